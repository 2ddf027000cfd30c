//! The validated model at one operating point: scales, steady sliding, and its linearisation.

use crate::friction::law::{FrictionLaw, LawKind};
use crate::models::pad_on_disc::parameters::{ParameterError, Parameters};
use crate::numerics::sine_cosine::SERIES_ANGLE;

/// The units of the scaled quantities, and the conversion to SI.
///
/// The paper measures lengths by the thickness h of the disc and time by
///
/// ```text
/// tau = sqrt(rho h^4 / D),      D = E h^3 / (12 (1 - nu^2)),      eta0 = 1 / tau^2
/// ```
///
/// **Dimension of tau.** With rho in kg/m^3, h in m and D in N m, `rho h^4 / D` is in s^2/m, so tau is a time over the
/// root of a length. A plate has the mass `rho h` per area, and its own time scale for a length L is
/// `sqrt(rho h L^4 / D)`, which for L = h is `tau sqrt(h)`. The paper takes the number tau, with all lengths in metres,
/// as a number of seconds.
///
/// **The conversion is exact nevertheless**, for pad and disc. Substitute t = tau t' in the equations in SI, with tau
/// as a number of seconds:
///
/// - Pad: `M x_tt` becomes `M eta0 x''`, and a damper becomes `c sqrt(eta0) x'`.
/// - Disc: `rho h w_tt + D nabla^4 w = p` becomes `w'' + (1/h) nabla^4 w = (h^2 / D) p`, with lengths over h. The
///   factor 1/h, the number of the thickness in metres, makes up for the missing root of a metre.
///
/// So a scaled frequency over tau is the frequency in hertz. A disc mode of frequency parameter lambda^2 has the scaled
/// angular frequency `lambda^2 h^(3/2) / b^2`, and over tau this is the textbook's
/// `(lambda^2 / b^2) sqrt(D / (rho h))`. With a true time scale, `tau sqrt(h)`, it would be `lambda^2 h^2 / b^2`.
///
/// The price is that scaled times, speeds and frequencies hold for lengths in metres only, and that those of discs of
/// different thickness cannot be compared. Seconds and hertz can.
///
/// Forces of the scaled equations are divided by h and carry N/m; see [`Scales::newtons`].
///
/// ```
/// use stickslip_core::models::pad_on_disc::parameters::Parameters;
/// use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;
/// let brake = PadOnDisc::new(Parameters::sui_ding_2018())?;
/// let frequency = brake.sliding_eigenvalues()[0].im / std::f64::consts::TAU;
/// assert!((frequency - 0.3327).abs() < 1e-4); // "Hz of scaled time"
/// assert!((brake.scales().hertz(frequency) - 3694.0).abs() < 1.0);
/// # Ok::<(), stickslip_core::models::pad_on_disc::parameters::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scales {
    /// Flexural rigidity D = E h^3 / (12 (1 - nu^2)), N m.
    pub flexural_rigidity: f64,
    /// Length scale h, m.
    pub length: f64,
    /// Time scale tau = sqrt(rho h^4 / D): one unit of scaled time, in seconds.
    pub time: f64,
    /// Speed scale h / tau = sqrt(D / (rho h^2)), m/s.
    pub speed: f64,
    /// eta0 = 1 / tau^2.
    pub eta0: f64,
}

impl Scales {
    fn new(parameters: &Parameters) -> Self {
        let disc = &parameters.disc;
        let h = disc.thickness;
        let flexural_rigidity =
            disc.youngs_modulus * h * h * h / (12.0 * (1.0 - disc.poissons_ratio * disc.poissons_ratio));
        let eta0 = flexural_rigidity / (disc.density * h * h * h * h);
        let time = 1.0 / eta0.sqrt();
        Self { flexural_rigidity, length: h, time, speed: h / time, eta0 }
    }

    /// A scaled time in s.
    #[must_use]
    pub fn seconds(&self, time: f64) -> f64 {
        time * self.time
    }

    /// A scaled length in m.
    #[must_use]
    pub fn metres(&self, length: f64) -> f64 {
        length * self.length
    }

    /// A scaled length in mm.
    #[must_use]
    pub fn millimetres(&self, length: f64) -> f64 {
        1e3 * self.metres(length)
    }

    /// A scaled speed in m/s.
    #[must_use]
    pub fn metres_per_second(&self, speed: f64) -> f64 {
        speed * self.speed
    }

