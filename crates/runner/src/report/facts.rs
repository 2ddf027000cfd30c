//! What a reader needs to know of a run to take its probabilities for what they are.

use toml::{Table, Value};

use super::run::{ReportedRun, length_scale_mm};
use crate::job::Job;
use crate::output::counted;
use crate::picture::view::{GridView, ViewAxis, rounded, scatter_of_entry};

/// Terms with what is to be said of each; nothing where a term has no meaning.
pub fn facts(run: &ReportedRun) -> Vec<(&'static str, String)> {
    let job = &run.values.job;
    let table: Table = toml::from_str(&job.normalised()).unwrap_or_default();
    let of_table = |name: &str, left_out: &[&str]| {
        let keys = table.get(name).and_then(|part| part.as_table()).into_iter().flatten();
        keys.filter(|(key, value)| !left_out.contains(&key.as_str()) && **value != Value::Boolean(false))
            .map(|(key, value)| format!("{key} = {value}"))
            .collect::<Vec<_>>()
            .join(", ")
    };
    let view = GridView::new(job);
    let axes = view.axes().iter().filter(|axis| axis.quantity.is_some());
    // Remarks are comments of a job: "# expected contact force on a rigid disc: 3.510 kN".
    let remarks = job.model.remarks(&job.grid).replace("\n# ", "; ");
    let scatters = (0..job.random.relative_stds.len()).map(|entry| scatter_of_entry(job, entry));
    let is_certain = run.values.is_certain();
    let if_it_scatters = |text: String| if is_certain { String::new() } else { text };
    vec![
        ("Expected values", axes.map(|axis| values(job, axis)).collect::<Vec<_>>().join("; ")),
        ("", remarks.trim_start_matches("# ").trim_end().to_owned()),
        ("Scatter", if is_certain { "none".to_owned() } else { scatters.collect::<Vec<_>>().join("; or ") }),
        ("Distributions", if_it_scatters(of_table("random", &["inputs", "relative_std", "std"]))),
        ("Criterion", of_table("criterion", &[])),
        ("Method", of_table("sampling", &[])),
        ("Range of P", if_it_scatters(job.sampling.method.interval(&job.sampling))),
        ("Computed", run.finished.clone().unwrap_or_default()),
    ]
}

/// The values of an axis: its only one, or how many there are from which to which.
fn values(job: &Job, axis: &ViewAxis) -> String {
    let range = |scale: f64, unit: &str| {
        let [first, last] = axis.ends().map(|end| rounded(scale * end));
        let ends = if axis.values.len() == 1 { first } else { format!("{first} to {last}") };
        format!("{ends} {unit}").trim_end().to_owned()
    };
    let is_over_length = axis.quantity.is_some_and(|place| job.quantity(place).is_over_length);
    let displacement = match length_scale_mm(job).filter(|_| is_over_length) {
        Some(length) => format!(" (displacement {})", range(length, "mm")),
        None => String::new(),
    };
    let count = match axis.values.len() {
        1 => String::new(),
        count => format!(", {}", counted(count as u128, "value", "values")),
    };
    format!("{} {}{displacement}{count}", axis.key(), range(1.0, axis.unit()))
}
