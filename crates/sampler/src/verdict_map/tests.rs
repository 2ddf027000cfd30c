//! Maps of planes whose verdicts are known.

use stickslip_core::model::verdict::Verdict;

use super::boundary_curve::Point;
use super::map::VerdictMap;
use super::resolve::MOST_QUESTIONS;
use super::tile::{Node, TILES, Tile, TileIndex, edge, tile_at};

#[test]
fn tiles_cover_the_plane_without_gaps() {
    for index in 0..TILES {
        let (from, to) = (edge(index), edge(index + 1));
        assert!(from < to);
        for coordinate in [from, 0.5 * (from + to), to.next_down()] {
            assert_eq!(tile_at(coordinate), Some(index), "{coordinate}");
        }
    }
    assert_eq!(edge(TILES), 64.0);
    assert_eq!([-1e-300, 64.0, f64::NAN, f64::INFINITY].map(tile_at), [None; 4]);
}

/// A map of all tiles up to 1 of a plane whose verdicts are known, and the questions that it took.
fn map_of(verdict_at: impl Fn(Point) -> Verdict) -> (VerdictMap, u64) {
    let mut map = VerdictMap::new(0.25);
    let mut questions = 0;
    for row in 0..8 {
        for column in 0..8 {
            let index = TileIndex { column, row };
            let tile =
                Tile::resolve(index, |points| points.iter().map(|&point| Some(verdict_at(point))).collect()).unwrap();
            questions += tile.questions;
            assert_eq!(Tile::from_nodes(tile.nodes().to_vec(), tile.questions), Some(tile.clone()));
            map.insert(index, tile);
        }
    }
    (map, questions)
}

/// Looks up a point of the plane.
fn look_up(map: &VerdictMap, point: Point) -> Option<Verdict> {
    let [preload, static_friction] = map.inputs(point);
    map.look_up(preload, static_friction)
}

/// Looks up a fine grid and checks every answer. Returns the share of points without an answer.
fn assert_right(map: &VerdictMap, verdict_at: impl Fn(Point) -> Verdict) -> f64 {
    let (mut silent, count) = (0, 1500);
    for i in 0..count {
        for j in 0..count {
            // Irrational steps, so that no point of the grid of a box is hit.
            let point = [(f64::from(i) + 0.414_213) / f64::from(count), (f64::from(j) + 0.732_05) / f64::from(count)];
            match look_up(map, point) {
                Some(verdict) => assert_eq!(verdict, verdict_at(point), "{point:?}"),
                None => silent += 1,
            }
        }
    }
    f64::from(silent) / f64::from(count * count)
}

#[test]
fn a_hyperbola_is_mapped() {
    let verdict_at = |[x, y]: Point| if x * y > 0.0135 { Verdict::Unstable } else { Verdict::Stable };
    let (map, questions) = map_of(verdict_at);
    let silent = assert_right(&map, verdict_at);
    assert!(silent < 1e-5 && questions < 30_000, "{silent} {questions}");
}

#[test]
fn two_branches_a_corner_and_an_island_are_mapped() {
    let verdict_at = |[x, y]: Point| {
        let hyperbola = x * y > 0.02 && y > 0.11 - 0.05 * x;
        let lens = (x - 0.6).powi(2) + (2.0 * (y - 0.05)).powi(2) < 0.0025;
        let gap = (x - 0.5).powi(2) + (y - 0.7).powi(2) < 0.01;
        if (hyperbola || lens) && !gap { Verdict::Unstable } else { Verdict::Stable }
    };
    let (map, questions) = map_of(verdict_at);
    let silent = assert_right(&map, verdict_at);
    assert!(silent < 1e-5 && questions < 100_000, "{silent} {questions}");
}

#[test]
fn a_boundary_that_dips_into_a_tile_between_its_grid_points_is_seen() {
    // Discs that reach 0.0004 beyond a line between tiles, and that far only between two points of the grid.
    let radius = 0.2664;
    for (centre, tip) in [(0.516, 0.516 - radius), (0.484, 0.484 + radius)] {
        let verdict_at = |[x, y]: Point| {
            let is_inside = (x - centre).powi(2) + (y - centre).powi(2) < radius * radius;
            if is_inside { Verdict::Unstable } else { Verdict::Stable }
        };
        let (map, _) = map_of(verdict_at);
        let just_inside = tip + 1e-4 * (centre - tip).signum();
        for point in [[centre, just_inside], [just_inside, centre]] {
            assert_eq!(verdict_at(point), Verdict::Unstable);
            assert_eq!(look_up(&map, point), Some(Verdict::Unstable), "{point:?}");
        }
        assert_right(&map, verdict_at);
    }
}

