//! Running stickslip as a user does, and reading its files.

#![allow(dead_code, reason = "each program of tests uses its own part")]
#![allow(clippy::disallowed_methods, reason = "expected values are computed as a textbook writes them")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so and stop")]

pub mod ten_inputs;

use std::ffi::{OsStr, OsString};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use arrow::array::{Array as _, Float64Array, Int64Array, StringArray};
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use serde_json::Value;
use tempfile::TempDir;

/// The targets of `reproduce`.
pub const TARGETS: [&str; 19] = [
    "table2",
    "table3",
    "fig4",
    "fig5",
    "fig6",
    "fig7",
    "fig8",
    "fig9",
    "fig10",
    "fig11",
    "fig12",
    "fig13",
    "fig14a",
    "fig14b",
    "fig14c",
    "fig14d",
    "fig15a",
    "fig15b",
    "scoreboard",
];

/// The root of the repository.
pub fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

/// The lines of a piece: whose it is, then its units or tiles.
pub fn lines_of(piece: &Path) -> Vec<Value> {
    fs::read_to_string(piece).unwrap().lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// Writes lines as a piece into a folder, under the name that says what is in it.
pub fn write_piece(folder: &Path, lines: &[Value]) {
    let text = lines.iter().map(Value::to_string).collect::<Vec<_>>().join("\n");
    fs::write(folder.join(format!("{}.jsonl", &blake3::hash(text.as_bytes()).to_hex()[..32])), text).unwrap();
}

/// Changes the lines of a piece, and its name with them.
pub fn change_piece(piece: &Path, change: impl FnOnce(&mut [Value])) {
    let mut lines = lines_of(piece);
    change(&mut lines);
    fs::remove_file(piece).unwrap();
    write_piece(piece.parent().unwrap(), &lines);
}

/// How long a test waits for what has to come: only what hangs takes as long, however busy the machine is.
pub const PATIENCE: Duration = Duration::from_secs(600);

/// Waits until something is there.
#[track_caller]
pub fn wait_until(what: &str, mut is_there: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !is_there() {
        assert!(begun.elapsed() < PATIENCE, "{what}: it does not come");
        thread::sleep(Duration::from_millis(5));
    }
}

/// Waits until something is there that a command makes which goes on.
#[track_caller]
pub fn wait_for(what: &str, child: &mut Child, mut is_there: impl FnMut() -> bool) {
    wait_until(what, || {
        let is_there = is_there();
        assert!(is_there || child.try_wait().unwrap().is_none(), "the command ended before {what}");
        is_there
    });
}

/// Tries again what depends on a moment that a test cannot choose, until it meets the moment; `attempt` gets the number of
/// the try, and returns what was wrong with the moment.
#[track_caller]
pub fn tried_until_met<T>(mut attempt: impl FnMut(u32) -> Result<T, String>) -> T {
    let begun = Instant::now();
    let mut number = 0;
    loop {
        match attempt(number) {
            Ok(met) => return met,
            Err(why) => assert!(begun.elapsed() < PATIENCE, "{} tries: {why}", number + 1),
        }
        number += 1;
    }
}

/// Sends a signal to a command.
#[track_caller]
pub fn send(child: &Child, signal: &str) {
    let sent = Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status();
    assert!(sent.unwrap().success());
}

/// Waits until a command watches for the signals that end it, as it does before it begins to work.
#[track_caller]
pub fn wait_until_it_watches(child: &mut Child) {
    let status = format!("/proc/{}/status", child.id());
    if !cfg!(target_os = "linux") {
        thread::sleep(Duration::from_secs(1));
        return;
    }
    wait_for("it watches for signals", child, || {
        let text = fs::read_to_string(&status).unwrap_or_default();
        let caught = text.lines().find_map(|line| line.strip_prefix("SigCgt:"));
        // SIGHUP, SIGINT and SIGTERM.
        caught.is_some_and(|mask| u64::from_str_radix(mask.trim(), 16).unwrap() & 0x4003 == 0x4003)
    });
}

/// The time that a process has had on processors so far, as others may be busy; since `begun` where the system does not
/// say. A hundredth of a second is its unit on Linux.
pub fn time_on_processors(process: u32, begun: Instant) -> Duration {
    let Ok(stat) = fs::read_to_string(format!("/proc/{process}/stat")) else { return begun.elapsed() };
    // Nothing is left of a process that has ended.
    if stat.is_empty() {
        return begun.elapsed();
    }
    // What follows the name, which may hold spaces: the state is the first, user and system time the twelfth and next.
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap().split_whitespace().collect();
    let ticks: u64 = [fields[11], fields[12]].iter().map(|ticks| ticks.parse::<u64>().unwrap()).sum();
    Duration::from_millis(10 * ticks)
}

/// A directory of its own for one test.
pub struct Place {
    directory: TempDir,
    program: PathBuf,
    environment: Vec<(String, String)>,
}

/// Exit code and output of a command.
#[derive(Debug)]
pub struct Outcome {
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl Outcome {
    /// Asserts success and returns the output.
    #[track_caller]
    pub fn done(self) -> Self {
        assert_eq!(self.code, Some(0), "{}\n{}", self.stdout, self.stderr);
        self
    }

    /// Asserts the exit code, and that the message contains every given text.
    #[track_caller]
    pub fn refused(self, code: i32, texts: &[&str]) -> Self {
        assert_eq!(self.code, Some(code), "{}\n{}", self.stdout, self.stderr);
        for text in texts {
            assert!(self.stderr.contains(text), "{text:?} is not in: {}", self.stderr);
        }
        assert!(!self.stderr.contains("panicked"), "{}", self.stderr);
        self
    }
}

/// The program under test: the one of this build, or what STICKSLIP_TEST_PROGRAM names, such as a program for another
/// processor in an emulator (`make test-aarch64`).
fn tested_program() -> PathBuf {
    std::env::var_os("STICKSLIP_TEST_PROGRAM").map_or_else(|| env!("CARGO_BIN_EXE_stickslip").into(), PathBuf::from)
}

/// A command that obeys signals even where the tests were started with some of them ignored, as by `nohup` or in the
/// background of a script.
pub fn with_default_signals(program: impl AsRef<OsStr>) -> Command {
    if cfg!(target_os = "linux") {
        let mut command = Command::new("/usr/bin/env");
        command.arg("--default-signal").arg(program);
        command
    } else {
        Command::new(program)
    }
}

impl Place {
    pub fn new() -> Self {
        Self { directory: tempfile::tempdir().unwrap(), program: tested_program(), environment: Vec::new() }
    }

    /// Uses another build of stickslip.
    pub fn with_program(mut self, program: &Path) -> Self {
        self.program = program.to_owned();
        self
    }

    pub fn with_environment(mut self, key: &str, value: &str) -> Self {
        self.environment.push((key.to_owned(), value.to_owned()));
        self
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.directory.path().join(name)
    }

    /// The number of finished pieces or tiles in a directory; files that are being written are none.
    pub fn pieces(&self, directory: &str) -> usize {
        let entries = fs::read_dir(self.path(directory)).into_iter().flatten();
        entries.filter(|entry| entry.as_ref().unwrap().path().extension() == Some("jsonl".as_ref())).count()
    }

    /// Writes a file.
    pub fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.path(name);
        fs::write(&path, text).unwrap();
        path
    }

    /// A command that has not run yet; words separated by spaces.
    pub fn command(&self, words: &str) -> Command {
        let mut command = with_default_signals(&self.program);
        command.args(words.split_whitespace()).current_dir(self.directory.path()).stdin(Stdio::null());
        command.envs(self.environment.iter().map(|(key, value)| (key, value)));
        command
    }

    /// Runs a command to its end.
    pub fn run(&self, words: &str) -> Outcome {
        let output = self.command(words).output().unwrap();
        Outcome {
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }

    /// Runs a command that must not wait for anything.
    #[track_caller]
    pub fn run_unless_it_hangs(&self, words: &str) -> Outcome {
        let mut child = self.command(words).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let begun = Instant::now();
        while child.try_wait().unwrap().is_none() {
            if begun.elapsed() > PATIENCE {
                child.kill().unwrap();
                panic!("`stickslip {words}` does not end");
            }
            thread::sleep(Duration::from_millis(5));
        }
        let output = child.wait_with_output().unwrap();
        Outcome {
            code: output.status.code(),
            stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
            stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
        }
    }

    /// Starts to run `job.toml` in a directory, or resumes that.
    pub fn begin_or_go_on(&self, run: &str) -> Command {
        // A job.toml appears whole or not at all, so one of the two always applies.
        match self.path(run).join("job.toml").exists() {
            true => self.command(&format!("resume {run} --threads 1")),
            false => self.command(&format!("submit job.toml --out {run} --threads 1")),
        }
    }

    /// Submits `job.toml` into `killed`, and repeatedly kills it when it has had so many milliseconds on processors, and goes
    /// on. Asserts that its surface is that of the run `whole` in the end, after at least `hits` kills that found it running.
    /// Where it comes to its end before, it begins anew, and is killed sooner.
    #[track_caller]
    pub fn assert_survives_kills(&self, whole: &str, delays: &[u64], hits: usize) {
        let (mut found_running, mut sooner) = (0, 1);
        for (number, &delay) in delays.iter().cycle().enumerate() {
            if number >= delays.len() && found_running >= hits {
                break;
            }
            let begun = Instant::now();
            let mut command = self.begin_or_go_on("killed");
            let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
            let delay = Duration::from_millis(delay) / sooner;
            let is_running = loop {
                if child.try_wait().unwrap().is_some() {
                    break false;
                } else if time_on_processors(child.id(), begun) >= delay {
                    break true;
                }
                thread::sleep(Duration::from_millis(1));
            };
            child.kill().unwrap();
            child.wait().unwrap();
            if is_running {
                found_running += 1;
            } else {
                assert!(self.surface(whole) == self.surface("killed"));
                fs::remove_dir_all(self.path("killed")).unwrap();
                sooner *= 2;
            }
        }
        assert!(self.begin_or_go_on("killed").output().unwrap().status.success());
        assert!(self.surface(whole) == self.surface("killed"));
    }

    /// The bytes of a run's surface.
    pub fn surface(&self, run: &str) -> Vec<u8> {
        fs::read(self.path(run).join("surface.parquet")).unwrap()
    }
}

/// The commands of the program, as its page of help lists them.
#[track_caller]
pub fn commands_of_the_program(place: &Place) -> Vec<String> {
    let help = place.run("help").done().stdout;
    let listed = help.lines().take_while(|line| *line != "Options:");
    let names = listed.filter_map(|line| line.strip_prefix("  ")?.split(' ').next().map(str::to_owned));
    let names: Vec<String> = names.collect();
    assert!(names.len() > 20, "{help}");
    names
}

/// The program that a variable of the environment names, as `make test` sets it. Without it, as on a machine without that
/// program, a test is left out; in continuous integration it fails then.
#[track_caller]
pub fn named_by(variable: &str) -> Option<OsString> {
    let named = std::env::var_os(variable);
    assert!(named.is_some() || std::env::var_os("CI").is_none(), "{variable} is not set; run `make test`");
    named
}

/// Makes a pipe that nobody writes into: it would be waited for.
#[track_caller]
pub fn make_pipe(path: &Path) {
    assert_succeeds(Command::new("mkfifo").arg(path));
}

/// Runs a Python script of this folder and asserts that it succeeds; false where there is no Python, see [`named_by`].
#[track_caller]
pub fn python_agrees<I: AsRef<OsStr>>(script: &str, arguments: impl IntoIterator<Item = I>) -> bool {
    let Some(python) = named_by("STICKSLIP_PYTHON") else { return false };
    let mut command = Command::new(python);
    assert_succeeds(command.arg(repository().join("tests").join(script)).args(arguments));
    true
}

/// Runs a command and asserts that it succeeds.
#[track_caller]
pub fn assert_succeeds(command: &mut Command) {
    let output = command.output().unwrap();
    let [stdout, stderr] = [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes));
    assert!(output.status.success(), "{command:?}\n{stdout}{stderr}");
}

/// A job over `points` by `points` cells around Figure 14a.
pub fn surface_job(name: &str, points: usize, samples: u64, seed: u64) -> String {
    format!(
        "name = \"{name}\"\n\n[axes]\nrotating_speed = 15.0\npreload = {{ from = 0.03, to = 0.30, points = {points} }}\n\
         static_friction = {{ from = 0.27, to = 0.50, points = {points} }}\n\n[random]\ninputs = [\"preload\", \
         \"static_friction\"]\nrelative_std = 0.2\n\n[criterion]\nkind = \"eigenvalue\"\n\n[sampling]\nsamples = {samples}\nseed = {seed}\n"
    )
}

/// The columns of a Parquet file as numbers. Integers are exact up to 2^53, nulls are NaN, and columns of other types
/// are empty.
pub struct Table {
    names: Vec<String>,
    columns: Vec<Vec<f64>>,
    /// The key-value pairs of the footer that are stickslip's.
    pub footer: Vec<(String, String)>,
}

/// The texts of a column of a Parquet file.
pub fn texts(path: &Path, name: &str) -> Vec<Option<String>> {
    let mut all = Vec::new();
    for batch in ParquetRecordBatchReaderBuilder::try_new(File::open(path).unwrap()).unwrap().build().unwrap() {
        let batch = batch.unwrap();
        let column = batch.column_by_name(name).unwrap().as_any().downcast_ref::<StringArray>().unwrap();
        all.extend(column.iter().map(|text| text.map(str::to_owned)));
    }
    all
}

impl Table {
    pub fn read(path: &Path) -> Self {
        let builder = ParquetRecordBatchReaderBuilder::try_new(File::open(path).unwrap()).unwrap();
        let pairs = builder.metadata().file_metadata().key_value_metadata().cloned().unwrap_or_default();
        let footer = pairs
            .into_iter()
            .filter(|pair| pair.key.starts_with("stickslip:"))
            .map(|pair| (pair.key, pair.value.unwrap_or_default()))
            .collect();
        let names: Vec<String> = builder.schema().fields().iter().map(|field| field.name().clone()).collect();
        let mut columns = vec![Vec::new(); names.len()];
        for batch in builder.build().unwrap() {
            for (column, array) in columns.iter_mut().zip(batch.unwrap().columns()) {
                if let Some(integers) = array.as_any().downcast_ref::<Int64Array>() {
                    column.extend(integers.values().iter().map(|&value| value as f64));
                } else if let Some(reals) = array.as_any().downcast_ref::<Float64Array>() {
                    column.extend(reals.iter().map(|value| value.unwrap_or(f64::NAN)));
                }
            }
        }
        Self { names, columns, footer }
    }

    pub fn names(&self) -> &[String] {
        &self.names
    }

    #[track_caller]
    pub fn column(&self, name: &str) -> &[f64] {
        let index = self.names.iter().position(|other| other == name);
        &self.columns[index.unwrap_or_else(|| panic!("no column {name}"))]
    }

    /// A hash of every value of every column, bit by bit. It is the same on every machine for the same release.
    pub fn digest(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        // The pinned digests are older than some columns.
        let has_weights = self.names.iter().any(|name| name == "n_effective");
        let pinned = |name: &String| match name.as_str() {
            "n_outside_physics" | "n_audit" | "n_audit_unstable" => false,
            "distrust" => has_weights,
            _ => true,
        };
        for (name, column) in self.names.iter().zip(&self.columns).filter(|(name, _)| pinned(name)) {
            hasher.update(name.as_bytes());
            for value in column {
                hasher.update(&value.to_bits().to_le_bytes());
            }
        }
        hasher.finalize().to_hex()[..32].to_owned()
    }
}

/// A job of 30 cells, with the given criterion and the given keys of `[random]` and `[sampling]`.
pub fn job(name: &str, criterion: &str, random: &str, sampling: &str) -> String {
    format!(
        "name = \"{name}\"\n\n[axes]\nrotating_speed = 15.0\npreload = {{ from = 0.05, to = 0.30, points = 6 }}\n\
         static_friction = {{ from = 0.28, to = 0.50, points = 5 }}\n\n[random]\n{random}\n\n[criterion]\n{criterion}\n\n\
         [sampling]\n{sampling}\n"
    )
}

pub const BOTH: &str = "inputs = [\"preload\", \"static_friction\"]\nrelative_std = 0.2";
pub const EIGENVALUE: &str = "kind = \"eigenvalue\"";

/// Submits a job into a directory of its name and returns its surface.
#[track_caller]
pub fn submitted(place: &Place, name: &str, text: &str) -> Table {
    place.write(&format!("{name}.toml"), text);
    place.run(&format!("submit {name}.toml --out {name}")).done();
    Table::read(&place.path(&format!("{name}/surface.parquet")))
}
