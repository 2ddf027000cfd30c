//! The verdict map: which verdict a sample has, as a function of its two random inputs, found by asking for verdicts.
//!
//! At one rotating speed the verdict is a deterministic function of preload and static friction, constant but for a few
//! curves. The plane of preload and falling friction `f_s - f_c` is cut into tiles (an eighth wide below 1, wider
//! beyond), and a tile into boxes until each is one of three: **uniform**, every point of a grid in it and around it has
//! one verdict; **crossed**, a [`BoundaryCurve`] separates two verdicts; or **unresolved**, too small to cut further, at
//! corners and ends of boundaries. A sample in a box is looked up unless it is within the resolution of a curve, or in an
//! unresolved box: then it has to be judged itself.
//!
//! Undecided regions have no simple edges: whether a motion shows what it will do just before its horizon depends on where
//! in its cycle the horizon falls, and lines of decided samples, too thin for any grid, run through them. A sample in such a
//! region is therefore judged itself, too; what the map says of it serves integration, where undecided regions count for
//! either side. Boxes that meet an undecided verdict are believed only from some depth on, and given up at another.
//!
//! A tile is a pure function of the verdicts, whoever asks for it: maps of different jobs can be joined.
//!
//! What a map cannot see: an island of another verdict that is smaller than the grid of its box (1/32 below 1) and
//! touches no point of it. At short horizons these occur: a sliver of undecided samples some thousandths wide may run along
//! a boundary through a tile none of whose points is undecided. That is why lookups are audited.

use std::collections::{BTreeMap, BTreeSet};

use crate::verdict_map::boundary_curve::{BoundaryCurve, Box2, Point, Search};
use stickslip_core::rigid_disc::pad_on_disc::RandomInputs;
use stickslip_core::verdict::Verdict;

/// Version of how tiles are resolved; maps of different versions are never joined.
///
/// 2: a tile ends within its limit of questions; finer near undecided verdicts, which are not looked up.
pub const MAP_VERSION: u32 = 2;

/// Tiles between 0 and 1; twice as wide in each octave beyond.
const TILES_TO_ONE: u32 = 8;

/// Tiles along each coordinate; they reach to 64.
pub const TILES: u32 = TILES_TO_ONE + 6 * TILES_TO_ONE / 2;

/// Boxes are halved this often at the most: to a 131 072nd of a tile.
const DEEPEST: u32 = 17;

/// A tile takes no more questions than this; what they do not resolve stays unresolved. Where verdicts have no order,
/// simulating the samples themselves is cheaper.
const MOST_QUESTIONS: u64 = 50_000;

/// A box that met a verdict that is not decided is cut at least this often before anything in it is believed (its grid is
/// then 1/256 wide below 1): the edges of undecided regions are ragged, and slivers of them run on beside boundaries.
const LEAST_DEPTH_IF_UNDECIDED: u32 = 3;

/// ... and no more often than this: regions with smooth edges are resolved by then, and cutting a ragged one further costs
/// more than the samples in a four-thousandth of the tile, next to others that are simulated anyway.
const MOST_DEPTH_IF_UNDECIDED: u32 = 6;

/// The guards of a boundary: a wider one only in boxes so small already that cutting them would cost more than the samples
/// inside the guard.
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

/// Intervals of the grid across a box, and the number of grid points with one interval more on each side.
const INTERVALS: i64 = 4;
const GRID: usize = INTERVALS as usize + 3;

/// The position of a tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TileIndex {
    /// Along the preload, 0 to [`TILES`] - 1.
    pub column: u32,
    /// Along the falling friction.
    pub row: u32,
}

/// Where tile `index` begins.
fn edge(index: u32) -> f64 {
    let Some(beyond) = index.checked_sub(TILES_TO_ONE) else { return f64::from(index) / f64::from(TILES_TO_ONE) };
    let half = TILES_TO_ONE / 2;
    f64::from(1 << (beyond / half)) * (1.0 + f64::from(beyond % half) / f64::from(half))
}

/// The tile that holds a coordinate, if it is not negative and not beyond the map.
fn tile_at(coordinate: f64) -> Option<u32> {
    if !(0.0..edge(TILES)).contains(&coordinate) {
        return None;
    }
    if coordinate < 1.0 {
        return Some((coordinate * f64::from(TILES_TO_ONE)) as u32);
    }
    let octave = coordinate.to_bits() >> 52 & 0x7ff;
    let octave = octave as u32 - 1023;
    let part = coordinate / f64::from(1 << octave) - 1.0;
    let half = TILES_TO_ONE / 2;
    Some(TILES_TO_ONE + half * octave + (part * f64::from(half)) as u32)
}

