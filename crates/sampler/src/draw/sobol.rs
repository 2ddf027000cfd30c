//! Scrambled Sobol points: evenly spread over the unit cube, yet each of them random and uniform.
//!
//! Point `i` of a Sobol sequence is `x_i = V b(i)` in arithmetic modulo 2, where `b(i)` are the binary digits of `i`
//! and the columns of `V`, one matrix per dimension, are the direction numbers of Joe and Kuo, file
//! `new-joe-kuo-6.21201` (S. Joe, F. Y. Kuo, Constructing Sobol sequences with better two-dimensional projections,
//! SIAM J. Sci. Comput. 30 (2008) 2635-2654). The first 2^k points, and each later 2^k that start at a multiple of
//! 2^k, fall evenly into the boxes of a digital net.
//!
//! Scrambling replaces `V` by `L V` and adds a random digital shift `e`: `x_i = L V b(i) + e`, with `L` lower
//! triangular, ones on its diagonal and random digits below (J. Matousek, On the L2-discrepancy for anchored boxes,
//! J. Complexity 14 (1998) 527-556). The points stay a net of the same quality, each is uniform, and so the mean of
//! a function over them is an unbiased estimate of its integral, whose error independent scramblings reveal. `L` has
//! more rows than `V`: digits beyond the 32 of the direction numbers are random too.

use rand::Rng;
use rand_xoshiro::Xoshiro256PlusPlus;

/// Dimensions that have direction numbers.
pub const MAX_DIMENSIONS: usize = 32;

/// Binary digits of an index, and of the direction numbers.
const INDEX_BITS: usize = 32;

/// Points of a sequence: indices are below 2^32.
pub const POINTS: u64 = 1 << INDEX_BITS;

/// Per dimension from the second on, the inner coefficients of the primitive polynomial (the highest in the highest
/// bit) and the initial direction numbers `m_1, m_2, ...`, as many as the polynomial's degree.
const JOE_KUO: [(u32, &[u32]); MAX_DIMENSIONS - 1] = [
    (0, &[1]),
    (1, &[1, 3]),
    (1, &[1, 3, 1]),
    (2, &[1, 1, 1]),
    (1, &[1, 1, 3, 3]),
    (4, &[1, 3, 5, 13]),
    (2, &[1, 1, 5, 5, 17]),
    (4, &[1, 1, 5, 5, 5]),
    (7, &[1, 1, 7, 11, 19]),
    (11, &[1, 1, 5, 1, 1]),
    (13, &[1, 1, 1, 3, 11]),
    (14, &[1, 3, 5, 5, 31]),
    (1, &[1, 3, 3, 9, 7, 49]),
    (13, &[1, 1, 1, 15, 21, 21]),
    (16, &[1, 3, 1, 13, 27, 49]),
    (19, &[1, 1, 1, 15, 7, 5]),
    (22, &[1, 3, 1, 15, 13, 25]),
    (25, &[1, 1, 5, 5, 19, 61]),
    (1, &[1, 3, 7, 11, 23, 15, 103]),
    (4, &[1, 3, 7, 13, 13, 15, 69]),
    (7, &[1, 1, 3, 13, 7, 35, 63]),
    (8, &[1, 3, 5, 9, 1, 25, 53]),
    (14, &[1, 3, 1, 13, 9, 35, 107]),
    (19, &[1, 3, 1, 5, 27, 61, 31]),
    (21, &[1, 1, 5, 11, 19, 41, 61]),
    (28, &[1, 3, 5, 3, 3, 13, 69]),
    (31, &[1, 1, 7, 13, 1, 19, 1]),
    (32, &[1, 3, 7, 5, 13, 19, 59]),
    (37, &[1, 1, 3, 9, 25, 29, 41]),
    (41, &[1, 3, 5, 13, 23, 1, 55]),
    (42, &[1, 3, 7, 3, 13, 59, 17]),
];

