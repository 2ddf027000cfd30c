//! Simulation of the samples of many units in one stream: they flow through the lanes of vector registers across cells
//! and units, so that no lane waits for the last sample of a unit.
//!
//! A sample is complete when all its decisions are there; with Sobol indices, those on the second and on the mixed
//! samples too. The samples of a unit are handed out in their order. Complete samples at the beginning of a unit can be
//! handed over at any time, so that little is lost when the work stops.

use std::cell::Cell as Shared;
use std::ops::Range;

use stickslip_core::model::decision::Decision;
use stickslip_core::model::verdict::Verdict;
use stickslip_core::model::{QueuedSample, SampleQueue, Simulation};
use stickslip_sampler::draw::deviates::Points;
use stickslip_sampler::grid::Cell;

use crate::evaluate::control::Control;
use crate::evaluate::criteria::Motions;
use crate::evaluate::evaluator::Evaluator;
use crate::evaluate::samples::Samples;
use crate::evaluate::sums::Lookups;
use crate::evaluate::unit::FinishedUnit;

/// Simulates the units of work that `next` returns, see [`Evaluator::work`].
pub(super) fn work(
    evaluator: &Evaluator<'_>,
    simulation: &dyn Simulation,
    next: &dyn Fn() -> Option<(u64, Range<u64>)>,
    emit: &mut dyn FnMut(FinishedUnit),
    control: &dyn Fn() -> Control,
) {
    let state = Shared::new(Control::Continue);
    let mut stream = Stream { evaluator, next, emit, control, state, units: Vec::new(), current: None, handed_out: 0 };
    // A queue that runs empty ends the lanes; one that is stopped leaves units incomplete.
    simulation.run(&mut stream);
    stream.flush();
}

/// The units in work.
struct Stream<'q, 'c> {
    evaluator: &'q Evaluator<'q>,
    next: &'c dyn Fn() -> Option<(u64, Range<u64>)>,
    emit: &'c mut dyn FnMut(FinishedUnit),
    control: &'c dyn Fn() -> Control,
    /// What `control` has asked for and is not done yet.
    state: Shared<Control>,
    /// Units in work; the places of finished ones are used again.
    units: Vec<Option<Unit<'q>>>,
    /// The unit whose samples are handed out.
    current: Option<usize>,
    handed_out: u32,
}

/// A unit in work.
struct Unit<'q> {
    part: u64,
    cell: Cell,
    /// Its first sample.
    first: u64,
    /// Its samples; for Sobol indices also the second and the mixed ones.
    sets: Vec<Set>,
    /// What simulates them; `None` if there is no such configuration.
    motions: Option<Motions<'q>>,
    /// Samples handed over already.
    emitted: usize,
    /// The next decision to ask for: a sample and its set.
    cursor: (usize, usize),
    /// Decisions that are missing.
    missing: usize,
}

/// Samples of a unit with their decisions.
struct Set {
    drawn: Samples,
    /// The samples that are decided, if they are not the drawn ones.
    clamped: Option<Samples>,
    /// Verdicts from a map.
    looked_up: Vec<Option<Verdict>>,
    /// Which samples are simulated although they are looked up.
    audited: Vec<bool>,
    /// Which samples fail because they lie outside the model, where any may.
    failing: Option<Vec<bool>>,
    /// Verdicts of simulation for audited samples, and the decisions of all others.
    decisions: Vec<Option<Decision>>,
}

impl Set {
    fn decided(&self) -> &Samples {
        self.clamped.as_ref().unwrap_or(&self.drawn)
    }
}

