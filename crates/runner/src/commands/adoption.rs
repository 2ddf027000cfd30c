//! Whether a run directory is one of a job that is submitted to it.

use crate::evaluate::parts::Parts;
use crate::failure::Failure;
use crate::job::{Job, JobSource};
use crate::output::{note, quoted};
use crate::store::directory::RunDirectory;
use crate::store::tally::Tally;

/// What a directory holds of a job that is submitted to it.
pub enum Standing {
    /// Nothing, or a finished run with fewer samples in each cell.
    Fresh(Tally),
    /// Some of the samples.
    Unfinished(Tally),
    /// All samples.
    Finished(Tally),
}

impl Standing {
    /// The samples that are there.
    pub fn into_tally(self) -> Tally {
        match self {
            Self::Fresh(tally) | Self::Unfinished(tally) | Self::Finished(tally) => tally,
        }
    }
}

/// Makes the directory one of this job, or refuses if it belongs to another. Gives the job as the run has it: it keeps the
/// name and the description under which it began.
pub fn adopt(directory: &RunDirectory, source: &JobSource, job: Job) -> Result<(Job, Standing), Failure> {
    if directory.job_source()?.is_none() {
        // Pieces may be there without a job (a job.toml removed by hand): those of this job count, others are refused
        // before anything is written. Unless another shard has frozen the job in the meantime.
        let tally = directory.tally(&job);
        if directory.job_source()?.is_none() {
            let tally = tally?;
            if directory.freeze_first(source, &job)? {
                return Ok((job, Standing::Fresh(tally)));
            }
        }
    }
    let existing = directory.job()?;
    let path = quoted(directory.path());
    if existing.experiment_hash() != job.experiment_hash() {
        return Err(Failure::Job(format!(
            "{path} holds a run of another job: {}. Choose another directory with --out",
            first_difference(&existing.normalised(), &job.normalised())
        )));
    }
    let (wanted, there) = (job.sampling.samples, existing.sampling.samples);
    let at_most = if job.stops_by_precision() { "at most " } else { "" };
    if wanted < there {
        return Err(Failure::Job(format!(
            "{path} holds a run of this job with {at_most}{there} samples in each cell, more than the {wanted} asked for. Ask for them with --samples {there}, or choose another directory with --out"
        )));
    }
    let tally = directory.tally(&existing)?;
    let finished = Parts::new(&existing).complete_cells(&tally) == existing.cells();
    if wanted == there {
        return Ok((existing, if finished { Standing::Finished(tally) } else { Standing::Unfinished(tally) }));
    }
    if !finished {
        return Err(Failure::CannotCreate(format!(
            "{path} holds an unfinished run of this job with {at_most}{there} samples in each cell; finish it with `stickslip resume {path}`, then ask for {wanted}"
        )));
    }
    note(format_args!("{path}: from {at_most}{there} to {at_most}{wanted} samples in each cell"));
    directory.freeze(source, &job)?;
    // With more samples a cell may have more parts.
    let tally = directory.tally(&job)?;
    Ok((job, Standing::Fresh(tally)))
}

/// The first line in which two normalised jobs differ.
fn first_difference(existing: &str, new: &str) -> String {
    let ignored = |line: &&str| {
        !["name = ", "description = ", "samples = ", "at_most = "].iter().any(|key| line.starts_with(key))
    };
    let (mut a, mut b) = (existing.lines().filter(ignored), new.lines().filter(ignored));
    loop {
        match (a.next(), b.next()) {
            (Some(a), Some(b)) if a == b => {}
            (Some(a), Some(b)) => return format!("it has `{}`, the job has `{}`", excerpt(a, b), excerpt(b, a)),
            (None, None) => return "it was made by another version".to_owned(),
            (Some(a), None) => return format!("it has `{}`, the job does not", excerpt(a, "")),
            (None, Some(b)) => return format!("the job has `{}`, the run does not", excerpt(b, "")),
        }
    }
}

/// A line that is not too long for a message, or the part of it where it begins to differ from another one.
fn excerpt(line: &str, other: &str) -> String {
    const LONGEST: usize = 120;
    if line.chars().count() <= LONGEST {
        return line.to_owned();
    }
    let common = line.chars().zip(other.chars()).take_while(|(a, b)| a == b).count();
    let first = common.saturating_sub(LONGEST / 2);
    let part: String = line.chars().skip(first).take(LONGEST).collect();
    format!("{}{part}...", if first > 0 { "..." } else { "" })
}