/// The columns of `V` of one dimension, first digit in the highest bit.
///
/// Column `k` is `m_k 2^(32-k)`; beyond the initial ones, `m_k` follows from the recurrence of the polynomial
/// `x^s + a_1 x^(s-1) + ... + a_(s-1) x + 1`: `m_k = 2 a_1 m_(k-1) ^ ... ^ 2^s m_(k-s) ^ m_(k-s)`.
fn direction_numbers(dimension: usize) -> [u32; INDEX_BITS] {
    let mut columns = [0; INDEX_BITS];
    let Some((coefficients, initial)) = dimension.checked_sub(1).map(|row| JOE_KUO[row]) else {
        // The first dimension mirrors the digits of the index (van der Corput).
        return std::array::from_fn(|k| 1 << (INDEX_BITS - 1 - k));
    };
    let degree = initial.len();
    for k in 0..INDEX_BITS {
        columns[k] = if k < degree {
            initial[k] << (INDEX_BITS - 1 - k)
        } else {
            let mut column = columns[k - degree] ^ (columns[k - degree] >> degree);
            for i in 1..degree {
                if coefficients >> (degree - 1 - i) & 1 == 1 {
                    column ^= columns[k - i];
                }
            }
            column
        };
    }
    columns
}

/// `L` and `e` of one dimension, digits of each column from the highest bit down.
struct Scramble {
    columns: [u64; INDEX_BITS],
    shift: u64,
}

impl Scramble {
    fn random(generator: &mut Xoshiro256PlusPlus) -> Self {
        let columns = std::array::from_fn(|k| {
            let diagonal = 1 << (u64::BITS as usize - 1 - k);
            diagonal | (generator.next_u64() & (diagonal - 1))
        });
        Self { columns, shift: generator.next_u64() }
    }

    /// `L v`.
    fn apply(&self, direction_number: u32) -> u64 {
        (0..INDEX_BITS)
            .filter(|k| direction_number >> (INDEX_BITS - 1 - k) & 1 == 1)
            .fold(0, |sum, k| sum ^ self.columns[k])
    }
}

/// A Sobol sequence in one random scrambling.
///
/// Each coordinate of a point is an odd multiple of 2^-53 with 52 random digits, hence inside (0, 1) and as likely as
/// its distance from 1. Point `i` is a pure function of the scrambling and `i`, and its coordinates do not depend on
/// how many others there are.
///
/// ```
/// use stickslip_sampler::draw::identity::{Purpose, block_generator};
/// use stickslip_sampler::draw::sobol::ScrambledSobol;
/// let sobol = ScrambledSobol::new(2, &mut block_generator(2018, Purpose::Scrambling, 0, 0));
/// let mut cursor = sobol.cursor(0);
/// let mut point = [0.0; 2];
/// let mut sum = 0.0;
/// for _ in 0..1024 {
///     cursor.next_point(&mut point);
///     sum += point[0] * point[1];
/// }
/// assert!((sum / 1024.0 - 0.25).abs() < 1e-3);
/// ```
#[derive(Debug, Clone)]
pub struct ScrambledSobol {
    dimensions: usize,
    /// Row `t` holds, for each dimension, the sum modulo 2 of columns 0 to `t` of `L V`: what changes from one point
    /// to the next when `t` digits of the index carry. These rows are also the direction numbers of the points in
    /// Gray code, so that point `i` is the sum of the rows at the set bits of `i ^ (i >> 1)`.
    carries: Vec<u64>,
    /// Point 0.
    shift: Vec<u64>,
}

impl ScrambledSobol {
    /// A sequence in `dimensions` dimensions, in a scrambling that `generator` draws: 33 words per dimension.
    ///
    /// # Panics
    /// Unless `1 <= dimensions <= MAX_DIMENSIONS`.
    #[must_use]
    pub fn new(dimensions: usize, generator: &mut Xoshiro256PlusPlus) -> Self {
        Self::with_scrambles(dimensions, || Scramble::random(generator))
    }

    fn with_scrambles(dimensions: usize, mut scramble: impl FnMut() -> Scramble) -> Self {
        assert!((1..=MAX_DIMENSIONS).contains(&dimensions), "{dimensions} dimensions; 1 to {MAX_DIMENSIONS} are known");
        let mut carries = vec![0; INDEX_BITS * dimensions];
        let mut shift = Vec::with_capacity(dimensions);
        for dimension in 0..dimensions {
            let scramble = scramble();
            shift.push(scramble.shift);
            let mut sum = 0;
            for (k, direction_number) in direction_numbers(dimension).into_iter().enumerate() {
                sum ^= scramble.apply(direction_number);
                carries[k * dimensions + dimension] = sum;
            }
        }
        Self { dimensions, carries, shift }
    }

