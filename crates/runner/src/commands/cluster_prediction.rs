//! The predicted times of a job on several machines, from what its steps take on this one.

use std::env;
use std::process::{Command, Stdio};
use std::time::Instant;

use serde_json::{Value, json};
use stickslip_core::model::verdict::VerdictCounts;
use tempfile::TempDir;

use crate::evaluate::parts::Parts;
use crate::evaluate::sums::SumLayout;
use crate::evaluate::unit::{FinishedUnit, Recorded};
use crate::failure::Failure;
use crate::files::folder::Folder;
use crate::job::Job;
use crate::output::counted;
use crate::schedule::cluster_cost::{ClusterCost, Load, Nodes, Rates, TASK, UNIT_HANDLED};
use crate::schedule::plan::{Plan, Shard};
use crate::schedule::time_left::{Duration, Prediction};
use crate::store::piece;
use crate::store::tally::Tally;
use crate::tables::surface::Surface;
use crate::unfinished::{self, Unfinished};

/// Numbers of shards whose times are shown beside those of the best.
const SHOWN: [u64; 4] = [1, 10, 100, 1000];

/// How often a step that is over soon is tried.
const TRIES: u64 = 3;

/// Most cells of the rows, and most units of the piece, that are tried.
const MOST_ROWS: u64 = 4096;
const MOST_UNITS: u64 = 1000;

/// About so many units are planned as a trial.
const MOST_PLANNED: u64 = 4096;

/// The predicted times of a job on several machines.
pub struct ClusterPrediction {
    on: Nodes,
    rates: Rates,
    load: Load,
    /// The relative standard error of the cost of a sample.
    error: f64,
    best: ClusterCost,
    shown: [ClusterCost; SHOWN.len()],
}

impl ClusterPrediction {
    /// The prediction for a job whose samples take `sample` seconds each on one thread, from what everything else takes
    /// here and now.
    pub fn for_job(job: &Job, parts: &Parts, load: Load, sample: f64, error: f64, on: Nodes) -> Result<Self, Failure> {
        let rates = measured(job, parts, sample)?;
        let shown = SHOWN.map(|shards| load.cost(&rates, on, shards));
        Ok(Self { on, rates, load, error, best: load.best(&rates, on, &SHOWN), shown })
    }

    /// As comments: a sentence on the best number of shards, and a table.
    pub fn text(&self) -> String {
        let Self { on, best, .. } = self;
        let nodes = counted(on.nodes.into(), "node", "nodes");
        let mut text = format!(
            "# on {nodes} with {} each, in {}: {}, {:.0} % of it computing\n",
            counted(on.threads.into(), "thread", "threads"),
            counted(best.shards.into(), "shard", "shards"),
            Prediction::from_rate(best.total, self.error),
            100.0 * best.efficiency
        );
        text += &format!(
            "# {:>8}  {:>13}  {:>13}  {:>13}  {:>13}  {:>9}  most of it\n",
            "shards", "one shard", "all shards", "merge", "together", "computing"
        );
        let mut rows: Vec<&ClusterCost> = self.shown.iter().collect();
        if !SHOWN.contains(&best.shards) {
            rows.insert(rows.partition_point(|cost| cost.shards < best.shards), best);
        }
        for cost in rows {
            let [shard, all, merge, total] =
                [cost.shard, cost.all, cost.merge, cost.total].map(|seconds| Duration(seconds).to_string());
            text += &format!(
                "# {:>8}  {shard:>13}  {all:>13}  {merge:>13}  {total:>13}  {:>7.1} %  {}\n",
                cost.shards,
                100.0 * cost.efficiency,
                cost.limit.name()
            );
        }
        text
    }

    /// Everything by name, times in seconds.
    pub fn json(&self) -> Value {
        json!({
            "nodes": self.on.nodes,
            "threads": self.on.threads,
            "seconds": self.rates,
            "load": self.load,
            "best": self.best,
            "shards": self.shown,
        })
    }
}

