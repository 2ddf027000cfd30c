//! Any parameter and any number of the start as an axis, and starts in numbers.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so and stop")]

use std::fs::{self, File};

use crate::common::{EIGENVALUE, Place, Table, submitted};
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;

/// A job with these axes, random inputs, criterion and further sections.
fn job(name: &str, axes: &str, random: &str, criterion: &str, sampling: &str) -> String {
    format!(
        "name = \"{name}\"\n[axes]\n{axes}\n[random]\n{random}\n[criterion]\n{criterion}\n\
         [sampling]\ncommon_random_numbers = true\n{sampling}\n"
    )
}

const RIGID: &str = "kind = \"time-domain\"\ndisc = \"rigid\"";
const SCATTER: &str = "inputs = [\"preload\", \"static_friction\"]\nrelative_std = 0.1";

/// The unit of a column of a run's surface.
fn unit(place: &Place, run: &str, column: &str) -> String {
    let file = File::open(place.path(&format!("{run}/surface.parquet"))).unwrap();
    let schema = ParquetRecordBatchReaderBuilder::try_new(file).unwrap().schema().clone();
    schema.field_with_name(column).unwrap().metadata()["unit"].clone()
}

#[test]
fn a_value_of_an_axis_gives_what_the_same_value_of_the_model_gives() {
    let place = Place::new();
    for (i, (criterion, samples)) in [
        (EIGENVALUE, 2000),
        ("kind = \"coupled-eigenvalue\"\ndisc_modes = 5", 200),
        (RIGID, 200),
        ("kind = \"time-domain\"\ndisc_modes = 5\nhorizon = 500", 10),
    ]
    .into_iter()
    .enumerate()
    {
        let sampling = format!("samples = {samples}");
        for random in [SCATTER, "inputs = [\"preload\", \"stiffness.contact_normal\"]\nrelative_std = 0.1"] {
            let axes = "rotating_speed = [14.0, 16.0]\n\"stiffness.contact_normal\" = [3e7, 5e7]\ndamping.tangential = [369.0, 400.0]";
            let text = job("axes", axes, random, criterion, &sampling);
            let whole = submitted(&place, &format!("axes-{i}-{}", random.len()), &text);
            let unstable = whole.column("n_unstable").to_vec();
            let mut found = Vec::new();
            for stiffness in ["3e7", "5e7"] {
                for damping in ["369.0", "400.0"] {
                    let text = job("model", "rotating_speed = [14.0, 16.0]", random, criterion, &sampling).replace(
                        "[axes]",
                        &format!(
                            "[model]\nstiffness.contact_normal = {stiffness}\ndamping.tangential = {damping}\n[axes]"
                        ),
                    );
                    let name = format!("model-{i}-{}-{stiffness}-{damping}", random.len());
                    found.extend(submitted(&place, &name, &text).column("n_unstable").to_vec());
                }
            }
            assert_eq!(unstable, found, "{criterion} {random}");
            assert!(found.iter().any(|&count| count != found[0]), "{criterion}: {found:?}");
        }
    }
}

#[test]
fn columns_of_axes_have_their_names_units_and_values() {
    let place = Place::new();
    let axes = "start.velocity = [0.0, 0.1]\n\"pad.mass\" = [0.1, 0.2]\n\"disc.density\" = 7800\nstatic_friction = [0.3, 0.4, 0.5]";
    let table = submitted(&place, "run", &job("run", axes, SCATTER, RIGID, "samples = 2"));
    let names = table.names();
    assert_eq!(names[names.len() - 4..], ["disc.density", "pad.mass", "start.velocity", "n_outside_physics"]);
    let mut expected = Vec::new();
    for mass in [0.1, 0.2] {
        for velocity in [0.0, 0.1] {
            for friction in [0.3, 0.4, 0.5] {
                expected.push([7800.0, mass, velocity, friction]);
            }
        }
    }
    let columns =
        ["disc.density", "pad.mass", "start.velocity", "static_friction"].map(|name| table.column(name).to_vec());
    let rows: Vec<[f64; 4]> = (0..12).map(|row| [0, 1, 2, 3].map(|column: usize| columns[column][row])).collect();
    assert_eq!(rows, expected);
    let units = ["kg/m^3", "kg", "m/s"];
    for (name, expected) in ["disc.density", "pad.mass", "start.velocity"].into_iter().zip(units) {
        assert_eq!(unit(&place, "run", name), expected, "{name}");
    }
}

