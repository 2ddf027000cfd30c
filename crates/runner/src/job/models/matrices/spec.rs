//! The tables `[model]` and `[criterion]` of models given by matrices, as jobs have them.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stickslip_core::models::matrices::recorded::PairResult;
use toml::Spanned;

use super::terms::{TermSpec, TermsSpec};
use crate::job::model::OutsidePhysics;
use crate::job::reduction::Reduction;

/// A model given by matrices, M q'' + C(p) q' + K(p) q = 0: `kind = "matrices"`.
#[derive(Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MatrixModelSpec {
    /// M: symmetric, positive definite.
    #[schemars(with = "TermSpec")]
    pub mass: Option<Spanned<TermSpec>>,
    /// The terms of C, each a matrix times its factor.
    #[serde(default)]
    #[schemars(with = "Vec<TermSpec>", extend("default" = []))]
    pub damping: TermsSpec,
    /// The terms of K. That of friction is not symmetric.
    #[serde(default)]
    #[schemars(with = "Vec<TermSpec>")]
    pub stiffness: TermsSpec,
    /// The expected values of the parameters in the factors, by your names for them.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, ParameterSpec>", extend("default" = {}))]
    pub parameters: BTreeMap<Spanned<String>, Spanned<ParameterSpec>>,
    /// How these matrices compare with the full ones that they were reduced from; `stickslip reduce` writes it.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Reduction>")]
    pub reduction: Option<Spanned<Reduction>>,
}

/// The expected value of a parameter, or more about it.
#[derive(Debug, Clone, Deserialize, Serialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "it must be a number, or a table { value = 0.4, unit = \"1\", label = \"friction\", range = [0, 1] } of which all but value may be left out"
)]
pub enum ParameterSpec {
    /// The expected value.
    Value(f64),
    /// The expected value with unit, name in pictures and range.
    Described(DescribedParameter),
}

/// A parameter with what there is to say about it.
#[derive(Debug, Clone, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(inline)]
pub struct DescribedParameter {
    /// The expected value.
    pub value: f64,
    /// Its unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Its name in pictures.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
    /// Its least and largest value; samples beyond are outside the model.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
}

/// What decides whether a sample of a model given by matrices is stable.
#[derive(Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MatrixCriterionSpec {
    /// How a sample is decided.
    #[schemars(with = "MatrixKind")]
    pub kind: Option<Spanned<MatrixKind>>,
    /// The band in which pairs count, Hz, ends included; by default all frequencies.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<[f64; 2]>")]
    pub frequency: Option<Spanned<[f64; 2]>>,
    /// Several bands: a cell for each, and one for any of them (`band` 0).
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Vec<[f64; 2]>>")]
    pub bands: Option<Spanned<Vec<[f64; 2]>>>,
    /// Unstable is a pair in the band whose damping ratio, -Re / |lambda|, is below it by more than 1e-9.
    #[schemars(with = "Option<f64>", extend("default" = 0, "exclusiveMinimum" = -1, "exclusiveMaximum" = 1))]
    pub damping_ratio: Option<Spanned<f64>>,
    /// Whether motions count that no stiffness and no damping holds; with `matrices = "full"` they always do.
    #[schemars(with = "Option<RigidBodyMotions>", extend("default" = "left-out"))]
    pub rigid_body_motions: Option<Spanned<RigidBodyMotions>>,
    /// With which matrices eigenvalues are found.
    #[schemars(with = "Option<SolvedMatrices>", extend("default" = "dense"))]
    pub matrices: Option<Spanned<SolvedMatrices>>,
    /// What happens to samples with a parameter beyond its range.
    #[schemars(with = "Option<OutsidePhysics>", extend("default" = "stable"))]
    pub outside_physics: Option<Spanned<OutsidePhysics>>,
    /// Which of `"damping_ratio"`, `"growth_rate"` (1/s) and `"frequency"` (Hz) of the least stable pair in the band
    /// are written for each cell, as mean and quantiles. Not with `matrices = "full"`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Vec<PairRecord>>", extend("default" = []))]
    pub record: Option<Spanned<Vec<PairRecord>>>,
}

/// What a run can record of the least stable pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PairRecord {
    /// Its damping ratio.
    DampingRatio,
    /// Its growth rate, 1/s.
    GrowthRate,
    /// Its frequency, Hz.
    Frequency,
}

impl PairRecord {
    /// In words of the model.
    pub fn result(self) -> PairResult {
        match self {
            Self::DampingRatio => PairResult::DampingRatio,
            Self::GrowthRate => PairResult::GrowthRate,
            Self::Frequency => PairResult::Frequency,
        }
    }

    /// From words of the model.
    pub fn of(result: PairResult) -> Self {
        match result {
            PairResult::DampingRatio => Self::DampingRatio,
            PairResult::GrowthRate => Self::GrowthRate,
            PairResult::Frequency => Self::Frequency,
        }
    }
}

/// Whether rigid-body motions count.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RigidBodyMotions {
    /// They are found and left out.
    LeftOut,
    /// Their eigenvalues count as any others.
    Counted,
}

/// With which matrices eigenvalues are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SolvedMatrices {
    /// Dense ones, for up to 400 degrees of freedom.
    Dense,
    /// The full sparse ones, eigenvalues in the band: some 0.1 to 10 s for each sample, if one LU factorisation fits
    /// into memory.
    Full,
}

/// How a sample of a model given by matrices is decided.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MatrixKind {
    /// The eigenvalues of the quadratic problem.
    ComplexEigenvalue,
}
