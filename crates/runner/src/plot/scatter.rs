//! Single samples as points over two of their values.

use indicatif::HumanCount;

use crate::picture::scale::Scale;
use crate::plot::canvas::{Canvas, Rgb};
use crate::plot::legend::Legend;
use crate::plot::panel::{Axis, LEFT, OnePanel, RIGHT};

/// Height of the panel over its width.
const ASPECT: f64 = 0.62;

/// Space between the panel and the legend.
const BEFORE: f64 = 8.0;

/// Radius of a point.
const POINT: f64 = 1.7;

/// A kind of points.
pub struct Kind {
    pub name: String,
    pub colour: Rgb,
    /// Across and up.
    pub places: Vec<[f64; 2]>,
}

/// What the points lie over.
pub struct Value {
    pub title: String,
    pub unit: String,
}

/// What is drawn.
pub struct ScatterPlot {
    /// Across and up.
    pub axes: [Value; 2],
    /// Those that come later are drawn over those before.
    pub kinds: Vec<Kind>,
    pub title: String,
    pub notes: Vec<String>,
}

impl ScatterPlot {
    /// The figure, this wide in pixels.
    pub fn figure(&self, width: f64) -> Canvas {
        let is_there = |points: &&Kind| !points.places.is_empty();
        let entries = self.kinds.iter().filter(is_there);
        let entries = entries
            .map(|points| (points.colour, format!("{} ({})", points.name, HumanCount(points.places.len() as u64))));
        let legend = Legend::new(entries.collect(), width - LEFT - RIGHT);
        let mut figure = OnePanel::new(width, ASPECT, BEFORE + legend.height(), &self.notes);
        let under = (figure.panel.left, figure.between() + BEFORE);
        let OnePanel { canvas, panel, .. } = &mut figure;
        let all = || self.kinds.iter().flat_map(|points| &points.places);
        let [across, up] = [0, 1].map(|axis| Axis {
            scale: Scale::around(all().map(|place| place[axis])),
            title: self.axes[axis].title.clone(),
            unit: self.axes[axis].unit.clone(),
        });
        for Kind { places, colour, .. } in &self.kinds {
            for [right, high] in places {
                canvas.dot(panel.place(across.scale.at(*right), up.scale.at(*high)), POINT, *colour);
            }
        }
        legend.draw(canvas, under);
        figure.finish(&across, &up, &self.title)
    }
}
