//! The amplitude that stick-slip settles to on a flexible disc.
//!
//! | state | on a cycle | then |
//! |---|---|---|
//! | summing | fewer than [`CYCLES_OF_MEAN`] amplitudes | they are added |
//! | | the last of them | a mean is made; settled if it agrees with the one before, or if it is the last allowed |
//! | any | stick-slip ends | no mean |

/// Amplitudes in a mean: the disc rings along, and single cycles differ.
const CYCLES_OF_MEAN: u32 = 10;

/// Two means in a row that agree to this have settled: a tenth of the width of a line in a plot.
const SETTLED_CHANGE: f64 = 1e-3;

/// A motion that goes on changing, as it may while the disc rings along, is given its last mean after this many.
const MOST_MEANS: u32 = 20;

/// Means of amplitudes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SettledAmplitude {
    sum: f64,
    summed: u32,
    means: u32,
    mean: f64,
}

impl SettledAmplitude {
    pub fn new() -> Self {
        Self { sum: 0.0, summed: 0, means: 0, mean: 0.0 }
    }

    /// Adds the amplitude of a cycle; whether the mean has settled with it.
    pub fn add(&mut self, amplitude: f64) -> bool {
        self.sum += amplitude;
        self.summed += 1;
        if self.summed < CYCLES_OF_MEAN {
            return false;
        }
        let mean = self.sum / f64::from(self.summed);
        let settled = self.means > 0 && (mean - self.mean).abs() <= SETTLED_CHANGE * mean;
        *self = Self { sum: 0.0, summed: 0, means: self.means + 1, mean };
        settled || self.means >= MOST_MEANS
    }

    /// The last mean, if there is one.
    pub fn value(&self) -> Option<f64> {
        (self.means > 0).then_some(self.mean)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// After how many cycles the amplitudes settle, and to what.
    fn settles(amplitude: impl Fn(u32) -> f64) -> (u32, f64) {
        let mut settled = SettledAmplitude::new();
        let cycles = (1..10_000).find(|&cycle| settled.add(amplitude(cycle))).unwrap();
        (cycles, settled.value().unwrap())
    }

    #[test]
    fn constant_amplitudes_settle_with_the_second_mean() {
        assert_eq!(settles(|_| 0.5), (20, 0.5));
    }

    #[test]
    fn amplitudes_that_scatter_settle_to_their_mean() {
        let (cycles, mean) = settles(|cycle| if cycle % 2 == 0 { 0.9 } else { 1.1 });
        assert_eq!(cycles, 20);
        assert!((mean - 1.0).abs() < 1e-12);
    }

    #[test]
    fn amplitudes_that_creep_towards_a_limit_settle_near_it() {
        let (cycles, mean) = settles(|cycle| 1.0 - 0.5 * (-0.05 * f64::from(cycle)).exp());
        assert!(cycles > 50 && cycles % 10 == 0, "{cycles}");
        assert!((mean - 1.0).abs() < 2e-3, "{mean}");
    }

    #[test]
    fn amplitudes_that_never_settle_are_given_their_last_mean() {
        assert_eq!(settles(f64::from).0, 200);
    }

    #[test]
    fn there_is_no_mean_before_ten_cycles() {
        let mut settled = SettledAmplitude::new();
        assert!((0..9).all(|_| !settled.add(1.0)));
        assert_eq!(settled.value(), None);
    }
}
