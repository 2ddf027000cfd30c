//! The run directory: its lock, its job and its files.

use std::ffi::OsStr;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::evaluate::parts::Parts;
use crate::evaluate::sums::{LOOKUPS, Lookups, SumLayout};
use crate::evaluate::unit::FinishedUnit;
use crate::failure::Failure;
use crate::files::folder::{Folder, SMALL_FILE, Unfinished};
use crate::files::foreign::text_of_key;
use crate::job::{Job, JobSource};
use crate::messages::{Code, Place};
use crate::output::{quoted, warn_of};
use crate::store::digests::{DIGESTS, Digests, Fit, Known, digest_of_bytes, digest_of_file};
use crate::store::file_state::{FileState, NOT_AS_WRITTEN, state_of};
use crate::store::joining::{self, Refusal};
use crate::store::layout::{
    AUDITS, JOB, LIMIT_SEARCHES, MAPS, SEARCHES, SHARDS, SURFACE, is_of_run, require_free, require_run, require_traces,
};
use crate::store::lock::{AN_INSTANT, Access, Lock, is_held};
use crate::store::piece::{self, Complaint, Defect, REMEDY_OF_VERSIONS};
use crate::store::searches::{self, Searches};
use crate::store::tally::Tally;

/// The footer key of a surface for the hash of its job.
pub const JOB_HASH_KEY: &str = "stickslip:job_hash";

/// The footer key of a surface for its job.
pub const JOB_KEY: &str = "stickslip:job";

/// A run directory that this process may work in.
#[derive(Debug)]
pub struct RunDirectory {
    root: Folder,
    shards: Folder,
    lock: Option<Lock>,
}

impl RunDirectory {
    /// Opens `path` for a job, creates it if it does not exist, and waits up to `patience` for others that work in it.
    pub fn create(path: &Path, access: Access, patience: Duration) -> Result<Self, Failure> {
        require_free(path)?;
        fs::create_dir_all(path).map_err(|error| Failure::creating(path, error))?;
        let root = Folder::open(path).map_err(|error| Failure::creating(path, error))?;
        Self::within(root, access, patience)
    }

    /// Opens an existing run, and waits up to `patience` for others that work in it.
    pub fn open(path: &Path, access: Access, patience: Duration) -> Result<Self, Failure> {
        require_run(path)?;
        let root = Folder::open(path).map_err(|error| Failure::reading(path, error))?;
        Self::within(root, access, patience)
    }

    /// Opens a directory that is to be verified, which may lack its job.
    pub fn open_any(path: &Path, access: Access) -> Result<Self, Failure> {
        require_traces(path)?;
        let root = Folder::open(path).map_err(|error| Failure::reading(path, error))?;
        Self::within(root, access, AN_INSTANT)
    }

    fn within(root: Folder, access: Access, patience: Duration) -> Result<Self, Failure> {
        let shards_path = root.path().join(SHARDS);
        if access != Access::Reading {
            root.require_writable().map_err(|error| Failure::creating(root.path(), error))?;
        }
        // Others see by the lock that a run without a job is being made.
        let lock = Lock::acquire(&root, access, patience)?;
        let shards = match access {
            Access::Reading => root.within(SHARDS).map_err(|error| Failure::reading(&shards_path, error))?,
            Access::Alone | Access::Shared => {
                let shards = root.create_within(SHARDS).map_err(|error| Failure::creating(&shards_path, error))?;
                shards.require_writable().map_err(|error| Failure::creating(&shards_path, error))?;
                shards
            }
        };
        Ok(Self { root, shards, lock })
    }

    /// Opens an existing run for reading, without a lock.
    pub fn view(path: &Path) -> Result<Self, Failure> {
        require_run(path)?;
        let root = Folder::open(path).map_err(|error| Failure::reading(path, error))?;
        let shards = root.within(SHARDS).map_err(|error| Failure::reading(&path.join(SHARDS), error))?;
        Ok(Self { root, shards, lock: None })
    }

    /// Lets shards in, after this process worked alone.
    pub fn share(self) -> Result<Self, Failure> {
        let Self { root, shards, lock } = self;
        let lock = lock.map(|lock| lock.share(&root)).transpose()?.flatten();
        Ok(Self { root, shards, lock })
    }

    /// Whether it is certain that no other process works here.
    fn is_alone(&self) -> bool {
        self.lock.as_ref().is_some_and(Lock::is_alone)
    }

    /// Whether another process is working in this run.
    pub fn in_use(&self) -> bool {
        is_held(&self.root)
    }

