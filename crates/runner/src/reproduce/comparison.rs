//! A Monte Carlo surface against the exact probabilities.

use stickslip_core::models::pad_on_disc::model::{PRELOAD, ROTATING_SPEED};
use stickslip_sampler::integrate::closed_form;
use stickslip_sampler::special_functions::{beta, normal};

use crate::commands::FinishedRun;
use crate::failure::Failure;
use crate::tables::row::SurfaceRow;
use crate::tables::surface::Surface;
use crate::units;

/// Unstable (or stable) samples that a cell must be expected to have before its deviation is called normal.
const ENOUGH: f64 = 10.0;

/// One cell with its exact probability.
pub struct ComparedRow {
    /// The cell as computed.
    pub row: SurfaceRow,
    /// Estimated probability.
    pub estimate: f64,
    /// Exact probability.
    pub exact: f64,
    /// Deviation of the estimate over its binomial standard error; `None` where the exact value leaves no error.
    pub z: Option<f64>,
}

impl ComparedRow {
    /// Samples expected on the rarer side.
    fn expected(&self) -> f64 {
        self.row.counts.decided() as f64 * self.exact.min(1.0 - self.exact)
    }

    /// Whether the deviation can be compared with the normal distribution.
    pub fn is_normal(&self) -> bool {
        self.expected() >= ENOUGH
    }

    /// Whether the estimate is within its binomial error of the exact value, for the largest of several cells at once:
    /// `limit` standard errors, and where samples on one side are rare, a count that chance exceeds no more often.
    pub fn agrees(&self, limit: f64) -> bool {
        if self.is_normal() {
            return self.z.is_some_and(|z| z.abs() <= limit);
        }
        let counts = &self.row.counts;
        let rare = if self.exact < 0.5 { counts.unstable } else { counts.stable };
        let (decided, p) = (counts.decided(), self.exact.min(1.0 - self.exact));
        let tail = beta::binomial_at_least(rare, decided, p).min(beta::binomial_at_most(rare, decided, p));
        decided > 0 && tail >= normal::upper_tail(limit)
    }
}

/// Every cell of a run with its exact probability.
pub fn compare(run: &FinishedRun) -> Result<Vec<ComparedRow>, Failure> {
    let grid = &run.job.grid;
    let pad = run.job.pad()?;
    let boundary =
        |brake: usize| pad.brake(&grid.first_cell_with(brake).expected).map(|brake| brake.stability_boundary());
    let boundaries: Result<Vec<_>, _> = (0..grid.configurations()).map(boundary).collect();
    let boundaries = boundaries.map_err(|error| Failure::Job(error.to_string()))?;
    let surface = Surface::new(&run.job, &run.tally);
    let compared = surface.rows().map(|row| {
        let boundary = &boundaries[grid.configuration_index(row.cell.index)];
        let exact = closed_form::probability(boundary, &run.job.normal_pair(&row.cell)).value;
        let estimate = row.estimate.probability.unwrap_or(f64::NAN);
        let error = (exact * (1.0 - exact) / row.counts.decided() as f64).sqrt();
        ComparedRow { row, estimate, exact, z: (error > 0.0).then(|| (estimate - exact) / error) }
    });
    Ok(compared.collect())
}

/// A sentence on how well all cells agree.
pub fn summary(run: &FinishedRun, rows: &[ComparedRow]) -> String {
    let what = if run.job.has_closed_form() {
        "the exact probabilities"
    } else {
        "the exact probabilities of linear stability on a rigid disc"
    };
    let normal: Vec<f64> = rows.iter().filter(|row| row.is_normal()).filter_map(|row| row.z).collect();
    let rare = rows.iter().filter(|row| !row.is_normal());
    let largest_rare = rare.clone().map(|row| (row.estimate - row.exact).abs()).fold(0.0, f64::max);
    let mut text = String::new();
    if !normal.is_empty() {
        let largest = normal.iter().map(|z| z.abs()).fold(0.0, f64::max);
        let mean_square = normal.iter().map(|z| z * z).sum::<f64>() / normal.len() as f64;
        text += &format!(
            "against {what}:\n    max |z| = {largest:.2}, mean z^2 = {mean_square:.3} over {} cells of {} samples\n",
            normal.len(),
            rows[0].row.counts.decided()
        );
    }
    let rare = rare.count();
    if rare > 0 {
        text += &format!(
            "in {rare} cells fewer than {ENOUGH} samples are expected on one side;\n\
             there max |p - exact| = {largest_rare:.5}\n"
        );
    }
    text + &in_si(run)
}

/// Speeds and preloads of a run in SI.
fn in_si(run: &FinishedRun) -> String {
    let grid = &run.job.grid;
    let Some(brake) = run.job.model.as_pad().and_then(|pad| pad.brake(&grid.cell(0).expected).ok()) else {
        return String::new();
    };
    let range = |values: &[f64], text: &dyn Fn(f64) -> String| match values {
        [only] => text(*only),
        [first, .., last] => format!("{} to {}", text(*first), text(*last)),
        [] => String::new(),
    };
    let scales = brake.scales();
    let (speeds, preloads) = (grid.values_of(ROTATING_SPEED), grid.values_of(PRELOAD));
    format!(
        "in SI: the disc passes the pad at {};\n    the preload is {}, {} of contact force\n",
        range(&speeds, &|value| units::speed(brake.speed_under_pad(value))),
        range(&preloads, &|value| units::length(scales.metres(value))),
        range(&preloads, &|value| units::force(brake.contact_force(value)))
    )
}
