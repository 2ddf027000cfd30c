//! `replay`: one sample of a run again, with its motion.

use stickslip_core::model::quantity::Role;
use stickslip_core::model::verdict::Verdict;
use stickslip_core::models::pad_on_disc::criterion::time_domain::TimeDomain;
use stickslip_core::models::pad_on_disc::model::{PadModel, ROTATING_SPEED, inputs};
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;

use super::completion::evaluator_again;
use super::motion_report::{Facts, name, report};
use super::one_brake::LookedAt;
use super::trajectory::simulate;
use crate::cli::ReplayArguments;
use crate::evaluate::evaluator::{EvaluatedSample, Evaluator};
use crate::failure::Failure;
use crate::job::{Job, OutsidePhysics};
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
    let is_counted = tally.contains(evaluator.parts().in_cell(arguments.cell).start + place as u64, number);
    let pad = job.model.as_pad();
    let brake = pad.and_then(|pad| pad.brake(&sample.decided).ok());
    let facts = facts(arguments, &job, &sample, is_counted, brake.as_ref());
    let meaning = job.model().outside_meaning();
    let why_none = match (pad, &brake) {
        (None, _) => Some(format!("{}; motions of this model are not shown", name(verdict))),
        (_, None) => Some("failed: one of its values is not admissible; there is no motion to simulate".to_owned()),
        _ if sample.is_outside && verdict == Verdict::Failed => {
            Some(format!("failed: it lies outside the model ({meaning}), and criterion.outside_physics = \"failed\""))
        }
        (_, Some(brake)) if brake.is_outside_physics(inputs(&sample.decided)) && verdict == Verdict::Stable => {
            Some(format!("stable by definition: it lies outside the model ({meaning}); there is no motion to simulate"))
        }
        _ => None,
    };
    match (pad, &brake, why_none) {
        (Some(pad), Some(brake), None) => show_motion(arguments, facts, pad, brake, &sample),
        (_, _, why) => without_motion(arguments, &facts, &why.unwrap_or_default()),
    }
}

/// Shows the sample alone. Programs see that no file is named.
fn without_motion(arguments: &ReplayArguments, facts: &Facts, why: &str) -> Result<(), Failure> {
    if arguments.motion.out.is_some() && !arguments.motion.json {
        return Err(Failure::Usage(format!("--out: this sample is {why}")));
    }
    let why = if arguments.motion.json { String::new() } else { format!("{why}\n") };
    result(&format!("{}{why}", facts.text(arguments.motion.json)))
}

/// Simulates the motion of the sample again, and shows it.
fn show_motion(
    arguments: &ReplayArguments,
    facts: Facts,
    pad: &PadModel,
    brake: &PadOnDisc,
    sample: &EvaluatedSample,
) -> Result<(), Failure> {
    let LookedAt { disc, settings } = LookedAt::by(pad, &sample.decided);
    if let Err(error) = TimeDomain::new(brake, &disc, settings) {
        let verdict = name(sample.decision.verdict);
        return without_motion(arguments, &facts, &format!("{verdict}; its motion cannot be simulated: {error}"));
    }
    let trajectory = simulate(brake, &disc, settings, inputs(&sample.decided), arguments.motion.horizon)?;
    report(facts, brake.scales(), &trajectory, &arguments.motion)
}

/// What the run drew and decided.
fn facts(
    arguments: &ReplayArguments,
    job: &Job,
    sample: &EvaluatedSample,
    is_counted: bool,
    brake: Option<&PadOnDisc>,
) -> Facts {
    let mut facts = Facts::default();
    facts.add("run", arguments.run.display().to_string());
    facts.add("cell", arguments.cell);
    facts.add("sample", arguments.sample);
    let unit = |place: usize| match &*job.quantity(place).unit {
        "1" => String::new(),
        unit => unit.to_owned(),
    };
    let places = || 0..sample.drawn.len();
    if job.model.as_pad().is_some() {
        facts.add_operating_point(sample.drawn[ROTATING_SPEED], inputs(&sample.drawn), brake);
    } else {
        for place in places().filter(|&place| job.quantity(place).is_always_shown) {
            let quantity = job.quantity(place);
            facts.add_with_unit(&quantity.column, &quantity.label, sample.drawn[place], &unit(place));
        }
    }
    let random = job.random.inputs.iter().copied();
    let others = random.filter(|&place| {
        let quantity = job.quantity(place);
        quantity.role == Role::Configuration && !quantity.is_always_shown
    });
    // Without other inputs and axes of the start, all motions start alike.
    let has_own_start =
        job.random.other().is_some() || job.varying().iter().any(|&place| job.quantity(place).role == Role::Start);
    let start = places()
        .filter(|&place| has_own_start && job.quantity(place).role == Role::Start && !sample.drawn[place].is_nan());
    for place in others.chain(start) {
        let name = &job.quantity(place).name;
        facts.add_with_unit(name, name, sample.drawn[place], &unit(place));
    }
    if sample.is_outside {
        let meaning = match job.outside_physics {
            OutsidePhysics::Stable => "decided as it is",
            OutsidePhysics::Failed => "counts as failed",
            OutsidePhysics::Clamp => "clamped to the border",
        };
        facts.add("outside_physics", meaning);
        if job.outside_physics == OutsidePhysics::Clamp {
            for place in job.model().pair().into_iter().flatten() {
                facts.add(&format!("{}_decided", job.quantity(place).column), sample.decided[place]);
            }
        }
    }
    let verdict = sample.decision.verdict;
    // The motion of a pad shows its own.
    if job.model.as_pad().is_none() {
        for (result, value) in job.model().recorded().iter().zip(sample.decision.recorded) {
            let unit = if result.unit == "1" { "" } else { result.unit };
            value.into_iter().for_each(|value| facts.add_with_unit(result.name, result.noun, value, unit));
        }
    }
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
    let evaluator = evaluator_again(directory, job, arguments.cell)?;
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
