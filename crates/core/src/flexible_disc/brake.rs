//! Pad and flexible disc together: the equations of motion.
//!
//! The disc is a few modes of the annular plate in the space-fixed frame, `w = sum of a_k psi_k`, with cosine and sine
//! shapes. With `mu s` the friction coefficient with its direction (in stick: the friction that is needed over the
//! pressure), `P = k_en <g+>` and `F = mu s P`, all forces divided by h:
//!
//! ```text
//! M eta0 x''     + c_x sqrt(eta0) x'     + k_x x + P sin(phi) + S cos(phi)           = 0,    S = k_t2 (x - F / k_t1)
//! M eta0 y''     + c_y sqrt(eta0) y'     + k_y (Delta + y) - P cos(phi) + S sin(phi) = 0
//! I_s eta0 phi'' + c_s sqrt(eta0) phi'   + k_s phi + S h q / 2                       = 0
//! c'' + eta1 c' + 2 Om n s' + (omega^2 - n^2 Om^2) c = -(h^3 k_en / (D m)) (<psi_c g+> + mu s <psi_c g+ w_theta / r>)
//! s'' + eta1 s' - 2 Om n c' + (omega^2 - n^2 Om^2) s = -(h^3 k_en / (D m)) (<psi_s g+> + mu s <psi_s g+ w_theta / r>)
//! ```
//!
//! (the paper's equation 2.5; `m` is the integral of `psi^2` over the disc, `Om = Omega tau`, `eta1 = 2 zeta omega_1`.)
//! The paper writes the sign of the sliding speed before the whole of S. A contact spring that turns into its opposite
//! when the pad overtakes the disc has no state of stick to return to; here friction alone changes its direction, which
//! is the same thing in all motion with `x' <= v`.
//!
//! # How many modes
//!
//! 60 random brakes, each with its own preload, a third and three times of it, compared with 24 modes (E 2e10 to 2.1e11 Pa,
//! h 8 to 30 mm, preload 0.02 to 0.3, zeta 0.002 to 0.05, contact stiffness 0.3 to 3 times that of the preset, 5 to 40 rad/s,
//! v_s 0.2 to 3 m/s, f_c 0.1 to 0.4, f_s up to twice that):
//!
//! | modes | other sign of the growth rate | largest difference | over the growth rate or 0.1 |
//! |---|---|---|---|
//! | 5 | 0 of 180 | 0.13 | 5.7 % |
//! | as [`crate::flexible_disc::mode_count`] finds, 5 to 14 | 0 of 180 | 0.007 | 0.14 % |
//! | 16 | 0 of 180 | 0.002 | 0.02 % |
//!
//! Five modes were not enough at 46 of the 180 points. A sign changes only close to the boundary; what a difference of the
//! growth rate means there is said in [`crate::flexible_disc::mode_count`].

use nalgebra::DMatrix;
use thiserror::Error;

use crate::criterion::time_domain::SettingsError;
use crate::flexible_disc::contact::{ContactLoads, ContactPatch, PadPosition, sufficient_points};
use crate::flexible_disc::linear_stability::CriticalProducts;
use crate::flexible_disc::plate_modes::{MOST_DISC_MODES, PlateMode, gauss_legendre};
use crate::friction::decay;
use crate::numerics::eigenvalues::EigenvalueError;
use crate::parameters::ParameterError;
use crate::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};

/// Disc modes that the preset needs, those with 0 to 4 nodal diameters and no nodal circle. Other brakes may need more:
/// see [`crate::flexible_disc::mode_count`].
pub const DISC_MODES: usize = 5;

/// Share of the static compliance under the pad that the kept modes must carry.
const LEAST_COMPLIANCE: f64 = 0.9;

/// Points along the radius of the pad for the mean shape of a mode.
const COMPLIANCE_POINTS: usize = 24;

/// x, y and phi come before the amplitudes of the disc.
pub(crate) const PAD: usize = 3;

