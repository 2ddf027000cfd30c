//! The job spec as TOML: one struct for each table, the source of parsing, of the JSON schema and of its texts.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::MapAccessDeserializer;
use serde::de::{MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use toml::Spanned;

use super::criterion_spec::CriterionSpec;
use super::random_spec::RandomSpec;
use super::sampling_spec::SamplingSpec;

/// A stickslip job: the probability of instability of a brake over a grid of operating points.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JobSpec {
    /// Name of the run; its results go to runs/NAME. Letters, digits, '-', '_' and '.'.
    #[schemars(with = "String")]
    pub name: Option<Spanned<String>>,
    /// What the job is for, in a sentence.
    #[serde(default)]
    pub description: String,
    /// The brake.
    #[serde(default)]
    pub model: ModelSpec,
    /// The grid; the job is the product of the axes. An axis that is left out has the preset's one value.
    #[serde(default)]
    pub axes: AxesSpec,
    /// Which inputs scatter, and how much.
    #[serde(default)]
    pub random: RandomSpec,
    /// What decides whether a sample is stable.
    #[schemars(with = "CriterionSpec")]
    pub criterion: Option<Spanned<CriterionSpec>>,
    /// How many samples are drawn, and how.
    #[serde(default)]
    pub sampling: SamplingSpec,
}

/// Preset and overrides.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ModelSpec {
    /// The parameter set to start from; "sui-ding-2018" is the only one, and the default.
    #[schemars(with = "Option<String>")]
    pub preset: Option<Spanned<String>>,
    /// Overrides of the disc's values.
    #[serde(default)]
    #[schemars(schema_with = "section_schema::<0>")]
    pub disc: Overrides,
    /// Overrides of the pad's values.
    #[serde(default)]
    #[schemars(schema_with = "section_schema::<1>")]
    pub pad: Overrides,
    /// Overrides of the springs.
    #[serde(default)]
    #[schemars(schema_with = "section_schema::<2>")]
    pub stiffness: Overrides,
    /// Overrides of the dampers.
    #[serde(default)]
    #[schemars(schema_with = "section_schema::<3>")]
    pub damping: Overrides,
    /// Overrides of the friction law.
    #[serde(default)]
    #[schemars(schema_with = "section_schema::<4>")]
    pub friction: Overrides,
    /// Overrides of the operating point, used for axes that are left out.
    #[serde(default)]
    #[schemars(schema_with = "section_schema::<5>")]
    pub operating_point: Overrides,
}

/// Values of one section of the parameters, by name.
pub type Overrides = BTreeMap<Spanned<String>, Spanned<f64>>;

/// The sections of the model, in the order of [`ModelSpec`].
pub const SECTIONS: [&str; 6] = ["disc", "pad", "stiffness", "damping", "friction", "operating_point"];

impl ModelSpec {
    /// Every section with its overrides.
    pub fn sections(&self) -> [(&'static str, &Overrides); 6] {
        let [disc, pad, stiffness, damping, friction, operating_point] = SECTIONS;
        [
            (disc, &self.disc),
            (pad, &self.pad),
            (stiffness, &self.stiffness),
            (damping, &self.damping),
            (friction, &self.friction),
            (operating_point, &self.operating_point),
        ]
    }
}

/// The JSON schema of one section, from the parameter list of the core.
fn section_schema<const SECTION: usize>(_: &mut SchemaGenerator) -> Schema {
    let mut properties = serde_json::Map::new();
    for scalar in stickslip_core::parameters::SCALARS.iter().filter(|scalar| scalar.section() == SECTIONS[SECTION]) {
        let limits = scalar.limits;
        let lower = if limits.includes_minimum { "minimum" } else { "exclusiveMinimum" };
        let upper = if limits.includes_maximum { "maximum" } else { "exclusiveMaximum" };
        let description = format!("{} ({}), unit {}", scalar.description, scalar.symbol, scalar.unit);
        properties.insert(
            scalar.name().to_owned(),
            serde_json::json!({ "type": "number", lower: limits.minimum, upper: limits.maximum, "description": description }),
        );
    }
    json_schema!({ "type": "object", "properties": properties, "additionalProperties": false })
}

/// The axes of the grid.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AxesSpec {
    /// Rotating speed of the disc, rad/s.
    #[schemars(with = "Option<AxisSpec>")]
    pub rotating_speed: Option<Spanned<AxisSpec>>,
    /// Expected preload: displacement of the calliper over the thickness of the disc.
    #[schemars(with = "Option<AxisSpec>")]
    pub preload: Option<Spanned<AxisSpec>>,
    /// Expected static friction coefficient.
    #[schemars(with = "Option<AxisSpec>")]
    pub static_friction: Option<Spanned<AxisSpec>>,
}

/// One axis: a number, a list of numbers, or `{ from, to, points }`.
#[derive(Debug, Clone)]
pub enum AxisSpec {
    /// Explicit values.
    Values(Vec<f64>),
    /// Evenly spaced values.
    Range(RangeSpec),
}

/// Evenly spaced values, both ends included.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RangeSpec {
    /// First value.
    pub from: f64,
    /// Last value.
    pub to: f64,
    /// Number of values, at least 2.
    #[schemars(range(min = 1))]
    pub points: u32,
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
            "description": "A number, a list of numbers, or evenly spaced values.",
            "anyOf": [
                { "type": "number" },
                { "type": "array", "items": { "type": "number" }, "minItems": 1, "uniqueItems": true },
                range,
            ]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::keys::TABLES;

    #[test]
    fn the_tables_are_those_of_the_schema() {
        let schema = schemars::schema_for!(JobSpec);
        let definitions = &schema.as_value()["$defs"];
        for (table, keys) in TABLES {
            let name = format!("{}{}Spec", table[..1].to_uppercase(), &table[1..]);
            let properties = definitions[&name]["properties"].as_object().unwrap();
            let known: Vec<&String> = properties.keys().collect();
            assert_eq!(known.len(), keys.len(), "{table}");
            assert!(known.iter().all(|key| keys.contains(&key.as_str())), "{table}: {known:?}");
        }
    }
}
