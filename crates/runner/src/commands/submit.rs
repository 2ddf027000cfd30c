//! `submit`, `resume` and `merge`: computing the surface of a job.

use std::path::{Path, PathBuf};

use super::adoption::{RunState, adopt};
use super::closing::report;
use super::completion::{Work, compute};
use crate::cli::{MergeArguments, ResumeArguments, SubmitArguments};
use crate::evaluate::parts::Parts;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::job::{Job, JobSource, Overrides};
use crate::output::{FREE_SPACE, HumanCount128, counted, note, quoted, warn};
use crate::schedule::plan::{Plan, Shard};
use crate::store::directory::{Access, RunDirectory};
use crate::store::provenance::Session;
use crate::store::tally::Tally;
use crate::tables::surface::Surface;

/// `stickslip submit`.
pub fn submit(arguments: &SubmitArguments, interrupt: &Interrupt) -> Result<(), Failure> {
    let overrides = Overrides { seed: arguments.seed, samples: arguments.samples };
    let source = JobSource::read(&arguments.job)?.with(overrides)?;
    let job = source.job()?;
    warn(job.warnings());
    if let (Some(shard), true) = (arguments.shard, job.is_integrated()) {
        let message =
            format!("--shard {shard}: method = \"exact\" draws no samples to share; submit the job without --shard");
        return Err(Failure::Usage(message));
    }
    warn(arguments.shard.and_then(|shard| shards_beyond_work(shard, &job)));
    let maps = map_directories(&arguments.maps.maps, &job)?;
    let out = arguments.out.clone().unwrap_or_else(|| Path::new("runs").join(&job.name));
    let access = if arguments.shard.is_some() { Access::Shared } else { Access::Alone };
    let directory = RunDirectory::create(&out, access)?;
    let threads = arguments.threads.count();
    let (job, state) = adopt(&directory, &source, job)?;
    match state {
        RunState::Finished(tally) if arguments.shard.is_none() && !job.is_integrated() => {
            note(format_args!("{} is finished already; nothing to do", out.display()));
            // A lost or damaged surface is written again from the pieces.
            let resumed = format!("all samples are kept; {FREE_SPACE} `stickslip resume {}`", quoted(&out));
            let kept = |failure: Failure| failure.with_remedy(&resumed);
            if Surface::new(&job, &tally).publish(directory.path()).map_err(kept)? {
                note(format_args!("{} was missing or differed; it is written again", directory.surface().display()));
            }
            report(&directory, &job, &Surface::new(&job, &tally))
        }
        RunState::Unfinished(tally) if arguments.shard.is_none() => Err(Failure::CannotCreate(format!(
            "{} holds an unfinished run of this job ({} of {} samples); continue it with `stickslip resume {}`",
            out.display(),
            HumanCount128(tally.counted()),
            HumanCount128(job.total_samples()),
            quoted(&out)
        ))),
        RunState::Finished(tally) | RunState::Unfinished(tally) | RunState::New(tally) => {
            let work = Work { threads, shard: arguments.shard, maps, command: "submit" };
            let run = compute(directory, job, tally, &work, interrupt)?;
            match arguments.shard {
                None => report(&run.directory, &run.job, &run.surface()),
                Some(shard) => {
                    note(format_args!(
                        "shard {shard} is done; when all are, `stickslip merge {}` writes the surface",
                        quoted(&out)
                    ));
                    Ok(())
                }
            }
        }
    }
}

/// `stickslip resume`.
pub fn resume(arguments: &ResumeArguments, interrupt: &Interrupt) -> Result<(), Failure> {
    let directory = RunDirectory::open(&arguments.run, Access::Alone)?;
    let job = directory.job()?;
    let tally = directory.tally(&job)?;
    if !job.is_integrated() && Parts::new(&job).complete_cells(&tally) == job.cells() {
        note(format_args!("{} has all its samples; nothing to compute", arguments.run.display()));
    }
    let maps = map_directories(&arguments.maps.maps, &job)?;
    let work = Work { threads: arguments.threads.count(), shard: None, maps, command: "resume" };
    let run = compute(directory, job, tally, &work, interrupt)?;
    report(&run.directory, &run.job, &run.surface())
}

/// A warning if a job has less work than shards.
fn shards_beyond_work(shard: Shard, job: &Job) -> Option<String> {
    let parts = Parts::new(job);
    let (work, what) = if parts.are_sequential() {
        (job.cells(), counted(job.cells().into(), "cell", "cells"))
    } else {
        let units = Plan::new(&Tally::new(parts.count()), &parts, job.unit_samples(), None).units();
        (units, counted(units.into(), "unit of work", "units of work"))
    };
    (shard.count() > work).then(|| {
        format!(
            "--shard {shard}: the job has only {what} to share, so that {} have nothing to compute",
            counted((shard.count() - work).into(), "shard", "shards")
        )
    })
}

/// The directories of the maps of the runs given with `--map`.
fn map_directories(runs: &[PathBuf], job: &Job) -> Result<Vec<PathBuf>, Failure> {
    if let (Some(run), false) = (runs.first(), job.uses_maps()) {
        let message = format!(
            "--map {}: this job uses no verdict map. Maps are used with sampling.evaluate = \"boundary\" or method = \"exact\" and a criterion other than \"eigenvalue\"",
            run.display()
        );
        return Err(Failure::Usage(message));
    }
    let map = |run: &PathBuf| {
        let directory = run.join("map");
        if directory.is_dir() {
            Ok(directory)
        } else {
            Err(Failure::InputOutput(format!("--map {}: this run has no verdict map", run.display())))
        }
    };
    runs.iter().map(map).collect()
}

/// `stickslip merge`.
pub fn merge(arguments: &MergeArguments) -> Result<(), Failure> {
    let directory = RunDirectory::open(&arguments.run, Access::Alone)?;
    let job = directory.job()?;
    let tally = directory.tally(&job)?;
    if job.is_integrated() {
        let message = format!(
            "method = \"exact\" has no shards; write the surface with `stickslip resume {}`",
            quoted(&arguments.run)
        );
        return Err(Failure::Job(message));
    }
    let complete = Parts::new(&job).complete_cells(&tally);
    if complete < job.cells() {
        return Err(Failure::Job(format!(
            "{} is not complete: {} of {} cells, {} of {} samples. Submit the missing shards, or compute what is missing here with `stickslip resume {}`",
            arguments.run.display(),
            complete,
            job.cells(),
            HumanCount128(tally.counted()),
            HumanCount128(job.total_samples()),
            quoted(&arguments.run)
        )));
    }
    directory.tidy()?;
    let session = Session::start("merge", 1);
    let surface = Surface::new(&job, &tally);
    let kept = |failure: Failure| {
        failure.with_remedy(&format!("all samples are kept; {FREE_SPACE} `stickslip merge {}`", quoted(&arguments.run)))
    };
    surface.publish(directory.path()).map_err(kept)?;
    session.record(directory.path(), "finished", 0).map_err(kept)?;
    report(&directory, &job, &surface)
}
