use crate::models::pad_on_disc::flexible_disc::contact::loads::ContactLoads;
use crate::models::pad_on_disc::flexible_disc::contact::patch::ContactPatch;
use crate::models::pad_on_disc::flexible_disc::contact::points::sufficient_points;
use crate::models::pad_on_disc::flexible_disc::contact::position::PadPosition;
use crate::models::pad_on_disc::flexible_disc::plate_modes::PlateMode;
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::{PadOnDisc, uniform_draws};

fn modes() -> Vec<PlateMode> {
    let plate = PadOnDisc::preset_with(&[]).annular_plate();
    (0..5).flat_map(|n| plate.modes(n, 1).unwrap()).collect()
}

fn patch(half_angle: f64, points: usize) -> ContactPatch {
    let brake = PadOnDisc::preset_with(&[("pad.half_angle", half_angle)]);
    let (radial, angular) = sufficient_points(brake.parameters(), &modes());
    ContactPatch::new(brake.parameters(), &modes(), points * radial, points * angular)
}

/// States with the pad tilted and the disc bent, from a simple generator.
fn state(seed: u64) -> (PadPosition, Vec<f64>) {
    let mut uniform = uniform_draws(seed);
    let mut draw = || uniform() - 0.5;
    let pad = PadPosition { normal: -0.01 * (draw() + 0.3), tilt: 4e-3 * draw() };
    (pad, (0..9).map(|_| 0.01 * draw()).collect())
}

/// Pressure, load and follower load on every amplitude by the midpoint rule with `points` points each way.
fn brute_force(half_angle: f64, pad: PadPosition, amplitudes: &[f64], points: usize) -> Vec<f64> {
    let disc = &PadOnDisc::preset_with(&[]).parameters().clone();
    let modes = modes();
    let inner = disc.pad.inner_radius / disc.disc.outer_radius;
    let thickness = disc.disc.thickness / disc.disc.outer_radius;
    let at = |i: usize| (i as f64 + 0.5) / points as f64;
    let theta: Vec<f64> = (0..points).map(|i| half_angle * (2.0 * at(i) - 1.0)).collect();
    let waves: Vec<[(f64, f64); 5]> =
        theta.iter().map(|t| [0.0, 1.0, 2.0, 3.0, 4.0].map(|n| (libm::cos(n * t), libm::sin(n * t)))).collect();
    let mut sums = vec![0.0; 19];
    for i in 0..points {
        let r = inner + (1.0 - inner) * at(i);
        let shapes: Vec<f64> = modes.iter().map(|mode| mode.shape(r)).collect();
        let a: Vec<f64> = (0..5).map(|n| shapes[n] * amplitudes[n]).collect();
        let b: Vec<f64> = (0..5).map(|n| if n > 0 { shapes[n] * amplitudes[4 + n] } else { 0.0 }).collect();
        let weight = r * 2.0 / ((1.0 + inner) * (points * points) as f64);
        let mut line = [0.0; 19];
        for (theta, waves) in theta.iter().zip(&waves) {
            let (mut gap, mut slope) = (-pad.normal - r / thickness * theta * pad.tilt, 0.0);
            for n in 0..5 {
                gap += a[n] * waves[n].0 + b[n] * waves[n].1;
                slope += n as f64 * (b[n] * waves[n].0 - a[n] * waves[n].1);
            }
            if gap > 0.0 {
                let share = weight * gap;
                let follower = share * slope * thickness / r;
                line[0] += share;
                for n in 0..5 {
                    line[1 + n] += share * waves[n].0;
                    line[10 + n] += follower * waves[n].0;
                }
                for n in 1..5 {
                    line[5 + n] += share * waves[n].1;
                    line[14 + n] += follower * waves[n].1;
                }
            }
        }
        sums[0] += line[0];
        for k in 0..9 {
            let shape = shapes[if k < 5 { k } else { k - 4 }];
            sums[1 + k] += shape * line[1 + k];
            sums[10 + k] += shape * line[10 + k];
        }
    }
    sums
}

