//! `submit`, `resume` and `merge`: from a job to its surface.

use std::path::Path;
use std::time::Instant;

use indicatif::HumanCount;

use crate::cli::{MergeArguments, ResumeArguments, SubmitArguments};
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::job::{Job, JobSource, Overrides};
use crate::output::{note, quoted, result};
use crate::picture::picture;
use crate::run::{Access, Engine, Outcome, Plan, Progress, RunDirectory, Session, Shard, Surface, Tally};

/// `stickslip submit`.
pub fn submit(arguments: &SubmitArguments, interrupt: &Interrupt) -> Result<(), Failure> {
    let overrides = Overrides { seed: arguments.seed, samples: arguments.samples };
    let source = JobSource::read(&arguments.job)?.with(overrides)?;
    let job = source.job()?;
    let out = arguments.out.clone().unwrap_or_else(|| Path::new("runs").join(&job.name));
    let access = if arguments.shard.is_some() { Access::Shared } else { Access::Alone };
    let directory = RunDirectory::create(&out, access)?;
    let threads = arguments.threads.count();
    match adopt(&directory, &source, &job)? {
        Standing::Finished(tally) if arguments.shard.is_none() => {
            note(format_args!("{} is finished already; nothing to do", out.display()));
            // A surface that was lost or damaged comes back from the pieces.
            if Surface::new(&job, &tally).publish(directory.path())? {
                note(format_args!("{} was missing or differed; it is written anew", directory.surface().display()));
            }
            report(&directory, &job, &tally)
        }
        Standing::Unfinished(tally) if arguments.shard.is_none() => Err(Failure::CannotCreate(format!(
            "{} holds an unfinished run of this job ({} of {} samples); continue it with `stickslip resume {}`",
            out.display(),
            HumanCount128(tally.counted()),
            HumanCount128(job.total_samples()),
            quoted(&out)
        ))),
        Standing::Finished(tally) | Standing::Unfinished(tally) | Standing::Fresh(tally) => {
            let run = compute(directory, job, tally, threads, arguments.shard, "submit", interrupt)?;
            match arguments.shard {
                None => report(&run.directory, &run.job, &run.tally),
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
    if tally.complete_cells(job.samples) == job.cells() {
        note(format_args!("{} has all its samples; nothing to compute", arguments.run.display()));
    }
    let run = compute(directory, job, tally, arguments.threads.count(), None, "resume", interrupt)?;
    report(&run.directory, &run.job, &run.tally)
}

/// `stickslip merge`.
pub fn merge(arguments: &MergeArguments) -> Result<(), Failure> {
    let directory = RunDirectory::open(&arguments.run, Access::Alone)?;
    let job = directory.job()?;
    let tally = directory.tally(&job)?;
    let complete = tally.complete_cells(job.samples);
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
    Surface::new(&job, &tally).publish(directory.path())?;
    session.record(directory.path(), "finished", 0)?;
    report(&directory, &job, &tally)
}

/// A run with all its samples counted and its surface written.
pub struct FinishedRun {
    /// Where it is.
    pub directory: RunDirectory,
    /// Its job.
    pub job: Job,
    /// Its verdicts.
    pub tally: Tally,
}

/// Brings a run of `source` to its end, whatever of it is there already.
pub fn complete_run(
    source: &JobSource,
    out: &Path,
    threads: usize,
    interrupt: &Interrupt,
) -> Result<FinishedRun, Failure> {
    let job = source.job()?;
    let directory = RunDirectory::create(out, Access::Alone)?;
    // A run that was extended answers as well, and better.
    if let Some(existing) = directory.job_source()?.map(|frozen| frozen.job()).transpose()?
        && existing.experiment_hash() == job.experiment_hash()
        && existing.samples > job.samples
    {
        let tally = directory.tally(&existing)?;
        return compute(directory, existing, tally, threads, None, "reproduce", interrupt);
    }
    let tally = adopt(&directory, source, &job)?.into_tally();
    compute(directory, job, tally, threads, None, "reproduce", interrupt)
}

/// What a directory holds of a job that is submitted to it.
enum Standing {
    /// Nothing, or a finished run with fewer samples in each cell.
    Fresh(Tally),
    /// Some of the samples.
    Unfinished(Tally),
    /// All samples.
    Finished(Tally),
}

impl Standing {
    fn into_tally(self) -> Tally {
        match self {
            Self::Fresh(tally) | Self::Unfinished(tally) | Self::Finished(tally) => tally,
        }
    }
}

/// Makes the directory one of this job, or refuses if it belongs to another.
fn adopt(directory: &RunDirectory, source: &JobSource, job: &Job) -> Result<Standing, Failure> {
    if directory.job_source()?.is_none() {
        // Pieces may be there without a job (a job.toml removed by hand): those of this job count, others are refused
        // before anything is written. Unless another shard has frozen the job in the meantime.
        let tally = directory.tally(job);
        if directory.job_source()?.is_none() {
            let tally = tally?;
            if directory.freeze_first(source)? {
                return Ok(Standing::Fresh(tally));
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
    if job.samples < existing.samples {
        return Err(Failure::Job(format!(
            "{path} holds a run of this job with {0} samples in each cell, more than the {1} asked for. Ask for them with --samples {0}, or choose another directory with --out",
            existing.samples, job.samples
        )));
    }
    let tally = directory.tally(&existing)?;
    let finished = tally.complete_cells(existing.samples) == existing.cells();
    if job.samples == existing.samples {
        return Ok(if finished { Standing::Finished(tally) } else { Standing::Unfinished(tally) });
    }
    if !finished {
        return Err(Failure::CannotCreate(format!(
            "{path} holds an unfinished run of this job with {} samples in each cell; finish it with `stickslip resume {path}`, then ask for {}",
            existing.samples, job.samples
        )));
    }
    note(format_args!("{path}: from {} to {} samples in each cell", existing.samples, job.samples));
    directory.freeze(source)?;
    Ok(Standing::Fresh(tally))
}

/// The first line in which two normalised jobs differ.
fn first_difference(existing: &str, new: &str) -> String {
    let ignored = |line: &&str| {
        !line.starts_with("name = ") && !line.starts_with("description = ") && !line.starts_with("samples = ")
    };
    let (mut a, mut b) = (existing.lines().filter(ignored), new.lines().filter(ignored));
    loop {
        match (a.next(), b.next()) {
            (Some(a), Some(b)) if a == b => {}
            (Some(a), Some(b)) => return format!("it has `{a}`, the job has `{b}`"),
            (None, None) => return "it was made by another version".to_owned(),
            (Some(a), None) => return format!("it has `{a}`, the job does not"),
            (None, Some(b)) => return format!("the job has `{b}`, the run does not"),
        }
    }
}

/// Computes what is missing; without a shard, writes the surface.
fn compute(
    directory: RunDirectory,
    job: Job,
    mut tally: Tally,
    threads: usize,
    shard: Option<Shard>,
    command: &str,
    interrupt: &Interrupt,
) -> Result<FinishedRun, Failure> {
    if shard.is_none() {
        directory.tidy()?;
    }
    let plan = Plan::new(&tally, job.samples, job.unit_samples(), shard);
    let session = Session::start(command, threads);
    let started = Instant::now();
    let before = tally.counted();
    let mut progress = Progress::new(plan.samples());
    let outcome = Engine::new(&job, threads)?.run(&plan, &mut tally, &directory, &mut progress, interrupt);
    progress.finish();
    let path = quoted(directory.path());
    let how = match shard {
        None => format!("stickslip resume {path}"),
        Some(shard) => format!("stickslip submit {path}/job.toml --out {path} --shard {shard}"),
    };
    let outcome = outcome
        .map_err(|failure| failure.with_remedy(&format!("what was written before is kept; continue with `{how}`")))?;
    let computed = u64::try_from(tally.counted() - before).unwrap_or(u64::MAX);
    let seconds = started.elapsed().as_secs_f64();
    if computed > 0 {
        note(format_args!(
            "{} samples in {seconds:.2} s on {threads} threads ({} samples/s)",
            HumanCount(computed),
            HumanCount((computed as f64 / seconds.max(1e-9)) as u64)
        ));
    }
    if let Outcome::Stopped(signal) = outcome {
        if shard.is_none() {
            session.record(directory.path(), &signal.to_string(), computed)?;
        }
        return Err(Failure::Stopped {
            signal,
            message: format!(
                "{} of {} samples are kept; continue with `{how}`",
                HumanCount128(tally.counted()),
                HumanCount128(job.total_samples())
            ),
        });
    }
    if shard.is_none() {
        Surface::new(&job, &tally).publish(directory.path())?;
        if computed > 0 {
            session.record(directory.path(), "finished", computed)?;
        }
    }
    Ok(FinishedRun { directory, job, tally })
}

/// Where the result is and what it looks like.
fn report(directory: &RunDirectory, job: &Job, tally: &Tally) -> Result<(), Failure> {
    let surface = Surface::new(job, tally);
    let line = closing_line(&directory.surface(), job);
    result(&format!("{}{line}{}", picture(&surface), without_verdict(&surface)))
}

/// A line on the samples without a verdict, if there are any: they are counted, and widen the interval.
fn without_verdict(surface: &Surface<'_>) -> String {
    let (mut undecided, mut failed) = (0, 0);
    for row in surface.rows() {
        undecided += row.counts.undecided;
        failed += row.counts.failed;
    }
    match (undecided, failed) {
        (0, 0) => String::new(),
        _ => format!(
            "{} samples undecided, {} failed; p_low and p_high count them for either side\n",
            HumanCount(undecided),
            HumanCount(failed)
        ),
    }
}

fn closing_line(surface: &Path, job: &Job) -> String {
    format!(
        "{}: {} cells, {} samples each, seed {}\n",
        surface.display(),
        HumanCount(job.cells()),
        HumanCount(job.samples),
        job.seed
    )
}

/// A count of any size with separators.
struct HumanCount128(u128);

impl std::fmt::Display for HumanCount128 {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match u64::try_from(self.0) {
            Ok(count) => HumanCount(count).fmt(f),
            Err(_) => self.0.fmt(f),
        }
    }
}
