//! How the samples of a list share the lanes of a bundle.

use crate::criterion::decision::Decision;
use crate::criterion::monitor::{Monitor, is_check_due};
use crate::criterion::time_domain::TimeDomain;
use crate::lanes::dispatch::InstructionSet;
use crate::lanes::findings::Finding;
use crate::motion::integrator::{Breakdown, Observer as _, turning_point};
use crate::pad::contact_state::ContactState;
use crate::rigid_disc::pad_on_disc::RandomInputs;
use crate::verdict::Verdict;

/// When no samples are left and no more than one lane in this number is busy, the scalar code is faster.
const SCALAR_FINISH_DIVISOR: usize = 8;

/// Lanes with one set of equations.
pub(super) trait Bundle {
    /// Lanes.
    const LANES: usize;

    type Monitor: Monitor;

    /// Puts a sample into the next state of a lane, or decides it without simulation.
    fn begin(
        &mut self,
        criterion: &TimeDomain,
        lane: usize,
        inputs: RandomInputs,
    ) -> Result<(ContactState, Self::Monitor), Decision>;

    /// Puts the start of a sample into the next state of a lane, decided or not.
    fn place(&mut self, criterion: &TimeDomain, lane: usize, inputs: RandomInputs);

    /// One step of slip in every lane, from the present states to the next ones.
    fn step(&mut self, set: InstructionSet);

    fn finding(&self, lane: usize) -> Finding;

    /// x, and x' and x'' at both ends of the step.
    fn tangential(&self, lane: usize) -> (f64, (f64, f64), (f64, f64));

    /// x and x' at the end of the step.
    fn next(&self, lane: usize) -> (f64, f64);

    /// The scalar step from the present state of a lane to its next one.
    fn scalar_step(
        &mut self,
        lane: usize,
        contact: ContactState,
        time: f64,
        monitor: &mut Self::Monitor,
    ) -> Result<ContactState, Breakdown>;

    /// The next states become the present ones.
    fn commit(&mut self);

    /// Length of a step.
    fn step_length(&self) -> f64;

    /// Simulates the sample of a lane to its end by the scalar code, from `steps` steps after its start.
    fn finish(
        &self,
        criterion: &TimeDomain,
        lane: usize,
        sample: &RunningSample<Self::Monitor>,
        steps: u64,
    ) -> Decision;
}

/// The sample that a lane simulates.
#[derive(Clone, Copy)]
pub(super) struct RunningSample<M> {
    /// Its place in the list.
    pub index: usize,
    pub monitor: M,
    pub contact: ContactState,
    /// The step of the bundle at which it started.
    pub started: u64,
}

/// Runs a list of samples through a bundle.
pub(super) fn run<B: Bundle>(
    criterion: &TimeDomain,
    inputs: &[RandomInputs],
    bundle: &mut B,
    set: InstructionSet,
) -> Vec<Decision> {
    let h = bundle.step_length();
    let limit = criterion.steps_to_horizon(h);
    let mut decisions = vec![Decision::OUTSIDE_PHYSICS; inputs.len()];
    let mut waiting = 0..inputs.len();
    let mut running: Vec<Option<RunningSample<B::Monitor>>> = vec![None; B::LANES];
    let mut busy = 0;
    let mut now = 0_u64;
    // The first step at which a lane may have reached its horizon.
    let mut deadline = limit;
    let mut refill = |bundle: &mut B, lane: usize, decisions: &mut [Decision], now: u64| {
        for index in waiting.by_ref() {
            match bundle.begin(criterion, lane, inputs[index]) {
                Err(known) => decisions[index] = known,
                Ok((contact, monitor)) => return Some(RunningSample { index, monitor, contact, started: now }),
            }
        }
        None
    };
    for (lane, sample) in running.iter_mut().enumerate() {
        *sample = refill(bundle, lane, &mut decisions, now);
        busy += usize::from(sample.is_some());
    }
    bundle.commit();
    let mut exhausted = busy < B::LANES;
    while busy > 0 {
        if exhausted && busy * SCALAR_FINISH_DIVISOR <= B::LANES {
            for (lane, sample) in running.iter().enumerate() {
                if let Some(sample) = sample {
                    decisions[sample.index] = bundle.finish(criterion, lane, sample, now - sample.started);
                }
            }
            break;
        }
        bundle.step(set);
        let at_deadline = now + 1 >= deadline;
        if at_deadline {
            deadline = u64::MAX;
        }
        for (lane, place) in running.iter_mut().enumerate() {
            let Some(sample) = place else { continue };
            let steps = now - sample.started;
            let time = steps as f64 * h;
            let finding = if sample.contact == ContactState::Slip { bundle.finding(lane) } else { Finding::Event };
            let decision = match finding {
                Finding::Nothing => None,
                Finding::Turn => {
                    let (x, u, acceleration) = bundle.tangential(lane);
                    let (part, at) = turning_point(x, u, acceleration, h);
                    sample.monitor.turns(time + part, at);
                    None
                }
                Finding::Event => match bundle.scalar_step(lane, sample.contact, time, &mut sample.monitor) {
                    Ok(contact) => {
                        sample.contact = contact;
                        None
                    }
                    Err(Breakdown) => Some(criterion.conclude_without_verdict(Verdict::Failed, &sample.monitor, time)),
                },
            };
            let checks = is_check_due(steps + 1);
            if checks && decision.is_none() {
                let (x, u) = bundle.next(lane);
                sample.monitor.check(x, u);
            }
            let decision = decision.or_else(|| {
                let verdict = if finding == Finding::Nothing && !checks { None } else { sample.monitor.verdict() };
                let end = (steps + 1) as f64 * h;
                match verdict {
                    Some(verdict) => Some(criterion.conclude(verdict, &sample.monitor, end)),
                    None => (at_deadline && steps + 1 >= limit)
                        .then(|| criterion.conclude_without_verdict(Verdict::Undecided, &sample.monitor, end)),
                }
            });
            if let Some(decision) = decision {
                decisions[sample.index] = decision;
                // Written to the next state, which becomes the present one below.
                *place = refill(bundle, lane, &mut decisions, now + 1);
                if place.is_none() {
                    busy -= 1;
                    exhausted = true;
                }
            }
            if at_deadline && let Some(sample) = place {
                deadline = deadline.min(sample.started + limit);
            }
        }
        bundle.commit();
        now += 1;
    }
    decisions
}
