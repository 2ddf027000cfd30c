use nalgebra::{DMatrix, dmatrix, dvector};

use super::*;
use crate::models::matrices::trial::{Numbers, close_modes, problem};

/// Verdicts of as many problems on as many samples against all eigenvalues; and how they came about.
fn compare(problems: std::ops::Range<u64>, samples: usize, scatter: f64) -> [usize; 5] {
    let mut ways = [0; 5];
    for seed in problems {
        let (problem, origin, region) = problem(seed);
        let mut numbers = Numbers(seed + 1_000_000);
        let series = ModeSeries::new(&problem, &origin, &[1, 2, 3, 4], &[region], 1 << 24);
        let decider = Decider::of_any(&problem, std::slice::from_ref(&region), series.as_ref());
        for _ in 0..samples {
            let mut coefficients = origin.clone();
            (1..5).for_each(|k| coefficients[k] *= 1.0 + scatter * numbers.normal());
            let all = problem.at(&coefficients).eigenvalues().unwrap();
            let edge = |value: &Eigenvalue| {
                let ratio = (damping_ratio(*value) - region.damping_ratio).abs();
                let ends = [region.lowest, region.highest].map(|end| (value.im.abs() - end).abs());
                ratio < 1e-8 || value.im != 0.0 && ends.iter().any(|end| *end < 1e-8)
            };
            let expected = all.iter().any(|value| region.contains(*value));
            let (unstable, way) = decider.is_unstable(&coefficients).unwrap();
            ways[way as usize] += 1;
            assert!(
                unstable == expected || all.iter().any(edge),
                "problem {seed}, {coefficients:?}, {way:?}: {unstable}, all eigenvalues {all:?}"
            );
        }
    }
    ways
}

/// Whether all eigenvalues show a sample of a problem unstable, and how it was decided: as they show, unless one of them is at the
/// threshold.
#[track_caller]
fn compared(decider: &Decider<'_>, seed: u64, coefficients: &[f64]) -> (bool, Way) {
    let [region] = decider.regions else { panic!("one region") };
    let all = decider.problem.at(coefficients).eigenvalues().unwrap();
    let is_edge = |value: &Eigenvalue| (damping_ratio(*value) - region.damping_ratio).abs() < 1e-8;
    let expected = all.iter().any(|value| region.contains(*value));
    let (found, way) = decider.is_unstable(coefficients).unwrap();
    assert!(found == expected || all.iter().any(is_edge), "{seed} {coefficients:?} {way:?} {found}");
    (expected, way)
}

#[test]
fn verdicts_are_those_of_all_eigenvalues() {
    for scatter in [0.01, 0.1, 0.4] {
        let ways = compare(0..60, 60, scatter);
        let all_ways = [Way::ClosedForm, Way::Series, Way::Vectors, Way::Refined, Way::All];
        assert!(scatter != 0.1 || all_ways.iter().all(|way| ways[*way as usize] > 0), "{scatter} {ways:?}");
        assert!(scatter > 0.2 || ways[Way::Series as usize] > ways[Way::All as usize], "{scatter} {ways:?}");
    }
}

