//! The picture of a fit: shares of tests that squealed, and the probabilities with the estimates.

use stickslip_core::model::pair_boundary::PairBoundary;
use stickslip_core::models::pad_on_disc::model::ROTATING_SPEED;
use stickslip_sampler::fit::Fit;
use stickslip_sampler::fit::shares::{Verdicts, of_onsets, of_verdicts};

use super::brake_tests::{BrakeTests, Observed};
use crate::failure::Failure;
use crate::job::Job;
use crate::picture::scale::Scale;
use crate::picture::title::title;
use crate::picture::view::rounded;
use crate::plot::fit::{Family, FitPicture, MOST_FAMILIES, Tests};
use crate::plot::panel::Axis;

/// Points of a curve: each takes some ten maximisations.
const POINTS: u32 = 41;

/// Space beside the speeds of the tests, over their range or, of a single speed, over itself.
const SPACE: f64 = 0.1;

/// The nominal preloads of tests, ascending.
///
/// # Errors
/// That there are too many for a picture.
pub fn preloads(tests: &BrakeTests) -> Result<Vec<f64>, String> {
    let mut preloads: Vec<f64> = tests.observed.iter().map(|test| test.preload).collect();
    preloads.sort_by(f64::total_cmp);
    preloads.dedup();
    if preloads.len() > MOST_FAMILIES {
        return Err(format!(
            "the tests have {} different preloads, and a picture of the fit shows at most {MOST_FAMILIES}; leave out --plot, or plot a file with the tests at some of them",
            preloads.len()
        ));
    }
    Ok(preloads)
}

/// The picture, with the boundary of stability at each speed.
///
/// # Errors
/// A speed at which there is no boundary.
pub fn fit_picture(
    job: &Job,
    tests: &BrakeTests,
    fit: &Fit<'_>,
    boundary: impl Fn(f64) -> Result<PairBoundary, Failure>,
) -> Result<FitPicture, Failure> {
    let confidence = job.sampling.confidence;
    let speeds = || tests.observed.iter().map(|test| test.speed);
    let (least, greatest) = (speeds().fold(f64::INFINITY, f64::min), speeds().fold(0.0, f64::max));
    let space = SPACE * if greatest > least { greatest - least } else { greatest };
    // A curve of onset speeds ends where friction falls most steeply.
    let (from, to) = ((least - space).max(0.5 * least).max(tests.steepest.min(least)), greatest + space);
    let mut boundaries = Vec::new();
    for point in 0..POINTS {
        let speed = from + (to - from) * f64::from(point) / f64::from(POINTS - 1);
        boundaries.push((speed, boundary(speed)?));
    }
    let family = |preload: f64| {
        let own: Vec<&Observed> = tests.observed.iter().filter(|test| test.preload == preload).collect();
        let predicted = |(speed, boundary): &(f64, PairBoundary)| {
            let prediction = fit.predict(preload, boundary);
            (*speed, [prediction.probability, prediction.low, prediction.high])
        };
        let name = format!("nominal preload {}", rounded(preload));
        Family { name, curve: boundaries.iter().map(predicted).collect(), tests: shown(&own, tests, confidence) }
    };
    let percent = rounded(100.0 * confidence);
    let what = if tests.has_onsets {
        "steps: share of the brakes that began to squeal at this speed or above (Kaplan and Meier), ticks: tests that ended without squeal".to_owned()
    } else {
        format!("points: shares of the tests that squealed, with {percent} % intervals (Clopper and Pearson)")
    };
    let quantity = job.quantity(ROTATING_SPEED);
    Ok(FitPicture {
        families: preloads(tests).map_err(Failure::Job)?.into_iter().map(family).collect(),
        horizontal: Axis { scale: Scale::linear(from, to), title: title(quantity), unit: quantity.unit.to_string() },
        vertical: Axis {
            scale: Scale::linear(0.0, 1.0),
            title: "Probability of squeal".to_owned(),
            unit: String::new(),
        },
        notes: vec![what, format!("curves: the fit, with pointwise {percent} % intervals of the profile likelihood")],
    })
}

/// What tests at one preload show.
fn shown(own: &[&Observed], tests: &BrakeTests, confidence: f64) -> Tests {
    if tests.has_onsets {
        let all: Vec<(f64, bool)> = own.iter().map(|test| (test.speed, !test.squealed)).collect();
        let censored = own.iter().filter(|test| !test.squealed).map(|test| test.speed).collect();
        return Tests::Steps { steps: of_onsets(&all), censored };
    }
    let of = |test: &&Observed| {
        let squealed = if test.squealed { test.count } else { 0 };
        Verdicts { speed: test.speed, squealed, tests: test.count }
    };
    Tests::Shares(of_verdicts(&own.iter().map(of).collect::<Vec<_>>(), confidence))
}