#[test]
fn an_axis_may_be_written_in_any_form_of_toml() {
    let place = Place::new();
    let checked = |text: &str| {
        place.write("job.toml", text);
        let done = place.run("check --all job.toml").done();
        done.stdout.lines().filter(|line| !line.starts_with("# ")).map(str::to_owned).collect::<Vec<_>>()
    };
    let with = |axes: &str| format!("name = \"job\"\n[criterion]\n{RIGID}\n[axes]\n{axes}\n");
    let quoted = checked(&with("\"pad.mass\" = [0.1, 1.0, 10.0]\n\"start.velocity\" = [1.0, 2.0]\npreload = 0.2"));
    let others = [
        "pad.mass = [0.1, 1.0, 10.0]\nstart.velocity = [1.0, 2.0]\npreload = 0.2",
        "preload = 0.2\n[axes.start]\nvelocity = [1.0, 2.0]\n[axes.pad]\nmass = [0.1, 1.0, 10.0]",
        "operating_point.preload = 0.2\nstart = { velocity = [1.0, 2.0] }\npad = { mass = { from = 0.1, to = 10, points = 3, scale = \"log\" } }",
    ];
    for other in others {
        assert_eq!(checked(&with(other)), quoted, "{other}");
    }
    // What `check` shows can itself be submitted, and is the same job.
    assert_eq!(checked(&quoted.join("\n")), quoted);
}

