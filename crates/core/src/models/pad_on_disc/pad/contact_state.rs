//! The states of contact between pad and disc.

/// How pad and disc move against each other at the contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum ContactState {
    /// The disc passes under the pad, `x' < v`.
    Slip,
    /// They move together, `x' = v`.
    Stick,
    /// The pad overtakes the disc, `x' > v`.
    Overtaking,
}

impl ContactState {
    /// s, the direction of friction while the pad slides.
    #[inline(always)]
    pub fn direction(self) -> f64 {
        if self == Self::Overtaking { -1.0 } else { 1.0 }
    }
}
