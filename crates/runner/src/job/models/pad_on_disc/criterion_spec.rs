//! The criterion of a job spec as written.

use std::borrow::Cow;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Unexpected, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use stickslip_core::models::pad_on_disc::flexible_disc::plate_modes::MOST_DISC_MODES;
use stickslip_core::models::pad_on_disc::model::LinearResult;
use stickslip_core::models::pad_on_disc::motion::start::{GivenStart, StartUnits};
use toml::Spanned;

use crate::job::model::OutsidePhysics;
use crate::job::models::record_spec::RecordedName;
use crate::job::models::start_spec::{StartNumbers, StartSpec};

/// The criterion of stability. All keys but `kind` belong to the simulation in time, `disc_modes` also to the coupled
/// eigenvalues.
#[derive(Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CriterionSpec {
    /// How a sample is decided.
    #[schemars(with = "CriterionKind")]
    pub kind: Option<Spanned<CriterionKind>>,
    /// The disc under the pad. With `"time-domain"`.
    #[schemars(with = "Option<DiscKind>", extend("default" = "flexible"))]
    pub disc: Option<Spanned<DiscKind>>,
    /// How many modes a flexible disc has, the lowest first. `"auto"`: as many as the growth rates of the job need.
    #[schemars(with = "Option<ModesSpec>", extend("default" = "auto"))]
    pub disc_modes: Option<Spanned<ModesSpec>>,
    /// Where a motion starts, by name or in numbers. With `"time-domain"`.
    #[schemars(with = "Option<StartSpec<GivenStartSpec>>", extend("default" = "near-equilibrium"))]
    pub start: Option<Spanned<StartSpec<GivenStartSpec>>>,
    /// Displacement of a start near the equilibrium, over the equilibrium's own; with other starts the distance within
    /// which a shrinking motion counts as stable. With `"time-domain"`.
    #[schemars(with = "Option<f64>", extend("default" = 0.01, "exclusiveMinimum" = 0, "maximum" = 1000))]
    pub displacement: Option<Spanned<f64>>,
    /// Scaled time after which a sample is undecided, at most 1e8 steps. With `"time-domain"`.
    #[schemars(with = "Option<f64>", extend("default" = 10_000, "exclusiveMinimum" = 0, "maximum" = 1e9))]
    pub horizon: Option<Spanned<f64>>,
    /// The paper's index, `{ amplitude = NUMBER }`: unstable where the settled amplitude of x (half peak to peak, over
    /// the disc's thickness) exceeds this, above 0 to 1000. Without it the motion decides. With `"time-domain"`.
    #[schemars(with = "Option<IndexSpec>")]
    pub index: Option<Spanned<IndexSpec>>,
    /// What happens to samples outside the model, such as those with f_s < f_c.
    #[schemars(with = "Option<OutsidePhysics>", extend("default" = "stable"))]
    pub outside_physics: Option<Spanned<OutsidePhysics>>,
    /// Results of the samples, whose mean and quantiles are written for each cell.
    #[schemars(with = "Option<Vec<Record>>", extend("default" = []))]
    pub record: Option<Spanned<Vec<Record>>>,
}

/// A number of disc modes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModesSpec {
    /// As many as the job needs.
    Auto,
    /// This many.
    Given(usize),
}

impl<'de> Deserialize<'de> for ModesSpec {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct ModesVisitor;

        impl Visitor<'_> for ModesVisitor {
            type Value = ModesSpec;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("\"auto\" or a whole number, for example 5")
            }

            fn visit_i64<E: serde::de::Error>(self, value: i64) -> Result<ModesSpec, E> {
                let refused = |_| E::invalid_value(Unexpected::Signed(value), &self);
                usize::try_from(value).map(ModesSpec::Given).map_err(refused)
            }

            fn visit_str<E: serde::de::Error>(self, value: &str) -> Result<ModesSpec, E> {
                if value == "auto" { Ok(ModesSpec::Auto) } else { Err(E::invalid_value(Unexpected::Str(value), &self)) }
            }
        }

        deserializer.deserialize_any(ModesVisitor)
    }
}

impl Serialize for ModesSpec {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Auto => "auto".serialize(serializer),
            Self::Given(modes) => modes.serialize(serializer),
        }
    }
}

impl JsonSchema for ModesSpec {
    fn schema_name() -> Cow<'static, str> {
        "DiscModes".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "\"auto\", or a number of disc modes.",
            "anyOf": [{ "const": "auto" }, { "type": "integer", "minimum": 1, "maximum": MOST_DISC_MODES }]
        })
    }
}

/// How a sample is decided.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CriterionKind {
    /// The eigenvalues of steady sliding on a rigid disc, in closed form.
    Eigenvalue,
    /// The eigenvalues of pad and flexible disc together.
    CoupledEigenvalue,
    /// The motion itself, simulated in time.
    TimeDomain,
}

/// The disc under the pad.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DiscKind {
    /// An elastic annular plate, by its modes.
    Flexible,
    /// The pad alone moves.
    Rigid,
}

