//! Progress of a computation: a bar on a terminal, plain lines elsewhere.

use std::io::{self, IsTerminal as _};
use std::time::{Duration, Instant};

use indicatif::{HumanCount, ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::messages::{Code, Message, Numbers, are_json};
use crate::output::rate;
use crate::schedule::bar_line::{BarLine, width};
use crate::schedule::time_left::{Prediction, RateMeter};

/// Time between plain lines. A line is also printed when another twentieth is done, after the shortest time, and once
/// when the time left is first known.
const PLAIN_INTERVAL: Duration = Duration::from_secs(30);
const PLAIN_SHORTEST: Duration = Duration::from_secs(2);

/// Time between messages for programs, which draw a bar of them.
const JSON_INTERVAL: Duration = Duration::from_millis(200);

/// Characters of a bar, and of what stands beside it but for the text: its share and spaces; and how often it is drawn.
const BAR: usize = 20;
const BESIDE: usize = 8;
const DRAWN_A_SECOND: u8 = 20;

/// What is known of the total.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Total {
    /// It is certain.
    Known,
    /// It is expected.
    Expected,
    /// It may be larger.
    AtLeast,
}

/// Shows the progress of a computation on standard error.
#[derive(Debug)]
pub struct Progress {
    bar: Option<ProgressBar>,
    total: u64,
    kind: Total,
    unit: &'static str,
    /// The step of a longer computation to which the time left belongs; empty if that is all of it.
    step: &'static str,
    done: u64,
    started: Instant,
    meter: RateMeter,
    last_line: Instant,
    last_done: u64,
    /// Whether a line has shown the time left.
    has_shown_time_left: bool,
}

impl Progress {
    /// Progress towards `total` samples, or other things that `unit` names.
    pub fn new(total: u128, unit: &'static str) -> Self {
        let total = u64::try_from(total).unwrap_or(u64::MAX);
        let bar = (io::stderr().is_terminal() && !are_json()).then(|| {
            let bar = ProgressBar::with_draw_target(
                Some(total),
                ProgressDrawTarget::term_like_with_hz(Box::<BarLine>::default(), DRAWN_A_SECOND),
            );
            let style = ProgressStyle::with_template(&format!("{{bar:{BAR}}} {{percent:>3}} %  {{msg}}"));
            bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        });
        let now = Instant::now();
        Self {
            bar,
            total,
            kind: Total::Known,
            unit,
            step: "",
            done: 0,
            started: now,
            meter: RateMeter::new(),
            last_line: now,
            last_done: 0,
            has_shown_time_left: false,
        }
    }

    /// Says that the time left is that of a first step only, which `step` names.
    pub fn of_step(self, step: &'static str) -> Self {
        Self { step, ..self }
    }

    /// Replaces the total, so that this much is left.
    pub fn expect_left(&mut self, left: u128, kind: Total) {
        self.total = self.done.saturating_add(u64::try_from(left).unwrap_or(u64::MAX));
        self.kind = kind;
    }

    /// Adds finished samples (or other units).
    pub fn advance(&mut self, samples: u64) {
        self.done += samples;
        // More than was predicted.
        self.total = self.total.max(self.done);
    }

    /// Updates the bar, or prints a plain line if one is due.
    pub fn tick(&mut self) {
        self.meter.record(self.started.elapsed().as_secs_f64(), self.done as f64);
        if let Some(bar) = &self.bar {
            bar.set_length(self.total);
            bar.set_position(self.done);
            // Parts of a line that is too long would stay behind.
            let width = usize::from(width()).saturating_sub(BAR + BESIDE);
            let fitting = self.texts().into_iter().find(|text| text.chars().count() <= width);
            bar.set_message(fitting.unwrap_or_else(|| self.left().chars().take(width).collect()));
            return;
        }
        let since = self.last_line.elapsed();
        let another_twentieth = (self.done - self.last_done).saturating_mul(20) >= self.total;
        let is_first = !self.has_shown_time_left && self.time_left() != Prediction::Unknown;
        let is_due = if are_json() {
            since >= JSON_INTERVAL
        } else {
            since >= PLAIN_INTERVAL || ((another_twentieth || is_first) && since >= PLAIN_SHORTEST)
        };
        if is_due {
            self.last_line = Instant::now();
            self.last_done = self.done;
            self.has_shown_time_left |= is_first;
            let share = 100.0 * self.done as f64 / self.total.max(1) as f64;
            let [text, _] = self.texts();
            let message = Message::new(Code::Progress, &format!("{share:.0} %: {text}"));
            Message { progress: Some(self.numbers()), ..message }.send();
        }
    }

    /// How long the rest takes.
    fn time_left(&self) -> Prediction {
        let left = self.total - self.done;
        // More than was predicted.
        if left == 0 && self.kind != Total::Known {
            return Prediction::Unknown;
        }
        let time = self.meter.time_left(self.started.elapsed().as_secs_f64(), self.done as f64, left as f64);
        if self.kind == Total::AtLeast { time.at_least() } else { time }
    }

    /// Units in a second.
    fn rate(&self) -> f64 {
        self.done as f64 / self.started.elapsed().as_secs_f64().max(1e-9)
    }

    /// What is done, how fast, and how long the rest takes, in numbers.
    fn numbers(&self) -> Numbers {
        Numbers {
            done: self.done,
            total: self.total,
            total_is: match self.kind {
                Total::Known => "known",
                Total::Expected => "expected",
                Total::AtLeast => "at-least",
            },
            unit: self.unit,
            rate: self.rate(),
            seconds_left: self.time_left().seconds(),
        }
    }

    /// How long the rest takes.
    fn left(&self) -> String {
        let step = if self.step.is_empty() { String::new() } else { format!(" for {}", self.step) };
        match self.time_left() {
            _ if self.done >= self.total && self.kind == Total::Known => "finishing".to_owned(),
            Prediction::Unknown => "estimating the time left".to_owned(),
            known if known.seconds().is_some_and(|seconds| seconds < 1.0) => {
                format!("less than a second left{step}")
            }
            known => format!("{known} left{step}"),
        }
    }

    /// What is done, how fast, and how long the rest takes; and the same without how fast.
    fn texts(&self) -> [String; 2] {
        let (rate, left) = (rate(self.rate()), self.left());
        let done = format!(
            "{} of {}{} {unit}",
            HumanCount(self.done),
            match self.kind {
                Total::Known => "",
                Total::Expected => "about ",
                Total::AtLeast => "at least ",
            },
            HumanCount(self.total),
            unit = self.unit
        );
        [format!("{done}, {rate} {}/s, {left}", self.unit), format!("{done}, {left}")]
    }

    /// Removes the bar.
    pub fn finish(self) {
        if let Some(bar) = self.bar {
            bar.finish_and_clear();
        }
    }
}
