//! Whether the model explains the tests.

use stickslip_core::model::pair_boundary::PairBoundary;

use super::data::{Onset, TestData};
use super::likelihood::FitModel;
use super::parameter::FitValues;
use crate::special_functions::{chi_squared, normal};

/// Tests of a group that are expected to squeal, and not to, at least.
const LEAST_EXPECTED: f64 = 5.0;

/// Degrees of freedom from which on the chi-squared distribution is approximated.
const MANY_DEGREES: usize = 200;

/// Terms of Kolmogorov's series.
const TERMS: i32 = 100;

/// How far the tests are from what the model with the estimates expects.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Goodness {
    /// Of verdicts: the deviance of groups of conditions, those with about the same probability of squeal together so that
    /// at least five tests are expected to squeal and five not to, against the model that has a probability for each group,
    ///
    /// ```text
    /// D = 2 sum (s ln(s / e) + q ln(q / (n - e)))
    /// ```
    ///
    /// with `s` squealing and `q` quiet tests of `n`, of which `e` are expected to squeal. It is about chi-squared with as
    /// many degrees of freedom as there are more groups than estimated parameters (P. McCullagh, J. A. Nelder, Generalized
    /// Linear Models, 1989, chapter 4).
    Verdicts {
        /// The deviance.
        deviance: f64,
        /// Its degrees of freedom, at least one.
        degrees: usize,
        /// The probability of a deviance as large.
        p_value: f64,
    },
    /// Of onset speeds: the largest distance between the shares of brakes that began to squeal above a speed and the
    /// probabilities (Kolmogorov and Smirnov; M. A. Stephens, J. R. Stat. Soc. B 32 (1970) 115-122). As parameters are
    /// estimated from the same speeds, it is too small rather than too large. Where tests ended without squeal, the shares
    /// are those of Kaplan and Meier, and each distance is weighted (W. J. Hall, J. A. Wellner, Biometrika 67 (1980)
    /// 133-143):
    ///
    /// ```text
    /// D = max |F - p| / ((1 + C) (1 - F)),      C = sum over onsets so far of n / (m (m - 1))
    /// ```
    ///
    /// with the share `F`, the probability `p`, `n` tests, and `m` of them that went on until the onset. Without such tests
    /// all weights are 1.
    Onsets {
        /// The distance.
        distance: f64,
        /// The probability of a distance as large, if nothing were estimated.
        p_value: f64,
    },
}

impl Goodness {
    /// The probability that tests of such brakes are as far from the model.
    #[must_use]
    pub fn p_value(&self) -> f64 {
        match *self {
            Self::Verdicts { p_value, .. } | Self::Onsets { p_value, .. } => p_value,
        }
    }
}

/// How well values explain tests; nothing of verdicts that have no more groups than there are estimated parameters.
pub(super) fn goodness(model: &FitModel, data: &TestData, values: &FitValues, estimated: usize) -> Vec<Goodness> {
    let mut conditions: Vec<[f64; 3]> = Vec::new();
    for verdicts in data.verdicts.iter().filter(|verdicts| !verdicts.are_censored) {
        let [p, _] = model.probabilities(values, verdicts.nominal, &verdicts.boundary);
        conditions.push([p, verdicts.squealed, verdicts.quiet]);
    }
    conditions.sort_by(|a, b| a[0].total_cmp(&b[0]));
    // Expected to squeal, expected to be quiet, squealed, quiet.
    let mut groups: Vec<[f64; 4]> = Vec::new();
    for [p, squealed, quiet] in conditions {
        let tests = squealed + quiet;
        let more = [tests * p, tests * (1.0 - p), squealed, quiet];
        let is_full = |group: &[f64; 4]| group[0] >= LEAST_EXPECTED && group[1] >= LEAST_EXPECTED;
        match groups.last_mut().filter(|group| !is_full(group)) {
            Some(group) => (0..4).for_each(|i| group[i] += more[i]),
            None => groups.push(more),
        }
    }
    if let [.., _, last] = groups[..]
        && (last[0] < LEAST_EXPECTED || last[1] < LEAST_EXPECTED)
    {
        groups.pop();
        let group = groups.last_mut();
        group.into_iter().for_each(|group| (0..4).for_each(|i| group[i] += last[i]));
    }
    let mut found = Vec::new();
    if groups.len() > estimated {
        let term = |observed: f64, expected: f64| {
            if observed > 0.0 { observed * libm::log(observed / expected.max(f64::MIN_POSITIVE)) } else { 0.0 }
        };
        let deviance = 2.0 * groups.iter().map(|&[e, f, s, q]| term(s, e) + term(q, f)).sum::<f64>();
        let degrees = groups.len() - estimated;
        found.push(Goodness::Verdicts { deviance, degrees, p_value: chi_squared_tail(deviance, degrees) });
    }
    if !data.onsets.is_empty() {
        let above = |nominal: f64, boundary: &PairBoundary| model.probabilities(values, nominal, boundary)[0];
        let onset = |onset: &Onset| (above(onset.nominal, &onset.boundaries[0]), false);
        let mut ends: Vec<(f64, bool)> = data.onsets.iter().map(onset).collect();
        for verdicts in data.verdicts.iter().filter(|verdicts| verdicts.are_censored) {
            let end = (above(verdicts.nominal, &verdicts.boundary), true);
            ends.extend(std::iter::repeat_n(end, verdicts.quiet as usize));
        }
        ends.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let distance = onset_distance(&ends);
        found.push(Goodness::Onsets { distance, p_value: kolmogorov_tail(distance, ends.len() as f64) });
    }
    found
}

