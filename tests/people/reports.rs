//! Reports of finished runs, and the gallery of what is reproduced of the paper.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so and stop")]

use std::fs;

use crate::common::{Place, Table, named_by, python_agrees, submitted};
use serde_json::Value;

/// A job with a sharp character in every text of its own.
const JOB: &str = r#"
name = "three"
description = "a < b & \"c\" {{data}} </script>"
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
        "P, the probability of instability: 0.0",
        "in 540 cells.",
        "a &lt; b &amp; &quot;c&quot; {{data}} &lt;/script&gt;",
        "plotly.js (cartesian - minified) v4.1.1",
        "plotly.js 4.1.1 (MIT licence",
        "stickslip submit three/job.toml",
        "kind = &quot;eigenvalue&quot;",
    ] {
        assert!(page.contains(text), "{text}");
    }
    assert_eq!(page.matches("{{").count(), 2, "a place of the page without its part");
    for outside in ["src=\"http", "href=\"http", "url(http", "@import"] {
        let own = page.split("<script>").next().unwrap();
        assert!(!own.contains(outside), "{outside}");
    }
    // The same run gives the same bytes.
    place.run("report three --out again.html").done();
    assert_eq!(fs::read_to_string(place.path("again.html")).unwrap(), page);
}

/// A thin ring, which more disc modes than a job may keep would bend further.
const RING: &str = r#"
name = "ring"
[model]
disc = { thickness = 0.002, inner_radius = 0.075, outer_radius = 0.090 }
pad = { inner_radius = 0.078 }
[axes]
rotating_speed = 15
preload = 0.1
static_friction = { from = 0.3, to = 0.5, points = 3 }
[random]
inputs = ["preload", "static_friction"]
relative_std = 0.1
[criterion]
kind = "coupled-eigenvalue"
[sampling]
samples = 50
seed = 1
"#;

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn a_report_warns_of_what_check_warns_of() {
    let place = Place::new();
    submitted(&place, "ring", RING);
    place.run("report ring").done();
    let page = fs::read_to_string(place.path("ring/report.html")).unwrap();
    assert!(page.contains("<p class=\"warning\">Warning: 24 disc modes: growth rate"), "no warning in the report");
    assert!(page.contains("an error remains in results"), "no error in the warning");
}

/// A small job with Sobol indices, and another that differs from it in its damping.
const DRAWN: &str = r#"
name = "drawn"
[axes]
rotating_speed = 15
preload = { from = 0.02, to = 0.3, points = 8 }
static_friction = { from = 0.25, to = 0.5, points = 9 }
[random]
inputs = ["preload", "static_friction", "damping.tangential"]
relative_std = 0.1
[criterion]
kind = "eigenvalue"
[sampling]
samples = 400
sensitivity = true
seed = 1
"#;

#[test]
fn a_browser_shows_the_numbers_of_the_files() {
    let Some(browser) = named_by("STICKSLIP_BROWSER") else { return };
    let place = Place::new();
    submitted(&place, "three", JOB);
    place.run("report three").done();
    submitted(&place, "drawn", DRAWN);
    submitted(&place, "other", &DRAWN.replace("[axes]", "[model.damping]\ntangential = 800.0\n[axes]"));
    place.run("report drawn other --out two.html").done();
    place.run("compare drawn other --out differences.parquet").done();
    let files =
        ["three/report.html", "three/surface.parquet", "two.html", "drawn/surface.parquet", "differences.parquet"];
    let files = files.map(|file| place.path(file).into_os_string());
    python_agrees("browser.py", [browser].into_iter().chain(files));
}

