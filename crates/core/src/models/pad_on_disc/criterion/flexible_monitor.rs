//! The monitor of a flexible disc: the tangential motion, disturbed by everything that rings along.
//!
//! It combines four state machines: [`Swings`], [`Cycles`], [`SettledAmplitude`] and [`Transients`]. Each documents its
//! states in a table of its own.
//!
//! | finding | while | verdict |
//! |---|---|---|
//! | shrinking, and no larger than the stated displacement | not known to be unstable | stable |
//! | creeping: no turn and no stick between two checks, half as far from the equilibrium as before | the same | stable |
//! | still: [`STILL_SWINGS`] swings in a row far smaller than any cycle | the same | stable |
//! | growing, or constant | not still | unstable |
//! | stick-slip persists | | unstable |
//!
//! A motion is doubtful if the pad grazed the disc's speed, or if its amplitude hardly changed from swing to swing for a
//! long time. It is then simulated again with finer steps (`confirmation`).
//!
//! If the settled amplitude is wanted, an unstable motion is simulated until stick-slip has settled or until its swings
//! are constant, after they have changed: small swings next to a critical speed grow too slowly to show it. The criterion finds out whether the equilibrium is linearly stable; if it is not, a motion is
//! monitored only for its amplitude.

use crate::model::verdict::Verdict;
use crate::models::pad_on_disc::criterion::cycles::Cycles;
use crate::models::pad_on_disc::criterion::monitor::Monitor;
use crate::models::pad_on_disc::criterion::settled_amplitude::SettledAmplitude;
use crate::models::pad_on_disc::criterion::swings::{Swings, Trend};
use crate::models::pad_on_disc::criterion::transients::Transients;
use crate::models::pad_on_disc::degree_of_freedom::DegreeOfFreedom;
use crate::models::pad_on_disc::motion::integrator::Observer;

/// Largest distance from the equilibrium, over x0, at which a shrinking motion counts as returned to it, however large
/// the stated displacement: cycles of the preset, and of the brakes on which verdicts were tested, are wider. A stable
/// cycle that is smaller than the displacement and has a linearly stable equilibrium inside (possible for exponents
/// above 1) is not distinguished from rest on a flexible disc.
const LARGEST_BASIN: f64 = 0.1;

/// Distance from the equilibrium, over x0, at which a motion that does not turn has arrived: smaller than what numbers
/// resolve at the end of a creeping motion.
const ARRIVED: f64 = 1e-6;

/// A motion with so many swings in a row that are smaller than this, over x0 and over the smallest cycle, is at rest.
/// What is left is the ringing of a disc that dies away more slowly than the tangential motion did. It beats, so its
/// changes say nothing beside what the first swings could imitate.
const STILL: f64 = 1e-6;
const STILL_SWINGS: u32 = 100;

/// A change of amplitude from swing to swing that may be due to the steps, and when it is looked at first. The change
/// shrinks with the fourth power of the steps.
const SLOW: f64 = 2e-5;
const FIRST_COMPARISON: f64 = 20.0;

/// How a motion is decided.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct MonitorOptions {
    /// Slowest damping rate of the degrees of freedom that disturb the tangential motion.
    pub slowest_transient: f64,
    /// Amplitude at which the pad swings as fast as the disc, that of the smallest stick-slip: on a slow disc far less
    /// than x0.
    pub smallest_cycle: f64,
    /// Whether an unstable motion is simulated until its amplitude has settled.
    pub until_settled: bool,
    /// What feeds small motions about steady sliding, if it is linearly unstable: then the verdict is known, and only
    /// the amplitude is not.
    pub linear_growth_fed_by: Option<DegreeOfFreedom>,
    /// The length of the steps over that of the first simulation.
    pub refinement: f64,
}

/// What is known of one motion so far.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FlexibleMonitor {
    until_settled: bool,
    linear_growth_fed_by: Option<DegreeOfFreedom>,
    /// x0.
    equilibrium: f64,
    /// Amplitude below which a shrinking motion counts as returned to the equilibrium: the stated displacement.
    basin: f64,
    /// Whether the amplitude has clearly grown or shrunk, or the pad has stuck: swings that are constant from the start on
    /// may be growing too slowly to show it.
    has_changed: bool,
    /// Amplitude below which a swing counts as still, and how many such swings came in a row.
    still: f64,
    still_swings: u32,
    /// Distance from the equilibrium at the last check, unless the motion has turned, stuck or slipped since.
    last_distance: Option<f64>,
    verdict: Option<Verdict>,
    /// The motion is known to be unstable, and may be simulated further for its amplitude.
    is_known_unstable: bool,
    /// Errors of the steps may have decided whether the pad stuck, or whether the motion grew.
    is_doubtful: bool,
    /// The change of amplitude from swing to swing below which the motion hovers.
    slow: f64,
    /// The swing with which later ones are compared to see whether it does.
    hovering_from: Option<HoveringFrom>,
    swings: Swings,
    cycles: Cycles,
    settled: SettledAmplitude,
    transients: Transients,
}

/// A swing, and how many came after it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct HoveringFrom {
    amplitude: f64,
    time: f64,
    swings: u32,
}

