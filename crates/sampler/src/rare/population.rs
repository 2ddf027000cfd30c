//! Deviates of rare events, from verdicts or from conditional probabilities.
//!
//! Points are tried with deviates 1, 1.5, 2.25 ... times as large, until instability is frequent and twice beyond. They have the density
//! `q`, the mean of those of the scatters. The particles, drawn from them, are led to the density `g phi / P` of unstable
//! points in steps, through
//!
//! ```text
//! pi_t = (g phi)^t q^(1 - t) / Z_t,    t from 0 to 1
//! ```
//!
//! `t` is raised so far that the weights `(g phi / q)^dt` of the points are those of half as many equal ones, the points
//! are drawn again by their weights, and each is moved by steps that leave `pi_t` as it is. The means of the weights
//! multiply to the probability. A region keeps about the share of the particles that it has in `pi_t`, whose logarithm is
//! between those in `q` and in the true density. So a region is found, be it near or far, if a point that was tried lies in
//! it and leads there; one in which no point lies is not.
//!
//! This is a sequential Monte Carlo sampler (P. Del Moral, A. Doucet, A. Jasra, J. R. Stat. Soc. B 68 (2006) 411-436); for
//! rare events compare subset simulation (S. K. Au, J. L. Beck, Probabilistic Engineering Mechanics 16 (2001) 263-277) and
//! J. Beaurepaire et al., Probabilistic Engineering Mechanics 33 (2013) 172-181, who change the scatter likewise.
//!
//! A point `u` moves to `m + sqrt(1 - r^2) (u - m) + r L xi` with normal `xi`, where `m` and `L L'` are the mean and the
//! covariance of inputs with about the scatter that `pi_t` has without `g`, and of the particles, by turns. Such a step leaves
//! the normal density `p` of that mean and covariance as it is. So the point moves with the probability of the ratio of
//! `pi_t / p` there and here, if that is below 1 (R. M. Neal, Regression and classification using Gaussian process priors,
//! 1998).

use std::ops::Range;

use rand::RngExt;
use rand::seq::SliceRandom;

use crate::estimate::conditional;
use crate::rare::exploration::{Effort, Explored, Search};
use crate::rare::gaussian::Gaussian;
use crate::rare::points::Points;
use crate::rare::scatters::{Scatters, square};

/// Points that are tried at each enlargement, for each particle.
pub const TRIED: usize = 3;

/// The effective number of points after a step, for each particle.
const LEFT: f64 = 0.5;

/// Moves after the last step.
const LAST_MOVES: usize = 8;

/// Particles that are spread over the region of a few, and their moves.
pub const SPREAD: usize = 60;
const SPREADING_MOVES: usize = 24;

/// The share of moves that should succeed.
const ACCEPTED: f64 = 0.35;

/// From so many inputs on, each of them is moved within the distribution of the inputs with this probability: a region that
/// few inputs determine is left less often.
const MANY: usize = 3;
const MOVED: f64 = 0.5;

/// The range of the step `r` of a move, and its first values.
const STEPS: [f64; 2] = [0.02, 1.0];
const FIRST_STEPS: [f64; 2] = [0.5, 0.8];

/// Bisections for the next step.
const BISECTIONS: usize = 40;

/// Particles with the density `g(u) phi(u) / P`.
#[derive(Debug, Clone, PartialEq)]
pub struct Population {
    /// The particles; none if no unstable point was found.
    pub particles: Points,
    /// The probability of the regions that they come from, from the weights of the steps. Zero if no unstable point was
    /// found.
    pub probability: f64,
}

