//! The probability of a run: filled contours over two axes, curves with their intervals over one.

use crate::job::Criterion;
use crate::picture::scale::Scale;
use crate::picture::view::{GridView, MOST_PANELS, Slice, ViewAxis, is_family};
use crate::plot::axes::axis;
use crate::plot::canvas::{BLACK, Canvas, GREY, Pen, Place, Rgb, Side, WHITE, width_of};
use crate::plot::contours::Field;
use crate::plot::levels::{Levels, deviate, label};
use crate::plot::panel::{Axis, BELOW, LEFT, NORMAL, Panel, SMALL};
use crate::plot::values::Values;

/// Space above a panel for its title, at the right of the last panel, and for the colour bar.
const ABOVE: f64 = 24.0;
const RIGHT: f64 = 14.0;
const BAR: f64 = 74.0;

/// Height of a panel over its width, of surfaces and of curves.
const SURFACE_ASPECT: f64 = 0.78;
const CURVE_ASPECT: f64 = 0.6;

/// Least width of a panel.
const LEAST_WIDTH: f64 = 150.0;

const LINE: Pen = Pen::new(BLACK, 1.0);
const HATCH: Pen = Pen::new(GREY, 0.5);
const HATCH_DISTANCE: f64 = 5.0;

/// A figure of a run, this wide in pixels.
pub fn figure(values: &Values, width: f64) -> Canvas {
    let view = GridView::new(&values.job);
    match (view.vertical(), view.horizontal()) {
        (Some(vertical), Some(horizontal)) if is_family(vertical, horizontal) => {
            curves(values, &view, horizontal, Some(vertical), false, width)
        }
        (Some(vertical), Some(horizontal)) if is_family(horizontal, vertical) => {
            curves(values, &view, vertical, Some(horizontal), true, width)
        }
        (Some(vertical), Some(horizontal)) => {
            Surfaces { values, view: &view, vertical, horizontal, levels: Levels::up_to(values.largest()) }
                .figure(width)
        }
        (_, along) => curves(values, &view, along.unwrap_or(&ViewAxis::single()), None, false, width),
    }
}

/// Where the panels of a figure lie, and its size.
struct Arrangement {
    panels: Vec<Panel>,
    height: f64,
}

fn arrangement(count: usize, width: f64, has_bar: bool, aspect: f64) -> Arrangement {
    let inside = width - RIGHT - if has_bar { BAR } else { 0.0 };
    let fits = ((inside / (LEFT + LEAST_WIDTH)).floor() as usize).max(1);
    let columns = fits.min(count.max(1));
    let panel_width = inside / columns as f64 - LEFT;
    let panel_height = aspect * panel_width;
    let step = ABOVE + panel_height + BELOW;
    let panels = (0..count).map(|i| Panel {
        left: LEFT + (i % columns) as f64 * (LEFT + panel_width),
        top: ABOVE + (i / columns) as f64 * step,
        width: panel_width,
        height: panel_height,
    });
    Arrangement { panels: panels.collect(), height: count.div_ceil(columns) as f64 * step + 12.0 }
}

/// A surface in each panel.
struct Surfaces<'a> {
    values: &'a Values,
    view: &'a GridView,
    vertical: &'a ViewAxis,
    horizontal: &'a ViewAxis,
    levels: Levels,
}

