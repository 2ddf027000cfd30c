//! Adding up the units of all pieces, which are read one after the other.
//!
//! What is counted does not depend on the order of the pieces, although they are not held in memory together. Most parts
//! have units without a sample in common, which may be added in any order. The parts in which some overlap, because a
//! task was started twice or stopped within a unit, are added up again, each from all of its units in a fixed order.

use std::cmp::Reverse;
use std::collections::BTreeSet;
use std::ops::Range;

use crate::evaluate::unit::FinishedUnit;
use crate::store::tally::Tally;

/// Units of parts with overlaps that are held at once. If there are more, the pieces are read several times.
const MOST_HELD: usize = 100_000;

/// Why units cannot be added up.
#[derive(Debug, PartialEq, Eq)]
pub enum Refusal<E> {
    /// The pieces cannot be read.
    Unread(E),
    /// Two units of this part have different results on the same samples: one of them is wrong.
    Disagreement(u64, Range<u64>),
}

/// Adds the units of pieces to a tally. `read` passes the units of all pieces, in any order, to what it is given.
/// Samples are counted once, even if a unit is there twice because a batch system started a task twice. Of units that
/// overlap, the one that starts first is counted, and of those the longest.
///
/// # Errors
/// Those of `read`, and units that disagree.
pub fn add_all<E>(
    tally: &mut Tally,
    mut read: impl FnMut(&mut dyn FnMut(FinishedUnit)) -> Result<(), E>,
) -> Result<(), Refusal<E>> {
    let mut overlapping = BTreeSet::new();
    read(&mut |unit| {
        if !tally.add(&unit) && !tally.has_just(&unit) {
            overlapping.insert(unit.part);
        }
    })
    .map_err(Refusal::Unread)?;
    while let Some(&first) = overlapping.first() {
        let mut held = Held { units: Vec::new(), parts: first..u64::MAX, most: MOST_HELD };
        read(&mut |unit| {
            if overlapping.contains(&unit.part) {
                held.take(unit);
            }
        })
        .map_err(Refusal::Unread)?;
        let rest = overlapping.split_off(&held.parts.end);
        overlapping.iter().for_each(|&part| tally.clear(part));
        add_in_order(tally, held.units).map_err(|(part, samples)| Refusal::Disagreement(part, samples))?;
        overlapping = rest;
    }
    Ok(())
}

/// All units of some consecutive parts: of as many as fit, and of one at least.
struct Held {
    units: Vec<FinishedUnit>,
    parts: Range<u64>,
    most: usize,
}

impl Held {
    /// Holds a unit, if it is of these parts, and of fewer parts if it is one too many.
    fn take(&mut self, unit: FinishedUnit) {
        if !self.parts.contains(&unit.part) {
            return;
        }
        self.units.push(unit);
        // Sorting takes less if it is rare.
        if self.units.len() >= 2 * self.most && self.parts.end > self.parts.start + 1 {
            self.units.sort_by_key(|unit| unit.part);
            let last = self.units[self.most].part.max(self.parts.start + 1);
            self.parts.end = last;
            self.units.retain(|unit| unit.part < last);
        }
    }
}

