//! Searches for critical values that go on where they were interrupted.

use stickslip_core::model::IsStopped;
use stickslip_core::model::critical_values::{Memory, OnInterval, UnstableValues};

use crate::evaluate::remembering::Asked;

/// The intervals of a search, whose answers are kept as those of other searches are.
pub struct RememberedIntervals<'a, 'k> {
    /// The answers.
    pub asked: &'a Asked<'k>,
    /// Whether to stop before the next interval.
    pub is_stopped: IsStopped<'a>,
}

impl Memory for RememberedIntervals<'_, '_> {
    fn next(&self, _: [f64; 2], find: &mut dyn FnMut() -> Option<OnInterval>) -> Option<OnInterval> {
        let find = || if (self.is_stopped)() { Err(()) } else { find().ok_or(()) };
        self.asked.ask_any(read, write, find).ok()
    }
}

/// An interval as numbers: how many it is unstable on surely, and possibly, and the ends of these; -1 if it is to be halved.
fn write(found: &OnInterval) -> Vec<f64> {
    let Some(UnstableValues { surely, possibly }) = found else { return vec![TO_BE_HALVED] };
    let counts = [surely, possibly].map(|intervals| intervals.len() as f64);
    counts.into_iter().chain(surely.iter().chain(possibly).flatten().copied()).collect()
}

const TO_BE_HALVED: f64 = -1.0;

/// An interval from the first of these numbers, if they can be one, and how many they are.
fn read(numbers: &[f64]) -> Option<(OnInterval, usize)> {
    let (&first, rest) = numbers.split_first()?;
    if first == TO_BE_HALVED {
        return Some((None, 1));
    }
    let (&second, ends) = rest.split_first()?;
    let [surely, possibly] = [count(first, ends)?, count(second, ends)?];
    let intervals: Vec<[f64; 2]> =
        ends.chunks_exact(2).take(surely + possibly).map(|ends| [ends[0], ends[1]]).collect();
    let are_sound = intervals.iter().all(|[from, to]| from.is_finite() && to.is_finite() && from <= to);
    let (surely, possibly) =
        intervals.split_at_checked(surely).filter(|(_, rest)| are_sound && rest.len() == possibly)?;
    let found = UnstableValues { surely: surely.to_vec(), possibly: possibly.to_vec() };
    Some((Some(found), 2 + 2 * intervals.len()))
}

/// A number of intervals, no more than these numbers can hold.
fn count(number: f64, ends: &[f64]) -> Option<usize> {
    (number >= 0.0 && number.fract() == 0.0 && number <= ends.len() as f64).then_some(number as usize)
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;
    use crate::evaluate::remembering::tests::InMemory;

    fn on(surely: &[[f64; 2]], possibly: &[[f64; 2]]) -> OnInterval {
        Some(UnstableValues { surely: surely.to_vec(), possibly: possibly.to_vec() })
    }

    #[test]
    fn what_was_found_is_not_found_again() {
        let answers = [None, on(&[], &[]), on(&[[1.0, 2.0]], &[[0.5, 2.0], [3.0, 4.0]]), None, on(&[], &[[4.0, 5.0]])];
        let keeper = InMemory::default();
        let found = Cell::new(0);
        for stop in [2, 4, usize::MAX] {
            let asked = Asked::new(Some(&keeper), (0, 0));
            let is_stopped = || found.get() >= stop;
            let memory = RememberedIntervals { asked: &asked, is_stopped: &is_stopped };
            let all: Vec<Option<OnInterval>> = (0..answers.len())
                .map(|number| {
                    memory.next([0.0, 1.0], &mut || {
                        found.set(found.get() + 1);
                        Some(answers[number].clone())
                    })
                })
                .take_while(Option::is_some)
                .collect();
            let expected = answers.iter().take(stop).cloned().map(Some);
            assert!(all.iter().cloned().eq(expected), "{all:?}");
        }
        assert_eq!(found.get(), answers.len(), "an interval was searched twice");
    }

    #[test]
    fn numbers_that_cannot_be_an_interval_say_nothing() {
        assert_eq!(read(&[1.0, 1.0, 0.0, 2.0, 0.0, 3.0, 7.0]), Some((on(&[[0.0, 2.0]], &[[0.0, 3.0]]), 6)));
        let broken: [&[f64]; 8] = [
            &[],
            &[0.0],
            &[0.5, 0.0],
            &[1.0, 0.0, 2.0],
            &[1.0, 0.0, 2.0, 1.0],
            &[1.0, 0.0, f64::NAN, 1.0],
            &[0.0, 1e300, 1.0, 2.0],
            &[-2.0, 0.0, 1.0, 2.0],
        ];
        broken.iter().for_each(|numbers| assert_eq!(read(numbers), None, "{numbers:?}"));
    }
}
