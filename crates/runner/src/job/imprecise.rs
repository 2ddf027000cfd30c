//! Jobs whose inputs are known as intervals or alternatives: one precise job for each combination of alternatives.

use std::collections::HashSet;
use std::fmt::Write as _;
use std::path::Path;

use toml::Spanned;
use toml::de::DeTable;

use super::diagnosis::{Complaint, Complaints};
use super::imprecise_values::{ImpreciseValue, Values, What, find, put};
use super::model::{Boundary, Draft};
use super::models;
use super::reading;
use super::sampling_spec::SamplingMethod;
use super::spec::JobSpec;
use super::validated::Job;
use super::validation::validate;

/// Combinations of alternatives at most.
const MOST_COMBINATIONS: usize = 1000;

/// Intervals at most; the search is over all of them together.
const MOST_INTERVALS: usize = 6;

/// Something imprecise.
#[derive(Debug, Clone)]
pub struct ImpreciseQuantity {
    /// What it is.
    pub what: What,
    /// Its key, for messages.
    pub key: String,
    /// The values that it may have.
    pub values: Values,
}

/// One choice of all alternatives.
#[derive(Debug)]
pub struct Combination {
    /// For each imprecise quantity the place of its alternative; 0 for intervals.
    pub choice: Vec<usize>,
    /// The job with these, and with the lower ends of all intervals.
    pub job: Job,
}

/// A job with imprecise inputs.
#[derive(Debug)]
pub struct ImpreciseJob {
    /// What is imprecise, in the order of the text.
    pub quantities: Vec<ImpreciseQuantity>,
    /// All combinations of alternatives, the last quantity fastest; at least one.
    pub combinations: Vec<Combination>,
    /// What a user should know of it, in sentences.
    pub warnings: Vec<String>,
}

impl ImpreciseQuantity {
    /// In words, with its values.
    pub fn text(&self) -> String {
        let values = match &self.values {
            Values::Between([low, high]) => format!("between {low} and {high}"),
            Values::OneOf(values) => format!("one of {}", values.join(", ").replace('"', "")),
        };
        format!("{} {values}", self.name())
    }

    /// In words.
    pub fn name(&self) -> String {
        match &self.what {
            What::Expected(name) => format!("expected {name}"),
            What::RelativeStd(input) => format!("relative std of {input}"),
            What::Distribution(input) => format!("distribution of {input}"),
            What::Correlation => "correlation".to_owned(),
        }
    }
}

impl ImpreciseJob {
    /// Reads and checks a spec in which something may be imprecise.
    ///
    /// `None` with at least one complaint if anything of it is refused; without imprecise values there are no quantities.
    pub fn read(text: &str, folder: &Path, complaints: &mut Complaints) -> Option<Self> {
        let mut document = reading::parse(text, complaints)?;
        let values = find(&mut document, text, complaints);
        if complaints.len() > 0 {
            return None;
        }
        let alternatives = |value: &ImpreciseValue<'_>| match value.values {
            Values::Between(_) => 1,
            Values::OneOf(_) => value.choices(),
        };
        let intervals = values.iter().filter(|value| matches!(value.values, Values::Between(_))).count();
        let combinations = values.iter().try_fold(1usize, |all, value| all.checked_mul(alternatives(value)));
        let combinations = combinations.filter(|combinations| *combinations <= MOST_COMBINATIONS);
        let first = values.first().map(|value| value.span.clone());
        if intervals > MOST_INTERVALS {
            let message = format!(
                "the job has {intervals} intervals; the limit is {MOST_INTERVALS}. Give some quantities one value"
            );
            complaints.push(Complaint::maybe_at(first, message));
            return None;
        }
        let Some(combinations) = combinations else {
            let message = format!(
                "the alternatives of one_of make more than {MOST_COMBINATIONS} combinations, the limit; give fewer"
            );
            complaints.push(Complaint::maybe_at(first, message));
            return None;
        };
        let mut family = Family { text, folder, document, values, complaints, is_first: true, warnings: Vec::new() };
        let mut all = Vec::with_capacity(combinations);
        for index in 0..combinations {
            let mut rest = index;
            let mut choice = vec![0; family.values.len()];
            for (place, value) in choice.iter_mut().zip(&family.values).rev() {
                let alternatives = alternatives(value);
                *place = rest % alternatives;
                rest /= alternatives;
            }
            let job = family.checked(&choice, if index == 0 { 1 << intervals } else { 2 })?;
            all.push(Combination { choice, job });
        }
        let quantity =
            |value: ImpreciseValue<'_>| ImpreciseQuantity { what: value.what, key: value.key, values: value.values };
        let quantities = family.values.into_iter().map(quantity).collect();
        Some(Self { quantities, combinations: all, warnings: family.warnings })
    }

    /// The first of the jobs, whose cells are those of all.
    pub fn first(&self) -> &Job {
        &self.combinations[0].job
    }
}

