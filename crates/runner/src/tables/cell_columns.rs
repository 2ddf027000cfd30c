//! Columns of what cells are: expected values and standard deviations, whatever was computed with them.

use std::borrow::Cow;

use stickslip_core::model::Model;
use stickslip_core::model::quantity::{Quantity, Role};
use stickslip_sampler::grid::Cell;

use crate::job::Job;

/// The axes of a job's grid, slowest first: the name of the column that has the values of each, and these values.
///
/// The axis of standard deviations goes by the first input in which its entries differ, as one column has to stand for
/// all inputs. There is none without inputs, unless the model has a pair, whose columns are always there.
pub fn axes(job: &Job) -> Vec<(String, Vec<f64>)> {
    let Job { grid, random, .. } = job;
    let mut axes: Vec<(String, Vec<f64>)> = grid
        .axes
        .iter()
        .map(|axis| (job.quantity(axis.quantity).column.to_string(), axis.axis.values().to_vec()))
        .collect();
    let input = random.first_varied().unwrap_or_default();
    let place = random.inputs.get(input).copied().or(job.model().pair().map(|pair| pair[0]));
    if let Some(place) = place {
        let stds = random.relative_stds.iter().map(|entry| entry.get(input).copied().unwrap_or(0.0)).collect();
        axes.insert(grid.slower_than_scatter, (format!("std_{}", job.quantity(place).name), stds));
    }
    axes
}

/// What cells are, as every surface shows it.
pub fn shown(job: &Job) -> impl Iterator<Item = CellColumn> {
    shown_of_configurations(job).chain(always_shown(job, true))
}

/// Expected values of configurations that every surface shows, and the standard deviations of the pair.
pub fn shown_of_configurations(job: &Job) -> impl Iterator<Item = CellColumn> {
    let std = |place: usize| CellColumn::std(job, place, &format!("the {}", job.quantity(place).noun()));
    always_shown(job, false).chain(job.model().pair().into_iter().flatten().map(std))
}

/// Expected values that every surface shows: of quantities that differ from sample to sample at no cost, or of others.
pub fn always_shown(job: &Job, is_input: bool) -> impl Iterator<Item = CellColumn> {
    let quantities = job.model().quantities().iter().enumerate();
    let wanted =
        quantities.filter(move |(_, quantity)| quantity.is_always_shown && (quantity.role == Role::Input) == is_input);
    wanted.map(|(place, quantity)| CellColumn::expected(place, quantity))
}

/// A column of what a cell is, whatever was computed of it.
pub struct CellColumn {
    pub name: Cow<'static, str>,
    pub unit: Cow<'static, str>,
    pub long_name: String,
    pub value: Box<dyn Fn(&Cell) -> f64>,
}

impl CellColumn {
    /// The expected value of a quantity.
    pub fn expected(place: usize, quantity: &Quantity) -> Self {
        Self {
            name: quantity.column.clone(),
            unit: quantity.unit.clone(),
            long_name: quantity.meaning_of_expected(),
            value: Box::new(move |cell| cell.expected[place]),
        }
    }

    /// The standard deviation of a quantity that is called `what`, 0 for one that does not scatter.
    fn std(job: &Job, place: usize, what: &str) -> Self {
        let quantity = job.quantity(place);
        let stds = stds_of(job, place);
        let (unit, over) = match job.is_absolute(place) {
            true => (quantity.unit.clone(), ""),
            false => ("1".into(), " over its expected value"),
        };
        Self {
            name: format!("std_{}", quantity.name).into(),
            unit,
            long_name: format!("standard deviation of {what}{over}"),
            value: Box::new(move |cell| stds[cell.scatter]),
        }
    }

    /// The standard deviation of a random input, as columns beside those of every surface have it.
    pub fn std_of_input(job: &Job, place: usize) -> Self {
        Self::std(job, place, &job.quantity(place).name)
    }
}

/// For each entry of `relative_std` the standard deviation of a quantity.
pub fn stds_of(job: &Job, place: usize) -> Vec<f64> {
    let input = job.random.position(place);
    job.random.relative_stds.iter().map(|stds| input.map_or(0.0, |input| stds[input])).collect()
}

/// The names of the pair in a sentence.
pub fn names_of_pair(model: &dyn Model) -> String {
    let labels = model.pair().into_iter().flatten().map(|place| &*model.quantities()[place].label);
    labels.collect::<Vec<_>>().join(" and ")
}
