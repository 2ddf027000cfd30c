//! The job that a command line names, and what may have been meant where it names none.

use std::path::Path;

use toml_edit::DocumentMut;

use super::shipped_jobs::ShippedJob;
use crate::failure::{Advice, Failure};
use crate::job::JobSource;
use crate::messages::Code;
use crate::output::quoted;
use crate::store::layout::{JOB, SHARDS};

/// Reads a job spec from a file, or from standard input where the path is `-`.
///
/// # Errors
/// A file that cannot be read. Of the directory of a run, and of a job that comes with the program and is not there, the
/// message says how to go on.
pub fn read_job(path: &Path) -> Result<JobSource, Failure> {
    let source = JobSource::read(path).map_err(|failure| match meant(path) {
        Some(advice) => failure.with_advice(&advice),
        None => failure,
    })?;
    match no_toml(&source.text) {
        Some((line, beginning)) => Err(Failure::Job(format!(
            "{}:{line}: this is no job: a job is TOML, with tables such as [axes] and [criterion], and this file begins with {beginning:?}; if it holds data of a job, name it there (`stickslip init --from own-brake` writes a job that names files)",
            path.display()
        ))
        .coded(Code::JobSpec)),
        None => Ok(source),
    }
}

/// Where a text begins that is something else than TOML, a table of data or matrices, and how. A job with mistakes has tables
/// or a key.
fn no_toml(text: &str) -> Option<(usize, String)> {
    let has_tables = text.lines().any(|line| line.trim_start().starts_with('['));
    let mut lines = (1..).zip(text.lines().map(str::trim));
    let (line, first) = lines.find(|(_, line)| !line.is_empty() && !line.starts_with('#'))?;
    let is_key = |key: &str| key.chars().all(|c| c.is_alphanumeric() || " _-.\"'".contains(c));
    let has_key = first.split_once('=').is_some_and(|(key, _)| is_key(key));
    let is_none =
        !has_tables && !has_key && first.parse::<DocumentMut>().is_err() && text.parse::<DocumentMut>().is_err();
    is_none.then(|| (line, first.chars().take(40).collect()))
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
