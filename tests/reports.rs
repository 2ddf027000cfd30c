//! Reports of finished runs.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so and stop")]

mod common;

use std::env;
use std::fs;
use std::process::Command;

use common::{Place, repository, submitted};

/// A job with a sharp character in every text of its own.
const JOB: &str = r#"
name = "three"
description = "a < b & \"c\" </script>"
[axes]
rotating_speed = [12, 15, 18]
preload = { from = 0.02, to = 0.3, points = 15 }
static_friction = { from = 0.25, to = 0.5, points = 12 }
[random]
inputs = ["preload", "static_friction"]
relative_std = 0.2
[criterion]
kind = "eigenvalue"
[sampling]
samples = 2000
seed = 1
"#;

#[test]
fn a_report_is_one_file_with_the_answer_the_job_and_the_library() {
    let place = Place::new();
    submitted(&place, "three", JOB);
    assert_eq!(place.run("report three").done().stdout, "three/report.html\n");
    let page = fs::read_to_string(place.path("three/report.html")).unwrap();
    assert!(page.len() < 2_000_000, "{} bytes", page.len());
    for text in [
        "P is below 1 % in",
        "of 540 cells",
        "a &lt; b &amp; &quot;c&quot; &lt;/script&gt;",
        "plotly.js (cartesian - minified) v4.1.1",
        "plotly.js 4.1.1 (MIT licence",
        "stickslip submit three/job.toml",
        "kind = &quot;eigenvalue&quot;",
    ] {
        assert!(page.contains(text), "{text}");
    }
    assert!(!page.contains("{{"), "a place of the page without its part");
    for outside in ["src=\"http", "href=\"http", "url(http", "@import"] {
        let own = page.split("<script>").next().unwrap();
        assert!(!own.contains(outside), "{outside}");
    }
    // The same run gives the same bytes.
    place.run("report three --out again.html").done();
    assert_eq!(fs::read_to_string(place.path("again.html")).unwrap(), page);
}

#[test]
fn a_browser_shows_the_numbers_of_the_file() {
    let (Some(python), Some(browser)) = (env::var_os("STICKSLIP_PYTHON"), env::var_os("STICKSLIP_BROWSER")) else {
        assert!(env::var_os("CI").is_none(), "STICKSLIP_PYTHON or STICKSLIP_BROWSER is not set; run `make test`");
        return;
    };
    let place = Place::new();
    submitted(&place, "three", JOB);
    place.run("report three").done();
    let output = Command::new(python)
        .arg(repository().join("tests/browser.py"))
        .arg(browser)
        .args(["three/report.html", "three/surface.parquet"].map(|file| place.path(file)))
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    );
}

#[test]
fn a_run_over_one_axis_and_one_of_a_single_cell_have_reports_too() {
    let place = Place::new();
    for (name, preload) in [("line", "{ from = 0.02, to = 0.3, points = 15 }"), ("point", "0.1")] {
        let job = JOB
            .replace("[12, 15, 18]", "15")
            .replace("{ from = 0.25, to = 0.5, points = 12 }", "0.39")
            .replace("{ from = 0.02, to = 0.3, points = 15 }", preload)
            .replace("\"three\"", &format!("{name:?}"));
        submitted(&place, name, &job);
        place.run(&format!("report {name}")).done();
        let page = fs::read_to_string(place.path(&format!("{name}/report.html"))).unwrap();
        assert!(page.contains("P is below") || page.contains("P is not surely below"), "{name}");
    }
}

#[test]
fn what_has_no_report_is_said() {
    let place = Place::new();
    place.run("report nowhere").refused(74, &["nowhere is not a run directory"]);
    submitted(&place, "three", JOB);
    place.run("report three --out no/folder/report.html").refused(73, &["no/folder"]);
    fs::remove_file(place.path("three/surface.parquet")).unwrap();
    place.run("report three").refused(65, &["has no surface yet", "stickslip resume three"]);
}