/// Why there is no flexible model, or no equilibrium of it.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum FlexibleError {
    /// The disc as a plate could not be computed.
    #[error("the modes of the disc: {0}")]
    Modes(#[from] EigenvalueError),
    /// Values that contradict each other.
    #[error(transparent)]
    Parameters(#[from] ParameterError),
    /// A number of modes that is not available.
    #[error("{count} disc modes: there must be at least 1 and at most {MOST_DISC_MODES}")]
    ModeCount {
        /// As asked for.
        count: usize,
    },
    /// The kept modes are too stiff: the disc would be nearly rigid.
    #[error(
        "{count} disc modes carry only {:.0} % of the disc's compliance under the pad; at least {:.0} % are needed, with this disc {needed} modes",
        100.0 * .share, 100.0 * LEAST_COMPLIANCE
    )]
    TooFewModes {
        /// As asked for.
        count: usize,
        /// What they carry.
        share: f64,
        /// How many would do; more than [`MOST_DISC_MODES`] if none.
        needed: usize,
    },
    /// How a motion is to be followed makes no sense.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// Nothing presses pad and disc together.
    #[error("there is no sliding equilibrium: preload {preload} does not press the pad on the disc")]
    NotPressed {
        /// The preload.
        preload: f64,
    },
    /// The search for the equilibrium did not end.
    #[error(
        "there is no sliding equilibrium near that of a rigid disc (preload {preload}, static friction {static_friction}): is the disc far too soft?"
    )]
    NoEquilibrium {
        /// The preload.
        preload: f64,
        /// The static friction coefficient.
        static_friction: f64,
    },
}

/// How pad and disc move against each other at the contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ContactState {
    /// The disc passes under the pad, `x' < v`.
    Slip,
    /// They move together, `x' = v`.
    Stick,
    /// The pad overtakes the disc, `x' > v`.
    Overtaking,
}

/// One amplitude of the disc: its equation and its partner, the other of cosine and sine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Amplitude {
    /// omega^2 - n^2 Om^2.
    pub stiffness: f64,
    /// 2 Om n, positive for the cosine and negative for the sine; 0 without partner.
    pub gyroscopic: f64,
    /// Index of the partner among the amplitudes, its own without one.
    pub partner: usize,
    /// h^3 k_en / (D m).
    pub compliance: f64,
}

/// Forces at the contact in one state, divided by the pad's mass over scaled time.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct ContactForces {
    /// P / (M eta0).
    pub pressure: f64,
    /// mu s: friction over pressure.
    pub friction_ratio: f64,
}

/// Pad and flexible disc at one rotating speed; preload and static friction are given sample by sample.
#[derive(Debug, Clone)]
pub struct FlexibleBrake {
    brake: PadOnDisc,
    modes: Vec<PlateMode>,
    pub(crate) patch: ContactPatch,
    pub(crate) amplitudes: Vec<Amplitude>,
    /// Everything of the pad's equations divided by its mass or inertia.
    pub(crate) pad: PadEquations,
    /// eta1.
    pub(crate) disc_damping: f64,
    /// Length of a step in time, and of the steps that friction asks for over what they are by default.
    pub(crate) step: f64,
    pub(crate) refinement: f64,
    /// Shapes of the cosine amplitudes at the outer edge, and a quarter of the way to it.
    pub(crate) shapes_at_edge: Vec<f64>,
    pub(crate) shapes_inside: Vec<f64>,
    /// Where linear stability is lost.
    pub(crate) critical_products: CriticalProducts,
    /// Of the linearised equations at the operating point, for the search of equilibria.
    pub(crate) approximate_inverse: DMatrix<f64>,
}

/// Coefficients of the pad's equations of motion, for scaled time and divided by `M eta0` or `I_s eta0`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PadEquations {
    pub tangential_damping: f64,
    pub tangential_stiffness: f64,
    pub contact_tangential: f64,
    pub normal_damping: f64,
    pub normal_stiffness: f64,
    pub angular_damping: f64,
    pub angular_stiffness: f64,
    /// (h q / 2) M / I_s: angular acceleration for one unit of S.
    pub arm: f64,
    /// k_en / M.
    pub pressure_gain: f64,
    /// k_t2 / k_t1.
    pub transmission: f64,
    /// v.
    pub disc_speed: f64,
    /// 1 / v_s.
    pub inverse_stribeck: f64,
    pub stribeck_exponent: f64,
    pub kinetic_friction: f64,
}

