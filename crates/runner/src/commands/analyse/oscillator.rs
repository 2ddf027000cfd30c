//! A friction oscillator on a belt at one point, by the pad on a rigid disc that moves as it does: metres and seconds.

use serde_json::{Value, json};
use stickslip_core::models::pad_on_disc::rigid_disc::basin::Basin;
use stickslip_core::models::pad_on_disc::rigid_disc::cycle_ranges::CycleRanges;
use stickslip_core::models::pad_on_disc::rigid_disc::limit_cycle::LimitCycle;
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
    /// Where there are limit cycles.
    cycles: CycleRanges,
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
            cycles: pad.cycle_ranges(),
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
            "unstable_speeds": pairs(&self.unstable_speeds),
            "stick_slip_speeds": pairs(&self.cycles.stick_slip),
            "sliding_cycle_speeds": pairs(&self.cycles.without_sticking),
            "unresolved_speeds": pairs(&self.cycles.unresolved),
            "end_of_stick_slip": self.cycles.end_of_stick_slip(),
            "end_of_cycles": self.cycles.end_of_cycles(),
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
            ref several => format!("unstable {}", listed(several)),
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
        let stick_slip = match *self.cycles.stick_slip {
            [] => "none at any belt speed".to_owned(),
            ref ranges => listed(ranges),
        };
        let CycleRanges { without_sticking, unresolved, .. } = &self.cycles;
        let sliding = ("without sticking", format!("a limit cycle {}", listed(without_sticking)));
        let sliding = (!without_sticking.is_empty()).then_some(sliding);
        let not_resolved = format!("limit cycles {}: too stiff for the method, or too slow", listed(unresolved));
        let not_resolved = ("not resolved", not_resolved);
        let not_resolved = (!unresolved.is_empty()).then_some(not_resolved);
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
            ("stick-slip", stick_slip),
        ];
        let line = |(what, value): (&str, String)| format!("{what:<18} {value}\n");
        let cycle = [("limit cycle", cycle), ("basin", basin)];
        let ranges = sliding.into_iter().chain(not_resolved);
        rows.into_iter().chain(ranges).chain(cycle).chain(curve).chain(without).map(line).collect()
    }
}

/// Ranges for JSON.
fn pairs(ranges: &[SpeedRange]) -> Vec<[f64; 2]> {
    ranges.iter().map(|range| [range.from, range.to]).collect()
}

/// Ranges in words.
fn listed(ranges: &[SpeedRange]) -> String {
    let in_words = |&SpeedRange { from, to }: &SpeedRange| match (from == 0.0, to.is_infinite()) {
        (true, true) => "at every belt speed".to_owned(),
        (true, false) => format!("below {} m/s", significant(to)),
        (false, true) => format!("above {} m/s", significant(from)),
        (false, false) => match [from, to].map(significant) {
            [from, to] if from == to => format!("next to {from} m/s"),
            [from, to] => format!("from {from} to {to} m/s"),
        },
    };
    ranges.iter().map(in_words).collect::<Vec<_>>().join(", ")
}