/// The largest weighted distance of tests, in the order of the probabilities at which they ended; those without an onset
/// are marked.
fn onset_distance(ends: &[(f64, bool)]) -> f64 {
    let count = ends.len() as f64;
    let (mut quiet, mut sum, mut weight, mut distance) = (1.0, 0.0, 1.0, 0.0_f64);
    for (before, &(p, is_censored)) in ends.iter().enumerate() {
        if is_censored {
            continue;
        }
        let left = count - before as f64;
        distance = distance.max(weight * (p - (1.0 - quiet)).abs());
        quiet *= (left - 1.0) / left;
        // The last test of all leaves none whose share could be weighted.
        if left > 1.0 {
            sum += count / (left * (left - 1.0));
            weight = 1.0 / ((1.0 + sum) * quiet);
        }
        distance = distance.max(weight * (p - (1.0 - quiet)).abs());
    }
    distance
}

/// The upper tail of the chi-squared distribution, for many degrees of freedom by E. B. Wilson and M. M. Hilferty, PNAS 17
/// (1931) 684-688.
fn chi_squared_tail(value: f64, degrees: usize) -> f64 {
    let value = value.max(0.0);
    if degrees > MANY_DEGREES {
        let spread = 2.0 / (9.0 * degrees as f64);
        return normal::upper_tail((libm::cbrt(value / degrees as f64) - (1.0 - spread)) / spread.sqrt());
    }
    chi_squared::upper_tail(value, degrees)
}

/// The upper tail of the largest distance of so many.
fn kolmogorov_tail(distance: f64, count: f64) -> f64 {
    let root = count.sqrt();
    let scaled = (root + 0.12 + 0.11 / root) * distance;
    if scaled < 0.2 {
        return 1.0;
    }
    let term = |k: i32| {
        let sign = if k % 2 == 1 { 2.0 } else { -2.0 };
        sign * libm::exp(-2.0 * f64::from(k * k) * scaled * scaled)
    };
    (1..=TERMS).map(term).sum::<f64>().clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tails_of_many_are_approximated() {
        let [exact, approximate] = [200, 201].map(|degrees| chi_squared_tail(230.0, degrees));
        assert!((exact - approximate).abs() < 0.01 && exact < approximate, "{exact} {approximate}");
        // kstwobign.sf(1.358) = 0.0500, of many samples.
        assert!((kolmogorov_tail(1.358 / 1e3, 1e6) - 0.05).abs() < 2e-4);
        assert!(kolmogorov_tail(0.01, 10.0) > 0.9999);
    }

    #[test]
    fn the_distance_of_shares_is_that_of_kolmogorov_unless_tests_ended_early() {
        // By hand: three of five up to 0.4.
        let all = [0.1, 0.35, 0.4, 0.7, 0.95].map(|p| (p, false));
        assert!((onset_distance(&all) - 0.2).abs() < 1e-12, "{}", onset_distance(&all));
        // Two of four that ended at 0.5 without an onset: 1/4 at 0.2 and 1/2 at 0.45, all weights 1.
        let half = [(0.2, false), (0.45, false), (0.5, true), (0.5, true)];
        assert!((onset_distance(&half) - 0.2).abs() < 1e-12);
        // One that ended before the others: by hand, C = 3 / (2 * 1), weight 1 / (2.5 * 0.5) after the first onset.
        let early = [(0.1, true), (0.6, false), (0.9, false)];
        assert!((onset_distance(&early) - 0.6).abs() < 1e-12);
        let late = [(0.1, true), (0.2, false), (0.9, false)];
        assert!((onset_distance(&late) - 0.8 * 0.4).abs() < 1e-12, "{}", onset_distance(&late));
    }
}
