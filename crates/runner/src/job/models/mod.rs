//! The kinds of models that job specs know: how each reads its tables `[model]` and `[criterion]`.
//!
//! Everything else in a job, axes, random inputs, sampling, limits, goes by the quantities of the model and knows no kind.

use std::ops::Range;

use schemars::{Schema, SchemaGenerator};
use serde_json::{Map, Value, json};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::axes_spec::AxisSpec;
use super::diagnosis::{Complaint, Complaints};
use super::keys::nearest;
use super::model::{Draft, Kind};
use super::reading::is_of_model;
use super::spec::JobSpec;

pub mod record_spec;

pub mod start_spec;

pub mod pad_on_disc;

mod belt_oscillator;

pub mod matrices;

#[cfg(test)]
mod two_masses;

/// The kinds; the first is meant where a job does not say.
const KINDS: &[Kind] = &[
    pad_on_disc::KIND,
    belt_oscillator::KIND,
    matrices::KIND,
    #[cfg(test)]
    two_masses::KIND,
];

/// Reads the model of a job by its kind.
pub fn draft(text: &str, document: &Spanned<DeTable<'_>>, complaints: &mut Complaints) -> Option<Box<dyn Draft>> {
    let mut tables = document.clone();
    let others: Vec<_> = tables.get_ref().keys().filter(|key| !is_of_model(key.get_ref())).cloned().collect();
    others.iter().for_each(|key| drop(tables.get_mut().remove(key)));
    let kind = match kind_of(tables.get_mut()) {
        None => match kind_by_keys(text, &tables) {
            None => Some(&KINDS[0]),
            Some((kind, span)) => {
                let message = format!(
                    "missing key `kind` in [model]: its keys are those of another kind of model than \"{}\", which is meant without one; write kind = \"{}\"",
                    KINDS[0].name, kind.name
                );
                complaints.push(Complaint::missing("kind", Some(span), message));
                None
            }
        },
        Some((name, span)) => {
            let kind = KINDS.iter().find(|kind| kind.name == name);
            if kind.is_none() {
                complaints.push(unknown_kind(&name, span));
            }
            kind
        }
    };
    let kind = kind?;
    leave_out_criterion_of_another(kind, tables.get_mut(), complaints);
    (kind.draft)(text, tables, complaints)
}

/// The kind that the keys of a model without one are of, and where the model is: less is wrong with its tables as that
/// kind than as the one that is meant without the key. One key less may be a slip.
fn kind_by_keys(text: &str, tables: &Spanned<DeTable<'_>>) -> Option<(&'static Kind, Range<usize>)> {
    let (model, _) = tables.get_ref().iter().find(|(key, _)| key.get_ref() == "model")?;
    let faults = |kind: &Kind| {
        let mut complaints = Complaints::default();
        drop((kind.draft)(text, tables.clone(), &mut complaints));
        complaints.len()
    };
    let usual = faults(&KINDS[0]);
    if usual < 2 {
        return None;
    }
    let (least, kind) = KINDS[1..].iter().map(|kind| (faults(kind), kind)).min_by_key(|(faults, _)| *faults)?;
    (least + 2 <= usual).then(|| (kind, model.span()))
}

/// Refuses a criterion that other kinds of models have. Its table is left out then, as all else in it belongs to those.
fn leave_out_criterion_of_another(kind: &Kind, tables: &mut DeTable<'_>, complaints: &mut Complaints) {
    let Some((key, criterion)) = tables.iter().find(|(key, _)| key.get_ref() == "criterion") else { return };
    let DeValue::Table(criterion) = criterion.get_ref() else { return };
    let Some((_, value)) = criterion.iter().find(|(key, _)| key.get_ref() == "kind") else { return };
    let DeValue::String(name) = value.get_ref() else { return };
    let has_it = |kind: &&Kind| kind.criteria.contains(&&**name);
    let Some(other) = KINDS.iter().find(has_it).filter(|_| !has_it(&kind)) else { return };
    let own: Vec<String> = kind.criteria.iter().map(|name| format!("\"{name}\"")).collect();
    let message = format!(
        "criterion.kind = \"{name}\" decides models of kind \"{0}\", and this one is of kind \"{1}\"; write kind = \"{0}\" in [model], or a criterion of this kind: {2}",
        other.name,
        kind.name,
        own.join(", ")
    );
    complaints.push(Complaint::at(value.span(), message));
    let key = key.clone();
    tables.remove(&key);
    complaints.note_unread(vec!["criterion".to_owned()]);
}

/// What may have been meant by a key outside the tables of the model, as the end of a message.
pub fn suggested(wrong: &str, table: &str) -> Option<String> {
    pad_on_disc::keys::suggested(wrong, table)
}

/// Takes the kind out of the tables.
fn kind_of(tables: &mut DeTable<'_>) -> Option<(String, Range<usize>)> {
    let model = tables.iter_mut().find(|(key, _)| key.get_ref() == "model").map(|(_, value)| value.get_mut())?;
    let DeValue::Table(model) = model else { return None };
    let key = model.keys().find(|key| key.get_ref() == "kind").cloned()?;
    let value = model.remove(&key)?;
    match value.get_ref() {
        DeValue::String(name) => Some((name.to_string(), value.span())),
        _ => Some((String::new(), value.span())),
    }
}

