//! What a kind of model is to a job: how it is checked, and what the rest of the job asks it.

use std::fmt::Debug;
use std::path::Path;

use schemars::{Schema, SchemaGenerator};
use serde::{Deserialize, Serialize};
use stickslip_core::friction::measured_curve::SharedCurve;
use stickslip_core::model::quantity::Quantity;
use stickslip_core::model::{Model, ModelError};
use stickslip_core::models::matrices::model::MatrixModel;
use stickslip_core::models::pad_on_disc::model::PadModel;
use stickslip_core::models::pad_on_disc::parameters::ParameterError;
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;
use stickslip_sampler::grid::{Axis, Grid};
use toml::Spanned;
use toml::de::DeTable;

use super::axes_spec::{AxesSpec, AxisEntry};
use super::diagnosis::{Complaint, Complaints};
use super::keys::nearest;
use super::random::RandomInputSet;
use super::reduction::Reduction;
use super::spec::JobSpec;

/// What happens to samples outside the model, as [`Configuration::outside`] finds them.
///
/// [`Configuration::outside`]: stickslip_core::model::Configuration::outside
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum OutsidePhysics {
    /// They are decided as they are.
    #[default]
    Stable,
    /// They count as failed.
    Failed,
    /// They are moved to the edge of the model and decided there.
    Clamp,
}

/// A model of a job, checked.
pub trait JobModel: Debug + Send + Sync {
    /// The model.
    fn model(&self) -> &dyn Model;

    /// The expected values of all quantities that are no axes.
    fn expected(&self) -> Vec<f64>;

    /// The tables `[model]` and `[criterion]` written out, without values that are axes of the grid.
    fn tables(&self, grid: &Grid) -> Tables;

    /// What a user should know before the job runs, in sentences.
    fn warnings(&self, grid: &Grid, random: &RandomInputSet) -> Vec<String> {
        let _ = (grid, random);
        Vec::new()
    }

    /// The one of them about speeds at which steady sliding is unstable on a measured friction curve, and which lie
    /// between the values of an axis.
    fn hidden_speeds(&self, grid: &Grid) -> Option<String> {
        let _ = grid;
        None
    }

    /// What `check` says of the expected values, in lines.
    fn remarks(&self, grid: &Grid) -> String {
        let _ = grid;
        String::new()
    }

    /// Why there is no limit along an axis of this name, where the kind of model knows.
    fn no_limit_axis(&self, name: &str) -> Option<String> {
        let _ = name;
        None
    }

    /// Why a verdict map over the pair does not hold what a grid asks for.
    fn map_refusal(&self, grid: &Grid, random: &RandomInputSet) -> Option<String> {
        let _ = (grid, random);
        Some("this model has no verdict maps".to_owned())
    }

    /// The pad on the disc, for what is about it alone.
    fn as_pad(&self) -> Option<&PadModel> {
        None
    }

    /// The pad on a rigid disc that moves as this model does with these values of all quantities, if there is one.
    fn rigid_pad(&self, expected: &[f64]) -> Option<Result<PadOnDisc, ParameterError>> {
        let _ = expected;
        None
    }

    /// The measured friction curve, with the speeds at which steady sliding is unstable with these values of all
    /// quantities; `None` of another friction law.
    fn friction_curve(&self, expected: &[f64]) -> Option<FrictionCurve> {
        let _ = expected;
        None
    }

    /// The model given by matrices, for what is about its modes.
    fn as_matrices(&self) -> Option<&MatrixModel> {
        None
    }

    /// Why nothing can be computed of it, where it was [read without its files](Draft::leave_files).
    fn unread(&self) -> Option<&'static str> {
        None
    }

    /// What its reduction from a larger model costs, where it was reduced.
    fn reduction(&self) -> Option<&Reduction> {
        None
    }

    /// The text of the spec with what it names in files written out, where it names any; and what is said about that in
    /// comments.
    fn freeze(&self, document: &mut toml_edit::DocumentMut) -> String {
        let _ = document;
        String::new()
    }
}

/// A measured friction curve, and where steady sliding is unstable on it.
#[derive(Debug, Clone)]
pub struct FrictionCurve {
    /// The curve.
    pub curve: SharedCurve,
    /// The coefficient at rest to which it is scaled.
    pub static_coefficient: f64,
    /// How many standard deviations it is shifted by.
    pub band: f64,
    /// Sliding speeds between which it is, m/s.
    pub unstable: Vec<[f64; 2]>,
}

/// Tables of a job, written out.
#[derive(Debug, Clone, Serialize)]
pub struct Tables {
    /// `[model]`.
    pub model: toml::Table,
    /// `[criterion]`.
    pub criterion: toml::Table,
}

/// The parts of a job spec that any kind of model is checked with.
#[derive(Clone, Copy)]
pub struct Parts<'a> {
    /// The whole spec.
    pub spec: &'a JobSpec,
    /// The random inputs, if they were not refused.
    pub random: Option<&'a RandomInputSet>,
}

/// What is known of the boundary of stability.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Boundary {
    /// It is a curve over the pair of the model, in closed form.
    ClosedForm,
    /// Critical values of any one quantity can be found.
    CriticalValues,
    /// Verdicts alone.
    Verdicts,
}

/// A model that is being checked: its tables as written, and what is known of them so far. The methods are called in
/// the order in which they stand here; each complains about what it refuses.
pub trait Draft {
    /// Its quantities. They are known although values may be refused.
    fn quantities(&self) -> &[Quantity];

    /// What its criterion knows of the boundary of stability, if it says which one it is.
    fn boundary(&self) -> Option<Boundary>;

    /// The key of what happens to samples outside the model, if it is given.
    fn outside_physics(&self) -> Option<&Spanned<OutsidePhysics>>;

