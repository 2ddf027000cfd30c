use super::*;

const SPEEDS: [f64; 9] = [0.0, 0.02, 0.05, 0.1, 0.2, 0.4, 0.8, 1.2, 2.0];
const COEFFICIENTS: [f64; 9] = [0.48, 0.46, 0.41, 0.36, 0.31, 0.27, 0.26, 0.29, 0.33];
const DEVIATIONS: [f64; 9] = [0.03, 0.03, 0.02, 0.02, 0.015, 0.01, 0.01, 0.02, 0.04];

fn curve() -> MeasuredCurve {
    MeasuredCurve::new(&SPEEDS, &COEFFICIENTS, Some(&DEVIATIONS)).unwrap()
}

#[test]
fn values_and_slopes_are_scipys() {
    // scipy 1.17.1, PchipInterpolator of the rows and one more at 3 m/s with the values of the last one: speed,
    // coefficient, its slope, standard deviation.
    let table = [
        (0.0, 0.48, -0.733_333_333_333_330_1, 0.03),
        (0.01, 0.471_240_437_158_469_97, -1.009_289_617_486_337_3, 0.03),
        (0.02, 0.46, -1.229_508_196_721_310_4, 0.03),
        (0.033, 0.438_913_034_014_132_73, -1.859_305_119_559_743_2, 0.025_994_074_074_074_072),
        (0.1, 0.36, -0.692_307_692_307_692_2, 0.02),
        (0.17, 0.320_848_461_538_461_5, -0.422_538_461_538_461_4, 0.016_588_846_153_846_155),
        (0.5, 0.265_701_013_513_513_55, -0.037_246_621_621_621_65, 0.01),
        (0.79, 0.260_006_579_391_891_9, -0.001_315_033_783_783_781, 0.01),
        (0.9, 0.263_536_931_818_181_83, 0.065_198_863_636_363_57, 0.011_093_75),
        (1.9, 0.328_952_414_772_727_3, 0.020_348_011_363_636_412, 0.039_414_062_499_999_99),
        (2.0, 0.33, 0.0, 0.04),
        (2.5, 0.33, 0.0, 0.04),
    ];
    let curve = curve();
    for (speed, coefficient, slope, deviation) in table {
        assert!((curve.coefficient(speed) - coefficient).abs() < 1e-14, "{speed}");
        assert!((curve.coefficient(-speed) - coefficient).abs() < 1e-14, "{speed}");
        assert!((0.48 * curve.slopes(speed).0 - slope).abs() < 1e-12, "{speed}");
        assert!((curve.deviation(speed) - deviation).abs() < 1e-14, "{speed}");
    }
}

#[test]
fn a_curve_that_begins_beyond_rest_is_constant_before() {
    // scipy 1.17.1, with one more row at rest and one at 2 m/s.
    let curve = MeasuredCurve::new(&[0.05, 0.3, 1.0], &[0.4, 0.3, 0.25], None).unwrap();
    let table = [
        (0.0, 0.4),
        (0.04, 0.4),
        (0.06, 0.399_585_101_075_268_84),
        (0.2, 0.340_103_225_806_451_6),
        (0.5, 0.276_189_431_225_639_27),
        (0.99, 0.250_011_141_415_091_34),
        (1.5, 0.25),
    ];
    for (speed, coefficient) in table {
        assert!((curve.coefficient(speed) - coefficient).abs() < 1e-8, "{speed}");
    }
    assert_eq!(curve.values(-0.3), curve.values(0.0));
}

#[test]
fn rows_are_met_exactly() {
    let curve = curve();
    for (speed, coefficient) in SPEEDS.into_iter().zip(COEFFICIENTS) {
        assert!((curve.coefficient(speed) / coefficient - 1.0).abs() < 1e-15, "{speed}");
    }
    assert_eq!(curve.values(0.0).0, 1.0);
}

