//! SI beside the scaled numbers: every conversion against the equations in SI, without the scales of the program.

#![allow(clippy::disallowed_methods, reason = "formulas as a textbook writes them")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so and stop")]

use std::f64::consts::TAU;
use std::fs::File;

use crate::common::{Place, Table, surface_job};
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use serde_json::Value;

/// Disc of the preset: h, b in m, rho in kg/m^3, E in Pa, nu.
const THICKNESS: f64 = 0.02;
const OUTER_RADIUS: f64 = 0.135;
const DENSITY: f64 = 7800.0;
const YOUNGS_MODULUS: f64 = 2.1e11;
const POISSONS_RATIO: f64 = 0.3;

/// lambda^2 of the lowest mode with 0 to 4 nodal diameters, a/b = 0.064/0.135, nu = 0.3, clamped inside and free
/// outside: from the zeros of the determinant of Bessel functions, computed outside this project.
const FREQUENCY_PARAMETERS: [f64; 5] = [11.7565, 11.9802, 13.3679, 17.3691, 24.6646];

/// Flexural rigidity of a disc, N m.
fn rigidity(youngs_modulus: f64, thickness: f64) -> f64 {
    youngs_modulus * thickness.powi(3) / (12.0 * (1.0 - POISSONS_RATIO * POISSONS_RATIO))
}

/// The paper's time scale of the preset, as a number of seconds.
fn time_scale() -> f64 {
    (DENSITY * THICKNESS.powi(4) / rigidity(YOUNGS_MODULUS, THICKNESS)).sqrt()
}

