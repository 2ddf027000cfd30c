//! Pieces of verdict maps: files of finished tiles.
//!
//! They are Parquet files of boxes in `map/`, named by the hash of their content like those of samples. They name
//! everything that their verdicts depend on (model, rotating speed, criterion), so that other jobs can use them.

use std::collections::BTreeMap;

use bytes::Bytes;
use parquet::basic::Compression;
use stickslip_core::verdict::Verdict;
use stickslip_sampler::verdict_map::boundary_curve::{BoundaryCurve, NODES};
use stickslip_sampler::verdict_map::tile::{Node, TILES, Tile, TileIndex};

use crate::evaluate::maps::Maps;
use crate::failure::Failure;
use crate::files::column::{Field, Lists, Values};
use crate::files::decode::{ReadTable, ReadValues};
use crate::files::encode::encoded;
use crate::files::folder::Folder;
use crate::files::foreign::{self, Known};
use crate::output::note;
use crate::store::piece::{Defect, digest, is_piece_name, read_checked};

const KEY: &str = "stickslip:verdict_map";

/// Adds the tiles in a directory of pieces that `maps` need, and returns their number. Tiles that are not needed are
/// left out, so that a map does not depend on where its tiles come from.
pub fn load(maps: &mut Maps, folder: &Folder) -> Result<usize, Failure> {
    let mut loaded = 0;
    if maps.is_empty() {
        return Ok(0);
    }
    let names = folder.names().map_err(|error| Failure::reading(folder.path(), error))?;
    for name in names.iter().filter(|name| is_piece_name(name)) {
        let ignored =
            |why: &str| note(format_args!("warning: {} is ignored: {why}", folder.path().join(name).display()));
        let bytes = match read_checked(folder, name) {
            Ok(bytes) => bytes,
            Err(Defect::Unread(why) | Defect::Damaged(why)) => {
                ignored(&why);
                continue;
            }
        };
        match decode(bytes) {
            Ok((key, tiles)) => {
                let Some(speed) = maps.brake_of(&key) else { continue };
                for (index, tile) in tiles {
                    if maps.needs(speed, index) {
                        maps.insert(speed, index, tile);
                        loaded += 1;
                    }
                }
            }
            Err(why) => ignored(&why),
        }
    }
    Ok(loaded)
}

/// Writes tiles as new pieces, one for each rotating speed.
pub fn write(maps: &Maps, folder: &Folder, tiles: &[(usize, TileIndex, Tile)]) -> Result<(), Failure> {
    let mut by_speed: BTreeMap<usize, Vec<&(usize, TileIndex, Tile)>> = BTreeMap::new();
    for tile in tiles {
        by_speed.entry(tile.0).or_default().push(tile);
    }
    for (speed, mut tiles) in by_speed {
        tiles.sort_by_key(|(_, index, _)| *index);
        let bytes = encode(maps.key(speed), &tiles).map_err(|error| Failure::writing(folder.path(), error))?;
        let name = format!("{}.parquet", digest(&bytes));
        folder.publish(&name, &bytes).map_err(|error| Failure::writing(&folder.path().join(name), error))?;
    }
    Ok(())
}

/// Writes all tiles of `maps`, including those of other runs.
pub fn write_all(maps: &Maps, folder: &Folder) -> Result<(), Failure> {
    write(maps, folder, &maps.tiles())
}

/// Integer columns of a piece: name and meaning.
const INTEGERS: [(&str, &str); 9] = [
    ("tile_column", "position of the tile along the preload"),
    ("tile_row", "position of the tile along the falling friction"),
    ("questions", "simulations that the tile took"),
    (
        "kind",
        "0 divided into four, 1 uniform, 2 crossed by a curve over preload, 3 crossed by a curve over falling friction, 4 unresolved",
    ),
    ("first_child", "of a divided box: place in its tile of the first of its four boxes"),
    ("verdict_below", "verdict below the curve, or of a uniform box: 0 stable, 1 unstable, 2 undecided, 3 failed"),
    ("verdict_above", "verdict above the curve"),
    ("cut", "how often the tile was divided to get this box"),
    ("cost", "cost of the simulations that the tile took, in units of scaled time"),
];

/// Largest count, so that the sums over all tiles fit 64 bits.
const MOST_COUNTED: u64 = 1 << 42;

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
        _ => Err(format!("{code} is not a verdict")),
    }
}

