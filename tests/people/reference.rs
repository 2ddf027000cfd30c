//! The tables of keys in docs/reference/job-spec.md are what the JSON schema says of them.
//!
//! Such a table follows a comment that names its place in the schema, and its rows keep the order that they have on the
//! page. `<!-- keys of #/$defs/LimitSpec -->` lists every key, `<!-- these keys of ... -->` those that the page has already.
//!
//! `STICKSLIP_UPDATE=1 cargo test -p stickslip --test people reference` writes the tables anew.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so and stop")]

use std::f64::consts::{FRAC_PI_6, PI};
use std::fs;

use crate::common::{Place, repository};
use serde_json::Value;

const PAGE: &str = "docs/reference/job-spec.md";
const ALL: &str = "<!-- keys of ";
const THESE: &str = "<!-- these keys of ";
const PARAMETERS: &str = "<!-- parameters -->";
const ANEW: &str = "STICKSLIP_UPDATE=1 cargo test -p stickslip --test people reference writes the tables anew";

/// What a schema refers to, with everything that may stand in its place.
fn alternatives<'a>(root: &'a Value, schema: &'a Value) -> Vec<&'a Value> {
    if let Some(reference) = schema["$ref"].as_str() {
        return alternatives(root, at(root, reference));
    }
    match schema["anyOf"].as_array() {
        Some(choices) => choices.iter().flat_map(|choice| alternatives(root, choice)).collect(),
        None => vec![schema],
    }
}

/// A place in the schema, as references have it.
fn at<'a>(root: &'a Value, reference: &str) -> &'a Value {
    let place = root.pointer(reference.strip_prefix('#').unwrap());
    place.unwrap_or_else(|| panic!("{PAGE}: the schema has no {reference}"))
}

/// Adds a word, unless it is there.
fn add(words: &mut Vec<String>, word: String) {
    if !words.contains(&word) {
        words.push(word);
    }
}

/// `a`, `b` or `c`.
fn listed(words: &[String]) -> String {
    match words {
        [] => String::new(),
        [only] => only.clone(),
        [first @ .., last] => format!("{} or {last}", first.join(", ")),
    }
}

/// The types that a value may have.
fn types(root: &Value, schema: &Value) -> String {
    let mut words = Vec::new();
    for choice in alternatives(root, schema) {
        let names = choice["type"].as_array().cloned().unwrap_or_else(|| vec![choice["type"].clone()]);
        for name in names {
            match name.as_str().unwrap_or("string") {
                "null" => {}
                "integer" => add(&mut words, "whole number".to_owned()),
                "array" => match types(root, &choice["items"]) {
                    items if items.contains(" or ") => add(&mut words, "list of these".to_owned()),
                    items if items.starts_with("list") => add(&mut words, "list of lists".to_owned()),
                    items => add(&mut words, format!("list of {items}s")),
                },
                "object" if choice["additionalProperties"].is_object() => add(&mut words, "table by input".to_owned()),
                "object" => add(&mut words, "table".to_owned()),
                "string" => add(&mut words, "text".to_owned()),
                other => add(&mut words, other.to_owned()),
            }
        }
    }
    listed(&words)
}

/// A value in the words of TOML.
fn shown(value: &Value) -> String {
    match value {
        Value::Null | Value::Object(_) => String::new(),
        Value::Number(_) => number(value),
        other => format!("`{other}`"),
    }
}

/// A number with few digits.
fn number(number: &Value) -> String {
    let value = number.as_f64().unwrap();
    let named = [(PI, "pi"), (FRAC_PI_6, "pi/6"), (u64::MAX as f64, "2^64 - 1")];
    if let Some((_, name)) = named.iter().find(|(known, _)| *known == value) {
        return (*name).to_owned();
    }
    match number.as_u64() {
        Some(1_000_000) => "1 000 000".to_owned(),
        Some(whole @ 10_000..1_000_000) => format!("{} {:03}", whole / 1000, whole % 1000),
        _ if value == 0.0 || (1e-4..1e4).contains(&value.abs()) => value.to_string(),
        _ => format!("{value:e}"),
    }
}

/// The admissible values, if they are numbers within limits.
fn range(root: &Value, schema: &Value) -> String {
    let limits = |schema: &Value| {
        let limit = |key: &str| schema[key].is_number().then(|| number(&schema[key]));
        let lower = limit("minimum").or_else(|| Some(format!(">{}", limit("exclusiveMinimum")?)));
        let upper = limit("maximum").or_else(|| Some(format!("<{}", limit("exclusiveMaximum")?)));
        match (lower, upper) {
            (Some(lower), Some(upper)) => Some(format!("{lower} to {upper}")),
            // Schemas of whole numbers all have a zero.
            (Some(lower), None) if lower != "0" => Some(format!("from {lower}")),
            _ => None,
        }
    };
    limits(schema).or_else(|| alternatives(root, schema).into_iter().find_map(limits)).unwrap_or_default()
}

/// What a key means, and each of its words.
fn meaning(root: &Value, schema: &Value) -> String {
    let sentence = |text: &Value| {
        let text = text.as_str().unwrap_or_default().replace('\n', " ");
        if text.is_empty() || text.ends_with(['.', '?']) { text } else { text + "." }
    };
    let mut text = sentence(&schema["description"]);
    text[..1].make_ascii_uppercase();
    for choice in alternatives(root, schema) {
        for word in choice["oneOf"].as_array().into_iter().flatten() {
            text += &format!(" `{}`: {}", word["const"], sentence(&word["description"]));
        }
        let words: Vec<String> =
            choice["enum"].as_array().into_iter().flatten().map(|word| format!("`{word}`")).collect();
        if !words.is_empty() && choice["description"] == schema["description"] {
            text += &format!(" One of {}.", words.join(", "));
        }
    }
    text
}

