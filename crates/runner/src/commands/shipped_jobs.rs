//! The jobs that come with the program, as the folder `jobs/` of its sources has them.

use crate::job::keys::nearest;

/// A job, and the files that it names beside it.
#[derive(Debug)]
pub struct ShippedJob {
    /// Its name, which is that of its file but for `.toml`.
    pub name: &'static str,
    /// Its text.
    pub text: &'static str,
    /// The files by the paths that the job names.
    pub files: &'static [(&'static str, &'static [u8])],
}

/// The jobs by name, each with the files that it names.
macro_rules! shipped {
    ($($name:literal $([$($file:literal),*])?,)*) => {
        &[$(ShippedJob {
            name: $name,
            text: include_str!(concat!("../../jobs/", $name, ".toml")),
            files: &[$($(($file, include_bytes!(concat!("../../jobs/", $file)))),*)?],
        }),*]
    };
}

/// All of them, sorted by name.
pub const SHIPPED: &[ShippedJob] = shipped! {
    "belt-oscillator",
    "bstab",
    "fig12",
    "fig13",
    "fig14a",
    "fig14b",
    "fig14c",
    "fig14d",
    "fig15a",
    "fig15b",
    "fig4",
    "hoffmann",
    "hulten",
    "measured-friction" ["measured-friction.csv"],
    "mission" ["mission-friction.csv"],
    "own-brake" ["own-brake/own-brake.mat"],
    "parking",
    "parking-map",
    "table2",
    "table3",
    "veraszto",
};

/// The jobs of `jobs/` that do not come with the program, and why.
const LEFT_OUT: [(&str, &str); 1] =
    [("tu-brake", "its matrices are too large for the program; they are in the folder jobs/ of the sources")];

impl ShippedJob {
    /// The job with a name.
    ///
    /// # Errors
    /// What there is, if there is none.
    pub fn named(name: &str) -> Result<&'static Self, String> {
        let plain = name.trim_start_matches("jobs/").trim_end_matches(".toml");
        if let Some(job) = SHIPPED.iter().find(|job| job.name == plain) {
            return Ok(job);
        }
        if let Some((_, why)) = LEFT_OUT.iter().find(|(left_out, _)| *left_out == plain) {
            return Err(format!("{plain} does not come with the program: {why}"));
        }
        let hint = nearest(plain, SHIPPED.iter().map(|job| job.name));
        let hint = hint.map_or(".".to_owned(), |name| format!("; did you mean {name}?"));
        let all: String = listed().lines().map(|line| format!("\n  {line}")).collect();
        Err(format!("there is no job {name:?}{hint} The jobs are:{all}"))
    }

    /// What it is for, in its own words.
    fn description(&self) -> String {
        let table: toml::Table = self.text.parse().unwrap_or_default();
        table.get("description").and_then(toml::Value::as_str).unwrap_or_default().to_owned()
    }
}

/// A line for each job: its name, and what it is for.
pub fn listed() -> String {
    let width = SHIPPED.iter().map(|job| job.name.len()).max().unwrap_or(0);
    SHIPPED.iter().map(|job| format!("{:width$}  {}\n", job.name, job.description())).collect()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::fs;
    use std::path::Path;

    use super::*;

    #[test]
    fn every_job_of_the_folder_is_shipped_or_left_out_with_a_word() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("jobs");
        let names = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let there: BTreeSet<String> = names.filter_map(|name| Some(name.strip_suffix(".toml")?.to_owned())).collect();
        let known = SHIPPED.iter().map(|job| job.name).chain(LEFT_OUT.map(|(name, _)| name));
        assert_eq!(there, known.map(str::to_owned).collect());
        assert!(SHIPPED.is_sorted_by_key(|job| job.name));
        assert!(SHIPPED.iter().all(|job| !job.description().is_empty()));
    }

    #[test]
    fn a_wrong_name_lists_the_others() {
        assert_eq!(ShippedJob::named("jobs/fig4.toml").unwrap().name, "fig4");
        let all = ShippedJob::named("parking-mop").unwrap_err();
        assert!(all.starts_with("there is no job \"parking-mop\"; did you mean parking-map? The jobs are:\n"), "{all}");
        assert!(all.contains("\n  mission "), "{all}");
        assert!(ShippedJob::named("xyz").unwrap_err().starts_with("there is no job \"xyz\". The jobs are:"));
        assert!(ShippedJob::named("tu-brake").unwrap_err().contains("too large"));
    }
}