#[test]
fn undecided_samples_have_a_region_of_their_own() {
    let verdict_at = |[x, y]: Point| match x * y {
        product if product > 0.05 => Verdict::Unstable,
        product if product > 0.03 => Verdict::Undecided,
        product if product > 0.02999 => Verdict::Failed,
        _ => Verdict::Stable,
    };
    let (map, questions) = map_of(verdict_at);
    let index = TileIndex::at(0.2, 0.2).unwrap();
    assert_eq!(map.tile(index).unwrap().look_up(index, [0.2, 0.2]), Some(Verdict::Undecided));
    assert_eq!(look_up(&map, [0.2, 0.2]), None, "such a sample is simulated");
    // Undecided are 4 % of the plane; what lies beside them is known but for the smallest boxes at the corners of
    // bands.
    let silent = assert_right(&map, verdict_at);
    let undecided = 0.05 * (1.0 - 0.05_f64.ln()) - 0.03 * (1.0 - 0.03_f64.ln());
    assert!((silent - undecided).abs() < 5e-3 && questions < 120_000, "{silent} {undecided} {questions}");
}

#[test]
fn slivers_beside_undecided_regions_are_found() {
    // An undecided wedge that runs out in a band between two parts of the same verdict, a third of the first grid wide.
    let verdict_at = |[x, y]: Point| match y - 0.2 - 0.3 * x {
        height if height < 0.0 => Verdict::Stable,
        height if (height - 0.02).abs() < (0.012 * (0.9 - x)).max(0.006) => Verdict::Undecided,
        _ => Verdict::Unstable,
    };
    let (map, _) = map_of(verdict_at);
    let silent = assert_right(&map, verdict_at);
    assert!(silent < 0.02, "{silent}");
}

