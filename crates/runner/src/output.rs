//! Writing to standard output and standard error, without a panic if they are closed.

use std::fmt;
use std::io::{self, IsTerminal as _, Write as _};
use std::mem;
use std::path::{Path, PathBuf};

use indicatif::HumanCount;

use crate::failure::Failure;

/// Writes a result to standard output.
///
/// # Errors
/// Any output error, including a closed pipe and a full disk.
pub fn result(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(|error| Failure::output(&error))
}

/// Text with its lines broken between words, for a terminal of 80 columns.
pub fn wrapped(text: &str) -> String {
    text.lines().flat_map(|line| broken(line, 80)).fold(String::new(), |text, line| text + &line + "\n")
}

/// A line broken between words into lines of at most `width` characters, but for longer words. At least one line.
pub fn broken(line: &str, width: usize) -> Vec<String> {
    let mut done = Vec::new();
    let mut current = String::new();
    for word in line.split(' ') {
        if !current.is_empty() && current.chars().count() + 1 + word.chars().count() > width {
            done.push(mem::take(&mut current));
        } else if !current.is_empty() {
            current.push(' ');
        }
        current += word;
    }
    done.push(current);
    done
}

/// Writes a message to standard error. Errors are ignored, as there is no other place to report them.
pub fn note(text: fmt::Arguments<'_>) {
    let _ = writeln!(io::stderr().lock(), "stickslip: {text}");
}

/// Writes a message to standard error where a progress bar may be.
pub fn note_over_bar(text: fmt::Arguments<'_>) {
    let mut out = io::stderr().lock();
    let over = if out.is_terminal() { "\r\x1b[2K" } else { "" };
    let _ = writeln!(out, "{over}stickslip: {text}");
}

/// Writes warnings to standard error.
pub fn warn(warnings: impl IntoIterator<Item = String>) {
    warnings.into_iter().for_each(|warning| note(format_args!("warning: {warning}")));
}

/// A path quoted for a shell, for commands that a message suggests.
pub fn quoted(path: &Path) -> String {
    let text = path.display().to_string();
    let is_plain = |c: char| c.is_alphanumeric() || "._-/+=:@".contains(c);
    if !text.is_empty() && text.chars().all(is_plain) { text } else { format!("'{}'", text.replace('\'', "'\\''")) }
}

/// The directory and name of the file of `--out`, if it can be written.
pub fn output_file(out: &Path) -> Result<(PathBuf, String), Failure> {
    let directory = match out.parent() {
        Some(parent) if parent != Path::new("") => parent.to_owned(),
        _ => PathBuf::from("."),
    };
    let name = out.file_name().and_then(|name| name.to_str());
    let name = name.ok_or_else(|| Failure::CannotCreate(format!("{} is not the name of a file", out.display())))?;
    // Writing would replace a device, a pipe or a link by a file.
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

/// A number of things, with the noun in singular or plural.
pub fn counted(count: u128, one: &str, many: &str) -> String {
    format!("{} {}", HumanCount128(count), if count == 1 { one } else { many })
}

/// A number of things in a second, with decimals if it is small.
pub fn rate(in_a_second: f64) -> String {
    match in_a_second {
        rate if rate < 1.0 => format!("{rate:.2}"),
        rate if rate < 10.0 => format!("{rate:.1}"),
        rate => HumanCount(rate as u64).to_string(),
    }
}

/// A count, with separators between thousands if it fits 64 bits.
pub struct HumanCount128(pub u128);

impl fmt::Display for HumanCount128 {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match u64::try_from(self.0) {
            Ok(count) => HumanCount(count).fmt(f),
            Err(_) => self.0.fmt(f),
        }
    }
}
