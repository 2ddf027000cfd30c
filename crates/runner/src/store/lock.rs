//! The lock of a run directory: the file `run.lock`, which also says who holds it.
//!
//! A lock ends with the process that holds it, however that ends, so there are no stale ones. It is a file rather than
//! the directory itself, because NFS locks files only.

use std::env;
use std::fmt::Write as _;
use std::fs::{File, TryLockError};
use std::io::{self, Read as _, Write as _};
use std::path::Path;
use std::process;
use std::thread;
use std::time::{Duration, Instant, SystemTime};

use rustix::fs::{AtFlags, Mode, OFlags, fstat, statat};
use rustix::io::Errno;

use crate::failure::Failure;
use crate::files::folder::{Folder, host};
use crate::output::note;
use crate::store::clock::in_words;

/// The name of the file.
pub const LOCK: &str = "run.lock";

/// Others hold the lock for an instant when they look whether it is held.
pub const AN_INSTANT: Duration = Duration::from_millis(200);

/// Time between two tries.
const PAUSE: Duration = Duration::from_millis(20);

/// Looks whether the lock is held, and the time by which each gap between two is longer than the one before.
const LOOKS: u32 = 6;
const GAP: Duration = Duration::from_millis(2);

/// Waiting longer than this is announced.
const SILENCE: Duration = Duration::from_secs(1);

/// Largest number of bytes of the file that are read.
const MOST: u64 = 1 << 16;

/// How a process works in a run directory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Access {
    /// Alone. It may remove unfinished files, change the job and write the surface.
    Alone,
    /// Beside others, as a shard, which only adds pieces.
    Shared,
    /// Beside others. It reads, and needs no right to write.
    Reading,
}

/// A lock that is held.
#[derive(Debug)]
pub struct Lock {
    file: File,
    access: Access,
    /// Whether it is certain to keep others out, those on other machines included.
    is_certain: bool,
}

impl Lock {
    /// Takes the lock of a run directory, and waits up to `patience` for it. Returns `None` where the file system has
    /// none.
    ///
    /// Without locks, pieces are safe: they are whole files with names of their own, and are counted once. At worst,
    /// work is done twice.
    pub fn acquire(folder: &Folder, access: Access, patience: Duration) -> Result<Option<Self>, Failure> {
        let started = Instant::now();
        let mut is_announced = patience <= SILENCE;
        loop {
            let Some(file) = open(folder, access)? else { return Ok(None) };
            let tried = match access {
                Access::Alone => file.try_lock(),
                Access::Shared | Access::Reading => file.try_lock_shared(),
            };
            match tried {
                Ok(()) if is_the_file(folder, &file)? => {
                    let lock = Self { is_certain: is_certain(folder), access, file };
                    lock.sign(access);
                    return Ok(Some(lock));
                }
                // The file was removed meanwhile: the lock is that of a new one.
                Ok(()) => {}
                Err(TryLockError::WouldBlock) if started.elapsed() >= patience => {
                    return Err(in_use(folder, "is in use"));
                }
                Err(TryLockError::WouldBlock) => {
                    if !is_announced && started.elapsed() >= SILENCE {
                        is_announced = true;
                        note(format_args!(
                            "waiting up to {} s for {} to end",
                            (patience - started.elapsed().min(patience)).as_secs(),
                            holders(folder)
                        ));
                    }
                    thread::sleep(PAUSE);
                }
                Err(TryLockError::Error(error)) => {
                    note(format_args!(
                        "note: {} cannot be locked ({error}); make sure that no other stickslip works in it",
                        folder.path().display()
                    ));
                    return Ok(None);
                }
            }
        }
    }

    /// Lets shards in. Others may get the lock first.
    pub fn share(self, folder: &Folder) -> Result<Option<Self>, Failure> {
        // It signs again.
        let _ = self.file.set_len(0);
        drop(self.file);
        Self::acquire(folder, Access::Shared, Duration::from_secs(60))
    }

    /// Whether it is certain to keep all others out.
    pub fn is_alone(&self) -> bool {
        self.is_certain && self.access == Access::Alone
    }

    /// Writes who holds it. Nothing depends on it but messages.
    fn sign(&self, access: Access) {
        if access == Access::Reading {
            return;
        }
        let since = in_words(SystemTime::now());
        let call = call();
        let line = format!("{} {} {since} {call}\n", process::id(), host());
        if access == Access::Alone {
            let _ = self.file.set_len(0);
        }
        let _ = (&self.file).write_all(line.as_bytes());
    }
}

