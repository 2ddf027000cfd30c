//! `submit`, `resume` and `merge`: from a job to its surface.

use std::path::{Path, PathBuf};
use std::time::Instant;

use indicatif::HumanCount;

use crate::cli::{MergeArguments, ResumeArguments, SubmitArguments};
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::job::{Job, JobSource, Overrides};
use crate::output::{note, quoted, result};
use crate::picture::picture;
use crate::run::{
    Access, Engine, IntegratedCell, Lookups, Outcome, Plan, Progress, RunDirectory, Session, Shard, Slots, Surface,
    SurfaceRow, Tally,
};

/// `stickslip submit`.
pub fn submit(arguments: &SubmitArguments, interrupt: &Interrupt) -> Result<(), Failure> {
    let overrides = Overrides { seed: arguments.seed, samples: arguments.samples };
    let source = JobSource::read(&arguments.job)?.with(overrides)?;
    let job = source.job()?;
    job.warn_of_few_modes();
    job.warn_of_validity();
    job.warn_of_missing_scatter();
    if let (Some(shard), true) = (arguments.shard, job.is_integrated()) {
        let message =
            format!("--shard {shard}: method = \"exact\" draws no samples that could be shared out; submit it without");
        return Err(Failure::Usage(message));
    }
    let maps = map_directories(&arguments.maps.maps, &job)?;
    let out = arguments.out.clone().unwrap_or_else(|| Path::new("runs").join(&job.name));
    let access = if arguments.shard.is_some() { Access::Shared } else { Access::Alone };
    let directory = RunDirectory::create(&out, access)?;
    let threads = arguments.threads.count();
    let standing = adopt(&directory, &source, &job)?;
    // A run keeps the name and the description under which it began.
    let job = directory.job()?;
    match standing {
        Standing::Finished(tally) if arguments.shard.is_none() && !job.is_integrated() => {
            note(format_args!("{} is finished already; nothing to do", out.display()));
            // A surface that was lost or damaged comes back from the pieces.
            if Surface::new(&job, &tally).publish(directory.path())? {
                note(format_args!("{} was missing or differed; it is written anew", directory.surface().display()));
            }
            report(&directory, &job, &Surface::new(&job, &tally))
        }
        Standing::Unfinished(tally) if arguments.shard.is_none() => Err(Failure::CannotCreate(format!(
            "{} holds an unfinished run of this job ({} of {} samples); continue it with `stickslip resume {}`",
            out.display(),
            HumanCount128(tally.counted()),
            HumanCount128(job.total_samples()),
            quoted(&out)
        ))),
        Standing::Finished(tally) | Standing::Unfinished(tally) | Standing::Fresh(tally) => {
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
    if !job.is_integrated() && Slots::new(&job).complete_cells(&tally) == job.cells() {
        note(format_args!("{} has all its samples; nothing to compute", arguments.run.display()));
    }
    let maps = map_directories(&arguments.maps.maps, &job)?;
    let work = Work { threads: arguments.threads.count(), shard: None, maps, command: "resume" };
    let run = compute(directory, job, tally, &work, interrupt)?;
    report(&run.directory, &run.job, &run.surface())
}

/// The maps of the runs named with `--map`.
fn map_directories(runs: &[PathBuf], job: &Job) -> Result<Vec<PathBuf>, Failure> {
    if let (Some(run), false) = (runs.first(), job.uses_maps()) {
        let message = format!(
            "--map {}: this job uses no verdict map; it would with sampling.evaluate = \"boundary\" or method = \"exact\" and a criterion other than \"eigenvalue\"",
            run.display()
        );
        return Err(Failure::Usage(message));
    }
    let map = |run: &PathBuf| {
        let directory = run.join("map");
        if directory.is_dir() {
            Ok(directory)
        } else {
            Err(Failure::InputOutput(format!("--map {}: there is no verdict map in this run", run.display())))
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
    let complete = Slots::new(&job).complete_cells(&tally);
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
    surface.publish(directory.path())?;
    session.record(directory.path(), "finished", 0)?;
    report(&directory, &job, &surface)
}

/// A run with all its samples counted and its surface written.
pub struct FinishedRun {
    /// Where it is.
    pub directory: RunDirectory,
    /// Its job.
    pub job: Job,
    /// Its verdicts.
    pub tally: Tally,
    /// Its probabilities, where they are integrated.
    integrated: Vec<IntegratedCell>,
}

impl FinishedRun {
    /// Its result.
    pub fn surface(&self) -> Surface<'_> {
        Surface::integrated(&self.job, &self.tally, &self.integrated)
    }
}

/// How a run is computed.
struct Work<'a> {
    threads: usize,
    shard: Option<Shard>,
    /// Directories of verdict maps that may be used.
    maps: Vec<PathBuf>,
    command: &'a str,
}

/// Brings a run of `source` to its end, whatever of it is there already.
pub fn complete_run(
    source: &JobSource,
    out: &Path,
    threads: usize,
    interrupt: &Interrupt,
) -> Result<FinishedRun, Failure> {
    let job = source.job()?;
    let work = Work { threads, shard: None, maps: Vec::new(), command: "reproduce" };
    let directory = RunDirectory::create(out, Access::Alone)?;
    // A run that was extended answers as well, and better.
    if let Some(existing) = directory.job_source()?.map(|frozen| frozen.job()).transpose()?
        && existing.experiment_hash() == job.experiment_hash()
        && existing.sampling.samples > job.sampling.samples
    {
        let tally = directory.tally(&existing)?;
        return compute(directory, existing, tally, &work, interrupt);
    }
    let tally = adopt(&directory, source, &job)?.into_tally();
    compute(directory, job, tally, &work, interrupt)
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
            if directory.freeze_first(source, job)? {
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
    let (wanted, there) = (job.sampling.samples, existing.sampling.samples);
    let at_most = if job.stops_by_precision() { "at most " } else { "" };
    if wanted < there {
        return Err(Failure::Job(format!(
            "{path} holds a run of this job with {at_most}{there} samples in each cell, more than the {wanted} asked for. Ask for them with --samples {there}, or choose another directory with --out"
        )));
    }
    let tally = directory.tally(&existing)?;
    let finished = Slots::new(&existing).complete_cells(&tally) == existing.cells();
    if wanted == there {
        return Ok(if finished { Standing::Finished(tally) } else { Standing::Unfinished(tally) });
    }
    if !finished {
        return Err(Failure::CannotCreate(format!(
            "{path} holds an unfinished run of this job with {at_most}{there} samples in each cell; finish it with `stickslip resume {path}`, then ask for {wanted}"
        )));
    }
    note(format_args!("{path}: from {at_most}{there} to {at_most}{wanted} samples in each cell"));
    directory.freeze(source, job)?;
    // With more samples a cell may have more parts.
    directory.tally(job).map(Standing::Fresh)
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

/// Computes what is missing; without a shard, writes the surface.
fn compute(
    directory: RunDirectory,
    job: Job,
    mut tally: Tally,
    work: &Work<'_>,
    interrupt: &Interrupt,
) -> Result<FinishedRun, Failure> {
    let Work { threads, shard, .. } = *work;
    if shard.is_none() {
        directory.tidy()?;
    }
    let mut session = Session::start(work.command, threads);
    let started = Instant::now();
    let before = tally.counted();
    let path = quoted(directory.path());
    let how = match shard {
        None => format!("stickslip resume {path}"),
        Some(shard) => format!("stickslip submit {path}/job.toml --out {path} --shard {shard}"),
    };
    let kept =
        |failure: Failure| failure.with_remedy(&format!("what was written before is kept; continue with `{how}`"));
    let mut engine = Engine::new(&job, threads)?;
    let mut integrated = Vec::new();
    let mut outcome = Outcome::Finished;
    // The eigenvalues of a flexible disc, and motions, are decided once for each place in the plane; not if all is counted.
    let counts_something = || Plan::new(&tally, &Slots::new(&job), job.unit_samples(), shard).units() > 0;
    // The audit of a cell begins with its first sample: one that began without a map cannot be audited later.
    if job.sampling.is_audited && was_counted_without_map(&job, &tally) {
        engine.give_maps_up();
        if counts_something() {
            note(format_args!(
                "{path}: the samples counted so far were simulated, as a verdict map would have cost more, and so are the others; for a map, submit the job into another directory with --out"
            ));
        }
    } else if job.uses_maps() && (job.is_integrated() || counts_something()) {
        let own = directory.maps();
        engine.load_maps(&own)?;
        let mut borrowed = false;
        for other in &work.maps {
            let loaded = engine.load_maps(other)?;
            borrowed |= loaded > 0;
            if loaded == 0 && !engine.maps().missing().is_empty() {
                note(format_args!("{}: no tile of this model, speed and criterion that is needed", other.display()));
            }
        }
        let completed = engine.complete_maps(Some(&own), borrowed, interrupt).map_err(kept)?;
        outcome = completed.outcome;
        if outcome == Outcome::Finished {
            session.maps(&completed);
        }
        if let Some(why) = completed.why_given_up(&job) {
            note(format_args!("{why} ({:.2} s)", started.elapsed().as_secs_f64()));
        } else if outcome == Outcome::Finished {
            note(format_args!(
                "verdict map: {} tiles from {} simulations, {} of them new ({:.2} s)",
                HumanCount(engine.maps().needed() as u64),
                HumanCount(engine.maps().questions()),
                HumanCount(completed.simulations),
                started.elapsed().as_secs_f64()
            ));
        }
    }
    if outcome == Outcome::Finished && job.is_integrated() {
        (outcome, integrated) = engine.integrate(interrupt)?;
    } else if outcome == Outcome::Finished {
        outcome = count(&engine, &directory, &job, &mut tally, shard, interrupt).map_err(kept)?;
    }
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
        let message = if job.is_integrated() {
            format!("finished tiles of the verdict map are kept; continue with `{how}`")
        } else {
            format!(
                "{} of {}{} samples{} are kept; continue with `{how}`",
                HumanCount128(tally.counted()),
                if job.stops_by_precision() { "at most " } else { "" },
                HumanCount128(job.total_samples()),
                if job.uses_maps() { " and the finished tiles of the verdict map" } else { "" }
            )
        };
        return Err(Failure::Stopped { signal, message });
    }
    let run = FinishedRun { directory, job, tally, integrated };
    if shard.is_none() {
        let surface = run.surface();
        let is_new = surface.publish(run.directory.path())?;
        if run.job.is_integrated() && !is_new {
            note(format_args!("{} is finished already; its surface came out the same", run.directory.path().display()));
        }
        if computed > 0 || is_new {
            session.lookups(surface.lookups());
            session.record(run.directory.path(), "finished", computed)?;
        }
    }
    Ok(run)
}

/// Whether all that is counted of a run was simulated, as its verdict map was given up.
pub fn was_counted_without_map(job: &Job, tally: &Tally) -> bool {
    let surface = Surface::new(job, tally);
    let simulated = surface.lookups().simulated;
    simulated > 0 && u128::from(simulated) == tally.counted()
}

/// Counts the samples that are missing; where more may be wanted after a look at them, in rounds.
fn count(
    engine: &Engine<'_>,
    directory: &RunDirectory,
    job: &Job,
    tally: &mut Tally,
    shard: Option<Shard>,
    interrupt: &Interrupt,
) -> Result<Outcome, Failure> {
    let slots = Slots::new(job);
    loop {
        let plan = Plan::new(tally, &slots, job.unit_samples(), shard);
        if plan.units() == 0 {
            return Ok(Outcome::Finished);
        }
        let mut progress = Progress::new(plan.samples(), "samples");
        let outcome = engine.run(&plan, tally, directory, &mut progress, interrupt);
        progress.finish();
        if outcome? != Outcome::Finished {
            return Ok(interrupt.signal().map_or(Outcome::Finished, Outcome::Stopped));
        }
    }
}

/// Where the result is and what it looks like.
fn report(directory: &RunDirectory, job: &Job, surface: &Surface<'_>) -> Result<(), Failure> {
    let line = closing_line(&directory.surface(), job, surface);
    result(&format!("{}{line}{}{}", picture(surface), without_verdict(surface), looked_up(job, surface)))?;
    let Lookups { audited, differed, .. } = surface.lookups();
    if differed == 0 {
        return Ok(());
    }
    Err(Failure::Audit(format!(
        "{}: {} of {} audited samples were judged otherwise than looked up, so the verdict map is wrong somewhere (a region of another verdict that it does not see). p_low and p_high of each cell contain what its audit does not exclude; {}",
        directory.surface().display(),
        HumanCount(differed),
        HumanCount(audited),
        if job.is_integrated() {
            "use method = \"monte-carlo\" with evaluate = \"each\" for this job"
        } else {
            "use evaluate = \"each\" for this job"
        }
    )))
}

/// A line on samples that were looked up in a verdict map, and what their audit says.
fn looked_up(job: &Job, surface: &Surface<'_>) -> String {
    let Lookups { simulated, audited, differed } = surface.lookups();
    if !job.uses_maps() {
        return String::new();
    }
    let counted: u128 = surface.rows().map(|row| u128::from(row.counts.total())).sum();
    if !job.is_integrated() && u128::from(simulated) == counted {
        return "every sample was simulated, none looked up in a verdict map\n".to_owned();
    }
    let mut text = if job.is_integrated() {
        String::new()
    } else {
        format!("looked up in a verdict map, {} simulated within its resolution; ", HumanCount(simulated))
    };
    text += &if job.sampling.is_audited {
        let widest = surface.rows().filter_map(|row| row.unaudited).fold(0.0, f64::max);
        format!(
            "audit: {} of {} differed, which leaves up to {widest:.1e} of a cell's samples open (p_audit)",
            HumanCount(differed),
            HumanCount(audited)
        )
    } else {
        "no audit: p_low and p_high take the map for right".to_owned()
    };
    text + "\n"
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

fn closing_line(path: &Path, job: &Job, surface: &Surface<'_>) -> String {
    let cells = HumanCount(job.cells());
    if job.is_integrated() {
        let error = |row: SurfaceRow| 0.5 * (row.estimate.high - row.estimate.low) - row.unaudited.unwrap_or(0.0);
        let widest = surface.rows().map(error).fold(0.0, f64::max);
        let undecided = surface.largest_undecided();
        let undecided = if undecided > 0.0 {
            format!("; up to {undecided:.1e} of a cell's samples would be undecided, see p_undecided")
        } else {
            String::new()
        };
        return format!("{}: {cells} cells, integrated, error at most {widest:.1e}{undecided}\n", path.display());
    }
    let samples = if job.stops_by_precision() {
        let counted: u128 = surface.rows().map(|row| u128::from(row.counts.total())).sum();
        format!("{} samples in all, at most {} each", HumanCount128(counted), HumanCount(job.sampling.samples))
    } else {
        format!("{} samples each", HumanCount(job.sampling.samples))
    };
    format!("{}: {cells} cells, {samples}, seed {}\n", path.display(), job.sampling.seed)
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
