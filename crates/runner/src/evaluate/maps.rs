//! The verdict maps of a job, and the tiles that its samples need.

use stickslip_sampler::grid::Cell;
use stickslip_sampler::inputs::Marginal;
use stickslip_sampler::integrate::NormalPair;
use stickslip_sampler::verdict_map::boundary_curve::Box2;
use stickslip_sampler::verdict_map::map::VerdictMap;
use stickslip_sampler::verdict_map::tile::{TILES, Tile, TileIndex};

use crate::job::Job;

/// Radius of the mapped region in standard deviations of both inputs together. One sample in 6.6e7 is outside and is
/// simulated.
const REACH: f64 = 6.0;

/// A verdict map for each configuration of a job.
#[derive(Debug)]
pub struct Maps {
    keys: Vec<String>,
    /// The tiles that the job's samples need, for each configuration.
    needed: Vec<Vec<TileIndex>>,
    maps: Vec<VerdictMap>,
}

impl Maps {
    /// The maps of a job, without tiles yet.
    pub fn new(job: &Job) -> Self {
        if !job.uses_maps() {
            return Self { keys: Vec::new(), needed: Vec::new(), maps: Vec::new() };
        }
        let configurations = || 0..job.grid.configurations();
        Self {
            keys: configurations().map(|index| job.map_key(index)).collect(),
            needed: configurations().map(|index| needed_tiles(job, index)).collect(),
            maps: configurations().map(|index| VerdictMap::new(origin(job, index))).collect(),
        }
    }

    /// The map of a brake of the grid; `None` if there are no maps.
    pub fn get(&self, brake: usize) -> Option<&VerdictMap> {
        self.maps.get(brake)
    }

    /// Adds a tile.
    pub fn insert(&mut self, brake: usize, index: TileIndex, tile: Tile) {
        self.maps[brake].insert(index, tile);
    }

    /// The needed tiles that are not there yet.
    pub fn missing(&self) -> Vec<(usize, TileIndex)> {
        self.missing_of(|_| true)
    }

    /// The same of a share of the needed tiles: `is_wanted` decides by the number of a tile among all of them.
    pub fn missing_of(&self, is_wanted: impl Fn(u64) -> bool) -> Vec<(usize, TileIndex)> {
        let needed = self.needed.iter().enumerate();
        let needed = needed.flat_map(|(brake, tiles)| tiles.iter().map(move |&index| (brake, index)));
        let wanted = (0..).zip(needed).filter(|(number, _)| is_wanted(*number)).map(|(_, tile)| tile);
        wanted.filter(|&(brake, index)| self.maps[brake].tile(index).is_none()).collect()
    }

    /// The number of tiles that the job needs.
    pub fn needed(&self) -> usize {
        self.needed.iter().map(Vec::len).sum()
    }

    /// The number of tiles that are there.
    pub fn resolved(&self) -> usize {
        self.maps.iter().map(|map| map.tiles().count()).sum()
    }

    /// The number of simulations behind all tiles that are there, including those of earlier sessions and other runs.
    pub fn simulations(&self) -> u64 {
        self.maps.iter().flat_map(VerdictMap::tiles).map(|(_, tile)| tile.questions).sum()
    }

    /// The brake whose verdicts have this key.
    pub fn configuration_of(&self, key: &str) -> Option<usize> {
        self.keys.iter().position(|own| own == key)
    }

    /// Everything that the verdicts on a brake depend on, see [`Job::map_key`].
    pub fn key(&self, brake: usize) -> &str {
        &self.keys[brake]
    }

    /// Whether a tile is needed and not there yet.
    pub fn needs(&self, brake: usize, index: TileIndex) -> bool {
        self.maps[brake].tile(index).is_none() && self.needed[brake].binary_search(&index).is_ok()
    }

    /// Whether the job uses no maps.
    pub fn is_empty(&self) -> bool {
        self.maps.is_empty()
    }

