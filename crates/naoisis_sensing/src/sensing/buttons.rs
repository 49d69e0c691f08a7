//! Buttons on a robot's body, such as the chest button, which people press at given times.
//!
//! Robots have them where `sensors` of a scenario or of one of its robots name them. Each press has a time, a button and a duration:
//!
//! `"sensors": { "buttons": { "presses": [{ "at_s": 5.0, "button": "chest" }] } }`
//!
//! **What it measures.** For each button that has been pressed, the number of presses so far and whether it is pressed. A press is felt
//! in the cycle in which it begins or later, and without errors. What it means is up to the robot's program.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

use naoisis_core::cycle::CycleClock;
use naoisis_core::knowledge::Knowledge;

/// The presses of a robot's buttons.
#[derive(Component, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Public)]
#[serde(default, deny_unknown_fields)]
pub struct Buttons {
    /// The presses, in any order.
    pub presses: Vec<Press>,
}

/// A press of a button.
#[derive(Clone, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[serde(try_from = "PressFields")]
pub struct Press {
    /// Its time, s since the start of the match.
    pub at_s: f64,
    /// The name of the button, such as `chest`.
    pub button: String,
    /// Its duration, s.
    pub for_s: f64,
}

/// The fields of a press in files.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PressFields {
    at_s: f64,
    button: String,
    #[serde(default = "short_s")]
    for_s: f64,
}

/// The duration of a short press, s.
fn short_s() -> f64 {
    0.2
}

impl TryFrom<PressFields> for Press {
    type Error = String;

    fn try_from(PressFields { at_s, button, for_s }: PressFields) -> Result<Self, String> {
        let is_word = |letter: u8| letter.is_ascii_lowercase() || letter.is_ascii_digit() || letter == b'_';
        if button.is_empty() || button.len() > 32 || !button.bytes().all(is_word) {
            return Err(format!(
                "a button `{button:.40}`; expected a word of lower-case letters, digits and underscores"
            ));
        }
        if !(0.0..=1e6).contains(&at_s) || !(0.0..=600.0).contains(&for_s) {
            return Err(format!(
                "a press at {at_s} s for {for_s} s; expected `at_s` from 0 to 1,000,000 and `for_s` from 0 to 600"
            ));
        }
        Ok(Self { at_s, button, for_s })
    }
}

/// The state of a robot's buttons, by their names.
#[derive(Component, Clone, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Sensor)]
#[serde(transparent)]
pub struct ButtonReadings(pub BTreeMap<String, ButtonReading>);

/// The state of a button.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize)]
pub struct ButtonReading {
    /// The number of presses so far.
    pub presses: u32,
    /// Whether it is pressed.
    #[serde(rename = "pressed")]
    pub is_pressed: bool,
}

/// Updates the readings of all robots with buttons.
pub fn feel(clock: Res<CycleClock>, mut robots: Query<(&Buttons, &mut ButtonReadings)>) {
    for (buttons, mut readings) in &mut robots {
        let readings_now = readings_at(clock.start_time_s(), buttons);
        readings.set_if_neq(readings_now);
    }
}

/// The readings at a time, s.
fn readings_at(time_s: f64, buttons: &Buttons) -> ButtonReadings {
    let mut readings = ButtonReadings::default();
    for press in buttons.presses.iter().filter(|press| press.at_s <= time_s) {
        let reading = readings.0.entry(press.button.clone()).or_default();
        reading.presses += 1;
        reading.is_pressed |= time_s < press.at_s + press.for_s;
    }
    readings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presses_are_counted_from_their_time_on() {
        let text = r#"{ "presses": [{ "at_s": 2.0, "button": "chest" }, { "at_s": 1.0, "button": "chest", "for_s": 0.5 },
            { "at_s": 9.0, "button": "head" }] }"#;
        let buttons: Buttons = serde_json::from_str(text).unwrap();
        let chest = |time_s: f64| {
            let readings = readings_at(time_s, &buttons).0;
            assert!(!readings.contains_key("head"));
            readings.get("chest").map(|chest| (chest.presses, chest.is_pressed))
        };
        assert_eq!(
            [0.99, 1.0, 1.6, 2.1, 2.3].map(chest),
            [None, Some((1, true)), Some((1, false)), Some((2, true)), Some((2, false))]
        );
    }

    #[test]
    fn presses_that_cannot_be_are_refused() {
        for (press, expected) in [
            (r#"{ "at_s": -1, "button": "chest" }"#, "`at_s` from 0"),
            (r#"{ "at_s": 1, "button": "Chest" }"#, "lower-case"),
            (r#"{ "at_s": 1, "button": "chest", "for_s": 1e9 }"#, "`for_s` from 0 to 600"),
            (r#"{ "at_s": 1 }"#, "button"),
        ] {
            let error = serde_json::from_str::<Press>(press).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
    }
}
