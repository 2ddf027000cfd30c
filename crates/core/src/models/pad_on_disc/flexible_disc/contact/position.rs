//! Where the pad is, as far as the gap depends on it.

/// Displacement and tilt of the pad against the disc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PadPosition {
    /// y.
    pub normal: f64,
    /// tan(phi) times [`LENGTH_UNIT`](crate::models::pad_on_disc::flexible_disc::contact::patch::LENGTH_UNIT) over `h / b`: how the gap
    /// falls along the disc, for one unit of length there.
    pub tilt: f64,
}
