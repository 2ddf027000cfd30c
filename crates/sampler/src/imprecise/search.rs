//! The least and the greatest probability over quantities about whose effect nothing is proved.
//!
//! The quantile of the normal distribution at the probability (the reliability index) changes smoothly over many powers
//! of ten of the probability. It is interpolated between Chebyshev's points, which are made finer until the
//! interpolation is settled, and its extremes are where the probability is computed last.

use std::collections::HashMap;

use super::interpolation::{Interpolation, node};
use super::result::{Extreme, Trend};
use super::tolerance::tolerance;
use crate::integrate::closed_form::ExactProbability;
use crate::special_functions::normal;

/// Intervals along each quantity to begin with.
const FIRST: usize = 4;

/// Points at most.
const MOST_POINTS: usize = 20_000;

/// Last coefficients of an interpolation that is settled: its error is smaller by some powers of ten.
const SETTLED: f64 = 2e-3;

/// Least ratio of the ends of an interval for steps of equal ratio.
const LEAST_RATIO: f64 = 2.0;

/// Points from which an extreme of the interpolation is sought.
const STARTS: usize = 4;

/// Times that each variable in turn is searched, and values at which it is first looked at.
const ROUNDS: usize = 6;
const LOOKS: usize = 32;

/// Steps of a golden-section search.
const STEPS: usize = 30;

/// The golden section.
const GOLDEN: f64 = 0.618_033_988_749_894_8;

/// The interpolation agrees with the probability at an extreme within so many tolerances.
const CLOSE: f64 = 30.0;

/// Refinements that leave the extremes as they were, after which the search ends: where the interpolation agrees with the
/// probability at the extremes, and where it does not, as beside a kink.
const UNCHANGED: usize = 2;
const UNCHANGED_ANYWAY: usize = 3;

/// Probabilities between which the reliability index is interpolated. Beyond, nothing need be distinguished, and a step
/// to a probability of 0 or 1 must not be too high.
const INTERPOLATED: [f64; 2] = [1e-30, 1.0 - 1e-8];

/// Differences of the reliability index that are rounding.
const ROUNDING: f64 = 1e-9;

/// What was found.
#[derive(Debug, Clone)]
pub struct Found {
    /// The least and the greatest probability, if wanted.
    pub extremes: [Option<Extreme>; 2],
    /// What the probability does along each quantity.
    pub trends: Vec<Trend>,
    /// Whether the interpolation agrees with the probability at the extremes, and finer ones do not change them.
    pub agrees: bool,
    /// Probabilities that were integrated.
    pub evaluations: u64,
}

/// How the refinement of an interpolation ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum End {
    /// The interpolation agrees everywhere.
    Settled,
    /// The extremes do not change any more, where it agrees; elsewhere the probability has a kink, or is 0 or 1.
    Unchanged,
    /// The interpolation does not agree at the extremes.
    Open,
}

/// Which extreme: the reliability index falls as the probability rises.
const SIGNS: [f64; 2] = [-1.0, 1.0];

/// Every probability that was computed.
struct Search<'a, F> {
    intervals: &'a [[f64; 2]],
    probability: F,
    computed: Vec<(Vec<f64>, ExactProbability)>,
    /// The place of each point among these, by the bits of its values.
    places: HashMap<Vec<u64>, usize>,
}

/// The least probability, the greatest, or both, as `wanted` says, over at least one interval.
///
/// # Errors
/// The first error of `probability`.
pub fn extremes<E>(
    intervals: &[[f64; 2]],
    wanted: [bool; 2],
    probability: impl FnMut(&[f64]) -> Result<ExactProbability, E>,
) -> Result<Found, E> {
    let mut search = Search { intervals, probability, computed: Vec::new(), places: HashMap::new() };
    let mut grid = Interpolation::new(intervals.len(), FIRST);
    let mut before: [Option<f64>; 2] = [None; 2];
    let mut unchanged = 0;
    let end = loop {
        for point in grid.points() {
            if !grid.knows(&point) {
                let at: Vec<f64> = point.iter().map(|&index| node(index)).collect();
                let value = search.index(&at)?;
                grid.set(point, value);
            }
        }
        grid.gather();
        let mut agrees = true;
        for which in (0..2).filter(|&which| wanted[which]) {
            for at in candidates(&grid, which) {
                let expected = normal::upper_tail(grid.at(&at));
                let found = normal::upper_tail(search.index(&at)?);
                agrees &= (expected - found).abs() <= CLOSE * tolerance(found);
            }
        }
        let tails: Vec<f64> = (0..intervals.len()).map(|variable| grid.tail(variable)).collect();
        let roughest = (0..tails.len()).max_by(|&a, &b| tails[a].total_cmp(&tails[b])).unwrap_or(0);
        if agrees && tails[roughest] <= SETTLED {
            break End::Settled;
        }
        let best =
            [0, 1].map(|which| wanted[which].then(|| search.best(which).map(|best| best.probability.value)).flatten());
        let is_same = |(now, before): (&Option<f64>, &Option<f64>)| match (now, before) {
            (Some(now), Some(before)) => (now - before).abs() <= CLOSE * tolerance(*now),
            (now, before) => now.is_none() == before.is_none(),
        };
        unchanged = if best.iter().zip(&before).all(is_same) { unchanged + 1 } else { 0 };
        before = best;
        match agrees {
            true if unchanged >= UNCHANGED => break End::Unchanged,
            false if unchanged >= UNCHANGED_ANYWAY => break End::Open,
            _ => {}
        }
        if 2 * grid.len() > MOST_POINTS || !grid.refine(roughest) {
            break End::Open;
        }
    };
    if end == End::Open {
        for which in (0..2).filter(|&which| wanted[which]) {
            search.polish(which)?;
        }
    }
    let extreme = |which: usize| wanted[which].then(|| search.best(which)).flatten();
    Ok(Found {
        extremes: [0, 1].map(extreme),
        trends: (0..intervals.len()).map(|variable| trend(&grid, variable)).collect(),
        agrees: end != End::Open,
        evaluations: search.computed.len() as u64,
    })
}

