//! A simple estimator of the [`Belief`]: the pose is predicted from odometry and corrected by landmarks, ball and robots are tracked from
//! sightings, and team-mates report themselves and the ball.
//!
//! The estimator reads only the robot's sensors and messages, and is registered through the same [barrier] as behaviours.

use bevy::ecs::query::QueryData;
use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::ball::BallEstimate;
use super::camera_error::{CameraError, CameraMotion};
use super::landmarks::{Landmarks, PitchObservation};
use super::localiser::Localiser;
use super::moments::{Moment, Moments, as_seen_now};
use super::robots::{RobotTrack, SonarModel, advance_tracks, hear_robot, see_robot};
use super::sighting::Sighting;
use super::wrong_end::WrongEnd;
use super::{Belief, SimpleBelief};
use crate::sensing::camera::CameraSettings;
use crate::sensing::camera::field_of_view::FieldOfView;
use crate::sensing::odometry::{Odometry, OdometrySettings};
use crate::sensing::sonar::{SonarReading, SonarSettings};
use crate::sensing::vision::{GazeDecay, GazeNoise, Percepts, VisionSettings};
use naoisis_core::behaviour::{DecideSystems, barrier, behaviour};
use naoisis_core::communication::{Inbox, ReceivedMessage};
use naoisis_core::cycle::{Cycle, CycleClock};
use naoisis_core::game::{GameState, PenaltyReason, ReturnPlace, Rules};
use naoisis_core::geometry::{Pose, unit};
use naoisis_core::knowledge::Knowledge;
use naoisis_core::pitch::{End, Pitch};
use naoisis_core::referee::shoot_out::places_for_shot;
use naoisis_core::referee::{GameStatus, formation, start_pose};
use naoisis_core::robot::head::HeadAngles;
use naoisis_core::robot::motion_settings::MotionSettings;
use naoisis_core::team::RobotId;

mod publish;

/// Updates the [`Belief`] of robots with [`SimpleBelief`] in [`DecideSystems::Believe`].
///
/// Add the plugins of the sensors first.
pub struct SimpleBeliefPlugin;

impl Plugin for SimpleBeliefPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<Belief>().register_type::<SimpleBelief>().register_type::<SimpleBeliefMemory>();
        app.register_required_components::<SimpleBelief, SimpleBeliefMemory>();
        let mut estimator = behaviour(estimate);
        match barrier::inspect::<SimpleBelief>("simple belief", &mut estimator, app.world_mut()) {
            Ok(()) => {
                app.add_systems(Cycle, estimator.into_configs().in_set(DecideSystems::Believe));
            }
            Err(error) => error!("a plugin is missing: {error}"),
        }
    }
}

/// The memory of the simple estimator from cycle to cycle.
#[derive(Component, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Belief)]
struct SimpleBeliefMemory {
    /// Whether the memory has been initialised.
    begun: bool,
    /// The robot's own pose.
    own: Localiser,
    /// The odometry of the last cycle.
    odometry: Pose,
    /// The recent moments, to which delayed percepts belong.
    moments: Moments,
    /// The number of restarts at which the robots had been placed.
    restarts: u32,
    /// The number of times that the robot had been placed by hand.
    hand_placements: u32,
    /// Whether the robot is off the pitch for a penalty.
    removed: bool,
    /// The ball, robot frame, if its position is known.
    ball: Option<BallEstimate>,
    /// Other robots, robot frame.
    tracks: Vec<RobotTrack>,
    /// The last message of each team-mate, in the order of their ids.
    heard: Vec<Heard>,
    /// The last sonar readings.
    echoes: SonarReading,
    /// The evidence that the robot is at the other end of the pitch.
    wrong_end: WrongEnd,
}

/// The last message of a team-mate.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
struct Heard {
    from: RobotId,
    /// The team-mate's position, m, team frame.
    position: Option<Vec2>,
    /// The position at which the team-mate sees the ball, m, team frame.
    ball: Option<Vec2>,
    /// The mean velocity of the ball since the previous message, m/s, team frame.
    ball_moved_mps: Option<Vec2>,
    age_s: f32,
}

