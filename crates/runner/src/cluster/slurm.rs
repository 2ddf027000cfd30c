//! The scripts of a job array of Slurm: one that submits, one of each stage, and the merge at the end.
//!
//! Slurm warns a task a while before its time limit by a signal that the task chooses. The shell of the task has the
//! program save its work, and puts the task into the queue again. SIGTERM comes with `scancel`, with preemption and
//! with a time limit without that warning. After it the task is not started again by itself.

use std::process::{Command, Stdio};

use super::shell::quoted;
use super::task::{Script, ShardTask};
use crate::job::{EngineSettings, TimeLimit};

/// Longest and shortest time in seconds from the warning to the time limit. The program takes two seconds.
const LONGEST_LEAD: u64 = 60;
const SHORTEST_LEAD: u64 = 5;

/// How often a task is started again: a sample that takes longer than the time limit would never be finished.
pub const RESTARTS: u64 = 100;

/// The scripts: what submits the tasks of a round and the merge after them, a task that is started again at its time limit,
/// and the merge.
const SUBMIT: &str = include_str!("slurm/submit.sh");
const TASK: &str = include_str!("slurm/task.sh");
const MERGE: &str = include_str!("slurm/merge.sh");

/// A job array and what comes before and after it.
#[derive(Debug)]
pub struct JobArray<'a> {
    /// The name of the job, of letters, digits, '-', '_' and '.'.
    pub name: &'a str,
    /// What a task does.
    pub task: ShardTask,
    /// The number of shards in which a verdict map is resolved first, if there is one.
    pub map_shards: Option<u64>,
    /// What is asked of Slurm.
    pub settings: EngineSettings,
    /// Processors of a task.
    pub cpus: u64,
}

impl JobArray<'_> {
    /// All scripts, the one that submits first.
    pub fn scripts(&self) -> Vec<Script> {
        let map_tasks = self.map_shards.map_or(String::new(), |shards| format!("1-{shards}"));
        let mut scripts = vec![self.task.script("submit.sh", SUBMIT, &[("map_tasks", map_tasks)])];
        scripts.extend(self.task.steps(TASK, self.map_shards, |step| {
            let header = self.header(step, self.cpus, &format!("{step}-%a"), Some(self.warning()));
            vec![("header", header), ("restarts", RESTARTS.to_string())]
        }));
        let again = format!("sh {}", quoted(&format!("{}/slurm/submit.sh", self.task.run())));
        let values = [("header", self.header("merge", 1, "merge", None)), ("again", quoted(&again))];
        scripts.push(self.task.script("merge.sh", MERGE, &values));
        scripts
    }

    /// The lines that Slurm reads. Of two lines about one option it takes the last, so that those of the user come last.
    fn header(&self, stage: &str, cpus: u64, log: &str, signal: Option<String>) -> String {
        let EngineSettings { partition, account, time, memory, sbatch, .. } = &self.settings;
        let mut options = vec![format!("--job-name=stickslip-{}-{stage}", self.name)];
        options.extend(partition.iter().map(|partition| format!("--partition={partition}")));
        options.extend(account.iter().map(|account| format!("--account={account}")));
        options.extend(time.iter().map(|time| format!("--time={time}")));
        options.extend(memory.iter().map(|memory| format!("--mem={memory}")));
        options.push(format!("--cpus-per-task={cpus}"));
        options.push(format!("--output=slurm/{log}.log"));
        options.extend(["--open-mode=append", "--requeue"].map(str::to_owned));
        options.extend(signal);
        options.extend(sbatch.iter().map(ToString::to_string));
        options.into_iter().map(|option| format!("#SBATCH {option}\n")).collect()
    }

    /// What makes Slurm warn the shell of a task before its time limit.
    fn warning(&self) -> String {
        format!("--signal=B:USR1@{}", self.settings.time.as_ref().map_or(LONGEST_LEAD, lead))
    }
}

/// Seconds from the warning to this time limit.
fn lead(limit: &TimeLimit) -> u64 {
    (limit.seconds / 10).clamp(SHORTEST_LEAD, LONGEST_LEAD)
}

/// Seconds that a task with this time limit computes at most, with all its restarts.
pub fn longest_task(limit: &TimeLimit) -> u64 {
    (RESTARTS + 1) * (limit.seconds - lead(limit))
}

/// The largest number of a task that the cluster allows, if it says.
pub fn array_limit() -> Option<u64> {
    let output = Command::new("scontrol").args(["show", "config"]).stdin(Stdio::null()).output().ok()?;
    limit_in(&String::from_utf8_lossy(&output.stdout))
}

/// The largest number of a task, which is less than MaxArraySize.
fn limit_in(configuration: &str) -> Option<u64> {
    let setting = |line: &str| {
        let (name, value) = line.split_once('=')?;
        (name.trim() == "MaxArraySize").then(|| value.trim().parse::<u64>().ok())?
    };
    configuration.lines().find_map(setting)?.checked_sub(1).filter(|&limit| limit > 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_task_computes_until_its_warning() {
        let seconds = |text: &str| longest_task(&text.parse().unwrap());
        assert_eq!(seconds("1"), 101 * 54);
        assert_eq!(seconds("1-0"), 101 * (86_400 - 60));
    }

    #[test]
    fn the_cluster_shows_its_limit() {
        assert_eq!(limit_in("MailProg                = /bin/true\nMaxArraySize            = 1001\n"), Some(1000));
        assert_eq!(limit_in("MaxArraySize            = 1\n"), None);
        assert_eq!(limit_in("slurm_load_ctl_conf error: Unable to contact slurm controller"), None);
    }
}
