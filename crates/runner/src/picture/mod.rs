//! Drawings of surfaces, curves and motions for the terminal, and the charts that plots draw too.

use anstyle::{Ansi256Color, Style};

use crate::output::{counted, wrapped};
use crate::picture::chart::{Chart, ChartAxis, Form, Series};
use crate::picture::panels::MOST_PANELS;
use crate::picture::scale::Scale;
use crate::picture::terminal::drawn;
use crate::picture::title::{capitalised, own_name};
use crate::picture::view::{GridView, Slice, ViewAxis, is_family, label, probability, rounded};
use crate::tables::row::SurfaceRow;
use crate::tables::surface::Surface;

pub mod scale;

pub mod title;

pub mod view;

pub mod panels;

pub mod chart;

pub mod terminal;

pub mod exceptions;

pub mod asked_cell;

pub mod answer;

/// Largest number of rows and columns of a picture; larger grids are thinned out.
const MOST_ROWS: usize = 15;
const MOST_COLUMNS: usize = 60;

/// Largest number of slices (combinations of the axes that are not shown) that are drawn; of further ones there is the
/// range of probabilities.
const MOST_SLICES: usize = 4;

/// Lines of a terminal that the drawings of several slices may take; else the ranges of all slices stand for them.
const MOST_LINES: usize = 24;

/// Largest number of further slices of which the range of probabilities is listed.
const MOST_RANGES: usize = 12;

/// Largest number of values that are shown as bars, with their numbers; more make a curve.
const MOST_BARS: usize = 12;

/// Largest number of columns of a table of numbers, of four decimals and of three; more make shades.
const MOST_WIDE_COLUMNS: usize = 7;
const MOST_NARROW_COLUMNS: usize = 11;

/// Probabilities at which the axis of a curve may end.
const TOPS: [f64; 13] = [1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 5e-3, 2e-3, 1e-3, 1e-4, 1e-5, 1e-6];

/// Length of the bar for a probability of 1.
const BAR: usize = 40;

/// Shades, each with the smallest probability that it is drawn for, and its colour at a terminal that has 256 of them:
/// those of plots, from yellow to violet.
const SHADES: [(f64, char, Ansi256Color); 6] = [
    (0.8, '█', Ansi256Color(54)),
    (0.6, '▓', Ansi256Color(61)),
    (0.4, '▒', Ansi256Color(30)),
    (0.2, '░', Ansi256Color(71)),
    (0.01, '·', Ansi256Color(178)),
    (0.0, ' ', Ansi256Color(178)),
];

/// Largest share of samples without a verdict with which a probability is drawn.
const MOST_UNKNOWN: f64 = 0.1;

/// The mark of such a probability.
const UNKNOWN: &str = "more than 10 % of the samples undecided or failed";

/// Part of a drawing.
pub enum Drawing {
    Text(String),
    Chart(Box<Chart>),
}

/// The probability of instability over the two longest axes, one slice for each combination of the others. If only one
/// axis varies, the picture shows a curve, or bars if it is short.
pub fn picture(surface: &Surface<'_>) -> String {
    let text = |drawing| match drawing {
        Drawing::Text(text) => text,
        Drawing::Chart(chart) => drawn(&chart),
    };
    let drawn: String = drawings(surface).into_iter().map(text).collect();
    let view = GridView::new(surface.job());
    let slices = view.slices();
    if slices == 1 || drawn.lines().count() <= MOST_LINES { drawn } else { ranges(surface, &view, 0, slices) }
}

/// The same in parts.
pub fn drawings(surface: &Surface<'_>) -> Vec<Drawing> {
    let view = GridView::new(surface.job());
    let slices = view.slices();
    let mut all = Vec::new();
    for number in 0..slices.min(MOST_SLICES) {
        let slice = view.slice(number);
        all.push(of_slice(surface, &view, &slice));
    }
    if slices > MOST_SLICES {
        all.push(Drawing::Text(ranges(surface, &view, MOST_SLICES, slices)));
    }
    all
}

