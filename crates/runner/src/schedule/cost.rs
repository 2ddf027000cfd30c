//! What a job costs, from measured times: what is set up once, and what each unit of work takes.
//!
//! A unit is a sample, an integral or a tile of a verdict map. Before the first one of a configuration something may be set up
//! that all others of it share. It is measured apart: as if each unit paid it, a job of many samples would seem to take
//! hours that takes seconds.

use std::fmt;
use std::ops::Add;

use crate::schedule::time_left::{Mean, Prediction};

/// The relative standard error of a time that was measured once. Of several it is taken to be this over their number at
/// least: few units tell little of how much they differ.
const OF_ONE: f64 = 1.0;

/// A time in seconds, and its standard error.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Time {
    /// Seconds.
    pub seconds: f64,
    /// Their standard error.
    pub error: f64,
}

impl Time {
    /// A time that is known.
    pub fn known(seconds: f64) -> Self {
        Self { seconds, error: 0.0 }
    }

    /// How it is said.
    pub fn prediction(self) -> Prediction {
        match self.seconds {
            seconds if seconds > 0.0 => Prediction::from_rate(seconds, self.error / seconds),
            _ => Prediction::About(0.0),
        }
    }
}

impl Add for Time {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let error = (self.error * self.error + other.error * other.error).sqrt();
        Self { seconds: self.seconds + other.seconds, error }
    }
}

/// Why a time is not known: not one unit was finished while it was measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unmeasured {
    /// What a unit is.
    pub what: &'static str,
    /// How long it was measured.
    pub seconds: f64,
}

impl fmt::Display for Unmeasured {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "no {} was finished in {:.1} seconds of measuring", self.what, self.seconds)
    }
}

/// The cost of units of one kind.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct UnitCost {
    /// Seconds in which the first configuration is set up.
    pub first_set_up: f64,
    /// Seconds in which each other one is.
    pub set_up: f64,
    /// Seconds of a unit on one thread, while all threads are at work.
    pub unit: f64,
    /// Their relative standard error.
    pub error: f64,
}

impl UnitCost {
    /// How long all configurations are set up on `threads` threads. The others wait for the first one.
    pub fn set_ups(&self, configurations: usize, threads: usize) -> f64 {
        let others = configurations.saturating_sub(1);
        self.first_set_up + others.div_ceil(threads.max(1)) as f64 * self.set_up
    }

    /// How long units take on `threads` threads without what is set up, if a thread does up to `serial` of them one after
    /// the other.
    pub fn units(&self, units: f64, serial: f64, threads: usize) -> Time {
        let seconds = (units / threads as f64).max(units.min(serial)) * self.unit;
        Time { seconds, error: seconds * self.error }
    }
}

/// Measured times of units of one kind.
#[derive(Debug, Clone, Copy, Default)]
pub struct Measured {
    first_set_up: Option<f64>,
    set_ups: Mean,
    /// Of batches of units: seconds of a unit.
    batches: Mean,
    seconds: f64,
    units: f64,
}

impl Measured {
    /// A configuration was set up.
    pub fn set_up(&mut self, seconds: f64) {
        match self.first_set_up {
            None => self.first_set_up = Some(seconds),
            Some(_) => self.set_ups.add(seconds),
        }
    }

    /// A batch of units was finished.
    pub fn batch(&mut self, seconds: f64, units: f64) {
        self.batches.add(seconds / units);
        self.seconds += seconds;
        self.units += units;
    }

    /// Units were not finished in this time. It counts all the same: those that were finished are the quicker ones.
    pub fn unfinished(&mut self, seconds: f64) {
        self.seconds += seconds;
    }

    /// The number of batches that were finished.
    pub fn batches(&self) -> u64 {
        self.batches.count()
    }

    /// The relative standard error of the mean cost, from how much the batches differ.
    pub fn relative_error(&self) -> f64 {
        self.batches.relative_error()
    }

