use nalgebra::{DMatrix, dmatrix, dvector};

use super::*;
use crate::model::critical_values::{NoMemory, evenly};
use crate::models::matrices::branches::Line;
use crate::models::matrices::decide::Decider;
use crate::models::matrices::series::ModeSeries;
use crate::models::matrices::sweep::Steps;
use crate::models::matrices::trial::Numbers;

const STEPS: Steps = Steps { joined: 3, halvings: 44, most: 1000, widest_first: true };

const ALL: Region = Region { lowest: 0.0, highest: f64::INFINITY, damping_ratio: 0.0 };

fn unstable(problem: &DenseQuadratic, path: &dyn Path, within: [f64; 2]) -> UnstableValues {
    let intervals: &mut dyn Intervals = &mut Covering::new(problem, path, &ALL);
    intervals.unstable_values(&evenly(within, 9), STEPS, &NoMemory).unwrap()
}

/// How much of a path is left open.
fn open(found: &UnstableValues) -> f64 {
    let [possibly, surely] =
        [&found.possibly, &found.surely].map(|set| set.iter().map(|[from, to]| to - from).sum::<f64>());
    possibly - surely
}

/// `q_1'' + 5 q_1' + (1 - p) q_1 = 0` diverges from p = 1 on, however stiff the other mode is.
#[test]
fn a_soft_mode_diverges_where_its_stiffness_ends_however_stiff_others_are() {
    for stiff in [1.0, 1e4, 1e8, 1e12] {
        let stiffness = [dmatrix![1.0, 0.0; 0.0, stiff], dmatrix![-1.0, 0.0; 0.0, 0.0]];
        let damping = [dmatrix![5.0, 0.0; 0.0, 1.0]];
        let problem = DenseQuadratic::new(&DMatrix::identity(2, 2), &damping, &stiffness, &[1.0; 3]).unwrap();
        let path = Line { from: vec![1.0, 1.0, 0.0], direction: vec![0.0, 0.0, 1.0] };
        let found = unstable(&problem, &path, [0.3, 1.5]);
        let ([surely], [possibly]) = (&found.surely[..], &found.possibly[..]) else { panic!("{stiff}: {found:?}") };
        for ends in [surely, possibly] {
            assert!((ends[0] - 1.0).abs() < 1e-8 && ends[1] == 1.5, "{stiff}: {found:?}");
        }
        let decider = Decider::of_any(&problem, &[ALL], None);
        for (p, expected) in [(1.0 - 3e-7, false), (1.0 + 3e-7, true)] {
            let found = decider.is_unstable(&path.coefficients(p)).map(|(is_unstable, _)| is_unstable);
            assert_eq!(found, Some(expected), "{stiff} {p}");
        }
    }
}

/// Between these ends a crossing is found, but its interval is not settled as a whole: it is halved.
#[test]
fn a_crossing_whose_interval_stays_wide_is_looked_at_in_parts() {
    let mass = dmatrix![0.445_103_723_763_575_27, 0.0; 0.0, 0.424_967_887_051_631_47];
    let damping =
        [dmatrix![367.794_425_117_017_4, 96.618_154_079_217_89; 96.618_154_079_217_87, 254.926_342_953_977_44]];
    let stiffness = [
        dmatrix![5_054_716.183_015_271, 0.0; 0.0, 8_597_001.835_334_135],
        dmatrix![0.0, 0.0; 0.0, 4_906_750.966_291_885],
    ];
    let problem = DenseQuadratic::new(&mass, &damping, &stiffness, &[1.0, 1.0, -1.75]).unwrap();
    let path = Line { from: vec![1.0, 1.0, 0.0], direction: vec![0.0, 0.0, -1.0] };
    let places = [1.751_510_191_321_623_3, 1.752_679_624_215_062_6];
    let intervals: &mut dyn Intervals = &mut Covering::new(&problem, &path, &ALL);
    let found = intervals.unstable_values(&places, STEPS, &NoMemory).unwrap();
    let ([surely], [possibly]) = (&found.surely[..], &found.possibly[..]) else { panic!("{found:?}") };
    // It diverges where the second stiffness ends.
    let expected = 8_597_001.835_334_135 / 4_906_750.966_291_885;
    for ends in [surely, possibly] {
        assert!((ends[0] - expected).abs() < 1e-9 && ends[1] == places[1], "{found:?}");
    }
}