/// The greatest age of a ball that is in view, s.
const SEEN_NOW_S: f32 = 0.3;

/// Corrects a sighting by the estimated error of the cameras, and adds the uncertainty of that error.
fn corrected(seen: Sighting, camera: Option<&(CameraError, CameraMotion)>) -> Sighting {
    camera.map_or(seen, |(error, motion)| error.corrected(&seen, motion))
}

/// The components that the estimator reads and writes.
#[derive(QueryData)]
#[query_data(mutable)]
struct BelievingRobot {
    id: &'static RobotId,
    settings: &'static SimpleBelief,
    status: &'static GameStatus,
    odometry: &'static Odometry,
    head: &'static HeadAngles,
    camera: &'static CameraSettings,
    vision: &'static VisionSettings,
    steps: (&'static MotionSettings, &'static OdometrySettings),
    percepts: &'static Percepts,
    sonar: &'static SonarReading,
    sonar_settings: &'static SonarSettings,
    inbox: &'static Inbox,
    memory: &'static mut SimpleBeliefMemory,
    belief: &'static mut Belief,
}

fn estimate(
    mut landmarks: Local<Option<Landmarks>>,
    (mut late, mut decay): (Local<Percepts>, Local<GazeDecay>),
    clock: Res<CycleClock>,
    pitch: Res<Pitch>,
    rules: Res<Rules>,
    mut robots: Query<BelievingRobot>,
) {
    if pitch.is_changed() {
        *landmarks = None;
    }
    let landmarks = landmarks.get_or_insert_with(|| Landmarks::of(&pitch));
    let period = clock.period();
    for robot in &mut robots {
        let BelievingRobotItem { status, odometry, camera, percepts, mut memory, mut belief, .. } = robot;
        let view = FieldOfView::of(camera);
        let settings = &robot.settings.with_known(robot.steps, &view, robot.vision.noise.gaze);
        let id = *robot.id;
        let number = id.role_number(status.goalkeeper);
        let kicking_off = id.team == status.kick_off_team && !status.drop_ball;
        let placed = || start_pose(&pitch, &rules, number, End::NegativeX, kicking_off);
        let by_hand = || formation(&pitch, rules.team_size, number, End::NegativeX, false);
        let shot = status.shoot_out.map(|team| places_for_shot(&pitch, rules.shoot_out_procedure, team == id.team));
        let start = || Localiser::placed(settings.localisation, id, belief.pose);
        memory.begin_cycle(id, start, odometry.0, status, landmarks, (rules.return_place, shot), placed, by_hand);
        let ground = robot.steps.0.gait.map_or(1.0, |gait| gait.slip.scale);
        let is_walking = odometry.0 != memory.odometry;
        memory.pass_time(odometry.0, ground, settings, period);
        let now = Moment { time_s: clock.start_time_s(), odometry: odometry.0, head_yaw: robot.head.yaw, is_walking };
        let then = memory.moments.at(percepts.time_s, now);
        let noise = robot.vision.noise.gaze;
        let motion = (noise != GazeNoise::default()).then(|| CameraMotion {
            noise,
            is_walking: then.is_walking,
            head_forward: unit(then.head_yaw),
            lens_height_m: view.lens_height_m,
            decay: decay.after(period, &noise),
        });
        let ball = memory.ball.as_ref().map(|ball| ball.velocity);
        let percepts = as_seen_now(percepts, (then, now), ball, &mut late);
        memory.listen(&robot.inbox.0);
        if !status.penalised {
            let image = Vec2::new(camera.width as f32, camera.height as f32);
            let observation = PitchObservation {
                percepts,
                landmarks,
                own_end: status.own_end,
                image,
                turn: clock.cycle as usize,
                model: &settings.landmarks,
                camera: motion,
            };
            memory.own.correct(id, &observation);
            let camera = memory.own.camera().copied().zip(motion);
            let late_s = (now.time_s - then.time_s) as f32;
            memory.watch_ball(percepts, (*robot.head, &view), camera.as_ref(), settings, period, late_s);
            if landmarks.are_symmetric() {
                memory.compare_ends(settings, period);
            }
            memory.watch_robots(percepts, camera.as_ref(), settings);
            memory.hear_robots((robot.sonar, robot.sonar_settings), &pitch, &settings.sonar);
        }
        memory.keep_finite(id, belief.pose);
        memory.publish(&mut belief, id.team, motion.as_ref(), settings);
    }
}

