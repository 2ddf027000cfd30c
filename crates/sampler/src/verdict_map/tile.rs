//! Tiles of the plane and the quadtrees of boxes that they hold.

use stickslip_core::model::verdict::Verdict;

use crate::verdict_map::boundary_curve::{BoundaryCurve, Box2, Point};

/// Tiles between 0 and 1, of equal width. In each octave beyond they are twice as wide as in the one before.
const TILES_TO_ONE: u32 = 8;

/// Tiles along each coordinate; together they cover 0 to 64.
pub const TILES: u32 = TILES_TO_ONE + 6 * TILES_TO_ONE / 2;

/// The position of a tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TileIndex {
    /// Along the first coordinate, 0 to [`TILES`] - 1.
    pub column: u32,
    /// Along the second coordinate.
    pub row: u32,
}

/// Where tile `index` begins.
pub(super) fn edge(index: u32) -> f64 {
    let Some(beyond) = index.checked_sub(TILES_TO_ONE) else { return f64::from(index) / f64::from(TILES_TO_ONE) };
    let half = TILES_TO_ONE / 2;
    f64::from(1 << (beyond / half)) * (1.0 + f64::from(beyond % half) / f64::from(half))
}

/// The tile that holds a coordinate; `None` if that is negative, NaN or beyond the map.
pub(super) fn tile_at(coordinate: f64) -> Option<u32> {
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
    /// The tile that holds a point of the plane; `None` outside the map.
    #[must_use]
    pub(crate) fn at(first: f64, second: f64) -> Option<Self> {
        Some(Self { column: tile_at(first)?, row: tile_at(second)? })
    }

    /// The box of the tile.
    #[must_use]
    pub fn bounds(self) -> Box2 {
        Box2 { low: [edge(self.column), edge(self.row)], high: [edge(self.column + 1), edge(self.row + 1)] }
    }
}

/// What is known of a box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Node {
    /// It is divided into four, which lie at this and the next three places of the list: lower and upper half of the
    /// first coordinate in the lower half of the second, then in the upper one.
    Cut(u32),
    /// All points of its grid have this verdict, which is assumed for every sample in it.
    Uniform(Verdict),
    /// A boundary between two verdicts crosses it.
    Crossed(BoundaryCurve),
    /// Its verdicts are not known.
    Unresolved,
}

/// A resolved tile: a quadtree of boxes, the tile itself first.
#[derive(Debug, Clone, PartialEq)]
pub struct Tile {
    pub(super) nodes: Vec<Node>,
    /// Verdicts that were asked for.
    pub questions: u64,
}

impl Tile {
    /// A tile from its boxes, as [`Tile::nodes`] returns them; `None` if they do not form a quadtree.
    #[must_use]
    pub fn from_nodes(nodes: Vec<Node>, questions: u64) -> Option<Self> {
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
        (next == nodes.len()).then_some(Self { nodes, questions })
    }

    /// All boxes, divided or not: children come after their parent, in groups of four.
    #[must_use]
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// Every box that is not divided, with what is known of it.
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

    /// The verdict at a point of the tile; `None` where it is unknown.
    #[inline]
    pub(super) fn look_up(&self, index: TileIndex, point: Point) -> Option<Verdict> {
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
}

fn middle(bounds: &Box2) -> Point {
    std::array::from_fn(|axis| 0.5 * (bounds.low[axis] + bounds.high[axis]))
}

/// One of the four quarters of a box, counted as in [`Node::Cut`].
pub(super) fn quarter(bounds: &Box2, child: usize) -> Box2 {
    let middle = middle(bounds);
    let mut quarter = *bounds;
    for (axis, middle) in middle.into_iter().enumerate() {
        let end = if (child >> axis) & 1 == 0 { &mut quarter.high } else { &mut quarter.low };
        end[axis] = middle;
    }
    quarter
}
