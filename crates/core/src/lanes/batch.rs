//! The time-domain criterion for many samples at once.

use crate::criterion::decision::Decision;
use crate::criterion::time_domain::{System, TimeDomain};
use crate::friction::shape::Shape;
use crate::lanes::dispatch::InstructionSet;
use crate::lanes::flexible::FlexibleBundle;
use crate::lanes::rigid::RigidBundle;
use crate::lanes::scheduling::{Bundle, run};
use crate::motion::integrator::{Equations, Motion};
use crate::pad::contact_state::ContactState;
use crate::rigid_disc::pad_on_disc::RandomInputs;

impl TimeDomain {
    /// Decides every sample of a list as [`TimeDomain::decide`] does, with the same bits, many at once. Linear
    /// stability is [`FlexibleBrake::linear_stability`]'s here and [`FlexibleBrake::by_eigenvalues`]'s there; tests
    /// compare the two.
    ///
    /// [`FlexibleBrake::linear_stability`]: crate::flexible_disc::brake::FlexibleBrake::linear_stability
    /// [`FlexibleBrake::by_eigenvalues`]: crate::flexible_disc::brake::FlexibleBrake::by_eigenvalues
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
        assert!(InstructionSet::available().contains(&set), "this processor has no {set:?}");
        match &self.system {
            System::Rigid(brake) if brake.law.shape == Shape::Tustin && brake.law.additional == 0.0 => {
                run(self, inputs, &mut RigidBundle::new(brake), set)
            }
            System::Flexible(motion)
                if motion.brake.equations.pad.friction_shape == Shape::Tustin
                    && motion.brake.equations.pad.additional_friction == 0.0 =>
            {
                run(self, inputs, &mut FlexibleBundle::new(motion), set)
            }
            _ => inputs.iter().map(|&inputs| self.decide(inputs)).collect(),
        }
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
                    take_scalar_steps(&sample, self.rigid_start(&sample), steps, brake.step);
                }
            }
            (System::Flexible(motion), None) => {
                for &inputs in inputs {
                    let sample = motion.sample(inputs);
                    if let Ok((start, _)) = self.flexible_start(&sample) {
                        take_scalar_steps(&sample, start, steps, motion.step);
                    }
                }
            }
        }
    }
}

fn take_scalar_steps<E: Equations>(equations: &E, motion: Motion<E::State>, steps: u32, h: f64) {
    let mut state = motion.state;
    for _ in 0..steps {
        state = equations.step(&state, ContactState::Slip, h).next;
    }
    std::hint::black_box(equations.tangential(&state));
}

fn take_bundle_steps<B: Bundle>(
    criterion: &TimeDomain,
    inputs: &[RandomInputs],
    steps: u32,
    bundle: &mut B,
    set: InstructionSet,
) {
    assert!(InstructionSet::available().contains(&set), "this processor has no {set:?}");
    for inputs in inputs.chunks_exact(B::LANES) {
        for (lane, &inputs) in inputs.iter().enumerate() {
            bundle.place(criterion, lane, inputs);
        }
        bundle.commit();
        for _ in 0..steps {
            bundle.step(set);
            bundle.commit();
        }
        std::hint::black_box(bundle.tangential(0));
    }
}

#[cfg(test)]
mod tests;
