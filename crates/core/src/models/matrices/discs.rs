//! Discs that hold the eigenvalues of a problem over an interval of a path, whatever the parameter is in it.

use nalgebra::{Complex, DMatrix, DVector};

use super::branches::Path;
use super::eigenbasis::{ComplexMatrix, Decomposition, Split, product};
use super::quadratic::{DenseQuadratic, Quadratic};
use super::region::magnitude;
use crate::numerics::eigenvalues::Eigenvalue;

/// Vectors are turned towards those of the whole interval where this part of the distance of two eigenvalues is more than what
/// couples them over it.
const TURNED: f64 = 0.25;

/// Relative rounding of sums and products of matrices.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Parts of an eigenvalue by which two of a cluster differ at most, but for rounding.
const CLUSTER: f64 = 1e-5;

/// The most eigenvalues of a cluster.
const LARGEST_CLUSTER: usize = 8;

/// The part of the distance to the nearest other disc that a disc may have, and that others keep away from its centre.
pub(super) const SHARE: f64 = 0.25;

/// Larger scales say no more.
const LARGEST_SCALE: f64 = 1e12;

/// A problem at a place of a path, in the basis of its eigenvectors, with its changes along the path.
///
/// With `A(p + d) = A + d A_1 + d^2 A_2 + rest`, `A X = X diag(lambda)` and `Y = X^-1`, these are `Y A_1 X` and `Y A_2 X`, and bounds
/// of the moduli of `Y (rest) X` and of all rounding.
pub(super) struct Expansion {
    eigenvalues: Vec<Eigenvalue>,
    first: ComplexMatrix,
    second: Option<ComplexMatrix>,
    rest: DMatrix<f64>,
    /// The part of rounding in the rest of each eigenvalue.
    rounding: Vec<f64>,
    /// How far the symmetric part of C and the skew part of K move each eigenvalue at most, to first order.
    asymmetry: Vec<f64>,
}

impl Expansion {
    /// The expansion about `p` for steps up to `step` from there; nothing where there is none. `asymmetries` are those of the terms
    /// of the problem, or none where they make no difference.
    pub(super) fn new(
        problem: &DenseQuadratic,
        path: &dyn Path,
        (p, step): (f64, f64),
        asymmetries: &[f64],
    ) -> Option<Self> {
        let series = path.series(p, step);
        if series.iter().flatten().any(|value| !value.is_finite()) {
            return None;
        }
        let of_order = |order: usize| series.iter().map(|of_term| of_term[order]).collect::<Vec<f64>>();
        let here = problem.at(&of_order(0));
        let Decomposition { eigenvalues, vectors, inverse } = Decomposition::balanced(&here)?;
        let coordinates = problem.size();
        let (states, right) = (eigenvalues.len(), Split::new(&vectors));
        let of_forces = Split::new(&inverse.columns(coordinates, coordinates).into_owned());
        let in_basis = |change: &Quadratic| of_forces.times(&right.forces(change));

        // A X - X diag(lambda).
        let forces = right.forces(&here);
        let residual = DMatrix::from_fn(2 * coordinates, states, |row, column| {
            let image = match row.checked_sub(coordinates) {
                Some(row) => forces.entry(row, column),
                None => vectors[(row + coordinates, column)],
            };
            magnitude(image - vectors[(row, column)] * eigenvalues[column])
        });
        let (left, right) = (inverse.map(magnitude), vectors.map(magnitude));
        let [upper, lower] = [0, coordinates].map(|from| right.rows(from, coordinates).into_owned());
        let noise = |sizes: &[f64], unit: f64| {
            let errors = problem.magnitudes_at(sizes);
            let mut noise = DMatrix::zeros(2 * coordinates, states);
            noise.rows_mut(0, coordinates).copy_from(&(&lower * unit));
            noise
                .rows_mut(coordinates, coordinates)
                .copy_from(&(product(&errors.stiffness, &upper) + product(&errors.damping, &lower)));
            noise
        };
        let size = |of_term: &[f64; 4]| {
            let [value, slope, curvature, beyond] = of_term.map(f64::abs);
            [value + step * (slope + step * curvature), beyond]
        };
        let sizes: Vec<[f64; 2]> = series.iter().map(size).collect();
        let mut off = [0.0; 2];
        for (index, (asymmetry, [size, beyond])) in asymmetries.iter().zip(&sizes).enumerate() {
            off[usize::from(!problem.is_damping(index))] += asymmetry * (size + beyond);
        }
        let [damping, stiffness] = off;
        let asymmetry = |i: usize| {
            let [upper, lower] = [0, coordinates].map(|from| right.column(i).rows(from, coordinates).norm());
            left.row(i).columns(coordinates, coordinates).norm() * (damping * lower + stiffness * upper)
        };
        let asymmetry = (0..states).map(asymmetry).collect();
        let of_rounding: Vec<f64> = sizes.iter().map(|[size, _]| ROUNDING * size).collect();
        let mut rest = product(&left, &(residual + noise(&of_rounding, ROUNDING)));
        let rounding = rest.diagonal().iter().copied().collect();
        // What the path has beyond its second order.
        let beyond = of_order(3);
        if beyond.iter().any(|value| *value != 0.0) {
            rest += product(&left, &noise(&beyond, 0.0));
        }

        let first = in_basis(&problem.at(&of_order(1)));
        let second = of_order(2);
        let second = second.iter().any(|value| *value != 0.0).then(|| in_basis(&problem.at(&second)));
        // Y X is 1 but for rounding.
        let mut changes = first.map(magnitude) * step;
        if let Some(second) = &second {
            changes += second.map(magnitude) * (step * step);
        }
        rest += product(&(product(&left, &right) * ROUNDING), &changes);
        Some(Self { first, second, eigenvalues, rest, rounding, asymmetry })
    }

