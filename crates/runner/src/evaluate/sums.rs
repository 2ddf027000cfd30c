//! What a job counts beside its verdicts: integers, so that no sum depends on its order.

use serde::{Deserialize, Serialize};
use stickslip_core::criterion::decision::Decision;
use stickslip_core::degree_of_freedom::DegreeOfFreedom;
use stickslip_core::verdict::{Verdict, VerdictCounts};
use stickslip_sampler::estimate::score::{CellParameter, ScoreSums, ScoreTotals};
use stickslip_sampler::estimate::sobol_indices::{IndexCounts, SobolIndices, indices};
use stickslip_sampler::grid::Cell;

use crate::evaluate::samples::Samples;
use crate::job::{EvaluateMode, Job};

/// Which sums a job has, and where they lie among all of them.
#[derive(Debug, Clone, Copy)]
pub struct SumLayout {
    /// Whether samples are drawn.
    samples: bool,
    lookups: bool,
    sources: bool,
    derivatives: bool,
    /// Random inputs, where their Sobol indices are wanted; 0 where not.
    sensitivity: usize,
}

/// How samples of a job with a verdict map were decided.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Lookups {
    /// Simulated, because the map does not tell.
    #[serde(rename = "lookups_simulated")]
    pub simulated: u64,
    /// Looked up, and simulated as well, as a check.
    #[serde(rename = "lookups_audited")]
    pub audited: u64,
    /// Of these, with another verdict than the one looked up.
    #[serde(rename = "audit_differed")]
    pub differed: u64,
}

impl Lookups {
    /// Adds those of another part.
    pub fn add(&mut self, other: Self) {
        self.simulated += other.simulated;
        self.audited += other.audited;
        self.differed += other.differed;
    }
}

const LOOKUPS: usize = 3;
/// Degrees of freedom that an unstable sample may be fed by, beside the tangential motion.
const SOURCES: [DegreeOfFreedom; 3] = [DegreeOfFreedom::Normal, DegreeOfFreedom::Angular, DegreeOfFreedom::Disc];
const DERIVATIVES: usize = ScoreSums::COUNT;
/// For each input, the counts behind its indices, and the samples that are left out of them.
const PER_INPUT: usize = 7;

impl SumLayout {
    /// Of a job.
    pub fn of(job: &Job) -> Self {
        Self {
            samples: !job.is_integrated(),
            lookups: job.uses_maps() && job.sampling.evaluate == EvaluateMode::Boundary,
            // What a map tells is fed by the tangential motion: maps are refused where anything else grows.
            sources: job.has_flexible_disc() && !job.is_integrated(),
            derivatives: job.sampling.derivatives,
            sensitivity: if job.sampling.sensitivity { job.random.inputs.len() } else { 0 },
        }
    }

    /// Whether samples have to be known one by one.
    pub fn need_samples(&self) -> bool {
        self.lookups || self.derivatives || self.sensitivity > 0
    }

    /// Whether derivatives are wanted.
    pub fn derivatives(&self) -> bool {
        self.derivatives
    }

    /// Inputs whose Sobol indices are wanted.
    pub fn sensitivity(&self) -> usize {
        self.sensitivity
    }

    /// Whether samples are looked up in a map.
    pub fn lookups(&self) -> bool {
        self.lookups
    }

    /// Whether it is counted what feeds unstable samples.
    pub fn sources(&self) -> bool {
        self.sources
    }

    fn lookups_at(self) -> usize {
        usize::from(self.samples)
    }

    fn sources_at(self) -> usize {
        self.lookups_at() + if self.lookups { LOOKUPS } else { 0 }
    }

    fn derivatives_at(self) -> usize {
        self.sources_at() + if self.sources { SOURCES.len() } else { 0 }
    }

    fn sensitivity_at(self) -> usize {
        self.derivatives_at() + if self.derivatives { DERIVATIVES } else { 0 }
    }

    /// How many sums there are.
    pub fn count(self) -> usize {
        self.sensitivity_at() + PER_INPUT * self.sensitivity
    }

    /// SumLayout with nothing in them.
    pub fn nothing(self) -> Vec<i64> {
        vec![0; self.count()]
    }

    /// Adds samples outside physics.
    pub fn add_outside_physics(self, sums: &mut [i64], count: u64) {
        if self.samples {
            sums[0] += count.cast_signed();
        }
    }

    /// How many samples are outside physics; `None` where no samples are drawn.
    pub fn read_outside_physics(self, sums: &[i128]) -> Option<u64> {
        self.samples.then(|| sums.first().map_or(0, |&sum| u64::try_from(sum).unwrap_or(0)))
    }

