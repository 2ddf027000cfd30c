//! What a trial tries of a job: some samples of each of many parts, from all over it.

use std::collections::HashSet;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use stickslip_core::model::IsStopped;
use stickslip_sampler::draw::identity::BLOCK_SAMPLES;

use crate::evaluate::evaluator::Evaluator;
use crate::evaluate::parts::Parts;
use crate::evaluate::unit::FinishedUnit;
use crate::schedule::spread::Spread;

/// Time that a batch of samples should take: short, so that there are many from all over the job, but long enough for
/// the vector lanes to be busy.
const BATCH: Duration = Duration::from_millis(25);

/// Longest time in which it is found out how many samples these are.
const LONGEST: Duration = Duration::from_millis(600);

/// Batches of a number of samples of which the quickest counts: a single sample may cost far more than most.
const TRIES: u64 = 3;

/// Multiples of it are spread evenly.
const GOLDEN_SECTION: f64 = 0.618_033_988_749_894_9;

/// The samples of a trial.
pub(super) struct Places<'e, 'j> {
    evaluator: &'e Evaluator<'j>,
    parts: Parts,
    /// Whether they are the audits of a job, plain samples beside its probabilities.
    are_audits: bool,
    order: Spread,
    /// The number of parts that are tried.
    count: u64,
    /// The number of parts of a cell that are tried: with looks, those up to the first.
    of_a_cell: u64,
    /// Largest number of samples of a part at once.
    most: u64,
    /// Configurations that are set up.
    set_up: Mutex<HashSet<usize>>,
}

/// How long one sample took when its configuration had to be set up, and how long the same one took again.
#[derive(Debug, Clone, Copy)]
pub(super) struct Twice {
    first: f64,
    pub(super) again: f64,
}

impl Twice {
    /// Seconds in which the configuration was set up.
    pub(super) fn set_up(self) -> f64 {
        (self.first - self.again).max(0.0)
    }
}

/// Samples that were tried.
pub(super) struct Tried {
    /// Seconds in which their configuration was set up, if it was not before.
    pub(super) set_up: Option<f64>,
    /// Seconds in which they were evaluated.
    pub(super) seconds: f64,
    /// What they gave; `None` if they were stopped before.
    pub(super) unit: Option<FinishedUnit>,
}

impl<'e, 'j> Places<'e, 'j> {
    /// The samples of a job.
    pub(super) fn of_samples(evaluator: &'e Evaluator<'j>) -> Self {
        let unit = evaluator.job().unit_samples();
        Self::new(evaluator, evaluator.parts().clone(), unit, false)
    }

    /// Its audits.
    pub(super) fn of_audits(evaluator: &'e Evaluator<'j>) -> Self {
        let parts = Parts::of_audits(evaluator.job());
        let unit = parts.unit_samples();
        Self::new(evaluator, parts, unit, true)
    }

    fn new(evaluator: &'e Evaluator<'j>, parts: Parts, unit: u64, are_audits: bool) -> Self {
        let of_a_cell = if parts.are_sequential() { 1 } else { parts.of_a_cell() as u64 };
        let count = parts.cells() * of_a_cell;
        let most = parts.max_samples(0).min(unit).max(1);
        let (order, set_up) = (Spread::over(count), Mutex::default());
        Self { evaluator, parts, are_audits, order, count, of_a_cell, most, set_up }
    }

    /// Largest number of samples of a part at once.
    pub(super) fn most(&self) -> u64 {
        self.most
    }

    /// The samples of one turn: their part and range.
    pub(super) fn at(&self, turn: u64, samples: u64) -> (u64, Range<u64>) {
        let place = self.order.at(turn % self.count).unwrap_or(0);
        let part = self.parts.in_cell(place / self.of_a_cell).start + place % self.of_a_cell;
        // Samples from anywhere in the part. Those of common random numbers are the same in all cells.
        let first = ((turn as f64 * GOLDEN_SECTION).fract() * (self.most - samples + 1) as f64) as u64;
        (part, first..first + samples)
    }

