//! Modes over a parameter: their frequencies and damping ratios, those of the expected values as lines and those of samples
//! as a cloud.

use crate::picture::scale::Scale;
use crate::plot::canvas::{Canvas, GREY, Pen, Place, Rgb};
use crate::plot::legend::Legend;
use crate::plot::panel::{
    ABOVE, Arrangement, Axis, LEFT, Layout, Panel, RIGHT, heading, in_lines, left_of, space_of, write_notes,
};

/// Height of a panel over its width.
const ASPECT: f64 = 0.75;

/// Colours and widths of lines, and colours of the cloud.
const STABLE: Pen = Pen::new((0x00, 0x72, 0xb2), 1.2);
const UNSTABLE: Pen = Pen::new((0xd5, 0x5e, 0x00), 2.6);
const CLOUD: [Rgb; 2] = [(0x9c, 0xc4, 0xe0), (0xf0, 0xb4, 0x8a)];

/// Half the side of a square of the cloud.
const HALF: f64 = 0.8;

/// How far above the threshold the damping ratio of a mode may be everywhere, if it is to be drawn beside others.
const MOST_DAMPED: f64 = 0.1;

/// Shares of the cloud that the axes leave out at each end.
const LEFT_OUT: f64 = 0.005;

/// Space between the panels, and above the legend.
const BETWEEN: f64 = 10.0;
const GAP: f64 = 6.0;

/// A mode at a value of the parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModePoint {
    pub value: f64,
    /// Hz.
    pub frequency: f64,
    pub damping_ratio: f64,
    pub is_unstable: bool,
}

/// What is drawn.
pub struct ModePlot {
    /// The parameter.
    pub along: Axis,
    /// What is fixed, above the panels.
    pub title: String,
    /// Each mode of the expected values, in the order of the parameter.
    pub lines: Vec<Vec<ModePoint>>,
    /// The modes of samples.
    pub cloud: Vec<ModePoint>,
    /// Damping ratios below it are unstable.
    pub threshold: f64,
    pub notes: Vec<String>,
}

/// What a panel shows of a mode.
type Of = fn(&ModePoint) -> f64;

impl ModePlot {
    /// The figure, this wide in pixels.
    pub fn figure(&self, width: f64) -> Canvas {
        let mut entries =
            vec![(STABLE.colour, "expected, stable".to_owned()), (UNSTABLE.colour, "expected, unstable".to_owned())];
        if !self.cloud.is_empty() {
            entries.push((CLOUD[0], "samples, stable".to_owned()));
            entries.push((CLOUD[1], "samples, unstable".to_owned()));
        }
        let legend = Legend::new(entries, width - 2.0 * RIGHT);
        let notes = in_lines(&self.notes, width);
        let below = GAP + legend.height() + space_of(&notes);
        let layout = Layout { above: ABOVE, right: RIGHT, below, aspect: ASPECT, most_columns: 2 };
        let Arrangement { mut panels, height } = layout.arrange(2, width);
        let mut canvas = Canvas::new(width, height);
        let axes = [
            self.axis("Frequency", "Hz", |point| point.frequency, None),
            self.axis("Damping ratio ζ", "", |point| point.damping_ratio, Some(self.threshold)),
        ];
        // Long labels need space at the left.
        let further =
            |panel: &Panel| axes.iter().map(|axis| left_of(axis, panel.height) - LEFT).fold(0.0, f64::max) + BETWEEN;
        for panel in &mut panels {
            let by = further(panel);
            panel.left += by;
            panel.width -= by;
        }
        let shown: [Of; 2] = [|point| point.frequency, |point| point.damping_ratio];
        for ((panel, axis), of) in panels.iter().zip(&axes).zip(shown) {
            self.panel(&mut canvas, panel, axis, of);
        }
        if let Some(first) = panels.first() {
            heading(&mut canvas, first, &self.title);
        }
        legend.draw(&mut canvas, (RIGHT, height - below + GAP));
        write_notes(&mut canvas, &notes, height);
        canvas
    }

    /// Leaves out modes that are damped by so much that they hide the others, if there are others.
    pub fn leave_out_damped(&mut self) {
        let is_shown = |point: &ModePoint| point.damping_ratio <= self.threshold + MOST_DAMPED;
        let is_line = |line: &Vec<ModePoint>| line.iter().any(is_shown);
        let left_out = self.lines.iter().filter(|line| !is_line(line)).count();
        if left_out == 0 || left_out == self.lines.len() {
            return;
        }
        self.lines.retain(is_line);
        self.cloud.retain(is_shown);
        let modes = if left_out == 1 { "one mode".to_owned() } else { format!("{left_out} modes") };
        self.notes.push(format!("left out: {modes} with damping ratios above {}", self.threshold + MOST_DAMPED));
    }

