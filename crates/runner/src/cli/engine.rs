//! The options of `submit` for clusters.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::job::{EngineSettings, MOST_CPUS, MOST_SHARDS, Memory, SbatchOption, SlurmName, TimeLimit};
use crate::schedule::plan::Shard;

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

/// The shard that a process computes.
#[derive(Debug, Clone, Copy)]
pub enum ShardArgument {
    /// As typed.
    Given(Shard),
    /// As the environment of a task of Slurm says.
    Slurm,
}

impl std::str::FromStr for ShardArgument {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "slurm" { Ok(Self::Slurm) } else { text.parse().map(Self::Given) }
    }
}

/// Arguments of `submit` for clusters.
#[derive(Debug, Args)]
#[command(next_help_heading = "On a cluster")]
pub struct EngineArguments {
    /// Share the job among the machines of a cluster, by Slurm or by GNU parallel
    #[arg(long, value_name = "ENGINE", value_enum, conflicts_with = "shard")]
    pub engine: Option<EngineKind>,
    /// Print the scripts, and neither write nor start anything
    #[arg(long, requires = "engine")]
    pub dry_run: bool,
    /// The number of shards [default: so many that one takes about ten minutes]
    #[arg(long, value_name = "N", requires = "engine", value_parser = clap::value_parser!(u64).range(1..=MOST_SHARDS))]
    pub shards: Option<u64>,
    /// The largest number of shards without --shards [default: 1000, or what the cluster allows]
    #[arg(long, value_name = "N", requires = "engine", value_parser = clap::value_parser!(u64).range(1..=MOST_SHARDS))]
    pub max_shards: Option<u64>,
    /// parallel: a file with a machine in each line, as ssh knows it
    #[arg(long, value_name = "FILE", requires = "engine")]
    pub hosts: Option<PathBuf>,
    /// slurm: the partition
    #[arg(long, value_name = "NAME", requires = "engine")]
    pub partition: Option<SlurmName>,
    /// slurm: the account that is charged
    #[arg(long, value_name = "NAME", requires = "engine")]
    pub account: Option<SlurmName>,
    /// slurm: the time limit of a task, for example 30 (minutes) or 2:00:00
    #[arg(long, value_name = "TIME", requires = "engine", allow_hyphen_values = true)]
    pub time: Option<TimeLimit>,
    /// slurm: the memory of a task, for example 2G
    #[arg(long, value_name = "SIZE", requires = "engine", allow_hyphen_values = true)]
    pub memory: Option<Memory>,
    /// slurm: processors, and threads, of a task [default: --threads, or 1]
    #[arg(long, value_name = "N", requires = "engine", value_parser = clap::value_parser!(u64).range(1..=MOST_CPUS))]
    pub cpus_per_task: Option<u64>,
    /// slurm: a further option of sbatch, for example --sbatch=--constraint=avx2; may be repeated
    #[arg(long, value_name = "OPTION", requires = "engine", allow_hyphen_values = true)]
    pub sbatch: Vec<SbatchOption>,
}

impl EngineArguments {
    /// What the options ask of a cluster.
    pub fn settings(&self) -> EngineSettings {
        EngineSettings {
            partition: self.partition.clone(),
            account: self.account.clone(),
            time: self.time.clone(),
            memory: self.memory.clone(),
            cpus_per_task: self.cpus_per_task,
            shards: self.shards,
            max_shards: self.max_shards,
            sbatch: self.sbatch.clone(),
        }
    }

    /// An option that is given and belongs to the other engine.
    pub fn stranger(&self, engine: EngineKind) -> Option<&'static str> {
        let of_slurm = [
            ("--partition", self.partition.is_some()),
            ("--account", self.account.is_some()),
            ("--time", self.time.is_some()),
            ("--memory", self.memory.is_some()),
            ("--cpus-per-task", self.cpus_per_task.is_some()),
            ("--sbatch", !self.sbatch.is_empty()),
        ];
        let of_parallel = [("--hosts", self.hosts.is_some())];
        let strangers = if engine == EngineKind::Slurm { &of_parallel[..] } else { &of_slurm[..] };
        strangers.iter().find(|(_, is_given)| *is_given).map(|(option, _)| *option)
    }
}

/// How `status --missing` lists shards.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ListFormat {
    /// 3,7,12-15, for sbatch --array
    Slurm,
    /// A number in each line
    Lines,
}
