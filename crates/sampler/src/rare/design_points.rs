//! Regions of a rare event by the gradient of a limit state, as the first-order reliability method finds them.
//!
//! A limit state `s(u)` is below zero where the event happens. The most probable point of a region, its design point, is the
//! point with `s <= 0` that is nearest to the origin. With `s` linear around a point `x`, with gradient `a`, it is
//!
//! ```text
//! u = -a c / (|a|^2 + e),    c = max(s(x) - a . x, 0),    beta = c / sqrt(|a|^2 + e),    P = Phi(-beta)
//! ```
//!
//! with `e = 0`. Where `g` is a conditional probability, `s` is [the deviate](super::points::ConditionalProbability) that it
//! corresponds to, a further normal deviate `xi` decides with `s + xi <= 0`, and `e = 1`. The step is repeated from there,
//! shortened where it leads to a worse point (A. M. Hasofer, N. C. Lind, J. Eng. Mech. Div. ASCE 100 (1974) 111-121; R.
//! Rackwitz, B. Fiessler, Computers & Structures 9 (1978) 489-494; shortened by a merit function as in P.-L. Liu, A. Der
//! Kiureghian, Structural Safety 9 (1991) 161-177). Gradients are differences.
//!
//! It starts from the origin, and then from the points that were tried whose limit state is farthest below what the design
//! points found so far make of it. A region is that of a plane only if a few samples around its design point agree.
//!
//! The least of several limit states, as of single modes, hides a region behind the nearest one, be it the smaller. So each of
//! these branches is followed by itself, too: from the origin, and from the tried point where it is least.

use crate::estimate::conditional::effective_number;
use crate::estimate::weighted::Event;
use crate::rare::exploration::{Explored, Search};
use crate::rare::gaussian::Gaussian;
use crate::rare::mixture::Group;
use crate::rare::points::Points;
use crate::rare::population::SPREAD;
use crate::rare::scatters::square;
use crate::special_functions::normal;

/// Largest number of starts beside the origin, the least distance between two over that of the farther from the origin, and
/// the least difference between what is known and what was found at them, over the sum of both.
const MOST_STARTS: usize = 6;
const LEAST_APART: f64 = 0.5;
const LEAST_SURPRISE: f64 = 0.1;

/// Largest number of steps from a start, and of halvings of a step.
const MOST_STEPS: usize = 10;
const MOST_HALVINGS: usize = 4;

/// The distance of the points of a difference.
const DIFFERENCE: f64 = 0.01;

/// The distance below which a step is the last, and that below which two steps lead to one design point.
const CLOSE: f64 = 0.1;
const SAME: f64 = 0.5;

/// A branch matters up to this distance of its design point from the origin, by its limit state there or by that point itself.
const FARTHEST_BRANCH: f64 = 9.0;

/// Samples around a design point; their effective number over this, and the factor between the probabilities that they and
/// the linear limit state give, where they agree.
const SAMPLES: usize = 40;
const LEAST_EFFECTIVE: f64 = 0.15;
const MOST_FACTOR: f64 = 3.0;

/// The share of the variance along the design point that is replaced by that of the inputs.
const LEAST_SHARE: f64 = 0.03;

/// A region around a design point.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    /// Its probability, from the samples.
    pub probability: f64,
    /// Its density.
    pub density: Gaussian,
    /// Whose region it is.
    pub event: Event,
    /// Whether the samples, and the points that were tried, are what the linear limit state makes of them.
    pub is_plane: bool,
}

impl Region {
    /// The region as a group of a mixture.
    #[must_use]
    pub fn group(&self) -> Group {
        Group { share: self.probability, density: self.density.clone() }
    }
}

/// Points from which steps lead to design points.
type Starts = Vec<Vec<f64>>;

/// A limit state that is linear around a point.
struct Linear {
    gradient: Vec<f64>,
    /// `|a|^2 + e`
    scale: f64,
    /// `c`, but below zero too.
    offset: f64,
}

impl Linear {
    /// From the limit state at a point and at those beside it, with `e`; `None` if it has no gradient there.
    fn new(point: &[f64], states: &[f64], extra: f64) -> Option<Self> {
        let (here, beside) = states.split_first()?;
        let gradient: Vec<f64> = beside.iter().map(|state| (state - here) / DIFFERENCE).collect();
        let scale = square(&gradient) + extra;
        let along: f64 = gradient.iter().zip(point).map(|(slope, u)| slope * u).sum();
        let offset = here - along;
        (scale > 0.0 && scale.is_finite() && offset.is_finite()).then_some(Self { gradient, scale, offset })
    }

