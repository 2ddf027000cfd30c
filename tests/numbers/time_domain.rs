//! Runs that simulate every sample, single motions and replays, through the command line.

#![allow(clippy::disallowed_methods, reason = "formulas as a textbook writes them")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so and stop")]

use crate::common::{Place, Table, repository, surface_job};

/// A job over `points` by `points` cells around Figure 14b; `criterion` are lines after `kind = "time-domain"`.
fn job(name: &str, points: usize, samples: u64, criterion: &str) -> String {
    let kind = format!("kind = \"time-domain\"\n{criterion}");
    surface_job(name, points, samples, 3).replace("kind = \"eigenvalue\"", &kind)
}

/// Digests of all columns. Regression values of results version 1, see `tests/runs/determinism.rs`.
const GOLDEN: [(&str, &str, &str); 4] = [
    ("flexible", "disc = \"flexible\"", "cc714dc8ec29ad59124085b86e7702c4"),
    ("rigid-rest", "disc = \"rigid\"\nstart = \"rest\"\nrecord = [\"amplitude\"]", "63ab478241371e34963b7579ccd720c7"),
    (
        "flexible-limit-cycle",
        "start = \"limit-cycle\"\ndisc_modes = 4\nindex = { amplitude = 0.006 }",
        "754710b609d8f44be5bfab6e804f76fa",
    ),
    ("short", "disc = \"rigid\"\nhorizon = 4.0\ndisplacement = 0.2", "e79803304df08efdb11ab27b14e9e091"),
];

#[test]
fn result_columns_are_pinned() {
    let place = Place::new();
    let mut found = Vec::new();
    for (name, criterion, _) in GOLDEN {
        place.write("job.toml", &job(name, 4, 60, criterion));
        place.run("submit job.toml").done();
        found.push((name, Table::read(&place.path(&format!("runs/{name}/surface.parquet"))).digest()));
    }
    let expected: Vec<_> = GOLDEN.iter().map(|(name, _, digest)| (*name, (*digest).to_owned())).collect();
    assert_eq!(found, expected);
}

#[test]
fn enough_disc_modes_are_chosen_and_too_few_cause_a_warning() {
    let place = Place::new();
    let check = |modes: &str, model: &str| {
        let spec = job("modes", 3, 10, modes).replace("[axes]", &format!("{model}\n\n[axes]"));
        place.write("job.toml", &spec);
        let checked = place.run("check --all job.toml").done();
        (checked.stdout, checked.stderr)
    };
    let (default, _) = check("", "");
    let (auto, quiet) = check("disc_modes = \"auto\"", "");
    assert!(default.contains("disc_modes = 5\n") && auto.contains("disc_modes = 5\n"), "{default}\n{auto}");
    assert!(!quiet.contains("warning"), "{quiet}");
    let (_, warned) = check("disc_modes = 4", "");
    assert!(
        warned.contains("warning: 4 disc modes: growth rate") && warned.contains("use disc_modes = \"auto\""),
        "{warned}"
    );
    let soft = "[model.disc]\nthickness = 0.010\nyoungs_modulus = 7e10";
    let (chosen, _) = check("", soft);
    assert!(!chosen.contains("disc_modes = 5\n"), "{chosen}");
    let (_, warned) = check("disc_modes = 5", soft);
    assert!(warned.contains("warning: 5 disc modes: growth rate"), "{warned}");
    // A disc so soft that the pad presses it in places has an equilibrium with any number of modes.
    let soft = "[model.disc]\nthickness = 0.002\nyoungs_modulus = 7.7e10\ninner_radius = 0.026\nouter_radius = 0.074\n\n[model.pad]\ninner_radius = 0.071";
    for modes in ["disc_modes = 8", "disc_modes = 12", "disc_modes = 24"] {
        check(modes, soft);
    }
    let (chosen, _) = check("", soft);
    assert!(!chosen.contains("disc_modes = 5\n"), "{chosen}");
    // A thin ring needs more modes than there are.
    let ring = "[model.disc]\nthickness = 0.002\ninner_radius = 0.075\nouter_radius = 0.090\n\n[model.pad]\ninner_radius = 0.078";
    let (chosen, warned) = check("", ring);
    assert!(chosen.contains("disc_modes = 24\n"), "{chosen}");
    assert!(
        warned.contains("warning: 24 disc modes: growth rate") && warned.contains("an error remains in results"),
        "{warned}"
    );
}

