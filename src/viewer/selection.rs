//! Which robot the user looks at: chosen by a click, a key or from a list.

use bevy::prelude::*;

use super::camera::ViewerCamera;
use super::layout::mouse_is_for_match;
use super::shared::{Choice, Selection, SelectionSystems};
use super::stage::pitch_from_world;
use crate::game::Penalty;
use crate::robot::Roster;
use crate::team::RobotId;

/// A press and a release with less movement between them are a click, logical pixels.
const CLICK_PIXELS: f32 = 4.0;
/// How far a click may miss the axis of a robot, m.
const REACH_M: f32 = 0.17;
/// Height of a robot, m.
const HEIGHT_M: f32 = 0.58;

/// Selects robots.
pub struct SelectionPlugin;

impl Plugin for SelectionPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Selection>()
            .add_message::<Choice>()
            .add_systems(Update, (click_on_robots.run_if(mouse_is_for_match), choose).chain().in_set(SelectionSystems));
    }
}

fn choose(mut choices: MessageReader<Choice>, roster: Res<Roster>, mut selection: ResMut<Selection>) {
    let ids: Vec<RobotId> = roster.iter().map(|(id, _)| id).collect();
    for choice in choices.read() {
        selection.0 = chosen(*choice, selection.0, &ids);
    }
    // Another match may lack it.
    if selection.0.is_some_and(|id| !ids.contains(&id)) {
        selection.0 = None;
    }
}

/// The robot that is selected after a choice among `ids`.
fn chosen(choice: Choice, selected: Option<RobotId>, ids: &[RobotId]) -> Option<RobotId> {
    let place = selected.and_then(|id| ids.iter().position(|other| *other == id));
    let wanted = match choice {
        Choice::Nobody => None,
        Choice::Robot(id) => Some(id),
        Choice::Number(team, number) => Some(RobotId { team, number }),
        Choice::Next => ids.get(place.map_or(0, |place| (place + 1) % ids.len().max(1))).copied(),
        Choice::Previous => ids.get(place.map_or(0, |place| (place + ids.len() - 1) % ids.len().max(1))).copied(),
    };
    wanted.filter(|id| ids.contains(id))
}

/// Where the mouse was pressed, and how far it has moved since.
#[derive(Default)]
struct Press {
    at: Option<Vec2>,
}

fn click_on_robots(
    mut press: Local<Press>,
    buttons: Res<ButtonInput<MouseButton>>,
    window: Single<&Window>,
    camera: Single<(&Camera, &GlobalTransform), With<ViewerCamera>>,
    robots: Query<(&RobotId, &Transform, &Penalty)>,
    mut choices: MessageWriter<Choice>,
) {
    let Some(cursor) = window.cursor_position() else { return };
    if buttons.just_pressed(MouseButton::Left) {
        press.at = Some(cursor);
    }
    if !buttons.just_released(MouseButton::Left) {
        return;
    }
    if press.at.take().is_none_or(|at| at.distance(cursor) > CLICK_PIXELS) {
        return;
    }
    let (camera, from) = *camera;
    let Ok(ray) = camera.viewport_to_world(from, cursor) else { return };
    let to_pitch = pitch_from_world();
    let places = robots
        .iter()
        .filter(|(_, _, penalty)| !penalty.is_active())
        .map(|(id, transform, _)| (*id, transform.translation.truncate()));
    let hit = pointed_at(to_pitch * ray.origin, to_pitch * *ray.direction, places);
    choices.write(hit.map_or(Choice::Nobody, Choice::Robot));
}

/// The nearest of the robots at these places that a ray from `origin` meets, pitch frame, m.
pub fn pointed_at(origin: Vec3, direction: Vec3, robots: impl IntoIterator<Item = (RobotId, Vec2)>) -> Option<RobotId> {
    robots
        .into_iter()
        .filter_map(|(id, place)| Some((id, along_ray(origin, direction, place)?)))
        .min_by(|(one, near), (other, far)| near.total_cmp(far).then(one.cmp(other)))
        .map(|(id, _)| id)
}

/// How far along a ray it passes a robot that stands at a place, if it does.
fn along_ray(origin: Vec3, direction: Vec3, place: Vec2) -> Option<f32> {
    // Of the points of the ray within reach of the robot's axis seen from above, the nearest that is neither above the
    // robot nor below the ground; of a ray straight down all are as near to the axis.
    let offset = place - origin.truncate();
    let level = direction.truncate();
    let speed_squared = level.length_squared();
    let (enter, leave) = if speed_squared > 1e-9 {
        let closest = offset.dot(level) / speed_squared;
        let miss_squared = (offset - closest * level).length_squared();
        let half_chord = ((REACH_M * REACH_M - miss_squared).max(0.0) / speed_squared).sqrt();
        (miss_squared <= REACH_M * REACH_M).then_some((closest - half_chord, closest + half_chord))?
    } else {
        (offset.length() <= REACH_M).then_some((0.0, f32::MAX))?
    };
    let height = |height: f32| (height - origin.z) / direction.z;
    let (above, below) = if direction.z.abs() > 1e-9 {
        let [one, other] = [height(HEIGHT_M), height(0.0)];
        (one.min(other), one.max(other))
    } else {
        (0.0..=HEIGHT_M).contains(&origin.z).then_some((0.0, f32::MAX))?
    };
    let (from, to) = (enter.max(above).max(0.0), leave.min(below));
    (from <= to).then_some(from)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::team::Team;

    const BLUE: RobotId = RobotId::new(Team::Blue, 1);
    const PINK: RobotId = RobotId::new(Team::Pink, 2);

    #[test]
    fn a_click_hits_the_nearer_of_two_robots_behind_each_other() {
        let robots = [(BLUE, Vec2::new(2.0, 0.0)), (PINK, Vec2::new(1.0, 0.05))];
        let eye = Vec3::new(-1.0, 0.0, 0.4);
        assert_eq!(pointed_at(eye, Vec3::X, robots), Some(PINK));
        assert_eq!(pointed_at(eye, Vec3::NEG_X, robots), None);
        // Over the head of the nearer one.
        let down = (Vec3::new(2.0, 0.0, 0.3) - Vec3::new(1.0, 0.0, 1.2)).normalize();
        assert_eq!(pointed_at(Vec3::new(1.0, 0.0, 1.2), down, robots), Some(BLUE));
    }

    #[test]
    fn from_straight_above_the_robot_under_the_mouse_is_meant() {
        let robots = [(BLUE, Vec2::ZERO), (PINK, Vec2::new(1.0, 0.0))];
        assert_eq!(pointed_at(Vec3::new(1.1, 0.0, 9.0), Vec3::NEG_Z, robots), Some(PINK));
        assert_eq!(pointed_at(Vec3::new(0.5, 0.0, 9.0), Vec3::NEG_Z, robots), None);
    }

    #[test]
    fn choices_go_round_and_who_is_not_there_is_not_chosen() {
        let ids = [BLUE, PINK];
        assert_eq!(chosen(Choice::Next, None, &ids), Some(BLUE));
        assert_eq!(chosen(Choice::Next, Some(PINK), &ids), Some(BLUE));
        assert_eq!(chosen(Choice::Previous, Some(BLUE), &ids), Some(PINK));
        assert_eq!(chosen(Choice::Number(Team::Pink, 2), None, &ids), Some(PINK));
        assert_eq!(chosen(Choice::Number(Team::Pink, 3), Some(BLUE), &ids), None);
        assert_eq!(chosen(Choice::Next, None, &[]), None);
        assert_eq!(chosen(Choice::Nobody, Some(BLUE), &ids), None);
    }
}
