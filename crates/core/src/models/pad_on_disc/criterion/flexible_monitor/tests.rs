//! Invented motions about the equilibrium 1, reported swing by swing and stick by stick.

use super::*;

/// A rate at which nothing rings for as long as a swing, and one at which something rings for ever.
const RINGS_NEVER: f64 = 10.0;
const RINGS_FOR_EVER: f64 = 0.0;

const DISPLACEMENT: f64 = 0.01;

fn options(slowest_transient: f64) -> MonitorOptions {
    MonitorOptions {
        slowest_transient,
        smallest_cycle: 1.0,
        until_settled: false,
        linear_growth_fed_by: None,
        refinement: 1.0,
    }
}

struct Driven {
    monitor: FlexibleMonitor,
    time: f64,
    x: f64,
    side: f64,
}

impl Driven {
    fn with(options: MonitorOptions, displacement: f64) -> Self {
        let monitor = FlexibleMonitor::new(options, 1.0, displacement, Some(1.0));
        Self { monitor, time: 0.0, x: 1.0, side: 1.0 }
    }

    fn new(slowest_transient: f64) -> Self {
        Self::with(options(slowest_transient), DISPLACEMENT)
    }

    /// A swing of three units of time.
    fn swing(&mut self, amplitude: f64) {
        self.time += 3.0;
        self.x += 2.0 * self.side * amplitude;
        self.side = -self.side;
        self.monitor.turns(self.time, self.x);
    }

    /// Up to a thousand swings, of amplitudes that depend on time; the verdict and the amplitude at which it came.
    fn swings(&mut self, amplitude: impl Fn(f64) -> f64) -> Option<(Verdict, f64)> {
        let begin = self.time;
        for _ in 0..1000 {
            self.swing(amplitude(self.time + 3.0 - begin));
            if let Some(verdict) = self.monitor.verdict {
                return Some((verdict, self.monitor.swings.amplitude()));
            }
        }
        None
    }

    fn verdict_of_swings(&mut self, amplitude: impl Fn(f64) -> f64) -> Option<Verdict> {
        self.swings(amplitude).map(|(verdict, _)| verdict)
    }

    /// Sticks at once for so long, and is released.
    fn stick(&mut self, duration: f64) {
        self.monitor.sticks(self.time, self.x);
        self.time += duration;
        self.monitor.slips(self.time);
    }

    /// Stick-slip of this amplitude that sticks for so long in every cycle; after how many sticks there is a verdict.
    fn sticks_until_verdict(&mut self, stick: f64, amplitude: f64) -> Option<(u32, Verdict)> {
        for count in 1..=500 {
            self.monitor.sticks(self.time, self.x);
            if let Some(verdict) = self.monitor.verdict {
                return Some((count, verdict));
            }
            self.time += stick;
            self.monitor.slips(self.time);
            self.swing(amplitude);
            self.swing(amplitude);
        }
        None
    }

    /// Looks at a motion at these distances from the equilibrium, alternating sides.
    fn check(&mut self, distances: &[f64]) -> Option<Verdict> {
        for (index, distance) in distances.iter().enumerate() {
            self.monitor.check(if index % 2 == 0 { 1.0 + distance } else { 1.0 - distance }, 0.0);
        }
        self.monitor.verdict
    }
}

fn decays(from: f64, rate: f64) -> impl Fn(f64) -> f64 {
    move |time| from * libm::exp(-rate * time)
}

#[test]
fn growing_swings_are_unstable_fed_by_the_tangential_motion() {
    let mut driven = Driven::new(RINGS_NEVER);
    assert!(!driven.monitor.is_unstable());
    assert_eq!(driven.verdict_of_swings(decays(0.01, -0.01)), Some(Verdict::Unstable));
    assert!(driven.monitor.is_unstable());
    assert_eq!(driven.monitor.fed_by(), DegreeOfFreedom::Tangential);
}

