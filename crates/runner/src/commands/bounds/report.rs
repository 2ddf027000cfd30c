//! Bounds as text, JSON and columns.

use serde_json::{Value, json};
use stickslip_core::model::quantity::Quantity;
use stickslip_sampler::draw::identity::RESULTS_VERSION;
use stickslip_sampler::imprecise::result::{Direction, Evidence, Trend};

use crate::files::table::{TableColumn, TableValues};
use crate::job::{ImpreciseJob, ImpreciseQuantity, JobSource, Values, What};
use crate::output::{aligned, counted, wrapped};
use crate::picture::view::rounded;
use crate::tables::cell_columns::{CellColumn, always_shown};
use crate::version::VERSION;

/// Largest number of cells at the terminal.
const MOST_CELLS: usize = 100;

/// The lower and the upper end, as columns name them.
const ENDS: [&str; 2] = ["lower", "upper"];

/// An end of the probability, and where it is reached.
#[derive(Debug, Clone)]
pub struct Reached {
    /// The probability.
    pub probability: f64,
    /// A bound on its numerical error.
    pub error_bound: f64,
    /// Proved: no probability is beyond it.
    pub bound: Option<f64>,
    /// How far it is certain.
    pub evidence: Evidence,
    /// The places of the alternatives.
    pub choice: Vec<usize>,
    /// The values of intervals.
    pub values: Vec<Option<f64>>,
}

/// The bounds of a cell.
#[derive(Debug, Clone)]
pub struct Row {
    /// The cell.
    pub cell: u64,
    /// The lower and the upper end.
    pub ends: [Reached; 2],
    /// What the probability does along each interval.
    pub trends: Vec<Option<Trend>>,
    /// Probabilities that were integrated.
    pub evaluations: u64,
}

impl Row {
    /// Together with the bounds of other alternatives.
    pub fn with(mut self, other: Self) -> Self {
        for (which, (own, other)) in self.ends.iter_mut().zip(other.ends).enumerate() {
            let sign = [1.0, -1.0][which];
            let evidence = own.evidence.max(other.evidence);
            let bound = own.bound.zip(other.bound).map(|(a, b)| if sign * a <= sign * b { a } else { b });
            if sign * other.probability < sign * own.probability {
                *own = other;
            }
            (own.evidence, own.bound) = (evidence, bound);
        }
        for (own, other) in self.trends.iter_mut().zip(other.trends) {
            *own = own.zip(other).map(|(own, other)| together(own, other));
        }
        self.evaluations += other.evaluations;
        self
    }
}

/// What is so with either of two alternatives.
fn together(a: Trend, b: Trend) -> Trend {
    let is_proved = a.is_proved && b.is_proved;
    let direction = if a.direction == b.direction { a.direction } else { Direction::Turns };
    Trend { direction, is_proved }
}

fn evidence_word(evidence: Evidence) -> &'static str {
    match evidence {
        Evidence::Proved => "proved",
        Evidence::Checked => "checked",
        Evidence::Searched => "searched",
    }
}

fn trend_word(trend: Trend) -> &'static str {
    match (trend.direction, trend.is_proved) {
        (Direction::Rises, true) => "rises (proved)",
        (Direction::Rises, false) => "rises (checked)",
        (Direction::Falls, true) => "falls (proved)",
        (Direction::Falls, false) => "falls (checked)",
        (Direction::Turns, _) => "turns",
        (Direction::Constant, _) => "constant",
    }
}

/// Everything that was found.
pub struct Found<'a> {
    pub source: &'a JobSource,
    pub job: &'a ImpreciseJob,
    pub rows: Vec<Row>,
}

/// What cells may differ in, and is not imprecise.
struct Known {
    column: CellColumn,
    /// Its value in each cell.
    values: Vec<f64>,
    /// Whether it differs between cells.
    varies: bool,
}

