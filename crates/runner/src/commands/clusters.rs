//! `submit --engine`: sharing a job among the machines of a cluster, by a job array of Slurm or by GNU parallel over ssh. What
//! they run is a script in the run directory.

use std::fs;
use std::io::{self, BufRead as _, BufReader};
use std::path::{Path, absolute};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use super::adoption::{RunState, adopt_as_shard};
use super::named_job::read_job;
use super::submit::{map_directories, merge, require_samples_to_share};
use crate::cli::{AskedArguments, EngineKind, MergeArguments, SubmitArguments, WAIT};
use crate::failure::{Advice, Failure};
use crate::files::bounded::read_file;
use crate::interrupt::Interrupt;
use crate::job::{Job, Overrides};
use crate::messages::are_json;
use crate::output::{note, quoted, result, warn};
use crate::shell::in_quotes;
use crate::store::directory::RunDirectory;

/// The scripts, in which `{{name}}` stands for a value.
const SLURM: &str = include_str!("clusters/slurm.sh");
const PARALLEL: &str = include_str!("clusters/parallel.sh");

/// The name of the script in the folder of its engine.
const SCRIPT: &str = "run.sh";

/// The limit of the file of machines, in bytes.
const MOST_BYTES: u64 = 1 << 20;

/// Time between two looks at a program that was started.
const PAUSE: Duration = Duration::from_millis(50);

/// Options of sbatch that the script needs for itself.
const OWN: [&str; 9] = ["--array", "-a", "--dependency", "-d", "--output", "-o", "--chdir", "-D", "--wrap"];

/// Characters that are quoted of what a program has written.
const MOST_QUOTED: usize = 500;

/// `stickslip submit --engine`.
pub fn submit_to_engine(arguments: &SubmitArguments, interrupt: &Interrupt) -> Result<(), Failure> {
    let (Some(kind), Some(shards)) = (arguments.engine.engine, arguments.engine.shards) else { return Ok(()) };
    let overrides = Overrides { seed: arguments.seed, samples: arguments.samples };
    let source = read_job(&arguments.job)?.with(overrides)?;
    let asked = &arguments.asked;
    let job = source.job()?.asked(asked.target, &asked.at)?;
    warn(job.warnings());
    require_samples_to_share(&job, "--engine")?;
    map_directories(&arguments.maps.maps, &job)?;
    let hosts = hosts(arguments, kind)?;
    let mut names = arguments.engine.sbatch.iter().filter_map(|option| option.split('=').next());
    if let Some(own) = names.find(|name| OWN.contains(name)) {
        return Err(Failure::Usage(format!("{own}: `--engine slurm` sets this option of sbatch itself; leave it out")));
    }
    let out = arguments.out.clone().unwrap_or_else(|| Path::new("runs").join(&job.name));
    if RunDirectory::view(&out).is_ok_and(|directory| directory.in_use()) {
        let remedy = "wait until it ends, or stop it";
        let message = format!("{} is in use by another stickslip; {remedy}", out.display());
        return Err(Failure::Busy(message).remedied(remedy));
    }
    require_program(kind)?;
    let (directory, job, state) = adopt_as_shard(&out, &source, &job)?;
    if let RunState::Finished(_) = state {
        drop(directory);
        note(format_args!("{} has all its samples; nothing to submit", out.display()));
        return merge(&MergeArguments { run: out, wait: WAIT, asked: asked.clone() }, interrupt);
    }
    let script = script(arguments, kind, shards, hosts, &job, &out)?;
    let folder = directory.create_folder(kind.name())?;
    // The logs of tasks go there, too, and a link in their place would be followed.
    folder.require_files().map_err(|error| Failure::creating(folder.path(), error))?;
    let path = folder.path().join(SCRIPT);
    folder.publish(SCRIPT, script.as_bytes()).map_err(|error| Failure::writing(&path, error))?;
    // The shards lock the directory themselves.
    drop(directory);
    let path = absolute(&path).map_err(|error| Failure::reading(&path, error))?;
    match kind {
        EngineKind::Slurm => submit_array(&path, &out),
        EngineKind::Parallel => run_shards(&path, &out, asked, interrupt),
    }
}

