//! A directory that is held open: whatever happens to its path meanwhile, files are read from and written to the same
//! directory.
//!
//! Only ordinary files are read, and only up to a limit: a pipe would be waited for for ever, a link may lead out of the
//! directory. Files appear whole or not at all: they are written under a temporary name, and renamed when they are on
//! disk.

use std::ffi::{OsStr, OsString};
use std::fs::{self, File};
use std::io::{self, Read as _, Write as _};
use std::os::unix::ffi::OsStrExt as _;
use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};
use std::process;
use std::sync::atomic::{AtomicU64, Ordering};

use rustix::fs::{Access, AtFlags, Dir, FileType, Mode, OFlags, statat};
use rustix::io::Errno;

use crate::failure::Failure;
use crate::files::publish::{PREFIX, is_temporary};
use crate::shell::shown;
use crate::unfinished;

/// Largest number of bytes of a small file, such as a job spec.
pub const SMALL_FILE: u64 = 64 << 20;

/// Bytes that are read of a file at once.
const AT_ONCE: u64 = 1 << 18;

/// Whether an error in reading says that there is no ordinary file of a fitting size, rather than that reading failed.
pub fn is_no_file(error: &io::Error) -> bool {
    error.kind() == io::ErrorKind::Other
}

/// Numbers the temporary files of this process.
static FILES: AtomicU64 = AtomicU64::new(0);

/// How a new file is opened. A link of its name is not followed.
const NEW_FILE: OFlags = OFlags::RDWR.union(OFlags::CREATE).union(OFlags::EXCL).union(OFlags::CLOEXEC);

/// The rights of a new file, of which the umask takes what the user wants to be taken.
fn mode_of_new_files() -> Mode {
    Mode::RUSR | Mode::WUSR | Mode::RGRP | Mode::WGRP | Mode::ROTH | Mode::WOTH
}

/// An open directory.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    handle: File,
    /// Its device and number there, by which it is recognised.
    identity: (u64, u64),
}

/// A file that has its name not yet. It is removed unless it gets one.
pub struct Unfinished<'f> {
    folder: &'f Folder,
    file: File,
    name: String,
    is_named: bool,
    /// Lets a signal remove it.
    _entry: unfinished::Unfinished,
}

impl Folder {
    /// Opens the directory at `path`.
    pub fn open(path: &Path) -> io::Result<Self> {
        let flags = OFlags::RDONLY | OFlags::DIRECTORY | OFlags::CLOEXEC;
        Self::new(path.to_owned(), File::from(rustix::fs::open(path, flags, Mode::empty())?))
    }

    /// Opens the directory `name` in this one, which must not be a link.
    pub fn within(&self, name: &str) -> io::Result<Self> {
        let flags = OFlags::RDONLY | OFlags::DIRECTORY | OFlags::NOFOLLOW | OFlags::CLOEXEC;
        let handle = rustix::fs::openat(&self.handle, name, flags, Mode::empty()).map_err(|error| match error {
            Errno::NOTDIR | Errno::LOOP => io::Error::other("it is no directory of its own, but a file or a link"),
            error => error.into(),
        })?;
        Self::new(self.path.join(name), File::from(handle))
    }

