//! The axes of a job, checked, and the brakes that they make.

use std::ops::Range;

use stickslip_core::motion::start::GivenStart;
use stickslip_core::parameters::{ParameterError, Parameters, SCALARS, Scalar, scalar};
use stickslip_core::rigid_disc::pad_on_disc::PadOnDisc;
use stickslip_sampler::grid::{Axis, Cell, FurtherAxis, Grid};

use super::axes_spec::{AxesSpec, AxisEntry, AxisSpec, RangeSpec, ScaleSpec};
use super::diagnosis::{Complaint, Complaints};
use super::keys::{axis_of, parameter_of_axis, unknown_axis};
use super::plausibility;
use super::preload_force::{self, PARAMETERS, PRELOAD, is_preload_force};
use super::spec::ModelSpec;
use super::start_value::StartValue;

/// Largest number of cells; their results are held in memory.
pub const MOST_CELLS: u64 = 1_000_000;

/// Brakes at most at which what must hold for all brakes of a job is checked.
const MOST_CORNERS: usize = 32;

/// The axes of a job, each checked alone; `None` in place of one that is refused.
pub struct CheckedAxes {
    /// Rotating speeds.
    pub rotating_speed: Option<Axis>,
    /// Expected preloads.
    pub preload: Option<Axis>,
    /// Expected static friction coefficients.
    pub static_friction: Option<Axis>,
    /// Further axes of the brake, in the order of [`SCALARS`].
    pub of_brake: Option<Vec<FurtherAxis>>,
    /// Axes of the start, in the order of [`StartValue::ALL`].
    pub of_start: Option<Vec<FurtherAxis>>,
}

impl CheckedAxes {
    /// Checks every axis. Those that are left out have the one value of the model.
    pub fn new(axes: &AxesSpec, model: &ModelSpec, defaults: &Parameters, complaints: &mut Complaints) -> Self {
        let before = complaints.len();
        for (i, entry) in axes.0.iter().enumerate() {
            complaints.push_some(unknown(entry).or_else(|| given_twice(entry, &axes.0[..i])));
        }
        let are_known = complaints.len() == before && !complaints.has_unread(&["axes"]);
        let [rotating_speed, static_friction] = ["rotating_speed", "static_friction"]
            .map(|name| parameter_of_axis(name).and_then(scalar))
            .map(|scalar| usual_axis(scalar?, axes, defaults, complaints));
        let further = SCALARS.iter().filter(|scalar| axis_of(scalar.key).is_none()).filter_map(|scalar| {
            let axis = complaints.take(checked(axes.of_parameter(scalar.key)?, scalar, defaults));
            Some(axis.map(|axis| FurtherAxis { name: scalar.key.to_owned(), axis }))
        });
        let of_brake = further.collect::<Vec<_>>().into_iter().collect::<Option<Vec<_>>>().filter(|_| are_known);
        let preload = match GivenForces::of(axes, model) {
            None => scalar(PRELOAD).and_then(|scalar| usual_axis(scalar, axes, defaults, complaints)),
            Some(forces) => {
                of_brake.as_ref().and_then(|of_brake| complaints.take(forces.preloads(axes, of_brake, defaults)))
            }
        };
        let of_start = StartValue::ALL.into_iter().filter_map(|value| {
            let entry = axes.0.iter().find(|entry| entry.name.get_ref() == value.key())?;
            let complain =
                |message: String| Complaint::at(entry.axis.span(), format!("axes.{}: {message}", value.key()));
            let axis = complaints.take(values(entry.axis.get_ref()).map_err(complain));
            Some(axis.map(|axis| FurtherAxis { name: value.key().to_owned(), axis }))
        });
        let of_start = of_start.collect::<Vec<_>>().into_iter().collect::<Option<Vec<_>>>();
        Self { rotating_speed, preload, static_friction, of_brake, of_start }
    }
}

/// The parameter that an axis has the values of.
fn parameter_of(entry: &AxisEntry) -> Option<&'static Scalar> {
    let name = entry.name.get_ref().as_str();
    if is_preload_force(name) {
        return scalar(PRELOAD);
    }
    scalar(parameter_of_axis(name).unwrap_or(name))
}

/// A complaint about an axis of something that does not exist.
fn unknown(entry: &AxisEntry) -> Option<Complaint> {
    let is_known = parameter_of(entry).is_some() || StartValue::from_key(entry.name.get_ref()).is_some();
    (!is_known).then(|| Complaint::at(entry.name.span(), unknown_axis(entry.name.get_ref())))
}

/// A complaint about an axis that one of those `before` is, too.
fn given_twice(entry: &AxisEntry, before: &[AxisEntry]) -> Option<Complaint> {
    let key = |entry: &AxisEntry| {
        let of_start = || StartValue::from_key(entry.name.get_ref()).map(StartValue::key);
        parameter_of(entry).map(|scalar| scalar.key).or_else(of_start)
    };
    let other = before.iter().find(|other| key(other).is_some() && key(other) == key(entry))?;
    let message = format!(
        "axes.{} is the same axis as axes.{}; remove one of the two",
        entry.name.get_ref(),
        other.name.get_ref()
    );
    Some(Complaint::at(entry.name.span(), message).and_at(other.name.span()))
}