/// Bands beside each other, with gaps and within each other, are told apart in one decision, by whatever way it is made.
#[test]
fn each_of_several_bands_has_the_verdict_of_all_eigenvalues() {
    let mut ways = [0; 5];
    let mut both = [0; 2];
    for seed in 0..60 {
        let (problem, origin, region) = problem(seed);
        let [low, high] = [region.lowest, region.highest];
        let end = if high.is_finite() { high } else { low + 4.0 };
        let at = |share: f64| low + share * (end - low);
        let bands = [[low, at(0.4)], [at(0.4), at(0.7)], [at(0.75), high], [at(0.2), at(0.9)]];
        let regions = bands.map(|[lowest, highest]| Region { lowest, highest, ..region });
        let series = ModeSeries::new(&problem, &origin, &[1, 2, 3, 4], &regions, 1 << 24);
        let decider = Decider { series: series.as_ref(), ..Decider::of_each(&problem, &regions) };
        let mut numbers = Numbers(seed + 2_000_000);
        for _ in 0..60 {
            let mut coefficients = origin.clone();
            (1..5).for_each(|k| coefficients[k] *= 1.0 + 0.1 * numbers.normal());
            let all = problem.at(&coefficients).eigenvalues().unwrap();
            let by_all = decider.by_all(&coefficients).unwrap();
            let (found, way) = decider.by_series(&coefficients).unwrap_or((by_all, Way::All));
            ways[way as usize] += 1;
            for (place, region) in regions.iter().enumerate() {
                let is_edge = |value: &Eigenvalue| {
                    let ends = [region.lowest, region.highest].map(|end| (value.im.abs() - end).abs());
                    (damping_ratio(*value) - region.damping_ratio).abs() < 1e-8
                        || value.im != 0.0 && ends.iter().any(|end| *end < 1e-8)
                };
                let expected = all.iter().any(|value| region.contains(*value));
                let is = found & region_at(place) != 0;
                assert!(
                    is == expected || all.iter().any(is_edge),
                    "{seed} {coefficients:?} {way:?} {region:?} {all:?}"
                );
                both[usize::from(expected)] += 1;
            }
        }
    }
    assert!(ways[1..].iter().all(|count| *count > 0) && both.iter().all(|count| *count > 1000), "{ways:?} {both:?}");
}

#[test]
#[ignore = "takes minutes"]
fn verdicts_on_many_problems_are_those_of_all_eigenvalues() {
    for scatter in [0.02, 0.1, 0.3] {
        assert_eq!(compare(1000..6000, 200, scatter).iter().sum::<usize>(), 1_000_000);
    }
}

#[test]
fn the_least_damped_pair_is_that_of_all_eigenvalues() {
    for seed in 0..40 {
        let (problem, origin, region) = problem(seed);
        let series = ModeSeries::new(&problem, &origin, &[1, 2, 3, 4], &[region], 1 << 24);
        let decider = Decider::of_any(&problem, std::slice::from_ref(&region), series.as_ref());
        let mut numbers = Numbers(seed + 77);
        for _ in 0..20 {
            let mut coefficients = origin.clone();
            (1..5).for_each(|k| coefficients[k] *= 1.0 + 0.1 * numbers.normal());
            let all = problem.at(&coefficients).eigenvalues().unwrap();
            let in_band = all.into_iter().filter(|value| value.im >= 0.0 && region.has_frequency_of(*value));
            let least = in_band.map(damping_ratio).fold(f64::INFINITY, f64::min);
            let found = decider.least_damped(&coefficients).map_or(f64::INFINITY, damping_ratio);
            assert!(least == found || (least - found).abs() < 1e-9, "problem {seed}: {least} {found}");
        }
    }
}

/// The error of a pair that comes from the vectors of the series holds the exact eigenvalue, and is much smaller than
/// that of the series.
#[test]
fn errors_of_vectors_hold_the_exact_eigenvalue() {
    let (mut compared, mut smaller) = (0, 0);
    for seed in 0..60 {
        let (problem, origin, region) = problem(seed);
        let Some(series) = ModeSeries::new(&problem, &origin, &[1, 2, 3, 4], &[region], 1 << 24) else { continue };
        let mut numbers = Numbers(seed + 7);
        for _ in 0..20 {
            let mut coefficients = origin.clone();
            (1..5).for_each(|k| coefficients[k] *= 1.0 + 0.05 * numbers.normal());
            let quadratic = problem.at(&coefficients);
            let Some((monomials, followed)) = series.follow(&coefficients) else { continue };
            let exact = quadratic.eigenvalues().unwrap();
            let mut taken = Vec::new();
            let pairs = vector_pairs(&series, &quadratic, &monomials, &followed).unwrap();
            for (mode, pair) in followed.iter().zip(pairs) {
                let mut distances: Vec<(f64, usize)> =
                    exact.iter().map(|value| magnitude(value - pair.eigenvalue)).zip(0..).collect();
                distances.sort_by(|a, b| a.0.total_cmp(&b.0));
                let nearest = distances[0].0;
                // No two pairs are one eigenvalue where errors tell them from the next.
                if distances.get(1).is_none_or(|second| 2.0 * pair.error + 1e-9 < second.0) {
                    assert!(!taken.contains(&distances[0].1), "problem {seed}: two pairs at {pair:?}");
                    taken.push(distances[0].1);
                }
                assert!(nearest <= pair.error + 1e-10, "problem {seed}: {mode:?} {pair:?} off by {nearest}");
                compared += 1;
                smaller += usize::from(pair.error < 0.3 * mode.radius);
            }
        }
    }
    assert!(compared > 1000 && smaller > compared / 10, "{compared} {smaller}");
}

