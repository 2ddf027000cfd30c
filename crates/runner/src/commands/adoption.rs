//! Checking whether a job may be submitted to a run directory.

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant};

use crate::evaluate::parts::Parts;
use crate::failure::Failure;
use crate::job::{Job, JobSource};
use crate::messages::{Code, Message, Place};
use crate::output::{note, quoted, shown};
use crate::store::directory::RunDirectory;
use crate::store::layout::JOB;
use crate::store::lock::{AN_INSTANT, Access};
use crate::store::tally::Tally;

/// The state of the run of a submitted job.
pub enum RunState {
    /// New, or a finished run that now gets more samples, or one without samples, which is computed as a whole.
    New(Tally),
    /// Some samples are counted.
    Unfinished(Tally),
    /// All samples are counted.
    Finished(Tally),
}

impl RunState {
    /// The samples that are counted already.
    pub fn into_tally(self) -> Tally {
        match self {
            Self::New(tally) | Self::Unfinished(tally) | Self::Finished(tally) => tally,
        }
    }
}

/// Freezes a job in a run directory that has none, or checks that the directory belongs to the same job. Returns the
/// job with the name and description of the run.
///
/// # Errors
/// A directory that belongs to another job, or to the same one with more samples or unfinished with fewer.
pub fn adopt(directory: &RunDirectory, source: &JobSource, job: Job) -> Result<(Job, RunState), Failure> {
    let frozen = directory.job();
    if let Err(refused) = &frozen
        && directory.takes_place_of_damaged(refused, &job)
    {
        directory.freeze(source, &job)?;
        let was = if refused.message().code == Code::Damaged { "was damaged" } else { "is refused" };
        note(format_args!("{} {was}; it is written again", directory.path().join(JOB).display()));
    }
    if directory.job_source()?.is_none() {
        // There may be pieces without a job.toml, if somebody removed it. Those of this job count; others are refused
        // before anything is written. Meanwhile, another shard may have frozen the job.
        let tally = directory.tally_with_audits(&job);
        if directory.job_source()?.is_none() {
            let tally = tally?;
            if directory.freeze_first(source, &job)? {
                return Ok((job, RunState::New(tally)));
            }
        }
    }
    let existing = frozen.or_else(|_| directory.job())?;
    let path = quoted(directory.path());
    if is_another(&existing, &job) {
        return Err(Failure::Job(format!(
            "{path} holds a run of another job: {}. Choose another directory with --out, or replace that run with --overwrite",
            first_difference(&existing.normalised(), &job.normalised())
        ))
        .coded(Code::JobDiffers)
        .remedied("--out"));
    }
    let (wanted, there) = (job.sampling.samples, existing.sampling.samples);
    let at_most = if job.stops_by_precision() { "at most " } else { "" };
    if wanted < there {
        return Err(Failure::Job(format!(
            "{path} holds a run of this job with {at_most}{there} samples in each cell, more than the {wanted} of this one. Use --samples {there}, choose another directory with --out, or replace that run with --overwrite"
        ))
        .coded(Code::RunHasMore)
        .remedied(format!("--samples {there}")));
    }
    let tally = directory.tally(&existing)?;
    let finished = Parts::new(&existing).are_complete(&tally);
    if wanted == there {
        let state = match finished {
            true => RunState::Finished(tally),
            false if existing.draws_samples() => RunState::Unfinished(tally),
            false => RunState::New(tally),
        };
        return Ok((existing, state));
    }
    if !finished {
        let resume = format!("stickslip resume {path}");
        return Err(Failure::CannotCreate(format!(
            "{path} holds an unfinished run of this job with {at_most}{there} samples in each cell; finish it with `{resume}`, then submit the job with {wanted}"
        ))
        .coded(Code::RunToExtend)
        .remedied(resume));
    }
    note(format_args!("{path}: from {at_most}{there} to {at_most}{wanted} samples in each cell"));
    directory.freeze(source, &job)?;
    // With more samples, a cell may have more parts.
    let tally = directory.tally(&job)?;
    Ok((job, RunState::New(tally)))
}

/// Whether a job can neither be that of a run nor extend it. With more samples it may have more plain ones beside its
/// probabilities, as it has by default, but not fewer.
fn is_another(existing: &Job, job: &Job) -> bool {
    // Their usual number may not be known of a run without its files.
    let have_the_same = || existing.extension_hash() == job.extension_hash();
    existing.experiment_hash() != job.experiment_hash()
        || match job.sampling.samples.cmp(&existing.sampling.samples) {
            Ordering::Less => !have_the_same(),
            Ordering::Equal => existing.hash() != job.hash(),
            Ordering::Greater => !have_the_same() && job.plain_samples() < existing.plain_samples(),
        }
}

