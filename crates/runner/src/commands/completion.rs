//! Completing a run: computing what is missing of a job.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use indicatif::HumanCount;

use super::adoption::adopt;
use super::limit::publish_limits;
use crate::cli::AskedArguments;
use crate::evaluate::evaluator::Evaluator;
use crate::evaluate::integral::IntegratedCell;
use crate::evaluate::maps::Maps;
use crate::evaluate::parts::Parts;
use crate::failure::{Advice, Failure};
use crate::files::folder::Folder;
use crate::interrupt::Interrupt;
use crate::job::{Answer, Job, JobSource, MapUse};
use crate::messages::Code;
use crate::output::{FREE_SPACE, HumanCount128, announce, counted, note, quoted, rate, warn};
use crate::schedule::engine::{Engine, Outcome, Samples};
use crate::schedule::mapping::{CompletedMaps, Mapping};
use crate::schedule::plan::{Plan, Shard};
use crate::schedule::progress::{Progress, Total};
use crate::store::directory::RunDirectory;
use crate::store::layout::{AUDITS, MAPS, SEARCHES};
use crate::store::lock::{AN_INSTANT, Access};
use crate::store::map_pieces;
use crate::store::provenance::Session;
use crate::store::tally::Tally;
use crate::tables::cell_columns::names_of_pair;
use crate::tables::limits::RunLimits;
use crate::tables::surface::Surface;

/// A run with all its samples counted and its surface written.
pub struct FinishedRun {
    /// Its directory.
    pub directory: RunDirectory,
    /// Its job.
    pub job: Job,
    /// Its verdicts.
    pub tally: Tally,
    /// Its limits, if its job asks for some.
    pub limits: Option<RunLimits>,
    /// Its probabilities, if they are integrated.
    integrated: Vec<IntegratedCell>,
    /// The samples that check its probabilities, if there are any.
    audits: Option<Tally>,
}

impl FinishedRun {
    /// Its result.
    pub fn surface(&self) -> Surface<'_> {
        Surface::integrated(&self.job, &self.tally, &self.integrated).audited(self.audits.as_ref())
    }
}

/// How a run is computed.
pub struct Work<'a> {
    /// The number of threads.
    pub threads: usize,
    /// The shard to compute; `None` for the whole run.
    pub shard: Option<Shard>,
    /// Directories of verdict maps of other runs that may be used.
    pub maps: Vec<Folder>,
    /// Whether only the verdict maps are resolved, of which a shard has a share.
    pub is_map_only: bool,
    /// The command, for the record of the session.
    pub command: &'a str,
    /// What the result says first, in place of what the job asks.
    pub asked: &'a AskedArguments,
}

/// Completes the run of a job in the directory `out`, whatever is there already.
pub fn complete_run(
    source: &JobSource,
    out: &Path,
    threads: usize,
    interrupt: &Interrupt,
) -> Result<FinishedRun, Failure> {
    let job = source.job()?;
    let asked = &AskedArguments::default();
    let work = Work { threads, shard: None, maps: Vec::new(), is_map_only: false, command: "reproduce", asked };
    let directory = RunDirectory::create(out, Access::Alone, AN_INSTANT)?;
    // A run that was extended has the samples of this job and more.
    if let Some(existing) = directory.job_source()?.map(|frozen| frozen.job()).transpose()?
        && existing.extension_hash() == job.extension_hash()
        && existing.sampling.samples > job.sampling.samples
    {
        let tally = directory.tally(&existing)?;
        return compute(directory, existing, tally, &work, interrupt);
    }
    let (job, state) = adopt(&directory, source, job)?;
    compute(directory, job, state.into_tally(), &work, interrupt)
}

/// What is said of an interrupted run.
pub fn kept_and_continued(run: &Path, shard: Option<Shard>, asked: &AskedArguments) -> Advice {
    Advice::command("what is finished is kept; continue with", &how_to_go_on(run, shard, asked))
}

/// The command that continues a run, or a shard of it, which answers no question.
fn how_to_go_on(run: &Path, shard: Option<Shard>, asked: &AskedArguments) -> String {
    let Some(shard) = shard else { return asked.resume(run) };
    let run = quoted(run);
    format!("stickslip submit {run}/job.toml --out {run} --shard {shard}")
}

