//! Where motions start, as written: by name, or in the numbers of a kind of model.

use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;

use clap::ValueEnum;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::{MapAccessDeserializer, StrDeserializer};
use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use stickslip_core::models::pad_on_disc::motion::start::{GivenStart, Start};

/// Where a motion starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum StartKind {
    /// At steady sliding, displaced a little.
    NearEquilibrium,
    /// At x = x' = 0, as the brake is applied.
    Rest,
    /// At the release from stick.
    LimitCycle,
}

/// Where a motion starts: by name, or in numbers.
#[derive(Debug, Clone, Serialize)]
#[serde(untagged)]
pub enum StartSpec<G> {
    /// One of the named starts.
    Named(StartKind),
    /// A state.
    Given(G),
}

/// The numbers of a start, by which kinds of models differ.
pub trait StartNumbers: JsonSchema + for<'de> Deserialize<'de> {
    /// The name of the schema of a start.
    const SCHEMA: &str;

    /// How the numbers are written, for messages.
    const FORM: &str;
}

impl<'de, G: StartNumbers> Deserialize<'de> for StartSpec<G> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct StartVisitor<G>(PhantomData<G>);

        impl<'de, G: StartNumbers> Visitor<'de> for StartVisitor<G> {
            type Value = StartSpec<G>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "\"near-equilibrium\", \"rest\", \"limit-cycle\" or {}", G::FORM)
            }

            fn visit_str<E: serde::de::Error>(self, name: &str) -> Result<StartSpec<G>, E> {
                StartKind::deserialize(StrDeserializer::new(name)).map(StartSpec::Named)
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<StartSpec<G>, A::Error> {
                G::deserialize(MapAccessDeserializer::new(map)).map(StartSpec::Given)
            }
        }

        deserializer.deserialize_any(StartVisitor(PhantomData))
    }
}

impl<G: StartNumbers> JsonSchema for StartSpec<G> {
    fn schema_name() -> Cow<'static, str> {
        G::SCHEMA.into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let (named, given) = (generator.subschema_for::<StartKind>(), generator.subschema_for::<G>());
        json_schema!({ "description": "A name, or a state that the motion starts in.", "anyOf": [named, given] })
    }
}

impl StartKind {
    /// As typed.
    pub fn name(self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }
}

impl From<StartKind> for Start {
    fn from(start: StartKind) -> Self {
        match start {
            StartKind::NearEquilibrium => Self::NearEquilibrium,
            StartKind::Rest => Self::Rest,
            StartKind::LimitCycle => Self::LimitCycle,
        }
    }
}

impl<G: for<'a> From<&'a GivenStart>> From<&Start> for StartSpec<G> {
    fn from(start: &Start) -> Self {
        match start {
            Start::NearEquilibrium => Self::Named(StartKind::NearEquilibrium),
            Start::Rest => Self::Named(StartKind::Rest),
            Start::LimitCycle => Self::Named(StartKind::LimitCycle),
            Start::Given(given) => Self::Given(given.into()),
        }
    }
}
