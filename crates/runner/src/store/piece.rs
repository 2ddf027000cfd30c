//! Pieces: files of finished units, from which a run resumes.
//!
//! A piece is a small Parquet file, named by the hash of its content. It is written under a temporary name and renamed
//! when it is on disk. A piece that is incomplete, altered or from another job is never used.

use std::ffi::{OsStr, OsString};
use std::path::Path;

use bytes::Bytes;
use parquet::basic::Compression;
use stickslip_core::criterion::time_domain::VERDICTS_VERSION;
use stickslip_core::verdict::VerdictCounts;
use stickslip_sampler::draw::identity::{ESTIMATES_VERSION, RESULTS_VERSION};
use stickslip_sampler::estimate::distribution::Distribution;
use stickslip_sampler::verdict_map::resolve::MAP_VERSION;

use crate::evaluate::unit::FinishedUnit;
use crate::failure::Failure;
use crate::files::column::{Field, Lists, Values};
use crate::files::decode::{ReadTable, ReadValues};
use crate::files::encode::encoded;
use crate::files::folder::{Folder, is_no_file};
use crate::files::foreign::{self, Known};
use crate::files::publish::is_temporary;
use crate::job::IDENTITY_VERSION;

const COLUMNS: [&str; 7] = ["cell", "first_sample", "n_samples", "n_stable", "n_unstable", "n_undecided", "n_failed"];

/// Columns of pieces with settled amplitudes: their sum, and a list of bins, each followed by its count.
const AMPLITUDE_SUM: &str = "amplitude_sum";
const AMPLITUDE_BINS: &str = "amplitude_bins";

/// Column of pieces with further sums.
const SUMS: &str = "sums";

const EXPERIMENT_KEY: &str = "stickslip:experiment";

/// A version that counts in what identifies a job.
struct CountedVersion {
    /// Its key in the footer.
    key: &'static str,
    /// Its name in messages.
    name: &'static str,
    /// That of this program.
    own: u32,
    /// That of pieces which do not name it, or an older one.
    unnamed: u32,
}

const VERSIONS: [CountedVersion; 5] = [
    CountedVersion { key: "stickslip:identity_version", name: "identity version", own: IDENTITY_VERSION, unnamed: 1 },
    CountedVersion { key: "stickslip:results_version", name: "results version", own: RESULTS_VERSION, unnamed: 1 },
    CountedVersion { key: "stickslip:verdicts_version", name: "verdicts version", own: VERDICTS_VERSION, unnamed: 2 },
    CountedVersion {
        key: "stickslip:estimates_version",
        name: "estimates version",
        own: ESTIMATES_VERSION,
        unnamed: 2,
    },
    CountedVersion { key: "stickslip:map_version", name: "map version", own: MAP_VERSION, unnamed: 2 },
];

/// What to do with a run of another version.
pub const REMEDY_OF_VERSIONS: &str = "Submit the run's job.toml again into another directory with --out, or continue the run with the stickslip that began it";

/// Largest number of bytes of a piece.
const MOST_BYTES: u64 = 1 << 30;

/// Largest count in a piece, and largest number of a part or sample. Jobs have at most a tenth of that many samples in a
/// cell, and sums of such counts fit 64 bits.
const MOST_COUNTED: u64 = 1 << 53;

/// Writes units as a new piece in `folder`.
pub fn write(folder: &Folder, experiment: &str, units: &[FinishedUnit]) -> Result<(), Failure> {
    let bytes = encode(experiment, units).map_err(|error| Failure::writing(folder.path(), error))?;
    let name = format!("{}.parquet", digest(&bytes));
    folder.publish(&name, &bytes).map_err(|error| Failure::writing(&folder.path().join(name), error))
}

/// Whether a file has the name of a piece: a digest.
pub fn is_piece_name(name: &OsStr) -> bool {
    let stem = name.to_str().and_then(|name| name.strip_suffix(".parquet"));
    stem.is_some_and(|stem| stem.len() == DIGITS && stem.bytes().all(|byte| byte.is_ascii_hexdigit()))
}

/// Why a piece is not used.
#[derive(Debug)]
pub enum Defect {
    /// It is there and was not or could not be read; it may be later.
    Unread(String),
    /// It does not hold what was written.
    Damaged(String),
}