impl SimpleBeliefMemory {
    /// Handles placement for a kick-off or by hand, penalties, and returns from penalties.
    fn begin_cycle(
        &mut self,
        id: RobotId,
        start: impl FnOnce() -> Localiser,
        odometry: Pose,
        status: &GameStatus,
        landmarks: &Landmarks,
        (return_place, shot): (ReturnPlace, Option<(Pose, Vec2)>),
        placed: impl FnOnce() -> Pose,
        by_hand: impl FnOnce() -> Pose,
    ) {
        if !self.begun {
            self.begun = true;
            self.odometry = odometry;
            self.restarts = status.restarts;
            self.hand_placements = status.hand_placements;
            self.own = start();
        }
        // A robot whose penalty ends at half time is put to its place, and does not return from beside the pitch.
        let mut is_placed = false;
        if status.restarts != self.restarts {
            self.restarts = status.restarts;
            if !status.penalised {
                is_placed = true;
                self.place_for_kick_off(placed());
            }
        }
        if status.hand_placements != self.hand_placements {
            self.hand_placements = status.hand_placements;
            match shot {
                Some((pose, ball)) => self.place(pose, ball),
                None => self.place_for_kick_off(by_hand()),
            }
        }
        let comes_back = self.removed && !status.penalised;
        if comes_back && !is_placed && shot.is_none() && status.state != GameState::Finished {
            let ball = self.heard.iter().find_map(|heard| heard.ball);
            match return_place {
                ReturnPlace::HalfwayLine => self.own.come_back_at_halfway_line(landmarks, ball),
                ReturnPlace::PenaltyMark => self.own.come_back_where_it_waited(id, landmarks),
            }
            self.tracks.clear();
            self.ball = None;
        }
        self.removed = status.penalised && (self.removed || !status.penalty.is_some_and(PenaltyReason::is_in_place));
    }

    fn place_for_kick_off(&mut self, pose: Pose) {
        self.place(pose, Vec2::ZERO);
    }

    /// Sets the pose of the robot, and places the ball at `mark` until it is seen.
    fn place(&mut self, pose: Pose, mark: Vec2) {
        self.own.place(pose);
        self.tracks.clear();
        self.ball = Some(BallEstimate::at_rest(pose.inverse_transform_point(mark), 0.1));
    }

    /// Predicts all estimates for a cycle. `ground` is the mean share of a step's length that remains after slip.
    fn pass_time(&mut self, odometry: Pose, ground: f32, settings: &SimpleBelief, period: f32) {
        let moved = odometry != self.odometry;
        let mut step = if moved { self.odometry.relative(odometry) } else { Pose::default() };
        // Slip shortens the steps.
        step.position *= ground;
        self.odometry = odometry;
        self.own.move_by(step, period, &settings.step_error);
        self.ball = self.ball.map(|ball| ball.advanced(step, period, &settings.ball, &settings.step_error));
        advance_tracks(&mut self.tracks, step, period, &settings.robots);
        self.heard.retain_mut(|heard| {
            heard.age_s += period;
            heard.age_s < settings.message_forget_s
        });
    }