    /// Adds how samples were decided.
    pub fn add_lookups(self, sums: &mut [i64], lookups: Lookups) {
        if self.lookups {
            for (sum, count) in
                sums[self.lookups_at()..].iter_mut().zip([lookups.simulated, lookups.audited, lookups.differed])
            {
                *sum += count.cast_signed();
            }
        }
    }

    /// Adds what feeds the unstable samples.
    pub fn add_sources(self, sums: &mut [i64], decisions: &[Decision]) {
        if self.sources {
            for (sum, source) in sums[self.sources_at()..].iter_mut().zip(SOURCES) {
                *sum += decisions.iter().filter(|decision| decision.fed_by == Some(source)).count() as i64;
            }
        }
    }

    /// How many unstable samples are fed by one degree of freedom.
    pub fn read_source(self, sums: &[i128], source: DegreeOfFreedom, unstable: u64) -> u64 {
        let counts = sums.get(self.sources_at()..self.derivatives_at()).unwrap_or_default();
        let count = |i: usize| counts.get(i).map_or(0, |&sum| u64::try_from(sum).unwrap_or(0));
        match SOURCES.iter().position(|other| *other == source) {
            Some(place) => count(place),
            None => unstable.saturating_sub((0..SOURCES.len()).map(count).sum::<u64>()),
        }
    }

    /// Adds the scores of the samples.
    pub fn add_scores(self, sums: &mut [i64], cell: &Cell, samples: &Samples, verdicts: &[Verdict]) {
        if !self.derivatives {
            return;
        }
        let mut scores = ScoreSums::default();
        for (sample, &verdict) in verdicts.iter().enumerate() {
            let [preload, static_friction] = samples.deviates(sample);
            scores.add(cell, preload, static_friction, verdict);
        }
        let at = self.derivatives_at();
        for (sum, score) in sums[at..at + DERIVATIVES].iter_mut().zip(scores.sums()) {
            *sum += score;
        }
    }

    /// Adds the verdicts on samples `first` and `second` and, for each input, on the first ones with that input of the
    /// second.
    pub fn add_sensitivity(self, sums: &mut [i64], first: &[Verdict], second: &[Verdict], mixed: &[Vec<Verdict>]) {
        let is_unstable = |verdict: Verdict| match verdict {
            Verdict::Unstable => Some(true),
            Verdict::Stable => Some(false),
            Verdict::Undecided | Verdict::Failed => None,
        };
        for (verdicts, sums) in mixed.iter().zip(sums[self.sensitivity_at()..].chunks_exact_mut(PER_INPUT)) {
            let mut counts = IndexCounts::default();
            let mut left_out = 0;
            for ((&a, &b), &ab) in first.iter().zip(second).zip(verdicts) {
                left_out += u64::from(!counts.add(is_unstable(a), is_unstable(b), is_unstable(ab)));
            }
            let IndexCounts { samples, first_unstable, second_unstable, up, down, turned } = counts;
            let counts = [samples, first_unstable, second_unstable, up, down, turned, left_out];
            sums.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count.cast_signed());
        }
    }

    /// How the samples were decided.
    pub fn read_lookups(self, sums: &[i128]) -> Lookups {
        let at = self.lookups_at();
        let count = |i: usize| sums.get(at + i).map_or(0, |&sum| u64::try_from(sum).unwrap_or(0));
        if self.lookups {
            Lookups { simulated: count(0), audited: count(1), differed: count(2) }
        } else {
            Lookups::default()
        }
    }

    /// The derivative of the probability by a number of the cell, and its standard error.
    pub fn read_derivative(
        self,
        sums: &[i128],
        number: CellParameter,
        cell: &Cell,
        counts: &VerdictCounts,
        probability: Option<f64>,
    ) -> Option<(f64, f64)> {
        let at = self.derivatives_at();
        let sums: &[i128; DERIVATIVES] = sums.get(at..at + DERIVATIVES)?.try_into().ok()?;
        ScoreTotals::from_sums(sums).derivative(number, cell, counts, probability?)
    }

    /// The counts behind the Sobol indices of an input, and the samples that are left out of them because one of their
    /// verdicts is undecided or failed.
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

    /// The Sobol indices of an input; `None` where the verdict does not vary.
    pub fn read_sensitivity(self, sums: &[i128], input: usize) -> Option<SobolIndices> {
        indices(&self.index_counts(sums, input)?.0)
    }

    /// Samples that the Sobol indices of an input leave out.
    pub fn read_left_out(self, sums: &[i128], input: usize) -> u64 {
        self.index_counts(sums, input).map_or(0, |(_, left_out)| left_out)
    }
}
