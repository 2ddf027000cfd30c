//! The events of a motion, kept with their times.

use crate::models::pad_on_disc::motion::integrator::Observer;
use crate::models::pad_on_disc::pad::contact_state::ContactState;

/// Turning points, sticks and releases of a motion.
#[derive(Debug, Clone, Default)]
pub(crate) struct EventLog {
    /// Times and displacements of turning points.
    pub turns: Vec<(f64, f64)>,
    /// Times at which pad and disc begin to stick.
    pub sticks: Vec<f64>,
    /// Times at which they are released.
    pub slips: Vec<f64>,
    /// In order, all times at which they begin to stick, also where they have not left each other since the release, and all
    /// at which they cease to; with whether they stick from then on.
    changes: Vec<(f64, bool)>,
    /// Whether the pad has passed the disc since the disc last held it.
    has_passed: bool,
}

impl Observer for EventLog {
    fn turns(&mut self, time: f64, x: f64) {
        self.turns.push((time, x));
    }
    fn sticks(&mut self, time: f64, _: f64) {
        if self.sticks.last().is_none_or(|last| *last < time) {
            self.sticks.push(time);
        }
    }
    fn holds(&mut self, time: f64) {
        self.changes.push((time, true));
        // A pad that passes the disc and is held by it at once is not seen to stick.
        if std::mem::take(&mut self.has_passed) {
            self.sticks.push(time);
        }
    }
    fn overtakes(&mut self, _: f64, _: ContactState) {
        self.has_passed = true;
    }
    fn slips(&mut self, time: f64) {
        self.slips.push(time);
        self.changes.push((time, false));
    }
}

impl EventLog {
    /// The log of a motion that starts in a state of contact.
    pub fn from_start(contact: ContactState) -> Self {
        let mut log = Self::default();
        if contact == ContactState::Stick {
            log.holds(0.0);
        }
        log
    }

    /// Time in stick between two moments.
    pub fn time_in_stick(&self, from: f64, to: f64) -> f64 {
        let share = |begin: f64, end: f64| (end.min(to) - begin.max(from)).max(0.0);
        let (mut begun, mut sum) = (None, 0.0);
        for &(time, sticks) in &self.changes {
            if sticks {
                begun.get_or_insert(time);
            } else if let Some(begin) = begun.take() {
                sum += share(begin, time);
            }
        }
        sum + begun.map_or(0.0, |begin| share(begin, f64::INFINITY))
    }

    /// Times of the releases after which pad and disc leave each other: of several between two sticks, the last.
    pub fn releases(&self) -> Vec<f64> {
        let mut sticks = self.sticks.iter().copied().peekable();
        let mut releases: Vec<f64> = Vec::new();
        for &slip in &self.slips {
            // The first one belongs to no stick of the log if the motion starts in stick.
            let mut is_after_a_stick = releases.is_empty();
            while sticks.next_if(|stick| *stick <= slip).is_some() {
                is_after_a_stick = true;
            }
            match releases.last_mut() {
                Some(last) if !is_after_a_stick => *last = slip,
                _ => releases.push(slip),
            }
        }
        releases
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A motion that starts in stick, and once is released and held again before it leaves the disc.
    #[test]
    fn a_release_that_leads_nowhere_shifts_no_other() {
        let mut log = EventLog::from_start(ContactState::Stick);
        log.slips(1.0);
        for (stick, held) in [(3.0, None), (6.0, Some(6.5)), (9.0, None)] {
            log.sticks(stick, 0.0);
            log.holds(stick);
            if let Some(again) = held {
                log.slips(again);
                log.holds(again);
            }
            log.slips(stick + 1.0);
        }
        assert_eq!(log.time_in_stick(0.0, 20.0), 4.0);
        assert_eq!(log.time_in_stick(6.25, 9.5), 1.25);
        assert_eq!(log.releases(), [1.0, 4.0, 7.0, 10.0]);
    }

    /// A motion that begins at the disc's speed is held and released at once.
    #[test]
    fn stick_of_no_length_shifts_nothing() {
        let mut log = EventLog::default();
        log.holds(0.0);
        log.slips(0.0);
        log.holds(5.0);
        log.slips(7.0);
        assert_eq!(log.time_in_stick(0.0, 10.0), 2.0);
    }

    /// A pad that passes the disc may be held by it at once, or come back first: only then is it reported to stick.
    #[test]
    fn stick_after_overtaking_counts() {
        let mut log = EventLog::default();
        for cycle in 0..5 {
            let begin = 10.0 * f64::from(cycle);
            log.overtakes(0.0, ContactState::Overtaking);
            log.holds(begin + 2.0);
            if cycle % 2 == 1 {
                log.sticks(begin + 2.0, 0.0);
            }
            log.slips(begin + 4.0);
        }
        assert_eq!(log.time_in_stick(0.0, 50.0), 10.0);
        assert_eq!(log.releases(), [4.0, 14.0, 24.0, 34.0, 44.0]);
        log.holds(52.0);
        assert_eq!(log.time_in_stick(50.0, 60.0), 8.0);
    }
}
