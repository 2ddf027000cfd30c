//! Models given by matrices in job specs.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;
use std::sync::{Arc, OnceLock};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stickslip_core::model::Model;
use stickslip_core::model::quantity::{Limits, Quantity};
use stickslip_core::models::matrices::factor::Factor;
use stickslip_core::models::matrices::model::{
    BAND, ComplexEigenvalue, Matrices, MatrixModel, Parameter, Term, quantities,
};
use stickslip_core::models::matrices::problem::Solver;
use stickslip_sampler::grid::{Axis, Grid};
use toml::Spanned;
use toml_edit::DocumentMut;

use self::checks::Mode;
use self::terms::{FileTerm, TermSpec, TermsSpec, read_term};
use crate::job::axes::values;
use crate::job::axes_spec::{AxesSpec, AxisEntry};
use crate::job::diagnosis::{Complaint, Complaints};
use crate::job::model::{Draft, JobModel, Kind, OutsidePhysics, Parts, Tables, configurable, table_of, written};
use crate::job::random::RandomInputSet;
use crate::job::reading;

mod terms;

mod checks;

/// The kind in job specs.
pub const KIND: Kind = Kind {
    name: "matrices",
    draft: |text, document, complaints| {
        let tables = reading::read::<MatrixTables>(text, document, |_, _| None, complaints)?;
        Some(Box::new(MatrixDraft::new(tables, complaints)))
    },
    schemas: [
        |generator| generator.subschema_for::<MatrixModelSpec>(),
        |generator| generator.subschema_for::<MatrixCriterionSpec>(),
    ],
    axes: Vec::new,
};

/// Degrees of freedom up to which samples are decided by dense matrices.
const MOST_COORDINATES: usize = 400;

/// The tables `[model]` and `[criterion]`.
#[derive(Debug, Deserialize)]
struct MatrixTables {
    #[serde(default)]
    model: MatrixModelSpec,
    criterion: Option<Spanned<MatrixCriterionSpec>>,
}

/// A model given by matrices, M q'' + C(p) q' + K(p) q = 0: `kind = "matrices"`.
#[derive(Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct MatrixModelSpec {
    /// M: symmetric, positive definite.
    #[schemars(with = "TermSpec")]
    mass: Option<Spanned<TermSpec>>,
    /// The terms of C, each a matrix times its factor; without it there is no damping.
    #[serde(default)]
    #[schemars(with = "Vec<TermSpec>", extend("default" = []))]
    damping: TermsSpec,
    /// The terms of K. That of friction is not symmetric.
    #[serde(default)]
    #[schemars(with = "Vec<TermSpec>")]
    stiffness: TermsSpec,
    /// The expected values of the parameters in the factors, by names of yours: a number, or a table.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, ParameterSpec>", extend("default" = {}))]
    parameters: BTreeMap<Spanned<String>, Spanned<ParameterSpec>>,
}

/// The expected value of a parameter, or more about it.
#[derive(Debug, Clone, Deserialize, Serialize, JsonSchema)]
#[serde(untagged)]
enum ParameterSpec {
    /// The expected value.
    Value(f64),
    /// The expected value with unit, name in pictures and range.
    Described(DescribedParameter),
}

/// A parameter with what there is to say about it.
#[derive(Debug, Clone, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(inline)]
struct DescribedParameter {
    /// The expected value.
    value: f64,
    /// Its unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    unit: Option<String>,
    /// Its name in pictures.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    label: Option<String>,
    /// Its least and largest value; samples beyond are outside the model.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    range: Option<[f64; 2]>,
}

