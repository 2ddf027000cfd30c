//! An eigenpair made exact from an approximation.

use super::quadratic::{Factorisation, Point, Side};
use crate::models::matrices::error::Error;
use crate::models::matrices::pair::{Complex, Pair, normalise, root_near};
use crate::models::matrices::region::magnitude;

/// Factorisations that a refinement may take.
const FACTORISATIONS: usize = 4;

/// Steps with one factorisation.
const STEPS: usize = 12;

/// A change of the eigenvalue below this, relative to it, is rounding.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

impl Point<'_> {
    /// The eigenvalue nearest to a guess that left and right vectors give together: the root of `y^T Q(lambda) x`, and
    /// `y^T Q'(lambda) x` there. Its error is a product of the errors of both vectors.
    #[must_use]
    pub fn rayleigh(&self, guess: Complex, left: &[Complex], right: &[Complex]) -> Option<(Complex, Complex)> {
        root_near(guess, self.forms(left, right))
    }

    /// The pair near an approximate one: inverse iteration for both vectors, with a factorisation at the eigenvalue.
    ///
    /// From vectors wrong by 10 %, one or two factorisations and some six solves with each.
    ///
    /// # Errors
    /// [`Error::NotConverged`], and what factorisations say.
    pub fn refine(&self, start: &Pair) -> Result<Pair, Error> {
        let mut pair = start.clone();
        if let Some((value, _)) = self.rayleigh(pair.eigenvalue, &pair.left, &pair.right)
            && magnitude(value - pair.eigenvalue) < 0.02 * magnitude(pair.eigenvalue)
        {
            pair.eigenvalue = value;
        }
        for _ in 0..FACTORISATIONS {
            // Not exactly at it: a small matrix would be singular to the last bit.
            let near = self.factorise(pair.eigenvalue * (1.0 + 1e-8))?;
            let (next, is_done) = self.refine_with(&near, &pair)?;
            pair = next;
            if is_done {
                return Ok(pair);
            }
        }
        Err(Error::NotConverged { re: pair.eigenvalue.re, im: pair.eigenvalue.im })
    }

    /// The same with a given factorisation at a shift near by. The second result says whether it converged; if not, it wants
    /// a nearer shift.
    ///
    /// `x <- x - Q(s)^-1 Q(lambda) x` (Neumaier, SIAM J. Numer. Anal. 22 (1985) 914) is, up to its scale,
    /// `x <- Q(s)^-1 ((lambda + s) M + C) x`, where nothing cancels. It converges by the distance of the eigenvalue from the
    /// shift over that of the next eigenvalue; the eigenvalue by the square of it.
    ///
    /// # Errors
    /// [`Error::NotConverged`] if the vectors lead nowhere, and what solves say.
    pub fn refine_with(&self, near: &Factorisation, start: &Pair) -> Result<(Pair, bool), Error> {
        let size = self.family().size();
        if near.coefficients() != self.coefficients() {
            return Err(Error::Request("a factorisation serves the parameter point at which it was made"));
        }
        let shift = near.shift();
        let mut pair = start.clone();
        normalise(&mut pair.right);
        normalise(&mut pair.left);
        let mut changes = vec![f64::INFINITY];
        let mut image = vec![Complex::default(); size];
        for _ in 0..STEPS {
            for side in [Side::Right, Side::Left] {
                let value = pair.eigenvalue;
                let vector = if side == Side::Right { &mut pair.right } else { &mut pair.left };
                let one = Complex::new(1.0, 0.0);
                self.combine([value + shift, one, Complex::default()], vector, side, &mut image);
                near.solve(&mut image, size, side)?;
                vector.copy_from_slice(&image);
                normalise(vector);
            }
            let not_converged = Error::NotConverged { re: pair.eigenvalue.re, im: pair.eigenvalue.im };
            let Some((value, slope)) = self.rayleigh(pair.eigenvalue, &pair.left, &pair.right) else {
                return Err(not_converged);
            };
            let change = magnitude(value - pair.eigenvalue);
            let before = changes.last().copied().unwrap_or(f64::INFINITY);
            changes.push(change);
            pair.eigenvalue = value;
            let rounding = ROUNDING * magnitude(value);
            if change <= rounding {
                pair.error = change + rounding;
                pair.left.iter_mut().for_each(|value| *value /= slope);
                return Ok((pair, true));
            }
            // Eigenvalues converge by the square of the factor of the vectors.
            if changes.len() > 4 && change > 0.2 * before {
                break;
            }
        }
        Ok((pair, false))
    }
}
