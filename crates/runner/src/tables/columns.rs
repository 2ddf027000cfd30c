//! The columns of `surface.parquet`: name, unit, meaning, and how to read the value from a row.

use std::borrow::Cow;
use std::sync::Arc;

use stickslip_core::degree_of_freedom::DegreeOfFreedom;
use stickslip_core::parameters::scalar;
use stickslip_sampler::estimate::score::CellParameter;
use stickslip_sampler::estimate::sobol_indices::SobolIndices;
use stickslip_sampler::estimate::weighted::{Distrust, WeightedEstimate};
use stickslip_sampler::grid::Cell;
use stickslip_sampler::inputs::Marginal;

use crate::evaluate::integral::IntegratedCell;
use crate::evaluate::sums::SumLayout;
use crate::files::column::{self, Field, Kind};
use crate::job::{Effort, Job, RandomInput, SamplingMethod, StartValue};
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
pub fn of(job: &Job, layout: SumLayout) -> Vec<Column> {
    let mut columns = first_columns(match job.sampling.effort {
        Effort::Randomisations { .. } if job.is_conditional() => {
            "probability of instability, the mean of the conditional probabilities of the samples"
        }
        _ if job.is_weighted() => {
            "probability of instability, the mean of samples with weights; null where it is not to be trusted"
        }
        Effort::Samples(_) | Effort::Randomisations { .. } => {
            "probability of instability, unstable over decided samples"
        }
        Effort::Until(_) => "probability of instability, the unbiased estimate of stopping by precision",
        Effort::Integrated => "probability of instability, the integral",
    });
    if job.is_conditional() {
        describe(&mut columns, &CONDITIONAL);
    }
    if job.is_weighted() {
        describe(&mut columns, if job.sampling.method == SamplingMethod::Subset { &SUBSET } else { &IMPORTANCE });
        columns.extend(weight_columns());
    }
    if job.records_amplitude() {
        columns.extend(amplitude_columns());
    }
    if job.is_integrated() && job.uses_maps() {
        let meaning = "probability that a sample is undecided or fails";
        columns.push(Column::optional("p_undecided", meaning, |row| Some(row.integrated?.undecided)));
    }
    if layout.lookups() || (job.is_integrated() && job.sampling.is_audited) {
        columns.extend(lookup_columns());
    }
    if layout.sources() {
        columns.extend(source_columns(layout));
    }
    if layout.derivatives() {
        columns.extend(derivative_columns(layout, job.sampling.method == SamplingMethod::Exact));
    }
    if layout.sensitivity() > 0 {
        columns.extend(sensitivity_columns(layout, &job.random.inputs));
    }
    add_input_columns(&mut columns, job);
    if job.has_verdicts() {
        columns.push(Column::integer(
            "n_outside_physics",
            "samples without preload or with friction that rises with speed, decided as criterion.outside_physics specifies",
            |row| row.outside_physics,
        ));
    }
    columns
}

/// The axes of a job's grid, slowest first: the name of the column that has the values of each, and these values.
///
/// The axis of standard deviations goes by the first input in which its entries differ, as one column has to stand for
/// all inputs.
pub fn axes(job: &Job) -> Vec<(String, Vec<f64>)> {
    let Job { grid, random, .. } = job;
    let further = grid.further().map(|further| (further.name.clone(), further.axis.values().to_vec()));
    let input = random.first_varied().unwrap_or_default();
    let scattered = random.inputs.get(input).map_or("preload", |input| input.name());
    let stds = random.relative_stds.iter().map(|entry| entry.get(input).copied().unwrap_or(0.0)).collect();
    further
        .chain([
            ("rotating_speed_rad_s".to_owned(), grid.rotating_speed.values().to_vec()),
            (format!("std_{scattered}"), stds),
            ("preload".to_owned(), grid.preload.values().to_vec()),
            ("static_friction".to_owned(), grid.static_friction.values().to_vec()),
        ])
        .collect()
}

