//! Which parameter of the pad on the disc a user may have meant.

use stickslip_core::models::pad_on_disc::motion::start::GivenStart;
use stickslip_core::models::pad_on_disc::motion::start_value::StartValue;
use stickslip_core::models::pad_on_disc::parameters::{SCALARS, Scalar, scalar};

use super::criterion_spec::CriterionSpec;
use super::preload_force::{self, AS_INPUT, is_preload_force};
use crate::job::axes_spec::{AxesSpec, AxisEntry};
use crate::job::keys::{has_key, nearest, table_with};
use crate::job::spec::JobSpec;

/// The sections of the model, in the order of the model's table.
pub const SECTIONS: [&str; 6] = ["disc", "pad", "stiffness", "damping", "friction", "operating_point"];

/// Parameters that are axes of a job, with the names that they have there, and what they are.
const AXES: [(&str, &str, &str); 4] = [
    ("operating_point.rotating_speed", "rotating_speed", "Rotating speed of the disc"),
    (
        "operating_point.preload",
        "preload",
        "Expected preload: displacement of the calliper over the thickness of the disc",
    ),
    (
        preload_force::KEY,
        preload_force::NAME,
        "In place of `preload`: expected contact force, from 0 to the force at preload 1, unit N",
    ),
    (STATIC, "static_friction", "Expected static friction coefficient"),
];

/// The parameter that is meant where friction is said.
const STATIC: &str = "friction.static_coefficient";

/// The axis of a job along which a parameter varies.
pub fn axis_of(key: &str) -> Option<&'static str> {
    AXES.iter().find(|(parameter, ..)| *parameter == key).map(|(_, axis, _)| *axis)
}

/// The parameter whose values an axis has.
pub fn parameter_of_axis(axis: &str) -> Option<&'static str> {
    AXES.iter().find(|(_, name, _)| *name == axis).map(|(parameter, ..)| *parameter)
}

/// The axis of a parameter, if the job has it, under any of its names.
pub fn axis_of_parameter<'a>(axes: &'a AxesSpec, key: &str) -> Option<&'a AxisEntry> {
    let is_axis = |name: &str| name == key || axis_of(key) == Some(name);
    let is_force = |name: &str| key == preload_force::PRELOAD && is_preload_force(name);
    axes.0.iter().find(|entry| is_axis(entry.name.get_ref()) || is_force(entry.name.get_ref()))
}

/// The parameter that a word names otherwise than by its key: by the symbol of the paper (`k_en`), by its name alone
/// (`contact_normal`), as a job spec does (`axes.preload`, `model.pad.mass`), or by a part of its name (`speed`).
pub fn parameter(word: &str) -> Option<&'static Scalar> {
    let bare = word.strip_prefix("model.").unwrap_or(word);
    let axis = word.strip_prefix("axes.").unwrap_or(word);
    let by = |matches: &dyn Fn(&Scalar) -> bool| SCALARS.iter().find(|scalar| matches(scalar));
    let has_part = |scalar: &&Scalar| scalar.name().split('_').any(|part| part == word);
    let with_part = || SCALARS.iter().find(has_part).filter(|_| SCALARS.iter().filter(has_part).count() == 1);
    // The section of the same name has parameters that few people mean.
    let bare = if ["friction", "mu", "friction_coefficient"].contains(&bare) { STATIC } else { bare };
    by(&|scalar| scalar.key == bare)
        .or_else(|| parameter_of_axis(axis).and_then(|key| by(&|scalar| scalar.key == key)))
        .or_else(|| by(&|scalar| scalar.symbol == word))
        .or_else(|| by(&|scalar| scalar.name() == word))
        .or_else(|| by(&|scalar| scalar.symbol.eq_ignore_ascii_case(word)))
        .or_else(with_part)
}

