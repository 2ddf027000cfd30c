//! What a job costs when processes on several nodes share it: predicted times of a shard, of all shards and of the merge.
//!
//! The prediction adds up what happens one after the other. Nodes compute one shard each at a time, in rounds. A shard is
//! started, reads the pieces that are there, computes its units on its threads, and writes the last piece. The merge
//! begins when all shards have ended.

use serde::Serialize;

use crate::schedule::saving::{LONGEST_INTERVAL, SHORTEST_INTERVAL};
use crate::schedule::shard_size::{MOST_TASKS, number_of_shards};

/// Seconds that a batch system takes to start a task and to notice its end: measured with Slurm 22.05 on one machine
/// (docs/cluster-costs.md). A busy cluster takes longer.
pub const TASK: f64 = 0.2;

/// Seconds that it takes to hand a unit to a thread, to collect its result and to encode it: a run of 10^6 units of 20
/// samples took 6.3 s on the processors, 3.4 s more than its other steps (docs/cluster-costs.md).
pub const UNIT_HANDLED: f64 = 3.4e-6;

/// Share of the time of a computation after which it writes a piece.
const PIECE_SHARE: f64 = 0.1;

/// Shards of up to ten minutes are proposed if they take no longer than this times the time of the quickest number.
pub const AS_GOOD: f64 = 1.05;

/// What the steps of a run take, in seconds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Rates {
    /// Starting a task by a batch system, and noticing its end.
    pub task: f64,
    /// A sample on one thread.
    pub sample: f64,
    /// Starting the program.
    pub start: f64,
    /// Planning a unit.
    pub unit_planned: f64,
    /// Handing a unit to a thread, collecting its result and encoding it.
    pub unit_handled: f64,
    /// Writing a piece, until it is on disk.
    pub piece_written: f64,
    /// Reading a piece, without its units.
    pub piece_read: f64,
    /// Reading a unit of a piece and adding it up.
    pub unit_read: f64,
    /// Making and writing a row of the surface.
    pub row: f64,
}

/// The work of a job.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Load {
    /// Samples that are drawn, as many as are expected.
    pub samples: f64,
    /// Units of work.
    pub units: u64,
    /// What is shared: units, or cells where the samples of a cell belong to one shard.
    pub shared: u64,
    /// Cells.
    pub cells: u64,
    /// Seconds that one thread takes for what every node of the first round needs before it draws samples.
    pub before: f64,
}

/// The machines: so many nodes, with so many threads each.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Nodes {
    /// How many.
    pub nodes: u64,
    /// Threads of each.
    pub threads: u64,
}

/// The predicted times of a job in a number of shards, in seconds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ClusterCost {
    /// The number of shards.
    pub shards: u64,
    /// One shard, from its start to its end, on the average.
    pub shard: f64,
    /// Of this, computing samples.
    pub computing: f64,
    /// All shards.
    pub all: f64,
    /// The merge.
    pub merge: f64,
    /// All shards and the merge.
    pub total: f64,
    /// The time that the samples alone take on all threads of all nodes, over the total.
    pub efficiency: f64,
    /// What takes most of the total.
    pub limit: Limit,
    /// The number of pieces that are written.
    pub pieces: u64,
}

/// What takes most of the time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Limit {
    /// Computing samples.
    Computing,
    /// Nodes or threads without work, while others have some.
    Idling,
    /// Starting tasks.
    Starting,
    /// Planning, handing out and collecting units, which are small.
    Handling,
    /// Shards that read the pieces of others.
    Reading,
    /// Writing the last piece of a shard.
    Writing,
    /// The merge.
    Merging,
}

impl Limit {
    /// In a word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Computing => "computing",
            Self::Idling => "idle nodes",
            Self::Starting => "starting",
            Self::Handling => "small units",
            Self::Reading => "reading pieces",
            Self::Writing => "writing",
            Self::Merging => "the merge",
        }
    }
}

impl Load {
    /// The predicted times in `shards` shards.
    pub fn cost(&self, rates: &Rates, on: Nodes, shards: u64) -> ClusterCost {
        let rounds = shards.div_ceil(on.nodes);
        // The largest shard.
        let shared = self.shared.div_ceil(shards);
        let of_one = self.samples * rates.sample / self.shared.max(1) as f64;
        // Shards without work write nothing.
        let working = shards.min(self.shared.max(1)) as f64;
        let units = self.units as f64 / working;
        let computing = shared.div_ceil(on.threads) as f64 * of_one;
        let handling = units * (rates.unit_planned + rates.unit_handled);
        let starting = rates.task + rates.start;
        let pieces = pieces_of(computing).min(units.ceil());
        // A shard reads what those of the rounds before have written.
        let reading_of_one = pieces * rates.piece_read + units * rates.unit_read;
        let rounds_before = rounds as f64 * (rounds - 1) as f64 / 2.0;
        let reading = rounds_before * on.nodes as f64 * reading_of_one * working / shards as f64;
        let before = self.before / on.threads as f64;
        let rounds = rounds as f64;
        let all = before + rounds * (starting + handling + computing + rates.piece_written) + reading;
        let merge = starting + working * reading_of_one + self.cells as f64 * rates.row + rates.piece_written;
        let (total, least) = (all + merge, self.samples * rates.sample / (on.nodes * on.threads) as f64);
        let parts = [
            (least, Limit::Computing),
            (before + rounds * computing - least, Limit::Idling),
            (rounds * starting, Limit::Starting),
            (rounds * handling, Limit::Handling),
            (reading, Limit::Reading),
            (rounds * rates.piece_written, Limit::Writing),
            (merge, Limit::Merging),
        ];
        let limit = parts.into_iter().max_by(|(a, _), (b, _)| a.total_cmp(b)).map_or(Limit::Computing, |(_, of)| of);
        ClusterCost {
            shards,
            shard: starting + handling + computing + rates.piece_written + reading / rounds,
            computing,
            all,
            merge,
            total,
            efficiency: least / total,
            limit,
            pieces: (working * pieces) as u64,
        }
    }

