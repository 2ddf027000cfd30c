//! What versions promise: what `--version` prints and pages repeat, and that runs of other versions are read or refused
//! with the remedy, and nothing of them is lost.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so and stop")]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use crate::common::{Place, Table, change_piece, repository, surface_job};

/// What every refusal says.
const REMEDY: &str = "Submit the run's job.toml again into another directory with --out, or continue the run with the stickslip that began it";

/// The files of a folder and their bytes, without the lock, whose content belongs to no run.
fn contents(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    fn add(folder: &Path, inside: &Path, files: &mut BTreeMap<PathBuf, Vec<u8>>) {
        for entry in fs::read_dir(folder.join(inside)).unwrap() {
            let name = inside.join(entry.unwrap().file_name());
            if folder.join(&name).is_dir() {
                add(folder, &name, files);
            } else if name != Path::new("run.lock") {
                files.insert(name.clone(), fs::read(folder.join(&name)).unwrap());
            }
        }
    }
    let mut files = BTreeMap::new();
    add(folder, Path::new(""), &mut files);
    files
}

/// Commands that need the samples of a run. The others read its surface or its job alone.
const NEEDING_SAMPLES: [&str; 11] = [
    "status run",
    "resume run",
    "submit run/job.toml --out run",
    "submit run/job.toml --out run --samples 60000",
    "submit run/job.toml --out run --samples 60000 --shard 2/2",
    "submit run/job.toml --out run --shard 2/2",
    "merge run",
    "verify run",
    "compare run run",
    "samples run --cell 1",
    "replay run --cell 1 --sample 2",
];

/// A finished run, as `run`.
fn finished(job: &str) -> Place {
    let place = Place::new();
    place.write("job.toml", job);
    place.run("submit job.toml --out run").done();
    place
}

/// A job over a map that is integrated, so that its only pieces are tiles and audits.
fn integrated() -> String {
    let criterion = "kind = \"time-domain\"\ndisc = \"rigid\"\nstart = \"rest\"";
    let job = surface_job("run", 2, 100, 7).replace("kind = \"eigenvalue\"", criterion);
    job.replace("samples = 100", "method = \"exact\"")
}

/// What the footer of a surface says, without its schema.
fn footer(path: &Path) -> BTreeMap<String, String> {
    Table::read(path).footer.into_iter().collect()
}

/// Replaces the pieces in a folder by those of a version whose number is higher by one.
fn make_later(folder: &Path, version: &str) {
    for piece in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect::<Vec<_>>() {
        change_piece(&piece, |lines| {
            let number = &mut lines[0]["versions"][version];
            *number = (number.as_u64().unwrap() + 1).into();
        });
    }
}

/// Makes the surface of a run one that a version with other results identified.
fn make_surface_later(place: &Place) {
    let path = place.path("run/surface.parquet");
    let hash = footer(&path)["stickslip:job_hash"].clone();
    let mut bytes = fs::read(&path).unwrap();
    let places: Vec<usize> =
        (0..bytes.len() - hash.len()).filter(|&i| bytes[i..].starts_with(hash.as_bytes())).collect();
    assert!(!places.is_empty());
    places.iter().for_each(|&i| bytes[i..i + hash.len()].reverse());
    fs::write(path, bytes).unwrap();
    // Otherwise the surface is taken for damaged.
    fs::remove_file(place.path("run/digests.json")).unwrap();
}

#[test]
fn runs_of_another_version_are_refused_with_the_remedy_and_left_as_they_are() {
    for name in ["format", "results"] {
        let place = finished(&surface_job("run", 2, 100, 7));
        make_later(&place.path("run/shards"), &format!("{name} version"));
        let before = contents(&place.path("run"));
        let own = &printed()[&format!("{name} version")];
        let versions = format!("({name} version {}, where this one has {own})", own.parse::<u32>().unwrap() + 1);
        for command in NEEDING_SAMPLES {
            place.run(command).refused(65, &["was written by another version of stickslip", &versions, REMEDY]);
            assert_eq!(contents(&place.path("run")), before, "{name}: {command}");
        }
        let status = place.run("status .").done().stdout;
        assert!(status.contains("unreadable"), "{name}: {status}");
        place.run("submit run/job.toml --out again").done();
    }
}

#[test]
fn surfaces_of_another_version_are_read_and_not_replaced() {
    let sampled = surface_job("run", 2, 100, 7);
    for job in [&sampled, &sampled.replace("samples = 100", "method = \"exact\"")] {
        let place = finished(job);
        make_surface_later(&place);
        let before = contents(&place.path("run"));
        for command in ["plot run --out p.svg", "export run --format json --out s.json", "report run --out r.html"] {
            let outcome = place.run(command).done();
            assert!(outcome.stderr.contains("computed by another version of stickslip"), "{}", outcome.stderr);
        }
        for command in ["status run", "resume run", "submit run/job.toml --out run", "merge run", "verify run"] {
            place.run(command).refused(65, &["surface.parquet was written by another version of stickslip", REMEDY]);
            assert_eq!(contents(&place.path("run")), before, "{command}");
        }
    }
}