/// What decides whether a sample of a model given by matrices is stable.
#[derive(Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct MatrixCriterionSpec {
    /// How a sample is decided.
    #[schemars(with = "MatrixKind")]
    kind: Option<Spanned<MatrixKind>>,
    /// The band in which pairs count, Hz, both ends included; without it all frequencies.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<[f64; 2]>")]
    frequency: Option<Spanned<[f64; 2]>>,
    /// Several bands in place of `frequency`: a cell for each, and one for any of them (`band` 0).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Vec<[f64; 2]>>")]
    bands: Option<Spanned<Vec<[f64; 2]>>>,
    /// Unstable is a pair in the band whose damping ratio, -Re / |lambda|, is below it by more than 1e-9.
    #[schemars(with = "Option<f64>", extend("default" = 0, "exclusiveMinimum" = -1, "exclusiveMaximum" = 1))]
    damping_ratio: Option<Spanned<f64>>,
    /// What happens to samples with a parameter beyond its range.
    #[schemars(with = "Option<OutsidePhysics>", extend("default" = "stable"))]
    outside_physics: Option<Spanned<OutsidePhysics>>,
}

/// How a sample of a model given by matrices is decided.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum MatrixKind {
    /// The eigenvalues of the quadratic problem.
    ComplexEigenvalue,
}

/// The model while it is being checked.
struct MatrixDraft {
    tables: MatrixTables,
    parameters: Vec<Parameter>,
    bands: Vec<[f64; 2]>,
    quantities: Vec<Quantity>,
    expected: Vec<f64>,
    model: Option<ReadModel>,
    /// Whether nothing of parameters and bands was refused.
    is_whole: bool,
}

/// The matrices, once they are read, and what the job says of them.
struct ReadModel {
    matrices: Arc<Matrices>,
    files: Vec<FileTerm>,
    notes: Vec<String>,
}

/// What a missing criterion is answered with.
const NO_CRITERION: &str = "there is no [criterion]: what decides whether a sample is stable? For example\n\n  [criterion]\n  kind = \"complex-eigenvalue\"\n  frequency = [1000.0, 3000.0]   # Hz";

impl MatrixDraft {
    fn new(tables: MatrixTables, complaints: &mut Complaints) -> Self {
        let before = complaints.len();
        let mut parameters = Vec::new();
        for (name, spec) in &tables.model.parameters {
            match parameter(name, spec) {
                Ok(parameter) => parameters.push(parameter),
                Err(complaint) => complaints.push(complaint),
            }
        }
        let bands = bands(tables.criterion.as_ref().map(Spanned::get_ref), complaints);
        let quantities = quantities(&parameters, bands.len());
        let mut expected: Vec<f64> = parameters.iter().map(|parameter| parameter.value).collect();
        expected.resize(quantities.len(), 0.0);
        Self { tables, parameters, bands, quantities, expected, model: None, is_whole: complaints.len() == before }
    }

    fn spec(&self) -> Option<&MatrixCriterionSpec> {
        self.tables.criterion.as_ref().map(Spanned::get_ref)
    }

    /// Reads the matrices and their factors, and checks them.
    fn read(&self, folder: &Path, complaints: &mut Complaints) -> Option<ReadModel> {
        let names: Vec<&str> = self.parameters.iter().map(|parameter| parameter.name.as_str()).collect();
        let mut files = Vec::new();
        let mut read = |place: &str, spec: &Spanned<TermSpec>, complaints: &mut Complaints| {
            let term = complaints.take(read_term(place, spec, folder, &names))?;
            files.extend(term.file);
            Some(Term { matrix: Arc::new(term.matrix), factor: term.factor })
        };
        let model = &self.tables.model;
        let Some(mass) = &model.mass else {
            let message = "missing key `mass` in [model]: the mass matrix, { file = \"brake.mat\", matrix = \"M\" } or { matrix = [[...], ...] }";
            complaints.push(Complaint::missing("model", None, message.to_owned()));
            return None;
        };
        let mass_term = read("mass", mass, complaints);
        let mut terms = |name: &str, specs: &TermsSpec| -> Option<Vec<Term>> {
            let read = |(i, spec)| read(&format!("{name}[{i}]"), spec, complaints);
            let terms: Vec<Option<Term>> = specs.0.iter().enumerate().map(read).collect();
            terms.into_iter().collect()
        };
        let (damping, stiffness) = (terms("damping", &model.damping), terms("stiffness", &model.stiffness));
        let (mass_term, damping, stiffness) = (mass_term?, damping?, stiffness?);
        if stiffness.is_empty() {
            let message = "missing key `stiffness` in [model]: the terms of the stiffness matrix";
            complaints.push(Complaint::missing("model", None, message.to_owned()));
            return None;
        }
        if mass_term.factor != Factor::number(1.0) {
            let message =
                "model.mass: the mass matrix has no factor; scale its values, or those of damping and stiffness";
            complaints.push(Complaint::at(mass.span(), message));
            return None;
        }
        let spans: Vec<Range<usize>> = model.damping.0.iter().chain(&model.stiffness.0).map(Spanned::span).collect();
        checks::sizes(&mass_term, mass.span(), &damping, &stiffness, &spans, complaints)?;
        let matrices = Matrices { mass: mass_term.matrix, damping, stiffness, parameters: self.parameters.clone() };
        let notes = checks::remarks(&matrices);
        Some(ReadModel { matrices: Arc::new(matrices), files, notes })
    }
}

