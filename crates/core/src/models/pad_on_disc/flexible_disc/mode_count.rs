//! How many modes of the disc a model needs.
//!
//! A number of modes is compared with a larger one. It is enough if
//!
//! - the modes carry [`COMPLIANCE_SHARE`] of the disc's static compliance under the pad,
//! - the displacement x0 of steady sliding is within [`EQUILIBRIUM_TOLERANCE`], relative, and
//! - the growth rate has the same sign and is within [`GROWTH_TOLERANCE`] of the larger of its own size and the pad's
//!   damping rate `c_x sqrt(eta0) / (2 M eta0)`,
//!
//! at every given pair of inputs. The tolerance of the growth rate follows from what it is for: the growth rate of the
//! tangential motion is falling friction, in proportion to the preload, less the damping rate. An error of 5e-4 of the
//! damping rate moves the critical preload by 0.05 %, and the probability of instability of a cell with a standard
//! deviation of 20 % by 0.001 at most. The preset needs five modes.
//!
//! The larger number is [`MOST_DISC_MODES`], the most that a model may keep, where these are as good as all: where the
//! whole patch is in contact, and the compliance that they leave out changes the contact force by less than
//! [`LEFT_OUT`]. Elsewhere it is twice as many. x0 of brakes with preload 0.1 and f_s 0.39, relative to that of 128
//! modes:
//!
//! | disc | pad from | 24 modes | 48 modes | 96 modes |
//! |---|---|---|---|---|
//! | of the preset | 90 mm | 3.8e-6 | 6e-7 | 2e-8 |
//! | of the preset, 8 mm, 20 GPa | 90 mm | 1.4e-3 | 4e-4 | 5e-6 |
//! | radii 75 and 90 mm, 2 mm | 78 mm | 3.9e-3 | 1.2e-4 | 3e-6 |
//! | radii 64 and 90 mm, 2 mm | 70 mm | 2.5e-3 | 3e-4 | 6e-6 |
//! | radii 64 and 90 mm, 2 mm | 80 mm | 2.3e-3 | 7e-4 | 4e-5 |
//!
//! Some thin rings need more modes than a model may keep: then [`ModeStudy::check`] says how far off the most of them
//! are.

use std::fmt;

use crate::models::pad_on_disc::flexible_disc::brake::FlexibleBrake;
use crate::models::pad_on_disc::flexible_disc::compliance::{compliances, modes_below};
use crate::models::pad_on_disc::flexible_disc::error::FlexibleError;
use crate::models::pad_on_disc::flexible_disc::plate_modes::{MOST_DISC_MODES, MOST_REFERENCE_MODES, PlateMode};
use crate::models::pad_on_disc::pad::equations::PAD;
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};
use crate::numerics::sine_cosine::sine_and_cosine;

/// Share of the static compliance under the pad that the modes must carry.
pub const COMPLIANCE_SHARE: f64 = 0.99;

/// Relative error of x0.
pub const EQUILIBRIUM_TOLERANCE: f64 = 3e-3;

/// Error of the growth rate over the larger of its own size and the pad's damping rate.
pub const GROWTH_TOLERANCE: f64 = 5e-4;

/// Relative change of the contact force by the modes that are left out, up to which the others are as good as all.
pub const LEFT_OUT: f64 = 0.1 * GROWTH_TOLERANCE;

/// What a number of modes gives and what a larger one gives, at the inputs where they differ most.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModeCheck {
    /// The number of modes.
    pub count: usize,
    /// The number that it is compared with.
    pub reference: usize,
    /// Where they differ most.
    pub inputs: RandomInputs,
    /// The growth rates there, per unit of scaled time; not a number where the few modes have no equilibrium.
    pub growth_rate: f64,
    /// With the reference number.
    pub reference_growth_rate: f64,
    /// Their difference, over the larger of the reference's size and the pad's damping rate.
    pub growth_error: f64,
    /// Relative error of x0 there.
    pub equilibrium_error: f64,
    /// What the modes carry of the disc's static compliance under the pad.
    pub compliance_share: f64,
    /// Whether the number is enough, at all inputs.
    pub is_enough: bool,
}

