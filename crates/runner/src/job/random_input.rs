//! A random input: one parameter that scatters.

use stickslip_core::parameters::{Parameters, SCALARS, Scalar, scalar};
use stickslip_sampler::grid::Grid;

use super::keys::{axis_of, nearest, parameter};
use super::preload_force::{AS_INPUT, is_preload_force};
use super::start_value::StartValue;

/// An input that scatters.
#[derive(Debug, Clone, Copy)]
pub enum RandomInput {
    /// The preload Delta.
    Preload,
    /// The static friction coefficient f_s.
    StaticFriction,
    /// Any other parameter; its expected value is the model's, or that of its axis.
    Other(&'static Scalar),
    /// A number of the start of a motion. It scatters by a standard deviation that is not relative to its expected
    /// value.
    Start(StartValue),
}

impl RandomInput {
    /// As in a job spec.
    pub fn name(self) -> &'static str {
        match self {
            Self::Preload => "preload",
            Self::StaticFriction => "static_friction",
            Self::Other(_) if self.is_rotating_speed() => "rotating_speed",
            Self::Other(scalar) => scalar.key,
            Self::Start(value) => value.key(),
        }
    }

    /// The parameter, if it is neither preload nor static friction.
    pub fn scalar(self) -> Option<&'static Scalar> {
        match self {
            Self::Preload | Self::StaticFriction | Self::Start(_) => None,
            Self::Other(scalar) => Some(scalar),
        }
    }

    /// From its name in a job spec.
    pub fn from_name(name: &str) -> Result<Self, String> {
        match name {
            "preload" => return Ok(Self::Preload),
            "static_friction" => return Ok(Self::StaticFriction),
            _ => {}
        }
        if is_preload_force(name) {
            return Err(format!("random.inputs: {AS_INPUT}"));
        }
        if let ("rotating_speed", Some(scalar)) = (name, scalar("operating_point.rotating_speed")) {
            return Ok(Self::Other(scalar));
        }
        if let Some(axis) = axis_of(name) {
            return Err(format!("random.inputs: write \"{axis}\" for \"{name}\", as in [axes]"));
        }
        if let Some(scalar) = scalar(name) {
            return Ok(Self::Other(scalar));
        }
        if let Some(value) = StartValue::from_key(name) {
            return Ok(Self::Start(value));
        }
        let names = ["preload", "static_friction", "rotating_speed"];
        let names = || names.into_iter().chain(SCALARS.iter().map(|scalar| scalar.key));
        let near = || nearest(name, names().chain(StartValue::ALL.map(StartValue::key)));
        let meant = parameter(name).map(|scalar| axis_of(scalar.key).unwrap_or(scalar.key));
        let hint = meant.or_else(near);
        let hint = hint.map_or(String::new(), |hint| format!("; did you mean `{hint}`?"));
        Err(format!(
            "random.inputs: there is no input \"{name}\"{hint} (preload, static_friction, rotating_speed, a parameter of the model as `section.name`, or a number of the start, for example `start.velocity`)"
        ))
    }

    /// Its expected values over all cells, and the key that has them. Those of the start are not looked at.
    pub fn all_expected(self, parameters: &Parameters, grid: &Grid) -> (Vec<f64>, String) {
        match self {
            Self::Preload => (grid.preload.values().to_vec(), "axes.preload".to_owned()),
            Self::StaticFriction => (grid.static_friction.values().to_vec(), "axes.static_friction".to_owned()),
            Self::Other(_) if self.is_rotating_speed() => {
                (grid.rotating_speed.values().to_vec(), "axes.rotating_speed".to_owned())
            }
            Self::Other(scalar) => match grid.further().find(|further| further.name == scalar.key) {
                Some(further) => (further.axis.values().to_vec(), format!("axes.{}", scalar.key)),
                None => (vec![scalar.value(parameters)], format!("model.{}", scalar.key)),
            },
            Self::Start(value) => (Vec::new(), value.key().to_owned()),
        }
    }

    /// Whether its standard deviation is not relative to its expected value: of numbers of the start, and of the shift
    /// of a measured friction curve, which counts standard deviations itself.
    pub fn scatters_absolutely(self) -> bool {
        match self {
            Self::Start(_) => true,
            Self::Other(scalar) => scalar.key == "friction.band",
            Self::Preload | Self::StaticFriction => false,
        }
    }

    /// Whether it is the rotating speed, which has an axis.
    pub fn is_rotating_speed(self) -> bool {
        matches!(self, Self::Other(scalar) if scalar.key == "operating_point.rotating_speed")
    }

    /// Its place in the order in which deviates are drawn: preload, static friction, then the model's parameters.
    pub fn rank(self) -> usize {
        match self {
            Self::Preload => 0,
            Self::StaticFriction => 1,
            Self::Other(scalar) => 2 + SCALARS.iter().position(|other| other.key == scalar.key).unwrap_or(0),
            Self::Start(value) => 2 + SCALARS.len() + value as usize,
        }
    }
}

/// The position of an input that a key other than `inputs` names.
pub fn position(inputs: &[RandomInput], name: &str, key: &str) -> Result<usize, String> {
    if is_preload_force(name) {
        return Err(format!("random.{key}: {AS_INPUT}"));
    }
    inputs
        .iter()
        .position(|input| input.name() == name)
        .ok_or_else(|| format!("random.{key} gives a value for {name}, but random.inputs does not list {name}"))
}
