//! Values of options, checked as they are read.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use crate::units::{hundredth, not_a_number};

/// A number.
pub fn number(text: &str) -> Result<f64, String> {
    text.trim().parse().map_err(|_| not_a_number(text.trim()))
}

/// A whole number as a job spec writes it, 10000, 10_000 or 1e4.
pub fn whole_number(text: &str) -> Result<u64, String> {
    /// Beyond this, numbers with a point are not whole numbers one by one.
    const LARGEST: f64 = 9_007_199_254_740_992.0;
    let plain = text.replace('_', "");
    let whole = |number: &f64| (0.0..=LARGEST).contains(number) && number.fract() == 0.0;
    let with_exponent = || plain.parse().ok().filter(whole).map(|number: f64| number as u64);
    let number = plain.parse().ok().or_else(with_exponent);
    number.ok_or_else(|| "write a whole number, for example 10000, 10_000 or 1e4".to_owned())
}

/// A whole number in a range.
pub fn whole_number_in(range: RangeInclusive<u64>) -> impl Fn(&str) -> Result<u64, String> + Clone + Send + Sync {
    move |text: &str| {
        let number = whole_number(text).ok().filter(|number| range.contains(number));
        number.ok_or_else(|| format!("write a whole number from {} to {}", range.start(), range.end()))
    }
}

/// A whole number of things in memory.
pub fn count(text: &str) -> Result<usize, String> {
    usize::try_from(whole_number(text)?).map_err(|_| format!("{text} is too large"))
}

/// A number of threads.
pub fn threads(text: &str) -> Result<u16, String> {
    const MOST: u16 = 1024;
    let threads = text.parse().ok().filter(|threads| (1..=MOST).contains(threads));
    threads.ok_or_else(|| format!("a number of threads is a whole number from 1 to {MOST}, for example 4"))
}

/// A seed in the range that a job spec allows.
pub fn seed(text: &str) -> Result<u64, String> {
    let seed = text.replace('_', "").parse().ok().filter(|&seed: &u64| i64::try_from(seed).is_ok());
    seed.ok_or_else(|| format!("a seed is a whole number from 0 to {} (2^63 - 1)", i64::MAX))
}

/// A probability that may be reached, neither impossible nor certain.
pub fn probability(text: &str) -> Result<f64, String> {
    const RANGE: &str = "a probability is greater than 0 and less than 1, for example 0.01 for 1 %";
    match number(text) {
        Ok(probability) if 0.0 < probability && probability < 1.0 => Ok(probability),
        Ok(percent) if (1.0..100.0).contains(&percent) => {
            Err(format!("{RANGE}; did you mean {} ({percent} %)?", hundredth(percent)))
        }
        Ok(_) => Err(RANGE.to_owned()),
        Err(why) => Err(format!("{why}; {RANGE}")),
    }
}

/// A time since the start of a motion.
pub fn seconds(text: &str) -> Result<f64, String> {
    const FORM: &str = "a time is a number of seconds since the start of the motion, for example 0.002";
    match number(text) {
        Ok(time) if time >= 0.0 && time.is_finite() => Ok(time),
        Ok(_) => Err(FORM.to_owned()),
        Err(why) => Err(format!("{why}; {FORM}")),
    }
}

/// An axis with a value on it.
pub fn axis_value(text: &str) -> Result<(String, f64), String> {
    const FORM: &str = "an axis and a number on it are written as in rotating_speed=15";
    let Some((name, value)) = text.split_once('=') else { return Err(FORM.to_owned()) };
    match number(value) {
        Ok(value) if value.is_finite() => Ok((name.trim().to_owned(), value)),
        Ok(_) => Err(FORM.to_owned()),
        Err(why) => Err(format!("{why}; {FORM}")),
    }
}

/// The path of a file that will be written as Parquet.
pub fn parquet_file(text: &str) -> Result<PathBuf, String> {
    file_named(text, "the file is written as Parquet", &["parquet"])
}

/// The path of a file that will be written as HTML.
pub fn html_file(text: &str) -> Result<PathBuf, String> {
    file_named(text, "a report is written as HTML", &["html"])
}

/// The path of a file that a plot can be written to.
pub fn plot_file(text: &str) -> Result<PathBuf, String> {
    file_named(text, "a plot is written as SVG, PDF or PNG", &["svg", "pdf", "png"])
}

/// A path with one of the extensions. A directory is refused later, with a message of its own.
fn file_named(text: &str, what: &str, extensions: &[&str]) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let is_named = |extension: &&str| path.extension().is_some_and(|found| found.eq_ignore_ascii_case(extension));
    if path.is_dir() || extensions.iter().any(is_named) {
        return Ok(path);
    }
    let names = extensions.iter().map(|extension| path.with_extension(extension).display().to_string());
    Err(format!("{what}; name it {}", names.collect::<Vec<_>>().join(" or ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_typed_in_another_form_is_answered_with_the_right_one() {
        let refused = |text: &str| probability(text).unwrap_err();
        assert!(refused("5").ends_with("; did you mean 0.05 (5 %)?"), "{}", refused("5"));
        assert!(refused("5%").starts_with("5% is in per cent; write 0.05; "), "{}", refused("5%"));
        assert!(refused("0,05").starts_with("0,05 has a decimal comma; write 0.05; "), "{}", refused("0,05"));
        for text in ["0", "-0.1", "100", "nan", "1e-400"] {
            assert_eq!(refused(text), "a probability is greater than 0 and less than 1, for example 0.01 for 1 %");
        }
        let refused = |text: &str| axis_value(text).unwrap_err();
        assert!(refused("rotating_speed=143rpm").contains("143 rpm = 14.974925 rad/s"));
        assert!(refused("preload=").starts_with("there is no number; "), "{}", refused("preload="));
        assert_eq!(refused("preload"), "an axis and a number on it are written as in rotating_speed=15");
        assert_eq!(axis_value(" preload = 0.1 "), Ok(("preload".to_owned(), 0.1)));
        assert!(seconds("0,002").unwrap_err().starts_with("0,002 has a decimal comma; write 0.002; a time is"));
        assert!(seconds("-1").unwrap_err().starts_with("a time is a number of seconds"));
        assert_eq!(seconds("2e-3"), Ok(2e-3));
        let vectors = whole_number_in(1..=400);
        assert_eq!([vectors("1e2"), vectors("4_00")], [Ok(100), Ok(400)]);
        for text in ["0", "401", "-1", "many"] {
            assert_eq!(vectors(text), Err("write a whole number from 1 to 400".to_owned()), "{text}");
        }
        assert_eq!([count("3"), count("1e3")], [Ok(3), Ok(1000)]);
        assert_eq!(number("1e-3"), Ok(1e-3));
    }
}
