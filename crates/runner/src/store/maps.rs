//! Verdict maps of a run: which tiles its samples need, and the pieces of finished tiles on disk.
//!
//! Pieces are Parquet files of boxes, in `map/`, named like those of samples by the hash of their bytes. They say what
//! decides their verdicts (model, rotating speed, criterion), so that other jobs can use them.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::Arc;

use arrow::array::{
    Array as _, ArrayRef, Float64Array, Float64Builder, Int64Array, ListArray, ListBuilder, RecordBatch,
};
use arrow::datatypes::{DataType, Schema};
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use stickslip_core::verdict::Verdict;
use stickslip_sampler::grid::Cell;
use stickslip_sampler::inputs::Marginal;
use stickslip_sampler::verdict_map::boundary_curve::{BoundaryCurve, NODES};
use stickslip_sampler::verdict_map::map::{Node, TILES, Tile, TileIndex, VerdictMap};

use crate::failure::Failure;
use crate::job::{Job, RandomInput};
use crate::output::note;
use crate::store::piece::digest;
use crate::store::publish::{files, is_temporary, publish};
use crate::tables::table::described_field;

/// Samples beyond this many standard deviations together are judged by themselves: one in 6.6e7.
const REACH: f64 = 6.0;

const KEY: &str = "stickslip:verdict_map";

/// A verdict map for each rotating speed of a job.
#[derive(Debug)]
pub struct Maps {
    keys: Vec<String>,
    /// Tiles that the job's samples need.
    needed: Vec<Vec<TileIndex>>,
    maps: Vec<VerdictMap>,
    /// What the needed tiles may cost together, beside the audit; more, and the samples themselves cost less.
    most: Option<u128>,
}

impl Maps {
    /// Of a job, without tiles yet.
    pub fn new(job: &Job) -> Self {
        let kinetic_coefficient = job.parameters.friction.kinetic_coefficient;
        let speeds = job.grid.rotating_speed.values();
        if !job.uses_maps() {
            return Self { keys: Vec::new(), needed: Vec::new(), maps: Vec::new(), most: None };
        }
        Self {
            keys: speeds.iter().map(|&speed| job.map_key(speed)).collect(),
            needed: (0..speeds.len()).map(|speed| needed_tiles(job, speed)).collect(),
            maps: vec![VerdictMap::new(kinetic_coefficient); speeds.len()],
            most: None,
        }
    }

    /// Limits what the needed tiles may cost together.
    pub fn limit(&mut self, most: u128) {
        self.most = Some(most);
    }

    /// Whether tiles of such a cost are more than the samples themselves.
    ///
    /// Only the sum over all needed tiles decides, which depends on the job alone: not on threads, shards, interruptions,
    /// or where tiles come from. As it only grows, a part of it that is too large already is enough.
    pub fn are_too_costly(&self, cost: u64) -> bool {
        self.most.is_some_and(|most| u128::from(cost) > most)
    }

    /// Gives the maps up: every sample is judged by itself.
    pub fn give_up(&mut self) {
        self.maps.clear();
    }

    /// The map at a rotating speed, if the job uses any.
    pub fn get(&self, speed: usize) -> Option<&VerdictMap> {
        self.maps.get(speed)
    }

    /// Adds a tile.
    pub fn insert(&mut self, speed: usize, index: TileIndex, tile: Tile) {
        self.maps[speed].insert(index, tile);
    }

    /// Needed tiles that are not there yet.
    pub fn missing(&self) -> Vec<(usize, TileIndex)> {
        let missing = |(speed, tiles): (usize, &Vec<TileIndex>)| -> Vec<(usize, TileIndex)> {
            tiles.iter().filter(|index| self.maps[speed].tile(**index).is_none()).map(|index| (speed, *index)).collect()
        };
        self.needed.iter().enumerate().flat_map(missing).collect()
    }

    /// How many tiles the job needs.
    pub fn needed(&self) -> usize {
        self.needed.iter().map(Vec::len).sum()
    }

    /// How many tiles are there.
    pub fn resolved(&self) -> usize {
        self.maps.iter().map(|map| map.tiles().count()).sum()
    }

    /// What all tiles together cost, whenever.
    pub fn cost(&self) -> u64 {
        self.maps.iter().flat_map(VerdictMap::tiles).map(|(_, tile)| tile.cost).sum()
    }

    /// Simulations that all tiles together took, whenever.
    pub fn questions(&self) -> u64 {
        self.maps.iter().flat_map(VerdictMap::tiles).map(|(_, tile)| tile.questions).sum()
    }