impl fmt::Display for ModeCheck {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            formatter,
            "{} disc modes: growth rate {:+.6} where {} give {:+.6} (preload {}, static friction {}), x0 off by {:.1e}",
            self.count,
            self.growth_rate,
            self.reference,
            self.reference_growth_rate,
            self.inputs.preload,
            self.inputs.static_friction,
            self.equilibrium_error
        )
    }
}

/// The default inputs at which the numbers of modes are compared: the brake's static friction with its preload, a third
/// of it and three times of it. Without any preload, that of the preset.
#[must_use]
pub fn representative_inputs(brake: &PadOnDisc) -> Vec<RandomInputs> {
    let parameters = brake.parameters();
    let preload = parameters.operating_point.preload;
    let preload = if preload > 0.0 { preload } else { 0.1 };
    let static_friction = parameters.friction.static_coefficient;
    [1.0, 1.0 / 3.0, 3.0].map(|factor| RandomInputs { preload: factor * preload, static_friction }).to_vec()
}

/// A disc with many modes at some inputs: what fewer modes are compared with.
#[derive(Debug, Clone)]
pub struct ModeStudy {
    brake: PadOnDisc,
    modes: Vec<PlateMode>,
    /// What the first modes carry together, over the compliance of the disc.
    shares: Vec<f64>,
    /// How many modes the others are compared with.
    reference: usize,
    /// Growth rate and x0 at each pair of inputs that has an equilibrium.
    references: Vec<(RandomInputs, f64, f64)>,
}

impl ModeStudy {
    /// Prepares the comparison. Inputs at which the disc has no equilibrium are left out.
    ///
    /// # Errors
    /// [`FlexibleError`] if the disc has no computable modes, or no equilibrium at any of the inputs.
    pub fn new(brake: &PadOnDisc, inputs: &[RandomInputs]) -> Result<Self, FlexibleError> {
        let modes = modes_below(brake, MOST_REFERENCE_MODES as u32)?;
        let compliances = compliances(brake, &modes);
        let total: f64 = compliances.iter().sum();
        let mut carried = 0.0;
        let share = |compliance: &f64| {
            carried += compliance;
            carried / total
        };
        let shares: Vec<f64> = compliances.iter().map(share).collect();
        // The disc yields in series with pad and calliper: how much of all yielding is its own.
        let stiffness = &brake.parameters().stiffness;
        let pad = 1.0 / stiffness.contact_normal + 1.0 / stiffness.calliper_normal;
        let left_out = (1.0 - shares[MOST_DISC_MODES - 1]) * total / (total + pad);
        let most = FlexibleBrake::of_modes(brake.clone(), &modes[..MOST_DISC_MODES]);
        let suffice = left_out <= LEFT_OUT && inputs.iter().all(|&inputs| is_whole(&most, inputs));
        let reference = if suffice { MOST_DISC_MODES } else { MOST_REFERENCE_MODES };
        let all = if suffice { most } else { FlexibleBrake::of_modes(brake.clone(), &modes[..reference]) };
        let mut references = Vec::with_capacity(inputs.len());
        let mut refused = None;
        for &inputs in inputs {
            match sliding(&all, inputs) {
                Ok((growth_rate, x)) => references.push((inputs, growth_rate, x)),
                Err(error) => refused = refused.or(Some(error)),
            }
        }
        match refused {
            Some(error) if references.is_empty() => Err(error),
            _ => Ok(Self { brake: brake.clone(), modes, shares, reference, references }),
        }
    }

