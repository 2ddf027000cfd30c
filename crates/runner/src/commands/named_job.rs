//! The job that a command line names, and what may have been meant where it names none.

use std::path::Path;

use super::shipped_jobs::ShippedJob;
use crate::failure::{Advice, Failure};
use crate::job::JobSource;
use crate::output::quoted;
use crate::store::layout::{JOB, SHARDS};

/// Reads a job spec from a file, or from standard input where the path is `-`.
///
/// # Errors
/// A file that cannot be read. Of the directory of a run, and of a job that comes with the program and is not there, the
/// message says how to go on.
pub fn read_job(path: &Path) -> Result<JobSource, Failure> {
    JobSource::read(path).map_err(|failure| match meant(path) {
        Some(advice) => failure.with_advice(&advice),
        None => failure,
    })
}

/// What may have been meant by a path that is no job.
fn meant(path: &Path) -> Option<Advice> {
    if path.join(JOB).is_file() && path.join(SHARDS).is_dir() {
        let words = format!("this is a run, of which {} is the job; continue it with", quoted(&path.join(JOB)));
        return Some(Advice::command(&words, &format!("stickslip resume {}", quoted(path))));
    }
    let is_there = path.symlink_metadata().is_ok();
    let job = ShippedJob::named(path.file_name()?.to_str()?).ok().filter(|_| !is_there)?;
    let words = format!("{} comes with the program; write it with", job.name);
    Some(Advice::command(&words, &format!("stickslip init --from {}", job.name)))
}
