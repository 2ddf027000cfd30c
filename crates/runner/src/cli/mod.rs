//! The command line.

mod values;

mod threads;

mod engine;

mod limit;

mod start;

mod pad_on_disc;

mod reduction;

mod plot;

mod words;

mod asked;

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use clap_complete::Shell;

pub use self::asked::AskedArguments;
pub use self::engine::{EngineArguments, EngineKind};
pub use self::limit::LimitArguments;
pub use self::pad_on_disc::{
    AllotmentArgument, AnalyseArguments, BrakeArguments, DiscArgument, EstimateArgument, FitArguments, MotionArguments,
    ParametersArguments, TrajectoryArguments,
};
pub use self::plot::{PlotArguments, PlotQuantity};
pub use self::reduction::ReduceArguments;
pub use self::start::StartArgument;
pub use self::threads::ThreadsArgument;
use self::values::{html_file, number, parquet_file, seed, whole_number};
pub use self::words::other_word;
use crate::export::format::Format;
use crate::messages::Form;
use crate::schedule::plan::Shard;
use crate::target::Target;
use crate::version;

/// Probability that a brake pad sticks and slips, by parallel Monte Carlo.
#[derive(Debug, Parser)]
#[command(name = "stickslip", version, long_version = version::in_full(), about, max_term_width = 110)]
#[command(after_help = "Exit codes: 0 done; 64 usage; 65 bad job spec, or a job that differs from the run's; \
    70 an audit found that the verdict map is wrong somewhere (the result is written), or an internal error; 73 cannot create output; 74 I/O error; 75 the run directory is in use; 128 + number ended by \
    a signal, such as 130 by Ctrl-C (finished work is kept).")]
pub struct Cli {
    /// How messages on standard error are written: lines for people, or one JSON object a line for programs
    #[arg(long, global = true, value_enum, value_name = "FORM", default_value = "text", display_order = 900)]
    pub messages: Form,
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Write an example job, or one of those that come with the program
    Init(InitArguments),
    /// Run a job and write its probability surface
    Submit(SubmitArguments),
    /// Continue a run that was interrupted
    Resume(ResumeArguments),
    /// Show the progress of a run, or of every run in a folder
    Status(StatusArguments),
    /// Validate a job, and say its cells, samples and expected cost
    Check(CheckArguments),
    /// List the parameters of the brake: symbols, units, ranges, values
    Parameters(ParametersArguments),
    /// Analyse one brake: equilibrium, eigenvalues, critical values
    Analyse(AnalyseArguments),
    /// Simulate one motion: time series and summary
    Trajectory(TrajectoryArguments),
    /// Compute one sample of a run again: inputs, verdict, trajectory
    Replay(ReplayArguments),
    /// Write every sample of a cell: its random inputs and its verdict
    Samples(SamplesArguments),
    /// Compare finished runs, cell by cell and sample by sample
    Compare(CompareArguments),
    /// Estimate the scatter of friction and preload from brake tests
    Fit(FitArguments),
    /// Find where along an axis the probability passes a target
    Limit(LimitArguments),
    /// Reduce the matrices of a job, and say what that costs
    Reduce(ReduceArguments),
    /// Draw a result, the inputs of a job or a motion, as SVG, PDF, PNG
    Plot(PlotArguments),
    /// Write a report of finished runs, one interactive HTML file
    Report(ReportArguments),
    /// Write the surface of a finished run as CSV, JSON, MAT or NPZ
    Export(ExportArguments),
    /// Reproduce tables and figures of Sui & Ding (2018)
    Reproduce(ReproduceArguments),
    /// Write the surface from the pieces of finished shards
    Merge(MergeArguments),
    /// Check the files of a run, and write again what can be
    Verify(VerifyArguments),
    /// Print the JSON schema of job specs
    Schema,
    /// Print a completion script for a shell
    Completions(CompletionsArguments),
    /// Print the manual page, or write a page for each command
    Man(ManArguments),
}

/// Arguments of `init`.
#[derive(Debug, Args)]
pub struct InitArguments {
    /// The file to write, which must not exist; - writes to standard output [default: job.toml, with --from NAME.toml]
    #[arg(value_name = "FILE")]
    pub file: Option<PathBuf>,
    /// Write one of the jobs that come with the program, with the files that it names
    #[arg(long, value_name = "NAME")]
    pub from: Option<String>,
    /// List the jobs that come with the program
    #[arg(long, conflicts_with_all = ["file", "from"])]
    pub list: bool,
}

