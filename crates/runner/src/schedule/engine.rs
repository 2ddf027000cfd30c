//! The computation: units of work on all cores, finished pieces on disk.

use std::ops::Range;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

use rayon::iter::{IntoParallelIterator as _, ParallelIterator as _};
use rayon::{ThreadPool, ThreadPoolBuilder};
use stickslip_core::criterion::time_domain::Decision;
use stickslip_core::rigid_disc::pad_on_disc::RandomInputs;
use stickslip_core::verdict::{Verdict, VerdictCounts};
use stickslip_sampler::draw::deviates::Points;
use stickslip_sampler::draw::identity::BLOCK_SAMPLES;
use stickslip_sampler::draw::samples::SampleStream;
use stickslip_sampler::estimate::audit;
use stickslip_sampler::estimate::distribution::Distribution;
use stickslip_sampler::estimate::interval::Estimate;
use stickslip_sampler::grid::Cell;
use stickslip_sampler::integrate::closed_form;
use stickslip_sampler::integrate::closed_form::Derivatives;
use stickslip_sampler::integrate::mapped::{MapRegions, MappedProbability};

use crate::evaluate::batch::Batch;
use crate::evaluate::extras::{Extras, Lookups};
use crate::failure::{Failure, Signal};
use crate::interrupt::Interrupt;
use crate::job::{Audit, Deciders, Effort, Job};
use crate::schedule::plan::Plan;
use crate::schedule::progress::Progress;
use crate::schedule::slots::Slots;
use crate::store::directory::RunDirectory;
use crate::store::maps::Maps;
use crate::store::piece;
use crate::store::tally::{Segment, Tally};
use crate::tables::row::IntegratedCell;

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
    pub(super) job: &'a Job,
    pub(super) slots: Slots,
    stream: SampleStream,
    /// Whether samples are drawn and counted by the fast path.
    is_plain: bool,
    extras: Extras,
    pub(super) deciders: Deciders,
    pub(super) maps: Maps,
    pool: ThreadPool,
}

/// What the thread that collects finished work is told.
pub(super) enum Event<T> {
    /// A unit is finished.
    Unit(T),
    /// Nothing for a while.
    Idle,
    /// That was all.
    Done,
}

impl<'a> Engine<'a> {
    /// Prepares the computation of a job on `threads` threads.
    pub fn new(job: &'a Job, threads: usize) -> Result<Self, Failure> {
        let deciders = job.deciders().map_err(|error| Failure::Job(error.to_string()))?;
        let pool = ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map_err(|error| Failure::InputOutput(format!("cannot start {threads} threads: {error}")))?;
        let extras = Extras::of(job);
        Ok(Self {
            job,
            slots: Slots::new(job),
            stream: job.stream(),
            is_plain: job.has_plain_samples() && !extras.need_samples(),
            extras,
            deciders,
            maps: Maps::new(job),
            pool,
        })
    }

    /// The verdict maps.
    pub fn maps(&self) -> &Maps {
        &self.maps
    }

    /// Computes one unit. A pure function of its arguments and the job.
    pub fn compute(&self, slot: u64, samples: Range<u64>) -> Segment {
        let (cell, part) = self.slots.place(slot);
        let place = self.job.grid.cell(cell);
        let first = self.slots.first_sample(part);
        let drawn = first + samples.start..first + samples.end;
        let mut counts = VerdictCounts::default();
        let mut amplitudes = Distribution::default();
        let mut sums = self.extras.nothing();
        if let (Deciders::Eigenvalue(boundaries), true) = (&self.deciders, self.is_plain) {
            let boundary = &boundaries[self.job.grid.rotating_speed_index(cell)];
            self.stream.for_each(&place, drawn, |samples| {
                counts += boundary.count(samples.preloads, samples.static_frictions);
            });
            return Segment { slot, samples, counts, amplitudes, sums };
        }
        let batch = Batch::draw(self.job, &place, part, drawn.clone(), self.job.points());
        let mut lookups = Lookups::default();
        let audited = self.audited(slot, samples.clone());
        let judged = self.decide(&place, &batch, &audited, &mut lookups);
        for judged in &judged {
            counts += judged.verdict.into();
            if let (Verdict::Unstable, Some(amplitude), true) =
                (judged.verdict, judged.amplitude, self.job.records_amplitude())
            {
                amplitudes.add(amplitude);
            }
        }
        self.extras.add_sources(&mut sums, &judged);
        let verdicts: Vec<Verdict> = judged.iter().map(|judged| judged.verdict).collect();
        self.extras.add_scores(&mut sums, &place, &batch, &verdicts);
        if self.extras.sensitivity() > 0 {
            let second = Batch::draw(self.job, &place, part, drawn, Points::SecondRandom);
            let verdicts_of = |batch: &Batch| -> Vec<Verdict> {
                let judged = self.decide(&place, batch, &[], &mut Lookups::default());
                judged.into_iter().map(|judged| judged.verdict).collect()
            };
            let mixed: Vec<Vec<Verdict>> =
                (0..self.extras.sensitivity()).map(|input| verdicts_of(&batch.with_input_of(input, &second))).collect();
            let second = verdicts_of(&second);
            self.extras.add_sensitivity(&mut sums, &verdicts, &second, &mixed);
        }
        self.extras.add_lookups(&mut sums, lookups);
        Segment { slot, samples, counts, amplitudes, sums }
    }

