//! `surface.parquet`: one row for each cell, sorted by cell.

use std::borrow::Cow;
use std::cell::OnceCell;
use std::collections::HashMap;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::sync::Arc;

use arrow::array::{ArrayRef, Float64Array, Int64Array, RecordBatch, StringArray};
use arrow::datatypes::{DataType, Field, Schema};
use parquet::arrow::ArrowWriter;
use parquet::basic::Compression;
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::FileReader as _;
use parquet::file::serialized_reader::SerializedFileReader;
use stickslip_core::{DegreeOfFreedom, VerdictCounts};
use stickslip_sampler::exact::Derivatives;
use stickslip_sampler::score::CellNumber;
use stickslip_sampler::sensitivity::SobolIndices;
use stickslip_sampler::{
    Cell, Distribution, ESTIMATES_VERSION, Estimate, Marginal, RESULTS_VERSION, audit, replicates,
};

use super::extras::{Extras, Lookups};
use super::publish::{publish, publish_with};
use super::slots::Slots;
use super::tally::Tally;
use crate::failure::Failure;
use crate::job::{Effort, Job, RandomInput, SamplingMethod};

/// Rows that are held in memory at once; also the size of a row group.
const BATCH_ROWS: u64 = 65_536;

const JOB_HASH_KEY: &str = "stickslip:job_hash";

/// One row of the result.
#[derive(Debug, Clone)]
pub struct SurfaceRow {
    /// Expected values and scatter.
    pub cell: Cell,
    /// Verdicts.
    pub counts: VerdictCounts,
    /// Probability and interval.
    pub estimate: Estimate,
    /// The share of samples whose looked-up verdict the audit does not exclude to be wrong; `None` without an audit.
    pub unaudited: Option<f64>,
    /// Settled amplitudes of the unstable samples, if the job records them.
    pub amplitudes: Distribution,
    /// How its samples, or those of its audit, were judged.
    lookups: Lookups,
    /// Further sums that the job asks for.
    sums: Vec<i128>,
    /// What is known beside the probability, where it was integrated.
    integrated: Option<IntegratedCell>,
}

/// The probability of a cell by integration.
#[derive(Debug, Clone, Copy)]
pub struct IntegratedCell {
    /// Probability, and the bounds of its error.
    pub estimate: Estimate,
    /// Its derivatives.
    pub derivatives: Derivatives,
    /// The probability that a sample is undecided, or fails.
    pub undecided: f64,
    /// The audit of the map behind it.
    pub lookups: Lookups,
}

impl SurfaceRow {
    /// The share of samples without a verdict, undecided or failed.
    pub fn unknown_share(&self) -> f64 {
        let counted = (self.counts.undecided + self.counts.failed) as f64 / self.counts.total().max(1) as f64;
        self.integrated.map_or(counted, |integrated| integrated.undecided)
    }
}

/// The result of a job.
#[derive(Debug)]
pub struct Surface<'a> {
    job: &'a Job,
    tally: &'a Tally,
    /// One for each cell where probabilities are integrated, else none.
    integrated: &'a [IntegratedCell],
    slots: Slots,
    extras: Extras,
    /// With looks, the estimate of each cell: rows are made more than once.
    at_stop: OnceCell<Vec<Estimate>>,
}

/// A column: name, unit, meaning, and its values.
struct Column {
    name: Cow<'static, str>,
    unit: Cow<'static, str>,
    long_name: Cow<'static, str>,
    values: Values,
}

enum Values {
    Integer(Read<u64>),
    Real(Read<f64>),
    OptionalReal(Read<Option<f64>>),
}

/// A value of a row.
type Read<T> = Box<dyn Fn(&SurfaceRow) -> T>;

impl Column {
    fn new(
        name: impl Into<Cow<'static, str>>,
        unit: impl Into<Cow<'static, str>>,
        long_name: impl Into<Cow<'static, str>>,
        values: Values,
    ) -> Self {
        Self { name: name.into(), unit: unit.into(), long_name: long_name.into(), values }
    }

    fn integer(name: &'static str, long_name: &'static str, value: impl Fn(&SurfaceRow) -> u64 + 'static) -> Self {
        Self::new(name, "1", long_name, Values::Integer(Box::new(value)))
    }

