//! Signals to slow jobs: answered in words at once, obeyed within two seconds, and nothing that was finished is lost.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so and stop")]

mod common;

use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsString;
use std::fs;
use std::io::{BufRead as _, BufReader};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

use common::{Place, repository};

/// Time in which a signal is answered in words. The program takes some hundredths of a second; the rest is for a busy
/// machine.
const WORDS: Duration = Duration::from_secs(2);

/// Time in which it is obeyed. The program takes two seconds at most.
const END: Duration = Duration::from_secs(6);

/// A command under way, and the lines that it writes to standard error.
struct Running {
    child: Child,
    lines: Receiver<String>,
    said: Vec<String>,
}

impl Running {
    fn start(place: &Place, words: &str) -> Self {
        let mut command = place.command(words);
        let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        let (sender, lines) = mpsc::channel();
        let stderr = BufReader::new(child.stderr.take().unwrap());
        thread::spawn(move || stderr.lines().map_while(Result::ok).try_for_each(|line| sender.send(line)));
        Self { child, lines, said: Vec::new() }
    }

    fn is_running(&mut self) -> bool {
        self.child.try_wait().unwrap().is_none()
    }

    fn send(&self, signal: &str) {
        let sent = Command::new("kill").args([&format!("-{signal}"), &self.child.id().to_string()]).status();
        assert!(sent.unwrap().success());
    }

    /// Sends a signal; asserts that it is answered and obeyed in time, and returns everything that was said.
    #[track_caller]
    fn stop(self, signal: &str) -> String {
        self.stop_or_end(signal).unwrap_or_else(|said| panic!("it had ended before the signal came:\n{said}"))
    }

    /// [`Running::stop`], or what was said by a command that came to its end before the signal reached it.
    #[track_caller]
    fn stop_or_end(mut self, signal: &str) -> Result<String, String> {
        let (word, code) = if signal == "INT" { ("interrupted", 130) } else { ("terminated", 143) };
        self.said.extend(self.lines.try_iter());
        let sent = Instant::now();
        self.send(signal);
        let mut answer = self.lines.recv_timeout(END);
        while let Ok(line) = answer {
            let answered = line.contains(word);
            self.said.push(line);
            if answered {
                assert!(sent.elapsed() < WORDS, "the answer came after {:?}", sent.elapsed());
                return Ok(self.ended(sent, code));
            }
            answer = self.lines.recv_timeout(END);
        }
        assert!(answer != Err(RecvTimeoutError::Timeout), "no answer within {END:?}:\n{}", self.said.join("\n"));
        Err(self.ended(sent, 0))
    }

    #[track_caller]
    fn ended(mut self, sent: Instant, code: i32) -> String {
        let status = self.child.wait().unwrap();
        let took = sent.elapsed();
        self.said.extend(self.lines.iter());
        let said = self.said.join("\n");
        assert!(took < END, "it ended after {took:?}\n{said}");
        assert_eq!(status.code(), Some(code), "{said}");
        said
    }
}

/// A job of one cell whose samples are slow: eight random inputs on a flexible disc.
fn slow_job(sampling: &str) -> String {
    format!(
        "name = \"slow\"\n[axes]\nrotating_speed = 15.0\npreload = 0.1\nstatic_friction = 0.3\n[random]\ninputs = [\"preload\", \
         \"static_friction\", \"friction.kinetic_coefficient\", \"friction.stribeck_velocity\", \"stiffness.contact_normal\", \
         \"damping.tangential\", \"pad.mass\", \"disc.thickness\"]\nrelative_std = 0.1\n[criterion]\nkind = \
         \"time-domain\"\nstart = \"rest\"\nrecord = [\"amplitude\"]\n[sampling]\n{sampling}\n"
    )
}

fn samples_done(place: &Place, run: &str) -> u64 {
    let status: serde_json::Value =
        serde_json::from_str(&place.run(&format!("status {run} --json")).done().stdout).unwrap();
    status["samples_done"].as_u64().unwrap()
}

