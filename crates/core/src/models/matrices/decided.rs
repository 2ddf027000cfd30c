//! What all eigenvalues of samples have said of every band.
//!
//! Cells that differ by band alone have the same samples. Where all eigenvalues of one are needed for a band, they tell of the
//! others, too, which may need them as well.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hasher};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::decide::RegionSet;

/// Samples that are kept at most, some 100 bytes each. All are given up then: what was not asked for is found again.
const MOST: usize = 1 << 19;

/// The regions in which samples are unstable; none of one whose eigenvalues do not converge.
#[derive(Default)]
pub(super) struct Decided {
    known: Mutex<HashMap<u128, Entry>>,
}

#[derive(Clone, Copy)]
enum Entry {
    /// It is being decided.
    InWork,
    /// What was found, and which bands asked for it.
    Decided(Option<RegionSet>, RegionSet),
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
    decided: &'a Decided,
    key: u128,
    who: RegionSet,
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
        match known.get_mut(&key) {
            Some(Entry::InWork) => Asked::InWork,
            Some(Entry::Decided(unstable, asked)) if *asked & who == 0 => {
                *asked |= who;
                Asked::Decided(*unstable)
            }
            _ => {
                if known.len() >= MOST {
                    known.retain(|_, entry| matches!(entry, Entry::InWork));
                }
                known.insert(key, Entry::InWork);
                Asked::Unknown(Undecided { decided: self, key, who, is_decided: false })
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
        self.decided.lock().insert(self.key, Entry::Decided(unstable, self.who));
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

    #[test]
    fn a_sample_is_decided_once() {
        let decided = Decided::default();
        let one = unknown(&decided, &[1.0, 2.0]);
        assert!(matches!(decided.ask(&[1.0, 2.0], 2), Asked::InWork));
        let other = unknown(&decided, &[2.0, 1.0]);
        assert_eq!(one.decided(Some(5)), Some(5));
        assert_eq!(other.decided(None), None);
        assert!(matches!(decided.ask(&[1.0, 2.0], 2), Asked::Decided(Some(5))));
        assert!(matches!(decided.ask(&[2.0, 1.0], 2), Asked::Decided(None)));
        // All bands together are one that asks; nobody is told twice.
        assert!(matches!(decided.ask(&[1.0, 2.0], 7), Asked::Decided(Some(5))));
        for again in [1, 2, 7] {
            assert!(matches!(decided.ask(&[1.0, 2.0], again), Asked::Unknown(_)), "{again}");
            let _ = unknown(&decided, &[1.0, 2.0]).decided(Some(5));
            assert!(matches!(decided.ask(&[1.0, 2.0], 2), Asked::Decided(Some(5))));
            assert!(matches!(decided.ask(&[1.0, 2.0], 7), Asked::Decided(Some(5))));
        }
        // Where work on it ends before it is decided, another does it.
        drop(unknown(&decided, &[3.0]));
        assert_eq!(unknown(&decided, &[3.0]).decided(Some(0)), Some(0));
    }

    #[test]
    fn no_more_are_kept_than_there_is_room_for_and_work_goes_on() {
        let decided = Decided::default();
        let in_work = unknown(&decided, &[-1.0]);
        for number in 0..=MOST {
            unknown(&decided, &[number as f64]).decided(Some(1));
            assert!(decided.lock().len() <= MOST);
        }
        assert!(matches!(decided.ask(&[-1.0], 2), Asked::InWork));
        in_work.decided(Some(2));
        assert!(matches!(decided.ask(&[-1.0], 2), Asked::Decided(Some(2))));
        assert!(matches!(decided.ask(&[MOST as f64], 2), Asked::Decided(Some(1))));
    }
}
