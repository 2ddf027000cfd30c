//! The brakes at the extremes of the axes of a job.

use stickslip_core::models::pad_on_disc::model::{ROTATING_SPEED, configuration_scalars};
use stickslip_core::models::pad_on_disc::motion::start::GivenStart;
use stickslip_core::models::pad_on_disc::motion::start_value::StartValue;
use stickslip_core::models::pad_on_disc::parameters::{ParameterError, Parameters, SCALARS, Scalar};
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;
use stickslip_sampler::grid::{Axis, Grid};

/// Brakes at most at which what must hold for all brakes of a job is checked.
const MOST_CORNERS: usize = 32;

/// The brakes of a grid, with the values that axes do not have.
pub struct Corners<'a> {
    parameters: &'a Parameters,
    grid: &'a Grid,
}

/// The parameter at a place in the list of quantities.
pub fn scalar_at(place: usize) -> Option<&'static Scalar> {
    configuration_scalars().nth(place.checked_sub(2)?)
}

impl<'a> Corners<'a> {
    /// The brakes of a grid. In place of the static friction coefficient `parameters` have the smallest one of its axis.
    pub fn new(parameters: &'a Parameters, grid: &'a Grid) -> Self {
        Self { parameters, grid }
    }

    /// The axis of the rotating speed.
    pub fn speeds(&self) -> Axis {
        // Every grid has it.
        let own = self.grid.axis_of(ROTATING_SPEED).cloned();
        own.or_else(|| Axis::from_values(self.grid.values_of(ROTATING_SPEED)).ok()).unwrap_or_else(|| unreachable!())
    }

    /// Checks that the brakes can be computed with.
    ///
    /// # Errors
    /// As [`PadOnDisc::new`].
    pub fn are_computable(&self) -> Result<(), ParameterError> {
        let corners = self.at_extremes(&self.speeds().extremes())?;
        corners.into_iter().try_for_each(|parameters| PadOnDisc::new(parameters).map(|_| ()))
    }

    /// The parameters at the extremes of the other axes, at each of these rotating speeds: all combinations, or if
    /// these are too many, all smallest values, all largest ones, and the smallest with one of the largest.
    ///
    /// # Errors
    /// None for axes that were checked, see [`settle`](super::values::settle).
    pub fn at_extremes(&self, rotating_speeds: &[f64]) -> Result<Vec<Parameters>, ParameterError> {
        let axes = self.grid.axes.iter().filter(|axis| axis.quantity != ROTATING_SPEED);
        let axes: Vec<(&'static Scalar, [f64; 2])> =
            axes.filter_map(|axis| Some((scalar_at(axis.quantity)?, axis.axis.extremes()))).collect();
        let varying: Vec<usize> = (0..axes.len()).filter(|&i| axes[i].1[0] < axes[i].1[1]).collect();
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
                let mut parameters = self.parameters.clone();
                for (axis, (scalar, ends)) in axes.iter().enumerate() {
                    parameters.set(scalar.key, ends[usize::from(largest.contains(&axis))])?;
                }
                parameters.operating_point.rotating_speed = rotating_speed;
                found.push(parameters);
            }
        }
        Ok(found)
    }

    /// A given start with all combinations of the extremes of its axes.
    pub fn extreme_starts(&self, start: GivenStart) -> Vec<GivenStart> {
        let mut starts = vec![start];
        for axis in &self.grid.axes {
            let Some(number) = start_value_at(axis.quantity) else { continue };
            let with = |start: &GivenStart, value: f64| {
                let mut start = *start;
                number.set(&mut start, value);
                start
            };
            let ends = axis.axis.extremes();
            starts = starts.iter().flat_map(|start| ends.map(|value| with(start, value))).collect();
        }
        starts
    }
}

/// The number of the start at a place in the list of quantities.
pub fn start_value_at(place: usize) -> Option<StartValue> {
    StartValue::ALL.get(place.checked_sub(SCALARS.len())?).copied()
}