/// What the script of a report draws.
fn data(page: &str) -> Value {
    let start = "<script id=\"data\" type=\"application/json\">";
    let data = &page[page.find(start).unwrap() + start.len()..];
    serde_json::from_str(&data[..data.find("</script>").unwrap()]).unwrap()
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn the_expected_brake_of_a_cell_is_that_of_analyse() {
    let place = Place::new();
    for (name, criterion, rate) in [
        ("rigid", "kind = \"eigenvalue\"", "growth_rate_per_s"),
        ("flexible", "kind = \"coupled-eigenvalue\"", "coupled_growth_rate_per_s"),
    ] {
        let axes = "preload = [0.05, 0.1, 0.25]\nstatic_friction = [0.3, 0.45]";
        let job = format!(
            "name = {name:?}\n[axes]\nrotating_speed = [10, 25]\n{axes}\n[random]\ninputs = [\"preload\"]\nrelative_std = 0.1\n[criterion]\n{criterion}\n[sampling]\nsamples = 10\nseed = 1\n"
        );
        submitted(&place, name, &job);
        place.run(&format!("report {name}")).done();
        let run = &data(&fs::read_to_string(place.path(&format!("{name}/report.html"))).unwrap())["runs"][0];
        let table = Table::read(&place.path(&format!("{name}/surface.parquet")));
        let mut cycles = 0;
        for cell in 0..12 {
            let of = |column| table.column(column)[cell];
            let (speed, preload, friction) = (of("rotating_speed_rad_s"), of("preload"), of("static_friction"));
            let analysis: Value = serde_json::from_str(
                &place
                    .run(&format!(
                        "analyse --json --set operating_point.rotating_speed={speed} --set \
                         operating_point.preload={preload} --set friction.static_coefficient={friction}"
                    ))
                    .done()
                    .stdout,
            )
            .unwrap();
            let shown = |column: &str| run["expected"][column][cell].as_f64();
            let close = |shown: Option<f64>, known: Option<f64>| match (shown, known) {
                (Some(shown), Some(known)) => assert!((shown - known).abs() <= 1e-5 * known.abs(), "{shown} {known}"),
                both => assert_eq!(both, (None, None)),
            };
            close(shown("growth_rate"), analysis[rate].as_f64());
            let cycle = &analysis["limit_cycle"];
            let half = |high: f64| Some(0.5 * (high - cycle["x_min_mm"].as_f64()?));
            close(shown("amplitude_mm"), cycle["x_max_mm"].as_f64().and_then(half));
            close(shown("frequency_hz"), cycle["frequency_hz"].as_f64());
            close(shown("stick"), cycle["stick_fraction"].as_f64());
            cycles += usize::from(shown("stick").is_some());
        }
        assert!(0 < cycles && cycles < 12, "{cycles} cells have a limit cycle");
    }
}

#[test]
fn a_run_with_a_verdict_map_shows_it() {
    let place = Place::new();
    let job = "name = \"mapped\"\n[axes]\nrotating_speed = 20\npreload = [0.05, 0.1]\nstatic_friction = [0.3, 0.4]\n[random]\ninputs = [\"preload\", \"static_friction\"]\nrelative_std = 0.05\n[criterion]\nkind = \"time-domain\"\ndisc = \"rigid\"\n[sampling]\nmethod = \"exact\"\naudit = 10\n";
    submitted(&place, "mapped", job);
    place.run("report mapped").done();
    let page = fs::read_to_string(place.path("mapped/report.html")).unwrap();
    let map = &page[page.find("<h2 id=\"verdicts-heading\">Verdict map</h2>").unwrap()..];
    assert!(map.contains("<svg role=\"img\" aria-label=\"Map of the verdicts") && map.contains(">unstable<"));
    submitted(&place, "drawn", DRAWN);
    place.run("report drawn").done();
    assert!(!fs::read_to_string(place.path("drawn/report.html")).unwrap().contains("verdicts-heading"));
}

#[test]
fn runs_that_share_no_cell_stand_beside_each_other() {
    let place = Place::new();
    submitted(&place, "three", JOB);
    submitted(&place, "drawn", DRAWN);
    let said = place.run("report three drawn").done();
    assert_eq!(said.stdout, "report.html\n");
    assert!(said.stderr.contains("without a comparison: three and drawn have no cell in common"), "{}", said.stderr);
    let data = data(&fs::read_to_string(place.path("report.html")).unwrap());
    assert_eq!(data["runs"].as_array().map(Vec::len), Some(2));
    assert_eq!(data["comparisons"].as_array().map(Vec::len), Some(0));
}

/// The targets of a gallery with each kind of part: tables, curves, a surface.
const SHOWN: &str = "reproduce table3 fig4 fig13 fig14a --report";

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn the_gallery_has_every_number_of_the_scoreboard_and_needs_nothing_else() {
    let place = Place::new();
    let printed = place.run(&format!("{SHOWN} --out all")).done().stdout;
    assert!(printed.ends_with("\ngallery: all/gallery.html\n"), "{printed}");
    let page = fs::read_to_string(place.path("all/gallery.html")).unwrap();
    assert!(page.len() < 1_000_000, "{} bytes", page.len());
    for text in [
        "15.56",
        "19.257",
        "critical speeds",
        "In the paper",
        "do not print are reconstructed",
        "<table>",
        "role=\"img\"",
    ] {
        assert!(page.contains(text), "{text}");
    }
    // Each section once, and each picture with words.
    for target in ["table3", "fig4", "fig13", "fig14a"] {
        assert_eq!(page.matches(&format!("<section id=\"{target}\"")).count(), 1, "{target}");
    }
    let pictures = page.matches("<svg ").count();
    assert!(pictures == 4 && page.matches("aria-label=\"").count() > pictures, "{pictures}");
    assert_eq!(page.matches("<figure").count(), page.matches("<details>").count());
    assert!(!page.contains("{{") && !page.contains("<script") && !page.contains('\u{1b}'));
    for outside in ["src=", "href=\"http", "url(", "@import"] {
        assert!(!page.contains(outside), "{outside}");
    }
    place.run(&format!("{SHOWN} --out all")).done();
    assert_eq!(fs::read_to_string(place.path("all/gallery.html")).unwrap(), page, "the same bytes again");

    // The scoreboard is first, wherever it is named, and complete.
    let printed = place.run("reproduce table3 scoreboard --report --out scores").done().stdout;
    let page = fs::read_to_string(place.path("scores/gallery.html")).unwrap();
    assert!(page.find("id=\"scoreboard\"").unwrap() < page.find("id=\"table3\"").unwrap());
    let table = printed.split("printed in the paper").nth(1).unwrap();
    let rows: Vec<&str> = table.lines().skip(1).take_while(|line| !line.is_empty()).collect();
    assert_eq!(rows.len(), 17, "{printed}");
    for row in rows {
        let cells = row.split("  ").map(str::trim).filter(|cell| !cell.is_empty());
        for cell in cells {
            assert!(
                page.contains(&format!(">{cell}</td>")) || page.contains(&format!("  {cell}</td>")),
                "{cell}: {row}"
            );
        }
    }
    assert!(page.contains("constrains c_x"));
}

#[test]
fn a_browser_shows_the_gallery() {
    let Some(browser) = named_by("STICKSLIP_BROWSER") else { return };
    let place = Place::new();
    place.run(SHOWN).done();
    python_agrees("gallery.py", [browser, place.path("runs/gallery.html").into_os_string()]);
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
        let [begins, ends, rest] = match name {
            "line" => ["P, the probability of instability: ", " in 15 cells.", "P &lt; 1 % for preload up to "],
            _ => ["At 15 rad/s: P, the probability of instability, is ", ").", "It rests on 2,000 samples, "],
        };
        let answer = page.split("<p class=\"verdict\">").nth(1).unwrap();
        let (first, answer) = answer.split_once("</p>").unwrap();
        assert!(first.starts_with(begins) && first.ends_with(ends), "{name}: {first}");
        let answer = answer.split("</p>").next().unwrap();
        assert!(answer.starts_with(&format!("<p class=\"answer\">{rest}")), "{name}: {answer}");
        assert!(!answer.contains("whatever"), "{name}: {answer}");
    }
}

