//! Charts at the terminal, 79 columns wide: curves in braille dots, two by four of them in a character.
//!
//! Colours distinguish curves; where there are none, a symbol on each curve does. The text has escape codes for the
//! colours and characters beyond ASCII; `output` takes out what its reader cannot show.

use anstyle::{AnsiColor, Style};

use crate::output::wrapped;
use crate::picture::chart::{Chart, Form, Share, listed};

/// Size of the area in characters.
const COLUMNS: usize = 68;
const ROWS: usize = 18;

/// Dots of a character.
const ACROSS: usize = 2;
const DOWN: usize = 4;

/// Width of the labels at the left.
const LABEL: usize = 8;

/// Width of a line.
const WIDTH: usize = 79;

/// Most ticks of the axes.
const TICKS_ACROSS: usize = 7;
const TICKS_UP: usize = 6;

/// Distance of the symbols on a curve, in characters.
const BETWEEN_SYMBOLS: usize = 15;

const COLOURS: [AnsiColor; 6] =
    [AnsiColor::Cyan, AnsiColor::Red, AnsiColor::Green, AnsiColor::Magenta, AnsiColor::Yellow, AnsiColor::Blue];

const BRAILLE: u32 = 0x2800;

/// What a character of the area shows.
#[derive(Debug, Clone, Copy, Default)]
struct Character {
    /// Dots as braille counts them.
    dots: u8,
    /// Drawn in place of the dots.
    symbol: Option<char>,
    /// The series that it belongs to.
    series: Option<usize>,
}

/// The area while it is drawn, row by row from the top.
struct Area {
    characters: Vec<Character>,
}

/// Where a share of the area lies, in dots from the left and from the top.
fn dot((right, up): Share) -> (usize, usize) {
    let place = |share: f64, dots: usize| (share.clamp(0.0, 1.0) * (dots - 1) as f64).round() as usize;
    (place(right, ACROSS * COLUMNS), DOWN * ROWS - 1 - place(up, DOWN * ROWS))
}

/// The bit of a dot in its character.
fn bit(x: usize, y: usize) -> u8 {
    const BITS: [[u8; ACROSS]; DOWN] = [[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]];
    BITS[y % DOWN][x % ACROSS]
}

impl Area {
    fn at(&mut self, x: usize, y: usize) -> &mut Character {
        &mut self.characters[y / DOWN * COLUMNS + x / ACROSS]
    }

    fn set(&mut self, (x, y): (usize, usize), series: usize) {
        let character = self.at(x, y);
        character.dots |= bit(x, y);
        character.series = Some(series);
    }

    /// A straight line, its first dot left out: it is the last one of the line before.
    fn line(&mut self, from: (usize, usize), to: (usize, usize), series: usize) {
        let steps = from.0.abs_diff(to.0).max(from.1.abs_diff(to.1));
        for step in 1..=steps {
            let between = |from: usize, to: usize| {
                let share = step as f64 / steps as f64;
                (from as f64 + share * (to as f64 - from as f64)).round() as usize
            };
            self.set((between(from.0, to.0), between(from.1, to.1)), series);
        }
    }

    /// Every fourth dot between two heights, so that a curve stands out from its band.
    fn shade(&mut self, x: usize, from: usize, to: usize, series: usize) {
        for y in from.min(to)..=from.max(to) {
            if x.is_multiple_of(2) && (x / 2 + y).is_multiple_of(2) {
                self.set((x, y), series);
            }
        }
    }
}

