//! References for motions on a flexible disc, found without the monitors of the criterion.
//!
//! A motion is simulated with steps a quarter of those in use, whose errors are 256 times smaller, for longer and
//! longer times. Its last quarter is summarised: how far x swings, and how much of the time pad and disc stick.
//!
//! | the last quarters | reference |
//! |---|---|
//! | of the equilibrium's own eigenvalues one grows | unstable, whatever the start |
//! | else: the swing has died to 1e-4 of the first | stable |
//! | the swing is the same in two lengths to 1e-5, and so is the share of stick | unstable |
//! | sticks in three lengths, the last of them at least the horizon, and the swing differs by less than a hundredth | unstable |
//! | at the end: without sticking, the swing falls in each length, and as fast as before | stable |
//! | at the end: anything else | none |

use stickslip_core::model::verdict::Verdict;
use stickslip_core::models::pad_on_disc::criterion::settings::TimeDomainSettings;
use stickslip_core::models::pad_on_disc::criterion::time_domain::TimeDomain;
use stickslip_core::models::pad_on_disc::flexible_disc::brake::FlexibleBrake;
use stickslip_core::models::pad_on_disc::flexible_disc::linear_stability::LinearStability;
use stickslip_core::models::pad_on_disc::motion::start::Start;
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};
use stickslip_core::models::pad_on_disc::trajectory::sweep::sweep;

/// Lengths of the motions: to three times the horizon of the verdicts.
const LENGTHS: [f64; 7] = [60.0, 180.0, 540.0, 1620.0, 4860.0, 14_580.0, 30_000.0];

/// Steps are divided by this.
const DIVISOR: f64 = 4.0;

/// The swing that is rest, over the first.
const AT_REST: f64 = 1e-4;

/// Change of the swing between two lengths that is none: motions that still change, change more over a time three times
/// as long.
const SAME: f64 = 1e-5;

/// The same for stick-slip whose cycles differ, because the disc rings along.
const NEARLY_SAME: f64 = 1e-2;

/// The least rate at which a motion near steady sliding still shrinks, over the rate before.
const AS_FAST: f64 = 0.7;

/// E-foldings that growth near an unstable equilibrium is given to show in time.
const GROWTH: f64 = 25.0;

/// Longest time that is simulated for it.
const LONGEST_GROWTH: f64 = 2000.0;

/// The last quarter of a motion of some length.
#[derive(Debug, Clone, Copy)]
struct LastQuarter {
    length: f64,
    swing: f64,
    stick: f64,
}

/// Linear stability of one brake, and the scales of its motions.
pub struct Equilibrium {
    inputs: RandomInputs,
    /// x of steady sliding.
    x: f64,
    /// The amplitude of a motion as fast as the disc.
    driven: f64,
    /// Of the fastest growing or slowest shrinking mode.
    growth_rate: f64,
    stability: LinearStability,
}

impl Equilibrium {
    pub fn new(brake: &PadOnDisc, modes: usize, inputs: RandomInputs) -> Self {
        let flexible = FlexibleBrake::with_modes(brake.clone(), modes).expect("a random brake has a model");
        let x = flexible.sliding_equilibrium(inputs).expect("a random brake has an equilibrium")[0];
        let growth_rate = flexible.growth_rate(inputs).expect("it has eigenvalues");
        let stability = flexible.by_eigenvalues(inputs).expect("it has eigenvalues");
        let driven = brake.disc_speed() / (brake.tangential_stiffness() / brake.scaled_mass()).sqrt();
        Self { inputs, x, driven, growth_rate, stability }
    }

    /// The verdict on a motion, undecided where nothing shows; and whether motion and eigenvalues contradict each
    /// other.
    pub fn reference(&self, criterion: &TimeDomain, settings: &TimeDomainSettings) -> (Verdict, bool) {
        let near = settings.start == Start::NearEquilibrium;
        let displaced = self.x.abs() * if near { settings.displacement } else { 1.0 };
        // On a slow disc the first swing is a long stick, and what a cycle swings is far less.
        let first_swing = 2.0 * displaced.min(self.driven);
        let motion = Motion { criterion: criterion.clone().with_steps_divided_by(DIVISOR), first_swing };
        if self.stability == LinearStability::Stable {
            return (motion.fate(self.inputs), false);
        }
        let time_to_grow = GROWTH / self.growth_rate;
        let contradicted = near && time_to_grow < LONGEST_GROWTH && !motion.grows(self.inputs, time_to_grow);
        (Verdict::Unstable, contradicted)
    }
}

/// A motion whose last quarters are compared.
struct Motion {
    criterion: TimeDomain,
    first_swing: f64,
}

impl Motion {
    /// The last quarter of a motion of this length, unless it breaks down.
    fn last_quarter(&self, inputs: RandomInputs, length: f64) -> Option<LastQuarter> {
        let points = sweep(std::slice::from_ref(&self.criterion), inputs, length).ok()?;
        let point = points.first()?;
        Some(LastQuarter { length, swing: point.tangential_max - point.tangential_min, stick: point.stick_fraction })
    }

    fn grows(&self, inputs: RandomInputs, time: f64) -> bool {
        let quarter = self.last_quarter(inputs, time.max(LENGTHS[0]));
        quarter.is_some_and(|quarter| quarter.stick > 0.0 || quarter.swing > 3.0 * self.first_swing)
    }

    fn fate(&self, inputs: RandomInputs) -> Verdict {
        let mut quarters = Vec::new();
        for length in LENGTHS {
            let Some(quarter) = self.last_quarter(inputs, length) else { return Verdict::Undecided };
            quarters.push(quarter);
            if quarter.stick == 0.0 && quarter.swing < AT_REST * self.first_swing {
                return Verdict::Stable;
            }
            let persists = match quarters[..] {
                [.., b, c] if is_same(b, c, SAME) => true,
                [.., a, b, c] if length >= 10_000.0 && c.stick > 0.0 => {
                    is_same(a, c, NEARLY_SAME) && is_same(b, c, NEARLY_SAME)
                }
                _ => false,
            };
            if persists {
                return Verdict::Unstable;
            }
        }
        let [.., a, b, c] = quarters[..] else { return Verdict::Undecided };
        let shrinks = |from: LastQuarter, to: LastQuarter| libm::log(from.swing / to.swing) / (to.length - from.length);
        let slides = a.stick + b.stick + c.stick == 0.0;
        if slides && shrinks(a, b) > 0.0 && shrinks(b, c) > AS_FAST * shrinks(a, b) {
            Verdict::Stable
        } else {
            Verdict::Undecided
        }
    }
}

/// Whether two last quarters show the same motion.
fn is_same(one: LastQuarter, other: LastQuarter, same: f64) -> bool {
    // The share of stick is cut at the ends of the quarter, which are no whole number of cycles apart.
    let cut = same.max(20.0 / one.length);
    (one.swing - other.swing).abs() <= same * other.swing
        && (one.stick > 0.0) == (other.stick > 0.0)
        && (one.stick - other.stick).abs() <= cut * other.stick
}
