//! Derivatives of the probability of instability from the samples that estimate the probability itself.
//!
//! The score of a sample is the derivative of the logarithm of its density: for an input `m (1 + s z)`
//!
//! ```text
//! by m (s constant):  (z + s (z^2 - 1)) / (m s) = z (1 + s z) / (m s) - 1 / m,
//! by s:               (z^2 - 1) / s
//! ```
//!
//! and the derivative of the probability is the expected value of the score where the sample is unstable, 0 elsewhere
//! (R. Y. Rubinstein, A. Shapiro, Discrete Event Systems, 1993). No sample is judged twice, and nothing is
//! asked of how the verdict depends on the input.
//!
//! Sums are kept in integers, so that no result depends on the order of the samples. What is summed is the score
//! times `m s` or `s`, which is of the size of 1 however small the scatter.

use crate::grid::Cell;

/// Sums are kept in units of 2^-20: rounding adds less than a millionth to each term.
const UNITS: f64 = (1_u64 << 20) as f64;

/// Terms are kept within this: a deviate of 10 stays below for relative standard deviations up to 9. A square is then
/// at most 2^40 units, and 2^22 of them fit in 64 bits.
const LARGEST: f64 = 1024.0;

/// The numbers of a cell by which a probability is differentiated, in the order of the sums.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CellNumber {
    /// Expected preload, at constant relative standard deviation.
    Preload,
    /// Expected static friction coefficient, at constant relative standard deviation.
    StaticFriction,
    /// Relative standard deviation of the preload.
    StdPreload,
    /// Relative standard deviation of the static friction coefficient.
    StdStaticFriction,
}

impl CellNumber {
    /// All of them, in the order of the sums.
    pub const ALL: [Self; 4] = [Self::Preload, Self::StaticFriction, Self::StdPreload, Self::StdStaticFriction];

    /// What a score by this number is multiplied with before it is summed; 0 for an input without scatter.
    fn scale(self, cell: &Cell) -> f64 {
        let std = cell.relative_std;
        match self {
            Self::Preload => cell.preload * std.preload,
            Self::StaticFriction => cell.static_friction * std.static_friction,
            Self::StdPreload if cell.preload != 0.0 => std.preload,
            Self::StdStaticFriction if cell.static_friction != 0.0 => std.static_friction,
            Self::StdPreload | Self::StdStaticFriction => 0.0,
        }
    }
}

/// The scores of a sample with these deviates, in the order of [`CellNumber::ALL`]; 0 for an input without scatter.
#[must_use]
pub fn scores(cell: &Cell, z_preload: Option<f64>, z_static_friction: Option<f64>) -> [f64; 4] {
    let scaled = scaled_scores(cell, z_preload, z_static_friction);
    std::array::from_fn(|i| {
        let scale = CellNumber::ALL[i].scale(cell);
        if scale == 0.0 { 0.0 } else { scaled[i] / scale }
    })
}

/// The scores times the standard deviation or the relative standard deviation of their input.
fn scaled_scores(cell: &Cell, z_preload: Option<f64>, z_static_friction: Option<f64>) -> [f64; 4] {
    let terms = |z: Option<f64>, std: f64| {
        let second = z.map_or(0.0, |z| z * z - 1.0);
        [z.unwrap_or(0.0) + std * second, second]
    };
    let preload = terms(z_preload, cell.relative_std.preload);
    let friction = terms(z_static_friction, cell.relative_std.static_friction);
    [preload[0], friction[0], preload[1], friction[1]]
}

/// Sums over some unstable samples of one cell, up to 2^22 of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ScoreSums {
    /// Sums of the scores times their scale, in units of 2^-20.
    pub sums: [i64; 4],
    /// Sums of their squares, in the same units.
    pub squares: [i64; 4],
}

impl ScoreSums {
    /// Adds an unstable sample with these deviates, `None` for an input without scatter.
    #[inline]
    pub fn add(&mut self, cell: &Cell, z_preload: Option<f64>, z_static_friction: Option<f64>) {
        for (i, score) in scaled_scores(cell, z_preload, z_static_friction).into_iter().enumerate() {
            let score = score.clamp(-LARGEST, LARGEST);
            // A conversion to an integer makes 0 of NaN.
            self.sums[i] = self.sums[i].saturating_add((score * UNITS).round() as i64);
            self.squares[i] = self.squares[i].saturating_add((score * score * UNITS).round() as i64);
        }
    }

    /// Adds the samples of another part, which together may be 2^22.
    pub fn merge(&mut self, other: &Self) {
        for i in 0..4 {
            self.sums[i] = self.sums[i].saturating_add(other.sums[i]);
            self.squares[i] = self.squares[i].saturating_add(other.squares[i]);
        }
    }
}

/// Sums over all unstable samples of one cell, as many as there may be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ScoreTotals {
    /// Sums of the scores times their scale, in units of 2^-20.
    pub sums: [i128; 4],
    /// Sums of their squares, in the same units.
    pub squares: [i128; 4],
}