#[test]
fn axes_and_starts_are_refused_with_the_remedy() {
    let place = Place::new();
    let rigid =
        |axes: &str, random: &str, start: &str| job("w", axes, random, &format!("{RIGID}\n{start}"), "samples = 1");
    let cases: &[(String, &[&str])] = &[
        (
            rigid("\"stiffness.contact_nornal\" = 3", "", ""),
            &["w.toml:3:1: there is no axis `stiffness.contact_nornal`; did you mean `\"stiffness.contact_normal\"`?"],
        ),
        (rigid("start.speed = 3", "", ""), &["there is no axis `start.speed`", "start.velocity"]),
        (rigid("start.velosity = 3", "", ""), &["did you mean `\"start.velocity\"`?"]),
        (
            rigid("k_en = 3", "", ""),
            &["w.toml:3:1: unknown key `k_en` in [axes]; did you mean `\"stiffness.contact_normal\"`?"],
        ),
        (
            rigid("\"operating_point.preload\" = 0.1\npreload = 0.2", "", ""),
            &[
                "w.toml:4:1: axes.preload is the same axis as axes.operating_point.preload; remove one of the two",
                "w.toml:3:1: and here",
            ],
        ),
        (
            rigid("\"pad.mass\" = { from = 0.0, to = 1.0, points = 3, scale = \"log\" }", "", ""),
            &["axes.pad.mass: 0 has no logarithm: both ends of a range with scale = \"log\" must be positive"],
        ),
        (
            rigid("\"pad.mass\" = [0.1, -1.0]", "", ""),
            &["axes.pad.mass: -1 is out of range: it must be greater than 0 and at most 1000 (in kg)"],
        ),
        (
            rigid("\"friction.kinetic_coefficient\" = [0.2, 0.45]\nstatic_friction = [0.4, 0.5]", "", ""),
            &[
                "w.toml:3:34: axes.friction.kinetic_coefficient contradicts the friction law: friction.kinetic_coefficient = 0.45 must be at most friction.static_coefficient = 0.4",
            ],
        ),
        (
            rigid("\"disc.inner_radius\" = [0.06, 0.1]", "", ""),
            &[
                "axes.disc.inner_radius contradicts the model: disc.inner_radius = 0.1 must be at most pad.inner_radius = 0.09",
            ],
        ),
        (
            rigid("\"pad.mass\" = [0.1, 0.2]", "", "").replace("[axes]", "[model.pad]\nmass = 0.3\n[axes]"),
            &["model.pad.mass = 0.3 is given a second time as axes.pad.mass"],
        ),
        (
            rigid(
                "\"pad.mass\" = [0.1, 0.2]",
                "inputs = [\"preload\", \"pad.mass\"]\nrelative_std = { preload = 0.1 }",
                "",
            ),
            &["random.relative_std has no value for pad.mass, which random.inputs lists"],
        ),
        (
            rigid("start.velocity = [0.1, 0.2]", "inputs = [\"start.velocity\"]", ""),
            &[
                "random.std has no value for start.velocity, which random.inputs lists",
                "std = { \"start.velocity\" = 0.05 }",
            ],
        ),
        (
            rigid(
                "",
                "inputs = [\"start.velocity\"]\nrelative_std = { \"start.velocity\" = 0.1 }\nstd = { \"start.velocity\" = 0.1 }",
                "",
            ),
            &["random.relative_std gives 0.1 for start.velocity, which scatters by random.std"],
        ),
        (
            rigid("", "inputs = [\"preload\"]\nrelative_std = 0.1\nstd = { preload = 0.1 }", ""),
            &["random.relative_std = 0.1 is for no input: all scatter by random.std; remove random.relative_std"],
        ),
        (
            rigid("", "inputs = [\"start.tangential\"]\nstd = { \"start.tangential\" = 1e-4 }", ""),
            &[
                "random.inputs lists \"start.tangential\", which has no expected value: give criterion.start = { tangential = ... }, or from_equilibrium = true",
            ],
        ),
        (
            rigid("start.velocity = [0.1, 0.2]", "", "start = \"rest\""),
            &[
                "axes.start.velocity is a number of a start, but criterion.start = \"rest\" has none; remove criterion.start",
            ],
        ),
        (
            rigid("start.velocity = [0.1, 0.2]", "", "start = { velocity = 0.1 }"),
            &["criterion.start.velocity = 0.1 is given a second time as axes.start.velocity"],
        ),
        (
            rigid("start.normal = [0.1, 0.2]", "", ""),
            &["axes.start.normal has no effect with disc = \"rigid\"", "use disc = \"flexible\""],
        ),
        (rigid("", "", "start = { angle = 0.1 }"), &["criterion.start.angle has no effect with disc = \"rigid\""]),
        (
            rigid("start.velocity = [0.1, 1e9]", "", ""),
            &["w.toml:3:18: criterion.start: a start at x = ", "is out of the disc's reach"],
        ),
        (rigid("", "", "start = { tangential = nan }"), &["is out of the disc's reach"]),
        (
            rigid("", "", "start = { tangental = 0.1 }"),
            &["unknown key `tangental` in [criterion.start]; did you mean `tangential`?"],
        ),
        (rigid("", "", "start = \"rets\""), &["criterion.start: unknown value `rets`; did you mean `rest`?"]),
        (
            job("w", "", "", "kind = \"time-domain\"\nstart = { normal = 0.01 }\ndisc_modes = 5", "samples = 1"),
            &["criterion.start: at y = 5e-1 h", "the pad does not touch the disc"],
        ),
        (
            job("w", "start.velocity = [0.1, 0.2]", "", EIGENVALUE, "samples = 1"),
            &["axes.start.velocity: a start belongs to criterion.kind = \"time-domain\""],
        ),
        (
            rigid("start.velocity = [0.1, 0.2]", SCATTER, "").replace("samples = 1", "evaluate = \"boundary\""),
            &[
                "a verdict map holds the verdicts of motions from one start; axes.start.velocity makes another start of each value",
            ],
        ),
        (
            rigid("pad.mass = { from = 0.1, to = 0.2, points = 2000 }", SCATTER, "")
                .replace("samples = 1", "evaluate = \"boundary\""),
            &[
                "each combination of pad.mass and rotating_speed takes a verdict map of its own, and the axes make 2000 of them; the limit is 1000",
            ],
        ),
        (
            rigid(
                "",
                "inputs = [\"start.velocity\"]\nstd = { \"start.velocity\" = 0.1 }\ndistribution = \"lognormal\"",
                "",
            ),
            &[
                "random.std of start.velocity: a ",
                " input that scatters by ",
                "has an expected value above 0, and here it is 0",
            ],
        ),
    ];
    for (text, said) in cases {
        place.write("w.toml", text);
        place.run("check w.toml").refused(65, said);
    }
}

