//! When a motion has shown what it will do.
//!
//! A verdict rests on what is told of the motion while it is followed: its turning points, whose distances are twice its
//! amplitude swing by swing, and the moments of sticking and release.
//!
//! * **Unstable**: the amplitude grows from swing to swing, by more than transients of the other degrees of freedom could
//!   feign; or stick-slip is reached and kept for several cycles.
//! * **Stable**: the amplitude shrinks from swing to swing, by more than transients could feign, and is no larger than
//!   the stated displacement from the equilibrium.
//! * **Stable** too: an overdamped motion that creeps towards the equilibrium without turning.
//! * **Undecided** when the horizon comes first, **failed** when the computation breaks down.
//!
//! On a rigid disc the tangential motion is a plane autonomous system: orbits do not cross, so once a swing is longer
//! than the one before, all later ones are longer still, and the first few swings decide for ever. With a flexible disc
//! the other degrees of freedom disturb the amplitude, but only as long as they ring: what they could feign is assumed to
//! be half of the amplitude that the motion had when it was let go, and to die away at the slowest of their damping rates.
//! It is an amplitude of its own: where the tangential motion dies away faster, what is left to see is their ringing, and
//! beats of it are no growth.

use crate::motion::Observer;
use crate::verdict::Verdict;

/// What can be feigned at any time: rounding and the interpolation of turning points.
const LEAST_CHANGE: f64 = 1e-4;

/// What transients can feign at first, relative to the amplitude at which the motion was let go.
const FEIGNED: f64 = 0.5;

/// The reference amplitude is taken anew when time has doubled, at first after this many units of scaled time.
const FIRST_REFERENCE: f64 = 20.0;

/// Swings after a release that may still end in stick again.
const FIRST_SWINGS: u32 = 3;

/// Stick-slip cycles in a row that count as kept: on a flexible disc, where the share of stick is large, and where it is
/// so small that a small disturbance could end it. On a rigid disc every release is the same, and one return suffices.
const KEPT: u32 = 6;
const KEPT_BARELY: u32 = 60;
const LARGE_SHARE: f64 = 0.05;

/// The settled amplitude of stick-slip is the mean over this many cycles on a flexible disc (on a rigid one all cycles are
/// the same), once two means in a row agree to [`SETTLED_CHANGE`]; a motion that goes on changing, as it may while the
/// disc rings along, is given its last mean after [`MOST_MEANS`] of them.
const CYCLES_OF_MEAN: u32 = 10;
const SETTLED_CHANGE: f64 = 1e-3;
const MOST_MEANS: u32 = 20;

/// Largest distance from the equilibrium, over x0, at which a shrinking motion counts as having come home, however large
/// the displacement: a limit cycle is wider.
const LARGEST_BASIN: f64 = 0.1;

/// Distance from the equilibrium, over x0, at which a motion that does not turn has arrived.
const ARRIVED: f64 = 1e-6;

/// Swings of constant amplitude after which a motion without stick counts as settled.
const SETTLED_SWINGS: u32 = 100;

/// How a motion is judged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rules {
    /// Scaled time after which a sample is undecided.
    pub horizon: f64,
    /// Slowest damping rate of the degrees of freedom that disturb the tangential motion; `None` if there are none.
    pub slowest_transient: Option<f64>,
    /// Whether an unstable motion is followed until its amplitude has settled.
    pub until_settled: bool,
}

/// What is known of one motion so far.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Judge {
    rules: Rules,
    /// x0.
    equilibrium: f64,
    /// Amplitude below which a shrinking motion has come home: the stated displacement.
    basin: f64,
    /// Distance from the equilibrium at the last look, unless the motion has turned or stuck since.
    last_distance: Option<f64>,
    verdict: Option<Verdict>,
    /// Known to be unstable, but followed further.
    grows: bool,
    last_turn: Option<f64>,
    amplitude: f64,
    /// When the motion was last let go, at the start or from stick, and the amplitude that the other degrees of freedom
    /// were excited with up to then; how many of the first swings since are still to come.
    let_go: f64,
    excitation: f64,
    first_swings: u32,
    reference: Option<Reference>,
    settled_swings: u32,
    /// Stick-slip cycles in a row.
    cycles: u32,
    swings_since_stick: u32,
    last_stick: f64,
    last_release: Option<f64>,
    stick_share: f64,
    /// Sum over the cycles of the mean in the making, their number, the means made, and the last of them.
    sum: f64,
    summed: u32,
    means: u32,
    mean: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Reference {
    amplitude: f64,
    time: f64,
    /// Relative change of the amplitude that is certainly none of the transients.
    change: f64,
}

impl Judge {
    /// For a motion about the equilibrium `x0`, with the stated displacement over x0, that starts at a turning point if it
    /// starts without speed.
    pub fn new(rules: Rules, equilibrium: f64, displacement: f64, starts_turning_at: Option<f64>) -> Self {
        Self {
            rules,
            equilibrium,
            basin: displacement.min(LARGEST_BASIN) * equilibrium.abs(),
            last_distance: None,
            verdict: None,
            grows: false,
            last_turn: starts_turning_at,
            amplitude: 0.0,
            let_go: 0.0,
            excitation: 0.0,
            first_swings: 1,
            reference: None,
            settled_swings: 0,
            cycles: 0,
            swings_since_stick: 0,
            last_stick: 0.0,
            last_release: None,
            stick_share: 0.0,
            sum: 0.0,
            summed: 0,
            means: 0,
            mean: 0.0,
        }
    }

    /// The verdict, once it is certain.
    pub fn verdict(&self) -> Option<Verdict> {
        self.verdict
    }

