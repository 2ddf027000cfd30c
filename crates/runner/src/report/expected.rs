//! What the model with exactly the expected values of a cell does.

use serde_json::{Value, json};
use stickslip_core::model::behaviour::Behaviour;

use crate::job::Job;
use crate::picture::view::round;

/// Largest number of cells of which this is computed: some tenths of a second.
pub const MOST_CELLS: u64 = 2000;

/// The behaviour in all cells, column by column; null for a grid that is too large, or if it is not known.
pub fn expected_behaviours(job: &Job) -> Value {
    let Some(mut find) = job.model().behaviours().filter(|_| job.cells() <= MOST_CELLS) else { return Value::Null };
    let found: Vec<Option<Behaviour>> = (0..job.cells()).map(|index| find(&job.grid.cell(index).expected)).collect();
    let column = |value: fn(&Behaviour) -> Option<f64>| -> Vec<Option<f64>> {
        found.iter().map(|behaviour| behaviour.as_ref().and_then(value).map(round)).collect()
    };
    json!({
        "on": job.model().behaviours_on(),
        "growth_rate": column(|behaviour| behaviour.growth_rate),
        "amplitude_mm": column(|behaviour| Some(1e3 * behaviour.cycle?.amplitude)),
        "frequency_hz": column(|behaviour| Some(behaviour.cycle?.frequency)),
        "stick": column(|behaviour| Some(behaviour.cycle?.stick)),
    })
}
