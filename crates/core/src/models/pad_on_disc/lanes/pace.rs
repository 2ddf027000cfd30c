//! How far lanes are in their steps, and what a trial step found.
//!
//! Every lane is in a step and a substep of its own ([`crate::models::pad_on_disc::motion::advance`]). All lanes take their trial steps
//! together. Here the plain ones are judged as [`crate::models::pad_on_disc::motion::substep`] judges them, without a branch: those that
//! complete a substep of slip, or of stick where the kernel knows it.

use crate::models::pad_on_disc::motion::advance::LEAST_REMAINDER;
use crate::models::pad_on_disc::motion::friction_steps::MOST_GROWTH;
use crate::models::pad_on_disc::motion::substep::SHORTEST;

/// What a trial step found in a lane, as bits of numbers of the width of a lane. The motion turned in it.
pub(super) const TURN: u64 = 1;
/// It is too long for the friction law, and is taken again with another length.
pub(super) const TOO_LONG: u64 = 2;
/// The scalar code has to judge it.
pub(super) const EVENT: u64 = 4;
/// It ended the step after which the lane is to be visited.
pub(super) const DUE: u64 = 8;

/// Steps and substeps of some lanes.
#[derive(Debug, Clone)]
pub(super) struct Pace<const N: usize> {
    /// Length of a step, and of the next trial step.
    pub step: [f64; N],
    pub length: [f64; N],
    /// The shortest trial step.
    pub shortest: [f64; N],
    /// What is over of the step, and the longest substep that is tried next.
    pub done: [f64; N],
    pub longest: [f64; N],
    /// Substeps of the motion that are over, how many it may take, and steps that are over. Whole numbers.
    pub substeps: [f64; N],
    pub most_substeps: [f64; N],
    pub steps: [f64; N],
    /// The number of steps after which the lane is visited.
    pub due: [f64; N],
    /// 1 if the scalar code judges every trial step, else 0.
    pub is_held: [u64; N],
    /// All bits if there is a sample, else none.
    pub is_busy: [u64; N],
    /// Of the last trial step: its length, when in the step it began, and what it found.
    pub taken: [f64; N],
    pub began: [f64; N],
    pub findings: [u64; N],
}

/// What a kernel knows of trial steps; 0 or 1 for each lane where it is true or false.
#[derive(Clone, Copy)]
pub(super) struct Trials<const N: usize> {
    pub is_too_long: [u64; N],
    pub is_event: [u64; N],
    pub turns: [u64; N],
    /// The length of the next trial step over this one's, see
    /// [`FrictionSteps::judge`](crate::models::pad_on_disc::motion::friction_steps::FrictionSteps::judge).
    pub factor: [f64; N],
}

impl<const N: usize> Trials<N> {
    #[inline(always)]
    pub fn plain() -> Self {
        Self { is_too_long: [0; N], is_event: [0; N], turns: [0; N], factor: [MOST_GROWTH; N] }
    }
}

impl<const N: usize> Default for Pace<N> {
    /// Without samples.
    fn default() -> Self {
        let zero = [0.0; N];
        Self {
            step: zero,
            length: zero,
            shortest: zero,
            done: zero,
            longest: zero,
            substeps: zero,
            most_substeps: [f64::INFINITY; N],
            steps: zero,
            due: zero,
            is_held: [0; N],
            is_busy: [0; N],
            taken: zero,
            began: zero,
            findings: [0; N],
        }
    }
}

impl<const N: usize> Pace<N> {
    /// Lanes whose trial step was plain go on to their next one. A trial step that was too long is shortened. The other
    /// lanes stay. The findings say which.
    #[inline(always)]
    pub fn judge(&mut self, trials: &Trials<N>) {
        for l in 0..N {
            let (step, length, done) = (self.step[l], self.length[l], self.done[l]);
            let (held, free) = (self.is_held[l], 1 - self.is_held[l]);
            let is_too_long = trials.is_too_long[l] & u64::from(length > self.shortest[l]) & free;
            let done_then = done + length;
            let left = step - done_then;
            let is_over = (length >= step - done) | (left <= LEAST_REMAINDER * step);
            let substeps = self.substeps[l] + 1.0;
            let is_exhausted = u64::from(!is_over & (substeps >= self.most_substeps[l]));
            let is_event = (trials.is_event[l] | held | is_exhausted) & (1 - is_too_long);
            let is_plain = (is_too_long | is_event) == 0;
            let steps = if is_plain & is_over { self.steps[l] + 1.0 } else { self.steps[l] };
            let is_due = u64::from(is_plain & is_over & (steps >= self.due[l]));
            let turns = u64::from(is_plain) & trials.turns[l];
            let findings = (turns * TURN) | (is_too_long * TOO_LONG) | (is_event * EVENT) | (is_due * DUE);
            self.findings[l] = findings & self.is_busy[l];
            (self.taken[l], self.began[l]) = (length, done);
            // Of the substep after this one.
            let done_next = if is_over { 0.0 } else { done_then };
            let growth = if trials.is_too_long[l] == 1 { MOST_GROWTH } else { trials.factor[l] };
            let longest = if is_over { step } else { growth * length };
            let left = step - done_next;
            let next = if left < longest { left } else { longest };
            self.steps[l] = steps;
            self.substeps[l] = if is_plain { substeps } else { self.substeps[l] };
            self.done[l] = if is_plain { done_next } else { done };
            self.longest[l] = if is_plain { longest } else { self.longest[l] };
            let shortened = if is_too_long == 1 { trials.factor[l] * length } else { length };
            self.length[l] = if is_plain { next } else { shortened };
            self.shortest[l] = if is_plain { SHORTEST * next } else { self.shortest[l] };
        }
    }

    /// The lanes with findings, one bit each.
    #[inline(always)]
    pub fn visits(&self) -> u64 {
        let mut lanes = 0;
        for l in 0..N {
            lanes |= u64::from(self.findings[l] != 0) << l;
        }
        lanes
    }
}
