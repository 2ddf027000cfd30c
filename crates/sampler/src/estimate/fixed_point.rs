//! Sums of numbers from 0 to 1 that have the same bits in any order of adding.
//!
//! A number is cut off after some binary digits, 30 for each of its words. With four words a number of 1e-30 still has
//! digits.

/// Binary digits of a word. With 2^32 numbers its sum fits 63 bits.
const DIGITS: u32 = 30;

/// Adds the words of a number from 0 to 1, the largest first.
pub fn add_words(sums: &mut [i64], number: f64) {
    // Exact: products with a power of two, and what is left of them.
    let mut rest = number;
    for sum in sums {
        rest *= f64::from(1_u32 << DIGITS);
        let word = rest.floor();
        *sum += word as i64;
        rest -= word;
    }
}

/// The number that words add up to.
#[must_use]
pub fn number(words: &[i128]) -> f64 {
    let unit = 1.0 / f64::from(1_u32 << DIGITS);
    // From the smallest, as in Horner's rule.
    words.iter().rev().fold(0.0, |sum, &word| (sum + word as f64) * unit)
}

/// The number that words of a unit add up to.
#[must_use]
pub fn number_of_unit(words: &[i64]) -> f64 {
    number(&words.iter().map(|&word| word.into()).collect::<Vec<i128>>())
}

/// Rounding of the numbers that are added, and of their sum.
const SLACK: f64 = 1e-6;

/// Whether words can be those of a sum of numbers from 0 to 1 that is at most this. Sums that are read may be forged.
#[must_use]
pub fn can_be_sum(words: &[i64], most: f64) -> bool {
    (-SLACK..=most + SLACK * most.max(1.0)).contains(&number_of_unit(words))
}