#[test]
fn threads_shards_and_interruptions_do_not_change_a_byte() {
    let place = Place::new();
    // Several units in each cell, with amplitudes, whose sums would show any dependence on order.
    place.write("job.toml", &job("job", 4, 4500, "disc = \"rigid\"\nstart = \"rest\"\nrecord = [\"amplitude\"]"));
    place.run("submit job.toml --out whole --threads 1").done();
    for threads in [2, 3] {
        place.run(&format!("submit job.toml --out {threads} --threads {threads}")).done();
        assert!(place.surface("whole") == place.surface(&threads.to_string()), "{threads} threads");
    }
    for count in [2, 5] {
        for index in (1..=count).rev() {
            place.run(&format!("submit job.toml --out by-{count} --shard {index}/{count}")).done();
        }
        place.run(&format!("merge by-{count}")).done();
        assert!(place.surface("whole") == place.surface(&format!("by-{count}")), "{count} shards");
    }
    place.assert_survives_kills("whole", &[30, 60, 90, 120, 200, 300], 3);
    // First fewer samples, then the rest.
    place.run("submit job.toml --out grown --samples 1700").done();
    place.run("submit job.toml --out grown").done();
    assert!(place.surface("whole") == place.surface("grown"));
}

fn json(text: &str) -> serde_json::Value {
    serde_json::from_str(text).unwrap()
}

#[test]
fn limit_cycles_have_the_tabulated_values() {
    // Physics notes, section 7: adaptive Runge-Kutta, tolerance 1e-11, outside Rust.
    let place = Place::new();
    for (speed, period, largest, smallest, stick) in
        [(10.0, 3.56373, 0.014309, 0.003465, 0.3756), (20.0, 3.10909, 0.016207, 0.001879, 0.1873)]
    {
        let words = format!("trajectory --disc rigid --start rest --set operating_point.rotating_speed={speed} --json");
        let summary = json(&place.run(&words).done().stdout);
        let value = |key: &str| summary[key].as_f64().unwrap();
        assert_eq!(summary["verdict"], "unstable");
        assert!((value("period") - period).abs() < 1e-4, "{summary}");
        assert!((value("x_max") - largest).abs() < 1e-6 && (value("x_min") - smallest).abs() < 1e-6, "{summary}");
        assert!((value("stick_fraction") - stick).abs() < 1e-4, "{summary}");
    }
    // Above both boundaries the pad comes to rest: there is no period.
    let quiet =
        place.run("trajectory --set operating_point.rotating_speed=35 --start rest --horizon 2000 --json").done();
    let quiet = json(&quiet.stdout);
    assert_eq!(
        (&quiet["verdict"], &quiet["period"], quiet["stick_fraction"].as_f64()),
        (&"stable".into(), &serde_json::Value::Null, Some(0.0))
    );
}

#[test]
fn a_motion_that_still_grows_is_not_called_settled() {
    // Just below the critical speed 15.560 rad/s; the limit cycle there has an amplitude of 0.0064 h.
    let place = Place::new();
    for (start, has_settled) in [("near-equilibrium", false), ("rest", true)] {
        let words = format!("trajectory --disc rigid --set operating_point.rotating_speed=15.5598 --start {start}");
        let shown = place.run(&words).done().stdout;
        assert_eq!(shown.contains("\nSettled motion, over the last quarter"), has_settled, "{shown}");
        assert_eq!(shown.contains("Its amplitude still grows by"), !has_settled, "{shown}");
        let summary = json(&place.run(&format!("{words} --json")).done().stdout);
        assert_eq!(summary["amplitude_change"].is_null(), has_settled, "{summary}");
        assert_eq!((summary["amplitude"].as_f64().unwrap() - 0.0064).abs() < 1e-4, has_settled, "{summary}");
    }
}

