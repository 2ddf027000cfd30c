//! How far a run is.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::evaluate::parts::Parts;
use crate::evaluate::sums::Lookups;
use crate::failure::Failure;
use crate::job::Job;
use crate::output::{counted, quoted};
use crate::store::directory::RunDirectory;
use crate::store::file_state::FileState;
use crate::store::outdated::{line, outdated};
use crate::tables::surface::Surface;

/// How far a run is.
pub struct RunProgress {
    pub job: Job,
    pub state: &'static str,
    pub in_use: bool,
    /// Where the surface lies, if it is written.
    pub surface: Option<PathBuf>,
    pub complete_cells: u64,
    pub samples_done: u128,
    pub samples_total: u128,
    pub share: f64,
    pub undecided: u64,
    pub failed: u64,
    pub audited: u64,
    pub differed: u64,
    /// Reports and pictures of earlier results.
    pub outdated: Vec<String>,
}

impl RunProgress {
    /// The progress of a run, from its directory alone.
    pub fn read(directory: &RunDirectory) -> Result<Self, Failure> {
        let job = directory.job_to_read()?;
        let tally = directory.tally(&job)?;
        let parts = Parts::new(&job);
        let in_use = directory.in_use();
        // After a run was extended, its surface does not count until it is written again.
        let surface_state = directory.surface_state(&job)?;
        let surface = (surface_state == FileState::Sound).then(|| directory.surface());
        let complete_cells = directory.complete_cells(&job, &tally);
        let state = match (complete_cells == job.cells(), surface.is_some()) {
            _ if in_use => "running",
            (true, false) if matches!(surface_state, FileState::Damaged(_)) => "surface damaged",
            (true, true) => "finished",
            (true, false) => "complete, not merged",
            (false, _) => "unfinished",
        };
        let (samples_done, samples_total) = (tally.counted(), job.total_samples());
        // Progress is measured in cells if no samples are drawn or their number is not known in advance.
        let by_cells = !job.draws_samples() || job.stops_by_precision();
        let share = if by_cells {
            complete_cells as f64 / job.cells() as f64
        } else {
            samples_done as f64 / samples_total as f64
        };
        let Lookups { audited, differed, .. } = Surface::new(&job, &tally).lookups();
        Ok(Self {
            undecided: (0..parts.count()).map(|part| tally.counts(part).undecided).sum(),
            failed: (0..parts.count()).map(|part| tally.counts(part).failed).sum(),
            job,
            state,
            in_use,
            surface,
            complete_cells,
            samples_done,
            samples_total,
            share,
            audited,
            differed,
            outdated: outdated(directory),
        })
    }

    /// What is done of it.
    pub fn percent(&self) -> f64 {
        100.0 * self.share
    }

    /// Everything by name.
    pub fn json(&self, run: &Path) -> Value {
        json!({
            "run": run.display().to_string(),
            "name": self.job.name,
            "state": self.state,
            "in_use": self.in_use,
            "cells": self.job.cells(),
            "cells_complete": self.complete_cells,
            "samples_per_cell": self.job.sampling.samples,
            "samples_done": u64::try_from(self.samples_done).unwrap_or(u64::MAX),
            "samples_total": u64::try_from(self.samples_total).unwrap_or(u64::MAX),
            "share_done": self.share,
            "samples_undecided": self.undecided,
            "samples_failed": self.failed,
            "samples_audited": self.audited,
            "samples_audit_differed": self.differed,
            "outdated": self.outdated,
            "surface": self.surface.as_ref().map(|surface| surface.display().to_string()),
            "job_hash": self.job.hash(),
        })
    }

    /// In a line, with what to do next.
    pub fn text(&self, run: &Path) -> String {
        let next = match self.state {
            "unfinished" => {
                let queued = if run.join("slurm").is_dir() { "unless its tasks are still queued, " } else { "" };
                format!("\n{queued}continue with `stickslip resume {}`", quoted(run))
            }
            "surface damaged" => format!("\nwrite the surface again with `stickslip verify {}`", quoted(run)),
            "complete, not merged" => format!("\nwrite the surface with `stickslip merge {}`", quoted(run)),
            _ => String::new(),
        };
        let mut remarks = match (self.undecided, self.failed) {
            (0, 0) => String::new(),
            (undecided, failed) => {
                format!("; {} undecided, {failed} failed", counted(undecided.into(), "sample", "samples"))
            }
        };
        let Self { audited, differed, .. } = self;
        if *differed > 0 {
            remarks +=
                &format!("; {differed} of {audited} audited samples differed: the verdict map is wrong somewhere");
        }
        format!(
            "{}: {}, {:.1} % ({} of {}{} samples, {} of {} cells complete){remarks}{next}\n{}",
            self.job.name,
            self.state,
            self.percent(),
            self.samples_done,
            if self.job.stops_by_precision() { "at most " } else { "" },
            self.samples_total,
            self.complete_cells,
            self.job.cells(),
            line(&self.outdated, run)
        )
    }
}
