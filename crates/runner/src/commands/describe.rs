//! `schema`, `completions` and `man`: descriptions of the engine for other programs.

use clap::CommandFactory as _;

use crate::cli::{Cli, CompletionsArguments};
use crate::failure::Failure;
use crate::job::JobSpec;
use crate::output::result;

/// `stickslip schema`.
pub fn schema() -> Result<(), Failure> {
    let schema = schemars::schema_for!(JobSpec);
    result(&format!("{:#}\n", schema.as_value()))
}

/// `stickslip completions`.
pub fn completions(arguments: &CompletionsArguments) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut Cli::command(), "stickslip", &mut script);
    result(&String::from_utf8_lossy(&script))
}

/// `stickslip man`: the main page, then one for each command.
pub fn man() -> Result<(), Failure> {
    let mut page = Vec::new();
    // The page is the same whichever machine prints it.
    let mut command = Cli::command().long_version(None);
    command.build();
    let render = |command: clap::Command, page: &mut Vec<u8>| clap_mangen::Man::new(command).render(page);
    render(command.clone(), &mut page).map_err(|error| Failure::output(&error))?;
    for subcommand in command.get_subcommands().filter(|subcommand| subcommand.get_name() != "help") {
        render(subcommand.clone(), &mut page).map_err(|error| Failure::output(&error))?;
    }
    result(&String::from_utf8_lossy(&page))
}
