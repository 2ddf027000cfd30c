//! Resolves a tile: asks for verdicts and divides boxes until each is uniform, crossed or too small.
//!
//! Each round completes the grids of all open boxes with one question to the caller, who may simulate many samples at
//! once. A box whose grid has one verdict is uniform. A box whose grid looks like two verdicts with one boundary
//! between them is searched for a curve along that boundary; if the search succeeds, the box is crossed. All other
//! boxes are divided into four.

use std::collections::{BTreeMap, BTreeSet};

use stickslip_core::model::verdict::Verdict;

use crate::verdict_map::boundary_curve::{BoundaryCurve, Box2, Point};
use crate::verdict_map::boundary_search::Search;
use crate::verdict_map::tile::{Node, Tile, TileIndex, quarter};

/// Divisions at most: boxes are no smaller than a 131 072nd of a tile.
const DEEPEST: u32 = 17;

/// Most questions of a tile; boxes beyond that stay unresolved. Where verdicts have no order, simulating the samples
/// themselves is cheaper.
pub(super) const MOST_QUESTIONS: u64 = 50_000;

/// A box with an undecided or failed verdict is divided at least this often before a curve in it is accepted (its grid
/// is then 1/256 wide below 1): the edges of undecided regions are ragged, and slivers of them run along boundaries.
const LEAST_DEPTH_IF_UNDECIDED: u32 = 3;

/// Such a box is divided no more often than this. Regions with smooth edges are resolved by then; to divide a ragged
/// one further costs more than to simulate the samples in a four-thousandth of the tile, beside others that are
/// simulated anyway.
const MOST_DEPTH_IF_UNDECIDED: u32 = 6;

/// A guard of a curve, and the depth from which the next wider one may be tried: only in boxes so small that dividing
/// them costs more than simulating the samples inside the guard.
struct Guard {
    factor: f64,
    next_from_depth: u32,
}

const GUARDS: [Guard; 4] = [
    Guard { factor: 1.0, next_from_depth: 2 },
    Guard { factor: 8.0, next_from_depth: 3 },
    Guard { factor: 64.0, next_from_depth: 5 },
    Guard { factor: 512.0, next_from_depth: u32::MAX },
];

/// Intervals of the grid across a box.
const INTERVALS: i64 = 4;

/// Points of the grid along each coordinate: it extends one interval beyond the box on either side.
const GRID: usize = INTERVALS as usize + 3;

impl Tile {
    /// Resolves a tile. `verdicts_at` returns the verdicts at points of the plane, many at once. If it
    /// returns `None`, the search ends there, with `None`.
    pub fn resolve(index: TileIndex, verdicts_at: impl FnMut(&[Point]) -> Option<Vec<Verdict>>) -> Option<Self> {
        let tile = index.bounds();
        let mut questions = Questions { verdicts_at, asked: 0 };
        let mut known = BTreeMap::new();
        let mut nodes = vec![Node::Unresolved];
        let mut open = vec![OpenBox { place: 0, bounds: tile, corner: [0, 0], depth: 0, has_undecided: false }];
        while !open.is_empty() {
            questions.complete_grids(&tile, &open, &mut known)?;
            let mut searches = Vec::new();
            let mut to_divide = Vec::new();
            for open_box in open {
                // The limit of questions left the grid incomplete: the box stays unresolved.
                let Some(grid) = open_box.grid().map(|point| known.get(&point).copied()).collect::<Option<Vec<_>>>()
                else {
                    continue;
                };
                let has_undecided = !grid.iter().all(|verdict| verdict.is_decided());
                let open_box = OpenBox { has_undecided, ..open_box };
                if grid.iter().all(|verdict| *verdict == grid[0]) {
                    nodes[open_box.place] = Node::Uniform(grid[0]);
                } else if let (true, Some(crossing)) = (open_box.is_small_enough(), Crossing::find(&grid)) {
                    searches.push((open_box, crossing.search(&open_box.bounds)));
                } else {
                    to_divide.push(open_box);
                }
            }
            for (open_box, curve) in locate(searches, &mut questions)? {
                match curve {
                    Some(curve) if open_box.is_small_enough() => nodes[open_box.place] = Node::Crossed(curve),
                    _ => to_divide.push(open_box),
                }
            }
            to_divide.sort_unstable_by_key(|open_box| open_box.place);
            open = Vec::new();
            to_divide.retain(|open_box| open_box.may_be_divided() && questions.asked < MOST_QUESTIONS);
            for open_box in to_divide {
                nodes[open_box.place] = Node::Cut(nodes.len() as u32);
                open.extend((0..4).map(|child| open_box.child(nodes.len() + child, child)));
                nodes.extend([Node::Unresolved; 4]);
            }
        }
        Some(Self { nodes, questions: questions.asked })
    }
}

