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
        let map = |shards: u64| {
            format!("# What is missing of the map is resolved by the shards.\non_all map $(seq 1 {shards})\n")
        };
        let map = self.map_shards.map_or(String::new(), map);
        let run = format!(
            "#!/bin/sh
# Runs the shards of a run over GNU parallel and ssh, one at a time on each machine.
#   sh run.sh         all shards
#   sh run.sh 3 7 12  these shards
set -eu
{}hosts={}
if [ \"$#\" -eq 0 ]; then set -- $(seq 1 {}); fi

program=
stopped=
# The first signal asks GNU parallel to start no more, the second one to end.
pass_on() {{
    stopped=yes
    if [ -n \"$program\" ]; then kill -TERM \"$program\" 2>/dev/null || :; fi
}}
trap pass_on TERM INT HUP

# on_all SCRIPT NUMBER...: runs the script for each number. What fails is tried again elsewhere.
on_all() {{
    script=$1
    shift
    parallel --sshloginfile \"$hosts\" --jobs 1 --retries 4 --joblog \"$run/parallel/$script.log\" \\
        sh '{{1}}' '{{2}}' ::: \"$run/parallel/$script.sh\" ::: \"$@\" &
    program=$!
    code=0
    wait \"$program\" || code=$?
    # A signal ends the waiting, not the program.
    while kill -0 \"$program\" 2>/dev/null; do
        code=0
        wait \"$program\" || code=$?
    done
    if [ -n \"$stopped\" ]; then exit 143; fi
}}

{map}on_all shard \"$@\"
exit \"$code\"
",
            self.task.variables(),
            quoted(&self.machines.file),
            self.task.shards,
        );
        let mut scripts = vec![Script { name: "run.sh", text: run }];
        if let Some(shards) = self.map_shards {
            let what = "Resolves a share of the verdict map of the run";
            scripts.push(Script { name: "map.sh", text: self.step(what, shards, " --map-only") });
        }
        let what = "Computes one shard of the run";
        scripts.push(Script { name: "shard.sh", text: self.step(what, self.task.shards, "") });
        scripts
    }

    /// A script that a machine runs for a number.
    fn step(&self, what: &str, shards: u64, more: &str) -> String {
        let threads = self.threads.map_or(String::new(), |threads| format!(" --threads {threads}"));
        let command = self.task.command("$1", shards, &format!("{more}{threads}"));
        format!("#!/bin/sh\n# {what}, whose number is given.\nset -eu\n{}exec {command}\n", self.task.variables())
    }
}
