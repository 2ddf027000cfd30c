use super::*;

#[test]
fn what_is_allotted_is_what_is_read() {
    // The work of loads on any deflection is the same on the grid as at the points.
    let plate = PlateGrid::new(8, 48, (3.2, 6.75), 0.02, 0.3);
    let patch = MovingPatch::new(&plate, 3.3, 0.5, 8);
    let deflection: Vec<f64> = (0..8 * 48).map(|k| libm::sin((7 * k * k) as f64)).collect();
    let loads: Vec<f64> = (0..patch.points.len()).map(|k| libm::cos((5 * k * k) as f64)).collect();
    let motion = plate.at_rest(&deflection);
    for passage in [Passage::default(), Passage { whole: 3, part: 0.7 }, Passage { whole: 45, part: 0.1 }] {
        let (mut positions, mut surface) = (Vec::new(), Surface::default());
        patch.locate(&plate, passage, &mut positions);
        patch.read(&plate, &motion, &positions, &mut surface);
        let at_points: f64 = surface.deflections.iter().zip(&loads).map(|(w, load)| w * load).sum();
        let mut on_grid = 0.0;
        patch.allot(&plate, &positions, &loads, |ring, column, load| {
            on_grid += plate.area(ring) * load * deflection[(ring - 1) * 48 + column];
        });
        assert!((at_points - on_grid).abs() < 1e-13 && at_points.abs() > 0.1, "{at_points} {on_grid}");
    }
}

#[test]
fn the_patch_reads_what_is_there_and_where_it_is() {
    // w = (r - a) (1 + cos(2 (theta + Om t))) seen from the pad, which is linear along the radius.
    let plate = PlateGrid::new(5, 96, (3.2, 6.75), 0.02, 0.3);
    let patch = MovingPatch::new(&plate, 4.5, 0.5, 8);
    let (whole, part) = (90, 0.3);
    let passed = (whole as f64 + part) * plate.angle;
    let node = |ring: usize, column: usize| {
        (plate.radius(ring) - 3.2) * (1.0 + libm::cos(2.0 * (column as f64 * plate.angle + passed)))
    };
    let deflection: Vec<f64> = (1..=5).flat_map(|ring| (0..96).map(move |column| node(ring, column))).collect();
    let motion = plate.at_rest(&deflection);
    let (mut positions, mut surface) = (Vec::new(), Surface::default());
    patch.locate(&plate, Passage { whole, part }, &mut positions);
    patch.read(&plate, &motion, &positions, &mut surface);
    for (((radius, theta), w), slope) in patch.places(plate.angle).zip(&surface.deflections).zip(&surface.slopes) {
        let height = radius - 3.2;
        // Second order in the spacing of 0.065.
        assert!((w - height * (1.0 + libm::cos(2.0 * theta))).abs() < 3e-3 * height, "{radius} {theta}: {w}");
        let exact = -2.0 * height * libm::sin(2.0 * theta) / radius;
        assert!((slope - exact).abs() < 2e-2 * height / radius, "{radius} {theta}: {slope} {exact}");
    }
    let (edge, inside) = patch.middle(&plate, &motion, Passage { whole, part });
    assert!((edge - 2.0 * 3.55).abs() < 0.01 && (inside - 0.5 * 3.55).abs() < 0.01, "{edge} {inside}");
    let total: f64 = patch.points.iter().map(|point| point.weight).sum();
    assert!((total - 1.0).abs() < 1e-14 && (patch.area - 0.5 * (6.75 * 6.75 - 4.5 * 4.5)).abs() < 1e-12, "{total}");
}
