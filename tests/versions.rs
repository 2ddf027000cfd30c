//! What versions promise: what `--version` tells and pages repeat, that runs of earlier and later versions are read or
//! refused with the remedy, and that nothing of them is lost. `tests/data/runs/README.md` says where the runs come from.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so and stop")]

mod common;

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::path::{Path, PathBuf};

use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader as _, SerializedFileReader};

use common::{Place, Table, repository, surface_job};

/// The formats of runs that were kept, with the runs of each that this version continues, and those that it refuses.
const FORMATS: [(&str, &[&str], &[&str]); 3] = [
    ("identity-1", &[], &["eigenvalue", "eigenvalue-part", "exact", "verdict-map", "time-domain-part"]),
    ("verdicts-3", &["eigenvalue", "eigenvalue-part", "exact"], &["verdict-map", "time-domain-part"]),
    ("verdicts-4", &["eigenvalue", "eigenvalue-part", "exact", "verdict-map", "time-domain", "time-domain-part"], &[]),
];

/// What every refusal says.
const REMEDY: &str = "Submit the run's job.toml again into another directory with --out, or continue the run with the stickslip that began it";

/// A kept run.
fn kept(format: &str, run: &str) -> PathBuf {
    repository().join("tests/data/runs").join(format).join(run)
}

/// A copy of a kept run, as `run`.
fn copied(format: &str, run: &str) -> Place {
    let place = Place::new();
    for (name, bytes) in contents(&kept(format, run)) {
        let path = place.path("run").join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    }
    // That of an integrated run is empty, and repositories keep no empty folders.
    fs::create_dir_all(place.path("run/shards")).unwrap();
    place
}

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
const NEEDING_SAMPLES: [&str; 12] = [
    "status run",
    "resume run",
    "submit run/job.toml --out run",
    "submit run/job.toml --out run --seed 11",
    "submit run/job.toml --out run --samples 60000",
    "submit run/job.toml --out run --samples 60000 --shard 2/2",
    "submit run/job.toml --out run --shard 2/2",
    "merge run",
    "verify run",
    "compare run run",
    "samples run --cell 1",
    "replay run --cell 1 --sample 2",
];

#[test]
fn every_kept_run_is_tried() {
    for (format, continued, refused) in FORMATS {
        let there = fs::read_dir(kept(format, "")).unwrap().map(|entry| entry.unwrap().file_name());
        let there: BTreeSet<String> = there.map(|name| name.into_string().unwrap()).collect();
        assert_eq!(there, continued.iter().chain(refused).map(|&run| run.to_owned()).collect(), "{format}");
    }
}

#[test]
fn surfaces_of_earlier_versions_are_drawn_and_exported_as_they_are() {
    for (format, continued, refused) in FORMATS {
        for run in continued.iter().chain(refused).filter(|run| !run.ends_with("-part")) {
            let place = copied(format, run);
            let before = contents(&place.path("run"));
            for command in ["plot run --out p.svg", "export run --format csv --out s.csv", "report run --out r.html"] {
                let outcome = place.run(command).done();
                let is_told = outcome.stderr.contains("computed by another version of stickslip");
                assert_eq!(is_told, refused.contains(run), "{format} {run}: {}", outcome.stderr);
            }
            assert_eq!(contents(&place.path("run")), before, "{format} {run}");
            assert!(fs::read_to_string(place.path("r.html")).unwrap().contains("stickslip 0.1.0"));
            let mut csv = csv::Reader::from_path(place.path("s.csv")).unwrap();
            let column = csv.headers().unwrap().iter().position(|name| name == "p_unstable").unwrap();
            let exported: Vec<f64> = csv.records().map(|row| row.unwrap()[column].parse().unwrap()).collect();
            assert_eq!(
                exported,
                Table::read(&place.path("run/surface.parquet")).column("p_unstable"),
                "{format} {run}"
            );
        }
    }
}

#[test]
fn runs_of_other_versions_are_refused_with_the_remedy_and_left_as_they_are() {
    for (format, _, refused) in FORMATS {
        let [found, own] = match format {
            "identity-1" => ["identity version 1, ", "this one has 2"],
            _ => ["verdicts version 3, ", "this one has 4"],
        };
        for run in refused {
            let place = copied(format, run);
            let before = contents(&place.path("run"));
            // An integrated run has its surface alone, which does not name all versions; it has no number of samples.
            let is_integrated = *run == "exact";
            let versions = if is_integrated { ["another version", "stickslip --version"] } else { [found, own] };
            for command in NEEDING_SAMPLES.iter().filter(|command| !is_integrated || !command.contains("00")) {
                if is_integrated && command.contains("shard") {
                    continue;
                }
                place.run(command).refused(65, &[REMEDY, versions[0], versions[1]]);
                assert_eq!(contents(&place.path("run")), before, "{format} {run}: {command}");
            }
            let status = place.run("status .").done().stdout;
            assert!(status.contains("unreadable"), "{format} {run}: {status}");
            if *run != "verdict-map" {
                place.run("submit run/job.toml --out again").done();
            }
        }
    }
}

