//! Imprecise values in the JSON schema of job specs.

use serde_json::{Value, json};

/// A number, or an imprecise one in its place.
pub fn number_or_imprecise(number: &Value) -> Value {
    let between = json!({ "type": "array", "items": number, "minItems": 2, "maxItems": 2 });
    let between = json!({ "type": "object", "properties": { "between": between }, "required": ["between"],
        "additionalProperties": false, "description": "All values between two ends, for `stickslip bounds`" });
    json!({ "anyOf": [number, between, one_of(number)] })
}

/// Alternatives in place of a value.
pub fn one_of(value: &Value) -> Value {
    let list = json!({ "type": "array", "items": value, "minItems": 2, "uniqueItems": true });
    json!({ "type": "object", "properties": { "one_of": list }, "required": ["one_of"],
        "additionalProperties": false, "description": "One of these, for `stickslip bounds`" })
}
