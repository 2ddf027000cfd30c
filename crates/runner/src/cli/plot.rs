//! Arguments of `plot`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::threads::ThreadsArgument;
use super::values::{axis_value, plot_file, probability, seconds, whole_number};

/// Arguments of `plot`.
#[derive(Debug, Args)]
pub struct PlotArguments {
    /// The run directory, a job to see its random inputs or with --of its samples, modes and measured friction, or a
    /// time series that trajectory or replay wrote
    #[arg(value_name = "RUN_DIR|JOB.toml|FILE.parquet")]
    pub run: PathBuf,
    /// What of the run to draw
    #[arg(long, value_name = "QUANTITY", value_enum, default_value_t = PlotQuantity::Probability)]
    pub of: PlotQuantity,
    /// The cell to draw: with --of sobol [default: all of at most 6 cells, else the one whose probability is nearest
    /// 0.5], with what is drawn of one cell [default: the operating point, or the middle of the axes]
    #[arg(long, value_name = "N", value_parser = whole_number, allow_negative_numbers = true)]
    pub cell: Option<u64>,
    /// The recorded result: with --of sobol the one whose variance is shared out [default: the verdict], with --of
    /// distribution the one that is drawn [default: the first]
    #[arg(long, value_name = "NAME")]
    pub result: Option<String>,
    /// With --of samples: the random input or recorded result that runs across [default: the first input]
    #[arg(long, value_name = "NAME")]
    pub x: Option<String>,
    /// With --of samples: the one that runs up [default: the second input]
    #[arg(long, value_name = "NAME")]
    pub y: Option<String>,
    /// With --of samples and convergence: how many samples to draw [default: 2000, 200 of large matrices; with
    /// convergence those of the run or job]
    #[arg(long, value_name = "N", value_parser = whole_number, allow_negative_numbers = true)]
    pub samples: Option<u64>,
    /// With --of modes: the parameter over which to draw them [default: the longest axis of the job, else that of
    /// friction]
    #[arg(long, value_name = "NAME")]
    pub along: Option<String>,
    /// Draw the difference of the probabilities: those of the run minus those of this one, which has the same axes
    #[arg(long, value_name = "RUN_DIR")]
    pub against: Option<PathBuf>,
    /// Show one value of an axis alone, for example rotating_speed=15; may be given for several axes
    #[arg(long, value_name = "AXIS=VALUE", value_parser = axis_value)]
    pub at: Vec<(String, f64)>,
    /// Draw the line of this probability, in place of the job's target
    #[arg(long, value_name = "P", value_parser = probability, allow_negative_numbers = true)]
    pub target: Option<f64>,
    /// Of a motion: draw it from this time on, in seconds [default: its start]
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    pub from: Option<f64>,
    /// Of a motion: draw it up to this time, in seconds [default: its end]
    #[arg(long, value_name = "SECONDS", value_parser = seconds, allow_negative_numbers = true)]
    pub to: Option<f64>,
    /// What to write above the figure, in place of what its cells share
    #[arg(long, value_name = "TEXT")]
    pub title: Option<String>,
    /// Write one file, SVG, PDF or PNG by its name [default: SVG and PNG in the run directory, or beside the file]
    #[arg(long, value_name = "FILE", value_parser = plot_file)]
    pub out: Option<PathBuf>,
    /// Columns of a paper that the figure fills: 1 is 84 mm wide, 2 are 174 mm
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..=2))]
    pub columns: u8,
    #[command(flatten)]
    pub threads: ThreadsArgument,
}

/// What a plot shows of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum PlotQuantity {
    /// The probability of instability
    Probability,
    /// The Sobol indices of the inputs, of a job with sensitivity = true
    Sobol,
    /// The verdict maps, of a job with evaluate = "boundary", or method = "exact" and a criterion other than
    /// "eigenvalue"
    Verdicts,
    /// Frequencies and damping ratios over a parameter, of a model given by matrices
    Modes,
    /// The frequencies of unstable samples of a cell, of a model given by matrices: which modes make the probability
    SquealFrequencies,
    /// The distributions of the random inputs of a cell, and where they leave the model; needs no run
    Inputs,
    /// Stable and unstable samples of a cell over two of their inputs or recorded results; needs no run
    Samples,
    /// The probability of a cell over the number of its samples; needs no run
    Convergence,
    /// The distribution of a recorded result: its quantiles over an axis, or with --cell its histogram
    Distribution,
    /// The measured friction curve: its rows, the curve of the model, and where steady sliding is unstable; needs no
    /// run
    Friction,
}