/// Computes what is missing; without a shard, writes the surface.
pub fn compute(
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
    let how = how_to_go_on(directory.path(), shard, work.asked);
    interrupt.remark(kept_and_continued(directory.path(), shard, work.asked));
    let resumed = Advice::command(&format!("what is on disk already is kept; {FREE_SPACE}"), &how);
    let kept = |failure: Failure, directory: &RunDirectory| match directory.root().require_in_place() {
        Ok(()) => failure.with_advice(&resumed),
        Err(_) => failure.with_advice(&Advice::action("resume the run where it is now")),
    };
    let engine = Engine::new(threads)?;
    let mut evaluator = Evaluator::new(&job)?;
    let mut integrated = Vec::new();
    let searches = match job.answer() == Answer::Integral && job.map_use() == MapUse::Nothing
        || job.answer().is_of_rare_events()
    {
        true => Some(Arc::new(directory.searches_of(SEARCHES, job.experiment_hash())?)),
        false => None,
    };
    if let Some(searches) = &searches {
        evaluator.keep_searches_by(searches.clone());
    }
    // Audits of another version are refused before a map is resolved.
    let mut audits = (job.has_audits() && shard.is_none()).then(|| directory.audits_done(&job)).transpose()?;
    let mut outcome = prepare_maps(&engine, &mut evaluator, &directory, &tally, work, &mut session, interrupt)
        .map_err(|failure| kept(failure, &directory))?;
    let lacking = audits.as_ref().and_then(|audits| lacking_audits(&job, audits));
    if outcome == Outcome::Finished && job.draws_samples() {
        outcome = count(&engine, &evaluator, &directory, &mut tally, shard, interrupt)
            .map_err(|failure| kept(failure, &directory))?;
    }
    if outcome == Outcome::Finished
        && let Some(audits) = &mut audits
    {
        let keep = directory.create_folder(AUDITS)?;
        outcome =
            engine.audit(&evaluator, audits, Some(&keep), interrupt).map_err(|failure| kept(failure, &directory))?;
        if outcome == Outcome::Finished && !job.draws_samples() {
            (outcome, integrated) = engine.integrate(&evaluator, audits, interrupt)?;
        }
    }
    let computed = u64::try_from(tally.counted() - before).unwrap_or(u64::MAX);
    let seconds = started.elapsed().as_secs_f64();
    if computed > 0 {
        note(format_args!(
            "{} in {seconds:.2} s on {} ({} samples/s)",
            counted(computed.into(), "sample", "samples"),
            counted(threads as u128, "thread", "threads"),
            rate(computed as f64 / seconds.max(1e-9))
        ));
    }
    if let Outcome::Stopped(signal) = outcome {
        if shard.is_none() {
            // The samples are what counts, and how to continue.
            warn(session.record(&directory, &signal.to_string(), computed).err().map(|error| error.to_string()));
        }
        let samples = format!(
            "{} of {}{} samples",
            HumanCount128(tally.counted()),
            if job.stops_by_precision() { "at most " } else { "" },
            HumanCount128(job.total_samples()),
        );
        let kept = match job.map_use() {
            MapUse::Nothing if job.draws_samples() => format!("{samples} are kept; continue with"),
            MapUse::Nothing => "integrals that were found are kept; continue with".to_owned(),
            MapUse::LookUp => format!("{samples} and the finished tiles of the verdict map are kept; continue with"),
            MapUse::Integrate => {
                "finished tiles of the verdict map and finished audits are kept; continue with".to_owned()
            }
        };
        return Err(Failure::stopped(signal, &Advice::command(&kept, &how)));
    }
    let mut run = FinishedRun { directory, job, tally, limits: None, integrated, audits };
    if shard.is_none() {
        let surface = run.surface();
        let is_new = surface.publish(&run.directory).map_err(|failure| kept(failure, &run.directory))?;
        if let (Answer::Integral, Some(searches)) = (run.job.answer(), &searches) {
            searches.forget();
        }
        if run.job.answer() == Answer::Integral && !is_new {
            let path = run.directory.path().display();
            match lacking {
                None => {
                    announce(Code::RunFinished, format_args!("{path} is finished already; its surface is unchanged"));
                }
                Some(samples) => note(format_args!("{path} lacked {samples}, drawn now; its surface is unchanged")),
            }
        }
        if computed > 0 || is_new {
            session.lookups(surface.lookups());
            session.record(&run.directory, "finished", computed).map_err(|failure| kept(failure, &run.directory))?;
        }
        let limits = publish_limits(&run.directory, &run.job, &engine, interrupt, work.asked);
        run.limits = limits.map_err(|failure| kept(failure, &run.directory))?;
    }
    Ok(run)
}