/// What the steps of a run of the job take here.
fn measured(job: &Job, parts: &Parts, sample: f64) -> Result<Rates, Failure> {
    let mut tally = Tally::new(parts);
    // The plan of a shard of some units.
    let shards = u64::try_from(parts.all_units() / u128::from(MOST_PLANNED)).unwrap_or(u64::MAX).clamp(1, 1_000_000);
    let mut planned = 0;
    let plan = quickest(TRIES, || {
        planned = Plan::new(&tally, parts, parts.unit_samples(), Shard::all(shards).next()).units();
        Ok(())
    })?;
    // Units of several cells, as those of a shard are.
    let layout = SumLayout::for_job(job);
    let unit = |cell: u64| {
        let samples = parts.max_samples(0).clamp(1, parts.unit_samples());
        let counts = VerdictCounts { stable: samples / 2, unstable: samples - samples / 2, ..Default::default() };
        let part = parts.in_cell(cell).start;
        FinishedUnit { part, samples: 0..samples, counts, recorded: Recorded::default(), sums: layout.zeros() }
    };
    let units: Vec<FinishedUnit> = (0..parts.cells().min(MOST_UNITS)).map(unit).collect();
    let experiment = job.experiment_hash();
    let scratch = [scratch()?, scratch()?];
    let open = |(_, directory): &(Unfinished, TempDir)| {
        Folder::open(directory.path()).map_err(|error| Failure::reading(directory.path(), error))
    };
    let (few, many) = (open(&scratch[0])?, open(&scratch[1])?);
    let mut turn = 0;
    let piece_written = quickest(TRIES, || {
        // Pieces of the same content would be one file.
        turn += 1;
        let samples = turn..turn + 1;
        let counts = VerdictCounts { stable: 1, ..Default::default() };
        piece::write(&few, &experiment, &[FinishedUnit { samples, counts, ..unit(0) }])
    })?;
    piece::write(&many, &experiment, &units)?;
    let mut read = |folder: &Folder| {
        quickest(TRIES, || {
            piece::read_all(folder, &experiment, |_| None, &mut |unit| {
                tally.clear(unit.part);
                tally.add(&unit);
                Ok(())
            })?;
            Ok(())
        })
    };
    let piece_read = read(&few)? / TRIES as f64;
    let unit_read = (read(&many)? - piece_read).max(0.0) / units.len() as f64;
    let rows = parts.cells().min(MOST_ROWS);
    for cell in 0..rows {
        let unit = unit(cell);
        tally.clear(unit.part);
        tally.add(&unit);
    }
    // A row is made for the file, and again for what is said of all cells.
    let surface = Surface::new(job, &tally);
    let row = quickest(TRIES, || {
        surface.try_rows(rows)?;
        (0..rows).for_each(|cell| drop(surface.row(cell)));
        Ok(())
    })?;
    let start = quickest(TRIES, || {
        started();
        Ok(())
    })?;
    let (unit_planned, row) = (plan / planned.max(1) as f64, row / rows as f64);
    Ok(Rates {
        task: TASK,
        sample,
        start,
        unit_planned,
        unit_handled: UNIT_HANDLED,
        piece_written,
        piece_read,
        unit_read,
        row,
    })
}

/// The least of the times that a step takes, in seconds.
fn quickest(times: u64, mut step: impl FnMut() -> Result<(), Failure>) -> Result<f64, Failure> {
    let mut least = f64::INFINITY;
    for _ in 0..times {
        let begun = Instant::now();
        step()?;
        least = least.min(begun.elapsed().as_secs_f64());
    }
    Ok(least)
}

/// A directory in the current one, whose file system is taken for that of runs, or, where nothing can be written there,
/// in that of temporary files. A signal removes it.
fn scratch() -> Result<(Unfinished, TempDir), Failure> {
    let created = unfinished::create(|| {
        let here = tempfile::Builder::new().prefix(".stickslip-").tempdir_in(".");
        let directory = here.or_else(|_| tempfile::tempdir())?;
        let path = directory.path().to_owned();
        Ok((directory, path))
    });
    created.map_err(|error| Failure::creating(&env::temp_dir(), error))
}

/// Starts this program once. Where it cannot be started, it is only too quick.
fn started() {
    let program = env::current_exe().map(|program| {
        Command::new(program).arg("--version").stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).status()
    });
    drop(program);
}
