//! `submit --engine`: the scripts for Slurm and GNU parallel, run here by stand-ins for their programs. `make test-slurm`
//! and `make test-parallel` run them on the real ones.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so and stop")]

use std::fs;
use std::os::unix::fs::{PermissionsExt as _, symlink};
use std::process::{Child, Command, Stdio};

use crate::common::{BOTH, EIGENVALUE, Outcome, Place, job, send, wait_until};

/// Takes the place of `sbatch`: notes its arguments in a line, with those of several lines quoted, and counts jobs.
const SBATCH: &str = r#"#!/bin/bash
if [ "$1" = --version ]; then echo "slurm 22.05.8"; exit; fi
printf '%q ' "$@" >> "$RECORD"
echo >> "$RECORD"
echo "$((100 + $(wc -l < "$RECORD")));here"
"#;

/// Takes the place of `scontrol`.
const SCONTROL: &str = r#"#!/bin/bash
case "$1" in
    show)
        if [ "$2" = config ]; then echo "MaxArraySize            = 21"; else echo "JobState=${JOB_STATE:-COMPLETED}"; fi ;;
    *) echo "scontrol $*" >> "$RECORD" ;;
esac
"#;

/// A place where Slurm seems to be installed.
fn cluster() -> Place {
    let place = Place::new();
    fs::create_dir(place.path("bin")).unwrap();
    for (name, text) in [("sbatch", SBATCH), ("scontrol", SCONTROL)] {
        let path = place.write(&format!("bin/{name}"), text);
        fs::set_permissions(path, fs::Permissions::from_mode(0o755)).unwrap();
    }
    let path = format!("{}:{}", place.path("bin").display(), std::env::var("PATH").unwrap());
    let record = place.path("record").display().to_string();
    place.with_environment("PATH", &path).with_environment("RECORD", &record)
}

fn record(place: &Place) -> Vec<String> {
    fs::read_to_string(place.path("record")).unwrap_or_default().lines().map(str::to_owned).collect()
}

/// Runs stickslip with these words and a last one that may have anything in it.
fn run_with(place: &Place, words: &str, last: &str) -> Outcome {
    ended(place.command(words).arg(last))
}

