//! What happens to a run directory that is damaged, moved, shared or full of other things: nothing that was computed is
//! lost, nothing broken is read as good, and nothing waits for ever.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so and stop")]

use std::fs::{self, File};
use std::os::unix::fs::{PermissionsExt as _, symlink};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::Duration;

use crate::common::{BOTH, Outcome, Place, job, make_pipe, surface_job, wait_for, wait_until};

/// A finished run of a small job.
fn finished() -> Place {
    let place = Place::new();
    place.write("job.toml", &surface_job("small", 3, 2000, 7));
    place.run("submit job.toml --out run").done();
    place
}

/// Runs a command, and asserts that it reads little: the program itself, and small files.
#[track_caller]
fn run_counting_reads(place: &Place, words: &str) -> Outcome {
    if !cfg!(target_os = "linux") {
        return place.run(words).done();
    }
    // What a process has read counts with its parent once that has waited for it.
    let line = format!("{} {words} && cat /proc/$$/io >&2", env!("CARGO_BIN_EXE_stickslip"));
    let mut shell = Command::new("sh");
    let output = shell.args(["-c", &line]).current_dir(place.path("")).output().unwrap();
    let [stdout, stderr] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
    let read = stderr.lines().find_map(|line| line.strip_prefix("rchar: ")).unwrap_or_else(|| panic!("{stderr}"));
    let read: u64 = read.parse().unwrap();
    assert!((1..32 << 20).contains(&read), "it read {read} bytes: {stderr}");
    Outcome { code: output.status.code(), stdout, stderr }.done()
}

/// The files of a folder with this extension.
fn files(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.filter(|path| path.extension().is_some_and(|found| found == extension)).collect()
}

#[test]
fn a_damaged_surface_is_noticed_wherever_it_is_read_and_written_again() {
    let place = finished();
    let sound = place.surface("run");
    let path = place.path("run/surface.parquet");
    let step = sound.len() / 40;
    for position in (0..sound.len()).step_by(step) {
        let mut bytes = sound.clone();
        bytes[position] ^= 1 << (position % 8);
        fs::write(&path, &bytes).unwrap();
        let status = place.run("status run").done();
        assert!(status.stdout.contains("surface damaged"), "byte {position}: {}", status.stdout);
        let remedy = ["is damaged", "stickslip verify run"];
        place.run("plot run --out plot.svg").refused(74, &remedy);
        if position % (10 * step) == 0 {
            for words in ["export run --format csv --out a.csv", "report run --out a.html"] {
                place.run(words).refused(74, &remedy);
            }
            let verified = place.run("verify run").done();
            assert!(verified.stdout.contains("it is written again from the pieces"), "{}", verified.stdout);
            assert!(place.surface("run") == sound);
            place.run("plot run --out plot.svg").done();
        }
    }
    fs::write(&path, &sound[..sound.len() / 2]).unwrap();
    place.run("resume run").done();
    assert!(place.surface("run") == sound);
}

#[test]
fn sparse_pieces_are_not_read_to_their_end() {
    let place = finished();
    for number in 0..8 {
        let name = format!("run/shards/{number}123456789abcdef0123456789abcdef.jsonl");
        File::create(place.path(&name)).unwrap().set_len(1 << 30).unwrap();
    }
    let status = run_counting_reads(&place, "status run");
    assert!(status.stdout.contains("finished") && status.stderr.contains("bytes that no such file has"), "{status:?}");
    place.run("resume run").done();
    assert!(place.run("verify run").done().stdout.contains("shards/: 1 piece, all sound"));
}

#[test]
fn a_run_that_another_process_is_making_is_not_called_lost() {
    let place = finished();
    fs::remove_file(place.path("run/job.toml")).unwrap();
    fs::remove_file(place.path("run/surface.parquet")).unwrap();
    let lock = File::options().write(true).open(place.path("run/run.lock")).unwrap();
    lock.lock().unwrap();
    for words in ["status run", "resume run", "plot run --out p.svg"] {
        place.run(words).refused(75, &["run is being made by ", "; wait until it ends, or stop it"]);
    }
    drop(lock);
    place.run("status run").refused(74, &["its job.toml is lost; submit the job again with `--out run`"]);
}

