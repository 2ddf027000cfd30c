//! The columns of `surface.parquet`: name, unit, meaning, and how to read the value from a row.

use std::borrow::Cow;
use std::iter;
use std::sync::Arc;

use arrow::array::{ArrayRef, Float64Array};
use arrow::datatypes::{DataType, Field};
use stickslip_core::model::Model;
use stickslip_core::model::decision::Source;
use stickslip_core::model::recorded::RecordedResult;
use stickslip_sampler::estimate::audit::PlainSamples;
use stickslip_sampler::estimate::distribution::Distribution;
use stickslip_sampler::estimate::sobol_indices::SobolIndices;
use stickslip_sampler::estimate::weighted::WeightedEstimate;
use stickslip_sampler::inputs::{Marginal, PairParameter};

use crate::evaluate::integral::IntegratedCell;
use crate::evaluate::sums::SumLayout;
use crate::files::table::{column, integers};
use crate::job::reduction::Reduction;
use crate::job::{Answer, Job, MapUse};
use crate::tables::cell_columns::{CellColumn, names_of_pair, shown, stds_of};
use crate::tables::row::SurfaceRow;

/// A column: its name, unit, meaning and values.
pub struct Column {
    name: Cow<'static, str>,
    unit: Cow<'static, str>,
    long_name: Cow<'static, str>,
    values: Values,
}

pub enum Values {
    Integer(Read<u64>),
    Real(Read<f64>),
    OptionalReal(Read<Option<f64>>),
}

/// Reads a value from a row.
pub type Read<T> = Box<dyn Fn(&SurfaceRow) -> T>;

impl Column {
    pub fn new(
        name: impl Into<Cow<'static, str>>,
        unit: impl Into<Cow<'static, str>>,
        long_name: impl Into<Cow<'static, str>>,
        values: Values,
    ) -> Self {
        Self { name: name.into(), unit: unit.into(), long_name: long_name.into(), values }
    }

    pub fn integer(name: &'static str, long_name: &'static str, value: impl Fn(&SurfaceRow) -> u64 + 'static) -> Self {
        Self::new(name, "1", long_name, Values::Integer(Box::new(value)))
    }

    pub fn real(name: &'static str, long_name: &'static str, value: impl Fn(&SurfaceRow) -> f64 + 'static) -> Self {
        Self::new(name, "1", long_name, Values::Real(Box::new(value)))
    }

    pub fn optional(
        name: impl Into<Cow<'static, str>>,
        long_name: impl Into<Cow<'static, str>>,
        value: impl Fn(&SurfaceRow) -> Option<f64> + 'static,
    ) -> Self {
        Self::new(name, "1", long_name, Values::OptionalReal(Box::new(value)))
    }
}

/// The columns of a job's surface, in their order.
pub fn for_job(job: &Job, layout: SumLayout) -> Vec<Column> {
    let mut columns = first_columns(job);
    let method = job.sampling.method;
    columns.extend(count_columns(method.probability()));
    describe(&mut columns, method.counts(&names_of_pair(job.model())));
    if job.answer().is_of_rare_events() {
        columns.extend(weight_columns());
    }
    if job.sampling.method.has_plain_samples() {
        columns.extend(trust_columns(job.plain_samples() > 0));
    }
    for (place, result) in job.model().recorded().iter().enumerate() {
        columns.extend(recorded_columns(place, result));
    }
    if job.map_use() == MapUse::Integrate {
        let meaning = "probability that a sample is undecided or fails";
        columns.push(Column::optional("p_undecided", meaning, |row| Some(row.integrated?.undecided)));
    }
    if layout.lookups() || job.sampling.is_audited {
        columns.extend(lookup_columns());
    }
    if let Some(reduction) = job.reduction() {
        columns.extend(reduction_columns(reduction, job.sampling.confidence));
    }
    if layout.sources() {
        columns.extend(source_columns(job.model(), layout));
    }
    if layout.derivatives() {
        columns.extend(derivative_columns(job, layout));
    }
    if layout.sensitivity() > 0 {
        columns.extend(sensitivity_columns(job, layout));
    }
    add_input_columns(&mut columns, job);
    if job.answer() == Answer::Verdict {
        let outside = job.model().outside_meaning();
        columns.push(Column::new(
            "n_outside_physics",
            "1",
            format!("samples outside the model ({outside}), decided as criterion.outside_physics specifies"),
            Values::Integer(Box::new(|row| row.outside_physics)),
        ));
    }
    columns
}

impl From<CellColumn> for Column {
    fn from(column: CellColumn) -> Self {
        let CellColumn { name, unit, long_name, value } = column;
        Self::new(name, unit, long_name, Values::Real(Box::new(move |row| value(&row.cell))))
    }
}

