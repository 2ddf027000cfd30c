//! Samples in groups that are counted apart, such as the randomisations of Sobol points, over all values of an axis.

use stickslip_core::model::verdict::VerdictCounts;

use super::sweep::{Counts, SortedSweep};

/// The counts of each group at any value.
#[derive(Debug, Clone)]
pub struct GroupedSweeps {
    groups: Vec<Group>,
    /// Where counts of any group change, rising.
    changes: Vec<f64>,
}

/// The samples of a group.
#[derive(Debug, Clone)]
struct Group {
    samples: u64,
    first: Counts,
    /// Where counts change, rising, and what they are beyond.
    steps: Vec<(f64, Counts)>,
}

impl GroupedSweeps {
    /// Of sweeps over one range.
    #[must_use]
    pub fn new(sweeps: &[SortedSweep]) -> Self {
        let groups: Vec<Group> = sweeps.iter().map(Group::from_sweep).collect();
        let mut changes: Vec<f64> = groups.iter().flat_map(|group| group.steps.iter().map(|(at, _)| *at)).collect();
        changes.sort_unstable_by(f64::total_cmp);
        Self { groups, changes }
    }

    /// The counts of each group at a value.
    #[must_use]
    pub fn at(&self, value: f64) -> Vec<VerdictCounts> {
        self.groups.iter().map(|group| group.at(value)).collect()
    }

    /// Some of the values at which counts change, rising: about so many, with equally many changes between them.
    #[must_use]
    pub fn changes(&self, about: usize) -> Vec<f64> {
        let mut some: Vec<f64> =
            self.changes.iter().step_by(self.changes.len().div_ceil(about.max(1)).max(1)).copied().collect();
        some.dedup();
        some
    }
}

impl Group {
    fn from_sweep(sweep: &SortedSweep) -> Self {
        let mut counts = sweep.first();
        let mut steps: Vec<(f64, Counts)> = Vec::new();
        for (at, change) in sweep.changes() {
            counts += change;
            match steps.last_mut() {
                Some(last) if last.0 == at => last.1 = counts,
                _ => steps.push((at, counts)),
            }
        }
        Self { samples: sweep.samples(), first: sweep.first(), steps }
    }

    /// A sample changes beyond the end of its span, not at it.
    fn at(&self, value: f64) -> VerdictCounts {
        let passed = self.steps.partition_point(|(at, _)| *at < value);
        let Counts { unstable, without_verdict } = passed.checked_sub(1).map_or(self.first, |last| self.steps[last].1);
        let [unstable, failed] = [unstable, without_verdict].map(i64::cast_unsigned);
        VerdictCounts { stable: self.samples - unstable - failed, unstable, undecided: 0, failed }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::spans::Spans;
    use crate::limits::sweep::Sweep;

    #[test]
    fn groups_are_counted_apart_at_any_value() {
        let sweep = |spans: &[[f64; 2]]| {
            let mut sweep = Sweep::new([0.0, 10.0]);
            for &unstable in spans {
                sweep.add(&Spans { unstable, without_verdict: [[8.0, f64::INFINITY], [0.0; 2]] });
            }
            sweep.sorted()
        };
        let sweeps = GroupedSweeps::new(&[sweep(&[[1.0, 3.0], [3.0, 4.0], [-1.0, 2.0]]), sweep(&[[2.0, 8.0]])]);
        for (value, expected) in
            [(0.0, [1, 0]), (1.0, [1, 0]), (1.5, [2, 0]), (2.5, [1, 1]), (3.0, [1, 1]), (3.5, [1, 1]), (5.0, [0, 1])]
        {
            assert_eq!(sweeps.at(value).iter().map(|counts| counts.unstable).collect::<Vec<_>>(), expected, "{value}");
        }
        let beyond = sweeps.at(9.0);
        assert_eq!((beyond[0].failed, beyond[1].failed, beyond[1].unstable), (3, 1, 0));
        assert_eq!(beyond.iter().map(VerdictCounts::total).collect::<Vec<_>>(), [3, 1]);
        assert_eq!(sweeps.changes(1000), [1.0, 2.0, 3.0, 4.0, 8.0]);
        assert!(sweeps.changes(3).len() <= 3);
    }
}