impl Search<'_> {
    /// Leads particles from the points at these places; `None` if it is stopped before.
    pub fn lead(&mut self, explored: &Explored, places: &[usize]) -> Option<Population> {
        let Effort { particles, moves } = self.effort();
        // In no order: either half of the particles has the same distribution then.
        let mut places = places.to_vec();
        places.shuffle(self.generator);
        let mut points = Points::new(self.dimensions());
        places.iter().for_each(|place| points.push(explored.points.get(*place).iter().copied()));
        let mut all = Particles {
            points,
            values: places.iter().map(|place| explored.values[*place]).collect(),
            scatters: &explored.scatters,
            power: 0.0,
            steps: FIRST_STEPS,
            search: self,
        };
        let mut log_probability = libm::log(places.len() as f64 / explored.tried as f64);
        if !places.is_empty() {
            while all.power < 1.0 {
                log_probability += all.advance(particles);
                all.make_moves(moves)?;
            }
            all.make_moves(LAST_MOVES)?;
        }
        Some(Population { particles: all.points, probability: libm::exp(log_probability) })
    }

    /// Spreads copies of a few particles over their region; `None` if it is stopped before.
    pub fn spread(&mut self, scatters: &Scatters, few: &[&[f64]]) -> Option<Points> {
        let mut points = Points::new(self.dimensions());
        (0..SPREAD).for_each(|i| points.push(few[i % few.len()].iter().copied()));
        let values = self.evaluate(&points)?.into_iter().map(Option::unwrap_or_default).collect();
        let mut all = Particles { points, values, scatters, power: 1.0, steps: FIRST_STEPS, search: self };
        all.make_moves(SPREADING_MOVES)?;
        Some(all.points)
    }

    /// Tries points, and leads particles from all of them; `None` if it is stopped before.
    pub fn population(&mut self) -> Option<(Explored, Population)> {
        let explored = self.explore(TRIED * self.effort().particles)?;
        let all: Vec<usize> = (0..explored.points.len()).collect();
        let population = self.lead(&explored, &all)?;
        Some((explored, population))
    }
}

/// Particles on their way.
struct Particles<'s, 'a> {
    points: Points,
    values: Vec<f64>,
    scatters: &'s Scatters,
    /// `t`
    power: f64,
    /// The steps of moves within the distribution of the inputs, and within that of the particles.
    steps: [f64; 2],
    search: &'s mut Search<'a>,
}

impl Particles<'_, '_> {
    /// Raises `t`, and draws so many particles by their weights: the logarithm of the mean of the weights.
    fn advance(&mut self, particles: usize) -> f64 {
        let logarithm = |(point, value): (&[f64], &f64)| {
            libm::log(*value) + self.scatters.log_ratio(square(point), self.points.dimensions())
        };
        let logarithms: Vec<f64> = self.points.iter().zip(&self.values).map(logarithm).collect();
        let most = logarithms.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        // Relative to the largest, which cannot underflow.
        let before = self.power;
        let weights = |power: f64| -> Vec<f64> {
            logarithms.iter().map(|logarithm| libm::exp((power - before) * (logarithm - most))).collect()
        };
        let power = farthest(before, |power| effective_number(&weights(power)) >= LEFT * particles as f64);
        let weights = weights(power);
        let mean = weights.iter().sum::<f64>() / weights.len() as f64;
        let ratio = libm::log(mean) + (power - before) * most;
        self.draw_again(&weights, particles);
        self.power = power;
        ratio
    }

    /// Draws `count` of the points again, by their weights: each as often as its share of the weights, rounded up or
    /// down.
    fn draw_again(&mut self, weights: &[f64], count: usize) {
        let step = weights.iter().sum::<f64>() / count as f64;
        let first: f64 = self.search.generator.random();
        let mut drawn = Points::new(self.points.dimensions());
        let mut values = Vec::with_capacity(count);
        let (mut point, mut sum) = (0, weights[0]);
        for i in 0..count {
            let wanted = (first + i as f64) * step;
            while sum < wanted && point + 1 < weights.len() {
                point += 1;
                sum += weights[point];
            }
            drawn.push(self.points.get(point).iter().copied());
            values.push(self.values[point]);
        }
        (self.points, self.values) = (drawn, values);
    }

    /// Moves every point some times, by turns within a distribution like that of the inputs and within that of the
    /// particles.
    fn make_moves(&mut self, moves: usize) -> Option<()> {
        let dimensions = self.points.dimensions();
        let mut squares: Vec<f64> = self.points.iter().map(square).collect();
        squares.sort_by(f64::total_cmp);
        let of_scatters = self.scatters.precision(squares[squares.len() / 2], dimensions);
        let scale = 1.0 / (self.power + (1.0 - self.power) * of_scatters).sqrt();
        let of_inputs = Gaussian::round(vec![0.0; dimensions], 1.0);
        let (count, middle) = (self.points.len(), self.points.len() / 2);
        for turn in 0..moves {
            if turn % 2 == 0 {
                self.move_within(0, scale, 0..count, &of_inputs)?;
                continue;
            }
            // A half moves within the density of the other: one that is fitted to the points that it moves holds them
            // where they are.
            for [own, others] in [[0..middle, middle..count], [middle..count, 0..middle]] {
                let around = self.fitted(others, scale).unwrap_or_else(|| of_inputs.clone());
                self.move_within(1, scale, own, &around)?;
            }
        }
        Some(())
    }

