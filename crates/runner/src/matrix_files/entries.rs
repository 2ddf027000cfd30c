//! Entries of a matrix, collected as a file gives them and put into columns.
//!
//! Entries that are given twice are added in the order of the file, so that the result has the same bits everywhere.

use faer::sparse::{SparseColMat, SymbolicSparseColMat};

use super::error::Problem;

/// Most rows of a matrix: the largest models of brakes have a tenth of them.
pub const MOST_ROWS: usize = 1 << 24;

/// Most entries of a matrix: 4 GiB of them.
pub const MOST_ENTRIES: usize = 1 << 28;

/// Entries of a compressed matrix that are always read, and how many more for each byte of its file. Deflate can make a
/// hundred entries of a byte, but makes hardly one where they are those of a model.
const FEW: usize = 1 << 20;
const MOST_PER_BYTE: u64 = 16;

/// Entries that are reserved on the word of a file alone.
const MOST_RESERVED: usize = 1 << 16;

/// What entries say of those on the other side of the diagonal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Symmetry {
    None,
    /// One triangle is given: the other is its mirror image.
    Symmetric,
    /// One triangle is given: the other has the opposite signs.
    Skew,
}

/// A square matrix, and how many of its entries were given more than once.
#[derive(Debug)]
pub struct Built {
    pub matrix: SparseColMat<usize, f64>,
    pub added: usize,
}

/// Entries, each with its row and column.
#[derive(Debug)]
pub struct Entries {
    rows: Vec<u32>,
    columns: Vec<u32>,
    values: Vec<f64>,
    most: usize,
}

impl Default for Entries {
    fn default() -> Self {
        Self::at_most(MOST_ENTRIES)
    }
}

impl Entries {
    /// So many at most.
    pub fn at_most(most: usize) -> Self {
        Self { rows: Vec::new(), columns: Vec::new(), values: Vec::new(), most }
    }

    /// Room for a number of entries that the length of the file does not rule out.
    pub fn with_room(count: usize) -> Self {
        let mut entries = Self::default();
        let count = count.min(MOST_RESERVED);
        entries.rows.reserve_exact(count);
        entries.columns.reserve_exact(count);
        entries.values.reserve_exact(count);
        entries
    }

    /// Adds an entry. Rows and columns count from 0; `into_matrix` compares them with the size.
    ///
    /// # Errors
    /// Too many entries.
    pub fn push(&mut self, row: u32, column: u32, value: f64) -> Result<(), Problem> {
        if self.values.len() >= self.most {
            return Err(too_many_entries(self.most));
        }
        self.rows.push(row);
        self.columns.push(column);
        self.values.push(value);
        Ok(())
    }

    /// All entries: row, column, value.
    pub fn iter(&self) -> impl Iterator<Item = (u32, u32, f64)> + '_ {
        self.rows.iter().zip(&self.columns).zip(&self.values).map(|((&row, &column), &value)| (row, column, value))
    }

    /// Keeps the entries for which `keep` is true.
    pub fn retain(&mut self, keep: impl Fn(u32, u32, f64) -> bool) {
        let mut kept = 0;
        for at in 0..self.values.len() {
            if keep(self.rows[at], self.columns[at], self.values[at]) {
                self.rows[kept] = self.rows[at];
                self.columns[kept] = self.columns[at];
                self.values[kept] = self.values[at];
                kept += 1;
            }
        }
        self.rows.truncate(kept);
        self.columns.truncate(kept);
        self.values.truncate(kept);
    }

    /// Gives rows and columns other numbers.
    pub fn renumber(&mut self, number: impl Fn(u32) -> u32) {
        self.rows.iter_mut().chain(&mut self.columns).for_each(|index| *index = number(*index));
    }

    /// The number of rows that the largest row or column asks for.
    pub fn implied_size(&self) -> usize {
        self.rows.iter().chain(&self.columns).max().map_or(0, |&largest| largest as usize + 1)
    }

    /// The matrix that has these entries.
    ///
    /// # Errors
    /// Entries outside the matrix, sums that are no finite numbers, too many entries, and entries of a triangle that are
    /// given twice, as nothing says whether they are to be added.
    pub fn into_matrix(self, size: usize, symmetry: Symmetry) -> Result<Built, Problem> {
        check_size(size)?;
        if let Some((row, column, _)) = self.iter().find(|&(row, column, _)| row.max(column) as usize >= size) {
            return Err(outside(row as usize, column as usize, size));
        }
        if symmetry == Symmetry::Skew
            && let Some((row, ..)) = self.iter().find(|entry| entry.0 == entry.1 && entry.2 != 0.0)
        {
            let text = format!(
                "the matrix is said to be skew-symmetric, but has an entry on the diagonal, in row {}",
                row + 1
            );
            return Err(Problem::new(text));
        }
        let has_mirror = |row: u32, column: u32| symmetry != Symmetry::None && row != column;
        let mut ends = vec![0_usize; size + 1];
        for (row, column, _) in self.iter() {
            ends[column as usize + 1] += 1;
            if has_mirror(row, column) {
                ends[row as usize + 1] += 1;
            }
        }
        for column in 0..size {
            ends[column + 1] += ends[column];
        }
        let total = ends[size];
        if total > MOST_ENTRIES {
            return Err(too_many_entries(MOST_ENTRIES));
        }
        let (mut rows, mut values) = (vec![0_u32; total], vec![0.0; total]);
        let mut next = ends.clone();
        let mut put = |row: u32, column: u32, value: f64| {
            let place = &mut next[column as usize];
            rows[*place] = row;
            values[*place] = value;
            *place += 1;
        };
        for (row, column, value) in self.iter() {
            put(row, column, value);
            if has_mirror(row, column) {
                put(column, row, if symmetry == Symmetry::Skew { -value } else { value });
            }
        }
        drop(self);
        let (built, twice) = tidied(size, ends, rows, values)?;
        match twice {
            Some((row, column)) if symmetry != Symmetry::None => Err(Problem::new(format!(
                "one triangle of the matrix should be given, but the entry of row {} and column {} is given twice, perhaps once in each triangle",
                row.max(column) + 1,
                row.min(column) + 1
            ))),
            _ => Ok(built),
        }
    }
}

