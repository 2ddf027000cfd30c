//! The scripts of a job array of Slurm: one that submits, one of each stage, and the merge at the end.
//!
//! Slurm tells a task a while before its time limit by a signal of its own choice. The shell of the task has the program
//! save its work, and puts the task into the queue again. SIGTERM comes with `scancel`, with preemption and with a time
//! limit without that warning. After it the task is not started again by itself.

use std::process::{Command, Stdio};

use super::shell::quoted;
use super::task::{Script, ShardTask};
use crate::job::{EngineSettings, TimeLimit};

/// Longest and shortest time in seconds from the warning to the time limit. The program takes two seconds.
const LONGEST_LEAD: u64 = 60;
const SHORTEST_LEAD: u64 = 5;

/// How often a task is started again: a sample that takes longer than the time limit would never be finished.
pub const RESTARTS: u64 = 100;

/// How often the merge submits what is missing.
const ROUNDS: u64 = 3;

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
        let mut scripts = vec![Script { name: "submit.sh", text: self.submission() }];
        if let Some(shards) = self.map_shards {
            let what = "Resolves a share of the verdict map of the run";
            scripts.push(Script { name: "map.sh", text: self.stage("map", what, shards, " --map-only") });
        }
        let what = "Computes one shard of the run";
        scripts.push(Script { name: "shard.sh", text: self.stage("shard", what, self.task.shards, "") });
        scripts.push(Script { name: "merge.sh", text: self.merge() });
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

    /// What submits the tasks of a round and the merge after them, and prints the numbers of the jobs.
    fn submission(&self) -> String {
        let mut text = format!(
            "#!/bin/sh
# Submits the shards of a run to Slurm, and the merge after them. Prints the numbers of the jobs.
#   sh submit.sh            all shards
#   sh submit.sh 3,7,12-15  these shards
set -eu
{}tasks=${{1:-1-{}}}
round=${{2:-1}}
# A federation adds the name of the cluster to the number of a job.
submitted() {{
    job=$(sbatch --parsable --chdir=\"$run\" \"$@\")
    job=${{job%%;*}}
    echo \"$job\"
}}
",
            self.task.variables(),
            self.task.shards
        );
        let mut after = "";
        if let Some(shards) = self.map_shards {
            text += &format!("map=$(submitted --array=1-{shards} \"$run/slurm/map.sh\")\n");
            // What a task leaves of the map is resolved by the shards.
            after = " --dependency=\"afterany:$map\"";
        }
        text += &format!("shards=$(submitted --array=\"$tasks\"{after} \"$run/slurm/shard.sh\")\n");
        text += "merge=$(submitted --dependency=\"afterany:$shards\" \"$run/slurm/merge.sh\" \"$round\" \"$shards\")\n";
        text + if self.map_shards.is_some() { "echo \"$map $shards $merge\"\n" } else { "echo \"$shards $merge\"\n" }
    }

    /// A stage whose tasks are started again at their time limit.
    fn stage(&self, stage: &str, what: &str, shards: u64, more: &str) -> String {
        let more = format!("{more} --threads \"$SLURM_CPUS_PER_TASK\"");
        format!(
            "#!/bin/sh
{header}# {what}: a task of a job array of Slurm.
set -u
{variables}program=
at_limit=no
stop() {{
    if [ -n \"$program\" ]; then kill -TERM \"$program\" 2>/dev/null; fi
}}
# USR1 tells that the time limit is near. TERM comes with scancel, and is obeyed.
trap 'at_limit=yes; stop' USR1
trap stop TERM

{command} &
program=$!
wait \"$program\"
code=$?
# A signal ends the waiting, not the program.
while kill -0 \"$program\" 2>/dev/null; do
    wait \"$program\"
    code=$?
done
if [ \"$at_limit\" = yes ] && [ \"$code\" -eq 143 ] && [ \"${{SLURM_RESTART_COUNT:-0}}\" -lt {RESTARTS} ]; then
    # What is finished is saved, and the task goes on from there.
    scontrol requeue \"${{SLURM_ARRAY_JOB_ID}}_$SLURM_ARRAY_TASK_ID\"
fi
exit \"$code\"
",
            header = self.header(stage, self.cpus, &format!("{stage}-%a"), Some(self.warning())),
            variables = self.task.variables(),
            command = self.task.command("$SLURM_ARRAY_TASK_ID", shards, &more),
        )
    }

    /// The merge. It submits the shards that are missing, a few times.
    fn merge(&self) -> String {
        format!(
            "#!/bin/sh
{header}# Writes the surface of the run, after its shards. If some are missing, they are submitted again.
#   merge.sh ROUND ARRAY
set -u
{variables}round=$1
array=$2

attempt=1
while :; do
    \"$stickslip\" merge \"$run\" --wait 0
    code=$?
    # 75: a task that Slurm believes to be lost is still at work.
    if [ \"$code\" -ne 75 ] || [ \"$attempt\" -ge 60 ]; then break; fi
    attempt=$((attempt + 1))
    sleep 10
done
if [ \"$code\" -ne 65 ]; then exit \"$code\"; fi
missing=$(\"$stickslip\" status \"$run\" --missing --format slurm) || exit
if [ -z \"$missing\" ]; then exit \"$code\"; fi
if scontrol show job \"$array\" --oneliner 2>/dev/null | grep -q JobState=CANCELLED; then
    why=\"tasks were cancelled\"
elif [ \"$round\" -ge {ROUNDS} ]; then
    why=\"this was round $round\"
else
    echo \"submitting shards $missing again\"
    sh \"$run/slurm/submit.sh\" \"$missing\" \"$((round + 1))\"
    exit
fi
echo \"shards $missing are missing, and $why. Submit them again with\"
printf '%s\\n' {again}\" $missing\"
exit \"$code\"
",
            header = self.header("merge", 1, "merge", None),
            variables = self.task.variables(),
            again = quoted(&self.again()),
        )
    }

    /// The command that submits shards, whose list follows.
    fn again(&self) -> String {
        format!("sh {}", quoted(&format!("{}/slurm/submit.sh", self.task.run())))
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
    fn the_cluster_tells_its_limit() {
        assert_eq!(limit_in("MailProg                = /bin/true\nMaxArraySize            = 1001\n"), Some(1000));
        assert_eq!(limit_in("MaxArraySize            = 1\n"), None);
        assert_eq!(limit_in("slurm_load_ctl_conf error: Unable to contact slurm controller"), None);
    }
}