impl PadEquations {
    fn new(brake: &PadOnDisc) -> Self {
        let parameters = brake.parameters();
        let stiffness = &parameters.stiffness;
        let mass = brake.scaled_mass();
        let (normal, angular) = (brake.normal_oscillator(), brake.angular_oscillator());
        Self {
            tangential_damping: brake.scaled_tangential_damping() / mass,
            tangential_stiffness: stiffness.calliper_tangential / mass,
            contact_tangential: stiffness.contact_tangential_2 / mass,
            normal_damping: normal.damping,
            normal_stiffness: stiffness.calliper_normal / mass,
            angular_damping: angular.damping,
            angular_stiffness: angular.stiffness,
            arm: brake.angular_arm(),
            pressure_gain: stiffness.contact_normal / mass,
            transmission: brake.friction_transmission(),
            disc_speed: brake.disc_speed(),
            inverse_stribeck: 1.0 / brake.friction_law().stribeck_velocity,
            stribeck_exponent: brake.friction_law().exponent,
            kinetic_friction: brake.friction_law().kinetic_coefficient,
        }
    }

    /// The disc's speed times the natural frequency of the tangential motion.
    pub fn meeting_rate(&self) -> f64 {
        self.disc_speed * (self.tangential_stiffness + self.contact_tangential).sqrt()
    }

    /// The amplitude of an oscillation at the natural frequency of the tangential motion that is as fast as the disc.
    pub fn smallest_cycle(&self) -> f64 {
        self.disc_speed / (self.tangential_stiffness + self.contact_tangential).sqrt()
    }

    /// mu at a sliding speed, see [`decay`].
    #[inline(always)]
    pub fn friction_coefficient(&self, sliding_speed: f64, static_friction: f64) -> f64 {
        let decay = decay(sliding_speed * self.inverse_stribeck, self.stribeck_exponent);
        self.kinetic_friction + (static_friction - self.kinetic_friction) * decay
    }
}

/// Angles up to which the series of sine and cosine are exact to the last place.
pub(crate) const SERIES_ANGLE: f64 = 0.25;

/// Sine and cosine of the pad's angle: series for the small angles of a pad, `libm` beyond.
#[inline(always)]
pub(crate) fn sine_and_cosine(angle: f64) -> (f64, f64) {
    if angle.abs() > SERIES_ANGLE {
        return (libm::sin(angle), libm::cos(angle));
    }
    small_sine_and_cosine(angle)
}

/// The series alone.
#[inline(always)]
pub(crate) fn small_sine_and_cosine(angle: f64) -> (f64, f64) {
    let s = angle * angle;
    let sine =
        ((((-1.0 / 39_916_800.0 * s + 1.0 / 362_880.0) * s - 1.0 / 5040.0) * s + 1.0 / 120.0) * s - 1.0 / 6.0) * s;
    let cosine = (((((1.0 / 479_001_600.0 * s - 1.0 / 3_628_800.0) * s + 1.0 / 40_320.0) * s - 1.0 / 720.0) * s
        + 1.0 / 24.0)
        * s
        - 0.5)
        * s;
    (angle + angle * sine, 1.0 + cosine)
}

impl FlexibleBrake {
    /// The model with [`DISC_MODES`] disc modes.
    ///
    /// # Errors
    /// [`FlexibleError`] if the disc has no computable modes, or if they are too stiff for it.
    pub fn new(brake: PadOnDisc) -> Result<Self, FlexibleError> {
        Self::with_modes(brake, DISC_MODES)
    }

