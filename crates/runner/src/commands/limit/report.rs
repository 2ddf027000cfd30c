//! Limits as text, JSON and columns.

use serde_json::{Value, json};
use stickslip_core::parameters::scalar;
use stickslip_sampler::grid::Cell;
use stickslip_sampler::limits::{Limit, State};

use crate::files::table::{TableColumn, TableValues};
use crate::job::{Job, LimitAxis, LimitMethod, RandomInput};
use crate::output::{aligned, counted, wrapped};
use crate::picture::view::{rounded, scatter};
use crate::tables::columns::axes;
use crate::tables::surface::footer;

/// Largest number of rows at the terminal.
const MOST_ROWS: usize = 200;

/// A limit of one combination of the other axes, or that there is none.
#[derive(Debug, Clone, Copy)]
pub struct Row {
    /// The cell of the combination with the first value of the axis.
    pub cell: u64,
    /// The probability that must not be exceeded.
    pub target: f64,
    /// What was found.
    pub limit: Limit,
    /// The probabilities at the smallest and the largest value of the axis.
    pub ends: [Option<f64>; 2],
}

/// Everything that was found, and how.
pub struct Found<'a> {
    pub job: &'a Job,
    pub axis: &'a LimitAxis,
    /// The probabilities that must not be exceeded.
    pub targets: &'a [f64],
    pub method: LimitMethod,
    /// At how many values of the axis the probability was first estimated.
    pub scanned: Option<usize>,
    /// The confidence of the bounds, if they are those of samples.
    pub confidence: Option<f64>,
    pub rows: Vec<Row>,
}

fn word(state: State) -> &'static str {
    match state {
        State::Rises => "rises",
        State::Falls => "falls",
        State::Within => "within",
        State::Above => "above",
    }
}

