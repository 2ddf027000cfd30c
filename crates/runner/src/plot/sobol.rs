//! The Sobol indices of a run as bars with their intervals.

use std::path::Path;

use stickslip_core::model::quantity::Quantity;
use stickslip_sampler::special_functions::normal;

use crate::failure::Failure;
use crate::job::Job;
use crate::picture::scale::Scale;
use crate::picture::title::title;
use crate::picture::view::{GridView, rounded};
use crate::plot::canvas::{BLACK, Canvas, GREY, Pen, Rgb, Side, width_of};
use crate::plot::legend::Legend;
use crate::plot::panel::{ABOVE, Axis, BELOW, OF_NOTES, Panel, RIGHT, SMALL, two_lines, wrapped};
use crate::plot::values::Values;
use crate::tables::finished::{FinishedSurface, FinishedValues};

/// What indices are of if no result is named.
const VERDICT: &str = "verdict";

/// Most cells that have a panel each when no cell is chosen.
const MOST_CELLS: usize = 6;

/// The probability whose cell is drawn where there are more.
const MIDDLE: f64 = 0.5;

/// Height of an input with its two bars, and of a bar.
const ROW: f64 = 30.0;
const BAR: f64 = 10.0;

/// Largest share of the figure that the names of the inputs take, the space between panels, and their least width.
const MOST_NAMES: f64 = 0.36;
const BETWEEN: f64 = 22.0;
const LEAST_WIDTH: f64 = 120.0;

/// Space between the panels and the legend, and below it.
const END: f64 = 8.0;

/// Ends that the axis does not pass, whatever the intervals.
const ENDS: (f64, f64) = (-0.2, 1.2);

/// Space of the axis beyond an interval that passes 0 or 1.
const AROUND: f64 = 0.02;

const FIRST_ORDER: Rgb = (0x00, 0x72, 0xb2);
const TOTAL: Rgb = (0xe6, 0x9f, 0x00);

/// An index with its standard error.
type Index = (f64, f64);

/// The indices of an input in a cell: first order and total.
type Pair = [Option<Index>; 2];

/// The Sobol indices of a run.
pub struct Sobol {
    values: Values,
    /// Whose variance they share out.
    of: &'static str,
    /// The titles of the inputs.
    inputs: Vec<String>,
    /// For each cell, for each input.
    indices: Vec<Vec<Pair>>,
}

impl Sobol {
    /// Reads the indices of a run: those of the verdict, or of a recorded result.
    ///
    /// # Errors
    /// As [`Values::read`], and a run without these indices.
    pub fn read(run: &Path, result: Option<&str>) -> Result<Self, Failure> {
        let values = Values::read(run)?;
        let of = described(&values.job, result)?;
        let prefix = result.map_or_else(String::new, |name| format!("{name}_"));
        let is_index = |name: &str| {
            let kind = name.strip_prefix(&prefix).unwrap_or_default();
            kind.starts_with("first_order_") || kind.starts_with("total_")
        };
        let columns = FinishedSurface::open(run)?.columns(is_index)?;
        if columns.is_empty() {
            return Err(Failure::Job(format!(
                "{} has no Sobol indices. Give its job two or more [random] inputs, and sensitivity = true in [sampling], with method = \"monte-carlo\" and a number of samples; then submit it to another directory",
                run.display()
            )));
        }
        let number = |name: &str, cell: usize| -> Option<f64> {
            match &columns.iter().find(|column| column.name == name)?.values {
                FinishedValues::Real(values) => *values.get(cell)?,
                FinishedValues::Integer(_) => None,
            }
        };
        let job = &values.job;
        let quantities: Vec<&Quantity> = job.random.inputs.iter().map(|&place| job.quantity(place)).collect();
        let pair = |cell: usize, input: &str| -> Pair {
            ["first_order", "total"].map(|kind| {
                let name = format!("{prefix}{kind}_{input}");
                number(&name, cell).zip(number(&format!("{name}_error"), cell))
            })
        };
        let cells = 0..values.probability.len();
        let indices = cells.map(|cell| quantities.iter().map(|input| pair(cell, &input.name)).collect()).collect();
        let inputs = quantities.into_iter().map(title).collect();
        Ok(Self { values, of, inputs, indices })
    }

