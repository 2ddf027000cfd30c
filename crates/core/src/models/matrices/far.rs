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

/// Signs of changes of all coefficients together.
const SIGN_PATTERNS: usize = 6;

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
        let is_safe = |delta: &[f64]| {
            let mut coefficients = origin.to_vec();
            changing.iter().zip(delta).for_each(|(&k, delta)| coefficients[k] += delta);
            let (Some(followed), Ok(all)) = (follow(delta), problem.at(&coefficients).eigenvalues()) else {
                return false;
            };
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
        let together = |pattern: usize, sizes: &[f64]| -> Vec<f64> {
            let part = 1.0 / (count as f64).sqrt();
            let sign = |k: usize| if (k * (pattern + 1) + pattern * pattern / 2) % 3 == 0 { -part } else { part };
            sizes.iter().enumerate().map(|(k, size)| sign(k) * size).collect()
        };
        for _ in 0..MOST_HALVINGS {
            if count < 2 || (0..SIGN_PATTERNS).all(|pattern| is_safe(&together(pattern, &sizes))) {
                return Self { sizes };
            }
            sizes.iter_mut().for_each(|size| *size *= 0.7);
        }
        Self { sizes: vec![0.0; count] }
    }

    /// Whether changes lie within the ellipsoid of those that are safe.
    pub(super) fn contain(&self, delta: &[f64]) -> bool {
        let part = |(delta, size): (&f64, &f64)| if *delta == 0.0 { 0.0 } else { (delta / size) * (delta / size) };
        delta.iter().zip(&self.sizes).map(part).sum::<f64>() <= 1.0
    }
}

fn distance(a: Eigenvalue, b: Eigenvalue) -> f64 {
    libm::hypot(a.re - b.re, a.im - b.im)
}
