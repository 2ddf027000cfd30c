//! The second iteration alone, against closed forms and the first one.

use super::*;

/// A sequence of numbers from -1 to 1.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn matrix(&mut self, size: usize) -> DMatrix<f64> {
        DMatrix::from_fn(size, size, |_, _| self.next())
    }
}

/// The eigenvalues of a matrix by the second iteration alone, after a look at its Q and T.
fn checked(matrix: &DMatrix<f64>) -> Vec<Complex<f64>> {
    let size = matrix.nrows();
    let found = safeguarded(matrix, SWEEPS_PER_ROW * size);
    let (q, t) = found.unwrap_or_else(|| panic!("the iteration does not converge for {matrix}"));
    for row in 2..size {
        assert!((0..row - 1).all(|column| t[(row, column)] == 0.0), "not a Schur form: {t}");
        assert!(t[(row, row - 1)] == 0.0 || t[(row - 1, row - 2)] == 0.0, "not a Schur form: {t}");
    }
    let largest = matrix.amax().max(f64::MIN_POSITIVE);
    let error = (&q * (&t / largest) * q.transpose() - matrix / largest).amax();
    let skew = (&q * q.transpose() - DMatrix::<f64>::identity(size, size)).amax();
    assert!(error < 1e-13 && skew < 1e-13, "{error:e} {skew:e} {matrix}");
    eigenvalues_of(&t)
}

/// The largest distance of one of these eigenvalues from the nearest of others.
fn distance(values: &[Complex<f64>], others: &[Complex<f64>]) -> f64 {
    let nearest =
        |value: &Complex<f64>| others.iter().map(|other| (value - other).norm()).fold(f64::INFINITY, f64::min);
    values.iter().map(nearest).fold(0.0, f64::max)
}

/// `x'' + C x' + K x = 0` with C near 10 and K near 0.1: as many eigenvalues near each root of `s^2 + 10 s + 0.1`.
#[test]
fn motions_that_are_nearly_equal_have_the_eigenvalues_of_one() {
    let fast = -5.0 - 24.9_f64.sqrt();
    let roots = [fast, 0.1 / fast].map(Complex::from);
    let mut numbers = Numbers(1);
    let (mut small, mut stagnant) = (0, 0);
    for size in 1..=12 {
        for perturbation in [0.0, 1e-16, 1e-15, 1e-14, 1e-13, 1e-12] {
            let mut near = |value: f64| {
                let perturbed = numbers.matrix(size) * perturbation;
                -(DMatrix::identity(size, size) * value + perturbed)
            };
            let mut companion = DMatrix::<f64>::zeros(2 * size, 2 * size);
            companion.view_mut((0, size), (size, size)).fill_with_identity();
            companion.view_mut((size, size), (size, size)).copy_from(&near(10.0));
            companion.view_mut((size, 0), (size, size)).copy_from(&near(0.1));
            let values = checked(&companion);
            let off = distance(&values, &roots);
            assert!(off < 1e-12 + 30.0 * perturbation, "{size} {perturbation}: {off}");
            assert_eq!(values.iter().filter(|value| value.re < -5.0).count(), size, "{perturbation}");
            // The first iteration takes long where it does not converge.
            if size <= 6 {
                let sweeps = SWEEPS_PER_ROW * 2 * size;
                small += 1;
                stagnant += usize::from(Schur::try_new(companion.clone(), f64::EPSILON, sweeps).is_none());
                let (_, triangle) = real_schur(&companion).unwrap();
                assert!(distance(&eigenvalues_of(&triangle), &roots) < 1e-12 + 30.0 * perturbation);
            }
        }
    }
    // Once nalgebra converges always, this iteration may go.
    assert!(stagnant > 0 && stagnant < small, "{stagnant} of {small}");
}

#[test]
fn random_matrices_have_the_eigenvalues_that_nalgebra_finds() {
    let mut numbers = Numbers(2);
    for case in 0..200 {
        let size = 1 + case % 16;
        let mut matrix = numbers.matrix(size);
        if case % 3 == 1 {
            // Some rows and columns stand alone, and some entries below the diagonal are zero from the start.
            matrix.apply(|entry| *entry = if entry.abs() < 0.6 { 0.0 } else { *entry });
        }
        let Some(first) = Schur::try_new(matrix.clone(), f64::EPSILON, SWEEPS_PER_ROW * size) else { continue };
        let (values, others) = (checked(&matrix), eigenvalues_of(&first.unpack().1));
        // Multiple eigenvalues of sparse matrices move by a root of rounding.
        let most = matrix.norm() * if case % 3 == 1 { 1e-3 } else { 1e-10 };
        assert!(distance(&values, &others) <= most && distance(&others, &values) <= most, "{matrix}");
    }
}