#[test]
fn what_depends_on_all_axes_is_checked_at_their_extremes() {
    let place = Place::new();
    let axes = "\"pad.mass\" = [0.1, 500.0]\n\"damping.tangential\" = { from = 1.0, to = 400.0, points = 3 }";
    place.write("job.toml", &job("job", axes, "", RIGID, "samples = 1"));
    let said = place.run("check --all job.toml").done().stderr;
    assert!(said.contains("axes.pad.mass = 500 kg is not plausible"), "{said}");
    assert!(said.contains("the damping ratio of the tangential motion = ") && said.contains("is below"), "{said}");
    // A heavy pad needs fewer modes than a light one; the job gets as many as the one that needs most.
    let modes = |mass: &str| {
        let axes = format!("pad.mass = {mass}");
        place.write("modes.toml", &job("modes", &axes, "", "kind = \"coupled-eigenvalue\"", "samples = 1"));
        let shown = place.run("check --all modes.toml").done().stdout;
        let line = shown.lines().find(|line| line.starts_with("disc_modes")).unwrap().to_owned();
        line.rsplit(' ').next().unwrap().parse::<u32>().unwrap()
    };
    let single = [modes("0.02"), modes("0.1"), modes("2.0")];
    assert_eq!(modes("[2.0, 0.1, 0.02]"), single[0].max(single[2]), "{single:?}");
}

#[test]
fn many_brakes_take_no_long_preparation() {
    let place = Place::new();
    let axes = "pad.mass = { from = 0.09, to = 0.11, points = 100_000 }";
    for criterion in ["kind = \"coupled-eigenvalue\"", RIGID, EIGENVALUE] {
        place.write("job.toml", &job("job", axes, SCATTER, criterion, "samples = 1000"));
        let shown = place.run_unless_it_hangs("check job.toml").done().stdout;
        assert!(shown.contains("# 100,000 cells: 100000 pad.mass x 1 rotating speed x"), "{shown}");
    }
}

#[test]
fn maps_and_integrals_serve_axes_of_the_brake() {
    let place = Place::new();
    let axes = "\"stiffness.contact_normal\" = [3.5e7, 3.8e7]\n\"friction.kinetic_coefficient\" = [0.2, 0.25]\nstatic_friction = [0.36, 0.4]\npreload = 0.1";
    let exact = submitted(
        &place,
        "exact",
        &job("exact", axes, SCATTER, EIGENVALUE, "method = \"exact\"").replace("common_random_numbers = true\n", ""),
    );
    let sampled = submitted(&place, "sampled", &job("sampled", axes, SCATTER, EIGENVALUE, "samples = 20000"));
    let mapped = submitted(
        &place,
        "mapped",
        &job("mapped", axes, SCATTER, RIGID, "samples = 20000\nevaluate = \"boundary\"\naudit = 50"),
    );
    let each = submitted(&place, "each", &job("each", axes, SCATTER, RIGID, "samples = 20000"));
    let probabilities = |table: &Table| table.column("p_unstable").to_vec();
    for ((exact, sampled), (mapped, each)) in probabilities(&exact)
        .iter()
        .zip(probabilities(&sampled))
        .zip(probabilities(&mapped).iter().zip(probabilities(&each)))
    {
        assert!((exact - sampled).abs() < 5.0 * (0.25f64 / 20000.0).sqrt(), "{exact} {sampled}");
        assert_eq!(*mapped, each, "the map gives what simulation gives");
    }
    assert_eq!(mapped.column("n_audit_differed").iter().sum::<f64>(), 0.0);
}