#[test]
fn what_has_no_report_is_said() {
    let place = Place::new();
    place.run("report nowhere").refused(74, &["nowhere is not a run directory"]);
    submitted(&place, "three", JOB);
    place.run("report three --out three/surface.parquet").refused(64, &["written as HTML; name it three/surface.html"]);
    place.run("report three --out no/folder/report.html").refused(73, &["no/folder"]);
    fs::remove_file(place.path("three/surface.parquet")).unwrap();
    place.run("report three").refused(65, &["has no surface yet", "stickslip resume three"]);
}

#[test]
fn the_operating_point_heads_the_report_and_the_end_of_a_run() {
    let place = Place::new();
    let asked = "[target]\nprobability = 0.2\nat = { rotating_speed = 15, preload = 0.1, static_friction = 0.25 }\n";
    let table = submitted(&place, "three", &format!("{JOB}{asked}"));
    let value = |name: &str, cell: usize| table.column(name)[cell];
    let near = |cell: &usize, [speed, preload, friction]: [f64; 3]| {
        (value("rotating_speed_rad_s", *cell) - speed).abs() < 1e-9
            && (value("preload", *cell) - preload).abs() < 1e-9
            && (value("static_friction", *cell) - friction).abs() < 1e-9
    };
    for (target, at) in [(0.2, None), (0.01, None), (0.5, Some([18.0, 0.3, 0.5]))] {
        let point = at.unwrap_or([15.0, 0.1, 0.25]);
        let cell = (0..540).find(|cell| near(cell, point)).unwrap();
        let [p, low, high] = ["p_unstable", "p_low", "p_high"].map(|name| value(name, cell));
        let [speed, preload, friction] = point;
        let first = format!(
            "At {speed} rad/s, preload = {preload}, static friction = {friction}: P, the probability of instability, is {p:.4} (95 % interval: {low:.4} to {high:.4})."
        );
        let met = match (high < target, low >= target) {
            (true, _) => format!("met, P is at most {high:.4}."),
            (_, true) => format!("not met, P is at least {low:.4}."),
            _ => "open, P may be below it and above it; take more samples.".to_owned(),
        };
        let met = format!("Target P < {} %: {met}", 100.0 * target);
        let unstable = match value("n_unstable", cell) as u64 {
            many @ 1000.. => format!("{},{:03}", many / 1000, many % 1000),
            few => few.to_string(),
        };
        let rests = format!("It rests on 2,000 samples, {unstable} of them unstable (method = \"monte-carlo\")");
        let mut options = format!(" --target {target}");
        if at.is_some() {
            options += &format!(" --at rotating_speed={speed} --at preload={preload} --at static_friction={friction}");
        }
        let said = place.run(&format!("submit three.toml --out three{options}")).done().stdout.replace('\n', " ");
        let decision = &serde_json::from_str::<Value>(
            &place.run(&format!("submit three.toml --out three --json{options}")).done().stdout,
        )
        .unwrap()["decision"];
        for (key, number) in
            [("p_unstable", p), ("p_low", low), ("p_high", high), ("target", target), ("confidence", 0.95)]
        {
            assert!((decision[key].as_f64().unwrap() - number).abs() < 1e-12, "{key}: {decision}");
        }
        for (name, number) in [("rotating_speed", speed), ("preload", preload), ("static_friction", friction)] {
            assert!((decision["at"][name].as_f64().unwrap() - number).abs() < 1e-9, "{decision}");
        }
        let is_met = if high < target { Some(true) } else { (low >= target).then_some(false) };
        assert_eq!(decision["met"].as_bool(), is_met, "{decision}");
        let rests_on = format!("It rests on {}", decision["rests_on"].as_str().unwrap());
        assert!(rests_on.starts_with(&rests) && decision["distrust"].is_null(), "{decision}");
        let in_order = [&first, &met, &rests, &format!("Target: P < {} %", 100.0 * target)];
        let places = in_order.map(|text| said.find(&**text).unwrap_or_else(|| panic!("{text}: {said}")));
        assert!(places.is_sorted(), "{places:?}: {said}");
        place.run(&format!("report three{options}")).done();
        let page = fs::read_to_string(place.path("three/report.html")).unwrap();
        let verdict = page.find(&format!("<p class=\"verdict\">{first}</p>")).unwrap_or_else(|| panic!("{first}"));
        let answer = page.find(&format!("<p class=\"answer\">{}", met.replace('<', "&lt;"))).unwrap();
        assert!(verdict < answer && answer < page.find("<div id=\"map\"").unwrap());
        // The page begins with this point selected.
        let run = &data(&page)["runs"][0];
        let at = run["at"].as_array().unwrap();
        let values: Vec<f64> = at
            .iter()
            .zip(run["axes"].as_array().unwrap())
            .filter(|(_, axis)| axis["values"].as_array().unwrap().len() > 1)
            .map(|(position, axis)| axis["values"][position.as_u64().unwrap() as usize].as_f64().unwrap())
            .collect();
        assert!(values.iter().zip(point).all(|(value, point)| (value - point).abs() < 1e-9), "{values:?}");
    }
    let missing = ["--at: preload is missing, which has 15 values"];
    place.run("report three --at rotating_speed=15").refused(64, &missing);
    place.run("submit three.toml --out three --at rotating_speed=15").refused(64, &missing);
    place.write("wrong.toml", &format!("{JOB}{}", asked.replace("preload = 0.1", "preload = 0.101")));
    place
        .run("check wrong.toml")
        .refused(65, &["wrong.toml:18", "target.at: preload has no value 0.101 on the grid; the nearest is 0.1"]);
}

