//! From the text of a job spec to what it says, with a complaint about every entry that cannot be read.

use std::ops::Range;

use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::{DeTable, DeValue, Deserializer, Error};

use super::diagnosis::{Complaint, Complaints, MOST_SHOWN};
use super::keys::{Suggested, nearest, suggestion};
use super::spec::JobSpec;
use super::syntax;
use crate::units;

/// Bytes of text that are looked at again for entries that cannot be read.
const LOOKED_AT: usize = 1 << 22;

/// Reads the text of a job spec as TOML; `None` with complaints if it is none.
pub fn parse<'a>(text: &'a str, complaints: &mut Complaints) -> Option<Spanned<DeTable<'a>>> {
    let (document, errors) = DeTable::parse_recoverable(text);
    if errors.is_empty() {
        return Some(document);
    }
    syntax::errors(text, errors).into_iter().for_each(|complaint| complaints.push(complaint));
    None
}

/// Reads what a job spec says beside its model. `suggested` is asked about unknown keys.
pub fn job_spec(
    text: &str,
    mut document: Spanned<DeTable<'_>>,
    suggested: Suggested,
    complaints: &mut Complaints,
) -> Option<JobSpec> {
    flatten_axes(&mut document);
    // What is read elsewhere is not read again here.
    for (_, value) in document.get_mut().iter_mut().filter(|(key, _)| is_of_model(key.get_ref())) {
        *value.get_mut() = DeValue::Boolean(true);
    }
    read(text, document, suggested, complaints)
}

/// Whether a table is read by the kind of the model.
pub fn is_of_model(key: &str) -> bool {
    matches!(key, "model" | "criterion")
}

/// Reads tables of a job spec from the TOML of its text. An entry that cannot be read is complained about and left out, so
/// that the others are read too; `None` if nothing can be read. `suggested` is asked about unknown keys.
pub fn read<T: DeserializeOwned>(
    text: &str,
    mut document: Spanned<DeTable<'_>>,
    suggested: Suggested,
    complaints: &mut Complaints,
) -> Option<T> {
    // Each entry that cannot be read takes a look at the whole text again.
    let most = (LOOKED_AT / text.len().max(1)).clamp(1, MOST_SHOWN);
    loop {
        if complaints.len() >= most {
            return None;
        }
        let error = match T::deserialize(Deserializer::from(document.clone())) {
            Ok(spec) => return Some(spec),
            Err(error) => error,
        };
        let Some(mut path) = error.span().and_then(|span| path_at(document.get_ref(), &span)) else {
            complaints.push(Complaint::maybe_at(error.span(), error.message()));
            return None;
        };
        if let Some(whole) = whole_in_place_of(&document, &path, &error) {
            change(document.get_mut(), &path, Some(whole));
            continue;
        }
        let mut choices = choices_at::<T>(&document, &path);
        // A table in place of one of a few names: the fault is not within it.
        let is_within = !choices.is_empty() || error.message().starts_with("unknown field ") || is_number(&error);
        if let [outer @ .., _] = &path[..]
            && !is_within
            && let of_outer @ [_, ..] = &choices_at::<T>(&document, outer)[..]
        {
            (choices, path) = (of_outer.to_vec(), outer.to_vec());
        }
        let keys: Vec<&str> = path.iter().map(String::as_str).collect();
        // What is said of a table from which an entry was taken may follow from that.
        if !complaints.has_unread(&keys) {
            let value = value_at(document.get_ref(), &path);
            let complaint = value.and_then(|value| about_value(text, &keys.join("."), value, &choices, &error));
            let in_words = || Complaint::maybe_at(error.span(), in_words(text, &path, &error, suggested));
            complaints.push(complaint.unwrap_or_else(in_words));
        }
        change(document.get_mut(), &path, None);
        complaints.note_unread(path);
    }
}

/// Writes axes in tables of their own, `[axes.pad] mass = 0.1`, under their whole names, `axes."pad.mass"`.
fn flatten_axes(document: &mut Spanned<DeTable<'_>>) {
    const OF_A_VALUE: [&str; 4] = ["from", "to", "points", "scale"];
    let axes = document.get_mut().iter_mut().find(|(key, _)| key.get_ref() == "axes");
    let Some(DeValue::Table(axes)) = axes.map(|(_, value)| value.get_mut()) else { return };
    let is_section = |value: &DeValue<'_>| match value {
        DeValue::Table(table) => !table.is_empty() && !table.keys().any(|key| OF_A_VALUE.contains(&&**key.get_ref())),
        _ => false,
    };
    let sections: Vec<_> =
        axes.iter().filter(|(_, value)| is_section(value.get_ref())).map(|(key, _)| key.clone()).collect();
    for section in sections {
        let Some(DeValue::Table(table)) = axes.remove(&section).map(Spanned::into_inner) else { continue };
        for (name, value) in table {
            let whole = format!("{}.{}", section.get_ref(), name.get_ref());
            axes.insert(Spanned::new(name.span(), whole.into()), value);
        }
    }
}

