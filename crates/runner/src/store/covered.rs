//! Which samples of the parts of a job are counted, in eight bytes for most parts.

use std::collections::BTreeMap;
use std::ops::Range;

/// Most units of a part that a word distinguishes.
const MOST_UNITS: u64 = 64;

/// The samples that are counted, by the number of the part. Parts that nothing is known of take no memory, as long as
/// their neighbours are not touched either.
#[derive(Debug, Clone)]
pub struct Covered {
    /// Largest number of samples in a unit of work. Units start at multiples of it.
    unit_samples: u64,
    /// For each part, what its word says: if it has few units, which of them are covered as a whole; otherwise up to
    /// which sample all are covered.
    words: Vec<u64>,
    /// The parts of which a word cannot say what is covered: sorted ranges with gaps between them.
    ranges: BTreeMap<usize, Vec<Range<u64>>>,
}

impl Covered {
    /// Nothing covered of so many parts, which are computed in units of so many samples.
    pub fn none_of(parts: usize, unit_samples: u64) -> Self {
        Self { unit_samples, words: vec![0; parts], ranges: BTreeMap::new() }
    }

    /// Adds `samples` to those that are covered of a part, which has at most `most`; false if some of them are covered
    /// already.
    pub fn cover(&mut self, part: usize, most: u64, samples: &Range<u64>) -> bool {
        let is_first = self.words[part] == 0 && !self.ranges.contains_key(&part);
        if is_first && let Some(word) = self.word(std::slice::from_ref(samples), most) {
            self.words[part] = word;
            return true;
        }
        let mut ranges = self.ranges(part, most);
        if !insert(&mut ranges, samples) {
            return false;
        }
        if let Some(word) = self.word(&ranges, most) {
            self.words[part] = word;
            self.ranges.remove(&part);
        } else {
            self.words[part] = 0;
            self.ranges.insert(part, ranges);
        }
        true
    }

    /// Takes away what is covered of a part.
    pub fn clear(&mut self, part: usize) {
        self.words[part] = 0;
        self.ranges.remove(&part);
    }

    /// What is covered of a part of at most `most` samples: sorted ranges with gaps between them.
    pub fn ranges(&self, part: usize, most: u64) -> Vec<Range<u64>> {
        if let Some(ranges) = self.ranges.get(&part) {
            return ranges.clone();
        }
        let mut word = self.words[part];
        let (mut ranges, mut unit) = (Vec::new(), 0);
        if word > 0 && !self.has_few_units(most) {
            ranges.push(0..word);
            return ranges;
        }
        while word != 0 {
            let (gap, length) = (word.trailing_zeros(), (word >> word.trailing_zeros()).trailing_ones());
            let (first, end) = (unit + u64::from(gap), unit + u64::from(gap + length));
            ranges.push(first * self.unit_samples..most.min(end * self.unit_samples));
            word = word.checked_shr(gap + length).unwrap_or(0);
            unit = end;
        }
        ranges
    }

    /// Up to which sample all are covered of a part of at most `most`; 0 if its first sample is not.
    pub fn end(&self, part: usize, most: u64) -> u64 {
        if let Some(ranges) = self.ranges.get(&part) {
            return ranges.first().filter(|first| first.start == 0).map_or(0, |first| first.end);
        }
        match self.words[part] {
            word if self.has_few_units(most) => most.min(u64::from(word.trailing_ones()) * self.unit_samples),
            word => word,
        }
    }

    /// The first `samples` samples of a part but for those that are covered.
    pub fn gaps(&self, part: usize, most: u64, samples: u64) -> Vec<Range<u64>> {
        let mut next = self.end(part, most);
        let mut gaps = Vec::new();
        if next >= samples {
            return gaps;
        }
        for range in self.ranges(part, most) {
            if range.start.min(samples) > next {
                gaps.push(next..range.start.min(samples));
            }
            next = range.end;
        }
        if next < samples {
            gaps.push(next..samples);
        }
        gaps
    }

    fn has_few_units(&self, most: u64) -> bool {
        most.div_ceil(self.unit_samples) <= MOST_UNITS
    }

