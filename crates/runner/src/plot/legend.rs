//! A legend below the panels of a figure: colours with their names.

use crate::plot::canvas::{BLACK, Canvas, Place, Rgb, Side, width_of};
use crate::plot::panel::{Panel, SMALL};

/// Size of text, side of a sample of a colour, spaces after the sample and after the name, and distance of lines.
const SIZE: u32 = SMALL - 1;
const SAMPLE: f64 = 9.0;
const GAP: f64 = 4.0;
const BETWEEN: f64 = 14.0;
const LINE: f64 = 15.0;

/// Colours with their names, in lines that fit in a width.
pub struct Legend {
    lines: Vec<Vec<(f64, Rgb, String)>>,
}

impl Legend {
    /// Arranges the entries beside each other, and below each other where they do not fit.
    pub fn new(entries: Vec<(Rgb, String)>, width: f64) -> Self {
        let mut lines: Vec<Vec<(f64, Rgb, String)>> = Vec::new();
        let mut right = f64::INFINITY;
        for (colour, name) in entries {
            let length = SAMPLE + GAP + width_of(&name, SIZE);
            if right + length > width {
                lines.push(Vec::new());
                right = 0.0;
            }
            if let Some(line) = lines.last_mut() {
                line.push((right, colour, name));
            }
            right += length + BETWEEN;
        }
        Self { lines }
    }

    pub fn height(&self) -> f64 {
        LINE * self.lines.len() as f64
    }

    /// Draws it below and to the right of a place.
    pub fn draw(&self, canvas: &mut Canvas, (left, top): Place) {
        for (number, line) in self.lines.iter().enumerate() {
            let top = top + number as f64 * LINE;
            for (right, colour, name) in line {
                let sample = Panel { left: left + right, top, width: SAMPLE, height: SAMPLE };
                let corner = (sample.left, sample.top);
                canvas.area(&[sample.rectangle(corner, (sample.right(), sample.bottom()))], *colour, 1.0);
                sample.outline(canvas);
                let beside = (sample.right() + GAP, top + SAMPLE - 1.0);
                canvas.text(beside, name, SIZE, Side::Right, 0.0, BLACK);
            }
        }
    }
}
