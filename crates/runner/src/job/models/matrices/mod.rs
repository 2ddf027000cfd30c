//! Models given by matrices in job specs.

use std::path::Path;
use std::sync::{Arc, OnceLock};

use serde::Deserialize;
use stickslip_core::model::Model;
use stickslip_core::model::quantity::Quantity;
use stickslip_core::models::matrices::model::{BAND, ComplexEigenvalue, MatrixModel, NOT_AT_HAND, quantities};
use stickslip_core::models::matrices::problem::{Problem, Solver};
use stickslip_core::models::matrices::recorded::PairResult;
use stickslip_core::models::matrices::terms::{Matrix, Parameter};
use stickslip_sampler::grid::{Axis, Grid};
use toml::Spanned;
use toml_edit::DocumentMut;

use self::assemble::ReadModel;
use self::checks::Mode;
use self::parameters::{parameter, written_parameter};
use self::spec::{MatrixCriterionSpec, MatrixKind, MatrixModelSpec, PairRecord, RigidBodyMotions, SolvedMatrices};
use self::terms::{FileTerm, TermSpec, TermsSpec};
use crate::job::axes::values;
use crate::job::axes_spec::{AxesSpec, AxisEntry};
use crate::job::diagnosis::{Complaint, Complaints};
use crate::job::model::{
    Boundary, Draft, JobModel, Kind, OutsidePhysics, Parts, Tables, configurable, table_of, written,
};
use crate::job::random::RandomInputSet;
use crate::job::reading;
use crate::job::reduction::Reduction;

pub mod terms;

mod spec;

mod parameters;

mod checks;

mod assemble;

/// The kind in job specs.
pub const KIND: Kind = Kind {
    name: "matrices",
    criteria: &["complex-eigenvalue"],
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

/// The model while it is being checked.
struct MatrixDraft {
    tables: MatrixTables,
    parameters: Vec<Parameter>,
    bands: Vec<[f64; 2]>,
    quantities: Vec<Quantity>,
    expected: Vec<f64>,
    model: Option<ReadModel>,
    reads_files: bool,
    /// Whether nothing of parameters and bands was refused.
    is_whole: bool,
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
        let is_whole = complaints.len() == before;
        Self { tables, parameters, bands, quantities, expected, model: None, reads_files: true, is_whole }
    }

    fn spec(&self) -> Option<&MatrixCriterionSpec> {
        self.tables.criterion.as_ref().map(Spanned::get_ref)
    }
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

    fn boundary(&self) -> Option<Boundary> {
        Some(Boundary::CriticalValues)
    }

    fn outside_physics(&self) -> Option<&Spanned<OutsidePhysics>> {
        self.spec()?.outside_physics.as_ref()
    }

    fn leave_files(&mut self) {
        self.reads_files = false;
    }

    fn check_values(&mut self, _: &AxesSpec, folder: &Path, complaints: &mut Complaints) {
        if complaints.has_unread(&["model"]) || !self.is_whole {
            return;
        }
        let folder = self.reads_files.then_some(folder);
        // Without files it is refused for other reasons than these, which were said when it was read with them.
        self.model = assemble::read(&self.tables.model, &self.parameters, folder, complaints)
            .filter(|read| folder.is_some() || !read.files.is_empty());
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
        if let Some(reduction) = &self.tables.model.reduction
            && reduction.get_ref().differed > reduction.get_ref().audited
        {
            let Reduction { audited, differed, .. } = reduction.get_ref();
            let message =
                format!("model.reduction.differed = {differed} is out of range: {audited} samples were audited");
            complaints.push(Complaint::at(reduction.span(), message));
            return None;
        }
        let solved = spec.matrices.as_ref().map(|matrices| (*matrices.get_ref(), matrices.span()));
        let record: Vec<PairResult> =
            spec.record.iter().flat_map(Spanned::get_ref).map(|record| record.result()).collect();
        if let (Some(record), Some((SolvedMatrices::Full, _))) = (&spec.record, &solved)
            && !record.get_ref().is_empty()
        {
            let message = "criterion.record needs all pairs of the band, and with criterion.matrices = \"full\" only those near the threshold are looked for; reduce the matrices first (`stickslip reduce`), or remove one of the two";
            complaints.push(Complaint::at(record.span(), message));
            return None;
        }
        let has_column =
            |name: &&Spanned<String>| record.iter().any(|result| result.described().name == *name.get_ref());
        if let Some(name) = self.tables.model.parameters.keys().find(has_column) {
            let message = format!(
                "model.parameters.{0}: criterion.record writes a column of this name; give the parameter another",
                name.get_ref()
            );
            complaints.push(Complaint::at(name.span(), message));
            return None;
        }
        let counts_rigid_body_motions =
            spec.rigid_body_motions.as_ref().is_some_and(|key| *key.get_ref() == RigidBodyMotions::Counted);
        let read = self.model.filter(|_| self.is_whole)?;
        let grid = grid?;
        let criterion = ComplexEigenvalue { bands: self.bands, damping_ratio, counts_rigid_body_motions };
        let solver = match solved {
            Some((SolvedMatrices::Full, span)) => {
                if criterion.bands.iter().any(|[_, highest]| highest.is_infinite()) {
                    let message = "criterion.matrices = \"full\" looks for eigenvalues in a band; give criterion.frequency = [lowest, highest] in Hz";
                    complaints.push(Complaint::at(span, message));
                    return None;
                }
                Solver::Sparse
            }
            _ => Solver::Dense,
        };
        if solver == Solver::Dense && read.matrices.size() > MOST_COORDINATES {
            let message = format!(
                "model: {} degrees of freedom are too many to decide every sample by all eigenvalues; the limit is {MOST_COORDINATES}. Reduce the matrices to some 100 coordinates first (`stickslip reduce`), or give criterion.matrices = \"full\", which takes some 0.1 to 10 s for each sample",
                read.matrices.size()
            );
            complaints.push(Complaint::maybe_at(self.tables.model.mass.map(|mass| mass.span()), message));
            return None;
        }
        let model = MatrixModel::new(read.matrices, criterion, solver);
        let span = self.tables.model.mass.as_ref().map(Spanned::span);
        let model =
            complaints.take(model.map_err(|error| Complaint::maybe_at(span, format!("model.mass: {error}"))))?;
        let mut model = model.recording(record);
        if self.reads_files {
            let checked = configurable(&model, grid);
            complaints.take(checked.map_err(|error| Complaint::maybe_at(None, format!("model: {error}"))))?;
        } else {
            model = model.without_matrices();
        }
        Some(Arc::new(MatrixJob {
            model,
            displacements: read.displacements,
            files: read.files,
            warnings: read.warnings,
            remarks: read.remarks,
            tables: self.tables.model,
            modes: OnceLock::new(),
        }))
    }
}