/// Two damped masses of Hoffmann and Gaul (2003): with c1 = 0.02, c2 = 0.05, k11 = 2, k22 = 2.2 and k12 = 1 they flutter
/// above `D = (a1 (a3 a2 - a1) / a3^2 - (k11 k22 - k12^2)) / k12`.
#[test]
fn verdicts_turn_at_the_criterion_of_hurwitz() {
    let (c1, c2, k11, k22, k12) = (0.02, 0.05, 2.0, 2.2, 1.0);
    let (a3, a2, a1) = (c1 + c2, k11 + k22 + c1 * c2, c1 * k22 + c2 * k11);
    let critical = (a1 * (a3 * a2 - a1) / (a3 * a3) - (k11 * k22 - k12 * k12)) / k12;
    let terms = [dmatrix![k11, k12; k12, k22], dmatrix![0.0, -1.0; 0.0, 0.0]];
    let damping = [dmatrix![c1, 0.0; 0.0, c2]];
    let problem = DenseQuadratic::new(&DMatrix::identity(2, 2), &damping, &terms, &[1.0; 3]).unwrap();
    let region = Region { lowest: 0.0, highest: f64::INFINITY, damping_ratio: 0.0 };
    let decider = Decider::of_any(&problem, std::slice::from_ref(&region), None);
    for distance in [1e-7, 1e-4, 0.1, 0.5] {
        for (friction, expected) in [(critical - distance, false), (critical + distance, true)] {
            let found = decider.is_unstable(&[1.0, 1.0, friction]);
            assert_eq!(found, Some((expected, Way::ClosedForm)), "{friction}");
        }
    }
}

/// A chain of masses with friction between neighbours: eigenvalues by vector instructions tell what all eigenvalues tell, and
/// nothing where the threshold is at one of them.
#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn large_problems_are_decided_by_fast_eigenvalues_where_these_are_clear() {
    let size = LARGE + 6;
    let (mut clear, mut unstable) = (0, 0);
    for seed in 0..60 {
        let mut numbers = Numbers(seed);
        let frequency: Vec<f64> = (0..size).map(|_| 1.0 + 0.4 * numbers.next()).collect();
        let diagonal =
            DMatrix::from_diagonal(&frequency.iter().map(|frequency| frequency * frequency).collect::<Vec<_>>().into());
        let friction = DMatrix::from_fn(size, size, |i, j| if i == j { 0.0 } else { 0.01 * numbers.normal() });
        let damping = DMatrix::identity(size, size) * 0.01;
        let problem =
            DenseQuadratic::new(&DMatrix::identity(size, size), &[damping], &[diagonal, friction], &[1.0; 3]).unwrap();
        let region = Region { lowest: 0.1, highest: 10.0, damping_ratio: 0.0 }.in_unit(problem.unit());
        for friction in [0.1, 0.3, 0.5, 1.0] {
            let quadratic = problem.at(&[1.0, 1.0, friction]);
            let all = quadratic.eigenvalues().unwrap();
            let expected = all.iter().any(|value| region.contains(*value));
            let decider = Decider::of_any(&problem, std::slice::from_ref(&region), None);
            let told = decider.clear(&quadratic);
            assert!(told.is_none_or(|told| (told != 0) == expected), "{seed} {friction}");
            assert_eq!(decider.is_unstable(&[1.0, 1.0, friction]), Some((expected, Way::All)));
            (clear, unstable) = (clear + usize::from(told.is_some()), unstable + usize::from(expected));
            let oscillating = all.iter().filter(|value| value.im > 0.0);
            let least = oscillating.map(|value| damping_ratio(*value)).fold(f64::INFINITY, f64::min);
            let at_the_threshold = Region { damping_ratio: least, ..region };
            let decider = Decider::of_any(&problem, std::slice::from_ref(&at_the_threshold), None);
            assert_eq!(decider.clear(&quadratic), None, "{seed} {friction}");
        }
    }
    assert!(clear > 200 && (40..200).contains(&unstable), "{clear} {unstable}");
}

