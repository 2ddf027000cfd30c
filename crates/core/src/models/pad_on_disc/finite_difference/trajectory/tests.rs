use super::*;
use crate::models::pad_on_disc::criterion::time_domain::{DiscModel, TimeDomain};
use crate::models::pad_on_disc::finite_difference::brake::DiscGrid;
use crate::models::pad_on_disc::flexible_disc::brake::FlexibleBrake;
use crate::models::pad_on_disc::flexible_disc::error::FlexibleError;
use crate::models::pad_on_disc::motion::moment::Moment;
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;

const NOMINAL: RandomInputs = RandomInputs { preload: 0.1, static_friction: 0.39 };

fn brake(speed: f64) -> PadOnDisc {
    PadOnDisc::preset_with(&[("operating_point.rotating_speed", speed)])
}

fn on_grid(speed: f64, points: usize) -> FiniteDifferenceBrake {
    FiniteDifferenceBrake::new(brake(speed), DiscGrid { radial: points, per_pad: points }).unwrap()
}

/// With sixteen modes: what five of them leave out is as much as a grid of 16.
fn modal(speed: f64, start: Start, displacement: f64, horizon: f64) -> Trajectory {
    let settings = TimeDomainSettings { start, displacement, ..Default::default() };
    let criterion = TimeDomain::new(&brake(speed), &DiscModel::Flexible { modes: 16 }, settings).unwrap();
    criterion.trajectory(NOMINAL, horizon).unwrap()
}

/// x, y and phi at any time, from the cubics through displacements and speeds.
fn between_moments(trajectory: &Trajectory, time: f64) -> [f64; 3] {
    let h = trajectory.interval;
    let index = ((time / h) as usize).min(trajectory.moments.len() - 2);
    let [a, b] = [&trajectory.moments[index], &trajectory.moments[index + 1]];
    let s = (time - a.time) / h;
    let cubic = |(x, u): (f64, f64), (next, next_u): (f64, f64)| {
        let (left, right) = (1.0 - s, s);
        left * left * ((1.0 + 2.0 * s) * x + s * h * u) + right * right * ((3.0 - 2.0 * s) * next - left * h * next_u)
    };
    [cubic(a.tangential, b.tangential), cubic(a.normal, b.normal), cubic(a.angle, b.angle)]
}

/// Largest differences of x, y and phi between two motions.
fn farthest(a: &Trajectory, b: &Trajectory) -> [f64; 3] {
    let mut farthest = [0.0_f64; 3];
    for moment in a.moments.iter().filter(|moment| moment.time <= b.moments[b.moments.len() - 1].time) {
        let other = between_moments(b, moment.time);
        for (k, x) in [moment.tangential.0, moment.normal.0, moment.angle.0].into_iter().enumerate() {
            farthest[k] = farthest[k].max((x - other[k]).abs());
        }
    }
    farthest
}

