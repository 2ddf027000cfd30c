//! What a drawing shows: curves and points over two axes. The terminal and plots draw the same chart.

use crate::picture::scale::{Scale, ends, superscript};
use crate::picture::view::rounded;
use crate::units::significant;

/// An axis of a chart: its title, its unit, empty for a pure number, and its scale.
#[derive(Debug, Clone)]
pub struct ChartAxis {
    pub title: String,
    pub unit: String,
    pub scale: Scale,
}

impl ChartAxis {
    pub fn new(title: &str, unit: &str, scale: Scale) -> Self {
        Self { title: title.to_owned(), unit: unit.to_owned(), scale }
    }

    /// The title with the unit, and the power of ten that labels of ticks leave out.
    pub fn heading(&self, power: i32) -> String {
        let factor = if power == 0 { String::new() } else { format!("10{}", superscript(power)) };
        let unit: Vec<&str> = [factor.as_str(), &self.unit].into_iter().filter(|part| !part.is_empty()).collect();
        if unit.is_empty() { self.title.clone() } else { format!("{}, {}", self.title, unit.join(" ")) }
    }
}

/// How the points of a series are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// Joined.
    Line,
    /// Each by itself.
    Points,
}

/// Points that belong together.
#[derive(Debug, Clone)]
pub struct Series {
    /// In the legend; empty for none.
    pub name: String,
    /// What distinguishes it where there are no colours.
    pub symbol: char,
    pub form: Form,
    pub points: Vec<(f64, f64)>,
    /// Low and high end of the interval of each point; empty if it has none.
    pub band: Vec<(f64, f64)>,
}

impl Series {
    /// The only curve of a chart.
    pub fn line(points: Vec<(f64, f64)>) -> Self {
        Self { name: String::new(), symbol: '*', form: Form::Line, points, band: Vec::new() }
    }

    /// One of several curves, counted from 0.
    pub fn numbered(number: usize, name: String, points: Vec<(f64, f64)>) -> Self {
        let symbol = u32::try_from(number + 1).ok().and_then(|digit| char::from_digit(digit, 10)).unwrap_or('*');
        Self { name, symbol, ..Self::line(points) }
    }
}

/// Values of the horizontal axis that are marked by a line.
#[derive(Debug, Clone)]
pub struct Marks {
    /// What they are.
    pub what: String,
    pub values: Vec<f64>,
}

/// A drawing with two axes.
#[derive(Debug, Clone)]
pub struct Chart {
    pub title: String,
    pub horizontal: ChartAxis,
    pub vertical: ChartAxis,
    pub series: Vec<Series>,
    pub marks: Option<Marks>,
    /// Whether a line is drawn where the vertical axis is zero.
    pub has_zero_line: bool,
    /// A line below the drawing at the terminal, and in the legend of a plot; empty for none.
    pub note: String,
}

/// A place in a chart: shares of its width and of its height, from the lower left corner.
pub type Share = (f64, f64);

impl Chart {
    pub fn new(title: impl Into<String>, horizontal: ChartAxis, vertical: ChartAxis, series: Vec<Series>) -> Self {
        let (title, note) = (title.into(), String::new());
        Self { title, horizontal, vertical, series, marks: None, has_zero_line: false, note }
    }

    /// Where a point lies, perhaps outside.
    fn share(&self, (x, y): (f64, f64)) -> Share {
        (self.horizontal.scale.at(x), self.vertical.scale.at(y))
    }

    /// The curve of a series, cut where it leaves the chart or is not known.
    pub fn lines(&self, series: &Series) -> Vec<Vec<Share>> {
        let mut lines: Vec<Vec<Share>> = Vec::new();
        for pair in series.points.windows(2) {
            let Some((from, to)) = clipped(self.share(pair[0]), self.share(pair[1])) else { continue };
            match lines.last_mut() {
                Some(line) if line.last() == Some(&from) => line.push(to),
                _ => lines.push(vec![from, to]),
            }
        }
        lines
    }

    /// The points of a series inside the chart.
    pub fn points(&self, series: &Series) -> Vec<Share> {
        series.points.iter().map(|&point| self.share(point)).filter(|&share| is_inside(share)).collect()
    }

    /// The band of a series: its points with the low and the high end of their intervals, in pieces without gaps.
    pub fn bands(&self, series: &Series) -> Vec<Vec<(f64, f64, f64)>> {
        let at = |y: f64| self.vertical.scale.at(y).clamp(0.0, 1.0);
        let ends = series.points.iter().zip(&series.band);
        let ends: Vec<_> =
            ends.map(|((x, _), (low, high))| (self.horizontal.scale.at(*x), at(*low), at(*high))).collect();
        let pieces = ends.split(|(x, low, high)| !(x.is_finite() && low.is_finite() && high.is_finite()));
        pieces.filter(|piece| !piece.is_empty()).map(<[_]>::to_vec).collect()
    }

