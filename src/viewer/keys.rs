//! What the keys do. The help lists the same table.

use bevy::prelude::*;
use bevy::render::view::screenshot::{Screenshot, save_to_disk};
use bevy_egui::input::egui_wants_any_keyboard_input;

use super::camera::{CameraSystems, ViewPreset};
use super::drive::ViewerCommand;
use crate::cycle::CycleClock;

/// Carries out what the keys mean.
pub struct KeysPlugin;

impl Plugin for KeysPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Shown>().add_message::<Action>().add_systems(
            Update,
            (read_keys.run_if(not(egui_wants_any_keyboard_input)), carry_out)
                .chain()
                .in_set(KeysSystems)
                .before(CameraSystems),
        );
    }
}

/// The systems that carry out what the keys mean.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct KeysSystems;

/// What a key, or a button, does.
#[derive(Message, Clone, Copy, PartialEq, Debug)]
pub enum Action {
    /// Something for the match.
    Command(ViewerCommand),
    /// Another view.
    View(ViewPreset),
    /// Shows or hides something.
    Toggle(Switch),
    /// Writes a picture of the window to the current folder.
    Screenshot,
}

/// What can be shown or hidden.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Switch {
    /// The list of keys.
    Help,
    /// The list of events.
    Events,
    /// Names above the robots.
    Labels,
    /// Shadows and smooth edges.
    FineDrawing,
}

/// What is shown.
#[derive(Resource, Clone, Copy, PartialEq, Eq, Debug)]
pub struct Shown {
    /// The list of keys.
    pub help: bool,
    /// The list of events.
    pub events: bool,
    /// Names above the robots.
    pub labels: bool,
    /// Shadows and smooth edges.
    pub fine_drawing: bool,
}

impl Default for Shown {
    fn default() -> Self {
        Self { help: false, events: true, labels: true, fine_drawing: true }
    }
}

impl Shown {
    /// The switch, to change it.
    pub fn of_mut(&mut self, switch: Switch) -> &mut bool {
        match switch {
            Switch::Help => &mut self.help,
            Switch::Events => &mut self.events,
            Switch::Labels => &mut self.labels,
            Switch::FineDrawing => &mut self.fine_drawing,
        }
    }
}

/// A key and what it does.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Binding {
    /// The key.
    pub key: KeyCode,
    /// Whether Shift is held down.
    pub shift: bool,
    /// The key's name on a keyboard.
    pub name: &'static str,
    /// What it does, for people.
    pub description: &'static str,
    /// What it does.
    pub action: Action,
}

const fn binding(key: KeyCode, name: &'static str, description: &'static str, action: Action) -> Binding {
    Binding { key, shift: false, name, description, action }
}

const fn with_shift(binding: Binding) -> Binding {
    Binding { shift: true, ..binding }
}

/// All keys.
pub const BINDINGS: &[Binding] = &[
    binding(KeyCode::Space, "Space", "Pause, go on", Action::Command(ViewerCommand::TogglePause)),
    binding(KeyCode::ArrowRight, "Right", "One cycle", Action::Command(ViewerCommand::Step)),
    binding(KeyCode::ArrowUp, "Up", "Faster", Action::Command(ViewerCommand::Faster)),
    binding(KeyCode::ArrowDown, "Down", "Slower", Action::Command(ViewerCommand::Slower)),
    binding(KeyCode::KeyR, "R", "Same match from the start", Action::Command(ViewerCommand::Restart)),
    with_shift(binding(
        KeyCode::KeyR,
        "Shift R",
        "New match with the next seed",
        Action::Command(ViewerCommand::RestartWithNextSeed),
    )),
    binding(KeyCode::Digit1, "1", "View from the side", Action::View(ViewPreset::Broadcast)),
    binding(KeyCode::Digit2, "2", "View from above", Action::View(ViewPreset::TopDown)),
    binding(KeyCode::Digit3, "3", "Follow the ball", Action::View(ViewPreset::FollowBall)),
    binding(KeyCode::KeyE, "E", "Events", Action::Toggle(Switch::Events)),
    binding(KeyCode::KeyN, "N", "Names of the robots", Action::Toggle(Switch::Labels)),
    binding(KeyCode::KeyS, "S", "Shadows, smooth edges", Action::Toggle(Switch::FineDrawing)),
    binding(KeyCode::KeyH, "H", "This help", Action::Toggle(Switch::Help)),
    binding(KeyCode::F12, "F12", "Save a picture", Action::Screenshot),
];

/// What the mouse does, for the help.
pub const MOUSE: &[(&str, &str)] =
    &[("Left drag", "Turn the view"), ("Right drag", "Move the view"), ("Wheel", "Closer, farther")];

fn read_keys(keys: Res<ButtonInput<KeyCode>>, mut actions: MessageWriter<Action>) {
    let shift = keys.any_pressed([KeyCode::ShiftLeft, KeyCode::ShiftRight]);
    actions.write_batch(
        BINDINGS
            .iter()
            .filter(|binding| keys.just_pressed(binding.key) && binding.shift == shift)
            .map(|binding| binding.action),
    );
}

fn carry_out(
    mut actions: MessageReader<Action>,
    mut viewer_commands: MessageWriter<ViewerCommand>,
    mut views: MessageWriter<ViewPreset>,
    mut shown: ResMut<Shown>,
    clock: Res<CycleClock>,
    mut commands: Commands,
) {
    for action in actions.read() {
        match *action {
            Action::Command(command) => {
                viewer_commands.write(command);
            }
            Action::View(preset) => {
                views.write(preset);
            }
            Action::Toggle(switch) => {
                let switch = shown.of_mut(switch);
                *switch = !*switch;
            }
            Action::Screenshot => {
                let path = format!("naoisis-{:06}.png", clock.cycle);
                commands.spawn(Screenshot::primary_window()).observe(save_to_disk(path));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_key_means_two_things() {
        for (index, binding) in BINDINGS.iter().enumerate() {
            for other in &BINDINGS[index + 1..] {
                assert!(binding.key != other.key || binding.shift != other.shift, "{}", binding.name);
            }
        }
    }
}
