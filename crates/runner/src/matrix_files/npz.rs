//! Archives of NumPy (.npz): full arrays with names, or the one sparse matrix of `scipy.sparse.save_npz`.

use std::io::Read as _;

use super::entries::{Entries, MOST_ENTRIES, Symmetry, from_columns, most_entries, square};
use super::error::{Problem, quoted};
use super::matrix::{ReadMatrix, Stored};
use super::npy::{self, Content as Kind, Header};
use super::numbers::{ended, index};
use super::source::{Listed, Source, choose, no_name};
use super::zip::{Content, Member, find, members};

const ENDING: &str = ".npy";

/// Most dimensions in the shape of a sparse matrix.
const MOST_DIMENSIONS: u64 = 32;

/// The arrays in an archive of full ones; `None` where it has one sparse matrix.
pub fn list(source: &mut Source) -> Result<Option<Vec<Listed>>, Problem> {
    let members = members(source)?;
    if is_sparse(&members) {
        return Ok(None);
    }
    let mut listed = Vec::new();
    for member in &members {
        let Some(name) = member.name.strip_suffix(ENDING).map(str::to_owned) else { continue };
        // What is wrong with a matrix matters to who asks for it.
        let header = Content::open(source, member).and_then(|mut content| Header::read(&mut content, member.size));
        let problem = header.map_or_else(|problem| Some(problem.to_string()), |header| header.problem());
        listed.push(Listed { name, problem: problem.map(|text| text.trim_start_matches(": ").to_owned()) });
    }
    Ok(Some(listed))
}

fn is_sparse(members: &[Member]) -> bool {
    ["format.npy", "shape.npy", "data.npy"].iter().all(|name| find(members, name).is_ok())
}

pub fn read(source: &mut Source, name: Option<&str>) -> Result<ReadMatrix, Problem> {
    let members = members(source)?;
    if is_sparse(&members) {
        no_name(name)?;
        return sparse(&mut Archive { source, members });
    }
    let listed = list(source)?.unwrap_or_default();
    let name = &listed[choose(&listed, name)?].name;
    let of_it = |problem: Problem| problem.of_matrix(name);
    let member = find(&members, &format!("{name}{ENDING}")).map_err(of_it)?;
    let length = source.length;
    let mut content = Content::open(source, member).map_err(of_it)?;
    let read = npy::read(&mut content, member.size, length).map_err(of_it)?;
    content.finish().map_err(of_it)?;
    Ok(read)
}

struct Archive<'a> {
    source: &'a mut Source,
    members: Vec<Member>,
}

impl Archive<'_> {
    /// How many entries are read of a matrix of this size.
    fn most_entries(&self, size: usize) -> usize {
        most_entries(size, self.source.length)
    }

    /// What an array says of itself.
    fn header(&mut self, name: &str) -> Result<Header, Problem> {
        let member = find(&self.members, &format!("{name}{ENDING}"))?;
        Header::read(&mut Content::open(self.source, member)?, member.size)
    }

    /// Gives all numbers of an array, at most so many, to `take`.
    fn numbers(
        &mut self,
        name: &str,
        most: u64,
        mut take: impl FnMut(f64) -> Result<(), Problem>,
    ) -> Result<(), Problem> {
        let of_it = |problem: Problem| Problem::new(format!("array {}{problem}", quoted(name)));
        let member = find(&self.members, &format!("{name}{ENDING}"))?;
        let mut content = Content::open(self.source, member).map_err(of_it)?;
        let header = Header::read(&mut content, member.size).map_err(of_it)?;
        if header.count() > most {
            let why = match name {
                "shape" | "indptr" | "offsets" => "; the file is damaged",
                _ => {
                    " by the rows of the matrix and the length of the compressed file; save it with compressed=False if it is sound"
                }
            };
            return Err(of_it(Problem::new(format!(
                "it has {} numbers, but should have {most} at most{why}",
                header.count()
            ))));
        }
        header.each(&mut content, &mut take).map_err(of_it)?;
        content.finish().map_err(of_it)
    }

    fn list<T>(&mut self, name: &str, most: u64, of: impl Fn(f64) -> Result<T, Problem>) -> Result<Vec<T>, Problem> {
        let mut list = Vec::new();
        self.numbers(name, most, |value| {
            list.push(of(value)?);
            Ok(())
        })?;
        Ok(list)
    }

    /// The name of the format, as bytes or as text of four bytes a character.
    fn format(&mut self) -> Result<String, Problem> {
        let member = find(&self.members, "format.npy")?;
        let mut content = Content::open(self.source, member)?;
        let header = Header::read(&mut content, member.size)?;
        let Kind::Text { .. } = header.content else {
            return Err(Problem::new("the array `format` is no text; the file is damaged"));
        };
        let mut bytes = Vec::new();
        content.by_ref().take(64).read_to_end(&mut bytes).map_err(|error| ended(&error))?;
        content.finish()?;
        bytes.retain(|byte| *byte != 0);
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    }
}

