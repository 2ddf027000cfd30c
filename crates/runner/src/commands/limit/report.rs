//! Limits as text, JSON and columns.

use serde_json::{Value, json};
use stickslip_core::model::quantity::Role;
use stickslip_sampler::estimate::audit::PlainSamples;
use stickslip_sampler::estimate::interval::Estimate;
use stickslip_sampler::limits::{Limit, State};

use crate::evaluate::limits_found::Beside;
use crate::files::table::{TableColumn, TableValues};
use crate::job::{Job, LimitAxis, LimitMethod};
use crate::output::{aligned, counted, wrapped};
use crate::picture::view::{GridView, rounded, scatter};
use crate::tables::cell_columns::{CellColumn, always_shown, axes, shown_of_configurations};
use crate::tables::limits::contradiction;
use crate::tables::row::CONTRADICTED;
use crate::tables::surface::footer;

/// Largest number of rows at the terminal.
const MOST_ROWS: usize = 200;

/// With which confidence plain samples exclude that something was missed.
const CONFIDENCE: f64 = 0.95;

/// A limit of one combination of the other axes, or that there is none.
#[derive(Debug, Clone, Copy)]
pub struct Row {
    /// The cell of the combination with the first value of the axis.
    pub cell: u64,
    /// The probability that must not be exceeded.
    pub target: f64,
    /// What was found.
    pub limit: Limit,
    /// The probability there, if it has a value.
    pub beside: Option<Beside>,
    /// Those at the smallest and the largest value of the axis.
    pub ends: [Beside; 2],
}

impl Row {
    /// What plain samples may be beside: the limit, and both ends.
    fn places(&self) -> [Option<Beside>; 3] {
        [self.beside, Some(self.ends[0]), Some(self.ends[1])]
    }

