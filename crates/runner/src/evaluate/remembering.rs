//! Searches that go on where they were interrupted.
//!
//! A search is determined by its random numbers and by the answers that it asks for, which take nearly all of its time. So
//! the answers are kept in the order in which they are asked for. A search that begins anew is given those that are known,
//! and comes to where it was at once; its result has the same bits.

use std::cell::RefCell;
use std::fmt;
use std::time::{Duration, Instant};

use stickslip_core::model::IsStopped;
use stickslip_sampler::estimate::interval::Estimate;
use stickslip_sampler::rare::points::{Integrand, Points};

/// A cell, and the number of a search in it.
pub type Key = (u64, u64);

/// Where the answers of searches are kept.
pub trait Keeper: fmt::Debug + Send + Sync {
    /// The first answers of a search, as far as they are known.
    fn known(&self, key: Key) -> Vec<f64>;

    /// Keeps further answers, of which `first` is the number of the first.
    fn keep(&self, key: Key, first: usize, answers: &[f64]);

    /// The same, together with those of other searches and at the latest when an [`INTERVAL`] has passed.
    fn gather(&self, key: Key, first: usize, answers: &[f64]);
}

/// Time between two writings of answers: a search for rare events that takes less writes none.
pub const INTERVAL: Duration = Duration::from_secs(4);

/// How long answers are computed at once, and of how many points at least: enough for vector lanes.
const AT_ONCE: Duration = Duration::from_secs(1);
const LEAST: usize = 16;

/// The answers of a search.
struct Answers<'a> {
    keeper: &'a dyn Keeper,
    key: Key,
    known: Vec<f64>,
    /// Answers that were given.
    given: usize,
    /// The last of these, which are not kept yet.
    fresh: Vec<f64>,
    kept: Instant,
    has_kept: bool,
}

impl<'a> Answers<'a> {
    fn new(keeper: &'a dyn Keeper, key: Key) -> Self {
        let known = keeper.known(key);
        Self { keeper, key, known, given: 0, fresh: Vec::new(), kept: Instant::now(), has_kept: false }
    }

    /// What the next numbers say, if they are known, and how many of them. From the first on that say nothing, none is known.
    fn recalled<T>(&mut self, read: impl Fn(&[f64]) -> Option<(T, usize)>) -> Option<T> {
        let (found, count) = self.known.get(self.given..).and_then(read).unzip();
        match count {
            Some(count) => self.given += count,
            None => self.known.truncate(self.given),
        }
        found
    }

    /// Adds answers that were not known. They are kept from time to time.
    fn add(&mut self, answers: &[f64]) {
        self.given += answers.len();
        self.fresh.extend_from_slice(answers);
        if self.kept.elapsed() >= INTERVAL {
            self.keep();
        }
    }

    fn keep(&mut self) {
        if !self.fresh.is_empty() {
            self.keeper.keep(self.key, self.given - self.fresh.len(), &self.fresh);
            self.fresh.clear();
            self.has_kept = true;
        }
        self.kept = Instant::now();
    }
}

/// A search whose answers are some numbers each and are found one by one. They are kept, if there is a keeper.
pub struct Asked<'a>(Option<RefCell<Answers<'a>>>);

impl<'a> Asked<'a> {
    /// A search.
    pub fn new(keeper: Option<&'a dyn Keeper>, key: Key) -> Self {
        Self(keeper.map(|keeper| RefCell::new(Answers::new(keeper, key))))
    }

    /// The next answer: the one that is known, or the one that is found. It is kept as that many numbers, which `write` makes
    /// of it; `read` makes an answer of numbers, if they can be one.
    ///
    /// # Errors
    /// What ends the search.
    pub fn ask<T, E>(
        &self,
        numbers: usize,
        read: impl Fn(&[f64]) -> Option<T>,
        write: impl Fn(&T) -> Vec<f64>,
        find: impl FnOnce() -> Result<T, E>,
    ) -> Result<T, E> {
        self.ask_any(|known| Some((read(known.get(..numbers)?)?, numbers)), write, find)
    }

