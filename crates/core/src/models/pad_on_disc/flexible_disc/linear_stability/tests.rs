use super::*;
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;

fn flexible(changes: &[(&str, f64)]) -> FlexibleBrake {
    FlexibleBrake::with_modes(PadOnDisc::preset_with(changes), 5).unwrap()
}

/// Inputs over the plane, denser towards the boundary of the preset's product.
fn inputs(count: u32) -> impl Iterator<Item = RandomInputs> {
    (0..count).map(move |i| {
        let (a, b) = (0.618_034 * f64::from(i), 0.414_214 * f64::from(i));
        let (a, b) = (a - a.floor(), b - b.floor());
        let preload = 0.005 + 0.6 * a * a;
        let fall = if i % 2 == 0 { b * 0.7 - 0.1 } else { 0.0138 / preload * (1.0 + 0.02 * (b - 0.5)) };
        RandomInputs { preload, static_friction: 0.25 + fall }
    })
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn the_lattice_agrees_with_the_eigenvalues() {
    for changes in [
        vec![("operating_point.rotating_speed", 15.4)],
        vec![("operating_point.rotating_speed", 15.4), ("disc.youngs_modulus", 4e9)],
        vec![("operating_point.rotating_speed", 24.0), ("friction.stribeck_exponent", 2.0)],
        vec![("operating_point.rotating_speed", 20.0), ("disc.transverse_damping_ratio", 0.0)],
        // 50 Stribeck velocities: nothing is left of the fall of friction there.
        vec![("operating_point.rotating_speed", 15.0), ("friction.stribeck_velocity", 0.0405)],
    ] {
        let flexible = flexible(&changes);
        let mut by_lattice = 0;
        for inputs in inputs(300) {
            let exact = flexible.by_eigenvalues(inputs).unwrap();
            if let Some(stability) = flexible.by_lattice(inputs, &|| false) {
                assert_eq!(stability, exact, "{changes:?} {inputs:?}");
                by_lattice += 1;
            }
            assert_eq!(flexible.linear_stability(inputs).unwrap(), exact);
        }
        // An undamped disc flutters almost everywhere, and has few critical products.
        let flutters = changes.contains(&("disc.transverse_damping_ratio", 0.0));
        assert!(flutters || by_lattice > 200, "{changes:?}: {by_lattice}");
    }
}

#[test]
fn flutter_is_fed_by_the_disc_and_stick_slip_by_the_tangential_motion() {
    let nominal = RandomInputs { preload: 0.1, static_friction: 0.39 };
    let groaning = flexible(&[("operating_point.rotating_speed", 12.0)]);
    let tangential = LinearStability::Unstable { fed_by: DegreeOfFreedom::Tangential };
    assert_eq!(groaning.linear_stability(nominal).unwrap(), tangential);
    assert_eq!(groaning.by_eigenvalues(nominal).unwrap(), tangential);
    let disc = LinearStability::Unstable { fed_by: DegreeOfFreedom::Disc };
    for changes in [
        [("disc.transverse_damping_ratio", 0.0), ("operating_point.rotating_speed", 40.0)],
        [("disc.transverse_damping_ratio", 0.02), ("operating_point.rotating_speed", 2e4)],
    ] {
        assert_eq!(flexible(&changes).linear_stability(nominal).unwrap(), disc, "{changes:?}");
    }
}

#[test]
fn an_eigenvector_is_one() {
    let flexible = flexible(&[]);
    let inputs = RandomInputs { preload: 0.1, static_friction: 0.39 };
    let q = flexible.sliding_equilibrium(inputs).unwrap();
    let matrix = flexible.equations.linearise_with(&q, 0.3).first_order(0.3);
    for value in eigenvalues(&matrix).unwrap().into_iter().take(3) {
        let vector = eigenvector(&matrix, value);
        let image = matrix.map(|entry| Complex::new(entry, 0.0)) * &vector;
        let residual = (image - &vector * value).norm();
        assert!(residual < 1e-7 * vector.norm(), "{value}: {residual}");
    }
}

#[test]
fn friction_that_rises_feeds_the_disc_and_not_the_tangential_motion() {
    // Stable at constant friction: it is the rise that makes the disc unstable.
    let brake = flexible(&[
        ("friction.kinetic_coefficient", 0.265_554),
        ("disc.thickness", 0.010_090_7),
        ("disc.youngs_modulus", 1.804_529e11),
        ("disc.transverse_damping_ratio", 2.571_451e-6),
        ("operating_point.rotating_speed", 24.187_893),
        ("friction.stribeck_velocity", 7.032_717),
        ("damping.tangential", 281.416_845),
    ]);
    let inputs = RandomInputs { preload: 0.177_652, static_friction: 0.034_344 };
    let q = brake.sliding_equilibrium(inputs).unwrap();
    let mu = brake.equations.coefficients.pad.steady_friction(inputs.static_friction);
    assert!(brake.equations.linearise_with(&q, mu).growth_rate(0.0).unwrap() < 0.0);
    assert!(brake.growth_rate(inputs).unwrap() > 0.0);
    let disc = LinearStability::Unstable { fed_by: DegreeOfFreedom::Disc };
    assert_eq!(brake.by_eigenvalues(inputs).unwrap(), disc);
    assert_eq!(brake.linear_stability(inputs).unwrap(), disc);
}