/// Two close modes that friction alone couples, and a third far off: nothing but their coupling changes, so that vectors of
/// second order vanish but for those of the conjugate modes.
#[test]
fn modes_that_move_alike_are_decided_rightly() {
    let mut ways = [0; 5];
    for seed in 0..400_u64 {
        let mut numbers = Numbers(seed);
        let gap = 0.005 + 0.02 * (1.0 + numbers.next());
        let problem = close_modes(gap, 2e-3 * (1.5 + numbers.next()));
        let expected = 0.25 + 0.2 * numbers.next();
        let origin = [1.0, 1.0, expected];
        // The threshold lies near the damping ratio of the less damped of the two.
        let threshold = 2e-4 * (1.0 + 0.5 * numbers.next());
        let region = Region { lowest: 0.3, highest: 3.0, damping_ratio: threshold }.in_unit(problem.unit());
        let series = ModeSeries::new(&problem, &origin, &[2], &[region], 1 << 24);
        let series = series.unwrap();
        let decider = Decider::of_any(&problem, std::slice::from_ref(&region), Some(&series));
        for step in -40..=40 {
            let coefficients = [1.0, 1.0, expected * (1.0 + 0.02 * f64::from(step))];
            let all = problem.at(&coefficients).eigenvalues().unwrap();
            let off = |from: Eigenvalue| all.iter().map(|value| magnitude(value - from)).fold(f64::INFINITY, f64::min);
            if let Some((monomials, followed)) = series.follow(&coefficients) {
                let pairs = vector_pairs(&series, &problem.at(&coefficients), &monomials, &followed).unwrap();
                for (mode, pair) in followed.iter().zip(pairs) {
                    let [by_series, by_vectors] = [off(mode.eigenvalue), off(pair.eigenvalue)];
                    assert!(by_series <= mode.radius + 1e-10, "{seed} {coefficients:?} {mode:?} off by {by_series}");
                    assert!(by_vectors <= pair.error + 1e-10, "{seed} {coefficients:?} {pair:?} off by {by_vectors}");
                }
            }
            let (_, way) = compared(&decider, seed, &coefficients);
            ways[way as usize] += 1;
        }
    }
    assert!(ways[Way::Series as usize] > 1000 && ways[Way::Vectors as usize] > 20, "{ways:?}");
}

/// Modes apart from each other at the origin that meet within the scatter, coupled so weakly that what couples each with its
/// conjugate hides it: they flutter in a narrow window.
#[test]
fn modes_that_meet_far_from_the_origin_are_decided_rightly() {
    let mut ways = [0; 5];
    for seed in 0..200_u64 {
        let mut numbers = Numbers(seed);
        (0..5).for_each(|_| _ = numbers.next());
        let size = 3 + seed as usize % 3;
        let gap = 0.05 + 0.1 * (1.0 + numbers.next());
        let coupling = libm::pow(10.0, -3.0 + numbers.next()) * if seed % 4 == 0 { 0.0 } else { 1.0 };
        let mut stiffness = DMatrix::from_fn(size, size, |i, j| if i == j { 1.0 + 3.0 * i as f64 } else { 0.0 });
        (stiffness[(0, 0)], stiffness[(1, 1)]) = (0.0, 1.0 + gap);
        let ratio = 1.5 + numbers.next();
        (stiffness[(0, 1)], stiffness[(1, 0)]) = (coupling, -coupling * ratio);
        let mut growing = DMatrix::zeros(size, size);
        growing[(0, 0)] = 1.0;
        // Where they meet they grow by half of their coupling.
        let damping = DMatrix::identity(size, size) * (0.7 * coupling * ratio.sqrt() + 1e-6);
        let mass = DMatrix::identity(size, size);
        let problem = DenseQuadratic::new(&mass, &[damping], &[stiffness, growing], &[1.0; 3]).unwrap();
        let region = Region { lowest: 0.0, highest: f64::INFINITY, damping_ratio: 0.0 };
        let origin = [1.0, 1.0, 1.0 + 0.2 * gap];
        let series = ModeSeries::new(&problem, &origin, &[2], &[region], 1 << 24);
        let decider = Decider::of_any(&problem, std::slice::from_ref(&region), series.as_ref());
        let mut unstable = 0;
        for step in -60..=60 {
            // Most of them in the window and beside it.
            let part = f64::from(step) / 60.0;
            let coefficients = [1.0, 1.0, 1.0 + gap + 3.0 * coupling * part + 0.2 * gap * part * part * part];
            let (expected, way) = compared(&decider, seed, &coefficients);
            ways[way as usize] += 1;
            unstable += usize::from(expected);
        }
        assert!(coupling == 0.0 || unstable > 10, "{seed}: {unstable}");
    }
    assert!(ways[Way::Series as usize] > 100, "{ways:?}");
}

