//! How many eigenvalues of a matrix lie in each region, where none can be on its boundary.
//!
//! The matrix is known as `diag(D) + R(z)`: an eigenvalue z makes `D - z + R(z)` singular, and of R, which is analytic in the regions,
//! the moduli of all entries are bounded by `B(z)`. Where weights `w > 0` satisfy
//!
//! ```text
//! |D_i - z| w_i > sum_j B_ij(z) w_j    for all i,
//! ```
//!
//! `D - z + t R(z)` is regular for all t from 0 to 1 (it is diagonally dominant in the unit of the weights). If that holds on the
//! whole boundary of a region, no eigenvalue crosses it as t grows, so that the region has as many eigenvalues of the matrix as it has
//! entries of D (Gershgorin's argument; R. S. Varga, Gershgorin and His Circles, Springer 2004). What is strongly coupled within a
//! region or far from it does no harm.
//!
//! The boundary is covered by pieces, over each of which distances are those of the whole piece; pieces that are not shown to be free
//! are halved.

use nalgebra::Complex;

use super::decide::{RegionSet, region_at};
use super::region::{RESOLUTION, Region, magnitude};
use crate::numerics::eigenvalues::Eigenvalue;

/// Pieces not longer than this part of the distance of the nearest diagonal entry are not halved: distances hardly grow by that.
const SHORT: f64 = 0.2;

/// Steps to weights.
const STEPS: usize = 8;

/// Weights are at least this part of the largest.
const LEAST_WEIGHT: f64 = 1e-6;

/// Pieces that are looked at at most.
const MOST_PIECES: usize = 1000;

/// A matrix whose entries are known within bounds: `F_ij` with an error of at most `(c_i + min(|z - s_i| n_i, m_i)) b_j`.
#[derive(Debug, Clone)]
pub(super) struct Bounded {
    /// F by rows.
    pub(super) entries: Vec<Complex<f64>>,
    /// What is taken off the distances of its diagonal, so that eigenvalues that are found otherwise are on the same side.
    pub(super) margins: Vec<f64>,
    /// What rounding makes of each entry at most.
    pub(super) rounding: f64,
    /// c.
    pub(super) constant: Vec<f64>,
    /// n.
    pub(super) slope: Vec<f64>,
    /// m.
    pub(super) most: Vec<f64>,
    /// s.
    pub(super) places: Vec<Eigenvalue>,
    /// b.
    pub(super) columns: Vec<f64>,
}

/// A part of a boundary.
#[derive(Debug, Clone, Copy)]
enum Piece {
    /// From one place to another.
    Segment(Eigenvalue, Eigenvalue),
    /// From a place to the right.
    Ray(Eigenvalue),
    /// All frequencies from this one on.
    HalfPlane(f64),
}

impl Piece {
    /// The distance of a place from it.
    fn distance(self, place: Eigenvalue) -> f64 {
        match self {
            Self::Segment(from, to) => {
                let (way, to_place) = (to - from, place - from);
                let part = (to_place.re * way.re + to_place.im * way.im) / way.norm_sqr().max(f64::MIN_POSITIVE);
                length(to_place - way * part.clamp(0.0, 1.0))
            }
            Self::Ray(from) if place.re <= from.re => length(place - from),
            Self::Ray(from) => (place.im - from.im).abs(),
            Self::HalfPlane(lowest) => lowest - place.im,
        }
    }

    /// The largest distance of a place from what is on it, or more than any.
    fn furthest(self, place: Eigenvalue) -> f64 {
        match self {
            Self::Segment(from, to) => length(place - from).max(length(place - to)),
            Self::Ray(_) | Self::HalfPlane(_) => f64::MAX,
        }
    }
}

/// The work on one matrix.
struct Search<'a> {
    matrix: &'a Bounded,
    /// D.
    diagonal: Vec<Eigenvalue>,
    /// `|F_ij|` by rows, zero on the diagonal.
    moduli: Vec<f64>,
    /// The last ones that were found, which often serve for the next piece.
    weights: Vec<f64>,
    distances: Vec<f64>,
    rows: Vec<f64>,
    products: Vec<f64>,
    pieces: usize,
}

impl Bounded {
    /// The regions in which the matrix has an eigenvalue; `None` where one may be on a boundary.
    pub(super) fn regions(&self, regions: &[Region]) -> Option<RegionSet> {
        let count = self.margins.len();
        let mut moduli: Vec<f64> = self.entries.iter().map(|entry| length(*entry)).collect();
        moduli.iter_mut().step_by(count + 1).for_each(|entry| *entry = 0.0);
        let mut search = Search {
            matrix: self,
            diagonal: self.entries.iter().step_by(count + 1).copied().collect(),
            moduli,
            weights: vec![1.0; count],
            distances: vec![0.0; count],
            rows: vec![0.0; count],
            products: vec![0.0; count],
            pieces: 0,
        };
        let mut found = 0;
        for (place, region) in regions.iter().enumerate() {
            let mut entries = search.diagonal.iter().zip(&self.margins);
            if entries.any(|(entry, radius)| region.sure(*entry, *radius).is_none()) || !search.is_free(region) {
                return None;
            }
            if search.diagonal.iter().any(|entry| entry.im > region.lowest.min(0.0) && region.contains(*entry)) {
                found |= region_at(place);
            }
        }
        Some(found)
    }
}