impl Surfaces<'_> {
    fn figure(&self, width: f64) -> Canvas {
        let count = self.view.slices().min(MOST_PANELS);
        let Arrangement { panels, height } = arrangement(count, width, true, SURFACE_ASPECT);
        let mut canvas = Canvas::new(width, height);
        for (number, panel) in panels.iter().enumerate() {
            self.panel(&mut canvas, panel, &self.view.slice(number));
        }
        if let (Some(first), Some(top_right)) = (panels.first(), panels.iter().map(Panel::right).reduce(f64::max)) {
            self.bar(&mut canvas, Panel { left: top_right + 14.0, width: 13.0, ..*first });
        }
        if self.has_boundary() {
            let note = "dashed: stability boundary of the expected brake";
            let at = (width - RIGHT, height - 4.0);
            canvas.text(at, note, SMALL - 3, Side::Left, 0.0, GREY);
        }
        canvas
    }

    /// Whether the boundary of stability is known in closed form, and lies in the plane that is shown.
    fn has_boundary(&self) -> bool {
        self.vertical.key() == "preload"
            && self.horizontal.key() == "static friction"
            && matches!(self.values.job.criterion, Criterion::Eigenvalue)
    }

    fn panel(&self, canvas: &mut Canvas, panel: &Panel, slice: &Slice<'_>) {
        let (horizontal, vertical) = (axis(self.horizontal), axis(self.vertical));
        let columns: Vec<f64> =
            self.horizontal.values.iter().map(|&value| panel.place(horizontal.scale.at(value), 0.0).0).collect();
        let rows: Vec<f64> =
            self.vertical.values.iter().map(|&value| panel.place(0.0, vertical.scale.at(value)).1).collect();
        let cells = (0..rows.len()).flat_map(|up| (0..columns.len()).map(move |right| (up, right)));
        let cells: Vec<usize> = cells.map(|(up, right)| slice.cell(up, right) as usize).collect();
        let values: Vec<Option<f64>> = cells.iter().map(|&cell| self.values.probability[cell].map(deviate)).collect();
        let field = Field { columns: &columns, rows: &rows, values: &values };

        canvas.area(&field.at_least(f64::NEG_INFINITY), self.levels.colour(0), 1.0);
        for (band, &level) in (1..).zip(self.levels.all()) {
            canvas.area(&field.at_least(deviate(level)), self.levels.colour(band), 1.0);
        }
        self.hatch(canvas, panel, &columns, &rows, &cells);
        self.boundary(canvas, panel, slice, &horizontal, &vertical);
        let mut boxes = Vec::new();
        for &level in self.levels.lines() {
            let band = self.levels.band(level);
            let colour = if 2 * band > self.levels.bands() + 4 { WHITE } else { BLACK };
            for line in field.on(deviate(level)) {
                labelled_line(canvas, panel, &line, &label(level), colour, &mut boxes);
            }
        }
        panel.frame(canvas, &horizontal, &vertical);
        self.heading(canvas, panel, slice);
    }

    /// Lines across the cells whose interval is wider than a band.
    fn hatch(&self, canvas: &mut Canvas, panel: &Panel, columns: &[f64], rows: &[f64], cells: &[usize]) {
        let edge = |places: &[f64], i: usize, by: isize| {
            let other = i.checked_add_signed(by).and_then(|other| places.get(other));
            other.map_or(places[i], |other| 0.5 * (places[i] + other))
        };
        for (i, &cell) in cells.iter().enumerate() {
            let (up, right) = (i / columns.len(), i % columns.len());
            let (low, high) = (self.values.low[cell], self.values.high[cell]);
            if self.levels.band(high) <= self.levels.band(low) + 1 || self.values.probability[cell].is_none() {
                continue;
            }
            let xs = [edge(columns, right, -1), edge(columns, right, 1)];
            let ys = [edge(rows, up, -1), edge(rows, up, 1)];
            let (left, right) = (xs[0].min(xs[1]).max(panel.left), xs[0].max(xs[1]).min(panel.right()));
            let (top, bottom) = (ys[0].min(ys[1]), ys[0].max(ys[1]));
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

    /// The boundary of stability of the expected brake, where it is known in closed form.
    fn boundary(&self, canvas: &mut Canvas, panel: &Panel, slice: &Slice<'_>, horizontal: &Axis, vertical: &Axis) {
        let job = &self.values.job;
        if !self.has_boundary() {
            return;
        }
        let Ok(brake) = job.brake(job.grid.brake_index(slice.first)) else { return };
        let boundary = brake.stability_boundary();
        let mut line: Vec<Place> = Vec::new();
        for i in 0..=200 {
            let [from, to] = self.horizontal.ends();
            let friction = from + (to - from) * f64::from(i) / 200.0;
            let place =
                panel.place(horizontal.scale.at(friction), vertical.scale.at(boundary.critical_preload(friction)));
            if panel.contains(place) {
                line.push(place);
            }
        }
        canvas.dashes(&line, Pen::new(WHITE, 1.2));
    }

    fn heading(&self, canvas: &mut Canvas, panel: &Panel, slice: &Slice<'_>) {
        let title = slice.title(&self.values.job);
        write_heading(canvas, panel, title.trim_start_matches([' ', ';']).trim_start_matches("at "));
    }

    fn bar(&self, canvas: &mut Canvas, bar: Panel) {
        let bands = self.levels.bands() as f64;
        for band in 0..self.levels.bands() {
            let (low, high) = (bar.place(0.0, band as f64 / bands), bar.place(1.0, (band + 1) as f64 / bands));
            canvas.area(&[bar.rectangle((low.0, high.1), (high.0, low.1))], self.levels.colour(band), 1.0);
        }
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0)];
        canvas.lines(&corners.map(|(right, up)| bar.place(right, up)), Pen::new(BLACK, 0.8));
        for (i, &level) in (1..).zip(self.levels.all()) {
            let at = bar.place(1.0, f64::from(i) / bands);
            canvas.line(at, (at.0 + 3.0, at.1), Pen::new(BLACK, 0.8));
            canvas.text((at.0 + 5.0, at.1 + 3.0), &label(level), SMALL - 1, Side::Right, 0.0, BLACK);
        }
        let beside = (bar.right() + 42.0, bar.top + 0.5 * bar.height);
        canvas.text(beside, "Probability of instability", SMALL, Side::Middle, -90.0, BLACK);
    }
}

