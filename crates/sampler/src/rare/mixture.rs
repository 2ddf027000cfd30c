//! Points as a mixture of normal densities, so that branches and islands keep a density each.
//!
//! The number of groups is the one with the least information criterion (G. Schwarz, Annals of Statistics 6 (1978)
//! 461-464). The densities are fitted by expectation and maximisation (A. P. Dempster, N. M. Laird, D. B. Rubin, J. R.
//! Stat. Soc. B 39 (1977) 1-38), from groups around points that lie far from each other.

use crate::rare::gaussian::Gaussian;
use crate::rare::points::Points;

/// Largest number of groups.
const MOST_GROUPS: usize = 4;

/// Rounds of a fit.
const ROUNDS: usize = 15;

/// Rounds in which points go to the nearest centre first.
const FIRST_ROUNDS: usize = 5;

/// Smallest share of the points that a group has.
const SMALLEST_SHARE: f64 = 0.01;

/// A group: its share of the points, and their density.
#[derive(Debug, Clone, PartialEq)]
pub struct Group {
    /// The share.
    pub share: f64,
    /// The density.
    pub density: Gaussian,
}

/// The groups of points; none without points.
#[must_use]
pub fn groups(points: &Points) -> Vec<Group> {
    let mut best: Option<(f64, Vec<Group>)> = None;
    for count in 1..=MOST_GROUPS.min(points.len()) {
        let Some((log_likelihood, groups)) = fit(points, count) else { continue };
        let size = points.dimensions() as f64;
        let parameters = count as f64 * (1.0 + 2.0 * size) - 1.0;
        let criterion = parameters * libm::log(points.len() as f64) - 2.0 * log_likelihood;
        if best.as_ref().is_none_or(|best| criterion < best.0) {
            best = Some((criterion, groups));
        }
    }
    best.map(|(_, groups)| groups).unwrap_or_default()
}

/// The points of each group: those that it has the largest share in.
#[must_use]
pub fn members<'p>(points: &'p Points, groups: &[Group]) -> Vec<Vec<&'p [f64]>> {
    let mut shares = vec![vec![0.0; points.len()]; groups.len()];
    expect(points, groups, &mut shares);
    let mut members = vec![Vec::new(); groups.len()];
    for (i, point) in points.iter().enumerate() {
        let own = (0..groups.len()).max_by(|a, b| shares[*a][i].total_cmp(&shares[*b][i]));
        members[own.unwrap_or(0)].push(point);
    }
    members
}

/// So many groups, and the logarithm of the likelihood of the points. `None` if a group vanishes.
fn fit(points: &Points, count: usize) -> Option<(f64, Vec<Group>)> {
    let mut shares = nearest(points, &centres(points, count));
    let mut groups = maximise(points, &shares)?;
    let mut log_likelihood = f64::NEG_INFINITY;
    for _ in 0..if count == 1 { 1 } else { ROUNDS } {
        log_likelihood = expect(points, &groups, &mut shares);
        groups = maximise(points, &shares)?;
    }
    Some((log_likelihood, groups))
}

/// Centres of groups: the point farthest from the mean of all, then each time the one farthest from the centres so far,
/// each moved to the mean of the points that are nearest to it.
fn centres(points: &Points, count: usize) -> Vec<Vec<f64>> {
    let mut mean = vec![0.0; points.dimensions()];
    for point in points.iter() {
        mean.iter_mut().zip(point).for_each(|(sum, u)| *sum += u / points.len() as f64);
    }
    if count == 1 {
        return vec![mean];
    }
    let mut centres: Vec<Vec<f64>> = Vec::new();
    while centres.len() < count {
        let from = |point: &[f64]| match centres.as_slice() {
            [] => square_distance(point, &mean),
            centres => centres.iter().map(|centre| square_distance(point, centre)).fold(f64::INFINITY, f64::min),
        };
        let farthest = points.iter().max_by(|a, b| from(a).total_cmp(&from(b))).map(<[f64]>::to_vec);
        centres.extend(farthest);
    }
    for _ in 0..FIRST_ROUNDS {
        let shares = nearest(points, &centres);
        for (centre, shares) in centres.iter_mut().zip(&shares) {
            let total: f64 = shares.iter().sum();
            if total > 0.0 {
                centre.fill(0.0);
                for (point, share) in points.iter().zip(shares) {
                    centre.iter_mut().zip(point).for_each(|(sum, u)| *sum += share / total * u);
                }
            }
        }
    }
    centres
}

