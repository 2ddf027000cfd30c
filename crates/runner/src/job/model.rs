//! The model and the axes of a job, checked.

use stickslip_core::parameters::{ParameterError, Parameters, Scalar, scalar};
use stickslip_sampler::grid::Axis;
use toml::Spanned;

use super::diagnosis::{Complaint, Complaints};
use super::keys::{axis_of, parameter_of_axis, unknown_parameter};
use super::plausibility;
use super::spec::{AxesSpec, AxisSpec, JobSpec, ModelSpec};

/// Largest number of cells; their results are held in memory.
pub const MOST_CELLS: u64 = 1_000_000;

/// The preset with the overrides of a job, each within its limits. `None` if any is refused.
pub fn validate_model(model: &ModelSpec, axes: &AxesSpec, complaints: &mut Complaints) -> Option<Parameters> {
    let before = complaints.len();
    if let Some(preset) = &model.preset
        && preset.get_ref() != "sui-ding-2018"
    {
        let message = format!("model.preset: unknown preset {:?}; there is \"sui-ding-2018\"", preset.get_ref());
        complaints.push(Complaint::at(preset.span(), message));
    }
    let mut parameters = Parameters::sui_ding_2018();
    for (section, overrides) in model.sections() {
        for (name, value) in overrides {
            let key = format!("{section}.{}", name.get_ref());
            match parameters.set(&key, *value.get_ref()) {
                Ok(()) => complaints.push_some(given_twice(&key, value, axes)),
                Err(ParameterError::Unknown { .. }) => {
                    complaints.push(Complaint::at(name.span(), unknown_parameter(&key, true)));
                }
                Err(error) => {
                    let hint = plausibility::hint(&key, *value.get_ref(), &parameters);
                    complaints.push(Complaint::at(value.span(), format!("model.{error}{hint}")));
                }
            }
        }
    }
    (complaints.len() == before && !complaints.has_unread(&["model"])).then_some(parameters)
}

/// A complaint about a value of the model that an axis has too.
fn given_twice(key: &str, value: &Spanned<f64>, axes: &AxesSpec) -> Option<Complaint> {
    let name = axis_of(key)?;
    let axis = axis(name, axes)?;
    let message = format!(
        "model.{key} = {} is given a second time as axes.{name}, which has the values that are used; remove one of the two",
        value.get_ref()
    );
    Some(Complaint::at(value.span(), message).and_at(axis.span()))
}

/// The axis of a name, if the job has it.
fn axis<'a>(name: &str, axes: &'a AxesSpec) -> Option<&'a Spanned<AxisSpec>> {
    match name {
        "rotating_speed" => axes.rotating_speed.as_ref(),
        "preload" => axes.preload.as_ref(),
        _ => axes.static_friction.as_ref(),
    }
}

/// One axis of the grid; by default the one value of the model.
pub fn validate_axis(name: &str, axes: &AxesSpec, defaults: &Parameters, complaints: &mut Complaints) -> Option<Axis> {
    let scalar = parameter_of_axis(name).and_then(scalar)?;
    let Some(spec) = axis(name, axes) else {
        let default = Axis::from_values(vec![scalar.value(defaults)]).ok();
        return default.filter(|_| !complaints.has_unread(&["axes", name]));
    };
    let checked = values_of_axis(name, spec.get_ref(), scalar, defaults);
    complaints.take(checked.map_err(|message| Complaint::at(spec.span(), message)))
}

fn values_of_axis(name: &str, spec: &AxisSpec, scalar: &Scalar, defaults: &Parameters) -> Result<Axis, String> {
    let built = match spec {
        AxisSpec::Values(values) => Axis::from_values(values.clone()),
        // Refused before it is filled: a slipped digit must not fill the memory.
        AxisSpec::Range(range) if u64::from(range.points) > MOST_CELLS => {
            return Err(format!("axes.{name}: {} points are too many; the limit is {MOST_CELLS}", range.points));
        }
        AxisSpec::Range(range) => Axis::evenly_spaced(range.from, range.to, range.points as usize),
    };
    let axis = built.map_err(|error| format!("axes.{name}: {error}"))?;
    match axis.values().iter().find(|value| !scalar.limits.contain(**value)) {
        None => Ok(axis),
        Some(&value) => {
            let unit = if scalar.unit == "1" { String::new() } else { format!(" (in {})", scalar.unit) };
            let hint = plausibility::hint(scalar.key, value, defaults);
            Err(format!("axes.{name}: {value} is out of range: it must be {}{unit}{hint}", scalar.limits))
        }
    }
}

/// A contradiction between two values, with the place in the text that brought it about.
pub fn contradiction(spec: &JobSpec, error: &ParameterError) -> Complaint {
    let message = error.to_string();
    if let ParameterError::Contradiction { key, other_key, .. } = error {
        let involves_friction = [*key, *other_key].contains(&"friction.static_coefficient");
        if let (true, Some(axis)) = (involves_friction, &spec.axes.static_friction) {
            let message = format!("axes.static_friction contradicts the friction law: {message}");
            return Complaint::at(axis.span(), message);
        }
        for wanted in [*key, *other_key] {
            for (section, overrides) in spec.model.sections() {
                for (name, value) in overrides {
                    if wanted.split_once('.') == Some((section, name.get_ref())) {
                        return Complaint::at(value.span(), format!("model: {message}"));
                    }
                }
            }
        }
    }
    Complaint::maybe_at(None, format!("model: {message}"))
}
