//! What tests show by themselves, without a model: the shares of brakes that squealed.

use crate::estimate::interval::{BinomialInterval, IntervalKind};

/// Most groups in which tests with verdicts are shown.
const MOST_GROUPS: usize = 12;

/// Tests with verdicts at one speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Verdicts {
    /// The speed.
    pub speed: f64,
    /// How many squealed.
    pub squealed: u64,
    /// How many there were.
    pub tests: u64,
}

/// The share of a group of tests that squealed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Share {
    /// The mean speed of the group.
    pub speed: f64,
    /// The share.
    pub share: f64,
    /// The lower end of its interval by Clopper and Pearson ([`BinomialInterval`]).
    pub low: f64,
    /// The upper end.
    pub high: f64,
}

/// The shares of tests that squealed, by speed. Each speed is a group of its own; of more than twelve speeds, neighbours
/// are put together until each group has a twelfth of the tests.
#[must_use]
pub fn of_verdicts(verdicts: &[Verdicts], confidence: f64) -> Vec<Share> {
    let mut sorted = verdicts.to_vec();
    sorted.sort_by(|a, b| a.speed.total_cmp(&b.speed));
    let mut speeds: Vec<Verdicts> = Vec::new();
    for one in sorted {
        match speeds.last_mut().filter(|last| last.speed == one.speed) {
            Some(last) => {
                *last = Verdicts { squealed: last.squealed + one.squealed, tests: last.tests + one.tests, ..*last }
            }
            None => speeds.push(one),
        }
    }
    let all: u64 = speeds.iter().map(|one| one.tests).sum();
    let least = if speeds.len() > MOST_GROUPS { all.div_ceil(MOST_GROUPS as u64) } else { 1 };
    let interval = BinomialInterval::new(IntervalKind::ClopperPearson, confidence);
    let mut shares = Vec::new();
    let (mut squealed, mut tests, mut sum) = (0, 0, 0.0);
    let count = speeds.len();
    for (number, one) in (1..).zip(speeds) {
        squealed += one.squealed;
        tests += one.tests;
        sum += one.speed * one.tests as f64;
        if tests >= least || number == count && tests > 0 {
            let (low, high) = interval.bounds(squealed, tests);
            shares.push(Share { speed: sum / tests as f64, share: squealed as f64 / tests as f64, low, high });
            (squealed, tests, sum) = (0, 0, 0.0);
        }
    }
    shares
}

/// The share of brakes that squeal at a speed or above it, from onset speeds while the speed was lowered: each speed at
/// which the share rises, from the highest down, with the share from there on. Tests in which the brake never squealed
/// (`true`) count as long as their speeds go (E. L. Kaplan, P. Meier, J. Am. Stat. Assoc. 53 (1958) 457-481):
///
/// ```text
/// 1 - product over onset speeds v_i >= v of (1 - d_i / n_i)
/// ```
///
/// with the number `d_i` of brakes that began to squeal at `v_i`, and `n_i` that were brought to it without squeal before.
#[must_use]
pub fn of_onsets(tests: &[(f64, bool)]) -> Vec<(f64, f64)> {
    let mut sorted = tests.to_vec();
    // At the same speed an onset comes before a test that ends there without one.
    sorted.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut steps: Vec<(f64, f64)> = Vec::new();
    let mut quiet = 1.0;
    for (before, &(speed, is_censored)) in sorted.iter().enumerate() {
        if is_censored {
            continue;
        }
        let left = (sorted.len() - before) as f64;
        quiet *= (left - 1.0) / left;
        match steps.last_mut().filter(|last| last.0 == speed) {
            Some(last) => last.1 = 1.0 - quiet,
            None => steps.push((speed, 1.0 - quiet)),
        }
    }
    steps
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(speed: f64, squealed: u64, tests: u64) -> Verdicts {
        Verdicts { speed, squealed, tests }
    }

    #[test]
    fn each_of_few_speeds_has_its_share() {
        let shares = of_verdicts(&[at(14.0, 30, 33), at(13.0, 81, 263), at(14.0, 0, 7)], 0.95);
        assert_eq!(shares.len(), 2);
        // R. G. Newcombe, Stat. Med. 17 (1998) 857-872, table I, method 5.
        let Share { speed, share, low, high } = shares[0];
        assert_eq!((speed, share), (13.0, 81.0 / 263.0));
        assert!((low - 0.2527).abs() < 5e-5 && (high - 0.3676).abs() < 5e-5, "{low} {high}");
        assert_eq!((shares[1].speed, shares[1].share), (14.0, 0.75));
        assert!(of_verdicts(&[], 0.95).is_empty());
    }

    #[test]
    fn many_speeds_are_put_together_without_losing_a_test() {
        let all: Vec<Verdicts> = (0..100).map(|i| at(20.0 - 0.1 * f64::from(i), u64::from(i >= 50), 1)).collect();
        let shares = of_verdicts(&all, 0.95);
        assert!((6..=12).contains(&shares.len()), "{}", shares.len());
        assert!(shares.windows(2).all(|pair| pair[0].speed < pair[1].speed && pair[0].share >= pair[1].share));
        // The last group has the four that are left.
        let mean = |of: fn(&Share) -> f64| {
            let last = shares.len() - 1;
            let weight = |i: usize| if i == last { 100.0 - 9.0 * last as f64 } else { 9.0 };
            shares.iter().enumerate().map(|(i, share)| weight(i) * of(share)).sum::<f64>() / 100.0
        };
        assert!((mean(|share| share.share) - 0.5).abs() < 1e-12 && (mean(|share| share.speed) - 15.05).abs() < 1e-9);
    }

    #[test]
    fn onset_speeds_give_the_steps_of_their_distribution() {
        let plain = of_onsets(&[(12.0, false), (16.0, false), (14.0, false), (14.0, false)]);
        let expected = [(16.0, 0.25), (14.0, 0.75), (12.0, 1.0)];
        assert!(plain.iter().zip(expected).all(|(a, b)| a.0 == b.0 && (a.1 - b.1).abs() < 1e-15), "{plain:?}");
        // Remission times of 21 patients with 6-mercaptopurine (E. J. Freireich and others, Blood 21 (1963) 699-716), with
        // the survival that textbooks give, such as J. P. Klein, M. L. Moeschberger, Survival Analysis, table 4.1. A
        // speed that is lowered is a time that passes.
        let (ends, censored) = ([6, 6, 6, 7, 10, 13, 16, 22, 23], [6, 9, 10, 11, 17, 19, 20, 25, 32, 32, 34, 35]);
        let speed = |time: i32| f64::from(100 - time);
        let tests: Vec<(f64, bool)> = censored
            .iter()
            .map(|&time| (speed(time), true))
            .chain(ends.iter().map(|&time| (speed(time), false)))
            .collect();
        let steps = of_onsets(&tests);
        let survival = [0.857, 0.807, 0.753, 0.690, 0.627, 0.538, 0.448];
        for ((at, share), (time, survival)) in steps.iter().zip([6, 7, 10, 13, 16, 22, 23].into_iter().zip(survival)) {
            assert!(*at == speed(time) && (1.0 - share - survival).abs() < 5.1e-4, "{at} {share} {survival}");
        }
        assert_eq!(steps.len(), 7);
        assert!(of_onsets(&[(12.0, true)]).is_empty());
    }
}
