//! Labels on the pitch: the names of robots, the words of overlays, and a ring around a small ball.

use bevy::prelude::*;
use bevy_egui::egui::{self, Align2, Color32, FontId, LayerId, Pos2, Stroke};
use bevy_egui::{EguiContexts, EguiPostUpdateSet, EguiPrimaryContextPass};

use super::camera::ViewerCamera;
use super::display_settings::{DisplaySettings, Workspace};
use super::event_log::EventLog;
use super::layout::{FreeArea, LayoutSystems};
use super::overlays::OverlayWords;
use super::palette;
use super::shared::{NameAreas, short_name, shows_truth};
use super::theme::{team_colour_on, text_size};
use naoisis_core::ball::BallPhysics;
use naoisis_core::behaviour::drawings::DrawColour;
use naoisis_core::cycle::CycleClock;
use naoisis_core::game::Penalty;
use naoisis_core::robot::body::Body;
use naoisis_core::robot::posture::Posture;
use naoisis_core::team::RobotId;

/// The distance from the upper edge of a robot to the centre of its name, logical pixels.
const ABOVE_PIXELS: f32 = 12.0;
/// The radius of the ring around a ball that appears smaller, logical pixels.
const LEAST_BALL_PIXELS: f32 = 9.0;
/// The space around a robot's name, and around words, logical pixels.
const NAME_MARGIN: egui::Vec2 = egui::vec2(5.0, 1.5);
const WORDS_MARGIN: egui::Vec2 = egui::vec2(3.0, 0.5);
/// The space between labels, logical pixels.
const GAP_PIXELS: f32 = 1.0;
/// The free width for each robot below which names are short, logical pixels at the usual size of names.
const LEAST_FOR_NAMES: f32 = 90.0;
/// The most other labels that one is moved above.
const MOST_MOVES: usize = 24;

/// The areas of all labels of this frame, logical pixels of the panels.
#[derive(Resource, Default, Debug)]
struct LabelAreas(Vec<egui::Rect>);

impl LabelAreas {
    /// Moves a label into `within` from the sides and from above, then upwards until it covers no other one, or downwards if there is no
    /// room above, and notes it. In a crowd it may cover another.
    fn place(&mut self, area: egui::Rect, within: egui::Rect) -> egui::Rect {
        let most_x = (within.max.x - area.width()).max(within.min.x);
        let corner = Pos2::new(area.min.x.clamp(within.min.x, most_x), area.min.y.max(within.min.y));
        let mut area = egui::Rect::from_min_size(corner, area.size());
        let mut is_upwards = true;
        for _ in 0..MOST_MOVES {
            // Labels that only touch do not cover each other.
            let inner = area.shrink(0.5);
            let Some(other) = self.0.iter().find(|other| other.intersects(inner)) else { break };
            let above = other.min.y - GAP_PIXELS - area.height();
            is_upwards &= above >= within.min.y;
            let top = if is_upwards { above } else { other.max.y + GAP_PIXELS };
            area = egui::Rect::from_min_size(Pos2::new(area.min.x, top), area.size());
        }
        self.0.push(area);
        area
    }
}

/// Writes the names of robots.
pub struct LabelsPlugin;

impl Plugin for LabelsPlugin {
    fn build(&self, app: &mut App) {
        // The camera has its place of this frame by then.
        app.init_resource::<NameAreas>()
            .init_resource::<LabelAreas>()
            .configure_sets(PostUpdate, EguiPostUpdateSet::EndPass.after(TransformSystems::Propagate))
            .add_systems(
                EguiPrimaryContextPass,
                (
                    forget_labels,
                    (draw_labels, ring_ball).run_if(|display: Res<DisplaySettings>| display.labels).run_if(shows_truth),
                    write_overlay_words,
                )
                    .chain()
                    .in_set(LayoutSystems::Behind),
            );
    }
}

fn write_overlay_words(
    mut contexts: EguiContexts,
    (words, display): (Res<OverlayWords>, Res<DisplaySettings>),
    camera: Single<(&Camera, &GlobalTransform), With<ViewerCamera>>,
    (free, mut areas): (Res<FreeArea>, ResMut<LabelAreas>),
) -> Result {
    let size = if is_for_audience(&display) { text_size::TITLE } else { text_size::SMALL };
    let (camera, camera_transform) = *camera;
    let context = contexts.ctx_mut()?;
    // The panels may be scaled relative to the window.
    let zoom = context.zoom_factor();
    let free = in_panels(&free, context);
    let painter = context.layer_painter(LayerId::background());
    for words in &words.0 {
        let Ok(place) = camera.world_to_viewport(camera_transform, words.place) else { continue };
        let font = FontId::proportional(size);
        // Lines fade with the age of what they show; words must stay readable.
        let text = painter.layout_no_wrap(words.text.clone(), font, palette::in_panel(words.colour.with_alpha(1.0)));
        let area = Align2::CENTER_BOTTOM.anchor_size(Pos2::new(place.x / zoom, place.y / zoom - 3.0), text.size());
        let patch = area.expand2(WORDS_MARGIN);
        if !free.intersects(patch) {
            continue;
        }
        let patch = areas.place(patch, free);
        painter.rect_filled(patch, 4.0, Color32::from_black_alpha(235));
        painter.galley(patch.min + WORDS_MARGIN, text, Color32::WHITE);
    }
    Ok(())
}

