//! What `analyse` says in the terminal.

use std::f64::consts::TAU;

use stickslip_core::models::pad_on_disc::degree_of_freedom::DegreeOfFreedom;
use stickslip_core::models::pad_on_disc::rigid_disc::basin::{Basin, Knock};
use stickslip_core::models::pad_on_disc::rigid_disc::stability::SpeedRange;
use stickslip_core::numerics::eigenvalues::Eigenvalue;

use super::point::{Analysis, Coupled};
use crate::commands::motion_report::scales_line;
use crate::job::measured_friction::described;
use crate::picture::view::rounded;
use crate::units::{duration, force, frequency, growth_rate, length, range, row, significant, speed};

impl Analysis {
    /// Everything in words.
    pub fn text(&self) -> String {
        let parameters = self.brake.parameters();
        format!(
            "Steady sliding at {} rad/s, preload {}, static friction {}: {}\n\n{}\n{}\n{}\n{}",
            rounded(parameters.operating_point.rotating_speed),
            rounded(parameters.operating_point.preload),
            rounded(parameters.friction.static_coefficient),
            if self.without_friction.steady {
                "outside the model, without friction".to_owned()
            } else {
                headline(self.stable, self.coupled.as_ref().ok())
            },
            self.sliding_text(),
            self.modes_text(),
            self.limits_text(),
            scales_line(self.brake.scales())
        )
    }

    /// The equilibrium.
    fn sliding_text(&self) -> String {
        let (scales, point) = (self.brake.scales(), &self.brake.parameters().operating_point);
        let equilibrium = &self.equilibrium;
        row("", "scaled", "SI")
            + &row(
                "speed under pad",
                &format!("{:.6e}", self.brake.disc_speed()),
                &speed(self.brake.speed_under_pad(point.rotating_speed)),
            )
            + &row("preload", &rounded(point.preload), &length(scales.metres(point.preload)))
            + &row("friction mu0", &format!("{:.5}", equilibrium.friction_coefficient), "")
            + &self.curve_text()
            + "Steady sliding on a rigid disc\n"
            + &row("  contact force", "", &format!("{:.1} N", scales.newtons(equilibrium.normal_force)))
            + &self.displacements_text([equilibrium.tangential, equilibrium.normal, equilibrium.angle])
    }

    /// The displacements of an equilibrium: x and y over h, and phi in rad.
    fn displacements_text(&self, [x, y, phi]: [f64; 3]) -> String {
        let metres = |value: f64| length(self.brake.scales().metres(value));
        row("  equilibrium x0", &format!("{x:.6e}"), &metres(x))
            + &row("  equilibrium y0", &format!("{y:.6e}"), &metres(y))
            + &row("  equilibrium phi0", "", &format!("{phi:.6e} rad"))
    }

    /// How long a measured friction curve is, how often it falls and rises, and where it is at or below 0; nothing of another
    /// law.
    fn curve_text(&self) -> String {
        let curve = self.brake.parameters().friction.law.table();
        let lines = [
            curve.map(|curve| format!("friction curve     {}\n", described(curve))),
            self.without_friction.words().map(|words| format!("friction           {words}\n")),
        ];
        lines.into_iter().flatten().collect()
    }

    /// Frequencies and growth rates of small motions.
    fn modes_text(&self) -> String {
        let scales = self.brake.scales();
        let mut text = "Small motions of the pad on a rigid disc, eigenvalues\n".to_owned();
        let [x, x_slower, y, y_slower, phi, phi_slower] = self.brake.sliding_eigenvalues();
        for (label, first, second) in
            [("  tangential, x", x, x_slower), ("  normal, y", y, y_slower), ("  rotation, phi", phi, phi_slower)]
        {
            let rate = |value: Eigenvalue| growth_rate(scales.per_second(value.re));
            text += &if first.im > 0.0 {
                row(
                    label,
                    &format!("{:+.6} +- {:.6} i", first.re, first.im),
                    &format!("{}, growth rate {}", frequency(scales.hertz(first.im / TAU)), rate(first)),
                )
            } else {
                row(
                    label,
                    &format!("{:+.6}, {:+.6}", first.re, second.re),
                    &format!("no oscillation, growth rates {}, {}", rate(first), rate(second)),
                )
            };
        }
        text += &match &self.coupled {
            Ok(Coupled { equilibrium, growth_rate: rate, modes, .. }) => {
                format!("Pad and flexible disc together, {modes} disc modes\n")
                    + &self.displacements_text(*equilibrium)
                    + &row("  fastest growth", &format!("{rate:+.6}"), &growth_rate(scales.per_second(*rate)))
            }
            Err(error) => format!("Pad and flexible disc together: {error}\n"),
        };
        if !self.disc_frequencies.is_empty() {
            let kilohertz: Vec<String> = self.disc_frequencies.iter().map(|hertz| significant(1e-3 * hertz)).collect();
            text += &format!(
                "Disc alone, lowest mode with 0 to {} nodal diameters\n                   {} kHz\n",
                kilohertz.len() - 1,
                kilohertz.join(", ")
            );
        }
        text
    }

