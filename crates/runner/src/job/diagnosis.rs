//! What is wrong with a job spec, with file, line, key and what would be right.

use std::ops::Range;
use std::path::Path;

use super::keys::nearest;
use crate::messages;
use crate::shell::shown;

/// Largest number of complaints that are shown. What follows from a slip at the top has no end otherwise.
pub const MOST_SHOWN: usize = 50;

/// Longest message, in characters. A value of a job may have millions.
const LONGEST_MESSAGE: usize = 2000;

/// Characters of a line that are shown, and how many of them before the place that is marked.
const SHOWN_WIDTH: usize = 160;
const SHOWN_BEFORE: usize = 60;

/// A complaint about a place in the spec's text.
#[derive(Debug)]
pub struct Complaint {
    /// Where in the text, if it can be said.
    span: Option<Range<usize>>,
    /// What is wrong and what would be right.
    pub(super) message: String,
    /// A second place that the message is about.
    other: Option<Range<usize>>,
    /// The key that is missing, if that is what is wrong.
    missing: Option<&'static str>,
}

impl Complaint {
    /// A complaint about the text at `span`.
    pub fn at(span: Range<usize>, message: impl Into<String>) -> Self {
        Self::maybe_at(Some(span), message)
    }

    /// A complaint about the text at `span`, or about the whole.
    pub fn maybe_at(span: Option<Range<usize>>, message: impl Into<String>) -> Self {
        Self { span, message: message.into(), other: None, missing: None }
    }

    /// A complaint that `key` is missing, about the table at `span`.
    pub fn missing(key: &'static str, span: Option<Range<usize>>, message: impl Into<String>) -> Self {
        Self { missing: Some(key), ..Self::maybe_at(span, message) }
    }

    /// The same with a second place that it is about.
    pub fn and_at(self, span: Range<usize>) -> Self {
        Self { other: Some(span), ..self }
    }

    /// Where it is in the text; at the end if that cannot be said.
    fn start(&self) -> usize {
        self.span.as_ref().map_or(usize::MAX, |span| span.start)
    }

    /// The full message: position, words, and the line itself with the place marked.
    fn render(&self, path: &Path, text: &str) -> String {
        let path = shown(path);
        let message = match self.message.char_indices().nth(LONGEST_MESSAGE) {
            Some((end, _)) => format!("{} ...", &self.message[..end]),
            None => self.message.clone(),
        };
        let Some(place) = self.span.clone().and_then(|span| Place::locate(span, text)) else {
            return format!("{path}: {message}");
        };
        let mut rendered = format!("{path}:{}:{}: {message}{}", place.line, place.column + 1, place.excerpt());
        if let Some(other) = self.other.clone().and_then(|span| Place::locate(span, text)) {
            rendered += &format!("\n{path}:{}:{}: and here{}", other.line, other.column + 1, other.excerpt());
        }
        rendered
    }
}

/// A place in a text, for people.
struct Place<'a> {
    line: usize,
    /// Characters before it in its line.
    column: usize,
    /// Characters of it.
    width: usize,
    text: &'a str,
}

impl<'a> Place<'a> {
    /// The place of a span, if it lies in the text.
    fn locate(span: Range<usize>, text: &'a str) -> Option<Self> {
        if span.start > text.len() {
            return None;
        }
        let before = &text[..floor_char_boundary(text, span.start)];
        let start = before.rfind('\n').map_or(0, |newline| newline + 1);
        let line = text[start..].lines().next().unwrap_or("");
        let end = floor_char_boundary(text, span.end.min(start + line.len()).max(before.len()));
        Some(Self {
            line: before.matches('\n').count() + 1,
            column: before[start..].chars().count(),
            width: text[before.len()..end].chars().count().max(1),
            text: line,
        })
    }

