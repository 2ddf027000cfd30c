//! `run.json`: what may differ between runs of one job, such as time, host, number of threads and build.

use std::fs;
use std::path::Path;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

use crate::evaluate::sums::Lookups;
use crate::failure::Failure;
use crate::files::publish::publish;

/// Time from 1970 to the year 10000, which has too many digits.
const YEAR_10000: Duration = Duration::from_secs(253_402_300_800);

/// One session of work on a run.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Session {
    command: String,
    started: String,
    seconds: f64,
    outcome: String,
    samples_computed: u64,
    #[serde(flatten, default)]
    maps: Option<MapUse>,
    #[serde(flatten, default)]
    lookups: Option<Lookups>,
    threads: usize,
    host: String,
    version: String,
    build: String,
    #[serde(skip, default = "Instant::now")]
    clock: Instant,
}

/// The verdict maps that a run used.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct MapUse {
    map_tiles: u64,
    /// Simulations of this session only.
    map_simulations: u64,
    /// Whether the maps were given up, as they would have cost more than simulating the samples.
    #[serde(default)]
    map_given_up: bool,
}

#[derive(Debug, Default, Serialize, Deserialize)]
struct Record {
    sessions: Vec<Session>,
}

/// A time in words. A clock that was never set may be before 1970, or far in the future.
fn in_words(time: SystemTime) -> String {
    match time.duration_since(UNIX_EPOCH) {
        Ok(since) if since < YEAR_10000 => humantime::format_rfc3339_seconds(time).to_string(),
        Ok(_) => "unknown, the clock is after the year 9999".to_owned(),
        Err(_) => "unknown, the clock is before 1970".to_owned(),
    }
}

impl Session {
    /// Starts a session.
    pub fn start(command: &str, threads: usize) -> Self {
        Self {
            command: command.to_owned(),
            started: in_words(SystemTime::now()),
            seconds: 0.0,
            outcome: String::new(),
            samples_computed: 0,
            maps: None,
            lookups: None,
            threads,
            host: gethostname::gethostname().to_string_lossy().into_owned(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            build: format!(
                "{} for {}",
                if cfg!(debug_assertions) { "debug" } else { "release" },
                std::env::consts::ARCH
            ),
            clock: Instant::now(),
        }
    }

    /// Records the tiles of the verdict maps, the simulations that this session made for them, and whether they were
    /// given up.
    pub fn maps(&mut self, map_tiles: u64, map_simulations: u64, map_given_up: bool) {
        self.maps = Some(MapUse { map_tiles, map_simulations, map_given_up });
    }

    /// Records how many samples of the run were simulated and audited, if it uses verdict maps.
    pub fn lookups(&mut self, lookups: Lookups) {
        self.lookups = self.maps.map(|_| lookups);
    }

    /// Appends the finished session to `run.json`. A file that cannot be read is replaced, as nothing depends on it.
    pub fn record(mut self, directory: &Path, outcome: &str, samples: u64) -> Result<(), Failure> {
        self.seconds = self.clock.elapsed().as_secs_f64();
        self.outcome = outcome.to_owned();
        self.samples_computed = samples;
        let path = directory.join("run.json");
        let mut record: Record =
            fs::read(&path).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok()).unwrap_or_default();
        record.sessions.push(self);
        let text = serde_json::to_string_pretty(&record).map_err(|error| Failure::writing(&path, error))?;
        publish(directory, "run.json", (text + "\n").as_bytes())
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