fn loads(patch: &ContactPatch, pad: PadPosition, amplitudes: &[f64]) -> Vec<f64> {
    let mut loads = ContactLoads::zero();
    patch.loads_of_pressed_part(pad, amplitudes, &mut loads);
    let on_modes = loads.on_modes[..9].iter();
    [loads.pressure].iter().chain(on_modes).chain(&loads.follower[..9]).copied().collect()
}

fn error(found: &[f64], exact: &[f64]) -> (f64, f64) {
    let part = |range: std::ops::Range<usize>| {
        // Nothing is compared where nothing presses.
        let scale = exact[range.clone()].iter().fold(1e-300_f64, |m, v| m.max(v.abs()));
        range.map(|k| (found[k] - exact[k]).abs() / scale).fold(0.0, f64::max)
    };
    (part(0..10), part(10..19))
}

/// The midpoint rule, extrapolated: its error falls with the square of the distance of the points.
fn reference(half_angle: f64, pad: PadPosition, amplitudes: &[f64]) -> Vec<f64> {
    let [coarse, fine] = [500, 1000].map(|points| brute_force(half_angle, pad, amplitudes, points));
    coarse.iter().zip(&fine).map(|(coarse, fine)| fine + (fine - coarse) / 3.0).collect()
}

#[test]
fn loads_agree_with_the_midpoint_rule() {
    // Seeds 1, 2 and 7: the edge runs from one end of the lines to the other, 13 and 21: from an end to a radius, 3 and
    // 10: a corner has lifted off. The extrapolated midpoint rule itself is good to some 1e-6.
    let mut partly = 0;
    for half_angle in [0.5, 1.5] {
        let patch = patch(half_angle, 1);
        for seed in [1, 2, 3, 7, 10, 13, 17, 21] {
            let (pad, amplitudes) = state(seed);
            let share = patch.contact_share(pad, &amplitudes);
            partly += u32::from(share > 0.1 && share < 0.99);
            let error = error(&loads(&patch, pad, &amplitudes), &reference(half_angle, pad, &amplitudes));
            assert!(error.0 < 3e-6 && error.1 < 1e-5, "{half_angle} {seed}: {share} {error:?}");
        }
    }
    assert!(partly > 12, "{partly}");
}

#[test]
fn twice_the_points_change_little() {
    let mut typical = 0;
    for half_angle in [0.5, 1.5] {
        let [patch, fine] = [1, 2].map(|points| patch(half_angle, points));
        for seed in 1..100 {
            let (pad, amplitudes) = state(seed);
            let error = error(&loads(&patch, pad, &amplitudes), &loads(&fine, pad, &amplitudes));
            typical += u32::from(error.0 < 1e-7);
            // The worst are edges that turn sharply between two lines, and islands that no probe line meets.
            assert!(error.0.max(error.1) < 3e-4, "{half_angle} {seed}: {error:?}");
        }
    }
    assert!(typical > 150, "{typical}");
}

#[test]
fn loads_are_continuous_where_the_patch_begins_to_lift_off() {
    // What remains is what the rule for the whole patch misses.
    let patch = patch(0.5, 1);
    for seed in 1..20 {
        let (mut pad, amplitudes) = state(seed);
        let share = |normal: f64| patch.contact_share(PadPosition { normal, ..pad }, &amplitudes);
        let (mut whole, mut partly) = (-1.0, 1.0);
        for _ in 0..100 {
            let middle = 0.5 * (whole + partly);
            if share(middle) > 1.0 - 1e-15 { whole = middle } else { partly = middle }
        }
        pad.normal = whole;
        let before = loads(&patch, pad, &amplitudes);
        pad.normal = partly + 1e-12;
        let error = error(&loads(&patch, pad, &amplitudes), &before);
        assert!(error.0 < 1e-6 && error.1 < 1e-5, "{seed}: {error:?}");
    }
}
