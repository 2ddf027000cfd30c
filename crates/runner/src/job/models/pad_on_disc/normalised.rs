//! The tables of the pad on the disc written out, with every default filled in.

use stickslip_core::friction::law::LawKind;
use stickslip_core::model::Model;
use stickslip_core::models::pad_on_disc::criterion::time_domain::DiscModel;
use stickslip_core::models::pad_on_disc::model::{Criterion, PadModel};
use stickslip_core::models::pad_on_disc::parameters::{Parameters, SCALARS};
use stickslip_sampler::grid::Grid;

use super::criterion_spec::{CriterionKind, CriterionSpec, DiscKind, IndexSpec, ModesSpec, Record};
use super::friction::{FrictionSpec, LawSpec};
use super::overrides::Overrides;
use super::tables::ModelSpec;
use crate::job::model::{Tables, table_of, written};
use crate::job::models::record_spec::names_of;

/// The tables of a job, without values that are axes.
pub fn tables(pad: &PadModel, grid: &Grid) -> Tables {
    let is_axis = |key: &str| pad.place(key).is_some_and(|place| grid.axis_of(place).is_some());
    Tables {
        model: table_of(&model(pad.parameters(), is_axis)),
        criterion: table_of(&CriterionSpec::from(pad.criterion())),
    }
}

/// The values of the parameters but for those that are axes.
fn model(parameters: &Parameters, is_axis: impl Fn(&str) -> bool) -> ModelSpec {
    let law = &parameters.friction.law;
    let is_strange = |name: &str| LawSpec::from(law).refusal(name, "").is_some();
    let section = |section: &str| -> Overrides {
        let scalars = SCALARS.iter().filter(|scalar| scalar.section() == section && !is_axis(scalar.key));
        let scalars = scalars.filter(|scalar| scalar.is_given(parameters));
        let own = scalars.filter(|scalar| section != "friction" || !is_strange(scalar.name()));
        own.map(|scalar| (written(scalar.name().to_owned()), written(scalar.value(parameters)))).collect()
    };
    let mut friction = FrictionSpec::written_out(law, section("friction"));
    // The one that is meant where a job does not say.
    if matches!(law, LawKind::Stribeck) {
        friction.law = None;
    }
    ModelSpec {
        preset: None,
        disc: section("disc"),
        pad: section("pad"),
        stiffness: section("stiffness"),
        damping: section("damping"),
        friction,
        operating_point: section("operating_point"),
    }
}

/// Keys that the kind of criterion has no use for are absent.
impl From<&Criterion> for CriterionSpec {
    fn from(criterion: &Criterion) -> Self {
        let of_kind = |kind: CriterionKind| Self { kind: Some(written(kind)), ..Self::default() };
        let given = |modes: usize| Some(written(ModesSpec::Given(modes)));
        match criterion {
            Criterion::Eigenvalue { record } => Self {
                record: (!record.is_empty()).then(|| written(names_of(*record))),
                ..of_kind(CriterionKind::Eigenvalue)
            },
            Criterion::CoupledEigenvalue { modes, record } => {
                let record = (!record.is_empty()).then(|| written(names_of(*record)));
                Self { disc_modes: given(*modes), record, ..of_kind(CriterionKind::CoupledEigenvalue) }
            }
            Criterion::TimeDomain { disc, settings } => {
                let (disc, disc_modes) = match disc {
                    DiscModel::Rigid => (DiscKind::Rigid, None),
                    DiscModel::Flexible { modes } => (DiscKind::Flexible, given(*modes)),
                };
                Self {
                    disc: Some(written(disc)),
                    disc_modes,
                    start: Some(written((&settings.start).into())),
                    displacement: Some(written(settings.displacement)),
                    horizon: Some(written(settings.horizon)),
                    index: settings.amplitude_index.map(|amplitude| written(IndexSpec { amplitude })),
                    record: settings.record_amplitude.then(|| written(vec![Record::Amplitude])),
                    ..of_kind(CriterionKind::TimeDomain)
                }
            }
        }
    }
}