    /// The line with the place marked, on lines of its own. Of a long line, the part around the place.
    fn excerpt(&self) -> String {
        let gutter = self.line.to_string();
        let margin = " ".repeat(gutter.len());
        let is_long = self.text.chars().nth(SHOWN_WIDTH).is_some();
        let left_out = if is_long { self.column.saturating_sub(SHOWN_BEFORE) } else { 0 };
        let mut line: String = self.text.chars().skip(left_out).take(SHOWN_WIDTH).collect();
        if left_out > 0 {
            line.insert_str(0, "... ");
        }
        if self.text.chars().nth(left_out + SHOWN_WIDTH).is_some() {
            line += " ...";
        }
        let column = self.column - left_out + if left_out > 0 { 4 } else { 0 };
        let (gap, mark) = (" ".repeat(column), "^".repeat(self.width.min(SHOWN_WIDTH)));
        format!("\n  {margin} |\n  {gutter} | {line}\n  {margin} | {gap}{mark}")
    }
}

fn floor_char_boundary(text: &str, mut index: usize) -> usize {
    index = index.min(text.len());
    while !text.is_char_boundary(index) {
        index -= 1;
    }
    index
}

/// Everything that is wrong with a job spec.
#[derive(Debug, Default)]
pub struct Complaints {
    list: Vec<Complaint>,
    /// Paths of the keys that could not be read. A complaint that one of them is missing would mislead.
    unread: Vec<Vec<String>>,
}

impl Complaints {
    /// Adds a complaint, unless it says that a key is missing which is there but could not be read.
    pub fn push(&mut self, complaint: Complaint) {
        let is_unread = |key: &str| {
            let names = self.unread.iter().filter_map(|path| path.last()).map(String::as_str);
            nearest(key, names).is_some()
        };
        if !complaint.missing.is_some_and(is_unread) {
            self.list.push(complaint);
        }
    }

    /// Adds the complaint of a check, if it has one.
    pub fn push_some(&mut self, complaint: Option<Complaint>) {
        complaint.into_iter().for_each(|complaint| self.push(complaint));
    }

    /// Adds the complaint of a check, or gives its result.
    pub fn take<T>(&mut self, checked: Result<T, Complaint>) -> Option<T> {
        checked.map_err(|complaint| self.push(complaint)).ok()
    }

    /// Notes that the entry at this path could not be read.
    pub fn note_unread(&mut self, path: Vec<String>) {
        self.unread.push(path);
    }

    /// Whether an entry at this path or below it could not be read.
    pub fn has_unread(&self, path: &[&str]) -> bool {
        self.unread.iter().any(|unread| unread.len() >= path.len() && path.iter().zip(unread).all(|(a, b)| a == b))
    }

    /// Whether this is a parameter of the model that could not be read, of which nothing else is to be said.
    pub fn has_unread_parameter(&self, name: &str) -> bool {
        self.has_unread(&["model", "parameters", name])
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Where the first of them is, in the order of the text. `key_at` finds the key of a span.
    pub fn place(&self, path: &Path, text: &str, key_at: impl Fn(&Range<usize>) -> Option<String>) -> messages::Place {
        let file = messages::Place::file(path);
        let Some(first) = self.list.iter().min_by_key(|complaint| complaint.start()) else { return file };
        let at = first.span.clone().and_then(|span| Place::locate(span, text));
        let keys = [first.span.as_ref().and_then(key_at), first.missing.map(str::to_owned)];
        let keys: Vec<String> = keys.into_iter().flatten().collect();
        messages::Place {
            line: at.as_ref().map(|at| at.line as u64),
            column: at.as_ref().map(|at| at.column as u64 + 1),
            key: Some(keys.join(".")).filter(|key| !key.is_empty()),
            ..file
        }
    }

    /// All of them, in the order of the text.
    pub fn render(mut self, path: &Path, text: &str) -> String {
        self.list.sort_by_key(Complaint::start);
        let first = self.list.iter().take(MOST_SHOWN);
        let mut rendered: Vec<String> = first.map(|complaint| complaint.render(path, text)).collect();
        if self.list.len() > MOST_SHOWN {
            rendered.push(format!("... and {} more", self.list.len() - MOST_SHOWN));
        }
        rendered.join("\n")
    }
}