/// What an answer claims, "P < 5 % for preload up to 0.02": the limit, the column, and the values for which it says so.
fn claims(answer: &str) -> Vec<(f64, String, [f64; 2])> {
    let claim = |part: &str| {
        let (limit, rest) = part.split_once(" % for ").unwrap();
        let rest = rest.split([',', '(']).next().unwrap().trim();
        let (name, range) = match (rest.strip_prefix("every "), rest.split_once(" up to "), rest.split_once(" from ")) {
            (Some(name), ..) => (name, [f64::NEG_INFINITY, f64::INFINITY]),
            (_, Some((name, end)), _) => (name, [f64::NEG_INFINITY, end.parse().unwrap()]),
            (.., Some((name, start))) => (name, [start.parse().unwrap(), f64::INFINITY]),
            _ => panic!("{part}"),
        };
        (limit.parse::<f64>().unwrap() / 100.0, name.replace(' ', "_"), range)
    };
    answer.split("P < ").skip(1).map(claim).collect()
}

/// The cells of a table whose value in a column lies in a range.
fn cells_in(table: &Table, column: &str, [from, to]: [f64; 2]) -> Vec<usize> {
    let values = table.column(column);
    (0..values.len()).filter(|&cell| from - 1e-9 < values[cell] && values[cell] < to + 1e-9).collect()
}

