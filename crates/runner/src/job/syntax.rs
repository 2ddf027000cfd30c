//! What is wrong with a text that is no TOML, for people who write MATLAB or numbers with a decimal comma.

use std::ops::Range;

use toml::de::Error;

use super::diagnosis::Complaint;
use crate::units;

/// One complaint for each line that is no TOML, up to one that leaves the rest of the text without meaning.
pub fn errors(text: &str, mut errors: Vec<Error>) -> Vec<Complaint> {
    let start_of = |error: &Error| error.span().map_or(0, |span| span.start.min(text.len()));
    errors.sort_by_key(start_of);
    let mut complaints = Vec::new();
    let mut last = None;
    // A line may be long, and have many errors: the start of its line is sought from the one before.
    let (mut line_start, mut searched) = (0, 0);
    for error in &errors {
        let newline = text.as_bytes()[searched..start_of(error)].iter().rposition(|&byte| byte == b'\n');
        line_start = newline.map_or(line_start, |newline| searched + newline + 1);
        searched = start_of(error);
        // Further errors of a line mostly follow from the first.
        if last.replace(line_start) == Some(line_start) {
            continue;
        }
        let line = text.get(line_start..).and_then(|rest| rest.lines().next()).unwrap_or("");
        // Beside such a number a list looks like one with decimal commas.
        if let Some((place, right)) = point_without_digit(line) {
            let message = format!("{} lacks a digit beside its point; write {right}", &line[place.clone()]);
            complaints.push(Complaint::at(line_start + place.start..line_start + place.end, message));
            continue;
        }
        let commas = decimal_commas(line);
        for place in &commas {
            let number = &line[place.clone()];
            let message = units::with_comma(number);
            complaints.push(Complaint::at(line_start + place.start..line_start + place.end, message));
        }
        if !commas.is_empty() {
            continue;
        }
        if error.message().starts_with("missing comma") {
            let message = "a comma is missing between the values of a list, or the list is not closed with ]";
            complaints.push(Complaint::maybe_at(error.span(), message));
            break;
        }
        complaints
            .push(Complaint::maybe_at(error.span(), in_words(line).unwrap_or_else(|| error.message().to_owned())));
    }
    complaints
}

/// What is wrong with a line of a key and a value, if that is known.
fn in_words(line: &str) -> Option<String> {
    let (key, value) = line.split_once('=')?;
    let (key, value) = (key.trim(), value.trim());
    if value.is_empty() || value.starts_with('#') {
        return Some(format!("{key} has no value"));
    }
    let value = value.split_once(" #").map_or(value, |(value, _)| value.trim_end());
    let is_curly = |c: char| "“”„‟‘’‚«»".contains(c);
    if value.contains(is_curly) && !value.starts_with(['"', '\'']) {
        let plain = value.trim_matches(is_curly);
        let right = if plain.parse::<f64>().is_ok() { plain.to_owned() } else { format!("\"{plain}\"") };
        return Some(format!("{value} has typographic quotation marks; write straight ones: {key} = {right}"));
    }
    let minus = |c: char| "−–—".contains(c);
    if value.contains(minus) && !value.starts_with(['"', '\'']) {
        let right = value.replace(minus, "-");
        return Some(format!("{value} has a dash that is no minus sign; write {key} = {right}"));
    }
    if value.starts_with(['"', '\'']) {
        return None;
    }
    if let Some(said) = units::number_with_unit(value) {
        return Some(said);
    }
    if let Some((before, _)) = value.split_once('%') {
        return Some(format!("a comment begins with #, not with %: {key} = {} # ...", before.trim()));
    }
    if let Some(before) = value.strip_suffix(';') {
        return Some(format!("a line has no semicolon at its end: {key} = {before}"));
    }
    if value.contains(['(', ':']) {
        return Some("a range of values is written as { from = 0.1, to = 0.2, points = 5 }".to_owned());
    }
    let inside = value.strip_prefix('[').and_then(|rest| rest.strip_suffix(']'));
    if let Some(inside) = inside {
        let numbers: Vec<&str> = inside.split([' ', ',']).filter(|word| !word.is_empty()).collect();
        let are_numbers = numbers.iter().all(|number| number.parse::<f64>().is_ok());
        return are_numbers.then(|| format!("the values of a list are separated by commas: [{}]", numbers.join(", ")));
    }
    let is_word = value.chars().all(|c| c.is_alphanumeric() || "-_. ".contains(c));
    (is_word && value.starts_with(char::is_alphabetic))
        .then(|| format!("{value} is no value: a text is written in quotes, \"{value}\""))
}

/// Characters of a number to each side of its point, at most: a line may be long.
const LONGEST: usize = 40;

/// The first number outside strings and comments that begins or ends with its point, and how it is right.
fn point_without_digit(line: &str) -> Option<(Range<usize>, String)> {
    let mut quote = None;
    let bytes = line.as_bytes();
    let digit = |place: Option<usize>| place.and_then(|place| bytes.get(place)).is_some_and(u8::is_ascii_digit);
    let word = |byte: &u8| byte.is_ascii_alphanumeric() || matches!(byte, b'.' | b'_' | b'-' | b'+' | b'"' | b'\'');
    for (i, &byte) in bytes.iter().enumerate() {
        match (quote, byte) {
            (None, b'#') => return None,
            (None, b'"' | b'\'') => quote = Some(byte),
            (Some(open), _) if open == byte => quote = None,
            (None, b'.') => {
                let from = i - bytes[..i].iter().rev().take(LONGEST).take_while(|byte| word(byte)).count();
                let to = i + bytes[i..].iter().take(LONGEST).take_while(|byte| word(byte)).count();
                let (before, after) = (digit(i.checked_sub(1)), digit(Some(i + 1)));
                let right = match (before, after) {
                    (false, true) => format!("{}0{}", &line[from..i], &line[i..to]),
                    (true, false) => format!("{}.0{}", &line[from..i], &line[i + 1..to]),
                    _ => continue,
                };
                if right.parse::<f64>().is_ok() {
                    return Some((from..to, right));
                }
            }
            _ => {}
        }
    }
    None
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_begin_or_end_with_their_point_are_found() {
        for (line, number, right) in [
            ("damping = [[0.2,0],[0,.1]]", ".1", "0.1"),
            ("k = -.5e3 # .7", "-.5e3", "-0.5e3"),
            ("k = 2.", "2.", "2.0"),
            ("k = [1., 2.0]", "1.", "1.0"),
        ] {
            let (place, found) = point_without_digit(line).unwrap();
            assert_eq!((&line[place], &*found), (number, right), "{line}");
        }
        for line in ["k = 2,0", "a.b = 1.0", "name = \".5\"", "# .5", "1.a = 2", "k = 1.5.2", "pad.mass = 2"] {
            assert_eq!(point_without_digit(line), None, "{line}");
        }
    }
}
