//! The friction oscillator on a belt in job specs.

use std::path::Path;
use std::sync::Arc;

use schemars::{JsonSchema, Schema};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use stickslip_core::friction::law::LawKind;
use stickslip_core::friction::measured_curve::SharedCurve;
use stickslip_core::model::Model;
use stickslip_core::model::quantity::{Quantity, Role};
use stickslip_core::models::belt_oscillator::{BeltCriterion, BeltOscillator, Oscillator, quantities};
use stickslip_core::models::pad_on_disc::criterion::settings::TimeDomainSettings;
use stickslip_core::models::pad_on_disc::model::{Criterion, LinearResult};
use stickslip_core::models::pad_on_disc::motion::start::{GivenStart, Start};
use stickslip_core::models::pad_on_disc::parameters::{Friction, ParameterError, Parameters};
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;
use stickslip_sampler::grid::{Axis, Grid};
use toml::Spanned;
use toml_edit::DocumentMut;

use super::pad_on_disc::friction::{self, FrictionSpec, LawSpec, use_law};
use super::pad_on_disc::measured_friction::{self, UnstableSpeeds};
use super::pad_on_disc::overrides::number_within;
use super::record_spec::{self, RecordedName, linear_record, names_of};
use super::start_spec::{StartNumbers, StartSpec};
use crate::job::axes_spec::AxesSpec;
use crate::job::diagnosis::{Complaint, Complaints};
use crate::job::model::{
    Boundary, Draft, FrictionCurve, JobModel, Kind, OutsidePhysics, Parts, Tables, configurable, table_of, written,
};
use crate::job::random::RandomInputSet;
use crate::job::reading;
use crate::job::spec::JobSpec;

/// The kind in job specs.
pub const KIND: Kind = Kind {
    name: "belt-oscillator",
    criteria: &["eigenvalue", "time-domain"],
    draft: |text, document, complaints| {
        let tables = reading::read::<BeltTables>(text, document, |_, _| None, complaints)?;
        Some(Box::new(BeltDraft::new(tables)))
    },
    schemas: [
        |generator| generator.subschema_for::<BeltModelSpec>(),
        |generator| generator.subschema_for::<BeltCriterionSpec>(),
    ],
    axes: || {
        let described = |quantity: Quantity| {
            let text = format!("Expected {} of an oscillator on a belt, unit {}", quantity.description, quantity.unit);
            (quantity.name.to_string(), text)
        };
        quantities().into_iter().map(described).collect()
    },
};

/// The tables `[model]` and `[criterion]`.
#[derive(Debug, Deserialize)]
struct BeltTables {
    #[serde(default)]
    model: BeltModelSpec,
    criterion: Option<Spanned<BeltCriterionSpec>>,
}

/// The friction oscillator on a belt, m x'' + c x' + k x = N mu(V - x'): `kind = "belt-oscillator"`.
#[derive(Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(transform = describe)]
struct BeltModelSpec {
    #[schemars(with = "Option<f64>")]
    mass: Option<Spanned<f64>>,
    #[schemars(with = "Option<f64>")]
    stiffness: Option<Spanned<f64>>,
    #[schemars(with = "Option<f64>")]
    damping: Option<Spanned<f64>>,
    #[schemars(with = "Option<f64>")]
    normal_force: Option<Spanned<f64>>,
    #[schemars(with = "Option<f64>")]
    belt_speed: Option<Spanned<f64>>,
    /// The friction law and its values, as for the pad on the disc.
    #[serde(default)]
    #[schemars(extend("default" = {}))]
    friction: FrictionSpec,
}

/// Puts what the core knows of the values into the JSON schema.
fn describe(schema: &mut Schema) {
    let Some(properties) = schema.get_mut("properties").and_then(Value::as_object_mut) else { return };
    for quantity in quantities() {
        let description = format!("{} ({}), unit {}", quantity.description, quantity.symbol, quantity.unit);
        if let Some(value) = properties.get_mut(&*quantity.path) {
            *value = number_within(quantity.limits, &description);
        }
    }
}

