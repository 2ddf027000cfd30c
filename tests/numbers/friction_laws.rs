//! Jobs with friction laws other than Tustin's: what they compute, which messages they get, and how they resume.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so and stop")]

use std::fs;

use crate::common::{Place, repository};

const CURVE: &str = "speed,coefficient,std\n0,0.45,0.02\n0.2,0.38,0.02\n1,0.26,0.01\n3,0.24,0.01\n8,0.29,0.02\n";

fn job(friction: &str) -> String {
    format!(
        "name = \"law\"\n\n[model.friction]\n{friction}\n\n[axes]\nrotating_speed = [2, 8]\npreload = 0.1\n\n\
        [random]\ninputs = [\"static_friction\"]\nrelative_std = 0.2\n\n[criterion]\nkind = \"time-domain\"\n\
        disc = \"rigid\"\n\n[sampling]\nsamples = 200\nseed = 5\n"
    )
}

#[test]
fn a_run_with_a_measured_curve_resumes_without_its_file() {
    let place = Place::new();
    fs::create_dir(place.path("data")).unwrap();
    place.write("data/curve.csv", CURVE);
    place.write("job.toml", &job("law = \"table\"\ntable = \"data/curve.csv\""));
    place.run("submit job.toml --out whole").done();
    let inline = "table = { speed = [0, 0.2, 1, 3, 8], coefficient = [0.45, 0.38, 0.26, 0.24, 0.29], \
        std = [0.02, 0.02, 0.01, 0.01, 0.02] }";
    place.write("inline.toml", &job(&format!("law = \"table\"\n{inline}")));
    fs::remove_file(place.path("data/curve.csv")).unwrap();
    let frozen = fs::read_to_string(place.path("whole/job.toml")).unwrap();
    assert!(frozen.starts_with("# model.friction.table: measured curve from \"data/curve.csv\""), "{frozen}");
    // The same job, whatever has the curve.
    let said = place.run("submit inline.toml --out whole").done();
    assert!(said.stderr.contains("already") || said.stdout.contains("already"), "{} {}", said.stdout, said.stderr);
    place.run("resume whole").done();
    place.write("other.toml", &job(&format!("law = \"table\"\n{}", inline.replace("0.29]", "0.3]"))));
    place.run("submit other.toml --out whole").refused(65, &[]);
}

#[test]
fn every_law_is_decided_alike_by_one_sample_and_by_many() {
    let place = Place::new();
    place.write("curve.csv", CURVE);
    for (name, friction) in [
        ("gaussian", "stribeck_exponent = 2"),
        ("general", "stribeck_exponent = 1.4"),
        ("viscous", "viscous = 0.004"),
        ("rational", "law = \"rational\""),
        ("table", "law = \"table\"\ntable = \"curve.csv\"\nband = 0.5"),
    ] {
        place.write("job.toml", &job(friction));
        place.run(&format!("submit job.toml --out {name}")).done();
        place.run(&format!("replay {name} --cell 0 --sample 17")).done();
    }
}

#[test]
fn a_random_band_scatters_about_zero() {
    let place = Place::new();
    place.write("curve.csv", CURVE);
    let text = job("law = \"table\"\ntable = \"curve.csv\"").replace(
        "inputs = [\"static_friction\"]\nrelative_std = 0.2",
        "inputs = [\"friction.band\"]\nstd = { \"friction.band\" = 1 }",
    );
    place.write("job.toml", &text);
    let said = place.run("submit job.toml").done();
    assert!(!said.stderr.contains("does not scatter"), "{}", said.stderr);
    let band = |sample: u32| {
        let said = place.run(&format!("replay runs/law --cell 0 --sample {sample} --json")).done().stdout;
        serde_json::from_str::<serde_json::Value>(&said).unwrap()["friction.band"].as_f64().unwrap()
    };
    let bands: Vec<f64> = (0..20).map(band).collect();
    assert!(bands.iter().any(|z| *z < -0.3) && bands.iter().any(|z| *z > 0.3), "{bands:?}");
    assert!(bands.iter().all(|z| z.abs() < 4.5), "{bands:?}");
}

