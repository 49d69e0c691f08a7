//! The layout of the window: panels are docked at its edges one after the other, so that none covers another or the
//! pitch. The match gets the remaining area.
//!
//! ```text
//! score
//! robot | the match                  | at the right: | events
//! robot | the match                  | cameras, …    | events
//! robot | lanes
//! timeline
//! interventions
//! controls
//! ```
//!
//! The edges of large panels can be dragged; their sizes are remembered.

use bevy::prelude::*;
use bevy_egui::egui::containers::panel::PanelState;
use bevy_egui::egui::{self, Align2, Context, Frame, Id, LayerId, Margin, Order, Panel, Pos2, Rangef, UiBuilder};
use bevy_egui::input::EguiWantsInput;
use bevy_egui::{EguiContexts, EguiPreUpdateSet, EguiPrimaryContextPass};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

use super::display_settings::{DisplaySettings, Workspace, is_debugging};
use super::theme::{MARGIN, ThemeSystems, bright, text_size};

/// Docks panels, and computes the free area.
pub struct LayoutPlugin;

impl Plugin for LayoutPlugin {
    fn build(&self, app: &mut App) {
        use LayoutSystems::*;
        app.init_resource::<OverPanel>()
            .init_resource::<MouseTaken>()
            .init_resource::<FreeArea>()
            .init_resource::<PanelSizes>()
            .configure_sets(
                EguiPrimaryContextPass,
                (Behind, Score, Controls, Interventions, TimelineBar, Robot, Lanes, Plots, Right, Events, Floating)
                    .chain()
                    .after(ThemeSystems),
            )
            // These panels are only shown in the debugging workspace. The other sets are for panels of all workspaces.
            .configure_sets(
                EguiPrimaryContextPass,
                (Score, Controls, Interventions, TimelineBar, Robot, Lanes, Plots, Events).run_if(is_debugging),
            )
            .init_resource::<HiddenPanels>()
            .configure_sets(
                EguiPrimaryContextPass,
                (Score, Controls, Interventions, TimelineBar, Robot, Lanes, Plots, Right, Events, Floating)
                    .run_if(panels_are_shown),
            )
            .add_systems(PreUpdate, find_panel.after(EguiPreUpdateSet::ProcessInput))
            .add_systems(EguiPrimaryContextPass, note_free_area.after(Events).before(Floating));
    }
}

/// The systems that show panels, in the order in which they take their part of the window.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum LayoutSystems {
    /// Labels on the pitch, which are behind all panels.
    Behind,
    /// Score and clock, at the top.
    Score,
    /// Pause, speed, scenario, at the bottom.
    Controls,
    /// The buttons for interventions, above the controls.
    Interventions,
    /// The timeline, above the interventions.
    TimelineBar,
    /// The selected robot, at the left.
    Robot,
    /// The lanes, below the match.
    Lanes,
    /// The plots, above the lanes.
    Plots,
    /// Panels at the right, one of which is open at a time.
    Right,
    /// The events, at the right.
    Events,
    /// Temporary areas above the match.
    Floating,
}

/// The area of the large score in the use for watching.
pub const LARGE_SCORE: &str = "large score";

/// Whether all panels are hidden. The match then has the whole window.
#[derive(Resource, Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct HiddenPanels {
    /// For a picture.
    pub for_picture: bool,
    /// For a recording.
    pub for_film: bool,
}

fn panels_are_shown(hidden: Res<HiddenPanels>) -> bool {
    *hidden == HiddenPanels::default()
}

/// The least edge of the free area, logical pixels, also in a window full of panels.
const LEAST_EDGE: f32 = 40.0;

/// The greatest share of the free area that the large score takes from the picture.
const MOST_FOR_SCORE: f32 = 0.25;

/// The part of the window that panels leave free, logical pixels of the window.
#[derive(Resource, Clone, Copy, PartialEq, Debug, Default)]
pub struct FreeArea {
    area: Option<Rect>,
    /// The height of the strip at its upper edge that the large score covers.
    below_score: f32,
}

impl FreeArea {
    /// A known free area.
    pub fn new(area: Rect) -> Self {
        Self { area: Some(area), below_score: 0.0 }
    }

