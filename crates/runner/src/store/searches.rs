//! Pieces of searches for rare events: answers of their integrands.
//!
//! They are written to `searches/` as those of samples are: the first line names the experiment, and each further one has the
//! cell and the number of a search, the number of its first answer, and answers by their bits.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::evaluate::remembering::{Keeper, Key};
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

/// The searches of a run.
#[derive(Debug)]
pub struct Searches {
    folder: Folder,
    owner: Owner,
    known: BTreeMap<Key, Vec<f64>>,
}

impl Searches {
    /// Those of an experiment in a directory of pieces.
    ///
    /// # Errors
    /// A directory that cannot be read.
    pub fn read(folder: Folder, experiment: String) -> Result<Self, Failure> {
        let owner = Owner { searches_of: experiment };
        let mut parts: BTreeMap<Key, Vec<(u64, Vec<u64>)>> = BTreeMap::new();
        let names = folder.names().map_err(|error| Failure::reading(folder.path(), error))?;
        for name in names.iter().filter(|name| is_piece_name(name)) {
            let ignored = |why: &str| warn_of(&folder.path().join(name), format_args!(" is ignored: {why}"));
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
        let known = parts.into_iter().map(|(key, parts)| (key, joined(parts))).collect();
        Ok(Self { folder, owner, known })
    }
}

impl Keeper for Searches {
    fn known(&self, key: Key) -> Vec<f64> {
        self.known.get(&key).cloned().unwrap_or_default()
    }

    fn keep(&self, (cell, number): Key, first: usize, answers: &[f64]) {
        let stored: Stored = (cell, number, first as u64, answers.iter().map(|answer| answer.to_bits()).collect());
        if let Err(why) = piece::publish(&self.folder, &self.owner, [stored]) {
            // The search goes on, and begins anew if it is interrupted.
            warn_of(self.folder.path(), format_args!(": {why}"));
        }
    }
}

fn decode(bytes: &[u8]) -> Result<(Owner, Vec<Stored>), String> {
    let (owner, lines) = piece::decode(bytes)?;
    Ok((owner, lines.collect::<Result<_, _>>()?))
}

/// The first answers of a search, up to the first that no part has. Parts of two processes overlap with the same answers.
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
