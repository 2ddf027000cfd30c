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

/// The relative standard error of the mean cost that is small enough.
pub const ENOUGH: f64 = 0.07;

/// Fewest batches from which the error of their mean is known.
pub const LEAST_BATCHES: u64 = 12;

/// By how many standard errors later batches are cheaper than earlier ones where that is no chance, and by more than a cost has
/// to be known.
const CHEAPER: f64 = 1.5;

/// Units are expected to go on to become cheaper: the relative standard error of their time is this times the logarithm of the
/// factor by which it falls for that.
const OF_THE_FALL: f64 = 0.3;

/// The least time of a unit is taken to be that of the cheapest of so many batches.
const LEAST_PART: usize = 10;

/// Of more batches it is asked once in so many whether they are enough.
const OFTEN: u64 = 64;

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
    /// How units become cheaper, where they do.
    pub fall: Option<Fall>,
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
        match self.fall.map(|fall| fall.of_units(units)) {
            None => Time { seconds, error: seconds * self.error },
            Some(Share { share, error }) => {
                let seconds = seconds * share;
                Time { seconds, error: seconds * libm::hypot(self.error, error) }
            }
        }
    }
}

/// Units that become cheaper the more of them were finished, as where what was found of some samples serves others: n of them
/// take a time proportional to n^a, until one takes the least time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fall {
    /// How many were measured.
    measured: f64,
    /// The exponent a, below 1.
    exponent: f64,
    /// Its standard error.
    error: f64,
    /// The least time of a unit over the mean of those that were measured.
    least: f64,
}

/// The time of units over what they would take if each took as long as those that were measured.
#[derive(Debug, Clone, Copy)]
struct Share {
    share: f64,
    /// The relative standard error.
    error: f64,
}

impl Fall {
    fn of_units(self, units: f64) -> Share {
        let Self { measured, exponent, error, least } = self;
        // Over the time of those that were measured: all until one takes the least time, and those after it.
        let last = libm::pow(least / exponent, 1.0 / (exponent - 1.0)).max(1.0);
        let times = units / measured;
        let share = (libm::pow(times.min(last), exponent) + (times - last).max(0.0) * least) / times;
        let of_exponent = error * libm::log(times.min(last));
        // It is known no less than a time that was measured once.
        Share { share, error: libm::hypot(of_exponent, OF_THE_FALL * libm::log(share)).min(OF_ONE) }
    }
}

/// Measured times of units of one kind.
#[derive(Debug, Clone, Default)]
pub struct Measured {
    first_set_up: Option<f64>,
    set_ups: Mean,
    /// Seconds and units of each batch, in the order in which they were finished.
    batches: Vec<[f64; 2]>,
    /// Seconds of batches that were not finished.
    unfinished: f64,
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
        self.batches.push([seconds, units]);
    }

    /// Units were not finished in this time. It counts all the same: those that were finished are the quicker ones.
    pub fn unfinished(&mut self, seconds: f64) {
        self.unfinished += seconds;
    }

    /// The number of batches that were finished.
    pub fn batches(&self) -> u64 {
        self.batches.len() as u64
    }

    /// How units become cheaper: where the later half of the batches is cheaper than the earlier one, and that is no chance.
    fn fall(&self) -> Option<Fall> {
        if self.batches() < 2 * LEAST_BATCHES {
            return None;
        }
        let halves = self.batches.split_at(self.batches.len() / 2);
        let [before, after] = [costs(halves.0), costs(halves.1)];
        let [mean_before, mean_after] = [&before, &after].map(|costs| costs.sum() / costs.count() as f64);
        let [error_before, error_after] = [&before, &after].map(Mean::relative_error);
        let difference = mean_before - mean_after;
        let chance = CHEAPER * libm::hypot(mean_before * error_before, mean_after * error_after);
        let is_known = difference.is_finite() && chance.is_finite();
        if !is_known || difference <= chance.max(ENOUGH * mean_before) {
            return None;
        }
        // Twice as many take 2^a times the time.
        let ratio = mean_after / mean_before;
        let mut all: Vec<f64> = self.batches.iter().map(|[seconds, units]| seconds / units).collect();
        all.sort_by(f64::total_cmp);
        Some(Fall {
            measured: self.batches.iter().map(|[_, units]| units).sum(),
            exponent: libm::log2(1.0 + ratio),
            error: libm::hypot(error_before, error_after) * ratio / (1.0 + ratio) / std::f64::consts::LN_2,
            least: all[all.len() / LEAST_PART] / (0.5 * (mean_before + mean_after)),
        })
    }

    /// Whether units cost as much at the end as at the beginning, or more.
    pub fn is_steady(&self) -> bool {
        self.fall().is_none()
    }

    /// Whether what a unit costs is known well, from how much the batches differ.
    pub fn is_certain(&self) -> bool {
        self.batches() >= LEAST_BATCHES && costs(&self.batches).relative_error() <= ENOUGH
    }

    /// Whether what a unit costs is known well enough for a trial of so many seconds to end: well, or, as far as it is known, so
    /// many units on so many threads are done sooner than they are measured.
    pub fn is_settled(&self, seconds: f64, units: f64, threads: usize) -> bool {
        let is_asked = self.batches() < OFTEN || self.batches().is_multiple_of(OFTEN);
        let is_done = |cost: UnitCost| self.batches() >= LEAST_BATCHES && units * cost.unit <= seconds * threads as f64;
        is_asked && (self.cost().is_some_and(is_done) || self.is_certain() && self.is_steady())
    }

    /// What a unit costs, where units become cheaper if they do; `None` if none was finished.
    pub fn falling_cost(&self) -> Option<UnitCost> {
        self.cost().map(|cost| UnitCost { fall: self.fall(), ..cost })
    }

    /// What a unit costs; `None` if none was finished.
    pub fn cost(&self) -> Option<UnitCost> {
        let [seconds, units] = [0, 1].map(|place| self.batches.iter().map(|batch| batch[place]).sum::<f64>());
        if units <= 0.0 {
            return None;
        }
        let scatter = Some(costs(&self.batches).relative_error()).filter(|error| error.is_finite()).unwrap_or(0.0);
        let first_set_up = self.first_set_up.unwrap_or(0.0);
        // Where only the first one was measured, the others are taken to be like it.
        let set_up = match self.set_ups.count() {
            0 => first_set_up,
            count => self.set_ups.sum() / count as f64,
        };
        let unit = (seconds + self.unfinished) / units;
        let error = scatter.max(OF_ONE / self.batches() as f64);
        Some(UnitCost { first_set_up, set_up, unit, error, fall: None })
    }
}

