//! `trajectory`: one motion in time.

use stickslip_core::models::pad_on_disc::criterion::settings::TimeDomainSettings;
use stickslip_core::models::pad_on_disc::criterion::time_domain::{DiscModel, TimeDomain, TimeDomainError};
use stickslip_core::models::pad_on_disc::finite_difference::brake::{
    Allotment, DiscGrid, FiniteDifferenceBrake, FiniteDifferenceError,
};
use stickslip_core::models::pad_on_disc::flexible_disc::error::FlexibleError;
use stickslip_core::models::pad_on_disc::flexible_disc::mode_count::{ModeStudy, representative_inputs};
use stickslip_core::models::pad_on_disc::flexible_disc::plate_modes::MOST_DISC_MODES;
use stickslip_core::models::pad_on_disc::motion::start::Start;
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};
use stickslip_core::models::pad_on_disc::trajectory::recording::Trajectory;

use super::motion_report::{Facts, report};
use super::one_brake::OneBrake;
use crate::cli::{AllotmentArgument, DiscArgument, StartArgument, TrajectoryArguments};
use crate::failure::Failure;
use crate::job::plausibility;
use crate::output::warn;

/// Scaled time that a trajectory covers by default: some 150 cycles of the pad.
const HORIZON: f64 = 500.0;

/// Largest number of moments; a trajectory is held in memory.
const MOST_MOMENTS: f64 = 5e6;

/// `stickslip trajectory`.
pub fn trajectory(arguments: &TrajectoryArguments) -> Result<(), Failure> {
    let OneBrake { brake: pad, model } = OneBrake::chosen(&arguments.brake)?;
    let of_job = model.as_ref().map(|model| model.settings).unwrap_or_default();
    let chosen_disc = arguments.disc.unwrap_or(match model.as_ref().map(|model| &model.disc) {
        Some(DiscModel::Rigid) => DiscArgument::Rigid,
        Some(DiscModel::Flexible { .. }) | None => DiscArgument::Flexible,
    });
    let start = arguments.start.clone().unwrap_or_else(|| StartArgument::from(of_job.start));
    let parameters = pad.parameters();
    let inputs = RandomInputs {
        preload: parameters.operating_point.preload,
        static_friction: parameters.friction.static_coefficient,
    };
    let settings = TimeDomainSettings {
        start: start.start,
        displacement: arguments.displacement.unwrap_or(of_job.displacement),
        ..of_job
    };
    if let (Start::Given(start), DiscArgument::Rigid) = (settings.start, chosen_disc)
        && (start.normal.is_some() || start.angle.is_some())
    {
        let message = "--start: normal and angle have no effect with --disc rigid; leave them out";
        return Err(Failure::Usage(message.to_owned()));
    }
    settings.validate().map_err(|error| Failure::Usage(format!("--{error}")))?;
    warn(plausibility::of_displacement("--displacement", settings.displacement));
    for (option, given, disc) in [
        ("--disc-modes", arguments.disc_modes.is_some(), DiscArgument::Flexible),
        ("--grid", arguments.grid.is_some(), DiscArgument::FiniteDifference),
        ("--allotment", arguments.allotment.is_some(), DiscArgument::FiniteDifference),
    ] {
        if given && chosen_disc != disc {
            return Err(Failure::Usage(format!("{option} belongs to --disc {}; leave it out", disc.name())));
        }
    }
    let simulated = match chosen_disc {
        DiscArgument::Rigid => simulate(&pad, &DiscModel::Rigid, settings, inputs, arguments.motion.horizon)?,
        DiscArgument::Flexible => {
            let refused = |error: FlexibleError| Failure::Usage(error.to_string());
            let study = ModeStudy::new(&pad, &representative_inputs(&pad));
            let of_job = model.and_then(|model| model.modes());
            let chosen = arguments.disc_modes.or(of_job);
            // Without modes or an equilibrium nothing is simulated below, with any number.
            let modes = match (&study, chosen) {
                (Ok(study), None) => study.smallest().map_err(refused)?,
                (Err(error), None) => return Err(refused(error.clone())),
                (_, Some(modes)) => modes,
            };
            let check = study.and_then(|study| study.check(modes)).ok();
            if let Some(check) = check.filter(|check| !check.is_enough)
                && (arguments.disc_modes.is_some() || of_job.is_none())
            {
                warn([if arguments.disc_modes.is_some_and(|modes| modes < MOST_DISC_MODES) {
                    format!("{check}; leave out --disc-modes")
                } else {
                    plausibility::of_modes(check)
                }]);
            }
            simulate(&pad, &DiscModel::Flexible { modes }, settings, inputs, arguments.motion.horizon)?
        }
        DiscArgument::FiniteDifference => {
            let refused = |error: FiniteDifferenceError| Failure::Usage(error.to_string());
            let allotment = match arguments.allotment {
                Some(AllotmentArgument::Nodal) => Allotment::Nodal,
                Some(AllotmentArgument::Linear) | None => Allotment::Linear,
            };
            let grid = arguments.grid.unwrap_or(DiscGrid { radial: 8, per_pad: 8 });
            let reference = FiniteDifferenceBrake::new(pad.clone(), grid).map_err(refused)?;
            let horizon = checked_horizon(arguments.motion.horizon, reference.step_length())?;
            reference.trajectory(inputs, settings.start, settings.displacement, horizon, allotment).map_err(refused)?
        }
    };
    let mut facts = Facts::default();
    facts.add("disc", chosen_disc.name());
    facts.add("start", start.text);
    facts.add_operating_point(parameters.operating_point.rotating_speed, inputs, Some(&pad));
    report(facts, pad.scales(), &simulated, &arguments.motion)
}

/// Simulates one motion.
pub fn simulate(
    pad: &PadOnDisc,
    disc: &DiscModel,
    settings: TimeDomainSettings,
    inputs: RandomInputs,
    horizon: Option<f64>,
) -> Result<Trajectory, Failure> {
    let refused = |error: TimeDomainError| Failure::Usage(error.to_string());
    let criterion = TimeDomain::new(pad, disc, settings).map_err(refused)?;
    criterion.check_start(inputs).map_err(refused)?;
    let horizon = checked_horizon(horizon, criterion.step_length())?;
    criterion.trajectory(inputs, horizon).map_err(refused)
}

/// The horizon of a trajectory, if it can be held in memory.
pub fn checked_horizon(horizon: Option<f64>, interval: f64) -> Result<f64, Failure> {
    let horizon = horizon.unwrap_or(HORIZON);
    let largest = (MOST_MOMENTS * interval).floor();
    if horizon > 0.0 && horizon <= largest {
        return Ok(horizon);
    }
    let message = format!(
        "--horizon {horizon} is out of range: it must be greater than 0 and at most {largest} (scaled time; {MOST_MOMENTS} moments)"
    );
    Err(Failure::Usage(message))
}
