//! Evaluates samples: from a cell, a part and a range of samples to their inputs, their verdicts and what is recorded.
//!
//! All commands evaluate samples by this code, with any criterion, random inputs and maps. Samples are drawn in chunks.
//! Each chunk is decided in closed form, by looking its samples up in the verdict map, or by simulation. Everything
//! here is a pure function of the job, its maps and the arguments.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

use stickslip_core::model::Columns;
use stickslip_core::model::decision::Decision;
use stickslip_core::model::recorded::RecordedOf;
use stickslip_core::model::verdict::{Verdict, VerdictCounts};
use stickslip_sampler::draw::deviates::{CHUNK_SAMPLES, Points};
use stickslip_sampler::draw::identity::BLOCK_SAMPLES;
use stickslip_sampler::estimate::audit;
use stickslip_sampler::estimate::conditional::ProbabilitySums;
use stickslip_sampler::grid::Cell;
use stickslip_sampler::rare::points::{Integrand, Points as DeviatePoints};

use crate::evaluate::conditional::{self, Conditional};
use crate::evaluate::criteria::Criteria;
use crate::evaluate::maps::Maps;
use crate::evaluate::parts::Parts;
use crate::evaluate::rare_events::RareEvents;
use crate::evaluate::remembering::Keeper;
use crate::evaluate::samples::{Drawing, Samples};
use crate::evaluate::sums::{Lookups, SumLayout};
use crate::evaluate::unit::{FinishedUnit, Recorded};
use crate::evaluate::unstable_values::UnstableValuesOfInput;
use crate::failure::Failure;
use crate::job::{Audit, Effort, Job, OutsidePhysics};
use stickslip_core::model::IsStopped;

/// Samples in a chunk if some are simulated: enough to keep the vector lanes busy, few enough for the memory.
const SIMULATED_CHUNK: usize = 100 * BLOCK_SAMPLES as usize;

/// Evaluates the samples of a job.
pub struct Evaluator<'a> {
    pub(super) job: &'a Job,
    pub(super) parts: Parts,
    pub(super) criteria: Criteria,
    pub(super) maps: Maps,
    /// Of the one input that integrals go over, where the model knows critical values.
    pub(super) unstable_values: UnstableValuesOfInput,
    layout: SumLayout,
    pub(super) chunk: usize,
    /// In jobs that integrate over the pair of the model at every sample.
    conditional: Option<Conditional>,
    /// In jobs whose samples have weights.
    rare_events: Option<RareEvents>,
    /// Where integrals that take long are kept.
    pub(super) keeper: Option<Arc<dyn Keeper>>,
}

/// One sample of a run, with everything that is known about it.
pub struct EvaluatedSample {
    /// The values of all quantities of the model, as drawn.
    pub drawn: Vec<f64>,
    /// Those that the verdict is for. They differ from the drawn ones only if the job clamps samples outside the model.
    pub decided: Vec<f64>,
    /// Whether the drawn values are outside the model.
    pub is_outside: bool,
    /// The decision of the criterion.
    pub decision: Decision,
    /// The verdict from the map, which the run counts instead, if the sample is looked up.
    pub looked_up: Option<Verdict>,
}

impl<'a> Evaluator<'a> {
    /// An evaluator for a job. Its maps have no tiles yet.
    pub fn new(job: &'a Job) -> Result<Self, Failure> {
        let criteria = Criteria::new(job).map_err(|error| Failure::Job(error.to_string()))?;
        let is_closed = job.has_closed_form();
        let conditional = Conditional::new(job);
        let dimensions = conditional.as_ref().map_or(job.random.inputs.len(), Conditional::dimensions);
        Ok(Self {
            job,
            parts: Parts::new(job),
            criteria,
            maps: Maps::new(job),
            unstable_values: UnstableValuesOfInput::default(),
            layout: SumLayout::for_job(job),
            chunk: if is_closed { CHUNK_SAMPLES } else { SIMULATED_CHUNK },
            conditional,
            rare_events: RareEvents::new(job, dimensions),
            keeper: None,
        })
    }