#[test]
fn growing_swings_say_nothing_while_ringing_can_imitate_as_much() {
    let mut driven = Driven::new(RINGS_FOR_EVER);
    driven.swing(0.1);
    for _ in 0..10 {
        driven.swing(0.15);
    }
    assert_eq!(driven.monitor.verdict(), None);
    assert!(!driven.monitor.is_unstable());
}

#[test]
fn shrinking_swings_are_stable_once_they_are_within_the_displacement() {
    let (verdict, amplitude) = Driven::new(RINGS_NEVER).swings(decays(0.1, 0.01)).unwrap();
    assert_eq!(verdict, Verdict::Stable);
    assert!(amplitude <= DISPLACEMENT && amplitude > 0.95 * DISPLACEMENT, "{amplitude}");
}

#[test]
fn shrinking_swings_outside_the_displacement_have_no_verdict_yet() {
    let mut driven = Driven::new(RINGS_NEVER);
    for swing in 0..50 {
        driven.swing(decays(0.1, 0.01)(3.0 * f64::from(swing)));
    }
    assert_eq!(driven.monitor.verdict(), None);
}

#[test]
fn however_large_the_displacement_a_stick_slip_cycle_does_not_fit_into_it() {
    let (verdict, amplitude) = Driven::with(options(RINGS_NEVER), 5.0).swings(decays(0.5, 0.01)).unwrap();
    assert_eq!(verdict, Verdict::Stable);
    assert!(amplitude <= 0.1 && amplitude > 0.095, "{amplitude}");
}

#[test]
fn a_cycle_without_sticking_is_unstable_once_nothing_rings() {
    assert_eq!(Driven::new(RINGS_NEVER).verdict_of_swings(|_| 0.05), Some(Verdict::Unstable));
    assert_eq!(Driven::new(0.02).verdict_of_swings(|_| 0.05), Some(Verdict::Unstable));
    assert_eq!(Driven::new(RINGS_FOR_EVER).verdict_of_swings(|_| 0.05), None);
}

#[test]
fn constant_swings_within_the_displacement_have_no_verdict() {
    assert_eq!(Driven::new(RINGS_NEVER).verdict_of_swings(|_| 0.9 * DISPLACEMENT), None);
    assert_eq!(Driven::new(RINGS_NEVER).verdict_of_swings(|_| 1.1 * DISPLACEMENT), Some(Verdict::Unstable));
}

#[test]
fn swings_that_shrink_onto_a_cycle_are_unstable() {
    let (verdict, amplitude) = Driven::new(RINGS_NEVER).swings(|time| 0.05 + decays(0.5, 0.05)(time)).unwrap();
    assert_eq!(verdict, Verdict::Unstable);
    assert!((amplitude - 0.05).abs() < 1e-4);
}

#[test]
fn beats_of_ringing_are_no_growth_and_die_away_to_a_stable_motion() {
    // The tangential motion has died away after some swings; what rings dies away at 0.01 and beats.
    let ringing = |time: f64| decays(1.0, 0.1)(time) + decays(0.5, 0.01)(time) * (1.0 + 0.5 * libm::sin(0.13 * time));
    let (verdict, amplitude) = Driven::new(0.01).swings(ringing).unwrap();
    assert_eq!(verdict, Verdict::Stable);
    assert!(amplitude <= DISPLACEMENT);
    // They grow in between, but never beyond what was before.
    assert_eq!(Driven::new(RINGS_NEVER).verdict_of_swings(ringing), Some(Verdict::Stable));
}

#[test]
fn ringing_after_a_release_is_no_growth_either() {
    let mut driven = Driven::new(0.01);
    driven.swing(0.5);
    driven.time = 3000.0;
    driven.stick(1.0);
    for swing in 0..30 {
        driven.swing(0.2 + 0.003 * f64::from(swing));
    }
    assert_eq!(driven.monitor.verdict(), None);
    // Of the same swings without a stick nothing is imitated.
    let mut driven = Driven::new(0.01);
    driven.swing(0.5);
    driven.time = 3000.0;
    assert_eq!(driven.verdict_of_swings(|time| 0.2 + 0.001 * time), Some(Verdict::Unstable));
}

