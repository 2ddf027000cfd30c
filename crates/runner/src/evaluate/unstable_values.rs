//! The unstable values of the one random input that integrals go over, found once for all cells that differ in its
//! distribution alone.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use stickslip_core::model::critical_values::{Memory, UnstableValues};
use stickslip_sampler::estimate::interval::Estimate;
use stickslip_sampler::grid::Cell;
use stickslip_sampler::inputs::DeviateLaw;
use stickslip_sampler::integrate::closed_form::ExactProbability;
use stickslip_sampler::integrate::one_input;

use crate::job::Job;

/// The bits of the expected values of all other quantities.
type Key = Vec<u64>;

/// What is found for a combination of the other quantities; nothing if it cannot be.
type Found = Arc<OnceLock<Option<UnstableValues>>>;

/// Unstable values, once they are found.
#[derive(Debug, Default)]
pub struct UnstableValuesOfInput {
    found: Mutex<BTreeMap<Key, Found>>,
}

impl UnstableValuesOfInput {
    /// The probability of instability in a cell of a job over the input that is the quantity at `place`, which alone scatters.
    /// Its expected value may be any within its axis. Nothing is known if its critical values cannot be found, or if `memory`
    /// ends the search; between two bounds that are far apart there is no probability.
    pub fn estimate(&self, job: &Job, cell: &Cell, place: usize, memory: &dyn Memory) -> Estimate {
        match self.probability(job, cell, place, memory) {
            Some(found) => {
                let [low, high] = found.bounds();
                Estimate { probability: found.is_resolved().then_some(found.value), low, high }
            }
            None => Estimate { probability: None, low: 0.0, high: 1.0 },
        }
    }

    /// The search for these values of the other quantities is made once, with `memory`; one memory may serve several in a row.
    fn probability(&self, job: &Job, cell: &Cell, place: usize, memory: &dyn Memory) -> Option<ExactProbability> {
        let position = job.random.position(place)?;
        let mut expected = cell.expected.clone();
        expected[place] = 0.0;
        let key = expected.iter().map(|value| value.to_bits()).collect();
        let found = self.found.lock().unwrap_or_else(PoisonError::into_inner).entry(key).or_default().clone();
        let unstable = found.get_or_init(|| {
            let configuration = job.model().configure(&cell.expected, &[place], None).ok()?;
            configuration.critical_values()?.unstable(&[cell.expected[place]], 0, &places(job, position), memory)
        });
        let distribution = job.distribution(position, cell);
        Some(one_input::probability(&distribution, DeviateLaw::INDEPENDENT, unstable.as_ref()?))
    }
}

/// Where a search begins for all cells: with each of the input's expected values and standard deviations.
fn places(job: &Job, position: usize) -> Vec<f64> {
    let place = job.random.inputs[position];
    let mut cell = job.grid.cell(0);
    let mut all = Vec::new();
    for scatter in 0..job.random.relative_stds.len() {
        for value in job.grid.values_of(place) {
            (cell.expected[place], cell.scatter) = (value, scatter);
            all.push((job.distribution(position, &cell), DeviateLaw::INDEPENDENT));
        }
    }
    one_input::places(&all)
}
