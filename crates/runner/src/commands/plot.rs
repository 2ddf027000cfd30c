//! `plot`: the result of a run, or a simulated motion, as a figure.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use crate::cli::{PlotArguments, PlotQuantity};
use crate::failure::Failure;
use crate::files::publish::publish;
use crate::output::{note, output_file, result};
use crate::picture::view::{GridView, MOST_PANELS, rounded};
use crate::plot::canvas::Canvas;
use crate::plot::motion;
use crate::plot::sobol::Sobol;
use crate::plot::surface;
use crate::plot::values::Values;

/// Widths of one and of two columns of a paper, 84 and 174 mm, in pixels.
const WIDTHS: [f64; 2] = [84.0 / 25.4 * 96.0, 174.0 / 25.4 * 96.0];

/// `stickslip plot`.
pub fn plot(arguments: &PlotArguments) -> Result<(), Failure> {
    let width = WIDTHS[usize::from(arguments.columns.clamp(1, 2)) - 1];
    check(arguments)?;
    let (canvas, beside) = if arguments.run.is_file() {
        (motion::figure(&arguments.run, width)?, arguments.run.clone())
    } else {
        of_run(arguments, width)?
    };
    let files = match &arguments.out {
        Some(out) => vec![out.clone()],
        None => ["svg", "png"].map(|extension| beside.with_extension(extension)).to_vec(),
    };
    let mut text = String::new();
    for file in files {
        let is_svg = file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("svg"));
        let bytes = if is_svg {
            canvas.svg()
        } else {
            canvas.png().map_err(|why| Failure::CannotCreate(format!("{}: {why}", file.display())))?
        };
        let (directory, name) = output_file(&file)?;
        publish(&directory, &name, &bytes)?;
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{}", file.display());
    }
    result(&text)
}

/// Refuses options that do not go together.
fn check(arguments: &PlotArguments) -> Result<(), Failure> {
    let is_probability = arguments.of == PlotQuantity::Probability;
    if arguments.run.is_file() && !is_probability {
        return Err(Failure::Usage(format!(
            "--of needs a run directory, and {} is a file; leave it out to draw a motion",
            arguments.run.display()
        )));
    }
    if arguments.cell.is_some() && arguments.of != PlotQuantity::Sobol {
        return Err(Failure::Usage("--cell chooses the cell of --of sobol; other plots show all cells".to_owned()));
    }
    Ok(())
}

/// The figure of a run, and where it is written if no file is given, without an extension.
fn of_run(arguments: &PlotArguments, width: f64) -> Result<(Canvas, PathBuf), Failure> {
    let run = &arguments.run;
    match arguments.of {
        PlotQuantity::Probability => {
            let values = Values::read(run)?;
            note_panels(GridView::new(&values.job).slices());
            let canvas = surface::figure(&values, width).ok_or_else(|| single_cell(run, &values))?;
            Ok((canvas, run.join("surface")))
        }
        PlotQuantity::Sobol => {
            let sobol = Sobol::read(run)?;
            let cells = sobol.cells(run, arguments.cell)?;
            Ok((sobol.figure(&cells, width), run.join("sobol")))
        }
    }
}

/// Says how many panels are left out.
fn note_panels(slices: usize) {
    if slices > MOST_PANELS {
        note(format_args!("{slices} panels are too many for one figure; the first {MOST_PANELS} are drawn"));
    }
}

/// The failure of a run that has nothing to draw.
fn single_cell(run: &Path, values: &Values) -> Failure {
    let probability = values.probability.first().copied().flatten();
    let (low, high) = (values.low.first().copied().unwrap_or(0.0), values.high.first().copied().unwrap_or(1.0));
    let known = probability.map_or_else(
        || "no sample of it is decided".to_owned(),
        |p| format!("its probability of instability is {} ({} to {})", rounded(p), rounded(low), rounded(high)),
    );
    Failure::Job(format!(
        "{} has a single cell: {known}. A plot needs several; give a quantity in [axes] more than one value, for example rotating_speed = {{ from = 5.0, to = 30.0, points = 26 }}",
        run.display()
    ))
}