    /// The same area, of which the large score covers a strip of this height at the upper edge.
    fn with_score(self, below_score: f32) -> Self {
        Self { below_score, ..self }
    }

    /// Returns whether panels have been laid out.
    pub fn is_known(&self) -> bool {
        self.area.is_some()
    }

    /// Returns the free area in a window of this size; the whole window before panels have been laid out.
    pub fn within(&self, window: Vec2) -> Rect {
        let window = Rect::from_corners(Vec2::ZERO, window.max(Vec2::ONE));
        let free = self.area.map_or(window, |free| free.intersect(window));
        Rect::from_center_size(free.center(), free.size().max(Vec2::splat(LEAST_EDGE).min(window.size())))
    }

    /// Returns the free area without what the large score covers: the picture of the match is in its middle.
    pub fn in_sight(&self, window: Vec2) -> Rect {
        let free = self.within(window);
        let covered = self.below_score.clamp(0.0, MOST_FOR_SCORE * free.height());
        Rect { min: free.min + covered * Vec2::Y, ..free }
    }

    /// Returns the aspect (width by height) of the free area in sight.
    pub fn aspect(&self, window: Vec2) -> f32 {
        let size = self.in_sight(window).size();
        (size.x / size.y).clamp(0.2, 5.0)
    }
}

/// Whether the mouse is over a panel in this frame.
#[derive(Resource, Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct OverPanel(bool);

/// Whether the mouse is used for something other than the match and the camera.
#[derive(Resource, Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct MouseTaken(pub bool);

fn find_panel(
    mut contexts: EguiContexts,
    windows: Query<&Window>,
    free: Res<FreeArea>,
    mut over: ResMut<OverPanel>,
) -> Result {
    let context = contexts.ctx_mut()?;
    let Some(window) = windows.iter().next() else { return Ok(()) };
    let Some(cursor) = window.cursor_position() else { return Ok(()) };
    // The panels may be scaled relative to the window.
    let place = cursor / context.zoom_factor();
    let is_above =
        context.layer_id_at(Pos2::new(place.x, place.y)).is_some_and(|layer| layer.order != Order::Background);
    over.0 = is_above || !free.within(window.size()).contains(cursor);
    Ok(())
}

/// Returns whether input of the mouse is for the match. egui's wishes are those of the last frame; on a slow display the mouse
/// may have reached and clicked a panel since then.
pub fn mouse_is_for_match(wants: Res<EguiWantsInput>, over: Res<OverPanel>, taken: Res<MouseTaken>) -> bool {
    mouse_is_over_match(&wants, &over) && !taken.0
}

/// Returns whether input of the mouse is not for panels.
pub fn mouse_is_over_match(wants: &EguiWantsInput, over: &OverPanel) -> bool {
    !over.0 && !wants.wants_any_pointer_input()
}

fn note_free_area(mut contexts: EguiContexts, display: Res<DisplaySettings>, mut free: ResMut<FreeArea>) -> Result {
    let context = contexts.ctx_mut()?;
    let score = shown_at(context, LARGE_SCORE).filter(|_| display.workspace == Workspace::Watch);
    let (area, zoom) = (free_area(context), context.zoom_factor());
    let corners = [area.min, area.max].map(|corner| zoom * Vec2::new(corner.x, corner.y));
    let below_score = score.map_or(0.0, |score| zoom * (score.bottom() - area.top()));
    free.set_if_neq(FreeArea::new(Rect::from_corners(corners[0], corners[1])).with_score(below_score));
    Ok(())
}

/// Returns the area that the panels docked in this frame leave free, logical pixels of the panels.
pub fn free_area(context: &Context) -> egui::Rect {
    let pass = context.cumulative_pass_nr();
    let noted = context.data(|data| data.get_temp::<(u64, egui::Rect)>(free_area_id()));
    noted.filter(|(of, _)| *of == pass).map_or_else(|| context.content_rect(), |(_, area)| area)
}

fn free_area_id() -> Id {
    Id::new("free area")
}