fn encode(key: &str, tiles: &[&(usize, TileIndex, Tile)]) -> Result<Vec<u8>, parquet::errors::ParquetError> {
    let mut integers: [Vec<i64>; INTEGERS.len()] = Default::default();
    let mut guards = Vec::new();
    let mut curves: [Lists<f64>; CURVES.len()] = Default::default();
    for (_, index, tile) in tiles {
        let mut depths = vec![0; tile.nodes().len()];
        for (place, node) in tile.nodes().iter().enumerate() {
            let (kind, child, below, above) = match node {
                Node::Cut(first) => {
                    (0..4).for_each(|child| depths[*first as usize + child] = depths[place] + 1);
                    (0, i64::from(*first), 0, 0)
                }
                Node::Uniform(verdict) => (1, 0, code(*verdict), code(*verdict)),
                Node::Crossed(curve) => (2 + curve.abscissa as i64, 0, code(curve.below), code(curve.above)),
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
                list.push(coefficients.iter().copied());
            }
        }
    }
    let mut fields = Vec::new();
    let mut columns = Vec::new();
    let mut add = |name: &'static str, long_name: &'static str, values: Values| {
        fields.push(Field { name: name.into(), unit: "1".into(), long_name: long_name.into(), kind: values.kind() });
        columns.push(values);
    };
    for ((name, long_name), values) in INTEGERS.into_iter().zip(integers) {
        add(name, long_name, Values::Integer(values));
    }
    add(GUARD, "distance from the curves within which samples are simulated", Values::Real(guards));
    let meaning = "Chebyshev coefficients, on the box, of the curve below which (lower) or above which (upper) the verdict is certain";
    for (name, lists) in CURVES.into_iter().zip(curves) {
        add(name, meaning, Values::Reals(lists));
    }
    encoded(&fields, columns, &[(KEY, key.to_owned())], Compression::UNCOMPRESSED)
}

/// The tiles of a map, and the key of the map.
type OwnTiles = (String, Vec<(TileIndex, Tile)>);

/// Reads a piece. Its checksum does not say who wrote it, so it may hold anything.
fn decode(bytes: Vec<u8>) -> Result<OwnTiles, String> {
    let is_wanted =
        |name: &str| name == GUARD || CURVES.contains(&name) || INTEGERS.iter().any(|(integer, _)| *integer == name);
    decode_tiles(&foreign::read(Bytes::from(bytes), Known::Piece, is_wanted)?)
}

fn decode_tiles(table: &ReadTable) -> Result<OwnTiles, String> {
    let key = table.pair(KEY).ok_or("it is not a piece of a verdict map")?.to_owned();
    let mut integers = Vec::new();
    for (name, _) in INTEGERS {
        integers.push(table.integers(name)?);
    }
    let guards = table.reals(GUARD)?;
    let mut curves = Vec::new();
    for name in CURVES {
        match table.column(name) {
            Some(ReadValues::Reals(lists)) => curves.push(lists),
            _ => return Err(format!("column {name} is not of lists of numbers")),
        }
    }
    let mut tiles: BTreeMap<TileIndex, (Vec<Node>, [u64; 2])> = BTreeMap::new();
    for row in 0..table.rows {
        let value = |column: usize| integers[column][row];
        let place = |column: usize| {
            u32::try_from(value(column)).ok().filter(|&place| place < TILES).ok_or("a tile is out of range")
        };
        let index = TileIndex { column: place(0)?, row: place(1)? };
        let coefficients = |curve: usize| -> Result<[f64; NODES], String> {
            curves[curve].row(row).try_into().map_err(|_| "a curve has too few coefficients".to_owned())
        };
        let node = match value(3) {
            0 => Node::Cut(u32::try_from(value(4)).map_err(|_| "a box is out of range")?),
            1 => Node::Uniform(verdict(value(5))?),
            kind @ (2 | 3) => Node::Crossed(BoundaryCurve {
                abscissa: (kind - 2) as usize,
                below: verdict(value(5))?,
                above: verdict(value(6))?,
                lower: coefficients(0)?,
                upper: coefficients(1)?,
                guard: guards[row],
            }),
            4 => Node::Unresolved,
            kind => return Err(format!("{kind} is not a kind of box")),
        };
        let count = |column: usize| {
            let count = u64::try_from(value(column)).ok().filter(|&count| count <= MOST_COUNTED);
            count.ok_or_else(|| format!("{} is no number of simulations, nor their cost", value(column)))
        };
        let counts = [count(2)?, count(8)?];
        let tile = tiles.entry(index).or_insert_with(|| (Vec::new(), counts));
        tile.0.push(node);
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
    use crate::files::forging::assert_bounded;

    /// A tile with boxes of every kind.
    fn tile(index: TileIndex) -> Tile {
        let verdict_at = |point: &[f64; 2]| match point {
            [x, y] if (x - 0.2).abs() < 0.01 && (y - 0.2).abs() < 0.01 => Verdict::Failed,
            [x, y] if x * y > 0.03 => Verdict::Unstable,
            [x, y] if x + y > 0.5 => Verdict::Undecided,
            _ => Verdict::Stable,
        };
        Tile::resolve(index, |points| points.iter().map(|point| Some(verdict_at(point))).collect()).unwrap()
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
    #[test]
    fn forged_pieces_are_read_or_refused() {
        let tile = tile(TileIndex { column: 1, row: 1 });
        let sound = [encode("key", &[&(0, TileIndex { column: 1, row: 1 }, tile)]).unwrap()];
        assert_bounded("store::map_pieces::tests::forged_pieces_are_read_or_refused", &sound, 1500, |bytes| {
            decode(bytes).map(drop)
        });
    }
}
