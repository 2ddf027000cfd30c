//! The scripts of a run over GNU parallel and ssh, on machines that share its directory.

use std::fs;
use std::path::Path;

use super::shell::{absolute_text, quoted};
use super::task::{Script, ShardTask};
use crate::failure::Failure;
use crate::files::bounded::read_file;

/// The limit of the file of machines.
const MOST_BYTES: u64 = 1 << 20;

/// Shards for each machine that keep it at work while others are at their last one.
const SHARDS_OF_A_MACHINE: u64 = 4;

/// Seconds that such a shard takes at least: long against the start of a program by ssh.
const SHORTEST: f64 = 10.0;

/// The scripts: what runs the others on all machines, and what a machine runs for a number.
const RUN: &str = include_str!("gnu_parallel/run.sh");
const TASK: &str = include_str!("gnu_parallel/task.sh");

/// The machines of a file with one login of ssh in each line.
#[derive(Debug)]
pub struct Machines {
    /// The path of the file.
    file: String,
    /// How many there are.
    count: u64,
}

impl Machines {
    /// Of a file.
    pub fn read(file: &Path) -> Result<Self, Failure> {
        // A pipe may never end, and the scripts read the file once more.
        let found = fs::metadata(file).map_err(|error| Failure::reading(file, error))?;
        if !found.is_file() {
            return Err(Failure::Usage(format!(
                "--hosts {}: it is {}; name an ordinary file with a machine in each line",
                file.display(),
                if found.is_dir() { "a directory" } else { "a pipe or a device, which may never end" },
            )));
        }
        let bytes = read_file(file, MOST_BYTES).map_err(|error| Failure::reading(file, error))?;
        let text = String::from_utf8_lossy(&bytes);
        let is_login = |line: &&str| !line.is_empty() && !line.starts_with('#');
        match text.lines().map(str::trim).filter(is_login).count() as u64 {
            0 => Err(Failure::Usage(format!(
                "--hosts {}: there is no machine in it; write one in each line, as ssh knows it (: is this one)",
                file.display()
            ))),
            count => Ok(Self { file: absolute_text(file)?, count }),
        }
    }

    /// The number of shards for work that takes this many seconds on one thread: `by_cost`, or more where that leaves
    /// machines without work.
    pub fn number_of_shards(&self, by_cost: u64, seconds: f64, units: u64, threads: usize, most: u64) -> u64 {
        let affordable = (seconds / (SHORTEST * threads as f64)) as u64;
        let for_all = (SHARDS_OF_A_MACHINE * self.count).min(affordable).min(units).min(most);
        by_cost.max(for_all)
    }
}

/// A run that is shared among machines.
#[derive(Debug)]
pub struct SharedRun<'a> {
    /// What computes a shard.
    pub task: ShardTask,
    /// The number of shards in which a verdict map is resolved first, if there is one.
    pub map_shards: Option<u64>,
    /// The machines.
    pub machines: &'a Machines,
    /// Threads of a shard; by default all processors of its machine.
    pub threads: Option<usize>,
}

impl SharedRun<'_> {
    /// All scripts, the one that runs the others first.
    pub fn scripts(&self) -> Vec<Script> {
        let map_shards = self.map_shards.map_or(String::new(), |shards| shards.to_string());
        let values = [("hosts", quoted(&self.machines.file)), ("map_shards", map_shards)];
        let mut scripts = vec![self.task.script("run.sh", RUN, &values)];
        let threads = self.threads.map_or(String::new(), |threads| format!(" --threads {threads}"));
        scripts.extend(self.task.steps(TASK, self.map_shards, |_| vec![("threads", threads.clone())]));
        scripts
    }
}
