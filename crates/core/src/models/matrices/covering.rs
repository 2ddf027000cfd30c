//! Proofs of which eigenvalues of dense matrices are unstable over intervals of a path.

use super::branches::Path;
use super::discs::{Discs, Expansion, SHARE};
use super::error::Error;
use super::quadratic::{DenseQuadratic, Mirrored};
use super::region::{RESOLUTION, Region};
use super::sweep::{Intervals, middle};
use crate::model::critical_values::{OnInterval, UnstableValues};

/// The interval of a crossing is looked at where it is less than this part of the one it was found in, and so often at most.
const SHRINKS: f64 = 0.5;
const DEEPEST: usize = 30;

/// The interval of a crossing that is as wide as so many errors of rounding does not become narrower.
const ROUNDED: f64 = 12.0;

/// How much of its way over an interval, at its least slope, an eigenvalue may be off that passes an edge in it.
const CROSSING: f64 = 0.25;

/// Growth of an eigenvalue that is zero all along, as far as rounding tells, from which on it would count; in the unit of the problem.
const GROWTH_RESOLUTION: f64 = 1e-10;

/// Parts of half of an interval, from its middle, at which it is asked whether rounding alone hides what is unstable.
const PLACES: [f64; 3] = [0.0, -0.6, 0.6];

/// The intervals of a path through dense matrices, all in the unit of the problem.
///
/// Nothing is interpolated, and no mode is followed. In the basis of the eigenvectors at the middle of an interval, [`Discs`] hold
/// all eigenvalues over the whole of it. Where each keeps clear of the edge of the region, or passes it once and at a slope, it
/// is known whether one is unstable all over the interval, but for the narrow intervals in which these pass.
pub(super) struct Covering<'a> {
    problem: &'a DenseQuadratic,
    path: &'a dyn Path,
    region: &'a Region,
    /// How many eigenvalues are zero, whatever the parameter.
    zeros: usize,
    mirrored: Mirrored,
    /// Of each term; none where they make no difference.
    asymmetries: Vec<f64>,
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
    /// By powers of the step.
    coefficients: [f64; 5],
    least: f64,
    most: f64,
    /// What the third and fourth powers make at most.
    slack: f64,
    /// Whether the centre passes the real axis, where the frequency turns back.
    is_folded: bool,
}

/// Where an eigenvalue is, seen from the edge of the region.
struct Seen {
    distances: Vec<Distance>,
    /// By how much it is unstable, or is not, all along; negative where it is not so.
    inside: f64,
    outside: f64,
    /// Whether it is zero, or stays on the imaginary axis.
    is_exact: bool,
    /// Whether it is zero all along, as far as rounding tells.
    is_zero: bool,
}

impl<'a> Covering<'a> {
    pub(super) fn new(problem: &'a DenseQuadratic, path: &'a dyn Path, region: &'a Region) -> Self {
        let mirrored = problem.mirrored();
        let asymmetries = if mirrored == Mirrored::ButForRounding { problem.asymmetries() } else { Vec::new() };
        Self { problem, path, region, zeros: problem.zeros(), mirrored, asymmetries }
    }

    fn expansion(&self, p: f64, step: f64) -> Option<Expansion> {
        Expansion::new(self.problem, self.path, (p, step), &self.asymmetries)
    }

    /// The parts of an interval; nothing where it is to be halved. One that may be is halved where a crossing stays wide, too.
    /// `within` are how deep it is in intervals of crossings, and how many eigenvalues are zero all along the one that it was found in.
    fn parts(&self, ends: [f64; 2], within: (usize, usize), may_halve: bool) -> Option<Vec<Part>> {
        if self.problem.size() == 0 {
            return Some(vec![Part { ends, is_unstable: Some(false) }]);
        }
        let p = middle(ends[0], ends[1]);
        let step = (ends[1] - p).max(p - ends[0]);
        let expansion = self.expansion(p, step)?;
        let discs = expansion.discs(step)?;
        let seen = self.seen(&discs);
        let (depth, most_zeros) = within;
        let zeros = seen.iter().filter(|eigenvalue| eigenvalue.is_zero).count();
        if zeros > most_zeros {
            // One that passes zero here is no longer told from one that stays there.
            return Some(vec![Part { ends, is_unstable: None }]);
        }
        let mut crossings = match self.said(&discs, &seen) {
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
            let inner = if hole.is_rounding || !narrower {
                None
            } else {
                self.parts([low, high], (depth + 1, zeros), may_halve)
            };
            if inner.is_none() && may_halve && !hole.is_rounding && !self.is_rounding([low, high]) {
                return None;
            }
            parts.extend(inner.unwrap_or_else(|| vec![Part { ends: [low, high], is_unstable: None }]));
            from = (high, hole.within[1]);
        }
        if from.0 < ends[1] {
            let is_unstable = Some(unstable_at(0.5 * (from.1 + step)));
            parts.push(Part { ends: [from.0, ends[1]], is_unstable });
        }
        Some(parts)
    }

    /// Whether nothing is known of an interval because eigenvalues are nearer to the edge than their rounding.
    fn is_rounding(&self, ends: [f64; 2]) -> bool {
        let p = middle(ends[0], ends[1]);
        let step = (ends[1] - p).max(p - ends[0]);
        PLACES.into_iter().all(|part| {
            let discs = self.expansion(p + part * step, 0.0).and_then(|expansion| expansion.discs(0.0));
            discs.is_none_or(|discs| matches!(self.said(&discs, &self.seen(&discs)), Said::Nothing))
        })
    }

    fn seen(&self, discs: &Discs) -> Vec<Seen> {
        (0..discs.radii.len()).map(|index| self.eigenvalue(discs, index)).collect()
    }