    fn listen(&mut self, messages: &[ReceivedMessage]) {
        for message in messages {
            let mut said = Heard {
                from: message.from,
                position: message.say.pose.map(|pose| pose.position),
                ball: message.say.ball_m,
                ball_moved_mps: None,
                age_s: 0.0,
            };
            match self.heard.binary_search_by_key(&message.from, |heard| heard.from) {
                Ok(index) => {
                    let before = &mut self.heard[index];
                    if let (Some(now), Some(then)) = (said.ball, before.ball)
                        && before.age_s > 0.0
                    {
                        said.ball_moved_mps = Some((now - then) / before.age_s);
                    }
                    *before = said;
                }
                Err(index) => self.heard.insert(index, said),
            }
        }
    }

    fn watch_ball(
        &mut self,
        percepts: &Percepts,
        (head, view): (HeadAngles, &FieldOfView),
        camera: Option<&(CameraError, CameraMotion)>,
        settings: &SimpleBelief,
        period: f32,
        late_s: f32,
    ) {
        if let Some(seen) = &percepts.ball {
            let sighting = corrected(
                Sighting::new(seen.position_m, settings.ball_angle_sd).from_height(settings.landmarks.lens_height_m),
                camera,
            );
            self.ball = Some(match &self.ball {
                Some(ball) => ball.seen(&sighting, &settings.ball, late_s),
                None => BallEstimate::first_seen(&sighting, &settings.ball),
            });
        } else if let Some(ball) = &mut self.ball {
            if view.contains(ball.position, head.yaw, head.pitch) {
                ball.missing_s += period;
            }
            if ball.age_s > settings.ball_forget_s || ball.missing_s > settings.ball_missing_s {
                self.ball = None;
            }
        }
    }

    /// Changes to the other end of the pitch if team-mates report the ball where this robot would see it from there.
    fn compare_ends(&mut self, settings: &SimpleBelief, period: f32) {
        let Some(ball) = self.ball.filter(|ball| ball.age_s < SEEN_NOW_S) else { return };
        let place = self.own.estimate().pose.transform_point(ball.position);
        let told = self.heard.iter().filter(|heard| heard.age_s < settings.ball_trust_s).filter_map(|heard| heard.ball);
        if self.wrong_end.weigh(place, told, period) {
            self.own.change_ends();
        }
    }

    fn watch_robots(
        &mut self,
        percepts: &Percepts,
        camera: Option<&(CameraError, CameraMotion)>,
        settings: &SimpleBelief,
    ) {
        for seen in &percepts.robots {
            let sighting = corrected(
                Sighting::new(seen.position_m, settings.robot_angle_sd).from_height(settings.landmarks.lens_height_m),
                camera,
            );
            see_robot(&mut self.tracks, seen.team, &sighting, &settings.robots);
        }
    }

    /// Corrects the distances of tracked robots by sonar echoes, except echoes of goal posts.
    fn hear_robots(&mut self, sonar: (&SonarReading, &SonarSettings), pitch: &Pitch, model: &SonarModel) {
        if self.tracks.is_empty() {
            return;
        }
        let (reading, settings) = sonar;
        // Between two pings the reading does not change.
        let is_old = settings.rate_hz.is_some() && *reading == self.echoes;
        self.echoes = *reading;
        if is_old {
            return;
        }
        let pose = self.own.estimate().pose;
        let (x, y) = (pitch.goal_post_x(), pitch.goal.width_m / 2.0);
        for (distance, heading) in [(reading.left, settings.heading), (reading.right, -settings.heading)] {
            let Some(distance) = distance else { continue };
            let echo = pose.transform_point(unit(heading) * distance);
            let posts = [Vec2::new(x, y), Vec2::new(x, -y), Vec2::new(-x, y), Vec2::new(-x, -y)];
            if posts.into_iter().all(|post| post.distance(echo) > model.post_range_m) {
                hear_robot(&mut self.tracks, distance, heading, settings.half_angle, model);
            }
        }
    }

    /// Removes estimates that are not finite.
    fn keep_finite(&mut self, robot: RobotId, last_pose: Pose) {
        self.own.keep_finite(robot, last_pose);
        self.ball = self.ball.filter(BallEstimate::is_finite);
        self.tracks.retain(|track| track.position.is_finite() && track.covariance.is_finite());
    }
}
