//! What becomes of motions on a flexible disc, seen without any judge.
//!
//! A motion is followed with steps an eighth of those in use, for longer and longer, and its last quarter is looked at: how
//! far x swings, and how much of the time pad and disc stick.
//!
//! | the last quarters | reference |
//! |---|---|
//! | of the equilibrium's own eigenvalues one grows | unstable, whatever the start |
//! | else: the swing has died to 1e-4 of the first | stable |
//! | the swing and the share of stick are the same in three lengths of the motion, each three times the one before | unstable |
//! | at the end: sticks in the last three lengths | unstable |
//! | at the end: without sticking, the swing falls in each length, and as fast as before | stable |
//! | at the end: anything else | none |

use stickslip_core::{
    DiscModel, FlexibleBrake, LinearStability, PadOnDisc, RandomInputs, Start, TimeDomain, TimeDomainSettings, Verdict,
    sweep,
};

/// Horizon of the verdicts.
pub const HORIZON: f64 = 10_000.0;

/// Lengths of the motions.
const LENGTHS: [f64; 7] = [137.0, 411.0, 1234.0, 3704.0, 11_111.0, 33_333.0, 100_000.0];

/// Steps are divided by this.
const DIVISOR: f64 = 8.0;

/// The swing that is rest, over the first.
const AT_REST: f64 = 1e-4;

/// Change of swing and share of stick between two lengths that is none.
const SAME: f64 = 1e-5;

/// The least rate at which a motion near steady sliding still shrinks, over the rate before.
const AS_FAST: f64 = 0.7;

/// E-foldings that growth near an unstable equilibrium is given to show in time.
const GROWTH: f64 = 25.0;

/// The last quarter of a motion of some length.
#[derive(Debug, Clone, Copy)]
struct Look {
    length: f64,
    swing: f64,
    stick: f64,
}

/// The motions of one brake.
pub struct Motions<'a> {
    brake: &'a PadOnDisc,
    modes: usize,
    inputs: RandomInputs,
    /// x of steady sliding.
    equilibrium: f64,
    /// Of the fastest growing or slowest shrinking mode.
    growth_rate: f64,
    stability: LinearStability,
}

impl<'a> Motions<'a> {
    pub fn new(brake: &'a PadOnDisc, modes: usize) -> Self {
        let parameters = brake.parameters();
        let inputs = RandomInputs {
            preload: parameters.operating_point.preload,
            static_friction: parameters.friction.static_coefficient,
        };
        let flexible = FlexibleBrake::with_modes(brake.clone(), modes).expect("a random brake has a model");
        let equilibrium = flexible.sliding_equilibrium(inputs).expect("a random brake has an equilibrium")[0];
        let growth_rate = flexible.growth_rate(inputs).expect("it has eigenvalues");
        let stability = flexible.by_eigenvalues(inputs).expect("it has eigenvalues");
        Self { brake, modes, inputs, equilibrium, growth_rate, stability }
    }

    /// What becomes of a motion with this start, undecided where nothing shows; and whether motion and eigenvalues contradict
    /// each other.
    pub fn reference(&self, start: Start) -> (Verdict, bool) {
        if self.stability == LinearStability::Stable {
            return (self.by_motion(start), false);
        }
        (Verdict::Unstable, start == Start::NearEquilibrium && !self.grows())
    }

    /// Whether a motion from near an unstable equilibrium leaves it, if there is time enough to see it.
    fn grows(&self) -> bool {
        let length = GROWTH / self.growth_rate;
        if length > HORIZON {
            return true;
        }
        let look = self.look(Start::NearEquilibrium, length.max(LENGTHS[0]));
        look.is_some_and(|look| look.stick > 0.0 || look.swing > 3.0 * self.first_swing(Start::NearEquilibrium))
    }

    fn first_swing(&self, start: Start) -> f64 {
        let displacement = if start == Start::NearEquilibrium { self.settings(start).displacement } else { 1.0 };
        2.0 * displacement * self.equilibrium.abs()
    }

    fn settings(&self, start: Start) -> TimeDomainSettings {
        TimeDomainSettings { start, ..Default::default() }
    }

    /// The last quarter of a motion, unless it breaks down.
    fn look(&self, start: Start, length: f64) -> Option<Look> {
        let disc = DiscModel::Flexible { modes: self.modes };
        let criterion = TimeDomain::new(self.brake, &disc, self.settings(start)).expect("a random brake has a model");
        let points = sweep(&[criterion.with_steps_divided_by(DIVISOR)], self.inputs, length).ok()?;
        let point = points.first()?;
        Some(Look { length, swing: point.tangential_max - point.tangential_min, stick: point.stick_fraction })
    }

    fn by_motion(&self, start: Start) -> Verdict {
        let mut looks = Vec::new();
        for length in LENGTHS {
            let Some(look) = self.look(start, length) else { return Verdict::Undecided };
            looks.push(look);
            if look.stick == 0.0 && look.swing < AT_REST * self.first_swing(start) {
                return Verdict::Stable;
            }
            if let [.., a, b, c] = looks[..]
                && is_same(a, c)
                && is_same(b, c)
            {
                return Verdict::Unstable;
            }
        }
        let [.., a, b, c] = looks[..] else { return Verdict::Undecided };
        let shrinks = |from: Look, to: Look| libm::log(from.swing / to.swing) / (to.length - from.length);
        let sticks = looks.iter().skip(1).filter(|look| look.stick > 0.0).count();
        if a.stick > 0.0 && b.stick > 0.0 && c.stick > 0.0 {
            Verdict::Unstable
        } else if sticks == 0 && shrinks(a, b) > 0.0 && shrinks(b, c) > AS_FAST * shrinks(a, b) {
            Verdict::Stable
        } else {
            Verdict::Undecided
        }
    }
}

/// Whether two looks show the same motion, one that goes on.
fn is_same(one: Look, other: Look) -> bool {
    let swings = (one.swing - other.swing).abs() <= SAME * other.swing;
    // The share of stick is cut at the ends of the quarter, which are no whole number of cycles apart.
    let cut = 20.0 / one.length;
    swings && (one.stick > 0.0) == (other.stick > 0.0) && (one.stick - other.stick).abs() <= cut * other.stick
}
