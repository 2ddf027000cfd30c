//! What is wrong with a job spec, said with file, line, key and what would be right.

use std::ops::Range;
use std::path::Path;

/// A complaint about a piece of the spec's text.
#[derive(Debug)]
pub struct Complaint {
    /// Where in the text, if it can be said.
    pub span: Option<Range<usize>>,
    /// What is wrong and what would be right.
    pub message: String,
}

impl Complaint {
    /// A complaint about the text at `span`.
    pub fn at(span: Range<usize>, message: impl Into<String>) -> Self {
        Self { span: Some(span), message: message.into() }
    }

    /// From the TOML parser, in words for people who do not know Rust, with a suggestion for a misspelt name.
    pub fn from_parser(error: &toml::de::Error) -> Self {
        let mut message = plain_words(error.message());
        if let Some((wrong, candidates)) = unknown_name(error.message())
            && let Some(right) = nearest(wrong, candidates.iter().copied())
        {
            message = format!("{message}; did you mean `{right}`?");
        }
        Self { span: error.span(), message }
    }

    /// The full message: position, words, and the line itself with the place marked.
    pub fn render(&self, path: &Path, text: &str) -> String {
        let Some(span) = self.span.clone().filter(|span| span.start <= text.len()) else {
            return format!("{}: {}", path.display(), self.message);
        };
        let before = &text[..floor_char_boundary(text, span.start)];
        let line_number = before.matches('\n').count() + 1;
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        let line = text[line_start..].lines().next().unwrap_or("");
        let column = before[line_start..].chars().count();
        let end = floor_char_boundary(text, span.end.min(line_start + line.len()).max(before.len()));
        let width = text[before.len()..end].chars().count().max(1);
        let gutter = line_number.to_string();
        let margin = " ".repeat(gutter.len());
        format!(
            "{}:{line_number}:{}: {}\n  {margin} |\n  {gutter} | {line}\n  {margin} | {}{}",
            path.display(),
            column + 1,
            self.message,
            " ".repeat(column),
            "^".repeat(width),
        )
    }
}

fn floor_char_boundary(text: &str, mut index: usize) -> usize {
    index = index.min(text.len());
    while !text.is_char_boundary(index) {
        index -= 1;
    }
    index
}

/// Serde names Rust types in its messages.
fn plain_words(message: &str) -> String {
    message
        .replace("expected f64", "expected a number")
        .replace("expected u64", "expected a whole number, for example 10_000")
        .replace("expected u32", "expected a whole number, for example 30")
        .replace("expected usize", "expected a whole number, for example 5")
        .replace("expected struct IndexSpec", "expected a table, for example { amplitude = 0.002 }")
        .replace("expected a sequence", "expected a list")
        .replace("unknown field", "unknown key")
        .replace("missing field", "missing key")
        .replace("unknown variant", "unknown value")
        .replace("invalid type: map", "invalid type: table")
}

/// The offending name and the admissible ones, from serde's "unknown field `x`, expected one of `a`, `b`".
fn unknown_name(message: &str) -> Option<(&str, Vec<&str>)> {
    if !message.starts_with("unknown field") && !message.starts_with("unknown variant") {
        return None;
    }
    let mut names = message.split('`').skip(1).step_by(2);
    let wrong = names.next()?;
    Some((wrong, names.collect()))
}

/// The candidate that `wrong` is most likely a misspelling of, if any is near enough.
pub fn nearest<'a>(wrong: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let scored = candidates.into_iter().map(|candidate| (strsim::jaro_winkler(wrong, candidate), candidate));
    scored.filter(|(score, _)| *score >= 0.8).max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, candidate)| candidate)
}
