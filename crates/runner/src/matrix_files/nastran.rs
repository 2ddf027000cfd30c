//! DMIG of Nastran and OptiStruct (`PARAM,EXTOUT,DMIGPCH`): columns of a matrix by grid point and component.
//!
//! A card has fields of 8 characters or, with an asterisk, of 16; its further lines start with a blank, a plus or an
//! asterisk. Fields may be separated by commas as well.

use std::collections::{HashMap, HashSet};

use super::entries::{Entries, Symmetry};
use super::error::{Problem, quoted};
use super::matrix::{Place, ReadMatrix, Stored};
use super::nodes::{Numbering, place};
use super::source::{Listed, Source, choose};
use super::text::{Lines, number};

/// Most matrices in a file.
const MOST_MATRICES: usize = 4096;

/// Whether a line starts a DMIG card.
pub fn is_dmig(line: &str) -> bool {
    let rest = line.get(..4).filter(|start| start.eq_ignore_ascii_case("DMIG")).and(line.get(4..));
    rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(['*', ' ', ',', '\t']))
}

/// The fields of a line after the first, without blanks: 8 short ones or 4 long ones.
fn fields(line: u64, text: &str, is_long: bool) -> Result<Vec<&str>, Problem> {
    let count = if is_long { 4 } else { 8 };
    if text.contains(',') {
        let mut fields: Vec<&str> = text.split(',').skip(1).map(str::trim).collect();
        fields.resize(count, "");
        return Ok(fields);
    }
    if !text.is_ascii() || text.contains('\t') {
        return Err(Problem::at(line, "the line has tabs or letters beside ASCII, so that its columns are not known"));
    }
    let width = if is_long { 16 } else { 8 };
    let field = |at: usize| {
        let start = (8 + at * width).min(text.len());
        text[start..(start + width).min(text.len())].trim()
    };
    Ok((0..count).map(field).collect())
}

/// What a header says.
struct Header {
    name: String,
    form: String,
    kind: String,
}

impl Header {
    fn problem(&self) -> Option<String> {
        match (&*self.form, &*self.kind) {
            ("9", _) => Some("it is rectangular (IFO is 9); one of mass, damping or stiffness is square".to_owned()),
            (_, "3" | "4") => Some("it is complex (TIN is 3 or 4); write it as a real matrix".to_owned()),
            ("1" | "2" | "6", "0" | "1" | "2" | "") => None,
            ("1" | "2" | "6", kind) => Some(format!("its type of numbers (TIN) is {}, not 1 or 2", quoted(kind))),
            (form, _) => Some(format!("its form (IFO) is {}; 1, 2 and 6 are read", quoted(form))),
        }
    }
}

/// What the further lines of a card go on with.
enum Card {
    /// The header of a matrix that is wanted.
    Header,
    /// A column of it.
    Column(Column),
    Other,
}

/// A column, and the rows that its card has so far.
struct Column {
    place: Place,
    rows: HashSet<Place>,
}

impl Column {
    fn take(
        &mut self,
        line: u64,
        group: &[&str],
        entry: &mut impl FnMut(u64, Place, Place, f64) -> Result<(), Problem>,
    ) -> Result<(), Problem> {
        match group {
            ["", "", "", ..] => Ok(()),
            [node, direction, value, imaginary] => {
                if !imaginary.is_empty() && number(line, imaginary)? != 0.0 {
                    return Err(Problem::at(line, "the entry is complex; write real matrices"));
                }
                let row = place(line, node, direction)?;
                if !self.rows.insert(row) {
                    let text = format!(
                        "the row of grid point {node} and component {direction} is there twice in one card, of the column of grid point {} and component {}; the card of another column may be missing before it",
                        self.place.0, self.place.1
                    );
                    return Err(Problem::at(line, text));
                }
                entry(line, self.place, row, number(line, value)?)
            }
            _ => Err(Problem::at(line, "the entry has no grid point, component and value")),
        }
    }
}

