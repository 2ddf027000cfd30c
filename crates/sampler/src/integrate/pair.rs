//! The probability of instability where two inputs have any distributions and are correlated.
//!
//! The inputs are quantiles of their distributions at `Phi(z1)` and `Phi(z2)` (a Gaussian copula), and the deviates
//! have a normal law, which may be one given other inputs ([`PairLaw`]): `z1 = m1 + l11 u`, `z2 = m2 + l21 u + l22 w`.
//! With the first input `a(z1)`, the second one on the boundary `b_crit(a)`, and the deviate `t(b)` of a second input
//!
//! ```text
//! P = integral over u with a(z1) > 0 of   phi(u) Q((t(b_crit(a(z1))) - m2 - l21 u) / l22)   du
//! ```
//!
//! The integral is divided where an input's distribution begins, ends or has a kink, and until the argument of the upper
//! tail `Q` changes little from one end of an interval to the other. All tolerances are relative, and `t` is accurate in
//! both tails, so that a probability of 1e-12 has as many digits as one of 0.1.

use stickslip_core::model::pair_boundary::PairBoundary;
use stickslip_core::model::verdict::Verdict;

use crate::inputs::{End, InputDistribution, PairLaw};
use crate::integrate::closed_form::ExactProbability;
use crate::integrate::quadrature::{gauss_kronrod, over_the_line};
use crate::special_functions::normal;

/// Deviates beyond this carry a probability below 1e-126.
const DEVIATE_LIMIT: f64 = 24.0;

/// Width of the intervals to begin with, and where the second input hardly scatters given the first.
const WIDTHS: [f64; 2] = [3.0, 0.5];

/// Standard deviation of the second deviate given the first below which the tail may rise and fall again within an
/// interval.
const NARROW: f64 = 0.2;

/// Most that the argument of the tail changes over an interval.
const MOST_CHANGE: f64 = 3.0;

/// The arguments between which a change matters.
const ARGUMENTS: [f64; 2] = [-10.0, 40.0];

/// Intervals that contribute less than this share are left out.
const NEGLIGIBLE: f64 = 1e-18;

/// Most halvings of an interval for a steep tail, and for the tolerance.
const STEEPEST: u32 = 44;
const DEEPEST: u32 = 10;

/// An interval whose two rules agree to this is not halved: the rest is rounding.
const ROUNDED: f64 = 1e-12;

/// Most that arguments of the tail may differ, times one more than themselves, for a series of two terms: the third is
/// below 1e-12 of the first.
const MOST_WIDTH: f64 = 4e-3;

/// How far the boundary is moved to find what its rounding does, relative to its coordinates.
const MARGIN: f64 = 1.5e-11;

/// Rounding error of the boundary, likewise.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Two inputs, prepared for integrals over many boundaries.
#[derive(Debug, Clone)]
pub struct Pair {
    first: InputDistribution,
    second: InputDistribution,
    /// The deviates of the first input at which its quantiles have a kink.
    first_kinks: Vec<f64>,
    /// The values of the second input likewise.
    second_kinks: Vec<f64>,
    /// The greatest deviate at which the first input is not positive.
    not_positive: f64,
}

/// An interval of the deviate `u`.
#[derive(Debug, Clone, Copy)]
struct Interval {
    from: f64,
    to: f64,
    /// An upper and a lower bound of what it contributes, if the tail is monotonic in it.
    bounds: [f64; 2],
    /// How much the argument of the tail changes.
    change: f64,
}

/// One boundary, with the law of the deviates.
struct Integrand<'a> {
    pair: &'a Pair,
    boundary: &'a PairBoundary,
    law: &'a PairLaw,
    /// By how much the boundary is moved towards stability, relative to its coordinates.
    margin: f64,
    /// Whether stable samples are counted in place of unstable ones.
    of_stable: bool,
}

impl Pair {
    /// Prepares two inputs.
    #[must_use]
    pub fn new(first: InputDistribution, second: InputDistribution) -> Self {
        let kinks = first.kinks();
        let deviates = kinks.iter().flat_map(|&kink| [End::Least, End::Greatest].map(|end| first.deviate(kink, end)));
        let mut first_kinks: Vec<f64> = deviates.filter(|deviate| deviate.is_finite()).collect();
        first_kinks.dedup();
        let not_positive = first.deviate(0.0, End::Greatest);
        let second_kinks = second.kinks();
        Self { first, second, first_kinks, second_kinks, not_positive }
    }

    /// The probability that a sample is unstable, with a relative error of the integral of at most about `tolerance`.
    #[must_use]
    pub fn probability(&self, boundary: &PairBoundary, law: &PairLaw, tolerance: f64) -> f64 {
        Integrand { pair: self, boundary, law, margin: 0.0, of_stable: false }.integral(tolerance).0.clamp(0.0, 1.0)
    }

