//! Hands the program the commit and the target that it is built for. A build in which neither has changed is the same,
//! whenever, wherever and by whom it is made.
//!
//! The commit is what STICKSLIP_COMMIT says; without it, what git says; without git, "unknown".

#![allow(clippy::print_stdout, reason = "cargo reads what a build script prints")]

use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The folder of this package in the repository.
const PACKAGE: &str = "crates/runner/";

/// What the program is built from, seen from the root of the repository.
const SOURCES: [&str; 4] = ["Cargo.toml", "Cargo.lock", "crates", "jobs"];

fn main() {
    println!("cargo::rerun-if-env-changed=STICKSLIP_COMMIT");
    println!("cargo::rerun-if-changed=build.rs");
    let given = env::var("STICKSLIP_COMMIT").ok().and_then(|given| Some(given.lines().next()?.trim().to_owned()));
    let commit = given.filter(|commit| !commit.is_empty()).or_else(commit_of_git);
    println!("cargo::rustc-env=STICKSLIP_BUILD_COMMIT={}", commit.as_deref().unwrap_or("unknown"));
    println!("cargo::rustc-env=STICKSLIP_BUILD_TARGET={}", env::var("TARGET").as_deref().unwrap_or("unknown"));
}

/// The commit that is checked out, as `0123456789ab (2026-01-31)`, and whether the sources differ from it.
fn commit_of_git() -> Option<String> {
    watch_head();
    // In the repository of something else that holds a copy of these files, git would name the commit of that.
    let is_ours = git(&["rev-parse", "--show-prefix"])? == PACKAGE && git(&["ls-files", "build.rs"])? == "build.rs";
    if !is_ours {
        return None;
    }
    let commit = git(&["log", "-1", "--no-show-signature", "--date=short", "--format=%H %cd"])?;
    let (hash, date) = commit.split_once(' ')?;
    let root = git(&["rev-parse", "--show-cdup"])?;
    let sources = SOURCES.iter().map(|source| format!("{root}{source}"));
    let sources: Vec<String> = sources.filter(|source| Path::new(source).exists()).collect();
    // Without this, changes after the first build would not be seen. A change there builds the program again in any case.
    for source in &sources {
        println!("cargo::rerun-if-changed={source}");
    }
    let mut status = vec!["status", "--porcelain", "--untracked-files=no", "--"];
    status.extend(sources.iter().map(String::as_str));
    let changes = if git(&status)?.is_empty() { "" } else { ", with changes" };
    Some(format!("{} ({date}){changes}", hash.get(..12)?))
}

/// Has cargo run this script again when another commit is checked out. A file that is watched must exist, or else the
/// script runs at every build.
fn watch_head() {
    let path_of = |name: &str| git(&["rev-parse", "--git-path", name]).map(PathBuf::from);
    let watch = |path: &Path| println!("cargo::rerun-if-changed={}", path.display());
    // The log has a line for each time that HEAD or its branch moves.
    let files = ["HEAD", "logs/HEAD"].into_iter().filter_map(path_of);
    files.filter(|path| path.exists()).for_each(|path| watch(&path));
    let Some(branch) = git(&["symbolic-ref", "--quiet", "HEAD"]).as_deref().and_then(path_of) else { return };
    if branch.exists() {
        watch(&branch);
        return;
    }
    // A packed branch gets a file of its own with its next commit, in a folder that may not be there yet.
    branch.ancestors().skip(1).find(|folder| folder.exists()).into_iter().for_each(watch);
    path_of("packed-refs").filter(|path| path.exists()).iter().for_each(|path| watch(path));
}

/// What git prints in the folder of this package; `None` if it fails.
fn git(arguments: &[&str]) -> Option<String> {
    let mut command = Command::new("git");
    command.args(["-c", "core.fsmonitor=false", "-c", "core.quotePath=false"]).args(arguments);
    command.current_dir(env::var_os("CARGO_MANIFEST_DIR")?);
    // A hook of git that builds would lead to its own repository, and a lock of the index would disturb others.
    for variable in ["GIT_DIR", "GIT_WORK_TREE", "GIT_INDEX_FILE", "GIT_PREFIX"] {
        command.env_remove(variable);
    }
    let output = command.env("GIT_OPTIONAL_LOCKS", "0").output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8(output.stdout).ok()?.trim_end_matches('\n').to_owned())
}