impl BeltModelSpec {
    /// The values beside friction, by name.
    fn values(&self) -> [(&'static str, &Option<Spanned<f64>>); 5] {
        [
            ("mass", &self.mass),
            ("stiffness", &self.stiffness),
            ("damping", &self.damping),
            ("normal_force", &self.normal_force),
            ("belt_speed", &self.belt_speed),
        ]
    }
}

/// What decides whether a sample of an oscillator on a belt is stable. All keys but `kind` and `outside_physics` belong to
/// the simulation in time.
#[derive(Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct BeltCriterionSpec {
    /// How a sample is decided.
    #[schemars(with = "BeltKind")]
    kind: Option<Spanned<BeltKind>>,
    /// Where a motion starts, by name or in numbers. With `"time-domain"`.
    #[schemars(with = "Option<StartSpec<GivenBeltStart>>", extend("default" = "near-equilibrium"))]
    start: Option<Spanned<StartSpec<GivenBeltStart>>>,
    /// Displacement of a start near the equilibrium, over the equilibrium's own; with other starts the distance within
    /// which a shrinking motion counts as stable. With `"time-domain"`.
    #[schemars(with = "Option<f64>", extend("default" = 0.01, "exclusiveMinimum" = 0, "maximum" = 1000))]
    displacement: Option<Spanned<f64>>,
    /// Time after which a sample is undecided, s; by default at most 5e6 radians of the fastest oscillator. With
    /// `"time-domain"`.
    #[schemars(with = "Option<f64>", extend("default" = 10_000, "exclusiveMinimum" = 0, "maximum" = 1e9))]
    horizon: Option<Spanned<f64>>,
    /// What happens to samples outside the model, with normal force at or below 0 or f_s < f_c, or whose motion meets a speed
    /// at which a measured curve is at or below 0.
    #[schemars(with = "Option<OutsidePhysics>", extend("default" = "stable"))]
    outside_physics: Option<Spanned<OutsidePhysics>>,
    /// Results of the samples, whose mean and quantiles are written for each cell.
    #[schemars(with = "Option<Vec<BeltRecord>>", extend("default" = []))]
    record: Option<Spanned<Vec<BeltRecord>>>,
}

/// How a sample of an oscillator on a belt is decided.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum BeltKind {
    /// The eigenvalues of steady sliding, in closed form: unstable where -N mu'(V) > c.
    Eigenvalue,
    /// The motion itself, simulated in time.
    TimeDomain,
}

/// What a run can record of the samples of an oscillator on a belt.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum BeltRecord {
    /// Settled amplitude of the unstable samples, half peak to peak of x, m. With `kind = "time-domain"`.
    Amplitude,
    /// Largest real part of the eigenvalues, 1/s. With `kind = "eigenvalue"`.
    GrowthRate,
    /// Frequency of the eigenvalue with the largest real part, Hz. With `kind = "eigenvalue"`.
    Frequency,
    /// Highest belt speed at which steady sliding is unstable, m/s; 0 where it is stable at every speed. With `kind =
    /// "eigenvalue"`.
    CriticalSpeed,
    /// Half peak to peak of x over the limit cycle, with or without sticking, m. With `kind = "eigenvalue"`.
    CycleAmplitude,
    /// Frequency of that cycle, Hz. With `kind = "eigenvalue"`.
    CycleFrequency,
    /// Root mean square of x' over that cycle, m/s. With `kind = "eigenvalue"`.
    CycleVelocity,
    /// Normal force above which steady sliding is unstable, N. With `kind = "eigenvalue"`.
    CriticalNormalForce,
}

