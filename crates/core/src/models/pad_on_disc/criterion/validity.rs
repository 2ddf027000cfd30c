//! Over which brakes verdicts in time were tested, and how often they were wrong or missing.
//!
//! `make validity` repeats the first table and 20 of the random flexible brakes (some ten minutes on two cores), and
//! lists the cases one by one; `VALIDITY_BRAKES=196` in the environment takes those of the second table (some hours, as
//! single brakes take half an hour). A range contains its lower end.
//!
//! # Rigid disc
//!
//! 2400 verdicts with a horizon of 1e5 against independent return maps (tests/data/rigid-fates.csv,
//! rigid-fates-more.csv), 2000 of them drawn around the boundaries of the verdicts.
//!
//! | range | cases | wrong | undecided | share of both | no reference | changed by half steps |
//! |---|---|---|---|---|---|---|
//! | all | 2400 | 0 | 0 | 0.00 % | 0 | 0 |
//! | v / v_s 0.0001 to 0.001 | 24 | 0 | 0 | 0.00 % | 0 | 0 |
//! | v / v_s 0.001 to 0.01 | 40 | 0 | 0 | 0.00 % | 0 | 0 |
//! | v / v_s 0.01 to 0.1 | 128 | 0 | 0 | 0.00 % | 0 | 0 |
//! | v / v_s 0.1 to 1 | 326 | 0 | 0 | 0.00 % | 0 | 0 |
//! | v / v_s 1 to 10 | 784 | 0 | 0 | 0.00 % | 0 | 0 |
//! | v / v_s 10 to 100 | 709 | 0 | 0 | 0.00 % | 0 | 0 |
//! | v / v_s 100 and more | 389 | 0 | 0 | 0.00 % | 0 | 0 |
//! | exponent 0.5 to less than 1 | 658 | 0 | 0 | 0.00 % | 0 | 0 |
//! | exponent 1 | 356 | 0 | 0 | 0.00 % | 0 | 0 |
//! | exponent more than 1 to 2 | 890 | 0 | 0 | 0.00 % | 0 | 0 |
//! | exponent more than 2 to 3 | 496 | 0 | 0 | 0.00 % | 0 | 0 |
//! | the damping ratio of the tangential motion 0.001 to 0.01 | 813 | 0 | 0 | 0.00 % | 0 | 0 |
//! | the damping ratio of the tangential motion 0.01 to 0.1 | 956 | 0 | 0 | 0.00 % | 0 | 0 |
//! | the damping ratio of the tangential motion 0.1 to 0.5 | 631 | 0 | 0 | 0.00 % | 0 | 0 |
//! | f_s / f_c 1 to 1.01 | 221 | 0 | 0 | 0.00 % | 0 | 0 |
//! | f_s / f_c 1.01 to 1.1 | 298 | 0 | 0 | 0.00 % | 0 | 0 |
//! | f_s / f_c 1.1 to 1.5 | 424 | 0 | 0 | 0.00 % | 0 | 0 |
//! | f_s / f_c 1.5 to 2 | 471 | 0 | 0 | 0.00 % | 0 | 0 |
//! | f_s / f_c 2 to 3 | 986 | 0 | 0 | 0.00 % | 0 | 0 |
//! | start: near the equilibrium | 655 | 0 | 0 | 0.00 % | 0 | 0 |
//! | start: rest | 810 | 0 | 0 | 0.00 % | 0 | 0 |
//! | start: limit cycle | 935 | 0 | 0 | 0.00 % | 0 | 0 |
//!
//! # Flexible disc
//!
//! 585 verdicts on 195 random brakes (0 to 195 without 153, whose motions take too long), three starts each, with a
//! horizon of 10 000. The reference of a linearly unstable brake is its eigenvalues; else motions of the same equations with a
//! quarter of the step, up to three times the horizon, whose last quarters are compared.
//!
//! | range | cases | wrong | undecided | share of both | no reference | changed by half steps |
//! |---|---|---|---|---|---|---|
//! | all | 585 | 1 | 1 | 0.34 % | 2 | 1 |
//! | v / v_s 0.001 to 0.01 | 27 | 0 | 0 | 0.00 % | 0 | 0 |
//! | v / v_s 0.01 to 0.1 | 18 | 0 | 0 | 0.00 % | 0 | 0 |
//! | v / v_s 0.1 to 1 | 60 | 0 | 0 | 0.00 % | 0 | 0 |
//! | v / v_s 1 to 10 | 324 | 0 | 1 | 0.31 % | 2 | 0 |
//! | v / v_s 10 to 100 | 123 | 1 | 0 | 0.81 % | 0 | 1 |
//! | v / v_s 100 to 1000 | 33 | 0 | 0 | 0.00 % | 0 | 0 |
//! | exponent 0.5 to less than 1 | 162 | 1 | 0 | 0.62 % | 0 | 1 |
//! | exponent 1 | 126 | 0 | 0 | 0.00 % | 2 | 0 |
//! | exponent more than 1 to 2 | 192 | 0 | 1 | 0.52 % | 0 | 0 |
//! | exponent more than 2 to 3 | 105 | 0 | 0 | 0.00 % | 0 | 0 |
//! | the damping ratio of the tangential motion 0.001 to 0.01 | 156 | 0 | 1 | 0.64 % | 0 | 0 |
//! | the damping ratio of the tangential motion 0.01 to 0.1 | 291 | 1 | 0 | 0.34 % | 2 | 1 |
//! | the damping ratio of the tangential motion 0.1 to 0.5 | 138 | 0 | 0 | 0.00 % | 0 | 0 |
//! | f_s / f_c 1 to 1.01 | 3 | 0 | 0 | 0.00 % | 0 | 0 |
//! | f_s / f_c 1.01 to 1.1 | 30 | 0 | 0 | 0.00 % | 0 | 0 |
//! | f_s / f_c 1.1 to 1.5 | 129 | 0 | 0 | 0.00 % | 0 | 0 |
//! | f_s / f_c 1.5 to 2 | 213 | 1 | 0 | 0.47 % | 2 | 1 |
//! | f_s / f_c 2 to 3 | 210 | 0 | 1 | 0.48 % | 0 | 0 |
//! | start: near the equilibrium | 195 | 0 | 0 | 0.00 % | 0 | 0 |
//! | start: rest | 195 | 0 | 0 | 0.00 % | 1 | 0 |
//! | start: limit cycle | 195 | 1 | 1 | 1.03 % | 1 | 1 |
//!
//! The wrong verdict is that on brake 169. With the steps in use its stick-slip ends 1e-4 to 3e-4 above the brake's
//! speed, with steps half as long up to 1e-4 below it. The table is from before such motions were simulated again with
//! finer steps; the verdict is right since then. Of 300 verdicts on 100 further brakes (195 to 295 without 286) one was
//! wrong (248, from rest), and one undecided (213). Ringing of the disc kept stick-slip up for more cycles than counted as
//! persistent, although friction hardly falls there; the verdict is right since these cycles have to be steady.
//!
//! 64 motions of 32 further brakes, from rest and from the limit cycle, have references that share no code with this
//! crate (tests/data/flexible-fates.csv): no verdict is wrong, none undecided. x and its speed in the first swings, and
//! the settled cycles, are the same to 1e-4 with fine steps; to 1e-3 where the pad lifts off and the reference is less
//! accurate.
//!
//! # Outside the range
//!
//! [`uncovered`] lists the quantities of a brake that lie outside the ranges [`RIGID_DISC`] and [`FLEXIBLE_DISC`];
//! `stickslip check` and `stickslip submit` warn of them. A verdict there may be right, but it was not tested. Look at
//! single samples with `stickslip trajectory`, and compare the run with one of a tenfold horizon (`stickslip compare`).

