//! What brakes with exactly given values do.

use crate::model::behaviour::{Behaviour, Behaviours, Cycle};
use crate::models::pad_on_disc::flexible_disc::brake::FlexibleBrake;

use super::definition::PadModel;
use super::quantities::{first_of_start, inputs};

impl PadModel {
    /// The growth rate with the flexible disc if the criterion has one; the limit cycle on a rigid disc.
    pub(super) fn behaviours_of_expected(&self) -> Behaviours<'_> {
        let modes = self.criterion().modes();
        // Neighbours differ in preload and friction alone, which the modes of the disc do not depend on.
        let mut disc: Option<(Vec<f64>, Option<FlexibleBrake>)> = None;
        Box::new(move |expected| {
            let brake = self.complete_brake(expected).ok()?;
            let inputs = inputs(expected);
            let growth_rate = match modes {
                None => Some(brake.growth_rate()),
                Some(modes) => {
                    let others = &expected[2..first_of_start()];
                    if disc.as_ref().is_none_or(|(known, _)| known != others) {
                        disc = Some((others.to_vec(), FlexibleBrake::with_modes(brake.clone(), modes).ok()));
                    }
                    disc.as_ref().and_then(|(_, flexible)| flexible.as_ref()?.growth_rate(inputs).ok())
                }
            };
            let scales = brake.scales();
            let cycle = brake.limit_cycle().map(|cycle| Cycle {
                amplitude: scales.metres(0.5 * (cycle.tangential_max - cycle.tangential_min)),
                frequency: scales.hertz(1.0 / cycle.period),
                stick: cycle.stick_fraction,
            });
            Some(Behaviour { growth_rate: growth_rate.map(|rate| scales.per_second(rate)), cycle })
        })
    }
}
