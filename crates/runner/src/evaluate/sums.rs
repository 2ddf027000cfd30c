//! The sums that a job has beside its verdict counts. They are integers, so that they do not depend on the order of
//! adding.

use serde::{Deserialize, Serialize};
use stickslip_core::model::decision::Decision;
use stickslip_core::model::recorded::{MOST_RECORDED, RecordedResult};
use stickslip_core::model::verdict::{Verdict, VerdictCounts};
use stickslip_sampler::estimate::conditional::{ConditionalPart, ProbabilitySums};
use stickslip_sampler::estimate::score::{ScoreSums, ScoreTotals};
use stickslip_sampler::estimate::sobol_indices::{IndexCounts, SobolIndices, indices};
use stickslip_sampler::estimate::value_indices::{self, ValueSums};
use stickslip_sampler::estimate::weighted::{WeightedPart, WeightedSums};
use stickslip_sampler::inputs::PairParameter;
use stickslip_sampler::integrate::NormalPair;

use crate::evaluate::samples::Samples;
use crate::evaluate::unit::FinishedUnit;
use crate::job::{Answer, Job, MapUse};

/// Which sums a job has, and their places in the list of sums.
#[derive(Debug, Clone, Copy)]
pub struct SumLayout {
    /// Whether samples are drawn.
    samples: bool,
    lookups: bool,
    /// Number of sources of unstable motions that are counted, the first apart; 0 if none are.
    sources: usize,
    derivatives: bool,
    /// Number of random inputs if the job computes Sobol indices, else 0.
    sensitivity: usize,
    /// How many recorded results have Sobol indices as well: those of all samples, which come first.
    results: usize,
    /// Whether samples have probabilities.
    probabilities: bool,
    /// Whether samples have weights, and whether they are populations.
    weights: bool,
    populations: bool,
}

/// Counts of the samples of a job with a verdict map, by how they were decided. The others were looked up.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Lookups {
    /// Simulated, as the map has no verdict for them.
    #[serde(rename = "lookups_simulated")]
    pub simulated: u64,
    /// Looked up, and simulated as well, as a check.
    #[serde(rename = "lookups_audited")]
    pub audited: u64,
    /// Audited samples whose simulated verdict differs from the one looked up.
    #[serde(rename = "audit_differed")]
    pub differed: u64,
}

impl Lookups {
    /// Adds the counts of other samples.
    pub fn add(&mut self, other: Self) {
        self.simulated += other.simulated;
        self.audited += other.audited;
        self.differed += other.differed;
    }

    /// The counts as sums of a unit.
    pub fn sums(self) -> [i64; LOOKUPS] {
        [self.simulated, self.audited, self.differed].map(u64::cast_signed)
    }

    /// Whether sums can be the counts of so many samples.
    pub fn can_be(sums: &[i64], samples: u64) -> bool {
        let all: u64 = sums.iter().take(2).fold(0, |all, &sum| all.saturating_add(sum.cast_unsigned()));
        let is_audited = |sums: &[i64]| sums.len() < LOOKUPS || (0..=sums[1]).contains(&sums[2]);
        all <= samples && is_audited(sums)
    }

    /// The counts from the sums of units; none from none.
    pub fn from_sums(sums: &[i128]) -> Self {
        let count = |i: usize| sums.get(i).map_or(0, |&sum| u64::try_from(sum).unwrap_or(0));
        Self { simulated: count(0), audited: count(1), differed: count(2) }
    }
}

/// The number of counts in [`Lookups`].
pub const LOOKUPS: usize = 3;
const DERIVATIVES: usize = ScoreSums::COUNT;
/// Sums for each input: the counts behind its Sobol indices, and the samples that they leave out.
const PER_INPUT: usize = 7;
/// Sums for each input and recorded result.
const PER_RESULT: usize = ValueSums::COUNT;