    /// The probability that a sample is stable: one minus that of instability, by an integral of its own, so that it has
    /// as many digits where it is small.
    #[must_use]
    pub fn stable_probability(&self, boundary: &PairBoundary, law: &PairLaw, tolerance: f64) -> f64 {
        Integrand { pair: self, boundary, law, margin: 0.0, of_stable: true }.integral(tolerance).0.clamp(0.0, 1.0)
    }

    /// The probability that a sample is unstable with the first boundary and stable with the second, which lies close
    /// beside it and makes nothing unstable that the first does not. Nothing cancels, so that the quotient by their
    /// distance is a density. Instability lies above both in the second input.
    #[must_use]
    pub fn probability_between(&self, boundaries: [&PairBoundary; 2], law: &PairLaw, tolerance: f64) -> f64 {
        let [wide, narrow] =
            boundaries.map(|boundary| Integrand { pair: self, boundary, law, margin: 0.0, of_stable: false });
        let probability = match (self.first.scatters(), self.second.scatters()) {
            (false, _) => share([wide.argument_of_second(), narrow.argument_of_second()]),
            (true, false) => share([wide.argument_of_first(), narrow.argument_of_first()]),
            (true, true) => {
                let between = |u: f64| narrow_share([wide.arguments(u)[0], narrow.arguments(u)[0]]);
                let weighted = |u: f64| normal::density(u) * between(u);
                let smooth = if wide.is_smooth() { over_the_line(&weighted, tolerance) } else { None };
                smooth.unwrap_or_else(|| wide.over_first(&between, tolerance).0)
            }
        };
        probability.clamp(0.0, 1.0)
    }

    /// The probability that a sample is unstable, with a bound on the error of the integral and of the rounded boundary.
    #[must_use]
    pub fn exact_probability(&self, boundary: &PairBoundary, law: &PairLaw) -> ExactProbability {
        const TOLERANCE: f64 = 1e-12;
        let integral =
            |margin: f64| Integrand { pair: self, boundary, law, margin, of_stable: false }.integral(TOLERANCE);
        let (value, error) = integral(0.0);
        let slope = (integral(MARGIN).0 - integral(-MARGIN).0).abs() / (2.0 * MARGIN);
        ExactProbability { value: value.clamp(0.0, 1.0), error_bound: error + ROUNDING * (value + slope) }
    }
}

