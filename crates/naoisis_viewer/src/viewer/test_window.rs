//! The whole window without a display or a graphics card, for tests: panels are operated by the names of their widgets,
//! as screen readers know them.

use bevy::app::TerminalCtrlCHandlerPlugin;
use bevy::input::ButtonState;
use bevy::input::keyboard::{Key, KeyboardInput};
use bevy::log::LogPlugin;
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::render::settings::{RenderCreation, WgpuSettings};
use bevy::time::TimeUpdateStrategy;
use bevy::window::PrimaryWindow;
use bevy::winit::{WinitPlugin, WinitSettings};
use bevy_egui::egui::{self, accesskit::Role};
use bevy_egui::{EguiContext, EguiContextSettings, EguiPrimaryContextPass, PrimaryEguiContext};
use core::time::Duration;
use egui_kittest::kittest::{NodeT, Queryable};
use egui_kittest::{Harness, Node};
use serde_json::Value;
use std::thread;

use super::ViewerPlugins;
use super::keyframes::Simulator;
use super::report_state;
use naoisis_sim::scenario::Scenario;
use naoisis_sim::simulation::{MatchApp, NaoisisPlugins};

/// The time between two frames: that of a cycle, rounded up, so that every frame plays one.
const FRAME: Duration = Duration::from_micros(33_334);

/// The size of the window, logical pixels.
const SIZE: Vec2 = Vec2::new(super::WINDOW_SIZE.0 as f32, super::WINDOW_SIZE.1 as f32);

/// The largest number of frames for which a test waits for a thread.
const MOST_FRAMES: usize = 20_000;
/// The largest number of times that a list is opened for an entry that a thread provides.
const MOST_CLICKS: usize = 1_000;