#[test]
fn a_motion_that_sticks_once_and_then_shrinks_is_stable() {
    for slowest_transient in [RINGS_NEVER, 0.02] {
        let mut driven = Driven::new(slowest_transient);
        driven.swing(0.5);
        driven.stick(1.0);
        assert_eq!(driven.verdict_of_swings(decays(0.5, 0.05)), Some(Verdict::Stable));
    }
}

#[test]
fn the_first_swings_after_a_stick_are_compared_with_nothing() {
    let mut driven = Driven::new(RINGS_NEVER);
    driven.swing(0.1);
    driven.stick(1.0);
    // Three swings that grow, as between two sticks; with the fourth stick-slip ends and swings are compared.
    for amplitude in [0.2, 0.3, 0.4, 0.5] {
        driven.swing(amplitude);
        assert_eq!(driven.monitor.verdict(), None);
    }
    driven.swing(0.6);
    assert_eq!(driven.monitor.verdict(), Some(Verdict::Unstable));
}

#[test]
fn a_swing_that_grows_until_it_sticks_is_unstable() {
    let mut driven = Driven::new(RINGS_NEVER);
    driven.swing(0.5);
    driven.monitor.sticks(6.0, driven.x - 1.2);
    assert_eq!(driven.monitor.verdict(), Some(Verdict::Unstable));
    let mut driven = Driven::new(RINGS_NEVER);
    driven.swing(0.5);
    driven.monitor.sticks(6.0, driven.x - 0.8);
    assert_eq!(driven.monitor.verdict(), None);
}

#[test]
fn a_motion_that_sticks_for_ever_is_unstable_with_its_seventh_stick() {
    assert_eq!(Driven::new(RINGS_NEVER).sticks_until_verdict(3.0, 0.5), Some((7, Verdict::Unstable)));
    assert_eq!(Driven::new(RINGS_FOR_EVER).sticks_until_verdict(3.0, 0.5), Some((7, Verdict::Unstable)));
}

#[test]
fn a_motion_that_barely_sticks_is_unstable_with_its_sixty_first_stick() {
    assert_eq!(Driven::new(RINGS_NEVER).sticks_until_verdict(0.1, 0.5), Some((61, Verdict::Unstable)));
}

#[test]
fn a_motion_that_creeps_towards_the_equilibrium_is_stable() {
    assert_eq!(Driven::new(RINGS_NEVER).check(&[0.009, 0.005]), None, "not half as far");
    assert_eq!(Driven::new(RINGS_NEVER).check(&[0.009, 0.004]), Some(Verdict::Stable));
    assert_eq!(Driven::new(RINGS_NEVER).check(&[0.9, 0.3, 0.1, 0.03, 0.011]), None, "outside the displacement");
    assert_eq!(Driven::new(RINGS_NEVER).check(&[0.9, 0.3, 0.1, 0.03, 0.009]), Some(Verdict::Stable));
}

#[test]
fn a_motion_that_creeps_after_it_stuck_once_is_stable() {
    let mut driven = Driven::new(RINGS_NEVER);
    driven.check(&[0.009]);
    driven.stick(1.0);
    assert_eq!(driven.check(&[0.003]), None, "what was seen before the stick does not count");
    assert_eq!(driven.check(&[0.001]), Some(Verdict::Stable));
}

#[test]
fn a_motion_that_has_arrived_is_stable_though_it_gets_no_nearer() {
    assert_eq!(Driven::new(RINGS_NEVER).check(&[0.9e-6, 0.9e-6]), Some(Verdict::Stable));
    assert_eq!(Driven::new(RINGS_NEVER).check(&[1.1e-6, 0.9e-6]), None);
    assert_eq!(Driven::new(RINGS_NEVER).check(&[0.9e-6, 1.1e-6]), None);
}

