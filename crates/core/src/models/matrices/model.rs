//! Models given by matrices as models of jobs: their parameters are the quantities, complex eigenvalues the criterion.

use std::any::Any;
use std::sync::{Arc, OnceLock};

use faer::sparse::SparseColMat;
use nalgebra::DMatrix;

use super::decide::Decider;
use super::factor::Factor;
use super::quadratic::{DenseQuadratic, QuadraticError};
use super::region::Region;
use super::series::ModeSeries;
use crate::model::decision::Decision;
use crate::model::quantity::{Limits, Quantity};
use crate::model::verdict::Verdict;
use crate::model::{Columns, Configuration, IsStopped, Model, ModelError};
use crate::numerics::eigenvalues::Eigenvalue;

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

    /// The eigenvalue problem with dense matrices.
    ///
    /// # Errors
    /// As [`DenseQuadratic::new`].
    pub fn dense(&self) -> Result<DenseQuadratic, QuadraticError> {
        let terms = |terms: &[Term]| terms.iter().map(|term| dense(&term.matrix)).collect::<Vec<_>>();
        let typical = self.coefficients(&self.expected());
        DenseQuadratic::new(&dense(&self.mass), &terms(&self.damping), &terms(&self.stiffness), &typical)
    }
}

fn dense(matrix: &Matrix) -> DMatrix<f64> {
    let mut dense = DMatrix::zeros(matrix.nrows(), matrix.ncols());
    for entry in matrix.triplet_iter() {
        dense[(entry.row, entry.col)] += *entry.val;
    }
    dense
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
    problem: Arc<DenseQuadratic>,
    criterion: ComplexEigenvalue,
    quantities: Vec<Quantity>,
}

impl MatrixModel {
    /// A model whose samples are decided by all eigenvalues in the bands.
    ///
    /// # Errors
    /// As [`DenseQuadratic::new`].
    pub fn new(matrices: Arc<Matrices>, criterion: ComplexEigenvalue) -> Result<Self, QuadraticError> {
        let problem = Arc::new(matrices.dense()?);
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
    pub fn problem(&self) -> &DenseQuadratic {
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
        let regions: Vec<Region> = regions.into_iter().map(|region| region.in_unit(self.problem.unit())).collect();
        let like = like.and_then(Samples::from_any).map(|like| like.shared.clone());
        let like = like.filter(|like| like.regions == regions && like.varying == varying);
        let shared = Shared {
            matrices: self.matrices.clone(),
            problem: self.problem.clone(),
            regions,
            expected: expected.to_vec(),
            varying: varying.to_vec(),
            series: OnceLock::new(),
        };
        Ok(Box::new(Samples { shared: Arc::new(shared), like, serves: OnceLock::new() }))
    }

    fn outside_meaning(&self) -> &'static str {
        "parameters beyond their range"
    }
}

/// What samples with the same expected values share.
struct Samples {
    shared: Arc<Shared>,
    /// Another configuration, whose series serves where it reaches well beyond the expected values.
    like: Option<Arc<Shared>>,
    /// Whether it does.
    serves: OnceLock<bool>,
}

/// A configuration with the series about its expected values, made when it is first wanted.
struct Shared {
    matrices: Arc<Matrices>,
    problem: Arc<DenseQuadratic>,
    /// In the unit of the problem.
    regions: Vec<Region>,
    expected: Vec<f64>,
    varying: Vec<usize>,
    series: OnceLock<Option<ModeSeries>>,
}

impl Shared {
    fn origin(&self) -> Vec<f64> {
        self.matrices.coefficients(&self.expected)
    }

    fn series(&self) -> Option<&ModeSeries> {
        let make = || {
            let terms = self.matrices.damping.iter().chain(&self.matrices.stiffness).enumerate();
            let changes = |term: &Term| term.factor.parameters().any(|own| self.varying.contains(&own));
            let changing: Vec<usize> = terms.filter(|(_, term)| changes(term)).map(|(place, _)| place).collect();
            ModeSeries::new(&self.problem, &self.origin(), &changing, &self.regions)
        };
        self.series.get_or_init(make).as_ref()
    }
}