    /// The same, if there is anything of that name.
    pub fn within_if_there(&self, name: &str) -> io::Result<Option<Self>> {
        match self.within(name) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            opened => opened.map(Some),
        }
    }

    /// The same, created if there is nothing of that name.
    pub fn create_within(&self, name: &str) -> io::Result<Self> {
        match rustix::fs::mkdirat(&self.handle, name, Mode::RWXU | Mode::RWXG | Mode::RWXO) {
            Ok(()) => self.handle.sync_all()?,
            Err(Errno::EXIST) => {}
            Err(error) => return Err(error.into()),
        }
        self.within(name)
    }

    fn new(path: PathBuf, handle: File) -> io::Result<Self> {
        let metadata = handle.metadata()?;
        Ok(Self { path, handle, identity: (metadata.dev(), metadata.ino()) })
    }

    /// The same directory, opened once more.
    pub fn again(&self) -> io::Result<Self> {
        Ok(Self { path: self.path.clone(), handle: self.handle.try_clone()?, identity: self.identity })
    }

    /// The path by which it was opened.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The open directory.
    pub fn handle(&self) -> &File {
        &self.handle
    }

    /// An error if its path leads elsewhere by now, because it was moved, removed or replaced.
    pub fn require_in_place(&self) -> io::Result<()> {
        let now = fs::metadata(&self.path).map(|metadata| (metadata.dev(), metadata.ino()));
        if now.is_ok_and(|now| now == self.identity) {
            return Ok(());
        }
        Err(io::Error::other(format!(
            "{} was moved, removed or replaced while this process worked in it; what is finished lies where it was moved to",
            self.path.display()
        )))
    }

    /// An error if files cannot be created in it.
    pub fn require_writable(&self) -> io::Result<()> {
        let access = Access::WRITE_OK | Access::EXEC_OK;
        Ok(rustix::fs::accessat(&self.handle, ".", access, AtFlags::EACCESS)?)
    }

    /// The names of everything in it, sorted.
    pub fn names(&self) -> io::Result<Vec<OsString>> {
        let mut names = Vec::new();
        for entry in Dir::read_from(&self.handle)? {
            let entry = entry?;
            let name = OsStr::from_bytes(entry.file_name().to_bytes());
            if name != "." && name != ".." {
                names.push(name.to_owned());
            }
        }
        names.sort();
        Ok(names)
    }

    /// Opens an ordinary file for reading.
    pub fn open_file(&self, name: impl AsRef<OsStr>) -> io::Result<File> {
        // Without NONBLOCK, opening a pipe waits for its writer.
        let flags = OFlags::RDONLY | OFlags::NOFOLLOW | OFlags::NONBLOCK | OFlags::CLOEXEC;
        let file = rustix::fs::openat(&self.handle, name.as_ref(), flags, Mode::empty());
        let file = File::from(file.map_err(|error| match error {
            Errno::LOOP => io::Error::other("it is a link, and a run has files of its own"),
            error => error.into(),
        })?);
        if !file.metadata()?.is_file() {
            return Err(io::Error::other("it is not an ordinary file"));
        }
        Ok(file)
    }

    /// The same, if there is anything of that name.
    pub fn open_if_there(&self, name: impl AsRef<OsStr>) -> io::Result<Option<File>> {
        match self.open_file(name) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            opened => opened.map(Some),
        }
    }

    /// The content of an ordinary file of at most `most` bytes.
    pub fn read(&self, name: impl AsRef<OsStr>, most: u64) -> io::Result<Vec<u8>> {
        self.read_while(name, most, |_| true)
    }

    /// The same of a file of which all bytes are possible. It is read up to the first that are not.
    pub fn read_while(
        &self,
        name: impl AsRef<OsStr>,
        most: u64,
        are_possible: impl Fn(&[u8]) -> bool,
    ) -> io::Result<Vec<u8>> {
        let file = self.open_file(name)?;
        let mut bytes = Vec::new();
        let mut end = if file.metadata()?.len() > most { usize::MAX } else { 0 };
        while end as u64 <= most {
            if (&file).take(AT_ONCE).read_to_end(&mut bytes)? == 0 {
                return Ok(bytes);
            }
            if !are_possible(&bytes[end..]) {
                return Err(io::Error::other("it has bytes that no such file has"));
            }
            end = bytes.len();
        }
        Err(io::Error::other(format!("it has more than {most} bytes, the most that such a file may have")))
    }

    /// The same, if there is anything of that name.
    pub fn read_if_there(&self, name: impl AsRef<OsStr>, most: u64) -> io::Result<Option<Vec<u8>>> {
        match self.read(name, most) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            read => read.map(Some),
        }
    }

    /// Whether there is a directory of that name.
    pub fn holds_directory(&self, name: &str) -> bool {
        let there = statat(&self.handle, name, AtFlags::SYMLINK_NOFOLLOW);
        there.is_ok_and(|there| FileType::from_raw_mode(there.st_mode) == FileType::Directory)
    }

    /// Removes a file, if there is one.
    pub fn remove(&self, name: impl AsRef<OsStr>) -> io::Result<()> {
        match rustix::fs::unlinkat(&self.handle, name.as_ref(), AtFlags::empty()) {
            Ok(()) | Err(Errno::NOENT) => Ok(()),
            Err(error) => Err(error.into()),
        }
    }

    /// Removes an empty directory.
    pub fn remove_directory(&self, name: &str) -> io::Result<()> {
        Ok(rustix::fs::unlinkat(&self.handle, name, AtFlags::REMOVEDIR)?)
    }

    /// An error if there is anything but ordinary files in it, such as a link that another program would follow.
    pub fn require_files(&self) -> io::Result<()> {
        for name in self.names()? {
            let there = statat(&self.handle, &name, AtFlags::SYMLINK_NOFOLLOW)?;
            if FileType::from_raw_mode(there.st_mode) != FileType::RegularFile {
                let name = shown(Path::new(&name));
                return Err(io::Error::other(format!("{name} in it is not an ordinary file; remove it")));
            }
        }
        Ok(())
    }

    /// Begins a file.
    pub fn begin(&self) -> io::Result<Unfinished<'_>> {
        let host = blake3::hash(host().as_bytes()).to_hex();
        loop {
            let number = FILES.fetch_add(1, Ordering::Relaxed);
            let name = format!("{PREFIX}{}-{}-{number}", &host[..8], process::id());
            let created = unfinished::create(|| {
                let file = rustix::fs::openat(&self.handle, &name, NEW_FILE, mode_of_new_files())?;
                Ok((File::from(file), self.path.join(&name)))
            });
            match created {
                Ok((entry, file)) => {
                    return Ok(Unfinished { folder: self, file, name, is_named: false, _entry: entry });
                }
                // Left behind by a killed process of the same number.
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(self.removed_or(error)),
            }
        }
    }

    /// That the directory was removed or moved, if this is why a file is not found in it.
    fn removed_or(&self, error: io::Error) -> io::Error {
        match error.kind() {
            io::ErrorKind::NotFound => self.require_in_place().err().unwrap_or(error),
            _ => error,
        }
    }

    /// Writes a file whole or not at all, in place of one of the same name.
    pub fn publish(&self, name: &str, bytes: &[u8]) -> io::Result<()> {
        let mut file = self.begin()?;
        file.write_all(bytes)?;
        file.publish(name)
    }

    /// Writes a file whole or not at all, unless there is one of that name; returns false then.
    pub fn publish_first(&self, name: &str, bytes: &[u8]) -> io::Result<bool> {
        let mut file = self.begin()?;
        file.write_all(bytes)?;
        file.publish_first(name)
    }

    /// Gives a file another name.
    pub fn rename(&self, from: &OsStr, to: &OsStr) -> io::Result<()> {
        rustix::fs::renameat(&self.handle, from, &self.handle, to)?;
        self.handle.sync_all()
    }

    /// Removes the unfinished files of killed processes. No other process may work in the directory at the same time.
    pub fn remove_unfinished(&self) -> Result<(), Failure> {
        let names = self.names().map_err(|error| Failure::reading(&self.path, error))?;
        for name in names.iter().filter(|name| is_temporary(Path::new(name))) {
            match rustix::fs::unlinkat(&self.handle, name, AtFlags::empty()) {
                // A directory is none of them.
                Ok(()) | Err(Errno::ISDIR | Errno::PERM | Errno::NOENT) => {}
                Err(error) => return Err(Failure::writing(&self.path.join(name), io::Error::from(error))),
            }
        }
        Ok(())
    }
}