    /// The same of an answer that is kept as any number of numbers: `read` is given all that follow, and says how many are its.
    ///
    /// # Errors
    /// What ends the search.
    pub fn ask_any<T, E>(
        &self,
        read: impl Fn(&[f64]) -> Option<(T, usize)>,
        write: impl Fn(&T) -> Vec<f64>,
        find: impl FnOnce() -> Result<T, E>,
    ) -> Result<T, E> {
        let Some(answers) = &self.0 else { return find() };
        if let Some(known) = answers.borrow_mut().recalled(read) {
            return Ok(known);
        }
        let found = find();
        let mut answers = answers.borrow_mut();
        match &found {
            Ok(found) => answers.add(&write(found)),
            Err(_) => answers.keep(),
        }
        found
    }

    /// The next answer, which is an estimate.
    ///
    /// # Errors
    /// What ends the search.
    pub fn estimate<E>(&self, find: impl FnOnce() -> Result<Estimate, E>) -> Result<Estimate, E> {
        let read = |numbers: &[f64]| {
            let &[probability, low, high] = numbers else { return None };
            let probability = Some(probability).filter(|value| !value.is_nan());
            let is_sound = probability.is_none_or(is_probability) && is_probability(low) && is_probability(high);
            (is_sound && low <= high).then_some(Estimate { probability, low, high })
        };
        let write = |found: &Estimate| vec![found.probability.unwrap_or(f64::NAN), found.low, found.high];
        self.ask(3, read, write, find)
    }
}

/// Whether a number can be a probability.
pub fn is_probability(value: f64) -> bool {
    (0.0..=1.0).contains(&value)
}

impl Drop for Asked<'_> {
    fn drop(&mut self) {
        if let Some(Answers { keeper, key, given, fresh, .. }) = self.0.as_mut().map(RefCell::get_mut)
            && !fresh.is_empty()
        {
            keeper.gather(*key, *given - fresh.len(), fresh);
        }
    }
}

/// An integrand whose answers are kept.
pub struct Remembering<'a> {
    integrand: &'a mut dyn Integrand,
    answers: Answers<'a>,
    is_stopped: IsStopped<'a>,
    /// Seconds for an answer.
    cost: f64,
    was_stopped: bool,
}

impl<'a> Remembering<'a> {
    /// Of a search.
    pub fn new(integrand: &'a mut dyn Integrand, keeper: &'a dyn Keeper, key: Key, is_stopped: IsStopped<'a>) -> Self {
        Self { integrand, answers: Answers::new(keeper, key), is_stopped, cost: 0.0, was_stopped: false }
    }

    /// Ends a search: keeps its last answers if others are kept, and returns its result unless an answer was missing because
    /// it was stopped.
    pub fn finish<T>(mut self, result: Option<T>) -> Option<T> {
        if self.answers.has_kept || self.was_stopped {
            self.answers.keep();
        }
        result.filter(|_| !self.was_stopped)
    }

    /// The next answer, if it is known.
    fn recalled(&mut self) -> Option<f64> {
        self.answers.recalled(|answers| Some((*answers.first()?, 1)))
    }

    /// Answers at points, from the first that is not known on, a few points at once: `answer` is given the integrand and the
    /// places of these. False if it is stopped before, or where there is no answer.
    fn answers(
        &mut self,
        points: &Points,
        answers: &mut Vec<f64>,
        mut answer: impl FnMut(&mut dyn Integrand, &Points, usize) -> Option<Vec<f64>>,
    ) -> bool {
        while answers.len() < points.len() {
            if let Some(known) = self.recalled() {
                answers.push(known);
                continue;
            }
            if (self.is_stopped)() {
                self.was_stopped = true;
                return false;
            }
            let affordable = (AT_ONCE.as_secs_f64() / self.cost.max(1e-9)) as usize;
            let count = if self.cost > 0.0 { affordable.max(LEAST) } else { LEAST };
            let next = part(points, answers.len(), count);
            let begun = Instant::now();
            let Some(found) = answer(self.integrand, &next, answers.len()) else { return false };
            self.cost = begun.elapsed().as_secs_f64() / next.len() as f64;
            self.answers.add(&found);
            answers.extend(found);
        }
        true
    }
}

