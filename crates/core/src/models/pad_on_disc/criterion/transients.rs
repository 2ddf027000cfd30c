//! How large a change of amplitude the other degrees of freedom can imitate.
//!
//! A start or a release from stick excites all degrees of freedom of pad and disc. Their ringing shows in the
//! tangential motion as amplitudes that change from swing to swing although nothing feeds or damps them.
//!
//! | state | on a swing | on a stick | on a release |
//! |---|---|---|---|
//! | just excited, first swings to come | the excitation is the largest amplitude of these swings | excited again | excited from here |
//! | ringing | nothing | excited again; what still rings is kept | |
//!
//! A change can be imitated up to the excitation, which dies away at the slowest damping rate of these degrees of
//! freedom. The excitation is an amplitude of its own: if the tangential motion has died away faster, beats of the
//! ringing are no growth.

/// Swings after a start or a release that show how much the other degrees of freedom can have been excited: a swing
/// takes at most as long as it takes the contact to pass the excitation on.
pub(super) const FIRST_SWINGS: u32 = 3;

/// The share of a ringing that does not matter any more: a hundredth of the amplitude it began with.
const NEGLIGIBLE_RINGING: f64 = 1e-2;

/// The ringing that is left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Transients {
    /// Slowest damping rate of the degrees of freedom that ring, per unit of scaled time.
    rate: f64,
    excited_at: f64,
    excitation: f64,
    first_swings: u32,
}

impl Transients {
    /// Of a motion that is excited at time 0.
    pub fn new(rate: f64) -> Self {
        // The start is a turning point already: one swing shows its amplitude.
        Self { rate, excited_at: 0.0, excitation: 0.0, first_swings: 1 }
    }

    /// The other degrees of freedom start with an amplitude of their own, and the motion perhaps not at a turning
    /// point.
    pub fn are_excited_by(&mut self, amplitude: f64) {
        self.excitation = self.excitation.max(amplitude);
        self.first_swings = FIRST_SWINGS;
    }

    /// A swing of this amplitude.
    pub fn swings(&mut self, amplitude: f64) {
        if self.first_swings > 0 {
            self.first_swings -= 1;
            self.excitation = self.excitation.max(amplitude);
        }
    }

    /// The motion sticks, which excites all degrees of freedom again.
    pub fn sticks(&mut self, time: f64) {
        self.slips(time);
        self.first_swings = FIRST_SWINGS;
    }

    /// The motion is released, perhaps after a stick that lasted longer than any ringing: the next swings show the
    /// excitation from here.
    pub fn slips(&mut self, time: f64) {
        self.excitation *= self.left(time);
        self.excited_at = time;
    }

    /// The change of an amplitude that ringing can still imitate. A motion larger than the excitation excites as much
    /// as its own amplitude.
    pub fn imitated(&self, time: f64, amplitude: f64) -> f64 {
        self.excitation.max(amplitude) * self.left(time)
    }

    /// Whether after this time more than [`NEGLIGIBLE_RINGING`] of a ringing is left.
    pub fn last_longer_than(&self, duration: f64) -> bool {
        self.left_after(duration) > NEGLIGIBLE_RINGING
    }

    /// The share of a ringing that is left after this time.
    pub fn left_after(&self, duration: f64) -> f64 {
        libm::exp(-self.rate * duration)
    }

    /// The share of the excitation that has not died away.
    fn left(&self, time: f64) -> f64 {
        self.left_after(time - self.excited_at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_swing_excites_and_later_ones_do_not() {
        let mut transients = Transients::new(0.1);
        transients.swings(2.0);
        transients.swings(5.0);
        assert_eq!(transients.imitated(0.0, 1.0), 2.0);
        assert!((transients.imitated(10.0, 0.0) - 2.0 / std::f64::consts::E).abs() < 1e-15);
        assert_eq!(transients.imitated(0.0, 7.0), 7.0);
    }

    #[test]
    fn ringing_lasts_until_a_hundredth_is_left() {
        let transients = Transients::new(0.1);
        assert!(transients.last_longer_than(46.0) && !transients.last_longer_than(46.1));
        assert!(Transients::new(0.0).last_longer_than(1e9));
    }

    #[test]
    fn after_a_stick_the_first_three_swings_excite_and_earlier_ringing_is_kept() {
        let mut transients = Transients::new(0.1);
        transients.swings(2.0);
        transients.sticks(10.0);
        assert!((transients.imitated(10.0, 0.0) - 2.0 / std::f64::consts::E).abs() < 1e-15);
        for amplitude in [0.1, 0.3, 0.2, 9.0] {
            transients.swings(amplitude);
        }
        // What rang before is more than the swings since.
        assert!((transients.imitated(10.0, 0.0) - 2.0 / std::f64::consts::E).abs() < 1e-15);
        transients.sticks(200.0);
        for amplitude in [0.1, 0.3, 0.2, 9.0] {
            transients.swings(amplitude);
        }
        assert_eq!(transients.imitated(200.0, 0.0), 0.3);
    }
    #[test]
    fn a_release_excites_however_long_the_stick_before_it_was() {
        let mut transients = Transients::new(0.1);
        transients.swings(2.0);
        transients.sticks(10.0);
        transients.slips(1000.0);
        for amplitude in [0.1, 0.3, 0.2] {
            transients.swings(amplitude);
        }
        assert_eq!(transients.imitated(1000.0, 0.0), 0.3);
        assert!((transients.imitated(1010.0, 0.0) - 0.3 / std::f64::consts::E).abs() < 1e-15);
    }
}
