//! The degrees of freedom of pad and disc.

use std::fmt;

use crate::model::decision::Source;

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

impl DegreeOfFreedom {
    /// All of them; each is known by its place here, and in [`SOURCES`].
    pub const ALL: [Self; 4] = [Self::Tangential, Self::Normal, Self::Angular, Self::Disc];
}

/// What decisions name as feeding an unstable motion.
pub static SOURCES: [Source; 4] = [
    Source {
        name: "tangential",
        meaning: "unstable samples that would be stable if friction did not fall with speed, or whose fastest growing mode is the tangential motion of the pad",
    },
    Source {
        name: "normal",
        meaning: "unstable samples that grow even without falling friction, most in the normal motion of the pad",
    },
    Source {
        name: "angular",
        meaning: "unstable samples that grow even without falling friction, most in the rotation of the pad",
    },
    Source {
        name: "disc",
        meaning: "unstable samples that grow even without falling friction, most in the bending of the disc",
    },
];

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
