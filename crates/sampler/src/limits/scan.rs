//! Crossings of a probability that can be estimated at any value of an axis.

use std::collections::BTreeMap;

use super::{Limit, State};
use crate::estimate::interval::Estimate;
use crate::special_functions::normal;

/// Points of a search at most; a limit at zero has no relative precision.
const MOST_POINTS: u32 = 400;

/// One of so many points of a search halves its bracket.
const HALVING: u32 = 4;

/// Steps of a golden-section search: it ends at 1e-8 of its interval, where an extremum is known to 1e-16.
const STEPS: usize = 40;

/// The golden section.
const GOLDEN: f64 = 0.618_033_988_749_894_8;

/// Probabilities beyond these count as these where a search interpolates.
const EXTREMES: (f64, f64) = (1e-300, 1.0 - f64::EPSILON);

/// Estimates of a probability over an axis, at enough values to see where it passes a target.
#[derive(Debug, Clone)]
pub struct Scan {
    /// Rising.
    points: Vec<(f64, Estimate)>,
    tolerance: f64,
}

/// The values of an axis in rising order, with so many values between each two that there are at least `intervals`, and
/// at least 2 between neighbours.
#[must_use]
pub fn scanned_values(axis: &[f64], intervals: usize) -> Vec<f64> {
    let mut values = axis.to_vec();
    values.sort_by(f64::total_cmp);
    let parts = intervals.div_ceil(values.len().saturating_sub(1).max(1)).max(2);
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
    /// Estimates the probability at `values`, which rise. Limits will be located to the part `tolerance` of themselves.
    ///
    /// # Errors
    /// The first error of `estimate`.
    pub fn new<E>(
        values: &[f64],
        tolerance: f64,
        mut estimate: impl FnMut(f64) -> Result<Estimate, E>,
    ) -> Result<Self, E> {
        let points = values.iter().map(|&value| Ok((value, estimate(value)?))).collect::<Result<_, E>>()?;
        Ok(Self { points, tolerance })
    }

    /// Whether there is no probability at any value.
    #[must_use]
    pub fn is_unknown(&self) -> bool {
        self.points.iter().all(|(_, found)| found.probability.is_none())
    }

    /// The first and the last value with their estimates; none of a scan without values.
    #[must_use]
    pub fn ends(&self) -> Option<[(f64, Estimate); 2]> {
        Some([*self.points.first()?, *self.points.last()?])
    }

    /// Every value at which the probability passes `target`, in rising order; if there is none, one entry that says on
    /// which side it is.
    ///
    /// A rise and a fall between two neighbouring values of the scan are found if the scan turns there: next to each of
    /// its extrema the true one is sought by golden section. The limit is the side of the last bracket on which the
    /// probability is within the target. Its bounds are where the interval of the probability ceases to contain the
    /// target, seen from the limit.
    ///
    /// # Errors
    /// The first error of `estimate`, which must be that of the scan.
    pub fn limits<E>(&self, target: f64, estimate: impl FnMut(f64) -> Result<Estimate, E>) -> Result<Vec<Limit>, E> {
        let known = self.points.iter().map(|(value, found)| (value.to_bits(), *found)).collect();
        let mut search = Search { target, tolerance: self.tolerance, known, estimate };
        let mut values: Vec<f64> = Vec::with_capacity(self.points.len());
        for i in 0..self.points.len() {
            let near = [i.saturating_sub(1), i, (i + 1).min(self.points.len() - 1)].map(|i| self.points[i]);
            values.push(near[1].0);
            values.extend(search.beyond_turn(near)?);
        }
        values.sort_by(f64::total_cmp);
        let mut limits = Vec::new();
        for i in 1..values.len() {
            let pair = [values[i - 1], values[i]];
            let is_over_beyond = search.is_over(pair[1], Of::Probability)?;
            if search.is_over(pair[0], Of::Probability)? != is_over_beyond {
                let [from, to] = search.narrowed(pair, Of::Probability)?;
                let bounds = [search.end(from, values[..i].iter().rev())?, search.end(to, values[i..].iter())?];
                let value = Some(if is_over_beyond { from } else { to });
                limits.push(Limit { state: State::passing(is_over_beyond), value, bounds: Some(bounds) });
            }
        }
        if let ([], Some(&first)) = (&limits[..], values.first()) {
            let state = State::without_limit(search.is_over(first, Of::Probability)?);
            limits.push(Limit { state, value: None, bounds: search.open(&values)? });
        }
        Ok(limits)
    }
}

/// What of an estimate is compared with a target.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Of {
    Low,
    Probability,
    High,
}

impl Of {
    /// Without a probability its lower bound counts.
    fn value(self, estimate: &Estimate) -> f64 {
        match self {
            Self::Low => estimate.low,
            Self::Probability => estimate.probability.unwrap_or(estimate.low),
            Self::High => estimate.high,
        }
    }
}

/// A search for the values at which a probability passes a target.
struct Search<F> {
    target: f64,
    tolerance: f64,
    /// Estimates that were made already, by the bits of their values.
    known: BTreeMap<u64, Estimate>,
    estimate: F,
}

impl<E, F: FnMut(f64) -> Result<Estimate, E>> Search<F> {
    fn at(&mut self, value: f64) -> Result<Estimate, E> {
        if let Some(known) = self.known.get(&value.to_bits()) {
            return Ok(*known);
        }
        let found = (self.estimate)(value)?;
        self.known.insert(value.to_bits(), found);
        Ok(found)
    }