impl Integrand<'_> {
    /// The integral, and an estimate of its error.
    fn integral(&self, tolerance: f64) -> (f64, f64) {
        let Pair { first, second, .. } = self.pair;
        let mean = self.law.mean;
        match (first.scatters(), second.scatters()) {
            (false, _) => {
                let std = self.law.second_variance().sqrt();
                let ends = self.ends(first.value(0.0)).map(|end| (end - mean[1]) / std);
                (self.share(ends), 0.0)
            }
            (true, false) => (self.share([self.argument_of_first(), f64::INFINITY]), 0.0),
            (true, true) => {
                let (value, error) = self.over_first(&|u| self.share(self.arguments(u)), tolerance);
                let mean = self.law.mean[0];
                // Where the first input is not positive, samples are stable.
                let beyond = if self.of_stable {
                    normal::upper_tail((mean - self.pair.not_positive) / self.law.factor[0])
                } else {
                    0.0
                };
                (value + beyond, error)
            }
        }
    }

    /// The probability that the second deviate has a sample counted: unstable ones lie between the ends.
    fn share(&self, ends: [f64; 2]) -> f64 {
        if self.of_stable { outside(ends) } else { share(ends) }
    }

    /// The argument of the upper tail of the second input, if the first does not scatter.
    fn argument_of_second(&self) -> f64 {
        let [from, _] = self.ends(self.pair.first.value(0.0));
        (from - self.law.mean[1]) / self.law.second_variance().sqrt()
    }

    /// The argument of the upper tail of the first input, if the second does not scatter.
    fn argument_of_first(&self) -> f64 {
        let critical = self.critical_first(self.pair.second.value(0.0));
        (self.pair.first.deviate(critical, End::Greatest) - self.law.mean[0]) / self.law.factor[0]
    }

    /// The deviates of the second input between which samples are unstable at a value of the first.
    fn ends(&self, first: f64) -> [f64; 2] {
        let first = first * (1.0 - self.margin);
        let (above, below) = self.boundary.unstable_second(first);
        if above == f64::INFINITY {
            return [f64::INFINITY; 2];
        }
        let is_included = self.boundary.verdict(first, above) == Verdict::Unstable;
        let input = &self.pair.second;
        let above = above * (1.0 + self.margin);
        let from = input.deviate(above, if is_included { End::Least } else { End::Greatest });
        let to = if below.is_finite() { input.deviate(below * (1.0 - self.margin), End::Least) } else { below };
        [from, to]
    }

    /// The first input on the boundary at a value of the second.
    fn critical_first(&self, second: f64) -> f64 {
        self.boundary.critical_first(second * (1.0 - self.margin)) * (1.0 + self.margin)
    }

    /// The arguments of the upper tail at a deviate `u`.
    fn arguments(&self, u: f64) -> [f64; 2] {
        let PairLaw { mean, factor: [own_first, by_first, own_second] } = *self.law;
        let ends = self.ends(self.pair.first.value(mean[0] + own_first * u));
        ends.map(|end| (end - mean[1] - by_first * u) / own_second)
    }

    /// Whether the arguments of the tail have no kinks, and do not pass through it and back within a small interval.
    fn is_smooth(&self) -> bool {
        let Pair { first_kinks, second_kinks, .. } = self.pair;
        let mut corners = second_kinks.iter().copied().chain([self.boundary.least_second]);
        let has_corner = corners.any(|corner| self.critical_first(corner).is_finite());
        first_kinks.is_empty() && !has_corner && self.law.factor[2] >= NARROW
    }

    /// The integral of a share over the deviates `u`, and an estimate of its error.
    fn over_first(&self, share: &dyn Fn(f64) -> f64, tolerance: f64) -> (f64, f64) {
        let integrand = |u: f64| [normal::density(u) * share(u)];
        let intervals = self.intervals();
        let estimates: Vec<_> =
            intervals.iter().map(|interval| gauss_kronrod(&integrand, interval.from, interval.to)).collect();
        let tolerance = tolerance * estimates.iter().map(|([value], _)| value).sum::<f64>();
        let mut sum = (0.0, 0.0);
        for (interval, &([value], [error])) in intervals.iter().zip(&estimates) {
            let (value, error) = halved(&integrand, interval.from, interval.to, (value, error), tolerance, DEEPEST);
            sum.0 += value;
            sum.1 += error;
        }
        sum
    }

    /// The intervals that contribute, in each of which the tail changes little.
    fn intervals(&self) -> Vec<Interval> {
        let nodes = self.nodes();
        let whole: Vec<Interval> =
            nodes.windows(2).filter(|pair| pair[0] < pair[1]).map(|pair| self.interval(pair[0], pair[1])).collect();
        let least = NEGLIGIBLE * whole.iter().map(|interval| interval.bounds[1]).fold(0.0, f64::max);
        let mut intervals = Vec::with_capacity(whole.len());
        whole.into_iter().for_each(|interval| self.divide(interval, least, STEEPEST, &mut intervals));
        intervals
    }

    fn interval(&self, from: f64, to: f64) -> Interval {
        // Inside, as the tail may jump at the ends.
        let inset = 1e-9 * (to - from);
        let [start, end] = [from + inset, to - inset].map(|u| self.arguments(u));
        let mass = mass(from, to);
        let shares = [self.share(start), self.share(end)];
        // Where the region has two ends, the share may be larger in between.
        let most = if start[1].is_finite() || end[1].is_finite() { 1.0 } else { shares[0].max(shares[1]) };
        let [least_argument, most_argument] = if self.of_stable { [-ARGUMENTS[1], -ARGUMENTS[0]] } else { ARGUMENTS };
        let clamped = |argument: f64| argument.clamp(least_argument, most_argument);
        let change = |i: usize| (clamped(start[i]) - clamped(end[i])).abs();
        Interval { from, to, bounds: [mass * most, mass * shares[0].min(shares[1])], change: change(0).max(change(1)) }
    }

    fn divide(&self, interval: Interval, least: f64, halvings: u32, intervals: &mut Vec<Interval>) {
        let Interval { from, to, bounds: [most, _], change } = interval;
        let is_narrow = self.law.factor[2] < NARROW;
        if most <= least && !is_narrow {
            return;
        }
        if change <= MOST_CHANGE || halvings == 0 {
            intervals.push(interval);
            return;
        }
        let middle = 0.5 * (from + to);
        for (from, to) in [(from, middle), (middle, to)] {
            self.divide(self.interval(from, to), least, halvings - 1, intervals);
        }
    }

    /// The deviates `u` at which to divide the integral, ascending.
    fn nodes(&self) -> Vec<f64> {
        let PairLaw { mean, factor: [own_first, _, own_second] } = *self.law;
        let Pair { first, first_kinks, second_kinks, not_positive, .. } = self.pair;
        let deviate = |z1: f64| (z1 - mean[0]) / own_first;
        let from = deviate(*not_positive).clamp(-DEVIATE_LIMIT, DEVIATE_LIMIT);
        let width = WIDTHS[usize::from(own_second < NARROW)];
        let steps = (DEVIATE_LIMIT / width) as i32;
        let mut nodes: Vec<f64> = (-steps..=steps).map(|step| width * f64::from(step)).collect();
        nodes.push(from);
        nodes.extend(first_kinks.iter().map(|&kink| deviate(kink)));
        for &kink in second_kinks.iter().chain([&self.boundary.least_second]) {
            let critical = self.critical_first(kink);
            if critical.is_finite() {
                nodes.extend([End::Least, End::Greatest].map(|end| deviate(first.deviate(critical, end))));
            }
        }
        nodes.retain(|node| (from..=DEVIATE_LIMIT).contains(node));
        nodes.sort_by(f64::total_cmp);
        nodes.dedup();
        if own_second < NARROW {
            self.add_turns(&mut nodes);
        }
        nodes
    }

    /// Adds the deviates at which an argument of the tail turns, as it may pass through zero and back beside them.
    fn add_turns(&self, nodes: &mut Vec<f64>) {
        let arguments: Vec<[f64; 2]> = nodes.iter().map(|&u| self.arguments(u)).collect();
        let mut turns = Vec::new();
        for i in 1..nodes.len().saturating_sub(1) {
            for which in [0, 1] {
                let [before, here, after] = [i - 1, i, i + 1].map(|i| arguments[i][which]);
                for sign in [1.0, -1.0] {
                    if here.is_finite() && sign * here <= sign * before && sign * here <= sign * after {
                        let value = |u: f64| sign * self.arguments(u)[which];
                        turns.push(least_of(value, nodes[i - 1], nodes[i + 1]));
                    }
                }
            }
        }
        nodes.extend(turns);
        nodes.sort_by(f64::total_cmp);
    }
}

