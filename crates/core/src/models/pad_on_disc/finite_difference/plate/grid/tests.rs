use super::*;
use crate::models::pad_on_disc::flexible_disc::plate_modes::BESSEL_FREQUENCIES;

/// The preset's plate.
fn plate(rings: usize, columns: usize) -> PlateGrid {
    PlateGrid::new(rings, columns, (3.2, 6.75), 0.02, 0.3)
}

#[test]
fn frequencies_converge_with_the_square_of_the_spacing() {
    for (n, exact) in BESSEL_FREQUENCIES.iter().enumerate() {
        let errors = [8, 16, 32].map(|count| {
            let squared = plate(count, 6 * count).squared_frequencies(n).unwrap();
            [0, 1, 2].map(|k| 6.75 * 6.75 * (0.02 * squared[k]).sqrt() / exact[k] - 1.0)
        });
        for k in 0..3 {
            let [coarse, middle, fine] = [errors[0][k], errors[1][k], errors[2][k]];
            // A quarter from grid to grid; the coarsest has 8 intervals for up to 3 half-waves.
            assert!(coarse / middle > 3.5 && coarse / middle < 4.05, "n = {n}, {k}: {coarse} {middle}");
            assert!(middle / fine > 3.84 && middle / fine < 4.05, "n = {n}, {k}: {middle} {fine}");
            assert!(fine.abs() < [0.0021, 0.0049, 0.0094][k], "n = {n}, {k}: {fine}");
        }
    }
}

#[test]
fn poissons_ratio_and_radii_enter_as_they_should() {
    // a/b, nu, n, lambda^2 from the Bessel determinant, as in the tests of the disc's modes.
    for (ratio, poissons_ratio, n, exact) in [
        (0.3, 0.0, 5, 36.680976),
        (0.3, 1.0 / 3.0, 2, 7.854989),
        (0.7, 0.0, 1, 36.854831),
        (0.7, 1.0 / 3.0, 5, 55.139592),
    ] {
        let error = |count: usize| {
            let grid = PlateGrid::new(count, 6 * count, (ratio, 1.0), 1.0, poissons_ratio);
            grid.squared_frequencies(n).unwrap()[0].sqrt() / exact - 1.0
        };
        let (coarse, fine) = (error(16), error(32));
        assert!(coarse / fine > 3.8 && coarse / fine < 4.2 && fine.abs() < 4e-3, "{ratio} {n}: {coarse} {fine}");
    }
}

#[test]
fn the_operator_is_symmetric_and_positive_and_its_bound_is_close() {
    for (inner, poissons_ratio) in [(0.05, 0.3), (0.5, 0.0), (0.5, 0.49), (0.95, 0.3)] {
        for (rings, per_pad) in [(4, 4), (4, 64), (32, 4), (12, 12)] {
            let grid = PlateGrid::new(rings, 6 * per_pad, (inner, 1.0), 1.0, poissons_ratio);
            let mut largest = 0.0_f64;
            for n in 0..=3 * per_pad {
                let squared = grid.squared_frequencies(n).unwrap();
                assert!(squared[0] > 0.0, "{inner} {rings} {per_pad} n = {n}: {}", squared[0]);
                largest = largest.max(squared[rings - 1]);
                let matrix = grid.radial_operator(n);
                for row in 0..rings {
                    for column in 0..rings {
                        let a = grid.area(row + 1) * matrix[(row, column)];
                        let b = grid.area(column + 1) * matrix[(column, row)];
                        assert!((a - b).abs() <= 1e-14 * (a.abs() + b.abs()), "{row} {column}: {a} {b}");
                    }
                }
            }
            let bound = grid.largest_squared_frequency();
            assert!(bound >= largest && bound < 1.2 * largest, "{inner} {rings} {per_pad}: {bound} {largest}");
        }
    }
}