    /// Takes the needed tiles that lie in a directory of pieces; how many. Others are left there, so that a map does not
    /// depend on what it was borrowed from.
    pub fn load(&mut self, directory: &Path) -> Result<usize, Failure> {
        let mut loaded = 0;
        if self.maps.is_empty() || !directory.is_dir() {
            return Ok(0);
        }
        for path in files(directory)? {
            if is_temporary(&path) || path.extension().is_none_or(|extension| extension != "parquet") {
                continue;
            }
            let ignored = |why: &str| note(format_args!("warning: {} is ignored: {why}", path.display()));
            let bytes = fs::read(&path).map_err(|error| Failure::reading(&path, error))?;
            if path.file_stem().is_none_or(|stem| stem.to_string_lossy() != digest(&bytes)) {
                ignored("its content does not match the checksum in its name");
                continue;
            }
            match decode(bytes) {
                Ok((key, tiles)) => {
                    let Some(speed) = self.keys.iter().position(|own| *own == key) else { continue };
                    for (index, tile) in tiles {
                        if self.maps[speed].tile(index).is_none() && self.needed[speed].binary_search(&index).is_ok() {
                            self.maps[speed].insert(index, tile);
                            loaded += 1;
                        }
                    }
                }
                Err(why) => ignored(&why),
            }
        }
        Ok(loaded)
    }

    /// Writes tiles of one rotating speed as a new piece.
    pub fn write(&self, directory: &Path, tiles: &[(usize, TileIndex, Tile)]) -> Result<(), Failure> {
        fs::create_dir_all(directory).map_err(|error| Failure::creating(directory, error))?;
        let mut by_speed: BTreeMap<usize, Vec<&(usize, TileIndex, Tile)>> = BTreeMap::new();
        for tile in tiles {
            by_speed.entry(tile.0).or_default().push(tile);
        }
        for (speed, mut tiles) in by_speed {
            tiles.sort_by_key(|(_, index, _)| *index);
            let bytes = encode(&self.keys[speed], &tiles).map_err(|error| Failure::writing(directory, error))?;
            publish(directory, &format!("{}.parquet", digest(&bytes)), &bytes)?;
        }
        Ok(())
    }

    /// Writes every needed tile: what was borrowed from another run is kept in this one.
    pub fn write_all(&self, directory: &Path) -> Result<(), Failure> {
        let tiles: Vec<_> = self
            .maps
            .iter()
            .enumerate()
            .flat_map(|(speed, map)| map.tiles().map(move |(index, tile)| (speed, index, tile.clone())))
            .collect();
        self.write(directory, &tiles)
    }
}

