//! Figures 5 and 7 to 9: motions in time and their phase portraits.

use std::ops::Range;
use std::path::Path;

use stickslip_core::models::pad_on_disc::criterion::settings::TimeDomainSettings;
use stickslip_core::models::pad_on_disc::criterion::time_domain::DiscModel;
use stickslip_core::models::pad_on_disc::flexible_disc::brake::DISC_MODES;
use stickslip_core::models::pad_on_disc::motion::moment::Moment;
use stickslip_core::models::pad_on_disc::motion::start::Start;
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::{RandomInputs, Scales};
use stickslip_core::models::pad_on_disc::trajectory::recording::Trajectory;

use super::part::Part;
use super::preset::brake_at;
use crate::commands::scales_line;
use crate::commands::{columns, simulate};
use crate::failure::Failure;
use crate::files::table::write_columns;
use crate::picture::chart::{Chart, ChartAxis, Series};
use crate::picture::scale::Scale;
use crate::target::Target;
use crate::units::{duration, frequency, length, range};

/// Scaled time of a motion, some 280 cycles of the pad; the last part of it is looked at.
pub const HORIZON: f64 = 1000.0;
pub const SETTLED: f64 = 500.0;

/// One motion of a figure.
pub struct Panel {
    /// In the name of its file.
    pub name: &'static str,
    /// rad/s.
    pub speed: f64,
    /// Where it starts.
    pub start: Start,
    /// Disc modes that are kept.
    pub modes: usize,
}

pub const fn panel(name: &'static str, speed: f64, start: Start) -> Panel {
    Panel { name, speed, start, modes: DISC_MODES }
}

impl Panel {
    /// Simulates the motion.
    pub fn trajectory(&self) -> Result<Trajectory, Failure> {
        let brake = brake_at(self.speed)?;
        let parameters = brake.parameters();
        let inputs = RandomInputs {
            preload: parameters.operating_point.preload,
            static_friction: parameters.friction.static_coefficient,
        };
        let settings = TimeDomainSettings { start: self.start, ..TimeDomainSettings::default() };
        simulate(&brake, &DiscModel::Flexible { modes: self.modes }, settings, inputs, Some(HORIZON))
    }
}

/// A quantity of a motion.
pub type Quantity = fn(&Moment) -> f64;

/// Disc modes for spectra, more than verdicts need: it is their ringing that is shown.
pub const SPECTRAL_MODES: usize = 16;

/// The stick-slip motion that the paper takes its spectra of, with many disc modes.
pub const SPECTRAL: Panel = Panel { name: "stick-slip-10", speed: 10.0, start: Start::Rest, modes: SPECTRAL_MODES };

/// One of the figures, and its data as files in `directory`.
pub fn figure(target: Target, directory: &Path) -> Result<Vec<Part>, Failure> {
    // They do not depend on the speed.
    let scales = *brake_at(SPECTRAL.speed)?.scales();
    let mut parts = match target {
        Target::Fig5 => phase_portraits(directory, &scales)?,
        Target::Fig7 => tangential_motion(directory, &scales)?,
        Target::Fig8 => {
            let panel = panel("steady-sliding-35", 35.0, Start::Rest);
            let title = "Figure 8: the brake settles to steady sliding at 35 rad/s (start: rest)\n\n";
            relative_motion(directory, &scales, title, &panel, 0.0..60.0)?
        }
        _ => {
            let panel = panel("stick-slip-10", 10.0, Start::Rest);
            let title = "Figure 9: stick-slip at 10 rad/s\n\n";
            relative_motion(directory, &scales, title, &panel, HORIZON - 15.0..HORIZON)?
        }
    };
    parts.push(Part::Text(scales_line(&scales)));
    Ok(parts)
}

/// A quantity of a motion over scaled time, within a part of it.
pub fn history(
    title: &str,
    name: &str,
    unit: &str,
    motion: &Trajectory,
    drawn: &Range<f64>,
    value: impl Fn(&Moment) -> f64,
) -> Chart {
    let shown = motion.moments.iter().filter(|moment| drawn.contains(&moment.time));
    let points: Vec<(f64, f64)> = shown.map(|moment| (moment.time, value(moment))).collect();
    Chart::new(
        title,
        ChartAxis::new("Scaled time", "", Scale::linear(drawn.start, drawn.end)),
        ChartAxis::new(name, unit, Scale::around(points.iter().map(|point| point.1))),
        vec![Series::line(points)],
    )
}

/// Writes the whole time series of a panel.
pub fn write(directory: &Path, scales: &Scales, panel: &Panel, trajectory: &Trajectory) -> Result<String, Failure> {
    let name = format!("{}.parquet", panel.name);
    write_columns(directory, &name, &columns(&trajectory.moments, scales))?;
    Ok(format!("data: {}\n", directory.join(name).display()))
}

/// Smallest and largest value of a quantity.
fn extremes<'a>(moments: impl Iterator<Item = &'a Moment>, value: Quantity) -> (f64, f64) {
    moments.map(value).fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
}

/// Scaled time of the phase portraits: some fifty cycles; longer, their lines cover each other.
const PORTRAIT: f64 = 180.0;

