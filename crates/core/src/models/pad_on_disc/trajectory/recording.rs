//! The motion of one sample, recorded at every step.

use crate::model::decision::Decision;
use crate::model::verdict::Verdict;
use crate::models::pad_on_disc::criterion::settings::TimeDomainSettings;
use crate::models::pad_on_disc::criterion::time_domain::{System, TimeDomain, TimeDomainError};
use crate::models::pad_on_disc::degree_of_freedom::DegreeOfFreedom;
use crate::models::pad_on_disc::flexible_disc::error::FlexibleError;
use crate::models::pad_on_disc::motion::advance::advance;
use crate::models::pad_on_disc::motion::event_log::EventLog;
use crate::models::pad_on_disc::motion::integrator::{Equations, Motion};
use crate::models::pad_on_disc::motion::moment::Moment;
use crate::models::pad_on_disc::motion::rigid_with_angle::{RigidAngleState, RigidWithAngle};
use crate::models::pad_on_disc::pad::contact_state::ContactState;
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::RandomInputs;
use crate::models::pad_on_disc::trajectory::settled::{Outcome, SettledMotion};

/// A motion, sampled at even intervals.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory {
    /// All moments, `interval` apart; fewer than asked for if the computation broke down.
    pub moments: Vec<Moment>,
    /// Scaled time between moments.
    pub interval: f64,
    /// What the motion settled to; `None` if the computation broke down or nothing was simulated.
    pub settled: Option<SettledMotion>,
    /// The verdict on the motion as a run would give it, whether it is certain before the trajectory ends or not.
    pub verdict: Verdict,
    /// What feeds the motion if it is unstable.
    pub fed_by: Option<DegreeOfFreedom>,
    /// Whether the friction coefficient is at or below 0 at a sliding speed that the motion meets, or at rest: it is outside
    /// the model, and stable by definition.
    pub lacks_friction: bool,
}

impl TimeDomain {
    /// The motion of one sample for a time `horizon`, recorded at every step. The steps are those in which
    /// [`TimeDomain::decide`] simulates it for the first time, bit for bit; the verdict on a flexible disc
    /// may come from a second simulation in finer ones.
    ///
    /// # Errors
    /// [`TimeDomainError`] if there is no equilibrium to start from, or if the horizon is out of range.
    pub fn trajectory(&self, inputs: RandomInputs, horizon: f64) -> Result<Trajectory, TimeDomainError> {
        TimeDomainSettings { horizon, ..self.settings }.validate()?;
        let pressed = inputs.preload > 0.0;
        if !pressed {
            return Err(FlexibleError::NotPressed { preload: inputs.preload }.into());
        }
        let h = self.step_length();
        let steps = (horizon / h).ceil() as u64;
        let (log, moments) = match &self.system {
            System::Rigid(motion) => {
                let sample = motion.sample(inputs);
                let start = self.rigid_start(&sample, self.settings.start);
                let equilibrium = self.brake.sliding_equilibrium_at(inputs);
                let length = self.brake.scales().length;
                let equations = RigidWithAngle::new(sample, &self.brake);
                let state = RigidAngleState::with_angle(start.state, equilibrium.angle);
                record(&equations, Motion { state, contact: start.contact }, h, steps, |time, state, contact| {
                    equations.moment(time, state, contact, &equilibrium, length)
                })
            }
            System::Flexible(motion) => {
                let sample = motion.sample(inputs);
                let start = self.flexible_start(&sample, self.settings.start)?.0;
                record(&sample, start, h, steps, |time, state, contact| sample.moment(time, state, contact))
            }
        };
        let Decision { verdict, fed_by, .. } = self.decide(inputs);
        let fed_by = fed_by.map(|place| DegreeOfFreedom::ALL[place]);
        let lacks_friction = self.brake.lacks_friction(inputs) || self.meets_no_friction(inputs);
        let outcome = if lacks_friction { Outcome::Unknown } else { self.outcome(inputs, verdict, fed_by) };
        let settled = SettledMotion::summarise(&log, &moments, steps, h, outcome);
        Ok(Trajectory { moments, interval: h, settled, verdict, fed_by, lacks_friction })
    }

    /// How a motion with friction and with this verdict ends. On a rigid disc its amplitude then is known, whatever its
    /// own settings ask for.
    fn outcome(&self, inputs: RandomInputs, verdict: Verdict, fed_by: Option<DegreeOfFreedom>) -> Outcome {
        let law = self.brake.friction_law();
        match &self.system {
            System::Rigid(_) => {
                let settings = TimeDomainSettings { record_amplitude: true, amplitude_index: None, ..self.settings };
                let Decision { verdict, fed_by, recorded, .. } = Self { settings, ..self.clone() }.decide(inputs);
                let fed_by = fed_by.map(|place| DegreeOfFreedom::ALL[place]);
                recorded[0].map_or_else(|| Outcome::by_verdict(verdict, fed_by, law), Outcome::Amplitude)
            }
            // With the paper's index, stable is what has a small amplitude.
            System::Flexible(_) if self.settings.amplitude_index.is_some() => Outcome::Unknown,
            System::Flexible(_) => Outcome::by_verdict(verdict, fed_by, law),
        }
    }
}

/// Simulates a motion and keeps every moment, until the end or until it breaks down.
fn record<E: Equations>(
    equations: &E,
    mut motion: Motion<E::State>,
    h: f64,
    steps: u64,
    moment: impl Fn(f64, &E::State, ContactState) -> Moment,
) -> (EventLog, Vec<Moment>) {
    let mut log = EventLog::from_start(motion.contact);
    let mut moments = Vec::new();
    moments.push(moment(0.0, &motion.state, motion.contact));
    for step in 0..steps {
        if advance(equations, &mut motion, step as f64 * h, h, &mut log).is_err() {
            break;
        }
        moments.push(moment((step + 1) as f64 * h, &motion.state, motion.contact));
    }
    (log, moments)
}

#[cfg(test)]
mod tests;