    /// A scaled area in the plane of x and x', a length times a speed, in m^2/s.
    #[must_use]
    pub fn square_metres_per_second(&self, area: f64) -> f64 {
        area * self.length * self.speed
    }

    /// A rate for each unit of scaled time, such as the real part of an eigenvalue or an angular speed, in 1/s.
    #[must_use]
    pub fn per_second(&self, rate: f64) -> f64 {
        rate / self.time
    }

    /// A frequency in cycles for each unit of scaled time ("Hz of scaled time"), in Hz. Of a pair of eigenvalues
    /// `re +- i im` it is `im / (2 pi)`.
    #[must_use]
    pub fn hertz(&self, frequency: f64) -> f64 {
        frequency / self.time
    }

    /// A force of the scaled equations (N/m) in N: times h.
    #[must_use]
    pub fn newtons(&self, force: f64) -> f64 {
        force * self.length
    }
}

/// The two inputs that every sample has of its own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RandomInputs {
    /// Delta.
    pub preload: f64,
    /// f_s.
    pub static_friction: f64,
}

impl RandomInputs {
    /// Whether a sample is outside physics, and so on a rigid disc stable by definition: without preload there is no
    /// contact force, and below the least static friction coefficient friction rises with speed (`f_s < f_c`), or a measured
    /// curve has none at rest or in steady sliding. See [`FrictionLaw::least_static_coefficient`].
    #[inline]
    #[must_use]
    pub fn are_outside_physics(self, least_static_coefficient: f64) -> bool {
        // `|`, not `||`: loops over many samples have no branches then.
        (self.preload <= 0.0) | (self.static_friction < least_static_coefficient)
    }
}

/// Largest rotation of the pad in steady sliding, rad. The model holds for small angles: the tangent of this one is 2 %
/// larger. Lanes leave larger ones to scalar code.
pub const LARGEST_ROTATION: f64 = SERIES_ANGLE;

/// Steady sliding of the pad on a rigid disc: where pad and friction are in balance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlidingEquilibrium {
    /// x0, tangential displacement over h.
    pub tangential: f64,
    /// y0, normal displacement over h; negative, the contact is pressed together.
    pub normal: f64,
    /// phi0, rotation of the pad, rad.
    pub angle: f64,
    /// N, contact force over h, N/m.
    pub normal_force: f64,
    /// mu0, friction coefficient at the sliding speed.
    pub friction_coefficient: f64,
}

/// A damped oscillator `u'' + damping u' + stiffness u = 0` in scaled time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Oscillator {
    /// Coefficient of the velocity; negative where friction feeds the motion.
    pub damping: f64,
    /// Coefficient of the displacement, the square of the undamped angular frequency.
    pub stiffness: f64,
}

/// The pad-on-disc system at one operating point, validated.
///
/// Rigid disc, `sin(phi) = 0`, `cos(phi) = 1`, as in section 3.3 of the paper.
///
/// ```
/// use stickslip_core::models::pad_on_disc::parameters::Parameters;
/// use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;
/// let mut parameters = Parameters::sui_ding_2018();
/// parameters.set("operating_point.rotating_speed", 35.0)?;
/// let brake = PadOnDisc::new(parameters)?;
/// let equilibrium = brake.sliding_equilibrium();
/// assert!((equilibrium.tangential - 8.15e-3).abs() < 5e-6); // the paper's printed value
/// # Ok::<(), stickslip_core::models::pad_on_disc::parameters::ParameterError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct PadOnDisc {
    parameters: Parameters,
    scales: Scales,
    friction: FrictionLaw,
}

impl PadOnDisc {
    /// Validates `parameters`.
    ///
    /// # Errors
    /// The first [`ParameterError`] found.
    pub fn new(parameters: Parameters) -> Result<Self, ParameterError> {
        parameters.validate()?;
        Self::of_admissible(parameters)
    }