#[test]
fn a_motion_that_turns_between_two_checks_does_not_creep() {
    let mut driven = Driven::new(RINGS_NEVER);
    driven.check(&[0.009]);
    driven.swing(0.005);
    assert_eq!(driven.check(&[0.001]), None);
}

#[test]
fn a_pad_that_sticks_on_a_slow_disc_does_not_creep_however_near_it_is_carried() {
    let mut driven = Driven::new(RINGS_NEVER);
    driven.monitor.sticks(1.0, 0.9);
    assert_eq!(driven.check(&[0.009, 0.003, 0.001, 1e-4, 1e-7, 1e-8]), None);
    driven.monitor.slips(2.0);
    assert_eq!(driven.check(&[1e-9]), None);
    assert_eq!(driven.check(&[0.4e-9]), Some(Verdict::Stable), "as soon as it creeps by itself");
}

#[test]
fn what_is_seen_of_a_motion_before_it_sticks_or_is_released_does_not_count_after() {
    let mut driven = Driven::new(RINGS_NEVER);
    driven.check(&[0.009]);
    driven.monitor.sticks(1.0, 0.9);
    assert_eq!(driven.check(&[0.003]), None, "it is carried there");
    let mut driven = Driven::new(RINGS_NEVER);
    driven.check(&[0.009]);
    driven.monitor.slips(1.0);
    assert_eq!(driven.check(&[0.003]), None, "it is carried there, as from the start on");
}

#[test]
fn a_motion_that_escapes_without_a_turn_has_no_verdict() {
    assert_eq!(Driven::new(RINGS_NEVER).check(&[0.001, 0.002, 0.004, 0.02, 0.5]), None);
}

#[test]
fn a_motion_known_to_be_unstable_does_not_become_stable_by_creeping() {
    let mut driven = Driven::with(MonitorOptions { until_settled: true, ..options(RINGS_NEVER) }, DISPLACEMENT);
    driven.swing(0.001);
    driven.swing(0.002);
    assert!(driven.monitor.is_unstable() && driven.monitor.verdict().is_none());
    assert_eq!(driven.check(&[0.009, 0.004, 0.001]), None);
}

const REPELLED: MonitorOptions = MonitorOptions {
    slowest_transient: RINGS_NEVER,
    smallest_cycle: 1.0,
    until_settled: false,
    linear_growth_fed_by: Some(DegreeOfFreedom::Normal),
    refinement: 1.0,
};

#[test]
fn a_linearly_unstable_equilibrium_makes_a_motion_unstable_at_once() {
    let monitor = Driven::with(REPELLED, DISPLACEMENT).monitor;
    assert_eq!(monitor.verdict(), Some(Verdict::Unstable));
    assert!(monitor.is_unstable());
    assert_eq!(monitor.fed_by(), DegreeOfFreedom::Normal);
}

#[test]
fn where_the_amplitude_is_wanted_the_motion_is_simulated_until_its_means_agree() {
    for options in [REPELLED, options(RINGS_NEVER)] {
        let mut driven = Driven::with(MonitorOptions { until_settled: true, ..options }, DISPLACEMENT);
        assert_eq!(driven.monitor.verdict(), None);
        assert_eq!(driven.monitor.is_unstable(), options.linear_growth_fed_by.is_some());
        // The first stick ends no cycle; two means are of ten cycles each.
        assert_eq!(driven.sticks_until_verdict(3.0, 0.4), Some((21, Verdict::Unstable)));
        assert!((driven.monitor.amplitude() - 0.4).abs() < 1e-12);
    }
}

