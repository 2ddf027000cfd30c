//! The pages of help: the commands in groups, and an example on the page of each.

use std::env;
use std::fmt::Write as _;

use clap::error::ErrorKind;
use clap::{Command, CommandFactory as _, FromArgMatches as _};

use crate::cli::Cli;

/// The line above the examples of a command.
pub const EXAMPLES: &str = "Examples:\n";

/// What is said where no command is given.
const FIRST_STEPS: &str = "there is no command. To begin:\n  \
    stickslip init --from fig14a    writes a job that comes with the program\n  \
    stickslip submit fig14a.toml    runs it, and says the answer\n  \
    stickslip report runs/fig14a    writes a page about it, to open in a browser\n  \
    stickslip help                  lists all commands";

/// A command, and how it is typed.
type Shown = (&'static str, &'static [&'static str]);

/// All commands, by what they are for.
static GROUPS: [(&str, &[Shown]); 5] = [
    (
        "Run a job",
        &[
            ("init", &["stickslip init --list", "stickslip init --from fig14a", "stickslip init my-brake.toml"]),
            ("check", &["stickslip check fig14a.toml", "stickslip check --all fig14a.toml"]),
            (
                "submit",
                &[
                    "stickslip submit fig14a.toml",
                    "stickslip submit fig14a.toml --samples 1e6 --threads 4",
                    "stickslip submit fig14a.toml --engine slurm --shards 60 -- --time=2:00:00",
                ],
            ),
            ("resume", &["stickslip resume runs/fig14a"]),
            ("status", &["stickslip status", "stickslip status runs/fig14a --json"]),
            ("merge", &["stickslip merge runs/fig14a"]),
            ("reduce", &["stickslip reduce own-brake.toml --vectors 120"]),
        ],
    ),
    (
        "Look at the result",
        &[
            (
                "plot",
                &[
                    "stickslip plot runs/fig14a",
                    "stickslip plot runs/fig14a --columns 1 --out fig14a.pdf",
                    "stickslip plot fig14a.toml --of inputs",
                ],
            ),
            ("report", &["stickslip report runs/fig14a"]),
            ("export", &["stickslip export runs/fig14a --format csv"]),
            (
                "samples",
                &[
                    "stickslip samples runs/fig14a --cell 390",
                    "stickslip samples runs/fig14a --cell 390 --csv > samples.csv",
                ],
            ),
        ],
    ),
    (
        "Ask",
        &[
            ("limit", &["stickslip limit belt-oscillator.toml --of belt_speed --probability 0.01"]),
            ("compare", &["stickslip compare runs/fig14a runs/fig14b"]),
            ("fit", &["stickslip fit tests.csv --job brake.toml --out fitted.toml"]),
        ],
    ),
    (
        "Understand one brake",
        &[
            (
                "analyse",
                &["stickslip analyse --set operating_point.rotating_speed=12", "stickslip analyse hulten.toml"],
            ),
            ("trajectory", &["stickslip trajectory --disc rigid --out motion.parquet"]),
            ("replay", &["stickslip replay runs/fig14a --cell 390 --sample 0"]),
            ("parameters", &["stickslip parameters --set pad.mass=0.2"]),
            ("reproduce", &["stickslip reproduce table3 fig4 --report"]),
        ],
    ),
    (
        "Keep and set up",
        &[
            ("verify", &["stickslip verify runs/fig14a"]),
            ("schema", &["stickslip schema > stickslip.schema.json"]),
            ("completions", &["stickslip completions bash > stickslip.bash"]),
            ("man", &["stickslip man --out man1"]),
        ],
    ),
];

/// The commands of all groups.
fn all() -> impl Iterator<Item = &'static Shown> {
    GROUPS.iter().flat_map(|(_, commands)| *commands)
}

/// The command line with its pages of help.
pub fn command() -> Command {
    let command = Cli::command().mut_subcommands(|command| {
        let examples = all().find(|(name, _)| *name == command.get_name()).map_or(&[][..], |(_, examples)| *examples);
        let lines = examples.iter().fold(EXAMPLES.to_owned(), |lines, example| format!("{lines}  {example}\n"));
        command.after_help(lines.trim_end().to_owned())
    });
    let page = page(&command);
    command.help_template(page)
}

/// The page of the program: its commands in groups, where clap knows one list.
fn page(command: &Command) -> String {
    let (header, literal) = (*command.get_styles().get_header(), *command.get_styles().get_literal());
    let width = all().map(|(name, _)| name.len()).max().unwrap_or_default();
    let mut page = "{about-with-newline}\n{usage-heading} {usage}\n".to_owned();
    for (heading, commands) in &GROUPS {
        // Writing to a string cannot fail.
        let _ = writeln!(page, "\n{header}{heading}:{header:#}");
        for (name, _) in *commands {
            let about = command.find_subcommand(name).and_then(Command::get_about);
            let about = about.map(ToString::to_string).unwrap_or_default();
            let _ = writeln!(page, "  {literal}{name:width$}{literal:#}  {about}");
        }
    }
    let _ = write!(page, "\n{header}Options:{header:#}\n{{options}}{{after-help}}");
    page
}

/// What was typed.
pub fn typed() -> Result<Cli, clap::Error> {
    let mut line = command();
    let mut matches = line.try_get_matches_from_mut(env::args_os()).map_err(|error| match error.kind() {
        ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand | ErrorKind::MissingSubcommand => {
            command().error(ErrorKind::MissingSubcommand, FIRST_STEPS)
        }
        _ => error,
    })?;
    Cli::from_arg_matches_mut(&mut matches).map_err(|error| error.format(&mut line))
}

#[cfg(test)]
mod tests {
    use clap::Parser as _;

    use super::*;

    #[test]
    fn every_command_is_in_one_group_with_examples_that_can_be_typed() {
        let command = command();
        let mut grouped: Vec<&str> = all().map(|(name, _)| *name).collect();
        let mut commands: Vec<&str> = command.get_subcommands().map(Command::get_name).collect();
        grouped.sort_unstable();
        commands.sort_unstable();
        assert_eq!(grouped, commands);
        for (name, examples) in all() {
            assert!(!examples.is_empty(), "{name}");
            for example in *examples {
                assert!(example.starts_with(&format!("stickslip {name}")), "{example}");
                assert!(example.len() <= 78, "{example}");
                let words = example.split(" > ").next().unwrap().split(' ');
                Cli::try_parse_from(words).unwrap_or_else(|error| panic!("{example}: {error}"));
            }
        }
    }

    #[test]
    fn every_option_says_what_it_does() {
        let program = command();
        for command in program.get_subcommands().chain([&program]) {
            for option in command.get_arguments() {
                let help = option.get_help().map(ToString::to_string).unwrap_or_default();
                assert!(!help.is_empty(), "{} {}", command.get_name(), option.get_id());
            }
        }
    }

    #[test]
    fn the_page_fits_a_terminal_and_names_every_command_once() {
        let help = command().render_help().to_string();
        let listed: Vec<&str> = help.lines().take_while(|line| *line != "Options:").collect();
        assert!(listed.iter().all(|line| line.chars().count() <= 80), "{help}");
        for (name, _) in all() {
            let row = format!("  {name} ");
            assert_eq!(listed.iter().filter(|line| line.starts_with(&row)).count(), 1, "{name}: {help}");
        }
        assert!(FIRST_STEPS.lines().all(|line| line.len() <= 80));
    }

    #[test]
    fn a_page_begins_with_its_command_and_ends_with_examples() {
        let mut command = command();
        command.build();
        let submit = command.find_subcommand_mut("submit").unwrap().render_help().to_string();
        let at = |text: &str| submit.find(text).unwrap_or_else(|| panic!("{text}: {submit}"));
        let places = ["--out", "--messages", "--help", "Examples:"].map(at);
        assert!(places.is_sorted(), "{places:?} {submit}");
        assert!(submit.contains("\n  stickslip submit fig14a.toml\n"), "{submit}");
    }
}
