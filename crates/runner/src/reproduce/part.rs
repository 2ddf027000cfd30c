//! What a target shows, in parts: the terminal, the files of figures and the gallery are made from the same ones.

use std::path::{Path, PathBuf};

use crate::failure::Failure;
use crate::picture::chart::Chart;
use crate::picture::terminal::drawn;
use crate::picture::view::GridView;
use crate::picture::{Drawing, drawings};
use crate::plot;
use crate::plot::canvas::Canvas;
use crate::plot::chart;
use crate::plot::values::Values;
use crate::tables::surface::Surface;

/// A part of what a target shows.
pub enum Part {
    Text(String),
    Table(Table),
    Chart(Box<Chart>),
    /// The surface of a run, shaded for the terminal, and where its file is.
    Surface {
        shaded: String,
        run: PathBuf,
    },
}

/// A table; the first column is text, the others are numbers.
pub struct Table {
    pub title: String,
    pub headings: Vec<String>,
    pub rows: Vec<Vec<String>>,
    /// How many of its columns the terminal shows.
    pub at_terminal: usize,
}

impl Part {
    pub fn text(text: impl Into<String>) -> Self {
        Self::Text(text.into())
    }

    pub fn chart(chart: Chart) -> Self {
        Self::Chart(Box::new(chart))
    }

    /// As the terminal shows it.
    pub fn shown(&self) -> String {
        match self {
            Self::Text(text) | Self::Surface { shaded: text, .. } => text.clone(),
            Self::Table(table) => table.text(),
            Self::Chart(chart) => drawn(chart),
        }
    }
}

/// The drawings of a run's surface as parts.
pub fn of_surface(surface: &Surface<'_>, run: PathBuf) -> Vec<Part> {
    let drawings = drawings(surface);
    if drawings.iter().any(|drawing| matches!(drawing, Drawing::Chart(_))) {
        let part = |drawing| match drawing {
            Drawing::Text(text) => Part::Text(text),
            Drawing::Chart(chart) => Part::Chart(chart),
        };
        return drawings.into_iter().map(part).collect();
    }
    let text = |drawing| if let Drawing::Text(text) = drawing { text } else { String::new() };
    vec![Part::Surface { shaded: drawings.into_iter().map(text).collect(), run }]
}

/// The charts of a target as one figure, or its surface, this wide in pixels.
pub fn figure(parts: &[Part], width: f64) -> Result<Option<Canvas>, Failure> {
    let charts = parts.iter().filter_map(|part| if let Part::Chart(chart) = part { Some(&**chart) } else { None });
    let charts: Vec<&Chart> = charts.collect();
    if !charts.is_empty() {
        return Ok(Some(chart::figure(&charts, width)));
    }
    let surfaces = parts.iter().find_map(|part| if let Part::Surface { run, .. } = part { Some(run) } else { None });
    surfaces.map_or(Ok(None), |run| plot_of(run, width))
}

/// The surface of a run, this wide in pixels; none of a single cell.
pub fn plot_of(run: &Path, width: f64) -> Result<Option<Canvas>, Failure> {
    let values = Values::read(run)?;
    Ok(plot::surface::figure(&values, &GridView::new(&values.job), width))
}

impl Table {
    pub fn new<const N: usize>(title: &str, headings: [&str; N], rows: Vec<[String; N]>) -> Self {
        Self {
            title: title.to_owned(),
            headings: headings.map(str::to_owned).to_vec(),
            rows: rows.into_iter().map(|row| row.to_vec()).collect(),
            at_terminal: N,
        }
    }

    fn text(&self) -> String {
        let width = |column: usize| {
            let cells = self.rows.iter().chain([&self.headings]).map(|row| row[column].chars().count());
            cells.max().unwrap_or(0)
        };
        let widths: Vec<usize> = (0..self.at_terminal).map(width).collect();
        let mut text = if self.title.is_empty() { String::new() } else { format!("{}\n\n", self.title) };
        for row in [&self.headings].into_iter().chain(&self.rows) {
            let mut line = String::new();
            for (column, (cell, width)) in row.iter().zip(&widths).enumerate() {
                line += &if column == 0 { format!("  {cell:<width$}") } else { format!("  {cell:>width$}") };
            }
            text += &format!("{}\n", line.trim_end());
        }
        text
    }
}
