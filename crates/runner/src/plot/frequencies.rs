//! The frequencies of unstable samples as a histogram whose bars add up to the probability of instability.

use crate::picture::scale::{Scale, ends};
use crate::plot::canvas::{Canvas, GREY, Pen, Rgb};
use crate::plot::histogram::Histogram;
use crate::plot::panel::{Axis, OnePanel};

/// Height of the panel over its width.
const ASPECT: f64 = 0.55;

const COLOUR: Rgb = (0xd5, 0x5e, 0x00);

/// Bars over the range of the frequencies.
const BARS: usize = 60;

/// Length of the marks of modes.
const MARK: f64 = 7.0;

/// What is drawn.
pub struct FrequencyPlot {
    /// Hz, of the unstable samples.
    pub frequencies: Vec<f64>,
    /// How many samples there are, stable ones included.
    pub samples: u64,
    /// Hz, of the modes at the expected values.
    pub modes: Vec<f64>,
    pub title: String,
    pub notes: Vec<String>,
}

impl FrequencyPlot {
    /// The figure, this wide in pixels.
    pub fn figure(&self, width: f64) -> Canvas {
        let mut figure = OnePanel::new(width, ASPECT, 0.0, &self.notes);
        let OnePanel { canvas, panel, .. } = &mut figure;
        let [low, high] = self.range();
        let frequencies = self.frequencies.iter().map(|frequency| (*frequency, 1));
        let histogram = Histogram::new(frequencies, [low, high], BARS);
        let share = |count: u64| count as f64 / self.samples.max(1) as f64;
        let highest = share(histogram.highest());
        let across = Axis { scale: Scale::linear(low, high), title: "Frequency".to_owned(), unit: "Hz".to_owned() };
        let top = if highest > 0.0 { 1.08 * highest } else { 1.0 };
        let up = Axis { scale: Scale::linear(0.0, top), title: "Share of all samples".to_owned(), unit: String::new() };
        histogram.draw(canvas, panel, [&across, &up], share(1), COLOUR);
        for frequency in self.modes.iter().filter(|frequency| (low..=high).contains(*frequency)) {
            let at = panel.place(across.scale.at(*frequency), 1.0);
            canvas.line(at, (at.0, at.1 + MARK), Pen::new(GREY, 1.0));
        }
        figure.finish(&across, &up, &self.title)
    }

    /// The range of the frequencies, with some space.
    fn range(&self) -> [f64; 2] {
        let of = if self.frequencies.is_empty() { &self.modes } else { &self.frequencies };
        let [low, high] = ends(of.iter().copied());
        if low > high {
            return [0.0, 1.0];
        }
        let space = (0.1 * (high - low)).max(0.01 * high).max(1e-9);
        [(low - space).max(0.0), high + space]
    }
}
