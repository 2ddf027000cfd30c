//! What can be recorded of samples that are decided by linear stability.

use std::cell::OnceCell;

use crate::model::recorded::{RecordedOf, RecordedResult};
use crate::models::pad_on_disc::flexible_disc::brake::FlexibleBrake;
use crate::models::pad_on_disc::rigid_disc::limit_cycle::LimitCycle;
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};
use crate::numerics::eigenvalues::Eigenvalue;

/// A figure of steady sliding, or of the limit cycle about it, with or without sticking.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LinearResult {
    /// The largest real part of the eigenvalues, 1/s.
    GrowthRate,
    /// The frequency of that eigenvalue, its imaginary part in Hz; 0 where the motion does not oscillate.
    Frequency,
    /// The highest rotating speed at which steady sliding is unstable with the preload and the friction of the sample,
    /// rad/s; 0 where it is stable at every speed.
    CriticalSpeed,
    /// Half peak to peak of the tangential displacement over the limit cycle on a rigid disc, m.
    CycleAmplitude,
    /// The frequency of that cycle, Hz.
    CycleFrequency,
    /// The root mean square of the tangential velocity over that cycle, m/s: radiated power goes with its square.
    CycleVelocity,
    /// The preload above which steady sliding is unstable with the friction of the sample, at its rotating speed.
    CriticalPreload,
}

/// A brake with all its values, of which figures are asked for.
pub(super) struct Sample<'a> {
    brake: &'a PadOnDisc,
    /// With the disc of the criterion, if that is flexible.
    flexible: Option<&'a FlexibleBrake>,
    inputs: RandomInputs,
    /// Whether the tangential motion is the only one.
    is_tangential: bool,
    cycle: OnceCell<Option<LimitCycle>>,
}

impl<'a> Sample<'a> {
    pub(super) fn new(
        brake: &'a PadOnDisc,
        flexible: Option<&'a FlexibleBrake>,
        inputs: RandomInputs,
        record: LinearRecord,
    ) -> Self {
        Self { brake, flexible, inputs, is_tangential: record.is_tangential, cycle: OnceCell::new() }
    }

    /// The eigenvalue with the largest real part, per unit of scaled time; `None` if eigenvalues are not found.
    fn least_stable(&self) -> Option<Eigenvalue> {
        match self.flexible {
            None if self.is_tangential => Some(self.brake.tangential_eigenvalue()),
            None => Some(self.brake.least_stable_eigenvalue()),
            Some(disc) => disc.least_stable(self.inputs).ok(),
        }
    }

    fn cycle(&self) -> Option<LimitCycle> {
        *self.cycle.get_or_init(|| self.brake.limit_cycle())
    }
}

impl LinearResult {
    /// All of them, in the order in which they are recorded: that without a mean is the last.
    pub const ALL: [Self; 7] = [
        Self::GrowthRate,
        Self::Frequency,
        Self::CriticalSpeed,
        Self::CycleAmplitude,
        Self::CycleFrequency,
        Self::CycleVelocity,
        Self::CriticalPreload,
    ];

    /// Its description.
    #[must_use]
    pub fn described(self) -> RecordedResult {
        let (name, unit, noun, meaning) = match self {
            Self::GrowthRate => ("growth_rate", "1/s", "growth rate", "largest real part of the eigenvalues"),
            Self::Frequency => ("frequency", "Hz", "frequency", "that of the eigenvalue with the largest real part"),
            Self::CriticalSpeed => (
                "critical_speed",
                "rad/s",
                "critical speed",
                "highest rotating speed at which steady sliding is unstable, 0 if it is stable at every speed",
            ),
            Self::CycleAmplitude => {
                ("cycle_amplitude", "m", "limit cycle amplitude", "half peak to peak of x over the limit cycle")
            }
            Self::CycleFrequency => ("cycle_frequency", "Hz", "limit cycle frequency", "that of the limit cycle"),
            Self::CycleVelocity => (
                "cycle_velocity",
                "m/s",
                "limit cycle velocity",
                "root mean square of x' over the limit cycle; radiated power goes with its square",
            ),
            Self::CriticalPreload => {
                ("critical_preload", "1", "critical preload", "preload above which steady sliding is unstable")
            }
        };
        // The critical preload is a constant over what friction drives with, which may be next to nothing.
        let has_mean = self != Self::CriticalPreload;
        RecordedResult { name, unit, noun, meaning, of: RecordedOf::All, is_length: false, has_mean }
    }

    /// Its value; `None` where there is none: an infinite critical speed or preload, no limit cycle, and eigenvalues that are
    /// not found.
    pub(super) fn value(self, sample: &Sample<'_>) -> Option<f64> {
        let scales = sample.brake.scales();
        let value = match self {
            Self::GrowthRate => scales.per_second(sample.least_stable()?.re),
            Self::Frequency => scales.hertz(sample.least_stable()?.im.abs() / std::f64::consts::TAU),
            Self::CriticalSpeed => sample.brake.unstable_speeds().last().map_or(0.0, |range| range.to),
            Self::CycleAmplitude => {
                let cycle = sample.cycle()?;
                scales.metres(0.5 * (cycle.tangential_max - cycle.tangential_min))
            }
            Self::CycleFrequency => scales.hertz(1.0 / sample.cycle()?.period),
            Self::CycleVelocity => scales.metres_per_second(sample.brake.rms_velocity(&sample.cycle()?)?),
            Self::CriticalPreload => sample.brake.stability_boundary().critical_first(sample.inputs.static_friction),
        };
        value.is_finite().then_some(value)
    }
}

/// Which of them are recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LinearRecord {
    results: [bool; LinearResult::ALL.len()],
    /// Whether growth rate and frequency are those of the tangential motion, whatever the others do.
    pub(super) is_tangential: bool,
}

impl LinearRecord {
    /// These.
    #[must_use]
    pub fn of(results: &[LinearResult]) -> Self {
        Self { results: LinearResult::ALL.map(|result| results.contains(&result)), is_tangential: false }
    }

    /// The same of the tangential motion alone: of a model that has no other.
    #[must_use]
    pub fn tangential(self) -> Self {
        Self { is_tangential: true, ..self }
    }

    /// Those that are recorded, in the order of [`LinearResult::ALL`].
    pub fn results(self) -> impl Iterator<Item = LinearResult> {
        LinearResult::ALL
            .into_iter()
            .zip(self.results)
            .filter(|(_, is_recorded)| *is_recorded)
            .map(|(result, _)| result)
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self.results == Self::default().results
    }
}
