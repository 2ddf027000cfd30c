//! Measured curves that are drawn so low that friction vanishes at some sliding speed: what meets such a speed is outside
//! the model.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so and stop")]

use crate::common::{Place, Table, repository, submitted, texts};

/// The curve of the case `negative-friction`. Drawn 3.5 standard deviations down it vanishes at 5 m/s; drawn 3.6 down, at
/// 3.1215 m/s.
const TABLE: &str = "law = \"table\"\ntable = { speed = [0.0, 0.5, 2.0, 5.0], coefficient = [0.45, 0.38, 0.3, 0.28], \
    std = [0.02, 0.05, 0.08, 0.08] }";

/// The case with something replaced.
fn case(changes: &[(&str, &str)]) -> String {
    let text = std::fs::read_to_string(repository().join("tests/data/cases/negative-friction.toml")).unwrap();
    changes.iter().fold(text, |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replace(from, to)
    })
}

/// Every motion of the case sticks and slips, and slides at 7.9 m/s and more (found outside the program by a classical
/// Runge-Kutta method). So it is outside the model where the curve is drawn more than 0.28 / 0.08 = 3.5 standard
/// deviations down, which is 12.2 % of a normal distribution with a standard deviation of 3. 43 of these 400 samples were
/// counted unstable once.
#[test]
fn samples_that_slide_without_friction_are_outside_the_model() {
    let place = Place::new();
    let surface = submitted(&place, "stable", &case(&[]));
    let numbers =
        |table: &Table| ["n_outside_physics", "n_stable", "n_unstable", "n_failed"].map(|n| table.column(n)[0]);
    let [outside, stable, unstable, failed] = numbers(&surface);
    place.run("samples stable --cell 0 --out samples.parquet").done();
    let samples = Table::read(&place.path("samples.parquet"));
    let verdicts = texts(&place.path("samples.parquet"), "verdict");
    let (bands, are_outside) = (samples.column("friction.band"), samples.column("outside_physics"));
    for ((&band, &is_outside), verdict) in bands.iter().zip(are_outside).zip(&verdicts) {
        assert_eq!(is_outside == 1.0, band < -3.5, "{band}");
        // A band beyond 10 is not admissible.
        let expected = if band < -10.0 { "failed" } else { "stable" };
        assert!(band >= -3.5 || verdict.as_deref() == Some(expected), "{band} {verdict:?}");
        assert!(!(-3.5..-1.0).contains(&band) || verdict.as_deref() == Some("unstable"), "{band} {verdict:?}");
    }
    assert_eq!(outside, are_outside.iter().sum::<f64>());
    assert!((outside / 400.0 - 0.122).abs() < 0.065, "{outside}");
    let inadmissible = bands.iter().map(|band| f64::from(u8::from(*band < -10.0))).sum::<f64>();

    let policy = |name: &str| {
        let changes = format!("kind = \"time-domain\"\noutside_physics = \"{name}\"");
        numbers(&submitted(&place, name, &case(&[("kind = \"time-domain\"", &changes)])))
    };
    let moved = outside - inadmissible;
    assert_eq!(policy("failed"), [outside, stable - moved, unstable, failed + moved]);
    assert_eq!(policy("clamp")[0], outside);
    // On a flexible disc, by the coupled eigenvalues too, they are not decided by equations that hold for no brake.
    let coupled = "kind = \"coupled-eigenvalue\"\nrecord = [\"growth_rate\"]";
    let text = case(&[
        ("kind = \"time-domain\"\ndisc = \"rigid\"\nstart = \"rest\"", coupled),
        ("samples = 400", "samples = 100"),
    ]);
    submitted(&place, "coupled", &text);
    place.run("samples coupled --cell 0 --out coupled.parquet").done();
    let samples = Table::read(&place.path("coupled.parquet"));
    let verdicts = texts(&place.path("coupled.parquet"), "verdict");
    let columns = ["friction.band", "outside_physics", "growth_rate"].map(|name| samples.column(name));
    for (sample, verdict) in verdicts.iter().enumerate() {
        let [band, is_outside, rate] = [0, 1, 2].map(|column| columns[column][sample]);
        // At the 2.16 m/s of steady sliding, in Python on PCHIP, friction vanishes between 3.70 and 3.75.
        assert!(is_outside == f64::from(u8::from(band < -3.725)) || (-3.75..-3.7).contains(&band), "{band}");
        if is_outside == 1.0 && band > -10.0 {
            assert!(verdict.as_deref() == Some("stable") && rate.is_nan(), "{band} {verdict:?} {rate}");
        }
    }
}

