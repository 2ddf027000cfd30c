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

mod direction_numbers;

use rand::Rng;
use rand_xoshiro::Xoshiro256PlusPlus;

use self::direction_numbers::{INDEX_BITS, MAX_DIMENSIONS, direction_numbers};

/// Points of a sequence: indices are below 2^32.
pub const POINTS: u64 = 1 << INDEX_BITS;

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
mod tests;