/// A chart as lines of text.
pub fn drawn(chart: &Chart) -> String {
    let mut area = Area { characters: vec![Character::default(); COLUMNS * ROWS] };
    let has_symbols = chart.series.len() > 1;
    for (number, series) in chart.series.iter().enumerate() {
        for piece in chart.bands(series) {
            for pair in piece.windows(2) {
                let [left, right] = [pair[0], pair[1]].map(|end| dot((end.0, 0.0)).0);
                for x in left..=right {
                    let share = (x - left) as f64 / (right - left).max(1) as f64;
                    let height = |from: f64, to: f64| dot((0.0, from + share * (to - from))).1;
                    area.shade(x, height(pair[0].1, pair[1].1), height(pair[0].2, pair[1].2), number);
                }
            }
        }
    }
    for (number, series) in chart.series.iter().enumerate() {
        let lines = match series.form {
            Form::Line => chart.lines(series),
            Form::Points => chart.points(series).into_iter().map(|point| vec![point]).collect(),
        };
        for line in lines {
            let dots: Vec<(usize, usize)> = line.into_iter().map(dot).collect();
            if let Some(&first) = dots.first() {
                area.set(first, number);
            }
            dots.windows(2).for_each(|pair| area.line(pair[0], pair[1], number));
        }
    }
    if has_symbols {
        (0..chart.series.len()).for_each(|number| symbols(&mut area, chart, number));
    }
    rulers(&mut area, chart);
    let mut text = wrapped(&chart.title);
    text += &framed(&area, chart);
    text += &legend(chart);
    text + "\n"
}

/// Puts the symbol of a series on its dots here and there, at other columns than those of the others.
fn symbols(area: &mut Area, chart: &Chart, number: usize) {
    let offset = (number + 1) * BETWEEN_SYMBOLS / (chart.series.len() + 1);
    for column in (offset..COLUMNS).step_by(BETWEEN_SYMBOLS) {
        let mut previous = false;
        for row in 0..ROWS {
            let character = &mut area.characters[row * COLUMNS + column];
            let is_own = character.series == Some(number) && character.dots != 0;
            // One symbol where a curve goes straight up.
            if is_own && !previous && character.symbol.is_none() {
                character.symbol = Some(chart.series[number].symbol);
            }
            previous = is_own;
        }
    }
    // A steep curve may pass between all of these columns.
    let is_named = area.characters.iter().any(|c| c.series == Some(number) && c.symbol.is_some());
    let own = |c: &&mut Character| c.series == Some(number) && c.dots != 0 && c.symbol.is_none();
    let count = area.characters.iter_mut().filter(own).count();
    if let (false, Some(middle)) = (is_named, area.characters.iter_mut().filter(own).nth(count / 2)) {
        middle.symbol = Some(chart.series[number].symbol);
    }
}

/// The line at zero and those of marked values, where nothing else is drawn.
fn rulers(area: &mut Area, chart: &Chart) {
    let mut put = |row: usize, column: usize, symbol: char| {
        let character = &mut area.characters[row * COLUMNS + column];
        if character.dots == 0 && character.symbol.is_none() {
            character.symbol = Some(symbol);
        }
    };
    for (_, at) in chart.marked() {
        (0..ROWS).for_each(|row| put(row, dot((at, 0.0)).0 / ACROSS, '┊'));
    }
    if let Some(zero) = chart.zero() {
        (0..COLUMNS).for_each(|column| put(dot((0.0, zero)).1 / DOWN, column, '╌'));
    }
}

/// A series' colour; grey for what belongs to none.
fn style(series: Option<usize>) -> Style {
    let colour = series.map_or(AnsiColor::BrightBlack, |number| COLOURS[number % COLOURS.len()]);
    Style::new().fg_color(Some(colour.into()))
}

