//! Proofs of which eigenvalues of dense matrices are unstable over intervals of a path.

use super::branches::{Branches, Critical, Followed, Path, Target};
use super::dense_branches::DenseBranches;
use super::discs::{Discs, Expansion, Isolated};
use super::error::Error;
use super::interval::{Change, multiplicity};
use super::pair::{Complex, Pair};
use super::quadratic::DenseQuadratic;
use super::region::{RESOLUTION, Region, ZERO};
use super::sweep::{Intervals, Sweep};
use crate::model::critical_values::{OnInterval, UnstableValues};

/// The interval of a crossing is looked at where it is less than this part of the one it was found in, and so often at most.
const SHRINKS: f64 = 0.5;
const DEEPEST: usize = 30;

/// The interval of a crossing that is as wide as so many errors of rounding does not become narrower.
const ROUNDED: f64 = 12.0;

/// How much of its way over an interval, at its least slope, an eigenvalue may be off that passes an edge in it.
const CROSSING: f64 = 0.25;

/// Parts of half of an interval, from its middle, at which it is asked whether rounding alone hides what is unstable.
const PLACES: [f64; 3] = [0.0, -0.6, 0.6];

/// The intervals of a path through dense matrices, all in the unit of the problem.
///
/// Nothing is interpolated, and no mode is followed. In the basis of the eigenvectors at the middle of an interval, [`Discs`] hold
/// all eigenvalues over the whole of it. Where each keeps clear of the edge of the region, or passes it once and at a slope, the number of unstable
/// eigenvalues is known all over the interval, but for the narrow intervals in which these pass.
pub(super) struct Covering<'a> {
    branches: DenseBranches<'a>,
    region: &'a Region,
    /// How many eigenvalues are zero, whatever the parameter.
    zeros: usize,
    /// Whether the spectrum is its own mirror image at the imaginary axis, whatever the parameter.
    is_mirrored: bool,
}

/// What discs say of an interval.
enum Said {
    /// An eigenvalue is unstable all along.
    Unstable,
    /// Where eigenvalues pass the edge; otherwise all keep to their side of it.
    Crossings(Vec<Crossing>),
    /// Too little.
    Nothing,
}

/// An eigenvalue that passes the edge once.
struct Crossing {
    index: usize,
    target: Target,
    /// Between which steps from the middle.
    within: [f64; 2],
    /// Whether rounding alone keeps these apart.
    is_rounding: bool,
}

/// A part of an interval with a verdict, or without one about a crossing.
#[derive(Debug, Clone, Copy)]
struct Part {
    ends: [f64; 2],
    is_unstable: Option<bool>,
}

/// A distance from the edge of the region, positive on the side of what is unstable, along the centre of a disc.
struct Distance {
    target: Target,
    /// By powers of the step.
    coefficients: [f64; 5],
    least: f64,
    most: f64,
    /// What the third and fourth powers make at most.
    slack: f64,
    /// Whether the centre passes the real axis, where the frequency turns back.
    is_folded: bool,
}

/// An eigenvalue beside the region.
struct Seen {
    distances: Vec<Distance>,
    /// By how much it is unstable, or is not, all along; one of them is negative.
    inside: f64,
    outside: f64,
    /// Whether it is known exactly, and not unstable.
    is_exact: bool,
}

impl<'a> Covering<'a> {
    pub(super) fn new(problem: &'a DenseQuadratic, path: &'a dyn Path, region: &'a Region) -> Self {
        let branches = DenseBranches { problem, path };
        Self { branches, region, zeros: problem.zeros(), is_mirrored: problem.is_mirrored() }
    }

    fn expansion(&self, p: f64, step: f64) -> Option<Expansion> {
        Expansion::new(self.branches.problem, self.branches.path, p, step)
    }

