//! Sobol indices of a continuous result: the shares of its variance that are due to an input.

use super::fixed_point::{add_words, can_be_sum, number};
use super::sobol_indices::SobolIndices;

/// Words of each sum, and what a sum's largest word counts: 2^120. With seven words the smallest counts 2^-90, so that
/// differences from 1e-6 to 1e9 have fourth powers with digits enough.
const WORDS: usize = 7;
const LARGEST: f64 = (1_u128 << 120) as f64;

/// Sums over triples, with `w = f(A) - f(B)`, `u = f(B) - f(A_i)` and `d = f(A) - f(A_i)`: of the squares of the three,
/// of these squares squared, and of those of `u` and `d` times that of `w`.
const MOMENTS: usize = 8;

/// Sums of the results on samples A, on independent samples B, and on samples A_i: A with input `i` taken from B.
/// They are integers, so that they do not depend on the order of adding.
///
/// A triple of A, B and A_i counts only if all three have a result.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ValueSums {
    words: [i64; MOMENTS * WORDS],
    left_out: i64,
}

impl Default for ValueSums {
    fn default() -> Self {
        Self { words: [0; MOMENTS * WORDS], left_out: 0 }
    }
}

impl ValueSums {
    /// The number of sums.
    pub const COUNT: usize = MOMENTS * WORDS + 1;

    /// Adds the results of a triple, of any unit; differences above 1e9 count as 1e9.
    pub fn add(&mut self, first: Option<f64>, second: Option<f64>, mixed: Option<f64>) {
        let finite = |value: Option<f64>| value.filter(|value| value.is_finite());
        let (Some(a), Some(b), Some(ab)) = (finite(first), finite(second), finite(mixed)) else {
            self.left_out += 1;
            return;
        };
        let square = |difference: f64| (difference * difference).min(1e18);
        let [w, u, d] = [a - b, b - ab, a - ab].map(square);
        let moments = [w, u, d, w * w, u * u, d * d, u * w, d * w];
        for (sum, moment) in self.words.chunks_exact_mut(WORDS).zip(moments) {
            add_words(sum, moment / LARGEST);
        }
    }

    /// Whether these can be the sums of so many triples, each of which adds at most 1 to the largest word.
    #[must_use]
    pub fn can_be(sums: &[i64], triples: u64) -> bool {
        let Some((&left_out, words)) = sums.split_last() else { return false };
        let Some(counted) = triples.checked_sub(left_out.cast_unsigned()) else { return false };
        sums.len() == Self::COUNT
            && words.iter().all(|word| *word >= 0)
            && words.chunks_exact(WORDS).all(|sum| can_be_sum(sum, counted as f64))
    }

    /// The sums, as they are kept.
    pub fn sums(&self) -> impl Iterator<Item = i64> + '_ {
        self.words.iter().copied().chain([self.left_out])
    }
}

/// The number of triples that totals of [`ValueSums::sums`] leave out.
#[must_use]
pub fn left_out(totals: &[i128; ValueSums::COUNT]) -> u64 {
    u64::try_from(totals[ValueSums::COUNT - 1]).unwrap_or(0)
}

