//! Figures 10 and 11: spectra of the pad, and the vibration of the disc.

use std::path::Path;

use stickslip_core::models::pad_on_disc::motion::moment::Moment;
use stickslip_core::models::pad_on_disc::motion::start::Start;
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::Scales;
use stickslip_core::models::pad_on_disc::trajectory::recording::Trajectory;

use super::motions::{HORIZON, Quantity, SETTLED, SPECTRAL, SPECTRAL_MODES, history, panel, write};
use super::part::Part;
use super::preset::brake_at;
use crate::commands::scales_line;
use crate::failure::Failure;
use crate::files::table::{DescribedColumn, write_columns};
use crate::picture::chart::{Chart, ChartAxis, Marks, Series};
use crate::picture::scale::Scale;
use crate::spectrum::{Spectrum, spectrum};
use crate::target::Target;
use crate::units::{frequency, significant};

/// Frequencies that the paper prints, Hz of scaled time: of the pad and its multiples, of the pad's rotation, of the
/// disc.
const PAD: [f64; 3] = [0.23, 0.45, 0.68];
const ROTATION: f64 = 0.16;
const DISC: [f64; 3] = [0.29, 1.87, 5.03];

/// Highest frequencies that are drawn, Hz of scaled time.
const HIGHEST_OF_PAD: f64 = 2.0;
const HIGHEST_OF_DISC: f64 = 6.0;

/// Smallest amplitude that is drawn, over the largest.
const LEAST_SHARE: f64 = 1e-5;

/// The spectrum of a quantity over the settled part of a motion.
pub fn settled_spectrum(trajectory: &Trajectory, value: Quantity) -> Spectrum {
    let settled = trajectory.moments.iter().filter(|moment| moment.time >= HORIZON - SETTLED);
    spectrum(&settled.map(value).collect::<Vec<f64>>(), trajectory.interval)
}

/// A motion that has settled has no spectrum, and the paper's still rings: the spectrum of y over the first quarter.
fn ringing_spectrum(trajectory: &Trajectory) -> Spectrum {
    let values: Vec<f64> = trajectory.moments.iter().map(|m| m.normal.0).collect();
    spectrum(&values[..values.len() / 4], trajectory.interval)
}

/// What the amplitudes of a spectrum are.
#[derive(Clone, Copy)]
enum Amplitude {
    /// Over the thickness of the disc.
    Length,
    /// In rad.
    Angle,
}

/// A spectrum with what the paper prints of it.
struct Shown<'a> {
    title: &'a str,
    /// What moves.
    of: &'a str,
    spectrum: &'a Spectrum,
    amplitude: Amplitude,
    highest: f64,
    /// Frequencies, and what is said of them.
    printed: &'a [f64],
    says: &'a str,
}

impl Shown<'_> {
    fn parts(&self, scales: &Scales) -> [Part; 2] {
        let points = self.spectrum.frequencies.iter().copied().zip(self.spectrum.amplitudes.iter().copied());
        let points: Vec<(f64, f64)> = points.filter(|point| point.0 <= self.highest).collect();
        let largest = points.iter().fold(0.0, |largest: f64, point| largest.max(point.1)).max(f64::MIN_POSITIVE);
        let unit = match self.amplitude {
            Amplitude::Length => "",
            Amplitude::Angle => "rad",
        };
        let mut chart = Chart::new(
            self.title,
            ChartAxis::new(
                &format!("Frequency, Hz of scaled time (1 Hz is {})", frequency(scales.hertz(1.0))),
                "",
                Scale::linear(0.0, self.highest),
            ),
            ChartAxis::new(
                &format!("Amplitude of {}", self.of),
                unit,
                Scale::logarithmic(LEAST_SHARE * largest, 2.0 * largest),
            ),
            vec![Series::line(points)],
        );
        chart.marks = Some(Marks { what: "printed in the paper".to_owned(), values: self.printed.to_vec() });
        [Part::chart(chart), Part::Text(self.peaks(scales))]
    }

    /// The highest peaks, in scaled units and SI, beside what the paper prints.
    fn peaks(&self, scales: &Scales) -> String {
        let found = self.spectrum.peaks(6, 1e-4);
        let scaled: Vec<String> = found.iter().map(|(f, _)| format!("{f:.3}")).collect();
        let in_kilohertz: Vec<String> = found.iter().map(|peak| significant(1e-3 * scales.hertz(peak.0))).collect();
        let highest = found.first().map_or(0.0, |peak| peak.1);
        let highest = match self.amplitude {
            Amplitude::Length => format!("{:.1e} mm", scales.millimetres(highest)),
            Amplitude::Angle => format!("{highest:.1e} rad"),
        };
        format!(
            "highest peaks: {} Hz\n    in SI: {} kHz (the first {highest})\n    the paper prints {}\n\n",
            scaled.join(", "),
            in_kilohertz.join(", "),
            self.says
        )
    }
}

/// Figure 10 or 11, and its data as files in `directory`.
pub fn figure(target: Target, directory: &Path) -> Result<Vec<Part>, Failure> {
    // They do not depend on the speed.
    let scales = *brake_at(SPECTRAL.speed)?.scales();
    let mut parts = if target == Target::Fig10 { of_pad(directory, &scales)? } else { of_disc(directory, &scales)? };
    parts.push(Part::Text(scales_line(&scales)));
    Ok(parts)
}

