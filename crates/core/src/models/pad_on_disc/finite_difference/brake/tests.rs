use super::*;
use crate::models::pad_on_disc::flexible_disc::compliance::{compliances, lowest_modes};

fn grid(points: usize) -> DiscGrid {
    DiscGrid { radial: points, per_pad: points }
}

fn on_grid(points: usize, changes: &[(&str, f64)]) -> FiniteDifferenceBrake {
    FiniteDifferenceBrake::new(PadOnDisc::preset_with(changes), grid(points)).unwrap()
}

/// Mean deflection of the patch, and the mean of `w r theta`, some time after a constant pressure of `k_en` over
/// the patch was suddenly laid on the disc; by the modes in the space-fixed frame.
fn suddenly_loaded_modes(brake: &FlexibleBrake, time: f64) -> (f64, f64) {
    let n = brake.equations.coefficients.amplitudes.len();
    let averages = &brake.equations.geometry.patch.averages;
    let rates = |a: &[f64], u: &[f64]| -> Vec<f64> {
        let rate = |(k, mode): (usize, &crate::models::pad_on_disc::flexible_disc::equations::Amplitude)| {
            let load = averages.shape.get(k).map_or(0.0, |shape| mode.compliance * shape);
            load - mode.stiffness * a[k]
                - brake.equations.coefficients.disc_damping * u[k]
                - mode.gyroscopic * u[mode.partner]
        };
        brake.equations.coefficients.amplitudes.iter().enumerate().map(rate).collect()
    };
    let steps = 4000;
    let h = time / f64::from(steps);
    let (mut a, mut u) = (vec![0.0; n], vec![0.0; n]);
    let add =
        |a: &[f64], factor: f64, b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a + factor * b).collect() };
    for _ in 0..steps {
        let k1 = rates(&a, &u);
        let u2 = add(&u, 0.5 * h, &k1);
        let k2 = rates(&add(&a, 0.5 * h, &u), &u2);
        let u3 = add(&u, 0.5 * h, &k2);
        let k3 = rates(&add(&a, 0.5 * h, &u2), &u3);
        let u4 = add(&u, h, &k3);
        let k4 = rates(&add(&a, h, &u3), &u4);
        for k in 0..n {
            a[k] += h / 6.0 * (u[k] + 2.0 * (u2[k] + u3[k]) + u4[k]);
            u[k] += h / 6.0 * (k1[k] + 2.0 * (k2[k] + k3[k]) + k4[k]);
        }
    }
    let sum = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum();
    (sum(&a, &averages.shape), sum(&a[averages.shape.len()..], &averages.arc_shape))
}

/// The same on the grid, in the disc's frame.
fn suddenly_loaded_grid(brake: &FiniteDifferenceBrake, allotment: Allotment, time: f64) -> (f64, f64) {
    let (plate, patch) = (&brake.plate, &brake.patch);
    let mut motion = plate.at_rest(&vec![0.0; plate.rings * plate.columns]);
    let loads: Vec<f64> = patch.points.iter().map(|point| brake.contact_gain * point.weight).collect();
    let (mut positions, mut surface) = (Vec::new(), Surface::default());
    let steps = (time / brake.step_length).round() as u64;
    for step in 0..=steps {
        patch.locate(plate, brake.passage(allotment, step), &mut positions);
        if step == steps {
            break;
        }
        plate.accelerate(&brake.step, &mut motion);
        // The first half of the first step is before the load.
        let share = if step == 0 { 0.5 } else { 1.0 };
        patch.allot(plate, &positions, &loads, |ring, column, load| {
            plate.push(&brake.step, &mut motion, ring, column, share * load);
        });
        plate.drift(&brake.step, &mut motion);
    }
    patch.read(plate, &motion, &positions, &mut surface);
    let by_arc = surface.deflections.iter().zip(&patch.points).map(|(w, point)| w * point.arc);
    (patch.average(surface.deflections.iter().copied()), patch.average(by_arc))
}