impl Found<'_> {
    /// A table for the terminal.
    pub fn text(&self) -> String {
        let Self { job, rows, .. } = self;
        let quantities: Vec<String> = job.quantities.iter().map(ImpreciseQuantity::text).collect();
        let known = self.known();
        let fixed: Vec<String> = known
            .iter()
            .filter(|known| !known.varies && known.values[0] != 0.0)
            .map(|known| format!("{} {}", known.column.name, rounded(known.values[0])))
            .collect();
        let fixed = if fixed.is_empty() { String::new() } else { format!("; {}", fixed.join(", ")) };
        let title = format!("Bounds of the probability of instability over {}{fixed}", quantities.join(", "));
        let varying: Vec<&Known> = known.iter().filter(|known| known.varies).collect();
        let mut lines = vec![varying.iter().map(|known| known.column.name.to_string()).collect::<Vec<String>>()];
        lines[0].extend(["bound", "P"].map(str::to_owned));
        lines[0].extend(job.quantities.iter().map(|quantity| column_name(job, quantity)));
        lines[0].push("evidence".to_owned());
        for row in rows.iter().take(MOST_CELLS) {
            for (which, end) in row.ends.iter().enumerate() {
                let axis =
                    |known: &&Known| if which == 0 { rounded(known.values[row.cell as usize]) } else { String::new() };
                let mut line: Vec<String> = varying.iter().map(axis).collect();
                line.extend([ENDS[which].to_owned(), probability(end.probability)]);
                line.extend((0..job.quantities.len()).map(|place| self.reached_text(end, place)));
                line.push(evidence_word(end.evidence).to_owned());
                lines.push(line);
            }
        }
        let mut text = wrapped(&title) + "\n" + &aligned(&lines);
        if rows.len() > MOST_CELLS {
            text += &format!("... and {} more cells; --out FILE.parquet writes them all\n", rows.len() - MOST_CELLS);
        }
        text + "\n" + &wrapped(&self.legend())
    }

    fn legend(&self) -> String {
        let has = |evidence: Evidence| self.rows.iter().flat_map(|row| &row.ends).any(|end| end.evidence == evidence);
        let words = [
            (
                Evidence::Proved,
                "proved: bounds of the derivatives leave no value beyond it by more than 1e-6 (small ones 1e-4 of themselves, at least 1e-7)",
            ),
            (
                Evidence::Checked,
                "checked: P is monotonic in every quantity wherever it was computed, and this is the end",
            ),
            (
                Evidence::Searched,
                "searched: found by interpolation that was refined until it agreed with P; not proved",
            ),
        ];
        let mut lines: Vec<String> =
            words.into_iter().filter(|(evidence, _)| has(*evidence)).map(|(_, line)| line.to_owned()).collect();
        lines.extend(self.trends());
        let evaluations: u64 = self.rows.iter().map(|row| row.evaluations).sum();
        lines.push(format!("P was integrated {}.", counted(evaluations.into(), "time", "times")));
        lines.join("\n")
    }

    /// What the probability does along each interval, in any of the cells.
    fn trends(&self) -> Vec<String> {
        let mut lines = Vec::new();
        for (place, quantity) in self.job.quantities.iter().enumerate() {
            let mut counts: Vec<(&str, u64)> = Vec::new();
            for word in self.rows.iter().filter_map(|row| row.trends[place].map(trend_word)) {
                match counts.iter_mut().find(|(of, _)| *of == word) {
                    Some((_, count)) => *count += 1,
                    None => counts.push((word, 1)),
                }
            }
            let said = match &counts[..] {
                [] => continue,
                [(word, _)] => (*word).to_owned(),
                several => {
                    let said = |(word, count): &(&str, u64)| {
                        format!("{word} in {}", counted((*count).into(), "cell", "cells"))
                    };
                    several.iter().map(said).collect::<Vec<_>>().join(", ")
                }
            };
            lines.push(format!("Along {} P {said}.", column_name(self.job, quantity)));
        }
        lines
    }

    /// Where an end is reached, for one quantity.
    fn reached_text(&self, end: &Reached, place: usize) -> String {
        match &self.job.quantities[place].values {
            Values::OneOf(values) => values[end.choice[place]].replace('"', ""),
            Values::Between(_) => end.values[place].map_or_else(|| "-".to_owned(), rounded),
        }
    }

    /// Everything by name; a cell has the names of the columns of the table.
    pub fn json(&self) -> Value {
        let columns = self.table();
        let row = |i: usize| {
            let entries = columns.iter().map(|column| (column.name.to_string(), column.value(i)));
            Value::Object(entries.collect())
        };
        json!({
            "name": self.job.first().name,
            "imprecise": imprecise_json(self.job),
            "cells": (0..self.rows.len()).map(row).collect::<Vec<Value>>(),
        })
    }

    /// One row for each cell.
    pub fn table(&self) -> Vec<TableColumn> {
        let Self { job, rows, .. } = self;
        let column = |name: String, unit: &str, long_name: String, values| TableColumn {
            name: name.into(),
            unit: unit.to_owned().into(),
            long_name: long_name.into(),
            values,
        };
        let real = |name: String, unit: &str, long_name: String, value: &dyn Fn(&Row) -> Option<f64>| {
            column(name, unit, long_name, TableValues::Real(rows.iter().map(value).collect()))
        };
        let cells = TableValues::Integer(rows.iter().map(|row| row.cell).collect());
        let mut columns = vec![column("cell".to_owned(), "1", "0-based index of the cell".to_owned(), cells)];
        for known in self.known() {
            let CellColumn { name, unit, long_name, .. } = known.column;
            columns.push(real(name.into_owned(), &unit, long_name, &|row| Some(known.values[row.cell as usize])));
        }
        for (which, (end, beyond)) in ENDS.into_iter().zip(["below", "above"]).enumerate() {
            let meaning =
                format!("{} probability of instability over the imprecise inputs", ["lowest", "highest"][which]);
            columns.push(real(format!("p_{end}"), "1", meaning, &|row| Some(row.ends[which].probability)));
            let meaning = format!("bound on the numerical error of p_{end}");
            columns.push(real(format!("p_{end}_error"), "1", meaning, &|row| Some(row.ends[which].error_bound)));
            let meaning = format!("proved: no probability is {beyond} it");
            columns.push(real(format!("p_{end}_bound"), "1", meaning, &|row| row.ends[which].bound));
            let words = rows.iter().map(|row| Some(evidence_word(row.ends[which].evidence))).collect();
            let meaning = format!("how far p_{end} is certain: proved, checked or searched");
            columns.push(column(format!("p_{end}_evidence"), "1", meaning, TableValues::Word(words)));
        }
        for (place, quantity) in job.quantities.iter().enumerate() {
            let (name, unit) = (column_name(job, quantity), unit_of(job, quantity));
            for (which, end) in ENDS.into_iter().enumerate() {
                let meaning = format!("{} with which p_{end} is reached", quantity.name());
                columns.push(column(format!("{name}_at_{end}"), &unit, meaning, self.reached(place, which)));
            }
            if let Values::Between(_) = quantity.values {
                let words = rows.iter().map(|row| row.trends[place].map(trend_word)).collect();
                let meaning = format!("what the probability does as the {} grows", quantity.name());
                columns.push(column(format!("{name}_trend"), "1", meaning, TableValues::Word(words)));
            }
        }
        let evaluations = TableValues::Integer(rows.iter().map(|row| row.evaluations).collect());
        columns.push(column(
            "evaluations".to_owned(),
            "1",
            "probabilities that were integrated".to_owned(),
            evaluations,
        ));
        columns
    }

    /// Where an end is reached: numbers, or the words of alternatives that are none.
    fn reached(&self, place: usize, which: usize) -> TableValues {
        let texts: Vec<String> = self.rows.iter().map(|row| self.reached_text(&row.ends[which], place)).collect();
        match &self.job.quantities[place].values {
            Values::Between(_) => {
                TableValues::Real(self.rows.iter().map(|row| row.ends[which].values[place]).collect())
            }
            Values::OneOf(_) => {
                let numbers: Option<Vec<f64>> = texts.iter().map(|text| text.replace('_', "").parse().ok()).collect();
                match numbers {
                    Some(numbers) => TableValues::Real(numbers.into_iter().map(Some).collect()),
                    None => TableValues::Text(texts),
                }
            }
        }
    }

    /// What the file says beside its columns.
    pub fn footer(&self) -> Vec<(&'static str, String)> {
        vec![
            ("stickslip:job", self.source.text.clone()),
            ("stickslip:imprecise", imprecise_json(self.job).to_string()),
            ("stickslip:engine_version", VERSION.to_owned()),
            ("stickslip:results_version", RESULTS_VERSION.to_string()),
        ]
    }

    /// Axes and standard deviations that are not imprecise, as the surface names their columns.
    fn known(&self) -> Vec<Known> {
        let job = self.job.first();
        let expected = |place: usize| CellColumn::expected(place, job.quantity(place));
        let others = job.grid.axes.iter().filter(|axis| !job.quantity(axis.quantity).is_always_shown);
        let others = others.map(|axis| expected(axis.quantity));
        let pair = job.model().pair().into_iter().flatten();
        let stds = pair.filter(|&place| job.random.position(place).is_some());
        let stds = stds.map(|place| CellColumn::std_of_input(job, place));
        let all = others.chain(always_shown(job, false)).chain(stds).chain(always_shown(job, true));
        let imprecise: Vec<String> =
            self.job.quantities.iter().map(|quantity| column_name(self.job, quantity)).collect();
        let known = |column: CellColumn| {
            let values: Vec<f64> = (0..job.cells()).map(|cell| (column.value)(&job.grid.cell(cell))).collect();
            let varies = values.iter().any(|value| *value != values[0]);
            Known { column, values, varies }
        };
        all.filter(|column| imprecise.iter().all(|name| *name != column.name)).map(known).collect()
    }
}

