//! What the build script of the program says of its commit, in repositories made for the purpose.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so and stop")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::common::{assert_succeeds, repository};
use tempfile::TempDir;

/// A folder with a copy of the build script where it lies in the repository, and the script, compiled.
struct Sources {
    folder: TempDir,
}

impl Sources {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let sources = Self { folder };
        fs::create_dir_all(sources.package()).unwrap();
        fs::copy(repository().join("crates/runner/build.rs"), sources.package().join("build.rs")).unwrap();
        for (name, text) in [("Cargo.toml", "[workspace]\n"), ("Cargo.lock", ""), ("README.md", "words\n")] {
            fs::write(sources.root().join(name), text).unwrap();
        }
        let script = sources.folder.path().join("script");
        let mut compile = Command::new(std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()));
        compile.args(["--edition", "2024", "-o"]).arg(script).arg(sources.package().join("build.rs"));
        assert_succeeds(&mut compile);
        sources
    }

    /// The root of the sources.
    fn root(&self) -> PathBuf {
        self.folder.path().join("sources")
    }

    fn package(&self) -> PathBuf {
        self.root().join("crates/runner")
    }

    /// Begins a repository in a folder and commits everything in it.
    fn commit_all(&self, folder: &Path) {
        for words in ["init --quiet", "add --all", "commit --quiet --message first"] {
            git(folder, words);
        }
    }

    /// The commit that the script finds in a package, and the files that it watches.
    fn found(&self, package: &Path, environment: &[(&str, &str)]) -> (String, Vec<PathBuf>) {
        let mut script = Command::new(self.folder.path().join("script"));
        script.current_dir(package).env("CARGO_MANIFEST_DIR", package).env("TARGET", "some-target");
        // No repository that holds the temporary folder counts.
        script.env("GIT_CEILING_DIRECTORIES", self.folder.path().canonicalize().unwrap());
        script.env_remove("STICKSLIP_COMMIT").envs(environment.iter().copied());
        let output = script.output().unwrap();
        assert!(output.status.success());
        let text = String::from_utf8(output.stdout).unwrap();
        assert!(text.contains("cargo::rustc-env=STICKSLIP_BUILD_TARGET=some-target\n"), "{text}");
        let of = |key: &str| -> Vec<String> {
            text.lines().filter_map(|line| line.strip_prefix(key)).map(str::to_owned).collect()
        };
        let [commit] = &of("cargo::rustc-env=STICKSLIP_BUILD_COMMIT=")[..] else { panic!("{text}") };
        let watched = of("cargo::rerun-if-changed=").iter().map(|path| package.join(path)).collect();
        (commit.clone(), watched)
    }
}

/// Whether there is git; in continuous integration there must be.
fn has_git() -> bool {
    let has_git = Command::new("git").arg("--version").output().is_ok();
    assert!(has_git || std::env::var_os("CI").is_none(), "there is no git");
    has_git
}

/// What git prints, as some author at some time.
fn git(folder: &Path, words: &str) -> String {
    let mut command = Command::new("git");
    command.args(["-c", "user.name=A", "-c", "user.email=a@example.org", "-c", "commit.gpgsign=false"]);
    command.args(words.split(' ')).current_dir(folder);
    command.env("GIT_COMMITTER_DATE", "2026-01-31T23:30:00+0100").env("GIT_AUTHOR_DATE", "2020-01-01T00:00:00+0000");
    let output = command.output().unwrap();
    assert!(output.status.success(), "git {words}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap().trim().to_owned()
}

/// What a commit without changes is called.
fn described(folder: &Path) -> String {
    format!("{} (2026-01-31)", &git(folder, "rev-parse HEAD")[..12])
}

/// The commit that is found, where every file that is watched exists.
#[track_caller]
fn commit(sources: &Sources, package: &Path) -> String {
    let (commit, watched) = sources.found(package, &[]);
    for path in watched {
        assert!(path.exists(), "{} is watched and does not exist, so that every build runs the script", path.display());
    }
    commit
}

#[test]
fn the_commit_is_that_of_the_sources() {
    if !has_git() {
        return;
    }
    let sources = Sources::new();
    let (root, package) = (sources.root(), sources.package());
    assert_eq!(commit(&sources, &package), "unknown", "without git");
    sources.commit_all(&root);
    assert_eq!(commit(&sources, &package), described(&root));

    fs::write(root.join("README.md"), "other words\n").unwrap();
    assert_eq!(commit(&sources, &package), described(&root), "the program is not made of its documents");
    fs::write(root.join("Cargo.toml"), "[workspace] # changed\n").unwrap();
    assert_eq!(commit(&sources, &package), described(&root) + ", with changes");
    git(&root, "commit --quiet --all --message second");
    assert_eq!(commit(&sources, &package), described(&root));

    assert_eq!(sources.found(&package, &[("STICKSLIP_COMMIT", " v1\nmore")]).0, "v1");
    assert_eq!(sources.found(&package, &[("STICKSLIP_COMMIT", "")]).0, described(&root));
    assert_eq!(sources.found(&package, &[("PATH", "/nowhere")]).0, "unknown", "without the program git");
}

#[test]
fn a_commit_is_noticed_wherever_git_keeps_it() {
    if !has_git() {
        return;
    }
    let sources = Sources::new();
    let (root, package) = (sources.root(), sources.package());
    sources.commit_all(&root);
    let tree = sources.folder.path().join("tree");
    git(&root, &format!("worktree add --quiet -b some/branch {}", tree.display()));
    let loose = (root.clone(), package.clone());
    let worktree = (tree.clone(), tree.join("crates/runner"));
    for (round, pack) in [false, true, true].into_iter().enumerate() {
        for (folder, package) in [&loose, &worktree] {
            if pack {
                git(folder, "pack-refs --all");
            }
            if round == 2 {
                git(folder, "config core.logAllRefUpdates false");
                let log = git(folder, "rev-parse --git-path logs/HEAD");
                fs::remove_file(folder.join(log)).unwrap();
            }
            assert_eq!(commit(&sources, package), described(folder));
            let watched = sources.found(package, &[]).1;
            let state = || watched.iter().map(|path| newest(path)).max().unwrap();
            let before = state();
            git(folder, "commit --quiet --allow-empty --message next");
            assert!(state() > before, "round {round}: no file that is watched has changed");
            assert_eq!(commit(&sources, package), described(folder));
        }
    }
}

/// The time of the newest change in a file or folder.
fn newest(path: &Path) -> std::time::SystemTime {
    let own = fs::metadata(path).unwrap().modified().unwrap();
    let inside = fs::read_dir(path).into_iter().flatten().map(|entry| newest(&entry.unwrap().path()));
    inside.fold(own, std::time::SystemTime::max)
}

#[test]
fn the_commit_of_another_repository_is_not_taken() {
    if !has_git() {
        return;
    }
    let sources = Sources::new();
    let (root, package) = (sources.root(), sources.package());
    // A copy in a folder of another repository, first as a part of it, then as files that it leaves out.
    let outer = sources.folder.path().join("outer");
    fs::create_dir(&outer).unwrap();
    fs::rename(&root, outer.join("copy")).unwrap();
    let inside = outer.join("copy/crates/runner");
    sources.commit_all(&outer);
    assert_eq!(commit(&sources, &inside), "unknown");
    fs::rename(outer.join("copy"), &root).unwrap();
    fs::write(root.join(".gitignore"), "/crates\n").unwrap();
    sources.commit_all(&root);
    assert_eq!(commit(&sources, &package), "unknown");
}
