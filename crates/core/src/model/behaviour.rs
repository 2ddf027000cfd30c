//! What a motion does, beside its verdict.

/// What steady motion with given values of all quantities does, in SI units.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Behaviour {
    /// Growth rate of small perturbations of it, 1/s; `None` if it cannot be computed.
    pub growth_rate: Option<f64>,
    /// The limit cycle about it, if there is one.
    pub cycle: Option<Cycle>,
}

/// A limit cycle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cycle {
    /// Half peak to peak, m.
    pub amplitude: f64,
    /// Hz.
    pub frequency: f64,
    /// The share of its period spent in stick; 0 in a cycle without sticking.
    pub stick: f64,
}

/// Finds the behaviour with these values of all quantities; `None` if there is no such configuration. What the last one
/// has in common with the next is not computed again.
pub type Behaviours<'a> = Box<dyn FnMut(&[f64]) -> Option<Behaviour> + 'a>;
