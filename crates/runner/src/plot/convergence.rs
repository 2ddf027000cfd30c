//! An estimate with its interval over the number of samples.

use stickslip_sampler::estimate::interval::Estimate;

use crate::picture::scale::Scale;
use crate::plot::canvas::{Canvas, GREY, Pen, Place, Rgb};
use crate::plot::panel::{Axis, OnePanel};

/// Height of the panel over its width.
const ASPECT: f64 = 0.55;

const COLOUR: Rgb = (0x00, 0x72, 0xb2);

/// What is drawn.
pub struct ConvergencePlot {
    /// Numbers of samples, growing, each with the estimate from so many.
    pub estimates: Vec<(u64, Estimate)>,
    /// What is counted.
    pub across: String,
    pub title: String,
    pub notes: Vec<String>,
}

impl ConvergencePlot {
    /// The figure, this wide in pixels.
    pub fn figure(&self, width: f64) -> Canvas {
        let mut figure = OnePanel::new(width, ASPECT, 0.0, &self.notes);
        let OnePanel { canvas, panel, .. } = &mut figure;
        let ends = [self.estimates.first(), self.estimates.last()].map(|end| end.map_or(1.0, |(n, _)| *n as f64));
        let across =
            Axis { scale: Scale::logarithmic(ends[0], ends[1]), title: self.across.clone(), unit: String::new() };
        // The first intervals reach from 0 to 1: what is looked at is where the estimates and the last intervals lie.
        let later = self.estimates.iter().skip(self.estimates.len() / 4);
        let values = later.flat_map(|(_, estimate)| [estimate.low, estimate.high]);
        let values = values.chain(self.estimates.iter().filter_map(|(_, estimate)| estimate.probability));
        let up = Axis {
            scale: Scale::around(values),
            title: "Probability of instability P".to_owned(),
            unit: String::new(),
        };
        let place = |(samples, value): (u64, f64)| -> Place {
            panel.place(across.scale.at(samples as f64), up.scale.at(value).clamp(0.0, 1.0))
        };
        let along = |value: fn(&Estimate) -> f64| -> Vec<Place> {
            self.estimates.iter().map(|(samples, estimate)| place((*samples, value(estimate)))).collect()
        };
        let (low, high) = (along(|estimate| estimate.low), along(|estimate| estimate.high));
        canvas.area(&[low.into_iter().chain(high.into_iter().rev()).collect()], COLOUR, 0.25);
        let known = self.estimates.iter().filter_map(|(samples, of)| Some((*samples, of.probability?)));
        let known: Vec<Place> = known.map(place).collect();
        if let Some(last) = known.last() {
            canvas.dashes(&[(panel.left, last.1), *last], Pen::new(GREY, 0.9));
        }
        canvas.lines(&known, Pen::new(COLOUR, 1.6));
        figure.finish(&across, &up, &self.title)
    }
}
