//! A job with imprecise inputs written out in full, with every default filled in.

use toml_edit::{DocumentMut, Item, Value};

use super::imprecise::ImpreciseJob;
use super::imprecise_values::{Values, What};

impl ImpreciseJob {
    /// The job with everything written out, as TOML that `bounds` takes.
    pub fn normalised(&self) -> String {
        let text = self.first().normalised();
        let Ok(mut document) = text.parse::<DocumentMut>() else { return text };
        // A list of standard deviations is an axis, whose entries cannot be imprecise.
        let stds = document.get_mut("random").and_then(|random| random.get_mut("relative_std"));
        if let Some(stds) = stds
            && let Some(only) = stds.as_array_of_tables().and_then(|list| list.iter().next()).cloned()
        {
            *stds = Item::Table(only);
        }
        for quantity in &self.quantities {
            if let Ok(value) = written(&quantity.values).parse::<Value>() {
                put(&mut document, &quantity.what, value);
            }
        }
        document.to_string()
    }
}

/// Imprecise values as a job has them.
fn written(values: &Values) -> String {
    match values {
        Values::Between([low, high]) => format!("{{ between = [{low:?}, {high:?}] }}"),
        Values::OneOf(values) => format!("{{ one_of = [{}] }}", values.join(", ")),
    }
}

/// Puts a value in the place of what has it.
fn put(document: &mut DocumentMut, what: &What, value: Value) {
    match what {
        What::Expected(name) => {
            let is_axis = document.get("axes").and_then(|axes| axes.get(name)).is_some();
            let table = if is_axis { &mut document["axes"] } else { &mut document["model"]["parameters"] };
            table[name] = Item::Value(value);
        }
        What::RelativeStd(input) => document["random"]["relative_std"][input] = Item::Value(value),
        // That of a normal distribution is not written out.
        What::Distribution(input) => document["random"]["distribution"][input] = Item::Value(value),
        What::Correlation => {
            let pairs = document["random"]["correlation"].as_array_mut();
            let pair = pairs.and_then(|pairs| pairs.get_mut(0)).and_then(Value::as_array_mut);
            if let Some(coefficient) = pair.and_then(|pair| pair.get_mut(2)) {
                *coefficient = value.decorated(" ", "");
            }
        }
    }
}
