//! Whether stick-slip persists from cycle to cycle.
//!
//! | state | event | then |
//! |---|---|---|
//! | free | sticks | sticking, the first stick |
//! | sticking | slips | slipping; the share of the cycle spent in stick is known from the second release on |
//! | slipping | swings, up to [`FIRST_SWINGS`](crate::models::pad_on_disc::criterion::transients::FIRST_SWINGS) of them | slipping: two turning points lie between two sticks |
//! | | swings once more | free: stick-slip has ended |
//! | | sticks | sticking, with one more cycle |
//!
//! Stick-slip persists if it lasts for more cycles in a row than these:
//!
//! | share of stick | while something rings | when nothing rings any more |
//! |---|---|---|
//! | large and steady | [`CYCLES_TO_PERSIST`] | [`CYCLES_TO_PERSIST`] |
//! | large | [`CYCLES_WHILE_RINGING`] | [`CYCLES_TO_PERSIST`] |
//! | small: a small disturbance could end it | [`CYCLES_WHILE_RINGING`] | [`CYCLES_WITH_SHORT_STICKS`] |
//!
//! While something rings it may be what makes the pad stick, as it lifts and lowers the normal force. Then the share of
//! stick changes from cycle to cycle, with the beats of the ringing and with its decay.

use crate::models::pad_on_disc::criterion::transients::{FIRST_SWINGS, Transients};

/// Cycles in a row after which stick-slip persists: with a large share of stick; with a small one, after the ringing
/// has died away; and while it lasts.
///
/// Measured on 400 random brakes with discs of 0.2 to 5 % damping, released from stick at 0.9 to 1.03 of their
/// saddle-node speed and simulated for 2000 units of time. With linearly stable sliding, stick-slip with a large share
/// of stick ended in none of them, and that with a small share in one, after 31 cycles in which the disc rang.
const CYCLES_TO_PERSIST: u32 = 6;
const CYCLES_WITH_SHORT_STICKS: u32 = 60;
const CYCLES_WHILE_RINGING: u32 = 600;

/// The share of stick in a cycle that is large.
const LARGE_SHARE: f64 = 0.05;

/// The share of stick is steady if it differs by less than this over the last cycles, relative to the largest of them.
///
/// Measured on 125 brakes that start from rest: random brake 248 of `make validity` with speed, preload, damping, friction
/// and stiffness of the disc scattered by factors of up to 1.3 to 3. Ringing keeps stick-slip with a large share up in many
/// of them, for up to 460 cycles. Without this limit and [`DECAY`] 56 of them count as persistent; with a limit of 5, 2, 1
/// and 0.5 % these are 25, 7, 2 and 1. Stick-slip that lasts, on 104 random brakes, is steady to 1 % after 14 cycles on
/// average, and to 0.5 % after 21.
const STEADY: f64 = 0.01;

/// Nor may a steady share have fallen by more than this part of what the ringing has decayed by: a share that follows the
/// ringing falls at least as fast. Less than [`ERRORS`] is no fall.
const DECAY: f64 = 0.5;
const ERRORS: f64 = 1e-4;

/// How many cycles are compared: those of which the share is known when stick-slip has lasted for [`CYCLES_TO_PERSIST`].
const COMPARED: usize = CYCLES_TO_PERSIST as usize - 1;

/// Stick-slip cycles in a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Cycles {
    /// Sticks in a row.
    sticks: u32,
    swings_since: u32,
    is_stuck: bool,
    first_stick: f64,
    last_stick: f64,
    last_release: Option<f64>,
    /// The shares of stick in the last cycles, the latest last.
    stick_shares: [f64; COMPARED],
}

impl Cycles {
    /// Of a motion that has not stuck yet.
    pub fn new() -> Self {
        Self {
            sticks: 0,
            swings_since: 0,
            is_stuck: false,
            first_stick: 0.0,
            last_stick: 0.0,
            last_release: None,
            stick_shares: [0.0; COMPARED],
        }
    }

    /// Pad and disc begin to stick.
    pub fn sticks(&mut self, time: f64) {
        if self.sticks == 0 {
            self.first_stick = time;
        }
        self.sticks += 1;
        self.swings_since = 0;
        self.is_stuck = true;
        self.last_stick = time;
    }

    /// They cease to.
    pub fn slips(&mut self, time: f64) {
        self.is_stuck = false;
        if let Some(before) = self.last_release.replace(time) {
            self.stick_shares.rotate_left(1);
            self.stick_shares[COMPARED - 1] = (time - self.last_stick) / (time - before);
        }
    }

    /// A swing has ended. Returns whether it ended stick-slip, which has at most three swings between two sticks.
    pub fn swings(&mut self) -> bool {
        if self.sticks == 0 {
            return false;
        }
        self.swings_since += 1;
        let has_ended = self.swings_since > FIRST_SWINGS;
        if has_ended {
            self.sticks = 0;
        }
        has_ended
    }

