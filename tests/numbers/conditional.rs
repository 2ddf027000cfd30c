//! Probabilities integrated over preload and static friction with any distribution and correlation, and given other
//! inputs.

#![allow(clippy::disallowed_methods, reason = "expected values are computed as a textbook writes them")]
#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so and stop")]

use crate::common::ten_inputs::{boundary, expected_of_ten, job_of_ten, logarithm};
use crate::common::{BOTH, EIGENVALUE, Place, job, submitted};
use stickslip_sampler::special_functions::normal;

#[test]
fn integrals_over_correlated_lognormal_inputs_are_those_of_a_normal_sum() {
    // Without kinetic friction a sample is unstable by the product of its inputs.
    let place = Place::new();
    let critical = boundary(0.0).critical_product;
    for coefficient in [-0.7, 0.4] {
        let random = format!(
            "inputs = [\"preload\", \"static_friction\"]\nrelative_std = {{ preload = 0.2, static_friction = 0.1 }}\n\
             distribution = \"lognormal\"\ncorrelation = [[\"static_friction\", \"preload\", {coefficient}]]"
        );
        let text = job("product", EIGENVALUE, &random, "method = \"exact\"")
            .replace("[random]", "[model.friction]\nkinetic_coefficient = 0.0\n\n[random]")
            .replace("from = 0.05, to = 0.30", "from = 0.01, to = 0.03");
        let table = submitted(&place, &format!("product{coefficient}"), &text);
        let mut rare = 0;
        for row in 0..30 {
            let [preload, friction] = ["preload", "static_friction"].map(|name| table.column(name)[row]);
            let ((a, first), (b, second)) = (logarithm(preload, 0.2), logarithm(friction, 0.1));
            let std = (first * first + second * second + 2.0 * coefficient * first * second).sqrt();
            let expected = normal::upper_tail((critical.ln() - a - b) / std);
            let [p, low, high] = ["p_unstable", "p_low", "p_high"].map(|name| table.column(name)[row]);
            assert!((p / expected - 1.0).abs() < 1e-11, "{coefficient} {row}: {p} {expected}");
            assert!(low <= expected && expected <= high && high - low < 1e-11, "{low} {expected} {high}");
            assert_eq!(table.column("n_samples")[row], 0.0);
            rare += u32::from(expected < 1e-6 && expected > 1e-30);
        }
        assert!(rare > 1, "{rare} rare events");
    }
}

#[test]
fn integrals_over_any_distributions_agree_with_samples() {
    let place = Place::new();
    place.write("measured.csv", "friction\n0.33\n0.36\n0.41\n0.41\n0.39\n0.45\n");
    for (name, distribution) in [
        ("weibull", "{ preload = \"weibull\", static_friction = \"gumbel\" }"),
        ("uniform", "{ preload = \"uniform\", static_friction = { triangular = 0.2 } }"),
        ("cut", "{ preload = { beta = [0.2, 3.0] }, static_friction = { truncated-normal = [-1.0, 2.0] } }"),
        ("measured", "{ static_friction = { csv = \"measured.csv\", column = \"friction\" } }"),
    ] {
        let std = if name == "measured" { "{ preload = 0.2 }" } else { "0.2" };
        let random = format!(
            "inputs = [\"preload\", \"static_friction\"]\nrelative_std = {std}\ndistribution = {distribution}\n\
             correlation = [[\"preload\", \"static_friction\", -0.6]]"
        );
        let exact = submitted(&place, name, &job(name, EIGENVALUE, &random, "method = \"exact\""));
        let sampling = "method = \"sobol\"\nsamples = 16_384\nseed = 3";
        let sampled = submitted(&place, &format!("{name}-sobol"), &job(name, EIGENVALUE, &random, sampling));
        for row in 0..30 {
            let p = exact.column("p_unstable")[row];
            let other = sampled.column("p_unstable")[row];
            assert!((p - other).abs() < 4e-3, "{name} {row}: {p} {other}");
            assert!(exact.column("p_high")[row] - exact.column("p_low")[row] < 1e-10, "{name} {row}");
        }
    }
}

