//! Fixed points of maps that may drive away from them.

use std::collections::VecDeque;

use nalgebra::{DMatrix, DVector};

/// Changes of so many rounds are combined.
const REMEMBERED: usize = 40;

/// Directions in which residuals change less than this part of the last change are lost in rounding.
const RESOLVED: f64 = 1e-13;

/// Largest number of rounds.
const ROUNDS: usize = 300;

/// The point `x` that `round` maps to itself, by Anderson's acceleration: the next point is the combination of the last
/// ones whose residuals `round(x) - x` nearly cancel. On a linear map that takes as many rounds as there are directions
/// in which it moves points, whether it draws them near or drives them away (Walker and Ni, SIAM J. Numer. Anal. 49
/// (2011) 1715).
///
/// It is found where no entry of the residual is above `tolerance`. Nothing where that does not happen.
///
/// # Errors
/// What `round` fails with.
pub(crate) fn fixed_point<E>(
    start: Vec<f64>,
    tolerance: f64,
    mut round: impl FnMut(&[f64]) -> Result<Vec<f64>, E>,
) -> Result<Option<Vec<f64>>, E> {
    let mut point = DVector::from_vec(start);
    let mut before: Option<[DVector<f64>; 2]> = None;
    // Changes of points and of their residuals.
    let mut changes: VecDeque<[DVector<f64>; 2]> = VecDeque::new();
    for _ in 0..ROUNDS {
        let residual = DVector::from_vec(round(point.as_slice())?) - &point;
        let largest = residual.amax();
        if largest <= tolerance {
            return Ok(Some(point.as_slice().to_vec()));
        }
        if !largest.is_finite() {
            return Ok(None);
        }
        if let Some([point_before, residual_before]) = before {
            changes.push_front([&point - point_before, &residual - residual_before]);
            changes.truncate(REMEMBERED.min(point.len()));
        }
        let mut next = &point + &residual;
        if !changes.is_empty() {
            let columns: Vec<_> = changes.iter().map(|[_, change]| change.clone()).collect();
            let (q, r) = DMatrix::from_columns(&columns).qr().unpack();
            let shares = r.svd(true, true).solve(&q.tr_mul(&residual), RESOLVED * columns[0].norm()).ok();
            for ([of_point, of_residual], share) in changes.iter().zip(shares.iter().flat_map(|shares| shares.iter())) {
                next -= *share * (of_point + of_residual);
            }
        }
        before = Some([std::mem::replace(&mut point, next), residual]);
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_map_that_drives_away_is_followed_to_its_fixed_point() {
        // x -> A x + b with eigenvalues from -50 to 20: rounds alone diverge.
        let matrix = DMatrix::from_fn(6, 6, |i, j| if i == j { [-50.0, 20.0, -3.0, 0.5, -0.9, 4.0][i] } else { 0.1 });
        let shift = DVector::from_fn(6, |i, _| 1.0 + i as f64);
        let exact = (DMatrix::identity(6, 6) - &matrix).lu().solve(&shift).unwrap();
        let mut rounds = 0;
        let round = |x: &[f64]| {
            rounds += 1;
            Ok::<_, ()>((&matrix * DVector::from_row_slice(x) + &shift).as_slice().to_vec())
        };
        let found = fixed_point(vec![0.0; 6], 1e-11, round).unwrap().unwrap();
        assert!((DVector::from_vec(found) - exact).amax() < 1e-12);
        assert!(rounds < 15, "{rounds}");
    }

    #[test]
    fn a_bent_map_too_and_none_is_found_where_there_is_none() {
        // x = -4 atan x + 10.
        let bent = |x: &[f64]| Ok::<_, ()>(vec![10.0 - 4.0 * x[0].atan()]);
        let found = fixed_point(vec![0.0], 1e-12, bent).unwrap().unwrap()[0];
        assert!((found + 4.0 * found.atan() - 10.0).abs() < 1e-11, "{found}");
        assert_eq!(fixed_point(vec![0.0], 1e-12, |x| Ok::<_, ()>(vec![x[0] + 1.0])).unwrap(), None);
        assert_eq!(fixed_point(vec![0.0], 1e-12, |_| Err::<Vec<f64>, _>("broken")), Err("broken"));
    }
}