use std::fmt;

use crate::friction::law::LawKind;
use crate::models::pad_on_disc::criterion::time_domain::DiscModel;
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;

/// A number without dimension on which verdicts in time depend.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// v / v_s, the disc's speed under the pad over the Stribeck velocity.
    SpeedRatio,
    /// delta, the Stribeck exponent.
    Exponent,
    /// c_x over the critical damping of the tangential motion, `2 sqrt((k_x + k_t2) M)`.
    DampingRatio,
    /// f_s / f_c.
    FrictionRatio,
}

impl Quantity {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::SpeedRatio, Self::Exponent, Self::DampingRatio, Self::FrictionRatio];

    /// Its value for a brake; infinite where it divides by nothing.
    #[must_use]
    pub fn value(self, brake: &PadOnDisc) -> f64 {
        let parameters = brake.parameters();
        let friction = &parameters.friction;
        match self {
            Self::SpeedRatio => brake.disc_speed() / brake.friction_law().speed_scale,
            Self::Exponent => friction.stribeck_exponent,
            Self::DampingRatio => {
                let critical = 2.0 * (brake.tangential_stiffness() * parameters.pad.mass).sqrt();
                parameters.damping.tangential / critical
            }
            Self::FrictionRatio if friction.static_coefficient == friction.kinetic_coefficient => 1.0,
            Self::FrictionRatio => friction.static_coefficient / friction.kinetic_coefficient,
        }
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::SpeedRatio => "v / v_s",
            Self::Exponent => "the Stribeck exponent",
            Self::DampingRatio => "the damping ratio of the tangential motion",
            Self::FrictionRatio => "f_s / f_c",
        })
    }
}

