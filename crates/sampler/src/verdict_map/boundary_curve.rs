//! A piece of a boundary between two verdicts, located by asking for verdicts and written as a polynomial.
//!
//! The plane is that of preload `Delta` and falling friction `f_s - f_c`. A piece is the graph of one of the two over an
//! interval of the other: on one side of it every sample has one verdict, on the other side another. Where a verdict of a
//! third kind lies between them (samples that are undecided at the horizon), each side has a graph of its own. An answer of one
//! side beyond a verdict of a third kind contradicts that, and ends the search.
//!
//! Verdicts are all that is known of a motion, so a point of a graph is found by bisection, to a few millionths of its
//! coordinate, at eight Chebyshev nodes; the polynomial through them is then tried at the nine points between and beside
//! the nodes, where its error is largest. A piece that fails, because the boundary bends too much for it, has a corner or
//! is not there all along, is no piece; the map cuts the box and tries again. A boundary that is ragged on a small scale
//! (where the rules of a verdict count cycles, say) passes with a wider guard around it.

use stickslip_core::verdict::Verdict;

/// Nodes of a piece, one more than the degree of its polynomials.
pub const NODES: usize = 8;

/// Where graphs are located: to this share of the coordinate ...
const TOLERANCE: f64 = 4e-6;

/// ... which counts as no smaller than this.
const LEAST_COORDINATE: f64 = 1e-3;

/// Distance that is kept from the polynomials, in tolerances: interpolation at Chebyshev nodes may double their errors.
const GUARD: f64 = 2.0;

/// How far beyond the box a graph is looked for, over the side of the box.
const REACH: f64 = 2.0;

/// Coordinates in the plane: preload and falling friction.
pub(crate) type Point = [f64; 2];

/// Part of the plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Box2 {
    /// Lower ends: preload, falling friction.
    pub low: Point,
    /// Upper ends.
    pub high: Point,
}

/// The piece of boundary in a box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundaryCurve {
    /// Over which coordinate it is a graph: 0 preload, 1 falling friction.
    pub over: usize,
    /// The verdict where the other coordinate is below the graph.
    pub below: Verdict,
    /// The verdict where it is above.
    pub above: Verdict,
    /// Chebyshev coefficients, on the box, of the highest value that is certainly below.
    pub lower: [f64; NODES],
    /// Of the lowest value that is certainly above.
    pub upper: [f64; NODES],
    /// Distance to keep from both.
    pub guard: f64,
}

impl BoundaryCurve {
    /// The ends, at `coordinate`, of what the piece does not tell: certainly `below` up to the first, certainly `above`
    /// from the second.
    #[must_use]
    pub fn gap(&self, within: &Box2, coordinate: f64) -> (f64, f64) {
        let t = scaled(within, self.over, coordinate);
        (clenshaw(&self.lower, t) - self.guard, clenshaw(&self.upper, t) + self.guard)
    }

    /// The verdict at a point of the box; `None` within the resolution of the piece.
    #[inline]
    #[must_use]
    pub fn verdict(&self, within: &Box2, point: [f64; 2]) -> Option<Verdict> {
        let (low, high) = self.gap(within, point[self.over]);
        let value = point[1 - self.over];
        if value < low {
            Some(self.below)
        } else if value > high {
            Some(self.above)
        } else {
            None
        }
    }
}

fn scaled(within: &Box2, axis: usize, coordinate: f64) -> f64 {
    (2.0 * coordinate - within.low[axis] - within.high[axis]) / (within.high[axis] - within.low[axis])
}

fn clenshaw(coefficients: &[f64; NODES], t: f64) -> f64 {
    let (mut b1, mut b2) = (0.0, 0.0);
    for &coefficient in coefficients[1..].iter().rev() {
        (b1, b2) = (coefficient + 2.0 * t * b1 - b2, b1);
    }
    coefficients[0] + t * b1 - b2
}

