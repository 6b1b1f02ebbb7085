//! Serialised values without their places in the text.

use serde::Serialize;
use serde_json::Value;

/// A value as JSON without places in the text: the same wherever it stands.
///
/// # Errors
///
/// The value cannot be written as JSON.
pub fn without_spans(value: &impl Serialize) -> serde_json::Result<Value> {
    let mut value = serde_json::to_value(value)?;
    strip(&mut value);
    Ok(value)
}

fn strip(value: &mut Value) {
    match value {
        Value::Object(fields) => {
            fields.remove("span");
            fields.values_mut().for_each(strip);
        }
        Value::Array(items) => items.iter_mut().for_each(strip),
        _ => {}
    }
}