    /// The marked values with where they lie.
    pub fn marked(&self) -> Vec<(f64, f64)> {
        let values = self.marks.iter().flat_map(|marks| marks.values.iter().copied());
        let placed = values.map(|value| (value, self.horizontal.scale.at(value)));
        placed.filter(|(_, at)| (0.0..=1.0).contains(at)).collect()
    }

    /// Where the vertical axis is zero, if that is drawn and inside.
    pub fn zero(&self) -> Option<f64> {
        let zero = self.vertical.scale.at(0.0);
        (self.has_zero_line && (0.0..=1.0).contains(&zero)).then_some(zero)
    }

    /// What the chart shows in a sentence, for those who do not see it.
    pub fn description(&self) -> String {
        let range = |values: &mut dyn Iterator<Item = f64>| {
            let [low, high] = ends(values.filter(|value| value.is_finite()));
            if low <= high { format!(" from {} to {}", significant(low), significant(high)) } else { String::new() }
        };
        let points = || self.series.iter().flat_map(|series| &series.points);
        let mut text = format!(
            "{}: {}{}, over {}{}",
            self.title,
            self.vertical.heading(0),
            range(&mut points().map(|point| point.1)),
            self.horizontal.heading(0),
            range(&mut points().map(|point| point.0))
        );
        let names: Vec<&str> =
            self.series.iter().map(|series| series.name.as_str()).filter(|n| !n.is_empty()).collect();
        if !names.is_empty() {
            text += &format!("; curves: {}", names.join(", "));
        }
        if let Some(Marks { what, values }) = &self.marks {
            text += &format!("; {what}: {}", listed(values));
        }
        text
    }
}

/// Numbers as a list.
pub fn listed(values: &[f64]) -> String {
    let texts: Vec<String> = values.iter().map(|&value| rounded(value)).collect();
    texts.join(", ")
}

fn is_inside((x, y): Share) -> bool {
    (0.0..=1.0).contains(&x) && (0.0..=1.0).contains(&y)
}

/// The part of a line inside the unit square (Liang and Barsky).
fn clipped(from: Share, to: Share) -> Option<(Share, Share)> {
    if is_inside(from) && is_inside(to) {
        return Some((from, to));
    }
    if ![from.0, from.1, to.0, to.1].iter().all(|value| value.is_finite()) {
        return None;
    }
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let (mut enters, mut leaves) = (0.0_f64, 1.0_f64);
    for (step, room) in [(-dx, from.0), (dx, 1.0 - from.0), (-dy, from.1), (dy, 1.0 - from.1)] {
        if step == 0.0 && room < 0.0 {
            return None;
        }
        if step < 0.0 {
            enters = enters.max(room / step);
        } else if step > 0.0 {
            leaves = leaves.min(room / step);
        }
    }
    let at = |share: f64| ((from.0 + share * dx).clamp(0.0, 1.0), (from.1 + share * dy).clamp(0.0, 1.0));
    (enters < leaves).then(|| (at(enters), at(leaves)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(points: Vec<(f64, f64)>) -> Chart {
        let axis = || ChartAxis::new("x", "mm", Scale::linear(0.0, 10.0));
        Chart::new("test", axis(), axis(), vec![Series::line(points)])
    }

    #[test]
    fn a_curve_is_cut_at_the_edges_and_where_it_is_not_known() {
        let chart = chart(vec![(0.0, 5.0), (5.0, 15.0), (10.0, 5.0), (f64::NAN, 5.0), (2.0, 0.0), (4.0, 0.0)]);
        let lines = chart.lines(&chart.series[0]);
        assert_eq!(lines, [vec![(0.0, 0.5), (0.25, 1.0)], vec![(0.75, 1.0), (1.0, 0.5)], vec![(0.2, 0.0), (0.4, 0.0)]]);
        assert_eq!(chart.points(&chart.series[0]).len(), 4);
    }

    #[test]
    fn a_chart_is_described_in_words() {
        let mut chart = chart(vec![(1.0, 2.0), (3.0, 4.0)]);
        chart.marks = Some(Marks { what: "critical speed".to_owned(), values: vec![2.5] });
        assert_eq!(
            chart.description(),
            "test: x, mm from 2.000 to 4.000, over x, mm from 1.000 to 3.000; critical speed: 2.5"
        );
    }
}