impl RecordedName for BeltRecord {
    const ALL: &'static [Self] = &[
        Self::Amplitude,
        Self::GrowthRate,
        Self::Frequency,
        Self::CriticalSpeed,
        Self::CycleAmplitude,
        Self::CycleFrequency,
        Self::CycleVelocity,
        Self::CriticalNormalForce,
    ];

    fn linear(self) -> Option<LinearResult> {
        match self {
            Self::Amplitude => None,
            Self::GrowthRate => Some(LinearResult::GrowthRate),
            Self::Frequency => Some(LinearResult::Frequency),
            Self::CriticalSpeed => Some(LinearResult::CriticalSpeed),
            Self::CycleAmplitude => Some(LinearResult::CycleAmplitude),
            Self::CycleFrequency => Some(LinearResult::CycleFrequency),
            Self::CycleVelocity => Some(LinearResult::CycleVelocity),
            Self::CriticalNormalForce => Some(LinearResult::CriticalPreload),
        }
    }
}

/// A state that a motion starts in. What is left out is as in steady sliding.
#[derive(Debug, Clone, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct GivenBeltStart {
    /// Displacement x, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    displacement: Option<f64>,
    /// Speed x', m/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    velocity: Option<f64>,
    /// Whether `displacement` counts from steady sliding, x = N mu(V) / k; otherwise from the spring without force.
    #[serde(default)]
    from_equilibrium: bool,
}

impl StartNumbers for GivenBeltStart {
    const SCHEMA: &str = "BeltStart";
    const FORM: &str = "{ displacement = ..., velocity = ... }";
}

impl From<&GivenBeltStart> for GivenStart {
    fn from(spec: &GivenBeltStart) -> Self {
        let GivenBeltStart { displacement, velocity, from_equilibrium } = *spec;
        Self { tangential: displacement, velocity, from_equilibrium, ..Self::default() }
    }
}

impl From<&GivenStart> for GivenBeltStart {
    fn from(start: &GivenStart) -> Self {
        Self { displacement: start.tangential, velocity: start.velocity, from_equilibrium: start.from_equilibrium }
    }
}

/// The model while it is being checked.
struct BeltDraft {
    tables: BeltTables,
    quantities: Vec<Quantity>,
    friction: Friction,
    expected: Vec<f64>,
    /// Which quantities have a value in `[model]`, right or wrong.
    given: Vec<bool>,
    /// Whether nothing of `[model]` was refused.
    is_whole: bool,
}

impl BeltDraft {
    fn new(tables: BeltTables) -> Self {
        let quantities = quantities();
        let expected = vec![f64::NAN; quantities.len()];
        // Without values of their own: every value of the law is given, or an axis.
        let unknown = Friction {
            static_coefficient: f64::NAN,
            kinetic_coefficient: f64::NAN,
            stribeck_velocity: f64::NAN,
            ..Parameters::sui_ding_2018().friction
        };
        let given = vec![false; quantities.len()];
        Self { tables, quantities, friction: unknown, expected, given, is_whole: false }
    }

    fn spec(&self) -> Option<&BeltCriterionSpec> {
        self.tables.criterion.as_ref().map(Spanned::get_ref)
    }

    fn kind(&self) -> Option<BeltKind> {
        self.spec()?.kind.as_ref().map(|kind| *kind.get_ref())
    }

    /// Sets an expected value within its limits.
    fn set(&mut self, path: &str, value: &Spanned<f64>, axes: &AxesSpec, complaints: &mut Complaints) {
        let Some(place) = self.quantities.iter().position(|quantity| quantity.path == path) else {
            let names: Vec<&str> =
                self.quantities.iter().filter_map(|quantity| quantity.path.strip_prefix("friction.")).collect();
            let message = format!("unknown key `{path}` in [model] (model.friction has {})", names.join(", "));
            complaints.push(Complaint::at(value.span(), message));
            return;
        };
        self.given[place] = true;
        let quantity = &self.quantities[place];
        if let Some(entry) = axes.0.iter().find(|entry| self.place_of_axis(entry.name.get_ref()) == Some(place)) {
            let message = format!(
                "model.{path} = {} is given a second time as axes.{}, which has the values that are used; remove one of the two",
                value.get_ref(),
                entry.name.get_ref()
            );
            complaints.push(Complaint::at(value.span(), message).and_at(entry.axis.span()));
        }
        if quantity.limits.contain(*value.get_ref()) {
            self.expected[place] = *value.get_ref();
        } else {
            let unit = if quantity.unit == "1" { String::new() } else { format!(" (in {})", quantity.unit) };
            let message =
                format!("model.{path} = {} is out of range: it must be {}{unit}", value.get_ref(), quantity.limits);
            complaints.push(Complaint::at(value.span(), message));
        }
    }

