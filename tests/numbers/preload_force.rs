//! The preload by the clamp force, in newtons.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so and stop")]

use crate::common::{Outcome, Place, Table, submitted};

/// A job with these axes and further tables; only the preload scatters.
fn job(axes: &str, tables: &str) -> String {
    format!(
        "name = \"clamp\"\n[axes]\n{axes}\nstatic_friction = 0.45\n{tables}\n[random]\ninputs = [\"preload\"]\n\
         relative_std = 0.2\n[criterion]\nkind = \"eigenvalue\"\n"
    )
}

#[track_caller]
fn checked(text: &str) -> Outcome {
    let place = Place::new();
    place.write("job.toml", text);
    place.run("check job.toml")
}

/// N = h Delta k_en k_y / (k_en + k_y), solved for Delta.
fn preload(force: f64, thickness: f64, contact: f64, calliper: f64) -> f64 {
    force * (contact + calliper) / (thickness * contact * calliper)
}

#[test]
fn forces_become_the_preloads_that_press_with_them() {
    let place = Place::new();
    for (i, (axes, tables, contact)) in [
        ("preload_force = [2000, 20_000.0]", "", 3.816e7),
        ("operating_point.preload_force = [2000, 20_000.0]", "[model.stiffness]\ncontact_normal = 5e7", 5e7),
        ("preload_force = { from = 2000, to = 20_000, points = 2 }\nstiffness.contact_normal = 5e7", "", 5e7),
    ]
    .into_iter()
    .enumerate()
    {
        let table = submitted(&place, &format!("run{i}"), &job(axes, tables));
        for (found, force) in table.column("preload").iter().zip([2000.0, 20_000.0]) {
            let expected = preload(force, 0.02, contact, 3.249e7);
            assert!((found / expected - 1.0).abs() < 1e-14, "{axes}: {found}, not {expected}");
            // And back: what `analyse` says of this preload is the force that was given.
            let said = place.run(&format!(
                "analyse --json --set operating_point.preload={found} --set stiffness.contact_normal={contact}"
            ));
            let analysis: serde_json::Value = serde_json::from_str(&said.done().stdout).unwrap();
            let back = analysis["normal_force_n"].as_f64().unwrap();
            assert!((back / force - 1.0).abs() < 1e-14, "{back}, not {force}");
        }
    }
}

#[test]
fn a_job_in_newtons_is_the_job_with_these_preloads() {
    let place = Place::new();
    let hash = |table: &Table| table.footer.iter().find(|(key, _)| key == "stickslip:job_hash").unwrap().1.clone();
    let by_force = submitted(&place, "force", &job("preload_force = [2000, 20_000]", ""));
    let preloads: Vec<String> = by_force.column("preload").iter().map(f64::to_string).collect();
    let by_preload = submitted(&place, "preload", &job(&format!("preload = [{}]", preloads.join(", ")), ""));
    assert_eq!(by_force.digest(), by_preload.digest());
    assert_eq!(hash(&by_force), hash(&by_preload));
    // The value of the model, in place of an axis.
    let of_model = submitted(&place, "model", &job("", "[model.operating_point]\npreload_force = 20_000"));
    assert_eq!(of_model.column("preload"), &by_force.column("preload")[1..]);
    // What check prints says the same again.
    let normalised = place.run("check --all force.toml").done().stdout;
    assert!(normalised.contains("# expected contact force on a rigid disc: 2.000 kN to 20.00 kN\n"), "{normalised}");
    assert_eq!(hash(&submitted(&place, "again", &normalised)), hash(&by_force));
}

#[test]
fn a_force_that_cannot_be_meant_is_refused_with_a_remedy() {
    let force = "preload_force = [200, 2000]";
    for (text, texts) in [
        (
            job(&format!("{force}\npreload = 0.1"), ""),
            &[
                "job.toml:3:1: axes.preload_force is the same axis as axes.preload; remove one",
                "job.toml:4:1: and here",
            ][..],
        ),
        (
            job(force, "[model.operating_point]\npreload = 0.1"),
            &["job.toml:6:11: model.operating_point.preload = 0.1 is given a second time as axes.preload_force"],
        ),
        (
            job("preload = 0.1", "[model.operating_point]\npreload_force = 200"),
            &["job.toml:6:17: model.operating_point.preload_force = 200 is given a second time as axes.preload"],
        ),
        (
            job("", "[model.operating_point]\npreload_force = 200\npreload = 0.2"),
            &[
                "job.toml:6:17: model.operating_point.preload_force = 200 is given a second time as model.operating_point.preload = 0.2",
            ],
        ),
        (
            job(&format!("{force}\ndisc.thickness = [0.02, 0.03]"), ""),
            &[
                "job.toml:3:17: axes.preload_force: the preload of a force depends on disc.thickness, which is an axis",
                "Give axes.preload in place of the force",
                "job.toml:4:18: and here",
            ],
        ),
        (
            job("preload_force = [200, 4e5]", ""),
            &["job.toml:3:17: axes.preload_force: 400000 is out of range", "at least 0 and at most 350975 N"],
        ),
        (
            job("", "[model.operating_point]\npreload_force = -1"),
            &["job.toml:6:17: model.operating_point.preload_force: -1 is out of range"],
        ),
        (
            job(force, "").replace("[\"preload\"]", "[\"preload_force\"]"),
            &["job.toml:7:11: random.inputs: write \"preload\" for \"preload_force\"", "relative standard deviation"],
        ),
        (
            job(force, "").replace("relative_std = 0.2", "relative_std = { preload_force = 0.2 }"),
            &["job.toml:8:16: random.relative_std: write \"preload\" for \"preload_force\""],
        ),
        (job("preload = 2000", ""), &["write 0.00569842 for 2000 N, or give preload_force = 2000 in its place"]),
        (job("preload_force = \"2 kN\"", ""), &["job.toml:3:17: axes.preload_force: 2 kN has a unit", "2 kN = 2000 N"]),
    ] {
        checked(&text).refused(65, texts);
    }
}

#[test]
fn analyse_takes_a_force() {
    let place = Place::new();
    let analysis = |options: &str| {
        let said = place.run(&format!("analyse --json {options}")).done().stdout;
        let value: serde_json::Value = serde_json::from_str(&said).unwrap();
        value["normal_force_n"].as_f64().unwrap()
    };
    // With the stiffness that is set, in whatever order.
    for options in [
        "--set operating_point.preload_force=2000",
        "--set operating_point.preload_force=2000 --set stiffness.contact_normal=6e7 --set disc.thickness=0.03",
        "--set stiffness.contact_normal=6e7 --set operating_point.preload_force=2000",
    ] {
        let force = analysis(options);
        assert!((force / 2000.0 - 1.0).abs() < 1e-14, "{options}: {force}");
    }
    place
        .run("analyse --set operating_point.preload_force=2000 --set operating_point.preload=0.2")
        .refused(64, &["the preload is set too, operating_point.preload=0.2; leave one of the two out"]);
    let short = place.run("analyse --set preload_force=2000").done().stdout;
    assert_eq!(short, place.run("analyse --set operating_point.preload_force=2000").done().stdout);
    place.run("trajectory --set operating_point.preload_force=1e6").refused(64, &["at least 0 and at most 350975 N"]);
}
