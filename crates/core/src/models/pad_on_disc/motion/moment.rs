//! Everything that is recorded of pad and disc at one moment.

use crate::models::pad_on_disc::pad::contact_state::ContactState;
use crate::models::pad_on_disc::pad::equations::PAD;

/// Pad, contact and disc at one moment; lengths over h, scaled time, forces in N.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// Scaled time.
    pub time: f64,
    /// x, and its speed.
    pub tangential: (f64, f64),
    /// y, and its speed.
    pub normal: (f64, f64),
    /// phi in rad, and its speed.
    pub angle: (f64, f64),
    /// v - x'.
    pub sliding_speed: f64,
    /// Friction force over contact force, with the direction of the friction on the pad; 0 without contact.
    pub friction_coefficient: f64,
    /// F, N.
    pub friction_force: f64,
    /// P, N.
    pub contact_force: f64,
    /// Whether pad and disc stick.
    pub sticks: bool,
    /// Share of the patch in contact.
    pub contact_share: f64,
    /// w at the middle of the pad's arc (theta = 0): at the outer edge, and a quarter of the way from the clamped to
    /// the outer edge. 0 for a rigid disc.
    pub deflection: (f64, f64),
}

/// What the contact adds to the state of the pad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RecordedContact {
    pub state: ContactState,
    /// P, N.
    pub force: f64,
    /// mu s: friction over pressure.
    pub friction_ratio: f64,
}

impl Moment {
    /// The moment of a pad with the displacements `q` and speeds `u` of x, y and phi, wholly in contact with a flat
    /// disc.
    pub(crate) fn of_pad(time: f64, q: [f64; PAD], u: [f64; PAD], disc_speed: f64, contact: RecordedContact) -> Self {
        let friction_coefficient = if contact.force > 0.0 { contact.friction_ratio } else { 0.0 };
        Self {
            time,
            tangential: (q[0], u[0]),
            normal: (q[1], u[1]),
            angle: (q[2], u[2]),
            sliding_speed: disc_speed - u[0],
            friction_coefficient,
            friction_force: friction_coefficient * contact.force,
            contact_force: contact.force,
            sticks: contact.state == ContactState::Stick,
            contact_share: 1.0,
            deflection: (0.0, 0.0),
        }
    }
}