impl SumLayout {
    /// The sums of a job.
    pub fn for_job(job: &Job) -> Self {
        let has_verdicts = job.answer() == Answer::Verdict;
        let of_all = job.model().recorded().iter().take_while(|result: &&RecordedResult| result.has_indices());
        Self {
            samples: has_verdicts,
            lookups: job.map_use() == MapUse::LookUp,
            // Samples that a map finds unstable are counted with the first: jobs are refused a map where others grow.
            sources: if has_verdicts { job.model().sources().len().saturating_sub(1) } else { 0 },
            derivatives: job.sampling.derivatives,
            sensitivity: if job.sampling.sensitivity { job.random.inputs.len() } else { 0 },
            results: if job.sampling.sensitivity { of_all.count() } else { 0 },
            probabilities: job.answer() == Answer::Probability,
            weights: job.answer().is_of_rare_events(),
            populations: job.answer() == Answer::Population,
        }
    }

    /// Whether the sums need the verdict on each sample.
    pub fn need_samples(&self) -> bool {
        self.lookups || self.derivatives || self.sensitivity > 0
    }

    /// Whether the job computes derivatives.
    pub fn derivatives(&self) -> bool {
        self.derivatives
    }

    /// The number of inputs with Sobol indices; 0 if the job computes none.
    pub fn sensitivity(&self) -> usize {
        self.sensitivity
    }

    /// The number of recorded results with Sobol indices.
    pub fn results(&self) -> usize {
        self.results
    }

    /// Whether samples are looked up in a map.
    pub fn lookups(&self) -> bool {
        self.lookups
    }

    /// Whether unstable samples are counted by what feeds them.
    pub fn sources(&self) -> bool {
        self.sources > 0
    }

    fn lookups_at(self) -> usize {
        usize::from(self.samples)
    }

    fn sources_at(self) -> usize {
        self.lookups_at() + if self.lookups { LOOKUPS } else { 0 }
    }

    fn derivatives_at(self) -> usize {
        self.sources_at() + self.sources
    }

    fn sensitivity_at(self) -> usize {
        self.derivatives_at() + if self.derivatives { DERIVATIVES } else { 0 }
    }

    fn results_at(self) -> usize {
        self.sensitivity_at() + PER_INPUT * self.sensitivity
    }

    fn probabilities_at(self) -> usize {
        self.results_at() + PER_RESULT * self.results * self.sensitivity
    }

    /// The number of sums.
    pub fn count(self) -> usize {
        self.weights_at() + if self.weights { WeightedSums::COUNT } else { 0 }
    }

    fn weights_at(self) -> usize {
        self.probabilities_at() + if self.probabilities { ProbabilitySums::COUNT } else { 0 }
    }

    /// Whether the sums of a unit can be those of its samples. Pieces that are read may be forged.
    pub fn can_be(self, unit: &FinishedUnit) -> bool {
        let FinishedUnit { counts, sums, .. } = unit;
        let (samples, within) = (unit.len(), 0..=unit.len().cast_signed());
        if sums.len() != self.count() {
            return false;
        }
        let of = |from: usize, to: usize| &sums[from..to];
        let plain = of(0, self.derivatives_at());
        let lookups = of(self.lookups_at(), self.sources_at());
        let inputs = of(self.sensitivity_at(), self.results_at());
        let mut results = of(self.results_at(), self.probabilities_at()).chunks_exact(PER_RESULT);
        plain.iter().all(|sum| within.contains(sum))
            && Lookups::can_be(lookups, samples)
            && (!self.derivatives
                || ScoreSums::can_be(of(self.derivatives_at(), self.sensitivity_at()), counts.unstable, counts.stable))
            && inputs.iter().all(|sum| within.contains(sum))
            && results.all(|sums| ValueSums::can_be(sums, samples))
            && (0..self.sensitivity).all(|input| {
                let sums: Vec<i128> = sums.iter().map(|&sum| sum.into()).collect();
                self.index_counts(&sums, input).is_some_and(|(counts, left_out)| counts.can_be(samples - left_out))
            })
            && (!self.probabilities || ProbabilitySums::can_be(of(self.probabilities_at(), self.weights_at()), samples))
            && (!self.weights || WeightedSums::can_be(&sums[self.weights_at()..], samples, self.populations))
    }