/// Amplitudes change by exp(m1 t / 2). At the critical speed the damping is C = 0.332 and the Stribeck ratio r = 2.918,
/// so that m1 is r C = 0.97 times the distance from it, and the amplitude changes by 1.5e-7 and 1.5e-6 in a cycle of
/// 3.0: less than the steps lose, or than shows in a horizon.
#[test]
fn a_motion_that_changes_too_slowly_to_show_it_is_not_called_settled() {
    let place = Place::new();
    let critical = json(&place.run("analyse --json").done().stdout)["critical_speed_rad_s"].as_f64().unwrap();
    for (factor, verdict, way, comes_to) in
        [(1.0 - 1e-7, "unstable", "grows", 0.0064), (1.0 + 1e-6, "stable", "shrinks", 0.0)]
    {
        for horizon in [500, 3000] {
            let words = format!(
                "trajectory --disc rigid --set operating_point.rotating_speed={} --displacement 1e-4 --horizon {horizon}",
                factor * critical
            );
            let summary = json(&place.run(&format!("{words} --json")).done().stdout);
            assert_eq!((&summary["verdict"], &summary["has_settled"]), (&verdict.into(), &false.into()), "{summary}");
            assert!((summary["comes_to"].as_f64().unwrap() - comes_to).abs() < 1e-4, "{summary}");
            assert!(summary["amplitude"].as_f64().unwrap() < 2e-6, "{summary}");
            assert!(summary["amplitude_change"].as_f64().unwrap().abs() < 1e-3, "{summary}");
            let shown = place.run(&words).done().stdout;
            assert!(shown.contains(&format!("Its amplitude still {way}")), "{shown}");
            assert!(shown.contains("a longer --horizon shows what it settles to."), "{shown}");
        }
    }
    // Stick-slip from rest has settled, and so has rest.
    for (speed, horizon) in [(15.5598, 500), (35.0, 2000)] {
        let words = format!(
            "trajectory --disc rigid --set operating_point.rotating_speed={speed} --start rest --horizon {horizon} --json"
        );
        let summary = json(&place.run(&words).done().stdout);
        assert_eq!(summary["has_settled"], true, "{summary}");
        assert!(summary["comes_to"].is_null() && summary["amplitude_change"].is_null(), "{summary}");
    }
}

#[test]
fn unstable_samples_without_a_settled_amplitude_are_counted_and_said() {
    let place = Place::new();
    // From 0.01 x0 the motion first sticks after 11.2 units of scaled time, by a classical Runge-Kutta method in
    // Python.
    let text = |horizon: &str| {
        format!(
            "name = \"short\"\n[axes]\nrotating_speed = 10.0\npreload = 0.1\nstatic_friction = 0.39\n[random]\ninputs = []\n\
             [criterion]\nkind = \"time-domain\"\ndisc = \"rigid\"\nhorizon = {horizon}\nrecord = [\"amplitude\"]\n\
             [sampling]\nsamples = 3\n"
        )
    };
    for (horizon, notes) in [
        (
            "9.0",
            vec!["3 unstable samples have no settled amplitude at the horizon; its mean and quantiles leave them out"],
        ),
        ("1000.0", vec![]),
    ] {
        place.write("short.toml", &text(horizon));
        let out = format!("run-{horizon}");
        let said = json(&place.run(&format!("submit short.toml --out {out} --json")).done().stdout);
        assert_eq!(said["notes"], serde_json::json!(notes), "{said}");
        let surface = Table::read(&place.path(&format!("{out}/surface.parquet")));
        assert_eq!(surface.column("n_unstable"), [3.0]);
        assert_eq!(surface.column("amplitude_mean")[0].is_nan(), horizon == "9.0");
    }
}

