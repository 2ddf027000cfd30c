//! `analyse`: one parameter point.

use serde_json::{Value, json};
use stickslip_core::degree_of_freedom::DegreeOfFreedom;
use stickslip_core::flexible_disc::brake::FlexibleBrake;
use stickslip_core::flexible_disc::linear_stability::LinearStability;
use stickslip_core::parameters::{ParameterError, Parameters, SCALARS};
use stickslip_core::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};

use crate::cli::AnalyseArguments;
use crate::failure::Failure;
use crate::job::{plausibility, unknown_parameter};
use crate::output::{result, warn};

/// `stickslip analyse`.
pub fn analyse(arguments: &AnalyseArguments) -> Result<(), Failure> {
    let brake = brake(&arguments.set)?;
    let eigenvalues = stickslip_core::numerics::eigenvalues::eigenvalues(&brake.jacobian())
        .map_err(|error| Failure::InputOutput(format!("eigenvalues of steady sliding: {error}")))?;
    let equilibrium = brake.sliding_equilibrium();
    let boundary = brake.stability_boundary();
    let parameters = brake.parameters();
    let operating_point = &parameters.operating_point;
    let speeds = brake.unstable_speeds();
    let stable = brake.growth_rate() <= 0.0;
    let (limit_cycle, saddle_node) = (brake.limit_cycle(), brake.saddle_node_speed());
    let inputs =
        RandomInputs { preload: operating_point.preload, static_friction: parameters.friction.static_coefficient };
    let coupled = FlexibleBrake::with_enough_modes(brake.clone()).and_then(|flexible| {
        Ok(Coupled {
            growth_rate: flexible.growth_rate(inputs)?,
            stability: flexible.by_eigenvalues(inputs)?,
            modes: flexible.modes(),
        })
    });
    let critical_static_friction = boundary.critical_static_friction(operating_point.preload);
    let critical_preload = boundary.critical_preload(parameters.friction.static_coefficient);
    if arguments.json {
        let values: serde_json::Map<String, Value> =
            SCALARS.iter().map(|scalar| (scalar.key.to_owned(), json!(scalar.value(parameters)))).collect();
        // JSON has no infinity; serde_json writes null, which reads as "there is none".
        let analysis = json!({
            "equilibrium": { "x": equilibrium.tangential, "y": equilibrium.normal, "phi": equilibrium.angle },
            "normal_force_n": equilibrium.normal_force * brake.scales().length,
            "friction_coefficient": equilibrium.friction_coefficient,
            "eigenvalues": eigenvalues.iter().map(|value| [value.re, value.im]).collect::<Vec<_>>(),
            "growth_rate": brake.growth_rate(),
            "stable": stable,
            "coupled_growth_rate": coupled.as_ref().ok().map(|coupled| coupled.growth_rate),
            "coupled_stable": coupled.as_ref().ok().map(|coupled| coupled.stability == LinearStability::Stable),
            "coupled_fed_by": coupled.as_ref().ok().and_then(Coupled::fed_by).map(|freedom| freedom.to_string()),
            "disc_modes": coupled.as_ref().ok().map(|coupled| coupled.modes),
            "unstable_speeds": match speeds {
                None => json!("none"),
                Some(speeds) if speeds.to.is_infinite() => json!("all"),
                Some(speeds) => json!([speeds.from, speeds.to]),
            },
            "critical_speed_rad_s": speeds.map(|speeds| speeds.to),
            "lower_critical_speed_rad_s": speeds.map(|speeds| speeds.from).filter(|from| *from > 0.0),
            "saddle_node_speed_rad_s": saddle_node,
            "limit_cycle": limit_cycle.map(|cycle| json!({
                "period": cycle.period,
                "x_max": cycle.tangential_max,
                "x_min": cycle.tangential_min,
                "stick_fraction": cycle.stick_fraction,
            })),
            "critical_static_friction": critical_static_friction,
            "critical_preload": critical_preload,
            "time_scale_s": brake.scales().time,
            "parameters": values,
        });
        return result(&format!("{analysis:#}\n"));
    }
    let mut text = format!(
        "Steady sliding at {} rad/s, preload {}, static friction {}: {}\n\n",
        operating_point.rotating_speed,
        operating_point.preload,
        parameters.friction.static_coefficient,
        headline(stable, coupled.as_ref().ok())
    );
    text += &format!(
        "equilibrium        x0 = {:.6e}, y0 = {:.6e} (times h = {} m), phi0 = {:.6e} rad\n",
        equilibrium.tangential,
        equilibrium.normal,
        brake.scales().length,
        equilibrium.angle
    );
    text += &format!(
        "contact            N = {:.1} N, friction coefficient {:.5}\n",
        equilibrium.normal_force * brake.scales().length,
        equilibrium.friction_coefficient
    );
    text += "eigenvalues        of scaled time (frequency in Hz of scaled time)\n";
    for value in eigenvalues.iter().filter(|value| value.im >= 0.0) {
        text += &format!(
            "                   {:+.6} +- {:.6} i   ({:.4} Hz)\n",
            value.re,
            value.im,
            value.im / std::f64::consts::TAU
        );
    }
    text += &format!("growth rate        {:+.6} (tangential motion)\n", brake.growth_rate());
    text += &match coupled {
        Ok(Coupled { growth_rate, modes, .. }) => {
            format!(
                "coupled            {growth_rate:+.6} (largest growth rate of pad and flexible disc, {modes} disc modes)\n"
            )
        }
        Err(error) => format!("coupled            {error}\n"),
    };
    text += &match speeds {
        None => "critical speed     none: steady sliding is stable at every speed\n".to_owned(),
        Some(speeds) if speeds.to.is_infinite() => "critical speed     none: unstable at every speed\n".to_owned(),
        Some(speeds) if speeds.from > 0.0 => {
            format!("critical speed     {:.4} rad/s, unstable down to {:.4} rad/s\n", speeds.to, speeds.from)
        }
        Some(speeds) => format!("critical speed     {:.4} rad/s, unstable below\n", speeds.to),
    };
    text += &match saddle_node {
        None if limit_cycle.is_some() => "saddle-node        none: stick-slip at every speed\n".to_owned(),
        None if !stable => "saddle-node        not found: the motion is too stiff for the method\n".to_owned(),
        None => "saddle-node        none: no stick-slip limit cycle at any speed\n".to_owned(),
        Some(speed) => format!("saddle-node        {speed:.4} rad/s, no stick-slip limit cycle above\n"),
    };
    text += &match limit_cycle {
        None if !stable => "limit cycle        not found: the motion is too stiff for the method\n".to_owned(),
        None => "limit cycle        none at this speed\n".to_owned(),
        Some(cycle) => format!(
            "limit cycle        x from {:.6} to {:.6}, period {:.5} (scaled time), {:.1} % of it in stick\n",
            cycle.tangential_min,
            cycle.tangential_max,
            cycle.period,
            100.0 * cycle.stick_fraction
        ),
    };
    text += &format!("critical friction  {} at this preload and speed\n", finite(critical_static_friction));
    text += &format!("critical preload   {} at this friction and speed\n", finite(critical_preload));
    result(&text)
}

