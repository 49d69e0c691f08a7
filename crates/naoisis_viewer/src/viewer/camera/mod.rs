//! The camera of the window: from the side, from above, following play, the ball or a robot, through a robot's camera,
//! or flying freely.

use bevy::camera::CameraUpdateSystems;
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::input::mouse::{AccumulatedMouseMotion, AccumulatedMouseScroll, MouseScrollUnit};
use bevy::math::ops;
use bevy::prelude::*;
use bevy_egui::{EguiGlobalSettings, PrimaryEguiContext};

mod choice;
pub mod free_area;
mod haze;
pub mod robot_view;
mod told;
pub mod viewpoint;

use super::commands::ViewPreset;
use super::display_settings::is_debugging;
use super::layout::{FreeArea, mouse_is_for_match};
use super::pitch_frame::{PitchFrameSystems, PitchRoot, pose_of};
use super::robot_model::RobotLimbs;
use super::shared::{CameraSystems, DrawnWhenSensed, Notice, RobotsWorld, SecondPitch, Selection, SelectionSystems};
use choice::{FollowsAgain, choose_view, follow_again, look_at_places, make_room, show_other_match};
pub use choice::{LookAt, in_another_area};
use free_area::AreaPerspective;
use naoisis_core::ball::Ball;
use naoisis_core::camera_model::{CameraMount, CameraName, CameraView};
use naoisis_core::cycle::CycleClock;
use naoisis_core::game::Penalty;
use naoisis_core::geometry::wrap_angle;
use naoisis_core::pitch::Pitch;
use naoisis_core::robot::Roster;
use naoisis_core::robot::body::Body;
use naoisis_core::robot::head::HeadAngles;
use naoisis_core::robot::posture::Posture;
use naoisis_core::team::RobotId;
use naoisis_record::record::history::History;
use naoisis_sensing::appearance::scene::world_from_body;
use naoisis_sensing::sensing::camera::CameraSettings;
use naoisis_sim::scenario::Scenario;
use viewpoint::{FIELD_OF_VIEW, Overview, Viewpoint};

/// The rate at which the camera approaches its target, 1/s.
const EASING_PER_S: f32 = 8.0;
/// The rate at which the camera follows play, 1/s. It is low because play moves back and forth.
const PLAY_EASING_PER_S: f32 = 1.2;
/// Pixels of a touch pad that count as one notch of a wheel.
const PIXELS_PER_NOTCH: f32 = 40.0;
/// The near plane, m; small, because the lens of a robot is close to its face.
const NEAR_M: f32 = 0.02;

/// The camera of the window.
pub struct ViewerCameraPlugin;

impl Plugin for ViewerCameraPlugin {
    fn build(&self, app: &mut App) {
        app.add_message::<ViewPreset>()
            .add_message::<LookAt>()
            .init_resource::<SecondPitch>()
            .init_resource::<FollowsAgain>()
            // The panels must not be drawn in the images of the robots' cameras.
            .insert_resource(EguiGlobalSettings { auto_create_primary_context: false, ..default() })
            .add_systems(Startup, spawn_camera)
            .add_systems(
                Update,
                (
                    make_room,
                    choose_view,
                    (look_at_places, follow_again).chain(),
                    use_mouse.run_if(mouse_is_for_match).in_set(CameraMouse),
                )
                    .chain()
                    .after(SelectionSystems)
                    .in_set(CameraSystems),
            )
            .add_systems(
                Update,
                told::tell_robot.run_if(resource_exists::<Notice>.and_then(not(is_debugging))).after(CameraSystems),
            )
            .add_systems(PostUpdate, choose_instant.before(PitchFrameSystems))
            // By then, everything that the camera may follow has its place of this frame.
            .add_systems(
                PostUpdate,
                (follow, move_camera, haze::thin_haze, hide_own_body)
                    .chain()
                    .after(PitchFrameSystems)
                    .before(TransformSystems::Propagate)
                    // What is drawn and what is culled are of the same projection.
                    .before(CameraUpdateSystems),
            )
            .add_systems(PreUpdate, show_other_match.run_if(resource_exists_and_changed::<Scenario>));
    }
}

/// The system that moves the camera by the mouse. Systems that need the mouse run before it.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct CameraMouse;