#[test]
fn swings_that_grow_too_slowly_to_show_it_have_no_settled_amplitude() {
    let wanted = MonitorOptions { until_settled: true, ..REPELLED };
    // By 3e-8 of the amplitude in a swing: by 3e-5 in a thousand of them.
    let mut driven = Driven::with(wanted, DISPLACEMENT);
    assert_eq!(driven.swings(|time| 0.01 * libm::exp(1e-8 * time)), None);
    assert!(driven.monitor.is_unstable());
    // Swings that have grown before they are constant are those of a cycle.
    let mut driven = Driven::with(wanted, DISPLACEMENT);
    let found = driven.swings(|time| 0.3 - 0.29 * libm::exp(-0.05 * time));
    assert!(found.is_some_and(|(verdict, amplitude)| verdict == Verdict::Unstable && amplitude > 0.299), "{found:?}");
}

#[test]
fn the_amplitude_of_stick_slip_that_scatters_is_its_mean() {
    let mut driven = Driven::with(MonitorOptions { until_settled: true, ..options(RINGS_NEVER) }, DISPLACEMENT);
    for stick in 0..21 {
        driven.stick(3.0);
        let amplitude = if stick % 2 == 0 { 0.3 } else { 0.5 };
        driven.swing(amplitude);
        driven.swing(amplitude);
    }
    assert_eq!(driven.monitor.verdict(), Some(Verdict::Unstable));
    assert!((driven.monitor.amplitude() - 0.4).abs() < 1e-12, "{}", driven.monitor.amplitude());
}

#[test]
fn stick_slip_is_known_to_be_unstable_before_its_amplitude_is_known() {
    let mut driven = Driven::with(MonitorOptions { until_settled: true, ..options(RINGS_NEVER) }, DISPLACEMENT);
    for stick in 1..=10 {
        driven.stick(3.0);
        assert_eq!((driven.monitor.is_unstable(), driven.monitor.verdict()), (stick >= 7, None), "{stick}");
        driven.swing(0.5);
        driven.swing(0.5);
    }
}

#[test]
fn amplitudes_from_before_the_end_of_stick_slip_are_forgotten() {
    let mut driven = Driven::with(MonitorOptions { until_settled: true, ..REPELLED }, DISPLACEMENT);
    for _ in 0..15 {
        driven.stick(3.0);
        driven.swing(0.8);
        driven.swing(0.8);
    }
    driven.swing(0.8);
    driven.swing(0.8);
    assert_eq!(driven.sticks_until_verdict(3.0, 0.4), Some((21, Verdict::Unstable)));
    assert!((driven.monitor.amplitude() - 0.4).abs() < 1e-12);
}

#[test]
fn the_amplitude_of_a_cycle_without_sticking_is_that_of_its_swings() {
    // However small: no motion returns to an equilibrium that repels.
    let mut driven = Driven::with(MonitorOptions { until_settled: true, ..REPELLED }, DISPLACEMENT);
    assert_eq!(driven.verdict_of_swings(|time| 0.002 + decays(0.1, 0.05)(time)), Some(Verdict::Unstable));
    assert!((driven.monitor.amplitude() - 0.002).abs() < 1e-6, "{}", driven.monitor.amplitude());
}

#[test]
fn a_verdict_stands() {
    let mut driven = Driven::new(RINGS_NEVER);
    assert_eq!(driven.verdict_of_swings(|_| 0.05), Some(Verdict::Unstable));
    assert_eq!(driven.check(&[0.009, 0.004, 0.001]), Some(Verdict::Unstable));
}

#[test]
fn a_motion_at_rest_is_stable_however_its_ringing_beats() {
    // After a first swing that may be imitated for ever, 1e-7 of the equilibrium, beating.
    let beats = |time: f64| 1e-7 * (1.5 + (0.3 * time).sin());
    let verdict = |options: MonitorOptions, amplitude: &dyn Fn(f64) -> f64| {
        // So small a displacement that no swing is within it.
        let mut driven = Driven::with(options, 1e-8);
        driven.swing(0.5);
        (driven.verdict_of_swings(amplitude), driven.time)
    };
    let ringing = options(RINGS_FOR_EVER);
    assert_eq!(verdict(ringing, &beats), (Some(Verdict::Stable), 303.0));
    let now_and_then_more = |time: f64| if time % 250.0 < 3.0 { 1e-5 } else { beats(time) };
    assert_eq!(verdict(ringing, &now_and_then_more).0, None);
    // On a slow disc a cycle may be as small.
    assert_eq!(verdict(MonitorOptions { smallest_cycle: 1e-7, ..ringing }, &beats).0, None);
}

