//! From a job spec to a job: every value resolved and checked, with a complaint about each that is refused.

use std::ops::Range;
use std::path::Path;

use stickslip_core::model::quantity::{Quantity, Role};
use stickslip_sampler::grid::Grid;
use toml::Spanned;

use super::axes::{CheckedAxes, MOST_CELLS};
use super::diagnosis::{Complaint, Complaints};
use super::limit::requested;
use super::limit_request::LimitRequest;
use super::method::{Answer, Sampling};
use super::model::{Draft, OutsidePhysics, Parts};
use super::operating_point::operating_point;
use super::random::RandomInputSet;
use super::scatter::Names;
use super::spec::JobSpec;
use super::target_spec::TargetSpec;
use super::validated::{Job, MOST_MAPS};

/// Largest number of parts of cells that are counted apart.
const MOST_PARTS: u64 = 2_000_000;

/// The job of a spec and the draft of its model; `None` with at least one complaint if anything of it is refused. Files
/// that it names are sought in `folder`.
pub fn validate(spec: &JobSpec, mut draft: Box<dyn Draft>, folder: &Path, complaints: &mut Complaints) -> Option<Job> {
    let before = complaints.len();
    let name = validate_name(spec.name.as_ref(), complaints);
    let names = Names {
        quantities: draft.quantities(),
        unknown: &|name| draft.unknown_input(name),
        instead: &|name| draft.instead_of(name).map(|(_, remedy)| remedy),
    };
    let random = RandomInputSet::validate(&spec.random, names, folder, complaints);
    let parts = Parts { spec, random: random.as_ref() };
    draft.check_values(&spec.axes, folder, complaints);
    let mut grid = validate_grid(&mut *draft, parts, complaints);
    let quantities: Vec<Quantity> = draft.quantities().to_vec();
    if let (Some(random), Some(grid)) = (&random, &grid) {
        random.check_expected(&spec.random, &quantities, grid, |role| role != Role::Start, complaints);
    }
    let boundary = draft.boundary();
    let given_policy = draft.outside_physics().map(|policy| (policy.span(), *policy.get_ref()));
    let model = draft.finish(grid.as_ref(), parts, complaints);
    if let (Some(random), Some(grid), Some(model)) = (&random, &mut grid, &model) {
        for (expected, value) in grid.expected.iter_mut().zip(model.expected()) {
            *expected = value;
        }
        let quantities = model.model().quantities();
        random.check_expected(&spec.random, quantities, grid, |role| role == Role::Start, complaints);
    }
    let cells = grid.as_ref().and_then(Grid::checked_len);
    let others = random.as_ref().zip(model.as_deref());
    let sampling = Sampling::validate(&spec.sampling, others, boundary, cells, complaints);
    let outside_physics = complaints.take(validate_outside_physics(given_policy, sampling.as_ref()));
    LimitRequest::check_keys(spec.limit.as_ref(), complaints);
    let target = TargetSpec::checked(spec.target.as_ref(), complaints);
    if complaints.len() > before || complaints.has_unread(&[]) {
        return None;
    }
    let job = Job {
        name: name?,
        description: spec.description.clone().unwrap_or_default(),
        model: model?,
        grid: grid?,
        random: random?,
        outside_physics: outside_physics?,
        sampling: sampling?,
        limit: None,
        target,
        operating_point: None,
    };
    let fitting = fits_a_map(&job, spec).and_then(|()| fits_in_memory(&job));
    complaints.take(fitting)?;
    let limit = spec.limit.as_ref().map(|limit| requested(limit, &job)).transpose();
    let limit = complaints.take(limit)?.flatten();
    let operating_point = complaints.take(operating_point(spec.target.as_ref(), &job))?;
    Some(Job { limit, operating_point, ..job })
}

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
            "name = {text:?} cannot name a run directory: use 1 to 100 letters from A to Z, digits, '-', '_' and '.', not starting with '.', for example {:?}",
            plain_name(text)
        );
        complaints.push(Complaint::at(name.span(), message));
        return None;
    }
    Some(text.clone())
}

