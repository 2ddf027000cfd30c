//! Reading the files with pandas, polars, DuckDB, pyarrow, xarray and GNU Octave.
//!
//! `make test` sets up a Python environment and names it in STICKSLIP_PYTHON. Without it, as on a machine without
//! Python, the test does nothing; in continuous integration it then fails. The same holds for Octave, which reads the MAT
//! file where `octave-cli` is on the path.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so and stop")]

use std::io::Write as _;
use std::process::Command;

use crate::common::{Place, assert_succeeds, python_agrees, repository, submitted};

#[test]
fn python_readers_read_what_the_documents_describe() {
    let place = Place::new();
    place.run(&format!("submit {}", repository().join("jobs/fig14a.toml").display())).done();
    place.run("samples runs/fig14a --cell 400").done();
    python_agrees(
        "readers.py",
        ["surface.parquet", "samples-400.parquet"].map(|file| place.path("runs/fig14a").join(file)),
    );
}

/// A grid with more than one value on four axes.
const GRID: &str = "name = \"grid\"\n[axes]\n\"pad.mass\" = [0.8, 1.0]\nrotating_speed = [12.0, 15.0]\n\
    preload = [0.05, 0.1, 0.3]\nstatic_friction = [0.3, 0.35, 0.4, 0.45]\n[random]\n\
    inputs = [\"preload\", \"static_friction\"]\nrelative_std = 0.2\n[criterion]\nkind = \"eigenvalue\"\n\
    [sampling]\nsamples = 200\nseed = 1\n";

#[test]
fn octave_reads_the_mat_file() {
    if Command::new("octave-cli").arg("--version").output().is_err() {
        assert!(std::env::var_os("CI").is_none(), "octave-cli is not on the path");
        // Not through `eprintln`, which the harness captures.
        let _ = writeln!(std::io::stderr(), "note: no octave-cli, the test of the MAT file in Octave is left out");
        return;
    }
    let place = Place::new();
    submitted(&place, "grid", GRID);
    for format in ["mat", "csv"] {
        place.run(&format!("export grid --format {format}")).done();
    }
    let mut octave = Command::new("octave-cli");
    octave.args(["--quiet", "--no-init-file"]).arg(repository().join("tests/readers.m"));
    assert_succeeds(octave.args(["mat", "csv"].map(|format| place.path("grid").join(format!("surface.{format}")))));
}
