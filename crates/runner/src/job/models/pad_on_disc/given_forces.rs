//! Forces in a job, in place of preloads.

use std::ops::Range;

use stickslip_core::model::quantity::Quantity;
use stickslip_core::models::pad_on_disc::model::PRELOAD as PRELOAD_PLACE;
use stickslip_core::models::pad_on_disc::parameters::Parameters;
use stickslip_sampler::grid::Axis;

use super::keys::axis_of_parameter;
use super::preload_force::{KEY, PARAMETERS, is_preload_force, preload};
use super::tables::ModelSpec;
use crate::job::axes::values;
use crate::job::axes_spec::{AxesSpec, AxisEntry, AxisSpec};
use crate::job::diagnosis::Complaint;

/// Forces in place of preloads.
pub struct GivenForces {
    /// Their key.
    key: String,
    span: Range<usize>,
    forces: Result<Axis, String>,
}

impl GivenForces {
    /// Those in place of the values of the quantity at `place`: of its axis, or without one those of the model.
    pub fn find(place: usize, entry: Option<&AxisEntry>, model: &ModelSpec) -> Option<Self> {
        if place != PRELOAD_PLACE {
            return None;
        }
        if let Some(AxisEntry { name, axis }) = entry {
            let key = format!("axes.{}", name.get_ref());
            return is_preload_force(name.get_ref()).then(|| Self {
                key,
                span: axis.span(),
                forces: values(axis.get_ref()),
            });
        }
        let force = model.preload_force()?;
        let forces = values(&AxisSpec::Values(vec![*force.get_ref()]));
        Some(Self { key: format!("model.{KEY}"), span: force.span(), forces })
    }

    /// The preloads that press with them.
    pub fn preloads(
        self,
        axes: &AxesSpec,
        given: &[(usize, Axis)],
        quantities: &[Quantity],
        defaults: &Parameters,
    ) -> Result<Axis, Complaint> {
        let Self { key, span, forces } = self;
        let complain = |message: String| Complaint::at(span.clone(), format!("{key}{message}"));
        let mut parameters = defaults.clone();
        let given = given.iter().map(|(place, axis)| (&*quantities[*place].name, axis));
        for (name, axis) in given.filter(|(name, _)| PARAMETERS.contains(name)) {
            let [value] = *axis.values() else {
                let message = format!(
                    ": the preload of a force depends on {name}, which is an axis with several values. Give axes.preload in place of the force, or {name} one value"
                );
                let other = axis_of_parameter(axes, name).map(|entry| entry.axis.span());
                return Err(other.into_iter().fold(complain(message), Complaint::and_at));
            };
            // It is within its limits.
            let _ = parameters.set(name, value);
        }
        let forces = forces.map_err(|message| complain(format!(": {message}")))?;
        let preload =
            |&force: &f64| preload(force, &parameters).map_err(|message| complain(format!(": {force} {message}")));
        let preloads = forces.values().iter().map(preload).collect::<Result<Vec<f64>, Complaint>>()?;
        Axis::from_values(preloads).map_err(|error| complain(format!(": {error}")))
    }
}
