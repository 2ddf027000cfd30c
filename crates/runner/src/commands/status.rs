//! `status`: the progress of a run.

use serde_json::json;

use crate::cli::StatusArguments;
use crate::evaluate::parts::Parts;
use crate::evaluate::sums::Lookups;
use crate::failure::Failure;
use crate::output::{quoted, result};
use crate::store::directory::RunDirectory;
use crate::tables::surface::Surface;

/// `stickslip status`.
pub fn status(arguments: &StatusArguments) -> Result<(), Failure> {
    let directory = RunDirectory::view(&arguments.run)?;
    let job = directory.job()?;
    let tally = directory.tally(&job)?;
    let parts = Parts::new(&job);
    let in_use = directory.in_use();
    // After a run was extended, its surface does not count until it is written again.
    let surface = directory.surface();
    let is_written = directory.has_surface_of(&job);
    let complete_cells = directory.complete_cells(&job, &tally);
    let state = match (complete_cells == job.cells(), is_written) {
        _ if in_use => "running",
        (true, true) => "finished",
        (true, false) => "complete, not merged",
        (false, _) => "unfinished",
    };
    let (counted, total) = (tally.counted(), job.total_samples());
    // Progress is measured in cells if no samples are drawn or their number is not known in advance.
    let by_cells = job.is_integrated() || job.stops_by_precision();
    let share = if by_cells { complete_cells as f64 / job.cells() as f64 } else { counted as f64 / total as f64 };
    let undecided: u64 = (0..parts.count()).map(|part| tally.counts(part).undecided).sum();
    let failed: u64 = (0..parts.count()).map(|part| tally.counts(part).failed).sum();
    let Lookups { audited, differed, .. } = Surface::new(&job, &tally).lookups();
    if arguments.json {
        let status = json!({
            "run": arguments.run.display().to_string(),
            "name": job.name,
            "state": state,
            "in_use": in_use,
            "cells": job.cells(),
            "cells_complete": complete_cells,
            "samples_per_cell": job.sampling.samples,
            "samples_done": u64::try_from(counted).unwrap_or(u64::MAX),
            "samples_total": u64::try_from(total).unwrap_or(u64::MAX),
            "share_done": share,
            "samples_undecided": undecided,
            "samples_failed": failed,
            "samples_audited": audited,
            "samples_audit_differed": differed,
            "surface": is_written.then(|| surface.display().to_string()),
            "job_hash": job.hash(),
        });
        return result(&format!("{status:#}\n"));
    }
    let next = match state {
        "unfinished" => format!("\ncontinue with `stickslip resume {}`", quoted(&arguments.run)),
        "complete, not merged" => format!("\nwrite the surface with `stickslip merge {}`", quoted(&arguments.run)),
        _ => String::new(),
    };
    let mut remarks = match (undecided, failed) {
        (0, 0) => String::new(),
        _ => format!("; {undecided} samples undecided, {failed} failed"),
    };
    if differed > 0 {
        remarks += &format!("; {differed} of {audited} audited samples differed: the verdict map is wrong somewhere");
    }
    result(&format!(
        "{}: {state}, {:.1} % ({counted} of {}{total} samples, {complete_cells} of {} cells complete){remarks}{next}\n",
        job.name,
        100.0 * share,
        if job.stops_by_precision() { "at most " } else { "" },
        job.cells()
    ))
}
