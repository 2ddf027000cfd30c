//! The table `[engine]` of a job spec: where and in how many shards the job is computed. Its result depends on none of
//! it, so that it belongs neither to the normalised job nor to its identity.

use std::fmt;
use std::str::FromStr;

use schemars::JsonSchema;
use serde::Deserialize;
use toml::Spanned;

use super::diagnosis::{Complaint, Complaints};
use super::sbatch::{SbatchOption, not_for_jobs};

/// Largest number of processors of a task.
pub const MOST_CPUS: u64 = 1024;

/// Largest number of shards.
pub const MOST_SHARDS: u64 = 1_000_000;

/// What a cluster is asked for with `submit --engine`; options of the command line count before it.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EngineSpec {
    /// Slurm: the partition, by default the cluster's. Letters, digits and `-_.,:@+/`.
    #[schemars(with = "Option<String>")]
    partition: Option<Spanned<String>>,
    /// Slurm: the account that is charged, by default yours. Letters, digits and `-_.,:@+/`.
    #[schemars(with = "Option<String>")]
    account: Option<Spanned<String>>,
    /// Slurm: the time limit of a task, from a minute up, as Slurm writes it: `"30"` (minutes), `"2:00:00"` or
    /// `"1-12"`; by default the partition's.
    #[schemars(with = "Option<String>")]
    time: Option<Spanned<String>>,
    /// Slurm: the memory of a task, for example `"2G"`; by default the partition's.
    #[schemars(with = "Option<String>")]
    memory: Option<Spanned<String>>,
    /// Slurm: processors of a task, and its threads.
    #[schemars(with = "Option<u64>", range(min = 1, max = MOST_CPUS), extend("default" = 1))]
    cpus_per_task: Option<Spanned<u64>>,
    /// The number of shards; by default by cost, so many that one takes about ten minutes.
    #[schemars(with = "Option<u64>", range(min = 1, max = MOST_SHARDS))]
    shards: Option<Spanned<u64>>,
    /// The largest number of shards where `shards` is left out; by default 1000, or what the cluster allows in an
    /// array.
    #[schemars(with = "Option<u64>", range(min = 1, max = MOST_SHARDS))]
    max_shards: Option<Spanned<u64>>,
    /// Slurm: further options of `sbatch` that ask for resources, as a line `#SBATCH` has them, one each:
    /// `["--constraint=avx2", "--qos=long"]`. Others are for `--sbatch` of the command line.
    #[schemars(with = "Option<Vec<String>>")]
    sbatch: Option<Vec<Spanned<String>>>,
}

/// What a cluster is asked for, checked: nothing in it can end a line of a script.
#[derive(Debug, Clone, Default)]
pub struct EngineSettings {
    /// The partition of Slurm.
    pub partition: Option<SlurmName>,
    /// The account of Slurm.
    pub account: Option<SlurmName>,
    /// The time limit of a task.
    pub time: Option<TimeLimit>,
    /// The memory of a task.
    pub memory: Option<Memory>,
    /// Processors of a task.
    pub cpus_per_task: Option<u64>,
    /// The number of shards.
    pub shards: Option<u64>,
    /// The largest number of shards, if it is not given.
    pub max_shards: Option<u64>,
    /// Further options of sbatch.
    pub sbatch: Vec<SbatchOption>,
}

impl EngineSettings {
    /// The checked settings of a spec.
    pub fn validate(spec: &EngineSpec, complaints: &mut Complaints) -> Self {
        let mut number = |key: &str, value: &Option<Spanned<u64>>, most: u64| {
            let value = value.as_ref()?;
            if !(1..=most).contains(value.get_ref()) {
                let message = format!("engine.{key} = {} must be from 1 to {most}", value.get_ref());
                complaints.push(Complaint::at(value.span(), message));
            }
            Some(*value.get_ref())
        };
        let cpus_per_task = number("cpus_per_task", &spec.cpus_per_task, MOST_CPUS);
        let shards = number("shards", &spec.shards, MOST_SHARDS);
        let max_shards = number("max_shards", &spec.max_shards, MOST_SHARDS);
        let further = spec.sbatch.iter().flatten().filter_map(|option| {
            parsed("sbatch", Some(option), complaints).map(|parsed: SbatchOption| parsed.at(option.span()))
        });
        let sbatch = further.collect();
        Self {
            partition: parsed("partition", spec.partition.as_ref(), complaints),
            account: parsed("account", spec.account.as_ref(), complaints),
            time: parsed("time", spec.time.as_ref(), complaints),
            memory: parsed("memory", spec.memory.as_ref(), complaints),
            cpus_per_task,
            shards,
            max_shards,
            sbatch,
        }
    }

