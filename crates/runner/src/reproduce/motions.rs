//! Figures 5 and 7 to 11: motions in time, their phase portraits and spectra.

use std::path::Path;

use stickslip_core::criterion::settings::TimeDomainSettings;
use stickslip_core::criterion::time_domain::DiscModel;
use stickslip_core::flexible_disc::brake::DISC_MODES;
use stickslip_core::motion::moment::Moment;
use stickslip_core::motion::start::Start;
use stickslip_core::rigid_disc::pad_on_disc::{RandomInputs, Scales};
use stickslip_core::trajectory::recording::Trajectory;

use super::preset::brake_at;
use super::spectrum::{Spectrum, spectrum};
use crate::commands::{columns, simulate};
use crate::failure::Failure;
use crate::files::table::{DescribedColumn, write_columns};
use crate::picture::curves;
use crate::target::Target;
use crate::units::{duration, frequency, length, range, scales_line, significant};

/// Scaled time of a motion, some 280 cycles of the pad; the last part of it is looked at.
const HORIZON: f64 = 1000.0;
const SETTLED: f64 = 500.0;

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

const fn panel(name: &'static str, speed: f64, start: Start) -> Panel {
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
type Quantity = fn(&Moment) -> f64;

/// A quantity of a motion over its settled part.
fn settled(trajectory: &Trajectory, value: Quantity) -> Vec<f64> {
    trajectory.moments.iter().filter(|moment| moment.time >= HORIZON - SETTLED).map(value).collect()
}

/// Disc modes for spectra, more than verdicts need: it is their ringing that is shown.
const SPECTRAL_MODES: usize = 16;

/// The stick-slip motion that the paper takes its spectra of, with many disc modes.
pub const SPECTRAL: Panel = Panel { name: "stick-slip-10", speed: 10.0, start: Start::Rest, modes: SPECTRAL_MODES };

/// One of the figures: its text, and its data as files in `directory`.
pub fn figure(target: Target, directory: &Path) -> Result<String, Failure> {
    // They do not depend on the speed.
    let scales = *brake_at(SPECTRAL.speed)?.scales();
    let text = match target {
        Target::Fig5 => phase_portraits(directory, &scales),
        Target::Fig7 => tangential_motion(directory, &scales),
        Target::Fig8 => {
            let panel = panel("steady-sliding-35", 35.0, Start::Rest);
            let title = "Figure 8: the brake settles to steady sliding at 35 rad/s (start: rest)\n\n";
            relative_motion(directory, &scales, title, &panel, 0.0..150.0)
        }
        Target::Fig9 => {
            let panel = panel("stick-slip-10", 10.0, Start::Rest);
            let title = "Figure 9: stick-slip at 10 rad/s\n\n";
            relative_motion(directory, &scales, title, &panel, HORIZON - 15.0..HORIZON)
        }
        Target::Fig10 => pad_spectra(directory, &scales),
        _ => disc_vibration(directory, &scales),
    };
    Ok(text? + &scales_line(&scales))
}

/// Writes the whole time series of a panel.
fn write(directory: &Path, scales: &Scales, panel: &Panel, trajectory: &Trajectory) -> Result<String, Failure> {
    let name = format!("{}.parquet", panel.name);
    write_columns(directory, &name, &columns(&trajectory.moments, scales))?;
    Ok(format!("data: {}\n", directory.join(name).display()))
}

/// Smallest and largest value of a quantity.
fn extremes<'a>(moments: impl Iterator<Item = &'a Moment>, value: Quantity) -> (f64, f64) {
    moments.map(value).fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
}

fn phase_portraits(directory: &Path, scales: &Scales) -> Result<String, Failure> {
    let mut text = "Figure 5: phase portraits of the tangential motion, x' against x, preload 0.1\n\n".to_owned();
    for (panel, what) in [
        (panel("a-35", 35.0, Start::Rest), "35 rad/s from rest: one sliding equilibrium"),
        (panel("b-10", 10.0, Start::NearEquilibrium), "10 rad/s from near the equilibrium: one limit cycle"),
        (panel("c-20-equilibrium", 20.0, Start::NearEquilibrium), "20 rad/s from near the equilibrium: it holds"),
        (panel("c-20-rest", 20.0, Start::Rest), "20 rad/s from rest: stick-slip"),
    ] {
        let trajectory = panel.trajectory()?;
        let line: Vec<(f64, f64)> = trajectory.moments.iter().map(|m| m.tangential).collect();
        let (left, right) = extremes(trajectory.moments.iter(), |m| m.tangential.0);
        let (slowest, fastest) = extremes(trajectory.moments.iter(), |m| m.tangential.1);
        text += &format!(
            "{what}\n{}in SI: x {} mm, x' {} m/s\n{}\n",
            curves(&[line]),
            range(scales.millimetres(left), scales.millimetres(right)),
            range(scales.metres_per_second(slowest), scales.metres_per_second(fastest)),
            write(directory, scales, &panel, &trajectory)?
        );
    }
    Ok(text)
}