#[test]
fn a_random_knock_has_the_probability_of_the_knocks_that_it_draws() {
    let place = Place::new();
    let start = "start = { velocity = 2.0 }";
    let criterion = format!("{RIGID}\n{start}");
    // Velocities uniform from 2 - sqrt(3) std to 2 + sqrt(3) std.
    let random =
        "inputs = [\"start.velocity\"]\nstd = { \"start.velocity\" = 1.1547005383792515 }\ndistribution = \"uniform\"";
    let drawn =
        submitted(&place, "drawn", &job("drawn", "rotating_speed = 25.0", random, &criterion, "samples = 4000"));
    let axes = "rotating_speed = 25.0\nstart.velocity = { from = 0.0, to = 4.0, points = 401 }";
    let scanned = submitted(&place, "scanned", &job("scanned", axes, "", RIGID, "samples = 1"));
    let share = scanned.column("n_unstable").iter().sum::<f64>() / 401.0;
    assert!(share > 0.1 && share < 0.9, "{share}");
    let p = drawn.column("p_unstable")[0];
    assert!((p - share).abs() < 5.0 * (0.25f64 / 4000.0).sqrt() + 1.0 / 400.0, "{p} {share}");
    assert_eq!(
        (drawn.column("start.velocity")[0], unit(&place, "drawn", "std_start.velocity")),
        (2.0, "m/s".to_owned())
    );
    // The first unstable knock is where the smallest one is, by single motions.
    let first = scanned.column("n_unstable").iter().position(|&count| count == 1.0).unwrap();
    for (velocity, verdict) in [(first - 1, "stable"), (first, "unstable")] {
        let velocity = scanned.column("start.velocity")[velocity];
        let words = format!(
            "trajectory --disc rigid --set operating_point.rotating_speed=25 --start velocity={velocity} --json"
        );
        let shown = place.run(&words).done().stdout;
        assert!(shown.contains(&format!("\"verdict\": \"{verdict}\"")), "{velocity}: {shown}");
    }
    // A sample replayed starts where it was drawn.
    let shown = place.run("replay drawn --cell 0 --sample 3 --json").done().stdout;
    let value = |key: &str| {
        let line = shown.lines().find(|line| line.contains(&format!("\"{key}\":"))).unwrap();
        line.split(": ").nth(1).unwrap().trim_end_matches(',').trim_matches('"').to_owned()
    };
    let verdict = value("verdict");
    assert_eq!(value("verdict_in_run"), verdict);
    let velocity = value("start.velocity");
    let words =
        format!("trajectory --disc rigid --set operating_point.rotating_speed=25 --start velocity={velocity} --json");
    assert!(place.run(&words).done().stdout.contains(&format!("\"verdict\": \"{verdict}\"")));
}

#[test]
fn starts_on_a_flexible_disc_may_vary_in_all_four_numbers() {
    let place = Place::new();
    let axes = "rotating_speed = 25.0\nstart.velocity = [0.0, 3.0]\nstart.angle = [0.0, 0.01]";
    let random = "inputs = [\"preload\", \"start.normal\"]\nrelative_std = 0.05\nstd = { \"start.normal\" = 1e-5 }";
    let criterion =
        "kind = \"time-domain\"\ndisc_modes = 5\nhorizon = 1000\nstart = { tangential = 0.0, from_equilibrium = true }";
    let table = submitted(&place, "run", &job("run", axes, random, criterion, "samples = 6"));
    let p = table.column("p_unstable");
    assert!(p[0] == 0.0 && p[1] == 0.0 && p[2] > 0.0 && p[3] > 0.0, "{p:?}");
    assert!(["n_undecided", "n_failed"].iter().all(|name| table.column(name).iter().all(|&count| count == 0.0)));
    assert_eq!(unit(&place, "run", "start.angle"), "rad");
}

