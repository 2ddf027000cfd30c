//! Options of `sbatch`: on the command line any, in a job those that ask for resources. A job may come from somebody else,
//! and others of its options write files, run programs or send mails.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use crate::shell::in_quotes;

/// The options that a job may have: the name, the short form, and whether it needs a value.
const OF_JOBS: [(&str, Option<char>, bool); 35] = [
    ("account", Some('A'), true),
    ("begin", Some('b'), true),
    ("comment", None, true),
    ("constraint", Some('C'), true),
    ("contiguous", None, false),
    ("core-spec", Some('S'), true),
    ("cores-per-socket", None, true),
    ("cpus-per-task", Some('c'), true),
    ("deadline", None, true),
    ("exclude", Some('x'), true),
    ("exclusive", None, false),
    ("gpus", Some('G'), true),
    ("gres", None, true),
    ("hint", None, true),
    ("licenses", Some('L'), true),
    ("mem", None, true),
    ("mem-per-cpu", None, true),
    ("mincpus", None, true),
    ("nice", None, false),
    ("nodelist", Some('w'), true),
    ("nodes", Some('N'), true),
    ("ntasks", Some('n'), true),
    ("partition", Some('p'), true),
    ("prefer", None, true),
    ("priority", None, true),
    ("qos", Some('q'), true),
    ("reservation", None, true),
    ("sockets-per-node", None, true),
    ("switches", None, true),
    ("thread-spec", None, true),
    ("threads-per-core", None, true),
    ("time", Some('t'), true),
    ("time-min", None, true),
    ("tmp", None, true),
    ("wckey", None, true),
];

/// An option of sbatch, in the words of a line `#SBATCH`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SbatchOption {
    text: String,
    /// Where it stands in a job, if it does.
    place: Option<Range<usize>>,
}

impl SbatchOption {
    /// The same, which stands there in a job.
    pub(super) fn at(self, place: Range<usize>) -> Self {
        Self { place: Some(place), ..self }
    }
}

impl FromStr for SbatchOption {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text.starts_with('-') && text.len() > 1 && !text.chars().any(char::is_control) {
            Ok(Self { text: text.to_owned(), place: None })
        } else {
            Err(format!("{text:?} is no option of sbatch in one line; write for example \"--constraint=avx2\""))
        }
    }
}

