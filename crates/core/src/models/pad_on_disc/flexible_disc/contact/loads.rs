//! The loads of the contact.

use crate::models::pad_on_disc::flexible_disc::plate_modes::MOST_REFERENCE_MODES;

/// Largest number of amplitudes: a cosine and a sine for every mode.
pub(crate) const MOST_AMPLITUDES: usize = 2 * MOST_REFERENCE_MODES;

/// The loads of the contact, before they are multiplied by stiffness and friction.
#[derive(Debug, Clone)]
pub(crate) struct ContactLoads {
    /// `<g+>`.
    pub pressure: f64,
    /// `<psi_k g+>`.
    pub on_modes: [f64; MOST_AMPLITUDES],
    /// `<psi_k g+ w_theta / r>`, times [`LENGTH_UNIT`](crate::models::pad_on_disc::flexible_disc::contact::patch::LENGTH_UNIT) over `h / b`:
    /// the slope is for one unit of length along the disc.
    pub follower: [f64; MOST_AMPLITUDES],
}

impl ContactLoads {
    pub fn zero() -> Self {
        Self { pressure: 0.0, on_modes: [0.0; MOST_AMPLITUDES], follower: [0.0; MOST_AMPLITUDES] }
    }
}
