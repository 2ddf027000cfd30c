//! How the probabilities of a job are found: its sampling keys, checked.

use stickslip_core::model::Model;
use stickslip_sampler::estimate::audit;
use stickslip_sampler::estimate::interval::half_of_the_error;
use stickslip_sampler::estimate::looks::{Looks, Precision};
use toml::Spanned;

use super::diagnosis::{Complaint, Complaints};
use super::method::{MapUse, Method, Sampling};
use super::methods::{Chosen, method};
use super::model::{Boundary, JobModel};
use super::needs::{Asked, Need};
use super::random::RandomInputSet;
use super::sampling_key::is_true;
use super::sampling_numbers::Effort;
use super::sampling_spec::{AUDIT, Audit, EvaluateMode, SamplingSpec};

/// Particles of a population.
const PARTICLES: [u64; 2] = [50, 100_000];

impl Sampling {
    /// Checks every key, and that they fit each other, the inputs and the criterion. `None` if anything is refused, or
    /// without inputs and criterion.
    pub fn validate(
        spec: &SamplingSpec,
        others: Option<(&RandomInputSet, &dyn JobModel)>,
        boundary: Option<Boundary>,
        cells: Option<u64>,
        complaints: &mut Complaints,
    ) -> Option<Self> {
        let before = complaints.len();
        let boundary = boundary.unwrap_or(Boundary::Verdicts);
        let method = method(spec, boundary);
        let cells = cells.unwrap_or(1);
        // Which keys have a meaning depends on these two.
        if !["method", "evaluate"].iter().any(|key| complaints.has_unread(&["sampling", key])) {
            let chosen = Chosen { method, boundary, others };
            spec.foreign_keys(chosen).into_iter().for_each(|complaint| complaints.push(complaint));
        }
        let confidence = complaints.take(spec.checked_confidence(cells));
        let samples = complaints.take(method.samples(spec));
        let audit = complaints.take(spec.checked_audit(method));
        let until = complaints.take(spec.precision());
        if complaints.len() > before || complaints.has_unread(&["sampling"]) {
            return None;
        }
        let has_maps = boundary == Boundary::Verdicts && method.map_use_with(spec.evaluate_mode()) != MapUse::Nothing;
        let samples = samples?;
        // What is usual does not depend on what the spec says of it.
        let are_slow = others.is_some_and(|(_, model)| model.model().has_very_slow_samples());
        let usual_audit = spec.usual_audit(method, samples, are_slow);
        let checked = Checked { confidence: confidence?, samples, audit: audit?, usual_audit, until: until? };
        let sampling = spec.resolved(method, has_maps, checked, cells);
        let sampling = complaints.take(sampling)?;
        let (inputs, model) = others?;
        complaints.take(spec.check_needs(method, inputs, model.model())).map(|()| sampling)
    }
}

/// Keys that were checked by themselves.
#[derive(Clone, Copy)]
struct Checked {
    confidence: f64,
    samples: u64,
    audit: Option<Audit>,
    usual_audit: Audit,
    until: Option<Precision>,
}

impl SamplingSpec {
    /// What is asked of the model and the random inputs: by the method, and by keys.
    fn check_needs(
        &self,
        method: &'static dyn Method,
        inputs: &RandomInputSet,
        model: &dyn Model,
    ) -> Result<(), Complaint> {
        let [at_method, at_evaluate, at_derivatives, at_sensitivity] = [
            self.method.as_ref().map(Spanned::span),
            self.evaluate.as_ref().map(Spanned::span),
            self.derivatives.as_ref().map(Spanned::span),
            self.sensitivity.as_ref().map(Spanned::span),
        ];
        let what = method.asked();
        let mut asked = vec![Asked { what: &what, span: at_method, needs: method.needs(), instead: method.instead() }];
        if self.evaluate_mode() == EvaluateMode::Boundary {
            asked.push(Asked {
                what: "evaluate = \"boundary\"",
                span: at_evaluate,
                needs: &[Need::Pair, Need::PairAlone, Need::NothingRecorded],
                instead: "use evaluate = \"each\"",
            });
        }
        if is_true(&self.derivatives) {
            let needs = &[Need::Pair, Need::IndependentNormal];
            let instead = "remove it (sampling.sensitivity has measures for any inputs)";
            asked.push(Asked { what: "derivatives", span: at_derivatives, needs, instead });
        }
        if is_true(&self.sensitivity) {
            let needs = &[Need::Independent(2)];
            asked.push(Asked { what: "sensitivity", span: at_sensitivity, needs, instead: "remove it" });
        }
        asked.iter().try_for_each(|asked| asked.check(model, inputs))
    }