/// What a run lacks of the samples that check its probabilities.
fn lacking_audits(job: &Job, audits: &Tally) -> Option<String> {
    let parts = Parts::of_audits(job);
    let lacking = Plan::new(audits, &parts, parts.unit_samples(), None).samples();
    let [one, many] = match job.plain_samples() {
        0 => ["audited sample", "audited samples"],
        _ => ["plain sample", "plain samples"],
    };
    (lacking > 0).then(|| format!("{} beside its probabilities", counted(lacking, one, many)))
}

/// Says of a run whose samples are all counted that it is `finished`, or which plain samples it lacks, which are drawn.
pub fn announce_finished(directory: &RunDirectory, job: &Job, finished: &str) -> Result<(), Failure> {
    let path = directory.path().display();
    let audits = (job.plain_samples() > 0).then(|| directory.audits_done(job)).transpose()?;
    match audits.and_then(|audits| lacking_audits(job, &audits)) {
        None => announce(Code::RunFinished, format_args!("{path} {finished}")),
        Some(samples) => note(format_args!("{path} has all its samples but {samples}, which are drawn now")),
    }
    Ok(())
}

/// The samples that check the probabilities of a run whose samples are all counted; those that are missing are drawn.
///
/// # Errors
/// A signal that stops it, and files that cannot be read or written.
pub fn complete_audits(
    directory: &RunDirectory,
    job: &Job,
    engine: &Engine,
    interrupt: &Interrupt,
    asked: &AskedArguments,
) -> Result<Option<Tally>, Failure> {
    if job.plain_samples() == 0 {
        return Ok(None);
    }
    let mut audits = directory.audits_done(job)?;
    let keep = directory.create_folder(AUDITS)?;
    match engine.audit(&Evaluator::new(job)?, &mut audits, Some(&keep), interrupt)? {
        Outcome::Finished => Ok(Some(audits)),
        Outcome::Stopped(signal) => Err(Failure::stopped(signal, &kept_and_continued(directory.path(), None, asked))),
    }
}

/// Completes the verdict maps that the missing samples or integrals need.
fn prepare_maps(
    engine: &Engine,
    evaluator: &mut Evaluator<'_>,
    directory: &RunDirectory,
    tally: &Tally,
    work: &Work<'_>,
    session: &mut Session,
    interrupt: &Interrupt,
) -> Result<Outcome, Failure> {
    let job = evaluator.job();
    let started = Instant::now();
    let is_incomplete = || Plan::new(tally, evaluator.parts(), job.unit_samples(), work.shard).units() > 0;
    match job.map_use() {
        MapUse::Integrate => {}
        MapUse::LookUp if is_incomplete() || lost_tiles(directory, job, tally)?.0 > 0 => {}
        MapUse::Nothing | MapUse::LookUp => return Ok(Outcome::Finished),
    }
    let completed = complete_maps(engine, evaluator, directory, work, interrupt)?;
    if completed.outcome == Outcome::Finished {
        let seconds = started.elapsed().as_secs_f64();
        session.maps(completed.tiles, completed.simulations);
        note(format_args!(
            "verdict map: {} tiles from {} simulations, {} of them new ({seconds:.2} s)",
            HumanCount(evaluator.maps().needed() as u64),
            HumanCount(evaluator.maps().simulations()),
            HumanCount(completed.simulations)
        ));
    }
    Ok(completed.outcome)
}

/// Completes the verdict maps of a run, with its own tiles and those of other runs.
fn complete_maps(
    engine: &Engine,
    evaluator: &mut Evaluator<'_>,
    directory: &RunDirectory,
    work: &Work<'_>,
    interrupt: &Interrupt,
) -> Result<CompletedMaps, Failure> {
    let own = directory.create_folder(MAPS)?;
    map_pieces::load(evaluator.maps_mut(), &own)?;
    let mut borrowed = false;
    for other in &work.maps {
        let loaded = map_pieces::load(evaluator.maps_mut(), other)?;
        borrowed |= loaded > 0;
        if loaded == 0 && !evaluator.maps().missing().is_empty() {
            note(format_args!(
                "{}: it has no tile of this model, speed and criterion that this job needs",
                other.path().display()
            ));
        }
    }
    let share = work.shard.filter(|_| work.is_map_only);
    let mapping = Mapping { keep: Some(&own), borrowed, share };
    engine.complete_maps(evaluator, mapping, interrupt)
}

