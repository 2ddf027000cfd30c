//! Modes without damping and friction: `K_s x = w^2 M x` with the stiffness that is symmetric.

use faer::linalg::solvers::SolveCore;
use faer::{Conj, Mat, MatMut, Side as Triangle};

use super::quadratic::Point;
use crate::models::matrices::error::Error;

/// Vectors a step adds.
const BLOCK: usize = 2;

/// Residual, relative, at which a mode is taken.
const TOLERANCE: f64 = 1e-9;

/// A mode.
#[derive(Debug, Clone, PartialEq)]
pub struct Mode {
    /// The square of the angular frequency in (rad/s)^2; negative where the symmetric part is not definite.
    pub square: f64,
    /// Its shape, with `x^T M x = 1`.
    pub shape: Vec<f64>,
}

impl Point<'_> {
    /// The stiffness without friction, in the common pattern: the sum of the terms that are symmetric, or, if none is, the
    /// symmetric part of all. (The symmetric part of friction alone can be large, and make the sum indefinite.)
    pub(super) fn symmetric_stiffness(&self) -> Vec<f64> {
        if let Some(sum) = self.family().symmetric_terms(&self.coefficients().stiffness) {
            return sum;
        }
        let values = self.stiffness_values();
        values.iter().zip(self.family().mirrored()).map(|(value, &other)| 0.5 * (value + values[other])).collect()
    }

    /// The modes with squares of the angular frequency up to that of `high` in rad/s, by rising frequency; with `most` vectors
    /// at most, the nearest to the middle of that range if they do not suffice.
    ///
    /// Block Lanczos iteration with `(K_s - s M)^-1 M` (Ericsson and Ruhe, Math. Comp. 35 (1980) 1251), all vectors kept
    /// orthogonal.
    ///
    /// # Errors
    /// What the factorisation says; [`Error::NotConverged`] if the dense eigenproblem fails.
    pub fn modes(&self, high: f64, most: usize) -> Result<Vec<Mode>, Error> {
        let family = self.family();
        let size = family.size();
        // Off half, where frequencies of round ratios could lie.
        let shift = 0.493 * high * high;
        let radius = high * high - shift;
        let values: Vec<f64> =
            self.symmetric_stiffness().iter().zip(family.mass_values()).map(|(k, m)| k - shift * m).collect();
        let lu = family.factorise_real(&values)?;
        let most = most.min(size) / BLOCK * BLOCK;
        let mut basis = Basis { vectors: Vec::new(), images: Vec::new() };
        let mut projected = Mat::<f64>::zeros(most + BLOCK, most);
        let step = |image: &[f64]| {
            let mut vector = image.to_vec();
            lu.solve_in_place_with_conj(Conj::No, MatMut::from_column_major_slice_mut(&mut vector, size, 1));
            vector
        };
        for start in 0..BLOCK as u64 {
            let start = (0..size as u64).map(|index| unstructured(start * size as u64 + index)).collect::<Vec<_>>();
            basis.append(step(&family.mass_times(&start)), |vector| family.mass_times(vector));
        }
        let mut count = 0;
        loop {
            let mut is_complete = false;
            let next = (count + BLOCK).min(basis.vectors.len());
            for column in count..next {
                let (coefficients, is_new) =
                    basis.append(step(&basis.images[column]), |vector| family.mass_times(vector));
                is_complete |= !is_new;
                for (row, value) in coefficients.iter().enumerate() {
                    projected[(row, column)] = *value;
                }
            }
            count = next;
            let is_last = is_complete || count + BLOCK > most;
            if !is_last && !count.is_multiple_of(8) {
                continue;
            }
            let eigen = projected
                .as_ref()
                .submatrix(0, 0, count, count)
                .self_adjoint_eigen(Triangle::Lower)
                .map_err(|_| Error::NotConverged { re: 0.0, im: high })?;
            let below = projected.as_ref().submatrix(count, 0, BLOCK, count);
            let leak = |column: usize| (below * eigen.U().col(column)).norm_l2() / eigen.S()[column].abs();
            let mut found: Vec<(f64, usize)> = (0..count)
                .filter(|&column| eigen.S()[column] != 0.0)
                .map(|column| (1.0 / eigen.S()[column], column))
                .collect();
            found.sort_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
            let good = found.iter().take_while(|(_, column)| leak(*column) <= TOLERANCE).count();
            let is_beyond = good > 0 && found[good - 1].0.abs() > radius;
            if is_beyond || is_last {
                let within = found[..good].iter().filter(|(away, _)| away.abs() <= radius);
                let mut modes: Vec<Mode> = within
                    .map(|&(away, column)| {
                        let mut shape = vec![0.0; size];
                        for (row, vector) in basis.vectors[..count].iter().enumerate() {
                            let factor = eigen.U()[(row, column)];
                            shape.iter_mut().zip(vector).for_each(|(sum, value)| *sum += factor * value);
                        }
                        Mode { square: shift + away, shape }
                    })
                    .collect();
                modes.sort_by(|a, b| a.square.total_cmp(&b.square));
                return Ok(modes);
            }
        }
    }

    /// Solves `K_s x = b` for several right sides.
    ///
    /// # Errors
    /// What the factorisation says.
    pub fn static_answers(&self, loads: &mut [Vec<f64>]) -> Result<(), Error> {
        let lu = self.family().factorise_real(&self.symmetric_stiffness())?;
        let size = self.family().size();
        for load in loads {
            lu.solve_in_place_with_conj(Conj::No, MatMut::from_column_major_slice_mut(load, size, 1));
            if !load.iter().all(|value| value.is_finite()) {
                return Err(Error::Singular { re: 0.0, im: 0.0 });
            }
        }
        Ok(())
    }
}

/// A number without structure from -1 to 1: fractions of squares times the golden ratio.
fn unstructured(index: u64) -> f64 {
    let index = index + 1;
    (index.wrapping_mul(index).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// Vectors that are orthonormal in a product, with their images under its matrix.
pub(super) struct Basis {
    pub(super) vectors: Vec<Vec<f64>>,
    pub(super) images: Vec<Vec<f64>>,
}

impl Basis {
    /// Adds what a vector has beyond the others. Returns its coefficients, and whether there was anything beyond rounding.
    pub(super) fn append(&mut self, mut vector: Vec<f64>, times: impl Fn(&[f64]) -> Vec<f64>) -> (Vec<f64>, bool) {
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut coefficients = vec![0.0; self.vectors.len()];
        let before = dot(&vector, &times(&vector)).max(0.0).sqrt();
        for _ in 0..2 {
            for ((known, image), total) in self.vectors.iter().zip(&self.images).zip(&mut coefficients) {
                let factor = dot(image, &vector);
                *total += factor;
                vector.iter_mut().zip(known).for_each(|(value, known)| *value -= factor * known);
            }
        }
        let mut image = times(&vector);
        let norm = dot(&vector, &image).max(0.0).sqrt();
        let is_new = norm > 1e-12 * before && norm > 0.0;
        if is_new {
            vector.iter_mut().chain(&mut image).for_each(|value| *value /= norm);
            self.vectors.push(vector);
            self.images.push(image);
            coefficients.push(norm);
        }
        (coefficients, is_new)
    }
}