fn unknown_kind(name: &str, span: Range<usize>) -> Complaint {
    let names: Vec<String> = KINDS.iter().map(|kind| format!("\"{}\"", kind.name)).collect();
    let near = nearest(name, KINDS.iter().map(|kind| kind.name));
    let near = near.map_or(String::new(), |near| format!("; did you mean \"{near}\"?"));
    let message = format!("model.kind: there is no kind of model \"{name}\"{near} (there are {})", names.join(", "));
    Complaint::at(span, message)
}

/// The JSON schema of job specs, of any kind of model.
pub fn schema() -> Schema {
    let mut generator = SchemaGenerator::default();
    let [model, criterion] =
        [0, 1].map(|table| -> Vec<Schema> { KINDS.iter().map(|kind| kind.schemas[table](&mut generator)).collect() });
    let axes = axes(&generator.subschema_for::<AxisSpec>());
    let mut schema = generator.into_root_schema_for::<JobSpec>();
    let root = schema.ensure_object();
    for (i, kind) in KINDS.iter().enumerate() {
        let reference = model[i].get("$ref").and_then(Value::as_str);
        let Some(name) = reference.and_then(|path| path.strip_prefix("#/$defs/")) else { continue };
        // It is taken out before a model reads its table.
        let table = &mut root["$defs"][name];
        let description = format!("The kind of model: `\"{}\"`.", kind.name);
        table["properties"]["kind"] = json!({ "const": kind.name, "description": description });
        if i == 0 {
            table["properties"]["kind"]["default"] = kind.name.into();
        } else {
            table["required"] = json!(["kind"]);
        }
    }
    root["properties"]["model"]["anyOf"] = json!(model);
    root["properties"]["criterion"]["anyOf"] = json!(criterion);
    root["$defs"]["AxesSpec"]["properties"] = axes.into();
    schema
}

/// The axes of all kinds, each with the schema of an axis.
fn axes(axis: &Schema) -> Map<String, Value> {
    let mut properties = Map::new();
    for (key, description) in KINDS.iter().flat_map(|kind| (kind.axes)()) {
        let mut schema = axis.clone();
        schema.insert("description".to_owned(), description.clone().into());
        // One kind may have an axis with the name of another's section.
        let section = properties.get(&key).filter(|known| known["type"] == "object");
        let either = section.map(|section| json!({ "description": description, "anyOf": [section, schema] }));
        properties.insert(key.clone(), either.unwrap_or_else(|| schema.clone().into()));
        // The same within the table of its section.
        if let Some((section, name)) = key.split_once('.') {
            let section = properties
                .entry(section)
                .or_insert_with(|| json!({ "type": "object", "properties": {}, "additionalProperties": false }));
            section["properties"][name] = schema.into();
        }
    }
    properties
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is said of the tables of a model.
    fn said(text: &str) -> Vec<String> {
        let mut complaints = Complaints::default();
        let (document, errors) = DeTable::parse_recoverable(text);
        assert!(errors.is_empty(), "{text}");
        drop(draft(text, &document, &mut complaints));
        complaints
            .render("job.toml".as_ref(), text)
            .lines()
            .filter(|line| line.contains("job.toml"))
            .map(str::to_owned)
            .collect()
    }

    #[test]
    fn every_kind_reads_the_criteria_that_it_lists_and_no_others() {
        let all: Vec<&str> = KINDS.iter().flat_map(|kind| kind.criteria).copied().collect();
        for kind in KINDS.iter().filter(|kind| !kind.criteria.is_empty()) {
            for name in &all {
                let text = format!("[model]\nkind = \"{}\"\n[criterion]\nkind = \"{name}\"\n", kind.name);
                let said = said(&text);
                assert_eq!(said.is_empty(), kind.criteria.contains(name), "{text}{said:?}");
            }
        }
    }

    #[test]
    fn a_kind_that_is_left_out_is_found_by_the_keys_of_the_model() {
        let of_matrices = "[model]\nmass = { file = \"M.mtx\" }\nstiffness = [{ file = \"K.mtx\" }, { file = \"F.mtx\", factor = \"mu\" }]\n\
            parameters = { mu = 0.4 }\n[criterion]\nkind = \"complex-eigenvalue\"\nfrequency = [1000, 3000]\n";
        let of_belt = "[model]\nmass = 1.0\nstiffness = 1.0\nbelt_speed = 1.3\n[criterion]\nkind = \"eigenvalue\"\n";
        for (text, kind) in [(of_matrices, "matrices"), (of_belt, "belt-oscillator")] {
            let said = said(text);
            assert!(said.len() == 1 && said[0].starts_with("job.toml:1:2: missing key `kind` in [model]"), "{said:?}");
            assert!(said[0].ends_with(&format!("write kind = \"{kind}\"")), "{said:?}");
        }
        // One wrong key is a slip.
        let said = said("[model]\nmass = 0.1\n");
        assert!(said.len() == 1 && said[0].contains("unknown key `mass`"), "{said:?}");
    }
}
