//! Single samples of a cell over two of their values.

use stickslip_core::model::verdict::Verdict;
use stickslip_sampler::grid::Cell;

use super::{FEW_SAMPLES, SAMPLES, first_samples, place, unit, value_of};
use crate::cli::PlotArguments;
use crate::commands::drawn_samples::DrawnSamples;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::job::Job;
use crate::job::keys::nearest;
use crate::output::counted;
use crate::picture::title::capitalised;
use crate::picture::view::scatter as scatter_of;
use crate::plot::canvas::Rgb;
use crate::plot::cells::names;
use crate::plot::regions::Region;
use crate::plot::scatter::{Points, ScatterPlot, Value};

/// Samples outside the model, which are not decided by its equations.
const OUTSIDE: Rgb = (0xb0, 0x60, 0x90);

/// Stable samples: as points they need a stronger colour than as areas.
const STABLE: Rgb = (0x56, 0xa5, 0xd8);

/// What samples are drawn over.
enum Along {
    /// A random input, by its place among them.
    Input(usize),
    /// A recorded result.
    Recorded(usize),
    /// The number of the sample.
    Number,
}

/// The picture of the first samples of a cell.
///
/// # Errors
/// A name that is none of a value of samples, and an interruption.
pub fn scatter(
    job: &Job,
    cell: &Cell,
    arguments: &PlotArguments,
    interrupt: &Interrupt,
) -> Result<ScatterPlot, Failure> {
    let axes = [("--x", &arguments.x, 0), ("--y", &arguments.y, 1)].map(|(option, name, place)| match name {
        Some(name) => Along::named(job, option, name),
        None => Ok(Along::by_default(job, cell, place)),
    });
    let [x, y] = axes;
    let axes = [x?, y?];
    let usual = if job.model().has_slow_samples() { FEW_SAMPLES } else { SAMPLES };
    let samples = arguments.samples.unwrap_or(usual);
    let drawn = first_samples(job, cell.index, samples, arguments.threads.count(), interrupt)?;
    let [stable, unstable, undecided, failed, _] = names(job.model());
    let outside = format!("outside the model, {}", job.model().outside_meaning());
    let of = |name: &str, colour: Rgb| Points { name: name.to_owned(), colour, places: Vec::new() };
    let mut kinds = vec![
        of(stable, STABLE),
        of(unstable, Region::Unstable.colour()),
        of(undecided, Region::Undecided.colour()),
        of(failed, Region::Failed.colour()),
        of(&outside, OUTSIDE),
    ];
    let verdicts = [Verdict::Stable, Verdict::Unstable, Verdict::Undecided, Verdict::Failed];
    let mut left_out = 0;
    for sample in 0..drawn.decisions.len() {
        let [x, y] = [0, 1].map(|axis: usize| axes[axis].value(&drawn, sample));
        let Some(at) = x.zip(y) else {
            left_out += 1;
            continue;
        };
        let verdict = verdicts.iter().position(|verdict| *verdict == drawn.decisions[sample].verdict);
        let kind = if drawn.are_outside[sample] { Some(verdicts.len()) } else { verdict };
        kinds[kind.unwrap_or(0)].places.push([at.0, at.1]);
    }
    let mut notes = vec![format!(
        "the first {}, drawn at random; {}",
        counted(samples.into(), "sample", "samples"),
        scatter_of(job, cell.index)
    )];
    notes.extend((left_out > 0).then(|| format!("{left_out} of them have no such value")));
    let axes = [0, 1].map(|axis: usize| axes[axis].described(job));
    Ok(ScatterPlot { axes, kinds, title: place(job, cell.index), notes })
}

impl Along {
    /// The value of this name.
    fn named(job: &Job, option: &str, name: &str) -> Result<Self, Failure> {
        let inputs = || job.random.inputs.iter().map(|&place| job.quantity(place));
        let recorded = || job.model().recorded().iter();
        if let Some(input) = inputs().position(|quantity| quantity.name == name || quantity.path == name) {
            return Ok(Self::Input(input));
        }
        if let Some(result) = recorded().position(|result| result.name == name) {
            return Ok(Self::Recorded(result));
        }
        let known: Vec<&str> = inputs().map(|quantity| &*quantity.name).chain(recorded().map(|of| of.name)).collect();
        let near = nearest(name, known.iter().copied()).map_or(String::new(), |near| format!("; did you mean {near}?"));
        Err(Failure::Usage(format!(
            "{option} {name}: samples have no such value{near} (random inputs and recorded results: {})",
            if known.is_empty() { "none".to_owned() } else { known.join(", ") }
        )))
    }

    /// The first two inputs that scatter; of one, with what is recorded.
    fn by_default(job: &Job, cell: &Cell, place: usize) -> Self {
        let scattering = (0..job.random.inputs.len()).filter(|&input| job.std(input, cell) != 0.0);
        let inputs = scattering.map(Self::Input);
        let recorded = (0..job.model().recorded().len()).map(Self::Recorded);
        inputs.chain(recorded).nth(place).unwrap_or(Self::Number)
    }

    fn value(&self, drawn: &DrawnSamples, sample: usize) -> Option<f64> {
        match self {
            Self::Input(input) => drawn.values.get(*input).map(|values| values[sample]),
            Self::Recorded(result) => drawn.decisions[sample].recorded[*result],
            Self::Number => Some(sample as f64),
        }
    }

    fn described(&self, job: &Job) -> Value {
        match self {
            Self::Input(input) => value_of(job.quantity_of(*input)),
            Self::Recorded(result) => {
                let result = &job.model().recorded()[*result];
                Value { title: capitalised(result.noun), unit: unit(result.unit).to_owned() }
            }
            Self::Number => Value { title: "Number of the sample".to_owned(), unit: String::new() },
        }
    }
}