    /// The coordinates of a point.
    #[must_use]
    pub fn dimensions(&self) -> usize {
        self.dimensions
    }

    /// Writes point `index` to `out`, one coordinate per dimension.
    ///
    /// # Panics
    /// If `index` is not below [`POINTS`], or `out` not as long as there are dimensions.
    pub fn point(&self, index: u64, out: &mut [f64]) {
        assert_eq!(out.len(), self.dimensions, "coordinates of a point");
        for (out, digits) in out.iter_mut().zip(self.digits(index)) {
            *out = uniform(digits);
        }
    }

    /// Walks the points from `index` on, in order and faster than by [`ScrambledSobol::point`].
    ///
    /// # Panics
    /// If `index` is not below [`POINTS`].
    #[must_use]
    pub fn cursor(&self, index: u64) -> SobolCursor<'_> {
        SobolCursor { sobol: self, index, digits: self.digits(index) }
    }

    /// The digits of point `index`; none beyond the dimensions.
    fn digits(&self, index: u64) -> [u64; MAX_DIMENSIONS] {
        assert!(index < POINTS, "point {index} of a sequence of 2^32");
        let mut digits = [0; MAX_DIMENSIONS];
        digits[..self.dimensions].copy_from_slice(&self.shift);
        let mut gray = index ^ (index >> 1);
        while gray != 0 {
            for (digits, carry) in digits.iter_mut().zip(self.carry(gray.trailing_zeros() as usize)) {
                *digits ^= carry;
            }
            gray &= gray - 1;
        }
        digits
    }

    #[inline]
    fn carry(&self, carried: usize) -> &[u64] {
        &self.carries[carried * self.dimensions..][..self.dimensions]
    }
}

/// The middle of the interval that the first 52 digits leave. With 53 of them it could round to 1.
#[inline]
fn uniform(digits: u64) -> f64 {
    const WIDTH: f64 = 1.0 / (1_u64 << 52) as f64;
    ((digits >> 12) as f64 + 0.5) * WIDTH
}

/// Consecutive points of a [`ScrambledSobol`].
#[derive(Debug, Clone)]
pub struct SobolCursor<'a> {
    sobol: &'a ScrambledSobol,
    /// Of the next point.
    index: u64,
    digits: [u64; MAX_DIMENSIONS],
}

impl SobolCursor<'_> {
    /// Writes the next point to `out`, one coordinate per dimension.
    ///
    /// # Panics
    /// After the last point of the sequence, or if `out` is not as long as there are dimensions.
    #[inline]
    pub fn next_point(&mut self, out: &mut [f64]) {
        assert!(self.index < POINTS, "no point after 2^32");
        // After the last point any row will do.
        let carried = (self.index.trailing_ones() as usize).min(INDEX_BITS - 1);
        let row = self.sobol.carry(carried);
        assert_eq!(out.len(), row.len(), "coordinates of a point");
        // One loop, so that digits are read as wide as they were written and need not wait for each other.
        for ((out, digits), carry) in out.iter_mut().zip(&mut self.digits).zip(row) {
            *out = uniform(*digits);
            *digits ^= carry;
        }
        self.index += 1;
    }
}

#[cfg(test)]
mod tests {
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
        let mut out = vec![0.0; sobol.dimensions()];
        sobol.point(index, &mut out);
        out
    }

    fn points(sobol: &ScrambledSobol, start: u64, count: u64) -> Vec<Vec<f64>> {
        let mut cursor = sobol.cursor(start);
        let mut out = vec![0.0; sobol.dimensions()];
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
            225, 99, 531, 693, 287, 929, 47, 921, 513, 71, 87, 261, 165, 393, 147, 379, 737, 353, 1015, 743, 535, 563,
            973, 553, 597, 929, 41, 1003, 61, 349, 151, 149,
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
    fn a_point_depends_neither_on_the_way_to_it_nor_on_further_dimensions() {
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
    fn a_sequence_ends() {
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
}