    /// The path of the directory.
    pub fn path(&self) -> &Path {
        self.root.path()
    }

    /// The directory itself.
    pub fn root(&self) -> &Folder {
        &self.root
    }

    /// The directory of the finished pieces.
    pub fn shards(&self) -> &Folder {
        &self.shards
    }

    /// The directory of the verdict maps, if there is one.
    pub fn maps(&self) -> Result<Option<Folder>, Failure> {
        self.folder(MAPS)
    }

    /// The directory of the audits of integrals, if there is one.
    pub fn audits(&self) -> Result<Option<Folder>, Failure> {
        self.folder(AUDITS)
    }

    /// The directory of searches for rare events, if there is one.
    pub fn searches(&self) -> Result<Option<Folder>, Failure> {
        self.folder(SEARCHES)
    }

    /// The searches of `what` that are kept in the directory `name` in this one.
    pub fn searches_of(&self, name: &str, what: String) -> Result<Searches, Failure> {
        let root = self.root.again().map_err(|error| Failure::reading(self.path(), error))?;
        Searches::read(root, name, what)
    }

    /// Removes the searches that are kept in the directory `name` in this one, if there are some.
    pub fn forget_searches(&self, name: &str) {
        searches::remove(&self.root, name);
    }

    /// A directory in this one, created if it is not there.
    pub fn create_folder(&self, name: &str) -> Result<Folder, Failure> {
        self.root.create_within(name).map_err(|error| Failure::writing(&self.path().join(name), error))
    }

    fn folder(&self, name: &str) -> Result<Option<Folder>, Failure> {
        self.root.within_if_there(name).map_err(|error| Failure::reading(&self.path().join(name), error))
    }

    /// The path of the result.
    pub fn surface(&self) -> PathBuf {
        self.path().join(SURFACE)
    }

    /// Opens the result for reading, if there is one.
    pub fn open_surface(&self) -> Result<Option<File>, Failure> {
        self.root.open_if_there(SURFACE).map_err(|error| Failure::reading(&self.surface(), error))
    }

    /// What there is of the surface of a job.
    pub fn surface_state(&self, job: &Job) -> Result<FileState, Failure> {
        let state = state_of(&self.root, SURFACE, &[(JOB_HASH_KEY, job.hash())])?;
        let is_older_or_newer = state == FileState::OfAnotherJob && self.has_surface_of_another_version(job);
        Ok(if is_older_or_newer { FileState::OfAnotherVersion } else { state })
    }

    /// Whether there is a result of this job that another version identified differently.
    fn has_surface_of_another_version(&self, job: &Job) -> bool {
        let footer = |file: &File| Some((text_of_key(file, JOB_HASH_KEY)?, text_of_key(file, JOB_KEY)?));
        let Some((hash, text)) = self.root.open_file(SURFACE).ok().as_ref().and_then(footer) else { return false };
        let written = JobSource { path: self.surface(), text };
        hash != job.hash() && written.job_to_read().is_ok_and(|written| written.hash() == job.hash())
    }

    /// Whether there is a result that belongs to this job.
    pub fn has_surface_of(&self, job: &Job) -> Result<bool, Failure> {
        Ok(self.surface_state(job)? == FileState::Sound)
    }

    /// Writes a file of this directory, and its digest before it.
    pub fn publish(&self, name: &str, bytes: &[u8]) -> Result<(), Failure> {
        self.expect(name, &digest_of_bytes(bytes))?;
        self.make_way(name);
        self.root.publish(name, bytes).map_err(|error| Failure::writing(&self.path().join(name), error))
    }

    /// Gives a finished file its name, and writes its digest before.
    pub fn publish_file(&self, name: &str, file: Unfinished<'_>, digest: &str) -> Result<(), Failure> {
        self.expect(name, digest)?;
        self.make_way(name);
        file.publish(name).map_err(|error| Failure::writing(&self.path().join(name), error))
    }

    /// Writes the digest of what a file will hold.
    pub fn expect(&self, name: &str, digest: &str) -> Result<(), Failure> {
        self.change_digests(|digests| self.expect_among(digests, name, digest))
    }

    /// Adds the digest of what a file will hold to those that are known.
    pub fn expect_among(&self, digests: &mut Digests, name: &str, digest: &str) {
        digests.expect(name, digest, || digest_of_file(self.root.open_file(name).ok()?).ok());
    }

    /// Writes the digests that `change` makes of those that are there, if they differ.
    pub fn change_digests(&self, change: impl FnOnce(&mut Digests)) -> Result<(), Failure> {
        let known = Known::read(&self.root)?;
        let is_known = matches!(known, Known::Digests(_));
        let before = known.into_digests();
        let mut digests = before.clone();
        change(&mut digests);
        if is_known && before == digests { Ok(()) } else { self.publish_digests(&digests) }
    }

