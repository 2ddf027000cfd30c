//! Arguments of the commands about one brake: `parameters`, `analyse`, `trajectory` and `fit`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use stickslip_core::models::pad_on_disc::finite_difference::brake::DiscGrid;

use super::start::{StartArgument, start};
use super::values::{count, number, parquet_file, plot_file, whole_number};

/// Arguments of `parameters`.
#[derive(Debug, Args)]
pub struct ParametersArguments {
    /// Change a value of the preset, for example friction.static_coefficient=0.45; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// The brake to look at.
#[derive(Debug, Args)]
pub struct BrakeArguments {
    /// Take the brake of a job, in place of the preset: a job spec (- reads it from standard input) or a run directory
    #[arg(long, value_name = "JOB.toml|RUN_DIR", group = "of_a_job")]
    pub job: Option<PathBuf>,
    /// The cell of the job whose expected values are taken [default: its operating point, or the middle of its axes, of
    /// two in the middle the first]
    #[arg(long, value_name = "I", value_parser = whole_number, allow_negative_numbers = true, requires = "of_a_job")]
    pub cell: Option<u64>,
    /// Change a value by its key in `stickslip parameters`, for example friction.static_coefficient=0.45, also
    /// operating_point.preload_force, friction.law=rational, or friction.table=FILE with friction.smoothing=spline; or
    /// one of the model of the job by its name, for example belt_speed=1.2; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<String>,
}

/// Arguments of `analyse`.
#[derive(Debug, Args)]
pub struct AnalyseArguments {
    /// The same as --job
    #[arg(value_name = "JOB.toml|RUN_DIR", group = "of_a_job")]
    pub place: Option<PathBuf>,
    #[command(flatten)]
    pub brake: BrakeArguments,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `trajectory`.
#[derive(Debug, Args)]
pub struct TrajectoryArguments {
    #[command(flatten)]
    pub brake: BrakeArguments,
    /// The disc under the pad [default: the job's, rigid with kind = "eigenvalue"; without a job flexible]
    #[arg(long, value_enum)]
    pub disc: Option<DiscArgument>,
    /// Number of modes of the flexible disc, lowest frequencies first [default: the job's, or as many as the growth
    /// rate needs]
    #[arg(long, value_name = "N", value_parser = count, allow_negative_numbers = true)]
    pub disc_modes: Option<usize>,
    /// Grid of the finite-difference disc: radial intervals, elements under the pad (6 N around the disc) [default:
    /// 8x8]
    #[arg(long, value_name = "RxN", value_parser = grid)]
    pub grid: Option<DiscGrid>,
    /// How the moving load of the finite-difference disc is shared among nodes [default: linear]
    #[arg(long, value_enum)]
    pub allotment: Option<AllotmentArgument>,
    /// Where the motion starts: near-equilibrium, rest, limit-cycle, or numbers, for example
    /// velocity=0.3,tangential=1e-4 (m/s, m, rad; also normal, angle, from_equilibrium and units=scaled) [default: the
    /// job's, or near-equilibrium]
    #[arg(long, value_name = "START", value_parser = start)]
    pub start: Option<StartArgument>,
    /// Relative displacement from the equilibrium at the start [default: the job's, or 0.01]
    #[arg(long, value_name = "D", value_parser = number, allow_negative_numbers = true)]
    pub displacement: Option<f64>,
    #[command(flatten)]
    pub motion: MotionArguments,
}

/// The motion to simulate, and how it is shown.
#[derive(Debug, Args)]
pub struct MotionArguments {
    /// Scaled time to simulate [default: 500]
    #[arg(long, value_name = "T", value_parser = number, allow_negative_numbers = true)]
    pub horizon: Option<f64>,
    /// Write the time series to a Parquet file
    #[arg(long, value_name = "FILE.parquet", value_parser = parquet_file)]
    pub out: Option<PathBuf>,
    /// Print the summary as JSON
    #[arg(long)]
    pub json: bool,
}

/// The disc of a trajectory.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum DiscArgument {
    /// No disc: the pad alone, sin(phi) = 0
    Rigid,
    /// An annular plate, by its modes
    Flexible,
    /// The paper's polar grid with a moving load, a reference for the modes; takes seconds to minutes
    FiniteDifference,
}

/// How the moving load of the finite-difference disc is shared among nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum AllotmentArgument {
    /// It jumps from node to node (the paper's condition a)
    Nodal,
    /// The two nodes around it share it linearly (condition b)
    Linear,
}

impl DiscArgument {
    /// Its name on the command line.
    pub fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }
}

/// Arguments of `fit`.
#[derive(Debug, Args)]
pub struct FitArguments {
    /// The tests: a CSV file with the columns rotating_speed, preload, squealed and perhaps count, or onset_speed,
    /// preload and perhaps censored
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
    /// Write a job with the estimates in place, named with -fitted after it; with preload_factor its preloads are the
    /// true ones
    #[arg(long, value_name = "NEW_JOB.toml")]
    pub out: Option<PathBuf>,
    /// Draw the tests and the fitted probability of squeal over the speed, as SVG, PDF or PNG by the name of the file;
    /// of at most 6 preloads
    #[arg(long, value_name = "FILE", value_parser = plot_file)]
    pub plot: Option<PathBuf>,
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

/// `RxN`: radial intervals and elements under the pad.
pub fn grid(text: &str) -> Result<DiscGrid, String> {
    let wrong =
        || format!("{text:?} is not a grid; write RxN, for example 12x12: radial intervals, elements under the pad");
    let (radial, per_pad) = text.split_once('x').ok_or_else(wrong)?;
    Ok(DiscGrid { radial: radial.parse().map_err(|_| wrong())?, per_pad: per_pad.parse().map_err(|_| wrong())? })
}