/// The cosine of `pi k / (2 NODES)`.
fn cosine(k: usize) -> f64 {
    libm::cos(std::f64::consts::PI * k as f64 / (2 * NODES) as f64)
}

fn coefficients(values: &[f64; NODES]) -> [f64; NODES] {
    std::array::from_fn(|j| {
        let sum: f64 = (0..NODES).map(|k| values[k] * cosine(j * (2 * k + 1) % (4 * NODES))).sum();
        sum * if j == 0 { 1.0 } else { 2.0 } / NODES as f64
    })
}

/// A piece being located.
#[derive(Debug, Clone)]
pub(crate) struct Search {
    within: Box2,
    over: usize,
    below: Verdict,
    above: Verdict,
    nodes: [NodeSearch; NODES],
    is_contradicted: bool,
}

/// The graph at one node: `below` up to `below_at`, `above` from `above_at`; `other`, if any, are the ends of what is
/// known to have neither verdict.
#[derive(Debug, Clone, Copy)]
struct NodeSearch {
    coordinate: f64,
    below_at: f64,
    above_at: f64,
    other: Option<(f64, f64)>,
}

impl NodeSearch {
    /// What to ask next: on the lower side until that is narrow enough, then on the upper one.
    fn next(&self) -> Option<f64> {
        let tolerance = TOLERANCE * self.above_at.abs().max(LEAST_COORDINATE);
        let intervals = match self.other {
            None => [(self.below_at, self.above_at); 2],
            Some((from, to)) => [(self.below_at, from), (to, self.above_at)],
        };
        intervals.into_iter().find(|(from, to)| to - from > tolerance).map(|(from, to)| 0.5 * (from + to))
    }

    /// Takes an answer. Whether it agrees with the earlier ones: nothing is `below` above what has neither verdict, nor
    /// `above` below it.
    fn learn(&mut self, at: f64, verdict: Verdict, below: Verdict, above: Verdict) -> bool {
        if verdict == below {
            self.below_at = at;
            self.other.is_none_or(|(from, _)| at < from)
        } else if verdict == above {
            self.above_at = at;
            self.other.is_none_or(|(_, to)| at > to)
        } else {
            self.other = Some(self.other.map_or((at, at), |(from, to)| (from.min(at), to.max(at))));
            true
        }
    }
}

impl Search {
    /// A piece between `below` and `above`, a graph over coordinate `over` of the box; `expected` says between which values
    /// it should lie at a coordinate.
    pub fn new(
        within: Box2,
        over: usize,
        (below, above): (Verdict, Verdict),
        expected: impl Fn(f64) -> (f64, f64),
    ) -> Self {
        let nodes = std::array::from_fn(|k| {
            let coordinate = at(&within, over, cosine(2 * k + 1));
            let (below_at, above_at) = expected(coordinate);
            NodeSearch { coordinate, below_at, above_at, other: None }
        });
        Self { within, over, below, above, nodes, is_contradicted: false }
    }

    /// Looks farther: the graph was not where it was expected.
    pub fn widen(&mut self) {
        let across = 1 - self.over;
        let reach = REACH * (self.within.high[across] - self.within.low[across]);
        for node in &mut self.nodes {
            node.below_at = self.within.low[across] - reach;
            node.above_at = self.within.high[across] + reach;
        }
    }

    fn point(&self, coordinate: f64, value: f64) -> Point {
        if self.over == 0 { [coordinate, value] } else { [value, coordinate] }
    }

    /// The points whose verdicts tell whether there is a graph to look for.
    pub fn ends(&self) -> Vec<Point> {
        let ends = |node: &NodeSearch| [node.below_at, node.above_at].map(|value| self.point(node.coordinate, value));
        self.nodes.iter().flat_map(ends).collect()
    }

    /// Whether those verdicts are as they should be.
    pub fn accepts_ends(&self, verdicts: &[Verdict]) -> bool {
        verdicts.chunks_exact(2).all(|pair| pair == [self.below, self.above])
    }

