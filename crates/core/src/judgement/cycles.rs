//! Whether stick-slip comes back cycle after cycle.
//!
//! | state | event | then |
//! |---|---|---|
//! | free | sticks | sticking, the first stick |
//! | sticking | slips | slipping; the share of the cycle spent in stick is known from the second release on |
//! | slipping | swings, up to [`FIRST_SWINGS`](super::transients::FIRST_SWINGS) of them | slipping: two turning points lie between two sticks |
//! | | swings once more | free: the motion has come away |
//! | | sticks | sticking, one cycle more |
//!
//! Stick-slip counts as kept after [`KEPT`] cycles in a row. Where the share of stick is small, a small disturbance could
//! end it, and ten times as many are asked for.

use super::transients::FIRST_SWINGS;

/// Cycles in a row that count as kept, KEPT_PLACEHOLDER
const KEPT: u32 = 6;
const KEPT_BARELY: u32 = 60;

/// The share of stick in a cycle that is large.
const LARGE_SHARE: f64 = 0.05;

/// Stick-slip cycles in a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Cycles {
    /// Sticks in a row.
    sticks: u32,
    swings_since: u32,
    is_stuck: bool,
    last_stick: f64,
    last_release: Option<f64>,
    stick_share: f64,
}

impl Cycles {
    /// Of a motion that has not stuck yet.
    pub fn new() -> Self {
        Self { sticks: 0, swings_since: 0, is_stuck: false, last_stick: 0.0, last_release: None, stick_share: 0.0 }
    }

    /// Pad and disc begin to stick.
    pub fn sticks(&mut self, time: f64) {
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

    /// A swing has ended; whether it was one too many for stick-slip.
    pub fn swings(&mut self) -> bool {
        if self.sticks == 0 {
            return false;
        }
        self.swings_since += 1;
        let comes_free = self.swings_since > FIRST_SWINGS;
        if comes_free {
            self.sticks = 0;
        }
        comes_free
    }

    /// Whether the motion has stuck and not come free.
    pub fn goes_on(&self) -> bool {
        self.sticks > 0
    }

    pub fn is_stuck(&self) -> bool {
        self.is_stuck
    }

    /// Whether a stick has just ended a cycle that began with another.
    pub fn has_cycle(&self) -> bool {
        self.sticks > 1
    }

    /// Whether stick-slip has come back so often that it stays.
    pub fn is_kept(&self) -> bool {
        self.sticks > if self.stick_share >= LARGE_SHARE { KEPT } else { KEPT_BARELY }
    }
}