    /// The job.
    pub fn job(&self) -> &'a Job {
        self.job
    }

    /// Keeps the answers of searches for rare events, and integrals without maps, in jobs that have some.
    pub fn keep_searches_by(&mut self, keeper: Arc<dyn Keeper>) {
        if let Some(rare_events) = &mut self.rare_events {
            rare_events.keep_by(keeper.clone());
        }
        self.keeper = Some(keeper);
    }

    /// Draws samples with weights where another evaluator draws them, which has evaluated the same cells.
    pub fn place_samples_as(&self, other: &Evaluator<'_>) {
        if let (Some(own), Some(other)) = (&self.rare_events, &other.rare_events) {
            own.place_as(other);
        }
    }

    /// The parts of its cells.
    pub fn parts(&self) -> &Parts {
        &self.parts
    }

    /// Its verdict maps.
    pub fn maps(&self) -> &Maps {
        &self.maps
    }

    /// Its verdict maps, for adding tiles.
    pub fn maps_mut(&mut self) -> &mut Maps {
        &mut self.maps
    }

    /// How many configurations are set up and kept; 1 if there are too many to keep, and each evaluation sets up its own.
    pub fn set_ups(&self) -> usize {
        self.criteria.kept().max(1)
    }

    /// Prepares the configuration of a part, as far as that is done before its first sample.
    pub fn prepare(&self, part: u64) {
        let (cell, _) = self.parts.place(part);
        self.criteria.configuration(self.job, self.job.grid.configuration_index(cell));
    }

    /// Whether samples are evaluated for their verdicts, and not for integrals or by searches.
    pub fn counts_verdicts(&self) -> bool {
        self.conditional.is_none() && self.rare_events.is_none() && self.job.draws_samples()
    }

    /// Evaluates one unit of work, consecutive samples of a part, and counts what the job records; `None` if it is
    /// stopped before.
    pub fn count(&self, part: u64, samples: Range<u64>, is_stopped: IsStopped<'_>) -> Option<FinishedUnit> {
        let (cell, place) = self.parts.place(part);
        let cell = self.job.grid.cell(cell);
        let configuration = self.job.grid.configuration_index(cell.index);
        let mut unit = self.empty_unit(part, samples.clone());
        if let Some(rare_events) = &self.rare_events {
            let mut integrand: Box<dyn Integrand> = match &self.conditional {
                Some(conditional) => Box::new(conditional::integrand(conditional, self.job, &cell, is_stopped)),
                None => Box::new(DecidedIntegrand::new(self, &cell, is_stopped)),
            };
            let key = (cell.index, place as u64);
            let sums = rare_events.evaluate(self.job, key, samples, &mut *integrand, &mut unit, is_stopped)?;
            self.layout.add_weighted(&mut unit.sums, &sums);
            return Some(unit);
        }
        if let Some(conditional) = &self.conditional {
            let mut sums = ProbabilitySums::default();
            let mut add = |verdict: Option<Verdict>, weight: f64, probability: Option<f64>| {
                verdict.into_iter().for_each(|verdict| unit.counts += verdict.into());
                sums.add(weight, probability);
            };
            let is_done = conditional.evaluate(self.job, &cell, place, samples, is_stopped, &mut add);
            self.layout.add_probabilities(&mut unit.sums, &sums);
            return is_done.then_some(unit);
        }
        let mut lookups = Lookups::default();
        let mut drawing = self.draw(&cell, place, &samples, self.job.points());
        let mut second = self.has_second_samples().then(|| self.draw(&cell, place, &samples, Points::SecondRandom));
        while let Some(chunk) = drawing.next_chunk(self.chunk) {
            if !self.layout.need_samples()
                && self.job.model().recorded().is_empty()
                && let Some((mut counted, outside)) = self.criteria.count(self.job, configuration, chunk)
            {
                self.layout.add_outside_physics(&mut unit.sums, outside);
                // The closed form finds samples outside the model stable.
                if self.job.outside_physics == OutsidePhysics::Failed {
                    counted.stable -= outside;
                    counted.failed += outside;
                }
                unit.counts += counted;
                continue;
            }
            let audited = self.audited(part, chunk.numbers());
            let mut sets = vec![self.decide(&cell, chunk, &audited, &mut lookups, is_stopped)?];
            if let Some(second) = second.as_mut().and_then(|second| second.next_chunk(self.chunk)) {
                let decide = |samples: &Samples| self.decide(&cell, samples, &[], &mut Lookups::default(), is_stopped);
                sets.push(decide(second)?);
                for mixed in self.mixed(chunk, second) {
                    sets.push(decide(&mixed)?);
                }
            }
            self.record(&mut unit, &cell, chunk, &sets);
        }
        self.record_lookups(&mut unit, lookups);
        Some(unit)
    }

    /// A unit of which nothing is counted yet.
    pub(super) fn empty_unit(&self, part: u64, samples: Range<u64>) -> FinishedUnit {
        let (counts, recorded) = (VerdictCounts::default(), Recorded::default());
        FinishedUnit { part, samples, counts, recorded, sums: self.layout.zeros() }
    }

    /// Draws samples of the part at `place` in a cell, numbered within the part.
    pub(super) fn draw(&self, cell: &Cell, place: usize, samples: &Range<u64>, points: Points) -> Drawing<'a> {
        let first = self.parts.first_sample(place);
        Drawing::new(self.job, cell, place, first + samples.start..first + samples.end, points)
    }

    /// Whether the job needs a second set of samples, for Sobol indices.
    pub(super) fn has_second_samples(&self) -> bool {
        self.layout.sensitivity() > 0
    }

    /// The samples with one input at a time taken from a second set.
    pub(super) fn mixed(&self, first: &Samples, second: &Samples) -> Vec<Samples> {
        (0..self.layout.sensitivity()).map(|input| first.with_input_of(input, second)).collect()
    }

    /// Counts in `unit` what is decided of samples. `sets` are the decisions on these, and for Sobol indices those on
    /// the second and on the mixed samples.
    pub(super) fn record(&self, unit: &mut FinishedUnit, cell: &Cell, samples: &Samples, sets: &[Vec<Decision>]) {
        let Some(decisions) = sets.first() else { return };
        let outside = self.outside(cell, samples);
        let count = outside.iter().flatten().filter(|is_outside| **is_outside).count();
        self.layout.add_outside_physics(&mut unit.sums, count as u64);
        for decision in decisions {
            unit.counts += decision.verdict.into();
            let values = decision.recorded.into_iter().zip(self.job.model().recorded()).zip(&mut unit.recorded);
            for ((value, result), distribution) in values {
                if result.of == RecordedOf::All || decision.verdict == Verdict::Unstable {
                    value.into_iter().for_each(|value| distribution.add(value));
                }
            }
        }
        self.layout.add_sources(&mut unit.sums, decisions);
        self.layout.add_scores(&mut unit.sums, &self.job.normal_pair(cell), samples, &verdicts_of(decisions));
        if let [first, second, mixed @ ..] = sets {
            self.layout.add_sensitivity(&mut unit.sums, first, second, mixed);
        }
    }

    /// Counts in `unit` how its samples were decided.
    pub(super) fn record_lookups(&self, unit: &mut FinishedUnit, lookups: Lookups) {
        self.layout.add_lookups(&mut unit.sums, lookups);
    }

    /// The verdicts that a run counts for consecutive samples of a cell, up to where it is stopped. With Sobol points,
    /// these are samples of one randomisation; otherwise `randomisation` is 0.
    pub fn verdicts(
        &self,
        cell: u64,
        randomisation: usize,
        samples: Range<u64>,
        is_stopped: IsStopped<'_>,
    ) -> Vec<Verdict> {
        // With looks, samples are numbered over all parts of the cell; with randomisations, within each.
        let places = match self.parts.are_sequential() {
            true => 0..self.parts.of_a_cell(),
            false => randomisation..randomisation + 1,
        };
        let mut verdicts = Vec::with_capacity((samples.end - samples.start) as usize);
        for part in places {
            let first = self.parts.first_sample(part);
            let drawn = samples.start.max(first)..samples.end.min(first + self.parts.max_samples(part));
            if drawn.is_empty() {
                continue;
            }
            let of_part = drawn.start - first..drawn.end - first;
            let part = self.parts.in_cell(cell).start + part as u64;
            self.each_decided(part, of_part, is_stopped, |_, decisions, _| verdicts.extend(verdicts_of(decisions)));
        }
        verdicts
    }

    /// Passes samples of a part, numbered within it, to `visit` chunk by chunk, with what a run counts of them and which lie
    /// outside the model, up to where it is stopped.
    pub fn each_decided(
        &self,
        part: u64,
        samples: Range<u64>,
        is_stopped: IsStopped<'_>,
        visit: impl FnMut(&Samples, &[Decision], Option<Vec<bool>>),
    ) {
        let (cell, place) = self.parts.place(part);
        let cell = self.job.grid.cell(cell);
        let drawing = self.draw(&cell, place, &samples, self.job.points());
        self.each_of(&cell, drawing, |numbers| self.audited(part, numbers), is_stopped, visit);
    }

    /// The same for the first samples of a cell that are drawn at random, whatever the method of the job.
    pub fn each_random(
        &self,
        cell: u64,
        samples: Range<u64>,
        is_stopped: IsStopped<'_>,
        visit: impl FnMut(&Samples, &[Decision], Option<Vec<bool>>),
    ) {
        let cell = self.job.grid.cell(cell);
        let drawing = Drawing::new(self.job, &cell, 0, samples, Points::Random);
        self.each_of(&cell, drawing, |_| Vec::new(), is_stopped, visit);
    }

    fn each_of(
        &self,
        cell: &Cell,
        mut drawing: Drawing<'_>,
        audited: impl Fn(Range<u64>) -> Vec<bool>,
        is_stopped: IsStopped<'_>,
        mut visit: impl FnMut(&Samples, &[Decision], Option<Vec<bool>>),
    ) {
        while let Some(chunk) = drawing.next_chunk(self.chunk) {
            let decided = self.decide(cell, chunk, &audited(chunk.numbers()), &mut Lookups::default(), is_stopped);
            let Some(decisions) = decided else { return };
            visit(chunk, &decisions, self.outside(cell, chunk));
        }
    }

    /// Evaluates one sample, numbered over all parts of its cell.
    pub fn sample(&self, cell: u64, sample: u64) -> Option<EvaluatedSample> {
        let (part, number) = self.parts.locate(sample);
        let place = self.job.grid.cell(cell);
        let number = self.parts.first_sample(part) + number;
        let mut drawing = Drawing::new(self.job, &place, part, number..number + 1, self.job.points());
        let samples = drawing.next_chunk(1)?;
        // As in an audit, the sample is simulated even if a map has its verdict.
        let decision = self.decide(&place, samples, &[true], &mut Lookups::default(), &|| false)?.pop()?;
        let is_audited = self.audited(self.parts.in_cell(cell).start + part as u64, samples.numbers());
        let outside = self.outside(&place, samples);
        let is_outside = outside.is_some_and(|outside| outside[0]);
        let fails = is_outside && self.job.outside_physics == OutsidePhysics::Failed;
        let map = self.maps.get(self.job.grid.configuration_index(cell));
        let map = map.filter(|_| !is_audited.contains(&true) && !fails);
        let within = self.within(&place, samples);
        let complete = |samples: &Samples| {
            Columns::new(samples.len(), &samples.columns()).complete(0, &place.expected, self.criteria.varying())
        };
        let [first, second] = within.pair(0);
        Some(EvaluatedSample {
            drawn: complete(samples),
            decided: complete(&within),
            is_outside,
            decision,
            looked_up: map.and_then(|map| map.look_up(first, second)),
        })
    }

    /// The audit of an integral: looks samples of a cell up in its verdict map and simulates them as well. `None` if it
    /// is stopped before.
    pub fn audit_integral(&self, cell: u64, samples: Range<u64>, is_stopped: IsStopped<'_>) -> Option<FinishedUnit> {
        let place = self.job.grid.cell(cell);
        let mut counts = VerdictCounts::default();
        let mut lookups = Lookups::default();
        let mut drawing = Drawing::new(self.job, &place, 0, samples.clone(), Points::Random);
        while let Some(chunk) = drawing.next_chunk(self.chunk) {
            let decisions = self.decide(&place, chunk, &vec![true; chunk.len()], &mut lookups, is_stopped)?;
            decisions.iter().for_each(|decision| counts += decision.verdict.into());
        }
        let (recorded, sums) = (Recorded::default(), lookups.sums().to_vec());
        Some(FinishedUnit { part: cell, samples, counts, recorded, sums })
    }

    /// Decides samples, those outside the model as the job specifies; `None` if it is stopped before.
    fn decide(
        &self,
        cell: &Cell,
        samples: &Samples,
        audited: &[bool],
        lookups: &mut Lookups,
        is_stopped: IsStopped<'_>,
    ) -> Option<Vec<Decision>> {
        let mut decisions = self.decide_all(cell, &self.within(cell, samples), audited, lookups, is_stopped)?;
        for (decision, fails) in decisions.iter_mut().zip(self.failing(cell, samples).into_iter().flatten()) {
            if fails {
                *decision = Verdict::Failed.into();
            }
        }
        Some(decisions)
    }

    /// Which samples of a cell lie outside the model; none where it has no such samples.
    fn outside(&self, cell: &Cell, samples: &Samples) -> Option<Vec<bool>> {
        let configuration = self.criteria.configuration(self.job, self.job.grid.configuration_index(cell.index))?;
        configuration.outside(&Columns::new(samples.len(), &samples.columns()))
    }

    /// How many further limit states samples of a cell have.
    fn limit_branches(&self, cell: &Cell) -> usize {
        let configuration = self.criteria.configuration(self.job, self.job.grid.configuration_index(cell.index));
        configuration.map_or(0, |configuration| configuration.limit_branches())
    }

    /// Limit states of samples of a cell, where their model has them.
    fn limit_states(&self, cell: &Cell, samples: &Samples) -> Option<Vec<f64>> {
        let configuration = self.criteria.configuration(self.job, self.job.grid.configuration_index(cell.index))?;
        let within = self.within(cell, samples);
        configuration.limit_states(&Columns::new(within.len(), &within.columns()))
    }

    /// The further limit states of each of them.
    fn branch_limit_states(&self, cell: &Cell, samples: &Samples) -> Option<Vec<Vec<f64>>> {
        let configuration = self.criteria.configuration(self.job, self.job.grid.configuration_index(cell.index))?;
        let within = self.within(cell, samples);
        configuration.branch_limit_states(&Columns::new(within.len(), &within.columns()))
    }

    /// The samples that are decided: those outside the model are clamped if the job says so.
    fn within<'s>(&self, cell: &Cell, samples: &'s Samples) -> Cow<'s, Samples> {
        self.clamped(cell, samples).map_or(Cow::Borrowed(samples), Cow::Owned)
    }

    /// The samples with those outside the model clamped; `None` if nothing is to be clamped.
    pub(super) fn clamped(&self, cell: &Cell, samples: &Samples) -> Option<Samples> {
        if self.job.outside_physics != OutsidePhysics::Clamp || !self.outside(cell, samples)?.contains(&true) {
            return None;
        }
        let configuration = self.criteria.configuration(self.job, self.job.grid.configuration_index(cell.index))?;
        let pair = configuration.clamped(&Columns::new(samples.len(), &samples.columns()))?;
        Some(samples.with_pair(pair))
    }

    /// Which samples fail because they lie outside the model, where that is what happens to them.
    pub(super) fn failing(&self, cell: &Cell, samples: &Samples) -> Option<Vec<bool>> {
        if self.job.outside_physics == OutsidePhysics::Failed { self.outside(cell, samples) } else { None }
    }

    /// Decides samples. Those that a map has a verdict for are looked up; the others, and those that are audited, are
    /// simulated. `None` if it is stopped before.
    fn decide_all(
        &self,
        cell: &Cell,
        samples: &Samples,
        audited: &[bool],
        lookups: &mut Lookups,
        is_stopped: IsStopped<'_>,
    ) -> Option<Vec<Decision>> {
        let Some(map) = self.maps.get(self.job.grid.configuration_index(cell.index)) else {
            lookups.simulated += samples.len() as u64;
            let all: Vec<usize> = (0..samples.len()).collect();
            return self.criteria.decide(self.job, cell, samples, &all, is_stopped);
        };
        let look_up = |sample: usize| {
            let [first, second] = samples.pair(sample);
            map.look_up(first, second)
        };
        let looked_up: Vec<Option<Verdict>> = (0..samples.len()).map(look_up).collect();
        let is_audited = |sample: usize| audited.get(sample).copied().unwrap_or(false);
        let simulated: Vec<usize> = (0..samples.len()).filter(|&i| looked_up[i].is_none() || is_audited(i)).collect();
        let decisions = self.criteria.decide(self.job, cell, samples, &simulated, is_stopped)?;
        let mut all: Vec<Decision> =
            looked_up.iter().map(|verdict| verdict.unwrap_or(Verdict::Failed).into()).collect();
        for (&sample, decision) in simulated.iter().zip(decisions) {
            match looked_up[sample] {
                None => lookups.simulated += 1,
                Some(verdict) => {
                    lookups.audited += 1;
                    lookups.differed += u64::from(verdict != decision.verdict);
                }
            }
            all[sample] = decision;
        }
        Some(all)
    }

    /// Which samples of a part are audited, by their numbers in the cell, with Sobol points in the randomisation.
    pub(super) fn audited(&self, part: u64, numbers: Range<u64>) -> Vec<bool> {
        if !self.layout.lookups() || self.job.sampling.audit.is_nothing() {
            return Vec::new();
        }
        match self.job.sampling.audit {
            Audit::Samples(wanted) => {
                let randomisations = match self.job.sampling.effort {
                    Effort::Randomisations { count, .. } => count,
                    _ => 1,
                };
                let wanted = wanted.div_ceil(randomisations);
                numbers.map(|number| number < wanted).collect()
            }
            Audit::Share(share) => {
                let key = if self.parts.are_sequential() { self.parts.place(part).0 } else { part };
                audit::choose(self.job.sampling.seed, key, numbers, share)
            }
        }
    }
}

