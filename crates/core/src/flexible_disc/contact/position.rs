//! Where the pad is, as far as the gap depends on it.

/// Displacement and tilt of the pad against the disc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PadPosition {
    /// y.
    pub normal: f64,
    /// tan(phi).
    pub tilt: f64,
}
