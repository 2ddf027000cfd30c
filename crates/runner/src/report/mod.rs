//! The report of runs: one HTML file that needs nothing else, neither a network nor other files.
//!
//! Its pictures are drawn in the browser by plotly.js, whose cartesian bundle is part of the program, compressed.

mod expected;

mod run;

mod facts;

mod comparison;

use std::io::Read as _;
use std::path::Path;

use flate2::read::GzDecoder;
use serde_json::{Value, json};
use stickslip_core::model::Model;
use stickslip_sampler::draw::identity::RESULTS_VERSION;
use stickslip_sampler::estimate::interval::Estimate;

pub use self::comparison::{ComparedCell, Comparison};
use self::facts::facts;
pub use self::run::{PICTURE_WIDTH, Picture, PictureKind, ReportedRun};
use crate::failure::Failure;
use crate::job::Job;
use crate::job::reduction::Reduction;
use crate::output::quoted;
use crate::picture::answer::answer;
use crate::plot::canvas::parts;
use crate::plot::svg::{self, escaped};
use crate::version::VERSION;

const PAGE: &str = include_str!("page.html");
/// The style of pages, light and dark.
pub const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = include_str!("script.js");

/// The cartesian bundle of plotly.js, see `plotly-license.txt` beside it.
const LIBRARY: &[u8] = include_bytes!("plotly-cartesian.min.js.gz");
const LIBRARY_VERSION: &str = "4.1.1";

/// The page of one or more runs, and of what the others differ from the first in.
///
/// # Errors
/// A library that was damaged when the program was built.
pub fn page(runs: &[ReportedRun], comparisons: &[Comparison]) -> Result<String, Failure> {
    let mut library = String::new();
    GzDecoder::new(LIBRARY)
        .read_to_string(&mut library)
        .map_err(|error| Failure::InputOutput(format!("the program's copy of plotly.js cannot be read: {error}")))?;
    let names: Vec<&str> = runs.iter().map(|run| run.values.job.name.as_str()).collect();
    let name = escaped(&names.join(", "));
    let all = |part: fn(&ReportedRun, bool) -> String| runs.iter().map(|run| part(run, runs.len() > 1)).collect();
    let data = json!({
        "runs": runs.iter().map(ReportedRun::data).collect::<Vec<_>>(),
        "comparisons": comparisons.iter().map(Comparison::data).collect::<Vec<_>>(),
    });
    let differences = comparisons.iter().map(|comparison| {
        element("p", "class=\"answer\"", &comparison.summary(&runs[0].path, &runs[comparison.run].path))
    });
    let has_pad = runs.iter().any(|run| run.values.job.model.as_pad().is_some());
    let parts = [
        ("results", runs.iter().filter_map(|run| run.results.as_deref()).collect::<Vec<_>>().join(" ")),
        ("title", format!("{name}: probability of instability")),
        ("style", STYLE.to_owned()),
        ("name", name),
        ("answers", all(answered)),
        ("differences", differences.collect()),
        ("map", map_title(runs).to_owned()),
        ("rested", all(rested)),
        ("computed", all(computed)),
        ("reconstructed", if has_pad { reconstructed() } else { String::new() }),
        ("pictures", PictureKind::ALL.iter().map(|kind| pictures(runs, *kind)).collect()),
        ("version", VERSION.to_owned()),
        ("plotly", LIBRARY_VERSION.to_owned()),
        ("data", in_script(&data)),
        ("script", SCRIPT.to_owned()),
        ("library", library),
    ];
    Ok(filled(PAGE, &parts))
}

/// What the map shows.
fn map_title(runs: &[ReportedRun]) -> &'static str {
    let is_certain = runs.iter().all(|run| run.values.is_certain());
    if is_certain { "Verdict of each cell" } else { "Probability of instability" }
}

/// A page with its places, such as `{{name}}`, filled by their parts.
pub fn filled(page: &str, parts: &[(&str, String)]) -> String {
    let mut pieces = page.split("{{");
    let mut text = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        let (place, after) = piece.split_once("}}").unwrap_or((piece, ""));
        let part = parts.iter().find(|(name, _)| *name == place);
        text += part.map_or("", |(_, part)| part);
        text += after;
    }
    text
}