    /// The complaint about an axis that does not exist.
    fn unknown_axis(&self, name: &str) -> String {
        format!("there is no axis `{name}`{} (axes are {})", self.near(name), self.names())
    }

    /// The complaint about a random input that does not exist.
    fn unknown_input(&self, name: &str) -> String {
        format!("random.inputs: there is no input \"{name}\"{} (there are {})", self.near(name), self.names())
    }

    /// What may have been meant by a name, as the end of a message.
    fn near(&self, name: &str) -> String {
        let near = nearest(name, self.quantities().iter().map(|quantity| &*quantity.name));
        near.map_or(String::new(), |near| format!("; did you mean `{near}`?"))
    }

    /// All names of quantities.
    fn names(&self) -> String {
        self.quantities().iter().map(|quantity| &*quantity.name).collect::<Vec<_>>().join(", ")
    }

    /// The quantity that varies along an axis, by its place.
    fn place_of_axis(&self, name: &str) -> Option<usize> {
        self.quantities().iter().position(|quantity| quantity.name == name)
    }

    /// The quantity to write in place of a name that stands for its values in another unit, and why as a random input.
    fn instead_of(&self, name: &str) -> Option<(&'static str, &'static str)> {
        let _ = name;
        None
    }

    /// What may have been meant by a value of a quantity that was refused, as the end of a message.
    fn hint(&self, place: usize, value: f64) -> String {
        let _ = (place, value);
        String::new()
    }

    /// Leaves out the files that a run names and does not keep, such as those of matrices. Such a model says what it
    /// is, and nothing can be computed of it.
    fn leave_files(&mut self) {}

    /// Checks the values of `[model]`.
    fn check_values(&mut self, axes: &AxesSpec, folder: &Path, complaints: &mut Complaints);

    /// The expected values of all quantities, before there are axes; NaN where there is none. They stand in for those
    /// that are refused.
    fn expected(&self) -> Vec<f64>;

    /// The values of an axis of a quantity that is not written in its own unit, or of a value of `[model]` that is not;
    /// `None` where it is.
    fn converted(
        &self,
        place: usize,
        entry: Option<&AxisEntry>,
        axes: &[(usize, Axis)],
        spec: &AxesSpec,
    ) -> Option<Result<Axis, Complaint>> {
        let _ = (place, entry, axes, spec);
        None
    }

    /// Takes the axes: values that must agree do so in every cell. False if they do not.
    fn settle(&mut self, axes: &[(usize, Axis)], spec: &JobSpec, complaints: &mut Complaints) -> bool {
        let _ = (axes, spec, complaints);
        true
    }

    /// Checks that the configurations at the extremes of the grid exist, and that what varies has a meaning.
    fn check_grid(&self, grid: Option<&Grid>, parts: Parts<'_>, complaints: &mut Complaints) -> bool {
        let _ = (grid, parts, complaints);
        true
    }

    /// Checks the criterion. `None` if anything is refused, or without a grid.
    fn finish(
        self: Box<Self>,
        grid: Option<&Grid>,
        parts: Parts<'_>,
        complaints: &mut Complaints,
    ) -> Option<std::sync::Arc<dyn JobModel>>;
}

/// Reads the tables of a model out of the text of a job spec.
type ReadDraft = fn(&str, Spanned<DeTable<'_>>, &mut Complaints) -> Option<Box<dyn Draft>>;

/// A kind of model: the word behind `[model] kind`, and how its tables are read.
pub struct Kind {
    /// As in job specs.
    pub name: &'static str,
    /// What `[criterion] kind` may be.
    pub criteria: &'static [&'static str],
    /// Reads the tables `[model]` and `[criterion]` of a document, which has nothing else.
    pub draft: ReadDraft,
    /// The JSON schemas of the two tables.
    pub schemas: [fn(&mut SchemaGenerator) -> Schema; 2],
    /// The names of its axes, each with what it is.
    pub axes: fn() -> Vec<(String, String)>,
}

/// A value of a spec that stands in no text.
pub fn written<T>(value: T) -> Spanned<T> {
    Spanned::new(0..0, value)
}

/// A value with keys as a table.
pub fn table_of(value: &impl Serialize) -> toml::Table {
    toml::Table::try_from(value).unwrap_or_default()
}

/// Configurations at most at which what must hold for all of a job is checked.
const MOST_CORNERS: usize = 32;

/// Checks that a model can be configured at the extremes of the axes of a grid: at all combinations, or if these are
/// too many, at all smallest and all largest values.
pub fn configurable(model: &dyn Model, grid: &Grid) -> Result<(), ModelError> {
    let axes: Vec<(usize, [f64; 2])> = grid.axes.iter().map(|axis| (axis.quantity, axis.axis.extremes())).collect();
    let varying: Vec<usize> = (0..axes.len()).filter(|&i| axes[i].1[0] < axes[i].1[1]).collect();
    let inputs: Vec<usize> = model.pair().into_iter().flatten().collect();
    let all = u32::try_from(varying.len()).ok().and_then(|axes| 1_usize.checked_shl(axes));
    let corners = match all {
        Some(all) if all <= MOST_CORNERS => (0..all).collect(),
        _ => vec![0, usize::MAX],
    };
    corners.into_iter().try_for_each(|corner| {
        let mut expected = grid.expected.clone();
        for (i, (quantity, ends)) in axes.iter().enumerate() {
            let bit = varying.iter().position(|axis| *axis == i).map_or(0, |bit| corner >> bit.min(63) & 1);
            expected[*quantity] = ends[bit];
        }
        model.configure(&expected, &inputs, None).map(drop)
    })
}
