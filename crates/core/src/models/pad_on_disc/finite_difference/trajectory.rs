//! The recorded motion of pad and disc on the grid, with its verdict.

use crate::model::verdict::Verdict;
use crate::models::pad_on_disc::criterion::flexible_monitor::{FlexibleMonitor, MonitorOptions};
use crate::models::pad_on_disc::criterion::monitor::{Monitor, is_check_due};
use crate::models::pad_on_disc::criterion::settings::TimeDomainSettings;
use crate::models::pad_on_disc::finite_difference::brake::{Allotment, FiniteDifferenceBrake, FiniteDifferenceError};
use crate::models::pad_on_disc::flexible_disc::linear_stability::LinearStability;
use crate::models::pad_on_disc::motion::event_log::EventLog;
use crate::models::pad_on_disc::motion::integrator::Observer;
use crate::models::pad_on_disc::motion::start::Start;
use crate::models::pad_on_disc::pad::contact_state::ContactState;
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::RandomInputs;
use crate::models::pad_on_disc::trajectory::recording::Trajectory;
use crate::models::pad_on_disc::trajectory::settled::{Outcome, SettledMotion};

/// Records the events of a motion, and monitors it until its verdict is certain.
struct MonitoredLog {
    log: EventLog,
    monitor: FlexibleMonitor,
    verdict: Option<Verdict>,
}

impl MonitoredLog {
    fn report(&mut self, event: impl Fn(&mut dyn Observer)) {
        event(&mut self.log);
        if self.verdict.is_none() {
            event(&mut self.monitor);
            self.verdict = self.monitor.verdict();
        }
    }

    /// See [`Monitor::check`].
    fn check(&mut self, x: f64, speed: f64) {
        if self.verdict.is_none() {
            self.monitor.check(x, speed);
            self.verdict = self.monitor.verdict();
        }
    }
}

impl Observer for MonitoredLog {
    fn turns(&mut self, time: f64, x: f64) {
        self.report(|observer| observer.turns(time, x));
    }
    fn sticks(&mut self, time: f64, x: f64) {
        self.report(|observer| observer.sticks(time, x));
    }
    fn holds(&mut self, time: f64) {
        self.report(|observer| observer.holds(time));
    }
    fn slips(&mut self, time: f64) {
        self.report(|observer| observer.slips(time));
    }
    fn overtakes(&mut self, x: f64, then: ContactState) {
        self.report(|observer| observer.overtakes(x, then));
    }
}

impl FiniteDifferenceBrake {
    /// The motion of pad and disc for a scaled time `horizon`, from steady sliding with x where `start` says;
    /// `displacement` is that of [`TimeDomainSettings`]. Its moments are a whole number of steps apart, about as far as
    /// those of [`TimeDomain::trajectory`]. The verdict is that of the motion up to `horizon`.
    ///
    /// [`TimeDomain::trajectory`]: crate::models::pad_on_disc::criterion::time_domain::TimeDomain::trajectory
    ///
    /// # Errors
    /// [`FiniteDifferenceError::Settings`] if `displacement` or `horizon` is out of range,
    /// [`FiniteDifferenceError::Brake`] if there is no equilibrium to start from.
    pub fn trajectory(
        &self,
        inputs: RandomInputs,
        start: Start,
        displacement: f64,
        horizon: f64,
        allotment: Allotment,
    ) -> Result<Trajectory, FiniteDifferenceError> {
        TimeDomainSettings { start, displacement, horizon, ..Default::default() }.validate()?;
        let (mut simulation, equilibrium) = self.start(inputs, start, displacement, allotment)?;
        let (x, u) = (simulation.pad.state.q[0], simulation.pad.state.u[0]);
        let slowest_transient = self.modal.brake.equations.slowest_transient();
        // Linear stability is that of the modes: on the grid a motion would take long to show it.
        let linear_growth_fed_by = match self.modal.brake.by_eigenvalues(inputs)? {
            LinearStability::Stable => None,
            LinearStability::Unstable { fed_by } => Some(fed_by),
        };
        let smallest_cycle = self.pad().smallest_cycle();
        let options = MonitorOptions {
            slowest_transient,
            smallest_cycle,
            until_settled: false,
            linear_growth_fed_by,
            refinement: 1.0,
        };
        let monitor = FlexibleMonitor::new(options, equilibrium, displacement, (u == 0.0).then_some(x));
        let rises = inputs.static_friction < self.pad().kinetic_friction;
        let verdict = monitor.verdict().or(rises.then_some(Verdict::Stable));
        let log = EventLog::from_start(simulation.pad.contact);
        let mut monitored = MonitoredLog { log, monitor, verdict };

        let every = (self.modal.step / self.step_length).round().max(1.0) as u64;
        let interval = every as f64 * self.step_length;
        let intervals = (horizon / interval).ceil() as u64;
        let mut moments = vec![simulation.moment()];
        let mut broken = false;
        while !broken && moments.len() as u64 <= intervals {
            broken = (0..every).any(|_| !simulation.step(&mut monitored));
            if !broken {
                if is_check_due(moments.len() as u64) {
                    let state = &simulation.pad.state;
                    monitored.check(state.q[0], state.u[0]);
                }
                moments.push(simulation.moment());
            }
        }
        let at_end = if broken { Verdict::Failed } else { Verdict::Undecided };
        let law = self.modal.brake.brake().friction_law().with_static(inputs.static_friction);
        let mut speeds = moments.iter().map(|moment| moment.sliding_speed);
        let lacks_friction = !law.without_friction().is_empty()
            && (law.at_rest() <= 0.0 || speeds.any(|speed| law.coefficient(speed) <= 0.0));
        let verdict = if lacks_friction { Verdict::Stable } else { monitored.verdict.unwrap_or(at_end) };
        let fed_by = (verdict == Verdict::Unstable).then(|| monitored.monitor.fed_by());
        let outcome = match lacks_friction {
            true => Outcome::Unknown,
            false => Outcome::by_verdict(verdict, fed_by, &law),
        };
        let settled = SettledMotion::summarise(&monitored.log, &moments, intervals, interval, outcome);
        Ok(Trajectory { moments, interval, settled, verdict, fed_by, lacks_friction })
    }
}

#[cfg(test)]
mod tests;
