//! Whole estimates, against probabilities in closed form.

use crate::estimate::weighted::{Distrust, WeightedEstimate};
use crate::rare::points::{Integrand, LimitBranches, LimitState, Points};
use crate::rare::scatters::square;
use crate::rare::whole;
use crate::special_functions::normal;

/// An estimate from 16 randomisations of `points` each.
fn weighted(dimensions: usize, points: u64, seed: u64, is_unstable: &dyn Fn(&[f64]) -> bool) -> WeightedEstimate {
    whole::importance(dimensions, points, seed, 0.95, &mut verdicts(is_unstable)).unwrap()
}

/// Verdicts alone.
fn verdicts(is_unstable: &dyn Fn(&[f64]) -> bool) -> impl Integrand {
    let value = |u: &[f64]| Some(f64::from(u8::from(is_unstable(u))));
    move |points: &Points| Some(points.iter().map(value).collect())
}

/// The share of seeds whose interval contains the truth, that of those that are trusted, and the mean relative error.
fn coverage(dimensions: usize, points: u64, truth: f64, is_unstable: &dyn Fn(&[f64]) -> bool) -> [f64; 3] {
    let [covered, trusted, error, _] = coverage_by(dimensions, points, truth, &mut verdicts(is_unstable));
    [covered, trusted, error]
}

/// The same, and the mean number of evaluations.
fn coverage_by(dimensions: usize, points: u64, truth: f64, integrand: &mut dyn Integrand) -> [f64; 4] {
    let seeds = 40;
    let (mut covered, mut trusted, mut squares, mut evaluations) = (0, 0, 0.0, 0.0);
    for seed in 0..seeds {
        let found = whole::importance(dimensions, points, seed, 0.95, integrand).unwrap();
        covered += u64::from(found.estimate.low <= truth && truth <= found.estimate.high);
        evaluations += found.evaluations;
        if let Some(p) = found.estimate.probability {
            trusted += 1;
            squares += (p / truth - 1.0) * (p / truth - 1.0);
        }
    }
    let seeds = seeds as f64;
    [covered as f64 / seeds, trusted as f64 / seeds, (squares / trusted as f64).sqrt(), evaluations / seeds]
}

