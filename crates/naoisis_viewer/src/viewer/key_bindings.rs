//! The table of keys and their actions.

use bevy::prelude::*;

use super::commands::{
    Action, FindEvent, HandAction, SelectionCommand, Share, TakePicture, TeachAction, TimelineCommand, ToggleFilm,
    ViewPreset, ViewerCommand,
};
use super::display_settings::Switch;
use super::key_presses::KeyPress;
use naoisis_core::camera_model::CameraName;
use naoisis_core::team::Team;

/// A key and its action.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Binding {
    /// The key.
    pub key: KeyCode,
    /// Whether Shift is held down.
    pub shift: bool,
    /// Whether Ctrl or the command key is held down.
    pub control: bool,
    /// The name of the key on a keyboard.
    pub name: &'static str,
    /// The description for the help.
    pub description: &'static str,
    /// The action.
    pub action: Action,
}

const fn binding(key: KeyCode, name: &'static str, description: &'static str, action: Action) -> Binding {
    Binding { key, shift: false, control: false, name, description, action }
}

const fn with_shift(binding: Binding) -> Binding {
    Binding { shift: true, ..binding }
}

const fn with_control(binding: Binding) -> Binding {
    Binding { control: true, ..binding }
}

/// All keys.
pub const BINDINGS: &[Binding] = &[
    binding(KeyCode::Space, "Space", "Pause, continue", Action::Command(ViewerCommand::TogglePause)),
    binding(KeyCode::ArrowRight, "Right", "One cycle", Action::Command(ViewerCommand::Step)),
    binding(KeyCode::ArrowUp, "Up", "Faster", Action::Command(ViewerCommand::Faster)),
    binding(KeyCode::ArrowDown, "Down", "Slower", Action::Command(ViewerCommand::Slower)),
    binding(KeyCode::ArrowLeft, "Left", "One cycle back", Action::Timeline(TimelineCommand::Step(-1))),
    binding(KeyCode::PageUp, "Page up", "Five seconds back", Action::Timeline(TimelineCommand::Skip(-5.0))),
    binding(KeyCode::PageDown, "Page down", "Five seconds forward", Action::Timeline(TimelineCommand::Skip(5.0))),
    binding(KeyCode::Home, "Home", "To the start", Action::Timeline(TimelineCommand::GoTo(0))),
    binding(KeyCode::End, "End", "To the present", Action::Timeline(TimelineCommand::Present)),
    binding(KeyCode::Comma, ",", "To the previous listed event", Action::Find(FindEvent::Previous)),
    binding(KeyCode::Period, ".", "To the next listed event", Action::Find(FindEvent::Next)),
    binding(KeyCode::KeyF, "F", "New branch from here", Action::PlayFromHere),
    binding(KeyCode::KeyR, "R", "Restart the same match", Action::Command(ViewerCommand::Restart)),
    with_shift(binding(
        KeyCode::KeyR,
        "Shift R",
        "New match with the next seed",
        Action::Command(ViewerCommand::RestartWithNextSeed),
    )),
    binding(KeyCode::Backspace, "Backspace", "The match before this one", Action::Command(ViewerCommand::MatchBefore)),
    binding(KeyCode::F1, "F1", "View from the side", Action::View(ViewPreset::Broadcast)),
    binding(KeyCode::F2, "F2", "View from above", Action::View(ViewPreset::TopDown)),
    binding(KeyCode::F3, "F3", "Follow the ball", Action::View(ViewPreset::FollowBall)),
    binding(KeyCode::F4, "F4", "Follow the selected robot", Action::View(ViewPreset::FollowRobot)),
    binding(KeyCode::F5, "F5", "Through its first camera", Action::View(ViewPreset::RobotCamera(CameraName::TOP))),
    binding(KeyCode::F6, "F6", "Through its last camera", Action::View(ViewPreset::RobotCamera(CameraName::BOTTOM))),
    binding(KeyCode::F7, "F7", "Fly with the mouse", Action::View(ViewPreset::Fly)),
    binding(KeyCode::KeyZ, "Z", "Another match beside this one", Action::Compare),
    binding(KeyCode::Tab, "Tab", "Next robot", Action::Select(SelectionCommand::Next)),
    with_shift(binding(KeyCode::Tab, "Shift Tab", "Previous robot", Action::Select(SelectionCommand::Previous))),
    binding(KeyCode::Escape, "Esc", "No robot", Action::Select(SelectionCommand::Nobody)),
    binding(KeyCode::KeyV, "V", "Watch, debug, teach", Action::NextWorkspace(1)),
    with_shift(binding(KeyCode::KeyV, "Shift V", "Teach, debug, watch", Action::NextWorkspace(-1))),
    binding(KeyCode::KeyI, "I", "The selected robot", Action::Toggle(Switch::Robot)),
    binding(KeyCode::KeyC, "C", "The cameras of all robots", Action::Toggle(Switch::Cameras)),
    binding(KeyCode::KeyO, "O", "Overlays", Action::Toggle(Switch::Overlays)),
    binding(KeyCode::KeyG, "G", "Lanes: the whole match", Action::Toggle(Switch::Lanes)),
    binding(KeyCode::KeyQ, "Q", "Plots of any number", Action::Toggle(Switch::Plots)),
    binding(KeyCode::KeyT, "T", "This moment, many times", Action::Toggle(Switch::ManyTimes)),
    binding(KeyCode::KeyA, "A", "What decided it", Action::Toggle(Switch::Decided)),
    binding(KeyCode::KeyE, "E", "Events", Action::Toggle(Switch::Events)),
    binding(KeyCode::KeyN, "N", "Names of the robots", Action::Toggle(Switch::Labels)),
    with_shift(binding(KeyCode::KeyS, "Shift S", "Statistics of the match", Action::Toggle(Switch::Summary))),
    binding(KeyCode::KeyS, "S", "Shadows, smooth edges", Action::Toggle(Switch::FineDrawing)),
    binding(KeyCode::KeyL, "L", "Light or dark", Action::Toggle(Switch::Light)),
    binding(KeyCode::KeyW, "W", "Whistle", Action::Hand(HandAction::Whistle)),
    binding(KeyCode::KeyB, "B", "Drop the ball on the centre", Action::Hand(HandAction::DropBall)),
    binding(KeyCode::KeyP, "P", "Penalise or return the robot", Action::Hand(HandAction::PenaliseOrReturn)),
    binding(KeyCode::KeyD, "D", "Drive the selected robot", Action::Hand(HandAction::Drive)),
    with_control(binding(KeyCode::KeyZ, "Ctrl Z", "Undo the last action", Action::Hand(HandAction::Undo))),
    with_control(with_shift(binding(
        KeyCode::KeyZ,
        "Ctrl Shift Z",
        "Redo the undone action",
        Action::Hand(HandAction::Redo),
    ))),
    with_control(binding(KeyCode::KeyY, "Ctrl Y", "Redo the undone action", Action::Hand(HandAction::Redo))),
    binding(KeyCode::KeyU, "U", "Pen: arrows, with Shift zones", Action::Teach(TeachAction::Pen)),
    binding(KeyCode::KeyX, "X", "Erase the last stroke", Action::Teach(TeachAction::Erase)),
    binding(KeyCode::KeyY, "Y", "One robot's world, or the truth", Action::Teach(TeachAction::RobotsWorld)),
    binding(KeyCode::KeyK, "K", "Bookmark with a caption", Action::Teach(TeachAction::Bookmark)),
    binding(KeyCode::KeyJ, "J", "Next bookmark", Action::Teach(TeachAction::NextBookmark)),
    with_shift(binding(KeyCode::KeyJ, "Shift J", "Previous bookmark", Action::Teach(TeachAction::PreviousBookmark))),
    binding(KeyCode::F9, "F9", "Save the situation", Action::Hand(HandAction::KeepSituation)),
    with_control(binding(KeyCode::KeyS, "Ctrl S", "Save the match and its trace", Action::Hand(HandAction::KeepMatch))),
    binding(KeyCode::Equal, "+", "Larger panels", Action::ScalePanels(1)),
    with_shift(binding(KeyCode::Equal, "Shift =", "Larger panels", Action::ScalePanels(1))),
    binding(KeyCode::NumpadAdd, "+ on the key pad", "Larger panels", Action::ScalePanels(1)),
    binding(KeyCode::Minus, "−", "Smaller panels", Action::ScalePanels(-1)),
    binding(KeyCode::NumpadSubtract, "− on the key pad", "Smaller panels", Action::ScalePanels(-1)),
    binding(KeyCode::F11, "F11", "Full screen", Action::FullScreen),
    with_shift(binding(
        KeyCode::F11,
        "Shift F11",
        "For a projector: larger, with a legend",
        Action::Toggle(Switch::Projector),
    )),
    binding(KeyCode::KeyM, "M", "Scenario, teams, settings", Action::Toggle(Switch::Game)),
    with_control(binding(KeyCode::KeyO, "Ctrl O", "Open a file", Action::OpenFile)),
    binding(KeyCode::F8, "F8", "Record a video", Action::Film(ToggleFilm::Video)),
    with_shift(binding(KeyCode::F8, "Shift F8", "Record PNG files", Action::Film(ToggleFilm::Frames))),
    binding(KeyCode::KeyH, "H", "This help", Action::Toggle(Switch::Help)),
    binding(KeyCode::F10, "F10", "Cost of a frame", Action::Toggle(Switch::FrameCost)),
    with_control(binding(
        KeyCode::F8,
        "Ctrl F8",
        "Record a video without panels",
        Action::Film(ToggleFilm::VideoOfMatch),
    )),
    binding(KeyCode::F12, "F12", "Save a picture", Action::Picture(TakePicture::OfWindow)),
    with_control(binding(
        KeyCode::F12,
        "Ctrl F12",
        "Save a picture without panels",
        Action::Picture(TakePicture::OfMatch),
    )),
    with_control(with_shift(binding(KeyCode::KeyC, "Ctrl Shift C", "Copy a picture", Action::Share(Share::Picture)))),
    with_control(binding(KeyCode::KeyC, "Ctrl C", "Copy this moment's command", Action::Share(Share::Link))),
    with_control(binding(KeyCode::KeyP, "Ctrl P", "Save a web page", Action::Share(Share::Page))),
    with_control(binding(KeyCode::KeyK, "? or Ctrl K", "Find a command", Action::Toggle(Switch::Commands))),
];

