//! Arrays over the grid, with names that MATLAB accepts: what NPZ and MAT share.

use super::columns::ExportedSurface;
use crate::tables::finished::FinishedValues;

/// The name of the entry that names the axes.
pub const AXES: &str = "axes";

/// Longest name of a variable in MATLAB.
const LONGEST_NAME: usize = 63;

/// A named array.
pub struct NamedArray {
    /// Name, valid in MATLAB.
    pub name: String,
    /// How many values it has along each axis, slowest first; one length for the values of an axis.
    pub shape: Vec<usize>,
    /// Its values, the last axis fastest.
    pub values: Numbers,
}

/// The values of an array.
pub enum Numbers {
    /// Integers, none missing.
    Integer(Vec<i64>),
    /// Numbers, NaN where one is missing.
    Real(Vec<f64>),
}

/// The arrays of a surface.
pub struct GridArrays<'a> {
    surface: &'a ExportedSurface,
    /// The name of each column, valid in MATLAB.
    names: Vec<String>,
}

impl<'a> GridArrays<'a> {
    /// The arrays of a surface, each made when it is asked for.
    pub fn new(surface: &'a ExportedSurface) -> Self {
        let names = identifiers(surface.columns.iter().map(|column| column.name.as_str()));
        Self { surface, names }
    }

    /// The names of the axes, slowest first.
    pub fn axis_names(&self) -> Vec<&str> {
        let place = |name: &str| self.surface.columns.iter().position(|column| column.name == name);
        let places = self.surface.axes.iter().filter_map(|axis| place(&axis.name));
        places.map(|place| self.names[place].as_str()).collect()
    }

    /// The values of each axis, then each further column over the whole grid. The column of an axis is left out, as its
    /// name is taken by the values of the axis.
    pub fn arrays(&self) -> impl Iterator<Item = NamedArray> {
        let axes = self.surface.axes.iter().zip(self.axis_names()).map(|(axis, name)| NamedArray {
            name: name.to_owned(),
            shape: vec![axis.values.len()],
            values: Numbers::Real(axis.values.clone()),
        });
        let shape: Vec<usize> = self.surface.axes.iter().map(|axis| axis.values.len()).collect();
        let is_axis = |name: &str| self.surface.axes.iter().any(|axis| axis.name == name);
        let columns = self.surface.columns.iter().zip(&self.names).filter(move |(column, _)| !is_axis(&column.name));
        axes.chain(columns.map(move |(column, name)| NamedArray {
            name: name.clone(),
            shape: shape.clone(),
            values: Numbers::from(&column.values),
        }))
    }
}

impl From<&FinishedValues> for Numbers {
    fn from(values: &FinishedValues) -> Self {
        let known = |value: &Option<f64>| value.unwrap_or(f64::NAN);
        match values {
            FinishedValues::Real(values) => Self::Real(values.iter().map(known).collect()),
            FinishedValues::Integer(values) => match values.iter().copied().collect() {
                Some(integers) => Self::Integer(integers),
                None => Self::Real(values.iter().map(|value| value.map_or(f64::NAN, |value| value as f64)).collect()),
            },
        }
    }
}

impl Numbers {
    /// As real numbers. Counts are at most 10^15 and stay exact.
    pub fn into_reals(self) -> Vec<f64> {
        match self {
            Self::Integer(values) => values.into_iter().map(|value| value as f64).collect(),
            Self::Real(values) => values,
        }
    }
}

/// Names that MATLAB accepts, none twice: `_` in place of every character that is no letter of English, digit or
/// underscore.
fn identifiers<'a>(names: impl Iterator<Item = &'a str>) -> Vec<String> {
    let mut taken = vec![AXES.to_owned()];
    for name in names {
        let mut valid: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
        if !valid.starts_with(|c: char| c.is_ascii_alphabetic()) {
            valid.insert(0, 'x');
        }
        valid.truncate(LONGEST_NAME);
        let mut unique = valid.clone();
        let mut number = 1;
        while taken.contains(&unique) {
            number += 1;
            let ending = format!("_{number}");
            unique = valid.chars().take(LONGEST_NAME - ending.len()).collect::<String>() + &ending;
        }
        taken.push(unique);
    }
    taken.split_off(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_valid_in_matlab_and_unique() {
        let names = identifiers(["p_unstable", "std_pad.mass", "std_pad_mass", "_x", "5%", "axes", ""].into_iter());
        assert_eq!(names, ["p_unstable", "std_pad_mass", "std_pad_mass_2", "x_x", "x5_", "axes_2", "x"]);
        let long = "n".repeat(70);
        let names = identifiers([long.as_str(), long.as_str()].into_iter());
        assert_eq!(names, ["n".repeat(63), "n".repeat(61) + "_2"]);
    }

    #[test]
    fn integers_stay_integers_unless_one_is_missing() {
        let whole = Numbers::from(&FinishedValues::Integer(vec![Some(1), Some(2)]));
        assert!(matches!(whole, Numbers::Integer(values) if values == [1, 2]));
        let holed = Numbers::from(&FinishedValues::Integer(vec![Some(1), None]));
        assert!(matches!(holed, Numbers::Real(values) if values[0] == 1.0 && values[1].is_nan()));
    }
}