/// What becomes of the content of a piece that is not used.
const AGAIN: &str = "what was in it will be computed again";

/// The bytes of a piece in `folder`, or why they are not what they were.
pub fn read_checked(folder: &Folder, name: &OsStr) -> Result<Vec<u8>, Defect> {
    let bytes = folder.read(name, MOST_BYTES).map_err(|error| {
        let why = format!("{error}; {AGAIN}");
        if is_no_file(&error) { Defect::Damaged(why) } else { Defect::Unread(why) }
    })?;
    if *name == *format!("{}.parquet", digest(&bytes)) {
        Ok(bytes)
    } else {
        Err(Defect::Damaged(format!("its content does not match the checksum in its name; {AGAIN}")))
    }
}

/// A file that is left out, and why.
#[derive(Debug)]
pub struct Complaint {
    /// Its name.
    pub name: OsString,
    /// What is wrong.
    pub defect: Defect,
}

/// Reads every piece in `folder`, one after the other, and passes the units of those that are in order to `take`.
/// `is_part` says which numbers parts may have, and `sums` is the number of sums. Returns what is not in order.
///
/// # Errors
/// A directory that cannot be read, an undamaged piece of another experiment, as the two must not be mixed, and what
/// `take` refuses.
pub fn read_all(
    folder: &Folder,
    experiment: &str,
    is_part: impl Fn(u64) -> bool,
    sums: usize,
    take: &mut dyn FnMut(FinishedUnit) -> Result<(), Failure>,
) -> Result<Vec<Complaint>, Failure> {
    let mut complaints = Vec::new();
    let names = folder.names().map_err(|error| Failure::reading(folder.path(), error))?;
    // Other files, such as .DS_Store, are left alone.
    let is_parquet = |name: &&OsString| Path::new(name).extension().is_some_and(|extension| extension == "parquet");
    for name in names.iter().filter(is_parquet).filter(|name| !is_temporary(Path::new(name))) {
        let mut complain = |defect: Defect| complaints.push(Complaint { name: name.clone(), defect });
        if !is_piece_name(name) {
            complain(Defect::Unread("it does not have the name of a piece".to_owned()));
            continue;
        }
        let bytes = match read_checked(folder, name) {
            Ok(bytes) => bytes,
            Err(defect) => {
                complain(defect);
                continue;
            }
        };
        match decode(bytes) {
            Ok((owner, _)) if owner.experiment != experiment => return Err(owner.refused(&folder.path().join(name))),
            Ok((_, units)) if units.iter().all(|s| is_part(s.part) && s.sums.len() == sums && s.is_consistent()) => {
                units.into_iter().try_for_each(&mut *take)?;
            }
            Ok(_) => complain(Defect::Damaged(format!("its counts do not add up; {AGAIN}"))),
            Err(why) => complain(Defect::Damaged(format!("{why}; {AGAIN}"))),
        }
    }
    Ok(complaints)
}

/// The run that a piece belongs to, as named in its footer.
struct Owner {
    experiment: String,
    /// In the order of [`VERSIONS`].
    versions: [u32; VERSIONS.len()],
}

impl Owner {
    /// A message why a piece of another job or version is refused, and what to do.
    fn refused(&self, path: &Path) -> Failure {
        let path = path.display();
        let differing: Vec<(&CountedVersion, u32)> =
            VERSIONS.iter().zip(self.versions).filter(|(version, found)| version.own != *found).collect();
        if differing.is_empty() {
            return Failure::Job(format!(
                "{path} belongs to another job or another version of stickslip. Was the run's job.toml edited or removed? Restore it, or choose another directory with --out"
            ));
        }
        let which = if differing.iter().all(|(version, found)| *found < version.own) {
            "an earlier"
        } else if differing.iter().all(|(version, found)| *found > version.own) {
            "a later"
        } else {
            "another"
        };
        let named = differing
            .iter()
            .map(|(version, found)| format!("{} {found}, where this one has {}", version.name, version.own));
        let named: Vec<String> = named.collect();
        Failure::Job(format!(
            "{path} was written by {which} version of stickslip ({}); what two versions compute is not mixed. {REMEDY_OF_VERSIONS}. If job.toml was edited, restore it first",
            named.join("; ")
        ))
    }
}

