//! Images of the robots' cameras for the panels, drawn only for cameras that are watched.
//!
//! They are drawn by the software renderer that also draws the images for robots, of the instant of exposure: the robot's
//! vision may be late, so detections lie on the objects of an earlier cycle than the one that is shown. If a robot sees by
//! images of its own, these are shown. Overlays are not part of the rendered scene, so no camera sees them.

use bevy::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, Instant};

use super::timeline::Timeline;
use naoisis_core::camera_model::CameraName;
use naoisis_core::cycle::{Cycle, CycleClock};
use naoisis_core::robot::Roster;
use naoisis_core::robot::body::Body;
use naoisis_core::robot::kick::KickSettings;
use naoisis_core::team::RobotId;
use naoisis_record::record::history::History;
use naoisis_sensing::appearance::gather::MatchScene;
use naoisis_sensing::appearance::scene::{Scene, SceneBall, SceneRobot};
use naoisis_sensing::appearance::stride::Stride;
use naoisis_sensing::appearance::view::View;
use naoisis_sensing::sensing::camera::image::{Image, Layers};
use naoisis_sensing::sensing::camera::software::{Detail, PreparedScene, Renderer};
use naoisis_sensing::sensing::camera::{CameraImages, CameraSettings};
use naoisis_sensing::sensing::jobs::{self, SensingThreads};
use naoisis_sensing::sensing::scene::SensingSystems;
use naoisis_sensing::sensing::vision::Percepts;
use naoisis_sim::interface::cycle_record::{BallRecord, CycleRecord};
use naoisis_sim::scenario::Scenario;

/// Draws images of the robots' cameras for the panels.
pub struct CameraImagesPlugin;

impl Plugin for CameraImagesPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Watched>()
            .init_resource::<SensedScene>()
            .init_resource::<ShownImages>()
            .add_systems(
                Cycle,
                keep_scene
                    .after(SensingSystems::Images)
                    .before(SensingSystems::Vision)
                    .run_if(|watched: Res<Watched>| !watched.cameras.is_empty()),
            )
            .add_systems(First, forget_scene.run_if(resource_exists_and_changed::<Scenario>))
            .add_systems(
                Update,
                (find_past_scenes, draw_watched)
                    .chain()
                    .in_set(CameraImagesSystems)
                    .run_if(|watched: Res<Watched>| !watched.cameras.is_empty()),
            );
    }
}

/// The systems that draw the images. Systems that show an image add its camera to [`Watched`] before them.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct CameraImagesSystems;

/// The cameras that are watched in this frame.
#[derive(Resource, Clone, PartialEq, Eq, Debug, Default)]
pub struct Watched {
    /// Robots and their cameras.
    pub cameras: BTreeSet<(RobotId, CameraName)>,
}

/// The scene of the match when the robots sensed it last, and those of the exposures of robots with late vision.
#[derive(Resource, Default, Debug)]
pub struct SensedScene {
    now: SceneOfCycle,
    /// Earlier scenes by their age, cycles.
    late: BTreeMap<u64, SceneOfCycle>,
}

#[derive(Default, Debug)]
struct SceneOfCycle {
    /// The cycle in which the robots sensed it.
    cycle: Option<u64>,
    scene: Scene,
    /// The strides of robots in recorded cycles, which records do not contain.
    strides: BTreeMap<RobotId, Stride>,
}

/// The images of the cameras that are watched.
#[derive(Resource, Default)]
pub struct ShownImages {
    /// Each with the cycle in which it was taken.
    images: BTreeMap<(RobotId, CameraName), (u64, Image)>,
    prepared: PreparedScene,
    workers: Vec<Renderer>,
    /// The number of matches since the start of the program: images of the same cycle of two matches differ.
    pub matches: u64,
    /// The number of images drawn since the start of the program.
    pub drawn: u64,
    /// The time for drawing the last images.
    pub last_took: Duration,
    /// The number of the last images.
    pub last_count: usize,
}

