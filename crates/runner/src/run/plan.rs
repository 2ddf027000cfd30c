//! Cutting the missing samples into units of work, and sharing them among shards.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use stickslip_sampler::BLOCK_SAMPLES;

use super::tally::Tally;

/// Samples of a unit at the most. Units start at multiples of it, whatever is counted already, so that shards
/// agree on them. A unit of the eigenvalue criterion takes some milliseconds: long against the cost of handing it
/// out, short against anyone's patience after Ctrl-C.
const UNIT_SAMPLES: u64 = 1000 * BLOCK_SAMPLES;

/// One of several processes that share a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    index: u64,
    count: u64,
}

impl FromStr for Shard {
    type Err = String;

    /// `I/N`. Both counts from 0 to N - 1 and from 1 to N reach every shard: N is taken for 0.
    fn from_str(text: &str) -> Result<Self, String> {
        let wrong =
            || format!("{text:?} is not a shard; write I/N, for example 1/16, with I from 1 to N (or from 0 to N-1)");
        let (index, count) = text.split_once('/').ok_or_else(wrong)?;
        let index: u64 = index.parse().map_err(|_| wrong())?;
        let count: u64 = count.parse().map_err(|_| wrong())?;
        if count == 0 || index > count || count > 1_000_000 {
            return Err(wrong());
        }
        Ok(Self { index: index % count, count })
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let index = if self.index == 0 { self.count } else { self.index };
        write!(f, "{index}/{}", self.count)
    }
}

impl Shard {
    /// Whether this shard computes the unit that starts at `first` of `cell`. Consecutive units go to different
    /// shards, so that jobs of one cell and jobs of many are shared alike.
    fn owns(&self, cell: u64, first: u64, units_per_cell: u64) -> bool {
        let unit = u128::from(cell) * u128::from(units_per_cell) + u128::from(first / UNIT_SAMPLES);
        unit % u128::from(self.count) == u128::from(self.index)
    }
}

/// The units of work of one process, without a list of them: 10^10 samples take no more memory than 10^4.
#[derive(Debug)]
pub struct Plan {
    gaps: Vec<(u64, Range<u64>)>,
    /// For each gap the number of units before it; one more entry at the end.
    units_before: Vec<u64>,
}

impl Plan {
    /// The units that are missing for `samples` samples in each cell.
    pub fn new(tally: &Tally, samples: u64, shard: Option<Shard>) -> Self {
        let mut gaps = tally.gaps(samples);
        if let Some(shard) = shard {
            let units_per_cell = samples.div_ceil(UNIT_SAMPLES);
            let pieces =
                gaps.into_iter().flat_map(|(cell, gap)| units_of(&gap).map(move |unit| (cell, cut(&gap, unit))));
            gaps = pieces.filter(|(cell, samples)| shard.owns(*cell, samples.start, units_per_cell)).collect();
        }
        let mut units_before = Vec::with_capacity(gaps.len() + 1);
        let mut units = 0;
        for (_, gap) in &gaps {
            units_before.push(units);
            units += units_of(gap).count() as u64;
        }
        units_before.push(units);
        Self { gaps, units_before }
    }

    /// The number of units.
    pub fn units(&self) -> u64 {
        self.units_before[self.gaps.len()]
    }

    /// Samples over all units.
    pub fn samples(&self) -> u128 {
        self.gaps.iter().map(|(_, gap)| u128::from(gap.end - gap.start)).sum()
    }

    /// The unit at `index`: its cell and samples.
    pub fn unit(&self, index: u64) -> (u64, Range<u64>) {
        let gap_index = self.units_before.partition_point(|&before| before <= index) - 1;
        let (cell, gap) = &self.gaps[gap_index];
        let first_unit = gap.start / UNIT_SAMPLES;
        (*cell, cut(gap, first_unit + index - self.units_before[gap_index]))
    }
}

/// The numbers of the units that a gap touches.
fn units_of(gap: &Range<u64>) -> Range<u64> {
    gap.start / UNIT_SAMPLES..gap.end.div_ceil(UNIT_SAMPLES)
}

/// The part of a unit that lies in a gap.
fn cut(gap: &Range<u64>, unit: u64) -> Range<u64> {
    gap.start.max(unit * UNIT_SAMPLES)..gap.end.min((unit + 1) * UNIT_SAMPLES)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::tally::Segment;
    use stickslip_core::VerdictCounts;

    fn tally_with_holes() -> Tally {
        let mut tally = Tally::new(7);
        for (cell, samples) in [(0, 0..3_500_000), (2, 1_000_000..1_000_001), (3, 0..10_000), (6, 999_999..2_000_000)] {
            let counts = VerdictCounts { stable: samples.end - samples.start, ..Default::default() };
            tally.add(&Segment { cell, samples, counts });
        }
        tally
    }

    fn units(tally: &Tally, shard: Option<Shard>) -> Vec<(u64, Range<u64>)> {
        let plan = Plan::new(tally, 3_500_000, shard);
        let units: Vec<_> = (0..plan.units()).map(|index| plan.unit(index)).collect();
        let samples: u128 = units.iter().map(|(_, samples)| u128::from(samples.end - samples.start)).sum();
        assert_eq!(samples, plan.samples());
        units
    }

    #[test]
    fn units_fill_the_gaps_and_nothing_else() {
        let mut tally = tally_with_holes();
        for (cell, samples) in units(&tally, None) {
            let before = tally.counted();
            let counts = VerdictCounts { stable: samples.end - samples.start, ..Default::default() };
            assert!(samples.start / UNIT_SAMPLES == (samples.end - 1) / UNIT_SAMPLES);
            tally.add(&Segment { cell, samples, counts });
            assert_eq!(tally.counted() - before, u128::from(counts.total()), "no overlap");
        }
        assert!(tally.gaps(3_500_000).is_empty());
    }

    #[test]
    fn shards_part_the_units_however_they_are_counted() {
        let tally = tally_with_holes();
        let mut whole = units(&tally, None);
        whole.sort_by_key(|(cell, samples)| (*cell, samples.start));
        for (count, first) in [(1, 0), (1, 1), (4, 0), (4, 1), (16, 1), (100, 0)] {
            let mut parts = Vec::new();
            for index in first..first + count {
                parts.extend(units(&tally, Some(format!("{index}/{count}").parse().unwrap())));
            }
            parts.sort_by_key(|(cell, samples)| (*cell, samples.start));
            assert_eq!(parts, whole, "{count} shards from {first}");
        }
    }

    #[test]
    fn a_shard_is_the_same_whatever_is_done_already() {
        let shard: Shard = "2/3".parse().unwrap();
        let fresh = units(&Tally::new(7), Some(shard));
        for (cell, samples) in units(&tally_with_holes(), Some(shard)) {
            let inside = |(c, s): &(u64, Range<u64>)| *c == cell && s.start <= samples.start && samples.end <= s.end;
            assert!(fresh.iter().any(inside), "{cell} {samples:?}");
        }
    }

    #[test]
    fn silly_shards_are_refused() {
        for text in ["", "3", "4/3", "1/0", "a/b", "-1/3", "1/3/5", "0/0"] {
            assert!(text.parse::<Shard>().is_err(), "{text}");
        }
        assert_eq!("3/3".parse::<Shard>().unwrap().to_string(), "3/3");
        assert_eq!("0/3".parse::<Shard>().unwrap().to_string(), "3/3");
    }
}