fn phase_portraits(directory: &Path, scales: &Scales) -> Result<Vec<Part>, Failure> {
    let mut parts = vec![Part::text("Figure 5: phase portraits of the tangential motion, preload 0.1\n\n")];
    for (panel, what) in [
        (panel("a-35", 35.0, Start::Rest), "a: 35 rad/s from rest: one sliding equilibrium"),
        (panel("b-10", 10.0, Start::NearEquilibrium), "b: 10 rad/s from near the equilibrium: one limit cycle"),
        (panel("c-20-equilibrium", 20.0, Start::NearEquilibrium), "c: 20 rad/s from near the equilibrium: it holds"),
        (panel("c-20-rest", 20.0, Start::Rest), "c: 20 rad/s from rest: stick-slip"),
    ] {
        let trajectory = panel.trajectory()?;
        let shown: Vec<&Moment> = trajectory.moments.iter().filter(|moment| moment.time <= PORTRAIT).collect();
        let line: Vec<(f64, f64)> = shown.iter().map(|moment| moment.tangential).collect();
        let (left, right) = extremes(shown.iter().copied(), |m| m.tangential.0);
        let (slowest, fastest) = extremes(shown.iter().copied(), |m| m.tangential.1);
        parts.push(Part::chart(Chart::new(
            what,
            ChartAxis::new("Displacement x over h", "", Scale::around([left, right].into_iter())),
            ChartAxis::new("Velocity x′, scaled", "", Scale::around([slowest, fastest].into_iter())),
            vec![Series::line(line)],
        )));
        parts.push(Part::Text(format!(
            "in SI: x {} mm, x' {} m/s\n{}\n",
            range(scales.millimetres(left), scales.millimetres(right)),
            range(scales.metres_per_second(slowest), scales.metres_per_second(fastest)),
            write(directory, scales, &panel, &trajectory)?
        )));
    }
    Ok(parts)
}

fn tangential_motion(directory: &Path, scales: &Scales) -> Result<Vec<Part>, Failure> {
    let mut parts = vec![Part::text("Figure 7: tangential motion of the pad, preload 0.1\n\n")];
    for (panel, what, drawn) in [
        (panel("a-35", 35.0, Start::Rest), "a: 35 rad/s from rest: a stable focus", 60.0),
        (panel("b-10", 10.0, Start::NearEquilibrium), "b: 10 rad/s from near the equilibrium: a limit cycle", 60.0),
    ] {
        let trajectory = panel.trajectory()?;
        let displacement = "Displacement x over h";
        parts.push(Part::chart(history(what, displacement, "", &trajectory, &(0.0..drawn), |m| m.tangential.0)));
        let mut text = String::new();
        if let Some(settled) = trajectory.settled {
            text += &format!(
                "settled: x from {:.6} to {:.6}, mean {:.6}",
                settled.tangential_min, settled.tangential_max, settled.tangential_mean
            );
            text += &settled.period.map_or("\n".to_owned(), |period| format!(", period {period:.5}\n"));
            text += &format!(
                "in SI: x {} mm, mean {}",
                range(scales.millimetres(settled.tangential_min), scales.millimetres(settled.tangential_max)),
                length(scales.metres(settled.tangential_mean))
            );
            text += &settled.period.map_or("\n".to_owned(), |period| {
                let seconds = scales.seconds(period);
                format!(", period {} ({})\n", duration(seconds), frequency(1.0 / seconds))
            });
        }
        parts.push(Part::Text(format!("{text}{}\n", write(directory, scales, &panel, &trajectory)?)));
    }
    parts.push(Part::text(
        "the paper prints x0 = 8.15e-3 at 35 rad/s (rigid disc); a flexible disc takes\n3 % of the contact force\n",
    ));
    Ok(parts)
}

fn relative_motion(
    directory: &Path,
    scales: &Scales,
    title: &str,
    panel: &Panel,
    drawn: Range<f64>,
) -> Result<Vec<Part>, Failure> {
    let trajectory = panel.trajectory()?;
    let mut parts = vec![Part::text(title)];
    let quantities: [(&str, &str, &str, Quantity); 4] = [
        ("a: sliding speed v - x′", "Sliding speed, scaled", "", |m| m.sliding_speed),
        ("b: friction coefficient", "Friction coefficient", "", |m| m.friction_coefficient),
        ("c: friction force", "Friction force", "kN", |m| 1e-3 * m.friction_force),
        ("d: contact force", "Contact force", "kN", |m| 1e-3 * m.contact_force),
    ];
    for (what, name, unit, value) in quantities {
        parts.push(Part::chart(history(what, name, unit, &trajectory, &drawn, value)));
    }
    let mut text = String::new();
    if let Some(last) = trajectory.moments.last() {
        text += &format!("at the end: friction coefficient {:.5}\n", last.friction_coefficient);
    }
    let shown = trajectory.moments.iter().filter(|moment| drawn.contains(&moment.time));
    let (slowest, fastest) = extremes(shown, |m| m.sliding_speed);
    text += &format!(
        "in SI: sliding speed {} m/s, {} of motion\n",
        range(scales.metres_per_second(slowest), scales.metres_per_second(fastest)),
        duration(scales.seconds(drawn.end - drawn.start))
    );
    text += &write(directory, scales, panel, &trajectory)?;
    parts.push(Part::Text(text));
    Ok(parts)
}