    /// The parts of an interval; nothing where it is to be halved.
    fn parts(&self, ends: [f64; 2], depth: usize) -> Option<Vec<Part>> {
        if self.branches.problem.size() == 0 {
            return Some(vec![Part { ends, is_unstable: Some(false) }]);
        }
        let (p, step) = middle(ends);
        let expansion = self.expansion(p, step)?;
        let discs = expansion.discs(step)?;
        let seen = self.seen(&discs);
        let mut crossings = match self.said(&discs, &seen, false) {
            Said::Unstable => return Some(vec![Part { ends, is_unstable: Some(true) }]),
            Said::Nothing => return None,
            Said::Crossings(crossings) => crossings,
        };
        crossings.sort_by(|a, b| a.within[0].total_cmp(&b.within[0]));
        // Crossings that overlap are looked at as one.
        let mut holes: Vec<Crossing> = Vec::new();
        for crossing in crossings {
            match holes.last_mut() {
                Some(last) if crossing.within[0] <= last.within[1] => {
                    last.within[1] = last.within[1].max(crossing.within[1]);
                    last.is_rounding &= crossing.is_rounding;
                }
                _ => holes.push(crossing),
            }
        }
        let unstable_at = |step: f64| seen.iter().any(|eigenvalue| eigenvalue.is_unstable_at(step));
        let mut parts = Vec::new();
        let mut from = (ends[0], -step);
        for hole in holes {
            let slack = 2.0 * f64::EPSILON * p.abs();
            let [low, high] =
                [p + hole.within[0] - slack, p + hole.within[1] + slack].map(|p| p.clamp(ends[0], ends[1]));
            if low > from.0 {
                let is_unstable = Some(unstable_at(0.5 * (from.1 + hole.within[0])));
                parts.push(Part { ends: [from.0, low], is_unstable });
            }
            let narrower = high - low <= SHRINKS * (ends[1] - ends[0]) && depth < DEEPEST;
            let inner = if hole.is_rounding || !narrower { None } else { self.parts([low, high], depth + 1) };
            parts.extend(inner.unwrap_or_else(|| vec![Part { ends: [low, high], is_unstable: None }]));
            from = (high, hole.within[1]);
        }
        if from.0 < ends[1] {
            let is_unstable = Some(unstable_at(0.5 * (from.1 + step)));
            parts.push(Part { ends: [from.0, ends[1]], is_unstable });
        }
        Some(parts)
    }

    /// The number of unstable eigenvalues at the lower end and where it changes; nothing where the interval is to be halved.
    fn counted(&self, ends: [f64; 2]) -> Result<Option<Sweep>, Error> {
        let (p, step) = middle(ends);
        let Some(expansion) = self.expansion(p, step) else { return Ok(None) };
        let Some(discs) = expansion.discs(step) else { return Ok(None) };
        let seen = self.seen(&discs);
        let Said::Crossings(crossings) = self.said(&discs, &seen, true) else { return Ok(None) };
        // The next interval may have what passes at an end.
        if crossings.iter().any(|crossing| crossing.within[0] <= -step || crossing.within[1] >= step) {
            return Ok(None);
        }
        let at_start = seen.iter().filter(|eigenvalue| eigenvalue.is_unstable_at(-step)).count();
        let mut changes = Vec::new();
        for crossing in crossings {
            let [from, to] = crossing.within;
            let at = 0.5 * (from + to);
            let [right, left] = expansion.vectors(crossing.index).map(|vector| vector.data.into());
            let eigenvalue = discs.centre(crossing.index, at);
            match self.change(
                &Pair { eigenvalue, right, left, error: f64::INFINITY },
                p + at,
                crossing.target,
                [p + from, p + to],
            ) {
                Ok(change) => changes.push(change),
                Err(Error::NotConverged { .. }) => return Ok(None),
                Err(error) => return Err(error),
            }
        }
        changes.sort_by(|a, b| a.p.total_cmp(&b.p));
        Ok(Some(Sweep { at_start, changes, unresolved: Vec::new() }))
    }