    fn target(&self) -> Vec<f64> {
        let factor = -self.offset.max(0.0) / self.scale;
        self.gradient.iter().map(|slope| factor * slope).collect()
    }

    /// The distance of the design point from the origin, with `xi` as one more deviate; below zero if the event happens there.
    fn beta(&self) -> f64 {
        self.offset / self.scale.sqrt()
    }

    /// The limit state of the plane at a point.
    fn at(&self, point: &[f64]) -> f64 {
        self.offset + self.gradient.iter().zip(point).map(|(slope, u)| slope * u).sum::<f64>()
    }

    /// The law of the deviates where the event happens: the mean, and the variance along it.
    fn density(&self) -> Option<Gaussian> {
        let beta = self.beta();
        // The mean and the variance of a standard normal deviate above the distance.
        let mean = normal::density(beta) / normal::upper_tail(beta);
        let variance = 1.0 + beta * mean - mean * mean;
        let along = square(&self.gradient) / self.scale;
        let variance = along * variance + 1.0 - along;
        let factor = -mean / self.scale.sqrt();
        Gaussian::along(
            self.gradient.iter().map(|slope| factor * slope).collect(),
            (1.0 - LEAST_SHARE) * variance + LEAST_SHARE,
        )
    }
}

/// What a point is worth on the way to a design point: less is better.
fn merit(point: &[f64], limit_state: f64, value: Option<f64>, penalty: f64) -> f64 {
    let of_state = match value {
        Some(value) if limit_state.is_nan() && value >= 1.0 => 0.0,
        Some(_) if limit_state.is_nan() => f64::INFINITY,
        Some(value) if is_conditional(value) => 0.5 * limit_state.max(0.0) * limit_state.max(0.0),
        Some(_) => penalty * limit_state.max(0.0),
        None => f64::INFINITY,
    };
    0.5 * square(point) + of_state
}

/// Whether `g` is neither of both verdicts.
fn is_conditional(value: f64) -> bool {
    0.0 < value && value < 1.0
}

/// A point, and those beside it whose differences from it make a gradient.
fn differences(point: &[f64]) -> Points {
    let mut points = Points::new(point.len());
    points.push(point.iter().copied());
    for moved in 0..point.len() {
        points.push(point.iter().enumerate().map(|(i, u)| if i == moved { u + DIFFERENCE } else { *u }));
    }
    points
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

/// The point that was tried, apart from other starts, that differs most from the planes that are known: its limit state is the
/// farthest below all of them, the nearest first where that is below zero and they are not.
fn most_surprising<'e>(explored: &'e Explored, known: &[Linear], starts: &[&[f64]]) -> Option<&'e [f64]> {
    let is_apart = |point: &[f64], other: &[f64]| {
        let farther = square(point).max(square(other)).sqrt();
        distance(point, other) > LEAST_APART * farther
    };
    let surprise = |point: &[f64], state: f64| {
        let expected = known.iter().map(|plane| plane.at(point)).fold(f64::INFINITY, f64::min);
        match expected {
            _ if state < 0.0 && expected > 0.0 => 1.0 + 1.0 / (1.0 + square(point)),
            f64::INFINITY => 1.0 / (1.0 + state),
            _ if expected <= 0.0 => 0.0,
            _ => (expected - state) / (expected + state),
        }
    };
    let candidates = explored.with_limit_state.iter().map(|(point, state)| (&point[..], surprise(point, *state)));
    let candidates = candidates.filter(|(_, surprise)| *surprise > LEAST_SURPRISE);
    let apart = candidates.filter(|(point, _)| starts.iter().all(|start| is_apart(point, start)));
    apart.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(point, _)| point)
}