/// Frequency of an annular plate, Hz: `lambda^2 / (2 pi b^2) sqrt(D / (rho h))`.
fn plate_frequency(frequency_parameter: f64, youngs_modulus: f64, thickness: f64) -> f64 {
    let stiffness_over_mass = rigidity(youngs_modulus, thickness) / (DENSITY * thickness);
    frequency_parameter / (TAU * OUTER_RADIUS * OUTER_RADIUS) * stiffness_over_mass.sqrt()
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

/// A number by its path, as in `limit_cycle.period_s`.
#[track_caller]
fn number(value: &Value, path: &str) -> f64 {
    let found = path.split('.').try_fold(value, |value, key| value.get(key));
    found.and_then(Value::as_f64).unwrap_or_else(|| panic!("no number {path} in {value:#}"))
}

#[track_caller]
fn assert_close(value: f64, expected: f64, tolerance: f64) {
    assert!((value - expected).abs() <= tolerance * expected.abs(), "{value} {expected}");
}

/// Name and unit of every column.
fn units(place: &Place, file: &str) -> Vec<(String, String)> {
    let builder = ParquetRecordBatchReaderBuilder::try_new(File::open(place.path(file)).unwrap()).unwrap();
    let fields = builder.schema().fields().iter();
    fields.map(|field| (field.name().clone(), field.metadata().get("unit").cloned().unwrap_or_default())).collect()
}

#[test]
fn small_motions_of_the_pad_are_those_of_its_equations_in_si() {
    let analysis = json(&Place::new().run("analyse --json").done().stdout);
    let p = |key: &str| analysis["parameters"][key].as_f64().unwrap();
    let (mass, inertia) = (p("pad.mass"), p("pad.moment_of_inertia"));
    let (k_y, k_en) = (p("stiffness.calliper_normal"), p("stiffness.contact_normal"));
    let (k_t1, k_t2) = (p("stiffness.contact_tangential_1"), p("stiffness.contact_tangential_2"));
    let sliding_speed = OUTER_RADIUS * p("operating_point.rotating_speed");
    assert_close(number(&analysis, "speed_under_pad_m_s"), sliding_speed, 1e-12);

    // Springs in series, pressed together by the displacement h Delta.
    let contact_force = k_en * k_y / (k_en + k_y) * THICKNESS * p("operating_point.preload");
    assert_close(number(&analysis, "normal_force_n"), contact_force, 1e-12);
    assert_close(number(&analysis, "preload_mm"), 1e3 * THICKNESS * p("operating_point.preload"), 1e-12);
    let friction = number(&analysis, "friction_coefficient") * contact_force;
    let x = k_t2 / k_t1 * friction / (p("stiffness.calliper_tangential") + k_t2);
    assert_close(number(&analysis, "equilibrium.x_mm"), 1e3 * x, 1e-12);
    assert_close(number(&analysis, "equilibrium.y_mm"), -1e3 * contact_force / k_en, 1e-12);

    // The friction force falls with the sliding speed: a negative damper, N s/m.
    let velocity = p("friction.stribeck_velocity");
    let fall = (p("friction.static_coefficient") - p("friction.kinetic_coefficient")) / velocity
        * (-sliding_speed / velocity).exp();
    let tangential_damping = p("damping.tangential") - k_t2 / k_t1 * contact_force * fall;
    let tangential_stiffness = p("stiffness.calliper_tangential") + k_t2;
    for (mode, stiffness, damping, mass) in [
        ("tangential", tangential_stiffness, tangential_damping, mass),
        ("normal", k_y + k_en, p("damping.normal"), mass),
        ("angular", p("stiffness.calliper_angular"), p("damping.angular"), inertia),
    ] {
        let rate = -0.5 * damping / mass;
        let frequency = (stiffness / mass - rate * rate).sqrt() / TAU;
        assert_close(number(&analysis, &format!("pad_modes.{mode}.growth_rate_per_s")), rate, 1e-9);
        assert_close(number(&analysis, &format!("pad_modes.{mode}.frequency_hz")), frequency, 1e-9);
    }
    // This brake squeals.
    let squeal = number(&analysis, "pad_modes.tangential.frequency_hz");
    assert!((3600.0..3800.0).contains(&squeal), "{squeal}");
    assert_close(number(&analysis, "growth_rate_per_s"), -0.5 * tangential_damping / mass, 1e-9);
}

#[test]
fn analyse_converts_its_other_numbers_by_the_scales_of_the_paper() {
    let place = Place::new();
    let analysis = json(&place.run("analyse --json").done().stdout);
    let tau = time_scale();
    assert_close(tau, 9.0e-5, 1e-2);
    assert_close(number(&analysis, "time_scale_s"), tau, 1e-12);
    assert_close(number(&analysis, "length_scale_m"), THICKNESS, 1e-12);
    assert_close(number(&analysis, "speed_scale_m_s"), THICKNESS / tau, 1e-12);
    for (in_si, scaled, factor) in [
        ("growth_rate_per_s", "growth_rate", 1.0 / tau),
        ("coupled_growth_rate_per_s", "coupled_growth_rate", 1.0 / tau),
        ("critical_speed_m_s", "critical_speed_rad_s", OUTER_RADIUS),
        ("saddle_node_speed_m_s", "saddle_node_speed_rad_s", OUTER_RADIUS),
        ("end_of_cycles_m_s", "end_of_cycles_rad_s", OUTER_RADIUS),
        ("critical_preload_mm", "critical_preload", 1e3 * THICKNESS),
        ("smallest_knock.speed_m_s", "smallest_knock.speed", THICKNESS / tau),
        ("smallest_knock.forward_m_s", "smallest_knock.forward", THICKNESS / tau),
        ("smallest_knock.backward_m_s", "smallest_knock.backward", THICKNESS / tau),
        ("smallest_knock.displacement_mm", "smallest_knock.displacement", 1e3 * THICKNESS),
        ("smallest_knock.outward_mm", "smallest_knock.outward", 1e3 * THICKNESS),
        ("smallest_knock.inward_mm", "smallest_knock.inward", 1e3 * THICKNESS),
        ("basin_area_m2_s", "basin_area", THICKNESS * THICKNESS / tau),
        ("limit_cycle.period_s", "limit_cycle.period", tau),
        ("limit_cycle.x_max_mm", "limit_cycle.x_max", 1e3 * THICKNESS),
        ("limit_cycle.x_min_mm", "limit_cycle.x_min", 1e3 * THICKNESS),
    ] {
        assert_close(number(&analysis, in_si), factor * number(&analysis, scaled), 1e-12);
    }
    assert_close(number(&analysis, "limit_cycle.frequency_hz") * number(&analysis, "limit_cycle.period_s"), 1.0, 1e-12);
    let force_per_preload = number(&analysis, "normal_force_n") / 0.1;
    let critical = number(&analysis, "critical_normal_force_n");
    assert_close(critical, force_per_preload * number(&analysis, "critical_preload"), 1e-12);
    assert!(analysis["lower_critical_speed_m_s"].is_null());
    let gaussian = place.run("analyse --set friction.stribeck_exponent=2 --set damping.tangential=200 --json");
    let gaussian = json(&gaussian.done().stdout);
    let lower = OUTER_RADIUS * number(&gaussian, "lower_critical_speed_rad_s");
    assert_close(number(&gaussian, "lower_critical_speed_m_s"), lower, 1e-12);
    // Where there is no speed there is none in m/s.
    let flat = json(&place.run("analyse --set friction.kinetic_coefficient=0.39 --json").done().stdout);
    for key in ["critical_speed_m_s", "saddle_node_speed_m_s", "critical_preload_mm", "limit_cycle", "smallest_knock"] {
        assert!(flat[key].is_null(), "{key} {}", flat[key]);
    }
}

/// The softer the disc, the less the calliper presses the pad, by its spring along y; all else is in proportion to that force.
#[test]
fn analyse_has_the_equilibrium_of_either_disc() {
    let place = Place::new();
    for (modulus, yields) in [("1e13", 5e-4..1e-3), ("2.1e11", 0.02..0.04), ("2e10", 0.2..0.3)] {
        let analysis = json(&place.run(&format!("analyse --set disc.youngs_modulus={modulus} --json")).done().stdout);
        let of = |disc: &str| ["x_mm", "y_mm", "phi"].map(|name| number(&analysis, &format!("{disc}.{name}")));
        let [[x, y, phi], [rigid_x, rigid_y, rigid_phi]] = ["coupled_equilibrium", "equilibrium"].map(of);
        let force = (number(&analysis, "preload_mm") + y) / (number(&analysis, "preload_mm") + rigid_y);
        assert!(yields.contains(&(1.0 - force)), "{modulus}: {force}");
        assert_close(x, force * rigid_x, 5e-3);
        assert_close(phi, force * rigid_phi, 5e-3);
    }
}

#[test]
fn the_text_of_analyse_shows_both_units() {
    let place = Place::new();
    let text = place.run("analyse").done().stdout;
    for expected in [
        "tangential, x    -0.013162 +- 2.090397 i  3.694 kHz, growth rate -146.1 1/s",
        "\nSteady sliding on a rigid disc\n  contact force                             35097.5 N\n  equilibrium x0   ",
        " disc modes\n  equilibrium x0   ",
        "critical speed     15.5599 rad/s, unstable below (2.101 m/s under the pad)",
        "period           3.20259                  0.2884 ms",
        "3.224, 3.285, 3.666, 4.763, 6.764 kHz",
    ] {
        assert!(text.contains(expected), "{expected}\n{text}");
    }
    // An overdamped motion has no frequency.
    let text = place.run("analyse --set damping.tangential=1e6").done().stdout;
    assert!(text.contains("no oscillation, growth rates -"), "{text}");
}

#[test]
fn disc_frequencies_in_hertz_are_those_of_the_textbooks_plate() {
    let place = Place::new();
    // Another thickness too: a scale with a wrong power of it would show.
    for (youngs_modulus, thickness) in [(YOUNGS_MODULUS, THICKNESS), (7e10, 0.008)] {
        let words =
            format!("analyse --set disc.youngs_modulus={youngs_modulus} --set disc.thickness={thickness} --json");
        let analysis = json(&place.run(&words).done().stdout);
        let shown = analysis["disc_frequencies_hz"].as_array().unwrap();
        assert_eq!(shown.len(), FREQUENCY_PARAMETERS.len());
        for (shown, parameter) in shown.iter().zip(FREQUENCY_PARAMETERS) {
            assert_close(shown.as_f64().unwrap(), plate_frequency(parameter, youngs_modulus, thickness), 1e-5);
        }
    }
}

/// Columns of a time series: the scaled ones as they always were, then those in SI.
const TIME_SERIES: [(&str, &str); 24] = [
    ("time", "1"),
    ("x", "1"),
    ("x_speed", "1"),
    ("y", "1"),
    ("y_speed", "1"),
    ("phi", "rad"),
    ("phi_speed", "rad"),
    ("sliding_speed", "1"),
    ("friction_coefficient", "1"),
    ("friction_force_n", "N"),
    ("contact_force_n", "N"),
    ("sticks", "1"),
    ("contact_share", "1"),
    ("deflection_edge", "1"),
    ("deflection_inside", "1"),
    ("time_s", "s"),
    ("x_mm", "mm"),
    ("x_speed_m_s", "m/s"),
    ("y_mm", "mm"),
    ("y_speed_m_s", "m/s"),
    ("phi_speed_rad_s", "rad/s"),
    ("sliding_speed_m_s", "m/s"),
    ("deflection_edge_mm", "mm"),
    ("deflection_inside_mm", "mm"),
];

/// Columns in SI with the scaled ones that they repeat, and the factor between them with the preset.
fn conversions() -> [(&'static str, &'static str, f64); 9] {
    let (tau, mm, m_s) = (time_scale(), 1e3 * THICKNESS, THICKNESS / time_scale());
    [
        ("time_s", "time", tau),
        ("x_mm", "x", mm),
        ("x_speed_m_s", "x_speed", m_s),
        ("y_mm", "y", mm),
        ("y_speed_m_s", "y_speed", m_s),
        ("phi_speed_rad_s", "phi_speed", 1.0 / tau),
        ("sliding_speed_m_s", "sliding_speed", m_s),
        ("deflection_edge_mm", "deflection_edge", mm),
        ("deflection_inside_mm", "deflection_inside", mm),
    ]
}

#[test]
fn a_time_series_has_si_columns_after_the_scaled_ones() {
    let place = Place::new();
    for (disc, horizon) in [("rigid", 100), ("flexible", 100), ("finite-difference", 5)] {
        let words = format!("trajectory --disc {disc} --start rest --set operating_point.rotating_speed=10");
        let words = format!("{words} --horizon {horizon} --out motion.parquet --json");
        let summary = json(&place.run(&words).done().stdout);
        let expected = TIME_SERIES.map(|(name, unit)| (name.to_owned(), unit.to_owned()));
        assert_eq!(units(&place, "motion.parquet"), expected, "{disc}");
        let motion = Table::read(&place.path("motion.parquet"));
        for (in_si, scaled, factor) in conversions() {
            for (value, scaled) in motion.column(in_si).iter().zip(motion.column(scaled)) {
                assert_close(*value, factor * scaled, 1e-12);
            }
        }
        for (in_si, scaled, factor) in [
            ("x_max_mm", "x_max", 1e3 * THICKNESS),
            ("x_min_mm", "x_min", 1e3 * THICKNESS),
            ("x_mean_mm", "x_mean", 1e3 * THICKNESS),
            ("amplitude_mm", "amplitude", 1e3 * THICKNESS),
            ("horizon_s", "horizon", time_scale()),
            ("interval_s", "interval", time_scale()),
        ] {
            assert_close(number(&summary, in_si), factor * number(&summary, scaled), 1e-12);
        }
        assert_close(
            number(&summary, "amplitude"),
            0.5 * (number(&summary, "x_max") - number(&summary, "x_min")),
            1e-12,
        );
        assert_close(number(&summary, "speed_under_pad_m_s"), OUTER_RADIUS * 10.0, 1e-12);
        assert_close(number(&summary, "preload_mm"), 2.0, 1e-12);
        if disc == "finite-difference" {
            continue;
        }
        let period = number(&summary, "period_s");
        assert_close(period, time_scale() * number(&summary, "period"), 1e-12);
        assert_close(number(&summary, "frequency_hz"), 1.0 / period, 1e-12);

        // Without any scale: a speed is the derivative of a displacement, and pad and disc add up to b Omega.
        let (time, x) = (motion.column("time_s"), motion.column("x_mm"));
        let (speed, sliding) = (motion.column("x_speed_m_s"), motion.column("sliding_speed_m_s"));
        let (mut deviations, mut speeds) = (0.0, 0.0);
        for row in 1..time.len() - 1 {
            let derivative = 1e-3 * (x[row + 1] - x[row - 1]) / (time[row + 1] - time[row - 1]);
            deviations += (derivative - speed[row]).abs();
            speeds += speed[row].abs();
            assert_close(speed[row] + sliding[row], OUTER_RADIUS * 10.0, 1e-9);
        }
        assert!(deviations < 0.03 * speeds, "{disc}: {deviations} {speeds}");
    }
}

#[test]
fn forces_in_newtons_balance_the_springs_of_the_pad() {
    // At rest relative to steady sliding every spring holds its force; phi is small, and with arm 0 it vanishes.
    let place = Place::new();
    let (k_y, k_en, k_t1, k_t2) = (3.249e7, 3.816e7, 2.138e7_f64, 2.138e7_f64);
    let analysis = json(&place.run("analyse --json").done().stdout);
    let p = |key: &str| analysis["parameters"][key].as_f64().unwrap();
    assert_eq!((p("stiffness.calliper_normal"), p("stiffness.contact_normal")), (k_y, k_en));
    assert_eq!((p("stiffness.contact_tangential_1"), p("stiffness.contact_tangential_2")), (k_t1, k_t2));
    let k_x = p("stiffness.calliper_tangential");
    for (disc, tolerance) in [("rigid", 1e-9), ("flexible", 1e-6)] {
        let words = format!("trajectory --disc {disc} --set operating_point.rotating_speed=35 --set pad.moment_arm=0");
        let summary = json(&place.run(&format!("{words} --horizon 2000 --out motion.parquet --json")).done().stdout);
        let motion = Table::read(&place.path("motion.parquet"));
        let last = |name: &str| *motion.column(name).last().unwrap();
        let contact_force = k_y * (2.0e-3 + 1e-3 * last("y_mm"));
        assert_close(last("contact_force_n"), contact_force, tolerance);
        assert_close(number(&summary, "contact_force_max_n"), contact_force, 1e-4);
        assert_close(number(&summary, "contact_force_min_n"), contact_force, 1e-4);
        let friction_force = k_t1 / k_t2 * (k_x + k_t2) * 1e-3 * last("x_mm");
        assert_close(last("friction_force_n"), friction_force, tolerance);
        if disc == "rigid" {
            assert_close(contact_force, k_en * k_y / (k_en + k_y) * 2.0e-3, 1e-12);
        }
        assert!(summary["period"].is_null() && summary["period_s"].is_null() && summary["frequency_hz"].is_null());
    }
}

#[test]
fn trajectory_and_replay_name_their_units() {
    let place = Place::new();
    let text = place
        .run("trajectory --disc rigid --start rest --set operating_point.rotating_speed=10 --horizon 200")
        .done()
        .stdout;
    for expected in [
        "rotating speed     10 rad/s (1.350 m/s under the pad)",
        "preload            0.1 (2.000 mm)",
        "                   scaled                   SI",
        "largest x          0.014309                 0.2862 mm",
        "period             3.56374                  0.3210 ms",
        "frequency          0.2806                   3.116 kHz",
        "contact force                               35.10 kN",
    ] {
        assert!(text.lines().any(|line| line == expected), "{expected}\n{text}");
    }
    place.write("job.toml", &surface_job("eigen", 3, 25, 3));
    place.run("submit job.toml").done();
    let words = "replay runs/eigen --cell 8 --sample 3 --horizon 50";
    let replayed = json(&place.run(&format!("{words} --json --out sample.parquet")).done().stdout);
    assert_close(number(&replayed, "preload_mm"), 1e3 * THICKNESS * number(&replayed, "preload"), 1e-12);
    assert_close(number(&replayed, "speed_under_pad_m_s"), OUTER_RADIUS * 15.0, 1e-12);
    assert_close(number(&replayed, "x_max_mm"), 1e3 * THICKNESS * number(&replayed, "x_max"), 1e-12);
    assert_eq!(units(&place, "sample.parquet"), TIME_SERIES.map(|(name, unit)| (name.to_owned(), unit.to_owned())));
    let text = place.run(words).done().stdout;
    assert!(text.contains("\nrotating speed     15 rad/s (2.025 m/s under the pad)\n"), "{text}");
}

#[test]
fn present_keys_of_the_summaries_stay() {
    let place = Place::new();
    let analysis = json(&place.run("analyse --json").done().stdout);
    for key in "equilibrium normal_force_n friction_coefficient eigenvalues growth_rate stable coupled_growth_rate \
                coupled_stable coupled_fed_by disc_modes unstable_speeds critical_speed_rad_s \
                lower_critical_speed_rad_s saddle_node_speed_rad_s limit_cycle critical_static_friction \
                critical_preload time_scale_s parameters"
        .split_whitespace()
    {
        assert!(analysis.get(key).is_some(), "{key}");
    }
    let trajectory = json(&place.run("trajectory --disc rigid --horizon 20 --json").done().stdout);
    for key in "verdict fed_by x_max x_min x_mean period stick_fraction horizon interval moments file disc start \
                rotating_speed_rad_s preload static_friction"
        .split_whitespace()
    {
        assert!(trajectory.get(key).is_some(), "{key}");
    }
}

#[test]
fn figures_carry_si_beside_the_papers_axes() {
    let place = Place::new();
    let printed = place.run("reproduce fig4").done().stdout;
    assert!(printed.contains("preload 0.1 (2.000 mm, 35.10 kN): critical speed 15.560 rad/s (2.101 m/s)"), "{printed}");
    let pairs = |pairs: &[(&str, &str)]| -> Vec<(String, String)> {
        pairs.iter().map(|(name, unit)| ((*name).to_owned(), (*unit).to_owned())).collect()
    };
    let growth = "runs/fig4/growth_rate.parquet";
    assert_eq!(
        units(&place, growth),
        pairs(&[
            ("rotating_speed_rad_s", "rad/s"),
            ("preload", "1"),
            ("growth_rate", "1"),
            ("speed_under_pad_m_s", "m/s"),
            ("growth_rate_per_s", "1/s"),
        ])
    );
    let table = Table::read(&place.path(growth));
    for row in 0..table.column("preload").len() {
        let of = |name: &str| table.column(name)[row];
        assert_close(of("growth_rate_per_s"), of("growth_rate") / time_scale(), 1e-12);
        assert_close(of("speed_under_pad_m_s"), OUTER_RADIUS * of("rotating_speed_rad_s"), 1e-12);
    }

    let printed = place.run("reproduce fig10").done().stdout;
    assert!(printed.contains("in SI: 3.142, 6.285,"), "{printed}");
    let spectra = "runs/fig10/pad_spectra.parquet";
    assert_eq!(
        units(&place, spectra),
        pairs(&[
            ("frequency_hz", "Hz"),
            ("x", "1"),
            ("y", "1"),
            ("phi", "rad"),
            ("frequency_khz", "kHz"),
            ("x_mm", "mm"),
            ("y_mm", "mm"),
        ])
    );
    let table = Table::read(&place.path(spectra));
    for row in 0..table.column("x").len() {
        let of = |name: &str| table.column(name)[row];
        assert_close(of("frequency_khz"), 1e-3 * of("frequency_hz") / time_scale(), 1e-12);
        assert_close(of("x_mm"), 1e3 * THICKNESS * of("x"), 1e-12);
    }

    let printed = place.run("reproduce scoreboard").done().stdout;
    assert!(printed.contains("Our disc frequencies are 3.224 kHz, 21.03 kHz, 60.36 kHz."), "{printed}");
    let printed = place.run("reproduce table3").done().stdout;
    let expected =
        "in SI: the disc passes the pad at 2.160 m/s;\n    the preload is 2.000 mm, 35.10 kN of contact force";
    assert!(printed.contains(expected), "{printed}");
}