impl<'q> Unit<'q> {
    fn new(evaluator: &'q Evaluator<'q>, part: u64, samples: &Range<u64>) -> Self {
        let (cell, place) = evaluator.parts.place(part);
        let cell = evaluator.job.grid.cell(cell);
        let most = (samples.end - samples.start) as usize;
        let draw = |points: Points| evaluator.draw(&cell, place, samples, points).next_chunk(most).cloned().into_iter();
        let first: Vec<Samples> = draw(evaluator.job.points()).collect();
        let mut all = first.clone();
        if evaluator.has_second_samples() {
            for (first, second) in first.iter().zip(draw(Points::SecondRandom)) {
                let mixed = evaluator.mixed(first, &second);
                all.push(second);
                all.extend(mixed);
            }
        }
        let map = evaluator.maps.get(evaluator.job.grid.configuration_index(cell.index));
        let set = |(number, drawn): (usize, Samples)| {
            let audited = if number == 0 { evaluator.audited(part, drawn.numbers()) } else { Vec::new() };
            let clamped = evaluator.clamped(&cell, &drawn);
            let failing = evaluator.failing(&cell, &drawn);
            let decided = clamped.as_ref().unwrap_or(&drawn);
            let look_up = |sample: usize| {
                let map = map?;
                let [first, second] = decided.pair(sample);
                map.look_up(first, second)
            };
            let looked_up: Vec<Option<Verdict>> = (0..drawn.len()).map(look_up).collect();
            let is_audited = |sample: usize| audited.get(sample).copied().unwrap_or(false);
            let known = |sample: usize| {
                let known = looked_up[sample].filter(|_| !is_audited(sample)).map(Decision::from);
                let fails = map.is_none() && failing.as_ref().is_some_and(|failing| failing[sample]);
                known.or(fails.then(|| Verdict::Failed.into()))
            };
            let decisions = (0..drawn.len()).map(known).collect();
            Set { clamped, looked_up, decisions, audited, failing, drawn }
        };
        let sets: Vec<Set> = all.into_iter().enumerate().map(set).collect();
        let missing = sets.iter().flat_map(|set| &set.decisions).filter(|decision| decision.is_none()).count();
        let motions = evaluator.criteria.motions(evaluator.job, &cell);
        Self { part, cell, first: samples.start, sets, motions, emitted: 0, cursor: (0, 0), missing }
    }

    fn len(&self) -> usize {
        self.sets.first().map_or(0, |set| set.drawn.len())
    }

    /// The next sample to simulate, with its set; `None` if all are handed out.
    fn next(&mut self) -> Option<(usize, usize)> {
        while self.cursor.0 < self.len() {
            let (sample, set) = self.cursor;
            self.cursor = if set + 1 < self.sets.len() { (sample, set + 1) } else { (sample + 1, 0) };
            if self.sets[set].decisions[sample].is_none() {
                return Some((sample, set));
            }
        }
        None
    }

    /// What is complete and not handed over yet, from the first sample on without a gap.
    fn finished(&mut self, evaluator: &Evaluator<'_>) -> Option<FinishedUnit> {
        let is_complete = |sample: &usize| self.sets.iter().all(|set| set.decisions[*sample].is_some());
        let places = self.emitted..self.emitted + (self.emitted..self.len()).take_while(is_complete).count();
        if places.is_empty() {
            return None;
        }
        self.emitted = places.end;
        let at = |place: usize| self.first + place as u64;
        let mut unit = evaluator.empty_unit(self.part, at(places.start)..at(places.end));
        let mut lookups = Lookups::default();
        let mut decisions: Vec<Vec<Decision>> = Vec::with_capacity(self.sets.len());
        for (number, set) in self.sets.iter().enumerate() {
            let decision = |sample: usize| {
                let decision = set.decisions[sample].unwrap_or(Verdict::Failed.into());
                if number == 0 {
                    match set.looked_up[sample] {
                        None => lookups.simulated += 1,
                        Some(verdict) if set.audited.get(sample) == Some(&true) => {
                            lookups.audited += 1;
                            lookups.differed += u64::from(verdict != decision.verdict);
                        }
                        Some(_) => {}
                    }
                }
                if set.failing.as_ref().is_some_and(|failing| failing[sample]) {
                    Verdict::Failed.into()
                } else {
                    decision
                }
            };
            decisions.push(places.clone().map(decision).collect());
        }
        let whole = places.len() == self.len();
        let samples = &self.sets.first()?.drawn;
        if whole {
            evaluator.record(&mut unit, &self.cell, samples, &decisions);
        } else {
            evaluator.record(&mut unit, &self.cell, &samples.part(places), &decisions);
        }
        evaluator.record_lookups(&mut unit, lookups);
        Some(unit)
    }
}

