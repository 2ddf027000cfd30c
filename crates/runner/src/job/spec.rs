//! The job spec as TOML: one struct for each table, the source of parsing, of the JSON schema and of its texts.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use toml::Spanned;

use super::axes_spec::AxesSpec;
use super::criterion_spec::CriterionSpec;
use super::engine::EngineSpec;
use super::friction::FrictionSpec;
use super::keys::SECTIONS;
use super::limit_spec::LimitSpec;
use super::overrides::{Overrides, section_properties};
use super::preload_force;
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
    /// Which limits are sought along an axis.
    #[schemars(with = "Option<LimitSpec>")]
    pub limit: Option<Spanned<LimitSpec>>,
    /// What a cluster is asked for.
    #[serde(default)]
    pub engine: EngineSpec,
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
    /// The friction law and its values.
    #[serde(default)]
    pub friction: FrictionSpec,
    /// Overrides of the operating point, used for axes that are left out.
    #[serde(default)]
    #[schemars(schema_with = "section_schema::<5>")]
    pub operating_point: Overrides,
}

impl ModelSpec {
    /// The force that is given in place of the preload.
    pub fn preload_force(&self) -> Option<&Spanned<f64>> {
        let is_force = |name: &str| preload_force::KEY.ends_with(&format!(".{name}"));
        self.operating_point.iter().find(|(name, _)| is_force(name.get_ref())).map(|(_, value)| value)
    }

    /// Every section with its overrides.
    pub fn sections(&self) -> [(&'static str, &Overrides); 6] {
        let [disc, pad, stiffness, damping, friction, operating_point] = SECTIONS;
        [
            (disc, &self.disc),
            (pad, &self.pad),
            (stiffness, &self.stiffness),
            (damping, &self.damping),
            (friction, &self.friction.values),
            (operating_point, &self.operating_point),
        ]
    }
}

/// The JSON schema of one section.
fn section_schema<const SECTION: usize>(_: &mut SchemaGenerator) -> Schema {
    let properties = section_properties(SECTIONS[SECTION]);
    json_schema!({ "type": "object", "properties": properties, "additionalProperties": false })
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
            // The other axes are those of parameters, of which another test knows.
            let known: Vec<&String> =
                properties.keys().filter(|key| table != "axes" || keys.contains(&key.as_str())).collect();
            assert_eq!(known.len(), keys.len(), "{table}");
            assert!(known.iter().all(|key| keys.contains(&key.as_str())), "{table}: {known:?}");
        }
    }
}
