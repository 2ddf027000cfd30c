//! From the text of a job spec to what it says, with a complaint about every entry that cannot be read.

use std::ops::Range;

use serde::Deserialize as _;
use toml::Spanned;
use toml::de::{DeTable, DeValue, Deserializer, Error};

use super::diagnosis::{Complaint, Complaints};
use super::keys::suggestion;
use super::spec::JobSpec;

/// Reads a job spec. An entry that cannot be read is complained about and left out, so that the others are read too;
/// `None` if nothing can be read.
pub fn read(text: &str, complaints: &mut Complaints) -> Option<JobSpec> {
    let (mut document, errors) = DeTable::parse_recoverable(text);
    if !errors.is_empty() {
        errors_of_syntax(text, &errors).into_iter().for_each(|complaint| complaints.push(complaint));
        return None;
    }
    loop {
        let error = match JobSpec::deserialize(Deserializer::from(document.clone())) {
            Ok(spec) => return Some(spec),
            Err(error) => error,
        };
        let Some(mut path) = error.span().and_then(|span| path_at(document.get_ref(), &span)) else {
            complaints.push(Complaint::maybe_at(error.span(), error.message()));
            return None;
        };
        let mut choices = choices_at(&document, &path);
        // A table in place of one of a few names: the fault is not within it.
        if let [outer @ .., _] = &path[..]
            && let of_outer @ [_, ..] = &choices_at(&document, outer)[..]
        {
            (choices, path) = (of_outer.to_vec(), outer.to_vec());
        }
        let keys: Vec<&str> = path.iter().map(String::as_str).collect();
        // What is said of a table from which an entry was taken may follow from that.
        if !complaints.has_unread(&keys) {
            let value = value_at(document.get_ref(), &path);
            // A wrong name is quoted in the error.
            let value = value.filter(|value| !choices.is_empty() && !value.get_ref().is_str());
            complaints.push(match value.map(Spanned::span) {
                Some(span) => {
                    let message = not_a_choice(&keys.join("."), text.get(span.clone()).unwrap_or_default(), &choices);
                    Complaint::at(span, message)
                }
                None => Complaint::maybe_at(error.span(), in_words(text, &path, &error)),
            });
        }
        change(document.get_mut(), &path, None);
        complaints.note_unread(path);
    }
}

/// What is wrong with the lines that are no TOML.
fn errors_of_syntax(text: &str, errors: &[Error]) -> Vec<Complaint> {
    let mut complaints = Vec::new();
    let mut last = None;
    for error in errors {
        let start = error.span().map_or(0, |span| span.start.min(text.len()));
        let newline = text.as_bytes()[..start].iter().rposition(|&byte| byte == b'\n');
        let line_start = newline.map_or(0, |newline| newline + 1);
        // Further errors of a line mostly follow from the first.
        if last.replace(line_start) == Some(line_start) {
            continue;
        }
        let line = text.get(line_start..).and_then(|rest| rest.lines().next()).unwrap_or("");
        let commas = decimal_commas(line);
        for place in &commas {
            let number = &line[place.clone()];
            let message = format!("{number} has a decimal comma; write {}", number.replacen(',', ".", 1));
            complaints.push(Complaint::at(line_start + place.start..line_start + place.end, message));
        }
        if commas.is_empty() {
            complaints.push(Complaint::maybe_at(error.span(), syntax_in_words(text, start, error)));
        }
    }
    complaints
}

/// What is wrong with a line that is no TOML.
fn syntax_in_words(text: &str, start: usize, error: &Error) -> String {
    let is_part = |c: char| c.is_alphanumeric() || "-_.".contains(c);
    let rest = text.get(start..).unwrap_or_default();
    let word = &rest[..rest.find(|c| !is_part(c)).unwrap_or(rest.len())];
    let is_value = text.get(..start).is_some_and(|before| before.trim_end_matches([' ', '\t']).ends_with('='));
    if is_value && word.starts_with(char::is_alphabetic) {
        return format!("{word} is no value: a text is written in quotes, \"{word}\"");
    }
    error.message().to_owned()
}

