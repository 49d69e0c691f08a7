//! Performs the actions of the [keys](super::key_bindings) of the window.

use bevy::input::keyboard::{KeyboardFocusLost, KeyboardInput};
use bevy::prelude::*;
use bevy::window::{MonitorSelection, WindowMode};
use bevy_egui::egui::{Event, Key};
use bevy_egui::input::EguiWantsInput;
use bevy_egui::{EguiInput, EguiPreUpdateSet};

use super::branches::BranchCommand;
use super::commands::{
    Action, Compare, FindEvent, HandAction, SelectionCommand, Share, TakePicture, TeachAction, TimelineCommand,
    ToggleFilm, ViewPreset, ViewerCommand,
};
use super::display_settings::{DisplaySettings, Switch};
use super::interaction::driving::Driving;
use super::key_bindings::actions_of;
use super::key_presses::HeldModifiers;
use super::shared::{CameraSystems, KeysSystems, Notice, SelectionSystems};
use super::start_page::{DialogIsOpen, NOT_ON_START_PAGE, StartPage};

/// Performs the actions of keys.
pub struct KeysPlugin;

impl Plugin for KeysPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<DisplaySettings>().init_resource::<TypedAhead>().add_message::<Action>().add_systems(
            PreUpdate,
            (keep_tab_from_panels, keep_letters_from_panels)
                .after(EguiPreUpdateSet::ProcessInput)
                .before(EguiPreUpdateSet::BeginPass),
        );
        app.add_systems(
            Update,
            (read_keys, carry_out).chain().in_set(KeysSystems).before(SelectionSystems).before(CameraSystems),
        );
    }
}

/// What was typed after the command that opens the list of commands, before its field takes keys.
#[derive(Resource, Default, Debug)]
pub(super) struct TypedAhead(pub String);

/// Removes Tab from the input of the panels, because it selects the next robot. In the panels it would move the focus,
/// which then takes all keys.
fn keep_tab_from_panels(mut inputs: Query<&mut EguiInput>) {
    for mut input in &mut inputs {
        input.events.retain(|event| !matches!(event, Event::Key { key: Key::Tab, .. }));
    }
}

/// Removes the letters of keys that are commands from the input of the panels. Otherwise, a letter would get into the field that its
/// command opens, also if the key is held down.
fn keep_letters_from_panels(
    mut inputs: MessageReader<KeyboardInput>,
    mut commands: Local<Vec<KeyCode>>,
    wants: Res<EguiWantsInput>,
    mut panels: Query<&mut EguiInput>,
) {
    let letters: Vec<String> = inputs
        .read()
        .filter_map(|input| letter_of_command(input, wants.wants_any_keyboard_input(), &mut commands))
        .collect();
    for mut panel in &mut panels {
        for letter in &letters {
            let is_letter = |event: &Event| matches!(event, Event::Text(text) if text == letter);
            if let Some(index) = panel.events.iter().position(is_letter) {
                panel.events.remove(index);
            }
        }
    }
}

/// The letter of an input if its key is a command: one that was pressed while no field had the keyboard. `held` are the commands
/// whose keys are held down.
fn letter_of_command(input: &KeyboardInput, is_for_field: bool, held: &mut Vec<KeyCode>) -> Option<String> {
    if !input.state.is_pressed() {
        held.retain(|key| *key != input.key_code);
        return None;
    }
    if !input.repeat && !is_for_field {
        held.push(input.key_code);
    }
    held.contains(&input.key_code).then(|| input.text.as_ref().map(ToString::to_string)).flatten()
}

fn read_keys(
    mut inputs: MessageReader<KeyboardInput>,
    mut losses: MessageReader<KeyboardFocusLost>,
    mut held: Local<HeldModifiers>,
    (wants, dialog): (Res<EguiWantsInput>, Option<Res<DialogIsOpen>>),
    (driving, page, display): (Res<Driving>, Option<Res<StartPage>>, Res<DisplaySettings>),
    mut notice: Option<ResMut<Notice>>,
    (mut ahead, mut actions): (ResMut<TypedAhead>, MessageWriter<Action>),
) {
    let is_dialog = dialog.is_some_and(|dialog| dialog.0);
    // With slow frames, several keys are read at once.
    let mut are_for_list = display.commands;
    for input in inputs.read() {
        let Some(press) = held.note(input).filter(|_| !(is_dialog || wants.wants_any_keyboard_input())) else {
            continue;
        };
        if are_for_list {
            ahead.0.extend(input.text.iter().flat_map(|text| text.chars()).filter(|letter| !letter.is_control()));
            continue;
        }
        // The question mark is on other keys of other keyboards.
        if input.text.as_deref() == Some("?") {
            actions.write(Action::Toggle(Switch::Commands));
            are_for_list = true;
            continue;
        }
        // Driving uses plain keys for that.
        if press.control || !driving.takes(press.key) {
            let is_page = page.as_ref().is_some_and(|page| page.0);
            for action in actions_of(press) {
                if !is_page || is_for_start_page(action) {
                    are_for_list |= action == Action::Toggle(Switch::Commands);
                    actions.write(action);
                } else if let Some(notice) = &mut notice {
                    notice.tell(NOT_ON_START_PAGE);
                }
            }
        }
    }
    if losses.read().count() > 0 {
        held.release();
    }
}

/// Whether a key does something while the start page is shown. Others would change the match behind it, unseen. What is done by hand is refused
/// by the page.
fn is_for_start_page(action: Action) -> bool {
    match action {
        Action::Toggle(switch) => {
            matches!(switch, Switch::Help | Switch::Commands | Switch::Light | Switch::FineDrawing | Switch::Projector)
        }
        Action::Command(command) => command == ViewerCommand::TogglePause,
        Action::Hand(_) | Action::Workspace(_) | Action::NextWorkspace(_) => true,
        Action::OpenFile | Action::FullScreen | Action::ScalePanels(_) | Action::Picture(_) => true,
        // Esc closes the help.
        Action::Select(command) => command == SelectionCommand::Nobody,
        _ => false,
    }
}

