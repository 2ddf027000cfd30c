//! Invented motions on rigid discs, reported swing by swing and stick by stick; the return map knows the true ones.

use super::*;
use crate::friction::law::FrictionLaw;

fn motion(disc_speed: f64, damping: f64, stribeck_velocity: f64, exponent: f64) -> PlanarMotion {
    let law = FrictionLaw::stribeck(1.2, 1.0, stribeck_velocity, exponent);
    PlanarMotion { stiffness: 1.0, damping, disc_speed, law }
}

/// Linearly stable, and stick-slip exists: swings of up to 1.4 surely shrink, those above 3 or so grow into sticking.
fn bistable() -> PlanarMotion {
    motion(4.0, 0.01, 1.0, 1.0)
}

/// The same with the exponent 2, for which cycles may lie inside one another.
fn flat_at_rest() -> PlanarMotion {
    motion(4.0, 0.01, 2.0, 2.0)
}

/// The unstable cycle reaches so far into speeds at which friction is concave that cycles inside it are not excluded.
fn concave_within_the_cycle() -> PlanarMotion {
    motion(4.0, 0.02, 2.5, 4.0)
}

/// Linearly unstable: all motions end in stick-slip.
fn repelling() -> PlanarMotion {
    motion(4.0, 0.002, 1.0, 1.0)
}

/// Linearly unstable a little below the crest of the friction law's slope: all motions end in a small smooth cycle.
fn smooth() -> PlanarMotion {
    let motion = motion(0.815, 0.0, 1.0, 2.5);
    PlanarMotion { damping: -0.98 * motion.damping_at_equilibrium(), ..motion }
}

fn monitor(motion: PlanarMotion, until_settled: bool, a: f64) -> RigidMonitor {
    RigidMonitor::new(motion, until_settled, (motion.equilibrium() + a, 0.0), false)
}

/// Turns below and above the equilibrium at each of these distances, until there is a verdict.
fn swings(monitor: &mut RigidMonitor, tops: &[f64]) -> Option<Verdict> {
    for top in tops {
        monitor.turns(0.0, monitor.equilibrium - top);
        monitor.turns(0.0, monitor.equilibrium + top);
        if monitor.verdict().is_some() {
            break;
        }
    }
    monitor.verdict()
}

#[test]
fn what_surely_comes_to_rest_is_stable_at_once() {
    assert_eq!(monitor(bistable(), false, 0.01).verdict(), Some(Verdict::Stable));
    assert_eq!(monitor(bistable(), true, 0.01).verdict(), Some(Verdict::Stable));
    assert_eq!(monitor(bistable(), false, 2.5).verdict(), None);
}

#[test]
fn a_linearly_unstable_equilibrium_makes_a_motion_unstable_at_once() {
    let at_once = monitor(repelling(), false, 0.01);
    assert_eq!(at_once.verdict(), Some(Verdict::Unstable));
    let simulated = monitor(repelling(), true, 0.01);
    assert_eq!(simulated.verdict(), None);
    assert!(at_once.is_unstable() && simulated.is_unstable());
    assert_eq!(simulated.fed_by(), DegreeOfFreedom::Tangential);
}

#[test]
fn a_swing_that_has_grown_by_more_than_errors_of_the_steps_is_unstable() {
    for grown in [2.53, 2.500_03] {
        let mut monitor = monitor(bistable(), false, 2.5);
        assert_eq!(swings(&mut monitor, &[grown]), Some(Verdict::Unstable));
        assert!(monitor.is_unstable());
    }
}

#[test]
fn where_no_cycle_can_lie_inside_the_first_swing_that_shrinks_is_stable() {
    for shrunk in [2.4, 2.499_97] {
        assert_eq!(swings(&mut monitor(bistable(), false, 2.5), &[shrunk]), Some(Verdict::Stable));
    }
    // Unless the pad passed the disc in between, and the two swings are of different kinds.
    let mut monitor = monitor(bistable(), false, 3.9);
    // The return map knows better than this invented motion how its first swing ends.
    monitor.started = None;
    monitor.overtakes(0.5, ContactState::Slip);
    assert_eq!(swings(&mut monitor, &[3.5]), None);
}

#[test]
fn where_a_cycle_can_lie_inside_shrinking_swings_are_simulated_until_they_surely_come_to_rest() {
    let mut monitor = monitor(flat_at_rest(), false, 3.9);
    assert_eq!(swings(&mut monitor, &[3.8, 3.5, 3.0]), None);
    assert!(!monitor.is_unstable());
    assert_eq!(swings(&mut monitor, &[0.1]), Some(Verdict::Stable));
}