/// Arguments of `submit`.
#[derive(Debug, Args)]
pub struct SubmitArguments {
    /// The job spec; - reads it from standard input
    #[arg(value_name = "JOB.toml")]
    pub job: PathBuf,
    /// Run directory [default: runs/NAME]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Where the run directory holds a run of another job, use one beside it with a digest of this job in its name
    #[arg(long, conflicts_with_all = ["overwrite", "shard", "engine"])]
    pub apart: bool,
    /// Remove the run that the directory holds, of whatever job, with its pictures, reports and exports, and compute
    /// anew
    #[arg(long, conflicts_with_all = ["shard", "engine"])]
    pub overwrite: bool,
    #[command(flatten)]
    pub threads: ThreadsArgument,
    /// Seed of the random numbers, 0 to 2^63 - 1, in place of the job's
    #[arg(long, value_name = "S", value_parser = seed, allow_negative_numbers = true)]
    pub seed: Option<u64>,
    /// Samples in each cell (with until: at most), in place of the job's; more than a finished run has extend it
    #[arg(long, value_name = "N", value_parser = whole_number, allow_negative_numbers = true)]
    pub samples: Option<u64>,
    #[command(flatten)]
    pub asked: AskedArguments,
    /// Compute only one of N shards, to be merged later; I counts from 1 to N or from 0 to N-1
    #[arg(long, value_name = "I/N")]
    pub shard: Option<Shard>,
    /// Resolve the verdict map, or the share of the shard in it, and compute no samples yet
    #[arg(long)]
    pub map_only: bool,
    #[command(flatten)]
    pub maps: MapsArgument,
    /// Print the summary as JSON
    #[arg(long, conflicts_with_all = ["shard", "map_only", "engine"])]
    pub json: bool,
    #[command(flatten)]
    pub engine: EngineArguments,
}

/// Verdict maps of other runs.
#[derive(Debug, Args)]
pub struct MapsArgument {
    /// Use the verdict map of another run of the same model, speed and criterion; may be repeated
    #[arg(long = "map", value_name = "RUN_DIR")]
    pub maps: Vec<PathBuf>,
}

/// Arguments of `resume`.
#[derive(Debug, Args)]
pub struct ResumeArguments {
    /// The run directory
    #[arg(value_name = "RUN_DIR")]
    pub run: PathBuf,
    #[command(flatten)]
    pub asked: AskedArguments,
    #[command(flatten)]
    pub threads: ThreadsArgument,
    #[command(flatten)]
    pub maps: MapsArgument,
}

