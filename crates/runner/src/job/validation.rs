//! From a job spec to a job: every value resolved and checked, with a complaint about each that is refused.

use std::path::Path;

use stickslip_core::parameters::Parameters;
use stickslip_sampler::grid::Grid;
use toml::Spanned;

use super::axes::{Brakes, CheckedAxes, MOST_CELLS, settle};
use super::criterion::Criterion;
use super::criterion_spec::{CriterionSpec, ModesSpec, OutsidePhysics};
use super::diagnosis::{Complaint, Complaints};
use super::engine::EngineSettings;
use super::friction::check_varied;
use super::limit::requested;
use super::limit_request::LimitRequest;
use super::model::{contradiction, validate_model};
use super::random::RandomInputSet;
use super::sampling::Sampling;
use super::sampling_spec::SamplingMethod;
use super::spec::JobSpec;
use super::start::StartSpecs;
use super::validated::{Job, MOST_MAPS};

/// Largest number of parts of cells that are counted apart.
const MOST_PARTS: u64 = 2_000_000;

/// The job of a spec; `None` with at least one complaint if anything of it is refused. Files that it names are sought
/// in `folder`.
pub fn validate(spec: &JobSpec, folder: &Path, complaints: &mut Complaints) -> Option<Job> {
    let before = complaints.len();
    let name = validate_name(spec.name.as_ref(), complaints);
    let random = RandomInputSet::validate(&spec.random, folder, complaints);
    let (parameters, grid) = validate_grid(spec, random.as_ref(), folder, complaints);
    if let Some(parameters) = &parameters {
        check_law_of_varied(spec, random.as_ref(), parameters, complaints);
    }
    let model = parameters.as_ref().zip(grid.as_ref());
    if let (Some(random), Some((parameters, grid))) = (&random, model) {
        random.check_expected(&spec.random, parameters, grid, complaints);
    }
    let criterion = match &spec.criterion {
        Some(criterion) => {
            let inputs = random.as_ref().map_or(&[][..], |random| &random.inputs);
            let specs = StartSpecs { criterion: criterion.get_ref(), axes: &spec.axes, random: &spec.random, inputs };
            Criterion::validate(criterion.span(), specs, model, complaints)
        }
        None => {
            complaints.push(Complaint::missing("criterion", None, NO_CRITERION));
            None
        }
    };
    if let (Some(random), Some(grid), Some(start)) =
        (&random, &grid, criterion.as_ref().and_then(Criterion::given_start))
    {
        random.check_start(&spec.random, grid, &start, complaints);
    }
    let kind = spec.criterion.as_ref().and_then(|criterion| criterion.get_ref().kind.as_ref());
    let kind = kind.map(|kind| *kind.get_ref());
    let cells = grid.as_ref().and_then(Grid::checked_len);
    let sampling = Sampling::validate(&spec.sampling, random.as_ref().zip(criterion.as_ref()), kind, cells, complaints);
    let criterion_spec = spec.criterion.as_ref().map(Spanned::get_ref);
    let outside_physics = complaints.take(validate_outside_physics(criterion_spec, sampling.as_ref()));
    let engine = EngineSettings::validate(&spec.engine, complaints);
    LimitRequest::check_keys(spec.limit.as_ref(), complaints);
    if complaints.len() > before || complaints.has_unread(&[]) {
        return None;
    }
    let disc_modes = spec.criterion.as_ref().and_then(|criterion| criterion.get_ref().disc_modes.as_ref());
    let job = Job {
        name: name?,
        description: spec.description.clone(),
        parameters: parameters?,
        grid: grid?,
        random: random?,
        criterion: criterion?,
        outside_physics: outside_physics?,
        sampling: sampling?,
        modes_are_given: disc_modes.is_some_and(|modes| matches!(modes.get_ref(), ModesSpec::Given(_))),
        limit: None,
        engine,
    };
    let fitting = fits_a_map(&job, spec).and_then(|()| fits_in_memory(&job));
    complaints.take(fitting)?;
    let limit = spec.limit.as_ref().map(|limit| requested(limit, &job)).transpose();
    let limit = complaints.take(limit)?.flatten();
    Some(Job { limit, ..job })
}

const NO_CRITERION: &str = "there is no [criterion]: what decides whether a sample is stable? For example\n\n  [criterion]\n  kind = \"eigenvalue\"        # or \"coupled-eigenvalue\" or \"time-domain\"";

fn validate_name(name: Option<&Spanned<String>>, complaints: &mut Complaints) -> Option<String> {
    let Some(name) = name else {
        let message =
            "missing key `name`: what is the run called? With name = \"my-brake\" its results go to runs/my-brake";
        complaints.push(Complaint::missing("name", None, message));
        return None;
    };
    let text = name.get_ref();
    let allowed = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
    if text.is_empty() || text.len() > 100 || text.starts_with('.') || !text.chars().all(allowed) {
        let message = format!(
            "name = {text:?} cannot name a run directory: use 1 to 100 letters, digits, '-', '_' and '.', not starting with '.'"
        );
        complaints.push(Complaint::at(name.span(), message));
        return None;
    }
    Some(text.clone())
}

