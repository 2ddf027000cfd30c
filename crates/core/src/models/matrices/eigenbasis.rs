//! All eigenvalues of a quadratic problem with their vectors, in which changes of its matrices are written.

use nalgebra::linalg::balancing::balance_parlett_reinsch;
use nalgebra::{Complex, DMatrix, DVector};

use super::quadratic::{DenseQuadratic, Quadratic, transposed_product};
use super::region::{magnitude, square_root};
use crate::numerics::eigenvalues::Eigenvalue;
use crate::numerics::schur::real_schur;

pub(super) type ComplexMatrix = DMatrix<Complex<f64>>;

/// The condition number of an eigenvalue up to which vectors are taken for a basis.
pub(super) const WORST_CONDITION: f64 = 1e6;

/// The eigenvalues of `z' = A z` with `z = (q, q')`, and their right and left vectors: `W A V = diag(lambda)`, `W V = 1`.
pub(super) struct Eigenbasis {
    /// The eigenvalues.
    pub(super) eigenvalues: Vec<Eigenvalue>,
    /// The upper half of V: displacements, a column for each eigenvalue.
    pub(super) right: Split,
    /// The right half of W, a row for each eigenvalue. Its rows are the left vectors of the quadratic problem.
    pub(super) left: Split,
}

/// `A X = X diag(lambda)` and `Y X = 1` for the matrix of first order of a problem.
pub(super) struct Decomposition {
    pub(super) eigenvalues: Vec<Eigenvalue>,
    pub(super) vectors: ComplexMatrix,
    pub(super) inverse: ComplexMatrix,
}

impl Decomposition {
    /// The decomposition in coordinates scaled by powers of two, in which soft directions beside stiff ones keep their digits. The
    /// vectors have all coordinates and their rates; rows of X, and columns of Y, are zero for coordinates that are not in the state.
    pub(super) fn balanced(problem: &Quadratic) -> Option<Self> {
        let mut companion = problem.companion();
        if companion.iter().any(|value| !value.is_finite()) {
            return None;
        }
        let scales = balance_parlett_reinsch(&mut companion);
        let mut found = Self::new(&companion)?;
        for (i, scale) in scales.iter().enumerate() {
            found.vectors.row_mut(i).scale_mut(*scale);
            found.inverse.column_mut(i).unscale_mut(*scale);
        }
        found.vectors = found.vectors.insert_rows(0, problem.unheld, Complex::from(0.0));
        found.inverse = found.inverse.insert_columns(0, problem.unheld, Complex::from(0.0));
        Some(found)
    }

    /// The decomposition of a matrix; `None` if there is none.
    fn new(companion: &DMatrix<f64>) -> Option<Self> {
        if companion.is_empty() || companion.iter().any(|value| !value.is_finite()) {
            return None;
        }
        let (schur_vectors, triangle) = real_schur(companion)?;
        let (schur_vectors, triangle) = complex_schur(&schur_vectors, &triangle);
        let of_triangle = vectors_of_triangle(&triangle);
        let schur_vectors = Split::new(&schur_vectors);
        let vectors = schur_vectors.times(&Split::new(&of_triangle));
        let inverse = schur_vectors.times(&Split::new(&inverse_of_triangle(&of_triangle).adjoint())).adjoint();
        Some(Self { eigenvalues: triangle.diagonal().iter().copied().collect(), vectors, inverse })
    }
}

impl Eigenbasis {
    /// The basis of a problem; `None` if there is none, or one so skew that it says little about what is near.
    pub(super) fn new(problem: &Quadratic) -> Option<Self> {
        let (basis, conditions) = Self::with_conditions(problem)?;
        conditions.into_iter().all(|condition| condition <= WORST_CONDITION).then_some(basis)
    }

    /// The basis of a problem and the condition numbers of its eigenvalues; `None` if there is none.
    pub(super) fn with_conditions(problem: &Quadratic) -> Option<(Self, Vec<f64>)> {
        let Decomposition { eigenvalues, vectors, inverse } = Decomposition::new(&problem.companion())?;
        let (states, size) = (eigenvalues.len(), problem.stiffness.nrows());
        let held = size - problem.unheld;
        let length =
            |values: &mut dyn Iterator<Item = Complex<f64>>| values.map(|value| value.norm_sqr()).sum::<f64>().sqrt();
        let condition =
            |i: usize| length(&mut inverse.row(i).iter().copied()) * length(&mut vectors.column(i).iter().copied());
        let basis = Self {
            right: Split::new(&displacements(&eigenvalues, &vectors, size)),
            left: Split::new(&inverse.columns(held, size).into_owned()),
            eigenvalues,
        };
        Some((basis, (0..states).map(condition).collect()))
    }

