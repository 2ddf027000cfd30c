//! Failures of commands, with their messages and exit codes.

use std::fmt;
use std::io;
use std::path::Path;

use signal_hook::consts::{SIGINT, SIGPIPE, SIGTERM};
use signal_hook::low_level::signal_name;
use thiserror::Error;

use crate::messages::{Code, Message, Place};
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
    /// Nobody reads standard output any more, as after `| head`.
    #[error("nobody reads standard output")]
    Unread,
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
    /// One of the others, with more for programs to read.
    #[error("{}", .0.failure)]
    Detailed(Box<Detailed>),
}

/// What a failure holds for programs beside its text.
#[derive(Debug)]
pub struct Detailed {
    failure: Failure,
    code: Option<Code>,
    place: Option<Place>,
    remedy: Option<String>,
}

/// What is said of work that ended early: what is kept of it, and mostly how to continue.
#[derive(Debug, Clone, Default)]
pub struct Advice {
    text: String,
    /// The command or action that the text names.
    remedy: Option<String>,
}

impl Advice {
    /// Words that end before a command.
    pub fn command(words: &str, command: &str) -> Self {
        Self { text: format!("{words} `{command}`"), remedy: Some(command.to_owned()) }
    }

    /// An action.
    pub fn action(action: &str) -> Self {
        Self { text: action.to_owned(), remedy: Some(action.to_owned()) }
    }

    /// The command or action that it names.
    pub fn remedy(&self) -> Option<&str> {
        self.remedy.as_deref()
    }
}

impl From<&str> for Advice {
    fn from(text: &str) -> Self {
        Self { text: text.to_owned(), remedy: None }
    }
}

impl fmt::Display for Advice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
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
            Self::Unread => Signal(SIGPIPE as u8).exit_code(),
            Self::Stopped { signal, .. } => signal.exit_code(),
            Self::Detailed(detailed) => detailed.failure.exit_code(),
        }
    }

    /// What it is about, unless that was set.
    fn code(&self) -> Code {
        match self {
            Self::Usage(_) => Code::Usage,
            Self::Job(_) => Code::JobRefused,
            Self::CannotCreate(_) => Code::CannotCreate,
            Self::InputOutput(_) | Self::Unread => Code::InputOutput,
            Self::Audit(_) => Code::Audit,
            Self::Internal(_) => Code::InternalError,
            Self::Busy(_) => Code::RunInUse,
            Self::Stopped { .. } => Code::Interrupted,
            Self::Detailed(detailed) => detailed.code.unwrap_or_else(|| detailed.failure.code()),
        }
    }

    /// Whether it is about the job, the run or data.
    pub fn is_of_job(&self) -> bool {
        self.exit_code() == 65
    }

    /// Whether another process is working in the run directory.
    pub fn is_in_use(&self) -> bool {
        self.exit_code() == 75
    }

    /// Whether a file or directory cannot be created.
    pub fn is_of_creating(&self) -> bool {
        self.exit_code() == 73
    }

    /// Whether nobody reads standard output any more.
    pub fn is_unread(&self) -> bool {
        matches!(self, Self::Unread)
    }

    /// The message of it.
    pub fn message(&self) -> Message {
        let mut message = Message::new(self.code(), &self.to_string());
        if let Self::Detailed(detailed) = self {
            message.place.clone_from(&detailed.place);
            message.remedy.clone_from(&detailed.remedy);
        }
        message
    }

    /// A signal ended the run; `kept` says how to continue.
    pub fn stopped(signal: Signal, kept: &Advice) -> Self {
        Self::Stopped { signal, message: kept.text.clone() }.advised(kept)
    }

    fn detailed(self) -> Box<Detailed> {
        match self {
            Self::Detailed(detailed) => detailed,
            failure => Box::new(Detailed { failure, code: None, place: None, remedy: None }),
        }
    }

    /// Sets the code, for programs.
    pub fn coded(self, code: Code) -> Self {
        Self::Detailed(Box::new(Detailed { code: Some(code), ..*self.detailed() }))
    }

    /// Sets the place, for programs.
    pub fn at(self, place: Place) -> Self {
        Self::Detailed(Box::new(Detailed { place: Some(place), ..*self.detailed() }))
    }

    /// Sets the remedy for programs: the command or action that its text names.
    pub fn remedied(self, remedy: impl Into<String>) -> Self {
        Self::Detailed(Box::new(Detailed { remedy: Some(remedy.into()), ..*self.detailed() }))
    }

    /// Sets the remedy for programs: the command or action of an advice that its text holds.
    fn advised(self, advice: &Advice) -> Self {
        match advice.remedy() {
            Some(remedy) => self.remedied(remedy),
            None => self,
        }
    }

    /// Adds to an I/O error how to continue with the work that is kept.
    pub fn with_advice(self, advice: &Advice) -> Self {
        match self {
            Self::InputOutput(message) => Self::InputOutput(format!("{message}; {advice}")).advised(advice),
            Self::Detailed(detailed) => {
                let Detailed { failure, code, place, remedy } = *detailed;
                let inner = failure.with_advice(advice).detailed();
                Self::Detailed(Box::new(Detailed { code, place, remedy: inner.remedy.or(remedy), ..*inner }))
            }
            other => other,
        }
    }

    /// A file could not be read.
    pub fn reading(path: &Path, error: impl fmt::Display) -> Self {
        Self::InputOutput(format!("cannot read {}: {error}", shown(path))).at(Place::file(path))
    }

    /// A file could not be written.
    pub fn writing(path: &Path, error: impl fmt::Display) -> Self {
        Self::InputOutput(format!("cannot write {}: {error}", shown(path))).at(Place::file(path))
    }

    /// A file or directory could not be created.
    pub fn creating(path: &Path, error: impl fmt::Display) -> Self {
        Self::CannotCreate(format!("cannot create {}: {error}", shown(path))).at(Place::file(path))
    }

    /// A result could not be written to standard output.
    pub fn output(error: &io::Error) -> Self {
        if error.kind() == io::ErrorKind::BrokenPipe {
            return Self::Unread;
        }
        Self::InputOutput(format!("cannot write to standard output: {error}"))
    }
}