    fn real(name: &'static str, long_name: &'static str, value: impl Fn(&SurfaceRow) -> f64 + 'static) -> Self {
        Self::new(name, "1", long_name, Values::Real(Box::new(value)))
    }

    fn optional(
        name: impl Into<Cow<'static, str>>,
        long_name: impl Into<Cow<'static, str>>,
        value: impl Fn(&SurfaceRow) -> Option<f64> + 'static,
    ) -> Self {
        Self::new(name, "1", long_name, Values::OptionalReal(Box::new(value)))
    }
}

/// The columns of every surface.
#[rustfmt::skip]
fn columns() -> Vec<Column> {
    vec![
        Column::integer("cell", "0-based index of the cell", |row| row.cell.index),
        Column::new("rotating_speed_rad_s", "rad/s", "rotating speed of the disc", Values::Real(Box::new(|row| row.cell.rotating_speed))),
        Column::real("std_preload", "standard deviation of the preload over its expected value", |row| row.cell.relative_std.preload),
        Column::real("std_static_friction", "standard deviation of the static friction coefficient over its expected value", |row| row.cell.relative_std.static_friction),
        Column::real("preload", "expected preload, calliper displacement over disc thickness", |row| row.cell.preload),
        Column::real("static_friction", "expected static friction coefficient", |row| row.cell.static_friction),
        Column::integer("n_samples", "samples", |row| row.counts.total()),
        Column::integer("n_stable", "samples judged stable", |row| row.counts.stable),
        Column::integer("n_unstable", "samples judged unstable", |row| row.counts.unstable),
        Column::integer("n_undecided", "samples without a certain verdict", |row| row.counts.undecided),
        Column::integer("n_failed", "samples whose computation broke down", |row| row.counts.failed),
        Column::optional("p_unstable", "probability of instability: unstable over decided samples; with until the unbiased estimate, by integration the integral", |row| row.estimate.probability),
        Column::real("p_low", "lower end of the confidence interval of the probability", |row| row.estimate.low),
        Column::real("p_high", "upper end of the confidence interval of the probability", |row| row.estimate.high),
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
        Column::integer("n_simulated", "samples that the verdict map does not tell, and that were simulated", |row| {
            row.lookups.simulated
        }),
        Column::integer("n_audited", "samples that were looked up and simulated all the same", |row| {
            row.lookups.audited
        }),
        Column::integer("n_audit_differed", "audited samples that were judged otherwise than looked up", |row| {
            row.lookups.differed
        }),
        Column::optional(
            "p_audit",
            "probability of samples whose looked-up verdict the audit does not exclude to be wrong; p_low and p_high contain it",
            |row| row.unaudited,
        ),
    ]
}

/// Columns of jobs on a flexible disc: what feeds the unstable samples.
fn source_columns(extras: Extras) -> Vec<Column> {
    let column = |name, meaning, source| {
        Column::integer(name, meaning, move |row: &SurfaceRow| {
            extras.read_source(&row.sums, source, row.counts.unstable)
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

/// Columns of jobs with derivatives: exact where probabilities are integrated, else with their standard errors.
fn derivative_columns(extras: Extras, integrated: bool) -> Vec<Column> {
    let numbers = [
        (CellNumber::Preload, "dp_dpreload", "expected preload at constant relative standard deviation"),
        (
            CellNumber::StaticFriction,
            "dp_dstatic_friction",
            "expected static friction coefficient at constant relative standard deviation",
        ),
        (CellNumber::StdPreload, "dp_dstd_preload", "relative standard deviation of the preload"),
        (
            CellNumber::StdStaticFriction,
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
                    CellNumber::Preload => derivatives.preload,
                    CellNumber::StaticFriction => derivatives.static_friction,
                    CellNumber::StdPreload => derivatives.std_preload,
                    CellNumber::StdStaticFriction => derivatives.std_static_friction,
                })
            }));
            continue;
        }
        let read = move |row: &SurfaceRow| {
            extras.read_derivative(&row.sums, number, &row.cell, &row.counts, row.estimate.probability)
        };
        columns.push(Column::optional(name, long_name, move |row| read(row).map(|(value, _)| value)));
        columns.push(Column::optional(format!("{name}_error"), format!("standard error of {name}"), move |row| {
            read(row).map(|(_, error)| error)
        }));
    }
    columns
}

