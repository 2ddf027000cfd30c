//! What the reduction of a model's matrices costs: samples decided by the reduced and by the full ones.

use std::fmt::Write as _;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stickslip_sampler::estimate::interval::{BinomialInterval, IntervalKind};

use crate::output::counted;

/// Confidence of the share of verdicts that sentences name.
const CONFIDENCE: f64 = 0.95;

/// Frequencies that a sentence lists.
const MOST_LISTED: usize = 10;

/// The comparison of reduced matrices with the full ones, as `stickslip reduce` writes it: `[model.reduction]`.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Reduction {
    /// Degrees of freedom of the full matrices.
    pub degrees_of_freedom: u64,
    /// Samples that both have decided.
    pub audited: u64,
    /// How many of these have another verdict on the full matrices.
    pub differed: u64,
    /// The largest difference of the least damping ratios in the bands.
    pub damping_ratio_difference: f64,
    /// Frequencies of modes in the bands that the reduced matrices lack, Hz.
    #[serde(default)]
    pub missing: Vec<f64>,
}

impl Reduction {
    /// The largest share of verdicts that differ which the audit does not exclude with this confidence; 1 without an audit.
    pub fn largest_share(&self, confidence: f64) -> f64 {
        if self.audited == 0 {
            return 1.0;
        }
        BinomialInterval::new(IntervalKind::ClopperPearson, confidence).bounds(self.differed, self.audited).1
    }

    /// What was found, in lines.
    pub fn text(&self) -> String {
        let Self { degrees_of_freedom, audited, differed, damping_ratio_difference, .. } = self;
        if *audited == 0 {
            return format!("no audit on the full matrices of {degrees_of_freedom} degrees of freedom (--audit 0)\n");
        }
        let mut text = format!("audit on the full matrices at {}:\n", counted((*audited).into(), "sample", "samples"));
        let lost = match self.missing.len() {
            0 => "no mode of the bands is missing".to_owned(),
            number => format!("missing {}: {} Hz", counted(number as u128, "mode", "modes"), self.listed()),
        };
        // Writing to a string cannot fail.
        let _ = write!(
            text,
            "  {} (with {} % confidence at most {:.1} % of all)\n  the least damping ratio differs by up to {damping_ratio_difference:.1e}\n  {lost}\n",
            differing(*differed),
            100.0 * CONFIDENCE,
            100.0 * self.largest_share(CONFIDENCE)
        );
        text
    }

    /// The same as a sentence on a result.
    pub fn sentence(&self) -> String {
        let Self { degrees_of_freedom, audited, differed, .. } = self;
        if *audited == 0 {
            return format!(
                "the matrices are reduced from {degrees_of_freedom} degrees of freedom, without an audit on the full ones"
            );
        }
        format!(
            "the matrices are reduced from {degrees_of_freedom} degrees of freedom: {differed} of {audited} verdicts differ on the full ones, so with {} % confidence up to {:.1} % of the samples of the first cell as it was reduced; p_low and p_high do not contain that",
            100.0 * CONFIDENCE,
            100.0 * self.largest_share(CONFIDENCE)
        )
    }

    /// What a user should know before the reduced matrices are used, in sentences.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        if !self.missing.is_empty() {
            warnings.push(format!(
                "the basis misses modes of the bands that the full matrices have: {} Hz; reduce them with more --vectors",
                self.listed()
            ));
        }
        warnings.extend(self.contradiction());
        warnings
    }

    /// What is said where the audit found other verdicts on the full matrices.
    pub fn contradiction(&self) -> Option<String> {
        (self.differed > 0).then(|| {
            format!(
                "{} of {} verdicts differ on the full matrices; reduce them with more --vectors, or submit the job that was reduced with criterion.matrices = \"full\"",
                self.differed, self.audited
            )
        })
    }

    fn listed(&self) -> String {
        self.missing.iter().take(MOST_LISTED).map(|frequency| format!("{frequency:.4e}")).collect::<Vec<_>>().join(", ")
    }
}

fn differing(count: u64) -> String {
    match count {
        1 => "1 verdict differs".to_owned(),
        count => format!("{count} verdicts differ"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reduction(audited: u64, differed: u64, missing: &[f64]) -> Reduction {
        let missing = missing.to_vec();
        Reduction { degrees_of_freedom: 4669, audited, differed, damping_ratio_difference: 1e-3, missing }
    }

    #[test]
    fn shares_are_those_of_clopper_and_pearson() {
        // 1 - 0.025^(1/20) and, with nothing compared, everything.
        assert!((reduction(20, 0, &[]).largest_share(0.95) - 0.168_433).abs() < 1e-6);
        assert!((reduction(0, 0, &[]).largest_share(0.95) - 1.0).abs() < 1e-15);
        assert!(reduction(0, 0, &[]).sentence().contains("without an audit"));
    }

    #[test]
    fn only_what_differs_is_warned_of() {
        assert_eq!(reduction(20, 0, &[]).warnings(), Vec::<String>::new());
        let warnings = reduction(20, 3, &[1234.5]).warnings();
        assert!(warnings[0].contains("1.2345e3 Hz") && warnings[1].starts_with("3 of 20 verdicts"), "{warnings:?}");
    }
}
