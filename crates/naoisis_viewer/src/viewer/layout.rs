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
//! Large panels are [docks](super::dock), whose edges can be dragged.

use bevy::prelude::*;
use bevy_egui::egui::{self, Align2, Context, Frame, Id, LayerId, Margin, Order, Panel, Pos2, UiBuilder};
use bevy_egui::input::EguiWantsInput;
use bevy_egui::{EguiContexts, EguiPreUpdateSet, EguiPrimaryContextPass};

use super::display_settings::{DisplaySettings, Workspace, is_debugging};
use super::theme::{MARGIN, ThemeSystems};

/// Docks panels, and computes the free area.
pub struct LayoutPlugin;

impl Plugin for LayoutPlugin {
    fn build(&self, app: &mut App) {
        use LayoutSystems::*;
        app.init_resource::<OverPanel>()
            .init_resource::<MouseTaken>()
            .init_resource::<FreeArea>()
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
pub(super) fn dock<R>(context: &Context, name: &str, panel: Panel, show: impl FnOnce(&mut egui::Ui) -> R) -> R {
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

    #[test]
    fn the_picture_is_below_a_large_score_but_keeps_most_of_the_window() {
        let window = Vec2::new(800.0, 600.0);
        let free = FreeArea::new(Rect::from_corners(Vec2::ZERO, window));
        assert_eq!(free.in_sight(window), free.within(window));
        let with_score = |height| free.with_score(height).in_sight(window).min.y;
        assert_eq!([with_score(60.0), with_score(500.0)], [60.0, 150.0]);
        assert_eq!(free.with_score(60.0).within(window), free.within(window), "the mouse is for the match there, too");
    }

    #[test]
    fn a_window_that_is_full_of_panels_still_shows_something() {
        let window = Vec2::new(800.0, 600.0);
        assert_eq!(FreeArea::default().within(window), Rect::new(0.0, 0.0, 800.0, 600.0));
        let full = FreeArea::new(Rect::new(500.0, 300.0, 480.0, 301.0)).within(window);
        assert!(full.width() >= LEAST_EDGE && full.height() >= LEAST_EDGE, "{full:?}");
    }
}