    /// Whether the motion is known to be unstable, settled or not.
    pub fn is_unstable(&self) -> bool {
        self.grows || self.verdict == Some(Verdict::Unstable)
    }

    /// Looks at the motion itself, from time to time: without turning points there are no swings to judge.
    pub fn looks(&mut self, x: f64) {
        let distance = (x - self.equilibrium).abs();
        if let Some(before) = self.last_distance
            && self.verdict.is_none()
            && !self.grows
            && self.cycles == 0
            && distance <= self.basin
            && (distance <= 0.5 * before || distance.max(before) <= ARRIVED * self.equilibrium.abs())
        {
            self.verdict = Some(Verdict::Stable);
        }
        self.last_distance = Some(distance);
    }

    /// The settled amplitude of stick-slip if it has one, or else half of the distance between the last two turning
    /// points.
    pub fn amplitude(&self) -> f64 {
        if self.means > 0 { self.mean } else { self.amplitude }
    }

    /// Adds a cycle of stick-slip to the mean of its amplitude; true once that has settled.
    fn add_cycle(&mut self) -> bool {
        let wanted = if self.rules.slowest_transient.is_some() { CYCLES_OF_MEAN } else { 1 };
        self.sum += self.amplitude;
        self.summed += 1;
        if self.summed < wanted {
            return false;
        }
        let mean = self.sum / f64::from(self.summed);
        let settled = self.means > 0 && (mean - self.mean).abs() <= SETTLED_CHANGE * mean;
        self.sum = 0.0;
        self.summed = 0;
        self.means += 1;
        self.mean = mean;
        settled || self.means >= MOST_MEANS
    }

    fn reference(&self, amplitude: f64, time: f64) -> Reference {
        let ringing = self.ringing(time);
        let feigned = if ringing > 0.0 { FEIGNED * ringing * (self.excitation / amplitude).max(1.0) } else { 0.0 };
        Reference { amplitude, time, change: LEAST_CHANGE + feigned }
    }

    /// What is left of transients since the motion was let go; none on a rigid disc.
    fn ringing(&self, time: f64) -> f64 {
        self.rules.slowest_transient.map_or(0.0, |rate| libm::exp(-rate * (time - self.let_go)))
    }

    /// The first swings since the motion was let go say how much the other degrees of freedom can have been excited; what
    /// still rings from before counts too.
    fn excites(&mut self) {
        if self.first_swings > 0 {
            self.first_swings -= 1;
            self.excitation = self.excitation.max(self.amplitude);
        }
    }

    fn becomes_unstable(&mut self) {
        if self.rules.until_settled {
            self.grows = true;
        } else {
            self.verdict = Some(Verdict::Unstable);
        }
    }

    /// A swing of a motion that does not stick.
    fn judge_swing(&mut self, time: f64) {
        let amplitude = self.amplitude;
        let Some(reference) = self.reference else {
            self.reference = Some(self.reference(amplitude, time));
            return;
        };
        let grown = amplitude > reference.amplitude * (1.0 + reference.change);
        let shrunk = amplitude * (1.0 + reference.change) < reference.amplitude;
        if shrunk && !self.grows && amplitude <= self.basin {
            self.verdict = Some(Verdict::Stable);
        } else if grown {
            self.becomes_unstable();
        }
        if grown || shrunk || (!self.grows && time > 2.0 * reference.time + FIRST_REFERENCE) {
            self.reference = Some(self.reference(amplitude, time));
            self.settled_swings = 0;
        } else {
            self.settled_swings += 1;
            if self.grows && self.settled_swings >= SETTLED_SWINGS {
                self.verdict = Some(Verdict::Unstable);
            }
        }
    }
}

impl Observer for Judge {
    fn turns(&mut self, time: f64, x: f64) {
        self.last_distance = None;
        let Some(before) = self.last_turn.replace(x) else { return };
        self.amplitude = 0.5 * (x - before).abs();
        if self.cycles > 0 {
            // Two turning points lie between two sticks; more than three mean that the motion has come free.
            self.swings_since_stick += 1;
            self.excites();
            if self.swings_since_stick <= FIRST_SWINGS {
                return;
            }
            self.cycles = 0;
            (self.sum, self.summed, self.means) = (0.0, 0, 0);
            self.reference = None;
        }
        self.excites();
        self.judge_swing(time);
    }

    fn sticks(&mut self, time: f64, x: f64) {
        self.last_distance = None;
        // A swing that ends in stick is at least this long.
        if let (Some(reference), Some(turn)) = (self.reference.take(), self.last_turn)
            && 0.5 * (x - turn).abs() > reference.amplitude * (1.0 + reference.change)
        {
            self.becomes_unstable();
        }
        self.last_stick = time;
        self.excitation *= self.ringing(time);
        self.let_go = time;
        self.first_swings = FIRST_SWINGS;
        self.swings_since_stick = 0;
        self.cycles += 1;
        let kept = match self.rules.slowest_transient {
            None => self.cycles > 1,
            Some(_) if self.stick_share >= LARGE_SHARE => self.cycles > KEPT,
            Some(_) => self.cycles > KEPT_BARELY,
        };
        // The first stick ends no cycle.
        let settled = self.rules.until_settled && self.cycles > 1 && self.add_cycle();
        if kept && (settled || !self.rules.until_settled) {
            self.verdict = Some(Verdict::Unstable);
        }
        self.grows |= kept;
    }

    fn slips(&mut self, time: f64) {
        if let Some(before) = self.last_release {
            self.stick_share = (time - self.last_stick) / (time - before);
        }
        self.last_release = Some(time);
    }
}
