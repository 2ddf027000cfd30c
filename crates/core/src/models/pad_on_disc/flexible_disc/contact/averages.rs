//! Averages over the patch of products of mode shapes.

use crate::models::pad_on_disc::flexible_disc::contact::node::Node;
use crate::models::pad_on_disc::flexible_disc::plate_modes::MOST_DISC_MODES;
use crate::numerics::row::Number;

/// Averages over the patch of products of mode shapes; even amplitudes are `i`, odd ones `j`. Those of two and three
/// shapes, whose number grows with the third power of that of the modes, are there for up to [`MOST_DISC_MODES`] modes.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Averages {
    /// `<psi_i>`.
    pub shape: Vec<f64>,
    /// `<psi_j r theta>`.
    pub arc_shape: Vec<f64>,
    /// `<psi_i psi_i'>`, `even` by `even`.
    pub even_even: Vec<f64>,
    /// `<psi_j psi_j'>`, `odd` by `odd`.
    pub odd_odd: Vec<f64>,
    /// For each even amplitude the factors of its follower load: of the products `a_i a_j` (`even` by `odd`), of `-y
    /// a_j`, and of `-tan(phi) a_i`.
    pub even_follower: Vec<Vec<f64>>,
    /// For each odd amplitude: of `a_i a_i'` and `a_j a_j'` (second index not below the first), of `-y a_i`, and of
    /// `-tan(phi) a_j`.
    pub odd_follower: Vec<Vec<f64>>,
    /// Largest `|psi_k|` and `|r theta|` on the nodes.
    pub largest_shape: Vec<f64>,
    pub largest_arc: f64,
}

impl Averages {
    /// What no gap of the patch is smaller than, at least: while that is positive, the whole patch is in contact.
    #[inline(always)]
    pub fn least_gap<N: Number>(&self, minus_y: N, tilt: N, amplitudes: &[N]) -> N {
        let mut least = minus_y - N::splat(self.largest_arc) * tilt.abs();
        for (amplitude, largest) in amplitudes.iter().zip(&self.largest_shape) {
            least = least - N::splat(*largest) * amplitude.abs();
        }
        least
    }

    /// Whether there are averages of two and three shapes.
    pub fn has_products(&self) -> bool {
        !self.even_even.is_empty()
    }

    /// `<g+>` while the whole patch is in contact: the odd shapes have no mean.
    #[inline(always)]
    pub fn mean_gap<N: Number>(&self, minus_y: N, amplitudes: &[N]) -> N {
        let mut mean = minus_y;
        for (amplitude, shape) in amplitudes.iter().zip(&self.shape) {
            mean = mean + N::splat(*shape) * *amplitude;
        }
        mean
    }

    pub(super) fn new(nodes: &[Node], even: usize, odd: usize) -> Self {
        let average = |value: &dyn Fn(&Node) -> f64| nodes.iter().map(|node| node.weight * value(node)).sum::<f64>();
        let (evens, odds) = (0..even, even..even + odd);
        let products = |range: std::ops::Range<usize>| -> Vec<f64> {
            let pairs = range.clone().flat_map(|k| range.clone().map(move |l| (k, l)));
            pairs.map(|(k, l)| average(&|node| node.shapes[k] * node.shapes[l])).collect()
        };
        // Of `a_l a_m`, from both orders of g and w_theta; of the square of one amplitude once.
        let quadratic = |k: usize, l: usize, m: usize| {
            let once = average(&|node| node.shapes[k] * node.shapes[l] * node.slopes[m]);
            let other = average(&|node| node.shapes[k] * node.shapes[m] * node.slopes[l]);
            if l == m { once } else { once + other }
        };
        let by_normal = |k: usize, m: usize| average(&|node| node.shapes[k] * node.slopes[m]);
        let by_tilt = |k: usize, m: usize| average(&|node| node.shapes[k] * node.arc * node.slopes[m]);
        let even_follower = |k: usize| -> Vec<f64> {
            let mixed = evens.clone().flat_map(|i| odds.clone().map(move |j| (i, j)));
            let mixed = mixed.map(|(i, j)| quadratic(k, i, j));
            mixed.chain(odds.clone().map(|j| by_normal(k, j))).chain(evens.clone().map(|i| by_tilt(k, i))).collect()
        };
        let odd_follower = |k: usize| -> Vec<f64> {
            let pairs = |range: std::ops::Range<usize>| {
                let end = range.end;
                range.flat_map(move |l| (l..end).map(move |m| (l, m)))
            };
            let same = pairs(evens.clone()).chain(pairs(odds.clone())).map(|(l, m)| quadratic(k, l, m));
            same.chain(evens.clone().map(|i| by_normal(k, i))).chain(odds.clone().map(|j| by_tilt(k, j))).collect()
        };
        let largest = |value: &dyn Fn(&Node) -> f64| nodes.iter().map(|node| value(node).abs()).fold(0.0, f64::max);
        let shape = evens.clone().map(|i| average(&|node| node.shapes[i])).collect();
        let arc_shape = odds.clone().map(|j| average(&|node| node.shapes[j] * node.arc)).collect();
        let products_of = |range: &std::ops::Range<usize>| if even > MOST_DISC_MODES { 0..0 } else { range.clone() };
        Self {
            shape,
            arc_shape,
            even_even: products(products_of(&evens)),
            odd_odd: products(products_of(&odds)),
            even_follower: products_of(&evens).map(even_follower).collect(),
            odd_follower: products_of(&odds).map(odd_follower).collect(),
            largest_shape: (0..even + odd).map(|k| largest(&|node| node.shapes[k])).collect(),
            largest_arc: largest(&|node| node.arc),
        }
    }
}