    /// The word that says that just these samples are covered, of at most `most`; `None` if no word can.
    fn word(&self, ranges: &[Range<u64>], most: u64) -> Option<u64> {
        if !self.has_few_units(most) {
            return match ranges {
                [] => Some(0),
                [only] if only.start == 0 => Some(only.end),
                _ => None,
            };
        }
        let unit = self.unit_samples;
        ranges.iter().try_fold(0, |word, range| {
            let ends_a_unit = range.end == most || range.end.is_multiple_of(unit) && range.end < most;
            let units = || range.start / unit..range.end.div_ceil(unit);
            (range.start.is_multiple_of(unit) && ends_a_unit).then(|| units().fold(word, |word, i| word | 1 << i))
        })
    }
}

/// Adds `samples` to sorted ranges with gaps between them; false if they contain some of them already.
fn insert(ranges: &mut Vec<Range<u64>>, samples: &Range<u64>) -> bool {
    let after = ranges.partition_point(|range| range.start < samples.start);
    let overlaps_before = after > 0 && ranges[after - 1].end > samples.start;
    let overlaps_after = after < ranges.len() && ranges[after].start < samples.end;
    if overlaps_before || overlaps_after {
        return false;
    }
    let joins_before = after > 0 && ranges[after - 1].end == samples.start;
    let joins_after = after < ranges.len() && ranges[after].start == samples.end;
    match (joins_before, joins_after) {
        (true, true) => {
            ranges[after - 1].end = ranges[after].end;
            ranges.remove(after);
        }
        (true, false) => ranges[after - 1].end = samples.end,
        (false, true) => ranges[after].start = samples.start,
        (false, false) => ranges.insert(after, samples.clone()),
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::slice::from_ref;

    /// Samples that are covered one after the other, of parts with few and with many units.
    const STEPS: [(Range<u64>, bool); 9] = [
        (20..30, true),
        (0..10, true),
        (25..26, false),
        (12..15, true),
        (10..12, true),
        (9..12, false),
        (15..20, true),
        (60..64, true),
        (30..60, true),
    ];

    #[test]
    fn every_way_to_hold_ranges_is_the_same() {
        for (unit, most) in [(10, 64), (10, 640), (10, 1000), (1, 64), (1, 65), (1000, 64)] {
            let mut covered = Covered::none_of(3, unit);
            let mut samples = [false; 64];
            for (range, is_new) in STEPS {
                assert_eq!(covered.cover(1, most, &range), is_new, "{range:?} of {most} in units of {unit}");
                if is_new {
                    range.for_each(|sample| samples[sample as usize] = true);
                }
                let listed: Vec<u64> = covered.ranges(1, most).into_iter().flatten().collect();
                let expected: Vec<u64> = (0..64).filter(|&sample| samples[sample as usize]).collect();
                assert_eq!(listed, expected, "of {most} in units of {unit}");
                let end = samples.iter().position(|is_covered| !is_covered).unwrap_or(64) as u64;
                assert_eq!(covered.end(1, most), end);
                let missing: Vec<u64> = covered.gaps(1, most, 40).into_iter().flatten().collect();
                assert_eq!(missing, (0..40).filter(|&sample| !samples[sample as usize]).collect::<Vec<_>>());
            }
            assert_eq!(covered.ranges(1, most), from_ref(&(0..64)));
            assert!(covered.ranges(0, most).is_empty() && covered.gaps(2, most, 5) == from_ref(&(0..5)));
            covered.clear(1);
            assert_eq!((covered.ranges(1, most), covered.end(1, most)), (Vec::new(), 0));
        }
    }

    #[test]
    fn whole_units_take_no_list() {
        let mut covered = Covered::none_of(1, 1000);
        for unit in [7, 3, 0, 63, 1] {
            assert!(covered.cover(0, 63_500, &(1000 * unit..63_500.min(1000 * unit + 1000))));
            assert!(covered.ranges.is_empty());
        }
        assert_eq!(covered.ranges(0, 63_500), [0..2000, 3000..4000, 7000..8000, 63_000..63_500]);
        assert!(covered.cover(0, 63_500, &(2000..2500)) && covered.ranges.len() == 1);
        assert!(covered.cover(0, 63_500, &(2500..3000)) && covered.ranges.is_empty());
    }

    #[test]
    fn a_cell_of_the_largest_size_takes_no_more() {
        let most = 1_000_000_000_000_000;
        let mut covered = Covered::none_of(1, 1_000_000);
        assert!(covered.cover(0, most, &(0..1_000_000)) && covered.ranges.is_empty());
        assert_eq!(covered.gaps(0, most, most), from_ref(&(1_000_000..most)));
    }
}
