//! Pieces of verdict maps: files of finished tiles.
//!
//! They are written to `map/` as those of samples are: the first line names everything that the verdicts depend on
//! (model, configuration, criterion), so that other jobs can use them, and each further one is a tile.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use stickslip_core::model::verdict::Verdict;
use stickslip_sampler::verdict_map::boundary_curve::{BoundaryCurve, NODES};
use stickslip_sampler::verdict_map::tile::{Node, TILES, Tile, TileIndex};

use crate::evaluate::maps::Maps;
use crate::failure::Failure;
use crate::files::folder::Folder;
use crate::output::warn_of;
use crate::store::piece::{self, Defect, is_piece_name, read_checked};

/// The first line of a piece.
#[derive(Serialize, Deserialize)]
struct Owner {
    verdict_map: String,
}

/// Adds the tiles in a directory of pieces that `maps` need, and returns their number. Tiles that are not needed are
/// left out, so that a map does not depend on where its tiles come from.
pub fn load(maps: &mut Maps, folder: &Folder) -> Result<usize, Failure> {
    let mut loaded = 0;
    if maps.is_empty() {
        return Ok(0);
    }
    let names = folder.names().map_err(|error| Failure::reading(folder.path(), error))?;
    for name in names.iter().filter(|name| is_piece_name(name)) {
        let ignored = |why: &str| warn_of(&folder.path().join(name), format_args!(" is ignored: {why}"));
        let bytes = match read_checked(folder, name) {
            Ok(bytes) => bytes,
            Err(Defect::Unread(why) | Defect::Damaged(why)) => {
                ignored(&why);
                continue;
            }
        };
        match decode(&bytes) {
            Ok((key, tiles)) => {
                let Some(configuration) = maps.configuration_of(&key) else { continue };
                for (index, tile) in tiles {
                    if maps.needs(configuration, index) {
                        maps.insert(configuration, index, tile);
                        loaded += 1;
                    }
                }
            }
            Err(why) => ignored(&why),
        }
    }
    Ok(loaded)
}

/// Writes tiles as new pieces, one for each configuration.
pub fn write(maps: &Maps, folder: &Folder, tiles: &[(usize, TileIndex, Tile)]) -> Result<(), Failure> {
    let mut by_configuration: BTreeMap<usize, Vec<&(usize, TileIndex, Tile)>> = BTreeMap::new();
    for tile in tiles {
        by_configuration.entry(tile.0).or_default().push(tile);
    }
    for (configuration, mut tiles) in by_configuration {
        tiles.sort_by_key(|(_, index, _)| *index);
        let owner = Owner { verdict_map: maps.key(configuration).to_owned() };
        piece::publish(folder, &owner, tiles.into_iter().map(|(_, index, tile)| stored(*index, tile)))?;
    }
    Ok(())
}

/// Writes all tiles of `maps`, including those of other runs.
pub fn write_all(maps: &Maps, folder: &Folder) -> Result<(), Failure> {
    write(maps, folder, &maps.tiles())
}

/// Largest count, so that the sums over all tiles fit 64 bits.
const MOST_COUNTED: u64 = 1 << 42;

/// A tile as it is stored: its column and row, the number of its simulations, its boxes.
type Stored = (u32, u32, u64, Vec<StoredNode>);

/// A box as it is stored.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum StoredNode {
    Cut(u32),
    Uniform(StoredVerdict),
    Crossed(StoredCurve),
    Unresolved,
}

/// The place of a verdict in [`VERDICTS`].
type StoredVerdict = u8;

/// Abscissa, verdicts below and above, the coefficients of both, and the guard. Numbers are stored by their bits.
type StoredCurve = (usize, StoredVerdict, StoredVerdict, [u64; NODES], [u64; NODES], u64);

const VERDICTS: [Verdict; 4] = [Verdict::Stable, Verdict::Unstable, Verdict::Undecided, Verdict::Failed];

