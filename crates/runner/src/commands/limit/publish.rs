//! `limits.parquet`, the limits of a run that its job asks for.

use super::search::{Tiles, Wanted};
use crate::cli::AskedArguments;
use crate::failure::{Advice, Failure};
use crate::files::table::encoded_table;
use crate::interrupt::Interrupt;
use crate::job::{Job, JobSource, LimitAxis, LimitMethod, LimitRequest};
use crate::output::shown;
use crate::picture::view::rounded;
use crate::schedule::engine::Engine;
use crate::store::directory::RunDirectory;
use crate::store::file_state::{FileState, state_of};
use crate::store::layout::{LIMIT_SEARCHES, LIMITS, MAPS};
use crate::tables::limits::{FinishedLimits, RunLimits};

/// Writes the limits that the job of a finished run asks for, unless they are there.
pub fn publish_limits(
    directory: &RunDirectory,
    job: &Job,
    engine: &Engine,
    interrupt: &Interrupt,
    asked: &AskedArguments,
) -> Result<Option<RunLimits>, Failure> {
    let Some(request) = &job.limit else { return Ok(None) };
    let path = directory.path().join(LIMITS);
    let contradiction = match sound_limits(directory, job, request)? {
        Ok(known) => known.contradiction(job),
        Err(_) => {
            let (axis, method) = checked(job, &request.of)?;
            let wanted = Wanted { job, axis: &axis, method, targets: &request.targets };
            let maps = match method {
                LimitMethod::MapIntegral => Some(directory.create_folder(MAPS)?),
                _ => None,
            };
            let tiles = Tiles { known: maps.as_ref(), keep: maps.as_ref() };
            let resume = asked.resume(directory.path());
            let what_is_kept = "the surface is written, and what was found of the limits is kept; continue with";
            let stopped = Advice::command(what_is_kept, &resume);
            let searches = directory.searches_of(LIMIT_SEARCHES, wanted.searches_of())?;
            let found = wanted.find(engine, tiles, interrupt, &stopped, Some(&searches))?;
            let bytes = encoded_table(&found.table(), &found.footer());
            directory.publish(LIMITS, &bytes.map_err(|error| Failure::writing(&path, error))?)?;
            found.contradiction()
        }
    };
    directory.forget_searches(LIMIT_SEARCHES);
    let targets: Vec<String> = request.targets.iter().map(|&target| rounded(target)).collect();
    let line = format!("{}: limits of {} at P = {}\n", shown(&path), request.of, targets.join(", "));
    Ok(Some(RunLimits { line, contradiction }))
}

/// The state of the limits that a job asks for, if it does.
pub fn check_limits(directory: &RunDirectory, job: &Job) -> Result<Option<FileState>, Failure> {
    let Some(request) = &job.limit else { return Ok(None) };
    Ok(Some(sound_limits(directory, job, request)?.map_or_else(|state| state, |_| FileState::Sound)))
}

/// The limits that a job asks for, as they were written; what there is of them where they are not.
fn sound_limits(
    directory: &RunDirectory,
    job: &Job,
    request: &LimitRequest,
) -> Result<Result<FinishedLimits, FileState>, Failure> {
    let (axis, method) = checked(job, &request.of)?;
    let wanted = Wanted { job, axis: &axis, method, targets: &request.targets };
    let state = state_of(directory.root(), LIMITS, &wanted.nothing_found().footer())?;
    if state != FileState::Sound {
        return Ok(Err(state));
    }
    // Without its digest, damage shows where it is read.
    let read = FinishedLimits::read(directory.path(), job).ok().flatten();
    Ok(read.ok_or_else(|| FileState::Damaged("it cannot be read".to_owned())))
}

/// The axis of a request and how its limits are found. Both were checked with the job.
fn checked(job: &Job, of: &str) -> Result<(LimitAxis, LimitMethod), Failure> {
    let axis = LimitAxis::named(job, of).map_err(Failure::Job)?;
    let method = LimitMethod::for_axis(job, &axis).map_err(Failure::Job)?;
    Ok((axis, method))
}

/// The job of a run with the limits that a submitted job asks for, if these are others; the run keeps them.
pub fn with_limits_of(directory: &RunDirectory, job: Job, submitted: &JobSource) -> Result<Job, Failure> {
    let wanted = submitted.job()?.limit;
    if wanted.is_none() || wanted == job.limit {
        return Ok(job);
    }
    let Some(frozen) = directory.job_source()? else { return Ok(job) };
    let frozen = frozen.with_limits_of(submitted);
    let job = frozen.job()?;
    directory.freeze(&frozen, &job)?;
    Ok(job)
}
