//! Derivatives of the probability of instability, by the score function, from the samples that estimate the
//! probability.
//!
//! The score of a sample is the derivative of the logarithm of its density. For a normal input `m (1 + s z)` it is
//!
//! ```text
//! by m (s constant):  (z + s (z^2 - 1)) / (m s) = z (1 + s z) / (m s) - 1 / m,
//! by s:               (z^2 - 1) / s
//! ```
//!
//! (R. Y. Rubinstein, A. Shapiro, Discrete Event Systems, 1993). Let `U` and `S` be the probabilities that a sample is
//! unstable and stable, and `E_U`, `E_S` the mean scores of unstable and of stable samples. The derivatives of `U` and
//! `S` are `U E_U` and `S E_S`, and for `p = U / (U + S)` the quotient rule gives
//!
//! ```text
//! dp = p (1 - p) (E_U - E_S)
//! ```
//!
//! whether or not some samples are undecided or failed. This needs no further verdicts, and no smoothness of the
//! verdict as a function of the inputs. The mean scores of `u` unstable and `s` stable samples vary independently of
//! each other and of `u`, so that the standard error is
//!
//! ```text
//! error^2 = (p (1 - p))^2 (V_U / u + V_S / s) + ((1 - 2p) (E_U - E_S))^2 p (1 - p) / (u + s)
//! ```
//!
//! with the variances `V` of the scores. The mean scores do not depend on when a cell stops that is sampled
//! sequentially either: with the unbiased `p` of [`Looks`](crate::estimate::looks::Looks) the derivative is as good as
//! `p (1 - p)`.
//!
//! Sums are kept in integers, so that the order of the samples has no effect. The summands are the scores times `m s`
//! or `s`, which are of the order of 1 however small the standard deviation.

use stickslip_core::model::verdict::{Verdict, VerdictCounts};

use crate::inputs::PairParameter;
use crate::integrate::NormalPair;

/// Sums are kept in multiples of 2^-20: rounding changes each term by less than a millionth.
const STEPS_PER_ONE: f64 = (1_u64 << 20) as f64;

/// Fewest unstable and fewest stable samples for a derivative: fewer do not show the error of their mean score.
const LEAST_SAMPLES: u64 = 30;

/// Largest magnitude of a term; larger ones are clamped. A deviate of 10 stays below for relative standard deviations
/// up to 9. A square is then at most 2^40 multiples, and 2^22 of them fit in 64 bits.
const LARGEST: f64 = 1024.0;

/// The factor of the score by a parameter in the sums; 0 for an input without scatter.
fn scale(parameter: PairParameter, inputs: &NormalPair) -> f64 {
    match parameter {
        PairParameter::Expected(input) => inputs.spread(input),
        PairParameter::RelativeStd(input) if inputs.expected[input] != 0.0 => inputs.relative_std[input],
        PairParameter::RelativeStd(_) | PairParameter::Correlation => 0.0,
    }
}

/// The scores by [`PairParameter::DIFFERENTIATED`], each times its [`scale`], of a sample with these deviates; `None`
/// stands for an input without scatter.
fn scaled_scores(inputs: &NormalPair, z: [Option<f64>; 2]) -> [f64; 4] {
    let terms = |input: usize| {
        let second = z[input].map_or(0.0, |z| z * z - 1.0);
        [z[input].unwrap_or(0.0) + inputs.relative_std[input] * second, second]
    };
    let [a, b] = [terms(0), terms(1)];
    [a[0], b[0], a[1], b[1]]
}

/// Sums over some samples of one verdict.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Moments<T> {
    /// Sums of the scores times their scale, in multiples of 2^-20.
    sums: [T; 4],
    /// Sums of their squares, in the same multiples.
    squares: [T; 4],
}

/// Sums of scores over up to 2^22 samples of one cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ScoreSums {
    unstable: Moments<i64>,
    stable: Moments<i64>,
}

impl ScoreSums {
    /// How many sums there are.
    pub const COUNT: usize = 16;

