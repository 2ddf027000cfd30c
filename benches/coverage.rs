//! Coverage of the project's intervals, by simulation and by exact sums. Each case is a line with method, samples,
//! probability, nominal and observed coverage.
//!
//! `make coverage` runs it in some ten minutes; `cargo bench --bench coverage -- sobol` runs one section. Repetitions are
//! seeded. No motion is simulated: verdicts are drawn with a
//! known probability, or come from a boundary in closed form.

#![allow(clippy::print_stdout, clippy::disallowed_methods, reason = "a table for people")]
#![allow(clippy::unwrap_used, reason = "a table that cannot be made should say so and stop")]

use rand::SeedableRng;
use rand_distr::{Binomial, Distribution};
use rand_xoshiro::Xoshiro256PlusPlus;
use stickslip_core::model::pair_boundary::PairBoundary;
use stickslip_core::model::verdict::{Verdict, VerdictCounts};
use stickslip_core::models::pad_on_disc::parameters::Parameters;
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;
use stickslip_sampler::draw::beyond;
use stickslip_sampler::draw::deviates::{DeviateStream, Points};
use stickslip_sampler::estimate::conditional::{ConditionalPart, ProbabilitySums};
use stickslip_sampler::estimate::difference::PairedCounts;
use stickslip_sampler::estimate::difference::{dependent_difference, paired_difference, unpaired_difference};
use stickslip_sampler::estimate::interval::simultaneous_confidence;
use stickslip_sampler::estimate::interval::{BinomialInterval, IntervalKind};
use stickslip_sampler::estimate::looks::{Looks, Precision};
use stickslip_sampler::estimate::score::{ScoreSums, ScoreTotals};
use stickslip_sampler::estimate::sobol_indices::{IndexCounts, indices};
use stickslip_sampler::estimate::{audit, conditional, randomisations};
use stickslip_sampler::inputs::{InputDistribution, Marginal, PairLaw, PairParameter};
use stickslip_sampler::integrate::NormalPair;
use stickslip_sampler::integrate::pair::Pair;
use stickslip_sampler::rare::points::{Integrand, LimitBranches, LimitState, Points as DeviatePoints};
use stickslip_sampler::rare::whole;
use stickslip_sampler::special_functions::normal;

/// One line of the table.
struct Line<'a> {
    method: &'a str,
    samples: u64,
    probability: f64,
    nominal: f64,
    coverage: f64,
    /// `None` for an exact sum over all counts.
    repetitions: Option<u64>,
}

fn print(line: &Line<'_>) {
    let Line { method, samples, probability, nominal, coverage, repetitions } = line;
    let repetitions = repetitions.map_or("exact".to_owned(), |count| count.to_string());
    println!("{method:<70} {samples:>8} {probability:>10.2e} {nominal:>9} {coverage:>8.4} {repetitions:>8}");
}

fn heading(text: &str) {
    println!("\n{text:<70} {:>8} {:>10} {:>9} {:>8} {:>8}", "n", "P", "nominal", "coverage", "of");
}

fn generator(seed: u64) -> Xoshiro256PlusPlus {
    Xoshiro256PlusPlus::seed_from_u64(seed)
}

fn draw(generator: &mut Xoshiro256PlusPlus, samples: u64, p: f64) -> u64 {
    Binomial::new(samples, p).unwrap().sample(generator)
}

fn counts(unstable: u64, samples: u64) -> VerdictCounts {
    VerdictCounts { unstable, stable: samples - unstable, ..VerdictCounts::default() }
}

/// The share of `repetitions` for which `covers` holds.
fn share(repetitions: u64, mut covers: impl FnMut(u64) -> bool) -> f64 {
    (0..repetitions).filter(|&seed| covers(seed)).count() as f64 / repetitions as f64
}

/// The probability that an interval contains `p`, summed over the counts from the most likely one outwards.
fn exact_coverage(interval: &BinomialInterval, samples: u64, p: f64) -> f64 {
    let n = samples as f64;
    let ratio = |k: u64| (n - k as f64) / (k as f64 + 1.0) * p / (1.0 - p);
    let mode = (((n + 1.0) * p) as u64).min(samples);
    let (mut covered, mut total) = (0.0, 0.0);
    let mut add = |k: u64, mass: f64| {
        let (low, high) = interval.bounds(k, samples);
        total += mass;
        covered += if low <= p && p <= high { mass } else { 0.0 };
    };
    add(mode, 1.0);
    let (mut k, mut mass) = (mode, 1.0);
    while k < samples && mass > 1e-18 {
        mass *= ratio(k);
        k += 1;
        add(k, mass);
    }
    (k, mass) = (mode, 1.0);
    while k > 0 && mass > 1e-18 {
        k -= 1;
        mass /= ratio(k);
        add(k, mass);
    }
    covered / total
}