    /// E, by which vectors are turned over steps up to `step`, and D, what is left of first order: of each two eigenvalues that what
    /// couples them moves little against their distance, `E_ij = (Y A_1 X)_ij / (lambda_j - lambda_i)`; of others `D_ij`.
    fn turns(&self, step: f64) -> [ComplexMatrix; 2] {
        let states = self.eigenvalues.len();
        let [mut turns, mut direct] = [(); 2].map(|()| ComplexMatrix::zeros(states, states));
        for j in 0..states {
            for i in (0..states).filter(|i| *i != j) {
                let (coupling, gap) = (self.first[(i, j)], self.eigenvalues[j] - self.eigenvalues[i]);
                if coupling == Complex::from(0.0) {
                    continue;
                }
                if magnitude(gap) > 0.0 && step * magnitude(coupling) <= TURNED * magnitude(gap) {
                    turns[(i, j)] = coupling / gap;
                } else {
                    direct[(i, j)] = coupling;
                }
            }
        }
        [turns, direct]
    }

    /// Discs for all steps from `-step` to `step`; nothing where the vectors turn too much.
    ///
    /// `(1 + d E)^-1 Y A X (1 + d E)` has the eigenvalues of A. It is `diag(lambda) + (1 + d E)^-1 (d (S + D) + d^2 (B + F E) + d^3 B E)`
    /// and a rest, with `F = Y A_1 X`, its diagonal S, and `B = Y A_2 X`. To second order that leaves D outside of the diagonal;
    /// Gershgorin's discs, scaled, are small where it is.
    pub(super) fn discs(&self, step: f64) -> Option<Discs> {
        let states = self.eigenvalues.len();
        let [turns, direct] = self.turns(step);
        let slopes: Vec<Complex<f64>> = self.first.diagonal().iter().copied().collect();
        let turn = Split::new(&turns);
        let mut second = Split::new(&self.first).times(&turn) - turn.times(&Split::new(&direct));
        for (j, mut column) in second.column_iter_mut().enumerate() {
            column -= turns.column(j) * slopes[j];
        }
        let mut third = ComplexMatrix::zeros(states, states);
        if let Some(own) = &self.second {
            second += own;
            third += Split::new(own).times(&turn);
        }
        third -= turn.times(&Split::new(&second));
        let fourth = |i: usize| -(0..states).map(|k| turns[(i, k)] * third[(k, i)]).sum::<Complex<f64>>();

        let square = step * step;
        let powers = [step, square, square * step, square * square];
        // The sum of the powers of d |E| is (1 - d |E|)^-1, if there is a positive vector that 1 - d |E| leaves positive.
        let sizes = turns.map(magnitude) * step;
        let powers_of_sizes = (DMatrix::identity(states, states) - &sizes).lu();
        let vector = powers_of_sizes.solve(&DVector::from_element(states, 1.0))?;
        let left = &vector - &sizes * &vector;
        if !vector.iter().chain(&left).all(|entry| *entry > 0.0) {
            return None;
        }
        // All from the fourth order on, and the rest.
        let rest = &self.rest + product(&self.rest, &sizes);
        let beyond = powers_of_sizes.solve(&(product(&sizes, &third.map(magnitude)) * powers[2] + &rest))?;
        let beyond = beyond.map(|entry| if entry < 0.0 { 0.0 } else { entry });
        let mut outside = DMatrix::from_fn(states, states, |i, j| {
            let of = [magnitude(direct[(i, j)]), magnitude(second[(i, j)]), magnitude(third[(i, j)])];
            of.iter().zip(powers).map(|(entry, power)| entry * power).sum::<f64>() + beyond[(i, j)]
        });
        outside.fill_diagonal(0.0);
        // What a centre has not: all from the fifth order on, and the rest.
        let own = |i: usize| rest[(i, i)] + (0..states).map(|k| sizes[(i, k)] * beyond[(k, i)]).sum::<f64>();
        let own: Vec<f64> = (0..states).map(own).collect();
        let centre = |i: usize| [self.eigenvalues[i], slopes[i], second[(i, i)], third[(i, i)], fourth(i)];
        let centres: Vec<[Complex<f64>; 5]> = (0..states).map(centre).collect();
        if outside.iter().chain(&own).any(|value| !value.is_finite()) {
            return None;
        }
        let apart = DMatrix::from_fn(states, states, |i, j| {
            if i == j {
                return f64::INFINITY;
            }
            let [gap, moves @ ..] = [0, 1, 2, 3, 4].map(|order| magnitude(centres[i][order] - centres[j][order]));
            gap - moves.iter().zip(powers).map(|(moved, power)| moved * power).sum::<f64>() - own[i] - own[j]
        });
        let (rounding, asymmetry) = (self.rounding.clone(), self.asymmetry.clone());
        let mut discs = Discs { step, centres, outside, own, apart, rounding, asymmetry, radii: Vec::new() };
        discs.radii = discs.isolated();
        Some(discs)
    }
}