/// Runs a job that a batch system ends again and again before its first unit of work is complete, and starts again.
/// Its number of samples is chosen so large that this happens at least three times.
#[track_caller]
fn advances(sampling: impl Fn(u64) -> String) {
    let place = Place::new();
    for samples in [40, 200, 1000, 5000, 25_000] {
        place.write("job.toml", &slow_job(&sampling(samples)));
        let run = format!("run-{samples}");
        let mut done = Vec::new();
        loop {
            let words = match place.path(&run).join("job.toml").exists() {
                true => format!("resume {run} --threads 1"),
                false => format!("submit job.toml --out {run} --threads 1"),
            };
            let mut running = Running::start(&place, &words);
            let started = Instant::now();
            while running.is_running() && started.elapsed() < Duration::from_millis(800 + 200 * done.len() as u64) {
                thread::sleep(Duration::from_millis(10));
            }
            if !running.is_running() {
                running.ended(Instant::now(), 0);
                break;
            }
            // It may come to its end between the look above and the signal.
            let Ok(said) = running.stop_or_end("TERM") else { break };
            assert!(said.contains(&format!("continue with `stickslip resume {run}`")), "{said}");
            done.push(samples_done(&place, &run));
            assert!(done.len() < 100, "it does not advance: {done:?}");
        }
        if done.len() >= 3 {
            assert!(done.iter().any(|done| !done.is_multiple_of(1000)), "no unit was interrupted: {done:?}");
            place.run(&format!("submit job.toml --out whole-{samples}")).done();
            assert!(place.surface(&run) == place.surface(&format!("whole-{samples}")));
            return;
        }
    }
    panic!("every job was too short for this test");
}

#[test]
fn a_block_that_takes_longer_than_the_time_limit_is_finished_in_parts() {
    advances(|samples| format!("samples = {samples}"));
}

#[test]
fn samples_with_sensitivity_are_kept_inside_a_block() {
    advances(|samples| format!("samples = {}\nsensitivity = true", samples / 10));
}

#[test]
fn sobol_points_are_kept_inside_a_randomisation() {
    advances(|samples| format!("method = \"sobol\"\nsamples = {}", samples.next_power_of_two() * 16));
}

#[test]
fn samples_between_two_looks_are_kept() {
    advances(|samples| format!("until = {{ half_width = 0.005, confidence = 0.9, at_most = {samples} }}"));
}

/// The answers of searches that are kept in a folder: the most of each search.
fn answers_kept(place: &Place, folder: &str) -> u64 {
    let mut most: BTreeMap<(u64, u64), u64> = BTreeMap::new();
    for name in names_in(place, folder) {
        let text = fs::read_to_string(place.path(folder).join(name)).unwrap_or_default();
        for line in text.lines().skip(1) {
            // A piece may be cut short.
            let Ok((cell, number, first, answers)) = serde_json::from_str::<(u64, u64, u64, Vec<u64>)>(line) else {
                break;
            };
            let kept = most.entry((cell, number)).or_default();
            *kept = (*kept).max(first + answers.len() as u64);
        }
    }
    most.values().sum()
}

/// The names of the pieces in a folder.
fn names_in(place: &Place, folder: &str) -> BTreeSet<OsString> {
    let entries = fs::read_dir(place.path(folder)).into_iter().flatten();
    let names = entries.map(|entry| entry.unwrap().file_name());
    names.filter(|name| !name.to_string_lossy().starts_with('.')).collect()
}

/// Begins or resumes a run of `slow.toml`.
fn go_on(place: &Place) -> Running {
    match place.path("run/job.toml").exists() {
        true => Running::start(place, "resume run --threads 1"),
        false => Running::start(place, "submit slow.toml --out run --threads 1"),
    }
}

/// Lets a command work for some milliseconds, and ends it by SIGTERM; false if it had come to its end.
fn stopped_after(mut running: Running, milliseconds: u64) -> bool {
    let started = Instant::now();
    while running.is_running() && started.elapsed() < Duration::from_millis(milliseconds) {
        thread::sleep(Duration::from_millis(10));
    }
    if running.is_running() {
        return running.stop_or_end("TERM").is_ok();
    }
    running.ended(Instant::now(), 0);
    false
}

