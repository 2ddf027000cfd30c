//! How far the shards of a run are.

use std::path::Path;

use serde_json::{Value, json};

use crate::cluster::first_script;
use crate::cluster::task_list::ranges;
use crate::evaluate::parts::Parts;
use crate::files::folder::Folder;
use crate::job::Job;
use crate::output::{quoted, rate};
use crate::schedule::plan::Plan;
use crate::store::layout::JOB;
use crate::store::sharing::{Sharing, Worker, now, workers};
use crate::store::tally::Tally;

/// Time in seconds from which a rate is known.
const SHORTEST: f64 = 1.0;

/// How far the shards of a run are.
pub struct ShardProgress {
    /// The samples of each that are missing.
    missing: Vec<u128>,
    /// What is done of each.
    pub shares: Vec<f64>,
    /// How many of them have nothing to compute, whatever is done.
    empty: usize,
    /// The processes at work on them, one for each shard that has some.
    workers: Vec<Worker>,
}

impl ShardProgress {
    /// The progress of a run that is computed in `count` shards.
    pub fn new(run: &Path, job: &Job, parts: &Parts, tally: &Tally, count: u64) -> Self {
        let samples = |tally: &Tally| Plan::missing_of_shards(tally, parts, job.unit_samples(), count);
        let (missing, all) = (samples(tally), samples(&Tally::new(parts)));
        let share = |(missing, all): (&u128, &u128)| if *all > 0 { 1.0 - *missing as f64 / *all as f64 } else { 1.0 };
        let shares = missing.iter().zip(&all).map(share).collect();
        let empty = all.iter().filter(|all| **all == 0).count();
        let workers = first_of_each(workers(run).into_iter().filter(|worker| worker.shards == count).collect());
        Self { missing, shares, empty, workers }
    }

    /// The number of shards.
    pub fn count(&self) -> u64 {
        self.missing.len() as u64
    }

    /// The numbers of the shards that are done, at work, and neither.
    fn by_state(&self) -> [Vec<u64>; 3] {
        let mut states = [const { Vec::new() }; 3];
        for (number, missing) in (1..).zip(&self.missing) {
            let is_at_work = self.workers.iter().any(|worker| worker.shard == number);
            states[if *missing == 0 { 0 } else { 2 - usize::from(is_at_work) }].push(number);
        }
        states
    }

    /// The shards that are neither done nor at work.
    pub fn missing(&self) -> Vec<u64> {
        let [_, _, missing] = self.by_state();
        missing
    }

    /// The command that submits what is missing, if an engine has left its scripts in the run. It writes them again: the
    /// run and its scripts may come from somebody else.
    pub fn again(&self, run: &Path) -> Option<String> {
        let engine = Sharing::read(run).filter(|sharing| sharing.shards == self.count())?.engine;
        let script = first_script(&engine).filter(|_| !self.missing().is_empty())?;
        Folder::open(run).and_then(|run| run.within(&engine)?.open_file(script)).ok()?;
        let hosts = if engine == "parallel" { " --hosts FILE" } else { "" };
        let run = quoted(run);
        Some(format!("stickslip submit {run}/{JOB} --out {run} --engine {engine}{hosts}"))
    }

    /// Samples in a second of all shards at work, if it is known.
    fn samples_per_second(&self) -> Option<f64> {
        let rates = self.workers.iter().filter_map(|worker| {
            let seconds = now() - worker.began;
            let done = worker.missing - *self.missing.get(usize::try_from(worker.shard).ok()?.checked_sub(1)?)? as f64;
            (seconds >= SHORTEST).then(|| done.max(0.0) / seconds)
        });
        let rates: Vec<f64> = rates.collect();
        (!rates.is_empty()).then(|| rates.iter().sum())
    }

    /// In a line.
    pub fn text(&self) -> String {
        let [done, at_work, missing] = self.by_state();
        let mut text = format!("shards: {} of {} done", done.len(), self.count());
        match self.empty {
            0 => {}
            1 => text += ", 1 of which has nothing to compute",
            empty => text += &format!(", {empty} of which have nothing to compute"),
        }
        if !at_work.is_empty() {
            text += &format!("; at work: {}", ranges(&at_work));
            if let Some(samples) = self.samples_per_second() {
                text += &format!(" ({} samples/s)", rate(samples));
            }
        }
        if !missing.is_empty() {
            text += &format!("; missing: {}", ranges(&missing));
        }
        text
    }

    /// By name.
    pub fn json(&self) -> Value {
        let [done, at_work, missing] = self.by_state();
        json!({
            "count": self.count(),
            "done": done,
            "nothing_to_compute": self.empty,
            "at_work": at_work,
            "missing": missing,
            "samples_per_second": self.samples_per_second(),
        })
    }
}

/// Of several processes at work on the same shard, the one that began first: samples that arrive since then are those of
/// all.
fn first_of_each(mut workers: Vec<Worker>) -> Vec<Worker> {
    workers.sort_by(|a, b| a.shard.cmp(&b.shard).then(a.began.total_cmp(&b.began)));
    workers.dedup_by_key(|worker| worker.shard);
    workers
}

/// What to do about the shards that a run misses, as the beginning of a sentence.
pub fn how_to_submit_missing(run: &Path, job: &Job, tally: &Tally) -> String {
    let Some(Sharing { shards, .. }) = Sharing::read(run) else {
        return format!(
            "Submit the missing shards; of N shards, `stickslip status {} --shards N --missing` lists them",
            quoted(run)
        );
    };
    let progress = ShardProgress::new(run, job, &Parts::new(job), tally, shards);
    let what = format!("Of {shards} shards, these are missing: {}", ranges(&progress.missing()));
    match progress.again(run) {
        Some(command) => format!("{what}. Submit them with `{command}` and the options of before"),
        None => format!("{what}. Submit them"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn worker(shard: u64, seconds: f64, missing: f64) -> Worker {
        Worker { shard, shards: 2, host: "here".to_owned(), began: now() - seconds, missing }
    }

    #[test]
    fn a_shard_counts_once_however_many_processes_work_on_it() {
        let progress = |workers| ShardProgress {
            missing: vec![600, 500],
            shares: vec![0.4, 0.5],
            empty: 0,
            workers: first_of_each(workers),
        };
        // 400 samples in 100 s, of which a second process has seen 200 in 50 s, and 500 samples in 100 s.
        let [first, second, other] = [worker(1, 100.0, 1000.0), worker(1, 50.0, 800.0), worker(2, 100.0, 1000.0)];
        for workers in [vec![first.clone(), second.clone(), other.clone()], vec![second, other, first]] {
            let rate = progress(workers).samples_per_second().unwrap();
            assert!((rate - 9.0).abs() < 0.1, "{rate}");
        }
    }
}