/// The verdicts at a list of points; `None` beyond the limit of questions.
type Answer = Option<Vec<Verdict>>;

/// The questions of a tile: who answers them, and how many were asked.
struct Questions<J> {
    verdicts_at: J,
    asked: u64,
}

impl<J: FnMut(&[Point]) -> Option<Vec<Verdict>>> Questions<J> {
    /// Whether `count` more may be asked.
    fn may_ask(&self, count: usize) -> bool {
        self.asked + count as u64 <= MOST_QUESTIONS
    }

    /// The verdicts at points; `None` if the search is to end.
    fn ask(&mut self, points: &[Point]) -> Option<Vec<Verdict>> {
        self.asked += points.len() as u64;
        if points.is_empty() { Some(Vec::new()) } else { (self.verdicts_at)(points) }
    }

    /// Asks for several lists of points at once, in their order. Lists beyond the limit of questions have no answer.
    /// `None` if the search is to end.
    fn ask_lists(&mut self, lists: impl Iterator<Item = Vec<Point>>) -> Option<Vec<Answer>> {
        let mut points = Vec::new();
        let lengths: Vec<Option<usize>> = lists
            .map(|list| {
                let is_affordable = self.may_ask(points.len() + list.len());
                is_affordable.then(|| {
                    points.extend_from_slice(&list);
                    list.len()
                })
            })
            .collect();
        let mut verdicts = self.ask(&points)?.into_iter();
        let answer = |length: Option<usize>| length.map(|length| verdicts.by_ref().take(length).collect());
        Some(lengths.into_iter().map(answer).collect())
    }

    /// Asks for the unknown points of the grids of boxes, one box after the other, up to the limit of questions. `None`
    /// if the search is to end.
    fn complete_grids(&mut self, tile: &Box2, boxes: &[OpenBox], known: &mut BTreeMap<Lattice, Verdict>) -> Option<()> {
        let mut wanted = BTreeSet::new();
        for open_box in boxes {
            let new: Vec<Lattice> =
                open_box.grid().filter(|point| !known.contains_key(point) && !wanted.contains(point)).collect();
            if !self.may_ask(wanted.len() + new.len()) {
                break;
            }
            wanted.extend(new);
        }
        let points: Vec<Point> = wanted.iter().map(|point| lattice_point(tile, *point)).collect();
        let verdicts = self.ask(&points)?;
        known.extend(wanted.into_iter().zip(verdicts));
        Some(())
    }
}

/// A grid point of a tile, in integer coordinates that resolve the grids of the smallest boxes.
type Lattice = [i64; 2];

/// Lattice intervals across a tile.
const LATTICE: i64 = INTERVALS << DEEPEST;

fn lattice_point(tile: &Box2, point: Lattice) -> Point {
    std::array::from_fn(|axis| {
        let width = tile.high[axis] - tile.low[axis];
        tile.low[axis] + width * (point[axis] as f64 / LATTICE as f64)
    })
}

/// A box that is not resolved yet.
#[derive(Debug, Clone, Copy)]
struct OpenBox {
    /// Its place in the list of the tile.
    place: usize,
    bounds: Box2,
    /// Its lower corner on the lattice.
    corner: Lattice,
    /// How often the tile was divided for it.
    depth: u32,
    /// Whether its grid, or the search in it, found an undecided or failed verdict.
    has_undecided: bool,
}

