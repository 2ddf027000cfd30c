//! Charts as plots: one panel for each, with its legend above it.

use crate::picture::chart::{Chart, ChartAxis, Form, Series, Share, listed};
use crate::picture::view::rounded;
use crate::plot::canvas::{BLACK, Canvas, GREY, Pen, Place, Rgb, Side, width_of};
use crate::plot::panel::{Axis, BELOW, LEFT, NORMAL, Panel, SMALL, left_of};

/// Colours of curves that colour-blind readers can distinguish (Okabe and Ito).
pub const COLOURS: [Rgb; 6] = [
    (0x00, 0x72, 0xb2),
    (0xd5, 0x5e, 0x00),
    (0x00, 0x9e, 0x73),
    (0xcc, 0x79, 0xa7),
    (0x8f, 0x6a, 0x00),
    (0x56, 0xb4, 0xe9),
];

/// Space at the right of a panel and above its title, height of a panel over its width, and height of a line of text.
const RIGHT: f64 = 14.0;
const ABOVE: f64 = 6.0;
const ASPECT: f64 = 0.6;
const LINE_HEIGHT: f64 = 14.0;

/// Panels side by side are at least this wide, with their axes.
const LEAST_WIDTH: f64 = 280.0;

/// A curve may be drawn this far from its points, in pixels, to be written with fewer of them; a part of a curve that
/// is looked at together has so many.
const TOLERANCE: f64 = 0.12;
const TOGETHER: usize = 400;

/// Radius of points and width of curves.
const POINT: f64 = 1.3;
const CURVE: f64 = 1.2;

/// The sample of a colour in a legend, and the space after an entry.
const SAMPLE: f64 = 14.0;
const AFTER: f64 = 12.0;

/// Charts as one figure, this wide in pixels.
pub fn figure(charts: &[&Chart], width: f64) -> Canvas {
    titled_figure("", charts, width)
}

/// The same under a title, unless that is empty.
pub fn titled_figure(title: &str, charts: &[&Chart], width: f64) -> Canvas {
    let columns = ((width / LEAST_WIDTH).floor() as usize).clamp(1, charts.len().clamp(1, 2));
    let step = width / columns as f64;
    let panel_width = step - LEFT - RIGHT;
    let panel_height = ASPECT * panel_width;
    let legends: Vec<Vec<Vec<Entry>>> = charts.iter().map(|chart| legend(chart, step - ABOVE)).collect();
    // Panels side by side begin at one height.
    let heads: Vec<f64> = legends
        .chunks(columns)
        .map(|row| 2.0 * ABOVE + LINE_HEIGHT * (1 + row.iter().map(Vec::len).max().unwrap_or(0)) as f64)
        .collect();
    let height: f64 = heads.iter().map(|head| head + panel_height + BELOW).sum();
    let mut top = if title.is_empty() { 0.0 } else { ABOVE + LINE_HEIGHT };
    let mut canvas = Canvas::new(width, top + height + 4.0);
    let size = (7..=NORMAL).rev().find(|&size| width_of(title, size) <= width - 2.0 * ABOVE).unwrap_or(7);
    if !title.is_empty() {
        canvas.text((0.5 * width, LINE_HEIGHT), title, size, Side::Middle, 0.0, BLACK);
    }
    for ((charts, legends), head) in charts.chunks(columns).zip(legends.chunks(columns)).zip(heads) {
        for (column, (chart, legend)) in charts.iter().zip(legends).enumerate() {
            let left = column as f64 * step;
            let wider = left_of(&axis(&chart.vertical), panel_height) - LEFT;
            let panel =
                Panel { left: left + LEFT + wider, top: top + head, width: panel_width - wider, height: panel_height };
            canvas.text(
                (left + ABOVE, top + LINE_HEIGHT),
                &chart.title,
                fitting(&chart.title, step - ABOVE),
                Side::Right,
                0.0,
                BLACK,
            );
            draw_legend(&mut canvas, legend, (left + ABOVE, top + 2.0 * LINE_HEIGHT));
            draw(&mut canvas, &panel, chart);
        }
        top += head + panel_height + BELOW;
    }
    canvas
}

/// The largest size of a font in which a text is not longer than this.
fn fitting(text: &str, length: f64) -> u32 {
    (7..=SMALL).rev().find(|&size| width_of(text, size) <= length).unwrap_or(7)
}

/// What an entry of a legend shows before its text: the colour of a series, the line of marks, or nothing.
#[derive(Clone, Copy, PartialEq)]
enum Sample {
    Series(usize),
    Marks,
    Nothing,
}

/// An entry of a legend with what it says.
type Entry = (Sample, String);

impl Sample {
    /// Its width with the space after it.
    fn width(self) -> f64 {
        if self == Self::Nothing { 0.0 } else { SAMPLE + 4.0 }
    }
}

/// The entries of a chart in lines of this length.
fn legend(chart: &Chart, length: f64) -> Vec<Vec<Entry>> {
    let named = chart.series.iter().enumerate().filter(|(_, series)| !series.name.is_empty());
    let mut entries: Vec<Entry> = named.map(|(number, series)| (Sample::Series(number), series.name.clone())).collect();
    let marks = chart.marks.iter().map(|marks| format!("{}: {}", marks.what, listed(&marks.values)));
    entries.extend(marks.map(|marks| (Sample::Marks, marks)));
    entries.extend((!chart.note.is_empty()).then(|| (Sample::Nothing, chart.note.clone())));
    let mut lines: Vec<Vec<Entry>> = Vec::new();
    let mut used = 0.0;
    for entry in entries {
        let needed = entry.0.width() + width_of(&entry.1, SMALL - 1) + AFTER;
        match lines.last_mut() {
            Some(line) if used + needed <= length => line.push(entry),
            _ => {
                lines.push(vec![entry]);
                used = 0.0;
            }
        }
        used += needed;
    }
    lines
}

