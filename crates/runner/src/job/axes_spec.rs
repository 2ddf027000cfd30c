//! The axes of a job spec as written.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::MapAccessDeserializer;
use serde::de::{Error as _, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use serde_json::json;
use stickslip_core::motion::start::GivenStart;
use stickslip_core::parameters::SCALARS;
use toml::Spanned;

use super::imprecise_schema::number_or_imprecise;
use super::keys::{SECTIONS, axis_of};
use super::preload_force;
use super::start_value::StartValue;

/// Keys of `[axes]` without a dot: the short names of three axes, and tables of further ones.
const BARE_KEYS: [&str; 11] = {
    let [disc, pad, stiffness, damping, friction, operating_point] = SECTIONS;
    let names = ["rotating_speed", "preload", preload_force::NAME, "static_friction"];
    let [speed, preload, force, friction_coefficient] = names;
    [speed, preload, force, friction_coefficient, disc, pad, stiffness, damping, friction, operating_point, START]
};

/// The table of axes of the start.
const START: &str = "start";

/// The axes of the grid, by name.
#[derive(Debug, Default)]
pub struct AxesSpec(pub Vec<AxisEntry>);

/// An axis under its name.
#[derive(Debug)]
pub struct AxisEntry {
    /// Its name: `rotating_speed`, `preload`, `preload_force`, `static_friction`, or the key of a parameter or of a number of the start.
    pub name: Spanned<String>,
    /// Its values.
    pub axis: Spanned<AxisSpec>,
}

impl AxesSpec {
    /// The first axis of a number of the start.
    pub fn of_start(&self) -> Option<&AxisEntry> {
        self.0.iter().find(|entry| StartValue::from_key(entry.name.get_ref()).is_some())
    }

    /// The axis of a parameter, if the job has it, under any of its names.
    pub fn of_parameter(&self, key: &str) -> Option<&AxisEntry> {
        let is_axis = |name: &str| name == key || axis_of(key) == Some(name);
        let is_force = |name: &str| key == preload_force::PRELOAD && preload_force::is_preload_force(name);
        self.0.iter().find(|entry| is_axis(entry.name.get_ref()) || is_force(entry.name.get_ref()))
    }
}

/// A key of `[axes]`.
struct AxisKey(String);

impl<'de> Deserialize<'de> for AxisKey {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let key = String::deserialize(deserializer)?;
        // Which names with a dot there are is checked later, and told with hints.
        if key.contains('.') || BARE_KEYS.contains(&key.as_str()) {
            Ok(Self(key))
        } else {
            Err(D::Error::unknown_field(&key, &BARE_KEYS))
        }
    }
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
                while let Some(key) = map.next_key::<Spanned<AxisKey>>()? {
                    let (span, AxisKey(key)) = (key.span(), key.into_inner());
                    if key == START || SECTIONS.contains(&key.as_str()) {
                        let section: BTreeMap<Spanned<String>, Spanned<AxisSpec>> = map.next_value()?;
                        entries.extend(section.into_iter().map(|(name, axis)| AxisEntry {
                            name: Spanned::new(name.span(), format!("{key}.{}", name.get_ref())),
                            axis,
                        }));
                    } else {
                        entries.push(AxisEntry { name: Spanned::new(span, key), axis: map.next_value()? });
                    }
                }
                Ok(AxesSpec(entries))
            }
        }

        deserializer.deserialize_map(AxesVisitor)
    }
}

impl JsonSchema for AxesSpec {
    fn schema_name() -> Cow<'static, str> {
        "AxesSpec".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let axis = generator.subschema_for::<AxisSpec>();
        let described = |description: String| {
            let mut schema = axis.clone();
            schema.insert("description".to_owned(), description.into());
            schema
        };
        let mut properties = serde_json::Map::new();
        for (name, description) in [
            ("rotating_speed", "Rotating speed of the disc, rad/s."),
            ("preload", "Expected preload: displacement of the calliper over the thickness of the disc."),
            (
                preload_force::NAME,
                "In place of preload: expected contact force, N. It depends on disc.thickness, stiffness.contact_normal and stiffness.calliper_normal.",
            ),
            ("static_friction", "Expected static friction coefficient."),
        ] {
            properties.insert(name.to_owned(), described(description.to_owned()).into());
        }
        let mut add = |key: &str, description: String| {
            let schema = described(description);
            properties.insert(key.to_owned(), schema.clone().into());
            // The same within the table of its section.
            if let Some((section, name)) = key.split_once('.') {
                let section = properties
                    .entry(section)
                    .or_insert_with(|| json!({ "type": "object", "properties": {}, "additionalProperties": false }));
                section["properties"][name] = schema.into();
            }
        };
        for scalar in &SCALARS {
            add(scalar.key, format!("Expected {}, unit {}", scalar.description, scalar.unit));
        }
        add(preload_force::KEY, "Expected contact force in place of preload, unit N".to_owned());
        for value in StartValue::ALL {
            let description = value.description(&GivenStart::default());
            add(value.key(), format!("Expected {description}, unit as criterion.start.units"));
        }
        json_schema!({
            "description": "The axes of the grid.",
            "type": "object",
            "properties": properties,
            "additionalProperties": false
        })
    }
}

/// One axis: a number, a list of numbers, or `{ from, to, points, scale }`.
#[derive(Debug, Clone)]
pub enum AxisSpec {
    /// Explicit values.
    Values(Vec<f64>),
    /// Values between two ends.
    Range(RangeSpec),
}

/// Values between two ends, both included.
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
    /// How they are spaced; evenly by default.
    #[serde(default)]
    pub scale: ScaleSpec,
}

/// How the values of an axis are spaced.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ScaleSpec {
    /// Evenly.
    #[default]
    Linear,
    /// Each value is the same multiple of the one before.
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
                number_or_imprecise(&json!({ "type": "number" })),
                { "type": "array", "items": { "type": "number" }, "minItems": 1, "uniqueItems": true },
                range,
            ]
        })
    }
}
