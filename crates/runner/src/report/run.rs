//! What the script of the page draws of one run.

use std::path::Path;

use serde_json::{Value, json};
use stickslip_core::model::quantity::Quantity;
use stickslip_core::model::recorded::RecordedResult;

use super::expected::expected_behaviours;
use crate::failure::Failure;
use crate::job::{Answer, Job};
use crate::output::{note, shown};
use crate::picture::title::title;
use crate::picture::view::{GridView, Slice, round};
use crate::plot::axes::axis;
use crate::plot::canvas::Canvas;
use crate::plot::levels::{Levels, label};
use crate::plot::limit_lines::{LimitLine, lines, target_label};
use crate::plot::values::Values;
use crate::plot::verdict_map::VerdictMaps;
use crate::store::directory::RunDirectory;
use crate::store::provenance::programs;
use crate::tables::finished::{FinishedColumn, FinishedSurface, FinishedValues};

/// A run, as it was named on the command line.
pub struct ReportedRun {
    /// The directory, as typed.
    pub path: String,
    /// Its probabilities.
    pub values: Values,
    /// Its recorded results and Sobol indices, with their names.
    further: Vec<FinishedColumn>,
    /// Pictures beside those that the script draws.
    pub pictures: Vec<Picture>,
    /// The programs that computed it, as far as it is known.
    pub programs: Vec<String>,
}

/// A picture of a run.
pub struct Picture {
    pub kind: PictureKind,
    pub canvas: Canvas,
}

/// What a picture shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PictureKind {
    Verdicts,
    Modes,
    SquealFrequencies,
}

/// Width of a picture, in pixels.
pub const PICTURE_WIDTH: f64 = 700.0;

/// How the columns of a recorded result end that are shown.
const SHOWN: [&str; 3] = ["_mean", "_p05", "_p95"];