/// A disc that holds exactly one eigenvalue, or one of a cluster that hold as many as they are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Isolated {
    /// Its radius.
    pub(super) radius: f64,
    /// The least distance of its centre, or of those of the cluster, from those of all others.
    pub(super) gap: f64,
    /// The first disc of the cluster.
    pub(super) first: usize,
    /// How many discs the cluster has.
    pub(super) cluster: usize,
}

/// What holds the eigenvalues over an interval from `-step` to `step` about a place.
pub(super) struct Discs {
    pub(super) step: f64,
    /// The coefficients of the centres by powers of the step.
    pub(super) centres: Vec<[Complex<f64>; 5]>,
    /// Bounds of what couples one with another.
    outside: DMatrix<f64>,
    /// By how much a centre may be off.
    pub(super) own: Vec<f64>,
    /// Lower bounds of the distances of centres.
    apart: DMatrix<f64>,
    /// About the part of `own` that does not become smaller with the interval.
    pub(super) rounding: Vec<f64>,
    /// See [`Expansion`].
    pub(super) asymmetry: Vec<f64>,
    /// Those that are apart from all others.
    pub(super) radii: Vec<Option<Isolated>>,
}

impl Discs {
    /// The discs that are apart from all others. A row is scaled by t, so that its own disc shrinks by that and the others
    /// grow by what it couples with them.
    fn isolated(&self) -> Vec<Option<Isolated>> {
        let states = self.own.len();
        let sums: Vec<f64> = self.outside.row_iter().map(|row| row.sum()).collect();
        let alone = |i: usize| {
            let gap = (0..states).map(|j| self.apart[(i, j)]).fold(f64::INFINITY, f64::min);
            let scale = (0..states).filter(|j| *j != i).map(|j| {
                let room = self.apart[(i, j)] - SHARE * gap - sums[j];
                if self.outside[(j, i)] > 0.0 { room / self.outside[(j, i)] } else { room.signum() * LARGEST_SCALE }
            });
            let scale = scale.fold(LARGEST_SCALE, f64::min);
            let radius = sums[i] / scale;
            (gap > 0.0 && scale > 0.0 && radius <= SHARE * gap).then_some(Isolated {
                radius: radius + self.own[i],
                gap,
                first: i,
                cluster: 1,
            })
        };
        let mut radii: Vec<Option<Isolated>> = (0..states).map(alone).collect();
        for i in 0..states {
            if radii[i].is_some() {
                continue;
            }
            for (index, isolated) in self.cluster(i, &sums) {
                radii[index] = Some(isolated);
            }
        }
        radii
    }