/// At 12 rad/s every sample with friction is unstable, as friction falls by 0.085 s/m and more there and 0.011 s/m are enough.
/// The static friction below which there is none at 1.62 m/s is 0.112738 for each standard deviation, as Python finds on
/// PCHIP: the probabilities follow from the normal distribution.
#[test]
fn every_method_takes_what_slides_steadily_without_friction_for_stable() {
    let place = Place::new();
    let text = |band: &str, inputs: &str, criterion: &str, sampling: &str| {
        format!(
            "name = \"job\"\n[model.friction]\n{TABLE}\nband = {band}\n[axes]\nrotating_speed = 12.0\npreload = 0.1\n\
             static_friction = 0.45\n[random]\n{inputs}\n[criterion]\nkind = \"eigenvalue\"\n{criterion}\n\
             [sampling]\n{sampling}\n"
        )
    };
    let one = "inputs = [\"static_friction\"]\nrelative_std = 0.1";
    let both = "inputs = [\"static_friction\", \"friction.band\"]\nrelative_std = { static_friction = 0.1 }\n\
        std = { \"friction.band\" = 0.3 }";
    let p = |table: &Table| table.column("p_unstable")[0];
    let exact = p(&submitted(&place, "exact", &text("-3.9", one, "", "method = \"exact\"")));
    assert!((exact - 0.590_668_93).abs() < 1e-7, "{exact}");
    let conditional = text("-3.9", both, "", "method = \"conditional\"\nsamples = 100_000");
    let conditional = p(&submitted(&place, "conditional", &conditional));
    assert!((conditional - 0.572_708).abs() < 0.005, "{conditional}");
    for (name, inputs, expected) in [("one", one, 0.590_669), ("both", both, 0.572_708)] {
        // The edge to which samples are moved is outside the model too: friction is 0 there.
        for policy in ["stable", "failed", "clamp"] {
            let criterion = format!("outside_physics = \"{policy}\"");
            let name = format!("{name}-{policy}");
            let table = submitted(&place, &name, &text("-3.9", inputs, &criterion, "samples = 100_000"));
            let numbers = ["n_outside_physics", "n_stable", "n_unstable", "n_failed"].map(|name| table.column(name)[0]);
            let [outside, stable, unstable, failed] = numbers;
            assert!((unstable / 1e5 - expected).abs() < 0.007, "{name}: {numbers:?}");
            assert_eq!((stable + failed, outside + unstable), (outside, 1e5), "{name}: {numbers:?}");
            assert_eq!(failed > 0.0, policy == "failed", "{name}");
        }
    }
}

/// 3.75 standard deviations down the curve is 0.3 - 3.75 * 0.08 = 0 at 2 m/s, where it still falls.
#[test]
fn what_slides_steadily_with_a_coefficient_of_0_is_outside_the_model_for_all_commands() {
    let place = Place::new();
    let rotating_speed = 2.0 / 0.135;
    for (band, is_outside) in [("-3.75", true), ("-3.7499", false)] {
        for (kind, further) in [("eigenvalue", ""), ("coupled-eigenvalue", ""), ("time-domain", "disc = \"rigid\"")] {
            let text = format!(
                "name = \"zero\"\n[model.friction]\n{TABLE}\nband = {band}\n[axes]\nrotating_speed = {rotating_speed}\n\
                 preload = 0.1\nstatic_friction = 0.45\n[random]\ninputs = []\n[criterion]\nkind = \"{kind}\"\n{further}\n\
                 [sampling]\nsamples = 1\n"
            );
            // What slides with friction only just loses it as it moves.
            let counted = is_outside || kind == "time-domain";
            let table = submitted(&place, &format!("{kind}{band}"), &text);
            let numbers = ["n_outside_physics", "n_stable"].map(|name| table.column(name)[0]);
            assert_eq!(numbers[0] == 1.0, counted, "{kind} {band}: {numbers:?}");
            assert_eq!(numbers[1] == 1.0, counted, "{kind} {band}: {numbers:?}");
            place.write("job.toml", &text);
            let checked = place.run("check job.toml").done().stderr;
            assert!(checked.contains("the friction coefficient is at or below 0 at"), "{checked}");
            let said = place.run("analyse job.toml --json").done().stdout;
            let analysis: serde_json::Value = serde_json::from_str(&said).unwrap();
            assert_eq!(analysis["without_friction"]["steady_sliding"], is_outside, "{kind} {band}: {said}");
        }
    }
}

