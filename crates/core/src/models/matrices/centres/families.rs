//! Verdicts from centres beside those of all eigenvalues on random models of several kinds.

use nalgebra::{DMatrix, DVector};

use super::*;
use crate::models::matrices::decide::Decider;
use crate::models::matrices::trial::Numbers;

/// What a kind of models is for.
const KINDS: [&str; 8] = [
    "modes apart, friction",
    "symmetric doublets",
    "near coalescence",
    "heavily damped modes between",
    "modes that enter the bands from above",
    "many inputs",
    "products of inputs",
    "gyroscopic, hardly damped",
];

/// The place of friction among the coefficients.
const FRICTION: usize = 4;

struct Family {
    problem: DenseQuadratic,
    regions: Vec<Region>,
    kind: usize,
    scatter: f64,
    /// How many coefficients there are, and which change.
    count: usize,
    changing: Vec<usize>,
}

impl Family {
    /// The coefficients of a sample with these deviates.
    fn coefficients(&self, deviates: &[f64]) -> Vec<f64> {
        let mut all = vec![1.0; self.count];
        self.changing.iter().zip(deviates).for_each(|(&k, deviate)| all[k] += self.scatter * deviate);
        if self.kind == 6 {
            all[FRICTION] *= all[3];
            all[0] *= all[3] * all[3];
        }
        all
    }
}

/// A model of a kind with coefficients of 1 as expected, whose inputs scatter by some share.
fn family(kind: usize, seed: u64, size: usize, scatter: f64) -> Family {
    let mut numbers = Numbers(seed);
    (0..5).for_each(|_| {
        numbers.next();
    });
    let mut matrix = |entry: f64| DMatrix::from_fn(size, size, |_, _| entry * numbers.next());
    let is_pair = kind == 1 || kind == 2;
    let split = [0.0, 0.0, 3e-4][kind.min(2)];
    let place = |i: usize| {
        let step = if is_pair { (i / 2) as f64 + 0.1 * split * (i % 2) as f64 } else { 0.5 * i as f64 };
        0.3 + 3.4 * (step + 0.25) / size as f64
    };
    let squares = DVector::from_fn(size, |i, _| place(i) * place(i));
    let own = DMatrix::from_diagonal(&squares);
    let light = if kind == 7 { 2e-3 } else { 0.02 };
    let mut ratios = matrix(light).column(0).map(f64::abs);
    if kind == 3 {
        (0..size).step_by(3).for_each(|i| ratios[i] = 0.6);
    }
    let damping = DMatrix::from_diagonal(&DVector::from_fn(size, |i, _| 2.0 * ratios[i] * place(i)));
    let skew = matrix(if kind == 7 { 0.2 } else { 0.02 });
    let gyroscopic = &skew - skew.transpose();
    // Upper modes rest on the lining, lower ones on both.
    let share = |i: usize| if kind == 4 && place(i) > 1.3 { 0.95 } else { 0.3 };
    let noise = matrix(0.05 / (size as f64).sqrt());
    let soft = DMatrix::from_diagonal(&DVector::from_fn(size, |i, _| share(i) * squares[i]));
    let lining = &soft + &noise + noise.transpose();
    let friction = matrix(0.1 / (size as f64).sqrt());
    let inputs = [3, 3, 3, 3, 2, 8, 3, 3][kind];
    let mut stiffness = vec![own - &lining, lining, friction];
    for _ in 3..inputs {
        stiffness.push(matrix(0.03 / (size as f64).sqrt()));
    }
    let count = 2 + stiffness.len();
    let new = |stiffness: &[DMatrix<f64>]| {
        let damping = [damping.clone(), gyroscopic.clone()];
        DenseQuadratic::new(&DMatrix::identity(size, size), &damping, stiffness, &vec![1.0; count]).unwrap()
    };
    let bands: &[[f64; 2]] = match seed % 6 {
        0 | 4 => &[[0.7, 1.2]],
        1 | 3 => &[[0.5, 0.8], [0.8, 1.2], [1.0, 1.3]],
        2 => &[[0.0, 0.8]],
        _ => &[[0.0, 0.5], [0.0, 1.1]],
    };
    let damping_ratio = [0.0, 0.0, 0.004, -0.002][seed as usize % 4];
    let in_unit = |problem: &DenseQuadratic| -> Vec<Region> {
        let regions = bands.iter().map(|&[lowest, highest]| Region { lowest, highest, damping_ratio });
        regions.map(|region| region.in_unit(problem.unit())).collect()
    };
    // The friction at which the expected model begins to be unstable.
    let first = new(&stiffness);
    let at = |friction: f64| {
        let coefficients: Vec<f64> = (0..count).map(|k| if k == FRICTION { friction } else { 1.0 }).collect();
        Decider::of_each(&first, &in_unit(&first)).by_all(&coefficients) != Some(0)
    };
    let (mut low, mut high) = (0.0, 64.0);
    for _ in 0..20 {
        let middle = 0.5 * (low + high);
        if at(middle) { high = middle } else { low = middle }
    }
    stiffness[FRICTION - 2] *= high;
    let problem = new(&stiffness);
    // Everything but the constant stiffness and gyroscopic forces changes.
    let changing: Vec<usize> = (0..count).filter(|k| ![1, 2].contains(k)).collect();
    Family { regions: in_unit(&problem), kind, scatter, count, changing, problem }
}

