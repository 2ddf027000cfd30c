//! Runs and their directories: threads, shards, signals, kills, damage, engines and versions.

#[path = "../common/mod.rs"]
mod common;

mod determinism;
mod engines;
mod interruptions;
mod large_jobs;
mod remedies;
mod run_directory;
mod signals;
mod versions;