/// The numbers with a comma between their digits, outside strings and comments.
fn decimal_commas(line: &str) -> Vec<Range<usize>> {
    let bytes = line.as_bytes();
    let digits = |byte: &&u8| byte.is_ascii_digit();
    let (mut found, mut quote): (Vec<Range<usize>>, Option<u8>) = (Vec::new(), None);
    for (i, &byte) in bytes.iter().enumerate() {
        match (quote, byte) {
            (None, b'#') => break,
            (None, b'"' | b'\'') => quote = Some(byte),
            (Some(open), _) if open == byte => quote = None,
            (None, b',') => {
                let before = bytes[..i].iter().rev().take_while(digits).count();
                let after = bytes[i + 1..].iter().take_while(digits).count();
                if before > 0 && after > 0 && found.last().is_none_or(|number| number.end <= i - before) {
                    found.push(i - before..i + 1 + after);
                }
            }
            _ => {}
        }
    }
    found
}

/// The keys that lead to the innermost entry about which something is said at `span`.
fn path_at(table: &DeTable<'_>, span: &Range<usize>) -> Option<Vec<String>> {
    let contains = |place: Range<usize>| place.start <= span.start && span.end <= place.end;
    let mut outer = None;
    for (key, value) in table {
        let below = if let DeValue::Table(table) = value.get_ref() { path_at(table, span) } else { None };
        if let Some(mut path) = below {
            path.insert(0, key.get_ref().to_string());
            return Some(path);
        }
        if contains(key.span()) || contains(value.span()) {
            outer = Some(vec![key.get_ref().to_string()]);
        }
    }
    outer
}

/// Replaces the entry at a path by a value, or removes it.
fn change<'a>(table: &mut DeTable<'a>, path: &[String], value: Option<DeValue<'a>>) {
    let [name, rest @ ..] = path else { return };
    let key = table.keys().find(|key| key.get_ref() == name).cloned();
    let Some(key) = key else { return };
    match (rest, value) {
        ([], None) => drop(table.remove(&key)),
        ([], Some(value)) => {
            if let Some(entry) = table.get_mut(&key) {
                *entry.get_mut() = value;
            }
        }
        (rest, value) => {
            if let Some(DeValue::Table(inner)) = table.get_mut(&key).map(Spanned::get_mut) {
                change(inner, rest, value);
            }
        }
    }
}

