//! Crossings of the share of unstable samples, with bounds from the binomial interval.
//!
//! Each sample is unstable between expected values of its own ([`spans`](super::spans)). In a sweep over the sorted ends
//! of all spans the counts are known at every value, and so is the interval of the probability. Where the probability
//! passes the target `p` once, the values at which the interval contains `p` are an interval of the limit with the same
//! confidence: the true limit is missed exactly when the interval at that value misses `p`.

use std::ops::{AddAssign, Range};

use super::spans::{Span, Spans};
use super::{Limit, State};
use crate::estimate::interval::BinomialInterval;

/// An end of a span: how the counts change there.
#[derive(Debug, Clone, Copy)]
struct Event {
    at: f64,
    unstable: i8,
    without_verdict: i8,
}

/// Counts of samples at one value, or how these change there.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Counts {
    pub(super) unstable: i64,
    pub(super) without_verdict: i64,
}

/// The verdicts of samples over an axis.
#[derive(Debug, Clone)]
pub struct Sweep {
    range: Span,
    samples: u64,
    /// Just above the lower end of the range.
    first: Counts,
    events: Vec<Event>,
}

impl Sweep {
    /// A sweep over a range, without samples yet.
    #[must_use]
    pub fn new(range: Span) -> Self {
        Self { range, samples: 0, first: Counts::default(), events: Vec::new() }
    }

    /// Adds a sample.
    pub fn add(&mut self, spans: &Spans) {
        self.samples += 1;
        self.add_span(spans.unstable, 1, 0);
        spans.without_verdict.iter().for_each(|&span| self.add_span(span, 0, 1));
    }

    fn add_span(&mut self, [from, to]: Span, unstable: i8, without_verdict: i8) {
        if from >= to || to <= self.range[0] || from >= self.range[1] {
            return;
        }
        if from <= self.range[0] {
            self.first.unstable += i64::from(unstable);
            self.first.without_verdict += i64::from(without_verdict);
        } else {
            self.events.push(Event { at: from, unstable, without_verdict });
        }
        if to < self.range[1] {
            self.events.push(Event { at: to, unstable: -unstable, without_verdict: -without_verdict });
        }
    }

    /// The same with its events in order, for any number of targets.
    #[must_use]
    pub fn sorted(mut self) -> SortedSweep {
        // Those at the same value are taken together, so that their order does not matter.
        self.events.sort_unstable_by(|a, b| a.at.total_cmp(&b.at));
        SortedSweep(self)
    }
}

/// A sweep whose events are in order.
#[derive(Debug, Clone)]
pub struct SortedSweep(Sweep);

/// Where counts are relative to a target.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    /// The whole interval is within the target.
    Within,
    /// The target lies in the interval.
    Open,
    /// The whole interval is above the target.
    Above,
}

/// From which counts on the interval is above a target, or reaches it.
struct Thresholds {
    samples: u64,
    target: f64,
    /// Least number of unstable samples with a lower end above the target.
    above: i64,
    /// Least number of unstable samples with an upper end above the target.
    open: i64,
}

impl Thresholds {
    fn new(samples: u64, target: f64, interval: &BinomialInterval) -> Self {
        let least = |exceeds: &dyn Fn(u64) -> bool| {
            let mut candidates: Range<u64> = 0..samples + 1;
            while candidates.start < candidates.end {
                let middle = candidates.start + (candidates.end - candidates.start) / 2;
                if exceeds(middle) { candidates.end = middle } else { candidates.start = middle + 1 }
            }
            candidates.start.cast_signed()
        };
        Self {
            samples,
            target,
            above: least(&|count| interval.bounds(count, samples).0 > target),
            open: least(&|count| interval.bounds(count, samples).1 > target),
        }
    }

    /// As [`BinomialInterval::estimate`]: samples without a verdict may be stable or unstable.
    fn place(&self, counts: Counts) -> Place {
        if counts.unstable >= self.above {
            Place::Above
        } else if counts.unstable + counts.without_verdict >= self.open {
            Place::Open
        } else {
            Place::Within
        }
    }

    /// Whether the estimate is above the target.
    fn is_over(&self, counts: Counts) -> bool {
        counts.unstable as f64 > self.target * (self.samples.cast_signed() - counts.without_verdict) as f64
    }
}