/// The place on the line of a region's threshold with this frequency.
pub(super) fn on_threshold(region: &Region, frequency: f64) -> Eigenvalue {
    let sine = region.damping_ratio - RESOLUTION;
    Eigenvalue::new(-frequency.abs() * sine / ((1.0 - sine) * (1.0 + sine)).sqrt(), frequency)
}

impl Search<'_> {
    /// Beyond this everything is far from all entries.
    fn scale(&self) -> f64 {
        self.diagonal.iter().chain(&self.matrix.places).map(|entry| length(*entry)).fold(1.0, f64::max)
    }

    /// Whether no eigenvalue is on the boundary of a region.
    fn is_free(&mut self, region: &Region) -> bool {
        let scale = 4.0 * self.scale();
        let is_bounded = region.highest < scale;
        let highest = region.highest.min(scale);
        let ends = [region.lowest.min(scale), highest].map(|frequency| on_threshold(region, frequency));
        let edges = if is_bounded { &ends[..] } else { &ends[..1] };
        let right = |from: Eigenvalue| from + Eigenvalue::from(scale);
        // The line turns at zero.
        let turn = if region.lowest < 0.0 { Eigenvalue::from(0.0) } else { ends[0] };
        (turn == ends[0] || self.is_free_between(ends[0], turn))
            && self.is_free_between(turn, ends[1])
            && edges
                .iter()
                .all(|&from| self.is_free_between(from, right(from)) && self.is_clear(Piece::Ray(right(from))))
            && (is_bounded || self.is_clear(Piece::HalfPlane(highest)))
    }

    /// Whether no eigenvalue is on a segment.
    fn is_free_between(&mut self, from: Eigenvalue, to: Eigenvalue) -> bool {
        let piece = Piece::Segment(from, to);
        if self.is_clear(piece) {
            return true;
        }
        let distances = self.diagonal.iter().map(|entry| piece.distance(*entry));
        if self.pieces >= MOST_PIECES || magnitude(to - from) <= SHORT * distances.fold(f64::INFINITY, f64::min) {
            return false;
        }
        let middle = (from + to) * 0.5;
        self.is_free_between(from, middle) && self.is_free_between(middle, to)
    }

    /// Whether weights show that no eigenvalue is on a piece.
    fn is_clear(&mut self, piece: Piece) -> bool {
        self.pieces += 1;
        let Bounded { margins, rounding, constant, slope, most, places, columns, .. } = self.matrix;
        for (i, (entry, margin)) in self.diagonal.iter().zip(margins).enumerate() {
            let distance = piece.distance(*entry) - margin;
            if distance.is_nan() || distance <= 0.0 {
                return false;
            }
            self.distances[i] = distance;
            self.rows[i] = constant[i] + (piece.furthest(places[i]) * slope[i]).min(most[i]);
        }
        let count = margins.len();
        for _ in 0..STEPS {
            let sum = dot(columns, &self.weights);
            let noise = rounding * self.weights.iter().sum::<f64>();
            let (mut are_all_below, mut are_all_above, mut heaviest) = (true, true, 0.0_f64);
            for i in 0..count {
                let row = dot(&self.moduli[i * count..(i + 1) * count], &self.weights);
                let product = (row + self.rows[i] * sum + noise) / self.distances[i];
                are_all_below &= product < self.weights[i];
                are_all_above &= product >= self.weights[i];
                self.products[i] = (self.weights[i] * product).sqrt();
                heaviest = heaviest.max(self.products[i]);
            }
            if are_all_below {
                return true;
            }
            // By Collatz and Wielandt no weights will do then.
            if are_all_above || !heaviest.is_finite() {
                break;
            }
            let weights = self.weights.iter_mut().zip(&self.products);
            weights.for_each(|(weight, product)| *weight = (product / heaviest).max(LEAST_WEIGHT));
        }
        false
    }
}

/// `|z|` of numbers whose squares are in range, faster than [`magnitude`](super::region::magnitude).
pub(super) fn length(z: Eigenvalue) -> f64 {
    z.norm_sqr().sqrt()
}

/// The sum of products, in eight sums that the processor may keep apart.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (eights, rest) = a.as_chunks::<8>();
    let (others, rest_of_others) = b.as_chunks::<8>();
    for (a, b) in eights.iter().zip(others) {
        sums.iter_mut().zip(a.iter().zip(b)).for_each(|(sum, (a, b))| *sum += a * b);
    }
    let rest: f64 = rest.iter().zip(rest_of_others).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f64>() + rest
}

#[cfg(test)]
pub(super) mod tests;
