//! The criterion of a job: its settings, checked, and what decides samples by them.

use std::ops::Range;

use stickslip_core::models::pad_on_disc::criterion::settings::TimeDomainSettings;
use stickslip_core::models::pad_on_disc::criterion::time_domain::{DiscModel, TimeDomain, TimeDomainError};
use stickslip_core::models::pad_on_disc::flexible_disc::brake::DISC_MODES;
use stickslip_core::models::pad_on_disc::flexible_disc::brake::FlexibleBrake;
use stickslip_core::models::pad_on_disc::flexible_disc::error::FlexibleError;
use stickslip_core::models::pad_on_disc::flexible_disc::mode_count::ModeStudy;
use stickslip_core::models::pad_on_disc::flexible_disc::plate_modes::MOST_DISC_MODES;
use stickslip_core::models::pad_on_disc::model::{Criterion, LinearRecord, PRELOAD, STATIC_FRICTION};
use stickslip_core::models::pad_on_disc::motion::start::Start;
use stickslip_core::models::pad_on_disc::parameters::Parameters;
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};
use stickslip_sampler::grid::Grid;
use toml::Spanned;

use super::corners::Corners;
use super::criterion_spec::{CriterionKind, CriterionSpec, DiscKind, ModesSpec, Record};
use super::plausibility;
use super::start::StartSpecs;
use crate::job::diagnosis::{Complaint, Complaints};
use crate::job::models::record_spec::{self, linear_record};

/// Standard deviations by which the static friction coefficient is taken to scatter.
const REACH: f64 = 6.0;

/// Largest number of rotating speeds that are all looked at; of more, the extremes are.
const MOST_SPEEDS: usize = 1000;

/// Steps between constant friction and the friction that rises most, at which a brake is tried.
const RISING_FRICTIONS: i32 = 8;

/// Checks every key, and that the model has modes and an equilibrium where the job needs them. `None` if anything
/// is refused, or without a model.
pub fn validate(
    span: Range<usize>,
    specs: StartSpecs<'_>,
    model: Option<(&Parameters, &Grid)>,
    complaints: &mut Complaints,
) -> Option<Criterion> {
    let before = complaints.len();
    let spec = specs.criterion;
    let Some(kind) = spec.kind.as_ref().map(|kind| *kind.get_ref()) else {
        let message =
            "missing key `kind` in [criterion]: write kind = \"eigenvalue\", \"coupled-eigenvalue\" or \"time-domain\"";
        complaints.push(Complaint::missing("kind", Some(span), message));
        return None;
    };
    spec.refuse_foreign_keys(kind, complaints);
    let start = specs.checked(kind, complaints);
    let settings = TimeDomainSettings { start, ..spec.settings(complaints) };
    if complaints.len() > before || complaints.has_unread(&["criterion"]) {
        return None;
    }
    let (parameters, grid) = model?;
    let disc = spec.disc.as_ref().map_or(DiscKind::Flexible, |disc| *disc.get_ref());
    let modes = match spec.disc_modes.as_ref().map(Spanned::get_ref) {
        Some(ModesSpec::Given(modes)) => *modes,
        _ if kind == CriterionKind::Eigenvalue || disc == DiscKind::Rigid => DISC_MODES,
        // Without any preload every sample is stable by definition.
        _ if grid.values_of(PRELOAD).iter().all(|preload| *preload <= 0.0) => DISC_MODES,
        _ => match enough_modes(parameters, grid) {
            Ok(modes) => modes,
            Err(error) => {
                // A disc without modes or equilibrium is refused with any number, and for that reason.
                let with_any = criterion_of(kind, disc, DISC_MODES, settings, spec.linear_record());
                let complaint = check_model(&with_any, specs, parameters, grid).err().unwrap_or_else(|| {
                    let span = spec.disc_modes.as_ref().map(Spanned::span);
                    let message = format!(
                        "criterion.disc_modes = \"auto\": how many disc modes are enough could not be found, as {error}. Write a number, from 1 to {MOST_DISC_MODES}"
                    );
                    Complaint::maybe_at(span, message)
                });
                complaints.push(complaint);
                return None;
            }
        },
    };
    let criterion = criterion_of(kind, disc, modes, settings, spec.linear_record());
    complaints.take(check_model(&criterion, specs, parameters, grid)).map(|()| criterion)
}