#[test]
fn unfinished_runs_of_other_versions_have_no_surface_to_read() {
    for command in ["plot run", "export run --format csv", "report run"] {
        let place = copied("identity-1", "eigenvalue-part");
        let before = contents(&place.path("run"));
        place.run(command).refused(65, &["has no surface yet", "stickslip resume run"]);
        assert_eq!(contents(&place.path("run")), before);
    }
}

#[test]
fn maps_of_other_versions_are_not_drawn_and_not_used() {
    for format in ["identity-1", "verdicts-3"] {
        let place = copied(format, "verdict-map");
        place.run("plot run --of verdicts").refused(65, &["5 of 5 tiles", "of another version of stickslip", REMEDY]);
        let reported = place.run("report run --out r.html").done();
        assert!(reported.stderr.contains("the report shows no verdict map of run"), "{}", reported.stderr);
    }
    let place = copied("verdicts-3", "verdict-map");
    let again = place.run("submit run/job.toml --out again --map run").done();
    assert!(again.stderr.contains("it has no tile of this model"), "{}", again.stderr);
    let whole = fs::read(kept("verdicts-4", "verdict-map/surface.parquet")).unwrap();
    assert!(place.surface("again") == whole, "another surface than with a map of its own");
    copied("verdicts-4", "verdict-map").run("plot run --of verdicts").done();
}

#[test]
fn runs_of_agreeing_versions_go_on_to_the_bytes_that_they_would_have_had() {
    for (format, continued, _) in FORMATS {
        for run in continued {
            let whole = fs::read(kept(format, run.trim_end_matches("-part")).join("surface.parquet")).unwrap();
            let is_part = run.ends_with("-part");
            let place = copied(format, run);
            let status = place.run("status run").done().stdout;
            assert!(status.contains(if is_part { "unfinished, 50.0 %" } else { "finished, 100.0 %" }), "{status}");
            place.run("verify run").done();
            place.run("resume run").done();
            assert!(place.surface("run") == whole, "{format} {run}");
            if *run != "exact" {
                place.run("merge run").done();
                assert!(place.surface("run") == whole, "{format} {run}");
            }
            place.run("verify run").done();
        }
        for run in continued.iter().filter(|run| run.ends_with("-part")) {
            let place = copied(format, run);
            place.run("submit run/job.toml --out run --shard 2/2").done();
            place.run("merge run").done();
            let whole = fs::read(kept(format, run.trim_end_matches("-part")).join("surface.parquet")).unwrap();
            assert!(place.surface("run") == whole, "{format} {run}");
        }
        if continued.contains(&"eigenvalue") {
            let place = copied(format, "eigenvalue");
            place.run("submit run/job.toml --out more --samples 60000").done();
            place.run("submit run/job.toml --out run --samples 60000").done();
            assert!(place.surface("run") == place.surface("more"), "{format}");
        }
    }
}

#[test]
fn limits_and_comparisons_of_what_two_versions_share_are_found() {
    let place = copied("identity-1", "eigenvalue");
    let limits = place.run("limit run --of preload --probability 0.5").done().stdout;
    let job = fs::read_to_string(kept("verdicts-4", "eigenvalue/job.toml")).unwrap();
    place.write("job.toml", &job);
    assert_eq!(limits, place.run("limit job.toml --of preload --probability 0.5").done().stdout);

    let place = copied("verdicts-3", "eigenvalue");
    let other = kept("verdicts-4", "eigenvalue");
    let compared = place.run(&format!("compare run {}", other.display())).done().stdout;
    assert!(compared.contains("mean difference   +0.00000"), "{compared}");
}

/// The bytes of a Parquet file whose footer is changed.
fn with_footer(path: &Path, change: impl Fn(&mut BTreeMap<String, String>)) -> Vec<u8> {
    let builder = ParquetRecordBatchReaderBuilder::try_new(File::open(path).unwrap()).unwrap();
    let mut footer = footer(path);
    change(&mut footer);
    let pairs = footer.into_iter().map(|(key, value)| KeyValue::new(key, value)).collect();
    let properties = WriterProperties::builder().set_key_value_metadata(Some(pairs)).build();
    let mut writer = ArrowWriter::try_new(Vec::new(), builder.schema().clone(), Some(properties)).unwrap();
    for batch in builder.build().unwrap() {
        writer.write(&batch.unwrap()).unwrap();
    }
    writer.into_inner().unwrap()
}

