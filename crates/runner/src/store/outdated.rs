//! Reports and pictures that show an earlier surface than the one that lies beside them.

use std::fs;
use std::path::Path;
use std::time::{Duration, SystemTime};

use crate::output::quoted;
use crate::store::directory::RunDirectory;
use crate::store::layout::SURFACE;

/// How names begin of what `report` and `plot` draw from a surface, and how they end.
const BEGINNINGS: [&str; 4] = ["report.", "surface.", "difference.", "sobol"];
const ENDINGS: [&str; 4] = [".html", ".svg", ".png", ".pdf"];

/// Copies of one directory are not written in the order of the originals.
const LEAST_DELAY: Duration = Duration::from_secs(1);

/// The names of reports and pictures in a run directory that were written before its surface.
pub fn outdated(directory: &RunDirectory) -> Vec<String> {
    let written = |name: &str| -> Option<SystemTime> {
        let about = fs::symlink_metadata(directory.path().join(name)).ok()?;
        about.modified().ok().filter(|_| about.is_file())
    };
    let Some(surface) = written(SURFACE) else { return Vec::new() };
    let names = directory.root().names().unwrap_or_default();
    let is_drawn = |name: &String| {
        BEGINNINGS.iter().any(|part| name.starts_with(part)) && ENDINGS.iter().any(|part| name.ends_with(part))
    };
    let is_older = |name: &String| {
        let age = written(name).and_then(|time| surface.duration_since(time).ok());
        age.is_some_and(|age| age >= LEAST_DELAY)
    };
    let mut names: Vec<String> = names.into_iter().filter_map(|name| name.into_string().ok()).collect();
    names.retain(|name| is_drawn(name) && is_older(name));
    names.sort_unstable();
    names
}

/// Such names in a line with how to make the files again; empty if there are none.
pub fn line(names: &[String], run: &Path) -> String {
    if names.is_empty() {
        return String::new();
    }
    let run = quoted(run);
    let (reports, plots): (Vec<&String>, Vec<&String>) = names.iter().partition(|name| name.starts_with("report."));
    let commands = [(reports, "report"), (plots, "plot")].into_iter().filter(|(names, _)| !names.is_empty());
    let commands: Vec<String> = commands.map(|(_, command)| format!("`stickslip {command} {run}`")).collect();
    let (are, them) = if names.len() == 1 { ("is", "it") } else { ("are", "them") };
    format!("{} {are} older than the surface; make {them} again with {}\n", names.join(", "), commands.join(" and "))
}
