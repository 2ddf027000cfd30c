//! What is found of the least and the greatest probability.

use crate::integrate::closed_form::ExactProbability;

/// The least or the greatest probability.
#[derive(Debug, Clone, PartialEq)]
pub struct Extreme {
    /// The values at which it was found.
    pub at: Vec<f64>,
    /// The probability there.
    pub probability: ExactProbability,
    /// Proved: no value is beyond it. It is as near as the tolerance. `None` if this is not proved.
    pub bound: Option<f64>,
}

impl Extreme {
    /// Nothing was found.
    pub(super) fn unknown() -> Self {
        Self { at: Vec::new(), probability: ExactProbability { value: f64::NAN, error_bound: 1.0 }, bound: None }
    }
}

/// What a probability does as one quantity grows, everything else within its interval.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// It never falls.
    Rises,
    /// It never rises.
    Falls,
    /// It rises here and falls there.
    Turns,
    /// It neither rises nor falls.
    Constant,
}

impl Direction {
    /// Whether a derivative between these bounds cannot be against this direction.
    pub(super) fn allows(self, [low, high]: [f64; 2]) -> bool {
        match self {
            Self::Rises => low >= 0.0,
            Self::Falls => high <= 0.0,
            Self::Turns | Self::Constant => true,
        }
    }
}

/// A direction, and how it is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Trend {
    /// What the probability does.
    pub direction: Direction,
    /// Whether this is proved for the whole interval; otherwise it is so wherever it was looked at.
    pub is_proved: bool,
}

impl Trend {
    /// That of the directions that are left.
    pub(super) fn from_directions(left: &[Direction], is_proved: bool) -> Self {
        match *left {
            [] => Self { direction: Direction::Turns, is_proved: false },
            [direction] => Self { direction, is_proved },
            _ => Self { direction: Direction::Constant, is_proved },
        }
    }

    /// Both directions, of which those are struck off that are not so.
    pub(super) fn all() -> Vec<Direction> {
        vec![Direction::Rises, Direction::Falls]
    }
}

/// How far an extreme is certain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Evidence {
    /// Bounds of the derivatives leave no room for a value beyond it by more than the tolerance.
    Proved,
    /// The probability is monotonic in every quantity wherever it was looked at, and the extreme is at the ends that
    /// follow from this.
    Checked,
    /// It was searched for.
    Searched,
}