/// Place of the unit, the set and the sample in a ticket.
const UNIT_SHIFT: u32 = 40;
const SET_SHIFT: u32 = 32;

/// Samples handed out between two questions what to do next: they may be decided at their start.
const SAMPLES_BETWEEN_QUESTIONS: u32 = 64;

impl Stream<'_, '_> {
    /// Asks what to do next.
    fn ask(&self) {
        self.state.set(self.state.get().max((self.control)()));
    }

    /// Hands over what is finished, if that was asked for.
    fn flush_if_asked(&mut self) {
        if self.state.get() == Control::Flush {
            self.state.set(Control::Continue);
            self.flush();
        }
    }

    /// Hands over what is finished.
    fn flush(&mut self) {
        for unit in self.units.iter_mut().flatten() {
            unit.finished(self.evaluator).into_iter().for_each(&mut *self.emit);
        }
    }

    /// Takes up another unit; `None` if there are no more.
    fn begin(&mut self) -> Option<()> {
        let (part, samples) = (self.next)()?;
        let place = self.units.iter().position(Option::is_none).unwrap_or_else(|| {
            self.units.push(None);
            self.units.len() - 1
        });
        self.units[place] = Some(Unit::new(self.evaluator, part, &samples));
        self.current = Some(place);
        self.close_if_complete(place);
        Some(())
    }

    /// Keeps a decision.
    fn keep(&mut self, place: usize, (sample, set): (usize, usize), decision: Decision) {
        if let Some(unit) = self.units.get_mut(place).and_then(Option::as_mut) {
            unit.sets[set].decisions[sample] = Some(decision);
            unit.missing -= 1;
            self.close_if_complete(place);
        }
    }

    /// Hands over a unit that is complete.
    fn close_if_complete(&mut self, place: usize) {
        if self.units[place].as_ref().is_some_and(|unit| unit.missing == 0)
            && let Some(mut unit) = self.units[place].take()
        {
            unit.finished(self.evaluator).into_iter().for_each(&mut *self.emit);
            self.current = self.current.filter(|current| *current != place);
        }
    }
}

impl<'q> SampleQueue<'q> for Stream<'q, '_> {
    fn next(&mut self, values: &mut Vec<f64>) -> Option<QueuedSample<'q>> {
        loop {
            self.handed_out += 1;
            if self.handed_out.is_multiple_of(SAMPLES_BETWEEN_QUESTIONS) {
                self.ask();
            }
            self.flush_if_asked();
            if self.state.get() == Control::Stop {
                return None;
            }
            let Some(place) = self.current else {
                self.begin()?;
                continue;
            };
            let Some(unit) = &mut self.units[place] else {
                self.current = None;
                continue;
            };
            let Some((sample, set)) = unit.next() else {
                self.current = None;
                continue;
            };
            let ticket = (place as u64) << UNIT_SHIFT | (set as u64) << SET_SHIFT | sample as u64;
            match &unit.motions {
                Some(motions) => {
                    values.clear();
                    values.extend(unit.sets[set].decided().of_sample(sample));
                    return Some(motions.queued(ticket));
                }
                None => self.keep(place, (sample, set), Verdict::Failed.into()),
            }
        }
    }

    fn decided(&mut self, ticket: u64, decision: Decision) {
        let place = (ticket >> UNIT_SHIFT) as usize;
        let set = (ticket >> SET_SHIFT & ((1 << (UNIT_SHIFT - SET_SHIFT)) - 1)) as usize;
        let sample = (ticket & ((1 << SET_SHIFT) - 1)) as usize;
        self.keep(place, (sample, set), decision);
        self.flush_if_asked();
    }

    fn is_stopped(&self) -> bool {
        self.ask();
        self.state.get() == Control::Stop
    }
}

#[cfg(test)]
mod tests;
