//! Why a file of matrices is refused: file, place, what is wrong, and what would be right.

use std::fmt;
use std::io;
use std::path::Path;

use thiserror::Error;

use crate::shell::{shown, without_controls};

/// Longest piece of a file that a message quotes.
const LONGEST_QUOTE: usize = 40;

/// Most names that a message lists.
const MOST_LISTED: usize = 20;

/// Why a file is refused.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{file}{problem}")]
pub struct MatrixFileError {
    file: String,
    problem: Problem,
}

/// What is wrong with a file, and where in it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    line: Option<u64>,
    text: String,
}

impl Problem {
    pub fn new(text: impl Into<String>) -> Self {
        Self { line: None, text: text.into() }
    }

    /// A problem in a line of a text.
    pub fn at(line: u64, text: impl Into<String>) -> Self {
        Self { line: Some(line), text: text.into() }
    }

    /// A file that cannot be read on.
    pub fn of_reading(error: &io::Error) -> Self {
        Self::new(format!("cannot read the file: {error}"))
    }

    /// The same problem, said of a matrix of this name.
    pub fn of_matrix(mut self, name: &str) -> Self {
        self.text = format!("matrix {}: {}", quoted(name), self.text);
        self
    }

    pub fn in_file(self, path: &Path) -> MatrixFileError {
        MatrixFileError { file: shown(path), problem: self }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(line) = self.line {
            write!(formatter, ":{line}")?;
        }
        write!(formatter, ": {}", self.text)
    }
}

/// A piece of a file for a message: short, and without what cannot be shown.
pub fn quoted(text: &str) -> String {
    let short: String = text.chars().take(LONGEST_QUOTE).collect();
    let dots = if short.len() < text.len() { "..." } else { "" };
    format!("`{}{dots}`", without_controls(&short).replace('\n', "\\n"))
}

/// Names for a message, as many as one reads.
pub fn listed<'a>(names: impl ExactSizeIterator<Item = &'a str>) -> String {
    let count = names.len();
    let mut text = names.take(MOST_LISTED).map(quoted).collect::<Vec<_>>().join(", ");
    if count > MOST_LISTED {
        text += &format!(" and {} more", count - MOST_LISTED);
    }
    text
}
