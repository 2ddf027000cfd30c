//! The computation: units of work on all threads, and finished pieces on disk.

use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

use rayon::iter::{IntoParallelIterator as _, ParallelIterator as _};
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::evaluate::evaluator::Evaluator;
use crate::evaluate::integral::IntegratedCell;
use crate::evaluate::unit::FinishedUnit;
use crate::failure::{Failure, Signal};
use crate::interrupt::Interrupt;
use crate::schedule::plan::Plan;
use crate::schedule::progress::Progress;
use crate::store::directory::RunDirectory;
use crate::store::piece;
use crate::store::tally::Tally;

/// Largest number of finished units that wait to be written.
const MOST_PENDING: usize = 100_000;

/// How a computation ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Everything that was planned is done.
    Finished,
    /// A signal ended it. What was finished is on disk.
    Stopped(Signal),
}

/// The threads that do the work.
pub struct Engine {
    pool: ThreadPool,
}

/// What the thread that collects finished work receives.
pub(super) enum Event<T> {
    /// A unit is finished.
    Unit(T),
    /// No unit finished for a while.
    Idle,
    /// All work has ended.
    Done,
}

impl Engine {
    /// Starts `threads` threads.
    pub fn new(threads: usize) -> Result<Self, Failure> {
        let pool = ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|error| Failure::InputOutput(format!("cannot start {threads} threads: {error}")))?;
        Ok(Self { pool })
    }

    /// Integrates the probability of every cell.
    pub fn integrate(
        &self,
        evaluator: &Evaluator<'_>,
        interrupt: &Interrupt,
    ) -> Result<(Outcome, Vec<IntegratedCell>), Failure> {
        let job = evaluator.job();
        let regions = evaluator.regions();
        let integrate = |index: u64| (index, evaluator.integrate(&job.grid.cell(index), &regions));
        let mut cells = vec![IntegratedCell::unknown(); job.cells() as usize];
        let outcome = self.for_each_in_parallel(job.cells(), interrupt, integrate, |(index, integrated)| {
            cells[index as usize] = integrated;
        })?;
        Ok((outcome, cells))
    }

    /// Computes everything in `plan`, adds it to `tally`, and writes it to pieces in `directory`.
    ///
    /// Pieces are written during the computation, at growing intervals. A kill loses a tenth of the time already spent,
    /// and never more than ten seconds.
    pub fn run(
        &self,
        evaluator: &Evaluator<'_>,
        plan: &Plan,
        tally: &mut Tally,
        directory: &RunDirectory,
        progress: &mut Progress,
        interrupt: &Interrupt,
    ) -> Result<Outcome, Failure> {
        let (shards, experiment) = (directory.shards(), evaluator.job().experiment_hash());
        let started = Instant::now();
        let mut written = Instant::now();
        let mut pending = Vec::new();
        let count = |index: u64| {
            let (part, samples) = plan.unit(index);
            evaluator.count(part, samples)
        };
        self.in_parallel(plan.units(), interrupt, count, |event| {
            let done = matches!(event, Event::Done);
            if let Event::Unit(unit) = event {
                progress.advance(unit.len());
                tally.add(&unit);
                pending.push(unit);
            }
            progress.tick();
            let interval = (started.elapsed() / 10).clamp(Duration::from_millis(100), Duration::from_secs(10));
            let due = done || written.elapsed() >= interval || pending.len() >= MOST_PENDING;
            if due && !pending.is_empty() {
                // Units are not joined, so that two processes that do the same work write the same units.
                pending.sort_by_key(|unit| (unit.part, unit.samples.start));
                pending.iter_mut().for_each(|unit: &mut FinishedUnit| unit.part = evaluator.parts().stored(unit.part));
                piece::write(&shards, &experiment, &pending)?;
                pending.clear();
                written = Instant::now();
            }
            Ok(())
        })
    }

    /// Does `units` units of work on all threads, and passes the results, in any order, to `take` on this thread.
    pub fn for_each_in_parallel<T: Send>(
        &self,
        units: u64,
        interrupt: &Interrupt,
        work: impl Fn(u64) -> T + Sync + Send,
        mut take: impl FnMut(T),
    ) -> Result<Outcome, Failure> {
        self.in_parallel(units, interrupt, work, |event| {
            if let Event::Unit(result) = event {
                take(result);
            }
            Ok(())
        })
    }

    /// Does `units` units of work on all threads, and passes events to `take` on this thread.
    pub(super) fn in_parallel<T: Send>(
        &self,
        units: u64,
        interrupt: &Interrupt,
        work: impl Fn(u64) -> T + Sync + Send,
        mut take: impl FnMut(Event<T>) -> Result<(), Failure>,
    ) -> Result<Outcome, Failure> {
        let (sender, receiver) = mpsc::sync_channel::<T>(4096);
        thread::scope(|scope| {
            let worker = scope.spawn(move || {
                self.pool.install(|| {
                    // After a signal, or when the receiver is gone because writing failed, no further unit is started.
                    (0..units).into_par_iter().try_for_each(|index| {
                        let is_running = interrupt.signal().is_none();
                        is_running.then(|| sender.send(work(index)).ok()).flatten()
                    })
                })
            });
            let collected = collect(&receiver, &mut take);
            drop(receiver);
            let panicked = worker.join().is_err();
            collected?;
            if panicked {
                return Err(Failure::InputOutput("a worker thread failed; please report this as a bug".to_owned()));
            }
            Ok(interrupt.signal().map_or(Outcome::Finished, Outcome::Stopped))
        })
    }
}

/// Passes finished work to `take` until all threads are done.
fn collect<T>(receiver: &Receiver<T>, take: &mut impl FnMut(Event<T>) -> Result<(), Failure>) -> Result<(), Failure> {
    loop {
        match receiver.recv_timeout(Duration::from_millis(50)) {
            Ok(result) => take(Event::Unit(result))?,
            Err(RecvTimeoutError::Timeout) => take(Event::Idle)?,
            Err(RecvTimeoutError::Disconnected) => return take(Event::Done),
        }
    }
}
