//! Messages: everything on standard error, as lines for people, or with `--messages json` as one JSON object a line for
//! programs. Only this module knows which.

use std::ffi::{OsStr, OsString};
use std::io::{self, IsTerminal as _, Write as _};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use clap::ValueEnum;
use serde::{Serialize, Serializer};

use crate::shell::{shown, without_controls};

/// The form that messages take.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Form {
    /// Lines for people
    Text,
    /// One JSON object a line, for programs
    Json,
}

/// Whether the form is JSON.
static IS_JSON: AtomicBool = AtomicBool::new(false);

/// Chooses the form of all messages from now on.
pub fn choose(form: Form) {
    IS_JSON.store(form == Form::Json, Ordering::Relaxed);
}

/// Whether messages are JSON.
pub fn are_json() -> bool {
    IS_JSON.load(Ordering::Relaxed)
}

/// The form that the words of a command line ask for which cannot be parsed.
pub fn form_of(words: impl Iterator<Item = OsString>) -> Form {
    let options: Vec<OsString> = words.take_while(|word| word != "--").collect();
    let is_json = options.contains(&OsString::from("--messages=json"))
        || options.windows(2).any(|pair| pair == [OsStr::new("--messages"), OsStr::new("json")]);
    if is_json { Form::Json } else { Form::Text }
}

/// Declares the codes with their names. docs/reference/command-line.md says what they mean.
macro_rules! codes {
    ($($code:ident $name:literal,)*) => {
        /// What a message is about. Programs decide by it, so a name never changes.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum Code {
            $(#[doc = $name] $code,)*
        }

        impl Code {
            /// All of them, in the order of the documentation.
            #[cfg(test)]
            const ALL: &[Self] = &[$(Self::$code,)*];

            /// The name, as programs get it.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$code => $name,)*
                }
            }
        }
    };
}

codes! {
    Progress "progress",
    Note "note",
    Warning "warning",
    FileWritten "file-written",
    RunFinished "run-finished",
    RunApart "run-apart",
    Interrupting "interrupting",
    Usage "usage",
    JobSpec "job-spec",
    JobDiffers "job-differs",
    RunHasMore "run-has-more",
    JobRefused "job-refused",
    OtherVersion "other-version",
    Incomplete "incomplete",
    Audit "audit",
    InternalError "internal-error",
    CannotCreate "cannot-create",
    RunUnfinished "run-unfinished",
    RunToExtend "run-to-extend",
    InputOutput "input-output",
    NoRun "no-run",
    Damaged "damaged",
    RunInUse "run-in-use",
    Interrupted "interrupted",
}

impl Serialize for Code {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

/// What a message is about: a place in a file, or a file. What is not known is left out.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct Place {
    /// The file; none for standard input.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// The line, from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub line: Option<u64>,
    /// The character in the line, from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub column: Option<u64>,
    /// The key of a job spec.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub key: Option<String>,
}

impl Place {
    /// A file.
    pub fn file(path: &Path) -> Self {
        Self { file: Some(shown(path)), ..Self::default() }
    }

    /// A line of a file.
    pub fn line(path: &Path, line: u64) -> Self {
        Self { line: Some(line), ..Self::file(path) }
    }
}

/// How far a computation is, in numbers.
#[derive(Debug, Clone, Serialize)]
pub struct Numbers {
    /// Units that are done, and all of them as far as it is known.
    pub done: u64,
    pub total: u64,
    /// Whether the total is `known`, `expected`, or `at-least` that.
    pub total_is: &'static str,
    /// What is counted.
    pub unit: &'static str,
    /// Units in a second.
    pub rate: f64,
    /// Seconds that the rest takes; none while that is not known.
    pub seconds_left: Option<f64>,
}

/// One message.
#[derive(Debug, Serialize)]
pub struct Message {
    /// What it is about.
    pub code: Code,
    /// The words.
    pub text: String,
    /// Where.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub place: Option<Place>,
    /// The command or action that helps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub remedy: Option<String>,
    /// How far the computation is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub progress: Option<Numbers>,
}

impl Message {
    /// A message of words alone. What would move the cursor or change colours, such as in the name of a file, is shown
    /// as text.
    pub fn new(code: Code, text: &str) -> Self {
        Self { code, text: without_controls(text), place: None, remedy: None, progress: None }
    }

    /// Writes it to standard error as a whole, so that messages of several processes do not mix. Errors are ignored, as
    /// there is no other place to report them.
    pub fn send(&self) {
        self.send_after("");
    }

    /// Writes it where a progress bar may be.
    pub fn send_over_bar(&self) {
        self.send_after(if io::stderr().is_terminal() { "\r\x1b[2K" } else { "" });
    }

    fn send_after(&self, before: &str) {
        let line = if are_json() {
            // It has nothing that JSON cannot hold.
            serde_json::to_string(self).unwrap_or_default() + "\n"
        } else {
            let kind = if self.code == Code::Warning { "warning: " } else { "" };
            format!("{before}stickslip: {kind}{}\n", self.text)
        };
        let _ = io::stderr().lock().write_all(line.as_bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_documentation_has_every_code_in_order() {
        let page = include_str!("../../../docs/reference/command-line.md");
        let (_, table) = page.split_once("| `code`, exit code |").unwrap();
        let rows = table.lines().skip(2).map_while(|row| row.strip_prefix("| `")?.split_once('`'));
        let documented: Vec<&str> = rows.map(|(name, _)| name).collect();
        let names: Vec<&str> = Code::ALL.iter().map(|code| code.name()).collect();
        assert_eq!(documented, names);
    }

    #[test]
    fn the_form_is_found_in_a_command_line_that_is_wrong() {
        let form = |words: &str| form_of(words.split(' ').map(OsString::from));
        assert_eq!(form("stickslip --messages json submit --thread"), Form::Json);
        assert_eq!(form("stickslip submit x --messages=json"), Form::Json);
        assert_eq!(form("stickslip submit --messages text json"), Form::Text);
        assert_eq!(form("stickslip submit -- --messages=json"), Form::Text);
    }
}
