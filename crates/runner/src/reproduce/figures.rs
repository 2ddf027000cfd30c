//! Figures 4, 12, 13, 14 and 15.

use stickslip_core::rigid_disc::pad_on_disc::PadOnDisc;
use stickslip_sampler::draw::deviates::CHUNK_SAMPLES;
use stickslip_sampler::special_functions::normal;

use super::comparison::{compare, summary};
use crate::commands::FinishedRun;
use crate::evaluate::samples::Drawing;
use crate::failure::Failure;
use crate::files::table::{DescribedColumn, write_columns};
use crate::picture::{curves, picture};
use crate::tables::surface::Surface;
use crate::units;

/// Figures 14 and 15: a surface, and how it compares with the exact one.
pub fn surface(run: &FinishedRun) -> Result<String, Failure> {
    let surface = Surface::new(&run.job, &run.tally);
    let rows = compare(run)?;
    Ok(format!("{}{}data: {}\n", picture(&surface), summary(run, &rows), run.directory.surface().display()))
}

/// Figure 4: the largest real part of the eigenvalues against rotating speed, for each preload.
pub fn growth_rates(run: &FinishedRun) -> Result<String, Failure> {
    let speeds = run.job.grid.rotating_speed.values();
    let mut columns = [const { Vec::new() }; 5];
    let mut lines = Vec::new();
    let mut text = "Figure 4: largest real part of the eigenvalues against rotating speed (rad/s)\n\n".to_owned();
    let (mut critical, mut one_in_si) = (String::new(), String::new());
    for &preload in run.job.grid.preload.values() {
        let brake_at = |speed: f64| {
            let mut parameters = run.job.parameters.clone();
            parameters.operating_point.preload = preload;
            parameters.operating_point.rotating_speed = speed;
            parameters.friction.static_coefficient = run.job.grid.static_friction.values()[0];
            PadOnDisc::new(parameters).map_err(|error| Failure::Job(error.to_string()))
        };
        let mut line = Vec::new();
        for &speed in speeds {
            let brake = brake_at(speed)?;
            let largest = brake.sliding_eigenvalues().iter().map(|value| value.re).fold(f64::NEG_INFINITY, f64::max);
            line.push((speed, largest));
            columns[0].push(speed);
            columns[1].push(preload);
            columns[2].push(largest);
            columns[3].push(brake.speed_under_pad(speed));
            columns[4].push(brake.scales().per_second(largest));
        }
        lines.push(line);
        let brake = brake_at(speeds[0])?;
        let crossing = brake.unstable_speeds().last().map_or("none".to_owned(), |range| {
            format!("{:.3} rad/s ({})", range.to, units::speed(brake.speed_under_pad(range.to)))
        });
        let scales = brake.scales();
        critical += &format!(
            "curve {}: preload {preload} ({}, {}), critical speed {crossing}\n",
            lines.len(),
            units::length(scales.metres(preload)),
            units::force(brake.contact_force(preload))
        );
        one_in_si = units::significant(scales.per_second(1.0));
    }
    text += &curves(&lines);
    text += &critical;
    text +=
        "the floor at -0.02 is the angular motion, which no speed changes; the paper prints 15.56 for preload 0.1\n";
    text += &format!("in SI: a growth rate of 1 in scaled time is {one_in_si} 1/s\n");
    let path = run.directory.path().join("growth_rate.parquet");
    let [speed, preload, growth_rate, under_pad, per_second] = columns;
    write_columns(
        run.directory.path(),
        "growth_rate.parquet",
        &[
            DescribedColumn {
                name: "rotating_speed_rad_s",
                unit: "rad/s",
                long_name: "rotating speed of the disc",
                values: speed,
            },
            DescribedColumn {
                name: "preload",
                unit: "1",
                long_name: "preload, calliper displacement over disc thickness",
                values: preload,
            },
            DescribedColumn {
                name: "growth_rate",
                unit: "1",
                long_name: "largest real part of the eigenvalues, per unit of scaled time",
                values: growth_rate,
            },
            DescribedColumn {
                name: "speed_under_pad_m_s",
                unit: "m/s",
                long_name: "speed of the disc under the pad",
                values: under_pad,
            },
            DescribedColumn {
                name: "growth_rate_per_s",
                unit: "1/s",
                long_name: "largest real part of the eigenvalues",
                values: per_second,
            },
        ],
    )?;
    text += &format!("data: {} and {}\n", path.display(), run.directory.surface().display());
    Ok(text)
}