    /// What a unit of a coefficient changes, in this basis: `W (dA / dc) V`.
    pub(super) fn change(&self, problem: &DenseQuadratic, coefficient: usize) -> ComplexMatrix {
        let mut moved = complex(&self.right.re, &self.right.im);
        if problem.is_damping(coefficient) {
            for (mut column, eigenvalue) in moved.column_iter_mut().zip(&self.eigenvalues) {
                column *= *eigenvalue;
            }
        }
        let term = problem.term(coefficient);
        let moved = Split::new(&moved);
        let forces = Split { re: -(term * moved.re), im: -(term * moved.im) };
        self.left.times(&forces)
    }
}

/// The displacements of so many coordinates; of those that are not in the state from their rates.
fn displacements(eigenvalues: &[Eigenvalue], vectors: &ComplexMatrix, size: usize) -> ComplexMatrix {
    let held = vectors.nrows() - size;
    ComplexMatrix::from_fn(size, vectors.ncols(), |row, column| match row.checked_sub(size - held) {
        Some(row) => vectors[(row, column)],
        None if eigenvalues[column] == Complex::from(0.0) => Complex::from(0.0),
        None => vectors[(held + row, column)] / eigenvalues[column],
    })
}

fn complex(re: &DMatrix<f64>, im: &DMatrix<f64>) -> ComplexMatrix {
    re.zip_map(im, Complex::new)
}

/// A complex matrix as two real ones, whose products are faster.
pub(super) struct Split {
    re: DMatrix<f64>,
    im: DMatrix<f64>,
}

impl Split {
    pub(super) fn new(matrix: &ComplexMatrix) -> Self {
        Self { re: matrix.map(|value| value.re), im: matrix.map(|value| value.im) }
    }

    /// The product with another matrix from the right.
    pub(super) fn times(&self, other: &Self) -> ComplexMatrix {
        complex(
            &(product(&self.re, &other.re) - product(&self.im, &other.im)),
            &(product(&self.re, &other.im) + product(&self.im, &other.re)),
        )
    }

    /// `-K q - C q'` of each column `(q, q')`, the lower half of `A X` with these as X.
    pub(super) fn forces(&self, problem: &Quadratic) -> Self {
        let of = |x: &DMatrix<f64>| {
            let size = x.nrows() / 2;
            let [upper, lower] = [0, size].map(|from| x.rows(from, size).into_owned());
            -(product(&problem.stiffness, &upper) + product(&problem.damping, &lower))
        };
        Self { re: of(&self.re), im: of(&self.im) }
    }

    /// The product with a vector from the right.
    pub(super) fn times_vector(&self, vector: &DVector<Complex<f64>>) -> DVector<Complex<f64>> {
        let mut sum = DVector::zeros(self.re.nrows());
        for ((re, im), x) in self.re.column_iter().zip(self.im.column_iter()).zip(vector.iter()) {
            let entries = re.as_slice().iter().zip(im.as_slice());
            sum.iter_mut().zip(entries).for_each(|(sum, (re, im))| *sum += x * Complex::new(*re, *im));
        }
        sum
    }

    /// The transpose times a vector.
    pub(super) fn transposed_times_vector(&self, vector: &DVector<Complex<f64>>) -> DVector<Complex<f64>> {
        transposed_product(&self.re, vector) + transposed_product(&self.im, vector) * Complex::i()
    }

    pub(super) fn column(&self, place: usize) -> DVector<Complex<f64>> {
        self.re.column(place).zip_map(&self.im.column(place), Complex::new)
    }

    pub(super) fn row(&self, place: usize) -> DVector<Complex<f64>> {
        self.re.row(place).zip_map(&self.im.row(place), Complex::new).transpose()
    }

    pub(super) fn entry(&self, row: usize, column: usize) -> Complex<f64> {
        Complex::new(self.re[(row, column)], self.im[(row, column)])
    }
}