fn tangential_motion(directory: &Path, scales: &Scales) -> Result<String, Failure> {
    let mut text = "Figure 7: tangential motion of the pad, x against scaled time, preload 0.1\n\n".to_owned();
    for (panel, what, drawn) in [
        (panel("a-35", 35.0, Start::Rest), "35 rad/s from rest: a stable focus", 150.0),
        (panel("b-10", 10.0, Start::NearEquilibrium), "10 rad/s from near the equilibrium: a limit cycle", 60.0),
    ] {
        let trajectory = panel.trajectory()?;
        let shown = trajectory.moments.iter().filter(|moment| moment.time <= drawn);
        let line: Vec<(f64, f64)> = shown.map(|m| (m.time, m.tangential.0)).collect();
        text += &format!("{what}\n{}", curves(&[line]));
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
        text += &format!("{}\n", write(directory, scales, &panel, &trajectory)?);
    }
    text += "the paper prints x0 = 8.15e-3 at 35 rad/s (rigid disc); a flexible disc takes 3 % of the contact force\n";
    Ok(text)
}

fn relative_motion(
    directory: &Path,
    scales: &Scales,
    title: &str,
    panel: &Panel,
    drawn: std::ops::Range<f64>,
) -> Result<String, Failure> {
    let trajectory = panel.trajectory()?;
    let mut text = title.to_owned();
    let quantities: [(&str, Quantity); 4] = [
        ("sliding speed v - x', scaled", |m| m.sliding_speed),
        ("friction coefficient", |m| m.friction_coefficient),
        ("friction force, kN", |m| 1e-3 * m.friction_force),
        ("contact force, kN", |m| 1e-3 * m.contact_force),
    ];
    for (what, value) in quantities {
        let shown = trajectory.moments.iter().filter(|moment| drawn.contains(&moment.time));
        let line: Vec<(f64, f64)> = shown.map(|m| (m.time, value(m))).collect();
        text += &format!("{what}, against scaled time\n{}", curves(&[line]));
    }
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
    Ok(text)
}

/// The spectrum of a quantity over the settled part of a motion.
pub fn settled_spectrum(trajectory: &Trajectory, value: Quantity) -> Spectrum {
    spectrum(&settled(trajectory, value), trajectory.interval)
}

/// A motion that has settled has no spectrum, and the paper's still rings: the spectrum of y over the first quarter.
fn ringing_spectrum(trajectory: &Trajectory) -> Spectrum {
    let values: Vec<f64> = trajectory.moments.iter().map(|m| m.normal.0).collect();
    spectrum(&values[..values.len() / 4], trajectory.interval)
}

fn pad_spectra(directory: &Path, scales: &Scales) -> Result<String, Failure> {
    let stick_slip = SPECTRAL.trajectory()?;
    let sliding = panel("sliding-35", 35.0, Start::Rest);
    let sliding_motion = sliding.trajectory()?;
    let mut text = "Figure 10: spectra of the pad (Hz of scaled time)\n\n".to_owned();
    let x = settled_spectrum(&stick_slip, |m| m.tangential.0);
    let y = settled_spectrum(&stick_slip, |m| m.normal.0);
    let phi = settled_spectrum(&stick_slip, |m| m.angle.0);
    text += &peaks(scales, "a: x at 10 rad/s", &x, Amplitude::Length, "0.23, 0.45, 0.68");
    text += &peaks(scales, "b: y at 10 rad/s", &y, Amplitude::Length, "0.23 and its multiples, 0.29 of the disc");
    let printed = "0.23 and its multiples, 0.16 of the pad's rotation";
    text += &peaks(scales, "c: phi at 10 rad/s", &phi, Amplitude::Angle, printed);
    let ringing = ringing_spectrum(&sliding_motion);
    let what = "d: y at 35 rad/s while it settles";
    text += &peaks(scales, what, &ringing, Amplitude::Length, "0.29 of the disc");
    let spectra = [("x", Some("x_mm"), &x), ("y", Some("y_mm"), &y), ("phi", None, &phi)];
    spectra_file(directory, scales, "pad_spectra.parquet", &spectra)?;
    spectra_file(directory, scales, "sliding_spectrum.parquet", &[("y", Some("y_mm"), &ringing)])?;
    text += &write(directory, scales, &SPECTRAL, &stick_slip)?;
    text += &write(directory, scales, &sliding, &sliding_motion)?;
    text += &format!("data: {}\n", directory.join("pad_spectra.parquet").display());
    Ok(text)
}

