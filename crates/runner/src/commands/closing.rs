//! The report of a finished run.

use std::path::Path;

use indicatif::HumanCount;
use stickslip_sampler::estimate::interval::Estimate;

use crate::evaluate::sums::Lookups;
use crate::failure::Failure;
use crate::job::{Job, OutsidePhysics};
use crate::output::{counted, result, wrapped};
use crate::picture::answer::answer;
use crate::picture::picture;
use crate::store::directory::RunDirectory;
use crate::tables::row::SurfaceRow;
use crate::tables::surface::Surface;

/// Prints the result as a picture and as a sentence, where it is, and notes on it.
///
/// # Errors
/// An audit that found wrong verdicts in the verdict map.
pub fn report(directory: &RunDirectory, job: &Job, surface: &Surface<'_>) -> Result<(), Failure> {
    let line = closing_line(&directory.surface(), job, surface);
    let notes = [outside_physics(job, surface), without_verdict(surface), looked_up(job, surface)].concat();
    let estimates: Vec<Estimate> = surface.rows().map(|row| row.estimate).collect();
    result(&format!("{}{}{line}{notes}", picture(surface), wrapped(&answer(job, &estimates))))?;
    let Lookups { audited, differed, .. } = surface.lookups();
    if differed == 0 {
        return Ok(());
    }
    Err(Failure::Audit(format!(
        "{}: {} of {} audited samples have another verdict than the one looked up, so the verdict map is wrong somewhere (it misses a region of another verdict). p_low and p_high of each cell contain what its audit does not exclude; {}",
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

/// A line on samples that were looked up in a verdict map, with the result of the audit.
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
            "audit: {} of {} differed, so up to {widest:.1e} of a cell's samples may have a wrong verdict (p_audit)",
            HumanCount(differed),
            HumanCount(audited)
        )
    } else {
        "no audit: p_low and p_high assume that the map is right".to_owned()
    };
    text + "\n"
}

/// A line on samples outside physics, if there are any.
fn outside_physics(job: &Job, surface: &Surface<'_>) -> String {
    let (mut outside, mut counted) = (0, 0_u128);
    let mut largest = 0.0_f64;
    for row in surface.rows() {
        outside += row.outside_physics;
        counted += u128::from(row.counts.total());
        largest = largest.max(row.outside_physics as f64 / row.counts.total().max(1) as f64);
    }
    if outside == 0 {
        return String::new();
    }
    let share = |share: f64| format!("{:.2} %", 100.0 * share);
    format!(
        "{} samples ({}, in one cell up to {}) have no preload or friction that rises with speed (f_s < f_c); {}\n",
        HumanCount(outside),
        share(outside as f64 / counted as f64),
        share(largest),
        match job.outside_physics {
            OutsidePhysics::Stable if job.has_flexible_disc() => {
                "they are decided as they are, see criterion.outside_physics"
            }
            OutsidePhysics::Stable => "they count as stable, see criterion.outside_physics",
            OutsidePhysics::Failed => "they count as failed",
            OutsidePhysics::Clamp => "they are moved to Delta = 0 or f_s = f_c",
        }
    )
}

/// A line on undecided and failed samples, if there are any.
fn without_verdict(surface: &Surface<'_>) -> String {
    let (mut undecided, mut failed) = (0, 0);
    for row in surface.rows() {
        undecided += row.counts.undecided;
        failed += row.counts.failed;
    }
    match (undecided, failed) {
        (0, 0) => String::new(),
        _ => format!(
            "{} undecided, {} failed; p_low and p_high allow for either verdict on them\n",
            count_of_samples(undecided.into()),
            HumanCount(failed)
        ),
    }
}

fn count_of_samples(count: u128) -> String {
    counted(count, "sample", "samples")
}

fn closing_line(path: &Path, job: &Job, surface: &Surface<'_>) -> String {
    let cells = counted(job.cells().into(), "cell", "cells");
    if job.is_integrated() {
        let error = |row: SurfaceRow| 0.5 * (row.estimate.high - row.estimate.low) - row.unaudited.unwrap_or(0.0);
        let widest = surface.rows().map(error).fold(0.0, f64::max);
        let undecided = surface.largest_undecided();
        let undecided = if undecided > 0.0 {
            format!("; up to {undecided:.1e} of a cell's samples would be undecided, see p_undecided")
        } else {
            String::new()
        };
        return format!("{}: {cells}, integrated, error at most {widest:.1e}{undecided}\n", path.display());
    }
    let samples = if job.stops_by_precision() {
        let drawn: u128 = surface.rows().map(|row| u128::from(row.counts.total())).sum();
        format!("{} in all, at most {} each", count_of_samples(drawn), HumanCount(job.sampling.samples))
    } else {
        format!("{} each", count_of_samples(job.sampling.samples.into()))
    };
    format!("{}: {cells}, {samples}, seed {}\n", path.display(), job.sampling.seed)
}
