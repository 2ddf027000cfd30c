//! The shard of a task of a job array, from the environment in which Slurm starts it.

use crate::schedule::plan::Shard;

/// A task of a job array.
#[derive(Debug)]
pub struct ArrayTask {
    /// The shard that it computes.
    pub shard: Shard,
    /// What it was taken from, in words.
    pub origin: String,
}

impl ArrayTask {
    /// The task that this process is, by the variables of its environment.
    ///
    /// # Errors
    /// What is wrong with them: they are missing, or do not number the tasks from 0 or 1 without gaps. An array of some
    /// tasks only (`--array=3,7`) does not say how many shards there are.
    pub fn from_environment(variable: impl Fn(&str) -> Option<String>) -> Result<Self, String> {
        let remedy = "write the number of shards yourself, as in --shard \"$SLURM_ARRAY_TASK_ID/16\"";
        let number = |name: &str| -> Result<Option<u64>, String> {
            let Some(text) = variable(name) else { return Ok(None) };
            text.parse().map(Some).map_err(|_| format!("{name} is {text:?}, not a whole number; {remedy}"))
        };
        let needed = |name: &str| {
            number(name)?.ok_or_else(|| {
                format!("{name} is not set: this is no task of a job array of Slurm (sbatch --array=1-16); {remedy}")
            })
        };
        let (task, count) = (needed("SLURM_ARRAY_TASK_ID")?, needed("SLURM_ARRAY_TASK_COUNT")?);
        let first = number("SLURM_ARRAY_TASK_MIN")?.unwrap_or(1);
        let last = number("SLURM_ARRAY_TASK_MAX")?.unwrap_or(first.saturating_add(count).saturating_sub(1));
        let whole = format!("task {task} of an array of {count}, numbered {first} to {last}");
        let is_whole = first <= 1 && last.checked_sub(first).and_then(|span| span.checked_add(1)) == Some(count);
        if !is_whole || !(first..=last).contains(&task) {
            return Err(format!(
                "this is {whole}: that does not say how many shards there are, as it would with tasks 1 to N or 0 to N-1; {remedy}"
            ));
        }
        let shard = format!("{task}/{count}").parse().map_err(|why| format!("this is {whole}: {why}"))?;
        Ok(Self { shard, origin: whole })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn task(values: [&str; 4]) -> Result<String, String> {
        let names = ["SLURM_ARRAY_TASK_ID", "SLURM_ARRAY_TASK_COUNT", "SLURM_ARRAY_TASK_MIN", "SLURM_ARRAY_TASK_MAX"];
        let find = |name: &str| {
            let place = names.iter().position(|other| *other == name)?;
            Some(values[place].to_owned()).filter(|value| !value.is_empty())
        };
        ArrayTask::from_environment(find).map(|task| task.shard.to_string())
    }

    #[test]
    fn arrays_without_gaps_are_shards() {
        assert_eq!(task(["3", "16", "1", "16"]).as_deref(), Ok("3/16"));
        assert_eq!(task(["0", "16", "0", "15"]).as_deref(), Ok("0/16"));
        assert_eq!(task(["15", "16", "0", "15"]).as_deref(), Ok("15/16"));
        assert_eq!(task(["16", "16", "", ""]).as_deref(), Ok("16/16"));
    }

    #[test]
    fn arrays_of_some_tasks_are_refused() {
        for (values, reason) in [
            (["", "", "", ""], "SLURM_ARRAY_TASK_ID is not set"),
            (["3", "", "", ""], "SLURM_ARRAY_TASK_COUNT is not set"),
            (["3", "2", "3", "7"], "numbered 3 to 7"),
            (["1", "3", "1", "7"], "an array of 3, numbered 1 to 7"),
            (["2", "1", "2", "2"], "numbered 2 to 2"),
            (["17", "16", "1", "16"], "task 17 of"),
            (["x", "16", "1", "16"], "not a whole number"),
            (["1", "0", "1", "0"], "an array of 0"),
            (["1", "16", "1", "18446744073709551615"], "numbered 1 to 18446744073709551615"),
        ] {
            let why = task(values).unwrap_err();
            assert!(why.contains(reason) && why.contains("--shard \"$SLURM_ARRAY_TASK_ID/16\""), "{why}");
        }
    }
}
