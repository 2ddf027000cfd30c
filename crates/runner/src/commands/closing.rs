//! The report of a finished run.

use std::path::Path;

use indicatif::HumanCount;
use serde_json::json;
use stickslip_core::model::recorded::RecordedOf;
use stickslip_sampler::estimate::audit::PlainSamples;
use stickslip_sampler::estimate::interval::Estimate;

use crate::evaluate::sums::Lookups;
use crate::failure::Failure;
use crate::job::reduction::Reduction;
use crate::job::{Answer, Computed, Job, MapUse};
use crate::output::{counted, result, shown, wrapped};
use crate::picture::answer::answer;
use crate::picture::asked_cell::KnownCell;
use crate::picture::exceptions::Exceptions;
use crate::picture::picture;
use crate::store::directory::RunDirectory;
use crate::store::layout::LIMITS;
use crate::store::outdated;
use crate::tables::limits::RunLimits;
use crate::tables::row::SurfaceRow;
use crate::tables::surface::Surface;

/// With which confidence plain samples exclude that something was missed.
const CONFIDENCE: f64 = 0.95;

/// Prints the result as a picture and as a sentence, where it and its `limits` are, and notes on it.
///
/// # Errors
/// An audit that found wrong verdicts in the verdict map.
pub fn report(
    directory: &RunDirectory,
    job: &Job,
    surface: &Surface<'_>,
    limits: Option<&RunLimits>,
) -> Result<(), Failure> {
    let summary = Summary::new(surface);
    let line = closing_line(&directory.surface(), job, &summary) + limits.map_or("", |limits| &limits.line);
    let notes = [
        summary.exceptions.sentences(job).into_iter().map(|sentence| sentence + "\n").collect(),
        looked_up(job, &summary),
        excluded(job, &summary),
        job.reduction().map_or_else(String::new, |reduction| reduction.sentence() + "\n"),
        outdated::line(&outdated::outdated(directory), directory.path()),
    ]
    .concat();
    result(&format!("{}{}{line}{notes}", picture(surface), wrapped(&answered(job, surface, &summary))))?;
    judged(directory, job, &summary, limits)
}

/// Prints the same as JSON, for programs.
///
/// # Errors
/// As [`report`].
pub fn report_as_json(
    directory: &RunDirectory,
    job: &Job,
    surface: &Surface<'_>,
    limits: Option<&RunLimits>,
) -> Result<(), Failure> {
    let summary = Summary::new(surface);
    let known = || summary.estimates.iter().filter_map(|estimate| estimate.probability);
    let said = json!({
        "run": directory.path().display().to_string(),
        "name": job.name,
        "job_hash": job.hash(),
        "surface": directory.surface().display().to_string(),
        "limits": limits.map(|_| directory.path().join(LIMITS).display().to_string()),
        "cells": job.cells(),
        "samples_done": u64::try_from(summary.computed.samples).unwrap_or(u64::MAX),
        "samples_audited": summary.lookups.audited,
        "samples_audit_differed": summary.lookups.differed,
        "p_unstable_min": known().reduce(f64::min),
        "p_unstable_max": known().reduce(f64::max),
        "answer": answered(job, surface, &summary).trim_end(),
        "decision": job.asked_cell().map(|cell| KnownCell::from(&surface.row(cell)).decision(job, cell)),
        "notes": summary.exceptions.sentences(job),
    });
    result(&format!("{said:#}\n"))?;
    judged(directory, job, &summary, limits)
}

/// The result in sentences, that of the operating point first.
fn answered(job: &Job, surface: &Surface<'_>, summary: &Summary) -> String {
    let asked = job.asked_cell().map(|cell| KnownCell::from(&surface.row(cell)));
    answer(job, &summary.estimates, asked.as_ref())
}

/// Refuses a result that its audit contradicts. It is written all the same.
fn judged(directory: &RunDirectory, job: &Job, summary: &Summary, limits: Option<&RunLimits>) -> Result<(), Failure> {
    if let Some(why) = limits.and_then(|limits| limits.contradiction.clone()) {
        return Err(Failure::Audit(why));
    }
    let contradicted = summary.exceptions.contradicted();
    if contradicted > 0 {
        return Err(Failure::Audit(format!(
            "{}: plain samples contradict the probability in {} of {}, so {} missed a region there; take method = \"monte-carlo\" for this job",
            directory.surface().display(),
            HumanCount(contradicted),
            counted(job.cells().into(), "cell", "cells"),
            job.sampling.method.asked(),
        )));
    }
    if let Some(why) = job.reduction().and_then(Reduction::contradiction) {
        let surface = directory.surface();
        return Err(Failure::Audit(format!("{}: its matrices are reduced, and {why}", surface.display())));
    }
    let Lookups { audited, differed, .. } = summary.lookups;
    if differed == 0 {
        return Ok(());
    }
    Err(Failure::Audit(format!(
        "{}: {} of {} audited samples have another verdict than the one looked up, so the verdict map is wrong somewhere (it misses a region of another verdict). p_low and p_high of each cell contain what its audit does not exclude; {}",
        directory.surface().display(),
        HumanCount(differed),
        HumanCount(audited),
        match job.map_use() {
            MapUse::Integrate => "use method = \"monte-carlo\" with evaluate = \"each\" for this job",
            MapUse::LookUp | MapUse::Nothing => "use evaluate = \"each\" for this job",
        }
    )))
}

