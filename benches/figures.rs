//! `make bench`: one line for each figure: name, value, unit. Ratios are taken within this one run; absolute values
//! depend on the machine.

#![allow(clippy::disallowed_methods, reason = "no result depends on a benchmark")]
#![allow(clippy::expect_used, clippy::print_stdout, reason = "a benchmark that cannot run should say so and stop")]

use std::fs;
use std::hint::black_box;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use rand::RngExt as _;
use rand_distr::StandardNormal;
use stickslip_core::model::decision::Decision;
use stickslip_core::model::verdict::VerdictCounts;
use stickslip_core::models::pad_on_disc::criterion::settings::TimeDomainSettings;
use stickslip_core::models::pad_on_disc::criterion::time_domain::{DiscModel, TimeDomain};
use stickslip_core::models::pad_on_disc::lanes::dispatch::InstructionSet;
use stickslip_core::models::pad_on_disc::motion::moment::Moment;
use stickslip_core::models::pad_on_disc::motion::start::Start;
use stickslip_core::models::pad_on_disc::parameters::Parameters;
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};
use stickslip_sampler::draw::deviates::{DeviateStream, Points};
use stickslip_sampler::draw::identity::block_generator;
use stickslip_sampler::draw::identity::{BLOCK_SAMPLES, Purpose};
use stickslip_sampler::inputs::{Correlation, InputColumns, Marginal};
use stickslip_sampler::integrate::NormalPair;

/// A cell of Figure 14: its number, its rotating speed, and its preload and static friction.
const CELL: u64 = 17;
const SPEED: f64 = 15.0;
const PAIR: NormalPair = NormalPair { expected: [0.1, 0.39], relative_std: [0.2, 0.2] };

fn figure(name: &str, value: f64, unit: &str) {
    let digits = if value >= 1000.0 { 0 } else { 3 };
    println!("{name:<58} {value:>16.digits$} {unit}");
}

fn main() {
    // `cargo test --benches` passes --test; there is nothing to measure then.
    if std::env::args().any(|argument| argument == "--test") {
        return;
    }
    sampling();
    threads();
    memory();
    start_up();
    lanes();
    convergence();
    figure_14b();
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// The time of `work` in seconds.
fn seconds(work: impl FnOnce()) -> f64 {
    let started = Instant::now();
    work();
    started.elapsed().as_secs_f64()
}

/// Normal preload and static friction.
fn scatter<'a>(pair: &NormalPair, independent: &'a Correlation) -> InputColumns<'a> {
    InputColumns::new(&[Marginal::Normal, Marginal::Normal], independent, &pair.expected, &pair.relative_std)
}

/// The loop over samples on one thread, alternately with and without verdicts.
fn sampling() {
    const SAMPLES: u64 = 10_000_000;
    let mut parameters = Parameters::sui_ding_2018();
    parameters.operating_point.rotating_speed = SPEED;
    let boundary = PadOnDisc::new(parameters).expect("the preset is valid").stability_boundary();
    let stream = DeviateStream { seed: 2018, common_random_numbers: false, dimensions: 2, points: Points::Random };
    let decided = || {
        let mut counts = VerdictCounts::default();
        let independent = Correlation::independent(2);
        let scatter = scatter(&PAIR, &independent);
        stream.for_each_chunk(CELL, 0, 0..SAMPLES, |columns| {
            scatter.apply(columns);
            counts += boundary.count(&columns[0], &columns[1]);
        });
        black_box(counts);
    };
    // The same blocks and deviates alone.
    let raw = || {
        let mut deviates = [[0.0_f64; 2]; 250];
        for block in 0..SAMPLES / BLOCK_SAMPLES {
            let mut generator = block_generator(2018, Purpose::Inputs, CELL, block);
            for _ in 0..BLOCK_SAMPLES / 250 {
                for pair in &mut deviates {
                    *pair = [generator.sample(StandardNormal), generator.sample(StandardNormal)];
                }
                black_box(&mut deviates);
            }
        }
    };
    let (mut decided_times, mut raw_times, mut ratios) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..15 {
        let (with, without) = (seconds(decided), seconds(raw));
        decided_times.push(with);
        raw_times.push(without);
        ratios.push(with / without);
    }
    figure("samples with verdict, one thread", SAMPLES as f64 / median(decided_times), "samples/s");
    figure("two normal deviates only, one thread", SAMPLES as f64 / median(raw_times), "samples/s");
    figure("verdict and bookkeeping over raw sampling (limit 0.2)", median(ratios) - 1.0, "of raw time");
}

