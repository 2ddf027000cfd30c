//! Rare events made to be missed: islands, rings, shells and branches of unequal weight, beside regions that are found
//! easily, each with its probability in closed form. A line for each shape: how often an estimate is given, and how often
//! its interval contains the truth.
//!
//! Then limit states with gradients. Then brakes whose measured friction curves are drawn at random, most of them with
//! several unstable regions. Preload and friction are integrated over or drawn too, rotating speed and damping scatter; the
//! truth is a sum over a grid of both.
//!
//! `make coverage` runs it. Everything is seeded.

#![allow(clippy::print_stdout, clippy::disallowed_methods, reason = "a table for people")]
#![allow(clippy::unwrap_used, reason = "a table that cannot be made should say so and stop")]

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use stickslip_core::friction::measured_curve::{MeasuredCurve, SharedCurve};
use stickslip_core::model::pair_boundary::PairBoundary;
use stickslip_core::models::pad_on_disc::parameters::Parameters;
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;
use stickslip_sampler::estimate::interval::Estimate;
use stickslip_sampler::inputs::{InputDistribution, Marginal, PairLaw};
use stickslip_sampler::integrate::pair::Pair;
use stickslip_sampler::rare::points::{ConditionalProbability, LimitState, Points};
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
fn islands() -> Vec<(String, Region, f64)> {
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
    // A part by its name, or all.
    let wanted = std::env::args().skip(1).find(|argument| !argument.starts_with('-'));
    for (name, part) in [("shapes", shapes as fn()), ("smooth", smooth), ("brakes", brakes)] {
        if wanted.as_deref().is_none_or(|wanted| wanted == name) {
            part();
        }
    }
}

/// A limit state.
type Limit = Box<dyn Fn(&[f64]) -> f64>;

/// The probability of a disc in two deviates, so far from the origin, by the midpoint rule.
fn disc(distance: f64, radius: f64) -> f64 {
    let (rings, angles) = (400, 400);
    let mut sum = 0.0;
    for ring in 0..rings {
        let r = radius * (f64::from(ring) + 0.5) / f64::from(rings);
        for angle in 0..angles {
            let cosine = libm::cos(std::f64::consts::TAU * f64::from(angle) / f64::from(angles));
            sum += r * libm::exp(-0.5 * (distance * distance + r * r + 2.0 * r * distance * cosine));
        }
    }
    sum * radius / f64::from(rings) / f64::from(angles)
}

