//! The pad on the disc in job specs: parameters of the preset and overrides, the friction law, three criteria.

use std::path::Path;
use std::sync::Arc;

use stickslip_core::friction::measured_curve::SharedCurve;
use stickslip_core::model::Model;
use stickslip_core::model::quantity::Quantity;
use stickslip_core::models::pad_on_disc::criterion::validity::{self, Uncovered};
use stickslip_core::models::pad_on_disc::model::{
    Criterion, LinearRecord, PRELOAD, PadModel, ROTATING_SPEED, STATIC_FRICTION, quantities,
};
use stickslip_core::models::pad_on_disc::motion::start::GivenStart;
use stickslip_core::models::pad_on_disc::parameters::{EFFECTIVE_RADIUS_KEY, Friction, Parameters};
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;
use stickslip_core::models::pad_on_disc::rigid_disc::stability::SpeedRange;
use stickslip_sampler::grid::{Axis, Grid};
use toml::Spanned;

use self::corners::Corners;
use self::criterion_spec::{CriterionKind, CriterionSpec, ModesSpec};
use self::given_forces::GivenForces;
use self::measured_friction::UnstableSpeeds;
use self::preload_force::is_preload_force;
use self::start::StartSpecs;
use self::tables::PadTables;
use self::values::{contradiction, validate_model};
use crate::job::axes_spec::{AxesSpec, AxisEntry};
use crate::job::diagnosis::{Complaint, Complaints};
use crate::job::model::{Boundary, Draft, FrictionCurve, JobModel, Kind, OutsidePhysics, Parts, Tables};
use crate::job::random::RandomInputSet;
use crate::job::reading;
use crate::job::spec::JobSpec;
use crate::units::force;

pub mod preload_force;

pub mod criterion_spec;

pub mod keys;

pub mod overrides;

pub mod friction;

pub mod measured_friction;

mod tables;

mod given_forces;

pub mod plausibility;

mod values;

mod corners;

mod start;

mod criterion;

mod normalised;

/// The kind in job specs.
pub const KIND: Kind = Kind {
    name: "pad-on-disc",
    criteria: &["eigenvalue", "coupled-eigenvalue", "time-domain"],
    draft: |text, document, complaints| {
        let tables = reading::read::<PadTables>(text, document, keys::suggested, complaints)?;
        Some(Box::new(PadDraft::new(tables)))
    },
    schemas: [
        |generator| generator.subschema_for::<tables::ModelSpec>(),
        |generator| generator.subschema_for::<CriterionSpec>(),
    ],
    axes: keys::documented_axes,
};

/// The model while it is being checked.
struct PadDraft {
    tables: PadTables,
    quantities: Vec<Quantity>,
    /// `None` if a value was refused.
    parameters: Option<Parameters>,
}

impl PadDraft {
    fn new(tables: PadTables) -> Self {
        Self { tables, quantities: quantities(&GivenStart::default()), parameters: None }
    }

    fn criterion_spec(&self) -> Option<&CriterionSpec> {
        self.tables.criterion.as_ref().map(Spanned::get_ref)
    }

    fn kind(&self) -> Option<CriterionKind> {
        self.criterion_spec()?.kind.as_ref().map(|kind| *kind.get_ref())
    }

    /// Refuses to scatter an effective radius that is not given: about the edge of the disc, half of the samples would be
    /// beyond it.
    fn check_effective_radius(&self, parts: Parts<'_>, parameters: &Parameters, complaints: &mut Complaints) {
        let is_of_it = |input: &usize| self.quantities[*input].path == EFFECTIVE_RADIUS_KEY;
        let is_random = parts.random.is_some_and(|random| random.inputs.iter().any(is_of_it));
        if is_random && parameters.pad.effective_radius.is_none() {
            let message = format!(
                "random.inputs lists \"{EFFECTIVE_RADIUS_KEY}\", which has no expected value: give model.{EFFECTIVE_RADIUS_KEY}, between pad.inner_radius = {} and disc.outer_radius = {}",
                parameters.pad.inner_radius, parameters.disc.outer_radius
            );
            complaints.push(Complaint::maybe_at(parts.spec.random.inputs.as_ref().map(Spanned::span), message));
        }
    }