    fn is_over(&mut self, value: f64, of: Of) -> Result<bool, E> {
        Ok(of.value(&self.at(value)?) > self.target)
    }

    /// On which side of the target the whole interval is: an end of it that is there as well. `None` if it contains the
    /// target.
    fn side(&mut self, value: f64) -> Result<Option<Of>, E> {
        let found = self.at(value)?;
        Ok(if found.low > self.target {
            Some(Of::Low)
        } else if found.high <= self.target {
            Some(Of::High)
        } else {
            None
        })
    }

    /// How far the estimate is above the target, on a scale on which it changes steadily; never 0.
    fn height(&mut self, value: f64, of: Of) -> Result<f64, E> {
        let found = of.value(&self.at(value)?);
        let deviate = |p: f64| normal::quantile(p.clamp(EXTREMES.0, EXTREMES.1));
        let height = deviate(found) - deviate(self.target);
        Ok(if found > self.target { height.max(f64::MIN_POSITIVE) } else { height.min(-f64::MIN_POSITIVE) })
    }

    /// Narrows a bracket, at one end of which the estimate is above the target and at the other it is not, by false
    /// position and bisection.
    fn narrowed(&mut self, [mut from, mut to]: [f64; 2], of: Of) -> Result<[f64; 2], E> {
        let mut heights = [self.height(from, of)?, self.height(to, of)?];
        let mut moved = None;
        for point in 0..MOST_POINTS {
            let (middle, width) = (from + 0.5 * (to - from), self.tolerance * from.abs().max(to.abs()));
            if to - from <= width || middle <= from || middle >= to {
                break;
            }
            // Not at an end, so that the last step closes the bracket.
            let secant = from + (to - from) * (heights[0] / (heights[0] - heights[1]));
            let secant = secant.max(from + 0.4 * width).min(to - 0.4 * width);
            let is_halved = point % HALVING == HALVING - 1 || secant <= from || secant >= to;
            let value = if is_halved { middle } else { secant };
            let height = self.height(value, of)?;
            let side = usize::from((height > 0.0) != (heights[0] > 0.0));
            heights[side] = height;
            if side == 0 {
                from = value;
            } else {
                to = value;
            }
            // An end that stays twice in a row counts half, or it would stay for ever.
            if moved.replace(side) == Some(side) {
                heights[1 - side] *= 0.5;
            }
        }
        Ok([from, to])
    }

    /// Where the interval ceases to contain the target, seen from `inner` past `outer` values; the last of these if it does
    /// nowhere.
    fn end<'a>(&mut self, inner: f64, outer: impl Iterator<Item = &'a f64>) -> Result<f64, E> {
        if self.side(inner)?.is_some() {
            return Ok(inner);
        }
        let mut open = inner;
        for &value in outer {
            if let Some(of) = self.side(value)? {
                let [from, to] = self.narrowed([open.min(value), open.max(value)], of)?;
                return Ok(if value < open { from } else { to });
            }
            open = value;
        }
        Ok(open)
    }

    /// From the first to the last of rising values at which the interval contains the target, or on to where it ceases
    /// to; `None` if it does at none of them.
    fn open(&mut self, values: &[f64]) -> Result<Option<[f64; 2]>, E> {
        let mut open = Vec::new();
        for (i, &value) in values.iter().enumerate() {
            if self.side(value)?.is_none() {
                open.push(i);
            }
        }
        let (Some(&first), Some(&last)) = (open.first(), open.last()) else { return Ok(None) };
        let low = self.end(values[first], values[..first].iter().rev())?;
        Ok(Some([low, self.end(values[last], values[last + 1..].iter())?]))
    }

    /// A value beside the middle one of three points at which the probability is on the other side of the target, if it
    /// turns at this point without reaching that side.
    fn beyond_turn(&mut self, [before, here, after]: [(f64, Estimate); 3]) -> Result<Option<f64>, E> {
        let of_here = Of::Probability.value(&here.1);
        let is_over = of_here > self.target;
        // Towards the target is up.
        let sign = if is_over { -1.0 } else { 1.0 };
        let rises = [before, after].map(|(_, other)| sign * (of_here - Of::Probability.value(&other)));
        let turns = rises.iter().all(|rise| *rise >= 0.0);
        if !turns || rises[0].max(rises[1]) <= 0.5 * (here.1.high - here.1.low) {
            return Ok(None);
        }
        let (mut from, mut to) = (before.0, after.0);
        let mut inner = [to - GOLDEN * (to - from), from + GOLDEN * (to - from)];
        let mut found = [self.at(inner[0])?, self.at(inner[1])?];
        for _ in 0..STEPS {
            let heights = found.map(|found| sign * Of::Probability.value(&found));
            if let Some(side) = (0..2).find(|&side| (sign * heights[side] > self.target) != is_over) {
                return Ok(Some(inner[side]));
            }
            if heights[0] > heights[1] {
                to = inner[1];
                inner = [to - GOLDEN * (to - from), inner[0]];
                found = [self.at(inner[0])?, found[0]];
            } else {
                from = inner[0];
                inner = [inner[1], from + GOLDEN * (to - from)];
                found = [found[1], self.at(inner[1])?];
            }
        }
        Ok(None)
    }
}

#[cfg(test)]
mod tests;
