//! Which key a user may have meant.

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::Value;

/// The JSON schema of a type, with those of its parts in their places.
pub fn schema_of<T: JsonSchema>() -> Value {
    let settings = SchemaSettings::default().with(|settings| settings.inline_subschemas = true);
    settings.into_generator().into_root_schema_for::<T>().to_value()
}

/// Whether a table declares a key.
pub fn has_key<T: JsonSchema>(key: &str) -> bool {
    schema_of::<T>()["properties"].get(key).is_some()
}

/// The table of a spec that declares a key.
pub fn table_with<T: JsonSchema>(key: &str) -> Option<String> {
    let schema = schema_of::<T>();
    let mut tables = schema["properties"].as_object()?.iter();
    tables.find(|(_, table)| table["properties"].get(key).is_some()).map(|(name, _)| name.clone())
}

/// The candidate that `wrong` is most likely a misspelling of, if any is near enough.
pub fn nearest<'a>(wrong: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let scored = candidates.into_iter().map(|candidate| (strsim::jaro_winkler(wrong, candidate), candidate));
    scored.filter(|(score, _)| *score >= 0.8).max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, candidate)| candidate)
}

/// What a kind of model knows of a word that a table does not have, as the end of a message.
pub type Suggested = fn(wrong: &str, table: &str) -> Option<String>;

/// The key of a spec that may have been meant by one that a table does not have, among those that it has, those of
/// other tables, and those of the kind of model, as the end of a message.
pub fn suggestion<T: JsonSchema>(wrong: &str, table: &str, candidates: &[&str], suggested: Suggested) -> String {
    if let Some(right) = table_with::<T>(wrong) {
        return format!("; `{wrong}` belongs in [{right}]");
    }
    if let Some(right) = nearest(wrong, candidates.iter().copied()) {
        return format!("; did you mean `{right}`?");
    }
    suggested(wrong, table).unwrap_or_default()
}