/// A job of rare events with eight random inputs on a flexible disc, whose searches take seconds.
fn slow_search(sampling: &str) -> String {
    slow_job(sampling)
        .replace("record = [\"amplitude\"]\n", "")
        .replace("static_friction = 0.3\n", "static_friction = 0.25\n")
        .replace("relative_std = 0.1", "relative_std = 0.05")
}

/// Starts a command again and again and stops it each time, as a batch system does, until it ends by itself. `kept` says after
/// each session how much it has kept, which becomes more. The number of sessions, and what was kept after the last.
#[track_caller]
fn stopped_until_done(start: impl Fn() -> Running, milliseconds: u64, kept: impl Fn() -> u64) -> (u32, u64) {
    let (mut before, mut sessions, mut idle) = (0, 0, 0);
    while stopped_after(start(), milliseconds) {
        let now = kept();
        // On a busy machine a session may be over before it is where the last one ended.
        idle = if now > before { 0 } else { idle + 1 };
        assert!(idle < 4, "no progress up to session {sessions}: {now}");
        (before, sessions) = (now, sessions + 1);
    }
    (sessions, before)
}

/// A batch system ends a run sooner than a search ends.
#[track_caller]
fn searches_advance(sampling: &str) {
    let place = Place::new();
    place.write("slow.toml", &slow_search(sampling));
    let kept = || answers_kept(&place, "run/searches") + samples_done(&place, "run");
    let (sessions, kept) = stopped_until_done(|| go_on(&place), 1000, kept);
    assert!(sessions >= 3 && kept > 1000, "it was too short for this test: {sessions} sessions, {kept}");
    place.run("submit slow.toml --out whole").done();
    assert!(place.surface("run") == place.surface("whole"));
    assert!(place.run("verify run").done().stdout.contains("searches"));
}

#[test]
fn a_search_for_rare_events_goes_on_where_a_signal_ended_it() {
    searches_advance("method = \"importance\"\nsamples = 256\nrandomisations = 8\nparticles = 200");
}

#[test]
fn a_population_goes_on_where_a_signal_ended_it() {
    searches_advance("method = \"subset\"\nrandomisations = 4\nparticles = 120");
}

/// Nothing is asked for twice of what was on disk before `kill -9`; what is damaged or of another run is not used.
#[test]
fn a_search_that_is_killed_goes_on_from_what_is_on_disk() {
    let place = Place::new();
    let sampling = "method = \"importance\"\nsamples = 256\nrandomisations = 8\nparticles = 900\nseed = 2";
    place.write("slow.toml", &slow_search(sampling));
    let folder = "run/searches";
    for session in 0..2 {
        let (before, mut running) = (answers_kept(&place, folder), go_on(&place));
        while answers_kept(&place, folder) <= before {
            assert!(running.is_running(), "it is too short for this test: session {session}");
            thread::sleep(Duration::from_millis(20));
        }
        running.send("KILL");
        assert!(!running.child.wait().unwrap().success());
        assert!(samples_done(&place, "run") < 256);
    }
    let kept: Vec<OsString> = names_in(&place, folder).into_iter().collect();
    assert!(kept.len() >= 2, "{kept:?}");
    let copies: Vec<Vec<u8>> = kept.iter().map(|name| fs::read(place.path(folder).join(name)).unwrap()).collect();
    // The answers of another seed, one piece cut short, and one with another bit.
    place.write("slow.toml", &slow_search(&sampling.replace("seed = 2", "seed = 3")));
    assert!(stopped_after(Running::start(&place, "submit slow.toml --out other --threads 1"), 1000));
    let foreign: Vec<OsString> = names_in(&place, "other/searches").into_iter().collect();
    let to = place.path(folder).join(&foreign[0]);
    fs::copy(place.path("other/searches").join(&foreign[0]), to).unwrap();
    fs::write(place.path(folder).join(&kept[0]), &copies[0][..copies[0].len() / 2]).unwrap();
    let mut flipped = copies[1].clone();
    flipped[copies[1].len() / 2] ^= 1;
    fs::write(place.path(folder).join(&kept[1]), flipped).unwrap();
    let said = place.run("resume run").done().stderr;
    for name in [&foreign[0], &kept[0], &kept[1]] {
        let name = name.to_string_lossy();
        assert!(said.contains(&format!("{name} is ignored")), "{name}: {said}");
    }
    place.write("slow.toml", &slow_search(sampling));
    place.run("submit slow.toml --out whole").done();
    assert!(place.surface("run") == place.surface("whole"));
}