#[test]
fn runs_with_further_axes_are_the_same_on_any_threads_and_shards() {
    let place = Place::new();
    let axes = "rotating_speed = 22.0\nstart.velocity = { from = 0.0, to = 3.0, points = 7 }\npad.mass = [0.1, 0.11]";
    let random =
        "inputs = [\"preload\", \"start.tangential\"]\nrelative_std = 0.1\nstd = { \"start.tangential\" = 1e-5 }";
    let criterion = format!("{RIGID}\nstart = {{ from_equilibrium = true }}");
    place.write("job.toml", &job("job", axes, random, &criterion, "samples = 300"));
    place.run("submit job.toml --out one --threads 1").done();
    place.run("submit job.toml --out two --threads 2").done();
    for shard in 1..=3 {
        place.run(&format!("submit job.toml --out parts --shard {shard}/3")).done();
    }
    place.run("merge parts").done();
    assert!(place.surface("one") == place.surface("two") && place.surface("one") == place.surface("parts"));
}

#[test]
fn cells_are_compared_by_all_axes() {
    let place = Place::new();
    let axes = |masses: &str| format!("rotating_speed = 15.0\npad.mass = {masses}\nstart.velocity = [0.0, 1.0]");
    for (name, masses) in [("first", "[0.1, 0.12, 0.14]"), ("second", "[0.12, 0.1]")] {
        submitted(&place, name, &job(name, &axes(masses), SCATTER, RIGID, "samples = 100"));
    }
    let done = place.run("compare first second --out differences.parquet").done();
    assert!(done.stderr.contains("4 cells are in both runs; left out are 2 of 6 in first and 0 of 4 in second"));
    assert!(done.stdout.contains("mean difference   +0.00000"), "{}", done.stdout);
    let table = Table::read(&place.path("differences.parquet"));
    assert_eq!(table.column("pad.mass"), [0.1, 0.1, 0.12, 0.12]);
    assert_eq!(table.column("cell_second"), [2.0, 3.0, 0.0, 1.0]);
    // A value of the model is that of an axis in another run.
    let text = job("third", "rotating_speed = 15.0\nstart.velocity = [0.0, 1.0]", SCATTER, RIGID, "samples = 100")
        .replace("[axes]", "[model.pad]\nmass = 0.12\n[axes]");
    submitted(&place, "third", &text);
    let done = place.run("compare first third").done();
    assert!(done.stderr.contains("2 cells are in both runs"), "{}", done.stderr);
}

#[test]
fn pictures_follow_the_longest_axes_and_fit_a_terminal() {
    let place = Place::new();
    let plane = "rotating_speed = 22.0\npreload = [0.1, 0.12]\nstart.tangential = { from = -6e-4, to = 1e-3, points = 9 }\nstart.velocity = { from = -3.0, to = 4.0, points = 5 }";
    place.write("plane.toml", &job("plane", plane, "", RIGID, "samples = 1"));
    let shown = place.run("submit plane.toml").done().stdout;
    assert!(shown.contains("at 22 rad/s, preload = 0.1; relative std: none"), "{shown}");
    assert!(shown.contains(" start.velocity, m/s\n") && shown.contains("start.tangential, m\n"), "{shown}");
    assert_eq!(shown.matches("Probability of instability").count(), 2);
    let curve = "rotating_speed = { from = 10.0, to = 30.0, points = 41 }\n\"stiffness.contact_normal\" = [3.8e7, 4e7]";
    place.write(
        "curve.toml",
        &job("curve", "rotating_speed = { from = 10.0, to = 20.0, points = 41 }", SCATTER, EIGENVALUE, "samples = 500"),
    );
    let line = place.run("submit curve.toml").done().stdout;
    let is_braille = |c: char| ('\u{2801}'..='\u{28ff}').contains(&c);
    assert!(line.contains(is_braille) && line.contains("Rotating speed, rad/s"), "{line}");
    assert!(line.contains("shaded: 95 % interval"), "{line}");
    assert!(!line.contains('█'));
    place.write("area.toml", &job("area", curve, SCATTER, EIGENVALUE, "samples = 500"));
    let area = place.run("submit area.toml").done().stdout;
    let names = "1 stiffness.contact_normal 3.8e7 N/m   2 stiffness.contact_normal 4e7 N/m";
    assert!(area.contains(names), "{area}");
    assert!(!format!("{shown}{line}{area}").contains('\u{1b}'), "colours are for terminals");
    for line in [&shown, &line, &area].into_iter().flat_map(|text| text.lines()) {
        assert!(line.starts_with("runs/") || line.starts_with('/') || line.chars().count() <= 80, "{line}");
    }
    assert!(fs::exists(place.path("runs/area/surface.parquet")).unwrap());
}

