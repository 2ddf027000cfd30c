//! How long the rest of a computation takes, from what is done of it.

use std::fmt;

/// Windows of time whose rates are kept.
const MOST_WINDOWS: usize = 64;

/// Length of the first windows in seconds. It doubles whenever there are too many.
const FIRST_WINDOW: f64 = 0.1;

/// Groups of windows whose rates are compared.
const GROUPS: usize = 8;

/// Standard errors between an estimate and its bounds.
const BOUNDS: f64 = 2.0;

/// Largest relative distance of bounds from an estimate that is shown without them.
const CLOSE: f64 = 0.3;

/// Largest relative distance of bounds from an estimate that is shown at all.
const WIDEST: f64 = 2.5;

/// A prediction of a time in seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Prediction {
    /// Too little is known.
    Unknown,
    /// At least this long: more may have to be done than is known of.
    AtLeast(f64),
    /// Between these two.
    Between(f64, f64),
    /// About this long.
    About(f64),
}

impl Prediction {
    /// A prediction from the time that some work takes at a mean rate, and the relative standard error of the rate.
    pub fn from_rate(seconds: f64, relative_error: f64) -> Self {
        let distance = BOUNDS * relative_error;
        if distance <= CLOSE {
            Self::About(seconds)
        } else if distance <= WIDEST {
            // Times differ by factors.
            Self::Between(seconds / (1.0 + distance), seconds * (1.0 + distance))
        } else {
            Self::Unknown
        }
    }

    /// As one number, if anything is known.
    pub fn seconds(self) -> Option<f64> {
        match self {
            Self::Unknown => None,
            Self::AtLeast(seconds) | Self::About(seconds) => Some(seconds),
            Self::Between(low, high) => Some((low * high).sqrt()),
        }
    }

    /// The least and the largest that it probably is, if both are known.
    pub fn bounds(self) -> Option<[f64; 2]> {
        match self {
            Self::Unknown | Self::AtLeast(_) => None,
            Self::Between(low, high) => Some([low, high]),
            Self::About(seconds) => Some([seconds / (1.0 + CLOSE), seconds * (1.0 + CLOSE)]),
        }
    }

    /// The same as a lower bound only.
    pub fn at_least(self) -> Self {
        match self {
            Self::Unknown => Self::Unknown,
            Self::AtLeast(low) | Self::Between(low, _) | Self::About(low) => Self::AtLeast(low),
        }
    }
}

impl fmt::Display for Prediction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown => f.write_str("an unknown time"),
            Self::AtLeast(low) => write!(f, "at least {}", Duration(*low)),
            Self::Between(low, high) => {
                let (low, high) = (Duration(*low).to_string(), Duration(*high).to_string());
                // "about 2 to 3 minutes", but "about 50 seconds to 2 minutes".
                let same_unit = low.split_once(' ').filter(|(_, unit)| high.ends_with(unit));
                write!(f, "about {} to {high}", same_unit.map_or(&low[..], |(number, _)| number))
            }
            Self::About(seconds) => write!(f, "about {}", Duration(*seconds)),
        }
    }
}

/// A time in seconds, in words with two significant digits.
pub struct Duration(pub f64);

impl fmt::Display for Duration {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const UNITS: [(f64, &str); 5] =
            [(365.25 * 86_400.0, "years"), (86_400.0, "days"), (3600.0, "hours"), (60.0, "minutes"), (1.0, "seconds")];
        let unit = UNITS.into_iter().find(|(length, _)| self.0 >= 1.5 * length);
        let (length, name) = unit.unwrap_or((1.0, "seconds"));
        let value = self.0 / length;
        if value < 0.95 {
            write!(f, "{:.2} {name}", value.max(0.01))
        } else if value < 9.5 {
            let text = format!("{value:.1}");
            let text = text.strip_suffix(".0").unwrap_or(&text);
            let name = if text == "1" { name.trim_end_matches('s') } else { name };
            write!(f, "{text} {name}")
        } else {
            write!(f, "{value:.0} {name}")
        }
    }
}

/// Measures the rate of some work, and how much it varies.
///
/// The work is done in an order that spreads over the whole of it, so that the mean rate up to now is that of the rest.
#[derive(Debug, Clone)]
pub struct RateMeter {
    /// The amount of work done in each window.
    windows: Vec<f64>,
    /// Length of a window in seconds.
    width: f64,
    /// When the last window ended, and what was done by then.
    seconds: f64,
    done: f64,
}

impl RateMeter {
    /// A meter at time 0.
    pub fn new() -> Self {
        Self { windows: Vec::new(), width: FIRST_WINDOW, seconds: 0.0, done: 0.0 }
    }

    /// Records how much is done after some seconds. Both only grow.
    pub fn record(&mut self, seconds: f64, done: f64) {
        // Windows that have passed without a record share the work evenly.
        let passed = ((seconds - self.seconds) / self.width).floor();
        if passed < 1.0 {
            return;
        }
        let each = (done - self.done) * self.width / (seconds - self.seconds);
        for _ in 0..(passed as usize).min(MOST_WINDOWS) {
            self.windows.push(each);
        }
        self.done += each * passed;
        self.seconds += self.width * passed;
        while self.windows.len() >= MOST_WINDOWS {
            self.windows = self.windows.chunks_exact(2).map(|pair| pair[0] + pair[1]).collect();
            self.width *= 2.0;
        }
    }

