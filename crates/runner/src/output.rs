//! Writing to standard output and standard error, without a panic if they are closed.

use std::env;
use std::fmt;
use std::io::{self, IsTerminal as _, Write as _};
use std::mem;
use std::path::{Path, PathBuf};

use anstream::AutoStream;
use anstream::adapter::strip_str;
use indicatif::HumanCount;

use crate::failure::Failure;
use crate::messages::{Code, Message, Place};
pub use crate::shell::{printable, quoted, shown};

/// Writes a result to standard output. What is not seen in it is shown as text. Its colours are left out where that is no terminal, and at one that has none or
/// is asked to show none (`NO_COLOR`, `TERM=dumb`). A terminal that cannot show the characters of drawings gets others.
///
/// # Errors
/// Any output error, including a closed pipe and a full disk.
pub fn result(text: &str) -> Result<(), Failure> {
    let text = printable(text);
    let plain = (io::stdout().is_terminal() && !is_utf8(|name| env::var(name).ok())).then(|| in_ascii(&text));
    let mut out = AutoStream::auto(io::stdout().lock());
    let text = plain.as_deref().unwrap_or(&text);
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(|error| Failure::output(&error))
}

/// A text without the codes of its colours.
pub fn without_colours(text: &str) -> String {
    strip_str(text).to_string()
}

/// Whether the locale has the characters of UTF-8. One that is not set says nothing against it.
fn is_utf8(variable: impl Fn(&str) -> Option<String>) -> bool {
    let set =
        ["LC_ALL", "LC_CTYPE", "LANG"].into_iter().find_map(|name| variable(name).filter(|text| !text.is_empty()));
    set.is_none_or(|locale| {
        let locale = locale.to_lowercase();
        locale.contains("utf-8") || locale.contains("utf8")
    })
}

/// A text with ASCII characters for those of drawings.
fn in_ascii(text: &str) -> String {
    let mut ascii = String::with_capacity(text.len());
    let mut is_raised = false;
    for c in text.chars() {
        let raised = match c {
            '⁻' => Some('-'),
            '¹' => Some('1'),
            '²' => Some('2'),
            '³' => Some('3'),
            '⁰'..='⁹' => char::from_digit(c as u32 - '⁰' as u32, 10),
            _ => None,
        };
        if raised.is_some() && !is_raised {
            ascii.push('^');
        }
        is_raised = raised.is_some();
        ascii.push(raised.unwrap_or(match c {
            // Braille: dots in the upper half, in the lower half, in both.
            '\u{2800}'..='\u{28ff}' => match c as u32 & 0xff {
                0 => ' ',
                dots if dots & 0b1110_0100 == 0 => '\'',
                dots if dots & 0b0001_1011 == 0 => '.',
                _ => ':',
            },
            '│' | '┤' | '┊' => '|',
            '└' | '┬' => '+',
            '─' | '╌' => '-',
            '█' => '#',
            '▓' => '%',
            '▒' => '+',
            '░' => '-',
            '·' => '.',
            '●' => 'o',
            '′' => '\'',
            'μ' | 'µ' => 'u',
            '…' => '~',
            c if c.is_ascii() => c,
            _ => '?',
        }));
    }
    ascii
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

/// What to do about a file of a run that could not be written, or threads that could not be started, before the command
/// that goes on.
pub const FREE_SPACE: &str = "correct that, or where a disk is full free space, then";

/// Writes a note to standard error.
pub fn note(text: fmt::Arguments<'_>) {
    announce(Code::Note, text);
}

/// Writes a message with a code, which programs know it by, to standard error.
pub fn announce(code: Code, text: fmt::Arguments<'_>) {
    Message::new(code, &text.to_string()).send();
}

/// Writes warnings to standard error.
pub fn warn(warnings: impl IntoIterator<Item = String>) {
    warnings.into_iter().for_each(|warning| announce(Code::Warning, format_args!("{warning}")));
}

/// Writes a warning about a file to standard error. Its text begins with the path.
pub fn warn_of(path: &Path, text: fmt::Arguments<'_>) {
    let message = Message::new(Code::Warning, &format!("{}{text}", path.display()));
    Message { place: Some(Place::file(path)), ..message }.send();
}

/// The directory and name of the file of `--out`, if it can be written.
pub fn output_file(out: &Path) -> Result<(PathBuf, String), Failure> {
    let directory = match out.parent() {
        Some(parent) if parent != Path::new("") => parent.to_owned(),
        _ => PathBuf::from("."),
    };
    let name = out.file_name().and_then(|name| name.to_str());
    let name = name.ok_or_else(|| Failure::CannotCreate(format!("{} is not the name of a file", shown(out))))?;
    // Writing would replace a device, a pipe or a link by a file.
    if out.symlink_metadata().is_ok_and(|there| !there.is_file() && !there.is_dir()) {
        return Err(Failure::CannotCreate(format!("{} is not an ordinary file; name one", shown(out))));
    }
    if out.is_dir() {
        return Err(Failure::CannotCreate(format!("{} is a directory; name a file in it", shown(out))));
    }
    if !directory.is_dir() {
        let message = format!("cannot create {}: there is no directory {}", shown(out), shown(&directory));
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

/// Columns of text, each as wide as its longest entry.
pub fn aligned(lines: &[Vec<String>]) -> String {
    let columns = lines.iter().map(Vec::len).max().unwrap_or(0);
    let widths: Vec<usize> =
        (0..columns).map(|i| lines.iter().filter_map(|line| line.get(i)).map(String::len).max().unwrap_or(0)).collect();
    let line = |line: &Vec<String>| {
        let cells: Vec<String> = line.iter().zip(&widths).map(|(text, &width)| format!("{text:<width$}")).collect();
        format!("{}\n", cells.join("  ").trim_end())
    };
    lines.iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_locale_says_whether_a_terminal_shows_drawings() {
        for (set, expected) in [
            (vec![], true),
            (vec![("LANG", "de_DE.UTF-8")], true),
            (vec![("LANG", "de_DE.UTF-8"), ("LC_ALL", "C")], false),
            (vec![("LANG", "C"), ("LC_CTYPE", "C.utf8")], true),
            (vec![("LANG", "C"), ("LC_ALL", "")], false),
        ] {
            let find = |name: &str| set.iter().find(|(key, _)| *key == name).map(|(_, value)| (*value).to_owned());
            assert_eq!(is_utf8(find), expected, "{set:?}");
        }
    }

    #[test]
    fn drawings_have_ascii_characters_too() {
        assert_eq!(in_ascii("│⠉⣀⣿⠀┊ 10⁻¹² ░█ x′"), "|'.: | 10^-12 -# x'");
        assert_eq!(in_ascii("Poincaré"), "Poincar?");
    }

    #[test]
    fn colours_are_left_out() {
        assert_eq!(without_colours("\u{1b}[36m⠉\u{1b}[0m 1"), "⠉ 1");
    }
}