#[test]
fn the_pad_slides_at_its_effective_radius() {
    let place = Place::new();
    // The brake of the guide. The critical friction coefficient by hand, from the damping that friction has to overcome:
    // (f_s - f_c) exp(-V / v_s) N k_t2 / (k_t1 v_s) = c_x, with V = r_e Omega and N = h Delta k_en k_y / (k_en + k_y).
    let random = "inputs = [\"static_friction\"]\nrelative_std = 0.2";
    let exact = |name: &str, axes: &str| {
        let axes = format!("{axes}\npreload = 0.026\nstatic_friction = 0.39");
        let text = job(name, &axes, random, EIGENVALUE, "method = \"exact\"");
        submitted(&place, name, &text.replace("common_random_numbers = true\n", ""))
    };
    let radii = [0.100, 0.114, 0.135];
    let given = exact("radii", "rotating_speed = 12.0\n\"pad.effective_radius\" = [0.100, 0.114, 0.135]");
    let speeds = radii.map(|radius| 12.0 * radius / 0.135);
    let at_the_edge = exact("edge", &format!("rotating_speed = {speeds:?}"));
    let force = 0.020 * 0.026 * 3.816e7 * 3.249e7 / (3.816e7 + 3.249e7);
    for (i, radius) in radii.into_iter().enumerate() {
        let critical = 0.25 + 369.0 * 0.72 * libm::exp(radius * 12.0 / 0.72) / force;
        let expected = 0.5 * libm::erfc((critical - 0.39) / (0.2 * 0.39) / std::f64::consts::SQRT_2);
        for surface in [&given, &at_the_edge] {
            assert!((surface.column("p_unstable")[i] / expected - 1.0).abs() < 1e-11, "{radius}");
        }
    }
    assert!((given.column("p_unstable")[1] - 0.2417).abs() < 5e-5);
}

#[test]
fn without_an_effective_radius_the_pad_slides_at_the_edge_of_the_disc_wherever_that_is() {
    let place = Place::new();
    let edges = "rotating_speed = 12.0\npreload = 0.05\n\"disc.outer_radius\" = [0.12, 0.15]";
    for (name, criterion) in [("eigenvalue", EIGENVALUE), ("rigid", RIGID)] {
        let counts = |of: &str, axes: &str, model: &str| {
            let text = job(of, axes, SCATTER, criterion, "samples = 500").replace("[axes]", &format!("{model}[axes]"));
            submitted(&place, &format!("{name}-{of}"), &text).column("n_unstable").to_vec()
        };
        let followed = counts("followed", edges, "");
        let given = [0.12, 0.15].map(|edge| {
            let model = format!("[model]\ndisc.outer_radius = 0.16\npad.effective_radius = {edge}\n");
            counts(&format!("given-{edge}"), "rotating_speed = 12.0\npreload = 0.05", &model)[0]
        });
        assert_eq!(followed, given, "{name}");
        assert!(followed[0] != followed[1], "{name}: {followed:?}");
    }
}