#[test]
fn thin_discs_have_the_equilibrium_of_their_modes() {
    for (thickness, x0) in [(0.01, Some(0.0067411)), (0.006, None)] {
        let brake = PadOnDisc::preset_with(&[("disc.thickness", thickness)]);
        let modal = FlexibleBrake::with_modes(brake.clone(), 24).unwrap().sliding_equilibrium(NOMINAL).unwrap();
        let grid = FiniteDifferenceBrake::new(brake, DiscGrid { radial: 12, per_pad: 12 }).unwrap();
        let on_grid = grid.equilibrium(NOMINAL).unwrap().0.q;
        for (on_grid, modal) in on_grid.into_iter().zip(&modal).take(2) {
            assert!((on_grid / modal - 1.0).abs() < 0.01, "{thickness}: {on_grid} {modal}");
        }
        // By Newton's method and without this code, with the whole pad in contact.
        assert!(x0.is_none_or(|x0: f64| (on_grid[0] / x0 - 1.0).abs() < 3e-3), "{}", on_grid[0]);
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn stick_slip_is_that_of_the_modal_disc() {
    for speed in [10.0, 20.0] {
        let exact = modal(speed, Start::Rest, 0.01, 80.0).settled.unwrap();
        let deviations = |points: usize| {
            let trajectory = on_grid(speed, points).trajectory(NOMINAL, Start::Rest, 0.01, 80.0, Allotment::Linear);
            let settled = trajectory.unwrap().settled.unwrap();
            [
                settled.period.unwrap() - exact.period.unwrap(),
                settled.tangential_max - exact.tangential_max,
                settled.tangential_min - exact.tangential_min,
                settled.stick_fraction - exact.stick_fraction,
            ]
        };
        let (coarse, fine) = (deviations(8), deviations(16));
        for (k, tolerance) in [2.5e-4, 3e-6, 1.5e-6, 1e-4].into_iter().enumerate() {
            // The amplitude is 0.005 to 0.007, the period 3.1 to 3.5.
            assert!(fine[k].abs() < tolerance, "{speed} {k}: {coarse:?} {fine:?}");
            assert!(fine[k].abs() < 0.4 * coarse[k].abs(), "{speed} {k}: {coarse:?} {fine:?}");
        }
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn both_allotments_give_one_motion() {
    let speed = 20.0;
    let [coarse, fine] = [8, 16].map(|points| {
        let brake = on_grid(speed, points);
        // On its way the load jumps, or the test would compare nothing.
        let elements = speed * brake.modal.brake.brake().scales().time * 80.0 / brake.plate.angle;
        assert!(elements > 1.0, "{elements}");
        let [linear, nodal] = [Allotment::Linear, Allotment::Nodal]
            .map(|allotment| brake.trajectory(NOMINAL, Start::Rest, 0.01, 80.0, allotment).unwrap());
        farthest(&linear, &nodal)
    });
    // x goes up to 0.016, y is -0.048, phi 0.001: a thousandth of each.
    for (k, tolerance) in [2e-5, 2e-5, 1e-6].into_iter().enumerate() {
        assert!(fine[k] < tolerance && fine[k] < 0.6 * coarse[k] && fine[k] > 0.0, "{k}: {coarse:?} {fine:?}");
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn nothing_moves_at_the_equilibrium_but_what_the_nodes_stir() {
    let [coarse, fine] = [8, 16].map(|points| {
        let brake = on_grid(40.0, points);
        let trajectory = brake.trajectory(NOMINAL, Start::NearEquilibrium, 1e-9, 120.0, Allotment::Linear).unwrap();
        let first = trajectory.moments[0];
        let mut stirred = [0.0_f64; 3];
        for moment in &trajectory.moments {
            let ratios = [
                moment.tangential.0 / first.tangential.0,
                moment.contact_force / first.contact_force,
                moment.deflection.0 / first.deflection.0,
            ];
            stirred = std::array::from_fn(|k| stirred[k].max((ratios[k] - 1.0).abs()));
        }
        stirred
    });
    for (k, tolerance) in [6e-5, 3e-5, 2e-3].into_iter().enumerate() {
        assert!(fine[k] < tolerance && fine[k] < 0.5 * coarse[k], "{k}: {coarse:?} {fine:?}");
    }
}

#[test]
fn steady_sliding_is_that_of_the_modal_disc() {
    // Preload and friction so strong that the follower load on the deflected surface shows.
    let inputs = RandomInputs { preload: 1.0, static_friction: 3.0 };
    let modes = FlexibleBrake::with_modes(brake(2.0), 16).unwrap();
    let q = modes.sliding_equilibrium(inputs).unwrap();
    let averages = &modes.equations.geometry.patch.averages;
    let (even, odd) = q[3..].split_at(averages.shape.len());
    let sum = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let exact = [q[0], q[1], q[2], sum(even, &averages.shape), sum(odd, &averages.arc_shape)];
    let [coarse, fine] = [8, 16].map(|points| {
        let brake = on_grid(2.0, points);
        let (state, deflection) = brake.equilibrium(inputs).unwrap();
        let surface = brake.surface(&brake.plate.at_rest(&deflection));
        let w = &surface.deflections;
        let by_arc = brake.patch.average(w.iter().zip(&brake.patch.points).map(|(w, point)| w * point.arc));
        let found = [state.q[0], state.q[1], state.q[2], brake.patch.average(w.iter().copied()), by_arc];
        std::array::from_fn::<_, 5, _>(|k| found[k] / exact[k] - 1.0)
    });
    // Of x, y, phi and the disc's mean deflection and tilt under the pad; 4 % of the tilt are the follower's.
    for (k, tolerance) in [3e-4, 3e-4, 3e-4, 8e-3, 1e-2].into_iter().enumerate() {
        assert!(fine[k].abs() < tolerance && fine[k].abs() < 0.4 * coarse[k].abs(), "{k}: {coarse:?} {fine:?}");
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn contact_is_lost_and_found_as_on_the_modal_disc() {
    let (start, displacement) = (Start::NearEquilibrium, 150.0);
    let exact = modal(20.0, start, displacement, 6.0);
    let [coarse, fine] = [8, 16].map(|points| {
        let trajectory =
            on_grid(20.0, points).trajectory(NOMINAL, start, displacement, 6.0, Allotment::Linear).unwrap();
        for motion in [&trajectory, &exact] {
            let shares = motion.moments.iter().map(|moment| moment.contact_share);
            let (least, last) = shares.fold((1.0_f64, 1.0), |(least, _), share| (least.min(share), share));
            assert!(least < 0.75 && last > 0.999, "{least} {last}");
        }
        farthest(&trajectory, &exact)
    });
    // x starts at 1.2, y goes to -0.05, phi to 0.04. The patches' own points show in y, of the one as of the other.
    for (k, (tolerance, shrinks)) in [(3e-4, 0.4), (1e-4, 1.0), (8e-6, 0.4)].into_iter().enumerate() {
        assert!(fine[k] < tolerance && fine[k] < shrinks * coarse[k], "{k}: {coarse:?} {fine:?}");
    }
}

#[test]
fn verdicts_are_those_of_the_modal_disc() {
    for (speed, start, horizon, expected) in [
        (10.0, Start::LimitCycle, 60.0, Verdict::Unstable),
        (22.0, Start::Rest, 60.0, Verdict::Unstable),
        (22.0, Start::Rest, 5.0, Verdict::Undecided),
        (35.0, Start::Rest, 400.0, Verdict::Stable),
    ] {
        let trajectory = on_grid(speed, 6).trajectory(NOMINAL, start, 0.01, horizon, Allotment::Linear).unwrap();
        assert_eq!(trajectory.verdict, expected, "{speed} {start:?}");
        let first = trajectory.moments[0];
        assert_eq!(first.sticks, start == Start::LimitCycle);
        if first.sticks {
            assert!((first.friction_coefficient - 0.39).abs() < 1e-12, "{first:?}");
        }
        assert!((trajectory.interval - 0.1).abs() < 0.02, "{}", trajectory.interval);
        for (index, moment) in trajectory.moments.iter().enumerate() {
            assert!((moment.time - index as f64 * trajectory.interval).abs() < 1e-9);
            assert_eq!(moment.sticks, moment.sliding_speed == 0.0, "{moment:?}");
        }
    }
    // Rising friction is stable by definition.
    let inputs = RandomInputs { static_friction: 0.2, ..NOMINAL };
    let rising = on_grid(10.0, 6).trajectory(inputs, Start::Rest, 0.01, 1.0, Allotment::Linear).unwrap();
    assert_eq!(rising.verdict, Verdict::Stable);
}

#[test]
fn motions_that_cannot_be_simulated_are_refused() {
    let brake = on_grid(10.0, 6);
    let simulate = |inputs, displacement, horizon| {
        brake.trajectory(inputs, Start::Rest, displacement, horizon, Allotment::Linear).unwrap_err()
    };
    for preload in [0.0, -0.1, f64::NAN] {
        let error = simulate(RandomInputs { preload, ..NOMINAL }, 0.01, 10.0);
        assert!(matches!(error, FiniteDifferenceError::Brake(FlexibleError::NotPressed { .. })), "{error}");
    }
    for static_friction in [1e6, f64::NAN] {
        let error = simulate(RandomInputs { static_friction, ..NOMINAL }, 0.01, 10.0);
        assert!(matches!(error, FiniteDifferenceError::Brake(FlexibleError::NoEquilibrium { .. })), "{error}");
    }
    assert!(matches!(simulate(NOMINAL, 0.0, 10.0), FiniteDifferenceError::Settings(_)));
    assert!(matches!(simulate(NOMINAL, 0.01, f64::NAN), FiniteDifferenceError::Settings(_)));
}

#[test]
fn a_motion_that_does_not_turn_is_decided_as_on_the_modal_disc() {
    for speed in [1.0, 5.0] {
        let changes = [("damping.tangential", 5e4), ("operating_point.rotating_speed", speed)];
        let pad = PadOnDisc::preset_with(&changes);
        let settings = TimeDomainSettings::default();
        let modal = TimeDomain::new(&pad, &DiscModel::Flexible { modes: 5 }, settings).unwrap().decide(NOMINAL);
        assert_eq!(modal.verdict, Verdict::Stable, "{speed}");
        let brake = FiniteDifferenceBrake::new(pad, DiscGrid { radial: 6, per_pad: 6 }).unwrap();
        let trajectory = brake.trajectory(NOMINAL, Start::NearEquilibrium, 0.01, 40.0, Allotment::Linear).unwrap();
        let falls = |pair: &[Moment]| pair[1].tangential.0 < pair[0].tangential.0;
        assert!(trajectory.moments.windows(2).all(falls), "{speed}: it turns");
        assert_eq!(trajectory.verdict, Verdict::Stable, "{speed}");
    }
}
