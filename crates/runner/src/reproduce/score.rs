//! Printed numbers and ours, side by side.

use super::part::Table;

/// One printed number.
pub struct Score {
    pub quantity: String,
    pub printed: f64,
    /// Decimals to which it is printed.
    pub decimals: usize,
    pub ours: f64,
    /// What the parameter set owes to this number.
    pub role: &'static str,
}

impl Score {
    fn deviation(&self) -> f64 {
        self.ours / self.printed - 1.0
    }

    /// Whether our value, rounded as it is printed, is the printed one, and no further off than 5 %: a single
    /// printed digit rounds too much away.
    pub fn agrees(&self) -> bool {
        let same_digits = format!("{:.*}", self.decimals, self.ours) == format!("{:.*}", self.decimals, self.printed);
        same_digits && self.deviation().abs() <= 0.05
    }

    fn row(&self) -> [String; 6] {
        let decimals = self.decimals;
        [
            self.quantity.clone(),
            format!("{:.decimals$}", self.printed),
            format!("{:.*}", decimals + 2, self.ours),
            // The sum makes -0 a 0.
            format!("{:+.2} %", (1e4 * self.deviation()).round() / 100.0 + 0.0),
            if self.agrees() { "yes" } else { "MISS" }.to_owned(),
            self.role.to_owned(),
        ]
    }
}

/// A table of scores; what the parameter set owes to them has no place at the terminal.
pub fn table(scores: &[Score]) -> Table {
    let headings = ["printed in the paper", "paper", "our set", "deviation", "same", "what it says of our set"];
    Table { at_terminal: 5, ..Table::new("", headings, scores.iter().map(Score::row).collect()) }
}
