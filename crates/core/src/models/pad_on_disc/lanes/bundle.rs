//! Lanes with one kind of equations.

use crate::model::decision::Decision;
use crate::models::pad_on_disc::criterion::monitor::Monitor;
use crate::models::pad_on_disc::lanes::BLOCK;
use crate::models::pad_on_disc::lanes::dispatch::InstructionSet;
use crate::models::pad_on_disc::lanes::pace::Pace;
use crate::models::pad_on_disc::lanes::queue::QueuedSample;
use crate::models::pad_on_disc::motion::integrator::{Equations, Motion, Step};
use crate::models::pad_on_disc::pad::contact_state::ContactState;

/// A motion at its beginning.
pub(super) struct Begun<S, M> {
    pub motion: Motion<S>,
    pub monitor: M,
    /// Length of its steps.
    pub step: f64,
}

/// Lanes with one kind of equations. Each has two states: the present one, from which the last trial step was taken,
/// and the next one, its end or what the scalar code puts there, from which the following trial step is taken.
pub(super) trait Bundle<'q> {
    /// Lanes, at most 64.
    const LANES: usize;

    type State: Copy;
    type Equations<'a>: Equations<State = Self::State>
    where
        Self: 'a;
    type Monitor: Monitor;

    /// Samples that are taken from the queue together, and what is found of them then.
    const AT_ONCE: usize;
    type Known: Default;

    /// What is found of some samples together.
    fn examine(&self, samples: &[QueuedSample<'q>]) -> Vec<Self::Known>;

    /// Gives a lane the equations of a sample, for steps divided by `divisor`; or decides the sample if it needs no
    /// simulation, or none in this bundle. Nothing has to be known of a sample that is simulated again, with a divisor
    /// above 1. It takes a shorter way to the same as soon as it `is_stopped`, if there is one.
    fn begin(
        &mut self,
        lane: usize,
        sample: &QueuedSample<'q>,
        divisor: f64,
        known: Self::Known,
        is_stopped: &dyn Fn() -> bool,
    ) -> Result<Begun<Self::State, Self::Monitor>, Decision>;

    /// Gives a lane the equations of a sample, decided or not. Returns the motion at its beginning and the length of
    /// its steps, if it has equations.
    fn place(&mut self, lane: usize, sample: &QueuedSample<'q>) -> Option<(Motion<Self::State>, f64)>;

    /// A trial step in every lane, from the next states of the last one.
    fn step(&mut self, set: InstructionSet);

    /// The lanes with findings, one bit each.
    fn visits(&self) -> u64;

    /// The steps of a lane and its neighbours, and its place among them.
    fn pace(&mut self, lane: usize) -> (&mut Pace<BLOCK>, usize);

    /// The equations of a lane.
    fn equations(&self, lane: usize) -> Option<Self::Equations<'_>>;

    /// x in the present state, and x' and x'' at both ends of the trial step.
    fn tangential(&self, lane: usize) -> (f64, (f64, f64), (f64, f64));

    /// x and x' in the next state.
    fn next_tangential(&self, lane: usize) -> (f64, f64);

    /// The present state.
    fn present(&self, lane: usize) -> Self::State;

    /// The next state.
    fn next(&self, lane: usize) -> Self::State;

    /// The trial step of a lane, unless the scalar code has to take it.
    fn trial(&self, lane: usize) -> Option<Step<Self::State>>;

    /// Whether lanes take steps in a state of contact.
    fn simulates(contact: ContactState) -> bool;

    /// Sets the next state.
    fn set_next(&mut self, lane: usize, motion: &Motion<Self::State>);

    /// Makes the present state the next one.
    fn keep(&mut self, lane: usize);
}
