//! The probability of instability and its derivatives from a verdict map, by integration instead of sampling.
//!
//! With the deviates `z1` of the preload and `z2` of the static friction, a box of the map is a rectangle. Where it has
//! one verdict, its probability is a product of two differences of the normal distribution function. Where a
//! [`BoundaryCurve`] crosses it, the integral over the deviate of the curve's coordinate is
//!
//! ```text
//! integral of   phi(z) (Phi(t(z)) - Phi(t_low))   dz,   t(z) the curve in deviates, kept in the box,
//! ```
//!
//! for what is below the curve; likewise the moments of the deviates, which give the derivatives as in [`exact`].
//!
//! What the map does not tell becomes the distance of two limits: the gap that a curve leaves between two verdicts,
//! boxes that are not resolved, tiles that are not there, and samples that have neither verdict.
//!
//! [`exact`]: crate::integrate::closed_form

use crate::verdict_map::boundary_curve::{BoundaryCurve, Box2};
use crate::verdict_map::map::{Node, VerdictMap};
use stickslip_core::verdict::Verdict;

use crate::grid::Cell;
use crate::integrate::closed_form::{Derivatives, Moments, Moments1, integrate_pieces, moments_at, product};
use crate::special_functions::normal;

/// Deviates beyond this carry a probability below 2e-17.
const DEVIATE_LIMIT: f64 = 8.5;

/// Boxes with less probability are left out; they count as unknown.
const LEAST_MASS: f64 = 1e-18;

/// Subdivision ends when the error estimate of a piece falls below this share of the probability of its box; a map's
/// own resolution is far coarser.
const TOLERANCE: f64 = 1e-8;

/// Halvings of a piece at the most.
const DEEPEST: u32 = 30;

/// Intervals in which a curve is looked at for where it passes a value.
const INTERVALS: usize = 32;

/// A curve that passes more deviates of the other input than this is steep: the integral is then cut where it passes
/// those of [`STEEP_CUTS`], as a probability that passes from 0 to 1 between two abscissae would not be noticed.
const STEEP: f64 = 12.0;
const STEEP_CUTS: [f64; 5] = [-8.0, -4.0, 0.0, 4.0, 8.0];

/// A bound of the rounding errors that a box contributes: of its two factors and of the sum.
const ROUNDING: f64 = 2.0 * f64::EPSILON;

/// What a map says of the probability of instability of a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MappedProbability {
    /// The probability that a sample is unstable, given that it is known to the map to be stable or unstable;
    /// boundaries lie in the middle of what they leave open. `None` where nothing is known.
    pub value: Option<f64>,
    /// The probability is not below this, whatever the map does not tell.
    pub low: f64,
    /// Nor above this.
    pub high: f64,
    /// Derivatives of `value`; none where nothing is known.
    pub derivatives: Derivatives,
    /// Probability of the verdicts [`Verdict::Undecided`] and [`Verdict::Failed`].
    pub undecided: f64,
}

/// What `map` says of the probability of instability of `cell`, which has to be at the map's rotating speed.
///
/// For many cells, prepare the map once with [`MapRegions::new`].
#[must_use]
pub fn probability(map: &VerdictMap, cell: &Cell) -> MappedProbability {
    MapRegions::new(map).probability(cell)
}

/// The boxes of a map, prepared for integration over many cells.
#[derive(Debug, Clone)]
pub struct MapRegions {
    kinetic_coefficient: f64,
    /// Every coordinate where a box begins or ends, ascending: preload, falling friction.
    edges: [Vec<f64>; 2],
    boxes: Vec<Region>,
}

/// A box that tells something.
#[derive(Debug, Clone, Copy)]
struct Region {
    bounds: Box2,
    /// The places of its ends among the edges.
    ends: [[usize; 2]; 2],
    node: Node,
}