    /// The oscillator with these expected values.
    fn oscillator(&self, expected: &[f64]) -> Oscillator {
        let friction = self.friction.clone();
        let unknown =
            Oscillator { mass: 1.0, stiffness: 1.0, damping: 0.0, normal_force: 1.0, belt_speed: 1.0, friction };
        BeltOscillator::new(unknown, BeltCriterion::default()).oscillator(expected)
    }

    /// Where motions start, if the criterion simulates them.
    fn start(&self, axes: &AxesSpec, random: &[usize]) -> Start {
        let varies = |place: usize| self.quantities[place].role == Role::Start;
        let is_axis = axes.0.iter().filter_map(|entry| self.place_of_axis(entry.name.get_ref())).any(varies);
        match self.spec().and_then(|spec| spec.start.as_ref()).map(Spanned::get_ref) {
            Some(StartSpec::Named(start)) => (*start).into(),
            Some(StartSpec::Given(given)) => Start::Given(given.into()),
            None if is_axis || random.iter().any(|place| varies(*place)) => {
                Start::Given(GivenStart { tangential: Some(0.0), velocity: Some(0.0), ..GivenStart::default() })
            }
            None => Start::NearEquilibrium,
        }
    }

    /// The longest horizon by default, s.
    fn longest(&self, grid: Option<&Grid>) -> f64 {
        let extremes = |name: &str| {
            let place = self.quantities.iter().position(|quantity| quantity.name == name)?;
            Some(grid?.axis_of(place).map_or([self.expected[place]; 2], Axis::extremes))
        };
        let fastest = extremes("mass").zip(extremes("stiffness")).map(|(mass, stiffness)| stiffness[1] / mass[0]);
        fastest.map_or(f64::INFINITY, |squared| MOST_RADIANS / squared.sqrt())
    }

    /// The criterion; each key that is refused is complained about.
    fn criterion(&self, grid: Option<&Grid>, parts: Parts<'_>, complaints: &mut Complaints) -> Option<BeltCriterion> {
        let Some(spanned) = &self.tables.criterion else {
            complaints.push(Complaint::missing("criterion", None, NO_CRITERION));
            return None;
        };
        let spec = spanned.get_ref();
        let Some(kind) = self.kind() else {
            let message = "missing key `kind` in [criterion]: write kind = \"eigenvalue\" or \"time-domain\"";
            complaints.push(Complaint::missing("kind", Some(spanned.span()), message));
            return None;
        };
        let random = parts.random.map_or(&[][..], |random| &random.inputs);
        let start = self.start(&parts.spec.axes, random);
        let names = spec.record.as_ref().map_or(&[][..], |record| record.get_ref());
        let known = if kind == BeltKind::Eigenvalue { &BeltRecord::ALL[1..] } else { &BeltRecord::ALL[..1] };
        let span = spec.record.as_ref().map(Spanned::span);
        complaints.take(record_spec::check(names, known, &kind).map_err(|message| Complaint::maybe_at(span, message)));
        if kind == BeltKind::Eigenvalue {
            let keys = [
                ("start", spec.start.as_ref().map(Spanned::span)),
                ("displacement", spec.displacement.as_ref().map(Spanned::span)),
                ("horizon", spec.horizon.as_ref().map(Spanned::span)),
            ];
            for (key, span) in keys {
                let message =
                    format!("criterion.{key} belongs to kind = \"time-domain\"; remove it, or change the kind");
                complaints.push_some(span.map(|span| Complaint::at(span, message)));
            }
            let is_start = |place: usize| self.quantities[place].role == Role::Start;
            for entry in &parts.spec.axes.0 {
                let name = entry.name.get_ref();
                if self.place_of_axis(name).is_some_and(is_start) {
                    let message = format!("axes.{name} {OF_MOTIONS}");
                    complaints.push(Complaint::at(entry.name.span(), message));
                }
            }
            for name in random.iter().filter(|place| is_start(**place)).map(|place| &self.quantities[*place].name) {
                let span = parts.spec.random.inputs.as_ref().map(Spanned::span);
                complaints.push(Complaint::maybe_at(span, format!("random.inputs: {name} {OF_MOTIONS}")));
            }
            return Some(BeltCriterion::Eigenvalue { record: linear_record(names) });
        }
        let default = TimeDomainSettings::default();
        let settings = TimeDomainSettings {
            start,
            displacement: spec.displacement.as_ref().map_or(default.displacement, |value| *value.get_ref()),
            horizon: spec.horizon.as_ref().map_or(default.horizon.min(self.longest(grid)), |value| *value.get_ref()),
            record_amplitude: names.contains(&BeltRecord::Amplitude),
            ..default
        };
        let checked = settings.validate().map_err(|error| Complaint::at(spanned.span(), format!("criterion.{error}")));
        complaints.take(checked).map(|()| BeltCriterion::TimeDomain(settings))
    }
}