/// The indices of one input from totals of [`ValueSums::sums`]; `None` where all results are the same.
///
/// ```text
/// S_i = 1 - E[(f(B) - f(A_i))^2] / 2V,   T_i = E[(f(A) - f(A_i))^2] / 2V,   2V = E[(f(A) - f(B))^2]
/// ```
///
/// (M. J. W. Jansen, Comput. Phys. Commun. 117 (1999); A. Saltelli et al., Comput. Phys. Commun. 181 (2010), table 2, rows
/// c and f.) All three are differences, so that a large mean costs no digits, an input without effect has the indices 0
/// and an input that decides alone has 1, without any error. The standard errors are those of a ratio of two means.
#[must_use]
pub fn indices(totals: &[i128; ValueSums::COUNT]) -> Option<SobolIndices> {
    let moment = |i: usize| number(&totals[i * WORDS..(i + 1) * WORDS]) * LARGEST;
    let [w, u, d, ww, uu, dd, uw, dw] = [0, 1, 2, 3, 4, 5, 6, 7].map(moment);
    if w.is_nan() || w <= 0.0 {
        return None;
    }
    // The sum of (x - r y)^2 over the square of the sum of y.
    let error = |ratio: f64, xx: f64, xw: f64| {
        let squares = xx - 2.0 * ratio * xw + ratio * ratio * ww;
        squares.max(0.0).sqrt() / w
    };
    let (other, total) = (u / w, d / w);
    Some(SobolIndices {
        first_order: 1.0 - other,
        first_order_error: error(other, uu, uw),
        total,
        total_error: error(total, dd, dw),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::deviates::{DeviateStream, Points};

    fn totals(sums: &[ValueSums]) -> [i128; ValueSums::COUNT] {
        let mut totals = [0; ValueSums::COUNT];
        for sums in sums {
            totals.iter_mut().zip(sums.sums()).for_each(|(total, sum)| *total += i128::from(sum));
        }
        totals
    }

    /// Sums for a function of three deviates, by input, in two halves.
    fn sums(seed: u64, samples: u64, f: impl Fn([f64; 3]) -> Option<f64>) -> [[ValueSums; 2]; 3] {
        let stream = |points| DeviateStream { seed, common_random_numbers: false, dimensions: 3, points };
        let first = stream(Points::Random).draw(0, 0, 0..samples);
        let second = stream(Points::SecondRandom).draw(0, 0, 0..samples);
        let mut sums = [[ValueSums::default(); 2]; 3];
        for (n, (a, b)) in first.chunks_exact(3).zip(second.chunks_exact(3)).enumerate() {
            let (a, b) = ([a[0], a[1], a[2]], [b[0], b[1], b[2]]);
            for (i, sums) in sums.iter_mut().enumerate() {
                let mut mixed = a;
                mixed[i] = b[i];
                sums[n % 2].add(f(a), f(b), f(mixed));
            }
        }
        sums
    }

    #[test]
    #[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
    fn indices_and_their_errors_are_right_whatever_the_mean_and_the_unit() {
        // f = z1 + z2 / 2 + z1 z2 / 2 has the variances 1, 1/4 and 1/4 of its parts; the third input has no effect.
        let expected = [[2.0 / 3.0, 5.0 / 6.0], [1.0 / 6.0, 1.0 / 3.0], [0.0, 0.0]];
        for (offset, scale) in [(0.0, 1.0), (2500.0, 1e-3), (-3e5, 1e4), (0.02, 1e-5)] {
            let f = |z: [f64; 3]| Some(offset + scale * (z[0] + 0.5 * z[1] + 0.5 * z[0] * z[1]));
            let (mut squares, mut runs) = ([[0.0; 2]; 2], 0.0);
            for seed in 0..200 {
                let found = sums(seed, 2000, f).map(|sums| indices(&totals(&sums)).unwrap());
                for ((indices, expected), squares) in found.iter().zip(expected).zip(&mut squares) {
                    squares[0] += ((indices.first_order - expected[0]) / indices.first_order_error).powi(2);
                    squares[1] += ((indices.total - expected[1]) / indices.total_error).powi(2);
                }
                let none = found[2];
                assert_eq!([none.first_order, none.total, none.total_error], [0.0; 3]);
                assert_eq!(none.first_order_error, 0.0);
                runs += 1.0;
            }
            // The mean square of a deviation over its standard error.
            for mean in squares.into_iter().flatten().map(|sum| sum / runs) {
                assert!((0.75..1.35).contains(&mean), "{offset} {scale}: {squares:?}");
            }
        }
    }

    #[test]
    fn sums_that_no_triples_have_are_told() {
        let [[sums, _], ..] = sums(3, 200, |z| (z[2] > -0.6745).then_some(1e9 * z[0]));
        let sound: Vec<i64> = sums.sums().collect();
        assert!(ValueSums::can_be(&sound, 100) && !ValueSums::can_be(&sound, sound[ValueSums::COUNT - 1] as u64 - 1));
        for (place, forged) in [(0, -1), (0, 1 << 40), (WORDS, 1 << 53), (ValueSums::COUNT - 1, -1), (9, -7)] {
            let mut sums = sound.clone();
            sums[place] = forged;
            assert!(!ValueSums::can_be(&sums, 100), "{place} {forged}");
        }
        assert!(!ValueSums::can_be(&sound[1..], 100) && !ValueSums::can_be(&[], 100));
    }

    #[test]
    fn an_input_that_decides_alone_has_all_of_the_variance() {
        let found = sums(7, 500, |z| Some(z[1].exp())).map(|sums| indices(&totals(&sums)).unwrap());
        assert_eq!([found[1].first_order, found[1].total], [1.0, 1.0]);
        assert_eq!([found[0].first_order, found[0].total], [0.0, 0.0]);
    }

    #[test]
    fn triples_without_a_result_are_left_out_and_counted() {
        let sums = sums(3, 1000, |z| (z[2] > -0.6745).then_some(z[0]));
        let totals = sums.map(|sums| totals(&sums));
        let found = totals.map(|totals| indices(&totals).unwrap());
        assert_eq!([found[0].first_order, found[0].total, found[2].total], [1.0, 1.0, 0.0]);
        assert!(
            totals.iter().all(|totals| (380..500).contains(&left_out(totals))),
            "{:?}",
            totals.map(|t| left_out(&t))
        );
    }

    #[test]
    fn results_that_are_all_the_same_or_not_finite_have_no_indices() {
        let mut sums = ValueSums::default();
        sums.add(Some(3.0), Some(3.0), Some(3.0));
        assert_eq!(indices(&totals(&[sums])), None);
        sums.add(Some(f64::INFINITY), Some(3.0), Some(f64::NAN));
        assert_eq!((indices(&totals(&[sums])), left_out(&totals(&[sums]))), (None, 1));
        sums.add(Some(1e300), Some(-1e300), Some(0.0));
        assert!(indices(&totals(&[sums])).is_some_and(|indices| indices.total_error.is_finite()));
    }
}
