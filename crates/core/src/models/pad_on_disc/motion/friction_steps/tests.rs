use super::*;

const EXPONENTS: [f64; 5] = [0.5, 1.0, 1.5, 2.0, 3.0];

/// A disc at speed 10 and a Stribeck velocity of 1/2.
fn limits(exponent: f64, falling_pull: f64, refinement: f64) -> FrictionSteps {
    FrictionSteps::new(10.0, 2.0, stribeck(exponent), (falling_pull, 0.0), refinement)
}

fn stribeck(exponent: f64) -> LimitedLaw {
    LimitedLaw::new(Shape::of_stribeck(exponent), exponent)
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
            assert_eq!(limits.judge(speeds, accelerations, h).0, is_too_long);
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
            assert!(limits.judge(speeds, accelerations, longest * (1.0 + 1e-12)).0);
            assert!(!limits.judge(speeds, accelerations, longest * (1.0 - 1e-12)).0);
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
    let series = |p: f64| 1.0 + p * (1.0 + p * (0.5 + p * (1.0 / 6.0 + p / 24.0)));
    let change_allowed = [
        // Exponent 1: 0.25 (1 + p/5 + p^2/50).
        (1.0, 0.0, 0.25),
        (1.0, 1.0, 0.25 * 1.22),
        (1.0, 10.0, 0.25 * 5.0),
        // Above 1: 0.5 e(p) / delta below r = 1; 0.5 e(p) r^(1 - delta) / delta above.
        (2.0, 0.1, 0.5 * series(0.01 / 5.0) / 2.0),
        (2.0, 0.5, 0.5 * series(0.25 / 5.0) / 2.0),
        (2.0, 2.0, 0.5 * series(4.0 / 5.0) / 4.0),
        (3.0, 1.0, 0.5 * series(1.0 / 5.0) / 3.0),
        (3.0, 4.0, 0.5 * series(64.0 / 5.0) / 48.0),
        (1.5, 0.3, 0.5 * series(0.164_3 / 5.0) / 1.5),
        // Below 1: 0.5 e(p) r^(1 - delta) / delta, and no more than 0.75 r.
        (0.5, 4.0, 0.5 * series(2.0 / 5.0) * 4.0),
        (0.5, 25.0, 0.5 * series(5.0 / 5.0) * 10.0),
        (0.5, 1.0, 0.75),
        (0.5, 0.0, 0.75 * 1e-5),
    ];
    for (exponent, r, allowed) in change_allowed {
        // The nearer end counts, and the larger acceleration.
        for (speeds, accelerations) in [((r, r), (3.0, -3.0)), ((r, r + 1.0), (0.0, -3.0)), ((r + 1.0, r), (3.0, 1.0))]
        {
            let speeds = (speed(speeds.0), speed(speeds.1));
            let excess = limits(exponent, 0.0, 1.0).excess(speeds, accelerations, 0.1);
            let expected = 0.1 * 3.0 * 2.0 / allowed;
            // Powers are rough but for the exponents 1 and 2.
            let tolerance = if exponent == 1.0 || exponent == 2.0 { 1e-10 } else { 0.05 };
            assert!((excess / expected - 1.0).abs() < tolerance, "{exponent} {r}: {excess} {expected}");
        }
    }
}

#[test]
fn near_rest_a_step_is_short_or_friction_changes_little_in_it() {
    // A disc at two Stribeck velocities; the step changes r by 0.05.
    let excess = |exponent: f64, falling_pull: f64| {
        let limits = FrictionSteps::new(1.0, 2.0, stribeck(exponent), (falling_pull, 0.0), 1.0);
        limits.excess((1.0 - 0.07 / 2.0, 1.0 - 0.02 / 2.0), (0.25, 0.25), 0.1)
    };
    for (exponent, is_limited) in [(0.5, true), (1.2, true), (1.6, true), (2.0, false), (3.0, false)] {
        assert_eq!(excess(exponent, 1.5) > 1.0, is_limited, "{exponent}");
    }
    // Where friction hardly changes the speed of the pad, only exponents below 1 are limited.
    for (exponent, is_limited) in [(0.5, true), (1.2, false), (1.6, false), (2.0, false)] {
        assert_eq!(excess(exponent, 1e-4) > 1.0, is_limited, "{exponent}");
    }
    // Friction that changes the speed by less than what a change of 0.75 r would allow.
    let by_size = 0.1 * 0.35 * libm::pow(0.07, 1.2) / (5e-4 * 1.0);
    assert!(by_size < 0.05 / (0.75 * 0.02));
    assert!((excess(1.2, 0.35) / by_size - 1.0).abs() < 0.03);
}

#[test]
fn a_step_through_sticking_is_limited_as_one_that_reaches_it() {
    for exponent in EXPONENTS {
        let limits = limits(exponent, 0.0, 1.0);
        let at = limits.excess((speed(0.0), speed(0.5)), (1.0, 1.0), 0.1);
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
        let limits = FrictionSteps::new(1.0, 1e3, stribeck(exponent), (0.1, 0.0), 1.0);
        assert!(!limits.judge((0.0, 0.1), (1.0, 1.0), 0.1).0, "{exponent}");
        assert!(limits.judge((0.99, 1.0), (1.0, 1.0), 0.1).0, "{exponent}");
        assert!(limits.judge((1.0, 0.99), (1.0, 1.0), 0.1).0, "{exponent}");
    }
}

#[test]
fn at_release_the_falling_friction_limits_a_step_of_no_acceleration() {
    // From sticking to one Stribeck velocity: the steepest friction, from where friction has not fallen yet.
    let steepest = [
        (0.5, 0.5 * 1e5_f64.sqrt() / 1.003_2),
        (1.0, 1.0),
        (1.5, 1.5 * libm::pow(3.0, -1.0 / 3.0) * libm::exp(-1.0 / 3.0)),
        (2.0, 2.0 * 0.5_f64.sqrt() * libm::exp(-0.5)),
    ];
    for (exponent, slope) in steepest {
        let excess = limits(exponent, 7.0, 1.0).excess((speed(0.0), speed(1.0)), (0.0, 0.0), 0.1);
        let expected = 0.1 * 7.0 * 2.0 * slope / 0.4;
        assert!((excess / expected - 1.0).abs() < if exponent == 0.5 { 0.01 } else { 1e-9 }, "{exponent}: {excess}");
    }
    // Farther away it is the less the more friction has fallen.
    let excess = limits(1.0, 7.0, 1.0).excess((speed(4.0), speed(2.0)), (0.0, 0.0), 0.1);
    assert!((excess - 0.1 * 7.0 * 2.0 / (0.4 * 7.0)).abs() < 1e-9);
    let excess = limits(2.0, 7.0, 1.0).excess((speed(3.0), speed(2.0)), (0.0, 0.0), 0.1);
    let growth = 1.0 + 4.0 + 8.0 + 64.0 / 6.0 + 256.0 / 24.0;
    assert!((excess - 0.1 * 7.0 * 2.0 * 4.0 / growth / 0.4).abs() < 1e-9);
}
