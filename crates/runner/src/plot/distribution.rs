//! The distribution of a recorded result over the samples of a cell.

use stickslip_sampler::estimate::distribution::Distribution;

use crate::picture::scale::Scale;
use crate::picture::view::rounded;
use crate::plot::canvas::{BLACK, Canvas, GREY, Pen, Rgb, Side};
use crate::plot::histogram::Histogram;
use crate::plot::panel::{Axis, OnePanel, SMALL};

/// Height of the panel over its width.
const ASPECT: f64 = 0.55;

/// Space above the highest bar, where the quantiles are named.
const SPACE: f64 = 1.28;

/// Distance of the names of quantiles, which stand below each other.
const NAME: f64 = 10.0;

/// Bars over the range.
const BARS: usize = 60;

/// Shares of the samples at the ends of what is drawn, if these are not farther from the outer quantiles than so many times
/// the distance of these.
const ENDS: [f64; 2] = [0.001, 0.999];
const FARTHEST: f64 = 1.0;

/// Quantiles that have a line.
const QUANTILES: [f64; 3] = [0.05, 0.5, 0.95];

const COLOUR: Rgb = (0xb3, 0xd9, 0xf2);

/// What is drawn.
pub struct DistributionPlot {
    pub values: Distribution,
    /// Of which samples they are.
    pub samples: String,
    pub title: String,
    pub unit: String,
    /// What stands above.
    pub heading: String,
    pub notes: Vec<String>,
}

impl DistributionPlot {
    /// The figure, this wide in pixels.
    pub fn figure(&self, width: f64) -> Canvas {
        let mut figure = OnePanel::new(width, ASPECT, 0.0, &self.notes);
        let OnePanel { canvas, panel, .. } = &mut figure;
        let quantile = |share: f64| self.values.quantile(share).unwrap_or(0.0);
        let [low, _, high] = QUANTILES.map(quantile);
        let reach = FARTHEST * (high - low);
        let ends = [quantile(ENDS[0]).max(low - reach), quantile(ENDS[1]).min(high + reach)];
        let mut scale = Scale::around(ends.into_iter());
        // What is never negative is not drawn as if it were.
        if self.values.middles().next().is_some_and(|(least, _)| least >= 0.0) && scale.value(0.0) < 0.0 {
            scale = Scale::linear(0.0, scale.value(1.0));
        }
        let across = Axis { scale, title: self.title.clone(), unit: self.unit.clone() };
        let range = [0.0, 1.0].map(|end| scale.value(end));
        let histogram = Histogram::new(self.values.middles(), range, BARS);
        let share = 1.0 / self.values.count().max(1) as f64;
        let top = SPACE * share * histogram.highest().max(1) as f64;
        let up = Axis {
            scale: Scale::linear(0.0, top),
            title: format!("Share of the {}", self.samples),
            unit: String::new(),
        };
        histogram.draw(canvas, panel, [&across, &up], share, COLOUR);
        for (number, share) in QUANTILES.into_iter().enumerate() {
            let at = across.scale.at(quantile(share));
            let (foot, head) = (panel.place(at, 0.0), panel.place(at, 1.0));
            canvas.dashes(&[foot, head], Pen::new(GREY, 1.0));
            // Beside each other they would cover each other, and the last would leave the panel.
            let (side, beside) = if at > 0.5 { (Side::Left, -3.0) } else { (Side::Right, 3.0) };
            let value = format!("{} {}", rounded(significant(quantile(share))), self.unit);
            let name = format!("{} %: {}", rounded(100.0 * share), value.trim_end());
            let below = head.1 + NAME * (1 + number) as f64;
            canvas.text((head.0 + beside, below), &name, SMALL - 2, side, 0.0, BLACK);
        }
        figure.finish(&across, &up, &self.heading)
    }
}

/// A number with four digits, as many as quantiles and estimates are known to.
pub fn significant(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}
