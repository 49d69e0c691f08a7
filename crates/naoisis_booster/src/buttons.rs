//! The buttons of a robot and of its remote controller, as the robot's sensor [`buttons`](naoisis_sensing::sensing::buttons) feels them.
//!
//! The buttons `button_0` and `button_1` are on the robot's back; `a`, `b`, `x`, `y`, `lb`, `rb`, `lt`, `rt`, `ls`, `rs`, `back` and `start`
//! are those of the remote controller, whose sticks are at rest.

use crate::messages::{ButtonEventMsg, RemoteControllerState};
use naoisis_sensing::sensing::buttons::{ButtonReading, ButtonReadings};

/// The beginning of the names of the buttons on the robot; the number follows.
const ON_ROBOT: &str = "button_";
/// A button of the remote controller was pressed, in the codes of SDL.
const BUTTON_DOWN: u32 = 0x603;
/// A button of the remote controller was released.
const BUTTON_UP: u32 = 0x604;

/// The changes between two readings: the name of the button, and whether it was pressed. A short press between them is both.
fn changes<'a>(before: &ButtonReadings, now: &'a ButtonReadings) -> Vec<(&'a str, bool)> {
    let mut changes = Vec::new();
    for (name, reading) in &now.0 {
        let was: ButtonReading = before.0.get(name).copied().unwrap_or_default();
        let is_new = reading.presses > was.presses;
        if was.is_pressed && (is_new || !reading.is_pressed) {
            changes.push((name.as_str(), false));
        }
        if is_new {
            changes.push((name.as_str(), true));
            if !reading.is_pressed {
                changes.push((name.as_str(), false));
            }
        }
    }
    changes
}

/// The events of the buttons on the robot.
pub fn button_events(before: &ButtonReadings, now: &ButtonReadings) -> Vec<ButtonEventMsg> {
    let event = |(name, is_pressed): (&str, bool)| {
        let button = name.strip_prefix(ON_ROBOT)?.parse().ok()?;
        Some(ButtonEventMsg { button, event: i32::from(!is_pressed) })
    };
    changes(before, now).into_iter().filter_map(event).collect()
}

/// The state of the remote controller.
pub fn remote_controller(before: &ButtonReadings, now: &ButtonReadings) -> RemoteControllerState {
    let mut state = RemoteControllerState { hat_c: true, ..Default::default() };
    let mut of_remote = |name: &str, is_pressed: bool| {
        let button = match name {
            "a" => &mut state.a,
            "b" => &mut state.b,
            "x" => &mut state.x,
            "y" => &mut state.y,
            "lb" => &mut state.lb,
            "rb" => &mut state.rb,
            "lt" => &mut state.lt,
            "rt" => &mut state.rt,
            "ls" => &mut state.ls,
            "rs" => &mut state.rs,
            "back" => &mut state.back,
            "start" => &mut state.start,
            _ => return false,
        };
        *button = is_pressed;
        true
    };
    for (name, reading) in &now.0 {
        of_remote(name, reading.is_pressed);
    }
    let mut is_of_remote = |name: &str| of_remote(name, now.0.get(name).is_some_and(|reading| reading.is_pressed));
    let last = changes(before, now).into_iter().rfind(|(name, _)| is_of_remote(name));
    state.event = last.map_or(0, |(_, is_pressed)| if is_pressed { BUTTON_DOWN } else { BUTTON_UP });
    state
}

#[cfg(test)]
mod tests {
    use super::*;

    fn readings(all: &[(&str, u32, bool)]) -> ButtonReadings {
        let reading =
            |&(name, presses, is_pressed): &(&str, u32, bool)| (name.to_owned(), ButtonReading { presses, is_pressed });
        ButtonReadings(all.iter().map(reading).collect())
    }

    #[test]
    fn a_press_is_two_events() {
        let none = ButtonReadings::default();
        let (down, up) = (readings(&[("button_1", 1, true)]), readings(&[("button_1", 1, false)]));
        assert_eq!(button_events(&none, &down), [ButtonEventMsg { button: 1, event: 0 }]);
        assert_eq!(button_events(&down, &up), [ButtonEventMsg { button: 1, event: 1 }]);
        assert_eq!(button_events(&none, &up).len(), 2);
        assert!(
            button_events(&up, &up).is_empty() && button_events(&none, &readings(&[("chest", 1, true)])).is_empty()
        );
    }

    #[test]
    fn the_remote_controller_has_its_buttons_and_its_last_event() {
        let none = ButtonReadings::default();
        let rest = RemoteControllerState { hat_c: true, ..Default::default() };
        assert_eq!(remote_controller(&none, &readings(&[("chest", 1, true)])), rest);
        let pressed = readings(&[("start", 1, true)]);
        let told = RemoteControllerState { start: true, event: BUTTON_DOWN, ..rest.clone() };
        assert_eq!(remote_controller(&none, &pressed), told);
        let told = RemoteControllerState { event: BUTTON_UP, ..rest };
        assert_eq!(remote_controller(&pressed, &readings(&[("start", 1, false)])), told);
    }
}
