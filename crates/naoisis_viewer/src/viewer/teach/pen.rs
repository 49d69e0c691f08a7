//! The pen: arrows and zones on the pitch, which stay in place when the view moves.

use bevy::prelude::*;
use bevy::window::WindowEvent;

use crate::viewer::camera::ViewerCamera;
use crate::viewer::commands::TeachAction;
use crate::viewer::layout::{MouseTaken, OverPanel, mouse_is_over_match};
use crate::viewer::overlays::Brush;
use crate::viewer::palette;
pub use crate::viewer::pen_marks::{Pen, PenMark};
use crate::viewer::pitch_frame::pitch_from_world;
use crate::viewer::shared::Notice;
use bevy_egui::input::EguiWantsInput;
use naoisis_core::behaviour::drawings::DrawColour;

/// The distance between the three parallel lines of a stroke, m.
const APART_M: f32 = 0.012;
/// The distance between the hatching lines of a zone, m.
const HATCHING_M: f32 = 0.12;

pub(super) fn apply(
    mut actions: MessageReader<TeachAction>,
    mut pen: ResMut<Pen>,
    mut taken: ResMut<MouseTaken>,
    mut notice: ResMut<Notice>,
) {
    for action in actions.read() {
        match action {
            TeachAction::Pen => {
                pen.is_on = !pen.is_on;
                taken.0 = pen.is_on;
                pen.release();
                let on = "Pen: a drag draws an arrow, with Shift a zone; X: erase the last one; U: put the pen away";
                notice.tell(if pen.is_on { on } else { "Pen away: the mouse moves the view again" });
            }
            TeachAction::Erase => drop(pen.marks.pop()),
            _ => {}
        }
    }
}

/// What the mouse did, in the order in which it did so.
#[derive(Clone, Copy, PartialEq, Debug)]
enum MouseInput {
    /// It moved to a position in the window, logical pixels.
    Moved(Vec2),
    /// Its left button was pressed.
    Pressed,
    /// Its left button was released.
    Released,
}

impl MouseInput {
    fn of(event: &WindowEvent) -> Option<Self> {
        match event {
            WindowEvent::CursorMoved(moved) => Some(Self::Moved(moved.position)),
            WindowEvent::MouseButtonInput(input) if input.button == MouseButton::Left => {
                Some(if input.state.is_pressed() { Self::Pressed } else { Self::Released })
            }
            _ => None,
        }
    }
}

/// Draws by the mouse. While a picture is drawn, the mouse may be pressed, move on, and be released: a stroke begins and ends where it was
/// pressed and released, not where it is when the picture is ready.
pub(super) fn draw(
    mut events: MessageReader<WindowEvent>,
    mut cursor: Local<Option<Vec2>>,
    keys: Res<ButtonInput<KeyCode>>,
    window: Single<&Window>,
    camera: Single<(&Camera, &GlobalTransform), With<ViewerCamera>>,
    (wants, over): (Res<EguiWantsInput>, Res<OverPanel>),
    mut pen: ResMut<Pen>,
) {
    let shift = keys.any_pressed([KeyCode::ShiftLeft, KeyCode::ShiftRight]);
    let is_over_match = mouse_is_over_match(&wants, &over);
    *cursor = cursor.or(window.cursor_position());
    for input in events.read().filter_map(MouseInput::of) {
        if let MouseInput::Moved(at) = input {
            *cursor = Some(at);
        }
        let at = cursor.and_then(|cursor| on_pitch(*camera, cursor));
        if pen.is_on
            && (input != MouseInput::Pressed || is_over_match)
            && (pen.is_drawing() || input == MouseInput::Pressed)
        {
            guide(&mut pen, input, at, shift);
        }
    }
}