impl OpenBox {
    /// The interval of its grid on the lattice.
    fn spacing(&self) -> i64 {
        (LATTICE / INTERVALS) >> self.depth
    }

    /// Its grid, the first coordinate varying fastest.
    fn grid(&self) -> impl Iterator<Item = Lattice> + use<> {
        let (corner, spacing) = (self.corner, self.spacing());
        (-1..=INTERVALS + 1)
            .flat_map(move |j| (-1..=INTERVALS + 1).map(move |i| [corner[0] + i * spacing, corner[1] + j * spacing]))
    }

    fn child(&self, place: usize, child: usize) -> Self {
        let half = self.spacing() * INTERVALS / 2;
        let corner = [self.corner[0] + half * (child & 1) as i64, self.corner[1] + half * (child >> 1) as i64];
        Self { place, bounds: quarter(&self.bounds, child), corner, depth: self.depth + 1, has_undecided: false }
    }

    /// Whether a curve in it is accepted.
    fn is_small_enough(&self) -> bool {
        !self.has_undecided || self.depth >= LEAST_DEPTH_IF_UNDECIDED
    }

    fn may_be_divided(&self) -> bool {
        self.depth < if self.has_undecided { MOST_DEPTH_IF_UNDECIDED } else { DEEPEST }
    }
}

/// A grid that looks like two verdicts with one boundary between them, a graph over the abscissa.
struct Crossing {
    abscissa: usize,
    below: Verdict,
    above: Verdict,
    /// For each line of the grid at one abscissa, the first point that is above; [`GRID`] if none is.
    first_above: [usize; GRID],
}

impl Crossing {
    /// The crossing over the coordinate along which more lines cross the boundary; `None` if it is a graph over
    /// neither.
    fn find(grid: &[Verdict]) -> Option<Self> {
        let crossed = |crossing: &Self| crossing.first_above.iter().filter(|&&first| first % GRID > 0).count();
        let found = (0..2).filter_map(|abscissa| Self::over(abscissa, grid));
        found.reduce(|a, b| if crossed(&b) > crossed(&a) { b } else { a })
    }

    /// The crossing over one coordinate, if the boundary is a graph over it.
    fn over(abscissa: usize, grid: &[Verdict]) -> Option<Self> {
        let at = |i: usize, j: usize| if abscissa == 0 { grid[i + GRID * j] } else { grid[j + GRID * i] };
        let crossed = (0..GRID).find(|&i| at(i, 0) != at(i, GRID - 1))?;
        let (below, above) = (at(crossed, 0), at(crossed, GRID - 1));
        let first_above = std::array::from_fn(|i| (0..GRID).find(|&j| at(i, j) != below).unwrap_or(GRID));
        // On each line, first below and then above.
        let is_graph = (0..GRID).all(|i| (first_above[i]..GRID).all(|j| at(i, j) == above));
        is_graph.then_some(Self { abscissa, below, above, first_above })
    }

    /// The search for the boundary in this box, at first between the grid points on either side of it.
    fn search(&self, bounds: &Box2) -> Search {
        let ordinate = 1 - self.abscissa;
        let spacing = (bounds.high[ordinate] - bounds.low[ordinate]) / INTERVALS as f64;
        let line_spacing = (bounds.high[self.abscissa] - bounds.low[self.abscissa]) / INTERVALS as f64;
        let expected = |coordinate: f64| {
            let line = ((coordinate - bounds.low[self.abscissa]) / line_spacing) as usize + 1;
            let (a, b) = (self.first_above[line], self.first_above[(line + 1).min(GRID - 1)]);
            let value = |place: usize| bounds.low[ordinate] + spacing * (place as f64 - 1.0);
            // A line whose points are all on one side does not show where the boundary is.
            let below_at = if a.min(b) == 0 { -1.0 } else { a.min(b) as f64 - 1.0 };
            (bounds.low[ordinate] + spacing * (below_at - 1.0), value(a.max(b)))
        };
        Search::new(*bounds, self.abscissa, (self.below, self.above), expected)
    }
}