/// A state that a motion starts in. What is left out is as in steady sliding.
#[derive(Debug, Clone, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GivenStartSpec {
    /// Displacement x of the pad, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tangential: Option<f64>,
    /// Its speed x', m/s, in the direction in which the disc drags it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub velocity: Option<f64>,
    /// Displacement y of the pad, m; on a flexible disc only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal: Option<f64>,
    /// Rotation phi of the pad, rad; on a flexible disc only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle: Option<f64>,
    /// Whether `tangential`, `normal` and `angle` count from steady sliding; otherwise from the pad without forces.
    #[serde(default)]
    pub from_equilibrium: bool,
    /// Units of displacements and speed.
    #[serde(default)]
    pub units: UnitsSpec,
}

/// Units of a start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum UnitsSpec {
    /// m and m/s.
    #[default]
    Si,
    /// Lengths over the disc's thickness h, and the speed over h/tau.
    Scaled,
}

impl StartNumbers for GivenStartSpec {
    const SCHEMA: &str = "Start";
    const FORM: &str = "{ tangential = ..., velocity = ..., normal = ..., angle = ... }";
}

impl From<&GivenStartSpec> for GivenStart {
    fn from(spec: &GivenStartSpec) -> Self {
        let GivenStartSpec { tangential, velocity, normal, angle, from_equilibrium, units } = *spec;
        let units = if units == UnitsSpec::Scaled { StartUnits::Scaled } else { StartUnits::Si };
        Self { tangential, velocity, normal, angle, from_equilibrium, units }
    }
}

impl From<&GivenStart> for GivenStartSpec {
    fn from(start: &GivenStart) -> Self {
        let GivenStart { tangential, velocity, normal, angle, from_equilibrium, units } = *start;
        let units = if units == StartUnits::Scaled { UnitsSpec::Scaled } else { UnitsSpec::Si };
        Self { tangential, velocity, normal, angle, from_equilibrium, units }
    }
}

/// The paper's index of instability.
#[derive(Debug, Clone, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct IndexSpec {
    /// Limit of the settled amplitude, half peak to peak of x over the disc's thickness.
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1000))]
    pub amplitude: f64,
}

/// What a run can record of its samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Record {
    /// Settled amplitude of the unstable samples, half peak to peak of x over the disc's thickness. With `kind =
    /// "time-domain"`.
    Amplitude,
    /// Largest real part of the eigenvalues, 1/s. With `kind = "eigenvalue"` or `"coupled-eigenvalue"`.
    GrowthRate,
    /// Frequency of the eigenvalue with the largest real part, Hz. With `kind = "eigenvalue"` or `"coupled-eigenvalue"`.
    Frequency,
    /// Highest rotating speed at which steady sliding is unstable, rad/s; 0 where it is stable at every speed. With `kind
    /// = "eigenvalue"`.
    CriticalSpeed,
    /// Half peak to peak of x over the limit cycle, with or without sticking, m. With `kind = "eigenvalue"`.
    CycleAmplitude,
    /// Frequency of that cycle, Hz. With `kind = "eigenvalue"`.
    CycleFrequency,
    /// Root mean square of x' over that cycle, m/s: radiated power goes with its square. With `kind = "eigenvalue"`.
    CycleVelocity,
    /// Preload above which steady sliding is unstable. With `kind = "eigenvalue"`.
    CriticalPreload,
}

impl RecordedName for Record {
    const ALL: &'static [Self] = &[
        Self::Amplitude,
        Self::GrowthRate,
        Self::Frequency,
        Self::CriticalSpeed,
        Self::CycleAmplitude,
        Self::CycleFrequency,
        Self::CycleVelocity,
        Self::CriticalPreload,
    ];

    fn linear(self) -> Option<LinearResult> {
        match self {
            Self::Amplitude => None,
            Self::GrowthRate => Some(LinearResult::GrowthRate),
            Self::Frequency => Some(LinearResult::Frequency),
            Self::CriticalSpeed => Some(LinearResult::CriticalSpeed),
            Self::CycleAmplitude => Some(LinearResult::CycleAmplitude),
            Self::CycleFrequency => Some(LinearResult::CycleFrequency),
            Self::CycleVelocity => Some(LinearResult::CycleVelocity),
            Self::CriticalPreload => Some(LinearResult::CriticalPreload),
        }
    }
}

impl CriterionKind {
    /// What can be recorded of samples that are decided so.
    pub fn recorded(self) -> &'static [Record] {
        match self {
            // All but the first.
            Self::Eigenvalue => &Record::ALL[1..],
            Self::CoupledEigenvalue => &[Record::GrowthRate, Record::Frequency],
            Self::TimeDomain => &[Record::Amplitude],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_the_columns() {
        for name in Record::ALL {
            let column = name.linear().map_or("amplitude", |result| result.described().name);
            assert_eq!(serde_json::to_value(name).unwrap(), column);
        }
    }
}