impl Integrand for Remembering<'_> {
    fn branches(&mut self) -> usize {
        self.integrand.branches()
    }

    fn select(&mut self, branch: Option<usize>) {
        self.integrand.select(branch);
    }

    fn branch_states(&mut self, points: &Points) -> Option<Vec<Vec<f64>>> {
        let count = self.integrand.branches();
        let mut all = Vec::with_capacity(points.len());
        for place in 0..points.len() {
            if let Some(known) = self.answers.recalled(|answers| Some((answers.get(..count)?.to_vec(), count))) {
                all.push(known);
                continue;
            }
            if (self.is_stopped)() {
                self.was_stopped = true;
                return None;
            }
            let mut states = self.integrand.branch_states(&part(points, place, 1))?.pop().unwrap_or_default();
            states.resize(count, f64::NAN);
            self.answers.add(&states);
            all.push(states);
        }
        Some(all)
    }

    fn values(&mut self, points: &Points) -> Option<Vec<Option<f64>>> {
        let mut answers = Vec::with_capacity(points.len());
        let without = |value: Option<f64>| value.unwrap_or(f64::NAN);
        let is_whole = self.answers(points, &mut answers, |integrand, points, _| {
            Some(integrand.values(points)?.into_iter().map(without).collect())
        });
        if !is_whole {
            self.was_stopped = true;
            return None;
        }
        Some(answers.into_iter().map(|value| (!value.is_nan()).then_some(value)).collect())
    }

    fn limit_states(&mut self, points: &Points, values: &[Option<f64>]) -> Option<Vec<f64>> {
        // The first answer is whether there are any.
        let answer = |integrand: &mut dyn Integrand, points: &Points, first: usize| {
            integrand.limit_states(points, &values[first..first + points.len()])
        };
        let mut answers = Vec::with_capacity(points.len());
        let has_states = match self.recalled() {
            Some(known) => known != 0.0,
            None if (self.is_stopped)() => {
                self.was_stopped = true;
                return None;
            }
            None => {
                let states = answer(self.integrand, &part(points, 0, LEAST), 0);
                answers.extend(states.iter().flatten());
                self.answers.add(&[&[f64::from(u8::from(states.is_some()))], &answers[..]].concat());
                states.is_some()
            }
        };
        (has_states && self.answers(points, &mut answers, answer)).then_some(answers)
    }
}

/// So many points, or those that are left, from a place on.
fn part(points: &Points, first: usize, count: usize) -> Points {
    let mut part = Points::new(points.dimensions());
    points.iter().skip(first).take(count).for_each(|point| part.push(point.iter().copied()));
    part
}

#[cfg(test)]
pub(super) mod tests {
    use std::cell::Cell;
    use std::sync::Mutex;

    use stickslip_sampler::draw::identity::{Purpose, block_generator};
    use stickslip_sampler::rare::exploration::{Effort, Search};
    use stickslip_sampler::rare::points::{LimitBranches, LimitState};
    use stickslip_sampler::rare::proposal::Proposal;

    use super::*;

    /// Keeps the answers of one search in memory.
    #[derive(Debug, Default)]
    pub struct InMemory(Mutex<Vec<f64>>);

    impl Keeper for InMemory {
        fn known(&self, _: Key) -> Vec<f64> {
            self.0.lock().unwrap().clone()
        }

        fn keep(&self, _: Key, first: usize, answers: &[f64]) {
            let mut known = self.0.lock().unwrap();
            assert_eq!(known.len(), first);
            known.extend_from_slice(answers);
        }

        fn gather(&self, key: Key, first: usize, answers: &[f64]) {
            self.keep(key, first, answers);
        }
    }

    const EFFORT: Effort = Effort { particles: 40, moves: 4 };

    /// What a search finds, and how many answers it asks for; with what is kept, until it has asked for so many.
    fn found(keeper: Option<&InMemory>, most: usize) -> (Option<String>, usize) {
        let asked = Cell::new(0);
        let mut integrand = LimitState(|point: &[f64]| {
            asked.set(asked.get() + 1);
            3.0 - point[0] - 0.3 * point[1] * point[1]
        });
        let mut generator = block_generator(5, Purpose::Population, 0, 0);
        let is_stopped = || asked.get() >= most;
        let result = match keeper {
            None => Proposal::find(&mut Search::new(2, EFFORT, &mut generator, &mut integrand)),
            Some(keeper) => {
                let mut remembering = Remembering::new(&mut integrand, keeper, (0, 0), &is_stopped);
                let result = Proposal::find(&mut Search::new(2, EFFORT, &mut generator, &mut remembering));
                remembering.finish(result)
            }
        };
        (result.map(|proposal| format!("{proposal:?}")), asked.get())
    }

