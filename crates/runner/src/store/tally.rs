//! Which samples of which cell are counted, and their verdicts so far.

use std::cmp::Reverse;
use std::ops::Range;

use stickslip_core::verdict::VerdictCounts;
use stickslip_sampler::estimate::distribution::Distribution;

/// The counted verdicts of consecutive samples of one slot (a cell, or a part of it); what workers hand back and pieces hold.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Segment {
    /// The slot.
    pub slot: u64,
    /// Its samples, counted from 0 in each slot.
    pub samples: Range<u64>,
    /// Their verdicts.
    pub counts: VerdictCounts,
    /// Settled amplitudes of those unstable ones that settled, where the job records them.
    pub amplitudes: Distribution,
    /// Further sums that the job asks for, see [`Extras`](crate::evaluate::extras::Extras).
    pub sums: Vec<i64>,
}

impl Segment {
    /// The number of samples.
    pub fn len(&self) -> u64 {
        self.samples.end - self.samples.start
    }

    /// Whether the counts can belong to the samples.
    pub fn is_consistent(&self) -> bool {
        let amplitudes = self.amplitudes.count();
        self.samples.start < self.samples.end && self.counts.total() == self.len() && amplitudes <= self.counts.unstable
    }
}

/// The state of a run: for each slot the samples counted so far and their verdicts.
#[derive(Debug, Clone)]
pub struct Tally {
    slots: Vec<SlotTally>,
}

#[derive(Debug, Clone, Default)]
struct SlotTally {
    counts: VerdictCounts,
    amplitudes: Distribution,
    sums: Vec<i128>,
    /// Disjoint, sorted, not touching.
    covered: Vec<Range<u64>>,
}

impl SlotTally {
    /// Adds `samples` to the covered ranges; false if some of them are covered already.
    fn cover(&mut self, samples: &Range<u64>) -> bool {
        let after = self.covered.partition_point(|range| range.start < samples.start);
        let overlaps_before = after > 0 && self.covered[after - 1].end > samples.start;
        let overlaps_after = after < self.covered.len() && self.covered[after].start < samples.end;
        if overlaps_before || overlaps_after {
            return false;
        }
        let joins_before = after > 0 && self.covered[after - 1].end == samples.start;
        let joins_after = after < self.covered.len() && self.covered[after].start == samples.end;
        match (joins_before, joins_after) {
            (true, true) => {
                self.covered[after - 1].end = self.covered[after].end;
                self.covered.remove(after);
            }
            (true, false) => self.covered[after - 1].end = samples.end,
            (false, true) => self.covered[after].start = samples.start,
            (false, false) => self.covered.insert(after, samples.clone()),
        }
        true
    }
}

impl Tally {
    /// Nothing counted yet.
    pub fn new(slots: u64) -> Self {
        Self { slots: vec![SlotTally::default(); slots as usize] }
    }

    /// Adds what pieces hold. Segments may come in any order and more than once (a task that a batch system
    /// started twice); samples that are already counted are not counted again.
    ///
    /// # Errors
    /// The slot and the samples of two segments with different verdicts on them: one is wrong, and nothing tells which.
    pub fn add_all(&mut self, mut segments: Vec<Segment>) -> Result<(), (u64, Range<u64>)> {
        segments.sort_by_key(|segment| (segment.slot, segment.samples.start, Reverse(segment.samples.end)));
        for pair in segments.windows(2) {
            let same_samples = pair[0].slot == pair[1].slot && pair[0].samples == pair[1].samples;
            if same_samples && pair[0] != pair[1] {
                return Err((pair[0].slot, pair[0].samples.clone()));
            }
        }
        for segment in &segments {
            self.add(segment);
        }
        Ok(())
    }

    /// Adds one segment, unless some of its samples are counted already.
    pub fn add(&mut self, segment: &Segment) {
        let slot = &mut self.slots[segment.slot as usize];
        if slot.cover(&segment.samples) {
            slot.counts += segment.counts;
            slot.amplitudes.add_all(&segment.amplitudes);
            slot.sums.resize(slot.sums.len().max(segment.sums.len()), 0);
            for (total, &sum) in slot.sums.iter_mut().zip(&segment.sums) {
                *total += i128::from(sum);
            }
        }
    }