/// The product of two matrices, each entry as the sum in the order of k of all `A_ik B_kj` whose `B_kj` is not zero.
pub(super) fn product(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    let rows = a.nrows();
    let mut product = DMatrix::zeros(rows, b.ncols());
    if rows == 0 {
        return product;
    }
    let mut factors = Vec::with_capacity(b.nrows());
    for (column, sums) in b.column_iter().zip(product.as_mut_slice().chunks_exact_mut(rows)) {
        factors.clear();
        factors
            .extend(column.iter().copied().zip(a.as_slice().chunks_exact(rows)).filter(|(factor, _)| *factor != 0.0));
        let (fours, rest) = factors.as_chunks::<4>();
        for [(p, a), (q, b), (r, c), (s, d)] in fours {
            for ((((sum, a), b), c), d) in sums.iter_mut().zip(*a).zip(*b).zip(*c).zip(*d) {
                *sum = *sum + p * a + q * b + r * c + s * d;
            }
        }
        for (factor, a) in rest {
            sums.iter_mut().zip(*a).for_each(|(sum, a)| *sum += factor * a);
        }
    }
    product
}

/// A complex Schur form from a real one: rotations make its blocks of two triangular.
fn complex_schur(vectors: &DMatrix<f64>, triangle: &DMatrix<f64>) -> (ComplexMatrix, ComplexMatrix) {
    let mut z = vectors.map(Complex::from);
    let mut t = triangle.map(Complex::from);
    let states = t.nrows();
    for low in (1..states).rev() {
        let high = low - 1;
        if t[(low, high)] == Complex::from(0.0) {
            continue;
        }
        let (a, b, c, d) = (t[(high, high)], t[(high, low)], t[(low, high)], t[(low, low)]);
        let (half, product) = ((a - d) * 0.5, b * c);
        let eigenvalue = d + half + square_root(half * half + product);
        let shifted = eigenvalue - d;
        let length = libm::hypot(magnitude(shifted), magnitude(c));
        let (cosine, sine) = (shifted / length, c / length);
        for column in high..states {
            let (upper, lower) = (t[(high, column)], t[(low, column)]);
            t[(high, column)] = cosine.conj() * upper + sine.conj() * lower;
            t[(low, column)] = cosine * lower - sine * upper;
        }
        for row in 0..=low {
            let (left, right) = (t[(row, high)], t[(row, low)]);
            t[(row, high)] = left * cosine + right * sine;
            t[(row, low)] = right * cosine.conj() - left * sine.conj();
        }
        for row in 0..states {
            let (left, right) = (z[(row, high)], z[(row, low)]);
            z[(row, high)] = left * cosine + right * sine;
            z[(row, low)] = right * cosine.conj() - left * sine.conj();
        }
        t[(low, high)] = Complex::from(0.0);
    }
    (z, t)
}

/// The right vectors of an upper triangular matrix, each of length 1.
fn vectors_of_triangle(triangle: &ComplexMatrix) -> ComplexMatrix {
    let states = triangle.nrows();
    let largest = triangle.iter().map(|value| magnitude(*value)).fold(0.0, f64::max);
    let least = f64::EPSILON * largest.max(f64::MIN_POSITIVE);
    let mut vectors = ComplexMatrix::zeros(states, states);
    for j in 0..states {
        let mut x = vec![Complex::from(0.0); j + 1];
        x[j] = Complex::from(1.0);
        let mut rest: Vec<Complex<f64>> = (0..j).map(|i| -triangle[(i, j)]).collect();
        for i in (0..j).rev() {
            let mut between = triangle[(i, i)] - triangle[(j, j)];
            if magnitude(between) < least {
                between = Complex::from(least);
            }
            x[i] = rest[i] / between;
            for (row, rest) in rest[..i].iter_mut().enumerate() {
                *rest -= triangle[(row, i)] * x[i];
            }
        }
        let length = x.iter().map(Complex::norm_sqr).sum::<f64>().sqrt();
        for (i, value) in x.into_iter().enumerate() {
            vectors[(i, j)] = value / length;
        }
    }
    vectors
}

/// The inverse of an upper triangular matrix without zeros on its diagonal.
fn inverse_of_triangle(triangle: &ComplexMatrix) -> ComplexMatrix {
    let states = triangle.nrows();
    let mut inverse = ComplexMatrix::identity(states, states);
    for (j, mut column) in inverse.column_iter_mut().enumerate() {
        for k in (0..=j).rev() {
            column[k] /= triangle[(k, k)];
            let factor = column[k];
            for row in 0..k {
                column[row] -= triangle[(row, k)] * factor;
            }
        }
    }
    inverse
}

