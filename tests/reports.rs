//! Reports of finished runs.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so and stop")]

mod common;

use std::fs;

use common::{Place, Table, named_by, python_agrees, submitted};

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
    let Some(browser) = named_by("STICKSLIP_BROWSER") else { return };
    let place = Place::new();
    submitted(&place, "three", JOB);
    place.run("report three").done();
    let files = ["three/report.html", "three/surface.parquet"].map(|file| place.path(file).into_os_string());
    python_agrees("browser.py", [browser].into_iter().chain(files));
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

/// The numbers of cells in a sentence "P is below 1 % in A of N cells, below 5 % in B, below 50 % in C ...".
fn counts(answer: &str) -> [usize; 4] {
    let numbers = answer.split(|c: char| !c.is_ascii_digit()).filter_map(|word| word.parse().ok());
    let numbers: Vec<usize> = numbers.collect();
    // 1 %, A, N, 5 %, B, 50 %, C.
    assert!(numbers.len() >= 7 && [numbers[0], numbers[3], numbers[5]] == [1, 5, 50], "{answer}");
    [numbers[1], numbers[4], numbers[6], numbers[2]]
}

#[test]
fn the_answer_is_that_of_the_exact_surface() {
    let place = Place::new();
    let limits = [0.01, 0.05, 0.5];
    for job in 0..10 {
        let text = JOB
            .replace("12, 15, 18", &format!("{}, {}", 8 + 2 * job, 25 + job))
            .replace("relative_std = 0.2", &format!("relative_std = {}", 0.05 + 0.03 * f64::from(job)))
            .replace("seed = 1", &format!("seed = {job}"));
        let exact = text.replace("samples = 2000\n", "").replace("seed =", "method = \"exact\"\nseed =");
        place.write("exact.toml", &exact.replace("\"three\"", "\"exact\""));
        place.write("drawn.toml", &text);
        let told = |name: &str| {
            let out = place.run(&format!("submit {name}.toml --out {name}-{job}")).done().stdout;
            out[out.find("P is below").unwrap()..].lines().take(2).collect::<Vec<_>>().join(" ")
        };
        let (exactly, drawn) = (counts(&told("exact")), counts(&told("drawn")));
        let read = |name: &str| Table::read(&place.path(&format!("{name}-{job}/surface.parquet")));
        let (known, estimated) = (read("exact"), read("drawn"));
        for (i, limit) in limits.into_iter().enumerate() {
            let below = known.column("p_unstable").iter().filter(|p| **p < limit).count();
            assert_eq!(exactly[i], below, "job {job}, {limit}");
            let sure: Vec<usize> =
                (0..known.column("cell").len()).filter(|&cell| estimated.column("p_high")[cell] < limit).collect();
            assert_eq!(drawn[i], sure.len(), "job {job}, {limit}");
            // An upper end of a 95 % interval is too low in 2.5 % of the cells.
            let wrong = sure.iter().filter(|&&cell| known.column("p_unstable")[cell] >= limit).count();
            assert!(wrong <= 4, "job {job}, {limit}: {wrong} of {} cells", sure.len());
        }
        assert_eq!(exactly[3], 2 * 15 * 12);
    }
}
