//! Sobol indices of the verdict: the shares of its variance that are due to an input.

/// Counts of verdicts on samples A, on independent samples B, and on samples A_i: A with input `i` taken from B.
///
/// A triple of A, B and A_i counts only if all three are decided. An undecided or failed sample has no verdict: to
/// count it as stable would attribute variance to the inputs that make samples fail.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct IndexCounts {
    /// Triples that are decided.
    pub samples: u64,
    /// Triples with A unstable.
    pub first_unstable: u64,
    /// Triples with B unstable.
    pub second_unstable: u64,
    /// Triples with B and A_i unstable and A stable.
    pub up: u64,
    /// Triples with B and A unstable and A_i stable.
    pub down: u64,
    /// Triples in which A and A_i differ.
    pub turned: u64,
}

impl IndexCounts {
    /// Whether these can be counts of at most so many triples.
    #[must_use]
    pub fn can_be(&self, triples: u64) -> bool {
        let Self { samples, first_unstable, second_unstable, up, down, turned } = *self;
        let both = up.saturating_add(down);
        samples <= triples
            && first_unstable.max(second_unstable).max(turned) <= samples
            && both <= second_unstable.min(turned)
    }

    /// Adds a triple: whether A, B and A_i are unstable, `None` for a sample without a verdict. Returns whether the
    /// triple counts.
    #[inline]
    pub fn add(&mut self, first: Option<bool>, second: Option<bool>, mixed: Option<bool>) -> bool {
        let (Some(a), Some(b), Some(ab)) = (first, second, mixed) else { return false };
        self.samples += 1;
        self.first_unstable += u64::from(a);
        self.second_unstable += u64::from(b);
        self.up += u64::from(b && ab && !a);
        self.down += u64::from(b && !ab && a);
        self.turned += u64::from(a != ab);
        true
    }
}

/// First-order and total index of one input, with their standard errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SobolIndices {
    /// Share of the variance that is due to this input alone.
    pub first_order: f64,
    /// Its standard error.
    pub first_order_error: f64,
    /// Share of the variance to which this input contributes, alone or in interaction with others.
    pub total: f64,
    /// Its standard error.
    pub total_error: f64,
}