#[test]
fn keys_of_other_laws_are_refused() {
    for (friction, texts) in [
        (
            "law = \"rational\"\nstribeck_exponent = 2",
            &["job.toml:5:21", "model.friction.stribeck_exponent belongs to law = \"stribeck\"", "is \"rational\""][..],
        ),
        ("law = \"table\"\ntable = \"curve.csv\"\nviscous = 0.1", &["friction.viscous belongs to", "is \"table\""]),
        ("law = \"table\"\ntable = \"curve.csv\"\nkinetic_coefficient = 0.1", &["kinetic_coefficient belongs to"]),
        ("band = 1", &["friction.band belongs to law = \"table\"", "is \"stribeck\""]),
        ("table = \"curve.csv\"", &["model.friction.table belongs to law = \"table\"", "write law = \"table\""]),
        ("law = \"table\"", &["job.toml:4:7", "needs the measured curve: table = \"curve.csv\""]),
        ("law = \"tabel\"", &["job.toml:4:7", "unknown value `tabel`; did you mean `table`?"]),
        ("law = \"table\"\ntable = 3", &["job.toml:5:9", "model.friction.table"]),
        ("law = \"table\"\ntable = { speed = [0, 1] }", &["coefficient"]),
        ("law = \"table\"\ntable = { speed = [0], coefficient = [0.3] }", &["at least two rows", "has 1"]),
        ("stribeck_exponent = 0", &["friction.stribeck_exponent = 0 is out of range", "greater than 0"]),
        (
            "law = \"rational\"\nstribeck_velocty = 2",
            &["unknown key `stribeck_velocty`", "did you mean `stribeck_velocity`?"],
        ),
    ] {
        let place = Place::new();
        place.write("curve.csv", CURVE);
        place.write("job.toml", &job(friction));
        place.run("check job.toml").refused(65, texts);
    }
}

#[test]
fn random_inputs_and_axes_of_other_laws_are_refused() {
    let place = Place::new();
    place.write("curve.csv", "speed,coefficient\n0,0.4\n1,0.3\n");
    let random = |friction: &str, input: &str| {
        let scatter = match input {
            "friction.band" => "std = { \"friction.band\" = 1 }",
            _ => "relative_std = 0.2",
        };
        job(friction)
            .replace("inputs = [\"static_friction\"]", &format!("inputs = [\"{input}\"]"))
            .replace("relative_std = 0.2", scatter)
    };
    let table = "law = \"table\"\ntable = \"curve.csv\"";
    let axis = |friction: &str, axis: &str| {
        job(friction).replace("preload = 0.1", &format!("preload = 0.1\n\"{axis}\" = [1, 2]"))
    };
    for (text, texts) in [
        (
            axis(table, "friction.stribeck_velocity"),
            &["job.toml:10:1", "axes: friction.stribeck_velocity belongs to"][..],
        ),
        (axis("viscous = 0", "friction.band"), &["axes: friction.band belongs to"]),
        (random(table, "friction.stribeck_velocity"), &["random.inputs: friction.stribeck_velocity belongs to"]),
        (random(table, "friction.band"), &["no column std"]),
        (random("viscous = 0", "friction.band"), &["friction.band belongs to law = \"table\""]),
        (random("law = \"rational\"", "friction.stribeck_exponent"), &["friction.stribeck_exponent belongs to"]),
    ] {
        place.write("job.toml", &text);
        place.run("check job.toml").refused(65, texts);
    }
}

#[test]
fn bad_tables_are_refused_with_file_line_value_and_remedy() {
    let place = Place::new();
    place.write("job.toml", &job("law = \"table\"\ntable = \"curve.csv\""));
    place.run("check job.toml").refused(65, &["job.toml:5:9", "cannot read curve.csv"]);
    for (curve, texts) in [
        ("speed,coefficient\n0,0.4\n", &["curve.csv: ", "at least two rows", "has 1"][..]),
        ("speed,coefficient\n", &["at least two rows", "has 0"]),
        ("speed,coefficient\n0,0.4\n2,0.3\n1,0.3\n", &["curve.csv:4", "speed = 1 does not exceed 2", "sort"]),
        ("speed,coefficient\n0,0.4\n1,0.3\n1,0.3\n", &["curve.csv:4", "make one row"]),
        ("speed,coefficient\n0,0.4\n\n1,-0.3\n", &["curve.csv:4", "coefficient = -0.3 is out of range", "at least 0"]),
        ("speed,coefficient\n-1,0.4\n1,0.3\n", &["curve.csv:2", "speed = -1 is out of range"]),
        ("speed,coefficient\n0,0.4\n1,nan\n", &["curve.csv:3", "\"nan\" in column \"coefficient\""]),
        ("speed,coefficient\n0,0.4\n1,low\n", &["curve.csv:3", "\"low\"", "such as 0.41"]),
        ("speed,mu\n0,0.4\n1,0.3\n", &["curve.csv:1", "column \"mu\"", "speed, coefficient and perhaps std"]),
        ("speed,std\n0,0.4\n1,0.3\n", &["curve.csv:1", "no column \"coefficient\""]),
        ("speed,coefficient\n0,0.4\n1\n", &["curve.csv:3", "1 fields"]),
        ("speed,coefficient\n0,0\n1,0.3\n", &["curve.csv:2", "must be positive"]),
        ("speed,coefficient,std\n0,0.4,-1\n1,0.3,0\n", &["curve.csv:2", "std = -1"]),
    ] {
        place.write("curve.csv", curve);
        place.run("check job.toml").refused(65, texts);
    }
}