/// Where a job spec has a parameter, for a message about a key of `table`.
fn place_in_job(scalar: &Scalar, table: &str) -> String {
    let (name, place) = match axis_of(scalar.key) {
        Some(axis) => (axis, "axes".to_owned()),
        None => (scalar.name(), format!("model.{}", scalar.section())),
    };
    match table {
        _ if place == table => format!("`{name}`"),
        "axes" => format!("`\"{}\"`", scalar.key),
        _ => format!("`{name}` in [{place}]"),
    }
}

/// What may have been meant by a key that a table does not have, as the end of a message.
pub fn suggested(wrong: &str, table: &str) -> Option<String> {
    if parameter_of_axis(wrong).is_some() {
        return Some(format!("; `{wrong}` belongs in [axes]"));
    }
    if has_key::<CriterionSpec>(wrong) {
        return Some(format!("; `{wrong}` belongs in [criterion]"));
    }
    let meant = parameter(wrong).or_else(|| parameter(&format!("{table}.{wrong}")));
    meant.map(|scalar| format!("; did you mean {}?", place_in_job(scalar, table)))
}

/// The complaint about a key of the parameters that does not exist. `in_job`: in a job spec, not in `--set`.
pub fn unknown_parameter(key: &str, in_job: bool) -> String {
    let (section, name) = key.split_once('.').unwrap_or(("", key));
    let table = format!("model.{section}");
    let names: Vec<&str> = SCALARS.iter().filter(|scalar| scalar.section() == section).map(Scalar::name).collect();
    if name == preload_force::NAME {
        let right = if in_job { "`preload_force` in [axes]".to_owned() } else { format!("`{}`", preload_force::KEY) };
        return format!("unknown parameter `{key}`; did you mean {right}?");
    }
    let meant = |scalar: &Scalar| {
        let right = if in_job { place_in_job(scalar, &table) } else { format!("`{}`", scalar.key) };
        format!("; did you mean {right}?")
    };
    let exact = parameter(key).or_else(|| parameter(name));
    if names.is_empty() {
        let near = || nearest(key, SCALARS.iter().map(|scalar| scalar.key)).and_then(parameter);
        let mut sections: Vec<&str> = SCALARS.iter().map(Scalar::section).collect();
        sections.dedup();
        let hint = exact.or_else(near).map_or(String::new(), meant);
        return format!("unknown parameter `{key}`{hint} (sections: {})", sections.join(", "));
    }
    let near = || nearest(name, names.iter().copied()).map(|name| format!("; did you mean `{name}`?"));
    let hint = exact.map(meant).or_else(near).unwrap_or_default();
    let place = if in_job { format!("[{table}]") } else { section.to_owned() };
    format!("unknown key `{name}` in {place}{hint} (it has {})", names.join(", "))
}

/// What the names of axes are, for messages.
pub const AXIS_NAMES: &str = "rotating_speed, preload (or preload_force), static_friction, every parameter as \"section.name\", for example \"stiffness.contact_normal\", and those of the start, \"start.tangential\", \"start.velocity\", \"start.normal\", \"start.angle\"";

/// The complaint about an axis of something that does not exist.
pub fn unknown_axis(name: &str) -> String {
    if !name.contains('.') {
        let others = SECTIONS.into_iter().filter(|section| *section != name);
        let near = || nearest(name, AXES.iter().map(|(_, axis, _)| *axis).chain(others));
        let near = near().map(|right| format!("; did you mean `{right}`?"));
        let exact = || parameter(name).is_some().then(|| suggested(name, "axes")).flatten();
        let hint = belongs(name).or_else(exact).or(near).unwrap_or_default();
        return format!("unknown key `{name}` in [axes]{hint} (it may have {AXIS_NAMES})");
    }
    let bare = name.strip_prefix("criterion.").unwrap_or(name);
    if let (Some((_, of_start)), true) = (bare.split_once('.'), bare.starts_with("start.")) {
        let near = nearest(of_start, StartValue::ALL.map(StartValue::name));
        let hint = near.map_or(String::new(), |near| format!("; did you mean `\"start.{near}\"`?"));
        return format!("there is no axis `{name}`{hint} (axes are {AXIS_NAMES})");
    }
    let near = || nearest(name, SCALARS.iter().map(|scalar| scalar.key)).and_then(parameter);
    let last = name.rsplit_once('.').map_or(name, |(_, last)| last);
    let meant = parameter(name).or_else(near).or_else(|| parameter(last));
    let hint = meant.map_or(String::new(), |scalar| format!("; did you mean {}?", place_in_job(scalar, "axes")));
    format!("there is no axis `{name}`{hint} (axes are {AXIS_NAMES})")
}

