//! The one brake of `analyse`, `trajectory` and `parameters`: the preset or a cell of a job, with changes.

use std::path::Path;

use stickslip_core::friction::law::LawKind;
use stickslip_core::model::quantity::{Quantity, Role};
use stickslip_core::models::matrices::model::BAND;
use stickslip_core::models::pad_on_disc::criterion::settings::TimeDomainSettings;
use stickslip_core::models::pad_on_disc::criterion::time_domain::DiscModel;
use stickslip_core::models::pad_on_disc::model::{Criterion, PadModel};
use stickslip_core::models::pad_on_disc::motion::start::Start;
use stickslip_core::models::pad_on_disc::parameters::{ParameterError, Parameters};
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;
use stickslip_sampler::grid::Cell;

use super::named_job::read_job;
use crate::cli::BrakeArguments;
use crate::failure::Failure;
use crate::job::friction::{LawSpec, SmoothingSpec, check_band, read_curve};
use crate::job::keys::nearest;
use crate::job::models::pad_on_disc::keys::parameter_of_axis;
use crate::job::models::pad_on_disc::preload_force::{self, PRELOAD};
use crate::job::{Job, plausibility, unknown_parameter};
use crate::output::{note, warn};
use crate::store::directory::RunDirectory;
use crate::units;

/// A brake at one operating point.
pub struct OneBrake {
    pub brake: PadOnDisc,
    /// What a job looks at, if the brake is one of a job.
    pub model: Option<LookedAt>,
}

/// What a job looks at.
pub struct LookedAt {
    pub disc: DiscModel,
    pub settings: TimeDomainSettings,
}

impl OneBrake {
    /// The brake that the command line names; warns of values that are not plausible.
    pub fn chosen(arguments: &BrakeArguments) -> Result<Self, Failure> {
        Self::in_cell(chosen_cell(arguments)?, &arguments.set)
    }

    /// The brake of a cell of a job, or else the preset, with changes; warns of values that are not plausible.
    pub fn in_cell(chosen: Option<(Job, Cell)>, changes: &[String]) -> Result<Self, Failure> {
        let Some((job, cell)) = chosen else {
            return Ok(Self { brake: changed_preset(changes)?, model: None });
        };
        let pad = job.pad()?;
        let brake = pad.complete_brake(&cell.expected).map_err(|error| Failure::Job(error.to_string()))?;
        let model = Some(LookedAt::by(pad, &cell.expected));
        Ok(Self { brake: changed(brake.parameters().clone(), changes)?, model })
    }
}

/// The job that the command line names, with the cell whose values are taken; `None` if it names none.
pub fn chosen_cell(arguments: &BrakeArguments) -> Result<Option<(Job, Cell)>, Failure> {
    arguments.job.as_deref().map(|path| cell_of(path, arguments.cell)).transpose()
}

/// The job in a file or of a run, with a cell of it, or the one that is [shown](shown_cell), with any band.
pub fn cell_of(path: &Path, cell: Option<u64>) -> Result<(Job, Cell), Failure> {
    let job = if path.is_dir() { RunDirectory::view(path)?.job()? } else { read_job(path)?.job()? };
    with_cell(job, cell)
}

/// A job with a cell of it, or the one that is [shown](shown_cell), with any band.
pub fn with_cell(job: Job, cell: Option<u64>) -> Result<(Job, Cell), Failure> {
    let last = job.cells() - 1;
    let index = match cell {
        Some(cell) if cell > last => {
            let message = format!("--cell {cell}: the job \"{}\" has cells 0 to {last}", job.name);
            return Err(Failure::Usage(message));
        }
        Some(cell) => cell,
        None => shown_cell(&job),
    };
    if cell.is_none() && last > 0 {
        note(format_args!(
            "cell {index} of 0 to {last} of the job \"{}\", {}; choose another with --cell",
            job.name,
            job.place_of_shown_cell()
        ));
    }
    let cell = job.grid.cell(index);
    Ok((job, cell))
}

