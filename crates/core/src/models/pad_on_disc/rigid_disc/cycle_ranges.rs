//! Between which speeds of the disc there are limit cycles on a rigid disc, with and without sticking.
//!
//! Where slow sliding is stable, with a Stribeck exponent above 1 or a measured curve, stick-slip begins at a speed above
//! 0; on a curve that falls in several places it may end and begin again. Cycles without sticking begin where small
//! swings lose their stability, where stick-slip ends, or with an unstable one beside them. They may lie inside one that
//! sticks: which of the two a motion comes to depends on its start.
//!
//! | cycle | there is one where |
//! |---|---|
//! | stick-slip | the motion after a release comes to the disc's speed again |
//! | without sticking | among the swings inside that motion some grow, and some wider ones shrink |
//!
//! Both are asked for at thirty speeds a decade, from far below both speeds that matter
//! ([`PadOnDisc::saddle_node_speed`]) up to the highest admissible one, and where ranges usually begin and end: beside the
//! ends of stick-slip and of unstable sliding, within and below each range of the latter. Between two speeds with
//! different answers the end is located by bisection. So a range is missed if it lies between two neighbouring speeds.

use crate::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;
use crate::models::pad_on_disc::rigid_disc::planar_motion::PlanarMotion;
use crate::models::pad_on_disc::rigid_disc::stability::SpeedRange;
use crate::numerics::root_location::bisect;

/// Speeds in each decade of the scan: neighbours differ by 8 %.
const POINTS_PER_DECADE: f64 = 30.0;

/// How far beside an end, relative to it, cycles are looked for too.
const BESIDE: f64 = 1e-6;

/// How close the ends are located, relative to their speed.
const LOCATED: f64 = 1e-10;

/// The rotating speeds (rad/s) with limit cycles, each list in rising order. A range from 0 goes on below the lowest speed
/// that is looked at, an infinite one above the highest admissible speed.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CycleRanges {
    /// With a cycle in which the pad comes to the disc's speed and sticks, or overtakes the disc where static friction
    /// cannot hold it.
    pub stick_slip: Vec<SpeedRange>,
    /// With a cycle in which it slides all the time.
    pub without_sticking: Vec<SpeedRange>,
    /// Where one or the other is not known: the motion is too stiff for the method, or changes too slowly.
    pub unresolved: Vec<SpeedRange>,
}

impl CycleRanges {
    /// The speed above which no motion sticks again; `None` if there is stick-slip at no speed, up to any speed, or as far
    /// as is known.
    #[must_use]
    pub fn end_of_stick_slip(&self) -> Option<f64> {
        self.end_of(self.stick_slip.last())
    }

    /// The speed above which there is no limit cycle, likewise.
    #[must_use]
    pub fn end_of_cycles(&self) -> Option<f64> {
        let last = [self.stick_slip.last(), self.without_sticking.last()].into_iter().flatten();
        self.end_of(last.max_by(|first, second| first.to.total_cmp(&second.to)))
    }

    fn end_of(&self, last: Option<&SpeedRange>) -> Option<f64> {
        let end = last.map(|range| range.to).filter(|end| end.is_finite())?;
        self.unresolved.iter().all(|range| range.to <= end).then_some(end)
    }
}

/// What is asked of the motion at each speed; `None` is not resolved.
type Question = fn(&PlanarMotion) -> Option<bool>;

impl PadOnDisc {
    /// The rotating speeds at which there are limit cycles on a rigid disc, with and without sticking. Ends are located to
    /// 1e-10; a range that is narrower than 8 % of its speed may be missed, if it neither touches another one or a range
    /// of unstable sliding, nor lies in the middle of one.
    #[must_use]
    pub fn cycle_ranges(&self) -> CycleRanges {
        let mut speeds = self.scanned_speeds(POINTS_PER_DECADE);
        if speeds.is_empty() {
            return CycleRanges::default();
        }
        for SpeedRange { from, to } in self.unstable_speeds() {
            speeds.extend([from, to].into_iter().flat_map(beside));
            speeds.extend([0.5 * from, 0.5 * (from + to)]);
        }
        let mut unresolved = Vec::new();
        let stick_slip = self.ranges_of(&mut speeds, PlanarMotion::has_stick_slip, &mut unresolved);
        speeds.extend(stick_slip.iter().flat_map(|range| [range.from, range.to]).flat_map(beside));
        let without_sticking = self.ranges_of(&mut speeds, PlanarMotion::has_cycle_without_sticking, &mut unresolved);
        unresolved.sort_by(|first, second| first.from.total_cmp(&second.from));
        unresolved.dedup();
        CycleRanges { stick_slip, without_sticking, unresolved }
    }

    /// The ranges in which the answer is yes. `speeds` are sorted, and freed of those that are not admissible; ranges
    /// without an answer are added to `unresolved`.
    fn ranges_of(
        &self,
        speeds: &mut Vec<f64>,
        question: Question,
        unresolved: &mut Vec<SpeedRange>,
    ) -> Vec<SpeedRange> {
        speeds.retain(|speed| self.motion_at(*speed).is_some());
        speeds.sort_by(f64::total_cmp);
        speeds.dedup();
        let ask = |speed: f64| self.motion_at(speed).and_then(|motion| question(&motion));
        let mut ranges: Vec<SpeedRange> = Vec::new();
        let mut before: Option<(f64, bool)> = None;
        let mut is_gap = false;
        for &speed in &*speeds {
            let Some(answer) = ask(speed) else {
                is_gap = true;
                continue;
            };
            let known_from = before.map_or(0.0, |(known, _)| known);
            if is_gap {
                unresolved.push(SpeedRange { from: known_from, to: speed });
            }
            let end = |was: bool| {
                let (early, late) = bisect((known_from, speed), 1000, LOCATED, |speed| ask(speed) == Some(was));
                0.5 * (early + late)
            };
            match (before, answer) {
                (None, true) => {
                    let from = if is_gap { speed } else { 0.0 };
                    ranges.push(SpeedRange { from, to: f64::INFINITY });
                }
                (Some((_, false)), true) => {
                    let from = if is_gap { speed } else { end(false) };
                    ranges.push(SpeedRange { from, to: f64::INFINITY });
                }
                (Some((_, true)), false) => {
                    if let Some(range) = ranges.last_mut() {
                        range.to = if is_gap { known_from } else { end(true) };
                    }
                }
                (None | Some((_, false)), false) | (Some((_, true)), true) => {}
            }
            (before, is_gap) = (Some((speed, answer)), false);
        }
        if is_gap {
            let from = before.map_or(0.0, |(known, _)| known);
            unresolved.push(SpeedRange { from, to: f64::INFINITY });
            if let (Some((_, true)), Some(range)) = (before, ranges.last_mut()) {
                range.to = from;
            }
        }
        ranges
    }
}

/// The speeds next to an end.
fn beside(end: f64) -> [f64; 2] {
    [end * (1.0 - BESIDE), end * (1.0 + BESIDE)]
}
