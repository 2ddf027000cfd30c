//! Figures 4, 14 and 15.

use stickslip_core::models::pad_on_disc::model::{PRELOAD, ROTATING_SPEED};

use super::comparison::{compare, summary};
use super::part::{Part, of_surface};
use crate::commands::FinishedRun;
use crate::failure::Failure;
use crate::files::table::{DescribedColumn, write_columns};
use crate::picture::chart::{Chart, ChartAxis, Marks, Series};
use crate::picture::scale::Scale;
use crate::tables::surface::Surface;
use crate::units;

/// Figures 14 and 15: a surface, and how it compares with the exact one.
pub fn surface(run: &FinishedRun) -> Result<Vec<Part>, Failure> {
    let mut parts = of_surface(&Surface::new(&run.job, &run.tally), run.directory.path().to_owned());
    let rows = compare(run)?;
    parts.push(Part::text(format!("{}data: {}\n", summary(run, &rows), run.directory.surface().display())));
    Ok(parts)
}

/// Growth rates that Figure 4 shows: those near zero, where curves cross it.
const SHOWN_GROWTH: (f64, f64) = (-0.05, 0.25);

/// Figure 4: the largest real part of the eigenvalues against rotating speed, for each preload.
pub fn growth_rates(run: &FinishedRun) -> Result<Vec<Part>, Failure> {
    let grid = &run.job.grid;
    let (pad, speeds) = (run.job.pad()?, grid.values_of(ROTATING_SPEED));
    let mut columns = [const { Vec::new() }; 5];
    let mut lines = Vec::new();
    let mut crossings = Vec::new();
    let mut text = String::new();
    let (mut one_in_si, mut highest) = (String::new(), 0.0_f64);
    for preload in grid.values_of(PRELOAD) {
        let brake_at = |speed: f64| {
            let mut expected = grid.cell(0).expected;
            expected[PRELOAD] = preload;
            expected[ROTATING_SPEED] = speed;
            pad.complete_brake(&expected).map_err(|error| Failure::Job(error.to_string()))
        };
        let mut line = Vec::new();
        for &speed in &speeds {
            let brake = brake_at(speed)?;
            let largest = brake.sliding_eigenvalues().iter().map(|value| value.re).fold(f64::NEG_INFINITY, f64::max);
            line.push((speed, largest));
            highest = highest.max(largest);
            columns[0].push(speed);
            columns[1].push(preload);
            columns[2].push(largest);
            columns[3].push(brake.speed_under_pad(speed));
            columns[4].push(brake.scales().per_second(largest));
        }
        lines.push(Series::numbered(lines.len(), format!("preload {preload}"), line));
        let brake = brake_at(speeds[0])?;
        let crossing = brake.unstable_speeds().last().map_or("none".to_owned(), |range| {
            crossings.push((1e3 * range.to).round() * 1e-3);
            format!("{:.3} rad/s ({})", range.to, units::speed(brake.speed_under_pad(range.to)))
        });
        let scales = brake.scales();
        text += &format!(
            "preload {preload} ({}, {}): critical speed {crossing}\n",
            units::length(scales.metres(preload)),
            units::force(brake.contact_force(preload))
        );
        one_in_si = units::significant(scales.per_second(1.0));
    }
    let speed = ChartAxis::new("Rotating speed", "rad/s", Scale::for_values(&speeds));
    let growth = ChartAxis::new("Growth rate in scaled time", "", Scale::linear(SHOWN_GROWTH.0, SHOWN_GROWTH.1));
    let mut chart =
        Chart::new("Figure 4: largest real part of the eigenvalues against rotating speed", speed, growth, lines);
    chart.has_zero_line = true;
    chart.marks = Some(Marks { what: "critical speeds".to_owned(), values: crossings });
    text += &format!(
        "above zero steady sliding is unstable; towards slow speeds the curves go on\n\
         up to {highest:.1}\n\
         the floor at -0.02 is the angular motion, which no speed changes\n\
         the paper prints 15.56 for preload 0.1\n"
    );
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
    Ok(vec![Part::chart(chart), Part::Text(text)])
}