fn of_slice(surface: &Surface<'_>, view: &GridView, slice: &Slice<'_>) -> Drawing {
    let titled = |text: String| {
        let title = format!("Probability of instability{}", slice.title(surface.job()));
        Drawing::Text(format!("{}\n{text}", wrapped(&title)))
    };
    let (vertical, horizontal) = match (view.vertical(), view.horizontal()) {
        (Some(vertical), Some(horizontal)) => (vertical, horizontal),
        (None, Some(axis)) if axis.values.len() > MOST_BARS => {
            return curves(surface, slice, axis, None, |_, along| slice.cell(0, along));
        }
        (_, axis) => return titled(bars(surface, slice, axis)),
    };
    let upright = |up: usize, right: usize| slice.cell(up, right);
    let turned = |up: usize, right: usize| slice.cell(right, up);
    if fits_a_table(vertical, horizontal) {
        titled(table(surface, vertical, horizontal, upright))
    } else if fits_a_table(horizontal, vertical) {
        titled(table(surface, horizontal, vertical, turned))
    } else if is_family(vertical, horizontal) {
        curves(surface, slice, horizontal, Some(vertical), upright)
    } else if is_family(horizontal, vertical) {
        curves(surface, slice, vertical, Some(horizontal), turned)
    } else {
        titled(heat_map(surface, slice, vertical, horizontal))
    }
}

/// The slices that are not drawn, each with its range of probabilities; `first` of them all are drawn.
fn ranges(surface: &Surface<'_>, view: &GridView, first: usize, slices: usize) -> String {
    let left = (slices - first) as u128;
    let drawn = if slices <= MOST_PANELS { "them all".to_owned() } else { format!("at most {MOST_PANELS} at once") };
    let mut text = match first {
        0 => format!("Probability of instability in {left} slices; `stickslip plot` draws {drawn}\n"),
        _ => {
            let more = counted(left, "more slice", "more slices");
            format!("... and {more} in the file; `stickslip plot` draws {drawn}\n")
        }
    };
    text += "Smallest and largest probability:\n";
    let length = |axis: Option<&ViewAxis>| axis.map_or(1, |axis| axis.values.len());
    let has_one_scatter = surface.job().grid.scatters == 1;
    let listed = slices.min(first + MOST_RANGES);
    for number in first..listed {
        let slice = view.slice(number);
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for up in 0..length(view.vertical()) {
            for right in 0..length(view.horizontal()) {
                if let Some(p) = surface.row(slice.cell(up, right)).estimate.probability {
                    (low, high) = (low.min(p), high.max(p));
                }
            }
        }
        let range =
            if low <= high { format!("{} to {}", label(low), label(high).trim()) } else { "unknown".to_owned() };
        let title = slice.title(surface.job());
        let title = if has_one_scatter { title.split(';').next().unwrap_or_default() } else { &title };
        text += &format!("{range:<20}  {}\n", title.trim_start_matches([' ', ';']));
    }
    if slices > listed {
        text += &format!("and {}\n", counted((slices - listed) as u128, "further slice", "further slices"));
    }
    text + "\n"
}

/// At most `most` evenly spaced indices below `length`, both ends included.
fn thinned(length: usize, most: usize) -> Vec<usize> {
    if length <= most {
        return (0..length).collect();
    }
    (0..most).map(|i| (i * (length - 1) + (most - 1) / 2) / (most - 1)).collect()
}

fn heat_map(surface: &Surface<'_>, slice: &Slice<'_>, vertical: &ViewAxis, horizontal: &ViewAxis) -> String {
    let columns = thinned(horizontal.values.len(), MOST_COLUMNS);
    let width = if columns.len() <= MOST_COLUMNS / 2 { 2 } else { 1 };
    let mut text = format!(" {}\n", vertical.name);
    let mut has_unknown = false;
    for up in thinned(vertical.values.len(), MOST_ROWS).into_iter().rev() {
        let shade_of = |&right: &usize| known_probability(&surface.row(slice.cell(up, right))).map_or('?', shade);
        let shades: Vec<char> = columns.iter().map(shade_of).collect();
        has_unknown |= shades.contains(&'?');
        let line: String = shades.chunk_by(char::eq).map(|equal| coloured(equal[0], width * equal.len())).collect();
        text += &format!("{} |{line}|\n", label(vertical.values[up]));
    }
    text += &foot(&horizontal.name, horizontal.ends(), columns.len() * width);
    text += "          ' ' below 1 %, · to 20, ░ to 40, ▒ to 60, ▓ to 80, █ 80 % and more\n";
    if has_unknown {
        text += &format!("          ? {UNKNOWN}\n");
    }
    text + "\n"
}

fn fits_a_table(vertical: &ViewAxis, horizontal: &ViewAxis) -> bool {
    vertical.values.len() <= MOST_BARS && horizontal.values.len() <= MOST_NARROW_COLUMNS
}

