//! Writes a model with fitted figures as a file.

use serde_json::{Map, Value, json};

use super::{Calibration, FittedFigure};
use naoisis_sim::scenario::{ModelError, RobotModel};

/// The text of a model file named `name`: `model` with the fitted figures and their sources.
pub fn model_file(model: &RobotModel, name: &str, log: &str, calibration: &Calibration) -> String {
    let mut realistic = model.realistic.clone();
    let settings = &model.settings;
    let mut sources = model.sources.clone();
    for FittedFigure { path, estimate, basis } in &calibration.figures {
        let digits = rounded(estimate.value, estimate.margin());
        set(&mut realistic, path, json!(digits));
        // What was said of the group is not said of this figure any more.
        let [low, high] = [estimate.low, estimate.high].map(|end| rounded(end, estimate.margin()));
        sources.insert(path.clone(), format!("{log}: {basis}, {low} to {high} with 95 % confidence"));
    }
    let description = format!("{}; calibrated by {log}", model.description);
    let mut text = String::new();
    text.push_str("// Made by naoisis. A scenario with `model: \"./this_file.ron\"` and `realism: \"realistic\"` plays with it.\n");
    let value = json!({ "name": name, "description": description, "settings": settings, "realistic": realistic, "sources": sources });
    text.push_str(&ron_text(&value));
    text.push('\n');
    text
}

impl Calibration {
    /// Moves the figures that `model` cannot have, such as a slip out of the range of slips, to what is lacking.
    pub fn keep_possible(&mut self, model: &RobotModel) {
        let refusal = |calibration: &Calibration| -> Option<ModelError> {
            RobotModel::from_ron("model", &model_file(model, &model.name, "", calibration)).err()
        };
        if refusal(self).is_none() {
            return;
        }
        for figure in core::mem::take(&mut self.figures) {
            self.figures.push(figure);
            let Some(error) = refusal(self) else { continue };
            if let Some(FittedFigure { path, estimate, .. }) = self.figures.pop() {
                let found = rounded(estimate.value, estimate.margin());
                self.lacking
                    .push(format!("{path}: {found} was found, which no model may have; expected {}", error.expected()));
            }
        }
    }
}

/// A model as RON.
pub(crate) fn ron_text(model: &Value) -> String {
    let mut text = String::new();
    write(model, 0, &mut text);
    text
}

/// Rounds `value` to the digits that are significant for its `margin`.
fn rounded(value: f64, margin: f64) -> f64 {
    if !(margin.is_finite() && margin > 0.0) {
        return value;
    }
    let unit = libm::pow(10.0, libm::floor(libm::log10(margin)) - 1.0);
    // Through text, as 3 * 0.1 is not 0.3.
    let digits = (-libm::log10(unit)).max(0.0) as usize;
    format!("{:.digits$}", (value / unit).round() * unit).parse().unwrap_or(value)
}

/// Sets the value at a path of names. Creates missing objects.
fn set(fields: &mut Map<String, Value>, path: &str, value: Value) {
    match path.split_once('.') {
        None => {
            fields.insert(path.to_owned(), value);
        }
        Some((first, rest)) => {
            let inner = fields.entry(first).or_insert_with(|| json!({}));
            if !inner.is_object() {
                *inner = json!({});
            }
            if let Value::Object(inner) = inner {
                set(inner, rest, value);
            }
        }
    }
}

/// Writes a value as RON. Keys are field names, or strings where one of them is no name: the sources', which are paths.
fn write(value: &Value, depth: usize, text: &mut String) {
    let indent = |depth: usize| "    ".repeat(depth);
    match value {
        Value::Object(fields) => {
            let is_map = !fields.keys().all(|name| is_field_name(name));
            let [open, close] = if is_map { ["{", "}"] } else { ["(", ")"] };
            text.push_str(open);
            text.push('\n');
            for (name, value) in fields {
                text.push_str(&indent(depth + 1));
                if is_map {
                    text.push_str(&quoted(name));
                } else {
                    text.push_str(name);
                }
                text.push_str(": ");
                write(value, depth + 1, text);
                text.push_str(",\n");
            }
            text.push_str(&indent(depth));
            text.push_str(close);
        }
        Value::Array(values) => {
            text.push('[');
            for (index, value) in values.iter().enumerate() {
                text.push_str(if index == 0 { "" } else { ", " });
                write(value, depth, text);
            }
            text.push(']');
        }
        Value::Null => text.push_str("None"),
        Value::String(words) => text.push_str(&quoted(words)),
        other => text.push_str(&other.to_string()),
    }
}

/// Whether a key can be written without quotation marks.
fn is_field_name(key: &str) -> bool {
    key.starts_with(|first: char| first.is_ascii_alphabetic() || first == '_')
        && key.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_')
}

/// A text in quotation marks. RON escapes control characters other than JSON does.
fn quoted(text: &str) -> String {
    format!("\"{}\"", text.escape_debug())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_text_and_any_key_is_read_as_it_was() {
        let texts = ["2nd", "a b", "\u{1b}[31m", "\"\\\n\t\0'", "é\u{301}\u{200b}", "", "r#type"];
        let fields: Map<String, Value> =
            texts.iter().map(|text| ((*text).to_owned(), json!([text, 1.5, null]))).collect();
        let value = json!({ "plain": { "inner_2": 1 }, "others": fields });
        assert_eq!(ron::from_str::<Value>(&ron_text(&value)), Ok(value));
    }
}
