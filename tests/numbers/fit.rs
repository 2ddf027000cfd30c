//! `stickslip fit`, as typed: what it prints, writes and refuses.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so and stop")]

use std::fs;

use crate::common::{Place, Table};
use serde_json::Value;

const VERDICTS: &str = "rotating_speed,preload,squealed,count\n13,0.1,1,39\n13,0.1,0,1\n14,0.1,1,35\n14,0.1,0,5\n\
    15,0.1,1,30\n15,0.1,0,10\n16,0.1,1,19\n16,0.1,0,21\n17,0.1,1,7\n17,0.1,0,33\n18,0.1,1,2\n18,0.1,0,38\n";

const ONSETS: &str = "onset_speed,preload,censored\n15.2,0.1,0\n16.3,0.1,0\n\n14.1,0.1,0\n12,0.1,1\n17.1,0.12,0\n\
    16.8,0.12,0\n15.5,0.12,0\n13.9,0.08,0\n12.6,0.08,0\n12,0.08,1\n";

const RANDOM: &str = "inputs = [\"preload\", \"static_friction\"]\n\
    relative_std = { preload = 0.05, static_friction = 0.1 }";

fn job(random: &str, rest: &str) -> String {
    format!(
        "name = \"tested\"\n\n[axes]\nrotating_speed = [14, 16]\npreload = [0.08, 0.1]\n\n[random]\n{random}\n\n\
        [criterion]\nkind = \"eigenvalue\"\n\n[sampling]\nmethod = \"exact\"\n{rest}"
    )
}

fn place(data: &str) -> Place {
    let place = Place::new();
    place.write("job.toml", &job(RANDOM, ""));
    place.write("data.csv", data);
    place
}