/// The probabilities in numbers; `cell` gives the cell at positions upwards and to the right.
fn table(
    surface: &Surface<'_>,
    vertical: &ViewAxis,
    horizontal: &ViewAxis,
    cell: impl Fn(usize, usize) -> u64,
) -> String {
    let is_wide = horizontal.values.len() <= MOST_WIDE_COLUMNS;
    let width = if is_wide { 8 } else { 5 };
    let written: fn(f64) -> String = if is_wide { label } else { narrow };
    let mut text = format!(" {}\n", vertical.name);
    let mut has_unknown = false;
    for (up, &value) in vertical.values.iter().enumerate().rev() {
        let mut line = format!("{} |", label(value));
        for right in 0..horizontal.values.len() {
            let row = surface.row(cell(up, right));
            let mark = if known_probability(&row).is_some() { ' ' } else { '?' };
            has_unknown |= mark == '?';
            line += &format!("{:>width$}{mark}", row.estimate.probability.map_or(String::new(), written));
        }
        text += &format!("{}\n", line.trim_end());
    }
    let values: String = horizontal.values.iter().map(|&value| format!("{:>width$} ", written(value))).collect();
    let line = "-".repeat(values.chars().count());
    let name = if line.len() + horizontal.name.len() < MOST_COLUMNS + 8 {
        format!("{values}  {}", horizontal.name)
    } else {
        format!("{}\n{:10}{:>length$}", values.trim_end(), "", horizontal.name, length = line.len())
    };
    text += &format!("{:9}+{line}+\n{:10}{name}\n", "", "");
    if has_unknown {
        text += &format!("          ? {UNKNOWN}\n");
    }
    text + "\n"
}

/// A number in five characters.
fn narrow(value: f64) -> String {
    if (-0.1..=-0.01).contains(&value) {
        return format!("{value:.3}").replacen("0.", ".", 1);
    }
    let (least, sign) = if value < 0.0 { (0.1, 1) } else { (1e-3, 0) };
    let plain = value == 0.0 || (least..1e5).contains(&value.abs());
    if !plain {
        return format!("{value:.0e}");
    }
    let whole = sign + format!("{:.0}", value.abs().trunc()).len();
    format!("{value:.*}", 4_usize.saturating_sub(whole).min(3))
}

/// The axis below a picture: its line, its ends and its name, which has a line of its own where it is long.
pub fn foot(name: &str, ends: [f64; 2], inside: usize) -> String {
    let [from, to] = ends.map(rounded);
    let gap = inside.saturating_sub(from.len() + to.len()).max(1);
    let break_before = if inside + name.len() > MOST_COLUMNS + 8 { format!("\n{:10}", "") } else { "  ".to_owned() };
    format!("{:9}+{}+\n{:10}{from}{:gap$}{to}{break_before}{name}\n", "", "-".repeat(inside), "", "")
}

/// The probability of a cell, if enough samples have a verdict.
fn known_probability(row: &SurfaceRow) -> Option<f64> {
    row.estimate.probability.filter(|_| row.unknown_share() <= MOST_UNKNOWN)
}

fn shade(probability: f64) -> char {
    SHADES.iter().find(|(from, ..)| probability >= *from).map_or(' ', |(_, shade, _)| *shade)
}

/// A shade so many times, in its colour.
fn coloured(shade: char, times: usize) -> String {
    let text: String = std::iter::repeat_n(shade, times).collect();
    let colour = SHADES.iter().find(|(_, known, _)| *known == shade && shade != ' ').map(|(_, _, colour)| *colour);
    colour.map_or_else(
        || text.clone(),
        |colour| {
            let style = Style::new().fg_color(Some(colour.into()));
            format!("{style}{text}{style:#}")
        },
    )
}

fn bars(surface: &Surface<'_>, slice: &Slice<'_>, axis: Option<&ViewAxis>) -> String {
    let mut text = axis.map_or_else(String::new, |axis| format!(" {}\n", axis.name));
    let rows: Vec<SurfaceRow> =
        (0..axis.map_or(1, |axis| axis.values.len())).map(|index| surface.row(slice.cell(0, index))).collect();
    let numbers: Vec<Option<[String; 3]>> = rows
        .iter()
        .map(|SurfaceRow { estimate, .. }| Some([estimate.probability?, estimate.low, estimate.high].map(probability)))
        .collect();
    // Small probabilities with an exponent of two digits are longer than the others.
    let width = numbers.iter().flatten().flatten().map(String::len).max().unwrap_or(0);
    for (index, (row, numbers)) in rows.iter().zip(&numbers).enumerate() {
        let line = match (row.estimate.probability, numbers) {
            (Some(p), Some([probability, low, high])) => {
                let filled = (p * BAR as f64).round() as usize;
                let bar = format!("{}{}", "█".repeat(filled), " ".repeat(BAR - filled));
                let unknown = if row.unknown_share() > MOST_UNKNOWN {
                    format!("\n{:9}|{:.0} % of the samples undecided or failed", "", 100.0 * row.unknown_share())
                } else {
                    String::new()
                };
                format!("{bar}| {probability:>width$}  ({low:>width$} to {high:>width$}){unknown}")
            }
            _ if row.counts.total() > 0 && row.counts.decided() == 0 => "no sample was decided".to_owned(),
            _ => {
                let (low, high) = (row.estimate.low, row.estimate.high);
                format!("no probability, only {} to {}", probability(low), probability(high))
            }
        };
        text += &format!("{} |{line}\n", axis.map_or_else(|| " ".repeat(8), |axis| label(axis.values[index])));
    }
    text.push('\n');
    text
}

