//! Pieces: files of finished units, from which a run resumes.
//!
//! A piece is a file of lines of JSON, named by the hash of its content: the first line says whose it is, each further
//! one is a unit. It is written under a temporary name and renamed when it is on disk. A piece that is incomplete or
//! altered is found by its name before anything in it is read, and one of another job is never used.

use std::collections::BTreeMap;
use std::ffi::{OsStr, OsString};
use std::path::Path;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use stickslip_sampler::draw::identity::RESULTS_VERSION;

use crate::evaluate::unit::FinishedUnit;
use crate::failure::Failure;
use crate::files::folder::{Folder, is_no_file};
use crate::files::publish::is_temporary;
use crate::messages::{Code, Place};
use crate::version::FORMAT_VERSION;

/// The versions that count in what identifies a job, by their names in pieces and in messages.
const VERSIONS: [(&str, u32); 2] = [("format version", FORMAT_VERSION), ("results version", RESULTS_VERSION)];

/// What to do with a run of another version.
pub const REMEDY_OF_VERSIONS: &str = "Submit the run's job.toml again into another directory with --out, or continue the run with the stickslip that began it";

/// Largest number of bytes of a piece.
const MOST_BYTES: u64 = 1 << 30;

/// What the names of pieces end with.
const EXTENSION: &str = "jsonl";

/// Writes units as a new piece in `folder`.
pub fn write(folder: &Folder, experiment: &str, units: &[FinishedUnit]) -> Result<(), Failure> {
    publish(folder, &Owner::new(experiment), units)
}

/// Writes a new piece in `folder`: a line that says whose it is, and others.
pub fn publish<T: Serialize>(
    folder: &Folder,
    owner: &impl Serialize,
    lines: impl IntoIterator<Item = T>,
) -> Result<(), Failure> {
    let bytes = encode(owner, lines).map_err(|error| Failure::writing(folder.path(), error))?;
    let name = name_of(&bytes);
    folder.publish(&name, &bytes).map_err(|error| Failure::writing(&folder.path().join(name), error))
}

