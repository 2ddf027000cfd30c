//! The time-domain criterion: the motion of a sample is simulated until its verdict is certain.
//!
//! # What stable and unstable mean
//!
//! *Stable* is a motion that converges to the sliding equilibrium of the model in use. *Unstable* is one that does not:
//! it sticks and slips for ever, or it keeps to a cycle without sticking, however small. All criteria, discs and starts
//! share this meaning:
//!
//! * A **linearly unstable** equilibrium attracts no motion. Such a sample is unstable whatever the start, and its
//!   motion is simulated only for its settled amplitude.
//! * With a **linearly stable** equilibrium the start decides, and the motion is simulated. If it starts outside an
//!   unstable cycle around the equilibrium, it does not return, however small its displacement is.
//!
//! *Undecided* is a motion that shows neither before the horizon; *failed* is one whose computation broke down.
//!
//! # Steps
//!
//! Steps are those of the classical fourth-order Runge-Kutta method. Their length is 0.1 over the natural frequency of
//! the pad on a rigid disc, 0.45 over the highest frequency of pad, contact and kept disc modes on a flexible one, and
//! no longer than 1 over the highest damping rate. Such a step is divided where the friction law is steep. For
//! Stribeck's law with the exponent 1, with `r = |v - x'| / v_s`,
//!
//! ```text
//! h |x''| / v_s <= 0.25 (1 + r/5 + r^2/50),      h G (f_s - f_c) / v_s <= 0.4 (1 + r + ... + r^4/24)
//! ```
//!
//! and the other laws have limits of this kind (module `friction_steps`). With these steps the saddle-node of
//! stick-slip is accurate to 1e-5 for disc speeds of ten to a thousand Stribeck velocities, and to 2.1e-5 at lower
//! ones, as the tests check.
//!
//! On a flexible disc, contact and disc ring along, and errors of the steps move the end of stick-slip by 1e-4 of the
//! speed, in single brakes by 5e-3. So a motion whose verdict may depend on such errors is simulated again with steps of
//! half the length, and of a quarter if that does not settle it (module `confirmation`).

use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use thiserror::Error;

use crate::model::decision::Decision;
use crate::model::recorded::NOTHING;
use crate::model::verdict::Verdict;
use crate::models::pad_on_disc::criterion::confirmation::Confirmation;
use crate::models::pad_on_disc::criterion::flexible_monitor::{FlexibleMonitor, MonitorOptions};
use crate::models::pad_on_disc::criterion::monitor::{Monitor, is_check_due};
use crate::models::pad_on_disc::criterion::rigid_monitor::RigidMonitor;
use crate::models::pad_on_disc::criterion::settings::{SettingsError, TimeDomainSettings};
use crate::models::pad_on_disc::flexible_disc::brake::FlexibleBrake;
use crate::models::pad_on_disc::flexible_disc::error::FlexibleError;
use crate::models::pad_on_disc::flexible_disc::linear_stability::LinearStability;
use crate::models::pad_on_disc::motion::advance::{Substeps, advance_counted};
use crate::models::pad_on_disc::motion::flexible::{FlexibleMotion, FlexibleSample, FlexibleState};
use crate::models::pad_on_disc::motion::integrator::{Equations, Motion, Stopped};
use crate::models::pad_on_disc::motion::rigid::{RigidBrake, RigidSample, RigidState};
use crate::models::pad_on_disc::motion::start::{Start, StartError, TangentialStart, check_reach};
use crate::models::pad_on_disc::pad::contact_state::ContactState;
use crate::models::pad_on_disc::parameters::ParameterError;
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};

/// Largest number of steps to the horizon, when a motion is simulated for the first time.
const MOST_STEPS: f64 = 1e8;

/// Substeps of a motion at most, from which on the motion may not divide a step further: a tenth of a second of work.
const MOST_SUBSTEPS: u64 = 1 << 20;

/// Further substeps for each step to the horizon on a flexible disc, where no return map decides in place of the
/// simulation.
const SUBSTEPS_PER_STEP: u64 = 100;

