//! Derivatives of the probability of instability from the samples that estimate the probability itself.
//!
//! The score of a sample is the derivative of the logarithm of its density: for an input `m (1 + s z)`
//!
//! ```text
//! by m (s constant):  (z + s (z^2 - 1)) / (m s) = z (1 + s z) / (m s) - 1 / m,
//! by s:               (z^2 - 1) / s
//! ```
//!
//! (R. Y. Rubinstein, A. Shapiro, Discrete Event Systems, 1993). With `p = U / (U + S)`, where `U` and `S` are the
//! probabilities that a sample is unstable and stable, and `E_U`, `E_S` the mean scores of those that are, the
//! derivatives of `U` and `S` are `U E_U` and `S E_S`, and the quotient rule gives
//!
//! ```text
//! dp = p (1 - p) (E_U - E_S)
//! ```
//!
//! whether or not some samples are undecided or failed. No sample is judged twice, and nothing is asked of how the
//! verdict depends on the input. The mean scores of `u` unstable and `s` stable samples scatter independently of each
//! other and of `u`, so that the standard error is
//!
//! ```text
//! error^2 = (p (1 - p))^2 (V_U / u + V_S / s) + ((1 - 2p) (E_U - E_S))^2 p (1 - p) / (u + s)
//! ```
//!
//! with the variances `V` of the scores. Nor do they depend on when a cell stopped that is looked at until it is known
//! well enough: with the unbiased `p` of [`Looks`](crate::estimate::sequential::Looks) the derivative is as good as `p (1 - p)`.
//!
//! Sums are kept in integers, so that no result depends on the order of the samples. What is summed is the score
//! times `m s` or `s`, which is of the size of 1 however small the scatter.

use stickslip_core::verdict::{Verdict, VerdictCounts};

use crate::grid::Cell;

/// Sums are kept in units of 2^-20: rounding adds less than a millionth to each term.
const UNITS: f64 = (1_u64 << 20) as f64;

/// So many samples have to be unstable, and so many stable: fewer do not tell how far their mean score is off.
pub const LEAST_SAMPLES: u64 = 30;

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

/// Sums over some samples of one verdict.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Moments<T> {
    /// Sums of the scores times their scale, in units of 2^-20.
    sums: [T; 4],
    /// Sums of their squares, in the same units.
    squares: [T; 4],
}

/// Sums over some samples of one cell, up to 2^22 of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ScoreSums {
    unstable: Moments<i64>,
    stable: Moments<i64>,
}

impl ScoreSums {
    /// How many sums there are.
    pub const COUNT: usize = 16;

    /// Adds a sample with these deviates, `None` for an input without scatter.
    #[inline]
    pub fn add(&mut self, cell: &Cell, z_preload: Option<f64>, z_static_friction: Option<f64>, verdict: Verdict) {
        let moments = match verdict {
            Verdict::Unstable => &mut self.unstable,
            Verdict::Stable => &mut self.stable,
            Verdict::Undecided | Verdict::Failed => return,
        };
        for (i, score) in scaled_scores(cell, z_preload, z_static_friction).into_iter().enumerate() {
            let score = score.clamp(-LARGEST, LARGEST);
            // A conversion to an integer makes 0 of NaN.
            moments.sums[i] = moments.sums[i].saturating_add((score * UNITS).round() as i64);
            moments.squares[i] = moments.squares[i].saturating_add((score * score * UNITS).round() as i64);
        }
    }

    /// All sums, as [`ScoreTotals::from_sums`] takes them.
    pub fn sums(&self) -> impl Iterator<Item = i64> {
        let Self { unstable, stable } = *self;
        [unstable.sums, unstable.squares, stable.sums, stable.squares].into_iter().flatten()
    }
}

/// Sums over all samples of one cell, as many as there may be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ScoreTotals {
    unstable: Moments<i128>,
    stable: Moments<i128>,
}

impl ScoreTotals {
    /// From sums of [`ScoreSums::sums`], added one by one.
    #[must_use]
    pub fn from_sums(sums: &[i128; ScoreSums::COUNT]) -> Self {
        let part = |from: usize| std::array::from_fn(|i| sums[from + i]);
        Self {
            unstable: Moments { sums: part(0), squares: part(4) },
            stable: Moments { sums: part(8), squares: part(12) },
        }
    }

    /// The derivative of the probability by a number of the cell, and its standard error, from the counts of the samples
    /// that were added and the estimate `probability` from them.
    ///
    /// It is that of `P(unstable | decided)`. `None` for an input without scatter, and where fewer than
    /// [`LEAST_SAMPLES`] are unstable or stable: a derivative of 0 +- 0 would say that the probability is known not to
    /// change.
    #[must_use]
    pub fn derivative(
        &self,
        number: CellNumber,
        cell: &Cell,
        counts: &VerdictCounts,
        probability: f64,
    ) -> Option<(f64, f64)> {
        let scale = number.scale(cell);
        if scale == 0.0 || counts.unstable.min(counts.stable) < LEAST_SAMPLES {
            return None;
        }
        let (unstable, variance_unstable) = self.unstable.mean(number, counts.unstable);
        let (stable, variance_stable) = self.stable.mean(number, counts.stable);
        let spread = probability * (1.0 - probability);
        let slope = unstable - stable;
        let by_scores = spread * spread * (variance_unstable + variance_stable);
        let by_share = (1.0 - 2.0 * probability) * slope;
        let variance = by_scores + by_share * by_share * spread / counts.decided() as f64;
        Some((spread * slope / scale, variance.sqrt() / scale.abs()))
    }
}