    /// The model with the `count` disc modes of lowest frequency; a cosine and its sine count as one.
    ///
    /// # Errors
    /// As [`FlexibleBrake::new`], and if `count` is 0, more than [`MOST_DISC_MODES`], or too small to carry nine tenths of the disc's
    /// static compliance under the pad.
    pub fn with_modes(brake: PadOnDisc, count: usize) -> Result<Self, FlexibleError> {
        if count == 0 || count > MOST_DISC_MODES {
            return Err(FlexibleError::ModeCount { count });
        }
        let modes = lowest_modes(&brake)?;
        let compliances = compliances(&brake, &modes);
        let total: f64 = compliances.iter().sum();
        let share = |count: usize| compliances[..count].iter().sum::<f64>() / total;
        if share(count) < LEAST_COMPLIANCE {
            let needed = (1..=modes.len()).find(|&count| share(count) >= LEAST_COMPLIANCE);
            let needed = needed.unwrap_or(MOST_DISC_MODES + 1);
            return Err(FlexibleError::TooFewModes { count, share: share(count), needed });
        }
        Self::of_modes(brake, &modes[..count])
    }

    /// The model with these modes, however little of the compliance they carry.
    pub(crate) fn of_modes(brake: PadOnDisc, modes: &[PlateMode]) -> Result<Self, FlexibleError> {
        let mut flexible = Self::assemble(brake, modes);
        flexible.prepare()?;
        Ok(flexible)
    }

    pub(crate) fn assemble(brake: PadOnDisc, modes: &[PlateMode]) -> Self {
        let points = sufficient_points(brake.parameters(), modes);
        Self::assemble_with_points(brake, modes, points)
    }

    /// With a given number of points along the radius and along the angle of the patch.
    pub(crate) fn assemble_with_points(
        brake: PadOnDisc,
        modes: &[PlateMode],
        (radial, angular): (usize, usize),
    ) -> Self {
        let parameters = brake.parameters();
        let disc = &parameters.disc;
        let patch = ContactPatch::new(parameters, modes, radial, angular);
        let spin = parameters.operating_point.rotating_speed * brake.scales().time;
        let gain = disc.thickness * disc.thickness * disc.thickness * parameters.stiffness.contact_normal
            / brake.scales().flexural_rigidity;
        let amplitude = |mode: &PlateMode, partner: usize, direction: f64| {
            let n = f64::from(mode.nodal_diameters);
            let frequency = brake.disc_frequency(mode);
            let circle = if mode.nodal_diameters == 0 { 2.0 } else { 1.0 } * std::f64::consts::PI;
            Amplitude {
                stiffness: frequency * frequency - n * n * spin * spin,
                gyroscopic: direction * 2.0 * spin * n,
                partner,
                compliance: gain / (disc.outer_radius * disc.outer_radius * circle),
            }
        };
        let mut amplitudes = Vec::with_capacity(2 * modes.len());
        let mut odd = modes.len();
        for (index, mode) in modes.iter().enumerate() {
            let has_partner = mode.nodal_diameters > 0;
            amplitudes.push(amplitude(mode, if has_partner { odd } else { index }, 1.0));
            odd += usize::from(has_partner);
        }
        for (index, mode) in modes.iter().enumerate().filter(|(_, mode)| mode.nodal_diameters > 0) {
            amplitudes.push(amplitude(mode, index, -1.0));
        }
        let first = modes.iter().map(|mode| brake.disc_frequency(mode)).fold(f64::INFINITY, f64::min);
        let disc_damping = 2.0 * disc.transverse_damping_ratio * first;
        let clamped = disc.inner_radius / disc.outer_radius;
        let shapes_at = |r: f64| modes.iter().map(|mode| mode.shape(r)).collect();
        Self {
            patch,
            amplitudes,
            pad: PadEquations::new(&brake),
            disc_damping,
            shapes_at_edge: shapes_at(1.0),
            shapes_inside: shapes_at(clamped + 0.25 * (1.0 - clamped)),
            approximate_inverse: DMatrix::zeros(0, 0),
            critical_products: CriticalProducts::default(),
            step: f64::NAN,
            refinement: 1.0,
            modes: modes.to_vec(),
            brake,
        }
    }