/// The title of a panel, in two lines where it is long.
fn write_heading(canvas: &mut Canvas, panel: &Panel, title: &str) {
    let middle = panel.left + 0.5 * panel.width;
    let length = panel.width + 0.8 * LEFT;
    let size = (7..=SMALL).rev().find(|&size| width_of(title, size) <= length);
    match (size, title.split_once("; ")) {
        (None, Some((first, second))) => {
            canvas.text((middle, panel.top - 14.0), first, 8, Side::Middle, 0.0, BLACK);
            canvas.text((middle, panel.top - 4.0), second, 8, Side::Middle, 0.0, BLACK);
        }
        (size, _) => canvas.text((middle, panel.top - 6.0), title, size.unwrap_or(7), Side::Middle, 0.0, BLACK),
    }
}

/// A contour line with its label in a gap, where the line is long enough and no other label is near.
fn labelled_line(canvas: &mut Canvas, panel: &Panel, line: &[Place], text: &str, colour: Rgb, labels: &mut Vec<Place>) {
    let pen = Pen { colour, ..LINE };
    let size = SMALL - 2;
    let gap = width_of(text, size) + 4.0;
    let distance = |a: Place, b: Place| libm::hypot(a.0 - b.0, a.1 - b.1);
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
    let mut best: Option<(f64, Place)> = None;
    for pair in line.windows(2) {
        walked += distance(pair[0], pair[1]);
        let from_middle = (walked - 0.5 * length).abs();
        if is_free(pair[1]) && best.is_none_or(|(other, _)| from_middle < other) {
            best = Some((from_middle, pair[1]));
        }
    }
    let Some((_, middle)) = best.filter(|_| length > 2.5 * gap) else {
        canvas.lines(line, pen);
        return;
    };
    labels.push(middle);
    let is_outside = |place: &Place| distance(*place, middle) > 0.5 * gap;
    line.split(|place| !is_outside(place)).for_each(|part| canvas.lines(part, pen));
    // The direction of the line from one end of the gap to the other.
    let near = line.iter().position(|place| *place == middle).unwrap_or(0);
    let from = line[..near].iter().rev().find(|place| is_outside(place)).copied().unwrap_or(middle);
    let to = line[near..].iter().find(|place| is_outside(place)).copied().unwrap_or(middle);
    let (from, to) = if from.0 <= to.0 { (from, to) } else { (to, from) };
    let turn = libm::atan2(to.1 - from.1, to.0 - from.0).to_degrees();
    let (sine, cosine) = (libm::sin(turn.to_radians()), libm::cos(turn.to_radians()));
    let down = 0.35 * f64::from(size);
    let at = (middle.0 - down * sine, middle.1 + down * cosine);
    canvas.text(at, text, size, Side::Middle, turn, colour);
}

