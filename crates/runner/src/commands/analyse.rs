//! `analyse`: one parameter point.

use std::f64::consts::TAU;
use std::path::Path;

use serde_json::{Map, Value, json};
use stickslip_core::degree_of_freedom::DegreeOfFreedom;
use stickslip_core::flexible_disc::brake::FlexibleBrake;
use stickslip_core::flexible_disc::error::FlexibleError;
use stickslip_core::flexible_disc::linear_stability::LinearStability;
use stickslip_core::friction::law::LawKind;
use stickslip_core::numerics::eigenvalues::{Eigenvalue, eigenvalues};
use stickslip_core::parameters::{ParameterError, Parameters, SCALARS};
use stickslip_core::rigid_disc::basin::{Basin, Knock};
use stickslip_core::rigid_disc::limit_cycle::LimitCycle;
use stickslip_core::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs, SlidingEquilibrium};
use stickslip_core::rigid_disc::stability::SpeedRange;

use crate::cli::AnalyseArguments;
use crate::failure::Failure;
use crate::job::friction::{LawSpec, check_band, read_curve};
use crate::job::preload_force::{self, PRELOAD};
use crate::job::{plausibility, unknown_parameter};
use crate::output::{result, warn};
use crate::units::{duration, force, frequency, growth_rate, length, range, row, scales_line, significant, speed};

/// Disc frequencies are shown up to this number of nodal diameters.
const MOST_NODAL_DIAMETERS: u32 = 4;

/// `stickslip analyse`.
pub fn analyse(arguments: &AnalyseArguments) -> Result<(), Failure> {
    let analysis = Analysis::new(brake(&arguments.set)?);
    result(&if arguments.json { format!("{:#}\n", analysis.json()?) } else { analysis.text() })
}

/// One parameter point.
struct Analysis {
    equilibrium: SlidingEquilibrium,
    stable: bool,
    coupled: Result<Coupled, FlexibleError>,
    disc_frequencies: Vec<f64>,
    unstable_speeds: Vec<SpeedRange>,
    saddle_node: Option<f64>,
    limit_cycle: Option<LimitCycle>,
    basin: Basin,
    critical_static_friction: f64,
    critical_preload: f64,
    brake: PadOnDisc,
}

impl Analysis {
    fn new(brake: PadOnDisc) -> Self {
        let parameters = brake.parameters();
        let preload = parameters.operating_point.preload;
        let static_friction = parameters.friction.static_coefficient;
        let inputs = RandomInputs { preload, static_friction };
        let coupled = FlexibleBrake::with_enough_modes(brake.clone()).and_then(|flexible| {
            Ok(Coupled {
                growth_rate: flexible.growth_rate(inputs)?,
                stability: flexible.by_eigenvalues(inputs)?,
                modes: flexible.modes(),
            })
        });
        let boundary = brake.stability_boundary();
        Self {
            equilibrium: brake.sliding_equilibrium(),
            stable: brake.growth_rate() <= 0.0,
            coupled,
            disc_frequencies: disc_frequencies(&brake),
            unstable_speeds: brake.unstable_speeds(),
            saddle_node: brake.saddle_node_speed(),
            limit_cycle: brake.limit_cycle(),
            basin: brake.basin(),
            critical_static_friction: boundary.critical_static_friction(preload),
            critical_preload: boundary.critical_preload(static_friction),
            brake,
        }
    }