    /// Writes the digests.
    pub fn publish_digests(&self, digests: &Digests) -> Result<(), Failure> {
        self.make_way(DIGESTS);
        digests.publish(&self.root)
    }

    /// Sets a directory aside that lies where a file is to be written.
    fn make_way(&self, name: &str) {
        if self.root.holds_directory(name) {
            self.set_aside(&self.root, name.as_ref(), "it is a directory");
        }
    }

    /// The bytes of a small file that has a digest, if there is one, or why it is not as it was written.
    pub fn read_known(&self, name: &str) -> Result<Option<Vec<u8>>, String> {
        let bytes = self.root.read_if_there(name, SMALL_FILE).map_err(|error| error.to_string())?;
        let Some(bytes) = bytes else { return Ok(None) };
        let known = Known::read(&self.root).map_err(|error| error.to_string())?;
        match known.fit(name, &digest_of_bytes(&bytes)) {
            Fit::Fits | Fit::Unknown => Ok(Some(bytes)),
            Fit::Differs => Err(NOT_AS_WRITTEN.to_owned()),
        }
    }

    /// Gives a damaged file another name, under which nothing reads it, and says so.
    pub fn set_aside(&self, folder: &Folder, name: &OsStr, why: &str) {
        let mut aside = name.to_owned();
        aside.push(".damaged");
        let path = folder.path().join(name);
        match folder.rename(name, &aside) {
            Ok(()) => warn_of(&path, format_args!(" is set aside as {}: {why}", aside.display())),
            Err(error) => warn_of(&path, format_args!(" is ignored: {why} ({error})")),
        }
    }

    /// Removes the unfinished files of killed processes, if no other process can be at work here.
    pub fn tidy(&self) -> Result<(), Failure> {
        if !self.is_alone() {
            return Ok(());
        }
        self.root.remove_unfinished()?;
        self.shards.remove_unfinished()?;
        for folder in [self.maps()?, self.audits()?, self.searches()?, self.folder(LIMIT_SEARCHES)?].iter().flatten() {
            folder.remove_unfinished()?;
        }
        Ok(())
    }

    /// Removes the run, with what was drawn and written of its result. Files of other names are left.
    ///
    /// # Errors
    /// If a file cannot be removed.
    pub fn clear(&self) -> Result<(), Failure> {
        let failed = |path: PathBuf| {
            move |error: io::Error| Failure::CannotCreate(format!("cannot remove {}: {error}", path.display()))
        };
        let remove = |folder: &Folder, name: &OsStr| folder.remove(name).map_err(failed(folder.path().join(name)));
        let root = &self.root;
        let names = root.names().map_err(|error| Failure::reading(self.path(), error))?;
        // The result first and the job last: what is left after a kill is a run of that job that goes on.
        let (last, first): (Vec<_>, Vec<_>) =
            names.into_iter().filter(|name| is_of_run(name)).partition(|name| name == JOB);
        for name in first {
            remove(root, &name)?;
        }
        for name in [SHARDS, MAPS, AUDITS, SEARCHES] {
            let Some(folder) = self.folder(name)? else { continue };
            for piece in folder.names().map_err(|error| Failure::reading(folder.path(), error))? {
                remove(&folder, &piece)?;
            }
        }
        last.iter().try_for_each(|name| remove(root, name))
    }

    /// The number of complete cells of a job. An integrated surface is complete as a whole or not at all.
    pub fn complete_cells(&self, job: &Job, tally: &Tally) -> u64 {
        if job.draws_samples() {
            return Parts::new(job).complete_cells(tally);
        }
        if self.has_surface_of(job).unwrap_or(false) { job.cells() } else { 0 }
    }

    /// Everything counted so far. Damaged pieces are named on standard error and left out.
    ///
    /// # Errors
    /// Pieces of another job or version, and a result of another version, which would be lost.
    pub fn tally(&self, job: &Job) -> Result<Tally, Failure> {
        let layout = SumLayout::for_job(job);
        let tally = self.tally_of(&self.shards, job, &Parts::new(job), |unit| layout.can_be(unit))?;
        if self.has_surface_of_another_version(job) {
            return Err(Failure::Job(format!(
                "{} was written by another version of stickslip: its results version or format version is not that of this one, see `stickslip --version`. `plot`, `report` and `export` read it. {REMEDY_OF_VERSIONS}",
                self.surface().display()
            ))
            .coded(Code::OtherVersion)
            .at(Place::file(&self.surface()))
            .remedied(REMEDY_OF_VERSIONS));
        }
        Ok(tally)
    }

