//! `plot`: the result of a run as a figure.

use std::fmt::Write as _;

use crate::cli::PlotArguments;
use crate::failure::Failure;
use crate::files::publish::publish;
use crate::output::{note, output_file, result};
use crate::picture::view::{GridView, MOST_PANELS};
use crate::plot::surface::figure;
use crate::plot::values::Values;

/// Widths of one and of two columns of a paper, 84 and 174 mm, in pixels.
const WIDTHS: [f64; 2] = [84.0 / 25.4 * 96.0, 174.0 / 25.4 * 96.0];

/// `stickslip plot`.
pub fn plot(arguments: &PlotArguments) -> Result<(), Failure> {
    let files = match &arguments.out {
        Some(out) => vec![out.clone()],
        None => ["surface.svg", "surface.png"].map(|name| arguments.run.join(name)).to_vec(),
    };
    let values = Values::read(&arguments.run)?;
    let slices = GridView::new(&values.job).slices();
    if slices > MOST_PANELS {
        note(format_args!("{slices} panels are too many for one figure; the first {MOST_PANELS} are drawn"));
    }
    let canvas = figure(&values, WIDTHS[usize::from(arguments.columns.clamp(1, 2)) - 1]);
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
