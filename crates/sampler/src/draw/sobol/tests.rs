//! The points against those of other programs, and the properties of a scrambled net.

use super::*;
use rand::SeedableRng;

fn scrambled(dimensions: usize, seed: u64) -> ScrambledSobol {
    ScrambledSobol::new(dimensions, &mut Xoshiro256PlusPlus::seed_from_u64(seed))
}

/// `L = 1`, `e = 0`.
fn unscrambled(dimensions: usize) -> ScrambledSobol {
    let columns = std::array::from_fn(|k| 1 << (u64::BITS as usize - 1 - k));
    ScrambledSobol::with_scrambles(dimensions, || Scramble { columns, shift: 0 })
}

fn point(sobol: &ScrambledSobol, index: u64) -> Vec<f64> {
    points(sobol, index, 1).remove(0)
}

fn points(sobol: &ScrambledSobol, start: u64, count: u64) -> Vec<Vec<f64>> {
    let mut cursor = sobol.cursor(start);
    let mut out = vec![0.0; sobol.dimensions];
    (0..count)
        .map(|_| {
            cursor.next_point(&mut out);
            out.clone()
        })
        .collect()
}

/// The first 32 binary digits.
fn leading(x: f64) -> u32 {
    (x * POINTS as f64) as u32
}

#[test]
fn unscrambled_points_agree_with_scipy() {
    // scipy.stats.qmc.Sobol(32, scramble=False, bits=32) of SciPy 1.17.1 gives point i ^ (i >> 1) as its i-th.
    let sobol = unscrambled(32);
    let scipy = |i: u64| -> Vec<u32> { point(&sobol, i ^ (i >> 1)).into_iter().map(leading).collect() };
    let thousandth = [
        225, 99, 531, 693, 287, 929, 47, 921, 513, 71, 87, 261, 165, 393, 147, 379, 737, 353, 1015, 743, 535, 563, 973,
        553, 597, 929, 41, 1003, 61, 349, 151, 149,
    ];
    assert_eq!(scipy(1000), thousandth.map(|x: u32| x << 22));
    let three_billionth = [
        9_313_751,
        206_004_777,
        3_953_899_511,
        1_280_606_549,
        2_532_171_339,
        2_057_589_177,
        3_942_453_765,
        3_496_341_047,
        2_506_015_463,
        2_449_807_935,
        2_908_598_875,
        596_686_715,
        1_759_334_153,
        2_656_689_653,
        1_372_678_755,
        1_119_803_815,
        205_290_789,
        3_002_993_055,
        3_132_494_017,
        1_191_084_345,
        2_037_385_631,
        1_635_394_239,
        4_161_538_079,
        1_463_884_019,
        4_211_777_659,
        905_893_461,
        3_120_874_069,
        1_752_222_743,
        3_015_793_575,
        477_903_723,
        819_378_795,
        3_671_122_593,
    ];
    assert_eq!(scipy(3_000_000_000), three_billionth);

    let mut digest = blake3::Hasher::new();
    for i in 0..4096 {
        for x in point(&sobol, i) {
            digest.update(&leading(x).to_le_bytes());
        }
    }
    assert_eq!(
        digest.finalize().to_hex().as_str(),
        "8f14a05f38f82ff5a247eaf7fdf4ddd3594584d404df9d76167d96b3343bb5e8",
        "hash of scipy's first 4096 points, put into natural order"
    );
}

#[test]
fn scrambled_points_are_pinned() {
    // Computed outside Rust: SciPy's direction numbers and a plain Python Xoshiro256++, scrambled digit by digit.
    let seed = std::array::from_fn(|i| i as u8);
    let sobol = ScrambledSobol::new(3, &mut Xoshiro256PlusPlus::from_seed(seed));
    assert_eq!(point(&sobol, 0), [0.784470376799358, 0.4151597234926113, 0.5501611498706626]);
    assert_eq!(point(&sobol, 1), [0.3741168910706981, 0.7761803873564127, 0.3842955579743569]);
    assert_eq!(point(&sobol, 1_000), [0.8483329311600295, 0.2682149172513809, 0.7551862813920195]);
    assert_eq!(point(&sobol, 4_294_967_295), [0.02065276539509775, 0.41515972328989215, 0.9449206305188534]);
}

#[test]
fn a_point_depends_neither_on_where_a_walk_begins_nor_on_further_dimensions() {
    let sobol = scrambled(5, 1);
    let fewer = scrambled(2, 1);
    for start in [0, 1, 1023, 4095, 123_456_789, POINTS / 2 - 20, POINTS - 40] {
        for (i, walked) in (start..).zip(points(&sobol, start, 40)) {
            assert_eq!(walked, point(&sobol, i), "{i}");
            assert_eq!(walked[..2], point(&fewer, i), "{i}");
        }
    }
}

#[test]
#[should_panic(expected = "no point after 2^32")]
fn the_sequence_ends_after_2_to_the_32_points() {
    points(&scrambled(1, 1), POINTS - 1, 2);
}

#[test]
fn coordinates_stay_inside_the_unit_interval() {
    let smallest = uniform(0);
    assert_eq!(smallest, 2f64.powi(-53));
    assert_eq!(uniform(u64::MAX), 1.0 - smallest);
    assert_eq!(uniform(1 << 63), 0.5 + smallest);
}

