//! Matrices of CalculiX (`*FREQUENCY, SOLVER=MATRIXSTORAGE`): .sti and .mas with `row column value` of the upper triangle,
//! and .dof beside them with a line `node.direction` for each row.

use super::abaqus;
use super::entries::{Entries, Symmetry};
use super::error::{Problem, quoted};
use super::matrix::{Place, ReadMatrix, Stored};
use super::nodes::{Numbering, place};
use super::source::Source;
use super::text::{Lines, index, number};

pub fn read(source: &mut Source) -> Result<ReadMatrix, Problem> {
    let mut entries = Entries::default();
    abaqus::each_line(source, |line, fields, text| {
        let &[row, column, value] = fields else {
            return Err(Problem::at(line, format!("{} is not `row column value`", quoted(text))));
        };
        entries.push(index(line, row, "row", None)?, index(line, column, "column", None)?, number(line, value)?)
    })?;
    if entries.iter().any(|(row, column, _)| row > column) && entries.iter().any(|(row, column, _)| row < column) {
        return Err(Problem::new("the file has entries on both sides of the diagonal; CalculiX writes one triangle"));
    }
    let implied = entries.implied_size();
    let places = degrees_of_freedom(source)?;
    let size = places.as_ref().map_or(implied, Vec::len);
    if size < implied {
        let text = format!(
            "there are {implied} rows, but the file .dof beside it has {size} degrees of freedom; are both of one run?"
        );
        return Err(Problem::new(text));
    }
    let mut notes =
        vec!["CalculiX writes one triangle of its matrices: friction, which is not symmetric, is lost".to_owned()];
    let (places, has_size) = match places {
        Some(places) => {
            let mut numbering = Numbering::default();
            let numbers: Vec<u32> = places.iter().map(|place| numbering.number(*place)).collect::<Result<_, _>>()?;
            if numbers.iter().zip(0..).any(|(&number, row)| number != row) {
                return Err(Problem::new("a degree of freedom is there twice in the file .dof beside it"));
            }
            (Some(numbering.sort(&mut entries)), true)
        }
        None => {
            notes.push(
                "there is no file .dof beside it, so that nodes and directions of its rows are not known".to_owned(),
            );
            (None, false)
        }
    };
    let mut read = ReadMatrix::new(entries.into_matrix(size, Symmetry::Symmetric)?, Stored::SymmetricTriangle);
    read.degrees_of_freedom = places;
    read.has_size = has_size;
    read.notes.append(&mut notes);
    Ok(read)
}

/// The degrees of freedom in the file beside it, where there is one.
fn degrees_of_freedom(source: &Source) -> Result<Option<Vec<Place>>, Problem> {
    let path = source.path.with_extension("dof");
    if !path.is_file() {
        return Ok(None);
    }
    let mut source = Source::open(&path)?;
    let of_it = |problem: Problem| Problem::new(format!("in the file .dof beside it{problem}"));
    places(&mut source).map(Some).map_err(of_it)
}

fn places(source: &mut Source) -> Result<Vec<Place>, Problem> {
    let mut places = Vec::new();
    let mut lines = Lines::new(source)?;
    while let Some((line, text)) = lines.next()? {
        let text = text.trim();
        if text.is_empty() {
            continue;
        }
        let wrong = || Problem::at(line, format!("{} is not `node.direction`", quoted(text)));
        let (node, direction) = text.split_once('.').ok_or_else(wrong)?;
        places.push(place(line, node, direction)?);
    }
    Ok(places)
}