/// Seconds of a unit in each batch.
fn costs(batches: &[[f64; 2]]) -> Mean {
    let mut costs = Mean::default();
    batches.iter().for_each(|[seconds, units]| costs.add(seconds / units));
    costs
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
    fn units_that_become_cheaper_are_expected_to_go_on_so_until_they_take_the_least_time() {
        // Of n units n^0.6 take 10 seconds, the others a tenth of one.
        let dear = |units: u32| libm::pow(f64::from(units), 0.6).floor();
        let taken = |units: u32| 10.0 * dear(units) + 0.1 * (f64::from(units) - dear(units));
        let mut measured = Measured::default();
        (0..400).for_each(|turn| measured.batch(taken(turn + 1) - taken(turn), 1.0));
        assert!(!measured.is_steady());
        let cost = measured.falling_cost().unwrap();
        for units in [200, 400, 1000, 2000] {
            let (time, expected) = (cost.units(f64::from(units), 1.0, 2), taken(units) / 2.0);
            assert!((time.seconds / expected - 1.0).abs() < 0.1, "{time:?} {expected}");
        }
        // Far beyond what was measured they take the least time.
        let [time, more] = [1e6, 2e6].map(|units| cost.units(units, 1.0, 1));
        assert!(((more.seconds - time.seconds) / 1e5 - 1.0).abs() < 1e-9, "{time:?} {more:?}");
        assert!((time.seconds / taken(1_000_000) - 1.0).abs() < time.error / time.seconds, "{time:?}");
        // How much that saves says how uncertain it is.
        let [near, far] = [400.0, 1e6].map(|units| cost.units(units, 1.0, 1)).map(|time| time.error / time.seconds);
        assert!(near < 0.2 && far > 0.6, "{near} {far}");
    }

    #[test]
    fn units_that_differ_by_chance_do_not_become_cheaper() {
        let mut measured = Measured::default();
        // A single dear one is in one of the halves.
        (0..48).for_each(|turn| measured.batch(if turn == 5 { 50.0 } else { 1.0 }, 1.0));
        assert_eq!((measured.is_steady(), measured.falling_cost()), (true, measured.cost()));
        // Dearer ones at the end.
        (0..48).for_each(|turn| measured.batch(if turn % 2 == 0 { 8.0 } else { 9.0 }, 1.0));
        assert!(measured.is_steady());
        // By a little, with thousands of batches.
        let mut little = Measured::default();
        (0..10_000).for_each(|turn| little.batch(if turn < 5000 { 1.0 } else { 0.96 }, 1.0));
        assert!(little.is_steady());
        // Without any time, by a coarse clock.
        for [before, after] in [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0]] {
            let mut coarse = Measured::default();
            (0..48).for_each(|turn| coarse.batch(if turn < 24 { before } else { after }, 1.0));
            let time = coarse.falling_cost().unwrap().units(1e6, 1.0, 1);
            assert!(time.seconds.is_finite() && time.error.is_finite(), "{before} {after} {time:?}");
        }
        // Few.
        let mut few = Measured::default();
        (0..2 * LEAST_BATCHES - 1).for_each(|turn| few.batch(if turn < LEAST_BATCHES { 8.0 } else { 1.0 }, 1.0));
        assert!(few.is_steady());
        few.batch(1.0, 1.0);
        assert!(!few.is_steady());
    }

    #[test]
    fn a_trial_ends_when_the_cost_is_known_or_is_less_than_its_own() {
        let mut measured = Measured::default();
        // They differ by more than what is allowed, and become cheaper.
        let batch = |turn: u64| if turn < LEAST_BATCHES { 8.0 } else { 1.0 };
        (0..LEAST_BATCHES - 1).for_each(|turn| measured.batch(batch(turn), 1.0));
        assert!(!measured.is_settled(100.0, 1.0, 2));
        (LEAST_BATCHES - 1..2 * LEAST_BATCHES).for_each(|turn| measured.batch(batch(turn), 1.0));
        // 4.5 seconds each on average: 20 of them take 45 on two threads, and 90 on one.
        for (units, threads, is_settled) in [(20.0, 2, true), (20.0, 1, false), (25.0, 2, false), (10.0, 1, true)] {
            assert_eq!(measured.is_settled(50.0, units, threads), is_settled, "{units} {threads}");
        }
        let mut alike = Measured::default();
        (0..2 * LEAST_BATCHES).for_each(|_| alike.batch(1.0, 1.0));
        assert!(alike.is_settled(0.5, 1e9, 2));
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
