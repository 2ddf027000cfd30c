//! The matrices of the quadratic eigenproblem, products with them, and their factorisation.

use faer::linalg::solvers::SolveCore;
use faer::sparse::linalg::LuError;
use faer::sparse::linalg::solvers::{Lu, SymbolicLu};
use faer::sparse::{FaerError, SparseColMat, SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, c64};
use nalgebra::DMatrix;

use super::compensated::Compensated;
use crate::models::matrices::error::Error;
use crate::models::matrices::pair::Complex;
use crate::models::matrices::quadratic::{DenseQuadratic, QuadraticError};

/// Coefficients of the terms at one parameter point.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Coefficients {
    /// One for each damping matrix.
    pub damping: Vec<f64>,
    /// One for each stiffness matrix.
    pub stiffness: Vec<f64>,
}

/// Which eigenvectors: of the matrix or of its transpose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// `Q x`.
    Right,
    /// `Q^T y`.
    Left,
}

impl Coefficients {
    /// Those of the damping matrices, of which there are so many, followed by those of the stiffness matrices.
    #[must_use]
    pub fn split(all: &[f64], damping_terms: usize) -> Self {
        let (damping, stiffness) = all.split_at(damping_terms.min(all.len()));
        Self { damping: damping.to_vec(), stiffness: stiffness.to_vec() }
    }
}

/// A matrix by its places in the common pattern.
#[derive(Debug, Clone)]
struct Term {
    places: Vec<usize>,
    values: Vec<f64>,
}

impl Term {
    fn add_to(&self, sum: &mut [f64], factor: f64) {
        if factor != 0.0 {
            for (&place, value) in self.places.iter().zip(&self.values) {
                sum[place] += factor * value;
            }
        }
    }
}

/// `lambda^2 M + lambda sum_i c_i C_i + sum_j k_j K_j` with sparse real matrices in one common pattern.
///
/// The pattern is symmetric and has the diagonal. Its ordering against fill is found once.
#[derive(Debug, Clone)]
pub struct SparseQuadratic {
    size: usize,
    column_starts: Vec<usize>,
    rows: Vec<usize>,
    /// For each place the place of the transposed entry.
    mirrored: Vec<usize>,
    mass: Vec<f64>,
    damping: Vec<Term>,
    stiffness: Vec<Term>,
    symbolic: SymbolicLu<usize>,
}

impl SparseQuadratic {
    /// Takes the matrices.
    ///
    /// # Errors
    /// [`Error::Size`] if sizes differ, [`Error::NotFinite`], [`Error::Memory`].
    pub fn new(
        mass: &SparseColMat<usize, f64>,
        damping: &[SparseColMat<usize, f64>],
        stiffness: &[SparseColMat<usize, f64>],
    ) -> Result<Self, Error> {
        let size = mass.nrows();
        let all = || std::iter::once(mass).chain(damping).chain(stiffness);
        for matrix in all() {
            if matrix.nrows() != size || matrix.ncols() != size {
                return Err(Error::Size { rows: matrix.nrows(), columns: matrix.ncols(), size });
            }
            if !matrix.val().iter().all(|value| value.is_finite()) {
                return Err(Error::NotFinite);
            }
        }
        let (column_starts, rows) = common_pattern(size, all);
        let place = |row: usize, column: usize| {
            let start = column_starts[column];
            start + rows[start..column_starts[column + 1]].binary_search(&row).unwrap_or(0)
        };
        let term = |matrix: &SparseColMat<usize, f64>| {
            let mut term = Term { places: Vec::new(), values: Vec::new() };
            for entry in matrix.triplet_iter() {
                if *entry.val != 0.0 {
                    term.places.push(place(entry.row, entry.col));
                    term.values.push(*entry.val);
                }
            }
            term
        };
        let mut mass_values = vec![0.0; rows.len()];
        term(mass).add_to(&mut mass_values, 1.0);
        let mut mirrored = Vec::with_capacity(rows.len());
        for column in 0..size {
            mirrored
                .extend(rows[column_starts[column]..column_starts[column + 1]].iter().map(|&row| place(column, row)));
        }
        let (damping, stiffness) = (damping.iter().map(term).collect(), stiffness.iter().map(term).collect());
        let pattern = SymbolicSparseColMatRef::new_checked(size, size, &column_starts, None, &rows);
        let symbolic = SymbolicLu::try_new(pattern).map_err(|_| Error::Memory { size })?;
        Ok(Self { size, column_starts, rows, mirrored, mass: mass_values, damping, stiffness, symbolic })
    }