/// Data as text inside a script element, which any `<` might end.
fn in_script(data: &Value) -> String {
    data.to_string().replace('<', "\\u003c")
}

/// The answer of a run, with its name if there are several, its description, and what `check` warns of.
fn answered(run: &ReportedRun, has_name: bool) -> String {
    let values = &run.values;
    let job = &values.job;
    let estimates: Vec<Estimate> = (0..job.cells()).map(|cell| values.known(cell).estimate).collect();
    let asked = job.asked_cell().map(|cell| values.known(cell));
    let answer = answer(job, &estimates, asked.as_ref());
    let (first, rest) = answer.split_once('\n').unwrap_or((answer.as_str(), ""));
    heading(run, has_name)
        + &element("p", "class=\"verdict\"", first)
        + &element("p", "class=\"answer\"", rest.trim_end())
        + &element("p", "class=\"note\"", &job.description)
        + &values
            .exceptions()
            .sentences(job)
            .into_iter()
            .chain(run.values.limits.as_ref().and_then(|limits| limits.contradiction(job)))
            .map(|text| element("p", "class=\"warning\"", &format!("{text}.")))
            .collect::<String>()
        + &job.reduction().map_or_else(String::new, |reduction| element("p", "class=\"note\"", &reduced(reduction)))
        + &job.warnings().iter().map(|warning| warned(warning)).collect::<String>()
}

/// What the probabilities of a run rest on.
fn rested(run: &ReportedRun, has_name: bool) -> String {
    heading(run, has_name) + &listed(&facts(run))
}

/// A list of terms, without those of which nothing is to be said.
fn listed(entries: &[(&str, String)]) -> String {
    let entry = |(name, value): &(&str, String)| {
        if value.is_empty() { String::new() } else { format!("<dt>{}</dt>{}", escaped(name), element("dd", "", value)) }
    };
    format!("<dl>{}</dl>", entries.iter().map(entry).collect::<String>())
}

/// What a reduction costs as a sentence.
fn reduced(reduction: &Reduction) -> String {
    let sentence = reduction.sentence();
    format!("T{}.", sentence.strip_prefix('t').unwrap_or(&sentence))
}

/// A warning as a sentence.
fn warned(warning: &str) -> String {
    let end = if warning.ends_with(['.', '?']) { "" } else { "." };
    element("p", "class=\"warning\"", &format!("Warning: {warning}{end}"))
}

/// The section of the pictures of a kind; nothing if no run has one.
fn pictures(runs: &[ReportedRun], kind: PictureKind) -> String {
    let (id, title) = kind.heading();
    let mut note = String::new();
    let mut shown = String::new();
    for run in runs {
        let job = &run.values.job;
        for Picture { canvas, .. } in run.pictures.iter().filter(|picture| picture.kind == kind) {
            let element = svg::element(canvas, &kind.alternative(job.model()));
            shown += &format!("{}<div class=\"picture\">{element}</div>", heading(run, runs.len() > 1));
            note = kind.note(job);
        }
    }
    if shown.is_empty() {
        return shown;
    }
    format!(
        "<section aria-labelledby=\"{id}-heading\" id=\"{id}\"><h2 id=\"{id}-heading\">{title}</h2>{shown}{}</section>",
        element("p", "class=\"note\"", &note)
    )
}

impl PictureKind {
    /// All of them, in their order on the page.
    const ALL: [Self; 6] =
        [Self::Inputs, Self::Friction, Self::Distributions, Self::Verdicts, Self::Modes, Self::SquealFrequencies];

    /// What its section is called, in links and above it.
    fn heading(self) -> (&'static str, &'static str) {
        match self {
            Self::Inputs => ("inputs", "Random inputs"),
            Self::Friction => ("friction", "Measured friction"),
            Self::Distributions => ("distributions", "Recorded results"),
            Self::Verdicts => ("verdicts", "Verdict map"),
            Self::Modes => ("modes", "Modes"),
            Self::SquealFrequencies => ("squeal-frequencies", "Frequencies of squeal"),
        }
    }

