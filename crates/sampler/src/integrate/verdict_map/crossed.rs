//! Integrals over a box that a boundary crosses.

use crate::integrate::derivatives::{DeviateMoments, moments_at, product};
use crate::integrate::quadrature::integrate_intervals;
use crate::integrate::verdict_map::input::{Edge, Input};
use crate::verdict_map::boundary_curve::{BoundaryCurve, Box2};

/// Deviates beyond this carry a probability below 2e-17.
const DEVIATE_LIMIT: f64 = 8.5;

/// Tolerance of each interval of integration, relative to the probability of its box; the resolution of a map is far
/// coarser.
const TOLERANCE: f64 = 1e-8;

/// Most halvings of an interval.
const DEEPEST: u32 = 30;

/// Intervals in which to look for the abscissae where a curve passes a value.
const INTERVALS: usize = 32;

/// A curve whose ordinates extend over more deviates than this is steep.
const STEEP: f64 = 12.0;

/// The integral below a steep curve is divided where the curve is at these deviates: a probability that rises from 0 to
/// 1 between two abscissae would be missed.
const STEEP_CUTS: [f64; 5] = [-8.0, -4.0, 0.0, 4.0, 8.0];

/// A box with a curve through it.
pub(super) struct Crossed<'a> {
    pub(super) bounds: &'a Box2,
    pub(super) curve: &'a BoundaryCurve,
    pub(super) inputs: &'a [Input; 2],
    pub(super) ends: &'a [[Edge; 2]; 2],
}

/// Integrals over a box that a curve crosses: the five moments below the middle of its gap, and the probabilities below
/// and above the gap.
pub(super) type CrossedIntegrals = [f64; 7];

impl Crossed<'_> {
    /// The integrals, and the numerical error of their probabilities.
    pub(super) fn integrals(&self) -> (CrossedIntegrals, f64) {
        let abscissa = self.curve.abscissa;
        let (outer, inner) = (&self.inputs[abscissa], &self.inputs[1 - abscissa]);
        if !outer.scatters() {
            return (self.at(outer.expected, &[1.0, 0.0, 0.0]), 0.0);
        }
        let [start, end] = self.ends[abscissa].map(|edge| edge.deviate.clamp(-DEVIATE_LIMIT, DEVIATE_LIMIT));
        let cuts = self.cuts(start, end);
        if inner.scatters() {
            let tolerance = TOLERANCE * self.ends.iter().map(|[start, end]| start.mass_to(end)).product::<f64>();
            let integrand = |z: f64| self.at(outer.coordinate(z), &moments_at(z));
            let (integrals, errors) = integrate_intervals(&integrand, &cuts, tolerance, DEEPEST);
            return (integrals, errors[0].max(errors[5]).max(errors[6]));
        }
        // Between two cuts the single ordinate is on one side of the curve.
        let mut integrals = [0.0; 7];
        for pair in cuts.windows(2) {
            let [from, to] = [pair[0], pair[1]].map(|z| outer.edge(outer.coordinate(z)));
            let interval = self.at(outer.coordinate(0.5 * (pair[0] + pair[1])), &from.moments_to(&to));
            (0..7).for_each(|i| integrals[i] += interval[i]);
        }
        (integrals, 0.0)
    }

    /// The integrals over the ordinate at one abscissa, times the moments `outer` of the abscissa.
    fn at(&self, coordinate: f64, outer: &DeviateMoments) -> CrossedIntegrals {
        let ordinate = 1 - self.curve.abscissa;
        let inner = &self.inputs[ordinate];
        let [start, end] = &self.ends[ordinate];
        let edge = |value: f64| inner.edge(value.clamp(self.bounds.low[ordinate], self.bounds.high[ordinate]));
        let (low, high) = self.curve.gap(self.bounds, coordinate);
        let below = start.moments_to(&edge(0.5 * (low + high)));
        let moments = if ordinate == 1 { product(outer, &below) } else { product(&below, outer) };
        let below_gap = outer[0] * start.mass_to(&edge(low));
        let above_gap = outer[0] * edge(high).mass_to(end);
        let mut integrals = [0.0; 7];
        integrals[..5].copy_from_slice(&moments);
        integrals[5..].copy_from_slice(&[below_gap, above_gap]);
        integrals
    }

    /// The deviates from `start` to `end` where the integrand has kinks or steps, both ends included, ascending.
    fn cuts(&self, start: f64, end: f64) -> Vec<f64> {
        let ordinate = 1 - self.curve.abscissa;
        let (outer, inner) = (&self.inputs[self.curve.abscissa], &self.inputs[ordinate]);
        let graphs = |z: f64| {
            let (low, high) = self.curve.gap(self.bounds, outer.coordinate(z));
            [low, 0.5 * (low + high), high]
        };
        let deviate = |i: usize| start + (end - start) * (i as f64 / INTERVALS as f64);
        let values: [[f64; 3]; INTERVALS + 1] = std::array::from_fn(|i| graphs(deviate(i)));
        let mut cuts = vec![start, end];
        let mut cut = |graph: usize, level: f64| {
            for i in 0..INTERVALS {
                let is_above = values[i][graph] > level;
                if (values[i + 1][graph] > level) != is_above {
                    cuts.push(crossing(|z| (graphs(z)[graph] > level) == is_above, deviate(i), deviate(i + 1)));
                }
            }
        };
        if inner.scatters() {
            // Beyond the limit a kink has no effect.
            for edge in [self.bounds.low[ordinate], self.bounds.high[ordinate]] {
                if inner.deviate(edge).abs() < DEVIATE_LIMIT {
                    (0..3).for_each(|graph| cut(graph, edge));
                }
            }
            let deviates = values.map(|[_, middle, _]| inner.deviate(middle));
            let (least, most) = deviates.iter().fold((f64::MAX, f64::MIN), |(a, b), &z| (a.min(z), b.max(z)));
            if most - least > STEEP {
                for z in STEEP_CUTS {
                    (0..3).for_each(|graph| cut(graph, inner.coordinate(z)));
                }
            }
        } else {
            (0..3).for_each(|graph| cut(graph, inner.expected));
        }
        cuts.sort_by(f64::total_cmp);
        cuts
    }
}

/// Where `holds` ceases to be true between `from` and `to`, by bisection.
fn crossing(holds: impl Fn(f64) -> bool, mut from: f64, mut to: f64) -> f64 {
    for _ in 0..48 {
        let middle = 0.5 * (from + to);
        if holds(middle) { from = middle } else { to = middle }
    }
    0.5 * (from + to)
}