    /// The density fitted to some of the points, divided by `scale`.
    fn fitted(&self, points: Range<usize>, scale: f64) -> Option<Gaussian> {
        let mut scaled = Points::new(self.points.dimensions());
        points.for_each(|i| scaled.push(self.points.get(i).iter().map(|u| u / scale)));
        Gaussian::fit(scaled.iter(), &vec![1.0; scaled.len()])
    }

    /// Moves some of the points within a distribution, by the step of that number. It is that of points divided by
    /// `scale`.
    fn move_within(&mut self, which: usize, scale: f64, points: Range<usize>, around: &Gaussian) -> Option<()> {
        let (step, dimensions) = (self.steps[which], self.points.dimensions());
        let rest = (1.0 - step * step).sqrt();
        let mut proposed = Points::new(dimensions);
        for i in points.clone() {
            let mut moved: Vec<f64> = (0..dimensions).map(|_| step * self.search.deviate()).collect();
            // This adds the mean.
            around.transform(&mut moved);
            for ((moved, u), mean) in moved.iter_mut().zip(self.points.get(i)).zip(around.mean()) {
                let is_moved = which == 1 || dimensions < MANY || self.search.generator.random::<f64>() < MOVED;
                *moved = if is_moved { scale * (*moved + rest * (u / scale - mean)) } else { *u };
            }
            proposed.push(moved);
        }
        let values = self.search.evaluate(&proposed)?;
        let mut scratch = vec![0.0; dimensions];
        // The logarithm of the density that is wanted over that which the step leaves as it is.
        let (scatters, power) = (self.scatters, self.power);
        let mut excess = |point: &[f64], value: f64| {
            let square = square(point);
            let wanted =
                power * libm::log(value) - 0.5 * square - (1.0 - power) * scatters.log_ratio(square, dimensions);
            let point: Vec<f64> = point.iter().map(|u| u / scale).collect();
            wanted - around.log_density(&point, &mut scratch)
        };
        let mut accepted = 0.0;
        for ((i, moved), value) in points.zip(proposed.iter()).zip(&values) {
            let chance: f64 = self.search.generator.random();
            let Some(value) = value.filter(|value| *value > 0.0) else { continue };
            let more = excess(moved, value) - excess(self.points.get(i), self.values[i]);
            if libm::exp(more) > chance {
                self.points.replace(i, moved);
                self.values[i] = value;
                accepted += 1.0;
            }
        }
        let share = accepted / values.len() as f64;
        self.steps[which] = (step * libm::exp(share - ACCEPTED)).clamp(STEPS[0], STEPS[1]);
        Some(())
    }
}

/// How far to go towards 1, so that enough is left.
fn farthest(from: f64, is_enough: impl Fn(f64) -> bool) -> f64 {
    if is_enough(1.0) {
        return 1.0;
    }
    let (mut enough, mut too_far) = (from, 1.0);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (enough + too_far);
        if is_enough(middle) {
            enough = middle;
        } else {
            too_far = middle;
        }
    }
    too_far
}