    /// Everything by name; JSON has no infinity and no NaN, they become null.
    fn json(&self) -> Result<Value, Failure> {
        let eigenvalues = eigenvalues(&self.brake.jacobian())
            .map_err(|error| Failure::InputOutput(format!("eigenvalues of steady sliding: {error}")))?;
        let (scales, parameters) = (self.brake.scales(), self.brake.parameters());
        let point = &parameters.operating_point;
        let values: Map<String, Value> =
            SCALARS.iter().map(|scalar| (scalar.key.to_owned(), json!(scalar.value(parameters)))).collect();
        let coupled = self.coupled.as_ref().ok();
        let [x, _, y, _, phi, _] = self.brake.sliding_eigenvalues();
        let mode = |value: Eigenvalue| {
            json!({
                "growth_rate_per_s": scales.per_second(value.re),
                "frequency_hz": scales.hertz(value.im / TAU),
            })
        };
        let critical = self.unstable_speeds.last().map(|speeds| speeds.to);
        let lower_critical = self.unstable_speeds.last().map(|speeds| speeds.from).filter(|from| *from > 0.0);
        let in_m_s = |speed: Option<f64>| speed.map(|speed| self.brake.speed_under_pad(speed));
        let mut analysis = json!({
            "equilibrium": {
                "x": self.equilibrium.tangential,
                "y": self.equilibrium.normal,
                "phi": self.equilibrium.angle,
                "x_mm": scales.millimetres(self.equilibrium.tangential),
                "y_mm": scales.millimetres(self.equilibrium.normal),
            },
            "normal_force_n": scales.newtons(self.equilibrium.normal_force),
            "friction_coefficient": self.equilibrium.friction_coefficient,
            "eigenvalues": eigenvalues.iter().map(|value| [value.re, value.im]).collect::<Vec<_>>(),
            "growth_rate": self.brake.growth_rate(),
            "stable": self.stable,
            "coupled_growth_rate": coupled.map(|coupled| coupled.growth_rate),
            "coupled_stable": coupled.map(|coupled| coupled.stability == LinearStability::Stable),
            "coupled_fed_by": coupled.and_then(Coupled::fed_by).map(|freedom| freedom.to_string()),
            "disc_modes": coupled.map(|coupled| coupled.modes),
            "unstable_speeds": match *self.unstable_speeds {
                [] => json!("none"),
                [speeds] if speeds.to.is_infinite() => json!("all"),
                [speeds] => json!([speeds.from, speeds.to]),
                ref several => json!(several.iter().map(|speeds| [speeds.from, speeds.to]).collect::<Vec<_>>()),
            },
            "critical_speed_rad_s": critical,
            "lower_critical_speed_rad_s": lower_critical,
            "saddle_node_speed_rad_s": self.saddle_node,
            "limit_cycle": self.limit_cycle.map(|cycle| json!({
                "period": cycle.period,
                "x_max": cycle.tangential_max,
                "x_min": cycle.tangential_min,
                "stick_fraction": cycle.stick_fraction,
                "period_s": scales.seconds(cycle.period),
                "frequency_hz": scales.hertz(1.0 / cycle.period),
                "x_max_mm": scales.millimetres(cycle.tangential_max),
                "x_min_mm": scales.millimetres(cycle.tangential_min),
            })),
            "smallest_knock": self.basin.smallest_knock().map(|knock| json!({
                "speed": knock.speed(),
                "displacement": knock.displacement(),
                "forward": knock.forward,
                "backward": knock.backward,
                "outward": knock.outward,
                "inward": knock.inward,
                "speed_m_s": scales.metres_per_second(knock.speed()),
                "displacement_mm": scales.millimetres(knock.displacement()),
                "forward_m_s": scales.metres_per_second(knock.forward),
                "backward_m_s": scales.metres_per_second(knock.backward),
                "outward_mm": scales.millimetres(knock.outward),
                "inward_mm": scales.millimetres(knock.inward),
            })),
            "basin_area": self.basin.area(),
            "critical_static_friction": self.critical_static_friction,
            "critical_preload": self.critical_preload,
            "time_scale_s": scales.time,
            "parameters": values,
        });
        let in_si = json!({
            "speed_under_pad_m_s": self.brake.speed_under_pad(point.rotating_speed),
            "preload_mm": scales.millimetres(point.preload),
            "pad_modes": { "tangential": mode(x), "normal": mode(y), "angular": mode(phi) },
            "growth_rate_per_s": scales.per_second(self.brake.growth_rate()),
            "coupled_growth_rate_per_s": coupled.map(|coupled| scales.per_second(coupled.growth_rate)),
            "disc_frequencies_hz": self.disc_frequencies,
            "critical_speed_m_s": in_m_s(critical),
            "lower_critical_speed_m_s": in_m_s(lower_critical),
            "saddle_node_speed_m_s": in_m_s(self.saddle_node),
            "basin_area_m2_s": self.basin.area().map(|area| scales.square_metres_per_second(area)),
            "critical_preload_mm": scales.millimetres(self.critical_preload),
            "critical_normal_force_n": self.brake.contact_force(self.critical_preload),
            "length_scale_m": scales.length,
            "speed_scale_m_s": scales.speed,
        });
        if let (Value::Object(analysis), Value::Object(in_si)) = (&mut analysis, in_si) {
            analysis.extend(in_si);
        }
        Ok(analysis)
    }

