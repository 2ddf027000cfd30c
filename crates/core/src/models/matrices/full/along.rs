//! The pairs of sparse matrices along a path of parameters.

use super::band::KrylovLimit;
use super::quadratic::{Coefficients, Point, Side, SparseQuadratic};
use crate::models::matrices::branches::{Branches, Path, Place};
use crate::models::matrices::error::Error;
use crate::models::matrices::pair::{Complex, Pair, dot};
use crate::models::matrices::region::{Region, magnitude};

/// A path through the parameters of given matrices.
#[derive(Clone, Copy)]
pub struct Along<'a> {
    /// The matrices.
    pub matrices: &'a SparseQuadratic,
    /// The path.
    pub path: &'a dyn Path,
    /// How much work all pairs at one place may take.
    pub limit: KrylovLimit,
}

impl<'a> Along<'a> {
    /// The matrices at `p`.
    ///
    /// # Errors
    /// As [`SparseQuadratic::at`].
    pub fn point(&self, p: f64) -> Result<Point<'a>, Error> {
        self.matrices.at(&Coefficients::split(&self.path.coefficients(p), self.matrices.damping_terms()))
    }
}

impl Branches for Along<'_> {
    fn at(&self, p: f64) -> Result<Box<dyn Place + '_>, Error> {
        let derivative = Coefficients::split(&self.path.derivative(p), self.matrices.damping_terms());
        Ok(Box::new(SparsePlace {
            point: self.point(p)?,
            derivative: self.matrices.at(&derivative)?,
            limit: self.limit,
        }))
    }
}

struct SparsePlace<'a> {
    point: Point<'a>,
    /// dQ/dp.
    derivative: Point<'a>,
    limit: KrylovLimit,
}

impl Place for SparsePlace<'_> {
    fn pairs(&self, region: &Region) -> Result<Vec<Pair>, Error> {
        self.point.pairs_about(region, self.limit)
    }

    fn refine(&self, start: &Pair) -> Result<Pair, Error> {
        self.point.refine(start)
    }

    fn overlap(&self, a: &Pair, b: &Pair) -> f64 {
        let one = Complex::new(1.0, 0.0);
        let sum = a.eigenvalue + b.eigenvalue;
        let mut image = vec![Complex::default(); a.right.len()];
        self.point.combine([sum, one, Complex::default()], &b.right, Side::Right, &mut image);
        let forward = dot(&a.left, &image);
        self.point.combine([sum, one, Complex::default()], &a.right, Side::Right, &mut image);
        magnitude(forward * dot(&b.left, &image))
    }

    fn coupling(&self, a: &Pair, b: &Pair) -> Complex {
        let [_, damping, stiffness] = self.derivative.forms(&a.left, &b.right);
        -((a.eigenvalue + b.eigenvalue) * 0.5 * damping + stiffness)
    }
}
