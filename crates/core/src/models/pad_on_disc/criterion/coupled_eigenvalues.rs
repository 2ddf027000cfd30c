//! The criterion of the coupled eigenvalues of pad and flexible disc.

use crate::model::decision::Decision;
use crate::model::verdict::Verdict;
use crate::models::pad_on_disc::flexible_disc::brake::FlexibleBrake;
use crate::models::pad_on_disc::flexible_disc::error::FlexibleError;
use crate::models::pad_on_disc::flexible_disc::linear_stability::LinearStability;
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};

impl FlexibleBrake {
    /// Decides a sample by the coupled eigenvalues. `stability` finds its linear stability:
    /// [`FlexibleBrake::linear_stability`] for one of many samples, [`FlexibleBrake::by_eigenvalues`] for a single one.
    /// Without preload or friction a sample is outside the model; one whose equilibrium or eigenvalues cannot be found is
    /// failed.
    #[must_use]
    pub fn decide_with(
        &self,
        inputs: RandomInputs,
        stability: impl Fn(&Self, RandomInputs) -> Result<LinearStability, FlexibleError>,
    ) -> Decision {
        decision(self.brake(), inputs, || stability(self, inputs))
    }
}

/// The decision on a sample of a brake. `stability` finds its linear stability.
pub(crate) fn decision(
    brake: &PadOnDisc,
    inputs: RandomInputs,
    stability: impl FnOnce() -> Result<LinearStability, FlexibleError>,
) -> Decision {
    if inputs.preload <= 0.0 || brake.lacks_friction(inputs) {
        return Decision::OUTSIDE_PHYSICS;
    }
    let (verdict, fed_by) = match stability() {
        Ok(LinearStability::Stable) => (Verdict::Stable, None),
        Ok(LinearStability::Unstable { fed_by }) => (Verdict::Unstable, Some(fed_by)),
        Err(_) => (Verdict::Failed, None),
    };
    Decision { fed_by: fed_by.map(|source| source as usize), ..Decision::from(verdict) }
}
