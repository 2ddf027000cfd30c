//! `analyse`: one parameter point.

mod point;

mod text;

use self::point::Analysis;
use super::one_brake::OneBrake;
use crate::cli::AnalyseArguments;
use crate::failure::Failure;
use crate::output::result;

/// `stickslip analyse`.
pub fn analyse(arguments: &AnalyseArguments) -> Result<(), Failure> {
    let OneBrake { brake, model } = OneBrake::chosen(&arguments.brake)?;
    let analysis = Analysis::new(brake, model.and_then(|model| model.modes()));
    result(&if arguments.json { format!("{:#}\n", analysis.json()?) } else { analysis.text() })
}
