//! What was observed in the tests.

use stickslip_core::rigid_disc::stability::StabilityBoundary;

/// Tests that only say whether a brake squealed, in equal conditions.
#[derive(Debug, Clone, Copy)]
pub(super) struct Verdicts {
    pub(super) preload: f64,
    pub(super) boundary: StabilityBoundary,
    pub(super) squealed: f64,
    pub(super) quiet: f64,
}

/// A test that says at which speed a brake began to squeal.
#[derive(Debug, Clone, Copy)]
pub(super) struct Onset {
    pub(super) preload: f64,
    /// The boundaries a little below and above that speed.
    pub(super) boundaries: [StabilityBoundary; 2],
    /// The logarithm of the quotient of the two speeds.
    pub(super) width: f64,
}

/// The tests. Their order has no effect but on rounding.
#[derive(Debug, Clone, Default)]
pub struct TestData {
    pub(super) verdicts: Vec<Verdicts>,
    pub(super) onsets: Vec<Onset>,
}

impl TestData {
    /// Adds `count` tests with a nominal preload, with the boundary at their rotating speed.
    pub fn add_verdict(&mut self, preload: f64, boundary: &StabilityBoundary, squealed: bool, count: u64) {
        let alike = |verdicts: &&mut Verdicts| verdicts.preload == preload && verdicts.boundary == *boundary;
        let counted = count as f64;
        let [more_squealed, more_quiet] = if squealed { [counted, 0.0] } else { [0.0, counted] };
        match self.verdicts.iter_mut().find(alike) {
            Some(verdicts) => {
                verdicts.squealed += more_squealed;
                verdicts.quiet += more_quiet;
            }
            None => self.verdicts.push(Verdicts {
                preload,
                boundary: *boundary,
                squealed: more_squealed,
                quiet: more_quiet,
            }),
        }
    }

    /// Adds a test with a nominal preload in which squeal began at a speed, with the boundaries at two speeds a little
    /// below and above it.
    pub fn add_onset(&mut self, preload: f64, boundaries: [StabilityBoundary; 2], speeds: [f64; 2]) {
        self.onsets.push(Onset { preload, boundaries, width: libm::log(speeds[1] / speeds[0]) });
    }

    /// How many onset speeds and different conditions of verdicts there are.
    #[must_use]
    pub fn conditions(&self) -> usize {
        self.verdicts.len() + self.onsets.len()
    }

    /// How many tests squealed, and how many did not.
    #[must_use]
    pub fn counts(&self) -> [f64; 2] {
        let sum = |of: fn(&Verdicts) -> f64| self.verdicts.iter().map(of).sum::<f64>();
        [sum(|verdicts| verdicts.squealed) + self.onsets.len() as f64, sum(|verdicts| verdicts.quiet)]
    }
}
