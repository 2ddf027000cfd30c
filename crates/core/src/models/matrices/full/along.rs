//! The pairs of sparse matrices along a path of parameters.

use super::band::KrylovLimit;
use super::quadratic::{Coefficients, Point, Side, SparseQuadratic};
use crate::models::matrices::branches::{Branches, Images, Path, Place};
use crate::models::matrices::error::Error;
use crate::models::matrices::pair::{Complex, Pair};
use crate::models::matrices::region::Region;

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

    fn images(&self, pair: &Pair) -> Images {
        let (zero, one) = (Complex::default(), Complex::new(1.0, 0.0));
        [[one, zero, zero], [zero, one, zero]].map(|factors| {
            let mut image = vec![zero; pair.right.len()];
            self.point.combine(factors, &pair.right, Side::Right, &mut image);
            image
        })
    }

    fn coupling(&self, a: &Pair, b: &Pair) -> Complex {
        let [_, damping, stiffness] = self.derivative.forms(&a.left, &b.right);
        -((a.eigenvalue + b.eigenvalue) * 0.5 * damping + stiffness)
    }
}
