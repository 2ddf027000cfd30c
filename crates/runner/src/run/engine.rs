//! The computation: units of work on all cores, finished pieces on disk.

use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

use rayon::iter::{IntoParallelIterator as _, ParallelIterator as _};
use rayon::{ThreadPool, ThreadPoolBuilder};
use stickslip_core::{StabilityBoundary, VerdictCounts};
use stickslip_sampler::SampleStream;

use super::directory::RunDirectory;
use super::piece;
use super::plan::Plan;
use super::progress::Progress;
use super::tally::{Segment, Tally};
use crate::failure::{Failure, Signal};
use crate::interrupt::Interrupt;
use crate::job::Job;

/// Segments waiting to be written at the most, whatever the clock says.
const MOST_PENDING: usize = 100_000;

/// How a computation ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Everything planned is counted.
    Finished,
    /// A signal came; what was finished is on disk.
    Stopped(Signal),
}

/// Everything that deciding a sample of a job takes.
pub struct Engine<'a> {
    job: &'a Job,
    stream: SampleStream,
    boundaries: Vec<StabilityBoundary>,
    pool: ThreadPool,
}

impl<'a> Engine<'a> {
    /// Prepares the computation of a job on `threads` threads.
    pub fn new(job: &'a Job, threads: usize) -> Result<Self, Failure> {
        let boundaries = job.boundaries().map_err(|error| Failure::Job(error.to_string()))?;
        let pool = ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|error| Failure::InputOutput(format!("cannot start {threads} threads: {error}")))?;
        Ok(Self { job, stream: job.stream(), boundaries, pool })
    }

    /// Computes one unit. A pure function of its arguments and the job.
    pub fn compute(&self, cell: u64, samples: std::ops::Range<u64>) -> Segment {
        let boundary = &self.boundaries[self.job.grid.rotating_speed_index(cell)];
        let mut counts = VerdictCounts::default();
        self.stream.for_each(&self.job.grid.cell(cell), samples.clone(), |samples| {
            counts += boundary.count(samples.preloads, samples.static_frictions);
        });
        Segment { cell, samples, counts }
    }

    /// Computes everything in `plan`, adds it to `tally` and to the pieces of `directory`.
    ///
    /// Pieces are written as the computation goes, the first soon, later ones less often: a kill loses a tenth of the
    /// time already spent, and never more than ten seconds.
    pub fn run(
        &self,
        plan: &Plan,
        tally: &mut Tally,
        directory: &RunDirectory,
        progress: &mut Progress,
        interrupt: &Interrupt,
    ) -> Result<Outcome, Failure> {
        let (sender, receiver) = mpsc::sync_channel::<Segment>(4096);
        thread::scope(|scope| {
            let worker = scope.spawn(move || {
                self.pool.install(|| {
                    // The first unit that finds a signal, or nobody to send to because writing failed, ends them all.
                    (0..plan.units()).into_par_iter().try_for_each(|index| {
                        let (cell, samples) = plan.unit(index);
                        let go_on = interrupt.signal().is_none();
                        go_on.then(|| sender.send(self.compute(cell, samples)).ok()).flatten()
                    })
                })
            });
            let collected = self.collect(&receiver, tally, directory, progress);
            drop(receiver);
            let panicked = worker.join().is_err();
            collected?;
            if panicked {
                return Err(Failure::InputOutput("a worker thread failed; please report this as a bug".to_owned()));
            }
            Ok(interrupt.signal().map_or(Outcome::Finished, Outcome::Stopped))
        })
    }

    /// Takes finished segments until the workers are done.
    fn collect(
        &self,
        receiver: &Receiver<Segment>,
        tally: &mut Tally,
        directory: &RunDirectory,
        progress: &mut Progress,
    ) -> Result<(), Failure> {
        let (shards, experiment) = (directory.shards(), self.job.experiment_hash());
        let started = Instant::now();
        let mut written = Instant::now();
        let mut pending = Vec::new();
        loop {
            let message = receiver.recv_timeout(Duration::from_millis(50));
            let done = matches!(message, Err(RecvTimeoutError::Disconnected));
            if let Ok(segment) = message {
                progress.advance(segment.len());
                tally.add(&segment);
                pending.push(segment);
            }
            progress.tick();
            let interval = (started.elapsed() / 10).clamp(Duration::from_millis(100), Duration::from_secs(10));
            let due = done || written.elapsed() >= interval || pending.len() >= MOST_PENDING;
            if due && !pending.is_empty() {
                // Units stay apart in a piece: two processes that do the same work write the same segments.
                pending.sort_by_key(|segment| (segment.cell, segment.samples.start));
                piece::write(&shards, &experiment, &pending)?;
                pending.clear();
                written = Instant::now();
            }
            if done {
                return Ok(());
            }
        }
    }
}