/// Speeds of many kinds: even, spread over decades, in clusters as near as allowed.
fn speeds_of_many_kinds() -> Vec<Vec<f64>> {
    let even = |rows: u32| (0..rows).map(|i| 0.1 * f64::from(i)).collect();
    let decades = (0..40).map(|i| libm::pow(10.0, -5.0 + 0.15 * f64::from(i))).collect();
    let clusters = [1.0, 7.3, 900.0].iter().flat_map(|base| (0..50).map(move |i| base * (1.0 + 1.1e-4 * f64::from(i))));
    vec![even(3), even(30), even(1000), decades, clusters.collect(), vec![0.0, 1e-300, 1e-3], vec![0.3, 0.4]]
}

#[test]
fn every_speed_is_found_in_its_interval() {
    for speeds in speeds_of_many_kinds() {
        let values: Vec<f64> = speeds.iter().map(|speed| 0.2 + 0.1 / (1.0 + speed)).collect();
        let curve = MeasuredCurve::new(&speeds, &values, None).unwrap();
        let last = speeds[speeds.len() - 1];
        let neighbours =
            |speed: f64| [speed, f64::from_bits(speed.to_bits() + 1), f64::from_bits(speed.to_bits().max(1) - 1)];
        let some = (0..=2000).map(|i| 1.1 * last * f64::from(i) / 2000.0);
        for speed in speeds.iter().flat_map(|&speed| neighbours(speed)).chain(some) {
            let expected = speeds.iter().rposition(|&knot| knot <= speed).unwrap_or(0);
            assert_eq!(curve.interval(speed), expected, "{speed} {speeds:?}");
        }
    }
}

#[test]
fn slopes_are_continuous_and_curves_monotone_between_rows() {
    let curve = SharedCurve::new(curve());
    let pieces: Vec<Piece> = curve.pieces_between([0.0, f64::INFINITY], (0.48, 0.0)).collect();
    assert_eq!(pieces.len(), SPEEDS.len() - 1);
    for pair in pieces.windows(2) {
        let knot = pair[0].to;
        assert!((pair[0].slope(knot) - pair[1].slope(knot)).abs() < 1e-12, "{knot}");
        assert!((pair[0].value(knot) - pair[1].value(knot)).abs() < 1e-14, "{knot}");
    }
    for piece in pieces {
        let rises = piece.value(piece.to) > piece.value(piece.from);
        for i in 0..=100 {
            let slope = piece.slope(piece.from + (piece.to - piece.from) * f64::from(i) / 100.0);
            assert!(if rises { slope >= -1e-12 } else { slope <= 1e-12 }, "{piece:?}");
        }
    }
}

#[test]
fn the_speeds_of_a_slope_and_the_steepest_fall_are_those_of_a_search() {
    let curve = SharedCurve::new(curve());
    for piece in curve.pieces_between([0.0, f64::INFINITY], (0.48, 1.5)) {
        let at = |i: u32| piece.from + (piece.to - piece.from) * f64::from(i) / 2000.0;
        let steepest = piece.slope(piece.steepest_fall(piece.from, piece.to));
        let searched = (0..=2000).map(|i| piece.slope(at(i))).fold(f64::INFINITY, f64::min);
        assert!(steepest <= searched && steepest > searched - 1e-4, "{piece:?}");
        for slope in [-1.3, -0.5, -0.1, 0.0, 0.05] {
            let found = piece.speeds_of_slope(slope);
            assert!(found.iter().all(|&speed| (piece.slope(speed) - slope).abs() < 1e-12), "{piece:?}");
            let changes =
                (1..1999).filter(|&i| (piece.slope(at(i)) > slope) != (piece.slope(at(i + 1)) > slope)).count();
            assert!(found.len() >= changes && found.len() <= changes + 2, "{piece:?} {slope} {found:?}");
        }
    }
}