/// The imprecise quantities by name.
pub fn imprecise_json(job: &ImpreciseJob) -> Value {
    let quantity = |quantity: &ImpreciseQuantity| {
        let (key, values) = match &quantity.values {
            Values::Between(ends) => ("between", json!(ends)),
            Values::OneOf(values) => {
                ("one_of", json!(values.iter().map(|value| value.replace('"', "")).collect::<Vec<_>>()))
            }
        };
        json!({ "quantity": column_name(job, quantity), "key": quantity.key, key: values })
    };
    job.quantities.iter().map(quantity).collect()
}

/// The quantity of a model by the name of its axis.
fn expected<'a>(job: &'a ImpreciseJob, name: &str) -> Option<&'a Quantity> {
    let job = job.first();
    job.model().place(name).map(|place| job.quantity(place))
}

/// The column of a quantity, as in a surface.
fn column_name(job: &ImpreciseJob, quantity: &ImpreciseQuantity) -> String {
    match &quantity.what {
        What::Expected(name) => expected(job, name).map_or(name.clone(), |quantity| quantity.column.to_string()),
        What::RelativeStd(input) => format!("std_{input}"),
        What::Distribution(input) => format!("distribution_{input}"),
        What::Correlation => "correlation".to_owned(),
    }
}

fn unit_of(job: &ImpreciseJob, quantity: &ImpreciseQuantity) -> String {
    match &quantity.what {
        What::Expected(name) => expected(job, name).map_or("1".to_owned(), |quantity| quantity.unit.to_string()),
        What::RelativeStd(_) | What::Distribution(_) | What::Correlation => "1".to_owned(),
    }
}

/// A probability with four decimals, or where these do not show it its order of magnitude.
fn probability(p: f64) -> String {
    if p == 0.0 || p >= 1e-3 { format!("{p:.4}") } else { format!("{p:.1e}") }
}
