//! What holds in the cell that is asked about: its probability, whether this meets the target, and what it rests on.

use indicatif::HumanCount;
use serde_json::{Value, json};
use stickslip_sampler::estimate::audit::PlainSamples;
use stickslip_sampler::estimate::interval::Estimate;

use crate::job::{Answer, Job};
use crate::output::counted;
use crate::picture::exceptions::{reason, share};
use crate::picture::view::{GridView, probability_beside, rounded};
use crate::tables::row::{CONTRADICTED, OPEN, SurfaceRow};

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
        let rests_on = format!("It rests on {}.", self.rests_on(job));
        [format!("{at}{}", self.found(job))].into_iter().chain(target).chain([rests_on]).collect()
    }

    /// The same for programs.
    pub fn decision(&self, job: &Job, cell: u64) -> Value {
        let Estimate { probability, low, high } = self.estimate;
        // One sample says everything there, and no interval is needed.
        let scatters = !job.random.scatters_nothing();
        // An integral has bounds, but for what the audit of its verdict map leaves open.
        let has_confidence = scatters && (job.answer() != Answer::Integral || self.unaudited.is_some());
        let at: serde_json::Map<String, Value> =
            job.point(cell).into_iter().map(|(axis, value)| (axis, value.into())).collect();
        json!({
            "cell": cell,
            "at": at,
            "p_unstable": probability,
            "p_low": scatters.then_some(low),
            "p_high": scatters.then_some(high),
            "interval": scatters.then(|| job.sampling.method.interval(&job.sampling)),
            "confidence": has_confidence.then_some(job.sampling.confidence),
            "target": job.target,
            "met": job.target.and_then(|target| self.is_met(job, target)),
            "rests_on": self.rests_on(job),
            "distrust": reason(job, self.distrust),
        })
    }

    /// Whether the probability is surely below a target, or surely not; none if that is open.
    fn is_met(&self, job: &Job, target: f64) -> Option<bool> {
        let Estimate { probability, low, high } = self.estimate;
        let known = probability.filter(|_| contradicted(job).is_none())?;
        match job.random.scatters_nothing() {
            true => Some(known < target),
            false if high < target => Some(true),
            false => (low >= target).then_some(false),
        }
    }

    /// Whether the interval is not to be trusted. Where critical values leave something open, it holds.
    fn is_doubtful(&self) -> bool {
        self.distrust > 0 && self.distrust != OPEN
    }

    fn found(&self, job: &Job) -> String {
        let Estimate { probability: known, low, high } = self.estimate;
        let number = |value: f64| probability_beside(value, job.target);
        let interval = job.sampling.method.interval(&job.sampling);
        let doubt = if self.is_doubtful() { ", not to be trusted" } else { "" };
        let interval = format!("({interval}{doubt}: {} to {})", number(low), number(high));
        let is = known.map_or_else(|| "not known".to_owned(), number);
        let why = reason(job, self.distrust).map_or_else(String::new, |why| format!(": {why}"));
        format!("P, the probability of instability, is {is} {interval}{why}.")
    }

    fn against(&self, job: &Job, target: f64) -> String {
        let Estimate { probability: known, low, high } = self.estimate;
        let below = format!("Target P < {} %", rounded(100.0 * target));
        let number = |value: f64| probability_beside(value, Some(target));
        match self.is_met(job, target) {
            Some(true) => {
                let outside = self.share_outside();
                let but = match outside > target {
                    true => format!(" But {} of the samples are outside the model, more than that.", share(outside)),
                    false => String::new(),
                };
                format!("{below}: met, P is at most {}.{but}", number(high))
            }
            Some(false) => format!("{below}: not met, P is at least {}.", number(low)),
            None if contradicted(job).is_some() => {
                format!("{below}: open, as verdicts differ on the full matrices.")
            }
            None if self.is_doubtful() => format!("{below}: open, as this result is not to be trusted."),
            None if known.is_none() => format!("{below}: open, as P is not known."),
            None if job.draws_samples() => {
                format!("{below}: open, P may be below it and above it; take more {}.", job.sampling.method.more())
            }
            None => format!("{below}: open, P may be below it and above it."),
        }
    }

    /// The share of the samples that lie outside the model.
    fn share_outside(&self) -> f64 {
        self.outside as f64 / self.samples.max(1) as f64
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
        let mut text = format!("{what} ({})", job.sampling.method.asked());
        if self.without_verdict > 0 {
            let samples = counted(self.without_verdict.into(), "sample is", "samples are");
            text += &format!("; {samples} undecided or failed");
        }
        if self.outside > 0 {
            text += &format!("; {} outside the model", share(self.share_outside()));
        }
        if let Some(unaudited) = self.unaudited {
            text += &format!("; by the audit at most {} of the verdicts of the map are wrong", share(unaudited));
        }
        if let Some(PlainSamples { decided, unstable }) = self.plain.filter(|plain| plain.decided > 0) {
            let plain = counted(decided.into(), "plain sample", "plain samples");
            let they = match self.distrust {
                CONTRADICTED => "contradict it",
                _ => "do not contradict it",
            };
            text += &format!("; {plain} beside it, {} of them unstable, {they}", HumanCount(unstable));
        }
        text + &contradicted(job).map_or_else(String::new, |why| format!("; {why}"))
    }
}