/// A job file in a directory of its own.
fn job(directory: &Path, name: &str, cells: usize, samples: u64) -> std::path::PathBuf {
    let path = directory.join(format!("{name}.toml"));
    let text = format!(
        "name = \"{name}\"\n[axes]\nrotating_speed = 15.0\npreload = {{ from = 0.01, to = 0.30, points = {cells} }}\n\
         static_friction = {{ from = 0.25, to = 0.50, points = {cells} }}\n[random]\ninputs = [\"preload\", \
         \"static_friction\"]\nrelative_std = 0.2\n[criterion]\nkind = \"eigenvalue\"\n[sampling]\nsamples = {samples}\nseed = 1\n"
    );
    fs::write(&path, text).expect("the job file can be written");
    path
}

/// Runs a job in a new directory. Returns seconds and peak memory in MiB of the whole process.
fn submit(directory: &Path, job: &Path, threads: usize) -> (f64, f64) {
    let out = directory.join("run");
    let _ = fs::remove_dir_all(&out);
    let started = Instant::now();
    let mut child = Command::new(env!("CARGO_BIN_EXE_stickslip"))
        .args([Path::new("submit"), job, Path::new("--out"), &out, Path::new("--threads")])
        .arg(threads.to_string())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("stickslip starts");
    let status = format!("/proc/{}/status", child.id());
    let mut peak = 0.0;
    loop {
        if let Some(done) = child.try_wait().expect("stickslip can be waited for") {
            assert!(done.success(), "stickslip failed");
            return (started.elapsed().as_secs_f64(), peak);
        }
        // The kernel records the peak itself, so polling misses only the last moment.
        let text = fs::read_to_string(&status).unwrap_or_default();
        let mark =
            text.lines().find_map(|line| line.strip_prefix("VmHWM:")?.split_whitespace().next()?.parse::<f64>().ok());
        peak = mark.map_or(peak, |kib| kib / 1024.0);
        thread::sleep(Duration::from_millis(2));
    }
}

/// As many threads as the machine has processors.
fn all_threads() -> usize {
    thread::available_parallelism().map_or(1, std::num::NonZero::get)
}

/// The numbers of threads that have a row: powers of two up to the processors of the machine, and all of these.
fn thread_counts() -> Vec<usize> {
    let all = all_threads();
    (0..).map(|exponent| 1 << exponent).take_while(|&count| count < all).chain([all]).collect()
}

/// Whole runs of a job: a row for each number of threads, and its gain over one thread. The numbers of threads take turns.
fn by_threads(name: &str, directory: &Path, job: &Path, samples: f64, rounds: usize) {
    let counts = thread_counts();
    let mut times = vec![Vec::new(); counts.len()];
    for _ in 0..rounds {
        for (times, &count) in times.iter_mut().zip(&counts) {
            times.push(submit(directory, job, count).0);
        }
    }
    for (own, count) in times.iter().zip(&counts) {
        figure(&format!("{name}, threads: {count}"), samples / median(own.clone()), "samples/s");
    }
    for (own, count) in times.iter().zip(&counts).skip(1) {
        let gains = times[0].iter().zip(own).map(|(one, more)| one / more).collect();
        let limit = if *count == 2 { " (at least 1.9)" } else { "" };
        figure(&format!("{name}, {count} threads over one{limit}"), median(gains), "times");
    }
}

