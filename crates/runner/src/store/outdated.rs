//! Reports and pictures of other results than those beside which they lie.
//!
//! Each says by a hash which results it shows, so that neither clocks matter nor the order in which files are copied.

use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use crate::files::foreign::text_of_key;
use crate::output::quoted;
use crate::store::directory::{JOB_HASH_KEY, RunDirectory};
use crate::store::layout::{LIMITS, SURFACE};

/// How names begin of what `report` and `plot` draw from a surface, and how they end.
const BEGINNINGS: [&str; 4] = ["report.", "surface.", "difference.", "sobol"];
const ENDINGS: [&str; 4] = [".html", ".svg", ".png", ".pdf"];

/// Among how many bytes at their beginning the hash stands.
const HEAD: u64 = 1 << 16;

/// What the limits of a run depend on, beside its job.
const OF_LIMITS: [&str; 2] = ["stickslip:of", "stickslip:targets"];

/// Identifies the results that lie in a run directory: the surface, by its job, and limits beside it. None without a surface.
pub fn results(directory: &RunDirectory) -> Option<String> {
    let open = |name: &str| directory.root().open_file(name).ok();
    let surface = text_of_key(&open(SURFACE)?, JOB_HASH_KEY).filter(|hash| is_hash(hash))?;
    let is_beside = |limits: &File| text_of_key(limits, JOB_HASH_KEY).as_ref() == Some(&surface);
    let Some(limits) = open(LIMITS).filter(is_beside) else { return Some(surface) };
    let limits = OF_LIMITS.map(|key| text_of_key(&limits, key).unwrap_or_default());
    Some(blake3::hash(format!("{surface} {limits:?}").as_bytes()).to_hex().to_string())
}

/// Whether a text that stands in a file, which may be forged, is a hash.
fn is_hash(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_hexdigit())
}

/// The names of reports and pictures in a run directory that show other results than those that lie there.
pub fn outdated(directory: &RunDirectory) -> Vec<String> {
    let is_drawn = |name: &String| {
        BEGINNINGS.iter().any(|part| name.starts_with(part)) && ENDINGS.iter().any(|part| name.ends_with(part))
    };
    let names = directory.root().names().unwrap_or_default().into_iter();
    let mut names: Vec<String> = names.filter_map(|name| name.into_string().ok()).filter(is_drawn).collect();
    if names.is_empty() {
        return names;
    }
    let Some(results) = results(directory) else { return Vec::new() };
    let shows_others = |name: &String| {
        let is_it = |part: &[u8]| part == results.as_bytes();
        head(directory, name).is_some_and(|head| !head.windows(results.len()).any(is_it))
    };
    names.retain(shows_others);
    names.sort_unstable();
    names
}

/// The beginning of a file, if it can be read.
fn head(directory: &RunDirectory, name: &str) -> Option<Vec<u8>> {
    let mut head = Vec::new();
    directory.root().open_file(name).ok()?.take(HEAD).read_to_end(&mut head).ok()?;
    Some(head)
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
    format!(
        "{} {are} outdated, as the results have changed since; make {them} again with {}\n",
        names.join(", "),
        commands.join(" and ")
    )
}
