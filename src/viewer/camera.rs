//! Where the match is watched from: around a point of the pitch, from a direction, at a distance.

use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::input::mouse::{AccumulatedMouseMotion, AccumulatedMouseScroll, MouseScrollUnit};
use bevy::math::ops;
use bevy::pbr::{DistanceFog, FogFalloff};
use bevy::prelude::*;
use bevy_egui::input::egui_wants_any_pointer_input;
use bevy_egui::{EguiGlobalSettings, PrimaryEguiContext};
use core::f32::consts::FRAC_PI_2;

use super::palette;
use super::stage::PitchRoot;
use crate::ball::Ball;
use crate::pitch::Pitch;

/// Vertical angle of view, radians.
const FIELD_OF_VIEW: f32 = 0.5;
/// How fast the camera goes where it should, 1/s.
const EASING_PER_S: f32 = 8.0;
/// Turn for a drag of one pixel, radians.
const TURN_PER_PIXEL: f32 = 0.005;
/// Change of the logarithm of the distance for one notch of the wheel.
const ZOOM_PER_NOTCH: f32 = 0.12;
/// Pixels of a touch pad that are one notch of a wheel.
const PIXELS_PER_NOTCH: f32 = 40.0;
/// From straight above there is no up; it is never quite straight, radians.
const STEEPEST: f32 = FRAC_PI_2 - 0.002;
/// The camera stays above the ground, radians.
const FLATTEST: f32 = 0.03;
/// Distances that can be chosen, m.
const DISTANCES: [f32; 2] = [0.4, 40.0];

/// The camera of the window.
pub struct ViewerCameraPlugin;

impl Plugin for ViewerCameraPlugin {
    fn build(&self, app: &mut App) {
        app.add_message::<ViewPreset>()
            // Cameras that robots look through must not get the panels.
            .insert_resource(EguiGlobalSettings { auto_create_primary_context: false, ..default() })
            .add_systems(Startup, spawn_camera)
            .add_systems(
                Update,
                (choose_view, drag_and_zoom.run_if(not(egui_wants_any_pointer_input)), follow_ball, move_camera)
                    .chain()
                    .in_set(CameraSystems),
            );
    }
}

/// The systems that move the camera.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct CameraSystems;

/// The views to choose from.
#[derive(Message, Clone, Copy, PartialEq, Eq, Debug)]
pub enum ViewPreset {
    /// The whole pitch from the side, as on television.
    Broadcast,
    /// The whole pitch from above.
    TopDown,
    /// Close to the ball, wherever it goes.
    FollowBall,
}

/// A place to look from.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Viewpoint {
    /// The point looked at, m, pitch frame.
    pub focus: Vec3,
    /// Direction in which one stands from there: 0 at -y, a quarter turn at +x, radians.
    pub azimuth: f32,
    /// Angle above the ground, radians.
    pub elevation: f32,
    /// Distance, m.
    pub distance: f32,
}

impl Viewpoint {
    /// The camera's place in the pitch frame.
    pub fn transform(&self) -> Transform {
        let (sin_azimuth, cos_azimuth) = ops::sin_cos(self.azimuth);
        let (sin_elevation, cos_elevation) = ops::sin_cos(self.elevation);
        let direction = Vec3::new(sin_azimuth * cos_elevation, -cos_azimuth * cos_elevation, sin_elevation);
        Transform::from_translation(self.focus + self.distance * direction).looking_at(self.focus, Vec3::Z)
    }

    /// A view of the whole pitch in a window `aspect` times as wide as high.
    fn of_pitch(preset: ViewPreset, pitch: &Pitch, aspect: f32) -> Self {
        let per_distance = ops::tan(FIELD_OF_VIEW / 2.0);
        let carpet = pitch.carpet_half_extents();
        match preset {
            ViewPreset::Broadcast => {
                let elevation = 0.6;
                let half_length = pitch.half_length() + 0.5 * (pitch.border_m + pitch.goal.depth_m);
                // The side line in front is nearer than the middle, and what is nearer looks longer.
                let distance = half_length / (per_distance * aspect) + pitch.half_width() * ops::cos(elevation);
                Self { focus: Vec3::new(0.0, -0.1, 0.0), azimuth: 0.0, elevation, distance }
            }
            ViewPreset::TopDown => {
                let distance = (carpet.x / (per_distance * aspect)).max(1.25 * carpet.y / per_distance);
                Self { focus: Vec3::ZERO, azimuth: 0.0, elevation: STEEPEST, distance }
            }
            ViewPreset::FollowBall => Self { focus: Vec3::ZERO, azimuth: 0.0, elevation: 0.4, distance: 3.2 },
        }
    }

