//! Single settings laid over a scenario, as on the command line: `messages.loss=0.2`, `rules.half_s=60`.

use core::fmt;
use core::str::FromStr;
use serde_json::{Map, Value};

use super::error::{ScenarioError, ScenarioErrorKind};
use super::field_path::{FieldPath, Segment};
use super::merge::field_of_word;
use super::wording::quoted;

/// A field of a scenario, with a value that replaces the file's.
///
/// A setting is written `PATH=VALUE`. The value is JSON; other texts are strings, as in `teams.blue=roles`. If the file has the name of a
/// preset, the other fields of the preset stay: `rules.half_s=60` with the rules `spl2010`.
#[derive(Clone, PartialEq, Debug)]
pub struct Setting {
    path: FieldPath,
    value: Value,
}

/// The error for a word that is no setting.
#[derive(Clone, PartialEq, Eq, thiserror::Error)]
#[error("{} is no setting: expected a field of the scenario and its value, such as `messages.loss=0.2` or `robots[0].number=7`", quoted(.0))]
pub struct NotASetting(pub String);

naoisis_core::debug_as_displayed!(NotASetting);

impl Setting {
    /// Returns the path of the field.
    pub fn path(&self) -> &FieldPath {
        &self.path
    }

    /// Returns the value as written: texts without quotes.
    pub fn value(&self) -> String {
        match &self.value {
            Value::String(text) => text.clone(),
            value => value.to_string(),
        }
    }

    /// Returns one setting for each value in `PATH=VALUE,VALUE,...`: the values of a sweep. Commas inside brackets, braces and quotes do
    /// not separate values.
    ///
    /// # Errors
    /// [`NotASetting`] if there is no path or no value.
    pub fn sweep(text: &str) -> Result<Vec<Setting>, NotASetting> {
        let error = || NotASetting(text.to_owned());
        let (path, values) = text.split_once('=').ok_or_else(error)?;
        split_values(values).into_iter().map(|value| Setting::new(path, value).ok_or_else(error)).collect()
    }

    fn new(path: &str, value: &str) -> Option<Setting> {
        let (path, value) = (FieldPath::parse(path.trim())?, value.trim());
        if value.is_empty() {
            return None;
        }
        let value = serde_json::from_str(value).unwrap_or_else(|_| Value::String(value.to_owned()));
        Some(Setting { path, value })
    }

    /// Sets the value, and adds missing objects on the path. Elements of lists must exist.
    pub(super) fn lay_over(&self, root: &mut Value) -> Result<(), ScenarioError> {
        let error = |message: String, expected: &str| Err(self.error(ScenarioErrorKind::Shape, &message, expected));
        let mut value = root;
        for (position, segment) in self.path.segments().iter().enumerate() {
            let here = self.path.first(position);
            value = match segment {
                Segment::Field(name) => {
                    if let Value::String(word) = value {
                        let word = Value::String(core::mem::take(word));
                        *value = Value::Object(Map::from_iter([(field_of_word(&here).to_owned(), word)]));
                    } else if value.is_null() {
                        *value = Value::Object(Map::new());
                    }
                    match value {
                        Value::Object(fields) => fields.entry(name.clone()).or_insert(Value::Null),
                        Value::Array(_) => {
                            return error(
                                format!("`{here}` is a list"),
                                &format!("an element's number, such as `{here}[0]`"),
                            );
                        }
                        _ => return error(format!("`{here}` has no fields"), "a field that a scenario has"),
                    }
                }
                Segment::Index(index) => match value {
                    Value::Array(elements) => match elements.len() {
                        0 => {
                            return error(
                                format!("the list `{here}` is empty"),
                                &format!("the whole list, `{here}=[...]`"),
                            );
                        }
                        length if *index >= length => {
                            let expected = format!("`{here}[0]` to `{here}[{}]`", length - 1);
                            return error(format!("there is no element {index}"), &expected);
                        }
                        _ => &mut elements[*index],
                    },
                    Value::Null => {
                        return error(
                            format!("the file has no list `{here}`"),
                            &format!("the whole list, `{here}=[...]`"),
                        );
                    }
                    _ => return error(format!("`{here}` is no list"), "a field that a scenario has"),
                },
            };
        }
        *value = self.value.clone();
        Ok(())
    }

    /// Returns whether the setting changes the value at `path`, a value in it, or a value around it.
    pub(super) fn concerns(&self, path: &FieldPath) -> bool {
        !path.segments().is_empty() && path.segments().iter().zip(self.path.segments()).all(|(one, other)| one == other)
    }

    /// Returns an error about this setting.
    pub(super) fn error(&self, kind: ScenarioErrorKind, message: &str, expected: &str) -> ScenarioError {
        ScenarioError::of_file(kind, &format!("--set {self}"), message.to_owned(), expected.to_owned())
    }
}

impl FromStr for Setting {
    type Err = NotASetting;

    fn from_str(text: &str) -> Result<Self, NotASetting> {
        let error = || NotASetting(text.to_owned());
        let (path, value) = text.split_once('=').ok_or_else(error)?;
        Setting::new(path, value).ok_or_else(error)
    }
}

impl fmt::Display for Setting {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}={}", self.path, self.value())
    }
}

