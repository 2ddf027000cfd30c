//! The measured friction curve of a job, and where steady sliding is unstable with the values of a cell.

use stickslip_core::friction::measured_curve::MeasuredCurve;
use stickslip_sampler::grid::Cell;

use super::common::place;
use crate::failure::Failure;
use crate::job::Job;
use crate::plot::friction::FrictionPlot;
use crate::units::significant;

/// Steps of the curve between two rows.
const STEPS: u32 = 12;

/// The picture of the curve; `None` of a job with another friction law.
pub fn friction(job: &Job, cell: &Cell) -> Option<FrictionPlot> {
    let measured = job.model.friction_curve(&cell.expected)?;
    let curve: &MeasuredCurve = &measured.curve;
    let scale = measured.static_coefficient / curve.at_rest();
    let coefficient = |speed: f64| scale * curve.coefficient(speed) + measured.band * curve.deviation(speed);
    let speeds = curve.speeds();
    let coefficients = curve.smoothing().map_or(curve.coefficients(), |smoothing| &smoothing.coefficients[..]);
    let between = |pair: &[f64]| {
        let (from, to) = (pair[0], pair[1]);
        (0..STEPS).map(move |step| from + (to - from) * f64::from(step) / f64::from(STEPS))
    };
    // Below its first row a curve is constant.
    let places = [0.0].into_iter().chain(speeds.windows(2).flat_map(between)).chain(speeds.last().copied());
    let mut notes = vec![place(job, cell.index)];
    notes.extend(curve.smoothing().map(|smoothing| {
        format!(
            "curve: a smoothing spline with {:.1} free parameters; the rows differ from it by {} (root mean square)",
            smoothing.parameters,
            significant(smoothing.residual)
        )
    }));
    Some(FrictionPlot {
        rows: speeds.iter().copied().zip(coefficients.iter().copied()).collect(),
        curve: places.map(|speed| (speed, coefficient(speed))).collect(),
        unstable: measured.unstable.clone(),
        title: "Measured friction".to_owned(),
        notes,
    })
}

/// The same, and otherwise why there is none.
///
/// # Errors
/// A job with another friction law.
pub fn wanted(job: &Job, cell: &Cell) -> Result<FrictionPlot, Failure> {
    friction(job, cell).ok_or_else(|| {
        Failure::Job(format!(
            "the job \"{}\" has no measured friction curve to draw; law = \"table\" in [model.friction], with table = \"FILE.csv\", gives it one",
            job.name
        ))
    })
}
