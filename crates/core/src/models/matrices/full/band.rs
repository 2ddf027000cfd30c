//! All eigenpairs of a frequency band.

use nalgebra::DMatrix;

use super::krylov::{Effort, Krylov, Ritz};
use super::quadratic::{Factorisation, Point, Side};
use crate::models::matrices::error::Error;
use crate::models::matrices::pair::{Complex, Pair, dot, normalise};
use crate::models::matrices::region::{Region, damping_ratio, magnitude};

/// Residual at which a vector of a Krylov space is taken. The error of the eigenvalue is about its square.
const TOLERANCE: f64 = 1e-8;

/// Above this error of an eigenvalue, relative to it, the pair is refined with a factorisation of its own.
const ENOUGH: f64 = 1e-12;

/// Eigenvalues nearer than this, relative to them, are taken as one cluster.
const CLUSTER: f64 = 1e-6;

/// How often a part of a band may be halved.
const HALVINGS: usize = 20;

/// The part of the ends of a region's band by which a search for its pairs reaches beyond them.
const MARGIN: f64 = 0.02;

/// How far below the threshold of a region, and above it, damping ratios are looked for.
const DAMPING: [f64; 2] = [0.3, 0.05];

/// Pairs that grow even faster, to this damping ratio, are looked for where a small space of each of some shifts shows one.
const LEAST: f64 = -0.99;

/// The direction of these shifts, in which damping ratios are -0.81. With `(lambda + conj s) / (lambda - s)` the left half plane
/// becomes the unit disc, and damping ratios from -0.3 to -0.97, of magnitudes within a factor of three of the shift, lie
/// outside it by a factor of 1.25 at least: so much each step favours them.
const GROWING: Complex = Complex::new(0.81, 0.586_429_876);

/// The range of magnitudes that a shift serves, and the steps from it.
const RATIO: f64 = 9.0;
const STEPS: usize = 40;

/// The residual at which a value of such a space is looked into.
const SUSPICIOUS: f64 = 0.1;

/// Where shifts begin in a band that goes down to 0, over its highest frequency.
const LOWEST: f64 = 1e-3;

/// Which eigenpairs are wanted: by angular frequency in rad/s, and by damping ratio. A pair outside is not looked for, also if
/// it grows faster.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Band {
    /// Lowest angular frequency in rad/s.
    pub low: f64,
    /// Highest angular frequency in rad/s.
    pub high: f64,
    /// Lowest damping ratio, above -1: negative for pairs that grow.
    pub least_damping: f64,
    /// Highest damping ratio, below 1.
    pub most_damping: f64,
}

impl Band {
    /// A band with all damping ratios up to 0.1 in magnitude.
    #[must_use]
    pub fn between(low: f64, high: f64) -> Self {
        Self { low, high, least_damping: -0.1, most_damping: 0.1 }
    }

    /// A band that has the pairs of a region and those that come into it near by: a little wider, with damping ratios from 0.3
    /// below its threshold, or -0.3, to 0.05 above.
    #[must_use]
    pub fn about(region: &Region) -> Self {
        Self {
            low: region.lowest * (1.0 - MARGIN),
            high: region.highest * (1.0 + MARGIN),
            least_damping: (region.damping_ratio - DAMPING[0]).clamp(-0.9, -DAMPING[0]),
            most_damping: (region.damping_ratio + DAMPING[1]).max(DAMPING[1]),
        }
    }

    /// Whether an eigenvalue lies in the band.
    #[must_use]
    pub fn contains(&self, eigenvalue: Complex) -> bool {
        (self.low..=self.high).contains(&eigenvalue.im)
            && (self.least_damping..=self.most_damping).contains(&damping_ratio(eigenvalue))
    }

    /// Whether it is one.
    fn is_sound(&self) -> bool {
        let ratios = [self.least_damping, self.most_damping];
        let are_ratios = ratios.iter().all(|ratio| ratio.abs() < 1.0) && ratios[0] < ratios[1];
        are_ratios && self.low >= 0.0 && self.high > self.low && self.high.is_finite()
    }

