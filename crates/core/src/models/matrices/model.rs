//! Models given by matrices as models of jobs: their parameters are the quantities, complex eigenvalues the criterion.

use std::sync::Arc;

use faer::sparse::SparseColMat;

use super::branches::Path;
use super::error::Error;
use super::factor::Factor;
use super::problem::{Problem, ProblemError, Solver};
use super::region::Region;
use super::samples::Samples;
use super::sweep::Sweep;
use crate::model::quantity::{Limits, Quantity};
use crate::model::{Configuration, Model, ModelError};

/// A matrix of a model, real and square.
pub type Matrix = SparseColMat<usize, f64>;

/// A matrix times a factor in parameters.
#[derive(Debug, Clone)]
pub struct Term {
    /// The matrix.
    pub matrix: Arc<Matrix>,
    /// Its factor.
    pub factor: Factor,
}

/// A named parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Its name in factors and jobs.
    pub name: String,
    /// Its expected value.
    pub value: f64,
    /// Its unit; `1` for a pure number.
    pub unit: String,
    /// Its name in pictures.
    pub label: String,
    /// Values that have a meaning; samples beyond are outside the model.
    pub range: Limits,
}

/// `M q'' + C(p) q' + K(p) q = 0`, with `C = sum_i c_i(p) C_i` and `K = sum_j k_j(p) K_j`.
#[derive(Debug, Clone)]
pub struct Matrices {
    /// M: symmetric and positive definite.
    pub mass: Arc<Matrix>,
    /// The terms of C.
    pub damping: Vec<Term>,
    /// The terms of K.
    pub stiffness: Vec<Term>,
    /// p, in the order in which factors know them.
    pub parameters: Vec<Parameter>,
}

impl Matrices {
    /// The number of degrees of freedom.
    #[must_use]
    pub fn size(&self) -> usize {
        self.mass.ncols()
    }

    /// The factors of the terms of C and then of K at these values of the parameters.
    #[must_use]
    pub fn coefficients(&self, parameters: &[f64]) -> Vec<f64> {
        self.damping.iter().chain(&self.stiffness).map(|term| term.factor.value(parameters)).collect()
    }

    /// The expected values of the parameters.
    #[must_use]
    pub fn expected(&self) -> Vec<f64> {
        self.parameters.iter().map(|parameter| parameter.value).collect()
    }

    /// The matrix of friction, as far as it can be told: the first stiffness term that is not symmetric and whose factor has
    /// one of these parameters; failing that the first term at all whose factor has one. The parameter, by its place.
    fn integrated(&self, parameters: &[usize]) -> Option<usize> {
        let of = |term: &Term| term.factor.parameters().find(|own| parameters.contains(own));
        let friction = self.stiffness.iter().filter(|term| !is_symmetric(&term.matrix)).find_map(of);
        friction.or_else(|| self.stiffness.iter().chain(&self.damping).find_map(of))
    }
}

/// Whether a matrix is symmetric to rounding.
fn is_symmetric(matrix: &Matrix) -> bool {
    let (mut asymmetry, mut largest) = (0.0_f64, 0.0_f64);
    for entry in matrix.triplet_iter() {
        let across = matrix.get(entry.col, entry.row).copied().unwrap_or(0.0);
        (asymmetry, largest) = (asymmetry.max((entry.val - across).abs()), largest.max(entry.val.abs()));
    }
    asymmetry <= 1e-9 * largest
}

/// The coefficients of matrices over one parameter.
pub(super) struct OverParameter<'a> {
    pub(super) matrices: &'a Matrices,
    /// The values of all parameters; that of the one counts for nothing.
    pub(super) values: &'a [f64],
    pub(super) place: usize,
}