impl Samples {
    fn from_any(configuration: &dyn Configuration) -> Option<&Self> {
        let any: &dyn Any = configuration;
        any.downcast_ref()
    }

    fn series(&self) -> Option<&ModeSeries> {
        let other = self.like.as_ref();
        let reaches =
            |other: &Arc<Shared>| other.series().is_some_and(|series| series.reaches_beyond(&self.shared.origin()));
        let serves = *self.serves.get_or_init(|| other.is_some_and(reaches));
        other.filter(|_| serves).unwrap_or(&self.shared).series()
    }

    fn coefficients(&self, samples: &Columns<'_>, sample: usize) -> Vec<f64> {
        self.shared.matrices.coefficients(&samples.complete(sample, &self.shared.expected, &self.shared.varying))
    }

    fn verdict(&self, coefficients: &[f64]) -> Verdict {
        if coefficients.iter().any(|value| !value.is_finite()) {
            return Verdict::Failed;
        }
        match Decider::new(&self.shared.problem, &self.shared.regions, self.series()).is_unstable(coefficients) {
            Some((true, _)) => Verdict::Unstable,
            Some((false, _)) => Verdict::Stable,
            None => Verdict::Failed,
        }
    }

    fn is_outside(&self, samples: &Columns<'_>, sample: usize) -> bool {
        let mut values = self.shared.varying.iter().zip(samples.sample(sample));
        values.any(|(&place, value)| {
            self.shared.matrices.parameters.get(place).is_some_and(|parameter| !parameter.range.contain(value))
        })
    }

    fn has_ranges(&self) -> bool {
        self.shared.varying.iter().any(|&place| {
            self.shared.matrices.parameters.get(place).is_some_and(|parameter| parameter.range != Limits::ANY)
        })
    }
}

impl Configuration for Samples {
    fn decide(&self, samples: &Columns<'_>, wanted: &[usize], is_stopped: IsStopped<'_>) -> Option<Vec<Decision>> {
        let decide = |&sample: &usize| {
            if is_stopped() {
                return None;
            }
            Some(match self.is_outside(samples, sample) {
                true => Decision::OUTSIDE_PHYSICS,
                false => self.verdict(&self.coefficients(samples, sample)).into(),
            })
        };
        wanted.iter().map(decide).collect()
    }

    fn outside(&self, samples: &Columns<'_>) -> Option<Vec<bool>> {
        self.has_ranges().then(|| (0..samples.len()).map(|sample| self.is_outside(samples, sample)).collect())
    }

    /// The smallest damping ratio in the bands less the threshold.
    fn limit_states(&self, samples: &Columns<'_>) -> Option<Vec<f64>> {
        let decider = Decider::new(&self.shared.problem, &self.shared.regions, self.series());
        let state = |sample: usize| {
            let coefficients = self.coefficients(samples, sample);
            decider.limit_state(&coefficients).unwrap_or(f64::NAN)
        };
        Some((0..samples.len()).map(state).collect())
    }

    fn unstable_frequencies(&self, samples: &Columns<'_>) -> Option<Vec<f64>> {
        let decider = Decider::new(&self.shared.problem, &self.shared.regions, self.series());
        let of_sample = |sample: usize| {
            let least = decider.least_damped(&self.coefficients(samples, sample));
            let in_unit = |value: Eigenvalue| value / self.shared.problem.unit();
            let is_unstable =
                |value: &Eigenvalue| self.shared.regions.iter().any(|region| region.contains(in_unit(*value)));
            let unstable = least.filter(|value| !self.is_outside(samples, sample) && is_unstable(value));
            unstable.map_or(f64::NAN, |value| value.im.abs() / std::f64::consts::TAU)
        };
        Some((0..samples.len()).map(of_sample).collect())
    }
}