impl FlexibleMonitor {
    /// For a motion about the equilibrium `x0`, with the stated displacement over x0, that starts at a turning point if
    /// it starts without speed.
    pub fn new(options: MonitorOptions, equilibrium: f64, displacement: f64, starts_turning_at: Option<f64>) -> Self {
        Self {
            until_settled: options.until_settled,
            linear_growth_fed_by: options.linear_growth_fed_by,
            equilibrium,
            basin: displacement.min(LARGEST_BASIN) * equilibrium.abs(),
            has_changed: false,
            still: STILL * equilibrium.abs().min(options.smallest_cycle),
            still_swings: 0,
            last_distance: None,
            verdict: (options.linear_growth_fed_by.is_some() && !options.until_settled).then_some(Verdict::Unstable),
            is_doubtful: false,
            slow: SLOW * libm::pow(options.refinement, 4.0),
            hovering_from: None,
            is_known_unstable: options.linear_growth_fed_by.is_some(),
            swings: Swings::new(starts_turning_at),
            cycles: Cycles::new(),
            settled: SettledAmplitude::new(),
            transients: Transients::new(options.slowest_transient),
        }
    }

    /// Notes that normal motion and rotation start away from steady sliding, by this much in the disc's thicknesses and
    /// rad together.
    pub fn is_excited_by(&mut self, distance: f64) {
        self.transients.are_excited_by(distance);
    }

    fn becomes_unstable(&mut self) {
        self.is_known_unstable = true;
        if !self.until_settled {
            self.verdict = Some(Verdict::Unstable);
        }
    }

    /// Notes a motion whose amplitude hardly changes from swing to swing: it is near an unstable cycle, and damping by
    /// the steps may decide whether it grows.
    fn notice_hovering(&mut self, time: f64, amplitude: f64) {
        // Within the displacement it has come back, however slowly it goes on: linear stability is known.
        if self.is_known_unstable || amplitude <= self.basin {
            return;
        }
        let now = HoveringFrom { amplitude, time, swings: 0 };
        let Some(from) = &mut self.hovering_from else {
            self.hovering_from = Some(now);
            return;
        };
        from.swings += 1;
        if time > 2.0 * from.time + FIRST_COMPARISON {
            let change = libm::log(amplitude / from.amplitude).abs();
            self.is_doubtful |= change < self.slow * f64::from(from.swings);
            self.hovering_from = Some(now);
        }
    }

    /// A swing of a motion that does not stick.
    fn compare_swing(&mut self, time: f64, amplitude: f64) {
        self.notice_hovering(time, amplitude);
        let imitated = self.transients.imitated(time, amplitude);
        let trend = self.swings.trend(time, imitated);
        self.has_changed |= matches!(trend, Trend::Growing | Trend::Shrinking);
        let is_cycle = if self.is_known_unstable { self.has_changed } else { amplitude > self.basin };
        match trend {
            // What is still may be errors of the steps, as of a start at the equilibrium itself.
            Trend::Growing if amplitude > self.still || self.is_known_unstable => self.becomes_unstable(),
            Trend::Shrinking if !self.is_known_unstable && amplitude <= self.basin => {
                self.verdict = Some(Verdict::Stable);
            }
            Trend::Constant if is_cycle => self.verdict = Some(Verdict::Unstable),
            Trend::Growing | Trend::Shrinking | Trend::Constant | Trend::Unclear => {}
        }
        self.still_swings = if amplitude <= self.still { self.still_swings + 1 } else { 0 };
        if self.still_swings >= STILL_SWINGS && !self.is_known_unstable && self.verdict.is_none() {
            self.verdict = Some(Verdict::Stable);
        }
    }
}

impl Monitor for FlexibleMonitor {
    #[inline]
    fn verdict(&self) -> Option<Verdict> {
        self.verdict
    }

    fn is_unstable(&self) -> bool {
        self.is_known_unstable || self.verdict == Some(Verdict::Unstable)
    }

    fn amplitude(&self) -> f64 {
        self.settled.value().unwrap_or(self.swings.amplitude())
    }

    fn is_doubtful(&self) -> bool {
        self.is_doubtful && self.linear_growth_fed_by.is_none()
    }

    fn fed_by(&self) -> DegreeOfFreedom {
        self.linear_growth_fed_by.unwrap_or(DegreeOfFreedom::Tangential)
    }

    #[inline]
    fn check(&mut self, x: f64, _: f64) {
        let distance = (x - self.equilibrium).abs();
        let arrived = ARRIVED * self.equilibrium.abs();
        if let Some(before) = self.last_distance
            && self.verdict.is_none()
            && !self.is_known_unstable
            && distance <= self.basin
            && (distance <= 0.5 * before || distance.max(before) <= arrived)
        {
            self.verdict = Some(Verdict::Stable);
        }
        self.last_distance = (!self.cycles.is_stuck()).then_some(distance);
    }
}

impl Observer for FlexibleMonitor {
    #[inline]
    fn turns(&mut self, time: f64, x: f64) {
        self.last_distance = None;
        let Some(amplitude) = self.swings.turns(x) else { return };
        self.transients.swings(amplitude);
        let has_ended = self.cycles.swings();
        if has_ended {
            self.settled = SettledAmplitude::new();
        }
        if !self.cycles.is_ongoing() {
            self.compare_swing(time, amplitude);
        }
    }

    fn sticks(&mut self, time: f64, x: f64) {
        self.last_distance = None;
        self.hovering_from = None;
        self.has_changed = true;
        if self.swings.sticks(x) {
            self.becomes_unstable();
        }
        self.transients.sticks(time);
        self.cycles.sticks(time);
        let has_settled = self.until_settled && self.cycles.has_cycle() && self.settled.add(self.swings.amplitude());
        if self.cycles.persists(&self.transients) {
            self.is_known_unstable = true;
            if has_settled || !self.until_settled {
                self.verdict = Some(Verdict::Unstable);
            }
        }
    }

    fn slips(&mut self, time: f64) {
        self.last_distance = None;
        self.transients.slips(time);
        self.cycles.slips(time);
    }

    fn grazes(&mut self) {
        self.is_doubtful |= !self.is_known_unstable;
    }
}

#[cfg(test)]
mod tests;
