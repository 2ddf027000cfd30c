//! Whether a sample has an unstable pair: by the characteristic polynomial of two coordinates, by a series where that is
//! sure, by its vectors or by refining single eigenvalues where it is not, and by all eigenvalues where nothing else will do.

use super::far::Followed;
use super::pair::Pair;
use super::polynomial::Monomials;
use super::quadratic::{DenseQuadratic, Quadratic};
use super::region::{Region, damping_ratio, excess, magnitude};
use super::series::{FOLLOWED, ModeSeries};
use super::two_coordinates;
use crate::numerics::eigenvalues::{Eigenvalue, fast_eigenvalues};

/// Relative rounding of eigenvalues of the series, in parts of the unit of frequency.
const ROUNDING: f64 = 1e-11;

/// An imaginary part that counts as rounding, in parts of the eigenvalue.
const NEARLY_REAL: f64 = 1e-12;

/// Coordinates from which on eigenvalues by vector instructions save time.
const LARGE: usize = 24;

/// How far from the edge of a region eigenvalues count with any last bits, in parts of themselves and of the norm of the
/// matrix: some thousand times the change of a pair that is about to couple with another, whose eigenvalues move by the root of
/// the rounding.
const CLEAR: f64 = 1e-4;
const CLEAR_OF_NORM: f64 = 1e-9;

/// Decides samples of a problem about an origin.
pub struct Decider<'a> {
    problem: &'a DenseQuadratic,
    /// In the unit of the problem; a pair in one of them makes a sample unstable.
    regions: &'a [Region],
    series: Option<&'a ModeSeries>,
}

/// How a sample was decided.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// By the characteristic polynomial of two coordinates.
    ClosedForm,
    /// By the series alone.
    Series,
    /// By the series and its vectors.
    Vectors,
    /// By eigenvalues that are refined from there.
    Refined,
    /// By all eigenvalues.
    All,
}

impl<'a> Decider<'a> {
    /// Decides by regions in the unit of the problem, with a series if there is one.
    pub(super) fn new(problem: &'a DenseQuadratic, regions: &'a [Region], series: Option<&'a ModeSeries>) -> Self {
        Self { problem, regions, series }
    }

    /// Whether a sample with these coefficients is unstable, and how that was found; `None` if eigenvalues do not converge.
    #[must_use]
    pub fn is_unstable(&self, coefficients: &[f64]) -> Option<(bool, Way)> {
        if let Some(values) = two_coordinates::eigenvalues(self.problem, coefficients)
            && let Some(told) = told(values.map(|(value, radius)| self.sure(value, radius)))
        {
            return Some((told, Way::ClosedForm));
        }
        let followed = self.series.and_then(|series| Some((series, series.follow(coefficients)?)));
        if let Some((series, (monomials, followed))) = followed {
            let (mut sure, mut unsure) = (Vec::new(), Vec::new());
            for mode in &followed {
                match self.sure(mode.eigenvalue, mode.radius) {
                    Some(true) => return Some((true, Way::Series)),
                    Some(false) => sure.push(*mode),
                    None => unsure.push(*mode),
                }
            }
            if unsure.is_empty() {
                return Some((false, Way::Series));
            }
            // The least damped first: often it is unstable, and no other is asked for.
            unsure.sort_by(|a, b| damping_ratio(a.eigenvalue).total_cmp(&damping_ratio(b.eigenvalue)));
            let problem = self.problem.at(coefficients);
            if let Some(told) = self.by_vectors(&problem, series, &monomials, &unsure, &sure) {
                return Some(told);
            }
        }
        let problem = self.problem.at(coefficients);
        if let Some(told) = self.clear(&problem) {
            return Some((told, Way::All));
        }
        let all = problem.eigenvalues().ok()?;
        Some((all.iter().any(|value| self.contains(*value)), Way::All))
    }