    /// Everything counted so far, where the audits are those of the job too.
    pub fn tally_with_audits(&self, job: &Job) -> Result<Tally, Failure> {
        self.audits_done(job)?;
        self.tally(job)
    }

    /// The audits of integrals that are finished, by cell. Their sums are those of [`Lookups`].
    pub fn audits_done(&self, job: &Job) -> Result<Tally, Failure> {
        let parts = Parts::of_audits(job);
        match self.audits()? {
            Some(pieces) => {
                let can_be =
                    |unit: &FinishedUnit| unit.sums.len() == LOOKUPS && Lookups::can_be(&unit.sums, unit.len());
                self.tally_of(&pieces, job, &parts, can_be)
            }
            None => Ok(Tally::new(&parts)),
        }
    }

    fn tally_of(
        &self,
        pieces: &Folder,
        job: &Job,
        parts: &Parts,
        can_be: impl Fn(&FinishedUnit) -> bool,
    ) -> Result<Tally, Failure> {
        let wrong = |unit: &FinishedUnit| {
            if parts.locate_stored(unit.part).0 >= job.cells() || !unit.is_consistent(job.model().recorded()) {
                return Some("its counts do not add up");
            }
            (!can_be(unit)).then_some("its sums cannot be those of its samples")
        };
        let experiment = job.experiment_hash();
        let mut complaints = None;
        let mut tally = Tally::new(parts);
        let read = |take: &mut dyn FnMut(FinishedUnit)| {
            let found = piece::read_all(pieces, &experiment, wrong, &mut |unit| {
                take(FinishedUnit { part: self.part_of(&unit, job, parts, pieces)?, ..unit });
                Ok(())
            })?;
            // Pieces may be read again.
            complaints.get_or_insert(found);
            Ok(())
        };
        joining::add_all(&mut tally, read).map_err(|refusal| match refusal {
            Refusal::Unread(failure) => failure,
            Refusal::Disagreement(part, samples) => {
                let (cell, place) = parts.place(part);
                let resume = format!("stickslip resume {}", quoted(self.path()));
                let of =
                    if parts.of_a_cell() > 1 { format!("part {place} of cell {cell}") } else { format!("cell {cell}") };
                Failure::InputOutput(format!(
                    "{}: two pieces disagree on samples {} to {} of {of}, so one of them is wrong. Move {}/ elsewhere, make an empty one in its place, and compute again with `{resume}`",
                    self.path().display(),
                    samples.start,
                    samples.end - 1,
                    pieces.path().file_name().unwrap_or_default().display()
                ))
                .coded(Code::Damaged)
                .at(Place::file(pieces.path()))
                .remedied(resume)
            }
        })?;
        for Complaint { name, defect } in complaints.into_iter().flatten() {
            match defect {
                Defect::Damaged(why) if self.is_alone() => self.set_aside(pieces, &name, &why),
                Defect::Damaged(why) | Defect::Unread(why) => {
                    warn_of(&pieces.path().join(name), format_args!(" is ignored: {why}"));
                }
            }
        }
        Ok(tally)
    }

    /// The part of a unit of a piece.
    ///
    /// # Errors
    /// Samples that the job does not have.
    fn part_of(&self, unit: &FinishedUnit, job: &Job, parts: &Parts, pieces: &Folder) -> Result<u64, Failure> {
        let (cell, part) = parts.locate_stored(unit.part);
        let wanted = part.filter(|&part| unit.samples.end <= parts.max_samples(parts.place(part).1));
        wanted.ok_or_else(|| {
            let what = part.map_or("more samples".to_owned(), |_| format!("sample {}", unit.samples.end - 1));
            let most = part.map_or(job.sampling.samples, |part| parts.max_samples(parts.place(part).1));
            let samples = match (part, parts.looks(), parts.of_a_cell()) {
                _ if pieces.path().ends_with(AUDITS) => "plain samples".to_owned(),
                (Some(_), None, count) if count > 1 => format!("samples in each of its {count} randomisations"),
                (Some(_), Some(_), _) => "samples up to its next look".to_owned(),
                _ => "samples".to_owned(),
            };
            Failure::Job(format!(
                "{}: the pieces in {} hold {what} of cell {cell}, but the job has only {most} {samples}; was its job.toml edited or removed?",
                self.path().display(),
                pieces.path().file_name().unwrap_or_default().display()
            ))
        })
    }
}