    /// All sums, zero.
    pub fn zeros(self) -> Vec<i64> {
        vec![0; self.count()]
    }

    /// Adds a number of samples outside physics.
    pub fn add_outside_physics(self, sums: &mut [i64], count: u64) {
        if self.samples {
            sums[0] += count.cast_signed();
        }
    }

    /// The number of samples outside physics; `None` if the job draws no samples.
    pub fn read_outside_physics(self, sums: &[i128]) -> Option<u64> {
        self.samples.then(|| sums.first().map_or(0, |&sum| u64::try_from(sum).unwrap_or(0)))
    }

    /// Adds counts of simulated and audited samples.
    pub fn add_lookups(self, sums: &mut [i64], lookups: Lookups) {
        if self.lookups {
            for (sum, count) in
                sums[self.lookups_at()..].iter_mut().zip([lookups.simulated, lookups.audited, lookups.differed])
            {
                *sum += count.cast_signed();
            }
        }
    }

    /// Counts unstable samples by what feeds them.
    pub fn add_sources(self, sums: &mut [i64], decisions: &[Decision]) {
        for (sum, source) in sums[self.sources_at()..].iter_mut().zip(1..=self.sources) {
            *sum += decisions.iter().filter(|decision| decision.fed_by == Some(source)).count() as i64;
        }
    }

    /// The number of unstable samples that a source feeds, by its place in the model's list.
    pub fn read_source(self, sums: &[i128], source: usize, unstable: u64) -> u64 {
        let counts = sums.get(self.sources_at()..self.derivatives_at()).unwrap_or_default();
        let count = |i: usize| counts.get(i).map_or(0, |&sum| u64::try_from(sum).unwrap_or(0));
        match source.checked_sub(1) {
            Some(place) => count(place),
            None => unstable.saturating_sub((0..self.sources).map(count).sum::<u64>()),
        }
    }

    /// Adds the scores of samples, for derivatives.
    pub fn add_scores(self, sums: &mut [i64], pair: &NormalPair, samples: &Samples, verdicts: &[Verdict]) {
        if !self.derivatives {
            return;
        }
        let mut scores = ScoreSums::default();
        for (sample, &verdict) in verdicts.iter().enumerate() {
            scores.add(pair, samples.deviates(sample), verdict);
        }
        let at = self.derivatives_at();
        for (sum, score) in sums[at..at + DERIVATIVES].iter_mut().zip(scores.sums()) {
            *sum += score;
        }
    }

    /// Adds decisions for Sobol indices: on samples `first`, on as many others `second` and, for each input, on the
    /// first ones with that input taken from the second (`mixed`).
    pub fn add_sensitivity(self, sums: &mut [i64], first: &[Decision], second: &[Decision], mixed: &[Vec<Decision>]) {
        let is_unstable = |decision: &Decision| match decision.verdict {
            Verdict::Unstable => Some(true),
            Verdict::Stable => Some(false),
            Verdict::Undecided | Verdict::Failed => None,
        };
        for (input, mixed) in mixed.iter().enumerate() {
            let mut counts = IndexCounts::default();
            let mut left_out = 0;
            let mut values = [ValueSums::default(); MOST_RECORDED];
            for ((a, b), ab) in first.iter().zip(second).zip(mixed) {
                left_out += u64::from(!counts.add(is_unstable(a), is_unstable(b), is_unstable(ab)));
                for (result, values) in values[..self.results].iter_mut().enumerate() {
                    values.add(a.recorded[result], b.recorded[result], ab.recorded[result]);
                }
            }
            let IndexCounts { samples, first_unstable, second_unstable, up, down, turned } = counts;
            let counts = [samples, first_unstable, second_unstable, up, down, turned, left_out];
            let own = sums[self.sensitivity_at() + PER_INPUT * input..].iter_mut();
            own.zip(counts).for_each(|(sum, count)| *sum += count.cast_signed());
            let own = sums[self.results_at() + PER_RESULT * self.results * input..].iter_mut();
            own.zip(values[..self.results].iter().flat_map(ValueSums::sums)).for_each(|(sum, more)| *sum += more);
        }
    }

