//! Failures of commands, with their messages and exit codes.

use std::fmt;
use std::io;
use std::path::Path;

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::low_level::signal_name;
use thiserror::Error;

use crate::shell::shown;

/// The signal that ended a command early, by its number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Signal(pub u8);

impl Signal {
    /// The exit code of a process that the signal ended.
    pub fn exit_code(self) -> u8 {
        self.0.saturating_add(128)
    }
}

impl fmt::Display for Signal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.0.into(), signal_name(self.0.into())) {
            (SIGINT, _) => f.write_str("interrupted"),
            (SIGTERM, _) => f.write_str("terminated"),
            (_, Some(name)) => write!(f, "ended by {name}"),
            (number, None) => write!(f, "ended by signal {number}"),
        }
    }
}

/// A failure of a command. Its text is the whole message to the user.
#[derive(Debug, Error)]
pub enum Failure {
    /// The command line is not valid.
    #[error("{0}")]
    Usage(String),
    /// The job spec is not valid, or differs from the run's.
    #[error("{0}")]
    Job(String),
    /// A file or directory cannot be created.
    #[error("{0}")]
    CannotCreate(String),
    /// Reading or writing failed.
    #[error("{0}")]
    InputOutput(String),
    /// The result is written, but its verdict map is wrong somewhere.
    #[error("{0}")]
    Audit(String),
    /// A mistake of the program itself.
    #[error("{0}")]
    Internal(String),
    /// Another process is working in the run directory.
    #[error("{0}")]
    Busy(String),
    /// A signal ended the run. Finished work is kept.
    #[error("{signal}; {message}")]
    Stopped {
        /// The signal.
        signal: Signal,
        /// What is kept, and how to continue.
        message: String,
    },
}

impl Failure {
    /// The exit code of the process.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Usage(_) => 64,
            Self::Job(_) => 65,
            Self::Audit(_) | Self::Internal(_) => 70,
            Self::CannotCreate(_) => 73,
            Self::InputOutput(_) => 74,
            Self::Busy(_) => 75,
            Self::Stopped { signal, .. } => signal.exit_code(),
        }
    }

    /// Adds to an I/O error how to continue with the work that is kept.
    pub fn with_remedy(self, remedy: &str) -> Self {
        match self {
            Self::InputOutput(message) => Self::InputOutput(format!("{message}; {remedy}")),
            other => other,
        }
    }

    /// A file could not be read.
    pub fn reading(path: &Path, error: impl fmt::Display) -> Self {
        Self::InputOutput(format!("cannot read {}: {error}", shown(path)))
    }

    /// A file could not be written.
    pub fn writing(path: &Path, error: impl fmt::Display) -> Self {
        Self::InputOutput(format!("cannot write {}: {error}", shown(path)))
    }

    /// A file or directory could not be created.
    pub fn creating(path: &Path, error: impl fmt::Display) -> Self {
        Self::CannotCreate(format!("cannot create {}: {error}", shown(path)))
    }

    /// A result could not be written to standard output.
    pub fn output(error: &io::Error) -> Self {
        Self::InputOutput(format!("cannot write to standard output: {error}"))
    }
}