    /// All tiles that are there, each with its brake.
    pub fn tiles(&self) -> Vec<(usize, TileIndex, Tile)> {
        let tiles = self.maps.iter().enumerate();
        tiles.flat_map(|(brake, map)| map.tiles().map(move |(index, tile)| (brake, index, tile.clone()))).collect()
    }
}

/// The second quantity at which the map of a configuration begins.
fn origin(job: &Job, index: usize) -> f64 {
    let configuration = job.configuration_in(&job.grid.first_cell_with(index)).ok();
    configuration.and_then(|configuration| configuration.map_origin()).unwrap_or(f64::NAN)
}

/// The tiles that samples of any cell with a brake may fall in, sorted. Jobs with maps have no axes of the start, so
/// that these cells follow each other.
fn needed_tiles(job: &Job, brake: usize) -> Vec<TileIndex> {
    let mut needed = vec![false; (TILES * TILES) as usize];
    let origin = origin(job, brake);
    let cells = job.cells() / job.grid.configurations() as u64;
    let first = job.grid.first_cell_with(brake).index;
    for index in first..first + cells {
        let cell = job.grid.cell(index);
        let [first_spread, second_spread] = spread(job, &cell, origin);
        let columns = first_spread.tiles(|tile| TileIndex { column: tile, row: 0 }.bounds(), 0);
        let rows = second_spread.tiles(|tile| TileIndex { column: 0, row: tile }.bounds(), 1);
        for &(row, row_distance) in &rows {
            for &(column, column_distance) in &columns {
                if row_distance * row_distance + column_distance * column_distance <= REACH * REACH {
                    needed[(row * TILES + column) as usize] = true;
                }
            }
        }
    }
    let mut tiles: Vec<TileIndex> = (0..TILES * TILES)
        .filter(|&place| needed[place as usize])
        .map(|place| TileIndex { column: place % TILES, row: place / TILES })
        .collect();
    tiles.sort_unstable();
    tiles
}

/// The range of samples along one coordinate.
struct Spread {
    low: f64,
    high: f64,
    /// Expected value and standard deviation, if the coordinate is independent and normally distributed.
    normal: Option<(f64, f64)>,
}

impl Spread {
    /// The tiles in the range, each with its distance from the expected value in standard deviations (0 if the
    /// coordinate is not normally distributed).
    fn tiles(&self, bounds: impl Fn(u32) -> Box2, axis: usize) -> Vec<(u32, f64)> {
        let reached = |tile: &u32| {
            let bounds = bounds(*tile);
            bounds.high[axis] > self.low && bounds.low[axis] <= self.high
        };
        let distance = |tile: u32| {
            let (low, high) = (bounds(tile).low[axis], bounds(tile).high[axis]);
            let distance = |(expected, std): (f64, f64)| (low - expected).max(expected - high).max(0.0) / std;
            self.normal.map_or(0.0, distance)
        };
        (0..TILES).filter(reached).map(|tile| (tile, distance(tile))).collect()
    }
}

/// The ranges of the samples of a cell in the two coordinates of a map.
fn spread(job: &Job, cell: &Cell, origin: f64) -> [Spread; 2] {
    let random = &job.random;
    let NormalPair { expected, relative_std } = job.normal_pair(cell);
    let of = |which: usize, shift: f64| {
        let expected = expected[which];
        let Some(at) = random.pair()[which] else {
            return Spread { low: expected - shift, high: expected - shift, normal: None };
        };
        let end = |z: f64| random.marginals[at].value(expected, relative_std[which], z) - shift;
        let is_plain = random.is_plain() && random.marginals[at] == Marginal::Normal;
        let std = expected * relative_std[which];
        Spread {
            low: end(-REACH),
            high: end(REACH),
            normal: (is_plain && std > 0.0).then_some((expected - shift, std)),
        }
    };
    [of(0, 0.0), of(1, origin)]
}