#[test]
fn conditional_probabilities_of_ten_inputs_have_a_mean_in_closed_form() {
    let place = Place::new();
    let table = submitted(&place, "ten", &job_of_ten("ten", "method = \"conditional\"\nsamples = 16_384\nseed = 4"));
    let expected = expected_of_ten(&table);
    assert!(expected.iter().any(|p| *p < 1e-6) && expected.iter().any(|p| *p > 1e-3), "{expected:?}");
    let mut narrow = 0;
    for (row, expected) in expected.into_iter().enumerate() {
        let [p, low, high] = ["p_unstable", "p_low", "p_high"].map(|name| table.column(name)[row]);
        assert!(low <= expected && expected <= high, "{row}: {low} {expected} {high}");
        narrow += u32::from(high - low < 0.5 * expected);
        // Where few samples matter, the interval says so.
        assert!(high - low < 3.0 * expected || high < 4.0 / 16_384.0, "{row}: {low} {expected} {high}");
        assert!((p / expected - 1.0).abs() < 0.8, "{row}: {p} {expected}");
        assert_eq!(table.column("n_samples")[row], 16_384.0);
        assert_eq!(table.column("n_stable")[row] + table.column("n_unstable")[row], 16_384.0);
    }
    assert!(narrow > 1, "{narrow}");
    assert!(!table.names().iter().any(|name| name == "n_outside_physics"));
    for words in ["replay ten --cell 0 --sample 0", "samples ten --cell 0"] {
        place.run(words).refused(64, &["method = \"conditional\"", "method = \"sobol\""]);
    }
    let check = place.run("check --all ten.toml").done().stdout;
    assert!(check.contains("method = \"conditional\"") && check.contains("65,536 samples"), "{check}");
    // With all defaults filled in, it is the same job.
    place.write("full.toml", &check);
    let again = place.run("submit full.toml --out ten").done();
    assert!(again.stderr.contains("finished already"), "{}", again.stderr);
}

#[test]
fn conditional_probabilities_agree_with_samples_of_all_inputs() {
    let place = Place::new();
    let random = "inputs = [\"preload\", \"static_friction\", \"friction.kinetic_coefficient\", \"friction.stribeck_velocity\"]\n\
                  relative_std = { preload = 0.2, static_friction = 0.1, \"friction.kinetic_coefficient\" = 0.05, \"friction.stribeck_velocity\" = 0.2 }\n\
                  distribution = { preload = \"weibull\", \"friction.stribeck_velocity\" = \"uniform\" }\n\
                  correlation = [[\"static_friction\", \"friction.kinetic_coefficient\", 0.8], [\"preload\", \"friction.stribeck_velocity\", -0.4]]";
    // Only one of the two may be random.
    let friction_alone = "inputs = [\"static_friction\", \"damping.tangential\"]\nrelative_std = 0.15\n\
                          correlation = [[\"static_friction\", \"damping.tangential\", 0.6]]";
    let preload_alone = "inputs = [\"preload\", \"rotating_speed\"]\nrelative_std = 0.15";
    for (name, random) in [("four", random), ("friction", friction_alone), ("preload", preload_alone)] {
        let conditional = submitted(
            &place,
            name,
            &job(name, EIGENVALUE, random, "method = \"conditional\"\nsamples = 256\nconfidence = 0.999"),
        );
        let sampled = submitted(
            &place,
            &format!("{name}-sobol"),
            &job(name, EIGENVALUE, random, "method = \"sobol\"\nsamples = 65_536"),
        );
        for row in 0..30 {
            let [p, low, high] = ["p_unstable", "p_low", "p_high"].map(|column| conditional.column(column)[row]);
            let other = sampled.column("p_unstable")[row];
            assert!((p - other).abs() < 0.01, "{name} {row}: {p} {other}");
            assert!(low - 2e-3 <= other && other <= high + 2e-3, "{name} {row}: {low} {other} {high}");
        }
    }
    let compared = place.run("compare four four-sobol --pointwise").done();
    assert!(compared.stdout.contains("significant       0 of 30 cells"), "{}", compared.stdout);
    let itself = place.run("compare four four --pointwise").done();
    assert!(itself.stderr.contains("they integrate over preload and static friction"), "{}", itself.stderr);
    assert!(itself.stdout.contains("significant       0 of 30 cells"), "{}", itself.stdout);
}