/// What is said of a start where nothing moves.
const OF_MOTIONS: &str =
    "is a number of the start, which belongs to kind = \"time-domain\"; remove it, or change the kind";

/// Radians of the fastest oscillator of a job in its default horizon, at most: half of what a motion may take, so that
/// oscillators that scatter about it have theirs.
const MOST_RADIANS: f64 = 5e6;

const NO_CRITERION: &str = "there is no [criterion]: what decides whether a sample is stable? For example\n\n  [criterion]\n  kind = \"eigenvalue\"        # or \"time-domain\"";

impl Draft for BeltDraft {
    fn quantities(&self) -> &[Quantity] {
        &self.quantities
    }

    fn boundary(&self) -> Option<Boundary> {
        let of = |kind| if kind == BeltKind::Eigenvalue { Boundary::ClosedForm } else { Boundary::Verdicts };
        self.kind().map(of)
    }

    fn outside_physics(&self) -> Option<&Spanned<OutsidePhysics>> {
        self.spec()?.outside_physics.as_ref()
    }

    fn check_values(&mut self, axes: &AxesSpec, folder: &Path, complaints: &mut Complaints) {
        let before = complaints.len();
        let mut friction = self.friction.clone();
        use_law(&self.tables.model.friction, folder, &mut friction, complaints);
        self.friction = friction;
        let has_law = complaints.len() == before;
        // A measured curve gives the static friction coefficient itself.
        let defaults = [
            ("friction.stribeck_exponent", self.friction.stribeck_exponent),
            ("friction.viscous", self.friction.viscous),
            ("friction.band", self.friction.band),
            ("friction.static_coefficient", self.friction.static_coefficient),
            ("friction.kinetic_coefficient", self.friction.kinetic_coefficient),
        ];
        for (path, value) in defaults {
            if let Some(place) = self.quantities.iter().position(|quantity| quantity.path == path) {
                self.expected[place] = value;
            }
        }
        let model = std::mem::take(&mut self.tables.model);
        for (name, value) in model.values() {
            if let Some(value) = value {
                self.set(name, value, axes, complaints);
            }
        }
        for (name, value) in &model.friction.values {
            self.set(&format!("friction.{}", name.get_ref()), value, axes, complaints);
        }
        self.tables.model = model;
        let law = LawSpec::from(&self.friction.law);
        for (place, quantity) in self.quantities.iter().enumerate() {
            let is_axis = axes.0.iter().any(|entry| self.place_of_axis(entry.name.get_ref()) == Some(place));
            let of_other_law =
                quantity.path.strip_prefix("friction.").is_some_and(|name| law.refusal(name, "").is_some());
            // Without its law nobody knows what friction needs.
            let is_known = has_law || !quantity.path.starts_with("friction.");
            let is_needed = quantity.role != Role::Start && !of_other_law && is_known && !self.given[place];
            if is_needed && self.expected[place].is_nan() && !is_axis && !complaints.has_unread(&["model"]) {
                let message = format!(
                    "missing key `{path}` in [model]: the {what}, unit {unit}; or give it an axis, axes.{name}",
                    path = quantity.path,
                    what = quantity.description,
                    unit = quantity.unit,
                    name = quantity.name
                );
                complaints.push(Complaint::missing("model", None, message));
            }
            if of_other_law && self.expected[place].is_nan() {
                self.expected[place] = 1.0;
            }
        }
        self.is_whole = complaints.len() == before && !complaints.has_unread(&["model"]);
    }