#[test]
fn what_is_not_seen_is_shown_in_paths_and_descriptions() {
    let place = finished();
    let name = "\x1b[31mred\u{202e}\u{9b}2J";
    fs::rename(place.path("run"), place.path(name)).unwrap();
    let is_seen = |text: &str| text.chars().all(|c| c == '\n' || c == '\t' || !(c.is_control() || c == '\u{202e}'));
    for words in [
        "plot",
        "report",
        "export --format csv",
        "samples --cell 0",
        "status",
        "status --json",
        "resume",
        "verify --json",
    ] {
        let output = place.command(words).arg(name).output().unwrap();
        let stdout = String::from_utf8(output.stdout).unwrap();
        assert!(output.status.success() && is_seen(&stdout), "{words}: {stdout:?}");
        if !["plot", "report", "export --format csv"].contains(&words) {
            continue;
        }
        // A shell takes what is printed for the path.
        for line in stdout.lines() {
            let script = format!("test -f {line}");
            let found = Command::new("bash").args(["-c", &script]).current_dir(place.path("")).status().unwrap();
            assert!(found.success(), "{line:?}");
        }
    }
    let text = surface_job("described", 3, 2000, 7);
    let described = text.replacen('\n', "\ndescription = \"a\u{202e}b\"\n", 1);
    place.write("described.toml", &described);
    let checked = place.run("check --all described.toml").done().stdout;
    assert!(checked.contains("description = \"a\\u202eb\"") && is_seen(&checked), "{checked}");
    place.write("again.toml", &checked);
    place.run("check again.toml").done();
    place.run("submit described.toml --out described").done();
    place.run("report described").done();
    let page = fs::read_to_string(place.path("described/report.html")).unwrap();
    assert!(page.contains("a\\u202eb") && !page.contains('\u{202e}'));
}

#[test]
fn every_damaged_byte_of_a_frozen_job_is_noticed_and_the_surface_holds_what_it_was() {
    let place = finished();
    let path = place.path("run/job.toml");
    let sound = fs::read(&path).unwrap();
    for position in 0..sound.len() {
        let mut bytes = sound.clone();
        bytes[position] ^= 1 << (position % 7);
        fs::write(&path, &bytes).unwrap();
        place.run("status run").refused(74, &["job.toml was damaged or edited", "stickslip verify run"]);
    }
    place.run("resume run").refused(74, &["damaged or edited"]);
    // The same job heals it, another one does not.
    let other = surface_job("small", 3, 2000, 8);
    place.write("other.toml", &other);
    place.run("submit other.toml --out run").refused(74, &["damaged or edited"]);
    let healed = place.run("submit job.toml --out run").done();
    assert!(healed.stderr.contains("job.toml was damaged; it is written again"), "{}", healed.stderr);
    assert_eq!(fs::read(&path).unwrap(), sound);
    for damage in [None, Some(&b"no job"[..])] {
        match damage {
            Some(bytes) => fs::write(&path, bytes).unwrap(),
            None => fs::remove_file(&path).unwrap(),
        }
        let surface = place.surface("run");
        if damage.is_none() {
            place.run("status run").refused(74, &["its job.toml is lost", "stickslip verify run"]);
        }
        let verified = place.run("verify run").done();
        assert!(verified.stdout.contains("the surface holds what it was"), "{}", verified.stdout);
        assert!(place.run("status run").done().stdout.contains("finished"));
        place.run("resume run").done();
        assert!(place.surface("run") == surface);
    }
}

#[test]
fn a_surface_of_fewer_samples_than_there_are_pieces_does_not_restore_the_job() {
    let place = finished();
    let small = surface_job("small", 3, 2000, 7);
    place.write("large.toml", &small.replace("samples = 2000", "samples = 4000"));
    place.run("submit large.toml --out run --shard 1/2").done();
    let frozen = fs::read(place.path("run/job.toml")).unwrap();
    fs::remove_file(place.path("run/job.toml")).unwrap();
    place.write("run/digests.json", "{}");
    for digests in ["digests.json: damaged, and written again", "digests.json: sound"] {
        let verified = place.run("verify run").refused(74, &["submit the job again", "finished pieces are kept"]);
        assert!(verified.stdout.contains("job.toml: lost") && verified.stdout.contains(digests), "{}", verified.stdout);
    }
    place.run("submit large.toml --out run --shard 2/2").done();
    assert_eq!(fs::read(place.path("run/job.toml")).unwrap(), frozen);
    place.run("merge run").done();
    place.run("submit large.toml --out whole").done();
    assert!(place.surface("run") == place.surface("whole"));
}

