//! Models made of matrices and factors, and their critical values.

use std::sync::Arc;

use faer::sparse::{SparseColMat, Triplet};
use stickslip_core::model::quantity::Limits;
use stickslip_core::models::matrices::factor::Factor;
use stickslip_core::models::matrices::model::{ComplexEigenvalue, MatrixModel};
use stickslip_core::models::matrices::problem::Solver;
use stickslip_core::models::matrices::terms::{Matrices, Matrix, Parameter, Term};

use crate::failure::Failure;

/// A matrix of two rows.
pub fn of_two([a, b, c, d]: [f64; 4]) -> Result<Arc<Matrix>, Failure> {
    let entries = [(0, 0, a), (0, 1, b), (1, 0, c), (1, 1, d)].map(|(row, col, val)| Triplet { row, col, val });
    let matrix = SparseColMat::try_new_from_triplets(2, 2, &entries);
    Ok(Arc::new(matrix.map_err(|error| Failure::Internal(format!("a matrix of two rows: {error:?}")))?))
}

/// Matrices with their factors in parameters.
pub struct Parts<'a> {
    pub mass: Arc<Matrix>,
    pub damping: Vec<(Arc<Matrix>, &'a str)>,
    pub stiffness: Vec<(Arc<Matrix>, &'a str)>,
    /// Names with their values.
    pub parameters: Vec<(&'a str, f64)>,
    /// Hz.
    pub band: [f64; 2],
    pub solver: Solver,
}

impl Parts<'_> {
    pub fn model(&self) -> Result<MatrixModel, Failure> {
        let names: Vec<&str> = self.parameters.iter().map(|(name, _)| *name).collect();
        let wrong = |why: String| Failure::Internal(format!("a model of the gallery: {why}"));
        let terms = |parts: &[(Arc<Matrix>, &str)]| {
            let term = |(matrix, factor): &(Arc<Matrix>, &str)| {
                let factor = Factor::parse(factor, &names).map_err(|error| wrong(error.to_string()))?;
                Ok(Term { matrix: matrix.clone(), factor })
            };
            parts.iter().map(term).collect::<Result<Vec<Term>, Failure>>()
        };
        let parameter = |(name, value): &(&str, f64)| Parameter {
            name: (*name).to_owned(),
            value: *value,
            unit: "1".to_owned(),
            label: (*name).to_owned(),
            range: Limits::ANY,
        };
        let matrices = Matrices {
            mass: self.mass.clone(),
            damping: terms(&self.damping)?,
            stiffness: terms(&self.stiffness)?,
            parameters: self.parameters.iter().map(parameter).collect(),
        };
        let criterion =
            ComplexEigenvalue { bands: vec![self.band], damping_ratio: 0.0, counts_rigid_body_motions: false };
        MatrixModel::new(Arc::new(matrices), criterion, self.solver).map_err(|error| wrong(error.to_string()))
    }

    /// The first value of the first parameter between two at which the number of unstable pairs changes, and the frequency in
    /// Hz there.
    pub fn critical(&self, within: [f64; 2]) -> Result<(f64, f64), Failure> {
        let wrong =
            |why: &str| Failure::Internal(format!("no critical value between {} and {}: {why}", within[0], within[1]));
        let model = self.model()?;
        let sweeps =
            model.sweeps(&model.matrices().expected(), 0, within).map_err(|error| wrong(&error.to_string()))?;
        let changes = sweeps.iter().flat_map(|sweep| &sweep.changes);
        let first = changes.min_by(|a, b| a.p.total_cmp(&b.p));
        let unresolved = sweeps.iter().flat_map(|sweep| &sweep.unresolved).map(|([from, to], _)| 0.5 * (from + to));
        let unresolved = unresolved.min_by(f64::total_cmp);
        match (first, unresolved) {
            (Some(change), before) if before.is_none_or(|before| before > change.p) => {
                Ok((change.p, change.at.pair.eigenvalue.im / std::f64::consts::TAU))
            }
            // Where two modes meet without damping they cannot be told apart: a stretch of the width of rounding.
            (_, Some(place)) => Ok((place, f64::NAN)),
            _ => Err(wrong("none was found")),
        }
    }
}
