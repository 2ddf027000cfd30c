//! One thread's work on units: it evaluates their samples a few at a time, so that it can stop soon, and hands over
//! what is finished.

use std::cell::Cell;
use std::ops::Range;
use std::time::{Duration, Instant};

use stickslip_core::model::IsStopped;

use crate::evaluate::control::Control;
use crate::evaluate::evaluator::Evaluator;
use crate::evaluate::stream;
use crate::evaluate::unit::FinishedUnit;

/// Time that the samples of one evaluation should take: short enough to stop soon after a signal, long enough for the
/// vector lanes to be busy most of it.
const AT_ONCE: Duration = Duration::from_millis(300);

/// Samples of the first evaluation, whose cost is not known.
const FIRST: u64 = 4;

/// How much larger an evaluation may be than the one before, at most.
const GROWTH: f64 = 4.0;

impl Evaluator<'_> {
    /// Evaluates the units of work, each some samples of a part, that `next` returns until it returns `None`. Hands
    /// finished samples to `emit`: each unit as a whole, or, if it is interrupted, in several parts without gaps, in
    /// their order. Asks `control` what to do after every few samples.
    pub fn work(
        &self,
        next: &dyn Fn() -> Option<(u64, Range<u64>)>,
        emit: &mut dyn FnMut(FinishedUnit),
        control: &dyn Fn() -> Control,
    ) {
        match self.job.model().simulation().filter(|_| !self.job.answer().is_of_rare_events()) {
            Some(simulation) => stream::work(self, simulation, next, emit, control),
            None => work(&|part, samples, is_stopped| self.count(part, samples, is_stopped), next, emit, control),
        }
    }

    /// Audits the maps behind integrals, or draws plain samples, like [`Evaluator::work`]: a part is a cell.
    pub fn work_on_audits(
        &self,
        next: &dyn Fn() -> Option<(u64, Range<u64>)>,
        emit: &mut dyn FnMut(FinishedUnit),
        control: &dyn Fn() -> Control,
    ) {
        work(&|cell, samples, is_stopped| self.audit_integral(cell, samples, is_stopped), next, emit, control);
    }
}

/// Evaluates some samples of a part, unless it is stopped before.
type Count<'a> = dyn Fn(u64, Range<u64>, IsStopped<'_>) -> Option<FinishedUnit> + 'a;

/// See [`Evaluator::work`]; `count` evaluates some samples of a part.
fn work(
    count: &Count<'_>,
    next: &dyn Fn() -> Option<(u64, Range<u64>)>,
    emit: &mut dyn FnMut(FinishedUnit),
    control: &dyn Fn() -> Control,
) {
    let asked = Cell::new(Control::Continue);
    // A motion may take many seconds, so that it is asked for a stop in its middle, too.
    let is_stopped = || {
        asked.set(asked.get().max(control()));
        asked.get() == Control::Stop
    };
    let mut pace = Pace::default();
    while let Some((part, samples)) = next() {
        pace.begin(samples.end - samples.start);
        let mut finished: Option<FinishedUnit> = None;
        let mut first = samples.start;
        while first < samples.end {
            let end = samples.end.min(first.saturating_add(pace.at_once));
            let begun = Instant::now();
            let Some(counted) = count(part, first..end, &is_stopped) else {
                finished.into_iter().for_each(&mut *emit);
                return;
            };
            pace.learn(end - first, begun.elapsed());
            match &mut finished {
                Some(finished) => finished.append(&counted),
                None => finished = Some(counted),
            }
            first = end;
            let must_stop = is_stopped();
            if asked.replace(Control::Continue) != Control::Continue {
                finished.take().into_iter().for_each(&mut *emit);
            }
            if must_stop {
                return;
            }
        }
        finished.into_iter().for_each(&mut *emit);
    }
}

/// How many samples to evaluate at once, by the cost of those before.
#[derive(Debug)]
struct Pace {
    at_once: u64,
    /// Seconds that a sample took in the last evaluation.
    cost: Option<f64>,
}

impl Default for Pace {
    fn default() -> Self {
        Self { at_once: FIRST, cost: None }
    }
}

impl Pace {
    /// Begins a unit. It is evaluated at once if that is expected to take little longer than it should. Otherwise the
    /// first evaluation is small, as the unit may be in another cell, whose samples cost many times as much.
    fn begin(&mut self, samples: u64) {
        let Some(cost) = self.cost else { return };
        if cost * samples as f64 <= 2.0 * AT_ONCE.as_secs_f64() {
            self.at_once = samples;
        } else {
            self.at_once = (self.at_once as f64 / GROWTH).max(1.0) as u64;
        }
    }

    /// Takes the time of an evaluation into account.
    fn learn(&mut self, samples: u64, took: Duration) {
        let cost = took.as_secs_f64() / samples as f64;
        let affordable = AT_ONCE.as_secs_f64() / cost.max(1e-12);
        self.at_once = affordable.min(self.at_once as f64 * GROWTH).max(1.0) as u64;
        self.cost = Some(cost);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::unit::Recorded;
    use std::thread;
    use stickslip_core::model::verdict::VerdictCounts;

    fn counted(part: u64, samples: Range<u64>) -> FinishedUnit {
        let counts = VerdictCounts { stable: samples.end - samples.start, ..Default::default() };
        let sums = vec![samples.clone().sum::<u64>().cast_signed()];
        FinishedUnit { part, samples, counts, recorded: Recorded::default(), sums }
    }

    /// Works on two units, and asks for `control` at its turns.
    fn emitted(cost: Duration, control: impl Fn(u32) -> Control) -> Vec<FinishedUnit> {
        let units = [(3, 200..1000), (4, 0..1000)];
        let (given, asked) = (Cell::new(0), Cell::new(0));
        let next = || {
            given.set(given.get() + 1);
            units.get(given.get() - 1).cloned()
        };
        let count = |part: u64, samples: Range<u64>, _: IsStopped<'_>| {
            thread::sleep(cost * (samples.end - samples.start) as u32);
            Some(counted(part, samples))
        };
        let mut emitted = Vec::new();
        work(&count, &next, &mut |unit| emitted.push(unit), &|| {
            asked.set(asked.get() + 1);
            control(asked.get())
        });
        emitted
    }

    #[test]
    fn units_that_are_not_interrupted_are_handed_over_whole() {
        let units = emitted(Duration::ZERO, |_| Control::Continue);
        assert_eq!(units, [counted(3, 200..1000), counted(4, 0..1000)]);
    }

    #[test]
    fn a_flush_hands_over_what_is_finished_and_goes_on() {
        let units = emitted(Duration::ZERO, |turn| if turn == 1 { Control::Flush } else { Control::Continue });
        assert_eq!(units, [counted(3, 200..204), counted(3, 204..1000), counted(4, 0..1000)]);
    }

    #[test]
    fn a_stop_hands_over_what_is_finished_and_returns() {
        let units = emitted(Duration::ZERO, |turn| if turn == 2 { Control::Stop } else { Control::Continue });
        assert_eq!(units, [counted(3, 200..220)]);
        assert_eq!(emitted(Duration::ZERO, |_| Control::Stop), [counted(3, 200..204)]);
    }

    #[test]
    #[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
    fn samples_are_evaluated_for_a_limited_time() {
        // The first samples take longer than one evaluation should, so that the next ones are of fewer.
        let units = emitted(Duration::from_millis(100), |turn| match turn {
            1 | 2 => Control::Flush,
            _ => Control::Stop,
        });
        assert_eq!(units[0].len(), FIRST);
        assert!(units[1..].iter().all(|unit| (1..=3).contains(&unit.len())), "{units:?}");
    }
}
