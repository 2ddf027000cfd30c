//! A simulated motion: its displacements and friction over time, its phase portrait and its spectrum.

use std::ops::Range;
use std::path::Path;

use crate::failure::Failure;
use crate::picture::chart::{Chart, ChartAxis, Series};
use crate::picture::scale::Scale;
use crate::plot::canvas::Canvas;
use crate::plot::chart;
use crate::spectrum::{Spectrum, spectrum};
use crate::tables::finished::read_numbers;

/// A quantity of a motion: its column, title and unit.
type Quantity = (&'static str, &'static str, &'static str);

const TIME: Quantity = ("time_s", "Time t", "s");
const X: Quantity = ("x_mm", "Tangential displacement x", "mm");
const SPEED: Quantity = ("x_speed_m_s", "Tangential velocity x′", "m/s");
const Y: Quantity = ("y_mm", "Normal displacement y - y(0)", "μm");
const FRICTION: Quantity = ("friction_force_n", "Friction force", "N");
const CONTACT: Quantity = ("contact_force_n", "Contact force", "N");

const QUANTITIES: [Quantity; 6] = [TIME, X, SPEED, Y, FRICTION, CONTACT];

/// The least number of moments of a part of a motion.
const LEAST_MOMENTS: usize = 10;

/// What is drawn over what: always, and where the disc under the pad moves. Without it, the contact force stays as it is.
const PANELS: [(usize, usize); 3] = [(0, 1), (1, 2), (0, 4)];
const OF_THE_DISC: [(usize, usize); 2] = [(0, 5), (0, 3)];

/// The part of a whole motion that its spectrum is taken of, at the end, and the frequencies that are shown: up to so many
/// times that of the highest peak, with amplitudes down to this share of it.
const SETTLED: f64 = 0.5;
const MULTIPLES: f64 = 12.0;
const LEAST_SHARE: f64 = 1e-5;

/// What is drawn of a motion: from and to which time, if not all of it, and under which title.
#[derive(Debug, Clone, Copy, Default)]
pub struct Excerpt<'a> {
    pub from: Option<f64>,
    pub to: Option<f64>,
    pub title: Option<&'a str>,
}

/// A figure of the time series that `trajectory` and `replay` write, this wide in pixels.
///
/// # Errors
/// A file that is not such a series, and times at which it has none.
pub fn figure(path: &Path, excerpt: Excerpt<'_>, width: f64) -> Result<Canvas, Failure> {
    let wrong = |why: &str| {
        Failure::InputOutput(format!(
            "{}: neither a run directory nor the time series of a motion, as `stickslip trajectory --out FILE.parquet` writes it: {why}",
            path.display()
        ))
    };
    let series = read_numbers(path, QUANTITIES.map(|(column, ..)| column)).map_err(|why| wrong(&why))?;
    let mut series =
        series.map(|column| column.into_iter().map(|value| value.unwrap_or(f64::NAN)).collect::<Vec<f64>>());
    if series[0].len() < 2 {
        return Err(wrong("it has fewer than two rows"));
    }
    // The pad moves by micrometres about the millimetre by which the preload shifts it.
    let start = series[3][0];
    series[3].iter_mut().for_each(|y| *y = 1e3 * (*y - start));
    let is_flexible = series[3].iter().any(|y| *y != 0.0);
    let part = excerpt.moments(&series[0]).map_err(|why| Failure::Usage(format!("{}: {why}", path.display())))?;
    let series = series.map(|column| column[part.clone()].to_vec());
    let over = |(across, up): (usize, usize)| {
        let points = series[across].iter().copied().zip(series[up].iter().copied()).collect();
        Chart::new(
            "",
            axis(QUANTITIES[across], &series[across]),
            axis(QUANTITIES[up], &series[up]),
            vec![Series::line(points)],
        )
    };
    let panels = PANELS.into_iter().chain(OF_THE_DISC.into_iter().filter(|_| is_flexible));
    let mut charts: Vec<Chart> = panels.map(over).collect();
    let (share, title) = if excerpt.from.or(excerpt.to).is_some() {
        (1.0, "Spectrum of x in this time")
    } else {
        (SETTLED, "Spectrum of x in the second half")
    };
    let settled = &series[1][(series[1].len() as f64 * (1.0 - share)) as usize..];
    charts.extend(of_spectrum(title, &spectrum(settled, series[0][1] - series[0][0])));
    Ok(chart::titled_figure(excerpt.title.unwrap_or_default(), &charts.iter().collect::<Vec<_>>(), width))
}

impl Excerpt<'_> {
    /// Which moments of a motion are drawn, of its times in ascending order.
    fn moments(&self, times: &[f64]) -> Result<Range<usize>, String> {
        let (first, last) = (times[0], times[times.len() - 1]);
        let (from, to) = (self.from.unwrap_or(first), self.to.unwrap_or(last));
        if let Some(outside) = self.from.filter(|from| *from >= last) {
            return Err(format!("--from {outside} is not before its end at {last} s"));
        }
        if from >= to {
            return Err(format!("--from {from} is not before --to {to}; the motion lasts from {first} s to {last} s"));
        }
        if let Some(outside) = self.to.filter(|to| *to > last) {
            return Err(format!("--to {outside} is after its end at {last} s"));
        }
        let part = times.partition_point(|time| *time < from)..times.partition_point(|time| *time <= to);
        if part.len() < LEAST_MOMENTS {
            return Err(format!(
                "from {from} s to {to} s it has {} moments, which are {} s apart; a picture needs {LEAST_MOMENTS}",
                part.len(),
                times[1] - first
            ));
        }
        Ok(part)
    }
}

fn axis((_, title, unit): Quantity, values: &[f64]) -> ChartAxis {
    let scale = match values {
        [first, .., last] if title == TIME.1 => Scale::linear(*first, *last),
        values => Scale::around(values.iter().copied()),
    };
    ChartAxis::new(title, unit, scale)
}

/// The amplitudes of x, if it moves.
fn of_spectrum(title: &str, spectrum: &Spectrum) -> Option<Chart> {
    let &(frequency, highest) = spectrum.peaks(1, 1.0).first()?;
    let points: Vec<(f64, f64)> =
        spectrum.frequencies.iter().copied().zip(spectrum.amplitudes.iter().copied()).collect();
    let last = spectrum.frequencies.last().copied()?.min(MULTIPLES * frequency);
    Some(Chart::new(
        title,
        ChartAxis::new("Frequency", "Hz", Scale::linear(0.0, last)),
        ChartAxis::new("Amplitude of x", "mm", Scale::logarithmic(LEAST_SHARE * highest, 2.0 * highest)),
        vec![Series::line(points)],
    ))
}