/// Verdicts on points in the space of deviates, and limit states of these.
struct DecidedIntegrand<'a> {
    evaluator: &'a Evaluator<'a>,
    cell: &'a Cell,
    is_stopped: IsStopped<'a>,
    drawing: Drawing<'a>,
    /// Which limit state is asked for, of several.
    branch: Option<usize>,
}

impl<'a> DecidedIntegrand<'a> {
    fn new(evaluator: &'a Evaluator<'a>, cell: &'a Cell, is_stopped: IsStopped<'a>) -> Self {
        let drawing = evaluator.draw(cell, 0, &(0..0), Points::Random);
        Self { evaluator, cell, is_stopped, drawing, branch: None }
    }
}

impl Integrand for DecidedIntegrand<'_> {
    fn values(&mut self, points: &DeviatePoints) -> Option<Vec<Option<f64>>> {
        let samples = self.drawing.of_deviates(points.iter());
        let decisions = self.evaluator.decide(self.cell, samples, &[], &mut Lookups::default(), self.is_stopped)?;
        let value = |decision: &Decision| match decision.verdict {
            Verdict::Unstable => Some(1.0),
            Verdict::Stable => Some(0.0),
            Verdict::Undecided | Verdict::Failed => None,
        };
        Some(decisions.iter().map(value).collect())
    }

    fn limit_states(&mut self, points: &DeviatePoints, _: &[Option<f64>]) -> Option<Vec<f64>> {
        let Some(branch) = self.branch else {
            let samples = self.drawing.of_deviates(points.iter());
            return self.evaluator.limit_states(self.cell, samples);
        };
        let all = self.branch_states(points)?;
        Some(all.iter().map(|states| states.get(branch).copied().unwrap_or(f64::NAN)).collect())
    }

    fn branches(&mut self) -> usize {
        self.evaluator.limit_branches(self.cell)
    }

    fn branch_states(&mut self, points: &DeviatePoints) -> Option<Vec<Vec<f64>>> {
        let mut all = Vec::with_capacity(points.len());
        for point in points.iter() {
            if (self.is_stopped)() {
                return None;
            }
            let samples = self.drawing.of_deviates(std::iter::once(point));
            all.extend(self.evaluator.branch_limit_states(self.cell, samples)?);
        }
        Some(all)
    }

    fn select(&mut self, branch: Option<usize>) {
        self.branch = branch;
    }
}

fn verdicts_of(decisions: &[Decision]) -> Vec<Verdict> {
    decisions.iter().map(|decision| decision.verdict).collect()
}
