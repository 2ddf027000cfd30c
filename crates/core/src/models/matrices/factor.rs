//! Factors of matrices: products of numbers and integer powers of parameters.

use std::fmt;

use thiserror::Error;

/// A number times integer powers of parameters, such as `friction * contact` or `1 / speed^2`.
///
/// ```
/// use stickslip_core::models::matrices::factor::Factor;
/// let names = ["friction", "speed"];
/// let factor = Factor::parse("0.5 * friction / speed^2", &names)?;
/// assert_eq!(factor.value(&[0.4, 10.0]), 0.5 * 0.4 / 100.0);
/// assert_eq!(factor.to_text(&names), "0.5 * friction / speed^2");
/// # Ok::<(), stickslip_core::models::matrices::factor::FactorError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Factor {
    number: f64,
    /// Places of parameters with their powers, none of which is zero, in the order of the places.
    powers: Vec<(usize, i32)>,
}

/// Largest power of a parameter, up or down.
const LARGEST_POWER: i32 = 9;

/// Why a text is no factor.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum FactorError {
    /// A name that no parameter has.
    #[error("there is no parameter `{0}`")]
    UnknownParameter(String),
    /// Something that a factor cannot have.
    #[error(
        "`{found}` has no place here: a factor is a product of numbers and powers of parameters, such as \"friction / speed^2\""
    )]
    Unexpected {
        /// What was found.
        found: String,
    },
    /// The text ends where a number or a parameter is expected.
    #[error("the factor ends where a number or a parameter is expected")]
    Incomplete,
    /// A number that is none, or that is infinite.
    #[error("`{0}` is no finite number")]
    NotANumber(String),
    /// A power that is no integer, or too large.
    #[error("the power `{0}` is no integer from -9 to 9")]
    Power(String),
}

impl Factor {
    /// A number.
    #[must_use]
    pub fn number(number: f64) -> Self {
        Self { number, powers: Vec::new() }
    }

    /// Reads a factor; parameters are known by their places among `names`.
    ///
    /// # Errors
    /// [`FactorError`], if the text is none.
    pub fn parse(text: &str, names: &[impl AsRef<str>]) -> Result<Self, FactorError> {
        let mut rest = text.trim();
        let mut number = 1.0;
        if let Some(after) = rest.strip_prefix('-') {
            (number, rest) = (-1.0, after.trim_start());
        }
        let mut powers = vec![0_i32; names.len()];
        let mut divides = false;
        loop {
            let (word, after) = word(rest).ok_or_else(|| unexpected_or_end(rest))?;
            let (power, after) = power(after)?;
            let power = if divides { -power } else { power };
            if word.starts_with(|c: char| c.is_ascii_digit() || c == '.' || c == '-' || c == '+') {
                let value: f64 = word.parse().map_err(|_| FactorError::NotANumber(word.to_owned()))?;
                number *= integer_power(value, power);
                if !number.is_finite() {
                    return Err(FactorError::NotANumber(text.trim().to_owned()));
                }
            } else {
                let place = names.iter().position(|name| name.as_ref() == word);
                let place = place.ok_or_else(|| FactorError::UnknownParameter(word.to_owned()))?;
                powers[place] += power;
                if powers[place].abs() > LARGEST_POWER {
                    return Err(FactorError::Power(powers[place].to_string()));
                }
            }
            rest = after.trim_start();
            divides = match rest.chars().next() {
                None => break,
                Some('*') => false,
                Some('/') => true,
                Some(_) => return Err(unexpected_or_end(rest)),
            };
            rest = rest[1..].trim_start();
        }
        let powers = powers.into_iter().enumerate().filter(|(_, power)| *power != 0).collect();
        Ok(Self { number, powers })
    }

    /// Its value at these values of all parameters.
    #[must_use]
    pub fn value(&self, parameters: &[f64]) -> f64 {
        let (mut above, mut below) = (self.number, 1.0);
        for &(place, power) in &self.powers {
            let value = integer_power(parameters[place], power.abs());
            if power > 0 {
                above *= value;
            } else {
                below *= value;
            }
        }
        above / below
    }

    /// The number that this factor is of another, whatever the parameters; none where it depends on them, or is infinite.
    #[must_use]
    pub fn over(&self, other: &Self) -> Option<f64> {
        let ratio = self.number / other.number;
        (self.powers == other.powers && ratio.is_finite()).then_some(ratio)
    }

