//! Small problems against dense eigenvalues and closed forms.

use faer::linalg::matmul::matmul;
use faer::sparse::{SparseColMat, Triplet};
use faer::{Accum, Mat, Par};
use nalgebra::DMatrix;

use super::along::Along;
use super::audit::missing;
use super::band::{Band, KrylovLimit};
use super::has_common_instructions;
use super::quadratic::{Coefficients, Side, SparseQuadratic};
use super::reduction::{Recipe, Reduced};
use crate::model::critical_values::evenly;
use crate::models::matrices::branches::{Branches, Followed, Line, Path, Target};
use crate::models::matrices::error::Error;
use crate::models::matrices::pair::{Complex, Pair};
use crate::models::matrices::region::{RESOLUTION, Region, damping_ratio, magnitude};
use crate::models::matrices::sweep::{Nodes, Steps};
use crate::numerics::eigenvalues::eigenvalues;

type Sparse = SparseColMat<usize, f64>;

fn sparse(size: usize, entries: &[(usize, usize, f64)]) -> Sparse {
    let entries: Vec<_> = entries.iter().map(|&(row, col, val)| Triplet { row, col, val }).collect();
    Sparse::try_new_from_triplets(size, size, &entries).unwrap()
}

/// A chain of masses between walls, springs that stiffen along it, dashpots, and friction that couples masses two places apart,
/// not symmetrically.
struct Chain {
    mass: Sparse,
    damping: Vec<Sparse>,
    stiffness: Vec<Sparse>,
}

impl Chain {
    fn new(size: usize) -> Self {
        let spring = |index: usize| 1e6 * (1.0 + 0.3 * index as f64 / size as f64);
        let mut stiffness = Vec::new();
        for index in 0..size {
            stiffness.push((index, index, spring(index) + spring(index + 1)));
            if index + 1 < size {
                stiffness.push((index, index + 1, -spring(index + 1)));
                stiffness.push((index + 1, index, -spring(index + 1)));
            }
        }
        let masses: Vec<_> = (0..size).map(|index| (index, index, 1.0 + 0.1 * (index % 3) as f64)).collect();
        let dashpots: Vec<_> = (0..size).map(|index| (index, index, 2.0 + (index % 5) as f64)).collect();
        let friction: Vec<_> = (0..size)
            .step_by((size / 4).max(7))
            .flat_map(|index| [(index, index + 2, 2e5), (index + 2, index, -2e5)])
            .filter(|(row, col, _)| row.max(col) < &size)
            .collect();
        Self {
            mass: sparse(size, &masses),
            damping: vec![sparse(size, &dashpots)],
            stiffness: vec![sparse(size, &stiffness), sparse(size, &friction)],
        }
    }

    fn matrices(&self) -> SparseQuadratic {
        SparseQuadratic::new(&self.mass, &self.damping, &self.stiffness).unwrap()
    }

    /// All eigenvalues by a dense method, of upper half plane.
    fn dense(&self, coefficients: &Coefficients) -> Vec<Complex> {
        let size = self.mass.nrows();
        let sum = |terms: &[Sparse], factors: &[f64]| {
            let mut sum = DMatrix::<f64>::zeros(size, size);
            for (term, factor) in terms.iter().zip(factors) {
                for entry in term.triplet_iter() {
                    sum[(entry.row, entry.col)] += factor * entry.val;
                }
            }
            sum
        };
        let inverse =
            DMatrix::from_diagonal(&sum(std::slice::from_ref(&self.mass), &[1.0]).diagonal().map(|m| 1.0 / m));
        let stiffness: DMatrix<f64> = &inverse * sum(&self.stiffness, &coefficients.stiffness);
        let damping: DMatrix<f64> = &inverse * sum(&self.damping, &coefficients.damping);
        companion_eigenvalues(&stiffness, &damping)
    }
}