/// A window that shows a match.
pub struct TestWindow(Harness<'static, App>);

impl TestWindow {
    /// Opens a window with the first cycle of a match, paused.
    pub fn new(scenario: &Scenario) -> Self {
        let mut app = app();
        app.start_match(scenario).unwrap();
        app.world_mut().resource_mut::<super::shared::Playback>().paused = true;
        // The first frame spawns the camera that the panels belong to.
        app.update();
        let harness = Harness::builder().with_size(SIZE.to_array()).with_max_steps(32).build_ui_state(show_frame, app);
        Self(harness)
    }

    /// Shows some frames.
    pub fn frames(&mut self, count: usize) {
        self.0.run_steps(count);
    }

    /// Shows frames until the [state](super::report_state) of the window meets a condition, and returns it.
    ///
    /// # Panics
    /// When it does not come to meet it.
    pub fn wait(&mut self, what: &str, is_so: impl Fn(&Value) -> bool) -> Value {
        for _ in 0..MOST_FRAMES {
            let state = self.state();
            if is_so(&state) {
                // The panels follow.
                self.frames(2);
                return state;
            }
            self.0.step();
            // The condition may wait for a thread.
            thread::yield_now();
        }
        panic!("waiting for {what}: it does not come; the state is {:#}", self.state());
    }

    /// Shows frames until no panel has a text that says that a thread is at work.
    pub fn wait_until_gone(&mut self, text: &str) {
        for _ in 0..MOST_FRAMES {
            if !self.texts().iter().any(|shown| shown == text) {
                return;
            }
            self.frames(1);
            thread::yield_now();
        }
        panic!("`{text}` stays");
    }

    /// The state of the window, as it is [reported](super::report_state).
    pub fn state(&mut self) -> Value {
        report_state::state_of(self.0.state_mut().world_mut())
    }

    /// Changes the size of the window, logical pixels.
    pub fn resize(&mut self, size: Vec2) {
        self.0.set_size(size.to_array().into());
        let world = self.0.state_mut().world_mut();
        let mut windows = world.query_filtered::<&mut Window, With<PrimaryWindow>>();
        windows.single_mut(world).unwrap().resolution.set(size.x, size.y);
        self.frames(8);
    }

    /// Presses a key, which the keys of the window see but fields of panels do not: see [`TestWindow::press_in_field`].
    pub fn press(&mut self, key: KeyCode) {
        self.press_with(&[], key);
    }

    /// Presses a key while modifiers are held down.
    pub fn press_with(&mut self, modifiers: &[KeyCode], key: KeyCode) {
        let world = self.0.state_mut().world_mut();
        let window = world.query_filtered::<Entity, With<PrimaryWindow>>().single(world).unwrap();
        let mut input = |key_code, state| {
            let logical_key = Key::Character(String::new().into());
            world.write_message(KeyboardInput { key_code, logical_key, state, text: None, repeat: false, window });
        };
        modifiers.iter().for_each(|modifier| input(*modifier, ButtonState::Pressed));
        input(key, ButtonState::Pressed);
        input(key, ButtonState::Released);
        modifiers.iter().for_each(|modifier| input(*modifier, ButtonState::Released));
        self.frames(3);
    }

    /// The operable widgets with a name, in the order in which they were added; without texts and the number fields of
    /// sliders, which have the same name.
    fn widgets<'a>(&'a self, name: &'a str) -> Vec<Node<'a>> {
        let is_operable = |node: &Node| {
            let node = node.accesskit_node();
            !matches!(node.role(), Role::Label | Role::SpinButton) && !node.is_disabled()
        };
        self.0.query_all_by_label(name).filter(is_operable).collect()
    }

    /// Whether there is a widget with this name.
    pub fn has(&self, name: &str) -> bool {
        !self.widgets(name).is_empty()
    }

    /// The texts of the panels, in the order in which they were added.
    pub fn texts(&self) -> Vec<String> {
        let labels = self.0.query_all_by_role(Role::Label);
        labels.filter_map(|label| label.accesskit_node().value()).collect()
    }

    /// The value of a widget: a number, a text, or the chosen entry of a list.
    ///
    /// # Panics
    /// When there is no such widget, or when it has no value.
    pub fn value(&self, name: &str) -> String {
        let node = self.widget(name).accesskit_node();
        node.value().or_else(|| node.numeric_value().map(|value| value.to_string())).expect(name)
    }

    fn widget<'a>(&'a self, name: &'a str) -> Node<'a> {
        self.widgets(name).pop().unwrap_or_else(|| panic!("there is no `{name}`; the texts are {:?}", self.texts()))
    }

    /// The edges of the last widget with a name, once it is there and has come to rest.
    fn edges_at_rest(&mut self, name: &str) -> egui::Rect {
        let mut before = None;
        for _ in 0..MOST_FRAMES {
            let edges = self.widgets(name).last().map(Node::rect);
            if let Some(edges) = edges.filter(|edges| before == Some(*edges)) {
                return edges;
            }
            before = edges;
            self.frames(1);
            // A thread may know what is to be listed.
            thread::yield_now();
        }
        self.widget(name).rect()
    }

    /// Clicks on the last widget with a name, once it is there.
    ///
    /// # Panics
    /// When there is none.
    pub fn click(&mut self, name: &str) {
        self.edges_at_rest(name);
        self.widget(name).click();
        self.frames(4);
    }

    /// Opens a list, and clicks on one of its entries, once it is listed.
    ///
    /// # Panics
    /// When it is not listed.
    pub fn choose(&mut self, list: &str, entry: &str) {
        let before = self.widgets(entry).len();
        for _ in 0..MOST_CLICKS {
            self.click(list);
            if self.widgets(entry).len() > before {
                return self.click(entry);
            }
            // A panel that was being filled may have moved away from the mouse, or may not know the entry yet: the list is
            // closed, if it is open, and opened again.
            self.frames(4);
        }
        panic!("`{list}` has no `{entry}`; the texts are {:?}", self.texts());
    }

    /// Clicks on a widget, at a share of its width.
    pub fn click_along(&mut self, name: &str, share: f32) {
        self.drag_along(name, &[share]);
    }

    /// Drags the mouse over a widget, at these shares of its width.
    pub fn drag_along(&mut self, name: &str, shares: &[f32]) {
        let edges = self.edges_at_rest(name);
        let place = |share: &f32| Vec2::new(edges.left() + share * edges.width(), edges.center().y);
        let places: Vec<Vec2> = shares.iter().map(place).collect();
        self.drag(&places);
    }

    /// Drags the mouse from place to place, logical pixels.
    pub fn drag(&mut self, places: &[Vec2]) {
        let position = |place: &Vec2| egui::pos2(place.x, place.y);
        self.0.hover_at(position(&places[0]));
        self.frames(1);
        self.0.drag_at(position(&places[0]));
        self.frames(1);
        for place in &places[1..] {
            self.0.hover_at(position(place));
            self.frames(1);
        }
        self.0.drop_at(position(&places[places.len() - 1]));
        self.frames(4);
    }

    /// Types a text into a field.
    pub fn type_into(&mut self, name: &str, text: &str) {
        self.click(name);
        self.widget(name).type_text(text);
        self.frames(4);
    }

    /// Presses a key that goes to the field that has the keyboard.
    pub fn press_in_field(&mut self, key: egui::Key) {
        self.0.key_press(key);
        self.frames(4);
    }
}

fn app() -> App {
    let mut app = App::new();
    let render = WgpuSettings { backends: None, ..default() };
    app.add_plugins(
        ViewerPlugins
            .build()
            .set(RenderPlugin { render_creation: RenderCreation::Automatic(Box::new(render)), ..default() })
            .disable::<WinitPlugin>()
            .disable::<LogPlugin>()
            .disable::<TerminalCtrlCHandlerPlugin>(),
    );
    // The settings are those of a plugin that is left out.
    app.init_resource::<WinitSettings>()
        .insert_resource(TimeUpdateStrategy::ManualDuration(FRAME))
        .insert_resource(Simulator(&simulator))
        .add_plugins(NaoisisPlugins)
        .add_observer(leave_panels_to_harness);
    app.finish();
    app.cleanup();
    app
}

fn simulator() -> App {
    let mut app = App::new();
    app.add_plugins(NaoisisPlugins);
    app
}

/// Leaves the input and the passes of the panels to the harness instead of `bevy_egui`.
fn leave_panels_to_harness(
    added: On<Add, PrimaryEguiContext>,
    mut settings: Query<&mut EguiContextSettings>,
) -> Result {
    settings.get_mut(added.entity)?.run_manually = true;
    Ok(())
}

/// A frame of the app, and then of its panels.
fn show_frame(ui: &mut egui::Ui, app: &mut App) {
    let world = app.world_mut();
    let mut contexts = world.query_filtered::<&mut EguiContext, With<PrimaryEguiContext>>();
    *contexts.single_mut(world).unwrap().get_mut() = ui.ctx().clone();
    app.update();
    app.world_mut().run_schedule(EguiPrimaryContextPass);
}