    /// Whether an answer contradicted an earlier one: the boundary is no graph here, and there is nothing to locate.
    pub fn is_contradicted(&self) -> bool {
        self.is_contradicted
    }

    /// The points to ask next; empty when every node is located, or one is contradicted.
    pub fn questions(&self) -> Vec<Point> {
        if self.is_contradicted {
            return Vec::new();
        }
        self.nodes.iter().filter_map(|node| Some(self.point(node.coordinate, node.next()?))).collect()
    }

    /// Takes the verdicts at the points of [`Search::questions`].
    pub fn learn(&mut self, verdicts: &[Verdict]) {
        let mut answers = verdicts.iter();
        for node in &mut self.nodes {
            if let Some(value) = node.next()
                && let Some(&verdict) = answers.next()
                && !node.learn(value, verdict, self.below, self.above)
            {
                self.is_contradicted = true;
            }
        }
    }

    /// The polynomials through the located nodes, guarded by `factor` times the distance that an exact boundary needs, and
    /// the points where they have to prove themselves: certainly `below` and certainly `above` in turn.
    pub fn curve(&self, factor: f64) -> (BoundaryCurve, Vec<Point>) {
        let largest = self.nodes.iter().map(|node| node.above_at.abs()).fold(LEAST_COORDINATE, f64::max);
        let curve = BoundaryCurve {
            over: self.over,
            below: self.below,
            above: self.above,
            lower: coefficients(&self.nodes.map(|node| node.below_at)),
            upper: coefficients(&self.nodes.map(|node| node.above_at)),
            guard: factor * GUARD * TOLERANCE * largest,
        };
        let proof = (0..=NODES).flat_map(|k| {
            let coordinate = at(&self.within, self.over, cosine(2 * k));
            let (low, high) = curve.gap(&self.within, coordinate);
            [self.point(coordinate, low), self.point(coordinate, high)]
        });
        (curve, proof.collect())
    }

    /// Whether the verdicts at the points of the proof are as they should be.
    pub fn accepts_proof(&self, verdicts: &[Verdict]) -> bool {
        self.accepts_ends(verdicts)
    }
}