    fn text(&self) -> String {
        let parameters = self.brake.parameters();
        format!(
            "Steady sliding at {} rad/s, preload {}, static friction {}: {}\n\n{}\n{}\n{}\n{}",
            parameters.operating_point.rotating_speed,
            parameters.operating_point.preload,
            parameters.friction.static_coefficient,
            headline(self.stable, self.coupled.as_ref().ok()),
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
        let in_mm = |label: &str, value: f64| row(label, &format!("{value:.6e}"), &length(scales.metres(value)));
        row("", "scaled", "SI")
            + &row(
                "speed under pad",
                &format!("{:.6e}", self.brake.disc_speed()),
                &speed(self.brake.speed_under_pad(point.rotating_speed)),
            )
            + &row("preload", &point.preload.to_string(), &length(scales.metres(point.preload)))
            + &row("contact force", "", &format!("{:.1} N", scales.newtons(equilibrium.normal_force)))
            + &row("friction mu0", &format!("{:.5}", equilibrium.friction_coefficient), "")
            + &in_mm("equilibrium x0", equilibrium.tangential)
            + &in_mm("equilibrium y0", equilibrium.normal)
            + &row("equilibrium phi0", "", &format!("{:.6e} rad", equilibrium.angle))
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
            Ok(Coupled { growth_rate: rate, modes, .. }) => {
                format!("Pad and flexible disc together, {modes} disc modes\n")
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

    /// Where steady sliding and stick-slip begin and end.
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
        text += &match self.saddle_node {
            None if self.limit_cycle.is_some() => "saddle-node        none: stick-slip at every speed\n".to_owned(),
            None if !self.stable => "saddle-node        not found: the motion is too stiff for the method\n".to_owned(),
            None => "saddle-node        none: no stick-slip limit cycle at any speed\n".to_owned(),
            Some(speed) => format!(
                "saddle-node        {speed:.4} rad/s, no stick-slip limit cycle above ({} under the pad)\n",
                in_m_s(speed)
            ),
        };
        text += &match self.limit_cycle {
            None if !self.stable => "limit cycle        not found: the motion is too stiff for the method\n".to_owned(),
            None => "limit cycle        none at this speed\n".to_owned(),
            Some(cycle) => {
                let (low, high) = (cycle.tangential_min, cycle.tangential_max);
                let cycles = 1.0 / cycle.period;
                row(
                    "limit cycle, x",
                    &format!("{low:.6} to {high:.6}"),
                    &format!("{} mm", range(scales.millimetres(low), scales.millimetres(high))),
                ) + &row("  period", &format!("{:.5}", cycle.period), &duration(scales.seconds(cycle.period)))
                    + &row("  frequency", &format!("{cycles:.4}"), &frequency(scales.hertz(cycles)))
                    + &row("  stick", &format!("{:.1} % of the period", 100.0 * cycle.stick_fraction), "")
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

/// Lowest frequency of the disc with 0, 1, ... nodal diameters, Hz: at rest and without the pad. Empty if the plate has
/// no modes that can be computed.
fn disc_frequencies(brake: &PadOnDisc) -> Vec<f64> {
    let plate = brake.annular_plate();
    let lowest = |nodal_diameters| {
        let modes = plate.modes(nodal_diameters, 1).ok()?;
        Some(brake.scales().hertz(brake.disc_frequency(modes.first()?) / TAU))
    };
    (0..=MOST_NODAL_DIAMETERS).map_while(lowest).collect()
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
    let mut force = None;
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
        if key == "friction.law" || key == "friction.table" {
            continue;
        }
        let number: f64 = value.parse().map_err(|_| refused(not_a_number(value)))?;
        if key == preload_force::KEY {
            force = Some((change, number));
            continue;
        }
        parameters.set(key, number).map_err(|error| match error {
            ParameterError::Unknown { .. } => refused(unknown_parameter(key, false)),
            other => refused(format!("{other}{}", plausibility::hint(key, number, &parameters))),
        })?;
    }
    use_law(&changed, &mut parameters)?;
    // It depends on the other values.
    if let Some((change, force)) = force {
        let refused = |message: String| Failure::Usage(format!("--set {change}: {message}"));
        if let Some((key, value)) = changed.iter().find(|(key, _)| *key == PRELOAD) {
            return Err(refused(format!("the preload is set too, {key}={value}; leave one of the two out")));
        }
        let preload = preload_force::preload(force, &parameters);
        parameters.operating_point.preload = preload.map_err(|message| refused(format!("it {message}")))?;
    }
    let brake = PadOnDisc::new(parameters).map_err(|error| Failure::Usage(format!("--set: {error}")))?;
    warn(plausibility::of_parameters(brake.parameters()));
    Ok(brake)
}

/// Applies `friction.law` and `friction.table` of the changes, and refuses values of other laws. A table changes the
/// static friction coefficient to its own unless that is set too.
fn use_law(changed: &[(&str, &str)], parameters: &mut Parameters) -> Result<(), Failure> {
    let value = |wanted: &str| changed.iter().find(|(key, _)| *key == wanted).map(|(_, value)| *value);
    let refused = |message: String| Failure::Usage(format!("--set: {message}"));
    let (law, file) = (value("friction.law"), value("friction.table"));
    let given = law.map(LawSpec::from_name).transpose().map_err(refused)?;
    let law = given.unwrap_or(if file.is_some() { LawSpec::Table } else { LawSpec::Stribeck });
    let keys = changed.iter().filter_map(|(key, _)| Some((*key, key.strip_prefix("friction.")?)));
    if let Some(message) = keys.into_iter().find_map(|(key, name)| law.refusal(name, key)) {
        return Err(refused(message));
    }
    let friction = &mut parameters.friction;
    match (law, file) {
        (LawSpec::Stribeck, _) => {}
        (LawSpec::Rational, _) => friction.law = LawKind::Rational,
        (LawSpec::Table, None) => {
            return Err(refused("friction.law=table needs the measured curve: --set friction.table=FILE".to_owned()));
        }
        (LawSpec::Table, Some(file)) => {
            let set = value("friction.static_coefficient").map(|_| friction.static_coefficient);
            let curve = read_curve(Path::new(file)).map_err(|error| refused(format!("friction.table: {error}")))?;
            friction.use_table(curve);
            friction.static_coefficient = set.unwrap_or(friction.static_coefficient);
        }
    }
    check_band(friction, false).map_err(refused)
}

/// What is wrong with the value of a parameter that cannot be read.
fn not_a_number(value: &str) -> String {
    let with_point = value.replacen(',', ".", 1);
    match with_point.parse::<f64>() {
        Ok(_) => format!("{value} has a decimal comma; write {with_point}"),
        Err(_) => format!("{value:?} is not a number"),
    }
}
