//! The matrices of a model, read from its files and brought to the same degrees of freedom.

use std::path::Path;
use std::sync::Arc;

use stickslip_core::models::matrices::condensation::condensed;
use stickslip_core::models::matrices::factor::Factor;
use stickslip_core::models::matrices::terms::{self as of_model, Matrices, Matrix, Parameter};
use toml::Spanned;

use super::checks;
use super::spec::MatrixModelSpec;
use super::terms::{FileTerm, Reader, Term, TermSpec, TermsSpec};
use crate::job::diagnosis::{Complaint, Complaints};
use crate::matrix_files;

/// Terms whose numbers of rows a message lists.
const MOST_LISTED: usize = 20;

/// The matrices, once they are read, and what is to be said of them.
pub struct ReadModel {
    pub matrices: Arc<Matrices>,
    /// The displacements of all degrees of freedom for those of the matrices, where some had no mass and were condensed.
    pub displacements: Option<Matrix>,
    pub files: Vec<FileTerm>,
    /// What may not be meant.
    pub warnings: Vec<String>,
    /// What was done in reading: comments below the normalised job.
    pub remarks: String,
}

/// Reads the matrices and their factors, and checks them. Without a folder of files the factors are read alone, with what
/// stands for the matrices.
pub fn read<'a>(
    spec: &'a MatrixModelSpec,
    parameters: &[Parameter],
    folder: Option<&Path>,
    complaints: &mut Complaints,
) -> Option<ReadModel> {
    let Some(mass) = &spec.mass else {
        let message = "missing key `mass` in [model]: the mass matrix, { file = \"brake.mat\", matrix = \"M\" } or { matrix = [[...], ...] }";
        complaints.push(Complaint::missing("model", None, message.to_owned()));
        return None;
    };
    let listed = |name: &'static str, specs: &'a TermsSpec| {
        specs.0.iter().enumerate().map(move |(i, spec)| (format!("{name}[{i}]"), spec))
    };
    let mut specs = vec![("mass".to_owned(), mass)];
    specs.extend(listed("damping", &spec.damping));
    let stiffness_from = specs.len();
    specs.extend(listed("stiffness", &spec.stiffness));
    let mut reader = Reader::new(folder, parameters);
    // All are read before any is missed, so that every mistake is named.
    let read = |(key, spec): (String, &'a Spanned<TermSpec>)| {
        reader.read(&key, spec).map_err(|complaint| complaints.push_some(complaint)).ok()
    };
    let terms: Vec<Option<Term>> = specs.into_iter().map(read).collect();
    let terms: Vec<Term> = terms.into_iter().collect::<Option<_>>()?;
    if terms.len() == stiffness_from {
        let message = "missing key `stiffness` in [model]: the terms of the stiffness matrix";
        complaints.push(Complaint::missing("model", None, message.to_owned()));
        return None;
    }
    let head = &terms[0].head;
    if head.factor != Factor::number(1.0) {
        let message = "the mass matrix has no factor; scale its values, or those of damping and stiffness";
        complaints.push(head.complaint(message));
        return None;
    }
    let terms = complaints.take(aligned(terms))?;
    checks::refuse(&terms, complaints)?;
    let mut warnings = folder.map_or_else(Vec::new, |_| checks::doubts(&terms, stiffness_from));
    let mut notes = checks::grouped(&terms, |read| &read.notes);
    let places = terms[0].read.degrees_of_freedom.clone();
    let (mut heads, mut files) = (Vec::new(), Vec::new());
    let mut terms = terms.into_iter().map(|term| {
        let factor = term.head.factor.clone();
        heads.push(term.head);
        files.extend(term.file);
        of_model::Term { matrix: Arc::new(term.read.matrix), factor }
    });
    let mass = terms.next()?.matrix;
    let damping = terms.by_ref().take(stiffness_from - 1).collect();
    let stiffness = terms.collect();
    let mut matrices = Matrices { mass, damping, stiffness, parameters: parameters.to_vec() };
    warnings.extend(checks::unused_parameters(&matrices));
    let mut displacements = None;
    match condensed(&matrices) {
        Ok(None) => {}
        Ok(Some(found)) => {
            notes.push(format!(
                "{} of {} motions have no mass and follow the others: they are condensed",
                matrices.size() - found.matrices.size(),
                matrices.size()
            ));
            (matrices, displacements) = (found.matrices, Some(found.displacements));
        }
        Err(error) => {
            complaints.push(checks::not_condensed(&heads, places.as_deref(), &matrices, &error));
            return None;
        }
    }
    let remarks = notes.iter().map(|note| format!("# {note}\n")).collect();
    Some(ReadModel { matrices: Arc::new(matrices), displacements, files, warnings, remarks })
}

/// The terms over the same degrees of freedom.
fn aligned(terms: Vec<Term>) -> Result<Vec<Term>, Complaint> {
    let rows: Vec<String> =
        terms.iter().take(MOST_LISTED).map(|term| format!("{} {}", term.head.key, term.read.matrix.nrows())).collect();
    let more = if terms.len() > MOST_LISTED { ", ..." } else { "" };
    let (others, matrices): (Vec<_>, Vec<_>) =
        terms.into_iter().map(|term| ((term.head, term.file), term.read)).unzip();
    let matrices = matrix_files::align(matrices)
        .map_err(|error| others[error.matrix].0.complaint(&format!("{error} (rows: {}{more})", rows.join(", "))))?;
    let whole = others.into_iter().zip(matrices).map(|((head, file), read)| Term { head, read, file });
    Ok(whole.collect())
}
