//! What holds in the cell that is asked about: its probability, whether this meets the target, and what it rests on.

use indicatif::HumanCount;
use stickslip_sampler::estimate::audit::PlainSamples;
use stickslip_sampler::estimate::interval::Estimate;

use crate::job::{Answer, Job};
use crate::output::counted;
use crate::picture::exceptions::{reason, share};
use crate::picture::view::{GridView, probability, rounded};
use crate::tables::row::SurfaceRow;

/// What is known of a cell.
#[derive(Debug, Clone)]
pub struct KnownCell {
    /// Probability and interval.
    pub estimate: Estimate,
    /// Samples of the cell; 0 where none are drawn.
    pub samples: u64,
    /// Those of them that are unstable, have no verdict, and lie outside the model.
    pub unstable: u64,
    pub without_verdict: u64,
    pub outside: u64,
    /// The plain samples beside the probability, where there are some.
    pub plain: Option<PlainSamples>,
    /// The largest share of wrong looked-up verdicts that the audit does not exclude; none without an audit.
    pub unaudited: Option<f64>,
    /// Why the probability is not to be trusted, as the column of that name has it.
    pub distrust: u64,
}

impl From<&SurfaceRow> for KnownCell {
    fn from(row: &SurfaceRow) -> Self {
        Self {
            estimate: row.estimate,
            samples: row.counts.total(),
            unstable: row.counts.unstable,
            without_verdict: row.counts.without_verdict(),
            outside: row.outside_physics,
            plain: row.plain,
            unaudited: row.unaudited,
            distrust: row.distrust,
        }
    }
}

impl KnownCell {
    /// What holds in the cell, in sentences: P with its interval, whether the target is met if there is one, and what both rest
    /// on.
    pub fn sentences(&self, job: &Job, cell: u64) -> Vec<String> {
        let place = GridView::new(job).place_of(job, cell);
        let at = if place.is_empty() { String::new() } else { format!("At {place}: ") };
        if job.random.scatters_nothing() {
            let verdict = match self.estimate.probability {
                Some(0.0) => "stable",
                Some(_) => "unstable",
                None => "without a verdict",
            };
            return vec![format!("{at}{verdict}.")];
        }
        let target = job.target.map(|target| self.against(job, target));
        [format!("{at}{}", self.found(job))].into_iter().chain(target).chain([self.rests_on(job)]).collect()
    }

    fn found(&self, job: &Job) -> String {
        let Estimate { probability: known, low, high } = self.estimate;
        let interval = job.sampling.method.interval(&job.sampling);
        let [low, high] = [low, high].map(probability);
        match known {
            Some(known) => {
                format!("P, the probability of instability, is {} ({interval}: {low} to {high}).", probability(known))
            }
            None => format!("P, the probability of instability, is not known ({interval}: {low} to {high})."),
        }
    }

    fn against(&self, job: &Job, target: f64) -> String {
        let Estimate { probability: known, low, high } = self.estimate;
        let below = format!("Target P < {} %", rounded(100.0 * target));
        if known.is_some() && high < target {
            return format!("{below}: met, P is at most {}.", probability(high));
        }
        if known.is_some() && low >= target {
            return format!("{below}: not met, P is at least {}.", probability(low));
        }
        let more =
            if job.draws_samples() { format!("; take more {}", job.sampling.method.more()) } else { String::new() };
        format!("{below}: open, P may be below it and above it{more}.")
    }

