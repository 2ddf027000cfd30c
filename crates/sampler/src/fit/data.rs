//! What was observed in the tests.

use stickslip_core::model::pair_boundary::PairBoundary;

/// Tests that only say whether there was squeal, in equal conditions.
#[derive(Debug, Clone, Copy)]
pub(super) struct Verdicts {
    /// The nominal first input.
    pub(super) nominal: f64,
    pub(super) boundary: PairBoundary,
    pub(super) squealed: f64,
    pub(super) quiet: f64,
    /// The rows of the first that squealed and of the first that did not.
    pub(super) rows: [Option<u64>; 2],
    /// Whether these are tests of onset speeds that ended without squeal: those that squealed before are not among them.
    pub(super) are_censored: bool,
}

/// A test that says at which speed squeal began.
#[derive(Debug, Clone, Copy)]
pub(super) struct Onset {
    /// The nominal first input.
    pub(super) nominal: f64,
    /// The boundaries a little below and above that speed.
    pub(super) boundaries: [PairBoundary; 2],
    /// The logarithm of the quotient of the two speeds.
    pub(super) width: f64,
    pub(super) row: u64,
}

/// The tests. Their order has no effect but on rounding.
#[derive(Debug, Clone, Default)]
pub struct TestData {
    pub(super) verdicts: Vec<Verdicts>,
    pub(super) onsets: Vec<Onset>,
    row: u64,
}

impl TestData {
    /// Names the row that the next tests are from.
    pub fn begin_row(&mut self, row: u64) {
        self.row = row;
    }

    /// Adds `count` tests at a nominal first input, with the boundary at their speed.
    pub fn add_verdict(&mut self, nominal: f64, boundary: &PairBoundary, squealed: bool, count: u64) {
        let counted = count as f64;
        let [more_squealed, more_quiet] = if squealed { [counted, 0.0] } else { [0.0, counted] };
        let row = (count > 0).then_some(self.row);
        let rows = if squealed { [row, None] } else { [None, row] };
        self.add(Verdicts {
            nominal,
            boundary: *boundary,
            squealed: more_squealed,
            quiet: more_quiet,
            rows,
            are_censored: false,
        });
    }

    /// Adds a test at a nominal first input in which the speed was lowered to that of the boundary without squeal.
    pub fn add_censored(&mut self, nominal: f64, boundary: &PairBoundary) {
        let rows = [None, Some(self.row)];
        self.add(Verdicts { nominal, boundary: *boundary, squealed: 0.0, quiet: 1.0, rows, are_censored: true });
    }

    fn add(&mut self, more: Verdicts) {
        let condition = |of: &Verdicts| (of.nominal, of.boundary, of.are_censored);
        match self.verdicts.iter_mut().find(|verdicts| condition(verdicts) == condition(&more)) {
            Some(verdicts) => {
                verdicts.rows = [verdicts.rows[0].or(more.rows[0]), verdicts.rows[1].or(more.rows[1])];
                verdicts.squealed += more.squealed;
                verdicts.quiet += more.quiet;
            }
            None => self.verdicts.push(more),
        }
    }

    /// Adds a test at a nominal first input in which squeal began at a speed, with the boundaries at two speeds a little
    /// below and above it.
    pub fn add_onset(&mut self, nominal: f64, boundaries: [PairBoundary; 2], speeds: [f64; 2]) {
        self.onsets.push(Onset { nominal, boundaries, width: libm::log(speeds[1] / speeds[0]), row: self.row });
    }

    /// The tests without those of a row: all that had its result in its condition.
    pub(super) fn without(&self, row: u64) -> Self {
        let mut others = self.clone();
        for verdicts in &mut others.verdicts {
            let [squealed, quiet] = verdicts.rows.map(|of| of == Some(row));
            verdicts.squealed = if squealed { 0.0 } else { verdicts.squealed };
            verdicts.quiet = if quiet { 0.0 } else { verdicts.quiet };
        }
        others.onsets.retain(|onset| onset.row != row);
        others
    }

    /// How many onset speeds and different conditions of verdicts there are.
    #[must_use]
    pub fn conditions(&self) -> usize {
        self.verdicts.len() + self.onsets.len()
    }

    /// How many tests squealed, and how many did not.
    #[must_use]
    pub fn counts(&self) -> [f64; 2] {
        let sum = |of: fn(&Verdicts) -> f64| self.verdicts.iter().map(of).sum::<f64>();
        [sum(|verdicts| verdicts.squealed) + self.onsets.len() as f64, sum(|verdicts| verdicts.quiet)]
    }
}
