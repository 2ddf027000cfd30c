//! A map of verdicts: the resolved tiles of one configuration.

use stickslip_core::model::verdict::Verdict;

use crate::verdict_map::boundary_curve::Point;
use crate::verdict_map::tile::{TILES, Tile, TileIndex};

/// The resolved tiles of the plane of one configuration.
#[derive(Debug, Clone)]
pub struct VerdictMap {
    origin: f64,
    tiles: Vec<Option<Tile>>,
}

impl VerdictMap {
    /// A map without tiles; `origin` is the second input where the second coordinate is zero.
    #[must_use]
    pub fn new(origin: f64) -> Self {
        Self { origin, tiles: vec![None; (TILES * TILES) as usize] }
    }

    /// The second input where the second coordinate is zero.
    #[must_use]
    pub fn origin(&self) -> f64 {
        self.origin
    }

    /// The two inputs at a point of the plane.
    #[must_use]
    pub fn inputs(&self, [first, above]: Point) -> [f64; 2] {
        [first, self.origin + above]
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

    /// The verdict on a sample. `None` where it is unknown: outside the tiles, in an unresolved box, within the
    /// resolution of a curve, or in an undecided region. Inputs outside the model (a first one that is not positive, a
    /// second one below the origin) are stable by definition.
    #[inline]
    #[must_use]
    pub fn look_up(&self, first: f64, second: f64) -> Option<Verdict> {
        let above = second - self.origin;
        if first <= 0.0 || above < 0.0 {
            return Some(Verdict::Stable);
        }
        let index = TileIndex::at(first, above)?;
        self.tile(index)?.look_up(index, [first, above]).filter(|verdict| verdict.is_decided())
    }
}