    /// A place a share of the way to another.
    fn eased(self, to: Viewpoint, share: f32) -> Viewpoint {
        Viewpoint {
            focus: self.focus.lerp(to.focus, share),
            azimuth: self.azimuth.lerp(to.azimuth, share),
            elevation: self.elevation.lerp(to.elevation, share),
            distance: self.distance.lerp(to.distance, share),
        }
    }

    /// Turns by a drag of this many pixels.
    fn turned(mut self, pixels: Vec2) -> Self {
        self.azimuth -= pixels.x * TURN_PER_PIXEL;
        self.elevation = (self.elevation + pixels.y * TURN_PER_PIXEL).clamp(FLATTEST, STEEPEST);
        self
    }

    /// Moves along the ground by a drag of this many pixels in a window of this height.
    fn shifted(mut self, pixels: Vec2, window_height: f32) -> Self {
        let metres = pixels * 2.0 * self.distance * ops::tan(FIELD_OF_VIEW / 2.0) / window_height;
        let (sin, cos) = ops::sin_cos(self.azimuth);
        let right = Vec2::new(cos, sin);
        let moved = metres.y * right.perp() - metres.x * right;
        self.focus += moved.extend(0.0);
        self
    }

    /// Goes closer by this many notches of the wheel.
    fn zoomed(mut self, notches: f32) -> Self {
        self.distance = (self.distance * ops::exp(-ZOOM_PER_NOTCH * notches)).clamp(DISTANCES[0], DISTANCES[1]);
        self
    }
}

/// The camera of the window: where it is, and where it goes.
#[derive(Component, Clone, Copy, PartialEq, Debug)]
pub struct ViewerCamera {
    /// Where it is.
    pub current: Viewpoint,
    /// Where it goes.
    pub wanted: Viewpoint,
    /// Whether it goes along with the ball.
    pub follows_ball: bool,
}

fn spawn_camera(mut commands: Commands, root: Res<PitchRoot>, pitch: Res<Pitch>, window: Query<&Window>) {
    let aspect = window.iter().next().map_or(16.0 / 9.0, |window| aspect_of(window.size()));
    let view = Viewpoint::of_pitch(ViewPreset::Broadcast, &pitch, aspect);
    commands.spawn((
        ChildOf(root.0),
        Camera3d::default(),
        PrimaryEguiContext,
        Projection::Perspective(PerspectiveProjection { fov: FIELD_OF_VIEW, near: 0.05, ..default() }),
        // The one that needs no look-up table and keeps colours.
        Tonemapping::KhronosPbrNeutral,
        DistanceFog { color: palette::SKY, falloff: FogFalloff::Linear { start: 12.0, end: 45.0 }, ..default() },
        ViewerCamera { current: view, wanted: view, follows_ball: false },
        view.transform(),
    ));
}

fn aspect_of(size: Vec2) -> f32 {
    (size.x / size.y.max(1.0)).clamp(0.2, 5.0)
}

fn choose_view(
    mut presets: MessageReader<ViewPreset>,
    pitch: Res<Pitch>,
    window: Query<&Window>,
    mut camera: Single<&mut ViewerCamera>,
) {
    let aspect = window.iter().next().map_or(16.0 / 9.0, |window| aspect_of(window.size()));
    for preset in presets.read() {
        let view = Viewpoint::of_pitch(*preset, &pitch, aspect);
        // The short way round.
        camera.current.azimuth = crate::geometry::wrap_angle(camera.current.azimuth);
        camera.wanted = view;
        camera.follows_ball = *preset == ViewPreset::FollowBall;
    }
}