    /// The change that a pair makes which passes the edge between two places, from an approximate one.
    fn change(&self, pair: &Pair, p: f64, target: Target, within: [f64; 2]) -> Result<Change, Error> {
        let branches: &dyn Branches = &self.branches;
        let place = branches.at(p)?;
        let Complex { re, im } = pair.eigenvalue;
        let start = Followed::new(p, place.refine(pair)?, &*place);
        let critical: Critical = branches.critical(target, &start, within)?;
        if !critical.error.is_finite() {
            return Err(Error::NotConverged { re, im });
        }
        let more = multiplicity(pair.eigenvalue);
        Ok(Change::new(self.region, target, critical, within, more).1)
    }

    /// Whether nothing is known of an interval because eigenvalues are nearer to the edge than their rounding.
    fn is_rounding(&self, ends: [f64; 2]) -> bool {
        let (p, step) = middle(ends);
        PLACES.into_iter().all(|part| {
            let discs = self.expansion(p + part * step, 0.0).and_then(|expansion| expansion.discs(0.0));
            discs.is_none_or(|discs| matches!(self.said(&discs, &self.seen(&discs), false), Said::Nothing))
        })
    }

    /// The number of unstable eigenvalues at a place, by all of them.
    fn count(&self, p: f64) -> Result<i32, Error> {
        let problem = self.branches.problem.at(&self.branches.path.coefficients(p));
        let values = problem.eigenvalues().map_err(|_| Error::NotConverged { re: f64::NAN, im: f64::NAN })?;
        let count = values.iter().filter(|value| self.region.contains(**value)).count();
        Ok(i32::try_from(count).unwrap_or(i32::MAX))
    }

    fn seen(&self, discs: &Discs) -> Vec<Seen> {
        (0..discs.radii.len()).map(|index| self.eigenvalue(discs, index)).collect()
    }

    /// An eigenvalue beside the threshold itself where discs tell on which side it is or where it passes; otherwise beside the one
    /// below which samples count as unstable, so that undamped ones are stable.
    fn eigenvalue(&self, discs: &Discs, index: usize) -> Seen {
        let beside = |by: f64| self.beside(discs, index, self.region.damping_ratio - by);
        let seen = beside(0.0);
        let is_told = match discs.radii[index] {
            Some(Isolated { radius, .. }) => {
                seen.is_exact || radius < seen.clear() || crossing(discs, &seen, index, radius).is_some()
            }
            None => seen.clear() > 0.0,
        };
        if is_told { seen } else { beside(RESOLUTION) }
    }

    fn beside(&self, discs: &Discs, index: usize, threshold: f64) -> Seen {
        let Region { lowest, highest, damping_ratio } = *self.region;
        let (step, centre) = (discs.step, discs.centres[index]);
        let sign = if centre[0].im < 0.0 { -1.0 } else { 1.0 };
        let isolated = discs.radii[index];
        // A real eigenvalue that is alone stays real.
        let is_real = centre[0].im == 0.0 && isolated.is_some_and(|isolated| isolated.cluster == 1);
        let of = |target: Target, re: f64, im: f64, constant: f64| {
            let mut coefficients = centre.map(|value| re * value.re + im * sign * value.im);
            coefficients[0] += constant;
            Distance::new(target, coefficients, step)
        };
        let mut distances = Vec::new();
        if is_real {
            if lowest <= 0.0 {
                distances.push(of(Target::Growth, 1.0, 0.0, -ZERO));
            }
        } else {
            let cosine = ((1.0 - threshold) * (1.0 + threshold)).max(0.0).sqrt();
            distances.push(of(Target::DampingRatio(threshold), cosine, threshold, 0.0));
            if lowest > 0.0 {
                distances.push(of(Target::Frequency(lowest), 0.0, 1.0, -lowest));
            }
            if highest.is_finite() {
                distances.push(of(Target::Frequency(highest), 0.0, -1.0, highest));
            }
            // Where a centre passes the real axis, its frequency is the other way round.
            let folded = 2.0 * (-of(Target::Growth, 0.0, 1.0, 0.0).least).max(0.0);
            for distance in &mut distances {
                distance.least -= folded;
                distance.most += folded;
                distance.is_folded = folded > 0.0;
            }
        }
        let (inside, outside) = if distances.is_empty() {
            (f64::NEG_INFINITY, f64::INFINITY)
        } else {
            let least = distances.iter().map(|distance| distance.least).fold(f64::INFINITY, f64::min);
            let most = distances.iter().map(|distance| distance.most).fold(f64::INFINITY, f64::min);
            // Next to zero nothing is unstable.
            let [re, im] = [of(Target::Growth, 1.0, 0.0, 0.0), of(Target::Growth, 0.0, 1.0, 0.0)];
            let largest = [re.least, re.most, im.least, im.most].into_iter().map(f64::abs).fold(0.0, f64::max);
            if is_real { (least, -most) } else { (least - 2.0 * ZERO, (-most).max(ZERO - largest)) }
        };
        let largest = |re: bool| {
            let part = of(Target::Growth, f64::from(u8::from(re)), f64::from(u8::from(!re)), 0.0);
            part.least.abs().max(part.most.abs())
        };
        // No other disc can have the mirror image of this eigenvalue, or zero.
        let is_exact = isolated.is_some_and(|isolated| {
            let is_on_axis = self.is_mirrored && damping_ratio <= 0.0 && isolated.cluster == 1;
            let is_zero = isolated.cluster <= self.zeros && centre[0].im == 0.0;
            is_on_axis && isolated.radius + 2.0 * largest(true) < 0.5 * isolated.gap
                || is_zero && largest(true) + largest(false) < (0.5 * isolated.gap).min(100.0 * ZERO)
        });
        Seen { distances, inside, outside, is_exact }
    }

