//! The computation: units of work on all cores, finished pieces on disk.

use std::ops::Range;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

use rayon::iter::{IntoParallelIterator as _, ParallelIterator as _};
use rayon::{ThreadPool, ThreadPoolBuilder};
use stickslip_core::{RandomInputs, Verdict, VerdictCounts};
use stickslip_sampler::{Cell, Distribution, SampleStream};

use super::directory::RunDirectory;
use super::piece;
use super::plan::Plan;
use super::progress::Progress;
use super::tally::{Segment, Tally};
use crate::failure::{Failure, Signal};
use crate::interrupt::Interrupt;
use crate::job::{Deciders, Job};

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
    deciders: Deciders,
    pool: ThreadPool,
}

impl<'a> Engine<'a> {
    /// Prepares the computation of a job on `threads` threads.
    pub fn new(job: &'a Job, threads: usize) -> Result<Self, Failure> {
        let deciders = job.deciders().map_err(|error| Failure::Job(error.to_string()))?;
        let pool = ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|error| Failure::InputOutput(format!("cannot start {threads} threads: {error}")))?;
        Ok(Self { job, stream: job.stream(), deciders, pool })
    }

    /// Computes one unit. A pure function of its arguments and the job.
    pub fn compute(&self, cell: u64, samples: Range<u64>) -> Segment {
        let speed = self.job.grid.rotating_speed_index(cell);
        let place = self.job.grid.cell(cell);
        let mut counts = VerdictCounts::default();
        let mut amplitudes = Distribution::default();
        match &self.deciders {
            Deciders::Eigenvalue(boundaries) => self.stream.for_each(&place, samples.clone(), |samples| {
                counts += boundaries[speed].count(samples.preloads, samples.static_frictions);
            }),
            Deciders::CoupledEigenvalue(brakes) => {
                for inputs in self.inputs(&place, samples.clone()) {
                    counts += brakes[speed].verdict(inputs).into();
                }
            }
            Deciders::TimeDomain(criteria) => {
                for judged in criteria[speed].judge_all(&self.inputs(&place, samples.clone())) {
                    counts += judged.verdict.into();
                    if let (Verdict::Unstable, Some(amplitude)) = (judged.verdict, judged.amplitude)
                        && self.job.records_amplitude()
                    {
                        amplitudes.add(amplitude);
                    }
                }
            }
        }
        Segment { cell, samples, counts, amplitudes }
    }

    /// The random inputs of a unit of a criterion that takes them one by one.
    fn inputs(&self, place: &Cell, samples: Range<u64>) -> Vec<RandomInputs> {
        let mut inputs = Vec::with_capacity((samples.end - samples.start) as usize);
        self.stream.for_each(place, samples, |samples| {
            let pairs = samples.preloads.iter().zip(samples.static_frictions);
            inputs.extend(pairs.map(|(&preload, &static_friction)| RandomInputs { preload, static_friction }));
        });
        inputs
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
