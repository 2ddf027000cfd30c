//! How samples flow through the lanes of a bundle.

use crate::model::decision::Decision;
use crate::model::verdict::Verdict;
use crate::models::pad_on_disc::criterion::confirmation::Confirmation;
use crate::models::pad_on_disc::criterion::monitor::{Monitor, STEPS_BETWEEN_CHECKS, is_check_due};
use crate::models::pad_on_disc::lanes::bundle::{Begun, Bundle};
use crate::models::pad_on_disc::lanes::dispatch::InstructionSet;
use crate::models::pad_on_disc::lanes::pace::{DUE, EVENT, TOO_LONG, TURN};
use crate::models::pad_on_disc::lanes::queue::{QueuedSample, SampleQueue};
use crate::models::pad_on_disc::motion::advance::{StepInProgress, Substeps};
use crate::models::pad_on_disc::motion::integrator::{Equations as _, Motion, Observer as _, Step, turning_point};
use crate::models::pad_on_disc::motion::substep::Attempt;
use crate::models::pad_on_disc::pad::contact_state::ContactState;

/// When no samples are left and no more than one lane in this number is busy, the scalar code is faster.
const SCALAR_FINISH_DIVISOR: usize = 16;

/// Trial steps of one lane between two questions whether to stop: less than a millisecond.
const STEPS_BETWEEN_QUESTIONS: usize = 4096;

/// Steps of the scalar code between two such questions.
const SCALAR_STEPS_BETWEEN_QUESTIONS: u64 = 256;

/// A sample that waits for a lane, with what is known of it.
struct Waiting<'q, K> {
    sample: QueuedSample<'q>,
    known: K,
    confirmation: Confirmation,
}

/// A sample in a lane.
struct Running<'q, S, M> {
    sample: QueuedSample<'q>,
    confirmation: Confirmation,
    monitor: M,
    contact: ContactState,
    /// Steps to the horizon.
    limit: u64,
    /// The step in progress while the scalar code judges it.
    progress: StepInProgress<S>,
    /// Changes of contact in a step, and the number of steps before it.
    changes: (u32, f64),
}

/// What flows through the lanes of a bundle.
struct Flow<'q, 'b, B: Bundle<'q>, Q> {
    bundle: &'b mut B,
    queue: &'b mut Q,
    /// Samples that were taken from the queue, and those to simulate again, the next one last.
    waiting: Vec<Waiting<'q, B::Known>>,
    running: Vec<Option<Running<'q, B::State, B::Monitor>>>,
    busy: usize,
    is_exhausted: bool,
    /// Whether the queue stopped before a motion began, or while the scalar code was at work.
    is_stopped: bool,
}

/// Runs the samples of a queue, from a `first` one on, through a bundle until they are decided or the queue stops.
pub(super) fn run<'q, B: Bundle<'q>, Q: SampleQueue<'q> + ?Sized>(
    first: QueuedSample<'q>,
    queue: &mut Q,
    bundle: &mut B,
    set: InstructionSet,
) {
    let running = (0..B::LANES).map(|_| None).collect();
    let mut queue = Preceded { first: Some(first), queue };
    let mut flow = Flow {
        bundle,
        queue: &mut queue,
        waiting: Vec::new(),
        running,
        busy: 0,
        is_exhausted: false,
        is_stopped: false,
    };
    for lane in 0..B::LANES {
        flow.refill(lane);
    }
    let mut steps = 0;
    while flow.busy > 0 && !flow.is_stopped {
        if flow.is_exhausted && flow.busy * SCALAR_FINISH_DIVISOR <= B::LANES {
            return flow.finish();
        }
        if steps % (STEPS_BETWEEN_QUESTIONS / B::LANES) == 0 && flow.queue.is_stopped() {
            return;
        }
        steps += 1;
        flow.bundle.step(set);
        let mut visits = flow.bundle.visits();
        while visits != 0 {
            flow.visit(visits.trailing_zeros() as usize);
            visits &= visits - 1;
        }
    }
}

/// A queue whose first sample has been taken.
struct Preceded<'q, 'b, Q: ?Sized> {
    first: Option<QueuedSample<'q>>,
    queue: &'b mut Q,
}

impl<'q, Q: SampleQueue<'q> + ?Sized> SampleQueue<'q> for Preceded<'q, '_, Q> {
    fn next(&mut self) -> Option<QueuedSample<'q>> {
        self.first.take().or_else(|| self.queue.next())
    }
    fn decided(&mut self, ticket: u64, decision: Decision) {
        self.queue.decided(ticket, decision);
    }
    fn is_stopped(&self) -> bool {
        self.queue.is_stopped()
    }
}

