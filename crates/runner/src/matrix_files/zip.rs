//! Zip archives as NumPy writes them: stored or deflated members, also with the long numbers of Zip64.

use std::collections::HashSet;
use std::fs::File;
use std::io::{self, BufReader, Read, Take};

use flate2::Crc;
use flate2::bufread::DeflateDecoder;

use super::error::{Problem, quoted};
use super::numbers::{TIGHTEST, ended};
use super::source::Source;

const END: [u8; 4] = *b"PK\x05\x06";
const END_64_PLACE: [u8; 4] = *b"PK\x06\x07";
const END_64: [u8; 4] = *b"PK\x06\x06";
const MEMBER: [u8; 4] = *b"PK\x01\x02";
const LOCAL: [u8; 4] = *b"PK\x03\x04";

/// Length of the end record without its comment, and the longest comment.
const LENGTH_OF_END: u64 = 22;
const LONGEST_COMMENT: u64 = 0xffff;

/// Most members, and most bytes of their list.
const MOST_MEMBERS: usize = 1 << 16;
const LONGEST_LIST: u64 = 1 << 24;

/// A number that stands in Zip64's extra field instead.
const ELSEWHERE: u64 = 0xffff_ffff;

/// A file inside an archive.
pub struct Member {
    pub name: String,
    pub size: u64,
    method: u16,
    flags: u16,
    crc: u32,
    compressed: u64,
    place: u64,
}

/// Little-endian numbers at places of some bytes.
struct Fields<'a>(&'a [u8]);

impl Fields<'_> {
    fn number(&self, place: usize, width: usize) -> Result<u64, Problem> {
        let bytes = self.0.get(place..place + width).ok_or_else(damaged)?;
        Ok(bytes.iter().rev().fold(0, |number, byte| number << 8 | u64::from(*byte)))
    }
}

fn damaged() -> Problem {
    Problem::new("the list of the archive's members is damaged; the file may be cut off")
}

fn bytes_at(source: &mut Source, place: u64, length: u64) -> Result<Vec<u8>, Problem> {
    if place.checked_add(length).is_none_or(|end| end > source.length) || length > LONGEST_LIST {
        return Err(damaged());
    }
    source.seek(place)?;
    let mut bytes = vec![0; length as usize];
    (&source.file).read_exact(&mut bytes).map_err(|error| ended(&error))?;
    Ok(bytes)
}

/// The members of an archive: of several of one name the last, which NumPy reads.
pub fn members(source: &mut Source) -> Result<Vec<Member>, Problem> {
    let length = source.length.min(LENGTH_OF_END + LONGEST_COMMENT);
    let tail_place = source.length - length;
    let tail = bytes_at(source, tail_place, length)?;
    let end = tail.windows(4).rposition(|bytes| bytes == END).ok_or_else(damaged)?;
    let fields = Fields(&tail[end..]);
    let (mut list_length, mut list_place) = (fields.number(12, 4)?, fields.number(16, 4)?);
    let before = (tail_place + end as u64).checked_sub(20);
    if let Some(before) = before {
        let locator = bytes_at(source, before, 20)?;
        if locator.starts_with(&END_64_PLACE) {
            let end = bytes_at(source, Fields(&locator).number(8, 8)?, 56)?;
            if !end.starts_with(&END_64) {
                return Err(damaged());
            }
            (list_length, list_place) = (Fields(&end).number(40, 8)?, Fields(&end).number(48, 8)?);
        }
    }
    let list = bytes_at(source, list_place, list_length)?;
    let mut members = Vec::new();
    let mut rest = &list[..];
    while !rest.is_empty() {
        if members.len() == MOST_MEMBERS {
            return Err(Problem::new(format!("the archive has more than {MOST_MEMBERS} members, the limit")));
        }
        let (member, length) = member(rest)?;
        members.push(member);
        rest = rest.get(length..).ok_or_else(damaged)?;
    }
    let mut names = HashSet::new();
    members.reverse();
    members.retain(|member: &Member| names.insert(member.name.clone()));
    members.reverse();
    Ok(members)
}

