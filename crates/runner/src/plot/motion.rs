//! A simulated motion: its displacements and friction over time, and its phase portrait.

use std::path::Path;

use crate::failure::Failure;
use crate::plot::canvas::{Canvas, Pen, Place, Rgb};
use crate::plot::panel::{Arrangement, Axis, Layout, RIGHT};
use crate::plot::scale::Scale;
use crate::tables::finished::read_numbers;

const LAYOUT: Layout = Layout { above: 10.0, right: RIGHT, below: 4.0, aspect: 0.6, most_columns: 2 };

/// Space around a line, over its range.
const AROUND: f64 = 0.06;

const LINE: Rgb = (0x3c, 0x6e, 0xb4);

/// A quantity of a motion: its column, title and unit.
type Quantity = (&'static str, &'static str, &'static str);

const TIME: Quantity = ("time_s", "Time t", "s");
const X: Quantity = ("x_mm", "Tangential displacement x", "mm");
const SPEED: Quantity = ("x_speed_m_s", "Tangential velocity x′", "m/s");
const Y: Quantity = ("y_mm", "Normal displacement y - y(0)", "μm");
const FRICTION: Quantity = ("friction_force_n", "Friction force", "N");

/// What is drawn over what.
const PANELS: [(usize, usize); 4] = [(0, 1), (1, 2), (0, 4), (0, 3)];
const QUANTITIES: [Quantity; 5] = [TIME, X, SPEED, Y, FRICTION];

/// A figure of the time series that `trajectory` and `replay` write, this wide in pixels.
///
/// # Errors
/// A file that is not such a series.
pub fn figure(path: &Path, width: f64) -> Result<Canvas, Failure> {
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
    let Arrangement { panels, height } = LAYOUT.arrange(PANELS.len(), width);
    let mut canvas = Canvas::new(width, height);
    for (panel, (across, up)) in panels.iter().zip(PANELS) {
        let axes = [across, up].map(|which| axis(QUANTITIES[which], &series[which]));
        let place = |(x, y): (&f64, &f64)| -> Place { panel.place(axes[0].scale.at(*x), axes[1].scale.at(*y)) };
        let points: Vec<Place> = series[across].iter().zip(&series[up]).map(place).collect();
        let is_known = |place: &Place| place.0.is_finite() && place.1.is_finite();
        points.split(|place| !is_known(place)).for_each(|part| canvas.lines(part, Pen::new(LINE, 1.0)));
        panel.frame(&mut canvas, &axes[0], &axes[1]);
    }
    Ok(canvas)
}

fn axis((_, title, unit): Quantity, values: &[f64]) -> Axis {
    let known = values.iter().filter(|value| value.is_finite());
    let (low, high) =
        known.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &value| (low.min(value), high.max(value)));
    let (low, high) = if low <= high { (low, high) } else { (0.0, 1.0) };
    let around = AROUND * (high - low);
    let scale = if title == TIME.1 { Scale::linear(low, high) } else { Scale::linear(low - around, high + around) };
    Axis { scale, title: title.to_owned(), unit: unit.to_owned() }
}
