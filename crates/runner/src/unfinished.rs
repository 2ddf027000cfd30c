//! The temporary files and directories of this process, so that a signal can remove them.

use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};
use std::thread;
use std::time::{Duration, Instant};

/// The temporary files and directories that exist now.
static FILES: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Time between two attempts to get hold of the list.
const PAUSE: Duration = Duration::from_millis(5);

/// A temporary file or directory. The owner of this renames or removes it before this is dropped.
#[derive(Debug)]
pub struct Unfinished(PathBuf);

impl Drop for Unfinished {
    fn drop(&mut self) {
        lock().remove(&self.0);
    }
}

/// Creates a temporary file or directory. `create` returns it with its path.
pub fn create<T>(create: impl FnOnce() -> io::Result<(T, PathBuf)>) -> io::Result<(Unfinished, T)> {
    // No file is created while the others are removed.
    let mut files = lock();
    let (file, path) = create()?;
    files.insert(path.clone());
    Ok((Unfinished(path), file))
}

/// Removes all temporary files and directories. None is created as long as the caller holds what is returned. Gives up after a time, as
/// creating a file on a file system that does not answer has no end.
pub fn remove_all(patience: Duration) -> Option<impl Drop> {
    let started = Instant::now();
    let files = loop {
        match FILES.try_lock() {
            Ok(files) => break files,
            Err(TryLockError::Poisoned(files)) => break files.into_inner(),
            Err(TryLockError::WouldBlock) if started.elapsed() >= patience => return None,
            Err(TryLockError::WouldBlock) => thread::sleep(PAUSE),
        }
    };
    for path in files.iter() {
        // It may have its final name by now; and nothing is left to report a failure to.
        let _ = if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) };
    }
    Some(files)
}

/// Locks the list. A thread that panicked while it held it has not left it half done.
fn lock() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    FILES.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Set in the process that removes everything that is unfinished in it, which would disturb other tests.
    const ALONE: &str = "STICKSLIP_REMOVES_UNFINISHED";

    #[test]
    fn a_file_is_removed_as_long_as_it_is_unfinished() {
        if std::env::var_os(ALONE).is_none() {
            let mut child = std::process::Command::new(std::env::current_exe().unwrap());
            let name = "unfinished::tests::a_file_is_removed_as_long_as_it_is_unfinished";
            let output = child.args(["--exact", name]).env(ALONE, "1").output().unwrap();
            let said = String::from_utf8_lossy(&output.stdout).into_owned();
            assert!(output.status.success() && said.contains("1 passed"), "{said}");
            return;
        }
        let directory = tempfile::tempdir().unwrap();
        let paths = ["one", "two"].map(|name| directory.path().join(name));
        let created = |path: &PathBuf| create(|| Ok((fs::File::create(path)?, path.clone()))).unwrap();
        let [one, two] = [&paths[0], &paths[1]].map(created);
        drop(one);
        let folder = directory.path().join("folder");
        let filled = || fs::create_dir(&folder).and_then(|()| fs::write(folder.join("file"), "text"));
        let three = create(|| Ok((filled()?, folder.clone()))).unwrap();
        let held = remove_all(Duration::from_secs(10));
        assert!(held.is_some() && paths[0].exists() && !paths[1].exists() && !folder.exists());
        assert!(remove_all(Duration::from_millis(20)).is_none(), "the list is held");
        drop(held);
        drop((two, three));
    }
}
