//! The names in a run directory, and by which of them a directory is recognised as one.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};

use crate::failure::Failure;
use crate::files::folder::Folder;
use crate::files::publish::{files, is_temporary};
use crate::messages::{Code, Place};
use crate::output::quoted;
use crate::store::digests::DIGESTS;
use crate::store::lock::{LOCK, in_use, is_held};

/// The names of the frozen job, of the result, of the limits found from it, of the record of sessions, and of the directories of pieces, tiles,
/// audits, searches for rare events, and searches for limits.
pub const JOB: &str = "job.toml";
pub const SURFACE: &str = "surface.parquet";
pub const LIMITS: &str = "limits.parquet";
pub const RECORD: &str = "run.json";
pub const SHARDS: &str = "shards";
pub const MAPS: &str = "map";
pub const AUDITS: &str = "audit";
pub const SEARCHES: &str = "searches";
pub const LIMIT_SEARCHES: &str = "limits";

/// The files that have digests.
pub const WITH_DIGESTS: [&str; 4] = [JOB, SURFACE, LIMITS, RECORD];

/// Whether a file of a run directory has a name that only this program gives: of the run itself, or of what is drawn and
/// written of its result where no other name is asked for.
pub fn is_of_run(name: &OsStr) -> bool {
    const DRAWN: [&str; 6] = ["surface", "difference", "verdicts", "sobol", "modes", "squeal-frequencies"];
    let Some(name) = name.to_str() else { return false };
    let (stem, extension) = name.rsplit_once('.').unwrap_or((name, ""));
    match extension {
        _ if WITH_DIGESTS.contains(&name) || [DIGESTS, "report.html"].contains(&name) => true,
        "svg" | "pdf" | "png" => DRAWN.contains(&stem) || stem.starts_with("sobol-"),
        "csv" | "json" | "mat" | "npz" => stem == "surface",
        "parquet" => stem.strip_prefix("samples-").is_some_and(|cell| cell.bytes().all(|c| c.is_ascii_digit())),
        "damaged" => is_of_run(OsStr::new(stem)),
        _ => false,
    }
}

/// The runs that lie in the folder `path`, sorted by name; none if it is no folder.
pub fn runs_in(path: &Path) -> Result<Vec<PathBuf>, Failure> {
    if !path.is_dir() {
        return Ok(Vec::new());
    }
    // A run that lost its job is one, too.
    let is_run = |entry: &PathBuf| {
        entry.join(SHARDS).is_dir() && [JOB, SURFACE].iter().any(|name| entry.join(name).symlink_metadata().is_ok())
    };
    Ok(files(path)?.into_iter().filter(is_run).collect())
}

/// An error if a directory is not that of a run, with what is missing.
pub fn require_run(path: &Path) -> Result<(), Failure> {
    let has_job = path.join(JOB).symlink_metadata().is_ok();
    let has_shards = path.join(SHARDS).is_dir();
    let verify = format!("stickslip verify {}", quoted(path));
    let out = format!("--out {}", quoted(path));
    let (why, remedy) = if !path.exists() {
        ("it does not exist".to_owned(), None)
    } else if !path.is_dir() {
        ("it is a file".to_owned(), None)
    } else if has_job && has_shards {
        return Ok(());
    } else if let Some(busy) = Folder::open(path).ok().filter(is_held).map(|run| in_use(&run, "is being made")) {
        // What is missing may be there by now.
        let is_made = path.join(JOB).symlink_metadata().is_ok() && path.join(SHARDS).is_dir();
        return if is_made { Ok(()) } else { Err(busy) };
    } else if has_shards && path.join(SURFACE).is_file() {
        (format!("its job.toml is lost; `{verify}` writes it again from the surface"), Some(verify))
    } else if has_shards {
        (format!("its job.toml is lost; submit the job again with `{out}`, its pieces are kept"), Some(out))
    } else if path.join(SHARDS).symlink_metadata().is_ok() {
        ("its shards is not a directory of its own; move it elsewhere".to_owned(), None)
    } else if has_job && path.join(DIGESTS).is_file() {
        (format!("its shards/ is lost; `{verify}` makes an empty one"), Some(verify))
    } else if has_job {
        (format!("it has no shards/; to compute the job there, submit it with `{out}`"), Some(out))
    } else {
        ("it has neither job.toml nor shards/".to_owned(), None)
    };
    let text = format!("{} is not a run directory: {why}", path.display());
    let failure = Failure::InputOutput(text).coded(Code::NoRun).at(Place::file(path));
    Err(match remedy {
        Some(remedy) => failure.remedied(remedy),
        None => failure,
    })
}

/// An error if a directory holds nothing that a run leaves. A job alone may be that of the user, who has not submitted
/// it there.
pub fn require_traces(path: &Path) -> Result<(), Failure> {
    if [SHARDS, DIGESTS].iter().any(|name| path.join(name).symlink_metadata().is_ok()) {
        return Ok(());
    }
    let why = format!("{} is not a run directory: there is neither {SHARDS}/ nor {DIGESTS} in it", path.display());
    let failure = |text: String| Failure::InputOutput(text).coded(Code::NoRun).at(Place::file(path));
    if path.join(JOB).symlink_metadata().is_err() {
        return Err(failure(why));
    }
    let out = format!("--out {}", quoted(path));
    Err(failure(format!("{why}; to compute the job there, submit it with `{out}`")).remedied(out))
}

/// An error if there is something else than a run under a path.
pub fn require_free(path: &Path) -> Result<(), Failure> {
    let why = if !path.exists() {
        return Ok(());
    } else if !path.is_dir() {
        "is a file; a run needs a directory"
    } else if path.join(JOB).exists() || has_lost_its_job(path) || looks_empty(path)? {
        return Ok(());
    } else {
        "is not empty and not a run directory"
    };
    let text = format!("{} {why}. Choose another with --out", path.display());
    Err(Failure::CannotCreate(text).at(Place::file(path)).remedied("--out"))
}

/// Whether a directory without a job was that of a run. Whether its pieces belong to another job is found where they are
/// read.
fn has_lost_its_job(path: &Path) -> bool {
    path.join(SHARDS).is_dir() && [DIGESTS, SURFACE].iter().any(|name| path.join(name).is_file())
}

fn looks_empty(path: &Path) -> Result<bool, Failure> {
    let entries = fs::read_dir(path).map_err(|error| Failure::reading(path, error))?;
    for entry in entries {
        let entry = entry.map_err(|error| Failure::reading(path, error))?;
        // A `submit` that was killed at its start leaves its lock, digests, shards/ and unfinished files. Another shard
        // may just have written job.toml.
        let name = entry.file_name();
        if ![JOB, SHARDS, LOCK, DIGESTS].iter().any(|own| name == *own) && !is_temporary(&entry.path()) {
            return Ok(false);
        }
    }
    Ok(true)
}
