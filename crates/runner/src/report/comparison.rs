//! How a run differs from the first one of a report.

use serde_json::{Value, json};

use crate::output::counted;
use crate::picture::view::{round, rounded};

/// Where the colours of differences are fixed, from the most negative to the most positive: blue, white, red.
const COLOURS: [(f64, &str); 5] =
    [(0.0, "#2166ac"), (0.25, "#92c5de"), (0.5, "#f7f7f7"), (0.75, "#f4a582"), (1.0, "#b2182b")];

/// The differences of a run from the first, for every cell of the first.
pub struct Comparison {
    /// Place of the run among those of the report.
    pub run: usize,
    /// What the intervals are.
    pub interval_name: String,
    /// None for cells that only the first run has.
    pub cells: Vec<Option<ComparedCell>>,
}

/// The probabilities of a cell in the first and in the other run, and the second minus the first.
pub struct ComparedCell {
    pub first: Option<f64>,
    pub second: Option<f64>,
    pub difference: Option<f64>,
    pub low: f64,
    pub high: f64,
}

impl Comparison {
    /// The comparison for the script of the page.
    pub fn data(&self) -> Value {
        let column = |value: fn(&ComparedCell) -> Option<f64>| -> Vec<Option<f64>> {
            self.cells.iter().map(|cell| cell.as_ref().and_then(value).map(round)).collect()
        };
        json!({
            "run": self.run,
            "interval_name": self.interval_name,
            "colours": COLOURS,
            "first": column(|cell| cell.first),
            "second": column(|cell| cell.second),
            "value": column(|cell| cell.difference),
            "low": column(|cell| Some(cell.low)),
            "high": column(|cell| Some(cell.high)),
        })
    }

    /// In how many cells the intervals say that the runs differ, as a sentence.
    pub fn summary(&self, first: &str, second: &str) -> String {
        let compared: Vec<&ComparedCell> = self.cells.iter().flatten().collect();
        let more = compared.iter().filter(|cell| cell.low > 0.0).count();
        let less = compared.iter().filter(|cell| cell.high < 0.0).count();
        let known = || compared.iter().filter_map(|cell| cell.difference);
        let without = match compared.len() - known().count() {
            0 => String::new(),
            without => {
                let cells = counted(without as u128, "cell is", "cells are");
                format!("{cells} without a probability in one run or both. ")
            }
        };
        let largest = known().max_by(|a, b| a.abs().total_cmp(&b.abs()));
        let largest = largest.map_or("No difference is known.".to_owned(), |largest| {
            format!("The largest difference is {}.", rounded(largest))
        });
        format!(
            "Of {} in both, P of {second} is larger than that of {first} in {more}, and smaller in {less}: there the {} of \
             the difference excludes 0. {without}{largest}",
            counted(compared.len() as u128, "cell", "cells"),
            self.interval_name
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_known_is_no_difference_of_zero() {
        let cell = |difference: Option<f64>, low, high| {
            Some(ComparedCell { first: None, second: None, difference, low, high })
        };
        let summary = |cells| Comparison { run: 1, interval_name: "95 % interval".to_owned(), cells }.summary("a", "b");
        assert_eq!(
            summary(vec![cell(None, -1.0, 1.0), None]),
            "Of 1 cell in both, P of b is larger than that of a in 0, and smaller in 0: there the 95 % interval of the \
             difference excludes 0. 1 cell is without a probability in one run or both. No difference is known."
        );
        assert_eq!(
            summary(vec![cell(Some(0.1), 0.05, 0.2), cell(Some(-0.3), -0.4, -0.2), cell(Some(0.0), -0.1, 0.1)]),
            "Of 3 cells in both, P of b is larger than that of a in 1, and smaller in 1: there the 95 % interval of the \
             difference excludes 0. The largest difference is -0.3."
        );
        assert_eq!(
            summary(vec![cell(None, -1.0, 1.0), cell(Some(2.5e-7), 1e-7, 4e-7), cell(None, -1.0, 1.0)]),
            "Of 3 cells in both, P of b is larger than that of a in 1, and smaller in 0: there the 95 % interval of the \
             difference excludes 0. 2 cells are without a probability in one run or both. The largest difference is \
             2.5e-7."
        );
    }
}
