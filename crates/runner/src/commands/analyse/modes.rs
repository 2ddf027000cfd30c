//! The modes of a model given by matrices at one point, and what each parameter does to them.

use serde_json::{Map, Value, json};
use stickslip_core::model::critical_values::{INTERVALS, NoMemory, evenly};
use stickslip_core::model::quantity::Limits;
use stickslip_core::models::matrices::modes::Mode;
use stickslip_core::models::matrices::region::Region;
use stickslip_core::models::matrices::terms::Parameter;
use stickslip_sampler::grid::Cell;

use crate::commands::analyse::nearest_change::Nearest;
use crate::commands::modes::{JobModes, failed};
use crate::commands::one_brake::changed_values;
use crate::failure::Failure;
use crate::job::Job;
use crate::output::{aligned, note};
use crate::picture::view::rounded;

/// Modes whose sensitivities the terminal shows: those with the least damping.
const MOST_SHOWN: usize = 10;

/// Of a parameter without a range, critical values are looked for between these multiples of its value.
const FACTORS: [f64; 2] = [0.1, 10.0];

/// What is computed at one point.
pub struct ModesAtPoint {
    name: String,
    parameters: Vec<Parameter>,
    values: Vec<f64>,
    regions: Vec<Region>,
    modes: Vec<Mode>,
    critical: Vec<Option<CriticalValue>>,
}

/// Where the verdict changes over a parameter.
struct CriticalValue {
    /// Within which values it was looked for.
    within: [f64; 2],
    /// The nearest places below and above the value of the parameter.
    below: Nearest,
    above: Nearest,
}

impl CriticalValue {
    /// Of a parameter, with these values of all quantities; `None` if it is not known.
    fn find(job: &Job, values: &[f64], place: usize, range: Limits) -> Option<Self> {
        let value = values[place];
        let ends = FACTORS.map(|factor| factor * value);
        let ends = [ends[0].min(ends[1]), ends[0].max(ends[1])];
        let end = |given: f64, else_from: f64| if given.is_finite() { given } else { else_from };
        let within = [end(range.minimum, ends[0]), end(range.maximum, ends[1])];
        let configuration = job.model().configure(values, &[place], None).ok()?;
        let unstable = configuration.critical_values()?.unstable(&[value], 0, &evenly(within, INTERVALS), &NoMemory)?;
        let [below, above] = Nearest::on_both_sides(&unstable, value, within);
        Some(Self { within, below, above })
    }
}

impl ModesAtPoint {
    /// Of a cell of a job, with changes.
    pub fn new(job: &Job, cell: &Cell, changes: &[String]) -> Result<Self, Failure> {
        let problem = JobModes::new(job)?;
        let values = changed_values(job, &cell.expected, changes)?;
        let regions = problem.regions(&values);
        let parameters = problem.own().to_vec();
        let modes = problem.model.modes(problem.parameters(&values), &regions);
        let modes = modes.map_err(|error| failed(job, &error))?;
        if problem.is_sparse() {
            note(format_args!(
                "of so large a model the modes are found whose damping ratios are at most 0.05 above the threshold"
            ));
        }
        let critical = parameters.iter().enumerate();
        let critical = critical.map(|(place, own)| CriticalValue::find(job, &values, place, own.range)).collect();
        let values = problem.parameters(&values).to_vec();
        Ok(Self { name: job.name.clone(), parameters, values, regions, modes, critical })
    }

    fn is_unstable(&self, mode: &Mode) -> bool {
        self.regions.iter().any(|region| region.contains(mode.eigenvalue))
    }

    fn is_stable(&self) -> bool {
        !self.modes.iter().any(|mode| self.is_unstable(mode))
    }

    /// Everything by name; what is not known is null.
    pub fn json(&self) -> Value {
        let values: Map<String, Value> =
            self.parameters.iter().zip(&self.values).map(|(own, value)| (own.name.clone(), json!(value))).collect();
        let of_mode = |mode: &Mode| {
            let slope = |place: usize| {
                json!({
                    "damping_ratio": mode.damping_ratio_slope(place),
                    "frequency_hz": mode.frequency_slope(place),
                    "growth_rate_per_s": mode.slopes.as_ref().map(|slopes| slopes[place].re),
                })
            };
            let slopes: Map<String, Value> =
                self.parameters.iter().enumerate().map(|(place, own)| (own.name.clone(), slope(place))).collect();
            json!({
                "frequency_hz": mode.frequency(),
                "damping_ratio": mode.damping_ratio(),
                "growth_rate_per_s": mode.eigenvalue.re,
                "eigenvalue": [mode.eigenvalue.re, mode.eigenvalue.im],
                "unstable": self.is_unstable(mode),
                "derivatives": slopes,
            })
        };
        let band = |region: &Region| {
            let [low, high] = hertz(region);
            // JSON has no infinity.
            json!([low, high.is_finite().then_some(high)])
        };
        json!({
            "parameters": values,
            "stable": self.is_stable(),
            "bands_hz": self.regions.iter().map(band).collect::<Vec<_>>(),
            "threshold_damping_ratio": self.regions.first().map(|region| region.damping_ratio),
            "modes": self.modes.iter().map(of_mode).collect::<Vec<_>>(),
            "critical_values": self.critical_json(),
        })
    }

