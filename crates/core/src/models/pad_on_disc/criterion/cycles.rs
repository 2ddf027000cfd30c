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
//! Stick-slip persists if it lasts for more than [`CYCLES_TO_PERSIST`] cycles in a row. If the share of stick is small,
//! a small disturbance could end it. Then it has to last for [`CYCLES_WITH_SHORT_STICKS`] cycles, and until nothing
//! rings any more, or for [`CYCLES_WHILE_RINGING`].

use crate::models::pad_on_disc::criterion::transients::FIRST_SWINGS;

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
    stick_share: f64,
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
            stick_share: 0.0,
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
            self.stick_share = (time - self.last_stick) / (time - before);
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

    /// Whether stick-slip has lasted so long that it stays; `still_rings` is whether what was excited before the first
    /// stick may still matter.
    pub fn persists(&self, still_rings: bool) -> bool {
        let kept = match (self.stick_share >= LARGE_SHARE, still_rings) {
            (true, _) => CYCLES_TO_PERSIST,
            (false, false) => CYCLES_WITH_SHORT_STICKS,
            (false, true) => CYCLES_WHILE_RINGING,
        };
        self.sticks > kept
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Simulates cycles of period 2 with a share of stick, until they persist or there are `most`.
    fn sticks_until_kept(cycles: &mut Cycles, share: f64, most: u32) -> Option<u32> {
        for count in 1..=most {
            let time = 2.0 * f64::from(count);
            cycles.sticks(time);
            if cycles.persists(false) {
                return Some(count);
            }
            cycles.slips(time + 2.0 * share);
            assert!(!cycles.swings() && !cycles.swings(), "two turns lie between two sticks");
        }
        None
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
        assert!(cycles.persists(false) && !cycles.persists(true));
        cycles.sticks(800.0);
        assert!(cycles.persists(true));
        assert_eq!(cycles.duration(), 798.0);
    }

    #[test]
    fn the_share_of_the_last_cycle_counts() {
        let mut cycles = Cycles::new();
        sticks_until_kept(&mut cycles, 0.01, 20);
        assert!(!cycles.persists(false));
        cycles.sticks(42.0);
        cycles.slips(43.0);
        assert!(cycles.persists(false), "a cycle from the release at 40.02 to that at 43, stuck for 1");
    }

    #[test]
    fn without_a_stick_nothing_is_ongoing_and_nothing_has_ended() {
        let mut cycles = Cycles::new();
        assert!((0..20).all(|_| !cycles.swings()));
        assert!(!cycles.is_ongoing() && !cycles.persists(false) && !cycles.is_stuck());
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
        assert!(cycles.is_ongoing() && cycles.persists(false));
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
