//! What the searches of a command have found, kept beside the file that it writes.

use std::path::PathBuf;

use crate::evaluate::remembering::Keeper;
use crate::failure::{Advice, Failure};
use crate::files::folder::Folder;
use crate::shell::shown;
use crate::store::searches::Searches;

/// What is said after a signal to a command that writes no file.
pub fn nothing_was_written() -> Advice {
    "nothing was written; with --out FILE, what was found is kept".into()
}

/// The searches of a command.
pub struct KeptBeside {
    searches: Searches,
    path: PathBuf,
}

impl KeptBeside {
    /// Those of `what`, beside the file of a name in a directory.
    ///
    /// # Errors
    /// A directory that cannot be read.
    pub fn read((directory, name): &(PathBuf, String), what: String) -> Result<Self, Failure> {
        let parent = Folder::open(directory).map_err(|error| Failure::reading(directory, error))?;
        let name = format!("{name}.searches");
        Ok(Self { path: directory.join(&name), searches: Searches::read(parent, &name, what)? })
    }

    /// What keeps their answers.
    pub fn keeper(&self) -> &dyn Keeper {
        &self.searches
    }

    /// What is said after a signal.
    pub fn advice(&self) -> Advice {
        Advice::action(&format!(
            "what was found is kept in {}; give the same command again to go on",
            shown(&self.path)
        ))
    }

    /// Removes them, when the file is written.
    pub fn forget(self) {
        self.searches.forget();
    }
}