#[test]
fn a_swing_is_compared_with_the_one_before() {
    let mut monitor = monitor(flat_at_rest(), false, 3.9);
    assert_eq!(swings(&mut monitor, &[3.5, 3.6]), Some(Verdict::Unstable));
}

#[test]
fn turns_below_the_equilibrium_are_compared_with_nothing() {
    let mut monitor = monitor(bistable(), false, 3.0);
    for below in [2.0, 4.0, 1.9, 1.9] {
        monitor.turns(0.0, monitor.equilibrium - below);
    }
    assert_eq!(monitor.verdict(), None);
}

#[test]
fn the_return_map_decides_slow_swings() {
    for shift in [1.0 + 5e-6, 1.0, 1.0 - 5e-6] {
        assert_eq!(swings(&mut monitor(bistable(), false, 2.5), &[2.5 * shift]), Some(Verdict::Stable));
        assert_eq!(swings(&mut monitor(bistable(), false, 3.5), &[3.5 * shift]), Some(Verdict::Unstable));
        let mut monitor = monitor(bistable(), true, 3.5);
        assert_eq!(swings(&mut monitor, &[3.5 * shift]), Some(Verdict::Unstable));
        let (out, back) = bistable().slip_from(bistable().release());
        assert_eq!(monitor.amplitude(), 0.5 * (out.x - back.unwrap().smallest), "of the stick-slip that follows");
    }
}

#[test]
fn a_motion_that_the_return_map_cannot_resolve_is_simulated_further() {
    // The unstable cycle between rest and stick-slip, to the last digits.
    let (mut shrinking, mut captured) = (0.5, 3.9);
    for _ in 0..60 {
        let middle = 0.5 * (shrinking + captured);
        match concave_within_the_cycle().fate_of_swing(middle) {
            Fate::Equilibrium => shrinking = middle,
            Fate::Grows { .. } => captured = middle,
            _ => (shrinking, captured) = (middle, middle),
        }
    }
    assert_eq!(concave_within_the_cycle().fate_of_swing(shrinking), Fate::Unresolved);
    let mut monitor = monitor(concave_within_the_cycle(), false, shrinking);
    assert_eq!(swings(&mut monitor, &[shrinking; 3]), None);
    assert!(monitor.is_unresolved, "the map is not used again");
    assert_eq!(swings(&mut monitor, &[0.98 * shrinking]), None);
    assert!(!monitor.is_unresolved, "but of another swing");
    assert_eq!(swings(&mut monitor, &[0.98 * shrinking]), Some(Verdict::Stable));
}

#[test]
fn the_first_stick_decides_nothing_and_the_second_that_all_cycles_are_the_same() {
    let mut monitor = monitor(bistable(), false, 3.9);
    monitor.sticks(1.0, 0.9);
    assert_eq!(monitor.verdict(), None);
    assert!(!monitor.is_unstable());
    monitor.slips(2.0);
    monitor.sticks(3.0, 0.9);
    assert_eq!(monitor.verdict(), Some(Verdict::Unstable));
    assert!(monitor.is_unstable());
}

#[test]
fn a_start_at_release_counts_as_a_stick() {
    let motion = bistable();
    let mut monitor = RigidMonitor::new(motion, false, (motion.release(), motion.disc_speed), true);
    assert_eq!(monitor.verdict(), None);
    monitor.sticks(1.0, 0.9);
    assert_eq!(monitor.verdict(), Some(Verdict::Unstable));
}

#[test]
fn a_swing_after_a_stick_is_not_compared_with_one_before_it() {
    let mut monitored = monitor(bistable(), false, 2.5);
    monitored.sticks(1.0, 0.9);
    monitored.slips(2.0);
    assert_eq!(swings(&mut monitored, &[3.5]), None);
    // Nor after a release without a reported stick.
    let mut monitored = monitor(bistable(), false, 2.5);
    monitored.slips(2.0);
    assert_eq!(swings(&mut monitored, &[3.5]), None);
}