impl ReportedRun {
    /// Reads a finished run.
    ///
    /// # Errors
    /// As [`Values::read`].
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let values = Values::read(path)?;
        let is_index = |name: &str| name.starts_with("first_order_") || name.starts_with("total_");
        let recorded = values.job.model().recorded();
        let is_recorded = |name: &str| {
            let of_result = |result: &RecordedResult| name.strip_prefix(result.name);
            let mut kinds = recorded.iter().filter_map(of_result);
            kinds.any(|kind| SHOWN.contains(&kind) || kind.strip_prefix('_').is_some_and(is_index))
        };
        let further = FinishedSurface::open(path)?.columns(|name| is_recorded(name) || is_index(name))?;
        let mut pictures = Vec::new();
        match values.job.uses_maps().then(|| VerdictMaps::read(path)) {
            Some(Ok(maps)) => {
                pictures.push(Picture { kind: PictureKind::Verdicts, canvas: maps.figure(PICTURE_WIDTH) });
            }
            Some(Err(why)) => note(format_args!("the report shows no verdict map of {}: {why}", path.display())),
            None => {}
        }
        let programs = programs(&RunDirectory::view(path)?);
        Ok(Self { path: shown(path), values, further, pictures, programs })
    }

    /// The run for the script: axes slowest first, and one number for each cell in every column.
    pub fn data(&self) -> Value {
        let Values { job, probability, low, high, samples, unstable, .. } = &self.values;
        let view = GridView::new(job);
        let axes: Vec<Value> = view
            .axes()
            .iter()
            .map(|of| {
                let named = axis(of);
                json!({
                    "title": named.title,
                    "unit": named.unit,
                    "values": of.values,
                    "logarithmic": named.scale.is_logarithmic(),
                })
            })
            .collect();
        let (vertical, horizontal) = view.shown();
        let levels = Levels::up_to(self.values.largest());
        let colour = |band| {
            let (red, green, blue) = levels.colour(band);
            format!("#{red:02x}{green:02x}{blue:02x}")
        };
        let rounded = |value: &f64| round(*value);
        json!({
            "name": job.name,
            "path": self.path,
            "axes": axes,
            "vertical": vertical,
            "horizontal": horizontal,
            "p": probability.iter().map(|p| p.map(round)).collect::<Vec<_>>(),
            "low": low.iter().map(rounded).collect::<Vec<_>>(),
            "high": high.iter().map(rounded).collect::<Vec<_>>(),
            "samples": samples,
            // With conditional probabilities and weights, counts are not shares.
            "unstable": (job.answer() == Answer::Verdict).then_some(unstable),
            "levels": levels.all(),
            "level_names": levels.all().iter().map(|level| label(*level)).collect::<Vec<_>>(),
            "lines": levels.lines(),
            "colours": (0..levels.bands()).map(colour).collect::<Vec<_>>(),
            "interval_name": job.sampling.method.interval(&job.sampling),
            "expected": expected_behaviours(job),
            "limits": self.limits(&view),
            "recorded": self.recorded(),
            "sensitivity": self.sensitivity(),
        })
    }

    /// The lines of limits in every slice, by the first cell of the slice.
    fn limits(&self, view: &GridView) -> Vec<Value> {
        let Some(limits) = &self.values.limits else { return Vec::new() };
        let slices = (0..view.slices()).map(|number| view.slice(number));
        let of_slice = |slice: Slice<'_>| {
            let line = |line: LimitLine| {
                let [x, y] =
                    [0, 1].map(|axis| line.points.iter().map(|point| round(point[axis])).collect::<Vec<f64>>());
                json!({ "first": slice.first, "target": line.target, "name": target_label(line.target), "x": x, "y": y })
            };
            lines(limits, view, &slice).into_iter().map(line).collect::<Vec<Value>>()
        };
        slices.flat_map(of_slice).collect()
    }

    /// What is recorded, with the columns that are shown of it; lengths in mm where these have one scale.
    fn recorded(&self) -> Vec<Value> {
        let job = &self.values.job;
        let of_result = |result: &RecordedResult| {
            let (scale, unit) = match (result.is_length, length_scale_mm(job)) {
                (true, Some(scale)) => (scale, "mm"),
                (true, None) => (1.0, "h"),
                (false, _) if result.unit == "1" => (1.0, ""),
                (false, _) => (1.0, result.unit),
            };
            let [mean, low, high] = SHOWN.map(|kind| self.further(&format!("{}{kind}", result.name)));
            Some(json!({
                "name": result.noun,
                "samples": result.of.nouns()[1],
                "scale": scale,
                "unit": unit,
                "mean": mean?,
                "low": low?,
                "high": high?,
            }))
        };
        job.model().recorded().iter().filter_map(of_result).collect()
    }

    /// The Sobol indices of the verdict and of recorded results, of each those of every input.
    fn sensitivity(&self) -> Vec<Value> {
        let job = &self.values.job;
        let of = |prefix: &str, name: &str| {
            let of_input = |quantity: &Quantity| {
                let column = |kind: &str| self.further(&format!("{prefix}{kind}_{}", quantity.name));
                let error = |kind: &str| self.further(&format!("{prefix}{kind}_{}_error", quantity.name));
                Some(json!({
                    "input": title(quantity),
                    "first_order": column("first_order")?,
                    "first_order_error": error("first_order")?,
                    "total": column("total")?,
                    "total_error": error("total")?,
                }))
            };
            let inputs = job.random.inputs.iter().filter_map(|&place| of_input(job.quantity(place)));
            json!({ "of": name, "inputs": inputs.collect::<Vec<_>>() })
        };
        let results = job.model().recorded().iter().map(|result| of(&format!("{}_", result.name), result.noun));
        let all = std::iter::once(of("", "verdict")).chain(results);
        all.filter(|indices| indices["inputs"].as_array().is_some_and(|inputs| !inputs.is_empty())).collect()
    }

    /// The rounded values of a column of real numbers.
    fn further(&self, name: &str) -> Option<Vec<Option<f64>>> {
        match &self.further.iter().find(|column| column.name == name)?.values {
            FinishedValues::Real(values) => Some(values.iter().map(|value| value.map(round)).collect()),
            FinishedValues::Integer(_) => None,
        }
    }
}

/// What recorded lengths are over, in mm, if it is the same in all cells.
fn length_scale_mm(job: &Job) -> Option<f64> {
    let of = |configuration| job.model().length_scale(&job.grid.first_cell_with(configuration).expected);
    let first = of(0)?;
    (1..job.grid.configurations()).all(|other| of(other) == Some(first)).then_some(1e3 * first)
}
