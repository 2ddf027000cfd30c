//! Samples of rare events: populations that lead to them, and samples drawn from the densities of these, with weights.

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use stickslip_core::model::IsStopped;
use stickslip_core::model::verdict::Verdict;
use stickslip_sampler::draw::deviates::Points as Source;
use stickslip_sampler::draw::identity::{Generator, Purpose, block_generator};
use stickslip_sampler::estimate::weighted::{Event, WeightedSums};
use stickslip_sampler::rare::exploration::{Effort, Search};
use stickslip_sampler::rare::points::{Integrand, Points};
use stickslip_sampler::rare::proposal::Proposal;

use crate::evaluate::remembering::{Keeper, Key, Remembering};
use crate::evaluate::unit::FinishedUnit;
use crate::job::{self, Answer, Job, Sampling};

/// Populations of a cell whose densities its randomisations share, where there are randomisations enough.
const POPULATIONS: usize = 4;

/// Randomisations of each population, at least.
const RANDOMISATIONS_EACH: usize = 4;

/// Samples that are decided at once.
const AT_ONCE: u64 = 250;

/// Densities that are kept at least; all randomisations of a cell use them.
const MOST_KEPT: usize = 64;

/// A probability above this counts as an unstable sample.
const HALF: f64 = 0.5;

/// How many populations the randomisations of a cell share: randomisation `r` uses population `r` modulo this number.
pub fn populations(job: &Job) -> usize {
    match job.sampling.effort {
        job::Effort::Randomisations { count, .. } => (count as usize / RANDOMISATIONS_EACH).clamp(1, POPULATIONS),
        _ => 1,
    }
}

/// How many searches for populations a job makes for each sample: each sample is one, or samples are drawn where few have led;
/// 1 in jobs without populations.
pub fn searches_per_sample(job: &Job) -> f64 {
    match job.answer() {
        Answer::Weight => job.cells() as f64 * populations(job) as f64 / job.total_samples() as f64,
        _ => 1.0,
    }
}

/// Where the samples of a job are drawn.
#[derive(Debug)]
pub struct RareEvents {
    dimensions: usize,
    effort: Effort,
    /// Densities found last. A population is looked for by one thread, while others that want it wait.
    kept: Mutex<VecDeque<(Key, Place)>>,
    /// Where the answers of searches that take long are kept.
    keeper: Option<Arc<dyn Keeper>>,
}

/// A density, once it is found.
type Place = Arc<Mutex<Option<Found>>>;

/// A density, and the number of evaluations by which it was found.
#[derive(Debug, Clone)]
struct Found {
    proposal: Arc<Proposal>,
    evaluations: u64,
}

impl RareEvents {
    /// Prepares a job with so many deviates for each sample; `None` if its samples have no weights.
    pub fn new(job: &Job, dimensions: usize) -> Option<Self> {
        let Sampling { particles, method, .. } = &job.sampling;
        let effort = Effort { particles: (*particles)? as usize, moves: method.moves() };
        Some(Self { dimensions, effort, kept: Mutex::default(), keeper: None })
    }

    /// Keeps the answers of searches that take long.
    pub fn keep_by(&mut self, keeper: Arc<dyn Keeper>) {
        self.keeper = Some(keeper);
    }

