//! The probability of instability and its derivatives from a verdict map, by integration instead of sampling.
//!
//! In the deviates `z1` of the first input and `z2` of the second, a box of the map is a rectangle. The
//! probability of a uniform box is a product of two differences of the normal distribution function. In a box that a
//! curve crosses, the probability below the curve is
//!
//! ```text
//! integral of   phi(z) (Phi(t(z)) - Phi(t_low))   dz
//! ```
//!
//! over the deviate `z` of the curve's abscissa, with the deviate `t(z)` of the curve, clamped to the box, and that of
//! the lower end of the box, `t_low`. The moments of the deviates are integrated in the same way and give the
//! [derivatives](crate::integrate::derivatives).
//!
//! The result has a lower and an upper bound. Between them is the probability of all unknown verdicts: the gap that a
//! curve leaves between two verdicts, boxes that are not resolved, missing tiles, and samples that are undecided or
//! failed.

mod input;

mod crossed;
use stickslip_core::model::verdict::Verdict;

use self::crossed::{Crossed, CrossedIntegrals};
use self::input::{Edge, Input};
use crate::integrate::derivatives::{Derivatives, DeviateMoments, Moments, product};
use crate::integrate::normal_pair::NormalPair;
use crate::verdict_map::boundary_curve::{BoundaryCurve, Box2};
use crate::verdict_map::map::VerdictMap;
use crate::verdict_map::tile::Node;

/// Boxes with less probability are skipped; they count as unknown.
const LEAST_MASS: f64 = 1e-18;

/// A bound on the rounding errors of one box: of its two factors and of the sum.
const ROUNDING: f64 = 2.0 * f64::EPSILON;

/// A probability of instability, with bounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoundedProbability {
    /// The probability that a sample is unstable, given that the map has it stable or unstable; a boundary is taken to
    /// lie in the middle of its gap. `None` if no verdict is known.
    pub value: Option<f64>,
    /// Lower bound, with every unknown verdict counted as stable.
    pub low: f64,
    /// Upper bound, with every unknown verdict counted as unstable.
    pub high: f64,
    /// Derivatives of `value`; `None` if no verdict is known.
    pub derivatives: Derivatives,
    /// Probability of the verdicts [`Verdict::Undecided`] and [`Verdict::Failed`].
    pub undecided: f64,
}

/// The boxes of a map, prepared for integration over many inputs.
#[derive(Debug, Clone)]
pub struct MapRegions {
    origin: f64,
    /// Every coordinate where a box begins or ends, ascending, along the first and the second coordinate.
    edges: [Vec<f64>; 2],
    boxes: Vec<Region>,
}

/// A box whose verdicts are known.
#[derive(Debug, Clone, Copy)]
struct Region {
    bounds: Box2,
    /// The positions of its ends among the edges.
    ends: [[usize; 2]; 2],
    node: Node,
}

impl MapRegions {
    /// The boxes of `map` whose verdicts are known.
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
        Self { origin: map.origin(), edges, boxes }
    }

    /// The probability of instability with inputs of which all else is as in the map.
    #[must_use]
    pub fn probability(&self, pair: &NormalPair) -> BoundedProbability {
        let inputs = [
            // A first input of exactly 0 is outside the model and not in the first tiles.
            Input {
                expected: if pair.expected[0] == 0.0 { -f64::MIN_POSITIVE } else { pair.expected[0] },
                spread: pair.spread(0),
            },
            Input { expected: pair.expected[1] - self.origin, spread: pair.spread(1) },
        ];
        let edges = [0, 1].map(|axis| self.edges[axis].iter().map(|&edge| inputs[axis].edge(edge)).collect::<Vec<_>>());
        let mut sums = Sums::default();
        sums.add_outside_model(&inputs);
        for Region { bounds, ends, node } in &self.boxes {
            let [first, second] = [0, 1].map(|axis| [edges[axis][ends[axis][0]], edges[axis][ends[axis][1]]]);
            // Before all moments are computed: most boxes end here.
            if first[0].mass_to(&first[1]) * second[0].mass_to(&second[1]) < LEAST_MASS {
                continue;
            }
            let moments = product(&first[0].moments_to(&first[1]), &second[0].moments_to(&second[1]));
            match node {
                Node::Uniform(verdict) => {
                    sums.add(*verdict, &moments);
                    sums.add_known(*verdict, moments[0]);
                }
                Node::Crossed(curve) => {
                    let crossed = Crossed { bounds, curve, inputs: &inputs, ends: &[first, second] };
                    sums.add_crossed(curve, &moments, &crossed.integrals());
                }
                Node::Cut(_) | Node::Unresolved => {}
            }
        }
        sums.probability(pair)
    }
}