    /// Adds the probabilities of samples.
    pub fn add_probabilities(self, sums: &mut [i64], probabilities: &ProbabilitySums) {
        if self.probabilities {
            let own = sums[self.probabilities_at()..].iter_mut();
            own.zip(probabilities.sums()).for_each(|(sum, more)| *sum += more);
        }
    }

    /// The probabilities of the samples of a part.
    pub fn read_probabilities(self, sums: &[i128]) -> ConditionalPart {
        ConditionalPart::from_sums(sums.get(self.probabilities_at()..).unwrap_or_default())
    }

    /// Adds samples with weights.
    pub fn add_weighted(self, sums: &mut [i64], weighted: &WeightedSums) {
        if self.weights {
            let own = sums[self.weights_at()..].iter_mut();
            own.zip(weighted.sums()).for_each(|(sum, more)| *sum += more);
        }
    }

    /// The samples with weights of a part.
    pub fn read_weighted(self, sums: &[i128], counts: &VerdictCounts) -> WeightedPart {
        WeightedPart::from_sums(counts.total(), sums.get(self.weights_at()..).unwrap_or_default())
    }

    /// The counts of simulated and audited samples.
    pub fn read_lookups(self, sums: &[i128]) -> Lookups {
        if self.lookups {
            Lookups::from_sums(sums.get(self.lookups_at()..).unwrap_or_default())
        } else {
            Lookups::default()
        }
    }

    /// The derivative of the probability by a parameter of the pair, and its standard error.
    pub fn read_derivative(
        self,
        sums: &[i128],
        parameter: PairParameter,
        pair: &NormalPair,
        counts: &VerdictCounts,
        probability: Option<f64>,
    ) -> Option<(f64, f64)> {
        let at = self.derivatives_at();
        let sums: &[i128; DERIVATIVES] = sums.get(at..at + DERIVATIVES)?.try_into().ok()?;
        ScoreTotals::from_sums(sums).derivative(parameter, pair, counts, probability?)
    }

    /// The counts behind the Sobol indices of an input, and the number of samples that they leave out because one of
    /// the verdicts is undecided or failed.
    fn index_counts(self, sums: &[i128], input: usize) -> Option<(IndexCounts, u64)> {
        let part = sums.get(self.sensitivity_at() + PER_INPUT * input..)?.get(..PER_INPUT)?;
        let count = |i: usize| u64::try_from(part[i]).unwrap_or(0);
        let counts = IndexCounts {
            samples: count(0),
            first_unstable: count(1),
            second_unstable: count(2),
            up: count(3),
            down: count(4),
            turned: count(5),
        };
        Some((counts, count(6)))
    }

    /// The Sobol indices of an input; `None` if all verdicts are the same.
    pub fn read_sensitivity(self, sums: &[i128], input: usize) -> Option<SobolIndices> {
        indices(&self.index_counts(sums, input)?.0)
    }

    /// The number of samples that the Sobol indices of an input leave out.
    pub fn read_left_out(self, sums: &[i128], input: usize) -> u64 {
        self.index_counts(sums, input).map_or(0, |(_, left_out)| left_out)
    }

    /// The Sobol indices of a recorded result by an input, if not all values are the same, and the number of samples that
    /// they leave out because they, or their partners, have no value.
    pub fn read_result_sensitivity(
        self,
        sums: &[i128],
        result: usize,
        input: usize,
    ) -> Option<(Option<SobolIndices>, u64)> {
        let part = sums.get(self.results_at() + PER_RESULT * (self.results * input + result)..)?.get(..PER_RESULT)?;
        let totals: &[i128; PER_RESULT] = part.try_into().ok()?;
        Some((value_indices::indices(totals), value_indices::left_out(totals)))
    }
}
