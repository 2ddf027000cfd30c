//! The methods: how the probability of a cell is found. Each is a [`Method`] in a file of its own, which says what it
//! takes, what it needs and what it returns; everything else asks it.

use super::diagnosis::Complaint;
use super::method::Method;
use super::sampling_key::Key;
use super::sampling_spec::{EvaluateMode, SamplingMethod, SamplingSpec};

mod independent;

mod until;

mod sobol;

mod conditional;

mod importance;

mod subset;

mod integral;

mod map_integral;

/// All methods.
const ALL: [&dyn Method; 8] = [
    &independent::Independent,
    &until::Until,
    &sobol::Sobol,
    &conditional::Conditional,
    &importance::Importance,
    &subset::Subset,
    &integral::Integral,
    &map_integral::MapIntegral,
];

/// The method of a job, whose boundary of stability is known in closed form or not.
pub fn method(spec: &SamplingSpec, has_closed_form: bool) -> &'static dyn Method {
    match spec.method() {
        SamplingMethod::MonteCarlo if spec.until.is_some() => &until::Until,
        SamplingMethod::MonteCarlo => &independent::Independent,
        SamplingMethod::Sobol => &sobol::Sobol,
        SamplingMethod::Conditional => &conditional::Conditional,
        SamplingMethod::Importance => &importance::Importance,
        SamplingMethod::Subset => &subset::Subset,
        SamplingMethod::Exact if has_closed_form => &integral::Integral,
        SamplingMethod::Exact => &map_integral::MapIntegral,
    }
}

impl SamplingSpec {
    /// The keys that have no meaning with the method of the job.
    pub fn foreign_keys(&self, method: &'static dyn Method) -> Vec<Complaint> {
        let foreign = |key: &Key| {
            let (name, span) = key.given(self);
            let span = span?;
            let option = if *key == Key::Samples { " (or --samples)" } else { "" };
            if !method.takes(*key) {
                let (asked, clause, instead) = (method.asked(), method.clause(), takers(*key, method));
                let message =
                    format!("sampling.{name} has no meaning with {asked}, {clause}; remove it{option}, or {instead}");
                return Some(Complaint::at(span, message));
            }
            let is_of_lookups = *key == Key::Audit && method.takes(Key::Evaluate);
            (is_of_lookups && self.evaluate_mode() != EvaluateMode::Boundary).then(|| {
                let message = "sampling.audit belongs to evaluate = \"boundary\" and to method = \"exact\"; remove it, or change one of these";
                Complaint::at(span, message)
            })
        };
        Key::ALL.iter().filter_map(foreign).collect()
    }
}

/// What to do for a key to have a meaning.
fn takers(key: Key, method: &dyn Method) -> String {
    let mut takers: Vec<_> = ALL.iter().filter(|taker| taker.takes(key)).map(|taker| taker.written()).collect();
    takers.dedup();
    if takers.contains(&method.written()) {
        return format!("remove {}", method.asked());
    }
    let names: Vec<String> = takers.iter().map(|taker| format!("\"{}\"", taker.name())).collect();
    format!("use method = {}", names.join(" or "))
}
