//! Whether amplitudes grow or shrink from swing to swing.
//!
//! A swing leads from one turning point to the next; half of its length is an amplitude. Each is compared with a
//! reference, an earlier amplitude of the same motion:
//!
//! | state | a swing whose amplitude | trend | then |
//! |---|---|---|---|
//! | no reference | is any | unclear | it is the reference |
//! | reference | exceeds the reference by more than ringing can imitate, and all amplitudes before | growing | it is the new reference |
//! | | exceeds the reference by so much, but not all before | unclear: a beat | it is the new reference |
//! | | falls short of it by more than half of that | shrinking | it is the new reference |
//! | | does neither | unclear | the same reference until time has doubled; then this amplitude |
//! | | has done neither for [`SUSTAINED`] swings and twice the time, when ringing can imitate nothing any more | constant | the same reference |
//!
//! A stick ends the comparison: the next swing is a new reference.

/// Relative changes below this say nothing: they may be errors of steps and of the interpolation of turning points.
/// With the steps in use amplitudes of a cycle differ by 1e-6, a hundredth of this.
const LEAST_CHANGE: f64 = 1e-4;

/// The reference is renewed when time has doubled, at first after this many units of scaled time: six periods, so that
/// a slow trend adds up beyond [`LEAST_CHANGE`].
const FIRST_REFERENCE: f64 = 20.0;

/// Swings of constant amplitude that make a cycle without sticking.
const SUSTAINED: u32 = 100;

/// What amplitudes do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Trend {
    Growing,
    Shrinking,
    Constant,
    Unclear,
}

/// The amplitudes of a motion without sticking.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Swings {
    last_turn: Option<f64>,
    amplitude: f64,
    reference: Option<Reference>,
    /// The largest amplitude since the last stick.
    largest: f64,
    /// Swings without a trend since the reference.
    unclear: u32,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Reference {
    amplitude: f64,
    time: f64,
    /// The change that ringing could imitate then.
    imitated: f64,
}

impl Reference {
    fn grows_to(&self, amplitude: f64) -> bool {
        amplitude > self.amplitude * (1.0 + LEAST_CHANGE) + self.imitated
    }

    fn shrinks_to(&self, amplitude: f64) -> bool {
        // Half of it is enough: this decides only when a motion near a stable equilibrium has returned.
        amplitude * (1.0 + LEAST_CHANGE + 0.5 * self.imitated / self.amplitude) < self.amplitude
    }
}

impl Swings {
    /// Of a motion that starts at a turning point, or not.
    pub fn new(starts_turning_at: Option<f64>) -> Self {
        Self { last_turn: starts_turning_at, amplitude: 0.0, reference: None, largest: 0.0, unclear: 0 }
    }

    /// The motion turns at `x`: the amplitude of the swing that ends there, if it began at a turning point.
    pub fn turns(&mut self, x: f64) -> Option<f64> {
        let before = self.last_turn.replace(x)?;
        self.amplitude = 0.5 * (x - before).abs();
        Some(self.amplitude)
    }

    /// The amplitude of the last swing.
    pub fn amplitude(&self) -> f64 {
        self.amplitude
    }

    /// The trend after a swing, if ringing can imitate a change of this size.
    pub fn trend(&mut self, time: f64, imitated: f64) -> Trend {
        let amplitude = self.amplitude;
        let now = Reference { amplitude, time, imitated };
        let largest = self.largest;
        self.largest = largest.max(amplitude);
        let Some(reference) = self.reference else {
            self.restart(Some(now));
            return Trend::Unclear;
        };
        if reference.grows_to(amplitude) {
            self.restart(Some(now));
            return if amplitude > largest { Trend::Growing } else { Trend::Unclear };
        }
        if reference.shrinks_to(amplitude) {
            self.restart(Some(now));
            return Trend::Shrinking;
        }
        self.unclear += 1;
        let has_doubled = time > 2.0 * reference.time + FIRST_REFERENCE;
        if has_doubled && self.unclear >= SUSTAINED && reference.imitated <= LEAST_CHANGE * amplitude {
            return Trend::Constant;
        }
        if has_doubled {
            self.restart(Some(now));
        }
        Trend::Unclear
    }

