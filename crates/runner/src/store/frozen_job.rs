//! The job of a run as it was frozen, and what is done where it is damaged or lost.

use crate::failure::Failure;
use crate::files::folder::{SMALL_FILE, is_no_file};
use crate::files::foreign::text_of_key;
use crate::job::{Job, JobSource};
use crate::messages::{Code, Place};
use crate::output::quoted;
use crate::store::digests::{Digests, Fit, Known, digest_of_bytes, digest_of_file};
use crate::store::directory::{JOB_HASH_KEY, JOB_KEY, RunDirectory};
use crate::store::file_state::{FileState, state_of};
use crate::store::layout::{JOB, LIMITS, SURFACE};

impl RunDirectory {
    /// The frozen job, if there is one.
    ///
    /// # Errors
    /// A file that is not the one that was written.
    pub fn job_source(&self) -> Result<Option<JobSource>, Failure> {
        let path = self.path().join(JOB);
        let bytes = match self.root().read_if_there(JOB, SMALL_FILE) {
            Ok(Some(bytes)) => bytes,
            Ok(None) => return Ok(None),
            Err(error) if is_no_file(&error) => return Err(self.job_damaged(&format!("is damaged: {error}"))),
            Err(error) => return Err(Failure::reading(&path, error)),
        };
        if Known::read(self.root())?.fit(JOB, &digest_of_bytes(&bytes)) == Fit::Differs {
            let why = "was damaged or edited: it does not have the digest that it was written with";
            return Err(self.job_damaged(why));
        }
        let text = String::from_utf8(bytes).map_err(|error| self.job_damaged(&format!("is damaged: {error}")))?;
        Ok(Some(JobSource { path, text }))
    }

    /// That the frozen job is damaged, with the remedy.
    fn job_damaged(&self, why: &str) -> Failure {
        let path = self.path().join(JOB);
        let (how, remedy) = self.how_to_write_job();
        let text = format!("{} {why}. {how}; a job with other settings needs another directory", path.display());
        Failure::InputOutput(text).coded(Code::Damaged).at(Place::file(&path)).remedied(remedy)
    }

    /// How a damaged job is written again, as a sentence, and the remedy that it names first.
    fn how_to_write_job(&self) -> (String, String) {
        let run = quoted(self.path());
        let (words, remedy) = if self.root().open_file(SURFACE).is_ok() {
            let verify = format!("stickslip verify {run}");
            (format!("Write it again from the surface with `{verify}`, or submit"), verify)
        } else {
            ("Submit".to_owned(), format!("--out {run}"))
        };
        (format!("{words} the same job again with `--out {run}`"), remedy)
    }

    /// The frozen job of an existing run.
    pub fn job(&self) -> Result<Job, Failure> {
        self.job_by(JobSource::job)
    }

    /// The frozen job of an existing run for what reads its results, see [`JobSource::job_to_read`].
    pub fn job_to_read(&self) -> Result<Job, Failure> {
        self.job_by(JobSource::job_to_read)
    }

    fn job_by(&self, read: fn(&JobSource) -> Result<Job, Failure>) -> Result<Job, Failure> {
        match self.job_source()? {
            Some(source) => read(&source).map_err(|refused| {
                if let Some(as_written) = self.refused_as_written(&source, &refused) {
                    return as_written;
                }
                let message = refused.message();
                let (how, remedy) = self.how_to_write_job();
                let text = format!("{}\nIf this file of the run was damaged or edited: {how}", message.text);
                Failure::Job(text).coded(message.code).at(message.place.unwrap_or_default()).remedied(remedy)
            }),
            None => Err(Failure::InputOutput(format!("{} has no job.toml", self.path().display()))),
        }
    }

    /// That the frozen job is refused although it is as it was written, or whole but for files that it names; `None` if it
    /// may be neither.
    pub fn refused_as_written(&self, source: &JobSource, refused: &Failure) -> Option<Failure> {
        let fit = Known::read(self.root()).ok()?.fit(JOB, &digest_of_bytes(source.text.as_bytes()));
        let state = match fit {
            Fit::Fits => "is as it was written",
            Fit::Unknown if source.job_to_read().is_ok() => "can be read",
            Fit::Unknown | Fit::Differs => return None,
        };
        let (message, path) = (refused.message(), self.path().join(JOB));
        let remedy = format!("--out {}", quoted(self.path()));
        let text = format!(
            "{}\n{} {state}. If files that it names were moved, bring them back, or submit the job again with `{remedy}` and the places where they are now",
            message.text,
            path.display()
        );
        Some(Failure::Job(text).coded(message.code).at(message.place.unwrap_or_default()).remedied(remedy))
    }

    /// The job in the footer of the surface, if that is as it was written and all pieces belong to it; with the table
    /// `[limit]` of the limits that were found of it.
    pub fn job_of_surface(&self) -> Option<(JobSource, Job)> {
        let digest = digest_of_file(self.root().open_file(SURFACE).ok()?).ok()?;
        if Known::read(self.root()).ok()?.fit(SURFACE, &digest) == Fit::Differs {
            return None;
        }
        let surface = self.root().open_file(SURFACE).ok()?;
        let text = text_of_key(&surface, JOB_KEY)?;
        let source = JobSource { path: self.surface(), text };
        let job = source.job_to_read().ok()?;
        let is_whole = text_of_key(&surface, JOB_HASH_KEY)? == job.hash();
        // A run that was extended has the surface of the job before until it is finished, and pieces beyond that job.
        if !is_whole || self.tally(&job).is_err() {
            return None;
        }
        let limited = self.table_of_limits(&job).and_then(|table| {
            let limited = JobSource { text: format!("{}{table}", source.text), path: self.surface() };
            limited.job_to_read().ok().map(|job| (limited, job))
        });
        Some(limited.unwrap_or((source, job)))
    }

