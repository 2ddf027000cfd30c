//! Models given by matrices beside what others published of them: two masses, a drum brake, and three brakes of finite
//! elements, whose matrices are read from files.

mod entry;

mod model;

mod small;

mod brakes;

use std::path::Path;

use self::entry::{Entry, Kind};
use super::part::{Part, Table};
use crate::failure::Failure;

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
