//! Chooses the moments at which images are taken: in matches that are played, and in situations that are drawn at random.

use bevy::math::{Vec2, ops};
use bevy::prelude::*;
use core::f32::consts::TAU;

use super::ranges::SceneRanges;
use naoisis_core::camera_model::CameraName;
use naoisis_core::cycle::CycleClock;
use naoisis_core::geometry::{Pose, to_radians, wrap_angle};
use naoisis_core::random::RandomStream;
use naoisis_core::robot::Roster;
use naoisis_core::robot::body::Body;
use naoisis_core::robot::head::{HeadAngles, HeadLimits};
use naoisis_core::robot::posture::{LyingOn, Posture};
use naoisis_core::team::RobotId;
use naoisis_sensing::appearance::posing::STEP_FREQUENCY;
use naoisis_sensing::appearance::scene::{Scene, SceneBall, SceneRobot};
use naoisis_sensing::appearance::stride::Stride;
use naoisis_sensing::sensing::camera::CameraSettings;
use naoisis_sim::scenario::{MODELS, Scenario};
use naoisis_sim::simulation::{MatchApp, is_over};

/// A moment at which an image is taken.
#[derive(Clone, PartialEq, Debug)]
pub struct Moment {
    /// The scene.
    pub scene: Scene,
    /// The robot with the camera.
    pub robot: RobotId,
    /// The camera.
    pub camera: CameraName,
    /// The settings of the robot's cameras.
    pub settings: CameraSettings,
    /// How fast the camera turns: yaw and pitch, rad/s.
    pub turn: Vec2,
    /// The cycle and the time of the match, s. `None` for a drawn situation.
    pub time: Option<(u64, f64)>,
    /// The models of the robots of the scene.
    pub models: Vec<(RobotId, String)>,
}

/// A robot of a scenario.
#[derive(Clone, PartialEq, Debug)]
pub struct CastMember {
    id: RobotId,
    model: String,
    body: Body,
    head: HeadLimits,
    /// The robot's cameras. `None` if it has none.
    cameras: Option<CameraSettings>,
}

/// The robots of a scenario, and the bodies of other models.
#[derive(Clone, PartialEq, Debug)]
pub struct Cast {
    members: Vec<CastMember>,
    others: Vec<(String, Body)>,
    ball_radius_m: f32,
}