/// All eigenvalues of `lambda^2 + lambda C + K` in the upper half plane.
fn companion_eigenvalues(stiffness: &DMatrix<f64>, damping: &DMatrix<f64>) -> Vec<Complex> {
    let (size, scale) = (stiffness.nrows(), 1000.0);
    let mut companion = DMatrix::zeros(2 * size, 2 * size);
    companion.view_mut((0, size), (size, size)).fill_with_identity();
    companion.view_mut((size, 0), (size, size)).copy_from(&(stiffness / (-scale * scale)));
    companion.view_mut((size, size), (size, size)).copy_from(&(damping / -scale));
    let values = eigenvalues(&companion).unwrap();
    values.into_iter().map(|value| value * scale).filter(|value| value.im > 0.0).collect()
}

/// How sweeps of these problems look for changes.
const STEPS: Steps = Steps { joined: 1, halvings: 30, most: 300, widest_first: false };

fn friction(factor: f64) -> Coefficients {
    Coefficients { damping: vec![1.0], stiffness: vec![1.0, factor] }
}

fn limit(vectors: usize) -> KrylovLimit {
    KrylovLimit { vectors }
}

#[test]
fn all_pairs_of_a_band_are_those_of_a_dense_method() {
    let chain = Chain::new(90);
    let matrices = chain.matrices();
    let band = Band::between(300.0, 1700.0);
    // With few vectors the band has to be cut in parts.
    for (factor, vectors) in [(0.0, 120), (3.0, 120), (3.0, 80), (1.0, 60)] {
        let mut expected: Vec<_> =
            chain.dense(&friction(factor)).into_iter().filter(|value| band.contains(*value)).collect();
        expected.sort_by(|a, b| a.im.total_cmp(&b.im));
        let point = matrices.at(&friction(factor)).unwrap();
        let pairs = point.pairs_in(band, limit(vectors)).unwrap();
        assert!(expected.len() > 40);
        assert_eq!(pairs.len(), expected.len(), "{factor} {vectors}");
        for (pair, expected) in pairs.iter().zip(&expected) {
            let sensitivity = pair.left.iter().map(Complex::norm_sqr).sum::<f64>().sqrt();
            let allowed = 1e-8 + 1e-14 * 5e6 * sensitivity;
            assert!(magnitude(pair.eigenvalue - expected) < allowed, "{} {expected} {allowed}", pair.eigenvalue);
            assert!(pair.error < 1e-8 && pair.error > 0.0, "{}", pair.error);
            for (vector, side) in [(&pair.right, Side::Right), (&pair.left, Side::Left)] {
                let residual = point.residual(pair.eigenvalue, vector, side);
                let scale = vector.iter().map(Complex::norm_sqr).sum::<f64>().sqrt() * 1e6;
                assert!(residual.iter().map(Complex::norm_sqr).sum::<f64>().sqrt() < 1e-6 * scale);
            }
        }
    }
}

/// Far above the axis many eigenvalues are nearly as far from a shift as the nearest, and none converges: a part of the band
/// there has no pair all the same.
#[test]
fn a_band_that_reaches_far_from_all_pairs_is_searched() {
    let chain = Chain::new(160);
    let band = Band { low: 1500.0, high: 1540.0, least_damping: -0.6, most_damping: 0.05 };
    let expected = chain.dense(&friction(0.0)).into_iter().filter(|value| band.contains(*value)).count();
    let matrices = chain.matrices();
    let pairs = matrices.at(&friction(0.0)).unwrap().pairs_in(band, limit(64)).unwrap();
    assert!(expected > 1);
    assert_eq!(pairs.len(), expected);
}

/// Strong friction makes pairs grow by more than twice a cycle. In any band the unstable ones are those of all eigenvalues.
#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn pairs_that_grow_fast_are_found() {
    let (mut fast, mut slow) = (0, 0);
    for size in [30, 90] {
        let chain = Chain::new(size);
        let matrices = chain.matrices();
        for factor in [1.0, 6.0, 20.0, 40.0, 100.0] {
            let coefficients = friction(factor);
            let all = chain.dense(&coefficients);
            let point = matrices.at(&coefficients).unwrap();
            for [lowest, highest] in
                [[200.0, 2500.0], [700.0, 1000.0], [1200.0, 1900.0], [2000.0, 8000.0], [10.0, 900.0]]
            {
                let region = Region { lowest, highest, damping_ratio: 0.0 };
                let of = |values: &mut dyn Iterator<Item = Complex>| {
                    let mut values: Vec<_> = values.filter(|value| region.contains(*value)).collect();
                    values.sort_by(|a, b| a.im.total_cmp(&b.im));
                    values
                };
                let expected = of(&mut all.iter().copied());
                let found = point.pairs_about(&region, KrylovLimit::default()).unwrap();
                let found = of(&mut found.iter().map(|pair| pair.eigenvalue));
                assert_eq!(found.len(), expected.len(), "{size} {factor} {region:?}");
                for (found, expected) in found.iter().zip(&expected) {
                    assert!(magnitude(found - expected) < 1e-6 * magnitude(*expected), "{found} {expected}");
                    let is_fast = damping_ratio(*expected) < -0.3;
                    fast += usize::from(is_fast);
                    slow += usize::from(!is_fast);
                }
            }
        }
    }
    assert!(fast > 25 && slow > 100, "{fast} {slow}");
}