/// What the footer of a Parquet file says, without its schema.
fn footer(path: &Path) -> BTreeMap<String, String> {
    let reader = SerializedFileReader::new(File::open(path).unwrap()).unwrap();
    let pairs = reader.metadata().file_metadata().key_value_metadata().unwrap().iter();
    let ours = pairs.filter(|pair| pair.key.starts_with("stickslip:"));
    ours.map(|pair| (pair.key.clone(), pair.value.clone().unwrap())).collect()
}

/// The only piece in a folder.
fn only_piece(folder: &Path) -> PathBuf {
    let mut pieces = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let piece = pieces.next().unwrap();
    assert!(pieces.next().is_none());
    piece
}

/// Replaces the only piece in a folder by one of a version that is later in what one key of its footer counts.
fn make_later(folder: &Path, key: &str) -> u32 {
    let piece = only_piece(folder);
    let version = footer(&piece)[key].parse::<u32>().unwrap();
    let bytes = with_footer(&piece, |footer| {
        footer.insert("stickslip:experiment".to_owned(), "as a later version identifies it".to_owned());
        footer.insert(key.to_owned(), (version + 1).to_string());
    });
    fs::remove_file(&piece).unwrap();
    fs::write(folder.join(format!("{}.parquet", &blake3::hash(&bytes).to_hex()[..32])), bytes).unwrap();
    version
}

#[test]
fn runs_of_a_later_version_are_refused_with_the_remedy_and_left_as_they_are() {
    for name in ["identity", "results", "verdicts", "estimates", "map"] {
        let place = Place::new();
        place.write("job.toml", &surface_job("run", 2, 100, 7));
        place.run("submit job.toml --out run").done();
        let own = make_later(&place.path("run/shards"), &format!("stickslip:{name}_version"));
        let before = contents(&place.path("run"));
        let versions = format!("{name} version {}, where this one has {own}", own + 1);
        for command in NEEDING_SAMPLES.iter().filter(|command| !command.contains("--seed")) {
            place.run(command).refused(65, &["was written by a later version of stickslip", &versions, REMEDY]);
            assert_eq!(contents(&place.path("run")), before, "{name}: {command}");
        }
    }
}

#[test]
fn surfaces_of_a_later_version_are_read_and_not_replaced() {
    for run in ["eigenvalue", "exact"] {
        let place = copied("verdicts-4", run);
        let surface = place.path("run/surface.parquet");
        let later = with_footer(&surface, |footer| {
            footer.insert("stickslip:job_hash".to_owned(), "as a later version identifies it".to_owned());
            footer.insert("stickslip:engine_version".to_owned(), "9.0.0".to_owned());
        });
        fs::write(&surface, later).unwrap();
        let before = contents(&place.path("run"));
        for command in ["plot run --out p.svg", "export run --format json --out s.json", "report run --out r.html"] {
            let outcome = place.run(command).done();
            assert!(outcome.stderr.contains("computed by another version of stickslip"), "{}", outcome.stderr);
        }
        for command in ["status run", "resume run", "submit run/job.toml --out run", "merge run", "verify run"] {
            place.run(command).refused(65, &["surface.parquet was written by another version of stickslip", REMEDY]);
            assert_eq!(contents(&place.path("run")), before, "{run}: {command}");
        }
    }
}

#[test]
fn audits_of_a_later_version_are_refused_before_a_map_is_resolved() {
    let place = Place::new();
    let job = fs::read_to_string(kept("verdicts-4", "verdict-map/job.toml")).unwrap();
    place.write("job.toml", &job.replace("samples = 20_000\nseed = 11\nevaluate = \"boundary\"", "method = \"exact\""));
    place.run("submit job.toml --out run").done();
    fs::remove_file(place.path("run/surface.parquet")).unwrap();
    fs::remove_dir_all(place.path("run/map")).unwrap();
    make_later(&place.path("run/audit"), "stickslip:verdicts_version");
    let before = contents(&place.path("run"));
    for command in ["resume run", "submit run/job.toml --out run"] {
        place.run(command).refused(65, &["was written by a later version of stickslip", REMEDY]);
        assert_eq!(contents(&place.path("run")), before, "{command}");
    }
}

/// What `--version` tells, by name.
fn told() -> BTreeMap<String, String> {
    let text = Place::new().run("--version").done().stdout;
    let lines = text.lines().skip(1).map(|line| line.split_once(": ").unwrap());
    lines.map(|(name, value)| (name.to_owned(), value.to_owned())).collect()
}