/// The tiles that samples of any cell at one rotating speed may fall in, sorted.
fn needed_tiles(job: &Job, speed: usize) -> Vec<TileIndex> {
    let mut needed = vec![false; (TILES * TILES) as usize];
    let cells = job.cells() / job.grid.rotating_speed.values().len() as u64;
    for index in speed as u64 * cells..(speed as u64 + 1) * cells {
        let cell = job.grid.cell(index);
        let [preload, falling] = spread(job, &cell);
        let columns = preload.tiles(|tile| TileIndex { column: tile, row: 0 }.bounds(), 0);
        let rows = falling.tiles(|tile| TileIndex { column: 0, row: tile }.bounds(), 1);
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

/// How far samples reach along one coordinate.
struct Spread {
    low: f64,
    high: f64,
    /// Expected value and standard deviation, where distance can be counted in these.
    normal: Option<(f64, f64)>,
}

impl Spread {
    /// The tiles that it reaches, each with its distance from the expected value in standard deviations (0 where that has
    /// no meaning).
    fn tiles(
        &self,
        bounds: impl Fn(u32) -> stickslip_sampler::verdict_map::boundary_curve::Box2,
        axis: usize,
    ) -> Vec<(u32, f64)> {
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

/// How far the samples of a cell reach in preload and falling friction.
fn spread(job: &Job, cell: &Cell) -> [Spread; 2] {
    let random = &job.random;
    let stds = &random.relative_stds[job.grid.relative_std_index(cell.index)];
    let of = |wanted: fn(&RandomInput) -> bool, expected: f64, shift: f64| {
        let at = random.inputs.iter().position(wanted);
        let Some(at) = at else { return Spread { low: expected - shift, high: expected - shift, normal: None } };
        let end = |z: f64| random.marginals[at].value(expected, stds[at], z) - shift;
        let is_plain = random.is_plain() && random.marginals[at] == Marginal::Normal;
        let std = expected * stds[at];
        Spread {
            low: end(-REACH),
            high: end(REACH),
            normal: (is_plain && std > 0.0).then_some((expected - shift, std)),
        }
    };
    let kinetic_coefficient = job.parameters.friction.kinetic_coefficient;
    [
        of(|input| matches!(input, RandomInput::Preload), cell.preload, 0.0),
        of(|input| matches!(input, RandomInput::StaticFriction), cell.static_friction, kinetic_coefficient),
    ]
}

/// Integer columns of a piece: name and meaning.
const INTEGERS: [(&str, &str); 9] = [
    ("tile_column", "position of the tile along the preload"),
    ("tile_row", "position of the tile along the falling friction"),
    ("questions", "verdicts that the tile took"),
    ("kind", "0 cut into four, 1 uniform, 2 crossed by a curve over preload, 3 over falling friction, 4 unresolved"),
    ("first_child", "of a box that is cut, the place in its tile of the first of four"),
    ("verdict_below", "verdict below the curve, or of a uniform box: 0 stable, 1 unstable, 2 undecided, 3 failed"),
    ("verdict_above", "verdict above the curve"),
    ("cut", "how often the tile was cut for this box"),
    ("cost", "what the verdicts that the tile took cost, in units of scaled time"),
];

const GUARD: &str = "guard";
const CURVES: [&str; 2] = ["lower", "upper"];

fn code(verdict: Verdict) -> i64 {
    match verdict {
        Verdict::Stable => 0,
        Verdict::Unstable => 1,
        Verdict::Undecided => 2,
        Verdict::Failed => 3,
    }
}

fn verdict(code: i64) -> Result<Verdict, String> {
    match code {
        0 => Ok(Verdict::Stable),
        1 => Ok(Verdict::Unstable),
        2 => Ok(Verdict::Undecided),
        3 => Ok(Verdict::Failed),
        _ => Err(format!("{code} is no verdict")),
    }
}

fn encode(key: &str, tiles: &[&(usize, TileIndex, Tile)]) -> Result<Vec<u8>, parquet::errors::ParquetError> {
    let mut integers: [Vec<i64>; INTEGERS.len()] = Default::default();
    let mut guards = Vec::new();
    let mut curves = [(); 2].map(|()| ListBuilder::new(Float64Builder::new()));
    for (_, index, tile) in tiles {
        let mut depths = vec![0; tile.nodes().len()];
        for (place, node) in tile.nodes().iter().enumerate() {
            let (kind, child, below, above) = match node {
                Node::Cut(first) => {
                    (0..4).for_each(|child| depths[*first as usize + child] = depths[place] + 1);
                    (0, i64::from(*first), 0, 0)
                }
                Node::Uniform(verdict) => (1, 0, code(*verdict), code(*verdict)),
                Node::Crossed(curve) => (2 + curve.over as i64, 0, code(curve.below), code(curve.above)),
                Node::Unresolved => (4, 0, 0, 0),
            };
            let row = [
                i64::from(index.column),
                i64::from(index.row),
                tile.questions.cast_signed(),
                kind,
                child,
                below,
                above,
                depths[place],
                tile.cost.cast_signed(),
            ];
            integers.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
            let (guard, coefficients) = match node {
                Node::Crossed(curve) => (curve.guard, [&curve.lower[..], &curve.upper[..]]),
                _ => (0.0, [&[][..]; 2]),
            };
            guards.push(guard);
            for (list, coefficients) in curves.iter_mut().zip(coefficients) {
                list.values().append_slice(coefficients);
                list.append(true);
            }
        }
    }
    let mut fields = Vec::new();
    let mut columns: Vec<ArrayRef> = Vec::new();
    for ((name, long_name), values) in INTEGERS.iter().zip(integers) {
        fields.push(described_field(name, "1", long_name, DataType::Int64, false));
        columns.push(Arc::new(Int64Array::from(values)));
    }
    fields.push(described_field(GUARD, "1", "distance kept from the curves", DataType::Float64, false));
    columns.push(Arc::new(Float64Array::from(guards)));
    for (name, mut list) in CURVES.into_iter().zip(curves) {
        let list = list.finish();
        let meaning = "Chebyshev coefficients, on the box, of the end of what is certainly below, or above";
        fields.push(described_field(name, "1", meaning, list.data_type().clone(), false));
        columns.push(Arc::new(list));
    }
    let schema = Arc::new(Schema::new(fields));
    let owner = KeyValue::new(KEY.to_owned(), key.to_owned());
    let properties = WriterProperties::builder().set_key_value_metadata(Some(vec![owner])).build();
    let mut writer = ArrowWriter::try_new(Vec::new(), schema.clone(), Some(properties))?;
    writer.write(&RecordBatch::try_new(schema, columns)?)?;
    writer.into_inner()
}

fn decode(bytes: Vec<u8>) -> Result<(String, Vec<(TileIndex, Tile)>), String> {
    let text = |error: &dyn std::fmt::Display| error.to_string();
    let builder = ParquetRecordBatchReaderBuilder::try_new(bytes::Bytes::from(bytes)).map_err(|e| text(&e))?;
    let metadata = builder.metadata().file_metadata().key_value_metadata();
    let key = metadata.and_then(|pairs| pairs.iter().find(|pair| pair.key == KEY));
    let key = key.and_then(|pair| pair.value.clone()).ok_or("it is no verdict map")?;
    let mut tiles: BTreeMap<TileIndex, (Vec<Node>, [u64; 2])> = BTreeMap::new();
    for batch in builder.build().map_err(|e| text(&e))? {
        let batch = batch.map_err(|e| text(&e))?;
        let column = |name: &str| batch.column_by_name(name).ok_or_else(|| format!("column {name} is missing"));
        let mut integers = Vec::new();
        for (name, _) in INTEGERS {
            let values = column(name)?.as_any().downcast_ref::<Int64Array>();
            integers.push(values.ok_or_else(|| format!("column {name} is not of integers"))?);
        }
        let guards = column(GUARD)?.as_any().downcast_ref::<Float64Array>().ok_or("guards are not numbers")?;
        for row in 0..batch.num_rows() {
            let value = |column: usize| integers[column].value(row);
            let place = |column: usize| {
                u32::try_from(value(column)).ok().filter(|&place| place < TILES).ok_or("a tile is out of range")
            };
            let index = TileIndex { column: place(0)?, row: place(1)? };
            let coefficients = |name: &str| -> Result<[f64; NODES], String> {
                let lists = column(name)?.as_any().downcast_ref::<ListArray>().ok_or("curves are not lists")?;
                let list = lists.value(row);
                let list = list.as_any().downcast_ref::<Float64Array>().ok_or("curves are not numbers")?;
                list.values().to_vec().try_into().map_err(|_| "a curve has too few coefficients".to_owned())
            };
            let node = match value(3) {
                0 => Node::Cut(u32::try_from(value(4)).map_err(|_| "a box is out of range")?),
                1 => Node::Uniform(verdict(value(5))?),
                over @ (2 | 3) => Node::Crossed(BoundaryCurve {
                    over: (over - 2) as usize,
                    below: verdict(value(5))?,
                    above: verdict(value(6))?,
                    lower: coefficients(CURVES[0])?,
                    upper: coefficients(CURVES[1])?,
                    guard: guards.value(row),
                }),
                4 => Node::Unresolved,
                kind => return Err(format!("{kind} is no kind of box")),
            };
            let count = |column: usize| u64::try_from(value(column)).map_err(|_| "a count is negative");
            let counts = [count(2)?, count(8)?];
            let tile = tiles.entry(index).or_insert_with(|| (Vec::new(), counts));
            tile.0.push(node);
        }
    }
    let tile = |(index, (nodes, [questions, cost])): (TileIndex, (Vec<Node>, [u64; 2]))| {
        Tile::from_nodes(nodes, questions, cost)
            .map(|tile| (index, tile))
            .ok_or("the boxes of a tile do not fit together")
    };
    Ok((key, tiles.into_iter().map(tile).collect::<Result<_, _>>()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tile with boxes of every kind.
    fn tile(index: TileIndex) -> Tile {
        let judge = |point: &[f64; 2]| match point {
            [x, y] if (x - 0.2).abs() < 0.01 && (y - 0.2).abs() < 0.01 => Verdict::Failed,
            [x, y] if x * y > 0.03 => Verdict::Unstable,
            [x, y] if x + y > 0.5 => Verdict::Undecided,
            _ => Verdict::Stable,
        };
        Tile::resolve(index, |points| points.iter().map(judge).collect())
    }

    #[test]
    fn a_tile_reads_back_as_written() {
        let leaves = [Verdict::Stable, Verdict::Unstable, Verdict::Undecided].map(Node::Uniform);
        let nodes = vec![Node::Cut(1), leaves[0], leaves[1], leaves[2], Node::Unresolved];
        let handmade = Tile::from_nodes(nodes, 77, 5).unwrap();
        let mut tiles = vec![(0, TileIndex { column: 5, row: 7 }, handmade)];
        tiles.extend((0..3).map(|row| TileIndex { column: 1, row }).map(|index| (0, index, tile(index))));
        assert!(tiles.iter().any(|(_, _, tile)| tile.nodes().iter().any(|node| matches!(node, Node::Crossed(_)))));
        let bytes = encode("key", &tiles.iter().collect::<Vec<_>>()).unwrap();
        let (key, read) = decode(bytes).unwrap();
        assert_eq!(key, "key");
        let mut written: Vec<_> = tiles.into_iter().map(|(_, index, tile)| (index, tile)).collect();
        written.sort_by_key(|(index, _)| *index);
        assert!(read == written);
    }
}
