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
    let mut commands: Vec<String> = Vec::new();
    for name in names {
        let command = format!("`{}`", renewal(name, run));
        if !commands.contains(&command) {
            commands.push(command);
        }
    }
    let commands = match &commands[..] {
        [first @ .., last] if !first.is_empty() => format!("{} and {last}", first.join(", ")),
        all => all.concat(),
    };
    let (are, them) = if names.len() == 1 { ("is", "it") } else { ("are", "them") };
    format!(
        "{} {are} outdated, as the results have changed since; make {them} again, for example with {commands}\n",
        names.join(", ")
    )
}

/// A command that makes such a file again, with options of which its name tells.
pub fn renewal(name: &str, run: &Path) -> String {
    let file = quoted(&run.join(name));
    let run = quoted(run);
    // What it shows stands before the first dot; what people add to a name stands behind it.
    let (kind, rest) = name.split_once('.').unwrap_or((name, ""));
    let command = match kind {
        "report" => format!("stickslip report {run}"),
        "difference" => format!("stickslip plot {run} --against RUN_DIR"),
        "sobol" => format!("stickslip plot {run} --of sobol"),
        _ => match kind.strip_prefix("sobol-") {
            Some(result) => format!("stickslip plot {run} --of sobol --result {}", quoted(Path::new(result))),
            None => format!("stickslip plot {run}"),
        },
    };
    // Without a name, plots are written as these two.
    let is_default = match kind {
        "report" => rest == "html",
        "surface" | "difference" | "sobol" => matches!(rest, "svg" | "png"),
        _ => kind.starts_with("sobol-") && matches!(rest, "svg" | "png"),
    };
    if is_default { command } else { format!("{command} --out {file}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_file_has_the_command_that_makes_it_again() {
        for (name, command) in [
            ("report.html", "stickslip report runs/a"),
            ("report.new.html", "stickslip report runs/a --out runs/a/report.new.html"),
            ("surface.svg", "stickslip plot runs/a"),
            ("surface.pdf", "stickslip plot runs/a --out runs/a/surface.pdf"),
            ("surface.paper.svg", "stickslip plot runs/a --out runs/a/surface.paper.svg"),
            ("sobol.paper.svg", "stickslip plot runs/a --of sobol --out runs/a/sobol.paper.svg"),
            (
                "sobol-amplitude.paper.svg",
                "stickslip plot runs/a --of sobol --result amplitude --out runs/a/sobol-amplitude.paper.svg",
            ),
            ("difference.paper.svg", "stickslip plot runs/a --against RUN_DIR --out runs/a/difference.paper.svg"),
            ("sobol.png", "stickslip plot runs/a --of sobol"),
            (
                "sobol-amplitude.pdf",
                "stickslip plot runs/a --of sobol --result amplitude --out runs/a/sobol-amplitude.pdf",
            ),
            ("difference.svg", "stickslip plot runs/a --against RUN_DIR"),
        ] {
            assert_eq!(renewal(name, Path::new("runs/a")), command);
        }
        let names = ["surface.png", "surface.svg"].map(str::to_owned);
        assert_eq!(
            line(&names, Path::new("runs/a")),
            "surface.png, surface.svg are outdated, as the results have changed since; make them again, for example with `stickslip plot runs/a`\n"
        );
    }
}
