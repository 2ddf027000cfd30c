//! `schema`, `completions` and `man`: descriptions of the engine for other programs.

use std::fs;

use clap::builder::PossibleValuesParser;
use clap_complete::Shell;

use super::parameters;
use super::shipped_jobs::SHIPPED;
use crate::cli::{CompletionsArguments, ManArguments};
use crate::failure::Failure;
use crate::files::publish::publish;
use crate::help;
use crate::job;
use crate::output::{quoted, result, shown};

/// `stickslip schema`.
pub fn schema() -> Result<(), Failure> {
    result(&format!("{:#}\n", job::schema().as_value()))
}

/// `stickslip completions`.
pub fn completions(arguments: &CompletionsArguments) -> Result<(), Failure> {
    let mut command = help::command();
    // Any text is taken, such as the parameters of a model given by matrices; these keys are offered.
    let keys: Vec<&'static str> = parameters::keys().map(|key| &*format!("{key}=").leak()).collect();
    for name in ["analyse", "trajectory", "parameters"] {
        let offered = PossibleValuesParser::new(keys.clone());
        command = command.mut_subcommand(name, |command| command.mut_arg("set", |set| set.value_parser(offered)));
    }
    let jobs = PossibleValuesParser::new(SHIPPED.iter().map(|job| job.name));
    command = command.mut_subcommand("init", |command| command.mut_arg("from", |from| from.value_parser(jobs)));
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut command, "stickslip", &mut script);
    let script = String::from_utf8_lossy(&script).into_owned();
    result(&match arguments.shell {
        // The value follows without a space.
        Shell::Bash => script.replace("--set)\n", "--set)\n                    compopt -o nospace 2> /dev/null\n"),
        Shell::Zsh => script.lines().map(without_space).collect(),
        _ => script,
    })
}

/// A line of a script for zsh, after whose keys no space follows: they are added by a command, not as a list.
fn without_space(line: &str) -> String {
    match line.split_once(":KEY=VALUE:(").and_then(|(before, rest)| Some((before, rest.split_once(')')?))) {
        Some((before, (keys, after))) => format!("{before}:KEY=VALUE:compadd -S \"\" -- {keys}{after}\n"),
        None => format!("{line}\n"),
    }
}

/// `stickslip man`: the main page, then one for each command, in one text or in files of their own.
pub fn man(arguments: &ManArguments) -> Result<(), Failure> {
    // The pages are the same whichever machine makes them.
    let mut command = help::command().long_version(None).disable_help_subcommand(true);
    command.build();
    let source = format!("stickslip {}", command.get_version().unwrap_or_default());
    let examples = format!(".SH EXTRA\n{}", help::EXAMPLES);
    let page = |command: &clap::Command| {
        let man = clap_mangen::Man::new(command.clone()).source(source.clone()).manual("stickslip");
        let mut text: Vec<u8> = Vec::new();
        man.render(&mut text).map_err(|error| Failure::output(&error))?;
        // What follows the options has one name for whatever it is.
        let text = String::from_utf8_lossy(&text).replace(&examples, ".SH EXAMPLES\n");
        let text = text.replace(".SH EXTRA\n", ".SH \"EXIT STATUS\"\n");
        Ok((man.get_filename(), text))
    };
    let mut pages = vec![page(&command)?];
    for subcommand in command.get_subcommands() {
        pages.push(page(subcommand)?);
    }
    let Some(folder) = &arguments.out else {
        let text: String = pages.into_iter().map(|(_, text)| text).collect();
        return result(&text);
    };
    fs::create_dir_all(folder).map_err(|error| Failure::creating(folder, error))?;
    for (name, text) in &pages {
        publish(folder, name, text.as_bytes())?;
    }
    result(&format!(
        "Wrote {} pages to {}; read one: man -l {}\n",
        pages.len(),
        shown(folder),
        quoted(&folder.join("stickslip.1"))
    ))
}
