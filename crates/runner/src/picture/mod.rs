//! Pictures of surfaces and curves for the terminal.

use crate::output::counted;
use crate::picture::view::{GridView, MOST_PANELS, Slice, ViewAxis, label, rounded};
use crate::tables::row::SurfaceRow;
use crate::tables::surface::Surface;

pub mod view;

pub mod answer;

/// Largest number of rows and columns of a picture; larger grids are thinned out.
const MOST_ROWS: usize = 15;
const MOST_COLUMNS: usize = 60;

/// Largest number of slices (combinations of the axes that are not shown) that are shown.
const MOST_SLICES: usize = 4;

/// Largest number of values that are shown as bars, with their numbers; more make a curve.
const MOST_BARS: usize = 12;

/// Largest number of columns of a table of numbers; more make shades.
const MOST_TABLE_COLUMNS: usize = 6;

/// Height of a curve, and the probabilities at which it may end.
const CURVE_ROWS: usize = 17;
const TOPS: [f64; 13] = [1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 5e-3, 2e-3, 1e-3, 1e-4, 1e-5, 1e-6];

/// Length of the bar for a probability of 1.
const BAR: usize = 40;

/// Shades, each with the smallest probability that it is drawn for.
const SHADES: [(f64, char); 6] = [(0.8, '█'), (0.6, '▓'), (0.4, '▒'), (0.2, '░'), (0.01, '·'), (0.0, ' ')];

/// Largest share of samples without a verdict with which a probability is drawn.
const MOST_UNKNOWN: f64 = 0.1;

/// The mark of such a probability.
const UNKNOWN: &str = "          ? more than 10 % of the samples undecided or failed\n";

/// The probability of instability over the two longest axes, one slice for each combination of the others. If only one
/// axis varies, the picture shows a curve, or bars if it is short.
pub fn picture(surface: &Surface<'_>) -> String {
    let view = GridView::new(surface.job());
    let slices = view.slices();
    let mut text = String::new();
    for number in 0..slices.min(MOST_SLICES) {
        let slice = view.slice(number);
        text += &format!("Probability of instability{}\n\n", slice.title(surface.job()));
        text += &match (view.vertical(), view.horizontal()) {
            (Some(vertical), Some(horizontal)) if fits_a_table(vertical, horizontal) => {
                table(surface, &slice, vertical, horizontal)
            }
            (Some(vertical), Some(horizontal)) => heat_map(surface, &slice, vertical, horizontal),
            (None, Some(axis)) if axis.values.len() > MOST_BARS => curve(surface, &slice, axis),
            (None, Some(axis)) => bars(surface, &slice, Some(axis)),
            _ => bars(surface, &slice, None),
        };
    }
    if slices > MOST_SLICES {
        let more = counted((slices - MOST_SLICES) as u128, "more slice", "more slices");
        let drawn = if slices <= MOST_PANELS { "them all".to_owned() } else { format!("the first {MOST_PANELS}") };
        text += &format!("... and {more} in the file; `stickslip plot` draws {drawn}\n");
    }
    text
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
        text += &format!("{} |", label(vertical.values[up]));
        for &right in &columns {
            let shade = known_probability(&surface.row(slice.cell(up, right))).map_or('?', shade);
            has_unknown |= shade == '?';
            text.extend(std::iter::repeat_n(shade, width));
        }
        text += "|\n";
    }
    text += &foot(&horizontal.name, horizontal.ends(), columns.len() * width);
    text += "          ' ' below 1 %, · to 20, ░ to 40, ▒ to 60, ▓ to 80, █ 80 % and more\n";
    if has_unknown {
        text += UNKNOWN;
    }
    text + "\n"
}

fn fits_a_table(vertical: &ViewAxis, horizontal: &ViewAxis) -> bool {
    vertical.values.len() <= MOST_BARS && horizontal.values.len() <= MOST_TABLE_COLUMNS
}

/// The probabilities in numbers.
fn table(surface: &Surface<'_>, slice: &Slice<'_>, vertical: &ViewAxis, horizontal: &ViewAxis) -> String {
    let mut text = format!(" {}\n", vertical.name);
    let mut has_unknown = false;
    for (up, &value) in vertical.values.iter().enumerate().rev() {
        let mut line = format!("{} |", label(value));
        for right in 0..horizontal.values.len() {
            let row = surface.row(slice.cell(up, right));
            let mark = if known_probability(&row).is_some() { ' ' } else { '?' };
            has_unknown |= mark == '?';
            line += &format!("{:>8}{mark}", row.estimate.probability.map_or(String::new(), label));
        }
        text += &format!("{}\n", line.trim_end());
    }
    let width = 9 * horizontal.values.len();
    let values: String = horizontal.values.iter().map(|&value| format!("{:>8} ", label(value))).collect();
    text += &format!("{:9}+{}+\n{:10}{values}  {}\n", "", "-".repeat(width), "", horizontal.name);
    if has_unknown {
        text += UNKNOWN;
    }
    text + "\n"
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
    SHADES.iter().find(|(from, _)| probability >= *from).map_or(' ', |(_, shade)| *shade)
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
                    format!("  {:.0} % of the samples undecided or failed", 100.0 * row.unknown_share())
                } else {
                    String::new()
                };
                format!("{bar}| {probability:>width$}  ({low:>width$} to {high:>width$}){unknown}")
            }
            _ => "no sample was decided".to_owned(),
        };
        text += &format!("{} |{line}\n", axis.map_or_else(|| " ".repeat(8), |axis| label(axis.values[index])));
    }
    text.push('\n');
    text
}