    fn defaults(&self) -> Parameters {
        self.parameters.clone().unwrap_or_else(Parameters::sui_ding_2018)
    }
}

impl Draft for PadDraft {
    fn quantities(&self) -> &[Quantity] {
        &self.quantities
    }

    fn boundary(&self) -> Option<Boundary> {
        let of = |kind| if kind == CriterionKind::Eigenvalue { Boundary::ClosedForm } else { Boundary::Verdicts };
        self.kind().map(of)
    }

    fn outside_physics(&self) -> Option<&Spanned<OutsidePhysics>> {
        self.criterion_spec()?.outside_physics.as_ref()
    }

    fn unknown_axis(&self, name: &str) -> String {
        keys::unknown_axis(name)
    }

    fn unknown_input(&self, name: &str) -> String {
        keys::unknown_input(name)
    }

    fn place_of_axis(&self, name: &str) -> Option<usize> {
        if is_preload_force(name) {
            return Some(PRELOAD);
        }
        self.quantities.iter().position(|quantity| quantity.name == name || quantity.path == name)
    }

    fn instead_of(&self, name: &str) -> Option<(&'static str, &'static str)> {
        is_preload_force(name).then_some(("preload", preload_force::AS_INPUT))
    }

    fn hint(&self, place: usize, value: f64) -> String {
        plausibility::hint(&self.quantities[place].path, value, &self.defaults())
    }

    fn check_values(&mut self, axes: &AxesSpec, folder: &Path, complaints: &mut Complaints) {
        self.parameters = validate_model(&self.tables.model, axes, folder, complaints);
    }

    fn expected(&self) -> Vec<f64> {
        PadModel::new(self.defaults(), Criterion::Eigenvalue { record: LinearRecord::default() }).expected()
    }

    fn converted(
        &self,
        place: usize,
        entry: Option<&AxisEntry>,
        axes: &[(usize, Axis)],
        spec: &AxesSpec,
    ) -> Option<Result<Axis, Complaint>> {
        let forces = GivenForces::find(place, entry, &self.tables.model)?;
        Some(forces.preloads(spec, axes, &self.quantities, &self.defaults()))
    }

    fn settle(&mut self, axes: &[(usize, Axis)], spec: &JobSpec, complaints: &mut Complaints) -> bool {
        let Some(parameters) = &mut self.parameters else { return false };
        // An axis replaces the model's own value, which therefore need not fit the other values.
        if let Some((_, axis)) = axes.iter().find(|(place, _)| *place == STATIC_FRICTION) {
            parameters.friction.static_coefficient = axis.extremes()[0];
        }
        let settled = values::settle(parameters, &self.quantities, axes);
        let settled = settled.map_err(|error| contradiction(&spec.axes, &self.tables.model, &error));
        complaints.take(settled).is_some()
    }

    fn check_grid(&self, grid: Option<&Grid>, parts: Parts<'_>, complaints: &mut Complaints) -> bool {
        let Some(parameters) = &self.parameters else { return false };
        let made = grid.is_none_or(|grid| {
            let made = Corners::new(parameters, grid).are_computable();
            let made = made.map_err(|error| contradiction(&parts.spec.axes, &self.tables.model, &error));
            complaints.take(made).is_some()
        });
        friction::check_law_of_varied(parts, &self.quantities, &parameters.friction, complaints);
        self.check_effective_radius(parts, parameters, complaints);
        made
    }