/// The keys of the numbers of robots, from 1.
const NUMBERS: [KeyCode; 9] = {
    use KeyCode::{Digit1, Digit2, Digit3, Digit4, Digit5, Digit6, Digit7, Digit8, Digit9};
    [Digit1, Digit2, Digit3, Digit4, Digit5, Digit6, Digit7, Digit8, Digit9]
};

/// Further keys and gestures for the help: group, key, description.
const OTHERS: &[(&str, &str, &str)] = &[
    ("Robots", "1 … 9", "Blue's robot of this number"),
    ("Robots", "Shift 1 … 9", "Pink's robot of this number"),
    ("Robots", "Click", "Select a robot"),
    ("By hand", "Drag", "Move a robot, the ball"),
    ("By hand", "Shift drag", "Turn a robot, kick the ball"),
    ("View", "Left drag", "Turn the view"),
    ("View", "Right drag", "Move the view"),
    ("View", "Middle drag", "Look around"),
    ("View", "Wheel", "Closer, farther"),
];

/// A group of the help.
#[derive(Clone, PartialEq, Debug)]
pub struct HelpGroup {
    /// The name of the group.
    pub name: &'static str,
    /// Keys and descriptions: one line for each action, with its first key.
    pub lines: Vec<(&'static str, &'static str)>,
}