/// Docks a panel at an edge of the free area.
fn dock<R>(context: &Context, name: &str, panel: Panel, show: impl FnOnce(&mut egui::Ui) -> R) -> R {
    let area = UiBuilder::new().layer_id(LayerId::background()).max_rect(free_area(context));
    let mut ui = egui::Ui::new(context.clone(), Id::new(("docked", name)), area);
    let frame = Frame::NONE.fill(ui.visuals().panel_fill).inner_margin(Margin::symmetric(10, 5));
    let shown = panel.frame(frame).show(&mut ui, show);
    let left = (context.cumulative_pass_nr(), ui.available_rect_before_wrap());
    context.data_mut(|data| data.insert_temp(free_area_id(), left));
    shown.inner
}

/// Shows a bar along the upper edge, as high as its contents.
pub fn bar_above<R>(context: &Context, name: &'static str, show: impl FnOnce(&mut egui::Ui) -> R) -> R {
    bar(context, name, Panel::top(name), show)
}

/// Shows a bar along the lower edge, as high as its contents.
pub fn bar_below<R>(context: &Context, name: &'static str, show: impl FnOnce(&mut egui::Ui) -> R) -> R {
    bar(context, name, Panel::bottom(name), show)
}

fn bar<R>(context: &Context, name: &str, panel: Panel, show: impl FnOnce(&mut egui::Ui) -> R) -> R {
    let shown = dock(context, name, panel.resizable(false).show_separator_line(false), show);
    let left = free_area(context);
    context.data_mut(|data| data.insert_temp(between_bars_id(), left));
    shown
}

/// Returns the area between the bars along the upper and the lower edge, logical pixels of the panels.
pub fn between_bars(context: &Context) -> egui::Rect {
    context.data(|data| data.get_temp(between_bars_id())).unwrap_or_else(|| context.content_rect())
}

fn between_bars_id() -> Id {
    Id::new("between bars")
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

/// Returns an area above the match, at an edge or in a corner of the free area.
pub fn floating(context: &Context, name: &str, align: Align2) -> egui::Area {
    let place = align.pos_in_rect(&free_area(context).shrink(MARGIN));
    egui::Area::new(Id::new(name)).pivot(align).fixed_pos(place)
}

/// Returns the place of a floating area in the last frame, logical pixels of the panels, if it was shown then.
pub fn shown_at(context: &Context, name: &str) -> Option<egui::Rect> {
    let layer = LayerId::new(Order::Middle, Id::new(name));
    context.memory(|memory| memory.area_rect(layer.id).filter(|_| memory.areas().visible_last_frame(&layer)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy_egui::egui::{Event, PointerButton, RawInput, Rect as Area, Ui, vec2};

    /// Runs frames of a window of this size with the given events.
    fn frames(context: &Context, size: [f32; 2], events: &[Vec<Event>], mut show: impl FnMut(&Context)) {
        let screen_rect = Some(Area::from_min_size(Pos2::ZERO, size.into()));
        for events in events {
            let input = RawInput { screen_rect, events: events.clone(), ..RawInput::default() };
            let mut output = context.run_ui(input, |ui: &mut Ui| show(ui.ctx()));
            output.textures_delta.clear();
        }
    }

    #[test]
    fn the_picture_is_below_a_large_score_but_keeps_most_of_the_window() {
        let window = Vec2::new(800.0, 600.0);
        let free = FreeArea::new(Rect::from_corners(Vec2::ZERO, window));
        assert_eq!(free.in_sight(window), free.within(window));
        let with_score = |height| free.with_score(height).in_sight(window).min.y;
        assert_eq!([with_score(60.0), with_score(500.0)], [60.0, 150.0]);
        assert_eq!(free.with_score(60.0).within(window), free.within(window), "the mouse is for the match there, too");
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
    fn a_window_that_is_full_of_panels_still_shows_something() {
        let window = Vec2::new(800.0, 600.0);
        assert_eq!(FreeArea::default().within(window), Rect::new(0.0, 0.0, 800.0, 600.0));
        let full = FreeArea::new(Rect::new(500.0, 300.0, 480.0, 301.0)).within(window);
        assert!(full.width() >= LEAST_EDGE && full.height() >= LEAST_EDGE, "{full:?}");
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
