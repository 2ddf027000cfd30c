//! Messages that name a remedy: it is taken, by its field `remedy` as a program would, and helps.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so and stop")]

use std::fs;
use std::path::{Path, PathBuf};

use crate::common::{BOTH, EIGENVALUE, Outcome, Place, change_piece, job, lines_of, write_piece};
use serde_json::Value;

/// A job that is counted in closed form; one that is looked up in a map, and one that is integrated over it.
const COUNTED: &str = "samples = 3000";
const SIMULATED: &str = "kind = \"time-domain\"\ndisc = \"rigid\"";
const LOOKED_UP: &str = "samples = 20_000\nevaluate = \"boundary\"";
const INTEGRATED: &str = "method = \"exact\"";

/// A place with a job and its finished run, and the surface of that.
fn finished(text: &str) -> (Place, Vec<u8>) {
    let place = Place::new();
    place.write("job.toml", text);
    place.run("submit job.toml --out run").done();
    let surface = place.surface("run");
    (place, surface)
}

fn counted() -> String {
    job("counted", EIGENVALUE, BOTH, COUNTED)
}

fn on_map(sampling: &str) -> String {
    format!(
        "name = \"mapped\"\n[axes]\npreload = [0.08, 0.1]\nstatic_friction = 0.39\n[random]\n{BOTH}\n[criterion]\n{SIMULATED}\n[sampling]\n{sampling}\n"
    )
}

/// The files in a folder of a run.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

/// Copies a directory.
fn copy(from: &Path, to: &Path) {
    fs::create_dir(to).unwrap();
    for file in files(from) {
        let copied = to.join(file.file_name().unwrap());
        if file.is_dir() {
            copy(&file, &copied);
        } else {
            fs::copy(&file, copied).unwrap();
        }
    }
}

/// Flips a bit in the middle of a file.
fn flip(path: &Path) {
    let mut bytes = fs::read(path).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(path, bytes).unwrap();
}

/// The remedy that a refused command names.
#[track_caller]
fn remedy(refused: &Outcome) -> String {
    let last = refused.stderr.lines().rev().find_map(|line| serde_json::from_str::<Value>(line).ok());
    let remedy = last.as_ref().and_then(|message| message["remedy"].as_str());
    remedy.unwrap_or_else(|| panic!("no remedy: {refused:?}")).to_owned()
}

/// Runs a command, and the remedies that it and they name, until one succeeds; then the command itself. Returns all
/// commands.
#[track_caller]
fn remedied(place: &Place, words: &str) -> Vec<String> {
    let mut taken = vec![words.to_owned()];
    while taken.len() < 5 {
        let command = taken.last().unwrap().clone();
        let outcome = place.run(&format!("--messages json {command}"));
        if outcome.code == Some(0) {
            place.run(words).done();
            return taken;
        }
        let remedy = remedy(&outcome);
        let next = match remedy.strip_prefix("stickslip ") {
            Some(words) => words.to_owned(),
            // An option of a submission, and what says that the job is to be submitted.
            None if remedy.contains("--out run") => "submit job.toml --out run".to_owned(),
            None => panic!("{remedy}"),
        };
        taken.push(next);
    }
    panic!("one names the other: {taken:?}");
}

/// Asserts that a run is whole, with this surface.
#[track_caller]
fn assert_whole(place: &Place, surface: &[u8]) {
    let verified = place.run("verify run").done().stdout;
    assert!(!verified.contains("lost") && !verified.contains("damaged"), "{verified}");
    assert!(place.run("status run").done().stdout.contains("finished"));
    assert!(place.surface("run") == surface, "another surface");
}

#[test]
fn lost_and_damaged_pieces_of_a_verdict_map_are_computed_again() {
    for (sampling, folders) in [(LOOKED_UP, &["map"][..]), (INTEGRATED, &["map", "audit"])] {
        let (place, surface) = finished(&on_map(sampling));
        let tiles = |place: &Place| {
            let mut tiles: Vec<Value> = files(&place.path("run/map"))
                .iter()
                .filter(|file| file.extension() == Some("jsonl".as_ref()))
                .flat_map(|file| lines_of(file).split_off(1))
                .collect();
            tiles.sort_by_key(Value::to_string);
            tiles
        };
        let before = tiles(&place);
        for folder in folders {
            for damage in [flip, |path: &Path| fs::remove_file(path).unwrap()] {
                damage(files(&place.path("run").join(folder)).first().unwrap());
                // Whoever asks again before the remedy is taken hears the same.
                place.run("verify run").refused(74, &["stickslip resume run"]);
                let twice = place.run("verify run").refused(74, &["stickslip resume run"]).stdout;
                assert!(twice.contains(&format!("{folder}/: ")) && twice.contains("are lost"), "{twice}");
                if *folder == "map" {
                    place.run("plot run --of verdicts --out v.svg").refused(65, &["stickslip resume run"]);
                }
                assert_eq!(remedied(&place, "verify run"), ["verify run", "resume run"]);
                assert_whole(&place, &surface);
                place.run("plot run --of verdicts --out v.svg").done();
                for file in files(&place.path("run").join(folder)) {
                    if file.to_string_lossy().ends_with(".damaged") {
                        fs::remove_file(file).unwrap();
                    }
                }
            }
        }
        assert!(tiles(&place) == before, "other tiles");
    }
}

