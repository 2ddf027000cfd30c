//! `plot`: the result of a run, or a simulated motion, as a figure.

use std::fmt::Write as _;
use std::path::Path;

use crate::cli::PlotArguments;
use crate::failure::Failure;
use crate::files::publish::publish;
use crate::output::{note, output_file, result};
use crate::picture::view::{GridView, MOST_PANELS, rounded};
use crate::plot::canvas::Canvas;
use crate::plot::motion;
use crate::plot::surface::figure;
use crate::plot::values::Values;

/// Widths of one and of two columns of a paper, 84 and 174 mm, in pixels.
const WIDTHS: [f64; 2] = [84.0 / 25.4 * 96.0, 174.0 / 25.4 * 96.0];

/// `stickslip plot`.
pub fn plot(arguments: &PlotArguments) -> Result<(), Failure> {
    let width = WIDTHS[usize::from(arguments.columns.clamp(1, 2)) - 1];
    let (canvas, beside) = if arguments.run.is_file() {
        (motion::figure(&arguments.run, width)?, arguments.run.clone())
    } else {
        (of_run(&arguments.run, width)?, arguments.run.join("surface"))
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

fn of_run(run: &Path, width: f64) -> Result<Canvas, Failure> {
    let values = Values::read(run)?;
    let slices = GridView::new(&values.job).slices();
    if slices > MOST_PANELS {
        note(format_args!("{slices} panels are too many for one figure; the first {MOST_PANELS} are drawn"));
    }
    figure(&values, width).ok_or_else(|| single_cell(run, &values))
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
