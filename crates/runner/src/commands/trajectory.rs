//! `trajectory`: one motion in time.

use std::path::Path;

use serde_json::{Value, json};
use stickslip_core::criterion::settings::TimeDomainSettings;
use stickslip_core::criterion::time_domain::{DiscModel, TimeDomain, TimeDomainError};
use stickslip_core::finite_difference::brake::{Allotment, DiscGrid, FiniteDifferenceBrake, FiniteDifferenceError};
use stickslip_core::flexible_disc::brake::DISC_MODES;
use stickslip_core::flexible_disc::mode_count::{ModeStudy, representative_inputs};
use stickslip_core::motion::moment::Moment;
use stickslip_core::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};
use stickslip_core::trajectory::recording::Trajectory;
use stickslip_core::verdict::Verdict;

use super::analyse::brake;
use crate::cli::{AllotmentArgument, DiscArgument, TrajectoryArguments};
use crate::failure::Failure;
use crate::files::table::{DescribedColumn, write_columns};
use crate::job::plausibility;
use crate::output::{note, output_file, result, warn};
use crate::picture::curves;

/// Scaled time that a trajectory follows unless told otherwise: some 150 cycles of the pad.
const HORIZON: f64 = 500.0;

/// Moments at the most; a trajectory is held in memory.
const MOST_MOMENTS: f64 = 5e6;

/// Scaled time at the end of a trajectory that is drawn: some five cycles of the pad.
const DRAWN: f64 = 18.0;

/// `stickslip trajectory`.
pub fn trajectory(arguments: &TrajectoryArguments) -> Result<(), Failure> {
    let pad = brake(&arguments.set)?;
    let parameters = pad.parameters();
    let inputs = RandomInputs {
        preload: parameters.operating_point.preload,
        static_friction: parameters.friction.static_coefficient,
    };
    let settings = TimeDomainSettings {
        start: arguments.start.into(),
        displacement: arguments.displacement.unwrap_or(TimeDomainSettings::default().displacement),
        ..TimeDomainSettings::default()
    };
    settings.validate().map_err(|error| Failure::Usage(format!("--{error}")))?;
    warn(plausibility::of_displacement("--displacement", settings.displacement));
    for (option, given, disc) in [
        ("--disc-modes", arguments.disc_modes.is_some(), DiscArgument::Flexible),
        ("--grid", arguments.grid.is_some(), DiscArgument::FiniteDifference),
        ("--allotment", arguments.allotment.is_some(), DiscArgument::FiniteDifference),
    ] {
        if given && arguments.disc != disc {
            return Err(Failure::Usage(format!("{option} belongs to --disc {}; leave it out", disc.name())));
        }
    }
    let simulated = match arguments.disc {
        DiscArgument::Rigid => simulate(&pad, &DiscModel::Rigid, settings, inputs, arguments.horizon)?,
        DiscArgument::Flexible => {
            let study = ModeStudy::new(&pad, &representative_inputs(&pad));
            // What has no modes or no equilibrium is refused below, with any number.
            let modes = match arguments.disc_modes {
                None => study.and_then(|study| study.smallest()).unwrap_or(DISC_MODES),
                Some(modes) => {
                    if let Ok(check) = study.and_then(|study| study.check(modes))
                        && !check.is_enough
                    {
                        note(format_args!("warning: {check}; leave out --disc-modes"));
                    }
                    modes
                }
            };
            simulate(&pad, &DiscModel::Flexible { modes }, settings, inputs, arguments.horizon)?
        }
        DiscArgument::FiniteDifference => {
            let refused = |error: FiniteDifferenceError| Failure::Usage(error.to_string());
            let allotment = match arguments.allotment {
                Some(AllotmentArgument::Nodal) => Allotment::Nodal,
                Some(AllotmentArgument::Linear) | None => Allotment::Linear,
            };
            let grid = arguments.grid.unwrap_or(DiscGrid { radial: 8, per_pad: 8 });
            let reference = FiniteDifferenceBrake::new(pad.clone(), grid).map_err(refused)?;
            let horizon = checked_horizon(arguments.horizon, reference.step_length())?;
            reference.trajectory(inputs, settings.start, settings.displacement, horizon, allotment).map_err(refused)?
        }
    };
    let facts = json!({
        "disc": arguments.disc.name(),
        "start": arguments.start.name(),
        "rotating_speed_rad_s": parameters.operating_point.rotating_speed,
        "preload": inputs.preload,
        "static_friction": inputs.static_friction,
    });
    report(&facts, &simulated, arguments.out.as_deref(), arguments.json)
}

/// Simulates one motion.
pub fn simulate(
    pad: &PadOnDisc,
    disc: &DiscModel,
    settings: TimeDomainSettings,
    inputs: RandomInputs,
    horizon: Option<f64>,
) -> Result<Trajectory, Failure> {
    let refused = |error: TimeDomainError| Failure::Usage(error.to_string());
    let criterion = TimeDomain::new(pad, disc, settings).map_err(refused)?;
    let horizon = checked_horizon(horizon, criterion.step_length())?;
    criterion.trajectory(inputs, horizon).map_err(refused)
}

/// The horizon of a trajectory, if it can be held in memory.
pub fn checked_horizon(horizon: Option<f64>, interval: f64) -> Result<f64, Failure> {
    let horizon = horizon.unwrap_or(HORIZON);
    let largest = (MOST_MOMENTS * interval).floor();
    if horizon > 0.0 && horizon <= largest {
        return Ok(horizon);
    }
    let message = format!(
        "--horizon {horizon} is out of range: it must be greater than 0 and at most {largest} (scaled time; {MOST_MOMENTS} moments)"
    );
    Err(Failure::Usage(message))
}

