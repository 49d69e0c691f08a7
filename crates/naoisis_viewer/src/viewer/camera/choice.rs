//! What the camera looks at: a view that was chosen, a place, the whole pitch of another match.

use bevy::prelude::*;

use super::viewpoint::{Overview, Viewpoint};
use super::{CameraMode, ViewerCamera, size_of};
use crate::viewer::commands::ViewPreset;
use crate::viewer::layout::FreeArea;
use crate::viewer::pitch_frame::pose_of;
use crate::viewer::shared::{Playback, SecondPitch, Selection};
use naoisis_core::ball::Ball;
use naoisis_core::cycle::CycleClock;
use naoisis_core::geometry::wrap_angle;
use naoisis_core::pitch::Pitch;
use naoisis_core::robot::Roster;
use naoisis_core::robot::body::Body;
use naoisis_core::team::RobotId;
use naoisis_sim::scenario::{Scenario, TeamsSpec};

/// Asks the camera to look at a position on the pitch, m.
#[derive(Message, Clone, Copy, PartialEq, Debug)]
pub struct LookAt {
    /// The position, m, pitch frame.
    pub place: Vec2,
    /// The distance around it that must be in view, m.
    pub reach_m: f32,
}

/// Moves the camera back when a panel opens, so that the same things stay in view.
pub(super) fn make_room(
    free: Res<FreeArea>,
    (pitch, second): (Res<Pitch>, Res<SecondPitch>),
    window: Query<&Window>,
    mut camera: Single<&mut ViewerCamera>,
    mut before: Local<Option<f32>>,
) {
    let now = free.aspect(size_of(window));
    if *before == Some(now) && !pitch.is_changed() && !second.is_changed() {
        return;
    }
    if second.is_changed() && second.0.is_some() && !matches!(camera.mode, CameraMode::Pitch(_)) {
        camera.mode = CameraMode::Pitch(Overview::Broadcast);
    }
    let factor = before.map_or(1.0, |before| room_for_views(before) / room_for_views(now));
    *before = Some(now);
    match camera.mode {
        CameraMode::Pitch(overview) => camera.wanted = whole(overview, &pitch, *second, now),
        CameraMode::Orbit => camera.wanted = camera.wanted.farther(factor),
        _ => {}
    }
}

/// A view of the whole pitch, and of the second one if there is one.
fn whole(overview: Overview, pitch: &Pitch, second: SecondPitch, aspect: f32) -> Viewpoint {
    Viewpoint::of_pitches(overview, pitch, second.0.unwrap_or_default(), aspect)
}

/// Returns a view that was chosen in an area with the aspect `then` for one with the aspect `now`: farther away in a narrower one.
pub fn in_another_area(view: Viewpoint, then: f32, now: f32) -> Viewpoint {
    view.farther(room_for_views(then) / room_for_views(now))
}

/// The factor of the distance for an area of this aspect: larger for narrow areas.
fn room_for_views(aspect: f32) -> f32 {
    /// The aspect of typical views, about that of a pitch.
    const OF_VIEWS: f32 = 1.5;
    (aspect / OF_VIEWS).min(1.0)
}

/// Shows the whole pitch of another match after a close-up of the match before.
pub(super) fn show_other_match(
    scenario: Res<Scenario>,
    clock: Res<CycleClock>,
    camera: Single<&ViewerCamera>,
    mut last: Local<Option<(String, Option<TeamsSpec>)>>,
    mut presets: MessageWriter<ViewPreset>,
) {
    let now = (scenario.name.clone(), scenario.teams.clone());
    let is_other = last.as_ref().is_some_and(|last| *last != now);
    *last = Some(now);
    if is_other && clock.cycle <= 1 && camera.mode == CameraMode::Orbit {
        presets.write(ViewPreset::Broadcast);
    }
}