impl TileIndex {
    /// The tile with a point of the plane; `None` outside the map.
    #[must_use]
    pub fn of(preload: f64, falling_friction: f64) -> Option<Self> {
        Some(Self { column: tile_at(preload)?, row: tile_at(falling_friction)? })
    }

    /// Its box: preload and falling friction.
    #[must_use]
    pub fn bounds(self) -> Box2 {
        Box2 { low: [edge(self.column), edge(self.row)], high: [edge(self.column + 1), edge(self.row + 1)] }
    }
}

/// What is known of a box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Node {
    /// It is cut into four, which lie at this and the next three places of the list: lower and upper preload at lower,
    /// then at upper friction.
    Cut(u32),
    /// One verdict.
    Uniform(Verdict),
    /// Two verdicts, with a boundary between them.
    Crossed(BoundaryCurve),
    /// Not resolved.
    Unresolved,
}

/// A resolved tile: a tree of boxes, the tile itself first.
#[derive(Debug, Clone, PartialEq)]
pub struct Tile {
    nodes: Vec<Node>,
    /// Verdicts that were asked for.
    pub questions: u64,
    /// What they cost, as whoever gives the verdicts counts it.
    pub cost: u64,
}

impl Tile {
    /// A tile from its parts; `None` if they are no tree.
    #[must_use]
    pub fn from_nodes(nodes: Vec<Node>, questions: u64, cost: u64) -> Option<Self> {
        // Children come in fours, after their parent, each once.
        let mut next = 1;
        for (place, node) in nodes.iter().enumerate() {
            if let Node::Cut(first) = *node {
                if first as usize != next || next <= place {
                    return None;
                }
                next += 4;
            }
        }
        (next == nodes.len()).then_some(Self { nodes, questions, cost })
    }

    /// Its boxes, cut or not, as [`Tile::from_nodes`] takes them.
    #[must_use]
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// Every box that is not cut, with what is known of it.
    pub fn boxes(&self, index: TileIndex) -> impl Iterator<Item = (Box2, Node)> + '_ {
        let mut bounds = vec![index.bounds(); self.nodes.len()];
        for (place, node) in self.nodes.iter().enumerate() {
            if let Node::Cut(first) = *node {
                for child in 0..4 {
                    bounds[first as usize + child] = quarter(&bounds[place], child);
                }
            }
        }
        self.nodes
            .iter()
            .zip(bounds)
            .filter(|(node, _)| !matches!(node, Node::Cut(_)))
            .map(|(&node, bounds)| (bounds, node))
    }

    /// The verdict at a point of the tile, `None` where it has to be found out.
    #[inline]
    fn look_up(&self, index: TileIndex, point: Point) -> Option<Verdict> {
        if let Node::Uniform(verdict) = self.nodes[0] {
            return Some(verdict);
        }
        let mut bounds = index.bounds();
        let mut place = 0;
        loop {
            match &self.nodes[place] {
                Node::Cut(first) => {
                    let middle = middle(&bounds);
                    let child = usize::from(point[0] >= middle[0]) + 2 * usize::from(point[1] >= middle[1]);
                    bounds = quarter(&bounds, child);
                    place = *first as usize + child;
                }
                Node::Uniform(verdict) => return Some(*verdict),
                Node::Crossed(curve) => return curve.verdict(&bounds, point),
                Node::Unresolved => return None,
            }
        }
    }

    /// Resolves a tile by asking for verdicts, many at once: `judge` takes points (preload, falling friction). Its cost is 0.
    pub fn resolve(index: TileIndex, judge: impl FnMut(&[[f64; 2]]) -> Vec<Verdict>) -> Self {
        let tile = index.bounds();
        let mut questions = Questions { judge, asked: 0 };
        let mut known = BTreeMap::new();
        let mut nodes = vec![Node::Unresolved];
        let mut open = vec![OpenBox { place: 0, bounds: tile, corner: [0, 0], depth: 0, met_undecided: false }];
        while !open.is_empty() {
            questions.complete_grids(&tile, &open, &mut known);
            let mut searches = Vec::new();
            let mut to_cut = Vec::new();
            for open_box in open {
                // A grid that is not complete was not affordable: the box stays unresolved, and so do the others like it.
                let Some(grid) = open_box.grid().map(|point| known.get(&point).copied()).collect::<Option<Vec<_>>>()
                else {
                    continue;
                };
                let met_undecided = !grid.iter().all(|verdict| verdict.is_decided());
                let open_box = OpenBox { met_undecided, ..open_box };
                if grid.iter().all(|verdict| *verdict == grid[0]) {
                    nodes[open_box.place] = Node::Uniform(grid[0]);
                } else if let (true, Some(crossing)) = (open_box.is_small_enough(), Crossing::of(&grid)) {
                    searches.push((open_box, crossing.search(&open_box.bounds)));
                } else {
                    to_cut.push(open_box);
                }
            }
            for (open_box, curve) in locate(searches, &mut questions) {
                match curve {
                    Some(curve) if open_box.is_small_enough() => nodes[open_box.place] = Node::Crossed(curve),
                    _ => to_cut.push(open_box),
                }
            }
            to_cut.sort_unstable_by_key(|open_box| open_box.place);
            open = Vec::new();
            to_cut.retain(|open_box| open_box.may_be_cut() && questions.asked < MOST_QUESTIONS);
            for open_box in to_cut {
                nodes[open_box.place] = Node::Cut(nodes.len() as u32);
                open.extend((0..4).map(|child| open_box.child(nodes.len() + child, child)));
                nodes.extend([Node::Unresolved; 4]);
            }
        }
        Self { nodes, questions: questions.asked, cost: 0 }
    }
}

