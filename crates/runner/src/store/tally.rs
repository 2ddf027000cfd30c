//! The samples of a run that are counted so far, and their verdicts.

use std::collections::BTreeMap;
use std::ops::Range;

use stickslip_core::model::verdict::VerdictCounts;

use crate::evaluate::parts::Parts;
use crate::evaluate::randomised::CountedPart;
use crate::evaluate::unit::{FinishedUnit, Recorded, add_recorded};
use crate::store::covered::Covered;

/// The units of a run added up: for each part, which samples are counted, and their verdicts.
///
/// A part takes 40 bytes, and 8 for each sum that the job has. Those of which nothing is counted take nothing as long as
/// it is so in many cells that follow each other: memory that is never written is not there.
#[derive(Debug, Clone)]
pub struct Tally {
    parts: Parts,
    /// For each part, how many of its samples are stable, unstable, undecided and failed.
    counts: Vec<[u64; 4]>,
    covered: Covered,
    /// The number of samples that are counted, over all parts.
    counted: u128,
    /// The number of sums of each part; 0 before any are added.
    sums_of_a_part: usize,
    /// The sums of all parts.
    sums: Vec<i64>,
    /// What has to be added to sums beyond the range of these.
    beyond: BTreeMap<usize, i128>,
    /// What is recorded of the parts that have any of it.
    recorded: BTreeMap<usize, Recorded>,
}

impl Tally {
    /// A tally in which nothing is counted.
    pub fn new(parts: &Parts) -> Self {
        let count = parts.count() as usize;
        Self {
            parts: parts.clone(),
            counts: vec![[0; 4]; count],
            covered: Covered::none_of(count, parts.unit_samples()),
            counted: 0,
            sums_of_a_part: 0,
            sums: Vec::new(),
            beyond: BTreeMap::new(),
            recorded: BTreeMap::new(),
        }
    }

    /// Where a part is kept, and the largest number of its samples. Parts at the same place in their cells follow each
    /// other: with looks, cells often stop before the last ones.
    fn locate(&self, part: u64) -> (usize, u64) {
        let (cell, place) = self.parts.place(part);
        ((place as u64 * self.parts.cells() + cell) as usize, self.parts.max_samples(place))
    }

    /// Adds one unit; false if some of its samples are counted already, and nothing is added.
    pub fn add(&mut self, unit: &FinishedUnit) -> bool {
        let (index, most) = self.locate(unit.part);
        if !self.covered.cover(index, most, &unit.samples) {
            return false;
        }
        self.counted += u128::from(unit.counts.total());
        let VerdictCounts { stable, unstable, undecided, failed } = unit.counts;
        for (total, count) in self.counts[index].iter_mut().zip([stable, unstable, undecided, failed]) {
            *total += count;
        }
        if unit.recorded != Recorded::default() {
            add_recorded(self.recorded.entry(index).or_default(), &unit.recorded);
        }
        if self.sums.is_empty() {
            self.sums_of_a_part = unit.sums.len();
            self.sums = vec![0; self.sums_of_a_part * self.counts.len()];
        }
        for (place, &sum) in (index * self.sums_of_a_part..).zip(&unit.sums) {
            let total = &mut self.sums[place];
            match total.checked_add(sum) {
                Some(more) => *total = more,
                None => *self.beyond.entry(place).or_default() += i128::from(std::mem::take(total)) + i128::from(sum),
            }
        }
        true
    }

    /// Whether just the samples of `unit` are counted of its part, with the same results.
    pub fn has_just(&self, unit: &FinishedUnit) -> bool {
        let (index, most) = self.locate(unit.part);
        let sums = unit.sums.iter().map(|&sum| i128::from(sum));
        self.counts(unit.part) == unit.counts
            && self.covered.ranges(index, most) == [unit.samples.clone()]
            && self.sums(unit.part).into_iter().eq(sums)
            && self.recorded(unit.part).unwrap_or(&Recorded::default()) == &unit.recorded
    }

    /// Takes away what is counted of a part.
    pub fn clear(&mut self, part: u64) {
        let (index, _) = self.locate(part);
        self.counted -= self.counts[index].iter().map(|&count| u128::from(count)).sum::<u128>();
        self.counts[index] = [0; 4];
        self.covered.clear(index);
        self.recorded.remove(&index);
        for place in index * self.sums_of_a_part..(index + 1) * self.sums_of_a_part {
            self.sums[place] = 0;
            self.beyond.remove(&place);
        }
    }

    /// The verdict counts of one part.
    pub fn counts(&self, part: u64) -> VerdictCounts {
        let [stable, unstable, undecided, failed] = self.counts[self.locate(part).0];
        VerdictCounts { stable, unstable, undecided, failed }
    }

    /// What is counted of some parts.
    pub fn counted_parts(&self, parts: impl Iterator<Item = u64>) -> Vec<CountedPart> {
        parts.map(|part| CountedPart { counts: self.counts(part), sums: self.sums(part) }).collect()
    }

    /// What is recorded of one part; `None` if nothing is.
    pub fn recorded(&self, part: u64) -> Option<&Recorded> {
        self.recorded.get(&self.locate(part).0)
    }

