//! The difference of the probabilities of two runs: filled contours over two axes, curves with intervals over one.

use crate::job::Job;
use crate::picture::scale::Scale;
use crate::picture::view::GridView;
use crate::plot::area::{Area, AreaPanel, LINE, LabelledLine, Level, labelled_lines};
use crate::plot::canvas::{BLACK, Canvas, Pen, Rgb};
use crate::plot::contours::Field;
use crate::plot::curves::Curves;
use crate::plot::form::Form;
use crate::plot::panel::Axis;

/// Levels of differences above 0; those below are the same with the other sign.
const LEVELS: [f64; 6] = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5];

/// Space around curves, over their range.
const AROUND: f64 = 0.06;

/// The difference of two runs in every cell.
pub struct Difference {
    pub job: Job,
    /// What is subtracted from what.
    pub name: String,
    /// What the intervals are, in a few words.
    pub intervals: String,
    /// None where no sample was decided.
    pub values: Vec<Option<f64>>,
    /// Ends of its interval.
    pub low: Vec<f64>,
    pub high: Vec<f64>,
    /// Whether all samples of both runs are stable, or all unstable. There the difference is zero, without a line.
    pub is_saturated: Vec<bool>,
}

impl Difference {
    /// The figure, this wide in pixels; none for a single cell.
    pub fn figure(&self, view: &GridView, width: f64) -> Option<Canvas> {
        let title = "Difference of probability";
        match Form::for_grid(view)? {
            Form::Curves(along) => {
                let known =
                    || self.values.iter().zip(self.low.iter().zip(&self.high)).filter(|(value, _)| value.is_some());
                let low = known().map(|(_, (low, _))| *low).fold(0.0, f64::min);
                let high = known().map(|(_, (_, high))| *high).fold(0.0, f64::max);
                let around = AROUND * (high - low);
                let scale = Scale::linear(low - around, high + around);
                let vertical = Axis { scale, title: title.to_owned(), unit: String::new() };
                let notes = vec![self.name.clone(), format!("bands: {}", self.intervals)];
                let Self { job, values, low, high, .. } = self;
                let curves =
                    Curves { job, view, along, values, low, high, vertical, has_zero: true, target: None, notes };
                Some(curves.figure(width))
            }
            Form::Area { vertical, horizontal } => {
                let contains_zero = |(low, high): (&f64, &f64)| *low <= 0.0 && 0.0 <= *high;
                let known = self.values.iter().map(Option::is_some);
                let notes =
                    vec![self.name.clone(), format!("hatched: not significant, 0 is in the {}", self.intervals)];
                let area = Area {
                    job: &self.job,
                    view,
                    vertical,
                    horizontal,
                    values: self.values.clone(),
                    is_hatched: self
                        .low
                        .iter()
                        .zip(&self.high)
                        .map(contains_zero)
                        .zip(known)
                        .map(|(a, b)| a && b)
                        .collect(),
                    levels: levels(),
                    colours: (0..=2 * LEVELS.len()).map(colour).collect(),
                    title,
                    notes,
                };
                Some(area.figure(width, |canvas, drawn| self.zero_line(canvas, drawn)))
            }
        }
    }

    /// The line on which the difference is zero.
    fn zero_line(&self, canvas: &mut Canvas, drawn: &AreaPanel<'_>) {
        let values: Vec<Option<f64>> =
            drawn.cells.iter().map(|&cell| self.values[cell].filter(|_| !self.is_saturated[cell])).collect();
        let field = Field { values: &values, ..drawn.field };
        let labelled = |points| LabelledLine { points, label: "0".to_owned(), pen: Pen::new(BLACK, LINE), ink: BLACK };
        let lines: Vec<LabelledLine> = field.on(0.0).into_iter().map(labelled).collect();
        labelled_lines(canvas, &drawn.panel, &lines);
    }
}

fn levels() -> Vec<Level> {
    let below = LEVELS.iter().rev().map(|&level| Level { value: -level, label: format!("−{level}") });
    let above = LEVELS.iter().map(|&level| Level { value: level, label: format!("+{level}") });
    below.chain(above).collect()
}

/// The colour of a band, from the lowest: blue below zero, nearly white about it, red above.
fn colour(band: usize) -> Rgb {
    let share = 1.0 - band as f64 / (2 * LEVELS.len()) as f64;
    colorous::RED_BLUE.eval_continuous(share).as_tuple()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_lightest_about_zero_and_differ_on_its_sides() {
        let light = |band: usize| {
            let (red, green, blue) = colour(band);
            0.2126 * f64::from(red) + 0.7152 * f64::from(green) + 0.0722 * f64::from(blue)
        };
        let middle = LEVELS.len();
        assert!((0..middle).all(|i| light(i) < light(i + 1) && light(middle + i + 1) < light(middle + i)));
        assert!(colour(0).2 > colour(0).0 && colour(2 * middle).0 > colour(2 * middle).2);
        assert_eq!(levels().len(), 2 * middle);
        assert!(levels().windows(2).all(|pair| pair[0].value < pair[1].value));
    }
}