pub(super) fn choose_view(
    mut presets: MessageReader<ViewPreset>,
    (pitch, second): (Res<Pitch>, Res<SecondPitch>),
    window: Query<&Window>,
    roster: Res<Roster>,
    mut selection: ResMut<Selection>,
    free: Res<FreeArea>,
    balls: Query<&Transform, (With<Ball>, Without<ViewerCamera>)>,
    robots: Query<(&Transform, &Body), (With<RobotId>, Without<ViewerCamera>)>,
    mut camera: Single<&mut ViewerCamera>,
) {
    let aspect = free.aspect(size_of(window));
    let whole = |overview| (whole(overview, &pitch, *second, aspect), CameraMode::Pitch(overview));
    for preset in presets.read() {
        if matches!(preset, ViewPreset::FollowRobot | ViewPreset::RobotCamera(_)) && selection.0.is_none() {
            selection.0 = roster.iter().next().map(|(id, _)| id);
        }
        let robot = selection.0.and_then(|id| robots.get(roster.get(id)?).ok());
        let robot = robot.map(|(transform, body)| (pose_of(transform), body.height_m));
        let tallest_m = robots.iter().map(|(_, body)| body.height_m).fold(0.0, f32::max);
        let wanted = camera.wanted;
        let (wanted, mode) = match preset {
            ViewPreset::Broadcast => whole(Overview::Broadcast),
            ViewPreset::TopDown => whole(Overview::TopDown),
            ViewPreset::FollowPlay => (wanted, CameraMode::Play),
            ViewPreset::FollowBall => {
                let ball = balls.iter().next().map(|ball| ball.translation.truncate());
                (Viewpoint::of_ball(ball.unwrap_or_default()).for_height(tallest_m), CameraMode::Ball)
            }
            ViewPreset::FollowRobot => match robot {
                Some((robot, height_m)) => {
                    let view = Viewpoint::behind(robot).for_height(height_m);
                    (view, CameraMode::Robot { heading: robot.heading })
                }
                None => continue,
            },
            ViewPreset::RobotCamera(side) => (wanted, CameraMode::RobotCamera(*side)),
            ViewPreset::Fly => (wanted, CameraMode::Fly),
        };
        // The camera turns the short way round.
        let turn = wrap_angle(wanted.azimuth - camera.current.azimuth);
        camera.current.azimuth = wanted.azimuth - turn;
        camera.wanted = wanted;
        camera.mode = mode;
    }
}

/// The view before the camera looked at a place.
#[derive(Resource, Default)]
pub(super) struct FollowsAgain {
    /// Whether it followed play before it looked at a place.
    play: bool,
    /// How it showed the whole pitch before it looked at a place.
    pitch: Option<Overview>,
}

pub(super) fn look_at_places(
    mut places: MessageReader<LookAt>,
    mut camera: Single<&mut ViewerCamera>,
    mut again: ResMut<FollowsAgain>,
) {
    if let Some(LookAt { place, reach_m }) = places.read().last() {
        match camera.mode {
            CameraMode::Play => again.play = true,
            CameraMode::Pitch(overview) => again.pitch = Some(overview),
            _ => {}
        }
        camera.wanted = camera.wanted.at(*place, *reach_m);
        camera.mode = CameraMode::Orbit;
    }
}

/// Follows play again once it goes on, and shows the whole pitch of another match again, unless another view was chosen.
pub(super) fn follow_again(
    playback: Option<Res<Playback>>,
    (scenario, clock): (Option<Res<Scenario>>, Option<Res<CycleClock>>),
    mut presets: MessageReader<ViewPreset>,
    mut camera: Single<&mut ViewerCamera>,
    mut again: ResMut<FollowsAgain>,
) {
    let is_new = scenario.is_some_and(|scenario| scenario.is_changed()) && clock.is_some_and(|clock| clock.cycle <= 1);
    if presets.read().count() > 0 || camera.mode != CameraMode::Orbit {
        *again = FollowsAgain::default();
    } else if again.play && playback.is_some_and(|playback| !playback.paused) {
        *again = FollowsAgain::default();
        camera.mode = CameraMode::Play;
    } else if let Some(overview) = again.pitch.filter(|_| is_new) {
        *again = FollowsAgain::default();
        camera.mode = CameraMode::Pitch(overview);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::geometry::Pose;

    #[test]
    fn a_camera_that_follows_play_looks_at_a_place_until_play_goes_on() {
        let mut app = App::new();
        app.add_message::<ViewPreset>()
            .add_message::<LookAt>()
            .init_resource::<FollowsAgain>()
            .insert_resource(Playback { paused: true, ..default() })
            .add_systems(Update, (look_at_places, follow_again).chain());
        let view = Viewpoint::behind(Pose::default());
        let camera = app.world_mut().spawn(ViewerCamera { current: view, wanted: view, mode: CameraMode::Play }).id();
        let mode = |app: &mut App, is_paused: bool| {
            app.world_mut().resource_mut::<Playback>().paused = is_paused;
            app.update();
            app.world().get::<ViewerCamera>(camera).unwrap().mode
        };
        let look = |app: &mut App| app.world_mut().write_message(LookAt { place: Vec2::ONE, reach_m: 0.0 });
        look(&mut app);
        assert_eq!([mode(&mut app, true), mode(&mut app, false)], [CameraMode::Orbit, CameraMode::Play]);
        // Another view that was chosen meanwhile stays.
        look(&mut app);
        assert_eq!(mode(&mut app, true), CameraMode::Orbit);
        app.world_mut().write_message(ViewPreset::Fly);
        app.world_mut().get_mut::<ViewerCamera>(camera).unwrap().mode = CameraMode::Orbit;
        assert_eq!([mode(&mut app, true), mode(&mut app, false)], [CameraMode::Orbit; 2]);
    }
}