#[test]
fn writes_that_fail_again_and_again_do_not_make_a_sound_job_a_damaged_one() {
    let place = finished();
    for samples in [4000, 5000, 6000] {
        let job = surface_job("small", 3, 2000, 7).replace("samples = 2000", &format!("samples = {samples}"));
        place.write("larger.toml", &format!("{job}# {}\n", "long ".repeat(200)));
        let limited = format!("ulimit -f 1; exec {} submit larger.toml --out run", env!("CARGO_BIN_EXE_stickslip"));
        let output = Command::new("sh").args(["-c", &limited]).current_dir(place.path("")).output().unwrap();
        assert_eq!(output.status.code(), Some(74), "{}", String::from_utf8_lossy(&output.stderr));
    }
    assert!(place.run("status run").done().stdout.contains("finished"));
    assert!(place.run("verify run").done().stdout.contains("job.toml: sound"));
}

#[test]
fn verify_does_not_take_a_folder_with_a_job_for_a_run_and_does_not_forget_lost_pieces() {
    let place = finished();
    fs::create_dir(place.path("mine")).unwrap();
    fs::copy(place.path("job.toml"), place.path("mine/job.toml")).unwrap();
    place.run("verify mine").refused(74, &["mine is not a run directory"]);
    assert_eq!(fs::read_dir(place.path("mine")).unwrap().count(), 1, "something was written");
    for piece in files(&place.path("run/shards"), "jsonl") {
        fs::remove_file(piece).unwrap();
    }
    for _ in 0..2 {
        let verified = place.run("verify run").refused(74, &["stickslip resume run"]);
        assert!(verified.stdout.contains("of its pieces only 0 of 9 cells"), "{}", verified.stdout);
    }
}

#[test]
fn directories_in_place_of_files_are_set_aside() {
    let place = finished();
    let sound = place.surface("run");
    let piece = files(&place.path("run/shards"), "jsonl").remove(0);
    let piece = format!("shards/{}", piece.file_name().unwrap().to_string_lossy());
    for name in ["surface.parquet", "job.toml", "run.json", "digests.json", &piece] {
        let path = place.path("run").join(name);
        fs::remove_file(&path).unwrap();
        fs::create_dir(&path).unwrap();
        if name.starts_with("shards/") {
            place.run("verify run").refused(74, &["set aside", "stickslip resume run"]);
        } else {
            place.run("verify run").done();
        }
        place.run("resume run").done();
        assert!(!path.is_dir() && place.surface("run") == sound, "{name}");
        place.run("verify run").done();
    }
    let lock = place.path("run/run.lock");
    fs::remove_file(&lock).unwrap();
    symlink("elsewhere", &lock).unwrap();
    place.run("resume run").refused(73, &["run.lock: it is a link; move it elsewhere"]);
}

#[test]
fn a_process_is_named_once_in_the_lock() {
    let place = Place::new();
    place.write("long.toml", &surface_job("long", 20, 2_000_000_000, 3));
    let mut first = started(&place, "submit long.toml --out run --threads 1 --shard 1/2");
    wait_for("a piece", &mut first, || place.pieces("run/shards") > 0);
    let busy = place.run("merge run --wait 0").refused(75, &["in use by process"]);
    assert!(!busy.stderr.contains("more"), "{}", busy.stderr);
    first.kill().unwrap();
    first.wait().unwrap();
}

#[test]
fn verify_names_what_is_damaged_and_resume_computes_it_again() {
    let place = finished();
    let sound = place.surface("run");
    let verified = place.run("verify run").done();
    for line in
        ["job.toml: sound", "all sound", "surface.parquet: sound, the same bytes as the pieces give", "run.json: sound"]
    {
        assert!(verified.stdout.contains(line), "{line}: {}", verified.stdout);
    }
    let piece = files(&place.path("run/shards"), "jsonl").remove(0);
    let mut bytes = fs::read(&piece).unwrap();
    bytes[40] ^= 4;
    fs::write(&piece, bytes).unwrap();
    fs::write(place.path("run/run.json"), "{").unwrap();
    let verified = place.run("verify run").refused(74, &["damaged: shards/", "stickslip resume run"]);
    assert!(verified.stdout.contains("1 of them damaged"), "{}", verified.stdout);
    assert!(piece.with_extension("jsonl.damaged").exists() && place.path("run/run.json.damaged").exists());
    place.run("resume run").done();
    assert!(place.surface("run") == sound);
    let json = place.run("verify run --json").done().stdout;
    assert!(json.contains("\"state\": \"sound\"") && !json.contains("broken"), "{json}");
    // Damage to the digests themselves is distinguished from damage to the files.
    let digests = place.path("run/digests.json");
    let text = fs::read_to_string(&digests).unwrap();
    fs::write(&digests, text.replacen("\"files\"", "\"fires\"", 1)).unwrap();
    let verified = place.run("verify run").done();
    assert!(verified.stdout.contains("digests.json: damaged"), "{}", verified.stdout);
    assert_eq!(fs::read_to_string(&digests).unwrap().lines().count(), text.lines().count());
}

