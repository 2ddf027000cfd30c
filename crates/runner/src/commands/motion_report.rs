//! What `trajectory` and `replay` say of a motion, in scaled units and SI, and the columns of its time series.

use serde_json::{Map, Value, json};
use stickslip_core::model::verdict::Verdict;
use stickslip_core::models::pad_on_disc::motion::moment::Moment;
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs, Scales};
use stickslip_core::models::pad_on_disc::trajectory::recording::Trajectory;
use stickslip_core::models::pad_on_disc::trajectory::settled::{Outcome, SettledMotion};

use crate::cli::MotionArguments;
use crate::failure::Failure;
use crate::files::table::{DescribedColumn, write_columns};
use crate::output::{output_file, result, shown};
use crate::picture::chart::{Chart, ChartAxis, Series};
use crate::picture::scale::Scale;
use crate::picture::terminal::drawn;
use crate::units::{duration, frequency, length, range, row, significant, speed};

/// Scaled time at the end of a trajectory that is drawn: some five cycles of the pad.
const DRAWN: f64 = 18.0;

/// A verdict in words.
pub fn name(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Stable => "stable",
        Verdict::Unstable => "unstable",
        Verdict::Undecided => "undecided",
        Verdict::Failed => "failed",
    }
}

/// What scaled numbers are in units of.
pub fn scales_line(scales: &Scales) -> String {
    format!(
        "Scaled units: length {} (the disc's thickness h), time {:.4e} s,\n    frequency {}, speed {}.\n",
        length(scales.length),
        scales.time,
        frequency(scales.hertz(1.0)),
        speed(scales.speed)
    )
}

/// What a motion belongs to: keys for JSON, and lines for the terminal.
#[derive(Debug, Default)]
pub struct Facts {
    keys: Map<String, Value>,
    lines: String,
}

impl Facts {
    /// A fact whose label is its key.
    pub fn add(&mut self, key: &str, value: impl Into<Value>) {
        self.add_with_unit(key, &key.replace('_', " "), value, "");
    }

    /// A fact with a label of its own and a unit.
    pub fn add_with_unit(&mut self, key: &str, label: &str, value: impl Into<Value>, unit: &str) {
        let value = value.into();
        let text = match (&value, value.as_f64()) {
            (Value::String(text), _) => text.clone(),
            (Value::Number(number), Some(real)) if number.is_f64() => real.to_string(),
            _ => value.to_string(),
        };
        self.lines += &format!("{}\n", format!("{label:<18} {text} {unit}").trim_end());
        self.keys.insert(key.to_owned(), value);
    }

    /// Rotating speed, preload and static friction; the first two also as the speed under the pad and as a
    /// displacement, where the brake is known.
    pub fn add_operating_point(&mut self, rotating_speed: f64, inputs: RandomInputs, pad: Option<&PadOnDisc>) {
        let (mut speed_note, mut preload_note) = (String::new(), String::new());
        if let Some(pad) = pad {
            let under_pad = pad.speed_under_pad(rotating_speed);
            let displacement = pad.scales().metres(inputs.preload);
            speed_note = format!(" ({} under the pad)", speed(under_pad));
            preload_note = format!("({})", length(displacement));
            self.keys.insert("speed_under_pad_m_s".to_owned(), json!(under_pad));
            self.keys.insert("preload_mm".to_owned(), json!(pad.scales().millimetres(inputs.preload)));
        }
        let unit = format!("rad/s{speed_note}");
        self.add_with_unit("rotating_speed_rad_s", "rotating speed", rotating_speed, &unit);
        self.add_with_unit("preload", "preload", inputs.preload, &preload_note);
        self.add("static_friction", inputs.static_friction);
    }

    /// As JSON, or one a line.
    pub fn text(&self, as_json: bool) -> String {
        if as_json { format!("{:#}\n", Value::Object(self.keys.clone())) } else { self.lines.clone() }
    }
}