fn threads() {
    let directory = tempfile::tempdir().expect("a temporary directory can be made");
    let job = job(directory.path(), "threads", 20, 1_000_000);
    by_threads("whole run of 4e8 samples", directory.path(), &job, 400.0 * 1e6, 7);
    // Processes that share nothing show the gain that the machine allows.
    for count in thread_counts().into_iter().skip(1) {
        let apart: Vec<_> = (0..count).map(|number| directory.path().join(number.to_string())).collect();
        let gains = (0..3).map(|_| {
            let single = submit(directory.path(), &job, 1).0;
            let together = seconds(|| {
                thread::scope(|scope| {
                    for path in &apart {
                        fs::create_dir_all(path).expect("a directory can be made");
                        let job = &job;
                        scope.spawn(move || submit(path, job, 1));
                    }
                });
            });
            count as f64 * single / together
        });
        figure(&format!("{count} separate processes over one (the machine's limit)"), median(gains.collect()), "times");
    }
}

fn memory() {
    let directory = tempfile::tempdir().expect("a temporary directory can be made");
    let all = all_threads();
    for (exponent, samples) in [(9, 2_500_000), (10, 25_000_000)] {
        let job = job(directory.path(), &format!("memory-1e{exponent}"), 20, samples);
        let (time, peak) = submit(directory.path(), &job, all);
        figure(&format!("peak memory of a run of 1e{exponent} samples (limit 64)"), peak, "MiB");
        figure(&format!("whole run of 1e{exponent} samples, all threads"), time, "s");
    }
}

fn start_up() {
    let directory = tempfile::tempdir().expect("a temporary directory can be made");
    let job = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../jobs/table3.toml");
    let all = all_threads();
    let times = (0..15).map(|_| submit(directory.path(), &job, all).0).collect();
    figure("start to result of jobs/table3.toml (limit 0.3)", median(times), "s");
}

/// Inputs as drawn by a run of Figure 14b, from all cells of its grid.
fn inputs(count: u64) -> Vec<RandomInputs> {
    let stream = DeviateStream { seed: 2018, common_random_numbers: false, dimensions: 2, points: Points::Random };
    let mut inputs = Vec::new();
    for index in 0..780 {
        let (preload, friction) = (0.01 + 0.01 * (index / 26) as f64, 0.25 + 0.01 * (index % 26) as f64);
        let pair = NormalPair { expected: [preload, friction], ..PAIR };
        let independent = Correlation::independent(2);
        let scatter = scatter(&pair, &independent);
        stream.for_each_chunk(index, 0, 0..count, |columns| {
            scatter.apply(columns);
            let pairs = columns[0].iter().zip(&columns[1]);
            inputs.extend(pairs.map(|(&preload, &static_friction)| RandomInputs { preload, static_friction }));
        });
    }
    inputs
}

fn brake() -> PadOnDisc {
    brake_at(SPEED)
}

fn brake_at(rotating_speed: f64) -> PadOnDisc {
    let mut parameters = Parameters::sui_ding_2018();
    parameters.operating_point.rotating_speed = rotating_speed;
    PadOnDisc::new(parameters).expect("the preset is valid")
}