    /// A rectangle around it.
    fn rectangle(&self) -> Rectangle {
        let real = |ratio: f64, im: f64| -im * ratio / (1.0 - ratio * ratio).sqrt();
        let reals = |ratio| [real(ratio, self.low), real(ratio, self.high)];
        let left = reals(self.most_damping).into_iter().fold(f64::INFINITY, f64::min);
        let right = reals(self.least_damping).into_iter().fold(f64::NEG_INFINITY, f64::max);
        Rectangle {
            middle: Complex::new(0.5 * (left + right), 0.5 * (self.low + self.high)),
            half_width: 0.5 * (right - left),
            half_height: 0.5 * (self.high - self.low),
        }
    }
}

/// A part of the complex plane.
#[derive(Debug, Clone, Copy)]
struct Rectangle {
    middle: Complex,
    half_width: f64,
    half_height: f64,
}

impl Rectangle {
    fn halves(self) -> [Self; 2] {
        let (mut half, mut away) = (self, Complex::default());
        if self.half_width > self.half_height {
            half.half_width *= 0.5;
            away.re = half.half_width;
        } else {
            half.half_height *= 0.5;
            away.im = half.half_height;
        }
        [self.middle - away, self.middle + away].map(|middle| Self { middle, ..half })
    }

    fn radius(self) -> f64 {
        (self.half_width * self.half_width + self.half_height * self.half_height).sqrt()
    }
}

/// How much work to take for one circle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct KrylovLimit {
    /// Vectors of a Krylov space; each costs a solve, and memory of two complex vectors. A band with more eigenvalues than
    /// they find is halved.
    pub vectors: usize,
}

impl Default for KrylovLimit {
    fn default() -> Self {
        Self { vectors: 120 }
    }
}