#[test]
fn double_eigenvalues_of_a_ring_are_found_twice() {
    let size = 60;
    let mut stiffness = Vec::new();
    for index in 0..size {
        let next = (index + 1) % size;
        stiffness.extend([(index, index, 2.01e6), (index, next, -1e6), (next, index, -1e6)]);
    }
    let unit: Vec<_> = (0..size).map(|index| (index, index, 1.0)).collect();
    let (unit, stiffness) = (sparse(size, &unit), sparse(size, &stiffness));
    let matrices = SparseQuadratic::new(&unit, std::slice::from_ref(&unit), &[stiffness]).unwrap();
    let point = matrices.at(&Coefficients { damping: vec![4.0], stiffness: vec![1.0] }).unwrap();
    let pairs = point.pairs_in(Band::between(50.0, 1500.0), limit(120)).unwrap();
    // lambda^2 + 4 lambda + 1e6 (2.01 - 2 cos(2 pi k / n)) = 0.
    let mut expected: Vec<f64> = (0..size)
        .map(|k| 1e6 * (2.01 - 2.0 * (2.0 * std::f64::consts::PI * k as f64 / size as f64).cos()))
        .map(|square| (square - 4.0).sqrt())
        .filter(|frequency| *frequency < 1500.0)
        .collect();
    expected.sort_by(f64::total_cmp);
    assert_eq!(pairs.len(), expected.len());
    for (pair, expected) in pairs.iter().zip(expected) {
        assert!(magnitude(pair.eigenvalue - Complex::new(-2.0, expected)) < 1e-8, "{} {expected}", pair.eigenvalue);
    }
}

#[test]
fn a_pair_is_refined_from_rough_vectors() {
    let chain = Chain::new(120);
    let matrices = chain.matrices();
    let band = Band::between(500.0, 700.0);
    let at = |factor: f64| matrices.at(&friction(factor)).unwrap();
    let start = at(0.1).pairs_in(band, limit(120)).unwrap();
    let point = at(0.12);
    let expected = chain.dense(&friction(0.12));
    for pair in &start {
        let refined = point.refine(pair).unwrap();
        let nearest = expected.iter().map(|value| magnitude(value - refined.eigenvalue)).fold(f64::INFINITY, f64::min);
        assert!(nearest < 1e-9, "{nearest}");
        assert!(magnitude(refined.eigenvalue - pair.eigenvalue) < 5.0);
    }
    let near = at(0.1).factorise(start[0].eigenvalue).unwrap();
    assert!(matches!(point.refine_with(&near, &start[0]), Err(Error::Request(_))));
}

#[test]
fn sensitivities_are_differences() {
    let chain = Chain::new(50);
    let matrices = chain.matrices();
    let path = Line { from: vec![1.0, 1.0, 0.0], direction: vec![0.5, 0.0, 1.0] };
    let along = Along { matrices: &matrices, path: &path, limit: limit(120) };
    let band = Band::between(300.0, 500.0);
    let branches: &dyn Branches = &along;
    for pair in along.point(0.1).unwrap().pairs_in(band, limit(120)).unwrap() {
        let here = Followed::new(0.1, pair, &*branches.at(0.1).unwrap());
        let step = 1e-4;
        let [above, below] = [0.1 + step, 0.1 - step].map(|p| branches.follow(&here, p).unwrap().pair);
        let difference = (above.eigenvalue - below.eigenvalue) / (2.0 * step);
        assert!(magnitude(difference - here.slope) < 1e-4 * magnitude(here.slope), "{difference} {}", here.slope);
        let ratio = (above.damping_ratio() - below.damping_ratio()) / (2.0 * step);
        assert!((ratio - here.damping_ratio_slope()).abs() < 1e-3 * ratio.abs(), "{ratio}");
    }
}

