use super::*;
use crate::models::pad_on_disc::flexible_disc::contact::points::{ANGULAR_POINTS, RADIAL_POINTS};
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::{PadOnDisc, uniform_draws};

fn patch(radial: usize, angular: usize) -> ContactPatch {
    let brake = PadOnDisc::preset_with(&[]);
    let plate = brake.annular_plate();
    let modes: Vec<PlateMode> = (0..5).flat_map(|n| plate.modes(n, 1).unwrap()).collect();
    ContactPatch::new(brake.parameters(), &modes, radial, angular)
}

/// Amplitudes of either sign and of the size that a limit cycle has, from a simple generator.
fn amplitudes(seed: u64, scale: f64) -> Vec<f64> {
    let mut draw = uniform_draws(seed);
    (0..9).map(|_| scale * (draw() - 0.5)).collect()
}

#[test]
fn the_fast_path_gives_the_numbers_of_the_nodes() {
    let patch = patch(RADIAL_POINTS, ANGULAR_POINTS);
    for seed in 1..200 {
        let amplitudes = amplitudes(seed, 2e-3);
        let pad = PadPosition { normal: -0.046, tilt: 1e-3 * (seed as f64 / 100.0 - 1.0) };
        assert!(patch.is_surely_whole(pad, &amplitudes));
        let [mut whole, mut by_node] = [ContactLoads::zero(), ContactLoads::zero()];
        patch.loads_of_whole_patch(pad, &amplitudes, &mut whole);
        patch.loads_by_node(pad, &amplitudes, &mut by_node);
        assert!((whole.pressure / by_node.pressure - 1.0).abs() < 1e-14);
        for k in 0..9 {
            // Relative to the loads on the strongest mode; single averages may nearly vanish.
            assert!((whole.on_modes[k] - by_node.on_modes[k]).abs() < 1e-15, "{k}");
            assert!((whole.follower[k] - by_node.follower[k]).abs() < 1e-17, "{k}");
        }
        assert!(by_node.follower.iter().any(|load| load.abs() > 1e-6), "the follower load is there to be compared");
    }
}

#[test]
fn the_bound_never_claims_contact_that_is_lost() {
    let patch = patch(RADIAL_POINTS, ANGULAR_POINTS);
    let (mut claimed, mut lost) = (0, 0);
    for seed in 1..3000 {
        let amplitudes = amplitudes(seed, 0.005);
        let pad = PadPosition { normal: -0.02, tilt: 2e-3 * ((seed % 7) as f64 / 3.0 - 1.0) };
        let whole = patch.contact_share(pad, &amplitudes) > 1.0 - 1e-12;
        let sure = patch.is_surely_whole(pad, &amplitudes);
        assert!(whole || !sure);
        claimed += u32::from(sure);
        lost += u32::from(!whole);
    }
    assert!(claimed > 20 && lost > 20, "{claimed} {lost}: both must occur for the test to mean something");
}

#[test]
fn twice_the_nodes_change_nothing_while_the_patch_is_whole() {
    let (coarse, fine) = (patch(RADIAL_POINTS, ANGULAR_POINTS), patch(2 * RADIAL_POINTS, 2 * ANGULAR_POINTS));
    for seed in 1..50 {
        let amplitudes = amplitudes(seed, 2e-3);
        let pad = PadPosition { normal: -0.046, tilt: 1e-3 };
        let [mut a, mut b] = [ContactLoads::zero(), ContactLoads::zero()];
        coarse.loads_by_node(pad, &amplitudes, &mut a);
        fine.loads_by_node(pad, &amplitudes, &mut b);
        assert!((a.pressure / b.pressure - 1.0).abs() < 1e-8);
        for k in 0..9 {
            assert!((a.on_modes[k] - b.on_modes[k]).abs() < 1e-8, "{k} {} {}", a.on_modes[k], b.on_modes[k]);
            assert!((a.follower[k] - b.follower[k]).abs() < 1e-9, "{k} {} {}", a.follower[k], b.follower[k]);
        }
    }
}

#[test]
fn the_weights_are_shares_of_the_area() {
    let patch = patch(RADIAL_POINTS, ANGULAR_POINTS);
    let total: f64 = patch.nodes.iter().map(|node| node.weight).sum();
    assert!((total - 1.0).abs() < 1e-14, "{total}");
    assert_eq!(patch.contact_share(PadPosition { normal: 1.0, tilt: 0.0 }, &[0.0; 9]), 0.0);
}