    /// Judges samples: those that a map tells are looked up, unless they are audited; the others are judged one by one.
    fn decide(&self, place: &Cell, batch: &Batch, audited: &[bool], lookups: &mut Lookups) -> Vec<Decision> {
        if let Deciders::Varying(brake) = &self.deciders {
            let judge = |i| brake.decide(place.rotating_speed, batch.inputs(i), batch.values(i));
            return (0..batch.len()).map(judge).collect();
        }
        let speed = self.job.grid.rotating_speed_index(place.index);
        let inputs: Vec<RandomInputs> = (0..batch.len()).map(|sample| batch.inputs(sample)).collect();
        let Some(map) = self.maps.get(speed) else {
            lookups.simulated += inputs.len() as u64;
            return self.deciders.decide(speed, &inputs);
        };
        let told: Vec<Option<Verdict>> = inputs.iter().map(|&inputs| map.look_up(inputs)).collect();
        let is_audited = |sample: usize| audited.get(sample).copied().unwrap_or(false);
        let to_judge: Vec<usize> = (0..inputs.len()).filter(|&i| told[i].is_none() || is_audited(i)).collect();
        let judged = self.deciders.decide(speed, &to_judge.iter().map(|&i| inputs[i]).collect::<Vec<_>>());
        let mut all: Vec<Decision> = told.iter().map(|told| told.unwrap_or(Verdict::Failed).into()).collect();
        for (&sample, judged) in to_judge.iter().zip(judged) {
            match told[sample] {
                None => lookups.simulated += 1,
                Some(told) => {
                    lookups.audited += 1;
                    lookups.differed += u64::from(told != judged.verdict);
                }
            }
            all[sample] = judged;
        }
        all
    }

    /// Which samples of a slot are audited: by their number in the cell, unless a randomisation numbers its own.
    fn audited(&self, slot: u64, samples: Range<u64>) -> Vec<bool> {
        if !self.extras.lookups() || self.job.sampling.audit.is_nothing() {
            return Vec::new();
        }
        let (cell, part) = self.slots.place(slot);
        let first = self.slots.first_sample(part);
        let samples = first + samples.start..first + samples.end;
        match self.job.sampling.audit {
            Audit::Samples(wanted) => {
                let randomisations = match self.job.sampling.effort {
                    Effort::Randomisations { count, .. } => count,
                    _ => 1,
                };
                let wanted = wanted.div_ceil(randomisations);
                samples.map(|sample| sample < wanted).collect()
            }
            Audit::Share(share) => {
                let key = if self.slots.are_decided_in_turn() { cell } else { slot };
                audit::choose(self.job.sampling.seed, key, samples, share)
            }
        }
    }

    /// Looks the first samples of a cell up in its verdict map, and simulates them as well.
    fn audit_integral(&self, cell: &Cell) -> Lookups {
        let mut lookups = Lookups::default();
        if let (Audit::Samples(wanted), true) = (self.job.sampling.audit, self.job.uses_maps()) {
            let mut first = 0;
            while first < wanted {
                let end = wanted.min(first + BLOCK_SAMPLES);
                let batch = Batch::draw(self.job, cell, 0, first..end, Points::Random);
                self.decide(cell, &batch, &vec![true; batch.len()], &mut lookups);
                first = end;
            }
        }
        lookups
    }

    /// The verdict of a map on a sample, numbered over all parts of its cell; `None` if the sample is simulated, because the
    /// map does not tell or for the audit.
    pub fn looked_up(&self, cell: u64, sample: u64) -> Option<Verdict> {
        let place = self.job.grid.cell(cell);
        let (part, index) = self.slots.locate(sample);
        let is_audited = self.audited(self.slots.of(cell).start + part as u64, index..index + 1);
        if is_audited.contains(&true) {
            return None;
        }
        let inputs = Batch::of_sample(self.job, &place, sample).inputs(0);
        self.maps.get(self.job.grid.rotating_speed_index(cell))?.look_up(inputs)
    }

