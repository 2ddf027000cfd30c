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
use crate::plot::canvas::{Canvas, Rgb};
use crate::plot::cells;
use crate::plot::level_lines::level_lines;
use crate::plot::levels::{Levels, label};
use crate::plot::limit_lines::{lines, target_label};
use crate::plot::regions::Region;
use crate::plot::values::Values;
use crate::plot::verdict_map::VerdictMaps;
use crate::store::directory::RunDirectory;
use crate::store::outdated;
use crate::store::provenance::{finished, programs};
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
    /// The programs that computed it, and when it was finished, as far as it is known.
    pub programs: Vec<String>,
    pub finished: Option<String>,
    /// What identifies the results that are shown.
    pub results: Option<String>,
}

/// A picture of a run.
pub struct Picture {
    pub kind: PictureKind,
    pub canvas: Canvas,
}

/// What a picture shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PictureKind {
    Inputs,
    Friction,
    Distributions,
    Verdicts,
    Modes,
    SquealFrequencies,
}

/// Width of a picture, in pixels.
pub const PICTURE_WIDTH: f64 = 700.0;

/// How the columns of a recorded result end that are shown.
const SHOWN: [&str; 3] = ["_p50", "_p05", "_p95"];

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
        let directory = RunDirectory::view(path)?;
        let (programs, finished) = (programs(&directory), finished(&directory));
        let results = outdated::results(&directory);
        Ok(Self { path: shown(path), values, further, pictures, programs, finished, results })
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
        let colour = |band| hexadecimal(levels.colour(band));
        let rounded = |value: &f64| round(*value);
        json!({
            "name": job.name,
            "path": self.path,
            "axes": axes,
            "vertical": vertical,
            "horizontal": horizontal,
            // Where the selected point is first.
            "at": job.operating_point.map(|cell| view.axes().iter().map(|axis| axis.position(cell)).collect::<Vec<_>>()),
            "p": probability.iter().map(|p| p.map(round)).collect::<Vec<_>>(),
            "low": low.iter().map(rounded).collect::<Vec<_>>(),
            "high": high.iter().map(rounded).collect::<Vec<_>>(),
            "samples": samples,
            // With conditional probabilities and weights, counts are not shares.
            "unstable": (job.answer() == Answer::Verdict).then_some(unstable),
            "levels": levels.all(),
            "level_names": levels.all().iter().map(|level| label(*level)).collect::<Vec<_>>(),
            "colours": (0..levels.bands()).map(colour).collect::<Vec<_>>(),
            "interval_name": job.sampling.method.interval(&job.sampling),
            "verdicts": self.values.is_certain().then(|| self.verdicts()),
            "apart": self.apart(),
            "expected": expected_behaviours(job),
            "lines": self.lines(&view),
            "target": job.target.map(|target| json!({ "value": target, "name": target_label(target) })),
            "recorded": self.recorded(),
            "sensitivity": self.sensitivity(),
        })
    }

    /// The lines on the map in every slice, by the first cell of the slice: those of levels and of the target, and those of
    /// limits, as a plot draws them.
    fn lines(&self, view: &GridView) -> Vec<Value> {
        let values = &self.values;
        let of_slice = |slice: Slice<'_>| {
            let limits = values.limits.as_ref().map_or_else(Vec::new, |limits| lines(limits, view, &slice));
            let is_level = |level: &f64| limits.iter().all(|line| line.target != *level);
            let line = |level: f64, points: &[[f64; 2]], is_limit: bool| {
                let [x, y] = [0, 1].map(|axis| points.iter().map(|point| round(point[axis])).collect::<Vec<f64>>());
                let is_wanted = is_limit || values.job.target == Some(level);
                let name = if is_wanted { target_label(level) } else { label(level) };
                json!({ "first": slice.first, "level": level, "is_limit": is_limit, "is_wide": is_wanted, "name": name, "x": x, "y": y })
            };
            let levels = values.lines().into_iter().filter(is_level);
            let at_level = |level| level_lines(&values.probability, view, &slice, level);
            let contours = levels.flat_map(|level| at_level(level).into_iter().map(move |points| (level, points)));
            let contours = contours.map(|(level, points)| line(level, &points, false));
            contours.chain(limits.iter().map(|of| line(of.target, &of.points, true))).collect::<Vec<Value>>()
        };
        (0..view.slices()).flat_map(|number| of_slice(view.slice(number))).collect()
    }

    /// The verdict of each cell of a run in which nothing scatters, by its place among their names; with their colours.
    fn verdicts(&self) -> Value {
        let names = cells::names(self.values.job.model());
        let of_cells: Vec<usize> =
            (0..self.values.samples.len()).map(|cell| cells::of_cell(&self.values, cell) as usize).collect();
        let colours = Region::ALL.map(|region| hexadecimal(region.colour()));
        json!({ "names": names, "colours": colours, "of_cells": of_cells })
    }

    /// Of each cell the shares of samples outside the model and of those without a verdict; nothing if there are none.
    fn apart(&self) -> Option<Value> {
        let Values { samples, undecided, failed, outside, .. } = &self.values;
        let share = |count: u64, cell: usize| round(count as f64 / samples[cell].max(1) as f64);
        let cells = 0..samples.len();
        let outside: Vec<f64> = cells.clone().map(|cell| share(outside[cell], cell)).collect();
        let open: Vec<f64> = cells.map(|cell| share(undecided[cell] + failed[cell], cell)).collect();
        let has_any = outside.iter().chain(&open).any(|share| *share > 0.0);
        has_any.then(|| json!({ "outside": outside, "open": open }))
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
            let [median, low, high] = SHOWN.map(|kind| self.further(&format!("{}{kind}", result.name)));
            Some(json!({
                "name": result.noun,
                "samples": result.of.nouns()[1],
                "scale": scale,
                "unit": unit,
                "median": median?,
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

/// A colour as HTML has it.
fn hexadecimal((red, green, blue): Rgb) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// What recorded lengths are over, in mm, if it is the same in all cells.
pub fn length_scale_mm(job: &Job) -> Option<f64> {
    let of = |configuration| job.model().length_scale(&job.grid.first_cell_with(configuration).expected);
    let first = of(0)?;
    (1..job.grid.configurations()).all(|other| of(other) == Some(first)).then_some(1e3 * first)
}
