//! What is checked of matrices, in the words of those who made them.

use std::sync::Arc;

use stickslip_core::models::matrices::condensation::CondensationError;
use stickslip_core::models::matrices::full::has_common_instructions;
use stickslip_core::models::matrices::model::MatrixModel;
use stickslip_core::models::matrices::problem::Problem;
use stickslip_core::models::matrices::region::damping_ratio;
use stickslip_core::models::matrices::terms::{Matrices, Matrix, asymmetry, is_symmetric};
use stickslip_core::numerics::eigenvalues::Eigenvalue;

use super::terms::{Head, Term};
use crate::job::diagnosis::{Complaint, Complaints};
use crate::matrix_files::{Place, ReadMatrix, Stored};
use crate::output::counted;
use crate::units::significant;

/// Frequencies that are shown, Hz.
const SHOWN_FREQUENCIES: usize = 10;

/// A stiffness at which programs hold degrees of freedom that are constrained.
const CONSTRAINED: f64 = 1e30;

/// Refuses what no model has. The terms are the mass, those of damping and those of stiffness.
pub fn refuse(terms: &[Term], complaints: &mut Complaints) -> Option<()> {
    let before = complaints.len();
    let mass = terms.first()?;
    let size = mass.read.matrix.nrows();
    let places = mass.read.degrees_of_freedom.as_deref();
    for term in &terms[1..] {
        let is_held = |row: &usize| diagonal(&term.read.matrix, *row).abs() >= CONSTRAINED;
        let held: Vec<usize> = (0..size).filter(is_held).collect();
        if let Some(first) = held.first() {
            let message = format!(
                "{} 1e30 or more (the first is {}), which is how programs mark constrained degrees of freedom; remove their rows and columns from all matrices, or name the file of Abaqus itself, from which they are taken out",
                counted(held.len() as u128, "entry on the diagonal is", "entries on the diagonal are"),
                named(places, *first)
            );
            complaints.push(term.head.complaint(&message));
        }
    }
    let is_empty = empty_rows([&mass.read.matrix].into_iter(), size);
    let is_wrong = |row: &usize| !is_empty[*row] && diagonal(&mass.read.matrix, *row) <= 0.0;
    if let Some(first) = (0..size).find(is_wrong) {
        let message = format!(
            "the matrix is not positive definite: the mass of degree of freedom {} is {}",
            named(places, first),
            diagonal(&mass.read.matrix, first)
        );
        complaints.push(mass.head.complaint(&message));
    }
    if !is_symmetric(&mass.read.matrix) {
        let [asymmetry, largest] = asymmetry(&mass.read.matrix);
        let message = format!(
            "the matrix is not symmetric: entries across the diagonal differ by {asymmetry:e}, the largest entry is {largest:e}"
        );
        complaints.push(mass.head.complaint(&message));
    }
    (complaints.len() == before).then_some(())
}

/// Why what has no mass cannot be condensed, and what to do.
pub fn not_condensed(
    heads: &[Head],
    places: Option<&[Place]>,
    matrices: &Matrices,
    error: &CondensationError,
) -> Complaint {
    let (place, what) = match error {
        CondensationError::NotHeld { place } => {
            let all = matrices.stiffness.iter().map(|term| &term.matrix).chain([&matrices.mass]);
            let empty =
                empty_rows(all.map(Arc::as_ref), matrices.size()).into_iter().filter(|is_empty| *is_empty).count();
            let what = if empty > 0 {
                format!(
                    "; {} neither mass nor stiffness, as programs leave what is constrained: remove their rows and columns from all matrices",
                    counted(empty as u128, "degree of freedom has", "degrees of freedom have")
                )
            } else {
                "; condense them before, or give them a small mass".to_owned()
            };
            (*place, what)
        }
        CondensationError::Changing { place, terms: changing } => {
            let keys: Vec<&str> = changing.iter().map(|term| heads[term + 1].key.as_str()).collect();
            let what = format!(" ({}); give them a small mass, or keep what varies off them", keys.join(", "));
            (*place, what)
        }
        CondensationError::TooMany { place, .. } => (*place, "; condense them before".to_owned()),
        _ => (0, String::new()),
    };
    let place = named(places, place);
    heads[0].complaint(&format!("some degrees of freedom have no mass (one is {place}), and {error}{what}"))
}

/// A degree of freedom as its users know it.
fn named(places: Option<&[Place]>, row: usize) -> String {
    match places.and_then(|places| places.get(row)) {
        Some((node, direction)) => format!("number {}, node {node} in direction {direction}", row + 1),
        None => format!("number {}", row + 1),
    }
}

/// Whether each row has no entry in any of these matrices.
fn empty_rows<'m>(matrices: impl Iterator<Item = &'m Matrix>, size: usize) -> Vec<bool> {
    let mut is_empty = vec![true; size];
    for matrix in matrices {
        for entry in matrix.triplet_iter().filter(|entry| *entry.val != 0.0) {
            is_empty[entry.row] = false;
        }
    }
    is_empty
}

