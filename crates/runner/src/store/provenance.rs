//! `run.json`: what may differ between runs of one job, such as time, host, number of threads and build.

use std::time::{Instant, SystemTime};

use serde::{Deserialize, Serialize};

use crate::evaluate::sums::Lookups;
use crate::failure::Failure;
use crate::files::folder::host;
use crate::store::clock::in_words;
use crate::store::directory::RunDirectory;
use crate::store::layout::RECORD;
use crate::version;

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
    commit: String,
    target: String,
    instruction_set: String,
    #[serde(skip, default = "Instant::now")]
    clock: Instant,
}

/// The verdict maps that a run used.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct MapUse {
    map_tiles: u64,
    /// Simulations of this session only.
    map_simulations: u64,
}

#[derive(Debug, Default, Serialize, Deserialize)]
struct Record {
    sessions: Vec<Session>,
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
            host: host(),
            version: version::VERSION.to_owned(),
            build: format!(
                "{} for {}",
                if cfg!(debug_assertions) { "debug" } else { "release" },
                std::env::consts::ARCH
            ),
            commit: version::COMMIT.to_owned(),
            target: version::TARGET.to_owned(),
            instruction_set: version::instruction_set().to_owned(),
            clock: Instant::now(),
        }
    }

    /// Records the tiles of the verdict maps, and the simulations that this session made for them.
    pub fn maps(&mut self, map_tiles: u64, map_simulations: u64) {
        self.maps = Some(MapUse { map_tiles, map_simulations });
    }

    /// Records how many samples of the run were simulated and audited, if it uses verdict maps.
    pub fn lookups(&mut self, lookups: Lookups) {
        self.lookups = self.maps.map(|_| lookups);
    }

    /// Appends the finished session to `run.json`. Nothing depends on that file: one that is damaged is set aside.
    pub fn record(mut self, directory: &RunDirectory, outcome: &str, samples: u64) -> Result<(), Failure> {
        self.seconds = self.clock.elapsed().as_secs_f64();
        self.outcome = outcome.to_owned();
        self.samples_computed = samples;
        let path = directory.path().join(RECORD);
        let mut record =
            match directory.read_known(RECORD).and_then(|bytes| bytes.map(|bytes| read(&bytes)).transpose()) {
                Ok(record) => record.unwrap_or_default(),
                Err(why) => {
                    directory.set_aside(directory.root(), RECORD.as_ref(), &why);
                    Record::default()
                }
            };
        record.sessions.push(self);
        let text = serde_json::to_string_pretty(&record).map_err(|error| Failure::writing(&path, error))?;
        directory.publish(RECORD, (text + "\n").as_bytes())
    }
}

/// The sessions of a run, as far as `run.json` can be read.
fn sessions(directory: &RunDirectory) -> Vec<Session> {
    let read = directory.read_known(RECORD).ok().flatten().and_then(|bytes| read(&bytes).ok());
    read.unwrap_or_default().sessions
}

/// When the session began that finished a run, and its command.
pub fn finished(directory: &RunDirectory) -> Option<String> {
    let session = sessions(directory).into_iter().rfind(|session| session.outcome == "finished")?;
    Some(format!("{}, by {}", session.started, session.command))
}

/// The programs that computed a run, each once, as far as `run.json` says.
pub fn programs(directory: &RunDirectory) -> Vec<String> {
    let mut programs = Vec::new();
    for Session { version, commit, target, instruction_set, .. } in sessions(directory) {
        let program = format!("stickslip {version}, commit {commit}, {target}, {instruction_set}");
        if !programs.contains(&program) {
            programs.push(program);
        }
    }
    programs
}

/// Whether bytes are those of such a file.
pub fn is_record(bytes: &[u8]) -> bool {
    serde_json::from_slice::<Record>(bytes).is_ok()
}

fn read(bytes: &[u8]) -> Result<Record, String> {
    serde_json::from_slice(bytes).map_err(|error| error.to_string())
}