/// The file of machines, which GNU parallel needs. A pipe may never end, and the script reads it once more.
fn hosts(arguments: &SubmitArguments, kind: EngineKind) -> Result<Option<&Path>, Failure> {
    let usage = |message: String| Err(Failure::Usage(message));
    let engine = &arguments.engine;
    let file = match (kind, &engine.hosts) {
        (EngineKind::Slurm, None) => return Ok(None),
        (EngineKind::Slurm, Some(_)) => return usage("--hosts does nothing with --engine slurm".to_owned()),
        (EngineKind::Parallel, _) if !engine.sbatch.is_empty() => {
            return usage("options of sbatch do nothing with --engine parallel".to_owned());
        }
        (EngineKind::Parallel, None) => {
            let why = "a file with a machine in each line, as ssh knows it";
            return usage(format!("--engine parallel needs --hosts FILE: {why}"));
        }
        (EngineKind::Parallel, Some(file)) => file,
    };
    let found = fs::metadata(file).map_err(|error| Failure::reading(file, error))?;
    if !found.is_file() {
        let what = if found.is_dir() { "a directory" } else { "a pipe or a device, which may never end" };
        let remedy = "name an ordinary file with a machine in each line";
        return usage(format!("--hosts {}: it is {what}; {remedy}", file.display()));
    }
    let bytes = read_file(file, MOST_BYTES).map_err(|error| Failure::reading(file, error))?;
    let text = String::from_utf8_lossy(&bytes);
    if text.lines().map(str::trim).all(|line| line.is_empty() || line.starts_with('#')) {
        let remedy = "write one in each line, as ssh knows it (: is this one)";
        return usage(format!("--hosts {}: there is no machine in it; {remedy}", file.display()));
    }
    Ok(Some(file))
}

/// The script of a run.
fn script(
    arguments: &SubmitArguments,
    kind: EngineKind,
    shards: u64,
    hosts: Option<&Path>,
    job: &Job,
    run: &Path,
) -> Result<String, Failure> {
    let program = std::env::current_exe()
        .map_err(|error| Failure::InputOutput(format!("cannot find the path of this program: {error}")))?;
    let maps = arguments.maps.maps.iter().map(|run| Ok(format!("--map {}", word(run)?)));
    let options = arguments.engine.sbatch.iter().map(|option| in_quotes(option));
    let asked = arguments.asked.options().map(|option| in_quotes(&option));
    let threads = arguments.threads.given();
    let values = [
        ("program", word(&program)?),
        ("run", word(run)?),
        ("name", job.name.clone()),
        ("shards", shards.to_string()),
        ("has_map", job.uses_maps().to_string()),
        ("maps", maps.collect::<Result<Vec<_>, Failure>>()?.join(" ")),
        ("hosts", hosts.map_or(Ok(String::new()), word)?),
        ("options", options.collect::<Vec<_>>().join(" ")),
        ("asked", asked.collect::<Vec<_>>().join(" ")),
        match kind {
            EngineKind::Slurm => ("threads", threads.unwrap_or(1).to_string()),
            EngineKind::Parallel => ("threads", threads.map_or(String::new(), |count| format!("--threads {count}"))),
        },
    ];
    let mut parts = if kind == EngineKind::Slurm { SLURM } else { PARALLEL }.split("{{");
    let mut text = parts.next().unwrap_or_default().to_owned();
    for (name, rest) in parts.filter_map(|part| part.split_once("}}")) {
        text.extend(values.iter().find(|(other, _)| *other == name).map(|(_, value)| value.as_str()));
        text.push_str(rest);
    }
    Ok(text)
}

/// An absolute path as a word of a script that runs elsewhere.
fn word(path: &Path) -> Result<String, Failure> {
    let absolute = absolute(path).map_err(|error| Failure::reading(path, error))?;
    let text = absolute.to_str().filter(|text| !text.contains('\0'));
    text.map(in_quotes).ok_or_else(|| {
        Failure::CannotCreate(format!("{} is not a path in UTF-8; scripts need one", absolute.display()))
    })
}

