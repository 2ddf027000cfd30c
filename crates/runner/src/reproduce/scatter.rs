//! Figures 12 and 13: the distribution of the random input, and the probability of instability along its axis.

use stickslip_sampler::draw::deviates::CHUNK_SAMPLES;
use stickslip_sampler::special_functions::normal;

use super::figures::surface;
use super::part::Part;
use crate::commands::FinishedRun;
use crate::evaluate::samples::Drawing;
use crate::failure::Failure;
use crate::files::table::{DescribedColumn, write_columns};
use crate::picture::chart::{Chart, ChartAxis, Series};
use crate::picture::scale::Scale;

/// Bins of the input's distribution for one standard deviation.
const BINS_PER_STD: i32 = 2;
const BINS: i32 = 12;

/// `reproduce fig12` and `fig13`.
pub fn scattered_input(run: &FinishedRun) -> Result<Vec<Part>, Failure> {
    let job = &run.job;
    let [preload, friction] = job.random.pair();
    let Some(input) = preload.or(friction) else { return surface(run) };
    let mut columns = [Vec::new(), Vec::new(), Vec::new(), Vec::new()];
    let mut series = Vec::new();
    let mut largest_difference = 0.0_f64;
    let (mut widest, mut densest) = (0.0_f64, 0.0_f64);
    let cells_per_std = (job.cells() / job.grid.scatters as u64).max(1);
    for index in 0..job.grid.scatters {
        let cell = job.grid.cell(index as u64 * cells_per_std);
        let (std, expected) = (job.std(input, &cell), job.expected(input, &cell));
        let mut bins = [0u64; BINS as usize];
        let mut drawing = Drawing::new(job, &cell, 0, 0..job.sampling.samples, job.points());
        while let Some(samples) = drawing.next_chunk(CHUNK_SAMPLES) {
            for sample in 0..samples.len() {
                let value = samples.values(sample).nth(input).unwrap_or(f64::NAN);
                let z = (value / expected - 1.0) / std;
                let bin = (z * f64::from(BINS_PER_STD)).floor() + f64::from(BINS / 2);
                if (0.0..f64::from(BINS)).contains(&bin) {
                    bins[bin as usize] += 1;
                }
            }
        }
        let mut steps = Vec::new();
        for (bin, &count) in bins.iter().enumerate() {
            let edge = |i: i32| f64::from(i - BINS / 2) / f64::from(BINS_PER_STD);
            let (low, high) = (edge(bin as i32), edge(bin as i32 + 1));
            let share = count as f64 / job.sampling.samples as f64;
            let normal_share = normal::upper_tail(low) - normal::upper_tail(high);
            largest_difference = largest_difference.max((share - normal_share).abs());
            let density = share / (std * (high - low));
            densest = densest.max(density);
            widest = widest.max(std * high);
            steps.extend([(std * low, density), (std * high, density)]);
            for (column, value) in columns.iter_mut().zip([std, std * low, std * high, share]) {
                column.push(value);
            }
        }
        series.push(Series::numbered(index, format!("standard deviation {std}"), steps));
    }
    let chart = Chart::new(
        format!("Distribution of the random {}", job.quantity_of(input).noun()),
        ChartAxis::new("Deviation over the expected value", "", Scale::linear(-widest, widest)),
        ChartAxis::new("Density", "", Scale::linear(0.0, 1.1 * densest)),
        series,
    );
    let [std, from, to, share] = columns;
    let column = |name, long_name, values| DescribedColumn { name, unit: "1", long_name, values };
    write_columns(
        run.directory.path(),
        "input_distribution.parquet",
        &[
            column("std", "standard deviation over expected value", std),
            column("deviation_from", "lower edge of the bin, deviation over expected value", from),
            column("deviation_to", "upper edge of the bin", to),
            column("share", "share of the samples in the bin", share),
        ],
    )?;
    let mut parts = vec![
        Part::chart(chart),
        Part::text(format!(
            "{} samples of one cell for each standard deviation; the shares of the bins\n\
             differ from those of the normal distribution by at most {largest_difference:.4}\n\n",
            job.sampling.samples
        )),
    ];
    parts.extend(surface(run)?);
    parts.push(Part::text(format!("      {}\n", run.directory.path().join("input_distribution.parquet").display())));
    Ok(parts)
}
