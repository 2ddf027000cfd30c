//! Job specs and friction curves with slips of all kinds: each is read or refused, without a panic and in short time.

use std::fs;
use std::panic;
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::friction::{SmoothingSpec, read_curve};
use super::source::{JobSource, Overrides};
use crate::files::forging::{Numbers, time};

/// Longest time on a processor for one of them, whatever else is at work. Most take a hundredth of a second, those that count
/// the modes of a disc a second without optimisation.
const LONGEST: Duration = Duration::from_secs(10);

/// How many are made of each job; of one with a flexible disc, whose modes take a while, fewer.
const OF_EACH: usize = 60;
const OF_EACH_FLEXIBLE: usize = 8;

/// Values that are put in place of others.
const VALUES: [&str; 37] = [
    "0",
    "-0.0",
    "-1",
    "1e308",
    "-1e308",
    "5e-324",
    "nan",
    "inf",
    "-inf",
    "9223372036854775807",
    "-9223372036854775808",
    "18446744073709551615",
    "18446744073709551616",
    "1e999",
    "0x7fffffffffffffff",
    "\"\"",
    "\"\\u0000\"",
    "\"\u{202e}\"",
    "\"/dev/zero\"",
    "\"/\"",
    "[]",
    "[[]]",
    "[0.1, 0.1]",
    "[nan]",
    "[1e308, -1e308]",
    "{}",
    "{ a = 1 }",
    "true",
    "1979-05-27",
    "{ from = 0.0, to = 1.0, points = 1000000000000000000 }",
    "{ from = 0.0, to = 1.0, points = 1000000 }",
    "{ from = 1e-300, to = 1e300, points = 1000, scale = \"log\" }",
    "{ from = 1.0, to = 1.0, points = 2 }",
    "{ preload = 0.1 }",
    "{ preload = { between = [0.1, 0.2] }, static_friction = [0.1, \"normal\", []] }",
    "1,5",
    "'''",
];

/// Lines that are added.
const LINES: [&str; 12] = [
    "[model.friction]",
    "[model.pad]",
    "[axes]",
    "[[axes]]",
    "[random]",
    "\"pad.mass\" = { from = 0.1, to = 1e9, points = 3 }",
    "\"friction.static_coefficient\" = [0.3, 0.4]",
    "correlation = [[\"preload\", \"static_friction\", 2.0]]",
    "law = \"table\"",
    "until = { half_width = 0.0, confidence = 1.0, at_most = 0 }",
    "method = \"sobol\"",
    "]]}}\"\"\"",
];

fn jobs() -> Vec<(PathBuf, String)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../jobs");
    let paths = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut paths: Vec<PathBuf> = paths.filter(|path| path.extension().is_some_and(|end| end == "toml")).collect();
    paths.sort();
    assert!(paths.len() > 10);
    let mut jobs: Vec<(PathBuf, String)> =
        paths.into_iter().map(|path| (path.clone(), fs::read_to_string(path).unwrap())).collect();
    jobs.push((PathBuf::from("example.toml"), include_str!("../commands/example.toml").to_owned()));
    jobs
}