    /// Where steady sliding, stick-slip and limit cycles begin and end.
    fn limits_text(&self) -> String {
        let scales = self.brake.scales();
        let in_m_s = |rad_s: f64| speed(self.brake.speed_under_pad(rad_s));
        let mut text = match *self.unstable_speeds {
            [] => "critical speed     none: steady sliding is stable at every speed\n".to_owned(),
            [speeds] if speeds.to.is_infinite() => "critical speed     none: unstable at every speed\n".to_owned(),
            [SpeedRange { from, to }] if from > 0.0 => format!(
                "critical speed     {to:.4} rad/s, unstable down to {from:.4} rad/s ({} and {} under the pad)\n",
                in_m_s(to),
                in_m_s(from)
            ),
            [SpeedRange { to, .. }] => {
                format!("critical speed     {to:.4} rad/s, unstable below ({} under the pad)\n", in_m_s(to))
            }
            ref several => several
                .iter()
                .map(|SpeedRange { from, to }| {
                    let (low, high) = (in_m_s(*from), in_m_s(*to));
                    format!("unstable           from {from:.4} to {to:.4} rad/s ({low} to {high} under the pad)\n")
                })
                .collect(),
        };
        text += &match self.ends.stick_slip {
            None if self.limit_cycle.is_some_and(|cycle| cycle.reaches_disc_speed) => {
                "saddle-node        none: stick-slip at every speed\n".to_owned()
            }
            None if !self.stable && self.limit_cycle.is_none() => {
                "saddle-node        not found: the motion is too stiff for the method\n".to_owned()
            }
            None => "saddle-node        none found\n".to_owned(),
            Some(speed) => format!(
                "saddle-node        {speed:.4} rad/s, no stick-slip limit cycle above ({} under the pad)\n",
                in_m_s(speed)
            ),
        };
        if let Some(speed) = self.ends.without_sticking() {
            text += &format!(
                "end of cycles      {speed:.4} rad/s, no limit cycle above, with or without sticking ({} under the pad)\n",
                in_m_s(speed)
            );
        }
        text += &match self.limit_cycle {
            None if !self.stable => "limit cycle        not found: the motion is too stiff for the method\n".to_owned(),
            None => "limit cycle        none at this speed\n".to_owned(),
            Some(cycle) => {
                let (low, high) = (cycle.tangential_min, cycle.tangential_max);
                let cycles = 1.0 / cycle.period;
                let stick = if cycle.reaches_disc_speed {
                    format!("{:.1} % of the period", 100.0 * cycle.stick_fraction)
                } else {
                    "none: a cycle without sticking".to_owned()
                };
                row(
                    "limit cycle, x",
                    &format!("{low:.6} to {high:.6}"),
                    &format!("{} mm", range(scales.millimetres(low), scales.millimetres(high))),
                ) + &row("  period", &format!("{:.5}", cycle.period), &duration(scales.seconds(cycle.period)))
                    + &row("  frequency", &format!("{cycles:.4}"), &frequency(scales.hertz(cycles)))
                    + &row("  stick", &stick, "")
            }
        };
        text += &self.knock_text();
        text += &format!("critical friction  {} at this preload and speed\n", finite(self.critical_static_friction));
        let force = if self.critical_preload.is_finite() {
            let displacement = scales.metres(self.critical_preload);
            format!(" ({}, {})", length(displacement), force(self.brake.contact_force(self.critical_preload)))
        } else {
            String::new()
        };
        text + &format!("critical preload   {} at this friction and speed{force}\n", finite(self.critical_preload))
    }

    /// How hard a knock has to be to end steady sliding.
    fn knock_text(&self) -> String {
        let scales = self.brake.scales();
        let (knock, area) = match (self.basin.smallest_knock(), self.basin.area()) {
            _ if self.basin == Basin::Nothing => {
                return "smallest knock     0: steady sliding is unstable\n".to_owned();
            }
            (Some(knock), Some(area)) => (knock, area),
            _ if self.basin == Basin::Everything => {
                return "smallest knock     none: the pad returns to steady sliding from any motion\n".to_owned();
            }
            _ => return "smallest knock     not found: the motion is too stiff for the method\n".to_owned(),
        };
        let Knock { forward, backward, outward, inward } = knock;
        let in_m_s = |value: f64| significant(scales.metres_per_second(value));
        let in_mm = |value: f64| significant(scales.millimetres(value));
        "smallest knock     in the direction of the disc's motion, and against it\n".to_owned()
            + &row(
                "  change of speed",
                &format!("{forward:.6e}, {backward:.6e}"),
                &format!("{}, {} m/s", in_m_s(forward), in_m_s(backward)),
            )
            + &row(
                "  displacement",
                &format!("{outward:.6e}, {inward:.6e}"),
                &format!("{}, {} mm", in_mm(outward), in_mm(inward)),
            )
            + &row(
                "  area of basin",
                &format!("{area:.6e}"),
                &format!("{} m^2/s", significant(scales.square_metres_per_second(area))),
            )
    }
}

/// One verdict where both discs agree, else both.
fn headline(stable_on_rigid_disc: bool, coupled: Option<&Coupled>) -> String {
    let word = |stable: bool| if stable { "stable" } else { "UNSTABLE" };
    let rigid = word(stable_on_rigid_disc);
    let Some(coupled) = coupled else { return format!("{rigid} on a rigid disc") };
    match coupled.fed_by() {
        None if stable_on_rigid_disc => rigid.to_owned(),
        Some(DegreeOfFreedom::Tangential) if !stable_on_rigid_disc => rigid.to_owned(),
        None => format!("{rigid} on a rigid disc, stable on the flexible one"),
        Some(freedom) => format!("{rigid} on a rigid disc, UNSTABLE on the flexible one, fed by the {freedom}"),
    }
}

fn finite(value: f64) -> String {
    match value {
        _ if !value.is_finite() => "none".to_owned(),
        _ if value < 1e6 => format!("{value:.5}"),
        _ => format!("{value:.5e}"),
    }
}