/// The questions of a tile: whom they are put to, and how many were.
struct Questions<J> {
    judge: J,
    asked: u64,
}

impl<J: FnMut(&[Point]) -> Vec<Verdict>> Questions<J> {
    /// Whether so many more may be asked.
    fn may_ask(&self, count: usize) -> bool {
        self.asked + count as u64 <= MOST_QUESTIONS
    }

    fn ask(&mut self, points: &[Point]) -> Vec<Verdict> {
        self.asked += points.len() as u64;
        if points.is_empty() { Vec::new() } else { (self.judge)(points) }
    }

    /// Asks for several lists of points at once: in their order, as far as they are affordable. `None` for the others.
    fn ask_lists(&mut self, lists: impl Iterator<Item = Vec<Point>>) -> Vec<Option<Vec<Verdict>>> {
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
        let mut verdicts = self.ask(&points).into_iter();
        lengths.into_iter().map(|length| length.map(|length| verdicts.by_ref().take(length).collect())).collect()
    }

    /// Asks for what is not known of the grids of boxes, one box after the other, as far as it is affordable.
    fn complete_grids(&mut self, tile: &Box2, boxes: &[OpenBox], known: &mut BTreeMap<Lattice, Verdict>) {
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
        let verdicts = self.ask(&points);
        known.extend(wanted.into_iter().zip(verdicts));
    }
}

/// A grid point of a tile, in units that are whole for the smallest boxes.
type Lattice = [i64; 2];

const LATTICE: i64 = INTERVALS << DEEPEST;

fn lattice_point(tile: &Box2, point: Lattice) -> Point {
    std::array::from_fn(|axis| {
        let width = tile.high[axis] - tile.low[axis];
        tile.low[axis] + width * (point[axis] as f64 / LATTICE as f64)
    })
}

fn middle(bounds: &Box2) -> Point {
    std::array::from_fn(|axis| 0.5 * (bounds.low[axis] + bounds.high[axis]))
}

fn quarter(bounds: &Box2, child: usize) -> Box2 {
    let middle = middle(bounds);
    let mut quarter = *bounds;
    for (axis, middle) in middle.into_iter().enumerate() {
        let end = if (child >> axis) & 1 == 0 { &mut quarter.high } else { &mut quarter.low };
        end[axis] = middle;
    }
    quarter
}

/// A box that is not known yet.
#[derive(Debug, Clone, Copy)]
struct OpenBox {
    place: usize,
    bounds: Box2,
    /// Its lower corner on the lattice.
    corner: Lattice,
    depth: u32,
    /// Whether its grid, or the search in it, met a verdict that is not decided.
    met_undecided: bool,
}

impl OpenBox {
    fn spacing(&self) -> i64 {
        (LATTICE / INTERVALS) >> self.depth
    }

    /// Its grid, one interval beyond it on each side, the preload varying fastest.
    fn grid(&self) -> impl Iterator<Item = Lattice> + use<> {
        let (corner, spacing) = (self.corner, self.spacing());
        (-1..=INTERVALS + 1)
            .flat_map(move |j| (-1..=INTERVALS + 1).map(move |i| [corner[0] + i * spacing, corner[1] + j * spacing]))
    }

    fn child(&self, place: usize, child: usize) -> Self {
        let half = self.spacing() * INTERVALS / 2;
        let corner = [self.corner[0] + half * (child & 1) as i64, self.corner[1] + half * (child >> 1) as i64];
        Self { place, bounds: quarter(&self.bounds, child), corner, depth: self.depth + 1, met_undecided: false }
    }