    /// For parameters that are admissible one by one and fit together.
    pub(in crate::models::pad_on_disc) fn of_admissible(parameters: Parameters) -> Result<Self, ParameterError> {
        let scales = Scales::new(&parameters);
        let law = &parameters.friction;
        let (f_s, f_c) = (law.static_coefficient, law.kinetic_coefficient);
        let stribeck_velocity = law.stribeck_velocity / scales.speed;
        let viscous = law.viscous * law.stribeck_velocity;
        let friction = match law.law {
            LawKind::Stribeck => {
                FrictionLaw::stribeck(f_s, f_c, stribeck_velocity, law.stribeck_exponent).with_additional(viscous)
            }
            LawKind::Rational => FrictionLaw::rational(f_s, f_c, stribeck_velocity).with_additional(viscous),
            LawKind::Table(curve) => FrictionLaw::table(curve, f_s, 1.0 / scales.speed).with_additional(law.band),
        };
        let brake = Self { parameters, scales, friction };
        brake.check_derived_values()?;
        Ok(brake)
    }

    /// The preset with some values changed, for tests.
    #[cfg(test)]
    pub(crate) fn preset_with(changes: &[(&str, f64)]) -> Self {
        let mut parameters = Parameters::sui_ding_2018();
        for (key, value) in changes {
            parameters.set(key, *value).unwrap();
        }
        Self::new(parameters).unwrap()
    }