#[test]
fn brakes_that_cannot_be_made_fail() {
    let place = Place::new();
    let random = "inputs = [\"preload\", \"damping.tangential\"]\nrelative_std = { preload = 0.1, \"damping.tangential\" = 1.0 }";
    let table =
        submitted(&place, "negative", &job("negative", EIGENVALUE, random, "method = \"conditional\"\nsamples = 1024"));
    let expected = normal::upper_tail(1.0);
    for row in 0..30 {
        let share = table.column("n_failed")[row] / 1024.0;
        assert!((share - expected).abs() < 0.01, "{share}");
        let [p, low, high] = ["p_unstable", "p_low", "p_high"].map(|name| table.column(name)[row]);
        assert!(
            low <= p * (1.0 - expected) + 0.01 && high >= (p * (1.0 - expected) + expected - 0.01).min(1.0),
            "{low} {p} {high}"
        );
    }
}

#[test]
fn conditional_sums_do_not_depend_on_how_the_work_is_shared() {
    let place = Place::new();
    let text = job_of_ten("job", "method = \"conditional\"\nsamples = 65_536\nseed = 4")
        .replace("0.008, 0.012, 0.016, 0.02", "0.012, 0.02");
    let small = text.replace("65_536", "1024");
    place.write("small.toml", &small);
    place.run("submit small.toml --out one --threads 1").done();
    place.run("submit small.toml --out two --threads 2").done();
    for shard in [3, 1, 2] {
        place.run(&format!("submit small.toml --out shards --shard {shard}/3")).done();
    }
    place.run("merge shards").done();
    // Begun with fewer samples, and extended.
    place.write("begun.toml", &small.replace("1024", "256"));
    place.run("submit begun.toml --out extended").done();
    place.run("submit small.toml --out extended").done();
    for other in ["two", "shards", "extended"] {
        assert!(place.surface("one") == place.surface(other), "{other}");
    }
    place.write("job.toml", &small.replace("1024", "32768"));
    place.run("submit job.toml --out whole").done();
    place.assert_survives_kills("whole", &[300, 500, 400], 2);
}

#[test]
fn conditional_columns_are_pinned() {
    // Regression values: another version gives the same columns, or another results version.
    let place = Place::new();
    let table = submitted(&place, "pinned", &job_of_ten("pinned", "method = \"conditional\"\nsamples = 256\nseed = 7"));
    assert_eq!(table.digest(), "a4978a8a34ab8ee554a680f2bd7a227b");
}

#[test]
fn conditional_probabilities_are_refused_where_they_do_not_apply() {
    let place = Place::new();
    let third = "inputs = [\"preload\", \"pad.mass\"]\nrelative_std = 0.1";
    let other = "inputs = [\"pad.mass\"]\nrelative_std = 0.1";
    let flexible = "kind = \"coupled-eigenvalue\"";
    let in_time = "kind = \"time-domain\"\ndisc = \"rigid\"";
    let failed = "kind = \"eigenvalue\"\noutside_physics = \"failed\"";
    for (criterion, random, further, texts) in [
        (EIGENVALUE, BOTH, "", &["lists none", "method = \"exact\""][..]),
        (EIGENVALUE, other, "", &["lists neither", "method = \"sobol\""]),
        (flexible, third, "", &["closed form", "criterion.kind = \"eigenvalue\"", "method = \"sobol\""]),
        (in_time, third, "", &["closed form", "criterion.kind = \"eigenvalue\"", "method = \"sobol\""]),
        (failed, third, "", &["outside_physics", "method = \"conditional\"", "\"monte-carlo\" or \"sobol\""]),
        (EIGENVALUE, third, "derivatives = true", &["derivatives", "method = \"conditional\""]),
        (EIGENVALUE, third, "sensitivity = true", &["sensitivity has no meaning", "use method = \"monte-carlo\""]),
        (EIGENVALUE, third, "evaluate = \"boundary\"", &["evaluate has no meaning", "\"conditional\""]),
        (EIGENVALUE, third, "interval = \"wilson\"", &["interval has no meaning"]),
        (EIGENVALUE, third, "until = { relative = 0.1 }", &["until has no meaning", "use method = \"monte-carlo\""]),
        (EIGENVALUE, third, "samples = 1000", &["16 randomisations", "samples = 1024"]),
    ] {
        place.write("job.toml", &job("job", criterion, random, &format!("method = \"conditional\"\n{further}")));
        place.run("check job.toml").refused(65, texts);
    }
}
