//! What can be recorded of samples that are decided by linear stability.

use crate::model::recorded::{RecordedOf, RecordedResult};
use crate::models::pad_on_disc::flexible_disc::brake::FlexibleBrake;
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};

/// A figure of steady sliding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LinearResult {
    /// The largest real part of the eigenvalues, 1/s.
    GrowthRate,
    /// The highest rotating speed at which steady sliding is unstable with the preload and the friction of the sample,
    /// rad/s; 0 where it is stable at every speed.
    CriticalSpeed,
    /// The preload above which steady sliding is unstable with the friction of the sample, at its rotating speed.
    CriticalPreload,
}

impl LinearResult {
    /// All of them, in the order in which they are recorded.
    pub const ALL: [Self; 3] = [Self::GrowthRate, Self::CriticalSpeed, Self::CriticalPreload];

    /// Its description.
    #[must_use]
    pub fn described(self) -> RecordedResult {
        let (name, unit, noun, meaning) = match self {
            Self::GrowthRate => ("growth_rate", "1/s", "growth rate", "largest real part of the eigenvalues"),
            Self::CriticalSpeed => (
                "critical_speed",
                "rad/s",
                "critical speed",
                "highest rotating speed at which steady sliding is unstable, 0 if it is stable at every speed",
            ),
            Self::CriticalPreload => {
                ("critical_preload", "1", "critical preload", "preload above which steady sliding is unstable")
            }
        };
        // The critical preload is a constant over what friction drives with, which may be next to nothing.
        let has_mean = self != Self::CriticalPreload;
        RecordedResult { name, unit, noun, meaning, of: RecordedOf::All, is_length: false, has_mean }
    }

    /// Its value for a brake with these inputs, with the disc of the criterion if that is flexible. `None` where there is
    /// none: an infinite critical speed or preload, and eigenvalues that are not found.
    pub(super) fn value(
        self,
        brake: &PadOnDisc,
        flexible: Option<&FlexibleBrake>,
        inputs: RandomInputs,
    ) -> Option<f64> {
        let value = match self {
            Self::GrowthRate => {
                let rate = flexible.map_or(Some(brake.growth_rate()), |disc| disc.growth_rate(inputs).ok());
                brake.scales().per_second(rate?)
            }
            Self::CriticalSpeed => brake.unstable_speeds().last().map_or(0.0, |range| range.to),
            Self::CriticalPreload => brake.stability_boundary().critical_first(inputs.static_friction),
        };
        value.is_finite().then_some(value)
    }
}

/// Which of them are recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LinearRecord([bool; LinearResult::ALL.len()]);

impl LinearRecord {
    /// These.
    #[must_use]
    pub fn of(results: &[LinearResult]) -> Self {
        Self(LinearResult::ALL.map(|result| results.contains(&result)))
    }

    /// Those that are recorded, in the order of [`LinearResult::ALL`].
    pub fn results(self) -> impl Iterator<Item = LinearResult> {
        LinearResult::ALL.into_iter().zip(self.0).filter(|(_, is_recorded)| *is_recorded).map(|(result, _)| result)
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self == Self::default()
    }
}