    /// The cost in the number of shards that is proposed: as many as their size makes, or else somewhat more, such that
    /// every node has as many, if that takes about as little time as the quickest of these two and `others`; and the
    /// quickest of all if neither does.
    pub fn best(&self, rates: &Rates, on: Nodes, others: &[u64]) -> ClusterCost {
        let seconds = self.samples * rates.sample;
        let by_size = number_of_shards(seconds, self.shared, on.threads as usize, MOST_TASKS);
        let most = MOST_TASKS.min(self.shared.max(1));
        let cost = |shards: u64| self.cost(rates, on, shards.min(most));
        let [by_size, even] = [by_size, by_size.next_multiple_of(on.nodes)].map(cost);
        // Of several that take as long, the one with the fewest shards.
        let in_order = |a: &ClusterCost, b: &ClusterCost| a.total.total_cmp(&b.total).then(a.shards.cmp(&b.shards));
        let all = others.iter().map(|&shards| cost(shards)).chain([even]);
        let quickest = all.fold(by_size, |a, b| if in_order(&b, &a).is_lt() { b } else { a });
        let is_as_good = |cost: &ClusterCost| cost.total <= AS_GOOD * quickest.total;
        [by_size, even].into_iter().find(is_as_good).unwrap_or(quickest)
    }
}