    fn finish(
        self: Box<Self>,
        grid: Option<&Grid>,
        parts: Parts<'_>,
        complaints: &mut Complaints,
    ) -> Option<Arc<dyn JobModel>> {
        let Some(criterion) = &self.tables.criterion else {
            complaints.push(Complaint::missing("criterion", None, NO_CRITERION));
            return None;
        };
        let inputs = parts.random.map_or(&[][..], |random| &random.inputs);
        let specs =
            StartSpecs { criterion: criterion.get_ref(), axes: &parts.spec.axes, random: &parts.spec.random, inputs };
        let model = self.parameters.as_ref().zip(grid);
        let criterion = criterion::validate(criterion.span(), specs, model, complaints)?;
        let modes = self.criterion_spec().and_then(|criterion| criterion.disc_modes.as_ref());
        let modes_are_given = modes.is_some_and(|modes| matches!(modes.get_ref(), ModesSpec::Given(_)));
        Some(Arc::new(PadJob { model: PadModel::new(self.parameters?, criterion), modes_are_given }))
    }
}

const NO_CRITERION: &str = "there is no [criterion]: what decides whether a sample is stable? For example\n\n  [criterion]\n  kind = \"eigenvalue\"        # or \"coupled-eigenvalue\" or \"time-domain\"";

/// The pad on the disc of a job.
#[derive(Debug, Clone)]
pub struct PadJob {
    /// The model, with its criterion.
    model: PadModel,
    /// Whether the spec itself says how many disc modes are kept.
    modes_are_given: bool,
}

impl PadJob {
    /// Where steady sliding is unstable with the values of the cell in the middle of a grid, if friction is measured.
    fn unstable_speeds(&self, grid: &Grid) -> Option<(&SharedCurve, UnstableSpeeds)> {
        let curve = self.model.parameters().friction.law.table()?;
        let cell = grid.cell(grid.middle()?);
        let brake = self.model.complete_brake(&cell.expected).ok()?;
        let (axis, unit, on) = ("rotating_speed", "rad/s", " on a rigid disc");
        Some((curve, UnstableSpeeds { axis, unit, on, cell: cell.index, ranges: brake.unstable_speeds() }))
    }

    /// The brakes at the extremes of the axes, each with the largest preload.
    fn extreme_brakes(&self, grid: &Grid) -> Vec<PadOnDisc> {
        let corners = Corners::new(self.model.parameters(), grid);
        let corners = corners.at_extremes(&corners.speeds().extremes()).unwrap_or_default();
        let [_, preload] = grid.extremes_of(PRELOAD);
        let brake = |corner: &Parameters, static_friction: f64| {
            let mut parameters = corner.clone();
            parameters.operating_point.preload = preload;
            parameters.friction.static_coefficient = static_friction;
            PadOnDisc::new(parameters).ok()
        };
        let of_corner = |corner: &Parameters| grid.extremes_of(STATIC_FRICTION).map(|value| brake(corner, value));
        corners.iter().flat_map(of_corner).flatten().collect()
    }

    /// What of the extremes of the axes lies outside the range over which verdicts in time were tested, each value
    /// once.
    fn uncovered(&self, grid: &Grid) -> Vec<Uncovered> {
        let Criterion::TimeDomain { disc, .. } = self.model.criterion() else { return Vec::new() };
        let mut found: Vec<Uncovered> = Vec::new();
        for uncovered in self.extreme_brakes(grid).iter().flat_map(|brake| validity::uncovered(brake, disc)) {
            if !found.contains(&uncovered) {
                found.push(uncovered);
            }
        }
        found
    }
}

impl JobModel for PadJob {
    fn model(&self) -> &dyn Model {
        &self.model
    }

    fn expected(&self) -> Vec<f64> {
        self.model.expected()
    }

    fn tables(&self, grid: &Grid) -> Tables {
        normalised::tables(&self.model, grid)
    }

