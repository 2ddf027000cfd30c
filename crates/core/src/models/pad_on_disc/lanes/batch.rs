//! The time-domain criterion for many samples at once.

use std::cell::Cell;

use crate::model::decision::Decision;
use crate::models::pad_on_disc::criterion::time_domain::{System, TimeDomain};
use crate::models::pad_on_disc::flexible_disc::brake::FlexibleBrake;
use crate::models::pad_on_disc::lanes::bundle::Bundle;
use crate::models::pad_on_disc::lanes::dispatch::InstructionSet;
use crate::models::pad_on_disc::lanes::flexible::FlexibleBundle;
use crate::models::pad_on_disc::lanes::queue::{QueuedSample, SampleQueue};
use crate::models::pad_on_disc::lanes::rigid::RigidBundle;
use crate::models::pad_on_disc::lanes::scheduling::run;
use crate::models::pad_on_disc::motion::friction_steps::FrictionSteps;
use crate::models::pad_on_disc::motion::integrator::{Equations, Motion, Reserve, Step};
use crate::models::pad_on_disc::pad::contact_state::ContactState;
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::RandomInputs;

impl TimeDomain {
    /// Decides every sample of a list as [`TimeDomain::decide`] does, with the same bits, many at once. Linear
    /// stability is [`FlexibleBrake::linear_stability`]'s here and [`FlexibleBrake::by_eigenvalues`]'s there; tests
    /// compare the two.
    ///
    /// [`FlexibleBrake::linear_stability`]: crate::models::pad_on_disc::flexible_disc::brake::FlexibleBrake::linear_stability
    /// [`FlexibleBrake::by_eigenvalues`]: crate::models::pad_on_disc::flexible_disc::brake::FlexibleBrake::by_eigenvalues
    #[must_use]
    pub fn decide_all(&self, inputs: &[RandomInputs]) -> Vec<Decision> {
        self.decide_all_with(inputs, InstructionSet::widest())
    }

    /// Decides every sample of a list as [`TimeDomain::decide`] does, with the same bits, by the lanes of `set`.
    ///
    /// # Panics
    /// If this processor does not have `set`.
    #[must_use]
    #[doc(hidden)]
    pub fn decide_all_with(&self, inputs: &[RandomInputs], set: InstructionSet) -> Vec<Decision> {
        let decisions = self.decide_until_with(inputs, &|| false, set);
        decisions.into_iter().map(|decision| decision.unwrap_or(Decision::FAILED)).collect()
    }

    /// [`TimeDomain::decide_all`] until `is_stopped`, which is asked about once a millisecond. Samples whose motion is
    /// cut short, or does not begin, have no decision.
    #[must_use]
    pub fn decide_until(&self, inputs: &[RandomInputs], is_stopped: &dyn Fn() -> bool) -> Vec<Option<Decision>> {
        self.decide_until_with(inputs, is_stopped, InstructionSet::widest())
    }

    fn decide_until_with(
        &self,
        inputs: &[RandomInputs],
        is_stopped: &dyn Fn() -> bool,
        set: InstructionSet,
    ) -> Vec<Option<Decision>> {
        let mut list = List { criterion: self, inputs, is_stopped, next: 0, decisions: vec![None; inputs.len()] };
        decide_queue_with(&mut list, set);
        list.decisions
    }

    /// The trial steps ([`crate::models::pad_on_disc::motion::substep`]) that all samples of a list take to their verdicts, for benchmarks.
    #[must_use]
    #[doc(hidden)]
    pub fn count_steps(&self, inputs: &[RandomInputs]) -> u64 {
        let taken = Cell::new(0);
        for &inputs in inputs {
            match &self.system {
                System::Rigid(brake) => {
                    let sample = brake.sample(inputs);
                    if let Ok((motion, mut monitor)) = self.start_rigid(&sample, inputs, self.start()) {
                        self.simulate(&Counted { equations: &sample, taken: &taken }, motion, &mut monitor, brake.step);
                    }
                }
                System::Flexible(motion) => {
                    let sample = motion.sample(inputs);
                    let start = self.start_flexible(&sample, self.start(), FlexibleBrake::linear_stability);
                    if let Ok((start, mut monitor)) = start {
                        self.simulate(&Counted { equations: &sample, taken: &taken }, start, &mut monitor, motion.step);
                    }
                }
            }
        }
        taken.get()
    }

    /// Takes `steps` steps of every sample of a list, for benchmarks of the steps alone: no motion is monitored, and
    /// all must be plain slip. Without a `set` the scalar code takes them one sample after the other; else full bundles
    /// of lanes do, and samples that do not fill a bundle are left out.
    ///
    /// # Panics
    /// If this processor does not have `set`.
    #[doc(hidden)]
    pub fn take_steps(&self, inputs: &[RandomInputs], steps: u32, set: Option<InstructionSet>) {
        match (&self.system, set) {
            (System::Rigid(brake), Some(set)) => {
                take_bundle_steps(self, inputs, steps, &mut RigidBundle::new(brake), set);
            }
            (System::Flexible(motion), Some(set)) => {
                take_bundle_steps(self, inputs, steps, &mut FlexibleBundle::new(motion), set);
            }
            (System::Rigid(brake), None) => {
                for &inputs in inputs {
                    let sample = brake.sample(inputs);
                    take_scalar_steps(&sample, self.rigid_start(&sample, self.start()), steps, brake.step);
                }
            }
            (System::Flexible(motion), None) => {
                for &inputs in inputs {
                    let sample = motion.sample(inputs);
                    if let Ok((start, _)) = self.flexible_start(&sample, self.start()) {
                        take_scalar_steps(&sample, start, steps, motion.step);
                    }
                }
            }
        }
    }
}