    /// Finds the length of a step, and linearises at the operating point, or at the preset's preload where that has none.
    pub(crate) fn prepare(&mut self) -> Result<(), FlexibleError> {
        let operating_point = &self.brake.parameters().operating_point;
        let inputs = RandomInputs {
            preload: if operating_point.preload > 0.0 { operating_point.preload } else { 0.1 },
            static_friction: self.brake.parameters().friction.static_coefficient,
        };
        let at = self.equilibrium_on_rigid_disc(inputs);
        let (stiffness, _) = self.linearise(inputs, &at);
        let unsolvable =
            FlexibleError::NoEquilibrium { preload: inputs.preload, static_friction: inputs.static_friction };
        self.approximate_inverse = stiffness.try_inverse().ok_or(unsolvable)?;
        self.step = self.resolving_step();
        Ok(())
    }

    /// The pad and its operating point.
    #[must_use]
    pub fn brake(&self) -> &PadOnDisc {
        &self.brake
    }

    /// Modes of the disc that are kept; a cosine and its sine count as one.
    #[must_use]
    pub fn modes(&self) -> usize {
        self.modes.len()
    }

    /// Degrees of freedom: x, y, phi, the cosine amplitudes and the sine amplitudes of the disc.
    #[must_use]
    pub fn size(&self) -> usize {
        PAD + self.amplitudes.len()
    }

    /// What each mode adds to the static deflection of the disc under the pad, averaged over the patch, for a unit
    /// force that is spread evenly over it; m/N.
    #[must_use]
    pub fn compliances(&self) -> Vec<f64> {
        compliances(&self.brake, &self.modes)
    }

    /// The accelerations of all degrees of freedom, and the forces at the contact, at displacements `q` and speeds `u`.
    #[inline]
    pub(crate) fn accelerations(
        &self,
        inputs: RandomInputs,
        contact: ContactState,
        q: &[f64],
        u: &[f64],
        loads: &mut ContactLoads,
        accelerations: &mut [f64],
    ) -> ContactForces {
        let pad = &self.pad;
        let (sine, cosine) = sine_and_cosine(q[2]);
        let position = PadPosition { normal: q[1], tilt: sine / cosine };
        let amplitudes = &q[PAD..];
        if self.patch.is_surely_whole(position, amplitudes) {
            self.patch.loads_of_whole_patch(position, amplitudes, loads);
        } else {
            self.patch.loads_of_pressed_part(position, amplitudes, loads);
        }
        let pressure = pad.pressure_gain * loads.pressure;
        let pull = pad.tangential_damping * u[0] + pad.tangential_stiffness * q[0] + pressure * sine;
        let (spring, friction_ratio) = match contact {
            ContactState::Stick => {
                let spring = -pull / cosine;
                let friction = pad.contact_tangential * q[0] - spring;
                (
                    spring,
                    if pressure > 0.0 {
                        friction / (pad.transmission * pressure)
                    } else {
                        f64::INFINITY.copysign(friction)
                    },
                )
            }
            ContactState::Slip | ContactState::Overtaking => {
                let ratio = if contact == ContactState::Slip {
                    pad.friction_coefficient(pad.disc_speed - u[0], inputs.static_friction)
                } else {
                    -pad.friction_coefficient(u[0] - pad.disc_speed, inputs.static_friction)
                };
                (pad.contact_tangential * q[0] - pad.transmission * ratio * pressure, ratio)
            }
        };
        accelerations[0] = if contact == ContactState::Stick { 0.0 } else { -(pull + spring * cosine) };
        accelerations[1] = -(pad.normal_damping * u[1] + pad.normal_stiffness * (inputs.preload + q[1])
            - pressure * cosine
            + spring * sine);
        accelerations[2] = -(pad.angular_damping * u[2] + pad.angular_stiffness * q[2] + pad.arm * spring);
        // Without pressure there is no follower load, however large the ratio.
        let follower = if pressure > 0.0 { friction_ratio } else { 0.0 };
        for (k, amplitude) in self.amplitudes.iter().enumerate() {
            accelerations[PAD + k] = -(amplitude.stiffness * q[PAD + k]
                + self.disc_damping * u[PAD + k]
                + amplitude.gyroscopic * u[PAD + amplitude.partner])
                - amplitude.compliance * (loads.on_modes[k] + follower * loads.follower[k]);
        }
        ContactForces { pressure, friction_ratio }
    }
}

