//! How accurately the least and the greatest probability are found.

/// Most that a proved extreme may leave out, and at least.
const MOST: f64 = 1e-6;
const LEAST: f64 = 1e-7;

/// The same relative to the probability.
const RELATIVE: f64 = 1e-4;

/// By how much a value beyond the extreme that was found may differ from it: a millionth, of probabilities below 0.01
/// one part in ten thousand of themselves, but not less than 1e-7.
pub fn tolerance(probability: f64) -> f64 {
    (RELATIVE * probability).clamp(LEAST, MOST)
}
