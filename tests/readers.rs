//! Reading the files with pandas, polars, DuckDB and pyarrow.
//!
//! `make test` sets up a Python environment and names it in STICKSLIP_PYTHON. Without it, as on a machine without
//! Python, the test does nothing; in continuous integration it then fails.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so and stop")]

mod common;

use std::process::Command;

use common::{Place, repository};

#[test]
fn python_readers_read_what_the_documents_describe() {
    let Some(python) = std::env::var_os("STICKSLIP_PYTHON") else {
        assert!(std::env::var_os("CI").is_none(), "STICKSLIP_PYTHON is not set; run `make test`");
        return;
    };
    let place = Place::new();
    place.run(&format!("submit {}", repository().join("jobs/fig14a.toml").display())).done();
    let output = Command::new(python)
        .arg(repository().join("tests/readers.py"))
        .arg(place.path("runs/fig14a/surface.parquet"))
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
}