    /// How a number of modes compares with more of them.
    ///
    /// # Errors
    /// [`FlexibleError::ModeCount`] if there is no such number.
    pub fn check(&self, count: usize) -> Result<ModeCheck, FlexibleError> {
        if count == 0 || count > MOST_DISC_MODES {
            return Err(FlexibleError::ModeCount { count });
        }
        let few = FlexibleBrake::of_modes(self.brake.clone(), &self.modes[..count]);
        let damping_rate = 0.5 * self.brake.scaled_tangential_damping() / self.brake.scaled_mass();
        let compliance_share = self.shares[count - 1];
        let mut worst: Option<(f64, ModeCheck)> = None;
        let mut is_enough = compliance_share >= COMPLIANCE_SHARE;
        for &(inputs, exact, x0) in &self.references {
            let (growth_rate, x) = sliding(&few, inputs).unwrap_or((f64::NAN, f64::NAN));
            let growth_error = (growth_rate - exact).abs() / damping_rate.max(exact.abs());
            let equilibrium_error = (x / x0 - 1.0).abs();
            is_enough &= growth_error <= GROWTH_TOLERANCE
                && equilibrium_error <= EQUILIBRIUM_TOLERANCE
                && (growth_rate > 0.0) == (exact > 0.0);
            // A change of sign is worse than any error of the size; not a number is worst of all.
            let changes_sign = (growth_rate > 0.0) != (exact > 0.0);
            let error = (growth_error / GROWTH_TOLERANCE).max(equilibrium_error / EQUILIBRIUM_TOLERANCE);
            let error = if growth_rate.is_nan() { f64::INFINITY } else { error + f64::from(changes_sign) * 1e9 };
            if worst.is_none_or(|(worst, _)| error > worst) {
                let check = ModeCheck {
                    count,
                    reference: self.reference,
                    inputs,
                    growth_rate,
                    reference_growth_rate: exact,
                    growth_error,
                    equilibrium_error,
                    compliance_share,
                    is_enough,
                };
                worst = Some((error, check));
            }
        }
        match worst {
            Some((_, check)) => Ok(ModeCheck { is_enough, ..check }),
            None => Err(FlexibleError::NotPressed { preload: 0.0 }),
        }
    }

    /// The smallest number of modes that is enough, [`MOST_DISC_MODES`] if no smaller one is. Whether these are enough
    /// then, [`ModeStudy::check`] says.
    ///
    /// # Errors
    /// As [`ModeStudy::check`].
    pub fn smallest(&self) -> Result<usize, FlexibleError> {
        let stiff = self.shares.iter().take_while(|share| **share < COMPLIANCE_SHARE).count();
        for count in (stiff + 1)..MOST_DISC_MODES {
            if self.check(count)?.is_enough {
                return Ok(count);
            }
        }
        Ok(MOST_DISC_MODES)
    }
}

/// Growth rate and x0 of steady sliding.
fn sliding(brake: &FlexibleBrake, inputs: RandomInputs) -> Result<(f64, f64), FlexibleError> {
    Ok((brake.growth_rate(inputs)?, brake.sliding_equilibrium(inputs)?[0]))
}

/// Whether the whole patch is in contact in steady sliding.
fn is_whole(brake: &FlexibleBrake, inputs: RandomInputs) -> bool {
    let equations = &brake.equations;
    brake.sliding_equilibrium(inputs).is_ok_and(|q| {
        let position = equations.position(&q, sine_and_cosine(q[2]));
        equations.geometry.patch.contact_share(position, &q[PAD..]) > 1.0 - 1e-9
    })
}

