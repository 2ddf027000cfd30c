//! Samples that are drawn and decided once more, to be looked at one by one.

use stickslip_core::model::IsStopped;
use stickslip_core::model::decision::Decision;
use stickslip_core::model::verdict::VerdictCounts;

use crate::evaluate::samples::Samples;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::schedule::engine::{Engine, Outcome};
use crate::schedule::progress::Progress;

/// Consecutive samples, in columns.
#[derive(Default)]
pub struct DrawnSamples {
    /// The values of each random input, in the job's order.
    pub values: Vec<Vec<f64>>,
    pub decisions: Vec<Decision>,
    pub are_outside: Vec<bool>,
}

/// Takes samples with their decisions, and which of them lie outside the model.
pub type Add<'a> = &'a mut dyn FnMut(&Samples, &[Decision], Option<Vec<bool>>);

/// Draws and decides the samples of all units, `total` of them, on so many threads. `of_unit` passes those of one unit on,
/// in order.
///
/// # Errors
/// If it is interrupted.
pub fn draw<U: Sync>(
    units: &[U],
    total: u64,
    threads: usize,
    interrupt: &Interrupt,
    of_unit: impl Fn(&U, IsStopped<'_>, Add<'_>) + Sync,
) -> Result<DrawnSamples, Failure> {
    let mut drawn: Vec<DrawnSamples> = Vec::new();
    drawn.resize_with(units.len(), DrawnSamples::default);
    let mut progress = Progress::new(total.into(), "samples");
    let evaluate = |index: u64, is_stopped: IsStopped<'_>| {
        let mut samples = DrawnSamples::default();
        let mut add = |chunk: &Samples, decisions: &[Decision], outside: Option<Vec<bool>>| {
            samples.add(chunk, decisions, outside);
        };
        of_unit(&units[index as usize], is_stopped, &mut add);
        (index as usize, samples)
    };
    let engine = Engine::new(threads)?;
    let outcome = engine.for_each_in_parallel(units.len() as u64, interrupt, evaluate, |(index, unit)| {
        progress.advance(unit.decisions.len() as u64);
        progress.tick();
        drawn[index] = unit;
    })?;
    progress.finish();
    match outcome {
        Outcome::Finished => Ok(drawn.into_iter().fold(DrawnSamples::default(), DrawnSamples::followed_by)),
        Outcome::Stopped(signal) => Err(Failure::stopped(signal, &"nothing was written".into())),
    }
}

impl DrawnSamples {
    /// Adds the samples of a chunk.
    fn add(&mut self, chunk: &Samples, decisions: &[Decision], outside: Option<Vec<bool>>) {
        self.values.resize(chunk.values(0).count(), Vec::new());
        for sample in 0..decisions.len() {
            self.values.iter_mut().zip(chunk.values(sample)).for_each(|(column, value)| column.push(value));
        }
        self.decisions.extend_from_slice(decisions);
        self.are_outside.extend(outside.unwrap_or_else(|| vec![false; decisions.len()]));
    }

    /// These and those after them.
    fn followed_by(mut self, next: Self) -> Self {
        self.values.resize(next.values.len(), Vec::new());
        for (values, further) in self.values.iter_mut().zip(next.values) {
            values.extend(further);
        }
        self.decisions.extend(next.decisions);
        self.are_outside.extend(next.are_outside);
        self
    }

    pub fn counts(&self) -> VerdictCounts {
        self.decisions.iter().fold(VerdictCounts::default(), |counts, decision| counts + decision.verdict.into())
    }
}