/// A parameter of a job.
fn parameter(name: &Spanned<String>, spec: &Spanned<ParameterSpec>) -> Result<Parameter, Complaint> {
    let text = name.get_ref();
    let is_name = text.starts_with(|c: char| c.is_alphabetic() || c == '_')
        && text.chars().all(|c| c.is_alphanumeric() || c == '_');
    if !is_name || text == BAND {
        let message = if is_name {
            format!("model.parameters.{text}: this name is that of the bands of frequencies; choose another")
        } else {
            format!(
                "model.parameters: `{text}` is no name: it must have letters, digits and _ only, and begin with a letter"
            )
        };
        return Err(Complaint::at(name.span(), message));
    }
    let described = match spec.get_ref() {
        ParameterSpec::Value(value) => DescribedParameter { value: *value, unit: None, label: None, range: None },
        ParameterSpec::Described(described) => described.clone(),
    };
    let complain = |message: String| Complaint::at(spec.span(), format!("model.parameters.{text}{message}"));
    let range = match described.range {
        None => Limits::ANY,
        Some([least, largest]) if least < largest => Limits::from(least, largest),
        Some([least, largest]) => {
            return Err(complain(format!(".range = [{least}, {largest}]: the first must be less than the second")));
        }
    };
    if !described.value.is_finite() || !range.contain(described.value) {
        return Err(complain(format!(" = {} is out of range: it must be {range}", described.value)));
    }
    Ok(Parameter {
        name: text.clone(),
        value: described.value,
        unit: described.unit.unwrap_or_else(|| "1".to_owned()),
        label: described.label.unwrap_or_else(|| text.replace('_', " ")),
        range,
    })
}

/// The bands of frequencies of a criterion, Hz.
fn bands(spec: Option<&MatrixCriterionSpec>, complaints: &mut Complaints) -> Vec<[f64; 2]> {
    const ALL: [f64; 2] = [0.0, f64::INFINITY];
    let Some(spec) = spec else { return vec![ALL] };
    let (key, bands, span) = match (&spec.frequency, &spec.bands) {
        (Some(_), Some(bands)) => {
            let message = "criterion.bands is given beside criterion.frequency; remove one of the two";
            complaints.push(Complaint::at(bands.span(), message));
            return vec![ALL];
        }
        (Some(band), None) => ("frequency", vec![*band.get_ref()], band.span()),
        (None, Some(bands)) => ("bands", bands.get_ref().clone(), bands.span()),
        (None, None) => return vec![ALL],
    };
    if bands.is_empty() {
        complaints.push(Complaint::at(span, "criterion.bands: there is no band; give each as [lowest, highest] in Hz"));
        return vec![ALL];
    }
    for [low, high] in &bands {
        if !(*low >= 0.0 && low < high) {
            let message =
                format!("criterion.{key}: [{low}, {high}] is no band: it must be [lowest, highest] in Hz, from 0 up");
            complaints.push(Complaint::at(span.clone(), message));
            return vec![ALL];
        }
    }
    bands
}

