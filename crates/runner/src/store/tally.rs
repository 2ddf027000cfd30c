//! The samples of a run that are counted so far, and their verdicts.

use std::cmp::Reverse;
use std::ops::Range;

use stickslip_core::verdict::VerdictCounts;
use stickslip_sampler::estimate::distribution::Distribution;

use crate::evaluate::unit::FinishedUnit;

/// The units of a run added up: for each part, which samples are counted, and their verdicts.
#[derive(Debug, Clone)]
pub struct Tally {
    parts: Vec<PartTally>,
}

#[derive(Debug, Clone, Default)]
struct PartTally {
    counts: VerdictCounts,
    amplitudes: Distribution,
    sums: Vec<i128>,
    /// The samples that are counted: sorted ranges with gaps between them.
    covered: Vec<Range<u64>>,
}

impl PartTally {
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
    /// A tally in which nothing is counted.
    pub fn new(parts: u64) -> Self {
        Self { parts: vec![PartTally::default(); parts as usize] }
    }

    /// Adds the units of pieces, in any order. Samples are counted once, even if a unit is there twice because a batch
    /// system started a task twice.
    ///
    /// # Errors
    /// The part and the samples of two units that have different verdicts on the same samples: one of them is wrong.
    pub fn add_all(&mut self, mut units: Vec<FinishedUnit>) -> Result<(), (u64, Range<u64>)> {
        units.sort_by_key(|unit| (unit.part, unit.samples.start, Reverse(unit.samples.end)));
        for pair in units.windows(2) {
            let same_samples = pair[0].part == pair[1].part && pair[0].samples == pair[1].samples;
            if same_samples && pair[0] != pair[1] {
                return Err((pair[0].part, pair[0].samples.clone()));
            }
        }
        for unit in &units {
            self.add(unit);
        }
        Ok(())
    }

    /// Adds one unit, unless some of its samples are counted already.
    pub fn add(&mut self, unit: &FinishedUnit) {
        let part = &mut self.parts[unit.part as usize];
        if part.cover(&unit.samples) {
            part.counts += unit.counts;
            part.amplitudes.add_all(&unit.amplitudes);
            part.sums.resize(part.sums.len().max(unit.sums.len()), 0);
            for (total, &sum) in part.sums.iter_mut().zip(&unit.sums) {
                *total += i128::from(sum);
            }
        }
    }

    /// The verdict counts of one part.
    pub fn counts(&self, part: u64) -> VerdictCounts {
        self.parts[part as usize].counts
    }

    /// The settled amplitudes of one part.
    pub fn amplitudes(&self, part: u64) -> &Distribution {
        &self.parts[part as usize].amplitudes
    }

    /// The further sums of one part; empty before anything is counted.
    pub fn sums(&self, part: u64) -> &[i128] {
        &self.parts[part as usize].sums
    }

    /// The number of samples that are counted, over all parts.
    pub fn counted(&self) -> u128 {
        self.parts.iter().map(|part| u128::from(part.counts.total())).sum()
    }

    /// Whether the first `samples` samples of a part are all counted.
    pub fn is_complete(&self, part: u64, samples: u64) -> bool {
        samples == 0
            || self.parts[part as usize].covered.first().is_some_and(|first| first.start == 0 && first.end >= samples)
    }

    /// Whether a sample of a part is counted.
    pub fn contains(&self, part: u64, sample: u64) -> bool {
        self.parts[part as usize].covered.iter().any(|range| range.contains(&sample))
    }

    /// The samples that are missing, by part, given how many samples of each part are wanted.
    pub fn gaps(&self, wanted: &[u64]) -> Vec<(u64, Range<u64>)> {
        let mut gaps = Vec::new();
        for ((index, part), &samples) in self.parts.iter().enumerate().zip(wanted) {
            let mut next = 0;
            for range in &part.covered {
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

    fn unit(part: u64, samples: Range<u64>) -> FinishedUnit {
        let counts = VerdictCounts { unstable: samples.end - samples.start, ..Default::default() };
        FinishedUnit { part, samples, counts, amplitudes: Distribution::default(), sums: vec![1, -2] }
    }

    #[test]
    fn order_and_repetition_do_not_matter() {
        let pieces = [unit(0, 0..10), unit(0, 10..25), unit(1, 5..10), unit(0, 25..30), unit(1, 0..5)];
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
        tally.add(&unit(0, 10..20));
        tally.add(&unit(0, 40..50));
        tally.add(&unit(2, 0..100));
        assert_eq!(tally.gaps(&[60; 3]), [(0, 0..10), (0, 20..40), (0, 50..60), (1, 0..60)]);
    }

    #[test]
    fn overlaps_are_not_counted_twice() {
        let mut tally = Tally::new(1);
        tally.add_all(vec![unit(0, 0..10), unit(0, 5..15), unit(0, 0..10), unit(0, 15..20)]).unwrap();
        assert_eq!(tally.counts(0).unstable, 15);
        assert_eq!(tally.gaps(&[20]), [(0, 10..15)]);
    }

    #[test]
    fn units_that_disagree_are_an_error() {
        let wrong = FinishedUnit { counts: VerdictCounts { stable: 10, ..Default::default() }, ..unit(0, 0..10) };
        let error = Tally::new(1).add_all(vec![unit(0, 0..10), wrong]).unwrap_err();
        assert_eq!(error, (0, 0..10));
    }
}
