//! Single samples of a cell over two of their values.

use stickslip_core::model::verdict::Verdict;
use stickslip_sampler::draw::deviates::Points;
use stickslip_sampler::grid::Cell;

use super::common::{FEW_SAMPLES, SAMPLES, first_samples, place, require_scatter, unit, value_of};
use crate::cli::PlotArguments;
use crate::commands::drawn_samples::DrawnSamples;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::job::keys::nearest;
use crate::job::{Answer, Job};
use crate::output::counted;
use crate::picture::title::capitalised;
use crate::picture::view::scatter as scatter_of;
use crate::plot::canvas::Rgb;
use crate::plot::cells::names;
use crate::plot::regions::Region;
use crate::plot::scatter::{Kind, ScatterPlot, Value};

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
    require_scatter(job, cell)?;
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
    let of = |name: &str, colour: Rgb| Kind { name: name.to_owned(), colour, places: Vec::new() };
    let mut kinds = vec![
        of(stable, STABLE),
        of(unstable, Region::Unstable.colour()),
        of(undecided, Region::Undecided.colour()),
        of(failed, Region::Failed.colour()),
        of("outside the model", OUTSIDE),
    ];
    let mut left_out = 0_u64;
    for sample in 0..drawn.decisions.len() {
        let [x, y] = [0, 1].map(|axis: usize| axes[axis].value(&drawn, sample));
        let Some(at) = x.zip(y) else {
            left_out += 1;
            continue;
        };
        let kind = match drawn.decisions[sample].verdict {
            _ if drawn.are_outside[sample] => 4,
            Verdict::Stable => 0,
            Verdict::Unstable => 1,
            Verdict::Undecided => 2,
            Verdict::Failed => 3,
        };
        kinds[kind].places.push([at.0, at.1]);
    }
    let names = axes.each_ref().map(|axis| axis.described(job));
    if left_out == samples {
        let names = [&names[0].title, &names[1].title].map(|name| name.to_lowercase());
        return Err(Failure::Job(format!(
            "none of {} of cell {} has both values, {} and {}; choose others with --x and --y, or another cell with --cell",
            counted(samples.into(), "sample", "samples"),
            cell.index,
            names[0],
            names[1]
        )));
    }
    // The samples of other methods are drawn otherwise.
    let has_others = arguments.run.is_dir() && !(job.answer() == Answer::Verdict && job.points() == Points::Random);
    let mut notes = vec![format!(
        "{}, drawn at random{}; {}",
        counted(samples.into(), "sample", "samples"),
        if has_others { ": the run has others" } else { "" },
        scatter_of(job, cell.index)
    )];
    if drawn.are_outside.contains(&true) {
        notes.push(format!("outside the model: {}", job.model().outside_meaning()));
    }
    let of_no_value = counted(left_out.into(), "sample has", "samples have");
    notes.extend((left_out > 0).then(|| format!("{of_no_value} no such result, as those outside the model")));
    let axes = names;
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
