//! A matrix that was read from a file, with what the file says of it.

use faer::sparse::SparseColMat;

use super::entries::Built;
use crate::output::counted;

/// A degree of freedom: the number of its node, and its direction from 1.
pub type Place = (i64, u32);

/// How a file stores a matrix.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stored {
    /// Every entry: the matrix may be symmetric or not.
    General,
    /// One triangle of a symmetric matrix. There is no friction in it, as that is not symmetric.
    SymmetricTriangle,
    /// One triangle of a skew-symmetric matrix.
    SkewTriangle,
}

/// A matrix that was read: square, without zeros among its entries.
#[derive(Debug, Clone)]
pub struct ReadMatrix {
    pub matrix: SparseColMat<usize, f64>,
    pub stored: Stored,
    /// The degree of freedom of each row, where the file says it.
    pub degrees_of_freedom: Option<Vec<Place>>,
    /// Rows that the file marks as held. They have no entries; `align` takes them out of all matrices of a model.
    pub constrained: Vec<usize>,
    /// Whether the file says how many rows there are. Where it does not, rows without entries may be missing at the end.
    pub has_size: bool,
    /// What was done in reading, as sentences without a full stop.
    pub notes: Vec<String>,
    /// What may not be meant, in the same way: a user should look at it.
    pub doubts: Vec<String>,
}

impl ReadMatrix {
    /// A matrix that a job has by its rows.
    pub fn of_rows(matrix: SparseColMat<usize, f64>) -> Self {
        Self::new(Built { matrix, added: 0 }, Stored::General)
    }

    /// A matrix of which no more is known.
    pub fn new(built: Built, stored: Stored) -> Self {
        let mut notes = Vec::new();
        if stored == Stored::SymmetricTriangle {
            notes.push("the file has one triangle of a symmetric matrix; the other is its mirror image".to_owned());
        }
        if built.added > 0 {
            let entries = counted(built.added as u128, "entry is", "entries are");
            notes.push(format!("{entries} given more than once, and added up"));
        }
        let matrix = built.matrix;
        Self {
            matrix,
            stored,
            degrees_of_freedom: None,
            constrained: Vec::new(),
            has_size: true,
            notes,
            doubts: Vec::new(),
        }
    }
}
