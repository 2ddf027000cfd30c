//! The scatters with which points are tried.

/// Normal deviates that are enlarged by one of some factors, each as often as any other.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Scatters(Vec<f64>);

impl Scatters {
    /// The factors.
    #[must_use]
    pub fn enlargements(&self) -> &[f64] {
        &self.0
    }

    /// Adds a factor.
    pub fn add(&mut self, enlargement: f64) {
        self.0.push(enlargement);
    }

    /// The logarithm of the density of the inputs over that of these scatters, at a point with this sum of squares.
    #[must_use]
    pub fn log_ratio(&self, square: f64, dimensions: usize) -> f64 {
        let (most, sum, _) = self.sums(square, dimensions);
        -0.5 * square - most - libm::log(sum / self.0.len() as f64)
    }

    /// The precision of the normal density around zero that falls at this sum of squares as that of these scatters does.
    #[must_use]
    pub fn precision(&self, square: f64, dimensions: usize) -> f64 {
        let (_, sum, precisions) = self.sums(square, dimensions);
        precisions / sum
    }

    /// The largest logarithm of the densities of the factors; the sum of the densities relative to it, as it is and with
    /// the precision of each.
    fn sums(&self, square: f64, dimensions: usize) -> (f64, f64, f64) {
        let logarithm = |scale: f64| -0.5 * square / (scale * scale) - dimensions as f64 * libm::log(scale);
        let most = self.0.iter().map(|scale| logarithm(*scale)).fold(f64::NEG_INFINITY, f64::max);
        let (mut sum, mut precisions) = (0.0, 0.0);
        for &scale in &self.0 {
            let density = libm::exp(logarithm(scale) - most);
            sum += density;
            precisions += density / (scale * scale);
        }
        (most, sum, precisions)
    }
}

/// The sum of squares of a point.
#[must_use]
pub fn square(point: &[f64]) -> f64 {
    point.iter().map(|u| u * u).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratio_and_precision_are_those_of_the_mean_of_the_densities() {
        let mut scatters = Scatters::default();
        scatters.add(1.0);
        assert_eq!(scatters.log_ratio(7.0, 3), 0.0);
        scatters.add(2.0);
        // In two dimensions: exp(-r^2 / 2) and exp(-r^2 / 8) / 4.
        let density = |square: f64| 0.5 * ((-0.5 * square).exp() + 0.25 * (-0.125 * square).exp());
        for square in [0.0_f64, 1.0, 9.0, 100.0] {
            let ratio = (-0.5 * square).exp() / density(square);
            assert!((scatters.log_ratio(square, 2) - ratio.ln()).abs() < 1e-12 * (1.0 + square));
            let h = 1e-4;
            let slope = (density(square + h).ln() - density(square - h).ln()) / (2.0 * h);
            assert!((scatters.precision(square, 2) + 2.0 * slope).abs() < 1e-7, "{square}");
        }
    }
}