    /// What the discs say; whether an eigenvalue is unstable all along only where not all crossings are wanted.
    fn said(&self, discs: &Discs, seen: &[Seen], is_all: bool) -> Said {
        let states = seen.len();
        let mut crossings = Vec::new();
        let mut open = Vec::new();
        for (i, eigenvalue) in seen.iter().enumerate() {
            let Some(isolated) = discs.radii[i] else {
                open.push(i);
                continue;
            };
            if eigenvalue.is_exact || isolated.radius < eigenvalue.outside {
                continue;
            }
            if isolated.radius < eigenvalue.inside {
                // Of a cluster one disc may hold what another has lost.
                if is_all || isolated.cluster > 1 {
                    continue;
                }
                return Said::Unstable;
            }
            match crossing(discs, eigenvalue, i, isolated.radius) {
                Some(crossing) => crossings.push(crossing),
                None => open.push(i),
            }
        }
        if !open.is_empty() {
            let is_open = |i: &usize| open.contains(i);
            let allowed = |i: usize| {
                let own = if is_open(&i) { seen[i].clear() - discs.own[i] } else { f64::INFINITY };
                let others = (0..states).filter(|j| is_open(j) != is_open(&i));
                others.map(|j| 0.5 * discs.distance(i, j)).fold(own, f64::min)
            };
            let allowed: Vec<f64> = (0..states).map(allowed).collect();
            if discs.within(&allowed).is_none() {
                return Said::Nothing;
            }
            if !is_all && open.iter().any(|&i| seen[i].inside > seen[i].outside) {
                return Said::Unstable;
            }
        }
        // Conjugates pass the edge together.
        crossings.retain(|crossing| discs.centres[crossing.index][0].im >= 0.0);
        Said::Crossings(crossings)
    }
}

impl Seen {
    /// How far it is from the edge all along.
    fn clear(&self) -> f64 {
        self.inside.max(self.outside)
    }

    fn is_unstable_at(&self, step: f64) -> bool {
        let is_beyond = |distance: &Distance| distance.at(step) > 0.0;
        !self.is_exact && self.outside <= 0.0 && self.distances.iter().all(is_beyond)
    }
}

