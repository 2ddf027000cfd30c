//! Deviates of rare events, from verdicts alone.
//!
//! With deviates `s` times as large, instability is frequent. A population of unstable points of that scatter is led
//! back to the true one in steps: `s` is reduced so far that the weights `phi_s'(u) / phi_s(u)` of the points are those
//! of half as many equal ones, the points are drawn again by their weights, and each is moved by steps that leave its
//! density as it is. The ratios of the steps multiply to the probability. Where `g` is a probability, a power `b` of it
//! rises from 0 to 1 in the same way before. This is subset simulation (S. K. Au, J. L. Beck, Probabilistic Engineering
//! Mechanics 16 (2001) 263-277) whose subsets are those of the scatter, as no function says how far a verdict is from
//! another (compare J. Beaurepaire et al., Probabilistic Engineering Mechanics 33 (2013) 172-181; I. Papaioannou et al.,
//! Structural Safety 62 (2016) 66-75).
//!
//! A point `u` moves to `m + sqrt(1 - r^2) (u - m) + r L xi` with normal `xi`, where `m` and `L L'` are the mean and the
//! covariance of the enlarged inputs and of the particles, by turns. Such a step leaves the normal density `q` of that mean
//! and covariance as it is. So the point moves with the probability `(g(new) / g(old))^b` times the ratio of `phi_s / q`
//! there and here, if that is below 1 (R. M. Neal, Regression and classification using Gaussian process priors, 1998).

use std::ops::Range;

use rand::RngExt;
use rand_distr::StandardNormal;
use rand_xoshiro::Xoshiro256PlusPlus;

use crate::estimate::conditional;
use crate::rare::gaussian::Gaussian;

/// The enlargements of the scatter that are tried are the powers of this number below the largest.
const ENLARGEMENT: f64 = 1.5;
const LARGEST: f64 = 12.0;

/// Points that are tried at each enlargement, for each particle.
const TRIED: usize = 3;

/// The share of tried points that should be unstable, at least with some probability, at the first enlargement.
const FREQUENT: f64 = 0.1;

/// The effective share of particles that a reduction of the scatter leaves.
const LEFT: f64 = 0.5;

/// Moves after the last reduction.
const LAST_MOVES: usize = 8;

/// The share of moves that should succeed.
const ACCEPTED: f64 = 0.35;

/// The range of the step `r` of a move, and its first values.
const STEPS: [f64; 2] = [0.02, 1.0];
const FIRST_STEPS: [f64; 2] = [0.5, 0.8];

/// Bisections for the next scatter or power.
const BISECTIONS: usize = 40;

/// Points in the space of deviates, one after the other.
#[derive(Debug, Clone, PartialEq)]
pub struct Points {
    dimensions: usize,
    coordinates: Vec<f64>,
}

impl Points {
    /// No points yet.
    #[must_use]
    pub fn new(dimensions: usize) -> Self {
        Self { dimensions, coordinates: Vec::new() }
    }

    /// The number of deviates of a point, at least one.
    #[must_use]
    pub fn dimensions(&self) -> usize {
        self.dimensions
    }

    /// The number of points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.coordinates.len() / self.dimensions.max(1)
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.coordinates.is_empty()
    }

    /// Adds a point.
    pub fn push(&mut self, point: impl IntoIterator<Item = f64>) {
        self.coordinates.extend(point);
    }

    /// The points.
    #[must_use]
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[f64]> + Clone {
        self.coordinates.chunks_exact(self.dimensions.max(1))
    }

    /// A point.
    #[must_use]
    pub fn get(&self, point: usize) -> &[f64] {
        &self.coordinates[point * self.dimensions..][..self.dimensions]
    }

    fn replace(&mut self, point: usize, by: &[f64]) {
        self.coordinates[point * self.dimensions..][..self.dimensions].copy_from_slice(by);
    }
}

/// `g` at points, from 0 to 1 each; `None` if it is stopped before.
pub type Integrand<'a> = dyn FnMut(&Points) -> Option<Vec<f64>> + 'a;

/// Particles with the density `g(u) phi(u) / P`.
#[derive(Debug, Clone, PartialEq)]
pub struct Population {
    /// The particles; none if no unstable point was found.
    pub particles: Points,
    /// How much the scatter was enlarged at first.
    pub enlargement: f64,
    /// The probability, from the ratios of the steps. With few particles it is a little too small, as the densities within
    /// which they move are fitted to them: by some per cent with 300. Zero if no unstable point was found.
    pub probability: f64,
    /// The points that were tried without enlargement, and the sum of their values, if that was enough; else zeros.
    pub tried: [f64; 2],
    /// Values of `g` that were computed.
    pub evaluations: u64,
}

/// How much is done to find a population.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Effort {
    /// Particles.
    pub particles: usize,
    /// Moves of each after a step: some 4 to see where the particles lie, 8 for their probability, as with fewer moves in
    /// ten dimensions it scatters by twice as much.
    pub moves: usize,
}