/// The area with its axes.
fn framed(area: &Area, chart: &Chart) -> String {
    let (up, power) = chart.vertical.scale.ticks(TICKS_UP);
    let mut labels = vec![None; ROWS];
    for tick in &up {
        labels[dot((0.0, chart.vertical.scale.at(tick.value))).1 / DOWN] = Some(tick.label.as_str());
    }
    let mut text = format!(" {}\n", chart.vertical.heading(power));
    for (row, characters) in area.characters.chunks(COLUMNS).enumerate() {
        let (label, frame) = labels[row].map_or(("", '│'), |label| (label, '┤'));
        text += format!("{label:>LABEL$} {frame}{}", coloured(characters)).trim_end();
        text.push('\n');
    }
    let (across, power) = chart.horizontal.scale.ticks(TICKS_ACROSS);
    let mut line = vec!['─'; COLUMNS];
    let mut below = vec![' '; WIDTH - 1];
    let mut free_from = 0;
    for tick in &across {
        let column = dot((chart.horizontal.scale.at(tick.value), 0.0)).0 / ACROSS;
        let length = tick.label.chars().count();
        let from = (LABEL + 2 + column).saturating_sub(length / 2).min(below.len() - length);
        if from >= free_from {
            line[column] = '┬';
            below.splice(from..from + length, tick.label.chars());
            free_from = from + length + 2;
        }
    }
    let below: String = below.into_iter().collect();
    let heading = chart.horizontal.heading(power);
    let space = LABEL + 2 + COLUMNS.saturating_sub(heading.chars().count()) / 2;
    text + &format!(
        "{:LABEL$} └{}\n{}\n{:space$}{heading}\n",
        "",
        line.into_iter().collect::<String>(),
        below.trim_end(),
        ""
    )
}

/// A row of the area, with the codes of its colours.
fn coloured(characters: &[Character]) -> String {
    let end = characters.iter().rposition(|character| character.dots != 0 || character.symbol.is_some());
    let characters = &characters[..end.map_or(0, |end| end + 1)];
    let is_blank = |character: &Character| character.dots == 0 && character.symbol.is_none();
    let mut text = String::new();
    for run in characters.chunk_by(|a, b| a.series == b.series && is_blank(a) == is_blank(b)) {
        let letters: String = run
            .iter()
            .map(|character| match character {
                Character { symbol: Some(symbol), .. } => *symbol,
                Character { dots: 0, .. } => ' ',
                Character { dots, .. } => char::from_u32(BRAILLE + u32::from(*dots)).unwrap_or('*'),
            })
            .collect();
        if is_blank(&run[0]) {
            text += &letters;
        } else {
            let style = style(run[0].series);
            text += &format!("{style}{letters}{style:#}");
        }
    }
    text
}

