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
    show) echo "JobState=${JOB_STATE:-COMPLETED}" ;;
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

/// The script of a run, as Slurm starts it for a step.
fn script(place: &Place, run: &str, step: &str, task: u64) -> Command {
    let mut shell = Command::new("sh");
    shell.arg(place.path(run).join("slurm/run.sh")).arg(step).current_dir(place.path("")).stdin(Stdio::null());
    // The environment of the place is that of its commands.
    for (key, value) in place.command("").get_envs() {
        shell.env(key, value.unwrap());
    }
    shell.env("SLURM_ARRAY_TASK_ID", task.to_string()).env("SLURM_ARRAY_JOB_ID", "77").env("SLURM_CPUS_PER_TASK", "1");
    shell
}

const SLOW: &str = "kind = \"time-domain\"\ndisc = \"rigid\"";

#[test]
fn slurm_is_asked_for_what_the_user_asks_for() {
    let place = cluster();
    place.write("job.toml", &job("asked", EIGENVALUE, BOTH, "samples = 1000"));
    let words = "submit job.toml --engine slurm --shards 7 --threads 3 -- --partition=long --time 2:00:00";
    assert_eq!(run_with(&place, words, "--comment=it's \"long\" $(id)").done().stdout, "101 102\n");
    let [array, merge] = &record(&place)[..] else { panic!("{:?}", record(&place)) };
    let run = place.path("").canonicalize().unwrap().join("runs/asked");
    let script = format!("{}/slurm/run.sh", run.display());
    let of_all = |step: &str, own: &str, words: &str| {
        format!(
            "--job-name=stickslip-asked-{step} --open-mode=append --requeue --cpus-per-task=3 --signal=B:USR1@60 \
             --partition=long --time 2:00:00 --comment=it\\'s\\ \\\"long\\\"\\ \\$\\(id\\) --parsable --chdir={} {own} \
             {script} {words} ",
            run.display()
        )
    };
    let own = "--array=1-7 --output=slurm/shard-%a.log";
    assert_eq!(array, &of_all("shard", own, "shard"));
    assert_eq!(merge, &of_all("merge", "--output=slurm/merge.log --dependency=afterany:101", "merge 1 101"));
}

#[test]
fn a_verdict_map_is_a_stage_of_its_own() {
    let place = cluster();
    place.write("job.toml", &job("mapped", SLOW, BOTH, "samples = 1000\nevaluate = \"boundary\""));
    assert_eq!(place.run("submit job.toml --engine slurm --shards 3").done().stdout, "101 102 103\n");
    let sent = record(&place);
    assert!(sent[0].contains("--array=1-3 ") && sent[0].ends_with("slurm/run.sh map "), "{sent:?}");
    assert!(sent[1].contains("--array=1-3 ") && sent[1].contains("--dependency=afterany:101 "), "{sent:?}");
    assert!(sent[2].contains("--dependency=afterany:102 "), "{sent:?}");
    ended(&mut script(&place, "runs/mapped", "map", 2)).done();
    assert!(place.pieces("runs/mapped/map") > 0 && place.pieces("runs/mapped/shards") == 0);
}

#[test]
fn a_run_through_the_script_is_that_of_one_process_whatever_its_path() {
    let place = cluster();
    place.write("job.toml", &job("odd", EIGENVALUE, BOTH, "samples = 30_000"));
    place.run("submit job.toml --out whole").done();
    for run in ["-it's $(touch hacked) \"a\" {}\nrun;", "plain"] {
        let _ = fs::remove_file(place.path("record"));
        let submitted = run_with(&place, "submit job.toml --engine slurm --shards 3 --out", &format!("./{run}")).done();
        assert_eq!(submitted.stdout, "101 102\n", "{}", submitted.stderr);
        assert_eq!(record(&place).len(), 2, "{:?}", record(&place));
        for task in 1..=3 {
            ended(&mut script(&place, run, "shard", task)).done();
        }
        ended(script(&place, run, "merge", 0).args(["1", "101"])).done();
        assert!(place.surface(run) == place.surface("whole"), "{run:?}");
        assert!(!place.path("hacked").exists());
    }
    // A run that is finished gets its surface again, and no jobs.
    fs::remove_file(place.path("plain/surface.parquet")).unwrap();
    place.run("submit job.toml --engine slurm --shards 3 --out plain").done();
    assert!(place.surface("plain") == place.surface("whole"));
    assert_eq!(record(&place).len(), 2);
}

/// Takes the place of GNU parallel: runs one shard after the other here.
const PARALLEL: &str = r#"#!/bin/bash
if [ "$1" = --version ]; then echo "GNU parallel 20221122"; exit; fi
while read -r shard; do sh "${@: -5:1}" "${@: -3:1}" "$shard" </dev/null || exit; done
"#;