fn binomial_intervals() {
    heading("one cell");
    let kinds = [("Wilson", IntervalKind::Wilson), ("Clopper-Pearson", IntervalKind::ClopperPearson)];
    for (confidence, p) in [(0.95, 1.7e-5), (0.95, 0.3), (0.999, 7.8e-6)] {
        for (name, kind) in kinds {
            let interval = BinomialInterval::new(kind, confidence);
            let coverage = exact_coverage(&interval, 10_000, p);
            print(&Line {
                method: name,
                samples: 10_000,
                probability: p,
                nominal: confidence,
                coverage,
                repetitions: None,
            });
        }
    }
    for confidence in [0.8, 0.9, 0.95, 0.99, 0.999] {
        for (name, kind) in kinds {
            let interval = BinomialInterval::new(kind, confidence);
            // Coverage is smooth between the interval ends of two counts, so a fine geometric grid finds the minimum.
            let of = |i: i32| 1e-6 * (0.05 / 1e-6_f64).powf(f64::from(i) / 4000.0);
            let at = |i: i32| (exact_coverage(&interval, 10_000, of(i)), of(i));
            let (coverage, p) = (0..=4000).map(at).min_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
            let method = format!("{name}, least over P up to 0.05");
            print(&Line {
                method: &method,
                samples: 10_000,
                probability: p,
                nominal: confidence,
                coverage,
                repetitions: None,
            });
        }
    }
}

fn whole_surfaces() {
    heading("all cells together (simultaneous = true)");
    let rare: Vec<f64> = (0..780).map(|i| 8e-7 * 15_f64.powf(f64::from(i) / 779.0)).collect();
    let ordinary: Vec<f64> = (0..728).map(|i| normal::upper_tail(-3.0 + 6.0 * f64::from(i) / 727.0)).collect();
    for (surface, samples, repetitions) in [(&rare, 10_000, 1000), (&ordinary, 1000, 1000)] {
        let cells = surface.len() as u64;
        let each = simultaneous_confidence(0.95, cells);
        for (name, kind) in
            [("Wilson, not offered", IntervalKind::Wilson), ("Clopper-Pearson", IntervalKind::for_confidence(each))]
        {
            let interval = BinomialInterval::new(kind, each);
            let coverage = share(repetitions, |seed| {
                let mut generator = generator(seed);
                surface.iter().all(|&p| {
                    let (low, high) = interval.bounds(draw(&mut generator, samples, p), samples);
                    low <= p && p <= high
                })
            });
            let method = format!("{name}, {cells} cells");
            print(&Line {
                method: &method,
                samples,
                probability: surface[0],
                nominal: 0.95,
                coverage,
                repetitions: Some(repetitions),
            });
        }
    }
}

fn stopping() {
    heading("until: interval at the stop");
    let mut biases = Vec::new();
    for (half_width, relative, p) in [
        (Some(0.002), None, 1e-4),
        (Some(0.0005), None, 1e-4),
        (Some(0.002), None, 1e-3),
        (Some(0.01), None, 0.3),
        (None, Some(0.2), 1e-2),
    ] {
        let precision = Precision { half_width, relative };
        let looks = Looks::new(precision, 200_000, 0.95);
        let (repetitions, mut sum, mut of_shares, mut most) = (10_000, 0.0, 0.0, 0);
        let coverage = share(repetitions, |seed| {
            let mut generator = generator(seed);
            let mut path: Vec<VerdictCounts> = Vec::new();
            loop {
                let before = path.last().copied().unwrap_or_default();
                let more = looks.ends()[path.len()] - before.total();
                path.push(before + counts(draw(&mut generator, more, p), more));
                if looks.is_enough(path.len() - 1, path.last().unwrap()) {
                    break;
                }
            }
            let (estimate, last) = (looks.estimate(&path), path.last().unwrap());
            sum += estimate.probability.unwrap();
            of_shares += last.unstable as f64 / last.total() as f64;
            most = most.max(last.total());
            estimate.low <= p && p <= estimate.high
        });
        let name = half_width.map_or_else(
            || format!("relative = {}", relative.unwrap()),
            |half_width| format!("half_width = {half_width}"),
        );
        print(&Line {
            method: &name,
            samples: most,
            probability: p,
            nominal: 0.95,
            coverage,
            repetitions: Some(repetitions),
        });
        let mean = |sum: f64| 100.0 * (sum / repetitions as f64 / p - 1.0);
        biases.push((name, p, mean(of_shares), mean(sum)));
    }
    println!(
        "\n{:<36} {:>10} {:>28} {:>20}",
        "until: mean deviation from P, %", "P", "of the observed share", "of p_unstable"
    );
    for (name, p, share, estimate) in biases {
        println!("{name:<36} {p:>10.2e} {share:>28.2} {estimate:>20.2}");
    }
}

