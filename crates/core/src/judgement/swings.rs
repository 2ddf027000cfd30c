//! Whether amplitudes grow or shrink from swing to swing.
//!
//! A swing leads from one turning point to the next; half of its length is an amplitude. Each is compared with a
//! reference, an earlier amplitude of the same motion:
//!
//! | state | a swing whose amplitude | trend | then |
//! |---|---|---|---|
//! | no reference | is any | unclear | it is the reference |
//! | reference | exceeds the reference by more than may be feigned | growing | it is the new reference |
//! | | falls short of it by more than may be feigned | shrinking | it is the new reference |
//! | | does neither | unclear | the same reference, until time has doubled since: then it is the new one |
//! | | has done neither for [`SUSTAINED`] swings and twice the time, with nothing left to be feigned | constant | the same reference |
//!
//! A stick makes an end of all references.

/// Changes that say nothing: errors of steps and of the interpolation of turning points. Amplitudes of a cycle differ by
/// 1e-6 with the steps in use, the more the less they resolve; this is a hundred times that.
const LEAST_CHANGE: f64 = 1e-4;

/// The reference is taken anew when time has doubled, at first after this many units of scaled time: six periods, so
/// that a slow trend adds up beyond [`LEAST_CHANGE`].
const FIRST_REFERENCE: f64 = 20.0;

/// Swings of constant amplitude that make a cycle without sticking.
const SUSTAINED: u32 = 100;

/// What amplitudes do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Trend {
    Growing,
    Shrinking,
    Constant,
    Unclear,
}

/// The amplitudes of a motion without sticking.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Swings {
    last_turn: Option<f64>,
    amplitude: f64,
    reference: Option<Reference>,
    /// Swings without a trend since the reference.
    unclear: u32,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Reference {
    amplitude: f64,
    time: f64,
    /// The amplitude that could be feigned then.
    feigned: f64,
}

impl Reference {
    fn grows_to(&self, amplitude: f64) -> bool {
        amplitude > self.amplitude * (1.0 + LEAST_CHANGE) + self.feigned
    }

    fn shrinks_to(&self, amplitude: f64) -> bool {
        // Half of what may be feigned: this decides nothing but when a motion near a stable equilibrium is at home.
        amplitude * (1.0 + LEAST_CHANGE + 0.5 * self.feigned / self.amplitude) < self.amplitude
    }
}

impl Swings {
    /// Of a motion that starts at a turning point, or not.
    pub fn new(starts_turning_at: Option<f64>) -> Self {
        Self { last_turn: starts_turning_at, amplitude: 0.0, reference: None, unclear: 0 }
    }

    /// The motion turns at `x`: the amplitude of the swing that ends there, if it began at a turning point.
    pub fn turns(&mut self, x: f64) -> Option<f64> {
        let before = self.last_turn.replace(x)?;
        self.amplitude = 0.5 * (x - before).abs();
        Some(self.amplitude)
    }

    /// The amplitude of the last swing.
    pub fn amplitude(&self) -> f64 {
        self.amplitude
    }

    /// The trend after a swing, if this amplitude may be feigned.
    pub fn trend(&mut self, time: f64, feigned: f64) -> Trend {
        let amplitude = self.amplitude;
        let now = Reference { amplitude, time, feigned };
        let Some(reference) = self.reference else {
            self.restart(Some(now));
            return Trend::Unclear;
        };
        if reference.grows_to(amplitude) {
            self.restart(Some(now));
            return Trend::Growing;
        }
        if reference.shrinks_to(amplitude) {
            self.restart(Some(now));
            return Trend::Shrinking;
        }
        self.unclear += 1;
        let has_doubled = time > 2.0 * reference.time + FIRST_REFERENCE;
        if has_doubled && self.unclear >= SUSTAINED && reference.feigned <= LEAST_CHANGE * amplitude {
            return Trend::Constant;
        }
        if has_doubled {
            self.restart(Some(now));
        }
        Trend::Unclear
    }

    /// The motion sticks at `x`: no later swing is compared with the ones before. Whether the swing that ends here, which
    /// is at least this long, had grown.
    pub fn sticks(&mut self, x: f64) -> bool {
        let reference = self.reference;
        self.restart(None);
        match (reference, self.last_turn) {
            (Some(reference), Some(turn)) => reference.grows_to(0.5 * (x - turn).abs()),
            _ => false,
        }
    }

    /// The next swing is the first to compare with.
    pub fn forget(&mut self) {
        self.restart(None);
    }

    fn restart(&mut self, reference: Option<Reference>) {
        self.reference = reference;
        self.unclear = 0;
    }
}
