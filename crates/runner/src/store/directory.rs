//! The run directory: its lock, its job and its paths.

use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};
use std::thread;
use std::time::Duration;

use crate::evaluate::parts::Parts;
use crate::evaluate::sums::{LOOKUPS, SumLayout};
use crate::evaluate::unit::FinishedUnit;
use crate::failure::Failure;
use crate::files::foreign::text_of_key;
use crate::files::publish::{files, is_temporary, publish, publish_first, remove_temporary};
use crate::job::{Job, JobSource};
use crate::output::note;
use crate::store::piece;
use crate::store::tally::Tally;

/// The footer key of a surface for the hash of its job.
pub const JOB_HASH_KEY: &str = "stickslip:job_hash";

/// How a process works in a run directory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Access {
    /// Alone. It may remove unfinished files and write the surface.
    Alone,
    /// Beside others, as a shard, which only adds pieces.
    Shared,
}

/// A run directory that this process may work in.
#[derive(Debug)]
pub struct RunDirectory {
    path: PathBuf,
    /// The lock, held as long as this file is open.
    _lock: Option<File>,
}

impl RunDirectory {
    /// Opens `path` for a job, and creates it if it does not exist.
    pub fn create(path: &Path, access: Access) -> Result<Self, Failure> {
        if path.exists() && !path.is_dir() {
            let message = format!("{} is a file; a run needs a directory. Choose another with --out", path.display());
            return Err(Failure::CannotCreate(message));
        }
        if path.is_dir() && !path.join("job.toml").exists() && !looks_empty(path)? {
            let message = format!("{} is not empty and not a run directory. Choose another with --out", path.display());
            return Err(Failure::CannotCreate(message));
        }
        let shards = path.join("shards");
        fs::create_dir_all(&shards).map_err(|error| Failure::creating(path, error))?;
        Self::lock(path, access)
    }

    /// Opens an existing run.
    pub fn open(path: &Path, access: Access) -> Result<Self, Failure> {
        Self::require_run(path)?;
        Self::lock(path, access)
    }

    /// Opens an existing run for reading, without a lock.
    pub fn view(path: &Path) -> Result<Self, Failure> {
        Self::require_run(path)?;
        Ok(Self { path: path.to_owned(), _lock: None })
    }

    /// The runs that lie in the folder `path`, sorted by name; none if it is no folder.
    pub fn runs_in(path: &Path) -> Result<Vec<PathBuf>, Failure> {
        if !path.is_dir() {
            return Ok(Vec::new());
        }
        Ok(files(path)?.into_iter().filter(|entry| Self::require_run(entry).is_ok()).collect())
    }

    fn require_run(path: &Path) -> Result<(), Failure> {
        let why = if !path.exists() {
            "it does not exist"
        } else if !path.is_dir() {
            "it is a file"
        } else if !path.join("job.toml").is_file() || !path.join("shards").is_dir() {
            "it has no job.toml and shards/"
        } else {
            return Ok(());
        };
        Err(Failure::InputOutput(format!("{} is not a run directory: {why}", path.display())))
    }