    /// Eigenvalues that are nearly one, whose rows are scaled together; none where they are not apart from the others.
    fn cluster(&self, of: usize, sums: &[f64]) -> Vec<(usize, Isolated)> {
        let value = |i: usize| self.centres[i][0];
        let within = |i: usize| CLUSTER * magnitude(value(of)) + self.rounding[i] + self.rounding[of];
        let is_near = |i: &usize| magnitude(value(*i) - value(of)) <= within(*i);
        let (own, others): (Vec<usize>, Vec<usize>) = (0..self.own.len()).partition(is_near);
        if own.len() < 2 || own.len() > LARGEST_CLUSTER {
            return Vec::new();
        }
        let distance = |j: &usize| own.iter().map(|&i| self.apart[(i, *j)]).fold(f64::INFINITY, f64::min);
        let gap = others.iter().map(distance).fold(f64::INFINITY, f64::min);
        let scale = others.iter().map(|j| {
            let room = distance(j) - SHARE * gap - sums[*j];
            let coupled: f64 = own.iter().map(|&i| self.outside[(*j, i)]).sum();
            if coupled > 0.0 { room / coupled } else { room.signum() * LARGEST_SCALE }
        });
        let scale = scale.fold(LARGEST_SCALE, f64::min);
        if !(gap > 0.0 && scale > 0.0) {
            return Vec::new();
        }
        let sum = |i: usize, over: &[usize]| over.iter().map(|&j| self.outside[(i, j)]).sum::<f64>();
        let radii: Vec<f64> = own.iter().map(|&i| sum(i, &others) / scale + sum(i, &own)).collect();
        if radii.iter().any(|radius| *radius > SHARE * gap) {
            return Vec::new();
        }
        let isolated = |(&index, radius): (&usize, f64)| {
            (index, Isolated { radius: radius + self.own[index], gap, first: own[0], cluster: own.len() })
        };
        own.iter().zip(radii).map(isolated).collect()
    }

    /// Whether there are discs within these radii that hold, in any union of discs that is apart from the others, as many
    /// eigenvalues as it has discs. `(1 - diag(1 / r) O) s = 1` gives the scales.
    pub(super) fn hold_within(&self, allowed: &[f64]) -> bool {
        if !allowed.iter().all(|radius| *radius > 0.0) {
            return false;
        }
        let states = allowed.len();
        let matrix =
            DMatrix::from_fn(states, states, |i, j| f64::from(u8::from(i == j)) - self.outside[(i, j)] / allowed[i]);
        let Some(scales) = matrix.lu().solve(&DVector::from_element(states, 1.0)) else { return false };
        let coupled = &self.outside * &scales;
        scales.iter().all(|scale| *scale > 0.0 && *scale < LARGEST_SCALE)
            && coupled
                .iter()
                .zip(scales.iter())
                .zip(allowed)
                .all(|((coupled, scale), allowed)| coupled / scale < *allowed)
    }

    /// The least distance of two centres.
    pub(super) fn distance(&self, i: usize, j: usize) -> f64 {
        self.apart[(i, j)]
    }
}

#[cfg(test)]
mod tests;
