//! `make validity`: compares verdicts with references over the range of brakes, for the tables of
//! `stickslip_core::models::pad_on_disc::criterion::validity`. With a rigid disc, the references come from an independent program. With a
//! flexible one, they are longer motions of the same equations with finer steps.
//!
//! `VALIDITY_BRAKES=20` or `VALIDITY_BRAKES=100..120` selects random brakes with a flexible disc.

#![allow(
    clippy::expect_used,
    clippy::print_stdout,
    clippy::print_stderr,
    reason = "a sweep that cannot run should say so and stop"
)]

#[path = "validity/brakes.rs"]
mod brakes;
#[path = "../tests/data/fates.rs"]
mod fates;
#[path = "validity/reference.rs"]
mod reference;
#[path = "validity/table.rs"]
mod table;

use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::Instant;

use brakes::random_brake;
use fates::{FATES, FATES_AT_BOUNDARIES, cases};
use reference::Equilibrium;
use stickslip_core::model::verdict::Verdict;
use stickslip_core::models::pad_on_disc::criterion::settings::HORIZON;
use stickslip_core::models::pad_on_disc::criterion::settings::TimeDomainSettings;
use stickslip_core::models::pad_on_disc::criterion::time_domain::{DiscModel, TimeDomain};
use stickslip_core::models::pad_on_disc::motion::start::Start;
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};
use table::{Held, Place, print_cases, print_table};

/// Random brakes with a flexible disc, each with three starts.
const BRAKES: usize = 20;

const THREADS: usize = 2;

fn main() {
    // `cargo test --benches` passes --test; there is nothing to measure then.
    if std::env::args().any(|argument| argument == "--test") {
        return;
    }
    let rigid = rigid_disc();
    println!("Rigid disc: {} verdicts with a horizon of 1e5 against independent return maps\n", rigid.len());
    print_table(&rigid);
    let range = selected_brakes();
    let brakes = range.len();
    let flexible: Vec<Held> = in_parallel(range, flexible_disc).into_iter().flatten().collect();
    println!("\nFlexible disc: {brakes} brakes, verdicts with a horizon of {HORIZON} against longer motions\n");
    print_table(&flexible);
    println!("\nRigid disc, case by case:\n");
    print_cases(&rigid, &mut std::io::stdout());
    println!("\nFlexible disc, case by case:\n");
    print_cases(&flexible, &mut std::io::stdout());
}

/// The random brakes that VALIDITY_BRAKES selects.
fn selected_brakes() -> Range<usize> {
    let Ok(text) = std::env::var("VALIDITY_BRAKES") else { return 0..BRAKES };
    let number = |text: &str| text.parse::<usize>().expect("VALIDITY_BRAKES is COUNT or FROM..TO");
    text.split_once("..").map_or_else(|| 0..number(&text), |(from, to)| number(from)..number(to))
}

/// The results of `compute` for every index, in order.
fn in_parallel<T: Send>(range: Range<usize>, compute: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let next = AtomicUsize::new(range.start);
    let results = Mutex::new(Vec::new());
    thread::scope(|scope| {
        for _ in 0..THREADS {
            scope.spawn(|| {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    if index >= range.end {
                        break;
                    }
                    let result = compute(index);
                    results.lock().expect("no other thread has panicked").push((index, result));
                }
            });
        }
    });
    let mut results = results.into_inner().expect("no thread has panicked");
    results.sort_by_key(|&(index, _)| index);
    results.into_iter().map(|(_, result)| result).collect()
}

/// The verdicts on the fates of tests/data, with the steps in use and with steps half as long.
fn rigid_disc() -> Vec<Held> {
    let files = [("rigid-fates.csv", cases(FATES)), ("rigid-fates-more.csv", cases(FATES_AT_BOUNDARIES))];
    let all: Vec<_> = files.iter().flat_map(|(file, cases)| cases.iter().map(move |case| (file, case))).collect();
    in_parallel(0..all.len(), |index| {
        let (file, case) = all[index];
        let brake = PadOnDisc::new(case.parameters.clone()).expect("the file holds valid brakes");
        let [verdict, halved] = [1.0, 2.0].map(|divisor| case.decide(divisor).verdict);
        Held {
            place: Place::new(&brake, case.start),
            reference: case.fate,
            verdict,
            halved,
            contradicted: false,
            case: format!("{file}, line {}", case.line),
        }
    })
}

/// The verdicts on a random brake with a flexible disc, for each start.
fn flexible_disc(index: usize) -> Vec<Held> {
    let started = Instant::now();
    let (brake, modes) = random_brake(index);
    let parameters = brake.parameters();
    let inputs = RandomInputs {
        preload: parameters.operating_point.preload,
        static_friction: parameters.friction.static_coefficient,
    };
    let equilibrium = Equilibrium::new(&brake, modes, inputs);
    let held = |start: Start| {
        let settings = TimeDomainSettings { start, ..Default::default() };
        let criterion = TimeDomain::new(&brake, &DiscModel::Flexible { modes }, settings);
        let criterion = criterion.expect("a random brake has a model");
        let (reference, contradicted) = equilibrium.reference(&criterion, &settings);
        Held {
            place: Place::new(&brake, start),
            reference,
            verdict: criterion.decide(inputs).verdict,
            halved: criterion.with_steps_divided_by(2.0).decide(inputs).verdict,
            contradicted,
            case: format!("brake {index}: {}", brakes::description(&brake, modes, start)),
        }
    };
    let all = [Start::NearEquilibrium, Start::Rest, Start::LimitCycle].map(held);
    // Brakes take from a tenth of a second to a minute.
    eprintln!("brake {index}: {:.1} s", started.elapsed().as_secs_f64());
    print_cases(&all, &mut std::io::stderr());
    all.into()
}

/// Whether a verdict is stable or unstable.
fn is_decided(verdict: Verdict) -> bool {
    matches!(verdict, Verdict::Stable | Verdict::Unstable)
}
