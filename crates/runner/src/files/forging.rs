//! Forged files for tests: sound ones with bytes changed, as nothing in them says who wrote them.

use std::env;
use std::fs::{self, File};
use std::io::Write as _;
use std::panic::{self, AssertUnwindSafe};
use std::process::Command;
use std::time::Duration;

/// Set in the process that reads forged files.
const READER: &str = "STICKSLIP_READS_FORGED_FILES";

/// Most memory that reading one of them may use.
const MOST_MEMORY: u64 = 1 << 28;

/// Longest time on a processor for one of them, whatever else is at work.
const LONGEST: Duration = Duration::from_secs(10);

/// Numbers that look random, from a seed (SplitMix64).
pub struct Numbers(pub u64);

impl Numbers {
    /// A number below `end`.
    pub fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % end.max(1) as u64) as usize
    }
}

/// Asserts that `read` takes every forged file, of which `count` are made from sound ones, without a panic, without much
/// memory and in short time. That is done in a process of its own, which runs the test `name` alone.
#[track_caller]
pub fn assert_bounded(name: &str, sound: &[Vec<u8>], count: usize, read: impl Fn(Vec<u8>) -> Result<(), String>) {
    let refused = assert_bounded_of(name, sound, count, forged, read);
    assert!(
        refused.is_none_or(|refused| refused > count / 2),
        "only {refused:?} of {count} were refused: the files are hardly changed"
    );
}

/// The same of files that `forged` makes from sound ones. Returns how many were refused, in the process that reads them.
#[track_caller]
pub fn assert_bounded_of(
    name: &str,
    sound: &[Vec<u8>],
    count: usize,
    forged: impl Fn(&[u8], &mut Numbers) -> Vec<u8>,
    read: impl Fn(Vec<u8>) -> Result<(), String>,
) -> Option<usize> {
    if env::var_os(READER).is_none() {
        let mut child = Command::new(env::current_exe().unwrap());
        let output = child.args(["--exact", name, "--test-threads=1"]).env(READER, "1").output().unwrap();
        let [stdout, stderr] = [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes));
        assert!(output.status.success() && stdout.contains("1 passed"), "{stdout}{stderr}");
        return None;
    }
    sound.iter().for_each(|bytes| read(bytes.clone()).unwrap());
    let mut numbers = Numbers(2018);
    let mut refused = 0;
    for case in 0..count {
        let bytes = forged(&sound[case % sound.len()], &mut numbers);
        let (started, before) = (time(), peak());
        let result = panic::catch_unwind(AssertUnwindSafe(|| read(bytes)));
        refused += usize::from(result.unwrap_or_else(|_| panic!("case {case} panicked")).is_err());
        // The system counts pages roughly: the most may be a few less than it was.
        let (took, memory) = (time() - started, peak().saturating_sub(before));
        assert!(memory <= MOST_MEMORY && took <= LONGEST, "case {case}: {memory} bytes, {took:?}");
    }
    Some(refused)
}

/// The time that this thread has had on a processor, as others may be busy; where the system does not say, none.
pub fn time() -> Duration {
    let times = fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    Duration::from_nanos(times.split_whitespace().next().map_or(0, |nanoseconds| nanoseconds.parse().unwrap()))
}

/// The most memory that this process has used, in bytes; 0 where the system does not say.
fn peak() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.map_or(0, |line| line.trim().trim_end_matches(" kB").parse::<u64>().unwrap() << 10)
}

/// A file without a name that holds some bytes.
pub fn file_of(bytes: &[u8]) -> File {
    let mut file = tempfile::tempfile().unwrap();
    file.write_all(bytes).unwrap();
    file
}

/// A file with a few of its bytes changed, those of Parquet mostly in their description.
fn forged(sound: &[u8], numbers: &mut Numbers) -> Vec<u8> {
    let mut bytes = sound.to_vec();
    let tail = bytes.len() - 8;
    let described = u32::from_le_bytes(bytes[tail..tail + 4].try_into().unwrap()) as usize;
    let description = tail - described.min(tail)..tail;
    for _ in 0..=numbers.below(3) {
        let at = match numbers.below(8) {
            0 => numbers.below(bytes.len()),
            1..=3 => numbers.below(description.start),
            _ => description.start + numbers.below(description.len()),
        };
        match numbers.below(8) {
            0 => bytes[at] = numbers.below(256) as u8,
            1 => bytes[at] ^= 1 << numbers.below(8),
            2 => bytes[at] = [0, 0x7f, 0x80, 0xff][numbers.below(4)],
            // A large number of several bytes, as Thrift writes it.
            3 => {
                let long = 2 + numbers.below(9);
                bytes.iter_mut().skip(at).take(long).for_each(|byte| *byte = 0xff);
                bytes.iter_mut().skip(at + long).take(1).for_each(|byte| *byte = 0x0f);
            }
            // A list of many elements.
            4 => {
                let list = [0xfc, 0xff, 0xff, 0xff, 0xff, 0x07];
                bytes.iter_mut().skip(at).zip(list).for_each(|(byte, new)| *byte = new);
            }
            5 => bytes[at] = bytes[at].wrapping_add(1),
            6 => bytes[at] = bytes[at].wrapping_sub(1),
            _ => {
                let from = numbers.below(sound.len());
                let length = numbers.below(16).min(sound.len() - from).min(sound.len() - at);
                bytes[at..at + length].copy_from_slice(&sound[from..from + length]);
            }
        }
    }
    bytes
}