/// The coordinate at `t` from -1 to 1 across the box.
fn at(within: &Box2, axis: usize, t: f64) -> f64 {
    0.5 * (within.low[axis] + within.high[axis] + t * (within.high[axis] - within.low[axis]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn locate(within: Box2, over: usize, judge: impl Fn(Point) -> Verdict) -> Option<(BoundaryCurve, usize)> {
        let mut asked = 0;
        let mut ask = |points: &[Point]| -> Vec<Verdict> {
            asked += points.len();
            points.iter().map(|&point| judge(point)).collect()
        };
        let expected = |_| (within.low[1 - over], within.high[1 - over]);
        let mut search = Search::new(within, over, (Verdict::Stable, Verdict::Unstable), expected);
        if !search.accepts_ends(&ask(&search.ends())) {
            search.widen();
            if !search.accepts_ends(&ask(&search.ends())) {
                return None;
            }
        }
        loop {
            let questions = search.questions();
            if questions.is_empty() {
                break;
            }
            search.learn(&ask(&questions));
        }
        let (curve, proof) = search.curve(1.0);
        search.accepts_proof(&ask(&proof)).then_some((curve, asked))
    }

    const BOX: Box2 = Box2 { low: [0.125, 0.0625], high: [0.1875, 0.125] };

    #[test]
    fn a_hyperbola_is_located_to_a_few_millionths() {
        let judge = |[x, y]: Point| if x * y > 0.0135 { Verdict::Unstable } else { Verdict::Stable };
        for over in [0, 1] {
            let (curve, asked) = locate(BOX, over, judge).unwrap();
            assert!(asked < 250, "{asked}");
            for i in 0..1000 {
                let coordinate = BOX.low[over] + 0.0625 * (f64::from(i) + 0.5) / 1000.0;
                let (low, high) = curve.gap(&BOX, coordinate);
                let exact = 0.0135 / coordinate;
                assert!(low < exact && exact < high && high - low < 4e-5 * exact, "{coordinate}: {low} {exact} {high}");
            }
        }
    }

    #[test]
    fn a_corner_and_a_missing_boundary_are_refused() {
        let corner = |[x, y]: Point| if y > 0.09 + (x - 0.15).abs() { Verdict::Unstable } else { Verdict::Stable };
        assert!(locate(BOX, 0, corner).is_none());
        assert!(locate(BOX, 0, |_| Verdict::Stable).is_none());
        assert!(locate(BOX, 0, |[x, _]| if x > 0.15 { Verdict::Unstable } else { Verdict::Stable }).is_none());
    }

    #[test]
    fn what_lies_between_two_verdicts_is_left_out() {
        let judge = |[x, y]: Point| match x * y {
            product if product > 0.0136 => Verdict::Unstable,
            product if product > 0.0134 => Verdict::Undecided,
            _ => Verdict::Stable,
        };
        let (curve, _) = locate(BOX, 0, judge).unwrap();
        for i in 0..100 {
            let x = 0.125 + 0.0625 * (f64::from(i) + 0.5) / 100.0;
            let (low, high) = curve.gap(&BOX, x);
            assert!(low < 0.0134 / x && low > 0.0134 / x - 4e-6 && high > 0.0136 / x && high < 0.0136 / x + 4e-6);
            assert_eq!(curve.verdict(&BOX, [x, 0.0135 / x]), None);
            assert_eq!(curve.verdict(&BOX, [x, 0.0133 / x]), Some(Verdict::Stable));
            assert_eq!(curve.verdict(&BOX, [x, 0.0137 / x]), Some(Verdict::Unstable));
        }
    }

    #[test]
    fn verdicts_without_order_along_a_line_end_the_search() {
        // From below: stable, undecided, stable again, unstable, undecided, unstable; and the other way round.
        let stripes = |value: f64| match (value * 1600.0) as i64 % 8 {
            0 | 1 | 4 => Verdict::Stable,
            3 | 5 => Verdict::Undecided,
            _ => Verdict::Unstable,
        };
        for shift in 0..200 {
            let shift = f64::from(shift) * 7.3e-5;
            let judge = |point: Point| match point[1] + shift {
                value if value < 0.064 => Verdict::Stable,
                value if value > 0.136 => Verdict::Unstable,
                value => stripes(value),
            };
            let mut search = Search::new(BOX, 0, (Verdict::Stable, Verdict::Unstable), |coordinate| {
                (0.05, 0.1375 + 0.01 * coordinate)
            });
            let mut rounds = 0;
            while !search.questions().is_empty() {
                let verdicts: Vec<Verdict> = search.questions().into_iter().map(judge).collect();
                search.learn(&verdicts);
                rounds += 1;
                assert!(rounds < 60, "{shift}");
            }
        }
    }

    #[test]
    fn an_answer_on_the_wrong_side_of_a_third_verdict_is_a_contradiction() {
        let (below, above, third) = (Verdict::Stable, Verdict::Unstable, Verdict::Undecided);
        let open = NodeSearch { coordinate: 0.0, below_at: 0.0, above_at: 1.0, other: None };
        let met = NodeSearch { other: Some((0.5, 0.5)), ..open };
        let agrees = |node: NodeSearch, at: f64, verdict: Verdict| {
            let mut node = node;
            node.learn(at, verdict, below, above)
        };
        assert!([below, above, third].into_iter().all(|verdict| agrees(open, 0.5, verdict)));
        assert!([below, third].into_iter().all(|verdict| agrees(met, 0.25, verdict)));
        assert!([above, third].into_iter().all(|verdict| agrees(met, 0.75, verdict)));
        assert!(!agrees(met, 0.25, above) && !agrees(met, 0.75, below));
    }
}
