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
    /// Cells whose samples are the same ones beside each other: what one of them finds serves all.
    cells: Vec<u64>,
    /// How many such cells there are of each sample.
    alike: u64,
    order: Spread,
    /// The number of parts that are tried, of one of such cells.
    count: u64,
    /// The number of parts of a cell that are tried: with looks, those up to the first.
    of_a_cell: u64,
    /// The number of samples of a part, and the largest one at once.
    samples: u64,
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
    /// Seconds in which each configuration was set up that was not before.
    pub(super) set_ups: Vec<f64>,
    /// Seconds in which they were evaluated, in all cells that have them.
    pub(super) seconds: f64,
    /// What they gave in each of these cells; `None` if they were stopped before.
    pub(super) units: Option<Vec<FinishedUnit>>,
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
        let mut cells: Vec<u64> = (0..parts.cells()).collect();
        let alike = evaluator.job().cells_of_a_stream();
        if alike > 1 {
            cells.sort_by_cached_key(|&cell| evaluator.job().stream_of(cell));
        }
        let count = parts.cells() / alike * of_a_cell;
        let samples = parts.max_samples(0).max(1);
        let most = samples.min(unit);
        let (order, set_up) = (Spread::over(count), Mutex::default());
        Self { evaluator, parts, are_audits, cells, alike, order, count, of_a_cell, samples, most, set_up }
    }

    /// Largest number of samples of a part at once.
    pub(super) fn most(&self) -> u64 {
        self.most
    }

    /// How many samples there are in all.
    pub(super) fn total(&self) -> f64 {
        self.samples as f64 * self.count as f64 * self.alike as f64
    }

    /// The samples of one turn: their cells, their place among the parts of each, and their range.
    fn of_turn(&self, turn: u64, samples: u64) -> (&[u64], u64, Range<u64>) {
        let place = self.order.at(turn % self.count).unwrap_or(0);
        let first_cell = (place / self.of_a_cell * self.alike) as usize;
        let cells = &self.cells[first_cell..first_cell + self.alike as usize];
        // Samples from anywhere in the part. Those of common random numbers are the same in all cells.
        let first = ((turn as f64 * GOLDEN_SECTION).fract() * (self.samples - samples + 1) as f64) as u64;
        (cells, place % self.of_a_cell, first..first + samples)
    }

    /// The samples of one turn in the first of their cells: their part and range.
    pub(super) fn at(&self, turn: u64, samples: u64) -> (u64, Range<u64>) {
        let (cells, place, samples) = self.of_turn(turn, samples);
        (self.parts.in_cell(cells[0]).start + place, samples)
    }

    fn count(&self, part: u64, samples: Range<u64>, is_stopped: IsStopped<'_>) -> Option<FinishedUnit> {
        match self.are_audits {
            true => self.evaluator.audit_integral(part, samples, is_stopped),
            false => self.evaluator.count(part, samples, is_stopped),
        }
    }

    /// The first cell of a turn.
    pub(super) fn cell(&self, turn: u64) -> u64 {
        self.of_turn(turn, 1).0[0]
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
        let (cells, place, samples) = self.of_turn(turn, samples);
        let new = cells.iter().filter(|&&cell| self.is_first_in(cell));
        let set_ups = new.filter_map(|&cell| self.set_up_in(cell, is_stopped).map(Twice::set_up)).collect();
        let begun = Instant::now();
        let units = cells.iter().map(|&cell| {
            let part = self.parts.in_cell(cell).start + place;
            self.count(part, samples.clone(), is_stopped)
        });
        let units = units.collect();
        Tried { set_ups, seconds: begun.elapsed().as_secs_f64(), units }
    }

    /// How many cells the samples of a turn count in.
    pub(super) fn alike(&self) -> u64 {
        self.alike
    }

    /// How many samples take the time of a batch, and how long each took, in all its cells, of those that were tried in the
    /// first place; `None` if not even one was finished.
    pub(super) fn samples_of_a_batch(&self, is_stopped: IsStopped<'_>) -> Option<(u64, f64)> {
        let mut found = None;
        let mut samples = 1;
        let started = Instant::now();
        for turn in 0.. {
            let mut quickest = f64::INFINITY;
            for more in 0..TRIES {
                // Always in the first place, where everything is set up.
                let tried = self.tried(self.count * (TRIES * turn + more), samples, is_stopped);
                if tried.units.is_some() {
                    quickest = quickest.min(tried.seconds);
                }
                if tried.units.is_none() || tried.seconds > BATCH.as_secs_f64() {
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

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;
    use crate::job::JobSource;

    const JOB: &str = r#"
name = "places"
[model]
kind = "matrices"
mass = { matrix = [[1, 0], [0, 1]] }
damping = { matrix = [[0.01, 0], [0, 0.01]] }
stiffness = [{ matrix = [[2, 1], [1, 2]] }, { matrix = [[0, -1], [0, 0]], factor = "friction" }]
[model.parameters]
friction = 0.7
[axes]
friction = [0.5, 0.7]
[random]
inputs = ["friction"]
relative_std = 0.1
[criterion]
kind = "complex-eigenvalue"
bands = [[0.01, 0.2], [0.2, 0.3]]
[sampling]
samples = 100_000
"#;

    /// Cells that differ by band alone have the same samples, which serve all of them in a run: so they do in a trial.
    #[test]
    fn samples_that_cells_share_are_tried_in_all_of_them_and_come_from_the_whole_job() {
        let job = JobSource { path: PathBuf::from("job.toml"), text: JOB.to_owned() }.job().unwrap();
        let evaluator = Evaluator::new(&job).unwrap();
        let places = Places::of_samples(&evaluator);
        // Two bands, and their union.
        assert_eq!((job.cells(), places.alike()), (6, 3));
        assert!((places.total() - 600_000.0).abs() < 0.5);
        let streams = |turn| {
            let (cells, place, _) = places.of_turn(turn, 10);
            assert_eq!((cells.len(), place), (3, 0));
            let streams: HashSet<u64> = cells.iter().map(|&cell| job.stream_of(cell)).collect();
            assert_eq!(streams.len(), 1, "{cells:?}");
            streams.into_iter().next().unwrap()
        };
        assert_ne!(streams(0), streams(1));
        let firsts: HashSet<u64> = (0..100).map(|turn| places.of_turn(turn, 10).2.start / 1000).collect();
        assert!(firsts.len() > 50, "{firsts:?}");
        assert!((0..100).all(|turn| places.of_turn(turn, 10).2.end <= 100_000));
        let tried = places.tried(1, 10, &|| false);
        let units = tried.units.unwrap();
        assert_eq!(units.iter().map(FinishedUnit::len).collect::<Vec<_>>(), [10; 3]);
        assert_eq!(units.iter().map(|unit| unit.part).collect::<HashSet<u64>>().len(), 3);
    }
}
