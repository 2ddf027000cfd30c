//! Errors of models with a flexible disc.

use thiserror::Error;

use crate::models::pad_on_disc::flexible_disc::compliance::LEAST_COMPLIANCE;
use crate::models::pad_on_disc::flexible_disc::plate_modes::MOST_DISC_MODES;
use crate::models::pad_on_disc::parameters::ParameterError;
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::LARGEST_ROTATION;
use crate::numerics::eigenvalues::EigenvalueError;

/// Why there is no flexible model, or no equilibrium of it.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum FlexibleError {
    /// The disc as a plate could not be computed.
    #[error("the modes of the disc: {0}")]
    Modes(#[from] EigenvalueError),
    /// Values that contradict each other.
    #[error(transparent)]
    Parameters(#[from] ParameterError),
    /// A number of modes that is not available.
    #[error("{count} disc modes: there must be at least 1 and at most {MOST_DISC_MODES}")]
    ModeCount {
        /// The requested number.
        count: usize,
    },
    /// The kept modes are too stiff: the disc would be nearly rigid.
    #[error(
        "{count} disc modes carry only {:.0} % of the disc's compliance under the pad; at least {:.0} % are needed, with this disc {needed} modes",
        100.0 * .share, 100.0 * LEAST_COMPLIANCE
    )]
    TooFewModes {
        /// The requested number.
        count: usize,
        /// What they carry.
        share: f64,
        /// How many would do; more than [`MOST_DISC_MODES`] if none.
        needed: usize,
    },
    /// Nothing presses pad and disc together.
    #[error("there is no sliding equilibrium: preload {preload} does not press the pad on the disc")]
    NotPressed {
        /// The preload.
        preload: f64,
    },
    /// The search for the equilibrium did not end.
    #[error(
        "no sliding equilibrium was found (preload {preload}, static friction {static_friction}), neither from that of a rigid disc nor from that under a small load: is the disc far too soft?"
    )]
    NoEquilibrium {
        /// The preload.
        preload: f64,
        /// The static friction coefficient.
        static_friction: f64,
    },
    /// The equilibrium is none of the model.
    #[error(
        "the pad is turned by {angle:.3} rad in steady sliding, and the model holds up to {LARGEST_ROTATION} rad: is the disc or the calliper's spring against rotation (stiffness.calliper_angular) far too soft?"
    )]
    Rotated {
        /// The rotation, rad.
        angle: f64,
    },
}