fn criterion_of(
    kind: CriterionKind,
    disc: DiscKind,
    modes: usize,
    settings: TimeDomainSettings,
    record: LinearRecord,
) -> Criterion {
    let disc = match disc {
        DiscKind::Rigid => DiscModel::Rigid,
        DiscKind::Flexible => DiscModel::Flexible { modes },
    };
    match kind {
        CriterionKind::Eigenvalue => Criterion::Eigenvalue { record },
        CriterionKind::CoupledEigenvalue => Criterion::CoupledEigenvalue { modes, record },
        CriterionKind::TimeDomain => Criterion::TimeDomain { disc, settings },
    }
}

/// Builds the model at the extremes of the axes, and looks for its equilibrium at the largest inputs.
fn check_model(
    criterion: &Criterion,
    specs: StartSpecs<'_>,
    parameters: &Parameters,
    grid: &Grid,
) -> Result<(), Complaint> {
    if matches!(criterion, Criterion::Eigenvalue { .. }) {
        return Ok(());
    }
    let modes = criterion.modes();
    let largest = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
    let inputs = RandomInputs {
        preload: largest(&grid.values_of(PRELOAD)),
        static_friction: largest(&grid.values_of(STATIC_FRICTION)),
    };
    let preloads = grid.values_of(PRELOAD).into_iter().filter(|preload| *preload > 0.0);
    let smallest = RandomInputs { preload: preloads.fold(f64::INFINITY, f64::min), ..inputs };
    let extreme_inputs: &[RandomInputs] = if inputs.preload > 0.0 { &[smallest, inputs] } else { &[] };
    let check = |parameters: Parameters| -> Result<(), TimeDomainError> {
        let brake = PadOnDisc::new(parameters)?;
        if let Criterion::TimeDomain { disc, settings } = criterion {
            let criterion = TimeDomain::new(&brake, disc, *settings)?;
            if let Start::Given(start) = settings.start {
                for start in Corners::new(brake.parameters(), grid).extreme_starts(start) {
                    let criterion = criterion.with_start(Start::Given(start));
                    extreme_inputs.iter().try_for_each(|&inputs| criterion.check_start(inputs))?;
                }
            }
        }
        // Without any preload every sample is stable by definition.
        match modes {
            Some(modes) if inputs.preload > 0.0 => {
                FlexibleBrake::with_modes(brake, modes)?.sliding_equilibrium(inputs)?;
            }
            _ => {}
        }
        Ok(())
    };
    let mut speeds = Corners::new(parameters, grid).speeds().extremes().to_vec();
    speeds.dedup();
    let corners = Corners::new(parameters, grid).at_extremes(&speeds).map_err(TimeDomainError::from);
    let checked = corners.and_then(|corners| corners.into_iter().try_for_each(check));
    checked.map_err(|error| {
        let spec = specs.criterion;
        if let TimeDomainError::Start(error) = error {
            let of_axis = || specs.axis_of_start().map(|entry| entry.axis.span());
            let span = of_axis().or_else(|| spec.start.as_ref().map(Spanned::span));
            let message = format!(
                "criterion.start: {error}. Numbers of a start are in m, m/s and rad, unless units = \"scaled\", and displacements count from the pad without forces, unless from_equilibrium = true"
            );
            return Complaint::maybe_at(span, message);
        }
        let span = match error {
            TimeDomainError::Brake(FlexibleError::ModeCount { .. } | FlexibleError::TooFewModes { .. }) => {
                spec.disc_modes.as_ref().map(Spanned::span)
            }
            TimeDomainError::Settings(_) => spec.horizon.as_ref().map(Spanned::span),
            _ => None,
        };
        Complaint::maybe_at(span, format!("criterion: {error}"))
    })
}