#[test]
fn the_first_two_dimensions_are_a_net() {
    // A (0, m, 2)-net in base 2: each elementary interval of volume 2^-m holds exactly one of 2^m points.
    for m in 0..=12 {
        for (seed, start) in [(1, 0), (2, 0), (3, 5 << m)] {
            let net = points(&scrambled(2, seed), start, 1 << m);
            for split in 0..=m {
                let mut seen = vec![false; 1 << m];
                for x in &net {
                    let column = (x[0] * f64::from(1 << split)) as usize;
                    let row = (x[1] * f64::from(1 << (m - split))) as usize;
                    let interval = (column << (m - split)) | row;
                    assert!(!seen[interval], "m {m}, {split} digits of the first, seed {seed}");
                    seen[interval] = true;
                }
            }
        }
    }
}

#[test]
fn every_dimension_is_stratified() {
    for m in [1, 5, 10, 14] {
        let set = points(&scrambled(32, 4), 0, 1 << m);
        for dimension in 0..32 {
            let mut strata: Vec<usize> = set.iter().map(|x| (x[dimension] * f64::from(1 << m)) as usize).collect();
            strata.sort_unstable();
            assert!(strata.into_iter().eq(0..1 << m), "dimension {dimension}, 2^{m} points");
        }
    }
}

/// Kolmogorov-Smirnov distance from the uniform distribution, times the square root of the sample size. Above
/// 1.95 with probability 0.001.
fn distance_from_uniform(mut values: Vec<f64>) -> f64 {
    let n = values.len() as f64;
    values.sort_by(f64::total_cmp);
    let distance = values
        .iter()
        .enumerate()
        .map(|(i, u)| (u - i as f64 / n).abs().max((u - (i + 1) as f64 / n).abs()))
        .fold(0.0, f64::max);
    distance * n.sqrt()
}

#[test]
fn one_point_is_uniform_over_scramblings() {
    for index in [0, 1, 6, 1000, POINTS - 1] {
        let over: Vec<Vec<f64>> = (0..20_000).map(|seed| point(&scrambled(3, seed), index)).collect();
        for dimension in 0..3 {
            let coordinates: Vec<f64> = over.iter().map(|x| x[dimension]).collect();
            let distance = distance_from_uniform(coordinates.clone());
            assert!(distance < 1.95, "point {index}, dimension {dimension}: {distance}");
        }
    }
}

#[test]
fn digits_beyond_the_direction_numbers_are_random() {
    // The 20 digits from the 33rd on, over the points of one scrambling.
    let set = points(&scrambled(2, 5), 0, 1 << 14);
    for dimension in 0..2 {
        let tails: Vec<f64> = set.iter().map(|x| (x[dimension] * POINTS as f64).fract()).collect();
        let distance = distance_from_uniform(tails);
        assert!(distance < 1.95, "dimension {dimension}: {distance}");
    }
}

/// Root mean square, over randomisations, of the error of the mean of `integrand`, whose integral is 1; and the
/// mean error in units of its own standard error.
fn error(dimensions: usize, count: u64, integrand: impl Fn(&[f64]) -> f64) -> (f64, f64) {
    const RANDOMISATIONS: u64 = 200;
    let errors: Vec<f64> = (0..RANDOMISATIONS)
        .map(|seed| {
            let set = points(&scrambled(dimensions, 1000 + seed), 0, count);
            set.iter().map(|x| integrand(x)).sum::<f64>() / count as f64 - 1.0
        })
        .collect();
    let n = RANDOMISATIONS as f64;
    let root_mean_square = (errors.iter().map(|e| e * e).sum::<f64>() / n).sqrt();
    (root_mean_square, errors.iter().sum::<f64>() / n.sqrt() / root_mean_square)
}

#[test]
fn smooth_functions_are_integrated_faster_than_by_independent_points() {
    // A product of exponentials scaled to integral 1. One coordinate has variance (e + 1) / (2 (e - 1)) - 1.
    let e = std::f64::consts::E;
    let integrand = |x: &[f64]| x.iter().map(|u| u.exp() / (e - 1.0)).product::<f64>();
    // From 2^4 to 2^12 points, independent points would gain a factor of 2^4; at best it is about 2^12.
    for (dimensions, least_gain) in [(2, 500.0), (6, 80.0)] {
        let variance = ((e + 1.0) / (2.0 * (e - 1.0))).powi(dimensions) - 1.0;
        let mut errors = Vec::new();
        for m in [4, 8, 12] {
            let (root_mean_square, bias) = error(dimensions as usize, 1 << m, integrand);
            let independent = (variance / f64::from(1 << m)).sqrt();
            assert!(root_mean_square < 0.5 * independent, "{dimensions} dimensions, 2^{m}: {root_mean_square}");
            assert!(bias.abs() < 3.5, "{dimensions} dimensions, 2^{m} points: {bias} standard errors");
            errors.push(root_mean_square);
        }
        assert!(errors[0] > least_gain * errors[2], "{dimensions} dimensions: {errors:?}");
    }
}
