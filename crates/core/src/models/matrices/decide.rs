//! In which bands a sample has an unstable pair: by the characteristic polynomial of two coordinates, by a series where that
//! is sure, by its vectors or by refining single eigenvalues where it is not, and by all eigenvalues where nothing else will
//! do.

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

/// Growth of a real eigenvalue, in the unit of the problem, up to which it may be a zero that rounding moves: where the stiffness is
/// singular.
const NEARLY_ZERO: f64 = 1e-10;

/// Coordinates from which on eigenvalues by vector instructions save time.
const LARGE: usize = 24;

/// How far from the edge of a region eigenvalues count with any last bits, in parts of themselves and of the norm of the
/// matrix: some thousand times the change of a pair that is about to couple with another, whose eigenvalues move by the root of
/// the rounding.
pub(super) const CLEAR: f64 = 1e-4;
pub(super) const CLEAR_OF_NORM: f64 = 1e-9;

/// Decides samples of a problem about an origin.
pub struct Decider<'a> {
    problem: &'a DenseQuadratic,
    /// In the unit of the problem.
    regions: &'a [Region],
    /// Whether they are kept apart; else only whether a pair is in one of them.
    are_apart: bool,
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

/// A set of regions: a bit for each place in a list, the last for all further ones.
pub type RegionSet = u64;

/// The set of a region at a place.
#[must_use]
pub fn region_at(place: usize) -> RegionSet {
    1 << place.min(MOST_REGIONS - 1)
}

/// Regions that a set keeps apart.
pub const MOST_REGIONS: usize = RegionSet::BITS as usize;

/// What is known of the regions that one of several eigenvalues is in.
#[derive(Debug, Clone, Copy, Default)]
struct Known {
    /// Those that one surely is in.
    inside: RegionSet,
    /// Those that one may be in.
    open: RegionSet,
}

impl Known {
    /// What is not known, where these are found to have one.
    fn open_but_for(self, found: RegionSet) -> RegionSet {
        self.open & !found
    }
}

impl<'a> Decider<'a> {
    /// Decides whether samples are unstable in one of these regions, in the unit of the problem, with a series if there is one.
    pub(super) fn of_any(problem: &'a DenseQuadratic, regions: &'a [Region], series: Option<&'a ModeSeries>) -> Self {
        Self { problem, regions, are_apart: false, series }
    }

    /// Decides in which of these regions samples are unstable, by all eigenvalues.
    pub(super) fn of_each(problem: &'a DenseQuadratic, regions: &'a [Region]) -> Self {
        Self { problem, regions, are_apart: true, series: None }
    }

    /// The set of the region at a place.
    fn region_at(&self, place: usize) -> RegionSet {
        if self.are_apart { region_at(place) } else { 1 }
    }

    /// The regions in which a sample with these coefficients is unstable, without all eigenvalues, and how that was found; `None`
    /// where that does not tell.
    #[must_use]
    pub fn by_series(&self, coefficients: &[f64]) -> Option<(RegionSet, Way)> {
        if let Some(values) = two_coordinates::eigenvalues(self.problem, coefficients)
            && let Some(told) = self.told(values)
        {
            return Some((told, Way::ClosedForm));
        }
        let series = self.series?;
        let (monomials, followed) = series.follow(coefficients)?;
        let mut found = 0;
        let mut known = Vec::with_capacity(followed.len());
        for mode in &followed {
            let of_mode = self.sure(mode.eigenvalue, mode.radius);
            found |= of_mode.inside;
            if found == self.all() {
                return Some((found, Way::Series));
            }
            known.push(of_mode);
        }
        let (mut unsure, mut sure) = (Vec::new(), Vec::new());
        for (mode, of_mode) in followed.into_iter().zip(known) {
            if of_mode.open_but_for(found) == 0 { sure.push(mode) } else { unsure.push(mode) }
        }
        if unsure.is_empty() {
            return Some((found, Way::Series));
        }
        // The least damped first: often it is unstable, and no other is asked for.
        unsure.sort_by(|a, b| damping_ratio(a.eigenvalue).total_cmp(&damping_ratio(b.eigenvalue)));
        self.by_vectors(&self.problem.at(coefficients), series, &monomials, &unsure, &sure, found)
    }