    /// Its derivative by the parameter at a place.
    fn derived(&self, place: usize) -> Self {
        let Some(&(_, power)) = self.powers.iter().find(|(own, _)| *own == place) else { return Self::number(0.0) };
        let powers = self.powers.iter().map(|&(own, power)| (own, if own == place { power - 1 } else { power }));
        let powers = powers.filter(|(_, power)| *power != 0).collect();
        Self { number: self.number * f64::from(power), powers }
    }

    /// `[c_0, c_1, c_2, c_3]`: with a parameter d larger than among these it is `c_0 + c_1 d + c_2 d^2`, but for at most `c_3` as
    /// long as d is no larger than a step to both sides.
    #[must_use]
    pub fn series(&self, parameters: &[f64], place: usize, step: f64) -> [f64; 4] {
        let first = self.derived(place);
        let second = first.derived(place);
        let third = second.derived(place);
        let largest = if third.number == 0.0 || step == 0.0 {
            0.0
        } else {
            let [low, high] = [-step, step].map(|by| parameters[place] + by);
            let is_within = low < 0.0 && high > 0.0;
            // A power of a parameter is largest at an end, or infinite at zero.
            let at = |value: f64| {
                let mut moved = parameters.to_vec();
                moved[place] = value;
                third.value(&moved).abs()
            };
            let at_zero = if is_within { at(0.0) } else { 0.0 };
            at(low).max(at(high)).max(at_zero)
        };
        let values = [self, &first, &second].map(|factor| factor.value(parameters));
        [values[0], values[1], 0.5 * values[2], largest * step * step * step / 6.0]
    }

    /// The parameters that it depends on, by their places.
    pub fn parameters(&self) -> impl Iterator<Item = usize> + '_ {
        self.powers.iter().map(|(place, _)| *place)
    }

    /// As it is written in jobs.
    #[must_use]
    pub fn to_text(&self, names: &[impl AsRef<str>]) -> String {
        Written { factor: self, names: names.iter().map(AsRef::as_ref).collect() }.to_string()
    }
}

struct Written<'a> {
    factor: &'a Factor,
    names: Vec<&'a str>,
}

impl fmt::Display for Written<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut is_first = self.factor.number.abs() == 1.0 && self.factor.powers.iter().any(|(_, power)| *power > 0);
        if is_first {
            f.write_str(if self.factor.number < 0.0 { "-" } else { "" })?;
        } else {
            write!(f, "{}", self.factor.number)?;
        }
        let mut powers = self.factor.powers.clone();
        powers.sort_by_key(|(place, power)| (*power < 0, *place));
        for (place, power) in powers {
            let sign = if power > 0 { " * " } else { " / " };
            if !is_first {
                f.write_str(sign)?;
            }
            is_first = false;
            f.write_str(self.names[place])?;
            if power.abs() > 1 {
                write!(f, "^{}", power.abs())?;
            }
        }
        Ok(())
    }
}

/// The number or name that a text begins with, and the rest.
fn word(text: &str) -> Option<(&str, &str)> {
    let is_number = text.starts_with(|c: char| c.is_ascii_digit() || c == '.' || c == '-' || c == '+');
    let end = if is_number {
        let mut before = ' ';
        let belongs = |(i, c): (usize, char)| {
            let is_sign = (c == '-' || c == '+') && (i == 0 || before == 'e' || before == 'E');
            before = c;
            !(c.is_ascii_digit() || c == '.' || c == 'e' || c == 'E' || is_sign)
        };
        text.char_indices().position(belongs)
    } else {
        if !text.starts_with(|c: char| c.is_alphabetic() || c == '_') {
            return None;
        }
        text.find(|c: char| !(c.is_alphanumeric() || c == '_'))
    };
    let end = end.unwrap_or(text.len());
    Some((&text[..end], text[end..].trim_start()))
}

/// The power that a text begins with, 1 if it has none, and the rest.
fn power(text: &str) -> Result<(i32, &str), FactorError> {
    let Some(after) = text.strip_prefix('^').or_else(|| text.strip_prefix("**")) else { return Ok((1, text)) };
    let after = after.trim_start();
    let end = after
        .char_indices()
        .find(|(i, c)| !(c.is_ascii_digit() || *i == 0 && *c == '-'))
        .map_or(after.len(), |(i, _)| i);
    let power: Option<i32> = after[..end].parse().ok().filter(|power: &i32| power.abs() <= LARGEST_POWER);
    let is_whole = !after[end..].starts_with('.');
    let wrong = || FactorError::Power(after.split_whitespace().next().unwrap_or_default().to_owned());
    Ok((power.filter(|_| is_whole).ok_or_else(wrong)?, after[end..].trim_start()))
}

