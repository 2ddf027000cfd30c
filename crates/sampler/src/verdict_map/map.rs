//! A map of verdicts: the resolved tiles at one rotating speed.

use stickslip_core::verdict::Verdict;

use crate::verdict_map::boundary_curve::Point;
use crate::verdict_map::tile::{TILES, Tile, TileIndex};

/// The resolved tiles of the plane at one rotating speed.
#[derive(Debug, Clone)]
pub struct VerdictMap {
    kinetic_coefficient: f64,
    tiles: Vec<Option<Tile>>,
}

impl VerdictMap {
    /// A map without tiles; `kinetic_coefficient` is f_c, where the falling friction is zero.
    #[must_use]
    pub fn new(kinetic_coefficient: f64) -> Self {
        Self { kinetic_coefficient, tiles: vec![None; (TILES * TILES) as usize] }
    }

    /// f_c, the kinetic friction coefficient.
    #[must_use]
    pub fn kinetic_coefficient(&self) -> f64 {
        self.kinetic_coefficient
    }

    /// The inputs at a point of the plane: preload and static friction coefficient.
    #[must_use]
    pub fn inputs(&self, [preload, falling_friction]: Point) -> [f64; 2] {
        [preload, self.kinetic_coefficient + falling_friction]
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
    /// resolution of a curve, or in an undecided region. Inputs outside physics (`Delta <= 0`, `f_s < f_c`) are stable
    /// by definition.
    #[inline]
    #[must_use]
    pub fn look_up(&self, preload: f64, static_friction: f64) -> Option<Verdict> {
        let falling = static_friction - self.kinetic_coefficient;
        if preload <= 0.0 || falling < 0.0 {
            return Some(Verdict::Stable);
        }
        let index = TileIndex::of(preload, falling)?;
        self.tile(index)?.look_up(index, [preload, falling]).filter(|verdict| verdict.is_decided())
    }
}