#[test]
fn one_point_takes_any_law() {
    let place = Place::new();
    place.write("curve.csv", CURVE);
    let analysis = |changes: &str| {
        let said = place.run(&format!("analyse {changes} --json")).done().stdout;
        serde_json::from_str::<serde_json::Value>(&said).unwrap()
    };
    let rational = analysis("--set friction.law=rational");
    // (1 + v / v_s)^2 = G (f_s - f_c) / (v_s c): half a percent of the preset's product with 16 rad/s is enough to
    // place it.
    let critical = rational["critical_speed_rad_s"].as_f64().unwrap();
    let slower =
        analysis(&format!("--set friction.law=rational --set operating_point.rotating_speed={}", critical * 0.999));
    assert!(slower["growth_rate"].as_f64().unwrap() > 0.0);
    let faster =
        analysis(&format!("--set friction.law=rational --set operating_point.rotating_speed={}", critical * 1.001));
    assert!(faster["growth_rate"].as_f64().unwrap() < 0.0);
    let table = analysis("--set friction.table=curve.csv --set operating_point.rotating_speed=7");
    assert!((table["friction_coefficient"].as_f64().unwrap() - 0.26).abs() < 0.02, "{table}");
    place.run("trajectory --set friction.law=table --set friction.table=curve.csv --disc rigid").done();
    place.run("analyse --set friction.law=table").refused(64, &["friction.table=FILE"]);
    place.run("analyse --set friction.law=tabel").refused(64, &["did you mean \"table\"?"]);
    place.run("analyse --set friction.law=rational --set friction.band=1").refused(64, &["friction.band belongs to"]);
}

/// A place with the noisy curve of `tests/data/friction` and its job.
fn noisy() -> Place {
    let place = Place::new();
    for file in ["noisy-curve.csv", "noisy-curve.toml"] {
        fs::copy(repository().join("tests/data/friction").join(file), place.path(file)).unwrap();
    }
    place
}

#[test]
fn a_noisy_curve_is_warned_of_with_the_ranges_that_the_grid_does_not_show() {
    let place = noisy();
    let checked = place.run("check noisy-curve.toml").done();
    assert!(
        checked.stdout.contains(
            "# friction curve: 40 rows from 0 to 1.950 m/s; from row to row it falls 11 times and rises 10 times\n# steady \
             sliding with the other values of cell 9: unstable at belt_speed 0 to 0."
        ),
        "{}",
        checked.stdout
    );
    let submitted = place.run("submit noisy-curve.toml --samples 1000").done();
    // With its own damping this curve has limit cycles in nine ranges of speed, whose ends take 20 seconds to find.
    let analysed = place.run("analyse --job noisy-curve.toml --set damping=400").done();
    assert!(analysed.stdout.contains("friction curve     40 rows from 0 to 1.950 m/s; "), "{}", analysed.stdout);
    for said in [checked.stderr, submitted.stderr, analysed.stderr] {
        for text in [
            "friction.table falls 11 times and rises 10 times between its 40 rows, which is probably noise",
            "unstable in 7 ranges of speed between two values of axes.belt_speed, so that no cell shows them: 0.80",
        ] {
            assert!(said.contains(text), "{text:?} is not in: {said}");
        }
        assert_eq!(said.matches("warning: ").count(), 2, "{said}");
    }
}

