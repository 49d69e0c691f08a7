//! Pressed keys with the modifiers that were held at that moment. On a slow display, a modifier may be released in the same frame as
//! its key was pressed.

use bevy::input::keyboard::KeyboardInput;
use bevy::prelude::*;

/// A pressed key.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct KeyPress {
    /// The key.
    pub key: KeyCode,
    /// Whether Shift was held down.
    pub shift: bool,
    /// Whether Ctrl or the command key was held down.
    pub control: bool,
}

const SHIFT: [KeyCode; 2] = [KeyCode::ShiftLeft, KeyCode::ShiftRight];
const CONTROL: [KeyCode; 4] = [KeyCode::ControlLeft, KeyCode::ControlRight, KeyCode::SuperLeft, KeyCode::SuperRight];

/// The modifiers that are held down.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct HeldModifiers(Vec<KeyCode>);

impl HeldModifiers {
    /// Notes an input. Returns the key if it was pressed, without repetitions of a key that is held down.
    pub fn note(&mut self, input: &KeyboardInput) -> Option<KeyPress> {
        let key = input.key_code;
        if SHIFT.contains(&key) || CONTROL.contains(&key) {
            self.0.retain(|held| *held != key);
            if input.state.is_pressed() {
                self.0.push(key);
            }
        }
        let holds = |keys: &[KeyCode]| self.0.iter().any(|held| keys.contains(held));
        let is_new = input.state.is_pressed() && !input.repeat;
        is_new.then(|| KeyPress { key, shift: holds(&SHIFT), control: holds(&CONTROL) })
    }

    /// Notes that the window no longer has the keyboard.
    pub fn release(&mut self) {
        self.0.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::input::ButtonState;
    use bevy::input::keyboard::Key;

    fn pressed(inputs: &[(KeyCode, bool)]) -> Vec<KeyPress> {
        let mut held = HeldModifiers::default();
        let input = |(key_code, is_down): &(KeyCode, bool)| KeyboardInput {
            key_code: *key_code,
            logical_key: Key::Shift,
            state: if *is_down { ButtonState::Pressed } else { ButtonState::Released },
            text: None,
            repeat: false,
            window: Entity::PLACEHOLDER,
        };
        inputs.iter().filter_map(|given| held.note(&input(given))).filter(|press| !SHIFT.contains(&press.key)).collect()
    }

    #[test]
    fn a_modifier_that_is_released_in_the_same_frame_counts() {
        use KeyCode::{ControlLeft, KeyV, KeyZ, ShiftLeft, ShiftRight};
        let press = |key, shift| KeyPress { key, shift, control: false };
        let frame = [(ShiftLeft, true), (KeyV, true), (KeyV, false), (ShiftLeft, false), (KeyZ, true)];
        assert_eq!(pressed(&frame), [press(KeyV, true), press(KeyZ, false)]);
        let undo = pressed(&[(ControlLeft, true), (KeyZ, true), (ControlLeft, false)]);
        assert!(undo.last().is_some_and(|press| press.key == KeyZ && press.control && !press.shift));
        // One of two keys of the same modifier is still held down.
        let both = [(ShiftLeft, true), (ShiftRight, true), (ShiftLeft, false), (KeyV, true)];
        assert_eq!(pressed(&both), [press(KeyV, true)]);
    }
}
