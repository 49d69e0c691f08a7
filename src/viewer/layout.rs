//! Where panels are, so that they keep clear of each other in windows of any size: each looks where those before it were in
//! the frame before.
//!
//! ```text
//! robot | hint          score          events
//! robot | costs
//! robot |                            overlays
//! robot |       hands (narrow)
//! robot |          timeline
//! hands |          controls
//! ```

use bevy::prelude::*;
use bevy_egui::egui::{Context, Id, LayerId, Order, Pos2, Rect};
use bevy_egui::input::EguiWantsInput;
use bevy_egui::{EguiContexts, EguiPreUpdateSet};

use super::theme::MARGIN;

/// Knows whether the mouse is over a panel.
pub struct LayoutPlugin;

impl Plugin for LayoutPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<OverPanel>().add_systems(PreUpdate, find_panel.after(EguiPreUpdateSet::ProcessInput));
    }
}

/// Whether the mouse is over a panel in this frame.
#[derive(Resource, Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct OverPanel(bool);

fn find_panel(mut contexts: EguiContexts, windows: Query<&Window>, mut over: ResMut<OverPanel>) -> Result {
    let context = contexts.ctx_mut()?;
    let cursor = windows.iter().next().and_then(Window::cursor_position);
    // Panels may be larger than the window has them.
    let place = cursor.map(|cursor| cursor / context.zoom_factor());
    let layer = place.and_then(|place| context.layer_id_at(Pos2::new(place.x, place.y)));
    over.0 = layer.is_some_and(|layer| layer.order != Order::Background);
    Ok(())
}

/// Whether what the mouse does is for the match. What the panels want is known of the frame before; on a slow display the
/// mouse may have come to a panel, and clicked, since then.
pub fn mouse_is_for_match(wants: Res<EguiWantsInput>, over: Res<OverPanel>) -> bool {
    !over.0 && !wants.wants_any_pointer_input()
}

/// Between panels that are above each other, logical pixels.
const GAP: f32 = 6.0;

/// Where a panel was in the frame before, if it was shown.
pub fn place_of(context: &Context, name: &str) -> Option<Rect> {
    let id = Id::new(name);
    context.memory(|memory| {
        let is_shown = memory.areas().visible_last_frame(&LayerId::new(Order::Middle, id));
        memory.area_rect(id).filter(|_| is_shown)
    })
}

/// The left edge of what the selected robot's panel leaves of the window, logical pixels of the panels.
pub fn beside_robot(context: &Context) -> f32 {
    place_of(context, "robot").map_or(0.0, |robot| robot.right())
}

/// How far to the right of the window's middle the middle of that is.
pub fn middle_beside_robot(context: &Context) -> f32 {
    beside_robot(context) / 2.0
}

/// The width of that, without its margins.
pub fn width_beside_robot(context: &Context) -> f32 {
    (context.content_rect().width() - beside_robot(context) - 2.0 * MARGIN).max(100.0)
}

/// The width of that below, where the buttons at the left leave it free on both sides of its middle.
pub fn width_below(context: &Context) -> f32 {
    let beside = width_beside_robot(context);
    let is_in_corner = |hands: &Rect| hands.left() <= MARGIN && hands.width() < 0.4 * beside;
    let hands = place_of(context, "hands").filter(|hands| is_in_corner(hands) && beside_robot(context) == 0.0);
    beside - hands.map_or(0.0, |hands| 2.0 * hands.right())
}

/// The part of the window between the panel of the selected robot and the list of events, as far as they are shown: its width
/// without margins, and how far to the right of the window's middle its own is.
pub fn between_sides(context: &Context) -> (f32, f32) {
    let (left, room) = (beside_robot(context), context.content_rect());
    let right = place_of(context, "events").map_or(room.right(), |events| events.left());
    ((right - left - 2.0 * MARGIN).max(100.0), (left + right) / 2.0 - room.center().x)
}

/// How far from the lower edge of the window a panel has to be to be above these others, as far as they are below it.
pub fn above(context: &Context, name: &str, others: &[&str]) -> f32 {
    let bottom = context.content_rect().bottom();
    let own = place_of(context, name);
    let upper_edges = others.iter().filter_map(|other| place_of(context, other)).filter(|other| meets(own, *other));
    upper_edges.map(|other| bottom - other.top() + GAP).fold(MARGIN, f32::max)
}

/// How far from the upper edge of the window a panel has to be to be below these others, as far as they are above it.
pub fn below(context: &Context, name: &str, others: &[&str]) -> f32 {
    let top = context.content_rect().top();
    let own = place_of(context, name);
    let lower_edges = others.iter().filter_map(|other| place_of(context, other)).filter(|other| meets(own, *other));
    lower_edges.map(|other| other.bottom() - top + GAP).fold(MARGIN, f32::max)
}

/// Whether one of two panels would be above the other: a panel that has no place yet may be anywhere.
fn meets(own: Option<Rect>, other: Rect) -> bool {
    own.is_none_or(|own| own.left() < other.right() + GAP && other.left() < own.right() + GAP)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewer::theme::panel;
    use bevy_egui::egui::{Align2, RawInput, Ui, vec2};

    /// Frames of a window of 800 x 600 pixels.
    fn show(context: &Context, mut show: impl FnMut(&Context)) {
        let screen_rect = Some(Rect::from_min_size(Pos2::ZERO, vec2(800.0, 600.0)));
        for _ in 0..4 {
            let input = RawInput { screen_rect, ..RawInput::default() };
            let mut output = context.run_ui(input, |ui: &mut Ui| show(ui.ctx()));
            output.textures_delta.clear();
        }
    }

    fn block(context: &Context, name: &str, align: Align2, offset: [f32; 2], size: [f32; 2]) {
        panel(name, align, offset).show(context, |ui| ui.allocate_space(size.into()));
    }

    #[test]
    fn a_panel_keeps_clear_of_those_that_are_below_it() {
        let context = Context::default();
        show(&context, |context| {
            block(context, "controls", Align2::CENTER_BOTTOM, [0.0, -MARGIN], [400.0, 40.0]);
            let offset = above(context, "right", &["controls"]);
            block(context, "right", Align2::RIGHT_BOTTOM, [-MARGIN, -offset], [300.0, 100.0]);
            let offset = above(context, "left", &["controls"]);
            block(context, "left", Align2::LEFT_BOTTOM, [MARGIN, -offset], [100.0, 100.0]);
        });
        // The one at the right would have been 90 pixels into the controls, which are 200 to 600; the other is beside them.
        assert_eq!(place_of(&context, "right").map(|right| right.bottom()), Some(600.0 - MARGIN - 40.0 - GAP));
        assert_eq!(place_of(&context, "left").map(|left| left.bottom()), Some(600.0 - MARGIN));
    }

    #[test]
    fn the_robots_panel_takes_room_only_while_it_is_shown() {
        let context = Context::default();
        show(&context, |context| block(context, "robot", Align2::LEFT_TOP, [MARGIN, MARGIN], [290.0, 100.0]));
        assert_eq!(beside_robot(&context), 300.0);
        assert_eq!(width_beside_robot(&context), 800.0 - 300.0 - 2.0 * MARGIN);
        assert_eq!(between_sides(&context), (480.0, 150.0));
        show(&context, |_| ());
        assert_eq!(beside_robot(&context), 0.0);
    }
}