/// A table; columns that say nothing are left out.
fn table<const N: usize>(head: [&str; N], rows: &[[String; N]]) -> String {
    let shown: Vec<usize> = (0..N).filter(|&i| rows.iter().any(|row| !row[i].is_empty())).collect();
    let line = |cell: &dyn Fn(usize) -> String| {
        let cells = shown.iter().map(|&i| cell(i).replace('|', "\\|"));
        let cells = cells.map(|text| if text.is_empty() { " |".to_owned() } else { format!(" {text} |") });
        format!("|{}\n", cells.collect::<String>())
    };
    let rows: String = rows.iter().map(|row| line(&|i| row[i].clone())).collect();
    format!("{}|{}\n{rows}", line(&|i| head[i].to_owned()), "---|".repeat(shown.len()))
}

/// The keys in the first column of a table on the page, in its order.
fn keys_on(page: &str) -> Vec<String> {
    page.lines().filter_map(|line| Some(line.strip_prefix("| `")?.split_once('`')?.0.to_owned())).collect()
}

/// The table of the keys of a place in the schema, in the order of the page; new ones come last.
fn keys_of(root: &Value, reference: &str, page: &str, all: bool) -> String {
    let schema = at(root, reference);
    let properties = schema["properties"].as_object().unwrap();
    let mut keys = keys_on(page);
    keys.retain(|key| properties.contains_key(key));
    if all {
        properties.keys().for_each(|key| add(&mut keys, key.clone()));
    }
    let required = schema["required"].as_array().into_iter().flatten();
    let required: Vec<&str> = required.filter_map(Value::as_str).collect();
    let row = |key: &String| {
        let property = &properties[key];
        let default = match shown(&property["default"]) {
            _ if required.contains(&key.as_str()) => "required".to_owned(),
            none if none.is_empty() => none,
            value => format!("default {value}"),
        };
        let (kind, range) = (types(root, property), range(root, property));
        // Limits are those of numbers, and defaults show what they are.
        let is_shown = match &*kind {
            "number" => !range.is_empty() || default.starts_with("default"),
            "text" | "boolean" => default.starts_with("default"),
            _ => false,
        };
        let kind = if is_shown { String::new() } else { kind };
        let value: Vec<String> = [kind, range, default].into_iter().filter(|part| !part.is_empty()).collect();
        [format!("`{key}`"), value.join(", "), meaning(root, property)]
    };
    table(["key", "value", "meaning"], &keys.iter().map(row).collect::<Vec<_>>())
}

/// The table of the parameters of the pad on the disc.
fn parameters(place: &Place) -> String {
    let listed: Value = serde_json::from_str(&place.run("parameters --json").done().stdout).unwrap();
    let row = |parameter: &Value| {
        let text = |key: &str| parameter[key].as_str().unwrap().to_owned();
        let limit = |key: &str| number(&parameter[key]);
        let lower = if parameter["includes_minimum"] == true { "" } else { ">" };
        let upper = if parameter["includes_maximum"] == true { "" } else { "<" };
        let range = format!("{lower}{} to {upper}{}", limit("minimum"), limit("maximum"));
        let preset = match &*text("unit") {
            "1" => limit("preset"),
            unit => format!("{} {unit}", limit("preset")),
        };
        let meaning = format!("{}: {}", text("symbol"), text("description"));
        [format!("`{}`", text("key")), format!("{preset}, {range}"), meaning]
    };
    let rows: Vec<_> = listed["parameters"].as_array().unwrap().iter().map(row).collect();
    table(["key under `[model]`", "preset, range", "meaning"], &rows)
}

/// The page with its tables made anew.
fn made_anew(page: &str) -> String {
    let place = Place::new();
    let root: Value = serde_json::from_str(&place.run("schema").done().stdout).unwrap();
    let mut lines = page.lines();
    let (mut text, mut tables) = (String::new(), 0);
    while let Some(line) = lines.next() {
        text += &format!("{line}\n");
        let all = line.strip_prefix(ALL);
        let reference = all.or_else(|| line.strip_prefix(THESE)).map(|rest| rest.strip_suffix(" -->").unwrap());
        if reference.is_none() && line != PARAMETERS {
            continue;
        }
        let shown: Vec<&str> = lines.by_ref().skip(1).take_while(|line| line.starts_with('|')).collect();
        let made = match reference {
            Some(reference) => keys_of(&root, reference, &shown.join("\n"), all.is_some()),
            None => parameters(&place),
        };
        text += &format!("\n{made}\n");
        tables += 1;
    }
    assert!(tables >= 14, "{PAGE} has only {tables} tables of keys");
    text
}

#[test]
fn the_tables_of_keys_are_what_the_schema_says() {
    let path = repository().join(PAGE);
    let page = fs::read_to_string(&path).unwrap();
    let made = made_anew(&page);
    if std::env::var_os("STICKSLIP_UPDATE").is_some() {
        fs::write(path, made).unwrap();
        return;
    }
    let mut lines = page.lines().zip(made.lines()).enumerate();
    if let Some((number, (shown, made))) = lines.find(|(_, (shown, made))| shown != made) {
        panic!("{PAGE}:{}: {shown}\nshould be: {made}\n{ANEW}", number + 1);
    }
    assert_eq!(page, made, "{ANEW}");
}
