//! Where a measured friction curve is at or below 0, and what of a brake slides there.

use serde_json::{Value, json};
use stickslip_core::models::pad_on_disc::criterion::settings::TimeDomainSettings;
use stickslip_core::models::pad_on_disc::criterion::time_domain::{DiscModel, TimeDomain};
use stickslip_core::models::pad_on_disc::motion::start::Start;
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};

use crate::units::significant;

/// The sliding speeds of a brake, or of the pad that moves as an oscillator does, without friction.
pub struct WithoutFriction {
    /// m/s, in rising order.
    speeds: Vec<[f64; 2]>,
    /// Whether steady sliding or rest is among them.
    pub steady: bool,
    /// Whether a limit cycle on a rigid disc slides at some of them.
    cycle: bool,
}

impl WithoutFriction {
    /// Of a brake, that may have a limit cycle.
    pub fn of(brake: &PadOnDisc, has_cycle: bool) -> Self {
        let parameters = brake.parameters();
        let inputs = RandomInputs {
            preload: parameters.operating_point.preload,
            static_friction: parameters.friction.static_coefficient,
        };
        let settings = TimeDomainSettings { start: Start::LimitCycle, ..TimeDomainSettings::default() };
        let speeds = brake.speeds_without_friction();
        let motion = || TimeDomain::new(brake, &DiscModel::Rigid, settings);
        let cycle = has_cycle && !speeds.is_empty() && motion().is_ok_and(|motion| motion.meets_no_friction(inputs));
        Self { steady: brake.lacks_friction(inputs), cycle, speeds }
    }

    /// By name. JSON has no infinity: the end of a range without one is null.
    pub fn json(&self) -> Value {
        json!({ "speeds_m_s": self.speeds, "steady_sliding": self.steady, "limit_cycle": self.cycle })
    }

    /// In words, if there are any.
    pub fn words(&self) -> Option<String> {
        let ranges = self.speeds.iter().map(|&[from, to]| match to.is_infinite() {
            true => format!("from {} m/s on", significant(from)),
            false => format!("from {} to {} m/s", significant(from), significant(to)),
        });
        let ranges: Vec<String> = ranges.collect();
        let met = match (self.steady, self.cycle) {
            (true, _) => "steady sliding or rest meets such a speed, which is outside the model",
            (false, true) => "the limit cycle meets such a speed and is outside the model, steady sliding is not",
            (false, false) => "a motion that meets such a speed is outside the model; steady sliding does not",
        };
        (!ranges.is_empty()).then(|| format!("at or below 0 {}: {met}", ranges.join(" and ")))
    }
}
