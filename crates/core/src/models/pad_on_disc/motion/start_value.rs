//! The numbers of a given start: their names, units and meaning.

use crate::models::pad_on_disc::motion::start::{GivenStart, StartUnits};

/// A number of a given start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum StartValue {
    /// x.
    Tangential,
    /// x'.
    Velocity,
    /// y.
    Normal,
    /// phi.
    Angle,
}

impl StartValue {
    /// All of them, in the order in which they vary as axes and are drawn as random inputs.
    pub const ALL: [Self; 4] = [Self::Tangential, Self::Velocity, Self::Normal, Self::Angle];

    /// As a job spec names it, for example `start.velocity`.
    #[must_use]
    pub fn key(self) -> &'static str {
        match self {
            Self::Tangential => "start.tangential",
            Self::Velocity => "start.velocity",
            Self::Normal => "start.normal",
            Self::Angle => "start.angle",
        }
    }

    /// As the table `criterion.start` names it.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.key().trim_start_matches("start.")
    }

    /// From its key.
    #[must_use]
    pub fn from_key(key: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|value| value.key() == key)
    }

    /// Its unit.
    #[must_use]
    pub fn unit(self, units: StartUnits) -> &'static str {
        match (self, units) {
            (Self::Angle, _) => "rad",
            (_, StartUnits::Scaled) => "1",
            (Self::Velocity, StartUnits::Si) => "m/s",
            (Self::Tangential | Self::Normal, StartUnits::Si) => "m",
        }
    }

    /// What it is.
    #[must_use]
    pub fn description(self, start: &GivenStart) -> String {
        let what = match self {
            Self::Tangential => "tangential displacement of the pad at the start",
            Self::Velocity => return "tangential speed of the pad at the start".to_owned(),
            Self::Normal => "normal displacement of the pad at the start",
            Self::Angle => "rotation of the pad at the start",
        };
        if start.from_equilibrium { format!("{what}, from steady sliding") } else { what.to_owned() }
    }

    /// The axis of a plot.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::Tangential => "Tangential displacement x at the start",
            Self::Velocity => "Tangential velocity x′ at the start",
            Self::Normal => "Normal displacement y at the start",
            Self::Angle => "Angle φ at the start",
        }
    }

    /// Its value in a start.
    #[must_use]
    pub fn value_in(self, start: &GivenStart) -> Option<f64> {
        match self {
            Self::Tangential => start.tangential,
            Self::Velocity => start.velocity,
            Self::Normal => start.normal,
            Self::Angle => start.angle,
        }
    }

    /// Sets its value in a start.
    pub fn set(self, start: &mut GivenStart, value: f64) {
        let place = match self {
            Self::Tangential => &mut start.tangential,
            Self::Velocity => &mut start.velocity,
            Self::Normal => &mut start.normal,
            Self::Angle => &mut start.angle,
        };
        *place = Some(value);
    }

    /// Whether steady sliding has a value that is known without computing it: 0.
    #[must_use]
    pub fn is_zero_when_left_out(self, start: &GivenStart) -> bool {
        self == Self::Velocity || start.from_equilibrium
    }
}