fn sparse(archive: &mut Archive<'_>) -> Result<ReadMatrix, Problem> {
    let format = archive.format()?;
    let shape =
        archive.list("shape", MOST_DIMENSIONS, |value| Ok(if value >= 0.0 { value as u64 } else { u64::MAX }))?;
    let &[rows, columns] = &shape[..] else {
        return Err(Problem::new(format!("the array has {} dimensions, not the two of a matrix", shape.len())));
    };
    let size = square(rows, columns)?;
    let built = match &*format {
        "csc" => {
            let starts = starts(archive, size)?;
            let most = archive.most_entries(size) as u64;
            let rows = archive.list("indices", most, index)?;
            from_columns(size, starts, rows, archive.list("data", most, Ok)?)?
        }
        "csr" => by_rows(archive, size, Blocks::ENTRIES)?.into_matrix(size, Symmetry::None)?,
        "bsr" => {
            let blocks = blocks(archive)?;
            by_rows(archive, size, blocks)?.into_matrix(size, Symmetry::None)?
        }
        "coo" => coordinates(archive, size)?.into_matrix(size, Symmetry::None)?,
        "dia" => diagonals(archive, size)?.into_matrix(size, Symmetry::None)?,
        other => {
            return Err(Problem::new(format!(
                "the sparse format {} is none of csc, csr, bsr, coo and dia",
                quoted(other)
            )));
        }
    };
    Ok(ReadMatrix::new(built, Stored::General))
}

/// Where each of `count` rows or columns starts, and the end of the last one.
fn starts(archive: &mut Archive<'_>, count: usize) -> Result<Vec<usize>, Problem> {
    archive.list("indptr", count as u64 + 1, |value| index(value).map(|start| start as usize))
}

/// How `data` holds blocks of entries.
#[derive(Clone, Copy)]
struct Blocks {
    count: usize,
    height: usize,
    width: usize,
    /// Whether the first index changes fastest, not the last one.
    is_by_columns: bool,
}

impl Blocks {
    /// Every entry is one.
    const ENTRIES: Self = Self { count: 1, height: 1, width: 1, is_by_columns: false };

    /// The block of a number of `data`, and the row and column in it.
    fn place(&self, at: usize) -> [usize; 3] {
        let Self { count, height, width, is_by_columns } = *self;
        if is_by_columns {
            [at % count, at / count % height, at / count / height]
        } else {
            [at / width / height, at / width % height, at % width]
        }
    }
}

fn blocks(archive: &mut Archive<'_>) -> Result<Blocks, Problem> {
    let header = archive.header("data")?;
    let is_by_columns = header.is_by_columns;
    match header.shape[..] {
        [count, height, width] if height > 0 && width > 0 && header.count() <= MOST_ENTRIES as u64 => {
            let [count, height, width] = [count.max(1), height, width].map(|size| size as usize);
            Ok(Blocks { count, height, width, is_by_columns })
        }
        _ => Err(Problem::new(format!("the blocks have the shape {:?}; the file is damaged", header.shape))),
    }
}