    /// The further sums of one part; empty before anything is counted.
    pub fn sums(&self, part: u64) -> Vec<i128> {
        let (index, most) = self.locate(part);
        if self.counts[index] == [0; 4] && self.covered.ranges(index, most).is_empty() {
            return Vec::new();
        }
        let places = index * self.sums_of_a_part..(index + 1) * self.sums_of_a_part;
        let beyond = |place: usize| if self.beyond.is_empty() { None } else { self.beyond.get(&place) };
        places.map(|place| i128::from(self.sums[place]) + beyond(place).copied().unwrap_or(0)).collect()
    }

    /// The number of samples that are counted, over all parts.
    pub fn counted(&self) -> u128 {
        self.counted
    }

    /// Whether the first `samples` samples of a part are all counted.
    pub fn is_complete(&self, part: u64, samples: u64) -> bool {
        let (index, most) = self.locate(part);
        self.covered.end(index, most) >= samples
    }

    /// Whether a sample of a part is counted.
    pub fn contains(&self, part: u64, sample: u64) -> bool {
        let (index, most) = self.locate(part);
        self.covered.ranges(index, most).iter().any(|range| range.contains(&sample))
    }

    /// Those of the first `samples` samples of a part that are missing.
    pub fn gaps(&self, part: u64, samples: u64) -> Vec<Range<u64>> {
        let (index, most) = self.locate(part);
        self.covered.gaps(index, most, samples)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::slice::from_ref;
    use stickslip_core::model::recorded::MOST_RECORDED;
    use stickslip_sampler::estimate::distribution::Distribution;

    fn unit(part: u64, samples: Range<u64>) -> FinishedUnit {
        let counts = VerdictCounts { unstable: samples.end - samples.start, ..Default::default() };
        FinishedUnit { part, samples, counts, recorded: Recorded::default(), sums: vec![1, -2] }
    }

    #[test]
    fn order_and_repetition_do_not_matter() {
        let pieces = [unit(0, 0..10), unit(0, 10..25), unit(1, 5..10), unit(0, 25..30), unit(1, 0..5)];
        for rotation in 0..pieces.len() {
            let mut tally = Tally::new(&Parts::plain(2, 30));
            let mut order = pieces.to_vec();
            order.rotate_left(rotation);
            order.extend_from_slice(&pieces[rotation..]);
            for piece in &order {
                tally.add(piece);
            }
            assert_eq!((tally.counts(0).unstable, tally.counts(1).unstable), (30, 10));
            assert_eq!([10, 11].map(|samples| tally.is_complete(1, samples)), [true, false]);
            assert!(tally.is_complete(0, 30) && tally.gaps(0, 10).is_empty());
            assert_eq!((tally.sums(0), tally.sums(1)), (vec![3, -6], vec![2, -4]));
        }
    }

    #[test]
    fn gaps_are_what_is_missing() {
        let mut tally = Tally::new(&Parts::plain(3, 100));
        tally.add(&unit(0, 10..20));
        tally.add(&unit(0, 40..50));
        tally.add(&unit(2, 0..100));
        assert_eq!(
            [0, 1, 2].map(|part| tally.gaps(part, 60)),
            [vec![0..10, 20..40, 50..60], from_ref(&(0..60)).to_vec(), Vec::new()]
        );
        assert!(tally.sums(1).is_empty() && tally.contains(0, 19) && !tally.contains(0, 20));
    }

    #[test]
    fn sums_go_beyond_those_of_units() {
        let mut tally = Tally::new(&Parts::plain(2, 100));
        for sample in 0..3 {
            tally.add(&FinishedUnit { sums: vec![i64::MAX, i64::MIN], ..unit(1, sample..sample + 1) });
        }
        let three = |sum: i64| 3 * i128::from(sum);
        assert_eq!(tally.sums(1), [three(i64::MAX), three(i64::MIN)]);
        tally.clear(1);
        tally.add(&unit(1, 0..100));
        assert_eq!(tally.sums(1), [1, -2]);
    }

    #[test]
    fn a_part_that_was_cleared_is_counted_anew() {
        let recorded = [(); MOST_RECORDED].map(|()| Distribution::from_parts(7, [(3, 4)]));
        let whole = FinishedUnit { recorded, ..unit(0, 0..10) };
        let mut tally = Tally::new(&Parts::plain(1, 10));
        assert!(tally.add(&whole) && tally.has_just(&whole) && !tally.add(&unit(0, 9..10)));
        for other in [
            unit(0, 0..10),
            unit(0, 0..9),
            FinishedUnit { sums: vec![1, 2], ..whole.clone() },
            FinishedUnit { counts: VerdictCounts { stable: 10, ..Default::default() }, ..whole.clone() },
        ] {
            assert!(!tally.has_just(&other), "{other:?}");
        }
        tally.clear(0);
        assert!(tally.counted() == 0 && tally.recorded(0).is_none() && tally.gaps(0, 10) == from_ref(&(0..10)));
        assert!(tally.add(&unit(0, 0..10)) && tally.has_just(&unit(0, 0..10)));
    }
}