/// Hoffmann and Gaul (2003): `K = [[k11, k12 - D], [k12, k22]]`, `C = diag(c1, c2)`, with the critical D by Routh and Hurwitz.
#[test]
fn two_coupled_masses_flutter_at_the_closed_form() {
    let unit = sparse(2, &[(0, 0, 1.0), (1, 1, 1.0)]);
    for (k22, c1, c2) in [(2.0_f64, 0.02_f64, 0.03_f64), (2.2, 0.001, 0.01), (2.2, 0.02, 0.02)] {
        let damping = sparse(2, &[(0, 0, c1), (1, 1, c2)]);
        let stiffness = sparse(2, &[(0, 0, 2.0), (0, 1, 1.0), (1, 0, 1.0), (1, 1, k22)]);
        let coupling = sparse(2, &[(0, 1, -1.0)]);
        let matrices = SparseQuadratic::new(&unit, &[damping], &[stiffness, coupling]).unwrap();
        let path = Line { from: vec![1.0, 1.0, 0.0], direction: vec![0.0, 0.0, 1.0] };
        let along = Along { matrices: &matrices, path: &path, limit: limit(20) };
        let (a3, a2, a1) = (c1 + c2, 2.0 + k22 + c1 * c2, c1 * k22 + c2 * 2.0);
        let expected = a1 * (a3 * a2 - a1) / (a3 * a3) - (2.0 * k22 - 1.0);
        let region = Region { lowest: 0.5, highest: 3.0, damping_ratio: 0.0 };
        let sweep = Nodes::new(&along, &region).sweep(&evenly([0.2, 1.9], 4), STEPS).unwrap();
        assert_eq!((sweep.at_start, sweep.changes.len(), &sweep.unresolved[..]), (0, 1, &[][..]), "{k22} {c1} {c2}");
        let change = &sweep.changes[0];
        let later = -RESOLUTION / change.at.damping_ratio_slope();
        assert!((change.p - later - expected).abs() < 1e-10, "{} {expected}", change.p);
        assert!(change.more == 2 && matches!(change.target, Target::DampingRatio(_)));
        let intervals = sweep.intervals(0.2, 1.9);
        assert_eq!(intervals.iter().map(|(_, count)| *count).collect::<Vec<_>>(), [Some(0), Some(2)]);
    }
}

#[test]
fn a_sweep_finds_all_changes_of_a_chain() {
    let chain = Chain::new(60);
    let matrices = chain.matrices();
    let path = Line { from: vec![1.0, 1.0, 0.0], direction: vec![0.0, 0.0, 1.0] };
    let along = Along { matrices: &matrices, path: &path, limit: limit(120) };
    let region = Region { lowest: 300.0, highest: 700.0, damping_ratio: 0.0 };
    let [low, high] = [2.0, 4.0];
    let sweep = Nodes::new(&along, &region).sweep(&evenly([low, high], 4), STEPS).unwrap();
    let unstable = |p: f64| {
        chain
            .dense(&Coefficients::split(&path.coefficients(p), 1))
            .iter()
            .filter(|value| (300.0..=700.0).contains(&value.im) && damping_ratio(**value) < 0.0)
            .count()
            * 2
    };
    assert!(sweep.changes.len() > 1, "{}", sweep.changes.len());
    for ([from, to], count) in sweep.intervals(low, high) {
        let Some(count) = count else { panic!("not followed from {from} to {to}") };
        for share in [0.01, 0.5, 0.99] {
            assert_eq!(unstable(from + share * (to - from)), count, "{from} {to} {share}");
        }
    }
}

