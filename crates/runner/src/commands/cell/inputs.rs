//! The random inputs of a cell.

use stickslip_core::model::Columns;
use stickslip_sampler::draw::deviates::Points;
use stickslip_sampler::grid::Cell;
use stickslip_sampler::inputs::Marginal;
use stickslip_sampler::special_functions::normal;

use super::common::{place, require_scatter, value_of};
use crate::evaluate::samples::{Drawing, Samples};
use crate::failure::Failure;
use crate::job::Job;
use crate::output::counted;
use crate::picture::scale::ends;
use crate::picture::view::rounded;
use crate::plot::inputs::{InputPanel, InputsPlot, PairPanel};

/// Samples that are drawn.
const DRAWN: u64 = 10_000;

/// Deviates between which densities are drawn, and into how many steps they are divided.
const FARTHEST: f64 = 3.5;
const STEPS: i32 = 400;

/// Values of an input at which it is asked whether they lie outside the model.
const TRIED: usize = 500;

/// Space about the drawn values at which that is asked, too, over their range.
const AROUND: f64 = 0.1;

/// The picture of the inputs of a cell.
///
/// # Errors
/// A job without random inputs, and a cell without a configuration.
pub fn inputs(job: &Job, cell: &Cell) -> Result<InputsPlot, Failure> {
    let random = &job.random;
    require_scatter(job, cell)?;
    let mut drawing = Drawing::new(job, cell, 0, 0..DRAWN, Points::Random);
    let drawn = drawing.next_chunk(DRAWN as usize).ok_or_else(|| Failure::Job("no samples are drawn".to_owned()))?;
    let configuration = job.model().configure(&cell.expected, &job.varying(), None);
    let configuration =
        configuration.map_err(|error| Failure::Job(format!("cell {} of \"{}\": {error}", cell.index, job.name)))?;
    let outside = |samples: &Columns<'_>| configuration.outside(samples).unwrap_or_else(|| vec![false; samples.len()]);
    let scattering: Vec<usize> = (0..random.inputs.len()).filter(|&input| job.std(input, cell) != 0.0).collect();
    let panels: Vec<InputPanel> = scattering.iter().map(|&input| panel(job, cell, input, drawn, &outside)).collect();
    let position = |input: usize| scattering.iter().position(|&scatters| scatters == input);
    let pairs = random.pairs.iter().filter(|(.., coefficient)| *coefficient != 0.0);
    let pairs: Vec<PairPanel> = pairs
        .filter_map(|&(first, second, coefficient)| {
            Some(PairPanel { inputs: [position(first)?, position(second)?], coefficient: rounded(coefficient) })
        })
        .collect();
    let are_outside = outside(&Columns::new(drawn.len(), &drawn.columns()));
    let count = are_outside.iter().filter(|is_outside| **is_outside).count();
    let share = |count: usize| rounded((1e4 * count as f64 / DRAWN as f64).round() / 100.0);
    let is_impossible = |sample: &usize| {
        let values = random.inputs.iter().zip(drawn.values(*sample));
        values.into_iter().any(|(&input, value)| !job.quantity(input).limits.contain(value))
    };
    let impossible = (0..drawn.len()).filter(|sample| !are_outside[*sample] && is_impossible(sample)).count();
    let drawn_samples = counted(DRAWN.into(), "sample", "samples");
    let mut notes = vec![format!("{}; {drawn_samples} drawn; dashed: expected value", place(job, cell.index))];
    notes.extend(
        (count > 0)
            .then(|| format!("{} % of them lie outside the model: {}", share(count), job.model().outside_meaning())),
    );
    notes.extend(
        (impossible > 0)
            .then(|| format!("{} % of them have a value that is not possible, and fail", share(impossible))),
    );

    if !pairs.is_empty() {
        notes.push("correlation: that of the normal deviates of both inputs".to_owned());
    }
    Ok(InputsPlot { inputs: panels, pairs, are_outside, notes })
}

/// One input of a cell.
fn panel(
    job: &Job,
    cell: &Cell,
    input: usize,
    drawn: &Samples,
    outside: &dyn Fn(&Columns<'_>) -> Vec<bool>,
) -> InputPanel {
    let (quantity, std) = (job.quantity_of(input), job.std(input, cell));
    let distribution = job.distribution(input, cell);
    let value = value_of(quantity);
    let drawn: Vec<f64> = (0..drawn.len()).filter_map(|sample| drawn.values(sample).nth(input)).collect();
    let at = |step: i32| FARTHEST * f64::from(step) / f64::from(STEPS);
    // With x(z) the value of a deviate, the density is phi(z) / x'(z).
    let density = |step: i32| {
        let [before, here, after] = [step - 1, step, step + 1].map(|step| distribution.value(at(step)));
        let slope = (after - before).abs() / (at(step + 1) - at(step - 1));
        [here, normal::density(at(step)) / slope]
    };
    let steps = if job.random.is_measured(input) { 0..0 } else { -STEPS..STEPS + 1 };
    let mut density: Vec<[f64; 2]> =
        steps.map(density).filter(|[value, density]| value.is_finite() && density.is_finite()).collect();
    density.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let scatter = if job.random.is_absolute(input) { "std" } else { "relative std" };
    let marginal = &job.random.marginals[input];
    let name = marginal.name();
    let before = if matches!(marginal, Marginal::TruncatedNormal { .. }) { " before the cut" } else { "" };
    let [low, high] = ends(drawn.iter().copied());
    let around = AROUND * (high - low);
    let step = (high - low + 2.0 * around) / (TRIED - 1) as f64;
    let values: Vec<f64> = (0..TRIED).map(|i| low - around + step * i as f64).collect();
    let are_outside = outside_along(job, cell, input, &values, outside);
    InputPanel {
        title: value.title,
        unit: value.unit,
        heading: format!("{name}, {scatter} {}{before}", rounded((std * 1e6).round() / 1e6)),
        expected: job.expected(input, cell),
        outside: ranges(&values, step, |i| are_outside[i]),
        impossible: ranges(&values, step, |i| !are_outside[i] && !quantity.limits.contain(values[i])),
        drawn,
        density,
    }
}

/// Which of some values of an input lie outside the model, if the others have their expected values.
fn outside_along(
    job: &Job,
    cell: &Cell,
    input: usize,
    values: &[f64],
    outside: &dyn Fn(&Columns<'_>) -> Vec<bool>,
) -> Vec<bool> {
    let quantity = job.random.inputs[input];
    let column = |place: usize| match place == quantity {
        true => values.to_vec(),
        false => vec![cell.expected[place]; values.len()],
    };
    let columns: Vec<Vec<f64>> = job.varying().into_iter().map(column).collect();
    outside(&Columns::new(values.len(), &columns.iter().map(Vec::as_slice).collect::<Vec<&[f64]>>()))
}

/// The ranges of values, a step from each other, for which something holds.
fn ranges(values: &[f64], step: f64, holds: impl Fn(usize) -> bool) -> Vec<[f64; 2]> {
    let all: Vec<usize> = (0..values.len()).collect();
    let runs = all.split(|&i| !holds(i)).filter_map(|run| Some([*run.first()?, *run.last()?]));
    runs.map(|[first, last]| [values[first] - 0.5 * step, values[last] + 0.5 * step]).collect()
}
