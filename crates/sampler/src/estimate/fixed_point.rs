//! Sums of numbers from 0 to 1 that have the same bits in any order of adding.
//!
//! A number is cut off after 120 binary digits, which are four words of 30. So a number of 1e-30 still has digits.

/// Binary digits of a word. With 2^32 numbers its sum fits 63 bits.
const DIGITS: u32 = 30;

/// Words of a number.
pub const WORDS: usize = 4;

/// Adds the words of a number from 0 to 1, the largest first.
pub fn add_words(sums: &mut [i64], number: f64) {
    // Exact: a product with a power of two, cut off.
    let digits = (number * (1_u128 << (DIGITS * WORDS as u32)) as f64) as u128;
    for (word, sum) in sums.iter_mut().enumerate() {
        let above = digits >> (DIGITS * (WORDS - 1 - word) as u32);
        let own = if word == 0 { above } else { above & ((1 << DIGITS) - 1) };
        *sum += own as i64;
    }
}

/// The number that words add up to.
#[must_use]
pub fn number(words: &[i128]) -> f64 {
    let unit = 1.0 / f64::from(1_u32 << DIGITS);
    // From the smallest, as in Horner's rule.
    words.iter().rev().fold(0.0, |sum, &word| (sum + word as f64) * unit)
}