/// Guides the pen by an input of the mouse, which is `at` a point of the pitch, or over the sky.
fn guide(pen: &mut Pen, input: MouseInput, at: Option<Vec2>, shift: bool) {
    match (input, at) {
        (MouseInput::Pressed, Some(at)) => pen.press(at),
        (MouseInput::Moved(_) | MouseInput::Released, Some(at)) => pen.move_to(at, shift),
        (_, None) => {}
    }
    if input == MouseInput::Released {
        pen.release();
    }
}

/// The point on the ground at a position in the window, m, pitch frame.
fn on_pitch((camera, from): (&Camera, &GlobalTransform), cursor: Vec2) -> Option<Vec2> {
    let ray = camera.viewport_to_world(from, cursor).ok()?;
    let (origin, direction) = (pitch_from_world() * ray.origin, pitch_from_world() * *ray.direction);
    let way = -origin.z / direction.z;
    (way.is_finite() && way > 0.0).then(|| (origin + way * direction).truncate())
}

pub(super) fn show(pen: Res<Pen>, mut brush: Brush) {
    for mark in pen.marks.iter().copied().chain(pen.under_way()) {
        match mark {
            PenMark::Arrow(start, end) => {
                let aside = APART_M * (end - start).normalize_or_zero().perp();
                for step in [-1.0, 0.0, 1.0] {
                    brush.arrow(start + step * aside, end + step * aside, palette::ink(DrawColour::Yellow));
                }
            }
            PenMark::Zone(centre, edge) => {
                let (radius, colour) = (centre.distance(edge), palette::ink(DrawColour::Yellow));
                for step in [-1.0, 0.0, 1.0] {
                    brush.circle(centre, radius + step * APART_M, colour);
                }
                for (start, end) in hatching(radius) {
                    brush.line(centre + start, centre + end, colour.with_alpha(0.5));
                }
            }
        }
    }
}

/// Slanted lines within a circle about the origin.
fn hatching(radius: f32) -> impl Iterator<Item = (Vec2, Vec2)> {
    let lines = (radius / HATCHING_M).floor() as i32;
    let across = Vec2::new(1.0, -1.0).normalize();
    (-lines..=lines).map(move |line| {
        let off = line as f32 * HATCHING_M;
        let half = (radius * radius - off * off).max(0.0).sqrt();
        (off * across - half * across.perp(), off * across + half * across.perp())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drag_is_an_arrow_with_shift_a_zone_and_a_click_nothing() {
        let (one, other) = (Vec2::new(1.0, 0.5), Vec2::new(-0.5, 0.0));
        let mut pen = Pen::default();
        for (end, shift) in [(other, false), (other, true), (one + 0.01, false)] {
            pen.press(one);
            pen.move_to(end, shift);
            pen.release();
        }
        assert_eq!(pen.marks, [PenMark::Arrow(one, other), PenMark::Zone(one, other)]);
        pen.move_to(other, false);
        pen.release();
        assert_eq!(pen.marks.len(), 2, "without a press nothing is drawn");
    }

    #[test]
    fn a_stroke_within_one_picture_begins_where_the_mouse_was_pressed() {
        let (one, other) = (Vec2::new(1.0, 0.5), Vec2::new(-0.5, 0.0));
        let mut pen = Pen::default();
        let moved = MouseInput::Moved(Vec2::ZERO);
        let inputs =
            [(MouseInput::Pressed, Some(one)), (moved, Some(other)), (moved, None), (MouseInput::Released, None)];
        inputs.into_iter().for_each(|(input, at)| guide(&mut pen, input, at, false));
        assert_eq!(pen.marks, [PenMark::Arrow(one, other)], "over the sky, the last point on the ground counts");
        guide(&mut pen, moved, Some(one), false);
        assert!(!pen.is_drawing() && pen.under_way().is_none());
    }

    #[test]
    fn a_zone_is_hatched_within_its_circle() {
        let lines: Vec<_> = hatching(0.5).collect();
        assert_eq!(lines.len(), 9);
        for (start, end) in lines {
            assert!((start.length() - 0.5).abs() < 1e-5 && (end.length() - 0.5).abs() < 1e-5);
        }
    }
}