#[test]
fn a_trajectory_file_holds_what_the_summary_says() {
    let place = Place::new();
    let summary =
        place.run("trajectory --set operating_point.rotating_speed=10 --start rest --out motion.parquet --json");
    let summary = json(&summary.done().stdout);
    let table = Table::read(&place.path("motion.parquet"));
    let (time, x, sticks) = (table.column("time"), table.column("x"), table.column("sticks"));
    assert_eq!(time.len() as u64, summary["moments"].as_u64().unwrap());
    let interval = summary["interval"].as_f64().unwrap();
    assert!(time.windows(2).all(|pair| (pair[1] - pair[0] - interval).abs() < 1e-9));
    let late = time.iter().position(|&time| time > 400.0).unwrap();
    let largest = x[late..].iter().copied().fold(f64::NEG_INFINITY, f64::max);
    assert!((largest - summary["x_max"].as_f64().unwrap()).abs() < 1e-4);
    let share = sticks[late..].iter().sum::<f64>() / (sticks.len() - late) as f64;
    assert!((share - summary["stick_fraction"].as_f64().unwrap()).abs() < 0.02);
    // In each row, the friction force is the coefficient times the contact force.
    for row in 0..time.len() {
        let ratio = table.column("friction_force_n")[row] / table.column("contact_force_n")[row];
        assert!((ratio - table.column("friction_coefficient")[row]).abs() < 1e-12);
    }
}

#[test]
fn the_papers_grid_with_its_moving_load_agrees_with_the_modes() {
    let place = Place::new();
    let summary = |words: &str| {
        let words =
            format!("trajectory {words} --start rest --horizon 100 --json --set operating_point.rotating_speed=10");
        json(&place.run(&words).done().stdout)
    };
    let modal = summary("");
    let mut before = f64::INFINITY;
    for (grid, tolerance) in [("8x8", 1.5e-3), ("16x16", 5e-4)] {
        let reference = summary(&format!("--disc finite-difference --grid {grid}"));
        assert_eq!(reference["verdict"], "unstable");
        let mut largest = 0.0_f64;
        for key in ["period", "x_max", "x_min", "x_mean", "stick_fraction"] {
            let deviation = (reference[key].as_f64().unwrap() / modal[key].as_f64().unwrap() - 1.0).abs();
            assert!(deviation < tolerance, "{grid} {key}: {deviation}");
            largest = largest.max(deviation);
        }
        assert!(largest < before, "a finer grid comes closer: {largest} {before}");
        before = largest;
    }
    let nodal = summary("--disc finite-difference --grid 16x16 --allotment nodal");
    assert!((nodal["period"].as_f64().unwrap() / modal["period"].as_f64().unwrap() - 1.0).abs() < 2e-3, "{nodal}");
    place.run("trajectory --disc finite-difference --grid 2x8").refused(64, &["grid.radial = 2", "at least 4"]);
    place.run("trajectory --disc finite-difference --grid 8").refused(64, &["not a grid", "12x12"]);
}