/// Columns of jobs with Sobol indices.
fn sensitivity_columns(extras: Extras, inputs: &[RandomInput]) -> Vec<Column> {
    let mut columns = Vec::new();
    for (i, input) in inputs.iter().enumerate() {
        let name = input.name();
        let read = move |row: &SurfaceRow| extras.read_sensitivity(&row.sums, i);
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
            Values::Integer(Box::new(move |row| extras.read_left_out(&row.sums, i))),
        ));
    }
    columns
}

/// Adds what the first columns do not say of the inputs: expected value and standard deviation of those other than preload
/// and static friction; mean and standard deviation of those that are truncated, whose other columns are named parameters.
fn add_input_columns(columns: &mut Vec<Column>, job: &Job) {
    for (i, (&input, marginal)) in job.random.inputs.iter().zip(&job.random.marginals).enumerate() {
        let name = input.name();
        let stds: Vec<f64> = job.random.relative_stds.iter().map(|stds| stds[i]).collect();
        let grid = job.grid.clone();
        let std = move |cell: &Cell| stds[grid.relative_std_index(cell.index)];
        let mut expected_column = name;
        let unit = match input {
            RandomInput::Preload | RandomInput::StaticFriction => "1",
            RandomInput::Other(scalar) => {
                if input.is_rotating_speed() {
                    expected_column = "rotating_speed_rad_s";
                } else {
                    let value = scalar.value(&job.parameters);
                    let long_name = format!("expected value of {name}: {}", scalar.description);
                    columns.push(Column::new(name, scalar.unit, long_name, Values::Real(Box::new(move |_| value))));
                }
                let (of_cell, long_name) =
                    (std.clone(), format!("standard deviation of {name} over its expected value"));
                let read = Values::Real(Box::new(move |row| of_cell(&row.cell)));
                columns.push(Column::new(format!("std_{name}"), "1", long_name, read));
                scalar.unit
            }
        };
        if !matches!(marginal, Marginal::TruncatedNormal { .. }) {
            continue;
        }
        let (marginal, parameters) = (marginal.clone(), job.parameters.clone());
        let moments = move |row: &SurfaceRow| marginal.moments(input.expected(&row.cell, &parameters), std(&row.cell));
        let means = moments.clone();
        let (mean_name, scatter_name) = (format!("mean_{name}"), format!("scatter_{name}"));
        for (column, instead) in [(expected_column, &mean_name), (&format!("std_{name}"), &scatter_name)] {
            if let Some(column) = columns.iter_mut().find(|other| other.name == column) {
                let long_name = &column.long_name;
                column.long_name =
                    format!("{long_name}, before it is truncated: a parameter of its distribution, see {instead}")
                        .into();
            }
        }
        let long_name = format!("mean of {name}, which is truncated");
        columns.push(Column::new(mean_name, unit, long_name, Values::Real(Box::new(move |row| means(row).0))));
        let long_name = format!("standard deviation of {name}, which is truncated, over its mean");
        columns.push(Column::optional(scatter_name, long_name, move |row| {
            let (mean, std) = moments(row);
            (mean > 0.0).then_some(std / mean)
        }));
    }
}

impl Column {
    fn field(&self) -> Field {
        let (data_type, nullable) = match &self.values {
            Values::Integer(_) => (DataType::Int64, false),
            Values::Real(_) => (DataType::Float64, false),
            Values::OptionalReal(_) => (DataType::Float64, true),
        };
        described_field(&self.name, &self.unit, &self.long_name, data_type, nullable)
    }

    fn array(&self, rows: &[SurfaceRow]) -> ArrayRef {
        match &self.values {
            // Counts stay far below 2^63, see the limit on samples.
            Values::Integer(value) => Arc::new(rows.iter().map(|row| value(row).cast_signed()).collect::<Int64Array>()),
            Values::Real(value) => Arc::new(rows.iter().map(|row| Some(value(row))).collect::<Float64Array>()),
            Values::OptionalReal(value) => Arc::new(rows.iter().map(value).collect::<Float64Array>()),
        }
    }
}

impl<'a> Surface<'a> {
    /// The surface of a run in its present state.
    pub fn new(job: &'a Job, tally: &'a Tally) -> Self {
        Self { job, tally, integrated: &[], slots: Slots::new(job), extras: Extras::of(job), at_stop: OnceCell::new() }
    }