impl MapRegions {
    /// The boxes of `map`.
    #[must_use]
    pub fn new(map: &VerdictMap) -> Self {
        let known = |(_, node): &(Box2, Node)| matches!(node, Node::Uniform(_) | Node::Crossed(_));
        let boxes: Vec<(Box2, Node)> = map.tiles().flat_map(|(index, tile)| tile.boxes(index)).filter(known).collect();
        let edges = [0, 1].map(|axis| {
            let mut edges: Vec<f64> =
                boxes.iter().flat_map(|(bounds, _)| [bounds.low[axis], bounds.high[axis]]).collect();
            edges.sort_by(f64::total_cmp);
            edges.dedup();
            edges
        });
        let place = |axis: usize, coordinate: f64| edges[axis].partition_point(|&edge| edge < coordinate);
        let region = |(bounds, node): (Box2, Node)| {
            let ends = [0, 1].map(|axis| [place(axis, bounds.low[axis]), place(axis, bounds.high[axis])]);
            Region { bounds, ends, node }
        };
        let boxes = boxes.into_iter().map(region).collect();
        Self { kinetic_coefficient: map.kinetic_coefficient(), edges, boxes }
    }

    /// What the map says of the probability of instability of `cell`, which has to be at its rotating speed.
    #[must_use]
    pub fn probability(&self, cell: &Cell) -> MappedProbability {
        let std = cell.relative_std;
        let inputs = [
            // A preload of exactly 0 presses nothing together; it is outside physics, not where the first tiles begin.
            Input {
                expected: if cell.preload == 0.0 { -f64::MIN_POSITIVE } else { cell.preload },
                spread: cell.preload * std.preload,
            },
            Input {
                expected: cell.static_friction - self.kinetic_coefficient,
                spread: cell.static_friction * std.static_friction,
            },
        ];
        let edges = [0, 1].map(|axis| self.edges[axis].iter().map(|&edge| inputs[axis].edge(edge)).collect::<Vec<_>>());
        let mut sums = Sums::default();
        sums.add_outside_physics(&inputs);
        for Region { bounds, ends, node } in &self.boxes {
            let [preload, friction] = [0, 1].map(|axis| [edges[axis][ends[axis][0]], edges[axis][ends[axis][1]]]);
            // Without a product of moments: most boxes end here.
            if preload[0].mass_to(&preload[1]) * friction[0].mass_to(&friction[1]) < LEAST_MASS {
                continue;
            }
            let moments = product(&preload[0].moments_to(&preload[1]), &friction[0].moments_to(&friction[1]));
            match node {
                Node::Uniform(verdict) => {
                    sums.add(*verdict, &moments);
                    sums.add_certain(*verdict, moments[0]);
                }
                Node::Crossed(curve) => {
                    let crossed = Crossed { bounds, curve, inputs: &inputs, ends: &[preload, friction] };
                    sums.add_crossed(curve, &moments, &crossed.integrals());
                }
                Node::Cut(_) | Node::Unresolved => {}
            }
        }
        sums.probability(cell)
    }
}

/// A random input, as a coordinate of the plane.
#[derive(Debug, Clone, Copy)]
struct Input {
    expected: f64,
    /// Standard deviation; 0 for an input that does not scatter.
    spread: f64,
}

impl Input {
    fn scatters(&self) -> bool {
        self.spread != 0.0
    }

    /// The deviate at a coordinate.
    fn deviate(&self, coordinate: f64) -> f64 {
        // Zero times infinity is not zero.
        ((coordinate - self.expected) / self.spread).clamp(-40.0, 40.0)
    }

    fn coordinate(&self, deviate: f64) -> f64 {
        self.expected + self.spread * deviate
    }

    /// What is below a coordinate, and what is not.
    fn edge(&self, coordinate: f64) -> Edge {
        if !self.scatters() {
            // One point, which belongs to the box that begins with it.
            let above = self.expected >= coordinate;
            let (lower, upper) = if above { (0.0, 1.0) } else { (1.0, 0.0) };
            return Edge { deviate: lower - upper, lower, upper, first: 0.0, second: 0.0 };
        }
        let deviate = self.deviate(coordinate);
        let tail = normal::upper_tail(deviate.abs());
        let (lower, upper) = if deviate > 0.0 { (1.0 - tail, tail) } else { (tail, 1.0 - tail) };
        let density = normal::density(deviate);
        Edge { deviate, lower, upper, first: density, second: deviate * density }
    }
}

/// A place between two intervals of an input.
#[derive(Debug, Clone, Copy)]
struct Edge {
    deviate: f64,
    /// Probability below it.
    lower: f64,
    /// Probability above it.
    upper: f64,
    /// The integrals of `z` and of `z^2 - 1` above it: `phi(z)` and `z phi(z)`.
    first: f64,
    second: f64,
}