    /// The verdicts of one slot.
    pub fn counts(&self, slot: u64) -> VerdictCounts {
        self.slots[slot as usize].counts
    }

    /// The settled amplitudes of one slot.
    pub fn amplitudes(&self, slot: u64) -> &Distribution {
        &self.slots[slot as usize].amplitudes
    }

    /// The further sums of one slot; empty before anything is counted.
    pub fn sums(&self, slot: u64) -> &[i128] {
        &self.slots[slot as usize].sums
    }

    /// Samples counted, over all slots.
    pub fn counted(&self) -> u128 {
        self.slots.iter().map(|slot| u128::from(slot.counts.total())).sum()
    }

    /// Whether the first `samples` samples of a slot are all counted.
    pub fn is_complete(&self, slot: u64, samples: u64) -> bool {
        samples == 0
            || self.slots[slot as usize].covered.first().is_some_and(|first| first.start == 0 && first.end >= samples)
    }

    /// The samples that are not counted yet, by slot, of as many as are wanted of each.
    pub fn gaps(&self, wanted: &[u64]) -> Vec<(u64, Range<u64>)> {
        let mut gaps = Vec::new();
        for ((index, slot), &samples) in self.slots.iter().enumerate().zip(wanted) {
            let mut next = 0;
            for range in &slot.covered {
                if range.start.min(samples) > next {
                    gaps.push((index as u64, next..range.start.min(samples)));
                }
                next = range.end;
            }
            if next < samples {
                gaps.push((index as u64, next..samples));
            }
        }
        gaps
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn segment(slot: u64, samples: Range<u64>) -> Segment {
        let counts = VerdictCounts { unstable: samples.end - samples.start, ..Default::default() };
        Segment { slot, samples, counts, amplitudes: Distribution::default(), sums: vec![1, -2] }
    }

    #[test]
    fn order_and_repetition_do_not_matter() {
        let pieces = [segment(0, 0..10), segment(0, 10..25), segment(1, 5..10), segment(0, 25..30), segment(1, 0..5)];
        for rotation in 0..pieces.len() {
            let mut tally = Tally::new(2);
            let mut order = pieces.to_vec();
            order.rotate_left(rotation);
            order.extend_from_slice(&pieces[rotation..]);
            for piece in &order {
                tally.add(piece);
            }
            assert_eq!((tally.counts(0).unstable, tally.counts(1).unstable), (30, 10));
            assert_eq!([10, 11].map(|samples| tally.is_complete(1, samples)), [true, false]);
            assert!(tally.is_complete(0, 30) && tally.gaps(&[10, 10]).is_empty());
            assert_eq!((tally.sums(0), tally.sums(1)), (&[3, -6][..], &[2, -4][..]));
        }
    }

    #[test]
    fn gaps_are_what_is_missing() {
        let mut tally = Tally::new(3);
        tally.add(&segment(0, 10..20));
        tally.add(&segment(0, 40..50));
        tally.add(&segment(2, 0..100));
        assert_eq!(tally.gaps(&[60; 3]), [(0, 0..10), (0, 20..40), (0, 50..60), (1, 0..60)]);
    }

    #[test]
    fn overlaps_are_not_counted_twice() {
        let mut tally = Tally::new(1);
        tally.add_all(vec![segment(0, 0..10), segment(0, 5..15), segment(0, 0..10), segment(0, 15..20)]).unwrap();
        assert_eq!(tally.counts(0).unstable, 15);
        assert_eq!(tally.gaps(&[20]), [(0, 10..15)]);
    }

    #[test]
    fn disagreement_is_an_error() {
        let wrong = Segment { counts: VerdictCounts { stable: 10, ..Default::default() }, ..segment(0, 0..10) };
        let error = Tally::new(1).add_all(vec![segment(0, 0..10), wrong]).unwrap_err();
        assert_eq!(error, (0, 0..10));
    }
}
