//! Random brakes with a flexible disc, around the preset and around their own boundaries.

use std::ops::RangeInclusive;

use stickslip_core::models::pad_on_disc::flexible_disc::brake::DISC_MODES;
use stickslip_core::models::pad_on_disc::flexible_disc::brake::FlexibleBrake;
use stickslip_core::models::pad_on_disc::flexible_disc::error::FlexibleError;
use stickslip_core::models::pad_on_disc::motion::start::Start;
use stickslip_core::models::pad_on_disc::parameters::Parameters;
use stickslip_core::models::pad_on_disc::parameters::SCALARS;
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;

/// v / v_s. On slower discs a pad sticks for longer than the horizon before anything happens.
const SPEED_RATIOS: RangeInclusive<f64> = 1e-3..=1e3;

/// Deviates of a brake: xorshift64*, seeded by its index through splitmix64.
struct Deviates(u64);

impl Deviates {
    fn for_brake(index: usize) -> Self {
        let mut z = (index as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        Self((z ^ (z >> 31)) | 1)
    }

    /// Evenly between 0 and 1.
    fn share(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.share()
    }

    /// Evenly on a logarithmic scale.
    fn around(&mut self, low: f64, high: f64) -> f64 {
        low * libm::exp(self.share() * libm::log(high / low))
    }

    fn one_of<const N: usize>(&mut self, values: [f64; N]) -> f64 {
        values[((self.share() * N as f64) as usize).min(N - 1)]
    }
}

/// The brake of this index, and how many disc modes carry enough of its disc's compliance.
pub fn random_brake(index: usize) -> (PadOnDisc, usize) {
    let mut deviates = Deviates::for_brake(index);
    loop {
        let mut parameters = random_parameters(&mut deviates);
        let resting = PadOnDisc::new(parameters.clone()).expect("every value is within its limits");
        parameters.operating_point.rotating_speed = random_speed(&resting, &mut deviates);
        if !(SPEED_RATIOS.contains(&(parameters.operating_point.rotating_speed / stribeck_speed(&resting)))) {
            continue;
        }
        let brake = PadOnDisc::new(parameters).expect("every value is within its limits");
        // A disc whose modes are all too stiff, or that has no equilibrium, is drawn again.
        match FlexibleBrake::with_modes(brake.clone(), DISC_MODES) {
            Ok(_) => return (brake, DISC_MODES),
            Err(FlexibleError::TooFewModes { needed, .. })
                if FlexibleBrake::with_modes(brake.clone(), needed).is_ok() =>
            {
                return (brake, needed);
            }
            Err(_) => {}
        }
    }
}

fn random_parameters(deviates: &mut Deviates) -> Parameters {
    let mut parameters = Parameters::sui_ding_2018();
    parameters.disc.youngs_modulus = deviates.around(2e10, 2.1e11);
    parameters.disc.thickness = deviates.around(0.008, 0.03);
    parameters.disc.transverse_damping_ratio = deviates.around(0.002, 0.05);
    let stiffness = &mut parameters.stiffness;
    let springs = [
        &mut stiffness.calliper_tangential,
        &mut stiffness.calliper_normal,
        &mut stiffness.calliper_angular,
        &mut stiffness.contact_normal,
        &mut stiffness.contact_tangential_1,
        &mut stiffness.contact_tangential_2,
    ];
    for spring in springs {
        *spring *= deviates.around(0.3, 3.0);
    }
    parameters.damping.normal *= deviates.around(0.3, 3.0);
    parameters.damping.angular *= deviates.around(0.3, 3.0);
    let tangential = parameters.stiffness.calliper_tangential + parameters.stiffness.contact_tangential_2;
    let critical_damping = 2.0 * (tangential * parameters.pad.mass).sqrt();
    parameters.damping.tangential = critical_damping * deviates.around(0.003, 0.3);
    let friction = &mut parameters.friction;
    friction.stribeck_velocity = deviates.around(0.05, 3.0);
    friction.stribeck_exponent = deviates.one_of([0.5, 0.7, 1.0, 1.5, 2.0, 3.0]);
    friction.kinetic_coefficient = deviates.between(0.1, 0.4);
    friction.static_coefficient = friction.kinetic_coefficient * deviates.between(1.0, 2.5);
    parameters.operating_point.preload = deviates.around(0.02, 0.3);
    parameters
}

/// A speed near one of the boundaries, the nearer the likelier, from a third to three times of it; near the Stribeck
/// velocity where there is no boundary.
fn random_speed(brake: &PadOnDisc, deviates: &mut Deviates) -> f64 {
    let linear = brake.unstable_speeds().pop();
    let share = deviates.share();
    let boundary = match linear {
        Some(range) if share < 0.1 && range.from > 0.0 => Some(range.from),
        Some(range) if share < 0.5 => Some(range.to),
        _ => brake.saddle_node_speed(),
    };
    let offset = deviates.between(-1.0, 1.0);
    let factor = libm::exp(libm::log(3.0) * offset * offset * offset);
    boundary.filter(|speed| speed.is_finite()).unwrap_or_else(|| stribeck_speed(brake)) * factor
}

/// The rotating speed at which the disc passes the pad with the Stribeck velocity, rad/s.
fn stribeck_speed(brake: &PadOnDisc) -> f64 {
    brake.rotating_speed(brake.friction_law().speed_scale)
}

/// The options of `stickslip trajectory` for a case.
pub fn description(brake: &PadOnDisc, modes: usize, start: Start) -> String {
    let (parameters, preset) = (brake.parameters(), Parameters::sui_ding_2018());
    let changed = SCALARS.iter().filter(|scalar| scalar.value(parameters) != scalar.value(&preset));
    let changes: Vec<String> =
        changed.map(|scalar| format!("--set {}={}", scalar.key, scalar.value(parameters))).collect();
    format!("{start:?}, {modes} modes, {}", changes.join(" "))
}
