//! The pairs of a problem of dense matrices along a path of parameters.

use nalgebra::DVector;

use super::branches::{Branches, Images, Path, Place};
use super::eigenbasis::{Eigenbasis, WORST_CONDITION};
use super::error::Error;
use super::pair::{Complex, Pair};
use super::quadratic::{DenseQuadratic, Quadratic, product};
use super::region::Region;

/// A path through the coefficients of a problem. Eigenvalues are in the unit of the problem.
pub(super) struct DenseBranches<'a> {
    pub(super) problem: &'a DenseQuadratic,
    pub(super) path: &'a dyn Path,
}

struct DensePlace {
    problem: Quadratic,
    /// C and K derived by the parameter of the path.
    derivative: Quadratic,
}

impl Branches for DenseBranches<'_> {
    fn at(&self, p: f64) -> Result<Box<dyn Place + '_>, Error> {
        let at = |coefficients: &[f64]| {
            let is_finite = coefficients.iter().all(|value| value.is_finite());
            if is_finite { Ok(self.problem.at(coefficients)) } else { Err(Error::NotFinite) }
        };
        Ok(Box::new(DensePlace { problem: at(&self.path.coefficients(p))?, derivative: at(&self.path.derivative(p))? }))
    }
}

impl Place for DensePlace {
    /// All eigenvalues that are not below the real axis and not known to be zero; those that are nearly defective without vectors.
    fn pairs(&self, _: &Region) -> Result<Vec<Pair>, Error> {
        let without_vectors =
            |eigenvalue| Pair { eigenvalue, right: Vec::new(), left: Vec::new(), error: f64::INFINITY };
        if let Some((basis, conditions)) = Eigenbasis::with_conditions(&self.problem) {
            let zeros = self.problem.known_zeros(&basis.eigenvalues);
            let is_upper = |place: &usize| basis.eigenvalues[*place].im >= 0.0 && !zeros.contains(place);
            let upper = (0..basis.eigenvalues.len()).filter(is_upper);
            let pair = |place: usize| {
                let eigenvalue = basis.eigenvalues[place];
                if conditions[place].is_nan() || conditions[place] > WORST_CONDITION {
                    return without_vectors(eigenvalue);
                }
                let (right, left) = (basis.right.column(place), basis.left.row(place));
                let slope = left.dot(&self.problem.derivative_times(eigenvalue, &right));
                self.problem.pair(eigenvalue, slope, right, &left)
            };
            return Ok(upper.map(pair).collect());
        }
        let not_converged = |_| Error::NotConverged { re: f64::NAN, im: f64::NAN };
        let values = self.problem.eigenvalues().map_err(not_converged)?;
        let zeros = self.problem.known_zeros(&values);
        let upper = values.into_iter().enumerate().filter(|(place, value)| value.im >= 0.0 && !zeros.contains(place));
        Ok(upper.map(|(_, value)| without_vectors(value)).collect())
    }

    fn refine(&self, start: &Pair) -> Result<Pair, Error> {
        let Complex { re, im } = start.eigenvalue;
        if start.right.is_empty() {
            return Err(Error::NotConverged { re, im });
        }
        self.problem.refine(start.clone()).ok_or(Error::NotConverged { re, im })
    }

    fn images(&self, pair: &Pair) -> Images {
        if pair.right.is_empty() {
            return Images::default();
        }
        let damped = product(&self.problem.damping, &DVector::from_column_slice(&pair.right));
        [pair.right.clone(), damped.as_slice().to_vec()]
    }

    fn coupling(&self, a: &Pair, b: &Pair) -> Complex {
        if a.right.is_empty() || b.right.is_empty() {
            return Complex::new(f64::INFINITY, f64::INFINITY);
        }
        let Quadratic { damping, stiffness, .. } = &self.derivative;
        let right = DVector::from_column_slice(&b.right);
        let mean = (a.eigenvalue + b.eigenvalue) * 0.5;
        let force = product(damping, &right) * mean + product(stiffness, &right);
        -DVector::from_column_slice(&a.left).dot(&force)
    }
}

