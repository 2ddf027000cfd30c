//! Signals to slow jobs: answered in words, obeyed, and nothing that was finished is lost. How soon is measured by
//! `make bench` and stands in docs/faults.md.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so and stop")]

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsString;
use std::fs;
use std::io::{BufRead as _, BufReader};
use std::process::{Child, Stdio};
use std::sync::mpsc::{self, Receiver};
use std::thread;
use std::time::{Duration, Instant};

use crate::common::{
    PATIENCE, Place, repository, send, time_on_processors, tried_until_met, wait_for, wait_until_it_watches,
};

/// A command under way, and the lines that it writes to standard error.
struct Running {
    child: Child,
    begun: Instant,
    lines: Receiver<String>,
    said: Vec<String>,
}

/// A try that is given up leaves nothing at work.
impl Drop for Running {
    fn drop(&mut self) {
        let _ = (self.child.kill(), self.child.wait());
    }
}

impl Running {
    fn start(place: &Place, words: &str) -> Self {
        let mut command = place.command(words);
        let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        let (sender, lines) = mpsc::channel();
        let stderr = BufReader::new(child.stderr.take().unwrap());
        thread::spawn(move || stderr.lines().map_while(Result::ok).try_for_each(|line| sender.send(line)));
        Self { child, begun: Instant::now(), lines, said: Vec::new() }
    }

    fn is_running(&mut self) -> bool {
        self.child.try_wait().unwrap().is_none()
    }

    /// Waits until a folder or file is there.
    #[track_caller]
    fn wait_for(&mut self, what: &str, is_there: impl FnMut() -> bool) {
        wait_for(what, &mut self.child, is_there);
    }

    /// Waits until it has had so much time on processors.
    #[track_caller]
    fn work_for(&mut self, work: Duration) {
        let begun = self.begun;
        let child = self.child.id();
        wait_for("its work", &mut self.child, || time_on_processors(child, begun) >= work);
    }

    /// Sends a signal; asserts that it is answered and obeyed, and returns everything that was said.
    #[track_caller]
    fn stop(self, signal: &str) -> String {
        self.stop_or_end(signal).unwrap_or_else(|said| panic!("it had ended before the signal came:\n{said}"))
    }

    /// [`Running::stop`], or what was said by a command that came to its end before the signal reached it.
    #[track_caller]
    fn stop_or_end(mut self, signal: &str) -> Result<String, String> {
        let (word, code) = if signal == "INT" { ("interrupted", 130) } else { ("terminated", 143) };
        self.said.extend(self.lines.try_iter());
        if !self.is_running() {
            return Err(self.ended(0));
        }
        send(&self.child, signal);
        while let Some(line) = self.next_line() {
            let answered = line.contains(word);
            self.said.push(line);
            if answered {
                return Ok(self.ended(code));
            }
        }
        Err(self.ended(0))
    }

    /// The next line that it says; none at its end.
    #[track_caller]
    fn next_line(&self) -> Option<String> {
        match self.lines.recv_timeout(PATIENCE) {
            Err(mpsc::RecvTimeoutError::Timeout) => panic!("it says nothing more:\n{}", self.said.join("\n")),
            line => line.ok(),
        }
    }