impl Search<'_> {
    /// The regions to which the limit state leads; `None` if it is stopped before.
    pub(super) fn design_points(&mut self, explored: &Explored) -> Option<Vec<Region>> {
        let origin = vec![0.0; self.dimensions()];
        let mut found: Vec<Linear> = self.design_point(&origin, &[])?.into_iter().collect();
        let mut starts: Vec<&[f64]> = Vec::new();
        while starts.len() < MOST_STARTS {
            let Some(start) = most_surprising(explored, &found, &starts) else { break };
            starts.push(start);
            let linear = self.design_point(start, &found)?;
            found.extend(linear);
        }
        if self.event() == Event::Instability && self.branches() > 0 {
            for (branch, starts) in self.branch_starts(explored)?.into_iter().enumerate() {
                found.extend(self.design_point_of(branch, &starts, &found)?);
            }
        }
        let mut regions = Vec::new();
        for linear in &found {
            let Some(density) = linear.density() else { continue };
            let region = self.region(linear, density, explored)?;
            // A region that is small in all directions is met by none of the samples around its design point.
            regions.push(if region.probability > 0.0 { region } else { self.fitted(&region, explored)? });
        }
        regions.retain(|region| region.probability > 0.0);
        Some(regions)
    }

    /// From where steps are to lead to a design point of each branch, in this order: from the origin, if the plane that its limit
    /// state is about there is near enough, and from the tried point with the least, if that is below zero or the origin is a
    /// start. A branch without a start is nowhere near the event. `None` if it is stopped before.
    ///
    /// What is computed at a point serves all branches, so that their number costs nothing here.
    fn branch_starts(&mut self, explored: &Explored) -> Option<Vec<Starts>> {
        let origin = vec![0.0; self.dimensions()];
        let at_origin = self.branch_states(&differences(&origin))?;
        let mut tried = Points::new(self.dimensions());
        explored.with_limit_state.iter().for_each(|(point, _)| tried.push(point.iter().copied()));
        let at_tried = self.branch_states(&tried)?;
        let starts = |branch: usize| {
            let of_branch = |states: &Vec<f64>| states.get(branch).copied().unwrap_or(f64::NAN);
            let around_origin: Vec<f64> = at_origin.iter().map(of_branch).collect();
            let plane = Linear::new(&origin, &around_origin, 0.0);
            let is_near = plane.is_some_and(|plane| plane.beta() < FARTHEST_BRANCH);
            let states = tried.iter().zip(at_tried.iter().map(of_branch)).filter(|(_, state)| !state.is_nan());
            let least = states.min_by(|a, b| a.1.total_cmp(&b.1));
            let least = least.filter(|(_, state)| is_near || *state < 0.0);
            let from_origin = is_near.then(|| origin.clone());
            from_origin.into_iter().chain(least.map(|(point, _)| point.to_vec())).collect::<Starts>()
        };
        Some((0..self.branches()).map(starts).collect())
    }

    /// The limit state of a branch around the first design point to which steps lead from one of these starts; as
    /// [`Search::design_point`].
    fn design_point_of(&mut self, branch: usize, starts: &[Vec<f64>], found: &[Linear]) -> Option<Option<Linear>> {
        self.select(Some(branch));
        let mut linear = Some(None);
        for start in starts {
            linear = self.design_point(start, found);
            if !matches!(linear, Some(None)) {
                break;
            }
        }
        self.select(None);
        Some(linear?.filter(|linear| linear.beta() < FARTHEST_BRANCH))
    }

    /// The limit state around the design point to which steps lead; the inner `None` if they lead to one that is known or
    /// to none, the outer one if it is stopped before.
    fn design_point(&mut self, start: &[f64], found: &[Linear]) -> Option<Option<Linear>> {
        let mut point = start.to_vec();
        for _ in 0..MOST_STEPS {
            let Some((linear, state, value)) = self.linear(&point)? else { return Some(None) };
            let target = linear.target();
            if distance(&target, &point) < CLOSE {
                let is_known = found.iter().any(|known| distance(&known.target(), &target) < SAME);
                return Some((!is_known).then_some(linear));
            }
            let penalty = 2.0 * square(&target).max(square(&point)).max(1.0).sqrt() / linear.scale.sqrt();
            let before = merit(&point, state, value, penalty);
            let mut share = 1.0;
            let mut next = None;
            for _ in 0..=MOST_HALVINGS {
                let tried: Vec<f64> = point.iter().zip(&target).map(|(from, to)| from + share * (to - from)).collect();
                let mut points = Points::new(self.dimensions());
                points.push(tried.iter().copied());
                let (values, states) = self.evaluate_limit_states(&points)?;
                if merit(&tried, states[0], values[0], penalty) < before {
                    next = Some(tried);
                    break;
                }
                share *= 0.5;
            }
            let Some(next) = next else { return Some(None) };
            point = next;
        }
        Some(None)
    }

    /// The limit state around a point, its value there and `g`; the inner `None` where it has no gradient, the outer one
    /// if it is stopped before.
    fn linear(&mut self, point: &[f64]) -> Option<Option<(Linear, f64, Option<f64>)>> {
        let (values, states) = self.evaluate_limit_states(&differences(point))?;
        let extra = if values[0].is_some_and(is_conditional) { 1.0 } else { 0.0 };
        Some(Linear::new(point, &states, extra).map(|linear| (linear, states[0], values[0])))
    }

    /// What samples say of a region; `None` if it is stopped before.
    fn region(&mut self, linear: &Linear, density: Gaussian, explored: &Explored) -> Option<Region> {
        let [sum, squares] = self.sampled(&density)?;
        let probability = sum / SAMPLES as f64;
        let factor = probability / normal::upper_tail(linear.beta());
        let is_explained = |(point, state): &(Vec<f64>, f64)| *state > 0.0 || linear.at(point) <= 0.0;
        let is_plane = effective_number(sum, squares) >= LEAST_EFFECTIVE * SAMPLES as f64
            && (1.0 / MOST_FACTOR..MOST_FACTOR).contains(&factor)
            && explored.with_limit_state.iter().all(is_explained);
        Some(Region { probability, density, event: self.event(), is_plane })
    }

    /// The same region with a density that is fitted to points which are spread over it from its middle; `None` if it is
    /// stopped before.
    pub(super) fn fitted(&mut self, region: &Region, explored: &Explored) -> Option<Region> {
        let spread = self.spread(&explored.scatters, &[region.density.mean()])?;
        let Some(density) = Gaussian::fit(spread.iter(), &[1.0; SPREAD]) else { return Some(region.clone()) };
        let [sum, _] = self.sampled(&density)?;
        let probability = if sum > 0.0 { sum / SAMPLES as f64 } else { region.probability };
        Some(Region { probability, density, ..region.clone() })
    }

    /// The sum of what samples with a density count for in the event, and that of the squares; `None` if it is stopped before.
    fn sampled(&mut self, density: &Gaussian) -> Option<[f64; 2]> {
        let dimensions = self.dimensions();
        let mut points = Points::new(dimensions);
        for _ in 0..SAMPLES {
            let mut point: Vec<f64> = (0..dimensions).map(|_| self.deviate()).collect();
            density.transform(&mut point);
            points.push(point);
        }
        let values = self.evaluate(&points)?;
        let mut scratch = vec![0.0; dimensions];
        let (mut sum, mut squares) = (0.0, 0.0);
        for (point, value) in points.iter().zip(values) {
            let ratio = libm::exp(-0.5 * square(point) - density.log_density(point, &mut scratch));
            let term = ratio * value.unwrap_or(0.0);
            sum += term;
            squares += term * term;
        }
        Some([sum, squares])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rare::exploration::Effort;
    use crate::rare::points::{ConditionalProbability, Integrand, LimitState};
    use rand::SeedableRng;
    use rand_xoshiro::Xoshiro256PlusPlus;

    /// The regions that a search finds, and the number of its evaluations.
    fn regions(inputs: usize, seed: u64, integrand: &mut dyn Integrand) -> (Vec<Region>, u64) {
        let mut generator = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut search = Search::new(inputs, Effort { particles: 300, moves: 4 }, &mut generator, integrand);
        let explored = search.explore_limit_states(40).unwrap();
        let regions = search.design_points(&explored).unwrap();
        (regions, search.evaluations())
    }

    #[test]
    fn densities_have_the_moments_of_the_region_of_a_plane() {
        // With scipy 1.14: truncnorm(3, inf).mean() and var().
        let (mean, variance) = (3.283_098_654_930_44, 0.070_559_186_785_255_86);
        let verdict = Linear { gradient: vec![0.0, -2.0], scale: 4.0, offset: 6.0 };
        let density = verdict.density().unwrap();
        assert!((density.mean()[1] - mean).abs() < 1e-9 && density.mean()[0] == 0.0);
        assert!((density.variance_along_mean() - (0.97 * variance + 0.03)).abs() < 1e-9);
        // With a further deviate of the same weight, it shares mean and excess of the variance with the other.
        let conditional = Linear { gradient: vec![0.0, -1.0], scale: 2.0, offset: 3.0 * 2.0_f64.sqrt() };
        let density = conditional.density().unwrap();
        assert!((density.mean()[1] - mean / 2.0_f64.sqrt()).abs() < 1e-9);
        assert!((density.variance_along_mean() - (0.97 * 0.5 * (1.0 + variance) + 0.03)).abs() < 1e-9);
    }

    #[test]
    fn a_plane_has_one_region_after_some_four_hundred_evaluations() {
        for inputs in [1, 2, 10, 20] {
            let root = libm::sqrt(inputs as f64);
            let mut plane = LimitState(|u: &[f64]| 5.0 - u.iter().sum::<f64>() / root);
            // The sum of the others exceeds 5 roots, less a further deviate of the same weight.
            let given = |u: &[f64]| normal::upper_tail(5.0 * 2.0_f64.sqrt() - u.iter().sum::<f64>() / root);
            let mut conditional =
                ConditionalProbability(|points: &Points| Some(points.iter().map(|u| Some(given(u))).collect()));
            for integrand in [&mut plane as &mut dyn Integrand, &mut conditional] {
                let (regions, evaluations) = regions(inputs, 1, integrand);
                let [region] = &regions[..] else { panic!("{inputs} inputs: {} regions", regions.len()) };
                assert!(region.is_plane && evaluations < 400 + 8 * inputs as u64, "{inputs} inputs: {evaluations}");
                let factor = region.probability / normal::upper_tail(5.0);
                assert!((0.5..2.0).contains(&factor), "{inputs} inputs: {factor}");
            }
        }
    }

    #[test]
    fn branches_of_like_weight_have_design_points() {
        let mut found = 0;
        for seed in 0..20 {
            let branches = |u: &[f64]| (4.0 - u[0]).min(4.2 + u[0]).min(4.1 - (u[1] + u[2]) / 2.0_f64.sqrt());
            let (regions, _) = regions(5, seed, &mut LimitState(branches));
            // The means of a standard normal deviate above 4, 4.1 and 4.2.
            for region in &regions {
                let distance = square(region.density.mean()).sqrt();
                assert!([4.2256, 4.3207, 4.4160].iter().any(|mean| (distance - mean).abs() < 2e-3), "{distance}");
            }
            assert!(regions.len() > 1, "seed {seed}");
            found += regions.len();
        }
        assert!(found >= 55, "{found} of 60");
    }

    /// Branches, and a limit state of the whole that is that of the first alone: nothing else leads to the others.
    struct Hidden<S> {
        states: S,
        count: usize,
        selected: usize,
    }

    impl<S: Fn(&[f64]) -> Vec<f64>> Integrand for Hidden<S> {
        fn values(&mut self, points: &Points) -> Option<Vec<Option<f64>>> {
            let is_unstable = |point: &[f64]| (self.states)(point).iter().any(|state| *state < 0.0);
            Some(points.iter().map(|point| Some(f64::from(u8::from(is_unstable(point))))).collect())
        }

        fn limit_states(&mut self, points: &Points, _: &[Option<f64>]) -> Option<Vec<f64>> {
            Some(points.iter().map(|point| (self.states)(point)[self.selected]).collect())
        }

        fn branches(&mut self) -> usize {
            self.count
        }

        fn select(&mut self, branch: Option<usize>) {
            self.selected = branch.unwrap_or(0);
        }

        fn branch_states(&mut self, points: &Points) -> Option<Vec<Vec<f64>>> {
            Some(points.iter().map(&self.states).collect())
        }
    }

    /// Whether the mean of a region is near a point.
    fn is_around(region: &Region, point: &[f64]) -> bool {
        distance(region.density.mean(), point) < 0.6
    }

    #[test]
    fn a_region_that_another_branch_hides_has_a_design_point() {
        // A plane whose limit state is small everywhere, and a sphere of radius 2 around a point at 4.5, from outside of which
        // it is far. The second mode has the more probable region by two orders of magnitude.
        let states = |u: &[f64]| {
            let sphere = square(u) - 4.5 * u[1..].iter().sum::<f64>() + 4.5 * 4.5 - 4.0;
            vec![0.025 * (4.5 - u[0]), sphere / 3.3]
        };
        for seed in 0..20 {
            let mut hidden = Hidden { states, count: 2, selected: 0 };
            let (regions, _) = regions(5, seed, &mut hidden);
            assert_eq!(hidden.selected, 0, "the limit state of the whole is asked for again");
            // The means of a standard normal deviate above 4.5, and above 2.5, which is shared by four inputs.
            assert!(regions.iter().any(|region| is_around(region, &[4.7, 0.0, 0.0, 0.0, 0.0])), "seed {seed}");
            assert!(regions.iter().any(|region| is_around(region, &[0.0, 1.41, 1.41, 1.41, 1.41])), "seed {seed}");
        }
    }

    #[test]
    fn a_branch_that_seems_far_from_the_origin_is_followed_from_a_tried_point_beyond_it() {
        // Flat at the origin, and below zero beyond 5.48 to both sides.
        let states = |u: &[f64]| vec![4.5 - u[0], 30.0 - u[1] * u[1]];
        for seed in 0..10 {
            let (regions, _) = regions(5, seed, &mut Hidden { states, count: 2, selected: 0 });
            let beyond = |side: f64| [0.0, side * 5.65, 0.0, 0.0, 0.0];
            let is_found = |region: &Region| is_around(region, &beyond(1.0)) || is_around(region, &beyond(-1.0));
            assert!(regions.iter().any(is_found), "seed {seed}: {regions:?}");
        }
    }

    #[test]
    fn branches_that_nothing_leads_to_cost_nothing() {
        let with = |far: usize| {
            let states = move |u: &[f64]| [vec![4.5 - u[0], 4.8 - u[1]], vec![50.0 - 0.1 * u[2]; far]].concat();
            let (regions, evaluations) = regions(5, 1, &mut Hidden { states, count: 2 + far, selected: 0 });
            (regions.len(), evaluations)
        };
        assert_eq!(with(0).0, 2);
        assert_eq!(with(50), with(0));
    }

    #[test]
    fn what_one_plane_does_not_explain_is_noticed() {
        // A corner without a design point, which many tried points are in; a disc, which hardly any is in.
        let corner = |u: &[f64]| (5.5 - u[2]).min((3.0 - u[0]).max(3.2 - u[1]));
        let disc = |u: &[f64]| (0.7 * (5.0 - u[2])).min(libm::hypot(u[0] + 4.0, u[1] - 3.0) - 0.6);
        // A probability that rises to 1 far from where it is small and hardly depends on the inputs.
        let jump = |u: &[f64]| normal::upper_tail(5.5 - 0.2 * u[1] - 8.0 * (1.0 + libm::tanh(3.0 * (u[0] - 4.3))));
        let mut jump = ConditionalProbability(|points: &Points| Some(points.iter().map(|u| Some(jump(u))).collect()));
        for inputs in [6, 10, 20] {
            let (mut corner, mut disc) = (LimitState(corner), LimitState(disc));
            let missed = |integrand: &mut dyn Integrand| {
                let is_missed = |seed: &u64| {
                    let (regions, _) = regions(inputs, *seed, integrand);
                    regions.len() == 1 && regions[0].is_plane
                };
                (0..20).filter(is_missed).count()
            };
            let [corner, disc, jump] = [&mut corner as &mut dyn Integrand, &mut disc, &mut jump].map(missed);
            assert!(corner == 0 && disc <= 2 && jump == 0, "{inputs} inputs: {corner} {disc} {jump}");
        }
    }

    #[test]
    fn a_point_without_a_limit_state_is_no_way_to_a_design_point() {
        assert_eq!(merit(&[3.0, 4.0], f64::NAN, Some(0.0), 2.0), f64::INFINITY);
        assert_eq!(merit(&[3.0, 4.0], f64::NAN, None, 2.0), f64::INFINITY);
        assert_eq!(merit(&[3.0, 4.0], f64::NAN, Some(1.0), 2.0), 12.5);
        assert_eq!(merit(&[3.0, 4.0], 0.5, Some(0.0), 2.0), 13.5);
        assert_eq!(merit(&[3.0, 4.0], 1.0, Some(normal::upper_tail(1.0)), 2.0), 13.0);
    }

    #[test]
    fn a_region_that_is_not_that_of_a_plane_is_told() {
        // A narrow paraboloid, a slab behind its nearer face, a ring that surrounds the origin.
        let paraboloid = |u: &[f64]| 4.0 + 0.5 * square(&u[1..]) - u[0];
        let slab = |u: &[f64]| (u[0] - 4.005).abs() - 0.005;
        let ring = |u: &[f64]| 5.0 - square(u).sqrt();
        for seed in 0..10 {
            for mut integrand in
                [LimitState(&paraboloid as &dyn Fn(&[f64]) -> f64), LimitState(&slab), LimitState(&ring)]
            {
                let (regions, _) = regions(6, seed, &mut integrand);
                assert!(regions.len() != 1 || !regions[0].is_plane, "seed {seed}");
            }
        }
    }

    #[test]
    fn without_a_gradient_there_is_no_design_point() {
        let (found, _) = regions(3, 1, &mut LimitState(|u: &[f64]| if u[0] > 3.0 { -1.0 } else { 1.0 }));
        assert!(found.is_empty());
        let (found, _) = regions(3, 1, &mut LimitState(|_: &[f64]| f64::NAN));
        assert!(found.is_empty());
    }
}
