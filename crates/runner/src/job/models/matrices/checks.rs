//! What is checked of matrices, in the words of those who made them.

use std::ops::Range;

use stickslip_core::models::matrices::model::{Matrices, Matrix, MatrixModel, Term};
use stickslip_core::models::matrices::region::damping_ratio;
use stickslip_core::numerics::eigenvalues::Eigenvalue;

use crate::job::diagnosis::{Complaint, Complaints};

/// Frequencies that are shown, Hz.
const SHOWN_FREQUENCIES: usize = 10;

/// The largest asymmetry of a matrix, over its largest entry, that counts as rounding.
const ROUNDING: f64 = 1e-9;

/// A stiffness at which programs hold degrees of freedom that are constrained.
const CONSTRAINED: f64 = 1e30;

/// Checks that all matrices have the size of the mass matrix, and that this one is a mass matrix.
pub fn sizes(
    mass: &Term,
    mass_span: Range<usize>,
    damping: &[Term],
    stiffness: &[Term],
    spans: &[Range<usize>],
    complaints: &mut Complaints,
) -> Option<()> {
    let before = complaints.len();
    let size = mass.matrix.nrows();
    if mass.matrix.ncols() != size {
        let message = format!("model.mass: the matrix is {size} by {}; it must be square", mass.matrix.ncols());
        complaints.push(Complaint::at(mass_span, message));
        return None;
    }
    let named = (0..).map(|i| format!("damping[{i}]")).take(damping.len());
    let named = named.chain((0..).map(|i| format!("stiffness[{i}]")).take(stiffness.len()));
    for ((name, term), span) in named.zip(damping.iter().chain(stiffness)).zip(spans) {
        let [rows, columns] = [term.matrix.nrows(), term.matrix.ncols()];
        if [rows, columns] != [size, size] {
            let message = format!(
                "model.{name}: the matrix is {rows} by {columns}, the mass matrix {size} by {size}; all matrices of a model have one size"
            );
            complaints.push(Complaint::at(span.clone(), message));
        }
        let held = (0..size.min(columns)).filter(|&i| diagonal(&term.matrix, i).abs() >= CONSTRAINED).count();
        if held > 0 {
            let message = format!(
                "model.{name}: {held} entries on the diagonal are 1e30 or more, which is how programs mark constrained degrees of freedom; remove their rows and columns from all matrices"
            );
            complaints.push(Complaint::at(span.clone(), message));
        }
    }
    let without = (0..size).filter(|&i| diagonal(&mass.matrix, i) <= 0.0 || diagonal(&mass.matrix, i).is_nan());
    let without: Vec<usize> = without.collect();
    if let Some(first) = without.first() {
        let message = format!(
            "model.mass: {} of {size} degrees of freedom have no mass (the first is number {}): the matrix is not positive definite; condense them, or give them a small mass",
            without.len(),
            first + 1
        );
        complaints.push(Complaint::at(mass_span.clone(), message));
    }
    let [asymmetry, largest] = asymmetry(&mass.matrix);
    if asymmetry > ROUNDING * largest {
        let message = format!(
            "model.mass: the matrix is not symmetric: entries across the diagonal differ by {asymmetry:e}, the largest entry is {largest:e}"
        );
        complaints.push(Complaint::at(mass_span, message));
    }
    (complaints.len() == before).then_some(())
}

fn diagonal(matrix: &Matrix, i: usize) -> f64 {
    matrix.get(i, i).copied().unwrap_or(0.0)
}

/// The largest difference of entries across the diagonal, and the largest entry.
fn asymmetry(matrix: &Matrix) -> [f64; 2] {
    let mut largest = [0.0_f64; 2];
    for entry in matrix.triplet_iter() {
        let across = matrix.get(entry.col, entry.row).copied().unwrap_or(0.0);
        largest = [largest[0].max((entry.val - across).abs()), largest[1].max(entry.val.abs())];
    }
    largest
}

/// What is to be said of matrices that can be read but may not be meant.
pub fn remarks(matrices: &Matrices) -> Vec<String> {
    let mut remarks = Vec::new();
    let is_symmetric = |term: &Term| {
        let [asymmetry, largest] = asymmetry(&term.matrix);
        asymmetry <= ROUNDING * largest
    };
    if matrices.stiffness.iter().all(is_symmetric) {
        remarks.push(
            "your stiffness is symmetric: there is no friction in it, so no modes are coupled by it (files that store one triangle lose friction without a word)".to_owned(),
        );
    }
    let used: Vec<usize> = matrices
        .damping
        .iter()
        .chain(&matrices.stiffness)
        .flat_map(|term| term.factor.parameters().collect::<Vec<_>>())
        .collect();
    for (place, parameter) in matrices.parameters.iter().enumerate() {
        if !used.contains(&place) {
            remarks.push(format!("the parameter `{}` stands in no factor: it changes nothing", parameter.name));
        }
    }
    remarks
}

/// What is to be said of the modes of the expected brake.
pub fn warnings(model: &MatrixModel, modes: &[Mode]) -> Vec<String> {
    let mut warnings = Vec::new();
    let undamped = modes.iter().filter(|mode| mode.damping_ratio.abs() < 1e-8 && in_band(model, mode)).count();
    if undamped > 0 && model.criterion().damping_ratio == 0.0 && !model.matrices().damping.is_empty() {
        warnings.push(format!(
            "{undamped} modes in the band are undamped: a damping ratio of 0 counts as stable, and rounding may be of either sign; a threshold such as damping_ratio = -0.001 leaves them out"
        ));
    }
    if !modes.iter().any(|mode| in_band(model, mode)) {
        warnings
            .push("the expected brake has no mode in the band of frequencies (Hz): are the units right?".to_owned());
    }
    warnings
}

fn in_band(model: &MatrixModel, mode: &Mode) -> bool {
    model.criterion().bands.iter().any(|[low, high]| (*low..=*high).contains(&mode.frequency))
}

/// An oscillating mode.
#[derive(Debug)]
pub struct Mode {
    /// Hz.
    frequency: f64,
    damping_ratio: f64,
}

/// The oscillating modes with these expected values, by rising frequency; none where eigenvalues do not converge.
pub fn modes(model: &MatrixModel, expected: &[f64]) -> Vec<Mode> {
    let matrices = model.matrices();
    let coefficients = matrices.coefficients(&expected[..matrices.parameters.len()]);
    let eigenvalues = model.problem().eigenvalues(&coefficients, &model.regions()).unwrap_or_default();
    let hertz = 1.0 / std::f64::consts::TAU;
    let oscillating = eigenvalues.into_iter().filter(|value| value.im > 0.0);
    let mode = |value: Eigenvalue| Mode { frequency: value.im * hertz, damping_ratio: damping_ratio(value) };
    let mut modes: Vec<Mode> = oscillating.map(mode).collect();
    modes.sort_by(|a, b| a.frequency.total_cmp(&b.frequency));
    modes
}

/// The first frequencies, in a line.
pub fn frequencies(model: &MatrixModel, modes: &[Mode]) -> String {
    let shown: Vec<String> =
        modes.iter().take(SHOWN_FREQUENCIES).map(|mode| format!("{:.4}", mode.frequency)).collect();
    format!(
        "# {} degrees of freedom; the first frequencies of the expected brake in Hz: {}\n",
        model.matrices().size(),
        shown.join(", ")
    )
}