/// Their errors are roots of rounding.
#[test]
fn defective_matrices_have_their_one_eigenvalue() {
    let mut numbers = Numbers(3);
    for size in 1..=7 {
        for eigenvalue in [0.0_f64, 1.0, -2.5] {
            let entry = |row: usize, column: usize| match column.checked_sub(row) {
                Some(0) => eigenvalue,
                Some(1) => 1.0,
                _ => 0.0,
            };
            let jordan = DMatrix::from_fn(size, size, entry);
            let turn = numbers.matrix(size).qr().q();
            for matrix in [jordan.transpose(), &turn * &jordan * turn.transpose(), jordan] {
                for value in checked(&matrix) {
                    let off = (value - eigenvalue).norm();
                    assert!(off.powi(size as i32) < 1e-12, "{size}: {value} for {eigenvalue}");
                }
            }
        }
    }
}

/// All their eigenvalues have one modulus, so that usual shifts do not tell them apart.
#[test]
fn permutations_have_roots_of_one() {
    for size in 1..=30 {
        let cycle = DMatrix::from_fn(size, size, |row, column| f64::from(u8::from(row == (column + 1) % size)));
        let angle = |k: usize| 2.0 * std::f64::consts::PI * k as f64 / size as f64;
        let roots: Vec<_> = (0..size).map(|k| Complex::new(angle(k).cos(), angle(k).sin())).collect();
        let values = checked(&cycle);
        assert!(distance(&values, &roots) < 1e-12 && distance(&roots, &values) < 1e-12, "{size}");
    }
    // Two turns by a right angle, coupled by rounding beside a diagonal of zeros.
    let mut turns = DMatrix::<f64>::zeros(5, 5);
    for (row, column, value) in [(0, 3, 1.0), (1, 2, 1.0), (2, 1, -1.0), (3, 0, -1.0), (4, 4, 1.0)] {
        turns[(row, column)] = value;
    }
    let roots = [Complex::new(0.0, 1.0), Complex::new(0.0, -1.0), Complex::new(1.0, 0.0)];
    assert!(distance(&checked(&turns), &roots) < 1e-14);
    let mut coupled = DMatrix::<f64>::zeros(4, 4);
    for (row, column, value) in [(0, 1, -1.0), (1, 0, 1.0), (2, 3, 1.0), (3, 2, -1.0), (2, 1, -2e-16), (1, 2, 2e-16)] {
        coupled[(row, column)] = value;
    }
    assert!(distance(&checked(&coupled), &roots[..2]) < 1e-14);
}

#[test]
fn zeros_single_numbers_and_triangles_stay_as_they_are() {
    for size in 1..=4 {
        assert_eq!(checked(&DMatrix::zeros(size, size)), vec![Complex::from(0.0); size]);
    }
    assert_eq!(checked(&DMatrix::from_element(1, 1, -3.0)), [Complex::from(-3.0)]);
    let triangle = DMatrix::from_row_slice(3, 3, &[3.0, 5.0, -7.0, 0.0, 3.0, 1e9, 0.0, 0.0, -2.0]);
    assert_eq!(checked(&triangle), [3.0, 3.0, -2.0].map(Complex::<f64>::from));
    assert_eq!(real_schur(&DMatrix::zeros(0, 0)).map(|(_, t)| t.nrows()), Some(0));
}

/// A change of unit changes nothing but the unit.
#[test]
fn scales_do_not_matter() {
    let mut numbers = Numbers(4);
    for size in 1..=8 {
        let matrix = numbers.matrix(size);
        let values = checked(&matrix);
        for exponent in [-900, -400, 400, 900] {
            let unit = libm::ldexp(1.0, exponent);
            let (_, t) = safeguarded(&(&matrix * unit), SWEEPS_PER_ROW * size).unwrap();
            assert_eq!(eigenvalues_of(&(t / unit)), values, "{size} {exponent}");
        }
    }
}
