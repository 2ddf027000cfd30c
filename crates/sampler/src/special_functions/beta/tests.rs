//! Tails and quantiles against sums, closed forms and high precision.

use std::cell::Cell;

use super::*;

/// Tails by mpmath 1.4 with 40 digits: numerical integration of the density, at the doubles nearest to these x.
const TAILS: [(f64, f64, f64, bool, f64); 21] = [
    (1.0, 1.0, 0.3, false, 0.3),
    (1.0, 20.0, 0.01, false, 0.182_093_062_402_769_13),
    (20.0, 1.0, 0.8, false, 0.011_529_215_046_068_483),
    (2.0, 3.0, 0.4, true, 0.4752),
    (2.0, 3.0, 0.9, true, 0.003_7),
    (5.0, 1e6, 1e-6, false, 0.003_659_885_148_265_091_6),
    (5.0, 1e6, 1e-5, true, 0.029_251_363_932_457_597),
    (1e6, 5.0, 0.99999, false, 0.029_251_363_933_318_488),
    (30.0, 70.0, 0.25, false, 0.135_814_904_283_427_44),
    (30.0, 70.0, 0.55, true, 2.052_466_240_174_723e-7),
    (999.0, 999.0, 0.45, false, 3.722_113_900_449_52e-6),
    (1000.0, 1000.0, 0.45, false, 3.683_198_869_007_578e-6),
    (1000.0, 1000.0, 0.51, true, 0.185_552_659_431_511_45),
    (300.0, 1e10, 4e-8, true, 7.507_353_610_434_936e-8),
    (1001.0, 1e10, 9e-8, false, 0.000_490_637_800_426_944_8),
    (1001.0, 1e10, 1.3e-7, true, 2.443_539_222_287_532e-18),
    (1e10, 1e10, 0.49998, false, 7.708_628_851_474_704e-9),
    (1e10, 1e10, 0.500_001, true, 0.388_648_705_392_89),
    (1e10, 3e9, 0.7692, false, 4.166_587_537_842_186e-17),
    (1e10, 3e9, 0.76928, true, 8.469_947_513_012_28e-41),
    (1e10, 2.5, 0.999_999_999_8, true, 0.450_584_096_398_483),
];

#[test]
fn tails_agree_with_high_precision() {
    for (a, b, x, upper, expected) in TAILS {
        let tail = if upper { upper_tail(a, b, x) } else { lower_tail(a, b, x) };
        // Beside the method's own error, what the spacing of the doubles next to x makes of it.
        let spacing = power(a, b, Point { x, y: 1.0 - x }) / (x * (1.0 - x)) / expected * f64::EPSILON;
        let rounding = spacing * x.min(1.0 - x);
        let error = (tail / expected - 1.0).abs();
        assert!(error < 1e-13 + rounding, "{a} {b} {x}: {tail} instead of {expected}");
    }
}

#[test]
fn tails_are_binomial_sums() {
    // I_p(k, n - k + 1) = P(at least k of n), the sum of the terms themselves.
    for n in [1u32, 2, 7, 30] {
        for p in [1e-3, 0.2, 0.5, 0.77, 0.999] {
            let mass = |k: u32| {
                let choices = (0..k).fold(1.0, |product, i| product * f64::from(n - i) / f64::from(i + 1));
                choices * f64::powi(p, k as i32) * f64::powi(1.0 - p, (n - k) as i32)
            };
            for k in 1..=n {
                let (a, b) = (f64::from(k), f64::from(n - k + 1));
                let at_least: f64 = (k..=n).map(mass).sum();
                let below: f64 = (0..k).map(mass).sum();
                for (tail, sum) in [(lower_tail(a, b, p), at_least), (upper_tail(a, b, p), below)] {
                    // A far tail is the exponential of a large number, rounded.
                    let limit = 5e-15 - 4e-16 * sum.ln();
                    assert!((tail / sum - 1.0).abs() < limit, "{k} of {n} at {p}: {tail:e} instead of {sum:e}");
                }
            }
        }
    }
}

#[test]
fn both_methods_agree_where_they_meet() {
    for (a, b) in [(1000.0, 1000.0), (1000.0, 1e7), (5e4, 1000.0), (3000.0, 20_000.0)] {
        for deviations in [-6.0, -2.0, -0.5, 0.0] {
            let mean: f64 = a / (a + b);
            let mode_or_below = (a - 1.0) / (a + b - 2.0) * (1.0 - 1e-9);
            let x = (mean + deviations * (mean * (1.0 - mean) / (a + b)).sqrt()).min(mean).min(mode_or_below);
            let point = Point { x, y: 1.0 - x };
            let ratio = by_quadrature(a, b, point) / by_continued_fraction(a, b, point);
            assert!((ratio - 1.0).abs() < 1e-13, "{a} {b} {deviations}: {ratio}");
        }
    }
}

