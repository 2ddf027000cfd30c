//! The paper's tables and figures again, from the job specs in `jobs/`.

mod comparison;
mod figures;
mod scoreboard;
mod tables;

use std::path::PathBuf;

use clap::ValueEnum;

use crate::cli::ReproduceArguments;
use crate::commands::{FinishedRun, complete_run};
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::job::JobSource;
use crate::output::result;

/// What can be reproduced.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Target {
    /// Ten preloads (the paper's numbers are lost, its range is not)
    Table2,
    /// Ten static friction coefficients, four scatters
    Table3,
    /// Growth rate against rotating speed for three preloads
    Fig4,
    /// Random preload: distribution of input and instability
    Fig12,
    /// Random static friction, four scatters
    Fig13,
    /// Surface at 15 rad/s
    Fig14a,
    /// Surface at 10 rad/s
    Fig14c,
    /// Surface at 20 rad/s
    Fig14d,
    /// Surface at 15 rad/s, standard deviation 0.1
    Fig15a,
    /// Surface at 15 rad/s, standard deviation 0.3
    Fig15b,
    /// Every number printed in the paper against ours
    Scoreboard,
    /// All of the above
    All,
}

impl Target {
    fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }

    /// The job spec behind a target, if it has one.
    fn job(self) -> Option<&'static str> {
        match self {
            Self::Table2 => Some(include_str!("../../../../jobs/table2.toml")),
            Self::Table3 => Some(include_str!("../../../../jobs/table3.toml")),
            Self::Fig4 => Some(include_str!("../../../../jobs/fig4.toml")),
            Self::Fig12 => Some(include_str!("../../../../jobs/fig12.toml")),
            Self::Fig13 => Some(include_str!("../../../../jobs/fig13.toml")),
            Self::Fig14a => Some(include_str!("../../../../jobs/fig14a.toml")),
            Self::Fig14c => Some(include_str!("../../../../jobs/fig14c.toml")),
            Self::Fig14d => Some(include_str!("../../../../jobs/fig14d.toml")),
            Self::Fig15a => Some(include_str!("../../../../jobs/fig15a.toml")),
            Self::Fig15b => Some(include_str!("../../../../jobs/fig15b.toml")),
            Self::Scoreboard | Self::All => None,
        }
    }
}

/// `stickslip reproduce`.
pub fn reproduce(arguments: &ReproduceArguments, interrupt: &Interrupt) -> Result<(), Failure> {
    if arguments.target != Target::All {
        return one(arguments.target, arguments, interrupt);
    }
    for (index, &target) in Target::value_variants().iter().filter(|target| **target != Target::All).enumerate() {
        let gap = if index == 0 { "" } else { "\n" };
        result(&format!("{gap}==== {} ====\n\n", target.name()))?;
        one(target, arguments, interrupt)?;
        if let Some(signal) = interrupt.signal() {
            let message = format!("finished up to {}; the same command goes on from there", target.name());
            return Err(Failure::Stopped { signal, message });
        }
    }
    Ok(())
}

fn one(target: Target, arguments: &ReproduceArguments, interrupt: &Interrupt) -> Result<(), Failure> {
    let text = match run(target, arguments, interrupt)? {
        None => scoreboard::scoreboard()?,
        Some(run) => match target {
            Target::Table2 => tables::table2(&run)?,
            Target::Table3 => tables::table3(&run)?,
            Target::Fig4 => figures::growth_rates(&run)?,
            Target::Fig12 | Target::Fig13 => figures::scattered_input(&run)?,
            _ => figures::surface(&run)?,
        },
    };
    result(&text)
}

/// The finished run of a target's job, computed now or before.
fn run(target: Target, arguments: &ReproduceArguments, interrupt: &Interrupt) -> Result<Option<FinishedRun>, Failure> {
    let Some(text) = target.job() else { return Ok(None) };
    let name = target.name();
    let source = JobSource { path: PathBuf::from(format!("jobs/{name}.toml")), text: text.to_owned() };
    complete_run(&source, &arguments.out.join(name), arguments.threads.count(), interrupt).map(Some)
}
