//! Numbers counted in bars of equal width.

use crate::plot::canvas::{Canvas, Rgb};
use crate::plot::panel::{Axis, Panel};

/// Numbers, counted.
#[derive(Debug, Clone, PartialEq)]
pub struct Histogram {
    low: f64,
    high: f64,
    counts: Vec<u64>,
}

impl Histogram {
    /// Counts numbers, each with how often it is there, in so many bars from `low` to `high`. Numbers beyond these are left
    /// out.
    pub fn new(numbers: impl IntoIterator<Item = (f64, u64)>, [low, high]: [f64; 2], bars: usize) -> Self {
        let mut counts = vec![0; bars];
        for (number, count) in numbers {
            if (low..=high).contains(&number) {
                let bar = (bars as f64 * (number - low) / (high - low)) as usize;
                counts[bar.min(bars - 1)] += count;
            }
        }
        Self { low, high, counts }
    }

    /// Width of a bar.
    pub fn width(&self) -> f64 {
        (self.high - self.low) / self.counts.len() as f64
    }

    /// The largest count.
    pub fn highest(&self) -> u64 {
        self.counts.iter().copied().max().unwrap_or(0)
    }

    /// Draws the bars, each as high as its count times `height`.
    pub fn draw(&self, canvas: &mut Canvas, panel: &Panel, [across, up]: [&Axis; 2], height: f64, colour: Rgb) {
        let bar = |(bar, count): (usize, &u64)| {
            let [left, right] = [bar, bar + 1].map(|end| across.scale.at(self.low + self.width() * end as f64));
            let (foot, head) = (panel.place(left, 0.0), panel.place(right, up.scale.at(height * *count as f64)));
            panel.rectangle((foot.0, head.1), (head.0, foot.1))
        };
        let bars: Vec<_> = self.counts.iter().enumerate().filter(|(_, count)| **count > 0).map(bar).collect();
        canvas.mosaic(&bars, colour);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_count_every_number_between_the_ends_once() {
        let numbers = [(100.0, 2), (130.0, 1), (160.0, 1), (161.0, 5)];
        let histogram = Histogram::new(numbers, [100.0, 160.0], 3);
        assert_eq!(histogram.counts, [2, 1, 1]);
        assert_eq!((histogram.width(), histogram.highest()), (20.0, 2));
    }
}