    /// The surface of a job that integrates, one probability for each cell.
    pub fn integrated(job: &'a Job, tally: &'a Tally, integrated: &'a [IntegratedCell]) -> Self {
        Self { integrated, ..Self::new(job, tally) }
    }

    /// The job behind it.
    pub fn job(&self) -> &Job {
        self.job
    }

    /// The row of one cell.
    pub fn row(&self, cell: u64) -> SurfaceRow {
        let counts = self.slots.counts(self.tally, cell);
        let mut amplitudes = Distribution::default();
        let mut sums = Vec::new();
        for slot in self.slots.of(cell) {
            amplitudes.add_all(self.tally.amplitudes(slot));
            add_sums(&mut sums, self.tally.sums(slot));
        }
        let integrated = self.integrated.get(cell as usize).copied();
        let lookups = integrated.map_or_else(|| self.extras.read_lookups(&sums), |integrated| integrated.lookups);
        // With a map that was given up, or audited as a whole, every sample was simulated.
        let is_audited = self.job.sampling.is_audited && lookups.simulated + lookups.audited < counts.total();
        let confidence = self.job.confidence(is_audited);
        let counted =
            integrated.map_or_else(|| self.estimate(cell, &counts, confidence), |integrated| integrated.estimate);
        let unaudited =
            self.job.sampling.is_audited.then(|| {
                unaudited(&lookups, integrated.is_none().then_some(counts.total()), self.job.audit_confidence())
            });
        SurfaceRow {
            cell: self.job.grid.cell(cell),
            counts,
            estimate: widened(&counted, unaudited.unwrap_or(0.0)),
            unaudited,
            amplitudes,
            lookups,
            sums,
            integrated,
        }
    }

    /// The probability of a cell, and the interval that its counts give at a confidence.
    fn estimate(&self, cell: u64, counts: &VerdictCounts, confidence: f64) -> Estimate {
        match self.job.sampling.effort {
            Effort::Samples(_) | Effort::Integrated => self.job.interval(confidence).estimate(counts),
            Effort::Randomisations { .. } => {
                let parts: Vec<VerdictCounts> = self.slots.of(cell).map(|slot| self.tally.counts(slot)).collect();
                replicates::estimate(&parts, self.job.random.inputs.len(), confidence)
            }
            Effort::Until(_) => {
                let nothing = Estimate { probability: None, low: 0.0, high: 1.0 };
                let of_cell = |cell| self.slots.estimate_at_stop(self.tally, cell).unwrap_or(nothing);
                self.at_stop.get_or_init(|| (0..self.job.cells()).map(of_cell).collect())[cell as usize]
            }
        }
    }

    /// The largest probability that a sample is undecided, where probabilities are integrated.
    pub fn largest_undecided(&self) -> f64 {
        self.integrated.iter().map(|cell| cell.undecided).fold(0.0, f64::max)
    }

    /// How the samples of all cells were judged, where they are looked up in a map.
    pub fn lookups(&self) -> Lookups {
        let mut lookups = Lookups::default();
        for slot in 0..self.slots.count() {
            lookups.add(self.extras.read_lookups(self.tally.sums(slot)));
        }
        self.integrated.iter().for_each(|cell| lookups.add(cell.lookups));
        lookups
    }

