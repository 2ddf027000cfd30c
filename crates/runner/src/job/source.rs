//! The text of a job spec: where it came from, and what the command line changes in it.

use std::io;
use std::path::{Path, PathBuf};

use stickslip_sampler::inputs::Marginal;
use toml_edit::{DocumentMut, Item, TableLike, Value};

use super::diagnosis::Complaints;
use super::models;
use super::reading;
use super::validated::Job;
use super::validation::validate;
use crate::failure::Failure;
use crate::files::bounded::{read, read_file};
use crate::messages::Code;

/// Largest job spec, in bytes: more than the measured values of all random inputs take.
const LARGEST: u64 = 64 << 20;

/// Largest number of values in a job spec, counted by what stands before them. They are read as a whole, which takes some
/// hundred bytes each.
const MOST_VALUES: usize = 3_000_000;

/// The text of a job spec and where it came from.
#[derive(Debug, Clone)]
pub struct JobSource {
    /// For messages.
    pub path: PathBuf,
    /// TOML.
    pub text: String,
}

/// What the command line changes in a job spec.
#[derive(Debug, Clone, Copy, Default)]
pub struct Overrides {
    /// `--seed`.
    pub seed: Option<u64>,
    /// `--samples`; with `until`, its `at_most`.
    pub samples: Option<u64>,
}

impl JobSource {
    /// Reads a job spec from a file, or from standard input where the path is `-`, which messages call job.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let is_input = path == Path::new("-");
        let path = if is_input { PathBuf::from("job") } else { path.to_owned() };
        let bytes = if is_input { read(&mut io::stdin().lock(), LARGEST) } else { read_file(&path, LARGEST) };
        let bytes = bytes.map_err(|error| Failure::reading(&path, error))?;
        let text = String::from_utf8(bytes).map_err(|error| {
            let place = error.utf8_error().valid_up_to();
            let line = error.as_bytes()[..place].iter().filter(|byte| **byte == b'\n').count() + 1;
            Failure::reading(&path, format_args!("line {line} is not text in UTF-8"))
        })?;
        let values = text.bytes().filter(|byte| b",=[{".contains(byte)).count();
        if values > MOST_VALUES {
            let why = format!("it has about {values} values; the limit is {MOST_VALUES}");
            return Err(Failure::reading(&path, why));
        }
        Ok(Self { path, text })
    }

    /// Writes the command line's changes into the text, comments and layout kept.
    pub fn with(mut self, overrides: Overrides) -> Result<Self, Failure> {
        let changes = [("seed", overrides.seed), ("samples", overrides.samples)];
        if changes.iter().all(|(_, value)| value.is_none()) {
            return Ok(self);
        }
        let mut document = match self.text.parse::<DocumentMut>() {
            Ok(document) => document,
            // What is no job either is left to `job`, which says where and why.
            Err(_) if self.job().is_err() => return Ok(self),
            Err(error) => {
                return Err(Failure::Job(format!(
                    "{}: --seed and --samples cannot be noted in it: {}",
                    self.path.display(),
                    error.message()
                )));
            }
        };
        for (key, value) in changes {
            let Some(value) = value else { continue };
            let value = i64::try_from(value).map_err(|_| {
                Failure::Usage(format!("--{key} {value} is too large: it must be at most {}", i64::MAX))
            })?;
            let sampling = document.entry("sampling").or_insert_with(toml_edit::table);
            let Some(mut table) = sampling.as_table_like_mut() else { return Ok(self) };
            // With `until` the number of samples is a limit.
            let stops = key == "samples" && table.contains_key("until");
            let key = if stops { "at_most" } else { key };
            if stops {
                let Some(until) = table.get_mut("until").and_then(Item::as_table_like_mut) else {
                    return Ok(self);
                };
                table = until;
            }
            let mut new = Value::from(value);
            if let Some(old) = table.get(key).and_then(Item::as_value) {
                *new.decor_mut() = old.decor().clone();
            }
            table.insert(key, Item::Value(new));
        }
        self.text = document.to_string();
        Ok(self)
    }

    /// The text with the table `[limit]` of another one, comments and layout kept.
    pub fn with_limits_of(mut self, other: &Self) -> Self {
        if let (Ok(mut own), Ok(mut others)) = (self.text.parse::<DocumentMut>(), other.text.parse::<DocumentMut>())
            && let Some(limits) = others.remove("limit")
        {
            own.insert("limit", limits);
            self.text = own.to_string();
        }
        self
    }

    /// Reads and checks the spec.
    ///
    /// # Errors
    /// Everything that is wrong with it, in the order of the text.
    pub fn job(&self) -> Result<Job, Failure> {
        self.checked(true)
    }

    /// The job for what reads the results of its run: where it is refused with the files that a run does not keep, such as
    /// those of matrices, without them. Nothing can be computed of it then.
    ///
    /// # Errors
    /// As [`JobSource::job`].
    pub fn job_to_read(&self) -> Result<Job, Failure> {
        self.job().or_else(|refused| self.checked(false).map_err(|_| refused))
    }

    fn checked(&self, reads_files: bool) -> Result<Job, Failure> {
        let mut complaints = Complaints::default();
        let folder = self.path.parent().unwrap_or(Path::new(""));
        let job = reading::parse(&self.text, &mut complaints).and_then(|document| {
            let mut draft = models::draft(&self.text, &document, &mut complaints);
            if let (false, Some(draft)) = (reads_files, &mut draft) {
                draft.leave_files();
            }
            let spec = reading::job_spec(&self.text, document, models::suggested, &mut complaints);
            validate(&spec?, draft?, folder, &mut complaints)
        });
        job.ok_or_else(|| self.refused(complaints))
    }

    /// Everything that is wrong with it.
    fn refused(&self, complaints: Complaints) -> Failure {
        let place = complaints.place(&self.path, &self.text, |span| reading::key_at(&self.text, span));
        Failure::Job(complaints.render(&self.path, &self.text)).coded(Code::JobSpec).at(place)
    }

    /// The spec as a run keeps it: measured values stand in it, in place of the file that they were read from.
    pub fn frozen(&self, job: &Job) -> String {
        let Ok(mut document) = self.text.parse::<DocumentMut>() else { return self.text.clone() };
        let mut origins = job.model.freeze(&mut document);
        let distribution = document.get_mut("random").and_then(|random| random.get_mut("distribution"));
        if let Some(distribution) = distribution.and_then(Item::as_table_like_mut) {
            if let (true, Some(marginal)) = (distribution.contains_key("csv"), job.random.marginals.first()) {
                origins += &put_values("random.distribution", distribution, marginal);
            }
            for (input, marginal) in job.random.marginals.iter().enumerate() {
                let name = &job.quantity_of(input).name;
                if let Some(own) = distribution.get_mut(name).and_then(Item::as_table_like_mut)
                    && own.contains_key("csv")
                {
                    origins += &put_values(&format!("random.distribution of {name}"), own, marginal);
                }
            }
        }
        if origins.is_empty() { self.text.clone() } else { format!("{origins}{document}") }
    }
}

/// Replaces the file in the table of a distribution by the values read from it; a comment that says what they were.
fn put_values(key: &str, table: &mut dyn TableLike, marginal: &Marginal) -> String {
    let Marginal::Empirical(measured) = marginal else { return String::new() };
    let text = |key: &str| table.get(key).and_then(Item::as_str).unwrap_or_default().to_owned();
    let origin = format!("# {key}: measured values from {:?}, column {:?}\n", text("csv"), text("column"));
    table.remove("csv");
    table.remove("column");
    table.insert("values", Item::Value(Value::Array(measured.values().iter().copied().collect())));
    origin
}
