//! The documents as a reader uses them: README.md and everything in docs/.
//!
//! Each page gets an empty directory of its own with `stickslip` on the path, as a reader who installed the program has it.
//! Its blocks run there from top to bottom. The first word of a fence is its language, further words say how it runs:
//!
//! | fence | what happens |
//! |---|---|
//! | `console` | lines that begin with `$ ` are commands and must succeed; the lines below one are its output |
//! | `console exit=65` | the last command ends with this exit code, and the lines below it are its messages |
//! | `toml` | a complete job, which `stickslip check` must accept |
//! | `toml fragment` | merged into a small job and checked |
//! | `python` | runs without error, with the names of the blocks before it, if `STICKSLIP_PYTHON` names an interpreter; where no command follows the first of them, all run once more when the page is through, with no names, in the same directory |
//! | `text output` | what the Python block before it prints |
//! | any of them `ignore (why)` | not run |
//!
//! A job that begins with the comment `# NAME.toml` is saved under that name; if `jobs/` has a job of this name, it is the
//! same. In shown output a line of three dots
//! stands for any number of lines, and `…` inside a line for any text. Lines that begin with `stickslip: ` are messages
//! on standard error, where others may stand between them.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so and stop")]

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::fs;
use std::io::{BufRead as _, BufReader, Write as _};
use std::path::{Component, Path, PathBuf};
use std::process::{Child, ChildStdout, Command, Stdio};

use crate::common::{Place, TARGETS, named_by, repository};

/// How many commands, jobs and Python blocks there are at the least, so that the test cannot pass by finding none.
const LEAST_COMMANDS: usize = 70;
const LEAST_JOBS: usize = 25;
const LEAST_PYTHON: usize = 17;
const LEAST_AGAIN: usize = 14;

/// What fragments are merged into.
const BASE_JOB: &str = r#"
name = "base"
[axes]
rotating_speed = 15.0
preload = { from = 0.05, to = 0.15, points = 3 }
static_friction = 0.39
[random]
inputs = ["preload", "static_friction"]
relative_std = 0.2
[criterion]
kind = "eigenvalue"
"#;

/// Languages of blocks that are shown only.
const SHOWN_ONLY: [&str; 4] = ["text", "matlab", "json", "bash"];

/// One fenced block.
#[derive(Debug)]
struct Block {
    language: String,
    words: Vec<String>,
    lines: Vec<String>,
    /// Page and line, for messages.
    place: String,
}

impl Block {
    fn is_ignored(&self) -> bool {
        self.words.iter().any(|word| word == "ignore")
    }

    fn is_output(&self) -> bool {
        self.language == "text" && self.words.iter().any(|word| word == "output")
    }

    fn exit_code(&self) -> i32 {
        let code = self.words.iter().find_map(|word| word.strip_prefix("exit="));
        code.map_or(0, |code| code.parse().unwrap())
    }

    fn text(&self) -> String {
        self.lines.join("\n") + "\n"
    }

    /// The name that its first line gives it.
    fn file_name(&self) -> Option<&str> {
        self.lines.first()?.strip_prefix("# ").filter(|name| name.ends_with(".toml") && !name.contains(' '))
    }
}

/// The contents of the site that `make docs` builds. It is no page of its own.
const CONTENTS: &str = "docs/SUMMARY.md";

/// Pages of the site that lie at the root, beside the README.
const AT_THE_ROOT: [&str; 3] = ["ARCHITECTURE.md", "SECURITY.md", "CHANGELOG.md"];

/// README.md and the pages in docs/, by their path in the repository.
fn pages() -> Vec<String> {
    fn add(folder: &str, pages: &mut Vec<String>) {
        for entry in fs::read_dir(repository().join(folder)).unwrap() {
            let name = format!("{folder}/{}", entry.unwrap().file_name().to_str().unwrap());
            if repository().join(&name).is_dir() {
                add(&name, pages);
            } else if name.ends_with(".md") && name != CONTENTS {
                pages.push(name);
            }
        }
    }
    let mut pages = vec!["README.md".to_owned()];
    add("docs", &mut pages);
    pages.sort();
    pages
}

