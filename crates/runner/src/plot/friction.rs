//! A measured friction curve: its rows, the curve that goes through or between them, and where steady sliding is unstable.

use crate::picture::scale::Scale;
use crate::plot::canvas::{Canvas, Pen, Place, Rgb};
use crate::plot::chart::simplified;
use crate::plot::legend::Legend;
use crate::plot::panel::{Axis, LEFT, OnePanel, RIGHT};

/// Height of the panel over its width.
const ASPECT: f64 = 0.6;

/// Space between the panel and the legend.
const BEFORE: f64 = 8.0;

/// Radius of a point and width of the curve.
const POINT: f64 = 2.0;
const LINE: f64 = 1.6;

const ROW: Rgb = (0x1a, 0x1a, 0x1a);
const CURVE: Rgb = (0x00, 0x72, 0xb2);
const UNSTABLE: Rgb = (0xf4, 0xd9, 0xd9);

/// What is drawn. Speeds are in m/s.
pub struct FrictionPlot {
    /// Speeds with their coefficients, as measured.
    pub rows: Vec<(f64, f64)>,
    /// Places of the curve.
    pub curve: Vec<(f64, f64)>,
    /// Where steady sliding is unstable.
    pub unstable: Vec<[f64; 2]>,
    pub title: String,
    pub notes: Vec<String>,
}

impl FrictionPlot {
    /// The figure, this wide in pixels.
    pub fn figure(&self, width: f64) -> Canvas {
        let entries = [
            (true, ROW, "rows of the table"),
            (true, CURVE, "curve of the model"),
            (!self.unstable.is_empty(), UNSTABLE, "steady sliding is unstable"),
        ];
        let entries = entries.into_iter().filter(|(is_there, ..)| *is_there);
        let entries = entries.map(|(_, colour, name)| (colour, name.to_owned()));
        let legend = Legend::new(entries.collect(), width - LEFT - RIGHT);
        let mut figure = OnePanel::new(width, ASPECT, BEFORE + legend.height(), &self.notes);
        let under = (figure.panel.left, figure.between() + BEFORE);
        let last = self.rows.iter().map(|row| row.0).fold(0.0, f64::max);
        let coefficients = self.rows.iter().chain(&self.curve).map(|place| place.1);
        let across =
            Axis { scale: Scale::linear(0.0, last), title: "Sliding speed".to_owned(), unit: "m/s".to_owned() };
        let up =
            Axis { scale: Scale::around(coefficients), title: "Friction coefficient".to_owned(), unit: String::new() };
        let OnePanel { canvas, panel, .. } = &mut figure;
        let panel = *panel;
        for range in &self.unstable {
            let [left, right] = range.map(|speed| panel.place(across.scale.at(speed), 0.0).0);
            canvas.area(&[panel.rectangle((left, panel.top), (right, panel.bottom()))], UNSTABLE, 1.0);
        }
        let place = |&(speed, coefficient): &(f64, f64)| -> Place {
            panel.place(across.scale.at(speed), up.scale.at(coefficient))
        };
        for row in &self.rows {
            canvas.dot(place(row), POINT, ROW);
        }
        let line: Vec<Place> = self.curve.iter().map(place).collect();
        canvas.lines(&simplified(&line), Pen::new(CURVE, LINE));
        legend.draw(canvas, under);
        figure.finish(&across, &up, &self.title)
    }
}
