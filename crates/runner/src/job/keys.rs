//! Which key a user may have meant.

use stickslip_core::parameters::{SCALARS, Scalar};

use super::preload_force;
use super::start_value::StartValue;

/// The sections of the model, in the order of the model's table.
pub const SECTIONS: [&str; 6] = ["disc", "pad", "stiffness", "damping", "friction", "operating_point"];

/// The keys of a job spec outside `[model]`, by table.
pub const TABLES: [(&str, &[&str]); 6] = [
    ("axes", &["rotating_speed", "preload", "preload_force", "static_friction"]),
    ("random", &["inputs", "relative_std", "std", "distribution", "correlation"]),
    (
        "criterion",
        &["kind", "disc", "disc_modes", "start", "displacement", "horizon", "index", "outside_physics", "record"],
    ),
    (
        "sampling",
        &[
            "method",
            "samples",
            "until",
            "seed",
            "evaluate",
            "audit",
            "randomisations",
            "particles",
            "common_random_numbers",
            "confidence",
            "interval",
            "simultaneous",
            "derivatives",
            "sensitivity",
        ],
    ),
    ("limit", &["of", "probability"]),
    ("engine", &["partition", "account", "time", "memory", "cpus_per_task", "shards", "max_shards", "sbatch"]),
];

/// Parameters that are axes of a job, with the names that they have there.
const AXES: [(&str, &str); 3] = [
    ("operating_point.rotating_speed", "rotating_speed"),
    ("operating_point.preload", "preload"),
    ("friction.static_coefficient", "static_friction"),
];

/// The axis of a job that has the values of a parameter.
pub fn axis_of(key: &str) -> Option<&'static str> {
    AXES.iter().find(|(parameter, _)| *parameter == key).map(|(_, axis)| *axis)
}

/// The parameter whose values an axis has.
pub fn parameter_of_axis(axis: &str) -> Option<&'static str> {
    AXES.iter().find(|(_, name)| *name == axis).map(|(parameter, _)| *parameter)
}

/// The candidate that `wrong` is most likely a misspelling of, if any is near enough.
pub fn nearest<'a>(wrong: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let scored = candidates.into_iter().map(|candidate| (strsim::jaro_winkler(wrong, candidate), candidate));
    scored.filter(|(score, _)| *score >= 0.8).max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, candidate)| candidate)
}

/// The parameter that a word names otherwise than by its key: by the symbol of the paper (`k_en`), by its name alone
/// (`contact_normal`), as a job spec does (`axes.preload`, `model.pad.mass`), or by a part of its name (`speed`).
pub fn parameter(word: &str) -> Option<&'static Scalar> {
    let bare = word.strip_prefix("model.").unwrap_or(word);
    let axis = word.strip_prefix("axes.").unwrap_or(word);
    let by = |matches: &dyn Fn(&Scalar) -> bool| SCALARS.iter().find(|scalar| matches(scalar));
    let has_part = |scalar: &&Scalar| scalar.name().split('_').any(|part| part == word);
    let with_part = || SCALARS.iter().find(has_part).filter(|_| SCALARS.iter().filter(has_part).count() == 1);
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

/// The key of a job spec that may have been meant by one that `table` does not have, among those that it has and those
/// of other tables, as the end of a message.
pub fn suggestion(wrong: &str, table: &str, candidates: &[&str]) -> String {
    if let Some((right, _)) = TABLES.iter().find(|(_, keys)| keys.contains(&wrong)) {
        return format!("; `{wrong}` belongs in [{right}]");
    }
    if let Some(right) = nearest(wrong, candidates.iter().copied()) {
        return format!("; did you mean `{right}`?");
    }
    let meant = parameter(wrong).or_else(|| parameter(&format!("{table}.{wrong}")));
    meant.map_or(String::new(), |scalar| format!("; did you mean {}?", place_in_job(scalar, table)))
}

/// The complaint about a key of the parameters that does not exist. `in_job` tells a job spec from `--set`.
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

/// The complaint about an axis, with a dot in its name, of something that does not exist.
pub fn unknown_axis(name: &str) -> String {
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