impl Point<'_> {
    /// All eigenpairs in a band, by rising frequency.
    ///
    /// Circles around shifts cover the band. Within each, all Ritz values from the nearest to beyond the circle have converged;
    /// where they have not, the rectangle in the circle is halved, and each half has a circle. Double
    /// eigenvalues are found, those of higher multiplicity may not be.
    ///
    /// # Errors
    /// [`Error::Request`] for a band without frequencies, [`Error::NotConverged`], and what factorisations say.
    pub fn pairs_in(&self, band: Band, limit: KrylovLimit) -> Result<Vec<Pair>, Error> {
        if !band.is_sound() {
            return Err(Error::Request(
                "a band goes from a frequency and a damping ratio to higher ones, ratios within 1",
            ));
        }
        let mut parts = vec![(band.rectangle(), 0)];
        let mut pairs: Vec<Pair> = Vec::new();
        while let Some((part, halvings)) = parts.pop() {
            let Some(found) = self.pairs_of_part(band, part, limit)? else {
                if halvings >= HALVINGS {
                    return Err(Error::NotConverged { re: part.middle.re, im: part.middle.im });
                }
                parts.extend(part.halves().map(|half| (half, halvings + 1)));
                continue;
            };
            for pair in found {
                if !pairs.iter().any(|known| self.is_same(known, &pair)) {
                    pairs.push(pair);
                }
            }
        }
        pairs.sort_by(|a, b| a.eigenvalue.im.total_cmp(&b.eigenvalue.im));
        Ok(pairs)
    }

    /// All pairs of a region, and those that come into it near by.
    ///
    /// # Errors
    /// As [`Point::pairs_in`].
    pub fn pairs_about(&self, region: &Region, limit: KrylovLimit) -> Result<Vec<Pair>, Error> {
        let mut band = Band::about(region);
        if self.seems_to_grow_faster(&band)? {
            band.least_damping = LEAST;
        }
        self.pairs_in(band, limit)
    }

    /// Whether there may be a pair with a frequency of a band that grows faster than the band reaches.
    fn seems_to_grow_faster(&self, band: &Band) -> Result<bool, Error> {
        // Eigenvalues that are nearly real are larger than their frequencies.
        let (low, high) = (band.low.max(LOWEST * band.high), 2.0 * band.high);
        let span = libm::log(high / low);
        let shifts = (span / libm::log(RATIO)).ceil().max(1.0);
        let effort = Effort { radius: f64::INFINITY, vectors: STEPS, block: 1, tolerance: TOLERANCE };
        for index in 0..shifts as usize {
            let size = low * libm::exp(span * (index as f64 + 0.5) / shifts);
            let near = self.factorise(GROWING * size)?;
            let space = Krylov::new(self, &near, Side::Right, effort)?;
            let is_suspicious = |value: &Ritz| {
                value.residual <= SUSPICIOUS
                    && (band.low * (1.0 - MARGIN)..=band.high * (1.0 + MARGIN)).contains(&value.eigenvalue.im)
                    && damping_ratio(value.eigenvalue) < band.least_damping * (1.0 - MARGIN)
            };
            if space.values.iter().any(is_suspicious) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Whether two pairs are one: of one eigenvalue, with vectors that are not independent.
    fn is_same(&self, known: &Pair, pair: &Pair) -> bool {
        magnitude(known.eigenvalue - pair.eigenvalue) <= 1e-9 * magnitude(pair.eigenvalue) && {
            let mut image = vec![Complex::default(); pair.right.len()];
            let one = Complex::new(1.0, 0.0);
            self.combine([pair.eigenvalue * 2.0, one, Complex::default()], &pair.right, Side::Right, &mut image);
            magnitude(dot(&known.left, &image)) > 1e-3
        }
    }

    /// The pairs of a part of a band by one circle, or nothing if it does not reach.
    fn pairs_of_part(&self, band: Band, part: Rectangle, limit: KrylovLimit) -> Result<Option<Vec<Pair>>, Error> {
        // Off the middle a little, where an undamped pair could meet the shift.
        let away = 1e-3 * part.radius();
        let shift = part.middle + away;
        let near = self.factorise(shift)?;
        let radius = part.radius() * (1.0 + 1e-9) + away;
        let effort = Effort { radius, vectors: limit.vectors, block: 2, tolerance: TOLERANCE };
        let rights = Krylov::new(self, &near, Side::Right, effort)?;
        if rights.radius < effort.radius {
            return Ok(None);
        }
        // The other side converges alike; a little more, so that partners of the outermost are there.
        let lefts = Krylov::new(self, &near, Side::Left, Effort { vectors: limit.vectors + 16, ..effort })?;
        if lefts.radius < effort.radius {
            return Ok(None);
        }
        let mut pairs = Vec::new();
        for cluster in clusters(&rights.values, effort.radius * (1.0 + CLUSTER)) {
            let others = partners(&cluster, &lefts.values);
            if others.len() < cluster.len() {
                return Ok(None);
            }
            let columns = cluster.iter().map(|value| rights.vector(value)).collect();
            let rows = others.iter().map(|value| lefts.vector(value)).collect();
            let Some(found) = self.biorthogonal(&cluster, columns, rows) else { return Ok(None) };
            for pair in found {
                pairs.push(self.checked(pair, &near, &rights.values)?);
            }
        }
        pairs.retain(|pair| band.contains(pair.eigenvalue));
        Ok(Some(pairs))
    }

    /// Pairs of a cluster of eigenvalues with `Y^T Q' X = 1`.
    fn biorthogonal(
        &self,
        cluster: &[Ritz],
        mut rights: Vec<Vec<Complex>>,
        mut lefts: Vec<Vec<Complex>>,
    ) -> Option<Vec<Pair>> {
        rights.iter_mut().chain(&mut lefts).for_each(|vector| normalise(vector));
        let one = Complex::new(1.0, 0.0);
        let images: Vec<Vec<Complex>> = rights
            .iter()
            .zip(cluster)
            .map(|(vector, value)| {
                let mut image = vec![Complex::default(); vector.len()];
                self.combine([value.eigenvalue * 2.0, one, Complex::default()], vector, Side::Right, &mut image);
                image
            })
            .collect();
        let count = rights.len();
        let gram = DMatrix::from_fn(count, count, |row, column| dot(&lefts[row], &images[column]));
        let inverse = gram.try_inverse()?;
        let mixed = |row: usize| {
            let mut sum = vec![Complex::default(); lefts[row].len()];
            for (column, left) in lefts.iter().enumerate() {
                let factor = inverse[(row, column)];
                sum.iter_mut().zip(left).for_each(|(sum, value)| *sum += factor * value);
            }
            sum
        };
        let lefts: Vec<Vec<Complex>> = (0..count).map(mixed).collect();
        let pairs = cluster.iter().zip(rights).zip(lefts);
        Some(
            pairs
                .map(|((value, right), left)| Pair { eigenvalue: value.eigenvalue, right, left, error: 0.0 })
                .collect(),
        )
    }

    /// The pair with its eigenvalue from both vectors and the error of that; refined if it is not small.
    ///
    /// The error is `e_y^T Q e_x`, where e are the errors of the vectors: `r_y^T Q(lambda)^-1 r_x` without the pair itself, and
    /// that is at most `r_y^T Q(s)^-1 r_x` times the largest `|lambda_j - s| / |lambda_j - lambda|` of the others.
    fn checked(&self, mut pair: Pair, near: &Factorisation, others: &[Ritz]) -> Result<Pair, Error> {
        let size = self.family().size();
        if let Some((value, slope)) = self.rayleigh(pair.eigenvalue, &pair.left, &pair.right) {
            let scale = magnitude(value);
            pair.left.iter_mut().for_each(|value| *value /= slope);
            pair.eigenvalue = value;
            let mut solved = self.residual(value, &pair.right, Side::Right);
            let left = self.residual(value, &pair.left, Side::Left);
            near.solve(&mut solved, size, Side::Right)?;
            let farther = others
                .iter()
                .map(|other| (other.distance, magnitude(other.eigenvalue - value)))
                .filter(|(_, gap)| *gap > CLUSTER * scale)
                .fold(1.0_f64, |largest, (distance, gap)| largest.max(distance / gap));
            pair.error = 2.0 * magnitude(dot(&left, &solved)) * farther + 4.0 * f64::EPSILON * scale;
            if pair.error <= ENOUGH * scale {
                return Ok(pair);
            }
        }
        self.refine(&pair)
    }
}

/// Values up to a distance from the shift, those that are nearly equal together.
fn clusters(values: &[Ritz], radius: f64) -> Vec<Vec<Ritz>> {
    let mut clusters: Vec<Vec<Ritz>> = Vec::new();
    for value in values.iter().take_while(|value| value.distance <= radius) {
        let is_near =
            |other: &Ritz| magnitude(other.eigenvalue - value.eigenvalue) <= CLUSTER * magnitude(value.eigenvalue);
        match clusters.iter_mut().find(|cluster| cluster.iter().any(is_near)) {
            Some(cluster) => cluster.push(*value),
            None => clusters.push(vec![*value]),
        }
    }
    clusters
}

/// As many values of the other side nearest to a cluster as the cluster has.
fn partners(cluster: &[Ritz], others: &[Ritz]) -> Vec<Ritz> {
    let distance = |other: &Ritz| {
        cluster.iter().map(|value| magnitude(value.eigenvalue - other.eigenvalue)).fold(f64::INFINITY, f64::min)
    };
    let mut near: Vec<(f64, Ritz)> = others.iter().map(|other| (distance(other), *other)).collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0));
    let most = 10.0 * CLUSTER * cluster.first().map_or(0.0, |value| magnitude(value.eigenvalue));
    near.into_iter().take(cluster.len()).filter(|(distance, _)| *distance <= most).map(|(_, value)| value).collect()
}
