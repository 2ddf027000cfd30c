//! Jobs with friction laws other than Tustin's: what they compute, which messages they get, and how they resume.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so and stop")]

use std::fs;

use crate::common::Place;

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
