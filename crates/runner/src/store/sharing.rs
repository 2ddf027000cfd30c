//! How a run is shared among processes: in how many shards, and at which of them processes are at work.

use std::ffi::OsString;
use std::fmt;
use std::fs::{self, File, TryLockError};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process;
use std::time::{SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

use crate::failure::Failure;
use crate::files::folder::Folder;
use crate::job::MOST_SHARDS;

/// The file that says in how many shards a run is computed.
const RECORD: &str = "engine.json";

/// Largest number of bytes of such a file.
const MOST: u64 = 1 << 16;

/// The folder of the files that processes hold while they work on a shard.
const WORKING: &str = "working";

/// In how many shards a run is computed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sharing {
    /// What runs the shards: slurm or parallel.
    pub engine: String,
    /// Their number.
    pub shards: u64,
}

impl Sharing {
    /// Of the run in a directory, if it is known.
    pub fn read(run: &Path) -> Option<Self> {
        let sharing: Self = serde_json::from_slice(&Folder::open(run).ok()?.read(RECORD, MOST).ok()?).ok()?;
        (1..=MOST_SHARDS).contains(&sharing.shards).then_some(sharing)
    }

    /// Notes it in the directory of a run.
    pub fn record(&self, run: &Path) -> Result<(), Failure> {
        let failed = |error: &dyn fmt::Display| Failure::writing(&run.join(RECORD), error);
        let text = serde_json::to_string(self).map_err(|error| failed(&error))? + "\n";
        Folder::open(run).and_then(|folder| folder.publish(RECORD, text.as_bytes())).map_err(|error| failed(&error))
    }
}

/// A process at work on a shard.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Worker {
    /// The shard, from 1 up, and the number of all.
    pub shard: u64,
    pub shards: u64,
    /// Where it runs.
    pub host: String,
    /// Seconds since 1970 when it began.
    pub began: f64,
    /// Samples of the shard that were missing then, at most.
    pub missing: f64,
}

/// What shows others that this process works on a shard, until it is dropped.
#[derive(Debug)]
pub struct AtWork {
    path: PathBuf,
    /// The lock, which ends with the process.
    _lock: File,
}

impl Drop for AtWork {
    fn drop(&mut self) {
        // At worst, files are left that nobody holds.
        let _ = fs::remove_file(&self.path);
        let _ = self.path.parent().map(fs::remove_dir);
    }
}

impl AtWork {
    /// Begins to work on a shard. If that cannot be noted, only `status` knows less.
    pub fn begin(run: &Path, shard: u64, shards: u64, missing: u128) -> Option<Self> {
        let host = gethostname::gethostname().to_string_lossy().into_owned();
        let folder = Folder::open(run).ok()?.create_within(WORKING).ok()?;
        let path = folder.path().join(format!("{shard}-of-{shards}.{host}.{}", process::id()));
        let worker = Worker { shard, shards, host, began: now(), missing: missing as f64 };
        let text = serde_json::to_vec(&worker).ok()?;
        let mut file = File::create(&path).ok()?;
        // A process that looks which shards are at work holds it for an instant.
        if file.lock().and_then(|()| file.write_all(&text)).is_err() {
            let _ = fs::remove_file(&path);
            return None;
        }
        Some(Self { path, _lock: file })
    }
}

/// The processes at work in a run, by shard. Those of machines whose locks are not seen here are left out.
pub fn workers(run: &Path) -> Vec<Worker> {
    let folder = Folder::open(run).and_then(|run| run.within_if_there(WORKING));
    let Some(folder) = folder.ok().flatten() else { return Vec::new() };
    let read = |name: &OsString| -> Option<Worker> {
        let is_held = matches!(folder.open_file(name).ok()?.try_lock(), Err(TryLockError::WouldBlock));
        if is_held { serde_json::from_slice(&folder.read(name, MOST).ok()?).ok() } else { None }
    };
    let mut workers: Vec<Worker> = folder.names().iter().flatten().filter_map(read).collect();
    workers.sort_by_key(|worker| worker.shard);
    workers
}

/// Removes what killed processes have left. No other process may work in the run.
pub fn tidy(run: &Path) {
    // Nothing depends on it.
    let _ = fs::remove_dir_all(run.join(WORKING));
}

/// Seconds since 1970.
pub fn now() -> f64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |since| since.as_secs_f64())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_process_is_at_work_until_it_ends() {
        let run = tempfile::tempdir().unwrap();
        assert!(workers(run.path()).is_empty());
        let first = AtWork::begin(run.path(), 3, 16, 1000);
        let found = workers(run.path());
        assert_eq!(found.iter().map(|worker| (worker.shard, worker.shards)).collect::<Vec<_>>(), [(3, 16)]);
        drop(first);
        assert!(workers(run.path()).is_empty() && !run.path().join(WORKING).exists());
        // A killed process leaves a file that it no longer holds.
        fs::create_dir(run.path().join(WORKING)).unwrap();
        fs::write(run.path().join(WORKING).join("4-of-16.host.1"), "{}").unwrap();
        assert!(workers(run.path()).is_empty());
        tidy(run.path());
        assert!(!run.path().join(WORKING).exists());
    }

    #[test]
    fn the_number_of_shards_is_kept() {
        let run = tempfile::tempdir().unwrap();
        assert_eq!(Sharing::read(run.path()), None);
        let sharing = Sharing { engine: "slurm".to_owned(), shards: 16 };
        sharing.record(run.path()).unwrap();
        assert_eq!(Sharing::read(run.path()), Some(sharing));
        for shards in [0, MOST_SHARDS + 1, u64::MAX] {
            fs::write(run.path().join(RECORD), format!("{{\"engine\": \"slurm\", \"shards\": {shards}}}")).unwrap();
            assert_eq!(Sharing::read(run.path()), None, "{shards}");
        }
    }
}