/// Modes that nothing couples, in turned coordinates; the damping ratio of one passes what counts at a slope. However small that is, its
/// critical value lies within what is left open, which is not more than rounding makes of it.
#[test]
fn a_crossing_that_rounding_blurs_is_left_open_and_not_taken_for_a_mode_on_the_threshold() {
    let mut blurred = 0;
    for seed in 0..400 {
        let mut numbers = Numbers(seed);
        let size = 2 + seed as usize % 5;
        let slope = libm::pow(10.0, -9.0 + 4.0 * (seed as f64 / 400.0));
        let turn = DMatrix::from_fn(size, size, |_, _| numbers.normal()).qr().q();
        let frequency = |i: usize| 1.0 + if i < 2 { 1e-3 * i as f64 } else { 0.3 * i as f64 };
        let at = 0.4 * numbers.next();
        let turned = |of: &dyn Fn(usize) -> f64| {
            let diagonal = DMatrix::from_fn(size, size, |i, j| if i == j { of(i) } else { 0.0 });
            turn.transpose() * diagonal * &turn
        };
        let damping = [
            turned(&|i| if i == 0 { 2.0 * (slope * at - RESOLUTION) } else { 0.02 * frequency(i) }),
            turned(&|i| if i == 0 { -2.0 * slope } else { 0.0 }),
        ];
        let stiffness = [turned(&|i| frequency(i) * frequency(i))];
        let problem = DenseQuadratic::new(&DMatrix::identity(size, size), &damping, &stiffness, &[1.0; 3]).unwrap();
        let path = Line { from: vec![1.0, 0.0, 1.0], direction: vec![0.0, 1.0, 0.0] };
        let found = unstable(&problem, &path, [-1.0, 1.0]);
        let ([surely], [possibly]) = (&found.surely[..], &found.possibly[..]) else { panic!("{seed}: {found:?}") };
        let rounding = 4.0 * f64::EPSILON / slope;
        assert!(possibly[0] <= at + rounding && at - rounding <= surely[0], "{seed}: {at} {possibly:?} {surely:?}");
        assert!(surely[0] - possibly[0] < 2e4 * rounding, "{seed}: {possibly:?} {surely:?}");
        blurred += usize::from(surely[0] - possibly[0] > 10.0 * rounding);
        // In an interval so narrow that this mode keeps next to the threshold.
        for narrow in 1..10 {
            let half = rounding * f64::from(1 << narrow);
            let parts = Covering::new(&problem, &path, &ALL).parts([at - half, at + 0.7 * half], (1, 0), false);
            for Part { ends, is_unstable } in parts.into_iter().flatten() {
                let is_right = is_unstable.is_none_or(|is_unstable| match is_unstable {
                    true => ends[0] >= at - rounding,
                    false => ends[1] <= at + rounding,
                });
                assert!(is_right, "{seed}: {at} {ends:?} {is_unstable:?}");
            }
        }
    }
    assert!(blurred > 100, "{blurred}");
}