/// Gives every header and every group of column, row and value to `header` and `entry`; groups of what is wanted only.
fn each(
    source: &mut Source,
    mut header: impl FnMut(u64, Header) -> Result<(), Problem>,
    is_wanted: impl Fn(u64, &str) -> Result<bool, Problem>,
    mut entry: impl FnMut(u64, Place, Place, f64) -> Result<(), Problem>,
) -> Result<(), Problem> {
    let mut lines = Lines::new(source)?;
    let mut card = Card::Other;
    while let Some((line, text)) = lines.next()? {
        if text.trim().is_empty() || text.starts_with('$') {
            continue;
        }
        if is_dmig(text) {
            let fields = fields(line, text, text.get(4..5) == Some("*"))?;
            let wanted = is_wanted(line, fields[0])?;
            card = Card::Other;
            if fields[1] == "0" {
                if wanted {
                    card = Card::Header;
                }
                let [name, form, kind] = [fields[0], fields[2], fields[3]].map(str::to_owned);
                header(line, Header { name, form, kind })?;
            } else if wanted {
                let mut column = Column { place: place(line, fields[1], fields[2])?, rows: HashSet::new() };
                // A card of long fields has none left for an entry.
                fields[4..].chunks(4).try_for_each(|group| column.take(line, group, &mut entry))?;
                card = Card::Column(column);
            }
        } else if text.starts_with([' ', '+', '*', ',']) {
            let fields = || fields(line, text, text.starts_with('*'));
            match &mut card {
                Card::Column(column) => {
                    fields()?.chunks(4).try_for_each(|group| column.take(line, group, &mut entry))?;
                }
                // A header of long fields goes on with TOUT, POLAR, nothing and NCOL.
                Card::Header if !fields()?[2].is_empty() => {
                    let text = "there is an entry after the header; the card of its column is missing before it";
                    return Err(Problem::at(line, text));
                }
                Card::Header | Card::Other => {}
            }
        } else {
            // Another card.
            card = Card::Other;
        }
    }
    lines.whole()
}

fn headers(source: &mut Source) -> Result<Vec<(Listed, Header)>, Problem> {
    let mut found: Vec<(Listed, Header)> = Vec::new();
    let take = |line, header: Header| {
        if found.iter().any(|(listed, _)| listed.name == header.name) {
            return Err(Problem::at(line, format!("matrix {} starts a second time", quoted(&header.name))));
        }
        if found.len() == MOST_MATRICES {
            return Err(Problem::at(line, format!("the file has more than {MOST_MATRICES} matrices, the limit")));
        }
        let listed = Listed { name: header.name.clone(), problem: header.problem() };
        found.push((listed, header));
        Ok(())
    };
    each(source, take, |_, _| Ok(false), |_, _, _, _| Ok(()))?;
    Ok(found)
}

/// The names of the matrices.
pub fn list(source: &mut Source) -> Result<Vec<Listed>, Problem> {
    Ok(headers(source)?.into_iter().map(|(listed, _)| listed).collect())
}

pub fn read(source: &mut Source, name: Option<&str>) -> Result<ReadMatrix, Problem> {
    let (listed, headers): (Vec<Listed>, Vec<Header>) = headers(source)?.into_iter().unzip();
    let chosen = &headers[choose(&listed, name)?];
    let mut entries = Entries::default();
    let mut numbering = Numbering::default();
    // The rows that have entries: in which line the first is, and whether the diagonal is given.
    let mut rows: HashMap<Place, (u64, bool)> = HashMap::new();
    each(
        source,
        |_, _| Ok(()),
        |line, name| {
            if headers.iter().any(|header| header.name == name) {
                return Ok(name == chosen.name);
            }
            let name = quoted(name);
            let text = format!("the column is of matrix {name}, which has no header (with 0 for the grid point)");
            Err(Problem::at(line, text))
        },
        |line, column, row, value| {
            if row == column || value != 0.0 {
                rows.entry(row).or_insert((line, false)).1 |= row == column;
            }
            entries.push(numbering.number(row)?, numbering.number(column)?, value)
        },
    )?;
    let of_it = |problem: Problem| problem.of_matrix(&chosen.name);
    let places = numbering.sort(&mut entries);
    let (symmetry, stored) = match &*chosen.form {
        "6" => (Symmetry::Symmetric, Stored::SymmetricTriangle),
        _ => (Symmetry::None, Stored::General),
    };
    let mut read = ReadMatrix::new(entries.into_matrix(places.len(), symmetry).map_err(of_it)?, stored);
    let without = rows.iter().filter(|(_, (_, has_diagonal))| !has_diagonal);
    if symmetry == Symmetry::Symmetric
        && let Some(((node, direction), (line, _))) = without.min_by_key(|(row, (line, _))| (*line, **row))
    {
        read.doubts.push(format!(
            "line {line}: the row of grid point {node} and component {direction} has an entry, but none on the diagonal; is the card of its column missing?"
        ));
    }
    read.degrees_of_freedom = Some(places);
    if chosen.form == "2" {
        read.doubts.push("the file calls the matrix rectangular (IFO is 2); it is read over all grid points and components of its rows and columns".to_owned());
    }
    Ok(read)
}