#[test]
fn a_radius_that_scatters_does_what_a_speed_that_scatters_does() {
    let place = Place::new();
    let axes = "rotating_speed = 12.0\npreload = 0.035";
    for (name, criterion, samples) in [
        ("eigenvalue", EIGENVALUE, 4000),
        ("coupled", "kind = \"coupled-eigenvalue\"\ndisc_modes = 5", 400),
        ("rigid", RIGID, 400),
    ] {
        let shares = ["pad.effective_radius", "rotating_speed"].map(|input| {
            let random = format!("inputs = [\"{input}\"]\nrelative_std = 0.03");
            let text = job(name, axes, &random, criterion, &format!("samples = {samples}"))
                .replace("[axes]", "[model.pad]\neffective_radius = 0.114\n[axes]");
            let surface = submitted(&place, &format!("{name}-{input}"), &text);
            assert_eq!(surface.column("n_failed"), [0.0], "{name} {input}");
            (surface.column("p_low")[0], surface.column("p_high")[0])
        });
        let [(low, high), (other_low, other_high)] = shares;
        assert!(low < other_high && other_low < high && low > 0.0 && high < 1.0, "{name}: {shares:?}");
    }
    // A radius beyond the patch is no brake.
    let random = "inputs = [\"pad.effective_radius\"]\nrelative_std = 0.2";
    let text = job("wide", axes, random, EIGENVALUE, "samples = 2000")
        .replace("[axes]", "[model.pad]\neffective_radius = 0.114\n[axes]");
    let failed = submitted(&place, "wide", &text).column("n_failed")[0] / 2000.0;
    // Phi((0.090 - 0.114) / 0.0228) + 1 - Phi((0.135 - 0.114) / 0.0228)
    let expected = 0.5 * (libm::erfc(0.024 / 0.0228 / 2f64.sqrt()) + libm::erfc(0.021 / 0.0228 / 2f64.sqrt()));
    assert!((failed - expected).abs() < 0.04, "{failed} {expected}");
}

#[test]
fn radii_that_contradict_each_other_are_refused_with_both() {
    let place = Place::new();
    let check = |model: &str, axes: &str, texts: &[&str]| {
        place
            .write("job.toml", &job("job", axes, SCATTER, EIGENVALUE, "").replace("[axes]", &format!("{model}[axes]")));
        place.run("check job.toml").refused(65, texts);
    };
    let given = |radius: f64| format!("[model.pad]\neffective_radius = {radius}\n");
    check(&given(0.14), "", &["pad.effective_radius = 0.14 must be at most disc.outer_radius = 0.135"]);
    check(&given(0.08), "", &["pad.inner_radius = 0.09 must be at most pad.effective_radius = 0.08"]);
    check(&given(115.0), "", &["did you mean 0.115 (115 mm)?"]);
    let axes = "\"pad.inner_radius\" = [0.08, 0.11]\n\"pad.effective_radius\" = [0.1, 0.12]";
    check("", axes, &["pad.inner_radius = 0.11 must be at most pad.effective_radius = 0.1"]);
    let axes = "\"disc.outer_radius\" = [0.11, 0.13]\n\"pad.effective_radius\" = [0.1, 0.12]";
    check("", axes, &["pad.effective_radius = 0.12 must be at most disc.outer_radius = 0.11"]);
    let random = "inputs = [\"pad.effective_radius\"]\nrelative_std = 0.02";
    place.write("job.toml", &job("job", "", random, EIGENVALUE, ""));
    place.run("check job.toml").refused(
        65,
        &["random.inputs lists \"pad.effective_radius\", which has no expected value: give model.pad.effective_radius, between pad.inner_radius = 0.09 and disc.outer_radius = 0.135"],
    );
    // Not given, it follows the edge of the disc.
    place.write("job.toml", &job("job", "\"disc.outer_radius\" = [0.11, 0.15]", SCATTER, EIGENVALUE, ""));
    place.run("check --all job.toml").done();
}
