//! `stickslip`: the command line of the engine. It reads job specs, runs them on all threads, keeps run directories,
//! and reproduces the tables and figures of Sui & Ding (2018).
//!
//! Modules are declared in reading order; physics is in `stickslip-core`, statistics in `stickslip-sampler`.

mod shell;

mod messages;

mod memory;

mod failure;

mod output;

mod panics;

mod units;

mod spectrum;

mod unfinished;

mod interrupt;

mod files;

mod matrix_files;

mod version;

mod job;

mod evaluate;

mod store;

mod tables;

mod schedule;

mod picture;

mod plot;

mod report;

mod export;

mod target;

mod cli;

mod help;

mod commands;

mod reproduce;

use std::env;
use std::panic;
use std::process::ExitCode;

use clap::error::ErrorKind;

use crate::cli::Command;
use crate::failure::Failure;
use crate::interrupt::Interrupt;

fn main() -> ExitCode {
    panics::say_in_a_line();
    panic::catch_unwind(run).unwrap_or(ExitCode::from(panics::EXIT_CODE))
}

fn run() -> ExitCode {
    let cli = match help::typed() {
        Ok(cli) => cli,
        Err(error) => return no_command(&error),
    };
    messages::choose(cli.messages);
    match Interrupt::watch().and_then(|interrupt| dispatch(cli.command, &interrupt)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => fail(&failure),
    }
}

/// The end of a command line that asks for help or the version, or for something that does not exist.
fn no_command(error: &clap::Error) -> ExitCode {
    messages::choose(messages::form_of(env::args_os()));
    if let Some(failure) = cli::other_word(error) {
        return fail(&failure);
    }
    if matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) {
        return error.print().map_or_else(|error| fail(&Failure::output(&error)), |()| ExitCode::SUCCESS);
    }
    let said = error.to_string();
    let (text, advice) = said.trim_end().rsplit_once("\n\n").unwrap_or((&said, "stickslip --help"));
    let failure = Failure::Usage(text.trim_start_matches("error: ").to_owned()).remedied(advice);
    if messages::are_json() {
        return fail(&failure);
    }
    // In colours, where there are some. If it fails, nothing is left to report that to.
    let _ = error.print();
    ExitCode::from(failure.exit_code())
}

fn dispatch(command: Command, interrupt: &Interrupt) -> Result<(), Failure> {
    match command {
        Command::Init(arguments) => commands::init(&arguments),
        Command::Submit(arguments) if arguments.engine.engine.is_some() => {
            commands::submit_to_engine(&arguments, interrupt)
        }
        Command::Submit(arguments) => commands::submit(&arguments, interrupt),
        Command::Resume(arguments) => commands::resume(&arguments, interrupt),
        Command::Status(arguments) => commands::status(&arguments),
        Command::Check(arguments) => commands::check(&arguments),
        Command::Parameters(arguments) => commands::parameters(&arguments),
        Command::Analyse(arguments) => commands::analyse(&arguments),
        Command::Trajectory(arguments) => commands::trajectory(&arguments),
        Command::Replay(arguments) => commands::replay(&arguments),
        Command::Samples(arguments) => commands::samples(&arguments, interrupt),
        Command::Compare(arguments) => commands::compare(&arguments, interrupt),
        Command::Fit(arguments) => commands::fit(&arguments),
        Command::Limit(arguments) => commands::limit(&arguments, interrupt),
        Command::Plot(arguments) => commands::plot(&arguments, interrupt),
        Command::Report(arguments) => commands::report(&arguments, interrupt),
        Command::Export(arguments) => commands::export(&arguments),
        Command::Reduce(arguments) => commands::reduce(&arguments),
        Command::Reproduce(arguments) => reproduce::reproduce(&arguments, interrupt),
        Command::Merge(arguments) => commands::merge(&arguments, interrupt),
        Command::Verify(arguments) => commands::verify(&arguments),
        Command::Schema => commands::schema(),
        Command::Completions(arguments) => commands::completions(&arguments),
        Command::Man(arguments) => commands::man(&arguments),
    }
}

fn fail(failure: &Failure) -> ExitCode {
    // The tools of a shell do not complain of a reader that has seen enough either.
    if !failure.is_unread() {
        failure.message().send();
    }
    ExitCode::from(failure.exit_code())
}

#[cfg(test)]
mod any_model;