impl<'q, B: Bundle<'q>, Q: SampleQueue<'q>> Flow<'q, '_, B, Q> {
    /// The next sample.
    fn take(&mut self) -> Option<Waiting<'q, B::Known>> {
        if self.waiting.is_empty() {
            let samples: Vec<_> = std::iter::from_fn(|| self.queue.next()).take(B::AT_ONCE).collect();
            let known = self.bundle.examine(&samples);
            let first = |(sample, known)| Waiting { sample, known, confirmation: Confirmation::NONE };
            self.waiting.extend(samples.into_iter().zip(known).map(first).rev());
        }
        self.waiting.pop()
    }

    /// Puts the next sample that needs simulation into a lane.
    fn refill(&mut self, lane: usize) {
        while let Some(Waiting { sample, known, confirmation }) = self.take() {
            // To find its linear stability may take longer than its motion.
            if self.queue.is_stopped() {
                self.is_stopped = true;
                return;
            }
            let (ticket, criterion) = (sample.ticket, sample.criterion);
            let queue = &*self.queue;
            match self.bundle.begin(lane, &sample, confirmation.divisor, known, &|| queue.is_stopped()) {
                Err(decision) => self.queue.decided(ticket, decision),
                Ok(Begun { motion, monitor, step }) => {
                    self.busy += usize::from(self.running[lane].is_none());
                    let substeps = Substeps::at_most(criterion.most_substeps(step));
                    let progress = StepInProgress::new(motion.contact, step, substeps);
                    let running = Running {
                        sample,
                        confirmation,
                        monitor,
                        contact: motion.contact,
                        limit: criterion.steps_to_horizon(step),
                        progress,
                        changes: (0, 0.0),
                    };
                    let (pace, l) = self.bundle.pace(lane);
                    pace.is_busy[l] = u64::MAX;
                    pace.step[l] = step;
                    self.bundle.set_next(lane, &motion);
                    self.running[lane] = Some(running);
                    self.set_progress(lane, &progress, 0.0);
                    return;
                }
            }
        }
        self.is_exhausted = true;
        self.busy -= usize::from(self.running[lane].take().is_some());
        let (pace, l) = self.bundle.pace(lane);
        pace.is_busy[l] = 0;
    }

    /// Sets how far the sample of a lane is, after `steps` steps.
    fn set_progress(&mut self, lane: usize, progress: &StepInProgress<B::State>, steps: f64) {
        let Some(running) = &mut self.running[lane] else { return };
        running.progress = *progress;
        running.changes = (progress.changes, steps);
        let due = running.due_after(steps);
        let shortest = progress.attempt.shortest_plain();
        // What lanes do not simulate, the scalar code judges too.
        let is_held = shortest.is_none() || !B::simulates(running.contact);
        let (pace, l) = self.bundle.pace(lane);
        pace.is_held[l] = u64::from(is_held);
        pace.length[l] = progress.attempt.length;
        pace.shortest[l] = shortest.unwrap_or(0.0);
        pace.done[l] = progress.done;
        pace.longest[l] = progress.longest;
        pace.substeps[l] = progress.substeps.taken as f64;
        pace.most_substeps[l] = progress.substeps.most as f64;
        pace.steps[l] = steps;
        pace.due[l] = due;
    }

    /// Looks at what the trial step of a lane found.
    fn visit(&mut self, lane: usize) {
        let (pace, l) = self.bundle.pace(lane);
        let findings = pace.findings[l];
        if findings & TOO_LONG != 0 {
            self.bundle.keep(lane);
        } else if findings & EVENT != 0 {
            let is_simulated = self.running[lane].as_ref().is_some_and(|running| B::simulates(running.contact));
            let trial = if is_simulated { self.bundle.trial(lane) } else { None };
            let state = self.bundle.present(lane);
            if let Some(decision) = self.judge(lane, state, trial, false) {
                self.decided(lane, decision);
            }
        } else {
            let ends_with_verdict = findings & TURN != 0 && self.turn(lane);
            if findings & DUE != 0 || ends_with_verdict {
                self.end_step(lane);
            }
        }
    }

    /// Looks at the sample of a lane at the end of a step.
    fn end_step(&mut self, lane: usize) {
        let at = self.bundle.next_tangential(lane);
        let (pace, l) = self.bundle.pace(lane);
        let (steps, h) = (pace.steps[l], pace.step[l]);
        let Some(running) = &mut self.running[lane] else { return };
        match running.end_step(at, steps, h) {
            Some(decision) => self.decided(lane, decision),
            None => pace.due[l] = running.due_after(steps),
        }
    }

    /// Ends the simulation of a lane with this decision, and begins the next one.
    fn decided(&mut self, lane: usize, decision: Decision) {
        if let Some(Running { sample, mut confirmation, monitor, .. }) = self.running[lane].take() {
            self.busy -= 1;
            match confirmation.accept(decision, monitor.is_doubtful()) {
                Some(decision) => self.queue.decided(sample.ticket, decision),
                None => self.waiting.push(Waiting { sample, known: B::Known::default(), confirmation }),
            }
        }
        self.refill(lane);
    }

    /// Reports the turning point in a plain trial step. Returns whether it brought a verdict and ended the step.
    fn turn(&mut self, lane: usize) -> bool {
        let (x, u, acceleration) = self.bundle.tangential(lane);
        let (pace, l) = self.bundle.pace(lane);
        let is_over = pace.done[l] == 0.0;
        let step_began = if is_over { pace.steps[l] - 1.0 } else { pace.steps[l] } * pace.step[l];
        let begin = step_began + pace.began[l];
        let (part, at) = turning_point(x, u, acceleration, pace.taken[l]);
        let Some(running) = &mut self.running[lane] else { return false };
        running.monitor.turns(begin + part, at);
        let is_decided = running.monitor.verdict().is_some();
        if is_decided {
            // It holds from the end of the step on.
            pace.due[l] = 0.0;
        }
        is_decided && is_over
    }

    /// Judges the trial step of a lane by the scalar code, and goes on by scalar steps as long as lanes cannot, or
    /// `to_the_end`. If the queue stops meanwhile, the lane is left as it is.
    fn judge(
        &mut self,
        lane: usize,
        state: B::State,
        mut trial: Option<Step<B::State>>,
        to_the_end: bool,
    ) -> Option<Decision> {
        let (pace, l) = self.bundle.pace(lane);
        let (mut steps, h, is_held) = (pace.steps[l], pace.step[l], pace.is_held[l] != 0);
        let (length, shortest) = (pace.length[l], pace.shortest[l]);
        let (done, longest, taken) = (pace.done[l], pace.longest[l], pace.substeps[l] as u64);
        let running = self.running[lane].as_mut()?;
        let substeps = Substeps { taken, ..running.progress.substeps };
        let equations = self.bundle.equations(lane)?;
        let mut progress = if is_held {
            running.progress
        } else {
            let attempt = match running.contact {
                ContactState::Stick => Attempt::new(ContactState::Stick, length, false),
                _ => Attempt::sliding(length, shortest),
            };
            let changes = if running.changes.1 == steps { running.changes.0 } else { 0 };
            StepInProgress { attempt, h, done, longest, substeps, changes }
        };
        let mut motion = Motion { state, contact: running.contact };
        for taken in 1_u64.. {
            if taken.is_multiple_of(SCALAR_STEPS_BETWEEN_QUESTIONS) && self.queue.is_stopped() {
                self.is_stopped = true;
                return None;
            }
            let time = steps * h;
            let step = match trial.take() {
                Some(step) => step,
                None => equations.step(&motion.state, motion.contact, progress.attempt.length),
            };
            match progress.judge(&equations, &mut motion, &step, time, &mut running.monitor) {
                Err(stopped) => {
                    let at = equations.tangential(&motion.state);
                    return Some(running.sample.criterion.conclude_stopped(stopped, &mut running.monitor, at, time));
                }
                Ok(true) => {
                    steps += 1.0;
                    let decision = running.end_step(equations.tangential(&motion.state), steps, h);
                    if decision.is_some() {
                        return decision;
                    }
                    progress = StepInProgress::new(motion.contact, h, progress.substeps);
                }
                Ok(false) => {}
            }
            if B::simulates(motion.contact) && !to_the_end {
                break;
            }
        }
        running.contact = motion.contact;
        drop(equations);
        self.bundle.set_next(lane, &motion);
        self.set_progress(lane, &progress, steps);
        None
    }

    /// Simulates the samples of all lanes to their end by the scalar code, or until the queue stops.
    fn finish(&mut self) {
        for lane in 0..B::LANES {
            // A sample may be followed by itself, in finer steps.
            while let Some(decision) = self.judge(lane, self.bundle.next(lane), None, true) {
                self.decided(lane, decision);
            }
            if self.is_stopped {
                return;
            }
        }
    }
}

impl<S, M: Monitor> Running<'_, S, M> {
    /// Ends the last of some steps of length `h`, at x and x'. Returns the decision if it is due.
    fn end_step(&mut self, (x, u): (f64, f64), steps: f64, h: f64) -> Option<Decision> {
        let (count, end) = (steps as u64, steps * h);
        if is_check_due(count) {
            self.monitor.check(x, u);
        }
        match self.monitor.verdict() {
            Some(verdict) => Some(self.sample.criterion.conclude(verdict, &self.monitor, end)),
            None => (count >= self.limit)
                .then(|| self.sample.criterion.conclude_without_verdict(Verdict::Undecided, &self.monitor, end)),
        }
    }

    /// The number of steps after which to look at the sample next, if nothing happens.
    fn due_after(&self, steps: f64) -> f64 {
        if self.monitor.verdict().is_some() {
            return 0.0;
        }
        let next_check = (steps as u64 / STEPS_BETWEEN_CHECKS + 1) * STEPS_BETWEEN_CHECKS;
        next_check.min(self.limit) as f64
    }
}