    /// All rows, in order.
    pub fn rows(&self) -> impl Iterator<Item = SurfaceRow> + '_ {
        (0..self.job.cells()).map(|cell| self.row(cell))
    }

    /// Writes `surface.parquet` into `directory`, whole or not at all. Returns false if the same bytes are there
    /// already.
    pub fn publish(&self, directory: &Path) -> Result<bool, Failure> {
        let target = directory.join("surface.parquet");
        // The same bytes may be there already; a hash tells without holding them.
        let present = hash_of_file(&target).map_err(|error| Failure::reading(&target, error))?;
        let written = || -> Result<bool, ParquetError> {
            if let Some(present) = present
                && present == self.encode(blake3::Hasher::new())?.finalize()
            {
                return Ok(false);
            }
            publish_with(directory, "surface.parquet", |file| -> Result<(), ParquetError> {
                self.encode(BufWriter::new(file))?.flush()?;
                Ok(())
            })?;
            Ok(true)
        };
        written().map_err(|error| Failure::writing(&target, error))
    }

    fn columns(&self) -> Vec<Column> {
        let mut columns = columns();
        if self.job.records_amplitude() {
            columns.extend(amplitude_columns());
        }
        if self.job.is_integrated() && self.job.uses_maps() {
            let meaning = "probability that a sample is undecided, or fails";
            columns.push(Column::optional("p_undecided", meaning, |row| Some(row.integrated?.undecided)));
        }
        if self.extras.lookups() || (self.job.is_integrated() && self.job.sampling.is_audited) {
            columns.extend(lookup_columns());
        }
        if self.extras.sources() {
            columns.extend(source_columns(self.extras));
        }
        if self.extras.derivatives() {
            columns.extend(derivative_columns(self.extras, self.job.sampling.method == SamplingMethod::Exact));
        }
        if self.extras.sensitivity() > 0 {
            columns.extend(sensitivity_columns(self.extras, &self.job.random.inputs));
        }
        add_input_columns(&mut columns, self.job);
        columns
    }

    fn encode<W: Write + Send>(&self, out: W) -> Result<W, ParquetError> {
        let columns = self.columns();
        let schema = Arc::new(Schema::new(columns.iter().map(Column::field).collect::<Vec<_>>()));
        let mut writer = ArrowWriter::try_new(out, schema.clone(), Some(self.properties()))?;
        let cells = self.job.cells();
        let mut first = 0;
        while first < cells {
            let end = cells.min(first + BATCH_ROWS);
            let rows: Vec<SurfaceRow> = (first..end).map(|cell| self.row(cell)).collect();
            let arrays = columns.iter().map(|column| column.array(&rows)).collect();
            writer.write(&RecordBatch::try_new(schema.clone(), arrays)?)?;
            writer.flush()?;
            first = end;
        }
        writer.into_inner()
    }

    /// The footer: the job and what makes its values, and nothing that differs between two runs of one job.
    fn properties(&self) -> WriterProperties {
        let mut footer = vec![
            ("stickslip:job", self.job.normalised()),
            (JOB_HASH_KEY, self.job.hash()),
            ("stickslip:seed", self.job.sampling.seed.to_string()),
            ("stickslip:engine_version", env!("CARGO_PKG_VERSION").to_owned()),
            ("stickslip:results_version", RESULTS_VERSION.to_string()),
        ];
        if self.job.has_later_estimates() {
            footer.push(("stickslip:estimates_version", ESTIMATES_VERSION.to_string()));
        }
        let pairs = footer.into_iter().map(|(key, value)| KeyValue::new(key.to_owned(), value)).collect();
        WriterProperties::builder().set_compression(Compression::SNAPPY).set_key_value_metadata(Some(pairs)).build()
    }
}

/// The share of a cell whose looked-up verdicts may be wrong, as far as the audit does not exclude it. Of `samples` in all,
/// those that were simulated are right; an integral has none.
pub fn unaudited(lookups: &Lookups, samples: Option<u64>, confidence: f64) -> f64 {
    let looked_up = samples.map_or(1.0, |samples| {
        samples.saturating_sub(lookups.simulated + lookups.audited) as f64 / samples.max(1) as f64
    });
    looked_up * audit::upper_bound(lookups.differed, lookups.audited, confidence)
}

/// An estimate if so large a share of the samples may have the other verdict.
pub fn widened(estimate: &Estimate, by: f64) -> Estimate {
    Estimate { low: (estimate.low - by).max(0.0), high: (estimate.high + by).min(1.0), ..*estimate }
}

fn add_sums(total: &mut Vec<i128>, sums: &[i128]) {
    total.resize(total.len().max(sums.len()), 0);
    total.iter_mut().zip(sums).for_each(|(total, sum)| *total += sum);
}

/// A field that says its unit and meaning.
pub fn described_field(name: &str, unit: &str, long_name: &str, data_type: DataType, nullable: bool) -> Field {
    let pairs = [("unit", unit), ("long_name", long_name)];
    let metadata: HashMap<String, String> = pairs.map(|(key, text)| (key.to_owned(), text.to_owned())).into();
    Field::new(name, data_type, nullable).with_metadata(metadata)
}