#[test]
fn the_two_frames_describe_one_motion() {
    // So fast, and so much damped, that the rotation and both parts of the damping show: at rest the load would not
    // tilt the disc at all.
    let fast = [("operating_point.rotating_speed", 2500.0), ("disc.transverse_damping_ratio", 0.1)];
    let modal = FlexibleBrake::with_modes(PadOnDisc::preset_with(&fast), 16).unwrap();
    let grids = [8, 16].map(|points| on_grid(points, &fast));
    for time in [1.0, 2.0, 5.0, 10.0] {
        let exact = suddenly_loaded_modes(&modal, time);
        let deviation = |grid: &FiniteDifferenceBrake, allotment| {
            let (mean, by_arc) = suddenly_loaded_grid(grid, allotment, time);
            (mean - exact.0).abs().max((by_arc - exact.1).abs())
        };
        let [coarse, fine] = [0, 1].map(|grid| deviation(&grids[grid], Allotment::Linear));
        assert!(fine < 1.2e-3 && fine < 0.45 * coarse, "{time}: {coarse} {fine}, {exact:?}");
        // Half an element of the way at most is missing or ahead.
        let [coarse, fine] = [0, 1].map(|grid| deviation(&grids[grid], Allotment::Nodal));
        assert!(fine < 5e-3 && coarse < 1.1e-2, "{time}: {coarse} {fine}, {exact:?}");
    }
}

#[test]
fn the_deflection_of_steady_sliding_stays_under_the_pad() {
    let brake = on_grid(12, &[("operating_point.rotating_speed", 2500.0)]);
    let (plate, patch, step) = (&brake.plate, &brake.patch, &brake.step);
    let loads: Vec<f64> = patch.points.iter().map(|point| brake.contact_gain * point.weight).collect();
    let deflection = brake.steady_deflection(brake.spin, &loads).unwrap();
    let mut motion = plate.standing_still(&deflection, brake.spin, brake.step_length);
    let first = brake.surface(&motion);
    let (mut positions, mut surface) = (Vec::new(), Surface::default());
    let largest = first.deflections.iter().copied().fold(0.0, f64::max);
    for steps in 0..3 * brake.steps_per_element {
        patch.locate(plate, brake.passage(Allotment::Linear, steps), &mut positions);
        patch.read(plate, &motion, &positions, &mut surface);
        for (now, then) in surface.deflections.iter().zip(&first.deflections) {
            assert!((now - then).abs() < 2e-2 * largest, "{steps}: {now} {then}");
        }
        plate.accelerate(step, &mut motion);
        patch.allot(plate, &positions, &loads, |ring, column, load| plate.push(step, &mut motion, ring, column, load));
        plate.drift(step, &mut motion);
    }
}

#[test]
fn the_disc_yields_to_the_pad_as_its_modes_do() {
    // 1.84e-9 m/N: modes with up to 12 nodal diameters, four radial each (physics notes, section 7).
    let preset = PadOnDisc::preset_with(&[]);
    let modal: f64 = compliances(&preset, &lowest_modes(&preset).unwrap()[..16]).iter().sum();
    let [coarse, middle, fine] = [8, 16, 32].map(|points| on_grid(points, &[]).compliance().unwrap() / 1.8435e-9 - 1.0);
    assert!(coarse / middle > 3.5 && coarse / middle < 4.5, "{coarse} {middle}");
    assert!(middle / fine > 3.5 && middle / fine < 4.5, "{middle} {fine}");
    assert!(fine.abs() < 2e-3, "{fine}");
    // The modes that are left out make the disc a little stiffer.
    assert!(modal < 1.8435e-9 && modal > 0.995 * 1.8435e-9, "{modal:e}");
    let frequencies = on_grid(16, &[]).frequency_parameters(2, 2).unwrap();
    let exact = [13.3679, 83.5585];
    assert!(frequencies.iter().zip(exact).all(|(value, exact)| (value / exact - 1.0).abs() < 0.02), "{frequencies:?}");
}

#[test]
fn bad_grids_are_refused() {
    for (radial, per_pad, wrong) in [(3, 8, "radial = 3"), (65, 8, "radial = 65"), (8, 3, "per_pad = 3"), (8, 65, "64")]
    {
        let error = FiniteDifferenceBrake::new(PadOnDisc::preset_with(&[]), DiscGrid { radial, per_pad }).unwrap_err();
        assert!(matches!(error, FiniteDifferenceError::Grid { .. }));
        assert!(error.to_string().contains(wrong), "{error}");
    }
    for (radial, per_pad) in [(4, 4), (4, 64), (8, 4)] {
        assert!(FiniteDifferenceBrake::new(PadOnDisc::preset_with(&[]), DiscGrid { radial, per_pad }).is_ok());
    }
}
