//! Models that others published, through the command line: the numbers of docs/published-models.md.

#![allow(clippy::disallowed_methods, reason = "formulas as a textbook writes them")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so and stop")]

use crate::common::{Place, Table, repository};

/// Stender & Hoffmann (bSTAB, Nonlinear Dynamics 2021, doi 10.1007/s11071-021-06786-5): belt speed, the share of 5000
/// uniform random states on [-2, 2] x [0, 2] that ends in steady sliding, as their toolbox prints it, and the area
/// inside the unstable cycle over that of the window, by SciPy 1.17.1 (solve_ivp with DOP853, rtol 1e-13, atol 1e-15).
const SHARES: [(f64, f64, f64); 6] = [
    (1.175, 0.0126, 0.018774),
    (1.25, 0.0838, 0.080197),
    (1.4, 0.2110, 0.212265),
    (1.5, 0.3120, 0.307126),
    (1.625, 0.4336, 0.428098),
    (1.775, 0.5552, 0.558367),
];

/// Asserts that the page has some text.
#[track_caller]
fn assert_on_page(text: &str) {
    let page = std::fs::read_to_string(repository().join("docs/published-models.md")).unwrap();
    assert!(page.contains(text), "docs/published-models.md does not have: {text}");
}

/// Asserts that a number of ours, rounded as theirs is written, is the same.
#[track_caller]
fn assert_digits(quantity: &str, theirs: &str, ours: f64) {
    let (digits, exponent) =
        theirs.split_once('e').map_or((theirs, None), |(digits, exponent)| (digits, Some(exponent)));
    let decimals = digits.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    let rounded = if exponent.is_some() { format!("{ours:.decimals$e}") } else { format!("{ours:.decimals$}") };
    assert_eq!(rounded, theirs, "{quantity}: {ours}");
}

/// The same, and that the page has theirs in the row of the quantity.
#[track_caller]
fn assert_same(quantity: &str, theirs: &str, ours: f64) {
    assert_on_page(&format!("| {quantity} | {theirs} |"));
    assert_digits(quantity, theirs, ours);
}

fn standard_errors(difference: f64, share: f64) -> f64 {
    difference / (share * (1.0 - share) / 5000.0).sqrt()
}

#[test]
fn shares_of_random_starts_are_those_of_the_published_oscillator() {
    let place = Place::new();
    place.run(&format!("submit {}", repository().join("jobs/bstab.toml").display())).done();
    let table = Table::read(&place.path("runs/bstab/surface.parquet"));
    let of = |name: &str, speed: f64| {
        let row = table.column("belt_speed").iter().position(|&value| value == speed).unwrap();
        table.column(name)[row]
    };
    for (speed, printed, area) in SHARES {
        assert_on_page(&format!("| {speed} | {printed:.4} | {area:.6} |"));
        let share = 1.0 - of("p_unstable", speed);
        assert!(standard_errors(share - area, area).abs() < 3.0, "{speed}: {share} {area}");
        assert_eq!(of("n_undecided", speed) + of("n_failed", speed), 0.0, "{speed}");
    }
    assert_eq!((of("p_unstable", 1.1), of("p_unstable", 1.85)), (1.0, 0.0));
}

#[test]
fn stick_slip_keeps_itself_going_up_to_the_speed_of_the_saddle_node() {
    let place = Place::new();
    place.run(&format!("submit {}", repository().join("jobs/veraszto.toml").display())).done();
    let table = Table::read(&place.path("runs/veraszto/surface.parquet"));
    let speeds = table.column("belt_speed");
    assert!(speeds[0] < 0.271789 && speeds[speeds.len() - 1] > 0.271789, "{speeds:?}");
    for (speed, p) in speeds.iter().zip(table.column("p_unstable")) {
        assert_eq!(*p, f64::from(*speed < 0.271789), "{speed}");
    }
}

#[test]
fn oscillators_are_analysed_in_metres_and_seconds() {
    let place = Place::new();
    for (name, critical, end) in [("bstab", "1.151293", "1.836601"), ("veraszto", "0.190616", "0.271789")] {
        let job = repository().join(format!("jobs/{name}.toml"));
        let printed = place.run(&format!("analyse --job {} --json", job.display())).done().stdout;
        let analysis: serde_json::Value = serde_json::from_str(&printed).unwrap();
        let number = |key: &str| analysis[key].as_f64().unwrap();
        assert_same(&format!("{name}: critical speed"), critical, number("critical_speed"));
        assert_same(&format!("{name}: end of stick-slip"), end, number("end_of_stick_slip"));
        assert!(analysis["limit_cycle"]["period"].as_f64().unwrap() > 0.0, "{printed}");
        let text = place.run(&format!("analyse --job {}", job.display())).done().stdout;
        assert!(text.contains("\nstick-slip         below ") && !text.contains("preload"), "{text}");
        place
            .run(&format!("analyse --job {} --set pad.mass=1", job.display()))
            .refused(64, &["there is no parameter pad.mass (there are normal_force, "]);
    }
}

