//! `init`: an example job to start from, or one of those that come with the program.

use std::fs;
use std::path::{Path, PathBuf};

use super::shipped_jobs::ShippedJob;
use crate::cli::InitArguments;
use crate::failure::Failure;
use crate::files::publish::publish_first;
use crate::output::{note, output_file, quoted, result, shown};

/// A job that runs as it is, and shows the keys that it leaves out as comments.
const EXAMPLE: &str = include_str!("example.toml");

/// `stickslip init`.
pub fn init(arguments: &InitArguments) -> Result<(), Failure> {
    let named = |name: &String| ShippedJob::named(name).map_err(|why| Failure::Usage(format!("--from: {why}")));
    let shipped = arguments.from.as_ref().map(named).transpose()?;
    let (default, text) = shipped.map_or(("job.toml".into(), EXAMPLE), |job| (format!("{}.toml", job.name), job.text));
    let file = arguments.file.clone().unwrap_or_else(|| default.into());
    let files = shipped.map_or(&[][..], |job| job.files);
    if file == Path::new("-") {
        for (path, _) in files {
            note(format_args!("the job names the file {path}, which `stickslip init --from` writes beside a FILE"));
        }
        return result(text);
    }
    let (directory, name) = output_file(&file)?;
    let files: Vec<(PathBuf, &[u8])> = files.iter().map(|(path, bytes)| (directory.join(path), *bytes)).collect();
    // What is there may be somebody's own.
    for (path, bytes) in &files {
        if path.symlink_metadata().is_ok() && !fs::read(path).is_ok_and(|there| there == *bytes) {
            let message = format!("{} exists already and is another file; choose another folder", shown(path));
            return Err(Failure::CannotCreate(message));
        }
    }
    if !publish_first(&directory, &name, text.as_bytes())? {
        let option = arguments.from.as_ref().map_or(String::new(), |from| format!("--from {from} "));
        let message = format!("{} exists already; name another file: stickslip init {option}NAME.toml", file.display());
        return Err(Failure::CannotCreate(message));
    }
    for (path, bytes) in &files {
        let (folder, name) = (path.parent().unwrap_or(&directory), path.file_name().unwrap_or_default());
        fs::create_dir_all(folder).map_err(|error| Failure::creating(folder, error))?;
        publish_first(folder, &name.to_string_lossy(), bytes)?;
    }
    let written: String =
        files.iter().map(|(path, _)| format!(" and {}", shown(path.strip_prefix(".").unwrap_or(path)))).collect();
    let quoted = quoted(&file);
    let comments = " Its comments say what it computes and what you can change.";
    let comments = if shipped.is_none() { comments } else { "" };
    result(&format!(
        "Wrote {}{written}.{comments} Next:\n  stickslip check {quoted}\n  stickslip submit {quoted}\n",
        shown(&file)
    ))
}
