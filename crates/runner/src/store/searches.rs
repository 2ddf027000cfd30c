//! Pieces of searches: their answers, in the order in which they were asked for.
//!
//! They are written to a folder of their own as pieces of samples are: the first line names what is searched, and each
//! further one has the cell and the number of a search, the number of its first answer, and answers by their bits.

use std::collections::BTreeMap;
use std::mem;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use serde::{Deserialize, Serialize};

use crate::evaluate::remembering::{INTERVAL, Keeper, Key};
use crate::failure::Failure;
use crate::files::folder::Folder;
use crate::output::warn_of;
use crate::store::piece::{self, Defect, is_piece_name, read_checked};

/// The first line of a piece.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
struct Owner {
    searches_of: String,
}

/// Answers as they are stored: cell, number of the search, number of the first answer, answers.
type Stored = (u64, u64, u64, Vec<u64>);

/// Searches whose answers are kept in a folder.
#[derive(Debug)]
pub struct Searches {
    /// The folder in which theirs is created when there is something to keep.
    parent: Folder,
    name: String,
    owner: Owner,
    known: BTreeMap<Key, Vec<f64>>,
    /// What is gathered, and since when.
    gathered: Mutex<(Vec<Stored>, Instant)>,
}

impl Searches {
    /// Those of `what` in the folder `name` of `parent`.
    ///
    /// # Errors
    /// A folder that cannot be read.
    pub fn read(parent: Folder, name: &str, what: String) -> Result<Self, Failure> {
        let owner = Owner { searches_of: what };
        let mut parts: BTreeMap<Key, Vec<(u64, Vec<u64>)>> = BTreeMap::new();
        let path = parent.path().join(name);
        let folder = parent.within_if_there(name).map_err(|error| Failure::reading(&path, error))?;
        if let Some(folder) = folder {
            let names = folder.names().map_err(|error| Failure::reading(&path, error))?;
            for name in names.iter().filter(|name| is_piece_name(name)) {
                let ignored = |why: &str| warn_of(&path.join(name), format_args!(" is ignored: {why}"));
                match read_checked(&folder, name).map(|bytes| decode(&bytes)) {
                    Ok(Ok((of, stored))) if of == owner => {
                        for (cell, number, first, answers) in stored {
                            parts.entry((cell, number)).or_default().push((first, answers));
                        }
                    }
                    Ok(Ok(_)) => ignored("it belongs to another job"),
                    Ok(Err(why)) | Err(Defect::Unread(why) | Defect::Damaged(why)) => ignored(&why),
                }
            }
        }
        let known = parts.into_iter().map(|(key, parts)| (key, joined(parts))).collect();
        let gathered = Mutex::new((Vec::new(), Instant::now()));
        Ok(Self { parent, name: name.to_owned(), owner, known, gathered })
    }

    /// Forgets the answers, of which none is needed any more.
    pub fn forget(&self) {
        *self.gathered.lock().unwrap_or_else(PoisonError::into_inner) = (Vec::new(), Instant::now());
        remove(&self.parent, &self.name);
    }

    /// Writes a piece; the search goes on without it.
    fn write(&self, stored: Vec<Stored>) {
        let written = self
            .parent
            .create_within(&self.name)
            .map_err(|error| Failure::writing(&self.parent.path().join(&self.name), error))
            .and_then(|folder| piece::publish(&folder, &self.owner, stored));
        if let Err(why) = written {
            warn_of(&self.parent.path().join(&self.name), format_args!(": {why}"));
        }
    }

    /// Gathers answers, and takes what is gathered if it is to be written.
    fn gathered(
        &self,
        (cell, number): Key,
        first: usize,
        answers: &[f64],
        is_due: impl Fn(Instant) -> bool,
    ) -> Vec<Stored> {
        let bits = answers.iter().map(|answer| answer.to_bits()).collect();
        let mut gathered = self.gathered.lock().unwrap_or_else(PoisonError::into_inner);
        gathered.0.push((cell, number, first as u64, bits));
        if is_due(gathered.1) { mem::replace(&mut *gathered, (Vec::new(), Instant::now())).0 } else { Vec::new() }
    }
}

/// Removes the answers of searches in the folder `name` of `parent`, if there are some.
pub fn remove(parent: &Folder, name: &str) {
    let Ok(Some(folder)) = parent.within_if_there(name) else { return };
    for name in folder.names().unwrap_or_default().iter().filter(|name| is_piece_name(name)) {
        let _ = folder.remove(name);
    }
    let _ = folder.remove_unfinished();
    // Other files in it keep it.
    let _ = parent.remove_directory(name);
}

impl Keeper for Searches {
    fn known(&self, key: Key) -> Vec<f64> {
        self.known.get(&key).cloned().unwrap_or_default()
    }

    fn keep(&self, key: Key, first: usize, answers: &[f64]) {
        self.write(self.gathered(key, first, answers, |_| true));
    }

    fn gather(&self, key: Key, first: usize, answers: &[f64]) {
        let stored = self.gathered(key, first, answers, |since| since.elapsed() >= INTERVAL);
        if !stored.is_empty() {
            self.write(stored);
        }
    }
}

impl Drop for Searches {
    fn drop(&mut self) {
        let (stored, _) =
            mem::replace(self.gathered.get_mut().unwrap_or_else(PoisonError::into_inner), (Vec::new(), Instant::now()));
        if !stored.is_empty() {
            self.write(stored);
        }
    }
}

/// What searches are of: those of a kind, for a job, which end in a file with this footer. A kind that asks in another
/// order has another name, as its answers are known by their order.
pub fn digest_of_searches(kind: &str, experiment: &str, footer: &[(&'static str, String)]) -> String {
    blake3::hash(format!("{kind} {experiment} {footer:?}").as_bytes()).to_hex().to_string()
}

fn decode(bytes: &[u8]) -> Result<(Owner, Vec<Stored>), String> {
    let (owner, lines) = piece::decode(bytes)?;
    Ok((owner, lines.collect::<Result<_, _>>()?))
}

/// The first answers of a search, up to the first that no part has. Parts of two processes overlap with the same
/// answers.
fn joined(mut parts: Vec<(u64, Vec<u64>)>) -> Vec<f64> {
    parts.sort_by_key(|(first, _)| *first);
    let mut all = Vec::new();
    for (first, answers) in parts {
        let Some(known) = (all.len() as u64).checked_sub(first) else { break };
        all.extend(answers.into_iter().skip(known as usize).map(f64::from_bits));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_joined_up_to_the_first_gap() {
        let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<u64>>();
        let parts =
            vec![(7, bits(&[9.0])), (2, bits(&[2.0, 3.0])), (0, bits(&[0.0, 1.0])), (1, bits(&[1.0, 2.0, 3.0, 4.0]))];
        assert_eq!(joined(parts), [0.0, 1.0, 2.0, 3.0, 4.0]);
        assert_eq!(joined(vec![(1, bits(&[1.0]))]), [0.0; 0]);
    }
}