#[test]
fn what_is_asked_for_is_answered_by_the_merge() {
    let place = cluster();
    let parallel = place.write("bin/parallel", PARALLEL);
    fs::set_permissions(parallel, fs::Permissions::from_mode(0o755)).unwrap();
    place.write("hosts", ":\n");
    place.write("job.toml", &job("asked", EIGENVALUE, BOTH, "samples = 1000"));
    let asked = "--target 0.03 --at preload=0.1 --at static_friction=0.28";
    let alone = place.run(&format!("submit job.toml --out alone {asked}")).done().stdout.replace('\n', " ");
    let answer = alone.split_once("At 15 rad/s, ").and_then(|(_, rest)| rest.split_once(" Target: ")).unwrap().0;
    assert!(answer.starts_with("preload = 0.1, static friction = 0.28: P, ") && answer.contains(" < 3 %"), "{answer}");
    let says_it = |said: Outcome| {
        let said = said.done().stdout.replace('\n', " ");
        assert!(said.contains(answer), "{answer}\n{said}");
    };

    place.run(&format!("submit job.toml --out array --engine slurm --shards 2 {asked}")).done();
    let incomplete = place.run(&format!("merge array {asked}"));
    incomplete.refused(65, &[&format!("what is missing here with `stickslip resume array {asked}`")]);
    for task in [1, 2] {
        ended(&mut script(&place, "array", "shard", task)).done();
    }
    says_it(ended(script(&place, "array", "merge", 0).args(["1", "101"])));
    let over_ssh = format!("submit job.toml --out shared --engine parallel --hosts hosts --shards 2 {asked}");
    says_it(place.run(&over_ssh));
    // The same of what is finished.
    says_it(place.run(&over_ssh));
    for command in ["merge", "resume"] {
        says_it(place.run(&format!("{command} shared {asked}")));
    }

    for (option, why) in [
        (
            "--target 0.03",
            "--target 0.03: with --shard there is no result yet that could answer it; give it to `stickslip merge`",
        ),
        ("--at preload=0.1 --at static_friction=0.28", "--at preload=0.1: with --shard there is no result"),
    ] {
        place.run(&format!("submit job.toml --out part --shard 1/2 {option}")).refused(64, &[why]);
    }
    place.write("mapped.toml", &job("mapped", SLOW, BOTH, "samples = 1000\nevaluate = \"boundary\""));
    place
        .run("submit mapped.toml --out part --map-only --target 0.03")
        .refused(64, &["--target 0.03: with --map-only there is no result", "the command that computes the samples"]);
    for command in ["merge shared", "resume shared", "submit job.toml --out part --engine slurm --shards 2"] {
        place
            .run(&format!("{command} --at preload=0.1 --at preload=0.05"))
            .refused(64, &["--at: preload is given twice, as 0.1 and as 0.05; give one value of each axis"]);
    }
    assert!(!place.path("part").exists());
}

/// A task under way, its program at work.
fn task_under_way(place: &Place) -> Child {
    place.write("slow.toml", &job("slow", SLOW, BOTH, "samples = 1_000_000"));
    place.run("submit slow.toml --engine slurm --shards 2 --out slow").done();
    let pieces = place.pieces("slow/shards");
    let mut task = script(place, "slow", "shard", 1);
    let task = task.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    wait_until("a piece of the shard", || place.pieces("slow/shards") > pieces);
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
        assert!(place.run("status slow").done().stdout.contains("slow: unfinished, "));
    }
}

#[test]
fn a_merge_submits_the_shards_again_a_few_times() {
    let place = cluster();
    place.write("job.toml", &job("gaps", EIGENVALUE, BOTH, "samples = 1000"));
    place.run("submit job.toml --engine slurm --shards 6 --out gaps").done();
    for task in [2, 3, 6] {
        ended(&mut script(&place, "gaps", "shard", task)).done();
    }
    let merge = |round: &str, state: &str| {
        let _ = fs::remove_file(place.path("record"));
        ended(script(&place, "gaps", "merge", 0).args([round, "101"]).env("JOB_STATE", state))
    };
    let again = merge("1", "FAILED").done();
    assert!(again.stderr.contains("Submit every shard again"), "{}", again.stderr);
    assert!(again.stdout.contains("submitting the shards again"), "{}", again.stdout);
    let sent = record(&place);
    assert!(sent[0].contains("--array=1-6 ") && sent[1].ends_with(" merge 2 101 "), "{sent:?}");
    for (round, state, why) in [("3", "FAILED", "this was round 3"), ("1", "CANCELLED", "tasks were cancelled")] {
        let left = merge(round, state);
        assert_eq!((left.code, record(&place).len()), (Some(65), 0), "{}", left.stderr);
        assert!(
            left.stdout.contains(&format!("samples are missing, and {why}; submit the job again")),
            "{}",
            left.stdout
        );
    }
    // A shard that is finished computes nothing.
    let pieces = place.pieces("gaps/shards");
    ended(&mut script(&place, "gaps", "shard", 2)).done();
    assert_eq!(place.pieces("gaps/shards"), pieces);
    for task in [1, 4, 5] {
        ended(&mut script(&place, "gaps", "shard", task)).done();
    }
    merge("2", "COMPLETED").done();
    assert!(record(&place).is_empty(), "nothing is missing, and {:?} was submitted", record(&place));
    place.run("verify gaps").done();
}