/// From rest stick-slip of this oscillator slides at 3.1215 m/s at the most where the belt has 1.33483 m/s: found outside the
/// program, as above.
#[test]
fn an_oscillator_on_a_belt_is_outside_the_model_from_the_speed_at_which_it_meets_no_friction() {
    let place = Place::new();
    let text = format!(
        "name = \"belt\"\n[model]\nkind = \"belt-oscillator\"\nmass = 1.0\nstiffness = 1.0\ndamping = 0.05\n\
         normal_force = 2.0\n[model.friction]\n{TABLE}\nband = -3.6\n[axes]\nbelt_speed = [0.7, 1.333, 1.337, 1.5]\n\
         [random]\ninputs = []\n[criterion]\nkind = \"time-domain\"\nstart = \"rest\"\n[sampling]\nsamples = 1\n"
    );
    let table = submitted(&place, "belt", &text);
    assert_eq!(table.column("n_outside_physics"), [0.0, 0.0, 1.0, 1.0]);
    assert_eq!(table.column("n_unstable"), [1.0, 1.0, 0.0, 0.0]);
}

#[test]
fn check_analyse_and_trajectory_say_where_there_is_no_friction() {
    let place = Place::new();
    place.write("scatter.toml", &case(&[]));
    let said = place.run("check scatter.toml").done().stderr;
    for text in
        ["warning: 12.2 % of the curves that friction.band draws with std = 3", "-3.500 or less", "at 5.000 m/s"]
    {
        assert!(said.contains(text), "{text:?} is not in: {said}");
    }
    place.write("little.toml", &case(&[("= 3 }", "= 1 }")]));
    assert!(!place.run("check little.toml").done().stderr.contains("of the curves"));

    let fixed = |band: &str| {
        let random = "[random]\ninputs = [\"friction.band\"]\nstd = { \"friction.band\" = 3 }";
        case(&[("band = 0.0", &format!("band = {band}")), (random, "[random]\ninputs = []")])
    };
    let json = |words: &str| -> serde_json::Value {
        serde_json::from_str(&place.run(&format!("{words} --json")).done().stdout).unwrap()
    };
    for (name, band, said_of_friction, steady) in [
        ("cycle", "-3.6", "at or below 0 from 3.122 m/s on: the limit cycle meets such a speed", false),
        ("steady", "-4.0", "m/s on: steady sliding or rest meets such a speed", true),
    ] {
        place.write(&format!("{name}.toml"), &fixed(band));
        let said = place.run(&format!("analyse {name}.toml")).done().stdout;
        let first = said.lines().next().unwrap_or_default();
        assert_eq!(first.contains(": outside the model, without friction"), steady, "{first}");
        assert!(said.contains("\nfriction           at or below 0 from"), "{said}");
        assert!(said.contains(said_of_friction), "{said}");
        let analysis = json(&format!("analyse {name}.toml"));
        assert_eq!(analysis["without_friction"]["steady_sliding"], steady, "{analysis}");
        assert!(analysis["without_friction"]["speeds_m_s"][0][1].is_null());
        let motion = place.run(&format!("trajectory --job {name}.toml --horizon 50")).done().stdout;
        assert!(motion.contains("verdict            stable\noutside the model  it meets a sliding speed"), "{motion}");
        assert_eq!(json(&format!("trajectory --job {name}.toml --horizon 50"))["lacks_friction"], true);
    }
    assert_eq!(json("analyse")["without_friction"]["speeds_m_s"], serde_json::json!([]));
    assert_eq!(json("trajectory --disc rigid --horizon 20")["lacks_friction"], false);

    let belt = format!(
        "name = \"belt\"\n[model]\nkind = \"belt-oscillator\"\nmass = 1.0\nstiffness = 1.0\ndamping = 0.05\n\
         normal_force = 2.0\nbelt_speed = 1.5\n[model.friction]\n{TABLE}\nband = -3.6\n[random]\ninputs = []\n\
         [criterion]\nkind = \"eigenvalue\"\n"
    );
    place.write("belt.toml", &belt);
    assert!(
        place.run("check belt.toml").done().stderr.contains("the curve with friction.band = -3.600 is not plausible")
    );
    let said = place.run("analyse belt.toml").done().stdout;
    assert!(said.contains("\nfriction           at or below 0 from 3.122 m/s on: the limit cycle meets"), "{said}");
}
