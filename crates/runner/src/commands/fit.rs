//! `fit`: what tests of brakes say about preload and static friction.

use std::path::Path;

use serde_json::{Map, Value, json};
use stickslip_core::model::pair_boundary::PairBoundary;
use stickslip_core::models::pad_on_disc::model::{PRELOAD, PadModel, ROTATING_SPEED, STATIC_FRICTION};
use stickslip_sampler::fit::{ESTIMABLE, Fit, FitModel, FitValues, Goodness, Prediction, fit as estimate};
use stickslip_sampler::inputs::{Marginal, PairParameter};

use super::brake_tests::{BrakeTests, read_tests};
use super::fit_picture::{fit_picture, preloads};
use super::fitted_job::fitted_job;
use super::named_job::read_job;
use crate::cli::{EstimateArgument, FitArguments};
use crate::failure::Failure;
use crate::files::publish::publish_first;
use crate::job::{Job, JobSource, OutsidePhysics};
use crate::output::{note, output_file, quoted, result, shown, warn};
use crate::picture::view::rounded;
use crate::plot::drawing::{WIDTHS, write};

/// Most cells of which the probability is predicted: each takes some ten maximisations.
const MOST_CELLS: u64 = 1000;

/// Most rows of the table at the terminal.
const MOST_ROWS: usize = 40;

/// Tests that are as improbable as this contradict the model.
const CONTRADICTION: f64 = 0.01;

/// The probability of squeal in a cell.
struct PredictedCell {
    rotating_speed: f64,
    /// The nominal preload.
    preload: f64,
    prediction: Prediction,
}

impl From<EstimateArgument> for PairParameter {
    fn from(argument: EstimateArgument) -> Self {
        match argument {
            EstimateArgument::StaticFriction => Self::Expected(1),
            EstimateArgument::PreloadFactor => Self::Expected(0),
            EstimateArgument::PreloadStd => Self::RelativeStd(0),
            EstimateArgument::StaticFrictionStd => Self::RelativeStd(1),
            EstimateArgument::Correlation => Self::Correlation,
        }
    }
}

/// `stickslip fit`.
pub fn fit(arguments: &FitArguments) -> Result<(), Failure> {
    let out = arguments.out.as_deref().map(checked_out).transpose()?;
    let source = read_job(&arguments.job)?;
    let job = source.job()?;
    warn(job.warnings());
    let estimated: Vec<PairParameter> = arguments.estimate.iter().map(|&argument| argument.into()).collect();
    let pad = job.pad()?;
    let model =
        model(&job, &estimated).map_err(|message| Failure::Job(format!("{}: {message}", shown(&source.path))))?;
    let brake = pad.brake(&job.grid.cell(0).expected).map_err(|error| Failure::Job(error.to_string()))?;
    let tests = read_tests(&arguments.data, &brake)?;
    if let Some(plot) = &arguments.plot {
        output_file(plot)?;
        preloads(&tests).map_err(|message| Failure::Job(format!("{}: {message}", shown(&arguments.data))))?;
    }
    let confidence = job.sampling.confidence;
    let fit = estimate(&model, &tests.data, &estimated, confidence)
        .map_err(|error| Failure::Job(format!("{}: {error}", shown(&arguments.data))))?;
    warn(contradictions(&fit));
    let new_job = match &out {
        Some((directory, name)) => {
            let text = new_text(&job, &source, arguments, &tests, (&model, &fit))?;
            Some((directory, name, text))
        }
        None => None,
    };
    let cells = predictions(&job, pad, &fit)?;
    let drawing = match &arguments.plot {
        Some(file) => Some((fit_picture(&job, &tests, &fit, |speed| boundary(&job, pad, speed))?, file)),
        None => None,
    };
    if let Some((directory, name, text)) = new_job
        && !publish_first(directory, name, text.as_bytes())?
    {
        return Err(taken(&directory.join(name)));
    }
    if let Some((picture, file)) = drawing {
        write(&picture.figure(WIDTHS[1]), file)?;
    }
    if arguments.json {
        return result(&format!("{:#}\n", as_json(&job, arguments, &tests, (&model, &fit), &cells)));
    }
    result(&as_text(&job, arguments, &tests, (&model, &fit), &cells))
}