impl OverParameter<'_> {
    fn each(&self, p: f64, of: impl Fn(&Factor, &[f64]) -> f64) -> Vec<f64> {
        let mut values = self.values.to_vec();
        values[self.place] = p;
        let Matrices { damping, stiffness, .. } = self.matrices;
        damping.iter().chain(stiffness).map(|term| of(&term.factor, &values)).collect()
    }
}

impl Path for OverParameter<'_> {
    fn coefficients(&self, p: f64) -> Vec<f64> {
        self.each(p, Factor::value)
    }

    fn derivative(&self, p: f64) -> Vec<f64> {
        self.each(p, |factor, values| factor.derivative(values, self.place))
    }
}

/// Which pairs make a sample unstable.
#[derive(Debug, Clone, PartialEq)]
pub struct ComplexEigenvalue {
    /// Bands of frequencies, Hz, with both ends.
    pub bands: Vec<[f64; 2]>,
    /// Pairs in a band are unstable with damping ratios below it.
    pub damping_ratio: f64,
}

/// The name of the quantity that says which band counts, where there are several: 0 for any, or the number of the band.
pub const BAND: &str = "band";

/// A model given by matrices, with its criterion.
#[derive(Debug, Clone)]
pub struct MatrixModel {
    matrices: Arc<Matrices>,
    problem: Problem,
    criterion: ComplexEigenvalue,
    quantities: Vec<Quantity>,
}

impl MatrixModel {
    /// A model whose samples are decided by all eigenvalues in the bands.
    ///
    /// # Errors
    /// As [`Problem::new`].
    pub fn new(matrices: Arc<Matrices>, criterion: ComplexEigenvalue, solver: Solver) -> Result<Self, ProblemError> {
        let problem = Problem::new(&matrices, solver)?;
        let quantities = quantities(&matrices.parameters, criterion.bands.len());
        Ok(Self { matrices, problem, criterion, quantities })
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

    /// The regions of the bands, rad/s.
    #[must_use]
    pub fn regions(&self) -> Vec<Region> {
        let region = |[lowest, highest]: &[f64; 2]| Region {
            lowest: std::f64::consts::TAU * lowest,
            highest: std::f64::consts::TAU * highest,
            damping_ratio: self.criterion.damping_ratio,
        };
        self.criterion.bands.iter().map(region).collect()
    }

    /// Where the number of unstable pairs of each band changes over the parameter at `place`, with these values of the others.
    ///
    /// # Errors
    /// As [`Problem::sweep`].
    pub fn sweeps(&self, parameters: &[f64], place: usize, within: [f64; 2]) -> Result<Vec<Sweep>, Error> {
        let path = OverParameter { matrices: &self.matrices, values: parameters, place };
        self.regions().iter().map(|region| self.problem.sweep(&path, region, within)).collect()
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
        let parameters = &expected[..self.matrices.parameters.len()];
        let factors = self.matrices.damping.iter().chain(&self.matrices.stiffness);
        for (term, value) in factors.zip(self.matrices.coefficients(parameters)) {
            if !value.is_finite() {
                let names: Vec<&str> = self.matrices.parameters.iter().map(|own| own.name.as_str()).collect();
                let text = term.factor.to_text(&names);
                return Err(ModelError(format!("the factor \"{text}\" is {value} at the values of this cell")));
            }
        }
        let mut regions = self.regions();
        if let Some(&band) = expected.get(parameters.len()) {
            if band.fract() != 0.0 || band < 0.0 || band > regions.len() as f64 {
                return Err(ModelError(format!("band = {band} is none of 0 (any) to {}", regions.len())));
            }
            if band > 0.0 {
                regions = vec![regions[band as usize - 1]];
            }
        }
        Ok(Samples::boxed(&self.matrices, &self.problem, regions, expected, varying, like))
    }

    /// That of friction, as far as it can be told.
    fn integrated(&self, inputs: &[usize]) -> Option<usize> {
        self.matrices.integrated(inputs)
    }

    fn outside_meaning(&self) -> &'static str {
        "parameters beyond their range"
    }
}