    fn expected(&self) -> Vec<f64> {
        self.expected.clone()
    }

    fn settle(&mut self, axes: &[(usize, Axis)], _: &JobSpec, _: &mut Complaints) -> bool {
        // An axis replaces the model's own value; the smallest static friction coefficient must fit the other values.
        for (place, axis) in axes {
            let is_pair = self.quantities[*place].role == Role::Input;
            self.expected[*place] = if is_pair { axis.extremes()[0] } else { axis.values()[0] };
        }
        self.is_whole
    }

    fn check_grid(&self, grid: Option<&Grid>, parts: Parts<'_>, complaints: &mut Complaints) -> bool {
        friction::check_law_of_varied(parts, &self.quantities, &self.friction, complaints);
        let Some(grid) = grid.filter(|_| self.is_whole) else { return self.is_whole };
        let model = BeltOscillator::new(self.oscillator(&self.expected), BeltCriterion::default());
        let checked = configurable(&model, grid).map_err(|error| Complaint::maybe_at(None, format!("model: {error}")));
        complaints.take(checked).is_some()
    }

    fn finish(
        self: Box<Self>,
        grid: Option<&Grid>,
        parts: Parts<'_>,
        complaints: &mut Complaints,
    ) -> Option<Arc<dyn JobModel>> {
        let criterion = self.criterion(grid, parts, complaints)?;
        let grid = grid?;
        let model = BeltOscillator::new(self.oscillator(&self.expected), criterion);
        let checked =
            configurable(&model, grid).map_err(|error| Complaint::maybe_at(None, format!("criterion: {error}")));
        complaints.take(checked)?;
        Some(Arc::new(BeltJob(model)))
    }
}

/// The oscillator of a job.
#[derive(Debug)]
struct BeltJob(BeltOscillator);

impl BeltJob {
    /// The friction law.
    fn law(&self) -> LawKind {
        self.0.oscillator(&self.0.expected()).friction.law
    }

    /// The place of the speed of the belt.
    fn belt_speed(&self) -> Option<usize> {
        self.0.quantities().iter().position(|quantity| quantity.name == BELT_SPEED)
    }

    /// Where steady sliding is unstable with the values of the cell in the middle of a grid, if friction is measured.
    fn unstable_speeds(&self, grid: &Grid) -> Option<(SharedCurve, UnstableSpeeds)> {
        let curve = *self.law().table()?;
        let cell = grid.cell(grid.middle()?);
        let pad = self.rigid_pad(&cell.expected)?.ok()?;
        let (axis, unit, on) = (BELT_SPEED, "m/s", "");
        Some((curve, UnstableSpeeds { axis, unit, on, cell: cell.index, ranges: pad.unstable_speeds() }))
    }
}

/// The name of the speed of the belt.
const BELT_SPEED: &str = "belt_speed";

impl JobModel for BeltJob {
    fn model(&self) -> &dyn Model {
        &self.0
    }

    fn expected(&self) -> Vec<f64> {
        self.0.expected()
    }