fn ended(command: &mut Command) -> Outcome {
    let output = command.output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    Outcome { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
}

/// A script of a run, as Slurm starts it.
fn script(place: &Place, run: &str, name: &str, task: u64) -> Command {
    let mut shell = Command::new("sh");
    shell.arg(place.path(run).join("slurm").join(name)).current_dir(place.path("")).stdin(Stdio::null());
    // The environment of the place is that of its commands.
    for (key, value) in place.command("").get_envs() {
        shell.env(key, value.unwrap());
    }
    shell.env("SLURM_ARRAY_TASK_ID", task.to_string()).env("SLURM_ARRAY_JOB_ID", "77").env("SLURM_CPUS_PER_TASK", "1");
    shell
}

/// The parts of what `--dry-run` prints, by the name of the script.
fn scripts(printed: &str) -> Vec<(&str, &str)> {
    let mut found = Vec::new();
    for part in printed.split("\n\n# ") {
        let (path, text) = part.trim_start_matches("# ").split_once('\n').unwrap();
        found.push((path.trim_end_matches('\'').rsplit('/').next().unwrap(), text));
    }
    found
}

const SLOW: &str = "kind = \"time-domain\"\ndisc = \"rigid\"";

#[test]
fn the_scripts_are_shown_and_nothing_is_written() {
    let place = Place::new();
    let engine = "[engine]\npartition = \"short\"\naccount = \"brakes\"\ntime = \"5\"\nsbatch = [\"--qos=low\"]\n";
    place.write("job.toml", &(job("shown", EIGENVALUE, BOTH, "samples = 1000") + engine));
    let before = fs::read_dir(place.path("")).unwrap().count();
    let words = "submit job.toml --engine slurm --dry-run --shards 7 --partition long --memory 2G --threads 3 --sbatch=--constraint=avx2";
    let shown = place.run(words).done().stdout;
    assert_eq!(fs::read_dir(place.path("")).unwrap().count(), before);
    let scripts = scripts(&shown);
    assert_eq!(scripts.iter().map(|(name, _)| *name).collect::<Vec<_>>(), ["submit.sh", "shard.sh", "merge.sh"]);
    let run = place.path("").canonicalize().unwrap().join("runs/shown");
    let [submit, shard, merge] = [0, 1, 2].map(|index: usize| scripts[index].1);
    assert!(submit.contains("tasks=${1:-1-7}\n"), "{submit}");
    assert!(submit.contains("--dependency=\"afterany:$shards\" \"$run/slurm/merge.sh\""), "{submit}");
    let header = "#!/bin/sh
#SBATCH --job-name=stickslip-shown-shard
#SBATCH --partition=long
#SBATCH --account=brakes
#SBATCH --time=5
#SBATCH --mem=2G
#SBATCH --cpus-per-task=3
#SBATCH --output=slurm/shard-%a.log
#SBATCH --open-mode=append
#SBATCH --requeue
#SBATCH --signal=B:USR1@30
#SBATCH --qos=low
#SBATCH --constraint=avx2
#";
    assert!(shard.starts_with(header), "{shard}");
    assert!(shard.contains(&format!("\nrun={}\n", run.display())), "{shard}");
    let command = "\"$stickslip\" submit \"$run/job.toml\" --out \"$run\" --shard \"$SLURM_ARRAY_TASK_ID/7\" --threads \"$SLURM_CPUS_PER_TASK\" &\n";
    assert!(shard.contains(command), "{shard}");
    assert!(merge.contains("#SBATCH --cpus-per-task=1\n") && !merge.contains("--signal"), "{merge}");
}

#[test]
fn a_verdict_map_is_a_stage_of_its_own() {
    let place = cluster();
    let sampling = "samples = 1000\nevaluate = \"boundary\"";
    place.write("job.toml", &job("mapped", SLOW, BOTH, sampling));
    let shown = place.run("submit job.toml --engine slurm --dry-run --shards 3").done().stdout;
    let scripts = scripts(&shown);
    assert_eq!(
        scripts.iter().map(|(name, _)| *name).collect::<Vec<_>>(),
        ["submit.sh", "map.sh", "shard.sh", "merge.sh"]
    );
    assert!(scripts[1].1.contains(" --threads \"$SLURM_CPUS_PER_TASK\" --map-only &\n"), "{shown}");
    assert!(!scripts[2].1.contains("--map-only"), "{shown}");
    assert_eq!(place.run("submit job.toml --engine slurm --shards 3").done().stdout, "101 102 103\n");
    let sent = record(&place);
    assert!(sent[0].contains("--array=1-") && sent[0].trim_end().ends_with("slurm/map.sh"), "{sent:?}");
    assert!(sent[1].contains("--array=1-3 --dependency=afterany:101 "), "{sent:?}");
    assert!(sent[2].contains("--dependency=afterany:102 "), "{sent:?}");
    place.write("hosts", ":\n");
    let shown = place.run("submit job.toml --engine parallel --dry-run --shards 3 --hosts hosts").done().stdout;
    assert!(shown.contains("\nmap_shards=") && !shown.contains("\nmap_shards=\n"), "{shown}");
    let map = shown.find("then on_all map ").unwrap();
    assert!(map < shown.find("\non_all shard \"$@\"").unwrap(), "{shown}");
}

#[test]
fn a_run_through_the_scripts_is_that_of_one_process_whatever_its_path() {
    let place = cluster();
    let engine = "[engine]\nshards = 50\n";
    place.write("job.toml", &(job("odd", EIGENVALUE, BOTH, "samples = 30_000") + engine));
    place.write("plain.toml", &job("odd", EIGENVALUE, BOTH, "samples = 30_000"));
    place.run("submit plain.toml --out whole").done();
    for run in ["-it's $(touch hacked) \"a\" {}\nrun;", "plain"] {
        let _ = fs::remove_file(place.path("record"));
        let submitted = run_with(&place, "submit job.toml --engine slurm --shards 3 --out", &format!("./{run}")).done();
        assert_eq!(submitted.stdout, "101 102\n", "{}", submitted.stderr);
        let sent = record(&place);
        assert_eq!(sent.len(), 2, "{sent:?}");
        assert!(sent[0].contains("--array=1-3 ") && sent[1].contains("--dependency=afterany:101 "), "{sent:?}");
        assert!(sent[1].trim_end().ends_with(" 1 101"), "{sent:?}");
        for name in ["submit.sh", "shard.sh", "merge.sh"] {
            let path = place.path(run).join("slurm").join(name);
            assert!(Command::new("sh").arg("-n").arg(path).status().unwrap().success(), "{name}");
        }
        let status = run_with(&place, "status", &format!("./{run}")).done().stdout;
        assert!(status.contains("shards: 0 of 3 done; missing: 1-3\n"), "{status}");
        for task in 1..=3 {
            ended(&mut script(&place, run, "shard.sh", task)).done();
        }
        ended(script(&place, run, "merge.sh", 0).args(["1", "101"])).done();
        assert!(place.surface(run) == place.surface("whole"), "{run:?}");
        assert!(!place.path("hacked").exists());
    }
    // A run that is finished gets its surface again, and no jobs.
    fs::remove_file(place.path("plain/surface.parquet")).unwrap();
    place.run("submit job.toml --engine slurm --shards 3 --out plain").done();
    assert!(place.surface("plain") == place.surface("whole"));
    assert_eq!(record(&place).len(), 2);
}

/// A task under way, its program at work.
fn task_under_way(place: &Place) -> Child {
    place.write("slow.toml", &job("slow", SLOW, BOTH, "samples = 1_000_000"));
    place.run("submit slow.toml --engine slurm --shards 2 --out slow").done();
    let mut task = script(place, "slow", "shard.sh", 1);
    let task = task.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    wait_until("a shard at work", || place.run("status slow").done().stdout.contains("; at work: 1;"));
    task
}

#[test]
fn a_task_is_put_into_the_queue_again_at_its_time_limit_and_not_when_it_is_cancelled() {
    let place = cluster();
    for (name, requeued) in [("USR1", true), ("TERM", false)] {
        let mut task = task_under_way(&place);
        let _ = fs::remove_file(place.path("record"));
        send(&task, name);
        assert_eq!(task.wait().unwrap().code(), Some(143), "{name}");
        let expected = if requeued { vec!["scontrol requeue 77_1".to_owned()] } else { Vec::new() };
        assert_eq!(record(&place), expected, "{name}");
        let status = place.run("status slow").done().stdout;
        assert!(status.contains("shards: 0 of 2 done; missing: 1-2\n"), "{status}");
    }
}

#[test]
fn a_merge_submits_missing_shards_a_few_times() {
    let place = cluster();
    place.write("job.toml", &job("gaps", EIGENVALUE, BOTH, "samples = 1000"));
    place.run("submit job.toml --engine slurm --shards 6 --out gaps").done();
    for task in [2, 3, 6] {
        ended(&mut script(&place, "gaps", "shard.sh", task)).done();
    }
    let merge = |round: &str, state: &str| {
        let _ = fs::remove_file(place.path("record"));
        ended(script(&place, "gaps", "merge.sh", 0).args([round, "101"]).env("JOB_STATE", state))
    };
    let again = merge("1", "FAILED").done();
    assert!(again.stderr.contains("Of 6 shards, these are missing: 1,4-5."), "{}", again.stderr);
    assert!(again.stdout.contains("submitting shards 1,4-5 again"), "{}", again.stdout);
    let sent = record(&place);
    assert!(sent[0].contains("--array=1\\,4-5 ") || sent[0].contains("--array=1,4-5 "), "{sent:?}");
    assert!(sent[1].trim_end().ends_with(" 2 101"), "{sent:?}");
    for (round, state, why) in [("3", "FAILED", "this was round 3"), ("1", "CANCELLED", "tasks were cancelled")] {
        let left = merge(round, state);
        assert_eq!((left.code, record(&place).len()), (Some(65), 0), "{}", left.stderr);
        assert!(left.stdout.contains(&format!("shards 1,4-5 are missing, and {why}")), "{}", left.stdout);
        assert!(left.stdout.contains("gaps/slurm/submit.sh 1,4-5\n"), "{}", left.stdout);
    }
    // Submitting once more takes what is missing, in as many shards as before.
    let _ = fs::remove_file(place.path("record"));
    place.run("submit job.toml --engine slurm --out gaps").done();
    assert!(record(&place)[0].contains("4-5"), "{:?}", record(&place));
    assert_eq!(place.run("status gaps --missing").done().stdout, "1\n4\n5\n");
    assert_eq!(place.run("status gaps --missing --format slurm").done().stdout, "1,4-5\n");
}

#[test]
fn a_task_of_an_array_finds_its_shard() {
    let place = Place::new();
    place.write("job.toml", &job("array", EIGENVALUE, BOTH, "samples = 1000"));
    let task = |id: &str, count: &str, first: &str, last: &str| {
        let mut command = place.command("submit job.toml --out array --shard slurm");
        command.env("SLURM_ARRAY_TASK_ID", id).env("SLURM_ARRAY_TASK_COUNT", count);
        ended(command.env("SLURM_ARRAY_TASK_MIN", first).env("SLURM_ARRAY_TASK_MAX", last))
    };
    let first = task("1", "3", "1", "3").done();
    let said = "--shard slurm: shard 1/3, from task 1 of an array of 3, numbered 1 to 3";
    assert!(first.stderr.contains(said), "{}", first.stderr);
    task("3", "2", "2", "3").refused(64, &["numbered 2 to 3", "--shard \"$SLURM_ARRAY_TASK_ID/16\""]);
    // An array of the first tasks only looks like a whole one.
    task("2", "2", "1", "2").refused(64, &["this array has 2 tasks", "3 shards", "\"$SLURM_ARRAY_TASK_ID/3\""]);
    place.run("submit job.toml --out other --shard slurm").refused(64, &["SLURM_ARRAY_TASK_ID is not set"]);
    assert!(!place.path("other").exists());
    let status = place.run("status array").done().stdout;
    assert!(status.contains("shards: 1 of 3 done; missing: 2-3\n"), "{status}");
    place.run("merge array").refused(65, &["Of 3 shards, these are missing: 2-3. Submit them, or compute"]);
    for id in ["2", "3"] {
        task(id, "3", "1", "3").done();
    }
    place.run("merge array").done();
}

#[test]
fn what_cannot_be_is_refused_before_anything_is_written() {
    let place = cluster();
    place.write("job.toml", &job("no", EIGENVALUE, BOTH, "samples = 1000"));
    place.write("exact.toml", &job("no", EIGENVALUE, BOTH, "method = \"exact\""));
    place.write("hosts", "# nobody\n\n");
    for (words, texts) in [
        ("job.toml --engine slurm --shards 21", vec!["20 tasks that this cluster allows", "--shards 20"]),
        ("job.toml --engine slurm --hosts hosts", vec!["--hosts does nothing with --engine slurm"]),
        ("job.toml --engine parallel --hosts hosts --time 5", vec!["--time does nothing with --engine parallel"]),
        ("job.toml --engine parallel", vec!["needs --hosts FILE"]),
        ("job.toml --engine parallel --hosts hosts", vec!["there is no machine in it"]),
        ("job.toml --engine slurm --time soon", vec!["\"soon\" is not a valid Slurm time limit of one minute or more"]),
        ("job.toml --engine slurm --partition a;b", vec!["\"a;b\" is not a valid Slurm name: use"]),
        ("job.toml --engine slurm --sbatch constraint=a", vec!["is no option of sbatch"]),
        ("job.toml --engine slurm --shard 1/2", vec!["cannot be used with"]),
        ("job.toml --partition main", vec!["--engine"]),
        ("exact.toml --engine slurm", vec!["draws no samples to share"]),
    ] {
        place.run(&format!("submit {words}")).refused(64, &texts);
    }
    assert!(!place.path("runs").exists() && record(&place).is_empty());
    // Wrong values in the job are reported with their line.
    let text = job("no", EIGENVALUE, BOTH, "samples = 1000");
    for (line, text_of_it) in [
        ("partition = \"a b\"", "engine.partition: \"a b\" is not a valid Slurm name: use"),
        ("time = \"1:2:3:4\"", "engine.time: \"1:2:3:4\" is not a valid Slurm time limit"),
        ("sbatch = [\"--a\\n--b\"]", "is no option of sbatch"),
        ("shards = 0", "engine.shards = 0 must be from 1 to 1000000"),
        ("nodes = 4", "unknown key `nodes` in [engine]"),
    ] {
        place.write("wrong.toml", &format!("{text}[engine]\n{line}\n"));
        place.run("check wrong.toml").refused(65, &["wrong.toml:", text_of_it]);
    }
}

#[test]
fn options_of_sbatch_in_a_job_ask_for_resources_alone() {
    let place = cluster();
    let text = job("asked", EIGENVALUE, BOTH, "samples = 1000");
    for option in ["--output=/root/.bashrc", "--export=ALL,LD_PRELOAD=/tmp/x.so", "--chdir=/", "--qos=low -o x"] {
        place.write("job.toml", &format!("{text}[engine]\nsbatch = [\"--qos=low\", \"{option}\"]\n"));
        let on_the_command_line = format!("give it on the command line: --sbatch='{option}'");
        let said = [
            "job.toml:18:",
            &format!("engine.sbatch: {option:?} is not for a job"),
            "one of --account (-A), ",
            &on_the_command_line,
        ];
        for words in ["check job.toml", "submit job.toml --engine slurm --dry-run", "submit job.toml --engine slurm"] {
            place.run(words).refused(65, &said);
        }
        // It does not keep a process from computing the run.
        place.run("submit job.toml --out alone").done();
        fs::remove_file(place.path("alone/surface.parquet")).unwrap();
        place.run("resume alone").done();
        fs::remove_dir_all(place.path("alone")).unwrap();
        // What the message says to do.
        place.write("job.toml", &format!("{text}[engine]\nsbatch = [\"--qos=low\"]\n"));
        let shown =
            run_with(&place, "submit job.toml --engine slurm --shards 2 --dry-run", &format!("--sbatch={option}"));
        assert!(shown.done().stdout.contains(&format!("#SBATCH --qos=low\n#SBATCH {option}\n")));
    }
    assert!(!place.path("runs").exists() && record(&place).is_empty());
}

#[test]
fn links_in_a_run_of_somebody_else_lead_nowhere() {
    let place = cluster();
    place.write("job.toml", &job("foreign", EIGENVALUE, BOTH, "samples = 1000"));
    place.run("submit job.toml --out run --shard 1/3").done();
    fs::create_dir(place.path("mine")).unwrap();
    place.write("mine/submit.sh", "precious");
    place.write("hosts", ":\n");
    let parallel = place.write("bin/parallel", "#!/bin/sh\necho GNU parallel\n");
    fs::set_permissions(parallel, fs::Permissions::from_mode(0o755)).unwrap();
    for (engine, words) in [("slurm", "--engine slurm"), ("parallel", "--engine parallel --hosts hosts")] {
        let submit = format!("submit job.toml --out run --shards 3 {words}");
        symlink(place.path("mine"), place.path("run").join(engine)).unwrap();
        place
            .run(&submit)
            .refused(74, &[&format!("run/{engine}: it is no directory of its own, but a file or a link")]);
        fs::remove_file(place.path("run").join(engine)).unwrap();
        // Slurm and GNU parallel would follow a link in the place of a log.
        fs::create_dir(place.path("run").join(engine)).unwrap();
        let log = place.path("run").join(engine).join("shard-2.log");
        symlink(place.path("mine/submit.sh"), &log).unwrap();
        place
            .run(&submit)
            .refused(73, &[&format!("run/{engine}: shard-2.log in it is not an ordinary file; remove it")]);
        fs::remove_file(log).unwrap();
    }
    assert_eq!(fs::read_dir(place.path("mine")).unwrap().count(), 1);
    assert_eq!(fs::read_to_string(place.path("mine/submit.sh")).unwrap(), "precious");
    assert!(record(&place).is_empty());
    assert_eq!(place.run("submit job.toml --out run --shards 3 --engine slurm").done().stdout, "101 102\n");
}

#[test]
fn no_message_names_a_script_that_a_run_came_with() {
    let place = cluster();
    place.write("job.toml", &job("foreign", EIGENVALUE, BOTH, "samples = 1000"));
    place.run("submit job.toml --out run --shards 3 --engine slurm").done();
    let script = place.write("run/slurm/submit.sh", "touch hacked\n");
    let status = place.run("status run").done().stdout;
    let merge = place.run("merge run").refused(65, &[]).stderr;
    for said in [&status, &merge] {
        assert!(!said.contains("submit.sh"), "{said}");
        assert!(
            said.contains("`stickslip submit run/job.toml --out run --engine slurm` and the options of before"),
            "{said}"
        );
    }
    // The command writes the scripts again.
    fs::remove_file(place.path("record")).unwrap();
    assert_eq!(place.run("submit run/job.toml --out run --engine slurm").done().stdout, "101 102\n");
    assert!(record(&place)[0].contains("--array=1-3 ") && !place.path("hacked").exists());
    assert!(fs::read_to_string(script).unwrap().contains("sbatch --parsable"));
}

#[test]
fn without_its_program_an_engine_is_refused() {
    let place = Place::new().with_environment("PATH", "/nowhere");
    place.write("job.toml", &job("no", EIGENVALUE, BOTH, "samples = 1000"));
    place.write("hosts", ":\n");
    place.run("submit job.toml --engine slurm --shards 2").refused(74, &["cannot run sbatch", "--dry-run"]);
    place.run("submit job.toml --engine parallel --shards 2 --hosts hosts").refused(74, &["cannot run parallel"]);
    assert!(!place.path("runs").exists());
}

#[test]
fn shards_are_sized_by_what_they_cost() {
    let place = Place::new();
    place.write("cheap.toml", &job("cheap", EIGENVALUE, BOTH, "samples = 1000"));
    let cheap = place.run("submit cheap.toml --engine slurm --dry-run").done();
    assert!(cheap.stderr.contains("1 shard of about") && cheap.stdout.contains("tasks=${1:-1-1}"), "{}", cheap.stderr);
    place.write("dear.toml", &job("dear", SLOW, BOTH, "samples = 1_000_000_000_000"));
    let dear = place.run("submit dear.toml --engine slurm --dry-run --max-shards 400").done();
    assert!(
        dear.stderr.contains("400 shards of about") && dear.stdout.contains("tasks=${1:-1-400}"),
        "{}",
        dear.stderr
    );
}

#[test]
fn a_time_limit_that_is_too_short_is_warned_of() {
    let place = Place::new();
    place.write("job.toml", &job("long", SLOW, BOTH, "samples = 1_000_000_000_000"));
    place.write("cheap.toml", &job("cheap", EIGENVALUE, BOTH, "samples = 1000"));
    let said = |words: &str| place.run(&format!("submit {words} --engine slurm --dry-run")).done().stderr;
    for shards in ["--max-shards 7", "--shards 7"] {
        let warned = said(&format!("job.toml --time 1 {shards}"));
        let parts = [
            "warning: a shard takes about ",
            ", but its task runs for about 1.5 hours at most (--time 1, with 100 restarts)",
            "Ask for more time (--time ",
        ];
        for part in parts {
            assert!(warned.contains(part), "{part:?} is not in: {warned}");
        }
    }
    place.write("day.toml", &job("day", SLOW, BOTH, "samples = 300_000_000"));
    let warned = said("day.toml --time 1 --shards 1");
    assert!(warned.contains(", or for at least "), "{warned}");
    let enough = said("job.toml --time 999999-0 --shards 1000");
    assert!(!enough.contains("warning"), "{enough}");
    let cheap = said("cheap.toml --time 1 --shards 7");
    assert!(!cheap.contains("warning"), "{cheap}");
}

#[test]
fn a_slurm_that_is_not_configured_is_quoted() {
    let place = cluster();
    place.write("job.toml", &job("no", EIGENVALUE, BOTH, "samples = 1000"));
    let fails = "#!/bin/sh\necho 'sbatch: error: resolve_ctls_from_dns_srv: Unknown host' >&2\nexit 1\n";
    fs::write(place.path("bin/sbatch"), fails).unwrap();
    let texts = ["does not name slurm", "exit status: 1", "resolve_ctls_from_dns_srv: Unknown host", "--dry-run"];
    place.run("submit job.toml --engine slurm --shards 2").refused(74, &texts);
    fs::write(place.path("bin/sbatch"), "#!/bin/sh\n").unwrap();
    place
        .run("submit job.toml --engine slurm --shards 2")
        .refused(74, &["exit status: 0", "nothing on standard error"]);
    assert!(!place.path("runs").exists());
}

#[test]
fn shards_without_work_are_distinguished() {
    let place = Place::new();
    place.write("job.toml", &job("few", EIGENVALUE, BOTH, "samples = 1000"));
    place.run("submit job.toml --out few --shard 1/1000").done();
    let status = place.run("status few --shards 1000").done().stdout;
    let json: serde_json::Value =
        serde_json::from_str(&place.run("status few --shards 1000 --json").done().stdout).unwrap();
    let [empty, done] = [
        json["shards"]["nothing_to_compute"].as_u64().unwrap(),
        json["shards"]["done"].as_array().unwrap().len() as u64,
    ];
    assert!(empty > 900 && done == empty + 1, "{json:#}");
    let line = format!("shards: {done} of 1000 done, {empty} of which have nothing to compute; missing: 2-");
    assert!(status.contains(&line), "{status}");
    // Without a note of the number of shards, the merge says how to list what is missing.
    let how = "of N shards, `stickslip status few --shards N --missing` lists them, or compute what is missing here";
    place.run("merge few").refused(65, &[how]);
}

#[test]
fn machines_are_read_from_what_ends() {
    let place = Place::new();
    place.write("job.toml", &job("no", EIGENVALUE, BOTH, "samples = 1000"));
    assert!(Command::new("mkfifo").arg(place.path("pipe")).status().unwrap().success());
    for (hosts, what) in [("pipe", "a pipe or a device"), ("/dev/zero", "a pipe or a device"), (".", "a directory")] {
        let words = format!("submit job.toml --engine parallel --hosts {hosts}");
        place.run(&words).refused(64, &[&format!("--hosts {hosts}: it is {what}"), "name an ordinary file"]);
    }
    place.run("submit job.toml --engine parallel --hosts gone").refused(74, &["cannot read gone"]);
}
