//! `status`: the progress of a run, or of every run in a folder.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::cli::StatusArguments;
use crate::evaluate::parts::Parts;
use crate::evaluate::sums::Lookups;
use crate::failure::Failure;
use crate::job::Job;
use crate::output::{quoted, result, warn};
use crate::store::directory::RunDirectory;
use crate::tables::surface::Surface;

/// `stickslip status`.
pub fn status(arguments: &StatusArguments) -> Result<(), Failure> {
    let path = &arguments.run;
    let directory = match RunDirectory::view(path) {
        Ok(directory) => directory,
        Err(failure) => {
            return match RunDirectory::runs_in(path)?.as_slice() {
                [] => Err(failure),
                runs => status_of_all(runs, arguments.json),
            };
        }
    };
    let progress = Progress::of(&directory)?;
    result(&if arguments.json { format!("{:#}\n", progress.json(path)) } else { progress.text(path) })
}

/// One line for each run of a folder. A run that cannot be read does not hide the others.
fn status_of_all(runs: &[PathBuf], as_json: bool) -> Result<(), Failure> {
    let all: Vec<(&PathBuf, Result<Progress, Failure>)> =
        runs.iter().map(|run| (run, RunDirectory::view(run).and_then(|run| Progress::of(&run)))).collect();
    if as_json {
        let values = all.iter().map(|(path, progress)| match progress {
            Ok(progress) => progress.json(path),
            Err(failure) => {
                json!({ "run": path.display().to_string(), "state": UNREADABLE, "message": failure.to_string() })
            }
        });
        return result(&format!("{:#}\n", Value::Array(values.collect())));
    }
    warn(all.iter().filter_map(|(_, progress)| progress.as_ref().err().map(ToString::to_string)));
    // Directories have the names that other commands take; several may hold jobs of one name.
    let name = |path: &Path| path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let state = |progress: &Result<Progress, Failure>| progress.as_ref().map_or(UNREADABLE, |progress| progress.state);
    let longest = |lengths: &mut dyn Iterator<Item = usize>| lengths.max().unwrap_or(0);
    let name_width = longest(&mut all.iter().map(|(path, _)| name(path).chars().count()));
    let state_width = longest(&mut all.iter().map(|(_, progress)| state(progress).len()));
    let lines = all.iter().map(|(path, progress)| {
        let share =
            progress.as_ref().map_or_else(|_| "-".to_owned(), |progress| format!("{:.1} %", progress.percent()));
        format!("{:name_width$}  {:state_width$}  {share:>7}\n", name(path), state(progress))
    });
    result(&lines.collect::<String>())
}

/// The state of a run whose job or pieces cannot be read.
const UNREADABLE: &str = "unreadable";

/// How far a run is.
struct Progress {
    job: Job,
    state: &'static str,
    in_use: bool,
    /// Where the surface lies, if it is written.
    surface: Option<PathBuf>,
    complete_cells: u64,
    samples_done: u128,
    samples_total: u128,
    share: f64,
    undecided: u64,
    failed: u64,
    audited: u64,
    differed: u64,
}

impl Progress {
    fn of(directory: &RunDirectory) -> Result<Self, Failure> {
        let job = directory.job()?;
        let tally = directory.tally(&job)?;
        let parts = Parts::new(&job);
        let in_use = directory.in_use();
        // After a run was extended, its surface does not count until it is written again.
        let surface = directory.has_surface_of(&job).then(|| directory.surface());
        let complete_cells = directory.complete_cells(&job, &tally);
        let state = match (complete_cells == job.cells(), surface.is_some()) {
            _ if in_use => "running",
            (true, true) => "finished",
            (true, false) => "complete, not merged",
            (false, _) => "unfinished",
        };
        let (samples_done, samples_total) = (tally.counted(), job.total_samples());
        // Progress is measured in cells if no samples are drawn or their number is not known in advance.
        let by_cells = job.is_integrated() || job.stops_by_precision();
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
        })
    }

    fn percent(&self) -> f64 {
        100.0 * self.share
    }

    fn json(&self, run: &Path) -> Value {
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
            "surface": self.surface.as_ref().map(|surface| surface.display().to_string()),
            "job_hash": self.job.hash(),
        })
    }

    fn text(&self, run: &Path) -> String {
        let next = match self.state {
            "unfinished" => format!("\ncontinue with `stickslip resume {}`", quoted(run)),
            "complete, not merged" => format!("\nwrite the surface with `stickslip merge {}`", quoted(run)),
            _ => String::new(),
        };
        let mut remarks = match (self.undecided, self.failed) {
            (0, 0) => String::new(),
            (undecided, failed) => format!("; {undecided} samples undecided, {failed} failed"),
        };
        let Self { audited, differed, .. } = self;
        if *differed > 0 {
            remarks +=
                &format!("; {differed} of {audited} audited samples differed: the verdict map is wrong somewhere");
        }
        format!(
            "{}: {}, {:.1} % ({} of {}{} samples, {} of {} cells complete){remarks}{next}\n",
            self.job.name,
            self.state,
            self.percent(),
            self.samples_done,
            if self.job.stops_by_precision() { "at most " } else { "" },
            self.samples_total,
            self.complete_cells,
            self.job.cells()
        )
    }
}