fn diagonal(matrix: &Matrix, i: usize) -> f64 {
    matrix.get(i, i).copied().unwrap_or(0.0)
}

/// What is to be said of matrices that can be read but may not be meant.
pub fn doubts(terms: &[Term], stiffness_from: usize) -> Vec<String> {
    let mut doubts = grouped(terms, |read| &read.doubts);
    let stiffness = &terms[stiffness_from..];
    if stiffness.iter().all(|term| is_symmetric(&term.read.matrix)) {
        let triangles: Vec<&str> = stiffness
            .iter()
            .filter(|term| term.read.stored == Stored::SymmetricTriangle)
            .map(|term| term.head.key.as_str())
            .collect();
        let why = match &triangles[..] {
            [] => "files that store one triangle lose friction without a word".to_owned(),
            keys => format!("one triangle is stored of {}, which loses friction without a word", keys.join(", ")),
        };
        doubts.push(format!(
            "your stiffness is symmetric: there is no friction in it, so no modes are coupled by it ({why})"
        ));
    }
    let size = stiffness.first().map_or(0, |term| term.read.matrix.nrows());
    let is_empty = empty_rows(stiffness.iter().map(|term| &term.read.matrix), size);
    if let Some(first) = is_empty.iter().position(|is_empty| *is_empty) {
        let count = is_empty.iter().filter(|is_empty| **is_empty).count();
        doubts.push(format!(
            "{} no stiffness (the first is {}): what has none moves freely; should it be constrained?",
            counted(count as u128, "degree of freedom has", "degrees of freedom have"),
            named(terms.first().and_then(|term| term.read.degrees_of_freedom.as_deref()), first)
        ));
    }
    doubts
}

/// What is said of matrices, each with the terms of which it is said.
pub fn grouped(terms: &[Term], said: impl Fn(&ReadMatrix) -> &[String]) -> Vec<String> {
    let mut groups: Vec<(&str, Vec<&str>)> = Vec::new();
    for term in terms {
        for text in said(&term.read) {
            match groups.iter_mut().find(|(other, _)| other == text) {
                Some((_, keys)) => keys.push(&term.head.key),
                None => groups.push((text, vec![&term.head.key])),
            }
        }
    }
    groups.into_iter().map(|(text, keys)| format!("model.{}: {text}", keys.join(", model."))).collect()
}

/// Parameters that change nothing.
pub fn unused_parameters(matrices: &Matrices) -> Vec<String> {
    let terms = matrices.damping.iter().chain(&matrices.stiffness);
    let used: Vec<usize> = terms.flat_map(|term| term.factor.parameters().collect::<Vec<_>>()).collect();
    let unused = matrices.parameters.iter().enumerate().filter(|(place, _)| !used.contains(place));
    unused
        .map(|(_, parameter)| format!("the parameter `{}` stands in no factor: it changes nothing", parameter.name))
        .collect()
}

/// Growth that is no more than this, over the frequency, and eigenvalues no larger than this, over the largest, are rounding.
const ROUNDING: f64 = 1e-6;

/// What moves by more than this, of 1, is named of a rigid-body motion.
const MOVES: f64 = 1e-6;

/// So many motions, and degrees of freedom of each, are named.
const NAMED: usize = 6;

/// What is to be said of the modes of the expected brake.
pub fn warnings(model: &MatrixModel, modes: &[Mode]) -> Vec<String> {
    let mut warnings = Vec::new();
    let undamped = modes
        .iter()
        .filter(|mode| mode.frequency > 0.0 && mode.damping_ratio.abs() < 1e-8 && in_band(model, mode))
        .count();
    if undamped > 0 && model.criterion().damping_ratio == 0.0 && !model.matrices().damping.is_empty() {
        warnings.push(format!(
            "{undamped} modes in the band are undamped: a damping ratio of 0 counts as stable, and rounding may be of either sign; a threshold such as damping_ratio = -0.001 leaves them out"
        ));
    }
    let knows_all = matches!(model.problem(), Problem::Dense(_));
    if !knows_all && !has_common_instructions() {
        warnings.push(
            "this processor lacks AVX2 or FMA, so that full matrices give other last digits here than on processors with both; see \"On every processor\" in docs/reference/versions.md"
                .to_owned(),
        );
    }
    warnings.extend(unstable_elsewhere(model, modes));
    if knows_all && modes.iter().all(|mode| mode.frequency == 0.0 && mode.damping_ratio > 0.0) {
        warnings.push(
            "nothing oscillates in the expected brake: all eigenvalues are real, as damping is beyond its critical value everywhere"
                .to_owned(),
        );
    } else if has_band(model) && !modes.iter().any(|mode| mode.frequency > 0.0 && in_band(model, mode)) {
        warnings
            .push("the expected brake has no mode in the band of frequencies (Hz): are the units right?".to_owned());
    }
    warnings
}

/// Whether every band leaves frequencies out.
fn has_band(model: &MatrixModel) -> bool {
    model.regions().iter().all(|region| region.lowest > 0.0 || region.highest.is_finite())
}