/// The model of a job.
#[derive(Debug)]
struct MatrixJob {
    model: MatrixModel,
    /// Of all degrees of freedom, where some are condensed.
    displacements: Option<Matrix>,
    files: Vec<FileTerm>,
    warnings: Vec<String>,
    /// What was done in reading, in lines of comments.
    remarks: String,
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
            // An axis replaces the value, which the factors need all the same.
            let value = if grid.axis_of(place).is_some() { grid.expected[place] } else { parameter.value };
            let spec = written_parameter(parameter, value);
            (written(parameter.name.clone()), written(spec))
        };
        let mut model = table_of(&MatrixModelSpec {
            mass: self.tables.mass.as_ref().map(|mass| written(self.written_term(mass.get_ref()))),
            damping: terms(&self.tables.damping),
            stiffness: terms(&self.tables.stiffness),
            parameters: self.model.matrices().parameters.iter().enumerate().map(of_parameter).collect(),
            reduction: self.tables.reduction.clone(),
        });
        model.insert("kind".to_owned(), KIND.name.into());
        let ComplexEigenvalue { bands, damping_ratio, counts_rigid_body_motions } = self.model.criterion();
        let recorded = self.model.recorded_results();
        let is_all = bands.len() == 1 && bands[0] == [0.0, f64::INFINITY];
        let criterion = table_of(&MatrixCriterionSpec {
            kind: Some(written(MatrixKind::ComplexEigenvalue)),
            frequency: (bands.len() == 1 && !is_all).then(|| written(bands[0])),
            bands: (bands.len() > 1).then(|| written(bands.clone())),
            damping_ratio: Some(written(*damping_ratio)),
            rigid_body_motions: counts_rigid_body_motions.then(|| written(RigidBodyMotions::Counted)),
            matrices: matches!(self.model.problem(), Problem::Sparse(_)).then(|| written(SolvedMatrices::Full)),
            outside_physics: None,
            record: (!recorded.is_empty())
                .then(|| written(recorded.iter().map(|result| PairRecord::of(*result)).collect())),
        });
        Tables { model, criterion }
    }

    fn warnings(&self, grid: &Grid, _: &RandomInputSet) -> Vec<String> {
        let mut warnings = self.warnings.clone();
        warnings.extend(self.reduction().map(Reduction::warnings).unwrap_or_default());
        if let Some(why) = self.unread() {
            warnings.push(format!("{why}, so nothing is said of them and of the modes"));
            return warnings;
        }
        warnings.extend(checks::warnings(&self.model, self.modes(grid)));
        warnings.extend(checks::rigid_body_motions(&self.model, self.displacements.as_ref()));
        warnings
    }

    fn remarks(&self, grid: &Grid) -> String {
        // Of matrices that are not at hand nothing is known.
        if self.unread().is_some() {
            return String::new();
        }
        let frequencies = checks::frequencies(&self.model, self.modes(grid));
        format!("{}{}{frequencies}", self.remarks, terms::unused_matrices(&self.files))
    }

    fn as_matrices(&self) -> Option<&MatrixModel> {
        Some(&self.model).filter(|model| model.has_matrices())
    }

    fn unread(&self) -> Option<&'static str> {
        (!self.model.has_matrices()).then_some(NOT_AT_HAND)
    }

    fn reduction(&self) -> Option<&Reduction> {
        self.tables.reduction.as_ref().map(Spanned::get_ref)
    }

    fn freeze(&self, document: &mut DocumentMut) -> String {
        terms::freeze(document, &self.files)
    }
}