impl FlexibleBrake {
    /// The model with the smallest number of modes that is enough at the [`representative_inputs`], or with the most
    /// that there may be; and how it compares with more of them.
    ///
    /// # Errors
    /// As [`ModeStudy::new`] and [`FlexibleBrake::with_modes`].
    pub fn with_enough_modes(brake: PadOnDisc) -> Result<(Self, ModeCheck), FlexibleError> {
        let study = ModeStudy::new(&brake, &representative_inputs(&brake))?;
        let check = study.check(study.smallest()?)?;
        Ok((Self::with_modes(brake, check.count)?, check))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::pad_on_disc::flexible_disc::brake::DISC_MODES;
    use crate::models::pad_on_disc::parameters::Parameters;
    use crate::models::pad_on_disc::rigid_disc::pad_on_disc::uniform_draws;

    /// A brake out of the study in the documentation of [`crate::models::pad_on_disc::flexible_disc::brake`].
    fn random_brake(draw: &mut impl FnMut() -> f64) -> PadOnDisc {
        let mut between = |from: f64, to: f64| from + (to - from) * draw();
        let kinetic = between(0.1, 0.4);
        PadOnDisc::preset_with(&[
            ("friction.kinetic_coefficient", kinetic),
            ("friction.static_coefficient", kinetic * between(1.0, 2.0)),
            ("friction.stribeck_velocity", between(0.2, 3.0)),
            ("stiffness.contact_normal", 3.816e7 * 0.3 * libm::pow(10.0, between(0.0, 1.0))),
            ("disc.youngs_modulus", between(2e10, 2.1e11)),
            ("disc.thickness", between(0.008, 0.03)),
            ("disc.transverse_damping_ratio", between(0.002, 0.05)),
            ("operating_point.preload", between(0.02, 0.3)),
            ("operating_point.rotating_speed", between(5.0, 40.0)),
        ])
    }

    #[test]
    #[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
    fn the_preset_needs_five_modes_at_every_speed() {
        for speed in [5.0, 10.0, 15.4, 16.0, 20.0, 35.0] {
            for preload in [0.01, 0.1, 0.3] {
                let changes = [("operating_point.rotating_speed", speed), ("operating_point.preload", preload)];
                let brake = PadOnDisc::preset_with(&changes);
                let study = ModeStudy::new(&brake, &representative_inputs(&brake)).unwrap();
                assert_eq!(study.smallest().unwrap(), DISC_MODES, "{speed} {preload}: {}", study.check(5).unwrap());
            }
        }
    }

    /// A disc of 2 mm with these radii, m, and the pad's.
    fn ring(inner: f64, outer: f64, pad: f64, changes: &[(&str, f64)]) -> PadOnDisc {
        let mut parameters = Parameters::sui_ding_2018();
        parameters.disc.thickness = 0.002;
        (parameters.disc.inner_radius, parameters.disc.outer_radius) = (inner, outer);
        parameters.pad.inner_radius = pad;
        for (key, value) in changes {
            parameters.set(key, *value).unwrap();
        }
        PadOnDisc::new(parameters).unwrap()
    }

    #[test]
    #[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
    fn where_the_most_modes_are_too_few_it_is_said() {
        let brake = ring(0.075, 0.090, 0.078, &[]);
        let (flexible, check) = FlexibleBrake::with_enough_modes(brake.clone()).unwrap();
        assert_eq!((flexible.modes(), check.count, check.reference), (MOST_DISC_MODES, MOST_DISC_MODES, 48));
        assert!(!check.is_enough && check.equilibrium_error > EQUILIBRIUM_TOLERANCE, "{check}");
        // Twice the modes of the reference say as much: 0.0069214 with 96 and 128 modes, 0.0069482 with 24.
        let inputs = RandomInputs { preload: 0.1, static_friction: 0.39 };
        let study = ModeStudy::new(&brake, &[inputs]).unwrap();
        let error = study.check(MOST_DISC_MODES).unwrap().equilibrium_error;
        assert!((error / (0.0069482 / 0.0069214 - 1.0) - 1.0).abs() < 0.05, "{error}");
        // The preset is as good with 24.
        let (_, check) = FlexibleBrake::with_enough_modes(PadOnDisc::preset_with(&[])).unwrap();
        assert!(check.is_enough && check.reference == MOST_DISC_MODES, "{check}");
    }

    #[test]
    fn enough_modes_give_the_growth_rate_of_the_largest_number() {
        let mut draw = uniform_draws(11);
        for _ in 0..6 {
            let brake = random_brake(&mut draw);
            let study = ModeStudy::new(&brake, &representative_inputs(&brake)).unwrap();
            let count = study.smallest().unwrap();
            let check = study.check(count).unwrap();
            assert!(check.is_enough || count == MOST_DISC_MODES, "{check}");
            assert!(count >= DISC_MODES && (check.growth_rate > 0.0) == (check.reference_growth_rate > 0.0), "{check}");
        }
    }
}