impl fmt::Display for SbatchOption {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

/// Those of the options that are not for a job, each with its place there and what is said of it.
pub fn not_for_jobs(options: &[SbatchOption]) -> impl Iterator<Item = (Option<Range<usize>>, String)> {
    options.iter().filter(|option| !is_for_jobs(&option.text)).map(|SbatchOption { text, place }| {
        let message = format!(
            "engine.sbatch: {text:?} is not for a job, which may come from somebody else. There it may be one of {}; with one value, --qos=long or -q long, without spaces, quotes, \\ and #, or in double quotes without \\ and #. Take it out of the job, and give it on the command line: --sbatch={}",
            allowed(),
            in_quotes(text)
        );
        (place.clone(), message)
    })
}

/// The options of jobs in words.
fn allowed() -> String {
    let name = |(long, short, _): (&str, Option<char>, bool)| match short {
        Some(short) => format!("--{long} (-{short})"),
        None => format!("--{long}"),
    };
    OF_JOBS.map(name).join(", ")
}

/// Whether a job may have an option: one of the list by its whole name, and nothing else in the same line.
fn is_for_jobs(text: &str) -> bool {
    if let Some(option) = text.strip_prefix("--") {
        let (name, value) = option.split_at(option.find(['=', ' ']).unwrap_or(option.len()));
        let known = OF_JOBS.iter().find(|(long, ..)| *long == name);
        return known.is_some_and(|(.., needs_value)| match value.strip_prefix('=') {
            Some(value) => is_one_word(value),
            // A value of its own never belongs to an option that may do without, and one that lacks its value would take
            // the next line.
            None if *needs_value => is_separate_word(value),
            None => value.is_empty(),
        });
    }
    OF_JOBS
        .iter()
        .filter_map(|(_, short, _)| text.strip_prefix('-')?.strip_prefix((*short)?))
        .any(|value| is_one_word(value) || is_separate_word(value))
}

/// Whether this is a word after a space that sbatch does not take for an option.
fn is_separate_word(text: &str) -> bool {
    text.strip_prefix(' ').is_some_and(|word| !word.starts_with('-') && is_one_word(word))
}

/// Whether sbatch reads this as one word.
fn is_one_word(text: &str) -> bool {
    let quoted = text.strip_prefix('"').and_then(|text| text.strip_suffix('"'));
    let is_plain = |c: char| !c.is_whitespace() && c != '\'';
    let is_safe = |c: char| !c.is_control() && !['"', '\\', '#'].contains(&c);
    match quoted {
        Some(inside) => inside.chars().all(is_safe),
        None => !text.is_empty() && text.chars().all(|c| is_plain(c) && is_safe(c)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_job_may_ask_for_resources_alone() {
        for text in [
            "--qos=long",
            "--qos long",
            "-q long",
            "-qlong",
            "-p short,long",
            "-A brakes",
            "--account=brakes",
            "-t 2:00:00",
            "--time=1-12",
            "--mem=2G",
            "-c 4",
            "--cpus-per-task=4",
            "-C avx2&ssd",
            "--constraint=[rack1|rack2]",
            "-w n[1-4]",
            "--nodelist=n1",
            "--exclusive",
            "--exclusive=user",
            "--nice=-5",
            "--comment=\"brake study\"",
            "--comment \"it's one\"",
        ] {
            assert!(is_for_jobs(text), "{text}");
        }
        for text in [
            "--output=/root/.bashrc",
            "-o/root/.bashrc",
            "-o /root/.bashrc",
            "--error=x",
            "-e x",
            "--input=/etc/passwd",
            "-i x",
            "--export=ALL,LD_PRELOAD=/tmp/x.so",
            "--export-file=x",
            "--chdir=/",
            "-D /",
            "--wrap=id",
            "--get-user-env",
            "--bbf=x",
            "--nodefile=/etc/passwd",
            "-F /etc/passwd",
            "--mail-user=a@b",
            "--array=1-9",
            "--signal=B:KILL@1",
            "--uid=0",
            "--container=x",
            "--dependency=singleton",
            "--",
            "-",
            // Abbreviations, and letters without a value before another.
            "--out=x",
            "--part=x",
            "-Qo/root/.bashrc",
            "-Ho x",
            // More than one option in a line, however it is written.
            "--qos=low --output=/root/.bashrc",
            "--qos= --output=x",
            "--qos low -o x",
            "--qos --output=x",
            "--qos -ox",
            "-q -ox",
            "-q low -o x",
            "--exclusive --output=x",
            "--exclusive user",
            "--comment=\"a\" --output=x",
            "--comment=\"a\" --output=\"x\"",
            "--comment=a\u{a0}-ox",
            "--comment=\"a\\\" --output=x \"",
            "--comment='a' -ox '",
            "--comment=a#b",
            "--qos",
            "--qos=",
            "-q",
            "--qos\t-ox",
        ] {
            assert!(!is_for_jobs(text), "{text}");
        }
    }

    #[test]
    fn the_reference_names_every_option() {
        let page = include_str!("../../../../docs/reference/job-spec.md").replace('\n', " ");
        for (long, short, _) in OF_JOBS {
            let short = short.map_or(String::new(), |short| format!(" (`-{short}`)"));
            assert!(page.contains(&format!("`--{long}`{short}")), "{long}");
        }
    }

    #[test]
    fn what_is_said_of_an_option_names_it_and_what_is_allowed() {
        let options: Vec<SbatchOption> =
            ["--output=it's", "--qos=low"].iter().map(|text| text.parse().unwrap()).collect();
        let said: Vec<String> = not_for_jobs(&options).map(|(_, message)| message).collect();
        assert_eq!(said.len(), 1);
        for part in ["engine.sbatch: \"--output=it's\"", "--qos (-q)", "--mem,", "--sbatch='--output=it'\\''s'"] {
            assert!(said[0].contains(part), "{part} is not in: {}", said[0]);
        }
    }
}