#[test]
fn the_answer_is_that_of_the_exact_surface() {
    let place = Place::new();
    let mut found = 0;
    for job in 0..10 {
        let text = JOB
            .replace("12, 15, 18", &format!("{}, {}", 8 + 2 * job, 25 + job))
            .replace("relative_std = 0.2", &format!("relative_std = {}", 0.05 + 0.03 * f64::from(job)))
            .replace("seed = 1", &format!("seed = {job}"));
        let exact = text.replace("samples = 2000\n", "").replace("seed =", "method = \"exact\"\nseed =");
        place.write("exact.toml", &exact.replace("\"three\"", "\"exact\""));
        place.write("drawn.toml", &text);
        let known = |name: &str| Table::read(&place.path(&format!("{name}-{job}/surface.parquet")));
        for name in ["exact", "drawn"] {
            let said = place.run(&format!("submit {name}.toml --out {name}-{job}")).done().stdout.replace('\n', " ");
            let answer = said.split("P, the probability of instability: ").nth(1).unwrap();
            let (range, rest) = answer.split_once(" in 360 cells. ").unwrap();
            let rest = rest.split(&format!("{name}-{job}/")).next().unwrap();
            let surface = known(name);
            let p = surface.column("p_unstable");
            let ends: Vec<f64> = range.split(" to ").map(|end| end.parse().unwrap()).collect();
            let known_ends = [f64::min, f64::max].map(|of| p.iter().copied().reduce(of).unwrap());
            assert!((ends[0] - known_ends[0]).abs() < 6e-5 && (ends[1] - known_ends[1]).abs() < 6e-5, "{job}: {range}");
            let exactly = known("exact");
            let (high, exactly) = (surface.column("p_high"), exactly.column("p_unstable"));
            for (limit, column, [from, to]) in claims(rest) {
                found += 1;
                let sure = cells_in(&surface, &column, [from, to]);
                assert!(!sure.is_empty() && sure.iter().all(|&cell| high[cell] < limit), "{job}, {name}: {rest}");
                // The next value has a cell in which it does not hold.
                let values = surface.column(&column);
                let beyond = |value: &f64| *value > to + 1e-9 || *value < from - 1e-9;
                let next = values.iter().copied().filter(beyond);
                let next = if to.is_finite() { next.reduce(f64::min) } else { next.reduce(f64::max) };
                let next = next.map(|value| cells_in(&surface, &column, [value, value]));
                assert!(next.is_none_or(|next| next.iter().any(|&cell| high[cell] >= limit)), "{job}, {name}: {rest}");
                // An upper end of a 95 % interval is too low in 2.5 % of the cells.
                let wrong = sure.iter().filter(|&&cell| exactly[cell] >= limit).count();
                assert!(wrong <= 4, "job {job}, {limit}: {wrong} of {} cells", sure.len());
            }
        }
    }
    assert!(found > 10, "{found} claims");
}