    /// The sampling that the keys ask for, each of which is checked.
    fn resolved(
        &self,
        method: &'static dyn Method,
        has_maps: bool,
        checked: Checked,
        cells: u64,
    ) -> Result<Sampling, Complaint> {
        let Checked { confidence, samples, audit, usual_audit, until } = checked;
        let is_audited = has_maps && !audit.unwrap_or(usual_audit).is_nothing();
        self.refuse_wilson_beyond_its_reach(confidence, is_audited)?;
        let of_a_cell = self.confidence_of_a_cell(confidence, cells);
        let for_counts = if is_audited { half_of_the_error(of_a_cell) } else { of_a_cell };
        let (audit, precision) = match until {
            Some(precision) if is_audited => {
                let (audit, precision) = self.share_precision(precision, audit, for_counts)?;
                (audit, Some(precision))
            }
            precision => (audit.unwrap_or(usual_audit), precision),
        };
        Ok(Sampling {
            method,
            samples,
            until,
            effort: match precision {
                Some(precision) => Effort::Until(Looks::new(precision, samples, for_counts)),
                None => method.effort(self, samples)?,
            },
            seed: self.seed.as_ref().map_or(0, |seed| *seed.get_ref()),
            evaluate: self.evaluate_mode(),
            audit,
            usual_audit,
            particles: method.particles().map(|default| self.checked_particles(default)).transpose()?,
            common_random_numbers: is_true(&self.common_random_numbers),
            confidence,
            interval: self.interval.as_ref().map(|interval| *interval.get_ref()),
            simultaneous: self.is_simultaneous(),
            is_audited,
            derivatives: is_true(&self.derivatives),
            sensitivity: is_true(&self.sensitivity),
        })
    }

    /// Samples that check the probability of a cell by default.
    fn usual_audit(&self, method: &'static dyn Method, samples: u64, are_slow: bool) -> Audit {
        if !method.has_plain_samples() {
            return AUDIT;
        }
        let particles = self.particles.as_ref().map(|particles| *particles.get_ref()).or(method.particles());
        Audit::Samples(method.usual_plain_samples(samples, particles, are_slow))
    }

    /// Particles of a population.
    fn checked_particles(&self, default: u64) -> Result<u64, Complaint> {
        let particles = self.particles.as_ref().map_or(default, |particles| *particles.get_ref());
        let [least, most] = PARTICLES;
        if (least..=most).contains(&particles) {
            return Ok(particles);
        }
        let message = format!(
            "sampling.particles = {particles} is out of range: it must be at least {least} and at most {most}; {default} is usual"
        );
        Err(Complaint::maybe_at(self.particles.as_ref().map(Spanned::span), message))
    }

    /// Shares the half width that is wanted among the audit of a verdict map, of which no sample differs, and the
    /// counts: the audit that it takes, and what is left for the counts.
    fn share_precision(
        &self,
        precision: Precision,
        audit: Option<Audit>,
        confidence: f64,
    ) -> Result<(Audit, Precision), Complaint> {
        let complain = |message: String| Err(Complaint::maybe_at(self.until.as_ref().map(Spanned::span), message));
        let (Some(half_width), None) = (precision.half_width, precision.relative) else {
            return complain(
                "sampling.until.relative cannot be kept with a verdict map, whose audit leaves the same share open whatever the probability: use half_width, evaluate = \"each\", or audit = 0 (the map is then taken for right)".to_owned(),
            );
        };
        // The map may not decide some of the first samples.
        let open = |samples: u64| audit::upper_bound(0, samples - samples / 20, confidence);
        let wanted = |reach: f64| (libm::log(1.0 - confidence) / libm::log1p(-reach) / 0.95).ceil() as u64 + 2;
        let audit = match audit {
            Some(Audit::Share(_)) => {
                return complain(
                    "sampling.until needs to know how many samples are audited: give sampling.audit as a whole number of samples of each cell".to_owned(),
                );
            }
            Some(Audit::Samples(samples)) => samples,
            None => wanted(0.5 * half_width),
        };
        let left = half_width - open(audit);
        if left <= 0.1 * half_width {
            return complain(format!(
                "sampling.until.half_width = {half_width} cannot be reached with sampling.audit = {audit}, which leaves {:.2e} of the samples of a cell open: audit = {} leaves half of it, audit = 0 takes the verdict map for right",
                open(audit),
                wanted(0.5 * half_width)
            ));
        }
        Ok((Audit::Samples(audit), Precision { half_width: Some(left), relative: None }))
    }
}