/// A member at the start of the list, and the length of its record.
fn member(record: &[u8]) -> Result<(Member, usize), Problem> {
    if !record.starts_with(&MEMBER) {
        return Err(damaged());
    }
    let fields = Fields(record);
    let number = |place, width| fields.number(place, width);
    let [name, extra, comment] = [number(28, 2)?, number(30, 2)?, number(32, 2)?].map(|length| length as usize);
    let name_bytes = record.get(46..46 + name).ok_or_else(damaged)?;
    let mut long = record.get(46 + name..46 + name + extra).ok_or_else(damaged)?;
    let mut sizes = [number(24, 4)?, number(20, 4)?, number(42, 4)?];
    while long.len() >= 4 {
        let (kind, length) = (Fields(long).number(0, 2)?, Fields(long).number(2, 2)? as usize);
        let field = long.get(4..4 + length).ok_or_else(damaged)?;
        if kind == 1 {
            let mut place = 0;
            for size in sizes.iter_mut().filter(|size| **size == ELSEWHERE) {
                *size = Fields(field).number(place, 8)?;
                place += 8;
            }
        }
        long = &long[4 + length..];
    }
    let [size, compressed, place] = sizes;
    let member = Member {
        name: String::from_utf8_lossy(name_bytes).into_owned(),
        size,
        method: number(10, 2)? as u16,
        flags: number(8, 2)? as u16,
        crc: number(16, 4)? as u32,
        compressed,
        place,
    };
    Ok((member, 46 + name + extra + comment))
}

enum Packed<'a> {
    Stored(BufReader<Take<&'a File>>),
    Deflated(DeflateDecoder<BufReader<Take<&'a File>>>),
}

/// The content of a member.
pub struct Content<'a> {
    from: Packed<'a>,
    left: u64,
    crc: Crc,
    expected: u32,
}

impl<'a> Content<'a> {
    /// Opens a member, whose size is compared with the length of the file.
    pub fn open(source: &'a mut Source, member: &Member) -> Result<Self, Problem> {
        let local = bytes_at(source, member.place, 30)?;
        if !local.starts_with(&LOCAL) {
            return Err(damaged());
        }
        if member.flags & 1 != 0 {
            return Err(Problem::new("it is encrypted; save it without a password"));
        }
        let start = member.place + 30 + Fields(&local).number(26, 2)? + Fields(&local).number(28, 2)?;
        if start.checked_add(member.compressed).is_none_or(|end| end > source.length) {
            return Err(Problem::new(format!(
                "it should have {} bytes, which is more than the file has; the file is cut off",
                member.compressed
            )));
        }
        let most = if member.method == 0 { member.compressed } else { member.compressed.saturating_mul(TIGHTEST) };
        if member.size > most {
            let text =
                format!("it should have {} bytes, but can have {most} at most; the file is damaged", member.size);
            return Err(Problem::new(text));
        }
        source.seek(start)?;
        let bytes = BufReader::with_capacity(1 << 16, (&source.file).take(member.compressed));
        let from = match member.method {
            0 => Packed::Stored(bytes),
            8 => Packed::Deflated(DeflateDecoder::new(bytes)),
            other => {
                let text =
                    format!("it is compressed by method {other}; save it with numpy.savez or numpy.savez_compressed");
                return Err(Problem::new(text));
            }
        };
        Ok(Self { from, left: member.size, crc: Crc::new(), expected: member.crc })
    }

    /// Compares the checksum at the end of what is read. What may follow it is not inflated.
    pub fn finish(self) -> Result<(), Problem> {
        if self.left > 0 {
            let text = format!("{} bytes follow the array; the file is damaged", self.left);
            return Err(Problem::new(text));
        }
        if self.crc.sum() != self.expected {
            return Err(Problem::new("its checksum is wrong; the file is damaged"));
        }
        Ok(())
    }
}

impl Read for Content<'_> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let most = (bytes.len() as u64).min(self.left) as usize;
        let read = match &mut self.from {
            Packed::Stored(from) => from.read(&mut bytes[..most])?,
            Packed::Deflated(from) => from.read(&mut bytes[..most])?,
        };
        self.crc.update(&bytes[..read]);
        self.left -= read as u64;
        Ok(read)
    }
}

/// The member of a name.
pub fn find<'a>(members: &'a [Member], name: &str) -> Result<&'a Member, Problem> {
    let missing = || Problem::new(format!("there is no {} in the archive", quoted(name)));
    members.iter().find(|member| member.name == name).ok_or_else(missing)
}
