//! The mean of randomisations in groups: each search for a rare event has placed the samples of one group.
//!
//! Randomisation `r` belongs to group `r` modulo the number `G` of groups. A group has a scatter of its own, as its samples may
//! be placed better or worse. The means of the groups may differ by more than this explains, where a search missed what
//! others found. So the variance of the mean of all `N` randomisations has a component of each group, of `n` randomisations
//! with variance `s^2`, and one of what lies between the groups (random effects, by analysis of variance):
//!
//! ```text
//! V = A + b,    A = sum a,    a = n s^2 / N^2,    b = max(sum n (mean of the group - mean)^2 / (G - 1) / N - A, 0)
//! ```
//!
//! Each component is known with degrees of freedom of its own: `n - 1` and `G - 1`. Where few searches have most of the
//! variance, it is known with those of these few alone, which is what the number of Welch and Satterthwaite says (F. E.
//! Satterthwaite, Biometrics Bulletin 2 (1946) 110-114; B. L. Welch, Biometrika 34 (1947) 28-35):
//!
//! ```text
//! f = V^2 / (A^2 / f_A + b^2 / (G - 1)),    f_A = A^2 / (sum a^2 / (n + 1)) - 2,    n - 1 <= f_A <= N - G
//! ```
//!
//! With `n - 1` for `n + 1` and without the 2 it would be too small: the square of an estimated variance is too large, on
//! average by the factor `(n + 1) / (n - 1)`.

use crate::special_functions::beta::{self, student_quantile};

/// The half width of Student's interval of the mean of all randomisations.
pub(super) fn half_width(shares: &[f64], groups: usize, confidence: f64) -> f64 {
    let mean = shares.iter().sum::<f64>() / shares.len() as f64;
    if mean <= 0.0 {
        return 0.0;
    }
    // Squares of small probabilities have no digits.
    let relative: Vec<f64> = shares.iter().map(|share| share / mean).collect();
    let (variance, degrees) = variance(&relative, groups);
    if variance > 0.0 { mean * student_quantile(confidence, degrees) * variance.sqrt() } else { 0.0 }
}

/// The variance of the mean, and its degrees of freedom.
fn variance(shares: &[f64], groups: usize) -> (f64, f64) {
    // One randomisation has no scatter.
    let groups = if shares.len() < 2 * groups { 1 } else { groups };
    let all = shares.len() as f64;
    let mean = shares.iter().sum::<f64>() / all;
    let (mut within, mut squares, mut between, mut least) = (0.0, 0.0, 0.0, all);
    for (group, of_group) in means(shares, groups).into_iter().enumerate() {
        let own = || shares.iter().skip(group).step_by(groups);
        let count = own().count() as f64;
        let scatter: f64 = own().map(|share| (share - of_group) * (share - of_group)).sum();
        let component = count * (scatter / (count - 1.0)) / (all * all);
        within += component;
        squares += component * component / (count + 1.0);
        between += count * (of_group - mean) * (of_group - mean);
        least = least.min(count - 1.0);
    }
    let [of_groups, most] = [groups as f64 - 1.0, all - groups as f64];
    let excess = if groups > 1 { (between / of_groups / all - within).max(0.0) } else { 0.0 };
    let mut uncertainty = 0.0;
    if within > 0.0 {
        uncertainty += within * within / (within * within / squares - 2.0).clamp(least, most);
    }
    if excess > 0.0 {
        uncertainty += excess * excess / of_groups;
    }
    let variance = within + excess;
    (variance, variance * variance / uncertainty)
}

/// The probability that the groups of equal ones differ as much, by analysis of variance; 1 with one group.
pub(super) fn significance(shares: &[f64], groups: usize) -> f64 {
    let (count, within_degrees) = (shares.len() as f64, shares.len() as f64 - groups as f64);
    if groups < 2 || within_degrees < 1.0 {
        return 1.0;
    }
    let all = shares.iter().sum::<f64>() / count;
    let means = means(shares, groups);
    let (mut between, mut within) = (0.0, 0.0);
    for (i, share) in shares.iter().enumerate() {
        let mean = means[i % groups];
        between += (mean - all) * (mean - all);
        within += (share - mean) * (share - mean);
    }
    if between + within <= 0.0 {
        return 1.0;
    }
    // The share of the groups in the sum of squares has a beta distribution.
    let (a, b) = (0.5 * (groups as f64 - 1.0), 0.5 * within_degrees);
    beta::upper_tail(a, b, between / (between + within))
}