fn boundary() -> PairBoundary {
    let mut parameters = Parameters::sui_ding_2018();
    parameters.set("operating_point.rotating_speed", 15.0).unwrap();
    PadOnDisc::new(parameters).unwrap().stability_boundary()
}

/// The derivative by the expected static friction coefficient. Samples with a deviate of the preload above
/// `undecided_above` are undecided, so that the exact derivative is known.
fn derivatives() {
    heading("derivatives by the static friction coefficient, 1.96 standard errors");
    let boundary = boundary();
    for (preload, friction, undecided_above, samples, repetitions) in [
        (0.1, 0.39, f64::INFINITY, 2000, 2000),
        (0.1, 0.39, 1.0, 2000, 2000),
        (0.1, 0.272, f64::INFINITY, 1000, 1000),
        (0.1, 0.272, f64::INFINITY, 100_000, 300),
    ] {
        let inputs = NormalPair { expected: [preload, friction], relative_std: [0.2, 0.1] };
        // P(unstable | decided), by the midpoint rule over the deviate of the preload.
        let probability = |friction: f64| {
            let (mut unstable, mut decided, step) = (0.0, 0.0, 1e-3);
            let steps = ((f64::min(undecided_above, 9.0) + 9.0) / step).round() as u32;
            for i in 0..steps {
                let z = -9.0 + step * (f64::from(i) + 0.5);
                let critical = boundary.critical_second(preload * (1.0 + 0.2 * z));
                decided += normal::density(z);
                unstable += normal::density(z) * normal::upper_tail((critical / friction - 1.0) / 0.1);
            }
            unstable / decided
        };
        let h = 1e-4;
        let truth = (probability(friction + h) - probability(friction - h)) / (2.0 * h);
        let (mut given, mut covered) = (0, 0);
        for seed in 0..repetitions {
            let stream = DeviateStream { seed, common_random_numbers: false, dimensions: 2, points: Points::Random };
            let mut sums = ScoreSums::default();
            let mut counts = VerdictCounts::default();
            for z in stream.draw(0, 0, 0..samples).chunks_exact(2) {
                let by_boundary = boundary.verdict(preload * (1.0 + 0.2 * z[0]), friction * (1.0 + 0.1 * z[1]));
                let verdict = if z[0] > undecided_above { Verdict::Undecided } else { by_boundary };
                sums.add(&inputs, [Some(z[0]), Some(z[1])], verdict);
                counts += verdict.into();
            }
            let sums: Vec<i128> = sums.sums().map(i128::from).collect();
            let totals = ScoreTotals::from_sums(&sums.try_into().unwrap());
            let p = counts.unstable as f64 / counts.decided() as f64;
            if let Some((value, error)) = totals.derivative(PairParameter::Expected(1), &inputs, &counts, p) {
                given += 1;
                covered += u64::from((value - truth).abs() <= 1.96 * error);
            }
        }
        let p = probability(friction);
        let undecided = 100.0 * normal::upper_tail(undecided_above);
        let method = format!("{undecided:.0} % undecided; given in {given} of {repetitions} repetitions");
        let coverage = if given == 0 { f64::NAN } else { covered as f64 / given as f64 };
        print(&Line { method: &method, samples, probability: p, nominal: 0.95, coverage, repetitions: Some(given) });
    }
}