#[test]
fn speeds_between_those_of_a_pad_job_at_which_a_measured_curve_falls_are_named() {
    let place = Place::new();
    // Between 1.6 and 2.3 m/s and between 3.0 and 3.8 m/s, under a pad whose disc is 0.135 m in radius.
    place.write("curve.csv", "speed,coefficient\n0,0.4\n1.6,0.402\n2.3,0.352\n3,0.354\n3.8,0.3\n6,0.302\n");
    let text = job("law = \"table\"\ntable = \"curve.csv\"")
        .replace("rotating_speed = [2, 8]", "rotating_speed = [10, 20, 30]")
        .replace("kind = \"time-domain\"\ndisc = \"rigid\"", "kind = \"eigenvalue\"");
    place.write("job.toml", &text);
    let json: serde_json::Value =
        serde_json::from_str(&place.run("analyse --job job.toml --json").done().stdout).unwrap();
    let ranges: Vec<[f64; 2]> = serde_json::from_value(json["unstable_speeds"].clone()).unwrap();
    let falls = [[1.6, 2.3], [3.0, 3.8]].map(|ends| ends.map(|speed| speed / 0.135));
    assert_eq!(ranges.len(), 2, "{ranges:?}");
    for ([from, to], [first, last]) in ranges.iter().zip(falls) {
        assert!((first..first + 0.5).contains(from) && (last - 0.5..=last).contains(to), "{ranges:?} {falls:?}");
    }
    let listed: Vec<String> = ranges.iter().map(|[from, to]| format!("{from:.2} to {to:.2}")).collect();
    let warning = format!(
        "steady sliding on a rigid disc is unstable in 2 ranges of speed between two values of axes.rotating_speed, so that \
         no cell shows them: {} rad/s (with the other values of cell 1)",
        listed.join(", ")
    );
    let curve = "6 rows from 0 to 6.000 m/s; from row to row it falls twice and rises 3 times";
    let checked = place.run("check job.toml").done();
    let analysed = place.run("analyse --job job.toml").done();
    assert!(checked.stdout.contains(&format!("# friction curve: {curve}\n")), "{}", checked.stdout);
    let at = format!("unstable at rotating_speed {} rad/s\n", listed.join(", "));
    assert!(checked.stdout.contains(&at), "{at}: {}", checked.stdout);
    assert!(analysed.stdout.contains(&format!("friction curve     {curve}\n")), "{}", analysed.stdout);
    let submitted = place.run("submit job.toml").done();
    for said in [checked.stderr, submitted.stderr, analysed.stderr] {
        assert!(said.contains(&warning), "{warning:?} is not in: {said}");
    }
    // With values in both ranges there is nothing to warn of.
    place.write("fine.toml", &text.replace("[10, 20, 30]", "[10, 15, 20, 25, 30]"));
    assert!(!place.run("check fine.toml").done().stderr.contains("warning: "));
}

#[test]
fn a_curve_in_millimetres_and_negative_friction_are_warned_of() {
    let place = Place::new();
    let checked = |curve: &str, scatter: &str| {
        place.write("curve.csv", curve);
        let text = job("law = \"table\"\ntable = \"curve.csv\"");
        place.write("job.toml", &text.replace("relative_std = 0.2", scatter));
        place.run("check job.toml")
    };
    let scatter = "relative_std = 0.2";
    assert!(!checked(CURVE, scatter).done().stderr.contains("not plausible"));
    for (curve, text) in [
        ("speed,coefficient\n0,0.45\n200,0.4\n900,0.3\n", "reaches 900.0 m/s"),
        ("speed,coefficient\n0,0.45\n5,0.4\n20,0.3\n", "did you mean 0.005000 m/s (5.000 mm/s)?"),
    ] {
        let said = checked(curve, scatter).done().stderr;
        assert!(said.contains("warning: friction.table is not plausible: ") && said.contains(text), "{said}");
    }
    checked("speed,coefficient\n0,0.45\n1500,0.3\n", scatter)
        .refused(65, &["curve.csv:3", "speed = 1500 is out of range", "did you mean 1.500 m/s (1500 mm/s)?"]);
    let said = checked(CURVE, "relative_std = 1").done().stderr;
    for text in ["static_friction = 1 is not plausible: 15.9 % of its values are negative", "\"lognormal\""] {
        assert!(said.contains(text), "{text:?} is not in: {said}");
    }
}

/// The job on the noisy curve, smoothed.
fn smoothed(place: &Place) -> String {
    let text = fs::read_to_string(place.path("noisy-curve.toml")).unwrap();
    let table = "table = \"noisy-curve.csv\"";
    assert!(text.contains(table), "{text}");
    text.replace(table, &format!("{table}\nsmoothing = \"spline\""))
}