/// A column of real numbers beside the surface, for figures.
pub struct DescribedColumn {
    /// Name.
    pub name: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Meaning.
    pub long_name: &'static str,
    /// Values.
    pub values: Vec<f64>,
}

/// Writes columns of equal length as `name` into `directory`, whole or not at all.
pub fn write_columns(directory: &Path, name: &str, columns: &[DescribedColumn]) -> Result<(), Failure> {
    let field = |c: &DescribedColumn| described_field(c.name, c.unit, c.long_name, DataType::Float64, false);
    let array = |c: &DescribedColumn| -> ArrayRef { Arc::new(Float64Array::from(c.values.clone())) };
    let (fields, arrays) = (columns.iter().map(field).collect(), columns.iter().map(array).collect());
    write_batch(directory, name, fields, arrays, None)
}

/// Writes one batch of columns as a file of its own, whole or not at all.
fn write_batch(
    directory: &Path,
    name: &str,
    fields: Vec<Field>,
    arrays: Vec<ArrayRef>,
    footer: Option<Vec<KeyValue>>,
) -> Result<(), Failure> {
    let encoded = (|| {
        let schema = Arc::new(Schema::new(fields));
        let batch = RecordBatch::try_new(schema.clone(), arrays)?;
        let properties =
            WriterProperties::builder().set_compression(Compression::SNAPPY).set_key_value_metadata(footer).build();
        let mut writer = ArrowWriter::try_new(Vec::new(), schema, Some(properties))?;
        writer.write(&batch)?;
        writer.into_inner()
    })();
    let bytes = encoded.map_err(|error: ParquetError| Failure::writing(&directory.join(name), error))?;
    publish(directory, name, &bytes)
}

/// The values of a [`TableColumn`].
pub enum TableValues {
    /// Counts and indices.
    Integer(Vec<u64>),
    /// Numbers that may be unknown.
    Real(Vec<Option<f64>>),
    /// Names.
    Text(Vec<String>),
}

/// A column of any type in a file of its own.
pub struct TableColumn {
    /// Name.
    pub name: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Meaning.
    pub long_name: &'static str,
    /// Values.
    pub values: TableValues,
}

impl TableColumn {
    fn field(&self) -> Field {
        let (data_type, nullable) = match &self.values {
            TableValues::Integer(_) => (DataType::Int64, false),
            TableValues::Real(_) => (DataType::Float64, true),
            TableValues::Text(_) => (DataType::Utf8, false),
        };
        described_field(self.name, self.unit, self.long_name, data_type, nullable)
    }

    fn array(&self) -> ArrayRef {
        match &self.values {
            TableValues::Integer(values) => {
                Arc::new(values.iter().map(|value| value.cast_signed()).collect::<Int64Array>())
            }
            TableValues::Real(values) => Arc::new(Float64Array::from(values.clone())),
            TableValues::Text(values) => Arc::new(StringArray::from_iter_values(values)),
        }
    }
}

/// Writes a table of columns of equal length as `name` into `directory`, whole or not at all, with pairs of key and value
/// in its footer.
pub fn write_table(
    directory: &Path,
    name: &str,
    columns: &[TableColumn],
    footer: &[(&str, String)],
) -> Result<(), Failure> {
    let pairs = footer.iter().map(|(key, value)| KeyValue::new((*key).to_owned(), value.clone())).collect();
    let fields = columns.iter().map(TableColumn::field).collect();
    write_batch(directory, name, fields, columns.iter().map(TableColumn::array).collect(), Some(pairs))
}

/// The job that a surface on disk says it is of; `None` if there is none, or none that can be read.
pub fn job_hash_of_file(path: &Path) -> Option<String> {
    let reader = SerializedFileReader::new(File::open(path).ok()?).ok()?;
    let pairs = reader.metadata().file_metadata().key_value_metadata()?;
    pairs.iter().find(|pair| pair.key == JOB_HASH_KEY)?.value.clone()
}

/// The hash of a file's content, if there is one.
fn hash_of_file(path: &Path) -> io::Result<Option<blake3::Hash>> {
    if !path.is_file() {
        return Ok(None);
    }
    let mut hasher = blake3::Hasher::new();
    io::copy(&mut File::open(path)?, &mut hasher)?;
    Ok(Some(hasher.finalize()))
}