#[test]
fn what_is_found_of_limits_is_kept() {
    let place = Place::new();
    place.write(
        "slow.toml",
        "name = \"limits\"\n[axes]\nrotating_speed = [12.0, 15.0]\npreload = [0.01, 0.3]\nstatic_friction = 0.39\n[random]\n\
         inputs = [\"preload\", \"static_friction\", \"friction.kinetic_coefficient\"]\nrelative_std = 0.1\n[criterion]\n\
         kind = \"eigenvalue\"\n[sampling]\nmethod = \"conditional\"\nsamples = 2048\n[limit]\nof = \"preload\"\n\
         probability = [0.01, 0.2]\n",
    );
    // Its limits are looked for when all of its samples are there.
    let kept = || answers_kept(&place, "run/limits") + samples_done(&place, "run");
    let (sessions, kept) = stopped_until_done(|| go_on(&place), 1000, kept);
    assert!(sessions >= 2 && kept > 8192 + 30, "it was too short for this test: {sessions} sessions, {kept}");
    assert!(!place.path("run/limits").exists(), "what is needed no more is removed");
    place.run("submit slow.toml --out whole").done();
    let limits = |run: &str| fs::read(place.path(run).join("limits.parquet")).unwrap();
    assert!(limits("run") == limits("whole") && place.surface("run") == place.surface("whole"));
}

/// One cell takes seconds; its search for critical values goes on within it.
#[test]
fn the_search_for_critical_values_of_one_cell_is_kept() {
    let place = Place::new();
    fs::copy(repository().join("jobs/tu-brake/disk_brake100.mat"), place.path("dense.mat")).unwrap();
    let term = |name: &str, factor: &str| format!("{{ file = \"dense.mat\", matrix = \"{name}\"{factor} }}");
    let (mass, damping) = (term("M", ""), term("D1", ""));
    let by_speed = [term("DR", ", factor = \"1 / speed\""), term("DG", ", factor = \"speed\"")].join(", ");
    let stiffness = [term("K1", ""), term("KR", ", factor = \"friction\"")].join(", ");
    let job = format!(
        "name = \"dense\"\n[model]\nkind = \"matrices\"\nmass = {mass}\ndamping = [{damping}, {by_speed}]\n\
         stiffness = [{stiffness}]\n[model.parameters]\nfriction = 0.08\nspeed = 1.0\n[axes]\n\
         friction = [0.08, 0.09]\n[random]\ninputs = [\"friction\"]\nrelative_std = 0.1\n[criterion]\n\
         kind = \"complex-eigenvalue\"\n[sampling]\nmethod = \"exact\"\n"
    );
    place.write("slow.toml", &job);
    let kept = || answers_kept(&place, "run/searches");
    let (sessions, kept) = stopped_until_done(|| go_on(&place), 1000, kept);
    assert!(sessions >= 2 && kept > 20, "it was too short for this test: {sessions} sessions, {kept}");
    assert!(!place.path("run/searches").exists(), "what is needed no more is removed");
    place.run("submit slow.toml --out whole").done();
    assert!(place.surface("run") == place.surface("whole"));
}