fn unexpected_or_end(rest: &str) -> FactorError {
    match rest.chars().next() {
        None => FactorError::Incomplete,
        Some(c) => FactorError::Unexpected { found: c.to_string() },
    }
}

fn integer_power(value: f64, power: i32) -> f64 {
    let magnitude = (0..power.unsigned_abs()).fold(1.0, |product, _| product * value);
    if power < 0 { 1.0 / magnitude } else { magnitude }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NAMES: [&str; 3] = ["friction", "speed", "e_lining"];

    #[test]
    fn products_of_powers_are_read_and_written() {
        let values = [0.4, 12.0, 3.0];
        for (text, value, written) in [
            ("friction", 0.4, "friction"),
            ("1/speed", 1.0 / 12.0, "1 / speed"),
            ("speed^2", 144.0, "speed^2"),
            ("speed**2", 144.0, "speed^2"),
            ("friction * e_lining", 0.4 * 3.0, "friction * e_lining"),
            ("2.5e-1*friction/speed / speed", 0.25 * 0.4 / 144.0, "0.25 * friction / speed^2"),
            ("-friction", -0.4, "-friction"),
            ("- 1 / speed", -1.0 / 12.0, "-1 / speed"),
            ("-1 * friction", -0.4, "-friction"),
            ("-2 * friction", -0.8, "-2 * friction"),
            ("speed^-1", 1.0 / 12.0, "1 / speed"),
            ("friction / friction", 1.0, "1"),
            ("1 / 1600", 1.0 / 1600.0, "0.000625"),
            ("1e3", 1000.0, "1000"),
        ] {
            let factor = Factor::parse(text, &NAMES).unwrap();
            assert!((factor.value(&values) / value - 1.0).abs() < 1e-15, "{text} {}", factor.value(&values));
            assert_eq!(factor.to_text(&NAMES), written);
            assert_eq!(Factor::parse(written, &NAMES).unwrap(), factor);
        }
    }

    #[test]
    fn a_series_is_off_by_no_more_than_it_says_and_not_by_much_less() {
        let values = [0.4, 12.0, -3.0_f64];
        let mut inexact = 0;
        for text in
            ["friction", "3", "friction * e_lining^3 / speed^9", "2 / speed", "speed^2", "e_lining^4", "friction^-3"]
        {
            let factor = Factor::parse(text, &NAMES).unwrap();
            for (place, value) in values.into_iter().enumerate() {
                for step in [0.0, 0.01 * value.abs(), 0.2 * value.abs()] {
                    let [a, b, c, most] = factor.series(&values, place, step);
                    let off = (-10..=10).map(|part| {
                        let by = step * f64::from(part) / 10.0;
                        let mut moved = values;
                        moved[place] += by;
                        (factor.value(&moved) - (a + by * (b + by * c))).abs()
                    });
                    let off = off.fold(0.0, f64::max);
                    let size = factor.value(&values).abs();
                    assert!(off <= most + 1e-14 * size, "{text} {place} {step}: {off} {most}");
                    assert!(most <= 12.0 * off + 1e-14 * size, "{text} {place} {step}: {off} {most}");
                    inexact += usize::from(most > 0.0);
                }
            }
        }
        assert_eq!(inexact, 10);
        let through_zero = |text: &str| Factor::parse(text, &NAMES).unwrap().series(&[0.1, 1.0, 1.0], 0, 0.2)[3];
        assert_eq!(through_zero("1 / friction"), f64::INFINITY);
        assert!((through_zero("friction^4") - 4.0 * 0.3 * 0.008).abs() < 1e-15);
    }

    #[test]
    fn what_is_no_product_is_refused() {
        for (text, message) in [
            ("frction", "there is no parameter `frction`"),
            ("friction + speed", "`+` has no place here"),
            ("sin(speed)", "there is no parameter `sin`"),
            ("speed^0.5", "the power `0.5` is no integer"),
            ("speed^99", "the power `99` is no integer"),
            ("speed *", "the factor ends"),
            ("", "the factor ends"),
            ("1.2.3", "`1.2.3` is no finite number"),
            ("1/0", "is no finite number"),
            ("-", "the factor ends"),
            ("(friction)", "`(` has no place here"),
            ("friction \u{d7} speed", "`\u{d7}` has no place here"),
        ] {
            let error = Factor::parse(text, &NAMES).unwrap_err().to_string();
            assert!(error.contains(message), "{text}: {error}");
        }
    }
}