    /// The regions in which all eigenvalues show a sample unstable; `None` if they do not converge.
    #[must_use]
    pub fn by_all(&self, coefficients: &[f64]) -> Option<RegionSet> {
        let problem = self.problem.at(coefficients);
        if let Some(told) = self.clear(&problem) {
            return Some(told);
        }
        let all = problem.eigenvalues().ok()?;
        let is_clear = |value: &Eigenvalue| value.im != 0.0 || value.re > NEARLY_ZERO;
        let (clear, nearly_zero): (Vec<Eigenvalue>, Vec<_>) = all.into_iter().partition(is_clear);
        let [found, doubtful] = [clear, nearly_zero].map(|values| self.containing(values));
        let is_counted = doubtful & !found != 0 && self.problem.is_regular(coefficients);
        Some(if is_counted { found | doubtful } else { found })
    }

    /// Whether a sample is unstable in one of the regions, and how that was found.
    #[cfg(test)]
    pub(super) fn is_unstable(&self, coefficients: &[f64]) -> Option<(bool, Way)> {
        let by_all = || Some((self.by_all(coefficients)?, Way::All));
        self.by_series(coefficients).or_else(by_all).map(|(regions, way)| (regions != 0, way))
    }

    /// The regions in which one of the followed modes that the series does not tell is unstable, by its vectors or by refining
    /// it, beside those that are found already; `None` where the modes cannot be kept apart.
    fn by_vectors(
        &self,
        problem: &Quadratic,
        series: &ModeSeries,
        monomials: &Monomials,
        unsure: &[Followed],
        sure: &[Followed],
        mut found: RegionSet,
    ) -> Option<(RegionSet, Way)> {
        let (mut pairs, mut known) = (Vec::with_capacity(unsure.len()), Vec::with_capacity(unsure.len()));
        for mode in unsure {
            let pair = series.pair(problem, monomials, mode)?;
            let of_pair = self.sure(pair.eigenvalue, pair.error);
            found |= of_pair.inside;
            if found == self.all() {
                return Some((found, Way::Vectors));
            }
            pairs.push(pair);
            known.push(of_pair);
        }
        let is_known = |i: usize| known[i].open_but_for(found) == 0 && !is_another(&pairs, i);
        let way = if (0..pairs.len()).all(is_known) { Way::Vectors } else { Way::Refined };
        let settled = settled(problem, &pairs, unsure, sure, is_known)?;
        // What the vectors have told is told; their eigenvalues are not exact.
        let refined = settled.into_iter().enumerate().filter(|(i, _)| !is_known(*i)).map(|(_, value)| value);
        Some((found | self.containing(refined), way))
    }

    /// The regions in which a sample is unstable by eigenvalues whose last bits depend on the processor; `None` for small
    /// problems, for which they save no time, and where one of them is so near to the edge of a region that more than last
    /// bits matter.
    fn clear(&self, problem: &Quadratic) -> Option<RegionSet> {
        if problem.stiffness.nrows() < LARGE {
            return None;
        }
        let (all, norm) = fast_eigenvalues(&problem.companion())?;
        let zeros = problem.known_zeros(&all);
        let others = all.into_iter().enumerate().filter(|(place, _)| !zeros.contains(place));
        self.told(others.map(|(_, value)| (value, CLEAR * magnitude(value) + CLEAR_OF_NORM * norm)))
    }

    /// All regions.
    fn all(&self) -> RegionSet {
        (0..self.regions.len()).fold(0, |all, place| all | self.region_at(place))
    }

    /// The regions that contain one of these eigenvalues.
    fn containing(&self, eigenvalues: impl IntoIterator<Item = Eigenvalue>) -> RegionSet {
        let of_regions = |value: Eigenvalue| {
            let regions = self.regions.iter().enumerate().filter(move |(_, region)| region.contains(value));
            regions.map(|(place, _)| self.region_at(place))
        };
        eigenvalues.into_iter().flat_map(of_regions).fold(0, |found, region| found | region)
    }

    /// The regions of one eigenvalue that is known within a radius.
    fn sure(&self, eigenvalue: Eigenvalue, radius: f64) -> Known {
        let mut known = Known::default();
        for (place, region) in self.regions.iter().enumerate() {
            match region.sure(eigenvalue, radius + ROUNDING) {
                Some(true) => known.inside |= self.region_at(place),
                Some(false) => {}
                None => known.open |= self.region_at(place),
            }
        }
        known
    }

    /// The regions that surely have one of these eigenvalues, each known within its radius; `None` if more may.
    fn told(&self, eigenvalues: impl IntoIterator<Item = (Eigenvalue, f64)>) -> Option<RegionSet> {
        let mut all = Known::default();
        for (value, radius) in eigenvalues {
            let known = self.sure(value, radius);
            all = Known { inside: all.inside | known.inside, open: all.open | known.open };
        }
        (all.open_but_for(all.inside) == 0).then_some(all.inside)
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
mod tests;