#[test]
fn what_is_found_of_bounds_is_kept_beside_their_file() {
    let place = Place::new();
    place.write(
        "slow.toml",
        "name = \"bounds\"\n[axes]\npreload = { from = 0.05, to = 0.3, points = 40 }\nstatic_friction = { one_of = [0.37, 0.4] }\n\
         [random]\ninputs = [\"preload\", \"static_friction\"]\nrelative_std = { between = [0.1, 0.2] }\n\
         correlation = [[\"preload\", \"static_friction\", { between = [-0.5, 0.0] }]]\n[criterion]\nkind = \"eigenvalue\"\n\
         [sampling]\nmethod = \"exact\"\n",
    );
    let words = "bounds slow.toml --threads 1 --out bounds.parquet";
    let folder = "bounds.parquet.searches";
    let is_damaged = Cell::new(false);
    let kept = || {
        let kept = answers_kept(&place, folder);
        assert!(!place.path("bounds.parquet").exists());
        let names = names_in(&place, folder);
        match names.first() {
            Some(name) if !is_damaged.replace(true) => {
                // It is not used, and found again.
                let path = place.path(folder).join(name);
                let content = fs::read(&path).unwrap();
                fs::write(&path, &content[..content.len() / 2]).unwrap();
                0
            }
            _ => kept,
        }
    };
    let (sessions, _) = stopped_until_done(|| Running::start(&place, words), 700, kept);
    assert!(sessions >= 2 && is_damaged.get(), "it was too short for this test: {sessions}");
    assert!(!place.path(folder).exists(), "what is needed no more is removed");
    place.run("bounds slow.toml --out whole.parquet").done();
    assert!(fs::read(place.path("bounds.parquet")).unwrap() == fs::read(place.path("whole.parquet")).unwrap());
    let running = Running::start(&place, &words.replace(" --out bounds.parquet", ""));
    thread::sleep(Duration::from_millis(500));
    let said = running.stop("TERM");
    assert!(said.contains("with --out FILE, what was found is kept"), "{said}");
}

/// A job with a verdict map that is integrated over it and audited at length, so that a signal comes in time.
const MAPPED: &str = "name = \"mapped\"\n[axes]\nrotating_speed = 15.0\npreload = { from = 0.03, to = 0.3, points = 3 }\n\
    static_friction = { from = 0.27, to = 0.5, points = 3 }\n[random]\ninputs = [\"preload\", \"static_friction\"]\n\
    relative_std = 0.2\n[criterion]\nkind = \"time-domain\"\n[sampling]\nmethod = \"exact\"\naudit = 6000\n";

#[test]
fn tiles_and_audits_that_are_finished_are_kept() {
    let place = Place::new();
    place.write("job.toml", MAPPED);
    let files = |folder: &str| place.pieces(&format!("run/{folder}"));
    for folder in ["map", "audit"] {
        let words = if folder == "map" { "submit job.toml --out run" } else { "resume run" };
        let mut running = Running::start(&place, words);
        while files(folder) == 0 {
            assert!(running.is_running(), "the job is too short for this test: it ended before {folder}/ was seen");
            thread::sleep(Duration::from_millis(5));
        }
        let said = running.stop("INT");
        assert!(said.contains("kept; continue with `stickslip resume run`"), "{said}");
        assert!(files(folder) > 0 && !place.path("run/surface.parquet").exists());
    }
    let resumed = place.run("resume run").done().stderr;
    assert!(resumed.contains(", 0 of them new"), "all tiles were there: {resumed}");
    place.run("submit job.toml --out whole").done();
    assert!(place.surface("run") == place.surface("whole"));
}

#[test]
fn a_job_that_prepares_many_brakes_ends_at_once() {
    let place = Place::new();
    let speeds = "rotating_speed = { from = 10.0, to = 20.0, points = 30_000 }";
    place.write("job.toml", &slow_job("samples = 1").replace("rotating_speed = 15.0", speeds).replace(
        "inputs = [\"preload\", \"static_friction\", \"friction.kinetic_coefficient\", \"friction.stribeck_velocity\", \
         \"stiffness.contact_normal\", \"damping.tangential\", \"pad.mass\", \"disc.thickness\"]",
        "inputs = [\"preload\"]",
    ));
    let mut running = Running::start(&place, "submit job.toml --out run");
    while !place.path("run/job.toml").exists() {
        assert!(running.is_running());
        thread::sleep(Duration::from_millis(5));
    }
    thread::sleep(Duration::from_millis(300));
    let said = running.stop("INT");
    assert!(said.contains("continue with `stickslip resume run`"), "{said}");
}

