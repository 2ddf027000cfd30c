//! The distribution of what is recorded of samples.

use std::path::Path;

use indicatif::HumanCount;
use stickslip_core::model::recorded::RecordedResult;
use stickslip_sampler::grid::Cell;

use super::common::{place, unit};
use crate::evaluate::unit::Recorded;
use crate::failure::Failure;
use crate::job::Job;
use crate::output::{counted, note};
use crate::picture::panels::left_out;
use crate::picture::scale::Scale;
use crate::picture::title::capitalised;
use crate::picture::view::{GridView, rounded, scatter};
use crate::plot::canvas::Canvas;
use crate::plot::curves::Curves;
use crate::plot::distribution::{DistributionPlot, significant};
use crate::plot::form::Form;
use crate::plot::panel::Axis;
use crate::store::directory::RunDirectory;
use crate::tables::finished::FinishedSurface;
use crate::tables::surface::Surface;

/// The picture of the quantiles over an axis, and its name; `None` where the cells make no curves.
///
/// # Errors
/// A path that is no run, and a run that does not record the result.
pub fn along(
    path: &Path,
    name: Option<&str>,
    title: Option<String>,
    width: f64,
) -> Result<Option<(Canvas, String)>, Failure> {
    require_run(path)?;
    let surface = FinishedSurface::open(path)?;
    let result = *chosen(&surface.job, name)?.1;
    let view = GridView::new(&surface.job).titled(title);
    let along = match Form::for_grid(&view) {
        Some(Form::Curves(along)) => along,
        _ => return Ok(None),
    };
    left_out(&view).iter().for_each(|what| note(format_args!("{what}")));
    let columns = ["p50", "p05", "p95"].map(|kind| format!("{}_{kind}", result.name));
    let [middle, low, high] = surface.numbers(columns.each_ref().map(String::as_str))?;
    if middle.iter().all(Option::is_none) {
        return Err(without_value(path, "any cell", &result));
    }
    let known = middle.iter().zip(low.iter().zip(&high)).filter(|(middle, _)| middle.is_some());
    let ends = known.flat_map(|(_, (low, high))| [*low, *high]).flatten();
    let curves = Curves {
        job: &surface.job,
        view: &view,
        along,
        vertical: Axis {
            scale: Scale::around(ends),
            title: capitalised(result.noun),
            unit: unit(result.unit).to_owned(),
        },
        has_zero: true,
        target: None,
        notes: vec![format!("median of the {}; bands: from the 5 % to the 95 % quantile", result.of.nouns()[1])],
        values: &middle,
        low: &low.iter().map(|end| end.unwrap_or(f64::NAN)).collect::<Vec<f64>>(),
        high: &high.iter().map(|end| end.unwrap_or(f64::NAN)).collect::<Vec<f64>>(),
    };
    Ok(Some((curves.figure(width), format!("distribution-{}", result.name))))
}

/// What is recorded of one cell of a run.
pub struct RecordedCell<'a> {
    path: &'a Path,
    job: &'a Job,
    cell: &'a Cell,
    recorded: Recorded,
    samples: u64,
}

impl<'a> RecordedCell<'a> {
    /// Reads it from the pieces of the run.
    ///
    /// # Errors
    /// A path that is no run, and pieces that cannot be read.
    pub fn read(path: &'a Path, job: &'a Job, cell: &'a Cell) -> Result<Self, Failure> {
        require_run(path)?;
        let tally = RunDirectory::view(path)?.tally(job)?;
        let row = Surface::new(job, &tally).row(cell.index);
        Ok(Self { path, job, cell, recorded: row.recorded, samples: row.counts.total() })
    }

    /// The picture of a result, and its name.
    ///
    /// # Errors
    /// A result that the run does not record, and one that no sample has.
    pub fn plot(&self, name: Option<&str>) -> Result<(DistributionPlot, String), Failure> {
        let Self { path, job, cell, .. } = *self;
        let (at, result) = chosen(job, name)?;
        let values = self.recorded[at].clone();
        let Some(mean) = values.mean() else {
            return Err(without_value(path, &format!("cell {}", cell.index), result));
        };
        let mean = if result.has_mean { format!(", mean {}", rounded(significant(mean))) } else { String::new() };
        let plot = DistributionPlot {
            samples: result.of.nouns()[1].to_owned(),
            title: capitalised(result.noun),
            unit: unit(result.unit).to_owned(),
            heading: place(job, cell.index),
            notes: vec![
                format!(
                    "{} of {} have a {}{mean}; {}",
                    HumanCount(values.count()),
                    counted(self.samples.into(), "sample", "samples"),
                    result.noun,
                    scatter(job, cell.index)
                ),
                format!("{}: {}", result.noun, result.meaning),
            ],
            values,
        };
        Ok((plot, format!("distribution-{}", result.name)))
    }
}

/// A recorded result with its place among them: the one of this name, or the first.
fn chosen<'a>(job: &'a Job, name: Option<&str>) -> Result<(usize, &'a RecordedResult), Failure> {
    let recorded = job.model().recorded();
    let names: Vec<&str> = recorded.iter().map(|result| result.name).collect();
    if names.is_empty() {
        return Err(Failure::Job(format!(
            "the job \"{}\" records nothing of its samples whose distribution could be drawn; name results in criterion.record, and submit it to another directory",
            job.name
        )));
    }
    let found = recorded.iter().enumerate().find(|(_, result)| name.is_none_or(|name| result.name == name));
    found.ok_or_else(|| {
        let name = name.unwrap_or_default();
        Failure::Usage(format!("--result {name}: the run does not record it (it records {})", names.join(", ")))
    })
}

/// The failure of a result that no sample has.
fn without_value(path: &Path, of: &str, result: &RecordedResult) -> Failure {
    Failure::Job(format!(
        "no sample of {of} of {} has a {} ({}); choose another result with --result, or another cell with --cell",
        path.display(),
        result.noun,
        result.meaning
    ))
}

/// Refuses a job that was not run.
fn require_run(path: &Path) -> Result<(), Failure> {
    if !path.is_file() {
        return Ok(());
    }
    Err(Failure::Usage(format!(
        "{} is a file; --of distribution draws what a run recorded: submit the job, and name its directory",
        path.display()
    )))
}
