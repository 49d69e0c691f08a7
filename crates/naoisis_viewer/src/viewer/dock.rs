//! Docked panels with an edge that can be dragged; their sizes are remembered.

use bevy::prelude::*;
use bevy_egui::egui::containers::panel::PanelState;
use bevy_egui::egui::{self, Context, Id, Panel, Rangef, UiBuilder};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

use super::layout::{dock, free_area};
use super::theme::{bright, text_size};

/// Keeps the sizes of docked panels.
pub struct DockPlugin;

impl Plugin for DockPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<PanelSizes>();
    }
}

/// Sizes of the panels whose edges were dragged, by name, logical pixels of the panels.
#[derive(Resource, Clone, PartialEq, Debug, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct PanelSizes(BTreeMap<String, f32>);

/// A docked panel with an edge that can be dragged.
#[derive(Clone, Copy, Debug)]
pub struct Dock {
    /// Its name.
    pub name: &'static str,
    /// The edge of the window.
    pub edge: Edge,
    /// Its initial width or height, logical pixels of the panels.
    pub size: f32,
    /// Its least size.
    pub least: f32,
    /// Its greatest size, as a fraction of the window's.
    pub most_share: f32,
}

/// An edge of the window.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Edge {
    /// The left one.
    Left,
    /// The right one.
    Right,
    /// The lower one.
    Below,
}

/// The least fraction of the window's width and height that is left for the match.
const MATCH: f32 = 0.35;
/// The least height of panels below the match and the least width of those beside it, even if less is left for the match,
/// logical pixels.
const LEAST_BELOW: f32 = 70.0;
const LEAST_BESIDE: f32 = 150.0;

impl Dock {
    /// The range of its size in a window of this size in which other panels have left `left`.
    fn range(&self, window: egui::Vec2, left: egui::Vec2) -> Rangef {
        let (window, left, least) = match self.edge {
            Edge::Below => (window.y, left.y, LEAST_BELOW),
            Edge::Left | Edge::Right => (window.x, left.x, LEAST_BESIDE),
        };
        // The match keeps its share, whatever is open beside and below it.
        let most = (self.most_share * window).min((left - MATCH * window).max(least));
        Rangef::new(self.least.min(most), most)
    }

    /// Its initial or remembered size.
    fn wanted(&self, sizes: &PanelSizes) -> f32 {
        sizes.0.get(self.name).copied().filter(|size| size.is_finite()).unwrap_or(self.size)
    }

    /// Returns whether the match would still have room beside it, without making the panel narrower.
    pub fn has_room(&self, context: &Context, sizes: &PanelSizes) -> bool {
        let window = context.content_rect().size();
        let width = self.range(window, egui::Vec2::INFINITY).clamp(self.wanted(sizes));
        free_area(context).width() - width >= MATCH * window.x
    }

    /// Shows the panel.
    pub fn show<R>(self, context: &Context, sizes: &mut PanelSizes, show: impl FnOnce(&mut egui::Ui) -> R) -> R {
        let id = Id::new(self.name);
        let range = self.range(context.content_rect().size(), free_area(context).size());
        let panel = match self.edge {
            Edge::Left => Panel::left(id),
            Edge::Right => Panel::right(id),
            Edge::Below => Panel::bottom(id),
        };
        // While nobody drags its edge, the panel has the size that the user wanted, as far as the window has room.
        if !context.input(|input| input.pointer.any_down() || input.pointer.any_released()) {
            context.data_mut(|data| data.remove::<PanelState>(id));
        }
        let panel = panel.resizable(true).default_size(self.wanted(sizes)).size_range(range);
        let shown = dock(context, self.name, panel, |ui| {
            // The contents do not enlarge the panel. Only dragging its edge does.
            let area = ui.available_rect_before_wrap();
            let mut inside = ui.new_child(UiBuilder::new().max_rect(area));
            inside.set_clip_rect(area.expand(2.0).intersect(ui.clip_rect()));
            let shown = show(&mut inside);
            ui.allocate_rect(area, egui::Sense::hover());
            shown
        });
        // In a smaller window the panels are smaller meanwhile. Only dragging the edge changes the wanted size. `__resize` is egui's name
        // of the edge.
        if context.read_response(id.with("__resize")).is_some_and(|edge| edge.drag_stopped())
            && let Some(state) = PanelState::load(context, id)
        {
            let size = if self.edge == Edge::Below { state.size().y } else { state.size().x };
            if (size - range.clamp(self.wanted(sizes))).abs() > 1.0 {
                sizes.0.insert(self.name.to_owned(), size.round());
            }
        }
        shown
    }
}

