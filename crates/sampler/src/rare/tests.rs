//! Whole estimates, against probabilities in closed form.

use crate::estimate::weighted::WeightedEstimate;
use crate::rare::population::Points;
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
