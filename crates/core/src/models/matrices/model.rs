//! Models given by matrices as models of jobs: their parameters are the quantities, complex eigenvalues the criterion.

use std::sync::Arc;

use super::decide::region_at;
use super::problem::{Problem, ProblemError, Solver};
use super::recorded::PairResult;
use super::region::Region;
use super::samples::{Bands, Samples};
use super::terms::{Matrices, Parameter};
use crate::model::quantity::{Limits, Quantity};
use crate::model::recorded::RecordedResult;
use crate::model::{Configuration, Model, ModelError};

/// Which pairs make a sample unstable.
#[derive(Debug, Clone, PartialEq)]
pub struct ComplexEigenvalue {
    /// Bands of frequencies, Hz, with both ends.
    pub bands: Vec<[f64; 2]>,
    /// Pairs in a band are unstable with damping ratios below it.
    pub damping_ratio: f64,
    /// Whether the double zero eigenvalues of rigid-body motions count, which rounding makes stable or unstable.
    pub counts_rigid_body_motions: bool,
}

impl ComplexEigenvalue {
    /// The regions in rad/s: those of all bands for `band` 0, else that of one, counted from 1.
    #[must_use]
    pub fn regions(&self, band: usize) -> Vec<Region> {
        let chosen = self.bands.iter().enumerate().filter(|(place, _)| band == 0 || band == place + 1);
        let region = |(_, [lowest, highest]): (usize, &[f64; 2])| Region {
            lowest: std::f64::consts::TAU * lowest,
            highest: std::f64::consts::TAU * highest,
            damping_ratio: self.damping_ratio,
        };
        chosen.map(region).collect()
    }

    /// All bands, and those that count for `band`.
    fn bands_for(&self, band: usize) -> Bands {
        let is_own = |place: &usize| band == 0 || band == place + 1;
        let places = (0..self.bands.len()).filter(is_own).map(region_at).fold(0, |set, place| set | place);
        Bands { all: self.regions(0), own: self.regions(band), places }
    }
}

/// The name of the quantity that says which band counts, where there are several: 0 for any, or the number of the band.
pub const BAND: &str = "band";

/// Coordinates from which on a sample takes long.
const SLOW: usize = 40;

/// Coordinates from which on it takes more than 10 milliseconds by all eigenvalues.
const VERY_SLOW: usize = 200;

/// Why nothing is computed of a model whose matrices are [left out](MatrixModel::without_matrices).
pub const NOT_AT_HAND: &str = "the matrices of the model cannot be read as they were";

/// A model given by matrices, with its criterion.
#[derive(Debug, Clone)]
pub struct MatrixModel {
    matrices: Arc<Matrices>,
    /// Whether these are its own.
    has_matrices: bool,
    problem: Problem,
    /// Left out of the problem: displacements of the degrees of freedom.
    rigid_body_motions: Vec<Vec<f64>>,
    criterion: ComplexEigenvalue,
    quantities: Vec<Quantity>,
    /// Parameters in the order in which integrals prefer them, some of them repeatedly.
    integrated: Vec<usize>,
    recorded: Vec<PairResult>,
    /// What these are.
    described: Vec<RecordedResult>,
}

impl MatrixModel {
    /// A model whose samples are decided by all eigenvalues in the bands.
    ///
    /// # Errors
    /// As [`Problem::new`].
    pub fn new(matrices: Arc<Matrices>, criterion: ComplexEigenvalue, solver: Solver) -> Result<Self, ProblemError> {
        let mut problem = Problem::new(&matrices, solver)?;
        let mut rigid_body_motions = Vec::new();
        if !criterion.counts_rigid_body_motions {
            (problem, rigid_body_motions) = problem.without_rigid_body_motions();
        }
        let quantities = quantities(&matrices.parameters, criterion.bands.len());
        let integrated = matrices.integrated();
        Ok(Self {
            matrices,
            has_matrices: true,
            problem,
            rigid_body_motions,
            criterion,
            quantities,
            integrated,
            recorded: Vec::new(),
            described: Vec::new(),
        })
    }

    /// The same, which records these results, each once and in the order of [`PairResult`]. Only with dense matrices.
    #[must_use]
    pub fn recording(mut self, mut results: Vec<PairResult>) -> Self {
        results.sort();
        results.dedup();
        self.described = results.iter().map(|result| result.described()).collect();
        self.recorded = results;
        self
    }