/// The groups of the help, in order.
const GROUPS: [&str; 7] = ["Time", "By hand", "Robots", "View", "Panels", "Presenting", "Sharing"];

/// The group of an action.
fn group_of(action: Action) -> &'static str {
    match action {
        Action::Command(_) | Action::Timeline(_) | Action::Find(_) | Action::PlayFromHere => "Time",
        Action::Hand(_) => "By hand",
        Action::Teach(_) => "Presenting",
        Action::Select(_) => "Robots",
        Action::View(_) | Action::Compare => "View",
        Action::Toggle(_) | Action::ScalePanels(_) | Action::Workspace(_) | Action::NextWorkspace(_) => "Panels",
        Action::FullScreen | Action::OpenFile => "Panels",
        Action::Picture(_) | Action::Film(_) | Action::Share(_) => "Sharing",
    }
}

/// The first key of each action, with the group of the action.
pub fn first_bindings() -> impl Iterator<Item = (&'static str, &'static Binding)> {
    let is_first = |(index, binding): &(usize, &Binding)| {
        BINDINGS[..*index].iter().all(|other| other.description != binding.description)
    };
    BINDINGS.iter().enumerate().filter(is_first).map(|(_, binding)| (group_of(binding.action), binding))
}

/// Returns the keys and descriptions for the help.
pub fn help() -> Vec<HelpGroup> {
    let of_bindings = first_bindings().map(|(group, binding)| (group, binding.name, binding.description));
    let lines: Vec<_> = of_bindings.chain(OTHERS.iter().copied()).collect();
    let of_group = |name| lines.iter().filter(move |(group, ..)| *group == name).map(|(_, key, what)| (*key, *what));
    GROUPS.into_iter().map(|name| HelpGroup { name, lines: of_group(name).collect() }).collect()
}

