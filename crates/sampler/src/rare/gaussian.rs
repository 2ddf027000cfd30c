//! Multivariate normal densities.

use crate::lower_triangle::{self, factorise, row_start};

/// The share of a fitted covariance that is replaced by that of the inputs themselves, at least. It widens the density
/// across a boundary, where the points of rare events lie close together, and keeps few points from making it singular.
const LEAST_SHARE: f64 = 0.1;

/// A normal density by its mean and the Cholesky factor of its covariance.
#[derive(Debug, Clone, PartialEq)]
pub struct Gaussian {
    mean: Vec<f64>,
    /// Packed row by row.
    factor: Vec<f64>,
    log_determinant: f64,
}

impl Gaussian {
    /// With the same standard deviation in all directions.
    #[must_use]
    pub fn round(mean: Vec<f64>, std: f64) -> Self {
        let size = mean.len();
        let mut factor = vec![0.0; row_start(size)];
        (0..size).for_each(|i| factor[row_start(i) + i] = std);
        Self { mean, factor, log_determinant: size as f64 * libm::log(std) }
    }

    /// With a variance of its own in the direction of the mean, and 1 across it. `None` if the variance is not above zero.
    #[must_use]
    pub fn along(mean: Vec<f64>, variance: f64) -> Option<Self> {
        let size = mean.len();
        let square: f64 = mean.iter().map(|u| u * u).sum();
        let excess = if square > 0.0 { (variance - 1.0) / square } else { 0.0 };
        let mut covariance = vec![0.0; row_start(size)];
        for i in 0..size {
            for k in 0..=i {
                covariance[row_start(i) + k] = excess * mean[i] * mean[k] + if i == k { 1.0 } else { 0.0 };
            }
        }
        Self::of_covariance(mean, covariance)
    }

    /// Fitted to points with weights. `None` if no weight is above zero.
    #[must_use]
    pub fn fit<'p>(points: impl Iterator<Item = &'p [f64]> + Clone, weights: &[f64]) -> Option<Self> {
        let total: f64 = weights.iter().sum();
        let size = points.clone().next()?.len();
        if total <= 0.0 {
            return None;
        }
        let mut mean = vec![0.0; size];
        for (point, weight) in points.clone().zip(weights) {
            mean.iter_mut().zip(point).for_each(|(sum, u)| *sum += weight / total * u);
        }
        let share = LEAST_SHARE.max(size as f64 / (size as f64 + total));
        let mut covariance = vec![0.0; row_start(size)];
        for (point, weight) in points.zip(weights) {
            for i in 0..size {
                for k in 0..=i {
                    covariance[row_start(i) + k] +=
                        (1.0 - share) * weight / total * (point[i] - mean[i]) * (point[k] - mean[k]);
                }
            }
        }
        (0..size).for_each(|i| covariance[row_start(i) + i] += share);
        Self::of_covariance(mean, covariance)
    }

    /// `None` if the covariance is not positive definite.
    fn of_covariance(mean: Vec<f64>, mut covariance: Vec<f64>) -> Option<Self> {
        let size = mean.len();
        factorise(size, &mut covariance).ok()?;
        let log_determinant = (0..size).map(|i| libm::log(covariance[row_start(i) + i])).sum();
        Some(Self { mean, factor: covariance, log_determinant })
    }

    /// The variance in the direction of the mean.
    #[must_use]
    pub fn variance_along_mean(&self) -> f64 {
        let square: f64 = self.mean.iter().map(|u| u * u).sum();
        if square <= 0.0 {
            return 1.0;
        }
        // |L' m|^2 / |m|^2
        let size = self.mean.len();
        let column = |k: usize| (k..size).map(|i| self.factor[row_start(i) + k] * self.mean[i]).sum::<f64>();
        (0..size).map(|k| column(k) * column(k)).sum::<f64>() / square
    }

    /// The mean.
    #[must_use]
    pub fn mean(&self) -> &[f64] {
        &self.mean
    }

    /// The logarithm of the density, without the term `-n ln(2 pi) / 2` that all densities of `n` inputs share.
    /// `scratch` is as long as the point.
    pub fn log_density(&self, point: &[f64], scratch: &mut [f64]) -> f64 {
        for ((scratch, u), mean) in scratch.iter_mut().zip(point).zip(&self.mean) {
            *scratch = u - mean;
        }
        lower_triangle::solve(&self.factor, scratch);
        -0.5 * scratch.iter().map(|z| z * z).sum::<f64>() - self.log_determinant
    }

    /// Replaces independent standard normal deviates by a point.
    pub fn transform(&self, deviates: &mut [f64]) {
        lower_triangle::multiply(&self.factor, deviates);
        deviates.iter_mut().zip(&self.mean).for_each(|(u, mean)| *u += mean);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn densities_are_those_of_scipy() {
        let points = [[1.0, 0.0], [3.0, 1.0], [2.0, 2.0], [0.0, -1.0]];
        let gaussian = Gaussian::fit(points.iter().map(<[f64; 2]>::as_slice), &[25.0; 4]).unwrap();
        // The covariance of the points is [[1.25, 1], [1, 1.25]]; a tenth of it is replaced. With scipy 1.14:
        // multivariate_normal([1.5, .5], [[1.225, .9], [.9, 1.225]]).logpdf([2.5, 1]) + log(2 pi).
        let density = gaussian.log_density(&[2.5, 1.0], &mut [0.0; 2]);
        assert!((density - -0.271_934_427_522_623_9).abs() < 1e-12, "{density}");
        let mut deviates = [1.0, -1.0];
        gaussian.transform(&mut deviates);
        let expected = -1.0 - gaussian.log_determinant;
        assert!((gaussian.log_density(&deviates, &mut [0.0; 2]) - expected).abs() < 1e-12);
    }

    #[test]
    fn a_density_along_its_mean_has_that_variance() {
        let gaussian = Gaussian::along(vec![3.0, -4.0], 0.25).unwrap();
        assert!((gaussian.variance_along_mean() - 0.25).abs() < 1e-15);
        // One standard deviation from the mean, along and across.
        let at = |u: [f64; 2]| gaussian.log_density(&u, &mut [0.0; 2]);
        let expected = -0.5 + std::f64::consts::LN_2;
        assert!((at([3.3, -4.4]) - expected).abs() < 1e-14 && (at([3.8, -3.4]) - expected).abs() < 1e-14);
        assert!(Gaussian::along(vec![1.0], 0.0).is_none());
    }

    #[test]
    fn a_round_density_has_its_standard_deviation_everywhere() {
        let gaussian = Gaussian::round(vec![1.0, 2.0, 3.0], 2.0);
        let density = gaussian.log_density(&[1.0, 4.0, 3.0], &mut [0.0; 3]);
        assert!((density - (-0.5 - 3.0 * std::f64::consts::LN_2)).abs() < 1e-15);
    }
}
