//! The cells that two runs share, and how their samples depend on each other.

use std::collections::{BTreeSet, HashMap};

use indicatif::HumanCount;

use super::run::Run;
use crate::failure::Failure;
use crate::job::{Answer, Effort, Job};
use crate::output::note;
use crate::tables::cell_columns::names_of_pair;

/// How the samples of a cell in one run depend on those in another run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dependence {
    /// Sample `j` of one run has the same deviates as sample `j` of the other; different samples share none.
    Paired,
    /// They share random numbers in another way.
    Dependent,
    /// They share no random numbers.
    Independent,
}

/// The dependence of two runs in cells that draw from the same streams in both, and the reason if they are not paired.
///
/// Only the deviates matter, as they make two verdicts depend on each other. The inputs, distributions and correlations
/// that the deviates are transformed to may differ.
fn dependence(first: &Job, second: &Job) -> (Dependence, Option<String>) {
    let (a, b) = (&first.sampling, &second.sampling);
    let independent = |why: String| (Dependence::Independent, Some(why));
    // Their samples stand for other inputs, and have probabilities in place of verdicts.
    if [first, second].iter().all(|job| job.answer() == Answer::Probability) && a.seed == b.seed {
        let over = match first.integrated() {
            Some(place) => first.quantity(place).name.to_string(),
            None => names_of_pair(first.model()),
        };
        return (Dependence::Dependent, Some(format!("they integrate over {over}")));
    }
    if [first, second].iter().all(|job| job.answer().is_of_rare_events()) && a.seed == b.seed {
        return (Dependence::Dependent, Some("their samples have weights".to_owned()));
    }
    if a.method.written() != b.method.written() {
        return independent("their sampling.method differs".to_owned());
    }
    if a.seed != b.seed {
        return independent(format!("their seeds differ ({} and {})", a.seed, b.seed));
    }
    if a.common_random_numbers != b.common_random_numbers {
        return independent("only one of them has common_random_numbers".to_owned());
    }
    let dependent = |why: String| (Dependence::Dependent, Some(why));
    if let (Effort::Randomisations { count: a, .. }, Effort::Randomisations { count: b, .. }) = (&a.effort, &b.effort)
        && a != b
    {
        return dependent(format!("they have {a} and {b} randomisations"));
    }
    let inputs = [first, second].map(|job| job.random.inputs.len());
    if inputs[0] != inputs[1] {
        return dependent(format!("they have {} and {} random inputs", inputs[0], inputs[1]));
    }
    if let Some(why) = first.model.unread().or(second.model.unread()) {
        return dependent(why.to_owned());
    }
    (Dependence::Paired, None)
}

/// A cell that two runs share.
#[derive(Debug, Clone, Copy)]
pub struct MatchedCell {
    /// Its index in the first run.
    pub first: u64,
    /// Its index in the second run.
    pub second: u64,
    /// How its samples in the two runs depend on each other.
    pub dependence: Dependence,
}

/// The cells that two runs share.
pub struct Matching {
    /// The cells, in the order of the first run; at least one.
    pub cells: Vec<MatchedCell>,
}

impl Matching {
    /// Matches the cells of two runs by their values. Notes on standard error which cells are left out and which cannot
    /// be paired.
    ///
    /// # Errors
    /// Two runs without a common cell.
    pub fn new(first: &Run, second: &Run) -> Result<Self, Failure> {
        let (a, b) = (&first.job, &second.job);
        let inputs = |job: &Job| {
            let name = |&place: &usize| job.quantity(place).name.to_string();
            job.random.inputs.iter().map(name).collect::<Vec<_>>()
        };
        let same_inputs = inputs(a) == inputs(b);
        // What only one of the runs has an axis of belongs to the cells of both.
        let of_axes = |job: &Job| {
            job.grid.axes.iter().map(|axis| job.quantity(axis.quantity).name.to_string()).collect::<Vec<_>>()
        };
        let names: BTreeSet<String> = [a, b].into_iter().flat_map(of_axes).collect();
        let places = |job: &Job| names.iter().map(|name| job.model().place(name)).collect::<Vec<_>>();
        let (places_in_a, places_in_b) = (places(a), places(b));
        let values = |job: &Job, places: &[Option<usize>], index: u64| -> Vec<u64> {
            let cell = job.grid.cell(index);
            let expected = places.iter().map(|place| place.map_or(f64::NAN, |place| cell.expected[place]));
            let pair = job.normal_pair(&cell).relative_std;
            // If both runs have the same random inputs, the standard deviations of the others belong to the cell, too, relative
            // ones and those in a unit apart.
            let stds = same_inputs.then(|| &job.random.relative_stds[cell.scatter]).into_iter().flatten();
            let kind = |(input, _): (usize, &f64)| if job.random.is_absolute(input) { 1.0 } else { 0.0 };
            let all = expected.chain(pair).chain(stds.clone().copied()).chain(stds.enumerate().map(kind));
            all.map(f64::to_bits).collect()
        };
        let mut in_second: HashMap<Vec<u64>, Vec<u64>> = HashMap::new();
        (0..b.cells()).rev().for_each(|index| in_second.entry(values(b, &places_in_b, index)).or_default().push(index));
        let exact = !a.draws_samples() || !b.draws_samples();
        let (dependence, why) = if exact { (Dependence::Independent, None) } else { dependence(a, b) };
        let common = a.sampling.common_random_numbers;
        let mut cells = Vec::new();
        for index in 0..a.cells() {
            if let Some(other) = in_second.get_mut(&values(a, &places_in_a, index)).and_then(Vec::pop) {
                let same_stream = common || a.stream_of(index) == b.stream_of(other);
                let dependence = if same_stream { dependence } else { Dependence::Independent };
                cells.push(MatchedCell { first: index, second: other, dependence });
            }
        }
        if cells.is_empty() {
            return Err(Failure::Job(format!(
                "{} and {} have no cell in common: no combination of values of their axes and standard deviations is in both. Compare runs whose [axes] and random.relative_std share values",
                first.name, second.name
            )));
        }
        let matching = Self { cells };
        matching.note_left_out(first, second);
        if let Some(why) = why {
            let though = match dependence {
                Dependence::Dependent => ", though they share random numbers (the same seed)",
                Dependence::Independent | Dependence::Paired => "",
            };
            note(format_args!(
                "{} and {} cannot be paired: {why}{though}; this widens their intervals",
                first.name, second.name
            ));
        } else if !exact {
            matching.note_unpaired();
        }
        Ok(matching)
    }

    /// Says which cells only one of the runs has.
    fn note_left_out(&self, first: &Run, second: &Run) {
        let matched = self.cells.len() as u64;
        let [a, b] = [first, second].map(|run| run.job.cells());
        if (a, b) != (matched, matched) {
            note(format_args!(
                "{} cells are in both runs; left out are {} of {} in {} and {} of {} in {}",
                HumanCount(matched),
                HumanCount(a - matched),
                HumanCount(a),
                first.name,
                HumanCount(b - matched),
                HumanCount(b),
                second.name
            ));
        }
    }

    /// Says how many cells draw other samples in the second run, as they have another index there.
    fn note_unpaired(&self) {
        let unpaired = self.cells.iter().filter(|cell| cell.dependence != Dependence::Paired).count();
        if unpaired > 0 {
            note(format_args!(
                "{} of {} cells cannot be paired: they have another index in the second run and so draw other samples there (with sampling.common_random_numbers = true, all cells draw the same); this widens their intervals",
                HumanCount(unpaired as u64),
                HumanCount(self.cells.len() as u64)
            ));
        }
    }
}