/// Refuses to start where the engine is not installed.
fn require_program(kind: EngineKind) -> Result<(), Failure> {
    let (program, sign, remedy) = match kind {
        EngineKind::Slurm => ("sbatch", "slurm", "submit on a machine of the cluster"),
        EngineKind::Parallel => ("parallel", "GNU parallel", "install GNU parallel"),
    };
    let output = Command::new(program).arg("--version").stdin(Stdio::null()).output();
    let output = output.map_err(|error| Failure::InputOutput(format!("cannot run {program}: {error}; {remedy}")))?;
    if String::from_utf8_lossy(&output.stdout).contains(sign) {
        return Ok(());
    }
    let said = String::from_utf8_lossy(&output.stderr);
    let said = match said.trim() {
        "" => "nothing on standard error".to_owned(),
        text => format!("{:?}", text.chars().take(MOST_QUOTED).collect::<String>()),
    };
    Err(Failure::InputOutput(format!(
        "`{program} --version` does not name {sign}: it ended with {} and wrote {said}. Correct its configuration, or {remedy}",
        output.status
    )))
}

/// Submits the array and the merge.
fn submit_array(script: &Path, run: &Path) -> Result<(), Failure> {
    let cannot = |error: io::Error| Failure::InputOutput(format!("cannot run sh: {error}"));
    let (child, passing_on) = started(script, &["submit"], Stdio::piped()).map_err(cannot)?;
    let output = child.wait_with_output().map_err(cannot)?;
    let _ = passing_on.map(JoinHandle::join);
    let jobs = String::from_utf8_lossy(&output.stdout).trim().to_owned();
    if !output.status.success() || jobs.is_empty() {
        let remedy = "correct what it says and submit the job again in the same way";
        let message = format!("Slurm did not take the job ({}); {remedy}", output.status);
        return Err(Failure::InputOutput(message).remedied(remedy));
    }
    note(format_args!("submitted; `stickslip status {}` shows its progress, `scancel {jobs}` stops it", quoted(run)));
    result(&format!("{jobs}\n"))
}

/// Runs the shards over GNU parallel, and merges them.
fn run_shards(script: &Path, run: &Path, asked: &AskedArguments, interrupt: &Interrupt) -> Result<(), Failure> {
    let again = "submit the job again in the same way";
    interrupt.remark(Advice::action(&format!(
        "shards that other machines have begun go on, and what is finished is kept; to continue, {again}"
    )));
    let cannot = |error: io::Error| Failure::InputOutput(format!("cannot run parallel: {error}"));
    let (child, passing_on) = started(script, &[], Stdio::inherit()).map_err(cannot)?;
    let status = wait(child, interrupt).map_err(cannot)?;
    if let Some(signal) = interrupt.signal() {
        let kept = Advice::action(&format!("what is finished is kept; to continue, {again}"));
        return Err(Failure::stopped(signal, &kept));
    }
    let _ = passing_on.map(JoinHandle::join);
    if !status.success() {
        let log = run.join("parallel/shard.log");
        note(format_args!("not every shard has ended well ({status}); see {}", quoted(&log)));
    }
    // A machine that was lost from sight may still be at work.
    merge(&MergeArguments { run: run.to_owned(), wait: WAIT, asked: asked.clone() }, interrupt)
}

/// Starts a script, whose messages a thread passes on as notes where they are for programs.
fn started(script: &Path, words: &[&str], output: Stdio) -> io::Result<(Child, Option<JoinHandle<()>>)> {
    let errors = if are_json() { Stdio::piped() } else { Stdio::inherit() };
    let mut command = Command::new("sh");
    command.arg(script).args(words).stdin(Stdio::null()).stdout(output).stderr(errors);
    let mut child = command.spawn()?;
    let passing_on = child.stderr.take().map(|errors| thread::spawn(|| pass_on(errors)));
    Ok((child, passing_on))
}

/// Passes on the messages of another program, each line as a note.
fn pass_on(errors: impl io::Read) {
    for line in BufReader::new(errors).split(b'\n').map_while(Result::ok) {
        note(format_args!("{}", String::from_utf8_lossy(&line)));
    }
}

/// Waits for a program to end, and ends it after a signal.
fn wait(mut child: Child, interrupt: &Interrupt) -> io::Result<ExitStatus> {
    let _working = interrupt.working();
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(status);
        }
        // GNU parallel may not listen yet, or wait for its jobs after the first signal.
        if interrupt.signal().is_some() {
            let _ = Command::new("kill").args(["-TERM", &child.id().to_string()]).status();
        }
        thread::sleep(PAUSE);
    }
}
