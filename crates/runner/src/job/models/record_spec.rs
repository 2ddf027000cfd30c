//! What pads and oscillators record of their samples, as jobs name it.

use serde::Serialize;
use stickslip_core::model::recorded::MOST_RECORDED;
use stickslip_core::models::pad_on_disc::model::{LinearRecord, LinearResult};

/// The names of what a model records.
pub trait RecordedName: Copy + PartialEq + Serialize + 'static {
    /// All of them, first what is of motions.
    const ALL: &'static [Self];

    /// What it is of linear stability; `None` for what is of motions.
    fn linear(self) -> Option<LinearResult>;
}

/// What is recorded of samples that are decided by linear stability.
pub fn linear_record<N: RecordedName>(names: &[N]) -> LinearRecord {
    LinearRecord::of(&names.iter().filter_map(|name| name.linear()).collect::<Vec<_>>())
}

/// The names of what is recorded.
pub fn names_of<N: RecordedName>(record: LinearRecord) -> Vec<N> {
    let is_recorded = |name: &N| record.results().any(|result| Some(result) == name.linear());
    N::ALL.iter().copied().filter(is_recorded).collect()
}

/// Says which of the names is none of those that samples have which are decided by this kind of criterion, and refuses more
/// than a model records.
///
/// # Errors
/// The first such name, and those that there are; or how many are too many.
pub fn check<N: RecordedName>(names: &[N], known: &[N], kind: &impl Serialize) -> Result<(), String> {
    let Some(foreign) = names.iter().find(|name| !known.contains(name)) else {
        let distinct = known.iter().filter(|name| names.contains(name)).count();
        if distinct > MOST_RECORDED {
            return Err(format!(
                "criterion.record has {distinct} results, and a run records {MOST_RECORDED} at most; leave some out, or record them in a second run with the same seed, which has the same samples"
            ));
        }
        return Ok(());
    };
    let are = if known.len() == 1 { "is" } else { "are" };
    let known: Vec<String> = known.iter().map(quoted).collect();
    Err(format!(
        "criterion.record: {} is no result of kind = {}; there {are} {}",
        quoted(foreign),
        quoted(kind),
        known.join(", ")
    ))
}

/// A name as jobs have it.
fn quoted(name: &impl Serialize) -> String {
    // Names are texts, which can be written.
    serde_json::to_string(name).unwrap_or_default()
}
