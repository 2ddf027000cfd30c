//! What there is to see of one cell of a job, before a run or after it: its inputs, its samples, how its estimate converges,
//! the distribution of what is recorded, and its measured friction curve.

use std::path::{Path, PathBuf};

use crate::cli::{PlotArguments, PlotQuantity};
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::job::Job;
use crate::output::note;
use crate::plot::canvas::Canvas;
use crate::report::{PICTURE_WIDTH, Picture, PictureKind};
use crate::store::directory::RunDirectory;

use super::one_brake::{cell_of, shown_cell, with_cell};

mod common;

mod inputs;

mod samples;

mod convergence;

mod distribution;

mod friction;

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
    let (job, cell) = match arguments.of {
        PlotQuantity::Distribution if path.is_dir() => {
            with_cell(RunDirectory::view(path)?.job_to_read()?, arguments.cell)?
        }
        _ => cell_of(path, arguments.cell)?,
    };
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
        PlotQuantity::Friction => {
            let mut plot = friction::wanted(&job, &cell)?;
            titled(&mut plot.title, arguments);
            (plot.figure(width), "friction".to_owned())
        }
        _ => (inputs::inputs(&job, &cell)?.figure(width), "inputs".to_owned()),
    };
    Ok((canvas, beside(path, &name)))
}

/// The pictures of a finished run in its report: the inputs of the cell that is [shown](shown_cell), its measured
/// friction curve, and what is recorded.
///
/// # Errors
/// A run that cannot be read.
pub fn pictures(job: &Job, path: &Path) -> Result<Vec<Picture>, Failure> {
    let cell = job.grid.cell(shown_cell(job));
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
    if let Some(plot) = friction::friction(job, &cell) {
        add(PictureKind::Friction, Ok(plot.figure(PICTURE_WIDTH)))?;
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
