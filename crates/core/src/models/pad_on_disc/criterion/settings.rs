//! Settings of a simulation in time.

use thiserror::Error;

use crate::models::pad_on_disc::motion::start::Start;

/// Default horizon, in scaled time.
pub const HORIZON: f64 = 10_000.0;

/// Default displacement of a start near the equilibrium, relative to x0.
pub(crate) const DISPLACEMENT: f64 = 0.01;

/// How the motion of a sample is simulated and decided.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeDomainSettings {
    /// Where it starts.
    pub start: Start,
    /// Displacement over x0, greater than 0 and at most 1000. For other starts it is only the distance from the
    /// equilibrium at which a shrinking motion counts as having returned.
    pub displacement: f64,
    /// Scaled time after which a sample is undecided, greater than 0 and at most 1e9.
    pub horizon: f64,
    /// The paper's own index: a sample is unstable if the settled amplitude (half peak to peak of x) exceeds this,
    /// greater than 0 and at most 1000. By default (`None`) it is unstable if its motion grows or keeps to stick-slip.
    pub amplitude_index: Option<f64>,
    /// Whether unstable motions are simulated until their amplitude has settled.
    pub record_amplitude: bool,
}

impl Default for TimeDomainSettings {
    fn default() -> Self {
        Self {
            start: Start::NearEquilibrium,
            displacement: DISPLACEMENT,
            horizon: HORIZON,
            amplitude_index: None,
            record_amplitude: false,
        }
    }
}

/// A setting out of range.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum SettingsError {
    /// Out of range or not a number.
    #[error("{key} = {value} is out of range: it must be greater than 0 and at most {largest}")]
    OutOfRange {
        /// Which setting.
        key: &'static str,
        /// Its value.
        value: f64,
        /// The limit.
        largest: f64,
    },
}

impl TimeDomainSettings {
    /// Checks every value.
    ///
    /// # Errors
    /// [`SettingsError`] with the first one that is out of range.
    pub fn validate(&self) -> Result<(), SettingsError> {
        let check = |key, value: f64, largest| {
            if value > 0.0 && value <= largest {
                Ok(())
            } else {
                Err(SettingsError::OutOfRange { key, value, largest })
            }
        };
        check("displacement", self.displacement, 1e3)?;
        check("horizon", self.horizon, 1e9)?;
        self.amplitude_index.map_or(Ok(()), |amplitude| check("amplitude_index", amplitude, 1e3))
    }

    pub(crate) fn until_settled(&self) -> bool {
        self.record_amplitude || self.amplitude_index.is_some()
    }
}
