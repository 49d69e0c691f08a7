//! The selected robot: chosen by a click, a key or from a list.

use bevy::prelude::*;

use super::camera::ViewerCamera;
use super::commands::SelectionCommand;
use super::layout::mouse_is_for_match;
use super::pitch_frame::pitch_from_world;
use super::shared::{NameAreas, Notice, Selection, SelectionSystems};
use naoisis_core::game::Penalty;
use naoisis_core::robot::Roster;
use naoisis_core::robot::body::Body;
use naoisis_core::team::RobotId;

/// The greatest movement of the mouse between press and release of a click, logical pixels.
const CLICK_PIXELS: f32 = 4.0;
/// The tolerance of a click on a robot's body, m.
const MISS_M: f32 = 0.02;

/// Selects robots.
pub struct SelectionPlugin;

impl Plugin for SelectionPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Selection>()
            .init_resource::<NameAreas>()
            .init_resource::<Notice>()
            .add_message::<SelectionCommand>()
            .add_systems(Update, (click_on_robots.run_if(mouse_is_for_match), choose).chain().in_set(SelectionSystems));
    }
}

fn choose(
    mut choices: MessageReader<SelectionCommand>,
    roster: Res<Roster>,
    mut selection: ResMut<Selection>,
    mut notice: ResMut<Notice>,
) {
    let ids: Vec<RobotId> = roster.iter().map(|(id, _)| id).collect();
    for choice in choices.read() {
        if let SelectionCommand::Number(team, number) = *choice
            && !ids.contains(&RobotId { team, number })
        {
            notice.tell(format!("There is no {}", RobotId { team, number }));
            continue;
        }
        selection.0 = chosen(*choice, selection.0, &ids);
    }
    // Another match may not have this robot.
    if selection.0.is_some_and(|id| !ids.contains(&id)) {
        selection.0 = None;
    }
}

/// The robot that is selected after a choice among `ids`.
fn chosen(choice: SelectionCommand, selected: Option<RobotId>, ids: &[RobotId]) -> Option<RobotId> {
    let place = selected.and_then(|id| ids.iter().position(|other| *other == id));
    let wanted = match choice {
        SelectionCommand::Nobody => None,
        SelectionCommand::Robot(id) => Some(id),
        SelectionCommand::Number(team, number) => Some(RobotId { team, number }),
        SelectionCommand::Next => ids.get(place.map_or(0, |place| (place + 1) % ids.len().max(1))).copied(),
        SelectionCommand::Previous => {
            ids.get(place.map_or(0, |place| (place + ids.len() - 1) % ids.len().max(1))).copied()
        }
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
    robots: Query<(&RobotId, &Transform, &Penalty, &Body)>,
    names: Res<NameAreas>,
    mut choices: MessageWriter<SelectionCommand>,
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
        .filter(|(_, _, penalty, _)| !penalty.is_off_pitch())
        .map(|(id, transform, _, body)| (*id, PickTarget::of(body, transform.translation.truncate())));
    // Names are drawn over robots.
    let hit = names.at(cursor).or_else(|| pointed_at(to_pitch * ray.origin, to_pitch * *ray.direction, places));
    choices.write(hit.map_or(SelectionCommand::Nobody, SelectionCommand::Robot));
}

/// The shape by which a robot is picked: an upright cylinder on the ground.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct PickTarget {
    /// The position of its axis, m, pitch frame.
    pub place: Vec2,
    /// Its radius, m.
    pub reach_m: f32,
    /// Its height, m.
    pub height_m: f32,
}

impl PickTarget {
    /// The shape of a robot with this body at `place`.
    pub fn of(body: &Body, place: Vec2) -> Self {
        Self { place, reach_m: body.torso.half_width_m + MISS_M, height_m: body.height_m }
    }
}

/// Returns the nearest robot that a ray from `origin` hits, pitch frame, m.
pub fn pointed_at(
    origin: Vec3,
    direction: Vec3,
    robots: impl IntoIterator<Item = (RobotId, PickTarget)>,
) -> Option<RobotId> {
    robots
        .into_iter()
        .filter_map(|(id, target)| Some((id, along_ray(origin, direction, target)?)))
        .min_by(|(one, near), (other, far)| near.total_cmp(far).then(one.cmp(other)))
        .map(|(id, _)| id)
}

