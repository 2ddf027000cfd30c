//! The density from which samples of a rare event are drawn, and their weights.
//!
//! It is a mixture. Each group of a [`Population`], and the region of each design point, has three normal densities around
//! its mean: one with its covariance, one with its variance in the direction of the mean alone, which few points determine
//! well whatever the number of inputs, and one with the standard deviations of the inputs. An eighth of the samples come
//! from the distribution of the inputs itself, so that no weight is above 8 (a defensive mixture: T. Hesterberg,
//! Technometrics 37 (1995) 185-194), and a sixteenth or more from the enlarged scatters with which points were tried, so
//! that a region without a particle can still be met.

use crate::estimate::weighted::{Event, MOST_WEIGHT};
use crate::rare::design_points::Region;
use crate::rare::exploration::{Explored, Search};
use crate::rare::gaussian::Gaussian;
use crate::rare::mixture::{self, Group};
use crate::rare::population::{Population, SPREAD, TRIED};
use crate::special_functions::normal;

/// Shares of the samples: from the distribution of the inputs, from the enlarged ones, also where points are missed that no
/// population came near, so that the scatter of the estimates shows what these have, and of the rest from the
/// densities of the groups with the standard deviations of the inputs, and with their variance along the mean.
const OF_INPUTS: f64 = 1.0 / MOST_WEIGHT;
const ENLARGED: f64 = 1.0 / 16.0;
const ENLARGED_WHERE_MISSED: f64 = 1.0 / 4.0;
const WIDE: f64 = 0.2;
const ALONG: f64 = 0.4;

/// A point that was tried is missed if it adds more than this share to the probability, and if a sample there would count as
/// much as so many others.
const LEAST_MISSED: f64 = 1e-4;
const MOST_TIMES: f64 = 10.0;

/// Particles for each of the points that are tried at an enlargement where there is a limit state.
const PARTICLES_PER_POINT: usize = 8;

/// Largest number of populations whose densities are mixed, and the share of the samples that each gets at least.
const MOST_POPULATIONS: usize = 4;
const LEAST_SHARE: f64 = 0.1;

/// The share of its population that a group with few particles gets at least.
const LEAST_OF_GROUP: f64 = 0.05;

/// One density of the mixture.
#[derive(Debug, Clone, PartialEq)]
struct Component {
    log_share: f64,
    /// A standard normal deviate below this, and not below that of the component before, chooses this component.
    below: f64,
    density: Gaussian,
}

/// The density from which samples are drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Proposal {
    /// The first is the distribution of the inputs.
    components: Vec<Component>,
    /// What is frequent among its samples.
    event: Event,
}

/// What a sample drawn from a [`Proposal`] counts for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weight {
    /// The density of the inputs over that of the proposal, at most [`MOST_WEIGHT`].
    pub weight: f64,
    /// Whether it was drawn from the distribution of the inputs.
    pub is_of_inputs: bool,
}

impl Proposal {
    /// Looks for a proposal; `None` if the search is stopped before.
    ///
    /// Where there is a limit state, its gradient leads to design points. If it leads to a single one, around which the limit
    /// state is about linear, the event is rare, and the few points that were tried have shown nothing else, that is all.
    /// Else, and where there are several limit states, populations are led from many more points. Where points that were tried are missed by the densities so far,
    /// another population is led from these.
    pub fn find(search: &mut Search<'_>) -> Option<Self> {
        let mut regions = Vec::new();
        if search.has_limit_states() {
            let explored = search.explore_limit_states(search.effort().particles.div_ceil(PARTICLES_PER_POINT))?;
            regions = search.design_points(&explored)?;
            // Behind several limit states there may be more than one plane shows.
            if search.branches() == 0
                && let Some(proposal) = Self::around_one_plane(&explored, &regions)
            {
                return Some(proposal);
            }
        }
        Self::around_populations(search, regions)
    }

    /// The proposal for a rare event in one region that is that of a plane; `None` if it is not, or if it misses points.
    fn around_one_plane(explored: &Explored, regions: &[Region]) -> Option<Self> {
        let [region] = regions else { return None };
        if !region.is_plane || explored.scatters.enlargements().len() == 1 {
            return None;
        }
        let proposal = Self::new(explored, &[(region.probability, vec![region.group()])], ENLARGED);
        proposal.missed(explored, region.probability).is_empty().then_some(proposal)
    }

