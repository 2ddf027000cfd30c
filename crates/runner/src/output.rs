//! Writing to standard output and standard error without a panic when nobody reads.

use std::fmt;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use indicatif::HumanCount;

use crate::failure::Failure;

/// Writes a result to standard output.
///
/// # Errors
/// A closed pipe or a full disk, as any other output error: the command says so and exits with its code.
pub fn result(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(|error| Failure::output(&error))
}

/// Says something on standard error. If that is closed, nobody wants to hear it.
pub fn note(text: fmt::Arguments<'_>) {
    let _ = writeln!(io::stderr().lock(), "stickslip: {text}");
}

/// Says warnings on standard error.
pub fn warn(warnings: impl IntoIterator<Item = String>) {
    warnings.into_iter().for_each(|warning| note(format_args!("warning: {warning}")));
}

/// A path as a shell takes it back, for commands that a message suggests.
pub fn quoted(path: &Path) -> String {
    let text = path.display().to_string();
    let is_plain = |c: char| c.is_alphanumeric() || "._-/+=:@".contains(c);
    if !text.is_empty() && text.chars().all(is_plain) { text } else { format!("'{}'", text.replace('\'', "'\\''")) }
}

/// Directory and name of a file that a user asks for with --out, if it can be written.
pub fn output_file(out: &Path) -> Result<(PathBuf, String), Failure> {
    let directory = match out.parent() {
        Some(parent) if parent != Path::new("") => parent.to_owned(),
        _ => PathBuf::from("."),
    };
    let name = out.file_name().and_then(|name| name.to_str());
    let name = name.ok_or_else(|| Failure::CannotCreate(format!("{} does not name a file", out.display())))?;
    // A device, a pipe or a link would be replaced by the file.
    if out.symlink_metadata().is_ok_and(|there| !there.is_file() && !there.is_dir()) {
        return Err(Failure::CannotCreate(format!("{} is not an ordinary file; name one", out.display())));
    }
    if out.is_dir() {
        return Err(Failure::CannotCreate(format!("{} is a directory; name a file in it", out.display())));
    }
    if !directory.is_dir() {
        let message = format!("cannot create {}: there is no directory {}", out.display(), directory.display());
        return Err(Failure::CannotCreate(message));
    }
    Ok((directory, name.to_owned()))
}

/// A number of things, in words.
pub fn counted(count: u128, one: &str, many: &str) -> String {
    format!("{} {}", HumanCount128(count), if count == 1 { one } else { many })
}

/// A count of any size with separators.
pub struct HumanCount128(pub u128);

impl fmt::Display for HumanCount128 {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match u64::try_from(self.0) {
            Ok(count) => HumanCount(count).fmt(f),
            Err(_) => self.0.fmt(f),
        }
    }
}
