//! `submit --engine`: sharing a job among the machines of a cluster.

use std::io::{self, BufRead as _, BufReader};
use std::path::{Path, PathBuf, absolute};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::Duration;

use super::adoption::{RunState, adopt_as_shard};
use super::shard_progress::ShardProgress;
use super::sharing::require_samples_to_share;
use super::sharing::{WorkToShare, cost_of_maps, cost_of_samples};
use super::submit::{map_directories, merge};
use crate::cli::{EngineKind, MergeArguments, SubmitArguments, WAIT};
use crate::cluster::gnu_parallel::{Machines, SharedRun};
use crate::cluster::slurm::{JobArray, RESTARTS, array_limit, longest_task};
use crate::cluster::task_list::ranges;
use crate::cluster::{Script, ShardTask, again};
use crate::evaluate::parts::Parts;
use crate::failure::{Advice, Failure};
use crate::interrupt::Interrupt;
use crate::job::{EngineSettings, Job, JobSource, Overrides, TimeLimit};
use crate::messages::are_json;
use crate::output::{counted, note, quoted, result, warn};
use crate::schedule::engine::Engine;
use crate::schedule::plan::Plan;
use crate::schedule::shard_size::{MOST_TASKS, number_of_shards};
use crate::schedule::time_left;
use crate::store::directory::RunDirectory;
use crate::store::sharing::Sharing;
use crate::store::tally::Tally;

/// Time between two looks at a program that was started.
const PAUSE: Duration = Duration::from_millis(50);

/// Characters that are quoted of what a program has written.
const MOST_QUOTED: usize = 500;

/// `stickslip submit --engine`.
pub fn submit_to_engine(arguments: &SubmitArguments, interrupt: &Interrupt) -> Result<(), Failure> {
    let Some(kind) = arguments.engine.engine else { return Ok(()) };
    if let Some(option) = arguments.engine.stranger(kind) {
        return Err(Failure::Usage(format!("{option} does nothing with --engine {}", kind.name())));
    }
    let overrides = Overrides { seed: arguments.seed, samples: arguments.samples };
    let source = JobSource::read(&arguments.job)?.with(overrides)?;
    let job = source.job()?;
    source.require_options_for_jobs(&job)?;
    warn(job.warnings());
    require_samples_to_share(&job, "--engine")?;
    map_directories(&arguments.maps.maps, &job)?;
    let out = arguments.out.clone().unwrap_or_else(|| Path::new("runs").join(&job.name));
    let request = Request {
        kind,
        settings: arguments.engine.settings().or(&job.engine),
        threads: arguments.threads.given(),
        machines: machines(arguments, kind)?,
        maps: &arguments.maps.maps,
        run: &out,
    };
    if RunDirectory::view(&out).is_ok_and(|directory| directory.in_use()) {
        let remedy = "wait until it ends, or stop it";
        let message = format!("{} is in use by another stickslip; {remedy}", out.display());
        return Err(Failure::Busy(message).remedied(remedy));
    }
    if arguments.engine.dry_run {
        let tally = Tally::new(&Parts::new(&job));
        let shards = request.shards(&job, &tally, None)?;
        let scripts = request.scripts(&job, shards)?;
        let text =
            |script: &Script| format!("# {}\n{}\n", quoted(&out.join(kind.name()).join(script.name)), script.text);
        return result(&scripts.iter().map(text).collect::<String>());
    }
    request.require_program()?;
    request.most()?;
    let (directory, job, state) = adopt_as_shard(&out, &source, &job)?;
    let known = Sharing::read(&out).map(|sharing| sharing.shards);
    let (tally, shards) = match state {
        RunState::Finished(_) => {
            drop(directory);
            note(format_args!("{} has all its samples; nothing to submit", out.display()));
            return merge(&MergeArguments { run: out, wait: WAIT }, interrupt);
        }
        // The shards of a run that has begun keep their numbers.
        RunState::Unfinished(tally) => {
            let shards = request.shards(&job, &tally, known)?;
            (tally, shards)
        }
        RunState::New(tally) => {
            let shards = request.shards(&job, &tally, None)?;
            (tally, shards)
        }
    };
    let scripts = request.scripts(&job, shards)?;
    let folder = directory.create_folder(kind.name())?;
    // The logs of tasks go there, too, and a link in their place would be followed.
    folder.require_files().map_err(|error| Failure::creating(folder.path(), error))?;
    for Script { name, text } in &scripts {
        let written = folder.publish(name, text.as_bytes());
        written.map_err(|error| Failure::writing(&folder.path().join(name), error))?;
    }
    Sharing { engine: kind.name().to_owned(), shards }.record(&out)?;
    let missing = ShardProgress::new(&out, &job, &Parts::new(&job), &tally, shards).missing();
    // The shards lock the directory themselves.
    drop(directory);
    request.start(&missing, interrupt)
}

