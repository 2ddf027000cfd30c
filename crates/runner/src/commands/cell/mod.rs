//! What there is to see of one cell of a job, before a run or after it: its inputs, its samples, how its estimate converges,
//! and the distribution of what is recorded.

use std::path::{Path, PathBuf};

use crate::cli::{PlotArguments, PlotQuantity};
use crate::evaluate::evaluator::Evaluator;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::job::Job;
use crate::output::note;
use crate::picture::title::title;
use crate::picture::view::GridView;
use crate::plot::canvas::Canvas;
use crate::plot::scatter::Value;
use crate::report::{PICTURE_WIDTH, Picture, PictureKind};

use super::drawn_samples::{Add, DrawnSamples, draw};
use super::one_brake::{cell_of, middle};
use stickslip_core::model::IsStopped;
use stickslip_core::model::quantity::Quantity;
use stickslip_sampler::grid::Cell;

mod inputs;

mod samples;

mod convergence;

mod distribution;

/// Samples that are looked at one by one, and those of models whose samples take long.
const SAMPLES: u64 = 2000;
const FEW_SAMPLES: u64 = 200;

/// Samples of a unit of work.
const UNIT_SAMPLES: u64 = 50;

/// The figure, and where it is written if no file is given, without an extension.
///
/// # Errors
/// As the pictures themselves.
pub fn figure(arguments: &PlotArguments, width: f64, interrupt: &Interrupt) -> Result<(Canvas, PathBuf), Failure> {
    let path = arguments.run.as_path();
    if let (PlotQuantity::Distribution, None) = (arguments.of, arguments.cell) {
        let curves = distribution::along(path, arguments.result.as_deref(), arguments.title.clone(), width)?;
        if let Some((canvas, name)) = curves {
            return Ok((canvas, beside(path, &name)));
        }
        note(format_args!("quantiles make curves over one long axis; here the histogram of one cell is drawn"));
    }
    let (job, cell) = cell_of(path, arguments.cell)?;
    let (canvas, name) = match arguments.of {
        PlotQuantity::Samples => {
            let mut plot = samples::scatter(&job, &cell, arguments, interrupt)?;
            titled(&mut plot.title, arguments);
            (plot.figure(width), "samples".to_owned())
        }
        PlotQuantity::Convergence => {
            let mut plot = convergence::convergence(path, &job, &cell, arguments, interrupt)?;
            titled(&mut plot.title, arguments);
            (plot.figure(width), "convergence".to_owned())
        }
        PlotQuantity::Distribution => {
            let recorded = distribution::RecordedCell::read(path, &job, &cell)?;
            let (mut plot, name) = recorded.plot(arguments.result.as_deref())?;
            titled(&mut plot.heading, arguments);
            (plot.figure(width), name)
        }
        _ => (inputs::inputs(&job, &cell)?.figure(width), "inputs".to_owned()),
    };
    Ok((canvas, beside(path, &name)))
}

/// The pictures of a finished run in its report: the inputs of the cell in the middle of its axes, and what is recorded.
///
/// # Errors
/// A run that cannot be read.
pub fn pictures(job: &Job, path: &Path) -> Result<Vec<Picture>, Failure> {
    let cell = job.grid.cell(middle(job));
    let mut pictures = Vec::new();
    let mut add = |kind: PictureKind, figure: Result<Canvas, Failure>| {
        match figure {
            Ok(canvas) => pictures.push(Picture { kind, canvas }),
            Err(why) if why.is_of_job() => note(format_args!("the report leaves a picture out: {why}")),
            Err(why) => return Err(why),
        }
        Ok(())
    };
    if !job.random.scatters_nothing() {
        add(PictureKind::Inputs, inputs::inputs(job, &cell).map(|plot| plot.figure(PICTURE_WIDTH)))?;
    }
    let mut recorded = None;
    for result in job.model().recorded() {
        let name = Some(result.name);
        let figure = match distribution::along(path, name, None, PICTURE_WIDTH) {
            Ok(Some((canvas, _))) => Ok(canvas),
            Ok(None) => {
                let recorded = match &recorded {
                    Some(recorded) => recorded,
                    None => recorded.insert(distribution::RecordedCell::read(path, job, &cell)?),
                };
                recorded.plot(name).map(|(plot, _)| plot.figure(PICTURE_WIDTH))
            }
            Err(why) => Err(why),
        };
        add(PictureKind::Distributions, figure)?;
    }
    Ok(pictures)
}

/// Replaces what stands above a figure by the title that is asked for.
fn titled(heading: &mut String, arguments: &PlotArguments) {
    if let Some(title) = &arguments.title {
        heading.clone_from(title);
    }
}

/// The file of a picture of a run, or of a job beside its file, without an extension.
pub fn beside(path: &Path, name: &str) -> PathBuf {
    if path.is_dir() {
        return path.join(name);
    }
    let job = path.file_stem().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{job}-{name}"))
}

/// Refuses a cell in which nothing scatters.
fn require_scatter(job: &Job, cell: &Cell) -> Result<(), Failure> {
    if (0..job.random.inputs.len()).any(|input| job.std(input, cell) != 0.0) {
        return Ok(());
    }
    Err(Failure::Job(format!(
        "nothing scatters in cell {} of \"{}\", so that all its samples are one: name inputs in random.inputs and give them a relative_std, or choose another cell with --cell",
        cell.index, job.name
    )))
}

/// The first samples of a cell, drawn at random, with their decisions.
fn first_samples(
    job: &Job,
    cell: u64,
    samples: u64,
    threads: usize,
    interrupt: &Interrupt,
) -> Result<DrawnSamples, Failure> {
    let evaluator = Evaluator::new(job)?;
    let units: Vec<u64> = (0..samples).step_by(UNIT_SAMPLES as usize).collect();
    let of_unit = |&first: &u64, is_stopped: IsStopped<'_>, add: Add<'_>| {
        evaluator.each_random(cell, first..samples.min(first + UNIT_SAMPLES), is_stopped, add);
    };
    draw(&units, samples, threads, interrupt, of_unit)
}

/// A quantity as the axis of a picture.
fn value_of(quantity: &Quantity) -> Value {
    Value { title: title(quantity), unit: unit(&quantity.unit).to_owned() }
}

/// A unit as pictures have it: nothing for a pure number.
fn unit(unit: &str) -> &str {
    if unit == "1" { "" } else { unit }
}

/// Which cell a picture shows, by the values of the axes.
fn place(job: &Job, cell: u64) -> String {
    let place = GridView::new(job).place_of(job, cell);
    if place.is_empty() { format!("cell {cell}") } else { format!("cell {cell}: {place}") }
}
