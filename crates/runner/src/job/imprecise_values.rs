//! Imprecise values in the text of a job spec: `{ between = [LOW, HIGH] }` and `{ one_of = [A, B, ...] }`.

use std::borrow::Cow;
use std::collections::HashSet;
use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::diagnosis::{Complaint, Complaints};

/// The keys of imprecise values.
const BETWEEN: &str = "between";
const ONE_OF: &str = "one_of";

/// What is imprecise.
#[derive(Debug, Clone)]
pub enum What {
    /// The expected value of a quantity, by the name of its axis.
    Expected(String),
    /// The relative standard deviation of an input.
    RelativeStd(String),
    /// The distribution of an input.
    Distribution(String),
    /// The coefficient of a correlated pair.
    Correlation,
}

/// The values that something imprecise may have.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// All between two ends, of which the first is less.
    Between([f64; 2]),
    /// One of these, as written.
    OneOf(Vec<String>),
}

/// A key or a place in a list.
#[derive(Debug, Clone, PartialEq)]
enum Step {
    Key(String),
    Index(usize),
}

/// An imprecise value of a job spec.
#[derive(Debug, Clone)]
pub struct ImpreciseValue<'a> {
    /// What has it.
    pub what: What,
    /// The values that it may have.
    pub values: Values,
    /// Its key, for messages.
    pub key: String,
    /// Its place in the text.
    pub span: Range<usize>,
    path: Vec<Step>,
    /// The ends or alternatives, to put in its place.
    choices: Vec<DeValue<'a>>,
}

impl ImpreciseValue<'_> {
    /// How many ends or alternatives it has.
    pub fn choices(&self) -> usize {
        self.choices.len()
    }
}

/// All imprecise values of a job spec, in the order of the text; with a complaint about each that is none, in whose
/// place its first number stands afterwards.
pub fn find<'a>(
    document: &mut Spanned<DeTable<'a>>,
    text: &str,
    complaints: &mut Complaints,
) -> Vec<ImpreciseValue<'a>> {
    for key in ["relative_std", "distribution"] {
        write_by_input(document.get_mut(), key);
    }
    let mut places = Vec::new();
    for (key, value) in document.get_ref() {
        walk(value, &mut vec![Step::Key(key.get_ref().to_string())], &mut places);
    }
    places.sort_by_key(|(_, span)| span.start);
    let mut found = Vec::new();
    let mut refused = HashSet::new();
    for (path, span) in places {
        let Some(DeValue::Table(table)) = value_at(document.get_mut(), &path).map(|value| value.clone()) else {
            continue;
        };
        let key = key_of(&path);
        let choices = choices_of(&table);
        let read = what_at(&path).and_then(|what| {
            let values = values_of(&table, text, matches!(what, What::Distribution(_)))?;
            Ok((what, values))
        });
        match (read, choices) {
            (Ok((what, values)), Some(choices)) => {
                found.push(ImpreciseValue { what, values, key, span, path, choices });
            }
            (Ok(_), None) => {}
            (Err(message), choices) => {
                // One that is given for all inputs stands for each of them, and is complained about once.
                if refused.insert(span.start) {
                    complaints.push(Complaint::at(span, format!("{key}: {message}")));
                }
                let first = choices.and_then(|choices| choices.into_iter().next());
                if let (Some(first), Some(place)) = (first, value_at(document.get_mut(), &path)) {
                    *place = first;
                }
            }
        }
    }
    found
}

/// Puts one of the ends or alternatives in the place of each imprecise value.
pub fn put<'a>(document: &mut Spanned<DeTable<'a>>, values: &[ImpreciseValue<'a>], choice: impl Fn(usize) -> usize) {
    for (i, value) in values.iter().enumerate() {
        if let (Some(chosen), Some(place)) = (value.choices.get(choice(i)), value_at(document.get_mut(), &value.path)) {
            *place = chosen.clone();
        }
    }
}

/// Whether a table stands for an imprecise value.
fn is_imprecise(table: &DeTable<'_>) -> bool {
    table.keys().any(|key| [BETWEEN, ONE_OF].contains(&&**key.get_ref()))
}

/// Writes an imprecise value that is given for all inputs as a table by input: each has a value of its own.
fn write_by_input(document: &mut DeTable<'_>, key: &str) {
    let Some(DeValue::Table(random)) = value_at(document, &[Step::Key("random".to_owned())]) else { return };
    let inputs: Vec<Spanned<Cow<'_, str>>> = match value_at(random, &[Step::Key("inputs".to_owned())]) {
        Some(DeValue::Array(inputs)) => inputs
            .iter()
            .filter_map(|input| match input.get_ref() {
                DeValue::String(name) => Some(Spanned::new(input.span(), Cow::Owned(name.to_string()))),
                _ => None,
            })
            .collect(),
        _ => return,
    };
    let Some(entry) = random.iter_mut().find(|(name, _)| name.get_ref() == key).map(|(_, value)| value) else { return };
    let span = entry.span();
    let value = entry.get_mut();
    if let DeValue::Table(table) = &*value
        && is_imprecise(table)
        && !inputs.is_empty()
    {
        let each = inputs.into_iter().map(|input| (input, Spanned::new(span.clone(), value.clone())));
        *value = DeValue::Table(each.collect());
    }
}

/// The places of tables with a key of an imprecise value.
fn walk(value: &Spanned<DeValue<'_>>, path: &mut Vec<Step>, places: &mut Vec<(Vec<Step>, Range<usize>)>) {
    match value.get_ref() {
        DeValue::Table(table) if is_imprecise(table) => places.push((path.clone(), value.span())),
        DeValue::Table(table) => {
            for (key, value) in table {
                path.push(Step::Key(key.get_ref().to_string()));
                walk(value, path, places);
                path.pop();
            }
        }
        DeValue::Array(list) => {
            for (i, value) in list.iter().enumerate() {
                path.push(Step::Index(i));
                walk(value, path, places);
                path.pop();
            }
        }
        _ => {}
    }
}

