//! Matrices of Abaqus, `*MATRIX OUTPUT` with FORMAT=MATRIX INPUT (`node, direction, node, direction, value`) and with
//! FORMAT=COORDINATE (`row column value`, from 1). Neither says whether it is one triangle of a symmetric matrix.

use std::collections::HashSet;

use super::entries::{Entries, Symmetry};
use super::error::{Problem, quoted};
use super::matrix::{ReadMatrix, Stored};
use super::nodes::{Numbering, place, symmetry, take_held};
use super::source::Source;
use super::text::{Lines, index, number, words};
use crate::output::counted;

/// Most words of a line that are looked at.
const MOST_WORDS: usize = 6;

/// Entries of nodes that Abaqus adds to a model.
#[derive(Default)]
struct Internal {
    entries: usize,
    nodes: HashSet<i64>,
}

impl Internal {
    fn refuse(&self) -> Result<(), Problem> {
        if self.entries == 0 {
            return Ok(());
        }
        Err(Problem::new(format!(
            "{} of {} (numbers below 1): Lagrange multipliers of contact, hybrid elements or couplings, which have no mass; write the model with penalty contact, without hybrid elements and with kinematic couplings",
            counted(self.entries as u128, "entry is", "entries are"),
            counted(self.nodes.len() as u128, "internal node", "internal nodes")
        )))
    }
}

pub fn read_matrix_input(source: &mut Source) -> Result<ReadMatrix, Problem> {
    let mut entries = Entries::default();
    let mut numbering = Numbering::default();
    let mut internal = Internal::default();
    each_line(source, |line, fields, text| {
        let &[row_node, row_direction, column_node, column_direction, value] = fields else {
            return Err(Problem::at(
                line,
                format!("{} is not `node, direction, node, direction, value`", quoted(text)),
            ));
        };
        let (row, column) = (place(line, row_node, row_direction)?, place(line, column_node, column_direction)?);
        let value = number(line, value)?;
        if row.0 < 1 || column.0 < 1 {
            if value != 0.0 {
                internal.entries += 1;
                internal.nodes.extend([row.0, column.0].into_iter().filter(|node| *node < 1));
            }
            return Ok(());
        }
        entries.push(numbering.number(row)?, numbering.number(column)?, value)
    })?;
    internal.refuse()?;
    let places = numbering.sort(&mut entries);
    let size = places.len();
    let mut read = finished(entries, size)?;
    read.degrees_of_freedom = Some(places);
    Ok(read)
}

pub fn read_coordinate(source: &mut Source) -> Result<ReadMatrix, Problem> {
    let mut entries = Entries::default();
    // What the first line would be as one with the numbers of rows, columns and entries, and which line that is.
    let mut sizes: Option<(u64, Option<u64>)> = None;
    each_line(source, |line, fields, text| {
        let &[row, column, value] = fields else {
            return Err(Problem::at(line, format!("{} is not `row column value`", quoted(text))));
        };
        sizes.get_or_insert_with(|| (line, value.parse().ok()));
        entries.push(index(line, row, "row", None)?, index(line, column, "column", None)?, number(line, value)?)
    })?;
    let size = entries.implied_size();
    if let (Some((line, Some(count))), Some((rows, columns, _))) = (sizes, entries.iter().next())
        && entries.iter().skip(1).count() as u64 == count
        && entries.iter().all(|(row, column, _)| row <= rows && column <= columns)
    {
        let text = format!(
            "this may be an entry, or a line of Matrix Market for {} rows, {} columns and the {count} entries that follow; put `%%MatrixMarket matrix coordinate real general` (or symmetric) before it, or write the entry as {count}.0",
            rows + 1,
            columns + 1
        );
        return Err(Problem::at(line, text));
    }
    let mut read = finished(entries, size)?;
    read.has_size = false;
    Ok(read)
}

/// Gives the words of every line to `take`, but of comments.
pub fn each_line(
    source: &mut Source,
    mut take: impl FnMut(u64, &[&str], &str) -> Result<(), Problem>,
) -> Result<(), Problem> {
    let mut lines = Lines::new(source)?;
    while let Some((line, text)) = lines.next()? {
        let text = text.trim();
        if text.is_empty() || text.starts_with("**") {
            continue;
        }
        let mut fields = [""; MOST_WORDS];
        let mut count = 0;
        for (field, word) in fields.iter_mut().zip(words(text)) {
            *field = word;
            count += 1;
        }
        take(line, &fields[..count], text)?;
    }
    lines.whole()
}

fn finished(mut entries: Entries, size: usize) -> Result<ReadMatrix, Problem> {
    let constrained = take_held(&mut entries, size);
    let (symmetry, note) = symmetry(&entries, size);
    let stored = if symmetry == Symmetry::None { Stored::General } else { Stored::SymmetricTriangle };
    let mut read = ReadMatrix::new(entries.into_matrix(size, symmetry)?, stored);
    if !constrained.is_empty() {
        read.notes.push(format!(
            "degrees of freedom that are held (1e36 on the diagonal) are taken out of all matrices: {}",
            constrained.len()
        ));
    }
    read.doubts.extend(note);
    read.constrained = constrained;
    Ok(read)
}
