//! Values of options, checked as they are read.

use std::path::PathBuf;

use clap::ValueEnum as _;
use stickslip_core::finite_difference::brake::DiscGrid;
use stickslip_core::motion::start::{GivenStart, Start, StartUnits};

use crate::job::{StartKind, StartValue};

/// A whole number as a job spec writes it, 10000 or 10_000.
pub fn whole_number(text: &str) -> Result<u64, String> {
    text.replace('_', "").parse().map_err(|_| "write a whole number, for example 10000 or 10_000".to_owned())
}

/// A seed in the range that a job spec allows.
pub fn seed(text: &str) -> Result<u64, String> {
    let seed = text.replace('_', "").parse().ok().filter(|&seed: &u64| i64::try_from(seed).is_ok());
    seed.ok_or_else(|| format!("a seed is a whole number from 0 to {} (2^63 - 1)", i64::MAX))
}

/// A probability that may be reached, neither impossible nor certain.
pub fn probability(text: &str) -> Result<f64, String> {
    let probability = text.parse().ok().filter(|&probability: &f64| 0.0 < probability && probability < 1.0);
    probability.ok_or_else(|| "a probability is greater than 0 and less than 1, for example 0.01 for 1 %".to_owned())
}

/// The path of a file that will be written as Parquet.
pub fn parquet_file(text: &str) -> Result<PathBuf, String> {
    file_named(text, "the file is written as Parquet", &["parquet"])
}

/// The path of a file that will be written as HTML.
pub fn html_file(text: &str) -> Result<PathBuf, String> {
    file_named(text, "a report is written as HTML", &["html"])
}

/// The path of a file that a plot can be written to.
pub fn plot_file(text: &str) -> Result<PathBuf, String> {
    file_named(text, "a plot is written as SVG or PNG", &["svg", "png"])
}

/// A path with one of the extensions. A directory is refused later, with a message of its own.
fn file_named(text: &str, what: &str, extensions: &[&str]) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let is_named = |extension: &&str| path.extension().is_some_and(|found| found.eq_ignore_ascii_case(extension));
    if path.is_dir() || extensions.iter().any(is_named) {
        return Ok(path);
    }
    let names = extensions.iter().map(|extension| path.with_extension(extension).display().to_string());
    Err(format!("{what}; name it {}", names.collect::<Vec<_>>().join(" or ")))
}

/// `RxN`: radial intervals and elements under the pad.
pub fn grid(text: &str) -> Result<DiscGrid, String> {
    let wrong =
        || format!("{text:?} is not a grid; write RxN, for example 12x12: radial intervals, elements under the pad");
    let (radial, per_pad) = text.split_once('x').ok_or_else(wrong)?;
    Ok(DiscGrid { radial: radial.parse().map_err(|_| wrong())?, per_pad: per_pad.parse().map_err(|_| wrong())? })
}

/// A start as typed.
#[derive(Debug, Clone)]
pub struct StartArgument {
    /// As typed.
    pub text: String,
    /// The start.
    pub start: Start,
}

/// What `--start` may be.
const STARTS: &str = "it may be near-equilibrium, rest, limit-cycle, or numbers of tangential, velocity, normal and angle, for example velocity=0.3,tangential=1e-4";

/// A start by its name, or in numbers.
pub fn start(text: &str) -> Result<StartArgument, String> {
    let named = StartKind::from_str(text, false).map(Start::from);
    let start = named.or_else(|_| given_start(text).map(Start::Given))?;
    Ok(StartArgument { text: text.to_owned(), start })
}

impl StartArgument {
    /// A start as it would be typed.
    pub fn of(start: Start) -> Self {
        let text = match start {
            Start::NearEquilibrium => "near-equilibrium".to_owned(),
            Start::Rest => "rest".to_owned(),
            Start::LimitCycle => "limit-cycle".to_owned(),
            Start::Given(given) => {
                let number = |number: StartValue| Some(format!("{}={}", number.name(), number.of(&given)?));
                let mut parts: Vec<String> = StartValue::ALL.into_iter().filter_map(number).collect();
                parts.extend((given.units == StartUnits::Scaled).then(|| "units=scaled".to_owned()));
                parts.extend(given.from_equilibrium.then(|| "from_equilibrium".to_owned()));
                parts.join(",")
            }
        };
        Self { text, start }
    }
}

fn given_start(text: &str) -> Result<GivenStart, String> {
    let mut start = GivenStart::default();
    for part in text.split(',').map(str::trim) {
        match part.split_once('=').map(|(name, value)| (name.trim(), value.trim())) {
            None if part == "from_equilibrium" => start.from_equilibrium = true,
            Some(("from_equilibrium", "true")) => start.from_equilibrium = true,
            Some(("from_equilibrium", "false")) => start.from_equilibrium = false,
            Some(("units", "si")) => start.units = StartUnits::Si,
            Some(("units", "scaled")) => start.units = StartUnits::Scaled,
            Some(("units", other)) => return Err(format!("units={other}: units are si or scaled")),
            Some((name, value)) => {
                let known = StartValue::ALL.into_iter().find(|number| number.name() == name);
                let number = known.ok_or_else(|| format!("there is no {name:?}; {STARTS}"))?;
                let parsed = value.parse().map_err(|_| format!("{name}={value}: {value:?} is not a number"))?;
                if number.of(&start).is_some() {
                    return Err(format!("{name} is given twice"));
                }
                number.set(&mut start, parsed);
            }
            None => return Err(STARTS.to_owned()),
        }
    }
    Ok(start)
}
