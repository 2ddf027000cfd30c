//! Messages in the terms of the Python package, which calls this program: functions and arguments in place of commands and
//! options.

use std::fmt::Write as _;

/// The commands that are methods of a run, and those that are functions. The others exist at the command line alone.
const METHODS: [&str; 6] = ["resume", "verify", "plot", "report", "export", "status"];
const FUNCTIONS: [&str; 6] = ["check", "limit", "compare", "fit", "analyse", "trajectory"];

/// The options that are arguments of the same name, but for their dashes.
const ARGUMENTS: [&str; 30] = [
    "out",
    "overwrite",
    "samples",
    "seed",
    "threads",
    "cell",
    "sample",
    "of",
    "against",
    "result",
    "x",
    "y",
    "at",
    "target",
    "title",
    "columns",
    "probability",
    "confidence",
    "pointwise",
    "estimate",
    "plot",
    "format",
    "horizon",
    "start",
    "disc",
    "disc-modes",
    "grid",
    "allotment",
    "displacement",
    "job",
];

/// Those that take no value.
const FLAGS: [&str; 2] = ["overwrite", "pointwise"];

/// A message with calls for the commands between backticks, and arguments for options.
pub fn in_python(text: &str) -> String {
    let mut done = String::with_capacity(text.len());
    for (i, part) in text.split('`').enumerate() {
        if i > 0 {
            done.push('`');
        }
        let call = if i % 2 == 1 { call(part) } else { None };
        done += &call.unwrap_or_else(|| with_arguments(part, i % 2 == 1));
    }
    done
}

/// A remedy, which is a command, an option or words.
pub fn remedy_in_python(remedy: &str) -> String {
    call(remedy).unwrap_or_else(|| with_arguments(remedy, true))
}

/// The call in place of a command.
fn call(command: &str) -> Option<String> {
    let words = command.strip_prefix("stickslip ")?;
    let (name, rest) = words.split_once(' ').unwrap_or((words, ""));
    let run = match rest {
        "" => "run".to_owned(),
        word if word.starts_with(['\'', '$']) => format!("stickslip.Run({word})"),
        word if !word.contains(' ') => format!("stickslip.Run('{word}')"),
        _ => return None,
    };
    match name {
        _ if METHODS.contains(&name) => Some(format!("{run}.{name}()")),
        _ if FUNCTIONS.contains(&name) => Some(format!("stickslip.{name}(...)")),
        "submit" => Some("stickslip.run(...)".to_owned()),
        _ => None,
    }
}

/// A text with arguments for options. A word behind an option is its value if it is a number, or the last of a command.
fn with_arguments(text: &str, is_code: bool) -> String {
    let mut done = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find("--") {
        let (before, option) = rest.split_at(at);
        done += before;
        let length = option[2..].find(|c: char| !c.is_ascii_lowercase() && c != '-').unwrap_or(option.len() - 2);
        let (name, after) = option[2..].split_at(length);
        let value = after.strip_prefix([' ', '=']).unwrap_or_default();
        let is_known = ARGUMENTS.contains(&name) && !before.ends_with(|c: char| c.is_alphanumeric() || c == '-');
        if name == "set" && !value.is_empty() {
            rest = value;
        } else if !is_known {
            done += &option[..2];
            rest = &option[2..];
        } else if let Some((_, rest_of_it)) = after.strip_prefix(" <").and_then(|value| value.split_once('>')) {
            done += &name.replace('-', "_");
            rest = rest_of_it;
        } else if FLAGS.contains(&name) {
            let _ = write!(done, "{name}=True");
            rest = after;
        } else if value.starts_with(|c: char| c.is_ascii_digit()) {
            let _ = write!(done, "{}=", name.replace('-', "_"));
            rest = value;
        } else if is_code && !value.is_empty() && !value.contains([' ', '\'', '<']) {
            let _ = write!(done, "{}='{value}'", name.replace('-', "_"));
            rest = "";
        } else {
            let _ = write!(done, "{}=", name.replace('-', "_"));
            rest = after;
        }
    }
    done + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_calls_and_options_are_arguments() {
        for (text, wanted) in [
            ("continue it with `stickslip resume runs/a`", "continue it with `stickslip.Run('runs/a').resume()`"),
            ("`stickslip verify 'a b'` writes it", "`stickslip.Run('a b').verify()` writes it"),
            ("`stickslip limit` finds it", "`stickslip.limit(...)` finds it"),
            (
                "Use --samples 1000, or choose another directory with --out",
                "Use samples=1000, or choose another directory with out=",
            ),
            ("replace it with --overwrite.", "replace it with overwrite=True."),
            ("submit it with `--out runs/a`", "submit it with `out='runs/a'`"),
            ("--cell 9: the run has cells 0 to 3", "cell=9: the run has cells 0 to 3"),
            ("a value '0' for '--threads <N>': no", "a value '0' for 'threads': no"),
            ("--set pad.mass: no", "pad.mass: no"),
            ("give --engine=slurm", "give --engine=slurm"),
            ("`stickslip merge a` writes it", "`stickslip merge a` writes it"),
            ("a file --- of none", "a file --- of none"),
            ("a `b` c `", "a `b` c `"),
        ] {
            assert_eq!(in_python(text), wanted);
        }
        assert_eq!(remedy_in_python("stickslip resume runs/a"), "stickslip.Run('runs/a').resume()");
        assert_eq!(remedy_in_python("--samples 1000"), "samples=1000");
        assert_eq!(remedy_in_python("--out"), "out=");
    }
}