    /// What is derived from the parameters and must be an ordinary positive number, with its name.
    pub(crate) fn derived_values(&self) -> [(&'static str, f64); 11] {
        [
            ("the flexural rigidity of the disc", self.scales.flexural_rigidity),
            ("the time scale", self.scales.time),
            ("the speed scale", self.scales.speed),
            ("eta0", self.scales.eta0),
            ("the scaled speed of the disc", self.disc_speed()),
            ("the speed scale of friction", self.friction.speed_scale),
            ("the contact force for one unit of preload", self.normal_force_per_preload()),
            ("k_t2 / k_t1", self.friction_transmission()),
            ("the tangential stiffness over the mass", self.tangential_oscillator().stiffness),
            ("the normal stiffness over the mass", self.normal_oscillator().stiffness),
            ("the angular stiffness over the inertia", self.angular_oscillator().stiffness),
        ]
    }

    /// Checks that everything derived is an ordinary positive number, so that no verdict rests on infinities.
    fn check_derived_values(&self) -> Result<(), ParameterError> {
        let derived = self.derived_values();
        if let Some(&(quantity, value)) = derived.iter().find(|(_, value)| !(value.is_normal() && *value > 0.0)) {
            return Err(ParameterError::NotComputable { quantity, value });
        }
        let damping = [
            ("the tangential damping over the mass", self.tangential_oscillator().damping),
            ("the normal damping over the mass", self.normal_oscillator().damping),
            ("the angular damping over the inertia", self.angular_oscillator().damping),
        ];
        match damping.iter().find(|(_, value)| !value.is_finite()) {
            Some(&(quantity, value)) => Err(ParameterError::NotComputable { quantity, value }),
            None => Ok(()),
        }
    }

    /// The parameters as validated.
    #[must_use]
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Length, time and speed scale.
    #[must_use]
    pub fn scales(&self) -> &Scales {
        &self.scales
    }

    /// The friction law over scaled speeds.
    #[must_use]
    pub fn friction_law(&self) -> &FrictionLaw {
        &self.friction
    }

    /// v, the scaled speed of the disc under the pad, `r_e Omega` over the speed scale.
    #[must_use]
    pub fn disc_speed(&self) -> f64 {
        self.parameters.effective_radius() * self.parameters.operating_point.rotating_speed / self.scales.speed
    }

    /// V = r_e Omega (m/s), the speed of the disc under the pad at a rotating speed Omega (rad/s): the sliding speed
    /// while the pad does not move.
    #[must_use]
    pub fn speed_under_pad(&self, rotating_speed: f64) -> f64 {
        self.parameters.effective_radius() * rotating_speed
    }

    /// The rotating speed (rad/s) at which the disc passes the pad with scaled speed `disc_speed`.
    #[must_use]
    pub fn rotating_speed(&self, disc_speed: f64) -> f64 {
        disc_speed * self.scales.speed / self.parameters.effective_radius()
    }

    /// The contact force over h that one unit of preload produces, `k_en k_y / (k_en + k_y)`, N/m.
    pub(crate) fn normal_force_per_preload(&self) -> f64 {
        self.parameters.stiffness.normal_in_series()
    }

    /// The contact force (N) of steady sliding on a rigid disc with this preload, `h Delta k_en k_y / (k_en + k_y)`.
    #[must_use]
    pub fn contact_force(&self, preload: f64) -> f64 {
        self.scales.newtons(self.normal_force_per_preload() * preload)
    }

    /// N, the contact force over h of steady sliding, N/m.
    pub(crate) fn normal_force(&self) -> f64 {
        self.normal_force_per_preload() * self.parameters.operating_point.preload
    }

    /// Whether a sample of this brake is outside physics, see [`RandomInputs::are_outside_physics`].
    #[must_use]
    pub fn is_outside_physics(&self, inputs: RandomInputs) -> bool {
        inputs.are_outside_physics(self.friction.least_static_coefficient(self.disc_speed()))
    }

    /// Whether a sample has a measured curve without friction at rest or in steady sliding: on any disc it is outside
    /// physics then.
    #[must_use]
    pub fn lacks_friction(&self, inputs: RandomInputs) -> bool {
        self.friction.is_table() && inputs.static_friction < self.friction.least_static_coefficient(self.disc_speed())
    }

    /// The ranges of sliding speed (m/s) at which the friction coefficient is at or below 0, in rising order.
    #[must_use]
    pub fn speeds_without_friction(&self) -> Vec<[f64; 2]> {
        let ranges = self.friction.without_friction().into_iter();
        ranges.map(|range| range.map(|speed| self.scales.metres_per_second(speed))).collect()
    }

    /// k_t2 / k_t1, the share of the friction force that reaches the pad.
    #[must_use]
    pub fn friction_transmission(&self) -> f64 {
        self.parameters.stiffness.contact_tangential_2 / self.parameters.stiffness.contact_tangential_1
    }

    /// a2 = k_x + k_t2, tangential stiffness that holds the pad, N/m.
    #[must_use]
    pub fn tangential_stiffness(&self) -> f64 {
        self.parameters.stiffness.calliper_tangential + self.parameters.stiffness.contact_tangential_2
    }

    /// c_x sqrt(eta0), the tangential damper over scaled time, N/m.
    #[must_use]
    pub fn scaled_tangential_damping(&self) -> f64 {
        self.parameters.damping.tangential * self.scales.eta0.sqrt()
    }

    /// M eta0, the mass over scaled time, N/m.
    #[must_use]
    pub fn scaled_mass(&self) -> f64 {
        self.parameters.pad.mass * self.scales.eta0
    }

    /// The force (N) that gives the pad this acceleration in scaled time.
    pub(crate) fn newtons(&self, acceleration: f64) -> f64 {
        acceleration * self.scaled_mass() * self.scales.length
    }

    /// The equilibrium of steady sliding on a rigid disc:
    ///
    /// ```text
    /// N = k_en k_y Delta / (k_en + k_y),   y0 = -k_y Delta / (k_en + k_y),   x0 = (k_t2 / k_t1) mu0 N / (k_x + k_t2),
    /// k_s phi0 = (q h / 2) k_t2 (mu0 N / k_t1 - x0)
    /// ```
    #[must_use]
    pub fn sliding_equilibrium(&self) -> SlidingEquilibrium {
        self.sliding_equilibrium_at(RandomInputs {
            preload: self.parameters.operating_point.preload,
            static_friction: self.parameters.friction.static_coefficient,
        })
    }

    /// [`PadOnDisc::sliding_equilibrium`] with other values of preload and static friction.
    pub(crate) fn sliding_equilibrium_at(&self, inputs: RandomInputs) -> SlidingEquilibrium {
        let Parameters { stiffness, pad, .. } = &self.parameters;
        let normal_force = self.normal_force_per_preload() * inputs.preload;
        let law = self.friction.with_static(inputs.static_friction);
        let friction_coefficient = law.coefficient(self.disc_speed());
        let friction_force = friction_coefficient * normal_force;
        let tangential = self.friction_transmission() * friction_force / self.tangential_stiffness();
        let normal =
            -stiffness.calliper_normal * inputs.preload / (stiffness.calliper_normal + stiffness.contact_normal);
        let contact_spring = friction_force / stiffness.contact_tangential_1 - tangential;
        let moment = 0.5 * pad.moment_arm * self.scales.length * stiffness.contact_tangential_2 * contact_spring;
        let angle = moment / stiffness.calliper_angular;
        SlidingEquilibrium { tangential, normal, angle, normal_force, friction_coefficient }
    }

    /// `(h q / 2) M / I_s`: angular acceleration for one unit of acceleration by the contact spring.
    pub(crate) fn angular_arm(&self) -> f64 {
        let pad = &self.parameters.pad;
        0.5 * pad.moment_arm * self.scales.length * pad.mass / pad.moment_of_inertia
    }

    /// The fall of the friction force with the sliding speed, `-(k_t2 / k_t1) N d mu / d v`, N/m: what friction takes
    /// away from the damping of the tangential motion.
    pub(super) fn friction_weakening_force(&self) -> f64 {
        let (law, v) = (&self.friction, self.disc_speed());
        let force = self.friction_transmission() * self.normal_force();
        force * law.falling() * law.weakening(v) - force * law.rise(v)
    }

    /// The tangential motion near steady sliding; its damping is `-m1` of the Jacobian, see
    /// [`PadOnDisc::jacobian`].
    pub(crate) fn tangential_oscillator(&self) -> Oscillator {
        Oscillator {
            damping: (self.scaled_tangential_damping() - self.friction_weakening_force()) / self.scaled_mass(),
            stiffness: self.tangential_stiffness() / self.scaled_mass(),
        }
    }

    /// The normal motion near steady sliding.
    pub(crate) fn normal_oscillator(&self) -> Oscillator {
        let Parameters { stiffness, damping, .. } = &self.parameters;
        Oscillator {
            damping: damping.normal * self.scales.eta0.sqrt() / self.scaled_mass(),
            stiffness: (stiffness.calliper_normal + stiffness.contact_normal) / self.scaled_mass(),
        }
    }

    /// The rotation of the pad near steady sliding.
    pub(crate) fn angular_oscillator(&self) -> Oscillator {
        let inertia = self.parameters.pad.moment_of_inertia * self.scales.eta0;
        Oscillator {
            damping: self.parameters.damping.angular * self.scales.eta0.sqrt() / inertia,
            stiffness: self.parameters.stiffness.calliper_angular / inertia,
        }
    }
}

/// The oscillator of Stender & Hoffmann (bSTAB, Nonlinear Dynamics 2021, doi 10.1007/s11071-021-06786-5):
/// x'' = -x - 0.1 x' + 0.5 + 0.5 exp(-(v - x') / 0.5) in slip; the disc's speed is the rotating speed.
#[cfg(test)]
pub(crate) fn bstab_with(changes: &[(&str, f64)]) -> PadOnDisc {
    let mut parameters = Parameters::sui_ding_2018();
    for (key, value) in [
        ("disc.density", 1000.0),
        ("disc.youngs_modulus", 12_000.0),
        ("disc.poissons_ratio", 0.0),
        ("disc.thickness", 1.0),
        ("disc.inner_radius", 0.25),
        ("disc.outer_radius", 1.0),
        ("pad.mass", 1.0),
        ("pad.moment_of_inertia", 1.0),
        ("pad.inner_radius", 0.5),
        ("pad.moment_arm", 0.0),
        ("stiffness.calliper_tangential", 0.5),
        ("stiffness.calliper_normal", 2.0),
        ("stiffness.calliper_angular", 1.0),
        ("stiffness.contact_normal", 2.0),
        ("stiffness.contact_tangential_1", 0.5),
        ("stiffness.contact_tangential_2", 0.5),
        ("damping.tangential", 0.1),
        ("damping.normal", 0.1),
        ("damping.angular", 0.1),
        ("friction.static_coefficient", 1.0),
        ("friction.kinetic_coefficient", 0.5),
        ("friction.stribeck_velocity", 0.5),
        ("friction.stribeck_exponent", 1.0),
        ("operating_point.preload", 1.0),
    ]
    .iter()
    .chain(changes)
    {
        parameters.set(key, *value).unwrap();
    }
    PadOnDisc::new(parameters).unwrap()
}

/// Numbers between 0 and 1 from a simple generator (Marsaglia's xorshift), for tests.
#[cfg(test)]
pub(crate) fn uniform_draws(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn friction_settles_around_a_quarter_at_35_rad_per_s() {
        // The paper, section 3.4: "the friction coefficient will be settled in a range around 0.25".
        let brake = PadOnDisc::preset_with(&[("operating_point.rotating_speed", 35.0)]);
        assert!((brake.sliding_equilibrium().friction_coefficient - 0.25).abs() < 5e-3);
    }
}
