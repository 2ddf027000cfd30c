//! The differences of two runs as text, picture, JSON and columns.

use std::collections::{BTreeMap, BTreeSet};

use std::borrow::Cow;

use indicatif::HumanCount;
use serde_json::{Value, json as object};
use stickslip_core::model::quantity::{Quantity, Role};

use super::differences::{Differences, Interval, Row};
use crate::files::table::{TableColumn, TableValues};
use crate::output::counted;
use crate::picture::foot;
use crate::picture::view::{GridView, ViewAxis, label};
use crate::tables::cell_columns::{CellColumn, shown};

/// Largest number of rows and columns of a picture; larger grids are thinned out.
const MOST_ROWS: usize = 15;
const MOST_COLUMNS: usize = 60;

/// Largest number of slices (combinations of the axes that are not shown) that are shown.
const MOST_SLICES: usize = 4;

/// Signs, each with the smallest difference that it is drawn for.
const SIGNS: [(f64, char); 5] = [(0.1, '#'), (0.01, '+'), (-0.01, ' '), (-0.1, '-'), (f64::NEG_INFINITY, '=')];

/// The figures that summarise a comparison.
struct Facts<'a> {
    cells: usize,
    paired: usize,
    /// Cells in which one run or both have no probability.
    without: usize,
    /// Means over the cells with a difference.
    mean: Option<f64>,
    mean_absolute: Option<f64>,
    largest: Option<&'a Row>,
    higher: usize,
    lower: usize,
    /// Pairs of samples: all, those where both are decided, and those unstable in the first or the second run only.
    pairs: u64,
    decided: u64,
    only_first: u64,
    only_second: u64,
}

impl<'a> Facts<'a> {
    fn new(differences: &'a Differences<'_>) -> Self {
        let rows = &differences.rows;
        let known = || rows.iter().filter_map(|row| row.difference.value.map(|value| (value, row)));
        let count = known().count();
        let mean = |values: &mut dyn Iterator<Item = f64>| (count > 0).then(|| values.sum::<f64>() / count as f64);
        let sum = |value: fn(&Row) -> u64| rows.iter().map(value).sum();
        Self {
            cells: rows.len(),
            without: rows.len() - count,
            paired: rows.iter().filter(|row| row.interval == Interval::Paired).count(),
            mean: mean(&mut known().map(|(value, _)| value)),
            mean_absolute: mean(&mut known().map(|(value, _)| value.abs())),
            // Of several, the first.
            largest: known().rev().max_by(|a, b| a.0.abs().total_cmp(&b.0.abs())).map(|(_, row)| row),
            higher: rows.iter().filter(|row| row.difference.low > 0.0).count(),
            lower: rows.iter().filter(|row| row.difference.high < 0.0).count(),
            pairs: sum(|row| row.pairs),
            decided: sum(|row| row.joint.total()),
            only_first: sum(|row| row.joint.only_first),
            only_second: sum(|row| row.joint.only_second),
        }
    }

    /// Shares of the decided pairs that are unstable in the second only, and in the first only.
    fn shares(&self) -> Option<(f64, f64)> {
        let share = |count: u64| count as f64 / self.decided as f64;
        (self.decided > 0).then(|| (share(self.only_second), share(self.only_first)))
    }
}

/// A summary in a few lines; `meaning` says what the confidence of the intervals is.
pub fn summary(differences: &Differences<'_>, meaning: &str) -> String {
    let facts = Facts::new(differences);
    let Differences { first, second, .. } = differences;
    let mut text = format!(
        "{second} against {first}: {}, {} of them paired\n",
        counted(facts.cells as u128, "cell", "cells"),
        HumanCount(facts.paired as u64)
    );
    if facts.without > 0 {
        text += &format!(
            "left out          {} without a probability in one run or both\n",
            counted(facts.without as u128, "cell", "cells")
        );
    }
    let unknown = || "no cell has a probability in both runs".to_owned();
    let mean = facts.mean.zip(facts.mean_absolute);
    let mean = mean.map_or_else(unknown, |(mean, absolute)| {
        format!("{}, of its absolute value {}", signed(mean), &signed(absolute)[1..])
    });
    text += &format!("mean difference   {mean}\n");
    let largest = facts.largest.map_or_else(unknown, |row| {
        let difference = row.difference;
        format!(
            "{} ({} to {}, {}) in cell {}: {}",
            signed(difference.value.unwrap_or(0.0)),
            signed(difference.low),
            signed(difference.high),
            row.interval.name(),
            row.cell.index,
            place(differences, row)
        )
    });
    text += &format!("largest           {largest}\n");
    text += &format!(
        "significant       {} of {} cells ({} higher, {} lower): their interval {meaning} excludes 0\n",
        HumanCount((facts.higher + facts.lower) as u64),
        HumanCount(facts.cells as u64),
        HumanCount(facts.higher as u64),
        HumanCount(facts.lower as u64)
    );
    if let Some((second, first)) = facts.shares() {
        text += &format!(
            "in {} of the samples the second run is unstable where the first is stable, in {} the other way round\n",
            percent(second),
            percent(first)
        );
    }
    if facts.pairs > facts.decided {
        text += &format!(
            "{} of {} samples have no verdict in one run or both; the intervals allow for either verdict on them\n",
            HumanCount(facts.pairs - facts.decided),
            HumanCount(facts.pairs)
        );
    }
    text
}