/// Particles at one scatter.
struct Particles<'a, 'g> {
    points: Points,
    values: Vec<f64>,
    scale: f64,
    power: f64,
    /// The steps of moves within the distribution of the inputs, and within that of the particles.
    steps: [f64; 2],
    evaluations: u64,
    generator: &'a mut Xoshiro256PlusPlus,
    integrand: &'a mut Integrand<'g>,
}

impl Population {
    /// Finds a population; `None` if it is stopped before.
    pub fn find(
        dimensions: usize,
        effort: Effort,
        generator: &mut Xoshiro256PlusPlus,
        integrand: &mut Integrand<'_>,
    ) -> Option<Self> {
        let Effort { particles, moves } = effort;
        let (points, values) = (Points::new(dimensions), Vec::new());
        let mut all = Particles {
            points,
            values,
            scale: 1.0,
            power: 0.0,
            steps: FIRST_STEPS,
            evaluations: 0,
            generator,
            integrand,
        };
        let Some(share) = all.begin(particles * TRIED)? else {
            return Some(Self {
                particles: Points::new(dimensions),
                enlargement: all.scale,
                probability: 0.0,
                tried: [0.0; 2],
                evaluations: all.evaluations,
            });
        };
        let enlargement = all.scale;
        let tried = match enlargement {
            1.0 => [all.values.len() as f64, all.values.iter().sum()],
            _ => [0.0; 2],
        };
        let mut log_probability = libm::log(share);
        let unstable: Vec<f64> = all.values.iter().map(|value| if *value > 0.0 { 1.0 } else { 0.0 }).collect();
        all.draw_again(&unstable, particles);
        while all.power < 1.0 {
            log_probability += all.raise();
            all.make_moves(moves)?;
        }
        while all.scale > 1.0 {
            log_probability += all.reduce(dimensions);
            all.make_moves(moves)?;
        }
        all.make_moves(LAST_MOVES)?;
        Some(Self {
            particles: all.points,
            enlargement,
            probability: libm::exp(log_probability),
            tried,
            evaluations: all.evaluations,
        })
    }
}

impl Particles<'_, '_> {
    /// Enlarges the scatter until instability is frequent, or goes back to where it is most frequent. The share of points
    /// there that may be unstable; the inner `None` if no point may.
    fn begin(&mut self, points: usize) -> Option<Option<f64>> {
        let mut best: Option<(usize, Points, Vec<f64>, f64)> = None;
        let mut scale = 1.0;
        while scale < LARGEST {
            let dimensions = self.points.dimensions;
            let mut tried = Points::new(dimensions);
            tried.push((0..points * dimensions).map(|_| scale * self.deviate()));
            let values = self.evaluate(&tried)?;
            let unstable = values.iter().filter(|value| **value > 0.0).count();
            if unstable > best.as_ref().map_or(0, |best| best.0) {
                best = Some((unstable, tried, values, scale));
            }
            self.scale = scale;
            if unstable as f64 >= FREQUENT * points as f64 {
                break;
            }
            scale *= ENLARGEMENT;
        }
        let Some((unstable, points, values, scale)) = best else { return Some(None) };
        let share = unstable as f64 / values.len() as f64;
        (self.points, self.values, self.scale) = (points, values, scale);
        Some(Some(share))
    }

    /// Raises the power of `g`: the logarithm of the ratio of the means after and before.
    fn raise(&mut self) -> f64 {
        let most = self.values.iter().copied().fold(0.0, f64::max);
        // Relative to the largest, which cannot underflow.
        let logarithms: Vec<f64> = self.values.iter().map(|value| libm::log(value / most)).collect();
        let weights = |power: f64| -> Vec<f64> {
            logarithms.iter().map(|logarithm| libm::exp((power - self.power) * logarithm)).collect()
        };
        let power = farthest(self.power, |power| effective_number(&weights(power)) >= LEFT * logarithms.len() as f64);
        let weights = weights(power);
        let mean = weights.iter().sum::<f64>() / weights.len() as f64;
        let ratio = libm::log(mean) + (power - self.power) * libm::log(most);
        self.draw_again(&weights, weights.len());
        self.power = power;
        ratio
    }

    /// Reduces the scatter: the logarithm of the ratio of the probabilities after and before.
    fn reduce(&mut self, dimensions: usize) -> f64 {
        let squares: Vec<f64> = self.points.iter().map(|point| point.iter().map(|u| u * u).sum()).collect();
        let least = squares.iter().copied().fold(f64::INFINITY, f64::min);
        // Relative to that of the point nearest to the centre, which cannot underflow.
        let weights = |precision: f64| -> Vec<f64> {
            let more = precision - 1.0 / (self.scale * self.scale);
            squares.iter().map(|square| libm::exp(-0.5 * more * (square - least))).collect()
        };
        let before = 1.0 / (self.scale * self.scale);
        let is_enough = |precision: f64| effective_number(&weights(precision)) >= LEFT * squares.len() as f64;
        let precision = farthest(before, is_enough);
        let weights = weights(precision);
        let mean = weights.iter().sum::<f64>() / weights.len() as f64;
        self.draw_again(&weights, squares.len());
        self.scale = 1.0 / precision.sqrt();
        libm::log(mean) - 0.5 * (precision - before) * least + 0.5 * dimensions as f64 * libm::log(precision / before)
    }