    /// Whether a boundary in it would be believed.
    fn is_small_enough(&self) -> bool {
        !self.met_undecided || self.depth >= LEAST_DEPTH_IF_UNDECIDED
    }

    fn may_be_cut(&self) -> bool {
        self.depth < if self.met_undecided { MOST_DEPTH_IF_UNDECIDED } else { DEEPEST }
    }
}

/// A grid that looks like two verdicts with one boundary between them, a graph over one coordinate.
struct Crossing {
    over: usize,
    below: Verdict,
    above: Verdict,
    /// For each line of the grid across that coordinate, the first point that is above; [`GRID`] if none is.
    first_above: [usize; GRID],
}

impl Crossing {
    /// As which of the two coordinates it is flatter; `None` if it is a graph over neither.
    fn of(grid: &[Verdict]) -> Option<Self> {
        let crossed = |crossing: &Self| crossing.first_above.iter().filter(|&&first| first % GRID > 0).count();
        let found = (0..2).filter_map(|over| Self::over(over, grid));
        found.reduce(|a, b| if crossed(&b) > crossed(&a) { b } else { a })
    }

    fn over(over: usize, grid: &[Verdict]) -> Option<Self> {
        let at = |i: usize, j: usize| if over == 0 { grid[i + GRID * j] } else { grid[j + GRID * i] };
        let crossed = (0..GRID).find(|&i| at(i, 0) != at(i, GRID - 1))?;
        let (below, above) = (at(crossed, 0), at(crossed, GRID - 1));
        let first_above = std::array::from_fn(|i| (0..GRID).find(|&j| at(i, j) != below).unwrap_or(GRID));
        // Below, then above, and nothing comes back.
        let is_graph = (0..GRID).all(|i| (first_above[i]..GRID).all(|j| at(i, j) == above));
        is_graph.then_some(Self { over, below, above, first_above })
    }

    /// The search for the boundary in this box: at first between the grid points that it passes.
    fn search(&self, bounds: &Box2) -> Search {
        let across = 1 - self.over;
        let spacing = (bounds.high[across] - bounds.low[across]) / INTERVALS as f64;
        let line_spacing = (bounds.high[self.over] - bounds.low[self.over]) / INTERVALS as f64;
        let expected = |coordinate: f64| {
            let line = ((coordinate - bounds.low[self.over]) / line_spacing) as usize + 1;
            let (a, b) = (self.first_above[line], self.first_above[(line + 1).min(GRID - 1)]);
            let value = |place: usize| bounds.low[across] + spacing * (place as f64 - 1.0);
            // A line without a point on one side says nothing of where the boundary is there.
            let below_at = if a.min(b) == 0 { -1.0 } else { a.min(b) as f64 - 1.0 };
            (bounds.low[across] + spacing * (below_at - 1.0), value(a.max(b)))
        };
        Search::new(*bounds, self.over, (self.below, self.above), expected)
    }
}

/// A box and the search for the boundary in it.
type BoxSearch = (OpenBox, Search);

/// Locates boundaries, all of them in step, so that many verdicts are asked for at once. No curve for what is no piece of a
/// boundary, contradicts itself, or took more questions than are left.
fn locate<J: FnMut(&[Point]) -> Vec<Verdict>>(
    searches: Vec<BoxSearch>,
    questions: &mut Questions<J>,
) -> Vec<(OpenBox, Option<BoundaryCurve>)> {
    let mut found = Vec::with_capacity(searches.len());
    let (mut going, mut to_widen) = accept_ends(searches, questions);
    to_widen.iter_mut().for_each(|(_, search)| search.widen());
    let (widened, failed) = accept_ends(to_widen, questions);
    going.extend(widened);
    found.extend(failed.into_iter().map(|(open_box, _)| (open_box, None)));
    loop {
        let answers = questions.ask_lists(going.iter().map(|(_, search)| search.questions()));
        if answers.iter().flatten().all(Vec::is_empty) && answers.iter().all(Option::is_some) {
            break;
        }
        let mut agreed = Vec::with_capacity(going.len());
        for ((mut open_box, mut search), verdicts) in going.into_iter().zip(answers) {
            if let Some(verdicts) = &verdicts {
                search.learn(verdicts);
                open_box.met_undecided |= !verdicts.iter().all(|verdict| verdict.is_decided());
            }
            if verdicts.is_some() && !search.is_contradicted() {
                agreed.push((open_box, search));
            } else {
                found.push((open_box, None));
            }
        }
        going = agreed;
    }
    for guard in GUARDS {
        let curves: Vec<_> = going.iter().map(|(_, search)| search.curve(guard.factor)).collect();
        let proofs = questions.ask_lists(curves.iter().map(|(_, proof)| proof.clone()));
        let mut failed = Vec::new();
        for (((mut open_box, search), (curve, _)), verdicts) in going.into_iter().zip(curves).zip(proofs) {
            open_box.met_undecided |= !verdicts.iter().flatten().all(|verdict| verdict.is_decided());
            if verdicts.is_some_and(|verdicts| search.accepts_proof(&verdicts)) {
                found.push((open_box, Some(curve)));
            } else {
                failed.push((open_box, search));
            }
        }
        let may_try_next = |open_box: &OpenBox| open_box.depth >= guard.next_from_depth;
        let (next, cut): (Vec<_>, Vec<_>) = failed.into_iter().partition(|(open_box, _)| may_try_next(open_box));
        found.extend(cut.into_iter().map(|(open_box, _)| (open_box, None)));
        going = next;
    }
    found.extend(going.into_iter().map(|(open_box, _)| (open_box, None)));
    found
}