/// Decides the samples of a queue, with the bits of [`TimeDomain::decide_from`], many at once: until there are no more,
/// or until the queue stops.
///
/// Samples share lanes if they have the disc model and the friction law of the first one, and on a flexible disc its
/// mode shapes and patch; coefficients, steps and starts may differ. Lanes know all friction laws. Stribeck's law
/// counts as three: with the exponent 1, with 2, and with any others, which may differ between lanes. The scalar code
/// simulates samples that do not share lanes one by one, and also the last few.
pub fn decide_queue<'q>(queue: &mut (impl SampleQueue<'q> + ?Sized)) {
    decide_queue_with(queue, InstructionSet::widest());
}

/// [`decide_queue`] by the lanes of `set`.
///
/// # Panics
/// If this processor does not have `set`.
#[doc(hidden)]
pub fn decide_queue_with<'q>(queue: &mut (impl SampleQueue<'q> + ?Sized), set: InstructionSet) {
    assert!(InstructionSet::available().contains(&set), "this processor has no {set:?}");
    let Some(first) = queue.next() else { return };
    match &first.criterion.system {
        System::Rigid(brake) => run(first, queue, &mut RigidBundle::new(brake), set),
        System::Flexible(motion) => {
            let mut bundle = FlexibleBundle::new(motion);
            run(first, queue, &mut bundle, set);
        }
    }
}

/// The samples of one brake, in a list.
struct List<'q> {
    criterion: &'q TimeDomain,
    inputs: &'q [RandomInputs],
    is_stopped: &'q dyn Fn() -> bool,
    next: usize,
    decisions: Vec<Option<Decision>>,
}

impl<'q> SampleQueue<'q> for List<'q> {
    fn next(&mut self) -> Option<QueuedSample<'q>> {
        let &inputs = self.inputs.get(self.next).filter(|_| !self.is_stopped())?;
        let ticket = self.next as u64;
        self.next += 1;
        Some(QueuedSample::new(ticket, self.criterion, inputs))
    }

    fn decided(&mut self, ticket: u64, decision: Decision) {
        if let Some(place) = self.decisions.get_mut(ticket as usize) {
            *place = Some(decision);
        }
    }

    fn is_stopped(&self) -> bool {
        (self.is_stopped)()
    }
}

/// Equations whose steps are counted.
struct Counted<'a, E> {
    equations: &'a E,
    taken: &'a Cell<u64>,
}

impl<E: Equations> Equations for Counted<'_, E> {
    type State = E::State;

    fn step(&self, state: &E::State, contact: ContactState, h: f64) -> Step<E::State> {
        self.taken.set(self.taken.get() + 1);
        self.equations.step(state, contact, h)
    }
    fn acceleration(&self, state: &E::State, contact: ContactState) -> f64 {
        self.equations.acceleration(state, contact)
    }
    fn tangential(&self, state: &E::State) -> (f64, f64) {
        self.equations.tangential(state)
    }
    fn disc_speed(&self) -> f64 {
        self.equations.disc_speed()
    }
    fn moving_with_disc(&self, state: &E::State) -> E::State {
        self.equations.moving_with_disc(state)
    }
    fn reserve(&self, state: &E::State) -> Reserve {
        self.equations.reserve(state)
    }
    fn meeting_rate(&self) -> f64 {
        self.equations.meeting_rate()
    }
    fn friction_steps(&self) -> &FrictionSteps {
        self.equations.friction_steps()
    }
}

fn take_scalar_steps<E: Equations>(equations: &E, motion: Motion<E::State>, steps: u32, h: f64) {
    let mut state = motion.state;
    for _ in 0..steps {
        state = equations.step(&state, ContactState::Slip, h).next;
    }
    std::hint::black_box(equations.tangential(&state));
}

fn take_bundle_steps<'q, B: Bundle<'q>>(
    criterion: &'q TimeDomain,
    inputs: &[RandomInputs],
    steps: u32,
    bundle: &mut B,
    set: InstructionSet,
) {
    assert!(InstructionSet::available().contains(&set), "this processor has no {set:?}");
    for inputs in inputs.chunks_exact(B::LANES) {
        for (lane, &inputs) in inputs.iter().enumerate() {
            if let Some((motion, step)) = bundle.place(lane, &QueuedSample::new(0, criterion, inputs)) {
                bundle.set_next(lane, &motion);
                let (pace, l) = bundle.pace(lane);
                pace.step[l] = step;
                pace.length[l] = step;
                pace.shortest[l] = f64::INFINITY;
                pace.longest[l] = step;
                pace.due[l] = f64::INFINITY;
            }
        }
        for _ in 0..steps {
            bundle.step(set);
        }
        std::hint::black_box(bundle.tangential(0));
    }
}

#[cfg(test)]
mod tests;
