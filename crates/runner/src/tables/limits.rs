//! The limits of a run, read back from its `limits.parquet`.

use std::path::Path;

use crate::failure::Failure;
use crate::files::decode::{ReadTable, ReadValues};
use crate::files::foreign::{self, Known, text_of_key};
use crate::job::Job;
use crate::output::quoted;
use crate::store::directory::{JOB_HASH_KEY, RunDirectory};
use crate::store::file_state::{FileState, state_of};
use crate::store::layout::LIMITS;

/// The limits of a run.
pub struct FinishedLimits {
    /// The axis along which they lie, as a job names it.
    pub of: String,
    /// In the order of the cells and targets, and in rising order.
    pub rows: Vec<FinishedLimit>,
}

/// A limit of one combination of the other axes.
pub struct FinishedLimit {
    /// The cell of the combination with the first value of the axis.
    pub cell: u64,
    /// The probability that is passed.
    pub target: f64,
    /// What the probability does there: it rises, falls, or does not pass the target.
    pub state: String,
    /// The value of the axis, if the target is passed.
    pub value: Option<f64>,
}

impl FinishedLimits {
    /// Reads the limits of a run; `None` if there are none of its job.
    ///
    /// # Errors
    /// A file that is not as it was written.
    pub fn read(run: &Path, job: &Job) -> Result<Option<Self>, Failure> {
        let directory = RunDirectory::view(run)?;
        let damaged = |why: String| {
            Failure::InputOutput(format!(
                "{} is damaged: {why}; remove it, or write it again with `stickslip resume {}`",
                run.join(LIMITS).display(),
                quoted(run)
            ))
        };
        match state_of(directory.root(), LIMITS, &[(JOB_HASH_KEY, job.hash())])? {
            FileState::Sound => {}
            FileState::Absent | FileState::OfAnotherJob | FileState::OfAnotherVersion => return Ok(None),
            FileState::Damaged(why) => return Err(damaged(why)),
        }
        let open = || directory.root().open_file(LIMITS).map_err(|error| damaged(error.to_string()));
        let of = text_of_key(&open()?, "stickslip:of").ok_or_else(|| damaged("it names no axis".to_owned()))?;
        let is_wanted = |name: &str| COLUMNS.contains(&name);
        let rows =
            foreign::read(open()?, Known::Table(None), is_wanted).and_then(|table| rows_of(&table)).map_err(damaged)?;
        match rows.iter().find(|row| row.cell >= job.cells()) {
            None => Ok(Some(Self { of, rows })),
            Some(row) => Err(damaged(format!("it has a limit of cell {}, which the job does not have", row.cell))),
        }
    }
}

/// The columns that are read, in the order of the file.
const COLUMNS: [&str; 4] = ["cell", "target", "state", "limit"];

fn rows_of(table: &ReadTable) -> Result<Vec<FinishedLimit>, String> {
    let (cells, targets) = (table.integers("cell")?, table.reals("target")?);
    let (Some(ReadValues::Text(states)), Some(ReadValues::Real(limits))) =
        (table.column("state"), table.column("limit"))
    else {
        return Err("its columns are not those of limits".to_owned());
    };
    let rows = cells.into_iter().zip(targets).zip(states.iter().zip(limits));
    rows.map(|((cell, target), (state, value))| {
        let state = state.clone().ok_or("a limit has no state")?;
        Ok(FinishedLimit { cell: cell.cast_unsigned(), target, state, value: *value })
    })
    .collect()
}
