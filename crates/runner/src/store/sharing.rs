//! How a run is shared among processes: in how many shards, and at which of them processes are at work.

use std::ffi::OsString;
use std::fmt;
use std::fs::{File, TryLockError};
use std::io::{self, Write as _};
use std::path::Path;
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
    run: Folder,
    folder: Folder,
    name: String,
    /// The lock, which ends with the process.
    _lock: File,
}

impl Drop for AtWork {
    fn drop(&mut self) {
        // At worst, files are left that nobody holds.
        let _ = self.folder.remove(&self.name);
        let _ = self.run.remove_directory(WORKING);
    }
}

impl AtWork {
    /// Begins to work on a shard. If that cannot be noted, only `status` knows less.
    pub fn begin(run: &Path, shard: u64, shards: u64, missing: u128) -> Option<Self> {
        let host = gethostname::gethostname().to_string_lossy().into_owned();
        let run = Folder::open(run).ok()?;
        let folder = run.create_within(WORKING).ok()?;
        let name = format!("{shard}-of-{shards}.{host}.{}", process::id());
        let worker = Worker { shard, shards, host, began: now(), missing: missing as f64 };
        let text = serde_json::to_vec(&worker).ok()?;
        let mut file = folder.create_file(&name).ok()?;
        let at_work = Self { run, folder, name, _lock: file.try_clone().ok()? };
        // A process that looks which shards are at work holds it for an instant.
        file.lock().and_then(|()| file.write_all(&text)).ok()?;
        Some(at_work)
    }
}

/// The processes at work in a run, by shard. Those of machines whose locks are not seen here are left out.
pub fn workers(run: &Path) -> Vec<Worker> {
    let folder = Folder::open(run).and_then(|run| run.within_if_there(WORKING));
    let Some(folder) = folder.ok().flatten() else { return Vec::new() };
    let read = |name: &OsString| -> Option<Worker> {
        // Those that look share the lock, so that they do not take each other for a process at work.
        let is_held = matches!(folder.open_file(name).ok()?.try_lock_shared(), Err(TryLockError::WouldBlock));
        if is_held { serde_json::from_slice(&folder.read(name, MOST).ok()?).ok() } else { None }
    };
    let mut workers: Vec<Worker> = folder.names().iter().flatten().filter_map(read).collect();
    workers.sort_by_key(|worker| worker.shard);
    workers
}

/// Removes what killed processes have left. No other process may work in the run.
pub fn tidy(run: &Path) {
    let removed = || -> io::Result<()> {
        let run = Folder::open(run)?;
        let Some(folder) = run.within_if_there(WORKING)? else { return Ok(()) };
        folder.names()?.iter().try_for_each(|name| folder.remove(name))?;
        run.remove_directory(WORKING)
    };
    // Nothing depends on it.
    let _ = removed();
}

/// Seconds since 1970.
pub fn now() -> f64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |since| since.as_secs_f64())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use std::os::unix::fs::symlink;
    use std::process::Command;

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
    fn what_somebody_else_has_put_there_is_not_followed() {
        let run = tempfile::tempdir().unwrap();
        let mine = run.path().join("mine");
        fs::write(&mine, "precious").unwrap();
        let working = run.path().join(WORKING);
        fs::create_dir(&working).unwrap();
        let host = gethostname::gethostname().to_string_lossy().into_owned();
        let of = |shard: u64| working.join(format!("{shard}-of-2.{host}.{}", process::id()));
        symlink(&mine, of(1)).unwrap();
        assert!(Command::new("mkfifo").arg(of(2)).status().unwrap().success());
        let both = [1, 2].map(|shard| AtWork::begin(run.path(), shard, 2, 10));
        assert!(both.iter().all(Option::is_some) && workers(run.path()).len() == 2);
        drop(both);
        symlink(run.path(), &working).unwrap();
        assert!(AtWork::begin(run.path(), 1, 2, 10).is_none() && workers(run.path()).is_empty());
        tidy(run.path());
        assert_eq!(fs::read_to_string(&mine).unwrap(), "precious");
    }

    #[test]
    fn looks_do_not_take_each_other_for_work() {
        let run = tempfile::tempdir().unwrap();
        fs::create_dir(run.path().join(WORKING)).unwrap();
        let left = run.path().join(WORKING).join("4-of-16.host.1");
        fs::write(&left, r#"{"shard": 4, "shards": 16, "host": "host", "began": 0, "missing": 1}"#).unwrap();
        let other = File::open(&left).unwrap();
        other.lock_shared().unwrap();
        assert!(workers(run.path()).is_empty());
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