/// Gyroscopic forces in other coordinates are skew but for rounding: what they keep stable stays on the imaginary axis, with narrow
/// intervals, and their flutter is that of all eigenvalues.
#[test]
fn gyroscopic_forces_that_are_skew_but_for_rounding_damp_nothing() {
    let mut unstable_places = 0;
    for seed in 0..30 {
        let mut numbers = Numbers(seed);
        let size = 2 + seed as usize % 4;
        let mut random = || DMatrix::from_fn(size, size, |_, _| numbers.normal());
        let [turn, forces, root] = [random(), random(), random()];
        let turn = DMatrix::identity(size, size) + 0.3 * turn;
        let skew = turn.transpose() * ((&forces - forces.transpose()) * 3.0) * &turn;
        // Two directions are held by gyroscopic forces alone.
        let signs = DMatrix::from_fn(size, size, |i, j| f64::from(u8::from(i == j)) * if i < 2 { -1.0 } else { 2.0 });
        let stiffness = turn.transpose() * (signs + 0.1 * (&root + root.transpose())) * &turn;
        let mut noise = || numbers.normal() * f64::EPSILON;
        let [skew, stiffness] =
            [skew, stiffness].map(|of| of.map_with_location(|_, _, value: f64| value + of.amax() * 0.2 * noise()));
        let problem = DenseQuadratic::new(&DMatrix::identity(size, size), &[skew], &[stiffness], &[1.0; 2]).unwrap();
        assert_eq!(problem.mirrored(), Mirrored::ButForRounding, "{seed}");
        let path = Line { from: vec![0.0, 1.0], direction: vec![1.0, 0.0] };
        let found = unstable(&problem, &path, [0.1, 3.0]);
        assert!(open(&found) < 1e-6, "{seed}: {found:?}");
        for step in 0..58 {
            let p = 0.1 + 0.05 * f64::from(step);
            let values = problem.at(&path.coefficients(p)).eigenvalues().unwrap();
            let contains = |set: &[[f64; 2]]| set.iter().any(|[from, to]| (*from..=*to).contains(&p));
            let expected = values.iter().any(|value| value.re > 1e-6);
            unstable_places += usize::from(expected);
            let is_right = [&found.surely, &found.possibly].into_iter().any(|set| contains(set) == expected);
            assert!(is_right, "{seed} at {p}: {values:?} {found:?}");
        }
    }
    assert!(unstable_places > 100 && unstable_places < 1600, "{unstable_places}");
}

/// Negative damping that is small beside gyroscopic forces of another direction is damping all the same.
#[test]
fn negative_damping_beside_large_gyroscopic_forces_is_no_rounding() {
    for (damping, expected) in [(-8e-9, true), (-1e-12, false)] {
        let damping = dmatrix![damping, 1e7, 0.0; -1e7, 0.0, 0.0; 0.0, 0.0, 0.0];
        let stiffness =
            [DMatrix::from_diagonal(&dvector![2.0, 1e16, 9.0]), dmatrix![1.0, 0.0, 0.0; 0.0, 0.0, 0.0; 0.0, 0.0, 0.0]];
        let problem = DenseQuadratic::new(&DMatrix::identity(3, 3), &[damping], &stiffness, &[1.0; 3]).unwrap();
        assert_eq!(problem.mirrored(), Mirrored::ButForRounding);
        let path = Line { from: vec![1.0, 1.0, 0.0], direction: vec![0.0, 0.0, 1.0] };
        let found = unstable(&problem, &path, [0.1, 1.0]);
        let whole = if expected { vec![[0.1, 1.0]] } else { Vec::new() };
        assert_eq!(found.possibly, whole, "{found:?}");
    }
}