impl LookedAt {
    /// The disc and the motion that decide samples with these values. A job that does not look at motions gets one of
    /// the model that it looks at.
    pub fn by(pad: &PadModel, values: &[f64]) -> Self {
        match pad.criterion() {
            Criterion::Eigenvalue { .. } => Self { disc: DiscModel::Rigid, settings: TimeDomainSettings::default() },
            Criterion::CoupledEigenvalue { modes, .. } => {
                Self { disc: DiscModel::Flexible { modes: *modes }, settings: TimeDomainSettings::default() }
            }
            Criterion::TimeDomain { disc, settings } => {
                let start = pad.given_start(values).map_or(settings.start, Start::Given);
                Self { disc: disc.clone(), settings: TimeDomainSettings { start, ..*settings } }
            }
        }
    }

    /// How many modes of the disc are kept, if there is one.
    pub fn modes(&self) -> Option<usize> {
        match self.disc {
            DiscModel::Rigid => None,
            DiscModel::Flexible { modes } => Some(modes),
        }
    }
}

/// The cell of a job that is shown if none is asked for: that of its operating point, or that in the middle of every axis, of
/// two the one before; on that of bands, which have no middle, the first.
pub fn shown_cell(job: &Job) -> u64 {
    let bands = job.grid.axes.iter().position(|axis| *job.quantity(axis.quantity).name == *BAND);
    let place = |(axis, length): (usize, &u64)| if Some(axis) == bands { 0 } else { (length - 1) / 2 };
    let lengths = job.grid.lengths();
    let middle = || lengths.iter().enumerate().fold(0, |index, (axis, length)| index * length + place((axis, length)));
    job.operating_point.unwrap_or_else(middle)
}

/// Values of all quantities of a job with `NAME=VALUE` changes, of a model whose quantities are its own.
///
/// # Errors
/// A name that no quantity has, and a value that is no number or out of range.
pub fn changed_values(job: &Job, values: &[f64], changes: &[String]) -> Result<Vec<f64>, Failure> {
    let mut values = values.to_vec();
    let mut changed: Vec<usize> = Vec::new();
    // The start of a motion changes nothing at a point, nor does what the model has no value of, as of another friction law.
    let is_taken = |place: &usize| job.quantity(*place).role != Role::Start && !values[*place].is_nan();
    let taken: Vec<usize> = (0..values.len()).filter(is_taken).collect();
    for change in changes {
        let refused = |message: String| Failure::Usage(format!("--set {change}: {message}"));
        let (name, value) =
            change.split_once('=').ok_or_else(|| refused("write NAME=VALUE, for example friction=0.45".to_owned()))?;
        let (name, value) = (name.trim(), value.trim());
        let place = taken.iter().copied().find(|place| job.quantity(*place).name == name).ok_or_else(|| {
            let names = taken.iter().map(|place| &*job.quantity(*place).name);
            let near = nearest(name, names.clone()).map_or(String::new(), |near| format!("; did you mean {near}?"));
            let names = names.collect::<Vec<_>>().join(", ");
            refused(format!("there is no parameter {name}{near} (there are {names})"))
        })?;
        if changed.contains(&place) {
            return Err(refused(format!("{name} is set a second time; leave one of the two out")));
        }
        changed.push(place);
        let number: f64 = value.parse().map_err(|_| refused(units::not_a_number(value)))?;
        let Quantity { name, limits, .. } = job.quantity(place);
        let is_whole = *name != *BAND || number.fract() == 0.0;
        if !(number.is_finite() && limits.contain(number) && is_whole) {
            let whole = if is_whole { "" } else { "a whole number, " };
            return Err(refused(format!("{number} is out of range: it must be {whole}{limits}")));
        }
        values[place] = number;
    }
    Ok(values)
}

/// The preset with `KEY=VALUE` changes; warns of values that are not plausible.
pub fn changed_preset(changes: &[String]) -> Result<PadOnDisc, Failure> {
    changed(Parameters::sui_ding_2018(), changes)
}