/// Where the cell of a row lies: "15 rad/s, preload 0.1, static friction 0.3, pad.mass 0.2".
fn place(differences: &Differences<'_>, row: &Row) -> String {
    let job = differences.job;
    let quantities = job.model().quantities().iter().zip(&row.cell.expected);
    let of_role = |is_input: bool| {
        quantities
            .clone()
            .filter(move |(quantity, _)| quantity.is_always_shown && (quantity.role == Role::Input) == is_input)
    };
    let text = |(quantity, value): (&Quantity, &f64)| match (&*quantity.unit, quantity.role) {
        ("1", _) => format!("{} {value}", quantity.label),
        (unit, Role::Input) => format!("{} {value} {unit}", quantity.label),
        (unit, _) => format!("{value} {unit}"),
    };
    let further = further(differences, row).map(|(quantity, value)| format!("{} {value}", quantity.name));
    let all = of_role(false).chain(of_role(true)).map(text).chain(further);
    all.collect::<Vec<_>>().join(", ")
}

/// The values of a row on axes of the reference that are not always shown.
fn further<'a>(differences: &'a Differences<'_>, row: &'a Row) -> impl Iterator<Item = (&'a Quantity, f64)> {
    let job = differences.job;
    let axes = job.grid.axes.iter().map(|axis| (job.quantity(axis.quantity), row.cell.expected[axis.quantity]));
    axes.filter(|(quantity, _)| !quantity.is_always_shown)
}

/// The largest difference as an object of JSON.
fn largest_as_json(differences: &Differences<'_>, row: &Row) -> Value {
    let mut largest = object!({ "cell_first": row.cell.index, "cell_second": row.second_cell });
    for column in shown(differences.job) {
        largest[&*column.name] = (column.value)(&row.cell).into();
    }
    largest["difference"] = row.difference.value.into();
    largest["difference_low"] = row.difference.low.into();
    largest["difference_high"] = row.difference.high.into();
    largest["interval"] = row.interval.name().into();
    for (quantity, value) in further(differences, row) {
        largest[&*quantity.name] = value.into();
    }
    largest
}

/// A difference with its sign: one of rare events has as many digits as others.
fn signed(difference: f64) -> String {
    if difference == 0.0 || difference.abs() >= 1e-3 {
        format!("{difference:+.5}")
    } else {
        format!("{difference:+.5e}")
    }
}

/// A share in per cent. A share of zero differs from one that rounds to zero.
fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    match percent {
        0.0 => "none".to_owned(),
        ..0.001 => "less than 0.001 %".to_owned(),
        ..0.1 => format!("{percent:.3} %"),
        _ => format!("{percent:.1} %"),
    }
}

/// The summaries as JSON.
pub fn json(compared: &[Differences<'_>], confidence: f64, simultaneous: bool) -> Value {
    let of = |differences: &Differences<'_>| {
        let facts = Facts::new(differences);
        let shares = facts.shares();
        object!({
            "first": differences.first,
            "second": differences.second,
            "cells": facts.cells,
            "cells_paired": facts.paired,
            "cells_without_difference": facts.without,
            "confidence": confidence,
            "simultaneous": simultaneous,
            "mean_difference": facts.mean,
            "mean_absolute_difference": facts.mean_absolute,
            "largest": facts.largest.map(|row| largest_as_json(differences, row)),
            "cells_significantly_higher": facts.higher,
            "cells_significantly_lower": facts.lower,
            "samples_paired": facts.pairs,
            "samples_only_first_unstable": facts.only_first,
            "samples_only_second_unstable": facts.only_second,
            "share_only_first_unstable": shares.map(|(_, first)| first),
            "share_only_second_unstable": shares.map(|(second, _)| second),
        })
    };
    Value::Array(compared.iter().map(of).collect())
}