impl Draft for MatrixDraft {
    fn quantities(&self) -> &[Quantity] {
        &self.quantities
    }

    fn has_closed_form(&self) -> Option<bool> {
        Some(false)
    }

    fn criterion_span(&self) -> Option<Range<usize>> {
        self.spec()?.kind.as_ref().map(Spanned::span)
    }

    fn outside_physics(&self) -> Option<&Spanned<OutsidePhysics>> {
        self.spec()?.outside_physics.as_ref()
    }

    fn check_values(&mut self, _: &AxesSpec, folder: &Path, complaints: &mut Complaints) {
        if complaints.has_unread(&["model"]) || !self.is_whole {
            return;
        }
        self.model = self.read(folder, complaints);
    }

    fn expected(&self) -> Vec<f64> {
        self.expected.clone()
    }

    /// Several bands are an axis by themselves: any of them, and each.
    fn converted(
        &self,
        place: usize,
        entry: Option<&AxisEntry>,
        _: &[(usize, Axis)],
        _: &AxesSpec,
    ) -> Option<Result<Axis, Complaint>> {
        if self.quantities[place].name != BAND {
            return None;
        }
        let all = || Axis::from_values((0..=self.bands.len()).map(|band| band as f64).collect());
        let axis = match entry {
            None => all().map_err(|error| Complaint::maybe_at(None, error.to_string())),
            Some(entry) => {
                let complain = |message: String| Complaint::at(entry.axis.span(), format!("axes.{BAND}: {message}"));
                values(entry.axis.get_ref()).map_err(complain).and_then(|axis| {
                    let is_band = |band: &f64| band.fract() == 0.0 && (0.0..=self.bands.len() as f64).contains(band);
                    match axis.values().iter().find(|band| !is_band(band)) {
                        None => Ok(axis),
                        Some(band) => {
                            Err(complain(format!("{band} is no band; there are 0 (any) to {}", self.bands.len())))
                        }
                    }
                })
            }
        };
        Some(axis)
    }

    fn settle(&mut self, axes: &[(usize, Axis)], _: &crate::job::spec::JobSpec, _: &mut Complaints) -> bool {
        for (place, axis) in axes {
            self.expected[*place] = axis.values()[0];
        }
        self.model.is_some()
    }

    fn finish(
        self: Box<Self>,
        grid: Option<&Grid>,
        _: Parts<'_>,
        complaints: &mut Complaints,
    ) -> Option<Arc<dyn JobModel>> {
        let Some(spec) = self.spec() else {
            if !complaints.has_unread(&["criterion"]) {
                complaints.push(Complaint::missing("criterion", None, NO_CRITERION.to_owned()));
            }
            return None;
        };
        if spec.kind.is_none() {
            let message = "missing key `kind` in [criterion]: it must be \"complex-eigenvalue\"";
            complaints.push(Complaint::missing("criterion", None, message.to_owned()));
            return None;
        }
        let damping_ratio = spec.damping_ratio.as_ref().map_or(0.0, |ratio| *ratio.get_ref());
        if let Some(ratio) = &spec.damping_ratio
            && !(-1.0 < damping_ratio && damping_ratio < 1.0)
        {
            let message = format!(
                "criterion.damping_ratio = {damping_ratio} is out of range: it must be greater than -1 and less than 1"
            );
            complaints.push(Complaint::at(ratio.span(), message));
            return None;
        }
        let read = self.model.filter(|_| self.is_whole)?;
        let grid = grid?;
        let criterion = ComplexEigenvalue { bands: self.bands, damping_ratio };
        if read.matrices.size() > MOST_COORDINATES {
            let message = format!(
                "model: {} degrees of freedom are too many to decide every sample by all eigenvalues; the limit is {MOST_COORDINATES}. Reduce the matrices to some 100 coordinates first",
                read.matrices.size()
            );
            complaints.push(Complaint::maybe_at(self.tables.model.mass.map(|mass| mass.span()), message));
            return None;
        }
        let model = MatrixModel::new(read.matrices, criterion, Solver::Dense);
        let span = self.tables.model.mass.as_ref().map(Spanned::span);
        let model =
            complaints.take(model.map_err(|error| Complaint::maybe_at(span, format!("model.mass: {error}"))))?;
        let checked = configurable(&model, grid).map_err(|error| Complaint::maybe_at(None, format!("model: {error}")));
        complaints.take(checked)?;
        Some(Arc::new(MatrixJob {
            model,
            files: read.files,
            notes: read.notes,
            tables: self.tables.model,
            modes: OnceLock::new(),
        }))
    }
}

