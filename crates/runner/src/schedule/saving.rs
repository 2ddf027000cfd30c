//! Saving finished samples to pieces while a computation goes on.

use std::time::{Duration, Instant};

use crate::evaluate::parts::Parts;
use crate::evaluate::unit::FinishedUnit;
use crate::failure::Failure;
use crate::files::folder::Folder;
use crate::interrupt::Interrupt;
use crate::store::piece;

/// Largest number of finished units that wait to be written.
const MOST_PENDING: usize = 100_000;

/// Pieces are written after a tenth of the time already spent, but not more often than the first and at least as often
/// as the second.
pub(super) const SHORTEST_INTERVAL: Duration = Duration::from_millis(100);
pub(super) const LONGEST_INTERVAL: Duration = Duration::from_secs(5);

/// Samples of a unit that is not complete wait this long for the rest. Units that take less time are written whole, so
/// that two processes that do the same work write the same units.
const PATIENCE: Duration = Duration::from_secs(3);

/// Finished samples, and when they are written.
pub struct Saving<'a> {
    pieces: &'a Folder,
    experiment: String,
    parts: &'a Parts,
    unit_samples: u64,
    pending: Vec<Pending>,
    started: Instant,
    written: Instant,
}

/// Samples that wait to be written.
struct Pending {
    unit: FinishedUnit,
    since: Instant,
}

impl<'a> Saving<'a> {
    /// Saves samples of an experiment in the folder `pieces`, computed in units of up to `unit_samples`.
    pub fn new(pieces: &'a Folder, experiment: String, parts: &'a Parts, unit_samples: u64) -> Self {
        let now = Instant::now();
        Self { pieces, experiment, parts, unit_samples, pending: Vec::new(), started: now, written: now }
    }

    /// Takes finished samples.
    pub fn add(&mut self, unit: FinishedUnit) {
        self.pending.push(Pending { unit, since: Instant::now() });
    }

    /// Writes a piece if one is due. After a signal it holds whatever is finished.
    pub fn save_if_due(&mut self, interrupt: &Interrupt) -> Result<(), Failure> {
        let is_stopping = interrupt.signal().is_some();
        let interval = match is_stopping {
            true => SHORTEST_INTERVAL,
            false => (self.started.elapsed() / 10).clamp(SHORTEST_INTERVAL, LONGEST_INTERVAL),
        };
        if self.written.elapsed() < interval && self.pending.len() < MOST_PENDING {
            return Ok(());
        }
        self.save(is_stopping, interrupt)
    }

    /// Writes everything that is finished.
    pub fn save_all(&mut self, interrupt: &Interrupt) -> Result<(), Failure> {
        self.save(true, interrupt)
    }

    fn save(&mut self, all: bool, interrupt: &Interrupt) -> Result<(), Failure> {
        self.join();
        let now = Instant::now();
        let pending = std::mem::take(&mut self.pending);
        let is_ready = |pending: &Pending| all || self.is_whole(&pending.unit) || now - pending.since >= PATIENCE;
        let (ready, rest): (Vec<Pending>, Vec<Pending>) = pending.into_iter().partition(is_ready);
        self.pending = rest;
        self.written = now;
        if ready.is_empty() {
            return Ok(());
        }
        let stored = |Pending { unit, .. }| FinishedUnit { part: self.parts.stored(unit.part), ..unit };
        let units: Vec<FinishedUnit> = ready.into_iter().map(stored).collect();
        let _saving = interrupt.saving();
        piece::write(self.pieces, &self.experiment, &units)
    }

    /// Joins consecutive samples of the same unit. Whole units are not joined.
    fn join(&mut self) {
        self.pending.sort_by_key(|pending| (pending.unit.part, pending.unit.samples.start));
        let mut joined: Vec<Pending> = Vec::with_capacity(self.pending.len());
        for Pending { unit, since } in self.pending.drain(..) {
            match joined.last_mut() {
                Some(last)
                    if last.unit.is_followed_by(&unit) && !unit.samples.start.is_multiple_of(self.unit_samples) =>
                {
                    last.unit.append(&unit);
                    last.since = last.since.min(since);
                }
                _ => joined.push(Pending { unit, since }),
            }
        }
        self.pending = joined;
    }

    /// Whether a unit ends where no further samples of it follow.
    fn is_whole(&self, unit: &FinishedUnit) -> bool {
        let place = self.parts.place(unit.part).1;
        unit.samples.end.is_multiple_of(self.unit_samples) || unit.samples.end == self.parts.max_samples(place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::unit::Recorded;
    use std::ops::Range;
    use stickslip_core::model::verdict::VerdictCounts;

    fn unit(part: u64, samples: Range<u64>) -> FinishedUnit {
        let counts = VerdictCounts { stable: samples.end - samples.start, ..Default::default() };
        FinishedUnit { part, samples, counts, recorded: Recorded::default(), sums: Vec::new() }
    }

    fn written(directory: &Folder) -> Vec<FinishedUnit> {
        let mut units = Vec::new();
        piece::read_all(directory, "experiment", |_| None, &mut |unit| {
            units.push(unit);
            Ok(())
        })
        .unwrap();
        units.sort_by_key(|unit| (unit.part, unit.samples.start));
        units
    }

    #[test]
    fn units_are_written_whole_and_what_is_not_whole_waits_for_the_rest() {
        let directory = tempfile::tempdir().unwrap();
        let folder = Folder::open(directory.path()).unwrap();
        let (parts, interrupt) = (Parts::plain(3, 2500), Interrupt::unwatched());
        let mut saving = Saving::new(&folder, "experiment".to_owned(), &parts, 1000);
        let arrived =
            [unit(1, 400..1000), unit(1, 0..400), unit(0, 1000..1700), unit(2, 2000..2500), unit(1, 1000..2000)];
        arrived.into_iter().for_each(|unit| saving.add(unit));
        saving.save(false, &interrupt).unwrap();
        assert_eq!(written(&folder), [unit(1, 0..1000), unit(1, 1000..2000), unit(2, 2000..2500)]);
        saving.add(unit(0, 1700..1800));
        saving.save_all(&interrupt).unwrap();
        assert_eq!(written(&folder)[0], unit(0, 1000..1800));
        assert!(saving.pending.is_empty());
    }

    #[test]
    fn what_is_not_whole_waits_only_so_long() {
        let directory = tempfile::tempdir().unwrap();
        let folder = Folder::open(directory.path()).unwrap();
        let (parts, interrupt) = (Parts::plain(1, 1000), Interrupt::unwatched());
        let mut saving = Saving::new(&folder, "experiment".to_owned(), &parts, 1000);
        saving.add(unit(0, 0..10));
        saving.pending[0].since -= PATIENCE;
        saving.add(unit(0, 10..12));
        saving.save(false, &interrupt).unwrap();
        assert_eq!(written(&folder), [unit(0, 0..12)]);
    }
}
