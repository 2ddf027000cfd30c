//! Engines that exist already and run the shards of a job on many machines: job arrays of Slurm, and GNU parallel over
//! ssh. What is made here are texts: scripts, lists of tasks, and what the environment of a task says.

mod shell;

pub mod task_list;

pub mod array_task;

mod task;

pub mod slurm;

pub mod gnu_parallel;

pub use task::{Script, ShardTask, again, first_script};