/// The probability along an axis with its interval: a curve for each value of another axis, if one is given; `cell`
/// gives the cell of a curve and of a place along it.
fn curves(
    surface: &Surface<'_>,
    slice: &Slice<'_>,
    along: &ViewAxis,
    several: Option<&ViewAxis>,
    cell: impl Fn(usize, usize) -> u64,
) -> Drawing {
    let mut series = Vec::new();
    let mut unknown = Vec::new();
    for number in 0..several.map_or(1, |axis| axis.values.len()) {
        let (mut points, mut band) = (Vec::new(), Vec::new());
        for (index, &at) in along.values.iter().enumerate() {
            let row = surface.row(cell(number, index));
            let known = known_probability(&row);
            points.push((at, known.unwrap_or(f64::NAN)));
            band.push(known.map_or((f64::NAN, f64::NAN), |_| (row.estimate.low, row.estimate.high)));
            if known.is_none() {
                unknown.push((at, 0.0));
            }
        }
        let name = several.map_or_else(String::new, |axis| {
            format!("{} {} {}", axis.key(), rounded(axis.values[number]), axis.unit()).trim_end().to_owned()
        });
        series.push(Series { band, ..Series::numbered(number, name, points) });
    }
    let ends = || series.iter().flat_map(|series: &Series| series.band.iter().map(|(_, high)| *high));
    let highest = ends().filter(|high| high.is_finite()).fold(0.0, f64::max);
    let is_known = ends().any(f64::is_finite);
    let top = TOPS.into_iter().rev().find(|top| is_known && *top >= highest).unwrap_or(1.0);
    // Below the least of them the axis ends at the curve.
    let top = if highest > 0.0 && highest < 0.1 * top { highest } else { top };
    if !unknown.is_empty() {
        let name = UNKNOWN.to_owned();
        series.push(Series { name, symbol: '?', form: Form::Points, points: unknown, band: Vec::new() });
    }
    let job = surface.job();
    let title = format!("Probability of instability{}", slice.title(job));
    // The keys of the model stay as they are written.
    let own = along.quantity.and_then(|place| own_name(job.quantity(place)));
    let name = match (own, along.key()) {
        (Some(own), _) => own.to_owned(),
        (None, key) if key.contains('.') => key.to_owned(),
        (None, key) => capitalised(key),
    };
    let horizontal = ChartAxis::new(&name, along.unit(), Scale::for_values(&along.values));
    let vertical = ChartAxis::new("P", "", Scale::linear(0.0, top));
    let mut chart = Chart::new(title, horizontal, vertical, series);
    chart.note = format!("shaded: {}", job.sampling.method.interval(&job.sampling));
    Drawing::Chart(Box::new(chart))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_probabilities_are_not_shown_as_zero() {
        for (value, text) in [
            (0.0, "0.0000"),
            (1.0, "1.0000"),
            (0.25, "0.2500"),
            (1e-3, "0.0010"),
            (9.99e-4, "1.0e-3"),
            (2.8e-7, "2.8e-7"),
            (3.14e-12, "3.1e-12"),
        ] {
            assert_eq!(probability(value), text);
        }
    }

    #[test]
    fn shades_have_colours_that_can_be_taken_out() {
        assert_eq!(coloured('█', 2), "\u{1b}[38;5;54m██\u{1b}[0m");
        assert_eq!(crate::output::without_colours(&coloured('·', 3)), "···");
        assert_eq!([coloured(' ', 2), coloured('?', 1)], ["  ", "?"]);
    }

    #[test]
    fn narrow_numbers_have_five_characters_at_most() {
        for (value, text) in
            [(0.0, "0.000"), (0.1234, "0.123"), (1.0, "1.000"), (15.5, "15.50"), (1234.5, "1234"), (2.8e-7, "3e-7")]
        {
            assert_eq!(narrow(value), text);
        }
        for (value, text) in
            [(-0.5, "-0.50"), (-0.0133, "-.013"), (-1e-3, "-1e-3"), (-15.5, "-15.5"), (-1234.5, "-1234")]
        {
            assert_eq!(narrow(value), text);
        }
    }
}