#[test]
fn the_version_is_told_in_short_and_in_full() {
    let place = Place::new();
    let version = format!("stickslip {}", env!("CARGO_PKG_VERSION"));
    assert_eq!(place.run("-V").done().stdout, format!("{version}\n"));
    let full = place.run("--version").done().stdout;
    assert_eq!(full.lines().next(), Some(&version[..]));
    let names: Vec<&str> = full.lines().skip(1).map(|line| line.split_once(": ").unwrap().0).collect();
    let expected = [
        "commit",
        "target",
        "instruction set",
        "results version",
        "verdicts version",
        "estimates version",
        "identity version",
        "licence",
    ];
    assert_eq!(names, expected, "scripts read these lines; later ones come after");

    let told = told();
    assert!(told["target"].contains(std::env::consts::ARCH), "{}", told["target"]);
    let sets: &[&str] = match std::env::consts::ARCH {
        "x86_64" => &["SSE2", "AVX2", "AVX-512"],
        "aarch64" => &["NEON"],
        _ => &["baseline"],
    };
    assert!(sets.contains(&&told["instruction set"][..]), "{}", told["instruction set"]);
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
    assert_eq!(told()["instruction set"], expected);
}

#[test]
fn sessions_tell_the_build_and_results_do_not() {
    let place = copied("verdicts-4", "eigenvalue-part");
    place.run("resume run").done();
    place.run("submit run/job.toml --out run --samples 4000").done();
    let record: serde_json::Value = serde_json::from_slice(&fs::read(place.path("run/run.json")).unwrap()).unwrap();
    let told = told();
    for session in record["sessions"].as_array().unwrap() {
        for (key, name) in [("commit", "commit"), ("target", "target"), ("instruction_set", "instruction set")] {
            assert_eq!(session[key], *told[name], "{session}");
        }
    }
    place.run("report run").done();
    let report = fs::read_to_string(place.path("run/report.html")).unwrap();
    let program = format!(
        "stickslip {}, commit {}, {}, {}<",
        env!("CARGO_PKG_VERSION"),
        told["commit"],
        told["target"],
        told["instruction set"]
    );
    assert_eq!(report.matches(&program).count(), 1, "{program}");

    let keys: Vec<String> = footer(&place.path("run/surface.parquet")).into_keys().collect();
    let of_the_job = ["engine_version", "job", "job_hash", "results_version", "seed"];
    assert_eq!(keys, of_the_job.map(|key| format!("stickslip:{key}")), "nothing that differs between two machines");
    // Sessions of earlier programs, which do not tell their build, stay as they are.
    let place = copied("verdicts-4", "eigenvalue");
    let first = |place: &Place| {
        let record: serde_json::Value = serde_json::from_slice(&fs::read(place.path("run/run.json")).unwrap()).unwrap();
        record["sessions"][0].clone()
    };
    let before = first(&place);
    place.run("submit run/job.toml --out run --samples 4000").done();
    assert_eq!(first(&place), before);
}

#[test]
fn the_pages_have_the_versions_of_the_program() {
    let page = fs::read_to_string(repository().join("docs/reference/versions.md")).unwrap();
    let told = told();
    for name in ["results version", "verdicts version", "estimates version", "identity version"] {
        let row = format!("| {name} | {} |", told[name]);
        assert!(page.contains(&row), "docs/reference/versions.md has no line that begins with {row:?}");
    }
    let row = format!("| version of the program | {} |", env!("CARGO_PKG_VERSION"));
    assert!(page.contains(&row), "docs/reference/versions.md has no line that begins with {row:?}");

    // That of maps is of no use in scripts, and only in pieces.
    let place = Place::new();
    place.write("job.toml", &surface_job("run", 2, 100, 7));
    place.run("submit job.toml --out run").done();
    let of_piece = footer(&only_piece(&place.path("run/shards")));
    assert!(page.contains(&format!("| map version | {} |", of_piece["stickslip:map_version"])));
    for name in ["results", "verdicts", "estimates", "identity"] {
        assert_eq!(of_piece[&format!("stickslip:{name}_version")], told[&format!("{name} version")]);
    }

    let changes = fs::read_to_string(repository().join("CHANGELOG.md")).unwrap();
    let headings: Vec<&str> = changes.lines().filter_map(|line| line.strip_prefix("## ")).collect();
    let own = format!("[{}]", env!("CARGO_PKG_VERSION"));
    assert!(headings.iter().any(|heading| heading.starts_with(&own)), "CHANGELOG.md has no entry {own}: {headings:?}");
    let entry = changes.split(&format!("## {own}")).nth(1).unwrap().split("\n## ").next().unwrap().replace('\n', " ");
    for name in ["results version", "verdicts version", "estimates version", "identity version"] {
        let named = format!("{name} {}", told[name]);
        assert!(entry.to_lowercase().contains(&named), "CHANGELOG.md does not name {named} in the entry {own}");
    }
    let citation = fs::read_to_string(repository().join("CITATION.cff")).unwrap();
    assert!(citation.contains(&format!("\nversion: {}\n", env!("CARGO_PKG_VERSION"))), "CITATION.cff");
}