fn stored(index: TileIndex, tile: &Tile) -> Stored {
    let code = |verdict: Verdict| VERDICTS.iter().position(|other| *other == verdict).unwrap_or_default() as u8;
    let node = |node: &Node| match *node {
        Node::Cut(first) => StoredNode::Cut(first),
        Node::Uniform(verdict) => StoredNode::Uniform(code(verdict)),
        Node::Crossed(BoundaryCurve { abscissa, below, above, lower, upper, guard }) => {
            let [lower, upper] = [lower, upper].map(|curve| curve.map(f64::to_bits));
            StoredNode::Crossed((abscissa, code(below), code(above), lower, upper, guard.to_bits()))
        }
        Node::Unresolved => StoredNode::Unresolved,
    };
    (index.column, index.row, tile.questions, tile.nodes().iter().map(node).collect())
}

/// A tile from what is stored of it, if that is possible.
fn tile((column, row, questions, nodes): Stored) -> Result<(TileIndex, Tile), String> {
    if column >= TILES || row >= TILES || questions > MOST_COUNTED {
        return Err("a tile is out of range, or its number of simulations".to_owned());
    }
    let verdict = |code: StoredVerdict| VERDICTS.get(usize::from(code)).copied();
    let node = |node: StoredNode| {
        Some(match node {
            StoredNode::Cut(first) => Node::Cut(first),
            StoredNode::Uniform(code) => Node::Uniform(verdict(code)?),
            StoredNode::Crossed((abscissa, below, above, lower, upper, guard)) if abscissa < 2 => {
                let [lower, upper] = [lower, upper].map(|curve| curve.map(f64::from_bits));
                let (below, above) = (verdict(below)?, verdict(above)?);
                Node::Crossed(BoundaryCurve { abscissa, below, above, lower, upper, guard: f64::from_bits(guard) })
            }
            StoredNode::Crossed(_) => return None,
            StoredNode::Unresolved => Node::Unresolved,
        })
    };
    let nodes = nodes.into_iter().map(node).collect::<Option<_>>().ok_or("a box has no such verdict or abscissa")?;
    let tile = Tile::from_nodes(nodes, questions).ok_or("the boxes of a tile do not fit together")?;
    Ok((TileIndex { column, row }, tile))
}

/// The key of the map that a piece is of, and its tiles.
fn decode(bytes: &[u8]) -> Result<(String, Vec<(TileIndex, Tile)>), String> {
    let (Owner { verdict_map }, lines) = piece::decode(bytes)?;
    Ok((verdict_map, lines.map(|line| tile(line?)).collect::<Result<_, _>>()?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::forging::assert_bounded;

    /// A tile with boxes of every kind.
    fn resolved(index: TileIndex) -> Tile {
        let verdict_at = |point: &[f64; 2]| match point {
            [x, y] if (x - 0.2).abs() < 0.01 && (y - 0.2).abs() < 0.01 => Verdict::Failed,
            [x, y] if x * y > 0.03 => Verdict::Unstable,
            [x, y] if x + y > 0.5 => Verdict::Undecided,
            _ => Verdict::Stable,
        };
        Tile::resolve(index, |points| points.iter().map(|point| Some(verdict_at(point))).collect()).unwrap()
    }

    fn encoded(tiles: &[(TileIndex, Tile)]) -> Vec<u8> {
        let tiles = tiles.iter().map(|(index, tile)| stored(*index, tile));
        piece::encode(&Owner { verdict_map: "key".to_owned() }, tiles).unwrap()
    }

    #[test]
    fn a_tile_reads_back_as_written() {
        let leaves = [Verdict::Stable, Verdict::Unstable, Verdict::Undecided].map(Node::Uniform);
        let nodes = vec![Node::Cut(1), leaves[0], leaves[1], leaves[2], Node::Unresolved];
        let handmade = Tile::from_nodes(nodes, 77).unwrap();
        let mut tiles = vec![(TileIndex { column: 5, row: 7 }, handmade)];
        tiles.extend((0..3).map(|row| TileIndex { column: 1, row }).map(|index| (index, resolved(index))));
        assert!(tiles.iter().any(|(_, tile)| tile.nodes().iter().any(|node| matches!(node, Node::Crossed(_)))));
        assert!(decode(&encoded(&tiles)).unwrap() == ("key".to_owned(), tiles));
    }

    #[test]
    fn forged_pieces_are_read_or_refused() {
        let index = TileIndex { column: 1, row: 1 };
        let sound = [encoded(&[(index, resolved(index))])];
        assert_bounded("store::map_pieces::tests::forged_pieces_are_read_or_refused", &sound, 1500, |bytes| {
            decode(&bytes).map(drop)
        });
    }
}
