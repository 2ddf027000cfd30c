//! Degrees of freedom that are given by node and direction.

use std::collections::HashMap;

use super::entries::{Entries, MOST_ROWS, Symmetry};
use super::error::{Problem, quoted};
use super::matrix::Place;

/// Largest number of a direction: programs have 1 to 6, and a few more for temperatures and warping.
const LARGEST_DIRECTION: u32 = 999;

/// Least value on the diagonal by which Abaqus says that a degree of freedom is held: 1e36, but for rounding.
const HELD: f64 = 0.999e36;

/// Numbers of degrees of freedom in the order in which they come.
#[derive(Debug, Default)]
pub struct Numbering {
    numbers: HashMap<Place, u32>,
    places: Vec<Place>,
}

impl Numbering {
    pub fn number(&mut self, place: Place) -> Result<u32, Problem> {
        if let Some(&number) = self.numbers.get(&place) {
            return Ok(number);
        }
        if self.places.len() == MOST_ROWS {
            return Err(Problem::new(format!("the matrix has more than {MOST_ROWS} rows, the limit")));
        }
        let number = self.places.len() as u32;
        self.numbers.insert(place, number);
        self.places.push(place);
        Ok(number)
    }

    /// The degrees of freedom by node and direction, with the entries numbered so.
    pub fn sort(self, entries: &mut Entries) -> Vec<Place> {
        let mut order: Vec<u32> = (0..self.places.len() as u32).collect();
        order.sort_by_key(|&number| self.places[number as usize]);
        let mut new = vec![0; order.len()];
        order.iter().zip(0..).for_each(|(&old, number)| new[old as usize] = number);
        entries.renumber(|old| new[old as usize]);
        order.iter().map(|&old| self.places[old as usize]).collect()
    }
}

/// The degree of freedom that two words name.
pub fn place(line: u64, node: &str, direction: &str) -> Result<Place, Problem> {
    let node = node.parse().map_err(|_| Problem::at(line, format!("{} is no number of a node", quoted(node))))?;
    match direction.parse() {
        Ok(direction) if direction <= LARGEST_DIRECTION => Ok((node, direction)),
        _ => {
            let text = format!("{} is no direction of a degree of freedom, such as 1 to 6", quoted(direction));
            Err(Problem::at(line, text))
        }
    }
}

/// Takes out the rows and columns that are marked as held by 1e36 on the diagonal, and says which they are.
pub fn take_held(entries: &mut Entries, size: usize) -> Vec<usize> {
    let mut is_held = vec![false; size];
    for (row, column, value) in entries.iter() {
        if row == column && value >= HELD {
            is_held[row as usize] = true;
        }
    }
    if is_held.contains(&true) {
        entries.retain(|row, column, _| !is_held[row as usize] && !is_held[column as usize]);
    }
    (0..size).filter(|&row| is_held[row]).collect()
}

/// Whether entries are one triangle of a symmetric matrix, in formats that do not say it, with what is doubtful about that.
///
/// A symmetric matrix of a model has a diagonal wherever it has anything. A friction stiffness may have entries on one side
/// of the diagonal alone, but not such a diagonal.
pub fn symmetry(entries: &Entries, size: usize) -> (Symmetry, Option<String>) {
    let mut has_diagonal = vec![false; size];
    let (mut is_lower, mut is_upper) = (false, false);
    for (row, column, value) in entries.iter().filter(|entry| entry.2 != 0.0) {
        is_lower |= row > column;
        is_upper |= row < column;
        has_diagonal[row as usize] |= row == column && value != 0.0;
    }
    let side = match (is_lower, is_upper) {
        (true, false) => "below",
        (false, true) => "above",
        _ => return (Symmetry::None, None),
    };
    let lacks = |index: u32| !has_diagonal[index as usize];
    if entries.iter().any(|(row, column, value)| value != 0.0 && (lacks(row) || lacks(column))) {
        let note = format!(
            "all entries off the diagonal are {side} it, but some rows have none on it: the matrix is read as one that is not symmetric"
        );
        return (Symmetry::None, Some(note));
    }
    (Symmetry::Symmetric, None)
}
