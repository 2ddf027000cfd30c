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
    fn next(&self, interval: [f64; 2], find: &mut dyn FnMut() -> Option<OnInterval>) -> Option<OnInterval> {
        // Where nothing is found, that is kept too: other searches may follow in the same answers.
        let find = || if (self.is_stopped)() { Err(()) } else { Ok(find()) };
        self.asked.ask_any(|numbers| read(interval, numbers), |found| write(interval, found), find).ok().flatten()
    }
}

/// What stands for an interval on which nothing was found, and for one that is to be halved.
const NOTHING: f64 = -2.0;
const TO_BE_HALVED: f64 = -1.0;

/// An interval as numbers: its ends, on how many others it is unstable surely, and possibly, and the ends of these.
fn write(interval: [f64; 2], found: &Option<OnInterval>) -> Vec<f64> {
    let mut numbers = interval.to_vec();
    match found {
        None => numbers.push(NOTHING),
        Some(None) => numbers.push(TO_BE_HALVED),
        Some(Some(UnstableValues { surely, possibly })) => {
            numbers.extend([surely, possibly].map(|intervals| intervals.len() as f64));
            numbers.extend(surely.iter().chain(possibly).flatten());
        }
    }
    numbers
}

/// This interval from the first of these numbers, if they can be it, and how many they are.
fn read(interval: [f64; 2], numbers: &[f64]) -> Option<(Option<OnInterval>, usize)> {
    let (ends, numbers) = numbers.split_first_chunk::<2>()?;
    let (&first, rest) = numbers.split_first()?;
    if ends.map(f64::to_bits) != interval.map(f64::to_bits) {
        return None;
    }
    match first {
        NOTHING => return Some((None, 3)),
        TO_BE_HALVED => return Some((Some(None), 3)),
        _ => {}
    }
    let (&second, rest) = rest.split_first()?;
    let [surely, possibly] = [count(first, rest)?, count(second, rest)?];
    let intervals: Vec<[f64; 2]> =
        rest.chunks_exact(2).take(surely + possibly).map(|ends| [ends[0], ends[1]]).collect();
    let are_sound = intervals.iter().all(|[from, to]| from.is_finite() && to.is_finite() && from <= to);
    let (surely, possibly) =
        intervals.split_at_checked(surely).filter(|(_, rest)| are_sound && rest.len() == possibly)?;
    let found = UnstableValues { surely: surely.to_vec(), possibly: possibly.to_vec() };
    Some((Some(Some(found)), 4 + 2 * intervals.len()))
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

    /// Two searches in a row, of which the first finds nothing on its third interval.
    #[test]
    fn what_was_found_is_not_found_again_and_searches_stay_in_step() {
        let answers = [
            Some(None),
            Some(on(&[], &[])),
            None,
            Some(on(&[[1.0, 2.0]], &[[0.5, 2.0], [3.0, 4.0]])),
            Some(None),
            Some(on(&[], &[[4.0, 5.0]])),
        ];
        let keeper = InMemory::default();
        let found = Cell::new(0);
        for stop in [2, 3, 5, usize::MAX] {
            let asked = Asked::new(Some(&keeper), (0, 0));
            let is_stopped = || found.get() >= stop;
            let memory = RememberedIntervals { asked: &asked, is_stopped: &is_stopped };
            for (number, answer) in answers.iter().enumerate() {
                let mut find = || {
                    found.set(found.get() + 1);
                    answer.clone()
                };
                let told = memory.next([number as f64, 9.0], &mut find);
                assert_eq!(told, answer.clone().filter(|_| number < stop), "{number} {stop}");
            }
        }
        assert_eq!(found.get(), answers.len(), "an interval was searched twice");
    }

    #[test]
    fn numbers_that_cannot_be_an_interval_say_nothing() {
        let of = |numbers: &[f64]| read([0.0, 1.0], numbers);
        let found = on(&[[0.0, 2.0]], &[[0.0, 3.0]]);
        assert_eq!(of(&[0.0, 1.0, 1.0, 1.0, 0.0, 2.0, 0.0, 3.0, 7.0]), Some((Some(found), 8)));
        let broken: [&[f64]; 10] = [
            &[],
            &[0.0, 1.0],
            &[0.0, 1.0, 0.0],
            &[0.0, 1.0, 0.5, 0.0],
            &[0.0, 1.0, 1.0, 0.0, 2.0],
            &[0.0, 1.0, 1.0, 0.0, 2.0, 1.0],
            &[0.0, 1.0, 1.0, 0.0, f64::NAN, 1.0],
            &[0.0, 1.0, 0.0, 1e300, 1.0, 2.0],
            &[0.0, 1.0, -3.0, 0.0, 1.0, 2.0],
            &[0.0, 2.0, -1.0],
        ];
        broken.iter().for_each(|numbers| assert_eq!(of(numbers), None, "{numbers:?}"));
    }
}