#[test]
fn maps_and_audits_of_another_version_are_not_used() {
    let place = finished(&integrated());
    make_surface_later(&place);
    fs::remove_dir_all(place.path("run/map")).unwrap();
    place.run("plot run --of verdicts").refused(65, &["tiles are missing", "of another version of stickslip", REMEDY]);
    // They are refused before a map is resolved.
    fs::remove_file(place.path("run/surface.parquet")).unwrap();
    make_later(&place.path("run/audit"), "results version");
    let before = contents(&place.path("run"));
    for command in ["resume run", "submit run/job.toml --out run"] {
        place.run(command).refused(65, &["was written by another version of stickslip", REMEDY]);
        assert_eq!(contents(&place.path("run")), before, "{command}");
    }
}

/// What `--version` prints, by name.
fn printed() -> BTreeMap<String, String> {
    let text = Place::new().run("--version").done().stdout;
    let lines = text.lines().skip(1).map(|line| line.split_once(": ").unwrap());
    lines.map(|(name, value)| (name.to_owned(), value.to_owned())).collect()
}

#[test]
fn the_version_is_printed_in_short_and_in_full() {
    let place = Place::new();
    let version = format!("stickslip {}", env!("CARGO_PKG_VERSION"));
    assert_eq!(place.run("-V").done().stdout, format!("{version}\n"));
    let full = place.run("--version").done().stdout;
    assert_eq!(full.lines().next(), Some(&version[..]));
    let names: Vec<&str> = full.lines().skip(1).map(|line| line.split_once(": ").unwrap().0).collect();
    let expected = ["commit", "target", "instruction set", "results version", "format version", "licence"];
    assert_eq!(names, expected, "scripts read these lines; later ones come after");

    let printed = printed();
    assert!(printed["target"].contains(std::env::consts::ARCH), "{}", printed["target"]);
    let sets: &[&str] = match std::env::consts::ARCH {
        "x86_64" => &["SSE2", "AVX2", "AVX-512"],
        "aarch64" => &["NEON"],
        _ => &["baseline"],
    };
    assert!(sets.contains(&&printed["instruction set"][..]), "{}", printed["instruction set"]);
    let manual = place.run("man").done().stdout;
    assert!(manual.contains(".SH VERSION\nv0.1.0"), "the manual is the same on every machine");
}

#[test]
fn the_instruction_set_is_that_of_the_processor() {
    let Ok(processor) = fs::read_to_string("/proc/cpuinfo") else { return };
    let has = |flag: &str| processor.split_whitespace().any(|word| word == flag);
    let expected = match std::env::consts::ARCH {
        "x86_64" if has("avx512f") && has("avx512dq") => "AVX-512",
        "x86_64" if has("avx2") => "AVX2",
        "x86_64" => "SSE2",
        "aarch64" => "NEON",
        _ => return,
    };
    assert_eq!(printed()["instruction set"], expected);
}

#[test]
fn sessions_record_the_build_and_results_do_not() {
    let place = finished(&surface_job("run", 2, 100, 7));
    place.run("submit run/job.toml --out run --samples 4000").done();
    let record: serde_json::Value = serde_json::from_slice(&fs::read(place.path("run/run.json")).unwrap()).unwrap();
    let printed = printed();
    for session in record["sessions"].as_array().unwrap() {
        for (key, name) in [("commit", "commit"), ("target", "target"), ("instruction_set", "instruction set")] {
            assert_eq!(session[key], *printed[name], "{session}");
        }
    }
    place.run("report run").done();
    let report = fs::read_to_string(place.path("run/report.html")).unwrap();
    let program = format!(
        "stickslip {}, commit {}, {}, {}<",
        env!("CARGO_PKG_VERSION"),
        printed["commit"],
        printed["target"],
        printed["instruction set"]
    );
    assert_eq!(report.matches(&program).count(), 1, "{program}");

    let keys: Vec<String> = footer(&place.path("run/surface.parquet")).into_keys().collect();
    let of_the_job = ["engine_version", "job", "job_hash", "results_version", "seed"];
    assert_eq!(keys, of_the_job.map(|key| format!("stickslip:{key}")), "nothing that differs between two machines");
}

#[test]
fn the_pages_have_the_versions_of_the_program() {
    let page = fs::read_to_string(repository().join("docs/reference/versions.md")).unwrap();
    let printed = printed();
    for name in ["results version", "format version"] {
        let row = format!("| {name} | {} |", printed[name]);
        assert!(page.contains(&row), "docs/reference/versions.md has no line that begins with {row:?}");
    }
    let row = format!("| version of the program | {} |", env!("CARGO_PKG_VERSION"));
    assert!(page.contains(&row), "docs/reference/versions.md has no line that begins with {row:?}");

    let changes = fs::read_to_string(repository().join("CHANGELOG.md")).unwrap();
    let headings: Vec<&str> = changes.lines().filter_map(|line| line.strip_prefix("## ")).collect();
    let own = format!("[{}]", env!("CARGO_PKG_VERSION"));
    assert!(headings.iter().any(|heading| heading.starts_with(&own)), "CHANGELOG.md has no entry {own}: {headings:?}");
    let entry = changes.split(&format!("## {own}")).nth(1).unwrap().split("\n## ").next().unwrap().replace('\n', " ");
    for name in ["results version", "format version"] {
        let named = format!("{name} {}", printed[name]);
        assert!(entry.to_lowercase().contains(&named), "CHANGELOG.md does not name {named} in the entry {own}");
    }
    let citation = fs::read_to_string(repository().join("CITATION.cff")).unwrap();
    assert!(citation.contains(&format!("\nversion: {}\n", env!("CARGO_PKG_VERSION"))), "CITATION.cff");
}