/// Whether labels are large, so that they can be read from the last row: when teaching, and when others watch on a projector.
fn is_for_audience(display: &DisplaySettings) -> bool {
    match display.workspace {
        Workspace::Teach => true,
        Workspace::Watch => display.projector,
        Workspace::Debug => false,
    }
}

/// The free area in sight in the last frame, logical pixels of the panels.
fn in_panels(free: &FreeArea, context: &egui::Context) -> egui::Rect {
    let (window, zoom) = (context.content_rect().size(), context.zoom_factor());
    let free = free.in_sight(zoom * Vec2::new(window.x, window.y));
    let [least, most] = [free.min, free.max].map(|corner| Pos2::new(corner.x / zoom, corner.y / zoom));
    egui::Rect::from_min_max(least, most)
}

fn forget_labels(mut names: ResMut<NameAreas>, mut areas: ResMut<LabelAreas>) {
    names.0.clear();
    areas.0.clear();
}

fn draw_labels(
    mut contexts: EguiContexts,
    camera: Single<(&Camera, &GlobalTransform), With<ViewerCamera>>,
    robots: Query<(&RobotId, &GlobalTransform, &Penalty, &Body, &Posture)>,
    (clock, display, log): (Res<CycleClock>, Res<DisplaySettings>, Res<EventLog>),
    (free, mut names, mut areas): (Res<FreeArea>, ResMut<NameAreas>, ResMut<LabelAreas>),
) -> Result {
    let size = if is_for_audience(&display) { text_size::TITLE } else { text_size::ENTRY };
    let (camera, camera_transform) = *camera;
    let context = contexts.ctx_mut()?;
    // The panels may be scaled relative to the window.
    let zoom = context.zoom_factor();
    let free = in_panels(&free, context);
    let painter = context.layer_painter(LayerId::background());
    let mut placed: Vec<_> = robots
        .iter()
        .filter_map(|(id, transform, penalty, body, posture)| {
            let point = transform.translation() + name_offset(body, *posture, penalty, *camera_transform.up());
            // A robot behind the camera has no place in the picture.
            let mut place = camera.world_to_viewport(camera_transform, point).ok()?;
            if !penalty.is_off_pitch() {
                place.y -= zoom * ABOVE_PIXELS;
            }
            Some((place, id, penalty))
        })
        .collect();
    // The lowest first: names are moved upwards, away from robots in front.
    placed.sort_by(|(one, ..), (other, ..)| other.y.total_cmp(&one.y));
    let robots = placed.iter().filter(|(place, ..)| free.contains(Pos2::new(place.x / zoom, place.y / zoom))).count();
    let is_short = are_short(free.width() * text_size::ENTRY / size, robots);
    for (place, id, penalty) in placed {
        let name = if is_short { short_name(*id) } else { id.to_string() };
        let name = match penalty.0 {
            Some(active) => format!("{name}: {:.0} s", active.left_s(&clock)),
            None if log.lost_program(*id, clock.end_time_s()).is_some() => format!("{name}: no program"),
            None => name,
        };
        let faded = if penalty.is_off_pitch() { 0.7 } else { 0.85 };
        // Dark enough for white letters.
        let colour = team_colour_on(false, id.team);
        let text = painter.layout_no_wrap(name, FontId::proportional(size), Color32::WHITE);
        let middle = Pos2::new(place.x / zoom, place.y / zoom);
        let area = Align2::CENTER_CENTER.anchor_size(middle, text.size());
        let patch = area.expand2(NAME_MARGIN);
        if !free.intersects(patch) {
            continue;
        }
        let patch = areas.place(patch, free);
        painter.rect_filled(patch, 7.0, colour.gamma_multiply(faded));
        let [least, most] = [patch.min, patch.max].map(|corner| zoom * Vec2::new(corner.x, corner.y));
        names.0.push((*id, Rect::from_corners(least, most)));
        painter.galley(patch.min + NAME_MARGIN, text, Color32::WHITE);
    }
    Ok(())
}

/// Whether the names of this many robots are [short](short_name), because the free area has this width.
fn are_short(free_width: f32, robots: usize) -> bool {
    free_width < LEAST_FOR_NAMES * robots as f32
}

/// The vector from a robot's position to the point at which its name is, m, in Bevy's world. A robot that waits beside the pitch is not drawn:
/// above its place, its name would be on the pitch.
fn name_offset(body: &Body, posture: Posture, penalty: &Penalty, up: Vec3) -> Vec3 {
    if penalty.is_off_pitch() { Vec3::ZERO } else { upper_edge(body, posture, up) }
}

