//! `status`: the progress of a run, or of every run in a folder.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::run_progress::RunProgress;
use crate::cli::StatusArguments;
use crate::failure::Failure;
use crate::output::{result, shown, warn};
use crate::store::directory::RunDirectory;
use crate::store::layout::runs_in;

/// `stickslip status`.
pub fn status(arguments: &StatusArguments) -> Result<(), Failure> {
    let path = &arguments.run;
    let directory = match RunDirectory::view(path) {
        Ok(directory) => directory,
        Err(failure) => {
            return match runs_in(path)?.as_slice() {
                [] => Err(failure),
                runs => status_of_all(runs, arguments.json),
            };
        }
    };
    let progress = RunProgress::read(&directory)?;
    result(&if arguments.json { format!("{:#}\n", progress.json(path)) } else { progress.text(path) })
}

/// One line for each run of a folder. A run that cannot be read does not hide the others.
fn status_of_all(runs: &[PathBuf], as_json: bool) -> Result<(), Failure> {
    let all: Vec<(&PathBuf, Result<RunProgress, Failure>)> =
        runs.iter().map(|run| (run, RunDirectory::view(run).and_then(|run| RunProgress::read(&run)))).collect();
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
    let name = |path: &Path| path.file_name().map_or_else(String::new, |name| shown(Path::new(name)));
    let state =
        |progress: &Result<RunProgress, Failure>| progress.as_ref().map_or(UNREADABLE, |progress| progress.state);
    let longest = |lengths: &mut dyn Iterator<Item = usize>| lengths.max().unwrap_or(0);
    let name_width = longest(&mut all.iter().map(|(path, _)| name(path).chars().count()));
    let state_width = longest(&mut all.iter().map(|(_, progress)| state(progress).len()));
    let lines = all.iter().map(|(path, progress)| {
        let share =
            progress.as_ref().map_or_else(|_| "-".to_owned(), |progress| format!("{:.1} %", progress.percent()));
        let outdated = progress.as_ref().map_or(&[][..], |progress| &progress.outdated);
        let remark = if outdated.is_empty() { String::new() } else { format!("  outdated: {}", outdated.join(", ")) };
        format!("{:name_width$}  {:state_width$}  {share:>7}{remark}\n", name(path), state(progress))
    });
    result(&lines.collect::<String>())
}

/// The state of a run whose job or pieces cannot be read.
const UNREADABLE: &str = "unreadable";