    /// The motion sticks at `x`: no later swing is compared with the ones before. Returns whether the swing that ends
    /// here, which is at least this long, had grown.
    pub fn sticks(&mut self, x: f64) -> bool {
        let (reference, largest) = (self.reference, self.largest);
        self.restart(None);
        self.largest = 0.0;
        match (reference, self.last_turn) {
            (Some(reference), Some(turn)) => {
                let amplitude = 0.5 * (x - turn).abs();
                reference.grows_to(amplitude) && amplitude > largest
            }
            _ => false,
        }
    }

    fn restart(&mut self, reference: Option<Reference>) {
        self.reference = reference;
        self.unclear = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Swings of any amplitudes, one every three units of time.
    struct Driven {
        swings: Swings,
        time: f64,
        x: f64,
        side: f64,
    }

    impl Driven {
        fn new() -> Self {
            Self { swings: Swings::new(Some(0.0)), time: 0.0, x: 0.0, side: 1.0 }
        }

        fn swing(&mut self, amplitude: f64, imitated: f64) -> Trend {
            self.time += 3.0;
            self.x += 2.0 * self.side * amplitude;
            self.side = -self.side;
            let reported = self.swings.turns(self.x).unwrap();
            assert!((reported - amplitude).abs() < 1e-12);
            self.swings.trend(self.time, imitated)
        }

        fn trends(amplitudes: &[f64]) -> Vec<Trend> {
            let mut driven = Self::new();
            amplitudes.iter().map(|&amplitude| driven.swing(amplitude, 0.0)).collect()
        }
    }

    /// The first trend of up to a thousand swings, and after how many.
    fn first_trend(amplitude: impl Fn(f64) -> f64, imitated: f64) -> Option<(u32, Trend)> {
        let mut driven = Driven::new();
        let trends = (1..=1000).map(|count| (count, driven.swing(amplitude(f64::from(count)), imitated)));
        trends.into_iter().find(|&(_, trend)| trend != Trend::Unclear)
    }

    #[test]
    fn a_motion_that_does_not_start_turning_has_an_amplitude_after_its_second_turn() {
        let mut swings = Swings::new(None);
        assert_eq!(swings.turns(3.0), None);
        assert_eq!(swings.turns(1.0), Some(1.0));
        assert_eq!(swings.amplitude(), 1.0);
    }

    #[test]
    fn the_first_swing_is_what_later_ones_are_compared_with() {
        assert_eq!(Driven::trends(&[1.0, 1.01]), [Trend::Unclear, Trend::Growing]);
        assert_eq!(Driven::trends(&[1.0, 0.99]), [Trend::Unclear, Trend::Shrinking]);
    }

    #[test]
    fn a_swing_with_a_trend_is_the_next_to_compare_with() {
        assert_eq!(Driven::trends(&[1.0, 2.0, 1.5])[2], Trend::Shrinking);
        assert_eq!(Driven::trends(&[1.0, 0.5, 0.7, 0.6])[3], Trend::Shrinking);
    }

    #[test]
    fn growth_goes_beyond_all_that_was_before() {
        assert_eq!(Driven::trends(&[1.0, 0.5, 0.7, 1.1])[2..], [Trend::Unclear, Trend::Growing]);
    }

    #[test]
    fn changes_below_a_ten_thousandth_say_nothing() {
        assert_eq!(Driven::trends(&[1.0, 1.000_09])[1], Trend::Unclear);
        assert_eq!(Driven::trends(&[1.0, 0.999_91])[1], Trend::Unclear);
        assert_eq!(Driven::trends(&[1.0, 1.000_11])[1], Trend::Growing);
        assert_eq!(Driven::trends(&[1.0, 0.999_89])[1], Trend::Shrinking);
    }

    #[test]
    fn slow_trends_add_up_until_they_are_seen() {
        // 26 swings of these exceed a ten thousandth; the reference before is renewed when time has doubled.
        for (rate, trend) in [(4e-6, Trend::Growing), (-4e-6, Trend::Shrinking)] {
            let (count, found) = first_trend(|count| 1.0 + rate * count, 0.0).unwrap();
            assert_eq!(found, trend);
            assert!((26..100).contains(&count), "{count}");
        }
    }

    #[test]
    fn constant_swings_make_a_cycle_after_a_hundred_of_them_and_twice_the_time() {
        // References at times 3, 27, 75, 171 and 363, each a swing after 20 and twice the time before; 128 swings later
        // time has doubled once more.
        assert_eq!(first_trend(|_| 0.7, 0.0), Some((249, Trend::Constant)));
        let mut driven = Driven::new();
        assert_eq!((1..=249).filter(|_| driven.swing(0.7, 0.0) == Trend::Constant).count(), 1);
        assert_eq!(driven.swing(0.7, 0.0), Trend::Constant, "and it goes on");
    }

    #[test]
    fn constant_swings_say_nothing_while_ringing_can_imitate_a_change() {
        assert_eq!(first_trend(|_| 0.7, 0.71e-4), None);
        assert_eq!(first_trend(|_| 0.7, 0.69e-4), Some((249, Trend::Constant)));
    }

    #[test]
    fn the_reference_is_renewed_when_time_has_doubled() {
        let growth_after = |waits: u32| {
            let mut driven = Driven::new();
            driven.swing(1.0, 0.0);
            for _ in 0..waits {
                assert_eq!(driven.swing(1.000_09, 0.0), Trend::Unclear);
            }
            driven.swing(1.000_18, 0.0)
        };
        // The first reference is of time 3: it is renewed after time 26.
        assert_eq!(growth_after(7), Trend::Growing);
        assert_eq!(growth_after(8), Trend::Unclear);
    }

    #[test]
    fn beats_that_ringing_can_imitate_say_nothing() {
        let beating = |count: f64| 1.0 + 0.02 * libm::sin(0.7 * count);
        assert_eq!(first_trend(beating, 0.1), None);
        assert!(first_trend(beating, 0.0).is_some());
    }

    #[test]
    fn imitation_counts_whole_against_growth_and_half_against_shrinking() {
        let second = |imitated: f64, amplitude: f64| {
            let mut driven = Driven::new();
            driven.swing(2.0, imitated);
            // What may be imitated by the second swing does not matter.
            driven.swing(amplitude, 0.0)
        };
        assert_eq!(second(0.1, 2.09), Trend::Unclear);
        assert_eq!(second(0.1, 2.11), Trend::Growing);
        assert_eq!(second(0.1, 1.96), Trend::Unclear);
        assert_eq!(second(0.1, 1.94), Trend::Shrinking);
    }

    #[test]
    fn a_stick_ends_the_reference_and_shows_growth_before_it() {
        for (amplitude, has_grown) in [(1.5, true), (1.0, false), (0.5, false)] {
            let mut driven = Driven::new();
            driven.swing(1.0, 0.0);
            let x = driven.x + 2.0 * driven.side * amplitude;
            assert_eq!(driven.swings.sticks(x), has_grown);
            assert_eq!(driven.swing(3.0, 0.0), Trend::Unclear);
            assert_eq!(driven.swing(4.0, 0.0), Trend::Growing);
        }
    }

    #[test]
    fn a_stick_without_anything_to_compare_with_shows_no_growth() {
        assert!(!Swings::new(None).sticks(1.0));
        assert!(!Swings::new(Some(0.0)).sticks(1.0));
    }

    #[test]
    fn what_was_imitated_at_the_reference_counts_and_not_what_is_since() {
        // The references of a constant motion, each a swing after 20 and twice the time of the one before.
        let references = [1, 9, 25, 57, 121];
        let first_constant = |at_references: f64, since: f64| {
            let mut driven = Driven::new();
            let imitated = |count: i32| if references.contains(&count) { at_references } else { since };
            (1..=249).find(|&count| driven.swing(0.7, imitated(count)) == Trend::Constant)
        };
        assert_eq!(first_constant(0.0, 0.1), Some(249));
        assert_eq!(first_constant(0.1, 0.0), None);
    }
}