/// Adds units of parts of which nothing is counted.
fn add_in_order(tally: &mut Tally, mut units: Vec<FinishedUnit>) -> Result<(), (u64, Range<u64>)> {
    units.sort_by_key(|unit| (unit.part, unit.samples.start, Reverse(unit.samples.end)));
    for pair in units.windows(2) {
        let same_samples = pair[0].part == pair[1].part && pair[0].samples == pair[1].samples;
        if same_samples && pair[0] != pair[1] {
            return Err((pair[0].part, pair[0].samples.clone()));
        }
    }
    for unit in &units {
        tally.add(unit);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::parts::Parts;
    use crate::evaluate::unit::Recorded;
    use std::slice::from_ref;
    use stickslip_core::model::verdict::VerdictCounts;

    fn unit(part: u64, samples: Range<u64>) -> FinishedUnit {
        let counts = VerdictCounts { unstable: samples.end - samples.start, ..Default::default() };
        let sums = vec![samples.clone().sum::<u64>().cast_signed()];
        FinishedUnit { part, samples, counts, recorded: Recorded::default(), sums }
    }

    fn joined(parts: &Parts, units: &[FinishedUnit]) -> Result<Tally, Refusal<()>> {
        let mut tally = Tally::new(parts);
        add_all(&mut tally, |take| {
            units.iter().cloned().for_each(take);
            Ok(())
        })?;
        Ok(tally)
    }

    #[test]
    fn overlaps_are_counted_once_whatever_the_order() {
        let parts = Parts::plain(2, 25);
        let mut units = vec![unit(0, 5..15), unit(0, 0..10), unit(0, 10..20), unit(0, 0..10), unit(1, 0..25)];
        units.extend([unit(1, 0..25), unit(1, 0..7)]);
        for turn in 0..units.len() {
            units.rotate_left(1);
            for _ in 0..2 {
                units.reverse();
                let tally = joined(&parts, &units).unwrap();
                assert_eq!((tally.counts(0).unstable, tally.counts(1).unstable), (20, 25), "{turn}");
                assert_eq!(tally.gaps(0, 25), from_ref(&(20..25)));
                assert_eq!((tally.sums(0), tally.sums(1)), (vec![190], vec![300]));
            }
        }
    }

    #[test]
    fn units_that_disagree_are_an_error_whatever_the_order() {
        let parts = Parts::plain(3, 30);
        let wrong = FinishedUnit { counts: VerdictCounts { stable: 10, ..Default::default() }, ..unit(1, 0..10) };
        let mut units = vec![unit(1, 0..10), unit(1, 10..20), wrong, unit(0, 0..10), unit(1, 0..10)];
        for _ in 0..units.len() {
            units.rotate_left(1);
            let Err(refusal) = joined(&parts, &units) else { panic!("no disagreement found") };
            assert_eq!(refusal, Refusal::Disagreement(1, 0..10));
        }
    }

    #[test]
    fn units_that_do_not_fit_are_left_for_the_next_reading() {
        let mut units: Vec<FinishedUnit> = (0..60).map(|i| unit(i * 7 % 20, i..i + 1)).collect();
        units.push(unit(3, 100..101));
        let mut next = 2;
        let mut seen = Vec::new();
        while next < 20 {
            let mut held = Held { units: Vec::new(), parts: next..u64::MAX, most: 7 };
            units.iter().cloned().for_each(|unit| held.take(unit));
            assert!(held.units.len() < 14 && held.parts.end > next);
            next = held.parts.end;
            seen.extend(held.units);
        }
        assert_eq!(seen.len(), 55, "all of 18 parts");
        // One part is held even if it has more units.
        let mut held = Held { units: Vec::new(), parts: 0..u64::MAX, most: 2 };
        (0..50).for_each(|i| held.take(unit(i % 2, i..i + 1)));
        assert!(held.parts == (0..1) && held.units.len() == 25);
    }

    #[test]
    fn parts_with_overlaps_may_have_more_units_than_are_held() {
        let parts = Parts::plain(40_000, 4);
        let of_part = |part: u64| [unit(part, 0..2), unit(part, 1..3), unit(part, 2..4)];
        let units: Vec<FinishedUnit> = (0..parts.cells()).flat_map(of_part).collect();
        let mut readings = 0;
        let mut tally = Tally::new(&parts);
        let read = |take: &mut dyn FnMut(FinishedUnit)| -> Result<(), ()> {
            readings += 1;
            units.iter().cloned().for_each(take);
            Ok(())
        };
        add_all(&mut tally, read).unwrap();
        assert_eq!((tally.counted(), readings), (160_000, 2));
        assert!((0..parts.cells()).all(|part| tally.is_complete(part, 4)));
    }
}
