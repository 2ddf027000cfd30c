//! The least and the greatest probability of one cell over all its imprecise quantities.

use stickslip_core::model::pair_boundary::PairBoundary;

use super::normal_inputs::{self, StdIntervals};
use super::result::{Direction, Evidence, Extreme, Trend};
use super::search;
use crate::integrate::NormalPair;
use crate::integrate::closed_form::ExactProbability;

/// What is known of a quantity before anything is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// The probability never falls as it grows: an expected value.
    Rising,
    /// The relative standard deviation of the first input (0) or of the second (1).
    RelativeStd(usize),
    /// Nothing is known.
    Unknown,
}

/// A quantity that is known as an interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quantity {
    /// What is known of it.
    pub role: Role,
    /// Its ends, of which the first is less.
    pub interval: [f64; 2],
}

/// The probability of a cell as a function of its imprecise quantities.
pub trait Family {
    /// Why a probability cannot be computed.
    type Error;

    /// The probability at values of the quantities.
    ///
    /// # Errors
    /// If there is none.
    fn probability(&self, at: &[f64]) -> Result<ExactProbability, Self::Error>;

    /// The boundary and the two inputs at values of the quantities, if these inputs are normal and independent whatever
    /// the values.
    ///
    /// # Errors
    /// As [`Family::probability`].
    fn normal_pair(&self, at: &[f64]) -> Result<Option<(PairBoundary, NormalPair)>, Self::Error>;
}

/// The least and the greatest probability.
#[derive(Debug, Clone)]
pub struct Bounds {
    /// The least and the greatest.
    pub extremes: [Extreme; 2],
    /// How far each is certain.
    pub evidence: [Evidence; 2],
    /// What the probability does along each quantity.
    pub trends: Vec<Trend>,
    /// Probabilities that were integrated.
    pub evaluations: u64,
}

/// Finds the bounds of a cell.
///
/// # Errors
/// The first error of the family.
pub fn bounds<F: Family>(family: &F, quantities: &[Quantity]) -> Result<Bounds, F::Error> {
    let is_open = |quantity: &Quantity| quantity.role != Role::Rising;
    let open: Vec<usize> = (0..quantities.len()).filter(|&i| is_open(&quantities[i])).collect();
    // The other quantities are at their lower ends for the least, and at their upper ends for the greatest probability.
    let ends = [0, 1].map(|end| quantities.iter().map(|quantity| quantity.interval[end]).collect::<Vec<f64>>());
    let search = Sides { family, quantities, open: &open };
    let [lower, upper] = if open.len() == quantities.len() {
        let both = search.side(&ends[0], [true; 2])?;
        let upper = Side { evaluations: 0, ..both.clone() };
        [both, upper]
    } else {
        [search.side(&ends[0], [true, false])?, search.side(&ends[1], [false, true])?]
    };
    let mut trends = vec![Trend { direction: Direction::Rises, is_proved: true }; quantities.len()];
    for (place, &quantity) in open.iter().enumerate() {
        let [first, second] = [lower.trends[place], upper.trends[place]];
        let is_same = open.len() == quantities.len();
        let direction = if first.direction == second.direction { first.direction } else { Direction::Turns };
        // Between the ends of the other quantities nothing is known of it.
        trends[quantity] = Trend { direction, is_proved: is_same && first.is_proved };
    }
    let evaluations = lower.evaluations + upper.evaluations;
    let evidence = [lower.evidence[0], upper.evidence[1]];
    let ([least, _], [_, most]) = (lower.extremes, upper.extremes);
    let extremes = [least, most].map(|extreme| extreme.unwrap_or_else(Extreme::unknown));
    Ok(Bounds { extremes, evidence, trends, evaluations })
}

/// The search for extremes over the open quantities.
struct Sides<'a, F> {
    family: &'a F,
    quantities: &'a [Quantity],
    open: &'a [usize],
}

/// What was found with the other quantities at some ends.
#[derive(Debug, Clone)]
struct Side {
    extremes: [Option<Extreme>; 2],
    evidence: [Evidence; 2],
    trends: Vec<Trend>,
    evaluations: u64,
}

