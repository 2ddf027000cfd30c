//! Modes far from the regions: how far coefficients may change before one of them comes near.
//!
//! Bounds by norms are twenty times too small here, as strongly damped modes are far from orthogonal. So the changes that
//! are safe are measured: all eigenvalues are computed at changes of each coefficient up and down and of all together, and
//! none may be near a region but those that the series follows. Samples within the ellipsoid of these changes rely on
//! that; others are decided by all their eigenvalues.

use super::quadratic::DenseQuadratic;
use super::region::{Region, damping_ratio, magnitude};
use crate::numerics::eigenvalues::Eigenvalue;

/// Changes that are tried first, in parts of the coefficients of the origin, and by what and how often they are made smaller.
const LARGEST_CHANGE: f64 = 1.0;
const SMALLER: f64 = 0.7;
const MOST_STEPS: usize = 15;

/// The damping ratio below which modes that leave a band downwards are told by their number.
const LIGHT_DAMPING: f64 = 0.1;

/// The part of the way to the surface of the ellipsoid that samples may take.
const WITHIN: f64 = 0.75;

/// Signs of changes of all coefficients together that are tried at most; all there are for four coefficients.
const MOST_PATTERNS: usize = 16;

/// An eigenvalue of the series.
#[derive(Debug, Clone, Copy)]
pub(super) struct Followed {
    pub(super) eigenvalue: Eigenvalue,
    /// How far the exact one may be; infinite where the series says nothing.
    pub(super) radius: f64,
    /// How far the one that its vectors of second order give may be.
    pub(super) radius_of_vectors: f64,
    /// The group that it comes from.
    pub(super) group: usize,
}

/// Changes of each coefficient that are safe.
pub(super) struct SafeChanges {
    sizes: Vec<f64>,
}

impl SafeChanges {
    /// Measures the changes that are safe, given what the series says about changes of the coefficients.
    pub(super) fn measured(
        problem: &DenseQuadratic,
        origin: &[f64],
        changing: &[usize],
        regions: &[Region],
        near: f64,
        follow: impl Fn(&[f64]) -> Option<Vec<Followed>>,
    ) -> Self {
        // What the series does not follow must not be near a region, nor have passed through a band from one side to the
        // other: the number of such modes below each band stays, but for strongly damped ones.
        let below = |values: &[Eigenvalue]| -> Vec<usize> {
            let weight = |value: &Eigenvalue| if value.im > 0.0 { 2 } else { 1 };
            let is_below =
                |region: &Region, value: &Eigenvalue| value.im < region.lowest && damping_ratio(*value) < LIGHT_DAMPING;
            let count = |region: &Region| values.iter().filter(|value| is_below(region, value)).map(weight).sum();
            regions.iter().map(count).collect()
        };
        let not_followed = |delta: &[f64]| -> Option<Vec<Eigenvalue>> {
            let mut coefficients = origin.to_vec();
            changing.iter().zip(delta).for_each(|(&k, delta)| coefficients[k] += delta);
            let mut all = problem.at(&coefficients).fast_eigenvalues()?;
            // Zeros are those that are so whatever the coefficients.
            all.retain(|value| value.im >= 0.0 && *value != Eigenvalue::from(0.0));
            for mode in follow(delta)?.iter().filter(|mode| mode.eigenvalue.im > -1e-9) {
                let between = |value: &Eigenvalue| magnitude(mode.eigenvalue - *value);
                let nearest = (0..all.len()).min_by(|&i, &j| between(&all[i]).total_cmp(&between(&all[j])))?;
                let is_near = |value| regions.iter().any(|region| region.distance(value) < 0.5 * near);
                let is_off = between(&all[nearest]) > mode.radius.min(0.1 * near) + 1e-9;
                if is_off && (is_near(all[nearest]) || is_near(mode.eigenvalue)) {
                    return None;
                }
                all.swap_remove(nearest);
            }
            Some(all)
        };
        let Some(at_origin) = not_followed(&vec![0.0; changing.len()]).map(|values| below(&values)) else {
            return Self { sizes: vec![0.0; changing.len()] };
        };
        let is_safe = |delta: &[f64]| {
            let is_far = |value: &Eigenvalue| regions.iter().all(|region| region.distance(*value) >= 0.5 * near);
            not_followed(delta).is_some_and(|values| values.iter().all(is_far) && below(&values) == at_origin)
        };
        let count = changing.len();
        let mut sizes: Vec<f64> = changing.iter().map(|&k| LARGEST_CHANGE * origin[k].abs()).collect();
        for (k, size) in sizes.iter_mut().enumerate() {
            let single = |size: f64| (0..count).map(move |l| if l == k { size } else { 0.0 }).collect::<Vec<f64>>();
            let is_safe = |size: f64| {
                [1.0, 0.7, 0.4].iter().all(|part| is_safe(&single(part * size)) && is_safe(&single(-part * size)))
            };
            let mut steps = 0;
            while *size > 0.0 && !is_safe(*size) {
                steps += 1;
                *size = if steps > MOST_STEPS { 0.0 } else { SMALLER * *size };
            }
        }
        let patterns = 1_usize.checked_shl(count as u32).map_or(MOST_PATTERNS, |all| all.min(MOST_PATTERNS));
        // Beyond four coefficients their signs are spread by a multiplication.
        let signs = |pattern: usize| if count <= 4 { pattern } else { (pattern + 1).wrapping_mul(0x9E37_79B9) >> 3 };
        let half = |sizes: &[f64]| -> Vec<f64> { sizes.iter().map(|size| 0.5 * size).collect() };
        let together = |pattern: usize, sizes: &[f64]| -> Vec<f64> {
            let part = 1.0 / (count as f64).sqrt();
            let sign = |k: usize| if signs(pattern) >> k & 1 == 1 { -part } else { part };
            sizes.iter().enumerate().map(|(k, size)| sign(k) * size).collect()
        };
        for _ in 0..MOST_STEPS {
            if count < 2
                || (0..patterns)
                    .all(|pattern| is_safe(&together(pattern, &sizes)) && is_safe(&together(pattern, &half(&sizes))))
            {
                return Self { sizes };
            }
            sizes.iter_mut().for_each(|size| *size *= SMALLER);
        }
        Self { sizes: vec![0.0; count] }
    }

    /// Whether changes lie within the ellipsoid of those that are safe, with some way left to its surface, which is not safe
    /// in every direction.
    pub(super) fn contain(&self, delta: &[f64]) -> bool {
        let part = |(delta, size): (&f64, &f64)| if *delta == 0.0 { 0.0 } else { (delta / size) * (delta / size) };
        delta.iter().zip(&self.sizes).map(part).sum::<f64>() <= WITHIN * WITHIN
    }
}
