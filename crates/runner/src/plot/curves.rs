//! Curves along an axis with their intervals.

use crate::job::Job;
use crate::picture::panels::drawn_slices;
use crate::picture::view::{GridView, rounded};
use crate::plot::axes::axis;
use crate::plot::canvas::{BLACK, Canvas, GREY, Pen, Place, Rgb, Side};
use crate::plot::form::Along;
use crate::plot::panel::{
    ABOVE, Arrangement, Axis, Layout, NORMAL, Panel, RIGHT, SMALL, heading, in_lines, space_of, wrapped, write_notes,
};

/// Height of a panel over its width.
const ASPECT: f64 = 0.6;

/// Space for the legend at the right.
const LEGEND: f64 = 74.0;

/// Most points of a curve that are marked.
const MOST_MARKS: usize = 40;

/// What is drawn as curves: a number for each cell, with the ends of its interval.
pub struct Curves<'a> {
    pub job: &'a Job,
    pub view: &'a GridView,
    pub along: Along<'a>,
    pub values: &'a [Option<f64>],
    pub low: &'a [f64],
    pub high: &'a [f64],
    /// The axis of the numbers. What lies beyond its ends is drawn at them.
    pub vertical: Axis,
    /// Whether there is a line at zero.
    pub has_zero: bool,
    /// Another line, with its label.
    pub target: Option<(f64, String)>,
    /// What else is to be said.
    pub notes: Vec<String>,
}

impl Curves<'_> {
    /// The figure, with a panel for each combination of the axes that are not shown.
    pub fn figure(&self, width: f64) -> Canvas {
        let has_legend = self.family().len() > 1;
        let notes = in_lines(&self.notes, width);
        let slices = drawn_slices(self.view);
        let right = if has_legend { RIGHT + LEGEND } else { RIGHT };
        let layout = Layout { above: ABOVE, right, below: space_of(&notes), aspect: ASPECT, most_columns: usize::MAX };
        let Arrangement { panels, height } = layout.arrange(slices.len(), width);
        let mut canvas = Canvas::new(width, height);
        for (number, panel) in slices.into_iter().zip(&panels) {
            self.panel(&mut canvas, panel, number);
        }
        self.legend(&mut canvas, &panels);
        write_notes(&mut canvas, &notes, height);
        canvas
    }

    /// The values that have a curve each.
    fn family(&self) -> &[f64] {
        self.along.several.map_or(&[f64::NAN][..], |axis| &axis.values)
    }

    fn panel(&self, canvas: &mut Canvas, panel: &Panel, number: usize) {
        let slice = self.view.slice(number);
        let along = axis(self.along.axis);
        if self.has_zero {
            let at = |right: f64| panel.place(right, self.vertical.scale.at(0.0));
            canvas.dashes(&[at(0.0), at(1.0)], Pen::new(GREY, 0.8));
        }
        if let Some((target, label)) = &self.target {
            let at = |right: f64| panel.place(right, self.vertical.scale.at(*target));
            canvas.dashes(&[at(0.0), at(1.0)], Pen::new(BLACK, 1.0));
            let above = (at(1.0).0 - 3.0, at(1.0).1 - 3.0);
            canvas.text(above, label, SMALL - 1, Side::Left, 0.0, BLACK);
        }
        let family = self.family().len();
        for up in 0..family {
            let colour = colour_of(up, family);
            let place = |right: usize, value: f64| {
                panel
                    .place(along.scale.at(self.along.axis.values[right]), self.vertical.scale.at(value).clamp(0.0, 1.0))
            };
            let cell = |right: usize| {
                let (up, right) = if self.along.is_vertical { (right, up) } else { (up, right) };
                slice.cell(up, right) as usize
            };
            let known = |right: &usize| self.values[cell(*right)].is_some();
            let all: Vec<usize> = (0..self.along.axis.values.len()).collect();
            for part in all.split(|right| !known(right)).filter(|part| !part.is_empty()) {
                let upper: Vec<Place> = part.iter().map(|&right| place(right, self.high[cell(right)])).collect();
                let lower: Vec<Place> = part.iter().map(|&right| place(right, self.low[cell(right)])).collect();
                match (&upper[..], &lower[..]) {
                    // A point between gaps has no band.
                    ([upper], [lower]) => canvas.line(*lower, *upper, Pen::new(colour, 1.0)),
                    _ => canvas.area(&[upper.into_iter().chain(lower.into_iter().rev()).collect()], colour, 0.25),
                }
                let line: Vec<Place> =
                    part.iter().map(|&right| place(right, self.values[cell(right)].unwrap_or(0.0))).collect();
                canvas.lines(&line, Pen::new(colour, 1.6));
                if part.len() <= MOST_MARKS {
                    line.iter().for_each(|&at| canvas.dot(at, 1.8, colour));
                }
            }
        }
        panel.frame(canvas, &along, &self.vertical);
        heading(canvas, panel, &slice.title(self.job));
    }

    /// The colours of the curves, at the right.
    fn legend(&self, canvas: &mut Canvas, panels: &[Panel]) {
        let (Some(several), Some(first)) = (self.along.several, panels.first()) else { return };
        let family = &several.values;
        let right = panels.iter().map(Panel::right).fold(0.0, f64::max) + 8.0;
        let heading = axis(several);
        let title = wrapped(&heading.title, LEGEND, SMALL - 2);
        for (i, line) in title.iter().enumerate() {
            let below = first.top + 8.0 + f64::from(SMALL) * i as f64;
            canvas.text((right, below), line, SMALL - 2, Side::Right, 0.0, BLACK);
        }
        let top = first.top + 8.0 + f64::from(SMALL) * (title.len() - 1) as f64;
        for (up, value) in family.iter().enumerate().rev() {
            let y = top + f64::from(NORMAL) * 1.3 * (family.len() - up) as f64;
            canvas.line((right, y - 3.0), (right + 14.0, y - 3.0), Pen::new(colour_of(up, family.len()), 2.0));
            let text = format!("{} {}", rounded(*value), heading.unit);
            canvas.text((right + 18.0, y), text.trim_end(), SMALL - 1, Side::Right, 0.0, BLACK);
        }
    }
}

/// Colours of curves, from dark to light.
fn colour_of(curve: usize, of: usize) -> Rgb {
    let share = 0.1 + 0.75 * curve as f64 / of.max(2) as f64;
    colorous::VIRIDIS.eval_continuous(share).as_tuple()
}