    /// The number of degrees of freedom.
    #[must_use]
    pub fn size(&self) -> usize {
        self.size
    }

    /// How many damping matrices there are.
    #[must_use]
    pub fn damping_terms(&self) -> usize {
        self.damping.len()
    }

    /// How many stiffness matrices there are.
    #[must_use]
    pub fn stiffness_terms(&self) -> usize {
        self.stiffness.len()
    }

    /// The matrices at one parameter point.
    ///
    /// # Errors
    /// [`Error::Coefficients`] if their numbers are not those of the matrices, [`Error::NotFinite`].
    pub fn at(&self, coefficients: &Coefficients) -> Result<Point<'_>, Error> {
        let sum = |terms: &[Term], factors: &[f64]| {
            if terms.len() != factors.len() {
                return Err(Error::Coefficients { given: factors.len(), expected: terms.len() });
            }
            if !factors.iter().all(|factor| factor.is_finite()) {
                return Err(Error::NotFinite);
            }
            let mut sum = vec![0.0; self.rows.len()];
            terms.iter().zip(factors).for_each(|(term, &factor)| term.add_to(&mut sum, factor));
            Ok(sum)
        };
        let damping = sum(&self.damping, &coefficients.damping)?;
        let stiffness = sum(&self.stiffness, &coefficients.stiffness)?;
        Ok(Point { family: self, coefficients: coefficients.clone(), damping, stiffness })
    }

    /// The same problem with dense matrices, without its rigid-body motions. Typical coefficients fix the unit of frequency.
    ///
    /// # Errors
    /// [`QuadraticError`].
    pub fn dense(&self, typical: &[f64]) -> Result<DenseQuadratic, QuadraticError> {
        let dense = |values: &[f64]| {
            let mut dense = DMatrix::zeros(self.size, self.size);
            let starts = self.column_starts.windows(2).enumerate();
            for (column, place) in
                starts.flat_map(|(column, ends)| (ends[0]..ends[1]).map(move |place| (column, place)))
            {
                dense[(self.rows[place], column)] = values[place];
            }
            dense
        };
        let of_terms = |terms: &[Term]| -> Vec<_> {
            let of_term = |term: &Term| {
                let mut values = vec![0.0; self.rows.len()];
                term.add_to(&mut values, 1.0);
                dense(&values)
            };
            terms.iter().map(of_term).collect()
        };
        let (damping, stiffness) = (of_terms(&self.damping), of_terms(&self.stiffness));
        Ok(DenseQuadratic::new(&dense(&self.mass), &damping, &stiffness, typical)?.without_rigid_body_motions().0)
    }

    /// The product of the mass matrix with a real vector.
    #[must_use]
    pub fn mass_times(&self, vector: &[f64]) -> Vec<f64> {
        self.real_product(&self.mass, vector, Side::Right)
    }

    /// The product of one stiffness matrix, or of its transpose, with a real vector.
    #[must_use]
    pub fn stiffness_times(&self, term: usize, vector: &[f64], side: Side) -> Vec<f64> {
        self.stiffness.get(term).map_or_else(Vec::new, |term| self.term_product(term, vector, side))
    }

    /// The product of one damping matrix with a real vector.
    #[must_use]
    pub fn damping_times(&self, term: usize, vector: &[f64], side: Side) -> Vec<f64> {
        self.damping.get(term).map_or_else(Vec::new, |term| self.term_product(term, vector, side))
    }

    /// Whether a stiffness matrix is symmetric to rounding.
    #[must_use]
    pub fn is_symmetric(&self, term: usize) -> bool {
        let Some(term) = self.stiffness.get(term) else { return true };
        let mut full = vec![0.0; self.rows.len()];
        term.add_to(&mut full, 1.0);
        let largest = full.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
        full.iter().zip(&self.mirrored).all(|(value, &other)| (value - full[other]).abs() <= 1e-12 * largest)
    }

    /// The sum of the stiffness matrices that are symmetric, if any is and counts.
    pub(super) fn symmetric_terms(&self, factors: &[f64]) -> Option<Vec<f64>> {
        let mut sum = vec![0.0; self.rows.len()];
        for (term, &factor) in factors.iter().enumerate().filter(|(term, _)| self.is_symmetric(*term)) {
            if let Some(term) = self.stiffness.get(term) {
                term.add_to(&mut sum, factor);
            }
        }
        sum.iter().any(|value| *value != 0.0).then_some(sum)
    }

    fn term_product(&self, term: &Term, vector: &[f64], side: Side) -> Vec<f64> {
        let mut full = vec![0.0; self.rows.len()];
        term.add_to(&mut full, 1.0);
        self.real_product(&full, vector, side)
    }

    pub(super) fn real_product(&self, values: &[f64], vector: &[f64], side: Side) -> Vec<f64> {
        let mut product = vec![0.0; self.size];
        for column in 0..self.size {
            let range = self.column_starts[column]..self.column_starts[column + 1];
            let entries = self.rows[range.clone()].iter().zip(&values[range]);
            match side {
                Side::Right => entries.for_each(|(&row, value)| product[row] += value * vector[column]),
                Side::Left => product[column] = entries.map(|(&row, value)| value * vector[row]).sum(),
            }
        }
        product
    }

    /// A real matrix in the common pattern, factorised.
    pub(super) fn factorise_real(&self, values: &[f64]) -> Result<Lu<usize, f64>, Error> {
        let pattern = SymbolicSparseColMatRef::new_checked(self.size, self.size, &self.column_starts, None, &self.rows);
        Lu::try_new_with_symbolic(self.symbolic.clone(), SparseColMatRef::new(pattern, values))
            .map_err(|error| self.factorisation_error(error, Complex::default()))
    }

    fn factorisation_error(&self, error: LuError, shift: Complex) -> Error {
        match error {
            LuError::Generic(FaerError::OutOfMemory) => Error::Memory { size: self.size },
            _ => Error::Singular { re: shift.re, im: shift.im },
        }
    }

    pub(super) fn mass_values(&self) -> &[f64] {
        &self.mass
    }

    pub(super) fn mirrored(&self) -> &[usize] {
        &self.mirrored
    }
}