#[test]
fn what_cannot_be_is_refused_before_anything_is_written() {
    let place = cluster();
    place.write("job.toml", &job("no", EIGENVALUE, BOTH, "samples = 1000"));
    place.write("exact.toml", &job("no", EIGENVALUE, BOTH, "method = \"exact\""));
    place.write("hosts", "# nobody\n\n");
    for (words, texts) in [
        ("job.toml --engine slurm --shards 2 --hosts hosts", vec!["--hosts does nothing with --engine slurm"]),
        ("job.toml --engine parallel --shards 2 --hosts hosts -- --time=5", vec!["options of sbatch do nothing"]),
        (
            "job.toml --engine slurm --shards 2 -- -p main --array=1-60%10",
            vec!["--array: `--engine slurm` sets this option"],
        ),
        ("job.toml --engine parallel --shards 2", vec!["needs --hosts FILE"]),
        ("job.toml --engine parallel --shards 2 --hosts hosts", vec!["there is no machine in it"]),
        ("job.toml --engine slurm", vec!["--shards"]),
        ("job.toml --engine slurm --shards 0", vec!["--shards", "a whole number from 1 to 1000000"]),
        ("job.toml --engine slurm --shards 2 --shard 1/2", vec!["cannot be used with"]),
        ("job.toml -- --partition=main", vec!["--engine"]),
        ("exact.toml --engine slurm --shards 2", vec!["draws no samples to share"]),
    ] {
        place.run(&format!("submit {words}")).refused(64, &texts);
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
    let submit = "--out run --shards 3 --engine slurm";
    place.run(&format!("submit job.toml {submit}")).done();
    let script = place.write("run/slurm/run.sh", "touch hacked\n");
    let status = place.run("status run").done().stdout;
    let merge = place.run("merge run").refused(65, &[]).stderr;
    assert!(status.contains("unless its tasks are still queued, continue with `stickslip resume run`"), "{status}");
    assert!(merge.contains("Submit every shard again (those that are finished end at once), or compute"), "{merge}");
    assert!(!status.contains("run.sh") && !merge.contains("run.sh"), "{status}{merge}");
    // The command writes it again.
    fs::remove_file(place.path("record")).unwrap();
    assert_eq!(place.run(&format!("submit run/job.toml {submit}")).done().stdout, "101 102\n");
    assert!(record(&place)[0].contains("--array=1-3 ") && !place.path("hacked").exists());
    assert!(fs::read_to_string(script).unwrap().contains("sbatch --job-name"));
}

#[test]
fn without_its_program_an_engine_is_refused() {
    let place = Place::new().with_environment("PATH", "/nowhere");
    place.write("job.toml", &job("no", EIGENVALUE, BOTH, "samples = 1000"));
    place.write("hosts", ":\n");
    place
        .run("submit job.toml --engine slurm --shards 2")
        .refused(74, &["cannot run sbatch", "submit on a machine of the cluster"]);
    place.run("submit job.toml --engine parallel --shards 2 --hosts hosts").refused(74, &["cannot run parallel"]);
    assert!(!place.path("runs").exists());
}

#[test]
fn a_slurm_that_is_not_configured_is_quoted() {
    let place = cluster();
    place.write("job.toml", &job("no", EIGENVALUE, BOTH, "samples = 1000"));
    let fails = "#!/bin/sh\necho 'sbatch: error: resolve_ctls_from_dns_srv: Unknown host' >&2\nexit 1\n";
    fs::write(place.path("bin/sbatch"), fails).unwrap();
    let texts = ["does not name slurm", "exit status: 1", "resolve_ctls_from_dns_srv: Unknown host"];
    place.run("submit job.toml --engine slurm --shards 2").refused(74, &texts);
    fs::write(place.path("bin/sbatch"), "#!/bin/sh\n").unwrap();
    place
        .run("submit job.toml --engine slurm --shards 2")
        .refused(74, &["exit status: 0", "nothing on standard error"]);
    assert!(!place.path("runs").exists());
}

#[test]
fn machines_are_read_from_what_ends() {
    let place = Place::new();
    place.write("job.toml", &job("no", EIGENVALUE, BOTH, "samples = 1000"));
    assert!(Command::new("mkfifo").arg(place.path("pipe")).status().unwrap().success());
    for (hosts, what) in [("pipe", "a pipe or a device"), ("/dev/zero", "a pipe or a device"), (".", "a directory")] {
        let words = format!("submit job.toml --engine parallel --shards 2 --hosts {hosts}");
        place.run(&words).refused(64, &[&format!("--hosts {hosts}: it is {what}"), "name an ordinary file"]);
    }
    place.run("submit job.toml --engine parallel --shards 2 --hosts gone").refused(74, &["cannot read gone"]);
}