#[test]
fn the_digests_of_another_run_are_written_again() {
    let (place, surface) = finished(&counted());
    place.write("other.toml", &counted().replace("3000", "1000"));
    place.run("submit other.toml --out other").done();
    fs::copy(place.path("other/digests.json"), place.path("run/digests.json")).unwrap();
    for words in ["status run", "resume run", "plot run --out p.svg", "submit job.toml --out run --samples 2000"] {
        fs::copy(place.path("other/digests.json"), place.path("run/digests.json")).unwrap();
        let refused = place.run(&format!("--messages json {words}"));
        assert_eq!((refused.code, remedy(&refused).as_str()), (Some(74), "stickslip verify run"), "{refused:?}");
        let verified = place.run("verify run").done().stdout;
        assert!(verified.contains("digests.json: of another run, and written again"), "{verified}");
        assert_whole(&place, &surface);
    }
    // The other remedy that is named.
    fs::copy(place.path("other/digests.json"), place.path("run/digests.json")).unwrap();
    place.run("submit job.toml --out run").done();
    assert!(place.run("verify run").done().stdout.contains("nothing depends on it"), "of the record of sessions");
    assert_whole(&place, &surface);
    // A run that has not finished has no surface that says what it was; its pieces do.
    for is_recorded in [true, false] {
        place.run("submit job.toml --out half --shard 1/2").done();
        if is_recorded {
            place.write("half/run.json", "{\"sessions\": []}");
        }
        fs::copy(place.path("other/digests.json"), place.path("half/digests.json")).unwrap();
        place.run("resume half").refused(74, &["damaged or edited"]);
        place.write("different.toml", &counted().replace("[sampling]", "[sampling]\nseed = 5"));
        place.run("submit different.toml --out half").refused(74, &["damaged or edited"]);
        if is_recorded {
            place.run("verify half").done();
        } else {
            place.run("verify half").refused(74, &["submit the job again to this directory with `--out half`"]);
            place.run("submit job.toml --out half").refused(73, &["stickslip resume half"]);
        }
        place.run("resume half").done();
        assert!(place.surface("half") == surface);
        place.run("verify half").done();
        fs::remove_dir_all(place.path("half")).unwrap();
    }
}

#[test]
fn every_lost_or_damaged_file_of_a_finished_run_comes_back() {
    let limits = "[limit]\nof = \"preload\"\nprobability = 0.5\n";
    for (text, file) in [
        (counted() + limits, "job.toml"),
        (counted() + limits, "surface.parquet"),
        (counted() + limits, "shards"),
        (counted() + limits, "limits.parquet"),
        (on_map(LOOKED_UP), "surface.parquet"),
        (on_map(INTEGRATED), "job.toml"),
        (on_map(INTEGRATED), "surface.parquet"),
    ] {
        let (place, surface) = finished(&text);
        let whole = place.path("whole");
        copy(&place.path("run"), &whole);
        for is_lost in [true, false] {
            for with_digests in [true, false] {
                fs::remove_dir_all(place.path("run")).unwrap();
                copy(&whole, &place.path("run"));
                let path = place.path("run").join(file);
                match (is_lost, file) {
                    (true, "shards") => fs::remove_dir_all(&path).unwrap(),
                    (true, _) => fs::remove_file(&path).unwrap(),
                    (false, "shards") => flip(&files(&path)[0]),
                    (false, _) => flip(&path),
                }
                if !with_digests {
                    fs::remove_file(place.path("run/digests.json")).unwrap();
                }
                let what = format!("{file}, lost: {is_lost}, digests: {with_digests}");
                let damaged = place.path("damaged");
                let _ = fs::remove_dir_all(&damaged);
                copy(&place.path("run"), &damaged);
                for words in [
                    "plot run --out p.svg",
                    "export run --format csv --out a.csv",
                    "status run",
                    "verify run",
                    "resume run",
                ] {
                    fs::remove_dir_all(place.path("run")).unwrap();
                    copy(&damaged, &place.path("run"));
                    remedied(&place, words);
                    // What the state is, and the command that status names.
                    let status = place.run("status run").done().stdout;
                    if let Some((_, command)) = status.split_once("`stickslip ") {
                        remedied(&place, command.split_once('`').unwrap().0);
                    }
                    assert!(place.run("status run").done().stdout.contains("finished"), "{what}, {words}: {status}");
                    remedied(&place, "resume run");
                    remedied(&place, "verify run");
                    assert_whole(&place, &surface);
                }
            }
        }
    }
}