/// A box and the search for the boundary in it.
type BoxSearch = (OpenBox, Search);

/// Runs searches side by side, so that many verdicts are asked for at once. `None` for a box without a boundary that a
/// curve describes, and for one whose search would exceed the limit of questions. `None` as a whole if the search is to
/// end.
fn locate<J: FnMut(&[Point]) -> Option<Vec<Verdict>>>(
    searches: Vec<BoxSearch>,
    questions: &mut Questions<J>,
) -> Option<Vec<(OpenBox, Option<BoundaryCurve>)>> {
    let mut found = Vec::with_capacity(searches.len());
    let (mut active, mut to_widen) = accept_ends(searches, questions)?;
    to_widen.iter_mut().for_each(|(_, search)| search.widen());
    let (widened, failed) = accept_ends(to_widen, questions)?;
    active.extend(widened);
    found.extend(failed.into_iter().map(|(open_box, _)| (open_box, None)));
    loop {
        let answers = questions.ask_lists(active.iter().map(|(_, search)| search.questions()))?;
        if answers.iter().flatten().all(Vec::is_empty) && answers.iter().all(Option::is_some) {
            break;
        }
        let mut agreed = Vec::with_capacity(active.len());
        for ((mut open_box, mut search), verdicts) in active.into_iter().zip(answers) {
            if let Some(verdicts) = &verdicts {
                search.record(verdicts);
                open_box.has_undecided |= !verdicts.iter().all(|verdict| verdict.is_decided());
            }
            if verdicts.is_some() && !search.is_contradicted() {
                agreed.push((open_box, search));
            } else {
                found.push((open_box, None));
            }
        }
        active = agreed;
    }
    for guard in GUARDS {
        let curves: Vec<_> = active.iter().map(|(_, search)| search.curve(guard.factor)).collect();
        let answers = questions.ask_lists(curves.iter().map(|(_, checks)| checks.clone()))?;
        let mut failed = Vec::new();
        for (((mut open_box, search), (curve, _)), verdicts) in active.into_iter().zip(curves).zip(answers) {
            open_box.has_undecided |= !verdicts.iter().flatten().all(|verdict| verdict.is_decided());
            if verdicts.is_some_and(|verdicts| search.accepts(&verdicts)) {
                found.push((open_box, Some(curve)));
            } else {
                failed.push((open_box, search));
            }
        }
        let may_try_next = |open_box: &OpenBox| open_box.depth >= guard.next_from_depth;
        let (next, to_divide): (Vec<_>, Vec<_>) = failed.into_iter().partition(|(open_box, _)| may_try_next(open_box));
        found.extend(to_divide.into_iter().map(|(open_box, _)| (open_box, None)));
        active = next;
    }
    found.extend(active.into_iter().map(|(open_box, _)| (open_box, None)));
    Some(found)
}

/// Separates the searches between whose ends a boundary lies from the others. `None` if the search is to end.
fn accept_ends<J: FnMut(&[Point]) -> Option<Vec<Verdict>>>(
    searches: Vec<BoxSearch>,
    questions: &mut Questions<J>,
) -> Option<(Vec<BoxSearch>, Vec<BoxSearch>)> {
    let answers = questions.ask_lists(searches.iter().map(|(_, search)| search.ends()))?;
    let is_accepted = |search: &Search, verdicts: Answer| verdicts.is_some_and(|v| search.accepts(&v));
    let answered = searches.into_iter().zip(answers).map(|(found, answer)| (is_accepted(&found.1, answer), found));
    let (accepted, others): (Vec<_>, Vec<_>) = answered.partition(|(is_accepted, _)| *is_accepted);
    let searches = |answered: Vec<(bool, BoxSearch)>| answered.into_iter().map(|(_, search)| search).collect();
    Some((searches(accepted), searches(others)))
}