/// How many verdicts of centres there are, how many were left open, and how many are unstable; none is another than that by all
/// eigenvalues.
fn compare(kind: usize, seed: u64, size: usize, scatter: f64, samples: usize) -> [usize; 3] {
    let family = family(kind, seed, size, scatter);
    let Family { problem, regions, changing, .. } = &family;
    let centres = Centres::new(regions.clone(), changing.clone(), vec![1.0; family.count]);
    let mut numbers = Numbers(seed + 1000);
    let mut tally = [0; 3];
    for _ in 0..samples {
        let deviates: Vec<f64> = changing.iter().map(|_| numbers.normal()).collect();
        let sample = family.coefficients(&deviates);
        let truth = Decider::of_each(problem, regions).by_all(&sample);
        tally[2] += usize::from(truth != Some(0));
        match centres.regions(problem, &sample) {
            Some(told) => {
                assert_eq!(Some(told), truth, "{} {seed} {size} {scatter} {sample:?}", KINDS[kind]);
                tally[0] += 1;
            }
            None => tally[1] += 1,
        }
    }
    tally
}

fn sum(all: impl Iterator<Item = [usize; 3]>) -> [usize; 3] {
    all.fold([0; 3], |sum, one| [0, 1, 2].map(|place| sum[place] + one[place]))
}

const SCATTER: [f64; 5] = [0.01, 0.03, 0.08, 0.15, 0.25];

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn verdicts_of_centres_are_those_of_all_eigenvalues_on_models_of_all_kinds() {
    for (kind, name) in KINDS.iter().enumerate() {
        let one = |seed: usize| compare(kind, seed as u64, 2 + 5 * seed, SCATTER[(kind + seed) % 3], 60);
        let [told, open, unstable] = sum((0..6).map(one));
        assert!(told > 60 && unstable > 10 && unstable < told + open - 10, "{name}: {told} {open} {unstable}");
    }
}

/// 200,000 samples of 200 models with 2 to 150 coordinates, by kind.
#[test]
#[ignore = "takes minutes"]
#[allow(clippy::print_stdout, reason = "a table")]
fn verdicts_of_centres_are_those_of_all_eigenvalues_on_many_models() {
    let mut samples = 0;
    for (kind, name) in KINDS.iter().enumerate() {
        let size = |seed: usize| [2, 3, 5, 8, 12, 17, 24, 30, 40, 150][seed % 10] + seed / 10;
        let one = |seed: usize| {
            compare(kind, 100 + seed as u64, size(seed), SCATTER[seed % 5], if size(seed) < 100 { 1100 } else { 150 })
        };
        let [told, open, unstable] = sum((0..25).map(one));
        samples += told + open;
        let part = |count: usize| 100.0 * count as f64 / (told + open) as f64;
        println!("{name}: {:.1} % unstable, {:.1} % by all eigenvalues", part(unstable), part(open));
    }
    assert!(samples >= 200_000, "{samples}");
}
