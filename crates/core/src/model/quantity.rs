//! The quantities of a model: what users vary, and what its samples differ in.

use std::borrow::Cow;
use std::fmt;

/// An interval of admissible values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Lower end.
    pub minimum: f64,
    /// Whether the lower end itself is admissible.
    pub includes_minimum: bool,
    /// Upper end.
    pub maximum: f64,
    /// Whether the upper end itself is admissible.
    pub includes_maximum: bool,
}

impl Limits {
    /// Every number.
    pub const ANY: Self =
        Self { minimum: f64::NEG_INFINITY, includes_minimum: false, maximum: f64::INFINITY, includes_maximum: false };

    /// Above `minimum`, and at most `maximum`.
    #[must_use]
    pub const fn above(minimum: f64, maximum: f64) -> Self {
        Self { minimum, includes_minimum: false, maximum, includes_maximum: true }
    }

    /// At least `minimum`, and at most `maximum`.
    #[must_use]
    pub const fn from(minimum: f64, maximum: f64) -> Self {
        Self { minimum, includes_minimum: true, maximum, includes_maximum: true }
    }

    /// At least `minimum`, and below `maximum`.
    #[must_use]
    pub const fn from_below(minimum: f64, maximum: f64) -> Self {
        Self { minimum, includes_minimum: true, maximum, includes_maximum: false }
    }

    /// Whether `value` is admissible; NaN never is.
    #[must_use]
    pub fn contain(&self, value: f64) -> bool {
        let above = if self.includes_minimum { value >= self.minimum } else { value > self.minimum };
        let below = if self.includes_maximum { value <= self.maximum } else { value < self.maximum };
        above && below
    }
}

impl fmt::Display for Limits {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let lower = if self.includes_minimum { "at least" } else { "greater than" };
        let upper = if self.includes_maximum { "at most" } else { "less than" };
        match (self.minimum.is_finite(), self.maximum.is_finite()) {
            (true, true) => write!(f, "{lower} {} and {upper} {}", self.minimum, self.maximum),
            (true, false) => write!(f, "{lower} {}", self.minimum),
            (false, true) => write!(f, "{upper} {}", self.maximum),
            (false, false) => f.write_str("a finite number"),
        }
    }
}

/// What a quantity is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// It belongs to what samples share, and is prepared once where it does not scatter.
    Configuration,
    /// It differs from sample to sample at no cost: nothing is prepared for it. A model has none of these, or two:
    /// the pair in which it may know its boundary of stability in closed form.
    Input,
    /// It belongs to the state in which a motion starts.
    Start,
}

/// A quantity of a model.
#[derive(Debug, Clone, PartialEq)]
pub struct Quantity {
    /// Its name in job specs, for example `preload` or `pad.mass`.
    pub name: Cow<'static, str>,
    /// Its path in the tables of the model, for example `friction.static_coefficient`: another name for it.
    pub path: Cow<'static, str>,
    /// The name of the column of results that has its expected values.
    pub column: Cow<'static, str>,
    /// Its name in pictures.
    pub label: Cow<'static, str>,
    /// The symbol of the literature.
    pub symbol: Cow<'static, str>,
    /// SI unit; `1` for a pure number.
    pub unit: Cow<'static, str>,
    /// What it is, in a line.
    pub description: Cow<'static, str>,
    /// Admissible expected values.
    pub limits: Limits,
    /// What it is for.
    pub role: Role,
    /// Whether results and pictures show it although it has one value.
    pub is_always_shown: bool,
    /// Whether its standard deviation is not relative to its expected value, which may be zero.
    pub scatters_absolutely: bool,
    /// The axis of a plot, where it is not called by description and symbol.
    pub title: Option<Cow<'static, str>>,
    /// Whether it is the rate of change of the quantity before it, so that both make a phase plane.
    pub is_rate: bool,
    /// Whether it is a displacement over [`Model::length_scale`](super::Model::length_scale).
    pub is_over_length: bool,
    /// Whether it only says what of a sample counts, and changes nothing of it: cells that differ by it alone have the same
    /// samples.
    pub only_selects: bool,
}

impl Quantity {
    /// A quantity that goes by its name everywhere, with any value, as a part of the configuration.
    #[must_use]
    pub fn new(
        name: impl Into<Cow<'static, str>>,
        unit: &'static str,
        description: impl Into<Cow<'static, str>>,
    ) -> Self {
        let name = name.into();
        Self {
            path: name.clone(),
            column: name.clone(),
            label: name.clone(),
            symbol: name.clone(),
            name,
            unit: unit.into(),
            description: description.into(),
            limits: Limits::ANY,
            role: Role::Configuration,
            is_always_shown: false,
            scatters_absolutely: false,
            title: None,
            is_rate: false,
            is_over_length: false,
            only_selects: false,
        }
    }

    /// What it is in few words: its description up to a comma.
    #[must_use]
    pub fn noun(&self) -> &str {
        self.description.split(',').next().unwrap_or(&self.description)
    }

    /// What the column of its expected values has.
    #[must_use]
    pub fn meaning_of_expected(&self) -> String {
        match (self.is_always_shown, self.role) {
            (true, Role::Input) => format!("expected {}", self.description),
            (true, _) => self.description.to_string(),
            (false, _) => format!("expected value of {}: {}", self.name, self.description),
        }
    }
}
