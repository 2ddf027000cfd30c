//! A number of others beside ours.

/// One number of others beside ours.
pub struct Entry {
    /// The problem and the quantity, with its unit.
    pub quantity: String,
    pub theirs: f64,
    pub ours: f64,
    /// Relative: the digits in which theirs is given.
    pub tolerance: f64,
    pub kind: Kind,
    /// The formula or the equation behind it.
    pub formula: &'static str,
    pub source: &'static str,
}

/// What a number of others is.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// By a formula.
    Formula,
    /// Printed by the authors of the model.
    Printed,
    /// Computed from the same matrices by another program.
    Computed,
    /// Of another model made from the same description. It is not reproduced.
    OtherModel,
}

impl Kind {
    pub fn name(self) -> &'static str {
        match self {
            Self::Formula => "formula",
            Self::Printed => "printed",
            Self::Computed => "computed",
            Self::OtherModel => "other model",
        }
    }
}

impl Entry {
    pub fn ratio(&self) -> f64 {
        self.ours / self.theirs
    }

    pub fn agrees(&self) -> bool {
        (self.ratio() - 1.0).abs() <= self.tolerance
    }

    pub fn row(&self) -> [String; 7] {
        let same = match (self.kind, self.agrees()) {
            (_, true) => "yes",
            (Kind::OtherModel, false) => "no",
            (_, false) => "MISS",
        };
        [
            self.quantity.clone(),
            significant(self.theirs),
            significant(self.ours),
            format!("{:.9}", self.ratio()),
            same.to_owned(),
            self.kind.name().to_owned(),
            format!("{}; {}", self.formula, self.source),
        ]
    }
}

/// Eleven significant digits at most.
fn significant(value: f64) -> String {
    let rounded: f64 = format!("{value:.10e}").parse().unwrap_or(value);
    if (1e-4..1e7).contains(&rounded.abs()) { format!("{rounded}") } else { format!("{rounded:e}") }
}
