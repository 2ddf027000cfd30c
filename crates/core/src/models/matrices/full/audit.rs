//! What a reduction costs: reduced pairs made full, and full pairs that have no reduced partner.

use nalgebra::DMatrix;

use super::quadratic::{Point, SparseQuadratic};
use crate::models::matrices::error::Error;
use crate::models::matrices::pair::{Complex, Pair};
use crate::models::matrices::region::magnitude;

impl Point<'_> {
    /// The pair of the full matrices that a reduced one stands for, of vectors `z` and `w` in coordinates of the basis V:
    /// inverse iteration from `V z` and `V w`, one or two factorisations. Its eigenvalue less the reduced one is the error of the reduction. If that is large, the reduced pair
    /// may stand for none, and the pair found is another one.
    ///
    /// # Errors
    /// As [`Point::refine`]; [`Error::Request`] if vectors do not fit the basis.
    pub fn lifted(&self, basis: &DMatrix<f64>, reduced: &Pair) -> Result<Pair, Error> {
        let fits = basis.nrows() == self.family().size()
            && [&reduced.right, &reduced.left].iter().all(|vector| vector.len() == basis.ncols());
        if !fits {
            return Err(Error::Request(
                "a basis has a row for each degree of freedom and a column for each coordinate",
            ));
        }
        let lift = |coordinates: &[Complex]| {
            let mut vector = vec![Complex::default(); basis.nrows()];
            for (column, factor) in basis.column_iter().zip(coordinates) {
                vector.iter_mut().zip(column.iter()).for_each(|(sum, value)| *sum += factor * *value);
            }
            vector
        };
        let (right, left) = (lift(&reduced.right), lift(&reduced.left));
        self.refine(&Pair { eigenvalue: reduced.eigenvalue, right, left, error: f64::INFINITY })
    }
}

/// Which full eigenvalues have no reduced partner within `tolerance` of them, relative to it. Each reduced eigenvalue
/// serves one full pair; the nearest are joined first.
#[must_use]
pub fn missing(full: &[Complex], reduced: &[Complex], tolerance: f64) -> Vec<usize> {
    let mut candidates: Vec<(f64, usize, usize)> = Vec::new();
    for (index, own) in full.iter().enumerate() {
        for (other, value) in reduced.iter().enumerate() {
            let distance = magnitude(own - value) / magnitude(*own);
            if distance <= tolerance {
                candidates.push((distance, index, other));
            }
        }
    }
    candidates.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2)));
    let (mut has_partner, mut is_taken) = (vec![false; full.len()], vec![false; reduced.len()]);
    for (_, index, other) in candidates {
        if !has_partner[index] && !is_taken[other] {
            has_partner[index] = true;
            is_taken[other] = true;
        }
    }
    (0..full.len()).filter(|&index| !has_partner[index]).collect()
}

impl SparseQuadratic {
    /// The share of a vector, by mass, that a basis orthonormal by mass can represent: 1 for all of it.
    #[must_use]
    pub fn captured(&self, basis: &DMatrix<f64>, vector: &[Complex]) -> f64 {
        let parts =
            [vector.iter().map(|value| value.re).collect::<Vec<_>>(), vector.iter().map(|value| value.im).collect()];
        let (mut inside, mut all) = (0.0, 0.0);
        for part in &parts {
            let image = self.mass_times(part);
            all += part.iter().zip(&image).map(|(a, b)| a * b).sum::<f64>();
            for column in basis.column_iter() {
                let factor: f64 = column.iter().zip(&image).map(|(a, b)| a * b).sum();
                inside += factor * factor;
            }
        }
        if all > 0.0 { inside / all } else { 0.0 }
    }
}