/// Hexadecimal digits of a digest.
const DIGITS: usize = 32;

/// The name of a piece: a hash of its content.
pub fn digest(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex()[..DIGITS].to_owned()
}

fn encode(experiment: &str, units: &[FinishedUnit]) -> Result<Vec<u8>, parquet::errors::ParquetError> {
    let column = |value: fn(&FinishedUnit) -> u64| {
        // Counts stay far below 2^63, see the limit on samples.
        Values::Integer(units.iter().map(|unit| value(unit).cast_signed()).collect())
    };
    let counts = [
        column(|s| s.part),
        column(|s| s.samples.start),
        column(FinishedUnit::len),
        column(|s| s.counts.stable),
        column(|s| s.counts.unstable),
        column(|s| s.counts.undecided),
        column(|s| s.counts.failed),
    ];
    let mut columns: Vec<(&'static str, Values)> = COLUMNS.into_iter().zip(counts).collect();
    if units.iter().any(|unit| unit.amplitudes.count() > 0) {
        let mut bins = Lists::default();
        for unit in units {
            bins.push(unit.amplitudes.bins().flat_map(|(bin, count)| [i64::from(bin), count.cast_signed()]));
        }
        columns.push((AMPLITUDE_SUM, column(|s| s.amplitudes.sum())));
        columns.push((AMPLITUDE_BINS, Values::Integers(bins)));
    }
    if units.iter().any(|unit| !unit.sums.is_empty()) {
        let mut sums = Lists::default();
        units.iter().for_each(|unit| sums.push(unit.sums.iter().copied()));
        columns.push((SUMS, Values::Integers(sums)));
    }
    let field = |(name, values): &(&'static str, Values)| Field {
        name: (*name).into(),
        unit: "".into(),
        long_name: "".into(),
        kind: values.kind(),
    };
    let fields: Vec<Field> = columns.iter().map(field).collect();
    let mut owner = vec![(EXPERIMENT_KEY, experiment.to_owned())];
    owner.extend(VERSIONS.iter().map(|version| (version.key, version.own.to_string())));
    encoded(&fields, columns.into_iter().map(|(_, values)| values), &owner, Compression::UNCOMPRESSED)
}

/// Reads a piece. Its checksum does not say who wrote it, so it may hold anything.
fn decode(bytes: Vec<u8>) -> Result<(Owner, Vec<FinishedUnit>), String> {
    let is_wanted = |name: &str| COLUMNS.contains(&name) || [AMPLITUDE_SUM, AMPLITUDE_BINS, SUMS].contains(&name);
    decode_units(&foreign::read(Bytes::from(bytes), Known::Piece, is_wanted)?)
}

fn decode_units(table: &ReadTable) -> Result<(Owner, Vec<FinishedUnit>), String> {
    let version_of = |key: &str| table.pair(key)?.parse::<u32>().ok();
    let owner = Owner {
        experiment: table.pair(EXPERIMENT_KEY).ok_or("it does not name its job")?.to_owned(),
        versions: VERSIONS.map(|version| version_of(version.key).unwrap_or(version.unnamed)),
    };
    let mut columns = Vec::new();
    for name in COLUMNS {
        columns.push(table.integers(name)?);
    }
    let amplitudes = match table.column(AMPLITUDE_SUM).and(lists(table, AMPLITUDE_BINS)?) {
        Some(bins) => Some((table.integers(AMPLITUDE_SUM)?, bins)),
        None => None,
    };
    let sums = lists(table, SUMS)?;
    let unit = |row: usize| {
        let value = |column: usize| count(columns[column][row]);
        let start = value(1)?;
        let end = start.checked_add(value(2)?).ok_or("a range of samples overflows")?;
        let counts = VerdictCounts { stable: value(3)?, unstable: value(4)?, undecided: value(5)?, failed: value(6)? };
        let amplitudes = match &amplitudes {
            Some((sums, bins)) => decode_amplitudes(sums[row], bins.row(row))?,
            None => Distribution::default(),
        };
        let sums = sums.map_or_else(Vec::new, |sums| sums.row(row).to_vec());
        Ok(FinishedUnit { part: value(0)?, samples: start..end, counts, amplitudes, sums })
    };
    Ok((owner, (0..table.rows).map(unit).collect::<Result<_, String>>()?))
}

/// A count as it is stored, if it is possible.
fn count(stored: i64) -> Result<u64, String> {
    let count = u64::try_from(stored).map_err(|_| "a count is negative")?;
    if count <= MOST_COUNTED { Ok(count) } else { Err(format!("a count is above {MOST_COUNTED}")) }
}

/// The settled amplitudes of a unit, from their sum and their bins.
fn decode_amplitudes(sum: i64, bins: &[i64]) -> Result<Distribution, String> {
    let mut pairs = Vec::with_capacity(bins.len() / 2);
    for pair in bins.chunks_exact(2) {
        let bin = u32::try_from(pair[0]).ok().filter(|&bin| Distribution::is_bin(bin));
        let bin = bin.ok_or("a bin of amplitudes is out of range")?;
        if pairs.last().is_some_and(|(before, _)| *before >= bin) {
            return Err("the bins of amplitudes are not in order".to_owned());
        }
        pairs.push((bin, count(pair[1])?));
    }
    Ok(Distribution::from_parts(sum.cast_unsigned(), pairs))
}

/// A column of lists of integers, if there is one.
fn lists<'a>(table: &'a ReadTable, name: &str) -> Result<Option<&'a Lists<i64>>, String> {
    match table.column(name) {
        Some(ReadValues::Integers(lists)) => Ok(Some(lists)),
        Some(_) => Err(format!("column {name} is not of lists of integers")),
        None => Ok(None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::forging::assert_bounded;
    use std::fs;
    use std::path::PathBuf;

    use crate::files::publish::files;

    fn some_units() -> Vec<FinishedUnit> {
        (0..50)
            .map(|cell| FinishedUnit {
                part: cell,
                samples: 1000 * cell..1000 * cell + 10,
                counts: VerdictCounts { stable: 4, unstable: 3, undecided: 2, failed: 1 },
                amplitudes: amplitudes(cell),
                sums: vec![-(cell as i64), i64::MAX],
            })
            .collect()
    }

    /// The amplitudes of the three unstable samples in every other unit, none in the rest.
    fn amplitudes(cell: u64) -> Distribution {
        let mut amplitudes = Distribution::default();
        (0..3 * (cell % 2)).for_each(|i| amplitudes.add(1e-3 * (cell + i) as f64));
        amplitudes
    }

    fn folder(directory: &tempfile::TempDir) -> Folder {
        Folder::open(directory.path()).unwrap()
    }

    fn written() -> (tempfile::TempDir, PathBuf) {
        let directory = tempfile::tempdir().unwrap();
        write(&folder(&directory), "experiment", &some_units()).unwrap();
        let piece = files(directory.path()).unwrap().remove(0);
        (directory, piece)
    }

    /// The units of all pieces, and the complaints.
    fn read(folder: &Folder, experiment: &str) -> Result<(Vec<FinishedUnit>, Vec<Complaint>), Failure> {
        let mut units = Vec::new();
        let complaints = read_all(folder, experiment, |part| part < 50, 2, &mut |unit| {
            units.push(unit);
            Ok(())
        })?;
        Ok((units, complaints))
    }

    #[test]
    fn a_piece_reads_back_as_written() {
        let (directory, _) = written();
        let (units, complaints) = read(&folder(&directory), "experiment").unwrap();
        assert_eq!(units, some_units());
        assert!(complaints.is_empty());
    }

    #[test]
    fn damage_is_found() {
        let (directory, piece) = written();
        let sound = fs::read(&piece).unwrap();
        for position in (0..sound.len()).step_by(7) {
            let mut bytes = sound.clone();
            bytes[position] ^= 0x10;
            fs::write(&piece, &bytes).unwrap();
            let (units, complaints) = read(&folder(&directory), "experiment").unwrap();
            assert!(units.is_empty() && complaints.len() == 1, "byte {position}");
        }
        for length in [0, 1, sound.len() / 2, sound.len() - 1] {
            fs::write(&piece, &sound[..length]).unwrap();
            let (units, complaints) = read(&folder(&directory), "experiment").unwrap();
            assert!(units.is_empty() && complaints.len() == 1, "length {length}");
        }
    }

    #[test]
    fn counts_that_do_not_add_up_are_refused_even_with_a_good_checksum() {
        let directory = tempfile::tempdir().unwrap();
        let mut wrong = some_units();
        wrong[7].counts.stable += 1;
        write(&folder(&directory), "experiment", &wrong).unwrap();
        let (units, complaints) = read(&folder(&directory), "experiment").unwrap();
        assert!(units.is_empty() && format!("{:?}", complaints[0]).contains("do not add up"));
    }

    #[test]
    fn counts_that_wrap_are_refused() {
        for change in [
            |unit: &mut FinishedUnit| unit.counts.stable = 1 << 63,
            |unit: &mut FinishedUnit| {
                // Their sum is that of the samples modulo 2^64.
                unit.counts.stable = 1 << 62;
                unit.counts.unstable = 1 << 62;
                unit.counts.undecided = 1 << 62;
                unit.counts.failed = (1 << 62) + 10;
            },
            |unit: &mut FinishedUnit| unit.samples = (1 << 63) - 1..(1 << 63) + 9,
            |unit: &mut FinishedUnit| unit.part = 1 << 54,
        ] {
            let directory = tempfile::tempdir().unwrap();
            let mut units = some_units();
            change(&mut units[7]);
            let folder = folder(&directory);
            write(&folder, "experiment", &units).unwrap();
            let mut taken = 0;
            let complaints = read_all(&folder, "experiment", |_| true, 2, &mut |_| {
                taken += 1;
                Ok(())
            });
            let complaints = complaints.unwrap();
            assert!(taken == 0 && complaints.len() == 1, "{complaints:?}");
        }
    }

    #[test]
    fn forged_pieces_are_read_or_refused() {
        let mut plain = some_units();
        plain.iter_mut().for_each(|unit| {
            unit.amplitudes = Distribution::default();
            unit.sums.clear();
        });
        let sound = [some_units(), plain].map(|units| encode("experiment", &units).unwrap());
        assert_bounded("store::piece::tests::forged_pieces_are_read_or_refused", &sound, 3000, |bytes| {
            let (_, units) = decode(bytes)?;
            units.iter().all(FinishedUnit::is_consistent).then_some(()).ok_or_else(|| "inconsistent".to_owned())
        });
    }

    #[test]
    fn a_piece_of_another_job_is_an_error() {
        let (directory, _) = written();
        assert!(matches!(read(&folder(&directory), "other"), Err(Failure::Job(_))));
    }

    #[test]
    fn a_piece_of_another_version_is_refused_with_both_versions_and_a_remedy() {
        let piece = Path::new("run/shards/0123.parquet");
        let refused = |versions| Owner { experiment: "e".to_owned(), versions }.refused(piece).to_string();
        let own = VERSIONS.map(|version| version.own);
        assert!(refused(own).contains("belongs to another job"));
        for (i, CountedVersion { name, own: version, .. }) in VERSIONS.iter().enumerate() {
            for (which, other) in [("an earlier", version - 1), ("a later", version + 1)] {
                let mut versions = own;
                versions[i] = other;
                let message = refused(versions);
                for text in [
                    format!("run/shards/0123.parquet was written by {which} version of stickslip"),
                    format!("({name} {other}, where this one has {version})"),
                    "again into another directory with --out".to_owned(),
                ] {
                    assert!(message.contains(&text), "{text:?} is not in: {message}");
                }
            }
        }
        let mut mixed = own;
        (mixed[0], mixed[1]) = (own[0] - 1, own[1] + 1);
        assert!(refused(mixed).contains("by another version"));
    }

    #[test]
    fn unfinished_files_are_not_read() {
        let (directory, _) = written();
        fs::write(directory.path().join(".unfinished-123-x.parquet"), "half").unwrap();
        assert_eq!(read(&folder(&directory), "experiment").unwrap().0.len(), 50);
        folder(&directory).remove_unfinished().unwrap();
        assert_eq!(files(directory.path()).unwrap().len(), 1);
    }
}