/// Splits a text at the commas outside brackets, braces and quotes.
fn split_values(text: &str) -> Vec<&str> {
    let (mut depth, mut in_text, mut start) = (0, false, 0);
    let mut values = Vec::new();
    for (position, character) in text.char_indices() {
        match character {
            '"' => in_text = !in_text,
            '[' | '{' if !in_text => depth += 1,
            ']' | '}' if !in_text => depth -= 1,
            ',' if !in_text && depth == 0 => {
                values.push(&text[start..position]);
                start = position + 1;
            }
            _ => {}
        }
    }
    values.push(&text[start..]);
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::{Format, Realism, ScenarioFile};
    use naoisis_core::team::Team;

    fn set(text: &str, settings: &[&str]) -> Result<ScenarioFile, ScenarioError> {
        let settings: Vec<Setting> = settings.iter().map(|setting| setting.parse().unwrap()).collect();
        ScenarioFile::from_text(text, Format::Json, "file").unwrap().with(&settings)
    }

    #[test]
    fn a_setting_replaces_what_the_file_says_or_leaves_to_its_default() {
        let text = r#"{ "messages": { "loss": 0.5, "delay_cycles": 3 }, "robots": [{}, { "pose": [1, 0, 0] }] }"#;
        let settings = ["messages.loss=0.1", "kicks.recovery_s=2", "robots.1.pose=[2, 1, 90]", "name=a word"];
        let scenario = set(text, &settings).unwrap().scenario;
        assert_eq!((scenario.messages.loss, scenario.messages.delay_cycles), (0.1, 3));
        assert_eq!(scenario.settings.kicks.recovery_s, 2.0);
        assert_eq!(scenario.robots[1].pose.position.to_array(), [2.0, 1.0]);
        assert_eq!(scenario.name, "a word");
    }

    #[test]
    fn a_presets_other_fields_stay() {
        let rules = set(r#"{ "rules": "spl2010" }"#, &["rules.half_s=30"]).unwrap().scenario.rules;
        let preset = crate::scenario::rules_preset("spl2010").unwrap();
        assert_eq!(rules, naoisis_core::game::Rules { half_s: 30.0, ..preset });
    }

    #[test]
    fn what_a_word_stands_for_stays() {
        let text = r#"{ "teams": { "blue": "passers", "pink": { "team": "roles" } }, "realism": "realistic" }"#;
        let settings = ["teams.blue.model=booster_k1", "teams.blue.model.body.height_m=0.9", "realism.kicks=paper"];
        let scenario = set(text, &settings).unwrap().scenario;
        let teams = scenario.teams.unwrap();
        assert_eq!((teams.blue.as_str(), teams.pink.as_str()), ("passers", "roles"));
        assert_eq!(teams.robots[Team::Blue].model.as_deref(), Some("booster_k1"));
        assert_eq!(teams.robots[Team::Blue].own.body.as_ref().map(|body| body.height_m), Some(0.9));
        let realism = scenario.realism;
        assert_eq!((realism.motion, realism.kicks), (Realism::Realistic, Realism::Paper));
        let error = set(text, &["teams.blue.model=nope"]).unwrap_err().to_string();
        assert!(error.contains("there is no model `nope`") && !error.contains("preset"), "{error}");
    }

    #[test]
    fn a_sweep_has_a_setting_for_each_value() {
        let values = |text: &str| Setting::sweep(text).unwrap().iter().map(ToString::to_string).collect::<Vec<_>>();
        assert_eq!(values("messages.loss=0,0.2, 0.5"), ["messages.loss=0", "messages.loss=0.2", "messages.loss=0.5"]);
        assert_eq!(values("robots[0].pose=[1,2,3],[4,5,6]"), ["robots[0].pose=[1,2,3]", "robots[0].pose=[4,5,6]"]);
        let no_paths =
            ["messages..loss=1", ".seed=1", "seed.=1", "robots[=1", "robots[]=1", "robots[0=1", "robots[0]number=1"];
        for wrong in ["messages.loss", "=3", "messages.loss=", "messages.loss=1,,2"].into_iter().chain(no_paths) {
            assert_eq!(Setting::sweep(wrong), Err(NotASetting(wrong.to_owned())));
        }
    }

    #[test]
    fn an_error_names_the_setting() {
        for (setting, words) in [
            ("messages.loss=7", "`loss` is 7"),
            ("messages.los=0.1", "there is no field `los`"),
            ("messages=many", "the text `many`"),
            ("robots[5].number=1", "there is no element 5; expected `robots[0]` to `robots[0]`"),
            ("robots.pose=[1,2,3]", "`robots` is a list; expected an element's number, such as `robots[0]`"),
            ("posts[0].radius_m=1", "the file has no list `posts`; expected the whole list, `posts=[...]`"),
            ("seed[0]=1", "`seed` is no list"),
            ("seed.high=1", "`seed` has no fields"),
        ] {
            let error = set(r#"{ "seed": 3, "robots": [{}] }"#, &[setting]).unwrap_err().to_string();
            assert!(error.starts_with(&format!("--set {setting}: ")) && error.contains(words), "{error}");
        }
    }
}