/// Rates of simulating samples to their verdict, alternately by the scalar code and by lanes. The motions start from
/// rest, between critical speed and saddle-node, where linear stability decides the fewest samples. Steps are trial
/// steps: where friction is steep, several of them make up a step of the usual length.
fn lanes() {
    for (name, disc, count) in [("rigid", DiscModel::Rigid, 60), ("flexible", DiscModel::Flexible { modes: 5 }, 1)] {
        let settings = TimeDomainSettings { start: Start::Rest, ..Default::default() };
        let criterion = TimeDomain::new(&brake_at(22.0), &disc, settings).expect("the preset is valid");
        let mut inputs = inputs(count);
        let decided = criterion.decide_all(&inputs);
        let mut is_simulated = decided.iter().map(|decision| decision.time > 0.0);
        inputs.retain(|_| is_simulated.next() == Some(true));
        let steps = criterion.count_steps(&inputs) as f64;
        let sets = InstructionSet::available();
        let mut scalar_times = Vec::new();
        let mut set_times = vec![Vec::new(); sets.len()];
        for _ in 0..7 {
            scalar_times.push(seconds(|| {
                black_box(inputs.iter().map(|&inputs| criterion.decide(inputs)).collect::<Vec<_>>());
            }));
            for (set, times) in sets.iter().zip(&mut set_times) {
                times.push(seconds(|| {
                    black_box(criterion.decide_all_with(&inputs, *set));
                }));
            }
        }
        figure(
            &format!("{name} disc, samples simulated to their verdict, scalar"),
            inputs.len() as f64 / median(scalar_times.clone()),
            "samples/s",
        );
        figure(&format!("{name} disc, scalar steps (RK4)"), 1e-6 * steps / median(scalar_times.clone()), "M steps/s");
        let alone = kernel(name, &criterion, &sets);
        for ((set, times), alone) in sets.iter().zip(&set_times).zip(alone) {
            let ratios = scalar_times.iter().zip(times).map(|(scalar, lanes)| scalar / lanes).collect();
            let rate = steps / median(times.clone());
            figure(&format!("{name} disc, {set:?} lanes"), 1e-6 * rate, "M steps/s");
            figure(&format!("{name} disc, {set:?} lanes over scalar, to the verdict"), median(ratios), "times");
            figure(
                &format!("{name} disc, {set:?} lanes to the verdict over steps alone"),
                rate / alone,
                "of their rate",
            );
        }
    }
}

/// Rates of steps alone, without starting, deciding and ending samples: motions close to the limit cycle's edge that do
/// not end. Returns those of the lanes.
fn kernel(name: &str, criterion: &TimeDomain, sets: &[InstructionSet]) -> Vec<f64> {
    let inputs: Vec<RandomInputs> =
        (0..64).map(|i| RandomInputs { preload: 0.04 + 5e-4 * f64::from(i), static_friction: 0.3 }).collect();
    let steps = if name == "rigid" { 200_000 } else { 10_000 };
    let mut scalar = Vec::new();
    let mut lanes = vec![Vec::new(); sets.len()];
    for _ in 0..7 {
        scalar.push(seconds(|| criterion.take_steps(&inputs[..1], steps, None)));
        for (set, times) in sets.iter().zip(&mut lanes) {
            times.push(seconds(|| criterion.take_steps(&inputs, steps / 10, Some(*set))));
        }
    }
    let scalar_rate = |time: &f64| f64::from(steps) / time;
    figure(
        &format!("{name} disc, steps alone, scalar"),
        1e-6 * median(scalar.iter().map(scalar_rate).collect()),
        "M steps/s",
    );
    let mut alone = Vec::new();
    for (set, times) in sets.iter().zip(&lanes) {
        let rates: Vec<f64> = times.iter().map(|time| 64.0 * f64::from(steps / 10) / time).collect();
        let ratios = scalar.iter().zip(&rates).map(|(scalar, rate)| rate / scalar_rate(scalar)).collect();
        let rate = median(rates);
        figure(&format!("{name} disc, steps alone, {set:?} lanes"), 1e-6 * rate, "M steps/s");
        figure(&format!("{name} disc, steps alone, {set:?} lanes over scalar"), median(ratios), "times");
        alone.push(rate);
    }
    alone
}

