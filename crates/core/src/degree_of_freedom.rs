//! The degrees of freedom of pad and disc.

use std::fmt;

/// A degree of freedom of pad and disc.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum DegreeOfFreedom {
    /// x, along the motion of the disc.
    Tangential,
    /// y, along the disc's axis.
    Normal,
    /// phi, the rotation of the pad.
    Angular,
    /// The bending of the disc.
    Disc,
}

impl fmt::Display for DegreeOfFreedom {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Tangential => "tangential motion of the pad",
            Self::Normal => "normal motion of the pad",
            Self::Angular => "rotation of the pad",
            Self::Disc => "bending of the disc",
        })
    }
}