    /// The axis of a number: all of the lines, and nearly all of the cloud.
    fn axis(&self, title: &str, unit: &str, of: Of, further: Option<f64>) -> Axis {
        let mut cloud: Vec<f64> = self.cloud.iter().map(of).collect();
        cloud.sort_by(f64::total_cmp);
        let out = (LEFT_OUT * cloud.len() as f64) as usize;
        let kept = cloud.get(out..cloud.len() - out).unwrap_or_default();
        let values = self.lines.iter().flatten().map(of).chain(kept.iter().copied()).chain(further);
        Axis { scale: Scale::around(values), title: title.to_owned(), unit: unit.to_owned() }
    }

    fn panel(&self, canvas: &mut Canvas, panel: &Panel, axis: &Axis, of: Of) {
        let place = |point: &ModePoint| panel.place(self.along.scale.at(point.value), axis.scale.at(of(point)));
        self.cloud_on(canvas, panel, place);
        if axis.unit.is_empty() {
            let at = |right: f64| panel.place(right, axis.scale.at(self.threshold));
            canvas.dashes(&[at(0.0), at(1.0)], Pen::new(GREY, 0.8));
        }
        for unstable in [false, true] {
            for line in &self.lines {
                for part in parts(line, self.threshold, unstable) {
                    let places: Vec<Place> = part.iter().map(place).collect();
                    canvas.lines(&places, if unstable { UNSTABLE } else { STABLE });
                }
            }
        }
        panel.frame(canvas, &self.along, axis);
    }

    fn cloud_on(&self, canvas: &mut Canvas, panel: &Panel, place: impl Fn(&ModePoint) -> Place) {
        for (colour, unstable) in CLOUD.into_iter().zip([false, true]) {
            let points = self.cloud.iter().filter(|point| point.is_unstable == unstable);
            let square = |(x, y): Place| panel.rectangle((x - HALF, y - HALF), (x + HALF, y + HALF));
            let squares: Vec<Vec<Place>> = points.map(&place).filter(|at| panel.contains(*at)).map(square).collect();
            canvas.area(&squares, colour, 1.0);
        }
    }
}

/// The parts of a line that are unstable, or those that are not. A line changes where it crosses the threshold.
fn parts(line: &[ModePoint], threshold: f64, unstable: bool) -> Vec<Vec<ModePoint>> {
    let mut parts: Vec<Vec<ModePoint>> = Vec::new();
    let mut part: Vec<ModePoint> = Vec::new();
    for (i, point) in line.iter().enumerate() {
        if let Some(before) = i.checked_sub(1).map(|i| &line[i])
            && before.is_unstable != point.is_unstable
        {
            let crossing = crossing(before, point, threshold);
            if before.is_unstable == unstable {
                part.push(crossing);
                parts.push(std::mem::take(&mut part));
            } else {
                part.push(crossing);
            }
        }
        if point.is_unstable == unstable {
            part.push(*point);
        }
    }
    parts.push(part);
    parts.retain(|part| part.len() > 1);
    parts
}

/// Where a line between two points crosses the threshold of the damping ratio.
fn crossing(from: &ModePoint, to: &ModePoint, threshold: f64) -> ModePoint {
    let share = (from.damping_ratio - threshold) / (from.damping_ratio - to.damping_ratio);
    let share = if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.5 };
    let between = |from: f64, to: f64| from + share * (to - from);
    ModePoint {
        value: between(from.value, to.value),
        frequency: between(from.frequency, to.frequency),
        damping_ratio: between(from.damping_ratio, to.damping_ratio),
        is_unstable: false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_changes_where_it_crosses_the_threshold() {
        let point = |value: f64, damping_ratio: f64| ModePoint {
            value,
            frequency: 100.0 + value,
            damping_ratio,
            is_unstable: damping_ratio < 0.01,
        };
        let line = [point(0.0, 0.03), point(1.0, 0.02), point(2.0, -0.02), point(3.0, 0.05)];
        let [stable, unstable] = [false, true].map(|unstable| parts(&line, 0.01, unstable));
        let ends = |parts: &[Vec<ModePoint>]| -> Vec<[f64; 2]> {
            parts.iter().map(|part| [part[0].value, part[part.len() - 1].value]).collect()
        };
        assert_eq!(ends(&unstable).len(), 1);
        assert_eq!(ends(&stable).len(), 2);
        assert_eq!(ends(&stable)[0], [0.0, 1.25]);
        assert_eq!(ends(&unstable)[0][0], 1.25);
        assert_eq!(ends(&unstable)[0][1], ends(&stable)[1][0]);
        assert_eq!(ends(&stable)[1][1], 3.0);
        assert!((unstable[0][0].frequency - 101.25).abs() < 1e-12);
    }
}