#[test]
fn quantiles_agree_with_high_precision() {
    // mpmath 1.4 with 40 digits: Newton's iteration on the integrated density. Columns: a, b, p, x, 1 - x.
    let table = [
        (1.0, 29.0, 0.025, 0.000_872_646_883_579_922, 0.999_127_353_116_420_1),
        (81.0, 183.0, 0.025, 0.252_736_745_585_271_15, 0.747_263_254_414_728_9),
        (5.0, 999_996.0, 0.025, 1.623_488_319_241_169_8e-6, 0.999_998_376_511_680_8),
        (5.0, 1_000_000.0, 1.0e-12, 1.038_932_401_989_503_2e-8, 0.999_999_989_610_675_9),
        (1.0, 10_000_000_000.0, 1.0e-12, 1.000_000_000_000_5e-22, 1.0),
        (10_000_000_000.0, 1.0, 1.0e-12, 0.999_999_997_236_897_9, 2.763_102_107_775_488e-9),
        (600.0, 700.0, 1.0e-12, 0.366_120_964_817_680_47, 0.633_879_035_182_319_5),
        (2_000.0, 3_000.0, 0.025, 0.386_460_826_567_632_6, 0.613_539_173_432_367_4),
        (2_000.0, 1_000_000_000.0, 1.0e-12, 1.701_376_059_514_080_6e-6, 0.999_998_298_623_940_5),
        (10_000_000_000.0, 10_000_000_000.0, 1.0e-12, 0.499_975_129_343_94, 0.500_024_870_656_06),
        (10_000_000_000.0, 10_000_000_000.0, 0.025, 0.499_993_070_480_878_5, 0.500_006_929_519_121_5),
        (10_000_000_000.0, 3.0, 0.3, 0.999_999_999_638_443_2, 3.615_567_664_850_817e-10),
        (3_000_000_000.0, 7_000_000_000.0, 0.8, 0.300_003_856_789_120_34, 0.699_996_143_210_879_7),
    ];
    for (a, b, p, x, y) in table {
        let quantiles = [(quantile(a, b, p), x), (upper_quantile(b, a, p), y)];
        for (value, expected) in quantiles {
            assert!((value / expected - 1.0).abs() < 3e-15, "{a} {b} {p}: {value} instead of {expected}");
        }
    }
}

#[test]
fn binomial_tails_agree_with_direct_sums() {
    let trials = 30_u64;
    for p in [0.0, 1e-3, 0.2, 0.5, 0.97, 1.0] {
        let mass = |k: u64| {
            let ways = (1..=k).fold(1.0, |ways, i| ways * (trials + 1 - i) as f64 / i as f64);
            ways * libm::pow(p, k as f64) * libm::pow(1.0 - p, (trials - k) as f64)
        };
        for count in 0..=trials {
            let upper: f64 = (count..=trials).map(mass).sum();
            let lower: f64 = (0..=count).map(mass).sum();
            assert!((binomial_at_least(count, trials, p) - upper).abs() < 1e-14, "{p} {count}");
            assert!((binomial_at_most(count, trials, p) - lower).abs() < 1e-14, "{p} {count}");
        }
    }
    assert_eq!((binomial_at_least(4, 3, 0.5), binomial_at_most(4, 3, 0.5)), (0.0, 1.0));
    assert_eq!((binomial_at_least(0, 0, 0.5), binomial_at_most(0, 0, 0.5)), (1.0, 1.0));
}

#[test]
fn small_parameters_are_right_too() {
    // mpmath 1.4 with 50 digits.
    for (a, b, x, lower, upper) in [
        (0.01, 0.01, 0.25, 0.494_586_974_254_139_1, 0.505_413_025_745_860_9),
        (0.01, 0.01, 0.75, 0.505_413_025_745_860_9, 0.494_586_974_254_139_1),
        (0.01, 5.0, 0.000_976_562_5, 0.952_570_819_623_530_5, 0.047_429_180_376_469_424),
        (0.05, 300.0, 0.000_976_562_5, 0.953_489_467_112_266_7, 0.046_510_532_887_733_25),
        (0.125, 0.031_25, 0.875, 0.243_329_868_513_793_58, 0.756_670_131_486_206_4),
        (0.02, 1e5, 3.814_697_265_625e-6, 0.985_214_486_718_733_2, 0.014_785_513_281_266_823),
    ] {
        assert!((lower_tail(a, b, x) / lower - 1.0).abs() < 1e-13, "{a} {b} {x}: {}", lower_tail(a, b, x));
        assert!((upper_tail(a, b, x) / upper - 1.0).abs() < 1e-13, "{a} {b} {x}: {}", upper_tail(a, b, x));
        let odds = |x: f64| x / (1.0 - x);
        // How far x moves with p: 1 / density over ln(odds) is at most some 100.
        assert!((odds(quantile(a, b, lower)) / odds(x) - 1.0).abs() < 1e-11, "{a} {b} {x}");
    }
}