/// An axis that every grid has; by default the one value of the model.
fn usual_axis(scalar: &Scalar, axes: &AxesSpec, defaults: &Parameters, complaints: &mut Complaints) -> Option<Axis> {
    match axes.of_parameter(scalar.key) {
        Some(entry) => complaints.take(checked(entry, scalar, defaults)),
        None => {
            let is_unread = complaints.has_unread(&["axes", axis_of(scalar.key).unwrap_or(scalar.key)]);
            Axis::from_values(vec![scalar.value(defaults)]).ok().filter(|_| !is_unread)
        }
    }
}

/// The values of an axis, within the limits of its parameter.
fn checked(entry: &AxisEntry, scalar: &Scalar, defaults: &Parameters) -> Result<Axis, Complaint> {
    let name = entry.name.get_ref();
    let complain = |message: String| Complaint::at(entry.axis.span(), format!("axes.{name}: {message}"));
    let axis = values(entry.axis.get_ref()).map_err(complain)?;
    match axis.values().iter().find(|value| !scalar.limits.contain(**value)) {
        None => Ok(axis),
        Some(&value) => {
            let unit = if scalar.unit == "1" { String::new() } else { format!(" (in {})", scalar.unit) };
            let hint = plausibility::hint(scalar.key, value, defaults);
            Err(complain(format!("{value} is out of range: it must be {}{unit}{hint}", scalar.limits)))
        }
    }
}

/// The values of an axis as written.
fn values(spec: &AxisSpec) -> Result<Axis, String> {
    let built = match spec {
        AxisSpec::Values(values) => Axis::from_values(values.clone()),
        // Refused before it is filled: a slipped digit must not fill the memory.
        AxisSpec::Range(range) if u64::from(range.points) > MOST_CELLS => {
            return Err(format!("{} points are too many; the limit is {MOST_CELLS}", range.points));
        }
        AxisSpec::Range(RangeSpec { from, to, points, scale }) => match scale {
            ScaleSpec::Linear => Axis::evenly_spaced(*from, *to, *points as usize),
            ScaleSpec::Log => Axis::log_spaced(*from, *to, *points as usize),
        },
    };
    built.map_err(|error| error.to_string())
}

/// Forces in place of preloads.
struct GivenForces {
    /// Their key.
    key: String,
    span: Range<usize>,
    forces: Result<Axis, String>,
}

impl GivenForces {
    /// Those of a job, if it gives any.
    fn of(axes: &AxesSpec, model: &ModelSpec) -> Option<Self> {
        if let Some(AxisEntry { name, axis }) = axes.of_parameter(PRELOAD) {
            let key = format!("axes.{}", name.get_ref());
            return is_preload_force(name.get_ref()).then(|| Self {
                key,
                span: axis.span(),
                forces: values(axis.get_ref()),
            });
        }
        let force = model.preload_force()?;
        let forces = values(&AxisSpec::Values(vec![*force.get_ref()]));
        Some(Self { key: format!("model.{}", preload_force::KEY), span: force.span(), forces })
    }

    /// The preloads that press with them.
    fn preloads(self, axes: &AxesSpec, of_brake: &[FurtherAxis], defaults: &Parameters) -> Result<Axis, Complaint> {
        let Self { key, span, forces } = self;
        let complain = |message: String| Complaint::at(span.clone(), format!("{key}{message}"));
        let mut parameters = defaults.clone();
        for FurtherAxis { name, axis } in of_brake.iter().filter(|further| PARAMETERS.contains(&&*further.name)) {
            let [value] = *axis.values() else {
                let message = format!(
                    ": the preload of a force depends on {name}, which is an axis with several values. Give axes.preload in place of the force, or {name} one value"
                );
                let other = axes.of_parameter(name).map(|entry| entry.axis.span());
                return Err(other.into_iter().fold(complain(message), Complaint::and_at));
            };
            // It is within its limits.
            let _ = parameters.set(name, value);
        }
        let forces = forces.map_err(|message| complain(format!(": {message}")))?;
        let preload = |&force: &f64| {
            preload_force::preload(force, &parameters).map_err(|message| complain(format!(": {force} {message}")))
        };
        let preloads = forces.values().iter().map(preload).collect::<Result<Vec<f64>, Complaint>>()?;
        Axis::from_values(preloads).map_err(|error| complain(format!(": {error}")))
    }
}

/// The parameters of all brakes of a grid, with the values that axes do not have.
pub struct Brakes<'a> {
    /// What is no axis. In place of the static friction coefficient it has the smallest one of the axis.
    pub parameters: &'a Parameters,
    /// The grid.
    pub grid: &'a Grid,
}