/// Writes the time series if `--out` is given, and prints what the motion is.
pub fn report(
    facts: Facts,
    scales: &Scales,
    trajectory: &Trajectory,
    arguments: &MotionArguments,
) -> Result<(), Failure> {
    let out = arguments.out.as_deref();
    if let Some(out) = out {
        let (directory, name) = output_file(out)?;
        write_columns(&directory, &name, &columns(&trajectory.moments, scales))?;
    }
    if arguments.json {
        let mut summary = facts.keys;
        summary.extend(summary_keys(scales, trajectory));
        summary.insert("file".to_owned(), json!(out.map(|out| out.display().to_string())));
        return result(&format!("{:#}\n", Value::Object(summary)));
    }
    let last = last_time(trajectory);
    let mut text = facts.lines;
    let fed_by = trajectory.fed_by.map_or(String::new(), |freedom| format!(", fed by the {freedom}"));
    text += &format!("verdict            {}{fed_by}\n", name(trajectory.verdict));
    if trajectory.lacks_friction {
        text += "outside the model  it meets a sliding speed at which the friction coefficient is at or below 0,\n\
                 \x20                  and is stable by definition\n";
    }
    text += "\n";
    text += &match trajectory.settled {
        None => format!("The computation broke down at scaled time {last:.3} ({}).\n", duration(scales.seconds(last))),
        Some(settled) => settled_table(scales, trajectory, &settled),
    };
    text += &format!("\n{}", drawn(&last_cycles(scales, trajectory)));
    if let Some(out) = out {
        text += &format!("{}: {} moments\n", shown(out), trajectory.moments.len());
    }
    result(&text)
}

/// The tangential motion at the end.
fn last_cycles(scales: &Scales, trajectory: &Trajectory) -> Chart {
    let last = last_time(trajectory);
    let late = trajectory.moments.iter().filter(|moment| moment.time >= last - DRAWN);
    let point = |moment: &Moment| (1e3 * scales.seconds(moment.time), scales.millimetres(moment.tangential.0));
    let line: Vec<(f64, f64)> = late.map(point).collect();
    let [from, to] = [last - DRAWN.min(last), last].map(|time| 1e3 * scales.seconds(time));
    Chart::new(
        format!("The last {:.0} units of scaled time", DRAWN.min(last)),
        ChartAxis::new("Time t", "ms", Scale::linear(from, to)),
        ChartAxis::new("Tangential displacement x", "mm", Scale::around(line.iter().map(|point| point.1))),
        vec![Series::line(line)],
    )
}

/// Scaled time of the last moment.
fn last_time(trajectory: &Trajectory) -> f64 {
    trajectory.moments.last().map_or(0.0, |moment| moment.time)
}

/// Smallest and largest contact force over the last quarter of a motion, N.
fn contact_forces(trajectory: &Trajectory) -> (f64, f64) {
    let from = 0.75 * last_time(trajectory);
    let late = trajectory.moments.iter().filter(|moment| moment.time >= from).map(|moment| moment.contact_force);
    late.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), force| (low.min(force), high.max(force)))
}

/// Half peak to peak of x.
fn amplitude(settled: &SettledMotion) -> f64 {
    0.5 * (settled.tangential_max - settled.tangential_min)
}

/// The amplitude that a motion which has not settled comes to, where that is known.
fn comes_to(settled: &SettledMotion) -> Option<f64> {
    match settled.outcome {
        Outcome::Amplitude(amplitude) if !settled.has_settled => Some(amplitude),
        Outcome::Amplitude(_) | Outcome::Sticks | Outcome::Unknown => None,
    }
}

/// The motion as keys of JSON. JSON has no infinity and no NaN: they become null.
fn summary_keys(scales: &Scales, trajectory: &Trajectory) -> Map<String, Value> {
    let settled = trajectory.settled;
    let of = |value: fn(&SettledMotion) -> f64| settled.as_ref().map(value);
    let millimetres = |value: fn(&SettledMotion) -> f64| of(value).map(|length| scales.millimetres(length));
    let period = settled.and_then(|settled| settled.period);
    let forces = settled.map(|_| contact_forces(trajectory));
    let last = last_time(trajectory);
    let keys = json!({
        "verdict": name(trajectory.verdict),
        "fed_by": trajectory.fed_by.map(|freedom| freedom.to_string()),
        "lacks_friction": trajectory.lacks_friction,
        "x_max": of(|settled| settled.tangential_max),
        "x_min": of(|settled| settled.tangential_min),
        "x_mean": of(|settled| settled.tangential_mean),
        "amplitude": of(amplitude),
        "has_settled": settled.map(|settled| settled.has_settled),
        "amplitude_change": settled.and_then(|settled| settled.amplitude_change),
        "comes_to": settled.as_ref().and_then(comes_to),
        "period": period,
        "stick_fraction": of(|settled| settled.stick_fraction),
        "horizon": last,
        "interval": trajectory.interval,
        "moments": trajectory.moments.len(),
        "x_max_mm": millimetres(|settled| settled.tangential_max),
        "x_min_mm": millimetres(|settled| settled.tangential_min),
        "x_mean_mm": millimetres(|settled| settled.tangential_mean),
        "amplitude_mm": millimetres(amplitude),
        "comes_to_mm": settled.as_ref().and_then(comes_to).map(|length| scales.millimetres(length)),
        "period_s": period.map(|period| scales.seconds(period)),
        "frequency_hz": period.map(|period| scales.hertz(1.0 / period)),
        "contact_force_min_n": forces.map(|forces| forces.0),
        "contact_force_max_n": forces.map(|forces| forces.1),
        "horizon_s": scales.seconds(last),
        "interval_s": scales.seconds(trajectory.interval),
        "time_scale_s": scales.time,
    });
    match keys {
        Value::Object(keys) => keys,
        _ => Map::new(),
    }
}