    /// The proposal for populations, and for those of the regions that they miss.
    fn around_populations(search: &mut Search<'_>, mut regions: Vec<Region>) -> Option<Self> {
        let explored = search.explore(TRIED * search.effort().particles)?;
        let mut populations: Vec<(f64, Vec<Group>)> = Vec::new();
        let mut places: Vec<usize> = (0..explored.points.len()).collect();
        loop {
            let Population { particles, probability } = search.lead(&explored, &places)?;
            let mut groups = mixture::groups(&particles);
            let members = mixture::members(&particles, &groups);
            for (group, members) in groups.iter_mut().zip(members) {
                if !members.is_empty() && members.len() < SPREAD {
                    let spread = search.spread(&explored.scatters, &members)?;
                    let density = Gaussian::fit(spread.iter(), &[1.0; SPREAD]);
                    group.density = density.unwrap_or(group.density.clone());
                    group.share = group.share.max(LEAST_OF_GROUP);
                }
            }
            populations.push((probability, groups));
            let proposal = Self::new(&explored, &populations, ENLARGED);
            let probability = populations.iter().map(|(probability, _)| probability).sum();
            places = proposal.missed(&explored, probability);
            if places.is_empty() || populations.len() == MOST_POPULATIONS {
                let enlarged = if places.is_empty() { ENLARGED } else { ENLARGED_WHERE_MISSED };
                regions.retain(|region| region.event == explored.event && proposal.misses(region, probability));
                for region in regions.iter_mut().filter(|region| !region.is_plane) {
                    *region = search.fitted(region, &explored)?;
                }
                if !regions.is_empty() {
                    let probability = regions.iter().map(|region| region.probability).sum();
                    populations.retain(|(_, groups)| !groups.is_empty());
                    populations.push((probability, regions.iter().map(Region::group).collect()));
                }
                return Some(Self::new(&explored, &populations, enlarged));
            }
        }
    }

    /// Whether a region matters, but samples of this proposal hardly ever come near its middle.
    fn misses(&self, region: &Region, probability: f64) -> bool {
        let mean = region.density.mean();
        region.probability > LEAST_MISSED * probability
            && self.weight(mean, &mut vec![0.0; mean.len()]) > MOST_TIMES * probability
    }

    /// The proposal for the groups of populations with their probabilities.
    fn new(explored: &Explored, populations: &[(f64, Vec<Group>)], enlarged: f64) -> Self {
        let total: f64 = populations.iter().map(|(probability, _)| probability).sum();
        let share = |probability: f64| match populations {
            [_] => 1.0,
            _ => LEAST_SHARE + (1.0 - populations.len() as f64 * LEAST_SHARE) * probability / total,
        };
        let rest = if total > 0.0 { 1.0 - OF_INPUTS - enlarged } else { 0.0 };
        let origin = || vec![0.0; explored.points.dimensions()];
        let mut densities = vec![(OF_INPUTS, Gaussian::round(origin(), 1.0))];
        let enlargements = explored.scatters.enlargements();
        let of_each = (1.0 - OF_INPUTS - rest) / enlargements.len() as f64;
        densities.extend(enlargements.iter().map(|scale| (of_each, Gaussian::round(origin(), *scale))));
        for (probability, groups) in populations {
            let of_groups: f64 = groups.iter().map(|group| group.share).sum();
            for group in groups {
                let share = rest * share(*probability) * group.share / of_groups;
                let mean = group.density.mean().to_vec();
                let wide = Gaussian::round(mean.clone(), 1.0);
                let along = Gaussian::along(mean, group.density.variance_along_mean()).unwrap_or(wide.clone());
                densities.push((WIDE * share, wide));
                densities.push((ALONG * share, along));
                densities.push(((1.0 - WIDE - ALONG) * share, group.density.clone()));
            }
        }
        Self::of(densities, explored.event)
    }

    /// The places of points that matter, but that samples of this proposal hardly ever come near.
    fn missed(&self, explored: &Explored, probability: f64) -> Vec<usize> {
        let mut scratch = vec![0.0; explored.points.dimensions()];
        let weights = explored.weights();
        let mut is_missed = |&place: &usize| {
            weights[place] > LEAST_MISSED * probability
                && explored.values[place] * self.weight(explored.points.get(place), &mut scratch)
                    > MOST_TIMES * probability
        };
        (0..weights.len()).filter(|place| is_missed(place)).collect()
    }

    fn of(densities: Vec<(f64, Gaussian)>, event: Event) -> Self {
        let mut sum = 0.0;
        let last = densities.len() - 1;
        debug_assert!(
            (densities.iter().map(|(share, _)| share).sum::<f64>() - 1.0).abs() < 1e-9,
            "shares of a mixture"
        );
        let component = |(i, (share, density)): (usize, (f64, Gaussian))| {
            sum += share;
            let below = if i == last { f64::INFINITY } else { normal::quantile(sum) };
            Component { log_share: libm::log(share), below, density }
        };
        let components = densities.into_iter().enumerate().map(component).collect();
        Self { components, event }
    }

