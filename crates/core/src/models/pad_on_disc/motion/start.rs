//! Where a motion starts.

use thiserror::Error;

use crate::models::pad_on_disc::motion::integrator::{Equations, FARTHEST, Motion};
use crate::models::pad_on_disc::pad::contact_state::ContactState;
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::Scales;

/// A start whose speed differs from the disc's by less than this share of it moves with the disc: it was meant to.
const SAME_SPEED: f64 = 1e-9;

/// Where a motion starts. What a start does not say is as in steady sliding of the model in use.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Start {
    /// At the sliding equilibrium, x displaced outwards by a stated fraction of x0: does steady sliding hold?
    NearEquilibrium,
    /// x = x' = 0, a brake that has just been applied: does it squeal?
    Rest,
    /// At the release from stick: does stick-slip keep itself going?
    LimitCycle,
    /// In a given state: what does this knock, or this displacement, lead to?
    Given(GivenStart),
}

/// A state that a motion starts in. What is `None` is as in steady sliding of the model in use, and so is everything
/// that it does not mention: y' = phi' = 0, and the deflection of the disc.
///
/// The state of contact follows. A pad slower than the disc slips, a faster one overtakes it. One as fast as the disc
/// (to 1e-9 of its speed) sticks if static friction can hold it there; otherwise it slips or overtakes as the force on
/// it points.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GivenStart {
    /// x.
    pub tangential: Option<f64>,
    /// x'.
    pub velocity: Option<f64>,
    /// y. It has no effect on a rigid disc, where the normal motion does not act back on the tangential one.
    pub normal: Option<f64>,
    /// phi, rad. It has no effect on a rigid disc either.
    pub angle: Option<f64>,
    /// Whether x, y and phi count from steady sliding, instead of from the state without forces.
    pub from_equilibrium: bool,
    /// The units of x, x' and y.
    pub units: StartUnits,
}

/// Units of displacements and speeds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum StartUnits {
    /// m and m/s.
    #[default]
    Si,
    /// The disc's thickness h, and h over the time scale.
    Scaled,
}

/// Why no motion can start in a given state.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum StartError {
    /// Farther away, or faster, than any pad can be.
    #[error(
        "a start at x = {tangential:e} h with x' = {velocity:e} h/tau (in scaled units) is out of the disc's reach: the motion \
         would go farther than {FARTHEST} thicknesses of the disc"
    )]
    OutOfReach {
        /// x, scaled.
        tangential: f64,
        /// x', scaled.
        velocity: f64,
    },
    /// The pad does not touch the disc.
    #[error(
        "at y = {normal:e} h, phi = {angle:e} rad (in scaled units) the pad does not touch the disc; it is in contact near the \
         y of steady sliding, {steady:e} h"
    )]
    LiftedOff {
        /// y, scaled.
        normal: f64,
        /// phi.
        angle: f64,
        /// y of steady sliding, scaled.
        steady: f64,
    },
}

/// The tangential motion at its start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TangentialStart {
    pub x: f64,
    pub speed: f64,
}

impl Start {
    /// The same start in scaled units.
    pub(crate) fn scaled(self, scales: &Scales) -> Self {
        match self {
            Self::Given(given) => Self::Given(given.scaled(scales)),
            named => named,
        }
    }

    /// x and its speed at the start: `displacement` is relative to the `equilibrium`, and `release` gives the x at
    /// which static friction can just hold the pad.
    pub(crate) fn tangential(
        self,
        displacement: f64,
        equilibrium: f64,
        release: impl FnOnce() -> f64,
        disc_speed: f64,
    ) -> TangentialStart {
        match self {
            Self::NearEquilibrium => TangentialStart { x: equilibrium * (1.0 + displacement), speed: 0.0 },
            Self::Rest => TangentialStart { x: 0.0, speed: 0.0 },
            Self::LimitCycle => TangentialStart { x: release(), speed: disc_speed },
            Self::Given(given) => {
                let speed = given.velocity.unwrap_or(0.0);
                let is_same = (speed - disc_speed).abs() <= SAME_SPEED * disc_speed;
                let x = given.displaced(given.tangential, equilibrium);
                TangentialStart { x, speed: if is_same { disc_speed } else { speed } }
            }
        }
    }

    /// y and phi at the start, if those of steady sliding are these.
    pub(crate) fn normal_and_angle(self, (normal, angle): (f64, f64)) -> (f64, f64) {
        match self {
            Self::Given(given) => (given.displaced(given.normal, normal), given.displaced(given.angle, angle)),
            _ => (normal, angle),
        }
    }

    /// The motion that starts in a state.
    pub(crate) fn motion<E: Equations>(self, equations: &E, state: E::State) -> Motion<E::State> {
        let contact = match self {
            Self::NearEquilibrium | Self::Rest => ContactState::Slip,
            Self::LimitCycle => ContactState::Stick,
            Self::Given(_) => contact_of(equations, &state),
        };
        Motion { state, contact }
    }
}

/// The state of contact that follows from the sliding speed, and where that vanishes, from the reserve of static
/// friction.
fn contact_of<E: Equations>(equations: &E, state: &E::State) -> ContactState {
    let sliding = equations.disc_speed() - equations.tangential(state).1;
    if sliding > 0.0 {
        return ContactState::Slip;
    }
    if sliding < 0.0 {
        return ContactState::Overtaking;
    }
    let reserve = equations.reserve(state);
    match (reserve.against_slip > 0.0, reserve.against_overtaking > 0.0) {
        (true, true) => ContactState::Stick,
        (false, _) => ContactState::Slip,
        (true, false) => ContactState::Overtaking,
    }
}

impl GivenStart {
    fn scaled(self, scales: &Scales) -> Self {
        match self.units {
            StartUnits::Scaled => self,
            StartUnits::Si => Self {
                tangential: self.tangential.map(|x| x / scales.length),
                velocity: self.velocity.map(|speed| speed / scales.speed),
                normal: self.normal.map(|y| y / scales.length),
                units: StartUnits::Scaled,
                ..self
            },
        }
    }

    fn displaced(&self, given: Option<f64>, steady: f64) -> f64 {
        match given {
            None => steady,
            Some(from_steady) if self.from_equilibrium => steady + from_steady,
            Some(value) => value,
        }
    }
}

/// Checks that a pad with this tangential stiffness over its mass can be there.
///
/// # Errors
/// [`StartError::OutOfReach`].
pub(crate) fn check_reach((x, speed): (f64, f64), stiffness: f64) -> Result<(), StartError> {
    if x.abs() < FARTHEST && speed.abs() < FARTHEST * stiffness.sqrt() {
        Ok(())
    } else {
        Err(StartError::OutOfReach { tangential: x, velocity: speed })
    }
}
