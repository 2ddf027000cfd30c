//! Where a motion starts.

use crate::pad::contact_state::ContactState;

/// Where the tangential motion starts. Everything else starts from steady sliding of the model in use.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Start {
    /// At the sliding equilibrium, x displaced outwards by a stated fraction of x0: does steady sliding hold?
    NearEquilibrium,
    /// x = x' = 0, a brake that has just been applied: does it squeal?
    Rest,
    /// At the release from stick: does stick-slip keep itself going?
    LimitCycle,
}

/// The tangential motion at its start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TangentialStart {
    pub x: f64,
    pub speed: f64,
    pub contact: ContactState,
}

impl Start {
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
            Self::NearEquilibrium => {
                TangentialStart { x: equilibrium * (1.0 + displacement), speed: 0.0, contact: ContactState::Slip }
            }
            Self::Rest => TangentialStart { x: 0.0, speed: 0.0, contact: ContactState::Slip },
            Self::LimitCycle => TangentialStart { x: release(), speed: disc_speed, contact: ContactState::Stick },
        }
    }
}
