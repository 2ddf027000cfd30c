//! Probabilities from maps against the closed form, midpoint rules and differences.

use super::*;
use crate::integrate::closed_form;
use crate::special_functions::normal;
use crate::verdict_map::tile::{Tile, TileIndex};
use proptest::prelude::*;
use std::sync::LazyLock;
use stickslip_core::model::pair_boundary::PairBoundary;
use stickslip_core::models::pad_on_disc::parameters::Parameters;
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;

const KINETIC: f64 = 0.25;

fn cell(preload: f64, static_friction: f64, preload_std: f64, friction_std: f64) -> NormalPair {
    NormalPair { expected: [preload, static_friction], relative_std: [preload_std, friction_std] }
}

/// A map of the tiles up to 2 for which `has` holds.
fn map_of(verdict_at: impl Fn(f64, f64) -> Verdict, has: impl Fn(TileIndex) -> bool) -> VerdictMap {
    let mut map = VerdictMap::new(KINETIC);
    for index in (0..12).flat_map(|row| (0..12).map(move |column| TileIndex { column, row })) {
        if has(index) {
            let verdicts = |points: &[[f64; 2]]| points.iter().map(|[x, y]| Some(verdict_at(*x, *y))).collect();
            map.insert(index, Tile::resolve(index, verdicts).unwrap());
        }
    }
    map
}

fn boundary() -> PairBoundary {
    let mut parameters = Parameters::sui_ding_2018();
    parameters.set("operating_point.rotating_speed", 15.0).unwrap();
    let boundary = PadOnDisc::new(parameters).unwrap().stability_boundary();
    assert_eq!(boundary.asymptote(), KINETIC);
    boundary
}

fn hyperbola_map() -> VerdictMap {
    let boundary = boundary();
    map_of(|x, y| boundary.verdict(x, y + KINETIC), |_| true)
}

/// The probability of a cell from a map that is used once.
fn probability(map: &VerdictMap, cell: &NormalPair) -> BoundedProbability {
    MapRegions::new(map).probability(cell)
}