/// A probability with four decimals, or with two digits and an exponent where those would show little of it.
fn probability(value: f64) -> String {
    if value == 0.0 || value >= 1e-3 { format!("{value:.4}") } else { format!("{value:.1e}") }
}

/// The probability along an axis, with its interval.
fn curve(surface: &Surface<'_>, slice: &Slice<'_>, axis: &ViewAxis) -> String {
    let columns = thinned(axis.values.len(), MOST_COLUMNS);
    let width = if columns.len() <= MOST_COLUMNS / 2 { 2 } else { 1 };
    let rows: Vec<SurfaceRow> = columns.iter().map(|&column| surface.row(slice.cell(0, column))).collect();
    let largest = rows.iter().filter_map(|row| known_probability(row).map(|_| row.estimate.high)).fold(0.0, f64::max);
    let top = TOPS.into_iter().rev().find(|top| *top >= largest).unwrap_or(1.0);
    let height_of = |p: f64| (p / top * (CURVE_ROWS - 1) as f64).round() as usize;
    let mut has_unknown = false;
    let mut area = vec![String::new(); CURVE_ROWS];
    for row in &rows {
        let known = known_probability(row);
        has_unknown |= known.is_none();
        for (height, line) in area.iter_mut().enumerate() {
            let symbol = match known {
                None if height == 0 => '?',
                None => ' ',
                Some(p) if height_of(p) == height => '●',
                Some(_) if (height_of(row.estimate.low)..=height_of(row.estimate.high.min(top))).contains(&height) => {
                    '░'
                }
                Some(_) => ' ',
            };
            line.extend(std::iter::repeat_n(symbol, width));
        }
    }
    let mut text = String::new();
    for (height, line) in area.iter().enumerate().rev() {
        let at = top * height as f64 / (CURVE_ROWS - 1) as f64;
        // Every second row is labelled.
        let value = if height % 2 == 0 { label(at) } else { " ".repeat(8) };
        text += &format!("{value} |{line}|\n");
    }
    text += &foot(&axis.name, axis.ends(), columns.len() * width);
    text += &format!(
        "          ● probability, ░ its interval with a confidence of {}\n",
        surface.job().sampling.confidence
    );
    if has_unknown {
        text += UNKNOWN;
    }
    text + "\n"
}

/// A number with at most three decimals, without trailing zeros.
fn short(value: f64) -> String {
    let text = format!("{value:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Size of the plot area of [`curves`].
const PLOT_ROWS: usize = 20;
const PLOT_COLUMNS: usize = 72;

/// Curves over a common abscissa, the n-th drawn with the digit n, with a line at zero.
pub fn curves(lines: &[Vec<(f64, f64)>]) -> String {
    let points = || lines.iter().flatten().copied();
    let range = |values: &mut dyn Iterator<Item = f64>| {
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
    };
    let (left, right) = range(&mut points().map(|point| point.0));
    let (bottom, top) = range(&mut points().map(|point| point.1));
    let row_of = |y: f64| ((top - y) / (top - bottom) * (PLOT_ROWS - 1) as f64).round() as usize;
    let column_of = |x: f64| ((x - left) / (right - left) * (PLOT_COLUMNS - 1) as f64).round() as usize;
    let mut area = vec![[' '; PLOT_COLUMNS]; PLOT_ROWS];
    if bottom < 0.0 && top > 0.0 {
        area[row_of(0.0)] = ['-'; PLOT_COLUMNS];
    }
    for (line, symbol) in lines.iter().zip("123456789".chars()) {
        for &(x, y) in line {
            area[row_of(y)][column_of(x)] = symbol;
        }
    }
    let mut text = String::new();
    for (row, cells) in area.iter().enumerate() {
        let label = top - (top - bottom) * row as f64 / (PLOT_ROWS - 1) as f64;
        text += &format!("{label:>9.5} |{}\n", cells.iter().collect::<String>().trim_end());
    }
    let (left, right) = (short(left), short(right));
    let gap = PLOT_COLUMNS.saturating_sub(left.len() + right.len());
    text += &format!("{:10}+{}\n{:11}{left}{:gap$}{right}\n\n", "", "-".repeat(PLOT_COLUMNS), "", "");
    text
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
}
