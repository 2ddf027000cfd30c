//! What a motion settles to, and whether it has.
//!
//! A motion may grow so slowly that no comparison of its amplitudes shows it: next to the critical speed it grows for any
//! time, and the steps lose 4e-7 of an amplitude in a cycle. So what is known of its end decides first:
//!
//! | known of its end | it has not settled if |
//! |---|---|
//! | rest, since it is stable | it still oscillates, or moves |
//! | the amplitude of its limit cycle, on a rigid disc by the return map | its amplitude differs by more than 0.1 % |
//! | that it sticks, as no cycle slides all the time | it slides all the time |
//! | nothing, or nothing of the above | its amplitude rises or falls from part to part: by more than 1e-4, or 1e-6 where it slides all the time |

use crate::friction::law::FrictionLaw;
use crate::model::verdict::Verdict;
use crate::models::pad_on_disc::degree_of_freedom::DegreeOfFreedom;
use crate::models::pad_on_disc::motion::event_log::EventLog;
use crate::models::pad_on_disc::motion::moment::Moment;

/// Share of a trajectory, from its end, that is summarised as the settled motion.
const SETTLED_SHARE: f64 = 0.25;

/// Amplitudes below this share of the displacement of the pad are no oscillation any more.
const STILL: f64 = 1e-6;

/// Parts of that time whose amplitudes are compared.
const PARTS: usize = 4;

/// An amplitude that changes by no more than this share from the first to the last of them has settled, as far as that
/// shows; and that of a motion without sticking, which has no events that scatter.
const SETTLED_CHANGE: f64 = 1e-4;
const SETTLED_SLIDING: f64 = 1e-6;

/// An amplitude has settled if it differs by no more than this share from the known one: far beyond the errors of the steps.
const AGREES: f64 = 1e-3;

/// A pad that comes no nearer to the disc's speed than this share of it slides all the time. Between two moments it comes
/// a thousandth nearer.
const SLIDES: f64 = 0.1;

/// What is known of the end of a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outcome {
    /// Nothing.
    Unknown,
    /// It comes to this amplitude, half peak to peak; 0 is rest.
    Amplitude(f64),
    /// It comes to the disc's speed again and again.
    Sticks,
}

impl Outcome {
    /// By its verdict, which is none by definition, and what feeds the motion.
    pub(crate) fn by_verdict(verdict: Verdict, fed_by: Option<DegreeOfFreedom>, law: &FrictionLaw) -> Self {
        match verdict {
            Verdict::Stable => Self::Amplitude(0.0),
            // With these laws no tangential cycle slides all the time.
            Verdict::Unstable if fed_by == Some(DegreeOfFreedom::Tangential) && law.is_completely_monotone() => {
                Self::Sticks
            }
            Verdict::Unstable | Verdict::Undecided | Verdict::Failed => Self::Unknown,
        }
    }
}

/// What a motion settled to, over the last quarter of its trajectory.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SettledMotion {
    /// Largest x.
    pub tangential_max: f64,
    /// Smallest x.
    pub tangential_min: f64,
    /// Mean of x.
    pub tangential_mean: f64,
    /// Time between releases, or else between turning points in the same direction; `None` where nothing oscillates.
    pub period: Option<f64>,
    /// Share of the time spent in stick.
    pub stick_fraction: f64,
    /// Whether the pad never comes near the disc's speed.
    pub slides: bool,
    /// Whether it has settled.
    pub has_settled: bool,
    /// If it has not, the share by which the amplitude rises, or falls if negative, from the first to the last of four
    /// parts of this time.
    pub amplitude_change: Option<f64>,
    /// What is known of its end.
    pub outcome: Outcome,
}