/// The difference over the two longest axes of the reference: one slice for each combination of the others, if it has
/// at least two values of each.
pub fn picture(differences: &Differences<'_>) -> String {
    let view = GridView::new(differences.job);
    let (Some(vertical), Some(horizontal)) = (view.vertical(), view.horizontal()) else { return String::new() };
    let mut slices: BTreeMap<u64, BTreeMap<(usize, usize), &Row>> = BTreeMap::new();
    for row in &differences.rows {
        let index = row.cell.index;
        let place = (vertical.position(index), horizontal.position(index));
        slices.entry(view.slice_of(index).first).or_default().insert(place, row);
    }
    let (mut text, mut drawn, mut more) = (String::new(), 0, 0);
    for (&first, slice) in &slices {
        let rows: Vec<usize> = slice.keys().map(|place| place.0).collect::<BTreeSet<_>>().into_iter().collect();
        let columns: Vec<usize> = slice.keys().map(|place| place.1).collect::<BTreeSet<_>>().into_iter().collect();
        if rows.len() < 2 || columns.len() < 2 {
            continue;
        }
        if drawn == MOST_SLICES {
            more += 1;
            continue;
        }
        drawn += 1;
        let shared = view.slice_of(first).title(differences.job);
        let comma = if shared.starts_with(';') { "" } else { "," };
        text += &format!("Difference, second minus first{comma}{shared}\n\n");
        text += &slice_picture(slice, &rows, &columns, (vertical, horizontal));
    }
    if more > 0 {
        text += &format!("... and {more} more slices; --out FILE.parquet writes them all\n");
    }
    text
}

/// At most `most` evenly spaced entries, both ends included.
fn thinned(entries: &[usize], most: usize) -> Vec<usize> {
    let length = entries.len();
    if length <= most {
        return entries.to_vec();
    }
    (0..most).map(|i| entries[(i * (length - 1) + (most - 1) / 2) / (most - 1)]).collect()
}

fn slice_picture(
    slice: &BTreeMap<(usize, usize), &Row>,
    rows: &[usize],
    columns: &[usize],
    (vertical, horizontal): (&ViewAxis, &ViewAxis),
) -> String {
    let mut text = format!(" {}\n", vertical.name);
    let drawn = thinned(columns, MOST_COLUMNS);
    let width = if drawn.len() <= MOST_COLUMNS / 2 { 2 } else { 1 };
    for up in thinned(rows, MOST_ROWS).into_iter().rev() {
        text += &format!("{} |", label(vertical.values[up]));
        for &right in &drawn {
            let sign = slice.get(&(up, right)).map_or('.', |row| row.difference.value.map_or('?', sign));
            text.extend(std::iter::repeat_n(sign, width));
        }
        text += "|\n";
    }
    let ends = [columns.first(), columns.last()].map(|column| column.map_or(0.0, |&column| horizontal.values[column]));
    text += &foot(&horizontal.name, ends, drawn.len() * width);
    text += "          = below -0.1, - to -0.01, ' ' to 0.01, + to 0.1, # 0.1 and more";
    if slice.values().any(|row| row.difference.value.is_none()) {
        text += "\n          ? without a probability in one run or both";
    }
    if slice.len() < rows.len() * columns.len() {
        text += "\n          . not in both runs";
    }
    text + "\n\n"
}

fn sign(difference: f64) -> char {
    SIGNS.iter().find(|(from, _)| difference >= *from).map_or('?', |(_, sign)| *sign)
}