/// Limit states with gradients, each with the probability that it is below zero.
fn limit_states() -> Vec<(String, usize, Limit, f64)> {
    let mut found: Vec<(String, usize, Limit, f64)> = Vec::new();
    for inputs in [2, 10, 20] {
        for p in [1e-3, 1e-6, 1e-9] {
            let limit = -normal::quantile(p);
            let root = libm::sqrt(inputs as f64);
            let state: Limit = Box::new(move |u| limit - u.iter().sum::<f64>() / root);
            found.push(("plane".to_owned(), inputs, state, p));
        }
    }
    for (near, far) in [(4.0, 4.1), (4.0, 4.6), (3.0, 5.0)] {
        let tails = [near, far].map(normal::upper_tail);
        let state: Limit = Box::new(move |u| (near - u[0]).min(far + u[1]));
        found.push((format!("branches at {near} and {far}"), 4, state, tails[0] + tails[1] - tails[0] * tails[1]));
    }
    for (from, to) in [(4.0, 4.3), (5.0, 5.5)] {
        for beyond in [5.5, 6.5] {
            let state: Limit = Box::new(move |u| {
                let slab = (u[0] - 0.5 * (from + to)).abs() - 0.5 * (to - from);
                slab.min(beyond - u[1..].iter().sum::<f64>() / 3.0)
            });
            let (slab, branch) = (between(from, to), normal::upper_tail(beyond));
            let p = slab + branch - slab * branch;
            found.push((format!("slab from {from} to {to}, branch at {beyond}"), 10, state, p));
        }
    }
    for (bend, limit) in [(0.1, 4.5), (-0.05, 4.5), (0.3, 3.5)] {
        // A paraboloid: the sum of the squares of nine deviates is integrated over.
        let state: Limit = Box::new(move |u| limit + bend * u[1..].iter().map(|u| u * u).sum::<f64>() - u[0]);
        let step = 0.001;
        let chi = |x: f64| libm::pow(x, 3.5) * libm::exp(-0.5 * x) / (libm::pow(2.0, 4.5) * 11.631_728_396_567_448);
        let term = |i: i32| {
            let x = step * (f64::from(i) + 0.5);
            step * chi(x) * normal::upper_tail(limit + bend * x)
        };
        found.push((format!("paraboloid of {bend} at {limit}"), 10, state, (0..100_000).map(term).sum()));
    }
    for inputs in [4, 10, 20] {
        let state: Limit = Box::new(|u| (5.5 - u[2]).min((3.0 - u[0]).max(3.2 - u[1])));
        let (corner, plane) = (normal::upper_tail(3.0) * normal::upper_tail(3.2), normal::upper_tail(5.5));
        found.push(("corner at 3, 3.2, branch at 5.5".to_owned(), inputs, state, corner + plane - corner * plane));
    }
    for (radius, inputs) in [(0.3, 3), (0.3, 6), (0.6, 3), (0.6, 6), (0.6, 10)] {
        let state: Limit = Box::new(move |u| (0.7 * (5.0 - u[2])).min(libm::hypot(u[0] + 4.0, u[1] - 3.0) - radius));
        let (disc, plane) = (disc(5.0, radius), normal::upper_tail(5.0));
        found.push((format!("disc of {radius}, branch at 5"), inputs, state, disc + plane - disc * plane));
    }
    for radius in [4.5, 6.0] {
        let state: Limit = Box::new(move |u| radius - libm::sqrt(u[0] * u[0] + u[1] * u[1]));
        found.push((format!("ring beyond {radius}"), 2, state, ring(radius, 40.0)));
    }
    for waves in [1.5, 3.0] {
        let state: Limit = Box::new(move |u| 4.5 + libm::cos(waves * u[1]) - u[0]);
        let term = |i: i32| {
            let x = 0.001 * f64::from(i);
            0.001 * normal::density(x) * normal::upper_tail(4.5 + libm::cos(waves * x))
        };
        found.push((format!("{waves} waves"), 2, state, (-10_000..=10_000).map(term).sum()));
    }
    found
}

/// Limit states with gradients: the same columns.
fn smooth() {
    println!();
    let (mut all, mut given_all, mut covered_all) = (0, 0, 0);
    for (name, inputs, state, truth) in limit_states() {
        let (mut given, mut covered, mut worst, mut evaluations) = (0, 0, 0.0_f64, 0.0);
        let mut squares = 0.0;
        let started = std::time::Instant::now();
        for seed in 0..SEEDS {
            let found = whole::importance(inputs, 128, seed, 0.95, &mut LimitState(&state)).unwrap();
            evaluations += found.evaluations / SEEDS as f64;
            if let Some(p) = found.estimate.probability {
                given += 1;
                squares += (p / truth - 1.0) * (p / truth - 1.0);
                covered += u64::from(found.estimate.low <= truth && truth <= found.estimate.high);
                let end = if p < truth { found.estimate.high } else { found.estimate.low };
                worst = worst.max((p - truth).abs() / (end - p).abs());
            }
        }
        let seconds = started.elapsed().as_secs_f64() / SEEDS as f64;
        (all, given_all, covered_all) = (all + SEEDS, given_all + given, covered_all + covered);
        let coverage = covered as f64 / given as f64;
        let error = 100.0 * libm::sqrt(squares / given as f64);
        println!(
            "{name:<36} {inputs:>6} {truth:>9.2e} {given:>6} {coverage:>8.3} {worst:>7.2} {evaluations:>11.0} {error:>6.1} % {:>8.2} ms",
            1e3 * seconds
        );
    }
    let coverage = covered_all as f64 / given_all as f64;
    println!("{given_all} of {all} given, {coverage:.4} of these intervals contain the truth");
}

