//! Finds a segment of a boundary by asking for verdicts.
//!
//! Verdicts are all that is known, so a point of the boundary is located by bisection, to a few millionths of its
//! coordinate, at eight Chebyshev nodes. The polynomial through these points is then checked at nine more abscissae,
//! between and beside the nodes, where its error is largest. A boundary fails the check if it bends too much for the
//! polynomial, has a corner, or does not cross the whole box; the caller then divides the box and tries again. A
//! boundary that is ragged on a small scale (where the rules of a verdict count cycles, for example) passes with a
//! wider guard.
//!
//! A verdict of a third kind may lie between the two. An answer of one of the two verdicts beyond one of the third kind
//! contradicts the assumption that the boundary is a graph, and ends the search.

use stickslip_core::model::verdict::Verdict;

use crate::verdict_map::boundary_curve::{BoundaryCurve, Box2, NODES, Point};

/// Points are located to this share of their coordinate, ...
const TOLERANCE: f64 = 4e-6;

/// ... which is taken to be at least this.
const LEAST_COORDINATE: f64 = 1e-3;

/// The guard of a curve, in tolerances: interpolation at Chebyshev nodes may double the errors at the nodes.
const GUARD: f64 = 2.0;

/// How far beyond the box a boundary is looked for, in sides of the box.
const REACH: f64 = 2.0;

/// The cosine of `pi k / (2 NODES)`.
fn cosine(k: usize) -> f64 {
    libm::cos(std::f64::consts::PI * k as f64 / (2 * NODES) as f64)
}

/// The Chebyshev coefficients of the polynomial through the values at the nodes.
fn coefficients(values: &[f64; NODES]) -> [f64; NODES] {
    std::array::from_fn(|j| {
        let sum: f64 = (0..NODES).map(|k| values[k] * cosine(j * (2 * k + 1) % (4 * NODES))).sum();
        sum * if j == 0 { 1.0 } else { 2.0 } / NODES as f64
    })
}

/// The search for a segment.
#[derive(Debug, Clone)]
pub(crate) struct Search {
    within: Box2,
    abscissa: usize,
    below: Verdict,
    above: Verdict,
    nodes: [Bracket; NODES],
    is_contradicted: bool,
}

/// The bracket of the bisection at one node: the verdict is `below` up to `below_at` and `above` from `above_at`.
/// `third` is the range of ordinates that are known to have neither verdict, if there are any.
#[derive(Debug, Clone, Copy)]
struct Bracket {
    coordinate: f64,
    below_at: f64,
    above_at: f64,
    third: Option<(f64, f64)>,
}

impl Bracket {
    /// The ordinate to ask for next: on the lower side until that is narrow enough, then on the upper one.
    fn next(&self) -> Option<f64> {
        let tolerance = TOLERANCE * self.above_at.abs().max(LEAST_COORDINATE);
        let intervals = match self.third {
            None => [(self.below_at, self.above_at); 2],
            Some((from, to)) => [(self.below_at, from), (to, self.above_at)],
        };
        intervals.into_iter().find(|(from, to)| to - from > tolerance).map(|(from, to)| 0.5 * (from + to))
    }

    /// Records an answer. Returns whether it agrees with the earlier ones: no `below` lies above an ordinate that has
    /// neither verdict, and no `above` below one.
    fn record(&mut self, at: f64, verdict: Verdict, below: Verdict, above: Verdict) -> bool {
        if verdict == below {
            self.below_at = at;
            self.third.is_none_or(|(from, _)| at < from)
        } else if verdict == above {
            self.above_at = at;
            self.third.is_none_or(|(_, to)| at > to)
        } else {
            self.third = Some(self.third.map_or((at, at), |(from, to)| (from.min(at), to.max(at))));
            true
        }
    }
}