#[test]
fn what_is_missing_of_an_unfinished_run_is_computed() {
    let surface = finished(&counted()).1;
    for words in [
        "merge run",
        "plot run --out p.svg",
        "export run --format csv --out a.csv",
        "report run --out r.html",
        "submit job.toml --out run",
        "samples run --cell 0 --out s.parquet",
        "compare run whole",
    ] {
        for file in [None, Some("job.toml"), Some("shards")] {
            let (place, whole) = finished(&counted());
            assert!(whole == surface);
            fs::rename(place.path("run"), place.path("whole")).unwrap();
            place.run("submit job.toml --out run --shard 1/2").done();
            match file {
                Some("shards") => flip(&files(&place.path("run/shards"))[0]),
                Some(file) => flip(&place.path("run").join(file)),
                None => {}
            }
            remedied(&place, words);
            assert_whole(&place, &surface);
        }
    }
}

#[test]
fn a_job_that_does_not_fit_is_submitted_as_the_message_says() {
    let (place, surface) = finished(&counted());
    place.write("fewer.toml", &counted().replace("3000", "2000"));
    let refused = place.run("--messages json submit fewer.toml --out run");
    assert_eq!(remedy(&refused), "--samples 3000");
    place.run("submit fewer.toml --out run --samples 3000").done();
    assert_whole(&place, &surface);
    place.write("different.toml", &counted().replace("[sampling]", "[sampling]\nseed = 5"));
    fs::create_dir(place.path("mine")).unwrap();
    place.write("mine/thesis.tex", "");
    for words in ["submit different.toml --out run", "submit different.toml --out mine"] {
        let refused = place.run(&format!("--messages json {words}"));
        assert_eq!(remedy(&refused), "--out", "{refused:?}");
    }
    place.run("submit different.toml --out elsewhere").done();
    // More samples for a run that is not finished.
    place.run("submit fewer.toml --out half --shard 1/2").done();
    let refused = place.run("--messages json submit job.toml --out half");
    assert_eq!(remedy(&refused), "stickslip resume half");
    place.run("resume half").done();
    place.run("submit job.toml --out half").done();
    assert!(place.surface("half") == surface);
}

#[test]
fn pieces_that_disagree_or_cannot_be_are_computed_again() {
    let (place, surface) = finished(&counted());
    let piece = files(&place.path("run/shards")).remove(0);
    let mut lines = lines_of(&piece);
    let counts = lines[1][3].as_array_mut().unwrap();
    counts.swap(0, 1);
    write_piece(&place.path("run/shards"), &lines);
    let refused = place.run("--messages json status run");
    assert_eq!((refused.code, remedy(&refused).as_str()), (Some(74), "stickslip resume run"), "{refused:?}");
    assert!(refused.stderr.contains("Move shards/ elsewhere, make an empty one in its place"), "{refused:?}");
    fs::rename(place.path("run/shards"), place.path("elsewhere")).unwrap();
    fs::create_dir(place.path("run/shards")).unwrap();
    place.run("resume run").done();
    assert_whole(&place, &surface);
    // A sum that no samples have.
    let text = counted().replace(BOTH, "inputs = [\"preload\", \"static_friction\", \"pad.mass\"]\nrelative_std = 0.1");
    let (place, surface) = finished(&text.replace(COUNTED, "method = \"conditional\"\nsamples = 1024"));
    fs::remove_file(place.path("run/surface.parquet")).unwrap();
    change_piece(&files(&place.path("run/shards"))[0], |lines| lines[1][6][0] = (1_u64 << 53).into());
    let verified = place.run("verify run");
    assert!(verified.stderr.contains("its sums cannot be those of its samples"), "{verified:?}");
    remedied(&place, "plot run --out p.svg");
    assert_whole(&place, &surface);
}