    /// Draws `count` of the points again, by their weights: each as often as its share of the weights, rounded up or
    /// down.
    fn draw_again(&mut self, weights: &[f64], count: usize) {
        let step = weights.iter().sum::<f64>() / count as f64;
        let first: f64 = self.generator.random();
        let mut drawn = Points::new(self.points.dimensions);
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

    /// Moves every point some times, by turns within the distribution of the inputs and within that of the particles.
    fn make_moves(&mut self, moves: usize) -> Option<()> {
        let dimensions = self.points.dimensions;
        let scaled: Vec<f64> = self.points.coordinates.iter().map(|u| u / self.scale).collect();
        let scaled = Points { dimensions, coordinates: scaled };
        let of_inputs = Gaussian::round(vec![0.0; dimensions], 1.0);
        // Those of the other half: a density that is fitted to the points that it moves holds them where they are.
        let middle = scaled.len() / 2;
        let of_half = |half: Range<usize>| {
            let weights: Vec<f64> = (0..scaled.len()).map(|i| if half.contains(&i) { 1.0 } else { 0.0 }).collect();
            Gaussian::fit(scaled.iter(), &weights).unwrap_or_else(|| of_inputs.clone())
        };
        let of_others = [of_half(middle..scaled.len()), of_half(0..middle)];
        for turn in 0..moves {
            match turn % 2 {
                0 => self.move_within(0, &of_inputs, |_| &of_inputs)?,
                _ => self.move_within(1, &of_inputs, |i| &of_others[usize::from(i >= middle)])?,
            }
        }
        Some(())
    }

    /// Moves every point within a distribution of its own, by the step of that number. Distributions are those of the
    /// deviates without enlargement.
    fn move_within<'d>(
        &mut self,
        which: usize,
        of_inputs: &Gaussian,
        of: impl Fn(usize) -> &'d Gaussian,
    ) -> Option<()> {
        let (step, scale, dimensions) = (self.steps[which], self.scale, self.points.dimensions);
        let rest = (1.0 - step * step).sqrt();
        let mut proposed = Points::new(dimensions);
        for i in 0..self.points.len() {
            let mut moved: Vec<f64> = (0..dimensions).map(|_| step * self.deviate()).collect();
            let around = of(i);
            // This adds the mean.
            around.transform(&mut moved);
            for ((moved, u), mean) in moved.iter_mut().zip(self.points.get(i)).zip(around.mean()) {
                *moved = scale * (*moved + rest * (u / scale - mean));
            }
            proposed.push(moved);
        }
        let values = self.evaluate(&proposed)?;
        let mut scratch = vec![0.0; dimensions];
        let mut excess = |i: usize, point: &[f64]| {
            let point: Vec<f64> = point.iter().map(|u| u / scale).collect();
            of_inputs.log_density(&point, &mut scratch) - of(i).log_density(&point, &mut scratch)
        };
        let mut accepted = 0.0;
        for (i, &value) in values.iter().enumerate() {
            let chance: f64 = self.generator.random();
            let more = excess(i, proposed.get(i)) - excess(i, self.points.get(i));
            if value > 0.0 && libm::pow(value / self.values[i], self.power) * libm::exp(more) > chance {
                self.points.replace(i, proposed.get(i));
                self.values[i] = value;
                accepted += 1.0;
            }
        }
        let share = accepted / values.len() as f64;
        self.steps[which] = (step * libm::exp(share - ACCEPTED)).clamp(STEPS[0], STEPS[1]);
        Some(())
    }

    fn deviate(&mut self) -> f64 {
        self.generator.sample(StandardNormal)
    }

    fn evaluate(&mut self, points: &Points) -> Option<Vec<f64>> {
        self.evaluations += points.len() as u64;
        (self.integrand)(points)
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

    const EFFORT: Effort = Effort { particles: 300, moves: 8 };

    fn find(dimensions: usize, seed: u64, is_unstable: impl Fn(&[f64]) -> bool) -> Population {
        let mut integrand =
            |points: &Points| Some(points.iter().map(|u| f64::from(u8::from(is_unstable(u)))).collect());
        let mut generator = Xoshiro256PlusPlus::seed_from_u64(seed);
        Population::find(dimensions, EFFORT, &mut generator, &mut integrand).unwrap()
    }

    #[test]
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
    fn a_power_of_probabilities_rises_where_these_are_known() {
        // Given the first of two inputs, the second exceeds 6 minus it.
        let truth = normal::upper_tail(6.0 / std::f64::consts::SQRT_2);
        let find = |seed: u64| {
            let mut integrand = |points: &Points| Some(points.iter().map(|u| normal::upper_tail(6.0 - u[0])).collect());
            let mut generator = Xoshiro256PlusPlus::seed_from_u64(seed);
            Population::find(1, EFFORT, &mut generator, &mut integrand).unwrap()
        };
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
        let population = find(3, 1, |u| u[0] > 0.0);
        assert_eq!(population.enlargement, 1.0);
        assert!((population.probability - 0.5).abs() < 0.1);
    }
}