impl Distance {
    fn new(target: Target, coefficients: [f64; 5], step: f64) -> Self {
        let [a, b, c, d, e] = coefficients;
        let slack = step * step * step * (d.abs() + step * e.abs());
        let at = |x: f64| a + x * (b + x * c);
        let top = -0.5 * b / c;
        let inner = if top.abs() < step { at(top) } else { at(step) };
        let values = [at(-step), at(step), inner];
        let least = values.into_iter().fold(f64::INFINITY, f64::min) - slack;
        let most = values.into_iter().fold(f64::NEG_INFINITY, f64::max) + slack;
        Self { target, coefficients, least, most, slack, is_folded: false }
    }

    fn at(&self, step: f64) -> f64 {
        self.coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * step + coefficient)
    }
}

/// How an eigenvalue within a radius of its centre passes the edge; nothing where that is not told, or not once.
fn crossing(discs: &Discs, eigenvalue: &Seen, index: usize, radius: f64) -> Option<Crossing> {
    let step = discs.step;
    let (met, others): (Vec<&Distance>, Vec<&Distance>) =
        eigenvalue.distances.iter().partition(|distance| distance.least <= radius && distance.most >= -radius);
    let [met] = met[..] else { return None };
    if met.is_folded || others.iter().any(|distance| distance.least <= radius) {
        return None;
    }
    let [a, b, c, d, e] = met.coefficients;
    let [low, high] = [b - 2.0 * c * step, b + 2.0 * c * step];
    let least = low.abs().min(high.abs()) - step * step * (3.0 * d.abs() + 4.0 * step * e.abs());
    if low * high <= 0.0 || least <= 0.0 || radius >= CROSSING * step * least {
        return None;
    }
    let error = radius + met.slack;
    // a + b x + c x^2 rises or falls: its only root in the interval, or the end that is nearer.
    let root = |value: f64| {
        let a = a - value;
        let square = b * b - 4.0 * a * c;
        let root = if square < 0.0 { f64::NAN } else { -2.0 * a / (b + square.sqrt().copysign(b)) };
        let nearer_end = if (a > 0.0) == (b > 0.0) { -step } else { step };
        if root.is_nan() { nearer_end } else { root.clamp(-step, step) }
    };
    let [one, other] = [root(-error), root(error)];
    let within = [one.min(other), one.max(other)];
    let is_rounding = within[1] - within[0] <= ROUNDED * discs.rounding[index] / least;
    Some(Crossing { index, target: met.target, within, is_rounding })
}

impl Intervals for Covering<'_> {
    fn settle(&mut self, ends: [f64; 2], may_halve: bool) -> Result<Option<Sweep>, Error> {
        if let Some(sweep) = self.counted(ends)? {
            return Ok(Some(sweep));
        }
        if may_halve && !self.is_rounding(ends) {
            return Ok(None);
        }
        let [from, to] = [self.count(ends[0])?, self.count(ends[1])?];
        let at_start = usize::try_from(from).unwrap_or(0);
        Ok(Some(Sweep { at_start, changes: Vec::new(), unresolved: vec![(ends, to - from)] }))
    }

    fn unstable(&mut self, ends: [f64; 2], may_halve: bool) -> Result<OnInterval, Error> {
        match self.parts(ends, 0) {
            Some(parts) => Ok(Some(unstable(&parts))),
            None if may_halve && !self.is_rounding(ends) => Ok(None),
            None => Ok(Some(UnstableValues { surely: Vec::new(), possibly: vec![ends] })),
        }
    }
}

/// The unstable values of these parts.
fn unstable(parts: &[Part]) -> UnstableValues {
    let with = |is_wanted: fn(Option<bool>) -> bool| {
        parts.iter().filter(|part| is_wanted(part.is_unstable)).map(|part| part.ends).collect()
    };
    let unstable = UnstableValues {
        surely: with(|is_unstable| is_unstable == Some(true)),
        possibly: with(|is_unstable| is_unstable != Some(false)),
    };
    UnstableValues::default().or(&unstable)
}

/// The middle of an interval, and the step from there to its ends.
fn middle([low, high]: [f64; 2]) -> (f64, f64) {
    let p = low + 0.5 * (high - low);
    (p, (high - p).max(p - low))
}