/// What the eigenvalues of pad and flexible disc say.
struct Coupled {
    growth_rate: f64,
    stability: LinearStability,
    modes: usize,
}

impl Coupled {
    fn fed_by(&self) -> Option<DegreeOfFreedom> {
        match self.stability {
            LinearStability::Stable => None,
            LinearStability::Unstable { fed_by } => Some(fed_by),
        }
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

/// The preset with `KEY=VALUE` changes; warns of values that are not plausible.
pub(super) fn brake(changes: &[String]) -> Result<PadOnDisc, Failure> {
    let mut parameters = Parameters::sui_ding_2018();
    let mut changed: Vec<(&str, &str)> = Vec::new();
    for change in changes {
        let refused = |message: String| Failure::Usage(format!("--set {change}: {message}"));
        let Some((key, value)) = change.split_once('=') else {
            return Err(refused("write KEY=VALUE, for example friction.static_coefficient=0.45".to_owned()));
        };
        let (key, value) = (key.trim(), value.trim());
        if let Some((_, before)) = changed.iter().find(|(other, _)| *other == key) {
            return Err(refused(format!("{key} is set a second time, after {key}={before}; leave one of the two out")));
        }
        changed.push((key, value));
        let number: f64 = value.parse().map_err(|_| refused(not_a_number(value)))?;
        parameters.set(key, number).map_err(|error| match error {
            ParameterError::Unknown { .. } => refused(unknown_parameter(key, false)),
            other => refused(format!("{other}{}", plausibility::hint(key, number, &parameters))),
        })?;
    }
    let brake = PadOnDisc::new(parameters).map_err(|error| Failure::Usage(format!("--set: {error}")))?;
    warn(plausibility::of_parameters(brake.parameters()));
    Ok(brake)
}

/// What is wrong with the value of a parameter that cannot be read.
fn not_a_number(value: &str) -> String {
    let with_point = value.replacen(',', ".", 1);
    match with_point.parse::<f64>() {
        Ok(_) => format!("{value} has a decimal comma; write {with_point}"),
        Err(_) => format!("{value:?} is not a number"),
    }
}