fn carry_out(
    mut actions: MessageReader<Action>,
    mut viewer_commands: MessageWriter<ViewerCommand>,
    (mut moments, mut events): (MessageWriter<TimelineCommand>, MessageWriter<FindEvent>),
    (mut ways, mut comparisons): (MessageWriter<BranchCommand>, MessageWriter<Compare>),
    mut views: MessageWriter<ViewPreset>,
    mut choices: MessageWriter<SelectionCommand>,
    (mut films, mut pictures): (MessageWriter<ToggleFilm>, MessageWriter<TakePicture>),
    (mut hand_actions, mut teach_actions): (MessageWriter<HandAction>, MessageWriter<TeachAction>),
    mut shares: MessageWriter<Share>,
    mut display: ResMut<DisplaySettings>,
    mut windows: Query<&mut Window>,
) {
    for action in actions.read() {
        match *action {
            Action::Command(command) => _ = viewer_commands.write(command),
            Action::Timeline(command) => _ = moments.write(command),
            Action::Find(event) => _ = events.write(event),
            Action::PlayFromHere => _ = ways.write(BranchCommand::PlayFromHere),
            Action::Compare => _ = comparisons.write(Compare),
            Action::View(preset) => _ = views.write(preset),
            // Esc closes first what lies over the match.
            Action::Select(SelectionCommand::Nobody) if display.help => display.help = false,
            Action::Select(SelectionCommand::Nobody) if display.summary => display.summary = false,
            Action::Select(choice) => _ = choices.write(choice),
            Action::Hand(action) => _ = hand_actions.write(action),
            Action::Teach(action) => _ = teach_actions.write(action),
            Action::ScalePanels(steps) => display.panel_scale = display.panel_scale.larger(steps),
            Action::Toggle(switch) => display.toggle(switch),
            Action::Workspace(workspace) => display.enter(workspace),
            Action::NextWorkspace(steps) => {
                let workspace = display.workspace.neighbour(steps);
                display.enter(workspace);
            }
            Action::Film(film) => _ = films.write(film),
            Action::Share(share) => _ = shares.write(share),
            Action::Picture(request) => _ = pictures.write(request),
            Action::FullScreen => windows.iter_mut().for_each(toggle_full_screen),
            // The dialog reads the action itself.
            Action::OpenFile => {}
        }
    }
}

fn toggle_full_screen(mut window: Mut<Window>) {
    window.mode = match window.mode {
        WindowMode::Windowed => WindowMode::BorderlessFullscreen(MonitorSelection::Current),
        _ => WindowMode::Windowed,
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_letter_of_a_command_does_not_get_into_the_field_that_it_opens() {
        let input = |state, repeat| KeyboardInput {
            key_code: KeyCode::KeyK,
            logical_key: bevy::input::keyboard::Key::Character("k".into()),
            state,
            text: Some("k".into()),
            repeat,
            window: Entity::PLACEHOLDER,
        };
        let mut held = Vec::new();
        let mut letter =
            |state, repeat, is_for_field| letter_of_command(&input(state, repeat), is_for_field, &mut held).is_some();
        use bevy::input::ButtonState::{Pressed, Released};
        assert!(letter(Pressed, false, false));
        assert!(letter(Pressed, true, true), "the key is still held down when the field is there");
        assert!(!letter(Released, false, true));
        assert!(!letter(Pressed, false, true) && !letter(Pressed, true, true), "the next one is for the field");
    }

    #[test]
    fn keys_after_the_one_that_opens_the_list_of_commands_are_typed_into_it() {
        let mut app = App::new();
        app.add_message::<KeyboardInput>()
            .add_message::<KeyboardFocusLost>()
            .add_message::<Action>()
            .init_resource::<EguiWantsInput>()
            .init_resource::<Driving>()
            .init_resource::<DisplaySettings>()
            .init_resource::<TypedAhead>()
            .add_systems(Update, read_keys);
        let press = |app: &mut App, keys: &[(KeyCode, &str)]| {
            for (key_code, text) in keys {
                app.world_mut().write_message(KeyboardInput {
                    key_code: *key_code,
                    logical_key: bevy::input::keyboard::Key::Character((*text).into()),
                    state: bevy::input::ButtonState::Pressed,
                    text: Some((*text).into()),
                    repeat: false,
                    window: Entity::PLACEHOLDER,
                });
            }
            app.update();
            let actions: Vec<Action> = app.world_mut().resource_mut::<Messages<Action>>().drain().collect();
            (actions, core::mem::take(&mut app.world_mut().resource_mut::<TypedAhead>().0))
        };
        let opens = Action::Toggle(Switch::Commands);
        let typed = [(KeyCode::Slash, "?"), (KeyCode::KeyO, "o"), (KeyCode::KeyR, "r"), (KeyCode::Enter, "\r")];
        assert_eq!(press(&mut app, &typed), (vec![opens], "or".to_owned()));
        app.world_mut().resource_mut::<DisplaySettings>().commands = true;
        assert_eq!(press(&mut app, &[(KeyCode::KeyR, "r")]), (vec![], "r".to_owned()));
        app.world_mut().resource_mut::<DisplaySettings>().commands = false;
        let restarts = Action::Command(ViewerCommand::Restart);
        assert_eq!(press(&mut app, &[(KeyCode::KeyR, "r")]), (vec![restarts], String::new()));
    }
}
