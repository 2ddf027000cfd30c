//! Probabilities integrated over preload and static friction with any distribution and correlation.

#![allow(clippy::disallowed_methods, reason = "expected values are computed as a textbook writes them")]
#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so and stop")]

mod common;

use common::{EIGENVALUE, Place, job, submitted};
use stickslip_core::parameters::Parameters;
use stickslip_core::rigid_disc::pad_on_disc::PadOnDisc;
use stickslip_core::rigid_disc::stability::StabilityBoundary;
use stickslip_sampler::special_functions::normal;

fn boundary(kinetic_coefficient: f64) -> StabilityBoundary {
    let mut parameters = Parameters::sui_ding_2018();
    parameters.set("operating_point.rotating_speed", 15.0).unwrap();
    parameters.set("friction.kinetic_coefficient", kinetic_coefficient).unwrap();
    PadOnDisc::new(parameters).unwrap().stability_boundary()
}

/// The mean of the logarithm of a lognormal input, and its standard deviation.
fn logarithm(expected: f64, relative_std: f64) -> (f64, f64) {
    let variance = (relative_std * relative_std).ln_1p();
    (expected.ln() - 0.5 * variance, variance.sqrt())
}

#[test]
fn integrals_over_correlated_lognormal_inputs_are_those_of_a_normal_sum() {
    // Without kinetic friction a sample is unstable by the product of its inputs.
    let place = Place::new();
    let critical = boundary(0.0).critical_product();
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
            rare += u32::from(expected < 1e-6 && expected > 1e-15);
        }
        assert!(rare > 2, "{rare} rare events");
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
