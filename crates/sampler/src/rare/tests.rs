//! Whole estimates, against probabilities in closed form.

use crate::estimate::weighted::WeightedEstimate;
use crate::rare::points::Points;
use crate::rare::whole;
use crate::special_functions::normal;

/// An estimate from 16 randomisations of `points` each.
fn weighted(dimensions: usize, points: u64, seed: u64, is_unstable: &dyn Fn(&[f64]) -> bool) -> WeightedEstimate {
    let value = |u: &[f64]| Some(f64::from(u8::from(is_unstable(u))));
    let mut integrand = |points: &Points| Some(points.iter().map(value).collect());
    whole::importance(dimensions, points, seed, 0.95, &mut integrand).unwrap()
}

/// The share of seeds whose interval contains the truth, that of those that are trusted, and the mean relative error.
fn coverage(dimensions: usize, points: u64, truth: f64, is_unstable: &dyn Fn(&[f64]) -> bool) -> [f64; 3] {
    let seeds = 40;
    let (mut covered, mut trusted, mut squares) = (0, 0, 0.0);
    for seed in 0..seeds {
        let found = weighted(dimensions, points, seed, is_unstable);
        covered += u64::from(found.estimate.low <= truth && truth <= found.estimate.high);
        if let Some(p) = found.estimate.probability {
            trusted += 1;
            squares += (p / truth - 1.0) * (p / truth - 1.0);
        }
    }
    [covered as f64 / seeds as f64, trusted as f64 / seeds as f64, (squares / trusted as f64).sqrt()]
}

#[test]
fn intervals_of_rare_events_hold() {
    for (dimensions, p, points) in [(2, 1e-3, 128), (2, 1e-9, 128), (10, 1e-6, 128), (20, 1e-9, 512)] {
        let limit = -normal::quantile(p) * (dimensions as f64).sqrt();
        let [covered, trusted, error] = coverage(dimensions, points, p, &|u| u.iter().sum::<f64>() > limit);
        assert!(covered >= 0.9 && trusted >= 0.95 && error < 0.1, "{dimensions} {p:e}: {covered} {trusted} {error}");
    }
}

#[test]
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
fn a_probability_near_one_is_resolved_as_well_as_one_near_zero() {
    let stable = normal::upper_tail(5.0);
    for seed in 0..10 {
        let found = weighted(3, 128, seed, &|u| u[0] > -5.0).estimate;
        let complement = 1.0 - found.probability.unwrap();
        assert!((complement / stable - 1.0).abs() < 0.1, "{complement:e}");
        assert!(found.high - found.low < 0.2 * stable, "{found:?}");
    }
    let certain = weighted(2, 128, 1, &|_| true).estimate;
    assert_eq!((certain.probability, certain.high), (Some(1.0), 1.0));
    assert!(certain.low > 0.98 && certain.low < 1.0, "{certain:?}");
}

#[test]
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