/// The columns of every surface; `probability` is the meaning of `p_unstable`.
#[rustfmt::skip]
fn first_columns(probability: &'static str) -> Vec<Column> {
    vec![
        Column::integer("cell", "0-based index of the cell", |row| row.cell.index),
        Column::new("rotating_speed_rad_s", "rad/s", "rotating speed of the disc", Values::Real(Box::new(|row| row.cell.rotating_speed))),
        Column::real("std_preload", "standard deviation of the preload over its expected value", |row| row.cell.relative_std.preload),
        Column::real("std_static_friction", "standard deviation of the static friction coefficient over its expected value", |row| row.cell.relative_std.static_friction),
        Column::real("preload", "expected preload, calliper displacement over disc thickness", |row| row.cell.preload),
        Column::real("static_friction", "expected static friction coefficient", |row| row.cell.static_friction),
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

/// What is counted where samples have conditional probabilities.
const CONDITIONAL: [(&str, &str); 4] = [
    ("n_samples", "samples of the inputs other than preload and static friction"),
    ("n_stable", "samples that are unstable with a probability of at most one half over preload and static friction"),
    ("n_unstable", "samples that are unstable with a probability above one half over preload and static friction"),
    ("n_failed", "samples of which no brake can be made"),
];

/// What is counted where samples are drawn with weights.
const IMPORTANCE: [(&str, &str); 5] = [
    ("n_samples", "samples, drawn where instability is frequent"),
    ("n_stable", "of these, samples decided as stable, or unstable with a probability of at most one half"),
    ("n_unstable", "of these, samples decided as unstable, or unstable with a probability above one half"),
    ("n_undecided", "of these, samples without a certain verdict"),
    ("n_failed", "0; failed samples are counted as undecided"),
];

/// What is counted where populations are led to rare events.
const SUBSET: [(&str, &str); 5] = [
    ("n_samples", "populations"),
    ("n_stable", "populations that found nothing unstable"),
    ("n_unstable", "populations that found something unstable"),
    ("n_undecided", "0"),
    ("n_failed", "0"),
];

/// Says what columns mean in a job in which they mean something else than usual.
fn describe(columns: &mut [Column], meanings: &[(&str, &'static str)]) {
    for (name, meaning) in meanings {
        if let Some(column) = columns.iter_mut().find(|column| column.name == *name) {
            column.long_name = (*meaning).into();
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
        Column::integer(
            "distrust",
            "0 if the probability is to be trusted; else p_unstable is null: 1 nothing unstable was found, 2 few samples have most of the probability, 3 independent populations disagree, 4 populations met samples without a verdict",
            |row| match row.weighted.as_ref().and_then(|weighted| weighted.distrust) {
                None => 0,
                Some(Distrust::NothingFound) => 1,
                Some(Distrust::FewSamples) => 2,
                Some(Distrust::Disagreement) => 3,
                Some(Distrust::WithoutVerdict) => 4,
            },
        ),
    ]
}

/// Columns of jobs that record the settled amplitude.
#[rustfmt::skip]
fn amplitude_columns() -> Vec<Column> {
    vec![
        Column::optional("amplitude_mean", "mean settled amplitude of the unstable samples, half peak to peak of x over disc thickness", |row| row.amplitudes.mean()),
        Column::optional("amplitude_p05", "settled amplitude that 5 % of the unstable samples do not exceed", |row| row.amplitudes.quantile(0.05)),
        Column::optional("amplitude_p50", "median settled amplitude of the unstable samples", |row| row.amplitudes.quantile(0.5)),
        Column::optional("amplitude_p95", "settled amplitude that 95 % of the unstable samples do not exceed", |row| row.amplitudes.quantile(0.95)),
    ]
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

/// Columns of jobs with a flexible disc: the degrees of freedom that feed the unstable samples.
fn source_columns(layout: SumLayout) -> Vec<Column> {
    let column = |name, meaning, source| {
        Column::integer(name, meaning, move |row: &SurfaceRow| {
            layout.read_source(&row.sums, source, row.counts.unstable)
        })
    };
    vec![
        column(
            "n_fed_tangential",
            "unstable samples that would be stable if friction did not fall with speed, or whose fastest growing mode is the tangential motion of the pad",
            DegreeOfFreedom::Tangential,
        ),
        column(
            "n_fed_normal",
            "unstable samples that grow even without falling friction, most in the normal motion of the pad",
            DegreeOfFreedom::Normal,
        ),
        column(
            "n_fed_angular",
            "unstable samples that grow even without falling friction, most in the rotation of the pad",
            DegreeOfFreedom::Angular,
        ),
        column(
            "n_fed_disc",
            "unstable samples that grow even without falling friction, most in the bending of the disc",
            DegreeOfFreedom::Disc,
        ),
    ]
}

/// Columns of jobs with derivatives: exact if probabilities are integrated, else with standard errors.
fn derivative_columns(layout: SumLayout, integrated: bool) -> Vec<Column> {
    let numbers = [
        (CellParameter::Preload, "dp_dpreload", "expected preload at constant relative standard deviation"),
        (
            CellParameter::StaticFriction,
            "dp_dstatic_friction",
            "expected static friction coefficient at constant relative standard deviation",
        ),
        (CellParameter::StdPreload, "dp_dstd_preload", "relative standard deviation of the preload"),
        (
            CellParameter::StdStaticFriction,
            "dp_dstd_static_friction",
            "relative standard deviation of the static friction coefficient",
        ),
    ];
    let mut columns = Vec::new();
    for (number, name, by) in numbers {
        let long_name = format!("derivative of the probability of instability by the {by}");
        if integrated {
            columns.push(Column::optional(name, long_name, move |row| {
                row.integrated.and_then(|IntegratedCell { derivatives, .. }| match number {
                    CellParameter::Preload => derivatives.preload,
                    CellParameter::StaticFriction => derivatives.static_friction,
                    CellParameter::StdPreload => derivatives.std_preload,
                    CellParameter::StdStaticFriction => derivatives.std_static_friction,
                })
            }));
            continue;
        }
        let read = move |row: &SurfaceRow| {
            layout.read_derivative(&row.sums, number, &row.cell, &row.counts, row.estimate.probability)
        };
        columns.push(Column::optional(name, long_name, move |row| read(row).map(|(value, _)| value)));
        columns.push(Column::optional(format!("{name}_error"), format!("standard error of {name}"), move |row| {
            read(row).map(|(_, error)| error)
        }));
    }
    columns
}

/// Columns of jobs with Sobol indices.
fn sensitivity_columns(layout: SumLayout, inputs: &[RandomInput]) -> Vec<Column> {
    let mut columns = Vec::new();
    for (i, input) in inputs.iter().enumerate() {
        let name = input.name();
        let read = move |row: &SurfaceRow| layout.read_sensitivity(&row.sums, i);
        let alone = format!("share of the verdict's variance that {name} explains alone");
        let any = format!("share of the verdict's variance in which {name} takes part");
        let mut add = |kind: &str, meaning: &str, value: fn(SobolIndices) -> f64, error: fn(SobolIndices) -> f64| {
            let column = format!("{kind}_{name}");
            let error_meaning = format!("standard error of {column}");
            let error_name = format!("{column}_error");
            columns.push(Column::optional(column, format!("Sobol index: {meaning}"), move |row| read(row).map(value)));
            columns.push(Column::optional(error_name, error_meaning, move |row| read(row).map(error)));
        };
        add("first_order", &alone, |indices| indices.first_order, |indices| indices.first_order_error);
        add("total", &any, |indices| indices.total, |indices| indices.total_error);
        columns.push(Column::new(
            format!("n_left_out_{name}"),
            "1",
            format!("samples that the Sobol indices of {name} leave out, because a verdict on them or their partners is undecided or failed"),
            Values::Integer(Box::new(move |row| layout.read_left_out(&row.sums, i))),
        ));
    }
    columns
}

/// Adds columns for the inputs and the further axes: expected value and standard deviation of those other than preload
/// and static friction, and mean and standard deviation of those that are truncated. The other columns of a truncated
/// input then name parameters of its distribution.
fn add_input_columns(columns: &mut Vec<Column>, job: &Job) {
    let job = Arc::new(job.clone());
    let start = job.criterion.given_start().unwrap_or_default();
    let expected_column = |key: &'static str, unit: &'static str, description: &str| {
        let of_job = job.clone();
        let value = move |row: &SurfaceRow| of_job.value_in(key, &row.cell).unwrap_or(f64::NAN);
        Column::new(key, unit, format!("expected value of {key}: {description}"), Values::Real(Box::new(value)))
    };
    for (i, (&input, marginal)) in job.random.inputs.iter().zip(&job.random.marginals).enumerate() {
        let name = input.name();
        let stds: Vec<f64> = job.random.relative_stds.iter().map(|stds| stds[i]).collect();
        let grid = job.grid.clone();
        let std = move |cell: &Cell| stds[grid.relative_std_index(cell.index)];
        let mut expected_name = name;
        let unit = match input {
            RandomInput::Preload | RandomInput::StaticFriction => "1",
            RandomInput::Other(scalar) => {
                if input.is_rotating_speed() {
                    expected_name = "rotating_speed_rad_s";
                } else {
                    columns.push(expected_column(scalar.key, scalar.unit, scalar.description));
                }
                let (of_cell, long_name) =
                    (std.clone(), format!("standard deviation of {name} over its expected value"));
                let read = Values::Real(Box::new(move |row| of_cell(&row.cell)));
                columns.push(Column::new(format!("std_{name}"), "1", long_name, read));
                scalar.unit
            }
            RandomInput::Start(number) => {
                let unit = number.unit(start.units);
                columns.push(expected_column(number.key(), unit, &number.description(&start)));
                let (of_cell, long_name) = (std.clone(), format!("standard deviation of {name}"));
                let read = Values::Real(Box::new(move |row| of_cell(&row.cell)));
                columns.push(Column::new(format!("std_{name}"), unit, long_name, read));
                unit
            }
        };
        if !matches!(marginal, Marginal::TruncatedNormal { .. }) {
            continue;
        }
        let (marginal, of_job) = (marginal.clone(), job.clone());
        let is_absolute = input.scatters_absolutely();
        let moments = move |row: &SurfaceRow| {
            let (expected, std) = (of_job.expected(input, &row.cell), std(&row.cell));
            if is_absolute { marginal.absolute_moments(expected, std) } else { marginal.moments(expected, std) }
        };
        let means = moments.clone();
        let (mean_name, scatter_name) = (format!("mean_{name}"), format!("scatter_{name}"));
        for (column, instead) in [(expected_name, &mean_name), (&format!("std_{name}"), &scatter_name)] {
            if let Some(column) = columns.iter_mut().find(|other| other.name == column) {
                let long_name = &column.long_name;
                column.long_name =
                    format!("{long_name}, before it is truncated: a parameter of its distribution, see {instead}")
                        .into();
            }
        }
        let long_name = format!("mean of {name}, which is truncated");
        columns.push(Column::new(mean_name, unit, long_name, Values::Real(Box::new(move |row| means(row).0))));
        if is_absolute {
            let long_name = format!("standard deviation of {name}, which is truncated");
            columns.push(Column::new(scatter_name, unit, long_name, Values::Real(Box::new(move |row| moments(row).1))));
            continue;
        }
        let long_name = format!("standard deviation of {name}, which is truncated, over its mean");
        columns.push(Column::optional(scatter_name, long_name, move |row| {
            let (mean, std) = moments(row);
            (mean > 0.0).then_some(std / mean)
        }));
    }
    for further in job.grid.further() {
        if columns.iter().any(|column| column.name == further.name) {
            continue;
        }
        if let Some(scalar) = scalar(&further.name) {
            columns.push(expected_column(scalar.key, scalar.unit, scalar.description));
        }
        if let Some(number) = StartValue::from_key(&further.name) {
            columns.push(expected_column(number.key(), number.unit(start.units), &number.description(&start)));
        }
    }
}

impl Column {
    /// What it is called and holds.
    pub fn field(&self) -> Field {
        let kind = match &self.values {
            Values::Integer(_) => Kind::Integer,
            Values::Real(_) => Kind::Real,
            Values::OptionalReal(_) => Kind::OptionalReal,
        };
        Field { name: self.name.clone(), unit: self.unit.clone(), long_name: self.long_name.clone(), kind }
    }

    /// Its values in some rows.
    pub fn read(&self, rows: &[SurfaceRow]) -> column::Values {
        match &self.values {
            // Counts stay far below 2^63, see the limit on samples.
            Values::Integer(value) => {
                column::Values::Integer(rows.iter().map(|row| value(row).cast_signed()).collect())
            }
            Values::Real(value) => column::Values::Real(rows.iter().map(value).collect()),
            Values::OptionalReal(value) => column::Values::OptionalReal(rows.iter().map(value).collect()),
        }
    }
}