    /// Verdicts on consecutive samples of a cell, of its randomisation `randomisation` where it has any: those that
    /// [`Engine::compute`] counts.
    pub fn verdicts(&self, cell: u64, randomisation: usize, samples: Range<u64>) -> Vec<Verdict> {
        let place = self.job.grid.cell(cell);
        let slots = self.slots.of(cell);
        // With looks, the samples are numbered over all parts of the cell; a randomisation numbers its own.
        let parts = match (self.slots.are_decided_in_turn(), (slots.end - slots.start) as usize) {
            (true, parts) => 0..parts,
            (false, _) => randomisation..randomisation + 1,
        };
        let mut verdicts = Vec::with_capacity((samples.end - samples.start) as usize);
        for part in parts {
            let first = self.slots.first_sample(part);
            let drawn = samples.start.max(first)..samples.end.min(first + self.slots.most(part));
            if drawn.is_empty() {
                continue;
            }
            let batch = Batch::draw(self.job, &place, part, drawn.clone(), self.job.points());
            let audited = self.audited(slots.start + part as u64, drawn.start - first..drawn.end - first);
            let judged = self.decide(&place, &batch, &audited, &mut Lookups::default());
            verdicts.extend(judged.into_iter().map(|judged| judged.verdict));
        }
        verdicts
    }

    /// The probability of every cell by integration.
    pub fn integrate(&self, interrupt: &Interrupt) -> Result<(Outcome, Vec<IntegratedCell>), Failure> {
        let speeds = self.job.grid.rotating_speed.values().len();
        let regions: Vec<MapRegions> =
            (0..speeds).filter_map(|speed| self.maps.get(speed)).map(MapRegions::new).collect();
        let unknown = Derivatives::default();
        let integrate = |index: u64| {
            let cell = self.job.grid.cell(index);
            let speed = self.job.grid.rotating_speed_index(index);
            if let Deciders::Eigenvalue(boundaries) = &self.deciders {
                let exact = closed_form::probability(&boundaries[speed], &cell);
                let low = (exact.value - exact.error_bound).max(0.0);
                let high = (exact.value + exact.error_bound).min(1.0);
                let wanted = self.extras.derivatives();
                let derivatives = if wanted { closed_form::derivatives(&boundaries[speed], &cell) } else { unknown };
                let estimate = Estimate { probability: Some(exact.value), low, high };
                return (index, IntegratedCell { estimate, derivatives, undecided: 0.0, lookups: Lookups::default() });
            }
            let mapped = regions[speed].probability(&cell);
            let estimate = Estimate { probability: mapped.value, low: mapped.low, high: mapped.high };
            let MappedProbability { derivatives, undecided, .. } = mapped;
            (index, IntegratedCell { estimate, derivatives, undecided, lookups: self.audit_integral(&cell) })
        };
        let nothing = IntegratedCell {
            estimate: Estimate { probability: None, low: 0.0, high: 1.0 },
            derivatives: unknown,
            undecided: 0.0,
            lookups: Lookups::default(),
        };
        let mut cells = vec![nothing; self.job.cells() as usize];
        let outcome = self.for_each_in_parallel(self.job.cells(), interrupt, integrate, |(index, integrated)| {
            cells[index as usize] = integrated;
        })?;
        Ok((outcome, cells))
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
        let (shards, experiment) = (directory.shards(), self.job.experiment_hash());
        let started = Instant::now();
        let mut written = Instant::now();
        let mut pending = Vec::new();
        let compute = |index: u64| {
            let (slot, samples) = plan.unit(index);
            self.compute(slot, samples)
        };
        self.in_parallel(plan.units(), interrupt, compute, |event| {
            let done = matches!(event, Event::Done);
            if let Event::Unit(segment) = event {
                progress.advance(segment.len());
                tally.add(&segment);
                pending.push(segment);
            }
            progress.tick();
            let interval = (started.elapsed() / 10).clamp(Duration::from_millis(100), Duration::from_secs(10));
            let due = done || written.elapsed() >= interval || pending.len() >= MOST_PENDING;
            if due && !pending.is_empty() {
                // Units stay apart in a piece: two processes that do the same work write the same segments.
                pending.sort_by_key(|segment| (segment.slot, segment.samples.start));
                pending.iter_mut().for_each(|segment: &mut Segment| segment.slot = self.slots.stored(segment.slot));
                piece::write(&shards, &experiment, &pending)?;
                pending.clear();
                written = Instant::now();
            }
            Ok(())
        })
    }

    /// Does `units` units of work on all threads, and hands what comes out, in any order, to `take` on this one.
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
                    // The first unit that finds a signal, or nobody to send to because writing failed, ends them all.
                    (0..units).into_par_iter().try_for_each(|index| {
                        let go_on = interrupt.signal().is_none();
                        go_on.then(|| sender.send(work(index)).ok()).flatten()
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

/// Takes what is finished until the workers are done.
fn collect<T>(receiver: &Receiver<T>, take: &mut impl FnMut(Event<T>) -> Result<(), Failure>) -> Result<(), Failure> {
    loop {
        match receiver.recv_timeout(Duration::from_millis(50)) {
            Ok(result) => take(Event::Unit(result))?,
            Err(RecvTimeoutError::Timeout) => take(Event::Idle)?,
            Err(RecvTimeoutError::Disconnected) => return take(Event::Done),
        }
    }
}
