//! The samples of one pass: their coefficients, one row for each.

use crate::models::pad_on_disc::degree_of_freedom::DegreeOfFreedom;
use crate::models::pad_on_disc::flexible_disc::contact::patch::LENGTH_UNIT;
use crate::models::pad_on_disc::flexible_disc::equations::friction_slope;
use crate::models::pad_on_disc::flexible_disc::geometry::DiscGeometry;
use crate::models::pad_on_disc::flexible_disc::linear_stability::LinearStability;
use crate::models::pad_on_disc::pad::equations::PadEquations;
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};
use crate::numerics::row::{Lanes, Row};

/// Samples that share a geometry, with the memory that deciding them takes.
#[derive(Debug, Clone)]
pub(crate) struct Batch<const L: usize> {
    pub coefficients: Coefficients<L>,
    pub work: Work<L>,
    pub findings: [Finding; L],
}

/// What the response says of a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Finding {
    /// Nothing: the eigenvalues decide.
    Open,
    /// Small motions die away.
    Stable,
    /// They grow, and would die away if friction did not fall with speed.
    FedByFriction,
}

impl Finding {
    /// The linear stability, if it was found.
    pub fn stability(self) -> Option<LinearStability> {
        match self {
            Self::Open => None,
            Self::Stable => Some(LinearStability::Stable),
            Self::FedByFriction => Some(LinearStability::Unstable { fed_by: DegreeOfFreedom::Tangential }),
        }
    }
}

/// What differs between samples of one geometry. The names are those of
/// [`FlexibleEquations`](crate::models::pad_on_disc::flexible_disc::equations::FlexibleEquations).
#[derive(Debug, Clone, Default)]
pub(crate) struct Coefficients<const L: usize> {
    pub pad: PadEquations<Row<L>>,
    pub preload: Row<L>,
    /// The friction coefficient of steady sliding, and how steeply it falls with the sliding speed.
    pub friction: Row<L>,
    pub friction_slope: Row<L>,
    /// Scaled frequency for one unit of lambda^2.
    pub frequency: Row<L>,
    /// Om.
    pub spin: Row<L>,
    /// h^3 k_en / (D b^2).
    pub compliance: Row<L>,
    pub disc_damping: Row<L>,
    pub tilt_scale: Row<L>,
    pub slope_scale: Row<L>,
}

/// Memory for one pass. Degrees of freedom are in the order of elimination: y, the amplitudes, phi, x.
#[derive(Debug, Clone)]
pub(crate) struct Work<const L: usize> {
    /// omega^2 - n^2 Om^2, 2 Om n with its direction, and h^3 k_en / (D m) of each amplitude.
    pub stiffness: Vec<Row<L>>,
    pub gyroscopic: Vec<Row<L>>,
    pub compliance: Vec<Row<L>>,
    /// Displacements and forces, and the step between them.
    pub q: Vec<Row<L>>,
    pub forces: Vec<Row<L>>,
    /// A of the module documentation, and the column of x in B.
    pub matrix: Vec<Row<L>>,
    pub damping_by_x: Vec<Row<L>>,
    /// Triangular factors: real ones of the search for the equilibrium, complex ones at a frequency.
    pub real: Vec<Row<L>>,
    pub imaginary: Vec<Row<L>>,
    /// w and z.
    pub left: Vec<(Row<L>, Row<L>)>,
    pub right: Vec<(Row<L>, Row<L>)>,
    pub further: Vec<(Row<L>, Row<L>)>,
}

impl<const L: usize> Batch<L> {
    /// Memory for samples of a geometry. Lanes that are not [set](Batch::set) decide nothing.
    pub fn new(geometry: &DiscGeometry) -> Self {
        let amplitudes = geometry.patch.even + geometry.patch.odd;
        let size = amplitudes + 3;
        let zero = Row::ZERO;
        let rows = |count: usize| vec![zero; count];
        Self {
            coefficients: Coefficients::default(),
            work: Work {
                stiffness: rows(amplitudes),
                gyroscopic: rows(amplitudes),
                compliance: rows(amplitudes),
                q: rows(size),
                forces: rows(size),
                matrix: rows(size * size),
                damping_by_x: rows(size),
                real: rows(size * size),
                imaginary: rows(size * size),
                left: vec![(zero, zero); size],
                right: vec![(zero, zero); size],
                further: vec![(zero, zero); size],
            },
            findings: [Finding::Open; L],
        }
    }

    /// Puts a sample into a lane. Its brake must have the geometry that the batch is decided with.
    pub fn set(&mut self, lane: usize, geometry: &DiscGeometry, brake: &PadOnDisc, inputs: RandomInputs) {
        let (pad, parameters) = (PadEquations::new(brake), brake.parameters());
        let disc = &parameters.disc;
        let slimness = disc.thickness / disc.outer_radius;
        let rigidity = brake.scales().flexural_rigidity;
        let gain = disc.thickness * disc.thickness * disc.thickness * parameters.stiffness.contact_normal / rigidity;
        let frequency = brake.frequency_per_parameter();
        let first = geometry.lowest_parameter * frequency;
        let to = &mut self.coefficients;
        to.pad.set(lane, &pad);
        to.preload.0[lane] = inputs.preload;
        to.friction.0[lane] = pad.steady_friction(inputs.static_friction);
        to.friction_slope.0[lane] = friction_slope(brake, &pad, inputs.static_friction);
        to.frequency.0[lane] = frequency;
        to.spin.0[lane] = parameters.operating_point.rotating_speed * brake.scales().time;
        to.compliance.0[lane] = gain / (disc.outer_radius * disc.outer_radius);
        to.disc_damping.0[lane] = 2.0 * disc.transverse_damping_ratio * first;
        to.tilt_scale.0[lane] = LENGTH_UNIT / slimness;
        to.slope_scale.0[lane] = slimness / LENGTH_UNIT;
    }
}