/// Whether a process works in a run directory. Another one that looks holds the lock for an instant, too; what is held at
/// every one of several looks is held for work.
pub fn is_held(folder: &Folder) -> bool {
    let Some(file) = folder.open_if_there(LOCK).ok().flatten() else { return false };
    let mut looks = (0..LOOKS).map(|look| {
        thread::sleep(GAP * look);
        matches!(file.try_lock(), Err(TryLockError::WouldBlock))
    });
    looks.all(|is_held| is_held)
}

/// Opens the file of the lock, and creates it if it is not there. `None` if it need not be there for reading.
fn open(folder: &Folder, access: Access) -> Result<Option<File>, Failure> {
    let flags = OFlags::RDWR | OFlags::APPEND | OFlags::NOFOLLOW | OFlags::NONBLOCK | OFlags::CLOEXEC;
    let mode = Mode::RUSR | Mode::WUSR | Mode::RGRP | Mode::WGRP | Mode::ROTH | Mode::WOTH;
    let created = match access {
        Access::Reading => OFlags::empty(),
        Access::Alone | Access::Shared => OFlags::CREATE,
    };
    let opened = match rustix::fs::openat(folder.handle(), LOCK, flags | created, mode) {
        Ok(file) => Ok(Some(File::from(file))),
        // It belongs to somebody else, who does not let others write it. To lock it, reading is enough.
        Err(Errno::ACCESS | Errno::ROFS | Errno::PERM) => folder.open_if_there(LOCK),
        Err(Errno::NOENT) if access == Access::Reading => return Ok(None),
        Err(error) => Err(error.into()),
    };
    let path = folder.path().join(LOCK);
    let move_it = "move it elsewhere when no stickslip works here";
    match opened {
        Ok(Some(file)) if file.metadata().is_ok_and(|metadata| metadata.is_file()) => Ok(Some(file)),
        Ok(None) if access == Access::Reading => Ok(None),
        Ok(None) => Err(Failure::creating(&path, "permission denied")),
        Ok(Some(_)) => Err(Failure::creating(&path, format!("it is not an ordinary file; {move_it}"))),
        Err(error) if error.raw_os_error() == Some(Errno::LOOP.raw_os_error()) => {
            Err(Failure::creating(&path, format!("it is a link; {move_it}")))
        }
        Err(error) if error.kind() == io::ErrorKind::IsADirectory => {
            Err(Failure::creating(&path, format!("it is a directory; {move_it}")))
        }
        Err(error) => Err(Failure::creating(&path, error)),
    }
}

/// Whether an open file is still the one of its name.
fn is_the_file(folder: &Folder, file: &File) -> Result<bool, Failure> {
    let there = match statat(folder.handle(), LOCK, AtFlags::SYMLINK_NOFOLLOW) {
        Err(Errno::NOENT) => return Ok(false),
        there => there,
    };
    let same =
        there.and_then(|there| fstat(file).map(|file| (file.st_dev, file.st_ino) == (there.st_dev, there.st_ino)));
    same.map_err(|error| Failure::creating(&folder.path().join(LOCK), io::Error::from(error)))
}

/// Whether the file system passes locks on to other machines, as far as its kind shows.
#[cfg(target_os = "linux")]
fn is_certain(folder: &Folder) -> bool {
    /// FUSE (sshfs), SMB, CIFS, 9P.
    const LOCAL_LOCKS: [u64; 4] = [0x6573_5546, 0xfe53_4d42, 0xff53_4d42, 0x0102_1997];
    /// NFS: locks hold unless they are turned off for a mount.
    const NFS: u64 = 0x6969;
    let kind = rustix::fs::fstatfs(folder.handle()).map_or(0, |system| u64::from(system.f_type as u32));
    if LOCAL_LOCKS.contains(&kind) {
        note(format_args!(
            "note: {} lies on a network or user file system, where a lock may not keep out processes of other machines; make sure that none works in it",
            folder.path().display()
        ));
    }
    !LOCAL_LOCKS.contains(&kind) && kind != NFS
}

/// Whether the file system passes locks on to other machines: not known.
#[cfg(not(target_os = "linux"))]
fn is_certain(_: &Folder) -> bool {
    true
}

/// That a run directory cannot be used while another process works in it.
pub fn in_use(folder: &Folder, how: &str) -> Failure {
    let remedy = "wait until it ends, or stop it";
    let text = format!("{} {how} by {}; {remedy}", folder.path().display(), holders(folder));
    Failure::Busy(text).remedied(remedy)
}

/// Who holds the lock, as far as the file says.
fn holders(folder: &Folder) -> String {
    let mut text = String::new();
    let read = folder.open_file(LOCK).and_then(|file| file.take(MOST).read_to_string(&mut text));
    let here = host();
    let mut holders: Vec<Holder<'_>> = match read {
        Ok(_) => text.lines().filter_map(Holder::parse).filter(|holder| !holder.has_ended(&here)).collect(),
        Err(_) => Vec::new(),
    };
    let Some(Holder { process, host, since, call }) = holders.pop() else {
        return "another stickslip".to_owned();
    };
    let mut who = format!("process {process} on {host} since {since} (`{call}`)");
    if !holders.is_empty() {
        let _ = write!(who, " and {} more", holders.len());
    }
    who
}

