//! Whether the model explains the tests.

use super::data::TestData;
use super::likelihood::FitModel;
use super::parameter::FitValues;
use crate::special_functions::normal;

/// Tests of a group that are expected to squeal, and not to, at least.
const LEAST_EXPECTED: f64 = 5.0;

/// Degrees of freedom from which on the chi-squared distribution is approximated.
const MANY_DEGREES: usize = 200;

/// Gamma(3 / 2)
const HALF_ROOT_OF_PI: f64 = 0.5 / (std::f64::consts::FRAC_2_SQRT_PI / 2.0);

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
    /// estimated from the same speeds, it is too small rather than too large.
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
    for verdicts in &data.verdicts {
        let p = model.probability(values, verdicts.nominal, &verdicts.boundary);
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
        let above = |onset: &super::data::Onset| model.probability(values, onset.nominal, &onset.boundaries[0]);
        let mut above: Vec<f64> = data.onsets.iter().map(above).collect();
        above.sort_by(f64::total_cmp);
        let count = above.len() as f64;
        let apart = |(i, p): (usize, &f64)| (p - i as f64 / count).max((i + 1) as f64 / count - p);
        let distance = above.iter().enumerate().map(apart).fold(0.0, f64::max);
        found.push(Goodness::Onsets { distance, p_value: kolmogorov_tail(distance, count) });
    }
    found
}

/// The upper tail of the chi-squared distribution: a finite sum, or for many degrees of freedom by E. B. Wilson and M. M.
/// Hilferty, PNAS 17 (1931) 684-688.
fn chi_squared_tail(value: f64, degrees: usize) -> f64 {
    let value = value.max(0.0);
    if degrees > MANY_DEGREES {
        let spread = 2.0 / (9.0 * degrees as f64);
        return normal::upper_tail((libm::cbrt(value / degrees as f64) - (1.0 - spread)) / spread.sqrt());
    }
    let half = 0.5 * value;
    let density = libm::exp(-half);
    let (mut tail, mut term, mut of) = match degrees % 2 {
        1 => (2.0 * normal::upper_tail(value.sqrt()), density * half.sqrt() / HALF_ROOT_OF_PI, 1),
        _ => (density, density * half, 2),
    };
    // term = half^(of / 2) exp(-half) / Gamma(of / 2 + 1)
    while of < degrees {
        tail += term;
        term *= half / (0.5 * of as f64 + 1.0);
        of += 2;
    }
    tail
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
    fn tails_are_those_of_scipy() {
        // scipy 1.14: chi2.isf(tail, degrees).
        for (value, degrees, tail) in [
            (3.841_458_82, 1, 0.05),
            (5.991_464_55, 2, 0.05),
            (9.487_729_04, 4, 0.05),
            (11.070_497_69, 5, 0.05),
            (23.209_251_16, 10, 0.01),
        ] {
            assert!((chi_squared_tail(value, degrees) - tail).abs() < 1e-9, "{value} {degrees}");
        }
        let [exact, approximate] = [200, 201].map(|degrees| chi_squared_tail(230.0, degrees));
        assert!((exact - approximate).abs() < 0.01 && exact < approximate, "{exact} {approximate}");
        // kstwobign.sf(1.358) = 0.0500, of many samples.
        assert!((kolmogorov_tail(1.358 / 1e3, 1e6) - 0.05).abs() < 2e-4);
        assert!(kolmogorov_tail(0.01, 10.0) > 0.9999);
    }
}