#[test]
fn replays_give_the_verdicts_that_the_run_counted() {
    let place = Place::new();
    for (name, criterion) in [("flexible", "disc = \"flexible\""), ("rest", "disc = \"rigid\"\nstart = \"rest\"")] {
        place.write("job.toml", &job(name, 3, 25, criterion));
        place.run("submit job.toml").done();
        let table = Table::read(&place.path(&format!("runs/{name}/surface.parquet")));
        let cell = 4;
        let mut unstable = 0.0;
        for sample in 0..25 {
            let words = format!("replay runs/{name} --cell {cell} --sample {sample} --horizon 20 --json");
            let replayed = json(&place.run(&words).done().stdout);
            unstable += f64::from(u8::from(replayed["verdict_in_run"] == "unstable"));
            if !replayed["verdict"].is_null() {
                assert_eq!(replayed["verdict"], replayed["verdict_in_run"]);
            }
        }
        assert_eq!(unstable, table.column("n_unstable")[cell], "{name}");
    }
    // Two replays agree bit for bit, also in a run by eigenvalues.
    place.write("eigen.toml", &surface_job("eigen", 3, 25, 3));
    place.run("submit eigen.toml").done();
    for run in ["runs/flexible", "runs/eigen"] {
        for file in ["a.parquet", "b.parquet"] {
            place.run(&format!("replay {run} --cell 8 --sample 3 --out {file}")).done();
        }
        assert_eq!(Table::read(&place.path("a.parquet")).digest(), Table::read(&place.path("b.parquet")).digest());
    }
    place.run("replay runs/flexible --cell 9 --sample 0").refused(64, &["cells 0 to 8"]);
    place.run("replay runs/flexible --cell 0 --sample 25").refused(64, &["samples 0 to 24"]);
    place.run("replay runs/nothing --cell 0 --sample 0").refused(74, &["runs/nothing"]);
}

#[test]
fn invalid_criteria_are_refused_with_line_value_and_remedy() {
    let place = Place::new();
    let cases: &[(&str, &[&str])] = &[
        ("horizon = 0", &["job.toml:14:11", "criterion.horizon = 0 is out of range", "greater than 0"]),
        ("horizon = 1e8", &["job.toml:14:11", "horizon = 100000000 is out of range", "at most"]),
        ("horizon = nan", &["job.toml:14:11", "criterion.horizon = NaN"]),
        ("displacement = 0.0", &["job.toml:14:16", "criterion.displacement = 0", "greater than 0"]),
        ("displacement = nan", &["criterion.displacement = NaN"]),
        ("index = { amplitude = -1.0 }", &["job.toml:14:9", "criterion.index.amplitude = -1"]),
        ("index = 0.1", &["it must be a table, for example { amplitude = 0.002 }"]),
        ("disc_modes = -1", &["-1", "a whole number"]),
        ("disc_modes = \"all\"", &["all", "\"auto\" or a whole number"]),
        ("index = { amplitud = 1.0 }", &["amplitud", "did you mean `amplitude`?"]),
        ("record = [\"amplitudes\"]", &["amplitudes", "did you mean `amplitude`?"]),
        ("disc = \"flexibel\"", &["flexibel", "did you mean `flexible`?"]),
        ("start = \"equilibrium\"", &["equilibrium", "near-equilibrium"]),
        ("disc_modes = 0", &["job.toml:14:14", "0 disc modes", "at least 1"]),
        ("disc_modes = 2", &["job.toml:14:14", "2 disc modes carry only 64 %", "4 modes"]),
        ("disc_modes = 99", &["99 disc modes", "at most 24"]),
        ("disc = \"rigid\"\ndisc_modes = 5", &["job.toml:15:14", "no meaning with disc = \"rigid\""]),
    ];
    for (line, texts) in cases {
        place.write("job.toml", &job("bad", 3, 10, line));
        place.run("submit job.toml").refused(65, texts);
    }
    for (section, texts) in [
        ("[model.disc]\ninner_radius = 0.135", ["disc.inner_radius", "must be less than"]),
        ("[model.pad]\ninner_radius = 0.2", ["pad.inner_radius", "must be less than"]),
        ("[model.pad]\nhalf_angle = 4.0", ["pad.half_angle", "at most"]),
        ("[model.disc]\nyoungs_modulus = 1e5", ["criterion", "no sliding equilibrium"]),
    ] {
        let spec = job("bad", 3, 10, "").replace("[axes]", &format!("{section}\n\n[axes]"));
        place.write("job.toml", &spec);
        place.run("submit job.toml").refused(65, &texts);
    }
    let eigen = surface_job("bad", 3, 10, 3);
    place.write("job.toml", &eigen.replace("kind = \"eigenvalue\"", "kind = \"eigenvalue\"\nhorizon = 5.0"));
    place
        .run("submit job.toml")
        .refused(65, &["job.toml:14:11", "criterion.horizon belongs to kind = \"time-domain\""]);
    for (words, texts) in [
        ("--horizon 0", ["--horizon 0", "greater than 0"]),
        ("--horizon nan", ["--horizon NaN", "greater than 0"]),
        ("--horizon 1e12", ["--horizon", "at most"]),
        ("--displacement -0.1", ["--displacement = -0.1", "greater than 0"]),
        ("--set operating_point.preload=0", ["no sliding equilibrium", "preload 0"]),
        ("--disc-modes 1", ["1 disc modes", "4 modes"]),
        ("--disc rigid --disc-modes 5", ["--disc-modes belongs to --disc flexible", "leave it out"]),
        ("--grid 8x8", ["--grid belongs to --disc finite-difference", "leave it out"]),
    ] {
        place.run(&format!("trajectory {words}")).refused(64, &texts);
    }
    place.run("trajectory --out nowhere/motion.parquet").refused(73, &["there is no directory nowhere"]);
    // A link is not replaced by a file.
    std::os::unix::fs::symlink("/dev/null", place.path("link.parquet")).unwrap();
    place.run("trajectory --out link.parquet").refused(73, &["link.parquet is not an ordinary file"]);
    assert!(place.path("link.parquet").symlink_metadata().unwrap().is_symlink());
}

