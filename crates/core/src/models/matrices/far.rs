//! Modes far from the regions: how far coefficients may change before one of them comes near.
//!
//! Bounds by norms are twenty times too small here, as strongly damped modes are far from orthogonal. So the changes that
//! are safe are measured: all eigenvalues are computed at changes of each coefficient up and down and of all together, and
//! none may be near a region but those that the series follows. Samples within the ellipsoid of these changes rely on
//! that; others are decided by all their eigenvalues.

use super::quadratic::DenseQuadratic;
use super::region::Region;
use super::series::Followed;
use crate::numerics::eigenvalues::Eigenvalue;

/// Changes that are tried first, in parts of the coefficients of the origin, and how often they are halved.
const LARGEST_CHANGE: f64 = 1.0;
const MOST_HALVINGS: usize = 8;

/// The part of the way to the surface of the ellipsoid that samples may take.
const WITHIN: f64 = 0.75;

/// Signs of changes of all coefficients together that are tried at most; all there are for four coefficients.
const MOST_PATTERNS: usize = 16;

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
        // A mode that passes through a band from one side to the other is not near at both ends of its way.
        let below = |all: &[Eigenvalue]| -> Vec<usize> {
            let is_below = |region: &Region, value: &Eigenvalue| {
                value.im.abs() < region.lowest && value.re.abs() < 0.5 * region.highest
            };
            regions.iter().map(|region| all.iter().filter(|value| is_below(region, value)).count()).collect()
        };
        let below_at_origin = problem.at(origin).eigenvalues().map(|all| below(&all)).unwrap_or_default();
        let is_safe = |delta: &[f64]| {
            let mut coefficients = origin.to_vec();
            changing.iter().zip(delta).for_each(|(&k, delta)| coefficients[k] += delta);
            let (Some(followed), Ok(all)) = (follow(delta), problem.at(&coefficients).eigenvalues()) else {
                return false;
            };
            if below(&all) != below_at_origin {
                return false;
            }
            let mut left: Vec<&Followed> = followed.iter().collect();
            all.into_iter().filter(|value| value.im >= 0.0).all(|value| {
                if regions.iter().all(|region| region.distance(value) >= 0.5 * near) {
                    return true;
                }
                let between = |mode: &Followed| distance(mode.eigenvalue, value);
                let nearest = (0..left.len()).min_by(|&i, &j| between(left[i]).total_cmp(&between(left[j])));
                let nearest = nearest.map(|place| left.swap_remove(place));
                nearest.is_some_and(|mode| between(mode) <= mode.radius.min(0.1 * near) + 1e-9)
            })
        };
        let count = changing.len();
        let mut sizes: Vec<f64> = changing.iter().map(|&k| LARGEST_CHANGE * origin[k].abs()).collect();
        for k in 0..count {
            let single = |size: f64| (0..count).map(move |l| if l == k { size } else { 0.0 }).collect::<Vec<f64>>();
            let mut halvings = 0;
            let is_safe = |size: f64| [1.0, -1.0, 0.5, -0.5].iter().all(|part| is_safe(&single(part * size)));
            while sizes[k] > 0.0 && !is_safe(sizes[k]) {
                halvings += 1;
                sizes[k] = if halvings > MOST_HALVINGS { 0.0 } else { 0.5 * sizes[k] };
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
        for _ in 0..MOST_HALVINGS {
            if count < 2
                || (0..patterns)
                    .all(|pattern| is_safe(&together(pattern, &sizes)) && is_safe(&together(pattern, &half(&sizes))))
            {
                return Self { sizes };
            }
            sizes.iter_mut().for_each(|size| *size *= 0.7);
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

fn distance(a: Eigenvalue, b: Eigenvalue) -> f64 {
    libm::hypot(a.re - b.re, a.im - b.im)
}
