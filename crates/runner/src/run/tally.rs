//! Which samples of which cell are counted, and their verdicts so far.

use std::cmp::Reverse;
use std::ops::Range;

use stickslip_core::VerdictCounts;
use stickslip_sampler::Distribution;

/// The counted verdicts of consecutive samples of one cell; what workers hand back and pieces hold.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Segment {
    /// The cell.
    pub cell: u64,
    /// Its samples.
    pub samples: Range<u64>,
    /// Their verdicts.
    pub counts: VerdictCounts,
    /// Settled amplitudes of those unstable ones that settled, where the job records them.
    pub amplitudes: Distribution,
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

/// The state of a run: for each cell the samples counted so far and their verdicts.
#[derive(Debug, Clone)]
pub struct Tally {
    cells: Vec<CellTally>,
}

#[derive(Debug, Clone, Default)]
struct CellTally {
    counts: VerdictCounts,
    amplitudes: Distribution,
    /// Disjoint, sorted, not touching.
    covered: Vec<Range<u64>>,
}

impl CellTally {
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
    pub fn new(cells: u64) -> Self {
        Self { cells: vec![CellTally::default(); cells as usize] }
    }

    /// Adds what pieces hold. Segments may come in any order and more than once (a task that a batch system
    /// started twice); samples that are already counted are not counted again.
    ///
    /// # Errors
    /// Two segments over the same samples with different verdicts: one of them is wrong, and nothing tells which.
    pub fn add_all(&mut self, mut segments: Vec<Segment>) -> Result<(), String> {
        segments.sort_by_key(|segment| (segment.cell, segment.samples.start, Reverse(segment.samples.end)));
        for pair in segments.windows(2) {
            let same_samples = pair[0].cell == pair[1].cell && pair[0].samples == pair[1].samples;
            if same_samples && (&pair[0].counts, &pair[0].amplitudes) != (&pair[1].counts, &pair[1].amplitudes) {
                return Err(format!(
                    "two pieces disagree on samples {} to {} of cell {}",
                    pair[0].samples.start,
                    pair[0].samples.end - 1,
                    pair[0].cell
                ));
            }
        }
        for segment in &segments {
            self.add(segment);
        }
        Ok(())
    }

    /// Adds one segment, unless some of its samples are counted already.
    pub fn add(&mut self, segment: &Segment) {
        let cell = &mut self.cells[segment.cell as usize];
        if cell.cover(&segment.samples) {
            cell.counts += segment.counts;
            cell.amplitudes.add_all(&segment.amplitudes);
        }
    }

    /// The verdicts of one cell.
    pub fn counts(&self, cell: u64) -> VerdictCounts {
        self.cells[cell as usize].counts
    }

    /// The settled amplitudes of one cell.
    pub fn amplitudes(&self, cell: u64) -> &Distribution {
        &self.cells[cell as usize].amplitudes
    }

    /// Samples counted, over all cells.
    pub fn counted(&self) -> u128 {
        self.cells.iter().map(|cell| u128::from(cell.counts.total())).sum()
    }

    /// Cells whose first `samples` samples are all counted.
    pub fn complete_cells(&self, samples: u64) -> u64 {
        let complete =
            |cell: &&CellTally| cell.covered.first().is_some_and(|first| first.start == 0 && first.end >= samples);
        self.cells.iter().filter(complete).count() as u64
    }

    /// The samples below `samples` that are not counted yet, by cell.
    pub fn gaps(&self, samples: u64) -> Vec<(u64, Range<u64>)> {
        let mut gaps = Vec::new();
        for (index, cell) in self.cells.iter().enumerate() {
            let mut next = 0;
            for range in &cell.covered {
                if range.start > next {
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

    fn segment(cell: u64, samples: Range<u64>) -> Segment {
        let counts = VerdictCounts { unstable: samples.end - samples.start, ..Default::default() };
        Segment { cell, samples, counts, amplitudes: Distribution::default() }
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
            assert_eq!(tally.complete_cells(10), 2);
            assert_eq!(tally.complete_cells(11), 1);
            assert!(tally.gaps(10).is_empty());
        }
    }

    #[test]
    fn gaps_are_what_is_missing() {
        let mut tally = Tally::new(3);
        tally.add(&segment(0, 10..20));
        tally.add(&segment(0, 40..50));
        tally.add(&segment(2, 0..100));
        assert_eq!(tally.gaps(60), [(0, 0..10), (0, 20..40), (0, 50..60), (1, 0..60)]);
    }

    #[test]
    fn overlaps_are_not_counted_twice() {
        let mut tally = Tally::new(1);
        tally.add_all(vec![segment(0, 0..10), segment(0, 5..15), segment(0, 0..10), segment(0, 15..20)]).unwrap();
        assert_eq!(tally.counts(0).unstable, 15);
        assert_eq!(tally.gaps(20), [(0, 10..15)]);
    }

    #[test]
    fn disagreement_is_an_error() {
        let wrong = Segment { counts: VerdictCounts { stable: 10, ..Default::default() }, ..segment(0, 0..10) };
        let error = Tally::new(1).add_all(vec![segment(0, 0..10), wrong]).unwrap_err();
        assert_eq!(error, "two pieces disagree on samples 0 to 9 of cell 0");
    }
}