/// What the report says of all cells together. Making their rows takes long in large jobs, so that it is done once.
struct Summary {
    estimates: Vec<Estimate>,
    lookups: Lookups,
    /// What was computed.
    computed: Computed,
    exceptions: Exceptions,
    /// The plain samples beside probabilities, and the largest share of a cell that they do not exclude to have been missed.
    plain: PlainSamples,
    missed: f64,
    /// The largest share of wrong looked-up verdicts of a cell that its audit does not exclude.
    unaudited: f64,
}

impl Summary {
    fn new(surface: &Surface<'_>) -> Self {
        let mut summary = Self {
            estimates: Vec::with_capacity(surface.job().cells() as usize),
            lookups: surface.lookups(),
            computed: Computed { samples: 0, evaluations: 0.0, error: 0.0, undecided: surface.largest_undecided() },
            exceptions: Exceptions::default(),
            plain: PlainSamples::default(),
            missed: 0.0,
            unaudited: 0.0,
        };
        // What is looked up, or counts by its weight, has no motion of its own.
        let job = surface.job();
        let is_simulated = job.answer() == Answer::Verdict && job.map_use() == MapUse::Nothing;
        let of_unstable = job.model().recorded().iter().position(|result| result.of == RecordedOf::Unstable);
        let of_unstable = of_unstable.filter(|_| is_simulated);
        for row in surface.rows() {
            let SurfaceRow { counts, estimate, unaudited, outside_physics, weighted, plain, distrust, .. } = row;
            let recorded = of_unstable.map(|place| row.recorded[place].count());
            summary.exceptions.add_unsettled(recorded.map_or(0, |recorded| counts.unstable.saturating_sub(recorded)));
            summary.computed.evaluations += weighted.map_or(0.0, |weighted| weighted.evaluations);
            summary.exceptions.add_distrust(distrust);
            if let Some(plain) = plain.filter(|_| distrust == 0) {
                summary.plain.decided += plain.decided;
                summary.plain.unstable += plain.unstable;
                let missed = plain.largest_missed([estimate.low, estimate.high], CONFIDENCE);
                summary.missed = summary.missed.max(missed);
            }
            summary.computed.samples += u128::from(counts.total());
            summary.exceptions.add(counts.total(), counts.undecided, counts.failed, outside_physics);
            summary.unaudited = summary.unaudited.max(unaudited.unwrap_or(0.0));
            let error = 0.5 * (estimate.high - estimate.low) - unaudited.unwrap_or(0.0);
            summary.computed.error = summary.computed.error.max(error);
            summary.estimates.push(estimate);
        }
        summary
    }
}

/// A line on samples that were looked up in a verdict map, with the result of the audit.
fn looked_up(job: &Job, summary: &Summary) -> String {
    let Lookups { simulated, audited, differed } = summary.lookups;
    let mut text = match job.map_use() {
        MapUse::Nothing => return String::new(),
        MapUse::Integrate => String::new(),
        MapUse::LookUp if u128::from(simulated) == summary.computed.samples => {
            return "every sample was simulated, none looked up in a verdict map\n".to_owned();
        }
        MapUse::LookUp => {
            format!("looked up in a verdict map, {} simulated within its resolution; ", HumanCount(simulated))
        }
    };
    text += &if job.sampling.is_audited {
        let widest = summary.unaudited;
        format!(
            "audit: {} of {} differed, so up to {widest:.1e} of a cell's samples may have a wrong verdict (p_audit)",
            HumanCount(differed),
            HumanCount(audited)
        )
    } else {
        "no audit: p_low and p_high assume that the map is right".to_owned()
    };
    text + "\n"
}

/// A line on what the plain samples beside probabilities exclude.
fn excluded(job: &Job, summary: &Summary) -> String {
    let PlainSamples { decided, unstable } = summary.plain;
    if job.plain_samples() == 0 || decided == 0 {
        return String::new();
    }
    let [where_, of] = if job.cells() == 1 { ["the probability", ""] } else { ["the probabilities", " of a cell"] };
    format!(
        "{} beside {where_} ({} unstable): no region of more than {:.1e}{of} was missed{}\n",
        counted(decided.into(), "plain sample", "plain samples"),
        HumanCount(unstable),
        summary.missed,
        if job.reduction().is_some() { " by the reduced matrices" } else { "" }
    )
}

fn closing_line(path: &Path, job: &Job, summary: &Summary) -> String {
    let cells = counted(job.cells().into(), "cell", "cells");
    format!("{}: {cells}, {}\n", shown(path), job.sampling.method.closing(&job.sampling, &summary.computed))
}
