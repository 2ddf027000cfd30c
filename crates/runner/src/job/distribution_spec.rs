//! Distributions as a job spec writes them.

use std::borrow::Cow;
use std::collections::BTreeMap;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer};
use serde_json::json;
use stickslip_sampler::inputs::Marginal;

use super::imprecise_schema::one_of;
use super::keys::nearest;

/// Distributions that are written as a name.
const NAMES: [&str; 6] = ["normal", "lognormal", "uniform", "weibull", "gumbel", "triangular"];

/// Keys of distributions that are written as a table. None is the name of an input.
const KEYS: [&str; 6] = ["truncated-normal", "triangular", "beta", "csv", "column", "values"];

/// What a distribution may be, for messages.
const CHOICE: &str = "a distribution is \"normal\", \"lognormal\", \"uniform\", \"weibull\", \"gumbel\", \"triangular\", \
    { triangular = PEAK } (from 0 to 1), { truncated-normal = [LOW, HIGH] } (in standard deviations from the expected \
    value), { beta = [LOW, HIGH] } (in multiples of the expected value) or { csv = \"FILE\", column = \"NAME\" }, or a table of \
    these by input";

/// One distribution for every random input, or a table by input.
#[derive(Debug, Clone)]
pub enum DistributionSpec {
    /// The same for every random input.
    Common(MarginalSpec),
    /// By input; those left out are normal.
    Each(BTreeMap<String, MarginalSpec>),
}

/// A distribution.
#[derive(Debug, Clone)]
pub enum MarginalSpec {
    /// One that needs nothing else.
    Given(Marginal),
    /// Measured values, in the job itself.
    Values(Vec<f64>),
    /// Measured values, in a file.
    Csv {
        /// Path, relative to the job's.
        file: String,
        /// Name in its first line.
        column: String,
    },
}

/// A distribution that is written as a table.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct MarginalTable {
    truncated_normal: Option<(f64, f64)>,
    triangular: Option<f64>,
    beta: Option<(f64, f64)>,
    csv: Option<String>,
    column: Option<String>,
    values: Option<Vec<f64>>,
}

impl MarginalSpec {
    fn from_toml(value: &toml::Value) -> Result<Self, String> {
        match value {
            toml::Value::String(name) => Self::from_name(name),
            toml::Value::Table(table) => Self::from_table(table),
            other => Err(format!("{other} is no distribution; {CHOICE}")),
        }
    }

    fn from_name(name: &str) -> Result<Self, String> {
        Ok(Self::Given(match name {
            "normal" => Marginal::Normal,
            "lognormal" => Marginal::Lognormal,
            "uniform" => Marginal::Uniform,
            "weibull" => Marginal::Weibull,
            "gumbel" => Marginal::Gumbel,
            "triangular" => Marginal::Triangular { mode: 0.5 },
            _ => return Err(unknown(name, NAMES)),
        }))
    }

    fn from_table(table: &toml::Table) -> Result<Self, String> {
        if let Some(key) = table.keys().find(|key| !KEYS.contains(&key.as_str())) {
            return Err(unknown(key, KEYS));
        }
        let refused = || {
            let pairs: Vec<String> = table.iter().map(|(key, value)| format!("{key} = {value}")).collect();
            let text = pairs.join(", ");
            let text = if text.len() > 100 { table.keys().cloned().collect::<Vec<_>>().join(", ") } else { text };
            format!("{{ {text} }} is no distribution; {CHOICE}")
        };
        match MarginalTable::deserialize(table.clone()).map_err(|_| refused())? {
            MarginalTable { csv: Some(file), column: Some(column), .. } if table.len() == 2 => {
                Ok(Self::Csv { file, column })
            }
            MarginalTable { csv: Some(file), column: None, .. } if table.len() == 1 => Err(format!(
                "which column of {file} has the measured values? For example {{ csv = \"{file}\", column = \"mu\" }}"
            )),
            MarginalTable { truncated_normal: Some((low, high)), .. } if table.len() == 1 => {
                Ok(Self::Given(Marginal::TruncatedNormal { low, high }))
            }
            MarginalTable { triangular: Some(mode), .. } if table.len() == 1 => {
                Ok(Self::Given(Marginal::Triangular { mode }))
            }
            MarginalTable { beta: Some((low, high)), .. } if table.len() == 1 => {
                Ok(Self::Given(Marginal::Beta { low, high }))
            }
            MarginalTable { values: Some(values), .. } if table.len() == 1 => Ok(Self::Values(values)),
            _ => Err(refused()),
        }
    }
}

fn unknown<const N: usize>(name: &str, names: [&str; N]) -> String {
    match nearest(name, names) {
        Some(right) => format!("there is no distribution \"{name}\"; did you mean \"{right}\"?"),
        None => format!("there is no distribution \"{name}\"; {CHOICE}"),
    }
}

impl<'de> Deserialize<'de> for DistributionSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let value = toml::Value::deserialize(deserializer)?;
        let spec = match &value {
            toml::Value::Table(table) if !table.keys().any(|key| KEYS.contains(&key.as_str())) => {
                let each = table.iter().map(|(input, value)| match MarginalSpec::from_toml(value) {
                    Ok(marginal) => Ok((input.clone(), marginal)),
                    Err(message) => Err(format!("random.distribution of {input}: {message}")),
                });
                each.collect::<Result<_, _>>().map(Self::Each)
            }
            common => MarginalSpec::from_toml(common)
                .map(Self::Common)
                .map_err(|message| format!("random.distribution: {message}")),
        };
        spec.map_err(D::Error::custom)
    }
}

impl JsonSchema for DistributionSpec {
    fn schema_name() -> Cow<'static, str> {
        "Distribution".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let table = |properties: serde_json::Value| {
            let keys: Vec<_> = properties.as_object().into_iter().flat_map(|keys| keys.keys().cloned()).collect();
            json!({ "type": "object", "properties": properties, "required": keys, "additionalProperties": false })
        };
        let ends = |description: &str| {
            let number = json!({ "type": "number" });
            json!({ "type": "array", "items": number, "minItems": 2, "maxItems": 2, "description": description })
        };
        let marginal = [
            json!({ "enum": NAMES }),
            table(json!({ "truncated-normal": ends("Ends, in standard deviations from the expected value") })),
            table(json!({ "beta": ends("Ends, in multiples of the expected value") })),
            table(json!({ "triangular": { "type": "number", "minimum": 0, "maximum": 1,
                "description": "Place of the peak between the lower end (0) and the upper end (1)" } })),
            table(
                json!({ "csv": { "type": "string", "description": "File of measured values, relative to the job's" },
                "column": { "type": "string", "description": "Name of their column" } }),
            ),
            table(json!({ "values": { "type": "array", "items": { "type": "number" }, "minItems": 2,
                "description": "Measured values" } })),
        ];
        let alternatives = one_of(&json!({ "anyOf": marginal }));
        let mut choices = marginal.to_vec();
        choices.push(alternatives.clone());
        let of_input = json!({ "anyOf": choices });
        let mut keys = vec!["one_of"];
        keys.extend(KEYS);
        choices.push(json!({
            "type": "object",
            "additionalProperties": of_input,
            "propertyNames": { "not": { "enum": keys } },
        }));
        json_schema!({
            "description": "One distribution for every random input, or a table by input; those left out are normal.",
            "anyOf": choices,
        })
    }
}