    /// Whether one of the followed modes that the series does not tell is unstable, by its vectors or by refining it; `None`
    /// where the modes cannot be kept apart.
    fn by_vectors(
        &self,
        problem: &Quadratic,
        series: &ModeSeries,
        monomials: &Monomials,
        unsure: &[Followed],
        sure: &[Followed],
    ) -> Option<(bool, Way)> {
        let (mut pairs, mut told) = (Vec::with_capacity(unsure.len()), Vec::with_capacity(unsure.len()));
        for mode in unsure {
            let pair = series.pair(problem, monomials, mode)?;
            let is_unstable = self.sure(pair.eigenvalue, pair.error);
            if is_unstable == Some(true) {
                return Some((true, Way::Vectors));
            }
            pairs.push(pair);
            told.push(is_unstable);
        }
        let is_known = |i: usize| told[i].is_some() && !is_another(&pairs, i);
        let way = if (0..pairs.len()).all(is_known) { Way::Vectors } else { Way::Refined };
        let settled = settled(problem, &pairs, unsure, sure, is_known)?;
        // What the vectors have told is stable; their eigenvalues are not exact.
        let mut refined = settled.into_iter().enumerate().filter(|(i, _)| !is_known(*i));
        Some((refined.any(|(_, value)| self.contains(value)), way))
    }

    /// Whether a sample is unstable by eigenvalues whose last bits depend on the processor; `None` for small problems, for
    /// which they save no time, and where one of them is so near to the edge of a region that more than last bits matter.
    fn clear(&self, problem: &Quadratic) -> Option<bool> {
        if problem.stiffness.nrows() < LARGE {
            return None;
        }
        let (all, norm) = fast_eigenvalues(&problem.companion())?;
        told(all.into_iter().map(|value| self.sure(value, CLEAR * magnitude(value) + CLEAR_OF_NORM * norm)))
    }

    fn contains(&self, eigenvalue: Eigenvalue) -> bool {
        self.regions.iter().any(|region| region.contains(eigenvalue))
    }

    /// Whether an eigenvalue that is known within a radius surely is in one of the regions, or surely in none.
    fn sure(&self, eigenvalue: Eigenvalue, radius: f64) -> Option<bool> {
        told(self.regions.iter().map(|region| region.sure(eigenvalue, radius + ROUNDING)))
    }

    /// The eigenvalue in the bands whose damping ratio is least above its threshold, in rad/s; `None` if there is none in a
    /// band, or none that converges.
    #[must_use]
    pub fn least_damped(&self, coefficients: &[f64]) -> Option<Eigenvalue> {
        let problem = self.problem.at(coefficients);
        let least = |values: Vec<Eigenvalue>| {
            // A real eigenvalue that was refined has an imaginary part of rounding.
            let real = |value: &Eigenvalue| value.im.abs() <= NEARLY_REAL * magnitude(*value);
            let values = values.into_iter().map(|value| if real(&value) { value.re.into() } else { value });
            let in_band = values.filter(|value| value.im >= 0.0 && excess(self.regions, *value).is_finite());
            in_band.min_by(|a, b| excess(self.regions, *a).total_cmp(&excess(self.regions, *b)))
        };
        let by_series = || {
            let series = self.series?;
            let (monomials, followed) = series.follow(coefficients)?;
            if followed.iter().any(|mode| mode.radius.is_infinite()) {
                return None;
            }
            let highest = self.regions.iter().map(|region| region.highest).fold(0.0, f64::max);
            // The least and largest that the excess of a followed eigenvalue may be: where a band may have its frequency, and
            // where one surely has.
            let bounds = |mode: &Followed| {
                let Followed { eigenvalue, radius, .. } = *mode;
                let by = 1.1 * radius / (magnitude(eigenvalue) - radius).max(f64::MIN_POSITIVE);
                let ends = [eigenvalue.im - radius, eigenvalue.im + radius];
                let excess = |may_have: bool| {
                    let has = |region: &&Region| match may_have {
                        true => region.lowest <= ends[1] && ends[0] <= region.highest,
                        false => region.lowest <= ends[0] && ends[1] <= region.highest,
                    };
                    let ratio = damping_ratio(eigenvalue);
                    let bands = self.regions.iter().filter(has);
                    bands.map(|region| ratio - region.damping_ratio).fold(f64::INFINITY, f64::min)
                };
                [excess(true) - by, excess(false) + by]
            };
            let least = followed.iter().map(|mode| bounds(mode)[1]).fold(f64::INFINITY, f64::min);
            // Modes that are not followed may have less damping than those with much of it.
            if !(least < 0.3 * FOLLOWED && highest.is_finite()) {
                return None;
            }
            let candidates: Vec<Followed> = followed.into_iter().filter(|mode| bounds(mode)[0] <= least).collect();
            let pairs = vector_pairs(series, &problem, &monomials, &candidates)?;
            settled(&problem, &pairs, &candidates, &[], |_| false)
        };
        let values = match by_series().and_then(least) {
            Some(value) => Some(value),
            None => least(problem.eigenvalues().ok()?),
        };
        values.map(|value| value * self.problem.unit())
    }

