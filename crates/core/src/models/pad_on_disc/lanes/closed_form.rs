//! The closed form of stability for samples that each have a brake of their own.
//!
//! Steady sliding on a rigid disc is unstable exactly when falling friction feeds the tangential motion more than the
//! damper takes from it (equation 3.8, see [`crate::models::pad_on_disc::rigid_disc::stability`]). With `V = r_e Omega`, in SI and without any
//! scale,
//!
//! ```text
//! h (k_t2 / k_t1) k_en k_y / (k_en + k_y) Delta [(f_s - f_c) W(V) - B(V)] > c_x
//! ```
//!
//! where friction falls by `(f_s - f_c) W(V) - B(V)` for each m/s; `W` belongs to the falling part of the law and `B`
//! to the additional term ([`crate::friction`]). Here both sides are multiplied by all denominators, so that each side
//! is a product of parameters: those that all samples share are multiplied once, the others row by row. For the
//! exponent 1 there is one division, `V / v_s`. A single sample is decided by the same operations as many, so it has
//! the same verdict.
//!
//! [`PadOnDisc::stability_boundary`] rounds differently, by some units in the last place of its critical product.
//!
//! [`PadOnDisc::stability_boundary`]: crate::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc::stability_boundary

use crate::friction::law::LawKind;
use crate::friction::measured_curve::{NOTHING, SharedCurve};
use crate::friction::shape::Shape;
use crate::model::verdict::{Verdict, VerdictCounts};
use crate::models::pad_on_disc::lanes::dispatch::{InstructionSet, dispatch};
use crate::models::pad_on_disc::parameters::{EFFECTIVE_RADIUS_KEY, Parameters, Scalar};
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::RandomInputs;
use crate::models::pad_on_disc::rigid_disc::varying_brake::{HIGHEST_FRICTION, VaryingBrake};
use crate::numerics::exponential::exp;
use crate::numerics::logarithm::power;

/// Samples that are decided together.
const LANES: usize = 64;

type Row = [f64; LANES];

/// Values of a parameter within this factor of the shared one are within the range of numbers in which nothing derived
/// overflows or vanishes. Other samples are checked one by one.
const USUAL: f64 = 1e3;

/// What is derived from the shared parameters must lie this well inside the range of numbers for that.
const MODERATE: f64 = 1e150;

/// The closed form for brakes that differ from sample to sample.
#[derive(Debug, Clone)]
pub struct VaryingClosedForm {
    brake: VaryingBrake,
    checks: Vec<Check>,
    form: Form,
    set: InstructionSet,
}

/// Between which values a parameter needs no further check.
#[derive(Debug, Clone, Copy)]
struct Check {
    least: f64,
    most: f64,
}

/// A parameter of the closed form.
#[derive(Debug, Clone, Copy)]
enum Term {
    /// The same for all samples.
    Shared(f64),
    /// The column of this number.
    Column(usize),
}

/// The closed form, prepared.
#[derive(Debug, Clone)]
struct Form {
    /// Shared factors of the left and of the right side.
    driving: f64,
    damping: f64,
    /// Columns that multiply them.
    driving_columns: Vec<usize>,
    damping_columns: Vec<usize>,
    contact_normal: Term,
    calliper_normal: Term,
    effective_radius: Term,
    rotating_speed: Term,
    kinetic: Term,
    /// v_s, for a table 1 m/s.
    speed_scale: Term,
    shape: Shape,
    exponent: Term,
    /// The factors of the additional term.
    additional: [Term; 2],
    /// The measured curve, if it may be without friction at some speed.
    lacking: Option<SharedCurve>,
    /// Inner radius of the disc, inner and effective radius of the pad, outer radius of the disc, if any of them differs.
    radii: Option<[Term; 4]>,
}

/// Samples that are decided together, and what is found of them.
struct Block {
    preload: Row,
    static_friction: Row,
    /// A row for each scalar of the brake.
    rows: Vec<Row>,
    found: [u64; LANES],
}

/// What is found of a sample.
const STABLE: u64 = 0;
const UNSTABLE: u64 = 1;
const UNUSUAL: u64 = 2;