/// What a motion settled to, for the terminal.
fn settled_table(scales: &Scales, trajectory: &Trajectory, settled: &SettledMotion) -> String {
    let last = last_time(trajectory);
    let in_mm = |label: &str, value: f64| row(label, &format!("{value:.6}"), &length(scales.metres(value)));
    let mut text = format!(
        "{}, over the last quarter of {last:.1} units of scaled time ({})\n\n",
        if settled.has_settled { "Settled motion" } else { "Motion that has not settled" },
        duration(scales.seconds(last))
    );
    text += &row("", "scaled", "SI");
    text += &in_mm("smallest x", settled.tangential_min);
    text += &in_mm("largest x", settled.tangential_max);
    text += &in_mm("mean x", settled.tangential_mean);
    text += &in_mm("amplitude", amplitude(settled));
    text += &match settled.period {
        None => "period             none: the motion has come to rest, or never turns\n".to_owned(),
        Some(period) => {
            let cycles = 1.0 / period;
            row("period", &format!("{period:.5}"), &duration(scales.seconds(period)))
                + &row("frequency", &format!("{cycles:.4}"), &frequency(scales.hertz(cycles)))
                + &format!("stick              {:.1} % of the period\n", 100.0 * settled.stick_fraction)
        }
    };
    let (low, high) = contact_forces(trajectory);
    text += &row("contact force", "", &format!("{} kN", range(1e-3 * low, 1e-3 * high)));
    if !settled.has_settled {
        text += &format!("\n{}\n", how_it_goes_on(scales, settled));
    }
    text
}

/// What is said of a motion that has not settled.
fn how_it_goes_on(scales: &Scales, settled: &SettledMotion) -> String {
    let change = settled.amplitude_change.unwrap_or(0.0);
    // Once it sticks, its amplitude may rise or fall to that of its cycle.
    let will_stick = settled.outcome == Outcome::Sticks && settled.slides;
    let grows = match settled.outcome {
        Outcome::Amplitude(end) => end > amplitude(settled),
        Outcome::Sticks | Outcome::Unknown => will_stick || change > 0.0,
    };
    // Where it changes less than the steps resolve, its change in this time may have the other sign.
    let by = match (change > 0.0) == grows && change != 0.0 {
        true => format!(" by {} % in this time", significant(100.0 * change.abs())),
        false => ", more slowly than shows in this time".to_owned(),
    };
    let to = match settled.outcome {
        Outcome::Sticks if will_stick => ", up to stick-slip".to_owned(),
        Outcome::Sticks | Outcome::Unknown => String::new(),
        Outcome::Amplitude(0.0) => ", down to rest".to_owned(),
        Outcome::Amplitude(end) => {
            format!(", {} to {end:.6} ({})", if grows { "up" } else { "down" }, length(scales.metres(end)))
        }
    };
    let way = if grows { "grows" } else { "shrinks" };
    format!("Its amplitude still {way}{by}{to}; a longer --horizon shows what it settles to.")
}