    /// The smallest damping ratio in the bands less its threshold, by the series as far as that reaches; 1 where there is
    /// no pair in a band. `None` if eigenvalues do not converge.
    #[must_use]
    pub fn limit_state(&self, coefficients: &[f64]) -> Option<f64> {
        let by_series = self.series.and_then(|series| series.follow(coefficients)).map(|(_, followed)| followed);
        let certain = by_series.filter(|followed| followed.iter().all(|mode| mode.radius < 1e-3));
        let values: Vec<Eigenvalue> = match certain {
            Some(followed) => followed.iter().map(|mode| mode.eigenvalue).collect(),
            None => self.problem.at(coefficients).eigenvalues().ok()?,
        };
        Some(values.into_iter().map(|value| excess(self.regions, value)).fold(1.0, f64::min))
    }
}

/// Whether one of these is surely so, or all surely are not; `None` if that is not known.
fn told(sure: impl IntoIterator<Item = Option<bool>>) -> Option<bool> {
    let mut all_are_known = true;
    for sure in sure {
        match sure {
            Some(true) => return Some(true),
            Some(false) => {}
            None => all_are_known = false,
        }
    }
    all_are_known.then_some(false)
}

/// The pairs of followed eigenvalues by their vectors.
fn vector_pairs(
    series: &ModeSeries,
    problem: &Quadratic,
    monomials: &Monomials,
    followed: &[Followed],
) -> Option<Vec<Pair>> {
    followed.iter().map(|mode| series.pair(problem, monomials, mode)).collect()
}

/// The eigenvalues of followed pairs, refined unless they are known well enough; `None` if one does not converge, is not
/// near to where the series has it, or may be that of another pair or of one of the other modes.
fn settled(
    problem: &Quadratic,
    pairs: &[Pair],
    followed: &[Followed],
    others: &[Followed],
    is_known: impl Fn(usize) -> bool,
) -> Option<Vec<Eigenvalue>> {
    let settle = |(i, pair): (usize, &Pair)| {
        let pair = if is_known(i) { pair.clone() } else { problem.refine(pair.clone())? };
        let distance = magnitude(followed[i].eigenvalue - pair.eigenvalue);
        let may_be =
            |other: &Followed| magnitude(other.eigenvalue - pair.eigenvalue) <= other.radius + pair.error + ROUNDING;
        (distance <= followed[i].radius + ROUNDING && !others.iter().any(may_be)).then_some(pair)
    };
    let settled: Vec<Pair> = pairs.iter().enumerate().map(settle).collect::<Option<_>>()?;
    let are_different = (0..settled.len()).all(|i| !is_another(&settled, i));
    are_different.then(|| settled.into_iter().map(|pair| pair.eigenvalue).collect())
}

