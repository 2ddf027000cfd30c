//! `status --watch`: the progress of a run as it goes on, from its directory alone.

use std::ffi::OsString;
use std::io::{self, IsTerminal as _};
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use indicatif::HumanCount;

use super::run_progress::RunProgress;
use super::shard_progress::ShardProgress;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::output::{HumanCount128, rate, result};
use crate::picture::view::rounded;
use crate::schedule::time_left;
use crate::store::directory::RunDirectory;

/// Time between two looks. Where reading a run takes long, it is a small part of the time.
const PAUSE: Duration = Duration::from_secs(1);
const SHARE_OF_READING: u32 = 5;

/// Characters of the bar.
const BAR: usize = 40;

/// Shows the progress of a run, and of this many shards of it, until no process works in it.
pub fn watch(directory: &RunDirectory, path: &Path, shards: Option<u64>, interrupt: &Interrupt) -> Result<(), Failure> {
    interrupt.remark("the run itself is not touched");
    let is_terminal = io::stdout().is_terminal() && std::env::var_os("TERM").is_none_or(|term| term != "dumb");
    let mut seen = Seen::read(directory)?;
    let mut progress = RunProgress::of_shards(directory, directory.job()?, shards)?;
    let mut speed = Speed::default();
    let mut shown = String::new();
    while progress.in_use {
        let started = Instant::now();
        speed.record(started, progress.samples_done);
        let block = block(&progress, &speed);
        if is_terminal {
            result(&format!("{}{block}", erased(&shown)))?;
        } else if block != shown {
            let gap = if shown.is_empty() { "" } else { "\n" };
            result(&format!("{gap}{block}"))?;
        }
        shown = block;
        thread::sleep(PAUSE.max(SHARE_OF_READING * speed.reading));
        let looked = Instant::now();
        progress = seen.look(directory, progress)?;
        speed.reading = looked.elapsed();
    }
    // What the last process wrote at its end.
    let end = RunProgress::of_shards(directory, directory.job()?, shards)?;
    let end = bars(&end) + &end.text(path);
    result(&if is_terminal { erased(&shown) + &end } else { end })
}

/// What erases these lines, the last ones on a terminal. They have no more than 80 columns.
fn erased(lines: &str) -> String {
    let count = lines.lines().count();
    if count > 0 { format!("\x1b[{count}A\x1b[J") } else { String::new() }
}

/// What a look has seen. What takes time is done again only if something else is there.
struct Seen {
    job: String,
    pieces: Vec<OsString>,
}

impl Seen {
    fn read(directory: &RunDirectory) -> Result<Self, Failure> {
        let job = directory.job_source()?.map(|source| source.text).unwrap_or_default();
        let shards = directory.shards();
        let pieces = shards.names().map_err(|error| Failure::reading(shards.path(), error))?;
        Ok(Self { job, pieces })
    }

    /// The progress now.
    fn look(&mut self, directory: &RunDirectory, before: RunProgress) -> Result<RunProgress, Failure> {
        let now = Self::read(directory)?;
        let is_same_job = now.job == self.job;
        if is_same_job && now.pieces == self.pieces {
            return Ok(RunProgress { in_use: directory.in_use(), ..before });
        }
        *self = now;
        let job = if is_same_job { before.job } else { directory.job()? };
        RunProgress::of_shards(directory, job, before.shards.as_ref().map(ShardProgress::count))
    }
}

/// How fast samples arrive in the directory. They come in pieces, so that the time between two arrivals counts and not
/// the time since the first look.
#[derive(Default)]
struct Speed {
    /// When the number of samples changed for the first time, and the number then.
    first: Option<(Instant, u128)>,
    /// The same for the last time.
    last: Option<(Instant, u128)>,
    /// The number at the last look.
    known: Option<u128>,
    /// How long the last look took.
    reading: Duration,
}

impl Speed {
    fn record(&mut self, now: Instant, samples: u128) {
        if self.known.is_some_and(|known| known != samples) {
            self.first.get_or_insert((now, samples));
            self.last = Some((now, samples));
        }
        self.known = Some(samples);
    }

    /// Samples in a second; `None` before the second arrival.
    fn samples_per_second(&self) -> Option<f64> {
        let ((from, before), (to, after)) = (self.first?, self.last?);
        let seconds = to.duration_since(from).as_secs_f64();
        (seconds > 0.0).then(|| after.saturating_sub(before) as f64 / seconds)
    }
}

/// A bar with its share in per cent.
fn bar(share: f64) -> String {
    let filled = ((share * BAR as f64) as usize).min(BAR);
    format!("{}{} {:5.1} %", "█".repeat(filled), "░".repeat(BAR - filled), 100.0 * share)
}

/// A bar for each shard.
fn bars(progress: &RunProgress) -> String {
    let Some(shards) = &progress.shards else { return String::new() };
    let count = shards.count();
    (1..).zip(&shards.shares).map(|(shard, share)| format!("{}  shard {shard}/{count}\n", bar(*share))).collect()
}

/// What is shown, in lines of at most 80 columns.
fn block(progress: &RunProgress, speed: &Speed) -> String {
    let RunProgress { job, share, samples_done, samples_total, complete_cells, .. } = progress;
    let name: String = job.name.chars().take(60).collect();
    let mut text = format!("{name}: {}\n{}\n", progress.state, bar(*share));
    text += &bars(progress);
    if !job.draws_samples() {
        return text + "It integrates its probabilities, and writes nothing before the end.\n";
    }
    let at_most = if job.stops_by_precision() { "at most " } else { "" };
    let (done, total) = (HumanCount128(*samples_done), HumanCount128(*samples_total));
    text += &format!(
        "{done} of {at_most}{total} samples, {} of {} cells finished\n",
        HumanCount(*complete_cells),
        HumanCount(job.cells())
    );
    text += &match speed.samples_per_second() {
        None => "rate not known yet: finished samples are saved every few seconds\n".to_owned(),
        Some(samples) if samples > 0.0 && !job.stops_by_precision() => {
            let left = (*samples_total - *samples_done) as f64 / samples;
            format!("{} samples/s, about {} left\n", rate(samples), time_left::Duration(left))
        }
        // How many samples it takes is not known in advance.
        Some(samples) => format!("{} samples/s\n", rate(samples)),
    };
    text + &match progress.probability {
        None => "no probability yet\n".to_owned(),
        Some((mean, cells)) => format!(
            "mean probability of instability so far: {}, over {} of {} cells\n",
            rounded(mean),
            HumanCount(cells),
            HumanCount(job.cells())
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rate_is_that_between_arrivals() {
        let start = Instant::now();
        let mut speed = Speed::default();
        for (seconds, samples) in [(0, 500), (1, 500), (2, 1000), (3, 1000), (4, 3000)] {
            assert_eq!(speed.samples_per_second(), None, "after less than two arrivals");
            speed.record(start + Duration::from_secs(seconds), samples);
        }
        assert_eq!(speed.samples_per_second(), Some(1000.0));
        speed.record(start + Duration::from_secs(5), 3000);
        assert_eq!(speed.samples_per_second(), Some(1000.0), "nothing has arrived");
    }
}