impl<E, F: FnMut(&[f64]) -> Result<ExactProbability, E>> Search<'_, F> {
    /// The value of a quantity at a variable from -1 to 1.
    fn value(&self, quantity: usize, x: f64) -> f64 {
        let [low, high] = self.intervals[quantity];
        if x <= -1.0 {
            low
        } else if x >= 1.0 {
            high
        } else {
            let share = 0.5 * (x + 1.0);
            let is_wide = low > 0.0 && high >= LEAST_RATIO * low;
            let value =
                if is_wide { low * libm::exp(share * libm::log(high / low)) } else { low + share * (high - low) };
            value.clamp(low, high)
        }
    }

    /// The reliability index at a point.
    fn index(&mut self, at: &[f64]) -> Result<f64, E> {
        let values: Vec<f64> = at.iter().enumerate().map(|(quantity, &x)| self.value(quantity, x)).collect();
        let bits: Vec<u64> = values.iter().map(|value| value.to_bits()).collect();
        let found = match self.places.get(&bits) {
            Some(&place) => self.computed[place].1,
            None => {
                let found = (self.probability)(&values)?;
                self.places.insert(bits, self.computed.len());
                self.computed.push((values, found));
                found
            }
        };
        Ok(-normal::quantile(found.value.clamp(INTERPOLATED[0], INTERPOLATED[1])))
    }

    /// The best of all points.
    fn best(&self, which: usize) -> Option<Extreme> {
        let key = |(_, found): &&(Vec<f64>, ExactProbability)| SIGNS[which] * -found.value;
        // Of equal ones the first.
        let best = self.computed.iter().min_by(|a, b| key(a).total_cmp(&key(b)))?;
        Some(Extreme { at: best.0.clone(), probability: best.1, bound: None })
    }

    /// Seeks on from the best point, one quantity after the other, with the probability itself.
    fn polish(&mut self, which: usize) -> Result<(), E> {
        let Some(best) = self.best(which) else { return Ok(()) };
        let mut at: Vec<f64> =
            (0..self.intervals.len()).map(|quantity| self.variable(quantity, best.at[quantity])).collect();
        for width in [0.25, 0.05] {
            for variable in 0..at.len() {
                let [from, to] = [at[variable] - width, at[variable] + width].map(|x| x.clamp(-1.0, 1.0));
                let mut value = |x: f64| {
                    let mut point = at.clone();
                    point[variable] = x;
                    self.index(&point).map(|index| SIGNS[which] * index)
                };
                let (x, found) = golden(&mut value, from, to)?;
                if found < value(at[variable])? {
                    at[variable] = x;
                }
            }
        }
        Ok(())
    }

    /// The variable of a value, to about rounding.
    fn variable(&self, quantity: usize, value: f64) -> f64 {
        let (mut from, mut to) = (-1.0, 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (from + to);
            if self.value(quantity, middle) < value { from = middle } else { to = middle }
        }
        to
    }
}