    fn critical_json(&self) -> Map<String, Value> {
        let of = |critical: &Option<CriticalValue>| match critical {
            Some(CriticalValue { within, below, above }) => {
                json!({ "below": below.json(), "above": above.json(), "within": within })
            }
            None => Value::Null,
        };
        self.parameters.iter().zip(&self.critical).map(|(own, critical)| (own.name.clone(), of(critical))).collect()
    }

    /// In words.
    pub fn text(&self) -> String {
        let values = self.parameters.iter().zip(&self.values).map(|(own, value)| {
            let unit = if own.unit == "1" { String::new() } else { format!(" {}", own.unit) };
            format!("{} {}{unit}", own.name, rounded(*value))
        });
        let verdict = if self.is_stable() { "stable" } else { "UNSTABLE" };
        let values: Vec<String> = values.collect();
        let at = if values.is_empty() { String::new() } else { format!(" at {}", values.join(", ")) };
        format!(
            "{}{at}: {verdict}\n\n{}{}{}",
            self.name,
            self.modes_text(),
            self.sensitivities_text(),
            self.critical_text()
        )
    }

    /// Where the verdict changes over each parameter.
    fn critical_text(&self) -> String {
        if self.parameters.is_empty() {
            return String::new();
        }
        let headings = ["parameter", "value", "nearest below", "nearest above", "looked for"];
        let mut lines = vec![headings.map(str::to_owned).to_vec()];
        for ((own, value), critical) in self.parameters.iter().zip(&self.values).zip(&self.critical) {
            let mut line = vec![own.name.clone(), rounded(*value)];
            line.extend(match critical {
                Some(CriticalValue { within: [from, to], below, above }) => {
                    [below.to_string(), above.to_string(), format!("from {} to {}", rounded(*from), rounded(*to))]
                }
                None => ["not known", "not known", ""].map(str::to_owned),
            });
            lines.push(line);
        }
        format!("\nCritical values: where stable turns to unstable or back, the others fixed\n{}", aligned(&lines))
    }

    fn modes_text(&self) -> String {
        let bands: Vec<String> = self.regions.iter().map(in_words).collect();
        let threshold = self.regions.first().map_or(0.0, |region| region.damping_ratio);
        let said = format!("Modes with {}; unstable is a damping ratio below {threshold}\n", bands.join(", "));
        if self.modes.is_empty() {
            return said + "none\n";
        }
        let mut lines =
            vec![["mode", "frequency, Hz", "damping ratio", "growth rate, 1/s", ""].map(str::to_owned).to_vec()];
        for (number, mode) in (1..).zip(&self.modes) {
            lines.push(vec![
                format!("{number:>4}"),
                format!("{:>13.4}", mode.frequency()),
                format!("{:>13}", rounded(without_rounding(mode.damping_ratio()))),
                format!("{:>16}", rounded(mode.eigenvalue.re)),
                if self.is_unstable(mode) { "unstable".to_owned() } else { String::new() },
            ]);
        }
        said + &aligned(&lines)
    }

    /// What each parameter does to the modes with the least damping.
    fn sensitivities_text(&self) -> String {
        if self.parameters.is_empty() || self.modes.is_empty() {
            return String::new();
        }
        let mut shown: Vec<usize> = (0..self.modes.len()).collect();
        shown.sort_by(|a, b| self.modes[*a].damping_ratio().total_cmp(&self.modes[*b].damping_ratio()));
        shown.truncate(MOST_SHOWN);
        shown.sort_unstable();
        let which = if shown.len() < self.modes.len() {
            format!(", of the {MOST_SHOWN} modes with the least damping (--json has all)")
        } else {
            String::new()
        };
        let headings =
            ["mode", "parameter", "d damping ratio / d parameter", "d frequency / d parameter, Hz", "with 1 % more"];
        let mut lines = vec![headings.map(str::to_owned).to_vec()];
        for place in shown {
            let mode = &self.modes[place];
            for (parameter, own) in self.parameters.iter().enumerate() {
                let slopes = mode.damping_ratio_slope(parameter).zip(mode.frequency_slope(parameter));
                let (by_ratio, by_frequency) = match slopes {
                    Some((by_ratio, by_frequency)) => (rounded(without_rounding(by_ratio)), rounded(by_frequency)),
                    None => ("none".to_owned(), "none".to_owned()),
                };
                let step = 0.01 * self.values[parameter];
                let moved = slopes.map_or_else(String::new, |(by_ratio, by_frequency)| {
                    format!("{:+.3e}, {:+.3e} Hz", without_rounding(by_ratio * step), by_frequency * step)
                });
                lines.push(vec![
                    format!("{:>4}", place + 1),
                    own.name.clone(),
                    format!("{by_ratio:>29}"),
                    format!("{by_frequency:>29}"),
                    moved,
                ]);
            }
        }
        format!("\nSensitivity to each parameter, in closed form{which}\n{}", aligned(&lines))
    }
}

/// The ends of a band in Hz.
fn hertz(region: &Region) -> [f64; 2] {
    [region.lowest, region.highest].map(|end| end / std::f64::consts::TAU)
}

fn in_words(region: &Region) -> String {
    match hertz(region) {
        [0.0, f64::INFINITY] => "any frequency".to_owned(),
        [low, f64::INFINITY] => format!("frequencies from {} Hz up", rounded(low)),
        [low, high] => format!("frequencies from {} to {} Hz", rounded(low), rounded(high)),
    }
}

/// A damping ratio or a change of one; zero where it is the rounding of an undamped mode.
fn without_rounding(value: f64) -> f64 {
    if value.abs() < 1e-12 { 0.0 } else { value }
}