    /// Waits for its end; everything that it said.
    #[track_caller]
    fn ended(mut self, code: i32) -> String {
        while let Some(line) = self.next_line() {
            self.said.push(line);
        }
        let said = self.said.join("\n");
        assert_eq!(self.child.wait().unwrap().code(), Some(code), "{said}");
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
    if !place.path(run).join("job.toml").exists() {
        return 0;
    }
    let status: serde_json::Value =
        serde_json::from_str(&place.run(&format!("status {run} --json")).done().stdout).unwrap();
    status["samples_done"].as_u64().unwrap()
}

/// Begins or resumes a run of `slow.toml`.
fn go_on(place: &Place) -> Running {
    match place.path("run/job.toml").exists() {
        true => Running::start(place, "resume run --threads 1"),
        false => Running::start(place, "submit slow.toml --out run --threads 1"),
    }
}

/// Lets a command work for a while, and ends it by SIGTERM; `None` if it had come to its end.
fn stopped_after(mut running: Running, length: Duration) -> Option<String> {
    wait_until_it_watches(&mut running.child);
    let watched = Instant::now();
    while running.is_running() && watched.elapsed() < length {
        thread::sleep(Duration::from_millis(5));
    }
    running.stop_or_end("TERM").ok()
}

/// Starts a command again and again and ends it each time by a signal, as a batch system does, until it has kept more three
/// times and this is `enough`; then lets it come to its end. `kept` says after each session how much it has kept. One that
/// kept nothing new, as on a busy machine, is followed by one that is a quarter longer: twice as long, it may end a job that
/// sets up for most of its time. An error if it came to its end before: of later attempts, sessions are shorter. Returns what
/// was kept after each session.
#[track_caller]
fn stopped_until_done(
    attempt: u32,
    start: impl Fn() -> Running,
    kept: impl Fn() -> u64,
    enough: impl Fn(u64) -> bool,
) -> Result<Vec<u64>, String> {
    let mut length = Duration::from_millis(100) / (1 << attempt.min(6));
    let mut advances = vec![0];
    while advances.len() <= 3 || !enough(*advances.last().unwrap()) {
        let Some(said) = stopped_after(start(), length) else {
            return Err(format!("it was too short for this test: {advances:?}"));
        };
        let now = kept();
        if now > *advances.last().unwrap() {
            advances.push(now);
        } else {
            length = length * 5 / 4;
            assert!(length < PATIENCE, "it does not advance: {advances:?}\n{said}");
        }
    }
    start().ended(0);
    Ok(advances)
}

/// Runs a job that a batch system ends again and again before its first unit of work is complete, and starts again.
/// `sampling` is by a number of samples, which is larger in later attempts.
#[track_caller]
fn advances(samples: u64, sampling: impl Fn(u64) -> String) {
    let (place, done) = tried_until_met(|attempt| {
        let place = Place::new();
        place.write("slow.toml", &slow_job(&sampling(samples << attempt)));
        let done = stopped_until_done(attempt, || go_on(&place), || samples_done(&place, "run"), |_| true)?;
        Ok((place, done))
    });
    let last = done.last().unwrap();
    assert!(done.iter().any(|done| done != last && !done.is_multiple_of(1000)), "no unit was interrupted: {done:?}");
    place.run("submit slow.toml --out whole").done();
    assert!(place.surface("run") == place.surface("whole"));
}

#[test]
fn a_block_that_takes_longer_than_the_time_limit_is_finished_in_parts() {
    advances(1000, |samples| format!("samples = {samples}"));
}

#[test]
fn samples_with_sensitivity_are_kept_inside_a_block() {
    advances(200, |samples| format!("samples = {samples}\nsensitivity = true"));
}

#[test]
fn sobol_points_are_kept_inside_a_randomisation() {
    advances(1024, |samples| format!("method = \"sobol\"\nsamples = {samples}"));
}

#[test]
fn samples_between_two_looks_are_kept() {
    advances(1000, |samples| format!("until = {{ half_width = 0.005, confidence = 0.9, at_most = {samples} }}"));
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

/// A job of rare events with eight random inputs on a flexible disc, whose searches take seconds.
fn slow_search(sampling: &str) -> String {
    slow_job(sampling)
        .replace("record = [\"amplitude\"]\n", "")
        .replace("static_friction = 0.3\n", "static_friction = 0.25\n")
        .replace("relative_std = 0.1", "relative_std = 0.05")
}

/// A batch system ends a run sooner than a search ends.
#[track_caller]
fn searches_advance(sampling: &str) {
    let place = tried_until_met(|attempt| {
        let place = Place::new();
        place.write("slow.toml", &slow_search(sampling));
        let kept = || answers_kept(&place, "run/searches") + samples_done(&place, "run");
        stopped_until_done(attempt, || go_on(&place), kept, |kept| kept > 1000)?;
        Ok(place)
    });
    place.run("submit slow.toml --out whole").done();
    assert!(place.surface("run") == place.surface("whole"));
    assert!(place.run("verify run").done().stdout.contains("searches"));
}

#[test]
fn a_search_for_rare_events_goes_on_where_a_signal_ended_it() {
    searches_advance("method = \"importance\"\nsamples = 256\nrandomisations = 8\nparticles = 100");
}

#[test]
fn a_population_goes_on_where_a_signal_ended_it() {
    searches_advance("method = \"subset\"\nrandomisations = 2\nparticles = 120");
}

/// Nothing is asked for twice of what was on disk before `kill -9`; what is damaged or of another run is not used.
#[test]
fn a_search_that_is_killed_goes_on_from_what_is_on_disk() {
    let place = Place::new();
    let sampling = "method = \"importance\"\nsamples = 256\nrandomisations = 8\nparticles = 300\nseed = 2";
    place.write("slow.toml", &slow_search(sampling));
    let folder = "run/searches";
    for _ in 0..2 {
        let (before, mut running) = (answers_kept(&place, folder), go_on(&place));
        running.wait_for("further answers", || answers_kept(&place, folder) > before);
        send(&running.child, "KILL");
        assert!(!running.child.wait().unwrap().success());
        assert!(samples_done(&place, "run") < 256);
    }
    let kept: Vec<OsString> = names_in(&place, folder).into_iter().collect();
    assert!(kept.len() >= 2, "{kept:?}");
    let copies: Vec<Vec<u8>> = kept.iter().map(|name| fs::read(place.path(folder).join(name)).unwrap()).collect();
    // The answers of another seed, one piece cut short, and one with another bit.
    place.write("slow.toml", &slow_search(&sampling.replace("seed = 2", "seed = 3")));
    let mut other = Running::start(&place, "submit slow.toml --out other --threads 1");
    other.wait_for("its first answers", || answers_kept(&place, "other/searches") > 0);
    other.stop("TERM");
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
    tried_until_met(|attempt| {
        let _ = fs::remove_dir_all(place.path("run"));
        stopped_until_done(attempt, || go_on(&place), kept, |kept| kept > 8192 + 30)
    });
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
         stiffness = [{stiffness}]\n[model.parameters]\nfriction = 0.3\nspeed = 1.0\n[axes]\n\
         friction = [0.3]\n[random]\ninputs = [\"friction\"]\nrelative_std = 0.5\n[criterion]\n\
         kind = \"complex-eigenvalue\"\n[sampling]\nmethod = \"exact\"\n"
    );
    place.write("slow.toml", &job);
    let kept = || answers_kept(&place, "run/searches");
    tried_until_met(|attempt| {
        let _ = fs::remove_dir_all(place.path("run"));
        stopped_until_done(attempt, || go_on(&place), kept, |_| true)
    });
    assert!(!place.path("run/searches").exists(), "what is needed no more is removed");
    place.run("submit slow.toml --out whole").done();
    assert!(place.surface("run") == place.surface("whole"));
}

/// A job with a verdict map that is integrated over it and audited.
const MAPPED: &str = "name = \"mapped\"\n[axes]\nrotating_speed = { from = 12.0, to = 18.0, points = 4 }\n\
    preload = { from = 0.03, to = 0.3, points = 3 }\nstatic_friction = { from = 0.27, to = 0.5, points = 3 }\n[random]\ninputs = [\"preload\", \"static_friction\"]\n\
    relative_std = 0.2\n[criterion]\nkind = \"time-domain\"\ndisc = \"rigid\"\n[sampling]\nmethod = \"exact\"\naudit = ";

#[test]
fn tiles_and_audits_that_are_finished_are_kept() {
    // Until a signal comes in time: the audit becomes longer.
    let (place, said) = tried_until_met(|attempt| {
        let place = Place::new();
        place.write("job.toml", &format!("{MAPPED}{}\n", 200_000 << attempt));
        let mut said = Vec::new();
        for (folder, words) in [("map", "submit job.toml --out run"), ("audit", "resume run")] {
            let files = || place.pieces(&format!("run/{folder}"));
            let mut running = Running::start(&place, words);
            while files() == 0 && running.is_running() {
                thread::sleep(Duration::from_millis(1));
            }
            said.push(running.stop_or_end("INT").map_err(|said| format!("it had ended before {folder}/:\n{said}"))?);
            assert!(files() > 0 && !place.path("run/surface.parquet").exists());
        }
        Ok((place, said))
    });
    for said in said {
        assert!(said.contains("kept; continue with `stickslip resume run`"), "{said}");
    }
    let resumed = place.run("resume run").done().stderr;
    assert!(resumed.contains(", 0 of them new"), "all tiles were there: {resumed}");
    place.run("submit job.toml --out whole").done();
    assert!(place.surface("run") == place.surface("whole"));
}

#[test]
fn a_job_that_prepares_many_brakes_ends_while_it_prepares() {
    let place = Place::new();
    let speeds = "rotating_speed = { from = 10.0, to = 20.0, points = 30_000 }";
    place.write("job.toml", &slow_job("samples = 1").replace("rotating_speed = 15.0", speeds).replace(
        "inputs = [\"preload\", \"static_friction\", \"friction.kinetic_coefficient\", \"friction.stribeck_velocity\", \
         \"stiffness.contact_normal\", \"damping.tangential\", \"pad.mass\", \"disc.thickness\"]",
        "inputs = [\"preload\"]",
    ));
    tried_until_met(|attempt| {
        let run = format!("run-{attempt}");
        let mut running = Running::start(&place, &format!("submit job.toml --out {run} --target 0.5"));
        running.wait_for("its job", || place.path(&run).join("job.toml").exists());
        running.work_for(Duration::from_millis(300));
        let said = running.stop("INT");
        assert!(said.contains(&format!("continue with `stickslip resume {run} --target 0.5`")), "{said}");
        // What it prepares is given up after two seconds, in which a busy machine may not come to its end.
        if said.contains("given up") { Err(said) } else { Ok(()) }
    });
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

/// Begins to run it, each sample for itself or in a verdict map, and lets it work for a while on processors.
fn running_very_slow_job(place: &Place, inputs: &str, modes: u32, sampling: &str, work: Duration) -> Running {
    let job = very_slow_job(inputs, modes, sampling);
    // What is integrated has no amplitudes.
    let job = if sampling.contains("exact") { job.replace("record = [\"amplitude\"]\n", "") } else { job };
    place.write("job.toml", &job);
    let mut running = Running::start(place, "submit job.toml --out run");
    running.wait_for("its job", || place.path("run/job.toml").exists());
    running.work_for(work);
    running
}

/// How much work a try lets a very slow job do before the signal: samples are simulated then, in a build for debugging, which
/// solves the modes of a disc for seconds, in a later try.
fn work(attempt: u32) -> Duration {
    Duration::from_millis(2000 << attempt.min(2))
}

/// An input that changes the modes of the disc.
const OF_MODES: &str = "disc.poissons_ratio";

#[test]
fn what_takes_too_long_is_given_up() {
    let said = tried_until_met(|attempt| {
        let said = running_very_slow_job(&Place::new(), OF_MODES, 24, "samples = 3", work(attempt)).stop("TERM");
        if said.contains("given up") { Ok(said) } else { Err(said) }
    });
    assert!(said.contains("continue with `stickslip resume run`"), "{said}");
}

/// [`Running::stop`], and an error if something was given up: where nothing is, the work ends at the signal, but on a busy
/// machine it may come too late.
fn stopped_in_time(running: Running, signal: &str) -> Result<String, String> {
    let said = running.stop(signal);
    assert!(said.contains("continue with `stickslip resume run`"), "{said}");
    if said.contains("given up") { Err(said) } else { Ok(said) }
}

#[test]
fn a_sample_is_given_up_in_the_middle_of_its_motion() {
    tried_until_met(|attempt| {
        let place = Place::new();
        stopped_in_time(running_very_slow_job(&place, "preload", 24, "samples = 3", work(attempt)), "TERM")
    });
}

#[test]
fn the_search_of_a_verdict_map_ends_in_the_middle_of_its_motions() {
    let mut tiles = BTreeSet::new();
    for (signal, work) in [("TERM", 2000), ("INT", 3400)] {
        tried_until_met(|_| {
            let place = Place::new();
            let work = Duration::from_millis(work);
            let running = running_very_slow_job(&place, "preload", 24, "method = \"exact\"", work);
            stopped_in_time(running, signal)?;
            tiles.extend(names_in(&place, "run/map"));
            Ok(())
        });
    }
    // Tiles are named by their content. One may be finished in time; the other takes a minute.
    assert!(tiles.len() <= 1, "a tile was cut short: {tiles:?}");
}

#[test]
fn a_second_signal_ends_the_process_at_once() {
    tried_until_met(|attempt| {
        let place = Place::new();
        let mut running = running_very_slow_job(&place, OF_MODES, 24, "samples = 3", work(attempt));
        send(&running.child, "INT");
        // A second signal within a moment is the same one, sent to the process and to its group.
        send(&running.child, "INT");
        thread::sleep(Duration::from_millis(500));
        if !running.is_running() {
            return Err("an echo ended it, or it came too late to be one".to_owned());
        }
        send(&running.child, "INT");
        let said = running.ended(130);
        if said.contains("given up") { Err(said) } else { Ok(()) }
    });
}

#[test]
fn nothing_is_predicted_before_something_is_known() {
    let place = Place::new();
    let running = running_very_slow_job(&place, "preload", 24, "samples = 1000", Duration::from_secs(2));
    let said = running.stop("INT").replace("estimating the time left", "");
    assert!(!said.contains("year") && !said.contains(" left"), "{said}");
}