    /// The cells to draw: the one that is asked for, all with indices if they are few, else the one whose probability
    /// is nearest one half.
    ///
    /// # Errors
    /// A cell that the run does not have or that has no indices, and a run in which no cell has any.
    pub fn cells(&self, run: &Path, wanted: Option<u64>) -> Result<Vec<usize>, Failure> {
        let has_indices = |cell: &usize| self.indices[*cell].iter().flatten().any(Option::is_some);
        let count = self.indices.len();
        if let Some(wanted) = wanted {
            let cell = usize::try_from(wanted).ok().filter(|cell| *cell < count).ok_or_else(|| {
                Failure::Usage(format!("--cell {wanted}: {} has cells 0 to {}", run.display(), count - 1))
            })?;
            if !has_indices(&cell) {
                return Err(Failure::Job(format!(
                    "cell {cell} of {} has no Sobol indices of the {}: its samples agree, P is {}. Choose a cell with a probability between 0 and 1, or leave --cell out",
                    run.display(),
                    self.of,
                    self.values.probability[cell].map_or_else(|| "not known".to_owned(), rounded)
                )));
            }
            return Ok(vec![cell]);
        }
        let known: Vec<usize> = (0..count).filter(has_indices).collect();
        if known.len() <= MOST_CELLS && !known.is_empty() {
            return Ok(known);
        }
        let distance = |cell: &usize| self.values.probability[*cell].map_or(f64::INFINITY, |p| (p - MIDDLE).abs());
        let nearest = known.into_iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
        nearest.map(|cell| vec![cell]).ok_or_else(|| {
            let results = self.values.job.model().recorded().iter().filter(|result| result.has_indices());
            let results: Vec<String> = results.map(|result| format!("--result {}", result.name)).collect();
            let or = if self.of == VERDICT && !results.is_empty() {
                format!(", or see {}", results.join(" and "))
            } else {
                String::new()
            };
            Failure::Job(format!(
                "no cell of {} has Sobol indices of the {}: in each all samples agree. Choose [axes] nearer the boundary of stability, or more samples{or}",
                run.display(),
                self.of
            ))
        })
    }

    /// The figure of some cells, this wide in pixels.
    pub fn figure(&self, cells: &[usize], width: f64) -> Canvas {
        let names: Vec<Vec<String>> =
            self.inputs.iter().map(|input| wrapped(input, MOST_NAMES * width, SMALL)).collect();
        let longest = names.iter().flatten().map(|line| width_of(line, SMALL)).fold(0.0, f64::max);
        let left = longest + 12.0;
        let inside = width - RIGHT - left;
        let fits = (((inside + BETWEEN) / (LEAST_WIDTH + BETWEEN)).floor() as usize).max(1);
        let columns = fits.min(cells.len().max(1));
        let panel_width = (inside + BETWEEN) / columns as f64 - BETWEEN;
        let panel_height = ROW * self.inputs.len() as f64;
        let step = ABOVE + panel_height + BELOW;
        let bottom = cells.len().div_ceil(columns) as f64 * step + END;
        let confidence = self.values.job.sampling.confidence;
        let entries = vec![(FIRST_ORDER, "first order: alone".to_owned()), (TOTAL, "total: taking part".to_owned())];
        let legend = Legend::new(entries, width - RIGHT - 8.0);
        let mut canvas = Canvas::new(width, bottom + legend.height() + 14.0);
        let axis = self.axis(cells);
        for (i, &cell) in cells.iter().enumerate() {
            let panel = Panel {
                left: left + (i % columns) as f64 * (panel_width + BETWEEN),
                top: ABOVE + (i / columns) as f64 * step,
                width: panel_width,
                height: panel_height,
            };
            if i % columns == 0 {
                write_names(&mut canvas, &panel, &names);
            }
            self.panel(&mut canvas, &panel, cell, &axis);
        }
        legend.draw(&mut canvas, (8.0, bottom));
        let note = format!("lines: {} % intervals", rounded(100.0 * confidence));
        canvas.text((RIGHT, bottom + legend.height() + 8.0), &note, OF_NOTES, Side::Right, 0.0, GREY);
        canvas
    }

