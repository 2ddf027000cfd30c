//! Columns of Parquet tables: their names, units, meanings, types and values.

use std::borrow::Cow;

/// What a column is called and holds.
pub struct Field {
    /// Name.
    pub name: Cow<'static, str>,
    /// Unit; `1` for a pure number.
    pub unit: Cow<'static, str>,
    /// Meaning.
    pub long_name: Cow<'static, str>,
    /// Type of the values.
    pub kind: Kind,
}

/// The type of the values of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Whole numbers of 64 bits.
    Integer,
    /// Numbers of 64 bits.
    Real,
    /// Numbers that may be unknown.
    OptionalReal,
    /// Texts.
    Text,
    /// Texts that may be missing.
    OptionalText,
    /// A list of whole numbers in each row.
    Integers,
    /// A list of numbers in each row.
    Reals,
}

/// The values of a column.
pub enum Values {
    /// Of [`Kind::Integer`].
    Integer(Vec<i64>),
    /// Of [`Kind::Real`].
    Real(Vec<f64>),
    /// Of [`Kind::OptionalReal`].
    OptionalReal(Vec<Option<f64>>),
    /// Of [`Kind::Text`].
    Text(Vec<String>),
    /// Of [`Kind::OptionalText`].
    OptionalText(Vec<Option<&'static str>>),
    /// Of [`Kind::Integers`].
    Integers(Lists<i64>),
    /// Of [`Kind::Reals`].
    Reals(Lists<f64>),
}

impl Values {
    /// Their type.
    pub fn kind(&self) -> Kind {
        match self {
            Self::Integer(_) => Kind::Integer,
            Self::Real(_) => Kind::Real,
            Self::OptionalReal(_) => Kind::OptionalReal,
            Self::Text(_) => Kind::Text,
            Self::OptionalText(_) => Kind::OptionalText,
            Self::Integers(_) => Kind::Integers,
            Self::Reals(_) => Kind::Reals,
        }
    }
}

/// A list of values in each row.
#[derive(Debug, PartialEq)]
pub struct Lists<T> {
    /// All values, row by row.
    values: Vec<T>,
    /// Where the list of each row ends in them.
    ends: Vec<usize>,
}

impl<T> Default for Lists<T> {
    fn default() -> Self {
        Self { values: Vec::new(), ends: Vec::new() }
    }
}

impl<T: Copy> Lists<T> {
    /// Adds a row.
    pub fn push(&mut self, list: impl IntoIterator<Item = T>) {
        self.values.extend(list);
        self.ends.push(self.values.len());
    }

    /// The number of rows.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// The list of a row.
    ///
    /// # Panics
    /// If there is no such row.
    pub fn row(&self, row: usize) -> &[T] {
        let start = row.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.values[start..self.ends[row]]
    }

    /// The lists of all rows.
    pub fn rows(&self) -> impl Iterator<Item = &[T]> {
        (0..self.len()).map(|row| self.row(row))
    }

    /// All values, row by row.
    pub fn values(&self) -> &[T] {
        &self.values
    }
}