#[test]
fn a_smoothed_curve_is_unstable_in_one_range_and_says_its_residual() {
    let place = noisy();
    place.write("smooth.toml", &smoothed(&place));
    let checked = place.run("check smooth.toml").done();
    assert!(!checked.stderr.contains("warning: "), "{}", checked.stderr);
    let residual = "smoothed by a spline with 5.2 free parameters, from which they differ by 0.006166 (root mean square); from row to \
                    row it falls once and rises never";
    for text in [residual, "unstable at belt_speed 0 to 0.7"] {
        assert!(checked.stdout.contains(text), "{text:?} is not in: {}", checked.stdout);
    }
    let analysed = place.run("analyse --job smooth.toml").done();
    assert!(analysed.stdout.contains(residual), "{}", analysed.stdout);
    let json: serde_json::Value =
        serde_json::from_str(&place.run("analyse --job smooth.toml --json").done().stdout).unwrap();
    let ranges: Vec<[f64; 2]> = serde_json::from_value(json["unstable_speeds"].clone()).unwrap();
    // A program in Python found 0.724.
    assert!(ranges.len() == 1 && ranges[0][0] == 0.0 && (ranges[0][1] - 0.724).abs() < 0.002, "{ranges:?}");
}

#[test]
fn a_run_with_a_smoothed_curve_keeps_the_rows_as_measured() {
    let place = noisy();
    place.write("smooth.toml", &smoothed(&place));
    place.run("submit smooth.toml --samples 1000 --out run").done();
    let frozen = fs::read_to_string(place.path("run/job.toml")).unwrap();
    assert!(frozen.contains("0.494, 0.4525, 0.4381") && frozen.contains("smoothing = \"spline\""), "{frozen}");
    // The job with every default is the same job; without the smoothing it is another one.
    let written = place.run("check --all run/job.toml").done().stdout;
    assert!(written.contains("0.494, 0.4525") && written.contains("smoothing = \"spline\""), "{written}");
    fs::remove_file(place.path("noisy-curve.csv")).unwrap();
    place.write("written.toml", &written);
    let said = place.run("submit written.toml --out run").done();
    assert!(said.stderr.contains("already") || said.stdout.contains("already"), "{} {}", said.stdout, said.stderr);
    place.write("rough.toml", &written.replace("smoothing = \"spline\"\n", ""));
    place.run("submit rough.toml --out run").refused(65, &[]);
}

#[test]
fn rows_and_smoothed_curve_are_drawn() {
    let place = noisy();
    place.write("smooth.toml", &smoothed(&place));
    let drawn = place.run("plot smooth.toml --of friction").done().stdout;
    assert_eq!(drawn, "smooth-friction.svg\nsmooth-friction.png\n");
    let svg = fs::read_to_string(place.path("smooth-friction.svg")).unwrap();
    for text in [">rows of the table<", ">curve of the model<", ">steady sliding is unstable<", "0.006166"] {
        assert!(svg.contains(text), "{text:?} is not in the picture");
    }
    place.run("submit smooth.toml --samples 1000 --out run").done();
    place.run("report run").done();
    let report = fs::read_to_string(place.path("run/report.html")).unwrap();
    assert!(report.contains("<h2 id=\"friction-heading\">Measured friction</h2>"));
    place.write("stribeck.toml", &job("viscous = 0.0"));
    place
        .run("plot stribeck.toml --of friction")
        .refused(65, &["\"law\" has no measured friction curve", "law = \"table\""]);
}

#[test]
fn a_smoothing_that_cannot_be_is_refused() {
    let place = noisy();
    place.write("curve.csv", "speed,coefficient\n0,0.4\n1,0.3\n2,0.25\n3,0.25\n");
    for (friction, texts) in [
        ("smoothing = \"spline\"", &["job.toml:4:13", "model.friction.smoothing belongs to law = \"table\""][..]),
        ("law = \"table\"\ntable = \"curve.csv\"\nsmoothing = \"spline\"", &["curve.csv", "at least 5 rows", "has 4"]),
        ("law = \"table\"\ntable = \"noisy-curve.csv\"\nsmoothing = \"splin\"", &["job.toml:6:13", "splin"]),
    ] {
        place.write("job.toml", &job(friction));
        place.run("check job.toml").refused(65, texts);
    }
    let set = "--set friction.table=noisy-curve.csv --set friction.smoothing=spline";
    let listed = place.run(&format!("parameters {set}")).done().stdout;
    assert!(listed.contains(" spline*") && listed.contains(" 40 rows*"), "{listed}");
    let analysed = place.run(&format!("analyse {set}")).done().stdout;
    assert!(analysed.contains("friction curve     40 rows from 0 to 1.950 m/s, smoothed by a spline"), "{analysed}");
    for (set, text) in [
        ("friction.smoothing=spline", "friction.smoothing belongs to law = \"table\""),
        ("friction.table=noisy-curve.csv --set friction.smoothing=loess", "there is no smoothing \"loess\""),
    ] {
        place.run(&format!("analyse --set {set}")).refused(64, &[text]);
    }
}