/// The matrix whose column j has the rows and values from `starts[j]` up to `starts[j + 1]`, in any order.
///
/// # Errors
/// Columns that do not follow each other, rows outside the matrix, and sums that are no finite numbers.
pub fn from_columns(size: usize, starts: Vec<usize>, rows: Vec<u32>, values: Vec<f64>) -> Result<Built, Problem> {
    check_size(size)?;
    let follow = starts.windows(2).all(|pair| pair[0] <= pair[1]);
    let end = starts.last().copied().unwrap_or_default();
    if starts.len() != size + 1 || starts[0] != 0 || !follow || end > rows.len() || end > values.len() {
        let text = format!(
            "the starts of its {size} columns do not rise from 0 to the number of entries ({}); the file is damaged",
            rows.len().min(values.len())
        );
        return Err(Problem::new(text));
    }
    for column in 0..size {
        let wrong = rows[starts[column]..starts[column + 1]].iter().find(|&&row| row as usize >= size);
        if let Some(&row) = wrong {
            return Err(outside(row as usize, column, size));
        }
    }
    tidied(size, starts, rows, values).map(|(built, _)| built)
}

/// Sorts the rows of each column, adds what is given twice and leaves out zeros. Says which entry was the first to be given
/// twice.
fn tidied(
    size: usize,
    mut starts: Vec<usize>,
    mut rows: Vec<u32>,
    mut values: Vec<f64>,
) -> Result<(Built, Option<(usize, usize)>), Problem> {
    let mut sorted: Vec<(u32, f64)> = Vec::new();
    let (mut end, mut added, mut twice) = (0, 0, None);
    for column in 0..size {
        let (from, to) = (starts[column], starts[column + 1]);
        if !rows[from..to].is_sorted() {
            sorted.clear();
            sorted.extend(rows[from..to].iter().copied().zip(values[from..to].iter().copied()));
            // Stable: what is given twice is added in the order of the file.
            sorted.sort_by_key(|entry| entry.0);
            for (at, &(row, value)) in (from..to).zip(&sorted) {
                (rows[at], values[at]) = (row, value);
            }
        }
        starts[column] = end;
        let mut at = from;
        while at < to {
            let row = rows[at];
            let mut value = values[at];
            at += 1;
            while at < to && rows[at] == row {
                value += values[at];
                at += 1;
                added += 1;
                twice.get_or_insert((row as usize, column));
            }
            if !value.is_finite() {
                let text = format!(
                    "the entry of row {} and column {} is {value}, which is no finite number",
                    row + 1,
                    column + 1
                );
                return Err(Problem::new(text));
            }
            if value != 0.0 {
                (rows[end], values[end]) = (row, value);
                end += 1;
            }
        }
    }
    starts[size] = end;
    rows.truncate(end);
    values.truncate(end);
    let rows: Vec<usize> = rows.into_iter().map(|row| row as usize).collect();
    // It checks again what holds by now: a mistake here would be no wrong memory access.
    let places = SymbolicSparseColMat::new_checked(size, size, starts, None, rows);
    Ok((Built { matrix: SparseColMat::new(places, values), added }, twice))
}

/// Refuses a number of rows beyond the limit, and no rows at all.
///
/// # Errors
/// See there.
pub fn check_size(size: usize) -> Result<(), Problem> {
    match size {
        0 => Err(Problem::new("the matrix has no rows")),
        _ if size > MOST_ROWS => Err(Problem::new(format!("the matrix has {size} rows; the limit is {MOST_ROWS}"))),
        _ => Ok(()),
    }
}

/// The number of rows of a matrix that is said to have so many rows and columns.
///
/// # Errors
/// A matrix that is not square, or too large.
pub fn square(rows: u64, columns: u64) -> Result<usize, Problem> {
    if rows != columns {
        let text =
            format!("the matrix has {rows} rows and {columns} columns; one of mass, damping or stiffness is square");
        return Err(Problem::new(text));
    }
    let size = usize::try_from(rows).unwrap_or(usize::MAX);
    check_size(size).map(|()| size)
}

fn outside(row: usize, column: usize, size: usize) -> Problem {
    Problem::new(format!(
        "there is an entry in row {} and column {}, but the matrix has {size} rows and columns",
        row + 1,
        column + 1
    ))
}

/// How many entries are read of a compressed matrix with so many rows, in a file of so many bytes. What is given more
/// than once has room among the few.
pub fn most_entries(size: usize, length: u64) -> usize {
    let of_length = usize::try_from(length.saturating_mul(MOST_PER_BYTE)).unwrap_or(usize::MAX);
    size.saturating_mul(size).min(of_length).saturating_add(FEW).min(MOST_ENTRIES)
}

pub fn too_many_entries(most: usize) -> Problem {
    let of_file = if most < MOST_ENTRIES {
        " for its rows and the length of its compressed file; save it without compression if it is sound"
    } else {
        ""
    };
    Problem::new(format!("the matrix has more than {most} entries, the limit{of_file}"))
}