/// The indices of one input; `None` where all samples have the same verdict.
///
/// With `f` = 1 for an unstable and 0 for a stable sample, and `p` its mean:
///
/// ```text
/// S_i = E[f(B) (f(A_i) - f(A))] / V,   T_i = E[(f(A) - f(A_i))^2] / 2V,   V = p (1 - p)
/// ```
///
/// (A. Saltelli et al., Comput. Phys. Commun. 181 (2010), table 2, rows b and f). Where samples are undecided or fail,
/// these are the indices of the decided samples: exactly if every single input decides by itself whether a sample is
/// left out (a stiffness below zero, for example), otherwise approximately. The standard errors include that of `V`,
/// and count one event more than was observed: an event that does not occur in `n` samples may still have a probability
/// of about `1 / n`.
#[must_use]
pub fn indices(counts: &IndexCounts) -> Option<SobolIndices> {
    let samples = counts.samples as f64;
    let p = (counts.first_unstable + counts.second_unstable) as f64 / (2.0 * samples);
    let variance = p * (1.0 - p);
    if variance.is_nan() || variance <= 0.0 {
        return None;
    }
    let share = |count: u64| count as f64 / samples;
    let error_by_variance = |index: f64| {
        // dV = (1 - 2p) dp, and p is the mean of 2n verdicts.
        index * (1.0 - 2.0 * p) / variance * (variance / (2.0 * samples)).sqrt()
    };
    let error = |second_moment: f64, mean: f64, scale: f64, index: f64| {
        let own = ((second_moment + 1.0 / samples - mean * mean).max(0.0) / samples).sqrt() * scale;
        let by_variance = error_by_variance(index);
        (own * own + by_variance * by_variance).sqrt()
    };
    let first = share(counts.up) - share(counts.down);
    let turned = share(counts.turned);
    let (first_order, total) = (first / variance, 0.5 * turned / variance);
    Some(SobolIndices {
        first_order,
        first_order_error: error(share(counts.up + counts.down), first, 1.0 / variance, first_order),
        total,
        total_error: error(turned, turned, 0.5 / variance, total),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::deviates::{DeviateStream, Points};

    /// Counts for the verdict z1 + z2 / 2 > 0.3, by input.
    fn counts(seed: u64, samples: u64) -> [IndexCounts; 2] {
        let verdict = |z: [f64; 2]| z[0] + 0.5 * z[1] > 0.3;
        let stream = |points| DeviateStream { seed, common_random_numbers: false, dimensions: 2, points };
        let first = stream(Points::Random).draw(0, 0, 0..samples);
        let second = stream(Points::SecondRandom).draw(0, 0, 0..samples);
        let mut counts = [IndexCounts::default(); 2];
        for (a, b) in first.chunks_exact(2).zip(second.chunks_exact(2)) {
            let (in_a, in_b) = (verdict([a[0], a[1]]), verdict([b[0], b[1]]));
            for (counts, mixed) in counts.iter_mut().zip([[b[0], a[1]], [a[0], b[1]]]) {
                assert!(counts.add(Some(in_a), Some(in_b), Some(verdict(mixed))));
            }
        }
        counts
    }

    #[test]
    fn indices_and_their_errors_are_right_for_a_linear_boundary() {
        // SciPy, quad over one deviate: p = P(z1 + z2 / 2 > 0.3), S_i = Var(E[f | z_i]) / p(1 - p), T_i = 1 - S_other.
        let expected = [[0.586_840_809, 0.874_327_568], [0.125_672_432, 0.413_159_191]];
        let (mut squares, mut runs) = ([[0.0; 2]; 2], 0.0);
        for seed in 0..300 {
            for ((counts, expected), squares) in counts(seed, 2000).iter().zip(expected).zip(&mut squares) {
                let indices = indices(counts).unwrap();
                squares[0] += ((indices.first_order - expected[0]) / indices.first_order_error).powi(2);
                squares[1] += ((indices.total - expected[1]) / indices.total_error).powi(2);
            }
            runs += 1.0;
        }
        // The mean square of a deviation over its standard error; errors may be a little large, not small.
        for mean in squares.into_iter().flatten().map(|sum| sum / runs) {
            assert!((0.55..1.2).contains(&mean), "{squares:?}");
        }
    }

    #[test]
    fn an_input_that_only_makes_samples_fail_has_no_index() {
        // The second input has no effect but that a quarter of its values have no verdict.
        let stream = |points| DeviateStream { seed: 4, common_random_numbers: false, dimensions: 2, points };
        let first = stream(Points::Random).draw(0, 0, 0..20_000);
        let second = stream(Points::SecondRandom).draw(0, 0, 0..20_000);
        let verdict = |z: [f64; 2]| (z[1] > -0.6745).then_some(z[0] > 0.3);
        let (mut counts, mut left_out) = ([IndexCounts::default(); 2], [0; 2]);
        for (a, b) in first.chunks_exact(2).zip(second.chunks_exact(2)) {
            for (i, mixed) in [[b[0], a[1]], [a[0], b[1]]].into_iter().enumerate() {
                let is_counted = counts[i].add(verdict([a[0], a[1]]), verdict([b[0], b[1]]), verdict(mixed));
                left_out[i] += u32::from(!is_counted);
            }
        }
        let [acts, fails] = counts.map(|counts| indices(&counts).unwrap());
        assert_eq!((fails.total, fails.first_order), (0.0, 0.0));
        assert!(fails.total_error < 1e-3, "{fails:?}");
        assert!((acts.total - 1.0).abs() < 4.0 * acts.total_error && acts.total_error < 0.02, "{acts:?}");
        assert!((acts.first_order - 1.0).abs() < 4.0 * acts.first_order_error, "{acts:?}");
        // A or B fail with probability 1 - 0.75^2, and with the input of B no sample fails that does not with its own.
        let share = left_out.map(|count| f64::from(count) / 20_000.0);
        assert!(share.iter().all(|share| (share - 0.4375).abs() < 0.02), "{share:?}");
    }

    #[test]
    fn indices_without_an_event_have_an_error() {
        let counts = IndexCounts { samples: 500, first_unstable: 497, second_unstable: 496, ..IndexCounts::default() };
        let found = indices(&counts).unwrap();
        assert_eq!((found.first_order, found.total), (0.0, 0.0));
        assert!(found.first_order_error > 0.1 && found.total_error > 0.05, "{found:?}");
        assert_eq!(indices(&IndexCounts { samples: 500, ..IndexCounts::default() }), None);
        assert_eq!(indices(&IndexCounts::default()), None);
    }
}
