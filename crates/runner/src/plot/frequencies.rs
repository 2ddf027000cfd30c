//! The frequencies of unstable samples as a histogram whose bars add up to the probability of instability.

use crate::picture::scale::Scale;
use crate::plot::canvas::{Canvas, GREY, Pen, Rgb};
use crate::plot::histogram::Histogram;
use crate::plot::panel::{ABOVE, Arrangement, Axis, Layout, RIGHT, heading, in_lines, space_of, write_notes};

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
        let notes = in_lines(&self.notes, width);
        let layout = Layout { above: ABOVE, right: RIGHT, below: space_of(&notes), aspect: ASPECT, most_columns: 1 };
        let Arrangement { panels, height } = layout.arrange(1, width);
        let mut canvas = Canvas::new(width, height);
        let [low, high] = self.range();
        let frequencies = self.frequencies.iter().map(|frequency| (*frequency, 1));
        let histogram = Histogram::new(frequencies, [low, high], BARS);
        let share = |count: u64| count as f64 / self.samples.max(1) as f64;
        let highest = share(histogram.highest());
        let across = Axis { scale: Scale::linear(low, high), title: "Frequency".to_owned(), unit: "Hz".to_owned() };
        let top = if highest > 0.0 { 1.08 * highest } else { 1.0 };
        let up = Axis { scale: Scale::linear(0.0, top), title: "Share of all samples".to_owned(), unit: String::new() };
        for panel in &panels {
            histogram.draw(&mut canvas, panel, [&across, &up], share(1), COLOUR);
            for frequency in self.modes.iter().filter(|frequency| (low..=high).contains(*frequency)) {
                let at = panel.place(across.scale.at(*frequency), 1.0);
                canvas.line(at, (at.0, at.1 + MARK), Pen::new(GREY, 1.0));
            }
            panel.frame(&mut canvas, &across, &up);
            heading(&mut canvas, panel, &self.title);
        }
        write_notes(&mut canvas, &notes, (width, height));
        canvas
    }

    /// The range of the frequencies, with some space.
    fn range(&self) -> [f64; 2] {
        let of = if self.frequencies.is_empty() { &self.modes } else { &self.frequencies };
        let [low, high] = of
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(*value), high.max(*value)]);
        if low > high {
            return [0.0, 1.0];
        }
        let space = (0.1 * (high - low)).max(0.01 * high).max(1e-9);
        [(low - space).max(0.0), high + space]
    }
}
