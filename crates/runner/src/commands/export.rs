//! `export`: the surface of a run for other programs.

use std::io::{self, BufWriter, Write as _};

use crate::cli::ExportArguments;
use crate::export::columns::ExportedSurface;
use crate::failure::Failure;
use crate::files::publish::publish_with;
use crate::output::{output_file, result, shown};

/// `stickslip export`.
pub fn export(arguments: &ExportArguments) -> Result<(), Failure> {
    let format = arguments.format;
    let default = || arguments.run.join(format!("surface.{}", format.extension()));
    let file = arguments.out.clone().unwrap_or_else(default);
    format.check_name(&file)?;
    let surface = ExportedSurface::read(&arguments.run)?;
    let (directory, name) = output_file(&file)?;
    publish_with(&directory, &name, |file| {
        let mut out = BufWriter::new(file);
        format.write(&surface, &mut out)?;
        out.flush()
    })
    .map_err(|error: io::Error| Failure::writing(&file, error))?;
    result(&format!("{}\n", shown(&file)))
}