/// A rotating speed of the axis and a growth rate at which pad and disc are unstable although friction does not
/// fall with speed, if there is one at the extremes of the further axes and at half the least or one and a half
/// times the largest preload: with constant friction, or with friction that rises as far as the scatter of the
/// static friction coefficient, `widest` of its relative standard deviations, reaches.
pub fn growth_without_fall(
    criterion: &Criterion,
    parameters: &Parameters,
    grid: &Grid,
    widest: f64,
) -> Option<(f64, f64)> {
    let modes = criterion.modes()?;
    let ends = |values: &[f64]| {
        let positive = || values.iter().copied().filter(|value| *value > 0.0);
        [positive().fold(f64::INFINITY, f64::min), positive().fold(0.0, f64::max)]
    };
    let [least_friction, _] = ends(&grid.values_of(STATIC_FRICTION));
    let speeds = match Corners::new(parameters, grid).speeds().values() {
        all if all.len() <= MOST_SPEEDS => all.to_vec(),
        _ => Corners::new(parameters, grid).speeds().extremes().to_vec(),
    };
    let brakes = Corners::new(parameters, grid).at_extremes(&speeds).ok()?;
    // All speeds of one disc follow each other: its modes, which take most of the time, are solved once.
    let discs = brakes.len() / speeds.len();
    let mut last: Option<FlexibleBrake> = None;
    for parameters in (0..discs).flat_map(|disc| brakes.iter().skip(disc).step_by(discs)).cloned() {
        let speed = parameters.operating_point.rotating_speed;
        let kinetic = parameters.friction.kinetic_coefficient;
        let lowest = (least_friction * (1.0 - REACH * widest)).max(0.0).min(kinetic);
        let frictions: Vec<f64> = (0..=RISING_FRICTIONS)
            .map(|i| kinetic - (kinetic - lowest) * f64::from(i) / f64::from(RISING_FRICTIONS))
            .collect();
        let pad = PadOnDisc::new(parameters).ok()?;
        let brake = match &last {
            Some(last) => last.with_brake(pad),
            None => FlexibleBrake::with_modes(pad, modes),
        };
        let brake = last.insert(brake.ok()?);
        let [least, largest] = ends(&grid.values_of(PRELOAD));
        for preload in [0.5 * least, 1.5 * largest] {
            for &static_friction in &frictions {
                match brake.growth_rate(RandomInputs { preload, static_friction }) {
                    Ok(rate) if rate > 0.0 => return Some((speed, rate)),
                    _ => {}
                }
            }
        }
    }
    None
}

/// What to say of a number of modes that is too few somewhere, or of which that could not be found out. `given` is a
/// number that stands in the job.
pub fn doubts_about_modes(criterion: &Criterion, given: bool, parameters: &Parameters, grid: &Grid) -> Option<String> {
    let modes = criterion.modes()?;
    // A smaller number that was chosen is enough.
    if !given && modes < MOST_DISC_MODES || grid.values_of(PRELOAD).iter().all(|preload| *preload <= 0.0) {
        return None;
    }
    let studies = match mode_studies(parameters, grid) {
        Ok(studies) => studies,
        Err(error) => return Some(format!("whether {modes} disc modes are enough could not be found, as {error}")),
    };
    let mut checks = studies.iter().filter_map(|study| study.check(modes).ok());
    let check = checks.find(|check| !check.is_enough)?;
    Some(if modes < MOST_DISC_MODES {
        format!("{check}; use disc_modes = \"auto\"")
    } else {
        plausibility::of_modes(check)
    })
}

/// The disc of a job at the extremes of its axes, at the corners of preloads and friction coefficients with some
/// room for their scatter.
fn mode_studies(parameters: &Parameters, grid: &Grid) -> Result<Vec<ModeStudy>, FlexibleError> {
    let ends = |values: &[f64]| {
        let positive = || values.iter().copied().filter(|value| *value > 0.0);
        [positive().fold(f64::INFINITY, f64::min), positive().fold(0.0, f64::max)]
    };
    let [least, largest] = ends(&grid.values_of(PRELOAD));
    let mut inputs = Vec::new();
    for preload in [0.5 * least, 1.5 * largest] {
        for static_friction in ends(&grid.values_of(STATIC_FRICTION)) {
            inputs.push(RandomInputs { preload, static_friction });
        }
    }
    let mut speeds = ends(Corners::new(parameters, grid).speeds().values()).to_vec();
    speeds.dedup();
    let study = |parameters: Parameters| ModeStudy::new(&PadOnDisc::new(parameters)?, &inputs);
    Corners::new(parameters, grid).at_extremes(&speeds)?.into_iter().map(study).collect()
}

