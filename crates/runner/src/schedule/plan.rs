//! Dividing the missing samples into units of work, and sharing the units among shards.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use crate::evaluate::parts::Parts;
use crate::store::tally::Tally;

/// Most shards of a job.
pub const MOST_SHARDS: u64 = 1_000_000;

/// One of several processes that share a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    index: u64,
    count: u64,
    /// The index as typed: the last shard is N or 0.
    typed: u64,
}

impl FromStr for Shard {
    type Err = String;

    /// `I/N`, with I from 1 to N or from 0 to N - 1: N is the same shard as 0.
    fn from_str(text: &str) -> Result<Self, String> {
        let wrong =
            || format!("{text:?} is not a shard; write I/N, for example 1/16, with I from 1 to N (or from 0 to N-1)");
        let (index, count) = text.split_once('/').ok_or_else(wrong)?;
        let index: u64 = index.parse().map_err(|_| wrong())?;
        let count: u64 = count.parse().map_err(|_| wrong())?;
        if count == 0 || index > count || count > MOST_SHARDS {
            return Err(wrong());
        }
        Ok(Self { index: index % count, count, typed: index })
    }
}

impl Shard {
    /// The number of shards.
    pub fn count(self) -> u64 {
        self.count
    }

    /// Whether a thing of this number belongs to it, where consecutive ones go to different shards.
    pub fn has(self, number: u64) -> bool {
        number % self.count == self.index
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.typed, self.count)
    }
}

/// The units of work of one process. They are not listed, so that 10^10 samples take no more memory than 10^4.
#[derive(Debug)]
pub struct Plan {
    gaps: Vec<Gap>,
    /// Largest number of samples in a unit. Units start at multiples of it, whatever is counted already, so that shards
    /// agree on them.
    unit_samples: u64,
    /// The number of units before each gap, and at the end the number of all units.
    units_before: Vec<u64>,
}

/// Missing samples of one part, and the units among them that this process computes.
#[derive(Debug)]
struct Gap {
    part: u64,
    samples: Range<u64>,
    /// Number of the first unit in the part, and the distance to the next.
    first: u64,
    step: u64,
    units: u64,
}

impl Gap {
    /// The units of a gap that a shard computes. The parts before this one have `units_before` units.
    fn new(part: u64, samples: Range<u64>, unit: u64, units_before: u128, shard: Option<Shard>) -> Self {
        let Shard { index, count, .. } = shard.unwrap_or(Shard { index: 0, count: 1, typed: 1 });
        let (from, to) = (samples.start / unit, samples.end.div_ceil(unit));
        let number = (units_before + u128::from(from)) % u128::from(count);
        let first = from + (index + count - number as u64) % count;
        Self { part, samples, first, step: count, units: to.saturating_sub(first).div_ceil(count) }
    }

    /// All units of a gap.
    fn whole(part: u64, samples: Range<u64>, unit: u64) -> Self {
        let (first, to) = (samples.start / unit, samples.end.div_ceil(unit));
        Self { part, samples, first, step: 1, units: to - first }
    }

    /// The samples of unit `i`.
    fn unit(&self, i: u64, unit_samples: u64) -> Range<u64> {
        let start = (self.first + i * self.step) * unit_samples;
        self.samples.start.max(start)..self.samples.end.min(start + unit_samples)
    }

    /// The number of samples in all units. Only the first and the last unit may be shorter than the others.
    fn total(&self, unit_samples: u64) -> u128 {
        let length = |i: u64| u128::from(self.unit(i, unit_samples).end - self.unit(i, unit_samples).start);
        match self.units {
            0 => 0,
            1 => length(0),
            units => length(0) + length(units - 1) + u128::from(units - 2) * u128::from(unit_samples),
        }
    }
}

impl Plan {
    /// The missing units of the samples that are wanted now.
    ///
    /// Consecutive units, counted over all parts, go to different shards, so that jobs with one cell and jobs with many
    /// are shared alike. Cells whose parts are sequential go to a shard as a whole.
    pub fn new(tally: &Tally, parts: &Parts, unit_samples: u64, shard: Option<Shard>) -> Self {
        let part_units: Vec<u128> =
            (0..parts.of_a_cell()).map(|place| u128::from(parts.max_samples(place).div_ceil(unit_samples))).collect();
        let cell_units: u128 = part_units.iter().sum();
        let cells = cells_with_units(parts, cell_units, shard);
        let missing = cells.flat_map(|cell| parts.missing_of(tally, cell));
        let gaps = missing.filter_map(|(part, gap)| {
            let (cell, place) = parts.place(part);
            match shard {
                Some(Shard { index, count, .. }) if parts.are_sequential() => {
                    (cell % count == index).then(|| Gap::whole(part, gap, unit_samples))
                }
                _ => {
                    let before = u128::from(cell) * cell_units + part_units[..place].iter().sum::<u128>();
                    Some(Gap::new(part, gap, unit_samples, before, shard))
                }
            }
        });
        let gaps: Vec<Gap> = gaps.filter(|gap| gap.units > 0).collect();
        let mut units_before = Vec::with_capacity(gaps.len() + 1);
        let mut units = 0;
        for gap in &gaps {
            units_before.push(units);
            units += gap.units;
        }
        units_before.push(units);
        Self { gaps, unit_samples, units_before }
    }

