//! Rare events made to be missed: islands, rings, shells and branches of unequal weight, beside regions that are found
//! easily, each with its probability in closed form. A line for each shape: how often an estimate is given, and how often
//! its interval contains the truth.
//!
//! `make coverage` runs it. Everything is seeded.

#![allow(clippy::print_stdout, clippy::disallowed_methods, reason = "a table for people")]
#![allow(clippy::unwrap_used, reason = "a table that cannot be made should say so and stop")]

use stickslip_sampler::rare::population::Points;
use stickslip_sampler::rare::whole;
use stickslip_sampler::special_functions::normal;

/// Seeds of each case.
const SEEDS: u64 = 20;

/// Points of each of 16 randomisations.
const POINTS: u64 = 256;

/// The probability that a standard normal deviate lies between.
fn between(from: f64, to: f64) -> f64 {
    normal::upper_tail(from) - normal::upper_tail(to)
}

/// The probability that the sum of squares of two deviates lies between these squares of radii.
fn ring(from: f64, to: f64) -> f64 {
    libm::exp(-0.5 * from * from) - libm::exp(-0.5 * to * to)
}

type Region = Box<dyn Fn(&[f64]) -> bool>;

/// A region in the first two inputs, with its probability.
fn regions() -> Vec<(String, Region, f64)> {
    let mut found: Vec<(String, Region, f64)> = Vec::new();
    for (near, width) in
        [(2.0, 0.1), (2.5, 0.5), (3.0, 0.3), (3.5, 1.0), (4.0, 0.3), (4.0, 1.0), (5.0, 0.5), (5.0, 2.0)]
    {
        let far = near + width;
        found.push((
            format!("slab from {near} to {far}"),
            Box::new(move |u| (near..far).contains(&u[0])),
            between(near, far),
        ));
    }
    for (x, y, side) in
        [(2.0, 2.0, 0.5), (3.0, -3.0, 1.0), (0.0, 4.0, 1.0), (3.5, -2.0, 0.5), (4.0, 4.0, 1.0), (1.0, 5.0, 0.7)]
    {
        found.push((
            format!("square of {side} from {x}, {y}"),
            Box::new(move |u| (x..x + side).contains(&u[0]) && (y..y + side).contains(&u[1])),
            between(x, x + side) * between(y, y + side),
        ));
    }
    found.push((
        "three islands of unequal weight".to_owned(),
        Box::new(|u| {
            (4.0..4.5).contains(&u[0])
                || (-4.5..-4.2).contains(&u[0])
                || ((-3.5..-3.0).contains(&u[1]) && (0.0..4.0).contains(&u[0]))
        }),
        between(4.0, 4.5) + between(4.2, 4.5) + between(3.0, 3.5) * between(0.0, 4.0),
    ));
    found.push((
        "two branches".to_owned(),
        Box::new(|u| u[0] > 4.0 || u[1] < -4.6),
        1.0 - (1.0 - normal::upper_tail(4.0)) * (1.0 - normal::upper_tail(4.6)),
    ));
    for (from, to) in [(3.5, 3.6), (4.0, 4.5), (4.5, 40.0), (5.0, 5.05), (6.0, 6.5)] {
        found.push((
            format!("ring from {from} to {to}"),
            Box::new(move |u| (from * from..to * to).contains(&(u[0] * u[0] + u[1] * u[1]))),
            ring(from, to),
        ));
    }
    found
}

fn main() {
    println!(
        "{:<36} {:>6} {:<18} {:>9} {:>6} {:>8} {:>7} {:>11}",
        "region", "inputs", "beside it", "P", "given", "coverage", "worst", "evaluations"
    );
    let (mut all, mut given_all, mut covered_all) = (0, 0, 0);
    for (name, region, p) in regions() {
        for (inputs, beside) in [
            (2, "nothing"),
            (3, "a branch at 6"),
            (3, "a valley of 1e-7"),
            (3, "a valley of 1e-5"),
            (10, "a branch at 5.5"),
        ] {
            // What lies beside it depends on the other inputs.
            let others = (inputs - 2) as f64;
            let more = |u: &[f64]| -> f64 {
                let sum = || u[2..].iter().sum::<f64>() / others.sqrt();
                match beside {
                    "a branch at 6" => f64::from(u8::from(sum() > 6.0)),
                    "a branch at 5.5" => f64::from(u8::from(sum() > 5.5)),
                    // A conditional probability that is nowhere zero.
                    "a valley of 1e-7" => normal::upper_tail((5.2 - 0.5 * sum()) / 0.75_f64.sqrt()),
                    "a valley of 1e-5" => normal::upper_tail((4.26 - 0.5 * sum()) / 0.75_f64.sqrt()),
                    _ => 0.0,
                }
            };
            let aside = match beside {
                "a branch at 6" => normal::upper_tail(6.0),
                "a branch at 5.5" => normal::upper_tail(5.5),
                "a valley of 1e-7" => normal::upper_tail(5.2),
                "a valley of 1e-5" => normal::upper_tail(4.26),
                _ => 0.0,
            };
            let truth = p + aside - p * aside;
            let value = |u: &[f64]| Some(if region(u) { 1.0 } else { more(u) });
            let (mut given, mut covered, mut worst, mut evaluations) = (0, 0, 0.0_f64, 0.0);
            for seed in 0..SEEDS {
                let mut integrand = |points: &Points| Some(points.iter().map(value).collect());
                let found = whole::importance(inputs, POINTS, seed, 0.95, &mut integrand).unwrap();
                evaluations += found.evaluations / SEEDS as f64;
                if let Some(p) = found.estimate.probability {
                    given += 1;
                    covered += u64::from(found.estimate.low <= truth && truth <= found.estimate.high);
                    let end = if p < truth { found.estimate.high } else { found.estimate.low };
                    worst = worst.max((p - truth).abs() / (end - p).abs());
                }
            }
            (all, given_all, covered_all) = (all + SEEDS, given_all + given, covered_all + covered);
            let coverage = covered as f64 / given as f64;
            println!(
                "{name:<36} {inputs:>6} {beside:<18} {truth:>9.2e} {given:>6} {coverage:>8.3} {worst:>7.2} {evaluations:>11.0}"
            );
        }
    }
    let coverage = covered_all as f64 / given_all as f64;
    println!("{given_all} of {all} given, {coverage:.4} of these intervals contain the truth");
}