fn disc_vibration(directory: &Path, scales: &Scales) -> Result<String, Failure> {
    let trajectory = SPECTRAL.trajectory()?;
    let edge = settled_spectrum(&trajectory, |m| m.deflection.0);
    let inside = settled_spectrum(&trajectory, |m| m.deflection.1);
    let mut text = "Figure 11: vibration of the disc at 10 rad/s, at the middle of the pad\n\n".to_owned();
    let printed = "0.29, 1.87, 5.03 of the disc, 0.23 and 0.45 of the pad";
    text += &peaks(scales, "a: outer edge", &edge, Amplitude::Length, printed);
    let what = "d: a quarter of the width from the clamped edge";
    text += &peaks(scales, what, &inside, Amplitude::Length, printed);
    let shown: Vec<&Moment> = trajectory.moments.iter().filter(|m| m.time >= HORIZON - 20.0).collect();
    let drawn: [(&str, Quantity); 2] = [
        ("b, c: deflection of the outer edge over disc thickness", |m| m.deflection.0),
        ("d: deflection a quarter of the width from the clamped edge", |m| m.deflection.1),
    ];
    for (what, value) in drawn {
        let line: Vec<(f64, f64)> = shown.iter().map(|m| (m.time, 1e3 * value(m))).collect();
        text += &format!("{what}, times 1000\n{}", curves(&[line]));
    }
    text += &format!(
        "{SPECTRAL_MODES} disc modes are kept here, those of lowest frequency. The disc starts deflected as in steady sliding, and\n\
        what rings dies away before the part of the motion that is looked at.\n"
    );
    let spectra = [
        ("deflection_edge", Some("deflection_edge_mm"), &edge),
        ("deflection_inside", Some("deflection_inside_mm"), &inside),
    ];
    spectra_file(directory, scales, "disc_spectra.parquet", &spectra)?;
    text += &write(directory, scales, &SPECTRAL, &trajectory)?;
    text += &format!("data: {}\n", directory.join("disc_spectra.parquet").display());
    Ok(text)
}

/// What the amplitudes of a spectrum are.
#[derive(Clone, Copy)]
enum Amplitude {
    /// Over the thickness of the disc.
    Length,
    /// In rad.
    Angle,
}

/// The highest peaks of a spectrum, in scaled units and SI, beside what the paper prints.
fn peaks(scales: &Scales, what: &str, spectrum: &Spectrum, amplitude: Amplitude, printed: &str) -> String {
    let found = spectrum.peaks(6, 1e-4);
    let scaled: Vec<String> = found.iter().map(|(f, a)| format!("{f:.3} Hz ({a:.1e})")).collect();
    let in_kilohertz: Vec<String> = found.iter().map(|peak| significant(1e-3 * scales.hertz(peak.0))).collect();
    let highest = found.first().map_or(0.0, |peak| peak.1);
    let highest = match amplitude {
        Amplitude::Length => format!("{:.1e} mm", scales.millimetres(highest)),
        Amplitude::Angle => format!("{highest:.1e} rad"),
    };
    format!(
        "{what}\n    {}\n    in SI: {} kHz (the first {highest})\n    the paper prints {printed}\n",
        scaled.join(", "),
        in_kilohertz.join(", ")
    )
}

/// Writes spectra of the same frequencies: names of their columns, the second of them in mm.
fn spectra_file(
    directory: &Path,
    scales: &Scales,
    name: &str,
    spectra: &[(&'static str, Option<&'static str>, &Spectrum)],
) -> Result<(), Failure> {
    let frequencies = spectra.first().map_or(&[][..], |(_, _, spectrum)| &spectrum.frequencies);
    let mut columns = vec![DescribedColumn {
        name: "frequency_hz",
        unit: "Hz",
        long_name: "frequency, Hz of scaled time",
        values: frequencies.to_vec(),
    }];
    columns.extend(spectra.iter().map(|(name, in_mm, spectrum)| DescribedColumn {
        name,
        unit: if in_mm.is_some() { "1" } else { "rad" },
        long_name: "amplitude (Hann window)",
        values: spectrum.amplitudes.clone(),
    }));
    columns.push(DescribedColumn {
        name: "frequency_khz",
        unit: "kHz",
        long_name: "frequency in SI, not of scaled time",
        values: frequencies.iter().map(|&frequency| 1e-3 * scales.hertz(frequency)).collect(),
    });
    columns.extend(spectra.iter().filter_map(|(_, in_mm, spectrum)| {
        Some(DescribedColumn {
            name: (*in_mm)?,
            unit: "mm",
            long_name: "amplitude (Hann window)",
            values: spectrum.amplitudes.iter().map(|&amplitude| scales.millimetres(amplitude)).collect(),
        })
    }));
    write_columns(directory, name, &columns)
}