#[test]
fn pipes_links_and_directories_in_place_of_files_are_not_waited_for() {
    let boundary = job(
        "map",
        "kind = \"time-domain\"\ndisc = \"rigid\"\nstart = \"rest\"",
        BOTH,
        "samples = 20\nseed = 3\nevaluate = \"boundary\"\naudit = 0",
    );
    let place = Place::new();
    place.write("job.toml", &boundary);
    place.run("submit job.toml --out sound").done();
    let sound = place.surface("sound");
    let tile = files(&place.path("sound/map"), "jsonl").remove(0);
    let piece = files(&place.path("sound/shards"), "jsonl").remove(0);
    let inside = |path: &Path| path.strip_prefix(place.path("sound")).unwrap().to_owned();
    let places = ["job.toml", "run.json", "surface.parquet", "digests.json", "run.lock"].map(PathBuf::from);
    for name in places.into_iter().chain([inside(&tile), inside(&piece)]) {
        for kind in ["pipe", "link", "directory"] {
            let run = place.path("run");
            let _ = fs::remove_dir_all(&run);
            assert!(Command::new("cp").arg("-r").arg(place.path("sound")).arg(&run).status().unwrap().success());
            let path = run.join(&name);
            fs::remove_file(&path).unwrap();
            match kind {
                "pipe" => make_pipe(&path),
                "link" => symlink("/dev/zero", &path).unwrap(),
                _ => fs::create_dir(&path).unwrap(),
            }
            for words in ["status run", "plot run --out p.svg", "verify run", "resume run"] {
                let ended = place.run_unless_it_hangs(words);
                assert!(matches!(ended.code, Some(0 | 65 | 73 | 74)), "{words}, {kind} {}: {ended:?}", name.display());
                assert!(!ended.stderr.contains("panicked"), "{}", ended.stderr);
            }
            if let Ok(now) = fs::read(run.join("surface.parquet"))
                && name != Path::new("surface.parquet")
            {
                assert!(now == sound, "{kind} {}", name.display());
            }
        }
    }
}

#[test]
fn foreign_files_are_left_alone_and_unread() {
    let place = finished();
    let sound = place.surface("run");
    for folder in ["run", "run/shards"] {
        fs::create_dir(place.path(folder).join(".unfinished-1-2")).unwrap();
        fs::write(place.path(folder).join(".DS_Store"), "x").unwrap();
    }
    // Sparse files: three GiB that take no room, unless somebody reads them.
    for name in ["run/shards/copy of a piece.jsonl", "run/shards/0123456789abcdef0123456789abcdef.jsonl"] {
        File::create(place.path(name)).unwrap().set_len(3 << 30).unwrap();
    }
    let status = run_counting_reads(&place, "status run");
    assert!(status.stderr.contains("does not have the name of a piece"), "{}", status.stderr);
    assert!(status.stderr.contains("has more than"), "{}", status.stderr);
    run_counting_reads(&place, "resume run");
    assert!(place.surface("run") == sound);
    assert!(place.path("run/shards/copy of a piece.jsonl").exists());
}

/// A job that takes some seconds on one thread and saves pieces all along.
fn slow(name: &str, seed: u64) -> String {
    job(
        name,
        "kind = \"time-domain\"\ndisc = \"rigid\"\nstart = \"rest\"",
        BOTH,
        &format!("samples = 40000\nseed = {seed}"),
    )
}

fn started(place: &Place, words: &str) -> Child {
    place.command(words).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
}

#[track_caller]
fn ended(child: Child) -> Outcome {
    let output = child.wait_with_output().unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    Outcome { code: output.status.code(), stdout: String::new(), stderr }
}

#[test]
fn a_run_whose_directory_is_moved_or_removed_writes_nothing_under_its_name() {
    let place = Place::new();
    place.write("slow.toml", &slow("slow", 1));
    place.write("other.toml", &surface_job("other", 2, 1000, 2));
    place.run("submit other.toml --out alone").done();
    for (attempt, delay) in [0, 20, 60, 120, 300, 600].into_iter().enumerate() {
        let mut first = started(&place, "submit slow.toml --out run --threads 1");
        wait_for("its job", &mut first, || place.path("run/job.toml").exists());
        thread::sleep(Duration::from_millis(delay));
        if attempt % 2 == 0 {
            fs::rename(place.path("run"), place.path("moved")).unwrap();
        } else {
            // A file may be written meanwhile.
            wait_until("its removal", || fs::remove_dir_all(place.path("run")).is_ok());
        }
        place.run("submit other.toml --out run").done();
        ended(first).refused(74, &["was moved, removed or replaced", "resume the run where it is now"]);
        assert!(place.surface("run") == place.surface("alone"));
        assert!(place.run("verify run").done().stdout.contains("the same bytes as the pieces give"));
        if attempt % 2 == 0 {
            assert!(!place.path("moved/surface.parquet").exists());
            assert!(place.run("status moved").done().stdout.contains("unfinished"));
            fs::remove_dir_all(place.path("moved")).unwrap();
        }
        fs::remove_dir_all(place.path("run")).unwrap();
    }
}