/// The whole number that was written as 1e4 or 10000.0 where only whole ones are taken.
fn whole_in_place_of(document: &Spanned<DeTable<'_>>, path: &[String], error: &Error) -> Option<DeValue<'static>> {
    /// Beyond this, numbers with a point are not whole numbers one by one.
    const LARGEST: f64 = 9_007_199_254_740_992.0;
    let is_wanted = error.message().starts_with("invalid type: floating point ")
        && ["u64", "u32", "usize"].iter().any(|kind| error.message().ends_with(&format!("expected {kind}")));
    let DeValue::Float(number) = value_at(document.get_ref(), path)?.get_ref() else { return None };
    let value: f64 = number.as_str().parse().ok()?;
    if !is_wanted || !(0.0..=LARGEST).contains(&value) || value.fract() != 0.0 {
        return None;
    }
    // The parser makes whole numbers of text alone, which must outlive the document: some digits for each of few keys.
    let digits: &'static str = Box::leak((value as u64).to_string().into_boxed_str());
    DeValue::parse(digits).ok().map(Spanned::into_inner)
}

/// Whether what is wrong is the type of a value that must be a number or one of two.
fn is_number(error: &Error) -> bool {
    ["expected f64", "expected a boolean"].iter().any(|end| error.message().ends_with(end))
}

/// The key of the innermost entry that has the text at `span`.
pub fn key_at(text: &str, span: &Range<usize>) -> Option<String> {
    path_at(DeTable::parse_recoverable(text).0.get_ref(), span).map(|path| path.join("."))
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
fn in_words(text: &str, path: &[String], error: &Error, suggested: Suggested) -> String {
    let (key, message) = (path.join("."), error.message());
    let table = path[..path.len() - 1].join(".");
    if let Some(names) = message.strip_prefix("unknown field ") {
        let (wrong, names) = names_in(names);
        let place = if table.is_empty() { String::new() } else { format!(" in [{table}]") };
        let hint = suggestion::<JobSpec>(wrong, &table, &names, suggested);
        return format!("unknown key `{wrong}`{place}{hint} (it may have {})", names.join(", "));
    }
    if let Some(names) = message.strip_prefix("unknown variant ") {
        let (wrong, names) = names_in(names);
        let hint = nearest(wrong, names.iter().copied());
        let hint = hint.map_or(String::new(), |name| format!("; did you mean `{name}`?"));
        return format!("{key}: unknown value `{wrong}`{hint} (it may be {})", listed(&names));
    }
    if let Some(name) = message.strip_prefix("missing field ") {
        return format!("missing key {name} in {key}");
    }
    // Some types say themselves what is wrong with which key.
    let own = if message.starts_with(path[0].as_str()) { message.to_owned() } else { format!("{key}: {message}") };
    in_words_for(text, &key, error).unwrap_or(own)
}

/// What is wrong with a value of a wrong type or size.
fn in_words_for(text: &str, key: &str, error: &Error) -> Option<String> {
    let typed = error.span().and_then(|span| text.get(span)).unwrap_or_default();
    match error.message() {
        "integer number overflowed" => {
            Some(format!("{key} = {} is too large; it must be {}", short(typed), whole_number(key)))
        }
        "floating-point number overflowed" => Some(format!("{key} = {} is too large for a number", short(typed))),
        message => {
            let (start, types) = message.split_once(": ")?;
            let (found, expected) = types.split_once(", expected ")?;
            start.starts_with("invalid ").then(|| wrong_type(key, typed, found, expected))
        }
    }
}

/// What a key may be that holds a whole number.
fn whole_number(key: &str) -> &'static str {
    match key {
        "sampling.seed" => "a whole number from 0 to 18446744073709551615 (2^64 - 1)",
        _ => "a whole number, for example 10_000",
    }
}

/// The complaint about a value of a wrong type, of which serde says what it found and what it expected.
fn wrong_type(key: &str, typed: &str, found: &str, expected: &str) -> String {
    let number = typed.trim_matches(['"', '\'']).replacen(',', ".", 1);
    let is_text = found.starts_with("string");
    let is_number = is_text && number.parse::<f64>().is_ok();
    let hint = if is_number && expected != "a string" {
        format!("; write {number}, without quotes")
    } else if is_text && expected.starts_with("a matrix") {
        // The name of its file alone.
        format!("; write {{ file = {typed} }}")
    } else {
        String::new()
    };
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
        "u64" | "u32" | "usize" => whole_number(key),
        "f64" => "a number",
        "bool" | "a boolean" => "true or false",
        "a sequence" => "a list",
        "a string" => "a text in quotes",
        "struct IndexSpec" => "a table, for example { amplitude = 0.002 }",
        expected if expected.starts_with("struct ") || expected == "a map" => "a table",
        expected => expected,
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

/// The values that the entry at a path may have, if it is one of a few names: an attempt with another name lists them.
fn choices_at<T: DeserializeOwned>(document: &Spanned<DeTable<'_>>, path: &[String]) -> Vec<String> {
    let mut attempt = document.clone();
    change(attempt.get_mut(), path, Some(DeValue::String("?".into())));
    let Err(error) = T::deserialize(Deserializer::from(attempt)) else { return Vec::new() };
    match error.message().strip_prefix("unknown variant ").map(names_in) {
        Some(("?", choices)) => choices.into_iter().map(str::to_owned).collect(),
        _ => Vec::new(),
    }
}

/// A complaint about a value that is seen from the value itself, not from the error.
fn about_value(
    text: &str,
    key: &str,
    value: &Spanned<DeValue<'_>>,
    choices: &[String],
    error: &Error,
) -> Option<Complaint> {
    let span = value.span();
    let typed = short(text.get(span.clone()).unwrap_or_default());
    let is_list = matches!(value.get_ref(), DeValue::Array(_));
    if let Some(complaint) = of_number_with_unit(text, key, error.span().filter(|_| is_list).unwrap_or(span.clone())) {
        return Some(complaint);
    }
    match value.get_ref() {
        DeValue::Datetime(_) => Some(Complaint::at(span, format!("{key} = {typed} is a date"))),
        DeValue::Array(_) if typed.starts_with("[[") && !key.contains('.') => {
            Some(Complaint::at(span, format!("[[{key}]] would be a list of tables; write [{key}], and once only")))
        }
        // The error is about an element.
        DeValue::Array(_) if error.span().is_some_and(|place| place != span) => {
            Some(Complaint::maybe_at(error.span(), in_words_for(text, &format!("an element of {key}"), error)?))
        }
        // A wrong name is quoted in the error.
        DeValue::String(_) => None,
        _ if !choices.is_empty() => {
            let choices: Vec<&str> = choices.iter().map(String::as_str).collect();
            let state = if key == "criterion.start" { ", or a state, for example { velocity = 0.3 }" } else { "" };
            let choices = listed(&choices).replace('`', "\"") + state;
            Some(Complaint::at(span, format!("{key} = {typed} is not a value that it may have; write {choices}")))
        }
        _ => None,
    }
}

/// The complaint about a text that is a number with its unit behind it.
fn of_number_with_unit(text: &str, key: &str, span: Range<usize>) -> Option<Complaint> {
    let quote = ['"', '\''];
    let typed = text.get(span.clone())?.strip_prefix(quote)?.strip_suffix(quote)?;
    units::number_with_unit(typed).map(|said| Complaint::at(span, format!("{key}: {said}")))
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

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use crate::job::JobSource;

    const JOB: &str = r#"name = "job"
description = "text"
[model]
preset = "sui-ding-2018"
disc.thickness = 0.02
[model.pad]
mass = 0.1
[axes]
rotating_speed = 15.0
preload = { from = 0.1, to = 0.2, points = 3 }
static_friction = [0.3, 0.4]
[random]
inputs = ["preload", "static_friction"]
relative_std = 0.2
distribution = "lognormal"
correlation = [["preload", "static_friction", 0.3]]
[criterion]
kind = "time-domain"
disc = "rigid"
start = "rest"
displacement = 0.02
horizon = 1000
index = { amplitude = 0.002 }
record = ["amplitude"]
[sampling]
method = "monte-carlo"
samples = 1000
seed = 1
evaluate = "each"
common_random_numbers = false
confidence = 0.9
interval = "clopper-pearson"
simultaneous = false
derivatives = false
sensitivity = false
"#;

    fn complaints(text: String) -> Option<String> {
        JobSource { path: PathBuf::from("job.toml"), text }.job().err().map(|failure| failure.to_string())
    }

    #[test]
    fn a_wrong_value_is_reported_at_its_own_line_and_at_no_other() {
        assert_eq!(complaints(JOB.to_owned()), None);
        let values = ["\"x\"", "3", "-7", "1e400", "{ a = 1 }", "[1]", "[[]]", "true", "1,5", "nan", "1979-05-27", ""];
        for (number, line) in JOB.lines().enumerate().filter(|(_, line)| line.contains(" = ")) {
            let key = line.split_once(" = ").unwrap().0;
            for value in values {
                let changed = format!("{key} = {value}");
                let text: Vec<&str> =
                    JOB.lines().enumerate().map(|(i, old)| if i == number { &changed } else { old }).collect();
                let Some(said) = complaints(text.join("\n")) else { continue };
                let places = said.matches("job.toml:").count();
                let own = said.matches(&format!("job.toml:{}:", number + 1)).count();
                assert!(own == 1 && places == 1, "{changed}: {said}");
                for word in ["f64", "u64", "struct", "variant", "field", "sequence", "visitor"] {
                    assert!(!said.contains(word), "{changed}: {said}");
                }
            }
        }
    }
}