/// The means of the groups of randomisations.
fn means(shares: &[f64], groups: usize) -> Vec<f64> {
    let mean = |group: usize| {
        let own: Vec<f64> = shares.iter().skip(group).step_by(groups).copied().collect();
        own.iter().sum::<f64>() / own.len() as f64
    };
    (0..groups).map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::special_functions::normal;

    fn close(value: f64, expected: f64) {
        assert!((value - expected).abs() <= 1e-9 * expected, "{value} {expected}");
    }

    /// Four groups of four, by their means and deviations.
    fn grouped(means: [f64; 4], deviations: [f64; 4]) -> Vec<f64> {
        (0..16).map(|i| means[i % 4] + deviations[i % 4] * if i / 4 % 2 == 0 { 1.0 } else { -1.0 }).collect()
    }

    #[test]
    fn few_components_have_few_degrees_of_freedom() {
        // Four groups that scatter alike: all twelve.
        let (variance_of_all, degrees) = variance(&grouped([1.0; 4], [0.1; 4]), 4);
        close(variance_of_all, 0.01 * 4.0 / 3.0 / 16.0);
        close(degrees, 12.0);
        // One of them has all of the scatter: its three.
        let (of_one, degrees) = variance(&grouped([1.0; 4], [0.1, 0.0, 0.0, 0.0]), 4);
        close(of_one, variance_of_all / 4.0);
        close(degrees, 3.0);
        // Two have it, by 5 (a + a)^2 / (a^2 + a^2) - 2.
        close(variance(&grouped([1.0; 4], [0.1, 0.0, 0.1, 0.0]), 4).1, 8.0);
        // Only what lies between them scatters: the three of four groups.
        let (between, degrees) = variance(&grouped([1.0, 1.3, 0.9, 1.0], [0.0; 4]), 4);
        close(between, 0.09 / 12.0);
        close(degrees, 3.0);
        // Both: by the formula with b = 0.0075 - A, f_A = 12.
        let within = 0.01 * 4.0 / 3.0 / 16.0;
        let excess = 0.0075 - within;
        let (both, degrees) = variance(&grouped([1.0, 1.3, 0.9, 1.0], [0.1; 4]), 4);
        close(both, 0.0075);
        close(degrees, 0.0075 * 0.0075 / (within * within / 12.0 + excess * excess / 3.0));
        // One group has no other beside it.
        close(variance(&grouped([1.0; 4], [0.1; 4]), 1).1, 15.0);
    }

    #[test]
    fn groups_of_unequal_size_have_the_components_of_the_formula() {
        // With NumPy, in groups of three and two.
        let (variance, degrees) = variance(&[1.0, 1.2, 1.4, 1.3, 1.1], 2);
        close(variance, 0.005_6);
        close(degrees, 2.602_739_726_027_399);
    }

    #[test]
    fn half_widths_are_students_whatever_the_size_of_the_probability() {
        // With NumPy and SciPy: a variance of 0.275625 with 1.0293 degrees of freedom.
        let shares = [1.0, 2.0, 1.2, 2.5, 1.1, 2.2, 1.3, 2.1];
        let expected = 6.238_109_469_887_043;
        for scale in [1.0, 1e-9, 1e-90] {
            let scaled: Vec<f64> = shares.iter().map(|share| scale * share).collect();
            close(half_width(&scaled, 2, 0.95) / scale, expected);
        }
        assert_eq!([half_width(&[0.25; 8], 2, 0.95), half_width(&[0.0; 8], 2, 0.95)], [0.0; 2]);
    }

    /// Standard normal deviates.
    fn deviates() -> impl FnMut() -> f64 {
        let mut state = 77_u64;
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            normal::quantile(((state >> 11) as f64 + 0.5) / (1_u64 << 53) as f64)
        }
    }

    #[test]
    #[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
    fn intervals_hold_where_groups_differ() {
        // Standard deviations of the groups, and that of what each of them misses, of those within. With 40 000 sets in NumPy:
        // 0.973, 1.000, 0.938, 0.915 and 0.932; Student's interval of all sixteen alone has 0.95, 0.99, 0.89, 0.78 and 0.47.
        for (deviations, missed, least) in [
            ([1.0; 4], 0.0, 0.96),
            ([1.0, 0.1, 0.1, 0.1], 0.0, 0.96),
            ([1.0; 4], 0.5, 0.92),
            ([1.0; 4], 1.0, 0.90),
            ([1.0; 4], 3.0, 0.91),
        ] {
            let (mut deviate, sets) = (deviates(), 5000);
            let covered = (0..sets).filter(|_| {
                let of_groups: Vec<f64> = (0..4).map(|_| 1000.0 + missed * deviate()).collect();
                let shares: Vec<f64> = (0..16).map(|i| of_groups[i % 4] + deviations[i % 4] * deviate()).collect();
                let mean = shares.iter().sum::<f64>() / 16.0;
                (mean - 1000.0).abs() <= half_width(&shares, 4, 0.95)
            });
            let share = covered.count() as f64 / f64::from(sets);
            assert!(share > least, "{deviations:?} {missed}: {share}");
        }
    }

    #[test]
    fn groups_that_do_not_differ_are_called_different_as_often_as_the_test_says() {
        let mut deviate = deviates();
        for (groups, each) in [(2, 4), (4, 4), (4, 2)] {
            let sets = 20_000;
            let mut below = [0; 2];
            for _ in 0..sets {
                let shares: Vec<f64> = (0..groups * each).map(|_| 1.0 + 0.1 * deviate()).collect();
                let significance = significance(&shares, groups);
                below[0] += u32::from(significance < 0.05);
                below[1] += u32::from(significance < 0.5);
            }
            for (below, level) in below.into_iter().zip([0.05_f64, 0.5]) {
                let share = f64::from(below) / f64::from(sets);
                assert!(
                    (share - level).abs() < 4.5 * (level * (1.0 - level) / f64::from(sets)).sqrt(),
                    "{groups}: {share}"
                );
            }
        }
    }
}