    /// Whether the motion has stuck and stick-slip has not ended since.
    pub fn is_ongoing(&self) -> bool {
        self.sticks > 0
    }

    pub fn is_stuck(&self) -> bool {
        self.is_stuck
    }

    /// Whether a stick has just ended a cycle that began with another.
    pub fn has_cycle(&self) -> bool {
        self.sticks > 1
    }

    /// The time from the first stick in the row to the last.
    pub fn duration(&self) -> f64 {
        self.last_stick - self.first_stick
    }

    /// Whether stick-slip has lasted so long that it stays, although what was excited before the first stick may still
    /// ring.
    pub fn persists(&self, transients: &Transients) -> bool {
        if self.sticks <= CYCLES_TO_PERSIST {
            return false;
        }
        let still_rings = transients.last_longer_than(self.duration());
        let is_large = self.stick_shares[COMPARED - 1] >= LARGE_SHARE;
        let kept = match (is_large, still_rings) {
            (true, true) if !self.is_steady(transients) => CYCLES_WHILE_RINGING,
            (true, _) => CYCLES_TO_PERSIST,
            (false, false) => CYCLES_WITH_SHORT_STICKS,
            (false, true) => CYCLES_WHILE_RINGING,
        };
        self.sticks > kept
    }

    /// Whether the share of stick has hardly changed in the last cycles, and not fallen as the ringing decays.
    fn is_steady(&self, transients: &Transients) -> bool {
        let (first, last) = (self.stick_shares[0], self.stick_shares[COMPARED - 1]);
        let smallest = self.stick_shares.iter().copied().fold(first, f64::min);
        let largest = self.stick_shares.iter().copied().fold(first, f64::max);
        let period = self.duration() / f64::from(self.sticks - 1);
        let decayed = 1.0 - transients.left_after((COMPARED - 1) as f64 * period);
        smallest >= (1.0 - STEADY) * largest && last >= (1.0 - DECAY * decayed - ERRORS) * first
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rates at which nothing rings any more after a cycle, and at which something rings for ever.
    const RINGS_NEVER: f64 = 10.0;
    const RINGS_FOR_EVER: f64 = 0.0;

    fn persists(cycles: &Cycles, rate: f64) -> bool {
        cycles.persists(&Transients::new(rate))
    }

    /// Simulates cycles of period 2 with these shares of stick beside ringing that decays at a rate, until they persist or
    /// there are `most`.
    fn sticks_until_kept_beside(rate: f64, cycles: &mut Cycles, share: impl Fn(u32) -> f64, most: u32) -> Option<u32> {
        for count in 1..=most {
            let time = 2.0 * f64::from(count);
            cycles.sticks(time);
            if persists(cycles, rate) {
                return Some(count);
            }
            cycles.slips(time + 2.0 * share(count));
            assert!(!cycles.swings() && !cycles.swings(), "two turns lie between two sticks");
        }
        None
    }

    /// The same with a constant share, when nothing rings.
    fn sticks_until_kept(cycles: &mut Cycles, share: f64, most: u32) -> Option<u32> {
        sticks_until_kept_beside(RINGS_NEVER, cycles, |_| share, most)
    }

    #[test]
    fn stick_slip_with_long_sticks_persists_after_six_cycles() {
        for share in [0.051, 0.3, 0.9] {
            assert_eq!(sticks_until_kept(&mut Cycles::new(), share, 100), Some(7), "{share}");
        }
    }

    #[test]
    fn stick_slip_with_short_sticks_persists_after_sixty_cycles() {
        for share in [0.0, 0.01, 0.049] {
            assert_eq!(sticks_until_kept(&mut Cycles::new(), share, 100), Some(61), "{share}");
        }
    }

    #[test]
    fn while_the_disc_rings_short_sticks_have_to_last_longer() {
        let mut cycles = Cycles::new();
        assert_eq!(sticks_until_kept(&mut cycles, 0.01, 60), None);
        (0..540).for_each(|cycle| cycles.sticks(200.0 + f64::from(cycle)));
        assert!(persists(&cycles, RINGS_NEVER) && !persists(&cycles, RINGS_FOR_EVER));
        cycles.sticks(800.0);
        assert!(persists(&cycles, RINGS_FOR_EVER));
        assert_eq!(cycles.duration(), 798.0);
    }

    #[test]
    fn while_the_disc_rings_long_sticks_persist_after_six_cycles_if_they_are_steady() {
        let kept = |scatter: f64| {
            let share = move |count: u32| 0.2 + if count.is_multiple_of(2) { scatter } else { 0.0 };
            sticks_until_kept_beside(RINGS_FOR_EVER, &mut Cycles::new(), share, 700)
        };
        assert_eq!(kept(0.0), Some(7));
        assert_eq!(kept(0.002), Some(7));
        assert_eq!(kept(0.005), Some(601));
        let steady_later = |count: u32| if count < 20 { 0.1 + 0.01 * f64::from(count) } else { 0.3 };
        let found = sticks_until_kept_beside(RINGS_FOR_EVER, &mut Cycles::new(), steady_later, 100);
        assert!(found.is_some_and(|count| (20..30).contains(&count)), "{found:?}");
    }

    #[test]
    fn long_sticks_that_fall_as_the_ringing_decays_do_not_persist_until_it_is_gone() {
        // 0.2 % in a cycle, so that five cycles differ by less than counts as unsteady.
        let rate = 0.001;
        let falls = |count: u32| 0.3 * libm::exp(-2.0 * rate * f64::from(count));
        assert_eq!(sticks_until_kept_beside(rate, &mut Cycles::new(), falls, 60), None);
        assert_eq!(sticks_until_kept_beside(rate, &mut Cycles::new(), |_| 0.3, 60), Some(7));
        // The same fall beside faster ringing does not follow it.
        assert_eq!(sticks_until_kept_beside(0.02, &mut Cycles::new(), falls, 60), Some(7));
    }

    #[test]
    fn stick_slip_that_ringing_keeps_up_for_a_dozen_cycles_does_not_persist() {
        // Sticks and releases of random brake 248 of `make validity`, from rest. Friction falls by 1.5 % only, and 30 units
        // of time later the motion has died away.
        let sticks =
            [0.008, 7.416, 8.731, 10.140, 11.579, 13.033, 14.514, 15.952, 17.418, 18.855, 20.328, 21.828, 23.338];
        let held = [6.182, 0.126, 0.236, 0.262, 0.343, 0.311, 0.331, 0.289, 0.268, 0.258, 0.225, 0.118, 0.058];
        let mut cycles = Cycles::new();
        for (stick, held) in sticks.into_iter().zip(held) {
            cycles.sticks(stick);
            assert!(!persists(&cycles, 0.0126), "{stick}");
            cycles.slips(stick + held);
        }
    }

    #[test]
    fn the_share_of_the_last_cycle_counts() {
        let mut cycles = Cycles::new();
        sticks_until_kept(&mut cycles, 0.01, 20);
        assert!(!persists(&cycles, RINGS_NEVER));
        cycles.sticks(42.0);
        cycles.slips(43.0);
        assert!(persists(&cycles, RINGS_NEVER), "a cycle from the release at 40.02 to that at 43, stuck for 1");
    }

    #[test]
    fn without_a_stick_nothing_is_ongoing_and_nothing_has_ended() {
        let mut cycles = Cycles::new();
        assert!((0..20).all(|_| !cycles.swings()));
        assert!(!cycles.is_ongoing() && !persists(&cycles, RINGS_NEVER) && !cycles.is_stuck());
    }

    #[test]
    fn a_motion_that_sticks_once_has_ended_with_its_fourth_swing() {
        let mut cycles = Cycles::new();
        cycles.sticks(1.0);
        cycles.slips(2.0);
        let has_ended: Vec<bool> = (0..5).map(|_| cycles.swings()).collect();
        assert_eq!(has_ended, [false, false, false, true, false]);
        assert!(!cycles.is_ongoing());
    }

    #[test]
    fn three_swings_between_sticks_do_not_end_stick_slip() {
        let mut cycles = Cycles::new();
        for cycle in 0..20 {
            cycles.sticks(f64::from(cycle));
            cycles.slips(f64::from(cycle) + 0.5);
            assert!((0..3).all(|_| !cycles.swings()));
        }
        assert!(cycles.is_ongoing() && persists(&cycles, RINGS_NEVER));
    }

    #[test]
    fn an_end_in_between_restarts_the_count() {
        let mut cycles = Cycles::new();
        assert_eq!(sticks_until_kept(&mut cycles, 0.3, 6), None);
        assert!(!cycles.swings() && cycles.swings());
        assert_eq!(sticks_until_kept(&mut cycles, 0.3, 100), Some(7));
    }

    #[test]
    fn the_pad_is_stuck_from_stick_to_slip() {
        let mut cycles = Cycles::new();
        for time in [1.0, 3.0] {
            cycles.sticks(time);
            assert!(cycles.is_stuck() && cycles.is_ongoing());
            cycles.slips(time + 1.0);
            assert!(!cycles.is_stuck() && cycles.is_ongoing());
        }
    }

    #[test]
    fn the_second_stick_completes_a_cycle() {
        let mut cycles = Cycles::new();
        cycles.sticks(1.0);
        assert!(!cycles.has_cycle());
        cycles.slips(2.0);
        cycles.sticks(3.0);
        assert!(cycles.has_cycle());
    }
}
