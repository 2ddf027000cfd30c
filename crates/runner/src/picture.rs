//! Pictures of surfaces and curves for the terminal.

use crate::job::RandomInput;
use crate::output::counted;
use crate::tables::row::SurfaceRow;
use crate::tables::surface::Surface;

/// Largest number of rows and columns of a picture; larger grids are thinned out.
const MOST_ROWS: usize = 15;
const MOST_COLUMNS: usize = 60;

/// Largest number of slices (combinations of speed and standard deviation) that are shown.
const MOST_SLICES: usize = 4;

/// Length of the bar for a probability of 1.
const BAR: usize = 40;

/// Shades, each with the smallest probability that it is drawn for.
const SHADES: [(f64, char); 6] = [(0.8, '█'), (0.6, '▓'), (0.4, '▒'), (0.2, '░'), (0.01, '·'), (0.0, ' ')];

/// Largest share of samples without a verdict with which a probability is drawn.
const MOST_UNKNOWN: f64 = 0.1;

/// The probability of instability over preload and static friction, one slice for each speed and standard deviation. If
/// only one of the two varies, the picture shows bars.
pub fn picture(surface: &Surface<'_>) -> String {
    let grid = &surface.job().grid;
    let [preloads, frictions] = [&grid.preload, &grid.static_friction].map(|axis| axis.values().len());
    let slices = surface.job().cells() as usize / (preloads * frictions);
    let mut text = String::new();
    for slice in 0..slices.min(MOST_SLICES) {
        let first = (slice * preloads * frictions) as u64;
        text += &slice_title(surface, first);
        if preloads > 1 && frictions > 1 {
            text += &heat_map(surface, first, preloads, frictions);
        } else {
            text += &bars(surface, first, preloads, frictions);
        }
    }
    if slices > MOST_SLICES {
        text +=
            &format!("... and {} in the file\n", counted((slices - MOST_SLICES) as u128, "more slice", "more slices"));
    }
    text
}

fn slice_title(surface: &Surface<'_>, first: u64) -> String {
    let cell = surface.row(first).cell;
    let mut scatter = Vec::new();
    // The standard deviation of measured values has many digits.
    let rounded = |std: f64| (std * 1e6).round() / 1e6;
    for (name, std) in [("preload", cell.relative_std.preload), ("friction", cell.relative_std.static_friction)] {
        if std > 0.0 {
            scatter.push(format!("{name} {}", rounded(std)));
        }
    }
    let job = surface.job();
    let stds = &job.random.relative_stds[job.grid.relative_std_index(first)];
    for (input, &std) in job.random.inputs.iter().zip(stds) {
        if matches!(input, RandomInput::Other(_)) && std > 0.0 {
            scatter.push(format!("{} {}", input.name(), rounded(std)));
        }
    }
    let scatter = if scatter.is_empty() { "none".to_owned() } else { scatter.join(", ") };
    format!("Probability of instability at {} rad/s; relative std: {scatter}\n\n", cell.rotating_speed)
}

/// At most `most` evenly spaced indices below `length`, both ends included.
fn thinned(length: usize, most: usize) -> Vec<usize> {
    if length <= most {
        return (0..length).collect();
    }
    (0..most).map(|i| (i * (length - 1) + (most - 1) / 2) / (most - 1)).collect()
}

fn heat_map(surface: &Surface<'_>, first: u64, preloads: usize, frictions: usize) -> String {
    let columns = thinned(frictions, MOST_COLUMNS);
    let width = if columns.len() <= MOST_COLUMNS / 2 { 2 } else { 1 };
    let row_at = |preload: usize, friction: usize| surface.row(first + (preload * frictions + friction) as u64);
    let mut text = " preload\n".to_owned();
    let mut has_unknown = false;
    for preload in thinned(preloads, MOST_ROWS).into_iter().rev() {
        text += &format!("{:>8.4} |", row_at(preload, 0).cell.preload);
        for &friction in &columns {
            let shade = known_probability(&row_at(preload, friction)).map_or('?', shade);
            has_unknown |= shade == '?';
            text.extend(std::iter::repeat_n(shade, width));
        }
        text += "|\n";
    }
    let (from, to) = (row_at(0, 0).cell.static_friction, row_at(0, frictions - 1).cell.static_friction);
    let (from, to) = (format!("{from}"), format!("{to}"));
    let inside = columns.len() * width;
    let gap = inside.saturating_sub(from.len() + to.len()).max(1);
    text += &format!("{:9}+{}+\n{:10}{from}{:gap$}{to}  static friction\n", "", "-".repeat(inside), "", "");
    text += "          ' ' below 1 %, · 1 to 20, ░ 20 to 40, ▒ 40 to 60, ▓ 60 to 80, █ 80 % and more\n";
    if has_unknown {
        text += "          ? more than 10 % of the samples undecided or failed\n";
    }
    text + "\n"
}

/// The probability of a cell, if enough samples have a verdict.
fn known_probability(row: &SurfaceRow) -> Option<f64> {
    row.estimate.probability.filter(|_| row.unknown_share() <= MOST_UNKNOWN)
}

fn shade(probability: f64) -> char {
    SHADES.iter().find(|(from, _)| probability >= *from).map_or(' ', |(_, shade)| *shade)
}

fn bars(surface: &Surface<'_>, first: u64, preloads: usize, frictions: usize) -> String {
    let along_preload = preloads > 1;
    let mut text = format!(" {}\n", if along_preload { "preload" } else { "static friction" });
    for index in thinned(preloads.max(frictions), 2 * MOST_ROWS) {
        let row = surface.row(first + index as u64);
        let value = if along_preload { row.cell.preload } else { row.cell.static_friction };
        let line = match row.estimate.probability {
            None => "no sample was decided".to_owned(),
            Some(p) => {
                let filled = (p * BAR as f64).round() as usize;
                let bar = format!("{}{}", "█".repeat(filled), " ".repeat(BAR - filled));
                let unknown = if row.unknown_share() > MOST_UNKNOWN {
                    format!("  {:.0} % of the samples undecided or failed", 100.0 * row.unknown_share())
                } else {
                    String::new()
                };
                format!("{bar}| {p:.4}  ({:.4} to {:.4}){unknown}", row.estimate.low, row.estimate.high)
            }
        };
        text += &format!("{value:>8.4} |{line}\n");
    }
    text.push('\n');
    text
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
