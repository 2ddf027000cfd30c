//! The size of shards: among how many processes a job is shared, by what it costs.

/// Seconds that a shard takes at most, where their number is not limited. A cluster takes from a part of a second to a
/// minute to start a task, and a task that is lost costs no more than this.
const LONGEST: f64 = 600.0;

/// Largest number of shards where it is not given. Slurm numbers the tasks of an array up to 1000 unless it is
/// configured otherwise.
pub const MOST_TASKS: u64 = 1000;

/// The number of shards, from 1 to `most`, for work that takes one thread so many `seconds` and comes in so many
/// `units`, which a thread computes one at a time. Each shard has this many threads, and a unit for each of them as far
/// as there are enough.
pub fn number_of_shards(seconds: f64, units: u64, threads: usize, most: u64) -> u64 {
    let threads = threads.max(1) as u64;
    // A number that is not known is 0 here.
    let wanted = (seconds / (threads as f64 * LONGEST)).ceil() as u64;
    wanted.min(most).min(units.div_ceil(threads)).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shard_takes_ten_minutes_at_most() {
        assert_eq!(number_of_shards(0.3, 1_000_000, 1, MOST_TASKS), 1);
        assert_eq!(number_of_shards(600.0, 1_000_000, 1, MOST_TASKS), 1);
        assert_eq!(number_of_shards(601.0, 1_000_000, 1, MOST_TASKS), 2);
        assert_eq!(number_of_shards(36_000.0, 1_000_000, 1, MOST_TASKS), 60);
        assert_eq!(number_of_shards(36_000.0, 1_000_000, 8, MOST_TASKS), 8, "60 / 8, rounded up");
    }

    #[test]
    fn there_are_no_more_shards_than_tasks_or_work() {
        assert_eq!(number_of_shards(1e9, 1_000_000, 1, MOST_TASKS), 1000);
        assert_eq!(number_of_shards(1e9, 1_000_000, 1, 50), 50);
        assert_eq!(number_of_shards(1e9, 7, 1, MOST_TASKS), 7);
        assert_eq!(number_of_shards(1e9, 7, 4, MOST_TASKS), 2, "no thread without a unit while another has two");
        for (seconds, units) in [(f64::NAN, 10), (0.0, 10), (1e9, 0)] {
            assert_eq!(number_of_shards(seconds, units, 1, MOST_TASKS), 1, "{seconds} s in {units} units");
        }
        assert_eq!(number_of_shards(f64::INFINITY, u64::MAX, 0, 1000), 1000);
    }
}