#[test]
fn unstable_samples_are_counted_by_what_feeds_them_and_flutter_is_not_mapped() {
    let place = Place::new();
    let counts = |name: &str, kind: &str, section: &str| {
        let spec = job(name, 3, 40, kind).replace("[axes]", &format!("{section}\n\n[axes]"));
        place.write("job.toml", &spec);
        place.run("submit job.toml").done();
        let table = Table::read(&place.path(&format!("runs/{name}/surface.parquet")));
        let sum = |column: &str| table.column(column).iter().sum::<f64>();
        let fed = ["n_fed_tangential", "n_fed_normal", "n_fed_angular", "n_fed_disc"].map(sum);
        assert_eq!(fed.iter().sum::<f64>(), sum("n_unstable"));
        fed
    };
    let [tangential, others @ ..] = counts("groan", "disc_modes = 5", "");
    assert!(tangential > 50.0 && others == [0.0; 3], "{tangential} {others:?}");
    let undamped = "[model.disc]\ntransverse_damping_ratio = 0";
    let [_, normal, angular, disc] = counts("flutter", "disc_modes = 5", undamped);
    assert!(disc > 50.0 && normal == 0.0 && angular == 0.0, "{disc} {normal} {angular}");
    // Friction that rises with speed would count as stable in a map.
    let spec = job("mapped", 3, 40, "disc_modes = 5").replace("[axes]", &format!("{undamped}\n\n[axes]"));
    place.write("job.toml", &spec.replace("[sampling]", "[sampling]\nevaluate = \"boundary\""));
    place.run("submit job.toml").refused(65, &["unstable although friction does not fall", "evaluate = \"each\""]);
    // With little damping of the rotation the brake is unstable only where friction rises, which some samples do.
    let rising = "name = \"rising\"\n[model.damping]\nangular = 0.001\n[axes]\nrotating_speed = 15.0\npreload = 0.3\n\
        static_friction = 0.27\n[random]\ninputs = [\"preload\", \"static_friction\"]\nrelative_std = 0.3\n\
        [criterion]\nkind = \"coupled-eigenvalue\"\n[sampling]\nsamples = 2000\n";
    for sampling in ["evaluate = \"boundary\"", "method = \"exact\""] {
        let method =
            if sampling.starts_with("method") { rising.replace("samples = 2000\n", "") } else { rising.to_owned() };
        place.write("job.toml", &format!("{method}{sampling}\n"));
        place.run("submit job.toml").refused(65, &["unstable although friction does not fall"]);
    }
    place.write("job.toml", rising);
    let outcome = place.run("submit job.toml").done();
    assert!(outcome.stdout.contains("they are decided as they are"), "{}", outcome.stdout);
    // `compare` simulates its samples again, and finds the verdicts that were counted.
    let outcome = place.run("compare runs/rising runs/rising").done();
    assert!(!outcome.stderr.contains("differ") && !outcome.stderr.contains("map"), "{}", outcome.stderr);
}