impl Found<'_> {
    /// A table for the terminal.
    pub fn text(&self) -> String {
        let Self { job, axis, rows, .. } = self;
        let [from, to] = axis.range().map(rounded);
        let grid = &job.grid;
        let speed = match grid.rotating_speed.values() {
            [speed] => format!(" at {speed} rad/s"),
            _ => String::new(),
        };
        let stds = match grid.relative_std.len() {
            1 => format!("; {}", scatter(job, 0)),
            _ => String::new(),
        };
        let title = format!("Limits of {} from {from} to {to}{speed}{stds}", self.named_axis());
        let others = self.varying_axes();
        let mut lines = vec![Vec::new()];
        lines[0].extend(others.iter().map(|other| other.name.clone()));
        // Those of a probability in closed form are the limit itself in the digits that are shown.
        let bounds_shown = if self.method == LimitMethod::Integral { 0..0 } else { 0..2 };
        lines[0].extend(["P at most", "limit"].map(str::to_owned));
        lines[0].extend(bounds_shown.clone().map(|end| ["low", "high"][end].to_owned()));
        lines[0].push("state".to_owned());
        lines[0].extend([&from, &to].map(|end| format!("P at {end}")));
        for row in rows.iter().take(MOST_ROWS) {
            let number = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), rounded);
            let bound = |end: usize| number(row.limit.bounds.map(|bounds| bounds[end]));
            let mut line: Vec<String> = others.iter().map(|other| rounded(other.value(row.cell))).collect();
            line.extend([rounded(row.target), number(row.limit.value)]);
            line.extend(bounds_shown.clone().map(bound));
            line.push(word(row.limit.state).to_owned());
            line.extend(row.ends.map(|p| p.map_or_else(|| "-".to_owned(), probability)));
            lines.push(line);
        }
        let mut text = wrapped(&title) + "\n" + &aligned(&lines);
        if rows.len() > MOST_ROWS {
            text += &format!("... and {} more rows; --out FILE.parquet writes them all\n", rows.len() - MOST_ROWS);
        }
        text + "\n" + &wrapped(&self.legend())
    }

    /// What the columns of the table mean.
    fn legend(&self) -> String {
        let has = |state: State| self.rows.iter().any(|row| row.limit.state == state);
        let name = self.axis.name;
        let states = [
            (State::Rises, format!("rises: the limit is the largest {name}, beyond it P is more than the target")),
            (State::Falls, format!("falls: the limit is the smallest {name}, below it P is more than the target")),
            (State::Within, "within: P does not pass the target, it is at most that on the whole range".to_owned()),
            (State::Above, "above: P does not pass the target, it is more than that on the whole range".to_owned()),
        ];
        let mut lines: Vec<String> =
            states.into_iter().filter(|(state, _)| has(*state)).map(|(_, line)| line).collect();
        let integrated = "P is integrated, without samples.";
        let mut method = match (self.method, self.confidence) {
            (LimitMethod::MapIntegral, _) => {
                format!("low to high: what the verdict map leaves open, which is taken for right. {integrated}")
            }
            (_, None) => integrated.to_owned(),
            (_, Some(confidence)) => format!(
                "low to high: {} % interval of the limit, from {} of each combination. At an end of the range it may reach further.",
                rounded(100.0 * confidence),
                counted(self.job.sampling.samples.into(), "sample", "samples")
            ),
        };
        if let Some(scanned) = self.scanned {
            method += &format!(" Limits are sought between {scanned} values of {name}.");
        }
        lines.push(method);
        lines.join("\n")
    }

    /// Everything by name; a row has the names of the columns of the table.
    pub fn json(&self) -> Value {
        let columns = self.table();
        let [from, to] = self.axis.range();
        let row = |i: usize| {
            let entries = columns.iter().map(|column| (column.name.to_string(), column.value(i)));
            Value::Object(entries.collect())
        };
        json!({
            "name": self.job.name,
            "job_hash": self.job.hash(),
            "of": self.axis.name,
            "unit": self.axis.scalar.unit,
            "from": from,
            "to": to,
            "method": self.job.sampling.method,
            "values_scanned": self.scanned,
            "samples": self.confidence.map(|_| self.job.sampling.samples),
            "confidence": self.confidence,
            "limits": (0..self.rows.len()).map(row).collect::<Vec<Value>>(),
        })
    }

    /// One row for each limit.
    pub fn table(&self) -> Vec<TableColumn> {
        let Self { axis, rows, .. } = self;
        let column = |name: String, unit: &'static str, long_name: String, values| TableColumn {
            name: name.into(),
            unit,
            long_name: long_name.into(),
            values,
        };
        let real = |name: &str, unit, long_name: &str, value: &dyn Fn(&Row) -> Option<f64>| {
            column(name.to_owned(), unit, long_name.to_owned(), TableValues::Real(rows.iter().map(value).collect()))
        };
        let cells = TableValues::Integer(rows.iter().map(|row| row.cell).collect());
        let meaning = "0-based index of the cell of the combination with the first value of the axis";
        let mut columns = vec![column("cell".to_owned(), "1", meaning.to_owned(), cells)];
        for other in self.other_axes() {
            columns.push(real(&other.name, other.unit, &other.long_name, &|row| Some(other.value(row.cell))));
        }
        let unit = axis.scalar.unit;
        let names = TableValues::Text(vec![axis.name.to_owned(); rows.len()]);
        let states = TableValues::Word(rows.iter().map(|row| Some(word(row.limit.state))).collect());
        let state = "what the probability does as the axis grows: rises or falls through the target at the limit; without a limit within the target or above it";
        columns.extend([
            column("of".to_owned(), "1", "the axis whose limits these are".to_owned(), names),
            real("target", "1", "probability of instability that must not be exceeded", &|row| Some(row.target)),
            column("state".to_owned(), "1", state.to_owned(), states),
            real("limit", unit, "value of the axis at which the probability passes the target", &|row| row.limit.value),
            real("limit_low", unit, "lower end of the interval of the limit", &|row| {
                row.limit.bounds.map(|bounds| bounds[0])
            }),
            real("limit_high", unit, "upper end of the interval of the limit", &|row| {
                row.limit.bounds.map(|bounds| bounds[1])
            }),
            real("p_from", "1", "probability of instability at the smallest value of the axis", &|row| row.ends[0]),
            real("p_to", "1", "probability of instability at the largest value of the axis", &|row| row.ends[1]),
        ]);
        columns
    }

    /// What the file says beside its columns.
    pub fn footer(&self) -> Vec<(&'static str, String)> {
        let [from, to] = self.axis.range();
        let mut pairs = footer(self.job);
        let targets: Vec<String> = self.targets.iter().map(f64::to_string).collect();
        pairs.extend([
            ("stickslip:of", self.axis.name.to_owned()),
            ("stickslip:from", from.to_string()),
            ("stickslip:to", to.to_string()),
            ("stickslip:targets", targets.join(", ")),
        ]);
        pairs.extend(self.scanned.map(|scanned| ("stickslip:values_scanned", scanned.to_string())));
        pairs.extend(self.confidence.map(|confidence| ("stickslip:confidence", confidence.to_string())));
        pairs
    }

    fn named_axis(&self) -> String {
        match self.axis.scalar.unit {
            "1" => self.axis.name.to_owned(),
            unit => format!("{} ({unit})", self.axis.name),
        }
    }

    /// The other axes and the standard deviations, as the surface names their columns.
    fn other_axes(&self) -> Vec<OtherAxis<'_>> {
        let job = self.job;
        let further = job.grid.of_brake.iter().filter_map(|further| {
            let scalar = scalar(&further.name)?;
            let long_name = format!("expected value of {}: {}", scalar.key, scalar.description);
            let value = move |cell| job.value_in(scalar.key, &job.grid.cell(cell)).unwrap_or(f64::NAN);
            Some(OtherAxis { name: scalar.key.to_owned(), unit: scalar.unit, long_name, value: Box::new(value) })
        });
        let usual = |name: &str, unit, long_name: &str, value: fn(&Cell) -> f64| OtherAxis {
            name: name.to_owned(),
            unit,
            long_name: long_name.to_owned(),
            value: Box::new(move |cell| value(&job.grid.cell(cell))),
        };
        let mut others: Vec<OtherAxis<'_>> = further.collect();
        others.extend([
            usual("rotating_speed_rad_s", "rad/s", "rotating speed of the disc", |cell| cell.rotating_speed),
            usual("std_preload", "1", "standard deviation of the preload over its expected value", |cell| {
                cell.relative_std.preload
            }),
            usual(
                "std_static_friction",
                "1",
                "standard deviation of the static friction coefficient over its expected value",
                |cell| cell.relative_std.static_friction,
            ),
        ]);
        for (i, input) in job.random.inputs.iter().enumerate() {
            let RandomInput::Other(_) = input else { continue };
            let value = move |cell| job.random.relative_stds[job.grid.relative_std_index(cell)][i];
            let long_name = match input.scatters_absolutely() {
                true => format!("standard deviation of {}", input.name()),
                false => format!("standard deviation of {} over its expected value", input.name()),
            };
            let name = format!("std_{}", input.name());
            others.push(OtherAxis { name, unit: "1", long_name, value: Box::new(value) });
        }
        others.extend([
            usual("preload", "1", "expected preload, calliper displacement over disc thickness", |cell| cell.preload),
            usual("static_friction", "1", "expected static friction coefficient", |cell| cell.static_friction),
        ]);
        let of = self.column_of_axis();
        others.retain(|other| other.name != of);
        others
    }

    /// Those that tell the combinations apart.
    fn varying_axes(&self) -> Vec<OtherAxis<'_>> {
        let several: Vec<String> =
            axes(self.job).into_iter().filter(|(_, values)| values.len() > 1).map(|(name, _)| name).collect();
        self.other_axes().into_iter().filter(|other| several.contains(&other.name)).collect()
    }

    /// The column of the surface with the values of the axis.
    fn column_of_axis(&self) -> &'static str {
        if self.axis.name == "rotating_speed" { "rotating_speed_rad_s" } else { self.axis.name }
    }
}

/// Another axis than that of the limits, or a standard deviation.
struct OtherAxis<'a> {
    name: String,
    unit: &'static str,
    long_name: String,
    value: Box<dyn Fn(u64) -> f64 + 'a>,
}

impl OtherAxis<'_> {
    /// Its value in a cell.
    fn value(&self, cell: u64) -> f64 {
        (self.value)(cell)
    }
}

/// A probability with four decimals, or where these do not show it its order of magnitude.
fn probability(p: f64) -> String {
    if p == 0.0 || p >= 1e-3 { format!("{p:.4}") } else { format!("{p:.0e}") }
}