/// The range of a quantity over which verdicts were tested, both ends included.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Covered {
    /// Of what.
    pub quantity: Quantity,
    /// Lower end.
    pub from: f64,
    /// Upper end.
    pub to: f64,
}

const fn covered(quantity: Quantity, from: f64, to: f64) -> Covered {
    Covered { quantity, from, to }
}

/// With a rigid disc. Source: the smallest and largest values in tests/data/rigid-fates.csv and rigid-fates-more.csv,
/// rounded inwards.
pub const RIGID_DISC: [Covered; 4] = [
    covered(Quantity::SpeedRatio, 1e-4, 1e3),
    covered(Quantity::Exponent, 0.5, 3.0),
    covered(Quantity::DampingRatio, 1e-3, 0.5),
    covered(Quantity::FrictionRatio, 1.0, 3.0),
];

/// With a flexible disc. Source: what the random brakes of `make validity` are drawn from (benches/validity/brakes.rs);
/// of v / v_s the decades in the middle, where most of them lie.
pub const FLEXIBLE_DISC: [Covered; 4] = [
    covered(Quantity::SpeedRatio, 1e-2, 1e2),
    covered(Quantity::Exponent, 0.5, 3.0),
    covered(Quantity::DampingRatio, 3e-3, 0.3),
    covered(Quantity::FrictionRatio, 1.0, 2.5),
];

/// A quantity of a brake outside the range over which verdicts were tested.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Uncovered {
    /// The range.
    pub covered: Covered,
    /// The value of the brake.
    pub value: f64,
}

impl fmt::Display for Uncovered {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Covered { quantity, from, to } = self.covered;
        let (relation, limit) = if self.value < from { ("below", from) } else { ("above", to) };
        write!(f, "{quantity} = {:.4e} is {relation} {limit}", self.value)
    }
}

/// The quantities of a brake that lie outside the range over which verdicts on this disc were tested.
#[must_use]
pub fn uncovered(brake: &PadOnDisc, disc: &DiscModel) -> Vec<Uncovered> {
    let ranges = match disc {
        DiscModel::Rigid => RIGID_DISC,
        DiscModel::Flexible { .. } => FLEXIBLE_DISC,
    };
    // A value that was given as the limit may be a little more after a formula.
    let contains =
        |covered: &Covered, value: f64| value >= covered.from * (1.0 - 1e-9) && value <= covered.to * (1.0 + 1e-9);
    // The tested brakes have Stribeck's law. Other laws have other tests, and not all of these quantities.
    let has = |covered: &Covered| match (covered.quantity, brake.parameters().friction.law) {
        (Quantity::DampingRatio, _) | (_, LawKind::Stribeck) => true,
        (Quantity::Exponent, _) | (_, LawKind::Table(_)) => false,
        (Quantity::SpeedRatio | Quantity::FrictionRatio, LawKind::Rational) => true,
    };
    let values =
        ranges.into_iter().filter(has).map(|covered| Uncovered { covered, value: covered.quantity.value(brake) });
    values.filter(|found| !contains(&found.covered, found.value)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::pad_on_disc::parameters::Parameters;

    #[test]
    fn the_preset_is_covered_and_each_quantity_has_its_limits() {
        let flexible = DiscModel::Flexible { modes: 5 };
        for disc in [&DiscModel::Rigid, &flexible] {
            assert_eq!(uncovered(&PadOnDisc::preset_with(&[]), disc), []);
        }
        let stiffness = Parameters::sui_ding_2018().stiffness;
        let critical = 2.0 * ((stiffness.calliper_tangential + stiffness.contact_tangential_2) * 0.1).sqrt();
        for (key, inside, outside, quantity) in [
            ("operating_point.rotating_speed", 0.72e3 / 0.135, 0.73e3 / 0.135, Quantity::SpeedRatio),
            ("friction.stribeck_exponent", 0.5, 0.49, Quantity::Exponent),
            ("damping.tangential", 0.5 * critical, 0.0, Quantity::DampingRatio),
            ("friction.static_coefficient", 0.75, 0.76, Quantity::FrictionRatio),
        ] {
            assert_eq!(uncovered(&PadOnDisc::preset_with(&[(key, inside)]), &DiscModel::Rigid), [], "{key}");
            let found = uncovered(&PadOnDisc::preset_with(&[(key, outside)]), &DiscModel::Rigid);
            assert_eq!(found.iter().map(|found| found.covered.quantity).collect::<Vec<_>>(), [quantity]);
        }
        let frictionless = [("friction.static_coefficient", 0.0), ("friction.kinetic_coefficient", 0.0)];
        assert_eq!(uncovered(&PadOnDisc::preset_with(&frictionless), &flexible), []);
    }
}