impl SettledMotion {
    /// Summarises the end of a motion of `steps` steps, if it reached it.
    pub(crate) fn summarise(log: &EventLog, moments: &[Moment], steps: u64, h: f64, outcome: Outcome) -> Option<Self> {
        if steps == 0 || moments.len() as u64 != steps + 1 {
            return None;
        }
        let to = steps as f64 * h;
        let from = (1.0 - SETTLED_SHARE) * to;
        let extremes = |from: f64, to: f64| {
            let sampled = moments.iter().map(|moment| (moment.time, moment.tangential.0));
            let inside = sampled.chain(log.turns.iter().copied()).filter(|(time, _)| *time >= from && *time <= to);
            inside.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), (_, x)| (least.min(x), most.max(x)))
        };
        let (smallest, largest) = extremes(from, f64::INFINITY);
        let oscillates = largest - smallest > STILL * largest.abs();
        let between = |times: &[f64], every: usize| {
            let times: Vec<f64> = times.iter().copied().filter(|time| *time >= from && *time <= to).collect();
            let cycles = times.len().saturating_sub(1) / every;
            (cycles > 0).then(|| (times[cycles * every] - times[0]) / cycles as f64)
        };
        let turns: Vec<f64> = log.turns.iter().map(|turn| turn.0).collect();
        let period = oscillates.then(|| between(&log.releases(), 1).or_else(|| between(&turns, 2))).flatten();
        // A whole number of cycles where there are some, so that neither mean nor share depends on where it is cut.
        let window = period.map_or(to - from, |period| ((to - from) / period).floor().max(1.0) * period);
        let start = to - window;
        let stick_fraction = log.time_in_stick(start, to) / window;
        let part = (to - from) / PARTS as f64;
        let amplitudes: [f64; PARTS] = std::array::from_fn(|number| {
            let begin = from + number as f64 * part;
            let (least, most) = extremes(begin, begin + part);
            most - least
        });
        let slides = moments.iter().filter(|moment| moment.time >= from).all(|moment| {
            let disc_speed = moment.sliding_speed + moment.tangential.1;
            moment.sliding_speed > SLIDES * disc_speed
        });
        let has_whole_cycles = period.is_some_and(|period| period <= part);
        let least = if slides { SETTLED_SLIDING } else { SETTLED_CHANGE };
        let is_changing = has_whole_cycles && changes_steadily(&amplitudes, least);
        let width = if has_whole_cycles { amplitudes[PARTS - 1] } else { largest - smallest };
        let differs = match outcome {
            Outcome::Unknown => false,
            Outcome::Sticks => slides,
            Outcome::Amplitude(0.0) => width > STILL * largest.abs(),
            Outcome::Amplitude(amplitude) => (width - 2.0 * amplitude).abs() > AGREES * width.max(2.0 * amplitude),
        };
        let has_settled = !(differs || is_changing);
        let change = amplitudes[PARTS - 1] / amplitudes[0] - 1.0;
        Some(Self {
            tangential_max: largest,
            tangential_min: smallest,
            tangential_mean: mean(moments, start, to),
            period,
            stick_fraction,
            slides,
            has_settled,
            amplitude_change: Some(change).filter(|change| !has_settled && change.is_finite()),
            outcome,
        })
    }
}

/// Whether these amplitudes rise or fall all along, by more than this share together.
fn changes_steadily(amplitudes: &[f64; PARTS], least: f64) -> bool {
    let change = amplitudes[PARTS - 1] / amplitudes[0] - 1.0;
    let is_steady = amplitudes.windows(2).all(|pair| (pair[1] - pair[0]) * change > 0.0);
    is_steady && change.abs() > least
}

/// The mean of x over a time, by the trapezoidal rule; intervals that reach out of it count by their share in it.
fn mean(moments: &[Moment], from: f64, to: f64) -> f64 {
    let (mut sum, mut time) = (0.0, 0.0);
    for pair in moments.windows(2) {
        let (begin, end) = (pair[0].time, pair[1].time);
        let (left, right) = (begin.max(from), end.min(to));
        if left < right {
            let x = |time: f64| {
                let share = (time - begin) / (end - begin);
                pair[0].tangential.0 + share * (pair[1].tangential.0 - pair[0].tangential.0)
            };
            sum += (right - left) * x(0.5 * (left + right));
            time += right - left;
        }
    }
    if time > 0.0 { sum / time } else { moments.last().map_or(f64::NAN, |moment| moment.tangential.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amplitudes_change_steadily_or_not_at_all() {
        assert!(changes_steadily(&[1.0, 1.1, 1.3, 1.5], SETTLED_CHANGE));
        assert!(changes_steadily(&[1.0, 0.9, 0.8, 0.7], SETTLED_CHANGE));
        // Beats, and a change that is lost among others.
        assert!(!changes_steadily(&[1.0, 1.3, 1.2, 1.5], SETTLED_CHANGE));
        assert!(!changes_steadily(&[1.0, 1.000_01, 1.000_02, 1.000_05], SETTLED_CHANGE));
        assert!(changes_steadily(&[1.0, 1.000_01, 1.000_02, 1.000_05], SETTLED_SLIDING));
    }

    #[test]
    fn a_verdict_says_how_a_motion_ends_where_nothing_can_slide_for_ever() {
        let tangential = Some(DegreeOfFreedom::Tangential);
        let law = |exponent: f64| FrictionLaw::stribeck(0.4, 0.25, 0.7, exponent);
        for (verdict, fed_by, exponent, outcome) in [
            (Verdict::Stable, None, 2.0, Outcome::Amplitude(0.0)),
            (Verdict::Unstable, tangential, 1.0, Outcome::Sticks),
            (Verdict::Unstable, tangential, 2.0, Outcome::Unknown),
            (Verdict::Unstable, Some(DegreeOfFreedom::Normal), 1.0, Outcome::Unknown),
            (Verdict::Undecided, None, 1.0, Outcome::Unknown),
        ] {
            assert_eq!(Outcome::by_verdict(verdict, fed_by, &law(exponent)), outcome, "{verdict:?} {exponent}");
        }
    }
}
