//! Paths in messages, and quoted for shells. A name may hold any byte but `/` and zero.

use std::borrow::Cow;
use std::fmt::Write as _;
use std::path::Path;

/// A path quoted for bash and zsh, for commands that a message suggests. Where it begins with a dash, no command takes
/// it for an option.
pub fn quoted(path: &Path) -> String {
    let bytes = path.as_os_str().as_encoded_bytes();
    let dot = if bytes.starts_with(b"-") { "./" } else { "" };
    let is_plain = |c: char| c.is_alphanumeric() || "._-/+=:@".contains(c);
    match path.to_str() {
        // Zsh takes a word that begins with = for the place of a command.
        Some(text) if !text.is_empty() && !text.starts_with('=') && text.chars().all(is_plain) => {
            format!("{dot}{text}")
        }
        Some(text) if !text.contains(is_hidden) => in_quotes(&format!("{dot}{text}")),
        _ => format!("$'{dot}{}'", escaped(bytes)),
    }
}

/// A text in quotes, which every shell reads as one word.
pub fn in_quotes(text: &str) -> String {
    format!("'{}'", text.replace('\'', "'\\''"))
}

/// A path for messages: as it is, or as a shell would take it if it holds what cannot be shown.
pub fn shown(path: &Path) -> String {
    match path.to_str() {
        Some(text) if !text.contains(is_hidden) => text.to_owned(),
        _ => format!("$'{}'", escaped(path.as_os_str().as_encoded_bytes())),
    }
}

/// A message whose control characters, other than the ends of lines, are shown as text.
pub fn without_controls(text: &str) -> String {
    let is_shown = |c: char| c == '\n' || !is_hidden(c);
    text.chars().fold(String::with_capacity(text.len()), |mut shown, c| {
        if is_shown(c) {
            shown.push(c);
        } else {
            shown.extend(c.escape_default());
        }
        shown
    })
}

/// A text for standard output or a page, in which characters that are not seen stand as JSON and TOML write them, `\u202e`.
/// Ends of lines, tabs, and the codes by which this program colours its output and moves the cursor stay.
pub fn printable(text: &str) -> Cow<'_, str> {
    let is_hidden = |c: char| is_hidden(c) && !['\n', '\t'].contains(&c);
    let Some(first) = text.find(is_hidden) else { return Cow::Borrowed(text) };
    let mut shown = text[..first].to_owned();
    for (at, c) in text.char_indices().skip_while(|(at, _)| *at < first) {
        if !is_hidden(c) || (c == '\x1b' && is_own_code(&text[at + 1..])) {
            shown.push(c);
        } else {
            // Writing to a string cannot fail, and these characters have four digits.
            let _ = write!(shown, "\\u{:04x}", c as u32);
        }
    }
    Cow::Owned(shown)
}

/// Whether this follows the escape character in a code of colours, or in one that moves the cursor up or erases.
fn is_own_code(text: &str) -> bool {
    let parameters =
        text.strip_prefix('[').map(|rest| rest.trim_start_matches(|c: char| c.is_ascii_digit() || c == ';'));
    parameters.is_some_and(|rest| rest.starts_with(['m', 'A', 'J']))
}

/// Whether a character is not seen, or changes how others are: control characters, ends of lines of any kind, marks
/// that turn the direction of writing, and what is no character.
fn is_hidden(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}')
        || matches!(c, '\u{feff}' | '\u{fffe}' | '\u{ffff}')
}

/// The inside of a `$'...'` of bash and zsh.
fn escaped(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(bytes.len());
    for chunk in bytes.utf8_chunks() {
        for c in chunk.valid().chars() {
            match c {
                '\'' | '\\' => text.extend(['\\', c]),
                c if is_hidden(c) => push_bytes(&mut text, c.encode_utf8(&mut [0; 4]).as_bytes()),
                c => text.push(c),
            }
        }
        push_bytes(&mut text, chunk.invalid());
    }
    text
}

/// Adds bytes in octal, which unlike hexadecimal has an end whatever follows.
fn push_bytes(text: &mut String, bytes: &[u8]) {
    for byte in bytes {
        // Writing to a string cannot fail.
        let _ = write!(text, "\\{byte:03o}");
    }
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt as _;
    use std::process::Command;

    use super::*;

    /// Names that a user may have, and such as others may make.
    const NAMES: [&[u8]; 17] = [
        b"runs/fig14a",
        "Bremsen/Gr\u{fc}n".as_bytes(),
        b"with space",
        b"it's",
        b"$HOME `id` \"x\" \\ !! *",
        b"~",
        b"-rf",
        b"-with space",
        b"--out=x",
        b"=ls",
        b"-\xff",
        b"",
        b"\xff\xfe/0123",
        b"two\nlines",
        b"\x1b[31mred\x07\t'\\",
        "\u{202e}turned\u{85}a".as_bytes(),
        b"\x01\x7f1",
    ];

    #[test]
    fn a_shell_reads_what_is_quoted_as_the_path_itself() {
        for name in NAMES {
            let text = quoted(Path::new(OsStr::from_bytes(name)));
            assert!(!text.contains(is_hidden), "{text:?}");
            let output = Command::new("bash").args(["-c", &format!("printf '%s\\0' {text}")]).output().unwrap();
            let read = output.stdout.strip_suffix(b"\0").unwrap();
            let read = if name.starts_with(b"-") { read.strip_prefix(b"./").unwrap() } else { read };
            assert_eq!(read, name, "{text}: {output:?}");
        }
    }

    #[test]
    fn messages_show_what_cannot_be_seen() {
        let path = |name: &'static [u8]| Path::new(OsStr::from_bytes(name));
        assert_eq!(shown(path(b"runs/it's")), "runs/it's");
        assert_eq!(shown(path(b"a\xffb\n")), "$'a\\377b\\012'");
        assert_eq!(without_controls("one\ntwo\x1b[2J\r"), "one\ntwo\\u{1b}[2J\\r");
        let coloured = "\x1b[36;1m\u{2807}\x1b[0m\tä\n\x1b[3A\x1b[J";
        assert_eq!(printable(coloured), coloured);
        assert_eq!(printable("a\u{202e}b\x1b]0;x\x07\u{9b}\x1b[2K"), "a\\u202eb\\u001b]0;x\\u0007\\u009b\\u001b[2K");
        let text = "\u{202e}\x1b\u{85}";
        let written = serde_json::Value::from(text).to_string();
        assert_eq!(serde_json::from_str::<String>(&printable(&written)).unwrap(), text);
    }
}
