use super::*;
use crate::friction::measured_curve::{MeasuredCurve, SharedCurve};
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::uniform_draws;
use crate::models::pad_on_disc::rigid_disc::planar_motion::SlipEnd;

fn motion(law: FrictionLaw, disc_speed: f64, damping: f64) -> PlanarMotion {
    PlanarMotion { stiffness: 1.0, damping, disc_speed, law }
}

/// Laws from weakly to strongly curved, with exponents above 1, and measured curves of three to eight rows, some with
/// scatter or with an end that rises.
fn laws(draw: &mut impl FnMut() -> f64) -> FrictionLaw {
    if draw() < 0.5 {
        let exponent = 1.05 + 3.0 * draw() * draw();
        return FrictionLaw::stribeck(0.3 + draw(), 0.3, 1.0, exponent).with_additional(0.02 * draw());
    }
    let rows = 3 + (6.0 * draw()) as usize;
    let speeds: Vec<f64> = (0..rows).map(|i| 0.7 * i as f64 + 0.3 * draw()).collect();
    let (rise, scatter, drop) = (0.1 * draw(), if draw() < 0.5 { 0.0 } else { 0.02 }, draw());
    let values: Vec<f64> = speeds.iter().map(|s| 0.3 + drop * libm::exp(-s) + rise * s + scatter * draw()).collect();
    let deviations: Vec<f64> = speeds.iter().map(|_| 0.02 * draw()).collect();
    let curve = MeasuredCurve::new(&speeds, &values, Some(&deviations)).unwrap();
    FrictionLaw::table(SharedCurve::new(curve), values[0], 1.0).with_additional(4.0 * draw() - 2.0)
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn where_no_cycle_is_inside_a_swing_that_shrinks_all_smaller_ones_shrink() {
    let mut draw = uniform_draws(7);
    let [mut decided, mut shrinking, mut of_tables] = [0; 3];
    for _ in 0..4000 {
        let law = laws(&mut draw);
        let v = 0.3 + 3.5 * draw();
        // Damping somewhat above what keeps the equilibrium stable, so that cycles exist.
        let motion = motion(law, v, (law.fall(v) + 0.1 * draw() * draw()).max(0.0));
        let top = v * (0.2 + 0.8 * draw());
        let swing = motion.slip([motion.equilibrium() + top, 0.0], top);
        let distances = (swing.x - motion.equilibrium(), motion.equilibrium() - swing.smallest);
        if swing.end != SlipEnd::Turned || distances.0 >= top || motion.damping_at_equilibrium() <= 0.0 {
            continue;
        }
        shrinking += 1;
        if !motion.has_no_cycle_inside(Turns { top, bottom: distances.1, next_top: distances.0 }) {
            continue;
        }
        decided += 1;
        of_tables += usize::from(matches!(law.shape, Shape::Table(_)));
        for share in [0.98, 0.95, 0.9, 0.8, 0.7, 0.6, 0.5, 0.35, 0.2, 0.1, 0.05] {
            let inner = motion.slip([motion.equilibrium() + share * top, 0.0], share * top);
            let shrinks = inner.end == SlipEnd::Equilibrium || inner.x - motion.equilibrium() < share * top;
            assert!(inner.end != SlipEnd::Captured && shrinks, "{law:?} {v} {top} {share}");
        }
    }
    assert!(decided > 1000 && of_tables > 200 && decided < shrinking, "{decided} {of_tables} {shrinking}");
}

#[test]
fn the_condition_is_the_derivative_of_the_damping_over_the_speed() {
    let mut draw = uniform_draws(8);
    for _ in 0..200 {
        let exponent = 1.05 + 3.0 * draw();
        let motion = motion(FrictionLaw::stribeck(1.0, 0.3, 1.0, exponent).with_additional(0.1), 2.0, 0.05);
        let (law, s) = (motion.law, 0.1 + 1.8 * draw());
        let f_over_u = |u: f64| (motion.damping - law.fall(2.0 - u)) / u;
        let (u, step) = (2.0 - s, 1e-5);
        let expected = (f_over_u(u + step) - f_over_u(u - step)) / (2.0 * step) * u * u;
        let g = motion.condition(s, -law.fall(s), law.curvature(s));
        assert!((g - expected).abs() < 1e-5 * (1.0 + expected.abs() / u), "{exponent} {s}: {g} {expected}");
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn no_half_swing_is_faster_than_its_bound() {
    let mut draw = uniform_draws(9);
    let [mut bounded, mut swings] = [0; 2];
    for _ in 0..600 {
        let law = FrictionLaw::stribeck(0.3 + 0.6 * draw(), 0.3, 1.0, 1.0 + 2.0 * draw());
        let v = 3.0;
        let motion = motion(law, v, 0.2 * draw());
        // Up from a bottom to the next top.
        let bottom = 3.0 * draw();
        let mut state = [motion.equilibrium() - bottom, 0.0];
        let mut fastest = 0.0_f64;
        while state[1] >= 0.0 && state[1] < v {
            let rate = |[x, u]: [f64; 2]| [u, law.coefficient(v - u) - x - motion.damping * u];
            state = crate::numerics::dormand_prince::step(rate, state, 1e-3).0;
            fastest = fastest.max(state[1]);
        }
        if fastest >= v {
            continue;
        }
        swings += 1;
        let friction = |u: f64| (law.coefficient(v - u) - law.coefficient(v), motion.damping * u);
        let bound = motion.fastest((bottom, state[0] - motion.equilibrium()), v, friction);
        assert!(fastest <= bound, "{law:?} {bottom}: {fastest} {bound}");
        bounded += usize::from(bound < 1.3 * fastest);
    }
    assert!(4 * bounded > 3 * swings && swings > 100, "{bounded} of {swings} within 30 %");
}

#[test]
fn a_linearly_unstable_equilibrium_has_a_cycle_or_capture_around_it() {
    let law = FrictionLaw::stribeck(1.2, 1.0, 1.0, 2.0);
    let small = Turns { top: 1e-3, bottom: 1e-3, next_top: 1e-3 };
    let unstable = motion(law, 2.0, 0.5 * law.fall(2.0));
    assert!(!unstable.has_no_cycle_inside(small) && !unstable.has_no_inner_cycle());
    let stable = motion(law, 2.0, 1.5 * law.fall(2.0));
    assert!(stable.has_no_cycle_inside(small) && !stable.has_no_inner_cycle());
}