    fn lock(path: &Path, access: Access) -> Result<Self, Failure> {
        let directory = File::open(path).map_err(|error| Failure::reading(path, error))?;
        let try_lock = || match access {
            Access::Alone => directory.try_lock(),
            Access::Shared => directory.try_lock_shared(),
        };
        // `status` takes the lock for an instant, so a single failure does not mean that the run is in use.
        let mut locked = try_lock();
        for _ in 0..10 {
            if !matches!(locked, Err(TryLockError::WouldBlock)) {
                break;
            }
            thread::sleep(Duration::from_millis(20));
            locked = try_lock();
        }
        match locked {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let message =
                    format!("{} is in use by another stickslip; wait until it ends, or stop it", path.display());
                return Err(Failure::Busy(message));
            }
            // Some network file systems have no locks. Pieces are safe without: they are whole files with names of
            // their own, and are counted once. At worst, work is done twice.
            Err(TryLockError::Error(error)) => {
                note(format_args!(
                    "note: {} cannot be locked ({error}); make sure that no other stickslip works in it",
                    path.display()
                ));
            }
        }
        Ok(Self { path: path.to_owned(), _lock: Some(directory) })
    }

    /// Whether another process is working in this run.
    pub fn in_use(&self) -> bool {
        File::open(&self.path).is_ok_and(|directory| matches!(directory.try_lock(), Err(TryLockError::WouldBlock)))
    }

    /// The path of the directory.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The directory of the finished pieces.
    pub fn shards(&self) -> PathBuf {
        self.path.join("shards")
    }

    /// The directory of the verdict maps.
    pub fn maps(&self) -> PathBuf {
        self.path.join("map")
    }

    /// The directory of the audits of integrals.
    pub fn audits(&self) -> PathBuf {
        self.path.join("audit")
    }

    /// The path of the result.
    pub fn surface(&self) -> PathBuf {
        self.path.join("surface.parquet")
    }

    /// Whether there is a result that belongs to this job.
    pub fn has_surface_of(&self, job: &Job) -> bool {
        text_of_key(&self.surface(), JOB_HASH_KEY) == Some(job.hash())
    }

    /// The number of complete cells of a job. An integrated surface is complete as a whole or not at all.
    pub fn complete_cells(&self, job: &Job, tally: &Tally) -> u64 {
        match job.is_integrated() {
            false => Parts::new(job).complete_cells(tally),
            true if self.has_surface_of(job) => job.cells(),
            true => 0,
        }
    }

    /// The frozen job, if there is one.
    pub fn job_source(&self) -> Result<Option<JobSource>, Failure> {
        let path = self.path.join("job.toml");
        if path.exists() { JobSource::read(&path).map(Some) } else { Ok(None) }
    }

    /// The frozen job of an existing run.
    pub fn job(&self) -> Result<Job, Failure> {
        match self.job_source()? {
            Some(source) => source.job(),
            None => Err(Failure::InputOutput(format!("{} has no job.toml", self.path.display()))),
        }
    }

    /// Freezes the job, unless another process has just frozen one; returns false then.
    pub fn freeze_first(&self, source: &JobSource, job: &Job) -> Result<bool, Failure> {
        publish_first(&self.path, "job.toml", source.frozen(job).as_bytes())
    }

    /// Replaces the frozen job.
    pub fn freeze(&self, source: &JobSource, job: &Job) -> Result<(), Failure> {
        publish(&self.path, "job.toml", source.frozen(job).as_bytes())
    }

    /// Removes the unfinished files of killed processes.
    pub fn tidy(&self) -> Result<(), Failure> {
        remove_temporary(&self.path)?;
        remove_temporary(&self.shards())?;
        for directory in [self.maps(), self.audits()] {
            if directory.is_dir() {
                remove_temporary(&directory)?;
            }
        }
        Ok(())
    }

    /// Everything counted so far. Damaged pieces are named on standard error and left out.
    pub fn tally(&self, job: &Job) -> Result<Tally, Failure> {
        self.tally_of(&self.shards(), job, &Parts::new(job), SumLayout::of(job).count())
    }

    /// The audits of integrals that are finished, by cell. Their sums are those of [`Lookups`].
    ///
    /// [`Lookups`]: crate::evaluate::sums::Lookups
    pub fn audits_done(&self, job: &Job) -> Result<Tally, Failure> {
        let parts = Parts::of_audits(job);
        match self.audits() {
            pieces if pieces.is_dir() => self.tally_of(&pieces, job, &parts, LOOKUPS),
            _ => Ok(Tally::new(parts.count())),
        }
    }

    fn tally_of(&self, pieces: &Path, job: &Job, parts: &Parts, sums: usize) -> Result<Tally, Failure> {
        let is_part = |stored: u64| parts.locate_stored(stored).0 < job.cells();
        let read = piece::read_all(pieces, &job.experiment_hash(), is_part, sums)?;
        for complaint in &read.complaints {
            note(format_args!("warning: {complaint}"));
        }
        let mut units = Vec::with_capacity(read.units.len());
        for unit in read.units {
            let (cell, part) = parts.locate_stored(unit.part);
            let wanted = part.filter(|&part| unit.samples.end <= parts.max_samples(parts.place(part).1));
            let Some(part) = wanted else {
                let what = part.map_or("more samples".to_owned(), |_| format!("sample {}", unit.samples.end - 1));
                return Err(Failure::Job(format!(
                    "{}: its pieces hold {what} of cell {cell}, but its job.toml has only {} samples; was it edited?",
                    self.path.display(),
                    job.sampling.samples
                )));
            };
            units.push(FinishedUnit { part, ..unit });
        }
        let mut tally = Tally::new(parts.count());
        tally.add_all(units).map_err(|(part, samples)| {
            let (cell, place) = parts.place(part);
            let of = if parts.of_a_cell() > 1 { format!("part {place} of cell {cell}") } else { format!("cell {cell}") };
            Failure::InputOutput(format!(
                "{}: two pieces disagree on samples {} to {} of {of}, so one of them is wrong. Move {}/ elsewhere and compute again",
                self.path.display(),
                samples.start,
                samples.end - 1,
                pieces.file_name().unwrap_or_default().display()
            ))
        })?;
        Ok(tally)
    }
}

fn looks_empty(path: &Path) -> Result<bool, Failure> {
    let entries = fs::read_dir(path).map_err(|error| Failure::reading(path, error))?;
    for entry in entries {
        let entry = entry.map_err(|error| Failure::reading(path, error))?;
        // A `submit` that was killed at its start leaves shards/ and unfinished files. Another shard may just have
        // written job.toml.
        let name = entry.file_name();
        if name != "shards" && name != "job.toml" && !is_temporary(&entry.path()) {
            return Ok(false);
        }
    }
    Ok(true)
}