    /// What a search finds, with the answers that are known; `None` if it is stopped before.
    fn searched<T>(
        &self,
        job: &Job,
        key: Key,
        integrand: &mut dyn Integrand,
        is_stopped: IsStopped<'_>,
        find: impl FnOnce(&mut Search<'_>) -> Option<T>,
    ) -> Option<T> {
        let mut generator = generator(job, key);
        let Some(keeper) = &self.keeper else {
            return find(&mut Search::new(self.dimensions, self.effort, &mut generator, integrand));
        };
        let mut remembering = Remembering::new(integrand, &**keeper, key, is_stopped);
        let found = find(&mut Search::new(self.dimensions, self.effort, &mut generator, &mut remembering));
        remembering.finish(found)
    }

    /// Draws the samples of cells where another job with as many deviates draws them, which has evaluated these cells.
    pub fn place_as(&self, other: &Self) {
        locked(&self.kept).clone_from(&locked(&other.kept));
    }

    /// Evaluates samples of a randomisation of a cell, or its populations, and counts them in `unit` and `sums`; `None`
    /// if it is stopped before.
    pub fn evaluate(
        &self,
        job: &Job,
        (cell, randomisation): Key,
        samples: Range<u64>,
        integrand: &mut dyn Integrand,
        unit: &mut FinishedUnit,
        is_stopped: IsStopped<'_>,
    ) -> Option<WeightedSums> {
        let mut sums = WeightedSums::default();
        if job.answer() == Answer::Population {
            for _ in samples {
                let population = |search: &mut Search<'_>| Some((search.population()?, search.evaluations()));
                let found = self.searched(job, (cell, randomisation), integrand, is_stopped, population)?;
                let ((explored, population), evaluations) = found;
                let (without, event) = (explored.without_verdict, explored.event);
                sums.add_population(population.probability, without, explored.of_inputs(), event);
                sums.add_evaluations(evaluations);
                let is_unstable = event == Event::Stability || population.probability > 0.0;
                unit.counts += if is_unstable { Verdict::Unstable } else { Verdict::Stable }.into();
            }
            return Some(sums);
        }
        let number = randomisation % populations(job) as u64;
        let Found { proposal, evaluations } = self.found(job, (cell, number), integrand, is_stopped)?;
        // Each population is counted once, with the first sample of the first randomisation that uses it.
        if samples.start == 0 && randomisation == number {
            sums.add_evaluations(evaluations);
        }
        let stream = job.deviates(self.dimensions + 1, Source::Sobol);
        let mut deviates = stream.start(job.stream_of(cell), randomisation, samples.start);
        let mut columns = vec![Vec::new(); self.dimensions + 1];
        let mut scratch = vec![0.0; self.dimensions];
        let mut first = samples.start;
        while first < samples.end {
            let count = AT_ONCE.min(samples.end - first);
            deviates.fill(count as usize, &mut columns);
            let mut points = Points::new(self.dimensions);
            let mut weights = Vec::with_capacity(count as usize);
            for i in 0..count as usize {
                let mut point: Vec<f64> = columns.iter().map(|column| column[i]).collect();
                weights.push(proposal.draw(&mut point, &mut scratch));
                points.push(point);
            }
            for (drawn, value) in weights.iter().zip(integrand.values(&points)?) {
                let of_event = value.map(|value| proposal.event().value(value));
                sums.add(drawn.weight, of_event, drawn.is_of_inputs, proposal.event());
                unit.counts += match value {
                    Some(value) if value > HALF => Verdict::Unstable,
                    Some(_) => Verdict::Stable,
                    None => Verdict::Undecided,
                }
                .into();
            }
            first += count;
        }
        Some(sums)
    }

    /// The density of a population of a cell; `None` if it is stopped before.
    fn found(&self, job: &Job, key: Key, integrand: &mut dyn Integrand, is_stopped: IsStopped<'_>) -> Option<Found> {
        let place = self.place(key);
        let mut found = locked(&place);
        if found.is_none() {
            *found = Some(self.searched(job, key, integrand, is_stopped, |search| {
                let proposal = Arc::new(Proposal::find(search)?);
                Some(Found { proposal, evaluations: search.evaluations() })
            })?);
        }
        found.clone()
    }

    /// Where the density of a population is kept.
    fn place(&self, key: Key) -> Place {
        let mut kept = locked(&self.kept);
        if let Some((_, place)) = kept.iter().find(|(other, _)| *other == key) {
            return place.clone();
        }
        if kept.len() == MOST_KEPT {
            kept.pop_front();
        }
        let place = Place::default();
        kept.push_back((key, place.clone()));
        place
    }
}

/// The random numbers of a population of a cell.
fn generator(job: &Job, (cell, number): Key) -> Generator {
    let (purpose, cell) = match job.sampling.common_random_numbers {
        true => (Purpose::CommonPopulation, 0),
        false => (Purpose::Population, cell),
    };
    block_generator(job.sampling.seed, purpose, cell, number)
}

/// What a mutex holds: nothing in it is half changed if a thread panics.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
