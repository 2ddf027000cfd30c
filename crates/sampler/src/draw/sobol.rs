//! Scrambled Sobol points: random points, each uniform over the unit cube, that together fill it evenly.
//!
//! Point `i` of a Sobol sequence is `x_i = V b(i)` in arithmetic modulo 2. `b(i)` are the binary digits of `i`, and the
//! columns of `V`, one matrix per dimension, are the direction numbers of Joe and Kuo, file `new-joe-kuo-6.21201` (S.
//! Joe, F. Y. Kuo, Constructing Sobol sequences with better two-dimensional projections, SIAM J. Sci. Comput. 30 (2008)
//! 2635-2654). The first 2^k points are a digital net, and so is each later group of 2^k that starts at a multiple of
//! 2^k.
//!
//! Scrambling replaces `V` by `L V` and adds a random digital shift `e`: `x_i = L V b(i) + e`. `L` is lower triangular
//! with ones on its diagonal and random digits below (J. Matousek, On the L2-discrepancy for anchored boxes, J.
//! Complexity 14 (1998) 527-556). The points remain a net of the same quality, and each is uniform. The mean of a
//! function over them is therefore an unbiased estimate of its integral, and independent scramblings show its error.
//! `L` has more rows than `V`: digits beyond the 32 of the direction numbers are random too.

mod direction_numbers;

use rand::Rng;
use rand_xoshiro::Xoshiro256PlusPlus;

use self::direction_numbers::{INDEX_BITS, MAX_DIMENSIONS, direction_numbers};

/// Points of a sequence; their indices are below 2^32.
pub const POINTS: u64 = 1 << INDEX_BITS;

/// `L` and `e` of one dimension, the digits of each column from the highest bit down.
struct Scramble {
    columns: [u64; INDEX_BITS],
    shift: u64,
}

impl Scramble {
    /// A random scrambling: 33 words of the generator.
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
/// Each coordinate of a point is an odd multiple of 2^-53 with 52 random digits. It lies inside (0, 1), and `x` is as
/// likely as `1 - x`. Point `i` is a pure function of the scrambling and `i`. Its coordinates do not depend on the
/// number of dimensions.
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
    /// A sequence in `dimensions` dimensions. `generator` draws the scrambling, 33 words per dimension.
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

    /// The points from `index` on, in order.
    ///
    /// # Panics
    /// If `index` is not below [`POINTS`].
    #[must_use]
    pub fn cursor(&self, index: u64) -> SobolCursor<'_> {
        SobolCursor { sobol: self, index, digits: self.digits(index) }
    }

    /// The digits of point `index`; 0 beyond the dimensions.
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

    /// The row of [`ScrambledSobol::carries`] for an index in which `carried` digits carry.
    #[inline]
    fn carry(&self, carried: usize) -> &[u64] {
        &self.carries[carried * self.dimensions..][..self.dimensions]
    }
}

/// The middle of the interval that the first 52 digits define. With 53 digits it could be rounded to 1.
#[inline]
fn uniform(digits: u64) -> f64 {
    const WIDTH: f64 = 1.0 / (1_u64 << 52) as f64;
    ((digits >> 12) as f64 + 0.5) * WIDTH
}

/// Consecutive points of a [`ScrambledSobol`].
#[derive(Debug, Clone)]
pub struct SobolCursor<'a> {
    sobol: &'a ScrambledSobol,
    /// Index of the next point.
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
        // After the last point the row does not matter.
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