fn sobol_points() {
    heading("Sobol points, 16 randomisations");
    for (inputs, points, unstable, confidence) in [
        (1, 64, 20.06, 0.95),
        (1, 64, 20.5, 0.95),
        (1, 1024, 100.1, 0.95),
        (2, 64, 20.06, 0.95),
        (2, 1024, 100.1, 0.95),
        (1, 64, 20.06, 0.999),
        (2, 1024, 100.1, 0.999),
    ] {
        let p = unstable / points as f64;
        let limit = -normal::quantile(p);
        // With two inputs the boundary is a line across both.
        let is_unstable = |z: &[f64]| if inputs == 1 { z[0] > limit } else { 0.6 * z[0] + 0.8 * z[1] > limit };
        let seeds = 2000;
        let coverage = share(seeds, |seed| {
            let stream =
                DeviateStream { seed, common_random_numbers: false, dimensions: inputs, points: Points::Sobol };
            let parts: Vec<VerdictCounts> = (0..16)
                .map(|randomisation| {
                    let deviates = stream.draw(0, randomisation, 0..points);
                    counts(deviates.chunks_exact(inputs).filter(|z| is_unstable(z)).count() as u64, points)
                })
                .collect();
            let estimate = randomisations::estimate(&parts, inputs, confidence);
            estimate.low <= p && p <= estimate.high
        });
        let method = format!("{inputs} random input{}", if inputs == 1 { "" } else { "s" });
        print(&Line {
            method: &method,
            samples: 16 * points,
            probability: p,
            nominal: confidence,
            coverage,
            repetitions: Some(seeds),
        });
    }
}

/// Ten inputs whose weighted sum decides, two of which are integrated over at every sample of the others.
fn conditional_probabilities() {
    heading("conditional probabilities, 16 randomisations");
    // The share of the variance that the two have.
    for (of_two, tail, points, seeds) in [
        (0.5, 0.1, 256, 1000),
        (0.5, 1e-3, 256, 1000),
        (0.5, 1e-3, 4096, 200),
        (0.5, 1e-6, 1024, 500),
        (0.5, 1e-6, 4096, 400),
        (0.8, 1e-3, 256, 1000),
        (0.8, 1e-6, 1024, 500),
        (0.8, 1e-9, 256, 1000),
        (0.8, 1e-9, 1024, 500),
        (0.8, 1e-9, 4096, 400),
        (0.95, 1e-9, 256, 1000),
        (0.95, 1e-12, 256, 1000),
        (0.95, 1e-12, 64, 1000),
    ] {
        let limit = -normal::quantile(tail);
        let others = 8;
        let weight = ((1.0 - of_two) / others as f64).sqrt();
        let given = |z: &[f64]| normal::upper_tail((limit - weight * z.iter().sum::<f64>()) / of_two.sqrt());
        print_conditional(&format!("two have {of_two} of the variance"), others, tail, points, seeds, &given);
    }
    // One or two others, on which the probability depends smoothly.
    for (others, bend, points, seeds) in [
        (1, 0.1_f64, 64, 1000),
        (1, 0.1, 512, 1000),
        (1, 0.1, 1000, 1000),
        (1, 0.1, 1024, 1000),
        (1, 0.1, 2048, 1000),
        (1, 1.0, 2048, 1000),
        (1, 0.1, 16_384, 100),
        (2, 0.1, 2048, 1000),
        (2, 1.0, 2048, 1000),
    ] {
        let p = 0.05 * (1.0 + bend).powf(-0.5 * others as f64);
        let given = |z: &[f64]| 0.05 * (-0.5 * bend * z.iter().map(|z| z * z).sum::<f64>()).exp();
        let method = format!("smooth over {others} other inputs, bent by {bend}");
        print_conditional(&method, others, p, points, seeds, &given);
    }
    // The same of a brake, with its integrals: the logarithms of preload, friction and damping are normal.
    let mut parameters = Parameters::sui_ding_2018();
    parameters.set("friction.kinetic_coefficient", 0.0).unwrap();
    let brake = PadOnDisc::new(parameters).unwrap();
    let damping = brake.parameters().damping.tangential;
    let boundary_with = |factor: f64| {
        let mut parameters = brake.parameters().clone();
        parameters.damping.tangential = damping * factor;
        PadOnDisc::new(parameters).unwrap().stability_boundary()
    };
    for (tail, seeds) in [(1e-3, 200), (1e-9, 200)] {
        let (others, weight, log_std) = (8, 0.05, 0.2_f64);
        let std = (2.0 * log_std * log_std + others as f64 * weight * weight).sqrt();
        let relative_std = (log_std * log_std).exp_m1().sqrt();
        let mean = (0.5 * log_std * log_std).exp();
        let preload = boundary_with(1.0).critical_product / 0.4 * (std * normal::quantile(tail)).exp();
        let lognormal = |median: f64| InputDistribution::relative(&Marginal::Lognormal, median * mean, relative_std);
        let pair = Pair::new(lognormal(preload), lognormal(0.4));
        let given = |z: &[f64]| {
            let boundary = boundary_with((-weight * z.iter().sum::<f64>()).exp());
            pair.probability(&boundary, &PairLaw::correlated(0.0), 1e-8)
        };
        print_conditional("a brake, by integrals", others, tail, 64, seeds, &given);
    }
}

