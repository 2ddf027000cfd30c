//! Models given by matrices beside what others published of them: two masses, a drum brake, and three brakes of finite
//! elements, whose matrices are read from files.

mod model;

mod small;

mod brakes;

use std::path::Path;

use super::part::{Part, Table};
use crate::failure::Failure;

/// One number of others beside ours.
struct Entry {
    /// The problem and the quantity, with its unit.
    quantity: String,
    theirs: f64,
    ours: f64,
    /// Relative: the digits in which theirs is given.
    tolerance: f64,
    kind: Kind,
    /// The formula or the equation behind it.
    formula: &'static str,
    source: &'static str,
}

/// What a number of others is.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
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
    fn name(self) -> &'static str {
        match self {
            Self::Formula => "formula",
            Self::Printed => "printed",
            Self::Computed => "computed",
            Self::OtherModel => "other model",
        }
    }
}

impl Entry {
    fn ratio(&self) -> f64 {
        self.ours / self.theirs
    }

    fn agrees(&self) -> bool {
        (self.ratio() - 1.0).abs() <= self.tolerance
    }

    fn row(&self) -> [String; 7] {
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

/// `reproduce matrices`: files are looked for in `folder`.
pub fn problems(folder: &Path) -> Result<Vec<Part>, Failure> {
    let mut parts = vec![Part::text(
        "Models given by matrices, M q'' + C q' + K q = 0, beside what others published.\nNothing was fitted.\n\n",
    )];
    let mut misses = 0;
    let mut left_out: Vec<String> = Vec::new();
    let mut add = |title: &str, entries: Result<Vec<Entry>, brakes::Missing>| match entries {
        Ok(entries) => {
            misses += entries.iter().filter(|entry| entry.kind != Kind::OtherModel && !entry.agrees()).count();
            parts.push(Part::Table(table(title, &entries)));
            parts.push(Part::text("\n"));
        }
        Err(brakes::Missing(file)) => left_out.push(format!("  {title}: there is no {}\n", file.display())),
    };
    add("Two masses and a drum brake, by formulas", Ok(small::entries()?));
    add("NLEVP disk_brake100, 100 degrees of freedom", brakes::dense(folder)?);
    add("The brake of TU Berlin, 4669 degrees of freedom", brakes::of_tu_berlin(folder)?);
    add("A brake of our own, 3316 degrees of freedom", brakes::of_our_own(folder)?);
    let holds = if misses == 0 { "holds" } else { "DOES NOT HOLD" };
    parts.push(Part::text(format!(
        "  same: as many digits as theirs are given with. Of the same models, all: {holds}\n\
         \x20 other model: made from the same description, its matrices are not at hand\n"
    )));
    if !left_out.is_empty() {
        parts.push(Part::text(format!(
            "\nLeft out:\n{}The files are in the folder jobs of the sources and of the archive of the program;\n\
             name it with --matrices DIR.\n",
            left_out.concat()
        )));
    }
    Ok(parts)
}

fn table(title: &str, entries: &[Entry]) -> Table {
    let headings = ["quantity", "theirs", "ours", "ratio", "same", "theirs is", "equation and source"];
    Table { at_terminal: 6, ..Table::new(title, headings, entries.iter().map(Entry::row).collect()) }
}
