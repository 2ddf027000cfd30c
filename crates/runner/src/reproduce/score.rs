//! Printed numbers and ours, side by side.

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

    fn line(&self) -> String {
        let decimals = self.decimals;
        let deviation = 100.0 * self.deviation();
        format!(
            "  {:<46} {:>10}   {:>12}   {deviation:+6.2} %   {:<5} {}\n",
            self.quantity,
            format!("{:.decimals$}", self.printed),
            format!("{:.*}", decimals + 2, self.ours),
            if self.agrees() { "yes" } else { "MISS" },
            self.role,
        )
    }
}

/// A table of scores under a heading.
pub fn table(what: &str, theirs: &str, ours: &str, role: &str, scores: &[Score]) -> String {
    let heading = format!("  {what:<46} {theirs:>10}   {ours:>12}   {:>8}   {:<5} {role}\n", "", "same");
    heading + &scores.iter().map(Score::line).collect::<String>()
}
