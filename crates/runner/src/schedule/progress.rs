//! Progress of a computation: a bar on a terminal, plain lines elsewhere.

use std::fmt::Write;
use std::io::{self, IsTerminal as _};
use std::time::{Duration, Instant};

use indicatif::{HumanCount, HumanDuration, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

use crate::output::note;

/// Time between plain lines. A line is also printed when another twentieth is done, after the shortest time.
const PLAIN_INTERVAL: Duration = Duration::from_secs(30);
const PLAIN_SHORTEST: Duration = Duration::from_secs(2);

/// Shows the progress of a computation on standard error.
#[derive(Debug)]
pub struct Progress {
    bar: Option<ProgressBar>,
    total: u64,
    unit: &'static str,
    done: u64,
    started: Instant,
    last_line: Instant,
    last_done: u64,
}

impl Progress {
    /// Progress towards `total` samples, or other things that `unit` names.
    pub fn new(total: u128, unit: &'static str) -> Self {
        let total = u64::try_from(total).unwrap_or(u64::MAX);
        let bar = io::stderr().is_terminal().then(|| {
            let bar = ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::stderr());
            let template = format!(
                "{{bar:30}} {{percent:>3}} %  {{human_pos}} of {{human_len}} {unit}  {{rate}} {unit}/s  {{eta}} left"
            );
            let rate = |state: &ProgressState, out: &mut dyn Write| {
                // An error would only leave the rate out of the bar.
                let _ = write!(out, "{}", HumanCount(state.per_sec() as u64));
            };
            let style = ProgressStyle::with_template(&template).unwrap_or_else(|_| ProgressStyle::default_bar());
            bar.set_style(style.with_key("rate", rate));
            bar
        });
        let now = Instant::now();
        Self { bar, total, unit, done: 0, started: now, last_line: now, last_done: 0 }
    }

    /// Adds finished samples (or other units).
    pub fn advance(&mut self, samples: u64) {
        self.done += samples;
        if let Some(bar) = &self.bar {
            bar.set_position(self.done);
        }
    }

    /// Prints a plain line if one is due.
    pub fn tick(&mut self) {
        if self.bar.is_some() {
            return;
        }
        let since = self.last_line.elapsed();
        let another_twentieth = (self.done - self.last_done).saturating_mul(20) >= self.total;
        if since >= PLAIN_INTERVAL || (another_twentieth && since >= PLAIN_SHORTEST) {
            self.last_line = Instant::now();
            self.last_done = self.done;
            let seconds = self.started.elapsed().as_secs_f64();
            let rate = self.done as f64 / seconds;
            let left = Duration::from_secs_f64(((self.total - self.done) as f64 / rate.max(1e-9)).min(1e9));
            note(format_args!(
                "{} of {} {unit} ({:.0} %), {} {unit}/s, {} left",
                HumanCount(self.done),
                HumanCount(self.total),
                100.0 * self.done as f64 / self.total as f64,
                HumanCount(rate as u64),
                HumanDuration(left),
                unit = self.unit
            ));
        }
    }

    /// Removes the bar.
    pub fn finish(self) {
        if let Some(bar) = self.bar {
            bar.finish_and_clear();
        }
    }
}