#[cfg(test)]
mod tests {
    use std::cell::{Cell, RefCell};

    use nalgebra::{DMatrix, dmatrix};

    use super::*;
    use crate::model::critical_values::{Memory, NoMemory, OnInterval, evenly};
    use crate::models::matrices::branches::Line;
    use crate::models::matrices::covering::Covering;
    use crate::models::matrices::sweep::{Intervals, Nodes, Steps, Sweep};
    use crate::models::matrices::trial::problem;
    use crate::numerics::eigenvalues::Eigenvalue;

    const FIRST: usize = 6;

    const STEPS: Steps = Steps { joined: 3, halvings: 44, most: 1000, widest_first: false };

    fn sweep(problem: &DenseQuadratic, path: &Line, region: &Region, within: [f64; 2]) -> Sweep {
        Nodes::new(&DenseBranches { problem, path }, region).sweep(&evenly(within, FIRST), STEPS).unwrap()
    }

    /// A random problem, and the path along one of its coefficients.
    fn along_a_coefficient(seed: u64) -> (DenseQuadratic, Line, Region) {
        let (problem, mut from, region) = problem(seed);
        let coefficient = seed as usize % from.len();
        let mut direction = vec![0.0; from.len()];
        direction[coefficient] = 1.0;
        from[coefficient] = 0.0;
        (problem, Line { from, direction }, region)
    }

    /// Where these paths end.
    const HIGHEST: f64 = 4.0;

    /// Along each coefficient of random problems, the stretches with an unstable pair are those that all eigenvalues show.
    /// Returns how many changes there were, and problems with several stretches.
    fn compare(seeds: std::ops::Range<u64>, places: u32) -> [usize; 2] {
        let (mut changes, mut several) = (0, 0);
        for seed in seeds {
            let (problem, path, region) = along_a_coefficient(seed);
            let within = [0.0, HIGHEST];
            let found = sweep(&problem, &path, &region, within);
            changes += found.changes.len();
            let intervals: &mut dyn Intervals = &mut Covering::new(&problem, &path, &region);
            let unstable = intervals.unstable_values(&evenly(within, FIRST), STEPS, &NoMemory).unwrap();
            several += usize::from(unstable.surely.len() > 1);
            let wide: f64 = found.unresolved.iter().map(|([from, to], _)| to - from).sum();
            assert!(wide < 1e-6, "{seed}: {:?}", found.unresolved);
            for step in 0..=places {
                let p = HIGHEST * f64::from(step) / f64::from(places);
                let values = problem.at(&path.coefficients(p)).eigenvalues().unwrap();
                let is_clear = |value: &Eigenvalue| {
                    let with = |ratio: f64| Region { damping_ratio: region.damping_ratio + ratio, ..region };
                    with(-1e-11).contains(*value) == with(1e-11).contains(*value)
                };
                let contains = |set: &[[f64; 2]]| set.iter().any(|[from, to]| (*from..=*to).contains(&p));
                let expected = values.iter().any(|value| region.contains(*value));
                let is_right = [&unstable.surely, &unstable.possibly].into_iter().any(|set| contains(set) == expected);
                assert!(is_right || !values.iter().all(is_clear), "problem {seed} at {p}: {unstable:?}");
            }
        }
        [changes, several]
    }

