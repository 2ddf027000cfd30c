//! What was found of samples in each band.
//!
//! Cells that differ by band alone have the same samples. What is found of one for a band may tell of others, which will ask for it,
//! and the chance of squeal in any band is that of all of them.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hasher};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::decide::RegionSet;

/// Samples that are kept at most, some 100 bytes each. All are given up then: what was not asked for is found again.
const MOST: usize = 1 << 19;

/// What is found of a sample.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Found {
    /// The regions that were looked at.
    pub(super) known: RegionSet,
    /// Those of them in which it is unstable.
    pub(super) unstable: RegionSet,
}

/// What is known of samples.
#[derive(Default)]
pub(super) struct Decided {
    known: Mutex<HashMap<u128, Entry>>,
}

#[derive(Clone, Copy)]
enum Entry {
    /// It is being decided.
    InWork,
    /// What was found, and which bands asked for it.
    Decided(Found, RegionSet),
}

/// What is known of a sample.
pub(super) enum Asked<'a> {
    /// The regions in which it is unstable.
    Decided(RegionSet),
    /// Too little: whoever asks decides the rest.
    Unknown(Undecided<'a>),
    /// It is being decided for another band.
    InWork,
}

/// A sample that is being decided.
pub(super) struct Undecided<'a> {
    decided: &'a Decided,
    key: u128,
    /// What was known of it, and who asked for it.
    before: Found,
    asked: RegionSet,
    is_decided: bool,
}

impl Decided {
    /// What is known of the sample with these coefficients, for some bands. Who asks again decides it again, so that samples which
    /// are tried several times to measure what they cost take their time.
    pub(super) fn ask(&self, coefficients: &[f64], bands: RegionSet) -> Asked<'_> {
        let key = key(coefficients);
        let mut known = self.lock();
        // Those of one band alone ask for it, those of several for all.
        let who = if bands.is_power_of_two() { bands } else { 1 << (RegionSet::BITS - 1) };
        let (before, asked) = match known.get(&key) {
            Some(Entry::InWork) => return Asked::InWork,
            Some(&Entry::Decided(found, asked)) if asked & who == 0 => (found, asked | who),
            _ => (Found::default(), who),
        };
        if bands & !before.known == 0 {
            known.insert(key, Entry::Decided(before, asked));
            return Asked::Decided(before.unstable);
        }
        if known.len() >= MOST {
            known.retain(|_, entry| matches!(entry, Entry::InWork));
        }
        known.insert(key, Entry::InWork);
        Asked::Unknown(Undecided { decided: self, key, before, asked, is_decided: false })
    }

    /// What is known, whoever may have left it.
    fn lock(&self) -> MutexGuard<'_, HashMap<u128, Entry>> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Undecided<'_> {
    /// The regions that were looked at before.
    pub(super) fn known(&self) -> RegionSet {
        self.before.known
    }

    /// Keeps what was found beside that, and gives all regions in which the sample is unstable.
    pub(super) fn decided(mut self, found: Found) -> RegionSet {
        let known = self.before.known | found.known;
        let unstable = self.before.unstable | found.unstable;
        self.decided.lock().insert(self.key, Entry::Decided(Found { known, unstable }, self.asked));
        self.is_decided = true;
        unstable
    }
}

impl Drop for Undecided<'_> {
    /// One that was not decided is unknown again.
    fn drop(&mut self) {
        if !self.is_decided {
            self.decided.lock().remove(&self.key);
        }
    }
}

/// 128 bits of numbers, by which they are told apart.
fn key(numbers: &[f64]) -> u128 {
    let half = |first: u8| {
        let mut hasher = DefaultHasher::new();
        hasher.write_u8(first);
        numbers.iter().for_each(|number| hasher.write_u64(number.to_bits()));
        u128::from(hasher.finish())
    };
    half(0) << 64 | half(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unknown<'a>(decided: &'a Decided, coefficients: &[f64]) -> Undecided<'a> {
        match decided.ask(coefficients, 1) {
            Asked::Unknown(undecided) => undecided,
            Asked::Decided(_) | Asked::InWork => panic!("it is known"),
        }
    }

    /// Unstable in these regions, where all were looked at.
    fn all(unstable: RegionSet) -> Found {
        Found { known: RegionSet::MAX, unstable }
    }

    #[test]
    fn a_sample_is_decided_once() {
        let decided = Decided::default();
        let one = unknown(&decided, &[1.0, 2.0]);
        assert!(matches!(decided.ask(&[1.0, 2.0], 2), Asked::InWork));
        let other = unknown(&decided, &[2.0, 1.0]);
        assert_eq!(one.decided(all(5)), 5);
        assert_eq!(other.decided(all(0)), 0);
        assert!(matches!(decided.ask(&[1.0, 2.0], 2), Asked::Decided(5)));
        assert!(matches!(decided.ask(&[2.0, 1.0], 2), Asked::Decided(0)));
        // All bands together are one that asks; nobody is told twice.
        assert!(matches!(decided.ask(&[1.0, 2.0], 7), Asked::Decided(5)));
        for again in [1, 2, 7] {
            assert!(matches!(decided.ask(&[1.0, 2.0], again), Asked::Unknown(_)), "{again}");
            let _ = unknown(&decided, &[1.0, 2.0]).decided(all(5));
            assert!(matches!(decided.ask(&[1.0, 2.0], 2), Asked::Decided(5)));
            assert!(matches!(decided.ask(&[1.0, 2.0], 7), Asked::Decided(5)));
        }
        // Where work on it ends before it is decided, another does it.
        drop(unknown(&decided, &[3.0]));
        assert_eq!(unknown(&decided, &[3.0]).decided(all(0)), 0);
    }

    #[test]
    fn a_band_that_was_not_looked_at_is_left() {
        let decided = Decided::default();
        let ask = |bands: RegionSet| match decided.ask(&[1.0], bands) {
            Asked::Unknown(undecided) => undecided,
            Asked::Decided(_) | Asked::InWork => panic!("{bands} are known"),
        };
        let first = ask(1);
        assert_eq!((first.known(), first.decided(Found { known: 1, unstable: 1 })), (0, 1));
        let second = ask(2);
        assert_eq!((second.known(), second.decided(Found { known: 2, unstable: 0 })), (1, 1));
        let rest = ask(7);
        assert_eq!((rest.known(), rest.decided(Found { known: 4, unstable: 4 })), (3, 5));
        assert!(matches!(decided.ask(&[1.0], 4), Asked::Decided(5)));
        // Who asks again decides all again.
        for again in [1, 2, 4, 7] {
            assert_eq!(ask(again).known(), 0);
            let _ = ask(8).decided(all(5));
            for other in [1, 2, 4, 7] {
                assert!(matches!(decided.ask(&[1.0], other), Asked::Decided(5)), "{other}");
            }
        }
    }

    #[test]
    fn no_more_are_kept_than_there_is_room_for_and_work_goes_on() {
        let decided = Decided::default();
        let in_work = unknown(&decided, &[-1.0]);
        for number in 0..=MOST {
            unknown(&decided, &[number as f64]).decided(all(1));
            assert!(decided.lock().len() <= MOST);
        }
        assert!(matches!(decided.ask(&[-1.0], 2), Asked::InWork));
        in_work.decided(all(2));
        assert!(matches!(decided.ask(&[-1.0], 2), Asked::Decided(2)));
        assert!(matches!(decided.ask(&[MOST as f64], 2), Asked::Decided(1)));
    }
}