#[test]
fn samples_whose_motion_diverges_are_failed_counted_and_shown() {
    let place = Place::new();
    // The calliper is so soft that the pad turns beyond small angles, or over, far from the expected values.
    let spec = job("failing", 1, 400, "disc = \"flexible\"\ndisc_modes = 5")
        .replace("{ from = 0.03, to = 0.30, points = 1 }", "0.3")
        .replace("{ from = 0.27, to = 0.50, points = 1 }", "1.0")
        .replace("[axes]", "[model.stiffness]\ncalliper_angular = 800.0\n\n[axes]")
        .replace("relative_std = 0.2", "relative_std = 1.0");
    place.write("job.toml", &spec);
    let outcome = place.run("submit job.toml").done();
    let table = Table::read(&place.path("runs/failing/surface.parquet"));
    let count = |name: &str| table.column(name)[0];
    assert!(count("n_failed") > 0.0 && count("n_failed") < 400.0, "{}", count("n_failed"));
    assert_eq!(count("n_stable") + count("n_unstable") + count("n_undecided") + count("n_failed"), 400.0);
    assert!(outcome.stdout.contains(&format!("{} failed", count("n_failed"))), "{}", outcome.stdout);
    let status = json(&place.run("status runs/failing --json").done().stdout);
    assert_eq!(status["samples_failed"].as_f64(), Some(count("n_failed")));
    // They widen the interval of the probability.
    let share = count("n_failed") / 400.0;
    assert!(interval_width(&table) >= share, "{} {share}", interval_width(&table));
}

/// Width of the interval of the first cell.
fn interval_width(table: &Table) -> f64 {
    table.column("p_high")[0] - table.column("p_low")[0]
}

#[test]
fn figures_14a_and_14b_nearly_agree_with_either_index() {
    let place = Place::new();
    let text = std::fs::read_to_string(repository().join("jobs/fig14b.toml")).unwrap();
    place.write("fig14b.toml", &text);
    // The paper's index: the settled amplitude. A limit below every limit cycle, above every motion that dies away.
    let index = text.replace("name = \"fig14b\"", "name = \"index\"");
    place.write("index.toml", &index.replace("horizon = 10_000.0", "index = { amplitude = 5e-4 }\nhorizon = 10_000.0"));
    place.run("submit fig14b.toml --samples 15").done();
    place.run("submit index.toml --samples 15").done();
    place.run(&format!("submit {} --samples 15", repository().join("jobs/fig14a.toml").display())).done();
    let [motion, amplitude, linear] =
        ["fig14b", "index", "fig14a"].map(|run| Table::read(&place.path(&format!("runs/{run}/surface.parquet"))));
    let sum = |table: &Table, name: &str| table.column(name).iter().sum::<f64>();
    let samples = sum(&motion, "n_samples");
    assert!(sum(&motion, "n_undecided") <= 1e-3 * samples && sum(&motion, "n_failed") == 0.0);
    let differing = |other: &Table| -> f64 {
        motion.column("n_unstable").iter().zip(other.column("n_unstable")).map(|(a, b)| (a - b).abs()).sum()
    };
    // With the other index, at most one sample in a thousand has another verdict.
    assert!(differing(&amplitude) <= 1e-3 * samples, "{} of {samples}", differing(&amplitude));
    // On a rigid disc, the critical speed differs by one per cent, so a few samples must differ, but not many.
    let by_disc = differing(&linear);
    assert!(by_disc > 0.0 && by_disc < 0.02 * samples, "{by_disc} of {samples}");
}
