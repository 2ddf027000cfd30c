//! Arguments of `limit`.

use std::path::PathBuf;

use clap::Args;

use super::threads::ThreadsArgument;
use super::values::{parquet_file, probability};

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
    /// Write one row for each limit to a Parquet file; if it is interrupted, the same command goes on
    #[arg(long, value_name = "FILE.parquet", value_parser = parquet_file)]
    pub out: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub threads: ThreadsArgument,
}