/// Where the interpolation is most extreme, from several starts.
fn candidates(grid: &Interpolation, which: usize) -> Vec<Vec<f64>> {
    let height = |at: &[f64]| SIGNS[which] * grid.at(at);
    let mut starts: Vec<(f64, Vec<f64>)> = grid
        .points()
        .iter()
        .map(|point| point.iter().map(|&index| node(index)).collect::<Vec<f64>>())
        .map(|at| (height(&at), at))
        .collect();
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut best: Option<(f64, Vec<f64>)> = None;
    for (_, start) in starts.into_iter().take(STARTS) {
        let mut at = start;
        for _ in 0..ROUNDS {
            let before = at.clone();
            for variable in 0..at.len() {
                let mut value = |x: f64| -> Result<f64, std::convert::Infallible> {
                    let mut point = at.clone();
                    point[variable] = x;
                    Ok(height(&point))
                };
                let look = |i: usize| if i == LOOKS { 1.0 } else { -1.0 + 2.0 * i as f64 / LOOKS as f64 };
                let mut looked: Vec<(f64, f64)> = Vec::new();
                for i in 0..=LOOKS {
                    let Ok(found) = value(look(i));
                    looked.push((look(i), found));
                }
                let lowest = (0..=LOOKS).min_by(|&a, &b| looked[a].1.total_cmp(&looked[b].1)).unwrap_or(0);
                let ends = [lowest.saturating_sub(1), (lowest + 1).min(LOOKS)].map(|i| looked[i].0);
                let Ok(found) = golden(&mut value, ends[0], ends[1]);
                let Ok(here) = value(at[variable]);
                for (x, found) in [looked[lowest], found] {
                    if found < here && found < height(&at) {
                        at[variable] = x;
                    }
                }
            }
            if at == before {
                break;
            }
        }
        let found = height(&at);
        if best.as_ref().is_none_or(|(height, _)| found < *height) {
            best = Some((found, at));
        }
    }
    best.into_iter().map(|(_, at)| at).collect()
}

/// Where a function is least between two ends, by golden sections.
fn golden<E>(f: &mut impl FnMut(f64) -> Result<f64, E>, mut from: f64, mut to: f64) -> Result<(f64, f64), E> {
    let mut inner = [to - GOLDEN * (to - from), from + GOLDEN * (to - from)];
    let mut heights = [f(inner[0])?, f(inner[1])?];
    for _ in 0..STEPS {
        if heights[0] < heights[1] {
            to = inner[1];
            inner = [to - GOLDEN * (to - from), inner[0]];
            heights = [f(inner[0])?, heights[0]];
        } else {
            from = inner[0];
            inner = [inner[1], from + GOLDEN * (to - from)];
            heights = [heights[1], f(inner[1])?];
        }
    }
    Ok(if heights[0] < heights[1] { (inner[0], heights[0]) } else { (inner[1], heights[1]) })
}

/// What the probability does along a quantity, at the points of the grid.
fn trend(grid: &Interpolation, variable: usize) -> Trend {
    let mut left = Trend::all();
    for line in grid.lines(variable) {
        for pair in line.windows(2) {
            // A larger index is a smaller probability.
            let change = if (pair[1] - pair[0]).abs() <= ROUNDING { 0.0 } else { pair[0] - pair[1] };
            left.retain(|direction| direction.allows([change; 2]));
        }
    }
    Trend::from_directions(&left, false)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::imprecise::result::Direction;
    use std::convert::Infallible;

    fn found(intervals: &[[f64; 2]], f: impl Fn(&[f64]) -> f64) -> Found {
        let probability = |at: &[f64]| Ok::<_, Infallible>(ExactProbability { value: f(at), error_bound: 0.0 });
        let Ok(found) = extremes(intervals, [true; 2], probability);
        found
    }

    #[test]
    fn an_extreme_inside_is_found_between_the_points() {
        let f = |at: &[f64]| normal::upper_tail(2.0 + 3.0 * (at[0] - 0.437).powi(2) - 0.5 * at[1]);
        let found = found(&[[0.1, 0.9], [-0.5, 0.5]], f);
        let [least, most] = found.extremes.map(Option::unwrap);
        assert!((most.at[0] - 0.437).abs() < 1e-3 && most.at[1] == 0.5, "{most:?}");
        assert_eq!(least.at, [0.9, -0.5]);
        assert!(found.agrees && found.evaluations < 60, "{}", found.evaluations);
        assert_eq!(found.trends[0].direction, Direction::Turns);
        assert_eq!(found.trends[1], Trend { direction: Direction::Rises, is_proved: false });
    }

    #[test]
    fn a_kink_is_searched_for_with_the_probability_itself() {
        let found = found(&[[0.0, 1.0]], |at| 0.3 - 0.2 * (at[0] - 0.613).abs());
        let [_, most] = found.extremes.map(Option::unwrap);
        assert!((most.probability.value - 0.3).abs() < 1e-6, "{most:?}");
        assert!(!found.agrees);
    }

    #[test]
    fn probabilities_of_zero_and_one_are_no_obstacle() {
        let found = found(&[[1.0, 2.0]], |at| if at[0] < 1.5 { 0.0 } else { 1.0 });
        let [least, most] = found.extremes.map(Option::unwrap);
        assert_eq!((least.probability.value, most.probability.value), (0.0, 1.0));
        assert_eq!(found.trends[0].direction, Direction::Rises);
    }
}