fn draw_legend(canvas: &mut Canvas, lines: &[Vec<Entry>], (left, top): Place) {
    for (line, entries) in lines.iter().enumerate() {
        let mut x = left;
        let y = top + line as f64 * LINE_HEIGHT;
        for (sample, text) in entries {
            let (from, to) = ((x, y - 3.0), (x + SAMPLE, y - 3.0));
            match sample {
                Sample::Series(number) => canvas.line(from, to, Pen::new(colour(*number), 2.0)),
                Sample::Marks => canvas.dashes(&[from, to], Pen::new(GREY, 1.0)),
                Sample::Nothing => {}
            }
            canvas.text((x + sample.width(), y), text, SMALL - 1, Side::Right, 0.0, BLACK);
            x += sample.width() + width_of(text, SMALL - 1) + AFTER;
        }
    }
}

fn colour(series: usize) -> Rgb {
    COLOURS[series % COLOURS.len()]
}

fn draw(canvas: &mut Canvas, panel: &Panel, chart: &Chart) {
    let place = |(right, up): Share| panel.place(right, up);
    if let Some(zero) = chart.zero() {
        canvas.line(place((0.0, zero)), place((1.0, zero)), Pen::new(GREY, 0.8));
    }
    let mut free_from = panel.left;
    for (value, at) in chart.marked() {
        canvas.dashes(&[place((at, 0.0)), place((at, 1.0))], Pen::new(GREY, 0.8));
        // The legend has them all, also where there is no room for a label.
        let (x, y) = place((at, 1.0));
        if x - f64::from(SMALL) >= free_from {
            canvas.text((x - 3.0, y + 4.0), &rounded(value), SMALL - 3, Side::Left, -90.0, GREY);
            free_from = x;
        }
    }
    for (number, series) in chart.series.iter().enumerate() {
        for piece in chart.bands(series) {
            let upper = piece.iter().map(|&(x, _, high)| place((x, high)));
            let lower = piece.iter().rev().map(|&(x, low, _)| place((x, low)));
            canvas.area(&[upper.chain(lower).collect()], colour(number), 0.25);
        }
    }
    for (number, series) in chart.series.iter().enumerate() {
        draw_series(canvas, panel, chart, series, colour(number));
    }
    panel.frame(canvas, &axis(&chart.horizontal), &axis(&chart.vertical));
}

fn draw_series(canvas: &mut Canvas, panel: &Panel, chart: &Chart, series: &Series, colour: Rgb) {
    let place = |(right, up): Share| panel.place(right, up);
    match series.form {
        Form::Points => {
            chart.points(series).into_iter().for_each(|share| canvas.dot(place(share), POINT, colour));
        }
        Form::Line => {
            for line in chart.lines(series) {
                let places: Vec<Place> = line.into_iter().map(place).collect();
                canvas.lines(&simplified(&places), Pen::new(colour, CURVE));
            }
        }
    }
}

fn axis(of: &ChartAxis) -> Axis {
    Axis { scale: of.scale, title: of.title.clone(), unit: of.unit.clone() }
}

/// A line with fewer points that nowhere is far from the given one (Ramer, Douglas and Peucker, in parts).
pub fn simplified(line: &[Place]) -> Vec<Place> {
    let Some(&first) = line.first() else { return Vec::new() };
    let mut kept = vec![first];
    let mut start = 0;
    while start + 1 < line.len() {
        let end = (start + TOGETHER).min(line.len() - 1);
        let part = &line[start..=end];
        let mut keeps = vec![false; part.len()];
        keeps[part.len() - 1] = true;
        let mut open = vec![(0, part.len() - 1)];
        while let Some((from, to)) = open.pop() {
            let distances = (from + 1..to).map(|i| (i, distance(part[i], part[from], part[to])));
            if let Some((farthest, far)) = distances.max_by(|a, b| a.1.total_cmp(&b.1))
                && far > TOLERANCE
            {
                keeps[farthest] = true;
                open.extend([(from, farthest), (farthest, to)]);
            }
        }
        kept.extend(part.iter().zip(keeps).filter(|(_, keeps)| *keeps).map(|(place, _)| *place));
        start = end;
    }
    kept
}

/// The distance of a place from a straight line between two others.
fn distance(place: Place, from: Place, to: Place) -> f64 {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let square = dx * dx + dy * dy;
    let along = if square > 0.0 { ((place.0 - from.0) * dx + (place.1 - from.1) * dy) / square } else { 0.0 };
    let along = along.clamp(0.0, 1.0);
    libm::hypot(place.0 - from.0 - along * dx, place.1 - from.1 - along * dy)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_simplified_line_stays_near_all_of_its_points() {
        let wave: Vec<Place> = (0..5000).map(|i| (0.1 * f64::from(i), 50.0 * libm::sin(0.02 * f64::from(i)))).collect();
        let simple = simplified(&wave);
        assert!(simple.len() < 600, "{}", simple.len());
        assert_eq!((simple.first(), simple.last()), (wave.first(), wave.last()));
        for &place in &wave {
            let nearest = simple.windows(2).map(|pair| distance(place, pair[0], pair[1])).fold(f64::MAX, f64::min);
            assert!(nearest <= TOLERANCE, "{place:?}: {nearest}");
        }
        assert!(simplified(&[]).is_empty());
    }
}