#[test]
fn a_motion_with_the_smallest_knock_is_between_both_verdicts() {
    // By the time-domain criterion, whose fixed steps lose a millionth of an amplitude in a cycle.
    let place = Place::new();
    let analysis: serde_json::Value = serde_json::from_str(&place.run("analyse --json").done().stdout).unwrap();
    let knock = |key: &str| analysis["smallest_knock"][key].as_f64().unwrap();
    for (key, name, sign) in [
        ("forward", "velocity", 1.0),
        ("backward", "velocity", -1.0),
        ("outward", "tangential", 1.0),
        ("inward", "tangential", -1.0),
    ] {
        for (share, p_unstable) in [(1.0 - 1e-5, 0.0), (1.0 + 1e-5, 1.0)] {
            let value = sign * knock(key) * share;
            let run = format!("{key}-{p_unstable}");
            place.write(
                "knock.toml",
                &format!(
                    "name = \"{run}\"\n[axes]\nrotating_speed = 16.0\npreload = 0.1\nstatic_friction = 0.39\n[random]\n\
                     inputs = []\n[criterion]\nkind = \"time-domain\"\ndisc = \"rigid\"\nstart = {{ {name} = {value:e}, \
                     from_equilibrium = true, units = \"scaled\" }}\n[sampling]\nsamples = 1\n"
                ),
            );
            place.run("submit knock.toml").done();
            let table = Table::read(&place.path(&format!("runs/{run}/surface.parquet")));
            assert_eq!(table.column("p_unstable"), [p_unstable], "{key} {share}");
        }
    }
}

/// A threshold below which a damping ratio counts just where it is below zero, as it does where it is 1e-9 below the threshold.
pub const OF_ZERO: &str = "damping_ratio = 1e-9";

/// A point of a model given by matrices, analysed: a model of `matrices`, parameters, keys of the criterion.
fn analysed(place: &Place, matrices: &str, parameters: &str, criterion: &str) -> serde_json::Value {
    place.write(
        "model.toml",
        &format!(
            "name = \"model\"\n[model]\nkind = \"matrices\"\n{matrices}\n[model.parameters]\n{parameters}\n\
             [criterion]\nkind = \"complex-eigenvalue\"\n{criterion}\n"
        ),
    );
    serde_json::from_str(&place.run("analyse model.toml --json").done().stdout).unwrap()
}

/// The eigenvalues of the modes, real and imaginary parts.
fn eigenvalues(analysis: &serde_json::Value) -> Vec<[f64; 2]> {
    let modes = analysis["modes"].as_array().unwrap().iter();
    modes.map(|mode| [0, 1].map(|part| mode["eigenvalue"][part].as_f64().unwrap())).collect()
}

/// The critical value above a point.
fn critical(analysis: &serde_json::Value, parameter: &str) -> f64 {
    analysis["critical_values"][parameter]["above"].as_f64().unwrap()
}

/// The critical det K of `lambda^4 + a3 lambda^3 + a2 lambda^2 + a1 lambda + det K`, by Routh and Hurwitz.
fn critical_determinant(a3: f64, a2: f64, a1: f64) -> f64 {
    a1 * (a3 * a2 - a1) / (a3 * a3)
}

/// Asserts a critical value: by a formula, as the page has it, and ours to a relative error.
#[track_caller]
fn assert_critical(quantity: &str, theirs: &str, formula: f64, ours: f64, error: f64) {
    assert_same(quantity, theirs, formula);
    assert!((ours / formula - 1.0).abs() < error, "{quantity}: {formula} {ours}");
}