    /// The table `[limit]` that asked for the limits of a job, if they are as they were written.
    fn table_of_limits(&self, job: &Job) -> Option<String> {
        if state_of(self.root(), LIMITS, &[(JOB_HASH_KEY, job.hash())]).ok()? != FileState::Sound {
            return None;
        }
        let file = self.root().open_file(LIMITS).ok()?;
        let of = toml::Value::from(text_of_key(&file, "stickslip:of")?);
        Some(format!("\n[limit]\nof = {of}\nprobability = [{}]\n", text_of_key(&file, "stickslip:targets")?))
    }

    /// Whether the frozen job is `refused` as damaged, and this one can take its place as where it is lost: all pieces belong
    /// to it, and the surface if there is one.
    pub fn takes_place_of_damaged(&self, refused: &Failure, job: &Job) -> bool {
        if !matches!(refused.message().code, Code::Damaged | Code::JobSpec) {
            return false;
        }
        let surface = self.root().open_file(SURFACE).ok();
        let footer = surface.and_then(|file| Some((text_of_key(&file, JOB_KEY)?, text_of_key(&file, JOB_HASH_KEY)?)));
        let fits = |(text, hash): (String, String)| match (JobSource { path: self.surface(), text }).job_to_read() {
            Ok(other) => other.experiment_hash() == job.experiment_hash(),
            Err(_) => hash == job.hash(),
        };
        footer.is_none_or(fits) && self.tally_with_audits(job).is_ok()
    }

    /// Freezes the job, in place of the one before if there is one. This process must work alone.
    pub fn freeze(&self, source: &JobSource, job: &Job) -> Result<(), Failure> {
        let text = source.frozen(job);
        self.expect_job(&text, job)?;
        self.publish(JOB, text.as_bytes())
    }

    /// Freezes the job, unless another process has just frozen one where no lock keeps it out; returns false then.
    pub fn freeze_first(&self, source: &JobSource, job: &Job) -> Result<bool, Failure> {
        let text = source.frozen(job);
        self.expect_job(&text, job)?;
        let path = self.path().join(JOB);
        let is_first =
            self.root().publish_first(JOB, text.as_bytes()).map_err(|error| Failure::writing(&path, error))?;
        if !is_first {
            // What the other one asks is not known.
            self.change_digests(|digests| {
                asked_tables(&text, job).iter().for_each(|(table, _)| digests.set(&entry_of(table), None));
            })?;
        }
        Ok(is_first)
    }

    /// Writes the digest of the text of a job, and of what it asks of its result, which the surface does not hold.
    fn expect_job(&self, text: &str, job: &Job) -> Result<(), Failure> {
        self.change_digests(|digests| {
            self.expect_among(digests, JOB, &digest_of_bytes(text.as_bytes()));
            set_asked(digests, text, job);
        })
    }

    /// Of the tables that ask for something of the result, those that a job lacks of the one that was frozen, or may lack. `text` is
    /// what it was read from.
    pub fn lacking_tables(&self, text: &str, job: &Job) -> Result<Vec<String>, Failure> {
        let named = |(table, lack)| match lack {
            Lack::Certain => format!("[{table}]"),
            Lack::Possible => format!("[{table}] if it had one"),
        };
        Ok(self.lacks(text, job)?.into_iter().map(named).collect())
    }

    /// Of them, those that it surely lacks.
    pub fn lost_tables(&self, text: &str, job: &Job) -> Result<Vec<String>, Failure> {
        let surely = |(table, lack)| (lack == Lack::Certain).then(|| format!("[{table}]"));
        Ok(self.lacks(text, job)?.into_iter().filter_map(surely).collect())
    }

    fn lacks(&self, text: &str, job: &Job) -> Result<Vec<(&'static str, Lack)>, Failure> {
        let known = Known::read(self.root())?;
        let lack = |(table, asked): (&'static str, String)| {
            let lack = match known.fit(&entry_of(table), &digest_of_bytes(asked.as_bytes())) {
                Fit::Differs => Some(Lack::Certain),
                Fit::Unknown if asked.is_empty() => Some(Lack::Possible),
                Fit::Fits | Fit::Unknown => None,
            };
            lack.map(|lack| (table, lack))
        };
        Ok(asked_tables(text, job).into_iter().filter_map(lack).collect())
    }
}

/// Whether a job lacks a table of the one that was frozen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Lack {
    /// It does.
    Certain,
    /// It does if that one had it, which is not known.
    Possible,
}

/// The tables of a job that ask for something of its result, and what they hold: nothing where there is none. Of `[target]`, which
/// options of a command replace, only that there is one.
fn asked_tables(text: &str, job: &Job) -> [(&'static str, String); 2] {
    let has_target = text.parse::<toml_edit::DocumentMut>().is_ok_and(|text| text.contains_key("target"));
    [("limit", job.limit_table()), ("target", if has_target { "[target]".to_owned() } else { String::new() })]
}

/// The name among the digests of what a table of the job asks of the result.
fn entry_of(table: &str) -> String {
    format!("{JOB} [{table}]")
}

/// Sets the digests of what a job asks of its result.
fn set_asked(digests: &mut Digests, text: &str, job: &Job) {
    for (table, asked) in asked_tables(text, job) {
        digests.set(&entry_of(table), Some(digest_of_bytes(asked.as_bytes())));
    }
}

/// Those digests as they are known, else of this job.
pub fn keep_asked(digests: &mut Digests, known: &Digests, text: &str, job: &Job) {
    set_asked(digests, text, job);
    for (table, _) in asked_tables(text, job) {
        digests.keep(&entry_of(table), known);
    }
}
