//! The paper's tables and figures again, from the job specs in `jobs/`, and oscillators that others published.

mod preset;

mod comparison;

mod tables;

mod figures;

mod bifurcation;

mod spectrum;

mod motions;

mod score;

mod external;

mod scoreboard;

use std::path::PathBuf;

use clap::ValueEnum;

use crate::cli::ReproduceArguments;
use crate::commands::{FinishedRun, complete_run};
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::job::JobSource;
use crate::output::result;
use crate::target::Target;

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
    let run = run(target, arguments, interrupt)?;
    interrupt.advise("the same command goes on from there");
    let text = match (target, run) {
        (Target::Table2, Some(run)) => tables::table2(&run)?,
        (Target::Table3, Some(run)) => tables::table3(&run)?,
        (Target::Fig4, Some(run)) => figures::growth_rates(&run)?,
        (Target::Fig12 | Target::Fig13, Some(run)) => figures::scattered_input(&run)?,
        (_, Some(run)) => figures::surface(&run)?,
        (Target::Fig6, None) => bifurcation::diagram(&directory(target, arguments)?)?,
        (Target::External, None) => external::oscillators(&directory(target, arguments)?, arguments, interrupt)?,
        (Target::Scoreboard, None) => scoreboard::scoreboard()?,
        (_, None) => motions::figure(target, &directory(target, arguments)?)?,
    };
    result(&text)
}

/// The directory for the data of a target without a job.
fn directory(target: Target, arguments: &ReproduceArguments) -> Result<PathBuf, Failure> {
    let directory = arguments.out.join(target.name());
    std::fs::create_dir_all(&directory)
        .map_err(|error| Failure::CannotCreate(format!("cannot create {}: {error}", directory.display())))?;
    Ok(directory)
}

/// The finished run of a target's job, computed now or before.
fn run(target: Target, arguments: &ReproduceArguments, interrupt: &Interrupt) -> Result<Option<FinishedRun>, Failure> {
    let Some(text) = target.job() else { return Ok(None) };
    let name = target.name();
    let source = JobSource { path: PathBuf::from(format!("jobs/{name}.toml")), text: text.to_owned() };
    complete_run(&source, &arguments.out.join(name), arguments.threads.count(), interrupt).map(Some)
}