impl ShownImages {
    /// Returns the image of a watched camera, and the cycle in which it was taken.
    pub fn image(&self, robot: RobotId, side: CameraName) -> Option<(u64, &Image)> {
        self.images.get(&(robot, side)).map(|(cycle, image)| (*cycle, image))
    }
}

fn forget_scene(mut sensed: ResMut<SensedScene>, mut images: ResMut<ShownImages>) {
    *sensed = SensedScene::default();
    images.images.clear();
    images.matches += 1;
}

/// Stores the scene that the robots sense in the current cycle.
fn keep_scene(clock: Res<CycleClock>, scene: Res<Scene>, mut sensed: ResMut<SensedScene>) {
    sensed.now.cycle = Some(clock.cycle);
    sensed.now.scene.clone_from(&scene);
}

/// Finds the scenes of cycles that are not stored: the world at the end of the cycle before, from the records.
fn find_past_scenes(
    clock: Res<CycleClock>,
    (timeline, watched): (Res<Timeline>, Res<Watched>),
    now: MatchScene,
    roster: Res<Roster>,
    (bodies, percepts): (Query<(&Body, &KickSettings)>, Query<&Percepts>),
    mut sensed: ResMut<SensedScene>,
    mut history: ResMut<History>,
) {
    let sensed = &mut *sensed;
    let ages: BTreeSet<u64> = watched
        .cameras
        .iter()
        .filter_map(|(id, _)| percepts.get(roster.get(*id)?).ok())
        .map(|percepts| age_cycles(percepts, &clock))
        .collect();
    sensed.late.retain(|age, _| ages.contains(age));
    let is_ahead = !timeline.is_past() && sensed.now.cycle.is_some_and(|cycle| cycle > clock.cycle);
    for age in ages {
        let cycle = clock.cycle.saturating_sub(age);
        let scene = if age == 0 { &mut sensed.now } else { sensed.late.entry(age).or_default() };
        if scene.cycle == Some(cycle) || (age == 0 && is_ahead) {
            continue;
        }
        if let Ok(Some(record)) = history.record(cycle.saturating_sub(1)) {
            now.gather(&mut scene.scene);
            let robot = |id| {
                let found = roster.get(id).and_then(|robot| bodies.get(robot).ok());
                found.map_or_else(Default::default, |(body, kicks)| (*body, *kicks))
            };
            scene.take_record(cycle, &record, &history, clock.period_s, robot);
        }
    }
}

/// Returns the age of detections, cycles: 0 if they are of the cycle that is shown, or have no time.
pub fn age_cycles(percepts: &Percepts, clock: &CycleClock) -> u64 {
    /// The longest delay of vision, s. Detections without a time, as in old traces, seem to be from the start of the match.
    const LONGEST_S: f64 = 2.0;

    let age_s = clock.start_time_s() - percepts.time_s;
    if age_s > LONGEST_S { 0 } else { (age_s / clock.period_s).round().max(0.0) as u64 }
}

impl SensedScene {
    /// Returns the scene of this age, cycles.
    fn of_age(&self, age: u64) -> Option<&SceneOfCycle> {
        if age == 0 { Some(&self.now) } else { self.late.get(&age) }
    }
}

impl SceneOfCycle {
    /// Copies the robots and the ball of a record into a scene. Everything else stays.
    fn take_record(
        &mut self,
        cycle: u64,
        record: &CycleRecord,
        history: &History,
        period_s: f64,
        known: impl Fn(RobotId) -> (Body, KickSettings),
    ) {
        self.cycle = Some(cycle);
        let on_pitch = record.robots.iter().filter(|robot| robot.penalised.is_none());
        self.scene.robots.clear();
        self.scene.robots.extend(on_pitch.map(|robot| {
            let stride = self.strides.entry(robot.id).or_default();
            let (body, kicks) = known(robot.id);
            stride.kick = history.swing(robot.id, record.cycle, period_s, &kicks);
            stride.follow(robot.pose, robot.velocity, record.time_s);
            let standing = SceneRobot::standing(robot.id, robot.pose, body);
            SceneRobot { head: robot.head, stride: *stride, ..standing.in_posture(robot.posture) }
        }));
        let known = self.scene.ball;
        let scene_ball = |ball: &BallRecord| {
            let radius = known.map_or(ball.position_m.z, |ball| ball.radius);
            let look = known.map(|ball| ball.look).unwrap_or_default();
            SceneBall { position: ball.position_m.truncate(), radius, height: ball.position_m.z - radius, look }
        };
        self.scene.ball = record.ball.as_ref().map(scene_ball);
        self.scene.more_balls.clear();
        self.scene.more_balls.extend(record.more_balls().iter().map(scene_ball));
    }
}

