//! Whole estimates in one call, in one thread.

use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;

use crate::draw::deviates::{DeviateStream, Points as Source};
use crate::estimate::weighted::{self, WeightedEstimate, WeightedPart, WeightedSums};
use crate::rare::exploration::{Effort, Search};
use crate::rare::points::{Integrand, Points};
use crate::rare::proposal::Proposal;

/// Randomisations, and the populations that they share.
const RANDOMISATIONS: usize = 16;
const POPULATIONS: usize = 4;

/// The mean of `g` over independent standard normal deviates, by samples with weights: 16 randomisations of `points` points
/// each, a power of two, placed by four populations of 300 particles.
///
/// ```
/// use stickslip_sampler::rare::whole::importance;
///
/// // Unstable where the sum of three deviates is above 9.
/// let mut g = |points: &stickslip_sampler::rare::points::Points| {
///     Some(points.iter().map(|u| Some(if u.iter().sum::<f64>() > 9.0 { 1.0 } else { 0.0 })).collect())
/// };
/// let found = importance(3, 256, 1, 0.95, &mut g).unwrap().estimate;
/// assert!(found.low < 1.0187e-7 && 1.0187e-7 < found.high && found.high - found.low < 1.5e-8);
/// ```
///
/// `None` if it is stopped before.
pub fn importance(
    dimensions: usize,
    points: u64,
    seed: u64,
    confidence: f64,
    integrand: &mut dyn Integrand,
) -> Option<WeightedEstimate> {
    let stream =
        DeviateStream { seed, common_random_numbers: false, dimensions: dimensions + 1, points: Source::Sobol };
    let effort = Effort { particles: 300, moves: 4 };
    let mut proposals = Vec::new();
    let mut parts = Vec::new();
    for randomisation in 0..RANDOMISATIONS {
        let mut sums = WeightedSums::default();
        if randomisation < POPULATIONS {
            let mut generator = generator(seed, randomisation);
            let mut search = Search::new(dimensions, effort, &mut generator, integrand);
            proposals.push(Proposal::find(&mut search)?);
            sums.add_evaluations(search.evaluations());
        }
        let mut scratch = vec![0.0; dimensions];
        let mut drawn = Points::new(dimensions);
        let mut weights = Vec::new();
        for deviates in stream.draw(0, randomisation as u64, 0..points).chunks_exact(dimensions + 1) {
            let mut point = deviates.to_vec();
            weights.push(proposals[randomisation % POPULATIONS].draw(&mut point, &mut scratch));
            drawn.push(point);
        }
        let event = proposals[randomisation % POPULATIONS].event();
        for (drawn, value) in weights.iter().zip(integrand.values(&drawn)?) {
            sums.add(drawn.weight, value.map(|value| event.value(value)), drawn.is_of_inputs, event);
        }
        parts.push(WeightedPart::from_sums(points, &sums.sums().map(i128::from)));
    }
    Some(weighted::estimate(&parts, POPULATIONS, confidence))
}

/// The mean of `g` over independent standard normal deviates, by 16 populations of so many particles; `None` if it is
/// stopped before.
pub fn subset(
    dimensions: usize,
    particles: usize,
    seed: u64,
    confidence: f64,
    integrand: &mut dyn Integrand,
) -> Option<WeightedEstimate> {
    let effort = Effort { particles, moves: 8 };
    let mut parts = Vec::new();
    for number in 0..RANDOMISATIONS {
        let mut generator = generator(seed, number);
        let mut search = Search::new(dimensions, effort, &mut generator, integrand);
        let (explored, population) = search.population()?;
        let mut sums = WeightedSums::default();
        sums.add_population(population.probability, explored.without_verdict, explored.of_inputs(), explored.event);
        sums.add_evaluations(search.evaluations());
        parts.push(WeightedPart::from_sums(1, &sums.sums().map(i128::from)));
    }
    Some(weighted::estimate_of_populations(&parts, confidence))
}

fn generator(seed: u64, number: usize) -> Xoshiro256PlusPlus {
    Xoshiro256PlusPlus::seed_from_u64(1000 * seed + number as u64)
}