/// The number of equal weights whose mean has the same relative variance.
fn effective_number(weights: &[f64]) -> f64 {
    let (sum, squares) = weights.iter().fold((0.0, 0.0), |(sum, squares), w| (sum + w, squares + w * w));
    conditional::effective_number(sum, squares)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::special_functions::normal;
    use rand::SeedableRng;
    use rand_xoshiro::Xoshiro256PlusPlus;

    const EFFORT: Effort = Effort { particles: 300, moves: 8 };

    fn find_by(dimensions: usize, seed: u64, g: impl Fn(&[f64]) -> f64) -> (Explored, Population) {
        let mut integrand = |points: &Points| Some(points.iter().map(|u| Some(g(u))).collect());
        let mut generator = Xoshiro256PlusPlus::seed_from_u64(seed);
        Search::new(dimensions, EFFORT, &mut generator, &mut integrand).population().unwrap()
    }

    fn find(dimensions: usize, seed: u64, is_unstable: impl Fn(&[f64]) -> bool) -> Population {
        find_by(dimensions, seed, |u| f64::from(u8::from(is_unstable(u)))).1
    }

    #[test]
    #[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
    fn the_ratios_multiply_to_the_probability() {
        for (dimensions, limit) in [(1, 3.0), (2, 4.75), (5, 1.0), (10, 5.0), (20, 6.0)] {
            let is_unstable = |u: &[f64]| u.iter().sum::<f64>() > limit * (dimensions as f64).sqrt();
            let truth = normal::upper_tail(limit);
            let seeds = 40;
            let found: Vec<f64> = (0..seeds).map(|seed| find(dimensions, seed, is_unstable).probability).collect();
            let mean = found.iter().sum::<f64>() / f64::from(seeds as u32);
            let variance = found.iter().map(|p| (p - mean) * (p - mean)).sum::<f64>() / (seeds - 1) as f64;
            let error = (variance / seeds as f64).sqrt();
            assert!((mean - truth).abs() < 3.5 * error, "{dimensions} inputs: {mean:e} +- {error:e}, {truth:e}");
            assert!(error < 0.15 * truth, "{dimensions} inputs: {mean:e} +- {error:e}");
        }
    }

    #[test]
    #[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
    fn many_particles_leave_no_bias() {
        // Halves of the particles that differ in their distribution make the probability 4 % too large.
        let limit = 3.0;
        let value = |u: &[f64]| Some(f64::from(u8::from(u.iter().sum::<f64>() > limit * 10_f64.sqrt())));
        let probability = |seed: u64| {
            let mut integrand = |points: &Points| Some(points.iter().map(value).collect());
            let mut generator = Xoshiro256PlusPlus::seed_from_u64(seed);
            let effort = Effort { particles: 6000, moves: 8 };
            Search::new(10, effort, &mut generator, &mut integrand).population().unwrap().1.probability
        };
        let mean = (0..20).map(probability).sum::<f64>() / 20.0;
        assert!((mean / normal::upper_tail(limit) - 1.0).abs() < 0.02, "{mean:e}");
    }

    #[test]
    fn a_power_of_probabilities_rises_where_these_are_known() {
        // Given the first of two inputs, the second exceeds 6 minus it.
        let truth = normal::upper_tail(6.0 / std::f64::consts::SQRT_2);
        let find = |seed: u64| find_by(1, seed, |u| normal::upper_tail(6.0 - u[0])).1;
        let populations: Vec<Population> = (0..40).map(find).collect();
        let mean = populations.iter().map(|population| population.probability).sum::<f64>() / 40.0;
        assert!((mean / truth - 1.0).abs() < 0.05, "{mean:e}, {truth:e}");
        // The first lies around 3 if their sum is 6.
        for population in populations {
            let mean = population.particles.iter().map(|u| u[0]).sum::<f64>() / 300.0;
            assert!((mean - 3.15).abs() < 0.25, "{mean}");
        }
    }

    #[test]
    fn particles_lie_in_all_regions_where_they_should() {
        // Two branches, of which the nearer has 0.9 of the probability, in five dimensions.
        let is_unstable = |u: &[f64]| u[0] > 4.5 || u[1] < -4.955;
        let share = normal::upper_tail(4.955) / (normal::upper_tail(4.5) + normal::upper_tail(4.955));
        let mut nearer = 0;
        let mut all = 0;
        for seed in 0..20 {
            let population = find(5, seed, is_unstable);
            assert!(population.particles.iter().all(is_unstable));
            nearer += population.particles.iter().filter(|u| u[0] > 4.5).count();
            all += population.particles.len();
        }
        let found = 1.0 - nearer as f64 / all as f64;
        assert!((found - share).abs() < 0.05, "{found} of the particles lie in the farther branch, {share} should");
    }

    #[test]
    fn where_nothing_is_unstable_nothing_is_found() {
        let population = find(3, 1, |_| false);
        assert!(population.particles.is_empty());
        assert_eq!(population.probability, 0.0);
    }

    #[test]
    fn frequent_events_need_no_larger_scatter() {
        let (explored, population) = find_by(3, 1, |u| f64::from(u8::from(u[0] > 0.0)));
        assert_eq!(explored.scatters.enlargements(), [1.0]);
        assert!((population.probability - 0.5).abs() < 0.1);
    }
}
