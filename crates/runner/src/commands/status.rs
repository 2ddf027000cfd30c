//! `status`: the progress of a run, or of every run in a folder.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::run_progress::RunProgress;
use super::sharing::require_samples_to_share;
use super::watch::watch;
use crate::cli::{ListFormat, StatusArguments};
use crate::cluster::task_list::ranges;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::output::{result, shown, warn};
use crate::store::directory::RunDirectory;
use crate::store::layout::runs_in;
use crate::store::sharing::Sharing;

/// `stickslip status`.
pub fn status(arguments: &StatusArguments, interrupt: &Interrupt) -> Result<(), Failure> {
    let path = &arguments.run;
    let directory = match RunDirectory::view(path) {
        Ok(directory) => directory,
        Err(failure) => {
            return match runs_in(path)?.as_slice() {
                [] => Err(failure),
                runs => match of_one_run(arguments) {
                    Some(option) => Err(Failure::Usage(format!(
                        "{option} is for one run, and {} holds several; name one of them",
                        path.display()
                    ))),
                    None => status_of_all(runs, arguments.json),
                },
            };
        }
    };
    let known = Sharing::read(directory.path()).map(|sharing| sharing.shards);
    if arguments.watch {
        // Without being asked, no more bars than a terminal has lines.
        let shards = arguments.shards.or(known.filter(|&shards| shards <= MOST_BARS));
        return watch(&directory, path, shards, interrupt);
    }
    let progress = RunProgress::of_shards(&directory, directory.job()?, arguments.shards.or(known))?;
    if arguments.missing {
        return missing(&progress, arguments.format, path);
    }
    result(&if arguments.json { format!("{:#}\n", progress.json(path)) } else { progress.text(path) })
}

/// An option that is given and says something of one run.
fn of_one_run(arguments: &StatusArguments) -> Option<&'static str> {
    let options =
        [("--watch", arguments.watch), ("--missing", arguments.missing), ("--shards", arguments.shards.is_some())];
    options.into_iter().find(|(_, is_given)| *is_given).map(|(option, _)| option)
}

/// Lists the shards that are neither done nor at work.
fn missing(progress: &RunProgress, format: ListFormat, path: &Path) -> Result<(), Failure> {
    let Some(shards) = &progress.shards else {
        require_samples_to_share(&progress.job, "--missing")?;
        return Err(Failure::Usage(format!(
            "--missing: in how many shards {} is computed is not known; give it with --shards N",
            path.display()
        )));
    };
    result(&match format {
        ListFormat::Slurm => ranges(&shards.missing()) + "\n",
        ListFormat::Lines => shards.missing().iter().map(|number| format!("{number}\n")).collect(),
    })
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
        format!("{:name_width$}  {:state_width$}  {share:>7}\n", name(path), state(progress))
    });
    result(&lines.collect::<String>())
}

/// Largest number of shards that are shown with a bar each where their number is not given.
const MOST_BARS: u64 = 16;

/// The state of a run whose job or pieces cannot be read.
const UNREADABLE: &str = "unreadable";