#[test]
fn the_second_runner_learns_who_the_first_is_and_a_killed_one_leaves_no_lock() {
    let place = Place::new();
    place.write("slow.toml", &slow("slow", 1));
    let mut first = started(&place, "submit slow.toml --out run --threads 1");
    wait_for("its job", &mut first, || place.path("run/job.toml").exists());
    let holder = format!("in use by process {} on ", first.id());
    for words in ["resume run", "submit slow.toml --out run", "merge run --wait 0", "verify run"] {
        place.run(words).refused(75, &[&holder, "`stickslip submit slow.toml --out run --threads 1`"]);
    }
    assert!(place.run("status run").done().stdout.contains("running"));
    first.kill().unwrap();
    first.wait().unwrap();
    assert!(place.run("status run").done().stdout.contains("unfinished"));
    place.run("resume run").done();
}

#[test]
fn merge_waits_for_shards_that_are_still_at_work() {
    let place = Place::new();
    // Long enough that the merge says what it waits for.
    place.write("slow.toml", &slow("slow", 1).replace("samples = 40000", "samples = 160000"));
    place.run("submit slow.toml --out whole").done();
    let shards: Vec<Child> =
        (1..=2).map(|i| started(&place, &format!("submit slow.toml --out run --threads 1 --shard {i}/2"))).collect();
    wait_until("its job", || place.path("run/job.toml").exists());
    place.run("merge run --wait 0").refused(75, &["in use by process", "--shard"]);
    let merged = place.run("merge run").done();
    assert!(merged.stderr.contains("waiting up to"), "{}", merged.stderr);
    assert!(place.surface("run") == place.surface("whole"));
    for shard in shards {
        ended(shard).done();
    }
}

#[test]
fn extensions_of_different_size_cannot_both_begin() {
    for attempt in 0..10 {
        let place = finished();
        let children = [("4000", 1), ("6000", 2)].map(|(samples, shard)| {
            started(&place, &format!("submit job.toml --out run --threads 1 --samples {samples} --shard {shard}/2"))
        });
        let outcomes = children.map(ended);
        let done = outcomes.iter().filter(|outcome| outcome.code == Some(0)).count();
        assert!(done == 1, "attempt {attempt}: {outcomes:?}");
        assert!(outcomes.iter().all(|outcome| matches!(outcome.code, Some(0 | 65 | 73))), "{outcomes:?}");
        place.run("resume run").done();
        let whole = if outcomes[0].code == Some(0) { "4000" } else { "6000" };
        place.run(&format!("submit job.toml --out whole --samples {whole}")).done();
        assert!(place.surface("run") == place.surface("whole"));
    }
}

#[test]
fn results_have_the_rights_that_the_umask_leaves() {
    let place = finished();
    fs::create_dir(place.path("shared")).unwrap();
    fs::set_permissions(place.path("shared"), fs::Permissions::from_mode(0o777)).unwrap();
    let line = format!(
        "umask 022; {0} submit job.toml --out shared/run && {0} plot shared/run --out shared/plot.svg",
        env!("CARGO_BIN_EXE_stickslip")
    );
    let mut shell = place.command("");
    shell = {
        let mut command = Command::new("sh");
        command.args(["-c", &line]).current_dir(shell.get_current_dir().unwrap());
        command
    };
    crate::common::assert_succeeds(&mut shell);
    for name in ["run/job.toml", "run/surface.parquet", "run/run.json", "run/run.lock", "run/digests.json", "plot.svg"]
    {
        let mode = fs::metadata(place.path("shared").join(name)).unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o644, "{name}");
    }
}

#[test]
fn a_file_system_that_cannot_be_written_is_refused_before_anything_is_computed() {
    let place = Place::new();
    place.write("slow.toml", &slow("slow", 1));
    place.write("file", "");
    for out in ["file", "file/run", "/proc/run"] {
        let refused = place.run(&format!("submit slow.toml --out {out}")).refused(73, &[out]);
        assert!(!refused.stderr.contains("samples in"), "{}", refused.stderr);
    }
}
