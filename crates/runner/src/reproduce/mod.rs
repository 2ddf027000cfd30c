//! The paper's tables and figures again, from the job specs in `jobs/`.

mod preset;

mod part;

mod comparison;

mod tables;

mod figures;

mod scatter;

mod bifurcation;

mod motions;

mod spectra;

mod score;

mod scoreboard;

mod printed;

mod gallery;

use std::path::PathBuf;

use clap::ValueEnum;

use self::gallery::Section;
use self::part::{Part, figure};
use crate::cli::ReproduceArguments;
use crate::commands::{FinishedRun, complete_run};
use crate::failure::Failure;
use crate::files::publish::publish;
use crate::interrupt::Interrupt;
use crate::job::JobSource;
use crate::output::result;
use crate::plot::svg::svg;
use crate::target::Target;

/// Width of figures, two columns of a paper: 174 mm in pixels.
const WIDTH: f64 = 174.0 / 25.4 * 96.0;

/// `stickslip reproduce`.
pub fn reproduce(arguments: &ReproduceArguments, interrupt: &Interrupt) -> Result<(), Failure> {
    let mut targets: Vec<Target> = Vec::new();
    for &target in &arguments.targets {
        let named = if target == Target::All { Target::value_variants() } else { &[target][..] };
        for &target in named.iter().filter(|target| **target != Target::All) {
            if !targets.contains(&target) {
                targets.push(target);
            }
        }
    }
    let mut sections = Vec::new();
    for (index, &target) in targets.iter().enumerate() {
        if targets.len() > 1 {
            let gap = if index == 0 { "" } else { "\n" };
            result(&format!("{gap}==== {} ====\n\n", target.name()))?;
        }
        sections.push(one(target, arguments, interrupt)?);
        if let (Some(signal), true) = (interrupt.signal(), index + 1 < targets.len()) {
            let kept = format!("finished up to {}; the same command goes on from there", target.name());
            return Err(Failure::stopped(signal, &kept.as_str().into()));
        }
    }
    if arguments.report {
        publish(&arguments.out, "gallery.html", gallery::page(&sections)?.as_bytes())?;
        result(&format!("\ngallery: {}\n", arguments.out.join("gallery.html").display()))?;
    }
    Ok(())
}

/// Reproduces one target: prints it, and writes its data and its figure.
fn one(target: Target, arguments: &ReproduceArguments, interrupt: &Interrupt) -> Result<Section, Failure> {
    let run = run(target, arguments, interrupt)?;
    interrupt.remark("finished runs are kept; the same command goes on from there");
    let directory = arguments.out.join(target.name());
    std::fs::create_dir_all(&directory)
        .map_err(|error| Failure::CannotCreate(format!("cannot create {}: {error}", directory.display())))?;
    let parts = match (target, run) {
        (Target::Table2, Some(run)) => tables::table2(&run)?,
        (Target::Table3, Some(run)) => tables::table3(&run)?,
        (Target::Fig4, Some(run)) => figures::growth_rates(&run)?,
        (Target::Fig12 | Target::Fig13, Some(run)) => scatter::scattered_input(&run)?,
        (_, Some(run)) => figures::surface(&run)?,
        (Target::Fig6, None) => bifurcation::diagram(&directory)?,
        (Target::Scoreboard, None) => scoreboard::scoreboard()?,
        (Target::Fig10 | Target::Fig11, None) => spectra::figure(target, &directory)?,
        (_, None) => motions::figure(target, &directory)?,
    };
    let mut text: String = parts.iter().map(Part::shown).collect();
    if let Some(figure) = figure(&parts, WIDTH)? {
        let name = format!("{}.svg", target.name());
        publish(&directory, &name, svg(&figure).as_bytes())?;
        text += &format!("figure: {}\n", directory.join(name).display());
    }
    result(&text)?;
    Ok(Section { target, parts })
}

/// The finished run of a target's job, computed now or before.
fn run(target: Target, arguments: &ReproduceArguments, interrupt: &Interrupt) -> Result<Option<FinishedRun>, Failure> {
    let Some(text) = target.job() else { return Ok(None) };
    let name = target.name();
    let source = JobSource { path: PathBuf::from(format!("jobs/{name}.toml")), text: text.to_owned() };
    complete_run(&source, &arguments.out.join(name), arguments.threads.count(), interrupt).map(Some)
}
