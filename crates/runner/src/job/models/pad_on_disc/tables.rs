//! The tables `[model]` and `[criterion]` of the pad on the disc as written.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use toml::Spanned;

use super::criterion_spec::CriterionSpec;
use super::friction::FrictionSpec;
use super::keys::SECTIONS;
use super::overrides::{Overrides, section_properties};
use super::preload_force;

/// Both tables.
#[derive(Debug, Deserialize)]
pub struct PadTables {
    /// The brake.
    #[serde(default)]
    pub model: ModelSpec,
    /// What decides whether a sample is stable.
    pub criterion: Option<Spanned<CriterionSpec>>,
}

/// The pad on the disc: preset and overrides. `kind = "pad-on-disc"` may be written, too.
#[derive(Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ModelSpec {
    /// The parameter set to start from; there is only this one.
    #[schemars(with = "Option<String>", extend("default" = "sui-ding-2018"))]
    pub preset: Option<Spanned<String>>,
    /// Values of the disc in place of the preset's.
    #[serde(default, skip_serializing_if = "Overrides::is_empty")]
    #[schemars(schema_with = "section_schema::<0>")]
    pub disc: Overrides,
    /// Values of the pad in place of the preset's.
    #[serde(default, skip_serializing_if = "Overrides::is_empty")]
    #[schemars(schema_with = "section_schema::<1>")]
    pub pad: Overrides,
    /// Values of the springs in place of the preset's.
    #[serde(default, skip_serializing_if = "Overrides::is_empty")]
    #[schemars(schema_with = "section_schema::<2>")]
    pub stiffness: Overrides,
    /// Values of the dampers in place of the preset's.
    #[serde(default, skip_serializing_if = "Overrides::is_empty")]
    #[schemars(schema_with = "section_schema::<3>")]
    pub damping: Overrides,
    /// The friction law, and its values in place of the preset's.
    #[serde(default)]
    #[schemars(extend("default" = {}))]
    pub friction: FrictionSpec,
    /// Values of the operating point in place of the preset's; used for axes that are left out.
    #[serde(default, skip_serializing_if = "Overrides::is_empty")]
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