    /// For readers who do not see it.
    fn alternative(self, model: &dyn Model) -> String {
        match self {
            Self::Inputs => "Densities of the random inputs".to_owned(),
            Self::Friction => "Measured friction over the sliding speed, with the curve of the model".to_owned(),
            Self::Distributions => "Distribution of a recorded result".to_owned(),
            Self::Verdicts => format!("Map of the verdicts over {}", nouns_of_pair(model)),
            Self::Modes => "Frequencies and damping ratios of modes over a parameter".to_owned(),
            Self::SquealFrequencies => "Histogram of the frequencies of unstable samples".to_owned(),
        }
    }

    fn note(self, job: &Job) -> String {
        let place = job.place_of_shown_cell();
        match self {
            Self::Inputs => format!("As drawn in the cell at {place}."),
            Self::Friction => {
                let has_disc = job.model().quantities().iter().any(|quantity| quantity.name == "rotating_speed");
                let on_disc = if has_disc { " on a rigid disc" } else { "" };
                format!(
                    "Steady sliding is unstable{on_disc} where the curve falls too steeply, here with the values of the cell at {place}."
                )
            }
            Self::Distributions => {
                "Of the samples that have the result: from the 5 % to the 95 % quantile lie 90 % of them.".to_owned()
            }
            Self::Verdicts => {
                format!("Every sample whose {} lie in a region has its verdict.", nouns_of_pair(job.model()))
            }
            Self::Modes => {
                "Where the lines of two frequencies meet and their damping ratios part, friction couples the modes."
                    .to_owned()
            }
            Self::SquealFrequencies => {
                "The bars add up to the probability of instability of these samples, the first of the cell.".to_owned()
            }
        }
    }
}

/// What the pair of a model is.
fn nouns_of_pair(model: &dyn Model) -> String {
    let nouns = model.pair().into_iter().flatten().map(|place| model.quantities()[place].noun());
    nouns.collect::<Vec<_>>().join(" and ")
}

/// How a run was computed: seed, versions, the command that computes the same numbers, and the job.
fn computed(run: &ReportedRun, has_name: bool) -> String {
    let values = &run.values;
    let job = &values.job;
    let samples = match job.draws_samples() {
        true => format!("{} in all", values.samples.iter().map(|&samples| u128::from(samples)).sum::<u128>()),
        false => "none, the probability is integrated".to_owned(),
    };
    let again = Path::new(&run.path).join("job.toml");
    let entries = [
        ("Cells", job.cells().to_string()),
        ("Samples", samples),
        ("Seed", job.sampling.seed.to_string()),
        ("Program", format!("stickslip {VERSION}, results version {RESULTS_VERSION}")),
        ("Job", job.hash()),
        ("Computed by", run.programs.join("; ")),
        ("The same numbers", format!("stickslip submit {}", quoted(&again))),
    ];
    format!(
        "{}{}<details class=\"printed\"><summary>The job with every default filled in</summary>{}</details>",
        heading(run, has_name),
        listed(&entries),
        element("pre", "", &job.with_all_keys())
    )
}

fn heading(run: &ReportedRun, has_name: bool) -> String {
    if has_name { element("h3", "", &format!("{} ({})", run.values.job.name, run.path)) } else { String::new() }
}

/// What of the preset is not printed in the paper.
pub fn reconstructed() -> String {
    let text = "Parameters start from the preset sui-ding-2018. Those that Sui and Ding (2018, doi \
                10.1007/s11071-018-4280-4) do not print are reconstructed from the results that they print.";
    element("p", "class=\"note\"", text)
}

/// An element with text; without text nothing. Symbols in paragraphs have their subscripts.
fn element(name: &str, attributes: &str, text: &str) -> String {
    if text.is_empty() {
        return String::new();
    }
    let set = |(part, is_subscript): (String, bool)| match is_subscript {
        true => format!("<sub>{}</sub>", escaped(&part)),
        false => escaped(&part),
    };
    let content = if name == "p" { parts(text).into_iter().map(set).collect() } else { escaped(text) };
    format!("<{name} {attributes}>{content}</{name}>")
}