#[cfg(test)]
mod tests {
    use nalgebra::dmatrix;

    use super::*;
    use crate::models::matrices::trial::Numbers;

    #[test]
    fn the_basis_diagonalises_the_problem_and_its_changes() {
        let mass = DMatrix::identity(3, 3);
        let terms = [
            dmatrix![0.3, -0.1, 0.0; -0.1, 0.2, 0.0; 0.0, 0.0, 5.0],
            dmatrix![2.0, 0.7, 0.1; 0.2, 2.5, 0.0; 0.3, -0.4, 4.0],
            dmatrix![0.1, 0.2, 0.3; -0.2, 0.1, 0.0; 0.5, 0.0, 0.4],
        ];
        let problem = DenseQuadratic::new(&mass, &terms[..1], &terms[1..], &[1.0, 1.0, 1.0]).unwrap();
        let basis = Eigenbasis::new(&problem.at(&[1.0, 1.0, 0.0])).unwrap();
        let step = 1e-6;
        let changes: Vec<ComplexMatrix> = (0..3).map(|k| basis.change(&problem, k)).collect();
        for (k, change) in changes.iter().enumerate() {
            let mut coefficients = [1.0, 1.0, 0.0];
            coefficients[k] += step;
            let moved = problem.at(&coefficients).eigenvalues().unwrap();
            for (i, eigenvalue) in basis.eigenvalues.iter().enumerate() {
                let first_order = eigenvalue + change[(i, i)] * step;
                let nearest = moved.iter().map(|value| magnitude(value - first_order));
                assert!(nearest.fold(f64::INFINITY, f64::min) < 1e-10, "{k} {i}");
            }
        }
        let real_one = basis.eigenvalues.iter().filter(|value| value.im == 0.0).count();
        assert!(real_one >= 2, "an overdamped mode has real eigenvalues: {:?}", basis.eigenvalues);
    }

    #[test]
    fn products_leave_out_zeros_alone() {
        let mut numbers = Numbers(1);
        for (rows, inner, columns) in [(0, 3, 2), (3, 0, 2), (1, 1, 1), (5, 4, 3), (7, 11, 9), (12, 6, 5)] {
            let a = DMatrix::from_fn(rows, inner, |_, _| numbers.next());
            let b = DMatrix::from_fn(inner, columns, |_, _| numbers.next().max(0.0));
            assert_eq!(
                product(&a, &b),
                DMatrix::from_fn(rows, columns, |i, j| (0..inner).map(|k| a[(i, k)] * b[(k, j)]).sum())
            );
        }
    }

    /// Coordinates with nearly the same strong damping and the same soft spring: two clusters of real eigenvalues, at which
    /// nalgebra's iteration stands still.
    #[test]
    fn motions_that_are_nearly_equal_have_a_basis() {
        let mut numbers = Numbers(1);
        for size in 1..=6 {
            for perturbation in [0.0, 1e-15, 1e-14, 1e-13, 1e-12] {
                let mut near = |value: f64| {
                    let perturbed = DMatrix::from_fn(size, size, |_, _| perturbation * numbers.next());
                    DMatrix::identity(size, size) * value + perturbed
                };
                let problem = Quadratic { damping: near(10.0), stiffness: near(0.1), unheld: 0, zeros: 0 };
                let Decomposition { eigenvalues, vectors, inverse } = Decomposition::balanced(&problem).unwrap();
                let companion: ComplexMatrix = problem.companion().map(Complex::from);
                let diagonal = ComplexMatrix::from_diagonal(&DVector::from_vec(eigenvalues));
                let residual = companion * &vectors - &vectors * diagonal;
                let unit = inverse * &vectors - ComplexMatrix::identity(2 * size, 2 * size);
                let largest = |matrix: &ComplexMatrix| matrix.iter().map(|entry| magnitude(*entry)).fold(0.0, f64::max);
                assert!(largest(&residual) < 1e-12 && largest(&unit) < 1e-12, "{size} {perturbation}");
                assert!(Eigenbasis::new(&problem).is_some(), "{size} {perturbation}");
            }
        }
    }
}