/// A verdict in words.
pub fn name(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Stable => "stable",
        Verdict::Unstable => "unstable",
        Verdict::Undecided => "undecided",
        Verdict::Failed => "failed",
    }
}

/// Writes the time series where asked to, and says what the motion is.
pub fn report(facts: &Value, trajectory: &Trajectory, out: Option<&Path>, as_json: bool) -> Result<(), Failure> {
    if let Some(out) = out {
        write(out, trajectory)?;
    }
    let settled = trajectory.settled;
    let last = trajectory.moments.last().map_or(0.0, |moment| moment.time);
    if as_json {
        let mut summary = json!({
            "verdict": name(trajectory.verdict),
            "fed_by": trajectory.fed_by.map(|freedom| freedom.to_string()),
            "x_max": settled.map(|settled| settled.tangential_max),
            "x_min": settled.map(|settled| settled.tangential_min),
            "x_mean": settled.map(|settled| settled.tangential_mean),
            "period": settled.and_then(|settled| settled.period),
            "stick_fraction": settled.map(|settled| settled.stick_fraction),
            "horizon": last,
            "interval": trajectory.interval,
            "moments": trajectory.moments.len(),
            "file": out.map(|out| out.display().to_string()),
        });
        if let (Some(summary), Some(facts)) = (summary.as_object_mut(), facts.as_object()) {
            summary.extend(facts.clone());
        }
        return result(&format!("{summary:#}\n"));
    }
    let mut text = lines(facts);
    let fed_by = trajectory.fed_by.map_or(String::new(), |freedom| format!(", fed by the {freedom}"));
    text += &format!("verdict            {}{fed_by}\n", name(trajectory.verdict));
    match settled {
        None => text += &format!("the computation broke down at time {last:.3}\n"),
        Some(settled) => {
            text += &format!(
                "x                  {:.6} to {:.6}, mean {:.6} (times h), over the last quarter of {last:.1} units of scaled time\n",
                settled.tangential_min, settled.tangential_max, settled.tangential_mean
            );
            text += &match settled.period {
                None => "period             none: the motion has come to rest, or never turns\n".to_owned(),
                Some(period) => format!(
                    "period             {period:.5} ({:.4} Hz of scaled time), {:.1} % of it in stick\n",
                    1.0 / period,
                    100.0 * settled.stick_fraction
                ),
            };
        }
    }
    let drawn = trajectory.moments.iter().filter(|moment| moment.time >= last - DRAWN);
    let line: Vec<(f64, f64)> = drawn.map(|moment| (moment.time, moment.tangential.0)).collect();
    text += &format!("\nx over the last {:.0} units of scaled time\n{}", DRAWN.min(last), curves(&[line]));
    if let Some(out) = out {
        text += &format!("{}: {} moments\n", out.display(), trajectory.moments.len());
    }
    result(&text)
}

/// Facts one a line.
pub fn lines(facts: &Value) -> String {
    let pairs = facts.as_object().into_iter().flatten();
    pairs
        .map(|(key, value)| {
            let value = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
            format!("{:<18} {value}\n", key.replace('_', " "))
        })
        .collect()
}

/// Writes a trajectory as a Parquet file.
pub fn write(out: &Path, trajectory: &Trajectory) -> Result<(), Failure> {
    let (directory, name) = output_file(out)?;
    write_columns(&directory, &name, &columns(&trajectory.moments))
}

/// The columns of a time series.
pub fn columns(moments: &[Moment]) -> Vec<DescribedColumn> {
    let column = |name, unit, long_name, value: fn(&Moment) -> f64| DescribedColumn {
        name,
        unit,
        long_name,
        values: moments.iter().map(value).collect(),
    };
    vec![
        column("time", "1", "scaled time", |m| m.time),
        column("x", "1", "tangential displacement of the pad over disc thickness", |m| m.tangential.0),
        column("x_speed", "1", "scaled tangential speed of the pad", |m| m.tangential.1),
        column("y", "1", "normal displacement of the pad over disc thickness", |m| m.normal.0),
        column("y_speed", "1", "scaled normal speed of the pad", |m| m.normal.1),
        column("phi", "rad", "rotation of the pad", |m| m.angle.0),
        column("phi_speed", "rad", "rotation of the pad per unit of scaled time", |m| m.angle.1),
        column("sliding_speed", "1", "scaled speed of the disc relative to the pad", |m| m.sliding_speed),
        column("friction_coefficient", "1", "friction force over contact force", |m| m.friction_coefficient),
        column("friction_force_n", "N", "friction force on the pad", |m| m.friction_force),
        column("contact_force_n", "N", "contact force between pad and disc", |m| m.contact_force),
        column("sticks", "1", "1 while pad and disc stick, 0 while they slip", |m| f64::from(u8::from(m.sticks))),
        column("contact_share", "1", "share of the pad's face in contact", |m| m.contact_share),
        column("deflection_edge", "1", "deflection of the disc's outer edge at the pad over its thickness", |m| {
            m.deflection.0
        }),
        column("deflection_inside", "1", "deflection at a quarter of the disc's width from its clamped edge", |m| {
            m.deflection.1
        }),
    ]
}