    /// What samples are counted of.
    #[must_use]
    pub fn event(&self) -> Event {
        self.event
    }

    /// Replaces independent standard normal deviates, one more than inputs, by a point of the mixture: the first chooses
    /// the component and is dropped. `scratch` is as long as the point.
    pub fn draw(&self, deviates: &mut Vec<f64>, scratch: &mut [f64]) -> Weight {
        let choice = deviates.remove(0);
        let chosen = self.components.iter().position(|component| choice < component.below).unwrap_or(0);
        self.components[chosen].density.transform(deviates);
        Weight { weight: self.weight(deviates, scratch), is_of_inputs: chosen == 0 }
    }

    /// The density of the inputs at a point over that of the mixture.
    fn weight(&self, point: &[f64], scratch: &mut [f64]) -> f64 {
        let own = -0.5 * point.iter().map(|u| u * u).sum::<f64>();
        let ratio = |component: &Component, scratch: &mut [f64]| {
            libm::exp(component.log_share + component.density.log_density(point, scratch) - own)
        };
        let sum: f64 = self.components.iter().map(|component| ratio(component, scratch)).sum();
        (1.0 / sum).min(MOST_WEIGHT)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::deviates::{DeviateStream, Points as Source};
    use crate::rare::points::Points;
    use crate::rare::scatters::Scatters;

    fn proposal(dimensions: usize, particles: &[&[f64]], enlargement: f64) -> Proposal {
        let mut points = Points::new(dimensions);
        particles.iter().for_each(|particle| points.push(particle.iter().copied()));
        let mut scatters = Scatters::default();
        scatters.add(enlargement);
        let explored = Explored {
            points: Points::new(dimensions),
            values: Vec::new(),
            with_limit_state: Vec::new(),
            scatters,
            tried: 1,
            without_verdict: 0.0,
            event: Event::Instability,
        };
        let probability = if particles.is_empty() { 0.0 } else { 1e-6 };
        Proposal::new(&explored, &[(probability, mixture::groups(&points))], ENLARGED)
    }

    /// The mean of a function of the inputs, by weighted samples.
    fn mean(proposal: &Proposal, dimensions: usize, of: impl Fn(&[f64]) -> f64) -> f64 {
        let stream =
            DeviateStream { seed: 1, common_random_numbers: false, dimensions: dimensions + 1, points: Source::Sobol };
        let samples = 1 << 14;
        let mut scratch = vec![0.0; dimensions];
        let term = |deviates: &[f64]| {
            let mut point = deviates.to_vec();
            let Weight { weight, is_of_inputs } = proposal.draw(&mut point, &mut scratch);
            assert!(weight <= MOST_WEIGHT);
            assert!(!is_of_inputs || deviates[0] < normal::quantile(0.125));
            weight * of(&point)
        };
        stream.draw(0, 0, 0..samples).chunks_exact(dimensions + 1).map(term).sum::<f64>() / samples as f64
    }

    #[test]
    fn weighted_means_are_those_of_the_inputs() {
        let particles: [&[f64]; 4] = [&[4.0, 0.5, 0.0], &[4.1, -0.5, 0.3], &[4.2, 0.1, -0.6], &[4.5, 0.0, 0.3]];
        let proposal = proposal(3, &particles, 2.25);
        assert!((mean(&proposal, 3, |_| 1.0) - 1.0).abs() < 0.01);
        assert!(mean(&proposal, 3, |u| u[1]).abs() < 0.02);
        assert!((mean(&proposal, 3, |u| u[2] * u[2]) - 1.0).abs() < 0.02);
        let tail = mean(&proposal, 3, |u| f64::from(u8::from(u[0] > 4.0)));
        let truth = normal::upper_tail(4.0);
        assert!((tail / truth - 1.0).abs() < 0.02, "{tail:e}, {truth:e}");
    }

    #[test]
    fn without_particles_the_inputs_and_a_larger_scatter_are_left() {
        let proposal = proposal(2, &[], 11.0);
        assert_eq!(proposal.components.len(), 2);
        let tail = mean(&proposal, 2, |u| f64::from(u8::from(u[0] > 3.0)));
        assert!((tail / normal::upper_tail(3.0) - 1.0).abs() < 0.1, "{tail:e}");
    }
}
