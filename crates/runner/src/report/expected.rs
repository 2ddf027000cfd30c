//! What the brake with exactly the expected values of a cell does.

use serde_json::{Value, json};
use stickslip_core::criterion::time_domain::DiscModel;
use stickslip_core::flexible_disc::brake::FlexibleBrake;
use stickslip_core::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};
use stickslip_sampler::grid::Cell;

use crate::job::{Criterion, Job};
use crate::picture::view::round;

/// Largest number of cells of which this is computed: some tenths of a second.
pub const MOST_CELLS: u64 = 2000;

/// A brake with the expected values of a cell, in SI units.
struct ExpectedBrake {
    /// Growth rate of steady sliding in 1/s, with the flexible disc if the job has one. None if it cannot be computed.
    growth_rate: Option<f64>,
    /// The stick-slip limit cycle on a rigid disc.
    cycle: Option<Cycle>,
}

/// A limit cycle: amplitude (half peak to peak) in mm, frequency in Hz, and the share of its period spent in stick.
struct Cycle {
    amplitude: f64,
    frequency: f64,
    stick: f64,
}

/// The expected brakes of all cells, column by column; null for a grid that is too large.
pub fn expected_brakes(job: &Job) -> Value {
    if job.cells() > MOST_CELLS {
        return Value::Null;
    }
    let modes = match &job.criterion {
        Criterion::CoupledEigenvalue { modes } | Criterion::TimeDomain { disc: DiscModel::Flexible { modes }, .. } => {
            Some(*modes)
        }
        _ => None,
    };
    // Neighbouring cells differ in preload and friction alone, which the modes of the disc do not depend on.
    let mut disc: Option<(Vec<f64>, Option<FlexibleBrake>)> = None;
    let brakes: Vec<Option<ExpectedBrake>> = (0..job.cells())
        .map(|index| {
            let cell = job.grid.cell(index);
            let brake = brake_of(job, &cell)?;
            let inputs = RandomInputs { preload: cell.preload, static_friction: cell.static_friction };
            let growth_rate = match modes {
                None => Some(brake.growth_rate()),
                Some(modes) => {
                    let mut place = job.grid.further_values(index);
                    place.push(cell.rotating_speed);
                    if disc.as_ref().is_none_or(|(known, _)| *known != place) {
                        disc = Some((place, FlexibleBrake::with_modes(brake.clone(), modes).ok()));
                    }
                    disc.as_ref().and_then(|(_, flexible)| flexible.as_ref()?.growth_rate(inputs).ok())
                }
            };
            let scales = brake.scales();
            let cycle = brake.limit_cycle().map(|cycle| Cycle {
                amplitude: scales.millimetres(0.5 * (cycle.tangential_max - cycle.tangential_min)),
                frequency: scales.hertz(1.0 / cycle.period),
                stick: cycle.stick_fraction,
            });
            Some(ExpectedBrake { growth_rate: growth_rate.map(|rate| scales.per_second(rate)), cycle })
        })
        .collect();
    let column = |value: fn(&ExpectedBrake) -> Option<f64>| -> Vec<Option<f64>> {
        brakes.iter().map(|brake| brake.as_ref().and_then(value).map(round)).collect()
    };
    json!({
        "flexible": modes.is_some(),
        "growth_rate": column(|brake| brake.growth_rate),
        "amplitude_mm": column(|brake| Some(brake.cycle.as_ref()?.amplitude)),
        "frequency_hz": column(|brake| Some(brake.cycle.as_ref()?.frequency)),
        "stick": column(|brake| Some(brake.cycle.as_ref()?.stick)),
    })
}

/// The brake of a cell, if there can be one with its values.
fn brake_of(job: &Job, cell: &Cell) -> Option<PadOnDisc> {
    let mut parameters = job.brakes().in_cell(cell).ok()?;
    parameters.operating_point.preload = cell.preload;
    parameters.friction.static_coefficient = cell.static_friction;
    PadOnDisc::new(parameters).ok()
}