impl VaryingClosedForm {
    /// Prepares the closed form.
    #[must_use]
    pub fn new(brake: VaryingBrake) -> Self {
        let derived = brake.shared().derived_values();
        let is_moderate = derived.iter().all(|(_, value)| *value > 1.0 / MODERATE && *value < MODERATE);
        let check = |scalar: &&'static Scalar| {
            let value = scalar.value(brake.shared().parameters());
            let limits = scalar.limits;
            let most = if limits.includes_maximum { limits.maximum } else { limits.maximum.next_down() };
            // The two friction terms may be zero, and their limits are no extreme numbers.
            if !is_moderate {
                Check { least: f64::INFINITY, most: f64::NEG_INFINITY }
            } else if ["friction.viscous", "friction.band"].contains(&scalar.key) {
                Check { least: limits.minimum, most }
            } else {
                Check { least: (value / USUAL).max(limits.minimum), most: (value * USUAL).min(most) }
            }
        };
        let checks = brake.scalars().iter().map(check).collect();
        let form = Form::new(brake.shared().parameters(), brake.scalars());
        Self { brake, checks, form, set: InstructionSet::widest() }
    }

    /// The same, decided by the lanes of `set`, for tests.
    ///
    /// # Panics
    /// If this processor does not have `set`.
    #[must_use]
    #[doc(hidden)]
    pub fn with_instruction_set(mut self, set: InstructionSet) -> Self {
        assert!(InstructionSet::available().contains(&set), "this processor has no {set:?}");
        self.set = set;
        self
    }

    /// The brakes.
    #[must_use]
    pub fn brake(&self) -> &VaryingBrake {
        &self.brake
    }

    /// Appends the verdicts on samples with these preloads and static friction coefficients; `columns[i]` has their
    /// values of scalar `i` of the brake.
    ///
    /// A sample fails if a value is not admissible. Without preload, with `f_s < f_c`, or on a measured curve without friction
    /// at rest or at its speed, it is stable.
    ///
    /// # Panics
    /// If the columns differ in length, or there is not one for each scalar.
    pub fn decide(&self, preloads: &[f64], static_frictions: &[f64], columns: &[&[f64]], verdicts: &mut Vec<Verdict>) {
        self.for_each_block(preloads, static_frictions, columns, |block, count| {
            let verdict = |lane: usize| match block.found[lane] {
                STABLE => Verdict::Stable,
                UNSTABLE => Verdict::Unstable,
                _ => self.decide_unusual(block, lane),
            };
            verdicts.extend((0..count).map(verdict));
        });
    }

    /// The verdicts of [`VaryingClosedForm::decide`], counted.
    ///
    /// # Panics
    /// As there.
    #[must_use]
    pub fn count(&self, preloads: &[f64], static_frictions: &[f64], columns: &[&[f64]]) -> VerdictCounts {
        let mut counts = VerdictCounts::default();
        self.for_each_block(preloads, static_frictions, columns, |block, count| {
            let found = &block.found[..count];
            if found.iter().fold(0, |all, finding| all | finding) & UNUSUAL == 0 {
                let unstable: u64 = found.iter().sum();
                counts.unstable += unstable;
                counts.stable += count as u64 - unstable;
                return;
            }
            for (lane, finding) in found.iter().enumerate() {
                counts += match *finding {
                    STABLE => Verdict::Stable,
                    UNSTABLE => Verdict::Unstable,
                    _ => self.decide_unusual(block, lane),
                }
                .into();
            }
        });
        counts
    }

    /// Decides blocks of samples one after the other; `take` receives each with the number of its samples.
    fn for_each_block(
        &self,
        preloads: &[f64],
        static_frictions: &[f64],
        columns: &[&[f64]],
        mut take: impl FnMut(&Block, usize),
    ) {
        assert_eq!(columns.len(), self.checks.len(), "one column for each scalar");
        let len = preloads.len();
        assert!(static_frictions.len() == len && columns.iter().all(|column| column.len() == len));
        let zero = [0.0; LANES];
        let mut block =
            Block { preload: zero, static_friction: zero, rows: vec![zero; columns.len()], found: [STABLE; LANES] };
        for first in (0..len).step_by(LANES) {
            let count = LANES.min(len - first);
            let fill = |row: &mut Row, column: &[f64]| {
                row[..count].copy_from_slice(&column[first..first + count]);
                // The lanes that are left repeat a sample; what they find is dropped.
                row[count..].fill(column[first]);
            };
            fill(&mut block.preload, preloads);
            fill(&mut block.static_friction, static_frictions);
            for (row, column) in block.rows.iter_mut().zip(columns) {
                fill(row, column);
            }
            let (set, form, checks, samples) = (self.set, &self.form, &self.checks[..], &mut block);
            dispatch!(set, decide_block, form: &Form, checks: &[Check], samples: &mut Block);
            take(&block, count);
        }
    }

    /// Decides a sample with a value that is not admissible, or far from the shared one.
    #[cold]
    fn decide_unusual(&self, block: &Block, lane: usize) -> Verdict {
        let (preload, static_friction) = (block.preload[lane], block.static_friction[lane]);
        match self.brake.brake(RandomInputs { preload, static_friction }, |i| block.rows[i][lane]) {
            Some(brake) => brake.stability_boundary().verdict(preload, static_friction),
            None => Verdict::Failed,
        }
    }
}