/// The table in which a key belongs that is no axis, as the end of a message.
fn belongs(wrong: &str) -> Option<String> {
    let of_criterion = || has_key::<CriterionSpec>(wrong).then(|| "criterion".to_owned());
    let right = table_with::<JobSpec>(wrong).or_else(of_criterion)?;
    Some(format!("; `{wrong}` belongs in [{right}]"))
}

/// The complaint about a random input that does not exist.
pub fn unknown_input(name: &str) -> String {
    if is_preload_force(name) {
        return format!("random.inputs: {AS_INPUT}");
    }
    let names = ["preload", "static_friction", "rotating_speed"];
    let names = || names.into_iter().chain(SCALARS.iter().map(|scalar| scalar.key));
    let near = || nearest(name, names().chain(StartValue::ALL.map(StartValue::key)));
    let meant = parameter(name).map(|scalar| axis_of(scalar.key).unwrap_or(scalar.key));
    let hint = meant.or_else(near);
    let hint = hint.map_or(String::new(), |hint| format!("; did you mean `{hint}`?"));
    format!(
        "random.inputs: there is no input \"{name}\"{hint} (preload, static_friction, rotating_speed, a parameter of the model as `section.name`, or a number of the start, for example `start.velocity`)"
    )
}

/// The names of all axes, each with what it is.
pub fn documented_axes() -> Vec<(String, String)> {
    let described = |(key, name, description): (&str, &str, &str)| {
        let of_model = scalar(key).map(|Scalar { unit, limits, .. }| {
            format!("{description}, unit {unit}, {limits}; by default that of the model")
        });
        (name.to_owned(), of_model.unwrap_or_else(|| description.to_owned()))
    };
    let mut axes = AXES.map(described).to_vec();
    let scalars = SCALARS.iter();
    axes.extend(
        scalars.map(|scalar| (scalar.key.to_owned(), format!("Expected {}, unit {}", scalar.description, scalar.unit))),
    );
    axes.push((preload_force::KEY.to_owned(), "Expected contact force in place of preload, unit N".to_owned()));
    axes.extend(StartValue::ALL.map(|value| {
        let description = value.description(&GivenStart::default());
        (value.key().to_owned(), format!("Expected {description}, unit as criterion.start.units"))
    }));
    axes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn symbols_and_names_of_job_specs_lead_to_the_parameter() {
        for (word, key) in [
            ("k_t1", "stiffness.contact_tangential_1"),
            ("k_en", "stiffness.contact_normal"),
            ("f_s", "friction.static_coefficient"),
            ("Delta", "operating_point.preload"),
            ("delta", "friction.stribeck_exponent"),
            ("Omega", "operating_point.rotating_speed"),
            ("omega", "operating_point.rotating_speed"),
            ("axes.preload", "operating_point.preload"),
            ("model.friction.static_coefficient", "friction.static_coefficient"),
            ("contact_normal", "stiffness.contact_normal"),
            ("speed", "operating_point.rotating_speed"),
        ] {
            assert_eq!(parameter(word).unwrap().key, key, "{word}");
            assert!(unknown_parameter(word, false).contains(&format!("did you mean `{key}`?")), "{word}");
        }
    }
}
