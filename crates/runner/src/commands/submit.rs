//! `submit`, `resume` and `merge`: computing the surface of a job.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::adoption::{RunState, adopt, adopt_as_shard, apart};
use super::closing::{report, report_as_json};
use super::completion::{Work, announce_finished, complete_audits, compute, kept_and_continued, lost_tiles, map_only};
use super::limit::{publish_limits, with_limits_of};
use super::named_job::read_job;
use crate::cli::{MergeArguments, ResumeArguments, SubmitArguments};
use crate::evaluate::parts::Parts;
use crate::failure::{Advice, Failure};
use crate::files::folder::Folder;
use crate::interrupt::Interrupt;
use crate::job::{Job, Overrides};
use crate::messages::Code;
use crate::output::{FREE_SPACE, HumanCount128, note, quoted, warn};
use crate::schedule::engine::Engine;
use crate::store::directory::RunDirectory;
use crate::store::layout::{JOB, MAPS};
use crate::store::lock::{AN_INSTANT, Access};
use crate::store::provenance::Session;
use crate::tables::surface::Surface;

/// `stickslip submit`.
pub fn submit(arguments: &SubmitArguments, interrupt: &Interrupt) -> Result<(), Failure> {
    let shard = arguments.shard;
    let overrides = Overrides { seed: arguments.seed, samples: arguments.samples };
    let source = read_job(&arguments.job)?.with(overrides)?;
    let job = source.job()?.asked(arguments.asked.target, &arguments.asked.at)?;
    refuse_to_ask_a_part(arguments)?;
    let (target, operating_point) = (job.target, job.operating_point);
    warn(job.warnings());
    if arguments.map_only && !job.uses_maps() {
        return Err(Failure::Usage(format!("--map-only: {WITHOUT_MAP}")));
    }
    if let Some(shard) = shard.filter(|_| !arguments.map_only) {
        require_samples_to_share(&job, &format!("--shard {shard}"))?;
    }
    let maps = map_directories(&arguments.maps.maps, &job)?;
    let out = arguments.out.clone().unwrap_or_else(|| Path::new("runs").join(&job.name));
    let threads = arguments.threads.count();
    // From the moment that there is a run.
    let asked = &arguments.asked;
    interrupt.remark_once_there(out.join(JOB), kept_and_continued(&out, shard, asked));
    let (directory, job, state) = match shard {
        Some(_) => adopt_as_shard(&out, &source, &job)?,
        None => {
            let directory = match arguments.apart {
                true => apart(&out, &job)?,
                false => RunDirectory::create(&out, Access::Alone, AN_INSTANT)?,
            };
            if arguments.overwrite {
                directory.clear()?;
            }
            let (job, state) = adopt(&directory, &source, job)?;
            let job = with_limits_of(&directory, job, &source)?;
            let job = Job { target, operating_point, ..job };
            (directory, job, state)
        }
    };
    let out = directory.path().to_owned();
    let is_map_only = arguments.map_only;
    let work = Work { threads, shard, maps, is_map_only, command: "submit", asked };
    let resume = asked.resume(&out);
    let report = if arguments.json { report_as_json } else { report };
    if is_map_only {
        return map_only(&directory, &job, &work, interrupt);
    }
    match state {
        RunState::Finished(tally) if shard.is_none() => {
            announce_finished(&directory, &job, "is finished already; nothing to do")?;
            // A lost or damaged surface is written again from the pieces.
            let resumed = Advice::command(&format!("all samples are kept; {FREE_SPACE}"), &resume);
            let kept = |failure: Failure| failure.with_advice(&resumed);
            let engine = Engine::new(threads)?;
            let audits = complete_audits(&directory, &job, &engine, interrupt, asked)?;
            let surface = Surface::new(&job, &tally).audited(audits.as_ref());
            if surface.publish(&directory).map_err(kept)? {
                note(format_args!("{} was missing or differed; it is written again", directory.surface().display()));
            }
            let limits = publish_limits(&directory, &job, &engine, interrupt, asked).map_err(kept)?;
            report(&directory, &job, &surface, limits.as_ref())
        }
        RunState::Unfinished(tally) if shard.is_none() => Err(Failure::CannotCreate(format!(
            "{} holds an unfinished run of this job ({} of {} samples); continue it with `{resume}`",
            out.display(),
            HumanCount128(tally.counted()),
            HumanCount128(job.total_samples()),
        ))
        .coded(Code::RunUnfinished)
        .remedied(resume)),
        RunState::Finished(tally) | RunState::Unfinished(tally) | RunState::New(tally) => {
            let run = compute(directory, job, tally, &work, interrupt)?;
            match shard {
                None => report(&run.directory, &run.job, &run.surface(), run.limits.as_ref()),
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
    let directory = RunDirectory::open(&arguments.run, Access::Alone, AN_INSTANT)?;
    let job = directory.job()?.asked(arguments.asked.target, &arguments.asked.at)?;
    let tally = directory.tally(&job)?;
    if Parts::new(&job).are_complete(&tally) && lost_tiles(&directory, &job, &tally)?.0 == 0 {
        announce_finished(&directory, &job, "has all its samples; nothing to compute")?;
    }
    let maps = map_directories(&arguments.maps.maps, &job)?;
    let threads = arguments.threads.count();
    let asked = &arguments.asked;
    let work = Work { threads, shard: None, maps, is_map_only: false, command: "resume", asked };
    let run = compute(directory, job, tally, &work, interrupt)?;
    report(&run.directory, &run.job, &run.surface(), run.limits.as_ref())
}

/// Refuses a question to what computes a part of a run and prints no result.
fn refuse_to_ask_a_part(arguments: &SubmitArguments) -> Result<(), Failure> {
    // As it is typed, with a space between option and value.
    let Some(option) = arguments.asked.options().next().map(|option| option.replacen('=', " ", 1)) else {
        return Ok(());
    };
    let (part, remedy) = match arguments.shard {
        _ if arguments.map_only => ("--map-only", "give it to the command that computes the samples"),
        Some(_) => ("--shard", "give it to `stickslip merge`, which prints that of all shards"),
        None => return Ok(()),
    };
    Err(Failure::Usage(format!("{option}: with {part} there is no result yet that could answer it; {remedy}")))
}

/// Refuses to share a job that draws no samples.
pub fn require_samples_to_share(job: &Job, option: &str) -> Result<(), Failure> {
    if job.draws_samples() {
        return Ok(());
    }
    let asked = job.sampling.method.asked();
    Err(Failure::Usage(format!(
        "{option}: {asked} draws no samples to share; one process computes it, without this option"
    )))
}

/// Why an option for verdict maps is refused.
const WITHOUT_MAP: &str = "this job uses no verdict map. Maps are used with sampling.evaluate = \"boundary\" or method = \"exact\" and a criterion other than \"eigenvalue\"";

/// The directories of the maps of the runs given with `--map`.
pub fn map_directories(runs: &[PathBuf], job: &Job) -> Result<Vec<Folder>, Failure> {
    if let (Some(run), false) = (runs.first(), job.uses_maps()) {
        return Err(Failure::Usage(format!("--map {}: {WITHOUT_MAP}", run.display())));
    }
    let map = |run: &PathBuf| {
        Folder::open(run).and_then(|run| run.within(MAPS)).map_err(|error| match error.kind() {
            ErrorKind::NotFound => {
                Failure::InputOutput(format!("--map {}: this run has no verdict map", run.display()))
            }
            _ => Failure::reading(&run.join(MAPS), error),
        })
    };
    runs.iter().map(map).collect()
}

/// `stickslip merge`.
pub fn merge(arguments: &MergeArguments, interrupt: &Interrupt) -> Result<(), Failure> {
    // Shards may still be at work: some that finish, or one of which a batch system started a second copy.
    let patience = Duration::from_secs(arguments.wait);
    let directory = RunDirectory::open(&arguments.run, Access::Alone, patience.max(AN_INSTANT))?;
    let job = directory.job()?.asked(arguments.asked.target, &arguments.asked.at)?;
    let tally = directory.tally(&job)?;
    let asked = &arguments.asked;
    let resume = asked.resume(&arguments.run);
    if !job.draws_samples() {
        let message = format!("{} has no shards; write the surface with `{resume}`", job.sampling.method.asked());
        return Err(Failure::Job(message).remedied(resume));
    }
    let complete = Parts::new(&job).complete_cells(&tally);
    if complete < job.cells() {
        return Err(Failure::Job(format!(
            "{} is not complete: {} of {} cells, {} of {} samples. Submit every shard again (those that are finished end at once), or compute what is missing here with `{resume}`",
            arguments.run.display(),
            complete,
            job.cells(),
            HumanCount128(tally.counted()),
            HumanCount128(job.total_samples()),
        ))
        .coded(Code::Incomplete)
        .remedied(resume));
    }
    directory.tidy()?;
    let session = Session::start("merge", 1);
    let engine = Engine::new(1)?;
    let audits = complete_audits(&directory, &job, &engine, interrupt, asked)?;
    let surface = Surface::new(&job, &tally).audited(audits.as_ref());
    let kept = |failure: Failure| {
        let merge = format!("stickslip merge {}{}", quoted(&arguments.run), asked.words());
        failure.with_advice(&Advice::command(&format!("all samples are kept; {FREE_SPACE}"), &merge))
    };
    surface.publish(&directory).map_err(kept)?;
    session.record(&directory, "finished", 0).map_err(kept)?;
    let limits = publish_limits(&directory, &job, &engine, interrupt, asked).map_err(kept)?;
    report(&directory, &job, &surface, limits.as_ref())
}