/// Whether a pair may be another of these.
fn is_another(pairs: &[Pair], i: usize) -> bool {
    let mut others = pairs.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, other)| other);
    let distance = |other: &Pair| magnitude(pairs[i].eigenvalue - other.eigenvalue);
    others.any(|other| distance(other) <= pairs[i].error + other.error + ROUNDING)
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, dmatrix};

    use super::*;
    use crate::models::matrices::trial::{Numbers, close_modes, problem};

    /// Verdicts of as many problems on as many samples against all eigenvalues; and how they came about.
    fn compare(problems: std::ops::Range<u64>, samples: usize, scatter: f64) -> [usize; 5] {
        let mut ways = [0; 5];
        for seed in problems {
            let (problem, origin, region) = problem(seed);
            let mut numbers = Numbers(seed + 1_000_000);
            let series = ModeSeries::new(&problem, &origin, &[1, 2, 3, 4], &[region], 1 << 24);
            let decider = Decider::new(&problem, std::slice::from_ref(&region), series.as_ref());
            for _ in 0..samples {
                let mut coefficients = origin.clone();
                (1..5).for_each(|k| coefficients[k] *= 1.0 + scatter * numbers.normal());
                let all = problem.at(&coefficients).eigenvalues().unwrap();
                let edge = |value: &Eigenvalue| {
                    let ratio = (damping_ratio(*value) - region.damping_ratio).abs();
                    let ends = [region.lowest, region.highest].map(|end| (value.im.abs() - end).abs());
                    ratio < 1e-8 || value.im != 0.0 && ends.iter().any(|end| *end < 1e-8)
                };
                let expected = all.iter().any(|value| region.contains(*value));
                let (unstable, way) = decider.is_unstable(&coefficients).unwrap();
                ways[way as usize] += 1;
                assert!(
                    unstable == expected || all.iter().any(edge),
                    "problem {seed}, {coefficients:?}, {way:?}: {unstable}, all eigenvalues {all:?}"
                );
            }
        }
        ways
    }

    #[test]
    fn verdicts_are_those_of_all_eigenvalues() {
        for scatter in [0.01, 0.1, 0.4] {
            let ways = compare(0..60, 60, scatter);
            let all_ways = [Way::ClosedForm, Way::Series, Way::Vectors, Way::Refined, Way::All];
            assert!(scatter != 0.1 || all_ways.iter().all(|way| ways[*way as usize] > 0), "{scatter} {ways:?}");
            assert!(scatter > 0.2 || ways[Way::Series as usize] > ways[Way::All as usize], "{scatter} {ways:?}");
        }
    }

    #[test]
    #[ignore = "takes minutes"]
    fn verdicts_on_many_problems_are_those_of_all_eigenvalues() {
        for scatter in [0.02, 0.1, 0.3] {
            assert_eq!(compare(1000..6000, 200, scatter).iter().sum::<usize>(), 1_000_000);
        }
    }

    #[test]
    fn the_least_damped_pair_is_that_of_all_eigenvalues() {
        for seed in 0..40 {
            let (problem, origin, region) = problem(seed);
            let series = ModeSeries::new(&problem, &origin, &[1, 2, 3, 4], &[region], 1 << 24);
            let decider = Decider::new(&problem, std::slice::from_ref(&region), series.as_ref());
            let mut numbers = Numbers(seed + 77);
            for _ in 0..20 {
                let mut coefficients = origin.clone();
                (1..5).for_each(|k| coefficients[k] *= 1.0 + 0.1 * numbers.normal());
                let all = problem.at(&coefficients).eigenvalues().unwrap();
                let in_band = all.into_iter().filter(|value| value.im >= 0.0 && region.has_frequency_of(*value));
                let least = in_band.map(damping_ratio).fold(f64::INFINITY, f64::min);
                let found = decider.least_damped(&coefficients).map_or(f64::INFINITY, damping_ratio);
                assert!(least == found || (least - found).abs() < 1e-9, "problem {seed}: {least} {found}");
            }
        }
    }

    /// The error of a pair that comes from the vectors of the series holds the exact eigenvalue, and is much smaller than
    /// that of the series.
    #[test]
    fn errors_of_vectors_hold_the_exact_eigenvalue() {
        let (mut compared, mut smaller) = (0, 0);
        for seed in 0..60 {
            let (problem, origin, region) = problem(seed);
            let Some(series) = ModeSeries::new(&problem, &origin, &[1, 2, 3, 4], &[region], 1 << 24) else { continue };
            let mut numbers = Numbers(seed + 7);
            for _ in 0..20 {
                let mut coefficients = origin.clone();
                (1..5).for_each(|k| coefficients[k] *= 1.0 + 0.05 * numbers.normal());
                let quadratic = problem.at(&coefficients);
                let Some((monomials, followed)) = series.follow(&coefficients) else { continue };
                let exact = quadratic.eigenvalues().unwrap();
                let mut taken = Vec::new();
                let pairs = vector_pairs(&series, &quadratic, &monomials, &followed).unwrap();
                for (mode, pair) in followed.iter().zip(pairs) {
                    let mut distances: Vec<(f64, usize)> =
                        exact.iter().map(|value| magnitude(value - pair.eigenvalue)).zip(0..).collect();
                    distances.sort_by(|a, b| a.0.total_cmp(&b.0));
                    let nearest = distances[0].0;
                    // No two pairs are one eigenvalue where errors tell them from the next.
                    if distances.get(1).is_none_or(|second| 2.0 * pair.error + 1e-9 < second.0) {
                        assert!(!taken.contains(&distances[0].1), "problem {seed}: two pairs at {pair:?}");
                        taken.push(distances[0].1);
                    }
                    assert!(nearest <= pair.error + 1e-10, "problem {seed}: {mode:?} {pair:?} off by {nearest}");
                    compared += 1;
                    smaller += usize::from(pair.error < 0.3 * mode.radius);
                }
            }
        }
        assert!(compared > 1000 && smaller > compared / 10, "{compared} {smaller}");
    }

    /// Two damped masses of Hoffmann and Gaul (2003): with c1 = 0.02, c2 = 0.05, k11 = 2, k22 = 2.2 and k12 = 1 they flutter
    /// above `D = (a1 (a3 a2 - a1) / a3^2 - (k11 k22 - k12^2)) / k12`.
    #[test]
    fn verdicts_turn_at_the_criterion_of_hurwitz() {
        let (c1, c2, k11, k22, k12) = (0.02, 0.05, 2.0, 2.2, 1.0);
        let (a3, a2, a1) = (c1 + c2, k11 + k22 + c1 * c2, c1 * k22 + c2 * k11);
        let critical = (a1 * (a3 * a2 - a1) / (a3 * a3) - (k11 * k22 - k12 * k12)) / k12;
        let terms = [dmatrix![k11, k12; k12, k22], dmatrix![0.0, -1.0; 0.0, 0.0]];
        let damping = [dmatrix![c1, 0.0; 0.0, c2]];
        let problem = DenseQuadratic::new(&DMatrix::identity(2, 2), &damping, &terms, &[1.0; 3]).unwrap();
        let region = Region { lowest: 0.0, highest: f64::INFINITY, damping_ratio: 0.0 };
        let decider = Decider::new(&problem, std::slice::from_ref(&region), None);
        for distance in [1e-7, 1e-4, 0.1, 0.5] {
            for (friction, expected) in [(critical - distance, false), (critical + distance, true)] {
                let found = decider.is_unstable(&[1.0, 1.0, friction]);
                assert_eq!(found, Some((expected, Way::ClosedForm)), "{friction}");
            }
        }
    }

    /// A chain of masses with friction between neighbours: eigenvalues by vector instructions tell what all eigenvalues tell, and
    /// nothing where the threshold is at one of them.
    #[test]
    #[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
    fn large_problems_are_decided_by_fast_eigenvalues_where_these_are_clear() {
        let size = LARGE + 6;
        let (mut clear, mut unstable) = (0, 0);
        for seed in 0..60 {
            let mut numbers = Numbers(seed);
            let frequency: Vec<f64> = (0..size).map(|_| 1.0 + 0.4 * numbers.next()).collect();
            let diagonal = DMatrix::from_diagonal(
                &frequency.iter().map(|frequency| frequency * frequency).collect::<Vec<_>>().into(),
            );
            let friction = DMatrix::from_fn(size, size, |i, j| if i == j { 0.0 } else { 0.01 * numbers.normal() });
            let damping = DMatrix::identity(size, size) * 0.01;
            let problem =
                DenseQuadratic::new(&DMatrix::identity(size, size), &[damping], &[diagonal, friction], &[1.0; 3])
                    .unwrap();
            let region = Region { lowest: 0.1, highest: 10.0, damping_ratio: 0.0 }.in_unit(problem.unit());
            for friction in [0.1, 0.3, 0.5, 1.0] {
                let quadratic = problem.at(&[1.0, 1.0, friction]);
                let all = quadratic.eigenvalues().unwrap();
                let expected = all.iter().any(|value| region.contains(*value));
                let decider = Decider::new(&problem, std::slice::from_ref(&region), None);
                let told = decider.clear(&quadratic);
                assert!(told.is_none_or(|told| told == expected), "{seed} {friction}");
                assert_eq!(decider.is_unstable(&[1.0, 1.0, friction]), Some((expected, Way::All)));
                (clear, unstable) = (clear + usize::from(told.is_some()), unstable + usize::from(expected));
                let oscillating = all.iter().filter(|value| value.im > 0.0);
                let least = oscillating.map(|value| damping_ratio(*value)).fold(f64::INFINITY, f64::min);
                let at_the_threshold = Region { damping_ratio: least, ..region };
                let decider = Decider::new(&problem, std::slice::from_ref(&at_the_threshold), None);
                assert_eq!(decider.clear(&quadratic), None, "{seed} {friction}");
            }
        }
        assert!(clear > 200 && (40..200).contains(&unstable), "{clear} {unstable}");
    }

    /// Two close modes that friction alone couples, and a third far off: nothing but their coupling changes, so that vectors of
    /// second order vanish but for those of the conjugate modes.
    #[test]
    fn modes_that_move_alike_are_decided_rightly() {
        let mut ways = [0; 5];
        for seed in 0..400_u64 {
            let mut numbers = Numbers(seed);
            let gap = 0.005 + 0.02 * (1.0 + numbers.next());
            let problem = close_modes(gap, 2e-3 * (1.5 + numbers.next()));
            let expected = 0.25 + 0.2 * numbers.next();
            let origin = [1.0, 1.0, expected];
            // The threshold lies near the damping ratio of the less damped of the two.
            let threshold = 2e-4 * (1.0 + 0.5 * numbers.next());
            let region = Region { lowest: 0.3, highest: 3.0, damping_ratio: threshold }.in_unit(problem.unit());
            let series = ModeSeries::new(&problem, &origin, &[2], &[region], 1 << 24);
            let series = series.unwrap();
            let decider = Decider::new(&problem, std::slice::from_ref(&region), Some(&series));
            for step in -40..=40 {
                let coefficients = [1.0, 1.0, expected * (1.0 + 0.02 * f64::from(step))];
                let all = problem.at(&coefficients).eigenvalues().unwrap();
                let off =
                    |from: Eigenvalue| all.iter().map(|value| magnitude(value - from)).fold(f64::INFINITY, f64::min);
                if let Some((monomials, followed)) = series.follow(&coefficients) {
                    let pairs = vector_pairs(&series, &problem.at(&coefficients), &monomials, &followed).unwrap();
                    for (mode, pair) in followed.iter().zip(pairs) {
                        let [by_series, by_vectors] = [off(mode.eigenvalue), off(pair.eigenvalue)];
                        assert!(
                            by_series <= mode.radius + 1e-10,
                            "{seed} {coefficients:?} {mode:?} off by {by_series}"
                        );
                        assert!(
                            by_vectors <= pair.error + 1e-10,
                            "{seed} {coefficients:?} {pair:?} off by {by_vectors}"
                        );
                    }
                }
                let is_edge = |value: &Eigenvalue| (damping_ratio(*value) - threshold).abs() < 1e-8;
                let expected = all.iter().any(|value| region.contains(*value));
                let (unstable, way) = decider.is_unstable(&coefficients).unwrap();
                ways[way as usize] += 1;
                assert!(unstable == expected || all.iter().any(is_edge), "{seed} {coefficients:?} {way:?} {unstable}");
            }
        }
        assert!(ways[Way::Series as usize] > 1000 && ways[Way::Vectors as usize] > 20, "{ways:?}");
    }

    /// A mode below the band is told by its vectors, whose eigenvalue is a little beyond the threshold where the exact one is
    /// not; the same mode in the upper half plane has to be refined.
    #[test]
    fn what_vectors_tell_is_not_asked_of_their_eigenvalues() {
        let (problem, origin, region) = problem(1165);
        let coefficients = [
            1.0,
            0.966_932_845_701_144_1,
            0.636_324_029_247_461_7,
            0.720_962_775_729_800_7,
            0.399_107_266_381_437_2,
            1.0,
        ];
        let series = ModeSeries::new(&problem, &origin, &[1, 2, 3, 4], &[region], 1 << 24);
        let decider = Decider::new(&problem, std::slice::from_ref(&region), series.as_ref());
        assert_eq!(decider.is_unstable(&coefficients), Some((false, Way::Refined)));
    }
}