    fn count(&self, part: u64, samples: Range<u64>, is_stopped: IsStopped<'_>) -> Option<FinishedUnit> {
        match self.are_audits {
            true => self.evaluator.audit_integral(part, samples, is_stopped),
            false => self.evaluator.count(part, samples, is_stopped),
        }
    }

    /// The cell of a turn.
    pub(super) fn cell(&self, turn: u64) -> u64 {
        self.parts.place(self.at(turn, 1).0).0
    }

    /// Whether nothing was tried before in the configuration of a cell, which is kept once it is set up.
    pub(super) fn is_first_in(&self, cell: u64) -> bool {
        let configuration = match self.evaluator.set_ups() {
            // All are one, or none is kept, so that each evaluation pays for its own.
            1 => 0,
            _ => self.evaluator.job().grid.configuration_index(cell),
        };
        self.set_up.lock().unwrap_or_else(PoisonError::into_inner).insert(configuration)
    }

    /// Sets the configuration of a cell up; `None` if it is stopped before.
    ///
    /// The sample that does so is evaluated again, so that the difference is not one of samples: never for longer than the
    /// first time, so that it is not stopped. It is a plain one, also where samples are searches or integrals, which take
    /// longer.
    pub(super) fn set_up_in(&self, cell: u64, is_stopped: IsStopped<'_>) -> Option<Twice> {
        let seconds = |is_stopped: IsStopped<'_>| {
            let begun = Instant::now();
            match self.evaluator.counts_verdicts() {
                true => self.evaluator.count(self.evaluator.parts().in_cell(cell).start, 0..1, is_stopped)?,
                false => self.evaluator.audit_integral(cell, 0..1, is_stopped)?,
            };
            Some(begun.elapsed().as_secs_f64())
        };
        Some(Twice { first: seconds(is_stopped)?, again: seconds(&|| false)? })
    }

    /// Evaluates the samples of one turn.
    pub(super) fn tried(&self, turn: u64, samples: u64, is_stopped: IsStopped<'_>) -> Tried {
        let cell = self.cell(turn);
        let set_up = match self.is_first_in(cell) {
            true => self.set_up_in(cell, is_stopped).map(Twice::set_up),
            false => None,
        };
        let (part, samples) = self.at(turn, samples);
        let begun = Instant::now();
        let unit = self.count(part, samples, is_stopped);
        Tried { set_up, seconds: begun.elapsed().as_secs_f64(), unit }
    }

    /// How many samples take the time of a batch, and how long each took of those that were tried in the first place;
    /// `None` if not even one was finished.
    pub(super) fn samples_of_a_batch(&self, is_stopped: IsStopped<'_>) -> Option<(u64, f64)> {
        let mut found = None;
        let mut samples = 1;
        let started = Instant::now();
        for turn in 0.. {
            let mut quickest = f64::INFINITY;
            for more in 0..TRIES {
                // Always in the first place, where everything is set up.
                let tried = self.tried(self.count * (TRIES * turn + more), samples, is_stopped);
                if tried.unit.is_some() {
                    quickest = quickest.min(tried.seconds);
                }
                if tried.unit.is_none() || tried.seconds > BATCH.as_secs_f64() {
                    break;
                }
            }
            if quickest.is_infinite() {
                break;
            }
            found = Some((samples, quickest / samples as f64));
            let affordable = samples as f64 * BATCH.as_secs_f64() / quickest.max(1e-9);
            let next = self.most.min(affordable.min(4.0 * samples as f64) as u64).max(1);
            if next <= samples || started.elapsed() >= LONGEST || is_stopped() {
                break;
            }
            samples = next;
        }
        // Whole blocks are drawn fastest.
        let whole = |samples: u64| if samples > BLOCK_SAMPLES { samples - samples % BLOCK_SAMPLES } else { samples };
        found.map(|(samples, seconds)| (whole(samples), seconds))
    }
}
