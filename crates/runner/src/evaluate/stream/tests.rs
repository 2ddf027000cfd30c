use std::cell::Cell;
use std::path::PathBuf;

use super::*;
use crate::job::{Job, JobSource};

fn job(random: &str, criterion: &str, sampling: &str) -> Job {
    let text = format!(
        "name = \"stream\"\n[axes]\nrotating_speed = [15.0, 20.0]\npreload = [0.08, 0.12]\n\
         [random]\ninputs = [\"preload\", \"static_friction\"{random}]\nrelative_std = 0.3\n\
         [criterion]\nkind = \"time-domain\"\ndisc = \"rigid\"\nstart = \"rest\"\n{criterion}\n\
         [sampling]\nsamples = 300\nseed = 7\n{sampling}\n"
    );
    JobSource { path: PathBuf::from("job.toml"), text }.job().unwrap()
}

/// Units of several cells, one of which begins inside a block.
const UNITS: [(u64, Range<u64>); 4] = [(0, 0..300), (1, 120..300), (2, 0..1), (3, 0..300)];

/// What is handed over, with `control` asked at its turns.
fn emitted(evaluator: &Evaluator<'_>, control: impl Fn(u32) -> Control) -> Vec<FinishedUnit> {
    let (given, asked) = (Cell::new(0), Cell::new(0));
    let next = || {
        given.set(given.get() + 1);
        UNITS.get(given.get() - 1).cloned()
    };
    let mut units = Vec::new();
    let simulation = evaluator.job().model().simulation().unwrap();
    work(evaluator, simulation, &next, &mut |unit| units.push(unit), &|| {
        asked.set(asked.get() + 1);
        control(asked.get())
    });
    units.sort_by_key(|unit| (unit.part, unit.samples.start));
    units
}

/// Units of one part joined, if there is no gap between them.
fn joined(units: Vec<FinishedUnit>) -> Vec<FinishedUnit> {
    let mut joined: Vec<FinishedUnit> = Vec::new();
    for unit in units {
        match joined.last_mut() {
            Some(last) if last.part == unit.part => {
                assert_eq!(last.samples.end, unit.samples.start);
                last.append(&unit);
            }
            _ => joined.push(unit),
        }
    }
    joined
}

fn jobs() -> Vec<Job> {
    vec![
        job("", "", ""),
        job("", "record = [\"amplitude\"]", "derivatives = true"),
        job(", \"damping.tangential\", \"stiffness.contact_normal\"", "", "sensitivity = true"),
        job("", "outside_physics = \"failed\"", ""),
        job(", \"friction.kinetic_coefficient\"", "outside_physics = \"clamp\"", ""),
    ]
}

#[test]
fn a_stream_counts_what_each_unit_counts_by_itself() {
    for job in jobs() {
        let evaluator = Evaluator::new(&job).unwrap();
        let expected: Vec<FinishedUnit> =
            UNITS.into_iter().map(|(part, samples)| evaluator.count(part, samples, &|| false).unwrap()).collect();
        assert!(expected.iter().any(|unit| unit.counts.unstable > 0 && unit.counts.stable > 0));
        assert_eq!(emitted(&evaluator, |_| Control::Continue), expected);
        let flushed = emitted(&evaluator, |turn| if turn % 3 == 0 { Control::Flush } else { Control::Continue });
        assert_eq!(joined(flushed), expected);
    }
}

#[test]
fn a_stopped_stream_hands_over_the_first_samples_of_its_units() {
    for job in jobs() {
        let evaluator = Evaluator::new(&job).unwrap();
        for stop in [1, 2, 5, 9] {
            for unit in emitted(&evaluator, |turn| if turn < stop { Control::Continue } else { Control::Stop }) {
                let (_, whole) = UNITS.iter().find(|(part, _)| *part == unit.part).unwrap();
                assert_eq!(unit.samples.start, whole.start);
                assert_eq!(evaluator.count(unit.part, unit.samples.clone(), &|| false).unwrap(), unit);
            }
        }
    }
}