/// The union of the patterns of the matrices and of their transposes, with the diagonal.
fn common_pattern<'a, I: Iterator<Item = &'a SparseColMat<usize, f64>>>(
    size: usize,
    all: impl Fn() -> I,
) -> (Vec<usize>, Vec<usize>) {
    let mut columns: Vec<Vec<usize>> = (0..size).map(|column| vec![column]).collect();
    for matrix in all() {
        for entry in matrix.triplet_iter() {
            if *entry.val != 0.0 {
                columns[entry.col].push(entry.row);
                columns[entry.row].push(entry.col);
            }
        }
        for column in &mut columns {
            column.sort_unstable();
            column.dedup();
        }
    }
    let mut starts = Vec::with_capacity(size + 1);
    starts.push(0);
    let mut rows = Vec::new();
    for column in columns {
        rows.extend(column);
        starts.push(rows.len());
    }
    (starts, rows)
}

/// The matrices at one parameter point: `Q(lambda) = lambda^2 M + lambda C + K`.
#[derive(Debug, Clone)]
pub struct Point<'a> {
    family: &'a SparseQuadratic,
    coefficients: Coefficients,
    damping: Vec<f64>,
    stiffness: Vec<f64>,
}

impl<'a> Point<'a> {
    /// The matrices of which this is one point.
    #[must_use]
    pub fn family(&self) -> &'a SparseQuadratic {
        self.family
    }

    /// The coefficients of the terms here.
    #[must_use]
    pub fn coefficients(&self) -> &Coefficients {
        &self.coefficients
    }

    pub(super) fn stiffness_values(&self) -> &[f64] {
        &self.stiffness
    }

    /// Writes `(a M + b C + c K) x`, or the same with transposed matrices, to `product`.
    pub fn combine(&self, [a, b, c]: [Complex; 3], vector: &[Complex], side: Side, product: &mut [Complex]) {
        let family = self.family;
        let entry = |place: usize| {
            let (m, d, k) = (family.mass[place], self.damping[place], self.stiffness[place]);
            Complex::new(a.re * m + b.re * d + c.re * k, a.im * m + b.im * d + c.im * k)
        };
        product.fill(Complex::default());
        for column in 0..family.size {
            let range = family.column_starts[column]..family.column_starts[column + 1];
            match side {
                Side::Right => {
                    let factor = vector[column];
                    range.for_each(|place| product[family.rows[place]] += entry(place) * factor);
                }
                Side::Left => product[column] = range.map(|place| entry(place) * vector[family.rows[place]]).sum(),
            }
        }
    }

    /// `Q(lambda) x`, or `Q(lambda)^T y`.
    #[must_use]
    pub fn residual(&self, eigenvalue: Complex, vector: &[Complex], side: Side) -> Vec<Complex> {
        let mut product = vec![Complex::default(); vector.len()];
        self.combine([eigenvalue * eigenvalue, eigenvalue, Complex::new(1.0, 0.0)], vector, side, &mut product);
        product
    }

    /// `y^T M x`, `y^T C x` and `y^T K x`, each rounded once.
    ///
    /// Summed in twice the precision, since the entries of a stiffness matrix cancel by many digits.
    #[must_use]
    pub fn forms(&self, left: &[Complex], right: &[Complex]) -> [Complex; 3] {
        let family = self.family;
        [&family.mass, &self.damping, &self.stiffness].map(|values| {
            let mut sum = [Compensated::default(); 2];
            for (column, x) in right.iter().enumerate() {
                let mut part = [Compensated::default(); 2];
                for place in family.column_starts[column]..family.column_starts[column + 1] {
                    if values[place] != 0.0 {
                        part[0].add_product(left[family.rows[place]].re, values[place]);
                        part[1].add_product(left[family.rows[place]].im, values[place]);
                    }
                }
                sum[0].add_scaled(part[0], x.re);
                sum[0].add_scaled(part[1], -x.im);
                sum[1].add_scaled(part[0], x.im);
                sum[1].add_scaled(part[1], x.re);
            }
            Complex::new(sum[0].value(), sum[1].value())
        })
    }

    /// Factorises `Q(shift)`.
    ///
    /// # Errors
    /// [`Error::Singular`] and [`Error::Memory`].
    pub fn factorise(&self, shift: Complex) -> Result<Factorisation, Error> {
        let family = self.family;
        let square = shift * shift;
        let values: Vec<c64> = (0..family.rows.len())
            .map(|place| {
                let (m, d, k) = (family.mass[place], self.damping[place], self.stiffness[place]);
                c64::new(square.re * m + shift.re * d + k, square.im * m + shift.im * d)
            })
            .collect();
        let (starts, rows) = (&family.column_starts, &family.rows);
        let pattern = SymbolicSparseColMatRef::new_checked(family.size, family.size, starts, None, rows);
        let lu = Lu::try_new_with_symbolic(family.symbolic.clone(), SparseColMatRef::new(pattern, values.as_slice()))
            .map_err(|error| family.factorisation_error(error, shift))?;
        Ok(Factorisation { lu, shift, coefficients: self.coefficients.clone() })
    }
}

