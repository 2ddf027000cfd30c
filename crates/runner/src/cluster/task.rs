//! What the tasks of all engines have in common.

use std::path::{Path, PathBuf};

use super::shell::{absolute_text, quoted};
use super::task_list::ranges;
use crate::failure::Failure;

/// A script of a run.
#[derive(Debug)]
pub struct Script {
    /// Its name in the folder of the engine.
    pub name: &'static str,
    /// Its text.
    pub text: String,
}

/// How one shard of a run is computed, by a script that may run on another machine.
#[derive(Debug)]
pub struct ShardTask {
    /// The path of this program.
    program: String,
    /// The path of the run directory.
    run: String,
    /// Paths of runs whose verdict maps may be used.
    maps: Vec<String>,
    /// The number of shards.
    pub shards: u64,
}

impl ShardTask {
    /// A shard of the run in the directory `run`, by this program, with the verdict maps of other runs.
    pub fn new(run: &Path, maps: &[PathBuf], shards: u64) -> Result<Self, Failure> {
        let program = std::env::current_exe()
            .map_err(|error| Failure::InputOutput(format!("cannot tell the path of this program: {error}")))?;
        Ok(Self {
            program: absolute_text(&program)?,
            run: absolute_text(run)?,
            maps: maps.iter().map(|run| absolute_text(run)).collect::<Result<_, _>>()?,
            shards,
        })
    }

    /// The path of the run directory.
    pub fn run(&self) -> &str {
        &self.run
    }

    /// The lines that set what the other lines of a script use.
    pub fn variables(&self) -> String {
        format!("stickslip={}\nrun={}\n", quoted(&self.program), quoted(&self.run))
    }

    /// The command that computes the shard with this index, a word of a script. `more` are further words.
    pub fn command(&self, index: &str, shards: u64, more: &str) -> String {
        let maps: String = self.maps.iter().map(|run| format!(" --map {}", quoted(run))).collect();
        format!("\"$stickslip\" submit \"$run/job.toml\" --out \"$run\" --shard \"{index}/{shards}\"{more}{maps}")
    }
}

/// The command that submits these shards of a run again, by the scripts that an engine keeps in it; `None` if there are
/// none.
pub fn again(run: &Path, engine: &str, shards: &[u64]) -> Option<String> {
    let (script, list) = match engine {
        "slurm" => ("submit.sh", ranges(shards)),
        "parallel" => ("run.sh", shards.iter().map(u64::to_string).collect::<Vec<_>>().join(" ")),
        _ => return None,
    };
    // Without a list, the scripts take all.
    if shards.is_empty() {
        return None;
    }
    let path = run.join(engine).join(script);
    let path = absolute_text(&path).ok().filter(|_| path.is_file())?;
    Some(format!("sh {} {list}", quoted(&path)))
}
