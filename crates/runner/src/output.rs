//! Writing to standard output and standard error without a panic when nobody reads.

use std::fmt;
use std::io::{self, Write as _};
use std::path::Path;

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

/// A path as a shell takes it back, for commands that a message suggests.
pub fn quoted(path: &Path) -> String {
    let text = path.display().to_string();
    let is_plain = |c: char| c.is_alphanumeric() || "._-/+=:@".contains(c);
    if !text.is_empty() && text.chars().all(is_plain) { text } else { format!("'{}'", text.replace('\'', "'\\''")) }
}
