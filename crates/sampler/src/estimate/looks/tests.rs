//! Schedules, exact sums over all stops, and simulated runs.

use super::*;
use rand::SeedableRng;
use rand_distr::{Binomial, Distribution};
use rand_xoshiro::Xoshiro256PlusPlus;

fn half_width(most: f64) -> Precision {
    Precision { half_width: Some(most), relative: None }
}

fn relative(most: f64) -> Precision {
    Precision { half_width: None, relative: Some(most) }
}

fn counts(unstable: u64, samples: u64) -> VerdictCounts {
    VerdictCounts { stable: samples - unstable, unstable, ..VerdictCounts::default() }
}

#[test]
fn looks_are_whole_blocks_that_grow_by_a_quarter_from_where_a_stop_is_possible() {
    for (precision, first) in
        [(half_width(0.01), 1000), (half_width(0.0001), 19_000), (relative(0.05), 1000), (relative(1e-4), 19_000)]
    {
        for at_most in [999, 1000, 1_000_000, 12_345_678, 1 << 40] {
            let looks = Looks::new(precision, at_most, 0.95);
            let ends = looks.ends();
            assert_eq!(ends[0], first.min(at_most));
            assert_eq!(*ends.last().unwrap(), at_most);
            assert!(ends[..ends.len() - 1].iter().all(|end| end % BLOCK_SAMPLES == 0));
            for pair in ends.windows(2) {
                assert!(pair[0] < pair[1] && pair[1] <= pair[0] + pair[0] / 4 + BLOCK_SAMPLES);
                assert!(pair[1] == at_most || 4 * pair[1] >= 5 * pair[0]);
            }
            let spent: f64 = (0..ends.len()).map(|look| looks.error_share(look)).sum();
            assert!(spent <= 1.0 + 1e-12, "{precision:?} {at_most}: {spent}");
        }
    }
    let either = Precision { half_width: Some(1e-4), relative: Some(0.05) };
    assert_eq!(Looks::new(either, u64::MAX, 0.95).ends()[0], 1000);
    assert_eq!(*Looks::new(either, u64::MAX, 0.95).ends().last().unwrap(), u64::MAX);
}

#[test]
fn a_higher_limit_changes_no_look_below_it() {
    for precision in [half_width(0.002), relative(0.1)] {
        let (short, long) = (Looks::new(precision, 31_500, 0.95), Looks::new(precision, 4_000_000, 0.95));
        let inner = short.ends().len() - 1;
        assert_eq!(short.ends()[..inner], long.ends()[..inner]);
        assert_eq!(short.intervals[..], long.intervals[..=inner], "the limit has the error of the next look");
    }
}

#[test]
fn every_probability_stops_within_the_regular_looks() {
    let looks = Looks::new(half_width(0.01), 1_000_000, 0.95);
    let last = looks.ends()[looks.regular - 1];
    assert!(looks.is_met(looks.regular - 1, last / 2, &counts(last / 2, last)));
    assert!(last < 40_000, "{last}");
    // One look alone would take 9604 samples.
    let looks = Looks::new(relative(0.1), 1_000_000_000, 0.95);
    let end = looks.ends().iter().position(|&end| end > 300_000).unwrap();
    assert!(looks.is_met(end, looks.ends()[end] / 100, &counts(0, looks.ends()[end])));
}

#[test]
fn a_look_is_enough_when_narrow_or_last() {
    let looks = Looks::new(half_width(0.02), 2000, 0.95);
    assert!(looks.is_enough(0, &counts(3, 1000)) && !looks.is_enough(0, &counts(500, 1000)));
    assert!(looks.is_enough(1, &counts(1000, 2000)));
    // Undecided samples count as width.
    let with_undecided = VerdictCounts { stable: 597, unstable: 3, undecided: 400, ..Default::default() };
    assert!(!looks.is_enough(0, &with_undecided));
    // Without unstable samples no relative precision is reached.
    let looks = Looks::new(relative(0.5), 100_000, 0.95);
    assert!(!looks.is_enough(0, &counts(0, 1000)) && looks.is_enough(0, &counts(200, 1000)));
}