/// The folder and name of the new job, which replaces no file.
fn checked_out(out: &Path) -> Result<(std::path::PathBuf, String), Failure> {
    let place = output_file(out)?;
    if out.exists() { Err(taken(out)) } else { Ok(place) }
}

fn taken(out: &Path) -> Failure {
    Failure::CannotCreate(format!("{} exists already; name another file with --out", shown(out)))
}

/// What the job says of the inputs, if its brakes can be compared with tests.
fn model(job: &Job, estimated: &[PairParameter]) -> Result<FitModel, String> {
    if !job.has_closed_form() {
        return Err("fit needs the boundary of stability in closed form: criterion.kind = \"eigenvalue\"".to_owned());
    }
    if job.outside_physics != OutsidePhysics::Stable {
        return Err("fit needs criterion.outside_physics = \"stable\"".to_owned());
    }
    if let Some(other) = job.random.other() {
        return Err(format!(
            "random.inputs lists {}; fit knows preload and static_friction only, so remove it",
            job.quantity(other).name
        ));
    }
    let further = job.grid.axes.iter().filter(|axis| !job.quantity(axis.quantity).is_always_shown);
    if let Some(further) = further.into_iter().find(|axis| axis.axis.values().len() > 1) {
        let name = &job.quantity(further.quantity).name;
        return Err(format!("axes.{name} has several values; give the one of the brakes that were tested"));
    }
    if job.random.relative_stds.len() > 1 {
        return Err(
            "random.relative_std lists several values; give one, which stands where it is not estimated".to_owned()
        );
    }
    if job.random.absolute().next().is_some() {
        return Err(
            "fit estimates relative standard deviations; give random.relative_std in place of random.std".to_owned()
        );
    }
    let frictions = job.grid.values_of(STATIC_FRICTION);
    if frictions.len() > 1 && !estimated.contains(&PairParameter::Expected(1)) {
        return Err("axes.static_friction has several values; give the one of the brakes that were tested, or estimate static_friction".to_owned());
    }
    let pair = job.random.pair();
    let of = |position: Option<usize>| {
        let std = |position: usize| job.random.relative_stds.first().map_or(0.0, |stds| stds[position]);
        position.map_or((Marginal::Normal, 0.0), |position| (job.random.marginals[position].clone(), std(position)))
    };
    let [first, second] = pair.map(of);
    let values = FitValues {
        expected: [1.0, frictions[frictions.len() / 2]],
        relative_std: [first.1, second.1],
        correlation: job.random.pairs.first().map_or(0.0, |&(_, _, coefficient)| coefficient),
    };
    let names = [PRELOAD, STATIC_FRICTION].map(|place| job.quantity(place).name.to_string());
    let model = FitModel { names, marginals: [first.0, second.0], values };
    let needs = |parameter: PairParameter, input: usize| {
        let name = &model.names[input];
        let is_missing = estimated.contains(&parameter) && pair[input].is_none();
        is_missing.then(|| {
            format!("{} is to be estimated, but random.inputs does not list {name}; add it, with random.relative_std of about 0.1", model.name(parameter))
        })
    };
    let missing = needs(PairParameter::RelativeStd(0), 0)
        .or_else(|| needs(PairParameter::RelativeStd(1), 1))
        .or_else(|| needs(PairParameter::Correlation, 0))
        .or_else(|| needs(PairParameter::Correlation, 1));
    if let Some(message) = missing {
        return Err(message);
    }
    let stds = [0, 1].map(PairParameter::RelativeStd);
    if model.values.relative_std == [0.0; 2] && !stds.iter().any(|std| estimated.contains(std)) {
        return Err("nothing scatters, so that each verdict is certain; give random.inputs and random.relative_std, or estimate std.static_friction".to_owned());
    }
    Ok(model)
}