#[test]
fn growth_of_what_is_still_says_nothing() {
    // As errors of the steps are, of a start at the equilibrium itself.
    let mut driven = Driven::new(RINGS_NEVER);
    for amplitude in [1e-8, 2e-8, 4e-8] {
        driven.swing(amplitude);
    }
    assert_eq!((driven.monitor.verdict(), driven.monitor.is_unstable()), (None, false));
    driven.swing(1.1e-6);
    assert_eq!(driven.monitor.verdict(), Some(Verdict::Unstable));
}

/// Whether a motion of these amplitudes is doubtful, in steps of this length over that of the first simulation.
fn hovers(refinement: f64, amplitude: impl Fn(f64) -> f64) -> bool {
    let mut driven = Driven::with(MonitorOptions { refinement, ..options(RINGS_NEVER) }, DISPLACEMENT);
    driven.swings(amplitude);
    driven.monitor.is_doubtful()
}

#[test]
fn a_motion_that_hovers_is_doubtful() {
    assert!(hovers(1.0, |_| 0.5), "constant");
    assert!(!hovers(1.0, |time| 0.5 * libm::exp(-0.01 * time)), "shrinking");
    // The amplitude changes by 1e-5 from swing to swing, and then shrinks.
    let lingers = |time: f64| 0.5 * libm::exp(-1e-5 * time.min(200.0) / 3.0 - 0.01 * (time - 200.0).max(0.0));
    assert!(hovers(1.0, lingers) && !hovers(0.5, lingers));
    assert!(!hovers(1.0, |_| 0.99 * DISPLACEMENT), "within the displacement");
}

#[test]
fn a_stick_ends_hovering() {
    let mut driven = Driven::new(RINGS_NEVER);
    (0..5).for_each(|_| driven.swing(0.5));
    driven.stick(1.0);
    // Long after the swing before the stick, and soon after the first one since.
    (0..5).for_each(|_| driven.swing(0.5));
    assert!(!driven.monitor.is_doubtful());
}

#[test]
fn a_pad_that_grazes_is_doubtful_unless_its_verdict_is_known() {
    for (linear_growth_fed_by, is_doubtful) in [(None, true), (Some(DegreeOfFreedom::Tangential), false)] {
        let options = MonitorOptions { until_settled: true, linear_growth_fed_by, ..options(RINGS_NEVER) };
        let mut driven = Driven::with(options, DISPLACEMENT);
        assert!(!driven.monitor.is_doubtful());
        driven.monitor.grazes();
        assert_eq!(driven.monitor.is_doubtful(), is_doubtful);
    }
}

#[test]
fn beats_that_are_largest_after_the_first_swings_are_no_growth() {
    // Of a random brake from rest: pad and disc hand the motion to and fro, and it dies away at their common rate, which
    // is less than that of either.
    let beats = |time: f64| 0.05 * libm::exp(-0.0102 * time) * libm::sin(0.9 + 0.09 * time).abs();
    let mut driven = Driven::with(options(0.0118), 0.001);
    driven.stick(4.0);
    let found = driven.swings(beats);
    assert!(found.is_some_and(|(verdict, _)| verdict == Verdict::Stable), "{found:?}");
    // What grows beyond all that was before does not come back.
    let mut driven = Driven::with(options(0.0118), 0.001);
    driven.stick(4.0);
    let found = driven.swings(|time| 0.05 * libm::exp(0.002 * time) * (0.2 + libm::sin(0.9 + 0.09 * time).abs()));
    assert!(found.is_some_and(|(verdict, _)| verdict == Verdict::Unstable), "{found:?}");
}
