//! `surface.parquet`: one row for each cell, sorted by cell.

use std::collections::HashMap;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::sync::Arc;

use arrow::array::{ArrayRef, Float64Array, Int64Array, RecordBatch};
use arrow::datatypes::{DataType, Field, Schema};
use parquet::arrow::ArrowWriter;
use parquet::basic::Compression;
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::FileReader as _;
use parquet::file::serialized_reader::SerializedFileReader;
use stickslip_core::VerdictCounts;
use stickslip_sampler::{Cell, Distribution, Estimate, RESULTS_VERSION, WilsonInterval};

use super::publish::{publish, publish_with};
use super::tally::Tally;
use crate::failure::Failure;
use crate::job::Job;

/// Rows that are held in memory at once; also the size of a row group.
const BATCH_ROWS: u64 = 65_536;

const JOB_HASH_KEY: &str = "stickslip:job_hash";

/// One row of the result.
#[derive(Debug, Clone, Copy)]
pub struct SurfaceRow<'a> {
    /// Expected values and scatter.
    pub cell: Cell,
    /// Verdicts.
    pub counts: VerdictCounts,
    /// Probability and interval.
    pub estimate: Estimate,
    /// Settled amplitudes of the unstable samples, if the job records them.
    pub amplitudes: &'a Distribution,
}

/// The result of a job.
#[derive(Debug)]
pub struct Surface<'a> {
    job: &'a Job,
    tally: &'a Tally,
    interval: WilsonInterval,
}

/// A column: name, unit, meaning, and its values.
struct Column {
    name: &'static str,
    unit: &'static str,
    long_name: &'static str,
    values: Values,
}

