//! Plots of finished runs, as a user asks for them.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so and stop")]

mod common;

use std::fs;

use common::{Place, submitted};

fn job(name: &str, axes: &str, samples: u64) -> String {
    format!(
        "name = \"{name}\"\n[axes]\n{axes}\n[random]\ninputs = [\"preload\", \"static_friction\"]\nrelative_std = 0.2\n\
         [criterion]\nkind = \"eigenvalue\"\n[sampling]\nsamples = {samples}\nseed = 1\n"
    )
}

const PLANE: &str = "rotating_speed = 15.0\npreload = { from = 0.02, to = 0.3, points = 15 }\n\
                     static_friction = { from = 0.25, to = 0.5, points = 12 }";

/// Width and height of a PNG, from its first chunk.
fn size(png: &[u8]) -> (u32, u32) {
    assert_eq!(&png[..8], b"\x89PNG\r\n\x1a\n");
    let number = |at: usize| u32::from_be_bytes(png[at..at + 4].try_into().unwrap());
    (number(16), number(20))
}

#[test]
fn a_surface_is_drawn_as_svg_and_png_with_its_axes_levels_and_boundary() {
    let place = Place::new();
    submitted(&place, "plane", &job("plane", PLANE, 3000));
    let told = place.run("plot plane").done().stdout;
    assert_eq!(told, "plane/surface.svg\nplane/surface.png\n");
    let svg = fs::read_to_string(place.path("plane/surface.svg")).unwrap();
    for text in [
        "Preload Δ",
        "Static friction coefficient fₛ",
        "Probability of instability",
        ">0.01<",
        ">0.05<",
        ">0.95<",
        "15 rad/s; relative std: preload 0.2, friction 0.2",
        "dashed: stability boundary of the expected brake",
    ] {
        assert!(svg.contains(text), "{text}");
    }
    // 174 mm at 300 dots an inch.
    let (width, height) = size(&fs::read(place.path("plane/surface.png")).unwrap());
    assert!(width.abs_diff(2055) <= 1 && height > width / 2, "{width} {height}");
    // The same run gives the same bytes.
    place.run("plot plane --out again.svg").done();
    assert_eq!(fs::read_to_string(place.path("again.svg")).unwrap(), svg);
    place.run("plot plane --columns 1 --out narrow.png").done();
    assert!(size(&fs::read(place.path("narrow.png")).unwrap()).0.abs_diff(992) <= 1);
}

#[test]
fn every_slice_has_a_panel_and_wide_intervals_are_hatched() {
    let place = Place::new();
    let axes = PLANE.replace("= 15.0", "= [12.0, 15.0, 18.0]");
    let lines = |samples: u64, name: &str| {
        submitted(&place, name, &job(name, &axes, samples));
        place.run(&format!("plot {name} --out {name}.svg")).done();
        let svg = fs::read_to_string(place.path(&format!("{name}.svg"))).unwrap();
        for speed in [12, 15, 18] {
            assert!(svg.contains(&format!("{speed} rad/s")), "{speed}");
        }
        svg.matches("<line").count()
    };
    let (few, many) = (lines(30, "few"), lines(100_000, "many"));
    assert!(few > many + 500, "hatching: {few} lines with 30 samples, {many} with 100,000");
}

#[test]
fn one_long_axis_is_a_curve_with_its_band() {
    let place = Place::new();
    let axes =
        "rotating_speed = { from = 5, to = 30, points = 26 }\npreload = [0.05, 0.1, 0.2]\nstatic_friction = 0.39";
    submitted(&place, "curves", &job("curves", axes, 1000));
    place.run("plot curves --out curves.svg").done();
    let svg = fs::read_to_string(place.path("curves.svg")).unwrap();
    for text in ["Rotating speed Ω (rad/s)", "Probability of instability P", ">0.05<", ">0.1<", ">0.2<"] {
        assert!(svg.contains(text), "{text}");
    }
    assert_eq!(svg.matches("opacity=\"0.25\"").count(), 3, "one band a curve");
}

#[test]
fn a_motion_is_drawn_from_its_file() {
    let place = Place::new();
    place
        .run("trajectory --set operating_point.rotating_speed=12 --disc rigid --horizon 100 --out motion.parquet")
        .done();
    assert_eq!(place.run("plot motion.parquet").done().stdout, "motion.svg\nmotion.png\n");
    let svg = fs::read_to_string(place.path("motion.svg")).unwrap();
    for text in
        ["Time t (", "Tangential displacement x (", "Tangential velocity x′ (", "Friction force (", "Contact force ("]
    {
        assert!(svg.contains(text), "{text}");
    }
    for text in ["Spectrum of x in the second half", "Frequency (", "Amplitude of x (mm)"] {
        assert!(svg.contains(text), "{text}");
    }
    // A frame in each of the six panels and a line, in pieces where it leaves the panel.
    assert!(svg.matches("<polyline").count() + svg.matches("<path").count() >= 12, "{svg}");
}

#[test]
fn what_cannot_be_drawn_is_said() {
    let place = Place::new();
    fs::write(place.path("other.parquet"), "no Parquet").unwrap();
    place.run("plot other.parquet").refused(74, &["other.parquet", "stickslip trajectory --out"]);
    submitted(&place, "plane", &job("plane", PLANE, 100));
    place.run("plot nowhere").refused(74, &["nowhere is not a run directory"]);
    place.run("plot plane --out plot.gif").refused(64, &["SVG or PNG", "plot.svg"]);
    place.run("plot plane --columns 3").refused(64, &["3"]);
    place.run("plot plane --out no/such/folder/plot.svg").refused(73, &["no/such/folder"]);
    fs::remove_file(place.path("plane/surface.parquet")).unwrap();
    place.run("plot plane").refused(65, &["has no surface yet", "stickslip resume plane"]);
    fs::write(place.path("plane/surface.parquet"), "no Parquet").unwrap();
    place.run("plot plane").refused(65, &["has no surface yet"]);
}