/// Why there is no time-domain criterion, or no motion of a sample.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum TimeDomainError {
    /// A setting out of range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// A given start that no pad can be in.
    #[error(transparent)]
    Start(#[from] StartError),
    /// The model of the disc, or its equilibrium.
    #[error(transparent)]
    Brake(#[from] FlexibleError),
}

impl From<ParameterError> for TimeDomainError {
    fn from(error: ParameterError) -> Self {
        Self::Brake(error.into())
    }
}

/// The disc of a simulation.
#[derive(Debug, Clone)]
pub enum DiscModel {
    /// The pad alone: no disc, `sin(phi) = 0`, `cos(phi) = 1`.
    Rigid,
    /// All of the equations, with this many modes of the disc.
    Flexible {
        /// See [`FlexibleBrake::with_modes`].
        modes: usize,
    },
}

/// The time-domain criterion at one rotating speed.
#[derive(Debug, Clone)]
pub struct TimeDomain {
    pub(crate) settings: TimeDomainSettings,
    pub(crate) system: System,
    pub(crate) brake: PadOnDisc,
}

#[derive(Debug, Clone)]
pub(crate) enum System {
    Rigid(RigidBrake),
    Flexible(Arc<FlexibleMotion>),
}

impl TimeDomain {
    /// Prepares the criterion.
    ///
    /// # Errors
    /// [`TimeDomainError::Settings`] if a setting is out of range or the horizon is more than 1e8 steps away;
    /// [`TimeDomainError::Brake`] as [`FlexibleBrake::with_modes`].
    pub fn new(brake: &PadOnDisc, disc: &DiscModel, settings: TimeDomainSettings) -> Result<Self, TimeDomainError> {
        settings.validate()?;
        let settings = TimeDomainSettings { start: settings.start.scaled(brake.scales()), ..settings };
        let system = match disc {
            DiscModel::Rigid => System::Rigid(RigidBrake::new(brake)),
            DiscModel::Flexible { modes } => {
                System::Flexible(Arc::new(FlexibleMotion::new(FlexibleBrake::with_modes(brake.clone(), *modes)?)))
            }
        };
        let criterion = Self { settings, system, brake: brake.clone() };
        criterion.check_horizon(criterion.step_length())?;
        Ok(criterion)
    }

    /// Whether the horizon is not too many steps of a length away.
    pub(crate) fn check_horizon(&self, step: f64) -> Result<(), SettingsError> {
        let (value, largest) = (self.settings.horizon, MOST_STEPS * step);
        if value > largest { Err(SettingsError::OutOfRange { key: "horizon", value, largest }) } else { Ok(()) }
    }

    /// The same criterion with all steps shorter by a factor, for studies of convergence.
    #[must_use]
    #[doc(hidden)]
    pub fn with_steps_divided_by(mut self, divisor: f64) -> Self {
        let (step, refinement) = match &mut self.system {
            System::Rigid(brake) => (&mut brake.step, &mut brake.refinement),
            System::Flexible(brake) => {
                let brake = Arc::make_mut(brake);
                (&mut brake.step, &mut brake.refinement)
            }
        };
        *step /= divisor;
        *refinement /= divisor;
        self
    }

    /// The same criterion for motions that start elsewhere.
    #[must_use]
    pub fn with_start(&self, start: Start) -> Self {
        let start = start.scaled(self.brake.scales());
        Self { settings: TimeDomainSettings { start, ..self.settings }, ..self.clone() }
    }

    /// Checks that a sample can start where the settings say.
    ///
    /// # Errors
    /// [`TimeDomainError::Start`] if no pad can be there, [`TimeDomainError::Brake`] if there is no steady sliding to
    /// start from.
    pub fn check_start(&self, inputs: RandomInputs) -> Result<(), TimeDomainError> {
        match &self.system {
            System::Rigid(motion) => self.check_rigid_start(&motion.sample(inputs), self.settings.start)?,
            System::Flexible(motion) => {
                let sample = motion.sample(inputs);
                self.check_flexible_start(&sample, &self.flexible_start(&sample, self.settings.start)?.0)?;
            }
        }
        Ok(())
    }

    pub(crate) fn check_rigid_start(&self, sample: &RigidSample, start: Start) -> Result<(), StartError> {
        let state = self.rigid_start(sample, start).state;
        check_reach((state.x, state.u), sample.brake.stiffness)
    }

    fn check_flexible_start(
        &self,
        sample: &FlexibleSample<'_>,
        motion: &Motion<FlexibleState>,
    ) -> Result<(), StartError> {
        let pad = &sample.brake.equations.coefficients.pad;
        let state = &motion.state;
        check_reach((state.q[0], state.u[0]), pad.tangential_stiffness + pad.contact_tangential)?;
        let (normal, angle) = (state.q[1], state.q[2]);
        let is_upright = angle.abs() < FRAC_PI_2;
        if is_upright && normal.is_finite() && sample.rates(state, ContactState::Slip).0.pressure > 0.0 {
            return Ok(());
        }
        let steady = sample.equilibrium().map_or(f64::NAN, |steady| steady.q[1]);
        Err(StartError::LiftedOff { normal, angle, steady })
    }

    /// Decides one sample. A sample without preload presses nothing together and is stable; so is one whose friction
    /// rises with speed (`f_s < f_c`), unless pad and disc feed each other without any fall of friction, and one whose
    /// motion meets a speed at which a measured curve is at or below 0 (module `met_speeds`).
    #[must_use]
    pub fn decide(&self, inputs: RandomInputs) -> Decision {
        self.decide_from(inputs, self.settings.start)
    }

    /// Decides one sample that starts elsewhere than the settings say.
    #[must_use]
    pub fn decide_from(&self, inputs: RandomInputs, start: Start) -> Decision {
        let start = start.scaled(self.brake.scales());
        match &self.system {
            System::Rigid(motion) => {
                let sample = motion.sample(inputs);
                match self.start_rigid(&sample, inputs, start) {
                    Ok((start, mut monitor)) => self.simulate(&sample, start, &mut monitor, motion.step),
                    Err(known) => known,
                }
            }
            System::Flexible(motion) => self.decide_flexible(motion, inputs, start),
        }
    }

    /// Decides a sample on a flexible disc, in finer steps where the verdict may depend on errors of the steps.
    fn decide_flexible(&self, motion: &FlexibleMotion, inputs: RandomInputs, start: Start) -> Decision {
        if self.flexible_meets_no_friction(motion, inputs, start) {
            return Decision::OUTSIDE_PHYSICS;
        }
        let mut confirmation = Confirmation::NONE;
        loop {
            let divisor = confirmation.divisor;
            let sample = motion.sample_in_finer_steps(inputs, divisor);
            // Only motions about a stable equilibrium are simulated again.
            let stability = |brake: &FlexibleBrake, inputs: RandomInputs| match divisor {
                1.0 => brake.by_eigenvalues(inputs),
                _ => Ok(LinearStability::Stable),
            };
            let (begun, mut monitor) = match self.start_flexible(&sample, start, stability) {
                Ok(begun) => begun,
                Err(known) => return known,
            };
            let decision = self.simulate(&sample, begun, &mut monitor, motion.step / divisor);
            if let Some(decision) = confirmation.accept(decision, monitor.is_doubtful()) {
                return decision;
            }
        }
    }

    /// The same criterion for another brake. A flexible disc keeps its number of modes. A start in SI units was scaled
    /// for the present brake and stays as it is; see [`TimeDomain::with_start`].
    ///
    /// # Errors
    /// As [`TimeDomain::new`].
    pub fn with_brake(&self, brake: &PadOnDisc) -> Result<Self, TimeDomainError> {
        let system = match &self.system {
            System::Rigid(own) => System::Rigid(RigidBrake::new(brake).refined_as(own)),
            System::Flexible(motion) => System::Flexible(Arc::new(motion.with_brake(brake.clone())?)),
        };
        let criterion = Self { settings: self.settings, system, brake: brake.clone() };
        criterion.check_horizon(criterion.step_length())?;
        Ok(criterion)
    }

    /// Where motions start.
    #[must_use]
    pub fn start(&self) -> Start {
        self.settings.start
    }

    /// The length of a step, scaled time.
    #[must_use]
    pub fn step_length(&self) -> f64 {
        match &self.system {
            System::Rigid(motion) => motion.step,
            System::Flexible(motion) => motion.step,
        }
    }

    /// The motion that a sample starts with, and its monitor; or the decision if it needs no simulation.
    pub(crate) fn start_rigid(
        &self,
        sample: &RigidSample,
        inputs: RandomInputs,
        start: Start,
    ) -> Result<(Motion<RigidState>, RigidMonitor), Decision> {
        if sample.brake.is_outside_physics(inputs) {
            return Err(Decision::OUTSIDE_PHYSICS);
        }
        let motion = self.rigid_start(sample, start);
        let starts_at_release = motion.contact == ContactState::Stick;
        let state = (motion.state.x, motion.state.u);
        let mut monitor =
            RigidMonitor::new(sample.planar_motion(), self.settings.until_settled(), state, starts_at_release);
        if let Start::Given(_) = start {
            self.check_rigid_start(sample, start).map_err(|_| Decision::FAILED)?;
            monitor.starts_in(motion.contact, motion.state.x);
        }
        if self.rigid_meets_no_friction(sample, inputs, start) {
            return Err(Decision::OUTSIDE_PHYSICS);
        }
        self.unless_decided(motion, monitor)
    }

    /// See [`TimeDomain::start_rigid`].
    ///
    /// `stability` finds the linear stability of the sample.
    pub(crate) fn start_flexible(
        &self,
        sample: &FlexibleSample<'_>,
        start: Start,
        stability: impl Fn(&FlexibleBrake, RandomInputs) -> Result<LinearStability, FlexibleError>,
    ) -> Result<(Motion<FlexibleState>, FlexibleMonitor), Decision> {
        let (brake, inputs) = (sample.brake, sample.inputs);
        if inputs.preload <= 0.0 || brake.brake().lacks_friction(inputs) {
            return Err(Decision::OUTSIDE_PHYSICS);
        }
        let linear_growth_fed_by = match stability(brake, inputs) {
            Ok(LinearStability::Stable) if brake.brake().is_outside_physics(inputs) => {
                return Err(Decision::OUTSIDE_PHYSICS);
            }
            Ok(LinearStability::Stable) => None,
            Ok(LinearStability::Unstable { fed_by }) => Some(fed_by),
            Err(_) => return Err(Decision::FAILED),
        };
        let is_given = matches!(start, Start::Given(_));
        if let (Some(fed_by), false, false) = (linear_growth_fed_by, self.settings.until_settled(), is_given) {
            // No motion needs to be started. That of a given start is checked first.
            return Err(Decision { fed_by: Some(fed_by as usize), ..Decision::from(Verdict::Unstable) });
        }
        let options = MonitorOptions {
            slowest_transient: brake.equations.slowest_transient(),
            smallest_cycle: brake.equations.coefficients.pad.smallest_cycle(),
            until_settled: self.settings.until_settled(),
            linear_growth_fed_by,
            refinement: sample.friction_steps.refinement,
        };
        let (motion, equilibrium) = self.flexible_start(sample, start).map_err(|_| Decision::FAILED)?;
        let starts_turning_at = (motion.state.u[0] == 0.0).then_some(motion.state.q[0]);
        let mut monitor = FlexibleMonitor::new(options, equilibrium, self.settings.displacement, starts_turning_at);
        if let Start::Given(_) = start {
            self.check_flexible_start(sample, &motion).map_err(|_| Decision::FAILED)?;
            let steady = sample.equilibrium().map_err(|_| Decision::FAILED)?.q;
            let q = &motion.state.q;
            monitor.is_excited_by((q[1] - steady[1]).abs() + (q[2] - steady[2]).abs());
        }
        self.unless_decided(motion, monitor)
    }

    fn unless_decided<S, M: Monitor>(&self, motion: Motion<S>, monitor: M) -> Result<(Motion<S>, M), Decision> {
        match monitor.verdict() {
            None => Ok((motion, monitor)),
            Some(verdict) => Err(self.conclude(verdict, &monitor, 0.0)),
        }
    }

    /// The motion at its beginning.
    pub(crate) fn rigid_start(&self, sample: &RigidSample, start: Start) -> Motion<RigidState> {
        let displacement = self.settings.displacement;
        let release = || sample.release();
        let TangentialStart { x, speed } =
            start.tangential(displacement, sample.equilibrium(), release, sample.brake.disc_speed);
        start.motion(sample, RigidState { x, u: speed })
    }

    /// The motion at its beginning, and the equilibrium's x.
    pub(crate) fn flexible_start(
        &self,
        sample: &FlexibleSample<'_>,
        start: Start,
    ) -> Result<(Motion<FlexibleState>, f64), FlexibleError> {
        let mut state = sample.equilibrium()?;
        let equilibrium = state.q[0];
        let displacement = self.settings.displacement;
        let release = || sample.release(&state);
        let TangentialStart { x, speed } =
            start.tangential(displacement, equilibrium, release, sample.brake.equations.coefficients.pad.disc_speed);
        state.q[0] = x;
        state.u[0] = speed;
        (state.q[1], state.q[2]) = start.normal_and_angle((state.q[1], state.q[2]));
        Ok((start.motion(sample, state), equilibrium))
    }

    /// Simulates a motion to its verdict or to the horizon.
    pub(crate) fn simulate<E: Equations, M: Monitor>(
        &self,
        equations: &E,
        mut motion: Motion<E::State>,
        monitor: &mut M,
        h: f64,
    ) -> Decision {
        let steps = self.steps_to_horizon(h);
        let mut substeps = Substeps::at_most(self.most_substeps(h));
        for step in 0..steps {
            let time = step as f64 * h;
            let advanced = advance_counted(equations, &mut motion, (time, h), &mut substeps, monitor);
            if let Err(stopped) = advanced {
                return self.conclude_stopped(stopped, monitor, equations.tangential(&motion.state), time);
            }
            if is_check_due(step + 1) {
                let (x, u) = equations.tangential(&motion.state);
                monitor.check(x, u);
            }
            if let Some(verdict) = monitor.verdict() {
                return self.conclude(verdict, monitor, (step + 1) as f64 * h);
            }
        }
        self.conclude_without_verdict(Verdict::Undecided, monitor, steps as f64 * h)
    }

    /// The decision on a motion that is not simulated further, at x and x'. One that took too many substeps is left to
    /// the monitor, and is undecided if that does not know its fate.
    pub(crate) fn conclude_stopped<M: Monitor>(
        &self,
        stopped: Stopped,
        monitor: &mut M,
        (x, speed): (f64, f64),
        time: f64,
    ) -> Decision {
        if stopped == Stopped::BrokeDown {
            return self.conclude_without_verdict(Verdict::Failed, monitor, time);
        }
        monitor.is_exhausted(x, speed);
        match monitor.verdict() {
            Some(verdict) => self.conclude(verdict, monitor, time),
            None => self.conclude_without_verdict(Verdict::Undecided, monitor, time),
        }
    }

    /// How many substeps of steps of length `h` a motion may take. It does not depend on the horizon where a return map
    /// takes over.
    pub(crate) fn most_substeps(&self, h: f64) -> u64 {
        match self.system {
            System::Rigid(_) => MOST_SUBSTEPS,
            System::Flexible(_) => MOST_SUBSTEPS + SUBSTEPS_PER_STEP * self.steps_to_horizon(h),
        }
    }

    /// The decision on a motion that ended at the horizon or broke down. If it is known to be unstable, that is its
    /// verdict, unless the settled amplitude is what decides.
    pub(crate) fn conclude_without_verdict<M: Monitor>(&self, otherwise: Verdict, monitor: &M, time: f64) -> Decision {
        let known = monitor.is_unstable() && self.settings.amplitude_index.is_none();
        let verdict = if known { Verdict::Unstable } else { otherwise };
        Decision { verdict, recorded: NOTHING, time, fed_by: known.then(|| monitor.fed_by() as usize) }
    }

    pub(crate) fn steps_to_horizon(&self, h: f64) -> u64 {
        (self.settings.horizon / h).ceil() as u64
    }

    /// The decision on a motion with this verdict. With the paper's index the settled amplitude decides.
    pub(crate) fn conclude<M: Monitor>(&self, verdict: Verdict, monitor: &M, time: f64) -> Decision {
        let amplitude = (verdict == Verdict::Unstable && self.settings.until_settled()).then(|| monitor.amplitude());
        let verdict = match (self.settings.amplitude_index, amplitude) {
            (Some(limit), Some(amplitude)) if amplitude <= limit => Verdict::Stable,
            _ => verdict,
        };
        let is_unstable = verdict == Verdict::Unstable;
        let mut recorded = NOTHING;
        recorded[0] = amplitude.filter(|_| is_unstable);
        Decision { verdict, recorded, time, fed_by: is_unstable.then(|| monitor.fed_by() as usize) }
    }
}

#[cfg(test)]
mod tests;