    /// Remembers what was found, and finds no more than so much at once.
    struct UntilStopped<'a> {
        known: &'a RefCell<Vec<([f64; 2], OnInterval)>>,
        asked: Cell<usize>,
        left: Cell<usize>,
    }

    impl Memory for UntilStopped<'_> {
        fn next(&self, interval: [f64; 2], find: &mut dyn FnMut() -> Option<OnInterval>) -> Option<OnInterval> {
            let number = self.asked.replace(self.asked.get() + 1);
            if let Some((of, found)) = self.known.borrow().get(number) {
                assert_eq!(*of, interval, "another interval than before");
                return Some(found.clone());
            }
            self.left.set(self.left.get().checked_sub(1)?);
            let found = find()?;
            self.known.borrow_mut().push((interval, found.clone()));
            Some(found)
        }
    }

    #[test]
    fn a_search_that_is_stopped_again_and_again_finds_what_the_sweep_does() {
        let (mut several, mut halved) = (0, 0);
        for seed in 0..60 {
            let (problem, path, region) = along_a_coefficient(seed);
            let within = [0.0, HIGHEST];
            let intervals: &mut dyn Intervals = &mut Covering::new(&problem, &path, &region);
            let expected = intervals.unstable_values(&evenly(within, FIRST), STEPS, &NoMemory).unwrap();
            let all = sweep(&problem, &path, &region, within).unstable(within);
            let size = |set: &[[f64; 2]]| set.iter().map(|[from, to]| to - from).sum::<f64>();
            for (found, all) in [(&expected.surely, &all.surely), (&expected.possibly, &all.possibly)] {
                assert!((size(found) - size(all)).abs() < 1e-6, "{seed}: {found:?} {all:?}");
            }
            let known = RefCell::default();
            let sessions = (0..).map(|_| {
                let memory = UntilStopped { known: &known, asked: Cell::new(0), left: Cell::new(3) };
                intervals.unstable_values(&evenly(within, FIRST), STEPS, &memory)
            });
            let (number, found) = sessions.enumerate().find_map(|(number, found)| Some((number, found?))).unwrap();
            assert_eq!(found, expected, "{seed}");
            // Three intervals in each session but the last: none is searched twice.
            assert_eq!(number, (known.borrow().len() - 1) / 3, "{seed}");
            several += usize::from(found.surely.len() > 1);
            halved += known.borrow().iter().filter(|(_, found)| found.is_none()).count();
        }
        assert!(several > 0 && halved > 100, "{several} {halved}");
    }

    #[test]
    #[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
    fn sweeps_find_what_all_eigenvalues_show_at_many_places() {
        let [changes, several] = compare(0..300, 200);
        assert!(changes > 25 && several > 4, "{changes} {several}");
    }

    #[test]
    #[ignore = "takes minutes"]
    fn sweeps_of_many_problems_find_what_all_eigenvalues_show() {
        let [changes, several] = compare(1000..6000, 1000);
        assert!(changes > 1500 && several > 50, "{changes} {several}");
    }

    /// Two masses without damping: Hoffmann, Fischer, Allgaier and Gaul (2002), D = 4 mu / 3, and Hulten's as Sinou and
    /// Jezequel (2007). Both modes are undamped up to where they meet, where pairs have no derivative.
    #[test]
    fn undamped_masses_flutter_where_their_modes_meet() {
        let identity = DMatrix::identity(2, 2);
        let critical = |stiffness: &[DMatrix<f64>], highest: f64| {
            let problem = DenseQuadratic::new(&identity, &[], stiffness, &[1.0, 1.0]).unwrap();
            let region = Region { lowest: 0.0, highest, damping_ratio: 0.0 }.in_unit(problem.unit());
            let path = Line { from: vec![1.0, 0.0], direction: vec![0.0, 1.0] };
            let unstable = sweep(&problem, &path, &region, [0.0, 1.3]).unstable([0.0, 1.3]);
            let ([surely], [possibly]) = (&unstable.surely[..], &unstable.possibly[..]) else { panic!("{unstable:?}") };
            assert!(surely[0] - possibly[0] < 1e-8 && surely[1] == 1.3, "{unstable:?}");
            surely[0]
        };
        let hoffmann = [dmatrix![2.0, 1.0; 1.0, 2.0], dmatrix![0.0, -4.0 / 3.0; 0.0, 0.0]];
        assert!((critical(&hoffmann, f64::INFINITY) - 0.75).abs() < 1e-8);
        let [first, second] = [100.0, 75.0].map(|frequency: f64| (std::f64::consts::TAU * frequency).powi(2));
        let hulten = [dmatrix![first, 0.0; 0.0, second], dmatrix![0.0, -second; first, 0.0]];
        let expected = (first - second) / (2.0 * (first * second).sqrt());
        assert!((critical(&hulten, 1e4) - expected).abs() < 1e-8);
    }

    /// Two modes that cross, with friction so weak that they flutter over 1/2000 of the way only.
    #[test]
    fn a_narrow_island_is_found() {
        let stiffness = [dmatrix![1.0, 0.0; 0.0, 1.3], dmatrix![1.0, 0.0; 0.0, 0.0], dmatrix![0.0, 1e-4; -1e-4, 0.0]];
        let damping = [DMatrix::identity(2, 2) * 2e-5];
        let problem =
            DenseQuadratic::new(&DMatrix::identity(2, 2), &damping, &stiffness, &[1.0, 1.0, 1.0, 1.0]).unwrap();
        let region = Region { lowest: 0.1, highest: 10.0, damping_ratio: 0.0 }.in_unit(problem.unit());
        let path = Line { from: vec![1.0, 1.0, 0.0, 1.0], direction: vec![0.0, 0.0, 1.0, 0.0] };
        let found = sweep(&problem, &path, &region, [0.0, 1.0]);
        let [[from, to]] = found.unstable([0.0, 1.0]).surely[..] else { panic!("{found:?}") };
        // Undamped they flutter for |p - 0.3| < 2e-4.
        assert!(from > 0.2997 && from < 0.3 && to > 0.3 && to < 0.3003, "{from} {to}");
    }

    /// Two modes that cross and exchange their damping, weakly coupled: where they meet, both have the mean of their damping
    /// ratios, which is above the threshold. With couplings down to 1e-3 the stable window is 1/400 of an interval.
    #[test]
    fn a_narrow_window_of_stability_is_found() {
        for coupling in [0.1, 0.03, 0.01, 1e-3] {
            let stiffness = [dmatrix![1.0, coupling; coupling, 0.5], dmatrix![0.0, 0.0; 0.0, 1.0]];
            let ratios = [0.1 * coupling, 0.3 * coupling];
            let damping = [DMatrix::from_diagonal(&DVector::from_iterator(2, ratios.map(|ratio| 2.0 * ratio)))];
            let problem = DenseQuadratic::new(&DMatrix::identity(2, 2), &damping, &stiffness, &[1.0; 3]).unwrap();
            let region = Region { lowest: 0.1, highest: 10.0, damping_ratio: 0.15 * coupling }.in_unit(problem.unit());
            let path = Line { from: vec![1.0, 1.0, 0.0], direction: vec![0.0, 0.0, 1.0] };
            let intervals: &mut dyn Intervals = &mut Covering::new(&problem, &path, &region);
            let within = [0.0, 1.07];
            let found = intervals.unstable_values(&evenly(within, FIRST), STEPS, &NoMemory).unwrap();
            let [first, last] = found.surely[..] else { panic!("{coupling}: {found:?}") };
            // At their meeting the modes share both; stable is where the one of less damping has taken enough from the other.
            let is_stable = |p: f64| {
                let values = problem.at(&path.coefficients(p)).eigenvalues().unwrap();
                !values.iter().any(|value| region.contains(*value))
            };
            assert!(is_stable(0.5) && first[1] < 0.5 && last[0] > 0.5, "{coupling}: {found:?}");
            for (end, outwards) in [(first[1], -1.0), (last[0], 1.0)] {
                assert!(is_stable(end - outwards * 1e-6) && !is_stable(end + outwards * 1e-6), "{coupling}: {found:?}");
            }
        }
    }
}
