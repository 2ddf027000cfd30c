//! What tests show and what was fitted to them: probabilities over one axis, a curve with its band for each family.

use stickslip_sampler::fit::shares::Share;

use crate::plot::canvas::{Canvas, Pen, Place, Rgb};
use crate::plot::chart::{COLOURS, simplified};
use crate::plot::legend::Legend;
use crate::plot::panel::{Axis, Layout, Panel, RIGHT, in_lines, space_of, write_notes};

/// Most families, each with a colour of its own.
pub const MOST_FAMILIES: usize = COLOURS.len();

/// Height of the panel over its width, space above it, and between its axis and the legend.
const ASPECT: f64 = 0.55;
const ABOVE: f64 = 14.0;
const BEFORE: f64 = 8.0;

/// Distance of intervals of different families beside each other, and half of the length of the ends of one.
const BESIDE: f64 = 3.0;
const CAP: f64 = 2.5;

/// Radius of a point, width of a curve and of other lines, and opacity of a band.
const POINT: f64 = 2.4;
const CURVE: f64 = 1.6;
const LINE: f64 = 1.0;
const BAND: f64 = 0.2;

/// What tests show.
#[derive(Debug, Clone)]
pub enum Tests {
    /// Shares of groups, with intervals.
    Shares(Vec<Share>),
    /// The steps of a distribution from its right end to the left, each with the share from there on, and the places of
    /// tests that ended without an event.
    Steps { steps: Vec<(f64, f64)>, censored: Vec<f64> },
}

/// Tests in one condition, with what was fitted to them.
#[derive(Debug, Clone)]
pub struct Family {
    /// In the legend.
    pub name: String,
    /// Places with their probabilities, and the ends of the intervals of those.
    pub curve: Vec<(f64, [f64; 3])>,
    pub tests: Tests,
}

/// The picture of a fit.
#[derive(Debug, Clone)]
pub struct FitPicture {
    pub families: Vec<Family>,
    pub horizontal: Axis,
    pub vertical: Axis,
    /// What is said below.
    pub notes: Vec<String>,
}

impl FitPicture {
    /// The figure, this wide in pixels.
    pub fn figure(&self, width: f64) -> Canvas {
        let coloured = || self.families.iter().zip(COLOURS);
        let legend =
            Legend::new(coloured().map(|(family, colour)| (colour, family.name.clone())).collect(), width - RIGHT);
        let notes = in_lines(&self.notes, width);
        let below = BEFORE + legend.height() + space_of(&notes);
        let layout = Layout { above: ABOVE, right: RIGHT, below, aspect: ASPECT, most_columns: 1 };
        let arrangement = layout.arrange(1, width);
        let mut canvas = Canvas::new(width, arrangement.height);
        for panel in &arrangement.panels {
            for (family, colour) in coloured() {
                self.draw_curve(&mut canvas, panel, family, colour);
            }
            let middle = 0.5 * (self.families.len() as f64 - 1.0);
            for (number, (family, colour)) in coloured().enumerate() {
                self.draw_tests(&mut canvas, panel, family, colour, BESIDE * (number as f64 - middle));
            }
            panel.frame(&mut canvas, &self.horizontal, &self.vertical);
            legend.draw(&mut canvas, (panel.left, arrangement.height - below + BEFORE));
        }
        write_notes(&mut canvas, &notes, arrangement.height);
        canvas
    }

    fn place(&self, panel: &Panel, at: f64, probability: f64) -> Place {
        panel.place(self.horizontal.scale.at(at).clamp(0.0, 1.0), self.vertical.scale.at(probability).clamp(0.0, 1.0))
    }

    fn draw_curve(&self, canvas: &mut Canvas, panel: &Panel, family: &Family, colour: Rgb) {
        let along = |which: usize| -> Vec<Place> {
            family.curve.iter().map(|&(at, values)| self.place(panel, at, values[which])).collect()
        };
        let [middle, low, high] = [0, 1, 2].map(along);
        canvas.area(&[low.into_iter().chain(high.into_iter().rev()).collect()], colour, BAND);
        canvas.lines(&simplified(&middle), Pen::new(colour, CURVE));
    }

    /// Draws tests, intervals of shares moved to the right so that those of other families do not cover them.
    fn draw_tests(&self, canvas: &mut Canvas, panel: &Panel, family: &Family, colour: Rgb, right: f64) {
        let pen = Pen::new(colour, LINE);
        match &family.tests {
            Tests::Shares(shares) => {
                for share in shares {
                    let of = |value: f64| {
                        let (x, y) = self.place(panel, share.speed, value);
                        (x + right, y)
                    };
                    let [at, low, high] = [share.share, share.low, share.high].map(of);
                    canvas.line(low, high, pen);
                    for (x, y) in [low, high] {
                        canvas.line((x - CAP, y), (x + CAP, y), pen);
                    }
                    canvas.dot(at, POINT, colour);
                }
            }
            Tests::Steps { steps, censored } => {
                let share = |at: f64| steps.iter().rev().find(|step| step.0 >= at).map_or(0.0, |step| step.1);
                let mut line = vec![panel.place(1.0, self.vertical.scale.at(0.0))];
                let mut before = 0.0;
                for &(at, share) in steps {
                    line.extend([self.place(panel, at, before), self.place(panel, at, share)]);
                    before = share;
                }
                let least = censored.iter().copied().fold(f64::INFINITY, f64::min);
                if steps.last().is_some_and(|last| least < last.0) {
                    line.push(self.place(panel, least, before));
                }
                canvas.lines(&line, pen);
                for &at in censored {
                    let (x, y) = self.place(panel, at, share(at));
                    canvas.line((x, y - 2.0 * CAP), (x, y + 2.0 * CAP), pen);
                }
            }
        }
    }
}