#[test]
fn a_stick_too_long_to_simulate_is_decided_by_its_release() {
    // A disc so slow that it carries the pad to its release for 350 units of time; a light pad sticks again, an
    // overdamped one creeps towards the equilibrium.
    for (damping, verdict) in [(0.1, Verdict::Unstable), (2.5, Verdict::Stable)] {
        let motion = motion(1e-3, damping, 1e-4, 1.0);
        // An invented motion: the return map knows better how its first swing ends.
        let mut sticking = RigidMonitor { started: None, ..monitor(motion, false, 0.15) };
        assert_eq!(sticking.verdict(), None);
        sticking.sticks(1.0, motion.release() - 0.09);
        assert_eq!(sticking.verdict(), None, "{damping}: a stick of 90 units of time is simulated");
        // An invented motion: the return map knows better how its first swing ends.
        let mut sticking = RigidMonitor { started: None, ..monitor(motion, false, 0.15) };
        sticking.sticks(1.0, motion.release() - 0.35);
        assert_eq!(sticking.verdict(), Some(verdict), "{damping}");
    }
}

#[test]
fn the_amplitude_of_stick_slip_is_half_of_its_last_swing() {
    let mut monitor = monitor(bistable(), true, 2.5);
    assert_eq!(swings(&mut monitor, &[2.6]), None);
    assert!(monitor.is_unstable(), "known, but simulated for its amplitude");
    monitor.sticks(1.0, 0.9);
    monitor.slips(2.0);
    assert_eq!(swings(&mut monitor, &[3.9]), None);
    monitor.sticks(3.0, 0.9);
    assert_eq!(monitor.verdict(), Some(Verdict::Unstable));
    assert!((monitor.amplitude() - 3.9).abs() < 1e-12, "{}", monitor.amplitude());
}

#[test]
fn the_amplitude_of_a_smooth_cycle_is_that_of_the_return_map() {
    let Fate::SmoothCycle { amplitude } = smooth().settles(smooth().fate_of_swing(0.05)) else {
        panic!("there is a smooth cycle")
    };
    let mut monitor = monitor(smooth(), true, 0.05);
    assert_eq!(swings(&mut monitor, &[0.06, 0.07]), None);
    assert_eq!(swings(&mut monitor, &[0.0701]), Some(Verdict::Unstable));
    assert!((monitor.amplitude() / amplitude - 1.0).abs() < 1e-6, "{} {amplitude}", monitor.amplitude());
    assert!(monitor.is_unstable());
}

#[test]
fn a_motion_known_to_be_unstable_does_not_come_to_rest() {
    // As errors of steps might have it.
    let mut monitor = monitor(bistable(), true, 2.5);
    assert_eq!(swings(&mut monitor, &[2.6, 1.0]), None);
    monitor.check(monitor.equilibrium, 0.0);
    assert_eq!(monitor.verdict(), None);
    assert_eq!(swings(&mut monitor, &[2.5, 2.5]), None, "whatever the return map finds for such a swing");
}

#[test]
fn a_check_decides_a_motion_that_surely_comes_to_rest_without_a_turn() {
    let mut monitor = monitor(bistable(), false, 2.5);
    monitor.check(monitor.equilibrium + 1.0, 2.3);
    assert_eq!(monitor.verdict(), None);
    monitor.check(monitor.equilibrium + 0.5, 0.5);
    assert_eq!(monitor.verdict(), Some(Verdict::Stable));
}

#[test]
fn the_return_map_decides_a_start_that_grazes() {
    for (a, verdict) in [(2.5, Verdict::Stable), (3.5, Verdict::Unstable)] {
        let mut monitor = monitor(bistable(), false, a);
        monitor.grazes();
        assert_eq!(monitor.verdict(), Some(verdict), "{a}");
    }
}

#[test]
fn a_start_that_is_captured_ends_as_its_release_does() {
    // So damped that there is no stick-slip: from far away the pad is captured, but from its release it comes to rest.
    let damped = motion(4.0, 0.03, 1.0, 1.0);
    let mut monitor = monitor(damped, false, 6.0);
    assert_eq!(damped.fate_from([damped.equilibrium() + 6.0, 0.0]), Fate::Captured);
    monitor.grazes();
    assert_eq!(monitor.verdict(), Some(Verdict::Stable));
}

#[test]
fn what_is_about_to_be_captured_ends_as_its_release_does() {
    for (damping, verdict) in [(0.03, Verdict::Stable), (0.01, Verdict::Unstable)] {
        let mut monitor = monitor(motion(4.0, damping, 1.0, 1.0), false, 6.0);
        monitor.is_caught(monitor.equilibrium);
        assert_eq!(monitor.verdict(), Some(verdict), "{damping}");
    }
}