impl Cast {
    /// Returns the robots of the match in `world`, which was started from `scenario`.
    pub fn of(world: &World, scenario: &Scenario) -> Self {
        let member = |(id, entity): (RobotId, Entity)| {
            let model = scenario.robot(id).model.unwrap_or_else(|| scenario.model.clone());
            let cameras = world.get::<CameraSettings>(entity).copied();
            let head = world.get::<HeadLimits>(entity).copied().unwrap_or_default();
            let head = head.reached_from(world.get::<HeadAngles>(entity).copied().unwrap_or_default());
            Some(CastMember {
                id,
                model,
                body: *world.get::<Body>(entity)?,
                head,
                cameras: cameras.filter(|cameras| cameras.mounts.names().next().is_some()),
            })
        };
        let members = world.resource::<Roster>().iter().filter_map(member).collect();
        let of_model = |name: &str| {
            let scenario =
                Scenario::from_json(&format!(r#"{{ "model": "{name}", "robots": [{{ "number": 1 }}] }}"#)).ok()?;
            let body = scenario.body_of(scenario.robots.first()?);
            // Robots on wheels play in no league with the others.
            body.legs.map(|_| (name.to_owned(), body))
        };
        let others = MODELS.iter().filter_map(|model| of_model(model.name)).collect();
        Self { members, others, ball_radius_m: scenario.ball.unwrap_or_default().radius_m }
    }

    /// Returns whether any robot has a camera.
    pub fn has_cameras(&self) -> bool {
        self.members.iter().any(|member| member.cameras.is_some())
    }

    /// Sets the size of all images, pixels.
    pub fn set_size(&mut self, [width, height]: [u32; 2]) {
        for cameras in self.members.iter_mut().filter_map(|member| member.cameras.as_mut()) {
            let mut mounts = *cameras;
            (mounts.width, mounts.height) = (width, height);
            *cameras = mounts;
        }
    }

    fn member(&self, id: RobotId) -> Option<&CastMember> {
        self.members.iter().find(|member| member.id == id)
    }
}

/// Draws an index below `count`.
fn pick(count: usize, stream: &mut RandomStream) -> usize {
    ((stream.uniform() * count as f32) as usize).min(count.saturating_sub(1))
}

/// Draws one of a robot's cameras.
fn pick_camera(settings: &CameraSettings, stream: &mut RandomStream) -> Option<CameraName> {
    let names: Vec<CameraName> = settings.mounts.names().collect();
    names.get(pick(names.len(), stream)).copied()
}

/// Continues the match in `app` and returns the moments of `count` images. A match that is over starts again.
pub fn played(
    app: &mut App,
    scenario: &Scenario,
    cast: &Cast,
    ranges: &SceneRanges,
    count: usize,
    stream: &mut RandomStream,
) -> Vec<Moment> {
    /// Attempts for each moment to find a robot that stands on the pitch and has a camera.
    const TRIES: usize = 20;

    let period_s = app.world().resource::<CycleClock>().period();
    let mut wait_s = ranges.first_s.draw(stream);
    let mut moments = Vec::with_capacity(count);
    let mut tries = 0;
    while moments.len() < count {
        let cycles = (wait_s / period_s).max(1.0) as usize;
        for _ in 0..cycles {
            if is_over(app.world()) {
                // The match has been started before, so it starts again.
                let _ = app.start_match(scenario);
            }
            app.run_cycles(1);
        }
        wait_s = ranges.gap_s.draw(stream);
        let mut scenes = [Scene::default(), Scene::default()];
        scenes[0].gather(app.world_mut());
        app.run_cycles(1);
        scenes[1].gather(app.world_mut());
        let [before, scene] = scenes;
        let clock = *app.world().resource::<CycleClock>();
        tries += 1;
        match moment_of(scene, &before, cast, clock, stream) {
            Some(moment) => moments.push(moment),
            None if tries < TRIES * count => {}
            None => break,
        }
    }
    moments
}

/// Returns the moment of `scene`, one cycle after `before`. Returns `None` if no standing robot has a camera.
fn moment_of(
    scene: Scene,
    before: &Scene,
    cast: &Cast,
    clock: CycleClock,
    stream: &mut RandomStream,
) -> Option<Moment> {
    let sees = |robot: &&SceneRobot| robot.is_upright() && cast.member(robot.id).is_some_and(|it| it.cameras.is_some());
    let seeing: Vec<SceneRobot> = scene.robots.iter().filter(sees).copied().collect();
    let robot = *seeing.get(pick(seeing.len(), stream))?;
    let settings = cast.member(robot.id)?.cameras?;
    let camera = pick_camera(&settings, stream)?;
    let direction = |robot: &SceneRobot| Vec2::new(robot.pose.heading + robot.head.yaw, robot.head.pitch);
    let turn = before.robot(robot.id).map_or(Vec2::ZERO, |before| {
        let turned = direction(&robot) - direction(before);
        Vec2::new(wrap_angle(turned.x), turned.y) / clock.period()
    });
    let models = scene.robots.iter().filter_map(|it| Some((it.id, cast.member(it.id)?.model.clone()))).collect();
    let time = Some((clock.cycle, clock.end_time_s()));
    Some(Moment { robot: robot.id, camera, settings, turn, time, models, scene })
}

/// The ranges of the head angles in drawn situations, degrees. The limits of the head also apply.
const HEAD_YAW_DEG: [f32; 2] = [-70.0, 70.0];
const HEAD_PITCH_DEG: [f32; 2] = [-12.0, 30.0];
/// The free space around robots and the ball, m.
const ROOM_M: f32 = 0.03;

/// Draws a situation on the pitch of `empty`, a scene without robots: some robots of the cast, one of which takes the image, and usually a
/// ball.
pub fn drawn(empty: &Scene, cast: &Cast, ranges: &super::ranges::Ranges, stream: &mut RandomStream) -> Option<Moment> {
    let seeing: Vec<&CastMember> = cast.members.iter().filter(|member| member.cameras.is_some()).collect();
    let own = *seeing.get(pick(seeing.len(), stream))?;
    let settings = own.cameras?;
    let camera = pick_camera(&settings, stream)?;
    let pitch = &empty.pitch;
    let (along, across) = (pitch.half_length() + 0.3 * pitch.border_m, pitch.half_width() + 0.3 * pitch.border_m);
    let mut between = |least: f32, most: f32| least + (most - least) * stream.uniform();
    let mut place = || Vec2::new(between(-along, along), between(-across, across));
    let position = place();
    let heading = to_radians(between(-180.0, 180.0));
    let head = own.head.nearest(HeadAngles {
        yaw: to_radians(between(HEAD_YAW_DEG[0], HEAD_YAW_DEG[1])),
        pitch: to_radians(between(HEAD_PITCH_DEG[0], HEAD_PITCH_DEG[1])),
    });
    let mut scene = Scene { robots: Vec::new(), ball: None, ..empty.clone() };
    let mut models = vec![(own.id, own.model.clone())];
    let standing = SceneRobot::standing(own.id, Pose { position, heading }, own.body);
    scene.robots.push(SceneRobot { head, stride: stride(stream), ..standing });
    for member in cast.members.iter().filter(|member| member.id != own.id) {
        if stream.chance(0.25) {
            continue;
        }
        let (model, body) = if stream.chance(ranges.robots.other_model_chance) && !cast.others.is_empty() {
            cast.others[pick(cast.others.len(), stream)].clone()
        } else {
            (member.model.clone(), member.body)
        };
        let reach = body.torso.reach().max(body.base.reach());
        // Half of the robots stand where the camera looks.
        let aimed = stream.chance(0.5);
        let free = (0..30).find_map(|_| {
            let place = if aimed {
                ahead(position, heading + head.yaw, 0.45 * pitch.length_m, stream)
            } else {
                anywhere(along, across, stream)
            };
            let is_on_carpet = place.x.abs() < along && place.y.abs() < across;
            let mut others =
                scene.robots.iter().map(|other| place.distance(other.pose.position) > reach + other.reach + ROOM_M);
            let mut posts =
                scene.posts.iter().map(|post| place.distance(post.position) > reach + post.post.radius + ROOM_M);
            (is_on_carpet && others.all(|is_free| is_free) && posts.all(|is_free| is_free)).then_some(place)
        });
        let Some(place) = free else { continue };
        let heading = wrap_angle(TAU * stream.uniform());
        let yaw = 2.0 * stream.uniform() - 1.0;
        let posture = if stream.chance(ranges.scenes.lying_chance) {
            Posture::fallen(if stream.chance(0.5) { LyingOn::Front } else { LyingOn::Back })
        } else {
            Posture::Upright
        };
        let robot = SceneRobot::standing(member.id, Pose { position: place, heading }, body).in_posture(posture);
        let head = member.head.nearest(HeadAngles { yaw, pitch: 0.0 });
        scene.robots.push(SceneRobot { head, stride: stride(stream), ..robot });
        models.push((member.id, model));
    }
    scene.robots.sort_unstable_by_key(|robot| robot.id);
    if !stream.chance(ranges.ball.missing_chance) {
        let radius = cast.ball_radius_m;
        scene.ball = (0..30).find_map(|_| {
            let place = ahead(position, heading + head.yaw, 0.5 * pitch.length_m, stream);
            let mut others =
                scene.robots.iter().map(|robot| place.distance(robot.pose.position) > robot.reach + radius);
            others.all(|is_free| is_free).then(|| SceneBall::on_ground(place, radius))
        });
    }
    let speed = to_radians(ranges.camera.turn_degps.draw(stream));
    let angle = TAU * stream.uniform();
    let turn = speed * Vec2::new(ops::cos(angle), 0.5 * ops::sin(angle));
    Some(Moment { robot: own.id, camera, settings, turn, time: None, models, scene })
}

/// Draws a place ahead of a camera. Near places are more likely.
fn ahead(position: Vec2, bearing: f32, furthest_m: f32, stream: &mut RandomStream) -> Vec2 {
    let bearing = bearing + to_radians(70.0 * (stream.uniform() - 0.5));
    let share = stream.uniform();
    let distance = 0.25 + (furthest_m - 0.25).max(0.0) * share * share;
    position + distance * Vec2::new(ops::cos(bearing), ops::sin(bearing))
}

fn anywhere(along: f32, across: f32, stream: &mut RandomStream) -> Vec2 {
    Vec2::new(along * (2.0 * stream.uniform() - 1.0), across * (2.0 * stream.uniform() - 1.0))
}

/// Draws the motion of a robot's limbs.
fn stride(stream: &mut RandomStream) -> Stride {
    let time_s = f64::from(stream.uniform() / STEP_FREQUENCY);
    let liveliness = if stream.chance(0.3) { 0.0 } else { 1.0 };
    Stride { time_s, speed: 0.4 * liveliness * (stream.uniform() - 0.3), liveliness, kick: None }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::ranges::Ranges;
    use naoisis_sim::simulation::NaoisisPlugins;

    fn started(name: &str) -> (App, Scenario, Cast) {
        let scenario = Scenario::named(name).unwrap();
        let mut app = App::new();
        app.add_plugins(NaoisisPlugins);
        app.start_match(&scenario).unwrap();
        let cast = Cast::of(app.world(), &scenario);
        (app, scenario, cast)
    }

    #[test]
    fn moments_of_a_match_are_apart_and_a_robot_sees_in_each() {
        let (mut app, scenario, cast) = started("k1_against_nao");
        let ranges = Ranges::read(None).unwrap();
        let moments = played(&mut app, &scenario, &cast, &ranges.scenes, 5, &mut RandomStream::for_match(1, "test"));
        assert_eq!(moments.len(), 5);
        for moment in &moments {
            assert!(moment.scene.robot(moment.robot).unwrap().is_upright());
            assert!(moment.settings.mounts.get(moment.camera).is_some());
            assert_eq!(moment.models.len(), moment.scene.robots.len());
        }
        let times: Vec<f64> = moments.iter().map(|moment| moment.time.unwrap().1).collect();
        assert!(times[0] >= 4.9 && times.windows(2).all(|pair| pair[1] > pair[0] + 0.3), "{times:?}");
    }

    #[test]
    fn drawn_situations_have_room_and_other_models() {
        let (app, _, cast) = started("match3v3");
        let ranges = Ranges::read(None).unwrap();
        let mut stream = RandomStream::for_match(1, "test");
        let empty = Scene::empty(app.world().resource::<naoisis_core::pitch::Pitch>().clone());
        let moments: Vec<Moment> = (0..50).map(|_| drawn(&empty, &cast, &ranges, &mut stream).unwrap()).collect();
        for Moment { scene, robot, .. } in &moments {
            assert!(scene.robot(*robot).unwrap().is_upright());
            for (index, one) in scene.robots.iter().enumerate() {
                for other in &scene.robots[..index] {
                    assert!(one.pose.position.distance(other.pose.position) > one.reach.max(other.reach));
                }
            }
        }
        let with_ball = moments.iter().filter(|moment| moment.scene.ball.is_some()).count();
        assert!((30..50).contains(&with_ball), "{with_ball}");
        let models =
            |name: &str| moments.iter().flat_map(|moment| &moment.models).filter(|(_, model)| model == name).count();
        assert!(models("nao") > 50 && models("booster_t1") > 2);
    }
}