/// The columns of a time series: scaled, then the same in SI.
pub fn columns(moments: &[Moment], scales: &Scales) -> Vec<DescribedColumn> {
    let column = |name, unit, long_name, value: &dyn Fn(&Moment) -> f64| DescribedColumn {
        name,
        unit,
        long_name,
        values: moments.iter().map(value).collect(),
    };
    let mm = |length: f64| scales.millimetres(length);
    let m_s = |speed: f64| scales.metres_per_second(speed);
    vec![
        column("time", "1", "scaled time", &|m| m.time),
        column("x", "1", "tangential displacement of the pad over disc thickness", &|m| m.tangential.0),
        column("x_speed", "1", "scaled tangential speed of the pad", &|m| m.tangential.1),
        column("y", "1", "normal displacement of the pad over disc thickness", &|m| m.normal.0),
        column("y_speed", "1", "scaled normal speed of the pad", &|m| m.normal.1),
        column("phi", "rad", "rotation of the pad", &|m| m.angle.0),
        column("phi_speed", "rad", "rotation of the pad per unit of scaled time", &|m| m.angle.1),
        column("sliding_speed", "1", "scaled speed of the disc relative to the pad", &|m| m.sliding_speed),
        column("friction_coefficient", "1", "friction force over contact force", &|m| m.friction_coefficient),
        column("friction_force_n", "N", "friction force on the pad", &|m| m.friction_force),
        column("contact_force_n", "N", "contact force between pad and disc", &|m| m.contact_force),
        column("sticks", "1", "1 while pad and disc stick, 0 while they slip", &|m| f64::from(u8::from(m.sticks))),
        column("contact_share", "1", "share of the pad's face in contact", &|m| m.contact_share),
        column("deflection_edge", "1", "deflection of the disc's outer edge at the pad over its thickness", &|m| {
            m.deflection.0
        }),
        column("deflection_inside", "1", "deflection at a quarter of the disc's width from its clamped edge", &|m| {
            m.deflection.1
        }),
        column("time_s", "s", "time", &|m| scales.seconds(m.time)),
        column("x_mm", "mm", "tangential displacement of the pad", &|m| mm(m.tangential.0)),
        column("x_speed_m_s", "m/s", "tangential speed of the pad", &|m| m_s(m.tangential.1)),
        column("y_mm", "mm", "normal displacement of the pad", &|m| mm(m.normal.0)),
        column("y_speed_m_s", "m/s", "normal speed of the pad", &|m| m_s(m.normal.1)),
        column("phi_speed_rad_s", "rad/s", "angular speed of the pad", &|m| scales.per_second(m.angle.1)),
        column("sliding_speed_m_s", "m/s", "speed of the disc relative to the pad", &|m| m_s(m.sliding_speed)),
        column("deflection_edge_mm", "mm", "deflection of the disc's outer edge at the pad", &|m| mm(m.deflection.0)),
        column(
            "deflection_inside_mm",
            "mm",
            "deflection at a quarter of the disc's width from its clamped edge",
            &|m| mm(m.deflection.1),
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_not_settled_goes_where_its_end_is_known_to_be() {
        let scales = Scales { flexural_rigidity: 1.0, length: 0.02, time: 1e-4, speed: 200.0, eta0: 1e8 };
        let motion = |outcome: Outcome, slides: bool, change: f64| SettledMotion {
            tangential_max: 0.3,
            tangential_min: 0.1,
            tangential_mean: 0.2,
            period: Some(1.0),
            stick_fraction: if slides { 0.0 } else { 0.4 },
            slides,
            has_settled: false,
            amplitude_change: Some(change),
            outcome,
        };
        for (outcome, slides, change, said) in [
            (Outcome::Sticks, true, 0.01, "grows by 1.000 % in this time, up to stick-slip;"),
            (Outcome::Sticks, true, -1e-9, "grows, more slowly than shows in this time, up to stick-slip;"),
            // It sticks already, and its amplitude is not yet that of its cycle.
            (Outcome::Sticks, false, 0.01, "grows by 1.000 % in this time;"),
            (Outcome::Sticks, false, -0.01, "shrinks by 1.000 % in this time;"),
            (Outcome::Unknown, true, -0.01, "shrinks by 1.000 % in this time;"),
            (Outcome::Amplitude(0.0), true, -0.01, "shrinks by 1.000 % in this time, down to rest;"),
            (Outcome::Amplitude(0.2), true, 0.01, "grows by 1.000 % in this time, up to 0.200000 (4.000 mm);"),
        ] {
            let shown = how_it_goes_on(&scales, &motion(outcome, slides, change));
            assert!(
                shown.starts_with(&format!("Its amplitude still {said}")),
                "{outcome:?} {slides} {change}: {shown}"
            );
        }
    }
}