impl Unfinished<'_> {
    /// Gives the file its name when it is on disk.
    pub fn publish(mut self, name: &str) -> io::Result<()> {
        self.file.sync_all()?;
        self.folder.require_in_place()?;
        let renamed = rustix::fs::renameat(&self.folder.handle, &self.name, &self.folder.handle, name);
        renamed.map_err(|error| self.folder.removed_or(error.into()))?;
        self.is_named = true;
        self.folder.handle.sync_all()
    }

    /// The same, unless there is a file of that name; returns false then.
    pub fn publish_first(self, name: &str) -> io::Result<bool> {
        self.file.sync_all()?;
        self.folder.require_in_place()?;
        let handle = &self.folder.handle;
        match rustix::fs::linkat(handle, &self.name, handle, name, AtFlags::empty()) {
            Ok(()) => handle.sync_all().map(|()| true),
            Err(Errno::EXIST) => Ok(false),
            // Some file systems have no links. What is left is a moment between the look and the name.
            Err(_) => match statat(handle, name, AtFlags::SYMLINK_NOFOLLOW) {
                Ok(_) => Ok(false),
                Err(_) => self.publish(name).map(|()| true),
            },
        }
    }
}

impl io::Write for Unfinished<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Drop for Unfinished<'_> {
    fn drop(&mut self) {
        if !self.is_named {
            // What cannot be removed here is removed by the next process that works alone in the directory.
            let _ = rustix::fs::unlinkat(&self.folder.handle, &self.name, AtFlags::empty());
        }
    }
}

/// The name of this machine.
pub fn host() -> String {
    rustix::system::uname().nodename().to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests;