/// Probabilities of stable, unstable and other verdicts, and the integrals of the scores over what is unstable: a
/// plain midpoint rule over both deviates, outside physics being stable.
fn by_midpoints(verdict_at: impl Fn(f64, f64) -> Verdict, cell: &NormalPair) -> ([f64; 3], [f64; 4]) {
    let NormalPair { expected: [preload, static_friction], relative_std: std } = *cell;
    let deviates = |std: f64| -> Vec<(f64, f64)> {
        if std == 0.0 {
            return vec![(0.0, 1.0)];
        }
        let points = 4000;
        let step = 15.0 / f64::from(points);
        (0..points)
            .map(|i| -7.5 + step * (f64::from(i) + 0.5))
            .map(|z| (z, step * (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt()))
            .collect()
    };
    let frictions = deviates(std[1]);
    let (mut masses, mut scores) = ([0.0; 3], [0.0; 4]);
    for (z1, weight1) in deviates(std[0]) {
        let x = preload * (1.0 + std[0] * z1);
        for &(z2, weight2) in &frictions {
            let y = static_friction * (1.0 + std[1] * z2) - KINETIC;
            let weight = weight1 * weight2;
            match if x <= 0.0 || y < 0.0 { Verdict::Stable } else { verdict_at(x, y) } {
                Verdict::Stable => masses[0] += weight,
                Verdict::Unstable => {
                    masses[1] += weight;
                    scores[0] += weight * (z1 + std[0] * (z1 * z1 - 1.0)) / (preload * std[0]);
                    scores[1] += weight * (z2 + std[1] * (z2 * z2 - 1.0)) / (static_friction * std[1]);
                    scores[2] += weight * (z1 * z1 - 1.0) / std[0];
                    scores[3] += weight * (z2 * z2 - 1.0) / std[1];
                }
                Verdict::Undecided | Verdict::Failed => masses[2] += weight,
            }
        }
    }
    (masses, scores)
}

#[test]
fn a_hyperbola_has_its_exact_probability_and_derivatives() {
    let (boundary, map) = (boundary(), hyperbola_map());
    let regions = MapRegions::new(&map);
    let mut unstable = 0;
    for preload in [0.01, 0.05, 0.1, 0.2, 0.3] {
        for friction in [0.25, 0.3, 0.39, 0.5] {
            for (preload_std, friction_std) in
                [(0.2, 0.2), (0.3, 0.05), (0.02, 0.3), (0.1, 1e-4), (1e-4, 0.1), (1e-3, 1e-3), (0.2, 0.0), (0.0, 0.2)]
            {
                let cell = cell(preload, friction, preload_std, friction_std);
                let exact = closed_form::probability(&boundary, &cell);
                let mapped = regions.probability(&cell);
                assert!(mapped.low <= exact.value && exact.value <= mapped.high, "{cell:?}: {exact:?} {mapped:?}");
                assert!((mapped.value.unwrap() - exact.value).abs() < 1e-5, "{cell:?}: {exact:?} {mapped:?}");
                assert!(mapped.low <= mapped.value.unwrap() && mapped.value.unwrap() <= mapped.high, "{mapped:?}");
                assert_eq!(mapped.undecided, 0.0);
                unstable += u32::from(exact.value > 0.01 && exact.value < 0.99);
                let derivatives = closed_form::derivatives(&boundary, &cell);
                for (i, (mapped, exact)) in mapped.derivatives.0.into_iter().zip(derivatives.0).enumerate() {
                    assert_eq!(mapped.is_some(), [preload_std, friction_std][i % 2] > 0.0);
                    let (Some(mapped), Some(exact)) = (mapped, exact) else { continue };
                    let scale = [preload * preload_std, friction * friction_std, preload_std, friction_std][i];
                    // In units of the scatter; where it is tiny against the map's resolution (4e-6 of the coordinate,
                    // 0.04 for a standard deviation of 1e-4) the boundary's place in it is only known to that.
                    let resolution = 1e-5 + 4e-6 / preload_std.max(friction_std).max(1e-9);
                    let error = (mapped - exact).abs() * scale;
                    assert!(error < resolution.max(1e-4 * exact.abs() * scale), "{cell:?} {i}: {mapped} {exact}");
                }
            }
        }
    }
    assert!(unstable > 40, "{unstable}");
}

#[test]
fn derivatives_are_accurate_to_a_ten_thousandth() {
    let (boundary, map) = (boundary(), hyperbola_map());
    for cell in [cell(0.1, 0.39, 0.2, 0.2), cell(0.05, 0.45, 0.3, 0.1), cell(0.2, 0.32, 0.1, 0.05)] {
        let mapped = probability(&map, &cell);
        assert!(mapped.high - mapped.low < 2e-4, "{mapped:?}");
        let exact = closed_form::derivatives(&boundary, &cell);
        for (mapped, exact) in mapped.derivatives.0.into_iter().zip(exact.0) {
            let (mapped, exact) = (mapped.unwrap(), exact.unwrap());
            assert!((mapped - exact).abs() < 1e-4 * exact.abs().max(0.1), "{cell:?}: {mapped} {exact}");
        }
    }
}

#[test]
fn the_bounds_hold_for_small_scatter_around_the_boundary() {
    let (boundary, map) = (boundary(), hyperbola_map());
    for std in [1e-2, 1e-3, 1e-4, 1e-5] {
        for shift in [-3.0, -1.0, 0.0, 0.5, 2.0] {
            for (preload_std, friction_std) in [(std, std), (std, 0.0), (0.0, std), (0.1, std), (std, 0.1)] {
                let friction = boundary.critical_second(0.1) * (1.0 + shift * std);
                let cell = cell(0.1, friction, preload_std, friction_std);
                let exact = closed_form::probability(&boundary, &cell).value;
                let mapped = probability(&map, &cell);
                assert!(mapped.low <= exact && exact <= mapped.high, "{cell:?}: {exact} {mapped:?}");
                assert!(mapped.high - mapped.low < 3e-5 / std + 1e-5, "{cell:?}: {mapped:?}");
            }
        }
    }
}

#[test]
fn a_step_beside_the_end_of_a_box_is_seen() {
    // The preload scatters widely, the friction hardly: the conditional probability passes from 0 to 1 within less
    // than the distance of the outermost abscissa from the end of the tile at 1/8.
    let (boundary, map) = (boundary(), hyperbola_map());
    for distance in [-2e-4, -1e-4, -3e-5, 3e-5, 1e-4, 2e-4] {
        let friction = boundary.critical_second(0.125 + distance);
        for friction_std in [1e-4, 1e-5, 1e-6] {
            let cell = cell(0.125, friction, 0.1, friction_std);
            let exact = closed_form::probability(&boundary, &cell).value;
            let mapped = probability(&map, &cell);
            assert!(mapped.low <= exact && exact <= mapped.high, "{distance} {cell:?}: {exact} {mapped:?}");
            assert!(mapped.high - mapped.low < 2e-3, "{mapped:?}");
        }
    }
}

/// A boundary with a corner, a second branch, a hole and an island.
fn branches(x: f64, y: f64) -> Verdict {
    let first = x * y > 0.02 && y > 0.11 - 0.05 * x;
    let lens = (x - 0.6).powi(2) + (2.0 * (y - 0.05)).powi(2) < 0.0025;
    let gap = (x - 0.5).powi(2) + (y - 0.7).powi(2) < 0.01;
    let slot = x < 0.1 && y > 0.6;
    if (first || lens) && !gap && !slot { Verdict::Unstable } else { Verdict::Stable }
}

#[test]
fn corners_branches_and_islands_agree_with_midpoints() {
    let map = map_of(branches, |_| true);
    for cell in [
        cell(0.2, 0.35, 0.3, 0.2),
        cell(0.6, 0.3, 0.1, 0.1),
        cell(0.5, 0.95, 0.2, 0.1),
        cell(0.1, 0.85, 0.1, 0.02),
        cell(0.6, 0.3, 0.1, 0.0),
        cell(0.5, 0.95, 0.0, 0.1),
    ] {
        let mapped = probability(&map, &cell);
        let (masses, scores) = by_midpoints(branches, &cell);
        let one_scatters = cell.relative_std[0] * cell.relative_std[1] == 0.0;
        // The rule misplaces a boundary across one line of its points by up to half a step.
        let tolerance = if one_scatters { 4e-3 } else { 5e-5 };
        assert!((mapped.value.unwrap() - masses[1]).abs() < tolerance, "{cell:?}: {mapped:?} {masses:?}");
        assert!(mapped.low - tolerance < masses[1] && masses[1] < mapped.high + tolerance, "{cell:?}: {mapped:?}");
        assert!(mapped.high - mapped.low < 1e-3, "{mapped:?}");
        for (derivative, score) in mapped.derivatives.0.into_iter().zip(scores) {
            let Some(derivative) = derivative else { continue };
            assert!(
                (derivative - score).abs() < 20.0 * tolerance * score.abs().max(1.0),
                "{cell:?}: {derivative} {score}"
            );
        }
    }
}

#[test]
fn undecided_samples_widen_the_bounds_and_are_no_part_of_the_value() {
    let verdict_at = |x: f64, y: f64| match x * y {
        product if product > 0.05 => Verdict::Unstable,
        product if product > 0.03 => Verdict::Undecided,
        product if product > 0.025 => Verdict::Failed,
        _ => Verdict::Stable,
    };
    let map = map_of(verdict_at, |_| true);
    for cell in [cell(0.2, 0.45, 0.2, 0.1), cell(0.3, 0.4, 0.1, 0.1)] {
        let mapped = probability(&map, &cell);
        let ([stable, unstable, other], _) = by_midpoints(verdict_at, &cell);
        assert!(other > 0.1 && unstable > 0.05);
        assert!((mapped.undecided - other).abs() < 3e-5, "{mapped:?} {other}");
        assert!((mapped.value.unwrap() - unstable / (stable + unstable)).abs() < 5e-5, "{mapped:?}");
        assert!((mapped.low - unstable).abs() < 1e-4 && (mapped.high - 1.0 + stable).abs() < 1e-4, "{mapped:?}");
        // The quotient's derivatives, by differences of the value.
        let value = |cell: &NormalPair| probability(&map, cell).value.unwrap();
        let (mut up, mut down) = (cell, cell);
        up.expected[0] *= 1.005;
        down.expected[0] *= 0.995;
        let by_preload = (value(&up) - value(&down)) / (0.01 * cell.expected[0]);
        assert!((mapped.derivatives.0[0].unwrap() / by_preload - 1.0).abs() < 2e-3, "{mapped:?} {by_preload}");
        up.expected[0] = cell.expected[0];
        down.expected[0] = cell.expected[0];
        up.relative_std[1] *= 1.01;
        down.relative_std[1] *= 0.99;
        let by_std = (value(&up) - value(&down)) / (0.02 * cell.relative_std[1]);
        let mapped = mapped.derivatives.0[3].unwrap();
        assert!((mapped - by_std).abs() < 3e-3 * by_std.abs().max(0.1), "{mapped} {by_std}");
    }
}

#[test]
fn missing_tiles_widen_the_bounds_by_their_probability() {
    let whole = hyperbola_map();
    let boundary = boundary();
    // Two tiles, one on each side of the boundary: preload 1/8 to 1/4, falling friction 1/4 to 3/8 and 0 to 1/8.
    let is_missing = |index: TileIndex| index.column == 1 && (index.row == 2 || index.row == 0);
    let map = map_of(|x, y| boundary.verdict(x, y + KINETIC), |index| !is_missing(index));
    let cell = cell(0.15, 0.45, 0.3, 0.3);
    let (whole, part) = (probability(&whole, &cell), probability(&map, &cell));
    let mass = |from: f64, to: f64, expected: f64, std: f64| {
        normal::cumulative((to - expected) / std) - normal::cumulative((from - expected) / std)
    };
    let missing = mass(0.125, 0.25, 0.15, 0.045) * (mass(0.5, 0.625, 0.45, 0.135) + mass(0.25, 0.375, 0.45, 0.135));
    let widened = (part.high - part.low) - (whole.high - whole.low);
    // The gaps in the missing tiles are now part of the missing probability.
    assert!((widened - missing).abs() < 2e-5 && missing > 0.1, "{widened} {missing}");
    assert!(part.low < whole.low && whole.high < part.high && part.value != whole.value);
    // A tile that is unstable throughout has no gap.
    let map = map_of(|x, y| boundary.verdict(x, y + KINETIC), |index| index != TileIndex { column: 1, row: 2 });
    let part = probability(&map, &cell);
    let missing = mass(0.125, 0.25, 0.15, 0.045) * mass(0.5, 0.625, 0.45, 0.135);
    assert!((whole.low - part.low - missing).abs() < 1e-13 && (whole.high - part.high).abs() < 1e-13, "{part:?}");
}

#[test]
fn without_tiles_only_outside_physics_is_known() {
    let map = VerdictMap::new(KINETIC);
    let mapped = probability(&map, &cell(0.1, 0.3, 0.5, 0.2));
    let inside = normal::upper_tail(-2.0) * normal::upper_tail(-0.05 / 0.06);
    assert!((mapped.high - inside).abs() < 2e-14 && mapped.low == 0.0 && mapped.value == Some(0.0), "{mapped:?}");
    let unknown = probability(&map, &cell(0.1, 0.3, 0.0, 0.0));
    assert_eq!((unknown.low, unknown.value, unknown.high), (0.0, None, 1.0));
    assert_eq!(unknown.derivatives, Derivatives::default());
}

#[test]
fn without_scatter_the_probability_is_the_verdict() {
    let (boundary, map) = (boundary(), hyperbola_map());
    // A preload on the edge of a tile, and one of 0.
    for preload in [0.0, 0.05, 0.125, 0.3] {
        for friction in [0.2, 0.25, 0.375, 0.3, 0.5, 0.75] {
            let mapped = probability(&map, &cell(preload, friction, 0.0, 0.0));
            let expected = f64::from(u8::from(boundary.verdict(preload, friction) == Verdict::Unstable));
            assert_eq!(mapped.value, Some(expected), "{preload} {friction}: {mapped:?}");
            assert!((mapped.high - mapped.low) < 1e-13, "{preload} {friction}: {mapped:?}");
        }
    }
    let on_boundary = probability(&map, &cell(0.1, boundary.critical_second(0.1), 0.0, 0.0));
    assert_eq!((on_boundary.low, on_boundary.high), (0.0, 1.0));
    // A preload of 0 is outside physics, even if the tiles that begin there are unstable.
    let unstable = map_of(|_, _| Verdict::Unstable, |_| true);
    for std in [0.0, 0.2] {
        let without_preload = probability(&unstable, &cell(0.0, 0.5, std, 0.2));
        assert!(without_preload.value == Some(0.0) && without_preload.high < 1e-14, "{without_preload:?}");
    }
}

static HYPERBOLA: LazyLock<MapRegions> = LazyLock::new(|| MapRegions::new(&hyperbola_map()));

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn the_exact_probability_is_within_the_bounds(
        preload in 0.005..0.6,
        friction in 0.2..0.9,
        preload_std in -11.0..-0.7,
        friction_std in -11.0..-0.7,
    ) {
        let cell = cell(preload, friction, libm::exp(preload_std), libm::exp(friction_std));
        let exact = closed_form::probability(&boundary(), &cell);
        let mapped = HYPERBOLA.probability(&cell);
        prop_assert!(mapped.low - exact.error_bound <= exact.value, "{:?} {:?}", exact, mapped);
        prop_assert!(exact.value <= mapped.high + exact.error_bound, "{:?} {:?}", exact, mapped);
        prop_assert!(mapped.low <= mapped.value.unwrap() && mapped.value.unwrap() <= mapped.high, "{:?}", mapped);
    }
}
