//! The table `[limit]` of a job spec as written.

use std::borrow::Cow;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use toml::Spanned;

/// Where along an axis the probability of instability passes targets; written as limits.parquet. The surface does not
/// depend on it.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LimitSpec {
    /// The axis along which limits are sought, between its ends: not of standard deviations or of the start.
    #[schemars(with = "String")]
    pub of: Option<Spanned<String>>,
    /// Probabilities of instability that must not be exceeded, at most 100.
    #[schemars(with = "TargetsSpec")]
    pub probability: Option<Spanned<TargetsSpec>>,
}

/// One probability or several.
#[derive(Debug)]
pub struct TargetsSpec(pub Vec<f64>);

impl<'de> Deserialize<'de> for TargetsSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct TargetsVisitor;

        impl<'de> Visitor<'de> for TargetsVisitor {
            type Value = TargetsSpec;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a probability or a list of probabilities, for example [0.01, 1e-5]")
            }

            fn visit_f64<E>(self, value: f64) -> Result<TargetsSpec, E> {
                Ok(TargetsSpec(vec![value]))
            }

            fn visit_i64<E>(self, value: i64) -> Result<TargetsSpec, E> {
                Ok(TargetsSpec(vec![value as f64]))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<TargetsSpec, A::Error> {
                let mut values = Vec::new();
                while let Some(value) = list.next_element()? {
                    values.push(value);
                }
                Ok(TargetsSpec(values))
            }
        }

        deserializer.deserialize_any(TargetsVisitor)
    }
}

impl JsonSchema for TargetsSpec {
    fn schema_name() -> Cow<'static, str> {
        "Targets".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let number = serde_json::json!({ "type": "number", "exclusiveMinimum": 0, "exclusiveMaximum": 1 });
        json_schema!({
            "description": "A probability, or a list of these.",
            "anyOf": [number, { "type": "array", "items": number, "minItems": 1 }]
        })
    }
}
