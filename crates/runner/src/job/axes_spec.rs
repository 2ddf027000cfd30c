//! The axes of a job spec as written.

use std::borrow::Cow;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::MapAccessDeserializer;
use serde::de::{MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use toml::Spanned;

/// The axes of the grid, by name.
#[derive(Debug, Default)]
pub struct AxesSpec(pub Vec<AxisEntry>);

/// An axis under its name.
#[derive(Debug)]
pub struct AxisEntry {
    /// Its name: that of a quantity of the model, or what the kind of model takes for one.
    pub name: Spanned<String>,
    /// Its values.
    pub axis: Spanned<AxisSpec>,
}

impl<'de> Deserialize<'de> for AxesSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct AxesVisitor;

        impl<'de> Visitor<'de> for AxesVisitor {
            type Value = AxesSpec;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a map")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<AxesSpec, A::Error> {
                let mut entries = Vec::new();
                while let Some((name, axis)) = map.next_entry()? {
                    entries.push(AxisEntry { name, axis });
                }
                Ok(AxesSpec(entries))
            }
        }

        deserializer.deserialize_map(AxesVisitor)
    }
}

impl Serialize for AxesSpec {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|entry| (&entry.name, &entry.axis)))
    }
}

impl JsonSchema for AxesSpec {
    fn schema_name() -> Cow<'static, str> {
        "AxesSpec".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        // Their names depend on the model, and are put in with its own schema.
        generator.subschema_for::<AxisSpec>();
        json_schema!({
            "description": "The axes of the grid.",
            "type": "object",
            "additionalProperties": false
        })
    }
}

/// One axis: a number, a list of numbers, or `{ from, to, points, scale }`.
#[derive(Debug, Clone, Serialize)]
#[serde(untagged)]
pub enum AxisSpec {
    /// Explicit values.
    Values(Vec<f64>),
    /// Values between two ends.
    Range(RangeSpec),
}

/// Values between two ends, both included.
#[derive(Debug, Clone, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RangeSpec {
    /// The first value.
    pub from: f64,
    /// The last value.
    pub to: f64,
    /// Number of values: at least 2, or 1 if the ends are equal.
    #[schemars(range(min = 1))]
    pub points: u32,
    /// How the values are spaced.
    #[serde(default)]
    pub scale: ScaleSpec,
}

/// How the values of an axis are spaced.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ScaleSpec {
    /// Evenly.
    #[default]
    Linear,
    /// Each value is the same multiple of the one before, rounded to 14 digits; both ends must be positive.
    Log,
}

impl<'de> Deserialize<'de> for AxisSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct AxisVisitor;

        impl<'de> Visitor<'de> for AxisVisitor {
            type Value = AxisSpec;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number, a list of numbers, or { from = ..., to = ..., points = ... }")
            }

            fn visit_f64<E>(self, value: f64) -> Result<AxisSpec, E> {
                Ok(AxisSpec::Values(vec![value]))
            }

            fn visit_i64<E>(self, value: i64) -> Result<AxisSpec, E> {
                Ok(AxisSpec::Values(vec![value as f64]))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<AxisSpec, A::Error> {
                let mut values = Vec::new();
                while let Some(value) = list.next_element()? {
                    values.push(value);
                }
                Ok(AxisSpec::Values(values))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<AxisSpec, A::Error> {
                RangeSpec::deserialize(MapAccessDeserializer::new(map)).map(AxisSpec::Range)
            }
        }

        deserializer.deserialize_any(AxisVisitor)
    }
}

impl JsonSchema for AxisSpec {
    fn schema_name() -> Cow<'static, str> {
        "Axis".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let range = generator.subschema_for::<RangeSpec>();
        json_schema!({
            "description": "A number, a list of numbers, or values between two ends.",
            "anyOf": [
                { "type": "number" },
                { "type": "array", "items": { "type": "number" }, "minItems": 1, "uniqueItems": true },
                range,
            ]
        })
    }
}
