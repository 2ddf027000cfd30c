//! `status --watch`: the progress of a run while it goes on.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so and stop")]

use std::io::{BufRead as _, BufReader};
use std::process::{Child, Stdio};

use crate::common::{BOTH, EIGENVALUE, Place, job, send, submitted, wait_for};

/// A run that takes minutes, under way, with some samples saved.
fn slow_run(place: &Place) -> Child {
    let text = job("slow", "kind = \"time-domain\"\ndisc = \"rigid\"", BOTH, "samples = 1_000_000");
    place.write("slow.toml", &text);
    let mut command = place.command("submit slow.toml --out slow --threads 1");
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    wait_for("a piece", &mut child, || place.pieces("slow/shards") > 0);
    child
}

#[test]
fn a_run_under_way_is_shown_in_blocks_until_it_ends() {
    let place = Place::new();
    let mut run = slow_run(&place);
    let mut watch = place.command("status slow --watch").stdout(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(watch.stdout.take().unwrap()).lines().map(Result::unwrap);
    let block: Vec<String> = lines.by_ref().take(5).collect();
    assert_eq!(block[0], "slow: running");
    assert!(block[1].starts_with('░') || block[1].starts_with('█'), "{block:?}");
    assert!(block[1].ends_with(" %"), "{block:?}");
    assert!(block[2].contains(" of 30,000,000 samples, 0 of 30 cells finished"), "{block:?}");
    assert!(block[3].contains("saved every few seconds"), "no rate is known at the first look: {block:?}");
    assert!(block[4].starts_with("mean probability of instability so far: 0."), "{block:?}");
    // The rate is known after the second arrival.
    let rate = lines.by_ref().find(|line| line.contains(" samples/s, about ")).unwrap();
    assert!(rate.ends_with(" left"), "{rate}");
    send(&run, "INT");
    run.wait().unwrap();
    let rest: Vec<String> = lines.collect();
    for line in block.iter().chain(&rest) {
        assert!(line.chars().count() <= 80 && !line.contains('\u{1b}'), "{line:?}");
    }
    assert!(rest.iter().any(|line| line.starts_with("slow: unfinished, ")), "{rest:?}");
    assert_eq!(rest.last().unwrap(), "continue with `stickslip resume slow`");
    assert_eq!(watch.wait().unwrap().code(), Some(0));
}

#[test]
fn every_shard_has_a_bar() {
    let place = Place::new();
    place.write("parts.toml", &job("parts", EIGENVALUE, BOTH, "samples = 2_000_000"));
    place.run("submit parts.toml --out parts --shard 2/3").done();
    let shown = place.run("status parts --watch --shards 3").done().stdout;
    for (line, share) in ["  0.0 %  shard 1/3", "100.0 %  shard 2/3", "  0.0 %  shard 3/3"].into_iter().zip([0, 40, 0])
    {
        let shown = shown.lines().find(|shown| shown.ends_with(line)).unwrap_or_else(|| panic!("{line}\n{shown}"));
        assert_eq!(shown.chars().filter(|&c| c == '█').count(), share, "{shown}");
    }
    let status = place.run("status parts --shards 3").done().stdout;
    assert!(status.contains("\nshards: 1 of 3 done; missing: 1,3\n"), "{status}");
    place.run("status parts --watch --shards 0").refused(64, &["1..=1000"]);
}

#[test]
fn a_signal_ends_the_watch_and_not_the_run() {
    let place = Place::new();
    let mut run = slow_run(&place);
    let mut watch = place.command("status slow --watch");
    let mut watch = watch.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut first = String::new();
    BufReader::new(watch.stdout.as_mut().unwrap()).read_line(&mut first).unwrap();
    send(&watch, "INT");
    let output = watch.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("interrupted; the run itself is not touched") && !said.contains('\u{1b}'), "{said}");
    assert!(run.try_wait().unwrap().is_none(), "the run goes on");
    run.kill().unwrap();
    run.wait().unwrap();
}

#[test]
fn a_run_that_nobody_works_in_is_shown_once() {
    let place = Place::new();
    submitted(&place, "run", &job("run", EIGENVALUE, BOTH, "samples = 100"));
    let status = place.run("status run").done().stdout;
    assert_eq!(place.run("status run --watch").done().stdout, status);
    for option in ["--watch", "--missing", "--missing --format slurm", "--shards 4", "--shards 4 --json"] {
        let name = option.split(' ').next().unwrap();
        let message = format!("{name} is for one run, and . holds several; name one of them");
        place.run(&format!("status . {option}")).refused(64, &[&message]);
    }
    place.run("status run --watch --json").refused(64, &["--json"]);
    place.run("status missing --watch").refused(74, &["missing is not a run directory"]);
}