/// Two modes with 18 % between them at the origin, whose window of flutter is known from 60 digits: what couples them is a
/// tenth of what couples one with its conjugate.
#[test]
fn a_narrow_window_far_from_the_origin_is_not_told_by_the_series() {
    let mass =
        DMatrix::from_diagonal(&dvector![0.239_009_797_546_498_3, 0.297_303_684_654_721_7, 0.213_824_721_020_789_7]);
    let damping =
        DMatrix::from_diagonal(&dvector![26.688_917_747_682_524, 7.408_016_499_366_854, 0.589_654_761_997_416_7]);
    let stiffness = dmatrix![
        61_234_366.847_998_53, -462_081.513_883_681_2, 0.0;
        157_400.636_464_176_47, 6_079_403.887_054_545, 0.0;
        0.0, 0.0, 194_861_469.479_869_2
    ];
    let growing = DMatrix::from_diagonal(&dvector![0.0, 439_698_186.638_907_8, 0.0]);
    let problem = DenseQuadratic::new(&mass, &[damping], &[stiffness, growing], &[1.0, 1.0, 0.13]).unwrap();
    let region = Region { lowest: 0.0, highest: f64::INFINITY, damping_ratio: 0.0 };
    let series = ModeSeries::new(&problem, &[1.0, 1.0, 0.130_714_89], &[2], &[region], 1 << 24);
    assert!(series.is_some());
    let decider = Decider::of_any(&problem, std::slice::from_ref(&region), series.as_ref());
    let (from, to) = (0.158_423_438_233_07, 0.160_375_254_412_9);
    for (p, expected) in
        [(0.15, false), (from - 1e-8, false), (from + 1e-8, true), (0.159, true), (to - 1e-8, true), (to + 1e-8, false)]
    {
        let found = decider.is_unstable(&[1.0, 1.0, p]).map(|(is_unstable, _)| is_unstable);
        assert_eq!(found, Some(expected), "{p}");
    }
}

/// Pairs that friction couples, each a group, and nothing with each other but by rounding: they cross within the scatter.
#[test]
fn groups_that_nothing_couples_are_told_by_the_series_where_they_cross() {
    let size = 12;
    let friction = 0.7;
    let scale = |i: usize| 1.0 + 0.1 * (i / 2) as f64;
    let own = |i: usize, j: usize| i / 2 == j / 2;
    let of = |entry: &dyn Fn(usize, usize) -> f64| {
        DMatrix::from_fn(size, size, |i, j| if own(i, j) { scale(i) * entry(i, j) } else { 0.0 })
    };
    let stiffness = [
        of(&|i, j| if i == j { 2.0 } else { 1.0 }),
        of(&|i, j| if i % 2 == 0 && j == i + 1 { -4.0 / 3.0 } else { 0.0 }),
    ];
    let damping = [DMatrix::identity(size, size) * 0.001];
    let mass = DMatrix::identity(size, size);
    let problem = DenseQuadratic::new(&mass, &damping, &stiffness, &[1.0, 1.0, friction]).unwrap();
    let region = Region { lowest: 0.0, highest: f64::INFINITY, damping_ratio: 0.0 };
    let series = ModeSeries::new(&problem, &[1.0, 1.0, friction], &[2, 0], &[region], 1 << 24);
    let decider = Decider::of_any(&problem, std::slice::from_ref(&region), series.as_ref());
    let mut ways = [0; 5];
    let mut numbers = Numbers(3);
    for _ in 0..500 {
        let coefficients = [1.0 + 0.1 * numbers.normal(), 1.0, friction * (1.0 + 0.1 * numbers.normal())];
        let all = problem.at(&coefficients).eigenvalues().unwrap();
        let (found, way) = decider.is_unstable(&coefficients).unwrap();
        assert_eq!(found, all.iter().any(|value| region.contains(*value)), "{coefficients:?}");
        ways[way as usize] += 1;
    }
    assert!(ways[Way::Series as usize] > 450, "{ways:?}");
}