impl Search {
    /// The search for a boundary between `below` and `above`; `expected` gives the ordinates between which it should
    /// lie at an abscissa.
    pub fn new(
        within: Box2,
        abscissa: usize,
        (below, above): (Verdict, Verdict),
        expected: impl Fn(f64) -> (f64, f64),
    ) -> Self {
        let nodes = std::array::from_fn(|k| {
            let coordinate = at(&within, abscissa, cosine(2 * k + 1));
            let (below_at, above_at) = expected(coordinate);
            Bracket { coordinate, below_at, above_at, third: None }
        });
        Self { within, abscissa, below, above, nodes, is_contradicted: false }
    }

    /// Widens the brackets: the boundary was not where it was expected.
    pub fn widen(&mut self) {
        let ordinate = 1 - self.abscissa;
        let reach = REACH * (self.within.high[ordinate] - self.within.low[ordinate]);
        for node in &mut self.nodes {
            node.below_at = self.within.low[ordinate] - reach;
            node.above_at = self.within.high[ordinate] + reach;
        }
    }

    fn point(&self, coordinate: f64, value: f64) -> Point {
        if self.abscissa == 0 { [coordinate, value] } else { [value, coordinate] }
    }

    /// The ends of the brackets: their verdicts show whether a boundary lies between them.
    pub fn ends(&self) -> Vec<Point> {
        let ends = |node: &Bracket| [node.below_at, node.above_at].map(|value| self.point(node.coordinate, value));
        self.nodes.iter().flat_map(ends).collect()
    }

    /// Whether the verdicts at pairs of points, as [`Search::ends`] and [`Search::curve`] return them, are `below` and
    /// `above`.
    pub fn accepts(&self, verdicts: &[Verdict]) -> bool {
        verdicts.chunks_exact(2).all(|pair| pair == [self.below, self.above])
    }

    /// Whether an answer contradicted an earlier one: the boundary is not a graph, and the search has ended.
    pub fn is_contradicted(&self) -> bool {
        self.is_contradicted
    }

    /// The points to ask for next; none when every node is located or an answer was contradictory.
    pub fn questions(&self) -> Vec<Point> {
        if self.is_contradicted {
            return Vec::new();
        }
        self.nodes.iter().filter_map(|node| Some(self.point(node.coordinate, node.next()?))).collect()
    }

    /// Records the verdicts at the points of [`Search::questions`].
    pub fn record(&mut self, verdicts: &[Verdict]) {
        let mut answers = verdicts.iter();
        for node in &mut self.nodes {
            if let Some(value) = node.next()
                && let Some(&verdict) = answers.next()
                && !node.record(value, verdict, self.below, self.above)
            {
                self.is_contradicted = true;
            }
        }
    }

    /// The polynomials through the located nodes, with `factor` times the guard that a smooth boundary needs, and the
    /// points at which to check them: `below` and `above` in turn.
    pub fn curve(&self, factor: f64) -> (BoundaryCurve, Vec<Point>) {
        let largest = self.nodes.iter().map(|node| node.above_at.abs()).fold(LEAST_COORDINATE, f64::max);
        let curve = BoundaryCurve {
            abscissa: self.abscissa,
            below: self.below,
            above: self.above,
            lower: coefficients(&self.nodes.map(|node| node.below_at)),
            upper: coefficients(&self.nodes.map(|node| node.above_at)),
            guard: factor * GUARD * TOLERANCE * largest,
        };
        let checks = (0..=NODES).flat_map(|k| {
            let coordinate = at(&self.within, self.abscissa, cosine(2 * k));
            let (low, high) = curve.gap(&self.within, coordinate);
            [self.point(coordinate, low), self.point(coordinate, high)]
        });
        (curve, checks.collect())
    }
}

/// The coordinate at `t` from -1 to 1 across the box: the inverse of the scaling of a curve.
fn at(within: &Box2, axis: usize, t: f64) -> f64 {
    0.5 * (within.low[axis] + within.high[axis] + t * (within.high[axis] - within.low[axis]))
}

#[cfg(test)]
mod tests;
