//! The distributions of random inputs, one beside the other, and the correlated ones over each other.

use crate::picture::scale::{Scale, ends};
use crate::plot::canvas::{Canvas, GREY, Pen, Place, Rgb};
use crate::plot::histogram::Histogram;
use crate::plot::legend::Legend;
use crate::plot::panel::{
    ABOVE, Arrangement, Axis, LEFT, Layout, Panel, RIGHT, heading, in_lines, space_of, write_notes,
};

/// Height of a panel over its width.
const ASPECT: f64 = 0.68;

/// Panels for which there is space at the least, where two fit beside each other.
const LEAST: usize = 2;

/// Bars over the values of an input.
const BARS: usize = 50;

/// Space of a density above its highest place.
const SPACE: f64 = 1.08;

/// Space between the panels and the legend.
const BEFORE: f64 = 8.0;

/// Radius of a point, and how many are drawn at most.
const POINT: f64 = 1.1;
const MOST_POINTS: usize = 2000;

const DRAWN: Rgb = (0xb3, 0xd9, 0xf2);
const CURVE: Rgb = (0x00, 0x72, 0xb2);
const OUTSIDE: Rgb = (0xf4, 0xd9, 0xd9);
const IMPOSSIBLE: Rgb = (0xdc, 0xdc, 0xdc);
const OUTSIDE_POINT: Rgb = (0xc0, 0x30, 0x30);

/// An input.
pub struct InputPanel {
    pub title: String,
    pub unit: String,
    /// What stands above.
    pub heading: String,
    pub expected: f64,
    /// Drawn values.
    pub drawn: Vec<f64>,
    /// Values with their densities; none of measured values.
    pub density: Vec<[f64; 2]>,
    /// Where values lie outside the model, if the others have their expected values.
    pub outside: Vec<[f64; 2]>,
    /// Where values are not possible, so that a sample fails.
    pub impossible: Vec<[f64; 2]>,
}

/// Two correlated inputs.
pub struct PairPanel {
    /// Their places among the inputs.
    pub inputs: [usize; 2],
    pub coefficient: String,
}

/// What is drawn.
pub struct InputsPlot {
    pub inputs: Vec<InputPanel>,
    pub pairs: Vec<PairPanel>,
    /// Which of the drawn samples lie outside the model.
    pub are_outside: Vec<bool>,
    pub notes: Vec<String>,
}

impl InputsPlot {
    /// The figure, this wide in pixels.
    pub fn figure(&self, width: f64) -> Canvas {
        let notes = in_lines(&self.notes, width);
        let has_outside = self.are_outside.contains(&true) || self.inputs.iter().any(|input| !input.outside.is_empty());
        let has_impossible = self.inputs.iter().any(|input| !input.impossible.is_empty());
        let has_density = self.inputs.iter().any(|input| !input.density.is_empty());
        let entries = [
            (true, DRAWN, "drawn"),
            (has_density, CURVE, "density"),
            (has_outside, OUTSIDE, "outside the model"),
            (has_impossible, IMPOSSIBLE, "not possible: the sample fails"),
        ];
        let entries = entries.into_iter().filter(|(is_there, ..)| *is_there);
        let legend = Legend::new(entries.map(|(_, colour, name)| (colour, name.to_owned())).collect(), width - LEFT);
        let below = BEFORE + legend.height() + space_of(&notes);
        let layout = Layout { above: ABOVE, right: RIGHT, below, aspect: ASPECT, most_columns: 2 };
        // One panel is not wider than one of two.
        let Arrangement { panels, height } = layout.arrange((self.inputs.len() + self.pairs.len()).max(LEAST), width);
        let mut canvas = Canvas::new(width, height);
        for (input, panel) in self.inputs.iter().zip(&panels) {
            input.draw(&mut canvas, panel);
        }
        for (pair, panel) in self.pairs.iter().zip(panels.iter().skip(self.inputs.len())) {
            self.draw_pair(&mut canvas, panel, pair);
        }
        legend.draw(&mut canvas, (LEFT, height - below + BEFORE));
        write_notes(&mut canvas, &notes, height);
        canvas
    }

    fn draw_pair(&self, canvas: &mut Canvas, panel: &Panel, pair: &PairPanel) {
        let [across, up] = pair.inputs.map(|input| &self.inputs[input]);
        let axes = [across.axis(), up.axis()];
        let samples = across.drawn.iter().zip(&up.drawn).zip(&self.are_outside).take(MOST_POINTS);
        for ((&right, &high), &is_outside) in samples {
            let at = panel.place(axes[0].scale.at(right), axes[1].scale.at(high));
            if panel.contains(at) {
                canvas.dot(at, POINT, if is_outside { OUTSIDE_POINT } else { CURVE });
            }
        }
        panel.frame(canvas, &axes[0], &axes[1]);
        heading(canvas, panel, &format!("correlation {}", pair.coefficient));
    }
}

impl InputPanel {
    /// The range of its values, and its place in figures.
    fn axis(&self) -> Axis {
        let of_density = self.density.iter().map(|[value, _]| *value);
        let values = of_density.chain(self.drawn.iter().copied()).chain([self.expected]);
        Axis { scale: Scale::around(values), title: self.title.clone(), unit: self.unit.clone() }
    }

    fn draw(&self, canvas: &mut Canvas, panel: &Panel) {
        let across = self.axis();
        let histogram =
            Histogram::new(self.drawn.iter().map(|value| (*value, 1)), ends(self.drawn.iter().copied()), BARS);
        let density = 1.0 / (histogram.width() * self.drawn.len().max(1) as f64);
        // A density may be infinite at its ends.
        let drawn = density * histogram.highest() as f64;
        let highest = self.density.iter().map(|[_, density]| *density).fold(0.0, f64::max);
        let highest = if highest < 2.0 * drawn { highest.max(drawn) } else { drawn };
        let per = match (self.unit.as_str(), self.unit.strip_prefix("1/")) {
            ("", _) => String::new(),
            (_, Some(unit)) => unit.to_owned(),
            (unit, None) => format!("per {unit}"),
        };
        let up = Axis { scale: Scale::linear(0.0, SPACE * highest), title: "Density".to_owned(), unit: per };
        for (ranges, colour) in [(&self.outside, OUTSIDE), (&self.impossible, IMPOSSIBLE)] {
            for range in ranges {
                let [left, right] = range.map(|end| panel.place(across.scale.at(end), 0.0).0);
                if left < panel.right() && right > panel.left {
                    canvas.area(&[panel.rectangle((left, panel.top), (right, panel.bottom()))], colour, 1.0);
                }
            }
        }
        histogram.draw(canvas, panel, [&across, &up], density, DRAWN);
        let curve: Vec<Place> = self
            .density
            .iter()
            .filter(|[_, density]| *density <= SPACE * highest)
            .map(|&[value, density]| panel.place(across.scale.at(value), up.scale.at(density)))
            .collect();
        canvas.lines(&curve, Pen::new(CURVE, 1.6));
        let at = across.scale.at(self.expected);
        canvas.dashes(&[panel.place(at, 0.0), panel.place(at, 1.0)], Pen::new(GREY, 0.9));
        panel.frame(canvas, &across, &up);
        heading(canvas, panel, &self.heading);
    }
}