/// The job with the estimates, if it is one.
fn new_text(
    job: &Job,
    source: &JobSource,
    arguments: &FitArguments,
    tests: &BrakeTests,
    (model, fit): (&FitModel, &Fit<'_>),
) -> Result<String, Failure> {
    let origin = format!(
        "# Written by stickslip fit from the tests {:?} and the job {:?}.\n# {}. Estimates, with {} % intervals of the profile likelihood:\n",
        arguments.data.display().to_string(),
        source.path.display().to_string(),
        counted(tests),
        rounded(100.0 * job.sampling.confidence)
    );
    let text = fitted_job(job, model, fit, &origin)
        .ok_or_else(|| Failure::Internal("the job with the estimates is not representable".to_owned()))?;
    let path = arguments.out.clone().unwrap_or_default();
    let new = JobSource { path, text };
    new.job().map_err(|error| {
        Failure::Job(format!(
            "no job can have these estimates, so none is written; leave out --out to see them.\n{error}"
        ))
    })?;
    Ok(new.text)
}

/// What is to be said where the tests contradict the model.
fn contradictions(fit: &Fit<'_>) -> Vec<String> {
    let lines: Vec<String> =
        fit.worst().iter().map(|test| format!("line {} with p = {:.1e}", test.row, test.p_value)).collect();
    let worst = if lines.is_empty() { String::new() } else { format!(" (explained worst: {})", lines.join(", ")) };
    let contradicts = |goodness: &Goodness| goodness.p_value() < CONTRADICTION;
    let text = |goodness: Goodness| {
        format!(
            "the tests contradict the model (p = {:.1e}), so that estimates and intervals mean little; look for wrong lines{worst}, for brakes of another kind, and for values of the job that are not those of the tested brakes",
            goodness.p_value()
        )
    };
    fit.goodness().into_iter().filter(contradicts).map(text).collect()
}

/// How many tests there are.
fn counted(tests: &BrakeTests) -> String {
    let [squealed, quiet] = tests.data.counts();
    let plural = if squealed + quiet > 1.0 { "s" } else { "" };
    format!("{} test{plural}, {squealed} of which squealed", squealed + quiet)
}

/// The probability of squeal in each cell of the job, with its own preloads as nominal ones; none if there are too many.
fn predictions(job: &Job, pad: &PadModel, fit: &Fit<'_>) -> Result<Vec<PredictedCell>, Failure> {
    let (speeds, preloads) = (job.grid.values_of(ROTATING_SPEED), job.grid.values_of(PRELOAD));
    let cells = (speeds.len() * preloads.len()) as u64;
    if cells > MOST_CELLS {
        note(format_args!(
            "probabilities are predicted for {MOST_CELLS} cells at most, and the job has {cells}; give fewer speeds or preloads to see them"
        ));
        return Ok(Vec::new());
    }
    let mut predicted = Vec::new();
    for rotating_speed in speeds {
        let boundary = boundary(job, pad, rotating_speed)?;
        let cell =
            |&preload: &f64| PredictedCell { rotating_speed, preload, prediction: fit.predict(preload, &boundary) };
        predicted.extend(preloads.iter().map(cell));
    }
    Ok(predicted)
}

/// The boundary of stability at a speed.
fn boundary(job: &Job, pad: &PadModel, rotating_speed: f64) -> Result<PairBoundary, Failure> {
    let mut expected = job.grid.cell(0).expected;
    expected[ROTATING_SPEED] = rotating_speed;
    let brake = pad.brake(&expected).map_err(|error| Failure::Job(error.to_string()))?;
    Ok(brake.stability_boundary())
}

fn as_json(
    job: &Job,
    arguments: &FitArguments,
    tests: &BrakeTests,
    (model, fit): (&FitModel, &Fit<'_>),
    cells: &[PredictedCell],
) -> Value {
    let [squealed, quiet] = tests.data.counts();
    let estimate = |parameter: PairParameter| fit.parameters.iter().find(|fitted| fitted.parameter == parameter);
    let mut estimates = Map::new();
    let mut fixed = Map::new();
    for parameter in ESTIMABLE {
        match estimate(parameter) {
            Some(fitted) => estimates.insert(
                model.name(parameter),
                json!({ "value": fitted.value, "low": fitted.low, "high": fitted.high }),
            ),
            None => fixed.insert(model.name(parameter), json!(fit.values.get(parameter))),
        };
    }
    let cell = |cell: &PredictedCell| {
        json!({
            "rotating_speed_rad_s": cell.rotating_speed,
            "preload": cell.preload,
            "p_squeal": cell.prediction.probability,
            "p_low": cell.prediction.low,
            "p_high": cell.prediction.high,
        })
    };
    json!({
        "data": arguments.data.display().to_string(),
        "kind": if tests.has_onsets { "onset" } else { "verdict" },
        "tests": (squealed + quiet) as u64,
        "squealed": squealed as u64,
        "confidence": job.sampling.confidence,
        "log_likelihood": fit.log_likelihood,
        "goodness_of_fit": fit.goodness().into_iter().map(goodness).collect::<Vec<_>>(),
        "explained_worst": fit.worst().iter().map(|test| json!({ "line": test.row, "p_value": test.p_value })).collect::<Vec<_>>(),
        "estimates": estimates,
        "from_job": fixed,
        "cells": cells.iter().map(cell).collect::<Vec<_>>(),
        "job": arguments.out.as_ref().map(|out| out.display().to_string()),
        "plot": arguments.plot.as_ref().map(|plot| plot.display().to_string()),
    })
}

fn goodness(of: Goodness) -> Value {
    match of {
        Goodness::Verdicts { deviance, degrees, p_value } => {
            json!({ "deviance": deviance, "degrees_of_freedom": degrees, "p_value": p_value })
        }
        Goodness::Onsets { distance, p_value } => json!({ "kolmogorov_distance": distance, "p_value": p_value }),
    }
}

fn as_text(
    job: &Job,
    arguments: &FitArguments,
    tests: &BrakeTests,
    (model, fit): (&FitModel, &Fit<'_>),
    cells: &[PredictedCell],
) -> String {
    let percent = rounded(100.0 * job.sampling.confidence);
    let mut text = format!("{}: {}\n\n", shown(&arguments.data), counted(tests));
    text += &format!("{:<22}{:>12}   {percent} % interval\n", "parameter", "estimate");
    for parameter in ESTIMABLE {
        let value = format!("{:.4}", fit.values.get(parameter));
        let end = |end: Option<f64>| end.map_or("open".to_owned(), |end| format!("{end:.4}"));
        let interval = fit.parameters.iter().find(|fitted| fitted.parameter == parameter).map_or_else(
            || "as in the job".to_owned(),
            |fitted| format!("{} to {}", end(fitted.low), end(fitted.high)),
        );
        text += &format!("{:<22}{value:>12}   {interval}\n", model.name(parameter));
    }
    for goodness in fit.goodness() {
        let p = format!("{:.2}", goodness.p_value());
        text += &match goodness {
            Goodness::Verdicts { deviance, degrees, .. } => {
                let plural = if degrees == 1 { "" } else { "s" };
                format!("\ndeviance {deviance:.2} with {degrees} degree{plural} of freedom: p = {p}\n")
            }
            Goodness::Onsets { distance, .. } => {
                format!("\nlargest distance of the shares of onset speeds {distance:.3}: p = {p}\n")
            }
        };
    }
    if !cells.is_empty() {
        text += &format!("\n{:<22}{:>12}{:>12}   {percent} % interval\n", "speed, rad/s", "preload", "P(squeal)");
    }
    for PredictedCell { rotating_speed, preload, prediction } in cells.iter().take(MOST_ROWS) {
        text += &format!(
            "{:<22}{:>12}{:>12.4}   {:.4} to {:.4}\n",
            rounded(*rotating_speed),
            rounded(*preload),
            prediction.probability,
            prediction.low,
            prediction.high
        );
    }
    if cells.len() > MOST_ROWS {
        text += &format!("{} further cells: --json shows all\n", cells.len() - MOST_ROWS);
    }
    if let Some(plot) = &arguments.plot {
        text += &format!("\nDrew {}.\n", shown(plot));
    }
    if let Some(out) = &arguments.out {
        text += &format!("\nWrote {}. Next:\n  stickslip check {}\n", shown(out), quoted(out));
    }
    text
}