    /// The same, whose matrices only stand for others that are not at hand: it says what it is, and nothing can be computed
    /// of it.
    #[must_use]
    pub fn without_matrices(self) -> Self {
        Self { has_matrices: false, ..self }
    }

    /// Whether something can be computed of it.
    #[must_use]
    pub fn has_matrices(&self) -> bool {
        self.has_matrices
    }

    /// What it records.
    #[must_use]
    pub fn recorded_results(&self) -> &[PairResult] {
        &self.recorded
    }

    /// The matrices.
    #[must_use]
    pub fn matrices(&self) -> &Arc<Matrices> {
        &self.matrices
    }

    /// The criterion.
    #[must_use]
    pub fn criterion(&self) -> &ComplexEigenvalue {
        &self.criterion
    }

    /// The eigenvalue problem.
    #[must_use]
    pub fn problem(&self) -> &Problem {
        &self.problem
    }

    /// The rigid-body motions that are left out, each as displacements of all degrees of freedom; with dense matrices.
    #[must_use]
    pub fn rigid_body_motions(&self) -> &[Vec<f64>] {
        &self.rigid_body_motions
    }

    /// The regions of the bands, rad/s.
    #[must_use]
    pub fn regions(&self) -> Vec<Region> {
        self.criterion.regions(0)
    }

    /// The expected values of all quantities, where nothing else is said.
    #[must_use]
    pub fn expected(&self) -> Vec<f64> {
        let mut expected = self.matrices.expected();
        expected.resize(self.quantities.len(), 0.0);
        expected
    }
}

/// The quantities of a model: its parameters, and where there are several bands, which one counts.
#[must_use]
pub fn quantities(parameters: &[Parameter], bands: usize) -> Vec<Quantity> {
    let of_parameter = |parameter: &Parameter| Quantity {
        label: parameter.label.clone().into(),
        unit: parameter.unit.clone().into(),
        limits: parameter.range,
        ..Quantity::new(parameter.name.clone(), "1", parameter.label.clone())
    };
    let band = (bands > 1).then(|| Quantity {
        limits: Limits::from(0.0, bands as f64),
        is_always_shown: true,
        only_selects: true,
        ..Quantity::new(BAND, "1", "band of frequencies, 0 for any")
    });
    parameters.iter().map(of_parameter).chain(band).collect()
}

impl Model for MatrixModel {
    fn quantities(&self) -> &[Quantity] {
        &self.quantities
    }

    fn configure(
        &self,
        expected: &[f64],
        varying: &[usize],
        like: Option<&dyn Configuration>,
    ) -> Result<Box<dyn Configuration>, ModelError> {
        if !self.has_matrices {
            return Err(ModelError(NOT_AT_HAND.to_owned()));
        }
        let parameters = &expected[..self.matrices.parameters.len()];
        let factors = self.matrices.damping.iter().chain(&self.matrices.stiffness);
        for (term, value) in factors.zip(self.matrices.coefficients(parameters)) {
            if !value.is_finite() {
                let names: Vec<&str> = self.matrices.parameters.iter().map(|own| own.name.as_str()).collect();
                let text = term.factor.to_text(&names);
                let value_of = |place: usize| format!("{} = {}", names[place], parameters[place]);
                let values: Vec<String> = term.factor.parameters().map(value_of).collect();
                return Err(ModelError(format!("the factor \"{text}\" is {value} at {}", values.join(", "))));
            }
        }
        let (band, bands) = (expected.get(parameters.len()).copied().unwrap_or(0.0), self.criterion.bands.len());
        if band.fract() != 0.0 || band < 0.0 || band > bands as f64 {
            return Err(ModelError(format!("band = {band} is none of 0 (any) to {bands}")));
        }
        let bands = self.criterion.bands_for(band as usize);
        Ok(Samples::boxed(&self.matrices, &self.problem, bands, &self.recorded, expected, varying, like))
    }

    fn has_slow_samples(&self) -> bool {
        self.matrices.size() >= SLOW
    }

    fn has_very_slow_samples(&self) -> bool {
        matches!(self.problem, Problem::Sparse(_)) || self.matrices.size() >= VERY_SLOW
    }

    /// That of friction, as far as it can be told.
    fn integrated(&self, inputs: &[usize]) -> Option<usize> {
        // One that stands in no factor makes no difference, whatever its value.
        self.integrated.iter().copied().find(|own| inputs.contains(own)).or(inputs.first().copied())
    }

    fn recorded(&self) -> &[RecordedResult] {
        &self.described
    }

    fn outside_meaning(&self) -> &'static str {
        "parameters beyond their range"
    }
}