    fn tables(&self, grid: &Grid) -> Tables {
        let expected = self.0.expected();
        let law = self.0.oscillator(&expected).friction.law;
        let given = |place: usize, quantity: &Quantity| {
            let is_given = quantity.role != Role::Start && grid.axis_of(place).is_none();
            is_given.then(|| written(expected[place]))
        };
        let value = |path: &str| {
            let mut quantities = self.0.quantities().iter().enumerate();
            quantities.find(|(_, quantity)| quantity.path == path).and_then(|(place, quantity)| given(place, quantity))
        };
        let of_friction = self.0.quantities().iter().enumerate().filter_map(|(place, quantity)| {
            let name = quantity.path.strip_prefix("friction.")?;
            let is_own = LawSpec::from(&law).refusal(name, "").is_none();
            is_own.then(|| Some((written(name.to_owned()), given(place, quantity)?))).flatten()
        });
        let mut model = table_of(&BeltModelSpec {
            mass: value("mass"),
            stiffness: value("stiffness"),
            damping: value("damping"),
            normal_force: value("normal_force"),
            belt_speed: value("belt_speed"),
            friction: FrictionSpec::written_out(&law, of_friction.collect()),
        });
        model.insert("kind".to_owned(), KIND.name.into());
        Tables { model, criterion: table_of(&BeltCriterionSpec::from(self.0.criterion())) }
    }

    fn warnings(&self, grid: &Grid, random: &RandomInputSet) -> Vec<String> {
        let (Some((curve, _)), Some(place)) = (self.unstable_speeds(grid), self.belt_speed()) else {
            return Vec::new();
        };
        let mut warnings = measured_friction::doubts(&curve, grid.extremes_of(place)[1]);
        warnings.extend(measured_friction::vanishing(&curve, self.0.quantities(), grid, random));
        warnings.extend(self.hidden_speeds(grid));
        warnings
    }

    fn hidden_speeds(&self, grid: &Grid) -> Option<String> {
        let (curve, speeds) = self.unstable_speeds(grid)?;
        speeds.doubt(&curve, grid.axis_of(self.belt_speed()?)?.values())
    }

    fn remarks(&self, grid: &Grid) -> String {
        self.unstable_speeds(grid).map_or(String::new(), |(curve, speeds)| speeds.remarks(&curve))
    }

    fn map_refusal(&self, _: &Grid, _: &RandomInputSet) -> Option<String> {
        None
    }

    fn rigid_pad(&self, expected: &[f64]) -> Option<Result<PadOnDisc, ParameterError>> {
        Some(PadOnDisc::new(self.0.oscillator(expected).as_pad()))
    }

    fn friction_curve(&self, expected: &[f64]) -> Option<FrictionCurve> {
        let curve = *self.law().table()?;
        let pad = self.rigid_pad(expected)?.ok()?;
        let unstable = pad.unstable_speeds().iter().map(|range| [range.from, range.to]).collect();
        let Friction { static_coefficient, band, .. } = pad.parameters().friction;
        Some(FrictionCurve { curve, static_coefficient, band, unstable })
    }

    fn freeze(&self, document: &mut DocumentMut) -> String {
        friction::freeze(document, &self.law())
    }
}

/// Keys that the kind of criterion has no use for are absent.
impl From<&Criterion> for BeltCriterionSpec {
    fn from(criterion: &Criterion) -> Self {
        let of_kind = |kind: BeltKind| Self { kind: Some(written(kind)), ..Self::default() };
        let Criterion::TimeDomain { settings, .. } = criterion else {
            let record = criterion.linear_record();
            let record = (!record.is_empty()).then(|| written(names_of(record)));
            return Self { record, ..of_kind(BeltKind::Eigenvalue) };
        };
        Self {
            start: Some(written((&settings.start).into())),
            displacement: Some(written(settings.displacement)),
            horizon: Some(written(settings.horizon)),
            record: settings.record_amplitude.then(|| written(vec![BeltRecord::Amplitude])),
            ..of_kind(BeltKind::TimeDomain)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_the_pads_columns_but_for_the_force() {
        for name in BeltRecord::ALL {
            let column = match name.linear().map_or("amplitude", |result| result.described().name) {
                "critical_preload" => "critical_normal_force",
                of_pad => of_pad,
            };
            assert_eq!(serde_json::to_value(name).unwrap(), column);
        }
    }
}