enum Values {
    Integer(fn(&SurfaceRow<'_>) -> u64),
    Real(fn(&SurfaceRow<'_>) -> f64),
    OptionalReal(fn(&SurfaceRow<'_>) -> Option<f64>),
}

#[rustfmt::skip]
static COLUMNS: [Column; 14] = [
    Column { name: "cell", unit: "1", long_name: "0-based index of the cell", values: Values::Integer(|row| row.cell.index) },
    Column { name: "rotating_speed_rad_s", unit: "rad/s", long_name: "rotating speed of the disc", values: Values::Real(|row| row.cell.rotating_speed) },
    Column { name: "std_preload", unit: "1", long_name: "standard deviation of the preload over its expected value", values: Values::Real(|row| row.cell.relative_std.preload) },
    Column { name: "std_static_friction", unit: "1", long_name: "standard deviation of the static friction coefficient over its expected value", values: Values::Real(|row| row.cell.relative_std.static_friction) },
    Column { name: "preload", unit: "1", long_name: "expected preload, calliper displacement over disc thickness", values: Values::Real(|row| row.cell.preload) },
    Column { name: "static_friction", unit: "1", long_name: "expected static friction coefficient", values: Values::Real(|row| row.cell.static_friction) },
    Column { name: "n_samples", unit: "1", long_name: "samples", values: Values::Integer(|row| row.counts.total()) },
    Column { name: "n_stable", unit: "1", long_name: "samples judged stable", values: Values::Integer(|row| row.counts.stable) },
    Column { name: "n_unstable", unit: "1", long_name: "samples judged unstable", values: Values::Integer(|row| row.counts.unstable) },
    Column { name: "n_undecided", unit: "1", long_name: "samples without a certain verdict", values: Values::Integer(|row| row.counts.undecided) },
    Column { name: "n_failed", unit: "1", long_name: "samples whose computation broke down", values: Values::Integer(|row| row.counts.failed) },
    Column { name: "p_unstable", unit: "1", long_name: "probability of instability, unstable over decided samples", values: Values::OptionalReal(|row| row.estimate.probability) },
    Column { name: "p_low", unit: "1", long_name: "lower end of the confidence interval of the probability", values: Values::Real(|row| row.estimate.low) },
    Column { name: "p_high", unit: "1", long_name: "upper end of the confidence interval of the probability", values: Values::Real(|row| row.estimate.high) },
];

/// Columns of jobs that record the settled amplitude, after all others.
#[rustfmt::skip]
static AMPLITUDE_COLUMNS: [Column; 4] = [
    Column { name: "amplitude_mean", unit: "1", long_name: "mean settled amplitude of the unstable samples, half peak to peak of x over disc thickness", values: Values::OptionalReal(|row| row.amplitudes.mean()) },
    Column { name: "amplitude_p05", unit: "1", long_name: "settled amplitude that 5 % of the unstable samples do not exceed", values: Values::OptionalReal(|row| row.amplitudes.quantile(0.05)) },
    Column { name: "amplitude_p50", unit: "1", long_name: "median settled amplitude of the unstable samples", values: Values::OptionalReal(|row| row.amplitudes.quantile(0.5)) },
    Column { name: "amplitude_p95", unit: "1", long_name: "settled amplitude that 95 % of the unstable samples do not exceed", values: Values::OptionalReal(|row| row.amplitudes.quantile(0.95)) },
];

impl Column {
    fn field(&self) -> Field {
        let (data_type, nullable) = match self.values {
            Values::Integer(_) => (DataType::Int64, false),
            Values::Real(_) => (DataType::Float64, false),
            Values::OptionalReal(_) => (DataType::Float64, true),
        };
        described_field(self.name, self.unit, self.long_name, data_type, nullable)
    }

    fn array(&self, rows: &[SurfaceRow<'_>]) -> ArrayRef {
        match self.values {
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
        Self { job, tally, interval: job.interval() }
    }

    /// The job behind it.
    pub fn job(&self) -> &Job {
        self.job
    }

    /// The row of one cell.
    pub fn row(&self, cell: u64) -> SurfaceRow<'a> {
        let counts = self.tally.counts(cell);
        SurfaceRow {
            cell: self.job.grid.cell(cell),
            counts,
            estimate: self.interval.estimate(&counts),
            amplitudes: self.tally.amplitudes(cell),
        }
    }

    /// All rows, in order.
    pub fn rows(&self) -> impl Iterator<Item = SurfaceRow<'a>> + '_ {
        (0..self.job.cells()).map(|cell| self.row(cell))
    }

    /// Writes `surface.parquet` into `directory`, whole or not at all. Returns false if the same bytes are there
    /// already.
    pub fn publish(&self, directory: &Path) -> Result<bool, Failure> {
        let target = directory.join("surface.parquet");
        let written = || -> Result<bool, ParquetError> {
            // The same bytes may be there already; a hash tells without holding them.
            if let Some(present) = hash_of_file(&target)?
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

    fn columns(&self) -> impl Iterator<Item = &'static Column> {
        let more: &[Column] = if self.job.records_amplitude() { &AMPLITUDE_COLUMNS } else { &[] };
        COLUMNS.iter().chain(more)
    }

    fn encode<W: Write + Send>(&self, out: W) -> Result<W, ParquetError> {
        let schema = Arc::new(Schema::new(self.columns().map(Column::field).collect::<Vec<_>>()));
        let mut writer = ArrowWriter::try_new(out, schema.clone(), Some(self.properties()))?;
        let cells = self.job.cells();
        let mut first = 0;
        while first < cells {
            let end = cells.min(first + BATCH_ROWS);
            let rows: Vec<SurfaceRow<'_>> = (first..end).map(|cell| self.row(cell)).collect();
            let columns = self.columns().map(|column| column.array(&rows)).collect();
            writer.write(&RecordBatch::try_new(schema.clone(), columns)?)?;
            writer.flush()?;
            first = end;
        }
        writer.into_inner()
    }

    /// The footer: the job and what makes its values, and nothing that differs between two runs of one job.
    fn properties(&self) -> WriterProperties {
        let footer = [
            ("stickslip:job", self.job.normalised()),
            (JOB_HASH_KEY, self.job.hash()),
            ("stickslip:seed", self.job.seed.to_string()),
            ("stickslip:engine_version", env!("CARGO_PKG_VERSION").to_owned()),
            ("stickslip:results_version", RESULTS_VERSION.to_string()),
        ];
        let pairs = footer.map(|(key, value)| KeyValue::new(key.to_owned(), value)).to_vec();
        WriterProperties::builder().set_compression(Compression::SNAPPY).set_key_value_metadata(Some(pairs)).build()
    }
}

/// A field that says its unit and meaning.
fn described_field(name: &str, unit: &str, long_name: &str, data_type: DataType, nullable: bool) -> Field {
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
    let encoded = (|| {
        let field = |c: &DescribedColumn| described_field(c.name, c.unit, c.long_name, DataType::Float64, false);
        let schema = Arc::new(Schema::new(columns.iter().map(field).collect::<Vec<_>>()));
        let array = |c: &DescribedColumn| -> ArrayRef { Arc::new(Float64Array::from(c.values.clone())) };
        let batch = RecordBatch::try_new(schema.clone(), columns.iter().map(array).collect())?;
        let properties = WriterProperties::builder().set_compression(Compression::SNAPPY).build();
        let mut writer = ArrowWriter::try_new(Vec::new(), schema, Some(properties))?;
        writer.write(&batch)?;
        writer.into_inner()
    })();
    let bytes = encoded.map_err(|error: ParquetError| Failure::writing(&directory.join(name), error))?;
    publish(directory, name, &bytes)
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