    /// What is said of the options of sbatch that are not for a job, in the order of its text.
    pub(super) fn not_for_jobs(&self) -> Complaints {
        let mut complaints = Complaints::default();
        not_for_jobs(&self.sbatch).for_each(|(place, message)| complaints.push(Complaint::maybe_at(place, message)));
        complaints
    }

    /// These settings, and for what they leave out those of `others`. Further options of sbatch are added to theirs, as
    /// the last one of a name counts.
    pub fn or(self, others: &Self) -> Self {
        let others = others.clone();
        Self {
            partition: self.partition.or(others.partition),
            account: self.account.or(others.account),
            time: self.time.or(others.time),
            memory: self.memory.or(others.memory),
            cpus_per_task: self.cpus_per_task.or(others.cpus_per_task),
            shards: self.shards.or(others.shards),
            max_shards: self.max_shards.or(others.max_shards),
            sbatch: others.sbatch.into_iter().chain(self.sbatch).collect(),
        }
    }
}

/// A value that is written as a text.
fn parsed<T: FromStr<Err = String>>(
    key: &str,
    value: Option<&Spanned<String>>,
    complaints: &mut Complaints,
) -> Option<T> {
    let value = value?;
    let parsed = value.get_ref().parse();
    complaints.take(parsed.map_err(|why| Complaint::at(value.span(), format!("engine.{key}: {why}"))))
}

/// A name that Slurm knows, or several with commas: of a partition or an account.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SlurmName(String);

impl FromStr for SlurmName {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let is_allowed = |c: char| c.is_ascii_alphanumeric() || "-_.,:@+/".contains(c);
        if text.is_empty() || text.len() > 200 || text.starts_with('-') || !text.chars().all(is_allowed) {
            return Err(format!(
                "{text:?} is not a valid Slurm name: use 1 to 200 letters, digits and -_.,:@+/ not starting with '-'"
            ));
        }
        Ok(Self(text.to_owned()))
    }
}

impl fmt::Display for SlurmName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// A time limit in one of the forms of Slurm.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TimeLimit {
    text: String,
    /// The same in seconds.
    pub seconds: u64,
}

impl TimeLimit {
    /// So many seconds, rounded up to an hour.
    pub fn covering(seconds: f64) -> Self {
        let hours = ((seconds / 3600.0).ceil() as u64).clamp(1, 24 * 999_999);
        let text = if hours < 24 { format!("{hours}:00:00") } else { format!("{}-{}", hours / 24, hours % 24) };
        Self { text, seconds: 3600 * hours }
    }
}

impl FromStr for TimeLimit {
    type Err = String;