/// Prints the coverage of the mean of `given` at Sobol points of so many inputs.
fn print_conditional(method: &str, inputs: usize, p: f64, points: u64, seeds: u64, given: &dyn Fn(&[f64]) -> f64) {
    let coverage = share(seeds, |seed| {
        let stream = DeviateStream { seed, common_random_numbers: false, dimensions: inputs, points: Points::Sobol };
        let part = |randomisation: u64| {
            let mut sums = ProbabilitySums::default();
            for z in stream.draw(0, randomisation, 0..points).chunks_exact(inputs) {
                sums.add(beyond::weight(z), Some(given(z)));
            }
            let far = beyond::beside(0..points, randomisation);
            let far = stream.draw(0, beyond::RANDOMISATIONS + randomisation, far);
            for z in far.chunks_exact(inputs) {
                let mut point = z.to_vec();
                let weight = beyond::move_out(&mut point);
                sums.add(weight, Some(given(&point)));
            }
            ConditionalPart::from_sums(&sums.sums().map(i128::from))
        };
        let estimate = conditional::estimate(&(0..16).map(part).collect::<Vec<_>>(), 0.95);
        estimate.low <= p && p <= estimate.high
    });
    print(&Line { method, samples: 16 * points, probability: p, nominal: 0.95, coverage, repetitions: Some(seeds) });
}

/// Inputs whose sum decides, of which the probability is rare: samples with weights, and populations.
fn rare_events() {
    heading("rare events, 16 randomisations");
    for (inputs, p) in [(2, 1e-3), (2, 1e-6), (2, 1e-9), (10, 1e-3), (10, 1e-6), (10, 1e-9), (20, 1e-9)] {
        let limit = -normal::quantile(p) * (inputs as f64).sqrt();
        let points = if inputs == 20 { 512 } else { 128 };
        let mut verdicts = verdicts(|u| u.iter().sum::<f64>() > limit);
        print_rare("importance, verdicts", inputs, p, 200, points, &mut verdicts);
        let mut limit_state = LimitState(|u: &[f64]| limit - u.iter().sum::<f64>());
        print_rare("importance, limit state", inputs, p, 1000, 128, &mut limit_state);
    }
    let tail = normal::upper_tail(5.0);
    let mut island = verdicts(|u| u[0] > 5.0 || ((3.0..4.0).contains(&u[0]) && (-4.0..-3.0).contains(&u[1])));
    let side = normal::upper_tail(3.0) - normal::upper_tail(4.0);
    print_rare("importance, an island", 2, tail + side * side, 200, 128, &mut island);
    for (inputs, p) in [(2, 1e-3), (2, 1e-6), (2, 1e-9), (10, 1e-3), (10, 1e-6), (10, 1e-9)] {
        let limit = -normal::quantile(p) * (inputs as f64).sqrt();
        print_rare("subset", inputs, p, 60, 0, &mut verdicts(|u| u.iter().sum::<f64>() > limit));
    }
}