/// Reads a job as commands do.
#[track_caller]
fn read(path: &Path, text: &str) {
    let started = time();
    let result = panic::catch_unwind(|| {
        let source = JobSource { path: path.to_owned(), text: text.to_owned() };
        match source.job() {
            Ok(job) => drop((job.hash(), job.normalised(), job.warnings().len(), source.frozen(&job))),
            Err(failure) => {
                let message = failure.to_string();
                assert!(message.len() < 500_000, "a message of {} bytes", message.len());
            }
        }
        source.with(Overrides { seed: Some(1), samples: Some(2) }).map(|source| source.text.len()).unwrap_or_default()
    });
    assert!(result.is_ok(), "it panicked:\n{}", text.chars().take(5000).collect::<String>());
    let took = time() - started;
    assert!(took < LONGEST, "{took:?} for:\n{}", text.chars().take(5000).collect::<String>());
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn mutated_jobs_are_read_or_refused() {
    let mut numbers = Numbers(14);
    for (path, text) in jobs() {
        let is_rigid = text.contains("kind = \"eigenvalue\"") || text.contains("disc = \"rigid\"");
        for _ in 0..if is_rigid { OF_EACH } else { OF_EACH_FLEXIBLE } {
            read(&path, &mutated(&text, &mut numbers));
        }
    }
}

/// A job with some lines and values changed, in ways that leave most of it readable.
fn mutated(text: &str, numbers: &mut Numbers) -> String {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    for _ in 0..=numbers.below(3) {
        let at = numbers.below(lines.len());
        match numbers.below(8) {
            0..=3 => {
                let with_values: Vec<usize> = (0..lines.len()).filter(|&i| lines[i].contains('=')).collect();
                let at = with_values[numbers.below(with_values.len())];
                let key = lines[at].split('=').next().unwrap().trim_start_matches("# ").to_owned();
                lines[at] = format!("{key}= {}", VALUES[numbers.below(VALUES.len())]);
            }
            4 => drop(lines.remove(at)),
            5 => lines.insert(at, LINES[numbers.below(LINES.len())].to_owned()),
            6 => {
                let other = lines[numbers.below(lines.len())].clone();
                lines.insert(at, other);
            }
            _ => {
                let place = numbers.below(lines[at].chars().count());
                let new = ['"', '[', '{', ',', '\u{0}', '\u{1b}', 'ü', '.', '-', '9'][numbers.below(10)];
                lines[at] = lines[at].chars().enumerate().map(|(i, c)| if i == place { new } else { c }).collect();
            }
        }
    }
    lines.join("\n")
}

#[test]
fn long_jobs_are_read_or_refused() {
    let (path, text) = jobs().into_iter().find(|(path, _)| path.ends_with("fig14a.toml")).unwrap();
    let many = |count: usize, of: &dyn Fn(usize) -> String| (0..count).map(of).collect::<Vec<_>>().join(",");
    let with = |old: &str, new: String| {
        assert!(text.contains(old), "{old}");
        text.replace(old, &new)
    };
    let (scatter, inputs) = ("relative_std = 0.2", "inputs = [\"preload\", \"static_friction\"]");
    let correlations = many(3000, &|_| "[\"preload\", \"static_friction\", 0.1]".to_owned());
    for job in [
        format!("a = {}{}", "[".repeat(20_000), "]".repeat(20_000)),
        format!("a = {}1{}", "{a=".repeat(20_000), "}".repeat(20_000)),
        format!("{}a = 1", "a.".repeat(20_000)),
        format!("[{}a]\nx = 1", "a.".repeat(20_000)),
        format!("k = {}", "1,5 ".repeat(20_000)),
        format!("k = {}x", "1,".repeat(20_000)),
        (0..3000).map(|i| format!("k{i} = 1,5\n")).collect(),
        format!("{text}\n[model.pad]\n{}", (0..1000).map(|i| format!("k{i} = 1\n")).collect::<String>()),
        (0..1000).map(|i| format!("k{i} = 1\n")).collect::<String>() + &text,
        with(scatter, format!("relative_std = [{}]", many(20_000, &|i| format!("{}e-6", i + 1)))),
        with(scatter, format!("{scatter}\ncorrelation = [{correlations}]")),
        with(inputs, format!("inputs = [{}]", many(3000, &|_| "\"preload\"".to_owned()))),
        with("seed = 2018", format!("seed = {}", "9".repeat(100_000))),
        with("\"fig14a\"", format!("\"{}\"", "x".repeat(100_000))),
    ] {
        read(&path, &job);
    }
}

#[test]
fn of_a_long_line_and_of_many_errors_a_part_is_shown() {
    let said = |text: String| JobSource { path: "job.toml".into(), text }.job().unwrap_err().to_string();
    let long = said(format!("name = \"x\"\ndescription = [{}]\n", "0.1, ".repeat(500)));
    assert!(long.lines().all(|line| line.chars().count() < 300), "{long}");
    let marked = said(format!("name = \"{}\" x", "y".repeat(500)));
    let (line, mark) = (marked.lines().nth(2).unwrap(), marked.lines().nth(3).unwrap());
    assert!(line.contains("| ... yyy") && line.as_bytes()[mark.find('^').unwrap()] == b'x', "{marked}");
    let many = said((0..80).map(|i| format!("k{i} = 1,5\n")).collect());
    assert!(many.ends_with("... and 30 more") && many.matches("decimal comma").count() == 50, "{many}");
}

#[test]
fn files_of_any_size_are_refused() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("job.toml");
    let refused = |path: &Path, why: &str| {
        let message = JobSource::read(path).unwrap_err().to_string();
        assert!(message.starts_with("cannot read ") && message.contains(why), "{message}");
    };
    refused(Path::new("/dev/zero"), "larger than 64 MiB");
    fs::write(&path, b"name = \"x\"\n\n\xfc").unwrap();
    refused(&path, "line 3 is not text in UTF-8");
    fs::write(&path, format!("a = [{}]", "1,".repeat(3_000_000))).unwrap();
    refused(&path, "the limit is 3000000");
    let curve = |file: &str| read_curve(&directory.path().join(file), None).map(drop).unwrap_err();
    assert!(curve("/dev/zero").contains("it is no regular file"), "{}", curve("/dev/zero"));
    let rows: String = (0..100_002).map(|i| format!("{i}.0,0.4\n")).collect();
    fs::write(directory.path().join("long.csv"), format!("speed,coefficient\n{rows}")).unwrap();
    assert!(curve("long.csv").contains("long.csv:100002: a curve has at most 100000 rows"), "{}", curve("long.csv"));
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn friction_curves_with_slips_are_read_or_refused() {
    let sound = include_str!("../../jobs/measured-friction.csv");
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("curve.csv");
    let mut numbers = Numbers(7);
    for _ in 0..500 {
        let mut bytes = sound.as_bytes().to_vec();
        for _ in 0..=numbers.below(4) {
            let at = numbers.below(bytes.len());
            match numbers.below(4) {
                _ if bytes.is_empty() => {}
                0 => bytes[at] = numbers.below(256) as u8,
                1 => bytes[at] = b",\"\n\r-e.9"[numbers.below(8)],
                2 => bytes.truncate(at),
                _ => drop(bytes.splice(at..at, *b"1e308")),
            }
        }
        fs::write(&path, &bytes).unwrap();
        let result = panic::catch_unwind(|| {
            [None, Some(SmoothingSpec::Spline)].map(|smoothing| read_curve(&path, smoothing).is_ok())
        });
        assert!(result.is_ok(), "it panicked: {}", String::from_utf8_lossy(&bytes));
    }
}
