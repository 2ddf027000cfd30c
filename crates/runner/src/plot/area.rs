//! Filled contours of a number over two axes, with a colour bar.

use crate::job::Job;
use crate::picture::panels::drawn_slices;
use crate::picture::view::{GridView, Slice, ViewAxis};
use crate::plot::axes::{axis, axis_of_cells, edges_of};
use crate::plot::canvas::{BLACK, Canvas, GREY, Pen, Place, Rgb, Side, width_of};
use crate::plot::contours::Field;
use crate::plot::panel::{
    ABOVE, Arrangement, Axis, Layout, Panel, RIGHT, SMALL, heading, in_lines, space_of, write_notes,
};

/// Space for the colour bar.
const BAR: f64 = 74.0;

/// Height of a panel over its width.
const ASPECT: f64 = 0.78;

/// Most values of an axis of a panel that are drawn: they lie closer than four dots of a print.
const MOST_VALUES: usize = 500;

/// Width of contour lines.
pub const LINE: f64 = 1.0;
const HATCH: Pen = Pen::new(GREY, 0.5);
const HATCH_DISTANCE: f64 = 5.0;

/// A level of a number between two colours.
pub struct Level {
    /// On the scale on which the number is interpolated.
    pub value: f64,
    pub label: String,
}

/// What is drawn as an area: a number for each cell.
pub struct Area<'a> {
    pub job: &'a Job,
    pub view: &'a GridView,
    pub vertical: &'a ViewAxis,
    pub horizontal: &'a ViewAxis,
    /// On the scale on which they are interpolated.
    pub values: Vec<Option<f64>>,
    pub is_hatched: Vec<bool>,
    pub levels: Vec<Level>,
    /// The colours between the levels, the outer ones included.
    pub colours: Vec<Rgb>,
    /// What the colours mean.
    pub title: &'static str,
    /// What else is drawn.
    pub notes: Vec<String>,
}

/// A panel while it is drawn, with its slice, its axes and its numbers.
pub struct AreaPanel<'a> {
    pub panel: Panel,
    pub slice: Slice<'a>,
    pub horizontal: Axis,
    pub vertical: Axis,
    pub field: Field<'a>,
    /// The cells of the field.
    pub cells: &'a [usize],
}

impl AreaPanel<'_> {
    /// Where values on the axis to the right and on the axis upwards lie.
    pub fn place(&self, [right, up]: [f64; 2]) -> Place {
        self.panel.place(self.horizontal.scale.at(right), self.vertical.scale.at(up))
    }
}

