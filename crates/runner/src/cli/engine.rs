//! The options of `submit` for clusters.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::values::whole_number_in;
use crate::schedule::plan::MOST_SHARDS;

/// What runs the shards of a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum EngineKind {
    /// An array of jobs of Slurm, and a merge after it
    Slurm,
    /// GNU parallel over ssh, on machines that share the run directory, then the merge
    Parallel,
}

impl EngineKind {
    /// Its name, which is that of its folder in a run, too.
    pub fn name(self) -> &'static str {
        match self {
            Self::Slurm => "slurm",
            Self::Parallel => "parallel",
        }
    }
}

/// Arguments of `submit` for clusters.
#[derive(Debug, Args)]
#[command(next_help_heading = "On a cluster")]
pub struct EngineArguments {
    /// Share the job among the machines of a cluster, by Slurm or by GNU parallel
    #[arg(long, value_name = "ENGINE", value_enum, conflicts_with = "shard", requires = "shards")]
    pub engine: Option<EngineKind>,
    /// In how many shards, 1 to 1,000,000; another number than before does no harm
    #[arg(
        long,
        value_name = "N",
        requires = "engine",
        value_parser = whole_number_in(1..=MOST_SHARDS),
        allow_negative_numbers = true
    )]
    pub shards: Option<u64>,
    /// parallel: an ordinary file with a machine in each line, as ssh knows it
    #[arg(long, value_name = "FILE", requires = "engine")]
    pub hosts: Option<PathBuf>,
    /// slurm: options of sbatch, after --, for example -- --partition=long --time=2:00:00
    #[arg(last = true, value_name = "OPTION", requires = "engine")]
    pub sbatch: Vec<String>,
}
