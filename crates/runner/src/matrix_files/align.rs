//! Matrices of one model over the same degrees of freedom.

use std::collections::BTreeSet;

use thiserror::Error;

use super::entries::{Entries, Symmetry};
use super::error::Problem;
use super::matrix::{Place, ReadMatrix};

/// Why matrices do not belong to one model.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{text}")]
pub struct AlignError {
    /// The place in the list of the matrix that does not fit the others.
    pub matrix: usize,
    text: String,
}

impl AlignError {
    fn of(matrix: usize) -> impl Fn(Problem) -> Self {
        move |problem| Self { matrix, text: problem.to_string().trim_start_matches(": ").to_owned() }
    }
}

/// What the matrices have in common.
struct Common {
    /// Number of degrees of freedom, those that are held included.
    size: usize,
    /// By node and direction, where files say them.
    places: Option<Vec<Place>>,
    is_held: Vec<bool>,
    /// Number of those that are not held.
    free: usize,
}

/// Brings matrices to one order of degrees of freedom: those that some of them have, and none that any of them marks as held.
/// Matrices whose files do not say nodes and directions should have the right number of rows.
///
/// # Errors
/// Numbers of rows that differ.
pub fn align(matrices: Vec<ReadMatrix>) -> Result<Vec<ReadMatrix>, AlignError> {
    let common = Common::of(&matrices)?;
    let mut places = common.places.clone();
    if let Some(places) = &mut places {
        let mut is_held = common.is_held.iter();
        places.retain(|_| !is_held.next().copied().unwrap_or_default());
    }
    let place_in = |(at, matrix)| common.place(matrix, places.as_ref()).map_err(AlignError::of(at));
    matrices.into_iter().enumerate().map(place_in).collect()
}

impl Common {
    fn of(matrices: &[ReadMatrix]) -> Result<Self, AlignError> {
        let maps = || matrices.iter().filter_map(|matrix| matrix.degrees_of_freedom.as_ref());
        let all: BTreeSet<Place> = maps().flatten().copied().collect();
        let has_maps = maps().next().is_some();
        let places: Option<Vec<Place>> = has_maps.then(|| all.into_iter().collect());
        let rows = |matrix: &ReadMatrix| matrix.matrix.nrows();
        let known = matrices.iter().filter(|matrix| matrix.has_size).map(rows).max();
        let size = match &places {
            Some(places) => places.len(),
            None => known.or_else(|| matrices.iter().map(rows).max()).unwrap_or_default(),
        };
        let mut is_held = vec![false; size];
        for (at, matrix) in matrices.iter().enumerate() {
            for &row in &matrix.constrained {
                let place = match (&places, &matrix.degrees_of_freedom) {
                    (Some(places), Some(own)) => own.get(row).and_then(|place| places.binary_search(place).ok()),
                    _ => Some(row),
                };
                match place.and_then(|place| is_held.get_mut(place)) {
                    Some(held) => *held = true,
                    None => {
                        let text =
                            format!("row {} is marked as held, but the other matrices have {size} rows", row + 1);
                        return Err(AlignError { matrix: at, text });
                    }
                }
            }
        }
        let free = is_held.iter().filter(|held| !**held).count();
        Ok(Self { size, places, is_held, free })
    }

    /// A matrix over the common degrees of freedom that are not held.
    fn place(&self, mut read: ReadMatrix, free_places: Option<&Vec<Place>>) -> Result<ReadMatrix, Problem> {
        let own = read.matrix.nrows();
        let place_of: Vec<u32> = match (&self.places, &read.degrees_of_freedom) {
            (Some(places), Some(own)) => {
                own.iter().map(|place| places.binary_search(place).unwrap_or_default() as u32).collect()
            }
            _ if own == self.size || (own < self.size && !read.has_size) => (0..own as u32).collect(),
            // Its program has left out what is held.
            _ if own == self.free => (0..self.size as u32).filter(|&row| !self.is_held[row as usize]).collect(),
            _ => return Err(self.does_not_fit(own)),
        };
        if own != self.free || self.free < self.size || place_of.iter().zip(0..).any(|(&place, row)| place != row) {
            let mut number = 0;
            let numbers: Vec<Option<u32>> = self
                .is_held
                .iter()
                .map(|held| {
                    let own = (!held).then_some(number);
                    number += u32::from(!held);
                    own
                })
                .collect();
            let new = |old: usize| place_of.get(old).and_then(|&place| numbers.get(place as usize).copied().flatten());
            let mut entries = Entries::default();
            let (starts, rows, values) = (read.matrix.col_ptr(), read.matrix.row_idx(), read.matrix.val());
            for column in 0..own {
                let Some(new_column) = new(column) else { continue };
                for at in starts[column]..starts[column + 1] {
                    if let Some(new_row) = new(rows[at]) {
                        entries.push(new_row, new_column, values[at])?;
                    }
                }
            }
            read.matrix = entries.into_matrix(self.free, Symmetry::None)?.matrix;
        }
        if let Some(places) = free_places {
            if read.degrees_of_freedom.is_none() {
                read.doubts.push("nodes and directions of its rows are not said: they are taken in the order of nodes, and of directions at a node".to_owned());
            }
            read.degrees_of_freedom = Some(places.clone());
        }
        read.constrained.clear();
        read.has_size = true;
        Ok(read)
    }

    fn does_not_fit(&self, own: usize) -> Problem {
        let held = self.size - self.free;
        let but_for = if held > 0 { format!(", {held} of them held") } else { String::new() };
        Problem::new(format!(
            "the matrix has {own} rows, but the other matrices of the model have {}{but_for}; matrices of one model have the same degrees of freedom",
            self.size
        ))
    }
}
