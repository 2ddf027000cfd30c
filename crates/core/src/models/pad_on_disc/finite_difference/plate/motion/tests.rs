use nalgebra::DVector;

use super::*;

/// The preset's plate.
fn plate(rings: usize, columns: usize) -> PlateGrid {
    PlateGrid::new(rings, columns, (3.2, 6.75), 0.02, 0.3)
}

/// Numbers between -1/2 and 1/2 from a simple generator.
fn scatter(count: usize) -> Vec<f64> {
    let mut state = 0x9E37_79B9_7F4A_7C15_u64;
    let mut draw = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    (0..count).map(|_| draw()).collect()
}

#[test]
fn thirteen_points_are_the_radial_operator() {
    let grid = plate(7, 36);
    let by_ring = scatter(7);
    for n in [0, 1, 4, 18] {
        let shape = |j: usize| libm::cos((n * j) as f64 * grid.angle);
        let deflection: Vec<f64> = by_ring.iter().flat_map(|a| (0..36).map(move |j| a * shape(j))).collect();
        let mut motion = grid.at_rest(&deflection);
        grid.accelerate(&grid.explicit_step(1.0, 0.0, 0.0), &mut motion);
        let expected = grid.radial_operator(n) * DVector::from_column_slice(&by_ring);
        for (ring, speeds) in motion.speeds.chunks_exact(36).enumerate() {
            for (j, speed) in speeds.iter().enumerate() {
                assert!((speed + expected[ring] * shape(j)).abs() < 1e-11 * expected.amax(), "{n} {ring} {j}");
            }
        }
    }
}

#[test]
fn steps_are_stable_up_to_the_bound_and_not_far_beyond() {
    let grid = plate(6, 36);
    let longest = 2.0 / grid.largest_squared_frequency().sqrt();
    let stays_small = |length: f64| {
        let mut motion = grid.at_rest(&scatter(6 * 36));
        let step = grid.explicit_step(length, 0.0, 0.0);
        for _ in 0..5000 {
            grid.accelerate(&step, &mut motion);
            grid.drift(&step, &mut motion);
        }
        motion.deflections.iter().all(|w| w.abs() < 30.0)
    };
    assert!(stays_small(0.999 * longest));
    assert!(!stays_small(1.1 * longest));
}

#[test]
fn a_steady_deflection_balances_its_load() {
    let grid = plate(8, 48);
    let load = scatter(8 * 48);
    for spin in [0.0, 0.3] {
        let deflection = grid.steady_deflection(spin, &load).unwrap();
        let mut motion = grid.at_rest(&deflection);
        grid.accelerate(&grid.explicit_step(1.0, 0.0, 0.0), &mut motion);
        for (index, load) in load.iter().enumerate() {
            let (begin, column) = (index / 48 * 48, index % 48);
            let at = |column: usize| deflection[begin + column % 48];
            let second = (at(column + 1) - 2.0 * at(column) + at(column + 47)) / (grid.angle * grid.angle);
            let balance = -motion.speeds[index] + spin * spin * second - load;
            assert!(balance.abs() < 1e-11, "{spin} {index}: {balance}");
        }
    }
}
