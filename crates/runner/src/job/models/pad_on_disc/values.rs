//! The values of `[model]`, checked.

use std::path::Path;

use stickslip_core::model::quantity::{Quantity, Role};
use stickslip_core::models::pad_on_disc::parameters::{ParameterError, Parameters};
use stickslip_sampler::grid::Axis;
use toml::Spanned;

use super::friction::{check_band, use_law};
use super::keys::{axis_of_parameter, unknown_parameter};
use super::plausibility;
use super::preload_force;
use super::tables::ModelSpec;
use crate::job::axes_spec::AxesSpec;
use crate::job::diagnosis::{Complaint, Complaints};

/// The preset with the overrides of a job, each within its limits. `None` if any is refused.
///
/// Files that it names are sought in `folder`.
pub fn validate_model(
    model: &ModelSpec,
    axes: &AxesSpec,
    folder: &Path,
    complaints: &mut Complaints,
) -> Option<Parameters> {
    let before = complaints.len();
    if let Some(preset) = &model.preset
        && preset.get_ref() != "sui-ding-2018"
    {
        let message = format!("model.preset: unknown preset {:?}; there is \"sui-ding-2018\"", preset.get_ref());
        complaints.push(Complaint::at(preset.span(), message));
    }
    let mut parameters = Parameters::sui_ding_2018();
    use_law(&model.friction, folder, &mut parameters.friction, complaints);
    for (section, overrides) in model.sections() {
        for (name, value) in overrides {
            let key = format!("{section}.{}", name.get_ref());
            if key == preload_force::KEY {
                // What it makes of the preload depends on the axes, see `CheckedAxes`.
                complaints.push_some(given_twice(&key, value, axes).or_else(|| given_as_preload(value, model)));
                continue;
            }
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
    if complaints.len() == before {
        let band = model.friction.values.iter().find(|(name, _)| name.get_ref() == "band");
        let checked = check_band(&parameters.friction, false);
        let span = band.map(|(_, value)| value.span());
        complaints.take(checked.map_err(|message| Complaint::maybe_at(span, format!("model.{message}"))));
    }
    (complaints.len() == before && !complaints.has_unread(&["model"])).then_some(parameters)
}

/// A complaint about a value of the model that an axis has too.
fn given_twice(key: &str, value: &Spanned<f64>, axes: &AxesSpec) -> Option<Complaint> {
    let entry = axis_of_parameter(axes, if key == preload_force::KEY { preload_force::PRELOAD } else { key })?;
    let message = format!(
        "model.{key} = {} is given a second time as axes.{}, which has the values that are used; remove one of the two",
        value.get_ref(),
        entry.name.get_ref()
    );
    Some(Complaint::at(value.span(), message).and_at(entry.axis.span()))
}

/// A complaint about a force in place of the preload, which is given too.
fn given_as_preload(force: &Spanned<f64>, model: &ModelSpec) -> Option<Complaint> {
    let mut others = model.operating_point.iter();
    let (name, preload) = others.find(|(name, _)| preload_force::PRELOAD.ends_with(&format!(".{}", name.get_ref())))?;
    let message = format!(
        "model.{} = {} is given a second time as model.{} = {}; remove one of the two",
        preload_force::KEY,
        force.get_ref(),
        preload_force::PRELOAD,
        preload.get_ref()
    );
    Some(Complaint::at(force.span(), message).and_at(name.span()))
}

/// A contradiction between two values, with the place in the text that brought it about.
pub fn contradiction(axes: &AxesSpec, model: &ModelSpec, error: &ParameterError) -> Complaint {
    let message = error.to_string();
    if let ParameterError::Contradiction { key, other_key, .. } = error {
        if let Some(entry) = [*key, *other_key].into_iter().find_map(|key| axis_of_parameter(axes, key)) {
            let what = if key.starts_with("friction.") { "the friction law" } else { "the model" };
            let message = format!("axes.{} contradicts {what}: {message}", entry.name.get_ref());
            return Complaint::at(entry.axis.span(), message);
        }
        for wanted in [*key, *other_key] {
            for (section, overrides) in model.sections() {
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

/// Puts the first value of every axis that results do not always show into the parameters, and checks that values which must agree do so in
/// every cell.
///
/// # Errors
/// The first contradiction.
pub fn settle(
    parameters: &mut Parameters,
    quantities: &[Quantity],
    axes: &[(usize, Axis)],
) -> Result<(), ParameterError> {
    let is_further = |quantity: &Quantity| quantity.role == Role::Configuration && !quantity.is_always_shown;
    let further = axes.iter().filter(|(place, _)| is_further(&quantities[*place]));
    let further: Vec<(&str, &Axis)> = further.map(|(place, axis)| (&*quantities[*place].name, axis)).collect();
    // Each relation holds everywhere if it does between the largest of the smaller and the smallest of the larger. The
    // radii of the pad are the larger of one pair and the smaller of another.
    let always_largest = ["disc.inner_radius", "friction.kinetic_coefficient"];
    for largest_of_pad in [&[][..], &["pad.inner_radius"], &["pad.inner_radius", "pad.effective_radius"]] {
        for &(name, axis) in &further {
            let is_largest = always_largest.contains(&name) || largest_of_pad.contains(&name);
            parameters.set(name, axis.extremes()[usize::from(is_largest)])?;
        }
        parameters.validate()?;
    }
    further.iter().try_for_each(|(name, axis)| parameters.set(name, axis.values()[0]))
}