/// Arguments of `status`.
#[derive(Debug, Args)]
pub struct StatusArguments {
    /// The run directory, or a folder of run directories
    #[arg(value_name = "DIR", default_value = "runs")]
    pub run: PathBuf,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `check`.
#[derive(Debug, Args)]
pub struct CheckArguments {
    /// The job spec; - reads it from standard input
    #[arg(value_name = "JOB.toml")]
    pub job: PathBuf,
    #[command(flatten)]
    pub threads: ThreadsArgument,
    /// Also print the job with every key, those of defaults too, as a job that can be submitted
    #[arg(long, conflicts_with = "json")]
    pub all: bool,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `replay`.
#[derive(Debug, Args)]
pub struct ReplayArguments {
    /// The run directory
    #[arg(value_name = "RUN_DIR")]
    pub run: PathBuf,
    /// The cell, by its number in the column `cell`
    #[arg(long, value_name = "I", value_parser = whole_number, allow_negative_numbers = true)]
    pub cell: u64,
    /// The sample of that cell, numbered from 0
    #[arg(long, value_name = "J", value_parser = whole_number, allow_negative_numbers = true)]
    pub sample: u64,
    #[command(flatten)]
    pub motion: MotionArguments,
}

/// Arguments of `samples`.
#[derive(Debug, Args)]
pub struct SamplesArguments {
    /// The run directory
    #[arg(value_name = "RUN_DIR")]
    pub run: PathBuf,
    /// The cell, by its number in the column `cell`
    #[arg(long, value_name = "I", value_parser = whole_number, allow_negative_numbers = true)]
    pub cell: u64,
    /// The file to write [default: samples-I.parquet in the run directory]
    #[arg(long, value_name = "FILE.parquet", value_parser = parquet_file)]
    pub out: Option<PathBuf>,
    /// Print the samples to standard output as CSV, and write no file
    #[arg(long, conflicts_with = "out")]
    pub csv: bool,
    #[command(flatten)]
    pub threads: ThreadsArgument,
}

/// Arguments of `compare`.
#[derive(Debug, Args)]
pub struct CompareArguments {
    /// Run directories: the reference, then the runs to compare with it
    #[arg(value_name = "RUN_DIR", required = true)]
    pub runs: Vec<PathBuf>,
    /// Write one row for each pair of runs and cell to a Parquet file
    #[arg(long, value_name = "FILE.parquet", value_parser = parquet_file)]
    pub out: Option<PathBuf>,
    /// Confidence that all intervals of the differences hold together
    #[arg(long, value_name = "C", default_value_t = 0.95, value_parser = number, allow_negative_numbers = true)]
    pub confidence: f64,
    /// Let the confidence hold for each cell by itself, not for all together
    #[arg(long)]
    pub pointwise: bool,
    /// Print the summary as JSON
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub threads: ThreadsArgument,
}

/// Arguments of `report`.
#[derive(Debug, Args)]
pub struct ReportArguments {
    /// The run directories; the others are compared with the first
    #[arg(value_name = "RUN_DIR", required = true)]
    pub runs: Vec<PathBuf>,
    /// The file to write [default: report.html in the run directory, of several runs in the current one]
    #[arg(long, value_name = "FILE.html", value_parser = html_file)]
    pub out: Option<PathBuf>,
    #[command(flatten)]
    pub asked: AskedArguments,
    #[command(flatten)]
    pub threads: ThreadsArgument,
}

/// Arguments of `export`.
#[derive(Debug, Args)]
pub struct ExportArguments {
    /// The run directory
    #[arg(value_name = "RUN_DIR")]
    pub run: PathBuf,
    /// The format
    #[arg(long, value_name = "FORMAT", value_enum)]
    pub format: Format,
    /// Write this file, named after the format [default: surface.FORMAT in the run directory]
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
}

/// Arguments of `reproduce`.
#[derive(Debug, Args)]
pub struct ReproduceArguments {
    /// Tables and figures, or all
    #[arg(value_name = "NAME", value_enum, required = true)]
    pub targets: Vec<Target>,
    /// Directory for the runs; each goes to DIR/NAME
    #[arg(long, value_name = "DIR", default_value = "runs")]
    pub out: PathBuf,
    /// Write DIR/gallery.html: what is reproduced, beside what the paper prints
    #[arg(long)]
    pub report: bool,
    #[command(flatten)]
    pub threads: ThreadsArgument,
}

/// Seconds that `merge` waits for shards.
pub const WAIT: u64 = 600;

/// Arguments of `merge`.
#[derive(Debug, Args)]
pub struct MergeArguments {
    /// The run directory of the shards
    #[arg(value_name = "RUN_DIR")]
    pub run: PathBuf,
    /// How long to wait for shards that are still at work; then it ends with code 75
    #[arg(
        long,
        value_name = "SECONDS",
        default_value_t = WAIT,
        value_parser = whole_number,
        allow_negative_numbers = true
    )]
    pub wait: u64,
    #[command(flatten)]
    pub asked: AskedArguments,
}

/// Arguments of `verify`.
#[derive(Debug, Args)]
pub struct VerifyArguments {
    /// The run directory
    #[arg(value_name = "RUN_DIR")]
    pub run: PathBuf,
    /// Print the findings as JSON
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `completions`.
#[derive(Debug, Args)]
pub struct CompletionsArguments {
    /// bash, elvish, fish, powershell or zsh
    #[arg(value_name = "SHELL", value_enum)]
    pub shell: Shell,
}

/// Arguments of `man`.
#[derive(Debug, Args)]
pub struct ManArguments {
    /// Write a page for the program and one for each command into this folder, instead of printing them in one
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}
