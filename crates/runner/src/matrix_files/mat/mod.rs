//! MAT files of MATLAB (level 5: `save -v6` and `-v7`), also those of Octave and SciPy.
//!
//! A file is a list of elements, one for each variable, perhaps compressed each by itself. Only the heads of variables are
//! read until the wanted one is found.

mod element;

mod array;

use super::error::Problem;
use super::matrix::{ReadMatrix, Stored};
use super::numbers::Order;
use super::source::{Listed, Source, choose};
use array::Head;
use element::Body;

/// The first bytes of HDF5.
pub const HDF5: &[u8] = b"\x89HDF\r\n\x1a\n";

/// Length of the text at the start of a file, and of the version and the order of bytes after it.
const HEADER: usize = 128;

/// Most variables in a file.
const MOST_VARIABLES: usize = 1 << 16;

const SAVE: &str = "save it in MATLAB with `save('brake.mat', 'M', 'K', '-v7')`";

/// What a file named .mat is, by its first bytes.
enum Level {
    Five(Order),
    Other(String),
}

/// Whether these are the first bytes of a MAT file of any level, or of what programs write under this name.
pub fn is_one(head: &[u8], extension: &str) -> bool {
    extension == "mat" || head.starts_with(b"MATLAB 5.0 MAT-file") || head.starts_with(b"MATLAB 7.3 MAT-file")
}

fn level(head: &[u8]) -> Level {
    if head.starts_with(b"MATLAB 7.3") || head.starts_with(HDF5) || head.get(512..520) == Some(HDF5) {
        return Level::Other(format!("this is a MAT file of version 7.3 (HDF5), which is not read; {SAVE}"));
    }
    if head.starts_with(b"# Created by Octave") || head.starts_with(b"Octave-1") {
        return Level::Other("this is a file in Octave's own format; save it with `save -v7 brake.mat M K`".to_owned());
    }
    match head.get(124..HEADER) {
        Some(&[0, 1, b'I', b'M']) => Level::Five(Order::Little),
        Some(&[1, 0, b'M', b'I']) => Level::Five(Order::Big),
        // Those of level 4 start with a number whose four decimal digits are small.
        _ if head.len() > 20 && (head[..4].ends_with(&[0, 0]) || head.starts_with(&[0, 0])) => {
            Level::Other(format!("this is a MAT file of version 4, which is not read; {SAVE}"))
        }
        _ => Level::Other(format!("this is no MAT file of version 5 to 7; {SAVE}")),
    }
}

/// A variable and the place of its element.
struct Variable {
    place: u64,
    head: Head,
}

fn variables(source: &mut Source) -> Result<(Order, Vec<Variable>), Problem> {
    let head = source.head()?;
    let order = match level(&head) {
        Level::Five(order) => order,
        Level::Other(what) => return Err(Problem::new(what)),
    };
    let mut place = HEADER as u64;
    let mut found = Vec::new();
    while place < source.length {
        let (mut body, next) = Body::at(source, place, order)?;
        if let Some(head) = Head::read(&mut body)? {
            found.push(Variable { place, head });
        }
        if found.len() > MOST_VARIABLES {
            return Err(Problem::new(format!("the file has more than {MOST_VARIABLES} variables, the limit")));
        }
        place = next;
    }
    Ok((order, found))
}

fn listed(variables: &[Variable]) -> Vec<Listed> {
    variables.iter().map(|one| Listed { name: one.head.name.clone(), problem: one.head.problem() }).collect()
}

/// All variables.
pub fn list(source: &mut Source) -> Result<Vec<Listed>, Problem> {
    Ok(listed(&variables(source)?.1))
}

pub fn read(source: &mut Source, name: Option<&str>) -> Result<ReadMatrix, Problem> {
    let (order, variables) = variables(source)?;
    let chosen = &variables[choose(&listed(&variables), name)?];
    let of_it = |problem: Problem| problem.of_matrix(&chosen.head.name);
    let length = source.length;
    let (mut body, _) = Body::at(source, chosen.place, order)?;
    let head = Head::read(&mut body)?.ok_or_else(|| Problem::new("the file changed while it was read"))?;
    let built = array::read(&mut body, &head, length).map_err(of_it)?;
    body.finish().map_err(of_it)?;
    Ok(ReadMatrix::new(built, Stored::General))
}