/// An image that is to be drawn.
struct ImageJob {
    camera: (RobotId, CameraName),
    view: View,
    image: Image,
}

fn draw_watched(
    watched: Res<Watched>,
    (timeline, clock): (Res<Timeline>, Res<CycleClock>),
    sensed: Res<SensedScene>,
    threads: Res<SensingThreads>,
    roster: Res<Roster>,
    robots: Query<(&CameraSettings, &CameraImages, &Percepts)>,
    mut shown: ResMut<ShownImages>,
) {
    let shown = &mut *shown;
    shown.images.retain(|camera, _| watched.cameras.contains(camera));
    let mut due: BTreeMap<u64, Vec<ImageJob>> = BTreeMap::new();
    for &(id, side) in &watched.cameras {
        let Some((settings, own, percepts)) = roster.get(id).and_then(|robot| robots.get(robot).ok()) else { continue };
        let age = age_cycles(percepts, &clock);
        let Some(SceneOfCycle { cycle: Some(cycle), scene, .. }) = sensed.of_age(age) else { continue };
        let cycle = *cycle;
        if shown.images.get(&(id, side)).is_some_and(|(taken, _)| *taken == cycle) {
            continue;
        }
        let (_, mut image) = shown.images.remove(&(id, side)).unwrap_or_default();
        // Robots that are off the pitch or lie have no images.
        let Some(body) = scene.robot(id).filter(|robot| robot.is_upright()) else { continue };
        if own.cycle.is_some() && !own.of(side).is_empty() && !timeline.is_past() {
            image.clone_from(own.of(side));
            shown.images.insert((id, side), (cycle, image));
            continue;
        }
        let Some(camera) = settings.view(side, &body.body, body.head) else { continue };
        let view = View::of_robot(&camera, body.world_from_robot(), id);
        due.entry(age).or_default().push(ImageJob { camera: (id, side), view, image });
    }
    if due.is_empty() {
        return;
    }
    let started = Instant::now();
    shown.last_count = 0;
    for (age, mut due) in due {
        let Some(SceneOfCycle { cycle: Some(cycle), scene, .. }) = sensed.of_age(age) else { continue };
        shown.prepared.prepare(scene, Detail::default());
        let prepared = &shown.prepared;
        jobs::for_each(*threads, &mut shown.workers, &mut due, |renderer, job| {
            renderer.draw(prepared, &job.view, Layers::default(), &mut job.image);
        });
        shown.last_count += due.len();
        shown.drawn += due.len() as u64;
        shown.images.extend(due.into_iter().map(|job| (job.camera, (*cycle, job.image))));
    }
    shown.last_took = started.elapsed();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewer::display_settings::DisplaySettings;
    use crate::viewer::drive::DrivePlugin;
    use crate::viewer::event_log::EventLogPlugin;
    use crate::viewer::shared::Selection;
    use bevy::time::TimeUpdateStrategy;
    use naoisis_core::robot::head::HeadAngles;
    use naoisis_core::team::Team;
    use naoisis_sim::simulation::{MatchApp, NaoisisPlugins};

    const BLUE: RobotId = RobotId::new(Team::Blue, 1);

    fn app() -> App {
        let scenario = Scenario::from_json(
            r#"{ "rules": "free", "ball": { "position_m": [0.9, 0.0], "velocity_mps": [0.5, 0.0] },
                 "robots": [{ "number": 1, "pose": [0.0, 0.0, 0.0] }, { "number": 2, "pose": [-1.0, 0.0, 0.0] }] }"#,
        );
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, NaoisisPlugins, CameraImagesPlugin));
        app.init_resource::<Timeline>().init_resource::<History>();
        app.start_match(&scenario.unwrap()).unwrap();
        app.update();
        app
    }

    fn drawn(app: &App) -> u64 {
        app.world().resource::<ShownImages>().drawn
    }

    #[test]
    fn only_cameras_that_someone_looks_at_are_drawn_and_once_a_cycle() {
        let mut app = app();
        for _ in 0..5 {
            app.run_cycles(1);
            app.update();
        }
        assert_eq!(drawn(&app), 0);
        app.world_mut().resource_mut::<Watched>().cameras.insert((BLUE, CameraName::BOTTOM));
        for _ in 0..5 {
            app.run_cycles(1);
            app.update();
            app.update();
        }
        assert_eq!(drawn(&app), 5);
        let shown = app.world().resource::<ShownImages>();
        let (cycle, image) = shown.image(BLUE, CameraName::BOTTOM).unwrap();
        assert_eq!((cycle, image.width, image.height), (10, 320, 240));
        assert!(shown.image(BLUE, CameraName::TOP).is_none());
        app.world_mut().resource_mut::<Watched>().cameras.clear();
        app.run_cycles(1);
        app.update();
        assert_eq!(drawn(&app), 5);
    }

    #[test]
    fn an_image_is_of_the_instant_at_which_the_robot_sensed() {
        let mut app = app();
        app.world_mut().resource_mut::<Watched>().cameras.insert((BLUE, CameraName::BOTTOM));
        app.run_cycles(1);
        app.update();
        // The ball was 0.9 m ahead when the image was taken, even if it has rolled on since.
        let camera =
            CameraSettings::default().view(CameraName::BOTTOM, &Body::default(), HeadAngles::default()).unwrap();
        let pixel = camera.pixel_in_image(Vec3::new(0.9, 0.0, 0.03)).unwrap();
        let (_, image) = app.world().resource::<ShownImages>().image(BLUE, CameraName::BOTTOM).unwrap();
        let [red, green, blue] = image.colour(pixel.x as u32, pixel.y as u32).unwrap();
        assert!(red > 150 && red > green + 50 && green > blue, "{red} {green} {blue}");
    }

    #[test]
    fn detections_of_late_vision_lie_on_the_objects_of_their_image() {
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, NaoisisPlugins, EventLogPlugin, DrivePlugin, CameraImagesPlugin))
            .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_micros(33_334)))
            .init_resource::<DisplaySettings>()
            .init_resource::<Selection>();
        // The ball rolls past, by several times its diameter within the delay.
        let scenario = Scenario::from_json(
            r#"{ "rules": "free", "ball": { "position_m": [0.7, -0.6], "velocity_mps": [0.0, 2.0] },
                 "robots": [{ "number": 1, "pose": [0.0, 0.0, 0.0], "latency": { "vision_s": 0.1 } }] }"#,
        );
        app.start_match(&scenario.unwrap()).unwrap();
        app.world_mut().resource_mut::<Watched>().cameras.insert((BLUE, CameraName::BOTTOM));
        let mut seen = 0;
        for _ in 0..20 {
            app.update();
            let world = app.world();
            let robot = world.resource::<Roster>().get(BLUE).unwrap();
            let ball = world.get::<Percepts>(robot).unwrap().ball;
            let Some(ball) = ball.filter(|ball| ball.camera == CameraName::BOTTOM) else { continue };
            let (cycle, image) = world.resource::<ShownImages>().image(BLUE, CameraName::BOTTOM).unwrap();
            assert_eq!(cycle, app.cycle() - 3);
            let [red, green, blue] = image.colour(ball.pixel.x as u32, ball.pixel.y as u32).unwrap();
            assert!(red > 150 && red > green + 50 && green > blue, "{cycle}: {red} {green} {blue}");
            seen += 1;
        }
        assert!(seen > 3, "{seen}");
    }
}
