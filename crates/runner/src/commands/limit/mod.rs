//! `limit`: the values of an axis at which the probability of instability passes a target.

mod axis;

mod report;

use indicatif::HumanCount;
use stickslip_core::parameters::ParameterError;
use stickslip_sampler::estimate::interval::{BinomialInterval, simultaneous_confidence};
use stickslip_sampler::limits::Limit;
use stickslip_sampler::limits::exact::{Scan, scanned_values};
use stickslip_sampler::limits::spans::Varied;

use self::axis::LimitAxis;
use self::report::{Found, Method, Row};
use crate::cli::LimitArguments;
use crate::evaluate::control::IsStopped;
use crate::evaluate::evaluator::Evaluator;
use crate::evaluate::limits::{OpenCell, varied};
use crate::failure::Failure;
use crate::files::table::write_table;
use crate::interrupt::Interrupt;
use crate::job::{Criterion, Effort, Job, JobSource};
use crate::output::{note, output_file, result, warn};
use crate::schedule::engine::{Engine, Outcome};
use crate::schedule::progress::Progress;
use crate::store::directory::RunDirectory;

/// Largest number of samples of a cell, which are held in memory.
const MOST_SAMPLES: u64 = 10_000_000;

/// `stickslip limit`.
pub fn limit(arguments: &LimitArguments, interrupt: &Interrupt) -> Result<(), Failure> {
    interrupt.remark("nothing was written");
    let LimitArguments { job: path, of, probabilities: targets, out, json, threads } = arguments;
    let job = if path.is_dir() { RunDirectory::view(path)?.job()? } else { JobSource::read(path)?.job()? };
    let axis = LimitAxis::named(&job, of)?;
    check_criterion(&job)?;
    let out = out.as_deref().map(|out| output_file(out).map(|place| (out, place))).transpose()?;
    warn(job.warnings());
    let engine = Engine::new(threads.count())?;
    let combinations = axis.combinations(&job);
    let found = if job.is_integrated() {
        let scanned = scanned_values(&axis.values);
        let method = Method::Exact { scanned: scanned.len() };
        let work = |cell: u64, is_stopped: IsStopped<'_>| exact(&job, &axis, &scanned, targets, cell, is_stopped);
        Found { job: &job, axis: &axis, method, rows: for_each(&engine, interrupt, &combinations, work)? }
    } else {
        let varied = check_samples(&job, &axis)?;
        let evaluator = Evaluator::new(&job)?;
        let confidence = match job.sampling.simultaneous {
            true => simultaneous_confidence(job.sampling.confidence, (combinations.len() * targets.len()) as u64),
            false => job.sampling.confidence,
        };
        let interval = job.interval(confidence);
        let method = Method::Samples { confidence };
        let work = |cell: u64, is_stopped: IsStopped<'_>| {
            Ok(sampled(&evaluator, varied, axis.range(), targets, &interval, cell, is_stopped))
        };
        Found { job: &job, axis: &axis, method, rows: for_each(&engine, interrupt, &combinations, work)? }
    };
    if let Some((out, (directory, name))) = out {
        write_table(&directory, &name, &found.table(), &found.footer())?;
        note(format_args!("{}: {} rows", out.display(), HumanCount(found.rows.len() as u64)));
    }
    result(&if *json { format!("{:#}\n", found.json()) } else { found.text() })
}

/// Limits are found in closed form.
fn check_criterion(job: &Job) -> Result<(), Failure> {
    if matches!(job.criterion, Criterion::Eigenvalue) {
        return Ok(());
    }
    Err(Failure::Usage(format!(
        "limit needs criterion.kind = \"eigenvalue\", whose boundary is known in closed form; the job \"{}\" has another. Submit the job: its summary tells up to which values of its axes the probability is below 1 %, 5 % and 50 %, and surface.parquet has p_high of every cell",
        job.name
    )))
}

/// Samples have limits along preload and static friction.
fn check_samples(job: &Job, axis: &LimitAxis) -> Result<Varied, Failure> {
    let Some(varied) = varied(axis.scalar) else {
        return Err(Failure::Usage(format!(
            "--of {}: with samples, limits are found along preload and static_friction; along other axes use sampling.method = \"exact\" (where only preload and static_friction scatter), or submit the job and read surface.parquet",
            axis.name
        )));
    };
    if job.is_conditional() {
        return Err(Failure::Usage(
            "limit finds its values from verdicts, and samples of sampling.method = \"conditional\" have probabilities; use \"sobol\", or \"exact\" if only preload and static_friction scatter".to_owned(),
        ));
    }
    if let Effort::Until(_) = job.sampling.effort {
        return Err(Failure::Usage(
            "limit uses the same number of samples for every combination of the axes; give sampling.samples in place of sampling.until".to_owned(),
        ));
    }
    let samples = job.sampling.samples;
    if samples > MOST_SAMPLES {
        return Err(Failure::Usage(format!(
            "limit keeps the samples of a cell in memory, {} at most; sampling.samples is {}. Give fewer, or sampling.method = \"exact\", which needs none",
            HumanCount(MOST_SAMPLES),
            HumanCount(samples)
        )));
    }
    Ok(varied)
}

