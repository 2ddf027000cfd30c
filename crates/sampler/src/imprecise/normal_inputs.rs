//! The least and the greatest probability over the standard deviations of normal, independent inputs, with a proof.
//!
//! The standard deviations are divided into boxes. On each the probability is a polynomial up to a known remainder (the
//! module `expansion`), whose extremes are bounded (the module `bernstein`). A box that may contain a more extreme value
//! than the best one found is halved, until none may by more than the tolerance.

use stickslip_core::model::pair_boundary::PairBoundary;

use super::bernstein::{Least, Patch};
use super::expansion::{Coefficients, ROUNDING, TERMS, expansion, remainder};
use super::result::{Direction, Extreme, Trend};
use super::tolerance::tolerance;
use crate::integrate::{NormalPair, closed_form};

/// Half the width of the boxes to begin with, in logarithms.
const FIRST_HALF_WIDTH: f64 = 0.3;

/// Boxes at most. More are needed only for an interval over many powers of ten.
const MOST_BOXES: usize = 1000;

/// The relative standard deviations of the first and the second input: each one value, or an interval with a positive
/// lower end.
#[derive(Debug, Clone, Copy)]
pub struct StdIntervals(pub [[f64; 2]; 2]);

/// What was found.
#[derive(Debug, Clone)]
pub struct Found {
    /// The least and the greatest probability, each at two standard deviations; in their order, those that are wanted.
    pub extremes: [Option<Extreme>; 2],
    /// How the probability changes with the standard deviation of the first input, and of the second.
    pub trends: [Trend; 2],
    /// Probabilities that were integrated.
    pub evaluations: u64,
}

/// A part of the intervals, in logarithms.
struct Part {
    ends: [[f64; 2]; 2],
    /// The polynomial, in variables from -1 to 1.
    scaled: Coefficients,
    remainder: f64,
    /// The extremes of the polynomial: the least value, and the least one of its opposite.
    extremes: [Option<Least>; 2],
}

/// Least gain for which a place between the ends is given in place of an end.
const WORTHWHILE: f64 = 1e-9;

/// Share of the tolerance that the boxes may leave open; the rest is for an end that is given in place of them.
const SHARE: f64 = 0.9;

/// Which extreme: 1 for the least, -1 for the greatest.
const SIGNS: [f64; 2] = [1.0, -1.0];

/// The search over the standard deviations.
struct Search<'a> {
    boundary: &'a PairBoundary,
    inputs: &'a NormalPair,
    intervals: StdIntervals,
    wanted: [bool; 2],
    evaluations: u64,
}

/// The least probability, the greatest, or both, as `wanted` says. Of `inputs` only the expected values matter.
///
/// # Errors
/// That of `go_on`, which is asked before every integral.
pub fn extremes<E>(
    boundary: &PairBoundary,
    inputs: &NormalPair,
    intervals: StdIntervals,
    wanted: [bool; 2],
    mut go_on: impl FnMut() -> Result<(), E>,
) -> Result<Found, E> {
    let mut search = Search { boundary, inputs, intervals, wanted, evaluations: 0 };
    let mut parts = Vec::new();
    for first in search.divided(0) {
        for second in search.divided(1) {
            go_on()?;
            parts.push(search.part([first, second]));
        }
    }
    for which in (0..2).filter(|&which| wanted[which]) {
        while let Some(open) = open_part(&parts, which) {
            if parts.len() >= MOST_BOXES {
                break;
            }
            let Part { ends, .. } = parts.swap_remove(open);
            let width = |along: usize| ends[along][1] - ends[along][0];
            let along = usize::from(width(1) > width(0));
            let middle = 0.5 * (ends[along][0] + ends[along][1]);
            for half in [[ends[along][0], middle], [middle, ends[along][1]]] {
                go_on()?;
                let mut ends = ends;
                ends[along] = half;
                parts.push(search.part(ends));
            }
        }
    }
    let mut extremes = [None, None];
    for which in (0..2).filter(|&which| wanted[which]) {
        go_on()?;
        extremes[which] = Some(search.extreme(&parts, which));
    }
    let trends = [0, 1].map(|along| search.trend(&parts, along));
    Ok(Found { extremes, trends, evaluations: search.evaluations })
}

