use super::*;
use crate::friction::measured_curve::MeasuredCurve;

const EXPONENTS: [f64; 5] = [0.5, 1.0, 1.5, 2.0, 3.0];

/// A disc at speed 10 and a Stribeck velocity of 1/2.
fn limits(exponent: f64, falling_pull: f64, refinement: f64) -> FrictionSteps {
    FrictionSteps::new(10.0, 2.0, (Shape::of_stribeck(exponent), exponent), (falling_pull, 0.0), refinement)
}

/// The speed of a pad that slides at `r` Stribeck velocities.
fn speed(r: f64) -> f64 {
    10.0 - 0.5 * r
}

/// Speeds and accelerations at the ends of steps, from a simple generator: speeds mostly near the disc's.
fn states() -> impl Iterator<Item = ((f64, f64), (f64, f64), f64)> {
    let mut state = 0x9E37_79B9_7F4A_7C15_u64;
    let mut draw = move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    std::iter::repeat_with(move || {
        let mut r = || 60.0 * (draw() - 0.2) * draw() * draw();
        let speeds = (speed(r()), speed(r()));
        (speeds, (40.0 * (draw() - 0.5), 40.0 * (draw() - 0.5)), 200.0 * draw() * draw())
    })
    .take(20_000)
}

#[test]
fn for_exponent_one_a_step_is_too_long_exactly_if_its_excess_is_above_one() {
    let mut seen = [0; 2];
    for (speeds, accelerations, falling_pull) in states() {
        let limits = limits(1.0, falling_pull, 1.0);
        let longest = 1.0 / limits.excess(speeds, accelerations, 1.0);
        for share in [0.01, 0.3, 1.0 - 1e-12, 1.0 + 1e-12, 2.0, 50.0] {
            let h = share * longest;
            let is_too_long = limits.is_too_long_for_tustin(speeds, accelerations, h);
            assert_eq!(is_too_long, share > 1.0, "{speeds:?} {accelerations:?} {falling_pull} {share}");
            assert_eq!(limits.is_too_long(speeds, accelerations, h), is_too_long);
            seen[usize::from(is_too_long)] += 1;
        }
    }
    assert_eq!(seen, [60_000; 2]);
}

#[test]
fn for_any_exponent_the_excess_says_how_much_shorter_a_step_has_to_be() {
    for exponent in EXPONENTS {
        for (speeds, accelerations, falling_pull) in states().take(1000) {
            let limits = limits(exponent, falling_pull, 1.0);
            let longest = 1.0 / limits.excess(speeds, accelerations, 1.0);
            assert!(limits.is_too_long(speeds, accelerations, longest * (1.0 + 1e-12)));
            assert!(!limits.is_too_long(speeds, accelerations, longest * (1.0 - 1e-12)));
        }
    }
}

#[test]
fn limits_scale_with_the_refinement() {
    for exponent in EXPONENTS {
        for (speeds, accelerations, falling_pull) in states().take(1000) {
            let [whole, half] =
                [1.0, 0.5].map(|share| limits(exponent, falling_pull, share).excess(speeds, accelerations, 0.1));
            assert!((half / whole - 2.0).abs() < 1e-12, "{exponent} {whole} {half}");
        }
    }
}

#[test]
fn the_sliding_speed_may_change_as_much_as_the_table_allows() {
    let change_allowed = [
        // Exponent 1: 0.25 e(r).
        (1.0, 0.0, 0.25),
        (1.0, 1.0, 0.25 * 1.22),
        (1.0, 10.0, 0.25 * 5.0),
        // Above 1: at most 0.3 r; 1 / delta below r = 1; r^(1 - delta) / delta above.
        (2.0, 0.1, 0.03),
        (2.0, 0.5, 0.25 * 1.051_25 / 2.0),
        (2.0, 2.0, 0.25 * 2.12 / 4.0),
        (3.0, 0.9, 0.25 * (1.0 + 0.729 / 5.0 + 0.729 * 0.729 / 50.0) / 3.0),
        // Below 1: at most 0.3 r, r^(1 - delta) / delta.
        (0.5, 1.0, 0.3),
        (0.5, 25.0, 0.25 * 2.5 * 10.0),
        // At rest, where derivatives of the law are infinite.
        (0.5, 0.0, 0.3e-5),
        (2.0, 0.0, 0.3e-5),
    ];
    for (exponent, r, allowed) in change_allowed {
        // The nearer end counts, and the larger acceleration.
        for (speeds, accelerations) in [((r, r), (3.0, -3.0)), ((r, r + 1.0), (0.0, -3.0)), ((r + 1.0, r), (3.0, 1.0))]
        {
            let speeds = (speed(speeds.0), speed(speeds.1));
            let excess = limits(exponent, 0.0, 1.0).excess(speeds, accelerations, 0.1);
            let expected = 0.1 * 3.0 * 2.0 / allowed;
            // Up to what is lost where the speed of the pad is subtracted from the disc's.
            assert!((excess / expected - 1.0).abs() < 1e-10, "{exponent} {r}: {excess} {expected}");
        }
    }
}

