//! What methods, and some keys of `[sampling]`, need of the model and of the random inputs. A need that is not met is
//! refused here.

use std::ops::Range;

use stickslip_core::model::Model;

use super::diagnosis::Complaint;
use super::random::RandomInputSet;

/// What may be needed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Need {
    /// A pair of quantities over which the boundary of stability is a curve.
    Pair,
    /// No random inputs but the pair.
    PairAlone,
    /// The boundary of stability in closed form, or critical values of one input.
    ClosedForm,
    /// One random input, and no other.
    OneInput,
    /// One of the pair among the random inputs, or critical values of one of them.
    OneOfPair,
    /// Random inputs other than the pair.
    Others,
    /// A correlation of the inputs of which that of the pair can be separated.
    SeparatePair,
    /// Inputs that are normal and independent.
    IndependentNormal,
    /// The same, for integrals over verdict maps.
    NormalOverMap,
    /// Inputs that are independent, and so many of them at least.
    Independent(usize),
    /// Random inputs, so many at most.
    Inputs(usize),
    /// A standard deviation above 0.
    Scatter,
    /// Nothing that is recorded.
    NothingRecorded,
}

/// What has needs.
pub struct Asked<'a> {
    /// As written, after `sampling.`.
    pub what: &'a str,
    /// Where.
    pub span: Option<Range<usize>>,
    /// What it needs.
    pub needs: &'a [Need],
    /// What to do where that is not met.
    pub instead: &'a str,
}

impl Asked<'_> {
    /// Refuses what is asked for where a need is not met.
    ///
    /// # Errors
    /// The first such need, and what would be right.
    pub fn check(&self, model: &dyn Model, inputs: &RandomInputSet) -> Result<(), Complaint> {
        let Some(lack) = self.needs.iter().find_map(|need| need.lack(model, inputs)) else { return Ok(()) };
        let message = format!("sampling.{} {lack}{}", self.what, self.instead);
        Err(Complaint::maybe_at(self.span.clone(), message))
    }
}

impl Need {
    /// What is missing, as a sentence up to its remedy; `None` if nothing is.
    pub fn lack(self, model: &dyn Model, inputs: &RandomInputSet) -> Option<String> {
        let pair = pair_names(model);
        let integrated = model.integrated(&inputs.inputs);
        let others = inputs.others(integrated);
        match self {
            Self::Pair => model.pair().is_none().then(|| {
                "needs a boundary of stability that is a curve over a pair of quantities, and this model has no such pair; ".to_owned()
            }),
            Self::OneInput => match inputs.inputs[..] {
                [_] => None,
                [] => Some(format!(
                    "integrates over one random input, and random.inputs lists none; add one, for example inputs = [{}], or ",
                    example_inputs(model)
                )),
                _ => Some(format!(
                    "integrates over one random input; random.inputs lists {}; ",
                    inputs.inputs.len()
                )),
            },
            Self::PairAlone => inputs.other().map(|other| {
                let name = &model.quantities()[other].name;
                format!("knows the boundary of stability as a curve over {pair}; random.inputs also lists {name}; ")
            }),
            Self::ClosedForm => (!model.has_closed_form() && integrated.is_none()).then(|| {
                format!("integrates over {pair} where the boundary of stability is known in closed form: with criterion.kind = \"eigenvalue\". For this criterion ")
            }),
            Self::OneOfPair => (inputs.pair() == [None, None] && integrated.is_none())
                .then(|| format!("integrates over {pair}, and random.inputs lists neither; ")),
            Self::Others => others.is_empty().then(|| {
                match integrated {
                    Some(place) => format!("draws the inputs other than {}, and random.inputs lists none; method = \"exact\" integrates over it without samples; otherwise ", model.quantities()[place].name),
                    None => format!("draws the inputs other than {pair}, and random.inputs lists none; method = \"exact\" integrates over these two without samples; otherwise "),
                }
            }),
            Self::SeparatePair => inputs.correlation_with_last(integrated).err().map(|error| {
                format!("cannot separate these inputs: {error}; lower the coefficients of random.correlation, or ")
            }),
            Self::IndependentNormal => (!inputs.is_plain()).then(|| {
                "needs independent normal inputs, without random.distribution and random.correlation; otherwise ".to_owned()
            }),
            Self::NormalOverMap => (!inputs.is_plain()).then(|| {
                "integrates independent normal inputs over a verdict map; for other distributions or correlation use criterion.kind = \"eigenvalue\", or ".to_owned()
            }),
            Self::Independent(least) => (inputs.inputs.len() < least || !inputs.correlation.is_independent()).then(|| {
                format!("splits the variance among independent inputs: it needs at least {least} of them, without random.correlation; otherwise ")
            }),
            Self::Inputs(most) => match inputs.inputs.len() {
                0 => Some(format!(
                    "draws random inputs, and random.inputs lists none; add some, for example inputs = [{}], or ",
                    example_inputs(model)
                )),
                listed if listed > most => Some(format!(
                    "takes at most {most} random inputs; random.inputs lists {listed}. Let fewer scatter, or "
                )),
                _ => None,
            },
            Self::Scatter => inputs.scatters_nothing().then(|| {
                "looks for rare events, and nothing scatters: all standard deviations of [random] are 0; give some above 0, or ".to_owned()
            }),
            Self::NothingRecorded => (!model.recorded().is_empty())
                .then(|| "records nothing of its samples; remove criterion.record, or ".to_owned()),
        }
    }
}

/// The names of the pair of a model: "preload and static_friction".
fn pair_names(model: &dyn Model) -> String {
    let names = model.pair().map(|pair| pair.map(|place| model.quantities()[place].name.to_string()));
    names.map_or_else(|| "a pair of quantities".to_owned(), |names| names.join(" and "))
}

/// Inputs that a job may list.
fn example_inputs(model: &dyn Model) -> String {
    let names = model.quantities().iter().take(2).map(|quantity| format!("\"{}\"", quantity.name));
    names.collect::<Vec<_>>().join(", ")
}
