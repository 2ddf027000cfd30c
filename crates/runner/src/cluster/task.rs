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
            .map_err(|error| Failure::InputOutput(format!("cannot find the path of this program: {error}")))?;
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

    /// A script, from a template in which `{{name}}` stands for a value of that name.
    pub fn script(&self, name: &'static str, template: &str, values: &[(&str, String)]) -> Script {
        let common =
            [("program", quoted(&self.program)), ("run", quoted(&self.run)), ("shards", self.shards.to_string())];
        let value = |name: &str| values.iter().chain(&common).find(|(other, _)| *other == name);
        let mut parts = template.split("{{");
        let mut text = parts.next().unwrap_or_default().to_owned();
        for (name, rest) in parts.filter_map(|part| part.split_once("}}")) {
            debug_assert!(value(name).is_some(), "no value of {name}");
            text.extend(value(name).map(|(_, value)| value.as_str()));
            text.push_str(rest);
        }
        Script { name, text }
    }

    /// The scripts that compute a part of the run by its number, from one template: a share of the verdict map, if that is
    /// resolved first, and a shard. `values` are further ones, by the name of the step.
    pub fn steps(
        &self,
        template: &str,
        map_shards: Option<u64>,
        values: impl Fn(&str) -> Vec<(&'static str, String)>,
    ) -> Vec<Script> {
        let maps: String = self.maps.iter().map(|run| format!(" --map {}", quoted(run))).collect();
        let step = |step: &str, file: &'static str, what: &str, shards: u64, option: &str| {
            let mut values = values(step);
            values.extend([
                ("what", what.to_owned()),
                ("shards", shards.to_string()),
                ("options", format!("{option}{maps}")),
            ]);
            self.script(file, template, &values)
        };
        let what = "Resolves a share of the verdict map of the run";
        let map = map_shards.map(|shards| step("map", "map.sh", what, shards, " --map-only"));
        let shard = step("shard", "shard.sh", "Computes one shard of the run", self.shards, "");
        map.into_iter().chain([shard]).collect()
    }
}

/// The script that starts the others of an engine; `None` if there is no such engine.
pub fn first_script(engine: &str) -> Option<&'static str> {
    match engine {
        "slurm" => Some("submit.sh"),
        "parallel" => Some("run.sh"),
        _ => None,
    }
}

/// The command that submits these shards of a run again, by the scripts that were just written there.
pub fn again(run: &Path, engine: &str, shards: &[u64]) -> Option<String> {
    // Without a list, the scripts take all.
    let script = first_script(engine).filter(|_| !shards.is_empty())?;
    let list = match engine {
        "slurm" => ranges(shards),
        _ => shards.iter().map(u64::to_string).collect::<Vec<_>>().join(" "),
    };
    let path = absolute_text(&run.join(engine).join(script)).ok()?;
    Some(format!("sh {} {list}", quoted(&path)))
}