/// Probabilities that are integrated, over speed and preload.
const INTEGRATED: &str = r#"
name = "integrated"
[axes]
rotating_speed = { from = 8.0, to = 16.0, points = 33 }
preload = { from = 0.010, to = 0.050, points = 9 }
static_friction = 0.39
[random]
inputs = ["static_friction"]
relative_std = 0.20
[criterion]
kind = "eigenvalue"
[sampling]
method = "exact"
"#;

/// The points of the lines of an SVG that are drawn in black, one pixel wide, in shares of the box of its areas.
fn drawn_lines(svg: &str) -> Vec<[f64; 2]> {
    let paths = || svg.split("<path d=\"").skip(1).map(|path| path.split('>').next().unwrap());
    let points = |path: &str| -> Vec<[f64; 2]> {
        let path = path.split('"').next().unwrap();
        let numbers = path.split(|c: char| !c.is_ascii_digit() && !"-.".contains(c)).filter(|part| !part.is_empty());
        let numbers: Vec<f64> = numbers.map(|number| number.parse().unwrap()).collect();
        numbers.chunks(2).map(|pair| [pair[0], pair[1]]).collect()
    };
    // The areas of the palest colour fill the panel; after them comes its tile in the bar of colours.
    let areas: Vec<[f64; 2]> = paths().filter(|path| path.contains("fill=\"#fd")).take(1).flat_map(points).collect();
    let [left, right] = [f64::min, f64::max].map(|of| areas.iter().map(|point| point[0]).reduce(of).unwrap());
    let [top, bottom] = [f64::min, f64::max].map(|of| areas.iter().map(|point| point[1]).reduce(of).unwrap());
    let lines = paths().filter(|path| path.contains("stroke=\"#1a1a1a\" stroke-width=\"1\""));
    let share = |[x, y]: [f64; 2]| [(x - left) / (right - left), (bottom - y) / (bottom - top)];
    lines.flat_map(points).map(share).collect()
}