    /// Adds a sample with these standard normal deviates, `None` for an input without scatter. Undecided and failed
    /// samples add nothing.
    #[inline]
    pub fn add(&mut self, inputs: &NormalPair, z: [Option<f64>; 2], verdict: Verdict) {
        let moments = match verdict {
            Verdict::Unstable => &mut self.unstable,
            Verdict::Stable => &mut self.stable,
            Verdict::Undecided | Verdict::Failed => return,
        };
        for (i, score) in scaled_scores(inputs, z).into_iter().enumerate() {
            let score = score.clamp(-LARGEST, LARGEST);
            // A conversion to an integer makes 0 of NaN.
            moments.sums[i] = moments.sums[i].saturating_add((score * STEPS_PER_ONE).round() as i64);
            moments.squares[i] = moments.squares[i].saturating_add((score * score * STEPS_PER_ONE).round() as i64);
        }
    }

    /// Whether these can be the sums of so many unstable and so many stable samples.
    #[must_use]
    pub fn can_be(sums: &[i64], unstable: u64, stable: u64) -> bool {
        let largest = (LARGEST * STEPS_PER_ONE) as i128;
        let of = |sums: &[i64], samples: u64| {
            let (sums, squares) = sums.split_at(4);
            let most = largest * i128::from(samples);
            sums.iter().all(|&sum| i128::from(sum).abs() <= most)
                && squares.iter().all(|&square| (0..=most * LARGEST as i128).contains(&square.into()))
        };
        sums.len() == Self::COUNT && of(&sums[..8], unstable) && of(&sums[8..], stable)
    }

    /// All sums, as [`ScoreTotals::from_sums`] takes them.
    pub fn sums(&self) -> impl Iterator<Item = i64> {
        let Self { unstable, stable } = *self;
        [unstable.sums, unstable.squares, stable.sums, stable.squares].into_iter().flatten()
    }
}

/// Sums of scores over all samples of one cell, in 128 bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ScoreTotals {
    unstable: Moments<i128>,
    stable: Moments<i128>,
}

impl ScoreTotals {
    /// From the totals of the sums of [`ScoreSums::sums`].
    #[must_use]
    pub fn from_sums(sums: &[i128; ScoreSums::COUNT]) -> Self {
        let part = |from: usize| std::array::from_fn(|i| sums[from + i]);
        Self {
            unstable: Moments { sums: part(0), squares: part(4) },
            stable: Moments { sums: part(8), squares: part(12) },
        }
    }

    /// The derivative of `P(unstable | decided)` by a parameter of the inputs, and its standard error. `counts` are those
    /// of the samples that were added, `probability` the estimate from them.
    ///
    /// `None` for an input without scatter, for the correlation, and where fewer than 30 samples are unstable or fewer
    /// than 30 stable: a derivative of 0 +- 0 would claim that the probability does not change.
    #[must_use]
    pub fn derivative(
        &self,
        parameter: PairParameter,
        inputs: &NormalPair,
        counts: &VerdictCounts,
        probability: f64,
    ) -> Option<(f64, f64)> {
        let (place, scale) = (parameter.place()?, scale(parameter, inputs));
        if scale == 0.0 || counts.unstable.min(counts.stable) < LEAST_SAMPLES {
            return None;
        }
        let (unstable, variance_unstable) = self.unstable.mean(place, counts.unstable);
        let (stable, variance_stable) = self.stable.mean(place, counts.stable);
        let spread = probability * (1.0 - probability);
        let slope = unstable - stable;
        let by_scores = spread * spread * (variance_unstable + variance_stable);
        let by_share = (1.0 - 2.0 * probability) * slope;
        let variance = by_scores + by_share * by_share * spread / counts.decided() as f64;
        Some((spread * slope / scale, variance.sqrt() / scale.abs()))
    }
}

impl Moments<i128> {
    /// The mean of `count` scores by one parameter, and its variance.
    fn mean(&self, place: usize, count: u64) -> (f64, f64) {
        let samples = count as f64;
        let mean = self.sums[place] as f64 / STEPS_PER_ONE / samples;
        let mean_square = self.squares[place] as f64 / STEPS_PER_ONE / samples;
        (mean, (mean_square - mean * mean).max(0.0) / (samples - 1.0))
    }
}

#[cfg(test)]
mod tests;
