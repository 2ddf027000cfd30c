//! Distributions as a job spec writes them.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::LazyLock;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::{Map, Value, json};
use stickslip_sampler::inputs::Marginal;

use super::keys::{nearest, schema_of};

/// Distributions that are written as a name.
const NAMED: [(&str, Marginal); 6] = [
    ("normal", Marginal::Normal),
    ("lognormal", Marginal::Lognormal),
    ("uniform", Marginal::Uniform),
    ("weibull", Marginal::Weibull),
    ("gumbel", Marginal::Gumbel),
    ("triangular", Marginal::Triangular { mode: 0.5 }),
];

/// The schema of each key of a distribution that is written as a table. None is the name of an input.
static KEYS: LazyLock<Map<String, Value>> =
    LazyLock::new(|| schema_of::<MarginalTable>()["properties"].as_object().cloned().unwrap_or_default());

/// What a distribution may be, for messages.
const CHOICE: &str = "a distribution is \"normal\", \"lognormal\", \"uniform\", \"weibull\", \"gumbel\", \"triangular\", \
    { triangular = PEAK } (from 0 to 1), { truncated-normal = [LOW, HIGH] } (in standard deviations from the expected \
    value), { beta = [LOW, HIGH] } (in multiples of the expected value) or { csv = \"FILE\", column = \"NAME\" }, or a table of \
    these by input";

/// One distribution for every random input, or a table by input.
#[derive(Debug, Clone, Serialize)]
#[serde(untagged)]
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
#[derive(Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct MarginalTable {
    /// Ends, in standard deviations from the expected value
    #[schemars(with = "[f64; 2]")]
    truncated_normal: Option<(f64, f64)>,
    /// Place of the peak between the lower end (0) and the upper end (1)
    #[schemars(with = "f64", range(min = 0, max = 1))]
    triangular: Option<f64>,
    /// Ends, in multiples of the expected value
    #[schemars(with = "[f64; 2]")]
    beta: Option<(f64, f64)>,
    /// File of measured values, relative to the job's
    #[schemars(with = "String")]
    csv: Option<String>,
    /// Name of their column
    #[schemars(with = "String")]
    column: Option<String>,
    /// Measured values
    #[schemars(with = "Vec<f64>", length(min = 2))]
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
        let mut named = NAMED.into_iter();
        let marginal = named.find(|(known, _)| *known == name).map(|(_, marginal)| marginal);
        marginal.map(Self::Given).ok_or_else(|| unknown(name, NAMED.iter().map(|(name, _)| *name)))
    }

    fn from_table(table: &toml::Table) -> Result<Self, String> {
        if let Some(key) = table.keys().find(|key| !KEYS.contains_key(*key)) {
            return Err(unknown(key, KEYS.keys().map(String::as_str)));
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

fn unknown<'a>(name: &str, names: impl Iterator<Item = &'a str>) -> String {
    match nearest(name, names) {
        Some(right) => format!("there is no distribution \"{name}\"; did you mean \"{right}\"?"),
        None => format!("there is no distribution \"{name}\"; {CHOICE}"),
    }
}

impl Serialize for MarginalSpec {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut table = MarginalTable::default();
        match self {
            Self::Given(Marginal::TruncatedNormal { low, high }) => table.truncated_normal = Some((*low, *high)),
            Self::Given(Marginal::Triangular { mode }) => table.triangular = Some(*mode),
            Self::Given(Marginal::Beta { low, high }) => table.beta = Some((*low, *high)),
            Self::Given(Marginal::Empirical(measured)) => table.values = Some(measured.values().to_vec()),
            Self::Given(marginal) => {
                let name = NAMED.iter().find(|(_, named)| named == marginal).map(|(name, _)| *name);
                return name.serialize(serializer);
            }
            Self::Values(values) => table.values = Some(values.clone()),
            Self::Csv { file, column } => (table.csv, table.column) = (Some(file.clone()), Some(column.clone())),
        }
        table.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for DistributionSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let value = toml::Value::deserialize(deserializer)?;
        let spec = match &value {
            toml::Value::Table(table) if !table.keys().any(|key| KEYS.contains_key(key)) => {
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
        let table = |keys: &[&str]| {
            let properties: Map<String, Value> =
                keys.iter().map(|key| ((*key).to_owned(), KEYS.get(*key).cloned().unwrap_or_default())).collect();
            json!({ "type": "object", "properties": properties, "required": keys, "additionalProperties": false })
        };
        const OF_A_FILE: [&str; 2] = ["csv", "column"];
        let alone = KEYS.keys().map(String::as_str).filter(|key| !OF_A_FILE.contains(key));
        let mut choices = vec![json!({ "enum": NAMED.map(|(name, _)| name) }), table(&OF_A_FILE)];
        choices.extend(alone.map(|key| table(&[key])));
        let of_input = json!({ "anyOf": choices });
        let keys: Vec<&str> = KEYS.keys().map(String::as_str).collect();
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