/// The effect of the step size on verdicts and on the balance of energy.
fn convergence() {
    for (name, disc, count) in [("rigid", DiscModel::Rigid, 60), ("flexible", DiscModel::Flexible { modes: 5 }, 4)] {
        let criterion = |divisor: f64| {
            let criterion =
                TimeDomain::new(&brake(), &disc, TimeDomainSettings::default()).expect("the preset is valid");
            criterion.with_steps_divided_by(divisor)
        };
        let inputs = inputs(count);
        let verdicts = |divisor: f64| criterion(divisor).decide_all(&inputs);
        let converged: Vec<Decision> = verdicts(8.0);
        for divisor in [0.5, 1.0, 2.0] {
            let differing = verdicts(divisor).iter().zip(&converged).filter(|(a, b)| a.verdict != b.verdict).count();
            let label =
                format!("{name} disc, verdicts that differ, steps h/{divisor} against h/8, of {}", inputs.len());
            figure(&label, differing as f64, "samples");
        }
        for divisor in [0.5, 1.0, 2.0] {
            let label = format!("{name} disc, energy that 100 cycles of stick-slip lose to steps h/{divisor}");
            println!("{label:<58} {:>16.3e} of the work done", energy_defect(&disc, divisor));
        }
    }
}

/// The relative error of the balance of the pad's kinetic energy and the work of all tangential forces, over steps of
/// slip.
fn energy_defect(disc: &DiscModel, divisor: f64) -> f64 {
    let mut parameters = Parameters::sui_ding_2018();
    parameters.operating_point.rotating_speed = 10.0;
    let brake = PadOnDisc::new(parameters).expect("the preset is valid");
    let settings = TimeDomainSettings { start: Start::Rest, ..TimeDomainSettings::default() };
    let criterion =
        TimeDomain::new(&brake, disc, settings).expect("the preset is valid").with_steps_divided_by(divisor);
    let inputs = RandomInputs { preload: 0.1, static_friction: 0.39 };
    let trajectory = criterion.trajectory(inputs, 360.0).expect("the preset has an equilibrium");
    let (mass, length) = (brake.scaled_mass(), brake.scales().length);
    let stiffness = &brake.parameters().stiffness;
    let rigid = matches!(disc, DiscModel::Rigid);
    let power = |moment: &Moment| {
        let (x, u) = moment.tangential;
        let (sine, cosine) = if rigid { (0.0, 1.0) } else { moment.angle.0.sin_cos() };
        let spring =
            stiffness.contact_tangential_2 * x - brake.friction_transmission() * moment.friction_force / length;
        let force = stiffness.calliper_tangential * x
            + brake.scaled_tangential_damping() * u
            + moment.contact_force / length * sine
            + spring * cosine;
        -force * u / mass
    };
    let (mut defect, mut work) = (0.0, 0.0);
    for three in trajectory.moments.windows(3).step_by(2) {
        if three.iter().any(|moment| moment.sticks) {
            continue;
        }
        let [first, second, third] = [&three[0], &three[1], &three[2]].map(power);
        let done = trajectory.interval / 3.0 * (first + 4.0 * second + third);
        let gained = 0.5 * (three[2].tangential.1.powi(2) - three[0].tangential.1.powi(2));
        defect += gained - done;
        work += done.abs();
    }
    (defect / work).abs()
}

/// The whole run of `jobs/fig14b.toml`, with either disc.
fn figure_14b() {
    let directory = tempfile::tempdir().expect("a temporary directory can be made");
    let job = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../jobs/fig14b.toml");
    let text = fs::read_to_string(&job).expect("the job is there");
    let written = |name: &str, text: &str| {
        let path = directory.path().join(name);
        fs::write(&path, text).expect("the job file can be written");
        path
    };
    let rigid = written("rigid.toml", &text.replace("disc = \"flexible\"", "disc = \"rigid\""));
    by_threads("jobs/fig14b.toml, rigid disc", directory.path(), &rigid, 7.8e6, 3);
    let few = text.replace("samples = 10_000", "samples = 1000");
    assert_ne!(few, text);
    by_threads("jobs/fig14b.toml, flexible disc, 1000 a cell", directory.path(), &written("few.toml", &few), 7.8e5, 3);
    let all = all_threads();
    figure("jobs/fig14b.toml with the rigid disc (limit 60)", submit(directory.path(), &rigid, all).0, "s");
    figure("jobs/fig14b.toml with the flexible disc (limit 1200)", submit(directory.path(), &job, all).0, "s");
}
