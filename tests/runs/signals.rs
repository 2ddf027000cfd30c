//! Signals of every kind, limits of the system, and files that cannot be written: what is finished is kept, nothing
//! half done is left, and the message says how to go on.

#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so and stop")]

use std::fs;
use std::os::fd::OwnedFd;
use std::os::unix::net::UnixDatagram;
use std::process::{Child, Command, Output, Stdio};
use std::thread;
use std::time::Duration;

use crate::common::{Place, send, surface_job, tried_until_met, wait_for, wait_until_it_watches, with_default_signals};

/// Starts a command of a shell, in which `stickslip` stands for the program.
fn start(place: &Place, script: &str) -> Child {
    let script = script.replace("stickslip", env!("CARGO_BIN_EXE_stickslip"));
    let mut shell = with_default_signals("sh");
    shell.args(["-c", &script]).current_dir(place.path("")).stdin(Stdio::null());
    shell.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

#[track_caller]
fn ended(child: Child, code: i32, texts: &[&str]) -> String {
    let Output { status, stderr, .. } = child.wait_with_output().unwrap();
    let said = String::from_utf8(stderr).unwrap();
    assert_eq!(status.code(), Some(code), "{status:?} {said}");
    for text in texts {
        assert!(said.contains(text), "{text:?} is not in: {said}");
    }
    said
}

/// The number of files in a folder of a run.
fn unfinished(place: &Place, folder: &str) -> usize {
    let entries = fs::read_dir(place.path(folder)).unwrap();
    entries.filter(|entry| entry.as_ref().unwrap().file_name().to_string_lossy().starts_with(".unfinished")).count()
}

/// A job that no test sees the end of.
fn long_job(place: &Place) {
    place.write("job.toml", &surface_job("long", 20, 2_000_000_000, 3));
}

#[test]
fn every_signal_that_ends_a_process_is_obeyed() {
    let place = Place::new();
    long_job(&place);
    for (signal, number, words) in [
        ("HUP", 1, "ended by SIGHUP"),
        ("QUIT", 3, "ended by SIGQUIT"),
        ("TRAP", 5, "ended by SIGTRAP"),
        ("ABRT", 6, "ended by SIGABRT"),
        ("USR1", 10, "ended by SIGUSR1"),
        ("USR2", 12, "ended by SIGUSR2"),
        ("ALRM", 14, "ended by SIGALRM"),
        ("XCPU", 24, "ended by SIGXCPU"),
        ("VTALRM", 26, "ended by SIGVTALRM"),
        ("40", 40, "ended by signal 40"),
    ] {
        tried_until_met(|_| {
            let is_new = !place.path("run/job.toml").exists();
            let words_of_command =
                if is_new { "exec stickslip submit job.toml --out run" } else { "exec stickslip resume run" };
            let before = place.pieces("run/shards");
            let mut child = start(&place, words_of_command);
            wait_for("pieces", &mut child, || place.pieces("run/shards") > before + 1);
            send(&child, signal);
            let said = ended(child, 128 + number, &[words, "saving what is finished", "`stickslip resume run`"]);
            // A busy machine may not have the time to save.
            if said.contains("given up") {
                return Err(said);
            }
            assert!(said.contains("samples are kept"), "{said}");
            assert_eq!(unfinished(&place, "run/shards"), 0);
            let record = fs::read_to_string(place.path("run/run.json")).unwrap();
            assert!(record.contains(&format!("\"outcome\": \"{words}\"")), "{record}");
            Ok(())
        });
    }
}

#[test]
fn a_command_without_work_obeys_signals_too() {
    let place = Place::new();
    place.run("init job.toml").done();
    assert!(Command::new("mkfifo").arg(place.path("pipe")).status().unwrap().success());
    let mut child = start(&place, "exec stickslip check pipe");
    wait_until_it_watches(&mut child);
    send(&child, "HUP");
    ended(child, 129, &["ended by SIGHUP"]);
}

#[test]
fn signals_that_were_ignored_at_the_start_stay_so() {
    let place = Place::new();
    long_job(&place);
    let mut child = start(&place, "trap '' HUP TERM USR1; exec stickslip submit job.toml --out run");
    wait_for("a piece", &mut child, || place.pieces("run/shards") > 0);
    for signal in ["HUP", "TERM", "USR1"] {
        send(&child, signal);
    }
    let before = place.pieces("run/shards");
    wait_for("further pieces", &mut child, || place.pieces("run/shards") > before + 2);
    send(&child, "INT");
    let said = ended(child, 130, &["interrupted"]);
    assert!(!said.contains("ended by") && !said.contains("terminated"), "{said}");
}

#[test]
fn a_file_beyond_the_size_limit_is_an_error_of_its_write() {
    let place = Place::new();
    place.write("job.toml", &surface_job("job", 20, 100, 3));
    let child = start(&place, "ulimit -f 1; exec stickslip submit job.toml --out run");
    ended(child, 74, &["cannot write run/shards", "File too large", "free space", "then `stickslip resume run`"]);
    place.run("resume run").done();
    let child = start(&place, "ulimit -f 1; exec stickslip trajectory --disc rigid --horizon 50 --out motion.parquet");
    ended(child, 74, &["cannot write ./motion.parquet", "File too large"]);
    assert!(unfinished(&place, "") == 0 && !place.path("motion.parquet").exists());
}

/// Puts a directory in place of a file, and one that is not empty where it would be set aside.
fn obstruct(place: &Place, name: &str) {
    fs::create_dir(place.path(name)).unwrap();
    fs::create_dir_all(place.path(&format!("{name}.damaged/something"))).unwrap();
}

#[test]
fn a_signal_says_how_to_go_on_though_the_record_cannot_be_written() {
    let place = Place::new();
    long_job(&place);
    tried_until_met(|_| {
        let _ = fs::remove_dir_all(place.path("run"));
        let mut child = start(&place, "exec stickslip submit job.toml --out run");
        wait_for("a piece", &mut child, || place.pieces("run/shards") > 0);
        obstruct(&place, "run/run.json");
        send(&child, "TERM");
        let said = ended(child, 143, &["terminated", "`stickslip resume run`"]);
        // A busy machine may not have the time to save.
        if said.contains("given up") {
            return Err(said);
        }
        assert!(said.contains("warning: cannot write run/run.json"), "{said}");
        assert!(said.lines().last().unwrap().contains("samples are kept; continue with"), "{said}");
        Ok(())
    });
}

#[test]
fn a_result_that_cannot_be_written_is_named_with_a_remedy() {
    let place = Place::new();
    place.write("job.toml", &surface_job("job", 3, 100, 3));
    for (name, again) in [("surface.parquet", "resume"), ("run.json", "resume"), ("surface.parquet", "merge")] {
        let _ = fs::remove_dir_all(place.path("run"));
        fs::create_dir_all(place.path("run/shards")).unwrap();
        if again == "merge" {
            place.run("submit job.toml --out run --shard 1/1").done();
        } else {
            place.write("run/job.toml", &fs::read_to_string(place.path("job.toml")).unwrap());
        }
        let obstacle = format!("run/{name}");
        obstruct(&place, &obstacle);
        let then = format!("correct that, or where a disk is full free space, then `stickslip {again} run`");
        place.run(&format!("{again} run")).refused(74, &[&format!("cannot write run/{name}"), &then]);
        fs::remove_dir(place.path(&obstacle)).unwrap();
        place.run(&format!("{again} run")).done();
    }
}

#[test]
fn a_signal_removes_the_files_that_are_not_finished() {
    let place = Place::new();
    let job = surface_job("wide", 250, 1, 3);
    place.write("job.toml", &job);
    place.run("submit job.toml --out run").done();
    fs::create_dir(place.path("out")).unwrap();
    // Until signals have come while the file was written.
    for _ in 0..3 {
        tried_until_met(|_| {
            let mut child = start(&place, "exec stickslip export run --format csv --out out/wide.csv");
            while unfinished(&place, "out") == 0 && child.try_wait().unwrap().is_none() {
                thread::sleep(Duration::from_millis(1));
            }
            // Of one that has ended and is not waited for, there is a process still.
            if child.try_wait().unwrap().is_none() {
                send(&child, "TERM");
            }
            let output = child.wait_with_output().unwrap();
            let is_whole = place.path("out/wide.csv").exists();
            assert_eq!(output.status.code(), Some(if is_whole && output.status.success() { 0 } else { 143 }));
            assert_eq!(unfinished(&place, "out"), 0, "it left a temporary file");
            if !is_whole {
                return Ok(());
            }
            let lines = fs::read_to_string(place.path("out/wide.csv")).unwrap().lines().count();
            assert_eq!(lines, 62_501, "a part of it has the final name");
            fs::remove_file(place.path("out/wide.csv")).unwrap();
            Err("the file was whole before the signal".to_owned())
        });
    }
}

#[test]
fn a_message_is_written_at_once() {
    let place = Place::new();
    let (ours, theirs) = UnixDatagram::pair().unwrap();
    let status = place.command("status nowhere").stderr(Stdio::from(OwnedFd::from(theirs))).status().unwrap();
    assert_eq!(status.code(), Some(74));
    ours.set_nonblocking(true).unwrap();
    let mut bytes = [0; 4096];
    let length = ours.recv(&mut bytes).unwrap();
    let said = String::from_utf8_lossy(&bytes[..length]);
    assert_eq!(said, "stickslip: nowhere is not a run directory: it does not exist\n");
    assert!(ours.recv(&mut bytes).is_err(), "it took a second write");
}

#[test]
fn control_characters_of_a_name_do_not_reach_the_terminal() {
    let place = Place::new();
    let mut command = place.command("submit");
    let output = command.arg("job\u{1b}[2J.toml").output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(74), "{said}");
    assert!(said.contains("cannot read $'job\\033[2J.toml'"), "{said}");
}
