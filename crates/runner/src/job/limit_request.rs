//! The limits that a job asks for in its table `[limit]`.

use toml::Spanned;

use super::diagnosis::{Complaint, Complaints};
use super::limit_spec::LimitSpec;

/// Largest number of targets of a job.
const MOST_TARGETS: usize = 100;

/// The limits that the table `[limit]` asks for.
#[derive(Debug, Clone, PartialEq)]
pub struct LimitRequest {
    /// The name of the axis.
    pub of: String,
    /// The probabilities that must not be exceeded.
    pub targets: Vec<f64>,
}

impl LimitRequest {
    /// Checks what of the table does not depend on the rest of the job.
    pub fn check_keys(spec: Option<&Spanned<LimitSpec>>, complaints: &mut Complaints) {
        let Some(spec) = spec else { return };
        let LimitSpec { of, probability } = spec.get_ref();
        if of.is_none() {
            let message =
                "missing key `of` in [limit]: along which axis are limits sought? Write of = \"AXIS\" with its name";
            complaints.push(Complaint::missing("of", Some(spec.span()), message));
        }
        let Some(targets) = probability else {
            let message = "missing key `probability` in [limit]: which probability of instability must not be exceeded? For example probability = 0.01";
            complaints.push(Complaint::missing("probability", Some(spec.span()), message));
            return;
        };
        let values = &targets.get_ref().0;
        let wrong = values.iter().find(|value| !(0.0 < **value && **value < 1.0));
        let repeated = values.iter().enumerate().find(|(i, value)| values[..*i].contains(value));
        let message = match (values.len(), wrong, repeated) {
            (0, ..) => "limit.probability is empty; write for example [0.01, 1e-5]".to_owned(),
            (_, Some(value), _) => format!(
                "limit.probability = {value} is out of range: a probability is greater than 0 and less than 1, for example 0.01 for 1 %"
            ),
            (_, _, Some((_, value))) => format!("limit.probability has {value} twice; list it once"),
            (count, ..) if count > MOST_TARGETS => {
                format!("limit.probability has {count} values; the limit is {MOST_TARGETS}")
            }
            _ => return,
        };
        complaints.push(Complaint::at(targets.span(), message));
    }
}