/// The machines of `--hosts`.
fn machines(arguments: &SubmitArguments, kind: EngineKind) -> Result<Option<Machines>, Failure> {
    match (&arguments.engine.hosts, kind) {
        (Some(file), EngineKind::Parallel) => Machines::read(file).map(Some),
        (None, EngineKind::Parallel) => Err(Failure::Usage(
            "--engine parallel needs --hosts FILE: a file with a machine in each line, as ssh knows it".to_owned(),
        )),
        (_, EngineKind::Slurm) => Ok(None),
    }
}

/// What is asked of an engine.
struct Request<'a> {
    kind: EngineKind,
    settings: EngineSettings,
    /// `--threads`.
    threads: Option<usize>,
    /// With GNU parallel.
    machines: Option<Machines>,
    maps: &'a [PathBuf],
    run: &'a Path,
}

impl Request<'_> {
    /// Processors of a task of Slurm.
    fn cpus(&self) -> u64 {
        self.settings.cpus_per_task.or(self.threads.map(|threads| threads as u64)).unwrap_or(1)
    }

    /// Threads of a shard, as far as they are known here.
    fn threads_of_shard(&self) -> usize {
        let here = || thread::available_parallelism().map_or(1, std::num::NonZero::get);
        match self.kind {
            EngineKind::Slurm => self.cpus() as usize,
            EngineKind::Parallel => self.threads.unwrap_or_else(here),
        }
    }

    /// The largest number of shards. An array of Slurm may have fewer tasks than is usual.
    fn most(&self) -> Result<u64, Failure> {
        let limit = if self.kind == EngineKind::Slurm { array_limit() } else { None };
        if let (Some(shards), Some(limit)) = (self.settings.shards, limit)
            && shards > limit
        {
            return Err(Failure::Usage(format!(
                "{shards} shards are more than the {limit} tasks that this cluster allows in an array (MaxArraySize); take --shards {limit} or fewer"
            )));
        }
        let most = self.settings.max_shards.unwrap_or(MOST_TASKS);
        Ok(limit.map_or(most, |limit| most.min(limit)))
    }

    /// The time limit of a task, if one is asked for.
    fn time_limit(&self) -> Option<&TimeLimit> {
        self.settings.time.as_ref().filter(|_| self.kind == EngineKind::Slurm)
    }

    /// The number of shards: as given, as the run has `known` it, or by what the missing samples cost.
    fn shards(&self, job: &Job, tally: &Tally, known: Option<u64>) -> Result<u64, Failure> {
        let most = self.most()?;
        let given = self.settings.shards.or(known);
        let limit = self.time_limit();
        if let (Some(shards), None) = (given, limit) {
            return Ok(shards);
        }
        let work = cost_of_samples(job, tally, &measuring()?)?;
        let shards = given.unwrap_or_else(|| self.shards_by_cost(work, most));
        warn(limit.and_then(|limit| self.too_short(limit, job, tally, work, shards)));
        Ok(shards)
    }

    /// The number of shards by what the missing samples cost, at most `most`.
    fn shards_by_cost(&self, WorkToShare { seconds, units }: WorkToShare, most: u64) -> u64 {
        let threads = self.threads_of_shard();
        let mut shards = number_of_shards(seconds, units, threads, most);
        if let Some(machines) = &self.machines {
            shards = machines.number_of_shards(shards, seconds, units, threads, most);
        }
        note(format_args!(
            "{} of about {} each on {} (measured now)",
            counted(shards.into(), "shard", "shards"),
            time_left::Duration(seconds / (shards as f64 * threads as f64)),
            counted(threads as u128, "thread", "threads"),
        ));
        shards
    }

    /// A warning, if the largest shard cannot be finished within the time limit and all restarts of its task.
    fn too_short(&self, limit: &TimeLimit, job: &Job, tally: &Tally, work: WorkToShare, shards: u64) -> Option<String> {
        let missing = Plan::missing_of_shards(tally, &Parts::new(job), job.unit_samples(), shards);
        let all: u128 = missing.iter().sum();
        let largest = *missing.iter().max()? as f64 / all.max(1) as f64;
        let seconds = work.seconds / self.threads_of_shard() as f64;
        let task = longest_task(limit) as f64;
        if largest * seconds <= task {
            return None;
        }
        let least = (seconds / task).ceil() as u64;
        let is_possible = least <= work.units.min(array_limit().unwrap_or(MOST_TASKS));
        let more_shards =
            if is_possible { format!(", or for at least {least} shards (--shards)") } else { String::new() };
        Some(format!(
            "a shard takes about {}, but its task runs for about {} at most (--time {limit}, with {RESTARTS} restarts), so that it will not be finished. Ask for more time (--time {} is enough without a restart){more_shards}",
            time_left::Duration(largest * seconds),
            time_left::Duration(task),
            TimeLimit::covering(largest * seconds + 60.0),
        ))
    }

    /// The number of shards in which verdict maps are resolved first, if the job has some.
    fn map_shards(&self, job: &Job) -> Result<Option<u64>, Failure> {
        if !job.uses_maps() {
            return Ok(None);
        }
        let most = self.most()?;
        let WorkToShare { seconds, units } = cost_of_maps(job, &measuring()?)?;
        Ok(Some(number_of_shards(seconds, units, self.threads_of_shard(), most)))
    }

    /// The scripts of a run in this many shards.
    fn scripts(&self, job: &Job, shards: u64) -> Result<Vec<Script>, Failure> {
        let task = ShardTask::new(self.run, self.maps, shards)?;
        let map_shards = self.map_shards(job)?;
        Ok(match &self.machines {
            Some(machines) => SharedRun { task, map_shards, machines, threads: self.threads }.scripts(),
            None => {
                let settings = self.settings.clone();
                JobArray { name: &job.name, task, map_shards, settings, cpus: self.cpus() }.scripts()
            }
        })
    }

    /// Refuses to start where the engine is not installed.
    fn require_program(&self) -> Result<(), Failure> {
        let (program, sign, remedy) = match self.kind {
            EngineKind::Slurm => ("sbatch", "slurm", "submit on a machine of the cluster"),
            EngineKind::Parallel => ("parallel", "GNU parallel", "install GNU parallel"),
        };
        let output = Command::new(program).arg("--version").stdin(Stdio::null()).output();
        match output {
            Ok(output) if String::from_utf8_lossy(&output.stdout).contains(sign) => Ok(()),
            Ok(output) => {
                let said = String::from_utf8_lossy(&output.stderr);
                let said = match said.trim() {
                    "" => "nothing on standard error".to_owned(),
                    text => format!("{:?}", text.chars().take(MOST_QUOTED).collect::<String>()),
                };
                Err(Failure::InputOutput(format!(
                    "`{program} --version` does not name {sign}: it ended with {} and wrote {said}. Correct its configuration, or {remedy}. --dry-run shows the scripts anywhere",
                    output.status
                )))
            }
            Err(error) => Err(Failure::InputOutput(format!(
                "cannot run {program}: {error}; {remedy}. --dry-run shows the scripts anywhere"
            ))),
        }
    }

    /// Starts the scripts, for all shards or for those that are missing.
    fn start(&self, missing: &[u64], interrupt: &Interrupt) -> Result<(), Failure> {
        match self.kind {
            EngineKind::Slurm => self.submit_array(missing),
            EngineKind::Parallel => self.run_shards(missing, interrupt),
        }
    }

    /// The path of a script, which no shell takes for an option.
    fn script(&self, name: &str) -> Result<PathBuf, Failure> {
        absolute(self.run.join(name)).map_err(|error| Failure::reading(self.run, error))
    }

    /// Submits the array and the merge.
    fn submit_array(&self, missing: &[u64]) -> Result<(), Failure> {
        let mut command = Command::new("sh");
        command.arg(self.script("slurm/submit.sh")?).arg(ranges(missing));
        let cannot = |error: io::Error| Failure::InputOutput(format!("cannot run sh: {error}"));
        let mut child =
            command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(its_errors()).spawn().map_err(cannot)?;
        let passing_on = child.stderr.take().map(|errors| thread::spawn(|| pass_on(errors)));
        let output = child.wait_with_output().map_err(cannot)?;
        let _ = passing_on.map(thread::JoinHandle::join);
        let jobs = String::from_utf8_lossy(&output.stdout).trim().to_owned();
        if !output.status.success() || jobs.is_empty() {
            let again = self.again(missing);
            return Err(Failure::InputOutput(format!(
                "Slurm did not take the job ({}); the scripts are in {}: change them and run `{again}`",
                output.status,
                quoted(&self.run.join("slurm")),
            ))
            .remedied(again));
        }
        note(format_args!(
            "submitted; `stickslip status {}` shows its progress, `scancel {jobs}` stops it",
            quoted(self.run)
        ));
        result(&format!("{jobs}\n"))
    }

    /// Runs the shards over GNU parallel, and merges them.
    fn run_shards(&self, missing: &[u64], interrupt: &Interrupt) -> Result<(), Failure> {
        let again = self.again(missing);
        interrupt.remark(Advice::command(
            "shards that other machines have begun go on, and what is finished is kept; continue with",
            &again,
        ));
        let mut command = Command::new("sh");
        command.arg(self.script("parallel/run.sh")?);
        command.args(missing.iter().map(u64::to_string)).stdin(Stdio::null());
        let cannot = |error: io::Error| Failure::InputOutput(format!("cannot run parallel: {error}"));
        let mut child = command.stderr(its_errors()).spawn().map_err(cannot)?;
        let passing_on = child.stderr.take().map(|errors| thread::spawn(|| pass_on(errors)));
        let status = wait(child, interrupt).map_err(cannot)?;
        if let Some(signal) = interrupt.signal() {
            return Err(Failure::stopped(signal, &Advice::command("what is finished is kept; continue with", &again)));
        }
        let _ = passing_on.map(thread::JoinHandle::join);
        if !status.success() {
            note(format_args!(
                "not every shard has ended well ({status}); see {}",
                quoted(&self.run.join("parallel/shard.log"))
            ));
        }
        // A machine that was lost from sight may still be at work.
        merge(&MergeArguments { run: self.run.to_owned(), wait: WAIT }, interrupt)
    }

    /// The command that submits shards again.
    fn again(&self, missing: &[u64]) -> String {
        again(self.run, self.kind.name(), missing).unwrap_or_default()
    }
}

/// The threads that measure what a job costs.
fn measuring() -> Result<Engine, Failure> {
    Engine::new(thread::available_parallelism().map_or(1, std::num::NonZero::get))
}

/// Where the messages of another program go.
fn its_errors() -> Stdio {
    if are_json() { Stdio::piped() } else { Stdio::inherit() }
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
    let mut is_signalled = false;
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(status);
        }
        if interrupt.signal().is_some() && !is_signalled {
            is_signalled = true;
            // The first asks GNU parallel to start no more, the second to end.
            for _ in 0..2 {
                let _ = Command::new("kill").args(["-TERM", &child.id().to_string()]).status();
                thread::sleep(PAUSE);
            }
        }
        thread::sleep(PAUSE);
    }
}
