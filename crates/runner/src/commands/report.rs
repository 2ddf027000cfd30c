//! `report`: a run as one HTML file.

use crate::cli::ReportArguments;
use crate::failure::Failure;
use crate::files::publish::publish;
use crate::output::{output_file, result};
use crate::plot::values::Values;
use crate::report::page;

/// `stickslip report`.
pub fn report(arguments: &ReportArguments) -> Result<(), Failure> {
    let out = arguments.out.clone().unwrap_or_else(|| arguments.run.join("report.html"));
    let values = Values::read(&arguments.run)?;
    let page = page(&values, &arguments.run)?;
    let (directory, name) = output_file(&out)?;
    publish(&directory, &name, page.as_bytes())?;
    result(&format!("{}\n", out.display()))
}