#[test]
fn plot_and_report_draw_a_probability_where_the_limit_is() {
    let place = Place::new();
    submitted(&place, "integrated", INTEGRATED);
    place.run("report integrated").done();
    place.run("plot integrated").done();
    let found = place.run("limit integrated.toml --of rotating_speed --probability 0.05 --json").done().stdout;
    let limits = &serde_json::from_str::<Value>(&found).unwrap()["limits"];
    let limits: Vec<(f64, f64)> = limits.as_array().unwrap().iter().filter_map(of_limit).collect();
    assert!(limits.len() > 5, "{found}");

    // In the report, lines have a point at every preload.
    let data = data(&fs::read_to_string(place.path("integrated/report.html")).unwrap());
    let lines = data["runs"][0]["lines"].as_array().unwrap();
    let of_level = lines.iter().filter(|line| line["level"] == 0.05);
    let points: Vec<(f64, f64)> = of_level
        .flat_map(|line| {
            let numbers = |axis: &str| {
                let values = line[axis].as_array().unwrap();
                values.iter().map(|value| value.as_f64().unwrap()).collect::<Vec<f64>>()
            };
            numbers("x").into_iter().zip(numbers("y"))
        })
        .collect();
    let svg = fs::read_to_string(place.path("integrated/surface.svg")).unwrap();
    let drawn: Vec<[f64; 2]> =
        drawn_lines(&svg).iter().map(|[right, up]| [0.01 + 0.04 * right, 8.0 + 8.0 * up]).collect();
    let mut beside = 0;
    for &(preload, speed) in &limits {
        let at_preload = points.iter().filter(|point| (point.0 - preload).abs() < 1e-9);
        let nearest = at_preload.map(|point| (point.1 - speed).abs()).fold(f64::INFINITY, f64::min);
        // The speeds of the grid are 0.25 rad/s apart.
        assert!(nearest < 0.005, "the report has 5 % at {preload} off by {nearest} rad/s");
        // The line of a plot has a gap for its label, and is written with hundredths of a pixel.
        let at_preload = drawn.iter().filter(|point| (point[0] - preload).abs() < 3e-5);
        beside += usize::from(at_preload.map(|point| (point[1] - speed).abs()).any(|off| off < 0.01));
    }
    assert!(beside + 1 >= limits.len(), "the plot has 5 % at {beside} of {} limits", limits.len());
}

/// The preload and the speed of a limit, if there is one.
fn of_limit(row: &Value) -> Option<(f64, f64)> {
    Some((row["preload"].as_f64()?, row["limit"].as_f64()?))
}

#[test]
fn a_report_says_what_its_numbers_rest_on() {
    let place = Place::new();
    submitted(&place, "three", JOB);
    place.run("report three").done();
    let page = fs::read_to_string(place.path("three/report.html")).unwrap();
    let open = &page[..page.find("<section aria-labelledby=\"job-heading\"").unwrap()];
    let table = Table::read(&place.path("three/surface.parquet"));
    let outside = table.column("n_outside_physics");
    let all: f64 = outside.iter().sum();
    assert!(all > 0.0);
    for text in [
        &format!("({:.2} %, in one cell up to", 100.0 * all / (540.0 * 2000.0)),
        "lie outside the model: preload at or below 0, or f<sub>s</sub> &lt; f<sub>c</sub>; they count as stable",
        "<dt>Scatter</dt><dd >relative std: preload 0.2, friction 0.2</dd>",
        "<dt>Criterion</dt><dd >kind = &quot;eigenvalue&quot;</dd>",
        "samples = 2000, seed = 1</dd>",
        "preload 0.02 to 0.3 (displacement 0.4 to 6 mm), 15 values",
        "expected contact force on a rigid disc: 7.019 kN to 105.3 kN",
        "<dt>Range of P</dt><dd >95 % interval</dd>",
        ", by submit</dd>",
    ] {
        assert!(open.contains(text), "{text}: {open}");
    }
    // What the map marks.
    let shown = &data(&page)["runs"][0]["apart"]["outside"];
    for (cell, count) in outside.iter().enumerate() {
        assert!((shown[cell].as_f64().unwrap() - count / 2000.0).abs() < 1e-9, "{cell}");
    }
}