/// Does the work of every combination on all threads: the rows in the order of the combinations. Work that is stopped
/// gives `None`.
fn for_each(
    engine: &Engine,
    interrupt: &Interrupt,
    combinations: &[u64],
    work: impl Fn(u64, IsStopped<'_>) -> Result<Option<Vec<Row>>, Failure> + Sync + Send,
) -> Result<Vec<Row>, Failure> {
    let mut found: Vec<Option<Vec<Row>>> = vec![None; combinations.len()];
    let mut failed: Option<(usize, Failure)> = None;
    let mut progress = Progress::new(combinations.len() as u128, "combinations");
    let of_one = |index: u64, is_stopped: IsStopped<'_>| {
        let index = index as usize;
        (index, work(combinations[index], is_stopped))
    };
    let outcome = engine.for_each_in_parallel(combinations.len() as u64, interrupt, of_one, |(index, rows)| {
        progress.advance(1);
        progress.tick();
        match rows {
            Ok(rows) => found[index] = rows,
            // Of several the first, whatever the threads.
            Err(failure) if failed.as_ref().is_none_or(|(first, _)| index < *first) => failed = Some((index, failure)),
            Err(_) => {}
        }
    })?;
    progress.finish();
    match (outcome, failed) {
        (Outcome::Stopped(signal), _) => Err(Failure::Stopped { signal, message: "nothing was written".to_owned() }),
        (Outcome::Finished, Some((_, failure))) => Err(failure),
        (Outcome::Finished, None) => Ok(found.into_iter().flatten().flatten().collect()),
    }
}

/// What ends the exact search in a combination.
enum Ended {
    Stopped,
    NoSuchBrake(f64, ParameterError),
}

/// The limits of a combination by the exact probability.
fn exact(
    job: &Job,
    axis: &LimitAxis,
    scanned: &[f64],
    targets: &[f64],
    cell: u64,
    is_stopped: IsStopped<'_>,
) -> Result<Option<Vec<Row>>, Failure> {
    let search = || {
        let open = OpenCell::new(job, cell, axis.scalar).map_err(|error| Ended::NoSuchBrake(axis.values[0], error))?;
        let probability = |value: f64| match is_stopped() {
            true => Err(Ended::Stopped),
            false => open.probability(value).map_err(|error| Ended::NoSuchBrake(value, error)),
        };
        let scan = Scan::new(scanned, probability)?;
        let ends = scan.ends().map(Some);
        let mut rows = Vec::new();
        for &target in targets {
            rows.extend(rows_of(cell, target, ends, scan.limits(target, probability)?));
        }
        Ok(rows)
    };
    match search() {
        Ok(rows) => Ok(Some(rows)),
        Err(Ended::Stopped) => Ok(None),
        Err(Ended::NoSuchBrake(value, error)) => Err(Failure::Job(format!(
            "there is no brake with {} = {value} in the combination of cell {cell}: {error}; choose values of axes.{} between which there is one everywhere",
            axis.name, axis.name
        ))),
    }
}

/// The limits of a combination by samples of its cell with the first value of the axis; `None` if it is stopped before.
fn sampled(
    evaluator: &Evaluator<'_>,
    varied: Varied,
    range: [f64; 2],
    targets: &[f64],
    interval: &BinomialInterval,
    cell: u64,
    is_stopped: IsStopped<'_>,
) -> Option<Vec<Row>> {
    let sweep = evaluator.sweep(cell, varied, range, is_stopped)?.sorted();
    let ends = sweep.ends();
    let of = |&target: &f64| rows_of(cell, target, ends, sweep.limits(target, interval)).collect::<Vec<Row>>();
    Some(targets.iter().flat_map(of).collect())
}

fn rows_of(cell: u64, target: f64, ends: [Option<f64>; 2], limits: Vec<Limit>) -> impl Iterator<Item = Row> {
    limits.into_iter().map(move |limit| Row { cell, target, limit, ends })
}