impl Brakes<'_> {
    /// The parameters in a cell.
    pub fn in_cell(&self, cell: &Cell) -> Result<Parameters, ParameterError> {
        let values = self.grid.further_values(cell.index);
        self.with(values.into_iter(), cell.rotating_speed)
    }

    /// The parameters of a brake by its index.
    pub fn parameters_of(&self, brake: usize) -> Result<Parameters, ParameterError> {
        self.in_cell(&self.grid.first_cell_with(brake))
    }

    fn with(&self, values: impl Iterator<Item = f64>, rotating_speed: f64) -> Result<Parameters, ParameterError> {
        let mut parameters = self.parameters.clone();
        for (FurtherAxis { name, .. }, value) in self.grid.of_brake.iter().zip(values) {
            parameters.set(name, value)?;
        }
        parameters.operating_point.rotating_speed = rotating_speed;
        Ok(parameters)
    }

    /// A given start with the values of its axes in a cell.
    pub fn start_in_cell(&self, mut start: GivenStart, cell: &Cell) -> GivenStart {
        let values = self.grid.further_values(cell.index);
        for (further, value) in self.grid.of_start.iter().zip(&values[self.grid.of_brake.len()..]) {
            if let Some(number) = StartValue::from_key(&further.name) {
                number.set(&mut start, *value);
            }
        }
        start
    }

    /// A given start with all combinations of the extremes of its axes.
    pub fn extreme_starts(&self, start: GivenStart) -> Vec<GivenStart> {
        let mut starts = vec![start];
        for further in &self.grid.of_start {
            let Some(number) = StartValue::from_key(&further.name) else { continue };
            let with = |start: &GivenStart, value: f64| {
                let mut start = *start;
                number.set(&mut start, value);
                start
            };
            let ends = further.axis.extremes();
            starts = starts.iter().flat_map(|start| ends.map(|value| with(start, value))).collect();
        }
        starts
    }

    /// Checks that the brakes at the extremes of the axes can be computed with.
    ///
    /// # Errors
    /// As [`PadOnDisc::new`].
    pub fn are_computable(&self) -> Result<(), ParameterError> {
        let corners = self.at_extremes(&self.grid.rotating_speed.extremes())?;
        corners.into_iter().try_for_each(|parameters| PadOnDisc::new(parameters).map(|_| ()))
    }

    /// The parameters at the extremes of the further axes, at each of these rotating speeds: all combinations, or if
    /// these are too many, all smallest values, all largest ones, and the smallest with one of the largest.
    ///
    /// # Errors
    /// None for axes that were checked, see [`settle`].
    pub fn at_extremes(&self, rotating_speeds: &[f64]) -> Result<Vec<Parameters>, ParameterError> {
        let extremes: Vec<[f64; 2]> = self.grid.of_brake.iter().map(|further| further.axis.extremes()).collect();
        let varying: Vec<usize> = (0..extremes.len()).filter(|&i| extremes[i][0] < extremes[i][1]).collect();
        let some = || {
            let one = varying.iter().map(|&axis| vec![axis]);
            [Vec::new(), varying.clone()].into_iter().chain(one).collect::<Vec<_>>()
        };
        let combinations = match u32::try_from(varying.len()).ok().and_then(|axes| 1usize.checked_shl(axes)) {
            Some(all) if all <= MOST_CORNERS => {
                let largest = |bits: usize| varying.iter().enumerate().filter(move |(i, _)| bits >> i & 1 == 1);
                (0..all).map(|bits| largest(bits).map(|(_, &axis)| axis).collect()).collect()
            }
            _ => some(),
        };
        let mut found = Vec::new();
        for &rotating_speed in rotating_speeds {
            for largest in &combinations {
                let value = |(axis, ends): (usize, &[f64; 2])| ends[usize::from(largest.contains(&axis))];
                found.push(self.with(extremes.iter().enumerate().map(value), rotating_speed)?);
            }
        }
        Ok(found)
    }
}

/// Puts the first value of every further axis into the parameters, and checks that values which must agree do so in
/// every cell.
///
/// # Errors
/// The first contradiction.
pub fn settle(parameters: &mut Parameters, of_brake: &[FurtherAxis]) -> Result<(), ParameterError> {
    // Each relation holds everywhere if it does between the largest of the smaller and the smallest of the larger. The
    // inner radius of the pad is the larger of one pair and the smaller of another.
    let largest = ["disc.inner_radius", "friction.kinetic_coefficient"];
    for pad_radius in [0, 1] {
        for FurtherAxis { name, axis } in of_brake {
            let of_pad = if name == "pad.inner_radius" { pad_radius } else { 0 };
            parameters.set(name, axis.extremes()[usize::from(largest.contains(&name.as_str())).max(of_pad)])?;
        }
        parameters.validate()?;
    }
    of_brake.iter().try_for_each(|FurtherAxis { name, axis }| parameters.set(name, axis.values()[0]))
}