#[test]
fn limit_states_take_as_few_evaluations_as_the_first_order_reliability_method() {
    // OpenTURNS 1.27 takes 2431 with ten inputs and 1e-9 for an error of 5 %, `make bench-peers`.
    let limit = -normal::quantile(1e-9) * 10_f64.sqrt();
    let mut plane = LimitState(|u: &[f64]| limit - u.iter().sum::<f64>());
    let [covered, trusted, error, evaluations] = coverage_by(10, 48, 1e-9, &mut plane);
    assert!(covered >= 0.9 && trusted >= 0.95 && error < 0.05, "{covered} {trusted} {error}");
    assert!(evaluations < 2431.0, "{evaluations}");
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn islands_of_limit_states_are_not_lost() {
    // A branch, and beside it a disc of radius 1 around (-4, 3), with most of the probability.
    let disc = |u: &[f64]| libm::hypot(u[0] + 4.0, u[1] - 3.0) - 1.0;
    let mut both = LimitState(|u: &[f64]| disc(u).min(5.0 - u[2]));
    // By the trapezoidal rule over the angle and the radius.
    let (mut of_disc, steps) = (0.0, 2000);
    for i in 0..steps {
        let radius = (f64::from(i) + 0.5) / f64::from(steps);
        for angle in 0..200 {
            let (sine, cosine) = libm::sincos(std::f64::consts::TAU * f64::from(angle) / 200.0);
            let square = (radius * cosine - 4.0).powi(2) + (radius * sine + 3.0).powi(2);
            of_disc += radius * libm::exp(-0.5 * square) / 200.0 / f64::from(steps);
        }
    }
    let truth = of_disc + normal::upper_tail(5.0) * (1.0 - of_disc);
    let [covered, trusted, error, _] = coverage_by(3, 256, truth, &mut both);
    assert!(covered >= 0.9 && trusted >= 0.95 && error < 0.1, "{covered} {trusted} {error}, {of_disc:e}");
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn intervals_of_rare_events_hold() {
    for (dimensions, p, points) in [(2, 1e-3, 128), (2, 1e-9, 128), (10, 1e-6, 128), (20, 1e-9, 512)] {
        let limit = -normal::quantile(p) * (dimensions as f64).sqrt();
        let [covered, trusted, error] = coverage(dimensions, points, p, &|u| u.iter().sum::<f64>() > limit);
        assert!(covered >= 0.9 && trusted >= 0.95 && error < 0.1, "{dimensions} {p:e}: {covered} {trusted} {error}");
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn a_second_branch_and_an_island_are_not_lost() {
    // Two branches of the same probability.
    let branches = |u: &[f64]| u[0] > 5.0 || u[1] < -5.0;
    let truth = 1.0 - (1.0 - normal::upper_tail(5.0)) * (1.0 - normal::upper_tail(5.0));
    let [covered, trusted, error] = coverage(4, 128, truth, &branches);
    assert!(covered >= 0.9 && trusted >= 0.95 && error < 0.1, "branches: {covered} {trusted} {error}");
    // An island beside a branch: a square of 3 to 4 by -4 to -3.
    let island = |u: &[f64]| u[0] > 5.0 || ((3.0..4.0).contains(&u[0]) && (-4.0..-3.0).contains(&u[1]));
    let side = normal::upper_tail(3.0) - normal::upper_tail(4.0);
    let truth = normal::upper_tail(5.0) + side * side;
    let [covered, trusted, error] = coverage(2, 128, truth, &island);
    assert!(covered >= 0.9 && trusted >= 0.95 && error < 0.1, "island: {covered} {trusted} {error}");
}

#[test]
fn a_region_that_is_not_found_is_not_called_stable() {
    let found = weighted(2, 128, 1, &|u| u[0] > 60.0);
    assert_eq!(found.estimate.probability, None);
    assert!(found.estimate.low == 0.0 && found.estimate.high > 0.001);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn a_probability_near_one_is_resolved_as_well_as_one_near_zero() {
    let stable = normal::upper_tail(5.0);
    for seed in 0..10 {
        let found = weighted(3, 128, seed, &|u| u[0] > -5.0).estimate;
        let complement = 1.0 - found.probability.unwrap();
        assert!((complement / stable - 1.0).abs() < 0.1, "{complement:e}");
        assert!(found.high - found.low < 0.2 * stable, "{found:?}");
    }
    let certain = weighted(2, 128, 1, &|_| true).estimate;
    assert_eq!((certain.probability, certain.high), (None, 1.0));
    assert!(certain.low > 0.98 && certain.low < 1.0, "{certain:?}");
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn a_region_that_a_nearer_limit_state_hides_is_not_lost() {
    // A plane at 4.5 whose limit state is small everywhere, and a sphere of radius 2 around a point at 4.5: by the noncentral
    // distribution of chi squared, both have 7.790e-4, the plane alone 3.4e-6.
    let states = |u: &[f64]| {
        let sphere = square(u) - 4.5 * u[1..].iter().sum::<f64>() + 4.5 * 4.5 - 4.0;
        vec![0.025 * (4.5 - u[0]), sphere / 3.3]
    };
    let (truth, mut held) = (7.790e-4, 0);
    for seed in 0..20 {
        let found = whole::importance(5, 128, seed, 0.95, &mut LimitBranches::new(2, states)).unwrap().estimate;
        let is_near = found.probability.is_none_or(|p| (p / truth - 1.0).abs() < 0.25);
        assert!(is_near, "seed {seed}: {found:?}");
        held += u32::from(found.probability.is_some() && found.low <= truth && truth <= found.high);
    }
    assert!(held >= 16, "{held} of 20");
}

#[test]
fn populations_that_find_nothing_stable_have_no_number_as_those_that_find_nothing_unstable() {
    for (is_unstable, mean) in [(true, 1.0), (false, 0.0)] {
        let found = whole::subset(2, 60, 1, 0.95, &mut verdicts(&|_| is_unstable)).unwrap();
        assert_eq!((found.estimate.probability, found.distrust), (None, Some(Distrust::NothingFound)));
        assert_eq!([found.mean, found.estimate.low, found.estimate.high], [mean, 0.0, 1.0]);
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn points_that_a_population_misses_get_particles_of_their_own() {
    // A conditional probability that is nowhere zero, and an island with a hundredth of its probability.
    let valley = |u: &[f64]| normal::upper_tail((5.2 - 0.5 * u[2]) / 0.75_f64.sqrt());
    let is_of_island = |u: &[f64]| (4.0..5.0).contains(&u[0]) && (4.0..5.0).contains(&u[1]);
    let side = normal::upper_tail(4.0) - normal::upper_tail(5.0);
    let truth = normal::upper_tail(5.2) + side * side;
    let mut met = 0;
    for seed in 0..10 {
        let mut samples = 0;
        let mut g = |points: &Points| {
            samples += points.iter().filter(|u| is_of_island(u)).count();
            Some(points.iter().map(|u| Some(if is_of_island(u) { 1.0 } else { valley(u) })).collect())
        };
        let found = whole::importance(3, 256, seed, 0.95, &mut g).unwrap();
        let Some(p) = found.estimate.probability else { continue };
        met += usize::from(samples > 100);
        assert!((p / truth - 1.0).abs() < 0.03, "{p:e}, {truth:e}");
    }
    assert!(met >= 8, "the island was sampled in {met} of 10 runs");
}
