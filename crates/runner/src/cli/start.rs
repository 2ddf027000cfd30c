//! The start of a motion of the pad as an option.

use clap::ValueEnum as _;
use stickslip_core::models::pad_on_disc::motion::start::{GivenStart, Start, StartUnits};
use stickslip_core::models::pad_on_disc::motion::start_value::StartValue;

use crate::job::StartKind;
use crate::units::not_a_number;

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

impl From<Start> for StartArgument {
    /// A start as it would be typed.
    fn from(start: Start) -> Self {
        let text = match start {
            Start::NearEquilibrium => "near-equilibrium".to_owned(),
            Start::Rest => "rest".to_owned(),
            Start::LimitCycle => "limit-cycle".to_owned(),
            Start::Given(given) => {
                let number = |number: StartValue| Some(format!("{}={}", number.name(), number.value_in(&given)?));
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
                let parsed = value.parse().map_err(|_| format!("{name}={value}: {}", not_a_number(value)))?;
                if number.value_in(&start).is_some() {
                    return Err(format!("{name} is given twice"));
                }
                number.set(&mut start, parsed);
            }
            None => return Err(STARTS.to_owned()),
        }
    }
    Ok(start)
}
