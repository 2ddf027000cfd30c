//! Words that people try as commands, and the command that does what they mean.

use clap::error::{ContextKind, ContextValue};

use crate::failure::Failure;

/// Words, a command in place of them, and what that does. A word like the name of a command is found by clap.
const MEANT: [(&[&str], &str, &str); 8] = [
    (&["run", "start", "execute", "compute", "simulate"], "submit JOB.toml", "runs a job"),
    (&["continue", "restart"], "resume RUN_DIR", "continues a run"),
    (&["validate", "lint", "estimate", "cost"], "check JOB.toml", "validates a job and says what it will cost"),
    (&["list", "ls", "show", "progress"], "status", "shows the runs of a folder"),
    (
        &["new", "create", "example", "examples"],
        "init",
        "writes a job to start from; with --list it lists further ones",
    ),
    (&["draw", "graph", "figure"], "plot RUN_DIR", "draws the result of a run"),
    (&["csv", "convert"], "export RUN_DIR --format csv", "writes the result of a run for other programs"),
    (&["join"], "merge RUN_DIR", "writes the result of a run from its shards"),
];

/// The answer to a command line whose command is such a word.
pub fn other_word(error: &clap::Error) -> Option<Failure> {
    let Some(ContextValue::String(word)) = error.get(ContextKind::InvalidSubcommand) else { return None };
    let (_, command, does) = MEANT.iter().find(|(words, ..)| words.contains(&word.as_str()))?;
    let command = format!("stickslip {command}");
    Some(Failure::Usage(format!("there is no command `{word}`; `{command}` {does}")).remedied(command))
}
