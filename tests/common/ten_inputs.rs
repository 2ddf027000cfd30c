//! A job of ten random inputs whose probabilities are known in closed form: without kinetic friction, a brake is unstable
//! by a product of powers of its parameters.

use stickslip_core::model::pair_boundary::PairBoundary;
use stickslip_core::models::pad_on_disc::parameters::Parameters;
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;
use stickslip_sampler::special_functions::normal;

use super::{EIGENVALUE, Table};

pub fn boundary(kinetic_coefficient: f64) -> PairBoundary {
    let mut parameters = Parameters::sui_ding_2018();
    parameters.set("operating_point.rotating_speed", 15.0).unwrap();
    parameters.set("friction.kinetic_coefficient", kinetic_coefficient).unwrap();
    PadOnDisc::new(parameters).unwrap().stability_boundary()
}

/// The mean of the logarithm of a lognormal input, and its standard deviation.
pub fn logarithm(expected: f64, relative_std: f64) -> (f64, f64) {
    let variance = (relative_std * relative_std).ln_1p();
    (expected.ln() - 0.5 * variance, variance.sqrt())
}

/// Inputs with lognormal distributions, each with its relative standard deviation and the power to which the driving
/// over the damping of a brake without kinetic friction depends on it.
const TEN: [(&str, f64, f64); 10] = [
    ("preload", 0.2, 1.0),
    ("static_friction", 0.1, 1.0),
    ("damping.tangential", 0.1, -1.0),
    ("stiffness.contact_tangential_1", 0.05, -1.0),
    ("stiffness.contact_tangential_2", 0.08, 1.0),
    ("disc.thickness", 0.02, 1.0),
    ("pad.mass", 0.1, 0.0),
    ("pad.moment_of_inertia", 0.1, 0.0),
    ("damping.normal", 0.2, 0.0),
    ("stiffness.calliper_angular", 0.1, 0.0),
];

/// Correlated pairs of them.
const PAIRS: [(&str, &str, f64); 5] = [
    ("preload", "static_friction", -0.3),
    ("preload", "damping.tangential", 0.4),
    ("stiffness.contact_tangential_2", "static_friction", 0.3),
    ("stiffness.contact_tangential_1", "stiffness.contact_tangential_2", 0.5),
    ("pad.mass", "preload", 0.2),
];

/// A job with these inputs.
pub fn job_of_ten(name: &str, sampling: &str) -> String {
    let quoted = |name: &str| format!("\"{name}\"");
    let inputs = TEN.map(|(name, ..)| quoted(name)).join(", ");
    let stds = TEN.map(|(name, std, _)| format!("{} = {std}", quoted(name))).join(", ");
    let pairs = PAIRS.map(|(a, b, rho)| format!("[{}, {}, {rho}]", quoted(a), quoted(b))).join(", ");
    format!(
        "name = \"{name}\"\n[model.friction]\nkinetic_coefficient = 0.0\n[axes]\nrotating_speed = 15.0\n\
         preload = [0.008, 0.012, 0.016, 0.02]\nstatic_friction = 0.4\n[random]\ninputs = [{inputs}]\n\
         relative_std = {{ {stds} }}\ndistribution = \"lognormal\"\ncorrelation = [{pairs}]\n[criterion]\n{EIGENVALUE}\n\
         [sampling]\n{sampling}\n"
    )
}

/// The probabilities of its cells, each the tail of a sum of normal logarithms.
pub fn expected_of_ten(table: &Table) -> Vec<f64> {
    let critical = boundary(0.0).critical_product;
    let logarithms = TEN.map(|(_, std, power)| {
        let (mean, log_std) = logarithm(1.0, std);
        (power * mean, power * log_std)
    });
    let place = |name: &str| TEN.iter().position(|(own, ..)| *own == name).unwrap();
    let mut variance: f64 = logarithms.iter().map(|(_, std)| std * std).sum();
    for (a, b, rho) in PAIRS {
        variance += 2.0 * rho * logarithms[place(a)].1 * logarithms[place(b)].1;
    }
    let mean: f64 = logarithms.iter().map(|(mean, _)| mean).sum();
    let products = table.column("preload").iter().zip(table.column("static_friction"));
    products
        .map(|(preload, friction)| {
            normal::upper_tail((critical.ln() - (preload * friction).ln() - mean) / variance.sqrt())
        })
        .collect()
}