    fn rests_on(&self, job: &Job) -> String {
        let samples = || counted(self.samples.into(), "sample", "samples");
        let what = match job.answer() {
            Answer::Verdict => format!("{}, {} of them unstable", samples(), HumanCount(self.unstable)),
            Answer::Probability => format!("{}, each with its probability", samples()),
            Answer::Weight => format!("{} with weights", samples()),
            Answer::Population => counted(job.sampling.samples.into(), "population", "populations"),
            Answer::Integral => "an integral".to_owned(),
        };
        let mut text = format!("It rests on {what} ({})", job.sampling.method.asked());
        if self.without_verdict > 0 {
            let samples = counted(self.without_verdict.into(), "sample is", "samples are");
            text += &format!("; {samples} undecided or failed");
        }
        if self.outside > 0 {
            text += &format!("; {} outside the model", share(self.outside as f64 / self.samples.max(1) as f64));
        }
        if let Some(unaudited) = self.unaudited {
            text += &format!("; by the audit at most {} of the verdicts of the map are wrong", share(unaudited));
        }
        match (reason(job, self.distrust), self.plain) {
            (Some(why), _) => text += &format!(". It is not to be trusted: {why}"),
            (None, Some(PlainSamples { decided, unstable })) if decided > 0 => {
                let plain = counted(decided.into(), "plain sample", "plain samples");
                text +=
                    &format!("; {plain} beside it, {} of them unstable, do not contradict it", HumanCount(unstable));
            }
            (None, _) => {}
        }
        text + "."
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::JobSource;

    fn job(sampling: &str) -> Job {
        let text = format!(
            "name = \"point\"\n[axes]\nrotating_speed = 15.0\npreload = [0.1, 0.2]\nstatic_friction = 0.4\n[random]\ninputs = [\"preload\"]\nrelative_std = 0.2\n[criterion]\nkind = \"eigenvalue\"\n[sampling]\n{sampling}\n[target]\nprobability = 0.05\nat = {{ preload = 0.2 }}\n"
        );
        JobSource { path: "job.toml".into(), text }.job().unwrap()
    }

    fn known(probability: Option<f64>, low: f64, high: f64) -> KnownCell {
        let estimate = Estimate { probability, low, high };
        KnownCell {
            estimate,
            samples: 20_000,
            unstable: 400,
            without_verdict: 0,
            outside: 0,
            plain: None,
            unaudited: None,
            distrust: 0,
        }
    }

    #[test]
    fn the_cell_is_described_by_its_place_its_probability_and_what_this_rests_on() {
        let job = job("samples = 20000\nseed = 1");
        assert_eq!(job.asked_cell(), Some(1));
        let sentences = known(Some(0.02), 0.018, 0.0221).sentences(&job, 1);
        let expected = [
            "At 15 rad/s, preload = 0.2: P, the probability of instability, is 0.0200 (95 % interval: 0.0180 to 0.0221).",
            "Target P < 5 %: met, P is at most 0.0221.",
            "It rests on 20,000 samples, 400 of them unstable (method = \"monte-carlo\").",
        ];
        assert_eq!(sentences, expected);
        let more =
            KnownCell { without_verdict: 1, outside: 1, unaudited: Some(0.002), ..known(Some(0.02), 0.018, 0.0221) };
        assert_eq!(
            more.sentences(&job, 1)[2],
            "It rests on 20,000 samples, 400 of them unstable (method = \"monte-carlo\"); 1 sample is undecided or failed; less than 0.01 % outside the model; by the audit at most 0.20 % of the verdicts of the map are wrong."
        );
        let without = Job { target: None, ..job };
        assert_eq!(known(Some(0.02), 0.018, 0.0221).sentences(&without, 1), [expected[0], expected[2]]);
    }

    #[test]
    fn a_target_is_met_not_met_or_open() {
        let sampled = job("samples = 20000\nseed = 1");
        let said = |known: KnownCell| known.sentences(&sampled, 1)[1].clone();
        assert_eq!(said(known(Some(0.02), 0.0, 0.04999)), "Target P < 5 %: met, P is at most 0.0500.");
        assert_eq!(said(known(Some(0.08), 0.05, 0.1)), "Target P < 5 %: not met, P is at least 0.0500.");
        let open = "Target P < 5 %: open, P may be below it and above it; take more samples.";
        assert_eq!(said(known(Some(0.05), 0.04, 0.06)), open);
        assert_eq!(said(known(Some(0.02), 0.0, 0.05)), open, "the upper end is not below it");
        assert_eq!(said(known(None, 0.0, 0.01)), open, "what is not known meets no target");
        let exact = known(Some(0.05), 0.04, 0.06).sentences(&job("method = \"exact\""), 1);
        assert_eq!(exact[1], "Target P < 5 %: open, P may be below it and above it.");
        assert_eq!(exact[2], "It rests on an integral (method = \"exact\").");
    }

    #[test]
    fn what_speaks_against_a_probability_is_said() {
        let plain = Some(PlainSamples { decided: 300, unstable: 7 });
        let job = job("method = \"subset\"\nrandomisations = 10\nseed = 1");
        let trusted = KnownCell { plain, ..known(Some(0.02), 0.018, 0.0221) };
        assert_eq!(
            trusted.sentences(&job, 1)[2],
            "It rests on 10 populations (method = \"subset\"); 300 plain samples beside it, 7 of them unstable, do not contradict it."
        );
        let contradicted = KnownCell { plain, distrust: 5, ..known(None, 0.0, 1e-3) };
        let sentences = contradicted.sentences(&job, 1);
        assert!(sentences[0].ends_with("is not known (95 % interval: 0.0000 to 0.0010)."), "{sentences:?}");
        assert!(
            sentences[2].ends_with(
                "It is not to be trusted: plain samples contradict p_low to p_high (n_audit and n_audit_unstable)."
            ),
            "{sentences:?}"
        );
    }
}