/// What the camera follows.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub enum CameraMode {
    /// Shows the whole pitch in the free area of the window.
    Pitch(Overview),
    /// Turns about a point of the pitch by the mouse.
    #[default]
    Orbit,
    /// Flies by the mouse.
    Fly,
    /// Follows play: the ball and its surroundings.
    Play,
    /// Follows the ball.
    Ball,
    /// Follows the selected robot.
    Robot {
        /// The last heading of the robot, counter-clockwise from +x, radians, pitch frame.
        heading: f32,
    },
    /// Looks through a camera of the selected robot.
    RobotCamera(CameraName),
}

/// The camera of the window.
#[derive(Component, Clone, Copy, PartialEq, Debug)]
pub struct ViewerCamera {
    /// The current viewpoint.
    pub current: Viewpoint,
    /// The viewpoint that it approaches.
    pub wanted: Viewpoint,
    /// What it follows.
    pub mode: CameraMode,
}

fn spawn_camera(mut commands: Commands, root: Res<PitchRoot>, pitch: Res<Pitch>, window: Query<&Window>) {
    let window = size_of(window);
    let area = FreeArea::default().within(window);
    let view = Viewpoint::of_pitch(Overview::Broadcast, &pitch, area.width() / area.height());
    let perspective = AreaPerspective { field_of_view: FIELD_OF_VIEW, near_m: NEAR_M, area, window };
    commands.spawn((
        ChildOf(root.0),
        Camera3d::default(),
        PrimaryEguiContext,
        Projection::custom(perspective),
        // The one that needs no look-up table and keeps colours.
        Tonemapping::KhronosPbrNeutral,
        haze::haze(view.eye(), &pitch, 0.0, haze::HIDES),
        ViewerCamera { current: view, wanted: view, mode: CameraMode::Pitch(Overview::Broadcast) },
        view.transform(),
    ));
}

/// The size of the window, logical pixels.
fn size_of(window: Query<&Window>) -> Vec2 {
    window.iter().next().map_or(Vec2::new(1280.0, 720.0), Window::size)
}

fn use_mouse(
    buttons: Res<ButtonInput<MouseButton>>,
    motion: Res<AccumulatedMouseMotion>,
    scroll: Res<AccumulatedMouseScroll>,
    window: Query<&Window>,
    free: Res<FreeArea>,
    mut camera: Single<&mut ViewerCamera>,
    mut again: ResMut<FollowsAgain>,
) {
    let height = free.within(size_of(window)).height();
    let mode = camera.mode;
    let mut wanted = camera.wanted;
    if buttons.pressed(MouseButton::Middle) || (buttons.pressed(MouseButton::Left) && mode == CameraMode::Fly) {
        wanted = wanted.looked(motion.delta);
    } else if buttons.pressed(MouseButton::Left) {
        wanted = wanted.turned(motion.delta);
    } else if buttons.pressed(MouseButton::Right) {
        wanted = match mode {
            CameraMode::Fly => wanted.drifted(motion.delta, height),
            _ => wanted.shifted(motion.delta, height),
        };
    }
    let notches = match scroll.unit {
        MouseScrollUnit::Line => scroll.delta.y,
        MouseScrollUnit::Pixel => scroll.delta.y / PIXELS_PER_NOTCH,
    };
    if notches != 0.0 {
        wanted = if mode == CameraMode::Fly { wanted.flown(notches) } else { wanted.zoomed(notches) };
    }
    if wanted == camera.wanted {
        return;
    }
    *again = FollowsAgain::default();
    // Moving the camera away from what it follows ends following.
    if matches!(mode, CameraMode::Pitch(_) | CameraMode::Play)
        || (wanted.focus != camera.wanted.focus && mode != CameraMode::Fly)
    {
        camera.mode = CameraMode::Orbit;
    }
    camera.wanted = wanted;
}