/// Whether a file has the name of a piece: a digest.
pub fn is_piece_name(name: &OsStr) -> bool {
    let stem = name.to_str().and_then(|name| name.strip_suffix(EXTENSION)?.strip_suffix('.'));
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

/// What happens to the content of a piece that is not used.
const AGAIN: &str = "what was in it will be computed again";

/// The bytes of a piece in `folder`, or why they are not what they were.
pub fn read_checked(folder: &Folder, name: &OsStr) -> Result<Vec<u8>, Defect> {
    let bytes = folder.read_while(name, MOST_BYTES, is_text).map_err(|error| {
        let why = format!("{error}; {AGAIN}");
        if is_no_file(&error) { Defect::Damaged(why) } else { Defect::Unread(why) }
    })?;
    if *name == *name_of(&bytes) {
        Ok(bytes)
    } else {
        Err(Defect::Damaged(format!("its content does not match the checksum in its name; {AGAIN}")))
    }
}

/// Whether bytes can stand in a piece: JSON in lines has no other control characters. The holes of a sparse file, which
/// may be large, are zeros.
fn is_text(bytes: &[u8]) -> bool {
    bytes.iter().all(|byte| *byte >= b' ' || *byte == b'\n')
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
/// `wrong` says why a unit cannot be one of the run, if so. Returns what is not in order.
///
/// # Errors
/// A directory that cannot be read, an undamaged piece of another experiment, as the two must not be mixed, and what
/// `take` refuses.
pub fn read_all(
    folder: &Folder,
    experiment: &str,
    wrong: impl Fn(&FinishedUnit) -> Option<&'static str>,
    take: &mut dyn FnMut(FinishedUnit) -> Result<(), Failure>,
) -> Result<Vec<Complaint>, Failure> {
    let mut complaints = Vec::new();
    let names = folder.names().map_err(|error| Failure::reading(folder.path(), error))?;
    // Other files, such as .DS_Store, are left alone.
    let may_be_piece = |name: &&OsString| Path::new(name).extension().is_some_and(|extension| extension == EXTENSION);
    for name in names.iter().filter(may_be_piece).filter(|name| !is_temporary(Path::new(name))) {
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
        let (owner, lines) = match decode::<Owner, FinishedUnit>(&bytes) {
            Ok(decoded) => decoded,
            Err(why) => {
                complain(Defect::Damaged(format!("{why}; {AGAIN}")));
                continue;
            }
        };
        if owner != Owner::new(experiment) {
            return Err(owner.refused(&folder.path().join(name)));
        }
        match lines.collect::<Result<Vec<_>, _>>() {
            Ok(units) => match units.iter().find_map(&wrong) {
                None => units.into_iter().try_for_each(&mut *take)?,
                Some(why) => complain(Defect::Damaged(format!("{why}; {AGAIN}"))),
            },
            Err(why) => complain(Defect::Damaged(format!("{why}; {AGAIN}"))),
        }
    }
    Ok(complaints)
}

/// The run that a piece belongs to.
#[derive(Serialize, Deserialize, PartialEq)]
struct Owner {
    experiment: String,
    versions: BTreeMap<String, u32>,
}

impl Owner {
    fn new(experiment: &str) -> Self {
        let versions = VERSIONS.iter().map(|(name, own)| ((*name).to_owned(), *own)).collect();
        Self { experiment: experiment.to_owned(), versions }
    }

    /// A message why a piece of another job or version is refused, and what to do.
    fn refused(&self, path: &Path) -> Failure {
        let shown = path.display();
        let found = VERSIONS.iter().map(|(name, own)| (*name, *own, self.versions.get(*name).copied().unwrap_or(0)));
        let differing: Vec<(&str, u32, u32)> = found.filter(|(_, own, found)| own != found).collect();
        if differing.is_empty() {
            return Failure::Job(format!(
                "{shown} belongs to another job or another version of stickslip. Was the run's job.toml edited or removed? Restore it, or choose another directory with --out"
            ))
            .coded(Code::JobDiffers)
            .at(Place::file(path));
        }
        let named = differing.iter().map(|(name, own, found)| format!("{name} {found}, where this one has {own}"));
        let named: Vec<String> = named.collect();
        Failure::Job(format!(
            "{shown} was written by another version of stickslip ({}); what two versions compute is not mixed. {REMEDY_OF_VERSIONS}",
            named.join("; ")
        ))
        .coded(Code::OtherVersion)
        .at(Place::file(path))
        .remedied(REMEDY_OF_VERSIONS)
    }
}

/// Hexadecimal digits of a digest.
const DIGITS: usize = 32;

/// The name of a piece: a hash of its content.
fn name_of(bytes: &[u8]) -> String {
    format!("{}.{EXTENSION}", &blake3::hash(bytes).to_hex()[..DIGITS])
}

/// The bytes of a piece: a line that says whose it is, and others.
pub fn encode<T: Serialize>(owner: &impl Serialize, lines: impl IntoIterator<Item = T>) -> serde_json::Result<Vec<u8>> {
    let mut bytes = serde_json::to_vec(owner)?;
    for line in lines {
        bytes.push(b'\n');
        serde_json::to_writer(&mut bytes, &line)?;
    }
    Ok(bytes)
}

/// The lines of a piece, each read when it is asked for.
type Lines<'a, T> = Box<dyn Iterator<Item = Result<T, String>> + 'a>;

/// Reads a piece: whose it is, and the lines after that. Its checksum does not say who wrote it, so it may hold anything.
pub fn decode<'a, O: DeserializeOwned, T: DeserializeOwned>(bytes: &'a [u8]) -> Result<(O, Lines<'a, T>), String> {
    let mut lines = bytes.split(|byte| *byte == b'\n');
    let owner = serde_json::from_slice(lines.next().unwrap_or_default());
    let line = |line: &[u8]| serde_json::from_slice(line).map_err(|error| error.to_string());
    Ok((owner.map_err(|_| "it does not name its job")?, Box::new(lines.map(line))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::forging::assert_bounded;
    use std::fs;
    use std::path::PathBuf;

    use stickslip_core::model::recorded::{RecordedOf, RecordedResult};
    use stickslip_core::model::verdict::VerdictCounts;

    use crate::evaluate::unit::Recorded;
    use crate::files::publish::files;

    fn some_units() -> Vec<FinishedUnit> {
        (0..50)
            .map(|cell| FinishedUnit {
                part: cell,
                samples: 1000 * cell..1000 * cell + 10,
                counts: VerdictCounts { stable: 4, unstable: 3, undecided: 2, failed: 1 },
                recorded: recorded(cell),
                sums: vec![-(cell as i64), i64::MAX],
            })
            .collect()
    }

    const fn result(of: RecordedOf) -> RecordedResult {
        RecordedResult { name: "", unit: "1", noun: "", meaning: "", of, is_length: false, has_mean: true }
    }

    const RESULTS: [RecordedResult; 2] = [result(RecordedOf::Unstable), result(RecordedOf::All)];

    /// Values of the three unstable samples in every other unit, none in the rest; of all ten in every third, of either sign.
    fn recorded(cell: u64) -> Recorded {
        let mut recorded = Recorded::default();
        (0..3 * (cell % 2)).for_each(|i| recorded[0].add(1e-3 * (cell + i) as f64));
        if cell.is_multiple_of(3) {
            (0..10).for_each(|i| recorded[1].add(1e12 - 3e11 * i as f64));
        }
        recorded
    }

    fn may_be(unit: &FinishedUnit) -> bool {
        unit.sums.len() == 2 && unit.is_consistent(&RESULTS)
    }

    fn wrong(unit: &FinishedUnit) -> Option<&'static str> {
        (!may_be(unit) || unit.part >= 50).then_some("its counts do not add up")
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
        let complaints = read_all(folder, experiment, wrong, &mut |unit| {
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
    fn lines_are_as_long_as_what_is_recorded() {
        let line =
            |cell: u64| serde_json::to_string(&FinishedUnit { sums: vec![5], ..some_units()[cell as usize].clone() });
        assert_eq!(line(2).unwrap(), "[2,2000,10,[4,3,2,1],0,[],[5]]");
        // The leading 22 bits of 1e-3, 2e-3 and 3e-3, and their sum in steps of 2^-34.
        let plain = "[1,1000,10,[4,3,2,1],103079215,[[1037336,1],[1038360,1],[1038884,1]],[5]]";
        assert_eq!(line(1).unwrap(), plain);
        assert!(line(0).unwrap().starts_with("[0,0,10,[4,3,2,1],0,[],[5],"));
        let longer = line(3).unwrap();
        assert_eq!(serde_json::from_str::<FinishedUnit>(&longer).unwrap().recorded, recorded(3));
        for wrong in [longer.replace("]]]", "]],1]"), longer.replace(",[5],", ",[5],1,"), plain.replace(",[5]", "")] {
            assert!(serde_json::from_str::<FinishedUnit>(&wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn more_values_than_samples_of_their_kind_are_refused() {
        let mut units = some_units();
        assert!(units.iter().all(may_be));
        units.iter_mut().for_each(|unit| unit.recorded[2].add(1.0));
        assert!(!units.iter().any(may_be));
        let mut unit = some_units().remove(1);
        unit.recorded[0].add(1.0);
        assert!(!may_be(&unit));
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
    fn holes_are_not_read_to_their_end() {
        let directory = tempfile::tempdir().unwrap();
        let piece = directory.path().join(name_of(b"hole"));
        fs::write(&piece, encode(&Owner::new("experiment"), some_units()).unwrap()).unwrap();
        fs::File::options().write(true).open(&piece).unwrap().set_len(MOST_BYTES).unwrap();
        let folder = folder(&directory);
        let (units, complaints) = read(&folder, "experiment").unwrap();
        assert!(units.is_empty() && format!("{:?}", complaints[0]).contains("bytes that no such file has"));
        let looked_at = std::cell::Cell::new(0);
        let refused = folder.read_while(name_of(b"hole"), MOST_BYTES, |bytes| {
            looked_at.set(looked_at.get() + bytes.len() as u64);
            is_text(bytes)
        });
        assert!(refused.is_err() && looked_at.get() < MOST_BYTES / 1000, "{} bytes", looked_at.get());
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
            let complaints = read_all(&folder, "experiment", wrong, &mut |_| {
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
            unit.recorded = Recorded::default();
            unit.sums.clear();
        });
        let owner = Owner::new("experiment");
        let sound = [some_units(), plain].map(|units| encode(&owner, &units).unwrap());
        assert_bounded("store::piece::tests::forged_pieces_are_read_or_refused", &sound, 3000, |bytes| {
            let (_, lines) = decode::<Owner, FinishedUnit>(&bytes)?;
            let units = lines.collect::<Result<Vec<_>, _>>()?;
            units.iter().all(|unit| unit.is_consistent(&RESULTS)).then_some(()).ok_or_else(|| "inconsistent".to_owned())
        });
    }

    #[test]
    fn a_piece_of_another_job_is_an_error() {
        let (directory, _) = written();
        assert!(read(&folder(&directory), "other").unwrap_err().is_of_job());
    }

    #[test]
    fn a_piece_of_another_version_is_refused_with_both_versions_and_a_remedy() {
        let piece = Path::new("run/shards/0123.jsonl");
        let refused = |owner: &Owner| owner.refused(piece).to_string();
        assert!(refused(&Owner::new("e")).contains("belongs to another job"));
        for (name, version) in VERSIONS {
            for other in [version - 1, version + 1] {
                let mut owner = Owner::new("e");
                owner.versions.insert(name.to_owned(), other);
                let message = refused(&owner);
                for text in [
                    "run/shards/0123.jsonl was written by another version of stickslip".to_owned(),
                    format!("({name} {other}, where this one has {version})"),
                    "again into another directory with --out".to_owned(),
                ] {
                    assert!(message.contains(&text), "{text:?} is not in: {message}");
                }
            }
        }
    }

    #[test]
    fn unfinished_files_are_not_read() {
        let (directory, _) = written();
        fs::write(directory.path().join(".unfinished-123-x.jsonl"), "half").unwrap();
        assert_eq!(read(&folder(&directory), "experiment").unwrap().0.len(), 50);
        folder(&directory).remove_unfinished().unwrap();
        assert_eq!(files(directory.path()).unwrap().len(), 1);
    }
}