fn read(page: &str) -> String {
    fs::read_to_string(repository().join(page)).unwrap()
}

/// The fenced blocks of a page. Fences in lists are indented; so are the lines in them.
fn blocks(page: &str) -> Vec<Block> {
    let mut blocks: Vec<Block> = Vec::new();
    let mut open: Option<usize> = None;
    for (i, line) in read(page).lines().enumerate() {
        let trimmed = line.trim_start();
        match (open, trimmed.strip_prefix("```")) {
            (None, Some(info)) => {
                let mut words = info.split_whitespace().map(str::to_owned);
                let language = words.next().unwrap_or_else(|| panic!("{page}:{}: a fence without a language", i + 1));
                blocks.push(Block {
                    language,
                    words: words.collect(),
                    lines: Vec::new(),
                    place: format!("{page}:{}", i + 1),
                });
                open = Some(line.len() - trimmed.len());
            }
            (Some(_), Some(_)) => open = None,
            (Some(indent), None) => {
                let text = if line.len() > indent { &line[indent..] } else { "" };
                blocks.last_mut().unwrap().lines.push(text.to_owned());
            }
            (None, None) => {}
        }
    }
    assert!(open.is_none(), "{page}: a fence is not closed");
    blocks
}

/// The search path with the directory of `stickslip` in front.
fn path_with_stickslip() -> OsString {
    let program = Path::new(env!("CARGO_BIN_EXE_stickslip")).parent().unwrap().to_owned();
    let path = std::env::var_os("PATH").unwrap_or_default();
    std::env::join_paths(std::iter::once(program).chain(std::env::split_paths(&path))).unwrap()
}