fn drag_and_zoom(
    buttons: Res<ButtonInput<MouseButton>>,
    motion: Res<AccumulatedMouseMotion>,
    scroll: Res<AccumulatedMouseScroll>,
    window: Query<&Window>,
    mut camera: Single<&mut ViewerCamera>,
) {
    let mut wanted = camera.wanted;
    if buttons.pressed(MouseButton::Left) {
        wanted = wanted.turned(motion.delta);
    } else if buttons.any_pressed([MouseButton::Right, MouseButton::Middle]) {
        let height = window.iter().next().map_or(1.0, |window| window.height().max(1.0));
        wanted = wanted.shifted(motion.delta, height);
    }
    let notches = match scroll.unit {
        MouseScrollUnit::Line => scroll.delta.y,
        MouseScrollUnit::Pixel => scroll.delta.y / PIXELS_PER_NOTCH,
    };
    wanted = wanted.zoomed(notches);
    if wanted.focus != camera.wanted.focus {
        camera.follows_ball = false;
    }
    if wanted != camera.wanted {
        camera.wanted = wanted;
    }
}

fn follow_ball(balls: Query<&Transform, (With<Ball>, Without<ViewerCamera>)>, mut camera: Single<&mut ViewerCamera>) {
    if let (true, Some(ball)) = (camera.follows_ball, balls.iter().next()) {
        camera.wanted.focus = ball.translation;
    }
}

fn move_camera(time: Res<Time<Real>>, camera: Single<(&mut ViewerCamera, &mut Transform)>) {
    let (mut camera, mut transform) = camera.into_inner();
    let share = 1.0 - ops::exp(-EASING_PER_S * time.delta_secs());
    camera.current = camera.current.eased(camera.wanted, share);
    *transform = camera.current.transform();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_broadcast_has_the_yellow_goal_on_the_right() {
        let view = Viewpoint::of_pitch(ViewPreset::Broadcast, &Pitch::default(), 1.6);
        let transform = view.transform();
        assert!(transform.translation.y < -3.0 && transform.translation.z > 2.0);
        assert!(transform.right().abs_diff_eq(Vec3::X, 1e-5));
    }

    #[test]
    fn from_above_up_is_plus_y() {
        let view = Viewpoint::of_pitch(ViewPreset::TopDown, &Pitch::default(), 1.6);
        assert!(view.transform().up().abs_diff_eq(Vec3::Y, 0.01));
    }

    #[test]
    fn the_whole_pitch_is_in_view() {
        let pitch = Pitch::default();
        for (preset, aspect) in [ViewPreset::Broadcast, ViewPreset::TopDown]
            .into_iter()
            .flat_map(|preset| [1.3, 1.6, 16.0 / 9.0, 2.2].map(|aspect| (preset, aspect)))
        {
            let camera_from_pitch = Viewpoint::of_pitch(preset, &pitch, aspect).transform().to_matrix().inverse();
            for corner in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
                let point = Vec3::new(corner.0 * pitch.half_length(), corner.1 * pitch.half_width(), 0.0);
                let seen = camera_from_pitch.transform_point3(point);
                let half_height = -seen.z * ops::tan(FIELD_OF_VIEW / 2.0);
                assert!(seen.x.abs() < aspect * half_height, "{preset:?} {aspect} {seen}");
                assert!(seen.y.abs() < half_height, "{preset:?} {aspect} {seen}");
            }
        }
    }

    #[test]
    fn the_ground_goes_along_with_the_mouse() {
        let view = Viewpoint::of_pitch(ViewPreset::TopDown, &Pitch::default(), 1.6);
        // A drag to the right by half the window's height: what is looked at is then as far to the left.
        let shifted = view.shifted(Vec2::new(50.0, 0.0), 100.0);
        let expected = -view.distance * ops::tan(FIELD_OF_VIEW / 2.0);
        assert!((shifted.focus.x - expected).abs() < 1e-4);
        assert!(view.shifted(Vec2::new(0.0, 50.0), 100.0).focus.y > 0.0);
    }

    #[test]
    fn the_camera_stays_above_the_ground() {
        let view = Viewpoint::of_pitch(ViewPreset::Broadcast, &Pitch::default(), 1.6);
        assert_eq!(view.turned(Vec2::new(0.0, -1e4)).elevation, FLATTEST);
        assert_eq!(view.turned(Vec2::new(0.0, 1e4)).elevation, STEEPEST);
        assert_eq!(view.zoomed(1e3).distance, DISTANCES[0]);
    }
}
