//! The limits of a run, read back from its `limits.parquet`.

use std::path::Path;

use arrow::array::{AsArray as _, RecordBatchReader as _};
use arrow::datatypes::{DataType, Float64Type, Int64Type};
use parquet::arrow::arrow_reader::ParquetRecordBatchReader;

use crate::failure::Failure;
use crate::files::foreign::{self, text_of_key};
use crate::job::Job;
use crate::messages::{Code, Place};
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
    /// Whether the probability rises there; else it falls or does not pass the target.
    pub rises: bool,
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
            let (path, resume) = (run.join(LIMITS), format!("stickslip resume {}", quoted(run)));
            let text = format!("{} is damaged: {why}; remove it, or write it again with `{resume}`", path.display());
            Failure::InputOutput(text).coded(Code::Damaged).at(Place::file(&path)).remedied(resume)
        };
        match state_of(directory.root(), LIMITS, &[(JOB_HASH_KEY, job.hash())])? {
            FileState::Sound => {}
            FileState::Absent | FileState::OfAnotherJob | FileState::OfAnotherVersion => return Ok(None),
            FileState::Damaged(why) => return Err(damaged(why)),
        }
        let open = || directory.root().open_file(LIMITS).map_err(|error| damaged(error.to_string()));
        let of = text_of_key(&open()?, "stickslip:of").ok_or_else(|| damaged("it names no axis".to_owned()))?;
        let is_wanted = |name: &str| COLUMNS.contains(&name);
        let rows = foreign::read(open()?, None, is_wanted, rows_of).map_err(damaged)?;
        match rows.iter().find(|row| row.cell >= job.cells()) {
            None => Ok(Some(Self { of, rows })),
            Some(row) => Err(damaged(format!("it has a limit of cell {}, which the job does not have", row.cell))),
        }
    }
}

/// The columns that are read, in the order of the file.
const COLUMNS: [&str; 4] = ["cell", "target", "state", "limit"];

fn rows_of(table: ParquetRecordBatchReader) -> Result<Vec<FinishedLimit>, String> {
    let schema = table.schema();
    let columns = schema.fields().iter().map(|field| (field.name().as_str(), field.data_type()));
    let types = [DataType::Int64, DataType::Float64, DataType::Utf8, DataType::Float64];
    if !columns.eq(COLUMNS.into_iter().zip(&types)) {
        return Err("its columns are not those of limits".to_owned());
    }
    let mut rows = Vec::new();
    for batch in table {
        let batch = batch.map_err(|error| error.to_string())?;
        let [cells, targets, states, limits] = [0, 1, 2, 3].map(|place| batch.column(place));
        let (cells, targets) = (cells.as_primitive::<Int64Type>(), targets.as_primitive::<Float64Type>());
        for row in cells.iter().zip(targets).zip(states.as_string::<i32>()).zip(limits.as_primitive::<Float64Type>()) {
            let (((Some(cell), Some(target)), Some(state)), value) = row else {
                return Err("a limit has no cell, target or state".to_owned());
            };
            rows.push(FinishedLimit { cell: cell.cast_unsigned(), target, rises: state == "rises", value });
        }
    }
    Ok(rows)
}
