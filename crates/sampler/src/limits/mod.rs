//! At which values of an axis the probability of instability passes a target.
//!
//! | module | contents |
//! |---|---|
//! | [`scan`] | crossings of a probability that can be estimated at any value: a scan, and a bracketing root finder |
//! | [`spans`] | between which expected values of one of two inputs a sample is unstable, in closed form |
//! | [`sweep`] | crossings of the share of unstable samples, with bounds, from these spans |
//! | [`randomised`] | the same samples in groups that are counted apart, at any value |

pub mod scan;

pub mod spans;

pub mod sweep;

pub mod randomised;

/// What a probability does at a limit, as the value of the axis grows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// It rises through the target: below the limit it is within the target.
    Rises,
    /// It falls through the target: above the limit it is within the target.
    Falls,
    /// There is no limit: it is within the target on the whole range.
    Within,
    /// There is no limit: it is above the target on the whole range.
    Above,
}

impl State {
    /// Without a limit, by whether the probability exceeds the target.
    fn without_limit(is_over: bool) -> Self {
        if is_over { Self::Above } else { Self::Within }
    }

    /// Where the probability exceeds the target beyond a limit, or below it.
    fn passing(is_over_beyond: bool) -> Self {
        if is_over_beyond { Self::Rises } else { Self::Falls }
    }
}

/// A value at which a probability passes a target, or that there is none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limit {
    /// What the probability does there.
    pub state: State,
    /// The value; `None` if the estimate does not pass the target.
    pub value: Option<f64>,
    /// Between which values the true limit lies. Without a limit, where the interval of the probability contains the
    /// target; `None` if nowhere. A bound at an end of the range may lie beyond it.
    pub bounds: Option<[f64; 2]>,
}