/// For each count at which a cell of probability `p` without undecided samples may stop, its probability and
/// the estimate there, by convolving binomial distributions from look to look.
fn stops(looks: &Looks, p: f64) -> Vec<(f64, u64, u64, Estimate)> {
    let binomial = |n: u64| {
        let mut mass = vec![libm::exp(n as f64 * libm::log1p(-p))];
        while mass.len() as f64 <= n as f64 * p + 12.0 * (n as f64 * p).sqrt() + 20.0 {
            let k = mass.len() as f64;
            mass.push(mass[mass.len() - 1] * (n as f64 - k + 1.0) / k * p / (1.0 - p));
        }
        mass
    };
    let (mut continuing, mut found, mut before) = (vec![1.0], Vec::new(), 0);
    let mut path = Vec::new();
    for (look, &end) in looks.ends().iter().enumerate() {
        let step = binomial(end - before);
        let mut next = vec![0.0; continuing.len() + step.len()];
        for (i, a) in continuing.iter().enumerate() {
            step.iter().enumerate().for_each(|(j, b)| next[i + j] += a * b);
        }
        before = end;
        path.push(counts(0, end));
        for (k, mass) in next.iter_mut().enumerate().filter(|(_, mass)| **mass > 1e-13) {
            let here = counts(k as u64, end);
            if looks.is_enough(look, &here) {
                *path.last_mut().unwrap() = here;
                found.push((*mass, k as u64, end, looks.estimate(&path)));
                *mass = 0.0;
            }
        }
        continuing = next;
    }
    found
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn the_estimate_is_unbiased_where_the_observed_share_is_not() {
    // Exact sums over all stops.
    for (precision, p, bias_of_share) in [
        (half_width(0.002), 1e-3, -0.14),
        (half_width(0.0005), 1e-4, -0.16),
        (half_width(0.001), 5e-3, -0.002),
        (relative(0.4), 5e-3, 0.01),
    ] {
        let looks = Looks::new(precision, 60_000, 0.95);
        let stops = stops(&looks, p);
        let total: f64 = stops.iter().map(|stop| stop.0).sum();
        assert!((total - 1.0).abs() < 1e-9, "{total}");
        let mean: f64 = stops.iter().map(|(mass, .., estimate)| mass * estimate.probability.unwrap()).sum();
        let share: f64 = stops.iter().map(|(mass, k, n, _)| mass * *k as f64 / *n as f64).sum();
        assert!((mean / p - 1.0).abs() < 1e-8, "{precision:?} {p}: {}", mean / p - 1.0);
        let bias = share / p - 1.0;
        assert!(bias.abs() > f64::abs(bias_of_share) && bias * bias_of_share > 0.0, "{precision:?} {p}: {bias}");
        let inside =
            stops.iter().all(|(_, _, _, e)| e.low <= e.probability.unwrap() && e.probability.unwrap() <= e.high);
        assert!(inside, "the estimate is in its interval");
        let covered: f64 = stops.iter().filter(|(.., e)| e.low <= p && p <= e.high).map(|stop| stop.0).sum();
        assert!(covered >= 0.95, "{precision:?} {p}: {covered}");
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn undecided_samples_leave_the_estimate_unbiased() {
    // Every tenth sample is undecided, whatever its verdict would be.
    let (p, looks) = (0.002, Looks::new(half_width(0.055), 6000, 0.95));
    let mut generator = Xoshiro256PlusPlus::seed_from_u64(1946);
    let (mut sum, mut sum_of_shares, mut squares, repetitions) = (0.0, 0.0, 0.0, 20_000);
    let mut stopped_at = Vec::new();
    for _ in 0..repetitions {
        let mut path: Vec<VerdictCounts> = Vec::new();
        for (look, &end) in looks.ends().iter().enumerate() {
            let before = path.last().copied().unwrap_or_default();
            let more = end - before.total();
            let undecided = Binomial::new(more, 0.1).unwrap().sample(&mut generator);
            let unstable = Binomial::new(more - undecided, p).unwrap().sample(&mut generator);
            path.push(before + VerdictCounts { undecided, unstable, stable: more - undecided - unstable, failed: 0 });
            if looks.is_enough(look, &path[look]) {
                break;
            }
        }
        let last = path.last().unwrap();
        stopped_at.push(path.len());
        let estimate = looks.estimate(&path).probability.unwrap();
        sum += estimate;
        squares += estimate * estimate;
        sum_of_shares += last.unstable as f64 / last.decided() as f64;
    }
    let mean = sum / f64::from(repetitions);
    let error = ((squares / f64::from(repetitions) - mean * mean) / f64::from(repetitions)).sqrt();
    assert!(stopped_at.iter().min() != stopped_at.iter().max(), "stops at different looks");
    assert!((mean - p).abs() < 4.0 * error, "{mean} +- {error}");
    let share = sum_of_shares / f64::from(repetitions);
    assert!(p - share > 4.0 * error, "{share}");
}

#[test]
fn a_single_look_gives_the_observed_share() {
    let counts = VerdictCounts { stable: 900, unstable: 60, undecided: 30, failed: 10 };
    let estimate = Looks::new(half_width(0.001), 1000, 0.95).estimate(&[counts]);
    assert_eq!(estimate.probability, Some(60.0 / 960.0));
    assert_eq!(Looks::new(half_width(0.001), 1000, 0.95).estimate(&[]).probability, None);
    let undecided = VerdictCounts { undecided: 1000, ..Default::default() };
    assert_eq!(Looks::new(half_width(0.001), 1000, 0.95).estimate(&[undecided]).probability, None);
}

#[test]
fn the_estimate_is_fast_for_many_samples() {
    // Where only the last look can have stopped, the estimate is the share.
    let looks = Looks::new(half_width(0.0005), 100_000_000, 0.95);
    let mut path = Vec::new();
    for (look, &end) in looks.ends().iter().enumerate() {
        path.push(counts(3 * end / 10, end));
        if looks.is_enough(look, &path[look]) {
            break;
        }
    }
    let last = *path.last().unwrap();
    assert!(last.total() > 3_000_000);
    assert!((looks.estimate(&path).probability.unwrap() - 0.3).abs() < 1e-9, "{last:?}");
}

#[test]
fn a_plain_interval_with_the_same_rule_covers_less_than_it_says() {
    let (p, most, repetitions) = (0.003, 0.0012, 20_000);
    let looks = Looks::new(half_width(most), 20_000, 0.95);
    let wilson = BinomialInterval::new(IntervalKind::Wilson, 0.95);
    let mut generator = Xoshiro256PlusPlus::seed_from_u64(1945);
    let mut covered = 0;
    for _ in 0..repetitions {
        let mut all = VerdictCounts::default();
        for &end in looks.ends() {
            let more = end - all.total();
            all += counts(Binomial::new(more, p).unwrap().sample(&mut generator), more);
            let plain = wilson.estimate(&all);
            if 0.5 * (plain.high - plain.low) <= most {
                covered += u32::from(plain.low <= p && p <= plain.high);
                break;
            }
        }
    }
    let share = f64::from(covered) / f64::from(repetitions);
    assert!(share < 0.94, "{share}");
}

#[test]
fn the_expected_end_is_where_a_cell_with_these_shares_stops() {
    let looks = Looks::new(half_width(0.002), 1_000_000, 0.95);
    for share in [0.001, 0.01, 0.3, 0.5] {
        let at = |samples: u64| counts((share * samples as f64) as u64, samples);
        let stop = (0..looks.ends().len()).find(|&look| looks.is_enough(look, &at(looks.ends()[look]))).unwrap();
        assert_eq!(looks.expected_end(0, &at(10_000)), looks.ends()[stop], "{share}");
        let later = (stop + 3).min(looks.ends().len() - 1);
        assert_eq!(looks.expected_end(later, &at(10_000)), looks.ends()[later], "{share}, later");
    }
}
