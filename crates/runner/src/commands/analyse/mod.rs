//! `analyse`: one parameter point.

mod without_friction;

mod point;

mod text;

mod oscillator;

mod nearest_change;

mod modes;

use std::path::Path;

use self::modes::ModesAtPoint;
use self::oscillator::Oscillator;
use self::point::Analysis;
use super::one_brake::{OneBrake, cell_of, changed_values, chosen_cell};
use crate::cli::AnalyseArguments;
use crate::failure::Failure;
use crate::job::plausibility;
use crate::output::{quoted, result, warn};

/// `stickslip analyse`.
pub fn analyse(arguments: &AnalyseArguments) -> Result<(), Failure> {
    let change = arguments.place.as_deref().filter(|place| !place.exists()).and_then(Path::to_str);
    if let Some(change) = change.filter(|change| change.contains('=')) {
        let remedy = format!("--set {}", quoted(Path::new(change)));
        let message = format!("{change}: there is no such job or run; to change a value, write {remedy}");
        return Err(Failure::Usage(message).remedied(remedy));
    }
    let chosen = match &arguments.place {
        Some(path) => Some(cell_of(path, arguments.brake.cell)?),
        None => chosen_cell(&arguments.brake)?,
    };
    if let Some((job, cell)) = &chosen
        && job.model.rigid_pad(&cell.expected).is_some()
    {
        let values = changed_values(job, &cell.expected, &arguments.brake.set)?;
        let pad = job.model.rigid_pad(&values).transpose().map_err(|error| Failure::Job(error.to_string()))?;
        warn(job.warnings());
        let Some(oscillator) = pad.as_ref().map(Oscillator::new) else {
            return Err(Failure::Internal("an oscillator is none with other values".to_owned()));
        };
        return result(&if arguments.json { format!("{:#}\n", oscillator.json()) } else { oscillator.text() });
    }
    if let Some((job, cell)) = &chosen
        && job.model.as_matrices().is_some()
    {
        let modes = ModesAtPoint::new(job, cell, &arguments.brake.set)?;
        return result(&if arguments.json { format!("{:#}\n", modes.json()) } else { modes.text() });
    }
    warn(chosen.as_ref().and_then(|(job, _)| job.model.hidden_speeds(&job.grid)));
    let OneBrake { brake, model } = OneBrake::in_cell(chosen, &arguments.brake.set)?;
    let analysis = Analysis::new(brake, model.and_then(|model| model.modes()));
    warn(analysis.coupled.iter().filter_map(|coupled| coupled.too_few).map(plausibility::of_modes));
    result(&if arguments.json { format!("{:#}\n", analysis.json()?) } else { analysis.text() })
}