/// One row for each pair of runs and cell.
pub fn table(compared: &[Differences<'_>]) -> Vec<TableColumn> {
    let all = || compared.iter().flat_map(|differences| differences.rows.iter().map(move |row| (differences, row)));
    let column = |name: &'static str, long_name: &'static str, values| TableColumn {
        name: name.into(),
        unit: "1".into(),
        long_name: Cow::Borrowed(long_name),
        values,
    };
    let text = |name: &'static str, long_name, value: fn(&Differences<'_>, &Row) -> String| {
        column(name, long_name, TableValues::Text(all().map(|(differences, row)| value(differences, row)).collect()))
    };
    let integer = |name: &'static str, long_name, value: fn(&Row) -> u64| {
        column(name, long_name, TableValues::Integer(all().map(|(_, row)| value(row)).collect()))
    };
    let real = |name: &'static str, long_name, value: fn(&Row) -> Option<f64>| {
        column(name, long_name, TableValues::Real(all().map(|(_, row)| value(row)).collect()))
    };
    let mut columns = vec![
        text("first_run", "directory of the reference", |differences, _| differences.first.to_owned()),
        text("second_run", "directory of the run that is compared with it", |differences, _| {
            differences.second.to_owned()
        }),
        integer("cell_first", "0-based index of the cell in the first run", |row| row.cell.index),
        integer("cell_second", "0-based index of the cell in the second run", |row| row.second_cell),
    ];
    columns.extend(of_cells(compared));
    #[rustfmt::skip]
    columns.extend([
        integer("n_paired", "samples that both runs decided; 0 unless paired", |row| row.pairs),
        integer("n_both", "paired samples unstable in both runs", |row| row.joint.both),
        integer("n_only_first", "paired samples unstable in the first run, stable in the second", |row| row.joint.only_first),
        integer("n_only_second", "paired samples stable in the first run, unstable in the second", |row| row.joint.only_second),
        integer("n_neither", "paired samples stable in both runs", |row| row.joint.neither),
        integer("n_without_verdict", "paired samples undecided or failed in one run or both", |row| row.pairs - row.joint.total()),
        real("p_first", "probability of instability in the first run, of the paired samples where there are any", |row| row.first),
        real("p_second", "probability of instability in the second run, of the paired samples where there are any", |row| row.second),
        real("difference", "probability in the second run minus that in the first", |row| row.difference.value),
        real("difference_low", "lower end of the interval of the difference", |row| Some(row.difference.low)),
        real("difference_high", "upper end of the interval of the difference", |row| Some(row.difference.high)),
        text("interval", "paired (sample by sample), unpaired (independent samples), dependent (shared random numbers) or bounds (of integrated probabilities)", |_, row| row.interval.name().to_owned()),
    ]);
    columns.extend(of_further_axes(compared));
    columns
}

/// What the cells of the references are, as every surface shows it.
fn of_cells(compared: &[Differences<'_>]) -> Vec<TableColumn> {
    let shown: Vec<Vec<CellColumn>> = compared.iter().map(|differences| shown(differences.job).collect()).collect();
    let column = |wanted: &CellColumn| {
        let values = compared.iter().zip(&shown).flat_map(|(differences, columns)| {
            let own = columns.iter().find(|column| column.name == wanted.name);
            differences.rows.iter().map(move |row| own.map(|own| (own.value)(&row.cell)))
        });
        TableColumn {
            name: wanted.name.clone(),
            unit: wanted.unit.clone(),
            long_name: wanted.long_name.clone().into(),
            values: TableValues::Real(values.collect()),
        }
    };
    shown.first().map_or_else(Vec::new, |columns| columns.iter().map(column).collect())
}

/// The values in the references of other quantities that have an axis in any of them.
fn of_further_axes(compared: &[Differences<'_>]) -> Vec<TableColumn> {
    let Some(first) = compared.first() else { return Vec::new() };
    let is_axis = |quantity: &Quantity| {
        let has_axis = |differences: &Differences<'_>| {
            let job = differences.job;
            job.model().place(&quantity.name).is_some_and(|place| job.grid.axis_of(place).is_some())
        };
        !quantity.is_always_shown && compared.iter().any(has_axis)
    };
    let column = |quantity: &Quantity| {
        let values = compared.iter().flat_map(|differences| {
            let place = differences.job.model().place(&quantity.name);
            let value = move |row: &Row| place.map(|place| row.cell.expected[place]).filter(|value| !value.is_nan());
            differences.rows.iter().map(value)
        });
        TableColumn {
            name: quantity.column.clone(),
            unit: quantity.unit.clone(),
            long_name: "expected value in the first run".into(),
            values: TableValues::Real(values.collect()),
        }
    };
    first.job.model().quantities().iter().filter(|quantity| is_axis(quantity)).map(column).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_difference_of_rare_events_has_six_digits() {
        let written = [1.234_567_89e-7, -9.876_543_21e-4, 0.0, 0.123_456_7].map(signed);
        assert_eq!(written, ["+1.23457e-7", "-9.87654e-4", "+0.00000", "+0.12346"]);
    }
}
