//! The frequencies at which the samples of a cell are unstable.

use stickslip_core::model::{Columns, IsStopped};
use stickslip_sampler::draw::deviates::Points;
use stickslip_sampler::grid::Cell;

use super::lines::fixed;
use super::{JobModes, failed};
use crate::evaluate::samples::Drawing;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::job::Job;
use crate::output::counted;
use crate::picture::view::{rounded, scatter};
use crate::plot::frequencies::FrequencyPlot;
use crate::schedule::engine::{Engine, Outcome};

/// Samples that are drawn, and those of full matrices, of which each takes some second.
pub const SAMPLES: u64 = 10_000;
const FEW_SAMPLES: u64 = 200;

/// Units of work.
const UNITS: u64 = 40;

/// The picture of a cell of a job, from the first samples, of full matrices from few of them.
pub fn frequencies(
    job: &Job,
    cell: &Cell,
    samples: u64,
    threads: usize,
    interrupt: &Interrupt,
) -> Result<FrequencyPlot, Failure> {
    let problem = JobModes::new(job)?;
    let samples = if problem.is_sparse() { samples.min(FEW_SAMPLES) } else { samples };
    let found = found(job, cell, samples, threads, interrupt)?;
    let frequencies: Vec<f64> = found.into_iter().filter(|frequency| !frequency.is_nan()).collect();
    let (parameters, regions) = (problem.parameters(&cell.expected), problem.regions(&cell.expected));
    let eigenvalues = problem.model.eigenvalues(parameters, &regions).map_err(|error| failed(job, &error))?;
    let modes = eigenvalues.iter().map(|value| value.im / std::f64::consts::TAU).filter(|frequency| *frequency > 0.0);
    let share = rounded(frequencies.len() as f64 / samples as f64);
    Ok(FrequencyPlot {
        samples,
        modes: modes.collect(),
        title: fixed(job, cell, usize::MAX),
        notes: vec![
            format!(
                "cell {}: {} of {} unstable, P = {share}; {}",
                cell.index,
                frequencies.len(),
                counted(samples.into(), "sample", "samples"),
                scatter(job, cell.index)
            ),
            "each at the frequency of its least damped mode; marks above: the modes of the expected values".to_owned(),
        ],
        frequencies,
    })
}

/// The frequency of each sample, not a number for those that are stable.
fn found(job: &Job, cell: &Cell, samples: u64, threads: usize, interrupt: &Interrupt) -> Result<Vec<f64>, Failure> {
    let wrong = |why: String| Failure::Job(format!("the job \"{}\": {why}", job.name));
    let configuration = job.model().configure(&cell.expected, &job.varying(), None);
    let configuration = configuration.map_err(|error| wrong(error.to_string()))?;
    let length = samples / UNITS;
    let mut found: Vec<Option<Vec<f64>>> = vec![None; UNITS as usize];
    let of_unit = |unit: u64, _: IsStopped<'_>| {
        let mut drawing = Drawing::new(job, cell, 0, unit * length..(unit + 1) * length, Points::Random);
        let mut frequencies = Some(Vec::new());
        while let Some(chunk) = drawing.next_chunk(length as usize) {
            let chunk = configuration.unstable_frequencies(&Columns::new(chunk.len(), &chunk.columns()));
            frequencies = frequencies.zip(chunk).map(|(mut all, chunk)| {
                all.extend(chunk);
                all
            });
        }
        (unit as usize, frequencies)
    };
    let outcome = Engine::new(threads)?.for_each_in_parallel(UNITS, interrupt, of_unit, |(unit, frequencies)| {
        found[unit] = frequencies;
    })?;
    if let Outcome::Stopped(signal) = outcome {
        return Err(Failure::stopped(signal, &"nothing was written".into()));
    }
    let all: Option<Vec<Vec<f64>>> = found.into_iter().collect();
    Ok(all.ok_or_else(|| wrong("its model knows no frequencies of its samples".to_owned()))?.concat())
}
