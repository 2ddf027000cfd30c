//! The computation: units of work on all threads, and finished pieces on disk.

use std::cell::Cell;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, SyncSender};
use std::thread;
use std::time::{Duration, Instant};

use rayon::iter::{IndexedParallelIterator as _, IntoParallelIterator as _, ParallelIterator as _};
use rayon::{ThreadPool, ThreadPoolBuilder};

use stickslip_core::model::IsStopped;

use crate::evaluate::control::Control;
use crate::evaluate::evaluator::Evaluator;
use crate::evaluate::integral::IntegratedCell;
use crate::evaluate::parts::Parts;
use crate::evaluate::sums::Lookups;
use crate::evaluate::unit::FinishedUnit;
use crate::failure::{Failure, Signal};
use crate::files::folder::Folder;
use crate::interrupt::Interrupt;
use crate::schedule::plan::Plan;
use crate::schedule::progress::Progress;
use crate::schedule::saving::Saving;
use crate::schedule::spread::Spread;
use crate::store::tally::Tally;

/// Time between two looks for a signal while nothing is finished.
const IDLE: Duration = Duration::from_millis(50);

/// Time after which a thread hands over what it has finished of a unit.
const FLUSH: Duration = Duration::from_millis(250);

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

/// Samples to compute, and where they are kept.
#[derive(Clone, Copy)]
pub struct Samples<'a> {
    /// The units that are missing.
    pub plan: &'a Plan,
    /// The parts that these are of.
    pub parts: &'a Parts,
    /// The directory of their pieces; `None` if they are not kept.
    pub pieces: Option<&'a Folder>,
    /// Whether they are the audit of integrals.
    pub are_audits: bool,
}

/// What the thread that collects finished work receives.
pub(super) enum Event<T> {
    /// Something is finished.
    Finished(T),
    /// Nothing was finished for a while.
    Idle,
    /// All work has ended.
    Done,
}

/// What a thread at work shares with the others and with the one that collects.
pub(super) struct Link<'a, T> {
    sender: SyncSender<T>,
    interrupt: &'a Interrupt,
    /// Positions in the order of the units that are handed out.
    turn: AtomicU64,
    order: Spread,
    /// Whether nobody collects any more, because writing failed.
    is_closed: AtomicBool,
}

impl<T> Link<'_, T> {
    /// Hands over finished work.
    pub(super) fn send(&self, finished: T) {
        if self.sender.send(finished).is_err() {
            self.is_closed.store(true, Ordering::Relaxed);
        }
    }

    /// Whether to stop: after a signal, or when nobody collects.
    pub(super) fn is_stopped(&self) -> bool {
        self.is_closed.load(Ordering::Relaxed) || self.interrupt.signal().is_some()
    }

    /// The number of the next unit, each once over all threads; `None` after the last and after a stop.
    pub(super) fn next(&self) -> Option<u64> {
        if self.is_stopped() { None } else { self.order.at(self.turn.fetch_add(1, Ordering::Relaxed)) }
    }
}

impl Engine {
    /// Starts `threads` threads.
    pub fn new(threads: usize) -> Result<Self, Failure> {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().map_err(|error| {
            Failure::InputOutput(format!("cannot start {threads} threads: {error}; give fewer with --threads"))
        })?;
        Ok(Self { pool })
    }

    /// The number of threads.
    pub fn threads(&self) -> usize {
        self.pool.current_num_threads()
    }

