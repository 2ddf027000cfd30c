//! The events of a motion, kept with their times.

use crate::models::pad_on_disc::motion::integrator::Observer;

/// Turning points, sticks and releases of a motion.
#[derive(Debug, Clone, Default)]
pub(crate) struct EventLog {
    /// Times and displacements of turning points.
    pub turns: Vec<(f64, f64)>,
    /// Times at which pad and disc begin to stick.
    pub sticks: Vec<f64>,
    /// Times at which they are released.
    pub slips: Vec<f64>,
}

impl Observer for EventLog {
    fn turns(&mut self, time: f64, x: f64) {
        self.turns.push((time, x));
    }
    fn sticks(&mut self, time: f64, _: f64) {
        self.sticks.push(time);
    }
    fn slips(&mut self, time: f64) {
        self.slips.push(time);
    }
}

impl EventLog {
    /// Time in stick between two moments.
    pub fn time_in_stick(&self, from: f64, to: f64) -> f64 {
        // A motion that starts in stick is released before it is seen to stick.
        let starts_stuck = self.slips.first().is_some_and(|slip| self.sticks.first().is_none_or(|stick| slip < stick));
        let begins = starts_stuck.then_some(0.0).into_iter().chain(self.sticks.iter().copied());
        let ends = self.slips.iter().copied().chain([f64::INFINITY]);
        begins.zip(ends).map(|(begin, end)| (end.min(to) - begin.max(from)).max(0.0)).fold(0.0, |sum, time| sum + time)
    }
}
