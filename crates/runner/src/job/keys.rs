//! Which key a user may have meant.

/// The keys of a job spec that belong to every kind of model, by table.
pub const TABLES: [(&str, &[&str]); 4] = [
    ("random", &["inputs", "relative_std", "std", "distribution", "correlation"]),
    (
        "sampling",
        &[
            "method",
            "samples",
            "until",
            "seed",
            "evaluate",
            "audit",
            "randomisations",
            "particles",
            "common_random_numbers",
            "confidence",
            "interval",
            "simultaneous",
            "derivatives",
            "sensitivity",
        ],
    ),
    ("limit", &["of", "probability"]),
    ("engine", &["partition", "account", "time", "memory", "cpus_per_task", "shards", "max_shards", "sbatch"]),
];

/// The candidate that `wrong` is most likely a misspelling of, if any is near enough.
pub fn nearest<'a>(wrong: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let scored = candidates.into_iter().map(|candidate| (strsim::jaro_winkler(wrong, candidate), candidate));
    scored.filter(|(score, _)| *score >= 0.8).max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, candidate)| candidate)
}

/// What a kind of model knows of a word that a table does not have, as the end of a message.
pub type Suggested = fn(wrong: &str, table: &str) -> Option<String>;

/// The key of a job spec that may have been meant by one that a table does not have, among those that it has, those of
/// other tables, and those of the kind of model, as the end of a message.
pub fn suggestion(wrong: &str, table: &str, candidates: &[&str], suggested: Suggested) -> String {
    if let Some((right, _)) = TABLES.iter().find(|(name, keys)| *name != table && keys.contains(&wrong)) {
        return format!("; `{wrong}` belongs in [{right}]");
    }
    if let Some(right) = nearest(wrong, candidates.iter().copied()) {
        return format!("; did you mean `{right}`?");
    }
    suggested(wrong, table).unwrap_or_default()
}