/// The vector from a robot's position to the uppermost point of its body for a camera with the upward direction `up`,
/// m, in Bevy's world.
fn upper_edge(body: &Body, posture: Posture, up: Vec3) -> Vec3 {
    let height = if posture.is_upright() { body.height_m } else { body.lying_height_m };
    let half_extents = Vec2::new(body.torso.half_width_m, height / 2.0);
    // The half height of an enclosing cylinder, so that the name stays where it is while the robot turns.
    let reach = Vec2::new(Vec2::new(up.x, up.z).length(), up.y.abs()).dot(half_extents);
    height / 2.0 * Vec3::Y + reach * up
}

/// Draws a ring around a ball that is only a few pixels large.
fn ring_ball(
    mut contexts: EguiContexts,
    camera: Single<(&Camera, &GlobalTransform), With<ViewerCamera>>,
    balls: Query<(&GlobalTransform, &BallPhysics)>,
) -> Result {
    let (camera, camera_transform) = *camera;
    let context = contexts.ctx_mut()?;
    let zoom = context.zoom_factor();
    let painter = context.layer_painter(LayerId::background());
    for (transform, physics) in &balls {
        let centre = transform.translation() + physics.radius_m * Vec3::Y;
        let edge = centre + physics.radius_m * camera_transform.right();
        let seen = [centre, edge].map(|point| camera.world_to_viewport(camera_transform, point).ok());
        let [Some(centre), Some(edge)] = seen else { continue };
        if centre.distance(edge) < LEAST_BALL_PIXELS - 2.0 {
            let (middle, radius) = (Pos2::new(centre.x / zoom, centre.y / zoom), LEAST_BALL_PIXELS / zoom);
            painter.circle_stroke(middle, radius, Stroke::new(3.0, Color32::from_black_alpha(150)));
            painter.circle_stroke(
                middle,
                radius,
                Stroke::new(1.5, palette::in_panel(palette::ink(DrawColour::Orange))),
            );
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_at_the_same_place_are_above_each_other_and_others_stay() {
        let label = |x, y| egui::Rect::from_min_size(Pos2::new(x, y), egui::vec2(60.0, 14.0));
        let mut areas = LabelAreas::default();
        let asked = [label(0.0, 100.0), label(0.0, 100.0), label(30.0, 95.0), label(61.0, 100.0), label(200.0, 0.0)];
        let window = egui::Rect::from_min_size(Pos2::ZERO, egui::vec2(300.0, 200.0));
        let placed = asked.map(|area| areas.place(area, window));
        for (index, area) in placed.iter().enumerate() {
            assert!(placed[..index].iter().all(|other| !other.intersects(*area)), "label {index} covers another");
        }
        assert!(placed[0] == asked[0] && placed[4] == asked[4]);
        assert!((placed[1].max.y - 99.0).abs() < 1e-3, "as near as possible");
        let at_edges = [label(-40.0, 150.0), label(290.0, 150.0)].map(|area| areas.place(area, window));
        assert_eq!(at_edges.map(|area| area.min.x), [0.0, 240.0], "whole words at the edges of the window");
        let mut areas = LabelAreas::default();
        let at_top = [label(100.0, -5.0), label(100.0, 3.0)].map(|area| areas.place(area, window));
        assert_eq!(at_top.map(|area| area.min.y), [0.0, 15.0], "and below its upper edge");
    }

    #[test]
    fn names_are_short_where_there_is_little_space_for_many_robots() {
        assert!(!are_short(640.0, 6) && !are_short(1280.0, 14));
        assert!(are_short(640.0, 10) && are_short(1280.0, 22));
    }

    #[test]
    fn the_name_of_a_robot_that_waits_beside_the_pitch_is_on_the_ground_there() {
        let offset = |penalty| name_offset(&Body::default(), Posture::Upright, &penalty, Vec3::Y);
        assert_eq!(offset(Penalty::SUBSTITUTE), Vec3::ZERO);
        assert!(offset(Penalty::default()).y > 0.5);
    }

    #[test]
    fn the_upper_edge_of_a_robot_is_its_head_from_the_side_and_its_shoulder_from_above() {
        let body = Body::default();
        let from_side = upper_edge(&body, Posture::Upright, Vec3::Y);
        assert!(from_side.abs_diff_eq(Vec3::new(0.0, body.height_m, 0.0), 1e-5));
        let from_above = upper_edge(&body, Posture::Upright, Vec3::NEG_Z);
        assert!((from_above.z + body.torso.half_width_m).abs() < 1e-5);
        let large = Body { height_m: 1.4, ..body };
        assert!(upper_edge(&large, Posture::Upright, Vec3::Y).y > 1.39);
    }
}