#[test]
fn windows_bound_slopes_and_bends_of_neighbours() {
    let curve = curve();
    let second = |speed: f64| (curve.slopes(speed + 1e-7).0 - curve.slopes(speed - 1e-7).0) / 2e-7;
    for i in 0..SPEEDS.len() - 1 {
        let window = curve.window(i);
        let (from, to) = (SPEEDS[i.saturating_sub(1)], SPEEDS[(i + 2).min(SPEEDS.len() - 1)]);
        let at = |j: u32| from + (to - from) * (f64::from(j) + 0.5) / 1000.0;
        let steepest = (0..1000).map(|j| curve.slopes(at(j)).0.abs()).fold(0.0, f64::max);
        assert!(window.steepest.0 >= steepest && window.steepest.0 < 1.01 * steepest + 1e-3, "{i}");
        let (first, last) = (SPEEDS[i] + 1e-6, SPEEDS[i + 1] - 1e-6);
        assert!(window.bend.0 >= 0.99 * (second(first) - second(last)).abs(), "{i}");
    }
}

#[test]
fn bad_rows_are_refused_with_their_row() {
    let refused = |speeds: &[f64], coefficients: &[f64], deviations: Option<&[f64]>| {
        MeasuredCurve::new(speeds, coefficients, deviations).unwrap_err()
    };
    assert_eq!(refused(&[1.0], &[0.3], None), CurveError::TooFewRows { rows: 1 });
    assert_eq!(refused(&[], &[], None), CurveError::TooFewRows { rows: 0 });
    assert!(matches!(refused(&[0.0, 1.0], &[0.3], None), CurveError::UnequalColumns { column: "coefficient", .. }));
    assert!(matches!(
        refused(&[0.0, 1.0], &[0.3, 0.2], Some(&[0.1])),
        CurveError::UnequalColumns { column: "std", .. }
    ));
    assert_eq!(
        refused(&[0.0, 1.0, 0.5], &[0.3, 0.2, 0.2], None),
        CurveError::NotRising { row: 2, speed: 0.5, before: 1.0 }
    );
    assert!(matches!(refused(&[0.0, 0.5, 0.5], &[0.3, 0.2, 0.2], None), CurveError::NotRising { row: 2, .. }));
    assert!(matches!(refused(&[0.0, 0.5, 0.500_01], &[0.3, 0.2, 0.2], None), CurveError::TooNear { row: 2, .. }));
    for bad in [-0.1, f64::NAN, f64::INFINITY] {
        for (speeds, coefficients, deviations, column) in [
            ([0.0, bad], [0.3, 0.2], [0.1, 0.1], "speed"),
            ([0.0, 1.0], [0.3, bad], [0.1, 0.1], "coefficient"),
            ([0.0, 1.0], [0.3, 0.2], [0.1, bad], "std"),
        ] {
            let error = refused(&speeds, &coefficients, Some(&deviations));
            assert!(
                matches!(&error, CurveError::OutOfRange { row: 1, column: named, .. } if *named == column),
                "{error:?}"
            );
        }
    }
    assert_eq!(refused(&[0.0, 1.0], &[0.0, 0.2], None), CurveError::NothingAtRest);
    let many = vec![0.1; MOST_ROWS + 1];
    assert_eq!(refused(&many, &many, None), CurveError::TooManyRows { rows: MOST_ROWS + 1 });
}

#[test]
fn the_same_curve_is_stored_once() {
    let first = SharedCurve::new(curve());
    assert_eq!(first, SharedCurve::new(curve()));
    assert!(std::ptr::eq(first.0, SharedCurve::new(curve()).0));
    let other = MeasuredCurve::new(&[0.0, 1.0], &[0.3, 0.2], None).unwrap();
    assert_ne!(first, SharedCurve::new(other));
}

#[test]
fn a_curve_says_how_often_it_falls_and_rises() {
    let counts = |coefficients: &[f64]| {
        let speeds: Vec<f64> = (0_u32..).map(f64::from).take(coefficients.len()).collect();
        MeasuredCurve::new(&speeds, coefficients, None).unwrap().falls_and_rises()
    };
    assert_eq!(curve().falls_and_rises(), [1, 1]);
    assert_eq!(counts(&[0.3, 0.3]), [0, 0]);
    assert_eq!(counts(&[0.3, 0.4, 0.4, 0.5]), [0, 1]);
    assert_eq!(counts(&[0.4, 0.3, 0.3, 0.2, 0.25, 0.2]), [2, 1]);
}