/// The probability between two arguments of the upper tail, from the side on which nothing cancels.
fn share([from, to]: [f64; 2]) -> f64 {
    if to == f64::INFINITY {
        normal::upper_tail(from)
    } else if from >= to {
        0.0
    } else if from > 0.0 {
        normal::upper_tail(from) - normal::upper_tail(to)
    } else {
        normal::upper_tail(-to) - normal::upper_tail(-from)
    }
}

/// The probability that is not between two arguments of the upper tail.
fn outside([from, to]: [f64; 2]) -> f64 {
    if from < to { normal::upper_tail(-from) + normal::upper_tail(to) } else { 1.0 }
}

/// The probability between two arguments of the upper tail, by the series about their middle if they are close.
fn narrow_share([from, to]: [f64; 2]) -> f64 {
    let (width, middle) = (to - from, 0.5 * (from + to));
    if !(0.0..MOST_WIDTH).contains(&(width * (1.0 + middle.abs()))) {
        return share([from, to]);
    }
    normal::density(middle) * width * (1.0 + (middle * middle - 1.0) * width * width / 24.0)
}

/// The probability of a standard normal deviate between two others, from the side on which nothing cancels.
fn mass(from: f64, to: f64) -> f64 {
    share([from, to.min(f64::MAX)])
}

/// The integral over an interval from its first estimate, halved until the error is at most `tolerance` or rounding.
fn halved(
    integrand: &impl Fn(f64) -> [f64; 1],
    from: f64,
    to: f64,
    (value, error): (f64, f64),
    tolerance: f64,
    halvings: u32,
) -> (f64, f64) {
    if error <= tolerance || error <= ROUNDED * value || halvings == 0 {
        return (value, error);
    }
    let middle = 0.5 * (from + to);
    let halves = [(from, middle), (middle, to)].map(|(from, to)| {
        let ([value], [error]) = gauss_kronrod(integrand, from, to);
        halved(integrand, from, to, (value, error), tolerance, halvings - 1)
    });
    (halves[0].0 + halves[1].0, halves[0].1 + halves[1].1)
}

/// Where a function is least, by golden sections.
fn least_of(f: impl Fn(f64) -> f64, mut from: f64, mut to: f64) -> f64 {
    const RATIO: f64 = 0.618_033_988_749_894_9;
    let inner = |from: f64, to: f64| [to - RATIO * (to - from), from + RATIO * (to - from)];
    for _ in 0..50 {
        let [a, b] = inner(from, to);
        if f(a) < f(b) { to = b } else { from = a }
    }
    0.5 * (from + to)
}

#[cfg(test)]
mod tests;