#[test]
fn unfit_matrices_and_requests_are_refused() {
    let (two, three) = (sparse(2, &[(0, 0, 1.0)]), sparse(3, &[(0, 0, 1.0)]));
    assert_eq!(SparseQuadratic::new(&two, &[], &[three]).unwrap_err(), Error::Size { rows: 3, columns: 3, size: 2 });
    assert_eq!(SparseQuadratic::new(&sparse(1, &[(0, 0, f64::NAN)]), &[], &[]).unwrap_err(), Error::NotFinite);
    let matrices = SparseQuadratic::new(&two, &[], std::slice::from_ref(&two)).unwrap();
    let coefficients = |stiffness: &[f64]| Coefficients { damping: vec![], stiffness: stiffness.to_vec() };
    assert_eq!(matrices.at(&coefficients(&[])).unwrap_err(), Error::Coefficients { given: 0, expected: 1 });
    let point = matrices.at(&coefficients(&[1.0])).unwrap();
    let band = Band::between(2.0, 1.0);
    assert!(matches!(point.pairs_in(band, limit(4)), Err(Error::Request(_))));
    // The second row and column are empty.
    assert!(matches!(point.pairs_in(Band { high: 3.0, ..band }, limit(4)), Err(Error::Singular { .. })));
}

/// The eigenvalues of a reduced problem of unit mass, and its pairs from the left and right null vectors.
fn dense_reduced(reduced: &Reduced, coefficients: &Coefficients) -> Vec<Complex> {
    let sum = |terms: &[DMatrix<f64>], factors: &[f64]| {
        let zero = DMatrix::<f64>::zeros(reduced.mass.nrows(), reduced.mass.nrows());
        terms.iter().zip(factors).fold(zero, |sum, (term, factor)| sum + term * *factor)
    };
    companion_eigenvalues(
        &sum(&reduced.stiffness, &coefficients.stiffness),
        &sum(&reduced.damping, &coefficients.damping),
    )
}

#[test]
fn modes_of_a_uniform_chain_are_sines() {
    let size = 100;
    let mut stiffness = Vec::new();
    for index in 0..size {
        stiffness.push((index, index, 2e6));
        if index + 1 < size {
            stiffness.extend([(index, index + 1, -1e6), (index + 1, index, -1e6)]);
        }
    }
    let unit: Vec<_> = (0..size).map(|index| (index, index, 1.0)).collect();
    let matrices = SparseQuadratic::new(&sparse(size, &unit), &[], &[sparse(size, &stiffness)]).unwrap();
    let point = matrices.at(&Coefficients { damping: vec![], stiffness: vec![1.0] }).unwrap();
    let modes = point.modes(1000.0, 100).unwrap();
    let angle = |k: usize| std::f64::consts::PI * k as f64 / (2.0 * (size as f64 + 1.0));
    assert_eq!(modes.len(), (1..=size).filter(|&k| 2000.0 * angle(k).sin() <= 1000.0).count());
    for (index, mode) in modes.iter().enumerate() {
        let frequency = 2000.0 * angle(index + 1).sin();
        assert!((mode.square.sqrt() - frequency).abs() < 1e-7, "{} {frequency}", mode.square.sqrt());
        let length: f64 = mode.shape.iter().map(|value| value * value).sum();
        assert!((length - 1.0).abs() < 1e-10);
    }
    // All modes at once: the space is complete.
    assert_eq!(point.modes(3000.0, 100).unwrap().len(), 100);
}