/// Where the estimate passed the target since the interval last excluded it.
#[derive(Debug, Clone, Copy)]
struct Passages {
    first: (f64, State),
    last: (f64, State),
}

/// What a sweep has met up to a value.
struct Met {
    limits: Vec<Limit>,
    /// Where the interval began to contain the target, if it does.
    open_from: Option<f64>,
    passages: Option<Passages>,
    /// From the first to the last value at which it did without a passage.
    undecided: Option<Span>,
}

impl Met {
    /// The interval excludes the target from `at` on, or the range ends there.
    fn close(&mut self, at: f64) {
        let open_from = self.open_from.take();
        let bounds = [open_from.unwrap_or(at), at];
        let limit = |(value, state): (f64, State)| Limit { state, value: Some(value), bounds: Some(bounds) };
        match self.passages.take() {
            None if open_from.is_some() => {
                let from = self.undecided.map_or(bounds[0], |[from, _]| from);
                self.undecided = Some([from, at]);
            }
            None => {}
            // To and fro within one interval is one passage: the first rise, or the last fall.
            Some(Passages { first, last }) if first.1 == last.1 => {
                self.limits.push(limit(if first.1 == State::Rises { first } else { last }));
            }
            Some(Passages { first, last }) => self.limits.extend([limit(first), limit(last)]),
        }
    }
}

impl SortedSweep {
    /// The counts just above the lower end of the range.
    pub(super) fn first(&self) -> Counts {
        self.0.first
    }

    /// Where counts change, rising, and how.
    pub(super) fn changes(&self) -> impl Iterator<Item = (f64, Counts)> {
        self.0.events.iter().map(|event| (event.at, event.counts()))
    }

    /// The number of samples.
    #[must_use]
    pub fn samples(&self) -> u64 {
        self.0.samples
    }

    /// The estimates just within the two ends of the range; `None` without a decided sample.
    #[must_use]
    pub fn ends(&self) -> [Option<f64>; 2] {
        let mut last = self.0.first;
        self.changes().for_each(|(_, change)| last += change);
        [self.0.first, last].map(|counts| {
            let decided = self.0.samples.cast_signed() - counts.without_verdict;
            (decided > 0).then(|| counts.unstable as f64 / decided as f64)
        })
    }

    /// Every value at which the estimate passes `target`, in rising order, with the values around it at which the
    /// interval contains the target; if there is none, one entry that says on which side the estimate is.
    #[must_use]
    pub fn limits(&self, target: f64, interval: &BinomialInterval) -> Vec<Limit> {
        let Sweep { range, samples, first, ref events } = self.0;
        let thresholds = Thresholds::new(samples, target, interval);
        let mut counts = first;
        let (mut place, mut is_over) = (thresholds.place(counts), thresholds.is_over(counts));
        let open_from = (place == Place::Open).then_some(range[0]);
        let mut met = Met { limits: Vec::new(), open_from, passages: None, undecided: None };
        for same in events.chunk_by(|a, b| a.at == b.at) {
            let at = same[0].at;
            same.iter().for_each(|event| counts += event.counts());
            let (next, next_is_over) = (thresholds.place(counts), thresholds.is_over(counts));
            if next_is_over != is_over {
                let passage = (at, State::passing(next_is_over));
                met.passages = Some(Passages { first: met.passages.map_or(passage, |met| met.first), last: passage });
            }
            if next != place {
                if next == Place::Open {
                    met.open_from = Some(at);
                } else {
                    met.close(at);
                }
            }
            (place, is_over) = (next, next_is_over);
        }
        if place == Place::Open {
            met.close(range[1]);
        }
        if met.limits.is_empty() {
            met.limits.push(Limit { state: State::without_limit(is_over), value: None, bounds: met.undecided });
        }
        met.limits
    }
}

impl Event {
    fn counts(&self) -> Counts {
        Counts { unstable: self.unstable.into(), without_verdict: self.without_verdict.into() }
    }
}

impl AddAssign for Counts {
    fn add_assign(&mut self, change: Self) {
        self.unstable += change.unstable;
        self.without_verdict += change.without_verdict;
    }
}

#[cfg(test)]
mod tests;