/// Parts searches into those whose ends are as they should be, and the others.
fn accept_ends<J: FnMut(&[Point]) -> Vec<Verdict>>(
    searches: Vec<BoxSearch>,
    questions: &mut Questions<J>,
) -> (Vec<BoxSearch>, Vec<BoxSearch>) {
    let answers = questions.ask_lists(searches.iter().map(|(_, search)| search.ends()));
    let is_accepted =
        |search: &Search, verdicts: Option<Vec<Verdict>>| verdicts.is_some_and(|v| search.accepts_ends(&v));
    let judged = searches.into_iter().zip(answers).map(|(found, answer)| (is_accepted(&found.1, answer), found));
    let (accepted, others): (Vec<_>, Vec<_>) = judged.partition(|(is_accepted, _)| *is_accepted);
    let searches = |judged: Vec<(bool, BoxSearch)>| judged.into_iter().map(|(_, search)| search).collect();
    (searches(accepted), searches(others))
}

/// Tiles of the plane at one rotating speed.
#[derive(Debug, Clone)]
pub struct VerdictMap {
    kinetic_coefficient: f64,
    tiles: Vec<Option<Tile>>,
}

impl VerdictMap {
    /// A map without tiles, of a brake with this kinetic friction coefficient.
    #[must_use]
    pub fn new(kinetic_coefficient: f64) -> Self {
        Self { kinetic_coefficient, tiles: vec![None; (TILES * TILES) as usize] }
    }

    /// f_c, the kinetic friction coefficient.
    #[must_use]
    pub fn kinetic_coefficient(&self) -> f64 {
        self.kinetic_coefficient
    }

    /// The inputs at a point of the plane.
    #[must_use]
    pub fn inputs(&self, point: [f64; 2]) -> RandomInputs {
        RandomInputs { preload: point[0], static_friction: self.kinetic_coefficient + point[1] }
    }

    /// Adds a tile.
    pub fn insert(&mut self, index: TileIndex, tile: Tile) {
        self.tiles[(index.row * TILES + index.column) as usize] = Some(tile);
    }

    /// A tile, if it is resolved.
    #[must_use]
    pub fn tile(&self, index: TileIndex) -> Option<&Tile> {
        self.tiles.get((index.row * TILES + index.column) as usize)?.as_ref()
    }

    /// All resolved tiles.
    pub fn tiles(&self) -> impl Iterator<Item = (TileIndex, &Tile)> {
        let place = |place: usize| TileIndex { column: place as u32 % TILES, row: place as u32 / TILES };
        self.tiles.iter().enumerate().filter_map(move |(i, tile)| Some((place(i), tile.as_ref()?)))
    }

    /// The verdict on a sample, `None` where the map does not tell: outside its tiles, within the resolution of a boundary,
    /// or in an undecided region. Inputs outside physics (`Delta <= 0`, `f_s < f_c`) are stable by definition.
    #[inline]
    #[must_use]
    pub fn look_up(&self, inputs: RandomInputs) -> Option<Verdict> {
        let falling = inputs.static_friction - self.kinetic_coefficient;
        if inputs.preload <= 0.0 || falling < 0.0 {
            return Some(Verdict::Stable);
        }
        let index = TileIndex::of(inputs.preload, falling)?;
        self.tile(index)?.look_up(index, [inputs.preload, falling]).filter(|verdict| verdict.is_decided())
    }
}

#[cfg(test)]
mod tests;