/// Half-spaces beyond some distances, each along an input of its own: by verdicts, by the limit state that is the least of
/// all, and by a limit state of each. One region has most of the probability, or all have about as much.
fn separate_regions() {
    heading("rare events in separate regions, 16 randomisations");
    for (inputs, distances) in [
        (4, &[5.0, 5.0][..]),
        (4, &[4.0, 4.5][..]),
        (10, &[4.0, 4.2][..]),
        (4, &[5.0, 5.0, 5.0, 5.0][..]),
        (4, &[4.0, 4.2, 4.4, 4.6][..]),
        (10, &[4.0, 4.1, 4.2, 4.3][..]),
    ] {
        let tails = distances.iter().map(|distance| normal::upper_tail(*distance));
        let p = tails.fold(0.0, |one_of_them, tail| one_of_them + tail - one_of_them * tail);
        let states = |u: &[f64]| -> Vec<f64> { distances.iter().zip(u).map(|(distance, u)| distance - u).collect() };
        let least = |u: &[f64]| states(u).into_iter().fold(f64::INFINITY, f64::min);
        let count = distances.len();
        let mut verdicts = verdicts(|u| least(u) < 0.0);
        print_rare(&format!("importance, {count} regions, verdicts"), inputs, p, 1000, 128, &mut verdicts);
        let mut limit_state = LimitState(least);
        print_rare(&format!("importance, {count} regions, limit state"), inputs, p, 1000, 128, &mut limit_state);
        let mut branches = LimitBranches::new(count, states);
        print_rare(&format!("importance, {count} regions, branches"), inputs, p, 1000, 128, &mut branches);
    }
}

/// Verdicts on points.
fn verdicts(is_unstable: impl Fn(&[f64]) -> bool) -> impl FnMut(&DeviatePoints) -> Option<Vec<Option<f64>>> {
    move |points| Some(points.iter().map(|u| Some(if is_unstable(u) { 1.0 } else { 0.0 })).collect())
}

/// Prints the coverage of estimates of a rare event, with so many points in each randomisation, or by populations alone
/// if there are none; and their relative error and cost.
fn print_rare(method: &str, inputs: usize, p: f64, seeds: u64, points: u64, integrand: &mut dyn Integrand) {
    let (mut squares, mut trusted, mut evaluations) = (0.0, 0_u64, 0.0);
    let coverage = share(seeds, |seed| {
        let found = match points {
            0 => whole::subset(inputs, 1000, seed, 0.95, integrand),
            points => whole::importance(inputs, points, seed, 0.95, integrand),
        };
        let found = found.unwrap();
        evaluations += found.evaluations;
        if let Some(estimate) = found.estimate.probability {
            trusted += 1;
            squares += (estimate / p - 1.0) * (estimate / p - 1.0);
        }
        found.estimate.low <= p && p <= found.estimate.high
    });
    let error = 100.0 * (squares / trusted as f64).sqrt();
    let percent = 100.0 * trusted as f64 / seeds as f64;
    let method = format!("{method}, {inputs} inputs: error {error:.1} %, {percent:.1} % trusted");
    let samples = (evaluations / seeds as f64) as u64;
    print(&Line { method: &method, samples, probability: p, nominal: 0.95, coverage, repetitions: Some(seeds) });
}

fn sobol_indices() {
    heading("Sobol indices, total, 1.96 standard errors");
    let (samples, seeds) = (4000, 1000);
    // The first input decides; a quarter of the values of the second one has no verdict.
    let verdict = |z: [f64; 2]| (z[1] > -0.6745).then_some(z[0] > 0.3);
    for (i, name, truth) in
        [(0, "of the input that decides", 1.0), (1, "of the input that only makes samples fail", 0.0)]
    {
        let coverage = share(seeds, |seed| {
            let stream = |points| DeviateStream { seed, common_random_numbers: false, dimensions: 2, points };
            let first = stream(Points::Random).draw(0, 0, 0..samples);
            let second = stream(Points::SecondRandom).draw(0, 0, 0..samples);
            let mut counts = IndexCounts::default();
            for (a, b) in first.chunks_exact(2).zip(second.chunks_exact(2)) {
                let mixed = if i == 0 { [b[0], a[1]] } else { [a[0], b[1]] };
                counts.add(verdict([a[0], a[1]]), verdict([b[0], b[1]]), verdict(mixed));
            }
            let found = indices(&counts).unwrap();
            (found.total - truth).abs() <= 1.96 * found.total_error
        });
        let probability = normal::upper_tail(0.3);
        print(&Line { method: name, samples, probability, nominal: 0.95, coverage, repetitions: Some(seeds) });
    }
}