/// The smallest number of disc modes that is enough for all of a job: a function of its parameters and axes alone.
fn enough_modes(parameters: &Parameters, grid: &Grid) -> Result<usize, FlexibleError> {
    let mut most = 1;
    for study in mode_studies(parameters, grid)? {
        most = most.max(study.smallest()?);
    }
    Ok(most)
}

impl CriterionSpec {
    /// Refuses keys that the kind of criterion has no use for.
    fn refuse_foreign_keys(&self, kind: CriterionKind, complaints: &mut Complaints) {
        let in_time = kind == CriterionKind::TimeDomain;
        let has_disc = kind != CriterionKind::Eigenvalue;
        let rigid = self.disc.as_ref().is_some_and(|disc| *disc.get_ref() == DiscKind::Rigid);
        let keys = [
            ("disc", self.disc.as_ref().map(Spanned::span), in_time),
            ("disc_modes", self.disc_modes.as_ref().map(Spanned::span), has_disc && !rigid),
            ("start", self.start.as_ref().map(Spanned::span), in_time),
            ("displacement", self.displacement.as_ref().map(Spanned::span), in_time),
            ("horizon", self.horizon.as_ref().map(Spanned::span), in_time),
            ("index", self.index.as_ref().map(Spanned::span), in_time),
        ];
        for (key, span, allowed) in keys {
            let (Some(span), false) = (span, allowed) else { continue };
            let message = match key {
                "disc_modes" if rigid && has_disc => {
                    "criterion.disc_modes has no meaning with disc = \"rigid\"; remove it".to_owned()
                }
                "disc_modes" => "criterion.disc_modes belongs to kind = \"time-domain\" or \"coupled-eigenvalue\"; remove it, or change the kind".to_owned(),
                _ => format!("criterion.{key} belongs to kind = \"time-domain\"; remove it, or change the kind"),
            };
            complaints.push(Complaint::at(span, message));
        }
        if let Some(record) = &self.record {
            let checked = record_spec::check(record.get_ref(), kind.recorded(), &kind);
            complaints.take(checked.map_err(|message| Complaint::at(record.span(), message)));
        }
    }

    /// What is recorded of samples that are decided by linear stability.
    fn linear_record(&self) -> LinearRecord {
        self.record.as_ref().map_or_else(LinearRecord::default, |record| linear_record(record.get_ref()))
    }

    /// The settings of the simulation in time; each value that is refused is complained about.
    fn settings(&self, complaints: &mut Complaints) -> TimeDomainSettings {
        let default = TimeDomainSettings::default();
        let mut settings = TimeDomainSettings {
            record_amplitude: self.record.as_ref().is_some_and(|record| record.get_ref().contains(&Record::Amplitude)),
            ..default
        };
        let mut check = |span: Range<usize>, change: &dyn Fn(&mut TimeDomainSettings)| {
            let mut alone = default;
            change(&mut alone);
            match alone.validate() {
                Ok(()) => change(&mut settings),
                Err(error) => {
                    // The setting has another name than its key in a job.
                    let message = format!("criterion.{error}").replace("amplitude_index", "index.amplitude");
                    complaints.push(Complaint::at(span, message));
                }
            }
        };
        if let Some(displacement) = &self.displacement {
            check(displacement.span(), &|settings| settings.displacement = *displacement.get_ref());
        }
        if let Some(horizon) = &self.horizon {
            check(horizon.span(), &|settings| settings.horizon = *horizon.get_ref());
        }
        if let Some(index) = &self.index {
            check(index.span(), &|settings| settings.amplitude_index = Some(index.get_ref().amplitude));
        }
        settings
    }
}
