//! Plots of finished runs, as a user asks for them.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so and stop")]

use std::fs;

use crate::common::{Place, submitted};

fn job(name: &str, axes: &str, samples: u64) -> String {
    format!(
        "name = \"{name}\"\n[axes]\n{axes}\n[random]\ninputs = [\"preload\", \"static_friction\"]\nrelative_std = 0.2\n\
         [criterion]\nkind = \"eigenvalue\"\n[sampling]\nsamples = {samples}\nseed = 1\n"
    )
}

const PLANE: &str = "rotating_speed = 15.0\npreload = { from = 0.02, to = 0.3, points = 15 }\n\
                     static_friction = { from = 0.25, to = 0.5, points = 12 }";

/// Colours of bars of Sobol indices.
const FIRST_ORDER: &str = "#0072b2";
const TOTAL: &str = "#e69f00";

/// The least and the largest of the first of each two numbers: how far a line or an area extends to the right.
fn extent(points: &str) -> [f64; 2] {
    let numbers = points.split(|c: char| !c.is_ascii_digit() && !"-.".contains(c)).filter(|number| !number.is_empty());
    let right: Vec<f64> = numbers.step_by(2).map(|number| number.parse().unwrap()).collect();
    [right.iter().copied().fold(f64::INFINITY, f64::min), right.iter().copied().fold(f64::NEG_INFINITY, f64::max)]
}

/// The area of a polygon.
fn surface_of(polygon: &str) -> f64 {
    let numbers = polygon.split(['M', 'L', ',']).filter(|number| !number.is_empty());
    let numbers: Vec<f64> = numbers.map(|number| number.parse().unwrap()).collect();
    let corners: Vec<[f64; 2]> = numbers.chunks(2).map(|pair| [pair[0], pair[1]]).collect();
    let next = corners.iter().cycle().skip(1);
    0.5 * corners.iter().zip(next).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum::<f64>().abs()
}

/// How far to the right the lines or areas extend whose description has this text, such as a colour.
fn areas(svg: &str, colour: &str) -> Vec<[f64; 2]> {
    let paths = svg.split("<path d=\"").skip(1).filter(|path| path.split('>').next().unwrap().contains(colour));
    paths.map(|path| extent(path.split('"').next().unwrap())).collect()
}

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
    let printed = place.run("plot plane").done().stdout;
    assert_eq!(printed, "plane/surface.svg\nplane/surface.png\n");
    let svg = fs::read_to_string(place.path("plane/surface.svg")).unwrap();
    for text in [
        "Preload Δ",
        "Static friction coefficient f<tspan",
        "Probability of instability",
        ">0.01<",
        ">0.05<",
        ">0.95<",
        "15 rad/s; relative std: preload 0.2, friction 0.2",
        "dashed: stability boundary of the expected values.<",
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
    // Notes that are too long for the figure go on in the next line.
    place.run("plot plane --columns 1 --out narrow.svg").done();
    let narrow = fs::read_to_string(place.path("narrow.svg")).unwrap();
    let notes = narrow.split("<text ").filter(|text| text.contains("font-size=\"9\"") && text.contains("#707070"));
    let notes: Vec<&str> = notes.map(|text| text.split(['<', '>']).nth(1).unwrap()).collect();
    assert!(notes.len() > 2 && notes.iter().all(|note| note.len() < 80), "{notes:?}");
}