fn differences() {
    heading("differences of two runs");
    let (samples, repetitions) = (1000_u64, 4000);
    // A sample is unstable if a deviate with correlation rho to another is above a limit. The two runs have the same
    // deviates, with rho = 0.9 and -0.9.
    let limit = 0.5;
    let p_of = |rho: f64| normal::upper_tail(limit + 0.5 * rho);
    let truth = p_of(0.9) - p_of(-0.9);
    let (mut covered, names) = (
        [0_u64; 3],
        ["same deviates, paired", "same deviates, assumed independent", "same deviates, dependent in an unknown way"],
    );
    for seed in 0..repetitions {
        let stream = DeviateStream { seed, common_random_numbers: false, dimensions: 2, points: Points::Random };
        let mut pairs = PairedCounts::default();
        for z in stream.draw(0, 0, 0..samples).chunks_exact(2) {
            let is_unstable = |rho: f64| rho * z[0] + (1.0 - rho * rho).sqrt() * z[1] > limit + 0.5 * rho;
            match (is_unstable(0.9), is_unstable(-0.9)) {
                (true, true) => pairs.both += 1,
                (true, false) => pairs.only_first += 1,
                (false, true) => pairs.only_second += 1,
                (false, false) => pairs.neither += 1,
            }
        }
        let (first, second) = (pairs.both + pairs.only_first, pairs.both + pairs.only_second);
        let found = [
            paired_difference(&pairs, 0.95),
            unpaired_difference(first, samples, second, samples, 0.95),
            dependent_difference(first, samples, second, samples, 0.95),
        ];
        for (covered, difference) in covered.iter_mut().zip(found) {
            *covered += u64::from(difference.low <= truth && truth <= difference.high);
        }
    }
    for (covered, name) in covered.into_iter().zip(names) {
        let coverage = covered as f64 / repetitions as f64;
        print(&Line {
            method: name,
            samples,
            probability: p_of(0.9),
            nominal: 0.95,
            coverage,
            repetitions: Some(repetitions),
        });
    }
    // Two seeds of one job: cells that appear to differ although their probabilities are equal.
    let surface: Vec<f64> = (0..780).map(|i| normal::upper_tail(-3.0 + 6.0 * f64::from(i) / 779.0)).collect();
    for (name, confidence) in [
        ("780 equal cells, all intervals contain 0 (--pointwise)", 0.95),
        ("780 equal cells, all intervals contain 0", simultaneous_confidence(0.95, 780)),
    ] {
        let repetitions = 300;
        let coverage = share(repetitions, |seed| {
            let mut generator = generator(seed);
            surface.iter().all(|&p| {
                let [a, b] = [(); 2].map(|()| draw(&mut generator, 10_000, p));
                let difference = unpaired_difference(a, 10_000, b, 10_000, confidence);
                difference.low <= 0.0 && 0.0 <= difference.high
            })
        });
        print(&Line {
            method: name,
            samples: 10_000,
            probability: surface[779],
            nominal: 0.95,
            coverage,
            repetitions: Some(repetitions),
        });
    }
}

fn audits() {
    heading("wrong verdict maps: interval with the audit");
    let confidence = 0.5 + 0.5 * 0.95;
    let interval = BinomialInterval::new(IntervalKind::for_confidence(confidence), confidence);
    for (wrong, audited) in [(0.005, 300), (0.02, 300), (0.3, 300), (0.02, 0)] {
        // The wrong verdicts are stable in the map; the samples are unstable.
        let (p, samples, repetitions) = (0.5, 10_000_u64, 4000);
        let coverage = share(repetitions, |seed| {
            let mut generator = generator(seed);
            let unstable = draw(&mut generator, samples, p - wrong);
            let differed = if audited == 0 { 0 } else { draw(&mut generator, audited, wrong) };
            let (low, high) = interval.bounds(unstable + differed, samples);
            let reach = if audited == 0 { 0.0 } else { audit::upper_bound(differed, audited, confidence) };
            low - reach <= p && p <= high + reach
        });
        let method = format!("{:.1} % of the verdicts wrong, {audited} audited", 100.0 * wrong);
        print(&Line {
            method: &method,
            samples,
            probability: p,
            nominal: 0.95,
            coverage,
            repetitions: Some(repetitions),
        });
    }
}

fn main() {
    println!("Coverage: the share of intervals that contain the true value");
    let sections: [(&str, fn()); 11] = [
        ("binomial", binomial_intervals),
        ("surfaces", whole_surfaces),
        ("until", stopping),
        ("derivatives", derivatives),
        ("sobol", sobol_points),
        ("conditional", conditional_probabilities),
        ("rare", rare_events),
        ("regions", separate_regions),
        ("indices", sobol_indices),
        ("differences", differences),
        ("audits", audits),
    ];
    let wanted: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with('-')).collect();
    for (name, section) in sections {
        if wanted.is_empty() || wanted.iter().any(|wanted| wanted == name) {
            section();
        }
    }
}