#[test]
fn a_reduction_keeps_the_eigenvalues_of_the_band_between_its_points() {
    let chain = Chain::new(150);
    let matrices = chain.matrices();
    let band = Band::between(150.0, 350.0);
    let recipe =
        Recipe { points: vec![friction(1.5), friction(0.5), friction(2.5)], band, vectors: 70, modes_up_to: 2.0 };
    let reduction = matrices.reduction(&recipe, KrylovLimit::default()).unwrap();
    assert_eq!(reduction.basis.ncols(), 70);
    assert_eq!(reduction.from_pairs + reduction.from_statics + reduction.from_modes, 70);
    let reduced = matrices.reduced(&reduction.basis);
    assert!((&reduced.mass - DMatrix::identity(70, 70)).amax() < 1e-12);
    for (factor, allowed) in [(1.5, 1e-9), (0.5, 1e-9), (1.0, 1e-5), (2.2, 1e-5)] {
        let coefficients = friction(factor);
        let values = dense_reduced(&reduced, &coefficients);
        let pairs = matrices.at(&coefficients).unwrap().pairs_in(band, KrylovLimit::default()).unwrap();
        assert!(pairs.len() > 8);
        let full: Vec<Complex> = pairs.iter().map(|pair| pair.eigenvalue).collect();
        assert_eq!(missing(&full, &values, allowed), [0; 0], "{factor}");
        for pair in &pairs {
            assert!(matrices.captured(&reduction.basis, &pair.right) > 1.0 - 1e-4);
        }
    }
    // Modes alone, few of them, miss some.
    let point = matrices.at(&friction(2.2)).unwrap();
    let modes = point.modes(200.0, 100).unwrap();
    let poor = DMatrix::from_fn(150, modes.len(), |row, column| modes[column].shape[row]);
    let pairs = point.pairs_in(band, KrylovLimit::default()).unwrap();
    let values = dense_reduced(&matrices.reduced(&poor), &friction(2.2));
    let full: Vec<Complex> = pairs.iter().map(|pair| pair.eigenvalue).collect();
    let lost = missing(&full, &values, 0.01);
    let beyond: Vec<usize> = (0..pairs.len()).filter(|&index| pairs[index].eigenvalue.im > 210.0).collect();
    assert!(!beyond.is_empty() && beyond.iter().all(|index| lost.contains(index)), "{lost:?} {beyond:?}");
    for index in beyond {
        assert!(matrices.captured(&poor, &pairs[index].right) < 0.9);
    }
}

#[test]
fn a_reduced_pair_is_lifted_to_the_full_one() {
    let chain = Chain::new(150);
    let matrices = chain.matrices();
    let point = matrices.at(&friction(1.0)).unwrap();
    let pairs = point.pairs_in(Band::between(150.0, 350.0), KrylovLimit::default()).unwrap();
    let modes = point.modes(600.0, 150).unwrap();
    let basis = DMatrix::from_fn(150, modes.len(), |row, column| modes[column].shape[row]);
    for pair in &pairs {
        // Unit mass by the modes: coordinates are V^T M x.
        let coordinates = |vector: &[Complex]| {
            let parts: [Vec<f64>; 2] =
                [vector.iter().map(|value| value.re).collect(), vector.iter().map(|value| value.im).collect()];
            let [re, im] =
                parts.map(|part| basis.transpose() * nalgebra::DVector::from_vec(matrices.mass_times(&part)));
            re.iter().zip(im.iter()).map(|(re, im)| Complex::new(*re, *im)).collect::<Vec<_>>()
        };
        let rough = Pair {
            eigenvalue: pair.eigenvalue * 1.001,
            right: coordinates(&pair.right),
            left: coordinates(&pair.left),
            error: f64::INFINITY,
        };
        let lifted = point.lifted(&basis, &rough).unwrap();
        assert!(magnitude(lifted.eigenvalue - pair.eigenvalue) < 1e-8, "{} {}", lifted.eigenvalue, pair.eigenvalue);
    }
    let none = Pair { right: vec![], left: vec![], ..pairs[0].clone() };
    assert!(matches!(point.lifted(&basis, &none), Err(Error::Request(_))));
}

/// On this rests that AVX-512 and AVX2 give the same bits: however wide its vectors, faer sums a product in one chain.
#[test]
fn sums_of_products_are_single_chains_of_fused_operations() {
    if !has_common_instructions() {
        return;
    }
    // Larger than what is computed without vectors of the widest kind, and with every number of rows left over.
    for size in 33..=60_usize {
        let entries = |seed: usize| {
            Mat::from_fn(size, size, |row, column| 1.0 / (1.0 + ((31 * row + 17 * column + seed) % 97) as f64) - 0.1)
        };
        let (left, right) = (entries(3), entries(50));
        let mut product = Mat::<f64>::zeros(size, size);
        matmul(&mut product, Accum::Replace, left.as_ref(), right.as_ref(), 1.0, Par::Seq);
        for row in 0..size {
            for column in 0..size {
                let chain = (0..size).fold(0.0, |sum, k| libm::fma(left[(row, k)], right[(k, column)], sum));
                assert_eq!(product[(row, column)].to_bits(), chain.to_bits(), "{size}: {row}, {column}");
            }
        }
    }
}
