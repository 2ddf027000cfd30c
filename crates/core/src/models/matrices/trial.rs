//! Random problems for tests.

use nalgebra::{DMatrix, dmatrix, dvector};

use super::quadratic::DenseQuadratic;
use super::region::Region;

/// A sequence of numbers from -1 to 1.
pub(super) struct Numbers(pub(super) u64);

impl Numbers {
    pub(super) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// Nearly normal, with variance 1.
    pub(super) fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.next()).sum::<f64>() / 2.0
    }

    fn matrix(&mut self, size: usize) -> DMatrix<f64> {
        DMatrix::from_fn(size, size, |_, _| self.next())
    }

    fn definite(&mut self, size: usize) -> DMatrix<f64> {
        let root = self.matrix(size);
        &root * root.transpose() + DMatrix::identity(size, size) * 0.1
    }
}

/// A problem with damping, strong damping of some directions, gyroscopic terms, friction and a band.
pub(super) fn problem(seed: u64) -> (DenseQuadratic, Vec<f64>, Region) {
    let mut numbers = Numbers(seed);
    for _ in 0..5 {
        numbers.next();
    }
    let size = 1 + seed as usize % 8;
    let mass = numbers.definite(size);
    let skew = numbers.matrix(size);
    let direction = numbers.matrix(size).column(0).into_owned();
    let damping = [
        numbers.definite(size) * 0.02,
        &direction * direction.transpose() * if seed.is_multiple_of(3) { 8.0 } else { 0.1 },
        (&skew - skew.transpose()) * 0.05,
    ];
    let stiffness = [numbers.definite(size) * 4.0, numbers.matrix(size), numbers.matrix(size) * 0.2];
    let origin = vec![1.0, 1.0, 0.7, 1.0, 0.4, 1.0];
    let problem = DenseQuadratic::new(&mass, &damping, &stiffness, &origin).unwrap();
    let frequency = problem.unit() * (1.0 + numbers.next());
    let region = Region {
        lowest: if seed.is_multiple_of(4) { 0.0 } else { 0.3 * frequency },
        highest: if seed.is_multiple_of(5) { f64::INFINITY } else { 2.0 * frequency },
        damping_ratio: [0.0, -0.01, 0.02][seed as usize % 3],
    };
    let region = region.in_unit(problem.unit());
    (problem, origin, region)
}

/// Two modes with this gap, which friction alone couples, the first with this damping, and a third far off. Coefficients: 1, 1
/// and friction.
pub(super) fn close_modes(gap: f64, damping: f64) -> DenseQuadratic {
    let stiffness = [
        DMatrix::from_diagonal(&dvector![1.0, 1.0 + gap, 9.0]),
        dmatrix![0.0, gap, 0.0; -gap, 0.0, 0.0; 0.0, 0.0, 0.0],
    ];
    let damping = [DMatrix::from_diagonal(&dvector![damping, 4e-4, 0.1])];
    DenseQuadratic::new(&DMatrix::identity(3, 3), &damping, &stiffness, &[1.0; 3]).unwrap()
}