/// The part that may contain a value beyond the best one by more than the tolerance, if there is one: that which may
/// most.
fn open_part(parts: &[Part], which: usize) -> Option<usize> {
    let bound = |part: &Part| part.extremes[which].map_or(f64::INFINITY, |least| least.bound - part.remainder);
    let value = |part: &Part| part.extremes[which].map_or(f64::INFINITY, |least| least.value + part.remainder);
    let best = parts.iter().map(value).fold(f64::INFINITY, f64::min);
    let open = (0..parts.len()).min_by(|&a, &b| bound(&parts[a]).total_cmp(&bound(&parts[b])))?;
    (best - bound(&parts[open]) > SHARE * tolerance(best.abs())).then_some(open)
}

impl Search<'_> {
    /// Whether a standard deviation is an interval.
    fn varies(&self, along: usize) -> bool {
        let [low, high] = self.intervals.0[along];
        low < high
    }

    /// The logarithms of an interval, divided evenly.
    fn divided(&self, along: usize) -> Vec<[f64; 2]> {
        if !self.varies(along) {
            return vec![[0.0; 2]];
        }
        let [low, high] = self.intervals.0[along].map(libm::log);
        let parts = ((high - low) / (2.0 * FIRST_HALF_WIDTH)).ceil().max(1.0) as usize;
        let end = |i: usize| if i == parts { high } else { low + (high - low) * (i as f64 / parts as f64) };
        (0..parts).map(|i| [end(i), end(i + 1)]).collect()
    }

    /// The standard deviation of a logarithm; the ends are those that were given.
    fn std(&self, along: usize, logarithm: f64) -> f64 {
        let [low, high] = self.intervals.0[along];
        if !self.varies(along) || logarithm <= libm::log(low) {
            low
        } else if logarithm >= libm::log(high) {
            high
        } else {
            libm::exp(logarithm).clamp(low, high)
        }
    }

    fn inputs_at(&self, logarithms: [f64; 2]) -> NormalPair {
        NormalPair { relative_std: [0, 1].map(|along| self.std(along, logarithms[along])), ..*self.inputs }
    }

    fn part(&mut self, ends: [[f64; 2]; 2]) -> Part {
        self.evaluations += 1;
        let half_widths = ends.map(|[from, to]| 0.5 * (to - from));
        let mut scaled = expansion(self.boundary, &self.inputs_at(ends.map(|[from, to]| 0.5 * (from + to))));
        let mut of_row = 1.0;
        for row in &mut scaled {
            let mut factor = of_row;
            for coefficient in row.iter_mut() {
                *coefficient *= factor;
                factor *= half_widths[1];
            }
            of_row *= half_widths[0];
        }
        let remainder = remainder(half_widths, [0, 0], self.boundary.is_unstable_above());
        let extremes = [0, 1].map(|which| {
            self.wanted[which].then(|| {
                let signed = scaled.map(|row| row.map(|coefficient| SIGNS[which] * coefficient));
                Patch::new(&signed).least(0.1 * remainder.max(tolerance(0.0)))
            })
        });
        Part { ends, scaled, remainder, extremes }
    }

    /// The best of the extremes of the polynomials and of the corners.
    fn extreme(&mut self, parts: &[Part], which: usize) -> Extreme {
        let sign = SIGNS[which];
        let bound = |part: &Part| part.extremes[which].map_or(f64::INFINITY, |least| least.bound - part.remainder);
        let value = |part: &Part| part.extremes[which].map_or(f64::INFINITY, |least| least.value);
        let bound = parts.iter().map(bound).fold(f64::INFINITY, f64::min);
        let best = parts.iter().min_by(|a, b| value(a).total_cmp(&value(b)));
        let interior = best.and_then(|part| part.extremes[which].map(|least| (part, least.at)));
        // The polynomials do not distinguish very small probabilities: corners come first.
        let mut candidates: Vec<[f64; 2]> = Vec::new();
        for first in self.intervals.0[0] {
            candidates.extend(self.intervals.0[1].map(|second| [first, second]));
        }
        candidates.extend(interior.map(|(part, at)| {
            [0, 1].map(|along| {
                let [from, to] = part.ends[along];
                let logarithm = if at[along] == 1.0 { to } else { from + 0.5 * (at[along] + 1.0) * (to - from) };
                self.std(along, logarithm)
            })
        }));
        let mut found: Option<Extreme> = None;
        for (i, &at) in candidates.iter().enumerate() {
            if candidates[..i].contains(&at) {
                continue;
            }
            self.evaluations += 1;
            let probability = closed_form::probability(self.boundary, &NormalPair { relative_std: at, ..*self.inputs });
            // Where it is the same up to rounding, an end says more than a place between.
            let least = if i < 4 { 0.0 } else { WORTHWHILE };
            let gain = |found: &Extreme| sign * (found.probability.value - probability.value);
            if found.as_ref().is_none_or(|found| gain(found) > least) {
                found = Some(Extreme { at: at.to_vec(), probability, bound: None });
            }
        }
        let mut found = found.unwrap_or_else(Extreme::unknown);
        let bound = (sign * bound).clamp(0.0, 1.0);
        let beyond = sign * (found.probability.value - bound);
        if beyond <= tolerance(found.probability.value) {
            // The bound of the polynomials may lie on this side by rounding.
            let value = found.probability.value;
            found.bound = Some(if beyond > 0.0 { bound } else { value });
        }
        found
    }

    /// How the probability changes with a standard deviation.
    fn trend(&self, parts: &[Part], along: usize) -> Trend {
        if !self.varies(along) {
            return Trend { direction: Direction::Constant, is_proved: true };
        }
        let by = if along == 0 { [1, 0] } else { [0, 1] };
        let (mut proved, mut seen) = (Trend::all(), Trend::all());
        for part in parts {
            let half_widths = part.ends.map(|[from, to]| 0.5 * (to - from));
            let derivative = derivative(&part.scaled, along);
            let patch = Patch::new(&derivative);
            let [low, high] = patch.bounds();
            let rest = half_widths[along] * remainder(half_widths, by, self.boundary.is_unstable_above());
            proved.retain(|direction| direction.allows([low - rest, high + rest]));
            // At the centre and at the corners, where it is not so known.
            seen.retain(|direction| direction.allows([derivative[0][0]; 2].map(without_rounding)));
            for corner in patch.corners() {
                seen.retain(|direction| direction.allows([corner + rest, corner - rest]));
            }
        }
        match Trend::from_directions(&proved, true) {
            Trend { direction: Direction::Turns, .. } => Trend::from_directions(&seen, false),
            trend => trend,
        }
    }
}

/// A derivative, or zero where it is rounding.
fn without_rounding(derivative: f64) -> f64 {
    if derivative.abs() <= ROUNDING { 0.0 } else { derivative }
}

/// The derivative of a polynomial.
fn derivative(scaled: &Coefficients, along: usize) -> Coefficients {
    let mut derivative = [[0.0; TERMS]; TERMS];
    for i in 0..TERMS {
        for j in 0..TERMS {
            match (along, i, j) {
                (0, 1.., _) => derivative[i - 1][j] = i as f64 * scaled[i][j],
                (1, _, 1..) => derivative[i][j - 1] = j as f64 * scaled[i][j],
                _ => {}
            }
        }
    }
    derivative
}

#[cfg(test)]
mod tests;
