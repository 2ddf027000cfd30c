//! The sampling keys of a job, checked one by one and against each other.

use stickslip_sampler::estimate::interval::{
    IntervalKind, MOST_WILSON_CONFIDENCE, half_of_the_error, simultaneous_confidence,
};
use stickslip_sampler::estimate::looks::Precision;
use toml::Spanned;

use super::diagnosis::Complaint;
use super::method::{Answer, Method};
use super::sampling_spec::{Audit, EvaluateMode, IntervalSpec, SamplingMethod, SamplingSpec, UntilSpec};

/// Samples in a cell at most with `until`, by default.
const AT_MOST: u64 = 1_000_000;

/// Largest number of audited samples in one cell.
const MOST_AUDITED: u64 = 100_000_000;

/// Beyond, quantiles lose their meaning to rounding.
const HIGHEST_CONFIDENCE: f64 = 1.0 - 1e-12;

impl From<IntervalSpec> for IntervalKind {
    fn from(spec: IntervalSpec) -> Self {
        match spec {
            IntervalSpec::Wilson => Self::Wilson,
            IntervalSpec::ClopperPearson => Self::ClopperPearson,
        }
    }
}

impl UntilSpec {
    /// Largest number of samples in a cell.
    pub fn at_most(&self) -> u64 {
        self.at_most.unwrap_or(AT_MOST)
    }

    /// What is wanted of each cell.
    fn precision(&self) -> Result<Precision, String> {
        let Self { half_width, relative, .. } = *self;
        for (key, value, limit) in [("half_width", half_width, 0.5), ("relative", relative, 1.0)] {
            if let Some(value) = value
                && !(value > 0.0 && value < limit)
            {
                return Err(format!(
                    "sampling.until.{key} = {value} is out of range: it must be greater than 0 and less than {limit}"
                ));
            }
        }
        if half_width.is_none() && relative.is_none() {
            return Err("sampling.until does not say when a cell is known well enough: give half_width (of p_low to p_high) or relative (half of that width over its middle), for example until = { relative = 0.05 }".to_owned());
        }
        Ok(Precision { half_width, relative })
    }
}

impl SamplingSpec {
    /// How probabilities are found.
    pub fn method(&self) -> SamplingMethod {
        self.method.as_ref().map_or(SamplingMethod::MonteCarlo, |method| *method.get_ref())
    }

    /// How the verdict of a sample is found.
    pub fn evaluate_mode(&self) -> EvaluateMode {
        self.evaluate.as_ref().map_or(EvaluateMode::Each, |evaluate| *evaluate.get_ref())
    }

    /// Whether the intervals of all cells hold together.
    pub fn is_simultaneous(&self) -> bool {
        self.simultaneous.as_ref().is_some_and(|simultaneous| *simultaneous.get_ref())
    }

    /// The confidence that one of so many intervals needs, for all of them to hold together if they are to.
    pub fn confidence_of_a_cell(&self, confidence: f64, cells: u64) -> f64 {
        if self.is_simultaneous() { simultaneous_confidence(confidence, cells) } else { confidence }
    }

    /// The confidence of the intervals.
    pub fn checked_confidence(&self, cells: u64) -> Result<f64, Complaint> {
        let (key, value, span) = match &self.until {
            Some(until) => ("until.confidence", until.get_ref().confidence.unwrap_or(0.95), Some(until.span())),
            None => (
                "confidence",
                self.confidence.as_ref().map_or(0.95, |confidence| *confidence.get_ref()),
                self.confidence.as_ref().map(Spanned::span),
            ),
        };
        // The bounds keep the quantile of the interval finite and its definition meaningful.
        if 0.0 < value && value <= HIGHEST_CONFIDENCE {
            let each = self.confidence_of_a_cell(value, cells);
            if each <= HIGHEST_CONFIDENCE {
                return Ok(value);
            }
            let message = format!(
                "sampling.{key} = {value} for {cells} cells together takes more than the highest confidence of one, 1 - 1e-12; lower it, or remove sampling.simultaneous"
            );
            return Err(Complaint::maybe_at(span, message));
        }
        let message = format!(
            "sampling.{key} = {value} is out of range: it must be greater than 0 and less than 1, for example 0.95"
        );
        Err(Complaint::maybe_at(span, message))
    }

    /// What is wanted of each cell, with `until`.
    pub fn precision(&self) -> Result<Option<Precision>, Complaint> {
        let precision = |until: &Spanned<UntilSpec>| {
            until.get_ref().precision().map_err(|message| Complaint::at(until.span(), message))
        };
        self.until.as_ref().map(precision).transpose()
    }

    /// Wilson's interval misses far more often than it says where misses are to be rare.
    pub fn refuse_wilson_beyond_its_reach(&self, confidence: f64, is_audited: bool) -> Result<(), Complaint> {
        let Some(interval) = self.interval.as_ref().filter(|interval| *interval.get_ref() == IntervalSpec::Wilson)
        else {
            return Ok(());
        };
        let why = if self.is_simultaneous() {
            "with sampling.simultaneous".to_owned()
        } else if IntervalKind::for_confidence(confidence) == IntervalKind::ClopperPearson {
            format!("at a confidence of {confidence}, above {MOST_WILSON_CONFIDENCE}")
        } else if is_audited
            && IntervalKind::for_confidence(half_of_the_error(confidence)) == IntervalKind::ClopperPearson
        {
            format!(
                "beside an audit, which takes half of the error: {} is above {MOST_WILSON_CONFIDENCE}",
                half_of_the_error(confidence)
            )
        } else {
            return Ok(());
        };
        let message = format!(
            "sampling.interval = \"wilson\" does not hold {why}: near 0 and 1 it misses far more often than it says. Remove it, or write \"clopper-pearson\""
        );
        Err(Complaint::at(interval.span(), message))
    }

    /// The audit of the verdict map, where there is one.
    pub fn checked_audit(&self, method: &dyn Method) -> Result<Option<Audit>, Complaint> {
        let Some(spec) = &self.audit else { return Ok(None) };
        let complain = |message: String| Err(Complaint::at(spec.span(), message));
        match *spec.get_ref() {
            Audit::Share(share) if !(0.0..=1.0).contains(&share) => complain(format!(
                "sampling.audit = {share} is out of range: it is a share of the looked-up samples, at least 0 and at most 1, or a whole number of samples of each cell"
            )),
            Audit::Share(0.0) => Ok(Some(Audit::Samples(0))),
            Audit::Samples(1) => complain(
                "sampling.audit = 1 is one sample of each cell, which says nothing; write audit = 1.0 for all samples, or a larger number".to_owned(),
            ),
            Audit::Share(share) if method.answer() != Answer::Verdict => complain(format!(
                "sampling.audit = {share} is a share of samples, and here the audit has samples of its own: give their number in each cell, for example audit = 1000"
            )),
            Audit::Samples(samples) if samples > MOST_AUDITED => {
                complain(format!("sampling.audit = {samples} is out of range: it must be at most {MOST_AUDITED}"))
            }
            audit => Ok(Some(audit)),
        }
    }
}