/// Two masses of Hoffmann and others (2002, 2003).
#[test]
fn two_masses_have_the_critical_friction_of_their_formulas() {
    let place = Place::new();
    let ours = |k22: f64, [c1, c2]: [f64; 2], factor: &str| {
        let matrices = format!(
            "mass = {{ matrix = [[1, 0], [0, 1]] }}\ndamping = {{ matrix = [[{c1:?}, 0], [0, {c2:?}]] }}\n\
             stiffness = [{{ matrix = [[2, 1], [1, {k22:?}]] }}, {{ matrix = [[0, -1], [0, 0]], factor = \"{factor}\" }}]"
        );
        let criterion = if c1 > 0.0 { OF_ZERO } else { "" };
        critical(&analysed(&place, &matrices, "D = 0.5", criterion), "D")
    };
    let mu = ours(2.0, [0.0; 2], "1.3333333333333333 * D");
    assert_critical("k22 = 2, no damping, D = 4 mu / 3: mu", "0.75", 0.75, mu, 1e-8);
    let undamped = 1.0 + 0.2_f64.powi(2) / 4.0;
    assert_critical("k22 = 2.2, no damping: D", "1.01", undamped, ours(2.2, [0.0; 2], "D"), 1e-8);
    for (quantity, [c1, c2], theirs) in [
        ("k22 = 2.2, c = (0.1, 0.3): D", [0.1, 0.3], "1.069"),
        ("k22 = 2.2, c = (0.01, 0.05): D", [0.01, 0.05], "1.0065722222"),
        ("k22 = 2.2, c = (1e-4, 1e-4): D", [1e-4, 1e-4], "1.010000021"),
        ("k22 = 2.2, c = (1e-4, 1e-3): D", [1e-4, 1e-3], "1.0033059869"),
    ] {
        let (k11, k12, k22) = (2.0, 1.0, 2.2);
        let determinant = critical_determinant(c1 + c2, k11 + k22 + c1 * c2, c1 * k22 + c2 * k11);
        let formula = (determinant - (k11 * k22 - k12 * k12)) / k12;
        assert_critical(quantity, theirs, formula, ours(k22, [c1, c2], "D"), 1e-9);
    }
}

/// The drum brake of Hulten (1993) with the parameters of Sinou and Jezequel (2007).
#[test]
fn a_drum_brake_has_the_critical_friction_of_its_formula() {
    let place = Place::new();
    let [w1, w2] = [100.0, 75.0].map(|hertz| std::f64::consts::TAU * hertz);
    for (quantity, [e1, e2], theirs, error) in [
        ("no damping", [0.0, 0.0], "0.29166666667", 1e-8),
        ("e = (0.02, 0.02)", [0.02, 0.02], "0.28936712552", 1e-9),
        ("e = (0.01, 0.05)", [0.01, 0.05], "0.23908393192", 1e-9),
    ] {
        let (c1, c2, k1, k2) = (e1 * w1, e2 * w2, w1 * w1, w2 * w2);
        let matrices = format!(
            "mass = {{ matrix = [[1, 0], [0, 1]] }}\ndamping = {{ matrix = [[{c1:?}, 0], [0, {c2:?}]] }}\n\
             stiffness = [{{ matrix = [[{k1:?}, 0], [0, {k2:?}]] }}, \
             {{ matrix = [[0, {:?}], [{k1:?}, 0]], factor = \"mu\" }}]",
            -k2
        );
        let formula = if e1 == 0.0 {
            (k1 - k2) / (2.0 * w1 * w2)
        } else {
            let determinant = critical_determinant(c1 + c2, k1 + k2 + c1 * c2, c1 * k2 + c2 * k1);
            (determinant / (k1 * k2) - 1.0).sqrt()
        };
        let criterion = if e1 > 0.0 { OF_ZERO } else { "" };
        let ours = critical(&analysed(&place, &matrices, "mu = 0.2", criterion), "mu");
        assert_critical(quantity, theirs, formula, ours, error);
    }
}

/// The matrices of a model in a file of `jobs/`: M, and the terms of damping and stiffness with their factors.
fn matrices(file: &str, damping: &[(&str, &str)], stiffness: &[(&str, &str)]) -> String {
    let file = repository().join("jobs").join(file).display().to_string();
    let term = |(matrix, factor): &(&str, &str)| {
        format!("{{ file = {file:?}, matrix = \"{matrix}\", factor = \"{factor}\" }}")
    };
    let terms = |list: &[(&str, &str)]| list.iter().map(term).collect::<Vec<_>>().join(", ");
    format!(
        "mass = {{ file = {file:?}, matrix = \"M\" }}\ndamping = [{}]\nstiffness = [{}]",
        terms(damping),
        terms(stiffness)
    )
}

/// disk_brake100 of NLEVP: eigenvalues by LAPACK.
#[test]
fn a_dense_brake_has_the_unstable_eigenvalues_of_lapack() {
    let place = Place::new();
    let unstable = |speed: f64, s: &str| {
        let (over, times) = (format!("{s} / {speed:?}"), format!("{speed:?}"));
        let damping = [("D1", "1"), ("DR", &over), ("DG", &times)];
        let matrices = matrices("tu-brake/disk_brake100.mat", &damping, &[("K1", "1"), ("KR", s)]);
        let analysis = analysed(&place, &matrices, "", "");
        eigenvalues(&analysis).into_iter().filter(|[growth, _]| *growth > 0.0).collect::<Vec<_>>()
    };
    let two_pi = std::f64::consts::TAU;
    for (quantity, turns, re, im) in [
        ("the unstable eigenvalue at Omega = 2 pi rad/s, s = 1", 1.0, "0.00106524", "0.000702"),
        ("at 4 pi rad/s", 2.0, "0.00105920", "0.000712"),
        ("at 8 pi rad/s", 4.0, "0.00104698", "0.000730"),
    ] {
        assert_on_page(&format!("| {quantity} | {re} + {im}i |"));
        let found = unstable(turns * two_pi, "1");
        let [[growth, frequency]] = found[..] else { panic!("{quantity}: {found:?}") };
        assert_digits(quantity, re, growth);
        assert_digits(quantity, im, frequency);
    }
    assert_on_page("| critical s at 2 pi rad/s | 0.0835794671 |");
    for (s, count) in [("0.0835793", 0), ("0.0835796", 1)] {
        assert_on_page(s);
        assert_eq!(unstable(two_pi, s).len(), count, "{s}");
    }
}