/// Complains of every imprecise value, for what takes precise jobs only; the first of its values stand in their places.
pub fn refuse<'a>(document: &mut Spanned<DeTable<'a>>, text: &str, complaints: &mut Complaints) {
    let values = find(document, text, complaints);
    let mut seen = HashSet::new();
    for value in &values {
        // One that is given for all inputs stands for each of them.
        if seen.insert(value.span.start) {
            let message = format!(
                "{} is imprecise; `stickslip bounds` finds the lower and upper probability over its values (with sampling.method = \"exact\", and criterion.kind = \"eigenvalue\" or \"complex-eigenvalue\"). Everything else takes one value",
                value.key
            );
            complaints.push(Complaint::at(value.span.clone(), message));
        }
    }
    put(document, &values, |_| 0);
}

/// The precise jobs behind an imprecise one.
struct Family<'a, 'c> {
    text: &'a str,
    folder: &'a Path,
    document: Spanned<DeTable<'a>>,
    values: Vec<ImpreciseValue<'a>>,
    complaints: &'c mut Complaints,
    is_first: bool,
    warnings: Vec<String>,
}

impl Family<'_, '_> {
    /// The job with the lower ends of all intervals; it and those at further corners are checked, up to `corners`.
    fn checked(&mut self, choice: &[usize], corners: usize) -> Option<Job> {
        let intervals: Vec<usize> =
            (0..choice.len()).filter(|&i| matches!(self.values[i].values, Values::Between(_))).collect();
        let all = 1 << intervals.len();
        let mut lower = None;
        for corner in 0..corners.min(all) {
            // Of two, the last corner has all upper ends.
            let bits = if corners < all && corner > 0 { all - 1 } else { corner };
            let of = |i: usize| match intervals.iter().position(|&interval| interval == i) {
                Some(bit) => bits >> bit & 1,
                None => choice[i],
            };
            let mut document = self.document.clone();
            put(&mut document, &self.values, of);
            let draft = models::draft(self.text, &document, self.complaints);
            let spec = reading::job_spec(self.text, document, models::suggested, self.complaints)?;
            let draft = draft?;
            for value in &self.values {
                if let What::Expected(name) = &value.what
                    && let Some((instead, _)) = draft.instead_of(name)
                {
                    let message = format!(
                        "{} is converted, and cannot be imprecise; write it as an imprecise axes.{instead}, which `stickslip check` converts",
                        value.key
                    );
                    self.complaints.push(Complaint::at(value.span.clone(), message));
                    return None;
                }
            }
            if std::mem::take(&mut self.is_first) {
                self.check_method(&spec, &*draft);
            }
            let job = validate(&spec, draft, self.folder, self.complaints)?;
            if self.complaints.len() > 0 {
                return None;
            }
            let new = job.warnings().into_iter().filter(|warning| !self.warnings.contains(warning)).collect::<Vec<_>>();
            self.warnings.extend(new);
            lower = lower.or(Some(job));
        }
        lower
    }

    /// Bounds are found from exact probabilities.
    fn check_method(&mut self, spec: &JobSpec, draft: &dyn Draft) {
        let Some(first) = self.values.first() else { return };
        let mut keys = String::new();
        for value in &self.values {
            let _ = write!(keys, "{}{}", if keys.is_empty() { "" } else { ", " }, value.key);
        }
        let because = format!("bounds over imprecise inputs ({keys})");
        match spec.sampling.method.as_ref().map(|method| (method.span(), *method.get_ref())) {
            Some((_, SamplingMethod::Exact)) => {}
            given => {
                let span = given.map_or(first.span.clone(), |(span, _)| span);
                let message = format!("{because} are found without samples: write sampling.method = \"exact\"");
                self.complaints.push(Complaint::at(span, message));
            }
        }
        if draft.boundary().is_some_and(|boundary| boundary == Boundary::Verdicts) {
            let message = format!(
                "{because} need criterion.kind = \"eigenvalue\", whose boundary is known in closed form, or a model given by matrices"
            );
            let span = draft.criterion_span().unwrap_or_else(|| first.span.clone());
            self.complaints.push(Complaint::at(span, message));
        }
    }
}