fn square_distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

/// 1 for the points that are nearest to a centre, 0 for the others, centre by centre.
fn nearest(points: &Points, centres: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mut shares = vec![vec![0.0; points.len()]; centres.len()];
    for (i, point) in points.iter().enumerate() {
        let distance = |&centre: &usize| square_distance(point, &centres[centre]);
        let nearest = (0..centres.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        if let Some(nearest) = nearest {
            shares[nearest][i] = 1.0;
        }
    }
    shares
}

/// The densities of groups that have these shares of each point; `None` if one is too small.
fn maximise(points: &Points, shares: &[Vec<f64>]) -> Option<Vec<Group>> {
    let group = |shares: &Vec<f64>| {
        let share = shares.iter().sum::<f64>() / points.len() as f64;
        let density = Gaussian::fit(points.iter(), shares)?;
        (share >= SMALLEST_SHARE).then_some(Group { share, density })
    };
    shares.iter().map(group).collect()
}

/// The share of each group in each point, and the logarithm of the likelihood of the points.
fn expect(points: &Points, groups: &[Group], shares: &mut [Vec<f64>]) -> f64 {
    let mut log_likelihood = 0.0;
    let mut scratch = vec![0.0; points.dimensions()];
    let mut logarithms = vec![0.0; groups.len()];
    for (i, point) in points.iter().enumerate() {
        for (logarithm, group) in logarithms.iter_mut().zip(groups) {
            *logarithm = libm::log(group.share) + group.density.log_density(point, &mut scratch);
        }
        let most = logarithms.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let sum: f64 = logarithms.iter().map(|logarithm| libm::exp(logarithm - most)).sum();
        log_likelihood += most + libm::log(sum);
        for (shares, logarithm) in shares.iter_mut().zip(&logarithms) {
            shares[i] = libm::exp(logarithm - most) / sum;
        }
    }
    log_likelihood
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_distr::StandardNormal;
    use rand_xoshiro::Xoshiro256PlusPlus;

    fn drawn(groups: &[(f64, f64)], dimensions: usize, count: usize) -> Points {
        let mut generator = Xoshiro256PlusPlus::seed_from_u64(7);
        let mut points = Points::new(dimensions);
        for i in 0..count {
            let (mean, std) = groups[i % groups.len()];
            let point: Vec<f64> = (0..dimensions)
                .map(|k| {
                    if k == 0 {
                        mean + std * generator.sample::<f64, _>(StandardNormal)
                    } else {
                        generator.sample(StandardNormal)
                    }
                })
                .collect();
            points.push(point);
        }
        points
    }

    #[test]
    fn groups_far_apart_are_separated() {
        for dimensions in [1, 2, 10, 20] {
            let found = groups(&drawn(&[(5.0, 0.2), (-5.5, 0.2)], dimensions, 300));
            let mut means: Vec<f64> = found.iter().map(|group| group.density.mean()[0]).collect();
            means.sort_by(f64::total_cmp);
            assert_eq!(found.len(), 2, "{dimensions} inputs: {means:?}");
            assert!((means[0] + 5.5).abs() < 0.1 && (means[1] - 5.0).abs() < 0.1, "{means:?}");
            assert!(found.iter().all(|group| (group.share - 0.5).abs() < 1e-9));
        }
    }

    #[test]
    fn one_cloud_is_one_group() {
        for dimensions in [1, 5, 20] {
            assert_eq!(groups(&drawn(&[(6.0, 0.3)], dimensions, 300)).len(), 1, "{dimensions} inputs");
        }
    }

    #[test]
    fn no_points_have_no_groups() {
        assert!(groups(&Points::new(3)).is_empty());
    }
}
