//! The methods: how the probability of a cell is found. Each is a [`Method`] in a file of its own, which says what it
//! takes, what it needs and what it returns; everything else asks it.

use clap::ValueEnum as _;

use super::diagnosis::Complaint;
use super::method::Method;
use super::model::{Boundary, JobModel};
use super::random::RandomInputSet;
use super::sampling_key::Key;
use super::sampling_spec::{EvaluateMode, SamplingMethod, SamplingSpec};

mod independent;

mod until;

mod sobol;

mod conditional;

mod importance;

mod subset;

mod integral;

use self::integral::Over;

/// The method of a job, of whose boundary of stability this is known.
pub fn method(spec: &SamplingSpec, boundary: Boundary) -> &'static dyn Method {
    spec.with_method(spec.method(), boundary)
}

/// The method that a job names, without `until`.
fn with_samples(written: SamplingMethod, boundary: Boundary) -> &'static dyn Method {
    match written {
        SamplingMethod::MonteCarlo => &independent::Independent,
        SamplingMethod::Sobol => &sobol::Sobol,
        SamplingMethod::Conditional => &conditional::Conditional,
        SamplingMethod::Importance => &importance::Importance,
        SamplingMethod::Subset => &subset::Subset,
        SamplingMethod::Exact => match boundary {
            Boundary::ClosedForm => &integral::Integral { over: Over::ClosedForm },
            Boundary::CriticalValues => &integral::Integral { over: Over::OneInput },
            Boundary::Verdicts => &integral::Integral { over: Over::Map },
        },
    }
}

/// A method, and what it is to be used with: model and inputs, if they are known.
#[derive(Clone, Copy)]
pub struct Chosen<'a> {
    pub method: &'static dyn Method,
    pub boundary: Boundary,
    pub others: Option<(&'a RandomInputSet, &'a dyn JobModel)>,
}

impl SamplingSpec {
    /// The method that its other keys make of a name.
    fn with_method(&self, written: SamplingMethod, boundary: Boundary) -> &'static dyn Method {
        match written {
            SamplingMethod::MonteCarlo if self.until.is_some() => &until::Until,
            _ => with_samples(written, boundary),
        }
    }

    /// The keys that have no meaning with the method of the job.
    pub fn foreign_keys(&self, chosen: Chosen<'_>) -> Vec<Complaint> {
        let foreign = |key: &Key| {
            let (name, span) = key.given(self);
            let (span, method) = (span?, chosen.method);
            let option = if *key == Key::Samples { " (or --samples)" } else { "" };
            if !method.takes(*key) {
                let (asked, clause, or) = (method.asked(), method.clause(), self.alternative(*key, chosen));
                let message = format!("sampling.{name} has no meaning with {asked}, {clause}; remove it{option}{or}");
                return Some(Complaint::at(span, message));
            }
            (*key == Key::Audit && !self.has_what_is_audited(method)).then(|| {
                let message = "sampling.audit belongs to evaluate = \"boundary\" and to methods whose probabilities do not come from plain samples (\"exact\", \"conditional\", \"importance\", \"subset\"); remove it, or change one of these";
                Complaint::at(span, message)
            })
        };
        Key::ALL.iter().filter_map(foreign).collect()
    }

    /// Whether samples are looked up, or integrals taken over a verdict map.
    fn has_what_is_audited(&self, method: &dyn Method) -> bool {
        method.has_plain_samples() || !method.takes(Key::Evaluate) || self.evaluate_mode() == EvaluateMode::Boundary
    }

    /// With which methods a key has a meaning, and all others that are given, as the end of a message; empty if there is
    /// none.
    fn alternative(&self, key: Key, chosen: Chosen<'_>) -> String {
        let Chosen { method, boundary, others } = chosen;
        if method.written() == SamplingMethod::MonteCarlo && with_samples(method.written(), boundary).takes(key) {
            return format!(", or remove {}", method.asked());
        }
        let suits = |written: &&SamplingMethod| {
            let other = self.with_method(**written, boundary);
            let given = |key: &&Key| key.given(self).1.is_some();
            let can_audit = self.audit.is_none() || self.has_what_is_audited(other);
            let is_met = |(inputs, model): (&RandomInputSet, &dyn JobModel)| {
                other.needs().iter().all(|need| need.lack(model.model(), inputs).is_none())
            };
            other.takes(key)
                && can_audit
                && Key::ALL.iter().filter(given).all(|key| other.takes(*key))
                && others.is_none_or(is_met)
        };
        let names: Vec<String> = SamplingMethod::value_variants()
            .iter()
            .filter(suits)
            .map(|suiting| format!("\"{}\"", suiting.name()))
            .collect();
        match names.split_last() {
            None => String::new(),
            Some((only, [])) => format!(", or use method = {only}"),
            Some((last, others)) => format!(", or use method = {} or {last}", others.join(", ")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values for the keys, one of each.
    const GIVEN: [&str; 12] = [
        "samples = 1024",
        "until = { half_width = 0.1 }",
        "evaluate = \"boundary\"",
        "audit = 20",
        "randomisations = 8",
        "particles = 60",
        "common_random_numbers = true",
        "confidence = 0.9",
        "interval = \"wilson\"",
        "simultaneous = true",
        "derivatives = true",
        "sensitivity = true",
    ];

    fn refused(written: &str, keys: &str, boundary: Boundary) -> Vec<String> {
        let spec: SamplingSpec = toml::from_str(&format!("method = \"{written}\"\n{keys}")).unwrap();
        let method = method(&spec, boundary);
        let complaints = spec.foreign_keys(Chosen { method, boundary, others: None });
        complaints.iter().map(|complaint| complaint.message.clone()).collect()
    }

    #[test]
    fn a_method_that_a_message_names_takes_the_keys() {
        let names: Vec<String> = SamplingMethod::value_variants().iter().map(|method| method.name()).collect();
        let (mut refusals, mut remedies) = (0, 0);
        for (written, boundary) in names.iter().flat_map(|name| {
            [Boundary::ClosedForm, Boundary::CriticalValues, Boundary::Verdicts].map(|boundary| (name, boundary))
        }) {
            for (first, second) in GIVEN.iter().flat_map(|first| GIVEN.iter().map(move |second| (first, second))) {
                let keys = if first == second { (*first).to_owned() } else { format!("{first}\n{second}") };
                for message in refused(written, &keys, boundary) {
                    refusals += 1;
                    let Some((_, named)) = message.split_once("use method = ") else { continue };
                    for name in named.split('"').skip(1).step_by(2) {
                        remedies += 1;
                        let still = refused(name, &keys, boundary);
                        assert!(still.is_empty(), "{written}, {keys}: {message}\n{name}: {still:?}");
                    }
                }
            }
        }
        assert!(refusals > 200 && remedies > 100, "{refusals} refusals name {remedies} methods");
    }

    #[test]
    fn every_key_has_a_meaning_with_some_method_and_without_another() {
        for key in Key::ALL {
            let takes = |method: &dyn Method| method.takes(key);
            let all = SamplingMethod::value_variants().iter().map(|written| with_samples(*written, Boundary::Verdicts));
            let further: [&dyn Method; 2] = [&until::Until, with_samples(SamplingMethod::Exact, Boundary::ClosedForm)];
            let takers = all.chain(further).filter(|method| takes(*method)).count();
            // All may be audited: a map, or a probability that does not come from plain samples.
            let most = if key == Key::Audit { 8 } else { 7 };
            assert!((1..=most).contains(&takers), "{key:?} has {takers} takers");
        }
    }
}
