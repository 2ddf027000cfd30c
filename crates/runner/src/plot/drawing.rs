//! Drawings written as files.

use std::path::Path;

use crate::failure::Failure;
use crate::files::publish::publish;
use crate::output::output_file;
use crate::plot::canvas::Canvas;
use crate::plot::pdf::pdf;
use crate::plot::png::png;
use crate::plot::svg::svg;

/// Widths of one and of two columns of a paper, 84 and 174 mm, in pixels.
pub const WIDTHS: [f64; 2] = [84.0 / 25.4 * 96.0, 174.0 / 25.4 * 96.0];

/// Writes a drawing as SVG, PDF or PNG, as the name of the file says.
///
/// # Errors
/// A place that cannot be written to.
pub fn write(canvas: &Canvas, file: &Path) -> Result<(), Failure> {
    let is_named = |name: &str| file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(name));
    let bytes = if is_named("svg") {
        Ok(svg(canvas).into_bytes())
    } else if is_named("pdf") {
        pdf(canvas)
    } else {
        png(canvas)
    };
    let bytes = bytes.map_err(|why| Failure::CannotCreate(format!("{}: {why}", file.display())))?;
    let (directory, name) = output_file(file)?;
    publish(&directory, &name, &bytes)?;
    Ok(())
}