/// Follows play, the ball or the robot.
fn follow(
    time: Res<Time<Real>>,
    (pitch, free, window): (Res<Pitch>, Res<FreeArea>, Query<&Window>),
    selection: Res<Selection>,
    roster: Res<Roster>,
    balls: Query<&Transform, (With<Ball>, Without<ViewerCamera>)>,
    robots: Query<(&Transform, &Penalty, &Body), (With<RobotId>, Without<ViewerCamera>)>,
    mut camera: Single<&mut ViewerCamera>,
) {
    let robot = selection.0.and_then(|id| robots.get(roster.get(id)?).ok());
    let robot = robot.filter(|(_, penalty, _)| !penalty.is_off_pitch());
    let robot = robot.map(|(transform, _, body)| (pose_of(transform), body.height_m));
    match camera.mode {
        CameraMode::Ball => {
            if let Some(ball) = balls.iter().next() {
                camera.wanted.focus = ball.translation;
            }
        }
        CameraMode::Play => {
            if let Some(ball) = balls.iter().next() {
                let play = Viewpoint::of_play(ball.translation.truncate(), &pitch, free.aspect(size_of(window)));
                let share = 1.0 - ops::exp(-PLAY_EASING_PER_S * time.delta_secs());
                camera.wanted = camera.wanted.eased(play, share);
            }
        }
        CameraMode::Robot { heading } => {
            if let Some((robot, height_m)) = robot {
                camera.wanted.focus = Viewpoint::behind(robot).for_height(height_m).focus;
                camera.wanted.azimuth += wrap_angle(robot.heading - heading);
                camera.mode = CameraMode::Robot { heading: robot.heading };
            }
        }
        CameraMode::Pitch(_) | CameraMode::Orbit | CameraMode::Fly | CameraMode::RobotCamera(_) => {}
    }
}

/// Draws the match when the robots sensed while it is seen through a robot's camera.
fn choose_instant(camera: Single<&ViewerCamera>, mut when_sensed: ResMut<DrawnWhenSensed>) {
    when_sensed.set_if_neq(DrawnWhenSensed(matches!(camera.mode, CameraMode::RobotCamera(_))));
}

/// The head of a robot when it sensed in a cycle, at its start: a head may turn by 10° in a cycle. Returns `None` if the cycle before is
/// not recorded.
fn head_when_sensed(history: &mut History, robot: RobotId, cycle: u64) -> Option<HeadAngles> {
    let before = cycle.checked_sub(1)?;
    let record = history.record(before).ok()?.filter(|record| record.cycle == before)?;
    Some(record.robot(robot)?.head)
}

/// Returns the camera with this name. If the robot does not have it: its last camera for the NAO's lower one, else its first.
pub fn mount_of(settings: &CameraSettings, name: CameraName) -> Option<&CameraMount> {
    let cameras = settings.mounts.as_slice();
    let other = if name == CameraName::BOTTOM { cameras.last() } else { cameras.first() };
    settings.mounts.get(name).or(other)
}

fn move_camera(
    time: Res<Time<Real>>,
    window: Query<&Window>,
    selection: Res<Selection>,
    roster: Res<Roster>,
    robots: Query<(&Transform, &HeadAngles, &Posture, &Body, &CameraSettings, &Penalty), Without<ViewerCamera>>,
    (free, clock): (Res<FreeArea>, Res<CycleClock>),
    mut history: ResMut<History>,
    mut sensed: Local<Option<((RobotId, u64), Option<HeadAngles>)>>,
    mut eased: Local<Option<Rect>>,
    camera: Single<(&mut ViewerCamera, &mut Transform, &mut Projection)>,
) {
    let (mut camera, mut transform, mut projection) = camera.into_inner();
    let window = size_of(window);
    let wanted = free.in_sight(window);
    let share = 1.0 - ops::exp(-EASING_PER_S * time.delta_secs());
    let mut area = eased.map_or(wanted, |before| between_areas(before, wanted, share));
    let mut field_of_view = FIELD_OF_VIEW;
    if let CameraMode::RobotCamera(side) = camera.mode {
        let robot = selection.0.and_then(|id| robots.get(roster.get(id)?).ok());
        let mount = robot.and_then(|(.., settings, _)| mount_of(settings, side));
        let (Some((place, head, posture, body, settings, penalty)), Some(mount)) = (robot, mount) else {
            camera.mode = CameraMode::Orbit;
            return;
        };
        if let Some(id) = selection.0.filter(|id| sensed.is_none_or(|(of, _)| of != (*id, clock.cycle))) {
            *sensed = Some(((id, clock.cycle), head_when_sensed(&mut history, id, clock.cycle)));
        }
        let head = sensed.and_then(|(_, head)| head).unwrap_or(*head);
        // The camera of a robot that is off the pitch stays as it was.
        if !penalty.is_off_pitch() {
            let view = CameraView::new(settings.intrinsics(mount), mount, body.neck_m, head);
            *transform = robot_view::transform(&view, world_from_body(pose_of(place), *posture, body));
        }
        // The area is not eased, so that detections are drawn at the right places of the image.
        area = wanted;
        field_of_view = robot_view::field_of_view(settings.intrinsics(mount), area.width() / area.height());
    } else {
        // In the first frame the camera starts at the wanted viewpoint.
        let share = if eased.is_some() { share } else { 1.0 };
        camera.current = camera.current.eased(camera.wanted, share);
        *transform = camera.current.transform();
    }
    *eased = free.is_known().then_some(area);
    let perspective = AreaPerspective { field_of_view, near_m: NEAR_M, area, window };
    let now = match &*projection {
        Projection::Custom(custom) => custom.get::<AreaPerspective>().copied(),
        _ => None,
    };
    if now != Some(perspective) {
        *projection = Projection::custom(perspective);
    }
}

