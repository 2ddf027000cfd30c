//! How many modes of the disc a model needs.
//!
//! A number of modes is compared with [`MOST_DISC_MODES`], the largest number there is. It is enough if
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

use std::fmt;

use crate::models::pad_on_disc::flexible_disc::brake::FlexibleBrake;
use crate::models::pad_on_disc::flexible_disc::compliance::{lowest_modes, relative_compliances};
use crate::models::pad_on_disc::flexible_disc::error::FlexibleError;
use crate::models::pad_on_disc::flexible_disc::plate_modes::{MOST_DISC_MODES, PlateMode};
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};

/// Share of the static compliance under the pad that the modes must carry.
pub const COMPLIANCE_SHARE: f64 = 0.99;

/// Relative error of x0.
pub const EQUILIBRIUM_TOLERANCE: f64 = 3e-3;

/// Error of the growth rate over the larger of its own size and the pad's damping rate.
pub const GROWTH_TOLERANCE: f64 = 5e-4;

/// What a number of modes gives and what the largest number gives, at the inputs where they differ most.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModeCheck {
    /// The number of modes.
    pub count: usize,
    /// The number that it is compared with, [`MOST_DISC_MODES`].
    pub reference: usize,
    /// Where they differ most.
    pub inputs: RandomInputs,
    /// The growth rates there, per unit of scaled time; not a number where the few modes have no equilibrium.
    pub growth_rate: f64,
    /// With the reference number.
    pub reference_growth_rate: f64,
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

/// A disc with all its modes at some inputs: what fewer modes are compared with.
#[derive(Debug, Clone)]
pub struct ModeStudy {
    brake: PadOnDisc,
    modes: Vec<PlateMode>,
    /// What the first modes carry together, over the compliance of the disc.
    shares: Vec<f64>,
    /// Growth rate and x0 at each pair of inputs that has an equilibrium.
    references: Vec<(RandomInputs, f64, f64)>,
}

impl ModeStudy {
    /// Prepares the comparison. Inputs at which the disc has no equilibrium are left out.
    ///
    /// # Errors
    /// [`FlexibleError`] if the disc has no computable modes, or no equilibrium at any of the inputs.
    pub fn new(brake: &PadOnDisc, inputs: &[RandomInputs]) -> Result<Self, FlexibleError> {
        let modes = lowest_modes(brake)?;
        let compliances = relative_compliances(brake, &modes);
        let total: f64 = compliances.iter().sum();
        let mut carried = 0.0;
        let share = |compliance: &f64| {
            carried += compliance;
            carried / total
        };
        let shares = compliances.iter().map(share).collect();
        let all = FlexibleBrake::of_modes(brake.clone(), &modes[..MOST_DISC_MODES]);
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
            _ => Ok(Self { brake: brake.clone(), modes, shares, references }),
        }
    }

    /// How a number of modes compares with all of them.
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
                    reference: MOST_DISC_MODES,
                    inputs,
                    growth_rate,
                    reference_growth_rate: exact,
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

    /// The smallest number of modes that is enough, [`MOST_DISC_MODES`] if no smaller one is.
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

impl FlexibleBrake {
    /// The model with the smallest number of modes that is enough at the [`representative_inputs`].
    ///
    /// # Errors
    /// As [`ModeStudy::new`] and [`FlexibleBrake::with_modes`].
    pub fn with_enough_modes(brake: PadOnDisc) -> Result<Self, FlexibleError> {
        let count = ModeStudy::new(&brake, &representative_inputs(&brake))?.smallest()?;
        Self::with_modes(brake, count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::pad_on_disc::flexible_disc::brake::DISC_MODES;
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