    /// Integrates the probability of every cell, with the audits in `audits`.
    pub fn integrate(
        &self,
        evaluator: &Evaluator<'_>,
        audits: &Tally,
        interrupt: &Interrupt,
    ) -> Result<(Outcome, Vec<IntegratedCell>), Failure> {
        let job = evaluator.job();
        let regions = evaluator.regions();
        let integrate = |index: u64, is_stopped: IsStopped<'_>| {
            let lookups = Lookups::from_sums(&audits.sums(index));
            evaluator.integrate(&job.grid.cell(index), &regions, lookups, is_stopped).map(|cell| (index, cell))
        };
        let mut cells = vec![IntegratedCell::unknown(); job.cells() as usize];
        let outcome = self.for_each_in_parallel(job.cells(), interrupt, integrate, |integrated| {
            if let Some((index, integrated)) = integrated {
                cells[index as usize] = integrated;
            }
        })?;
        Ok((outcome, cells))
    }

    /// Audits the maps behind integrals, or draws the plain samples beside probabilities, as far as `audits` lacks it. Finished audits are written to the directory
    /// `keep`, if there is one.
    pub fn audit(
        &self,
        evaluator: &Evaluator<'_>,
        audits: &mut Tally,
        keep: Option<&Folder>,
        interrupt: &Interrupt,
    ) -> Result<Outcome, Failure> {
        let parts = Parts::of_audits(evaluator.job());
        let plan = Plan::new(audits, &parts, parts.unit_samples(), None);
        if plan.units() == 0 {
            return Ok(interrupt.signal().map_or(Outcome::Finished, Outcome::Stopped));
        }
        let mut progress = Progress::new(plan.samples(), "audited samples");
        let samples = Samples { plan: &plan, parts: &parts, pieces: keep, are_audits: true };
        let outcome = self.run(evaluator, samples, audits, &mut progress, interrupt);
        progress.finish();
        outcome
    }

    /// Computes the samples of a plan, adds them to `tally`, and writes them to pieces.
    ///
    /// Pieces are written during the computation, at growing intervals. A kill loses a tenth of the time already spent,
    /// and never more than ten seconds.
    pub fn run(
        &self,
        evaluator: &Evaluator<'_>,
        samples: Samples<'_>,
        tally: &mut Tally,
        progress: &mut Progress,
        interrupt: &Interrupt,
    ) -> Result<Outcome, Failure> {
        let Samples { plan, parts, pieces, are_audits } = samples;
        let experiment = evaluator.job().experiment_hash();
        let mut saving = pieces.map(|pieces| Saving::new(pieces, experiment, parts, plan.unit_samples()));
        let work = |link: &Link<'_, FinishedUnit>| {
            let flushed = Cell::new(Instant::now());
            let next = || -> Option<(u64, Range<u64>)> { Some(plan.unit(link.next()?)) };
            let control = || {
                if link.is_stopped() {
                    Control::Stop
                } else if flushed.get().elapsed() >= FLUSH {
                    flushed.set(Instant::now());
                    Control::Flush
                } else {
                    Control::Continue
                }
            };
            let mut emit = |unit| link.send(unit);
            if are_audits {
                evaluator.work_on_audits(&next, &mut emit, &control);
            } else {
                evaluator.work(&next, &mut emit, &control);
            }
        };
        self.on_every_thread(plan.units(), interrupt, work, |event| {
            let is_done = matches!(event, Event::Done);
            if let Event::Finished(unit) = event {
                progress.advance(unit.len());
                tally.add(&unit);
                saving.iter_mut().for_each(|saving| saving.add(unit.clone()));
            }
            progress.tick();
            saving
                .iter_mut()
                .try_for_each(|saving| if is_done { saving.save_all(interrupt) } else { saving.save_if_due(interrupt) })
        })
    }

    /// Does `units` units of work on all threads, each until it is stopped, and passes the results, in any order, to
    /// `take` on this thread.
    pub fn for_each_in_parallel<T: Send>(
        &self,
        units: u64,
        interrupt: &Interrupt,
        work: impl Fn(u64, IsStopped<'_>) -> T + Sync + Send,
        mut take: impl FnMut(T),
    ) -> Result<Outcome, Failure> {
        self.in_parallel(units, interrupt, work, |event| {
            if let Event::Finished(result) = event {
                take(result);
            }
            Ok(())
        })
    }

    /// Does `units` units of work on all threads, each until it is stopped, and passes events to `take` on this thread.
    pub(super) fn in_parallel<T: Send>(
        &self,
        units: u64,
        interrupt: &Interrupt,
        work: impl Fn(u64, IsStopped<'_>) -> T + Sync + Send,
        take: impl FnMut(Event<T>) -> Result<(), Failure>,
    ) -> Result<Outcome, Failure> {
        let each = |link: &Link<'_, T>| {
            while let Some(unit) = link.next() {
                link.send(work(unit, &|| link.is_stopped()));
            }
        };
        self.on_every_thread(units, interrupt, each, take)
    }

    /// Runs `work` once on every thread, and passes what it hands over to `take` on this thread. `units` is the number
    /// of units that the link hands out.
    pub(super) fn on_every_thread<T: Send>(
        &self,
        units: u64,
        interrupt: &Interrupt,
        work: impl Fn(&Link<'_, T>) + Sync + Send,
        mut take: impl FnMut(Event<T>) -> Result<(), Failure>,
    ) -> Result<Outcome, Failure> {
        let (sender, receiver) = mpsc::sync_channel::<T>(4096);
        let order = Spread::over(units);
        let link = Link { sender, interrupt, turn: AtomicU64::new(0), order, is_closed: AtomicBool::new(false) };
        let _working = interrupt.working();
        thread::scope(|scope| {
            let workers = thread::Builder::new().spawn_scoped(scope, move || {
                // Each thread takes units until there are none. In which order they are done, and by which thread,
                // makes no difference to the results.
                self.pool.install(|| {
                    (0..self.threads()).into_par_iter().with_max_len(1).for_each(|_| work(&link));
                });
            });
            let workers =
                workers.map_err(|error| Failure::InputOutput(format!("cannot start one more thread: {error}")))?;
            let collected = collect(&receiver, &mut take);
            drop(receiver);
            let panicked = workers.join().is_err();
            collected?;
            if panicked {
                return Err(Failure::Internal("a worker thread failed; please report this as a bug".to_owned()));
            }
            Ok(interrupt.signal().map_or(Outcome::Finished, Outcome::Stopped))
        })
    }
}

/// Passes finished work to `take` until all threads are done.
fn collect<T>(receiver: &Receiver<T>, take: &mut impl FnMut(Event<T>) -> Result<(), Failure>) -> Result<(), Failure> {
    loop {
        match receiver.recv_timeout(IDLE) {
            Ok(result) => take(Event::Finished(result))?,
            Err(RecvTimeoutError::Timeout) => take(Event::Idle)?,
            Err(RecvTimeoutError::Disconnected) => return take(Event::Done),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_in_a_thread_is_an_error_and_the_others_go_on() {
        let (engine, mut done) = (Engine::new(2).unwrap(), Vec::new());
        let work = |unit, _: IsStopped<'_>| if unit == 3 { panic!("unit {unit}") } else { unit };
        let result = engine.for_each_in_parallel(50, &Interrupt::unwatched(), work, |unit| done.push(unit));
        assert!(result.unwrap_err().to_string().contains("a worker thread failed"));
        done.sort_unstable();
        assert_eq!(done, (0..50).filter(|unit| *unit != 3).collect::<Vec<_>>());
    }
}
