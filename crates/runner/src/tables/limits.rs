//! The limits of a run, read back from its `limits.parquet`.

use std::path::Path;

use arrow::array::{Array as _, AsArray as _};
use arrow::datatypes::{DataType, Float64Type, Int64Type, Schema};

use crate::failure::Failure;
use crate::files::foreign::{self, Parts, text_of_key};
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
    /// Whether plain samples contradict the probability there or at an end of the axis.
    pub is_contradicted: bool,
}

impl FinishedLimits {
    /// How many of them plain samples contradict.
    pub fn contradicted(&self) -> usize {
        self.rows.iter().filter(|row| row.is_contradicted).count()
    }

    /// What is said where plain samples contradict limits; nothing where they do not.
    pub fn contradiction(&self, job: &Job) -> Option<String> {
        let contradicted = self.contradicted();
        (contradicted > 0).then(|| contradiction(job, &self.of, [contradicted, self.rows.len()]))
    }

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

/// What is said of the limits of a run.
pub struct RunLimits {
    /// A line on them.
    pub line: String,
    /// What is said where plain samples contradict some.
    pub contradiction: Option<String>,
}

/// What is said where plain samples contradict so many of so many limits of an axis.
pub fn contradiction(job: &Job, of: &str, [contradicted, all]: [usize; 2]) -> String {
    format!(
        "plain samples contradict the probability at {contradicted} of {all} limits of {of} or at the ends of the axis, so {} missed a region there; take method = \"monte-carlo\" for this job",
        job.sampling.method.asked(),
    )
}

/// The columns that are read, in the order of the file. The last is there where plain samples are.
const COLUMNS: [&str; 5] = ["cell", "target", "state", "limit", "distrust"];

fn rows_of(schema: &Schema, parts: Parts<'_>) -> Result<Vec<FinishedLimit>, String> {
    let columns = schema.fields().iter().map(|field| (field.name().as_str(), field.data_type()));
    let types = [DataType::Int64, DataType::Float64, DataType::Utf8, DataType::Float64, DataType::Int64];
    let count = schema.fields().len();
    if count + 1 < COLUMNS.len() || !columns.eq(COLUMNS.into_iter().zip(&types).take(count)) {
        return Err("its columns are not those of limits".to_owned());
    }
    let mut rows = Vec::new();
    for part in parts {
        let part = part?;
        let [cells, targets, states, limits] = [0, 1, 2, 3].map(|place| part.column(place));
        let (cells, targets) = (cells.as_primitive::<Int64Type>(), targets.as_primitive::<Float64Type>());
        let distrust = |row: usize| match part.columns().get(4) {
            Some(reasons) => !reasons.is_null(row) && reasons.as_primitive::<Int64Type>().value(row) != 0,
            None => false,
        };
        for (place, row) in cells
            .iter()
            .zip(targets)
            .zip(states.as_string::<i32>())
            .zip(limits.as_primitive::<Float64Type>())
            .enumerate()
        {
            let (((Some(cell), Some(target)), Some(state)), value) = row else {
                return Err("a limit has no cell, target or state".to_owned());
            };
            let (cell, is_contradicted) = (cell.cast_unsigned(), distrust(place));
            rows.push(FinishedLimit { cell, target, rises: state == "rises", value, is_contradicted });
        }
    }
    Ok(rows)
}