/// The columns of every surface that say what its cells are.
fn first_columns(job: &Job) -> Vec<Column> {
    let cell = Column::integer("cell", "0-based index of the cell", |row| row.cell.index);
    iter::once(cell).chain(shown(job).map(Column::from)).collect()
}

/// The columns of every surface that say what was found; `probability` is the meaning of `p_unstable`.
#[rustfmt::skip]
fn count_columns(probability: &'static str) -> Vec<Column> {
    vec![
        Column::integer("n_samples", "samples", |row| row.counts.total()),
        Column::integer("n_stable", "samples decided as stable", |row| row.counts.stable),
        Column::integer("n_unstable", "samples decided as unstable", |row| row.counts.unstable),
        Column::integer("n_undecided", "samples without a certain verdict", |row| row.counts.undecided),
        Column::integer("n_failed", "samples whose computation failed", |row| row.counts.failed),
        Column::optional("p_unstable", probability, |row| row.estimate.probability),
        Column::real("p_low", "lower end of the confidence interval of the probability", |row| row.estimate.low),
        Column::real("p_high", "upper end of the confidence interval of the probability", |row| row.estimate.high),
    ]
}

/// Says what columns mean in a job in which they mean something else than usual.
fn describe(columns: &mut [Column], meanings: Vec<(&'static str, String)>) {
    for (name, meaning) in meanings {
        if let Some(column) = columns.iter_mut().find(|column| column.name == name) {
            column.long_name = meaning.into();
        }
    }
}

/// Columns of jobs whose samples have weights.
fn weight_columns() -> Vec<Column> {
    let of = |value: fn(&WeightedEstimate) -> f64| move |row: &SurfaceRow| row.weighted.as_ref().map(value);
    vec![
        Column::optional(
            "n_effective",
            "effective number of samples, or of populations, that have the probability: the square of the sum of their contributions over the sum of the squares",
            of(|weighted| weighted.effective),
        ),
        Column::optional(
            "n_evaluations",
            "verdicts or conditional probabilities that were computed, with those by which the samples were placed",
            of(|weighted| weighted.evaluations),
        ),
    ]
}

/// Columns of jobs whose probabilities do not come from plain samples.
fn trust_columns(has_plain_samples: bool) -> Vec<Column> {
    let distrust = Column::integer(
        "distrust",
        "0 if nothing speaks against the probability; else p_unstable is null: 1 nothing unstable was found (or nothing stable, where instability is frequent), 2 few samples have most of the probability, 3 independent populations disagree, 4 samples without a verdict are more probable than unstable ones, 5 plain samples contradict p_low to p_high, 6 critical values leave too much open",
        |row| row.distrust,
    );
    let plain = |name: &'static str, meaning: &'static str, count: fn(&PlainSamples) -> u64| {
        Column::integer(name, meaning, move |row| row.plain.as_ref().map_or(0, count))
    };
    let samples = [
        plain("n_audit", "plain samples beside the probability that have a verdict", |plain| plain.decided),
        plain("n_audit_unstable", "unstable ones of them", |plain| plain.unstable),
    ];
    let samples = samples.into_iter().filter(|_| has_plain_samples);
    iter::once(distrust).chain(samples).collect()
}

/// Columns of a result that is recorded.
fn recorded_columns(place: usize, result: &RecordedResult) -> Vec<Column> {
    let RecordedResult { name, unit, noun, meaning, .. } = result;
    let samples = result.of.nouns()[1];
    let column = |kind: &str, long_name: String, value: fn(&Distribution) -> Option<f64>| {
        let values = Values::OptionalReal(Box::new(move |row| value(&row.recorded[place])));
        Column::new(format!("{name}_{kind}"), *unit, long_name, values)
    };
    let below = |percent: u32| format!("{noun} that {percent} % of the {samples} do not exceed");
    let mean = || column("mean", format!("mean {noun} of the {samples}, {meaning}"), Distribution::mean);
    let quantiles = [
        column("p05", below(5), |values| values.quantile(0.05)),
        column("p50", format!("median {noun} of the {samples}, {meaning}"), |values| values.quantile(0.5)),
        column("p95", below(95), |values| values.quantile(0.95)),
    ];
    result.has_mean.then(mean).into_iter().chain(quantiles).collect()
}

/// Columns of jobs with a verdict map.
fn lookup_columns() -> Vec<Column> {
    vec![
        Column::integer(
            "n_simulated",
            "samples that were simulated, as the verdict map has no verdict for them",
            |row| row.lookups.simulated,
        ),
        Column::integer("n_audited", "samples that were looked up and simulated as well, as a check", |row| {
            row.lookups.audited
        }),
        Column::integer(
            "n_audit_differed",
            "audited samples whose simulated verdict differs from the one looked up",
            |row| row.lookups.differed,
        ),
        Column::optional(
            "p_audit",
            "largest share of wrong looked-up verdicts that the audit does not exclude; p_low and p_high contain it",
            |row| row.unaudited,
        ),
    ]
}

/// Columns of jobs whose model was reduced from a larger one.
fn reduction_columns(reduction: &Reduction, confidence: f64) -> Vec<Column> {
    let (audited, differed, share) = (reduction.audited, reduction.differed, reduction.largest_share(confidence));
    vec![
        Column::integer(
            "n_reduction_audited",
            "samples that the full matrices decided as well, before the job",
            move |_| audited,
        ),
        Column::integer(
            "n_reduction_differed",
            "samples of these whose verdict differs on the full matrices",
            move |_| differed,
        ),
        Column::real(
            "p_reduction",
            "largest share of verdicts of the first cell as it was reduced that differ on the full matrices, as far as this audit does not exclude it; p_low and p_high do not contain it",
            move |_| share,
        ),
    ]
}

/// Columns of jobs whose decisions name what feeds the unstable samples.
fn source_columns(model: &dyn Model, layout: SumLayout) -> Vec<Column> {
    let column = |(place, source): (usize, &Source)| {
        let value = move |row: &SurfaceRow| layout.read_source(&row.sums, place, row.counts.unstable);
        Column::new(format!("n_fed_{}", source.name), "1", source.meaning, Values::Integer(Box::new(value)))
    };
    model.sources().iter().enumerate().map(column).collect()
}

/// Columns of jobs with derivatives: exact if probabilities are integrated, else with standard errors.
fn derivative_columns(job: &Job, layout: SumLayout) -> Vec<Column> {
    let Some(pair) = job.model().pair() else { return Vec::new() };
    let job = Arc::new(job.clone());
    let mut columns = Vec::new();
    for parameter in PairParameter::DIFFERENTIATED {
        let (name, by) = match parameter {
            PairParameter::Expected(input) => {
                let quantity = job.quantity(pair[input]);
                let by = format!("expected {} at constant relative standard deviation", quantity.noun());
                (format!("dp_d{}", quantity.name), by)
            }
            PairParameter::RelativeStd(input) => {
                let quantity = job.quantity(pair[input]);
                let by = format!("relative standard deviation of the {}", quantity.noun());
                (format!("dp_dstd_{}", quantity.name), by)
            }
            PairParameter::Correlation => ("dp_dcorrelation".to_owned(), "correlation".to_owned()),
        };
        let long_name = format!("derivative of the probability of instability by the {by}");
        if job.answer() == Answer::Integral {
            columns.push(Column::optional(name, long_name, move |row| {
                row.integrated.and_then(|IntegratedCell { derivatives, .. }| derivatives.get(parameter))
            }));
            continue;
        }
        let of_job = job.clone();
        let read = move |row: &SurfaceRow| {
            let inputs = of_job.normal_pair(&row.cell);
            layout.read_derivative(&row.sums, parameter, &inputs, &row.counts, row.estimate.probability)
        };
        let value = read.clone();
        columns.push(Column::optional(name.clone(), long_name, move |row| value(row).map(|(value, _)| value)));
        columns.push(Column::optional(format!("{name}_error"), format!("standard error of {name}"), move |row| {
            read(row).map(|(_, error)| error)
        }));
    }
    columns
}

/// Columns of jobs with Sobol indices: those of the verdict, then those of every result that is recorded of all samples.
fn sensitivity_columns(job: &Job, layout: SumLayout) -> Vec<Column> {
    let names = || job.random.inputs.iter().map(|&place| &*job.quantity(place).name).enumerate();
    let mut columns = Vec::new();
    for (i, input) in names() {
        columns.extend(index_columns("", "verdict", input, move |row| layout.read_sensitivity(&row.sums, i)));
        columns.push(Column::new(
            format!("n_left_out_{input}"),
            "1",
            format!("samples that the Sobol indices of {input} leave out, because a verdict on them or their partners is undecided or failed"),
            Values::Integer(Box::new(move |row| layout.read_left_out(&row.sums, i))),
        ));
    }
    for (place, result) in job.model().recorded().iter().enumerate().take(layout.results()) {
        let RecordedResult { name, noun, .. } = result;
        for (i, input) in names() {
            let read = move |row: &SurfaceRow| layout.read_result_sensitivity(&row.sums, place, i);
            columns.extend(index_columns(&format!("{name}_"), noun, input, move |row| read(row)?.0));
            columns.push(Column::new(
                format!("{name}_n_left_out_{input}"),
                "1",
                format!("samples that the Sobol indices of the {noun} by {input} leave out, because they or their partners have none"),
                Values::Integer(Box::new(move |row| read(row).map_or(0, |(_, left_out)| left_out))),
            ));
        }
    }
    columns
}

/// The columns of the Sobol indices by an input, of what is called `of` in sentences.
fn index_columns(
    prefix: &str,
    of: &str,
    input: &str,
    read: impl Fn(&SurfaceRow) -> Option<SobolIndices> + Copy + 'static,
) -> Vec<Column> {
    let mut columns = Vec::new();
    let mut add = |kind: &str, meaning: &str, value: fn(SobolIndices) -> f64, error: fn(SobolIndices) -> f64| {
        let column = format!("{prefix}{kind}_{input}");
        let error_meaning = format!("standard error of {column}");
        let error_name = format!("{column}_error");
        let meaning = format!("Sobol index: share of the {of}'s variance {meaning}");
        columns.push(Column::optional(column, meaning, move |row| read(row).map(value)));
        columns.push(Column::optional(error_name, error_meaning, move |row| read(row).map(error)));
    };
    let (alone, any) = (format!("that {input} explains alone"), format!("in which {input} takes part"));
    add("first_order", &alone, |indices| indices.first_order, |indices| indices.first_order_error);
    add("total", &any, |indices| indices.total, |indices| indices.total_error);
    columns
}

/// Adds what the columns of every surface do not have: expected values and standard deviations of the other inputs,
/// mean and standard deviation of those that are truncated, and expected values of the other axes. The other columns of
/// a truncated input then name parameters of its distribution.
fn add_input_columns(columns: &mut Vec<Column>, job: &Job) {
    for (&place, marginal) in job.random.inputs.iter().zip(&job.random.marginals) {
        add_missing(columns, CellColumn::expected(place, job.quantity(place)));
        add_missing(columns, CellColumn::std_of_input(job, place));
        if let Marginal::TruncatedNormal { .. } = marginal {
            add_moments(columns, job, place, marginal);
        }
    }
    for axis in &job.grid.axes {
        add_missing(columns, CellColumn::expected(axis.quantity, job.quantity(axis.quantity)));
    }
}

fn add_missing(columns: &mut Vec<Column>, column: CellColumn) {
    if columns.iter().all(|other| other.name != column.name) {
        columns.push(column.into());
    }
}

/// Adds mean and standard deviation of an input that is truncated.
fn add_moments(columns: &mut Vec<Column>, job: &Job, place: usize, marginal: &Marginal) {
    let quantity = job.quantity(place);
    let (name, unit) = (&quantity.name, &quantity.unit);
    let (is_absolute, marginal) = (job.is_absolute(place), marginal.clone());
    let stds = stds_of(job, place);
    let moments = move |row: &SurfaceRow| {
        let (expected, std) = (row.cell.expected[place], stds[row.cell.scatter]);
        if is_absolute { marginal.absolute_moments(expected, std) } else { marginal.moments(expected, std) }
    };
    let means = moments.clone();
    let (mean_name, scatter_name) = (format!("mean_{name}"), format!("scatter_{name}"));
    for (column, instead) in [(&*quantity.column, &mean_name), (&*format!("std_{name}"), &scatter_name)] {
        if let Some(column) = columns.iter_mut().find(|other| other.name == column) {
            let long_name = &column.long_name;
            column.long_name =
                format!("{long_name}, before it is truncated: a parameter of its distribution, see {instead}").into();
        }
    }
    let long_name = format!("mean of {name}, which is truncated");
    columns.push(Column::new(mean_name, unit.clone(), long_name, Values::Real(Box::new(move |row| means(row).0))));
    if is_absolute {
        let long_name = format!("standard deviation of {name}, which is truncated");
        let std = Values::Real(Box::new(move |row| moments(row).1));
        columns.push(Column::new(scatter_name, unit.clone(), long_name, std));
        return;
    }
    let long_name = format!("standard deviation of {name}, which is truncated, over its mean");
    columns.push(Column::optional(scatter_name, long_name, move |row| {
        let (mean, std) = moments(row);
        (mean > 0.0).then_some(std / mean)
    }));
}

impl Column {
    /// What it is called and holds.
    pub fn field(&self) -> Field {
        let (kind, is_optional) = match &self.values {
            Values::Integer(_) => (DataType::Int64, false),
            Values::Real(_) => (DataType::Float64, false),
            Values::OptionalReal(_) => (DataType::Float64, true),
        };
        column(&self.name, &self.unit, &self.long_name, kind, is_optional)
    }

    /// Its values in some rows.
    pub fn read(&self, rows: &[SurfaceRow]) -> ArrayRef {
        match &self.values {
            Values::Integer(value) => Arc::new(integers(rows.iter().map(value))),
            Values::Real(value) => Arc::new(Float64Array::from_iter_values(rows.iter().map(value))),
            Values::OptionalReal(value) => Arc::new(Float64Array::from_iter(rows.iter().map(value))),
        }
    }
}
