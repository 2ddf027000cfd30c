//! Crossings of a probability that can be computed at any value.

use super::{Limit, State};
use crate::integrate::closed_form::ExactProbability;

/// Least number of intervals of a scan.
const INTERVALS: usize = 256;

/// A limit is located to this part of itself.
const TOLERANCE: f64 = 1e-12;

/// Halvings at most; a limit at zero has no relative precision.
const MOST_HALVINGS: usize = 200;

/// Steps of a golden-section search: it ends at 1e-8 of its interval, where an extremum is known to 1e-16.
const STEPS: usize = 40;

/// The golden section.
const GOLDEN: f64 = 0.618_033_988_749_894_8;

/// A probability over an axis, at enough values to see where it passes a target.
#[derive(Debug, Clone)]
pub struct Scan {
    /// Rising.
    points: Vec<(f64, ExactProbability)>,
}

/// The values of an axis in rising order, with so many values between each two that there are at least 256 intervals,
/// and at least 2 between neighbours.
#[must_use]
pub fn scanned_values(axis: &[f64]) -> Vec<f64> {
    let mut values = axis.to_vec();
    values.sort_by(f64::total_cmp);
    let parts = INTERVALS.div_ceil(values.len().saturating_sub(1).max(1)).max(2);
    let mut scanned = Vec::with_capacity(values.len() * parts);
    for pair in values.windows(2) {
        let between = (1..parts).map(|i| pair[0] + (pair[1] - pair[0]) * (i as f64 / parts as f64));
        scanned.push(pair[0]);
        scanned.extend(between.filter(|value| pair[0] < *value && *value < pair[1]));
    }
    scanned.extend(values.last());
    scanned
}

impl Scan {
    /// Computes the probability at `values`, which rise.
    ///
    /// # Errors
    /// The first error of `probability`.
    pub fn new<E>(values: &[f64], mut probability: impl FnMut(f64) -> Result<ExactProbability, E>) -> Result<Self, E> {
        let points = values.iter().map(|&value| Ok((value, probability(value)?))).collect::<Result<_, E>>()?;
        Ok(Self { points })
    }

    /// The probabilities at the first and the last value.
    #[must_use]
    pub fn ends(&self) -> [f64; 2] {
        [self.points.first(), self.points.last()].map(|point| point.map_or(f64::NAN, |(_, found)| found.value))
    }

    /// Every value at which the probability passes `target`, in rising order; if there is none, one entry that says on
    /// which side it is.
    ///
    /// A rise and a fall between two neighbouring values of the scan are found if the scan turns there: next to each of
    /// its extrema the true one is sought by golden section. The limit is the side of the last bracket on which the
    /// probability is within the target; the bounds are those that its error bound leaves open
    /// between the neighbouring values of the scan.
    ///
    /// # Errors
    /// The first error of `probability`, which must be that of the scan.
    pub fn limits<E>(
        &self,
        target: f64,
        mut probability: impl FnMut(f64) -> Result<ExactProbability, E>,
    ) -> Result<Vec<Limit>, E> {
        let mut points: Vec<(f64, bool)> = Vec::with_capacity(self.points.len());
        for (i, &(value, found)) in self.points.iter().enumerate() {
            points.push((value, found.value > target));
            if let Some(beyond) = self.turn_through(i, target, &mut probability)? {
                points.push((beyond, found.value <= target));
            }
        }
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut limits = Vec::new();
        for pair in points.windows(2) {
            if pair[0].1 != pair[1].1 {
                limits.push(located([pair[0].0, pair[1].0], pair[1].1, target, &mut probability)?);
            }
        }
        if let ([], Some(first)) = (&limits[..], points.first()) {
            limits.push(Limit { state: State::without_limit(first.1), value: None, bounds: None });
        }
        Ok(limits)
    }

    /// A value beside point `i` at which the probability is on the other side of the target, if the scan turns at this
    /// point without reaching that side.
    fn turn_through<E>(
        &self,
        i: usize,
        target: f64,
        probability: &mut impl FnMut(f64) -> Result<ExactProbability, E>,
    ) -> Result<Option<f64>, E> {
        let (_, here) = self.points[i];
        let (before, after) = (self.points[i.saturating_sub(1)], self.points[(i + 1).min(self.points.len() - 1)]);
        let is_over = here.value > target;
        // Towards the target is up.
        let sign = if is_over { -1.0 } else { 1.0 };
        let rise = |other: ExactProbability| sign * (here.value - other.value);
        let turns = rise(before.1) >= 0.0 && rise(after.1) >= 0.0;
        if !turns || rise(before.1).max(rise(after.1)) <= here.error_bound {
            return Ok(None);
        }
        let (mut from, mut to) = (before.0, after.0);
        let mut inner = [to - GOLDEN * (to - from), from + GOLDEN * (to - from)];
        let mut height = [sign * probability(inner[0])?.value, sign * probability(inner[1])?.value];
        for _ in 0..STEPS {
            if let Some(side) = (0..2).find(|&side| (sign * height[side] > target) != is_over) {
                return Ok(Some(inner[side]));
            }
            if height[0] > height[1] {
                to = inner[1];
                inner = [to - GOLDEN * (to - from), inner[0]];
                height = [sign * probability(inner[0])?.value, height[0]];
            } else {
                from = inner[0];
                inner = [inner[1], from + GOLDEN * (to - from)];
                height = [height[1], sign * probability(inner[1])?.value];
            }
        }
        Ok(None)
    }
}

/// The limit between two values on either side of the target; `is_over` says on which side the second is.
fn located<E>(
    between: [f64; 2],
    is_over: bool,
    target: f64,
    probability: &mut impl FnMut(f64) -> Result<ExactProbability, E>,
) -> Result<Limit, E> {
    // The probability itself, and that raised and lowered by the bound of its error.
    let mut bracket = |share_of_error: f64| {
        let mut exceeds = |value: f64| {
            let found = probability(value)?;
            Ok(found.value + share_of_error * found.error_bound > target)
        };
        let [mut from, mut to] = between;
        if share_of_error != 0.0 {
            let ends = [exceeds(from)?, exceeds(to)?];
            if ends[0] == ends[1] {
                return Ok(if ends[0] == is_over { [from, from] } else { [to, to] });
            }
        }
        for _ in 0..MOST_HALVINGS {
            let middle = from + 0.5 * (to - from);
            if to - from <= TOLERANCE * from.abs().max(to.abs()) || middle <= from || middle >= to {
                break;
            }
            if exceeds(middle)? == is_over { to = middle } else { from = middle }
        }
        Ok([from, to])
    };
    let found = bracket(0.0)?;
    let others = [found, bracket(1.0)?, bracket(-1.0)?];
    let low = others.iter().fold(f64::INFINITY, |low, [from, _]| low.min(*from));
    let high = others.iter().fold(f64::NEG_INFINITY, |high, [_, to]| high.max(*to));
    let value = Some(if is_over { found[0] } else { found[1] });
    Ok(Limit { state: State::passing(is_over), value, bounds: Some([low, high]) })
}

#[cfg(test)]
mod tests;