/// Regions in closed form.
fn shapes() {
    println!(
        "{:<36} {:>6} {:<18} {:>9} {:>6} {:>8} {:>7} {:>11}",
        "region", "inputs", "beside it", "P", "given", "coverage", "worst", "evaluations"
    );
    let (mut all, mut given_all, mut covered_all) = (0, 0, 0);
    for (name, region, p) in islands() {
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

/// Brakes, and the least and largest probability of those that are counted.
const BRAKES: usize = 300;
const COUNTED: [f64; 2] = [1e-13, 0.3];

/// What was found for a brake: by conditional probabilities, and by its limit state with preload and friction drawn too.
struct Found {
    seed: u64,
    regions: usize,
    truth: f64,
    estimates: [Estimate; 2],
}

/// Estimates for brakes with measured friction curves, a share of them on each thread.
fn brakes() {
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let found: Vec<Found> = std::thread::scope(|scope| {
        let of_thread = |thread: usize| scope.spawn(move || of_brakes(thread, threads, BRAKES.div_ceil(threads)));
        let threads: Vec<_> = (0..threads).map(of_thread).collect();
        threads.into_iter().flat_map(|thread| thread.join().unwrap()).collect()
    });
    let several = found.iter().filter(|found| found.regions > 1).count();
    println!("\n{} brakes, {several} with several unstable regions", found.len());
    for (way, name) in ["conditional probabilities", "limit states"].into_iter().enumerate() {
        let (mut given, mut covered) = (0_u32, 0_u32);
        let mut worst: Vec<(f64, String)> = Vec::new();
        for Found { seed, regions, truth, estimates } in &found {
            let estimate = &estimates[way];
            let Some(p) = estimate.probability else { continue };
            given += 1;
            covered += u32::from(estimate.low <= *truth && *truth <= estimate.high);
            let end = if p < *truth { estimate.high } else { estimate.low };
            let off = (p - truth).abs() / (end - p).abs();
            worst.push((
                off,
                format!("brake {seed}: {regions} regions, P {truth:.3e}, found {p:.3e}, off by {off:.2} half widths"),
            ));
        }
        worst.sort_by(|a, b| b.0.total_cmp(&a.0));
        let coverage = f64::from(covered) / f64::from(given);
        println!("{name}: {given} given, {coverage:.4} of these intervals contain the truth; the worst:");
        worst.iter().take(5).for_each(|(_, line)| println!("{line}"));
    }
}

/// So many brakes of one of some threads. Two thirds have several unstable regions.
fn of_brakes(thread: usize, threads: usize, count: usize) -> Vec<Found> {
    let mut all: Vec<Found> = Vec::new();
    let (mut single, mut seed) = (0, thread as u64);
    while all.len() < count {
        let brake = Brake::draw(&mut Xoshiro256PlusPlus::seed_from_u64(seed));
        let is_wanted = |regions: usize| regions > 1 || 3 * single < count;
        if is_wanted(brake.regions())
            && let (truth, regions) = brake.truth()
            && (COUNTED[0]..COUNTED[1]).contains(&truth)
            && is_wanted(regions)
        {
            single += usize::from(regions < 2);
            let mut integrand =
                ConditionalProbability(|points: &Points| Some(points.iter().map(|u| brake.given(u)).collect()));
            let given = whole::importance(2, 128, seed, 0.95, &mut integrand).unwrap().estimate;
            let mut limit_state = LimitState(|u: &[f64]| brake.limit_state(u));
            let decided = whole::importance(4, 128, seed, 0.95, &mut limit_state).unwrap().estimate;
            all.push(Found { seed, regions, truth, estimates: [given, decided] });
        }
        seed += threads as u64;
    }
    all
}

/// A brake with a measured friction curve; its rotating speed and tangential damping scatter.
struct Brake {
    parameters: Parameters,
    stds: [f64; 2],
    inputs: [InputDistribution; 2],
    pair: Pair,
}

impl Brake {
    fn draw(generator: &mut Xoshiro256PlusPlus) -> Self {
        let mut between = |from: f64, to: f64| from + (to - from) * generator.random::<f64>();
        // A curve that falls, rises or drops from one row to the next.
        let (mut speeds, mut coefficients) = (vec![0.0], vec![between(0.35, 0.55)]);
        while *speeds.last().unwrap() < 6.0 {
            let (speed, coefficient) = (*speeds.last().unwrap(), *coefficients.last().unwrap());
            speeds.push(speed + between(0.15, 0.7));
            let slope = match between(0.0, 1.0) {
                kind if kind < 0.4 => between(-0.03, 0.0),
                kind if kind < 0.7 => between(0.0, 0.05),
                _ => between(-0.25, -0.03),
            };
            coefficients.push((coefficient + slope * (speeds.last().unwrap() - speed)).max(0.05));
        }
        let mut parameters = Parameters::sui_ding_2018();
        parameters.friction.use_table(SharedCurve::new(MeasuredCurve::new(&speeds, &coefficients, None).unwrap()));
        let mut set = |key: &str, value: f64| parameters.set(key, value).unwrap();
        set("operating_point.rotating_speed", between(5.0, 25.0));
        set("damping.tangential", between(50.0, 1500.0));
        let (preload, friction) = (between(0.01, 0.2), parameters.friction.static_coefficient);
        let input = |expected: f64, std: f64| InputDistribution::relative(&Marginal::Normal, expected, std);
        let inputs = [input(preload, between(0.05, 0.15)), input(friction, between(0.04, 0.1))];
        let pair = Pair::new(inputs[0].clone(), inputs[1].clone());
        Self { stds: [between(0.03, 0.12), between(0.03, 0.12)], inputs, pair, parameters }
    }

    /// The boundary of stability given two deviates.
    fn boundary(&self, u: &[f64]) -> Option<PairBoundary> {
        let mut parameters = self.parameters.clone();
        let speed = parameters.operating_point.rotating_speed * (1.0 + self.stds[0] * u[0]);
        parameters.set("operating_point.rotating_speed", speed).ok()?;
        parameters.damping.tangential *= 1.0 + self.stds[1] * u[1];
        Some(PadOnDisc::new(parameters).ok()?.stability_boundary())
    }

    /// The probability given two deviates.
    fn given(&self, u: &[f64]) -> Option<f64> {
        Some(self.pair.probability(&self.boundary(u)?, &PairLaw::correlated(0.0), 1e-6))
    }

    /// The limit state of four deviates, the last two those of preload and friction.
    fn limit_state(&self, u: &[f64]) -> f64 {
        let [preload, friction] = [0, 1].map(|i| self.inputs[i].value(u[2 + i]));
        self.boundary(&u[..2]).map_or(f64::NAN, |boundary| boundary.limit_state(preload, friction))
    }

    /// The probability, by the trapezoidal rule, and how many regions of the speed matter.
    fn truth(&self) -> (f64, usize) {
        let coarse = 0.4;
        let given = |speed: f64| -> f64 {
            let at = |k: i32| {
                let damping = coarse * f64::from(k);
                self.given(&[speed, damping]).unwrap_or(0.0) * normal::density(damping) * coarse
            };
            (-20..=20).map(at).sum()
        };
        let along = along(given);
        (along.iter().sum::<f64>() * FINE, regions(&along))
    }

    /// How many regions of the speed matter with the expected damping.
    fn regions(&self) -> usize {
        regions(&along(|speed| self.given(&[speed, 0.0]).unwrap_or(0.0)))
    }
}

/// The distance of the deviates of a sum.
const FINE: f64 = 0.01;

/// What a deviate adds to a mean, from -8 to 8.
fn along(given: impl Fn(f64) -> f64) -> Vec<f64> {
    (-800..=800).map(|i| FINE * f64::from(i)).map(|u| given(u) * normal::density(u)).collect()
}

/// The peaks of at least a hundredth of the highest, with a valley of a tenth between them.
fn regions(along: &[f64]) -> usize {
    let highest = along.iter().copied().fold(0.0, f64::max);
    let (mut regions, mut rises, mut extreme) = (0, true, 0.0_f64);
    for &at in along.iter().chain([&0.0]) {
        if rises && at < 0.1 * extreme {
            regions += usize::from(extreme > 0.01 * highest);
            (rises, extreme) = (false, at);
        } else if !rises && at > 10.0 * extreme {
            (rises, extreme) = (true, at);
        } else {
            extreme = if rises { extreme.max(at) } else { extreme.min(at) };
        }
    }
    regions
}