    /// The axis of the indices, the same for all panels: from 0 to 1, and further where intervals are.
    fn axis(&self, cells: &[usize]) -> (Axis, [f64; 2]) {
        let known = || cells.iter().flat_map(|&cell| self.indices[cell].iter().flatten().flatten());
        let lowest = known().map(|index| self.ends(*index)[0]).fold(0.0, f64::min);
        let highest = known().map(|index| self.ends(*index)[1]).fold(1.0, f64::max);
        let beyond = |end: f64, limit: f64| if end == limit { 0.0 } else { AROUND };
        let ends = [(lowest - beyond(lowest, 0.0)).max(ENDS.0), (highest + beyond(highest, 1.0)).min(ENDS.1)];
        let title = format!("Share of the variance of the {}", self.of);
        (Axis { scale: Scale::linear(ends[0], ends[1]), title, unit: String::new() }, ends)
    }

    /// The interval of an index.
    fn ends(&self, (value, error): Index) -> [f64; 2] {
        let times = normal::quantile(0.5 + 0.5 * self.values.job.sampling.confidence);
        [value - times * error, value + times * error]
    }

    fn panel(&self, canvas: &mut Canvas, panel: &Panel, cell: usize, (axis, [lowest, highest]): &(Axis, [f64; 2])) {
        let right = |value: f64| panel.place(axis.scale.at(value.clamp(*lowest, *highest)), 0.0).0;
        for (input, pair) in self.indices[cell].iter().enumerate() {
            let middle = panel.top + (input as f64 + 0.5) * ROW;
            for ((index, colour), top) in pair.iter().zip([FIRST_ORDER, TOTAL]).zip([middle - BAR, middle]) {
                let Some(index) = *index else {
                    let at = (right(0.0) + 3.0, top + BAR - 2.0);
                    canvas.text(at, "not known", SMALL - 2, Side::Right, 0.0, GREY);
                    continue;
                };
                let (from, to) = (right(index.0.min(0.0)), right(index.0.max(0.0)));
                canvas.area(&[panel.rectangle((from, top), (to, top + BAR))], colour, 1.0);
                let ([low, high], level) = (self.ends(index).map(right), top + 0.5 * BAR);
                canvas.line((low, level), (high, level), Pen::new(BLACK, 1.0));
                for end in [low, high] {
                    canvas.line((end, level - 2.5), (end, level + 2.5), Pen::new(BLACK, 1.0));
                }
            }
        }
        if *lowest < 0.0 {
            canvas.line((right(0.0), panel.top), (right(0.0), panel.bottom()), Pen::new(GREY, 0.8));
        }
        panel.outline(canvas);
        panel.axis_below(canvas, axis);
        let probability = self.values.probability[cell].unwrap_or(f64::NAN);
        let first = format!("cell {cell}: P = {}", rounded((probability * 1e4).round() / 1e4));
        let second = GridView::new(&self.values.job).place_of(&self.values.job, cell as u64);
        let fits = |size: &u32| width_of(&first, *size).max(width_of(&second, *size)) <= panel.width + 0.8 * BETWEEN;
        two_lines(canvas, panel, [&first, &second], (6..SMALL).rev().find(fits).unwrap_or(6));
    }
}

/// What a recorded result of a job with Sobol indices is called, or the verdict.
fn described(job: &Job, result: Option<&str>) -> Result<&'static str, Failure> {
    let Some(name) = result else { return Ok(VERDICT) };
    let known = || job.model().recorded().iter().filter(|known| known.has_indices());
    known().find(|known| known.name == name).map(|known| known.noun).ok_or_else(|| {
        let names: Vec<&str> = known().map(|known| known.name).collect();
        let there_are = match names[..] {
            [] => "the job records no result of all samples, see criterion.record".to_owned(),
            _ => format!("there are {}", names.join(", ")),
        };
        Failure::Usage(format!("--result {name}: there are no Sobol indices of it ({there_are})"))
    })
}

/// The names of the inputs at the left of a panel.
fn write_names(canvas: &mut Canvas, panel: &Panel, names: &[Vec<String>]) {
    for (input, lines) in names.iter().enumerate() {
        let middle = panel.top + (input as f64 + 0.5) * ROW;
        let first = middle + 0.35 * f64::from(SMALL) - 0.55 * f64::from(SMALL) * (lines.len() - 1) as f64;
        for (i, line) in lines.iter().enumerate() {
            let at = (panel.left - 6.0, first + 1.1 * f64::from(SMALL) * i as f64);
            canvas.text(at, line, SMALL, Side::Left, 0.0, BLACK);
        }
    }
}