/// A job whose samples take many seconds each, as the disc is as stiff as none is. With `inputs` that change the modes
/// of its disc, none of them can be stopped.
fn very_slow_job(inputs: &str, modes: u32, sampling: &str) -> String {
    format!(
        "name = \"long\"\n[model.disc]\nyoungs_modulus = 1e13\nthickness = 0.05\n[axes]\nrotating_speed = 15.0\npreload = 0.1\n\
         static_friction = 0.39\n[random]\ninputs = [\"{inputs}\"]\nrelative_std = 0.1\n[criterion]\nkind = \
         \"time-domain\"\nstart = \"rest\"\ndisc_modes = {modes}\nrecord = [\"amplitude\"]\n[sampling]\n{sampling}\n"
    )
}

/// Begins to run it, each sample for itself or in a verdict map.
fn running_very_slow_job(place: &Place, inputs: &str, modes: u32, sampling: &str) -> Running {
    let job = very_slow_job(inputs, modes, sampling);
    // What is integrated has no amplitudes.
    let job = if sampling.contains("exact") { job.replace("record = [\"amplitude\"]\n", "") } else { job };
    place.write("job.toml", &job);
    let mut running = Running::start(place, "submit job.toml --out run");
    while !place.path("run/job.toml").exists() {
        assert!(running.is_running());
        thread::sleep(Duration::from_millis(5));
    }
    // Until a sample is simulated; a build for debugging takes seconds to solve the modes of its disc.
    let solves = if inputs == OF_MODES && cfg!(debug_assertions) { 8000 } else { 1500 };
    thread::sleep(Duration::from_millis(solves));
    assert!(running.is_running(), "the job is too short for this test");
    running
}

/// An input that changes the modes of the disc.
const OF_MODES: &str = "disc.poissons_ratio";

#[test]
fn what_takes_too_long_is_given_up() {
    let place = Place::new();
    let said = running_very_slow_job(&place, OF_MODES, 24, "samples = 3").stop("TERM");
    assert!(said.contains("given up") && said.contains("continue with `stickslip resume run`"), "{said}");
}

#[test]
fn a_sample_is_given_up_in_the_middle_of_its_motion() {
    let place = Place::new();
    let said = running_very_slow_job(&place, "preload", 24, "samples = 3").stop("TERM");
    assert!(said.contains("continue with `stickslip resume run`") && !said.contains("given up"), "{said}");
}

#[test]
fn the_search_of_a_verdict_map_ends_in_the_middle_of_its_motions() {
    let place = Place::new();
    let mut tiles = BTreeSet::new();
    for (signal, later) in [("TERM", 0), ("INT", 700)] {
        let running = running_very_slow_job(&place, "preload", 24, "method = \"exact\"");
        thread::sleep(Duration::from_millis(later));
        let said = running.stop(signal);
        assert!(said.contains("continue with `stickslip resume run`") && !said.contains("given up"), "{said}");
        let files = fs::read_dir(place.path("run/map")).into_iter().flatten();
        tiles.extend(files.map(|file| file.unwrap().file_name()));
        fs::remove_dir_all(place.path("run")).unwrap();
    }
    // Tiles are named by their content. One may be finished in time; the other takes a minute.
    assert!(tiles.len() <= 1, "a tile was cut short: {tiles:?}");
}

#[test]
fn a_second_signal_ends_the_process_at_once() {
    let place = Place::new();
    let mut running = running_very_slow_job(&place, OF_MODES, 24, "samples = 3");
    let started = Instant::now();
    running.send("INT");
    // A second signal within a moment is the same one, sent to the process and to its group.
    running.send("INT");
    thread::sleep(Duration::from_millis(500));
    assert!(running.is_running() || started.elapsed() > Duration::from_millis(1500), "an echo ended it");
    let again = Instant::now();
    running.send("INT");
    let said = running.ended(again, 130);
    assert!(!said.contains("given up") || again.elapsed() > Duration::from_secs(1), "{said}");
}

#[test]
fn nothing_is_predicted_before_something_is_known() {
    let place = Place::new();
    let running = running_very_slow_job(&place, "preload", 24, "samples = 1000");
    thread::sleep(Duration::from_secs(1));
    let said = running.stop("INT");
    assert!(!said.contains("year") && !said.contains(" left"), "{said}");
}