impl Moments<i128> {
    /// The mean of `count` scores, and its variance.
    fn mean(&self, number: CellNumber, count: u64) -> (f64, f64) {
        let samples = count as f64;
        let mean = self.sums[number as usize] as f64 / UNITS / samples;
        let mean_square = self.squares[number as usize] as f64 / UNITS / samples;
        (mean, (mean_square - mean * mean).max(0.0) / (samples - 1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::deviates::{DeviateStream, Points};
    use crate::grid::RelativeStd;
    use crate::integrate::closed_form;
    use stickslip_core::parameters::Parameters;
    use stickslip_core::rigid_disc::pad_on_disc::PadOnDisc;
    use stickslip_core::rigid_disc::stability::StabilityBoundary;
    use stickslip_core::verdict::Verdict;

    fn boundary() -> StabilityBoundary {
        let mut parameters = Parameters::sui_ding_2018();
        parameters.set("operating_point.rotating_speed", 15.0).unwrap();
        PadOnDisc::new(parameters).unwrap().stability_boundary()
    }

    fn cell(preload: f64, static_friction: f64, preload_std: f64, friction_std: f64) -> Cell {
        let relative_std = RelativeStd { preload: preload_std, static_friction: friction_std };
        Cell { index: 0, rotating_speed: 15.0, relative_std, preload, static_friction }
    }

    /// The deviates of samples, each with its verdict by the closed form.
    fn judged(seed: u64, cell: &Cell, samples: u64) -> Vec<([Option<f64>; 2], Verdict)> {
        let RelativeStd { preload, static_friction } = cell.relative_std;
        let stds: Vec<f64> = [preload, static_friction].into_iter().filter(|&std| std > 0.0).collect();
        let stream =
            DeviateStream { seed, common_random_numbers: false, dimensions: stds.len(), points: Points::Random };
        let boundary = boundary();
        let mut found = Vec::new();
        stream.for_each_chunk(cell.index, 0, 0..samples, |columns| {
            let mut next = columns.iter();
            let mut column = |std: f64| if std > 0.0 { next.next() } else { None };
            let deviates = [column(preload), column(static_friction)];
            for sample in 0..columns.first().map_or(0, Vec::len) {
                let z = deviates.map(|column| column.map(|column| column[sample]));
                let input = |expected: f64, std: f64, z: Option<f64>| expected * (1.0 + std * z.unwrap_or(0.0));
                let verdict = boundary
                    .verdict(input(cell.preload, preload, z[0]), input(cell.static_friction, static_friction, z[1]));
                found.push((z, verdict));
            }
        });
        found
    }

    /// Sums and counts of some samples.
    fn total(cell: &Cell, judged: &[([Option<f64>; 2], Verdict)]) -> (ScoreTotals, VerdictCounts) {
        let mut totals = [0_i128; ScoreSums::COUNT];
        let mut counts = VerdictCounts::default();
        for part in judged.chunks(1000) {
            let mut sums = ScoreSums::default();
            for ([z1, z2], verdict) in part {
                sums.add(cell, *z1, *z2, *verdict);
                counts += (*verdict).into();
            }
            totals.iter_mut().zip(sums.sums()).for_each(|(total, sum)| *total += i128::from(sum));
        }
        (ScoreTotals::from_sums(&totals), counts)
    }

    fn estimate(cell: &Cell, judged: &[([Option<f64>; 2], Verdict)], number: CellNumber) -> Option<(f64, f64)> {
        let (totals, counts) = total(cell, judged);
        totals.derivative(number, cell, &counts, counts.unstable as f64 / counts.decided() as f64)
    }

    fn exact_derivatives(cell: &Cell) -> [Option<f64>; 4] {
        let exact = closed_form::derivatives(&boundary(), cell);
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
            let judged = judged(7, &cell, samples);
            for (number, exact) in CellNumber::ALL.into_iter().zip(exact_derivatives(&cell)) {
                let estimate = estimate(&cell, &judged, number);
                assert_eq!(estimate.is_some(), number.scale(&cell) != 0.0, "{cell:?} {number:?}");
                if let (Some((value, error)), Some(exact)) = (estimate, exact) {
                    assert!((value - exact).abs() < 4.0 * error, "{cell:?} {number:?}: {value} +- {error}, {exact}");
                    let scale = number.scale(&cell);
                    assert!(error * scale < 2.0 / (samples as f64).sqrt(), "{number:?}: {error}");
                }
            }
        }
    }

    #[test]
    fn no_bit_depends_on_the_order() {
        let c = cell(0.1, 0.39, 0.2, 0.2);
        let judged = judged(3, &c, 50_000);
        let mut backwards = judged.clone();
        backwards.reverse();
        assert_eq!(total(&c, &judged), total(&c, &backwards));
    }

    /// The mean square of the deviations over their standard errors, and the share within 1.96 of them, over replicates of
    /// `samples` samples; of those that have an estimate.
    fn deviations(cell: &Cell, number: CellNumber, samples: u64, replicates: u64, exact: f64) -> (f64, f64, u64) {
        let (mut squares, mut covered, mut count) = (0.0, 0.0, 0);
        for seed in 0..replicates {
            if let Some((value, error)) = estimate(cell, &judged(seed, cell, samples), number) {
                let deviation = (value - exact) / error;
                squares += deviation * deviation;
                covered += f64::from(u32::from(deviation.abs() <= 1.96));
                count += 1;
            }
        }
        (squares / count as f64, covered / count as f64, count)
    }

    #[test]
    fn standard_errors_are_those_of_repeated_estimates() {
        let c = cell(0.1, 0.39, 0.2, 0.1);
        for (number, exact) in CellNumber::ALL.into_iter().zip(exact_derivatives(&c)) {
            let (mean, covered, count) = deviations(&c, number, 2000, 1000, exact.unwrap());
            // The mean of 1000 squares of standard normal deviates has a standard deviation of 0.045.
            assert!(count == 1000 && (mean - 1.0).abs() < 0.18, "{number:?}: {mean}");
            assert!((covered - 0.95).abs() < 0.025, "{number:?}: {covered}");
        }
    }

    #[test]
    fn rare_events_have_no_derivative_rather_than_a_wrong_one() {
        // Some 8.5e-4 of the samples are unstable.
        let c = cell(0.1, 0.2735, 0.2, 0.1);
        let p = closed_form::probability(&boundary(), &c).value;
        assert!((p - 8.5e-4).abs() < 1e-4, "{p}");
        let exact = exact_derivatives(&c)[0].unwrap();
        let (.., count) = deviations(&c, CellNumber::Preload, 1000, 50, exact);
        assert_eq!(count, 0);
        let stable =
            judged(1, &c, 100).into_iter().filter(|(_, verdict)| *verdict == Verdict::Stable).collect::<Vec<_>>();
        assert_eq!(estimate(&c, &stable, CellNumber::Preload), None);
        // With enough of them the error is right.
        let (mean, covered, count) = deviations(&c, CellNumber::Preload, 60_000, 400, exact);
        assert!(count > 390 && (mean - 1.0).abs() < 0.35 && covered > 0.92, "{mean} {covered} {count}");
    }

    #[test]
    fn undecided_samples_are_left_out_by_the_quotient_rule() {
        // Undecided is a sixth of the samples, those with much friction: what remains is stable more often, the more the
        // expected friction grows.
        let c = cell(0.1, 0.39, 0.2, 0.2);
        let limit = 0.39 * (1.0 + 0.2 * 1.0);
        // P(unstable | friction below the limit), by the trapezoidal rule over the deviate of the friction.
        let probability = |c: &Cell| {
            let (mut unstable, mut decided, step) = (0.0, 0.0, 1e-4);
            let end = (limit / c.static_friction - 1.0) / c.relative_std.static_friction;
            let mut z = end;
            let mut weight = 0.5;
            while z > -9.0 {
                let friction = c.static_friction * (1.0 + c.relative_std.static_friction * z);
                let critical = (boundary().critical_preload(friction) / c.preload - 1.0) / c.relative_std.preload;
                decided += weight * crate::special_functions::normal::density(z);
                unstable += weight
                    * crate::special_functions::normal::density(z)
                    * crate::special_functions::normal::upper_tail(critical);
                z -= step;
                weight = 1.0;
            }
            unstable / decided
        };
        let h = 1e-4;
        let shifted = |by: f64| Cell { static_friction: c.static_friction + by, ..c };
        let exact = (probability(&shifted(h)) - probability(&shifted(-h))) / (2.0 * h);
        let (mut squares, replicates) = (0.0, 300);
        for seed in 0..replicates {
            let mut judged = judged(seed, &c, 2000);
            for ([_, z], verdict) in &mut judged {
                if z.unwrap() > 1.0 {
                    *verdict = Verdict::Undecided;
                }
            }
            let (value, error) = estimate(&c, &judged, CellNumber::StaticFriction).unwrap();
            squares += ((value - exact) / error).powi(2);
        }
        let mean = squares / f64::from(u32::try_from(replicates).unwrap());
        assert!((mean - 1.0).abs() < 0.3, "{mean}");
    }

    #[test]
    fn the_largest_terms_do_not_overflow() {
        let c = cell(0.1, 0.39, 50.0, 0.1);
        let mut sums = ScoreSums::default();
        (0..1 << 22).for_each(|_| sums.add(&c, Some(1e9), Some(f64::NAN), Verdict::Unstable));
        let found: Vec<i64> = sums.sums().collect();
        assert_eq!(found[..8], [1 << 52, 0, 1 << 52, 0, 1 << 62, 0, 1 << 62, 0]);
    }
}