/// Shows the title of a panel with a button that closes it. Returns whether the button was clicked.
pub fn title(ui: &mut egui::Ui, words: &str) -> bool {
    ui.horizontal(|ui| {
        ui.label(bright(words).size(text_size::IMPORTANT));
        let button = |ui: &mut egui::Ui| ui.small_button("✖").on_hover_text("Close").clicked();
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), button).inner
    })
    .inner
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewer::layout::{bar_above, bar_below};
    use bevy_egui::egui::{Event, PointerButton, Pos2, RawInput, Rect as Area, Ui, vec2};

    /// Runs frames of a window of this size with the given events.
    fn frames(context: &Context, size: [f32; 2], events: &[Vec<Event>], mut show: impl FnMut(&Context)) {
        let screen_rect = Some(Area::from_min_size(Pos2::ZERO, size.into()));
        for events in events {
            let input = RawInput { screen_rect, events: events.clone(), ..RawInput::default() };
            let mut output = context.run_ui(input, |ui: &mut Ui| show(ui.ctx()));
            output.textures_delta.clear();
        }
    }

    const ROBOT: Dock = Dock { name: "robot", edge: Edge::Left, size: 300.0, least: 150.0, most_share: 0.4 };
    const EVENTS: Dock = Dock { name: "events", edge: Edge::Right, size: 200.0, least: 100.0, most_share: 0.3 };

    fn show_panels(context: &Context, sizes: &mut PanelSizes) -> Area {
        bar_above(context, "score", |ui| ui.allocate_space(vec2(100.0, 20.0)));
        bar_below(context, "controls", |ui| ui.allocate_space(vec2(100.0, 30.0)));
        for dock in [ROBOT, EVENTS] {
            if dock.has_room(context, sizes) {
                dock.show(context, sizes, |ui| ui.allocate_space(ui.available_size()));
            }
        }
        free_area(context)
    }

    /// The free area in a window of this size after these events.
    fn left(world: &mut World, context: &Context, size: [f32; 2], events: &[Vec<Event>]) -> Area {
        let mut area = Area::NOTHING;
        frames(context, size, events, |context| area = show_panels(context, &mut world.resource_mut::<PanelSizes>()));
        area
    }

    #[test]
    fn panels_leave_the_middle_of_the_window_and_none_where_there_is_no_room() {
        let mut world = World::new();
        world.init_resource::<PanelSizes>();
        let still = vec![Vec::new(); 3];
        let area = left(&mut world, &Context::default(), [1280.0, 720.0], &still);
        assert_eq!(area, Area::from_min_max(Pos2::new(300.0, 30.0), Pos2::new(1080.0, 680.0)));
        // In a window of half the width, the robot panel gets its share and the events are left out.
        let area = left(&mut world, &Context::default(), [640.0, 480.0], &still);
        assert_eq!(area, Area::from_min_max(Pos2::new(256.0, 30.0), Pos2::new(640.0, 440.0)));
    }

    #[test]
    fn an_edge_that_is_dragged_stays_there_the_next_time() {
        let mut world = World::new();
        world.init_resource::<PanelSizes>();
        let at = |x: f32| Pos2::new(x, 300.0);
        let button = |x, pressed| {
            vec![Event::PointerButton {
                pos: at(x),
                button: PointerButton::Primary,
                pressed,
                modifiers: egui::Modifiers::NONE,
            }]
        };
        let moved = |x| vec![Event::PointerMoved(at(x))];
        let drag = [
            vec![],
            vec![],
            moved(300.0),
            button(300.0, true),
            moved(350.0),
            moved(380.0),
            button(380.0, false),
            vec![],
        ];
        let area = left(&mut world, &Context::default(), [1280.0, 720.0], &drag);
        assert_eq!(area.left(), 380.0);
        let text = serde_json::to_string(world.resource::<PanelSizes>()).unwrap();
        assert_eq!(text, r#"{"robot":380.0}"#);
        let area = left(&mut world, &Context::default(), [1280.0, 720.0], &[vec![], vec![]]);
        assert_eq!(area.left(), 380.0);
        // A smaller window does not change the remembered size: a larger window has it again.
        let (context, still) = (Context::default(), vec![Vec::new(); 2]);
        for (width, expected) in [(1280.0, 380.0), (640.0, 256.0), (1280.0, 380.0)] {
            assert_eq!(left(&mut world, &context, [width, 720.0], &still).left(), expected);
        }
        left(&mut world, &Context::default(), [640.0, 480.0], &drag);
        assert_eq!(serde_json::to_string(world.resource::<PanelSizes>()).unwrap(), text);
    }
}