#[test]
fn noise_is_left_unresolved_and_inputs_outside_physics_are_known() {
    // Verdicts without order: none may be looked up, and the number of questions is bounded.
    let mut map = VerdictMap::new(0.25);
    let index = TileIndex { column: 3, row: 5 };
    let verdict_at = |point: &Point| {
        let bits = (point[0].to_bits() ^ point[1].to_bits().rotate_left(17)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        if bits >> 63 == 0 && (point[0] - 0.22).abs() < 1e-4 { Verdict::Unstable } else { Verdict::Stable }
    };
    let answer = |points: &[Point]| points.iter().map(|point| Some(verdict_at(point))).collect();
    map.insert(index, Tile::resolve(index, answer).unwrap());
    assert!(map.tile(index).unwrap().questions < 2 * MOST_QUESTIONS);
    for (preload, static_friction) in [(0.0, 0.5), (-1.0, 0.5), (0.2, 0.2), (-1.0, 0.1)] {
        assert_eq!(map.look_up(preload, static_friction), Some(Verdict::Stable));
    }
    assert_eq!(map.look_up(0.5, 0.5), None, "no such tile");
    assert_eq!(map.look_up(f64::NAN, 0.5), None);
}

#[test]
fn boxes_that_form_no_quadtree_are_refused() {
    let leaf = Node::Uniform(Verdict::Stable);
    for nodes in
        [vec![], vec![leaf, leaf], vec![Node::Cut(1), leaf, leaf, leaf], vec![Node::Cut(0), leaf, leaf, leaf, leaf]]
    {
        assert_eq!(Tile::from_nodes(nodes, 1), None);
    }
}

/// Stripes of verdicts across a boundary, each narrower than the last, without order along a line.
fn stripes([x, y]: Point) -> Verdict {
    let distance = x * y - 0.0135;
    match (libm::log2(distance.abs()) * 3.0) as i64 % 3 {
        _ if distance.abs() > 2e-3 => {
            if distance > 0.0 {
                Verdict::Unstable
            } else {
                Verdict::Stable
            }
        }
        0 => Verdict::Stable,
        -1 => Verdict::Undecided,
        _ => Verdict::Unstable,
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn a_tile_never_takes_more_than_its_limit_of_questions() {
    let noise = |point: Point| {
        let bits = (point[0].to_bits() ^ point[1].to_bits().rotate_left(17)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        [Verdict::Stable, Verdict::Unstable, Verdict::Undecided][(bits >> 33) as usize % 3]
    };
    let ragged = |[x, y]: Point| match x * y + 1e-4 * libm::sin(1e7 * (x - y)) {
        product if product > 0.0137 => Verdict::Unstable,
        product if product > 0.0133 => noise([x, y]),
        _ => Verdict::Stable,
    };
    let verdict_ats: [&dyn Fn(Point) -> Verdict; 3] = [&stripes, &noise, &ragged];
    for (number, verdict_at) in verdict_ats.into_iter().enumerate() {
        for (column, row) in [(0, 0), (0, 1), (1, 0), (0, 3), (7, 0)] {
            let mut asked = 0;
            let tile = Tile::resolve(TileIndex { column, row }, |points| {
                asked += points.len() as u64;
                assert!(asked <= MOST_QUESTIONS, "{number} {column} {row}: {asked}");
                points.iter().map(|&point| Some(verdict_at(point))).collect()
            });
            assert_eq!(tile.unwrap().questions, asked);
        }
    }
}

#[test]
fn a_search_ends_where_an_answer_is_refused() {
    let index = TileIndex { column: 0, row: 1 };
    let verdict_at = |point: &Point| if point[0] * point[1] > 0.012 { Verdict::Unstable } else { Verdict::Stable };
    let mut rounds = 0;
    let whole = Tile::resolve(index, |points| {
        rounds += 1;
        points.iter().map(|point| Some(verdict_at(point))).collect()
    });
    assert!(whole.is_some() && rounds > 5, "{rounds} rounds");
    for last in 0..rounds {
        let mut asked = 0;
        let tile = Tile::resolve(index, |points| {
            asked += 1;
            (asked <= last).then(|| points.iter().map(verdict_at).collect())
        });
        assert_eq!((tile, asked), (None, last + 1));
    }
}

/// How often a tile was divided for each box with a curve, least and most, and the most of all boxes.
fn depths(index: TileIndex, verdict_at: impl Fn(Point) -> Verdict) -> ([u32; 2], u32) {
    let tile = Tile::resolve(index, |points| points.iter().map(|&point| Some(verdict_at(point))).collect()).unwrap();
    let width = index.bounds().high[0] - index.bounds().low[0];
    let (mut crossed, mut most) = ([u32::MAX, 0], 0);
    for (bounds, node) in tile.boxes(index) {
        let depth = (width / (bounds.high[0] - bounds.low[0])).log2().round() as u32;
        most = most.max(depth);
        if let Node::Crossed(_) = node {
            crossed = [crossed[0].min(depth), crossed[1].max(depth)];
        }
    }
    (crossed, most)
}

#[test]
fn a_curve_beside_an_undecided_point_is_accepted_in_small_boxes_only() {
    let index = TileIndex { column: 1, row: 1 };
    let line = |[x, y]: Point| y - 0.1 - 0.5 * x;
    let between = |below: Verdict, above: Verdict| move |at: Point| if line(at) < 0.0 { below } else { above };
    assert_eq!(depths(index, between(Verdict::Stable, Verdict::Unstable)).0[0], 0);
    for third in [Verdict::Undecided, Verdict::Failed] {
        // Seen by the grid.
        assert!(depths(index, between(Verdict::Stable, third)).0[0] >= 3, "{third:?}");
        // So narrow that only the search along the boundary meets it.
        let sliver = |at: Point| match line(at) {
            height if height < 0.0 => Verdict::Stable,
            height if height < 1e-4 => third,
            _ => Verdict::Unstable,
        };
        assert!(depths(index, sliver).0[0] >= 3, "{third:?}");
    }
}

#[test]
fn ragged_undecided_verdicts_are_not_divided_to_the_last() {
    let index = TileIndex { column: 3, row: 3 };
    let [x0, y0] = index.bounds().low;
    // Noise in a sixteenth of the tile, along each coordinate.
    let noise = |third: Verdict| {
        move |[x, y]: Point| {
            let bits = (x.to_bits() ^ y.to_bits().rotate_left(17)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
            let is_inside = x < x0 + 1.0 / 256.0 && y < y0 + 1.0 / 256.0;
            if is_inside && bits >> 63 == 0 { third } else { Verdict::Stable }
        }
    };
    assert!(depths(index, noise(Verdict::Unstable)).1 > 7, "verdicts that are decided are divided on");
    assert!(depths(index, noise(Verdict::Undecided)).1 <= 7);
}