    #[test]
    fn a_search_that_is_stopped_again_and_again_finds_the_same_with_no_answer_lost() {
        let (expected, all) = found(None, usize::MAX);
        assert!(expected.is_some() && all > 500, "{all}");
        let keeper = InMemory::default();
        let (mut asked, mut sessions) = (0, 0);
        let result = loop {
            let (result, more) = found(Some(&keeper), 100);
            asked += more;
            sessions += 1;
            assert!(result.is_some() || more >= 100, "a session without progress");
            if result.is_some() {
                break result;
            }
        };
        assert_eq!(result, expected);
        assert!(sessions > 4, "{sessions}");
        assert_eq!(asked, all, "an answer was asked for twice");
        // What was found once is found again without an answer, but for the last ones, which no session kept.
        assert_eq!(found(Some(&keeper), usize::MAX).0, expected);
    }

    #[test]
    fn limit_states_of_branches_are_asked_for_once() {
        let keeper = InMemory::default();
        let mut points = Points::new(2);
        (0..20).for_each(|i| points.push([f64::from(i), 0.5]));
        let states = |u: &[f64]| vec![3.0 - u[0], u[1], u[0] * u[1]];
        let expected: Vec<Vec<f64>> = points.iter().map(states).collect();
        let asked = Cell::new(0);
        for most in [7, 11, usize::MAX] {
            let mut integrand = LimitBranches::new(3, |point: &[f64]| {
                asked.set(asked.get() + 1);
                states(point)
            });
            let is_stopped = || asked.get() >= most;
            let mut remembering = Remembering::new(&mut integrand, &keeper, (0, 0), &is_stopped);
            let found = remembering.branch_states(&points);
            assert_eq!(remembering.branches(), 3);
            assert_eq!(remembering.finish(found), (most == usize::MAX).then(|| expected.clone()));
        }
        assert_eq!(asked.get(), 20, "an answer was asked for twice");
    }

    #[test]
    fn answers_of_several_numbers_are_asked_for_once() {
        let keeper = InMemory::default();
        let mut found = 0;
        for stop in [3, 7, u32::MAX] {
            let asked = Asked::new(Some(&keeper), (0, 0));
            let result: Result<Vec<Vec<f64>>, ()> = (0..10_u32)
                .map(|number| {
                    asked.ask(
                        2,
                        |answer| Some(answer.to_vec()),
                        Vec::clone,
                        || {
                            if number == stop {
                                return Err(());
                            }
                            found += 1;
                            Ok(vec![f64::from(number), f64::NAN])
                        },
                    )
                })
                .collect();
            assert_eq!(result.is_err(), stop < 10);
            let numbers = result.unwrap_or_default().into_iter().map(|answer| answer[0]);
            assert!(stop < 10 || numbers.eq((0..10_u32).map(f64::from)));
        }
        assert_eq!(found, 10, "an answer was found twice");
        assert_eq!(keeper.known((0, 0)).len(), 20, "the last answers are kept, too");
    }

    #[test]
    fn what_cannot_be_an_estimate_is_found_again() {
        let sound = [[0.5, 0.4, 0.6], [f64::NAN, 0.0, 1.0]];
        let broken = [[0.5, f64::NAN, 0.6], [0.5, 0.6, 0.4], [2.0, 0.0, 1.0], [0.5, 0.4, 1.5], [0.5, -1.0, 0.6]];
        for (numbers, is_known) in sound.iter().map(|s| (s, true)).chain(broken.iter().map(|b| (b, false))) {
            let keeper = InMemory(Mutex::new(numbers.to_vec()));
            let asked = Asked::new(Some(&keeper), (0, 0));
            assert_eq!(asked.estimate(|| Err(())).is_ok(), is_known, "{numbers:?}");
        }
    }
}
