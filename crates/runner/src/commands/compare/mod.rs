//! `compare`: finished runs cell by cell, and sample by sample where they share their samples.
//!
//! Neither surfaces nor pieces hold the joint verdicts of two runs, so the samples are evaluated again, as each run
//! did. They are pure functions of the seed. A cell is paired only if the verdicts are those that both runs counted. By
//! default the intervals hold for all cells together.

mod run;

mod matching;

mod evaluated_run;

mod pairs;

mod differences;

mod report;

use std::path::Path;

use indicatif::HumanCount;
use stickslip_sampler::estimate::interval::simultaneous_confidence;

use self::differences::differences;
pub use self::differences::{Differences, Row};
use self::evaluated_run::{EvaluatedRun, STOPPED};
use self::matching::{Dependence, Matching};
use self::report::{json, picture, summary, table};
pub use self::run::Run;
use crate::cli::CompareArguments;
use crate::evaluate::sums::Lookups;
use crate::failure::Failure;
use crate::files::table::write_table;
use crate::interrupt::Interrupt;
use crate::messages::Code;
use crate::output::{announce, note, output_file, result};
use crate::picture::view::rounded;
use crate::schedule::engine::Engine;
use crate::version::VERSION;

/// Confidence of the intervals in plots and reports, for all cells together.
pub const CONFIDENCE: f64 = 0.95;

/// What the intervals in plots and reports are.
pub fn interval_name(runs: &[&Run]) -> String {
    if runs.iter().any(|run| run.job.draws_samples()) {
        format!("{} % interval for all cells together", rounded(100.0 * CONFIDENCE))
    } else {
        "bounds of the integrals".to_owned()
    }
}

/// `stickslip compare`.
pub fn compare(arguments: &CompareArguments, interrupt: &Interrupt) -> Result<(), Failure> {
    if arguments.runs.iter().any(|run| run == Path::new("-")) {
        let message = "compare takes run directories, and - is standard input; run a job from standard input first: stickslip submit - --out RUN_DIR";
        return Err(Failure::Usage(message.to_owned()));
    }
    if arguments.runs.len() < 2 {
        let only = arguments.runs.first().map_or_else(String::new, |run| format!(", not only {}", run.display()));
        let message =
            format!("compare takes two runs or more{only}: first the reference, then those that are compared with it");
        return Err(Failure::Usage(message));
    }
    let confidence = arguments.confidence;
    if !(0.0 < confidence && confidence <= 1.0 - 1e-12) {
        let message = format!(
            "--confidence {confidence} is out of range: it must be greater than 0 and less than 1, for example 0.95"
        );
        return Err(Failure::Usage(message));
    }
    let out = arguments.out.as_deref().map(|out| output_file(out).map(|place| (out, place))).transpose()?;

    let runs: Vec<Run> = arguments.runs.iter().map(|path| Run::open(path)).collect::<Result<_, _>>()?;
    let engine = Engine::new(arguments.threads.count())?;
    let compared = differences_of(&runs, confidence, arguments.pointwise, &engine, interrupt)?;
    if let Some((out, (directory, name))) = out {
        let footer = [
            ("stickslip:confidence", confidence.to_string()),
            ("stickslip:simultaneous", (!arguments.pointwise).to_string()),
            ("stickslip:engine_version", VERSION.to_owned()),
        ];
        write_table(&directory, &name, &table(&compared), &footer)?;
        announce(Code::FileWritten, format_args!("{}: {} rows", out.display(), rows(&compared)));
    }
    if arguments.json {
        return result(&format!("{:#}\n", json(&compared, confidence, !arguments.pointwise)));
    }
    let meaning = if arguments.pointwise {
        format!("(confidence {confidence} for each by itself)")
    } else {
        format!("(confidence {confidence} for all together)")
    };
    let text = |compared: &Differences| format!("{}\n{}", summary(compared, &meaning), picture(compared));
    result(&compared.iter().map(text).collect::<String>())
}

/// How the runs after the first differ from the first, with intervals that hold all together, or each for itself.
///
/// # Errors
/// Runs without a common cell, samples that cannot be evaluated again, and an interruption.
pub fn differences_of<'r>(
    runs: &'r [Run],
    confidence: f64,
    pointwise: bool,
    engine: &Engine,
    interrupt: &Interrupt,
) -> Result<Vec<Differences<'r>>, Failure> {
    interrupt.remark(STOPPED);
    let Some((reference, others)) = runs.split_first() else { return Ok(Vec::new()) };
    let matchings: Vec<Matching> =
        others.iter().map(|second| Matching::new(reference, second)).collect::<Result<_, _>>()?;
    let evaluated = evaluated_runs(runs, &matchings, engine, interrupt)?;
    evaluated.iter().for_each(warn_of_audit);
    let cells = if pointwise { 1 } else { matchings.iter().map(|matching| matching.cells.len() as u64).sum() };
    let of_a_cell = simultaneous_confidence(confidence, cells);
    let (reference, others) = evaluated.split_at(1);
    let pairs = others.iter().zip(&matchings);
    pairs.map(|(other, matching)| differences(engine, &reference[0], other, matching, of_a_cell, interrupt)).collect()
}

fn rows(compared: &[Differences]) -> HumanCount {
    HumanCount(compared.iter().map(|differences| differences.rows.len() as u64).sum())
}

/// Prepares runs for the evaluation of their samples; `matchings` are those of all runs but the first with the first.
fn evaluated_runs<'a>(
    runs: &'a [Run],
    matchings: &[Matching],
    engine: &Engine,
    interrupt: &Interrupt,
) -> Result<Vec<EvaluatedRun<'a>>, Failure> {
    let is_paired: Vec<bool> = matchings
        .iter()
        .map(|matching| matching.cells.iter().any(|cell| cell.dependence == Dependence::Paired))
        .collect();
    let mut evaluated = Vec::with_capacity(runs.len());
    for (i, run) in runs.iter().enumerate() {
        let needs_verdicts = if i == 0 { is_paired.contains(&true) } else { is_paired[i - 1] };
        evaluated.push(EvaluatedRun::new(run, needs_verdicts, runs, engine, interrupt)?);
    }
    Ok(evaluated)
}

/// Warns if the audit of a run found its verdict map wrong somewhere.
fn warn_of_audit(evaluated: &EvaluatedRun<'_>) {
    let run = evaluated.run;
    let mut lookups = Lookups::default();
    (0..run.job.cells()).for_each(|cell| lookups.add(evaluated.lookups(cell)));
    if lookups.differed > 0 {
        note(format_args!(
            "warning: {}: {} of {} audited samples differed, so its verdict map is wrong somewhere; the intervals contain what the audit does not exclude",
            run.name,
            HumanCount(lookups.differed),
            HumanCount(lookups.audited)
        ));
    }
}