/// What is said of motions of the expected brake that grow outside of the bands, which no verdict counts.
fn unstable_elsewhere(model: &MatrixModel, modes: &[Mode]) -> Option<String> {
    let largest = modes.iter().fold(0.0_f64, |largest, mode| largest.max(mode.magnitude));
    let grows = |mode: &&Mode| {
        let is_beyond_rounding = mode.magnitude > ROUNDING * largest && mode.damping_ratio < -ROUNDING;
        is_beyond_rounding && mode.damping_ratio < model.criterion().damping_ratio && !in_band(model, mode)
    };
    let mut frequencies: Vec<String> = modes.iter().filter(grows).map(|mode| significant(mode.frequency)).collect();
    // Between two bands sparse matrices have a pair from both.
    frequencies.dedup();
    let first = frequencies.first()?;
    let of = match frequencies.len() {
        1 => format!("a motion of the expected brake is unstable outside of the band, at {first} Hz"),
        count => {
            format!("{count} motions of the expected brake are unstable outside of the band, the first at {first} Hz")
        }
    };
    let without_swinging = if first == "0" { " (it goes away without swinging)" } else { "" };
    Some(format!(
        "{of}{without_swinging}; P counts the band alone. Are the signs and the units of the matrices right? A band that holds these frequencies counts them, criterion.frequency"
    ))
}

/// What is said of rigid-body motions that are left out: what moves in each.
pub fn rigid_body_motions(model: &MatrixModel, displacements: Option<&Matrix>) -> Option<String> {
    let of_all = |motion: &Vec<f64>| {
        let Some(displacements) = displacements else { return motion.clone() };
        let mut all = vec![0.0; displacements.nrows()];
        displacements.triplet_iter().for_each(|entry| all[entry.row] += *entry.val * motion[entry.col]);
        all
    };
    let motions: Vec<Vec<f64>> = model.rigid_body_motions().iter().map(of_all).collect();
    let moving = |motion: &Vec<f64>| {
        let largest = motion.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
        let moves = |place: &usize| motion[*place].abs() > MOVES * largest;
        let places: Vec<usize> = (0..motion.len()).filter(moves).collect();
        let first: Vec<String> = places.iter().take(NAMED).map(|place| (place + 1).to_string()).collect();
        let rest = places.len().saturating_sub(NAMED);
        let more = if rest > 0 { format!(" and {rest} more") } else { String::new() };
        format!("{}{more}", first.join(", "))
    };
    let moving: Vec<String> = motions.iter().take(NAMED).map(moving).collect();
    let number = match motions.len() {
        0 => return None,
        1 => "1 rigid-body motion is left out, which".to_owned(),
        many => format!("{many} rigid-body motions are left out, which"),
    };
    Some(format!(
        "{number} no stiffness and no damping holds (it moves the degrees of freedom number {}); is something not held that should be? criterion.rigid_body_motions = \"counted\" counts their eigenvalues, which are zero up to rounding",
        moving.join("; another ")
    ))
}

fn in_band(model: &MatrixModel, mode: &Mode) -> bool {
    model.criterion().bands.iter().any(|[low, high]| (*low..=*high).contains(&mode.frequency))
}

/// A mode, or a motion that does not oscillate, with the frequency 0.
#[derive(Debug)]
pub struct Mode {
    /// Hz.
    frequency: f64,
    damping_ratio: f64,
    /// Of its eigenvalue, 1/s.
    magnitude: f64,
}

/// The modes with these expected values, by rising frequency; none where eigenvalues do not converge.
pub fn modes(model: &MatrixModel, expected: &[f64]) -> Vec<Mode> {
    let matrices = model.matrices();
    let coefficients = matrices.coefficients(&expected[..matrices.parameters.len()]);
    let eigenvalues = model.problem().eigenvalues(&coefficients, &model.regions()).unwrap_or_default();
    let of_pairs = eigenvalues.into_iter().filter(|value| value.im >= 0.0);
    let mode = |value: Eigenvalue| Mode {
        frequency: value.im / std::f64::consts::TAU,
        damping_ratio: damping_ratio(value),
        magnitude: libm::hypot(value.re, value.im),
    };
    let mut modes: Vec<Mode> = of_pairs.map(mode).collect();
    modes.sort_by(|a, b| a.frequency.total_cmp(&b.frequency));
    modes
}

/// The first frequencies, in a line.
pub fn frequencies(model: &MatrixModel, modes: &[Mode]) -> String {
    let oscillating = modes.iter().filter(|mode| mode.frequency > 0.0);
    let shown: Vec<String> = oscillating.take(SHOWN_FREQUENCIES).map(|mode| format!("{:.4}", mode.frequency)).collect();
    let what = match shown.is_empty() {
        true => "no motion of the expected brake oscillates".to_owned(),
        false => format!("the first frequencies of the expected brake in Hz: {}", shown.join(", ")),
    };
    let size = model.matrices().size();
    format!("# {size} {} of freedom; {what}\n", if size == 1 { "degree" } else { "degrees" })
}
