//! Arguments of the commands that answer how large, how likely and how sure: `fit`, `limit` and `bounds`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::threads::ThreadsArgument;
use super::values::{parquet_file, probability};

/// Arguments of `fit`.
#[derive(Debug, Args)]
pub struct FitArguments {
    /// The tests: a CSV file with the columns rotating_speed, preload, squealed and perhaps count, or onset_speed, preload
    /// and perhaps censored
    #[arg(value_name = "DATA.csv")]
    pub data: PathBuf,
    /// The job whose brake was tested; - reads it from standard input
    #[arg(long, value_name = "JOB.toml")]
    pub job: PathBuf,
    /// What to estimate, separated by commas; the rest is taken from the job
    #[arg(
        long,
        value_name = "LIST",
        value_enum,
        value_delimiter = ',',
        default_values = ["static_friction", "std.static_friction"]
    )]
    pub estimate: Vec<EstimateArgument>,
    /// Write a job with the estimates in place
    #[arg(long, value_name = "NEW_JOB.toml")]
    pub out: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// What may be estimated from tests.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum EstimateArgument {
    /// The expected static friction coefficient
    #[value(name = "static_friction")]
    StaticFriction,
    /// The true preload over the nominal one
    #[value(name = "preload_factor")]
    PreloadFactor,
    /// The relative standard deviation of the preload
    #[value(name = "std.preload")]
    PreloadStd,
    /// The relative standard deviation of the static friction coefficient
    #[value(name = "std.static_friction")]
    StaticFrictionStd,
    /// The correlation of both
    #[value(name = "correlation")]
    Correlation,
}

/// Arguments of `limit`.
#[derive(Debug, Args)]
pub struct LimitArguments {
    /// The job spec (- reads it from standard input), or a run directory
    #[arg(value_name = "JOB.toml|RUN_DIR")]
    pub job: PathBuf,
    /// The axis whose values are sought: preload, static_friction, rotating_speed or a parameter of the brake [default: that
    /// of the job's table limit]
    #[arg(long, value_name = "NAME")]
    pub of: Option<String>,
    /// The probability of instability that must not be exceeded, above 0 and below 1; may be repeated [default: those of
    /// the job's table limit]
    #[arg(long = "probability", value_name = "P", value_parser = probability, allow_negative_numbers = true)]
    pub probabilities: Vec<f64>,
    /// Write one row for each limit to a Parquet file
    #[arg(long, value_name = "FILE.parquet", value_parser = parquet_file)]
    pub out: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub threads: ThreadsArgument,
}

/// Arguments of `bounds`.
#[derive(Debug, Args)]
pub struct BoundsArguments {
    /// The job spec, with values that are { between = [LOW, HIGH] } or { one_of = [A, B] }; - reads it from standard input
    #[arg(value_name = "JOB.toml")]
    pub job: PathBuf,
    /// Write one row for each cell to a Parquet file
    #[arg(long, value_name = "FILE.parquet", value_parser = parquet_file)]
    pub out: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub threads: ThreadsArgument,
}