/// The rows of `tests/data/friction/noisy-curve.csv`, at every 0.05 m/s.
const NOISY: [f64; 40] = [
    0.4940, 0.4525, 0.4381, 0.4183, 0.4063, 0.3786, 0.3720, 0.3589, 0.3471, 0.3399, 0.3342, 0.3288, 0.3192, 0.3219,
    0.3115, 0.2915, 0.3142, 0.3015, 0.2966, 0.3002, 0.2978, 0.2948, 0.2877, 0.2924, 0.2807, 0.2974, 0.2802, 0.2856,
    0.2862, 0.2866, 0.2832, 0.2870, 0.2619, 0.2818, 0.2811, 0.2791, 0.2906, 0.2753, 0.2805, 0.2685,
];

#[test]
fn a_smoothed_curve_falls_where_a_noisy_one_falls_and_rises() {
    let speeds: Vec<f64> = (0_u32..40).map(|row| 0.05 * f64::from(row)).collect();
    assert_eq!(MeasuredCurve::new(&speeds, &NOISY, None).unwrap().falls_and_rises(), [11, 10]);
    let curve = MeasuredCurve::smoothed(&speeds, &NOISY, None).unwrap();
    assert_eq!(curve.falls_and_rises(), [1, 0]);
    // As an independent program in Python found.
    let smoothing = curve.smoothing().unwrap();
    assert!((smoothing.residual - 0.006_166).abs() < 1e-5, "{}", smoothing.residual);
    assert!((smoothing.parameters - 5.224).abs() < 0.01, "{}", smoothing.parameters);
    for (row, expected) in [0.497_998, 0.452_017, 0.430_916].into_iter().enumerate() {
        assert!((curve.coefficients()[row] - expected).abs() < 1e-5, "{row}: {}", curve.coefficients()[row]);
    }
    assert_eq!(smoothing.coefficients, NOISY);
    assert_eq!(curve.at_rest(), curve.coefficients()[0]);
    assert_eq!(curve.coefficient(0.5), curve.coefficients()[10]);
}

#[test]
fn a_smoothed_curve_is_the_spline_between_its_rows_too() {
    let speeds: Vec<f64> = (0_u32..40).map(|row| 0.05 * f64::from(row)).collect();
    let curve = MeasuredCurve::smoothed(&speeds, &NOISY, None).unwrap();
    // scipy 1.17.1, make_smoothing_spline over the root of the speed with the least score of generalised cross-validation
    // (inflation 1.4, softness in steps of a quarter): speed, coefficient, slope.
    let table = [
        (0.05, 0.452_017_492, -0.489_050_507),
        (0.125, 0.421_875_080, -0.348_402_578),
        (0.5, 0.335_006_337, -0.142_013_003),
        (0.525, 0.331_564_739, -0.133_406_250),
        (1.0, 0.295_048_632, -0.040_021_562),
        (1.61, 0.280_456_847, -0.015_157_790),
    ];
    for (speed, coefficient, slope) in table {
        let found = curve.at_rest() * curve.slopes(speed).0;
        assert!((curve.coefficient(speed) - coefficient).abs() < 1e-8, "{speed}: {}", curve.coefficient(speed));
        assert!((found / slope - 1.0).abs() < 1e-4, "{speed}: {found} for {slope}");
    }
}

/// A friction coefficient over the sliding speed.
type Law<'a> = &'a dyn Fn(f64) -> f64;