impl<F: Family> Sides<'_, F> {
    /// The extremes that are wanted, with the quantities that are not open at `ends`.
    fn side(&self, ends: &[f64], wanted: [bool; 2]) -> Result<Side, F::Error> {
        if self.open.is_empty() {
            let probability = self.family.probability(ends)?;
            let extreme = Extreme { at: ends.to_vec(), probability, bound: Some(probability.value) };
            let extremes = wanted.map(|wanted| wanted.then(|| extreme.clone()));
            return Ok(Side { extremes, evidence: [Evidence::Proved; 2], trends: Vec::new(), evaluations: 1 });
        }
        if self.open.iter().all(|&i| self.has_expansion(i))
            && let Some((boundary, inputs)) = self.family.normal_pair(ends)?
        {
            return self.proved(&boundary, &inputs, ends, wanted);
        }
        self.searched(ends, wanted)
    }

    /// Whether the probability is a polynomial of a quantity, up to a remainder.
    fn has_expansion(&self, quantity: usize) -> bool {
        let Quantity { role, interval } = self.quantities[quantity];
        matches!(role, Role::RelativeStd(_)) && interval[0] > 0.0
    }

    fn proved(
        &self,
        boundary: &PairBoundary,
        inputs: &NormalPair,
        ends: &[f64],
        wanted: [bool; 2],
    ) -> Result<Side, F::Error> {
        let mut intervals = inputs.relative_std.map(|std| [std; 2]);
        let along = |quantity: usize| usize::from(self.quantities[quantity].role == Role::RelativeStd(1));
        for &quantity in self.open {
            intervals[along(quantity)] = self.quantities[quantity].interval;
        }
        let go_on = || self.family.normal_pair(ends).map(|_| ());
        let found = normal_inputs::extremes(boundary, inputs, StdIntervals(intervals), wanted, go_on)?;
        let placed = |extreme: Extreme| {
            let mut at = ends.to_vec();
            for &quantity in self.open {
                at[quantity] = extreme.at[along(quantity)];
            }
            Extreme { at, ..extreme }
        };
        let extremes = found.extremes.map(|extreme| extreme.map(placed));
        let evidence = |extreme: &Option<Extreme>| match extreme {
            Some(Extreme { bound: Some(_), .. }) => Evidence::Proved,
            _ => Evidence::Searched,
        };
        let evidence = [0, 1].map(|which| evidence(&extremes[which]));
        let trends = self.open.iter().map(|&quantity| found.trends[along(quantity)]).collect();
        Ok(Side { extremes, evidence, trends, evaluations: found.evaluations })
    }

    fn searched(&self, ends: &[f64], wanted: [bool; 2]) -> Result<Side, F::Error> {
        let intervals: Vec<[f64; 2]> = self.open.iter().map(|&i| self.quantities[i].interval).collect();
        let placed = |open: &[f64]| {
            let mut at = ends.to_vec();
            self.open.iter().zip(open).for_each(|(&quantity, value)| at[quantity] = *value);
            at
        };
        let found = search::extremes(&intervals, wanted, |open| self.family.probability(&placed(open)))?;
        let evidence = [0, 1].map(|which| {
            let Some(extreme) = &found.extremes[which] else { return Evidence::Searched };
            let is_there = |((trend, interval), value): ((&Trend, &[f64; 2]), &f64)| match trend.direction {
                Direction::Rises => interval[which] == *value,
                Direction::Falls => interval[1 - which] == *value,
                Direction::Constant => true,
                Direction::Turns => false,
            };
            let are_there = found.trends.iter().zip(&intervals).zip(&extreme.at).all(is_there);
            if found.agrees && are_there { Evidence::Checked } else { Evidence::Searched }
        });
        let extremes =
            found.extremes.map(|extreme| extreme.map(|extreme| Extreme { at: placed(&extreme.at), ..extreme }));
        Ok(Side { extremes, evidence, trends: found.trends, evaluations: found.evaluations })
    }
}

#[cfg(test)]
mod tests;