/// Interpolates between two areas. Returns `to` when they are almost the same.
fn between_areas(from: Rect, to: Rect, share: f32) -> Rect {
    let between = Rect { min: from.min.lerp(to.min, share), max: from.max.lerp(to.max, share) };
    let is_there = between.min.abs_diff_eq(to.min, 0.5) && between.max.abs_diff_eq(to.max, 0.5);
    if is_there { to } else { between }
}

/// Hides the body of the robot through whose camera the match is seen, and all robots while only one robot's world is
/// shown.
fn hide_own_body(
    camera: Single<&ViewerCamera>,
    world: Option<Res<RobotsWorld>>,
    selection: Res<Selection>,
    robots: Query<(&RobotId, &RobotLimbs)>,
    mut limbs: Query<&mut Visibility>,
) {
    for (id, model) in &robots {
        let is_own = matches!(camera.mode, CameraMode::RobotCamera(_)) && selection.0 == Some(*id);
        let hidden = is_own || world.as_ref().is_some_and(|world| world.0);
        let wanted = if hidden { Visibility::Hidden } else { Visibility::Inherited };
        for limb in model.limbs {
            if let Ok(mut visibility) = limbs.get_mut(limb) {
                visibility.set_if_neq(wanted);
            }
        }
    }
}

impl ViewerCamera {
    /// Returns the robot and camera through which the match is seen, in the mode [`CameraMode::RobotCamera`].
    pub fn robot_camera(&self, selection: &Selection) -> Option<(RobotId, CameraName)> {
        match self.mode {
            CameraMode::RobotCamera(side) => selection.0.map(|id| (id, side)),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::geometry::Pose;
    use naoisis_core::team::Team;
    use naoisis_sim::interface::cycle_record::{CycleRecord, RobotRecord};

    #[test]
    fn a_camera_looks_where_the_head_was_when_the_robot_sensed() {
        let robot = RobotId::new(Team::Blue, 1);
        let mut history = History::default();
        for cycle in 3..6 {
            let head = HeadAngles { yaw: 0.1 * cycle as f32, pitch: 0.0 };
            let robots = vec![RobotRecord { head, ..RobotRecord::new(robot) }];
            history.push(&CycleRecord { cycle, time_s: cycle as f64 / 30.0, robots, ..default() }).unwrap();
        }
        let yaws = [3, 4, 6].map(|cycle| head_when_sensed(&mut history, robot, cycle).map(|head| head.yaw));
        assert_eq!(yaws, [None, Some(0.1 * 3.0), Some(0.1 * 5.0)]);
    }

    #[test]
    fn only_the_eyes_of_a_selected_robot_are_looked_through() {
        let view = Viewpoint::behind(Pose::default());
        let camera = |mode| ViewerCamera { current: view, wanted: view, mode };
        let selection = Selection(Some(RobotId::new(Team::Pink, 2)));
        let eyes = camera(CameraMode::RobotCamera(CameraName::BOTTOM)).robot_camera(&selection);
        assert_eq!(eyes.map(|(_, side)| side), Some(CameraName::BOTTOM));
        assert_eq!(camera(CameraMode::Ball).robot_camera(&selection), None);
    }
}