/// A name like another one that can name a run directory.
fn plain_name(text: &str) -> String {
    let plain = |c: char| match c {
        'ä' => "ae".to_owned(),
        'ö' => "oe".to_owned(),
        'ü' => "ue".to_owned(),
        'Ä' => "Ae".to_owned(),
        'Ö' => "Oe".to_owned(),
        'Ü' => "Ue".to_owned(),
        'ß' => "ss".to_owned(),
        'é' | 'è' | 'ê' => "e".to_owned(),
        'à' | 'á' | 'â' => "a".to_owned(),
        'ç' => "c".to_owned(),
        'ñ' => "n".to_owned(),
        c if c.is_ascii_alphanumeric() || "-_.".contains(c) => c.to_string(),
        _ => "-".to_owned(),
    };
    let name: String = text.chars().map(plain).collect();
    let name: String = name.trim_matches(['.', '-']).chars().take(100).collect();
    if name.is_empty() { "my-brake".to_owned() } else { name }
}

/// The grid of the axes.
fn validate_grid(draft: &mut dyn Draft, parts: Parts<'_>, complaints: &mut Complaints) -> Option<Grid> {
    let spec = parts.spec;
    let axes = CheckedAxes::new(&spec.axes, draft, complaints);
    if !axes.are_whole || !draft.settle(&axes.given, spec, complaints) {
        return None;
    }
    let grid = parts.random.map(|random| axes.grid(draft.quantities(), draft.expected(), random.relative_stds.len()));
    let cells = grid.as_ref().map(Grid::checked_len);
    match cells {
        Some(cells) if cells.is_none_or(|cells| cells > MOST_CELLS) => {
            let cells = cells.map_or("more than 2^64".to_owned(), |cells| cells.to_string());
            let message = format!("the axes make {cells} cells; the limit is {MOST_CELLS}");
            complaints.push(Complaint::maybe_at(None, message));
            draft.check_grid(None, parts, complaints);
            None
        }
        _ => draft.check_grid(grid.as_ref(), parts, complaints).then_some(grid)?,
    }
}

/// What happens to samples outside physics; an integral has none.
fn validate_outside_physics(
    given: Option<(Range<usize>, OutsidePhysics)>,
    sampling: Option<&Sampling>,
) -> Result<OutsidePhysics, Complaint> {
    let Some((span, policy)) = given else { return Ok(OutsidePhysics::default()) };
    let Some(method) = sampling.map(|sampling| sampling.method) else { return Ok(policy) };
    let is_integrated = matches!(method.answer(), Answer::Probability | Answer::Integral);
    if !is_integrated || policy == OutsidePhysics::Stable {
        return Ok(policy);
    }
    let message = format!(
        "criterion.outside_physics: {} draws no samples that could fail or be clamped; it takes what is outside physics for stable. Remove the key, or use method = \"monte-carlo\" or \"sobol\"",
        method.asked()
    );
    Err(Complaint::at(span, message))
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
    if let Some(name) = job.axes_of(Role::Start).next() {
        let message = format!(
            "a verdict map holds the verdicts of motions from one start; axes.{name} makes another start of each value. Use evaluate = \"each\""
        );
        return Err(Complaint::maybe_at(span(), message));
    }
    let maps = job.grid.configurations();
    if maps > MOST_MAPS {
        let names: Vec<&str> = job.axes_of(Role::Configuration).collect();
        let pair: Vec<&str> = job.axes_of(Role::Input).collect();
        let message = format!(
            "each combination of {} takes a verdict map of its own, and the axes make {maps} of them; the limit is {MOST_MAPS}. One map serves all values of {} and relative_std. Use fewer values, or evaluate = \"each\"",
            names.join(" and "),
            pair.join(", ")
        );
        return Err(Complaint::maybe_at(span(), message));
    }
    match job.model.map_refusal(&job.grid, &job.random) {
        Some(message) => Err(Complaint::maybe_at(span(), message)),
        None => Ok(()),
    }
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
