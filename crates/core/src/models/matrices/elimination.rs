//! The matrix that remains of one of first order where some modes are eliminated, after changes, and what that leaves out.
//!
//! The matrix is `diag(lambda) + E` with `E = sum_k delta_k E_k`; modes S are kept, and the others R keep distances `g_r` from all places
//! z that are looked at. Where the norm
//!
//! ```text
//! rho = |G|_2,    G_rq = E_rq / sqrt(g_r g_q)
//! ```
//!
//! is below 1, `z - lambda_R - E_RR` is regular for all these z, and z is an eigenvalue just where this is singular (the Schur
//! complement):
//!
//! ```text
//! lambda_S + E_SS - z + E_SR (z - lambda_R - E_RR)^-1 E_RS
//! ```
//!
//! In its last term row i, e of E_SR, is taken at one place s and to third order:
//!
//! ```text
//! Y E_RS,    Y = y_0 + y_1,    y_0 = e (s - lambda_R)^-1,    y_1 = y_0 E_RR (s - lambda_R)^-1
//! ```
//!
//! As `e - Y (z - lambda_R - E_RR) = y_1 E_RR - (z - s) Y`, what that leaves out is exactly
//!
//! ```text
//! (y_1 E_RR - (z - s) Y) (z - lambda_R - E_RR)^-1 E_RS,
//! ```
//!
//! and, as all of the term and all of what is taken for it are bounded too, not more than the least of
//!
//! ```text
//! (|y_1 sqrt(g)| rho + |z - s| |Y / sqrt(g)|) b_j / (1 - rho),    (|e / sqrt(g)| / (1 - rho) + |Y sqrt(g)|) b_j
//! ```
//!
//! with `b_j = |E_rj / sqrt(g_r)|`. Of few changes all of this is known as polynomials ([`polynomials`]); of many, it takes less
//! time to add them up and to multiply what they are together ([`direct`]).

mod changed;
mod direct;
mod polynomials;

use faer::Mat;

use self::changed::{Changed, Modes};
use self::direct::Direct;
use self::polynomials::Polynomials;
use super::boundary::{Bounded, length};
use super::fast_basis::ComplexMat;
use crate::numerics::eigenvalues::Eigenvalue;

/// Modes that are kept and others that are eliminated.
pub(super) struct Elimination {
    /// lambda_S.
    kept: Vec<Eigenvalue>,
    /// s.
    places: Vec<Eigenvalue>,
    /// The largest modulus in each change of the rows and columns of modes that are kept.
    sizes: Vec<f64>,
    terms: Terms,
}

/// How what changes make is found.
enum Terms {
    Polynomials(Polynomials),
    Direct(Direct),
}

/// Products of two changes times the cube of all modes up to which polynomials take well below a second to find.
const MOST_WORK: f64 = (1_u64 << 30) as f64;

impl Elimination {
    /// Keeps the first modes, as many as there are places, which are at the distances from all that will be looked at. The distances
    /// of the others are above zero. `None` where polynomials take less time for a sample, but too much to find.
    pub(super) fn new(
        eigenvalues: &[Eigenvalue],
        distances: &[f64],
        places: Vec<Eigenvalue>,
        changes: &[ComplexMat],
    ) -> Option<Self> {
        Self::with(eigenvalues, distances, places, changes, |modes| {
            let all = eigenvalues.len() as f64;
            let of_two = 0.5 * changes.len() as f64 * (changes.len() as f64 + 1.0);
            let [with, without] = modes.work();
            match with <= without {
                true if of_two * all * all * all > MOST_WORK => None,
                true => Some(Terms::Polynomials(Polynomials::new(modes))),
                false => Some(Terms::Direct(Direct::new(modes))),
            }
        })
    }

    fn with(
        eigenvalues: &[Eigenvalue],
        distances: &[f64],
        places: Vec<Eigenvalue>,
        changes: &[ComplexMat],
        terms: impl Fn(&Modes<'_>) -> Option<Terms>,
    ) -> Option<Self> {
        let kept = places.len();
        let others = &eigenvalues[kept..];
        let roots: Vec<f64> = distances[kept..].iter().map(|distance| distance.sqrt()).collect();
        let modes = Modes {
            changes,
            kept,
            inverse_roots: roots.iter().map(|root| 1.0 / root).collect(),
            roots,
            inverse_gaps: Mat::from_fn(kept, others.len(), |i, r| 1.0 / (places[i] - others[r])),
        };
        let all = eigenvalues.len();
        let size = |change: &ComplexMat| {
            let places = (0..all).flat_map(|i| (0..if i < kept { all } else { kept }).map(move |j| (i, j)));
            places.map(|place| length(change[place])).fold(0.0, f64::max)
        };
        Some(Self {
            terms: terms(&modes)?,
            sizes: changes.iter().map(size).collect(),
            kept: eigenvalues[..kept].to_vec(),
            places,
        })
    }

    /// How many modes are kept.
    pub(super) fn kept(&self) -> usize {
        self.kept.len()
    }

    /// How many numbers it has, nearly.
    pub(super) fn numbers(&self) -> usize {
        match &self.terms {
            Terms::Polynomials(terms) => terms.numbers(),
            Terms::Direct(terms) => terms.numbers(),
        }
    }

    /// A bound of rho.
    pub(super) fn norm(&self, changes: &[f64]) -> f64 {
        match &self.terms {
            Terms::Polynomials(terms) => terms.norm(changes),
            Terms::Direct(terms) => terms.norm(changes),
        }
    }

    /// The matrix that remains after these changes, where rho is below 1. Distances are made smaller by `margin` of each entry of its
    /// diagonal, and `rounding` is that of each entry, by the largest that changes may add, each for itself.
    pub(super) fn bounded(
        &self,
        changes: &[f64],
        margin: impl Fn(Eigenvalue) -> f64,
        rounding: impl Fn(f64) -> f64,
    ) -> Option<Bounded> {
        let changed = match &self.terms {
            Terms::Polynomials(terms) => terms.after(changes),
            Terms::Direct(terms) => terms.after(changes),
        };
        let Changed {
            mut entries,
            norm,
            rows,
            columns,
            first: [first_times, first_over],
            second: [second_times, second_over],
        } = changed?;
        let size = self.kept.len();
        let of_changes: f64 = changes.iter().zip(&self.sizes).map(|(change, size)| change.abs() * size).sum();
        let largest = entries.iter().map(|entry| length(*entry)).fold(of_changes, f64::max);
        let diagonal = entries.iter_mut().step_by(size + 1).zip(&self.kept);
        diagonal.for_each(|(entry, eigenvalue)| *entry += eigenvalue);
        let diagonal = entries.iter().step_by(size + 1);
        let rest = 1.0 / (1.0 - norm);
        Some(Bounded {
            margins: diagonal.map(|value| margin(*value)).collect(),
            rounding: rounding(largest),
            entries,
            constant: second_times.iter().map(|second| second * norm * rest).collect(),
            slope: first_over.iter().zip(&second_over).map(|(first, second)| (first + second) * rest).collect(),
            most: (0..size).map(|i| rows[i] * rest + first_times[i] + second_times[i]).collect(),
            places: self.places.clone(),
            columns,
        })
    }
}

#[cfg(test)]
mod tests;