impl Area<'_> {
    /// The figure, with a panel for each combination of the axes that are not shown. `lines` draws what lies on the
    /// colours.
    pub fn figure(&self, width: f64, lines: impl Fn(&mut Canvas, &AreaPanel<'_>)) -> Canvas {
        let slices = drawn_slices(self.view);
        let right = RIGHT + BAR;
        let notes = in_lines(&self.notes, width);
        let layout = Layout { above: ABOVE, right, below: space_of(&notes), aspect: ASPECT, most_columns: usize::MAX };
        let Arrangement { panels, height } = layout.arrange(slices.len(), width);
        let mut canvas = Canvas::new(width, height);
        for (number, panel) in slices.into_iter().zip(&panels) {
            self.panel(&mut canvas, panel, self.view.slice(number), &lines);
        }
        if let (Some(first), Some(top_right)) = (panels.first(), panels.iter().map(Panel::right).reduce(f64::max)) {
            self.bar(&mut canvas, Panel { left: top_right + 14.0, width: 13.0, ..*first });
        }
        write_notes(&mut canvas, &notes, height);
        canvas
    }

    fn panel(
        &self,
        canvas: &mut Canvas,
        panel: &Panel,
        slice: Slice<'_>,
        lines: &impl Fn(&mut Canvas, &AreaPanel<'_>),
    ) {
        // Where little is known between the cells, each is a tile.
        let is_tiled = self.view.is_coarse();
        let axis = if is_tiled { axis_of_cells } else { axis };
        let (horizontal, vertical) = (axis(self.horizontal), axis(self.vertical));
        let [across, along] = [self.horizontal, self.vertical].map(|axis| drawn_values(axis.values.len()));
        let columns: Vec<f64> = across
            .iter()
            .map(|&right| panel.place(horizontal.scale.at(self.horizontal.values[right]), 0.0).0)
            .collect();
        let rows: Vec<f64> =
            along.iter().map(|&up| panel.place(0.0, vertical.scale.at(self.vertical.values[up])).1).collect();
        let cells = along.iter().flat_map(|&up| across.iter().map(move |&right| (up, right)));
        let cells: Vec<usize> = cells.map(|(up, right)| slice.cell(up, right) as usize).collect();
        let values: Vec<Option<f64>> = cells.iter().map(|&cell| self.values[cell]).collect();
        let field = Field { columns: &columns, rows: &rows, values: &values };
        let floors = [f64::NEG_INFINITY].into_iter().chain(self.levels.iter().map(|level| level.value));
        for (floor, &colour) in floors.zip(&self.colours) {
            if is_tiled {
                let at_least = |i: &usize| values[*i].is_some_and(|value| value >= floor);
                let tiles = (0..values.len()).filter(at_least).map(|i| tile(panel, &columns, &rows, i));
                canvas.mosaic(&tiles.collect::<Vec<_>>(), colour);
            } else {
                canvas.area(&field.at_least(floor), colour, 1.0);
            }
        }
        self.hatch(canvas, panel, &columns, &rows, &cells);
        let drawn = AreaPanel { panel: *panel, slice, horizontal, vertical, field, cells: &cells };
        lines(canvas, &drawn);
        panel.frame(canvas, &drawn.horizontal, &drawn.vertical);
        heading(canvas, panel, &drawn.slice.title(self.job));
    }

    /// Lines across the cells that are hatched.
    fn hatch(&self, canvas: &mut Canvas, panel: &Panel, columns: &[f64], rows: &[f64], cells: &[usize]) {
        for (i, &cell) in cells.iter().enumerate() {
            if !self.is_hatched[cell] {
                continue;
            }
            let corners = tile(panel, columns, rows, i);
            let ((left, top), (right, bottom)) = (corners[0], corners[2]);
            // Lines x + y = constant, the same ones in all cells.
            let mut sum = ((left + top) / HATCH_DISTANCE).ceil() * HATCH_DISTANCE;
            while sum < right + bottom {
                let from = (left.max(sum - bottom), sum - left.max(sum - bottom));
                let to = (right.min(sum - top), sum - right.min(sum - top));
                canvas.line(from, to, HATCH);
                sum += HATCH_DISTANCE;
            }
        }
    }

    fn bar(&self, canvas: &mut Canvas, bar: Panel) {
        let bands = self.colours.len() as f64;
        for (band, &colour) in self.colours.iter().enumerate() {
            let (low, high) = (bar.place(0.0, band as f64 / bands), bar.place(1.0, (band + 1) as f64 / bands));
            canvas.area(&[bar.rectangle((low.0, high.1), (high.0, low.1))], colour, 1.0);
        }
        bar.outline(canvas);
        for (i, level) in (1..).zip(&self.levels) {
            let at = bar.place(1.0, f64::from(i) / bands);
            canvas.line(at, (at.0 + 3.0, at.1), Pen::new(BLACK, 0.8));
            canvas.text((at.0 + 5.0, at.1 + 3.0), &level.label, SMALL - 1, Side::Right, 0.0, BLACK);
        }
        let longest = self.levels.iter().map(|level| level.label.chars().count()).max().unwrap_or(0);
        let beside = (bar.right() + if longest > 4 { 49.0 } else { 42.0 }, bar.top + 0.5 * bar.height);
        canvas.text(beside, self.title, SMALL, Side::Middle, -90.0, BLACK);
    }
}

/// Of how many neighbouring ones of so many values of an axis one is drawn.
pub fn step_of(values: usize) -> usize {
    values.div_ceil(MOST_VALUES)
}

/// Which of so many values of an axis are drawn: both ends, and those between them in steps.
pub fn drawn_values(values: usize) -> Vec<usize> {
    let last = values.saturating_sub(1);
    (0..last).step_by(step_of(values).max(1)).chain([last]).collect()
}

/// The rectangle about a point of a grid, half way to its neighbours, as far as it lies inside a panel.
fn tile(panel: &Panel, columns: &[f64], rows: &[f64], i: usize) -> Vec<Place> {
    let (xs, ys) = (edges_of(columns, i % columns.len()), edges_of(rows, i / columns.len()));
    panel.rectangle((xs[0].min(xs[1]), ys[0].min(ys[1])), (xs[0].max(xs[1]), ys[0].max(ys[1])))
}

/// A line whose points are no farther from each other than this.
fn dense(line: &[Place], most: f64) -> Vec<Place> {
    let mut points: Vec<Place> = line.first().copied().into_iter().collect();
    for pair in line.windows(2) {
        let [(x, y), (to_x, to_y)] = [pair[0], pair[1]];
        let parts = (libm::hypot(to_x - x, to_y - y) / most).ceil().max(1.0);
        for part in 1..=parts as usize {
            let share = part as f64 / parts;
            points.push((x + share * (to_x - x), y + share * (to_y - y)));
        }
    }
    points
}

/// A line with a label, which has ink of its own.
pub struct LabelledLine {
    pub points: Vec<Place>,
    pub label: String,
    pub pen: Pen,
    pub ink: Rgb,
}

/// How far a label is from other lines, where there is such a place, and how far points of these are from each other.
const CLEARANCE: f64 = (SMALL - 2) as f64;
const NEAR: f64 = 3.0;

/// Draws the lines of a panel with their labels.
pub fn labelled_lines(canvas: &mut Canvas, panel: &Panel, lines: &[LabelledLine]) {
    let points: Vec<Vec<Place>> = lines.iter().map(|line| dense(&line.points, NEAR)).collect();
    let mut labels = Vec::new();
    for (number, line) in lines.iter().enumerate() {
        let clearance = |place: Place| {
            let others = points.iter().enumerate().filter(|(other, _)| *other != number);
            others.flat_map(|(_, points)| points).map(|other| distance(*other, place)).fold(CLEARANCE, f64::min)
        };
        labelled_line(canvas, panel, line, clearance, &mut labels);
    }
}

fn distance(a: Place, b: Place) -> f64 {
    libm::hypot(a.0 - b.0, a.1 - b.1)
}

/// A line with its label in a gap, where the line is long enough and no other label is near: where the `clearance` from other
/// lines is largest, and there as near to its middle as can be.
fn labelled_line(
    canvas: &mut Canvas,
    panel: &Panel,
    LabelledLine { points, label, pen, ink }: &LabelledLine,
    clearance: impl Fn(Place) -> f64,
    labels: &mut Vec<Place>,
) {
    let size = SMALL - 2;
    let gap = width_of(label, size) + 4.0;
    let line = &dense(points, 0.25 * gap);
    let length: f64 = line.windows(2).map(|pair| distance(pair[0], pair[1])).sum();
    // Not at the edges, and away from other labels.
    let inner = Panel {
        left: panel.left + gap,
        width: panel.width - 2.0 * gap,
        top: panel.top + 8.0,
        height: panel.height - 16.0,
    };
    let is_free =
        |place: Place| inner.contains(place) && labels.iter().all(|label| distance(*label, place) > 1.5 * gap);
    let mut walked = 0.0;
    let mut best: Option<(f64, f64, Place)> = None;
    for pair in line.windows(2) {
        walked += distance(pair[0], pair[1]);
        let from_middle = (walked - 0.5 * length).abs();
        if !is_free(pair[1]) {
            continue;
        }
        let clear = clearance(pair[1]);
        let is_better = |(other, off, _): (f64, f64, Place)| clear > other || (clear >= other && from_middle < off);
        if best.is_none_or(is_better) {
            best = Some((clear, from_middle, pair[1]));
        }
    }
    let Some((_, _, middle)) = best.filter(|_| length > 2.5 * gap) else {
        canvas.lines(line, *pen);
        return;
    };
    labels.push(middle);
    let is_outside = |place: &Place| distance(*place, middle) > 0.5 * gap;
    line.split(|place| !is_outside(place)).for_each(|part| canvas.lines(part, *pen));
    // The direction of the line from one end of the gap to the other.
    let near = line.iter().position(|place| *place == middle).unwrap_or(0);
    let from = line[..near].iter().rev().find(|place| is_outside(place)).copied().unwrap_or(middle);
    let to = line[near..].iter().find(|place| is_outside(place)).copied().unwrap_or(middle);
    let (from, to) = if from.0 <= to.0 { (from, to) } else { (to, from) };
    let turn = libm::atan2(to.1 - from.1, to.0 - from.0).to_degrees();
    let (sine, cosine) = (libm::sin(turn.to_radians()), libm::cos(turn.to_radians()));
    let down = 0.35 * f64::from(size);
    let at = (middle.0 - down * sine, middle.1 + down * cosine);
    canvas.text(at, label, size, Side::Middle, turn, *ink);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::canvas::Shape;

    #[test]
    fn fine_axes_are_drawn_in_steps_from_end_to_end() {
        assert_eq!(drawn_values(1), [0]);
        assert_eq!(drawn_values(500), (0..500).collect::<Vec<_>>());
        let thinned = drawn_values(1200);
        assert_eq!((thinned.len(), step_of(1200), thinned[1], thinned.last()), (401, 3, 3, Some(&1199)));
        assert!(drawn_values(1_000_000).len() <= 501);
    }

    #[test]
    fn labels_are_apart_from_each_other_and_from_other_lines() {
        let panel = Panel { left: 0.0, top: 0.0, width: 300.0, height: 200.0 };
        // The lines are 15 pixels from each other at the left, and 1 at the right.
        let line = |label: &str, from: f64, to: f64| LabelledLine {
            points: vec![(0.0, from), (300.0, to)],
            label: label.to_owned(),
            pen: Pen::new(BLACK, LINE),
            ink: BLACK,
        };
        let mut canvas = Canvas::new(300.0, 200.0);
        labelled_lines(&mut canvas, &panel, &[line("0.01", 100.0, 100.0), line("0.05", 85.0, 99.0)]);
        let places: Vec<Place> = canvas
            .shapes
            .iter()
            .filter_map(|shape| match shape {
                Shape::Text(text) => Some(text.at),
                _ => None,
            })
            .collect();
        assert_eq!(places.len(), 2);
        assert!(places.iter().all(|(x, _)| *x < 155.0), "{places:?}");
        assert!((places[0].0 - places[1].0).abs() > 30.0, "{places:?}");
        // Alone, each has its label in the middle.
        let mut canvas = Canvas::new(300.0, 200.0);
        labelled_lines(&mut canvas, &panel, &[line("0.01", 100.0, 100.0)]);
        let middle =
            canvas.shapes.iter().any(|shape| matches!(shape, Shape::Text(text) if (text.at.0 - 150.0).abs() < 6.0));
        assert!(middle, "{:?}", canvas.shapes);
    }

    #[test]
    fn a_dense_line_keeps_its_corners_and_has_no_long_parts() {
        let corners = [(0.0, 0.0), (10.0, 0.0), (10.0, 3.0)];
        let line = dense(&corners, 4.0);
        assert_eq!(line.len(), 5);
        assert!(corners.iter().all(|corner| line.contains(corner)));
        assert!(line.windows(2).all(|pair| libm::hypot(pair[1].0 - pair[0].0, pair[1].1 - pair[0].1) <= 4.0));
        assert!(dense(&[], 4.0).is_empty());
    }
}