/// Sums over the boxes of a map.
#[derive(Debug, Default)]
struct Sums {
    stable: Moments,
    unstable: Moments,
    undecided: f64,
    known_stable: f64,
    known_unstable: f64,
    error: f64,
}

impl Sums {
    /// Adds the samples outside the model, which are stable by definition.
    fn add_outside_model(&mut self, [first, second]: &[Input; 2]) {
        const WHOLE: DeviateMoments = [1.0, 0.0, 0.0];
        let zero = first.edge(0.0);
        let regions = [
            product(&Edge::START.moments_to(&zero), &WHOLE),
            product(&zero.moments_to(&Edge::END), &Edge::START.moments_to(&second.edge(0.0))),
        ];
        for moments in regions {
            self.add(Verdict::Stable, &moments);
            self.add_known(Verdict::Stable, moments[0]);
        }
    }

    /// Adds a region with one verdict.
    fn add(&mut self, verdict: Verdict, moments: &Moments) {
        match verdict {
            Verdict::Stable => (0..5).for_each(|i| self.stable[i] += moments[i]),
            Verdict::Unstable => (0..5).for_each(|i| self.unstable[i] += moments[i]),
            Verdict::Undecided | Verdict::Failed => self.undecided += moments[0],
        }
    }

    /// Adds the probability of a region whose verdict does not depend on where in its gap a boundary is.
    fn add_known(&mut self, verdict: Verdict, mass: f64) {
        self.error += ROUNDING;
        match verdict {
            Verdict::Stable => self.known_stable += mass,
            Verdict::Unstable => self.known_unstable += mass,
            Verdict::Undecided | Verdict::Failed => {}
        }
    }

    /// Adds a box that a curve crosses; `whole` are the moments of the box.
    fn add_crossed(&mut self, curve: &BoundaryCurve, whole: &Moments, (crossed, error): &(CrossedIntegrals, f64)) {
        let below: Moments = std::array::from_fn(|i| crossed[i]);
        self.add(curve.below, &below);
        self.add(curve.above, &std::array::from_fn(|i| whole[i] - below[i]));
        self.add_known(curve.below, crossed[5]);
        self.add_known(curve.above, crossed[6]);
        self.error += error;
    }

    fn probability(&self, pair: &NormalPair) -> BoundedProbability {
        let low = (self.known_unstable - self.error).clamp(0.0, 1.0);
        let high = (1.0 - self.known_stable + self.error).clamp(0.0, 1.0);
        let (stable, unstable) = (self.stable[0], self.unstable[0]);
        let decided = stable + unstable;
        let undecided = self.undecided.clamp(0.0, 1.0);
        if decided < LEAST_MASS {
            return BoundedProbability { value: None, low, high, derivatives: Derivatives::default(), undecided };
        }
        // The quotient rule, as the known probability depends on the inputs too.
        let quotient = |i: usize| (self.unstable[i] * stable - unstable * self.stable[i]) / (decided * decided);
        let derivatives = Derivatives::from_moments(pair, &std::array::from_fn(quotient));
        let value = Some((unstable / decided).clamp(low, high));
        BoundedProbability { value, low, high, derivatives, undecided }
    }
}

#[cfg(test)]
mod tests;
