//! A friction oscillator on a belt at one point, by the pad on a rigid disc that moves as it does: metres and seconds.

use serde_json::{Value, json};
use stickslip_core::models::pad_on_disc::rigid_disc::basin::Basin;
use stickslip_core::models::pad_on_disc::rigid_disc::limit_cycle::{CycleEnds, LimitCycle};
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::{PadOnDisc, SlidingEquilibrium};
use stickslip_core::models::pad_on_disc::rigid_disc::stability::SpeedRange;
use stickslip_core::numerics::eigenvalues::Eigenvalue;

use super::without_friction::WithoutFriction;
use crate::job::measured_friction::described;
use crate::units::significant;

/// What is computed of an oscillator.
pub struct Oscillator {
    belt_speed: f64,
    /// What is said of a measured friction curve, if it has one.
    curve: Option<String>,
    equilibrium: SlidingEquilibrium,
    eigenvalues: [Eigenvalue; 2],
    /// Where steady sliding is unstable.
    unstable_speeds: Vec<SpeedRange>,
    /// The speed above which no motion sticks again, and that above which there is no limit cycle.
    ends: CycleEnds,
    cycle: Option<LimitCycle>,
    basin: Basin,
    without_friction: WithoutFriction,
}

impl Oscillator {
    /// Of the pad that moves as it does.
    pub fn new(pad: &PadOnDisc) -> Self {
        let [first, second, ..] = pad.sliding_eigenvalues();
        let cycle = pad.limit_cycle();
        Self {
            belt_speed: pad.parameters().operating_point.rotating_speed,
            curve: pad.parameters().friction.law.table().map(|curve| described(curve)),
            equilibrium: pad.sliding_equilibrium(),
            eigenvalues: [first, second],
            unstable_speeds: pad.unstable_speeds(),
            ends: pad.cycle_ends(),
            cycle,
            basin: pad.basin(),
            without_friction: WithoutFriction::of(pad, cycle.is_some()),
        }
    }

    fn is_stable(&self) -> bool {
        self.eigenvalues[0].re <= 0.0
    }

    /// Everything by name; JSON has no infinity, which becomes null.
    pub fn json(&self) -> Value {
        let cycle = self.cycle.as_ref().map(|cycle| {
            json!({
                "x_max": cycle.tangential_max,
                "x_min": cycle.tangential_min,
                "period": cycle.period,
                "stick_fraction": cycle.stick_fraction,
            })
        });
        let knock = self.basin.smallest_knock().map(|knock| {
            json!({
                "forward": knock.forward,
                "backward": knock.backward,
                "outward": knock.outward,
                "inward": knock.inward,
            })
        });
        json!({
            "belt_speed": self.belt_speed,
            "equilibrium": { "x": self.equilibrium.tangential },
            "friction_coefficient": self.equilibrium.friction_coefficient,
            "eigenvalues": self.eigenvalues.map(|value| [value.re, value.im]),
            "stable": self.is_stable(),
            "critical_speed": self.unstable_speeds.last().map(|speeds| speeds.to),
            "unstable_speeds": self.unstable_speeds.iter().map(|speeds| [speeds.from, speeds.to]).collect::<Vec<_>>(),
            "end_of_stick_slip": self.ends.stick_slip,
            "end_of_cycles": self.ends.any,
            "limit_cycle": cycle,
            "smallest_knock": knock,
            "without_friction": self.without_friction.json(),
        })
    }

    /// The speeds at which steady sliding is unstable, in words.
    fn critical_speed(&self) -> String {
        match *self.unstable_speeds {
            [] => "none: steady sliding is stable at every speed".to_owned(),
            [SpeedRange { from: 0.0, to }] if to.is_infinite() => "none: unstable at every speed".to_owned(),
            [SpeedRange { from: 0.0, to }] => format!("{} m/s", significant(to)),
            ref several => {
                let ranges = several.iter().map(|&SpeedRange { from, to }| match to.is_infinite() {
                    true => format!("above {} m/s", significant(from)),
                    false => format!("from {} to {} m/s", significant(from), significant(to)),
                });
                format!("unstable {}", ranges.collect::<Vec<_>>().join(", "))
            }
        }
    }

    /// In words.
    pub fn text(&self) -> String {
        let [first, second] = &self.eigenvalues;
        let eigenvalues = match first.im {
            0.0 => format!("{} and {} 1/s", significant(first.re), significant(second.re)),
            im => format!("{} +- {}i 1/s", significant(first.re), significant(im)),
        };
        let stable = match (self.without_friction.steady, self.is_stable()) {
            (true, _) => "outside the model, without friction",
            (false, true) => "stable",
            (false, false) => "unstable",
        };
        let end_of_stick_slip = self.ends.stick_slip.map(|speed| format!("{} m/s", significant(speed)));
        let end_of_cycles = self.ends.without_sticking().map(|speed| {
            ("end of cycles", format!("{} m/s, no limit cycle above, with or without sticking", significant(speed)))
        });
        let cycle = match &self.cycle {
            Some(cycle) => format!(
                "x from {} to {} m, period {} s, {}",
                significant(cycle.tangential_min),
                significant(cycle.tangential_max),
                significant(cycle.period),
                if cycle.reaches_disc_speed {
                    format!("{:.1} % of it in stick", 100.0 * cycle.stick_fraction)
                } else {
                    "without sticking".to_owned()
                }
            ),
            None => "none at this belt speed".to_owned(),
        };
        let basin = match (&self.basin, self.basin.smallest_knock()) {
            (Basin::Everything, _) => "every motion returns to steady sliding".to_owned(),
            (Basin::Nothing, _) => "no motion returns to steady sliding".to_owned(),
            (_, Some(knock)) => format!(
                "a knock below {} m/s along the belt or {} m/s against it returns",
                significant(knock.forward),
                significant(knock.backward)
            ),
            (_, None) => "not resolved".to_owned(),
        };
        let curve = self.curve.as_ref().map(|curve| ("friction curve", curve.clone()));
        let without = self.without_friction.words().map(|words| ("friction", words));
        let rows = [
            ("belt speed", format!("{} m/s", significant(self.belt_speed))),
            (
                "steady sliding",
                format!(
                    "{stable}; x = {} m, friction coefficient {}",
                    significant(self.equilibrium.tangential),
                    significant(self.equilibrium.friction_coefficient)
                ),
            ),
            ("eigenvalues", eigenvalues),
            ("critical speed", self.critical_speed()),
            ("end of stick-slip", end_of_stick_slip.unwrap_or_else(|| "not found".to_owned())),
        ];
        let line = |(what, value): (&str, String)| format!("{what:<18} {value}\n");
        let cycle = [("limit cycle", cycle), ("basin", basin)];
        rows.into_iter().chain(end_of_cycles).chain(cycle).chain(curve).chain(without).map(line).collect()
    }
}