/// The model of a job.
#[derive(Debug)]
struct MatrixJob {
    model: MatrixModel,
    files: Vec<FileTerm>,
    notes: Vec<String>,
    tables: MatrixModelSpec,
    /// The modes of the expected brake, found when they are first wanted.
    modes: OnceLock<Vec<Mode>>,
}

impl MatrixJob {
    fn modes(&self, grid: &Grid) -> &[Mode] {
        self.modes.get_or_init(|| checks::modes(&self.model, &grid.expected))
    }

    /// A term as it is written out.
    fn written_term(&self, spec: &TermSpec) -> TermSpec {
        spec.identified(&self.files)
    }
}

impl JobModel for MatrixJob {
    fn model(&self) -> &dyn Model {
        &self.model
    }

    fn expected(&self) -> Vec<f64> {
        self.model.expected()
    }

    fn tables(&self, grid: &Grid) -> Tables {
        let terms = |specs: &TermsSpec| {
            TermsSpec(specs.0.iter().map(|spec| written(self.written_term(spec.get_ref()))).collect())
        };
        let of_parameter = |(place, parameter): (usize, &Parameter)| {
            let range = (parameter.range != Limits::ANY).then_some([parameter.range.minimum, parameter.range.maximum]);
            // An axis replaces the value, which the factors need all the same.
            let value = if grid.axis_of(place).is_some() { grid.expected[place] } else { parameter.value };
            let described = DescribedParameter {
                value,
                unit: (parameter.unit != "1").then(|| parameter.unit.clone()),
                label: (parameter.label != parameter.name.replace('_', " ")).then(|| parameter.label.clone()),
                range,
            };
            let spec = match &described {
                DescribedParameter { unit: None, label: None, range: None, .. } => ParameterSpec::Value(value),
                _ => ParameterSpec::Described(described),
            };
            (written(parameter.name.clone()), written(spec))
        };
        let mut model = table_of(&MatrixModelSpec {
            mass: self.tables.mass.as_ref().map(|mass| written(self.written_term(mass.get_ref()))),
            damping: terms(&self.tables.damping),
            stiffness: terms(&self.tables.stiffness),
            parameters: self.model.matrices().parameters.iter().enumerate().map(of_parameter).collect(),
        });
        model.insert("kind".to_owned(), KIND.name.into());
        let ComplexEigenvalue { bands, damping_ratio } = self.model.criterion();
        let is_all = bands.len() == 1 && bands[0] == [0.0, f64::INFINITY];
        let criterion = table_of(&MatrixCriterionSpec {
            kind: Some(written(MatrixKind::ComplexEigenvalue)),
            frequency: (bands.len() == 1 && !is_all).then(|| written(bands[0])),
            bands: (bands.len() > 1).then(|| written(bands.clone())),
            damping_ratio: Some(written(*damping_ratio)),
            outside_physics: None,
        });
        Tables { model, criterion }
    }

    fn warnings(&self, grid: &Grid, _: &RandomInputSet) -> Vec<String> {
        let mut warnings = self.notes.clone();
        warnings.extend(checks::warnings(&self.model, self.modes(grid)));
        warnings
    }

    fn remarks(&self, grid: &Grid) -> String {
        checks::frequencies(&self.model, self.modes(grid))
    }

    fn as_matrices(&self) -> Option<&MatrixModel> {
        Some(&self.model)
    }

    fn freeze(&self, document: &mut DocumentMut) -> String {
        terms::freeze(document, &self.files)
    }
}
