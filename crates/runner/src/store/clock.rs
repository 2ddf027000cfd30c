//! Times in words.

use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// Time from 1970 to the year 10000, which has too many digits.
const YEAR_10000: Duration = Duration::from_secs(253_402_300_800);

/// A time in words. A clock that was never set may be before 1970, or far in the future.
pub fn in_words(time: SystemTime) -> String {
    match time.duration_since(UNIX_EPOCH) {
        Ok(since) if since < YEAR_10000 => humantime::format_rfc3339_seconds(time).to_string(),
        Ok(_) => "unknown, the clock is after the year 9999".to_owned(),
        Err(_) => "unknown, the clock is before 1970".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clock_that_is_wrong_is_said_in_words() {
        assert_eq!(in_words(UNIX_EPOCH), "1970-01-01T00:00:00Z");
        assert_eq!(in_words(UNIX_EPOCH + YEAR_10000 - Duration::from_secs(1)), "9999-12-31T23:59:59Z");
        assert_eq!(in_words(UNIX_EPOCH + YEAR_10000), "unknown, the clock is after the year 9999");
        assert_eq!(in_words(UNIX_EPOCH - Duration::from_secs(1)), "unknown, the clock is before 1970");
    }
}
