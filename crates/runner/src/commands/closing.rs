//! The report of a finished run.

use std::path::Path;

use indicatif::HumanCount;
use stickslip_sampler::estimate::interval::Estimate;
use stickslip_sampler::estimate::weighted::Distrust;

use crate::evaluate::sums::Lookups;
use crate::failure::Failure;
use crate::job::{Computed, Job, MapUse};
use crate::output::{counted, result, shown, wrapped};
use crate::picture::answer::answer;
use crate::picture::exceptions::Exceptions;
use crate::picture::picture;
use crate::store::directory::RunDirectory;
use crate::store::outdated;
use crate::tables::row::SurfaceRow;
use crate::tables::surface::Surface;

/// Prints the result as a picture and as a sentence, where it and its `limits` are, and notes on it.
///
/// # Errors
/// An audit that found wrong verdicts in the verdict map.
pub fn report(directory: &RunDirectory, job: &Job, surface: &Surface<'_>, limits: Option<&str>) -> Result<(), Failure> {
    let summary = Summary::new(surface);
    let line = closing_line(&directory.surface(), job, &summary) + limits.unwrap_or_default();
    let notes = [
        summary.exceptions.sentences(job).into_iter().map(|sentence| sentence + "\n").collect(),
        looked_up(job, &summary),
        distrusted(job, &summary),
        job.reduction().map_or_else(String::new, |reduction| reduction.sentence() + "\n"),
        outdated::line(&outdated::outdated(directory), directory.path()),
    ]
    .concat();
    result(&format!("{}{}{line}{notes}", picture(surface), wrapped(&answer(job, &summary.estimates))))?;
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
    /// In how many cells the estimate is not to be trusted, where samples have weights, by reason.
    distrusted: [u64; 4],
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
            distrusted: [0; 4],
            unaudited: 0.0,
        };
        for SurfaceRow { counts, estimate, unaudited, outside_physics, weighted, .. } in surface.rows() {
            summary.computed.evaluations += weighted.map_or(0.0, |weighted| weighted.evaluations);
            match weighted.and_then(|weighted| weighted.distrust) {
                None => {}
                Some(Distrust::NothingFound) => summary.distrusted[0] += 1,
                Some(Distrust::FewSamples) => summary.distrusted[1] += 1,
                Some(Distrust::Disagreement) => summary.distrusted[2] += 1,
                Some(Distrust::WithoutVerdict) => summary.distrusted[3] += 1,
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

/// Lines on the cells whose estimates are not to be trusted, where samples have weights.
fn distrusted(job: &Job, summary: &Summary) -> String {
    let [nothing, few, differ, open] = summary.distrusted;
    if nothing + few + differ + open == 0 {
        return String::new();
    }
    let more = job.sampling.method.more();
    let mut text = String::new();
    for (count, what) in [
        (nothing, "no unstable sample was found, even with a larger scatter".to_owned()),
        (few, format!("few samples have most of the probability; take more {more}")),
        (differ, format!("independent populations disagree, so some have missed a region; take more {more}")),
        (
            open,
            "samples without a verdict are more probable than unstable ones, so that the populations say little"
                .to_owned(),
        ),
    ] {
        if count > 0 {
            text += &format!("p_unstable is null in {}: {what}\n", counted(count.into(), "cell", "cells"));
        }
    }
    text
}

fn closing_line(path: &Path, job: &Job, summary: &Summary) -> String {
    let cells = counted(job.cells().into(), "cell", "cells");
    format!("{}: {cells}, {}\n", shown(path), job.sampling.method.closing(&job.sampling, &summary.computed))
}