    /// How long an amount of work takes that is left after `seconds`, in which `done` was done.
    pub fn time_left(&self, seconds: f64, done: f64, left: f64) -> Prediction {
        match self.relative_error() {
            Some(error) if done > 0.0 => Prediction::from_rate(left * seconds / done, error),
            _ => Prediction::Unknown,
        }
    }

    /// The relative standard error of the mean rate, from the rates in groups of windows; `None` if there are too few.
    pub fn relative_error(&self) -> Option<f64> {
        let of_a_group = self.windows.len() / GROUPS;
        if of_a_group == 0 {
            return None;
        }
        let mut rates = Mean::default();
        self.windows.chunks_exact(of_a_group).take(GROUPS).for_each(|group| rates.add(group.iter().sum()));
        Some(rates.relative_error())
    }
}

/// The mean of some values and its error.
#[derive(Debug, Clone, Copy, Default)]
pub struct Mean {
    count: u64,
    sum: f64,
    squares: f64,
}

impl Mean {
    /// Adds a value.
    pub fn add(&mut self, value: f64) {
        self.count += 1;
        self.sum += value;
        self.squares += value * value;
    }

    /// The number of values.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The sum of the values.
    pub fn sum(&self) -> f64 {
        self.sum
    }

    /// The standard error of the mean over the mean; infinite if it is not known.
    pub fn relative_error(&self) -> f64 {
        let count = self.count as f64;
        let mean = self.sum / count;
        let variance = (self.squares / count - mean * mean).max(0.0) * count / (count - 1.0);
        let error = (variance / count).sqrt() / mean;
        if error.is_finite() { error } else { f64::INFINITY }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_predicted_from_nothing() {
        let mut meter = RateMeter::new();
        assert_eq!(meter.time_left(0.0, 0.0, 1e9), Prediction::Unknown);
        meter.record(0.3, 100.0);
        assert_eq!(meter.time_left(0.3, 100.0, 1e9), Prediction::Unknown);
        // An hour without anything done.
        meter.record(3600.0, 0.0);
        assert_eq!(RateMeter::new().time_left(3600.0, 0.0, 1e9), Prediction::Unknown);
    }

    #[test]
    fn a_steady_rate_predicts_a_number() {
        let mut meter = RateMeter::new();
        for tick in 1..=10_000 {
            let seconds = 0.05 * f64::from(tick);
            meter.record(seconds, 200.0 * seconds);
        }
        assert!(meter.windows.len() <= MOST_WINDOWS);
        let Prediction::About(seconds) = meter.time_left(500.0, 100_000.0, 50_000.0) else { panic!("not a number") };
        assert!((seconds - 250.0).abs() < 1e-6, "{seconds}");
    }

    #[test]
    fn an_unsteady_rate_predicts_a_range() {
        // The rate changes by a factor of five from one second to the next.
        let mut meter = RateMeter::new();
        let mut done = 0.0;
        for tick in 1..=80 {
            done += if tick / 10 % 2 == 0 { 1.0 } else { 5.0 };
            meter.record(0.1 * f64::from(tick), done);
        }
        let prediction = meter.time_left(8.0, done, done);
        assert!(matches!(prediction, Prediction::Between(low, high) if low < 8.0 && high > 8.0), "{prediction:?}");
        // All of it was done in the first second.
        let mut meter = RateMeter::new();
        (1..=80).for_each(|tick| meter.record(0.1 * f64::from(tick), 100.0));
        let prediction = meter.time_left(8.0, 100.0, 100.0);
        assert!(matches!(prediction, Prediction::Between(low, high) if low < 4.0 && high > 16.0), "{prediction:?}");
    }

    #[test]
    fn only_what_may_be_more_is_a_lower_bound() {
        for error in [0.0, 0.1, 0.3, 1.0, 1.25] {
            let prediction = Prediction::from_rate(10.0, error);
            assert!(matches!(prediction, Prediction::About(_) | Prediction::Between(..)), "{error}: {prediction:?}");
            assert!((prediction.seconds().unwrap() - 10.0).abs() < 1e-9);
            assert!(prediction.bounds().is_some_and(|[low, high]| low < 10.0 && 10.0 < high));
            assert!(matches!(prediction.at_least(), Prediction::AtLeast(low) if low <= 10.0));
            assert_eq!(prediction.at_least().bounds(), None);
        }
        assert_eq!(Prediction::from_rate(10.0, 2.0), Prediction::Unknown);
        assert_eq!(Prediction::from_rate(10.0, f64::INFINITY), Prediction::Unknown);
        assert_eq!(Prediction::from_rate(10.0, f64::NAN), Prediction::Unknown);
    }

    #[test]
    fn a_range_names_its_unit_once() {
        assert_eq!(Prediction::Between(120.0, 200.0).to_string(), "about 2 to 3.3 minutes");
        assert_eq!(Prediction::Between(50.0, 200.0).to_string(), "about 50 seconds to 3.3 minutes");
    }

    #[test]
    fn times_are_shown_with_two_digits() {
        let text = |seconds: f64| Duration(seconds).to_string();
        let texts = [0.004, 0.35, 0.97, 1.0, 1.24, 22.4, 89.0, 91.0, 150.0, 700.0, 7000.0, 1e5, 1e6].map(text);
        let expected = [
            "0.01 seconds",
            "0.35 seconds",
            "1 second",
            "1 second",
            "1.2 seconds",
            "22 seconds",
            "89 seconds",
            "1.5 minutes",
            "2.5 minutes",
            "12 minutes",
            "1.9 hours",
            "28 hours",
            "12 days",
        ];
        assert_eq!(texts, expected);
    }
}