impl Edge {
    const START: Self = Self { deviate: -40.0, lower: 0.0, upper: 1.0, first: 0.0, second: 0.0 };
    const END: Self = Self { deviate: 40.0, lower: 1.0, upper: 0.0, first: 0.0, second: 0.0 };

    /// The probability between this edge and a higher one, from the tails that do not cancel.
    fn mass_to(&self, end: &Self) -> f64 {
        if self.deviate > 0.0 { self.upper - end.upper } else { end.lower - self.lower }
    }

    fn moments_to(&self, end: &Self) -> Moments1 {
        [self.mass_to(end), self.first - end.first, self.second - end.second]
    }
}

/// A box with a curve through it.
struct Crossed<'a> {
    bounds: &'a Box2,
    curve: &'a BoundaryCurve,
    inputs: &'a [Input; 2],
    ends: &'a [[Edge; 2]; 2],
}

/// Integrals over a box that a curve crosses: the moments below the curve's middle, the probability that is certainly
/// below it and the one that is certainly above it.
type CrossedIntegrals = [f64; 7];

impl Crossed<'_> {
    /// The integrals, and the numerical error of their probabilities.
    fn integrals(&self) -> (CrossedIntegrals, f64) {
        let over = self.curve.over;
        let (outer, inner) = (&self.inputs[over], &self.inputs[1 - over]);
        if !outer.scatters() {
            return (self.at(outer.expected, &[1.0, 0.0, 0.0]), 0.0);
        }
        let [start, end] = self.ends[over].map(|edge| edge.deviate.clamp(-DEVIATE_LIMIT, DEVIATE_LIMIT));
        let cuts = self.cuts(start, end);
        if inner.scatters() {
            let tolerance = TOLERANCE * self.ends.iter().map(|[start, end]| start.mass_to(end)).product::<f64>();
            let integrand = |z: f64| self.at(outer.coordinate(z), &moments_at(z));
            let (integrals, errors) = integrate_pieces(&integrand, &cuts, tolerance, DEEPEST);
            return (integrals, errors[0].max(errors[5]).max(errors[6]));
        }
        // Between two cuts the one value of the other input is on one side.
        let mut integrals = [0.0; 7];
        for pair in cuts.windows(2) {
            let [from, to] = [pair[0], pair[1]].map(|z| outer.edge(outer.coordinate(z)));
            let piece = self.at(outer.coordinate(0.5 * (pair[0] + pair[1])), &from.moments_to(&to));
            (0..7).for_each(|i| integrals[i] += piece[i]);
        }
        (integrals, 0.0)
    }

    /// The integrals over the other input at one coordinate, times the moments `outer` of this one.
    fn at(&self, coordinate: f64, outer: &Moments1) -> CrossedIntegrals {
        let across = 1 - self.curve.over;
        let inner = &self.inputs[across];
        let [start, end] = &self.ends[across];
        let edge = |value: f64| inner.edge(value.clamp(self.bounds.low[across], self.bounds.high[across]));
        let (low, high) = self.curve.gap(self.bounds, coordinate);
        let below = start.moments_to(&edge(0.5 * (low + high)));
        let moments = if across == 1 { product(outer, &below) } else { product(&below, outer) };
        let certainly_below = outer[0] * start.mass_to(&edge(low));
        let certainly_above = outer[0] * edge(high).mass_to(end);
        let mut integrals = [0.0; 7];
        integrals[..5].copy_from_slice(&moments);
        integrals[5..].copy_from_slice(&[certainly_below, certainly_above]);
        integrals
    }

    /// The deviates from `start` to `end` where the integrand has kinks or steps, both ends included, ascending.
    fn cuts(&self, start: f64, end: f64) -> Vec<f64> {
        let across = 1 - self.curve.over;
        let (outer, inner) = (&self.inputs[self.curve.over], &self.inputs[across]);
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
            // Beyond the limit there is no kink to be seen.
            for edge in [self.bounds.low[across], self.bounds.high[across]] {
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

/// Where `holds` ceases to hold between `from` and `to`, by bisection.
fn crossing(holds: impl Fn(f64) -> bool, mut from: f64, mut to: f64) -> f64 {
    for _ in 0..48 {
        let middle = 0.5 * (from + to);
        if holds(middle) { from = middle } else { to = middle }
    }
    0.5 * (from + to)
}

/// What is known of a cell.
#[derive(Debug, Default)]
struct Sums {
    stable: Moments,
    unstable: Moments,
    undecided: f64,
    certainly_stable: f64,
    certainly_unstable: f64,
    error: f64,
}

impl Sums {
    /// Samples outside physics are stable by definition.
    fn add_outside_physics(&mut self, [preload, friction]: &[Input; 2]) {
        const WHOLE: Moments1 = [1.0, 0.0, 0.0];
        let zero = preload.edge(0.0);
        let regions = [
            product(&Edge::START.moments_to(&zero), &WHOLE),
            product(&zero.moments_to(&Edge::END), &Edge::START.moments_to(&friction.edge(0.0))),
        ];
        for moments in regions {
            self.add(Verdict::Stable, &moments);
            self.add_certain(Verdict::Stable, moments[0]);
        }
    }

    fn add(&mut self, verdict: Verdict, moments: &Moments) {
        match verdict {
            Verdict::Stable => (0..5).for_each(|i| self.stable[i] += moments[i]),
            Verdict::Unstable => (0..5).for_each(|i| self.unstable[i] += moments[i]),
            Verdict::Undecided | Verdict::Failed => self.undecided += moments[0],
        }
    }

    fn add_certain(&mut self, verdict: Verdict, mass: f64) {
        self.error += ROUNDING;
        match verdict {
            Verdict::Stable => self.certainly_stable += mass,
            Verdict::Unstable => self.certainly_unstable += mass,
            Verdict::Undecided | Verdict::Failed => {}
        }
    }

    /// Adds a box with the moments `whole`.
    fn add_crossed(&mut self, curve: &BoundaryCurve, whole: &Moments, (crossed, error): &(CrossedIntegrals, f64)) {
        let below: Moments = std::array::from_fn(|i| crossed[i]);
        self.add(curve.below, &below);
        self.add(curve.above, &std::array::from_fn(|i| whole[i] - below[i]));
        self.add_certain(curve.below, crossed[5]);
        self.add_certain(curve.above, crossed[6]);
        self.error += error;
    }

    fn probability(&self, cell: &Cell) -> MappedProbability {
        let low = (self.certainly_unstable - self.error).clamp(0.0, 1.0);
        let high = (1.0 - self.certainly_stable + self.error).clamp(0.0, 1.0);
        let (stable, unstable) = (self.stable[0], self.unstable[0]);
        let decided = stable + unstable;
        let undecided = self.undecided.clamp(0.0, 1.0);
        if decided < LEAST_MASS {
            return MappedProbability { value: None, low, high, derivatives: Derivatives::default(), undecided };
        }
        // The quotient rule: what is known depends on the cell too.
        let quotient = |i: usize| (self.unstable[i] * stable - unstable * self.stable[i]) / (decided * decided);
        let derivatives = Derivatives::of(cell, &std::array::from_fn(quotient));
        let value = Some((unstable / decided).clamp(low, high));
        MappedProbability { value, low, high, derivatives, undecided }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::RelativeStd;
    use crate::integrate::closed_form;
    use crate::verdict_map::map::{Tile, TileIndex};
    use proptest::prelude::*;
    use std::sync::LazyLock;
    use stickslip_core::parameters::Parameters;
    use stickslip_core::rigid_disc::pad_on_disc::PadOnDisc;
    use stickslip_core::rigid_disc::stability::StabilityBoundary;

    const KINETIC: f64 = 0.25;

    fn cell(preload: f64, static_friction: f64, preload_std: f64, friction_std: f64) -> Cell {
        let relative_std = RelativeStd { preload: preload_std, static_friction: friction_std };
        Cell { index: 0, rotating_speed: 15.0, relative_std, preload, static_friction }
    }

    /// A map of the tiles up to 2 for which `has` holds.
    fn map_of(judge: impl Fn(f64, f64) -> Verdict, has: impl Fn(TileIndex) -> bool) -> VerdictMap {
        let mut map = VerdictMap::new(KINETIC);
        for index in (0..12).flat_map(|row| (0..12).map(move |column| TileIndex { column, row })) {
            if has(index) {
                let verdicts = |points: &[[f64; 2]]| points.iter().map(|[x, y]| judge(*x, *y)).collect();
                map.insert(index, Tile::resolve(index, verdicts));
            }
        }
        map
    }

    fn boundary() -> StabilityBoundary {
        let mut parameters = Parameters::sui_ding_2018();
        parameters.set("operating_point.rotating_speed", 15.0).unwrap();
        let boundary = PadOnDisc::new(parameters).unwrap().stability_boundary();
        assert_eq!(boundary.kinetic_coefficient(), KINETIC);
        boundary
    }

    fn hyperbola_map() -> VerdictMap {
        let boundary = boundary();
        map_of(|x, y| boundary.verdict(x, y + KINETIC), |_| true)
    }

    fn as_array(derivatives: Derivatives) -> [Option<f64>; 4] {
        let Derivatives { preload, static_friction, std_preload, std_static_friction } = derivatives;
        [preload, static_friction, std_preload, std_static_friction]
    }

    /// Probabilities of stable, unstable and other verdicts, and the integrals of the scores over what is unstable: a
    /// plain midpoint rule over both deviates, outside physics being stable.
    fn by_midpoints(judge: impl Fn(f64, f64) -> Verdict, cell: &Cell) -> ([f64; 3], [f64; 4]) {
        let Cell { relative_std: std, preload, static_friction, .. } = *cell;
        let deviates = |std: f64| -> Vec<(f64, f64)> {
            if std == 0.0 {
                return vec![(0.0, 1.0)];
            }
            let points = 4000;
            let step = 15.0 / f64::from(points);
            (0..points)
                .map(|i| -7.5 + step * (f64::from(i) + 0.5))
                .map(|z| (z, step * (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt()))
                .collect()
        };
        let frictions = deviates(std.static_friction);
        let (mut masses, mut scores) = ([0.0; 3], [0.0; 4]);
        for (z1, weight1) in deviates(std.preload) {
            let x = preload * (1.0 + std.preload * z1);
            for &(z2, weight2) in &frictions {
                let y = static_friction * (1.0 + std.static_friction * z2) - KINETIC;
                let weight = weight1 * weight2;
                match if x <= 0.0 || y < 0.0 { Verdict::Stable } else { judge(x, y) } {
                    Verdict::Stable => masses[0] += weight,
                    Verdict::Unstable => {
                        masses[1] += weight;
                        scores[0] += weight * (z1 + std.preload * (z1 * z1 - 1.0)) / (preload * std.preload);
                        scores[1] += weight * (z2 + std.static_friction * (z2 * z2 - 1.0))
                            / (static_friction * std.static_friction);
                        scores[2] += weight * (z1 * z1 - 1.0) / std.preload;
                        scores[3] += weight * (z2 * z2 - 1.0) / std.static_friction;
                    }
                    Verdict::Undecided | Verdict::Failed => masses[2] += weight,
                }
            }
        }
        (masses, scores)
    }

    #[test]
    fn a_hyperbola_has_its_exact_probability_and_derivatives() {
        let (boundary, map) = (boundary(), hyperbola_map());
        let regions = MapRegions::new(&map);
        let mut unstable = 0;
        for preload in [0.01, 0.05, 0.1, 0.2, 0.3] {
            for friction in [0.25, 0.3, 0.39, 0.5] {
                for (preload_std, friction_std) in [
                    (0.2, 0.2),
                    (0.3, 0.05),
                    (0.02, 0.3),
                    (0.1, 1e-4),
                    (1e-4, 0.1),
                    (1e-3, 1e-3),
                    (0.2, 0.0),
                    (0.0, 0.2),
                ] {
                    let cell = cell(preload, friction, preload_std, friction_std);
                    let exact = closed_form::probability(&boundary, &cell);
                    let mapped = regions.probability(&cell);
                    assert!(mapped.low <= exact.value && exact.value <= mapped.high, "{cell:?}: {exact:?} {mapped:?}");
                    assert!((mapped.value.unwrap() - exact.value).abs() < 1e-5, "{cell:?}: {exact:?} {mapped:?}");
                    assert!(mapped.low <= mapped.value.unwrap() && mapped.value.unwrap() <= mapped.high, "{mapped:?}");
                    assert_eq!(mapped.undecided, 0.0);
                    unstable += u32::from(exact.value > 0.01 && exact.value < 0.99);
                    let derivatives = closed_form::derivatives(&boundary, &cell);
                    for (i, (mapped, exact)) in
                        as_array(mapped.derivatives).into_iter().zip(as_array(derivatives)).enumerate()
                    {
                        assert_eq!(mapped.is_some(), [preload_std, friction_std][i % 2] > 0.0);
                        let (Some(mapped), Some(exact)) = (mapped, exact) else { continue };
                        let scale = [preload * preload_std, friction * friction_std, preload_std, friction_std][i];
                        // In units of the scatter; where it is tiny against the map's resolution (4e-6 of the
                        // coordinate, 0.04 for a standard deviation of 1e-4) the boundary's place in it is only known to that.
                        let resolution = 1e-5 + 4e-6 / preload_std.max(friction_std).max(1e-9);
                        let error = (mapped - exact).abs() * scale;
                        assert!(error < resolution.max(1e-4 * exact.abs() * scale), "{cell:?} {i}: {mapped} {exact}");
                    }
                }
            }
        }
        assert!(unstable > 40, "{unstable}");
    }

    #[test]
    fn derivatives_are_accurate_to_a_ten_thousandth() {
        let (boundary, map) = (boundary(), hyperbola_map());
        for cell in [cell(0.1, 0.39, 0.2, 0.2), cell(0.05, 0.45, 0.3, 0.1), cell(0.2, 0.32, 0.1, 0.05)] {
            let mapped = probability(&map, &cell);
            assert!(mapped.high - mapped.low < 2e-4, "{mapped:?}");
            let exact = closed_form::derivatives(&boundary, &cell);
            for (mapped, exact) in as_array(mapped.derivatives).into_iter().zip(as_array(exact)) {
                let (mapped, exact) = (mapped.unwrap(), exact.unwrap());
                assert!((mapped - exact).abs() < 1e-4 * exact.abs().max(0.1), "{cell:?}: {mapped} {exact}");
            }
        }
    }

    #[test]
    fn tiny_scatter_around_the_boundary_is_within_the_limits() {
        let (boundary, map) = (boundary(), hyperbola_map());
        for std in [1e-2, 1e-3, 1e-4, 1e-5] {
            for shift in [-3.0, -1.0, 0.0, 0.5, 2.0] {
                for (preload_std, friction_std) in [(std, std), (std, 0.0), (0.0, std), (0.1, std), (std, 0.1)] {
                    let friction = boundary.critical_static_friction(0.1) * (1.0 + shift * std);
                    let cell = cell(0.1, friction, preload_std, friction_std);
                    let exact = closed_form::probability(&boundary, &cell).value;
                    let mapped = probability(&map, &cell);
                    assert!(mapped.low <= exact && exact <= mapped.high, "{cell:?}: {exact} {mapped:?}");
                    assert!(mapped.high - mapped.low < 3e-5 / std + 1e-5, "{cell:?}: {mapped:?}");
                }
            }
        }
    }

    #[test]
    fn a_step_beside_the_end_of_a_box_is_seen() {
        // The preload scatters widely, the friction hardly: the conditional probability passes from 0 to 1 within less
        // than the distance of the outermost abscissa from the end of the tile at 1/8.
        let (boundary, map) = (boundary(), hyperbola_map());
        for distance in [-2e-4, -1e-4, -3e-5, 3e-5, 1e-4, 2e-4] {
            let friction = boundary.critical_static_friction(0.125 + distance);
            for friction_std in [1e-4, 1e-5, 1e-6] {
                let cell = cell(0.125, friction, 0.1, friction_std);
                let exact = closed_form::probability(&boundary, &cell).value;
                let mapped = probability(&map, &cell);
                assert!(mapped.low <= exact && exact <= mapped.high, "{distance} {cell:?}: {exact} {mapped:?}");
                assert!(mapped.high - mapped.low < 2e-3, "{mapped:?}");
            }
        }
    }

    /// A boundary with a corner, a second branch, a hole and an island.
    fn branches(x: f64, y: f64) -> Verdict {
        let first = x * y > 0.02 && y > 0.11 - 0.05 * x;
        let lens = (x - 0.6).powi(2) + (2.0 * (y - 0.05)).powi(2) < 0.0025;
        let gap = (x - 0.5).powi(2) + (y - 0.7).powi(2) < 0.01;
        let slot = x < 0.1 && y > 0.6;
        if (first || lens) && !gap && !slot { Verdict::Unstable } else { Verdict::Stable }
    }

    #[test]
    fn corners_branches_and_islands_agree_with_midpoints() {
        let map = map_of(branches, |_| true);
        for cell in [
            cell(0.2, 0.35, 0.3, 0.2),
            cell(0.6, 0.3, 0.1, 0.1),
            cell(0.5, 0.95, 0.2, 0.1),
            cell(0.1, 0.85, 0.1, 0.02),
            cell(0.6, 0.3, 0.1, 0.0),
            cell(0.5, 0.95, 0.0, 0.1),
        ] {
            let mapped = probability(&map, &cell);
            let (masses, scores) = by_midpoints(branches, &cell);
            let one_scatters = cell.relative_std.preload * cell.relative_std.static_friction == 0.0;
            // The rule misplaces a boundary across one line of its points by up to half a step.
            let tolerance = if one_scatters { 4e-3 } else { 5e-5 };
            assert!((mapped.value.unwrap() - masses[1]).abs() < tolerance, "{cell:?}: {mapped:?} {masses:?}");
            assert!(mapped.low - tolerance < masses[1] && masses[1] < mapped.high + tolerance, "{cell:?}: {mapped:?}");
            assert!(mapped.high - mapped.low < 1e-3, "{mapped:?}");
            for (derivative, score) in as_array(mapped.derivatives).into_iter().zip(scores) {
                let Some(derivative) = derivative else { continue };
                assert!(
                    (derivative - score).abs() < 20.0 * tolerance * score.abs().max(1.0),
                    "{cell:?}: {derivative} {score}"
                );
            }
        }
    }

    #[test]
    fn undecided_samples_are_doubt_and_no_part_of_the_value() {
        let judge = |x: f64, y: f64| match x * y {
            product if product > 0.05 => Verdict::Unstable,
            product if product > 0.03 => Verdict::Undecided,
            product if product > 0.025 => Verdict::Failed,
            _ => Verdict::Stable,
        };
        let map = map_of(judge, |_| true);
        for cell in [cell(0.2, 0.45, 0.2, 0.1), cell(0.3, 0.4, 0.1, 0.1)] {
            let mapped = probability(&map, &cell);
            let ([stable, unstable, other], _) = by_midpoints(judge, &cell);
            assert!(other > 0.1 && unstable > 0.05);
            assert!((mapped.undecided - other).abs() < 3e-5, "{mapped:?} {other}");
            assert!((mapped.value.unwrap() - unstable / (stable + unstable)).abs() < 5e-5, "{mapped:?}");
            assert!((mapped.low - unstable).abs() < 1e-4 && (mapped.high - 1.0 + stable).abs() < 1e-4, "{mapped:?}");
            // The quotient's derivatives, by differences of the value.
            let value = |cell: &Cell| probability(&map, cell).value.unwrap();
            let (mut up, mut down) = (cell, cell);
            up.preload *= 1.005;
            down.preload *= 0.995;
            let by_preload = (value(&up) - value(&down)) / (0.01 * cell.preload);
            assert!((mapped.derivatives.preload.unwrap() / by_preload - 1.0).abs() < 2e-3, "{mapped:?} {by_preload}");
            up.preload = cell.preload;
            down.preload = cell.preload;
            up.relative_std.static_friction *= 1.01;
            down.relative_std.static_friction *= 0.99;
            let by_std = (value(&up) - value(&down)) / (0.02 * cell.relative_std.static_friction);
            let mapped = mapped.derivatives.std_static_friction.unwrap();
            assert!((mapped - by_std).abs() < 3e-3 * by_std.abs().max(0.1), "{mapped} {by_std}");
        }
    }

    #[test]
    fn missing_tiles_widen_the_limits_by_their_probability() {
        let whole = hyperbola_map();
        let boundary = boundary();
        // Two tiles, one on each side of the boundary: preload 1/8 to 1/4, falling friction 1/4 to 3/8 and 0 to 1/8.
        let is_missing = |index: TileIndex| index.column == 1 && (index.row == 2 || index.row == 0);
        let map = map_of(|x, y| boundary.verdict(x, y + KINETIC), |index| !is_missing(index));
        let cell = cell(0.15, 0.45, 0.3, 0.3);
        let (whole, part) = (probability(&whole, &cell), probability(&map, &cell));
        let mass = |from: f64, to: f64, expected: f64, std: f64| {
            normal::cumulative((to - expected) / std) - normal::cumulative((from - expected) / std)
        };
        let missing = mass(0.125, 0.25, 0.15, 0.045) * (mass(0.5, 0.625, 0.45, 0.135) + mass(0.25, 0.375, 0.45, 0.135));
        let widened = (part.high - part.low) - (whole.high - whole.low);
        // The crossed boxes of the missing tiles had doubts of their own, now part of what is missing.
        assert!((widened - missing).abs() < 2e-5 && missing > 0.1, "{widened} {missing}");
        assert!(part.low < whole.low && whole.high < part.high && part.value != whole.value);
        // A tile all of which is unstable had none.
        let map = map_of(|x, y| boundary.verdict(x, y + KINETIC), |index| index != TileIndex { column: 1, row: 2 });
        let part = probability(&map, &cell);
        let missing = mass(0.125, 0.25, 0.15, 0.045) * mass(0.5, 0.625, 0.45, 0.135);
        assert!((whole.low - part.low - missing).abs() < 1e-13 && (whole.high - part.high).abs() < 1e-13, "{part:?}");
    }

    #[test]
    fn without_tiles_only_outside_physics_is_known() {
        let map = VerdictMap::new(KINETIC);
        let mapped = probability(&map, &cell(0.1, 0.3, 0.5, 0.2));
        let inside = normal::upper_tail(-2.0) * normal::upper_tail(-0.05 / 0.06);
        assert!((mapped.high - inside).abs() < 2e-14 && mapped.low == 0.0 && mapped.value == Some(0.0), "{mapped:?}");
        let nothing = probability(&map, &cell(0.1, 0.3, 0.0, 0.0));
        assert_eq!((nothing.low, nothing.value, nothing.high), (0.0, None, 1.0));
        assert_eq!(nothing.derivatives, Derivatives::default());
    }

    #[test]
    fn without_scatter_the_probability_is_the_verdict() {
        let (boundary, map) = (boundary(), hyperbola_map());
        // A preload on the edge of a tile, and one that is nothing.
        for preload in [0.0, 0.05, 0.125, 0.3] {
            for friction in [0.2, 0.25, 0.375, 0.3, 0.5, 0.75] {
                let mapped = probability(&map, &cell(preload, friction, 0.0, 0.0));
                let expected = f64::from(u8::from(boundary.verdict(preload, friction) == Verdict::Unstable));
                assert_eq!(mapped.value, Some(expected), "{preload} {friction}: {mapped:?}");
                assert!((mapped.high - mapped.low) < 1e-13, "{preload} {friction}: {mapped:?}");
            }
        }
        let on_boundary = probability(&map, &cell(0.1, boundary.critical_static_friction(0.1), 0.0, 0.0));
        assert_eq!((on_boundary.low, on_boundary.high), (0.0, 1.0));
        // A preload of 0 is outside physics, whatever the tiles that begin there say.
        let unstable = map_of(|_, _| Verdict::Unstable, |_| true);
        for std in [0.0, 0.2] {
            let nothing_pressed = probability(&unstable, &cell(0.0, 0.5, std, 0.2));
            assert!(nothing_pressed.value == Some(0.0) && nothing_pressed.high < 1e-14, "{nothing_pressed:?}");
        }
    }

    static HYPERBOLA: LazyLock<MapRegions> = LazyLock::new(|| MapRegions::new(&hyperbola_map()));

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4000))]

        #[test]
        fn the_exact_probability_is_within_the_limits(
            preload in 0.005..0.6,
            friction in 0.2..0.9,
            preload_std in -11.0..-0.7,
            friction_std in -11.0..-0.7,
        ) {
            let cell = cell(preload, friction, libm::exp(preload_std), libm::exp(friction_std));
            let exact = closed_form::probability(&boundary(), &cell);
            let mapped = HYPERBOLA.probability(&cell);
            prop_assert!(mapped.low - exact.error_bound <= exact.value, "{:?} {:?}", exact, mapped);
            prop_assert!(exact.value <= mapped.high + exact.error_bound, "{:?} {:?}", exact, mapped);
            prop_assert!(mapped.low <= mapped.value.unwrap() && mapped.value.unwrap() <= mapped.high, "{:?}", mapped);
        }
    }
}
