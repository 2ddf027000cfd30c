//! What the pictures of a cell have in common.

use stickslip_core::model::IsStopped;
use stickslip_core::model::quantity::Quantity;
use stickslip_sampler::grid::Cell;

use crate::commands::drawn_samples::{Add, DrawnSamples, draw};
use crate::evaluate::evaluator::Evaluator;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::job::Job;
use crate::picture::title::title;
use crate::picture::view::GridView;
use crate::plot::scatter::Value;

/// Samples that are looked at one by one, and those of models whose samples take long.
pub const SAMPLES: u64 = 2000;
pub const FEW_SAMPLES: u64 = 200;

/// Samples of a unit of work.
const UNIT_SAMPLES: u64 = 50;

/// Refuses a cell in which nothing scatters.
pub fn require_scatter(job: &Job, cell: &Cell) -> Result<(), Failure> {
    if (0..job.random.inputs.len()).any(|input| job.std(input, cell) != 0.0) {
        return Ok(());
    }
    Err(Failure::Job(format!(
        "nothing scatters in cell {} of \"{}\", so that all its samples are one: name inputs in random.inputs and give them a relative_std, or choose another cell with --cell",
        cell.index, job.name
    )))
}

/// The first samples of a cell, drawn at random, with their decisions.
pub fn first_samples(
    job: &Job,
    cell: u64,
    samples: u64,
    threads: usize,
    interrupt: &Interrupt,
) -> Result<DrawnSamples, Failure> {
    let evaluator = Evaluator::new(job)?;
    let units: Vec<u64> = (0..samples).step_by(UNIT_SAMPLES as usize).collect();
    let of_unit = |&first: &u64, is_stopped: IsStopped<'_>, add: Add<'_>| {
        evaluator.each_random(cell, first..samples.min(first + UNIT_SAMPLES), is_stopped, add);
    };
    draw(&units, samples, threads, interrupt, of_unit)
}

/// A quantity as the axis of a picture.
pub fn value_of(quantity: &Quantity) -> Value {
    Value { title: title(quantity), unit: unit(&quantity.unit).to_owned() }
}

/// A unit as pictures have it: nothing for a pure number.
pub fn unit(unit: &str) -> &str {
    if unit == "1" { "" } else { unit }
}

/// Which cell a picture shows, by the values of the axes.
pub fn place(job: &Job, cell: u64) -> String {
    let place = GridView::new(job).place_of(job, cell);
    if place.is_empty() { format!("cell {cell}") } else { format!("cell {cell}: {place}") }
}