/// Bins of the input's distribution for one standard deviation.
const BINS_PER_STD: i32 = 2;
const BINS: i32 = 12;

/// Widest bar of a histogram.
const BAR: f64 = 40.0;

/// Figures 12 and 13: the distribution of the random input, and the probability of instability along the axis.
pub fn scattered_input(run: &FinishedRun) -> Result<String, Failure> {
    let job = &run.job;
    let is_preload = job.random.has_preload();
    let mut columns = [Vec::new(), Vec::new(), Vec::new(), Vec::new()];
    let mut text = String::new();
    let cells_per_std = (job.cells() / job.grid.relative_std.len() as u64).max(1);
    for (index, std) in job.grid.relative_std.iter().enumerate() {
        let cell = job.grid.cell(index as u64 * cells_per_std);
        let (std, expected) =
            if is_preload { (std.preload, cell.preload) } else { (std.static_friction, cell.static_friction) };
        let mut bins = [0u64; BINS as usize];
        let mut drawing = Drawing::new(job, &cell, 0, 0..job.sampling.samples, job.points());
        while let Some(samples) = drawing.next_chunk(CHUNK_SAMPLES) {
            let values = if is_preload { samples.preloads() } else { samples.static_frictions() };
            for value in values {
                let z = (value / expected - 1.0) / std;
                let bin = (z * f64::from(BINS_PER_STD)).floor() + f64::from(BINS / 2);
                if (0.0..f64::from(BINS)).contains(&bin) {
                    bins[bin as usize] += 1;
                }
            }
        }
        text += &format!(
            "Relative deviation of the input, standard deviation {std} ({} samples of cell {})\n\n",
            job.sampling.samples, cell.index
        );
        text += "        from        to    share   normal\n";
        for (bin, &count) in bins.iter().enumerate() {
            let edge = |i: i32| f64::from(i - BINS / 2) / f64::from(BINS_PER_STD);
            let (low, high) = (edge(bin as i32), edge(bin as i32 + 1));
            let share = count as f64 / job.sampling.samples as f64;
            let normal_share = normal::upper_tail(low) - normal::upper_tail(high);
            let bar = "█".repeat((share / 0.2 * BAR).round() as usize);
            text += &format!("    {:+8.3}  {:+8.3}   {share:.4}   {normal_share:.4}  {bar}\n", std * low, std * high);
            for (column, value) in columns.iter_mut().zip([std, std * low, std * high, share]) {
                column.push(value);
            }
        }
        text.push('\n');
    }
    let [std, from, to, share] = columns;
    write_columns(
        run.directory.path(),
        "input_distribution.parquet",
        &[
            DescribedColumn {
                name: "std",
                unit: "1",
                long_name: "standard deviation over expected value",
                values: std,
            },
            DescribedColumn {
                name: "deviation_from",
                unit: "1",
                long_name: "lower edge of the bin, deviation over expected value",
                values: from,
            },
            DescribedColumn { name: "deviation_to", unit: "1", long_name: "upper edge of the bin", values: to },
            DescribedColumn { name: "share", unit: "1", long_name: "share of the samples in the bin", values: share },
        ],
    )?;
    text += &surface(run)?;
    text += &format!("      {}\n", run.directory.path().join("input_distribution.parquet").display());
    Ok(text)
}