/// Curves along an axis with their intervals, one for each value of another, and one panel for each combination of the
/// axes that are not shown; `along_vertical` says that the curves run along the vertical axis of the view.
fn curves(
    values: &Values,
    view: &GridView,
    horizontal: &ViewAxis,
    several: Option<&ViewAxis>,
    along_vertical: bool,
    width: f64,
) -> Canvas {
    let family = several.map_or(&[f64::NAN][..], |axis| &axis.values);
    let has_legend = family.len() > 1;
    let Arrangement { panels, height } = arrangement(view.slices().min(MOST_PANELS), width, has_legend, CURVE_ASPECT);
    let mut canvas = Canvas::new(width, height);
    let top = values.high.iter().copied().filter(|high| high.is_finite()).fold(0.0, f64::max);
    let top = [1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01].into_iter().rev().find(|limit| *limit >= top).unwrap_or(1.0);
    let top = if values.largest() < 1e-3 { values.largest() * 1.2 + 1e-12 } else { top };
    let vertical =
        Axis { scale: Scale::linear(0.0, top), title: "Probability of instability P".to_owned(), unit: String::new() };
    let along = axis(horizontal);
    for (number, panel) in panels.iter().enumerate() {
        let slice = view.slice(number);
        for (up, _) in family.iter().enumerate() {
            let colour = colour_of(up, family.len());
            let place = |right: usize, p: f64| {
                panel.place(along.scale.at(horizontal.values[right]), vertical.scale.at(p.min(top)))
            };
            let cell = |right: usize| {
                let (up, right) = if along_vertical { (right, up) } else { (up, right) };
                slice.cell(up, right) as usize
            };
            let known = |right: &usize| values.probability[cell(*right)].is_some();
            let all: Vec<usize> = (0..horizontal.values.len()).collect();
            for part in all.split(|right| !known(right)).filter(|part| !part.is_empty()) {
                let upper = part.iter().map(|&right| place(right, values.high[cell(right)]));
                let lower = part.iter().rev().map(|&right| place(right, values.low[cell(right)]));
                canvas.area(&[upper.chain(lower).collect()], colour, 0.25);
                let line: Vec<Place> =
                    part.iter().map(|&right| place(right, values.probability[cell(right)].unwrap_or(0.0))).collect();
                canvas.lines(&line, Pen::new(colour, 1.6));
                if part.len() <= 40 {
                    line.iter().for_each(|&at| canvas.dot(at, 1.8, colour));
                }
            }
        }
        panel.frame(&mut canvas, &along, &vertical);
        let title = slice.title(&values.job);
        write_heading(&mut canvas, panel, title.trim_start_matches([' ', ';']).trim_start_matches("at "));
    }
    if let (Some(second), Some(first)) = (several, panels.first()) {
        let right = panels.iter().map(Panel::right).fold(0.0, f64::max) + 8.0;
        let heading = axis(second);
        canvas.text((right, first.top + 8.0), &heading.title, SMALL - 2, Side::Right, 0.0, BLACK);
        for (up, value) in family.iter().enumerate().rev() {
            let y = first.top + 8.0 + f64::from(NORMAL) * 1.3 * (family.len() - up) as f64;
            canvas.line((right, y - 3.0), (right + 14.0, y - 3.0), Pen::new(colour_of(up, family.len()), 2.0));
            let text = format!("{} {}", crate::picture::view::rounded(*value), heading.unit);
            canvas.text((right + 18.0, y), text.trim_end(), SMALL - 1, Side::Right, 0.0, BLACK);
        }
    }
    canvas
}

/// Colours of curves, from dark to light.
fn colour_of(curve: usize, of: usize) -> Rgb {
    let share = 0.1 + 0.75 * curve as f64 / of.max(2) as f64;
    kuva::plot::colormap::ColorMap::Viridis.map_rgb(share).unwrap_or_default()
}
