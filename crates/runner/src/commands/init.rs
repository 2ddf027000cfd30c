//! `init`: an example job to start from.

use std::path::Path;

use crate::cli::InitArguments;
use crate::failure::Failure;
use crate::files::publish::publish_first;
use crate::output::{output_file, quoted, result, shown};

/// A job that runs as it is, and shows the keys that it leaves out as comments.
const EXAMPLE: &str = include_str!("example.toml");

/// `stickslip init`.
pub fn init(arguments: &InitArguments) -> Result<(), Failure> {
    let file = &arguments.file;
    if file == Path::new("-") {
        return result(EXAMPLE);
    }
    let (directory, name) = output_file(file)?;
    // The file may hold somebody's job, so it is never replaced.
    if !publish_first(&directory, &name, EXAMPLE.as_bytes())? {
        let message = format!("{} exists already; name another file: stickslip init NAME.toml", file.display());
        return Err(Failure::CannotCreate(message));
    }
    let quoted = quoted(file);
    result(&format!(
        "Wrote {}. Its comments say what it computes and what you can change. Next:\n  \
         stickslip check {quoted}\n  stickslip submit {quoted}\n",
        shown(file)
    ))
}
