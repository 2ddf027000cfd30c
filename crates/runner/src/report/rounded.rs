//! Numbers of the page.

/// Significant digits.
const DIGITS: usize = 6;

/// A number with as many digits as anyone reads.
pub fn round(value: f64) -> f64 {
    format!("{value:.*e}", DIGITS - 1).parse().unwrap_or(value)
}
