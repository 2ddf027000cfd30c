//! The random inputs of a job spec as written.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::MapAccessDeserializer;
use serde::de::{MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use toml::Spanned;

use super::distribution_spec::DistributionSpec;

/// Relative standard deviation at most, for the widest distributions.
pub const LARGEST_STD: f64 = 10.0;

/// The random inputs.
#[derive(Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RandomSpec {
    /// The inputs that scatter: `"preload"`, `"static_friction"`, `"rotating_speed"`, keys of the model such as
    /// `"stiffness.contact_normal"`, and numbers of the start such as `"start.velocity"`. With an empty list one sample
    /// decides a cell.
    #[schemars(with = "Option<Vec<String>>")]
    pub inputs: Option<Spanned<Vec<Spanned<String>>>>,
    /// Standard deviation over expected value, up to what the distribution allows. A list makes an axis of the grid.
    /// Required of inputs that are not in `std`, unless they have measured values.
    #[schemars(with = "Option<RelativeStdSpec>")]
    pub relative_std: Option<Spanned<RelativeStdSpec>>,
    /// Standard deviations in the units of the inputs: `{ static_friction = 0.03 }`. Required of numbers of the start
    /// and `friction.band`, which may be 0 on average.
    #[schemars(with = "Option<BTreeMap<String, f64>>")]
    pub std: Option<Spanned<BTreeMap<Spanned<String>, Spanned<f64>>>>,
    /// The distribution of every input, or of each by name; those left out are normal.
    #[schemars(with = "Option<DistributionSpec>", extend("default" = "normal"))]
    pub distribution: Option<Spanned<DistributionSpec>>,
    /// Correlated pairs, `[["preload", "static_friction", 0.3]]`: coefficients between -1 and 1 of the normal deviates
    /// behind the inputs.
    #[serde(default)]
    #[schemars(schema_with = "pairs_schema")]
    pub correlation: Option<Spanned<Vec<PairSpec>>>,
}

/// The JSON schema of correlated pairs.
fn pairs_schema(_: &mut SchemaGenerator) -> Schema {
    let coefficient = serde_json::json!({ "type": "number" });
    let input = serde_json::json!({ "type": "string" });
    let pair = serde_json::json!({ "type": "array", "prefixItems": [input, input, coefficient], "minItems": 3, "maxItems": 3 });
    json_schema!({ "type": ["array", "null"], "items": pair })
}

/// Two inputs and their coefficient of correlation.
pub type PairSpec = Spanned<(String, String, f64)>;

/// One relative standard deviation for every random input, or one for each.
#[derive(Debug, Clone, Serialize)]
#[serde(untagged)]
pub enum StdSpec {
    /// The same for every random input.
    Common(f64),
    /// By input.
    Each(BTreeMap<String, f64>),
}

/// A number, a table by input, or a list of these.
#[derive(Debug, Clone, Serialize)]
pub struct RelativeStdSpec(pub Vec<StdSpec>);

struct StdVisitor;

impl<'de> Visitor<'de> for StdVisitor {
    type Value = StdSpec;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number or a table by input, { INPUT = ..., INPUT = ... }")
    }

    fn visit_f64<E>(self, value: f64) -> Result<StdSpec, E> {
        Ok(StdSpec::Common(value))
    }

    fn visit_i64<E>(self, value: i64) -> Result<StdSpec, E> {
        Ok(StdSpec::Common(value as f64))
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<StdSpec, A::Error> {
        BTreeMap::deserialize(MapAccessDeserializer::new(map)).map(StdSpec::Each)
    }
}

impl<'de> Deserialize<'de> for StdSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(StdVisitor)
    }
}

impl<'de> Deserialize<'de> for RelativeStdSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct ListVisitor;

        impl<'de> Visitor<'de> for ListVisitor {
            type Value = RelativeStdSpec;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number, a list of numbers, or { INPUT = ..., INPUT = ... }")
            }

            fn visit_f64<E: serde::de::Error>(self, value: f64) -> Result<RelativeStdSpec, E> {
                StdVisitor.visit_f64(value).map(|std| RelativeStdSpec(vec![std]))
            }

            fn visit_i64<E: serde::de::Error>(self, value: i64) -> Result<RelativeStdSpec, E> {
                StdVisitor.visit_i64(value).map(|std| RelativeStdSpec(vec![std]))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<RelativeStdSpec, A::Error> {
                let mut values = Vec::new();
                while let Some(value) = list.next_element()? {
                    values.push(value);
                }
                Ok(RelativeStdSpec(values))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<RelativeStdSpec, A::Error> {
                StdVisitor.visit_map(map).map(|std| RelativeStdSpec(vec![std]))
            }
        }

        deserializer.deserialize_any(ListVisitor)
    }
}

impl JsonSchema for RelativeStdSpec {
    fn schema_name() -> Cow<'static, str> {
        "RelativeStd".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let number = serde_json::json!({ "type": "number", "minimum": 0, "maximum": LARGEST_STD });
        let table = serde_json::json!({ "type": "object", "additionalProperties": number });
        json_schema!({
            "description": "A number, a table by input, or a list of these.",
            "anyOf": [
                number,
                table,
                { "type": "array", "items": { "anyOf": [number, table] }, "minItems": 1 },
            ]
        })
    }
}