    fn warnings(&self, grid: &Grid, random: &RandomInputSet) -> Vec<String> {
        let parameters = self.model.parameters();
        let quantities = self.model.quantities();
        let mut warnings = plausibility::of_job(parameters, quantities, grid);
        let curve = parameters.friction.law.table();
        warnings.extend(curve.and_then(|curve| measured_friction::vanishing(curve, quantities, grid, random)));
        warnings.extend(self.hidden_speeds(grid));
        let criterion = self.model.criterion();
        if criterion.modes().is_none() {
            warnings.extend(plausibility::of_rotation(self.extreme_brakes(grid).iter()));
        }
        if let Criterion::TimeDomain { settings, .. } = criterion {
            warnings.extend(plausibility::of_displacement("criterion.displacement", settings.displacement));
        }
        warnings.extend(criterion::doubts_about_modes(criterion, self.modes_are_given, parameters, grid));
        // The scatter of the inputs is not looked at.
        warnings.extend(self.uncovered(grid).iter().map(|uncovered| format!(
            "{uncovered}, the limit up to which verdicts in time were tested. They may be right beyond it; look at single samples with `stickslip trajectory`, and compare the run with one of a tenfold criterion.horizon (`stickslip compare`)"
        )));
        warnings
    }

    fn hidden_speeds(&self, grid: &Grid) -> Option<String> {
        let (curve, speeds) = self.unstable_speeds(grid)?;
        speeds.doubt(curve, grid.axis_of(ROTATING_SPEED)?.values())
    }

    fn no_limit_axis(&self, name: &str) -> Option<String> {
        name.ends_with(preload_force::NAME).then(|| {
            "limits are given as preloads; name the axis preload. Force and preload are proportional".to_owned()
        })
    }

    fn map_refusal(&self, grid: &Grid, random: &RandomInputSet) -> Option<String> {
        let [least, _] = grid.extremes_of(STATIC_FRICTION);
        let widest = random.position(STATIC_FRICTION).map_or(0.0, |input| {
            let stds = random.relative_stds.iter().map(|stds| random.relative(input, stds[input], least));
            stds.fold(0.0, f64::max)
        });
        let parameters = self.model.parameters();
        let (speed, rate) = criterion::growth_without_fall(self.model.criterion(), parameters, grid, widest)?;
        Some(format!(
            "a verdict map takes friction that rises with speed for stable, but at {speed} rad/s this brake is unstable although friction does not fall (growth rate {rate:+.2e}). Use evaluate = \"each\", which counts what feeds each unstable sample"
        ))
    }

    fn remarks(&self, grid: &Grid) -> String {
        let corners = Corners::new(self.model.parameters(), grid);
        // Contact forces, which say more than the preloads, grow with each value that they depend on.
        let Ok(brakes) = corners.at_extremes(&corners.speeds().extremes()[..1]) else { return String::new() };
        let forces = |preload: f64| {
            let brakes = brakes.iter().filter_map(|parameters| PadOnDisc::new(parameters.clone()).ok());
            brakes.map(move |brake| brake.contact_force(preload)).collect::<Vec<f64>>()
        };
        let [least, most] = grid.extremes_of(PRELOAD);
        let least = forces(least).into_iter().fold(f64::INFINITY, f64::min);
        let most = forces(most).into_iter().fold(0.0, f64::max);
        let range = if least < most { format!("{} to {}", force(least), force(most)) } else { force(most) };
        let of_curve = self.unstable_speeds(grid).map_or(String::new(), |(curve, speeds)| speeds.remarks(curve));
        format!("# expected contact force on a rigid disc: {range}\n{of_curve}")
    }

    fn friction_curve(&self, expected: &[f64]) -> Option<FrictionCurve> {
        let curve = *self.model.parameters().friction.law.table()?;
        let brake = self.model.complete_brake(expected).ok()?;
        let speeds = brake.unstable_speeds();
        let in_m_s = |range: &SpeedRange| [range.from, range.to].map(|speed| brake.speed_under_pad(speed));
        let Friction { static_coefficient, band, .. } = brake.parameters().friction;
        Some(FrictionCurve { curve, static_coefficient, band, unstable: speeds.iter().map(in_m_s).collect() })
    }

    fn as_pad(&self) -> Option<&PadModel> {
        Some(&self.model)
    }

    fn freeze(&self, document: &mut toml_edit::DocumentMut) -> String {
        friction::freeze(document, &self.model.parameters().friction.law)
    }
}