/// What the symbols mean, in lines that fit.
fn legend(chart: &Chart) -> String {
    let mut text = String::new();
    let mut width = 0;
    let named = chart.series.iter().enumerate().filter(|(_, series)| !series.name.is_empty());
    for (number, series) in named {
        let length = series.name.chars().count() + 2;
        if width > 0 && width + 3 + length > WIDTH {
            text.push('\n');
            width = 0;
        }
        text += "   ";
        width += 3 + length;
        let style = style(Some(number));
        text += &format!("{style}{}{style:#} {}", series.symbol, series.name);
    }
    if width > 0 {
        text.push('\n');
    }
    if let Some(marks) = &chart.marks {
        let style = style(None);
        text += &format!("   {style}┊{style:#} {}: {}\n", marks.what, listed(&marks.values));
    }
    if !chart.note.is_empty() {
        text += &format!("   {}\n", chart.note);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::without_colours;
    use crate::picture::chart::{ChartAxis, Marks, Series};
    use crate::picture::scale::Scale;

    fn chart(series: Vec<Series>) -> Chart {
        let axis = |name, unit| ChartAxis::new(name, unit, Scale::linear(-1.0, 1.0));
        Chart::new("Title", axis("Time t", "ms"), axis("x", "mm"), series)
    }

    #[test]
    fn every_line_fits_the_terminal_and_has_its_axes() {
        let names = ["a long name of a first curve", "another long name of a curve", "and a third one of them"];
        let series = names.iter().enumerate().map(|(i, name)| {
            let slope = 0.3 * (i as f64 + 1.0);
            Series::numbered(i, (*name).to_owned(), vec![(-1.0, -slope), (1.0, slope)])
        });
        let mut chart = chart(series.collect());
        chart.has_zero_line = true;
        chart.marks = Some(Marks { what: "printed".to_owned(), values: vec![0.5] });
        let text = without_colours(&drawn(&chart));
        for line in text.lines() {
            assert!(line.chars().count() <= WIDTH, "{line}");
        }
        for part in [" x, mm", "Time t, ms", "0.5 ┤", "-1.0 ┤", "┬", "┊ printed: 0.5", "╌", "1 a long name"] {
            assert!(text.contains(part), "{part}: {text}");
        }
        for symbol in ["1", "2", "3"] {
            let area = text.lines().skip(2).take(ROWS);
            assert!(area.filter(|line| line[LABEL..].contains(symbol)).count() >= 1, "{symbol}: {text}");
        }
    }

    #[test]
    fn dots_are_where_the_points_are() {
        let mut point = Series::line(vec![(-1.0, 1.0), (1.0, -1.0), (5.0, 0.0), (f64::NAN, 0.0)]);
        point.form = Form::Points;
        let text = without_colours(&drawn(&chart(vec![point])));
        let rows: Vec<&str> = text.lines().skip(2).take(ROWS).collect();
        assert!(rows[0].ends_with("┤\u{2801}"), "{text}");
        assert!(rows[ROWS - 1].ends_with('\u{2880}'), "{text}");
        let drawn = text.chars().filter(|c| ('\u{2801}'..='\u{28ff}').contains(c)).count();
        assert_eq!(drawn, 2, "what lies outside is left out: {text}");
    }

    #[test]
    fn a_straight_line_has_no_gaps() {
        let text = without_colours(&drawn(&chart(vec![Series::line(vec![(-1.0, 0.5), (1.0, 0.5)])])));
        let row = text.lines().find(|line| line.contains('⠤') || line.contains('⠒') || line.contains('⠉'));
        let row = row.unwrap_or_else(|| panic!("{text}"));
        assert_eq!(row.chars().filter(|c| ('\u{2801}'..='\u{28ff}').contains(c)).count(), COLUMNS, "{text}");
    }

    #[test]
    fn curves_have_colours_of_their_own() {
        let line = |number| Series::numbered(number, "c".to_owned(), vec![(-1.0, 0.1 * number as f64), (1.0, 0.9)]);
        let text = drawn(&chart(vec![line(0), line(5)]));
        assert!(text.contains("\u{1b}[36m") && text.contains("\u{1b}[31m"), "{text:?}");
        assert!(!without_colours(&text).contains('\u{1b}'));
    }

    #[test]
    fn a_band_is_lighter_than_its_curve() {
        let mut series = Series::line(vec![(-1.0, 0.0), (1.0, 0.0)]);
        series.band = vec![(-0.5, 0.5); 2];
        let with = drawn(&chart(vec![series.clone()]));
        series.band.clear();
        let without = drawn(&chart(vec![series]));
        let dots = |text: &str| -> u32 {
            let braille = text.chars().filter(|c| ('\u{2801}'..='\u{28ff}').contains(c));
            braille.map(|c| (c as u32 & 0xff).count_ones()).sum()
        };
        let (band, curve) = (dots(&with) - dots(&without), dots(&without));
        assert_eq!(curve as usize, ACROSS * COLUMNS);
        assert!(band > 4 * curve && band < 12 * curve, "{band} {curve}");
    }

    #[test]
    fn a_constant_curve_has_an_axis_with_different_labels() {
        let mut chart = chart(vec![Series::line(vec![(-1.0, 0.008), (1.0, 0.008)])]);
        chart.vertical.scale = Scale::around([0.008, 0.008 + 1e-12].into_iter());
        let text = without_colours(&drawn(&chart));
        let labels: Vec<&str> = text.lines().filter_map(|line| line.split_once('┤').map(|pair| pair.0)).collect();
        assert!(labels.len() >= 3 && labels.windows(2).all(|pair| pair[0] != pair[1]), "{text}");
    }
}