/// A mode that moves through two others, which changes couple with each other to a group. What couples it with them is little beside
/// what couples each mode with its conjugate.
#[test]
fn a_group_and_a_mode_that_meets_it_are_decided_rightly() {
    let mut ways = [0; 5];
    let mut unstable = 0;
    for seed in 0..100_u64 {
        let mut numbers = Numbers(seed);
        (0..5).for_each(|_| _ = numbers.next());
        let gap = 0.05 + 0.1 * (1.0 + numbers.next());
        let of_group = 0.05 * gap;
        let coupling = of_group * libm::pow(10.0, -2.0 + numbers.next());
        let origin = 1.0 + 0.2 * gap;
        let mut stiffness = DMatrix::from_diagonal(&dvector![0.0, 1.0 + gap, 1.0 + gap + of_group, 4.0]);
        let mut growing = DMatrix::zeros(4, 4);
        growing[(0, 0)] = 1.0;
        for (i, j) in [(1, 2), (2, 1)] {
            (growing[(i, j)], stiffness[(i, j)]) = (3.0 * of_group, -3.0 * of_group * origin);
        }
        let ratio = 1.5 + numbers.next();
        // The mode acts on both and both on it, or one drives it and it drives the other.
        let [drives, is_driven] = [[true, true], [true, false], [false, true]][seed as usize % 3];
        for (mode, to, from) in [(1, drives, is_driven), (2, is_driven, drives)] {
            stiffness[(mode, 0)] = if to { -coupling * ratio } else { 0.0 };
            stiffness[(0, mode)] = if from { coupling } else { 0.0 };
        }
        // Where they meet they grow by half of their coupling.
        let damping = DMatrix::identity(4, 4) * (0.7 * coupling * ratio.sqrt() + 1e-6);
        let mass = DMatrix::identity(4, 4);
        let problem = DenseQuadratic::new(&mass, &[damping], &[stiffness, growing], &[1.0; 3]).unwrap();
        let region = Region { lowest: 0.0, highest: f64::INFINITY, damping_ratio: 0.0 };
        let series = ModeSeries::new(&problem, &[1.0, 1.0, origin], &[2], &[region], 1 << 24);
        let decider = Decider::of_any(&problem, std::slice::from_ref(&region), series.as_ref());
        for step in -90..=90 {
            let part = f64::from(step) / 60.0;
            let centre = 1.0 + gap + if part < 0.0 { 0.0 } else { of_group };
            let coefficients = [1.0, 1.0, centre + 3.0 * coupling * part + 0.1 * of_group * part * part * part];
            let (expected, way) = compared(&decider, seed, &coefficients);
            ways[way as usize] += 1;
            unstable += usize::from(expected);
        }
    }
    assert!(unstable > 500, "{unstable} {ways:?}");
}

/// A mode below the band is told by its vectors, whose eigenvalue is a little beyond the threshold where the exact one is
/// not; the same mode in the upper half plane has to be refined.
#[test]
fn what_vectors_tell_is_not_asked_of_their_eigenvalues() {
    let (problem, origin, region) = problem(1165);
    let coefficients =
        [1.0, 0.966_932_845_701_144_1, 0.636_324_029_247_461_7, 0.720_962_775_729_800_7, 0.399_107_266_381_437_2, 1.0];
    let series = ModeSeries::new(&problem, &origin, &[1, 2, 3, 4], &[region], 1 << 24);
    let decider = Decider::of_any(&problem, std::slice::from_ref(&region), series.as_ref());
    assert_eq!(decider.is_unstable(&coefficients), Some((false, Way::Refined)));
}
