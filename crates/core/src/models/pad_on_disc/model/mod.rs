//! The pad on the disc as a [`Model`]: its quantities, and the configurations that decide samples.

use crate::friction::law::LawKind;
use crate::model::behaviour::Behaviours;
use crate::model::decision::Source;
use crate::model::quantity::Quantity;
use crate::model::recorded::RecordedResult;
use crate::model::{Configuration, Model, ModelError, SampleQueue, Simulation};
use crate::models::pad_on_disc::criterion::time_domain::DiscModel;
use crate::models::pad_on_disc::degree_of_freedom::SOURCES;
use crate::models::pad_on_disc::lanes::batch::decide_queue;

use self::configuration::{PadConfiguration, Varying};
use self::queue::Motions;

mod quantities;

mod linear_results;

mod definition;

mod behaviour;

mod list;

mod configuration;

mod queue;

pub use definition::{AMPLITUDE, Criterion, PadModel};
pub use linear_results::{LinearRecord, LinearResult};
pub use quantities::{
    PRELOAD, PRELOAD_KEY, ROTATING_SPEED, STATIC_FRICTION, STATIC_FRICTION_KEY, configuration_scalars, first_of_start,
    inputs, quantities,
};

impl PadModel {
    fn varying(&self, varying: &[usize]) -> Varying {
        let given = self.criterion().given_start();
        Varying::new(varying, given)
    }
}

impl Model for PadModel {
    fn quantities(&self) -> &[Quantity] {
        &self.quantities
    }

    fn configure(
        &self,
        expected: &[f64],
        varying: &[usize],
        like: Option<&dyn Configuration>,
    ) -> Result<Box<dyn Configuration>, ModelError> {
        let like = like.and_then(PadConfiguration::from_any);
        let brake = self.brake(expected)?;
        Ok(Box::new(PadConfiguration::new(brake, self.varying(varying), self.criterion(), like)?))
    }

    fn outside_meaning(&self) -> &'static str {
        match self.parameters().friction.law {
            LawKind::Table(_) => "preload at or below 0, or a friction coefficient at or below 0",
            LawKind::Stribeck | LawKind::Rational => "preload at or below 0, or f_s < f_c",
        }
    }

    fn verdict_names(&self) -> [&'static str; 2] {
        match self.criterion() {
            // What does not come to rest sticks and slips, or keeps to a cycle.
            Criterion::TimeDomain { disc: DiscModel::Rigid, .. } => ["steady sliding", "stick-slip"],
            _ => ["stable", "unstable"],
        }
    }

    fn length_scale(&self, expected: &[f64]) -> Option<f64> {
        self.place("disc.thickness").map(|place| expected[place])
    }

    fn behaviours(&self) -> Option<Behaviours<'_>> {
        Some(self.behaviours_of_expected())
    }

    fn behaviours_on(&self) -> [&'static str; 2] {
        let rigid = " on a rigid disc";
        [if self.criterion().modes().is_some() { " with the flexible disc" } else { rigid }, rigid]
    }

    fn sources(&self) -> &'static [Source] {
        if self.criterion().modes().is_some() { &SOURCES } else { &[] }
    }

    fn recorded(&self) -> &[RecordedResult] {
        &self.recorded
    }

    fn has_very_slow_samples(&self) -> bool {
        matches!(self.criterion(), Criterion::TimeDomain { disc: DiscModel::Flexible { .. }, .. })
    }

    fn has_closed_form(&self) -> bool {
        matches!(self.criterion(), Criterion::Eigenvalue { .. })
    }

    fn simulation(&self) -> Option<&dyn Simulation> {
        matches!(self.criterion(), Criterion::TimeDomain { .. }).then_some(self)
    }
}

impl Simulation for PadModel {
    fn outline(&self, expected: &[f64], varying: &[usize]) -> Result<Box<dyn Configuration>, ModelError> {
        Ok(Box::new(PadConfiguration::outline(self.brake(expected)?, self.varying(varying))))
    }

    fn run<'q>(&self, queue: &mut dyn SampleQueue<'q>) {
        decide_queue(&mut Motions::new(queue));
    }
}
