//! What a motion settles to.

use crate::models::pad_on_disc::motion::event_log::EventLog;
use crate::models::pad_on_disc::motion::moment::Moment;

/// Share of a trajectory, from its end, that is summarised as the settled motion.
const SETTLED_SHARE: f64 = 0.25;

/// Amplitudes below this share of the displacement of the pad are no oscillation any more.
const STILL: f64 = 1e-6;

/// Parts of that time whose amplitudes are compared.
const PARTS: usize = 4;

/// An amplitude that changes by no more than this share from the first to the last of them has settled.
const SETTLED_CHANGE: f64 = 1e-4;

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
    /// The share by which the amplitude still rises, or falls if negative, from the first to the last of four parts of
    /// this time; `None` where it does neither from part to part, or a part is shorter than the period.
    pub amplitude_change: Option<f64>,
}

impl SettledMotion {
    /// Summarises the end of a motion of `steps` steps, if it reached it.
    pub(crate) fn summarise(log: &EventLog, moments: &[Moment], steps: u64, h: f64) -> Option<Self> {
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
        let amplitude_change = period.filter(|period| *period <= part).and_then(|_| steady_change(&amplitudes));
        Some(Self {
            tangential_max: largest,
            tangential_min: smallest,
            tangential_mean: mean(moments, start, to),
            period,
            stick_fraction,
            amplitude_change,
        })
    }
}

/// The share by which the last of these amplitudes exceeds the first, if they rise or fall all along.
fn steady_change(amplitudes: &[f64; PARTS]) -> Option<f64> {
    let change = amplitudes[PARTS - 1] / amplitudes[0] - 1.0;
    let is_steady = amplitudes.windows(2).all(|pair| (pair[1] - pair[0]) * change > 0.0);
    (is_steady && change.abs() > SETTLED_CHANGE).then_some(change)
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
        assert!((steady_change(&[1.0, 1.1, 1.3, 1.5]).unwrap() - 0.5).abs() < 1e-15);
        assert!((steady_change(&[1.0, 0.9, 0.8, 0.7]).unwrap() + 0.3).abs() < 1e-15);
        // Beats, and a change that is lost among others.
        assert_eq!(steady_change(&[1.0, 1.3, 1.2, 1.5]), None);
        assert_eq!(steady_change(&[1.0, 1.000_01, 1.000_02, 1.000_05]), None);
    }
}
