//! Searches over a parameter against all eigenvalues on a dense grid.

use nalgebra::{Complex, DMatrix, Schur, dmatrix, dvector};

use crate::model::critical_values::NoMemory;
use crate::models::matrices::branches::Path;
use crate::models::matrices::covering::Covering;
use crate::models::matrices::quadratic::{DenseQuadratic, Mirrored};
use crate::models::matrices::region::{RESOLUTION, Region};
use crate::models::matrices::sweep::{Intervals, Steps, settled};
use crate::models::matrices::trial::Numbers;

/// As in [`problem`](crate::models::matrices::problem), of what is proved.
const STEPS: Steps = Steps { joined: 3, halvings: 44, most: 1000, widest_first: true };

/// Places of the grid, over five standard deviations to each side.
const GRID: u32 = 1500;

/// What the parameter does; the models of each kind differ by their seed.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    Friction,
    Modulus,
    Speed,
    Damping,
    Divergence,
    Overdamped,
    Undamped,
}

const KINDS: [Kind; 7] =
    [Kind::Friction, Kind::Modulus, Kind::Speed, Kind::Damping, Kind::Divergence, Kind::Overdamped, Kind::Undamped];

/// Coefficients `c + p d + p^2 e` of a parameter `p = mean (1 + std z)`; z is the place on the path.
struct OverDeviate {
    terms: [Vec<f64>; 3],
    mean: f64,
    std: f64,
}

impl Path for OverDeviate {
    fn series(&self, z: f64, _: f64) -> Vec<[f64; 4]> {
        let (p, by) = (self.mean * (1.0 + self.std * z), self.mean * self.std);
        let [c, d, e] = &self.terms;
        let each = c.iter().zip(d).zip(e);
        each.map(|((c, d), e)| [c + p * (d + p * e), by * (d + 2.0 * p * e), by * by * e, 0.0]).collect()
    }
}

