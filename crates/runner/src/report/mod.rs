//! The report of a run: one HTML file that needs nothing else, neither a network nor other files.
//!
//! Its pictures are drawn in the browser by plotly.js, whose cartesian bundle is part of the program, compressed.

use std::io::Read as _;
use std::path::Path;

use flate2::read::GzDecoder;
use serde_json::{Value, json};
use stickslip_sampler::draw::identity::RESULTS_VERSION;
use stickslip_sampler::estimate::interval::Estimate;

use crate::failure::Failure;
use crate::output::quoted;
use crate::picture::answer::answer;
use crate::picture::view::GridView;
use crate::plot::axes::axis;
use crate::plot::levels::Levels;
use crate::plot::values::Values;

const PAGE: &str = include_str!("page.html");
/// The style of pages, light and dark.
pub const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = include_str!("script.js");

/// The cartesian bundle of plotly.js, see `plotly-license.txt` beside it.
const LIBRARY: &[u8] = include_bytes!("plotly-cartesian.min.js.gz");
const LIBRARY_VERSION: &str = "4.1.1";

/// Significant digits of numbers in the page.
const DIGITS: usize = 6;

/// The page of a run.
///
/// # Errors
/// A library that was damaged when the program was built.
pub fn page(values: &Values, run: &Path) -> Result<String, Failure> {
    let job = &values.job;
    let mut library = String::new();
    GzDecoder::new(LIBRARY)
        .read_to_string(&mut library)
        .map_err(|error| Failure::InputOutput(format!("the program's copy of plotly.js cannot be read: {error}")))?;
    let estimates: Vec<Estimate> = (0..values.probability.len())
        .map(|cell| Estimate { probability: values.probability[cell], low: values.low[cell], high: values.high[cell] })
        .collect();
    let name = escaped(&job.name);
    let parts = [
        ("title", format!("{name}: probability of instability")),
        ("style", STYLE.to_owned()),
        ("name", name),
        ("description", escaped(&job.description)),
        ("answer", escaped(&answer(job, &estimates))),
        ("interval", interval_name(values)),
        ("facts", facts(values, run)),
        ("job", escaped(&job.normalised())),
        ("reconstructed", reconstructed().to_owned()),
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ("plotly", LIBRARY_VERSION.to_owned()),
        ("data", data(values).to_string().replace("</", "<\\/")),
        ("script", SCRIPT.to_owned()),
        // Last, so that nothing in it is taken for a place of another part.
        ("library", library),
    ];
    let mut page = PAGE.to_owned();
    for (place, text) in parts {
        page = page.replacen(&format!("{{{{{place}}}}}"), &text, if place == "name" { 2 } else { 1 });
    }
    Ok(page)
}

/// What the script draws.
fn data(values: &Values) -> Value {
    let view = GridView::new(&values.job);
    let axes: Vec<Value> = view
        .axes()
        .iter()
        .map(|of| {
            let named = axis(of);
            json!({
                "title": named.title,
                "unit": named.unit,
                "values": of.values,
                "logarithmic": named.scale.is_logarithmic(),
            })
        })
        .collect();
    let (vertical, horizontal) = view.shown();
    let levels = Levels::up_to(values.largest());
    let colour = |band| {
        let (red, green, blue) = levels.colour(band);
        format!("#{red:02x}{green:02x}{blue:02x}")
    };
    let rounded = |value: &f64| round(*value);
    json!({
        "axes": axes,
        "vertical": vertical,
        "horizontal": horizontal,
        "p": values.probability.iter().map(|p| p.map(round)).collect::<Vec<_>>(),
        "low": values.low.iter().map(rounded).collect::<Vec<_>>(),
        "high": values.high.iter().map(rounded).collect::<Vec<_>>(),
        "samples": values.samples,
        "unstable": values.unstable,
        "levels": levels.all(),
        "lines": levels.lines(),
        "colours": (0..levels.bands()).map(colour).collect::<Vec<_>>(),
        "interval_name": interval_name(values),
    })
}

/// A number with as many digits as anyone reads.
fn round(value: f64) -> f64 {
    format!("{value:.*e}", DIGITS - 1).parse().unwrap_or(value)
}

fn interval_name(values: &Values) -> String {
    let sampling = &values.job.sampling;
    if values.job.is_integrated() {
        return "bounds of the integral".to_owned();
    }
    let together = if sampling.simultaneous { " for all cells together" } else { "" };
    format!("{} % interval{together}", round(100.0 * sampling.confidence))
}

/// Seed, versions and the command that computes the same numbers, as entries of a list.
fn facts(values: &Values, run: &Path) -> String {
    let job = &values.job;
    let samples = if job.is_integrated() {
        "none, the probability is integrated".to_owned()
    } else {
        format!("{} in all", values.samples.iter().map(|&samples| u128::from(samples)).sum::<u128>())
    };
    let entries = [
        ("Cells", job.cells().to_string()),
        ("Samples", samples),
        ("Seed", job.sampling.seed.to_string()),
        ("Program", format!("stickslip {}, results version {RESULTS_VERSION}", env!("CARGO_PKG_VERSION"))),
        ("Job", job.hash()),
        ("The same numbers", format!("stickslip submit {}", quoted(&run.join("job.toml")))),
    ];
    let entry = |(name, value): (&str, String)| format!("<dt>{name}</dt><dd>{}</dd>", escaped(&value));
    entries.into_iter().map(entry).collect()
}

/// What of the preset is not printed in the paper.
pub fn reconstructed() -> &'static str {
    "<p class=\"note\">The preset sui-ding-2018 is reconstructed from the printed results of Sui and Ding (2018, \
     doi 10.1007/s11071-018-4280-4) where the paper does not print a parameter.</p>"
}

/// Text for HTML.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