#[test]
fn a_page_has_the_size_of_the_figure_and_the_same_bytes_each_time() {
    let place = Place::new();
    submitted(&place, "plane", &job("plane", PLANE, 300));
    for (columns, millimetres) in [(2, 174.0), (1, 84.0)] {
        for file in ["figure.svg", "first.pdf", "second.pdf"] {
            let printed = place.run(&format!("plot plane --columns {columns} --out {file}")).done().stdout;
            assert_eq!(printed, format!("{file}\n"));
        }
        let page = fs::read(place.path("first.pdf")).unwrap();
        assert!(page == fs::read(place.path("second.pdf")).unwrap(), "the same run gives the same bytes");
        assert!(page.starts_with(b"%PDF-"));
        let text = String::from_utf8_lossy(&page);
        assert_eq!(text.matches("/Type /Page\n").count(), 1);
        assert!(!text.contains("Date"));
        let corners = text.split_once("/MediaBox [0 0 ").unwrap().1.split_once(']').unwrap().0;
        let corner: Vec<f64> = corners.split(' ').map(|length| length.parse().unwrap()).collect();
        let svg = fs::read_to_string(place.path("figure.svg")).unwrap();
        let pixels = svg.split_once("viewBox=\"0 0 ").unwrap().1.split_once('"').unwrap().0;
        let pixels: Vec<f64> = pixels.split(' ').map(|length| length.parse().unwrap()).collect();
        assert!((corner[0] - millimetres / 25.4 * 72.0).abs() < 0.01, "{corner:?}");
        assert!((corner[1] - 0.75 * pixels[1]).abs() < 0.01, "{corner:?} {pixels:?}");
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn limits_are_red_lines_on_the_surface_with_gaps_where_there_are_none() {
    let place = Place::new();
    // With an exponent of 2 slow sliding is stable, too: two branches. Little preload is never unstable.
    let axes = "rotating_speed = { from = 0.5, to = 25.0, points = 12 }\npreload = { from = 0.0002, to = 0.02, points = 12 }\nstatic_friction = 0.39";
    let text = job("branches", axes, 400)
        .replace("[axes]", "[model.friction]\nstribeck_exponent = 2.0\n[axes]")
        .replace("samples = 400", "method = \"exact\"")
        .replace("seed = 1\n", "");
    let limit = "[limit]\nof = \"rotating_speed\"\nprobability = [0.5, 1e-5]\n";
    submitted(&place, "branches", &format!("{text}{limit}"));
    place.run("plot branches --out with.svg").done();
    let svg = fs::read_to_string(place.path("with.svg")).unwrap();
    assert!(svg.contains("red: limits of rotating speed"), "{svg}");
    assert!(svg.contains("at P = 0.5, 1e-5"));
    let red = areas(&svg, "#e01030");
    let labels = [">P = 0.5<", ">P = 10⁻⁵<"].map(|label| svg.matches(label).count());
    // Lines are interrupted by their labels, or shortened by one near their end.
    let parts = 4 + labels.iter().sum::<usize>();
    assert!((4..=parts).contains(&red.len()), "{red:?} {labels:?}");
    assert!(labels.iter().all(|&count| count >= 1), "{labels:?}");
    let ends = red.iter().fold([f64::MAX, f64::MIN], |[from, to], [a, b]| [from.min(*a), to.max(*b)]);
    let frame = areas(&svg, "#1a1a1a").into_iter().fold(0.0, |most: f64, [_, to]| most.max(to));
    // The smallest preloads have no limit.
    assert!(ends[0] > 70.0 && ends[1] > 400.0 && ends[1] <= frame + 1.0, "{ends:?} {frame}");
    // The contour at a target is not drawn beside its line.
    place.write("plain.toml", &text);
    place.run("submit plain.toml --out plain").done();
    place.run("plot plain").done();
    let plain = fs::read_to_string(place.path("plain/surface.svg")).unwrap();
    assert!(plain.contains(">0.5</text>") && !plain.contains("#e01030"));
    // Any run can be given limits.
    place.run("limit plain --of rotating_speed --probability 0.5 --probability 1e-5 --out plain/limits.parquet").done();
    place.run("plot plain").done();
    assert!(fs::read_to_string(place.path("plain/surface.svg")).unwrap() == svg);
    // Damaged ones are refused.
    let file = place.path("branches/limits.parquet");
    let mut bytes = fs::read(&file).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&file, bytes).unwrap();
    place.run("plot branches").refused(74, &["limits.parquet is damaged", "stickslip resume branches"]);
    place.run("resume branches").done();
    place.run("report branches").done();
    let page = fs::read_to_string(place.path("branches/report.html")).unwrap();
    assert!(page.contains("\"name\":\"P = 10⁻⁵\""), "the report has them, too");
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
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

/// How often a colour fills an area of the picture.
fn fills(svg: &str, colour: &str) -> usize {
    svg.matches(&format!("fill=\"{colour}\"")).count()
}

#[test]
fn sobol_indices_are_bars_of_first_order_and_total_with_their_intervals() {
    let place = Place::new();
    let axes = "rotating_speed = 15.0\npreload = [0.06, 0.08, 0.10]\nstatic_friction = 0.39";
    let with_indices = |name: &str, axes: &str| job(name, axes, 2000) + "sensitivity = true\n";
    let which = submitted(&place, "which", &with_indices("which", axes));
    assert_eq!(place.run("plot which --of sobol").done().stdout, "which/sobol.svg\nwhich/sobol.png\n");
    let svg = fs::read_to_string(place.path("which/sobol.svg")).unwrap();
    for text in [
        "Preload Δ",
        "Static friction coefficient f<tspan",
        "Share of the variance",
        ">cell 1: P = 0.",
        ">15 rad/s, preload = 0.08<",
        "first order: alone",
        "total: taking part",
        "lines: 95 % intervals",
    ] {
        assert!(svg.contains(text), "{text}");
    }
    // Two inputs in three cells, and a sample in the legend.
    assert_eq!((fills(&svg, FIRST_ORDER), fills(&svg, TOTAL)), (7, 7), "{svg}");
    // The length of a bar is the index of the file.
    let total = which.column("total_static_friction")[1];
    let one = place.run("plot which --of sobol --cell 1 --columns 1 --out one.svg").done();
    assert_eq!(one.stdout, "one.svg\n");
    let svg = fs::read_to_string(place.path("one.svg")).unwrap();
    assert_eq!((fills(&svg, FIRST_ORDER), fills(&svg, TOTAL)), (3, 3));
    let bar = areas(&svg, TOTAL)[1];
    let frame = areas(&svg, "stroke-width=\"0.8\"")[0];
    assert!(((bar[1] - bar[0]) / (frame[1] - frame[0]) - total).abs() < 0.03, "{bar:?} {frame:?} {total}");

    // Of many cells that with the probability nearest one half.
    let many = submitted(&place, "many", &with_indices("many", PLANE));
    place.run("plot many --of sobol --out many.svg").done();
    let svg = fs::read_to_string(place.path("many.svg")).unwrap();
    let p = many.column("p_unstable");
    let nearest = (0..p.len()).min_by(|a, b| (p[*a] - 0.5).abs().total_cmp(&(p[*b] - 0.5).abs())).unwrap();
    assert!(svg.contains(&format!(">cell {nearest}: P = {}<", (p[nearest] * 1e4).round() / 1e4)), "{nearest} {svg}");

    submitted(&place, "plain", &job("plain", axes, 100));
    place.run("plot plain --of sobol").refused(65, &["plain has no Sobol indices", "sensitivity = true"]);
    place.run("plot which --of sobol --cell 3").refused(64, &["--cell 3", "cells 0 to 2"]);
    place.run("plot many --of sobol --cell 0").refused(65, &["cell 0 of many has no Sobol indices", "P is 0"]);
    place.run("plot which --cell 1").refused(64, &["--of sobol"]);
}

/// Colours of differences above 0.2, from 0.01 to 0.02 and about 0, and of the lines of a hatching. Each colour is in the
/// bar, and on the map if some differences are as high or higher.
const HIGHER: &str = "#a1182b";
const JUST_HIGHER: &str = "#faddcc";
const ZERO: &str = "#f1efed";
const HATCHED: &str = "stroke=\"#707070\" stroke-width=\"0.5\"";

#[test]
fn the_difference_of_two_runs_is_a_map_with_its_line_of_zero_and_hatching() {
    let place = Place::new();
    submitted(&place, "plane", &job("plane", PLANE, 1000));
    let other = "[model.friction]\nstribeck_velocity = 0.6\n";
    submitted(&place, "slower", &job("slower", PLANE, 1000).replace("[axes]", &format!("{other}[axes]")));
    let printed = place.run("plot plane --against slower").done().stdout;
    assert_eq!(printed, "plane/difference.svg\nplane/difference.png\n");
    let svg = fs::read_to_string(place.path("plane/difference.svg")).unwrap();
    for text in [
        "Preload Δ",
        "Static friction coefficient f<tspan",
        ">Difference of probability<",
        ">+0.01<",
        ">−0.5<",
        ">P of plane minus P of slower.<",
        "hatched: not significant, 0 is in the 95 % interval for all cells together",
    ] {
        assert!(svg.contains(text), "{text}");
    }
    assert_eq!(fills(&svg, HIGHER), 2);
    let hatched = svg.matches(HATCHED).count();
    assert!(hatched > 20, "{hatched}");
    place.run("plot slower --against plane --columns 1 --out reversed.svg").done();
    let svg = fs::read_to_string(place.path("reversed.svg")).unwrap();
    assert_eq!([JUST_HIGHER, ZERO].map(|colour| fills(&svg, colour)), [1, 2], "the difference is nowhere above zero");
    assert!(svg.contains(">P of slower minus P of plane.<") && !svg.contains(">0<"));

    // A run and itself differ nowhere.
    place.run("plot plane --against plane --out same.svg").done();
    let svg = fs::read_to_string(place.path("same.svg")).unwrap();
    assert!(fills(&svg, ZERO) == 2 && svg.matches(HATCHED).count() > 5 * hatched);

    // Another distribution makes some cells worse and others better, with zero between them.
    let uniform = job("uniform", PLANE, 1000).replace("[criterion]", "distribution = \"uniform\"\n[criterion]");
    submitted(&place, "uniform", &uniform);
    place.run("plot plane --against uniform --out both.svg").done();
    assert!(fs::read_to_string(place.path("both.svg")).unwrap().contains(">0<"), "the label of the line of zero");
}

#[test]
fn the_difference_of_runs_with_one_long_axis_is_a_curve_with_its_interval() {
    let place = Place::new();
    let axes = "rotating_speed = { from = 5, to = 30, points = 26 }\npreload = 0.1\nstatic_friction = 0.39";
    submitted(&place, "all", &job("all", axes, 1000));
    submitted(&place, "few", &job("few", axes, 500));
    place.run("plot few --against all --out curve.svg --threads 1").done();
    let svg = fs::read_to_string(place.path("curve.svg")).unwrap();
    for text in [
        "Rotating speed Ω (rad/s)",
        ">Difference of probability (10⁻³)<",
        "bands: 95 % interval for all cells together",
    ] {
        assert!(svg.contains(text), "{text}");
    }
    assert_eq!(svg.matches("opacity=\"0.25\"").count(), 1, "one band");
    let dashes = svg.matches("stroke=\"#707070\"").count();
    assert!(dashes > 20, "{dashes} dashes of the line at zero");

    submitted(&place, "plane", &job("plane", PLANE, 100));
    place.run("plot plane --against all").refused(
        65,
        &[
            "plane and all have different axes",
            "rotating speed, rad/s has the value 15",
            "26 values from 5 to 30",
            "compare",
        ],
    );
    let wide = job("wide", axes, 500).replace("0.2", "0.1");
    submitted(&place, "wide", &wide);
    place.run("plot wide --against all").refused(65, &["no cell in common", "random.relative_std share values"]);
    place.run("plot all --against nowhere").refused(74, &["nowhere is not a run directory"]);
    place.run("plot all --against few --of sobol").refused(64, &["--against", "leave --of out"]);
    fs::write(place.path("motion.parquet"), "").unwrap();
    place.run("plot motion.parquet --against all").refused(64, &["motion.parquet is a file"]);
}

/// Colours of regions: stable, unstable, undecided.
const REGIONS: [&str; 3] = ["#b3d9f2", "#df8244", "#999999"];

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn a_verdict_map_has_a_panel_for_each_brake_with_its_regions_and_tiles() {
    let place = Place::new();
    let axes = "rotating_speed = [12.0, 18.0]\npreload = [0.05, 0.1]\nstatic_friction = [0.35, 0.4, 0.45]";
    let with = |name: &str, sampling: &str| {
        let text = job(name, axes, 50).replace("kind = \"eigenvalue\"", "kind = \"time-domain\"\ndisc = \"rigid\"");
        text.replace("relative_std = 0.2", "relative_std = 0.05").replace("samples = 50\nseed = 1", sampling)
    };
    submitted(&place, "map", &with("map", "method = \"exact\"\naudit = 0"));
    let printed = place.run("plot map --of verdicts").done().stdout;
    assert_eq!(printed, "map/verdicts.svg\nmap/verdicts.png\n");
    let svg = fs::read_to_string(place.path("map/verdicts.svg")).unwrap();
    for text in [
        ">12 rad/s<",
        ">18 rad/s<",
        "Preload Δ",
        "Static friction coefficient f<tspan",
        ">stable<",
        ">unstable<",
        "dots: expected values of the cells",
    ] {
        assert!(svg.contains(text), "{text}");
    }
    // Both regions in both panels, each as one path, and in the legend; nothing is undecided.
    assert_eq!(REGIONS.map(|colour| fills(&svg, colour)), [3, 3, 0], "{svg}");
    assert!(!svg.contains(">undecided<"));
    // A polygon without an area would be a stray line.
    for path in svg.split("<path d=\"").filter(|path| REGIONS.iter().any(|colour| path.contains(colour))) {
        for polygon in path.split('"').next().unwrap().split('Z').filter(|polygon| !polygon.trim().is_empty()) {
            assert!(surface_of(polygon) > 1e-6, "{polygon}");
        }
    }
    assert_eq!(svg.matches("<circle").count(), 12, "a dot for each cell");
    // Tiles of an eighth from a kinetic friction of 0.25: for friction up to 0.45 * 1.3 three columns, for preloads up
    // to 0.1 * 1.3 two rows.
    assert_eq!(svg.matches("stroke=\"#ffffff\" stroke-width=\"0.4\"").count(), 2 * 6);
    // The faster disc is stable up to a larger preload: its region is larger.
    place.run("plot map --of verdicts --columns 1 --out narrow.png").done();
    assert!(size(&fs::read(place.path("narrow.png")).unwrap()).0.abs_diff(992) <= 1);

    // Runs that have no map.
    submitted(&place, "each", &with("each", "samples = 20\nseed = 1"));
    place
        .run("plot each --of verdicts")
        .refused(65, &["each has no verdict map", "evaluate = \"boundary\"", "\"exact\""]);
    place.run("plot nowhere --of verdicts").refused(74, &["nowhere is not a run directory"]);
}

#[test]
fn a_run_without_scatter_is_drawn_as_cells_of_two_colours() {
    let place = Place::new();
    let basin = |name: &str, axes: &str, criterion: &str| {
        format!("name = \"{name}\"\n[axes]\n{axes}\n[criterion]\n{criterion}\n[sampling]\nsamples = 1\n")
    };
    let axes = "rotating_speed = 25.0\n\"start.tangential\" = { from = -4e-4, to = 4e-4, points = 9 }\n\
                \"start.velocity\" = { from = -6.0, to = 6.0, points = 7 }";
    let motion = "kind = \"time-domain\"\ndisc = \"rigid\"\nstart = { from_equilibrium = true }";
    submitted(&place, "basin", &basin("basin", axes, motion));
    place.run("plot basin").done();
    let svg = fs::read_to_string(place.path("basin/surface.svg")).unwrap();
    for text in ["Tangential displacement x at the start (", "Tangential velocity x′ at the start (m/s)", ">25 rad/s;"]
    {
        assert!(svg.contains(text), "{text}");
    }
    assert!(svg.contains(">steady sliding<") && svg.contains(">stick-slip<") && !svg.contains("Probability"), "{svg}");
    assert_eq!(REGIONS.map(|colour| fills(&svg, colour)), [2, 2, 0], "a path and a sample in the legend: {svg}");
    // The cells of the basin: so wide is the widest row of them.
    let stable = areas(&svg, REGIONS[0])[0];
    let frame = areas(&svg, "stroke-width=\"0.8\"")[0];
    let cells = 9.0 * (stable[1] - stable[0]) / (frame[1] - frame[0]);
    assert!((cells - cells.round()).abs() < 0.01 && (1.5..5.0).contains(&cells), "{cells}");

    // Over one axis, a strip.
    submitted(&place, "linear", &basin("linear", "rotating_speed = [10.0, 45.0]", "kind = \"eigenvalue\""));
    place.run("plot linear --out linear.svg").done();
    let svg = fs::read_to_string(place.path("linear.svg")).unwrap();
    assert!(svg.contains(">stable<") && svg.contains(">unstable<"), "{svg}");
}

#[test]
fn a_motion_is_drawn_from_its_file() {
    let place = Place::new();
    place
        .run("trajectory --set operating_point.rotating_speed=12 --disc rigid --horizon 100 --out motion.parquet")
        .done();
    assert_eq!(place.run("plot motion.parquet").done().stdout, "motion.svg\nmotion.png\n");
    let svg = fs::read_to_string(place.path("motion.svg")).unwrap();
    for text in ["Time t (", "Tangential displacement x (", "Tangential velocity x′ (", "Friction force ("] {
        assert!(svg.contains(text), "{text}");
    }
    for text in ["Spectrum of x in the second half", "Frequency (", "Amplitude of x (mm)"] {
        assert!(svg.contains(text), "{text}");
    }
    // A frame in each of the four panels and a line, in pieces where it leaves the panel. Nothing moves the disc.
    assert!(svg.matches("<polyline").count() + svg.matches("<path").count() >= 8, "{svg}");
    assert!(!svg.contains("Contact force") && !svg.contains("Normal displacement"));
    let flexible = "trajectory --disc flexible --horizon 60 --out flexible.parquet";
    place.run(flexible).done();
    place.run("plot flexible.parquet").done();
    let svg = fs::read_to_string(place.path("flexible.svg")).unwrap();
    assert!(svg.contains("Contact force (") && svg.contains("Normal displacement y"));
}

#[test]
fn a_part_of_a_motion_is_drawn_under_a_title() {
    let place = Place::new();
    place.run("trajectory --disc rigid --horizon 100 --out motion.parquet").done();
    place.run("plot motion.parquet --from 0.002 --to 0.004 --title Squeal --out part.svg").done();
    let svg = fs::read_to_string(place.path("part.svg")).unwrap();
    for text in [">Squeal<", ">Spectrum of x in this time<", ">2.5<", ">3.5<", ">Time t (ms)<"] {
        assert!(svg.contains(text), "{text}");
    }
    assert!(!svg.contains(">1.5<") && !svg.contains(">4.5<"), "times outside");
    place.run("plot motion.parquet --from 0.008 --out end.svg").done();
    submitted(&place, "plane", &job("plane", PLANE, 100));
    for (options, why) in [
        ("motion.parquet --from 1", "--from 1 is not before its end at 0.009"),
        ("motion.parquet --to 1", "--to 1 is after its end at 0.009"),
        ("motion.parquet --from 0.004 --to 0.002", "--from 0.004 is not before --to 0.002"),
        ("motion.parquet --from 0.004 --to 0.0040001", "a picture needs 10"),
        ("motion.parquet --from=-1", "a time is a number of seconds"),
        ("motion.parquet --to 2ms", "a time is a number of seconds"),
        ("motion.parquet --at preload=1", "--at is for the probability of a run"),
        ("plane --from 0.1", "--from and --to choose the time of a motion"),
    ] {
        place.run(&format!("plot {options}")).refused(64, &[why]);
    }
}

#[test]
fn many_slices_make_a_figure_of_a_page_spread_over_their_axis() {
    let place = Place::new();
    let axes = "rotating_speed = { from = 2.0, to = 20.0, points = 19 }\npreload = { from = 0.05, to = 0.3, points = 20 }\nstatic_friction = { from = 0.3, to = 0.5, points = 21 }";
    submitted(&place, "many", &job("many", axes, 20));
    let drawn = place.run("plot many --columns 1 --out many.svg").done();
    let said = "19 panels are too many for one figure; those with 12 of the 19 values of rotating_speed are drawn. `--at rotating_speed=VALUE` draws any other";
    assert!(drawn.stderr.contains(said), "{}", drawn.stderr);
    let svg = fs::read_to_string(place.path("many.svg")).unwrap();
    assert_eq!(svg.matches(" rad/s; relative std").count(), 12);
    assert!(svg.contains(">2 rad/s; ") && svg.contains(">20 rad/s; "), "both ends");
    let height: f64 = svg.split_once("viewBox=\"0 0 ").unwrap().1.split(['"', ' ']).nth(1).unwrap().parse().unwrap();
    assert!(height < 4000.0, "{height}");
    assert!(place.run("plot many --at rotating_speed=3 --out one.svg").done().stderr.is_empty());
}

#[test]
fn what_cannot_be_drawn_is_said() {
    let place = Place::new();
    fs::write(place.path("other.parquet"), "no Parquet").unwrap();
    place.run("plot other.parquet").refused(74, &["other.parquet", "stickslip trajectory --out"]);
    submitted(&place, "plane", &job("plane", PLANE, 100));
    place.run("plot nowhere").refused(74, &["nowhere is not a run directory"]);
    place.run("plot plane --out plot.gif").refused(64, &["SVG, PDF or PNG", "plot.svg or plot.pdf or plot.png"]);
    submitted(&place, "single", &job("single", "rotating_speed = 15.0\npreload = 0.1\nstatic_friction = 0.39", 1000));
    place
        .run("plot single")
        .refused(65, &["single has a single cell", "is 0.517 (0.486", "[axes] more than one value"]);
    place.run("plot plane --columns 3").refused(64, &["3"]);
    place.run("plot plane --out no/such/folder/plot.svg").refused(73, &["no/such/folder"]);
    fs::remove_file(place.path("plane/surface.parquet")).unwrap();
    place.run("plot plane").refused(65, &["has no surface yet", "stickslip resume plane"]);
    fs::write(place.path("plane/surface.parquet"), "no Parquet").unwrap();
    place.run("plot plane").refused(74, &["plane/surface.parquet is damaged", "stickslip verify plane"]);
}

#[test]
fn few_values_along_an_axis_are_tiles() {
    let place = Place::new();
    let axes = "rotating_speed = 15.0\npreload = [0.05, 0.1, 0.25]\nstatic_friction = [0.3, 0.4]";
    submitted(&place, "few", &job("few", axes, 200));
    place.run("plot few").done();
    let svg = fs::read_to_string(place.path("few/surface.svg")).unwrap();
    assert!(svg.contains("samples (12.67 %, in one cell up to 24.50 %) lie outside the model"));
    // No line of a level between cells, and each colour of a tile ends half way between two values.
    assert!(!svg.contains("stroke=\"#1a1a1a\" stroke-width=\"1\""), "a line between the cells");
    let paths = svg.split("<path d=\"").skip(1).map(|path| path.split('>').next().unwrap());
    let mut ends: Vec<i64> = paths
        .filter(|path| path.contains("fill=\"#") && !path.contains("fill=\"none\""))
        .flat_map(|path| extent(path.split('"').next().unwrap()))
        .map(|end| (100.0 * end).round() as i64)
        .filter(|end| *end < 57_000)
        .collect();
    ends.sort_unstable();
    ends.dedup();
    assert_eq!(ends.len(), 3, "the left, the middle and the right of the panel: {ends:?}");
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn a_plot_shows_chosen_values_a_target_and_a_title() {
    let place = Place::new();
    let axes = PLANE.replace("rotating_speed = 15.0", "rotating_speed = [12.0, 15.0, 18.0]");
    submitted(&place, "three", &job("three", &axes, 300));
    submitted(&place, "one", &job("one", PLANE, 300));
    let drawn = |options: &str| {
        place.run(&format!("plot {options} --out figure.svg")).done();
        fs::read_to_string(place.path("figure.svg")).unwrap()
    };
    let few = "rotating_speed = 15.0\npreload = [0.1, 0.2]\nstatic_friction = [0.3, 0.4]";
    submitted(&place, "few", &job("few", few, 300));
    // One speed of three has one panel, whose heading names it.
    let held = drawn("three --at rotating_speed=15");
    assert_eq!(held.matches(">Preload Δ<").count(), 1);
    assert!(held.contains(">15 rad/s; relative std: preload 0.2, friction 0.2<"));
    // Holding an axis of the area leaves curves along the other.
    let curves = drawn("three --at preload=0.1");
    assert!(curves.contains("Probability of instability P") && curves.contains("preload = 0.1"));
    // The target is a line of its own with its name, from the option or from the job.
    assert!(!drawn("one").contains("P = 0.03"));
    assert!(drawn("one --target 0.03").contains(">P = 0.03<"));
    submitted(&place, "aimed", &format!("{}[target]\nprobability = 0.07\n", job("aimed", PLANE, 300)));
    assert!(drawn("aimed").contains(">P = 0.07<") && drawn("aimed --target 0.03").contains(">P = 0.03<"));
    // Over one axis too, where the axis of probabilities reaches it.
    assert!(!curves.contains(">P = "));
    let aimed = drawn("three --at preload=0.1 --target 0.03");
    assert!(aimed.contains(">P = 0.03<"), "{aimed}");
    let titled = drawn("one --title Mine");
    assert!(titled.contains(">Mine<") && !titled.contains("15 rad/s"));
    // The difference of two runs, too.
    let difference = drawn("three --against three --at rotating_speed=15 --title Mine");
    assert_eq!(difference.matches(">Preload Δ<").count(), 1);
    assert!(difference.contains(">Mine<"));
    for (options, why) in [
        ("few --at preload=0.1 --at static_friction=0.4", "--at leaves a single cell of few: its probability of"),
        ("three --at rotating_speed=14", "has no value 14 in the run; the nearest is 15"),
        (
            "three --at rotating_speed=15 --at rotating_speed=12",
            "--at rotating_speed=12: rotating_speed is given twice, as 15 and as 12; give one value of each axis",
        ),
        ("three --at speed=15", "speed is no axis of the run, whose axes are rotating_speed, preload, static_friction"),
        ("three --at rotating_speed", "rotating_speed=15"),
        ("one --target 1.5", "greater than 0 and less than 1"),
        ("one --of sobol --title x", "--title is for the probability of a run"),
    ] {
        place.run(&format!("plot {options}")).refused(64, &[why]);
    }
}

/// A job whose inputs are correlated and leave the model, and which records results.
const SEEN: &str = r#"
name = "seen"
[axes]
preload = 0.1
static_friction = { from = 0.3, to = 0.45, points = 4 }
rotating_speed = 15.0
[random]
inputs = ["preload", "static_friction", "pad.mass"]
relative_std = { preload = 0.3, static_friction = 0.15, "pad.mass" = 0.05 }
distribution = { static_friction = "lognormal", "pad.mass" = "uniform" }
correlation = [["preload", "static_friction", 0.6]]
[criterion]
kind = "eigenvalue"
record = ["critical_speed"]
[sampling]
samples = 20_000
seed = 1
"#;

#[test]
fn the_inputs_and_samples_of_a_job_are_seen_before_it_is_run() {
    let place = Place::new();
    place.write("seen.toml", SEEN);
    let read = |file: &str| fs::read_to_string(place.path(file)).unwrap();
    assert_eq!(place.run("plot seen.toml").done().stdout, "seen-inputs.svg\nseen-inputs.png\n");
    let inputs = read("seen-inputs.svg");
    for text in [
        ">normal, relative std 0.3<",
        ">lognormal, relative std 0.15<",
        ">uniform, relative std 0.05<",
        ">correlation 0.6<",
        "Mass of the pad M (kg)",
        ">outside the model<",
        "of them lie outside the model: preload at or below 0, or f<tspan",
        ">c</tspan><tspan dy=\"-1.98\">.</tspan>",
    ] {
        assert!(inputs.contains(text), "{text}");
    }
    // The points of a scatter are the samples that the run has: as many of each verdict.
    place.run("plot seen.toml --of samples --cell 2 --samples 500 --out before.svg").done();
    place.run("submit seen.toml --out run").done();
    place.run("plot run --of samples --cell 2 --samples 500 --out after.svg").done();
    assert!(read("before.svg") == read("after.svg"));
    place.run("samples run --cell 2 --out samples.parquet").done();
    let outside = crate::common::Table::read(&place.path("samples.parquet")).column("outside_physics")[..500].to_vec();
    let outside = outside.iter().filter(|is_outside| **is_outside == 1.0).count();
    let legend = |svg: &str, name: &str| -> usize {
        let after = svg.split(&format!(">{name} (")).nth(1).unwrap_or("0)");
        after.split(')').next().unwrap().parse().unwrap()
    };
    let svg = read("before.svg");
    let counts = ["stable", "unstable", "outside the model"];
    let counts = counts.map(|name| legend(&svg, name));
    assert_eq!((counts.iter().sum::<usize>(), counts[2]), (500, outside));
    assert_eq!(svg.matches("<circle").count(), 500);
    // Recorded results are values of samples, too.
    place
        .run("plot seen.toml --of samples --x critical_speed --y static_friction --samples 100 --out speed.svg")
        .done();
    assert!(read("speed.svg").contains("Critical speed (rad/s)"));
    place
        .run("plot seen.toml --of samples --x critical_sped")
        .refused(64, &["--x critical_sped", "did you mean critical_speed?", "preload, static_friction, pad.mass"]);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn an_estimate_converges_to_that_of_the_run() {
    let place = Place::new();
    let jobs = [
        ("random", SEEN.to_owned()),
        ("sobol", SEEN.replace("samples = 20_000", "method = \"sobol\"\nsamples = 20_000")),
        (
            "conditional",
            SEEN.replace("samples = 20_000", "method = \"conditional\"\nsamples = 20_000")
                .replace("record", "# record"),
        ),
        (
            "importance",
            SEEN.replace("samples = 20_000", "method = \"importance\"\nsamples = 20_000").replace("record", "# record"),
        ),
        (
            "subset",
            SEEN.replace("samples = 20_000", "method = \"subset\"\nparticles = 500").replace("record", "# record"),
        ),
        ("until", SEEN.replace("samples = 20_000", "until = { relative = 0.05, at_most = 20_000 }")),
    ];
    for (name, job) in jobs {
        let surface = submitted(&place, name, &job);
        place.run(&format!("plot {name} --of convergence --cell 1 --out {name}.svg")).done();
        let svg = fs::read_to_string(place.path(&format!("{name}.svg"))).unwrap();
        let last = svg.split(">last: P = ").nth(1).unwrap().split(' ').next().unwrap();
        let (last, found): (f64, f64) = (last.parse().unwrap(), surface.column("p_unstable")[1]);
        // A run that stopped early has an estimate that allows for it; here its samples are counted, and no further ones.
        let share = || surface.column("n_unstable")[1] / surface.column("n_samples")[1];
        let found = if name == "until" { share() } else { found };
        assert!((last - found).abs() <= 6e-4 * found, "{name}: {last} {found}");
    }
    let exact = SEEN.replace("samples = 20_000\nseed = 1", "method = \"exact\"").replace(", \"pad.mass\"]", "]");
    let exact = exact
        .replace("record", "# record")
        .replace(", \"pad.mass\" = 0.05", "")
        .replace(", \"pad.mass\" = \"uniform\"", "");
    // Nothing is drawn without a word.
    place.run("plot random --of convergence --samples 0").refused(64, &["--samples 0", "give 1 or more"]);
    place.run("plot random --of convergence --samples 3").refused(64, &["3 samples of cell", "draw 4 or more"]);
    place.run("plot random --of samples --samples 0").refused(64, &["--samples 0"]);
    place.write("exact.toml", &exact);
    place.run("plot exact.toml --of convergence").refused(64, &["draws no samples"]);
}

#[test]
fn recorded_results_are_drawn_over_an_axis_and_in_a_cell() {
    let place = Place::new();
    let surface = submitted(&place, "seen", SEEN);
    let printed = place.run("plot seen --of distribution").done().stdout;
    assert_eq!(printed, "seen/distribution-critical_speed.svg\nseen/distribution-critical_speed.png\n");
    let svg = fs::read_to_string(place.path("seen/distribution-critical_speed.svg")).unwrap();
    assert!(svg.contains("Critical speed (rad/s)") && svg.contains("bands: from the 5 % to the 95 % quantile"));
    place.run("plot seen --of distribution --cell 3 --out cell.svg").done();
    let svg = fs::read_to_string(place.path("cell.svg")).unwrap();
    for (kind, name) in [("p05", "5 %: "), ("p50", "50 %: "), ("p95", "95 %: ")] {
        let shown = svg.split(&format!(">{name}")).nth(1).unwrap().split('<').next().unwrap();
        let shown: f64 = shown.strip_suffix(" rad/s").unwrap().parse().unwrap();
        let quantile = surface.column(&format!("critical_speed_{kind}"))[3];
        assert!((shown / quantile - 1.0).abs() < 5e-4, "{kind}: {shown} {quantile}");
    }
    place.run("report seen").done();
    let report = fs::read_to_string(place.path("seen/report.html")).unwrap();
    assert!(report.contains("id=\"inputs-heading\"") && report.contains("id=\"distributions-heading\""));
    place
        .run("plot seen --of distribution --result growth_rate")
        .refused(64, &["does not record it", "critical_speed"]);
    place.write("seen.toml", SEEN);
    place.run("plot seen.toml --of distribution").refused(64, &["submit the job"]);
    place.run("plot seen.toml --title Inputs").refused(64, &["--title is for the probability of a run"]);
    place.run("plot seen.toml --from 0.1").refused(64, &["need a file that trajectory or replay wrote"]);
    submitted(&place, "plain", &SEEN.replace("record", "# record"));
    place.run("plot plain --of distribution").refused(65, &["records nothing", "criterion.record"]);
    // What no sample has, and what nothing scatters in.
    let undamped = SEEN.replace("[axes]", "[model.damping]\ntangential = 0.0\n[axes]");
    submitted(&place, "undamped", &undamped);
    place.run("plot undamped --of distribution").refused(65, &["no sample of any cell", "critical speed"]);
    // The report of such a run leaves the picture out.
    let said = place.run("report undamped").done().stderr;
    assert!(said.contains("the report leaves a picture out: no sample of any cell"), "{said}");
    place
        .run("plot undamped --of samples --y critical_speed")
        .refused(65, &["none of 2,000 samples", "critical speed"]);
    place.write("still.toml", &SEEN.replace("{ preload = 0.3, static_friction = 0.15, \"pad.mass\" = 0.05 }", "0.0"));
    for of in ["inputs", "samples"] {
        place.run(&format!("plot still.toml --of {of}")).refused(65, &["nothing scatters in cell", "relative_std"]);
    }
    place.run("plot seen.toml --of sobol").refused(64, &["seen.toml is a job", "submit the job"]);
    place.run("plot plain --of sobol --samples 5").refused(64, &["--samples is for"]);
}