/// What modes add to the static deflection under the pad, see [`FlexibleBrake::compliances`]: `h^3 <psi>^2 / (D m omega^2)`,
/// at rest, without the centrifugal softening of the rotation.
pub(crate) fn compliances(brake: &PadOnDisc, modes: &[PlateMode]) -> Vec<f64> {
    let (disc, pad) = (&brake.parameters().disc, &brake.parameters().pad);
    let inner = pad.inner_radius / disc.outer_radius;
    let rule = gauss_legendre(COMPLIANCE_POINTS);
    let compliance = |mode: &PlateMode| {
        let angle = f64::from(mode.nodal_diameters) * pad.half_angle;
        let along_angle = if angle > 0.0 { libm::sin(angle) / angle } else { 1.0 };
        let along_radius = |&(s, weight): &(f64, f64)| {
            let r = 0.5 * ((1.0 + inner) + (1.0 - inner) * s);
            weight * r * mode.shape(r) / (1.0 + inner)
        };
        let mean = along_angle * rule.iter().map(along_radius).sum::<f64>();
        let frequency = brake.disc_frequency(mode);
        mean * mean * modal_gain(brake, mode) / (frequency * frequency)
    };
    modes.iter().map(compliance).collect()
}

/// h^3 / (D m), with m the integral of `psi^2` over the disc.
fn modal_gain(brake: &PadOnDisc, mode: &PlateMode) -> f64 {
    let disc = &brake.parameters().disc;
    let circle = if mode.nodal_diameters == 0 { 2.0 } else { 1.0 } * std::f64::consts::PI;
    let gain = disc.thickness * disc.thickness * disc.thickness / brake.scales().flexural_rigidity;
    gain / (disc.outer_radius * disc.outer_radius * circle)
}

/// The modes of lowest frequency, enough of them for every choice.
pub(crate) fn lowest_modes(brake: &PadOnDisc) -> Result<Vec<PlateMode>, FlexibleError> {
    let plate = brake.annular_plate();
    let mut modes = Vec::new();
    for nodal_diameters in 0..MOST_DISC_MODES as u32 {
        modes.extend(plate.modes(nodal_diameters, 4)?);
    }
    modes.sort_by(|a, b| a.frequency_parameter.total_cmp(&b.frequency_parameter));
    modes.truncate(4 * MOST_DISC_MODES);
    Ok(modes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_no_model_or_no_equilibrium_is_refused() {
        let brake = || PadOnDisc::preset_with(&[]);
        assert!(matches!(FlexibleBrake::with_modes(brake(), 0), Err(FlexibleError::ModeCount { count: 0 })));
        assert!(matches!(
            FlexibleBrake::with_modes(brake(), MOST_DISC_MODES + 1),
            Err(FlexibleError::ModeCount { .. })
        ));
        let few = FlexibleBrake::with_modes(brake(), 2).unwrap_err();
        assert!(matches!(few, FlexibleError::TooFewModes { needed: 4, .. }), "{few}");
        let flexible = FlexibleBrake::new(brake()).unwrap();
        for preload in [0.0, -0.1, f64::NAN] {
            let inputs = RandomInputs { preload, static_friction: 0.39 };
            assert!(matches!(flexible.sliding_equilibrium(inputs), Err(FlexibleError::NotPressed { .. })));
        }
        let inputs = RandomInputs { preload: 0.1, static_friction: 1e6 };
        assert!(matches!(flexible.sliding_equilibrium(inputs), Err(FlexibleError::NoEquilibrium { .. })));
    }

    #[test]
    fn sine_and_cosine_are_libms() {
        for i in -400..=400 {
            let angle = 1e-3 * f64::from(i);
            let (sine, cosine) = sine_and_cosine(angle);
            assert!((sine - libm::sin(angle)).abs() <= 1e-16 * (1.0 + angle.abs()), "{angle}");
            assert!((cosine - libm::cos(angle)).abs() <= 2.3e-16, "{angle}");
        }
    }
}