/// The distance along a ray at which it hits a robot, if it does.
fn along_ray(origin: Vec3, direction: Vec3, PickTarget { place, reach_m, height_m }: PickTarget) -> Option<f32> {
    // The result is the nearest point of the ray that is within reach of the robot's axis seen from above, not above the robot and not
    // below the ground. All points of a vertical ray have the same distance from the axis.
    let offset = place - origin.truncate();
    let level = direction.truncate();
    let speed_squared = level.length_squared();
    let (enter, leave) = if speed_squared > 1e-9 {
        let closest = offset.dot(level) / speed_squared;
        let miss_squared = (offset - closest * level).length_squared();
        let half_chord = ((reach_m * reach_m - miss_squared).max(0.0) / speed_squared).sqrt();
        (miss_squared <= reach_m * reach_m).then_some((closest - half_chord, closest + half_chord))?
    } else {
        (offset.length() <= reach_m).then_some((0.0, f32::MAX))?
    };
    let height = |height: f32| (height - origin.z) / direction.z;
    let (above, below) = if direction.z.abs() > 1e-9 {
        let [one, other] = [height(height_m), height(0.0)];
        (one.min(other), one.max(other))
    } else {
        (0.0..=height_m).contains(&origin.z).then_some((0.0, f32::MAX))?
    };
    let (from, to) = (enter.max(above).max(0.0), leave.min(below));
    (from <= to).then_some(from)
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::robot::body::BodyBox;
    use naoisis_core::team::Team;

    const BLUE: RobotId = RobotId::new(Team::Blue, 1);
    const PINK: RobotId = RobotId::new(Team::Pink, 2);

    #[test]
    fn a_click_hits_the_nearer_of_two_robots_behind_each_other() {
        let at = |x, y| PickTarget::of(&Body::default(), Vec2::new(x, y));
        let robots = [(BLUE, at(2.0, 0.0)), (PINK, at(1.0, 0.05))];
        let eye = Vec3::new(-1.0, 0.0, 0.4);
        assert_eq!(pointed_at(eye, Vec3::X, robots), Some(PINK));
        assert_eq!(pointed_at(eye, Vec3::NEG_X, robots), None);
        // The ray passes over the head of the nearer robot.
        let down = (Vec3::new(2.0, 0.0, 0.3) - Vec3::new(1.0, 0.0, 1.2)).normalize();
        assert_eq!(pointed_at(Vec3::new(1.0, 0.0, 1.2), down, robots), Some(BLUE));
    }

    #[test]
    fn from_straight_above_the_robot_under_the_mouse_is_meant() {
        let at = |x, y| PickTarget::of(&Body::default(), Vec2::new(x, y));
        let robots = [(BLUE, at(0.0, 0.0)), (PINK, at(1.0, 0.0))];
        assert_eq!(pointed_at(Vec3::new(1.1, 0.0, 9.0), Vec3::NEG_Z, robots), Some(PINK));
        assert_eq!(pointed_at(Vec3::new(0.5, 0.0, 9.0), Vec3::NEG_Z, robots), None);
    }

    #[test]
    fn a_large_robot_is_met_at_its_head() {
        let nao = Body::default();
        let large = Body { height_m: 1.4, torso: BodyBox { half_width_m: 0.25, ..nao.torso }, ..nao };
        let met = |body: &Body, y: f32, z: f32| {
            pointed_at(Vec3::new(-1.0, y, z), Vec3::X, [(BLUE, PickTarget::of(body, Vec2::ZERO))]).is_some()
        };
        assert!(met(&large, 0.0, 1.3) && !met(&nao, 0.0, 1.3));
        assert!(met(&large, 0.24, 0.3) && !met(&nao, 0.24, 0.3));
    }

    #[test]
    fn a_name_is_clicked_as_its_robot_and_the_topmost_of_several() {
        let area = |x: f32| Rect::new(x, 10.0, x + 40.0, 25.0);
        let names = NameAreas(vec![(BLUE, area(100.0)), (PINK, area(120.0))]);
        let at = |x: f32, y: f32| names.at(Vec2::new(x, y));
        assert_eq!([at(105.0, 15.0), at(130.0, 15.0), at(130.0, 30.0)], [Some(BLUE), Some(PINK), None]);
    }

    #[test]
    fn choices_go_round_and_who_is_not_there_is_not_chosen() {
        let ids = [BLUE, PINK];
        assert_eq!(chosen(SelectionCommand::Next, None, &ids), Some(BLUE));
        assert_eq!(chosen(SelectionCommand::Next, Some(PINK), &ids), Some(BLUE));
        assert_eq!(chosen(SelectionCommand::Previous, Some(BLUE), &ids), Some(PINK));
        assert_eq!(chosen(SelectionCommand::Number(Team::Pink, 2), None, &ids), Some(PINK));
        assert_eq!(chosen(SelectionCommand::Next, None, &[]), None);
        assert_eq!(chosen(SelectionCommand::Nobody, Some(BLUE), &ids), None);
    }
}
