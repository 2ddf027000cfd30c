//! The tables of the pad on the disc written out, with every default filled in.

use std::collections::BTreeMap;

use serde::Serialize;
use stickslip_core::friction::law::LawKind;
use stickslip_core::model::Model;
use stickslip_core::models::pad_on_disc::criterion::time_domain::DiscModel;
use stickslip_core::models::pad_on_disc::model::{Criterion, PadModel};
use stickslip_core::models::pad_on_disc::parameters::{Parameters, SCALARS};
use stickslip_sampler::grid::Grid;

use super::criterion_spec::{CriterionKind, DiscKind, GivenStartSpec, Record};
use super::friction::{CurveColumns, LawSpec};
use crate::job::model::{Tables, table_of};
use crate::job::models::start_spec::StartSpec;

/// The values of the model by section and name, without those that are axes of the grid.
type NormalisedModel = BTreeMap<&'static str, BTreeMap<&'static str, NormalisedValue>>;

/// A value of the model.
#[derive(Serialize)]
#[serde(untagged)]
enum NormalisedValue {
    Number(f64),
    Word(&'static str),
    Curve(CurveColumns),
}

/// The tables of a job, without values that are axes.
pub fn tables(pad: &PadModel, grid: &Grid) -> Tables {
    let is_axis = |key: &str| pad.place(key).is_some_and(|place| grid.axis_of(place).is_some());
    Tables {
        model: table_of(&model(pad.parameters(), is_axis)),
        criterion: table_of(&NormalisedCriterion::from(pad.criterion())),
    }
}

/// The values of the parameters but for those that are axes.
fn model(parameters: &Parameters, is_axis: impl Fn(&str) -> bool) -> NormalisedModel {
    let law = &parameters.friction.law;
    let mut model = NormalisedModel::new();
    for scalar in &SCALARS {
        let is_strange = scalar.section() == "friction" && LawSpec::from(law).refusal(scalar.name(), "").is_some();
        if !is_axis(scalar.key) && !is_strange {
            let value = NormalisedValue::Number(scalar.value(parameters));
            model.entry(scalar.section()).or_default().insert(scalar.name(), value);
        }
    }
    let friction = model.entry("friction").or_default();
    if !matches!(law, LawKind::Stribeck) {
        friction.insert("law", NormalisedValue::Word(law.name()));
    }
    if let Some(curve) = law.table() {
        friction.insert("table", NormalisedValue::Curve(CurveColumns::from(&**curve)));
    }
    model
}

/// The criterion. Keys that its kind has no use for are absent.
#[derive(Serialize)]
struct NormalisedCriterion {
    kind: CriterionKind,
    #[serde(skip_serializing_if = "Option::is_none")]
    disc: Option<DiscKind>,
    #[serde(skip_serializing_if = "Option::is_none")]
    disc_modes: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    start: Option<StartSpec<GivenStartSpec>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    displacement: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    horizon: Option<f64>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    record: Vec<Record>,
    #[serde(skip_serializing_if = "Option::is_none")]
    index: Option<NormalisedIndex>,
}

/// The paper's index of instability.
#[derive(Serialize)]
struct NormalisedIndex {
    amplitude: f64,
}

impl From<&Criterion> for NormalisedCriterion {
    fn from(criterion: &Criterion) -> Self {
        let empty = Self {
            kind: CriterionKind::Eigenvalue,
            disc: None,
            disc_modes: None,
            start: None,
            displacement: None,
            horizon: None,
            record: Vec::new(),
            index: None,
        };
        match criterion {
            Criterion::Eigenvalue => empty,
            Criterion::CoupledEigenvalue { modes } => {
                Self { kind: CriterionKind::CoupledEigenvalue, disc_modes: Some(*modes), ..empty }
            }
            Criterion::TimeDomain { disc, settings } => Self {
                kind: CriterionKind::TimeDomain,
                disc: Some(if matches!(disc, DiscModel::Rigid) { DiscKind::Rigid } else { DiscKind::Flexible }),
                disc_modes: if let DiscModel::Flexible { modes } = disc { Some(*modes) } else { None },
                start: Some((&settings.start).into()),
                displacement: Some(settings.displacement),
                horizon: Some(settings.horizon),
                record: settings.record_amplitude.then_some(Record::Amplitude).into_iter().collect(),
                index: settings.amplitude_index.map(|amplitude| NormalisedIndex { amplitude }),
            },
        }
    }
}
