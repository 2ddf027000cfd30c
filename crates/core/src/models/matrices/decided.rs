//! Decisions on samples that are asked for again with another band.
//!
//! Cells that differ by band alone have the same samples. What decides one tells of every band, and is kept until all have
//! asked.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hasher};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::decide::RegionSet;

/// Samples that are kept at most, some 50 bytes each.
const MOST: usize = 1 << 20;

/// The regions in which samples are unstable; none of one whose eigenvalues do not converge.
pub(super) struct Decided {
    known: Mutex<HashMap<u128, Entry>>,
    /// How often each is asked for after it is decided.
    repeats: u32,
}

enum Entry {
    /// It is being decided.
    InWork,
    Decided {
        unstable: Option<RegionSet>,
        repeats: u32,
    },
}

/// What is known of a sample.
pub(super) enum Asked<'a> {
    /// What was decided.
    Decided(Option<RegionSet>),
    /// Nothing: whoever asks decides it.
    Unknown(Undecided<'a>),
    /// It is being decided for another band.
    InWork,
}

/// A sample that is being decided.
pub(super) struct Undecided<'a> {
    /// Where it is kept, unless there is no room.
    kept: Option<(&'a Decided, u128)>,
}

impl Decided {
    pub(super) fn new(repeats: u32) -> Self {
        Self { known: Mutex::default(), repeats }
    }

    /// What is known of the sample with these coefficients, of a configuration with these expected values.
    pub(super) fn ask(&self, of: [&[f64]; 2]) -> Asked<'_> {
        let key = key(of);
        let mut known = self.lock();
        let is_full = known.len() >= MOST;
        match known.get_mut(&key) {
            None if is_full => Asked::Unknown(Undecided { kept: None }),
            None => {
                known.insert(key, Entry::InWork);
                Asked::Unknown(Undecided { kept: Some((self, key)) })
            }
            Some(Entry::InWork) => Asked::InWork,
            Some(Entry::Decided { unstable, repeats }) => {
                let unstable = *unstable;
                *repeats -= 1;
                if *repeats == 0 {
                    known.remove(&key);
                }
                Asked::Decided(unstable)
            }
        }
    }

    /// What is known, whoever may have left it.
    fn lock(&self) -> MutexGuard<'_, HashMap<u128, Entry>> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Undecided<'_> {
    /// Keeps what was decided.
    pub(super) fn decided(mut self, unstable: Option<RegionSet>) -> Option<RegionSet> {
        if let Some((decided, key)) = self.kept.take() {
            decided.lock().insert(key, Entry::Decided { unstable, repeats: decided.repeats });
        }
        unstable
    }
}

impl Drop for Undecided<'_> {
    /// One that was not decided is unknown again.
    fn drop(&mut self) {
        if let Some((decided, key)) = self.kept.take() {
            decided.lock().remove(&key);
        }
    }
}

/// 128 bits of numbers, by which they are told apart.
fn key(of: [&[f64]; 2]) -> u128 {
    let half = |first: u8| {
        let mut hasher = DefaultHasher::new();
        hasher.write_u8(first);
        of.into_iter().flatten().for_each(|number| hasher.write_u64(number.to_bits()));
        u128::from(hasher.finish())
    };
    half(0) << 64 | half(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unknown<'a>(decided: &'a Decided, of: [&[f64]; 2]) -> Undecided<'a> {
        match decided.ask(of) {
            Asked::Unknown(undecided) => undecided,
            Asked::Decided(_) | Asked::InWork => panic!("it is known"),
        }
    }

    #[test]
    fn a_sample_is_decided_once_and_kept_until_all_have_asked() {
        let decided = Decided::new(2);
        let one = unknown(&decided, [&[0.5], &[1.0, 2.0]]);
        assert!(matches!(decided.ask([&[0.5], &[1.0, 2.0]]), Asked::InWork));
        let other = unknown(&decided, [&[0.5], &[2.0, 1.0]]);
        assert_eq!(one.decided(Some(5)), Some(5));
        assert_eq!(other.decided(None), None);
        for _ in 0..2 {
            assert!(matches!(decided.ask([&[0.5], &[1.0, 2.0]]), Asked::Decided(Some(5))));
            assert!(matches!(decided.ask([&[0.5], &[2.0, 1.0]]), Asked::Decided(None)));
        }
        assert!(decided.lock().is_empty());
        // Where work on it ends before it is decided, another does it.
        drop(unknown(&decided, [&[0.5], &[1.0, 2.0]]));
        let again = unknown(&decided, [&[0.5], &[1.0, 2.0]]);
        assert_eq!(again.decided(Some(0)), Some(0));
    }
}
