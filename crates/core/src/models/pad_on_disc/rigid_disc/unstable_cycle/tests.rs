use super::*;
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;
use crate::models::pad_on_disc::rigid_disc::return_map::Fate;

fn cycle(changes: &[(&str, f64)]) -> UnstableCycle {
    match PadOnDisc::preset_with(changes).planar_motion().innermost_unstable_cycle() {
        Surrounding::Cycle(cycle) => cycle,
        Surrounding::Unresolved => panic!("{changes:?}"),
    }
}

#[test]
fn unstable_cycles_are_where_an_independent_integration_finds_them() {
    // SciPy 1.17.1, solve_ivp with DOP853, rtol 1e-13, atol 1e-15, forward in time; the amplitude at which a swing
    // returns to itself by brentq, xtol and rtol 1e-14; the area by integrating u^2 along. Columns: speed (rad/s),
    // exponent; outward, inward, period, forward, backward, area.
    let cases = [
        (
            (16.0, 1.0),
            0.0013234533715,
            -0.0012174014995,
            3.0077184648,
            0.0026480590290,
            -0.0026502724917,
            1.0593414950e-5,
        ),
        (
            (22.0, 1.0),
            0.0059762160237,
            -0.0047700207393,
            3.0287271594,
            0.0107606738796,
            -0.0110980564295,
            1.8809662493e-4,
        ),
        (
            (30.0, 1.0),
            0.0100982048764,
            -0.0078886117231,
            3.0467709229,
            0.0173017534285,
            -0.0185412150385,
            5.2269338908e-4,
        ),
        (
            (22.0, 0.6),
            0.0060407523158,
            -0.0051402266234,
            3.0163370076,
            0.0114528357471,
            -0.0116096490253,
            2.0451534921e-4,
        ),
        (
            (12.0, 2.0),
            0.0011809537777,
            -0.0009654626072,
            3.0196309014,
            0.0021923837787,
            -0.0022209528439,
            7.5317862081e-6,
        ),
    ];
    for ((speed, exponent), outward, inward, period, forward, backward, area) in cases {
        let cycle = cycle(&[("operating_point.rotating_speed", speed), ("friction.stribeck_exponent", exponent)]);
        for (ours, reference) in [
            (cycle.outward, outward),
            (cycle.inward, inward),
            (cycle.period, period),
            (cycle.forward, forward),
            (cycle.backward, backward),
            (cycle.area, area),
        ] {
            assert!((ours / reference - 1.0).abs() < 1e-9, "{speed} {exponent}: {ours} {reference}");
        }
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn near_the_critical_speed_the_amplitude_grows_with_the_root_of_the_distance() {
    let critical = PadOnDisc::preset_with(&[]).unstable_speeds().last().unwrap().to;
    let at = |distance: f64| cycle(&[("operating_point.rotating_speed", critical * (1.0 + distance))]).outward;
    let limit = at(1e-6) / 1e-6_f64.sqrt();
    for (distance, tolerance) in [(1e-5, 1e-3), (1e-7, 1e-3), (1e-8, 1e-3)] {
        assert!((at(distance) / distance.sqrt() / limit - 1.0).abs() < tolerance, "{distance}");
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn a_cycle_that_no_motion_follows_forward_in_time_is_found() {
    // Amplitudes just inside it and just outside differ by less than their last digit after one turn.
    let brakes = [
        (3.0, 1417.5, 0.52268, 0.69132, 0.013591, 0.14352, 5.65),
        (1.3, 1771.0, 0.54525, 0.72026, 0.021981, 0.39907, 9.67),
        (2.0, 2552.6, 0.091066, 0.13575, 0.011589, 0.71757, 1.43),
    ];
    for (exponent, damping, kinetic, static_, stribeck, preload, speed) in brakes {
        let cycle = cycle(&[
            ("friction.stribeck_exponent", exponent),
            ("damping.tangential", damping),
            ("friction.kinetic_coefficient", kinetic),
            ("friction.static_coefficient", static_),
            ("friction.stribeck_velocity", stribeck),
            ("operating_point.preload", preload),
            ("operating_point.rotating_speed", speed),
        ]);
        assert!(cycle.outward > 0.0 && cycle.forward > 0.0 && cycle.area > 0.0, "{cycle:?}");
    }
}

#[test]
fn the_innermost_of_two_cycles_is_found() {
    // The Gaussian law, critical at 1.25 v_s: just above, where the third derivative of friction has its sign of higher
    // speeds and the fifth has not, a stable cycle of slip lies outside the unstable one.
    let at = |speed: f64, damping: f64| {
        let changes = [
            ("friction.stribeck_exponent", 2.0),
            ("damping.tangential", damping),
            ("operating_point.rotating_speed", speed),
        ];
        PadOnDisc::preset_with(&changes).planar_motion()
    };
    let critical = 1.25 * 0.72 / 0.135;
    let motion = at(critical, 369.0);
    let damping = 369.0 * (1.0 - motion.damping_at_equilibrium() / motion.damping);
    let motion = at(critical * (1.0 + 4e-4), damping);
    let Surrounding::Cycle(cycle) = motion.innermost_unstable_cycle() else { panic!("no cycle") };
    assert_eq!(motion.fate_of_swing(cycle.outward * (1.0 - 1e-5)), Fate::Equilibrium);
    let outside = motion.settles(motion.fate_of_swing(cycle.outward * (1.0 + 1e-5)));
    let Fate::SmoothCycle { amplitude } = outside else { panic!("{outside:?}") };
    assert!(amplitude > 1.2 * cycle.outward, "{amplitude} {cycle:?}");
    // Ten times further from the critical speed both are gone.
    let motion = at(critical * (1.0 + 4e-3), damping);
    assert_eq!(motion.fate_of_swing(amplitude), Fate::Equilibrium);
}