    /// What a unit costs; `None` if none was finished.
    pub fn cost(&self) -> Option<UnitCost> {
        if self.units <= 0.0 {
            return None;
        }
        let scatter = Some(self.batches.relative_error()).filter(|error| error.is_finite()).unwrap_or(0.0);
        let first_set_up = self.first_set_up.unwrap_or(0.0);
        // Where only the first one was measured, the others are taken to be like it.
        let set_up = match self.set_ups.count() {
            0 => first_set_up,
            count => self.set_ups.sum() / count as f64,
        };
        let unit = self.seconds / self.units;
        Some(UnitCost { first_set_up, set_up, unit, error: scatter.max(OF_ONE / self.batches.count() as f64) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_set_up_counts_once_and_not_with_each_unit() {
        let mut measured = Measured::default();
        measured.set_up(3.0);
        (0..20).for_each(|_| measured.batch(0.05, 100.0));
        let cost = measured.cost().unwrap();
        assert!((cost.unit - 0.0005).abs() < 1e-15 && (cost.first_set_up - 3.0).abs() < 1e-15);
        // 14,000 samples on one thread: 3 and 7 seconds. As if each paid for it, it would be twelve hours.
        assert!((cost.set_ups(1, 1) - 3.0).abs() < 1e-12);
        let time = Time::known(cost.set_ups(1, 1)) + cost.units(14_000.0, 1.0, 1);
        assert!((time.seconds - 10.0).abs() < 1e-9, "{time:?}");
        assert_eq!(time.prediction().to_string(), "about 10 seconds");
    }

    #[test]
    fn configurations_are_set_up_on_all_threads_after_the_first() {
        let mut measured = Measured::default();
        measured.batch(1.0, 1.0);
        measured.set_up(4.0);
        assert!((measured.cost().unwrap().set_ups(5, 2) - 12.0).abs() < 1e-12);
        measured.set_up(0.5);
        measured.set_up(1.5);
        let cost = measured.cost().unwrap();
        assert!((cost.set_ups(1, 2) - 4.0).abs() < 1e-12);
        assert!((cost.set_ups(5, 2) - 6.0).abs() < 1e-12);
        assert!((cost.set_ups(6, 2) - 7.0).abs() < 1e-12);
        assert!((cost.set_ups(5, 100) - 5.0).abs() < 1e-12);
    }

    #[test]
    fn a_thread_does_a_piece_of_the_work_alone() {
        let cost = UnitCost { unit: 0.1, ..UnitCost::default() };
        assert!((cost.units(1000.0, 10.0, 4).seconds - 25.0).abs() < 1e-9);
        assert!((cost.units(1000.0, 500.0, 4).seconds - 50.0).abs() < 1e-9);
        assert!((cost.units(100.0, 500.0, 4).seconds - 10.0).abs() < 1e-9);
    }

    #[test]
    fn what_was_not_finished_makes_the_others_dearer() {
        let mut measured = Measured::default();
        measured.unfinished(5.0);
        assert_eq!(measured.cost(), None);
        (0..10).for_each(|_| measured.batch(1.0, 1.0));
        assert!((measured.cost().unwrap().unit - 1.5).abs() < 1e-12);
    }

    #[test]
    fn few_measurements_give_a_range_and_many_a_number() {
        let said = |batches: u32| {
            let mut measured = Measured::default();
            (0..batches).for_each(|_| measured.batch(2.0, 1.0));
            measured.cost().unwrap().units(5.0, 1.0, 1).prediction()
        };
        assert!(matches!(said(1), Prediction::Between(low, high) if low < 4.0 && high > 25.0));
        assert!(matches!(said(3), Prediction::Between(low, high) if low > 5.0 && high < 20.0));
        assert_eq!(said(10).to_string(), "about 10 seconds");
    }

    #[test]
    fn what_is_not_known_is_said_with_its_reason() {
        let why = Unmeasured { what: "search for rare events", seconds: 6.94 };
        assert_eq!(why.to_string(), "no search for rare events was finished in 6.9 seconds of measuring");
    }
}