/// The model, and the grid of the axes.
fn validate_grid(
    spec: &JobSpec,
    random: Option<&RandomInputSet>,
    folder: &Path,
    complaints: &mut Complaints,
) -> (Option<Parameters>, Option<Grid>) {
    let parameters = validate_model(&spec.model, &spec.axes, folder, complaints);
    let defaults = parameters.clone().unwrap_or_else(Parameters::sui_ding_2018);
    let CheckedAxes { rotating_speed, preload, static_friction, of_brake, of_start } =
        CheckedAxes::new(&spec.axes, &spec.model, &defaults, complaints);
    let (Some(mut parameters), Some(static_friction), Some(of_brake)) = (parameters, static_friction, of_brake) else {
        return (None, None);
    };
    // An axis replaces the model's own value, which therefore need not fit the other values.
    if spec.axes.of_parameter("friction.static_coefficient").is_some() {
        let [lowest, _] = static_friction.extremes();
        parameters.friction.static_coefficient = lowest;
    }
    if complaints.take(settle(&mut parameters, &of_brake).map_err(|error| contradiction(spec, &error))).is_none() {
        return (None, None);
    }
    let (Some(rotating_speed), Some(preload), Some(of_start), Some(random)) =
        (rotating_speed, preload, of_start, random)
    else {
        return (Some(parameters), None);
    };
    let grid = Grid { of_brake, of_start, rotating_speed, relative_std: random.axis(), preload, static_friction };
    match grid.checked_len() {
        Some(cells) if cells <= MOST_CELLS => {
            let made = Brakes { parameters: &parameters, grid: &grid }.are_computable();
            let made = complaints.take(made.map_err(|error| contradiction(spec, &error)));
            (Some(parameters), made.map(|()| grid))
        }
        cells => {
            let cells = cells.map_or("more than 2^64".to_owned(), |cells| cells.to_string());
            let message = format!("the axes make {cells} cells; the limit is {MOST_CELLS}");
            complaints.push(Complaint::maybe_at(None, message));
            (Some(parameters), None)
        }
    }
}

/// Refuses random inputs and axes of parameters that belong to another friction law.
fn check_law_of_varied(
    spec: &JobSpec,
    random: Option<&RandomInputSet>,
    parameters: &Parameters,
    complaints: &mut Complaints,
) {
    let friction = &parameters.friction;
    let span = spec.random.inputs.as_ref().map(Spanned::span);
    for name in random.into_iter().flat_map(|random| &random.inputs).map(|input| input.name()) {
        let checked = check_varied(&format!("random.inputs: {name}"), name, friction);
        complaints.take(checked.map_err(|message| Complaint::maybe_at(span.clone(), message)));
    }
    for entry in &spec.axes.0 {
        let name = entry.name.get_ref();
        let checked = check_varied(&format!("axes: {name}"), name, friction);
        complaints.take(checked.map_err(|message| Complaint::at(entry.name.span(), message)));
    }
}

/// What becomes of samples outside physics; an integral has none.
fn validate_outside_physics(
    spec: Option<&CriterionSpec>,
    sampling: Option<&Sampling>,
) -> Result<OutsidePhysics, Complaint> {
    let Some(policy) = spec.and_then(|spec| spec.outside_physics.as_ref()) else {
        return Ok(OutsidePhysics::default());
    };
    let method = match sampling.map(|sampling| sampling.method) {
        Some(SamplingMethod::Exact) => "exact",
        Some(SamplingMethod::Conditional) => "conditional",
        Some(
            SamplingMethod::MonteCarlo | SamplingMethod::Sobol | SamplingMethod::Importance | SamplingMethod::Subset,
        )
        | None => return Ok(*policy.get_ref()),
    };
    if *policy.get_ref() != OutsidePhysics::Stable {
        let message = format!(
            "criterion.outside_physics: method = \"{method}\" draws no preload and static friction that could fail or be clamped; it takes what is outside physics for stable. Remove the key, or use method = \"monte-carlo\" or \"sobol\""
        );
        return Err(Complaint::at(policy.span(), message));
    }
    Ok(*policy.get_ref())
}

/// Refuses a verdict map for a brake whose flutter it would not see.
fn fits_a_map(job: &Job, spec: &JobSpec) -> Result<(), Complaint> {
    if !job.uses_maps() {
        return Ok(());
    }
    let span = || {
        let evaluate = spec.sampling.evaluate.as_ref().map(Spanned::span);
        evaluate.or(spec.sampling.method.as_ref().map(Spanned::span))
    };
    if let Some(further) = job.grid.of_start.first() {
        let message = format!(
            "a verdict map holds the verdicts of motions from one start; axes.{} makes another start of each value. Use evaluate = \"each\"",
            further.name
        );
        return Err(Complaint::maybe_at(span(), message));
    }
    let maps = job.grid.brakes();
    if maps > MOST_MAPS {
        let names: Vec<&str> =
            job.grid.of_brake.iter().map(|further| &*further.name).chain(["rotating_speed"]).collect();
        let message = format!(
            "each combination of {} takes a verdict map of its own, and the axes make {maps} of them; the limit is {MOST_MAPS}. One map serves all values of preload, static_friction and relative_std. Use fewer values, or evaluate = \"each\"",
            names.join(" and ")
        );
        return Err(Complaint::maybe_at(span(), message));
    }
    let Some((speed, rate)) = job.criterion.growth_without_fall(&job.parameters, &job.grid) else { return Ok(()) };
    let message = format!(
        "a verdict map takes friction that rises with speed for stable, but at {speed} rad/s this brake is unstable although friction does not fall (growth rate {rate:+.2e}). Use evaluate = \"each\", which counts what feeds each unstable sample"
    );
    Err(Complaint::maybe_at(span(), message))
}

/// Refuses more sums than are to be held in memory.
fn fits_in_memory(job: &Job) -> Result<(), Complaint> {
    let (cells, parts) = (job.cells(), job.parts());
    let sums = cells.saturating_mul(parts);
    if sums <= MOST_PARTS {
        return Ok(());
    }
    let message = format!(
        "{cells} cells with {parts} parts each (randomisations, or looks of until) make {sums} sums to keep; the limit is {MOST_PARTS}: ask for fewer cells at a time, fewer randomisations, or a smaller at_most"
    );
    Err(Complaint::maybe_at(None, message))
}
