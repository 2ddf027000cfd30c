//! The identity of a job: a hash of every value that its result depends on.
//!
//! It is taken from the normalised job (see [`normalised`](super::normalised)), whatever keys that has, so that no key can
//! be forgotten. The name and the description do not belong to it, nor do keys that the job's method or criterion has no
//! use for. Each value enters the hash with its type, its length where it has one, and its bits: the hash depends on no
//! printer of numbers and on no order of a file.

use std::collections::BTreeMap;
use std::fmt::Debug;

use serde::Serialize;
use serde_json::{Value, json};
use stickslip_core::model::quantity::Role;
use stickslip_sampler::draw::identity::RESULTS_VERSION;
use stickslip_sampler::grid::{Axis, Grid, GridAxis};

use super::model::Tables;
use super::spec::JobSpec;
use super::validated::Job;
use crate::version::FORMAT_VERSION;

impl Job {
    /// Identifies the job: everything that its result depends on.
    pub fn hash(&self) -> String {
        hashed("job", &self.experiment())
    }

    /// Identifies the job but for the number of samples, and of plain ones beside a probability: runs that agree in it
    /// share their samples.
    pub fn experiment_hash(&self) -> String {
        let mut experiment = self.without_samples();
        if self.sampling.method.has_plain_samples() {
            experiment.sampling.audit = None;
        }
        hashed("job", &experiment)
    }

    /// The same with the number of plain samples where it is not the usual one: runs that agree in it can be extended by one
    /// another.
    pub fn extension_hash(&self) -> String {
        hashed("job", &self.without_samples())
    }

    fn without_samples(&self) -> JobSpec {
        let mut experiment = self.experiment();
        experiment.sampling.samples = None;
        if let Some(until) = &mut experiment.sampling.until {
            until.get_mut().at_most = Some(0);
        }
        experiment
    }

    /// What the job computes, whatever it is called.
    fn experiment(&self) -> JobSpec {
        JobSpec { name: None, description: None, ..self.written_out() }
    }

    /// Identifies what decides a sample of one configuration of the grid: jobs that agree in it can share verdict maps.
    pub fn map_key(&self, configuration: usize) -> String {
        let cell = self.grid.first_cell_with(configuration);
        let places = (0..cell.expected.len()).filter(|&place| self.quantity(place).role != Role::Start);
        let axis = |quantity: usize| {
            let axis = Axis::from_values(vec![cell.expected[quantity]]).ok()?;
            Some(GridAxis { quantity, axis })
        };
        // The grid that has this configuration alone, written out as any other.
        let grid = Grid { axes: places.filter_map(axis).collect(), ..self.grid.clone() };
        let Tables { model, criterion } = self.model.tables(&grid);
        let name = |axis: &GridAxis| self.quantity(axis.quantity).name.to_string();
        let own = grid.axes.iter().filter(|axis| grid.of_configuration[axis.quantity]);
        let values: BTreeMap<String, &[f64]> = own.map(|axis| (name(axis), axis.axis.values())).collect();
        hashed("verdict map", &json!({ "model": model, "criterion": criterion, "values": values }))
    }
}

/// The hash of a value and of the versions behind results and verdicts.
fn hashed(what: &str, value: &(impl Serialize + Debug)) -> String {
    let mut hasher = blake3::Hasher::new();
    let versions = [FORMAT_VERSION, RESULTS_VERSION];
    // Text keys, finite numbers, lists and tables: there is nothing in it that JSON cannot hold. If there were, the
    // value as programmers print it would still tell one from another.
    let value = serde_json::to_value(value).unwrap_or_else(|_| Value::from(format!("{value:?}")));
    add(&mut hasher, &json!([what, versions, value]));
    hasher.finalize().to_hex().to_string()
}

/// Adds a value to a hash: its type, its length, its bits.
fn add(hasher: &mut blake3::Hasher, value: &Value) {
    let mut head = |kind: u8, length: usize| {
        hasher.update(&[kind]);
        hasher.update(&(length as u64).to_le_bytes());
    };
    match value {
        Value::Null => head(b'n', 0),
        Value::Bool(flag) => head(b'b', usize::from(*flag)),
        Value::String(text) => {
            head(b's', text.len());
            hasher.update(text.as_bytes());
        }
        Value::Number(number) => match (number.as_u64(), number.as_f64()) {
            (Some(whole), _) => {
                head(b'w', 8);
                hasher.update(&whole.to_le_bytes());
            }
            // Zero has one sign.
            (None, real) => {
                head(b'r', 8);
                hasher.update(&(real.unwrap_or(f64::NAN) + 0.0).to_bits().to_le_bytes());
            }
        },
        Value::Array(list) => {
            head(b'l', list.len());
            list.iter().for_each(|value| add(hasher, value));
        }
        // A key without a value is none.
        Value::Object(table) => {
            let mut entries: Vec<_> = table.iter().filter(|(_, value)| !value.is_null()).collect();
            entries.sort_by_key(|(key, _)| *key);
            head(b't', entries.len());
            for (key, value) in entries {
                add(hasher, &Value::from(key.as_str()));
                add(hasher, value);
            }
        }
    }
}

#[cfg(test)]
mod tests;