/// Rows of uneven distances whose spline turns, or would be below 0: the curve is monotone between knots, and its bound is
/// its least value.
#[test]
fn a_smoothed_curve_is_monotone_between_knots_and_never_below_its_bound() {
    let near_rest = |speed: f64| 0.2 + 0.25 * libm::exp(-speed / 0.02);
    let parabola = |speed: f64| 0.3 * (speed - 1.1) * (speed - 1.1);
    let uneven = [0.0, 0.001, 0.5, 1.0, 1.5, 2.0];
    let even: Vec<f64> = (0_u32..12).map(|row| 0.2 * f64::from(row)).collect();
    let decades: Vec<f64> = (0_u32..40).map(|row| libm::pow(10.0, 0.1 * f64::from(row) - 3.0)).collect();
    let curves: [(&[f64], Law<'_>); 5] = [
        (&uneven, &near_rest),
        (&even, &near_rest),
        (&even, &parabola),
        (&decades, &near_rest),
        (&decades, &|speed| 0.5 - 0.1 * libm::log10(speed)),
    ];
    for (number, (speeds, law)) in curves.into_iter().enumerate() {
        let rows: Vec<f64> = speeds.iter().map(|speed| law(*speed)).collect();
        let curve = SharedCurve::new(MeasuredCurve::smoothed(speeds, &rows, Some(&rows)).unwrap());
        let bound = curve.at_rest() * curve.lower_bound(1.0, 0.0);
        assert!(bound >= 0.0, "{number}: {bound}");
        for piece in curve.pieces_between([0.0, f64::INFINITY], (curve.at_rest(), 0.0)) {
            let values: Vec<f64> =
                (0..=50).map(|i| piece.value(piece.from + (piece.to - piece.from) * f64::from(i) / 50.0)).collect();
            let rises = values[50] >= values[0];
            let is_monotone =
                |pair: &[f64]| if rises { pair[1] >= pair[0] - 1e-15 } else { pair[1] <= pair[0] + 1e-15 };
            assert!(values.windows(2).all(is_monotone), "{number}: {piece:?}");
            assert!(values.iter().all(|value| *value >= bound - 1e-15), "{number}: {piece:?} {bound}");
        }
    }
    // The parabola turns where it does, between two rows.
    let parabola: Vec<f64> = even.iter().map(|speed| 0.2 + parabola(*speed)).collect();
    let curve = MeasuredCurve::smoothed(&even, &parabola, None).unwrap();
    assert_eq!(curve.falls_and_rises(), [1, 1]);
    let least =
        (0..=2200).map(|i| 1e-3 * f64::from(i)).min_by(|a, b| curve.coefficient(*a).total_cmp(&curve.coefficient(*b)));
    assert!((least.unwrap() - 1.1).abs() < 0.02, "{least:?}");
}

#[test]
fn a_straight_line_is_smoothed_to_itself() {
    let speeds = [0.0, 0.25, 1.0, 2.25, 4.0, 6.25];
    let line = speeds.map(|speed: f64| 0.5 - 0.08 * speed.sqrt());
    let curve = MeasuredCurve::smoothed(&speeds, &line, Some(&[0.01; 6])).unwrap();
    for (fitted, value) in curve.coefficients().iter().zip(line) {
        assert!((fitted - value).abs() < 1e-12, "{fitted} {value}");
    }
    assert!(curve.deviations().unwrap().iter().all(|std| (std - 0.01).abs() < 1e-12));
    assert!(curve.smoothing().unwrap().residual < 1e-12);
}

#[test]
fn few_rows_are_not_smoothed() {
    let rows = |count: usize| MeasuredCurve::smoothed(&[0.0, 1.0, 2.0, 3.0, 4.0][..count], &[0.3; 5][..count], None);
    assert_eq!(rows(4).unwrap_err(), CurveError::TooFewToSmooth { rows: 4 });
    assert!(rows(5).is_ok());
    assert_eq!(rows(1).unwrap_err(), CurveError::TooFewRows { rows: 1 });
    let zero = MeasuredCurve::smoothed(&[0.0, 1.0, 2.0, 3.0, 4.0], &[0.0; 5], None);
    assert_eq!(zero.unwrap_err(), CurveError::NothingAtRest);
}