/// What is wrong with the entry at a path, in words for people who do not know Rust.
fn in_words(text: &str, path: &[String], error: &Error) -> String {
    let (key, message) = (path.join("."), error.message());
    let table = path[..path.len() - 1].join(".");
    if let Some(names) = message.strip_prefix("unknown field ") {
        let (wrong, names) = names_in(names);
        let place = if table.is_empty() { String::new() } else { format!(" in [{table}]") };
        let hint = suggestion(wrong, &table, &names);
        return format!("unknown key `{wrong}`{place}{hint} (it may have {})", names.join(", "));
    }
    if let Some(names) = message.strip_prefix("unknown variant ") {
        let (wrong, names) = names_in(names);
        let hint = super::keys::nearest(wrong, names.iter().copied());
        let hint = hint.map_or(String::new(), |name| format!("; did you mean `{name}`?"));
        return format!("{key}: unknown value `{wrong}`{hint} (it may be {})", listed(&names));
    }
    if let Some(name) = message.strip_prefix("missing field ") {
        return format!("missing key {name} in {key}");
    }
    let typed = error.span().and_then(|span| text.get(span)).unwrap_or_default();
    let whole = match key.as_str() {
        "sampling.seed" => "a whole number from 0 to 18446744073709551615 (2^64 - 1)",
        _ => "a whole number, for example 10_000",
    };
    if message == "integer number overflowed" {
        return format!("{key} = {} is too large; it must be {whole}", short(typed));
    }
    let parts = message.split_once(": ").filter(|(start, _)| start.starts_with("invalid "));
    let Some((found, expected)) = parts.and_then(|(_, rest)| rest.split_once(", expected ")) else {
        // Some types say themselves what is wrong with which key.
        let is_whole = message.starts_with(path[0].as_str());
        return if is_whole { message.to_owned() } else { format!("{key}: {message}") };
    };
    let number =
        if found.starts_with("string") { typed.trim_matches(['"', '\'']).replacen(',', ".", 1) } else { String::new() };
    let is_number = number.parse::<f64>().is_ok();
    let found = found.replace('`', "");
    let found = match found.split_once(' ') {
        Some(("string", string)) => format!("the string {string}"),
        Some(("integer", number)) => number.trim_end_matches(" as i128").to_owned(),
        Some(("floating", number)) => number.trim_start_matches("point ").to_owned(),
        Some(("boolean", value)) => value.to_owned(),
        _ if found == "map" => "a table".to_owned(),
        _ if found == "sequence" => "a list".to_owned(),
        _ => found,
    };
    let expected = match expected {
        "u64" | "u32" | "usize" => whole,
        "f64" => "a number",
        "bool" | "a boolean" => "true or false",
        "a sequence" => "a list",
        "a string" => "a text in quotes",
        "struct IndexSpec" => "a table, for example { amplitude = 0.002 }",
        expected if expected.starts_with("struct ") || expected == "a map" => "a table",
        expected => expected,
    };
    let hint = if is_number && expected != "a text in quotes" {
        format!("; write {number}, without quotes")
    } else {
        String::new()
    };
    format!("{key} is {found}; it must be {expected}{hint}")
}

/// The offending name and the admissible ones, from "`x`, expected one of `a`, `b`".
fn names_in(message: &str) -> (&str, Vec<&str>) {
    let mut names = message.split('`').skip(1).step_by(2);
    (names.next().unwrap_or_default(), names.collect())
}

/// `a`, `b` or `c`.
fn listed(names: &[&str]) -> String {
    let names: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    match &names[..] {
        [] => String::new(),
        [only] => only.clone(),
        [first @ .., last] => format!("{} or {last}", first.join(", ")),
    }
}

/// A piece of the text that fits in a message.
fn short(text: &str) -> String {
    let line = text.lines().next().unwrap_or_default();
    if line.len() == text.len() && line.chars().count() <= 60 { line.to_owned() } else { "...".to_owned() }
}

/// The values that the entry at a path may have, if it is one of a few names: an attempt with another name tells them.
fn choices_at(document: &Spanned<DeTable<'_>>, path: &[String]) -> Vec<String> {
    let mut attempt = document.clone();
    change(attempt.get_mut(), path, Some(DeValue::String("?".into())));
    let Err(error) = JobSpec::deserialize(Deserializer::from(attempt)) else { return Vec::new() };
    match error.message().strip_prefix("unknown variant ").map(names_in) {
        Some(("?", choices)) => choices.into_iter().map(str::to_owned).collect(),
        _ => Vec::new(),
    }
}

/// Something else than a name where one of a few is wanted.
fn not_a_choice(key: &str, typed: &str, choices: &[String]) -> String {
    let choices: Vec<&str> = choices.iter().map(String::as_str).collect();
    let choices = listed(&choices).replace('`', "\"");
    format!("{key} = {} is not a value that it may have; write {choices}", short(typed))
}

/// The value of the entry at a path.
fn value_at<'a, 'i>(table: &'a DeTable<'i>, path: &[String]) -> Option<&'a Spanned<DeValue<'i>>> {
    let [name, rest @ ..] = path else { return None };
    let (_, value) = table.iter().find(|(key, _)| key.get_ref() == name)?;
    match value.get_ref() {
        _ if rest.is_empty() => Some(value),
        DeValue::Table(inner) => value_at(inner, rest),
        _ => None,
    }
}