impl From<ScoreSums> for ScoreTotals {
    fn from(part: ScoreSums) -> Self {
        Self { sums: part.sums.map(i128::from), squares: part.squares.map(i128::from) }
    }
}

impl ScoreTotals {
    /// Adds some samples.
    pub fn add(&mut self, part: &ScoreSums) {
        self.merge(&Self::from(*part));
    }

    /// Adds the samples of another total.
    pub fn merge(&mut self, other: &Self) {
        for i in 0..4 {
            self.sums[i] = self.sums[i].saturating_add(other.sums[i]);
            self.squares[i] = self.squares[i].saturating_add(other.squares[i]);
        }
    }

    /// The derivative of the probability by a number of the cell, and its standard error, from `decided` samples, of
    /// which the unstable ones were added. `None` for an input without scatter, or fewer than two samples.
    ///
    /// It is the derivative of `P(unstable | decided)` as long as no sample is undecided, or the share of those does
    /// not depend on the number. The standard error is that of a mean of `decided` terms; with a handful of unstable
    /// samples it is itself uncertain, and 0 with none.
    #[must_use]
    pub fn derivative(&self, number: CellNumber, cell: &Cell, decided: u64) -> Option<(f64, f64)> {
        let scale = number.scale(cell);
        if scale == 0.0 || decided < 2 {
            return None;
        }
        let samples = decided as f64;
        let mean = self.sums[number as usize] as f64 / UNITS / samples;
        let mean_square = self.squares[number as usize] as f64 / UNITS / samples;
        let variance = (mean_square - mean * mean).max(0.0) / (samples - 1.0);
        Some((mean / scale, variance.sqrt() / scale.abs()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exact;
    use crate::grid::RelativeStd;
    use crate::samples::SampleStream;
    use stickslip_core::{PadOnDisc, Parameters, StabilityBoundary, Verdict};

    /// The deviates `z` of a sample of `cell`, preload and static friction; `None` for an input without scatter.
    fn deviates(cell: &Cell, preload: f64, static_friction: f64) -> [Option<f64>; 2] {
        let deviate = |value: f64, expected: f64, std: f64| {
            let spread = expected * std;
            (spread != 0.0).then(|| (value - expected) / spread)
        };
        let std = cell.relative_std;
        [
            deviate(preload, cell.preload, std.preload),
            deviate(static_friction, cell.static_friction, std.static_friction),
        ]
    }

    fn boundary() -> StabilityBoundary {
        let mut parameters = Parameters::sui_ding_2018();
        parameters.set("operating_point.rotating_speed", 15.0).unwrap();
        PadOnDisc::new(parameters).unwrap().stability_boundary()
    }

    fn cell(preload: f64, static_friction: f64, preload_std: f64, friction_std: f64) -> Cell {
        let relative_std = RelativeStd { preload: preload_std, static_friction: friction_std };
        Cell { index: 0, rotating_speed: 15.0, relative_std, preload, static_friction }
    }

    /// The deviates of the unstable samples.
    fn unstable(seed: u64, cell: &Cell, samples: u64) -> Vec<[Option<f64>; 2]> {
        let stream = SampleStream {
            seed,
            common_random_numbers: false,
            preload_is_random: cell.relative_std.preload > 0.0,
            static_friction_is_random: cell.relative_std.static_friction > 0.0,
        };
        let boundary = boundary();
        let mut found = Vec::new();
        stream.for_each(cell, 0..samples, |samples| {
            for (&preload, &friction) in samples.preloads.iter().zip(samples.static_frictions) {
                if boundary.verdict(preload, friction) == Verdict::Unstable {
                    found.push(deviates(cell, preload, friction));
                }
            }
        });
        found
    }

    fn total(cell: &Cell, deviates: &[[Option<f64>; 2]]) -> ScoreTotals {
        let mut totals = ScoreTotals::default();
        for part in deviates.chunks(1000) {
            let mut sums = ScoreSums::default();
            part.iter().for_each(|[z1, z2]| sums.add(cell, *z1, *z2));
            totals.add(&sums);
        }
        totals
    }

    fn exact_derivatives(cell: &Cell) -> [Option<f64>; 4] {
        let exact = exact::derivatives(&boundary(), cell);
        [exact.preload, exact.static_friction, exact.std_preload, exact.std_static_friction]
    }

    #[test]
    fn scores_are_derivatives_of_the_logarithm_of_the_density() {
        let log_density = |value: f64, expected: f64, std: f64| {
            let z = (value / expected - 1.0) / std;
            -0.5 * z * z - (expected * std).ln()
        };
        let c = cell(0.1, 0.4, 0.2, 0.05);
        for z in [-2.5, -0.3, 0.0, 1.0, 3.0] {
            let scores = scores(&c, Some(z), Some(0.5 * z));
            for (input, expected, std, z) in [(0, 0.1, 0.2, z), (1, 0.4, 0.05, 0.5 * z)] {
                let value = expected * (1.0 + std * z);
                let h = 1e-5;
                let by_expected = (log_density(value, expected * (1.0 + h), std)
                    - log_density(value, expected * (1.0 - h), std))
                    / (2.0 * h * expected);
                let by_std = (log_density(value, expected, std * (1.0 + h))
                    - log_density(value, expected, std * (1.0 - h)))
                    / (2.0 * h * std);
                assert!((scores[input] - by_expected).abs() < 1e-5 * by_expected.abs().max(1.0), "{z}");
                assert!((scores[input + 2] - by_std).abs() < 1e-5 * by_std.abs().max(1.0), "{z}");
            }
        }
        let only_preload = scores(&cell(0.1, 0.4, 0.2, 0.0), Some(1.0), None);
        assert_eq!((only_preload[1], only_preload[3]), (0.0, 0.0));
        assert_eq!(scores(&cell(0.1, 0.4, 0.0, 0.0), Some(1.0), Some(1.0)), [0.0; 4]);
    }

    #[test]
    fn estimates_agree_with_integration() {
        let samples = 400_000;
        for cell in [
            cell(0.1, 0.39, 0.2, 0.2),
            cell(0.05, 0.45, 0.3, 0.1),
            cell(0.1, 0.38, 1e-3, 0.2),
            cell(0.1, 0.38, 0.2, 0.0),
            cell(0.1, 0.38, 0.0, 0.2),
        ] {
            let totals = total(&cell, &unstable(7, &cell, samples));
            for (number, exact) in CellNumber::ALL.into_iter().zip(exact_derivatives(&cell)) {
                let estimate = totals.derivative(number, &cell, samples);
                assert_eq!(estimate.is_some(), number.scale(&cell) != 0.0, "{cell:?} {number:?}");
                if let (Some((value, error)), Some(exact)) = (estimate, exact) {
                    assert!((value - exact).abs() < 4.0 * error, "{cell:?} {number:?}: {value} +- {error}, {exact}");
                    let scale = number.scale(&cell);
                    assert!(error * scale < 3.0 / (samples as f64).sqrt(), "{number:?}: {error}");
                }
            }
        }
    }

    #[test]
    fn no_bit_depends_on_the_order() {
        let c = cell(0.1, 0.39, 0.2, 0.2);
        let deviates = unstable(3, &c, 50_000);
        let mut backwards = deviates.clone();
        backwards.reverse();
        assert_eq!(total(&c, &deviates), total(&c, &backwards));
        let (first, second) = deviates.split_at(deviates.len() / 3);
        let mut merged = total(&c, second);
        merged.merge(&total(&c, first));
        assert_eq!(merged, total(&c, &deviates));
        let part = |deviates: &[[Option<f64>; 2]]| {
            let mut sums = ScoreSums::default();
            deviates.iter().for_each(|[z1, z2]| sums.add(&c, *z1, *z2));
            sums
        };
        let mut sums = part(second);
        sums.merge(&part(first));
        assert_eq!(ScoreTotals::from(sums), merged);
    }

    #[test]
    fn standard_errors_are_those_of_repeated_estimates() {
        let c = cell(0.1, 0.39, 0.2, 0.1);
        let (samples, repetitions) = (2000, 1000);
        let totals: Vec<ScoreTotals> = (0..repetitions).map(|seed| total(&c, &unstable(seed, &c, samples))).collect();
        for (number, exact) in CellNumber::ALL.into_iter().zip(exact_derivatives(&c)) {
            let squares = totals.iter().map(|totals| {
                let (value, error) = totals.derivative(number, &c, samples).unwrap();
                ((value - exact.unwrap()) / error).powi(2)
            });
            // The mean of 1000 squares of standard normal deviates has a standard deviation of 0.045.
            let mean = squares.sum::<f64>() / repetitions as f64;
            assert!((mean - 1.0).abs() < 0.18, "{number:?}: {mean}");
        }
    }

    #[test]
    fn the_largest_terms_do_not_overflow() {
        let c = cell(0.1, 0.39, 50.0, 0.1);
        let mut sums = ScoreSums::default();
        (0..1 << 20).for_each(|_| sums.add(&c, Some(1e9), Some(f64::NAN)));
        (0..2).for_each(|_| sums.merge(&sums.clone()));
        assert_eq!(sums.sums, [1 << 52, 0, 1 << 52, 0]);
        assert_eq!(sums.squares, [1 << 62, 0, 1 << 62, 0]);
        let totals = ScoreTotals::from(sums);
        let (value, error) = totals.derivative(CellNumber::Preload, &c, 1 << 22).unwrap();
        assert!((value - 1024.0 / 5.0).abs() < 1e-12 && error == 0.0);
        assert_eq!(totals.derivative(CellNumber::Preload, &c, 1), None);
    }
}