#[test]
fn a_run_without_scatter_has_verdicts_and_no_probabilities() {
    let place = Place::new();
    let job = JOB.replace("[random]\ninputs = [\"preload\", \"static_friction\"]\nrelative_std = 0.2\n", "");
    submitted(&place, "three", &job.replace("samples = 2000\nseed = 1\n", ""));
    place.run("report three").done();
    let page = fs::read_to_string(place.path("three/report.html")).unwrap();
    assert!(page.contains("<h2 id=\"map-heading\">Verdict of each cell</h2>") && !page.contains("<dt>Range of P</dt>"));
    let run = &data(&page)["runs"][0];
    let verdicts = &run["verdicts"];
    assert_eq!(run["lines"], Value::Array(Vec::new()));
    let table = Table::read(&place.path("three/surface.parquet"));
    for (cell, p) in table.column("p_unstable").iter().enumerate() {
        let name = &verdicts["names"][verdicts["of_cells"][cell].as_u64().unwrap() as usize];
        assert_eq!(name, if *p == 1.0 { "unstable" } else { "stable" }, "{cell}");
    }
}

#[test]
fn what_shows_earlier_results_is_named() {
    let place = Place::new();
    let job = DRAWN.replace("samples = 400\nsensitivity = true", "samples = 100");
    submitted(&place, "drawn", &job);
    let made = ["report.html", "surface.pdf", "surface.png", "surface.svg"];
    let draw = || {
        for command in ["report drawn", "plot drawn", "plot drawn --out drawn/surface.pdf"] {
            place.run(command).done();
        }
    };
    let are_renewed = || {
        for command in ["status drawn", "status .", "verify drawn", "submit drawn.toml --out drawn --samples 200"] {
            let said = place.run(command).done().stdout;
            assert!(!said.contains("outdated"), "{command}: {said}");
        }
    };
    draw();
    let now = place.run("status drawn").done().stdout;
    assert!(!now.contains("outdated"), "{now}");

    // Whatever their clocks say: the run is extended at once, and its surface has the time of the pictures.
    let extended = place.run("submit drawn.toml --out drawn --samples 200").done().stdout;
    let time = fs::metadata(place.path("drawn/report.html")).unwrap().modified().unwrap();
    fs::File::options().write(true).open(place.path("drawn/surface.parquet")).unwrap().set_modified(time).unwrap();
    let line = format!(
        "{} are outdated, as the results have changed since; make them again, for example with `stickslip report drawn`, `stickslip plot drawn --out drawn/surface.pdf` and `stickslip plot drawn`\n",
        made.join(", ")
    );
    for said in [extended, place.run("status drawn").done().stdout, place.run("resume drawn").done().stdout] {
        assert!(said.ends_with(&line), "{said}");
    }
    let all = place.run("status .").done().stdout;
    assert!(all.contains(&format!("100.0 %  outdated: {}\n", made.join(", "))), "{all}");
    let checked = place.run("verify drawn").done().stdout;
    let of_picture = "surface.png: outdated, it shows earlier results of the run; make it again, for example with `stickslip plot drawn`\n";
    assert!(checked.contains(of_picture), "{checked}");
    let checked: Value = serde_json::from_str(&place.run("verify drawn --json").done().stdout).unwrap();
    assert_eq!(checked["state"], "sound", "the run itself is sound");
    assert_eq!(checked["outdated"].as_array().unwrap(), &made);
    let named = checked["files"].as_array().unwrap().iter().filter(|file| file["state"] == "outdated");
    assert_eq!(named.map(|file| file["file"].as_str().unwrap()).collect::<Vec<_>>(), made);
    draw();
    are_renewed();

    // Limits are results, too. A report of several runs shows each of them.
    place.run("limit drawn --of preload --probability 0.05 --out drawn/limits.parquet").done();
    assert!(place.run("status drawn").done().stdout.ends_with(&line));
    draw();
    are_renewed();
    submitted(&place, "other", &job.replace("seed = 1", "seed = 2"));
    place.run("report drawn other --out drawn/report.html").done();
    place.run("report drawn other --out other/report.html").done();
    are_renewed();
    assert!(!place.run("status other").done().stdout.contains("outdated"));
}