/// Parameters with `KEY=VALUE` changes; warns of values that are not plausible.
fn changed(mut parameters: Parameters, changes: &[String]) -> Result<PadOnDisc, Failure> {
    let mut changed: Vec<(&str, &str)> = Vec::new();
    let mut force = None;
    for change in changes {
        let refused = |message: String| Failure::Usage(format!("--set {change}: {message}"));
        let Some((key, value)) = change.split_once('=') else {
            return Err(refused("write KEY=VALUE, for example friction.static_coefficient=0.45".to_owned()));
        };
        let (key, value) = (key.trim(), value.trim());
        // A quantity that is an axis of a job has the name that it has there, too.
        let key = parameter_of_axis(key).unwrap_or(key);
        if let Some((_, before)) = changed.iter().find(|(other, _)| *other == key) {
            return Err(refused(format!("{key} is set a second time, after {key}={before}; leave one of the two out")));
        }
        changed.push((key, value));
        if ["friction.law", "friction.table", "friction.smoothing"].contains(&key) {
            continue;
        }
        let number: f64 = value.parse().map_err(|_| {
            let units = units::number_with_unit(value).map_or("", |_| "; `stickslip parameters` lists the units");
            refused(format!("{}{units}", units::not_a_number(value)))
        })?;
        if key == preload_force::KEY {
            force = Some((change, number));
            continue;
        }
        parameters.set(key, number).map_err(|error| match error {
            ParameterError::Unknown { .. } => refused(unknown_parameter(key, false)),
            other => refused(format!("{other}{}", plausibility::hint(key, number, &parameters))),
        })?;
    }
    use_law(&changed, &mut parameters)?;
    // It depends on the other values.
    if let Some((change, force)) = force {
        let refused = |message: String| Failure::Usage(format!("--set {change}: {message}"));
        if let Some((key, value)) = changed.iter().find(|(key, _)| *key == PRELOAD) {
            return Err(refused(format!("the preload is set too, {key}={value}; leave one of the two out")));
        }
        let preload = preload_force::preload(force, &parameters);
        parameters.operating_point.preload = preload.map_err(|message| refused(format!("it {message}")))?;
    }
    let brake = PadOnDisc::new(parameters).map_err(|error| Failure::Usage(format!("--set: {error}")))?;
    warn(plausibility::of_parameters(brake.parameters()));
    Ok(brake)
}

/// Applies `friction.law`, `friction.table` and `friction.smoothing` of the changes, and refuses values of other laws. A table changes the
/// static friction coefficient to its own unless that is set too.
fn use_law(changed: &[(&str, &str)], parameters: &mut Parameters) -> Result<(), Failure> {
    let value = |wanted: &str| changed.iter().find(|(key, _)| *key == wanted).map(|(_, value)| *value);
    let refused = |message: String| Failure::Usage(format!("--set: {message}"));
    let (law, file) = (value("friction.law"), value("friction.table"));
    let smoothing = value("friction.smoothing").map(SmoothingSpec::from_name).transpose().map_err(refused)?;
    let given = law.map(LawSpec::from_name).transpose().map_err(refused)?;
    let before = LawSpec::from(&parameters.friction.law);
    let law = given.unwrap_or(if file.is_some() { LawSpec::Table } else { before });
    let keys = changed.iter().filter_map(|(key, _)| Some((*key, key.strip_prefix("friction.")?)));
    if let Some(message) = keys.into_iter().find_map(|(key, name)| law.refusal(name, key)) {
        return Err(refused(message));
    }
    let friction = &mut parameters.friction;
    match (law, file) {
        (LawSpec::Stribeck, _) => friction.law = LawKind::Stribeck,
        (LawSpec::Rational, _) => friction.law = LawKind::Rational,
        (LawSpec::Table, None) if before == LawSpec::Table && smoothing.is_some() => {
            let message = "friction.smoothing smooths a curve that is read with it: --set friction.table=FILE; or give the job smoothing = \"spline\" in [model.friction]";
            return Err(refused(message.to_owned()));
        }
        (LawSpec::Table, None) if before == LawSpec::Table => {}
        (LawSpec::Table, None) => {
            return Err(refused("friction.law=table needs the measured curve: --set friction.table=FILE".to_owned()));
        }
        (LawSpec::Table, Some(file)) => {
            let set = value("friction.static_coefficient").map(|_| friction.static_coefficient);
            let curve = read_curve(Path::new(file), smoothing);
            let curve = curve.map_err(|error| refused(format!("friction.table: {error}")))?;
            friction.use_table(curve);
            friction.static_coefficient = set.unwrap_or(friction.static_coefficient);
        }
    }
    check_band(friction, false).map_err(refused)
}