impl Form {
    fn new(parameters: &Parameters, scalars: &[&'static Scalar]) -> Self {
        let term = |key: &str, shared: f64| {
            scalars.iter().position(|scalar| scalar.key == key).map_or(Term::Shared(shared), Term::Column)
        };
        let Parameters { disc, pad, stiffness, damping, friction, operating_point } = parameters;
        let contact_normal = term("stiffness.contact_normal", stiffness.contact_normal);
        let calliper_normal = term("stiffness.calliper_normal", stiffness.calliper_normal);
        let stribeck_velocity = term("friction.stribeck_velocity", friction.stribeck_velocity);
        let viscous = term("friction.viscous", friction.viscous);
        let exponent = term("friction.stribeck_exponent", friction.stribeck_exponent);
        let (shape, speed_scale, additional) = match (friction.law, exponent) {
            (LawKind::Stribeck, Term::Shared(exponent)) => {
                (Shape::of_stribeck(exponent), stribeck_velocity, [viscous, stribeck_velocity])
            }
            (LawKind::Stribeck, Term::Column(_)) => (Shape::Stribeck, stribeck_velocity, [viscous, stribeck_velocity]),
            (LawKind::Rational, _) => (Shape::Rational, stribeck_velocity, [viscous, stribeck_velocity]),
            (LawKind::Table(curve), _) => {
                (Shape::Table(curve), Term::Shared(1.0), [term("friction.band", friction.band), Term::Shared(1.0)])
            }
        };
        let outer_radius = term("disc.outer_radius", disc.outer_radius);
        let effective_radius = match term(EFFECTIVE_RADIUS_KEY, parameters.effective_radius()) {
            Term::Shared(_) if pad.effective_radius.is_none() => outer_radius,
            of_its_own => of_its_own,
        };
        let driving = [
            term("disc.thickness", disc.thickness),
            term("stiffness.contact_tangential_2", stiffness.contact_tangential_2),
            contact_normal,
            calliper_normal,
        ];
        let damping = [
            term("damping.tangential", damping.tangential),
            term("stiffness.contact_tangential_1", stiffness.contact_tangential_1),
            speed_scale,
        ];
        let radii = [
            term("disc.inner_radius", disc.inner_radius),
            term("pad.inner_radius", pad.inner_radius),
            effective_radius,
            outer_radius,
        ];
        let differs = radii.iter().any(|term| matches!(term, Term::Column(_)));
        Self {
            driving: shared_product(&driving),
            damping: shared_product(&damping),
            driving_columns: columns_of(&driving),
            damping_columns: columns_of(&damping),
            contact_normal,
            calliper_normal,
            effective_radius,
            rotating_speed: term("operating_point.rotating_speed", operating_point.rotating_speed),
            kinetic: term("friction.kinetic_coefficient", friction.kinetic_coefficient),
            speed_scale,
            shape,
            exponent,
            additional,
            lacking: friction
                .law
                .table()
                .copied()
                .filter(|curve| !matches!(additional[0], Term::Shared(0.0)) || curve.lower_bound(1.0, 0.0) <= NOTHING),
            radii: differs.then_some(radii),
        }
    }
}

fn shared_product(terms: &[Term]) -> f64 {
    terms.iter().map(|term| if let Term::Shared(value) = term { *value } else { 1.0 }).product()
}

fn columns_of(terms: &[Term]) -> Vec<usize> {
    terms.iter().filter_map(|term| if let Term::Column(column) = term { Some(*column) } else { None }).collect()
}

impl Term {
    #[inline(always)]
    fn row(self, rows: &[Row]) -> Row {
        match self {
            Self::Shared(value) => [value; LANES],
            Self::Column(column) => rows[column],
        }
    }
}

/// Decides the samples of a block.
#[inline(always)]
fn decide_block(form: &Form, checks: &[Check], block: &mut Block) {
    let Block { preload, static_friction, rows, found } = block;
    let mut usual = [1_u64; LANES];
    for (check, row) in checks.iter().zip(&*rows) {
        for l in 0..LANES {
            usual[l] &= u64::from((row[l] >= check.least) & (row[l] <= check.most));
        }
    }
    for l in 0..LANES {
        usual[l] &= u64::from(static_friction[l] <= HIGHEST_FRICTION);
    }
    if let Some(radii) = form.radii {
        let [inner, of_pad, effective, outer] = radii.map(|term| term.row(rows));
        for l in 0..LANES {
            let is_a_ring = (inner[l] < outer[l]) & (inner[l] <= of_pad[l]) & (of_pad[l] < outer[l]);
            usual[l] &= u64::from(is_a_ring & (of_pad[l] <= effective[l]) & (effective[l] <= outer[l]));
        }
    }

    let (radius, speed, scale) =
        (form.effective_radius.row(rows), form.rotating_speed.row(rows), form.speed_scale.row(rows));
    let mut ratio = [0.0; LANES];
    for l in 0..LANES {
        ratio[l] = radius[l] * speed[l] / scale[l];
    }
    let (mut weakening, mut rise) = ([0.0; LANES], [0.0; LANES]);
    slopes(form.shape, &form.exponent.row(rows), &ratio, &mut weakening, &mut rise);
    let kinetic = form.kinetic.row(rows);
    for l in 0..LANES {
        weakening[l] *= static_friction[l] - kinetic[l];
    }
    // Below this static friction a sample is outside physics.
    let mut least = kinetic;
    let [first, second] = form.additional;
    if !matches!(first, Term::Shared(0.0)) {
        let (first, second) = (first.row(rows), second.row(rows));
        for l in 0..LANES {
            let factor = first[l] * second[l];
            weakening[l] -= factor * rise[l];
        }
    }
    if let Some(curve) = form.lacking {
        let shift = first.row(rows);
        for l in 0..LANES {
            least[l] = curve.least_at_rest(ratio[l], shift[l]);
        }
    }
    let (contact, calliper) = (form.contact_normal.row(rows), form.calliper_normal.row(rows));
    let (mut driving, mut damping) = ([0.0; LANES], [0.0; LANES]);
    for l in 0..LANES {
        driving[l] = form.driving * preload[l] * weakening[l];
        damping[l] = form.damping * (contact[l] + calliper[l]);
    }
    for &column in &form.driving_columns {
        for l in 0..LANES {
            driving[l] *= rows[column][l];
        }
    }
    for &column in &form.damping_columns {
        for l in 0..LANES {
            damping[l] *= rows[column][l];
        }
    }
    for l in 0..LANES {
        let unstable = (preload[l] > 0.0) & (static_friction[l] >= least[l]) & (driving[l] > damping[l]);
        found[l] = if usual[l] == 0 { UNUSUAL } else { u64::from(unstable) };
    }
}

/// The slopes of the two parts of a law at `r`, the speed over its scale: the fall of the first and the rise of the
/// second.
#[inline(always)]
fn slopes(shape: Shape, exponent: &Row, ratio: &Row, fall: &mut Row, rise: &mut Row) {
    *rise = [1.0; LANES];
    match shape {
        Shape::Tustin => {
            for l in 0..LANES {
                fall[l] = exp(-ratio[l]);
            }
        }
        Shape::Gaussian => {
            for l in 0..LANES {
                fall[l] = 2.0 * ratio[l] * exp(-(ratio[l] * ratio[l]));
            }
        }
        Shape::Stribeck => {
            for l in 0..LANES {
                let power = power(ratio[l], exponent[l]);
                fall[l] = exponent[l] * power / ratio[l] * exp(-power);
            }
        }
        Shape::Rational => {
            for l in 0..LANES {
                fall[l] = 1.0 / ((1.0 + ratio[l]) * (1.0 + ratio[l]));
            }
        }
        Shape::Table(curve) => {
            for l in 0..LANES {
                let (by_shape, by_deviation) = curve.slopes(ratio[l]);
                (fall[l], rise[l]) = (-by_shape, by_deviation);
            }
        }
    }
}

#[cfg(test)]
mod tests;