fn of_pad(directory: &Path, scales: &Scales) -> Result<Vec<Part>, Failure> {
    let stick_slip = SPECTRAL.trajectory()?;
    let sliding = panel("sliding-35", 35.0, Start::Rest);
    let sliding_motion = sliding.trajectory()?;
    let x = settled_spectrum(&stick_slip, |m| m.tangential.0);
    let y = settled_spectrum(&stick_slip, |m| m.normal.0);
    let phi = settled_spectrum(&stick_slip, |m| m.angle.0);
    let ringing = ringing_spectrum(&sliding_motion);
    let [first, second, third] = PAD;
    let shown = |title, of, spectrum, amplitude, printed, says| Shown {
        title,
        of,
        spectrum,
        amplitude,
        highest: HIGHEST_OF_PAD,
        printed,
        says,
    };
    let mut parts = vec![Part::text("Figure 10: spectra of the pad\n\n")];
    for spectrum in [
        shown("a: x at 10 rad/s", "x over h", &x, Amplitude::Length, &PAD, "0.23, 0.45, 0.68"),
        shown(
            "b: y at 10 rad/s",
            "y over h",
            &y,
            Amplitude::Length,
            &[first, DISC[0], second, third],
            "0.23 and its multiples, 0.29 of the disc",
        ),
        shown(
            "c: phi at 10 rad/s",
            "phi",
            &phi,
            Amplitude::Angle,
            &[ROTATION, first, second, third],
            "0.23 and its multiples, 0.16 of the pad's rotation",
        ),
        shown(
            "d: y at 35 rad/s while it settles",
            "y over h",
            &ringing,
            Amplitude::Length,
            &DISC[..1],
            "0.29 of the disc",
        ),
    ] {
        parts.extend(spectrum.parts(scales));
    }
    let spectra = [("x", Some("x_mm"), &x), ("y", Some("y_mm"), &y), ("phi", None, &phi)];
    write_spectra(directory, scales, "pad_spectra.parquet", &spectra)?;
    write_spectra(directory, scales, "sliding_spectrum.parquet", &[("y", Some("y_mm"), &ringing)])?;
    let mut text = write(directory, scales, &SPECTRAL, &stick_slip)?;
    text += &write(directory, scales, &sliding, &sliding_motion)?;
    text += &format!("data: {}\n", directory.join("pad_spectra.parquet").display());
    parts.push(Part::Text(text));
    Ok(parts)
}

fn of_disc(directory: &Path, scales: &Scales) -> Result<Vec<Part>, Failure> {
    let trajectory = SPECTRAL.trajectory()?;
    let edge = settled_spectrum(&trajectory, |m| m.deflection.0);
    let inside = settled_spectrum(&trajectory, |m| m.deflection.1);
    let printed = [PAD[0], DISC[0], PAD[1], DISC[1], DISC[2]];
    let shown = |title, spectrum| Shown {
        title,
        of: "the deflection over h",
        spectrum,
        amplitude: Amplitude::Length,
        highest: HIGHEST_OF_DISC,
        printed: &printed,
        says: "0.29, 1.87, 5.03 of the disc, 0.23 and 0.45 of the pad",
    };
    let mut parts = vec![Part::text("Figure 11: vibration of the disc at 10 rad/s, at the middle of the pad\n\n")];
    parts.extend(shown("a: outer edge", &edge).parts(scales));
    parts.extend(shown("d: a quarter of the width from the clamped edge", &inside).parts(scales));
    let late = HORIZON - 20.0..HORIZON;
    let drawn: [(&str, Quantity); 2] = [
        ("b, c: outer edge", |m| m.deflection.0),
        ("d: a quarter of the width from the clamped edge", |m| m.deflection.1),
    ];
    for (what, value) in drawn {
        let values: Vec<f64> = trajectory.moments.iter().filter(|m| late.contains(&m.time)).map(value).collect();
        let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
        let what = format!("{what}, mean {mean:.3e}");
        let deviation = |moment: &Moment| value(moment) - mean;
        parts.push(Part::chart(history(&what, "Deflection over h - mean", "", &trajectory, &late, deviation)));
    }
    let mut text = format!(
        "{SPECTRAL_MODES} disc modes are kept here, those of lowest frequency. The disc starts\n\
         deflected as in steady sliding, and what rings dies away before the part of the\n\
         motion that is looked at.\n"
    );
    let spectra = [
        ("deflection_edge", Some("deflection_edge_mm"), &edge),
        ("deflection_inside", Some("deflection_inside_mm"), &inside),
    ];
    write_spectra(directory, scales, "disc_spectra.parquet", &spectra)?;
    text += &write(directory, scales, &SPECTRAL, &trajectory)?;
    text += &format!("data: {}\n", directory.join("disc_spectra.parquet").display());
    parts.push(Part::Text(text));
    Ok(parts)
}

/// Writes spectra of the same frequencies: names of their columns, the second of them in mm.
fn write_spectra(
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
