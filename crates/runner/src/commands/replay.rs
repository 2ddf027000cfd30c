//! `replay`: one sample of a run again, with its motion.

use stickslip_core::criterion::time_domain::TimeDomain;
use stickslip_core::motion::start::Start;
use stickslip_core::verdict::Verdict;

use super::completion::evaluator_again;
use super::motion_report::{Facts, name, report};
use super::one_brake::LookedAt;
use super::trajectory::simulate;
use crate::cli::ReplayArguments;
use crate::evaluate::evaluator::{EvaluatedSample, Evaluator};
use crate::failure::Failure;
use crate::job::{Job, OutsidePhysics, RandomInput, StartValue};
use crate::output::result;
use crate::store::directory::RunDirectory;
use crate::store::tally::Tally;

/// `stickslip replay`.
pub fn replay(arguments: &ReplayArguments) -> Result<(), Failure> {
    let directory = RunDirectory::view(&arguments.run)?;
    let job = directory.job()?;
    let tally = directory.tally(&job)?;
    let evaluator = evaluator(&directory, &job, &tally, arguments)?;
    let Some(sample) = evaluator.sample(arguments.cell, arguments.sample) else {
        return Err(Failure::Usage(format!("--sample {}: there is no such sample", arguments.sample)));
    };
    let verdict = sample.decision.verdict;
    let (place, number) = evaluator.parts().locate(arguments.sample);
    let is_counted = tally.contains(evaluator.parts().of(arguments.cell).start + place as u64, number);
    let facts = facts(arguments, &job, &sample, is_counted);
    let LookedAt { disc, mut settings } = LookedAt::by(&job, &job.grid.cell(arguments.cell));
    settings.start = sample.start.unwrap_or(settings.start);
    let outside = match &sample.brake {
        None => Some("failed: one of its values is not admissible; there is no motion to simulate"),
        Some(_) if sample.is_outside_physics && verdict == Verdict::Failed => {
            Some("failed: no preload, or friction that rises with speed, and criterion.outside_physics = \"failed\"")
        }
        Some(pad) if pad.is_outside_physics(sample.inputs) && verdict == Verdict::Stable => {
            Some("stable by definition: no preload, or friction that rises with speed; there is no motion to simulate")
        }
        Some(_) => None,
    };
    let without_motion = |why: &str| {
        if arguments.out.is_some() {
            return Err(Failure::Usage(format!("--out: this sample is {why}")));
        }
        let why = if arguments.json { String::new() } else { format!("{why}\n") };
        result(&format!("{}{why}", facts.text(arguments.json)))
    };
    let (Some(pad), None) = (&sample.brake, outside) else { return without_motion(outside.unwrap_or_default()) };
    if let Err(error) = TimeDomain::new(pad, &disc, settings) {
        return without_motion(&format!("{}; its motion cannot be simulated: {error}", name(verdict)));
    }
    let trajectory = simulate(pad, &disc, settings, sample.inputs, arguments.horizon)?;
    report(facts, pad.scales(), &trajectory, arguments.out.as_deref(), arguments.json)
}

/// What the run drew and decided.
fn facts(arguments: &ReplayArguments, job: &Job, sample: &EvaluatedSample, is_counted: bool) -> Facts {
    let mut facts = Facts::default();
    facts.add("run", arguments.run.display().to_string());
    facts.add("cell", arguments.cell);
    facts.add("sample", arguments.sample);
    let mut rotating_speed = job.grid.cell(arguments.cell).rotating_speed;
    for (input, &value) in job.random.inputs.iter().zip(&sample.values) {
        if input.is_rotating_speed() {
            rotating_speed = value;
        }
    }
    facts.add_operating_point(rotating_speed, sample.drawn, sample.brake.as_ref());
    for (input, &value) in job.random.inputs.iter().zip(&sample.values) {
        if let RandomInput::Other(scalar) = input
            && !input.is_rotating_speed()
        {
            let unit = if scalar.unit == "1" { "" } else { scalar.unit };
            facts.add_with_unit(scalar.key, scalar.key, value, unit);
        }
    }
    if let Some(Start::Given(start)) = &sample.start {
        for number in StartValue::ALL {
            if let Some(value) = number.of(start) {
                let unit = number.unit(start.units);
                facts.add_with_unit(number.key(), number.key(), value, if unit == "1" { "" } else { unit });
            }
        }
    }
    if sample.is_outside_physics {
        let meaning = match job.outside_physics {
            OutsidePhysics::Stable => "decided as it is",
            OutsidePhysics::Failed => "counts as failed",
            OutsidePhysics::Clamp => "clamped to the border",
        };
        facts.add("outside_physics", meaning);
        if job.outside_physics == OutsidePhysics::Clamp {
            facts.add("preload_decided", sample.inputs.preload);
            facts.add("static_friction_decided", sample.inputs.static_friction);
        }
    }
    let verdict = sample.decision.verdict;
    let in_run = if is_counted { name(sample.looked_up.unwrap_or(verdict)) } else { "not counted yet" };
    facts.add("verdict_in_run", in_run);
    if let Some(looked_up) = sample.looked_up {
        facts.add("verdict_looked_up", name(looked_up));
        facts.add("verdict_simulated", name(verdict));
    }
    facts
}

/// What evaluates the samples of a run, if the wanted sample is one of them.
fn evaluator<'a>(
    directory: &RunDirectory,
    job: &'a Job,
    tally: &Tally,
    arguments: &ReplayArguments,
) -> Result<Evaluator<'a>, Failure> {
    let evaluator = evaluator_again(directory, job, tally, arguments.cell)?;
    // A cell that stopped by precision has fewer samples than the job allows.
    let samples = if job.stops_by_precision() {
        evaluator.parts().counts(tally, arguments.cell).total()
    } else {
        job.sampling.samples
    };
    if arguments.sample >= samples {
        let message = match samples {
            0 => format!("--sample {}: cell {} has no samples yet", arguments.sample, arguments.cell),
            _ => format!("--sample {}: cell {} has samples 0 to {}", arguments.sample, arguments.cell, samples - 1),
        };
        return Err(Failure::Usage(message));
    }
    Ok(evaluator)
}