    /// An eigenvalue beside the edge of what is unstable; where it is zero all along, as far as rounding tells, beside a growth that it is
    /// clear of.
    fn eigenvalue(&self, discs: &Discs, index: usize) -> Seen {
        let seen = self.beside(discs, index, 0.0);
        if seen.is_zero { self.beside(discs, index, GROWTH_RESOLUTION) } else { seen }
    }

    /// An eigenvalue beside the edge, to which for real ones so much growth belongs.
    fn beside(&self, discs: &Discs, index: usize, growth: f64) -> Seen {
        let Region { lowest, highest, damping_ratio } = *self.region;
        let threshold = damping_ratio - RESOLUTION;
        let (step, centre) = (discs.step, discs.centres[index]);
        let sign = if centre[0].im < 0.0 { -1.0 } else { 1.0 };
        let isolated = discs.radii[index];
        // A real eigenvalue that is alone stays real.
        let is_real = centre[0].im == 0.0 && isolated.is_some_and(|isolated| isolated.cluster == 1);
        let of = |re: f64, im: f64, constant: f64| {
            let mut coefficients = centre.map(|value| re * value.re + im * sign * value.im);
            coefficients[0] += constant;
            Distance::new(coefficients, step)
        };
        let [re, im] = [of(1.0, 0.0, 0.0), of(0.0, 1.0, 0.0)];
        let lowest_frequency = im.least;
        let [re, im] = [re, im].map(|part| part.least.abs().max(part.most.abs()));
        let mut distances = Vec::new();
        if is_real {
            if lowest <= 0.0 {
                distances.push(of(1.0, 0.0, -growth));
            }
        } else {
            let cosine = ((1.0 - threshold) * (1.0 + threshold)).max(0.0).sqrt();
            distances.push(of(cosine, threshold, 0.0));
            if lowest > 0.0 {
                distances.push(of(0.0, 1.0, -lowest));
            }
            if highest.is_finite() {
                distances.push(of(0.0, -1.0, highest));
            }
            // Where a centre passes the real axis, its frequency is the other way round.
            let folded = 2.0 * (-lowest_frequency).max(0.0);
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
            if is_real { (least, -most) } else { (least - 2.0 * growth, (-most).max(growth - re.max(im))) }
        };
        // It is its own mirror image in the middle and never meets another one. Other discs keep away from the centre, and zero does not.
        let is_exact = isolated.is_some_and(|isolated| {
            let is_mirrored = match self.mirrored {
                Mirrored::Surely => true,
                // It is nearer to the axis than what counts: its conjugate is twice its frequency away, or less.
                Mirrored::ButForRounding => {
                    let off = 2.0 * discs.asymmetry[index] + ROUNDED * discs.rounding[index];
                    off < 0.5 * isolated.gap * RESOLUTION
                }
                Mirrored::No => false,
            };
            let is_on_axis = is_mirrored && damping_ratio <= 0.0 && isolated.cluster == 1;
            let is_zero = isolated.cluster <= self.zeros;
            is_on_axis && isolated.radius + 2.0 * re < 0.5 * isolated.gap || is_zero && re + im < SHARE * isolated.gap
        });
        let is_zero = re.max(im) < ROUNDED * discs.rounding[index];
        Seen { distances, inside, outside, is_exact, is_zero }
    }

    fn said(&self, discs: &Discs, seen: &[Seen]) -> Said {
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
                if isolated.cluster > 1 {
                    continue;
                }
                return Said::Unstable;
            }
            match crossing(discs, eigenvalue, i, isolated.radius) {
                // Conjugates pass the edge together.
                Some(_) if discs.centres[i][0].im < 0.0 => {}
                Some(crossing) => crossings.push(crossing),
                None => open.push(i),
            }
        }
        // Where a disc of a cluster is open, what the others hold is not known either.
        let first = |i: usize| discs.radii[i].filter(|isolated| isolated.cluster > 1).map(|isolated| isolated.first);
        let clusters: Vec<usize> = open.iter().filter_map(|&i| first(i)).collect();
        open.extend((0..states).filter(|&i| first(i).is_some_and(|first| clusters.contains(&first))));
        open.sort_unstable();
        open.dedup();
        if !open.is_empty() {
            let is_open = |i: &usize| open.contains(i);
            let allowed = |i: usize| {
                let own = if is_open(&i) { seen[i].clear() - discs.own[i] } else { f64::INFINITY };
                let others = (0..states).filter(|j| is_open(j) != is_open(&i));
                others.map(|j| 0.5 * discs.distance(i, j)).fold(own, f64::min)
            };
            let allowed: Vec<f64> = (0..states).map(allowed).collect();
            if !discs.hold_within(&allowed) {
                return Said::Nothing;
            }
            if open.iter().any(|&i| seen[i].inside > seen[i].outside) {
                return Said::Unstable;
            }
        }
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
    fn new(coefficients: [f64; 5], step: f64) -> Self {
        let [a, b, c, d, e] = coefficients;
        let slack = step * step * step * (d.abs() + step * e.abs());
        let at = |x: f64| a + x * (b + x * c);
        let top = -0.5 * b / c;
        let inner = if top.abs() < step { at(top) } else { at(step) };
        let values = [at(-step), at(step), inner];
        let least = values.into_iter().fold(f64::INFINITY, f64::min) - slack;
        let most = values.into_iter().fold(f64::NEG_INFINITY, f64::max) + slack;
        Self { coefficients, least, most, slack, is_folded: false }
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
    Some(Crossing { within, is_rounding })
}

impl Intervals for Covering<'_> {
    fn unstable(&mut self, ends: [f64; 2], may_halve: bool) -> Result<OnInterval, Error> {
        match self.parts(ends, (0, usize::MAX), may_halve) {
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

#[cfg(test)]
mod tests;