/// Entries row by row, or blocks of entries.
fn by_rows(archive: &mut Archive<'_>, size: usize, blocks: Blocks) -> Result<Entries, Problem> {
    let Blocks { height, width, .. } = blocks;
    let rows = size.div_ceil(height);
    let starts = starts(archive, rows)?;
    let most = archive.most_entries(size);
    let columns = archive.list("indices", most as u64, index)?;
    let per_block = height.saturating_mul(width);
    let follow = starts.windows(2).all(|pair| pair[0] <= pair[1]);
    if starts.len() != rows + 1 || starts[0] != 0 || !follow || starts[rows] > columns.len() {
        return Err(Problem::new(format!(
            "`indptr` does not rise from 0 to the number of entries in {rows} steps; the file is damaged"
        )));
    }
    let mut entries = Entries::at_most(most);
    let (mut at, mut row) = (0, 0);
    let last = starts[rows].saturating_mul(per_block);
    archive.numbers("data", MOST_ENTRIES as u64, |value| {
        let [number, inside_row, inside_column] = blocks.place(at);
        at += 1;
        if value != 0.0 && number < starts[rows] {
            // Blocks come in rising order, and by columns again and again.
            if number < starts[row] {
                row = 0;
            }
            while starts[row + 1] <= number {
                row += 1;
            }
            let place = |block: usize, length: usize, inside: usize| {
                let place = block.checked_mul(length).and_then(|start| start.checked_add(inside));
                place.and_then(|place| u32::try_from(place).ok()).unwrap_or(u32::MAX)
            };
            let column = place(columns[number] as usize, width, inside_column);
            entries.push(place(row, height, inside_row), column, value)?;
        }
        Ok(())
    })?;
    if at < last {
        return Err(Problem::new(format!("there are {at} values where {last} are due; the file is damaged")));
    }
    Ok(entries)
}

fn coordinates(archive: &mut Archive<'_>, size: usize) -> Result<Entries, Problem> {
    let most = archive.most_entries(size);
    // Later versions of SciPy may write both as one array.
    let [rows, columns] = if find(&archive.members, "coords.npy").is_ok() {
        let header = archive.header("coords")?;
        if !matches!(header.shape[..], [2, _]) {
            return Err(Problem::new(format!(
                "the array `coords` has the shape {:?}, not the two rows of a matrix; the file is damaged",
                header.shape
            )));
        }
        let all = archive.list("coords", 2 * most as u64, index)?;
        if header.is_by_columns {
            [0, 1].map(|first| all.iter().skip(first).step_by(2).copied().collect::<Vec<u32>>())
        } else {
            let (rows, columns) = all.split_at(all.len() / 2);
            [rows.to_vec(), columns.to_vec()]
        }
    } else {
        [archive.list("row", most as u64, index)?, archive.list("col", most as u64, index)?]
    };
    let mut entries = Entries::at_most(most);
    let mut at = 0;
    let count = rows.len();
    let wrong = || Problem::new("rows, columns and values of the entries are not equally many; the file is damaged");
    archive.numbers("data", most as u64, |value| {
        let (Some(&row), Some(&column)) = (rows.get(at), columns.get(at)) else { return Err(wrong()) };
        at += 1;
        entries.push(row, column, value)
    })?;
    if at == count && columns.len() == count { Ok(entries) } else { Err(wrong()) }
}

/// Diagonals, each with its values at the places of their columns.
fn diagonals(archive: &mut Archive<'_>, size: usize) -> Result<Entries, Problem> {
    let most = archive.most_entries(size);
    let offsets = archive.list("offsets", (2 * size as u64).min(most as u64), Ok)?;
    let header = archive.header("data")?;
    let long = match header.shape[..] {
        [count, long] if count == offsets.len() as u64 => long.max(1) as usize,
        _ => {
            return Err(Problem::new(format!(
                "the {} diagonals have the shape {:?}; the file is damaged",
                offsets.len(),
                header.shape
            )));
        }
    };
    let mut entries = Entries::at_most(most);
    let mut at = 0;
    archive.numbers("data", MOST_ENTRIES as u64, |value| {
        let (diagonal, column) = match header.is_by_columns {
            true => (at % offsets.len().max(1), at / offsets.len().max(1)),
            false => (at / long, at % long),
        };
        at += 1;
        let row = offsets.get(diagonal).map_or(f64::NAN, |offset| column as f64 - offset);
        if value != 0.0 && column < size && row >= 0.0 && row < size as f64 {
            entries.push(index(row)?, column as u32, value)?;
        }
        Ok(())
    })?;
    Ok(entries)
}
