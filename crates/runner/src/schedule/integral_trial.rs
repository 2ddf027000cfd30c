//! The cost of integrals in closed form or over critical values, measured on some cells.

use std::collections::BTreeSet;
use std::time::Instant;

use crate::evaluate::evaluator::Evaluator;
use crate::evaluate::sums::Lookups;
use crate::schedule::cost::{Measured, UnitCost};
use crate::schedule::spread::Spread;
use crate::schedule::trial::{Limits, Trial};

/// What a trial of integrals found.
#[derive(Debug, Clone, Copy)]
pub struct IntegralTrial {
    /// The cost of one.
    pub cost: UnitCost,
    /// How many the job has. Cells that differ in the input alone that an integral goes over share one search.
    pub integrals: usize,
}

/// Finds the probabilities of some cells of a job without verdict maps, evenly spread, on this thread.
pub fn try_integrals(evaluator: &Evaluator<'_>, begun: Instant) -> Trial<IntegralTrial> {
    let (job, limits) = (evaluator.job(), Limits::of(begun));
    let first_like = |cell: u64| match job.integrated() {
        Some(place) => job.grid.first_cell_but_for(place, cell),
        None => cell,
    };
    let searches: Vec<u64> = (0..job.cells()).map(first_like).collect::<BTreeSet<u64>>().into_iter().collect();
    let order = Spread::over(searches.len() as u64);
    let mut measured = Measured::default();
    for turn in 0..searches.len() as u64 {
        // The first one has all the time that there is.
        let is_first = turn == 0;
        let is_late = || if is_first { limits.is_over_at_last() } else { limits.is_over() };
        let Some(place) = order.at(turn).filter(|_| !is_late()) else { break };
        let cell = job.grid.cell(searches[place as usize]);
        let begun = Instant::now();
        let found = evaluator.integrate(&cell, &[], Lookups::default(), &is_late);
        let seconds = begun.elapsed().as_secs_f64();
        if found.is_none() {
            measured.unfinished(seconds);
            break;
        }
        measured.batch(seconds, 1.0);
    }
    let trial = |mut cost: UnitCost| {
        if measured.batches() == searches.len() as u64 {
            cost.error = 0.0;
        }
        IntegralTrial { cost, integrals: searches.len() }
    };
    let what = if job.integrated().is_some() { "search for critical values" } else { "integral" };
    measured.cost().map(trial).ok_or_else(|| limits.unmeasured(what))
}