/// The directory of a job: `out`, or where that holds a run of another job, one beside it with a digest of this one in
/// its name.
pub fn apart(out: &Path, job: &Job) -> Result<RunDirectory, Failure> {
    let mut beside = out.as_os_str().to_owned();
    beside.push(format!("-{}", &job.extension_hash()[..8]));
    let beside = PathBuf::from(beside);
    if !beside.join(JOB).exists()
        && let Some(directory) = unless_of_another(out, job)?
    {
        return Ok(directory);
    }
    let text = format!("{} holds a run of another job; this one goes to {}", shown(out), shown(&beside));
    Message { place: Some(Place::file(&beside)), ..Message::new(Code::RunApart, &text) }.send();
    RunDirectory::create(&beside, Access::Alone, AN_INSTANT)
}

/// The directory `out`, unless it holds a run of another job. Files that this run names, such as its matrices, may be
/// gone.
fn unless_of_another(out: &Path, job: &Job) -> Result<Option<RunDirectory>, Failure> {
    let is_of_another =
        |directory: &RunDirectory| directory.job_to_read().is_ok_and(|existing| is_another(&existing, job));
    let started = Instant::now();
    loop {
        let busy = match RunDirectory::create(out, Access::Alone, AN_INSTANT) {
            Ok(directory) => return Ok(Some(directory).filter(|directory| !is_of_another(directory))),
            Err(busy) if busy.is_in_use() => busy,
            Err(other) => return Err(other),
        };
        let viewed = RunDirectory::view(out).ok();
        if viewed.as_ref().is_some_and(is_of_another) {
            return Ok(None);
        }
        // The other process may be about to freeze its job.
        let has_job = viewed.is_some_and(|directory| !matches!(directory.job_source(), Ok(None)));
        if has_job || started.elapsed() >= PATIENCE {
            return Err(busy);
        }
        thread::sleep(PAUSE);
    }
}

/// How long a shard waits for a process that works alone: the first shard freezes the job, and reads what is there.
const PATIENCE: Duration = Duration::from_secs(20);

/// Time between two tries.
const PAUSE: Duration = Duration::from_millis(20);

/// The same for a shard. The one that freezes the job, or raises its number of samples, works alone for that moment, so
/// that shards of different jobs cannot both do it.
pub fn adopt_as_shard(out: &Path, source: &JobSource, job: &Job) -> Result<(RunDirectory, Job, RunState), Failure> {
    let started = Instant::now();
    loop {
        let busy = match RunDirectory::create(out, Access::Alone, Duration::ZERO) {
            Ok(directory) => {
                let (job, state) = adopt(&directory, source, job.clone())?;
                return Ok((directory.share()?, job, state));
            }
            Err(busy) if busy.is_in_use() => busy,
            Err(other) => return Err(other),
        };
        // Other shards are at work, or soon will be.
        let directory = RunDirectory::create(out, Access::Shared, PATIENCE)?;
        if let Some(frozen) = directory.job_source()?
            && frozen.job()?.sampling.samples >= job.sampling.samples
        {
            let (job, state) = adopt(&directory, source, job.clone())?;
            return Ok((directory, job, state));
        }
        if started.elapsed() >= PATIENCE {
            return Err(busy);
        }
        drop(directory);
        thread::sleep(PAUSE);
    }
}

/// The first key in which two normalised jobs differ, by its whole name.
fn first_difference(existing: &str, new: &str) -> String {
    let (a, b) = (settings(existing), settings(new));
    for (key, ours) in &a {
        match b.get(key) {
            Some(theirs) if theirs == ours => {}
            Some(theirs) => {
                let (ours, theirs) = (excerpt(ours, theirs), excerpt(theirs, ours));
                return format!("it has `{key} = {ours}`, the job has `{key} = {theirs}`");
            }
            None => return format!("it has `{key} = {}`, the job does not", excerpt(ours, "")),
        }
    }
    match b.iter().find(|(key, _)| !a.contains_key(*key)) {
        Some((key, theirs)) => format!("the job has `{key} = {}`, the run does not", excerpt(theirs, "")),
        None => "it is of another version".to_owned(),
    }
}

/// The values of a normalised job by their whole keys, but for those that may differ.
fn settings(job: &str) -> BTreeMap<String, String> {
    fn add(prefix: &str, table: &toml::Table, found: &mut BTreeMap<String, String>) {
        for (name, value) in table {
            let name = if name.contains('.') { format!("\"{name}\"") } else { name.clone() };
            let key = if prefix.is_empty() { name } else { format!("{prefix}.{name}") };
            match value {
                toml::Value::Table(table) => add(&key, table, found),
                value => drop(found.insert(key, value.to_string())),
            }
        }
    }
    let mut found = BTreeMap::new();
    // It was written by this program.
    add("", &job.parse().unwrap_or_default(), &mut found);
    for key in ["name", "description", "sampling.samples", "sampling.until.at_most"] {
        found.remove(key);
    }
    found
}

/// A value, or the excerpt of a long one that begins to differ from another one.
fn excerpt(line: &str, other: &str) -> String {
    const LONGEST: usize = 120;
    if line.chars().count() <= LONGEST {
        return line.to_owned();
    }
    let common = line.chars().zip(other.chars()).take_while(|(a, b)| a == b).count();
    let first = common.saturating_sub(LONGEST / 2);
    let part: String = line.chars().skip(first).take(LONGEST).collect();
    format!("{}{part}...", if first > 0 { "..." } else { "" })
}