#[test]
fn quantiles_invert_the_tails() {
    for a in [0.5, 1.0, 1.5, 3.0, 80.0, 2500.0, 1e6, 1e10] {
        for b in [0.5, 1.0, 2.0, 45.0, 999.0, 1e4, 1e10] {
            for p in [1e-100, 1e-12, 1e-6, 0.025, 0.5] {
                let back = tails(a, b, Point::from_odds(lower_odds(a, b, p))).0;
                // The density of the logarithm of the tail, times the spacing of the doubles.
                let limit = 1e-13 + 1e-15 * f64::min(a, b).sqrt() * (1.0 - normal::quantile(p));
                assert!((back / p - 1.0).abs() < limit, "{a} {b} {p}: {back}");
            }
        }
    }
    assert_eq!((quantile(2.0, 3.0, 0.0), quantile(2.0, 3.0, 1.0)), (0.0, 1.0));
    assert_eq!((upper_quantile(2.0, 3.0, 0.0), upper_quantile(2.0, 3.0, 1.0)), (1.0, 0.0));
}

#[test]
fn students_quantiles_agree_with_closed_forms_and_high_precision() {
    // One degree of freedom is Cauchy's distribution, two have t = c sqrt(2 / (1 - c^2)).
    for confidence in [0.01, 0.3, 0.5, 0.9, 0.95, 0.999_999] {
        // The closed forms themselves lose digits next to 1.
        let limit = 1e-14 + 1e-15 / (1.0 - confidence);
        let cauchy = (std::f64::consts::FRAC_PI_2 * confidence).tan();
        assert!((student_quantile(confidence, 1.0) / cauchy - 1.0).abs() < limit, "{confidence}");
        let two = confidence * (2.0 / (1.0 - confidence * confidence)).sqrt();
        assert!((student_quantile(confidence, 2.0) / two - 1.0).abs() < limit, "{confidence}");
    }
    // mpmath 1.4 with 30 digits: the density integrated and inverted by Newton's iteration.
    for (confidence, freedom, t) in [
        (0.1, 1_u32, 0.158_384_440_324_536_3),
        (0.95, 1, 12.706_204_736_174_694),
        (0.99, 1, 63.656_741_162_871_526),
        (0.1, 3, 0.136_598_199_353_698_9),
        (0.95, 3, 3.182_446_305_283_708_6),
        (0.99, 3, 5.840_909_309_733_355),
        (0.1, 10, 0.128_890_189_293_273_78),
        (0.95, 10, 2.228_138_851_986_274_4),
        (0.99, 10, 3.169_272_672_616_951),
        (0.1, 30, 0.126_729_613_132_073_6),
        (0.95, 30, 2.042_272_456_301_237_8),
        (0.99, 30, 2.749_995_653_567_225),
        (0.1, 200, 0.125_821_009_779_451_8),
        (0.95, 200, 1.971_896_223_633_909),
        (0.99, 200, 2.600_634_436_191_557_4),
        (0.1, 5_000, 0.125_667_729_307_245_82),
        (0.95, 5_000, 1.960_438_551_706_507_5),
        (0.99, 5_000, 2.576_812_966_556_280_7),
        (0.1, 4_000_000_000, 0.125_661_346_863_051_9),
        (0.95, 4_000_000_000, 1.959_963_985_133_121_6),
        (0.99, 4_000_000_000, 2.575_829_304_778_037),
    ] {
        let value = student_quantile(confidence, f64::from(freedom));
        assert!((value / t - 1.0).abs() < 3e-15, "{confidence} {freedom}: {value}");
    }
    // SciPy 1.17: t.ppf, with numbers of degrees of freedom that are not whole.
    for (confidence, freedom, t) in [
        (0.95, 3.7, 2.867_520_707_191_189_5),
        (0.999, 2.5, 18.277_893_528_131_457),
        (1.0 - 5e-7, 7.5, 15.797_068_326_926_373),
    ] {
        let value = student_quantile(confidence, freedom);
        assert!((value / t - 1.0).abs() < 1e-9, "{confidence} {freedom}: {value}");
    }
}

/// Numbers that forged counts may lead to.
const ODD: [f64; 16] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::MAX,
    f64::MIN_POSITIVE,
    -1.0,
    -1e300,
    0.0,
    1e-10,
    1.0,
    999.5,
    1e6,
    9_007_199_254_740_992.0,
    9.3e18,
    1e30,
    1e300,
];

thread_local! {
    /// Terms of continued fractions that were computed.
    pub(super) static TERMS: Cell<u64> = const { Cell::new(0) };
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn whatever_is_asked_is_answered_with_few_terms() {
    let mut asked = 0;
    for a in ODD {
        for b in ODD {
            for p in [f64::NAN, -1.0, 0.0, 1e-300, 1e-12, 0.025, 0.5, 0.975, 1.0, 2.0] {
                let values = [quantile(a, b, p), upper_quantile(a, b, p), lower_tail(a, b, p), upper_tail(a, b, p)];
                asked += values.len() as u64;
                let is_known = [a, b].iter().all(|of| (1.0..=1e10).contains(of)) && (0.0..=1.0).contains(&p);
                let are_shares = values.iter().all(|value| (0.0..=1.0).contains(value));
                assert!(are_shares || !is_known, "{a} {b} {p}: {values:?}");
            }
        }
    }
    // A term takes some nanoseconds.
    let each = TERMS.get() / asked;
    assert!((1000..100_000).contains(&each), "{each} terms for a question");
}