/// A line of the file.
struct Holder<'a> {
    process: u32,
    host: &'a str,
    since: &'a str,
    call: &'a str,
}

impl<'a> Holder<'a> {
    fn parse(line: &'a str) -> Option<Self> {
        let mut parts = line.splitn(4, ' ');
        let process = parts.next()?.parse().ok()?;
        Some(Self { process, host: parts.next()?, since: parts.next()?, call: parts.next()? })
    }

    /// Whether it is known to have ended. Processes of other machines are not known.
    fn has_ended(&self, here: &str) -> bool {
        let processes = Path::new("/proc");
        self.host == here && processes.join("self").exists() && !processes.join(self.process.to_string()).exists()
    }
}

/// The command line of this process, in a line.
fn call() -> String {
    const LONGEST: usize = 200;
    let words = env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned());
    let text = words.fold("stickslip".to_owned(), |text, word| text + " " + &word);
    let text: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{} ...", &text[..end]),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder() -> (tempfile::TempDir, Folder) {
        let directory = tempfile::tempdir().unwrap();
        let folder = Folder::open(directory.path()).unwrap();
        (directory, folder)
    }

    #[test]
    #[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
    fn one_works_alone_or_several_share() {
        let (_directory, folder) = folder();
        assert!(!is_held(&folder));
        let alone = Lock::acquire(&folder, Access::Alone, AN_INSTANT).unwrap().unwrap();
        assert!(is_held(&folder) && alone.is_alone());
        for access in [Access::Alone, Access::Shared, Access::Reading] {
            let refused = Lock::acquire(&folder, access, AN_INSTANT).unwrap_err();
            let holder = format!("is in use by process {} on ", process::id());
            assert!(refused.exit_code() == 75 && refused.to_string().contains(&holder), "{refused}");
        }
        let shared = alone.share(&folder).unwrap();
        let second = Lock::acquire(&folder, Access::Shared, AN_INSTANT).unwrap();
        assert!(Lock::acquire(&folder, Access::Alone, AN_INSTANT).is_err());
        drop((shared, second));
        assert!(!is_held(&folder));
    }

    #[test]
    fn looks_do_not_take_each_other_for_work() {
        let (directory, folder) = folder();
        drop(Lock::acquire(&folder, Access::Alone, AN_INSTANT).unwrap());
        let look = |path: std::path::PathBuf| {
            let folder = Folder::open(&path).unwrap();
            (0..2000).filter(|_| is_held(&folder)).count()
        };
        let begun = Instant::now();
        loop {
            let threads: Vec<_> =
                (0..4).map(|_| directory.path().to_owned()).map(|path| thread::spawn(move || look(path))).collect();
            let taken: usize = threads.into_iter().map(|thread| thread.join().unwrap()).sum();
            if taken == 0 {
                break;
            }
            // On a busy machine one of them may have been put aside while it looked.
            assert!(begun.elapsed() < Duration::from_secs(600), "{taken}");
        }
    }

    #[test]
    fn waiting_ends_when_the_holder_does() {
        let (directory, folder) = folder();
        let held = Lock::acquire(&folder, Access::Alone, AN_INSTANT).unwrap();
        let waiting = thread::spawn(move || {
            let folder = Folder::open(directory.path()).unwrap();
            Lock::acquire(&folder, Access::Alone, Duration::from_secs(60)).is_ok()
        });
        thread::sleep(Duration::from_millis(300));
        assert!(!waiting.is_finished());
        drop(held);
        assert!(waiting.join().unwrap());
    }

    #[test]
    fn a_removed_lock_is_not_taken_for_held() {
        let (directory, folder) = folder();
        let _first = Lock::acquire(&folder, Access::Alone, AN_INSTANT).unwrap();
        std::fs::remove_file(directory.path().join(LOCK)).unwrap();
        assert!(Lock::acquire(&folder, Access::Alone, AN_INSTANT).unwrap().is_some());
    }

    #[test]
    fn only_those_that_may_still_work_are_named() {
        let (directory, folder) = folder();
        let here = host();
        let lines = format!("4194999 {here} t stickslip submit a\n1 elsewhere t2 stickslip submit b\nbroken\n");
        std::fs::write(directory.path().join(LOCK), lines).unwrap();
        assert_eq!(holders(&folder), "process 1 on elsewhere since t2 (`stickslip submit b`)");
    }
}