fn json(place: &Place, command: &str) -> Value {
    serde_json::from_str(&place.run(command).done().stdout).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

#[test]
fn verdicts_give_estimates_and_a_job_that_has_their_probabilities() {
    let place = place(VERDICTS);
    let said = place.run("fit data.csv --job job.toml --out new.toml").done();
    for text in ["240 tests, 132 of which squealed", "static_friction", "95 % interval", "as in the job", "P(squeal)"] {
        assert!(said.stdout.contains(text), "{text}: {}", said.stdout);
    }
    let found = json(&place, "fit data.csv --job job.toml --json");
    assert_eq!(found["kind"], "verdict");
    let friction = &found["estimates"]["static_friction"];
    assert!((number(&friction["value"]) - 0.4).abs() < 0.01, "{friction}");
    assert!(number(&friction["low"]) < number(&friction["value"]), "{friction}");
    assert!(number(&friction["high"]) > number(&friction["value"]), "{friction}");
    assert_eq!(number(&found["from_job"]["std.preload"]), 0.05);
    let text = fs::read_to_string(place.path("new.toml")).unwrap();
    assert!(
        text.starts_with("# Written by stickslip fit from the tests \"data.csv\" and the job \"job.toml\"."),
        "{text}"
    );
    assert!(text.contains("#   static_friction = 0."), "{text}");
    place.run("check new.toml").done();
    place.run("submit new.toml").done();
    let table = Table::read(&place.path("runs/tested-fitted/surface.parquet"));
    let cells = found["cells"].as_array().unwrap();
    assert_eq!(cells.len(), 4);
    for (row, cell) in cells.iter().enumerate() {
        let [p, low, high] = ["p_squeal", "p_low", "p_high"].map(|key| number(&cell[key]));
        // The job has six digits of each estimate.
        assert!((table.column("p_unstable")[row] - p).abs() < 2e-4, "{cell}");
        assert!(0.0 <= low && low < p && p < high && high <= 1.0, "{cell}");
    }
    place.run("fit data.csv --job job.toml --out new.toml").refused(73, &["new.toml exists already", "--out"]);
}

#[test]
fn the_factor_of_the_preload_moves_the_preloads_of_the_new_job() {
    let place = place(VERDICTS);
    let command = "fit data.csv --job job.toml --estimate preload_factor,std.static_friction";
    let found = json(&place, &format!("{command} --json"));
    let factor = number(&found["estimates"]["preload_factor"]["value"]);
    assert!(factor > 1.0 && factor < 1.5, "{found}");
    place.run(&format!("{command} --out new.toml")).done();
    place.run("submit new.toml").done();
    let table = Table::read(&place.path("runs/tested-fitted/surface.parquet"));
    for (row, cell) in found["cells"].as_array().unwrap().iter().enumerate() {
        assert!((table.column("preload")[row] / (factor * number(&cell["preload"])) - 1.0).abs() < 1e-5, "{cell}");
        assert!((table.column("p_unstable")[row] - number(&cell["p_squeal"])).abs() < 2e-4, "{cell}");
    }
}

#[test]
fn onset_speeds_are_recognised_by_their_column() {
    let place = place(ONSETS);
    let friction_only = "inputs = [\"static_friction\"]\nrelative_std = 0.1";
    place.write("job.toml", &job(friction_only, ""));
    let found = json(&place, "fit data.csv --job job.toml --json");
    assert_eq!(found["kind"], "onset");
    assert_eq!((number(&found["tests"]), number(&found["squealed"])), (10.0, 8.0));
    let friction = number(&found["estimates"]["static_friction"]["value"]);
    assert!((0.36..0.42).contains(&friction), "{friction}");
    // Without the tests that never squealed the brakes seem worse.
    place.write("without.csv", &ONSETS.replace("12,0.1,1\n", "").replace("12,0.08,1\n", ""));
    let without = json(&place, "fit without.csv --job job.toml --json");
    assert!(number(&without["estimates"]["static_friction"]["value"]) > friction, "{without}");
    // A curve that is flat at rest has onset speeds only above its steepest fall.
    let gaussian = job(RANDOM, "").replace("[axes]", "[model.friction]\nstribeck_exponent = 2\n\n[axes]");
    place.write("gaussian.toml", &gaussian);
    place.write("slow.csv", "onset_speed,preload\n9,0.1\n0.5,0.1\n");
    place
        .run("fit slow.csv --job gaussian.toml")
        .refused(65, &["slow.csv:3: onset_speed = 0.5 is not above", "steeply"]);
    let curve = "law = \"table\"\ntable = { speed = [0, 1, 3], coefficient = [0.45, 0.26, 0.24] }";
    place.write("table.toml", &job(RANDOM, "").replace("[axes]", &format!("[model.friction]\n{curve}\n\n[axes]")));
    place.run("fit data.csv --job table.toml").refused(65, &["data.csv:1", "verdicts"]);
}

#[test]
fn rows_that_cannot_be_right_are_refused_with_their_place() {
    let place = place("");
    for (data, texts) in [
        ("", &["data.csv:1", "rotating_speed,preload,squealed,count"][..]),
        ("speed,preload\n1,2\n", &["data.csv:1", "no column rotating_speed or onset_speed"]),
        ("onset_speed/preload\n15/0.1\n", &["data.csv:1", "commas or semicolons", "it has \"onset_speed/preload\""]),
        ("onset_speed,preload;x\n15,1;2\n", &["data.csv:1", "commas and semicolons"]),
        ("onset_speed;preload\n15,2;0,1\n\n15.3;0,1\n", &["data.csv:2", "\"15,2\" here and \"15.3\" in line 4"]),
        ("onset_speed;preload\n15,200;1\n16,100;1\n", &["data.csv:2", "\"15,200\" may be 15.200 or 15200"]),
        ("onset_speed;preload\n15,2;0,1\n\nfast;0,1\n", &["data.csv:4", "\"fast\" in column \"onset_speed\""]),
        ("onset_speed;preload\n15,2;0,1\n15,3;3,5\n", &["data.csv:3", "preload = 3.5 is out of range"]),
        ("onset_speed,preload\n15,2,0,1\n", &["data.csv:2", "4 fields", "decimal commas need semicolons"]),
        (
            "onset_speed,preload\n15,0.1\n15,0.1\n",
            &["scatter no more than", "std.static_friction is 0.0020", "add tests"],
        ),
        ("rotating_speed,onset_speed,preload\n1,1,2\n", &["data.csv:1", "both"]),
        ("rotating_speed,preload,count\n1,0.1,2\n", &["data.csv:1", "no column squealed"]),
        ("rotating_speed,preload,squealed,Count\n1,0.1,1,2\n", &["data.csv:1", "\"Count\""]),
        ("onset_speed,preload,preload\n1,0.1,0.1\n", &["data.csv:1", "two columns are named preload"]),
        ("onset_speed,preload\n12,0.1\n\nfast,0.1\n", &["data.csv:4", "\"fast\" in column \"onset_speed\""]),
        ("onset_speed,preload\n12,0.1\nNaN,0.1\n", &["data.csv:3", "\"NaN\" in column \"onset_speed\""]),
        ("onset_speed,preload\n-12,0.1\n", &["data.csv:2", "onset_speed = -12 is out of range", "rad/s"]),
        ("onset_speed,preload\n12,35000\n", &["data.csv:2", "preload = 35000 is out of range", "at most 1"]),
        ("onset_speed,preload\n12\n", &["data.csv:2", "1 fields"]),
        ("onset_speed,preload,censored\n12,0.1,yes\n", &["data.csv:2", "\"yes\" in column censored", "0 (no)"]),
        ("rotating_speed,preload,squealed\n12,0.1,2\n", &["data.csv:2", "\"2\" in column squealed"]),
        ("rotating_speed,preload,squealed,count\n12,0.1,1,0\n", &["data.csv:2", "\"0\" in column count"]),
        ("rotating_speed,preload,squealed,count\n12,0.1,1,1.5\n", &["data.csv:2", "\"1.5\" in column count"]),
        ("rotating_speed,preload,squealed\n", &["data.csv", "no tests"]),
        ("rotating_speed,preload,squealed\n12,0.1,1\n14,0.1,1\n", &["every test squealed", "higher speeds"]),
        ("rotating_speed,preload,squealed\n12,0.1,1\n14,0.1,0\n", &["separated", "set it in the job"]),
    ] {
        place.write("data.csv", data);
        place.run("fit data.csv --job job.toml").refused(65, texts);
    }
    fs::write(place.path("data.csv"), [0xff, 0xfe, 0x00, b'\n', 0x80]).unwrap();
    place.run("fit data.csv --job job.toml").refused(65, &["data.csv"]);
    place.run("fit none.csv --job job.toml").refused(74, &["cannot read none.csv"]);
}

#[test]
fn jobs_that_do_not_say_enough_are_refused() {
    let place = place(VERDICTS);
    let only_preload = "inputs = [\"preload\"]\nrelative_std = 0.1";
    let third = "inputs = [\"static_friction\", \"pad.mass\"]\nrelative_std = 0.1";
    let several = "inputs = [\"static_friction\"]\nrelative_std = [0.1, 0.2]";
    for (text, options, words) in [
        (job(only_preload, ""), "", "random.inputs does not list static_friction"),
        (job(third, "").replace("\"exact\"", "\"monte-carlo\""), "", "pad.mass"),
        (job(several, ""), "", "random.relative_std lists several values"),
        (
            job(RANDOM, "").replace("preload = [", "static_friction = [0.3, 0.4]\npreload = ["),
            "--estimate std.static_friction",
            "axes.static_friction has several values",
        ),
        (
            job(RANDOM, "").replace("preload = [", "\"pad.mass\" = [0.1, 0.2]\npreload = ["),
            "",
            "axes.pad.mass has several values",
        ),
        (job("inputs = []", ""), "--estimate static_friction", "nothing scatters"),
        (
            job(RANDOM, "").replace("\"eigenvalue\"", "\"coupled-eigenvalue\"").replace("\"exact\"", "\"monte-carlo\""),
            "",
            "criterion.kind = \"eigenvalue\"",
        ),
    ] {
        place.write("other.toml", &text);
        place.run(&format!("fit data.csv --job other.toml {options}")).refused(65, &["other.toml", words]);
    }
    // A redundant set is recognised by its names.
    let all = "--estimate static_friction,preload_factor,std.static_friction";
    place
        .run(&format!("fit data.csv --job job.toml {all}"))
        .refused(65, &["the tests do not determine", "estimate fewer"]);
    place.run("fit data.csv --job job.toml --estimate friction").refused(64, &["static_friction"]);
}

#[test]
fn damaged_data_end_in_a_message_or_a_result() {
    let place = Place::new();
    place.write("job.toml", &job("inputs = [\"static_friction\"]\nrelative_std = 0.1", ""));
    for data in [VERDICTS, ONSETS] {
        for i in 0..24_usize {
            // A byte of the file replaced, at places and by bytes that a multiplication scatters.
            let mut bytes = data.as_bytes().to_vec();
            let length = bytes.len();
            bytes[i * 7919 % length] = [b'0', b'9', b',', b'-', b'e', b'\n', b'"', 0xff][i % 8];
            bytes.truncate(length - i * 31 % 40);
            fs::write(place.path("data.csv"), bytes).unwrap();
            let said = place.run("fit data.csv --job job.toml --json");
            assert!(matches!(said.code, Some(0 | 65)), "{i}: {said:?}");
        }
    }
}

#[test]
fn tests_that_contradict_the_model_are_told() {
    let zigzag = "rotating_speed,preload,squealed,count\n10,0.1,1,400\n12,0.1,1,100\n12,0.1,0,300\n14,0.1,1,348\n14,0.1,0,52\n\
                  16,0.1,1,40\n16,0.1,0,360\n18,0.1,1,200\n18,0.1,0,200\n20,0.1,0,400\n";
    let place = place(zigzag);
    let outcome = place.run("fit data.csv --job job.toml --json").done();
    assert!(outcome.stderr.contains("the tests contradict the model (p = "), "{}", outcome.stderr);
    let found: Value = serde_json::from_str(&outcome.stdout).unwrap();
    assert!(number(&found["goodness_of_fit"][0]["p_value"]) < 1e-10, "{found}");
    // A misplaced decimal point in line 3.
    place.write("data.csv", "onset_speed,preload\n15.2,0.1\n163,0.1\n14.1,0.1\n17.1,0.1\n16.8,0.12\n15.5,0.12\n");
    let texts = ["data.csv: the model cannot produce the test of line 3, whose"];
    place.run("fit data.csv --job job.toml").refused(65, &texts);
}

#[test]
fn files_of_spreadsheets_say_the_same() {
    for data in [VERDICTS, ONSETS] {
        let place = place(data);
        let said = place.run("fit data.csv --job job.toml").done().stdout;
        let semicolons = data.replace(',', ";");
        let decimal_commas = semicolons.replace('.', ",");
        let empty = ";".repeat(data.lines().next().unwrap().matches(',').count());
        for other in [
            semicolons,
            decimal_commas.clone(),
            // As Excel writes it: a byte order mark, two characters at the end of a line, and rows without anything.
            format!("\u{feff}{}{empty}\r\n", decimal_commas.replace('\n', "\r\n")),
            data.replace(',', "\t").replace('.', ","),
        ] {
            place.write("data.csv", &other);
            assert_eq!(place.run("fit data.csv --job job.toml").done().stdout, said, "{other}");
        }
    }
}

/// The numbers of the elements of an SVG that begin with a text.
fn elements(svg: &str, beginning: &str, names: &[&str]) -> Vec<Vec<f64>> {
    let of = |element: &str| {
        let value = |name: &&str| {
            let (_, rest) = element.split_once(&format!(" {name}=\"")).unwrap();
            rest.split('"').next().unwrap().parse().unwrap()
        };
        names.iter().map(value).collect()
    };
    svg.split(beginning).skip(1).map(|element| of(element.split('>').next().unwrap())).collect()
}

/// The points of the widest lines of an SVG.
fn curves(svg: &str) -> Vec<Vec<[f64; 2]>> {
    let lines = svg.split("<path d=\"M ").skip(1).map(|line| line.split('>').next().unwrap());
    let points = |line: &str| -> Vec<[f64; 2]> {
        let numbers = line.split('"').next().unwrap().split([' ', 'L']).filter(|number| !number.is_empty());
        let numbers: Vec<f64> = numbers.map(|number| number.parse().unwrap()).collect();
        numbers.chunks(2).map(|pair| [pair[0], pair[1]]).collect()
    };
    lines.filter(|line| line.contains("stroke-width=\"1.6\"")).map(points).collect()
}

/// The height of a curve at a place.
fn height(curve: &[[f64; 2]], x: f64) -> f64 {
    let pair = curve.windows(2).find(|pair| pair[0][0] <= x && x <= pair[1][0]).unwrap();
    let share = (x - pair[0][0]) / (pair[1][0] - pair[0][0]);
    pair[0][1] + share * (pair[1][1] - pair[0][1])
}

#[test]
fn the_picture_shows_the_shares_of_the_tests_and_the_fitted_probabilities() {
    let place = place(VERDICTS);
    let found = json(&place, "fit data.csv --job job.toml --plot fit.svg --json");
    assert_eq!(found["plot"], "fit.svg");
    let svg = fs::read_to_string(place.path("fit.svg")).unwrap();
    for text in [
        "Probability of squeal",
        "Rotating speed",
        "rad/s",
        "nominal preload 0.1",
        "95 % intervals (Clopper and Pearson)",
        "pointwise 95 %",
    ] {
        assert!(svg.contains(text), "{text}");
    }
    let points = elements(&svg, "<circle", &["cx", "cy"]);
    let shares = [39.0, 35.0, 30.0, 19.0, 7.0, 2.0].map(|squealed| squealed / 40.0);
    assert_eq!(points.len(), shares.len());
    // The scales, from two points; the others agree.
    let [first, last] = [&points[0], &points[5]];
    let x = |speed: f64| first[0] + (speed - 13.0) / 5.0 * (last[0] - first[0]);
    let y = |share: f64| first[1] + (share - shares[0]) / (shares[5] - shares[0]) * (last[1] - first[1]);
    for ((point, share), speed) in points.iter().zip(shares).zip([13.0, 14.0, 15.0, 16.0, 17.0, 18.0]) {
        assert!((point[0] - x(speed)).abs() < 0.02 && (point[1] - y(share)).abs() < 0.02, "{point:?} {speed} {share}");
    }
    // SciPy: binomtest(19, 40).proportion_ci(0.95), as a line of this height.
    let bars = elements(&svg, "<line", &["x1", "x2", "y1", "y2"]);
    let bar = bars.iter().find(|bar| bar[0] == bar[1] && (bar[0] - x(16.0)).abs() < 0.02).unwrap();
    assert!((bar[2] - y(0.315_117_0)).abs() < 0.05 && (bar[3] - y(0.638_683_8)).abs() < 0.05, "{bar:?}");
    // The curve has the probabilities that are predicted for the cells, and the area their intervals.
    let curves = curves(&svg);
    let cells = found["cells"].as_array().unwrap();
    let own: Vec<&Value> = cells.iter().filter(|cell| number(&cell["preload"]) == 0.1).collect();
    assert_eq!((curves.len(), own.len()), (1, 2));
    let area = svg.split("<path d=\"M").nth(1).unwrap().split('"').next().unwrap();
    let corners: Vec<[f64; 2]> = area
        .trim_end_matches('Z')
        .split('L')
        .map(|corner| corner.split_once(',').unwrap())
        .map(|(x, y)| [x.parse().unwrap(), y.parse().unwrap()])
        .collect();
    let (low, high) = corners.split_at(corners.len() / 2);
    let high: Vec<[f64; 2]> = high.iter().rev().copied().collect();
    for cell in own {
        let at = x(number(&cell["rotating_speed_rad_s"]));
        for (line, key) in [(&curves[0][..], "p_squeal"), (low, "p_low"), (&high, "p_high")] {
            let drawn = height(line, at);
            assert!((drawn - y(number(&cell[key]))).abs() < 0.5, "{key} {drawn} {cell}");
        }
    }
    // Onset speeds are drawn as steps.
    place.write("data.csv", ONSETS);
    place.run("fit data.csv --job job.toml --plot onsets.svg").done();
    let svg = fs::read_to_string(place.path("onsets.svg")).unwrap();
    for text in ["nominal preload 0.08", "nominal preload 0.1", "nominal preload 0.12", "Kaplan and Meier"] {
        assert!(svg.contains(text), "{text}");
    }
    assert!(self::curves(&svg).len() == 3 && !svg.contains("<circle"));
    place.run("fit data.csv --job job.toml --plot fit.png").done();
    assert!(fs::read(place.path("fit.png")).unwrap().starts_with(b"\x89PNG"));
}

#[test]
fn what_cannot_be_drawn_is_refused_before_the_fit() {
    let place = place(VERDICTS);
    place.run("fit data.csv --job job.toml --plot fit.pdf").done();
    assert!(fs::read(place.path("fit.pdf")).unwrap().starts_with(b"%PDF-"));
    place.run("fit data.csv --job job.toml --plot fit.gif").refused(64, &["SVG, PDF or PNG", "fit.svg or fit.pdf or"]);
    place
        .run("fit data.csv --job job.toml --plot none/fit.svg --out new.toml")
        .refused(73, &["there is no directory none"]);
    let rows: String = (0..8).map(|i| format!("{},0.{:02},{}\n", 12 + i, 7 + i, i % 2)).collect();
    place.write("data.csv", &format!("rotating_speed,preload,squealed\n{rows}"));
    let texts = ["data.csv", "8 different preloads", "at most 6", "leave out --plot"];
    place.run("fit data.csv --job job.toml --plot fit.svg --out new.toml").refused(65, &texts);
    assert!(!place.path("new.toml").exists() && !place.path("fit.svg").exists());
}

#[test]
fn lines_that_are_explained_worst_are_named() {
    // One of forty that squealed at 60 rad/s is impossible, and at 30 rad/s leads the scatter to its limit.
    let place = place(&format!("{VERDICTS}60,0.1,1,1\n60,0.1,0,39\n"));
    place.run("fit data.csv --job job.toml").refused(65, &["cannot produce the test of line 14, whose"]);
    place.write("data.csv", &format!("{VERDICTS}30,0.1,1,1\n30,0.1,0,39\n"));
    let texts = ["std.static_friction is 1.0000, the limit", "It would not without line 14 (p = ", "by the others)"];
    place.run("fit data.csv --job job.toml").refused(65, &texts);
    // Half of the tests ended without squeal, which is no contradiction.
    let speeds = (0..40).map(|i| 14.0 + 0.1 * f64::from(i) - 0.002 * f64::from((i - 20) * (i - 20)));
    let row = |speed: f64| if speed > 15.5 { format!("{speed},0.1,0\n") } else { "15.5,0.1,1\n".to_owned() };
    place.write("data.csv", &format!("onset_speed,preload,censored\n{}", speeds.map(row).collect::<String>()));
    let outcome = place.run("fit data.csv --job job.toml --json").done();
    assert!(!outcome.stderr.contains("contradict"), "{}", outcome.stderr);
}