/// `Q` at a shift and a parameter point, factorised as LU.
#[derive(Debug, Clone)]
pub struct Factorisation {
    lu: Lu<usize, c64>,
    shift: Complex,
    coefficients: Coefficients,
}

impl Factorisation {
    /// The shift.
    #[must_use]
    pub fn shift(&self) -> Complex {
        self.shift
    }

    /// The coefficients of the parameter point.
    #[must_use]
    pub fn coefficients(&self) -> &Coefficients {
        &self.coefficients
    }

    /// Solves `Q b = a` or `Q^T b = a` for several columns one after the other in `columns`, in place.
    ///
    /// # Errors
    /// [`Error::Singular`] if the solution is not finite.
    pub fn solve(&self, columns: &mut [Complex], size: usize, side: Side) -> Result<(), Error> {
        let count = columns.len() / size.max(1);
        let matrix = MatMut::from_column_major_slice_mut(columns, size, count);
        match side {
            Side::Right => self.lu.solve_in_place_with_conj(Conj::No, matrix),
            Side::Left => self.lu.solve_transpose_in_place_with_conj(Conj::No, matrix),
        }
        if columns.iter().all(|value| value.re.is_finite() && value.im.is_finite()) {
            Ok(())
        } else {
            Err(Error::Singular { re: self.shift.re, im: self.shift.im })
        }
    }
}
