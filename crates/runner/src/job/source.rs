//! The text of a job spec: where it came from, and what the command line changes in it.

use std::fs;
use std::path::{Path, PathBuf};

use super::diagnosis::Complaint;
use super::spec::JobSpec;
use super::validated::Job;
use crate::failure::Failure;

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
    /// Reads a job spec from a file.
    pub fn read(path: &Path) -> Result<Self, Failure> {
        let text = fs::read_to_string(path).map_err(|error| Failure::reading(path, error))?;
        Ok(Self { path: path.to_owned(), text })
    }

    /// Writes the command line's changes into the text, comments and layout kept.
    pub fn with(mut self, overrides: Overrides) -> Result<Self, Failure> {
        let changes = [("seed", overrides.seed), ("samples", overrides.samples)];
        if changes.iter().all(|(_, value)| value.is_none()) {
            return Ok(self);
        }
        // A text that does not parse is left to `job`, which says where and why.
        let Ok(mut document) = self.text.parse::<toml_edit::DocumentMut>() else { return Ok(self) };
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
                let Some(until) = table.get_mut("until").and_then(toml_edit::Item::as_table_like_mut) else {
                    return Ok(self);
                };
                table = until;
            }
            let mut new = toml_edit::Value::from(value);
            if let Some(old) = table.get(key).and_then(toml_edit::Item::as_value) {
                *new.decor_mut() = old.decor().clone();
            }
            table.insert(key, toml_edit::Item::Value(new));
        }
        self.text = document.to_string();
        Ok(self)
    }

    /// Parses and validates the spec.
    pub fn job(&self) -> Result<Job, Failure> {
        let complain = |complaint: Complaint| Failure::Job(complaint.render(&self.path, &self.text));
        let spec: JobSpec = toml::from_str(&self.text).map_err(|error| complain(Complaint::from_parser(&error)))?;
        Job::validate(spec).map_err(complain)
    }
}