/// Resolves the verdict maps of a job, or the share of a shard, and prints how to go on.
pub fn map_only(directory: &RunDirectory, job: &Job, work: &Work<'_>, interrupt: &Interrupt) -> Result<(), Failure> {
    let started = Instant::now();
    let path = quoted(directory.path());
    let submit = format!("stickslip submit {path}/job.toml --out {path}");
    let share = work.shard.map_or(String::new(), |shard| format!(" --shard {shard}"));
    let again = format!("{submit} --map-only{share}");
    interrupt.remark(Advice::command("finished tiles of the verdict map are kept; continue with", &again));
    let next = match job.draws_samples() {
        true => format!("`stickslip resume {path}`, or shard by shard with `{submit} --shard I/N`"),
        false => format!("`stickslip resume {path}`"),
    };
    let engine = Engine::new(work.threads)?;
    let mut evaluator = Evaluator::new(job)?;
    let completed = complete_maps(&engine, &mut evaluator, directory, work, interrupt)
        .map_err(|failure| failure.with_advice(&Advice::command("finished tiles are kept; continue with", &again)))?;
    let needed = HumanCount(evaluator.maps().needed() as u64);
    if let Outcome::Stopped(signal) = completed.outcome {
        let tiles = HumanCount(completed.tiles);
        let kept = format!("{tiles} of {needed} tiles of the verdict map are kept; continue with");
        return Err(Failure::stopped(signal, &Advice::command(&kept, &again)));
    }
    let seconds = started.elapsed().as_secs_f64();
    let new = HumanCount(completed.simulations);
    if evaluator.maps().missing().is_empty() {
        note(format_args!(
            "the verdict map is complete: {needed} tiles, {new} simulations now ({seconds:.2} s); go on with {next}"
        ));
    } else {
        note(format_args!(
            "the verdict map has {} of its {needed} tiles, {new} simulations now ({seconds:.2} s); when every other shard has run `{submit} --map-only --shard I/N`, go on with {next}",
            HumanCount(completed.tiles)
        ));
    }
    Ok(())
}

/// The tiles of its verdict map that a run with all its samples has lost, and how many it needs.
pub fn lost_tiles(directory: &RunDirectory, job: &Job, tally: &Tally) -> Result<(usize, usize), Failure> {
    let is_whole = Parts::new(job).are_complete(tally);
    if job.map_use() != MapUse::LookUp || !is_whole {
        return Ok((0, 0));
    }
    let mut maps = Maps::new(job);
    directory.maps()?.map(|folder| map_pieces::load(&mut maps, &folder)).transpose()?;
    Ok((maps.missing().len(), maps.needed()))
}

/// What evaluates samples of a cell of a run once more, with the verdict maps that the run used.
pub fn evaluator_again<'a>(directory: &RunDirectory, job: &'a Job, cell: u64) -> Result<Evaluator<'a>, Failure> {
    if cell >= job.cells() {
        return Err(Failure::Usage(format!("--cell {cell}: the run has cells 0 to {}", job.cells() - 1)));
    }
    if let Some(why) = job.sampling.method.without_verdicts(&names_of_pair(job.model())) {
        return Err(Failure::Usage(why));
    }
    let mut evaluator = Evaluator::new(job)?;
    directory.maps()?.map(|maps| map_pieces::load(evaluator.maps_mut(), &maps)).transpose()?;
    Ok(evaluator)
}

/// Evaluates and counts the missing samples. With `until`, it repeats that as long as more samples are wanted.
fn count(
    engine: &Engine,
    evaluator: &Evaluator<'_>,
    directory: &RunDirectory,
    tally: &mut Tally,
    shard: Option<Shard>,
    interrupt: &Interrupt,
) -> Result<Outcome, Failure> {
    let (job, parts) = (evaluator.job(), evaluator.parts());
    let pieces = directory.shards();
    let mut progress = Progress::new(0, "samples");
    let mut outcome = Ok(Outcome::Finished);
    while matches!(outcome, Ok(Outcome::Finished)) {
        let plan = Plan::new(tally, parts, job.unit_samples(), shard);
        if plan.units() == 0 {
            break;
        }
        match parts.expected_to_be_missing(tally) {
            // A shard has its share of the cells.
            Some(expected) => {
                let of_shard = expected / u128::from(shard.map_or(1, Shard::count));
                progress.expect_left(of_shard.max(plan.samples()), Total::Expected);
            }
            None if parts.are_sequential() => progress.expect_left(plan.samples(), Total::AtLeast),
            None => progress.expect_left(plan.samples(), Total::Known),
        }
        let samples = Samples { plan: &plan, parts, pieces: Some(pieces), are_audits: false };
        outcome = engine.run(evaluator, samples, tally, &mut progress, interrupt);
        // Only looks ask for more.
        if !parts.are_sequential() {
            break;
        }
    }
    progress.finish();
    outcome
}
