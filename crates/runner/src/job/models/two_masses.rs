//! A model of a few lines, to show that jobs of any model run: two masses whose modes friction couples.
//!
//! After N. Hoffmann, M. Fischer, R. Allgaier, L. Gaul, A minimal model for studying properties of the mode-coupling type
//! instability in friction induced oscillations, Mech. Res. Comm. 29 (2002): x'' + K x = 0 with K = [[k11, k12 - D], [k12,
//! k22]] and D = 4 mu / 3, unstable for D > k12 + (k11 - k22)^2 / (4 k12).

use std::path::Path;
use std::sync::Arc;

use schemars::json_schema;
use serde::Deserialize;
use stickslip_core::model::decision::Decision;
use stickslip_core::model::quantity::Quantity;
use stickslip_core::model::verdict::Verdict;
use stickslip_core::model::{Columns, Configuration, IsStopped, Model, ModelError};
use stickslip_sampler::grid::Grid;
use toml::Spanned;

use crate::job::axes_spec::AxesSpec;
use crate::job::diagnosis::Complaints;
use crate::job::model::{Boundary, Draft, JobModel, Kind, OutsidePhysics, Parts, Tables};
use crate::job::reading;

/// The model: its quantities, and one formula.
#[derive(Debug, Clone)]
struct TwoMasses([Quantity; 4]);

struct Shared(Vec<f64>, Vec<usize>);

impl Model for TwoMasses {
    fn quantities(&self) -> &[Quantity] {
        &self.0
    }

    fn configure(
        &self,
        expected: &[f64],
        varying: &[usize],
        _: Option<&dyn Configuration>,
    ) -> Result<Box<dyn Configuration>, ModelError> {
        Ok(Box::new(Shared(expected.to_vec(), varying.to_vec())))
    }
}

impl Configuration for Shared {
    fn decide(&self, samples: &Columns<'_>, wanted: &[usize], _: IsStopped<'_>) -> Option<Vec<Decision>> {
        let verdict = |&sample: &usize| match samples.complete(sample, &self.0, &self.1)[..] {
            [mu, k11, k12, k22] if 4.0 * mu / 3.0 > k12 + (k11 - k22) * (k11 - k22) / (4.0 * k12) => Verdict::Unstable,
            _ => Verdict::Stable,
        };
        Some(wanted.iter().map(verdict).map(Decision::from).collect())
    }
}

/// The kind in job specs.
pub const KIND: Kind = Kind {
    name: "two-masses",
    criteria: &[],
    draft: |text, document, complaints| {
        let tables = reading::read::<TwoTables>(text, document, |_, _| None, complaints)?;
        let quantity = |name, unit, what| Quantity::new(name, unit, what);
        let quantities = [
            quantity("friction", "1", "friction coefficient"),
            quantity("k11", "N/m", "stiffness across"),
            quantity("k12", "N/m", "stiffness between"),
            quantity("k22", "N/m", "stiffness along"),
        ];
        Some(Box::new(TwoDraft { tables, model: TwoMasses(quantities) }))
    },
    schemas: [|_| json_schema!({}), |_| json_schema!({})],
    axes: Vec::new,
};

#[derive(Debug, Clone, Deserialize)]
struct TwoTables {
    model: TwoValues,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct TwoValues {
    friction: f64,
    stiffness: [f64; 3],
}

struct TwoDraft {
    tables: TwoTables,
    model: TwoMasses,
}

impl Draft for TwoDraft {
    fn quantities(&self) -> &[Quantity] {
        &self.model.0
    }

    fn boundary(&self) -> Option<Boundary> {
        Some(Boundary::Verdicts)
    }

    fn outside_physics(&self) -> Option<&Spanned<OutsidePhysics>> {
        None
    }

    fn check_values(&mut self, _: &AxesSpec, _: &Path, _: &mut Complaints) {}

    fn expected(&self) -> Vec<f64> {
        let TwoValues { friction, stiffness: [k11, k12, k22] } = self.tables.model;
        vec![friction, k11, k12, k22]
    }

    fn finish(self: Box<Self>, _: Option<&Grid>, _: Parts<'_>, _: &mut Complaints) -> Option<Arc<dyn JobModel>> {
        Some(Arc::new(TwoJob { expected: self.expected(), model: self.model }))
    }
}

#[derive(Debug)]
struct TwoJob {
    model: TwoMasses,
    expected: Vec<f64>,
}

impl JobModel for TwoJob {
    fn model(&self) -> &dyn Model {
        &self.model
    }

    fn expected(&self) -> Vec<f64> {
        self.expected.clone()
    }

    fn tables(&self, _: &Grid) -> Tables {
        let stiffness: Vec<f64> = self.expected[1..].to_vec();
        let model =
            [("kind", KIND.name.into()), ("friction", self.expected[0].into()), ("stiffness", stiffness.into())];
        let model = model.map(|(key, value): (&str, toml::Value)| (key.to_owned(), value));
        Tables { model: model.into_iter().collect(), criterion: toml::Table::new() }
    }
}