#[test]
fn the_return_map_decides_a_release_that_grazes_though_the_start_would_have_come_to_rest() {
    let mut monitor = monitor(bistable(), false, 2.5);
    monitor.slips(1.0);
    monitor.grazes();
    assert_eq!(monitor.verdict(), Some(Verdict::Unstable));
}

#[test]
fn only_the_first_swing_grazes() {
    let mut monitor = monitor(flat_at_rest(), false, 3.9);
    assert_eq!(swings(&mut monitor, &[3.5]), None);
    monitor.grazes();
    assert_eq!(monitor.verdict(), None);
}

#[test]
fn a_motion_outside_one_that_does_not_come_to_rest_is_unstable() {
    // Of two brakes that differ in their damping, stick-slip exists for one only.
    for (damping, verdict) in [(0.01, Some(Verdict::Unstable)), (0.03, None)] {
        let mut monitor = monitor(motion(4.0, damping, 1.0, 1.0), false, 6.0);
        // The first time the pad may stick soon. Falling back to the disc's speed says nothing.
        monitor.overtakes(-2.0, ContactState::Overtaking);
        monitor.overtakes(1.0, ContactState::Slip);
        assert_eq!(monitor.verdict(), None);
        monitor.overtakes(-2.0, ContactState::Overtaking);
        assert_eq!(monitor.verdict(), verdict, "{damping}");
    }
}

#[test]
fn outside_a_cycle_of_stick_slip_a_motion_ends_in_that_cycle() {
    let motion = bistable();
    let mut monitor = monitor(motion, true, 6.0);
    monitor.overtakes(-2.0, ContactState::Overtaking);
    assert_eq!(monitor.verdict(), None);
    monitor.overtakes(-1.95, ContactState::Overtaking);
    assert_eq!(monitor.verdict(), Some(Verdict::Unstable));
    let cycle = motion.limit_cycle().unwrap();
    assert_eq!(monitor.amplitude(), 0.5 * (cycle.tangential_max - cycle.tangential_min));
}

#[test]
fn a_place_has_settled_when_what_is_left_of_its_change_is_small() {
    let settles = |ratio: f64, first: f64| {
        let mut monitor = monitor(bistable(), true, 6.0);
        let places = [0.0, 1.0, 2.0].map(|cycle| -2.0 + first * ratio.powf(cycle));
        assert!(!monitor.has_settled(places[0], places[1]), "a single change says nothing of the next");
        monitor.has_settled(places[1], places[2])
    };
    assert!(settles(0.5, 1e-5));
    assert!(!settles(0.5, 1e-3));
    // A small change, but a thousand times as much is to come.
    assert!(!settles(0.999, 1e-2));
    assert!(settles(0.999, 1e-6));
}

#[test]
fn a_verdict_stands() {
    let mut stable = monitor(bistable(), false, 3.5);
    stable.check(stable.equilibrium, 0.0);
    assert_eq!(stable.verdict(), Some(Verdict::Stable));
    stable.grazes();
    stable.turns(1.0, stable.equilibrium + 3.7);
    stable.turns(2.0, stable.equilibrium + 3.9);
    for time in [3.0, 5.0] {
        stable.sticks(time, 0.9);
        stable.slips(time + 1.0);
    }
    assert_eq!(stable.verdict(), Some(Verdict::Stable));
    assert!(!stable.is_unstable());
}

#[test]
fn slow_swings_are_awaited_a_hundred_times_and_no_longer() {
    let slow = |from: f64, count: i32| (1..=count).map(|i| from * 0.998_f64.powi(i)).collect::<Vec<f64>>();
    let mut monitored = monitor(flat_at_rest(), false, 3.9);
    assert_eq!(swings(&mut monitored, &slow(3.9, 100)), None);
    assert!(!monitored.is_unresolved, "the return map is not asked yet");
    let last = 3.9 * 0.998_f64.powi(101);
    let fate = flat_at_rest().fate_of_swing(last);
    assert!(matches!(fate, Fate::Grows { .. }), "the invented swings shrink, those of this motion do not: {fate:?}");
    assert_eq!(swings(&mut monitored, &[last]), Some(Verdict::Unstable));
    // Swings that shrink fast are no slow ones.
    let mut monitored = monitor(flat_at_rest(), false, 3.9);
    let fast: Vec<f64> = (1..=5).map(|i| 3.9 * 0.989_f64.powi(i)).collect();
    assert_eq!(swings(&mut monitored, &fast), None);
    assert_eq!(swings(&mut monitored, &slow(fast[4], 98)), None);
}