/// A random model with modes that lie near each other. Coefficients: two of damping, three of stiffness.
fn model(kind: Kind, seed: u64) -> (DenseQuadratic, OverDeviate, Region) {
    let mut numbers = Numbers(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
    for _ in 0..8 {
        numbers.next();
    }
    let mut uniform = move || 0.5 * (1.0 + numbers.next());
    let size = match seed % 20 {
        0..=9 => 2,
        10..=17 => 3 + (9.0 * uniform()) as usize,
        18 => 12 + (10.0 * uniform()) as usize,
        _ => 22 + (19.0 * uniform()) as usize,
    };
    // Frequencies from 1 on, some of them close, and damping ratios of some thousandths.
    let mut squares = vec![1.0];
    for _ in 1..size {
        let gap = if uniform() < 0.6 { 0.02 + 0.3 * uniform() } else { 1.0 + uniform() };
        squares.push(squares[squares.len() - 1] + gap);
    }
    let diagonal = |values: Vec<f64>| DMatrix::from_diagonal(&values.into());
    let mut random = |scale: f64| DMatrix::from_fn(size, size, |_, _| scale * (2.0 * uniform() - 1.0));
    let symmetric = |matrix: DMatrix<f64>| (&matrix + matrix.transpose()) * 0.5;
    let skew = |matrix: DMatrix<f64>| (&matrix - matrix.transpose()) * 0.5;
    let friction = random(0.3);
    let coupling = symmetric(random(0.05));
    let tuning = symmetric(random(0.1));
    let gyroscopic = skew(random(0.2));
    let some = random(1.0);
    let pick = |place: usize| 0.5 * (1.0 + some[(place % size, place / size % size)]);
    let ratios: Vec<f64> =
        (0..size).map(|i| [2e-4, 2e-3, 2e-2][(3.0 * pick(i)) as usize % 3] * squares[i].sqrt()).collect();
    let mut damping = diagonal(ratios);
    let place = (size as f64 * pick(size)) as usize % size;
    let single = |value: f64| diagonal((0..size).map(|i| if i == place { value } else { 0.0 }).collect());
    let stiffness = diagonal(squares.clone()) + coupling;
    // Terms: damping, that of the parameter, stiffness, friction or tuning, that of the parameter.
    let zero = DMatrix::zeros(size, size);
    let mut other = &friction * (0.1 + pick(1));
    let (mut of_damping, mut of_stiffness, mut of_square) = (zero.clone(), zero.clone(), zero.clone());
    match kind {
        Kind::Friction => {
            of_stiffness = friction;
            other = zero;
        }
        Kind::Modulus => of_stiffness = single(0.4 * squares[place]) + tuning,
        Kind::Speed => {
            of_damping = gyroscopic;
            of_square = -diagonal(squares.iter().map(|square| 0.05 * square * pick(3)).collect()) + friction * 0.1;
        }
        Kind::Damping => of_damping = single(0.05) + symmetric(random(0.002)),
        Kind::Divergence => of_stiffness = -single(squares[place] * (0.5 + pick(4))) + tuning,
        Kind::Overdamped => {
            damping += single(4.0 * squares[place].sqrt());
            of_damping = single(2.0);
            of_stiffness = friction;
        }
        Kind::Undamped => {
            damping = zero.clone();
            of_stiffness = friction;
            other = zero;
        }
    }
    let mean = 0.2 + 1.3 * pick(5);
    let path = OverDeviate {
        terms: [vec![1.0, 0.0, 1.0, 0.0, 0.0], vec![0.0, 1.0, 0.0, 1.0, 0.0], vec![0.0, 0.0, 0.0, 0.0, 1.0]],
        mean,
        std: [0.03, 0.1, 0.3][(3.0 * pick(6)) as usize % 3],
    };
    let stiffness = [stiffness + other, of_stiffness, of_square];
    let problem =
        DenseQuadratic::new(&DMatrix::identity(size, size), &[damping, of_damping], &stiffness, &[1.0; 5]).unwrap();
    let middle = squares[(size as f64 * pick(7)) as usize % size].sqrt();
    let band = match (4.0 * pick(8)) as usize {
        _ if kind == Kind::Divergence => [0.0, f64::INFINITY],
        0 => [middle * 0.97, middle * 1.02],
        1 => [0.3, middle * 1.3],
        _ => [0.0, f64::INFINITY],
    };
    let damping_ratio = [0.0, 0.0, -0.001, -0.01][(4.0 * pick(9)) as usize % 4];
    let region = Region { lowest: band[0], highest: band[1], damping_ratio }.in_unit(problem.unit());
    (problem, path, region)
}

/// The probability that a standard normal deviate is at most so large.
fn below(z: f64) -> f64 {
    0.5 * libm::erfc(-z / std::f64::consts::SQRT_2)
}

fn probability(set: &[[f64; 2]]) -> f64 {
    set.iter().map(|[from, to]| below(*to) - below(*from)).sum()
}

/// The probability of instability by bisection between places of a grid, and further ones, where the verdict differs.
fn by_grid(is_unstable: &dyn Fn(f64) -> bool, more: &[f64]) -> f64 {
    let mut places: Vec<f64> = (0..=GRID).map(|index| 10.0 * f64::from(index) / f64::from(GRID) - 5.0).collect();
    places.extend(more.iter().filter(|place| place.abs() < 5.0));
    places.sort_by(f64::total_cmp);
    let mut sum = 0.0;
    let (mut from, mut was) = (f64::NEG_INFINITY, is_unstable(places[0]));
    for two in places.windows(2) {
        let is = is_unstable(two[1]);
        if is != was {
            let [mut low, mut high] = [two[0], two[1]];
            for _ in 0..40 {
                let middle = 0.5 * (low + high);
                *(if is_unstable(middle) == was { &mut low } else { &mut high }) = middle;
            }
            sum += if was { below(high) - below(from) } else { 0.0 };
            (from, was) = (high, is);
        }
    }
    sum + if was { 1.0 - below(from) } else { 0.0 }
}

/// Searches on models of these seeds, and of how many the probability was neither 0 nor 1.
fn compare(seeds: std::ops::Range<u64>) -> usize {
    let mut between = 0;
    let mut wrong = Vec::new();
    let mut wide = 0;
    let number = seeds.clone().count();
    for seed in seeds {
        let kind = KINDS[(seed % KINDS.len() as u64) as usize];
        let (problem, path, region) = model(kind, seed);
        let intervals: &mut dyn Intervals = &mut Covering::new(&problem, &path, &region);
        let places = [-9.0, -6.5, -4.5, -3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 4.5, 6.5, 9.0];
        let found = intervals.unstable_values(&places, STEPS, &NoMemory).unwrap();
        let is_unstable = |z: f64| {
            let values = problem.at(&path.coefficients(z)).eigenvalues().unwrap();
            values.iter().any(|value| region.contains(*value))
        };
        let [low, high] = [&found.surely, &found.possibly].map(|set| probability(set));
        // A window that the grid misses is seen in the middle of what was found.
        let ends: Vec<f64> = found.surely.iter().flatten().copied().collect();
        let middles: Vec<f64> = ends.windows(2).map(|two| 0.5 * (two[0] + two[1])).collect();
        let expected = by_grid(&is_unstable, &middles);
        between += usize::from(expected > 1e-12 && expected < 1.0 - 1e-12);
        wide += usize::from(high - low > 1e-6);
        // Where much is left open there is no number to be wrong.
        let is_number = high - low <= 1e-3;
        if is_number && (expected < low - 1e-6 || expected > high + 1e-6) {
            wrong.push(format!("{kind:?} {seed}: {low} to {high}, by the grid {expected}"));
        }
    }
    assert!(
        wrong.is_empty(),
        "{} of {number}, {between} between 0 and 1, {wide} wide:\n{}",
        wrong.len(),
        wrong.join("\n")
    );
    assert!(wide * 100 <= number, "{wide} of {number} are wide");
    between
}

/// Every place at which an eigenvalue may pass a threshold of the damping ratio, of a model whose matrices are linear in the
/// place, by one eigenvalue problem. A threshold is a ray of the complex plane. The first-order matrix `A`, turned so that the
/// ray of `λ` is the imaginary axis and, the other way, so that of its conjugate is, has two eigenvalues there whose sum is 0:
/// the Kronecker sum of both is singular. Places that belong to other pairs of eigenvalues are among them.
fn by_eigenproblem(problem: &DenseQuadratic, path: &OverDeviate, damping_ratio: f64) -> Vec<f64> {
    let angle = libm::asin(damping_ratio);
    let sum = |z: f64| {
        let matrix = problem.at(&path.coefficients(z)).companion().map(|value| Complex::new(value, 0.0));
        let one = DMatrix::identity(matrix.nrows(), matrix.nrows());
        let turned = |by: f64| matrix.map(|value| value * Complex::new(libm::cos(by), libm::sin(by)));
        turned(-angle).kronecker(&one) + one.kronecker(&turned(angle))
    };
    // The sum is S(z) = S(z0) + (z - z0) T, and singular where 1 / (z0 - z) is an eigenvalue of the inverse of S(z0) times T.
    let start = 0.377;
    let slope = sum(1.0) - sum(0.0);
    let product = sum(start).lu().solve(&slope).unwrap();
    let values = Schur::new(product).eigenvalues().unwrap();
    let places = values.iter().filter(|value| value.norm() > 1e-9).map(|value| Complex::from(start) - value.inv());
    places.filter(|place| place.im.abs() < 1e-3 && place.re.abs() < 9.0).map(|place| place.re).collect()
}

/// The whole verdict from this eigenvalue problem, with all eigenvalues between its places.
#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn searches_over_a_parameter_find_what_one_eigenvalue_problem_shows() {
    let linear = [Kind::Friction, Kind::Modulus, Kind::Damping, Kind::Divergence, Kind::Overdamped];
    let (mut models, mut between, mut ends) = (0, 0, 0);
    for seed in 0..3000 {
        let kind = KINDS[(seed % KINDS.len() as u64) as usize];
        let (problem, path, region) = model(kind, seed);
        if !linear.contains(&kind) || problem.size() > 3 {
            continue;
        }
        models += 1;
        let region = Region { lowest: 0.0, highest: f64::INFINITY, ..region };
        let mut breaks = by_eigenproblem(&problem, &path, region.damping_ratio - RESOLUTION);
        breaks.extend([-9.0, 9.0]);
        breaks.sort_by(f64::total_cmp);
        let is_unstable = |two: &&[f64]| {
            let values = problem.at(&path.coefficients(0.5 * (two[0] + two[1]))).eigenvalues().unwrap();
            values.iter().any(|value| region.contains(*value))
        };
        let unstable: Vec<[f64; 2]> = breaks.windows(2).filter(is_unstable).map(|two| [two[0], two[1]]).collect();
        let expected = probability(&unstable);
        let intervals: &mut dyn Intervals = &mut Covering::new(&problem, &path, &region);
        let found = intervals.unstable_values(&[-9.0, -4.5, 0.0, 4.5, 9.0], STEPS, &NoMemory).unwrap();
        let [low, high] = [&found.surely, &found.possibly].map(|set| probability(set));
        assert!(
            low - 1e-9 <= expected && expected <= high + 1e-9 && high - low < 1e-9,
            "{kind:?} {seed}: {low} to {high}, by the eigenvalue problem {expected}"
        );
        between += usize::from(expected > 1e-12 && expected < 1.0 - 1e-12);
        ends += found.surely.len();
    }
    assert!(models > 1000 && between > 200 && ends > between, "{models} {between} {ends}");
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn searches_over_a_parameter_find_what_all_eigenvalues_show() {
    let between = compare(0..105);
    assert!(between > 20, "{between}");
}

#[test]
#[ignore = "takes minutes"]
fn searches_over_a_parameter_of_many_models_find_what_all_eigenvalues_show() {
    let between = compare(1000..6000);
    assert!(between > 1000, "{between}");
}

/// Models at which searches that interpolate between places go wrong without a word, in closed form, the two windows by the roots of the
/// characteristic polynomial in 40 digits: the parameter is normal with this mean and standard deviation.
#[test]
fn windows_that_places_do_not_show_are_found() {
    let none = || DMatrix::zeros(2, 2);
    let one = |value: f64| DMatrix::from_element(1, 1, value);
    let alone = |damping: [f64; 3], stiffness: [f64; 2]| {
        (damping.map(one).to_vec(), vec![one(stiffness[0]), one(stiffness[1]), one(0.0)])
    };
    let grazing = |depth: f64| alone([1e-4 - depth, -0.02, 1.0], [1.0, 0.0]);
    let grazes = (1e-6 - 2.0 * RESOLUTION).sqrt() / 0.01;
    let stiff = dmatrix![0.0, 1.0, 1.0; -1.0, 0.0, 1.0; 1.0, 1.0, 0.0];
    let beside_stiff = vec![DMatrix::from_diagonal(&dvector![1.0, 1.1, 1e12]), stiff.clone(), stiff * 0.0];
    // Two modes flutter where (Im k)^2 = c^2 Re k; what separates a damping ratio that counts from zero adds to c = 0.01.
    let damping_of = |frequency: f64| 0.01 + 2.0 * RESOLUTION * frequency;
    // Of the soft two, k = 1.05 +- i sqrt(p^2 - 0.05^2).
    let flutters = (0.0025 + damping_of(1.05_f64.sqrt()) * damping_of(1.05_f64.sqrt()) * 1.05).sqrt();
    let beside_stiff_one = below((0.04 - flutters) / 0.02) + below((-0.04 - flutters) / 0.02);
    let passing = dmatrix![0.0, 0.0; 0.0, -1.0];
    for (name, (damping, stiffness), [mean, std], expected) in [
        (
            "a narrow window of flutter",
            (
                vec![DMatrix::identity(2, 2) * 1e-6, none(), none()],
                vec![dmatrix![1.0, 1e-5; -1e-5, 2.137], passing.clone(), none()],
            ),
            [1.0, 0.1],
            6.211_767_867_1e-5,
        ),
        (
            "a narrow window of stability",
            (
                vec![dmatrix![-1e-3, 0.0; 0.0, 3e-3], none(), none()],
                vec![dmatrix![1.0, 2e-3; 2e-3, 2.137], passing, none()],
            ),
            [1.0, 0.1],
            0.996_395_356_038_4,
        ),
        ("a stiff coordinate", (vec![DMatrix::identity(3, 3) * 0.01; 1], beside_stiff), [0.04, 0.02], beside_stiff_one),
        (
            "modes that are one at the median",
            (
                vec![DMatrix::identity(2, 2) * 0.01],
                vec![DMatrix::identity(2, 2), dmatrix![0.0, 1.0; -1.0, 0.0], none()],
            ),
            [0.0, 0.01],
            2.0 * below(-damping_of(1.0) / 0.01),
        ),
        ("divergence without damping", alone([0.0; 3], [1.0, -1.0]), [0.8, 0.1], below(-2.0)),
        ("damping that grazes zero", grazing(1e-6), [0.01, 0.01], 1.0 - 2.0 * below(-grazes)),
        ("damping that does not", grazing(-1e-6), [0.01, 0.01], 0.0),
    ] {
        let size = stiffness[0].nrows();
        let terms = [damping.len(), stiffness.len()];
        let coefficient = |order: usize| {
            let of = |terms: usize| (0..terms).map(|index| f64::from(u8::from(index == order))).collect::<Vec<_>>();
            [of(terms[0]), of(terms[1])].concat()
        };
        let typical = vec![1.0; terms[0] + terms[1]];
        let problem = DenseQuadratic::new(&DMatrix::identity(size, size), &damping, &stiffness, &typical).unwrap();
        // The place is p - 1.
        let path = OverDeviate { terms: [0, 1, 2].map(coefficient), mean: 1.0, std: 1.0 };
        let region = Region { lowest: 0.0, highest: f64::INFINITY, damping_ratio: 0.0 };
        let places: Vec<f64> = (-4..=4).map(|z| mean + 2.0 * f64::from(z) * std - 1.0).collect();
        let intervals: &mut dyn Intervals = &mut Covering::new(&problem, &path, &region);
        let found = intervals.unstable_values(&places, STEPS, &NoMemory).unwrap();
        let deviates =
            |set: &[[f64; 2]]| set.iter().map(|ends| ends.map(|z| (z + 1.0 - mean) / std)).collect::<Vec<_>>();
        let [low, high] = [&found.surely, &found.possibly].map(|set| probability(&deviates(set)));
        let error = 1e-9 * (1.0 - expected).min(expected).max(1e-4) + 1e-9;
        assert!(low - error <= expected && expected <= high + error, "{name}: {low} to {high}, not {expected}");
        assert!(high - low <= 1e-8, "{name}: {low} to {high}");
    }
}

/// Models that go wrong where a part of the proof is left out. The parameter goes from -1 to 1 or within given ends.
#[test]
fn what_a_proof_needs_is_looked_at() {
    let skew = dmatrix![0.0, 1.0; -1.0, 0.0];
    let s = 8e-5;
    let one_sided = |p: f64| dmatrix![1.0, 0.07 * s * p; 2.0 * s * p, 1.0];
    let cluster = [one_sided(0.0), one_sided(1.0) - one_sided(0.0)];
    let mut stiff = DMatrix::from_diagonal(&dvector![1.0, 1.5, 1e12]);
    (stiff[(0, 1)], stiff[(1, 0)]) = (0.004, -0.004);
    let gyroscopic = dmatrix![0.0, -0.5, 0.0; 0.5, 0.0, 0.0; 0.0, 0.0, 0.0];
    // Friction beside a spring that is 1e12 times as stiff is no rounding of a symmetric matrix.
    let beside_stiff = DenseQuadratic::new(&DMatrix::identity(3, 3), &[gyroscopic], &[stiff], &[1.0; 2]).unwrap();
    assert_eq!(beside_stiff.mirrored(), Mirrored::No);
    let slow = DMatrix::identity(2, 2) * 0.1 + &skew * -1e-7;
    let turning = -DMatrix::identity(2, 2) + &skew;
    let free = dmatrix![1.0, -1.0, 0.0, 0.0; -1.0, 1.0, 0.0, 0.0; 0.0, 0.0, 1.0, -1.0; 0.0, 0.0, -1.0, 1.0];
    let zero = DMatrix::zeros(4, 4);
    let all = [-1.0, 1.0];
    for (name, damping, stiffness, threshold, ends) in [
        // A disc of two that may have lost its eigenvalue to the other.
        ("cluster", DMatrix::from_diagonal(&dvector![-0.1 * s, 0.14 * s]), cluster, 0.0, all),
        // A slow pair whose frequency passes zero.
        ("slow", DMatrix::identity(2, 2) * 10.0, [slow, turning], -0.5, [-0.2, 0.2]),
        // Two rigid-body motions that damping holds: two eigenvalues that are zero.
        ("free", DMatrix::identity(4, 4) * 0.1, [free, zero], 0.0, all),
    ] {
        let size = damping.nrows();
        let problem =
            DenseQuadratic::new(&DMatrix::identity(size, size), &[damping], &stiffness, &[1.0, 1.0, 0.0]).unwrap();
        let path = OverDeviate { terms: [vec![1.0, 1.0, 0.0], vec![0.0, 0.0, 1.0], vec![0.0; 3]], mean: 1.0, std: 1.0 };
        let region = Region { lowest: 0.0, highest: f64::INFINITY, damping_ratio: threshold };
        let intervals: &mut dyn Intervals = &mut Covering::new(&problem, &path, &region);
        let ends = ends.map(|p| p - 1.0);
        let found = intervals.unstable_values(&ends, STEPS, &NoMemory).unwrap();
        let open: f64 = [&found.possibly, &found.surely]
            .map(|set| set.iter().map(|[a, b]| b - a).sum::<f64>())
            .iter()
            .rev()
            .fold(0.0, |rest, size| size - rest);
        assert!(open < 1e-4, "{name}: {found:?}");
        let mut checked = 0;
        for part in 0..=200 {
            let z = ends[0] + (ends[1] - ends[0]) * (f64::from(part) + 0.37) / 202.0;
            let Ok(values) = problem.at(&path.coefficients(z)).eigenvalues() else { continue };
            checked += 1;
            let is_unstable = values.iter().any(|value| region.contains(*value));
            let has = |set: &[[f64; 2]]| set.iter().any(|[from, to]| (*from..=*to).contains(&z));
            assert!(has(&found.possibly) || !is_unstable, "{name}: {z} {found:?}");
            assert!(!has(&found.surely) || is_unstable, "{name}: {z} {found:?} {values:?}");
        }
        assert!(checked > 150, "{name}: {checked}");
    }
}

/// Where one part of an interval takes as many halvings as there are, the rest is found all the same.
#[test]
fn wide_intervals_come_before_those_that_are_narrow() {
    let steps = Steps { joined: 1, halvings: 44, most: 200, widest_first: true };
    let left = |steps| {
        let is_found = |[from, to]: [f64; 2]| from >= 0.0 && to - from <= 0.1;
        let settle = |interval: [f64; 2], may_halve| {
            Ok(if is_found(interval) {
                Some(0.0)
            } else if may_halve {
                None
            } else {
                Some(interval[1] - interval[0].max(0.0))
            })
        };
        let found: Vec<f64> = settled(&[-1.0, 3.0], steps, settle).unwrap();
        found.into_iter().filter(|width| *width > 0.0).sum::<f64>()
    };
    assert!(left(steps) < 1e-12, "{}", left(steps));
    assert!(left(Steps { widest_first: false, ..steps }) > 2.9);
}