/// The number of pieces that a computation of so many seconds writes: one after each tenth of the time already spent,
/// within the intervals of saving, and one at the end.
fn pieces_of(seconds: f64) -> f64 {
    let (shortest, longest) = (SHORTEST_INTERVAL.as_secs_f64(), LONGEST_INTERVAL.as_secs_f64());
    // Until when the interval is the shortest, and from when it is the longest.
    let (slower, steady) = (shortest / PIECE_SHARE, longest / PIECE_SHARE);
    let first = seconds.min(slower) / shortest;
    let growing = libm::log(seconds.clamp(slower, steady) / slower) / libm::log1p(PIECE_SHARE);
    let last = (seconds - steady).max(0.0) / longest;
    (first + growing + last).floor() + 1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATES: Rates = Rates {
        task: TASK,
        sample: 1e-3,
        start: 0.3,
        unit_planned: 4e-4,
        unit_handled: 6e-4,
        piece_written: 0.5,
        piece_read: 0.01,
        unit_read: 1e-4,
        row: 2e-3,
    };

    /// 100 cells of 1000 samples each, a unit in each.
    const LOAD: Load = Load { samples: 100_000.0, units: 100, shared: 100, cells: 100, before: 0.0 };

    fn close(a: f64, b: f64) {
        assert!((a - b).abs() < 1e-9 * b.abs().max(1.0), "{a} is not {b}");
    }

    #[test]
    fn one_shard_on_one_thread_is_the_sum_of_its_steps() {
        let cost = LOAD.cost(&RATES, Nodes { nodes: 1, threads: 1 }, 1);
        // 100 s of computing: 10 pieces in the first second, 41 until 50 s, 10 afterwards, and one at the end.
        assert_eq!((cost.pieces, cost.limit), (62, Limit::Computing));
        close(cost.shard, 0.2 + 0.3 + 0.1 + 100.0 + 0.5);
        close(cost.all, cost.shard);
        close(cost.merge, 0.2 + 0.3 + 62.0 * 0.01 + 100.0 * 1e-4 + 100.0 * 2e-3 + 0.5);
        close(cost.total, cost.all + cost.merge);
        close(cost.efficiency, 100.0 / cost.total);
    }

    #[test]
    fn shards_run_in_rounds_and_read_what_is_there() {
        let cost = LOAD.cost(&RATES, Nodes { nodes: 4, threads: 1 }, 10);
        // Three rounds of ten units each. A shard of 10 s writes 10 + 24 + 1 pieces, but has 10 units.
        close(cost.computing, 10.0);
        assert_eq!(cost.pieces, 100);
        // The second round reads four shards, the third eight.
        let reading = 12.0 * (10.0 * 0.01 + 10.0 * 1e-4);
        close(cost.all, 3.0 * (0.51 + 10.0 + 0.5) + reading);
        close(cost.shard, 0.51 + 10.0 + 0.5 + reading / 3.0);
    }

    #[test]
    fn nodes_and_threads_without_work_are_reported() {
        let on = |nodes, threads| Nodes { nodes, threads };
        assert_eq!(LOAD.cost(&RATES, on(50, 1), 1).limit, Limit::Idling);
        // A unit is not shared among threads.
        close(LOAD.cost(&RATES, on(1, 64), 100).computing, 1.0);
        close(LOAD.cost(&RATES, on(1, 64), 1).computing, 2.0);
        let by_cells = Load { shared: 3, ..LOAD };
        close(by_cells.cost(&RATES, on(2, 1), 2).computing, 200.0 / 3.0);
    }

    #[test]
    fn shards_without_work_write_nothing() {
        let cost = |shards| LOAD.cost(&RATES, Nodes { nodes: 1000, threads: 1 }, shards);
        assert_eq!([10, 100, 1000].map(|shards| cost(shards).pieces), [100, 100, 100]);
        close(cost(1000).merge, cost(100).merge);
    }

    #[test]
    fn what_takes_most_is_the_limit() {
        let on = Nodes { nodes: 100, threads: 1 };
        let limit = |rates: Rates, load: Load| load.cost(&rates, on, 1000).limit;
        let quick = Rates { sample: 1e-9, ..RATES };
        let many = Load { units: 100_000, shared: 100_000, ..LOAD };
        assert_eq!(limit(Rates { start: 60.0, ..quick }, many), Limit::Starting);
        assert_eq!(limit(Rates { unit_handled: 60.0, ..quick }, many), Limit::Handling);
        assert_eq!(limit(Rates { piece_written: 60.0, ..quick }, many), Limit::Writing);
        assert_eq!(limit(Rates { piece_read: 60.0, ..quick }, many), Limit::Reading);
        assert_eq!(limit(Rates { row: 60.0, ..quick }, many), Limit::Merging);
        assert_eq!(limit(Rates { sample: 60.0, ..quick }, many), Limit::Computing);
        assert_eq!(limit(quick, Load { before: 1e6, ..many }), Limit::Idling);
    }

    #[test]
    fn the_best_number_of_shards_takes_the_least_time() {
        let load = Load { samples: 1e8, units: 100_000, shared: 100_000, ..LOAD };
        // Pieces that are read at once, as on a local disk.
        let rates = Rates { piece_read: 0.0, unit_read: 0.0, ..RATES };
        let best = |nodes, others: &[u64]| load.best(&rates, Nodes { nodes, threads: 1 }, others).shards;
        // 100 000 s on one thread are 167 shards of ten minutes.
        assert_eq!(best(1, &[]), 167);
        assert_eq!(best(100, &[]), 200);
        assert_eq!(best(500, &[]), 500);
        assert_eq!(best(100, &[1, 10, 100, 1000]), 200, "one round of 100 shards saves less than 5 %");
        // Two rounds of 501 s or less, or one of 1000 s: the second round reads the pieces of the first.
        let slow = |others: &[u64]| load.best(&RATES, Nodes { nodes: 100, threads: 1 }, others).shards;
        assert_eq!((slow(&[]), slow(&[1, 10, 100, 1000])), (200, 100));
        let small = Load { samples: 10.0, ..LOAD };
        let best = |load: &Load, nodes| load.best(&RATES, Nodes { nodes, threads: 1 }, &[1, 10, 100, 1000]).shards;
        assert_eq!(best(&small, 100), 1);
        assert_eq!(best(&LOAD, 1000), 100, "no more than units");
    }

    #[test]
    fn no_number_of_shards_that_is_shown_is_clearly_quicker_than_the_proposed_one() {
        let shown = [1, 10, 100, 1000];
        for (nodes, threads) in [(1, 1), (3, 8), (10, 4), (100, 32), (100_000, 1)] {
            for samples in [1e2, 1e4, 1e6, 1e8, 1e10] {
                for units in [1, 40, 1040, 1_000_000] {
                    let (load, on) = (Load { samples, units, shared: units, ..LOAD }, Nodes { nodes, threads });
                    let best = load.best(&RATES, on, &shown).total;
                    let quickest =
                        shown.map(|shards| load.cost(&RATES, on, shards).total).into_iter().fold(best, f64::min);
                    assert!(best <= AS_GOOD * quickest, "{on:?}, {load:?}: {best} s, {quickest} s");
                }
            }
        }
    }

    #[test]
    fn pieces_grow_with_the_logarithm_and_then_with_time() {
        assert_eq!([0.0, 0.05, 0.55, 1.05].map(pieces_of), [1.0, 1.0, 6.0, 11.0]);
        assert_eq!(pieces_of(3650.0) - pieces_of(50.0), 720.0);
    }
}