fn value_at<'t, 'a>(table: &'t mut DeTable<'a>, path: &[Step]) -> Option<&'t mut DeValue<'a>> {
    let (Step::Key(first), rest) = path.split_first()? else { return None };
    let (_, value) = table.iter_mut().find(|(key, _)| key.get_ref() == first)?;
    let mut value = value.get_mut();
    for step in rest {
        value = match (value, step) {
            (DeValue::Table(table), Step::Key(name)) => {
                table.iter_mut().find(|(key, _)| key.get_ref() == name).map(|(_, value)| value.get_mut())?
            }
            (DeValue::Array(list), Step::Index(i)) => list.get_mut(*i)?.get_mut(),
            _ => return None,
        };
    }
    Some(value)
}

/// The key of a value, for messages.
fn key_of(path: &[Step]) -> String {
    let names: Vec<&str> =
        path.iter().filter_map(|step| if let Step::Key(name) = step { Some(&**name) } else { None }).collect();
    match names[..] {
        ["random", key, input] => format!("random.{key} of {input}"),
        _ => names.join("."),
    }
}

/// What a place has the value of.
fn what_at(path: &[Step]) -> Result<What, String> {
    let names: Vec<Option<&str>> =
        path.iter().map(|step| if let Step::Key(name) = step { Some(&**name) } else { None }).collect();
    match (&names[..], path) {
        ([Some("axes"), Some(_)] | [Some("axes"), Some(_), Some(_)], _) => {
            let name = names[1..].iter().flatten().copied().collect::<Vec<&str>>().join(".");
            Ok(What::Expected(name))
        }
        ([Some("model"), Some("parameters"), Some(name)], _) => Ok(What::Expected((*name).to_owned())),
        ([Some("random"), Some("relative_std"), Some(input)], _) => Ok(What::RelativeStd((*input).to_owned())),
        ([Some("random"), Some("distribution"), Some(input)], _) => Ok(What::Distribution((*input).to_owned())),
        ([Some("random"), Some("correlation"), None, None], [.., Step::Index(2)]) => {
            Ok(What::Correlation)
        }
        ([Some("random"), Some("relative_std"), ..], _) => Err(
            "a list of relative_std makes an axis, and its entries cannot be imprecise; give one table, relative_std = { INPUT = { between = [0.1, 0.2] }, ... }".to_owned(),
        ),
        _ => Err(format!("this cannot be imprecise; {PLACES}")),
    }
}

const PLACES: &str = "imprecise may be axes (also of parameters, axes.\"section.name\"), the model.parameters of matrices, random.relative_std, random.distribution and the coefficients of random.correlation";

/// The elements of the list of an imprecise value.
fn choices_of<'a>(table: &DeTable<'a>) -> Option<Vec<DeValue<'a>>> {
    match table.iter().next().map(|(_, value)| value.get_ref()) {
        Some(DeValue::Array(list)) => Some(list.iter().map(|value| value.get_ref().clone()).collect()),
        _ => None,
    }
}

/// The ends or alternatives of an imprecise value, checked.
fn values_of(table: &DeTable<'_>, text: &str, is_distribution: bool) -> Result<Values, String> {
    const FORM: &str = "an imprecise value is { between = [LOW, HIGH] } or { one_of = [A, B] }";
    let mut entries = table.iter();
    let (Some((key, value)), None) = (entries.next(), entries.next()) else {
        return Err(format!("{FORM}, with no other key"));
    };
    let DeValue::Array(list) = value.get_ref() else { return Err(format!("{FORM}, with a list")) };
    let written = |value: &Spanned<DeValue<'_>>| text.get(value.span()).unwrap_or_default().to_owned();
    if key.get_ref() == ONE_OF {
        let values: Vec<String> = list.iter().map(written).collect();
        if let Some(i) = (1..values.len()).find(|&i| values[..i].contains(&values[i])) {
            return Err(format!("one_of lists {} twice", values[i]));
        }
        return match &values[..] {
            [] => Err("one_of is empty; it needs two values or more".to_owned()),
            [only] => Err(format!("one_of has the one value {only}; write {only} without one_of")),
            _ => Ok(Values::OneOf(values)),
        };
    }
    if is_distribution {
        return Err(
            "nothing lies between distributions; list them: { one_of = [\"normal\", \"lognormal\"] }".to_owned()
        );
    }
    let [low, high] = &**list else {
        return Err(format!("between has {} values; it is two ends, {{ between = [LOW, HIGH] }}", list.len()));
    };
    let end = |value: &Spanned<DeValue<'_>>| {
        let number = number(value.get_ref()).filter(|number| number.is_finite());
        number.ok_or_else(|| format!("{} is no end of an interval; it must be a number", written(value)))
    };
    let ends = [end(low)?, end(high)?];
    if ends[0] > ends[1] {
        return Err(format!("between = [{}, {}] is reversed; write between = [{1}, {0}]", ends[0], ends[1]));
    }
    if ends[0] == ends[1] {
        return Err(format!("both ends of between are {0}; write {0} in place of an interval", ends[0]));
    }
    Ok(Values::Between(ends))
}

fn number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Integer(integer) => i64::from_str_radix(integer.as_str(), integer.radix()).ok().map(|n| n as f64),
        DeValue::Float(float) => float.as_str().parse().ok(),
        _ => None,
    }
}
