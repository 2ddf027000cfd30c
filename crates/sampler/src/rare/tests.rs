//! Whole estimates, against probabilities in closed form.

use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;

use crate::draw::deviates::{DeviateStream, Points as Source};
use crate::estimate::weighted::{WeightedEstimate, WeightedPart, WeightedSums, estimate};
use crate::rare::population::{Effort, Points, Population};
use crate::rare::proposal::Proposal;
use crate::special_functions::normal;

/// An estimate from 16 randomisations of `points` each, in 4 groups of their own population of 300.
fn weighted(dimensions: usize, points: u64, seed: u64, is_unstable: &dyn Fn(&[f64]) -> bool) -> WeightedEstimate {
    let mut integrand = |points: &Points| Some(points.iter().map(|u| f64::from(u8::from(is_unstable(u)))).collect());
    let proposal = |group: u64| {
        let mut generator = Xoshiro256PlusPlus::seed_from_u64(1000 * seed + group);
        Proposal::new(
            &Population::find(dimensions, Effort { particles: 300, moves: 4 }, &mut generator, &mut integrand).unwrap(),
        )
    };
    let proposals: Vec<Proposal> = (0..4).map(proposal).collect();
    let stream =
        DeviateStream { seed, common_random_numbers: false, dimensions: dimensions + 1, points: Source::Sobol };
    let mut scratch = vec![0.0; dimensions];
    let mut part = |randomisation: usize| {
        let mut sums = WeightedSums::default();
        for deviates in stream.draw(0, randomisation as u64, 0..points).chunks_exact(dimensions + 1) {
            let mut point = deviates.to_vec();
            let drawn = proposals[randomisation % 4].draw(&mut point, &mut scratch);
            sums.add(drawn.weight, Some(f64::from(u8::from(is_unstable(&point)))), drawn.is_of_inputs);
        }
        WeightedPart::from_sums(points, &sums.sums().map(i128::from))
    };
    estimate(&(0..16).map(&mut part).collect::<Vec<_>>(), 4, 0.95)
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