#[test]
fn a_step_through_sticking_is_as_long_as_one_at_it() {
    for exponent in EXPONENTS {
        let limits = limits(exponent, 0.0, 1.0);
        let at = limits.excess((speed(0.0), speed(0.0)), (1.0, 1.0), 0.1);
        for speeds in [(0.5, -2.0), (-2.0, 0.5)] {
            let through = limits.excess((speed(speeds.0), speed(speeds.1)), (1.0, 1.0), 0.1);
            assert_eq!(through, at, "{exponent}");
        }
    }
}

#[test]
fn a_step_is_cut_near_sticking_and_not_where_friction_has_died() {
    // A disc a thousand Stribeck velocities fast, and a step of a tenth over the natural frequency.
    for exponent in EXPONENTS {
        let limits = FrictionSteps::new(1.0, 1e3, (Shape::of_stribeck(exponent), exponent), (0.1, 0.0), 1.0);
        assert!(!limits.is_too_long((0.0, 0.1), (1.0, 1.0), 0.1), "{exponent}");
        assert!(limits.is_too_long((0.99, 1.0), (1.0, 1.0), 0.1), "{exponent}");
        assert!(limits.is_too_long((1.0, 0.99), (1.0, 1.0), 0.1), "{exponent}");
    }
}

#[test]
fn at_release_the_falling_friction_limits_a_step_of_no_acceleration() {
    // From sticking to one Stribeck velocity: the steepest friction in between.
    let steepest = [
        (0.5, 0.5 * 1e5_f64.sqrt() * libm::exp(-1e-5_f64.sqrt())),
        (1.0, 1.0),
        (2.0, 2.0 * 0.5_f64.sqrt() * libm::exp(-0.5)),
    ];
    for (exponent, slope) in steepest {
        let excess = limits(exponent, 7.0, 1.0).excess((speed(0.0), speed(1.0)), (0.0, 0.0), 0.1);
        let expected = 0.1 * 7.0 * 2.0 * slope / 0.4;
        assert!((excess / expected - 1.0).abs() < 1e-9, "{exponent}: {excess} {expected}");
    }
    // Farther away it is the less the more friction has fallen.
    let excess = limits(1.0, 7.0, 1.0).excess((speed(4.0), speed(2.0)), (0.0, 0.0), 0.1);
    assert!((excess - 0.1 * 7.0 * 2.0 / (0.4 * 7.0)).abs() < 1e-9);
    let excess = limits(2.0, 7.0, 1.0).excess((speed(3.0), speed(2.0)), (0.0, 0.0), 0.1);
    assert!((excess - 0.1 * 7.0 * 2.0 * 4.0 * libm::exp(-4.0) / 0.4).abs() < 1e-9);
}

#[test]
fn a_step_that_lanes_take_for_short_is_short() {
    let curve = MeasuredCurve::new(&[0.0, 1.0, 4.0, 12.0], &[0.4, 0.3, 0.25, 0.3], None).unwrap();
    let stribeck = [0.3, 0.7, 1.0, 1.4, 2.0, 5.0].map(|exponent| (Shape::of_stribeck(exponent), exponent));
    let others = [(Shape::Rational, 1.0), (Shape::Table(SharedCurve::new(curve)), 1.0)];
    for law in stribeck.into_iter().chain(others) {
        let mut counts = [0; 3];
        for (speeds, accelerations, falling_pull) in states().take(5000) {
            let limits = FrictionSteps::new(10.0, 2.0, law, (falling_pull, 0.0), 1.0);
            for h in [1e-4, 1e-3, 1e-2] {
                let is = limits.is_too_long(speeds, accelerations, h);
                let may_be = limits.may_be_too_long(speeds, accelerations, h);
                assert!(may_be || !is, "{law:?} {speeds:?} {accelerations:?} {h}");
                counts[usize::from(is) + usize::from(may_be)] += 1;
            }
        }
        // Few steps are left to the scalar code in vain.
        assert!(counts[0] > 1000 && counts[2] > 100 && counts[1] < counts[0], "{law:?} {counts:?}");
    }
}