    /// Largest number of samples in a unit.
    pub fn unit_samples(&self) -> u64 {
        self.unit_samples
    }

    /// The number of units.
    pub fn units(&self) -> u64 {
        self.units_before[self.gaps.len()]
    }

    /// The number of samples in all units.
    pub fn samples(&self) -> u128 {
        self.gaps.iter().map(|gap| gap.total(self.unit_samples)).sum()
    }

    /// The unit at `index`: its part and samples.
    pub fn unit(&self, index: u64) -> (u64, Range<u64>) {
        let position = self.units_before.partition_point(|&before| before <= index) - 1;
        let gap = &self.gaps[position];
        (gap.part, gap.unit(index - self.units_before[position], self.unit_samples))
    }
}

/// The cells of which a process computes units, and perhaps others: those between the units of a shard, most of the cells
/// of a large job, need not be looked at.
fn cells_with_units(parts: &Parts, cell_units: u128, shard: Option<Shard>) -> impl Iterator<Item = u64> {
    let (first, step, of_a_cell) = match shard {
        Some(Shard { index, count, .. }) if parts.are_sequential() => (index.into(), count.into(), 1),
        Some(Shard { index, count, .. }) if cell_units > 0 && u128::from(count) >= cell_units => {
            (u128::from(index), u128::from(count), cell_units)
        }
        _ => (0, 1, 1),
    };
    let cells = parts.cells();
    (0..).map(move |turn: u128| ((first + turn * step) / of_a_cell) as u64).take_while(move |&cell| cell < cells)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::unit::{FinishedUnit, Recorded};
    use stickslip_core::model::verdict::VerdictCounts;

    const SAMPLES: u64 = 3_500_000;

    const UNIT_SAMPLES: u64 = 1_000_000;

    fn tally_with_holes() -> Tally {
        let mut tally = Tally::new(&Parts::plain(7, SAMPLES));
        for (cell, samples) in [(0, 0..3_500_000), (2, 1_000_000..1_000_001), (3, 0..10_000), (6, 999_999..2_000_000)] {
            let counts = VerdictCounts { stable: samples.end - samples.start, ..Default::default() };
            tally.add(&FinishedUnit { part: cell, samples, counts, recorded: Recorded::default(), sums: Vec::new() });
        }
        tally
    }

    fn units(tally: &Tally, shard: Option<Shard>) -> Vec<(u64, Range<u64>)> {
        let plan = Plan::new(tally, &Parts::plain(7, SAMPLES), UNIT_SAMPLES, shard);
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
            tally.add(&FinishedUnit { part: cell, samples, counts, recorded: Recorded::default(), sums: Vec::new() });
            assert_eq!(tally.counted() - before, u128::from(counts.total()), "no overlap");
        }
        assert!((0..7).all(|part| tally.gaps(part, SAMPLES).is_empty()));
    }

    #[test]
    fn shards_share_all_units_whether_counted_from_0_or_1() {
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
    fn a_shard_does_not_depend_on_finished_work() {
        let shard: Shard = "2/3".parse().unwrap();
        let fresh = units(&Tally::new(&Parts::plain(7, SAMPLES)), Some(shard));
        for (cell, samples) in units(&tally_with_holes(), Some(shard)) {
            let inside = |(c, s): &(u64, Range<u64>)| *c == cell && s.start <= samples.start && samples.end <= s.end;
            assert!(fresh.iter().any(inside), "{cell} {samples:?}");
        }
    }

    #[test]
    fn invalid_shards_are_refused() {
        for text in ["", "3", "4/3", "1/0", "a/b", "-1/3", "1/3/5", "0/0"] {
            assert!(text.parse::<Shard>().is_err(), "{text}");
        }
        assert_eq!("3/3".parse::<Shard>().unwrap().to_string(), "3/3");
        assert_eq!("0/3".parse::<Shard>().unwrap().to_string(), "0/3");
    }
}
