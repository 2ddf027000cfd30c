//! A job with what `fit` has estimated.

use stickslip_sampler::fit::{Fit, FitModel};
use stickslip_sampler::inputs::PairParameter;
use toml_edit::{Array, DocumentMut, InlineTable, Item, Value};

use crate::job::Job;
use crate::picture::view::rounded;

/// Most characters of the name of a job.
const LONGEST_NAME: usize = 100;

/// What is added to the name of the job.
const SUFFIX: &str = "-fitted";

/// A number with six digits, as the comments show it.
fn short(value: f64) -> f64 {
    rounded(value).parse().unwrap_or(value)
}

/// The text of `job` with the estimates in place, after comments that `origin` begins; `None` if it cannot be written as TOML.
pub fn fitted_job(job: &Job, model: &FitModel, fit: &Fit<'_>, origin: &str) -> Option<String> {
    let mut document: DocumentMut = job.normalised().parse().ok()?;
    let kept = job.name.len().min(LONGEST_NAME - SUFFIX.len());
    document["name"] = toml_edit::value(format!("{}{SUFFIX}", job.name.get(..kept)?));
    let is_estimated = |parameter: PairParameter| fit.parameters.iter().any(|fitted| fitted.parameter == parameter);
    let one = |value: f64| Item::Value(Value::Array(Array::from_iter([short(value)])));
    let pair = job.model().pair()?;
    let [first, second] = pair.map(|place| &*job.quantity(place).name);
    if is_estimated(PairParameter::Expected(1)) {
        document["axes"][second] = one(fit.values.expected[1]);
    }
    if is_estimated(PairParameter::Expected(0)) {
        let values = job.grid.values_of(pair[0]).into_iter().map(|value| short(value * fit.values.expected[0]));
        document["axes"][first] = Item::Value(Value::Array(values.collect()));
    }
    let stds = [(first, PairParameter::RelativeStd(0)), (second, PairParameter::RelativeStd(1))];
    if stds.iter().any(|(_, parameter)| is_estimated(*parameter)) {
        let mut table = InlineTable::new();
        let random = &job.random;
        for ((name, parameter), position) in stds.into_iter().zip(random.pair()) {
            // Measured values have a standard deviation of their own, which is not given.
            let Some(position) = position.filter(|&position| !random.is_measured(position)) else { continue };
            let own = random.relative_stds[0][position];
            table.insert(
                name,
                Value::from(if is_estimated(parameter) { short(fit.values.get(parameter)) } else { own }),
            );
        }
        // Its own key was that of a list of tables, and is laid out as one.
        document["random"].as_table_like_mut()?.remove("relative_std");
        document["random"]["relative_std"] = Item::Value(Value::InlineTable(table));
    }
    if is_estimated(PairParameter::Correlation) {
        let mut pair = Array::from_iter([first, second]);
        pair.push(short(fit.values.correlation));
        document["random"]["correlation"] = Item::Value(Value::Array(Array::from_iter([pair])));
    }
    let mut comments = origin.to_owned();
    for fitted in &fit.parameters {
        let end = |end: Option<f64>| end.map_or("open".to_owned(), rounded);
        comments += &format!(
            "#   {} = {} ({} to {})\n",
            model.name(fitted.parameter),
            rounded(fitted.value),
            end(fitted.low),
            end(fitted.high)
        );
    }
    if is_estimated(PairParameter::Expected(0)) {
        comments += &format!("# axes.{first} holds the true {first}s: the nominal ones times {first}_factor.\n");
    }
    Some(format!("{comments}\n{document}"))
}