    /// Whether plain samples contradict a probability at one of these.
    pub fn is_contradicted(&self) -> bool {
        self.places().iter().flatten().any(Beside::is_contradicted)
    }
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
        let fixed = GridView::new(job).fixed();
        let fixed = if fixed.is_empty() { String::new() } else { format!(" at {}", fixed.join(", ")) };
        let stds = match job.grid.scatters {
            1 => format!("; {}", scatter(job, 0)),
            _ => String::new(),
        };
        let title = format!("Limits of {} from {from} to {to}{fixed}{stds}", self.named_axis());
        let others = self.varying_axes();
        let mut lines = vec![Vec::new()];
        lines[0].extend(others.iter().map(|other| other.name.to_string()));
        // Those of a probability in closed form are the limit itself in the digits that are shown.
        let bounds_shown = if self.method == LimitMethod::Integral { 0..0 } else { 0..2 };
        lines[0].extend(["P at most", "limit"].map(str::to_owned));
        lines[0].extend(bounds_shown.clone().map(|end| ["low", "high"][end].to_owned()));
        lines[0].push("state".to_owned());
        lines[0].extend([&from, &to].map(|end| format!("P at {end}")));
        for row in rows.iter().take(MOST_ROWS) {
            let number = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), rounded);
            let bound = |end: usize| number(row.limit.bounds.map(|bounds| bounds[end]));
            let mut line: Vec<String> = others.iter().map(|other| rounded(self.value(other, row.cell))).collect();
            line.extend([rounded(row.target), number(row.limit.value)]);
            line.extend(bounds_shown.clone().map(bound));
            let contradicted = if row.is_contradicted() { ", contradicted" } else { "" };
            line.push(format!("{}{contradicted}", word(row.limit.state)));
            line.extend(row.ends.map(|end| end.estimate.probability.map_or_else(|| "-".to_owned(), probability)));
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
        let name = &self.axis.name;
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
                let is_right = if self.job.samples_beside_limits() > 0 { "" } else { ", which is taken for right" };
                format!("low to high: what the verdict map leaves open{is_right}. {integrated}")
            }
            (_, None) => integrated.to_owned(),
            (_, Some(_)) if self.job.sampling.samples == 0 => {
                format!("low to high: what the integral leaves open. {integrated}")
            }
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
        lines.extend(self.audit());
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
            "unit": self.axis.unit,
            "from": from,
            "to": to,
            "method": self.job.sampling.method.written(),
            "values_scanned": self.scanned,
            "samples": self.confidence.map(|_| self.job.sampling.samples),
            "confidence": self.confidence,
            "limits": (0..self.rows.len()).map(row).collect::<Vec<Value>>(),
        })
    }

    /// One row for each limit.
    pub fn table(&self) -> Vec<TableColumn> {
        let Self { axis, rows, .. } = self;
        let column = |name: String, unit: &str, long_name: String, values| TableColumn {
            name: name.into(),
            unit: unit.to_owned().into(),
            long_name: long_name.into(),
            values,
        };
        let real = |name: &str, unit: &str, long_name: &str, value: &dyn Fn(&Row) -> Option<f64>| {
            column(name.to_owned(), unit, long_name.to_owned(), TableValues::Real(rows.iter().map(value).collect()))
        };
        let cells = TableValues::Integer(rows.iter().map(|row| row.cell).collect());
        let meaning = "0-based index of the cell of the combination with the first value of the axis";
        let mut columns = vec![column("cell".to_owned(), "1", meaning.to_owned(), cells)];
        for other in self.other_axes() {
            columns.push(real(&other.name, &other.unit, &other.long_name, &|row| Some(self.value(&other, row.cell))));
        }
        let unit = &*axis.unit;
        let names = TableValues::Text(vec![axis.name.to_string(); rows.len()]);
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
            real("p_from", "1", "probability of instability at the smallest value of the axis", &|row| {
                row.ends[0].estimate.probability
            }),
            real("p_to", "1", "probability of instability at the largest value of the axis", &|row| {
                row.ends[1].estimate.probability
            }),
        ]);
        if self.job.samples_beside_limits() > 0 {
            let counts = |place: usize, count: fn(&PlainSamples) -> u64| {
                let of =
                    |row: &Row| row.places()[place].and_then(|beside| beside.plain).map_or(0, |plain| count(&plain));
                TableValues::Integer(rows.iter().map(of).collect())
            };
            for (place, (end, at)) in [
                ("", "at the limit; 0 without one"),
                ("_from", "at the smallest value"),
                ("_to", "at the largest value"),
            ]
            .into_iter()
            .enumerate()
            {
                let samples = format!("plain samples {at}");
                columns.push(column(format!("n_audit{end}"), "1", samples, counts(place, |plain| plain.decided)));
                let unstable = format!("unstable ones among the plain samples {at}");
                let name = format!("n_audit_unstable{end}");
                columns.push(column(name, "1", unstable, counts(place, |plain| plain.unstable)));
            }
            let why = |row: &Row| if row.is_contradicted() { CONTRADICTED } else { 0 };
            let reasons = TableValues::Integer(rows.iter().map(why).collect());
            let meaning = "5: plain samples contradict the probability at the limit or at an end of the axis; else 0";
            columns.push(column("distrust".to_owned(), "1", meaning.to_owned(), reasons));
        }
        columns
    }

    /// A line on what plain samples exclude, or contradict.
    fn audit(&self) -> Option<String> {
        let samples = self.job.samples_beside_limits();
        if samples == 0 || self.rows.is_empty() {
            return None;
        }
        let beside =
            format!("{} at each limit and at both ends", counted(samples.into(), "plain sample", "plain samples"));
        let contradicted = self.contradicted();
        if contradicted > 0 {
            return Some(format!("{beside} contradict {contradicted} of {} rows.", self.rows.len()));
        }
        let missed = |place: &Beside| {
            let Estimate { low, high, .. } = place.estimate;
            place.plain.map_or(0.0, |plain| plain.largest_missed([low, high], CONFIDENCE))
        };
        let all = self.rows.iter().flat_map(Row::places).flatten();
        let most = all.map(|place| missed(&place)).fold(0.0, f64::max);
        let by = if self.job.reduction().is_some() { " by the reduced matrices" } else { "" };
        Some(format!("{beside}: no region of more than {most:.1e} was missed there{by}."))
    }

    /// The rows that plain samples contradict.
    pub fn contradicted(&self) -> usize {
        self.rows.iter().filter(|row| row.is_contradicted()).count()
    }

    /// What is said where plain samples contradict limits; nothing where they do not.
    pub fn contradiction(&self) -> Option<String> {
        let contradicted = self.contradicted();
        (contradicted > 0).then(|| contradiction(self.job, &self.axis.name, [contradicted, self.rows.len()]))
    }

    /// What the file says beside its columns.
    pub fn footer(&self) -> Vec<(&'static str, String)> {
        let [from, to] = self.axis.range();
        let mut pairs = footer(self.job);
        let targets: Vec<String> = self.targets.iter().map(f64::to_string).collect();
        pairs.extend([
            ("stickslip:of", self.axis.name.to_string()),
            ("stickslip:from", from.to_string()),
            ("stickslip:to", to.to_string()),
            ("stickslip:targets", targets.join(", ")),
        ]);
        pairs.extend(self.scanned.map(|scanned| ("stickslip:values_scanned", scanned.to_string())));
        pairs.extend(self.confidence.map(|confidence| ("stickslip:confidence", confidence.to_string())));
        pairs
    }

    fn named_axis(&self) -> String {
        match &*self.axis.unit {
            "1" => self.axis.name.to_string(),
            unit => format!("{} ({unit})", self.axis.name),
        }
    }

    /// The other axes and the standard deviations, as the surface names their columns.
    fn other_axes(&self) -> Vec<CellColumn> {
        let job = self.job;
        let further = job.grid.axes.iter().filter(|axis| !job.quantity(axis.quantity).is_always_shown);
        let further = further.map(|axis| CellColumn::expected(axis.quantity, job.quantity(axis.quantity)));
        let inputs = job.random.inputs.iter().filter(|input| job.quantity(**input).role != Role::Input);
        let stds = inputs.map(|&input| CellColumn::std_of_input(job, input));
        let all = further.chain(shown_of_configurations(job)).chain(stds).chain(always_shown(job, true));
        let of = &job.quantity(self.axis.quantity).column;
        all.filter(|other| other.name != *of).collect()
    }

    /// Those in which the combinations differ.
    fn varying_axes(&self) -> Vec<CellColumn> {
        let several: Vec<String> =
            axes(self.job).into_iter().filter(|(_, values)| values.len() > 1).map(|(name, _)| name).collect();
        self.other_axes().into_iter().filter(|other| several.iter().any(|name| *name == other.name)).collect()
    }

    fn value(&self, other: &CellColumn, cell: u64) -> f64 {
        (other.value)(&self.job.grid.cell(cell))
    }
}

/// A probability with four decimals, or where these do not show it its order of magnitude.
fn probability(p: f64) -> String {
    if p == 0.0 || p >= 1e-3 { format!("{p:.4}") } else { format!("{p:.0e}") }
}