/// The actions of a pressed key.
pub(super) fn actions_of(press: KeyPress) -> impl Iterator<Item = Action> {
    let KeyPress { key, shift, control } = press;
    let is_meant = move |binding: &&Binding| binding.key == key && binding.shift == shift && binding.control == control;
    let team = if shift { Team::Pink } else { Team::Blue };
    let numbers = NUMBERS.iter().zip(1..).filter(move |(number, _)| **number == key && !control);
    let choices = numbers.map(move |(_, number)| Action::Select(SelectionCommand::Number(team, number)));
    BINDINGS.iter().filter(is_meant).map(|binding| binding.action).chain(choices)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_key_means_two_things() {
        for (index, binding) in BINDINGS.iter().enumerate() {
            for other in &BINDINGS[index + 1..] {
                assert!(
                    (binding.key, binding.shift, binding.control) != (other.key, other.shift, other.control),
                    "{}",
                    binding.name
                );
            }
            assert!(!NUMBERS.contains(&binding.key), "{}", binding.name);
        }
    }

    #[test]
    fn a_key_means_something_else_with_a_modifier() {
        let actions = |key, shift, control| actions_of(KeyPress { key, shift, control }).collect::<Vec<_>>();
        assert_eq!(actions(KeyCode::KeyV, true, false), [Action::NextWorkspace(-1)]);
        assert_eq!(actions(KeyCode::KeyZ, false, true), [Action::Hand(HandAction::Undo)]);
        assert_eq!(actions(KeyCode::KeyZ, false, false), [Action::Compare]);
        let pink2 = Action::Select(SelectionCommand::Number(Team::Pink, 2));
        assert_eq!(
            (actions(KeyCode::Digit2, true, false), actions(KeyCode::Digit2, false, true)),
            (vec![pink2], vec![])
        );
    }

    #[test]
    fn the_help_has_a_line_for_each_thing_and_every_line_a_group() {
        let groups = help();
        let lines: Vec<_> = groups.iter().flat_map(|group| &group.lines).collect();
        assert_eq!(lines.iter().filter(|(_, what)| *what == "Larger panels").count(), 1);
        for binding in BINDINGS {
            assert!(lines.iter().any(|(_, what)| *what == binding.description), "{}", binding.description);
        }
        for (_, key, what) in OTHERS {
            assert!(lines.contains(&&(*key, *what)), "{what}");
        }
    }
}