/// Why all probabilities of a job are doubtful, if they are: its matrices are reduced ones that decide otherwise.
fn contradicted(job: &Job) -> Option<String> {
    job.reduction()?.contradiction()
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
        assert_eq!(said(known(Some(0.02), 0.0, 0.0449)), "Target P < 5 %: met, P is at most 0.0449.");
        assert_eq!(said(known(Some(0.08), 0.05, 0.1)), "Target P < 5 %: not met, P is at least 0.0500.");
        let open = "Target P < 5 %: open, P may be below it and above it; take more samples.";
        assert_eq!(said(known(Some(0.05), 0.04, 0.06)), open);
        assert_eq!(said(known(Some(0.02), 0.0, 0.05)), open, "the upper end is not below it");
        assert_eq!(
            said(KnownCell { outside: 4000, ..known(Some(0.02), 0.0, 0.0449) }),
            "Target P < 5 %: met, P is at most 0.0449. But 20.00 % of the samples are outside the model, more than that."
        );
        let unknown = said(known(None, 0.0, 0.01));
        assert_eq!(unknown, "Target P < 5 %: open, as P is not known.", "what is not known meets no target");
        let exact = known(Some(0.05), 0.04, 0.06).sentences(&job("method = \"exact\""), 1);
        assert_eq!(exact[1], "Target P < 5 %: open, P may be below it and above it.");
        assert_eq!(exact[2], "It rests on an integral (method = \"exact\").");
    }

    #[test]
    fn rounding_moves_no_number_over_the_target() {
        let job = job("samples = 20000\nseed = 1");
        let said = |p: f64, low: f64, high: f64| {
            let [found, target, _] = &known(Some(p), low, high).sentences(&job, 1)[..] else { panic!("no target") };
            let interval = found.rsplit_once(": ").unwrap().1.trim_end_matches(").").to_owned();
            (interval, target.rsplit_once(": ").unwrap().1.to_owned())
        };
        for (low, high, interval, target) in [
            (0.04, 0.04999, "0.0400 to 0.04999", "met, P is at most 0.04999."),
            (0.04, 0.049_999_96, "0.0400 to 0.04999996", "met, P is at most 0.04999996."),
            (0.05, 0.06, "0.0500 to 0.0600", "not met, P is at least 0.0500."),
            (0.050_04, 0.06, "0.0500 to 0.0600", "not met, P is at least 0.0500."),
            (0.049_99, 0.06, "0.04999 to 0.0600", "open, P may be below it and above it; take more samples."),
            (0.04, 0.05, "0.0400 to 0.0500", "open, P may be below it and above it; take more samples."),
        ] {
            assert_eq!(said(0.5 * (low + high), low, high), (interval.to_owned(), target.to_owned()));
        }
        let rare = Job { target: Some(1e-6), ..job.clone() };
        let below = known(Some(5e-7), 1e-7, 9.99e-7).sentences(&rare, 1);
        assert_eq!(below[1], "Target P < 0.0001 %: met, P is at most 9.99e-7.");
        let between = Job { target: Some(0.051_25), ..job };
        let above = known(Some(0.055), 0.051_26, 0.06).sentences(&between, 1);
        assert_eq!(above[1], "Target P < 5.125 %: not met, P is at least 0.0513.");
        let above = known(Some(0.055), 0.051_251, 0.06).sentences(&between, 1);
        assert_eq!(above[1], "Target P < 5.125 %: not met, P is at least 0.0513.");
        let above = Job { target: Some(0.051_24), ..between };
        let above = known(Some(0.055), 0.051_241, 0.06).sentences(&above, 1);
        assert_eq!(above[1], "Target P < 5.124 %: not met, P is at least 0.05124.");
    }

    #[test]
    fn programs_get_the_same_in_fields() {
        let sampled = job("samples = 20000\nseed = 1");
        let of = |known: KnownCell, job: &Job| known.decision(job, 1);
        let met = of(known(Some(0.02), 0.018, 0.0221), &sampled);
        let expected = json!({
            "cell": 1,
            "at": { "rotating_speed": 15.0, "preload": 0.2, "static_friction": 0.4 },
            "p_unstable": 0.02,
            "p_low": 0.018,
            "p_high": 0.0221,
            "interval": "95 % interval",
            "confidence": 0.95,
            "target": 0.05,
            "met": true,
            "rests_on": "20,000 samples, 400 of them unstable (method = \"monte-carlo\")",
            "distrust": null,
        });
        assert_eq!(met, expected);
        assert_eq!(of(known(Some(0.08), 0.05, 0.1), &sampled)["met"], false);
        assert_eq!(of(known(Some(0.05), 0.04, 0.06), &sampled)["met"], Value::Null);
        let without = of(known(Some(0.02), 0.018, 0.0221), &Job { target: None, ..sampled });
        assert_eq!([&without["target"], &without["met"]], [&Value::Null; 2]);
        let exact = of(known(Some(0.02), 0.02, 0.02), &job("method = \"exact\""));
        assert_eq!([&exact["confidence"], &exact["met"]], [&Value::Null, &Value::Bool(true)]);
        assert_eq!(exact["interval"], "bounds of the integral");
        let audited = KnownCell { unaudited: Some(0.002), ..known(Some(0.02), 0.018, 0.022) };
        assert_eq!(of(audited, &job("method = \"exact\""))["confidence"], 0.95);
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
        let why = "plain samples contradict p_low to p_high (n_audit and n_audit_unstable)";
        let first = format!("is not known (95 % interval, not to be trusted: 0.0000 to 0.0010): {why}.");
        assert!(sentences[0].ends_with(&first), "{sentences:?}");
        assert_eq!(sentences[1], "Target P < 5 %: open, as this result is not to be trusted.");
        assert!(sentences[2].ends_with("300 plain samples beside it, 7 of them unstable, contradict it."));
        let decision = contradicted.decision(&job, 1);
        assert_eq!([&decision["met"], &decision["p_unstable"]], [&Value::Null; 2]);
        assert_eq!(decision["distrust"], why);
        // What critical values leave open is between the bounds, surely.
        let open = KnownCell { distrust: OPEN, ..known(None, 0.01, 0.02) };
        let sentences = open.sentences(&job, 1);
        assert!(sentences[0].contains("is not known (95 % interval: 0.0100 to 0.0200): critical values"));
        assert_eq!(sentences[1], "Target P < 5 %: open, as P is not known.");
    }
}