    /// `minutes`, `minutes:seconds`, `hours:minutes:seconds`, `days-hours`, `days-hours:minutes` or
    /// `days-hours:minutes:seconds`.
    fn from_str(text: &str) -> Result<Self, String> {
        let number = |digits: &str| -> Option<u64> {
            let is_number = (1..=6).contains(&digits.len()) && digits.bytes().all(|byte| byte.is_ascii_digit());
            is_number.then(|| digits.parse().ok()).flatten()
        };
        let (days, rest) = text.split_once('-').map_or((None, text), |(days, rest)| (Some(days), rest));
        let parts: Option<Vec<u64>> = rest.split(':').map(number).collect();
        let seconds = match (days.map(number), parts.as_deref()) {
            (None, Some(&[minutes])) => Some(60 * minutes),
            (None, Some(&[minutes, seconds])) => Some(60 * minutes + seconds),
            (None, Some(&[hours, minutes, seconds])) => Some(3600 * hours + 60 * minutes + seconds),
            (Some(Some(days)), Some(&[hours, ref rest @ ..])) if rest.len() <= 2 => {
                let [minutes, seconds] = [0, 1].map(|place| rest.get(place).copied().unwrap_or(0));
                Some(86400 * days + 3600 * hours + 60 * minutes + seconds)
            }
            _ => None,
        };
        match seconds {
            Some(seconds @ 60..) => Ok(Self { text: text.to_owned(), seconds }),
            _ => Err(format!(
                "{text:?} is not a valid Slurm time limit of one minute or more; write minutes (\"30\"), \"hours:minutes:seconds\" or \"days-hours\""
            )),
        }
    }
}

impl fmt::Display for TimeLimit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

/// An amount of memory as Slurm writes it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Memory(String);

impl FromStr for Memory {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let digits = text.strip_suffix(['K', 'M', 'G', 'T']).unwrap_or(text);
        if (1..=12).contains(&digits.len()) && digits.bytes().all(|byte| byte.is_ascii_digit()) {
            Ok(Self(text.to_owned()))
        } else {
            Err(format!("{text:?} is no amount of memory; write a whole number with K, M, G or T, for example \"2G\""))
        }
    }
}

impl fmt::Display for Memory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_limits_are_those_of_slurm() {
        for (text, seconds) in [
            ("30", Some(1800)),
            ("1:30", Some(90)),
            ("2:00:00", Some(7200)),
            ("1-12", Some(129_600)),
            ("1-12:30", Some(131_400)),
            ("1-12:30:15", Some(131_415)),
            ("0", None),
            ("0:59", None),
            ("", None),
            ("-5", None),
            ("1-", None),
            ("1:2:3:4", None),
            ("1-1:2:3:4", None),
            ("ten", None),
            ("5\n#", None),
            ("99999999999999999999", None),
        ] {
            assert_eq!(text.parse::<TimeLimit>().ok().map(|limit| limit.seconds), seconds, "{text:?}");
        }
    }

    #[test]
    fn time_limits_cover_a_time() {
        for (seconds, text) in [(0.0, "1:00:00"), (3601.0, "2:00:00"), (86_400.0, "1-0"), (1e30, "999999-0")] {
            let limit = TimeLimit::covering(seconds);
            assert_eq!((limit.to_string().as_str(), text.parse()), (text, Ok(limit)));
        }
    }

    #[test]
    fn nothing_can_end_a_line() {
        for text in ["", "-x", "a b", "a\nb", "a;b", "$(a)", "a'b", "#"] {
            assert!(text.parse::<SlurmName>().is_err(), "{text:?}");
        }
        assert!("short,long".parse::<SlurmName>().is_ok());
        for text in ["", "2 G", "G", "2GB", "-2", "2\n"] {
            assert!(text.parse::<Memory>().is_err(), "{text:?}");
        }
        assert!("2G".parse::<Memory>().is_ok() && "512".parse::<Memory>().is_ok());
        for text in ["", "-", "constraint=a", "--a\n--b", "--a\r"] {
            assert!(text.parse::<SbatchOption>().is_err(), "{text:?}");
        }
        assert!("--comment=\"a b\"".parse::<SbatchOption>().is_ok());
    }

    #[test]
    fn settings_that_are_given_count_before_others() {
        let option = |text: &str| text.parse::<SbatchOption>().unwrap();
        let given = EngineSettings { shards: Some(3), sbatch: vec![option("--a")], ..EngineSettings::default() };
        let others = EngineSettings {
            shards: Some(5),
            cpus_per_task: Some(2),
            sbatch: vec![option("--b")],
            ..EngineSettings::default()
        };
        let both = given.or(&others);
        assert_eq!((both.shards, both.cpus_per_task), (Some(3), Some(2)));
        assert_eq!(both.sbatch, [option("--b"), option("--a")]);
    }
}