/// Runs a line in a page's directory as a shell does: exit code, standard output, standard error.
fn shell(place: &Place, line: &str) -> (Option<i32>, String, String) {
    let output = Command::new("sh")
        .args(["-c", line])
        .current_dir(place.path(""))
        .env("PATH", path_with_stickslip())
        .stdin(Stdio::null())
        .output()
        .unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

/// Whether a line is what is shown, `…` standing for any text.
fn line_matches(shown: &str, line: &str) -> bool {
    let Some((before, after)) = shown.split_once('…') else { return shown.trim_end() == line.trim_end() };
    let Some(rest) = line.strip_prefix(before) else { return false };
    (0..=rest.len()).filter(|&at| rest.is_char_boundary(at)).any(|at| line_matches(after, &rest[at..]))
}

/// Whether lines are what is shown, a line of three dots standing for any number of them.
fn lines_match(shown: &[&str], lines: &[&str]) -> bool {
    match (shown.first(), lines.first()) {
        (None, None) => true,
        (Some(&"..."), _) => (0..=lines.len()).any(|skipped| lines_match(&shown[1..], &lines[skipped..])),
        (Some(first), Some(line)) => line_matches(first, line) && lines_match(&shown[1..], &lines[1..]),
        _ => false,
    }
}

/// The commands of a block with the output that is shown below each.
fn commands(block: &Block) -> Vec<(String, Vec<&str>)> {
    let mut commands: Vec<(String, Vec<&str>)> = Vec::new();
    let mut goes_on = false;
    for line in &block.lines {
        if goes_on {
            let command = &mut commands.last_mut().unwrap().0;
            command.push('\n');
            command.push_str(line);
        } else if let Some(command) = line.strip_prefix("$ ") {
            commands.push((command.to_owned(), Vec::new()));
        } else {
            let last = commands.last_mut();
            last.unwrap_or_else(|| panic!("{}: output before any command", block.place)).1.push(line);
            continue;
        }
        goes_on = line.ends_with('\\');
    }
    for (_, output) in &mut commands {
        while output.last().is_some_and(|line| line.is_empty()) {
            output.pop();
        }
    }
    commands
}

/// Runs the commands of a block; how many there were.
fn run_console(place: &Place, block: &Block) -> usize {
    let commands = commands(block);
    assert!(!commands.is_empty(), "{}: no line begins with `$ `", block.place);
    for (i, (command, shown)) in commands.iter().enumerate() {
        let wanted = if i + 1 == commands.len() { block.exit_code() } else { 0 };
        let (code, stdout, stderr) = shell(place, command);
        let whole = format!("{}: `{command}`\n{stdout}{stderr}", block.place);
        assert_eq!(code, Some(wanted), "{whole}");
        let (messages, results): (Vec<&str>, Vec<&str>) =
            shown.iter().partition(|line| wanted != 0 || line.starts_with("stickslip: "));
        if !results.is_empty() {
            let lines: Vec<&str> = stdout.trim_end().lines().collect();
            assert!(lines_match(&results, &lines), "output differs from what is shown\n{whole}");
        }
        let mut said = stderr.lines();
        for message in messages.into_iter().filter(|message| *message != "...") {
            assert!(said.any(|line| line_matches(message, line)), "not said: {message}\n{whole}");
        }
    }
    commands.len()
}

/// A job that holds a fragment.
fn merged(fragment: &Block) -> String {
    let parse = |text: &str| text.parse::<toml::Table>().unwrap_or_else(|error| panic!("{}: {error}", fragment.place));
    let (mut job, fragment) = (parse(BASE_JOB), parse(&fragment.text()));
    for (section, values) in fragment {
        match (job.get_mut(&section).and_then(toml::Value::as_table_mut), values) {
            (Some(table), toml::Value::Table(values)) => {
                // Other inputs have a scatter of their own.
                if values.contains_key("inputs") {
                    table.remove("relative_std");
                }
                table.extend(values);
            }
            (_, values) => {
                job.insert(section, values);
            }
        }
    }
    toml::to_string(&job).unwrap()
}

/// Checks a job or fragment.
fn check_job(place: &Place, block: &Block, number: usize) {
    let text = if block.words.iter().any(|word| word == "fragment") { merged(block) } else { block.text() };
    let name = block.file_name().map_or_else(|| format!("block-{number}.toml"), str::to_owned);
    place.write(&name, &text);
    if let Ok(kept) = fs::read_to_string(repository().join("jobs").join(&name)) {
        assert_eq!(kept, text, "{}: jobs/{name} is another job", block.place);
    }
    let (code, _, stderr) = shell(place, &format!("stickslip check {name}"));
    assert_eq!(code, Some(0), "{}: {stderr}\n{text}", block.place);
    assert!(!stderr.contains("warning"), "{}: {stderr}", block.place);
}

/// What a Python process runs: each line of its input is a directory, a session, a name and a script. The scripts of a
/// session in a directory share their names. A mark ends each answer.
const PYTHON_DRIVER: &str = r#"
import json, os, sys, traceback
names = {}
for line in sys.stdin:
    directory, session, place, script = json.loads(line)
    os.chdir(directory)
    try:
        exec(compile(script, place, "exec"), names.setdefault((directory, session), {"__name__": "__main__"}))
    except BaseException:
        print("FAILED", traceback.format_exc())
    print("\x1e", end="", flush=True)
"#;

/// A Python process that runs blocks one after the other.
struct Python {
    process: Child,
    answers: BufReader<ChildStdout>,
}

impl Python {
    /// The interpreter that `make test` sets up; continuous integration insists on it.
    fn start() -> Option<Self> {
        let python = named_by("STICKSLIP_PYTHON")?;
        let mut command = Command::new(python);
        command.args(["-c", PYTHON_DRIVER]).env("MPLBACKEND", "agg").env("PATH", path_with_stickslip());
        // The Python package, as it is here, with the program that is tested.
        command.env("PYTHONPATH", repository().join("python")).env("PYTHONDONTWRITEBYTECODE", "1");
        command.env("STICKSLIP_PROGRAM", env!("CARGO_BIN_EXE_stickslip"));
        let mut process = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        let answers = BufReader::new(process.stdout.take().unwrap());
        Some(Self { process, answers })
    }

    /// Runs a block in a directory, and compares what it prints with what is shown.
    fn run(&mut self, directory: &Path, session: u8, block: &Block, output: Option<&Block>) {
        let question = serde_json::json!([directory, session, block.place, block.text()]);
        writeln!(self.process.stdin.as_mut().unwrap(), "{question}").unwrap();
        let mut answer = Vec::new();
        self.answers.read_until(b'\x1e', &mut answer).unwrap();
        let answer = String::from_utf8(answer).unwrap();
        let printed = answer.strip_suffix('\x1e').unwrap_or_else(|| panic!("{}: Python has ended", block.place));
        assert!(!printed.contains("FAILED"), "{}, session {session}: {printed}", block.place);
        if let Some(shown) = output {
            let lines: Vec<&str> = shown.lines.iter().map(String::as_str).collect();
            assert!(
                lines_match(&lines, &printed.lines().collect::<Vec<_>>()),
                "{}, session {session}:\n{printed}",
                shown.place
            );
        }
    }
}

impl Drop for Python {
    fn drop(&mut self) {
        drop(self.process.stdin.take());
        let _ = self.process.wait();
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn everything_that_the_documents_show_runs() {
    let (mut ran, mut jobs, mut scripts, mut again) = (0, 0, 0, 0);
    let mut python = Python::start();
    for blocks in pages().iter().map(|page| blocks(page)) {
        let place = Place::new();
        for (number, block) in blocks.iter().enumerate() {
            let reason = block.words.iter().any(|word| word.starts_with('('));
            assert!(!block.is_ignored() || reason, "{}: say in brackets why the block does not run", block.place);
            match block.language.as_str() {
                "console" | "toml" | "python" if block.is_ignored() => {}
                "console" => ran += run_console(&place, block),
                "toml" => {
                    check_job(&place, block, number);
                    jobs += 1;
                }
                "python" => {
                    scripts += 1;
                    let output = blocks.get(number + 1).filter(|next| next.is_output());
                    if let Some(python) = &mut python {
                        python.run(&place.path(""), 1, block, output);
                    }
                }
                language => {
                    assert!(SHOWN_ONLY.contains(&language), "{}: the language {language} is not known", block.place);
                }
            }
        }
        // As "Restart & run all" of a notebook does. Commands between may have changed what they read.
        let runs = |block: &&Block, language: &str| block.language == language && !block.is_ignored();
        let from_python = blocks.iter().skip_while(|block| !runs(block, "python"));
        let is_of_python = !from_python.clone().any(|block| runs(&block, "console"));
        for (number, block) in blocks.iter().enumerate().filter(|_| is_of_python) {
            if let ("python", false, Some(python)) = (block.language.as_str(), block.is_ignored(), &mut python) {
                let output = blocks.get(number + 1).filter(|next| next.is_output());
                python.run(&place.path(""), 2, block, output);
                again += 1;
            }
        }
    }
    assert!(ran >= LEAST_COMMANDS, "only {ran} commands");
    assert!(python.is_none() || again >= LEAST_AGAIN, "only {again} Python blocks ran twice");
    assert!(jobs >= LEAST_JOBS, "only {jobs} jobs and fragments");
    assert!(scripts >= LEAST_PYTHON, "only {scripts} Python blocks");
}

/// The anchor that a heading gets: lower case, without punctuation, with dashes for spaces.
fn anchor(heading: &str) -> String {
    let kept = heading.trim().chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
    kept.collect::<String>().to_lowercase().replace(' ', "-")
}

/// The lines of a page outside its blocks, without code.
fn prose(page: &str) -> Vec<String> {
    let mut is_block = false;
    let mut lines = Vec::new();
    for line in read(page).lines() {
        if line.trim_start().starts_with("```") {
            is_block = !is_block;
        } else if !is_block {
            lines.push(line.split('`').step_by(2).collect::<Vec<_>>().join(""));
        }
    }
    lines
}

fn anchors(page: &str) -> BTreeSet<String> {
    let text = read(page);
    let mut is_block = false;
    let mut found = BTreeSet::new();
    for line in text.lines() {
        if line.trim_start().starts_with("```") {
            is_block = !is_block;
        } else if let (false, Some(heading)) = (is_block, line.strip_prefix('#')) {
            assert!(found.insert(anchor(heading.trim_start_matches('#'))), "{page}: two headings are alike: {line}");
        }
    }
    found
}

/// Targets of the links of a page to other files of the repository: path and anchor.
fn links(page: &str) -> Vec<(String, String)> {
    let text = prose(page).join("\n");
    let folder = Path::new(page).parent().unwrap();
    let mut links = Vec::new();
    let definitions = text.lines().filter_map(|line| line.strip_prefix('[')?.split_once("]: "));
    let inline = text.split("](").skip(1).map(|part| part.split(')').next().unwrap());
    for target in inline.chain(definitions.map(|(_, target)| target)) {
        if target.starts_with("https:") {
            continue;
        }
        let (path, anchor) = target.split_once('#').unwrap_or((target, ""));
        let mut whole = PathBuf::new();
        for step in folder.join(path).components() {
            match step {
                Component::ParentDir => assert!(whole.pop(), "{page}: {target} leads out of the repository"),
                step => whole.push(step),
            }
        }
        let path = if path.is_empty() { page } else { whole.to_str().unwrap() };
        links.push((path.to_owned(), anchor.to_owned()));
    }
    links
}

#[test]
fn every_link_leads_somewhere_and_every_page_is_linked() {
    let (mut count, mut linked) = (0, BTreeSet::from(["README.md".to_owned()]));
    for page in pages().into_iter().chain(AT_THE_ROOT.map(str::to_owned)) {
        for (path, target) in links(&page) {
            count += 1;
            assert!(repository().join(&path).exists(), "{page}: there is no {path}");
            let is_there = target.is_empty() || anchors(&path).contains(&target);
            assert!(is_there, "{page}: {path} has no heading #{target}");
            linked.insert(path);
        }
    }
    assert!(count >= 60, "only {count} links");
    let architecture = read("ARCHITECTURE.md");
    let named = architecture.split('`').skip(1).step_by(2).filter(|text| text.starts_with("tests/"));
    for path in named {
        assert!(repository().join(path).exists(), "ARCHITECTURE.md: there is no {path}");
    }
    for page in pages() {
        assert!(linked.contains(&page), "no page links to {page}");
    }
}

#[test]
fn the_site_has_every_page_once() {
    let mut listed: Vec<String> = links(CONTENTS).into_iter().map(|(path, _)| path).collect();
    listed.sort();
    let mut wanted = pages();
    wanted.extend(AT_THE_ROOT.map(str::to_owned));
    wanted.sort();
    assert_eq!(listed, wanted, "{CONTENTS} lists every page, and each once");

    for page in &listed {
        for (path, _) in links(page) {
            let is_page = path.ends_with(".md");
            assert!(!is_page || listed.contains(&path), "{page}: {path} is not in {CONTENTS}");
            assert!(repository().join(&path).is_file(), "{page}: {path} is a folder, which a site does not show");
        }
    }
}

#[test]
fn the_reference_names_every_key_and_target() {
    let place = Place::new();
    let keys = read("docs/reference/job-spec.md");
    let schema: serde_json::Value = serde_json::from_str(&place.run("schema").done().stdout).unwrap();
    let definitions = schema["$defs"].as_object().unwrap().values();
    let mut count = 0;
    for table in definitions.chain([&schema]) {
        let nested = table["properties"].as_object().into_iter().flatten();
        let sections = nested.clone().filter_map(|(_, value)| value["properties"].as_object()).flatten();
        for (key, _) in nested.chain(sections) {
            count += 1;
            let is_there = ["`", " ", ".", "[", "\""].iter().any(|before| keys.contains(&format!("{before}{key}")));
            assert!(is_there, "docs/reference/job-spec.md does not name {key}");
        }
    }
    assert!(count > 60, "the schema has only {count} keys");

    let page = read("docs/reproduction.md");
    for target in TARGETS {
        assert!(page.contains(&format!("`{target}`")), "docs/reproduction.md does not name {target}");
    }
}