/// Masses that dampers alone hold in one direction: its eigenvalue is zero, not what rounding makes of it.
#[test]
fn a_motion_that_dampers_alone_hold_is_never_unstable() {
    let mut critical = 0;
    for seed in 0..60 {
        let mut numbers = Numbers(seed);
        let size = 2 + seed as usize % 5;
        let mut random = || DMatrix::from_fn(size, size, |_, _| numbers.normal());
        let definite = |root: &DMatrix<f64>| root * root.transpose() + DMatrix::identity(size, size) * 0.1;
        let [mass, damping, stiffness] = [random(), random(), random()].map(|root| definite(&root));
        let [friction, direction] = [random(), random()];
        let direction = direction.column(0).normalize();
        let across = DMatrix::identity(size, size) - &direction * direction.transpose();
        let stiffness = [&across * stiffness * &across, &across * friction * &across];
        let damping = [damping * libm::pow(10.0, seed as f64 / 8.0 - 5.0)];
        let problem = DenseQuadratic::new(&mass, &damping, &stiffness, &[1.0; 3]).unwrap();
        let (problem, motions) = problem.without_rigid_body_motions();
        assert_eq!((motions.len(), problem.zeros()), (0, 0), "{seed}");
        let path = Line { from: vec![1.0, 1.0, 0.0], direction: vec![0.0, 0.0, 1.0] };
        let found = unstable(&problem, &path, [0.0, 3.0]);
        critical += usize::from(!found.surely.is_empty());
        assert!(open(&found) < 1e-5, "{seed}: {found:?}");
        for step in 0..=60 {
            let p = 0.05 * f64::from(step);
            let values = problem.at(&path.coefficients(p)).eigenvalues().unwrap();
            assert_eq!(values.len(), 2 * size - 1, "{seed} {p}");
            let contains = |set: &[[f64; 2]]| set.iter().any(|[from, to]| (*from..=*to).contains(&p));
            let expected = values.iter().any(|value| ALL.contains(*value));
            for series in [None, ModeSeries::new(&problem, &path.coefficients(p + 0.01), &[2], &[ALL], 1 << 24)] {
                let decider = Decider::of_any(&problem, &[ALL], series.as_ref());
                let decided = decider.is_unstable(&path.coefficients(p));
                assert_eq!(decided.map(|(is_unstable, _)| is_unstable), Some(expected), "{seed} at {p}");
            }
            let is_right = [&found.surely, &found.possibly].into_iter().all(|set| contains(set) == expected);
            assert!(is_right, "{seed} at {p}: {values:?} {found:?}");
        }
    }
    assert!(critical > 10, "{critical}");
}

/// `x'' + c x' + x = 0` with `c = (p - at)^2 - 2 depth`.
struct Grazing {
    at: f64,
    depth: f64,
}

impl Path for Grazing {
    fn series(&self, p: f64, _: f64) -> Vec<[f64; 4]> {
        let by = p - self.at;
        vec![[by * by - 2.0 * self.depth, 2.0 * by, 1.0, 0.0], [1.0, 0.0, 0.0, 0.0]]
    }
}

/// A damping ratio that falls below the threshold by less than what counts, or by a few times as much.
#[test]
fn a_shallow_window_has_its_own_width() {
    let problem = DenseQuadratic::new(
        &DMatrix::identity(1, 1),
        &[DMatrix::identity(1, 1)],
        &[DMatrix::identity(1, 1)],
        &[1.0, 1.0],
    )
    .unwrap();
    for depth in [2e-9, 4e-9, 1e-8, 2e-8, 1e-6] {
        let found = unstable(&problem, &Grazing { at: 0.4, depth }, [0.0, 1.0]);
        let ([surely], [possibly]) = (&found.surely[..], &found.possibly[..]) else { panic!("{depth}: {found:?}") };
        let half = (2.0 * (depth - RESOLUTION)).sqrt();
        for (end, expected) in [surely, possibly].into_iter().flat_map(|ends| ends.iter().zip([0.4 - half, 0.4 + half]))
        {
            assert!((end - expected).abs() < 1e-9, "{depth}: {found:?}");
        }
    }
    for depth in [9e-10, 3e-10, -1e-12, -1e-8] {
        let found = unstable(&problem, &Grazing { at: 0.4, depth }, [0.0, 1.0]);
        let width: f64 = found.possibly.iter().map(|[from, to]| to - from).sum();
        assert!(found.surely.is_empty() && width < 1e-6, "{depth}: {found:?}");
    }
}