/// The eigenvalues of the brake of TU Berlin in bands (Hz): the speed in rad/s, the factor s, with or without D4.
fn brake_of_tu_berlin(place: &Place, speed: f64, s: &str, d4: &str, bands: &str) -> Vec<[f64; 2]> {
    let [over, times, square] = [format!("1 / {speed:?}"), format!("{speed:?}"), format!("{speed:?}^2")];
    let damping = [("D1", "1"), ("DR", &over), ("DG", &times), ("D4", d4)];
    let matrices = matrices("tu-brake/tu-brake.mat", &damping, &[("K1", "1"), ("KR", s), ("KGEO", &square)]);
    eigenvalues(&analysed(place, &matrices, "", &format!("matrices = \"full\"\nbands = {bands}")))
}

/// The brake of TU Berlin (Graebner and others, 2016), with its 4669 degrees of freedom.
#[test]
fn a_brake_of_finite_elements_has_the_eigenvalues_that_its_authors_print() {
    let place = Place::new();
    let pi = std::f64::consts::PI;
    for (speed, bands, given) in [
        (2.0 * pi, "[[531, 532]]", &[("-2.462", "3338")][..]),
        (
            40.0 * pi,
            "[[224, 226], [569, 570], [1565, 1566], [2711, 2712]]",
            &[("-9.215", "1413"), ("-3.809", "3576"), ("-6.673", "9836"), ("63.93", "1.704e4")],
        ),
        (
            4.0 * pi,
            "[[224, 226], [531, 532], [2601, 2602], [2778, 2779]]",
            &[
                ("-10.173152", "1413.56400"),
                ("-2.914258", "3337.09330"),
                ("-13.587414", "16346.09452"),
                ("75.347507", "17459.93857"),
            ],
        ),
    ] {
        let found = brake_of_tu_berlin(&place, speed, "1", "0", bands);
        assert_eq!(found.len(), given.len(), "{found:?}");
        for ([growth, frequency], (re, im)) in found.iter().zip(given) {
            assert_on_page(&format!("| {re} + {im}i |"));
            assert_digits(re, re, *growth);
            assert_digits(im, im, *frequency);
        }
    }
}

/// A pair grows above a critical value and decays below: each a few times 1e-10 away, relative to it.
#[test]
fn brakes_of_finite_elements_have_the_critical_values_of_arpack() {
    let place = Place::new();
    assert_on_page("| critical s at 4 pi rad/s with D4 | 1.9602310483 |");
    for (s, sign) in [("1.960231047", -1.0), ("1.960231050", 1.0)] {
        let found = brake_of_tu_berlin(&place, 4.0 * std::f64::consts::PI, s, "6.25e-4", "[[2760, 2764]]");
        let [[growth, frequency]] = found[..] else { panic!("{s}: {found:?}") };
        assert!(growth * sign > 0.0, "{s}: {growth:e}");
        assert_same("its frequency, Hz", "2762.0966", frequency / std::f64::consts::TAU);
    }

    assert_on_page("| critical friction | 0.282710234738 | 0.2862109194 |");
    for (friction, sign) in [("0.2827102346", -1.0), ("0.2827102349", 1.0)] {
        let damping = [("M", "20"), ("K0", "5e-7"), ("K_lining", "5e-7 * 8e9")];
        let friction_stiffness = format!("{friction} * 5e12");
        let stiffness = [("K0", "1"), ("K_lining", "8e9"), ("K_contact", "5e12"), ("K_friction", &friction_stiffness)];
        let matrices = matrices("own-brake/own-brake.mat", &damping, &stiffness);
        let band = "matrices = \"full\"\nfrequency = [12743, 12744]";
        let found = eigenvalues(&analysed(&place, &matrices, "", band));
        let [[growth, frequency]] = found[..] else { panic!("{friction}: {found:?}") };
        assert!(growth * sign > 0.0, "{friction}: {growth:e}");
        assert_same("its frequency, Hz", "12743.43535", frequency / std::f64::consts::TAU);
    }
}
